//! What is asked of some sequences does not depend on those that they do not read.

use std::collections::BTreeSet;

use super::sequences::solve_until;
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Solved, closures};
use crate::value::Value;

/// The sequences alone on which these values depend, with their forms, where there are others, which may have none.
pub(super) fn needed(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    sides: [&Value; 2],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Solved> {
    let needed = read_by(recurrence, &sides)?;
    let Some(solved) = solved else { return solve_until(recurrence.only(&needed), known, stop).ok() };
    let forms = needed.iter().map(|place| solved.forms()[*place].clone()).collect();
    Solved::check(recurrence.only(&needed), forms, solved.conditions().to_vec(), known).ok()
}

/// The places of the sequences on which these values depend, where there are others.
pub(crate) fn read_by(recurrence: &Recurrence, sides: &[&Value]) -> Option<BTreeSet<usize>> {
    let terms = recurrence.terms();
    let read =
        |place: &usize| terms.iter().any(|(name, own, _)| own == place && sides.iter().any(|side| side.mentions(name)));
    let count = recurrence.sequences.len();
    let closures = closures(count, recurrence.reads());
    let needed: BTreeSet<usize> = (0..count).filter(read).flat_map(|place| closures[place].clone()).collect();
    (!needed.is_empty() && needed.len() < count).then_some(needed)
}
