//! The first power of a rational number that lies between two numbers.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::exponential_polynomial::enclosed::Enclosed;

/// The most bits of a power that is written down.
const MOST_BITS: u64 = 1 << 15;
/// The same where its first bits do not tell on which side of a number it is.
const MOST_EXACT: u64 = 400_000;
/// The bits of powers that are enclosed, one attempt after the other.
const LENGTHS: [u64; 3] = [128, 512, 2_048];
/// The largest exponent.
const MOST_FAR: u64 = 1 << 50;

/// An interval between numbers.
pub(super) struct Numbers {
    pub(super) low: Option<(BigRational, bool)>,
    pub(super) high: Option<(BigRational, bool)>,
}

impl Numbers {
    pub(super) fn above_low(&self, number: &BigRational) -> bool {
        self.low.as_ref().is_none_or(|(low, strict)| if *strict { number > low } else { number >= low })
    }

    pub(super) fn below_high(&self, number: &BigRational) -> bool {
        self.high.as_ref().is_none_or(|(high, strict)| if *strict { number < high } else { number <= high })
    }

    fn scaled(&self, factor: &BigRational) -> Numbers {
        let scale =
            |bound: &Option<(BigRational, bool)>| bound.as_ref().map(|(number, strict)| (number * factor, *strict));
        let (low, high) = (scale(&self.low), scale(&self.high));
        if factor.is_negative() { Numbers { low: high, high: low } } else { Numbers { low, high } }
    }
}

/// When a power lies between numbers.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    At(u64),
    Never,
    TooFar,
}

/// The least `n >= from` with `ratio^n` between the numbers.
pub(super) fn powers(ratio: &BigRational, numbers: &Numbers, from: u64) -> Found {
    if ratio.is_zero() || ratio.is_one() {
        return few(ratio, numbers, from);
    }
    if ratio.is_positive() {
        return monotone(ratio, numbers, from);
    }
    // Even and odd exponents are monotone each: ratio^(2*m + odd) = ratio^odd * (ratio^2)^m.
    let square = ratio * ratio;
    let mut least = Found::Never;
    for odd in 0..2u64 {
        let factor = if odd == 1 { ratio.clone() } else { BigRational::one() };
        let half = (from.saturating_sub(odd)).div_ceil(2);
        let part = numbers.scaled(&factor.recip());
        let found = if square.is_one() { few(&square, &part, half) } else { monotone(&square, &part, half) };
        least = match (found, least) {
            (Found::TooFar, _) | (_, Found::TooFar) => return Found::TooFar,
            (Found::At(found), Found::At(least)) => Found::At(least.min(2 * found + odd)),
            (Found::At(found), Found::Never) => Found::At(2 * found + odd),
            (Found::Never, least) => least,
        };
    }
    least
}

/// Of a ratio 0 or 1: only the first two powers differ.
fn few(ratio: &BigRational, numbers: &Numbers, from: u64) -> Found {
    for at in [from, from + 1] {
        let power = if at == 0 { BigRational::one() } else { ratio.clone() };
        if numbers.above_low(&power) && numbers.below_high(&power) {
            return Found::At(at);
        }
    }
    Found::Never
}

/// A power of a rational number: its parts stay coprime, so they are multiplied without looking for common factors.
struct Power {
    top: BigInt,
    bottom: BigInt,
}

impl Power {
    fn times(&self, other: &Power) -> Power {
        Power { top: &self.top * &other.top, bottom: &self.bottom * &other.bottom }
    }

    fn order(&self, number: &BigRational) -> Ordering {
        (&self.top * number.denom()).cmp(&(number.numer() * &self.bottom))
    }
}

impl Numbers {
    fn admits(&self, power: &Power, upper: bool) -> bool {
        let (bound, allowed) = if upper { (&self.high, Ordering::Less) } else { (&self.low, Ordering::Greater) };
        bound.as_ref().is_none_or(|(number, strict)| {
            let order = power.order(number);
            order == allowed || (!strict && order == Ordering::Equal)
        })
    }
}

/// Of a positive ratio that is not 1: the powers fall or grow.
fn monotone(ratio: &BigRational, numbers: &Numbers, from: u64) -> Found {
    let falls = *ratio < BigRational::one();
    let entered = |power: &Power| numbers.admits(power, falls);
    if falls && numbers.high.as_ref().is_some_and(|(high, _)| !high.is_positive()) {
        return Found::Never;
    }
    let width = ratio.numer().bits().max(ratio.denom().bits());
    let (Some(exponent), true) = (from.to_u32(), from.saturating_mul(width) <= MOST_BITS) else {
        return far(ratio, numbers, from).unwrap_or(Found::TooFar);
    };
    let mut power = Power { top: ratio.numer().pow(exponent), bottom: ratio.denom().pow(exponent) };
    let mut at = from;
    if !entered(&power) {
        // Longer and longer strides while none is entered, then shorter and shorter ones.
        let mut strides = vec![Power { top: ratio.numer().clone(), bottom: ratio.denom().clone() }];
        loop {
            let (stride, length) = (&strides[strides.len() - 1], 1u64 << (strides.len() - 1));
            let next = power.times(stride);
            if entered(&next) {
                break;
            }
            if (at + 2 * length).saturating_mul(width) > MOST_BITS {
                return far(ratio, numbers, at + length).unwrap_or(Found::TooFar);
            }
            power = next;
            at += length;
            let double = stride.times(stride);
            strides.push(double);
        }
        for (place, stride) in strides.iter().enumerate().rev() {
            let next = power.times(stride);
            if !entered(&next) {
                power = next;
                at += 1 << place;
            }
        }
        power = power.times(&strides[0]);
        at += 1;
    }
    if numbers.admits(&power, !falls) { Found::At(at) } else { Found::Never }
}

