//! Comparisons of which all are to hold: where each one holds for ever once it holds, all do from the last of their first
//! indices on, and not before it.

use std::collections::BTreeMap;

use num_traits::Zero;

use super::Reach;
use super::parabola::before_rounding;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, compared};
use crate::value::{Relation, Value};

/// The first index at which all comparisons hold, each of which is asked; not known where one of them is not, and nothing where
/// one may cease to hold.
pub(super) fn first_of_all(
    recurrence: &Recurrence,
    parts: &[Comparison],
    known: &Assumptions,
    ask: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let found = last_of_firsts(parts, known, ask)?;
    let never = matches!(found, Reach::Never(_));
    (never || parts.iter().all(|part| lasts(recurrence, part, known) == Some(true))).then_some(found)
}

/// The last of the first indices at which comparisons hold, each of which is asked; never, or not known, where one is not.
pub(super) fn last_of_firsts(
    parts: &[Comparison],
    known: &Assumptions,
    ask: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let (mut latest, mut all, mut open): (Option<Value>, Vec<Comparison>, Option<Reach>) = (None, Vec::new(), None);
    for part in parts {
        match ask((part.0, &part.1, &part.2)) {
            Reach::Never(why) => return Some(Reach::Never(format!("{} is not met: {why}", compared(part)))),
            unknown @ Reach::Unknown(_) => open = open.or(Some(unknown)),
            Reach::At(at, conditions) => {
                let after = conditions.into_iter().filter(|condition| !all.contains(condition)).collect::<Vec<_>>();
                all.extend(after);
                latest = Some(match latest {
                    Some(other) => later(other, at, known)?,
                    None => at,
                });
            }
        }
    }
    open.or_else(|| latest.map(|at| Reach::At(at, all)))
}

/// Whether a comparison of terms holds at the next index where it holds at one, whatever the terms are.
fn lasts(recurrence: &Recurrence, (relation, left, right): &Comparison, known: &Assumptions) -> Option<bool> {
    let index = &recurrence.index;
    let mut here = known.without_name(index);
    if recurrence.from >= 0 {
        here.assume_natural(index);
    }
    let mut images = BTreeMap::new();
    for sequence in &recurrence.sequences {
        let term = recurrence.term(&sequence.name, 0);
        here = here.without_name(&term);
        let next = match sequence.start.len() {
            1 => sequence.next.clone(),
            _ => Value::variable(&recurrence.term(&sequence.name, 1)),
        };
        images.insert(term, next);
    }
    images.insert(index.clone(), Value::variable(index).add(&Value::one()).ok()?);
    let difference = left.sub(right).ok()?;
    let next = difference.substitute(&images).ok()?;
    let zero = Value::zero();
    if *relation == Relation::Eq {
        return images.keys().filter(|name| *name != index).find_map(|name| {
            let (factor, rest) = difference.linear_in(name)?;
            factor.as_rational().filter(|factor| !factor.is_zero())?;
            let place = rest.neg().ok()?.div(&factor).ok()?;
            here.decide(Relation::Eq, &here.simplify(&next.with(name, &place).ok()?), &zero)
        });
    }
    here.assume(*relation, &difference, &zero);
    here.decide(*relation, &here.simplify(&next), &zero)
}

/// The greater of two indices.
fn later(one: Value, other: Value, known: &Assumptions) -> Option<Value> {
    // Rounding up keeps the order.
    let order = |one: &Value, other: &Value| known.decide(Relation::Gte, one, other);
    let of_inner =
        |one: &Value, other: &Value| Some(order(&before_rounding(one)?, &before_rounding(other)?) == Some(true));
    if order(&one, &other) == Some(true) || of_inner(&one, &other) == Some(true) {
        return Some(one);
    }
    if order(&other, &one) == Some(true) || of_inner(&other, &one) == Some(true) {
        return Some(other);
    }
    Value::maximum(&[one, other]).ok()
}
