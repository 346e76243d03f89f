//! A chain over its axes: the ways through a round, each with what decides it and how it moves; from known states,
//! what follows is computed exactly until noise sets in.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::Question;
use super::axes::{AXES, Axes, axes, combinations, ratio, shown, stateless};
use super::chain::{Chain, Linear, Move, Region, Side};
use super::region::{Patch, Set, common, half, meet, merged, outside, whole};
use crate::distribution::standard;
use crate::interval::{Interval, normal_between};
use crate::value::Relation;

/// What decides a way on one axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Decider {
    /// Nothing.
    Nothing,
    /// The next state.
    Next,
    /// A normal number `factor * s + offset + noise`.
    Noisy {
        /// How it depends on the state.
        factor: BigRational,
        /// What is added.
        offset: BigRational,
        /// The variance of the noise.
        variance: BigRational,
        /// Its covariance with the noise of the next state.
        covariance: BigRational,
    },
}

/// What a way does on one axis: the next state is `slope * s + shift` and noise of this variance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Motion {
    /// The factor of the state.
    pub slope: BigRational,
    /// What is added.
    pub shift: BigRational,
    /// The variance of the noise.
    pub variance: BigRational,
    /// What decides.
    pub decider: Decider,
}

/// One way through a round. A patch has a set for the state and one for the decider of each axis in turn.
#[derive(Clone, Debug)]
pub struct Way {
    /// The chance of this part of the draws.
    pub weight: BigRational,
    /// By axis.
    pub motions: [Motion; AXES],
    /// Where it leads to what is asked for.
    pub success: Vec<Patch>,
    /// Where it leads to what is asked for at the last moment only.
    pub last: Vec<Patch>,
    /// Where it goes on.
    pub onward: Vec<Patch>,
    /// The phase to which it goes on.
    pub next: usize,
}

/// A way by which noise sets in, the number of rounds that have passed by then, and the chance of coming there.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Rounds.
    pub time: u64,
    /// The way, which does not depend on a state.
    pub way: Way,
    /// The chance.
    pub chance: Interval,
}

/// A chain over its axes.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Which axes the state of a phase has.
    pub states: Vec<[bool; AXES]>,
    /// The ways of a round of each phase.
    pub phases: Vec<Vec<Way>>,
    /// Where noise sets in.
    pub entries: Vec<Entry>,
    /// The chance that is decided before.
    pub decided: Interval,
    /// How many rounds there are.
    pub rounds: u64,
}

/// Known states that are followed.
const MOST_POINTS: usize = 100_000;
/// Bits of their numbers.
const MOST_BITS: u64 = 20_000;
/// Rounds.
const MOST_ROUNDS: u64 = 1_000_000;

/// The chain over its axes.
///
/// # Errors
/// What keeps it from being one in one or two independent dimensions.
pub fn plan(chain: &Chain, question: &Question) -> Result<Plan, String> {
    let axes = axes(chain, question)?;
    let live: Vec<usize> = (0..chain.phases.len()).filter(|phase| axes.settled[*phase].is_none()).collect();
    let duration = duration(chain, &live)?;
    let starts_late = |one: &Move| one.stretches.iter().any(|stretch| stretch.duration.is_some());
    if chain.initial.iter().any(starts_late) {
        return Err("time passes before the first round".to_string());
    }
    let rounds = match &duration {
        Some(duration) => (&question.time / duration).floor().to_integer().to_u64(),
        None => Some(0),
    };
    let rounds = rounds.filter(|rounds| *rounds <= MOST_ROUNDS).ok_or("there are too many rounds")?;
    let reducer = Reducer { chain, question, axes: &axes };
    let mut phases = vec![Vec::new(); chain.phases.len()];
    for phase in live {
        for one in &chain.phases[phase] {
            phases[phase].extend(reducer.ways(one, Some(phase), None)?);
        }
    }
    let states = axes.directions.iter().map(|all| [all[0].is_some(), all[1].is_some()]).collect();
    let (entries, decided) = reducer.unfold(rounds)?;
    Ok(Plan { states, phases, entries, decided, rounds })
}

