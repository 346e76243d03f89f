//! Forms in turn next to forms that hold at all indices: the latter are taken apart into turns, so that all are of one kind.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::{Form, Recurrence, Unchecked, check::whole, in_class};
use crate::name::Name;
use crate::value::Value;

/// Forms of which all come in turn if any does: `n` is `2*n` and `2*n + 1` in two turns.
pub(super) fn turned<'a>(forms: &'a [Form], recurrence: &Recurrence) -> Result<Cow<'a, [Form]>, Unchecked> {
    let count = forms.iter().find_map(|form| if let Form::Turns(forms) = form { Some(forms.len()) } else { None });
    let Some(count) = count.filter(|_| forms.iter().any(|form| !matches!(form, Form::Turns(_)))) else {
        return Ok(Cow::Borrowed(forms));
    };
    let mut all = Vec::new();
    for form in forms {
        let value = form.value(&recurrence.index).filter(|_| !matches!(form, Form::Pieces(_)));
        let Some(value) = value else {
            all.push(form.clone());
            continue;
        };
        let mut turns = Vec::new();
        for turn in 0..count {
            let offset = recurrence.from.saturating_add(whole(turn)?);
            turns.push(Form::Value(Vec::new(), in_class(&value, &recurrence.index, whole(count)?, offset)?));
        }
        all.push(Form::Turns(turns));
    }
    Ok(Cow::Owned(all))
}

/// Whether the forms name each term as a number, and the recurrence reads nothing but terms.
pub(super) fn only_numbers(recurrence: &Recurrence, forms: &[Form]) -> bool {
    let number = |form: &Form| match form {
        Form::Value(early, last) => early.iter().chain([last]).all(|value| value.as_rational().is_some()),
        _ => false,
    };
    let named = |form: &Form| if let Form::Turns(forms) = form { forms.iter().all(number) } else { number(form) };
    let terms: BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let started = |start: &[Value]| start.iter().all(|value| value.as_rational().is_some());
    let reads_terms = recurrence
        .sequences
        .iter()
        .all(|sequence| sequence.next.variables().is_subset(&terms) && started(&sequence.start));
    reads_terms && forms.iter().all(named)
}
