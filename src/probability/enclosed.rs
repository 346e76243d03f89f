//! Chances of a chain in one or two independent dimensions, by quadrature with a proved bound.
//!
//! The chance V(s) of success within n more rounds from state s satisfies V_0 = 0 and
//! V_n(s) = D(s) + ∫ k(s,x) V_(n-1)(x) dx, summed over the ways of a round, with a kernel that is a product over the axes
//! of a normal density times the chance of the guard. Integrals become sums over points, added up from the start on: with the
//! mass of each point of a round, of which D(s) is won there and the rest goes on. Four errors are bounded, none by experience:
//! * *discretisation*: [`super::grid`] says how;
//! * *truncation*: whatever the sums leave out (states outside the window of their round, densities far out) is what
//!   the chances of going on exceed the masses by that are found in the next round; it may have led anywhere;
//! * *rounding*: each kernel value is known to a stated error, a sum of n terms to n units in the last place;
//! * *what is next to impossible*: moves that no state makes likely are left out, and tests that no state makes fail where
//!   the others hold ([`super::unlikely`]); their chances widen the answer;
//! * all of them add up from round to round, as the kernel's total mass is at most 1.

use num_traits::ToPrimitive;

use super::axes::{AXES, settled};
use super::chain::Chain;
use super::field::{Field, Outcome, Room};
use super::foreseen::foreseen;
use super::grid::{Grid, Smooth};
use super::joint::joint;
use super::kernel::{BAND, Fast, Guard, Ranges, UNIT, contains};
use super::lattice::lattice;
use super::linear::closer;
use super::operator::{Cut, Key, Operator};
use super::piecewise::piecewise;
use super::plan::{Entry, MOST_ROUNDS, Plan, Way, duration, plan};
use super::recut::later_rounds;
use super::sharp::blunted;
use super::spots::Spots;
use super::stretches::one_each;
use super::unlikely::without;
use super::ways::{FastEntry, FastPatch, FastWay, UNLIKELY, units};
use super::window::windows;
use super::{Enclosed, Question};
use crate::interval::Interval;

/// What slices should err by, in relation to what one sum should.
const SLICED: f64 = 0.05;
/// Chances that are not worth taking out, in the same relation.
const VAIN: f64 = 1e-7;
/// Chances that are left out and counted, in relation to what one sum should err by: of a way that a state takes, and at the
/// ends of an axis.
const NEGLIGIBLE: f64 = 1e-3;
const TRIMMED: f64 = 0.05;
/// Values that are held, and multiplications.
const MOST_VALUES: usize = 25_000_000;
const MOST_WORK: f64 = 3e11;

/// A chance, surely between these, as narrow as is wanted if machine numbers allow it.
///
/// # Errors
/// Where the states or the kernel grow too large, or a way has no noise.
pub fn enclosed(whole: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
    let found = by_quadrature(whole, question, wanted).or_else(|reason| lattice(whole, question).map_err(|_| reason));
    let found = found.or_else(|reason| {
        piecewise(whole, question, wanted).map_err(|other| format!("{reason}; with noise of any kind: {other}"))
    });
    closer(found, whole, question)
}

fn by_quadrature(whole: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
    if let Some(cut) = one_each(whole) {
        return by_quadrature(&cut, question, wanted);
    }
    if whole.is_curved() {
        return apart(whole, question, wanted);
    }
    let (chain, lost) = without(whole);
    let found = apart(&chain, question, wanted).or_else(|reason| {
        let both = joint(&chain, question, wanted).or_else(|other| {
            let rest = rounds(&chain, question).and_then(|rounds| foreseen(&chain, rounds)).ok_or(other.clone())?;
            apart(&rest, question, wanted).or_else(|_| joint(&rest, question, wanted)).map_err(|_| other)
        });
        let both = both.or_else(|other| {
            let solve =
                |(cut, question)| apart(&cut, &question, wanted).or_else(|_| joint(&cut, &question, wanted)).ok();
            later_rounds(&chain, question).find_map(solve).ok_or(other)
        });
        both.map_err(|other| format!("{reason}; over two dimensions that lean on each other: {other}"))
    })?;
    if lost == Interval::exactly(0.0) {
        return Ok(found);
    }
    // Where all is decided before anything is drawn, nothing is left out.
    if found.interval.low == found.interval.high
        && let Ok(plan) = plan(whole, question)
        && (plan.entries.is_empty() || plan.rounds == 0)
    {
        return Ok(Enclosed::within(plan.decided));
    }
    // What is left out may have led anywhere, in each of the rounds and before them; so may what is not tested.
    let lost = lost.times(Interval::exactly(MOST_ROUNDS as f64 + 2.0)).high;
    Ok(Enclosed::within(found.plus(Interval::between(-lost, lost)).probability()))
}

