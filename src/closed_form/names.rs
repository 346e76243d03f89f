//! Which names may stand where in forms, first values and conditions.

use std::collections::BTreeSet;

use super::check::failed;
use super::{Comparison, Form, Recurrence, Unchecked, layer, product};
use crate::name::Name;
use crate::value::Value;

/// First values, conditions and the ends of pieces are free of the index, and nothing but an equation has terms in it.
pub(super) fn names(recurrence: &Recurrence, forms: &[Form], conditions: &[Comparison]) -> Result<(), Unchecked> {
    let terms: BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let bound = forms.iter().map(most_layers).max().unwrap_or(0);
    let bound: BTreeSet<Name> = (0..bound).map(layer).chain([product(), recurrence.index.clone()]).collect();
    let fixed = |value: &Value| {
        let variables = value.variables();
        variables.is_disjoint(&bound) && variables.is_disjoint(&terms)
    };
    let starts = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
    let sides = conditions.iter().flat_map(|(_, left, right)| [left, right]);
    if !starts.chain(sides).all(fixed) {
        return Err(failed("a first value or condition depends on the index"));
    }
    let mut rest: Vec<&Form> = forms.iter().collect();
    while let Some(form) = rest.pop() {
        let free = |value: &Value| value.variables().is_disjoint(&terms);
        let fine = match form {
            Form::Value(early, value) => early.iter().all(fixed) && free(value) && !value.mentions(&product()),
            Form::Sum(early, sum) => {
                early.iter().all(fixed) && sum.parts().all(|(_, rows)| rows.iter().flatten().all(fixed))
            }
            Form::Product(ratio, value) => free(ratio) && free(value),
            Form::Nested(nested) => {
                // A layer reads those before it alone.
                let later =
                    |count: usize, value: &Value| (count..nested.layers.len()).any(|at| value.mentions(&layer(at)));
                nested.early.iter().all(fixed)
                    && nested
                        .values()
                        .all(|(count, value)| free(value) && !value.mentions(&product()) && !later(count, value))
            }
            Form::Turns(forms) => {
                rest.extend(forms);
                true
            }
            Form::Pieces(pieces) => {
                let ends = pieces.iter().flat_map(|piece| [Some(&piece.from), piece.until.as_ref()]).flatten();
                ends.into_iter().all(fixed) && pieces.iter().all(|piece| free(&piece.form))
            }
        };
        if !fine {
            return Err(failed("the form depends on what it may not depend on"));
        }
    }
    Ok(())
}

/// The most layers of a form, or of one of its turns.
fn most_layers(form: &Form) -> usize {
    match form {
        Form::Nested(nested) => nested.layers.len(),
        Form::Turns(forms) => forms.iter().map(most_layers).max().unwrap_or(0),
        _ => 0,
    }
}
