//! Sequences of which some come to their last form only after a start, such as `y(n+1) = max(y(n)-1,0)`: the recurrence is
//! solved from the index on at which these have, and its first terms are put before.

use num_integer::Integer;
use num_traits::{Signed, ToPrimitive, Zero};

use super::Unknown;
use super::parts::parts;
use super::sequences::solve_until;
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Sequence, Solved};
use crate::name::Name;
use crate::value::{Atom, Value};

/// The latest start that is looked at.
const MOST_START: usize = 200;
/// The longest terms of it, in bits.
const MOST_BITS: u64 = 2_000;

/// The forms of a recurrence from a later index on, with the terms before; nothing where nothing settles, or it has none then
/// either. `reason`: why it has none from its own index on.
pub(super) fn after_a_start(
    recurrence: &Recurrence,
    reason: &Unknown,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Solved> {
    if recurrence.sequences.len() < 2 || recurrence.from != 0 {
        return None;
    }
    let all = parts(recurrence, reason, known, stop);
    let forms = all.iter().filter_map(|part| part.found.as_ref().ok()).flat_map(|solved| solved.forms());
    let late = forms.map(since).collect::<Option<Vec<usize>>>()?.into_iter();
    let conditions = recurrence.sequences.iter().flat_map(|one| thresholds(&one.next, &recurrence.index));
    let late = late.chain(conditions.map(|(_, since, _)| since));
    let start = late.max().filter(|start| (1..=MOST_START).contains(start))?;
    let longest = recurrence.sequences.iter().map(|one| one.start.len()).max()?;
    let terms = recurrence.iterate(start + longest).ok()?;
    if terms.iter().flatten().any(|term| term.bits() > MOST_BITS) || stop() {
        return None;
    }
    let own = |(one, terms): (&Sequence, &Vec<Value>)| {
        let next = decided(&one.next, &recurrence.index)?;
        Some(Sequence { start: terms.get(start..start + one.start.len())?.to_vec(), next, ..one.clone() })
    };
    let sequences = recurrence.sequences.iter().zip(&terms).map(own).collect::<Option<_>>()?;
    let from = i64::try_from(start).ok()?;
    let solved = solve_until(Recurrence { from, sequences, ..recurrence.clone() }, known, stop).ok()?;
    let whole = solved.forms().iter().zip(&terms).map(|(form, terms)| begun(form, &terms[..start], &recurrence.index));
    Solved::check(recurrence.clone(), whole.collect::<Option<_>>()?, solved.conditions().to_vec(), known).ok()
}

/// From which index on a form is of one kind; nothing where that is not a number.
fn since(form: &Form) -> Option<usize> {
    match form {
        Form::Value(early, _) | Form::Sum(early, _) => Some(early.len()),
        Form::Turns(turns) => {
            let behind =
                |(place, early): (usize, usize)| early.checked_sub(1).map_or(0, |last| last * turns.len() + place + 1);
            let each = turns.iter().map(since).collect::<Option<Vec<usize>>>()?;
            each.into_iter().enumerate().map(behind).max()
        }
        Form::Pieces(pieces) => pieces.last()?.from.as_rational()?.to_usize(),
        Form::Product(..) | Form::Nested(_) => Some(0),
    }
}

/// The conditions of a value on the index alone, each with the index from which on it is what it remains, and that.
fn thresholds(value: &Value, index: &Name) -> Vec<(Atom, usize, bool)> {
    let of = |atom: Atom| {
        let Atom::Positive(inner) = &atom else { return None };
        let (factor, rest) = inner.linear_in(index)?;
        let (factor, rest) = (factor.as_rational()?, rest.as_rational()?);
        let at = (!factor.is_zero()).then(|| -rest / &factor)?;
        let since = if at.is_negative() { 0 } else { at.to_integer().to_usize()?.checked_add(1)? };
        Some((atom, since, factor.is_positive()))
    };
    value.atoms().into_iter().filter_map(of).collect()
}

/// A value with these conditions as they remain.
fn decided(value: &Value, index: &Name) -> Option<Value> {
    thresholds(value, index).iter().try_fold(value.clone(), |value, (atom, _, holds)| {
        value.with_atom(atom, &if *holds { Value::one() } else { Value::zero() }).ok()
    })
}

/// A form from a later index on with the terms before it.
fn begun(form: &Form, first: &[Value], index: &Name) -> Option<Form> {
    let plain = |form: Form| without_same(form, index);
    let start = first.len();
    let before = |early: &[Value]| first.iter().chain(early).cloned().collect::<Vec<_>>();
    Some(match form {
        Form::Value(early, value) => plain(Form::Value(before(early), value.clone())),
        Form::Sum(early, sum) => plain(Form::Sum(before(early), sum.clone())),
        Form::Turns(turns) => {
            let count = turns.len();
            let each = (0..count).map(|place| {
                // The turn in which this place is, counted from the later start, and how many rounds it is behind.
                let turn = (place + count * start - start).mod_floor(&count);
                let rounds = (start + turn).checked_sub(place)?.checked_div(count)?;
                let own: Vec<Value> = first.iter().skip(place).step_by(count).cloned().collect();
                if own.len() != rounds {
                    return None;
                }
                let before = |early: &[Value]| own.iter().chain(early).cloned().collect::<Vec<_>>();
                match turns.get(turn)? {
                    Form::Value(early, value) => {
                        let behind = Value::variable(index).sub(&Value::integer(i64::try_from(rounds).ok()?)).ok()?;
                        Some(plain(Form::Value(before(early), value.with(index, &behind).ok()?)))
                    }
                    Form::Sum(early, sum) => {
                        let behind = (0..rounds).try_fold(sum.clone(), |sum, _| sum.previous().ok())?;
                        Some(plain(Form::Sum(before(early), behind)))
                    }
                    _ => None,
                }
            });
            Form::Turns(each.collect::<Option<_>>()?)
        }
        Form::Pieces(pieces) => {
            let at = |place: usize| i64::try_from(place).map(Value::integer).ok();
            let one = |(place, term): (usize, &Value)| {
                Some(Piece { from: at(place)?, until: Some(at(place + 1)?), form: term.clone() })
            };
            let own = first.iter().enumerate().map(one).collect::<Option<Vec<_>>>()?;
            Form::Pieces(own.into_iter().chain(pieces.iter().cloned()).collect())
        }
        Form::Product(..) | Form::Nested(_) => return None,
    })
}

/// A form without first terms that are what it says of all later ones.
fn without_same(form: Form, index: &Name) -> Form {
    let value = form_of_later(&form, index);
    let same = |early: &mut Vec<Value>| {
        let says = |early: &Vec<Value>| {
            let place = Value::integer(i64::try_from(early.len()).ok()? - 1);
            value.as_ref()?.with(index, &place).ok().filter(|value| Some(value) == early.last())
        };
        while says(early).is_some() {
            early.pop();
        }
    };
    match form {
        Form::Value(mut early, value) => {
            same(&mut early);
            Form::Value(early, value)
        }
        Form::Sum(mut early, sum) => {
            same(&mut early);
            Form::Sum(early, sum)
        }
        form => form,
    }
}

fn form_of_later(form: &Form, index: &Name) -> Option<Value> {
    match form {
        Form::Value(_, value) => Some(value.clone()),
        Form::Sum(_, sum) => sum.value(index),
        _ => None,
    }
}
