//! First indices that are far out: the terms are enclosed between numbers of a fixed length, where exact ones would be
//! too long to be written down one after the other.

use super::Reach;
use super::numeric::{Arithmetic, Near, Numeric};
use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::tail::Tail;
use crate::value::Value;

/// The terms that are looked at, at most.
const MOST_TERMS: u64 = 200_000;

/// The first index at which a comparison holds, or that none does; otherwise before which index there is none.
pub(super) fn far(
    recurrence: &Recurrence,
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
    second.map_err(|later| later.max(before))
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
        if let Tail::Never(until, why) = tail
            && u64::try_from(at).is_ok_and(|at| at >= *until)
        {
            return Ok(Reach::Never(format!("no term before {} = {at} is, and {why}", recurrence.index)));
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
