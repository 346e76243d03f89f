//! Recurrences that begin at another index than 0, and forms of classes of indices: each is counted from 0 while it is solved.

use std::collections::BTreeMap;

use super::Unknown;
use crate::closed_form::{Form, Piece, Recurrence};
use crate::name::Name;
use crate::value::Value;

/// A reason that is given of a recurrence counted from 0 by an index called `(n-from)`, in the words of the recurrence itself.
pub(super) fn at_own_index(
    Unknown { reason: mut text, open, formula }: Unknown,
    recurrence: &Recurrence,
    place: &Name,
) -> Unknown {
    let (index, from) = (&recurrence.index, recurrence.from);
    if from == 0 {
        return Unknown { reason: text, open, formula };
    }
    // No other name has the brackets of this index.
    let own = |name: &Name| !name.as_str().contains(place.as_str());
    let open = open.filter(|open| open.1.variables().iter().chain(&open.2.variables()).all(own));
    for sequence in &recurrence.sequences {
        text = text.replace(&format!("{}({place}", sequence.name), &format!("{}({index}", sequence.name));
    }
    for words in ["on ", "all "] {
        text = text.replace(&format!("{words}{place}"), &format!("{words}{index}"));
    }
    // `(n-3) = 5` is n = 8.
    let equals = format!("{place} = ");
    let mut parts = text.split(&equals);
    let mut whole = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let after = part.trim_start_matches(|letter: char| letter.is_ascii_digit());
        match part.strip_suffix(after).unwrap_or_default().parse::<i64>() {
            Ok(number) => whole += &format!("{index} = {}{after}", number.saturating_add(from)),
            Err(_) => whole += &format!("{equals}{part}"),
        }
    }
    Unknown { open, ..Unknown::because(whole) }
}

/// The same recurrence, counted from 0, by an index that is called `(n-from)`.
pub(super) fn from_zero(recurrence: &Recurrence) -> Result<Recurrence, Unknown> {
    let (index, from) = (&recurrence.index, recurrence.from);
    if from == 0 {
        return Ok(recurrence.clone());
    }
    let name = Name::new(&if from > 0 { format!("({index}-{from})") } else { format!("({index}+{})", -from) });
    let mut moved = Recurrence { index: name.clone(), from: 0, sequences: recurrence.sequences.clone() };
    let pairs = recurrence.terms().into_iter().zip(moved.terms());
    let mut images: BTreeMap<Name, Value> = pairs.map(|(old, new)| (old.0, Value::variable(&new.0))).collect();
    images.insert(index.clone(), Value::variable(&name).add(&Value::integer(from))?);
    for sequence in &mut moved.sequences {
        sequence.next = sequence.next.substitute(&images)?;
    }
    Ok(moved)
}

/// A form that counts from 0 by `moved`, counted as the recurrence does.
pub(super) fn begins(form: Form, moved: &Name, recurrence: &Recurrence) -> Result<Form, Unknown> {
    let (count, from) = (Value::variable(&recurrence.index), recurrence.from);
    if from == 0 {
        return Ok(form);
    }
    match form {
        // Rounds are counted from the first index in any case.
        Form::Turns(forms) => {
            let all = forms.into_iter().map(|form| placed(form, moved, &count, 0));
            Ok(Form::Turns(all.collect::<Result<_, _>>()?))
        }
        form => placed(form, moved, &count.sub(&Value::integer(from))?, from),
    }
}

/// A form with `n - from` for n.
pub(super) fn counted_from(form: Form, index: &Name, from: i64) -> Result<Form, Unknown> {
    placed(form, index, &Value::variable(index).sub(&Value::integer(from))?, from)
}

/// A form with another value, which is less than another index by `from`, for its index.
fn placed(form: Form, index: &Name, place: &Value, from: i64) -> Result<Form, Unknown> {
    Ok(match form {
        Form::Value(early, value) => Form::Value(early, value.with(index, place)?),
        Form::Sum(early, mut sum) => {
            for _ in 0..from.abs() {
                sum = if from > 0 { sum.previous()? } else { sum.next()? };
            }
            Form::Sum(early, sum)
        }
        Form::Product(ratio, value) => Form::Product(ratio.with(index, place)?, value.with(index, place)?),
        Form::Turns(forms) => {
            let all = forms.into_iter().map(|form| placed(form, index, place, from));
            Form::Turns(all.collect::<Result<_, _>>()?)
        }
        Form::Nested(nested) => Form::Nested(nested.with_index(index, place)?),
        Form::Pieces(pieces) => Form::Pieces(moved_pieces(pieces, index, place, &Value::integer(from))?),
    })
}

/// Pieces that count from this index, counted from 0.
pub(super) fn later(pieces: Vec<Piece>, index: &Name, from: &Value) -> Result<Vec<Piece>, Unknown> {
    moved_pieces(pieces, index, &Value::variable(index).sub(from)?, from)
}

fn moved_pieces(pieces: Vec<Piece>, index: &Name, place: &Value, from: &Value) -> Result<Vec<Piece>, Unknown> {
    let moved = pieces.into_iter().map(|piece| {
        let until = piece.until.as_ref().map(|until| until.add(from)).transpose()?;
        Ok(Piece { from: piece.from.add(from)?, until, form: piece.form.with(index, place)? })
    });
    moved.collect()
}
