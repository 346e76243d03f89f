//! Chances of a chain over two coordinates that share their noise or lean on each other, by quadrature with a proved bound.
//!
//! As in [`super::enclosed`], the chance of success within n more rounds is an integral over that within n-1, and integrals
//! become sums. What differs: guards may look at a number that the step to the next state gives away, so that the place
//! of a cut depends on the state, or at a combination of both coordinates. Then the piece of a panel up to the cut is
//! summed, over the polynomial through the points of the panel ([`super::panels`]).
//!
//! Chances that jump in the state (what is shown at the end) are never interpolated: they are integrated with the step that
//! leads to them, in closed form over the second coordinate. All errors of a round (quadrature, interpolation, what lies
//! beyond the panels, rounding) are carried back with the absolute values of the weights, as a second function.

use std::rc::Rc;

use super::chain::Chain;
use super::growth::{Growth, cuts, growth, unfit, width};
use super::kernel::{BAND, Ranges, UNIT, everything};
use super::normal::distribution;
use super::pace::{Area, Pace, Reach, between, meet};
use super::pair::{Pair, Step, pair};
use super::panels::{Panels, Row, Sample, interpolation, quadrature};
use super::rows::{Field, Operator, Second};
use super::spread::{Clouds, clouds};
use super::{Enclosed, Question};
use crate::interval::Interval;

/// Values that are held, and multiplications.
const MOST_VALUES: f64 = 4e7;
const MOST_WORK: f64 = 4e10;
const CLOSE: &str = "points, as close together as the bound on how chances grow asks for";

/// What happens for certain, or not at all, at the end that a state has.
struct Ending<'a> {
    pace: &'a Pace,
    area: &'a Area,
}

struct Machine {
    phases: Vec<Vec<Pace>>,
    grids: Vec<[Panels; 2]>,
    clouds: Clouds,
    operators: Vec<Vec<Operator>>,
    /// What is won on the way into the next round, and in the last one; what a row errs by.
    gains: Vec<[Vec<f64>; 2]>,
    rests: Vec<Vec<f64>>,
}

/// A chance, surely between these.
///
/// # Errors
/// What keeps the chain from being one over two such coordinates, or makes it too large.
pub(super) fn joint(chain: &Chain, question: &Question, wanted: f64) -> Result<Enclosed, String> {
    let plan = pair(chain, question)?;
    let mut machine = Machine::new(&plan, wanted)?;
    machine.connect()?;
    let (value, error) = machine.run(plan.rounds);
    if !value.is_finite() || !error.is_finite() || error > 1e-3 {
        return Err("the bounds are too wide".to_string());
    }
    let wide = Interval::exactly(value).plus(Interval::between(-error, error));
    Ok(Enclosed::within(wide.probability()))
}

impl Machine {
    fn new(plan: &Pair, wanted: f64) -> Result<Machine, String> {
        let (phases, has, known) = laid_out(plan)?;
        let growth = growth(&phases, plan.rounds)?;
        let share = wanted / (plan.rounds as f64 + 2.0) / 8.0;
        let wide = (2.0 * (8.0 / share).ln()).sqrt().min(BAND);
        let clouds = clouds(&phases, plan.rounds, wide);
        let mut grids = Vec::new();
        for (phase, known) in known.iter().enumerate() {
            let mut both = known.map(Panels::point);
            let hull = |axis: usize| {
                let all = clouds.iter().filter_map(|now| now.get(phase).copied().flatten()).map(|both| both[axis]);
                all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
            };
            for axis in (0..2).filter(|axis| has[phase][*axis]) {
                let Some(hull) = hull(axis) else { continue };
                let cuts = if axis == 0 { cuts(&phases, phase) } else { Vec::new() };
                both[axis] = Panels::new(hull, &cuts, width(&phases, phase, axis, &growth, share))?;
            }
            grids.push(both);
        }
        let mut machine =
            Machine { phases, grids, clouds, operators: Vec::new(), gains: Vec::new(), rests: Vec::new() };
        let step = machine.bound(&growth);
        machine.fit(plan.rounds)?;
        for phase in 0..machine.phases.len() {
            machine.rests.push(machine.beyond(phase, step));
        }
        Ok(machine)
    }

