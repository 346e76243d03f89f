//! Where one part of a sum is larger than all others together.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::{PRECISION, Part};

/// Whether from an index on one part is larger than the sum of all others.
pub(super) fn outgrown(parts: &[Part], main: usize, at: u64) -> bool {
    is_matched(parts, main, at, true)
}

/// Whether from an index on one part is as large as the sum of all others, or `larger`.
pub(super) fn is_matched(parts: &[Part], main: usize, at: u64, larger: bool) -> bool {
    let own = &parts[main];
    let enough = |sum: &BigRational| if larger { *sum < own.weight.0 } else { *sum <= own.weight.0 };
    let (count, next) = (BigRational::from_integer(at.into()), BigRational::from_integer((at + 1).into()));
    let Some(exponent) = at.to_i32().filter(|_| own.size.0.is_positive()) else { return false };
    let mut sum = BigRational::zero();
    for (_, part) in parts.iter().enumerate().filter(|(place, _)| *place != main) {
        let ratio = &part.size.1 / &own.size.0;
        let degree = part.power as i32 - own.power as i32;
        // Their quotient must fall from here on: `((n+1)/n)^degree * ratio` is at most 1 here, and at all later indices,
        // where it comes down to the ratio, or up to it.
        if ratio > BigRational::one() || (&next / &count).pow(degree) * &ratio > BigRational::one() {
            return false;
        }
        sum += &part.weight.1 * count.pow(degree) * rounded_up(&ratio).pow(exponent);
        if !enough(&sum) {
            return false;
        }
    }
    enough(&sum)
}

/// A number that is not less, with a short numerator; no more than 1 for a number that is not.
pub(in crate::exponential_polynomial) fn rounded_up(number: &BigRational) -> BigRational {
    let scale = BigInt::one() << PRECISION;
    let up = BigRational::new((number * BigRational::from_integer(scale.clone())).ceil().to_integer(), scale);
    if *number <= BigRational::one() { up.min(BigRational::one()) } else { up }
}
