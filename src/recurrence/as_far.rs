//! The first legs of a motion that has no form as a whole: one that goes back and forth for ever at a symbolic speed.

use super::Unknown;
use super::modes::first_modes;
use super::rotation::with_signs;
use super::switching::first_switches;
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Solved};
use crate::value::Value;

/// The forms of the first legs, the reason why they end, and the index where they do.
pub(super) type FirstLegs = (Vec<Form>, Value, String);

/// Forms of a recurrence as far as they are known, where it goes through modes or its maxima and conditions change.
///
/// # Errors
/// What would have to be known for the first leg, if there is none for that reason.
pub fn as_far_as(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Solved, Option<Unknown>> {
    if recurrence.from != 0 || recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        return Err(None);
    }
    let known = &with_signs(recurrence, known.without_name(&recurrence.index));
    let checked = |(forms, last, reason): FirstLegs| {
        let solved = Solved::as_far_as(recurrence, forms, (last, reason), known).ok();
        solved.filter(|solved| solved.conditions().is_empty()).ok_or(None)
    };
    first_modes(recurrence, known, stop).and_then(checked).or_else(|why| {
        let by_switches = first_switches(recurrence, known, stop).and_then(checked);
        by_switches.map_err(|other| why.or(other))
    })
}
