//! What is computed of terms: exactly, or between numbers of a fixed length, which late terms do not outgrow.

use std::cmp::Ordering;

use num_rational::BigRational;

use super::number::Number;
use crate::exponential_polynomial::enclosed::Enclosed;

/// Numbers of which nothing is known where an answer is none.
pub(in super::super) trait Arithmetic: Clone {
    /// Whether there are roots.
    const ROOTS: bool;

    fn of(number: &BigRational) -> Option<Self>;
    fn times(&self, other: &Self) -> Option<Self>;
    fn plus(&self, other: &Self) -> Option<Self>;
    fn inverse(&self) -> Option<Self>;
    fn raised(&self, exponent: i64) -> Option<Self>;
    fn greater(&self, other: &Self) -> Option<Self>;
    fn floor(&self) -> Option<Self>;
    fn root(&self) -> Option<Self>;
    /// How it lies to 0.
    fn sign(&self) -> Option<Ordering>;
    /// How it lies to another.
    fn compared(&self, other: &Self) -> Option<Ordering>;
    /// The whole number of a machine word that it is.
    fn whole(&self) -> Option<i64>;
}

impl Arithmetic for Number {
    const ROOTS: bool = false;

    fn of(number: &BigRational) -> Option<Number> {
        Some(Number::of(number))
    }

    fn times(&self, other: &Number) -> Option<Number> {
        Some(self.times(other))
    }

    fn plus(&self, other: &Number) -> Option<Number> {
        Some(self.plus(other))
    }

    fn inverse(&self) -> Option<Number> {
        self.inverse()
    }

    fn raised(&self, exponent: i64) -> Option<Number> {
        self.raised(exponent)
    }

    fn greater(&self, other: &Number) -> Option<Number> {
        Some(if self.compared(other) == Ordering::Greater { self.clone() } else { other.clone() })
    }

    fn floor(&self) -> Option<Number> {
        Some(self.floor())
    }

    fn root(&self) -> Option<Number> {
        None
    }

    fn sign(&self) -> Option<Ordering> {
        Some(self.sign())
    }

    fn compared(&self, other: &Number) -> Option<Ordering> {
        Some(self.compared(other))
    }

    fn whole(&self) -> Option<i64> {
        self.whole()
    }
}

/// A number between two of so many bits.
#[derive(Clone, Debug)]
pub(in super::super) struct Near<const BITS: u64>(Enclosed);

impl<const BITS: u64> Arithmetic for Near<BITS> {
    const ROOTS: bool = true;

    fn of(number: &BigRational) -> Option<Self> {
        Enclosed::of(number, BITS).map(Near)
    }

    fn times(&self, other: &Self) -> Option<Self> {
        self.0.times(&other.0).map(Near)
    }

    fn plus(&self, other: &Self) -> Option<Self> {
        self.0.plus(&other.0).map(Near)
    }

    fn inverse(&self) -> Option<Self> {
        self.0.inverse().map(Near)
    }

    fn raised(&self, exponent: i64) -> Option<Self> {
        match exponent {
            1 => return Some(self.clone()),
            2 => return self.times(self),
            _ => {}
        }
        // No power of 0 but those with a positive exponent has a meaning.
        if exponent <= 0 && self.0.sign()? == Ordering::Equal {
            return None;
        }
        let power = self.0.raised(exponent.unsigned_abs()).map(Near)?;
        if exponent < 0 { power.inverse() } else { Some(power) }
    }

    fn greater(&self, other: &Self) -> Option<Self> {
        self.0.greater(&other.0).map(Near)
    }

    fn floor(&self) -> Option<Self> {
        self.0.floor().map(Near)
    }

    fn root(&self) -> Option<Self> {
        self.0.root().map(Near)
    }

    fn sign(&self) -> Option<Ordering> {
        self.0.sign()
    }

    fn compared(&self, other: &Self) -> Option<Ordering> {
        self.plus(&other.times(&Self::of(&BigRational::from_integer((-1).into()))?)?)?.sign()
    }

    fn whole(&self) -> Option<i64> {
        self.0.whole()
    }
}
