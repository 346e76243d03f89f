//! Variables of a phase that may be integers: what a number leaves of an integer is one of so many.

use std::collections::BTreeSet;

use crate::invariant::Claim;
use crate::period::{Period, Phase, Test};
use crate::term::Term;
use crate::value::{Atom, Relation, Value};

/// Variables of a phase that are looked at.
const MOST_VARIABLES: usize = 12;

/// For each phase that each of its variables is an integer, if something is rounded in the claim or on some way; which of them
/// are is left to those who ask what follows on every way.
pub(super) fn integers(period: &Period, claim: &Claim) -> Vec<BTreeSet<Test>> {
    let rounded = |value: &Value| value.atoms().iter().any(|atom| matches!(atom, Atom::Floor(_)));
    let claimed = claim.tests.iter().any(|test| rounded(&test.left) || rounded(&test.right));
    let shown = |term: &Term| term.values().any(&rounded);
    let anything = claimed
        || period.ways().any(|edge| {
            edge.map.values().any(rounded) || edge.segments.iter().flat_map(|segment| &segment.observed).any(shown)
        });
    let whole = |value: Value| Some(Test { relation: Relation::Eq, left: value.floor().ok()?, right: value });
    let of = |phase: &Phase| {
        phase.variables.iter().take(MOST_VARIABLES).filter_map(|name| whole(Value::variable(name))).collect()
    };
    period.phases.iter().map(|phase| if anything { of(phase) } else { BTreeSet::new() }).collect()
}
