//! What may be an invariant: what is claimed of a phase, and what was asked on the ways into it.

use std::collections::BTreeSet;

use super::carried::carried;
use super::noise::{asked_roughly, noise};
use crate::assumption::Assumptions;
use crate::invariant::cases::impossible;
use crate::invariant::{Claim, follows, premises};
use crate::name::Name;
use crate::period::{Edge, Next, Period, Phase, Test};
use crate::value::{Relation, Value, ValueError};

/// The bits from which on a number is long.
const LONG: u64 = 128;

/// Leaves out that a value is at least and at most one long number: that is where the run happens to be after many rounds.
fn without_points(tests: &mut BTreeSet<Test>) {
    let opposite = |test: &Test| match test.relation {
        Relation::Gte => Some(Test { relation: Relation::Lte, ..test.clone() }),
        Relation::Lte => Some(Test { relation: Relation::Gte, ..test.clone() }),
        _ => None,
    };
    let long = |test: &Test| test.left.bits().max(test.right.bits()) > LONG;
    let all = tests.clone();
    tests.retain(|test| !long(test) || !opposite(test).is_some_and(|opposite| all.contains(&opposite)));
}

/// What is left out of what may hold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// What was asked on some way into a phase, if it follows on every way.
    Following,
    /// The same, if it follows on every way that can be taken; a phase that cannot be reached has no values at all.
    Reached,
    /// All that was asked.
    All,
}

/// What may hold in each phase: what is claimed there, and what was asked on some way into it.
pub(super) fn candidates(
    period: &Period,
    candidate: &Claim,
    assumptions: &Assumptions,
    kept: Kept,
    equal: &[BTreeSet<Test>],
) -> Result<Vec<Vec<Test>>, ValueError> {
    let mut claimed = claimed(period, candidate)?;
    let mut asked = Vec::new();
    for (number, phase) in period.phases.iter().enumerate() {
        let own: BTreeSet<&Name> = phase.variables.iter().collect();
        let about = |test: &Test| {
            let names = test.left.variables();
            names.union(&test.right.variables()).any(|name| own.contains(name))
        };
        asked.push(
            entries(period, number)
                .flat_map(|edge| edge.after.iter().flatten())
                .cloned()
                .chain(carried(period, number))
                .chain(noise(period, number))
                .chain(asked_roughly(period, number))
                .filter(|test| about(test))
                .chain(equal[number].iter().cloned())
                .collect::<BTreeSet<Test>>(),
        );
    }
    asked.iter_mut().for_each(without_points);
    match kept {
        Kept::All => {}
        Kept::Following => {
            let all = vec![true; period.phases.len()];
            while drop_one_round(period, assumptions, &claimed, &all, &mut asked)? {}
        }
        Kept::Reached => {
            let reached = reached(period, assumptions, &claimed, &mut asked)?;
            let never = Test { relation: Relation::Gte, left: Value::zero(), right: Value::one() };
            for number in (0..reached.len()).filter(|number| !reached[*number]) {
                claimed[number] = BTreeSet::from([never.clone()]);
                asked[number].clear();
            }
        }
    }
    Ok(claimed.into_iter().zip(asked).map(|(claimed, asked)| claimed.union(&asked).cloned().collect()).collect())
}

/// What is claimed of the variables of each phase as it begins.
pub(super) fn claimed(period: &Period, claim: &Claim) -> Result<Vec<BTreeSet<Test>>, ValueError> {
    let of = |phase: &Phase| {
        let mut tests = BTreeSet::new();
        for edge in &phase.edges {
            let Some(first) = edge.segments.first() else { continue };
            let duties = claim.duties(&first.observed)?;
            tests.extend(duties.into_iter().filter(|duty| duty.premises.is_empty()).flat_map(|duty| duty.tests));
        }
        Ok(tests)
    };
    period.phases.iter().map(of).collect()
}

/// The phases that are reached where what is claimed holds; leaves out what does not follow on a way to one of them.
fn reached(
    period: &Period,
    assumptions: &Assumptions,
    claimed: &[BTreeSet<Test>],
    asked: &mut [BTreeSet<Test>],
) -> Result<Vec<bool>, ValueError> {
    let mut reached = vec![false; period.phases.len()];
    let reach = |edges: &[Edge], known: &[Test], reached: &mut Vec<bool>| -> bool {
        let mut more = false;
        for edge in edges {
            let Next::Phase(next) = edge.next else { continue };
            if reached.get(next) == Some(&false) && !impossible(assumptions, &premises(edge, known)) {
                reached[next] = true;
                more = true;
            }
        }
        more
    };
    reach(&period.initial, &[], &mut reached);
    loop {
        while drop_one_round(period, assumptions, claimed, &reached, asked)? {}
        let mut more = false;
        for (number, phase) in period.phases.iter().enumerate() {
            if !reached[number] {
                continue;
            }
            let known: Vec<Test> = claimed[number].union(&asked[number]).cloned().collect();
            more |= reach(&phase.edges, &known, &mut reached);
        }
        if !more {
            return Ok(reached);
        }
    }
}

/// Leaves out what does not follow on some way from the start or a phase that is reached; true if anything was left out.
fn drop_one_round(
    period: &Period,
    assumptions: &Assumptions,
    claimed: &[BTreeSet<Test>],
    reached: &[bool],
    asked: &mut [BTreeSet<Test>],
) -> Result<bool, ValueError> {
    let mut changed = false;
    let known: Vec<Vec<Test>> =
        claimed.iter().zip(asked.iter()).map(|(claimed, asked)| claimed.union(asked).cloned().collect()).collect();
    let starts = period.initial.iter().map(|edge| (edge, None));
    let rounds = period
        .phases
        .iter()
        .enumerate()
        .filter(|(from, _)| reached.get(*from) == Some(&true))
        .flat_map(|(from, phase)| phase.edges.iter().map(move |edge| (edge, Some(from))));
    for (edge, from) in starts.chain(rounds) {
        let Next::Phase(next) = edge.next else { continue };
        let before = premises(edge, from.and_then(|from| known.get(from)).map_or(&[][..], Vec::as_slice));
        let Some(here) = asked.get_mut(next) else { continue };
        for test in here.clone() {
            let there = edge.after.iter().flatten().any(|after| *after == test);
            if !there && !follows(assumptions, &before, &test.substitute(&edge.map)?) {
                here.remove(&test);
                changed = true;
            }
        }
    }
    Ok(changed)
}

/// The ways into a phase.
pub(super) fn entries(period: &Period, number: usize) -> impl Iterator<Item = &Edge> {
    let all = period.ways();
    all.filter(move |edge| edge.next == Next::Phase(number))
}
