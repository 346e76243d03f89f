//! What keeps its value along a recurrence, or is multiplied by the same number in each step: the radius of a rotation, of
//! which the terms themselves say nothing so plain.

use std::collections::BTreeMap;

use num_traits::One;

use super::reach::{Wanted, reach};
use super::{Reach, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, term};
use crate::name::Name;
use crate::value::Value;

/// The first index at which a comparison holds of such a value and one that stays the same; none of anything else.
pub(super) fn in_ratio(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let terms = recurrence.terms();
    let reads = |value: &Value| terms.iter().any(|(name, ..)| value.mentions(name));
    let (value, bound, relation) = match (reads(left), reads(right)) {
        (true, false) => (left, right, relation),
        (false, true) => (right, left, relation.mirrored()),
        _ => return None,
    };
    let index = &recurrence.index;
    if value.as_variable().is_some() || value.mentions(index) || bound.mentions(index) {
        return None;
    }
    let (mut next, mut first) = (BTreeMap::new(), BTreeMap::new());
    for (name, place, offset) in &terms {
        let sequence = &recurrence.sequences[*place];
        first.insert(name.clone(), sequence.start[*offset].clone());
        let later = match offset + 1 < sequence.start.len() {
            true => Value::variable(&recurrence.term(&sequence.name, offset + 1)),
            false => sequence.next.clone(),
        };
        next.insert(name.clone(), later);
    }
    let later = value.substitute(&next).ok()?;
    let ratio = later.div(value).ok()?.as_rational()?;
    if !later.sub(&value.scale(&ratio).ok()?).ok()?.is_zero() {
        return None;
    }
    let start = value.substitute(&first).ok()?;
    if ratio.is_one() {
        let reason = format!("{value} is {start} at every {index}");
        return match known.decide(relation, &start, bound)? {
            true => Some(Reach::At(Value::integer(recurrence.from), Vec::new())),
            false => Some(Reach::Never(reason)),
        };
    }
    let name = Name::new("[value]");
    let own = Value::variable(&term(&name, index, 0));
    let sequence = Sequence { name, start: vec![start], next: own.scale(&ratio).ok()? };
    let alone = Recurrence { index: index.clone(), from: recurrence.from, sequences: vec![sequence] };
    let solved = solve_until(alone.clone(), known, stop).ok();
    match reach(&alone, solved.as_ref(), (relation, &own, bound), known, stop) {
        Reach::Unknown(_) => None,
        Reach::Never(reason) => {
            let times = format!("{value} is multiplied by {ratio} in each step");
            let plain = !reason.contains('[');
            Some(Reach::Never(if plain { format!("{times}: {reason}") } else { times }))
        }
        found => Some(found),
    }
}
