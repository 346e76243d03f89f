//! What the first rounds ask of parameters: the tests on the ways of the phases, and the claim, where only parameters are
//! left in them.

use std::collections::BTreeMap;

use super::Asked;
use crate::invariant::cases::cases;
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::value::Value;

/// Rounds from the start.
const ROUNDS: usize = 4;
/// Ways that are gone in each.
const MOST_WAYS: usize = 40;

/// The tests that the first rounds come to.
pub(super) fn prefix(period: &Period, asked: Asked<'_>) -> Vec<Test> {
    let mut found = Vec::new();
    let mut reached: Vec<(&[Edge], BTreeMap<Name, Value>)> = vec![(&period.initial, BTreeMap::new())];
    for _ in 0..ROUNDS {
        let mut next = Vec::new();
        for (edge, values) in reached.iter().flat_map(|(edges, values)| edges.iter().map(move |edge| (edge, values))) {
            if next.len() < MOST_WAYS
                && !(asked.interrupted)()
                && let Some(way) = follow(edge, values, period, asked, &mut found)
            {
                next.push(way);
            }
        }
        reached = next;
    }
    let known = |name: &Name| !period.phases.iter().any(|phase| phase.variables.contains(name));
    let free = |test: &Test| test.left.variables().iter().chain(&test.right.variables()).all(known);
    found.retain(free);
    found
}

/// Goes one way, unless it cannot be gone; where it leads.
fn follow<'a>(
    edge: &Edge,
    values: &BTreeMap<Name, Value>,
    period: &'a Period,
    Asked { claim, assumptions, .. }: Asked<'_>,
    found: &mut Vec<Test>,
) -> Option<(&'a [Edge], BTreeMap<Name, Value>)> {
    let put = |test: &Test| test.substitute(values).ok();
    let mut here = Vec::new();
    for test in edge.tests.iter().filter_map(put) {
        match test.decide(assumptions) {
            Some(false) => return None,
            Some(true) => {}
            None => here.push(test),
        }
    }
    let duties = edge.segments.iter().filter_map(|segment| claim.duties(&segment.observed).ok()).flatten();
    let asked: Vec<Test> = duties.flat_map(|duty| duty.tests).filter_map(|test| put(&test)).collect();
    for test in here.iter().chain(&asked).filter(|test| test.decide(assumptions).is_none()) {
        // Without `abs`, `max` and `if`: each of their sides is a test.
        let sides = cases(assumptions, std::slice::from_ref(test)).unwrap_or_default();
        let sides = sides.into_iter().flat_map(|side| side.tests);
        found.extend(sides.chain([test.clone()]).flat_map(|test| [test.negated(), test]));
    }
    let Next::Phase(next) = edge.next else { return None };
    let map = edge.map.iter().map(|(name, value)| Some((name.clone(), value.substitute(values).ok()?)));
    Some((&period.phases.get(next)?.edges, map.collect::<Option<_>>()?))
}
