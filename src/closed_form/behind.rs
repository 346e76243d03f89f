//! What is asked of late terms alone, `x(n) = 1 and n > 4`, as the same of sequences that begin there.

use super::first::Wanted;
use super::remainders::needed;
use super::{Comparison, Form, Recurrence, Sequence, Solved};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The latest term that such sequences begin with, and the same where terms have symbols.
const LATEST: i64 = 256;
const LATEST_SYMBOLIC: i64 = 8;

/// The sequences from an index on, and both sides as they are there, where a comparison holds at no index before, whatever the
/// terms are, and does not speak of the index from there on.
pub(crate) fn behind(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
) -> Option<(Recurrence, Comparison)> {
    let index = &recurrence.index;
    if ![left, right].iter().any(|side| side.mentions(index)) {
        return None;
    }
    let mut values = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
    let latest = if values.all(|value| value.as_rational().is_some()) { LATEST } else { LATEST_SYMBOLIC };
    let fails = |at: &i64| {
        let [left, right] = [left, right].map(|side| side.with(index, &Value::integer(*at)).ok());
        known.decide(relation, &left?, &right?).map(|holds| !holds)
    };
    let last = recurrence.from.checked_add(latest)?;
    let from = (recurrence.from..last).find(|at| fails(at) != Some(true))?;
    if from <= recurrence.from.max(-1) {
        return None;
    }
    let mut later = known.without_name(index);
    later.assume_natural(index);
    later.assume(Relation::Gte, &Value::variable(index), &Value::integer(from));
    let recurrence = begun_at(recurrence, from)?;
    if let Some(equation) = as_equation((relation, left, right), index, &later) {
        return Some((recurrence, equation));
    }
    let [left, right] = [left, right].map(|side| later.simplify(side));
    let free = !left.mentions(index) && !right.mentions(index);
    free.then_some((recurrence, (relation, left, right)))
}

/// `x = 0` for `-abs(x) >= 0`, and `(x,y) = (0,0)` for the same of both: what holds just where all these are 0.
fn as_equation(wanted: Wanted<'_>, index: &Name, known: &Assumptions) -> Option<Comparison> {
    let (relation, left, right) = wanted;
    let mut all = needed(wanted, known).filter(|_| relation != Relation::Eq)?;
    all.retain(|value| !value.mentions(index));
    let mut there = known.clone();
    all.iter().for_each(|value| there.assume(Relation::Eq, value, &Value::zero()));
    there.decide(relation, left, right).filter(|holds| *holds)?;
    let none = vec![Value::zero(); all.len()];
    match all.as_slice() {
        [] => None,
        [only] => Some((Relation::Eq, only.clone(), Value::zero())),
        _ => Some((Relation::Eq, Value::vector(all).ok()?, Value::vector(none).ok()?)),
    }
}

/// The forms of sequences as those of the same that begin later, checked anew.
pub(super) fn solved_behind(later: &Recurrence, solved: &Solved) -> Option<Solved> {
    let skipped = usize::try_from(later.from.checked_sub(solved.recurrence().from)?).ok()?;
    let rest = |early: &[Value]| early.iter().skip(skipped).cloned().collect::<Vec<_>>();
    let forms = solved.forms().iter().map(|form| match form {
        Form::Value(early, value) => Some(Form::Value(rest(early), value.clone())),
        Form::Sum(early, sum) => Some(Form::Sum(rest(early), sum.clone())),
        _ => None,
    });
    let conditions = solved.conditions().to_vec();
    Solved::check(later.clone(), forms.collect::<Option<_>>()?, conditions, solved.known()).ok()
}

/// The same sequences without the terms before an index.
fn begun_at(recurrence: &Recurrence, from: i64) -> Option<Recurrence> {
    let skipped = usize::try_from(from.checked_sub(recurrence.from)?).ok()?;
    let order = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max()?;
    let terms = recurrence.iterate(skipped + order).ok()?;
    let sequences = recurrence.sequences.iter().zip(terms).map(|(sequence, terms)| {
        let start = terms.into_iter().skip(skipped).take(sequence.start.len()).collect();
        Sequence { start, ..sequence.clone() }
    });
    Some(Recurrence { from, sequences: sequences.collect(), ..recurrence.clone() })
}