    /// Whether there is not too much to hold and to compute.
    fn fit(&self, rounds: u64) -> Result<(), String> {
        let size = |phase: usize, axis: usize| self.grids[phase][axis].nodes.len() as f64;
        let band = |phase: usize, axis: usize, sd: f64| {
            let grid = &self.grids[phase][axis];
            (grid.count(2.0 * BAND * sd) * super::grid::POINTS as f64).min(grid.nodes.len() as f64)
        };
        let (mut values, mut work) = (0.0, 0.0);
        for (phase, paces) in self.phases.iter().enumerate() {
            for pace in paces {
                let Some(next) = pace.next else { continue };
                let (one, other) = (band(next, 0, pace.sd), band(next, 1, pace.spread));
                let tilted = pace.onward.iter().any(|area| !everything(&area.tilt));
                // Rows that are not cut are shared, unless all differ.
                let keys = match tilted {
                    true if pace.tilt[0] != 0.0 && pace.tilt[2] != 0.0 => size(next, 0),
                    _ if pace.lean != 0.0 => size(phase, 0),
                    _ => 1.0,
                };
                values += size(phase, 0) * one + keys * size(phase, 1) * other;
                work += size(phase, 0) * (one * size(next, 1) + size(phase, 1) * other);
            }
        }
        let most = self.grids.iter().map(|both| both[0].nodes.len() * both[1].nodes.len()).max().unwrap_or(0);
        match values > MOST_VALUES || work * rounds as f64 > MOST_WORK {
            true => Err(format!("there is too much to compute over both dimensions: {most} {CLOSE}")),
            false => Ok(()),
        }
    }

    fn reach(&self) -> Reach {
        [0, 1].map(|axis: usize| {
            let nodes = self.grids.iter().flat_map(|grids| {
                let ends = grids[axis].window().map(|(low, high)| low.abs().max(high.abs()));
                grids[axis].nodes.iter().map(|node| node.abs()).chain(ends)
            });
            nodes.fold(0.0, f64::max)
        })
    }

    /// What a row errs by at most: quadrature, interpolation, rounding.
    fn bound(&self, growth: &Growth) -> f64 {
        let reach = self.reach();
        let mut worst = 0.0f64;
        for paces in &self.phases {
            let (mut sum, mut areas) = (0.0, 0.0);
            for pace in paces {
                let count = pace.areas().count() as f64;
                let ends = |set: &Ranges| 2.0 * set.len() as f64;
                let cuts: f64 = pace.areas().flat_map(|area| area.looks.iter().map(ends)).sum();
                areas += count;
                sum += pace.rounding(reach);
                let Some(next) = pace.next else { continue };
                let [one, other] = &self.grids[next];
                let mut panels = |grid: &Panels, sd: f64, rate: f64, cuts: f64, own: f64, cut: bool, reach: f64| {
                    if sd <= 0.0 {
                        return;
                    }
                    let half = grid.half();
                    let pieces = count * grid.count(2.0 * BAND * sd) + cuts;
                    sum += 2.0 * pieces * 0.4 / sd * quadrature(rate, half);
                    // Points that are rounded, see the panels of `grid`.
                    let distance = rate.sqrt().recip();
                    let band = 2.0 * BAND * sd + 4.0 * half;
                    sum += count * band * 0.7 / sd / distance * 4.0 * UNIT * (reach + half);
                    if cut {
                        sum += 2.0 * interpolation(own, half) + 4e-12;
                    }
                };
                panels(one, pace.sd, growth.first, cuts, growth.chance, growth.tied, reach[0]);
                let tilted = pace.areas().map(|area| ends(&area.tilt)).sum();
                panels(other, pace.spread, growth.second, tilted, growth.kept, growth.tilted, reach[1]);
            }
            let terms = self.grids.iter().flatten().map(|grid| grid.nodes.len()).max().unwrap_or(0) as f64;
            worst = worst.max(sum + (4.0 * terms + 40.0 * areas + 100.0) * UNIT);
        }
        2.0 * worst
    }

