//! Chances of a chain in one or two independent dimensions, by quadrature with a proved bound.
//!
//! The chance V(s) of success within n more rounds from state s satisfies V_0 = 0 and
//! V_n(s) = D(s) + ∫ k(s,x) V_(n-1)(x) dx, summed over the ways of a round, with a kernel that is a product over the axes
//! of a normal density times the chance of the guard. Integrals become sums over points, and these sums of sums are added
//! up from the start on: with the mass of each point of a round, of which D(s) is won in that round and the rest goes on by
//! the weighted kernel. Four errors are bounded, none by experience:
//!
//! * *discretisation*: [`super::grid`] says how;
//! * *truncation*: whatever the sums leave out (states outside the window of their round, densities far out) is what
//!   the chances of going on exceed the masses by that are found in the next round; it may have led anywhere;
//! * *rounding*: each kernel value is known to a stated error, a sum of n terms to n units in the last place;
//! * *what is next to impossible*: moves that no state makes likely are left out, and tests that no state makes fail where
//!   the others hold ([`super::unlikely`]); their chances widen the answer;
//! * all of them add up from round to round, as the kernel's total mass is at most 1.

use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::axes::{AXES, settled};
use super::chain::Chain;
use super::field::{Field, Outcome, Room};
use super::foreseen::foreseen;
use super::grid::{Grid, Smooth};
use super::joint::joint;
use super::kernel::{AxisRanges, Fast, Guard, Ranges, UNIT, contains, scale};
use super::operator::{Cut, Key, Operator};
use super::plan::{Entry, MOST_ROUNDS, PLACES, Plan, Way, duration, plan};
use super::recut::later_rounds;
use super::region::Patch;
use super::sharp::blunted;
use super::unlikely::without;
use super::window::windows;
use super::{Enclosed, Question};
use crate::interval::Interval;

/// Chances that are left out and counted, in relation to what one sum should err by: of a way that a state takes, and at the
/// ends of an axis.
const NEGLIGIBLE: f64 = 1e-3;
const TRIMMED: f64 = 0.05;
/// Values that are held, and multiplications.
const MOST_VALUES: usize = 8_000_000;
const MOST_WORK: f64 = 3e11;

/// A patch in machine numbers.
pub(super) type FastPatch = [AxisRanges; AXES];

/// A way in machine numbers.
pub(super) struct FastWay {
    pub weight: f64,
    pub motions: [Fast; AXES],
    pub success: Vec<FastPatch>,
    pub last: Vec<FastPatch>,
    pub onward: Vec<FastPatch>,
    pub next: usize,
}

/// An entry in machine numbers.
pub(super) struct FastEntry {
    pub time: u64,
    pub way: FastWay,
    chance: Interval,
}

/// A chance, surely between these, as narrow as is wanted if machine numbers allow it.
///
/// # Errors
/// Where the states or the kernel grow too large, or a way has no noise.
pub fn enclosed(whole: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
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
}

