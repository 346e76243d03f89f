//! What is asked of late terms alone, `x(n) = 1 and n > 4`: the first of these is the start of a sequence of its own.

use super::Reach;
use super::reach::{Wanted, reach};
use super::sequences::solve_until;
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;

/// The same of the terms from an index on, before which it holds of none, whatever the terms are; nothing where from there on
/// it still speaks of the index, or nothing is found.
pub(super) fn behind(
    recurrence: &Recurrence,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let (later, (relation, left, right)) = crate::closed_form::behind(recurrence, wanted, known)?;
    let solved = solve_until(later.clone(), known, stop).ok();
    let found = reach(&later, solved.as_ref(), (relation, &left, &right), known, stop);
    Some(found).filter(|found| !matches!(found, Reach::Unknown(_)))
}
