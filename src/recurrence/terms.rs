//! The first terms of a sequence whose exact terms grow too long to write: first exactly, then between two numbers.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::value::{Atom, Value};

/// A term.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Term {
    /// Exactly.
    Exact(Value),
    /// Between two numbers.
    Between(BigRational, BigRational),
}

/// The most bits of a term that is computed exactly, and of the whole part of any.
const MOST_BITS: u64 = 2_000;
/// The most parts of a term with symbols: a longer one says nothing to a reader, and takes long to compute.
const MOST_SIZE: usize = 120;
/// The bits to which bounds are rounded.
const PRECISION: u64 = 600;
/// The most bits of a power of bounds.
const LONGEST: u64 = 200_000;
/// The longest text of an exact term.
const WIDEST: usize = 40;
/// The digits of other terms.
const DIGITS: usize = 10;

type Bounds = (BigRational, BigRational);

/// The first terms of every sequence, as many as can be computed and are not too long.
pub(super) fn listed(
    recurrence: &Recurrence,
    count: usize,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<Vec<Term>> {
    let first = |value: &Value| Term::Exact(known.simplify(value));
    let starts = recurrence.sequences.iter().map(|sequence| sequence.start.iter().map(first).collect());
    let mut all: Vec<Vec<Term>> = starts.collect();
    let mut exact = true;
    let mut step = 0;
    while all.iter().any(|terms| terms.len() < count) && !stop() {
        let next = exact.then(|| exactly(recurrence, &all, step, known)).flatten();
        exact = next.as_ref().is_some_and(|next| next.iter().all(short));
        let bounds = |(low, high)| Term::Between(low, high);
        let bounded = || Some(bounded(recurrence, &all, step)?.into_iter().map(bounds).collect());
        let Some(next) = next.or_else(bounded) else { break };
        all.iter_mut().zip(next).for_each(|(terms, next)| terms.push(next));
        step += 1;
    }
    // As many of one as of the other.
    let least = all.iter().map(Vec::len).min().unwrap_or(0).min(count);
    all.iter_mut().for_each(|terms| terms.truncate(least));
    all
}

/// Whether the terms after it may be computed exactly, too.
fn short(term: &Term) -> bool {
    let Term::Exact(value) = term else { return false };
    value.as_rational().is_none_or(|number| number.numer().bits() + number.denom().bits() < MOST_BITS)
}

/// The terms that the equations give at a step; none where one is not defined, or too long with its symbols.
fn exactly(recurrence: &Recurrence, all: &[Vec<Term>], step: usize, known: &Assumptions) -> Option<Vec<Term>> {
    let mut images = BTreeMap::new();
    for (name, place, offset) in recurrence.terms() {
        let Term::Exact(value) = all.get(place)?.get(step + offset)? else { return None };
        images.insert(name, value.clone());
    }
    images.insert(recurrence.index.clone(), Value::integer(recurrence.from + i64::try_from(step).ok()?));
    let next = |sequence: &crate::closed_form::Sequence| {
        let value = sequence.next.substitute(&images).ok()?;
        let fits = |value: &Value, most: usize| value.as_rational().is_some() || value.size() <= most;
        let value = fits(&value, 2 * MOST_SIZE).then(|| known.simplify(&value))?;
        fits(&value, MOST_SIZE).then_some(Term::Exact(value))
    };
    recurrence.sequences.iter().map(next).collect()
}

/// Bounds of the terms that the equations give at a step; `None` where they cannot be had.
fn bounded(recurrence: &Recurrence, all: &[Vec<Term>], step: usize) -> Option<Vec<Bounds>> {
    let mut known = BTreeMap::new();
    for (name, place, offset) in recurrence.terms() {
        known.insert(name, all.get(place)?.get(step + offset)?.bounds()?);
    }
    let index = BigRational::from_integer(BigInt::from(recurrence.from) + BigInt::from(step));
    known.insert(recurrence.index.clone(), (index.clone(), index));
    recurrence.sequences.iter().map(|sequence| evaluated(&sequence.next, &known)).collect()
}

/// The bounds of a quotient of polynomials.
fn evaluated(value: &Value, known: &BTreeMap<Name, Bounds>) -> Option<Bounds> {
    let (numerator, denominator) = value.polynomials()?;
    let polynomial = |polynomial: &crate::polynomial::Polynomial<Atom>| {
        let mut sum = (BigRational::zero(), BigRational::zero());
        for (monomial, number) in polynomial.terms() {
            let mut product = (number.clone(), number.clone());
            for (atom, exponent) in monomial.factors() {
                let Atom::Variable(name) = atom else { return None };
                product = times(&product, &power(known.get(name)?, *exponent)?);
            }
            sum = (sum.0 + product.0, sum.1 + product.1);
        }
        Some(sum)
    };
    let (top, bottom) = (polynomial(numerator)?, polynomial(denominator)?);
    if !bottom.0.is_positive() && !bottom.1.is_negative() {
        return None;
    }
    rounded(times(&top, &(bottom.1.recip(), bottom.0.recip())))
}

fn times(left: &Bounds, right: &Bounds) -> Bounds {
    let products = [&left.0 * &right.0, &left.0 * &right.1, &left.1 * &right.0, &left.1 * &right.1];
    let least = products.iter().min().cloned().unwrap_or_else(BigRational::zero);
    let most = products.into_iter().max().unwrap_or_else(BigRational::zero);
    (least, most)
}

/// A power, which is not negative where the exponent is even; `None` when it is too large.
fn power(bounds: &Bounds, exponent: u32) -> Option<Bounds> {
    let bits = |number: &BigRational| number.numer().bits() + number.denom().bits();
    if (bits(&bounds.0) + bits(&bounds.1)).saturating_mul(exponent.into()) > LONGEST {
        return None;
    }
    let ends =
        [num_traits::pow(bounds.0.clone(), exponent as usize), num_traits::pow(bounds.1.clone(), exponent as usize)];
    let [one, other] = ends;
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    let within = bounds.0.is_negative() && bounds.1.is_positive();
    Some(if exponent.is_multiple_of(2) && within { (BigRational::zero(), high) } else { (low, high) })
}

/// Bounds further out, with few bits; `None` when the number is too large.
fn rounded((low, high): Bounds) -> Option<Bounds> {
    let largest = low.abs().max(high.abs());
    if largest.to_integer().bits() > MOST_BITS {
        return None;
    }
    let scale = BigRational::from_integer(BigInt::one() << PRECISION);
    Some(((low * &scale).floor() / &scale, (high * &scale).ceil() / scale))
}

impl Term {
    fn bounds(&self) -> Option<Bounds> {
        match self {
            Term::Exact(value) => value.as_rational().map(|number| (number.clone(), number)),
            Term::Between(low, high) => Some((low.clone(), high.clone())),
        }
    }

    /// Exactly where that is short; else, behind `≈`, the leading digits that are certain.
    pub fn text(&self) -> String {
        if let Term::Exact(value) = self {
            let text = value.to_string();
            if text.len() <= WIDEST || value.as_rational().is_none() {
                return text;
            }
        }
        let Some((low, high)) = self.bounds() else { return "?".to_string() };
        let certain = (1..=DIGITS).rev().find_map(|digits| {
            let (one, other) = (decimal(&low, digits)?, decimal(&high, digits)?);
            (one == other).then_some(one)
        });
        certain.map_or_else(|| "?".to_string(), |text| format!("≈{text}"))
    }
}

/// The leading digits of a number, rounded: `-0.2065`, `1.234e57`.
fn decimal(number: &BigRational, digits: usize) -> Option<String> {
    if number.is_zero() {
        return Some("0".to_string());
    }
    let ten = BigInt::from(10);
    let size = number.abs();
    // The exponent of the leading digit.
    let mut exponent = i64::try_from(size.to_integer().to_string().len()).ok()? - 1;
    if size < BigRational::one() {
        exponent = -i64::try_from(size.recip().ceil().to_integer().to_string().len()).ok()?;
        let next = BigRational::new(BigInt::one(), ten.pow(u32::try_from(-exponent - 1).ok()?));
        if size >= next {
            exponent += 1;
        }
    }
    let shift = i64::try_from(digits).ok()? - 1 - exponent;
    let scale = BigRational::from_integer(ten.pow(u32::try_from(shift.abs()).ok()?));
    let rounded = if shift >= 0 { size * scale } else { size / scale }.round().to_integer();
    let mut whole = rounded.to_string();
    if whole.len() > digits {
        // Rounded up to the next power of ten.
        whole.pop();
        exponent += 1;
    }
    let sign = if number.is_negative() { "-" } else { "" };
    let (head, tail) = whole.split_at(1);
    Some(match exponent {
        -6..=-1 => format!("{sign}0.{}{whole}", "0".repeat(usize::try_from(-exponent - 1).ok()?)),
        0 if tail.is_empty() => format!("{sign}{head}"),
        0 => format!("{sign}{head}.{tail}"),
        _ if tail.is_empty() => format!("{sign}{head}e{exponent}"),
        _ => format!("{sign}{head}.{tail}e{exponent}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_digits() {
        let number = |top: i64, bottom: i64| BigRational::new(top.into(), bottom.into());
        assert_eq!(decimal(&number(-55, 256), 4).unwrap(), "-0.2148");
        assert_eq!(decimal(&number(1, 1), 3).unwrap(), "1.00");
        assert_eq!(decimal(&number(999_999, 1_000_000), 3).unwrap(), "1.00");
        assert_eq!(decimal(&number(1, 10), 3).unwrap(), "0.100");
        assert_eq!(decimal(&number(123_456, 1), 3).unwrap(), "1.23e5");
        assert_eq!(decimal(&number(1, 300_000_000), 2).unwrap(), "3.3e-9");
    }
}
