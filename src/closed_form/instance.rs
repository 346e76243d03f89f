//! What holds for every value of a parameter holds for one.

use super::{Comparison, Form, Piece, Recurrence, Sequence, Solved, Unchecked};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Value, ValueError};

impl Solved {
    /// The same for a value of a parameter, in which no division stands, so that it has a meaning wherever it is asked for.
    /// All that was assumed of the parameter must follow for the value from what is known of it and from the conditions.
    ///
    /// # Errors
    /// Where it does not, or a form is a product, or a sum over such.
    pub fn instance(&self, name: &Name, value: &Value, known: &Assumptions) -> Result<Solved, Unchecked> {
        if self.as_far.is_some() {
            return Err(Unchecked("the forms are not known for every index".to_string()));
        }
        let recurrence = &self.recurrence;
        let own = recurrence.terms();
        let bound = |other: &Name| *other == recurrence.index || own.iter().any(|(term, ..)| term == other);
        if value.variables().iter().any(|other| bound(other) || other == name) || !value.needs().is_empty() {
            return Err(Unchecked(format!("{value} is no value for {name}")));
        }
        let put = |one: &Value| one.with(name, value);
        let conditions = self.conditions.iter().map(|(relation, left, right)| Ok((*relation, put(left)?, put(right)?)));
        let conditions = conditions.collect::<Result<Vec<Comparison>, ValueError>>()?;
        let known = known.without_name(&recurrence.index);
        let mut here = known.clone();
        conditions.iter().for_each(|(relation, left, right)| here.assume(*relation, left, right));
        for (relation, zero) in self.known.iter() {
            if here.decide(relation, &put(&zero)?, &Value::zero()) != Some(true) {
                return Err(Unchecked(format!("{zero} {} 0 is not known where {name} = {value}", relation.symbol())));
            }
        }
        if self.known.naturals().iter().any(|natural| natural == name || !known.naturals().contains(natural)) {
            return Err(Unchecked(format!("{value} is not known to be natural")));
        }
        let sequences = recurrence.sequences.iter().map(|sequence| {
            let start = sequence.start.iter().map(put).collect::<Result<_, _>>()?;
            Ok(Sequence { name: sequence.name.clone(), start, next: put(&sequence.next)? })
        });
        let sequences = sequences.collect::<Result<_, ValueError>>()?;
        let recurrence = Recurrence { index: recurrence.index.clone(), from: recurrence.from, sequences };
        let forms = self.forms.iter().map(|form| with(form, &recurrence.index, (name, value)));
        let forms = forms.collect::<Result<_, _>>()?;
        Ok(Solved { recurrence, forms, conditions, known: here, as_far: None })
    }
}

/// A form with a value in place of a parameter.
fn with(form: &Form, index: &Name, (name, value): (&Name, &Value)) -> Result<Form, Unchecked> {
    let put = |one: &Value| one.with(name, value);
    let other = || Unchecked("a form of another kind has no instances here".to_string());
    Ok(match form {
        Form::Value(early, last) => Form::Value(early.iter().map(put).collect::<Result<_, _>>()?, put(last)?),
        Form::Sum(early, sum) => {
            let last = sum.value(index).ok_or_else(other)?;
            Form::Value(early.iter().map(put).collect::<Result<_, _>>()?, put(&last)?)
        }
        Form::Pieces(pieces) => {
            let piece = |piece: &Piece| {
                let until = piece.until.as_ref().map(put).transpose()?;
                Ok::<_, ValueError>(Piece { from: put(&piece.from)?, until, form: put(&piece.form)? })
            };
            Form::Pieces(pieces.iter().map(piece).collect::<Result<_, _>>()?)
        }
        Form::Turns(forms) => {
            let all = forms.iter().map(|form| with(form, index, (name, value)));
            Form::Turns(all.collect::<Result<_, _>>()?)
        }
        Form::Product(..) | Form::Nested(_) => return Err(other()),
    })
}
