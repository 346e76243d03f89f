//! The first index at which a sequence that is neither linear nor geometric lies in an interval: of its late terms one part
//! outgrows all others, or it moves one way only; the terms before are looked at one by one.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::powers::Numbers;
use super::search::{Entry, whole};
use super::{Reach, Unknown};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{Tail, first_by_halves, outside, tail};
use crate::value::{Relation, Value};

/// Terms that are looked at one by one where nothing is known of the late ones.
const MOST_TERMS: u64 = 2_000;

/// The answer, where the sequence is a sum of exponentials and polynomials with numbers in it.
pub(super) fn outgrown(entry: &Entry) -> Option<Result<Reach, Unknown>> {
    let sum = ExponentialPolynomial::of(&entry.value, entry.index)?;
    let numbers = entry.interval.numbers()?;
    let from = entry.from.as_rational().filter(BigRational::is_integer)?.to_u64()?;
    let beyond = |bound: &BigRational| beyond(&sum, bound, entry);
    match never(&beyond, &numbers, from)? {
        Tail::Never(end, why) => Some(match first(&sum, &numbers, from, end)? {
            Some(at) => entry.before_end(whole(at), Vec::new()),
            None if end == from => Ok(Reach::Never(why)),
            None => Ok(Reach::Never(format!("no term before {} = {end} is, and {why}", entry.index))),
        }),
        Tail::Unknown(_) => {
            let at =
                by_halves(&beyond, &numbers, from).or_else(|| first(&sum, &numbers, from, from + MOST_TERMS).flatten());
            at.map(|at| entry.before_end(whole(at), Vec::new()))
        }
    }
}

/// From which index on no term lies between the numbers, where one of its sides says so.
fn never(beyond: &Beyond<'_>, numbers: &Numbers, from: u64) -> Option<Tail> {
    let mut found = Tail::Unknown(String::new());
    let point = matches!((&numbers.low, &numbers.high), (Some((low, _)), Some((high, _))) if low == high);
    let low = numbers.low.as_ref().map(|bound| (bound, Relation::Gte, Relation::Gtr));
    let high = numbers.high.as_ref().map(|bound| (bound, Relation::Lte, Relation::Lss));
    for ((bound, strict), shut, open) in low.into_iter().chain(high) {
        let relation = match (point, strict) {
            (true, _) => Relation::Eq,
            (false, true) => open,
            (false, false) => shut,
        };
        if let Tail::Never(end, why) = tail(&beyond(bound)?, relation, from)
            && !matches!(&found, Tail::Never(other, _) if *other <= end)
        {
            found = Tail::Never(end, why);
        }
    }
    if let (Tail::Unknown(_), Some((low, _)), Some((high, _)), false) = (&found, &numbers.low, &numbers.high, point) {
        let two = BigRational::from_integer(2.into());
        found = outside(&beyond(&((low + high) / &two))?, &((high - low) / two), from);
    }
    Some(found)
}

/// By how much the terms are above a number.
type Beyond<'a> = dyn Fn(&BigRational) -> Option<ExponentialPolynomial> + 'a;

fn beyond(sum: &ExponentialPolynomial, bound: &BigRational, entry: &Entry) -> Option<ExponentialPolynomial> {
    sum.plus(&ExponentialPolynomial::of(&Value::rational(-bound), entry.index)?).ok()
}

/// The first of some terms between the numbers; nothing where a term is no number.
fn first(sum: &ExponentialPolynomial, numbers: &Numbers, from: u64, end: u64) -> Option<Option<u64>> {
    for at in from..end {
        let term = sum.at(at).ok()?.as_rational()?;
        if numbers.above_low(&term) && numbers.below_high(&term) {
            return Some(Some(at));
        }
    }
    Some(None)
}

/// The first term beyond one bound, where there is one bound and the terms move one way only.
fn by_halves(beyond: &Beyond<'_>, numbers: &Numbers, from: u64) -> Option<u64> {
    let ((bound, strict), shut, open) = match (&numbers.low, &numbers.high) {
        (Some(low), None) => (low, Relation::Gte, Relation::Gtr),
        (None, Some(high)) => (high, Relation::Lte, Relation::Lss),
        _ => return None,
    };
    first_by_halves(&beyond(bound)?, if *strict { open } else { shut }, from, &|| false)
}
