//! Bounds of numbers that may be very large or very small, with as many leading digits as are kept.

use dashu_float::FBig;
use dashu_float::round::mode::{Down, Up};
use dashu_int::IBig;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::rational::from_whole;

type Low = FBig<Down, 2>;
type High = FBig<Up, 2>;

/// The bits that are kept, and those where they do not tell the leading digits.
pub(super) const PRECISIONS: [usize; 2] = [600, 1 << 17];
/// The largest exponent of two, up or down.
const MOST: isize = 1 << 40;

/// Two numbers between which one lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bounds {
    low: Low,
    high: High,
    /// The bits that are kept.
    precision: usize,
}

impl Bounds {
    /// Those of a number, with so many bits.
    pub(super) fn of(number: &BigRational, precision: usize) -> Bounds {
        let part = |whole: &BigInt| IBig::from_le_bytes(&whole.to_signed_bytes_le());
        let (above, below) = (part(number.numer()), part(number.denom()));
        let bits = (number.numer().bits() + number.denom().bits()) as usize + precision;
        let low = Low::from_parts(above.clone(), 0).with_precision(bits).value() / Low::from_parts(below.clone(), 0);
        let high = High::from_parts(above, 0).with_precision(bits).value() / High::from_parts(below, 0);
        Bounds { low, high, precision }.rounded()
    }

    fn rounded(self) -> Bounds {
        let Bounds { low, high, precision } = self;
        Bounds { low: low.with_precision(precision).value(), high: high.with_precision(precision).value(), precision }
    }

    /// A whole number with as many bits.
    fn whole(&self, number: i64) -> Bounds {
        Bounds::of(&BigRational::from_integer(number.into()), self.precision)
    }

    /// Whether its exponents are small enough for a product to have one, too.
    fn counted(&self) -> bool {
        let small = |exponent: isize| (-MOST..MOST).contains(&exponent);
        small(self.low.repr().exponent()) && small(self.high.repr().exponent())
    }

    pub(super) fn plus(&self, other: &Bounds) -> Bounds {
        Bounds { low: &self.low + &other.low, high: &self.high + &other.high, precision: self.precision }
    }

    /// The greater of both numbers.
    pub(super) fn or_more(&self, other: &Bounds) -> Bounds {
        let (low, high) = (self.low.clone().max(other.low.clone()), self.high.clone().max(other.high.clone()));
        Bounds { low, high, precision: self.precision }
    }

    /// Whether the number is more than 0, where the bounds tell.
    pub(super) fn is_positive(&self) -> Option<bool> {
        match (self.low > Low::ZERO, self.high > High::ZERO) {
            (true, _) => Some(true),
            (_, false) => Some(false),
            _ => None,
        }
    }

    /// The product; none where it is too large or too small.
    pub(super) fn times(&self, other: &Bounds) -> Option<Bounds> {
        let (a, b) = (&self.low, &self.high.clone().with_rounding::<Down>());
        let (c, d) = (&other.low, &other.high.clone().with_rounding::<Down>());
        let low = [a * c, a * d, b * c, b * d].into_iter().min()?;
        let (a, b) = (&self.low.clone().with_rounding::<Up>(), &self.high);
        let (c, d) = (&other.low.clone().with_rounding::<Up>(), &other.high);
        let high = [a * c, a * d, b * c, b * d].into_iter().max()?;
        Some(Bounds { low, high, precision: self.precision }.rounded()).filter(Bounds::counted)
    }

    /// A power, which is not negative where the exponent is even.
    pub(super) fn power(&self, exponent: u64) -> Option<Bounds> {
        let mut whole = self.whole(1);
        let mut square = self.clone();
        let mut left = exponent;
        while left > 0 {
            if left % 2 == 1 {
                whole = whole.times(&square)?;
            }
            left /= 2;
            if left > 0 {
                square = square.times(&square)?;
                // A square is not negative.
                if square.low < Low::ZERO {
                    square.low = self.whole(0).low;
                }
            }
        }
        Some(whole)
    }

    /// The square root; none of what is not known to be at least 0.
    pub(super) fn sqrt(&self) -> Option<Bounds> {
        if self.low < Low::ZERO {
            return None;
        }
        let kept = self.clone().rounded();
        let root = |zero: bool, root: &dyn Fn() -> Bounds| if zero { self.whole(0) } else { root() };
        let low = root(kept.low == Low::ZERO, &|| Bounds { low: kept.low.sqrt(), ..kept.clone() }).low;
        let high = root(kept.high == High::ZERO, &|| Bounds { high: kept.high.sqrt(), ..kept.clone() }).high;
        Some(Bounds { low, high, precision: self.precision })
    }

    /// The largest whole number that is not more.
    pub(super) fn floor(&self) -> Bounds {
        let (low, high) = (self.low.floor(), self.high.floor());
        Bounds { low, high, precision: self.precision }.rounded()
    }

    /// The quotient; none where it is not known to be one.
    pub(super) fn over(&self, other: &Bounds) -> Option<Bounds> {
        if other.low <= Low::ZERO && other.high >= High::ZERO {
            return None;
        }
        let one = self.whole(1);
        let low = &one.low / &other.high.clone().with_rounding::<Down>();
        let high = &one.high / &other.low.clone().with_rounding::<Up>();
        self.times(&Bounds { low, high, precision: self.precision })
    }