    /// For each state, the chance of leaving the panels, and what a row errs by.
    fn beyond(&self, phase: usize, step: f64) -> Vec<f64> {
        let [one, other] = &self.grids[phase];
        let mut rests = vec![step; one.nodes.len() * other.nodes.len()];
        let outside = |grid: &Panels, mean: f64, sd: f64| match grid.window() {
            Some((low, high)) if sd > 0.0 => distribution((low - mean) / sd) + distribution((mean - high) / sd) + 2e-14,
            _ => 0.0,
        };
        for pace in &self.phases[phase] {
            let Some(next) = pace.next else { continue };
            for (row, first) in one.nodes.iter().enumerate() {
                let part = outside(&self.grids[next][0], pace.mean(*first), pace.sd);
                for (column, second) in other.nodes.iter().enumerate() {
                    let mean = pace.second_mean(*first, *second);
                    let leaves = part + outside(&self.grids[next][1], mean, pace.spread);
                    rests[row * other.nodes.len() + column] += pace.weight * leaves;
                }
            }
        }
        rests
    }

    /// The points of the next first coordinate that a row sums over, with the weighted chances.
    fn samples(&self, pace: &Pace, next: usize, area: &Area, [first, second]: [f64; 2]) -> Vec<(Sample, f64)> {
        if !area.now.iter().any(|(low, high)| *low <= first && first <= *high) {
            return Vec::new();
        }
        let mean = pace.mean(first);
        let band = (mean - BAND * pace.sd, mean + BAND * pace.sd);
        let grid = &self.grids[next][0];
        let all = grid.samples(&pace.reach(area, first), band);
        let value = |sample: Sample| {
            let density = if pace.sd > 0.0 { pace.density(first, sample.place) } else { 1.0 };
            let value = pace.weight * sample.weight * density * pace.passes(area, [first, second], sample.place);
            (sample, value)
        };
        all.into_iter().map(value).filter(|(_, value)| *value > 0.0).collect()
    }

    /// What is won from the states of a phase in a round, or in the last one, and in the next by what ends there in a jump.
    fn gain(&self, phase: usize, last: bool) -> Vec<f64> {
        let [one, other] = &self.grids[phase];
        let mut gains = vec![0.0; one.nodes.len() * other.nodes.len()];
        for (first, row) in one.nodes.iter().zip(gains.chunks_exact_mut(other.nodes.len())) {
            for pace in &self.phases[phase] {
                match pace.next {
                    Some(next) => self.won(pace, next, last, *first, &other.nodes, row),
                    None => ended(pace, if last { &pace.last } else { &pace.success }, *first, &other.nodes, row),
                }
            }
        }
        gains
    }

    /// What is won on the way into the next round.
    fn won(&self, pace: &Pace, next: usize, last: bool, first: f64, seconds: &[f64], row: &mut [f64]) {
        let all = vec![(f64::NEG_INFINITY, f64::INFINITY)];
        for area in if last { &pace.last } else { &pace.success } {
            if pace.leans() {
                for (second, gain) in seconds.iter().zip(row.iter_mut()) {
                    *gain +=
                        self.samples(pace, next, area, [first, *second]).iter().map(|(_, value)| value).sum::<f64>();
                }
                continue;
            }
            collect(pace, &self.samples(pace, next, area, [first, 0.0]), &area.tilt, (&all, 0.0), first, seconds, row);
        }
        for ending in if last { Vec::new() } else { self.endings(next) } {
            for area in &pace.onward {
                let samples = self.samples(pace, next, area, [first, 0.0]);
                let samples: Vec<(Sample, f64)> = samples.iter().filter_map(|one| ending.after(one)).collect();
                let jump = (&ending.area.tilt, ending.pace.tilt[0]);
                collect(pace, &samples, &area.tilt, jump, first, seconds, row);
            }
        }
    }

