//! Forms with numbers of very many digits, as they can be read: powers of the index are counted from where the form begins, and
//! what is left of a long number is written as a product of powers.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::value::Value;

/// Up to this many letters a form is written as it is.
const WIDE: usize = 400;
/// The most bits of a number that is written in digits.
const MOST_BITS: u64 = 160;
/// The most bits of a number that is taken apart, and the primes that are looked for in it.
const LONGEST: u64 = 1 << 22;
/// The least power that is written as one.
const FEW: u64 = 10;
const PRIMES: [u32; 11] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31];

/// A form that holds from this index on.
pub(super) fn readable(form: &Value, index: &Name, from: &Value) -> String {
    let plain = form.to_string();
    let shifted = match from.as_rational() {
        Some(_) if plain.len() <= WIDE => return plain,
        Some(_) => shifted(form, index, from),
        None => counted_from(form, index, from),
    };
    shifted.map(|form| form.to_string()).filter(|text| text.len() < plain.len()).unwrap_or(plain)
}

/// The same where it begins at an index with symbols: `(1/2)^(n-floor(g/v))*g` in place of `(1/2)^n*2^floor(g/v)*g`.
fn counted_from(form: &Value, index: &Name, from: &Value) -> Option<Value> {
    let count = Value::variable(index);
    let name = Name::new(&format!("({})", count.sub(from).ok()?));
    form.with(index, &count.add(from).ok()?).ok()?.with(index, &Value::variable(&name)).ok()
}

/// The same as a value to be written, where names stand for powers of numbers and for the index less where it begins.
fn shifted(form: &Value, index: &Name, from: &Value) -> Option<Value> {
    let first = from.as_rational().filter(BigRational::is_integer)?.to_integer().to_i64()?;
    let count = match first {
        0 => Value::variable(index),
        1.. => Value::variable(&Name::new(&format!("({index}-{first})"))),
        _ => return None,
    };
    let mut sum = Value::zero();
    for (base, coefficients) in exponentials(form, index)? {
        let base_number = base.as_rational()?;
        let scale = base.power(&Value::integer(first)).ok()?.as_rational()?;
        for (power, coefficient) in coefficients.iter().enumerate() {
            let number = coefficient.as_rational()? * &scale;
            let number = written(&number).or_else(|| in_two(&number))?;
            let power = Value::variable(index).power(&Value::integer(i64::try_from(power).ok()?)).ok()?;
            let mut product = number.mul(&power).ok()?;
            if !base_number.is_one() {
                product = product.mul(&base.power(&count).ok()?).ok()?;
            }
            sum = sum.add(&product).ok()?;
        }
    }
    Some(sum)
}

/// A number as a whole number and what is left.
fn in_two(number: &BigRational) -> Option<Value> {
    let whole = number.round();
    written(&whole)?.add(&written(&(number - &whole))?).ok()
}

/// A number, with names for the powers in it if it is a long one; nothing if there are not enough of them.
fn written(number: &BigRational) -> Option<Value> {
    let bits = number.numer().bits() + number.denom().bits();
    if bits <= MOST_BITS || number.is_zero() {
        return Some(Value::rational(number.clone()));
    }
    if bits > LONGEST {
        return None;
    }
    let (mut above, mut below) = (number.numer().abs(), number.denom().clone());
    let mut powers = Value::one();
    for prime in PRIMES {
        let ((times, rest), (under, other)) = (without(&above, prime), without(&below, prime));
        let name = match (times, under) {
            (FEW.., _) => format!("{prime}^{times}"),
            (_, FEW..) => format!("(1/{prime})^{under}"),
            _ => continue,
        };
        (above, below) = (rest, other);
        powers = powers.mul(&Value::variable(&Name::new(&name))).ok()?;
    }
    let rest = BigRational::new(if number.is_negative() { -above } else { above }, below);
    if rest.numer().bits() + rest.denom().bits() > MOST_BITS {
        return None;
    }
    Value::rational(rest).mul(&powers).ok()
}

/// How often a prime divides a number that is not 0, and what is left.
fn without(number: &BigInt, prime: u32) -> (u64, BigInt) {
    let mut squares = vec![BigInt::from(prime)];
    while let Some(last) = squares.last().filter(|last| last.bits() <= number.bits()) {
        squares.push(last * last);
    }
    let (mut times, mut rest) = (0u64, number.clone());
    for (place, square) in squares.iter().enumerate().rev() {
        let (quotient, remainder) = rest.div_rem(square);
        if remainder.is_zero() {
            (times, rest) = (times + (1 << place), quotient);
        }
    }
    (times, rest)
}