/// How many rounds there are, where all last equally long.
fn rounds(chain: &Chain, question: &Question) -> Option<u64> {
    let open: Vec<usize> = (0..chain.phases.len()).filter(|phase| settled(chain, question, *phase).is_none()).collect();
    let duration = duration(chain, &open).ok().flatten()?;
    (&question.time / duration).floor().to_integer().to_u64().filter(|rounds| *rounds <= MOST_ROUNDS)
}

/// Over dimensions that are independent.
fn apart(chain: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
    let plan = plan(chain, question)?;
    let own = plan.phases.len();
    let plan = entered_apart(blunted(plan));
    if plan.entries.is_empty() || plan.rounds == 0 {
        return Ok(Enclosed::within(plan.decided));
    }
    Ok(Enclosed::within(Machine::new(&plan, own, wanted)?.run(&plan)?))
}

/// Entries to be followed on a grid of their own.
const MOST_APART: usize = 12;

/// Where noise sets in, there may be less of it than in the rounds: a phase is entered by a copy of its own, which has
/// its own grid.
fn entered_apart(mut plan: Plan) -> Plan {
    if plan.entries.len() > MOST_APART {
        return plan;
    }
    for entry in &mut plan.entries {
        let phase = entry.way.next;
        entry.way.next = plan.phases.len();
        plan.phases.push(plan.phases[phase].clone());
        plan.states.push(plan.states[phase]);
    }
    plan
}

/// A range of points on each axis.
type Active = [(usize, usize); AXES];

struct Machine {
    phases: Vec<Vec<FastWay>>,
    entries: Vec<FastEntry>,
    /// By phase and axis.
    grids: Vec<[Grid; AXES]>,
    /// The points of each grid that are looked at in each round.
    active: Vec<Vec<Option<Active>>>,
    operators: Vec<Operator>,
    /// The operators of each onward patch, by phase, way and patch.
    onward: Vec<Vec<Vec<[usize; AXES]>>>,
    /// What one sum should err by at most.
    share: f64,
    /// Standard deviations beyond which densities are left out.
    band: f64,
    /// What one round errs by at most.
    step: f64,
    /// The number of phases that are not entered apart.
    own: usize,
    /// Which axes the state of a phase has.
    states: Vec<[bool; AXES]>,
    /// The number of phases that are no slices of others.
    whole: usize,
    /// What the slices of the plane err by.
    spotted: f64,
}

