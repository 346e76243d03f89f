//! One sequence whose next term depends on that of k steps before alone: k sequences, one after the other in turn.

use super::sequences::found;
use super::{Comparison, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Sequence, in_class};

/// The form in turns, of a recurrence that begins at 0; nothing if the next term depends on others too.
pub(super) fn interleaved(
    sequence: &Sequence,
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Option<(Form, Vec<Comparison>)>, Unknown> {
    let (count, index) = (sequence.start.len(), &recurrence.index);
    if (1..count).any(|offset| sequence.next.mentions(&recurrence.term(&sequence.name, offset))) {
        return Ok(None);
    }
    let (mut forms, mut conditions) = (Vec::new(), Vec::new());
    for (turn, start) in sequence.start.iter().enumerate() {
        let (count, turn) = (i64::try_from(count).unwrap_or(i64::MAX), i64::try_from(turn).unwrap_or(i64::MAX));
        let next = in_class(&sequence.next, index, count, turn)?;
        let own = Sequence { name: sequence.name.clone(), start: vec![start.clone()], next };
        let (own, more) = found(&Recurrence { index: index.clone(), from: 0, sequences: vec![own] }, known, stop)?;
        conditions.extend(more);
        forms.extend(own);
    }
    let simple = |form: &Form| matches!(form, Form::Value(..) | Form::Sum(..) | Form::Product(..) | Form::Nested(_));
    if !forms.iter().all(simple) {
        return Err(Unknown::because(format!("its {count} parts have no simple closed forms")));
    }
    Ok(Some((Form::Turns(forms), conditions)))
}