impl Machine {
    fn new(plan: &Plan, own: usize, wanted: f64) -> Result<Machine, String> {
        let units = units(plan)?;
        let fast = |way: &Way| FastWay::of(way, &units);
        let phases: Vec<Vec<FastWay>> = plan.phases.iter().map(|ways| ways.iter().map(fast).collect()).collect();
        let entry = |one: &Entry| FastEntry { time: one.time, way: fast(&one.way).near(), chance: one.chance };
        let entries: Vec<FastEntry> = plan.entries.iter().map(entry).collect();
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
        let share = wanted / (plan.rounds as f64 + 2.0) / (phases.len() * AXES) as f64;
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
        };
        for (phase, windows) in windows.iter().enumerate() {
            let mut grids = [Grid::single(), Grid::single()];
            for (axis, grid) in grids.iter_mut().enumerate().filter(|(axis, _)| plan.states[phase][*axis]) {
                let hull =
                    windows.iter().flatten().map(|window| window[axis]).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
                if let Some(hull) = hull {
                    *grid = Grid::new(hull, &machine.smooth(plan, phase, axis), machine.share)?;
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
        machine.connect(plan)?;
        machine.step = machine.bound();
        Ok(machine)
    }

    /// What is known of the integrals over the states of a phase.
    fn smooth(&self, plan: &Plan, phase: usize, axis: usize) -> Smooth {
        let all = self.phases.iter().flatten().chain(self.entries.iter().map(|entry| &entry.way));
        let into: Vec<&FastWay> = all.filter(|way| !way.onward.is_empty() && way.next == phase).collect();
        let lands = |way: &FastWay| !way.onward.is_empty() && plan.states[way.next][axis];
        let out = &self.phases[phase];
        let kernel = into.iter().map(|way| way.motions[axis].growth()).fold(0.0, f64::max);
        let value = out.iter().map(|way| way.motions[axis].growth_before(lands(way))).fold(0.0, f64::max);
        let weight = |ways: &mut dyn Iterator<Item = &FastWay>| ways.map(|way| way.weight).sum::<f64>() + 1.0;
        let sd = into.iter().map(|way| way.motions[axis].sd);
        let mut cuts = Vec::new();
        let finite = |ranges: &Ranges| {
            ranges.iter().flat_map(|(low, high)| [*low, *high]).filter(|end| end.is_finite()).collect::<Vec<f64>>()
        };
        for way in into.iter().filter(|way| way.motions[axis].guard == Guard::Next) {
            way.onward.iter().for_each(|patch| cuts.extend(finite(&patch[axis][1])));
        }
        for way in out {
            way.patches().for_each(|patch| cuts.extend(finite(&patch[axis][0])));
        }
        Smooth {
            growth: kernel + value,
            size: weight(&mut into.iter().copied()) * weight(&mut out.iter()),
            sd: (sd.clone().fold(f64::INFINITY, f64::min), sd.fold(0.0, f64::max)),
            cuts,
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
                for patch in 0..count {
                    let here = (phase, way, patch);
                    patches.push([self.operator(plan, here, 0), self.operator(plan, here, 1)]);
                }
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

    /// What of an operator is left out, and counted.
    fn cut(&self) -> Cut {
        Cut { band: self.band, least: NEGLIGIBLE * self.share }
    }

    fn operator(&mut self, plan: &Plan, (phase, way, patch): (usize, usize, usize), axis: usize) -> usize {
        let one = &self.phases[phase][way];
        let key = key(plan, one, &one.onward[patch], axis, phase * AXES + axis);
        let grid = |number: usize| &self.grids[number / AXES][number % AXES];
        let same = |other: &Operator| {
            let other = &other.key;
            let points = grid(other.from) == grid(key.from) && grid(other.to) == grid(key.to);
            points && Key { from: key.from, to: key.to, ..other.clone() } == key
        };
        if let Some(found) = self.operators.iter().position(same) {
            return found;
        }
        let operator = Operator::new(key.clone(), &grid(key.from).nodes, grid(key.to), self.cut());
        self.operators.push(operator);
        self.operators.len() - 1
    }

    /// What one round errs by at most: quadrature of the chance and of what is left out, and rounding.
    fn bound(&self) -> f64 {
        let quadrature: f64 = self.grids[..self.own].iter().flatten().map(|grid| grid.error).sum();
        let reach =
            self.grids.iter().flatten().flat_map(|grid| &grid.nodes).fold(0.0f64, |most, node| most.max(node.abs()));
        let error = |way: &FastWay, patch: &FastPatch| {
            let axes = way.motions.iter().zip(patch);
            way.weight * axes.map(|(motion, ranges)| motion.chance_error(ranges, reach)).sum::<f64>()
        };
        let each = |ways: &mut dyn Iterator<Item = &FastWay>| {
            let (mut relative, mut absolute, mut patches) = (0.0f64, 0.0, 0.0);
            for way in ways {
                let sum = |patches: &[FastPatch]| patches.iter().map(|patch| error(way, patch)).sum::<f64>();
                // Either all of a round counts, or what counts at the last moment alone.
                absolute += (sum(&way.success) + sum(&way.onward)).max(sum(&way.last));
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
        2.1 * quadrature + 2.0 * relative + 2.0 * absolute + 2.0 * terms * UNIT
    }

    fn run(&self, plan: &Plan) -> Result<Interval, String> {
        let fields = || vec![Field::default(); self.phases.len()];
        let (mut now, mut next, mut room) = (fields(), fields(), Room::default());
        let outcomes = self.outcomes();
        let (mut value, mut lost, mut wide) = (0.0, 0.0, 0.0);
        let mut entries = self.entries.iter().peekable();
        self.clear(&mut next, 0);
        // What goes on into a round; what of it is not found there is lost.
        let mut onward = 0.0;
        for time in 0..plan.rounds {
            std::mem::swap(&mut now, &mut next);
            while let Some(entry) = entries.next_if(|entry| entry.time == time) {
                let chance = f64::midpoint(entry.chance.low, entry.chance.high);
                let entered = self.enter(plan, &entry.way, chance, &mut now, &mut room);
                wide += entry.chance.width() + self.error(entry, entered, plan.rounds - time);
                onward += entered;
            }
            now.iter_mut().for_each(|field| field.trim(TRIMMED * self.share));
            lost += onward - now.iter().map(Field::mass).sum::<f64>();
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
                    for operators in patches {
                        let [one, other] = operators.map(|place| &self.operators[place]);
                        onward += way.weight * field.weighted(&one.chances, &other.chances);
                        if way.weight * one.most * other.most > NEGLIGIBLE * self.share {
                            field.go(way.weight, one, other, &mut next[way.next], &mut room);
                        }
                    }
                }
            }
        }
        let found = Interval::between((value - wide).max(0.0), value + lost.max(0.0) + wide);
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
                let (motion, ranges) = (&way.motions[axis], &patch[axis]);
                let chance =
                    |state: &f64| if contains(&ranges[0], *state) { motion.chance(ranges, *state) } else { 0.0 };
                self.grids[phase][axis].nodes.iter().map(chance).collect::<Vec<f64>>()
            };
            Outcome { weight: way.weight, chances: [along(0), along(1)] }
        };
        let mut all = Vec::new();
        for (phase, ways) in self.phases.iter().enumerate() {
            let early = ways.iter().flat_map(|way| way.success.iter().map(move |patch| outcome(phase, way, patch)));
            let last = ways.iter().flat_map(|way| way.last.iter().map(move |patch| outcome(phase, way, patch)));
            all.push([early.collect(), last.collect()]);
        }
        all
    }

    /// From where there is no state into a phase; gives the chance of coming there.
    fn enter(&self, plan: &Plan, way: &FastWay, chance: f64, fields: &mut [Field], room: &mut Room) -> f64 {
        let mut start = Field::default();
        start.put(chance);
        let mut sum = 0.0;
        for patch in &way.onward {
            let make = |axis: usize| {
                Operator::new(key(plan, way, patch, axis, 0), &[0.0], &self.grids[way.next][axis], self.cut())
            };
            let [one, other] = [make(0), make(1)];
            sum += way.weight * start.weighted(&one.chances, &other.chances);
            start.go(way.weight, &one, &other, &mut fields[way.next], room);
        }
        sum
    }
}

fn key(plan: &Plan, way: &FastWay, patch: &FastPatch, axis: usize, from: usize) -> Key {
    Key {
        motion: way.motions[axis].clone(),
        ranges: patch[axis].clone(),
        lands: plan.states[way.next][axis],
        from,
        to: way.next * AXES + axis,
    }
}

/// A power of 2 for each axis that brings the least noise near 1.
fn units(plan: &Plan) -> Result<[BigRational; AXES], String> {
    let ways = || plan.phases.iter().flatten().chain(plan.entries.iter().map(|entry| &entry.way));
    let unit = |axis: usize| {
        let variances = ways().map(|way| &way.motions[axis].variance).filter(|variance| !variance.is_zero());
        variances.min().map_or_else(BigRational::one, |least| scale(least).1)
    };
    let (one, other) = (unit(0), unit(1));
    if [&one, &other].iter().any(|unit| unit.numer().bits().max(unit.denom().bits()) > 1_000) {
        return Err("the noise is too small or too large for machine numbers".to_string());
    }
    Ok([one, other])
}

/// More than the chance that a normal number is 12 standard deviations off, a million times.
const UNLIKELY: f64 = 1e-26;

impl FastWay {
    /// From where there is no state, without the ends of ranges that the next state does not come near to.
    fn near(mut self) -> FastWay {
        for (axis, motion) in self.motions.iter().enumerate().filter(|(_, motion)| motion.guard == Guard::Next) {
            let (low, high) = (motion.shift - 12.1 * motion.sd, motion.shift + 12.1 * motion.sd);
            let few = |patch: &&mut FastPatch| patch[axis][1].len() < 100;
            for patch in self.onward.iter_mut().filter(few) {
                let ranges = &mut patch[axis][1];
                ranges.retain(|(first, last)| *first < high && *last > low);
                for (first, last) in ranges {
                    *first = if *first < low { f64::NEG_INFINITY } else { *first };
                    *last = if *last > high { f64::INFINITY } else { *last };
                }
            }
        }
        self
    }

    fn of(way: &Way, units: &[BigRational; AXES]) -> FastWay {
        let ranges = |patch: &Patch, axis: usize| {
            Fast::ranges(&way.motions[axis], &units[axis], &patch[axis * PLACES..(axis + 1) * PLACES])
        };
        let fast = |patches: &Vec<Patch>| {
            patches.iter().map(|patch| [ranges(patch, 0), ranges(patch, 1)]).collect::<Vec<FastPatch>>()
        };
        FastWay {
            weight: super::kernel::near(&way.weight),
            motions: [0, 1].map(|axis: usize| Fast::of(&way.motions[axis], &units[axis])),
            success: fast(&way.success),
            last: fast(&way.last),
            onward: fast(&way.onward),
            next: way.next,
        }
    }

    fn patches(&self) -> impl Iterator<Item = &FastPatch> {
        self.success.iter().chain(&self.last).chain(&self.onward)
    }
}
