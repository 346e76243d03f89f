//! First indices that are far out: the terms are enclosed between numbers of a fixed length, where exact ones would be
//! too long to be written down one after the other.

use num_rational::BigRational;

use super::Reach;
use super::numeric::{Arithmetic, Near, Number, Numeric};
use super::reach::Wanted;
use crate::closed_form::{Form, Recurrence, Solved};
use crate::exponential_polynomial::tail::Tail;
use crate::value::Value;

/// The terms that are looked at, at most.
const MOST_TERMS: u64 = 200_000;
/// The same where exact terms are computed in between.
const MOST_BETWEEN: u64 = 20_000;
/// So many of these at most.
const MOST_EXACT: usize = 100;

/// The first index at which a comparison holds, or that none does; otherwise before which index there is none.
pub(super) fn far(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    wanted: Wanted<'_>,
    tail: &Tail,
    stop: &dyn Fn() -> bool,
) -> Result<Reach, u64> {
    let first = follow(Numeric::<Near<192>>::of(recurrence, wanted), recurrence, tail, stop);
    let Err(before) = first else { return first };
    if before >= MOST_TERMS {
        return first;
    }
    let second = follow(Numeric::<Near<1_024>>::of(recurrence, wanted), recurrence, tail, stop);
    let Err(later) = second else { return second };
    let before = later.max(before);
    match solved.filter(|_| before < MOST_BETWEEN) {
        Some(solved) => between(solved, wanted, (before, tail), stop),
        None => Err(before),
    }
}

/// The same from an index on, where a term is computed exactly, by its form, whenever it is not known well enough.
fn between(
    solved: &Solved,
    wanted: Wanted<'_>,
    (before, tail): (u64, &Tail),
    stop: &dyn Fn() -> bool,
) -> Result<Reach, u64> {
    let recurrence = solved.recurrence();
    let of_sums = solved.forms().iter().all(|form| matches!(form, Form::Sum(..)));
    let (near, exact) = (Numeric::<Near<1_024>>::of(recurrence, wanted), Numeric::<Number>::of(recurrence, wanted));
    let (Some(mut near), Some(mut exact), true) = (near, exact, of_sums) else { return Err(before) };
    let terms = |at: i64| -> Option<Vec<BigRational>> {
        let term = |(_, place, offset): (_, usize, usize)| {
            let at = at.checked_add(i64::try_from(offset).ok()?)?;
            solved.at(&recurrence.sequences[place].name, at).ok()?.as_rational()
        };
        recurrence.terms().into_iter().map(term).collect()
    };
    let first = recurrence.from.checked_add_unsigned(before).and_then(terms).ok_or(before)?;
    near.put(&first, before).ok_or(before)?;
    let mut exactly = 0;
    for count in before..MOST_BETWEEN {
        let at = recurrence.from.checked_add_unsigned(count).ok_or(count)?;
        if let Some(never) = ended(tail, at, recurrence) {
            return Ok(never);
        }
        let holds = match near.holds() {
            Some(holds) => holds,
            None if exactly == MOST_EXACT => return Err(count),
            None => {
                exactly += 1;
                let terms = terms(at).ok_or(count)?;
                near.put(&terms, count).ok_or(count)?;
                exact.put(&terms, count).ok_or(count)?;
                exact.holds().ok_or(count)?
            }
        };
        if holds {
            return Ok(Reach::At(Value::integer(at), Vec::new()));
        }
        if stop() {
            return Err(count);
        }
        near.advance().ok_or(count + 1)?;
    }
    Err(MOST_BETWEEN)
}

/// That no later term is, where this is known of the index.
fn ended(tail: &Tail, at: i64, recurrence: &Recurrence) -> Option<Reach> {
    let Tail::Never(until, why) = tail else { return None };
    u64::try_from(at).ok().filter(|at| at >= until)?;
    Some(Reach::Never(format!("no term before {} = {at} is, and {why}", recurrence.index)))
}

fn follow<N: Arithmetic>(
    numbers: Option<Numeric<N>>,
    recurrence: &Recurrence,
    tail: &Tail,
    stop: &dyn Fn() -> bool,
) -> Result<Reach, u64> {
    let Some(mut numbers) = numbers else { return Err(0) };
    for count in 0..MOST_TERMS {
        let at = recurrence.from.checked_add_unsigned(count).ok_or(count)?;
        if let Some(never) = ended(tail, at, recurrence) {
            return Ok(never);
        }
        match numbers.holds() {
            Some(true) => return Ok(Reach::At(Value::integer(at), Vec::new())),
            Some(false) if !stop() => {}
            _ => return Err(count),
        }
        numbers.advance().ok_or(count + 1)?;
    }
    Err(MOST_TERMS)
}