impl Machine {
    fn new(plan: &Plan, own: usize, wanted: f64) -> Result<Machine, String> {
        let units = units(plan)?;
        let share = wanted / (plan.rounds as f64 + 2.0) / (plan.phases.len() * AXES) as f64;
        let fast = |way: &Way| FastWay::of(way, &units, SLICED * share);
        let phases = plan.phases.iter().map(|ways| ways.iter().map(fast).collect::<Result<Vec<FastWay>, _>>());
        let phases = phases.collect::<Result<Vec<_>, _>>()?;
        let entry = |one: &Entry| Ok(FastEntry { time: one.time, way: fast(&one.way)?.near(), chance: one.chance });
        let entries = plan.entries.iter().map(entry).collect::<Result<Vec<FastEntry>, String>>()?;
        let all = || phases.iter().flatten().chain(entries.iter().map(|entry| &entry.way));
        if !all().flat_map(|way| &way.motions).all(Fast::is_sound) {
            return Err("a decider of a round is certain once the next state is known, or too large".to_string());
        }
        for way in all().filter(|way| !way.onward.is_empty()) {
            let still = |axis: usize| plan.states[way.next][axis] && way.motions[axis].sd <= 0.0;
            if (0..AXES).any(still) {
                return Err("a round adds no noise".to_string());
            }
        }
        let wide = (2.0 * (8.0 / share).ln()).sqrt().min(9.0);
        let windows = windows(&phases, &entries, plan.rounds, wide);
        let mut machine = Machine {
            phases,
            entries,
            grids: Vec::new(),
            active: Vec::new(),
            operators: Vec::new(),
            onward: Vec::new(),
            share: share / 4.0,
            band: wide,
            step: 0.0,
            own,
            states: plan.states.clone(),
            whole: plan.phases.len(),
            spotted: 0.0,
        };
        for (phase, windows) in windows.iter().enumerate() {
            let mut grids = [Grid::single(), Grid::single()];
            for (axis, grid) in grids.iter_mut().enumerate().filter(|(axis, _)| plan.states[phase][*axis]) {
                let hull =
                    windows.iter().flatten().map(|window| window[axis]).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
                if let Some(hull) = hull {
                    *grid = Grid::new(hull, &machine.smooth(phase, axis), machine.share)?;
                }
            }
            let place = |axis: usize, (low, high): (f64, f64)| {
                let nodes = &grids[axis].nodes;
                if nodes.len() == 1 {
                    return (0, 1);
                }
                (nodes.partition_point(|node| *node < low), nodes.partition_point(|node| *node <= high))
            };
            let active = windows.iter().map(|window| window.map(|window| [place(0, window[0]), place(1, window[1])]));
            machine.active.push(active.collect());
            machine.grids.push(grids);
        }
        machine.cut_spots(plan.rounds)?;
        machine.connect(plan)?;
        machine.step = machine.bound();
        Ok(machine)
    }

    /// Makes phases of the slices of the plane into which ways lead.
    fn cut_spots(&mut self, rounds: u64) -> Result<(), String> {
        let smooth = |phase: usize| [self.smooth(phase, 0), self.smooth(phase, 1)];
        let spots = Spots::of(&self.phases, &self.entries, smooth, SLICED * self.share)?;
        spots.place(&mut self.phases, &mut self.entries);
        self.spotted = spots.error;
        for slice in spots.slices {
            let points = slice.grids.each_ref().map(|grid| (0, grid.nodes.len()));
            self.active.push(vec![Some(points); rounds as usize + 1]);
            self.grids.push(slice.grids);
            self.states.push([true; AXES]);
        }
        Ok(())
    }

    /// What is known of the integrals over the states of a phase.
    fn smooth(&self, phase: usize, axis: usize) -> Smooth {
        let all = self.phases.iter().flatten().chain(self.entries.iter().map(|entry| &entry.way));
        let into: Vec<&FastWay> = all.filter(|way| !way.onward.is_empty() && way.next == phase).collect();
        let lands = |way: &FastWay| !way.onward.is_empty() && self.states[way.next][axis];
        let out = &self.phases[phase];
        let kernel = into.iter().map(|way| way.motions[axis].growth()).fold(0.0, f64::max);
        let value = out.iter().map(|way| way.motions[axis].growth_before(lands(way))).fold(0.0, f64::max);
        // What is taken out of another part counts as well: so much at most ([`super::slicer`]).
        let once = |way: &FastWay| if way.is_sliced() { 5.0 * way.weight } else { way.weight };
        let weight = |ways: &mut dyn Iterator<Item = &FastWay>| ways.map(once).sum::<f64>() + 1.0;
        let sd = into.iter().map(|way| way.motions[axis].sd);
        let mut cuts = Vec::new();
        let finite = |ranges: &Ranges| {
            ranges.iter().flat_map(|(low, high)| [*low, *high]).filter(|end| end.is_finite()).collect::<Vec<f64>>()
        };
        for way in into.iter().filter(|way| way.motions[axis].guard == Guard::Next) {
            way.onward.iter().for_each(|patch| cuts.extend(finite(&patch.axes[axis][1])));
        }
        for way in out {
            way.patches().for_each(|patch| cuts.extend(finite(&patch.axes[axis][0])));
        }
        Smooth {
            growth: kernel + value,
            size: weight(&mut into.iter().copied()) * weight(&mut out.iter()),
            sd: (sd.clone().fold(f64::INFINITY, f64::min), sd.fold(0.0, f64::max)),
            cuts,
        }
    }

