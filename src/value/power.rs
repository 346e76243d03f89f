//! Powers, with integer or symbolic exponent. A symbolic exponent, and each variable in it, stands for a natural number.

mod whole;

use std::sync::LazyLock;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::{Atom, Outcome, Real, Sort, Value, ValueError};
use crate::polynomial::{Monomial, Polynomial};

/// Divisors that are looked for in a base; what is left is one base.
const MOST_FACTOR: u32 = 1000;

/// The primes below that, in groups whose product is a machine word: one division tells which of them divide a number.
static PRIMES: LazyLock<Vec<(u64, Vec<u32>)>> = LazyLock::new(|| {
    let mut primes: Vec<u32> = Vec::new();
    let mut groups: Vec<(u64, Vec<u32>)> = Vec::new();
    for number in 2..MOST_FACTOR {
        if primes.iter().any(|prime| number % prime == 0) {
            continue;
        }
        primes.push(number);
        match groups.last_mut().and_then(|last| last.0.checked_mul(u64::from(number)).map(|product| (last, product))) {
            Some((last, product)) => {
                last.0 = product;
                last.1.push(number);
            }
            None => groups.push((u64::from(number), vec![number])),
        }
    }
    groups
});

impl Value {
    /// `self ^ exponent`: an integer exponent, or a symbolic one that stands for a natural number.
    ///
    /// # Errors
    /// On an exponent that is a number but not an integer, a vector or distribution, `0` to a negative power, or when
    /// the result is too large.
    pub fn power(&self, exponent: &Value) -> Result<Value, ValueError> {
        if exponent.sort() != Sort::Real || self.sort() != Sort::Real {
            let wrong = if self.sort() == Sort::Real { exponent } else { self };
            return Err(ValueError(format!("a power needs numbers, and this is {}", wrong.sort())));
        }
        match exponent.as_rational() {
            Some(number) if number.is_integer() => self.integer_power(number.numer()),
            Some(_) => Err(ValueError::new("an exponent must be an integer; write sqrt(x) for a square root")),
            None => self.symbolic_power(exponent),
        }
    }

    pub(super) fn integer_power(&self, exponent: &BigInt) -> Outcome {
        let (numerator, denominator) = self.real()?;
        if exponent.is_zero() {
            return Ok(Value::one());
        }
        if let Some(number) = self.as_rational().filter(|number| number.is_zero() || number.abs().is_one()) {
            let odd = exponent.is_odd() || number.is_zero();
            if number.is_zero() && exponent.is_negative() {
                return Err(ValueError::new("division by zero"));
            }
            return Ok(if odd { self.clone() } else { Value::one() });
        }
        let size = exponent.magnitude().to_u32().ok_or_else(ValueError::too_large)?;
        let raise = |part: &Real| part.power(size).ok_or_else(ValueError::too_large);
        let (numerator, denominator) = (raise(numerator)?, raise(denominator)?);
        if exponent.is_negative() {
            Value::quotient(denominator, numerator)
        } else {
            Value::quotient(numerator, denominator)
        }
    }

    /// Whether a power of it holds a power of -1.
    pub fn has_sign(&self) -> bool {
        let negative = |part: &Real| !part.is_zero() && part.leading().is_negative();
        self.real().is_ok_and(|(numerator, denominator)| negative(numerator) || negative(denominator))
    }

    fn symbolic_power(&self, exponent: &Value) -> Outcome {
        let (numerator, denominator) = self.real()?;
        if denominator.is_one() {
            return raise(numerator, exponent);
        }
        raise(numerator, exponent)?.div(&raise(denominator, exponent)?)
    }
}

/// A polynomial to a symbolic power: content and monomial are raised by themselves.
fn raise(base: &Real, exponent: &Value) -> Outcome {
    if base.is_zero() {
        return split(&Value::zero(), exponent);
    }
    let content = if base.leading().is_negative() { -base.content() } else { base.content() };
    let monomial = base.monomial_content();
    let mut result = raise_number(&content, exponent)?;
    for (atom, count) in monomial.factors() {
        let times = exponent.mul(&Value::integer(i64::from(*count)))?;
        result = result.mul(&raise_atom(atom, &times)?)?;
    }
    let rest = base.without(&monomial).primitive();
    if rest.is_one() { Ok(result) } else { result.mul(&split(&Value::whole(rest)?, exponent)?) }
}

fn raise_atom(atom: &Atom, exponent: &Value) -> Outcome {
    match atom {
        Atom::Power(base, inner) => split(base, &inner.mul(exponent)?),
        other => split(&other.value()?, exponent),
    }
}

fn raise_number(number: &BigRational, exponent: &Value) -> Outcome {
    let mut result = if number.is_negative() { split(&Value::integer(-1), exponent)? } else { Value::one() };
    for (factor, count) in factors(&number.numer().abs()) {
        let times = exponent.mul(&Value::rational(BigRational::from_integer(count.into())))?;
        result = result.mul(&split(&whole(factor), &times)?)?;
    }
    for (factor, count) in factors(number.denom()) {
        let times = exponent.mul(&Value::rational(BigRational::from_integer(count.into())))?;
        result = result.div(&split(&whole(factor), &times)?)?;
    }
    Ok(result)
}

fn whole(number: BigInt) -> Value {
    Value::rational(BigRational::from_integer(number))
}

