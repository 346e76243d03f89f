//! A system that has run for some rounds, with numbers.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::value::{Relation, Value};

/// The bits of a value.
const MOST_BITS: u64 = 512;
/// The bits of the denominator of a bound.
const SHORT: u64 = 8;

/// The variables of a phase with their values.
type Values = BTreeMap<Name, Value>;

/// Goes through so many rounds from the start, and hands out the phases that it comes to; the last of them with its values,
/// or none where a round draws, a value is no number, or the run ends before.
fn walk(
    period: &Period,
    assumptions: &Assumptions,
    rounds: usize,
    visit: &mut dyn FnMut(usize, &Values),
) -> Option<(usize, Values)> {
    let mut values = Values::new();
    let mut edges = &period.initial;
    let mut place = 0;
    for _ in 0..=rounds {
        let edge = taken(edges, &values, assumptions)?;
        let Next::Phase(next) = edge.next else { return None };
        let phase = period.phases.get(next)?;
        let mut reached = Values::new();
        for name in &phase.variables {
            let image = edge.map.get(name)?.substitute(&values).ok()?;
            image.as_rational().filter(|_| image.bits() <= MOST_BITS)?;
            reached.insert(name.clone(), image);
        }
        visit(next, &reached);
        (values, edges, place) = (reached, &phase.edges, next);
    }
    Some((place, values))
}

/// Short numbers between which a number lies: itself, if it is one.
fn shortened(number: &BigRational) -> (BigRational, BigRational) {
    if number.denom().bits() <= SHORT {
        return (number.clone(), number.clone());
    }
    let scale = BigRational::from_integer((1_i64 << SHORT).into());
    let scaled = number * &scale;
    (scaled.floor() / &scale, scaled.ceil() / scale)
}

/// That a value lies between two numbers.
pub(super) fn between(left: &Value, least: &BigRational, most: &BigRational) -> [Test; 2] {
    [(Relation::Gte, least), (Relation::Lte, most)].map(|(relation, end)| Test {
        relation,
        left: left.clone(),
        right: Value::rational(end.clone()),
    })
}

/// For each phase, between which numbers each of its variables lies in the first rounds of the run.
pub(super) fn observed(period: &Period, assumptions: &Assumptions, rounds: usize) -> Vec<Vec<Test>> {
    let mut ranges: Vec<BTreeMap<Name, [BigRational; 2]>> = vec![BTreeMap::new(); period.phases.len()];
    walk(period, assumptions, rounds, &mut |place, values| {
        for (name, value) in values {
            let Some(number) = value.as_rational() else { continue };
            let (low, high) = shortened(&number);
            let range = ranges[place].entry(name.clone()).or_insert_with(|| [low.clone(), high.clone()]);
            *range = [range[0].clone().min(low), range[1].clone().max(high)];
        }
    });
    // A phase is entered earlier than it is by what this run shows: what holds in all of them is easier to keep.
    let mut common: BTreeMap<Name, [BigRational; 2]> = BTreeMap::new();
    for (name, [least, most]) in ranges.iter().flatten() {
        let both = common.entry(name.clone()).or_insert_with(|| [least.clone(), most.clone()]);
        *both = [both[0].clone().min(least.clone()), both[1].clone().max(most.clone())];
    }
    let tests = |(name, [least, most]): (&Name, &[BigRational; 2])| between(&Value::variable(name), least, most);
    let own = |range: &BTreeMap<Name, [BigRational; 2]>| {
        let all = common.iter().filter(|(name, _)| range.contains_key(*name));
        range.iter().chain(all).flat_map(tests).collect()
    };
    ranges.iter().map(own).collect()
}

/// The period as it begins after so many rounds, without the ways that are not taken any more; none where a round draws, a
/// value is no number, or the run ends before.
pub(super) fn later(period: &Period, assumptions: &Assumptions, rounds: usize) -> Option<Period> {
    let (place, values) = walk(period, assumptions, rounds, &mut |_, _| {})?;
    let start = Edge {
        tests: Vec::new(),
        after: Vec::new(),
        segments: Vec::new(),
        map: values,
        communications: Vec::new(),
        draws: Vec::new(),
        switches: false,
        next: Next::Phase(place),
    };
    let mut later = Period { initial: vec![start], ..period.clone() };
    let reached = reached(&later);
    let gone = later.phases.iter_mut().enumerate().filter(|(number, _)| !reached.contains(number));
    gone.for_each(|(_, phase)| phase.edges.clear());
    Some(later)
}

/// The phases to which some way leads.
pub(super) fn reached(period: &Period) -> BTreeSet<usize> {
    let next = |edge: &Edge| match edge.next {
        Next::Phase(number) => Some(number),
        Next::End(_) => None,
    };
    let mut open: Vec<usize> = period.initial.iter().filter_map(next).collect();
    let mut found = BTreeSet::new();
    while let Some(number) = open.pop() {
        if found.insert(number) {
            open.extend(period.phases.get(number).iter().flat_map(|phase| &phase.edges).filter_map(next));
        }
    }
    found
}

/// The way that is taken with these values.
fn taken<'e>(edges: &'e [Edge], values: &BTreeMap<Name, Value>, assumptions: &Assumptions) -> Option<&'e Edge> {
    for edge in edges {
        if !edge.draws.is_empty() {
            return None;
        }
        let decide = |test: &Test| test.substitute(values).ok()?.decide(assumptions);
        let tests: Option<Vec<bool>> = edge.tests.iter().map(decide).collect();
        if tests?.into_iter().all(|holds| holds) {
            return Some(edge);
        }
    }
    None
}