    fn key(&self, way: &FastWay, patch: &FastPatch, axis: usize, from: usize) -> Key {
        Key {
            motion: way.motions[axis].clone(),
            ranges: patch.axes[axis].clone(),
            lands: self.states[way.next][axis],
            from,
            to: way.next * AXES + axis,
        }
    }

    /// Makes the operators, each once.
    fn connect(&mut self, plan: &Plan) -> Result<(), String> {
        let mut onward = Vec::new();
        for phase in 0..self.phases.len() {
            let mut ways = Vec::new();
            for way in 0..self.phases[phase].len() {
                let count = self.phases[phase][way].onward.len();
                let mut patches = Vec::new();
                let mut kept = Vec::new();
                for patch in 0..count {
                    let here = (phase, way, patch);
                    let both = [self.operator(here, 0)?, self.operator(here, 1)?];
                    let one = &self.phases[phase][way];
                    let most = both.map(|place| self.operators[place].most);
                    let most = one.weight.abs() * one.onward[patch].weight * most[0] * most[1];
                    // Next to nothing is taken out of another part by it.
                    let vain = most < 0.0 && -most < VAIN * self.share;
                    self.spotted -= if vain { most } else { 0.0 };
                    patches.extend((!vain).then_some(both));
                    kept.push(!vain);
                }
                let mut kept = kept.into_iter();
                self.phases[phase][way].onward.retain(|_| kept.next().unwrap_or(true));
                ways.push(patches);
            }
            onward.push(ways);
            if self.operators.iter().map(Operator::size).sum::<usize>() > MOST_VALUES {
                return Err("the kernel is too large".to_string());
            }
        }
        self.onward = onward;
        let work: f64 = self.operators.iter().map(|one| one.size() as f64).sum::<f64>()
            * self.grids.iter().map(|grids| grids[0].nodes.len().min(grids[1].nodes.len())).max().unwrap_or(1) as f64
            * plan.rounds as f64;
        if work > MOST_WORK { Err("there is too much to compute".to_string()) } else { Ok(()) }
    }

    /// What of an operator into a phase is left out, and counted; of a slice it would not be missed.
    fn cut(&self, next: usize) -> Cut {
        match next < self.whole {
            true => Cut { band: self.band, least: NEGLIGIBLE * self.share },
            false => Cut { band: BAND, least: 0.0 },
        }
    }

    fn operator(&mut self, (phase, way, patch): (usize, usize, usize), axis: usize) -> Result<usize, String> {
        let one = &self.phases[phase][way];
        let key = self.key(one, &one.onward[patch], axis, phase * AXES + axis);
        let grid = |number: usize| &self.grids[number / AXES][number % AXES];
        let same = |other: &Operator| {
            let other = &other.key;
            let points = grid(other.from) == grid(key.from) && grid(other.to) == grid(key.to);
            points && Key { from: key.from, to: key.to, ..other.clone() } == key
        };
        let slice = [phase, one.next].iter().any(|phase| *phase >= self.whole);
        if let Some(found) = (!slice).then(|| self.operators.iter().position(same)).flatten() {
            return Ok(found);
        }
        let points = (&grid(key.from).nodes, grid(key.to));
        self.operators.push(Operator::new(key.clone(), points.0, points.1, self.cut(one.next), MOST_VALUES)?);
        Ok(self.operators.len() - 1)
    }

