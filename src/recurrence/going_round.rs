//! First indices of forms that go round: in the first round, and before an integer part of the index grows.

use super::{Closed, Goal, Piece, Reach, by_shape};
use crate::assumption::Assumptions;
use crate::closed_form::{by_place, first_lap, first_round};
use crate::name::Name;

/// The first index of a form that goes round, in its first round: what is not met there is never met. Of one whose rounds are not
/// alike, only where it is met before an integer part of the index grows.
pub(super) fn in_one_round(closed: &Closed, index: &Name, goal: &Goal, known: &Assumptions) -> Option<Reach> {
    let last = closed.pieces.last().filter(|last| last.until.is_none())?;
    let within = |(until, form)| {
        let mut once = closed.clone();
        once.pieces.pop();
        let first = Piece { from: last.from.clone(), until: Some(until), form };
        once.pieces.extend(by_place(first, index, known));
        by_shape(&once, index, goal, known)
    };
    let Some((until, form)) = first_round(&last.form, index, &last.from, known) else {
        let found = within(first_lap(&last.form, index, &last.from, known)?);
        return Some(found).filter(|found| matches!(found, Reach::At(..)));
    };
    let steps = until.sub(&last.from).ok()?;
    Some(match within((until, form)) {
        Reach::Never(_) => Reach::Never(format!(
            "from {index} = {} on it goes round in {steps} steps, and is not met in the first round",
            last.from
        )),
        found => found,
    })
}
