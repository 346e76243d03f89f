//! Exact rational numbers that are two machine words as long as they fit.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use crate::rational::{product, sum};

/// The bits of a number that is still raised to a power.
const MOST_BITS: u64 = 1 << 16;
/// The largest exponent of a power.
const MOST_EXPONENT: i64 = 4_096;

/// A rational number; numerator and denominator have no common factor, and the denominator is positive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) enum Number {
    Small(i64, i64),
    Large(BigRational),
}

impl Number {
    pub(super) fn integer(number: i64) -> Number {
        Number::Small(number, 1)
    }

    pub(super) fn of(number: &BigRational) -> Number {
        match (number.numer().to_i64(), number.denom().to_i64()) {
            (Some(above), Some(below)) => Number::Small(above, below),
            _ => Number::Large(number.clone()),
        }
    }

    fn large(&self) -> BigRational {
        match self {
            Number::Small(above, below) => BigRational::new_raw(BigInt::from(*above), BigInt::from(*below)),
            Number::Large(number) => number.clone(),
        }
    }

    /// The quotient of two numbers without common factor, the second positive.
    fn quotient(above: i128, below: i128) -> Number {
        match (i64::try_from(above), i64::try_from(below)) {
            (Ok(above), Ok(below)) => Number::Small(above, below),
            _ => Number::Large(BigRational::new_raw(BigInt::from(above), BigInt::from(below))),
        }
    }

    pub(super) fn times(&self, other: &Number) -> Number {
        let (Number::Small(a, b), Number::Small(c, d)) = (self, other) else {
            return Number::of(&product(&self.large(), &other.large()));
        };
        let (one, two) = (common(*a, *d), common(*c, *b));
        Number::quotient(
            (i128::from(*a) / one) * (i128::from(*c) / two),
            (i128::from(*b) / two) * (i128::from(*d) / one),
        )
    }

    pub(super) fn plus(&self, other: &Number) -> Number {
        let (Number::Small(a, b), Number::Small(c, d)) = (self, other) else {
            return Number::of(&sum(&self.large(), &other.large()));
        };
        let [a, b, c, d] = [*a, *b, *c, *d].map(i128::from);
        if b == 1 && d == 1 {
            return Number::quotient(a + c, 1);
        }
        let shared = short(b).gcd(&short(d));
        let shared = i128::from(shared);
        let above = a * (d / shared) + c * (b / shared);
        // What divides both is one of what the denominators share (Knuth, 4.5.1).
        let factor = i128::from(short(above % shared).gcd(&short(shared)));
        Number::quotient(above / factor, (b / shared) * (d / factor))
    }

    /// One over it, if it is not 0.
    pub(super) fn inverse(&self) -> Option<Number> {
        match self {
            _ if self.sign() == Ordering::Equal => None,
            Number::Small(above, below) if *above > 0 => Some(Number::Small(*below, *above)),
            Number::Small(above, below) => Some(Number::quotient(-i128::from(*below), -i128::from(*above))),
            Number::Large(number) => Some(Number::of(&number.recip())),
        }
    }

    /// How it lies to 0.
    pub(super) fn sign(&self) -> Ordering {
        match self {
            Number::Small(above, _) => above.cmp(&0),
            Number::Large(number) => number.numer().cmp(&BigInt::zero()),
        }
    }

    pub(super) fn compared(&self, other: &Number) -> Ordering {
        match (self, other) {
            (Number::Small(a, b), Number::Small(c, d)) => {
                (i128::from(*a) * i128::from(*d)).cmp(&(i128::from(*c) * i128::from(*b)))
            }
            _ => self.large().cmp(&other.large()),
        }
    }

    pub(super) fn floor(&self) -> Number {
        match self {
            Number::Small(above, below) => Number::integer(above.div_floor(below)),
            Number::Large(number) => Number::of(&number.floor()),
        }
    }

    /// A power; nothing where it is not defined, or too large.
    pub(super) fn raised(&self, exponent: i64) -> Option<Number> {
        match exponent {
            1 => return Some(self.clone()),
            2 => return Some(self.times(self)),
            _ => {}
        }
        let (above, below) = self.bits();
        let small = above.max(below).saturating_mul(exponent.unsigned_abs()) <= MOST_BITS;
        let undefined = self.sign() == Ordering::Equal && exponent <= 0;
        if undefined || !small || exponent.abs() > MOST_EXPONENT {
            return None;
        }
        Some(Number::of(&self.large().pow(i32::try_from(exponent).ok()?)))
    }

    /// It as a whole number of a machine word.
    pub(super) fn whole(&self) -> Option<i64> {
        if let Number::Small(number, 1) = self { Some(*number) } else { None }
    }

    /// The bits of the numerator and of the denominator.
    pub(super) fn bits(&self) -> (u64, u64) {
        match self {
            Number::Small(above, below) => {
                (u64::from(64 - above.unsigned_abs().leading_zeros()), u64::from(64 - below.leading_zeros()))
            }
            Number::Large(number) => (number.numer().bits(), number.denom().bits()),
        }
    }
}

/// The size of a number that fits into a machine word.
fn short(number: i128) -> u64 {
    u64::try_from(number.unsigned_abs()).unwrap_or(u64::MAX)
}

/// The greatest common divisor, where the second is positive.
fn common(one: i64, other: i64) -> i128 {
    if other == 1 { 1 } else { i128::from(one.unsigned_abs().gcd(&other.unsigned_abs())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_long_arithmetic() {
        let mut numbers = Vec::new();
        for above in [0, 1, -1, 6, -35, i64::MAX, i64::MIN, i64::MAX - 1, 1 << 40] {
            for below in [1, 2, 15, 1 << 31, i64::MAX] {
                numbers.push(BigRational::new(above.into(), below.into()));
            }
        }
        for one in &numbers {
            for other in &numbers {
                let (a, b) = (Number::of(one), Number::of(other));
                assert_eq!(a.times(&b), Number::of(&(one * other)));
                assert_eq!(a.plus(&b), Number::of(&(one + other)));
                assert_eq!(a.compared(&b), one.cmp(other));
            }
            let number = Number::of(one);
            assert_eq!(number.floor(), Number::of(&one.floor()));
            assert_eq!(number.inverse(), (!one.is_zero()).then(|| Number::of(&one.recip())));
            assert_eq!(number.raised(3), Some(Number::of(&one.pow(3))));
        }
    }
}
