//! A system that takes the same ways again and again though its values go on: by the tests on these ways, which hold for
//! ever once they hold.

use std::collections::{BTreeMap, BTreeSet};

use super::course::{Course, MOST_SIZE, way};
use super::forever::{Answers, Values};
use super::{Edge, Next, Period, Test};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::Value;

/// Rounds that are followed; after 1, 2, 3, 4, 6, 8, 12, … of them it is looked whether the ways come again.
const MOST_ROUNDS: usize = 1 << 9;
/// Ways that come again one after another.
const MOST_WAYS: usize = 32;

/// A way that was taken: from which phase, in which state, how long after the start.
struct Taken<'a> {
    edge: &'a Edge,
    phase: usize,
    state: BTreeMap<Name, Value>,
    time: Value,
}

impl Taken<'_> {
    fn is_as(&self, other: &Taken<'_>) -> bool {
        self.phase == other.phase && std::ptr::eq(self.edge, other.edge)
    }
}

/// Several ways one after another, as one: what they ask and come to, over the variables before them.
#[derive(Default)]
struct Joined {
    tests: Vec<Test>,
    lasting: Vec<Value>,
    /// What the variables are after each way.
    images: Vec<BTreeMap<Name, Value>>,
}

impl Period {
    /// Where the same ways are taken for ever from some time on, though values go on: after that time it is again as it was,
    /// but for these. None where that is not found.
    pub fn onward(&self, assumptions: &Assumptions, interrupted: &dyn Fn() -> bool) -> Option<Course> {
        let (mut edges, mut state, mut time) = (self.initial.as_slice(), BTreeMap::new(), Value::zero());
        let mut taken: Vec<Taken<'_>> = Vec::new();
        let mut phase = None;
        while taken.len() < MOST_ROUNDS && !interrupted() {
            let edge = way(edges, &state, assumptions)?;
            let Next::Phase(number) = edge.next else { return None };
            if let Some(phase) = phase {
                taken.push(Taken { edge, phase, state: state.clone(), time: time.clone() });
            }
            time = time.add(&edge.duration().ok()?.substitute(&state).ok()?).ok()?;
            let next = edge.map.iter().map(|(name, value)| Some((name.clone(), value.substitute(&state).ok()?)));
            state = next.collect::<Option<_>>()?;
            if state.values().any(|value| value.size() > MOST_SIZE) {
                return None;
            }
            (edges, phase) = (&self.phases.get(number)?.edges, Some(number));
            let count = taken.len();
            if (count.is_power_of_two() || (count.is_multiple_of(3) && (count / 3).is_power_of_two()))
                && let Some(found) = again(&taken, (number, &state, &time), assumptions, interrupted)
            {
                return Some(found);
            }
        }
        None
    }
}

