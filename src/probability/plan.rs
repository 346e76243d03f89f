//! A chain over its axes: the ways through a round, each with what decides it and how it moves; from known states,
//! what follows is computed exactly until noise sets in.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::Question;
use super::axes::{AXES, Axes, axes, combinations, random, shown};
use super::chain::{Chain, Move};
use super::draft::Draft;
use super::region::{Patch, Range, common, merged, whole};
use super::unrolled::unrolled;
use crate::distribution::standard;
use crate::interval::{Interval, normal_between};

/// What decides a way on one axis.
#[allow(clippy::large_enum_variant)] // There are few of them, and most are of the large kind.
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

/// A further number that decides, independent of all others once the state is known: `factor * s + offset + noise`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Gate {
    /// The factor.
    pub factor: BigRational,
    /// What is added.
    pub offset: BigRational,
    /// The variance of the noise, positive.
    pub variance: BigRational,
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
    /// What decides too, each by itself.
    pub gates: Vec<Gate>,
}

/// The numbers that may decide on one axis: of a mission of several legs, each may be the last look of a round.
pub const DECIDERS: usize = 16;
/// Coordinates of a patch for each axis: the state, the decider, the gates.
pub const PLACES: usize = 2 + DECIDERS;

/// Distances that may decide a way.
pub const DISCS: usize = 4;
/// Coordinates of a patch: those of each axis in turn, and the distances.
pub const WIDTH: usize = AXES * PLACES + DISCS;

/// What decides a way by a distance: `a*(x-c)² + b*(y-d)²` of a number on each axis, each with noise of its own.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Round {
    /// By axis: the place of the number in a patch, the factor, and the middle.
    pub sides: [(usize, BigRational, BigRational); AXES],
}

/// One way through a round. A patch has [`PLACES`] sets for each axis in turn, and one for each distance.
#[derive(Clone, Debug)]
pub struct Way {
    /// The chance of this part of the draws.
    pub weight: BigRational,
    /// By axis.
    pub motions: [Motion; AXES],
    /// Distances that decide.
    pub rounds: Vec<Round>,
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
pub(super) const MOST_ROUNDS: u64 = 1_000_000;

/// The chain over its axes.
///
/// # Errors
/// What keeps it from being one in one or two independent dimensions.
pub fn plan(chain: &Chain, question: &Question) -> Result<Plan, String> {
    planned(chain, question).or_else(|reason| {
        let live: Vec<usize> = (0..chain.phases.len()).collect();
        let duration = duration(chain, &live).ok().flatten();
        let unrolled = duration.and_then(|duration| unrolled(chain, question, &duration)).ok_or(reason.clone())?;
        planned(&unrolled, question).map_err(|_| reason)
    })
}

fn planned(chain: &Chain, question: &Question) -> Result<Plan, String> {
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
    let leads = vec![Leads::default(); chain.phases.len()];
    let mut reducer = Reducer { chain, question, axes: &axes, leads };
    let drawn = if random(chain) { live.as_slice() } else { &[] };
    let mut phases = reducer.rounds(drawn);
    if phases.is_err() {
        // Where no guards share their noise, it did not matter.
        reducer.leads = reducer.leads(drawn)?;
        phases = reducer.rounds(drawn);
    }
    let phases = phases?;
    let states = axes.directions.iter().map(|all| [all[0].is_some(), all[1].is_some()]).collect();
    let (entries, decided) = reducer.unfold(rounds)?;
    Ok(Plan { states, phases, entries, decided, rounds })
}

/// Ways that move alike, as one: the chances of their patches add up where no two have anything in common. Those of two
/// parts of a mixture may be the same, and each counts.
fn together(ways: Vec<Way>) -> Vec<Way> {
    let mut all: Vec<Way> = Vec::new();
    let apart =
        |one: &[Patch], other: &[Patch]| one.iter().all(|one| other.iter().all(|other| common(one, other).is_none()));
    for way in ways {
        let alike = |other: &&mut Way| {
            other.next == way.next
                && other.weight == way.weight
                && other.motions == way.motions
                && other.rounds == way.rounds
                && apart(&other.success, &way.success)
                && apart(&other.last, &way.last)
                && apart(&other.onward, &way.onward)
        };
        match all.iter_mut().find(alike) {
            Some(other) => {
                other.success.extend(way.success);
                other.last.extend(way.last);
                other.onward.extend(way.onward);
            }
            None => all.push(way),
        }
    }
    for way in &mut all {
        for patches in [&mut way.success, &mut way.last, &mut way.onward] {
            *patches = merged(std::mem::take(patches));
        }
    }
    all
}

/// The duration of a round, which is the same everywhere; none where there are no rounds.
pub(super) fn duration(chain: &Chain, live: &[usize]) -> Result<Option<BigRational>, String> {
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

pub(super) struct Reducer<'a> {
    pub chain: &'a Chain,
    pub question: &'a Question,
    pub axes: &'a Axes,
    /// By phase and axis: the variance of the noise that sets in before anything is looked at, where the state is taken
    /// after it.
    pub leads: Vec<Leads>,
}

/// The variances of the parts of a noise, by axis.
pub(super) type Leads = [Option<Vec<BigRational>>; AXES];

impl Reducer<'_> {
    /// The ways of a round of these phases.
    fn rounds(&self, live: &[usize]) -> Result<Vec<Vec<Way>>, String> {
        let mut phases = vec![Vec::new(); self.chain.phases.len()];
        for phase in live {
            let mut ways = Vec::new();
            for one in &self.chain.phases[*phase] {
                ways.extend(self.ways(one, Some(*phase), None)?);
            }
            phases[*phase] = together(ways);
        }
        Ok(phases)
    }