    /// The ways of a phase that end there in what is asked for, with a jump.
    fn endings(&self, phase: usize) -> Vec<Ending<'_>> {
        let ends = self.phases[phase].iter().filter(|pace| pace.next.is_none());
        let all = ends.flat_map(|pace| pace.success.iter().map(move |area| Ending { pace, area }));
        all.filter(|ending| !everything(&ending.area.tilt)).collect()
    }

    /// Makes the weights, and what is won.
    fn connect(&mut self) -> Result<(), String> {
        for phase in 0..self.phases.len() {
            let mut operators: Vec<Operator> = Vec::new();
            for pace in &self.phases[phase] {
                let Some(next) = pace.next else { continue };
                let mut tilts: Vec<&Ranges> = pace.onward.iter().map(|area| &area.tilt).collect();
                tilts.dedup();
                let tilted = tilts.iter().any(|tilt| !everything(tilt));
                if tilted && pace.tilt[0] != 0.0 && (pace.lean != 0.0 || pace.tilt[1] != 0.0) {
                    return Err("a combination that leans on both dimensions is looked at in every round".to_string());
                }
                let mut done: Vec<&Ranges> = Vec::new();
                for tilt in tilts {
                    if !done.contains(&tilt) {
                        operators.push(self.operator(phase, pace, next, tilt));
                        done.push(tilt);
                    }
                }
            }
            self.operators.push(operators);
            let gains = [self.gain(phase, false), self.gain(phase, true)];
            self.gains.push(gains);
        }
        Ok(())
    }

    fn operator(&self, phase: usize, pace: &Pace, next: usize, tilt: &Ranges) -> Operator {
        let [one, other] = &self.grids[phase];
        let [to, after] = &self.grids[next];
        let first = one.nodes.iter().map(|place| {
            let mut row = Row::default();
            for area in pace.onward.iter().filter(|area| area.tilt == *tilt) {
                row.add(to.row(&self.samples(pace, next, area, [*place, 0.0])));
            }
            row
        });
        let first = first.collect();
        // The weights for each second coordinate, by the first one now and the next one; rows that are not cut are shared.
        let plain = |place: f64, second: f64, ranges: &Ranges| {
            let mean = pace.second_mean(place, second);
            let band = (mean - BAND * pace.spread, mean + BAND * pace.spread);
            let value = |sample: Sample| {
                let value = sample.weight * pace.second_density(mean, sample.place);
                (sample, value)
            };
            Rc::new(after.row(&after.samples(ranges, band).into_iter().map(value).collect::<Vec<_>>()))
        };
        let all = vec![(f64::NEG_INFINITY, f64::INFINITY)];
        let whole: Vec<Rc<Row>> = other.nodes.iter().map(|second| plain(0.0, *second, &all)).collect();
        let nothing = Rc::new(Row::default());
        let rows = |place: f64, after_place: f64| {
            let row = |(second, whole): (&f64, &Rc<Row>)| {
                let moved = pace.tilt[0] * after_place;
                let ranges: Ranges =
                    pace.tilted(tilt, [place, *second]).iter().map(|(a, b)| (a - moved, b - moved)).collect();
                let mean = pace.second_mean(place, *second);
                let (low, high) = after.touching((mean - BAND * pace.spread, mean + BAND * pace.spread));
                match (pace.lean == 0.0, meet(&ranges, &vec![(low, high)]).as_slice()) {
                    (true, [only]) if *only == (low, high) => whole.clone(),
                    (_, []) => nothing.clone(),
                    _ => plain(place, *second, &ranges),
                }
            };
            other.nodes.iter().zip(&whole).map(row).collect::<Vec<Rc<Row>>>()
        };
        let tilted = !everything(tilt);
        let second = match after.window() {
            None => Second::Nothing,
            Some(_) if tilted && pace.tilt[0] != 0.0 => {
                Second::Next(to.nodes.iter().map(|place| rows(0.0, *place)).collect())
            }
            Some(_) if pace.lean != 0.0 || (tilted && pace.tilt[1] != 0.0) => {
                Second::Now(one.nodes.iter().map(|place| rows(*place, 0.0)).collect())
            }
            Some(_) => Second::Same(rows(0.0, 0.0)),
        };
        Operator { next, first, second }
    }

    /// The chance from the start, and what it errs by.
    fn run(&self, rounds: u64) -> (f64, f64) {
        let start = self.phases.len() - 1;
        let whole = |phase: usize| [0, 1].map(|axis: usize| (0, self.grids[phase][axis].nodes.len()));
        let ones = |phase: usize| {
            let size = self.rests[phase].len();
            Field { active: whole(phase), values: vec![0.0; size], errors: vec![1.0; size] }
        };
        let all: Vec<Field> = (0..self.phases.len()).map(ones).collect();
        let sums: Vec<Field> = (0..start + 1).map(|phase| self.back(phase, whole(phase), &all)).collect();
        let mut fields: Vec<Field> = vec![Field::default(); self.phases.len()];
        for time in (0..rounds).rev() {
            let last = time + 1 == rounds;
            let mut now = vec![Field::default(); self.phases.len()];
            for (phase, field) in now.iter_mut().enumerate() {
                // The first window is that of the start.
                let window = self.clouds.get(time as usize + 1).and_then(|now| now.get(phase).copied().flatten());
                let Some(window) = window.filter(|_| phase < start) else { continue };
                let active = [0, 1].map(|axis: usize| self.grids[phase][axis].active(window[axis]));
                *field = if last { self.nothing(phase, active) } else { self.back(phase, active, &fields) };
                self.finish(phase, field, last, &sums[phase]);
            }
            fields = now;
        }
        let last = rounds == 0;
        let mut field = if last { self.nothing(start, whole(start)) } else { self.back(start, whole(start), &fields) };
        self.finish(start, &mut field, last, &sums[start]);
        (field.values.first().copied().unwrap_or(f64::NAN), field.errors.first().copied().unwrap_or(f64::NAN))
    }

    fn nothing(&self, phase: usize, active: [(usize, usize); 2]) -> Field {
        let size = self.rests[phase].len();
        Field { active, values: vec![0.0; size], errors: vec![0.0; size] }
    }

    /// Adds what is won and what is not known; the errors become less by 1, as those of states that are not looked at are
    /// 1.
    fn finish(&self, phase: usize, field: &mut Field, last: bool, sums: &Field) {
        let width = self.grids[phase][1].nodes.len();
        let start = phase + 1 == self.phases.len();
        for row in field.active[0].0..field.active[0].1 {
            for column in field.active[1].0..field.active[1].1 {
                let place = row * width + column;
                field.values[place] += self.gains[phase][usize::from(last)][place];
                let sum = if last { 0.0 } else { sums.errors[place] };
                field.errors[place] = (field.errors[place] + sum) * (1.0 + 1e-9) + self.rests[phase][place];
                if !start {
                    field.errors[place] -= 1.0;
                }
            }
        }
    }

    /// The sums of one round back, over the states that are looked at.
    fn back(&self, phase: usize, active: [(usize, usize); 2], after: &[Field]) -> Field {
        let mut field = self.nothing(phase, active);
        let width = self.grids[phase][1].nodes.len();
        for operator in &self.operators[phase] {
            let next = &after[operator.next];
            if next.values.is_empty() {
                continue;
            }
            operator.apply(&mut field, width, next, self.grids[operator.next][1].nodes.len());
        }
        field
    }
}