    /// What one round errs by at most: quadrature of the chance and of what is left out, and rounding.
    fn bound(&self) -> f64 {
        let quadrature: f64 = self.grids[..self.own].iter().flatten().map(|grid| grid.error).sum();
        let reach =
            self.grids.iter().flatten().flat_map(|grid| &grid.nodes).fold(0.0f64, |most, node| most.max(node.abs()));
        let error = |way: &FastWay, patch: &FastPatch| {
            let both = [0, 1].map(|axis: usize| (&way.motions[axis], &patch.axes[axis]));
            let [one, other] = both.map(|(motion, ranges)| (motion.chance_error(ranges, reach), motion.most(ranges)));
            way.weight * patch.weight.abs() * (one.0 * other.1 + other.0 * one.1)
        };
        let each = |ways: &mut dyn Iterator<Item = &FastWay>| {
            let (mut relative, mut absolute, mut patches) = (0.0f64, 0.0, 0.0);
            for way in ways {
                let sum = |patches: &[FastPatch]| patches.iter().map(|patch| error(way, patch)).sum::<f64>();
                // Either all of a round counts, or what counts at the last moment alone.
                absolute += (sum(&way.success) + sum(&way.onward)).max(sum(&way.last)) + way.weight * way.error;
                relative = relative.max(way.motions.iter().map(|motion| motion.rounding(reach)).sum());
                patches += way.patches().count() as f64;
            }
            (relative, absolute, patches)
        };
        let groups = self.phases.iter().map(|ways| each(&mut ways.iter()));
        let entries = self.entries.iter().map(|entry| each(&mut std::iter::once(&entry.way)));
        let worst =
            |one: (f64, f64, f64), other: (f64, f64, f64)| (one.0.max(other.0), one.1.max(other.1), one.2.max(other.2));
        let (relative, absolute, patches) = groups.chain(entries).fold((0.0, 0.0, 0.0), worst);
        let longest = self.operators.iter().map(|one| one.longest).max().unwrap_or(0);
        let most = |axis: usize| self.grids.iter().map(|grids| grids[axis].nodes.len()).max().unwrap_or(0) as f64;
        let into = |phase: usize| {
            let ways = self.phases.iter().flatten().filter(|way| way.next == phase);
            let entries = self.entries.iter().map(|entry| &entry.way).filter(|way| way.next == phase);
            ways.chain(entries).map(|way| way.onward.len()).sum::<usize>()
        };
        let into = (0..self.phases.len()).map(into).max().unwrap_or(0);
        // Sums along both axes, and of all that leads into a phase; masses and chances are summed by the eight.
        let terms = (2 * longest + into) as f64 + most(0) / 8.0 + most(1) + 8.0 * patches + 80.0;
        let sliced = self.spotted > 0.0 || self.phases.iter().flatten().any(FastWay::is_sliced);
        let taken = if sliced { 5.0 } else { 1.0 };
        2.1 * (quadrature + self.spotted) + 2.0 * taken * relative + 2.0 * absolute + 2.0 * taken * terms * UNIT
    }

    fn run(&self, plan: &Plan) -> Result<Interval, String> {
        let fields = || vec![Field::default(); self.phases.len()];
        let (mut now, mut next, mut room) = (fields(), fields(), Room::default());
        let outcomes = self.outcomes();
        // What is taken out of a round and not found there may not have been there.
        let (mut value, mut lost, mut over, mut wide) = (0.0, 0.0, 0.0, 0.0);
        let mut entries = self.entries.iter().peekable();
        self.clear(&mut next, 0);
        // What goes on into a round; what of it is not found there is lost.
        let mut onward = 0.0;
        for time in 0..plan.rounds {
            std::mem::swap(&mut now, &mut next);
            while let Some(entry) = entries.next_if(|entry| entry.time == time) {
                let chance = f64::midpoint(entry.chance.low, entry.chance.high);
                let (entered, kept) = self.enter(&entry.way, chance, &mut now, &mut room)?;
                wide += entry.chance.width() + self.error(entry, entered, plan.rounds - time);
                if entry.way.next < self.whole {
                    over += kept;
                    onward += entered;
                }
            }
            now[..self.whole].iter_mut().for_each(|field| field.trim(TRIMMED * self.share));
            lost += onward - now[..self.whole].iter().map(Field::mass).sum::<f64>();
            onward = 0.0;
            let last = time + 1 == plan.rounds;
            for (field, outcomes) in now.iter().zip(&outcomes).filter(|(field, _)| !field.is_empty()) {
                let won = |one: &Outcome| one.weight * field.weighted(&one.chances[0], &one.chances[1]);
                value += outcomes[usize::from(last)].iter().map(won).sum::<f64>();
            }
            if last {
                break;
            }
            self.clear(&mut next, time + 1);
            for (phase, field) in now.iter().enumerate().filter(|(_, field)| !field.is_empty()) {
                for (way, patches) in self.phases[phase].iter().zip(&self.onward[phase]) {
                    for (patch, operators) in way.onward.iter().zip(patches) {
                        let [one, other] = operators.map(|place| &self.operators[place]);
                        let weight = way.weight * patch.weight;
                        let (counts, next) = (way.next < self.whole, &mut next[way.next]);
                        let going = if counts { weight * field.weighted(&one.chances, &other.chances) } else { 0.0 };
                        onward += going;
                        if weight < 0.0 {
                            let taken = field.take(-weight, one, other, next, &mut room);
                            over -= if counts { going + taken } else { 0.0 };
                        } else if !counts || weight * one.most * other.most > NEGLIGIBLE * self.share {
                            field.go(weight, one, other, next, &mut room);
                        }
                    }
                }
            }
        }
        let (wide, over) = (wide + over.max(0.0), over.max(0.0));
        let found = Interval::between((value - wide).max(0.0), value + (lost + over).max(0.0) + wide);
        if !found.high.is_finite() {
            return Err("the bounds are too wide".to_string());
        }
        Ok(plan.decided.plus(found).probability())
    }