/// The duration of a round, which is the same everywhere; none where there are no rounds.
fn duration(chain: &Chain, live: &[usize]) -> Result<Option<BigRational>, String> {
    let mut found: Option<BigRational> = None;
    for phase in live {
        shown(chain, *phase)?;
        for one in &chain.phases[*phase] {
            let stretch = match one.stretches.as_slice() {
                [stretch] => stretch,
                [stretch, rest] if one.next.is_none() && rest.duration.is_none() => stretch,
                _ => return Err("a round has more than one stretch".to_string()),
            };
            let duration = stretch.duration.clone().filter(Signed::is_positive).ok_or("a round takes no time")?;
            if found.as_ref().is_some_and(|other| *other != duration) {
                return Err("the rounds differ in length".to_string());
            }
            found = Some(duration);
        }
    }
    Ok(found)
}

struct Reducer<'a> {
    chain: &'a Chain,
    question: &'a Question,
    axes: &'a Axes,
}

/// A form over the states of the axes and the draws.
#[derive(Clone, Debug)]
struct Form {
    factors: [BigRational; AXES],
    draws: Vec<BigRational>,
    offset: BigRational,
}

type Drawn = [(BigRational, BigRational)];

impl Reducer<'_> {
    /// The ways of a move, from the states of a phase or from one that is known.
    fn ways(&self, one: &Move, phase: Option<usize>, point: Option<&[BigRational]>) -> Result<Vec<Way>, String> {
        let mut ways = Vec::new();
        for (weight, drawn) in combinations(one)? {
            ways.extend(Draft { reducer: self, one, phase, point, drawn: &drawn }.way(weight)?);
        }
        Ok(ways)
    }

    /// Follows known states exactly, until noise sets in on every axis.
    fn unfold(&self, rounds: u64) -> Result<(Vec<Entry>, Interval), String> {
        let (mut entries, mut decided) = (Vec::new(), Interval::exactly(0.0));
        type Point = (Option<usize>, Vec<BigRational>);
        let mut points: BTreeMap<Point, Interval> = BTreeMap::from([((None, Vec::new()), Interval::exactly(1.0))]);
        let mut count = 0;
        for time in 0..=rounds {
            let mut later = BTreeMap::new();
            for ((phase, state), chance) in points {
                count += 1;
                if count > MOST_POINTS || state.iter().any(|number: &BigRational| number.denom().bits() > MOST_BITS) {
                    return Err("there are too many known states to follow".to_string());
                }
                let moves = phase.map_or(self.chain.initial.as_slice(), |phase| self.chain.phases[phase].as_slice());
                for one in moves {
                    for way in self.ways(one, phase, Some(&state))? {
                        let patches = if time == rounds { &way.last } else { &way.success };
                        for patch in patches {
                            decided = plus(decided, times(chance, way.chance(patch)));
                        }
                        if way.onward.is_empty() || time == rounds {
                            continue;
                        }
                        let axes = (0..AXES).filter(|axis| self.axes.directions[way.next][*axis].is_some());
                        let still: Vec<bool> = axes.map(|axis| way.motions[axis].variance.is_zero()).collect();
                        if still.iter().all(|still| *still) {
                            let state = way.motions.iter().map(|motion| motion.shift.clone()).collect();
                            let onward = way.onward.iter().map(|patch| times(chance, way.chance(patch)));
                            let entry = later.entry((Some(way.next), state)).or_insert(Interval::exactly(0.0));
                            *entry = onward.fold(*entry, plus);
                        } else if still.iter().any(|still| *still) {
                            return Err("one axis is certain and the other is not".to_string());
                        } else {
                            entries.push(Entry { time, way, chance });
                        }
                    }
                }
            }
            points = later;
        }
        Ok((entries, decided))
    }
}

