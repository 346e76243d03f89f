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
        Form::Value(early, last) => early.iter().chain([last]).all(|value| value.variables().is_empty()),
        _ => false,
    };
    let named = |form: &Form| if let Form::Turns(forms) = form { forms.iter().all(number) } else { number(form) };
    let terms: BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let started = |start: &[Value]| start.iter().all(|value| value.variables().is_empty());
    let reads_terms = recurrence
        .sequences
        .iter()
        .all(|sequence| sequence.next.variables().is_subset(&terms) && started(&sequence.start));
    reads_terms && forms.iter().all(named)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assumption::Assumptions;
    use crate::closed_form::{Sequence, Solved, term};

    fn accepted(start: i64, next: impl Fn(&Value) -> Value, form: Form) -> bool {
        let index = Name::new("n");
        let next = next(&Value::variable(&term(&Name::new("f"), &index, 0)));
        let sequences = vec![Sequence { name: Name::new("f"), start: vec![Value::integer(start)], next }];
        let recurrence = Recurrence { index, from: 0, sequences };
        Solved::check(recurrence, vec![form], Vec::new(), &Assumptions::default()).is_ok()
    }

    #[test]
    fn steps_that_divide_are_made_with_numbers() {
        let one = Value::one;
        let map = |term: &Value| one().div(&one().sub(term).unwrap()).unwrap();
        let plain = |number: Value| Form::Value(Vec::new(), number);
        let third = |numbers: [(i64, i64); 3]| {
            Form::Turns(numbers.map(|(top, below)| plain(Value::fraction(top, below).unwrap())).to_vec())
        };
        assert!(accepted(3, map, third([(3, 1), (-1, 2), (2, 3)])));
        assert!(!accepted(3, map, third([(3, 1), (-1, 2), (3, 4)])), "a wrong turn");
        assert!(!accepted(3, map, third([(3, 1), (2, 3), (-1, 2)])), "turns in another order");
        assert!(!accepted(1, map, third([(1, 1), (1, 1), (1, 1)])), "1 has no next term");
        assert!(!accepted(0, map, Form::Value(vec![Value::zero()], one())), "nor has 0 after one step");
        assert!(!accepted(1, map, plain(one())), "it stays at what has no next term");
        let with_parameter = |term: &Value| Value::variable(&Name::new("a")).div(term).unwrap();
        assert!(!accepted(1, with_parameter, plain(one())), "a is not known");
        let halved = |term: &Value| Value::integer(6).div(&one().add(term).unwrap()).unwrap();
        assert!(accepted(2, halved, plain(Value::integer(2))));
        assert!(!accepted(2, halved, plain(Value::integer(-3))), "the step holds, the start does not");
    }
}
