//! Why a function of the index is in an interval at no index, in a clause: it moves away from it, it goes to a limit that is no
//! nearer, or it is bounded by its parts.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::affine::{Shape, shape};
use super::search::Entry;
use crate::assumption::Assumptions;
use crate::exponential_polynomial::exponentials;
use crate::value::{Relation, Value};

/// What is asked, of no index, and why, where that is one of these; the index is known to be one of those that are asked for.
pub(super) fn for_none(entry: &Entry<'_>, known: &Assumptions) -> String {
    let goal = format!("{} for no {}", entry.goal(&entry.value), entry.index);
    [true, false].iter().find_map(|low| why(entry, *low, known)).map_or(goal.clone(), |why| format!("{goal}: {why}"))
}

/// Why it stays below what bounds the interval from below (`low`), or above what bounds it from above.
fn why(entry: &Entry<'_>, low: bool, known: &Assumptions) -> Option<String> {
    let (bound, strict) = entry.interval.bound(low)?;
    let beyond = match (low, strict) {
        (true, true) => Relation::Lte,
        (true, false) => Relation::Lss,
        (false, true) => Relation::Gte,
        (false, false) => Relation::Gtr,
    };
    let outside = |value: &Value, known: &Assumptions| known.decide(beyond, value, bound) == Some(true);
    let (value, index, from) = (&entry.value, entry.index, entry.from);
    let start = known.simplify(&value.with(index, from).ok()?);
    if outside(&start, entry.known) {
        let next = value.with(index, &Value::variable(index).add(&Value::one()).ok()?).ok()?;
        let step = known.simplify(&next.sub(value).ok()?);
        let (away, verb) = if low { (Relation::Lte, "grow") } else { (Relation::Gte, "fall") };
        if known.decide(away, &step, &Value::zero()) == Some(true) {
            return Some(format!("it is {start} at {index} = {from} and does not {verb} from there on"));
        }
        if let Ok(Shape::Geometric { limit, ratio, .. }) = shape(value, index)
            && known.decide(Relation::Gtr, &ratio, &Value::zero()) == Some(true)
            && known.decide(Relation::Lss, &ratio, &Value::one()) == Some(true)
            && known.decide(if low { Relation::Lte } else { Relation::Gte }, &limit, bound) == Some(true)
        {
            return Some(format!("it goes from {start} at {index} = {from} to {limit} and stays between them"));
        }
    }
    let most = by_parts(entry, low)?;
    outside(&most, known).then(|| format!("it is at {} {most}", if low { "most" } else { "least" }))
}

/// A number that it is never above (`above`), or never below, if its parts are numbers times powers that do not grow.
fn by_parts(entry: &Entry<'_>, above: bool) -> Option<Value> {
    let from = entry.from.as_rational()?.to_integer().to_i32().filter(|from| *from >= 0)?;
    let mut sum = BigRational::zero();
    for (base, coefficients) in exponentials(&entry.value, entry.index)? {
        let ([coefficient], base) = (coefficients.as_slice(), base.as_rational()?) else { return None };
        let number = coefficient.as_rational()?;
        if base.abs() > BigRational::one() || base.is_zero() {
            return None;
        }
        if base.is_one() {
            sum += number;
        } else if base.is_negative() || number.is_positive() == above {
            // A positive power comes down to 0, and a negative one comes to either side.
            let size = number.abs() * base.abs().pow(from);
            sum += if above { size } else { -size };
        }
    }
    Some(Value::rational(sum))
}
