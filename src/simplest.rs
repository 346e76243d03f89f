//! The simplest number between two others: the one with the least denominator.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

/// The simplest number between two, both included, in any order.
pub fn simplest(one: &BigRational, other: &BigRational) -> BigRational {
    let (low, high) = if one <= other { (one, other) } else { (other, one) };
    if !low.is_positive() && !high.is_negative() {
        return BigRational::zero();
    }
    if high.is_negative() {
        return -positive(-high, -low);
    }
    positive(low.clone(), high.clone())
}

/// By continued fractions, for 0 < low <= high.
fn positive(low: BigRational, high: BigRational) -> BigRational {
    let (mut low, mut high) = (low, high);
    let mut wholes: Vec<BigInt> = Vec::new();
    let last = loop {
        let whole = low.numer().div_floor(low.denom());
        let rest = BigRational::from_integer(whole.clone());
        if rest == low {
            break rest;
        }
        if &rest + BigRational::one() <= high {
            break rest + BigRational::one();
        }
        wholes.push(whole);
        let (next_low, next_high) = ((&high - &rest).recip(), (&low - &rest).recip());
        (low, high) = (next_low, next_high);
    };
    wholes.into_iter().rev().fold(last, |number, whole| BigRational::from_integer(whole) + number.recip())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(numerator: i64, denominator: i64) -> BigRational {
        BigRational::new(numerator.into(), denominator.into())
    }

    #[test]
    fn no_number_between_has_a_smaller_denominator() {
        for a in -30..30i64 {
            for b in 1..12i64 {
                let (low, high) = (number(a, 7), number(a, 7) + number(1, b * 13));
                let found = simplest(&low, &high);
                assert!(low <= found && found <= high);
                for denominator in 1..200i64 {
                    let least = (&low * BigRational::from_integer(denominator.into())).ceil() / number(denominator, 1);
                    if least <= high {
                        assert_eq!(*found.denom(), *least.reduced().denom(), "{low} {high}");
                        break;
                    }
                }
            }
        }
    }
}