/// The phases with those that are entered apart and the start, which coordinates each has, and where it is known otherwise.
#[allow(clippy::type_complexity)] // Three lists of one length.
fn laid_out(plan: &Pair) -> Result<(Vec<Vec<Pace>>, Vec<[bool; 2]>, Vec<[f64; 2]>), String> {
    let paces = |steps: &Vec<Step>| steps.iter().map(Pace::of).collect::<Vec<Pace>>();
    let mut phases: Vec<Vec<Pace>> = plan.phases.iter().map(paces).collect();
    let mut start = paces(&plan.start);
    if !phases.iter().flatten().chain(&start).all(Pace::is_sound) {
        return Err("the numbers of a round are too large or too small for machine numbers".to_string());
    }
    // A phase is entered by a copy of its own: there a coordinate may be known, or have less noise.
    let mut has: Vec<[bool; 2]> =
        plan.bases.iter().map(|basis| [basis.first.is_some(), basis.second.is_some()]).collect();
    // A second coordinate that never changes is the same in all phases.
    let still = |pace: &Pace| pace.next.is_some_and(|next| has[next][1]) && pace.spread <= 0.0;
    let constant = phases.iter().flatten().any(still);
    has.iter_mut().filter(|_| constant).for_each(|has| has[1] = false);
    let value = start.iter().find(|pace| constant && pace.next.is_some()).map_or(0.0, |pace| pace.drift);
    let mut known: Vec<[f64; 2]> = vec![[0.0, value]; phases.len()];
    for pace in &mut start {
        let Some(next) = pace.next else { continue };
        pace.next = Some(phases.len());
        phases.push(phases[next].clone());
        known.push([pace.shift, pace.drift]);
        has.push([has[next][0] && pace.sd > 0.0, has[next][1] && pace.spread > 0.0]);
    }
    // What ends a run may be summed over a number as if it were a state.
    let count = phases.len();
    let summed = phases.iter_mut().chain([&mut start]).flatten().filter(|pace| pace.summed);
    for (number, pace) in summed.enumerate() {
        pace.next = Some(count + number);
        has.push([true, false]);
        known.push([0.0; 2]);
    }
    phases.resize(has.len(), Vec::new());
    phases.push(start);
    known.push([0.0; 2]);
    has.push([false; 2]);
    if (0..phases.len()).any(|phase| unfit(&phases, phase)) {
        return Err("a run ends by a combination of the state that comes with no noise of its own".to_string());
    }
    Ok((phases, has, known))
}

