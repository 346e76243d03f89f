//! The induction written out: what the forms give at the start, and why each next term is as the recurrence says.

use std::collections::BTreeMap;

use super::readable::readable;
use super::{Comparison, Form, Piece, Sequence, Solved, compared};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

impl Solved {
    /// The steps of the induction that [`Solved::check`] made, in words: for each sequence its first terms, and one step for
    /// each piece of the forms. Of forms in products and sums it is said what the step rests on.
    pub fn induction(&self) -> Vec<String> {
        let recurrence = &self.recurrence;
        let mut lines = Vec::new();
        if !self.conditions.is_empty() {
            let conditions: Vec<String> =
                self.conditions.iter().map(|condition: &Comparison| compared(condition)).collect();
            lines.push(format!("where {}:", conditions.join(" and ")));
        }
        for sequence in &recurrence.sequences {
            for (place, start) in sequence.start.iter().enumerate() {
                let at = recurrence.from.saturating_add_unsigned(place as u64);
                lines.push(format!("start: the form gives {}({at}) = {start}, as is given", sequence.name));
            }
        }
        match self.as_pieces() {
            Some(all) => lines.extend(self.steps(&all)),
            None => lines.extend(
                self.forms.iter().zip(&recurrence.sequences).map(|(form, sequence)| self.step_in_words(form, sequence)),
            ),
        }
        lines
    }

    /// Every form by pieces, where each is.
    fn as_pieces(&self) -> Option<Vec<Vec<Piece>>> {
        let (index, from) = (&self.recurrence.index, Value::integer(self.recurrence.from));
        let pieces = |form: &Form| match form {
            Form::Pieces(pieces) => Some(pieces.clone()),
            Form::Value(early, value) if !early.is_empty() => {
                let from = from.add(&Value::integer(i64::try_from(early.len()).ok()?)).ok()?;
                Some(vec![Piece { from, until: None, form: value.clone() }])
            }
            form => Some(vec![Piece { from: from.clone(), until: None, form: form.value(index)? }]),
        };
        self.forms.iter().map(pieces).collect()
    }

    /// A step for each piece of each sequence: within it, and from it to the next.
    fn steps(&self, all: &[Vec<Piece>]) -> Vec<String> {
        let (recurrence, index) = (&self.recurrence, &self.recurrence.index);
        let mut lines = Vec::new();
        for (sequence, pieces) in recurrence.sequences.iter().zip(all) {
            let next = recurrence.term(&sequence.name, sequence.start.len());
            for (place, piece) in pieces.iter().enumerate() {
                let alone = pieces.len() == 1;
                let range = match &piece.until {
                    _ if alone && piece.from == Value::integer(recurrence.from) => String::new(),
                    None => format!(" for {} <= {index}", piece.from),
                    Some(until) => {
                        let order = i64::try_from(sequence.start.len()).unwrap_or(i64::MAX);
                        let end = until.sub(&Value::integer(order)).unwrap_or_else(|_| until.clone());
                        format!(" for {} <= {index} < {end}", piece.from)
                    }
                };
                let form = readable(&piece.form, index, &piece.from);
                lines.push(format!("step{range}: suppose {} = {form}", recurrence.term(&sequence.name, 0)));
                lines.push(format!("  {next} = {}", sequence.next));
                if let Some(image) = self.image(sequence, piece, all) {
                    lines.push(format!(
                        "  {} = {}",
                        " ".repeat(next.as_str().len()),
                        readable(&image, index, &piece.from)
                    ));
                }
                lines.push(format!("  which is the form at {index}+{}", sequence.start.len()));
                if let (Some(until), Some(later)) = (&piece.until, pieces.get(place + 1))
                    && let Ok(term) = later.form.with(index, until)
                {
                    lines.push(format!(
                        "  and from the last index before {until} it comes to {}({until}) = {term}",
                        sequence.name
                    ));
                }
            }
        }
        lines
    }

    /// What the equation gives for the forms, within a piece, as far as these lie in one.
    fn image(&self, sequence: &Sequence, piece: &Piece, all: &[Vec<Piece>]) -> Option<Value> {
        let index = &self.recurrence.index;
        let count = Value::variable(index);
        let mut known: Assumptions = self.known.clone();
        if self.recurrence.from >= 0 {
            known.assume_natural(index);
        }
        known.assume(Relation::Gte, &count, &piece.from);
        if let Some(until) = &piece.until {
            known.assume(Relation::Lss, &count.add(&Value::one()).ok()?, until);
        }
        let mut images: BTreeMap<Name, Value> = BTreeMap::new();
        for (name, place, offset) in self.recurrence.terms() {
            if !sequence.next.mentions(&name) {
                continue;
            }
            let own = self.recurrence.sequences.get(place)?.name == sequence.name;
            let form = match all.get(place)?.as_slice() {
                _ if own => &piece.form,
                [only] => &only.form,
                _ => return None,
            };
            images.insert(name, form.with(index, &count.add(&Value::integer(i64::try_from(offset).ok()?)).ok()?).ok()?);
        }
        Some(known.simplify(&sequence.next.substitute(&images).ok()?))
    }

    /// What the step of a form rests on that is no value in the index.
    fn step_in_words(&self, form: &Form, sequence: &Sequence) -> String {
        let (index, next) = (&self.recurrence.index, self.recurrence.term(&sequence.name, sequence.start.len()));
        let why = match form {
            Form::Value(..) | Form::Pieces(_) => "both sides have one normal form".to_string(),
            Form::Sum(..) => "on both sides each root has the same coefficients".to_string(),
            Form::Product(ratio, _) => {
                format!("the product has one factor more, {ratio}, and then both sides have one normal form")
            }
            Form::Nested(_) => {
                "each sum has one term more, each product one factor, and then both sides have one normal form"
                    .to_string()
            }
            Form::Turns(forms) => {
                format!("asked for each of the {} classes of indices by itself, both sides are equal", forms.len())
            }
        };
        format!("step: {next} = {} for every {index}: {why}", sequence.next)
    }
}
