//! The first index at which a goal is met, one piece after the other: what is learned of those that do not meet it helps with
//! the later ones.

use super::{Closed, Goal, Reach, in_piece, meets};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece, with_known_parts};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The least index at which a goal is met, from the shapes of the pieces; the index is known to be natural.
pub(super) fn piece_by_piece(closed: &Closed, index: &Name, goal: &Goal, known: &Assumptions) -> Reach {
    let (mut reason, mut known) = ("there is no piece".to_string(), known.clone());
    for (place, piece) in closed.pieces.iter().enumerate() {
        // Whether the first index behind the piece has it.
        let next = closed.pieces.get(place + 1);
        let value = next.and_then(|next| next.form.with(index, &next.from).ok());
        let holds = |value: &Value| meets(value, closed, goal, &known) == Some(true);
        let by_parts = |value: &Value| with_known_parts(value, &known).is_some_and(|value| holds(&value));
        let at_end = value.is_some_and(|value| holds(&value) || by_parts(&value));
        match in_piece((piece, at_end), closed, index, goal, &known) {
            Ok(Reach::Never(why)) => {
                reason = why;
                not_at_the_end(piece, closed, index, goal, &mut known);
            }
            Err(unknown) => return Reach::Unknown(unknown),
            Ok(Reach::At(at, conditions)) => {
                let later = || {
                    let (rest, [condition]) = (closed.pieces.get(place + 1..)?, conditions.as_slice()) else {
                        return None;
                    };
                    if_not_whole(
                        &at,
                        condition,
                        &Closed { pieces: rest.to_vec(), ..closed.clone() },
                        index,
                        goal,
                        &known,
                    )
                };
                return later().unwrap_or(Reach::At(at, conditions));
            }
            Ok(found) => return found,
        }
    }
    Reach::Never(reason)
}

/// Learns that the last terms of a piece, whose end is symbolic, do not meet a goal.
fn not_at_the_end(piece: &Piece, closed: &Closed, index: &Name, goal: &Goal, known: &mut Assumptions) {
    let Some(until) = piece.until.as_ref().filter(|until| until.as_rational().is_none()) else { return };
    let differs = |value: &Value, known: &Assumptions| {
        let (relation, difference) = match goal {
            Goal::Equals(wanted) => (Relation::Eq, value.sub(wanted)),
            Goal::Within(center, tolerance) => {
                (Relation::Lte, value.sub(center).and_then(|rest| rest.abs()).and_then(|rest| rest.sub(tolerance)))
            }
            Goal::Holds(relation, left, right) => {
                (*relation, left.sub(right).and_then(|rest| rest.with(&closed.variable, value)))
            }
        };
        Some((relation.negated(), known.simplify(&difference.ok()?)))
    };
    for back in 1..=LAST_TERMS {
        let Ok(at) = until.sub(&Value::integer(back)) else { return };
        if known.decide(Relation::Gte, &at, &piece.from) != Some(true) {
            return;
        }
        let term = piece.form.with(index, &at).ok();
        if let Some((relation, difference)) = term.and_then(|term| differs(&term, known)) {
            known.assume(relation, &difference, &Value::zero());
        }
    }
}

/// The last terms of a piece of which it is learned that they do not meet a goal.
const LAST_TERMS: i64 = 2;

/// Where a goal is met at `at` if that is a whole number, and if not, at the next whole number by a later piece: at `ceil(at)`.
fn if_not_whole(
    at: &Value,
    (relation, floor, value): &Comparison,
    later: &Closed,
    index: &Name,
    goal: &Goal,
    known: &Assumptions,
) -> Option<Reach> {
    if (*relation, value) != (Relation::Eq, at)
        || known.simplify(&at.floor().ok()?) != *floor
        || later.pieces.is_empty()
    {
        return None;
    }
    let mut between = known.clone();
    between.assume(Relation::Gtr, at, floor);
    let Reach::At(next, conditions) = piece_by_piece(later, index, goal, &between) else { return None };
    let follows = between.decide(Relation::Eq, &next, &floor.add(&Value::one()).ok()?) == Some(true);
    (follows && conditions.is_empty()).then(|| Some(Reach::At(at.ceiling().ok()?, Vec::new()))).flatten()
}