/// The same, by the first bits of the powers.
fn far(ratio: &BigRational, numbers: &Numbers, from: u64) -> Option<Found> {
    let falls = *ratio < BigRational::one();
    let admits = |at: u64, upper: bool| {
        let (bound, allowed) = if upper { (&numbers.high, Ordering::Less) } else { (&numbers.low, Ordering::Greater) };
        let Some((number, strict)) = bound else { return Some(true) };
        let order = order(ratio, at, number)?;
        Some(order == allowed || (!strict && order == Ordering::Equal))
    };
    // It is not entered at the earlier of two indices, and at the later it is.
    let (mut earlier, mut later) = (from, from);
    let mut stride = 1;
    while !admits(later, falls)? {
        (earlier, later) = (later, later.checked_add(stride).filter(|later| *later <= MOST_FAR)?);
        stride *= 2;
    }
    while later - earlier > 1 {
        let middle = earlier + (later - earlier) / 2;
        if admits(middle, falls)? { later = middle } else { earlier = middle }
    }
    Some(if admits(later, !falls)? { Found::At(later) } else { Found::Never })
}

/// How a power of a positive number lies to a number.
fn order(ratio: &BigRational, exponent: u64, number: &BigRational) -> Option<Ordering> {
    if !number.is_positive() {
        return Some(Ordering::Greater);
    }
    let enclosed = |bits: u64| {
        let power = Enclosed::of(ratio, bits)?.raised(exponent)?;
        power.plus(&Enclosed::of(&-number, bits)?)?.sign()
    };
    let exact = || {
        let width = ratio.numer().bits().max(ratio.denom().bits());
        let short = exponent.saturating_mul(width) <= MOST_EXACT;
        let power = i32::try_from(exponent).ok().filter(|_| short).map(|exponent| ratio.pow(exponent))?;
        Some(power.cmp(number))
    };
    LENGTHS.into_iter().find_map(enclosed).or_else(exact)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(top: i64, bottom: i64) -> BigRational {
        BigRational::new(top.into(), bottom.into())
    }

    #[test]
    fn the_search_agrees_with_trying() {
        for (top, bottom) in [(9, 10), (1, 2), (3, 2), (-9, 10), (-1, 1), (-3, 2), (1, 3)] {
            let ratio = number(top, bottom);
            for high in 1..40i64 {
                let interval = |low: i64| Numbers {
                    low: Some((number(low, 30), high % 2 == 0)),
                    high: Some((number(high, 20), false)),
                };
                for low in [-50, -3, 0, high] {
                    for from in [0u64, 1, 4] {
                        let numbers = interval(low);
                        let fits = |at: &u64| {
                            let power = ratio.pow(*at as i32);
                            numbers.above_low(&power) && numbers.below_high(&power)
                        };
                        let tried = (from..80).find(fits);
                        let found = powers(&ratio, &numbers, from);
                        assert_eq!(found, tried.map_or(Found::Never, Found::At), "{ratio} {low} {high} {from}");
                    }
                }
            }
        }
    }

    #[test]
    fn far_powers_are_found_by_their_first_bits() {
        let below = |top: i64, bottom: i64| Numbers { low: None, high: Some((number(top, bottom), false)) };
        let slow = number(999_999, 1_000_000);
        assert_eq!(powers(&slow, &below(1, 2), 0), Found::At(693_147));
        // The logarithm of 10^-9 over that of the ratio is 20723255.47…
        assert_eq!(powers(&slow, &below(1, 1_000_000_000), 0), Found::At(20_723_256));
        assert_eq!(powers(&slow, &below(1, 2), 700_000), Found::At(700_000));
        let between = Numbers { low: Some((number(1, 2), true)), high: Some((number(5_000_001, 10_000_000), true)) };
        assert_eq!(powers(&slow, &between, 0), Found::Never);
    }

    #[test]
    fn a_far_power_that_is_met_exactly_is_told_from_its_neighbours() {
        let ratio = number(1, 2);
        let goal = ratio.pow(20_000);
        let numbers = |strict| Numbers { low: None, high: Some((goal.clone(), strict)) };
        assert_eq!(powers(&ratio, &numbers(false), 0), Found::At(20_000));
        assert_eq!(powers(&ratio, &numbers(true), 0), Found::At(20_001));
        let huge = Numbers { low: None, high: Some((number(1, 1), true)) };
        assert_eq!(powers(&number(1_000_000_007, 1_000_000_006), &huge, 3), Found::Never);
    }

    #[test]
    fn far_searches_end() {
        let near = BigRational::new((BigInt::one() << 200) - 1, BigInt::one() << 200);
        let numbers = Numbers { low: None, high: Some((number(1, 1_000_000_000), false)) };
        assert_eq!(powers(&near, &numbers, 0), Found::TooFar);
    }
}
