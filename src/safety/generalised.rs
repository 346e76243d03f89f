//! From one instance to all: an invariant that proves the claim with some numbers, over the phases with symbols.

use std::collections::BTreeSet;

use super::candidates::{Kept, candidates};
use super::equality::equalities;
use super::later::reached;
use super::points::Instance;
use super::search::supposed;
use crate::assumption::Assumptions;
use crate::invariant::cases::{cases, impossible};
use crate::invariant::{Claim, check, premises};
use crate::period::{Edge, Period, Test};
use crate::value::{Relation, Value};

/// How often ways are left out that an invariant does not leave open.
const ROUNDS: usize = 4;
/// Tests of an invariant of which each is tried to be left out.
const MOST_TESTS: usize = 40;

type Invariant = Vec<Vec<Test>>;

/// Invariants that prove the claim in this instance: as they are found, and without what is not needed there.
pub(super) fn generalised(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    instance: &Instance,
) -> Vec<Invariant> {
    let numbers: Vec<Test> = instance.values.iter().map(|(name, value)| equal(Value::variable(name), value)).collect();
    let with = supposed(assumptions, &numbers);
    let parts = cases(&Assumptions::default(), &claim.tests).unwrap_or_default();
    let stronger = parts.into_iter().filter(|part| !part.tests.is_empty());
    let stronger = stronger.map(|part| Claim { tests: part.tests, ..claim.clone() });
    for candidate in stronger.chain([claim.clone()]) {
        for (kept, tied) in [(Kept::Following, false), (Kept::Following, true), (Kept::All, true)] {
            if let Some(found) = proving(period, (claim, &candidate), &with, kept, tied) {
                let fewer = needed(period, claim, &with, found.clone());
                return if fewer == found { vec![found] } else { vec![fewer, found] };
            }
        }
    }
    Vec::new()
}

fn equal(left: Value, right: &Value) -> Test {
    Test { relation: Relation::Eq, left, right: right.clone() }
}

/// An invariant made of what is asked on the ways that can be gone, and of which values are equal there.
fn proving(
    period: &Period,
    (claim, candidate): (&Claim, &Claim),
    with: &Assumptions,
    kept: Kept,
    tied: bool,
) -> Option<Invariant> {
    let mut open = restricted(period, with, None);
    for _ in 0..ROUNDS {
        let known: Vec<BTreeSet<Test>> =
            (0..open.phases.len()).map(|phase| if tied { equalities(&open, phase) } else { BTreeSet::new() }).collect();
        let mut invariant = candidates(&open, candidate, with, kept, &known).ok()?;
        let reached = reached(&open);
        let gone = invariant.iter_mut().enumerate().filter(|(number, _)| !reached.contains(number));
        gone.for_each(|(_, tests)| *tests = vec![equal(Value::zero(), &Value::one())]);
        if check(period, with, claim, &invariant).is_ok() {
            return Some(invariant);
        }
        let next = restricted(period, with, Some(&invariant));
        if ways(&next) == ways(&open) {
            return None;
        }
        open = next;
    }
    None
}

fn ways(period: &Period) -> usize {
    period.phases.iter().map(|phase| phase.edges.len()).sum()
}

/// The period without ways that cannot be gone.
fn restricted(period: &Period, with: &Assumptions, invariant: Option<&Invariant>) -> Period {
    let mut open = period.clone();
    let nothing = Vec::new();
    let can = |edge: &Edge, known: &[Test]| !impossible(with, &premises(edge, known));
    open.initial.retain(|edge| can(edge, &[]));
    for (number, phase) in open.phases.iter_mut().enumerate() {
        let known = invariant.map_or(&nothing, |invariant| &invariant[number]);
        phase.edges.retain(|edge| can(edge, known));
    }
    let reached = reached(&open);
    let gone = open.phases.iter_mut().enumerate().filter(|(number, _)| !reached.contains(number));
    gone.for_each(|(_, phase)| phase.edges.clear());
    open
}

/// Leaves out of an invariant what the proof in this instance does without.
fn needed(period: &Period, claim: &Claim, with: &Assumptions, mut invariant: Invariant) -> Invariant {
    if invariant.iter().map(Vec::len).sum::<usize>() > MOST_TESTS {
        return invariant;
    }
    for phase in 0..invariant.len() {
        for place in (0..invariant[phase].len()).rev() {
            let mut fewer = invariant.clone();
            fewer[phase].remove(place);
            if check(period, with, claim, &fewer).is_ok() {
                invariant = fewer;
            }
        }
    }
    invariant
}
