//! Pieces that meet: where the form of a piece gives the first value of the next one, too, it may be asked up to there. A
//! motion that passes a point is on its line still when it is behind it.

use super::{Closed, Piece};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The same values, with each piece whose end is symbolic one index longer where its form holds there; `None` where none is.
pub(super) fn overlapping(closed: &Closed, index: &Name, known: &Assumptions) -> Option<Closed> {
    let mut pieces = closed.pieces.clone();
    let mut changed = false;
    for place in 1..pieces.len() {
        let [before, after] = pieces.get_mut(place - 1..=place)? else { return None };
        if let Some(end) = later(before, after, index, known) {
            before.until = Some(end.clone());
            after.from = end;
            changed = true;
        }
    }
    changed.then(|| Closed { pieces, ..closed.clone() })
}

/// The index after the first one of a piece, if that is not its last and the piece before has the same value there.
fn later(before: &Piece, after: &Piece, index: &Name, known: &Assumptions) -> Option<Value> {
    let end = before.until.as_ref().filter(|end| end.as_rational().is_none() && **end == after.from)?;
    let later = end.add(&Value::one()).ok()?;
    let remains = |until: &Value| known.decide(Relation::Lss, &later, until) == Some(true);
    if !after.until.as_ref().is_none_or(remains) {
        return None;
    }
    let [one, other] = [before, after].map(|piece| piece.form.with(index, end).ok());
    (known.decide(Relation::Eq, &one?, &other?) == Some(true)).then_some(later)
}