    /// The ways of a move, from the states of a phase or from one that is known.
    fn ways(&self, one: &Move, phase: Option<usize>, point: Option<&[BigRational]>) -> Result<Vec<Way>, String> {
        let mut ways = Vec::new();
        for (weight, drawn) in combinations(one)? {
            ways.extend(Draft { reducer: self, one, phase, point, drawn: &drawn }.way(weight)?);
        }
        Ok(ways)
    }

    /// Where several guards of a round look at one position, they share the noise with which it was reached. On such an
    /// axis the state of a phase is taken behind that noise, which then belongs to the round before; here are the
    /// variances of its parts.
    fn leads(&self, live: &[usize]) -> Result<Vec<Leads>, String> {
        let mut leads = vec![Leads::default(); self.chain.phases.len()];
        let mut needed = [false; AXES];
        for phase in live {
            for one in &self.chain.phases[*phase] {
                for (_, drawn) in combinations(one)? {
                    let draft = Draft { reducer: self, one, phase: Some(*phase), point: None, drawn: &drawn };
                    for (axis, (shares, parts)) in draft.leads()?.into_iter().enumerate() {
                        needed[axis] |= shares;
                        let least = leads[*phase][axis].as_ref().map(Vec::len);
                        if parts.as_ref().is_some_and(|parts| least.is_none_or(|least| parts.len() < least)) {
                            leads[*phase][axis] = parts;
                        }
                    }
                }
            }
        }
        for all in &mut leads {
            all.iter_mut().zip(needed).filter(|(_, needed)| !needed).for_each(|(lead, _)| *lead = None);
        }
        Ok(leads)
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
                    for way in together(self.ways(one, phase, Some(&state))?) {
                        let patches = if time == rounds { &way.last } else { &way.success };
                        for patch in patches {
                            decided = plus(decided, times(chance, way.chance(patch)?));
                        }
                        if way.onward.is_empty() || time == rounds {
                            continue;
                        }
                        let axes = (0..AXES).filter(|axis| self.axes.directions[way.next][*axis].is_some());
                        let still: Vec<bool> = axes.map(|axis| way.motions[axis].variance.is_zero()).collect();
                        if still.iter().all(|still| *still) {
                            let state = way.motions.iter().map(|motion| motion.shift.clone()).collect();
                            let entry = later.entry((Some(way.next), state)).or_insert(Interval::exactly(0.0));
                            for patch in &way.onward {
                                *entry = plus(*entry, times(chance, way.chance(patch)?));
                            }
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
pub(super) fn plus(one: Interval, other: Interval) -> Interval {
    match (one == Interval::exactly(0.0), other == Interval::exactly(0.0)) {
        (true, _) => other,
        (_, true) => one,
        _ => one.plus(other).probability(),
    }
}

pub(super) fn times(one: Interval, other: Interval) -> Interval {
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
    pub(super) fn chance(&self, patch: &Patch) -> Result<Interval, String> {
        let mut chance = Interval::of(&self.weight);
        for (round, set) in self.rounds.iter().zip(&patch[AXES * PLACES..]).filter(|(_, set)| **set != whole()) {
            chance = times(chance, round.chance(&self.motions, set)?);
        }
        for (axis, motion) in self.motions.iter().enumerate() {
            let sets = &patch[axis * PLACES..(axis + 1) * PLACES];
            let own = match &motion.decider {
                Decider::Nothing => None,
                Decider::Next => Some((&motion.shift, &motion.variance)),
                Decider::Noisy { offset, variance, .. } => Some((offset, variance)),
            };
            let gates = motion.gates.iter().map(|gate| Some((&gate.offset, &gate.variance)));
            for (number, set) in std::iter::once(own).chain(gates).zip(&sets[1..]) {
                if let (Some((mean, variance)), false) = (number, *set == whole()) {
                    let place = |bound: &Option<BigRational>, otherwise: f64| {
                        bound.as_ref().map_or(Interval::exactly(otherwise), |bound| standard(bound, mean, variance))
                    };
                    let part =
                        |(low, high): &Range| normal_between(place(low, f64::NEG_INFINITY), place(high, f64::INFINITY));
                    chance = times(chance, set.iter().map(part).fold(Interval::exactly(0.0), plus));
                }
            }
        }
        Ok(chance)
    }
}
