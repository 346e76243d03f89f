//! The first terms of a sequence whose exact terms grow too long to write: first exactly, then between two numbers.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::bounds::{Bounds, PRECISIONS};

use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, needs_in_cases};
use crate::name::Name;
use crate::value::{Atom, Sort, Value, ValueError};

/// A term.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Term {
    /// Exactly.
    Exact(Value),
    /// Between two numbers.
    Between(Bounds),
}

/// The most bits of a term that is computed exactly.
const MOST_BITS: u64 = 2_000;
/// The most parts of a term with symbols: a longer one says nothing to a reader, and takes long to compute.
const MOST_SIZE: usize = 120;
/// The longest text of an exact term.
const WIDEST: usize = 40;
/// What is said of a value that there is not.
const NO_QUOTIENT: &str = "division by zero";
const NO_ROOT: &str = "has no square root";
/// The digits of other terms.
const DIGITS: usize = 10;

/// The first terms of every sequence, as many as can be computed and are not too long.
pub(super) fn listed(
    recurrence: &Recurrence,
    count: usize,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<Vec<Term>> {
    let [few, many] = PRECISIONS;
    let all = listed_to(recurrence, count, (known, stop), few);
    match all.iter().flatten().any(|term| term.leading().is_none()) {
        true => listed_to(recurrence, count, (known, stop), many),
        false => all,
    }
}

/// The same with so many bits of what is not exact.
fn listed_to(
    recurrence: &Recurrence,
    count: usize,
    (known, stop): (&Assumptions, &dyn Fn() -> bool),
    precision: usize,
) -> Vec<Vec<Term>> {
    let first = |value: &Value| Term::Exact(known.simplify(value));
    let starts = recurrence.sequences.iter().map(|sequence| sequence.start.iter().map(first).collect());
    let mut all: Vec<Vec<Term>> = starts.collect();
    let mut exact = true;
    let mut step = 0;
    while all.iter().any(|terms| terms.len() < count) && !stop() {
        let next = exact.then(|| exactly(recurrence, &all, step, known)).flatten();
        exact = next.as_ref().is_some_and(|next| next.iter().all(short));
        let bounded = || Some(bounded(recurrence, &all, step, precision)?.into_iter().map(Term::Between).collect());
        let Some(next) = next.or_else(bounded) else { break };
        all.iter_mut().zip(next).for_each(|(terms, next)| terms.push(next));
        step += 1;
    }
    // As many of one as of the other.
    let least = all.iter().map(Vec::len).min().unwrap_or(0).min(count);
    all.iter_mut().for_each(|terms| terms.truncate(least));
    all
}

/// The first term that there is not after these, `u(4)`, and why, if that is so: not where it is only too large.
pub(super) fn ended(recurrence: &Recurrence, all: &[Vec<Term>]) -> Option<(String, String)> {
    let longest = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max()?;
    let step = all.iter().map(Vec::len).min()?.checked_sub(longest)?;
    let mut images = BTreeMap::new();
    for (name, place, offset) in recurrence.terms() {
        let Term::Exact(value) = all.get(place)?.get(step + offset)? else { return None };
        images.insert(name, value.clone());
    }
    let from = recurrence.from.checked_add(i64::try_from(step).ok()?)?;
    images.insert(recurrence.index.clone(), Value::integer(from));
    let numbers = images.values().all(|value| value.as_rational().is_some());
    let (sequence, error) = recurrence.sequences.iter().find_map(|sequence| {
        let error = sequence.next.substitute(&images).err()?.0;
        (error == NO_QUOTIENT || error.ends_with(NO_ROOT)).then_some((sequence, error))
    })?;
    let at = from.checked_add(i64::try_from(sequence.start.len()).ok()?)?;
    numbers.then(|| (format!("{}({at})", sequence.name), error))
}

/// Whether the terms after it may be computed exactly, too.
fn short(term: &Term) -> bool {
    let Term::Exact(value) = term else { return false };
    match value.as_rational() {
        Some(number) => number.numer().bits() + number.denom().bits() < MOST_BITS,
        None => is_symbolic(value) || value.to_string().len() <= WIDEST,
    }
}

/// Whether it is no number: then there are no digits of it.
fn is_symbolic(value: &Value) -> bool {
    value.sort() != Sort::Real || !value.variables().is_empty()
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
        let value =
            if fits(&value, 2 * MOST_SIZE) { put_in(&sequence.next, &images, known).ok()? } else { return None };
        fits(&value, MOST_SIZE).then_some(Term::Exact(value))
    };
    recurrence.sequences.iter().map(next).collect()
}

/// What an equation gives where these are put in, as the assumptions leave it, if nothing is left out that may have no value:
/// `max(100,sqrt(3-a))` with a at least 2 is 100 where it has a value, and it has none where a is more than 3.
///
/// # Errors
/// Where it has no value, or may have none and does not show that.
pub(super) fn put_in(next: &Value, images: &BTreeMap<Name, Value>, known: &Assumptions) -> Result<Value, ValueError> {
    let simple = known.simplify(&next.substitute(images)?);
    // Of numbers alone what has no value is seen where they are put in.
    let symbolic = |name: &Name| images.get(name).is_none_or(|image| !image.variables().is_empty());
    if next.needs().is_empty() || !next.variables().iter().any(symbolic) {
        return Ok(simple);
    }
    let shown = simple.needs();
    for (here, need) in needs_in_cases(next, images, known)? {
        let need = need.substitute(images)?;
        if !need.value().variables().is_empty() && !need.follows_from(&shown) && here.grants(&need) != Some(true) {
            return Err(ValueError::new(need.to_string()));
        }
    }
    Ok(simple)
}

