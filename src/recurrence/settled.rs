//! Sequences of which some come to their last form only after a start, such as `y(n+1) = max(y(n)-1,0)`: the recurrence is
//! solved from the index on at which these have, and its first terms are put before.

use num_integer::Integer;
use num_traits::{Signed, ToPrimitive, Zero};

use super::Unknown;
use super::parts::parts;
use super::sequences::{of_one_term_each, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Sequence, Solved};
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
    let with = |early: &[Value]| first.iter().chain(early).cloned().collect::<Vec<_>>();
    Some(match form {
        Form::Value(early, value) => Form::Value(before(with(early), Some(value), index), value.clone()),
        Form::Sum(early, sum) => Form::Sum(before(with(early), sum.value(index).as_ref(), index), sum.clone()),
        Form::Turns(turns) => {
            let each = (0..turns.len()).map(|place| turn(turns, place, first, index));
            Form::Turns(each.collect::<Option<_>>()?)
        }
        Form::Pieces(pieces) => Form::Pieces(of_one_term_each(first).chain(pieces.iter().cloned()).collect()),
        Form::Product(..) | Form::Nested(_) => return None,
    })
}

/// The form at every so manyth index from this place on, of turns that are counted from behind the first terms.
fn turn(turns: &[Form], place: usize, first: &[Value], index: &Name) -> Option<Form> {
    let (count, start) = (turns.len(), first.len());
    // The turn in which this place is, counted from the later start, and how many rounds it is behind.
    let turn = (place + count * start - start).mod_floor(&count);
    let rounds = (start + turn).checked_sub(place)?.checked_div(count)?;
    let own: Vec<Value> = first.iter().skip(place).step_by(count).cloned().collect();
    if own.len() != rounds {
        return None;
    }
    // Each turn by itself is a sequence that begins with its own terms, and is counted so.
    let counted = match turns.get(turn)? {
        Form::Value(early, value) => {
            let behind = Value::variable(index).sub(&Value::integer(i64::try_from(rounds).ok()?)).ok()?;
            Form::Value(early.clone(), value.with(index, &behind).ok()?)
        }
        Form::Sum(early, sum) => {
            Form::Sum(early.clone(), (0..rounds).try_fold(sum.clone(), |sum, _| sum.previous().ok())?)
        }
        _ => return None,
    };
    begun(&counted, &own, index)
}

/// First terms without the last of them that are what is said of all later ones.
fn before(mut early: Vec<Value>, later: Option<&Value>, index: &Name) -> Vec<Value> {
    let said = |place: usize| later?.with(index, &Value::integer(i64::try_from(place).ok()?)).ok();
    while let Some(last) = early.last()
        && said(early.len() - 1).as_ref() == Some(last)
    {
        early.pop();
    }
    early
}