/// Sums and products that keep what is exact as it is.
fn plus(one: Interval, other: Interval) -> Interval {
    match (one == Interval::exactly(0.0), other == Interval::exactly(0.0)) {
        (true, _) => other,
        (_, true) => one,
        _ => one.plus(other).probability(),
    }
}

fn times(one: Interval, other: Interval) -> Interval {
    let (nothing, all) = (Interval::exactly(0.0), Interval::exactly(1.0));
    match (one, other) {
        (one, _) if one == nothing => nothing,
        (_, other) if other == nothing => nothing,
        (one, other) if one == all => other,
        (one, other) if other == all => one,
        _ => one.times(other).probability(),
    }
}

impl Way {
    /// The chance of a patch, from where there is no state.
    fn chance(&self, patch: &Patch) -> Interval {
        let mut chance = Interval::of(&self.weight);
        for (axis, motion) in self.motions.iter().enumerate() {
            let (mean, variance) = match &motion.decider {
                Decider::Nothing => continue,
                Decider::Next => (&motion.shift, &motion.variance),
                Decider::Noisy { offset, variance, .. } => (offset, variance),
            };
            if patch[2 * axis + 1] == whole() {
                continue;
            }
            let place = |bound: &Option<BigRational>, otherwise: f64| {
                bound.as_ref().map_or(Interval::exactly(otherwise), |bound| standard(bound, mean, variance))
            };
            let part = |(low, high): &super::region::Range| {
                normal_between(place(low, f64::NEG_INFINITY), place(high, f64::INFINITY))
            };
            chance = times(chance, patch[2 * axis + 1].iter().map(part).fold(Interval::exactly(0.0), plus));
        }
        chance
    }
}

/// A way in the making: a move with the means and variances of what it draws.
struct Draft<'a> {
    reducer: &'a Reducer<'a>,
    one: &'a Move,
    phase: Option<usize>,
    point: Option<&'a [BigRational]>,
    drawn: &'a Drawn,
}

/// Which axis a draw belongs to, and the random number that decides on each axis.
struct Owners {
    draws: Vec<Option<usize>>,
    bases: [Option<Form>; AXES],
}