/// Small prime factors with their multiplicity, and what is left as one factor; the product is the number.
pub(super) fn factors(number: &BigInt) -> Vec<(BigInt, u32)> {
    let mut found = Vec::new();
    let mut left = number.clone();
    for (product, primes) in PRIMES.iter() {
        let smallest = u64::from(primes[0]);
        if left.is_one() || left.bits() > 4096 || left < BigInt::from(smallest * smallest) {
            break;
        }
        let rest = (&left % *product).to_u64().unwrap_or(0);
        for prime in primes.iter().copied().filter(|prime| rest.is_multiple_of(u64::from(*prime))) {
            let count = without(&mut left, u64::from(prime));
            if count > 0 {
                found.push((BigInt::from(prime), count));
            }
        }
    }
    if !left.is_one() {
        found.push((left, 1));
    }
    found
}

/// Takes a prime out of a number; how often it was in it. Machine words of it go first: it may be there a thousand times.
fn without(number: &mut BigInt, prime: u64) -> u32 {
    let most = 63 / (64 - prime.leading_zeros());
    let mut count = 0;
    for (power, times) in [(prime.pow(most), most), (prime, 1)] {
        while (&*number % power).is_zero() {
            *number /= power;
            count += times;
        }
    }
    count
}

/// `base ^ exponent` for a base that is itself not a product: `b^(2*n + m + 3) = (b^n)^2 * b^m * b^3`.
fn split(base: &Value, exponent: &Value) -> Outcome {
    if let Some(number) = exponent.as_rational() {
        if !number.is_integer() {
            return Err(ValueError::new("an exponent must be an integer"));
        }
        return base.integer_power(number.numer());
    }
    let (numerator, denominator) = exponent.real()?;
    if !denominator.is_one() {
        return Atom::Power(base.clone(), exponent.clone()).value();
    }
    let mut result = Value::one();
    let mut rest = Polynomial::zero();
    for (monomial, number) in numerator.terms() {
        if number.is_integer() {
            let part = if monomial.factors().is_empty() {
                base.clone()
            } else {
                Atom::Power(base.clone(), unit(monomial)?).value()?
            };
            result = result.mul(&part.integer_power(number.numer())?)?;
        } else {
            rest = rest.plus(&Polynomial::term(monomial.clone(), number.clone()));
        }
    }
    if rest.is_zero() {
        return Ok(result);
    }
    result.mul(&Atom::Power(base.clone(), Value::whole(rest)?).value()?)
}

fn unit(monomial: &Monomial<Atom>) -> Outcome {
    Value::whole(Polynomial::term(monomial.clone(), BigRational::one()))
}

/// The root of the powers of positive numbers, as `(4/9)^n`, that divide every term of a sum, and the rest.
pub(super) fn with_powers(polynomial: &Real) -> Option<(Value, Real)> {
    if polynomial.terms().len() < 2 {
        return None;
    }
    let (mut root, mut taken) = (Value::one(), Vec::new());
    for (atom, count) in polynomial.monomial_content().factors() {
        let Atom::Power(base, exponent) = atom else { continue };
        let Some(base) = base.as_rational().filter(Signed::is_positive) else { continue };
        let half = Polynomial::term(Monomial::of(vec![(atom.clone(), count / 2)])?, BigRational::one());
        root = root.mul(&Value::whole(half).ok()?).ok()?;
        let single = Value::rational(base).sqrt().ok().and_then(|root| root.as_rational()).filter(|_| count % 2 == 1);
        if let Some(base) = &single {
            root = root.mul(&Value::rational(base.clone()).power(exponent).ok()?).ok()?;
        }
        taken.push((atom.clone(), if single.is_some() { *count } else { count - count % 2 }));
    }
    let square = Monomial::of(taken).filter(|square| !square.factors().is_empty())?;
    Some((root, polynomial.without(&square)))
}

/// Whether this is a product of powers of positive numbers, and so more than 0.
pub(super) fn is_of_powers(polynomial: &Real) -> bool {
    let positive =
        |atom: &Atom| matches!(atom, Atom::Power(base, _) if base.as_rational().is_some_and(|base| base.is_positive()));
    let [(monomial, number)] = polynomial.terms() else { return false };
    number.is_positive() && monomial.factors().iter().all(|(atom, _)| positive(atom))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn exponents_split() {
        let n = Value::variable(&Name::new("n"));
        let half = Value::fraction(1, 2).unwrap();
        let four = Value::integer(4);
        let power = half.power(&n).unwrap();
        let product = power.mul(&power).unwrap().mul(&four.power(&n).unwrap()).unwrap();
        assert_eq!(product, Value::one());
        let next = n.add(&Value::one()).unwrap();
        assert_eq!(half.power(&next).unwrap(), power.mul(&half).unwrap());
        let sign = Value::integer(-1).power(&n).unwrap();
        assert_eq!(sign.mul(&sign).unwrap(), Value::one());
        assert_eq!(Value::zero().power(&next).unwrap(), Value::zero());
    }

    #[test]
    fn huge_powers_are_refused() {
        let huge = Value::integer(i64::MAX);
        assert!(Value::integer(3).power(&huge).is_err());
        assert_eq!(Value::integer(-1).power(&huge).unwrap(), Value::integer(-1));
    }
}