impl Ending<'_> {
    /// A point of an integral with the chance that it ends there, but for the tilted form.
    fn after(&self, (sample, value): &(Sample, f64)) -> Option<(Sample, f64)> {
        let chance = self.chance(sample.place);
        (chance > 0.0).then(|| (*sample, value * chance))
    }

    fn chance(&self, first: f64) -> f64 {
        let here = self.area.now.iter().any(|(low, high)| *low <= first && first <= *high);
        if here { self.pace.weight * self.pace.passes(self.area, [first, 0.0], 0.0) } else { 0.0 }
    }
}

/// Adds the chances of what ends a run, but for jumps, which count a round before.
fn ended(pace: &Pace, areas: &[Area], first: f64, seconds: &[f64], row: &mut [f64]) {
    for area in areas.iter().filter(|area| everything(&area.tilt)) {
        if area.now.iter().any(|(low, high)| *low <= first && first <= *high) {
            let gains = row.iter_mut().zip(seconds);
            gains.for_each(|(gain, second)| *gain += pace.weight * pace.passes(area, [first, *second], 0.0));
        }
    }
}

/// Adds the chances that the next second coordinate is where it must be, for each state of a row: for the way, and for a
/// jump of its slope.
fn collect(
    pace: &Pace,
    samples: &[(Sample, f64)],
    tilt: &Ranges,
    (jump, slope): (&Ranges, f64),
    first: f64,
    seconds: &[f64],
    row: &mut [f64],
) {
    if everything(tilt) && everything(jump) {
        let sum: f64 = samples.iter().map(|(_, value)| value).sum();
        row.iter_mut().for_each(|gain| *gain += sum);
        return;
    }
    // Where both are looked at, their slopes are the same.
    let slope = if everything(tilt) { slope } else { pace.tilt[0] };
    let total: f64 = samples.iter().map(|(_, value)| value).sum();
    for (second, gain) in seconds.iter().zip(row) {
        let mean = pace.second_mean(first, *second);
        let ranges = meet(&pace.tilted(tilt, [first, *second]), jump);
        let part = |(sample, value): &(Sample, f64)| value * between(&ranges, mean + slope * sample.place, pace.spread);
        *gain += match slope == 0.0 {
            true => total * between(&ranges, mean, pace.spread),
            false => samples.iter().map(part).sum::<f64>(),
        };
    }
}