    /// Both as numbers of ordinary size times one power of ten, whose exponent is the third.
    pub(super) fn in_tens(&self) -> Option<(BigRational, BigRational, i64)> {
        let size = self.low.repr().exponent() + self.low.digits() as isize;
        let tens = (size as f64 * std::f64::consts::LOG10_2).floor().to_i64()?;
        let power = self.whole(10).power(tens.unsigned_abs())?;
        let scaled = if tens >= 0 { self.over(&power)? } else { self.times(&power)? };
        Some((rational(scaled.low)?, rational(scaled.high.with_rounding::<Down>())?, tens))
    }
}

/// The number as a fraction, where that is not too long.
fn rational(number: Low) -> Option<BigRational> {
    const LONGEST: isize = 1 << 18;
    let repr = number.into_repr();
    let exponent = repr.exponent();
    if !(-LONGEST..LONGEST).contains(&exponent) {
        return None;
    }
    let whole = from_whole(repr.significand());
    let two = BigInt::from(1) << exponent.unsigned_abs();
    Some(if exponent >= 0 { BigRational::from_integer(whole * two) } else { BigRational::new(whole, two) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(top: i64, bottom: i64) -> BigRational {
        BigRational::new(top.into(), bottom.into())
    }

    fn of(number: &BigRational) -> Bounds {
        Bounds::of(number, PRECISIONS[0])
    }

    fn contains(bounds: &Bounds, exact: &BigRational) -> bool {
        let (low, high) = (rational(bounds.low.clone()), rational(bounds.high.clone().with_rounding::<Down>()));
        low.is_some_and(|low| low <= *exact) && high.is_some_and(|high| *exact <= high)
    }

    #[test]
    fn what_is_computed_with_fractions_lies_between() {
        let numbers = [number(1, 3), number(-7, 11), number(22, 7), number(-1, 1_000_003), number(0, 1), number(5, 1)];
        for one in &numbers {
            for other in &numbers {
                let (left, right) = (of(one), of(other));
                assert!(contains(&left.plus(&right), &(one + other)), "{one} + {other}");
                assert!(contains(&left.times(&right).unwrap(), &(one * other)), "{one} * {other}");
                match left.over(&right) {
                    Some(found) => assert!(contains(&found, &(one / other)), "{one} / {other}"),
                    None => assert_eq!(*other, number(0, 1)),
                }
            }
            assert!(contains(&of(one).power(5).unwrap(), &(one * one * one * one * one)), "{one}^5");
        }
    }

    #[test]
    fn a_square_of_what_may_be_negative_is_not() {
        let around = Bounds { low: of(&number(-2, 1)).low, ..of(&number(3, 1)) };
        let square = around.power(2).unwrap();
        assert!(contains(&square, &number(9, 1)) && contains(&square, &number(0, 1)));
        assert!(!contains(&square, &number(-1, 1)));
    }

    #[test]
    fn the_greater_and_the_sign_are_told() {
        for one in [number(-7, 11), number(0, 1), number(1, 3)] {
            assert_eq!(of(&one).is_positive(), Some(one > number(0, 1)), "{one}");
            for other in [number(-1, 2), number(0, 1), number(2, 7)] {
                let greater = of(&one).or_more(&of(&other));
                assert!(contains(&greater, &one.clone().max(other.clone())), "{one} and {other}");
                let less = &one.clone().max(other) - number(1, 1_000_000);
                assert!(!contains(&greater, &less), "{less}");
            }
        }
        let around = Bounds { low: of(&number(-2, 1)).low, ..of(&number(3, 1)) };
        assert_eq!(around.is_positive(), None);
    }

    #[test]
    fn whole_parts_lie_between() {
        for (one, floor) in [(number(-7, 11), -1), (number(22, 7), 3), (number(5, 1), 5), (number(-5, 1), -5)] {
            assert!(contains(&of(&one).floor(), &number(floor, 1)), "{one}");
        }
        let large = of(&number(10, 1)).power(400).unwrap().plus(&of(&number(1, 2)));
        assert!(contains(&large.floor(), &num_traits::pow(number(10, 1), 400)));
    }

    #[test]
    fn a_root_lies_between_roots() {
        for one in [number(0, 1), number(2, 1), number(9, 4), number(1, 1_000_003)] {
            let root = of(&one).sqrt().unwrap();
            assert!(contains(&root.power(2).unwrap(), &one), "{one}");
            let (low, high) = (rational(root.low).unwrap(), rational(root.high.with_rounding::<Down>()).unwrap());
            assert!(&low * &low <= one && one <= &high * &high && &high - &low < number(1, 1 << 60), "{one}");
        }
        assert!(of(&number(-1, 7)).sqrt().is_none());
    }

    #[test]
    fn very_large_and_very_small_numbers_keep_their_digits() {
        // 3^(2^20) has 500298 digits.
        let mut large = of(&number(3, 1));
        for _ in 0..20 {
            large = large.power(2).unwrap();
        }
        let (low, high, tens) = large.in_tens().unwrap();
        // Thirty digits behind the point.
        let digits = |one: &BigRational| (one * num_traits::pow(number(10, 1), 30)).floor().to_integer().to_string();
        assert_eq!(digits(&low)[..30], digits(&high)[..30], "{tens}");
        assert_eq!(digits(&low).len() as i64 - 30 + tens, 500_298);
        let small = of(&number(1, 1)).over(&large).unwrap();
        let product = small.times(&large).unwrap();
        assert!(product.low <= Low::ONE && product.high >= High::ONE);
        // The sum of both is not less than the larger one.
        assert!(large.plus(&small).low >= large.low);
        let mut beyond = large;
        while let Some(next) = beyond.power(2) {
            beyond = next;
        }
    }
}