/// What comes again from here on, if the last ways are those before them: the fewest such ways, or those that have come again
/// for longest, as three may come twice within a greater round.
fn again(
    taken: &[Taken<'_>],
    now: (usize, &BTreeMap<Name, Value>, &Value),
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Option<Course> {
    // How long, from the end backwards, each way is the one so many before it.
    let repeated = |count: usize| {
        let (last, earlier) = (taken.iter().rev(), taken.iter().rev().skip(count));
        last.zip(earlier).take_while(|(one, other)| one.is_as(other)).count()
    };
    let counts = (1..=MOST_WAYS.min(taken.len() / 2)).map(|count| (count, repeated(count)));
    let counts: Vec<(usize, usize)> = counts.filter(|(count, repeated)| repeated >= count).collect();
    let (fewest, _) = *counts.first()?;
    let (longest, _) = *counts.iter().rev().max_by_key(|(_, repeated)| *repeated)?;
    repeats(taken, fewest, now, assumptions, interrupted)
        .or_else(|| (longest != fewest).then(|| repeats(taken, longest, now, assumptions, interrupted)).flatten())
}

/// Whether so many last ways are taken for ever.
fn repeats(
    taken: &[Taken<'_>],
    count: usize,
    (phase, state, now): (usize, &BTreeMap<Name, Value>, &Value),
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Option<Course> {
    let ways = taken.get(taken.len() - count..)?;
    if ways.first()?.phase != phase {
        return None;
    }
    let joined = Joined::of(ways)?;
    let images = joined.images.last()?;
    let values = Values { start: state, images };
    let unchanged = unchanged(&values);
    let stays =
        |value: &Value| value.variables().iter().all(|name| !images.contains_key(name) || unchanged.contains(name));
    let lasting = joined.lasting.iter().try_fold(Value::zero(), |sum, time| sum.add(time).ok())?;
    let needed = joined.images.iter().flat_map(BTreeMap::values).filter(|value| !value.needs().is_empty());
    if !stays(&lasting) || !needed.into_iter().all(stays) || !shows_values(ways) {
        return None;
    }
    let tests: Vec<Test> =
        joined.tests.iter().filter(|test| !(stays(&test.left) && stays(&test.right))).cloned().collect();
    if !matches!(values.answers(&tests, assumptions, interrupted), Answers::Forever) {
        return None;
    }
    let beside =
        joined.images.iter().flatten().filter(|(_, value)| !stays(value)).map(|(name, _)| name.clone()).collect();
    let from = since(taken, (count, state), &beside).map_or(now, |first| &first.time).clone();
    let lasting = lasting.substitute(state).ok()?;
    (!lasting.is_zero()).then_some(Course::Repeats { lasting, from, beside })
}

/// The first from which on, of ways that come again after so many, all but what is beside is what it is then.
fn since<'t, 'a>(
    taken: &'t [Taken<'a>],
    (count, state): (usize, &BTreeMap<Name, Value>),
    beside: &BTreeSet<Name>,
) -> Option<&'t Taken<'a>> {
    let later = |place: usize| taken.get(place + count);
    let holds = |(place, one): &(usize, &Taken<'_>)| {
        let then = later(*place).map_or(state, |later| &later.state);
        let kept = |(name, value): (&Name, &Value)| beside.contains(name) || then.get(name) == Some(value);
        later(*place).is_none_or(|later| one.is_as(later)) && one.state.iter().all(kept)
    };
    taken.iter().enumerate().rev().skip(count - 1).take_while(holds).last().map(|(_, first)| first)
}

/// Whether all that passes and is shown on these ways has a value, whatever the variables are.
fn shows_values(ways: &[Taken<'_>]) -> bool {
    ways.iter().all(|taken| {
        let shown = taken.edge.segments.iter().flat_map(|segment| &segment.observed).flat_map(|term| term.values());
        let passed = taken.edge.communications.iter().map(|(_, value)| value);
        let tests = taken.edge.tests.iter().flat_map(|test| [&test.left, &test.right]);
        let times = taken.edge.segments.iter().map(|segment| &segment.duration);
        shown.chain(passed).chain(tests).chain(times).all(|value| {
            let needs = value.needs();
            needs.iter().all(|need| need.value().variables().iter().all(|name| !taken.state.contains_key(name)))
        })
    })
}

/// The values that each round leaves as they are at the start: images of such values alone.
fn unchanged(values: &Values<'_>) -> BTreeSet<Name> {
    let mut kept: BTreeMap<Name, Value> = values.start.clone();
    loop {
        let stays = |(name, value): (&Name, &Value)| {
            let image = values.images.get(name).and_then(|image| image.substitute(&kept).ok());
            image.as_ref() == Some(value)
        };
        let next: BTreeMap<Name, Value> =
            kept.iter().filter(|one| stays(*one)).map(|(name, value)| (name.clone(), value.clone())).collect();
        if next.len() == kept.len() {
            return next.into_keys().collect();
        }
        kept = next;
    }
}

impl Joined {
    fn of(ways: &[Taken<'_>]) -> Option<Joined> {
        let mut joined = Joined::default();
        let mut now: BTreeMap<Name, Value> = BTreeMap::new();
        for Taken { edge, .. } in ways {
            for test in &edge.tests {
                joined.tests.push(test.substitute(&now).ok()?);
            }
            joined.lasting.push(edge.duration().ok()?.substitute(&now).ok()?);
            let next = edge.map.iter().map(|(name, value)| Some((name.clone(), value.substitute(&now).ok()?)));
            now = next.collect::<Option<_>>()?;
            if now.values().any(|value| value.size() > MOST_SIZE) {
                return None;
            }
            joined.images.push(now.clone());
        }
        Some(joined)
    }
}
