//! The first index from a number on: the terms from there are a recurrence of their own.

use super::Reach;
use super::jointly::from_on;
use super::reach::{Wanted, reach};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Sequence, Solved};
use crate::value::{Relation, Value};

/// The first index, `from` or later, at which a comparison of terms holds, by the forms; nothing where these are no pieces.
pub fn reach_since(
    solved: &Solved,
    from: i64,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let whole = solved.recurrence();
    let (index, place) = (&whole.index, Value::integer(from));
    if whole.from != 0 {
        return None;
    }
    match reach(whole, Some(solved), (relation, left, right), known, stop) {
        Reach::At(at, conditions) if conditions.is_empty() => match known.decide(Relation::Gte, &at, &place) {
            Some(true) => return Some(Reach::At(at, conditions)),
            Some(false) => {}
            None => return Some(Reach::undecided(Relation::Gte, &at, &place)),
        },
        never @ Reach::Never(_) => return Some(never),
        _ => {}
    }
    let shifted = Value::variable(index).add(&place).ok()?;
    let moved = |value: &Value| value.with(index, &shifted).ok();
    let (mut sequences, mut forms) = (Vec::new(), Vec::new());
    for (sequence, form) in whole.sequences.iter().zip(solved.forms()) {
        let pieces = match from_on(form.by_pieces(index, 0)?, &place, index, known)? {
            Ok(pieces) => pieces,
            Err(asked) => return Some(asked),
        };
        let form = match pieces.as_slice() {
            [Piece { form, .. }] => Form::Value(Vec::new(), form.clone()),
            _ => Form::Pieces(pieces),
        };
        let start = (0..sequence.start.len())
            .map(|offset| form.at(index, 0, i64::try_from(offset).ok()?, known).ok().map(|term| known.simplify(&term)));
        sequences.push(Sequence {
            start: start.collect::<Option<_>>()?,
            next: moved(&sequence.next)?,
            ..sequence.clone()
        });
        forms.push(form);
    }
    let later = Recurrence { index: index.clone(), from: 0, sequences };
    let later = Solved::check(later, forms, solved.conditions().to_vec(), known).ok()?;
    let (left, right) = (moved(left)?, moved(right)?);
    Some(match reach(later.recurrence(), Some(&later), (relation, &left, &right), known, stop) {
        Reach::At(at, conditions) => Reach::At(at.add(&place).ok()?, conditions),
        found => found,
    })
}