/// Bounds of the terms that the equations give at a step; `None` where they cannot be had.
fn bounded(recurrence: &Recurrence, all: &[Vec<Term>], step: usize, precision: usize) -> Option<Vec<Bounds>> {
    let mut known = BTreeMap::new();
    for (name, place, offset) in recurrence.terms() {
        known.insert(name, all.get(place)?.get(step + offset)?.bounds(precision)?);
    }
    // The index exactly: as an exponent it has to be whole.
    let index = Value::integer(recurrence.from.checked_add(i64::try_from(step).ok()?)?);
    let next = |sequence: &crate::closed_form::Sequence| {
        evaluated(&sequence.next.with(&recurrence.index, &index).ok()?, &known, precision)
    };
    recurrence.sequences.iter().map(next).collect()
}

/// The bounds of a quotient of polynomials in terms, maxima, and conditions that are known.
fn evaluated(value: &Value, known: &BTreeMap<Name, Bounds>, precision: usize) -> Option<Bounds> {
    let (numerator, denominator) = value.polynomials()?;
    let polynomial = |polynomial: &crate::polynomial::Polynomial<Atom>| {
        let mut sum: Option<Bounds> = None;
        for (monomial, number) in polynomial.terms() {
            let mut product = Bounds::of(number, precision);
            for (atom, exponent) in monomial.factors() {
                product = product.times(&of_atom(atom, known, precision)?.power((*exponent).into())?)?;
            }
            sum = Some(match sum {
                Some(sum) => sum.plus(&product),
                None => product,
            });
        }
        Some(sum.unwrap_or_else(|| Bounds::of(&BigRational::zero(), precision)))
    };
    polynomial(numerator)?.over(&polynomial(denominator)?)
}

fn of_atom(atom: &Atom, known: &BTreeMap<Name, Bounds>, precision: usize) -> Option<Bounds> {
    let whole = |number: i64| Bounds::of(&BigRational::from_integer(number.into()), precision);
    match atom {
        Atom::Variable(name) => known.get(name).cloned(),
        Atom::Maximum(parts) => parts
            .iter()
            .try_fold(whole(0), |greatest, part| Some(greatest.or_more(&evaluated(part, known, precision)?))),
        Atom::Root(inner) => evaluated(inner, known, precision)?.sqrt(),
        Atom::Floor(inner) => Some(evaluated(inner, known, precision)?.floor()),
        Atom::Positive(inner) => evaluated(inner, known, precision)?.is_positive().map(|holds| whole(holds.into())),
        _ => None,
    }
}

impl Term {
    fn bounds(&self, precision: usize) -> Option<Bounds> {
        match self {
            Term::Exact(value) => evaluated(value, &BTreeMap::new(), precision),
            Term::Between(bounds) => Some(bounds.clone()),
        }
    }

    /// Whether it has symbols.
    pub fn is_symbolic(&self) -> bool {
        matches!(self, Term::Exact(value) if is_symbolic(value))
    }

    /// Exactly where that is short; else, behind `≈`, the leading digits that are certain.
    pub fn text(&self) -> String {
        self.leading().unwrap_or_else(|| "?".to_string())
    }

    /// The same; none where no digit is certain.
    fn leading(&self) -> Option<String> {
        if let Term::Exact(value) = self {
            let text = value.to_string();
            if text.len() <= WIDEST || is_symbolic(value) {
                return Some(text);
            }
        }
        let (low, high, tens) = self.bounds(PRECISIONS[0])?.in_tens()?;
        (1..=DIGITS).rev().find_map(|digits| {
            let (one, other) = (decimal(&low, tens, digits)?, decimal(&high, tens, digits)?);
            (one == other).then(|| format!("≈{one}"))
        })
    }
}

/// The leading digits of a number times a power of ten, rounded: `-0.2065`, `1.234e57`.
fn decimal(number: &BigRational, tens: i64, digits: usize) -> Option<String> {
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
    let exponent = exponent.checked_add(tens)?;
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
        assert_eq!(decimal(&number(-55, 256), 0, 4).unwrap(), "-0.2148");
        assert_eq!(decimal(&number(1, 1), 0, 3).unwrap(), "1.00");
        assert_eq!(decimal(&number(999_999, 1_000_000), 0, 3).unwrap(), "1.00");
        assert_eq!(decimal(&number(1, 10), 0, 3).unwrap(), "0.100");
        assert_eq!(decimal(&number(123_456, 1), 0, 3).unwrap(), "1.23e5");
        assert_eq!(decimal(&number(1, 300_000_000), 0, 2).unwrap(), "3.3e-9");
    }
}
