//! Arithmetic of exact rational numbers that looks for common factors only where there may be some, and by machine words
//! where the numbers are that short: the search takes longer than all the rest.

use dashu_int::IBig;
use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

/// The greatest common divisor, not negative. A long number is brought to the length of a short one first.
pub(crate) fn common(one: &BigInt, other: &BigInt) -> BigInt {
    if one.is_one() || other.is_one() {
        return BigInt::one();
    }
    if let (Some(one), Some(other)) = (one.magnitude().to_u64(), other.magnitude().to_u64()) {
        return BigInt::from(one.gcd(&other));
    }
    let (long, short) = if one.bits() < other.bits() { (other, one) } else { (one, other) };
    if short.is_zero() || long.bits() <= short.bits() + 64 {
        return of_long(long, short);
    }
    let rest = long % short;
    match (rest.magnitude().to_u64(), short.magnitude().to_u64()) {
        (Some(rest), Some(short)) => BigInt::from(rest.gcd(&short)),
        _ => of_long(&rest, short),
    }
}

/// The same: by Lehmer's method where it is sooner there than bit by bit.
fn of_long(one: &BigInt, other: &BigInt) -> BigInt {
    const LONG: u64 = 512;
    if one.bits().min(other.bits()) < LONG {
        return one.gcd(other);
    }
    from_whole(&IBig::from(dashu_int::ops::Gcd::gcd(to_whole(one), to_whole(other))))
}

/// The number as one of `dashu-int`, whose arithmetic of long numbers is faster, and which keeps those of two machine
/// words in place.
pub(crate) fn to_whole(number: &BigInt) -> IBig {
    match number.to_i128() {
        Some(short) => IBig::from(short),
        None => IBig::from_le_bytes(&number.to_signed_bytes_le()),
    }
}

/// The number that [`to_whole`] gives, back.
pub(crate) fn from_whole(number: &IBig) -> BigInt {
    BigInt::from_signed_bytes_le(&number.to_le_bytes())
}

/// A numerator and a denominator so short that sums and products of two of them are machine words.
fn short(number: &BigRational) -> Option<(i64, i64)> {
    let part = |part: &BigInt| part.to_i64().filter(|part| part.unsigned_abs() < 1 << 31);
    Some((part(number.numer())?, part(number.denom())?))
}

fn raw(top: i64, bottom: i64) -> BigRational {
    BigRational::new_raw(BigInt::from(top), BigInt::from(bottom))
}

/// The product.
pub(crate) fn product(left: &BigRational, right: &BigRational) -> BigRational {
    if left.is_one() || right.is_zero() {
        return right.clone();
    }
    if right.is_one() || left.is_zero() {
        return left.clone();
    }
    if let (Some((a, b)), Some((c, d))) = (short(left), short(right)) {
        let (one, other) = (a.gcd(&d), c.gcd(&b));
        return raw((a / one) * (c / other), (b / other) * (d / one));
    }
    if left.is_integer() && right.is_integer() {
        return BigRational::from_integer(left.numer() * right.numer());
    }
    let (one, other) = (common(left.numer(), right.denom()), common(right.numer(), left.denom()));
    BigRational::new_raw(
        over(left.numer(), &one) * over(right.numer(), &other),
        over(left.denom(), &other) * over(right.denom(), &one),
    )
}

/// The quotient by a number that is not 0.
pub(crate) fn quotient(left: &BigRational, right: &BigRational) -> BigRational {
    if right.is_one() || left.is_zero() { left.clone() } else { product(left, &right.recip()) }
}

/// The difference.
pub(crate) fn difference(left: &BigRational, right: &BigRational) -> BigRational {
    if right.is_zero() { left.clone() } else { sum(left, &-right) }
}

/// The sum.
pub(crate) fn sum(left: &BigRational, right: &BigRational) -> BigRational {
    if left.is_zero() || right.is_zero() {
        return if left.is_zero() { right.clone() } else { left.clone() };
    }
    if let (Some((a, b)), Some((c, d))) = (short(left), short(right)) {
        let (top, bottom) = (a * d + c * b, b * d);
        let shared = top.gcd(&bottom);
        return raw(top / shared, bottom / shared);
    }
    match (left.is_integer(), right.is_integer()) {
        (true, true) => return BigRational::from_integer(left.numer() + right.numer()),
        // A whole number brings no common factor in.
        (true, false) => {
            return BigRational::new_raw(left.numer() * right.denom() + right.numer(), right.denom().clone());
        }
        (false, true) => {
            return BigRational::new_raw(left.numer() + right.numer() * left.denom(), left.denom().clone());
        }
        (false, false) => {}
    }
    let shared = common(left.denom(), right.denom());
    if shared.is_one() {
        let numerator = left.numer() * right.denom() + right.numer() * left.denom();
        return BigRational::new_raw(numerator, left.denom() * right.denom());
    }
    let (one, other) = (left.denom() / &shared, right.denom() / &shared);
    let numerator = left.numer() * &other + right.numer() * &one;
    if numerator.is_zero() {
        return BigRational::zero();
    }
    // A factor of the numerator and the denominators together is one of what these share (Knuth, 4.5.1).
    let factor = common(&numerator, &shared);
    BigRational::new_raw(over(&numerator, &factor), one * over(right.denom(), &factor))
}

/// The exact quotient of whole numbers.
fn over(number: &BigInt, divisor: &BigInt) -> BigInt {
    if divisor.is_one() { number.clone() } else { number / divisor }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_the_library() {
        let long = BigInt::from(10).pow(30);
        let mut numbers = Vec::new();
        for top in [-12i64, -7, -1, 0, 1, 6, 35, 1_000_003] {
            for bottom in [1i64, 2, 6, 35, 49, 1_000_000] {
                let small = BigRational::new(top.into(), bottom.into());
                numbers.push(&small * BigRational::new(long.clone(), BigInt::from(7).pow(31)));
                numbers.push(&small * BigRational::from_integer(long.clone()));
                numbers.push(small);
            }
        }
        for one in &numbers {
            for other in &numbers {
                // Equal numbers in lowest terms: the parts are compared, not the values.
                let mut all = vec![(product(one, other), one * other), (sum(one, other), one + other)];
                all.push((difference(one, other), one - other));
                if !other.is_zero() {
                    all.push((quotient(one, other), one / other));
                }
                for (own, wanted) in all {
                    assert_eq!((own.numer(), own.denom()), (wanted.numer(), wanted.denom()), "{one} {other}");
                }
            }
        }
    }

    #[test]
    fn common_factors_of_long_numbers_are_those_of_the_library() {
        let power = |base: u32, exponent: u32| BigInt::from(base).pow(exponent);
        let numbers = [
            BigInt::from(-12),
            power(6, 300) * BigInt::from(-35),
            power(10, 200) * power(7, 90),
            power(3, 1000) + BigInt::one(),
            (power(3, 1000) + BigInt::one()) * power(2, 64),
            power(2, 127),
            -power(2, 127),
        ];
        for one in &numbers {
            assert_eq!(&from_whole(&to_whole(one)), one);
            for other in &numbers {
                assert_eq!(common(one, other), one.gcd(other), "{one} {other}");
            }
        }
    }
}
