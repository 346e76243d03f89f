//! What may be an invariant: what is claimed of a phase, and what was asked on the ways into it.

use std::collections::BTreeSet;

use super::carried::carried;
use super::noise::{asked_roughly, noise};
use crate::assumption::Assumptions;
use crate::invariant::{Claim, follows, premises};
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::value::{Relation, ValueError};

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

/// What may hold in each phase: what is claimed there, and what was asked on some way into it. Unless all are kept,
/// those are left out that do not follow on every way.
pub(super) fn candidates(
    period: &Period,
    candidate: &Claim,
    assumptions: &Assumptions,
    kept: bool,
    equal: &[BTreeSet<Test>],
) -> Result<Vec<Vec<Test>>, ValueError> {
    let mut claimed = Vec::new();
    let mut asked = Vec::new();
    for (number, phase) in period.phases.iter().enumerate() {
        let mut tests = BTreeSet::new();
        for edge in &phase.edges {
            let Some(first) = edge.segments.first() else { continue };
            let duties = candidate.duties(&first.observed)?;
            tests.extend(duties.into_iter().filter(|duty| duty.premises.is_empty()).flat_map(|duty| duty.tests));
        }
        claimed.push(tests);
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
    if !kept {
        while drop_one_round(period, assumptions, &claimed, &mut asked)? {}
    }
    Ok(claimed.into_iter().zip(asked).map(|(claimed, asked)| claimed.union(&asked).cloned().collect()).collect())
}

/// Leaves out what does not follow on some way; true if anything was left out.
fn drop_one_round(
    period: &Period,
    assumptions: &Assumptions,
    claimed: &[BTreeSet<Test>],
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
    let all = period.initial.iter().chain(period.phases.iter().flat_map(|phase| &phase.edges));
    all.filter(move |edge| edge.next == Next::Phase(number))
}