impl Draft<'_> {
    /// None where it is never taken.
    fn way(&self, weight: BigRational) -> Result<Option<Way>, String> {
        let axes = self.reducer.axes;
        let target = self.one.next.map(|next| axes.settled.get(next).copied().flatten().ok_or(next));
        let mut next: [Option<Form>; AXES] = [None, None];
        let mut region = Region::new();
        match target {
            Some(Err(phase)) => {
                for (axis, direction) in axes.directions[phase].iter().enumerate() {
                    let Some(direction) = direction else { continue };
                    let linear = Linear { state: direction.clone(), ..Linear::default() };
                    next[axis] = Some(self.form(&linear.after(&self.one.image))?);
                }
                region = shown(self.reducer.chain, phase)?;
                region.iter_mut().flatten().for_each(|side| side.form = side.form.after(&self.one.image));
            }
            Some(Ok(true)) => region = vec![Vec::new()],
            Some(Ok(false)) => {}
            None => {
                let rest = self.one.stretches.iter().find(|stretch| stretch.duration.is_none());
                region = rest.map(|stretch| stretch.shown.clone()).unwrap_or_default();
            }
        }
        let mut owners = self.owners(&next, &region)?;
        let Some(taken) = self.patch(&self.one.tests, &mut owners)? else { return Ok(None) };
        let mut asked = Vec::new();
        for sides in &region {
            asked.extend(self.patch(sides, &mut owners)?.and_then(|patch| common(&taken, &patch)));
        }
        let phase = if let Some(Err(phase)) = target { Some(phase) } else { None };
        let rest = asked.iter().fold(vec![taken.clone()], outside);
        let (success, last, onward) = match (phase, self.reducer.question.first) {
            (None, _) => (asked.clone(), asked, Vec::new()),
            (Some(_), true) => (asked.clone(), asked, rest),
            (Some(_), false) => (Vec::new(), asked, vec![taken]),
        };
        let mut way = Way {
            weight,
            motions: [self.motion(&next[0], &owners.bases[0]), self.motion(&next[1], &owners.bases[1])],
            success,
            last,
            onward,
            next: phase.unwrap_or_default(),
        };
        for axis in 0..AXES {
            let transform = next[axis].as_ref().zip(owners.bases[axis].as_ref()).and_then(|(a, b)| multiple(a, b));
            let Some((ratio, constant)) = transform else { continue };
            for patch in [&mut way.success, &mut way.last, &mut way.onward].into_iter().flatten() {
                patch[2 * axis + 1] = moved(&patch[2 * axis + 1], &ratio, &constant);
            }
        }
        for patches in [&mut way.success, &mut way.last, &mut way.onward] {
            *patches = merged(std::mem::take(patches));
        }
        Ok(Some(way))
    }

    fn motion(&self, next: &Option<Form>, base: &Option<Form>) -> Motion {
        let zero = BigRational::zero;
        let axis_factor =
            |form: &Form| form.factors.iter().find(|factor| !factor.is_zero()).cloned().unwrap_or_default();
        let decider = match (base, next) {
            (None, _) => Decider::Nothing,
            (Some(base), Some(next)) if multiple(next, base).is_some() => Decider::Next,
            (Some(base), next) => Decider::Noisy {
                factor: axis_factor(base),
                offset: base.offset.clone(),
                variance: self.inner(base, base),
                covariance: next.as_ref().map_or_else(zero, |next| self.inner(next, base)),
            },
        };
        let Some(next) = next else { return Motion { slope: zero(), shift: zero(), variance: zero(), decider } };
        Motion { slope: axis_factor(next), shift: next.offset.clone(), variance: self.inner(next, next), decider }
    }

    fn form(&self, linear: &Linear) -> Result<Form, String> {
        let means: BigRational = linear.draws.iter().zip(self.drawn).map(|(factor, (mean, _))| factor * mean).sum();
        let mut draws = linear.draws.clone();
        draws.resize(self.drawn.len(), BigRational::zero());
        for (factor, _) in draws.iter_mut().zip(self.drawn).filter(|(_, (_, variance))| variance.is_zero()) {
            *factor = BigRational::zero();
        }
        let mut form =
            Form { factors: [BigRational::zero(), BigRational::zero()], draws, offset: &linear.constant + means };
        if stateless(linear) {
            return Ok(form);
        }
        let directions = self.phase.and_then(|phase| self.reducer.axes.directions.get(phase));
        let mut along = directions.into_iter().flatten().enumerate();
        let found = along.find_map(|(axis, direction)| Some((axis, ratio(direction.as_ref()?, &linear.state)?)));
        let (axis, factor) = found.ok_or("a round depends on a combination of the state that is not followed")?;
        match self.point {
            Some(point) => form.offset += factor * point.get(axis).ok_or("a state is missing")?,
            None => form.factors[axis] = factor,
        }
        Ok(form)
    }

    /// The covariance of two forms, for a given state.
    fn inner(&self, left: &Form, right: &Form) -> BigRational {
        left.draws.iter().zip(&right.draws).zip(self.drawn).map(|((a, b), (_, variance))| a * b * variance).sum()
    }

    /// The draws on which a form depends.
    fn drawn(&self, form: &Form) -> Vec<usize> {
        (0..self.drawn.len()).filter(|place| !form.draws[*place].is_zero()).collect()
    }

    /// Which axis each draw belongs to; the axes must be independent.
    fn owners(&self, next: &[Option<Form>; AXES], region: &Region) -> Result<Owners, String> {
        let mut owners = Owners { draws: vec![None; self.drawn.len()], bases: [None, None] };
        let mut forms: Vec<(Option<usize>, Vec<usize>)> = Vec::new();
        for (axis, form) in next.iter().enumerate() {
            forms.extend(form.as_ref().map(|form| (Some(axis), self.drawn(form))));
        }
        for side in self.one.tests.iter().chain(region.iter().flatten()) {
            let form = self.form(&side.form)?;
            forms.push((form.factors.iter().position(|factor| !factor.is_zero()), self.drawn(&form)));
        }
        for _ in 0..=forms.len() {
            for (axis, draws) in &mut forms {
                *axis = axis.or(draws.iter().find_map(|draw| owners.draws[*draw]));
                let Some(axis) = *axis else { continue };
                for draw in draws {
                    if owners.draws[*draw].replace(axis).is_some_and(|other| other != axis) {
                        return Err("two dimensions of the state share their noise".to_string());
                    }
                }
            }
        }
        Ok(owners)
    }

    /// Where the states and the random numbers must lie for all of these to hold; none if one of them never does.
    fn patch(&self, sides: &[Side], owners: &mut Owners) -> Result<Option<Patch>, String> {
        let mut patch: Patch = vec![whole(); 2 * AXES];
        for side in sides {
            let form = self.form(&side.form)?;
            let along = form.factors.iter().position(|factor| !factor.is_zero());
            let drawn = self.drawn(&form);
            let (place, set) = match (side.relation, along, drawn.first()) {
                (relation, None, None) if relation.holds(form.offset.cmp(&BigRational::zero())) => continue,
                (_, None, None) | (Relation::Eq, _, _) => return Ok(None),
                (Relation::Neq, _, _) => continue,
                (relation, Some(axis), None) => (2 * axis, half(relation, &form.factors[axis], &form.offset)),
                (relation, _, Some(draw)) => {
                    let free = || (0..AXES).find(|axis| owners.bases[*axis].is_none());
                    let axis = along.or(owners.draws[*draw]).or_else(free);
                    let axis = axis.ok_or("the guards of a round depend on more than two random numbers")?;
                    drawn.iter().for_each(|draw| owners.draws[*draw] = Some(axis));
                    let base = owners.bases[axis].get_or_insert_with(|| form.clone());
                    let parts = multiple(base, &form);
                    let (ratio, constant) = parts.ok_or("the guards of a round depend on different random numbers")?;
                    (2 * axis + 1, half(relation, &ratio, &constant))
                }
            };
            patch[place] = meet(&patch[place], &set);
            if patch[place].is_empty() {
                return Ok(None);
            }
        }
        Ok(Some(patch))
    }
}

/// `(r, c)` with `other = r * base + c`.
fn multiple(base: &Form, other: &Form) -> Option<(BigRational, BigRational)> {
    let place = base.draws.iter().position(|factor| !factor.is_zero())?;
    let ratio = &other.draws[place] / &base.draws[place];
    let same = |(one, two): (&BigRational, &BigRational)| *two == one * &ratio;
    let fits = base.draws.iter().zip(&other.draws).all(same) && base.factors.iter().zip(&other.factors).all(same);
    (fits && !ratio.is_zero()).then(|| (ratio.clone(), &other.offset - &ratio * &base.offset))
}

/// Ranges of `ratio * x + constant` as ranges of x.
fn moved(set: &Set, ratio: &BigRational, constant: &BigRational) -> Set {
    let place = |bound: &Option<BigRational>| bound.as_ref().map(|bound| (bound - constant) / ratio);
    let range = |(low, high): &super::region::Range| {
        if ratio.is_negative() { (place(high), place(low)) } else { (place(low), place(high)) }
    };
    let mut ranges: Set = set.iter().map(range).collect();
    ranges.sort_by(|one, other| one.0.cmp(&other.0));
    ranges
}
