//! Sequences whose conditions compare them with each other, as of a pursuit, `if x(n) < y(n) then x(n)+v else x(n)`: with what
//! lies between them as a sequence in place of one of them, the conditions are of that one alone.

use super::Unknown;
use super::exact::of_difference;
use super::sequences::{Found, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Form, Recurrence, Sequence, Solved, term};
use crate::name::Name;
use crate::value::{Atom, Value};

/// The most sequences of which one is replaced.
const MOST: usize = 6;

/// The forms of all sequences by what lies between two of them; otherwise why none are known, which may be that something
/// must be known of that.
pub(super) fn by_difference(
    recurrence: &Recurrence,
    reason: Unknown,
    (known, stop): (&Assumptions, &dyn Fn() -> bool),
    checked: &dyn Fn(Found) -> Result<Solved, Unknown>,
) -> Result<Solved, Unknown> {
    let several = (2..=MOST).contains(&recurrence.sequences.len());
    if !several || recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        return Err(reason);
    }
    let Some(between) = between(recurrence) else { return Err(reason) };
    for place in 0..recurrence.sequences.len() {
        let Some((replaced, back)) = with_between(recurrence, &between, place) else { continue };
        match solve_until(replaced, known, stop) {
            Ok(solved) => {
                if let Some(found) = put_back(recurrence, &solved, (place, &back), known)
                    && let Ok(solved) = checked(found)
                {
                    return Ok(solved);
                }
            }
            Err(asked) if asked.open.as_ref().is_some_and(|open| of_parameters(open)) => return Err(asked),
            Err(_) => {}
        }
    }
    Err(reason)
}

/// Whether something is asked of parameters alone, and not of what lies between: that has no name in the question.
fn of_parameters((_, left, right): &Comparison) -> bool {
    left.variables().iter().chain(&right.variables()).all(|name| !name.as_str().contains(BETWEEN))
}

/// What lies between is called so: no name of a question.
const BETWEEN: &str = "[between]";

/// What lies between sequences: what conditions and maxima of two or more of them are of, without what is free of them.
fn between(recurrence: &Recurrence) -> Option<Value> {
    let names: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let mut inner = Vec::new();
    for sequence in &recurrence.sequences {
        for atom in sequence.next.atoms() {
            match atom {
                Atom::Positive(value) => inner.push(value),
                Atom::Maximum(parts) => inner.extend(parts.iter().cloned()),
                _ => {}
            }
        }
    }
    inner.into_iter().find_map(|value| {
        let read: Vec<&Name> = names.iter().filter(|name| value.mentions(name)).collect();
        if read.len() < 2 {
            return None;
        }
        let mut sum = Value::zero();
        for name in read {
            let (factor, _) = value.linear_in(name)?;
            factor.as_rational()?;
            sum = sum.add(&factor.mul(&Value::variable(name)).ok()?).ok()?;
        }
        Some(sum)
    })
}

/// The system with what lies between in place of one sequence, and that one by it; none where its next value, or a
/// condition, depends on others.
fn with_between(recurrence: &Recurrence, between: &Value, place: usize) -> Option<(Recurrence, Value)> {
    let index = &recurrence.index;
    let own = recurrence.term(&recurrence.sequences[place].name, 0);
    let name = Name::new(BETWEEN);
    let other = term(&name, index, 0);
    let (factor, rest) = between.linear_in(&own)?;
    factor.as_rational().filter(|factor| !num_traits::Zero::is_zero(factor))?;
    let back = Value::variable(&other).sub(&rest).ok()?.div(&factor).ok()?;
    let mut next = between.clone();
    let mut start = between.clone();
    let marks: Vec<Name> = (0..recurrence.sequences.len()).map(|place| Name::new(&format!("[next {place}]"))).collect();
    for (sequence, mark) in recurrence.sequences.iter().zip(&marks) {
        let term = recurrence.term(&sequence.name, 0);
        next = next.with(&term, &Value::variable(mark)).ok()?;
        start = start.with(&term, sequence.start.first()?).ok()?;
    }
    for (sequence, mark) in recurrence.sequences.iter().zip(&marks) {
        next = next.with(mark, &sequence.next).ok()?;
    }
    let mut sequences = Vec::new();
    for (number, sequence) in recurrence.sequences.iter().enumerate() {
        let (name, start, next) = if number == place {
            (name.clone(), vec![start.clone()], &next)
        } else {
            (sequence.name.clone(), sequence.start.clone(), &sequence.next)
        };
        sequences.push(Sequence { name, start, next: next.with(&own, &back).ok()? });
    }
    let replaced = Recurrence { sequences, ..recurrence.clone() };
    let alone = &replaced.sequences[place].next;
    let terms = replaced.terms();
    let depends = terms.iter().any(|(name, number, _)| *number != place && alone.mentions(name));
    (!depends).then_some((replaced, back))
}

/// The forms of the sequences themselves.
fn put_back(
    recurrence: &Recurrence,
    solved: &Solved,
    (place, back): (usize, &Value),
    known: &Assumptions,
) -> Option<Found> {
    let used = solved.recurrence().terms().into_iter().filter(|(name, _, offset)| *offset == 0 && back.mentions(name));
    let used: Vec<(Name, usize)> = used.map(|(name, number, _)| (name, number)).collect();
    let mut known = known.clone();
    solved.conditions().iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    let pieces = of_difference(solved, back, &used, &known)?;
    let mut forms = solved.forms().to_vec();
    *forms.get_mut(place)? = match pieces.as_slice() {
        [only] => Form::Value(Vec::new(), only.form.clone()),
        _ => Form::Pieces(pieces),
    };
    (forms.len() == recurrence.sequences.len()).then(|| (forms, solved.conditions().to_vec()))
}