    /// Nothing yet at the points that are looked at in a round.
    fn clear(&self, fields: &mut [Field], time: u64) {
        for (field, active) in fields.iter_mut().zip(&self.active) {
            field.clear(active.get(time as usize).copied().flatten().unwrap_or_default());
        }
    }

    /// What the chance from an entry that is taken with this chance errs by at most, so many rounds before the end: the
    /// kernel's mass is at most 1, and its quadrature errs by no more than a step.
    fn error(&self, entry: &FastEntry, entered: f64, rounds: u64) -> f64 {
        let grid: f64 = self.grids[entry.way.next].iter().map(|grid| grid.error).sum();
        let taken = (1.001 * entered + entry.chance.width() + 2.1 * grid + self.step).min(entry.chance.high);
        let sum = rounds as f64 * self.step;
        2.0 * taken * sum * (1.001 * sum).exp() + entry.chance.high * (2.1 * grid + 2.1 * self.step + UNLIKELY)
    }

    /// The chances of success from each point, by phase: in a round, and in the last one.
    fn outcomes(&self) -> Vec<[Vec<Outcome>; 2]> {
        let outcome = |phase: usize, way: &FastWay, patch: &FastPatch| {
            let along = |axis: usize| {
                let (motion, ranges) = (&way.motions[axis], &patch.axes[axis]);
                let chance =
                    |state: &f64| if contains(&ranges[0], *state) { motion.chance(ranges, *state) } else { 0.0 };
                self.grids[phase][axis].nodes.iter().map(chance).collect::<Vec<f64>>()
            };
            Outcome { weight: way.weight * patch.weight, chances: [along(0), along(1)] }
        };
        let mut all = Vec::new();
        for (phase, ways) in self.phases.iter().enumerate() {
            let early = ways.iter().flat_map(|way| way.success.iter().map(move |patch| outcome(phase, way, patch)));
            let last = ways.iter().flat_map(|way| way.last.iter().map(move |patch| outcome(phase, way, patch)));
            all.push([early.collect(), last.collect()]);
        }
        all
    }

    /// From no state into a phase; gives the chance of coming there, and what should have been taken out and was not.
    fn enter(&self, way: &FastWay, chance: f64, fields: &mut [Field], room: &mut Room) -> Result<(f64, f64), String> {
        let mut start = Field::default();
        start.put(chance);
        let (mut sum, mut over) = (0.0, 0.0);
        for patch in &way.onward {
            let make = |axis: usize| {
                let (key, grid) = (self.key(way, patch, axis, 0), &self.grids[way.next][axis]);
                Operator::new(key, &[0.0], grid, self.cut(way.next), MOST_VALUES)
            };
            let ([one, other], weight) = ([make(0)?, make(1)?], way.weight * patch.weight);
            let going = weight * start.weighted(&one.chances, &other.chances);
            sum += going;
            if weight < 0.0 {
                over -= going + start.take(-weight, &one, &other, &mut fields[way.next], room);
            } else {
                start.go(weight, &one, &other, &mut fields[way.next], room);
            }
        }
        Ok((sum, over))
    }
}
