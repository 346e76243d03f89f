//! The same affine maps applied many times, in whole numbers of many bits: where much cancels, or there are very many rounds,
//! machine numbers tell too little.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::interval::Interval;

/// Bits behind the point.
const BITS: u32 = 640;
/// Numbers with more bits than this are given up.
const MOST_BITS: u64 = 8_000;

/// Between these, over `2^BITS`, a number lies.
#[derive(Clone, PartialEq, Eq, Debug)]
struct Between {
    low: BigInt,
    high: BigInt,
}

impl Between {
    fn of(number: &BigRational) -> Between {
        let scaled = number.numer() << BITS;
        Between { low: scaled.div_floor(number.denom()), high: scaled.div_ceil(number.denom()) }
    }

    fn is_zero(&self) -> bool {
        self.low.is_zero() && self.high.is_zero()
    }

    fn add_product(&mut self, one: &Between, other: &Between) {
        if one.is_zero() || other.is_zero() {
            return;
        }
        let ends = [&one.low * &other.low, &one.low * &other.high, &one.high * &other.low, &one.high * &other.high];
        let scale = BigInt::one() << BITS;
        if let (Some(low), Some(high)) = (ends.iter().min(), ends.iter().max()) {
            self.low += low.div_floor(&scale);
            self.high += high.div_ceil(&scale);
        }
    }

    fn bits(&self) -> u64 {
        self.low.bits().max(self.high.bits())
    }

    fn interval(&self) -> Interval {
        let scale = BigInt::one() << BITS;
        let end = |end: &BigInt| Interval::of(&BigRational::new(end.clone(), scale.clone()));
        Interval::between(end(&self.low).low, end(&self.high).high)
    }
}

/// The first number of a state after an affine map, given by its rows of factors and what is added, applied so many times;
/// none where numbers grow too long.
pub(super) fn power(map: &[Vec<BigRational>], state: &[BigRational], mut times: u64) -> Option<Interval> {
    let mut state: Vec<Between> = state.iter().map(Between::of).collect();
    let mut now: Vec<Vec<Between>> = map.iter().map(|row| row.iter().map(Between::of).collect()).collect();
    while times > 0 {
        if times % 2 == 1 {
            state = now.iter().map(|row| applied(row, &state)).collect::<Option<_>>()?;
        }
        times /= 2;
        if times > 0 {
            now = squared(&now)?;
        }
        let numbers = state.iter().chain(now.iter().flatten());
        if numbers.map(Between::bits).any(|bits| bits > MOST_BITS) {
            return None;
        }
    }
    state.first().map(Between::interval)
}

fn applied(row: &[Between], state: &[Between]) -> Option<Between> {
    let (added, factors) = row.split_last()?;
    let mut sum = added.clone();
    factors.iter().zip(state).for_each(|(factor, number)| sum.add_product(factor, number));
    Some(sum)
}

/// An affine map applied twice.
fn squared(map: &[Vec<Between>]) -> Option<Vec<Vec<Between>>> {
    let twice = |row: &Vec<Between>| -> Option<Vec<Between>> {
        let (added, factors) = row.split_last()?;
        let nothing = Between { low: BigInt::zero(), high: BigInt::zero() };
        let mut sums = vec![nothing; factors.len()];
        sums.push(added.clone());
        for (factor, other) in factors.iter().zip(map) {
            sums.iter_mut().zip(other).for_each(|(sum, number)| sum.add_product(factor, number));
        }
        Some(sums)
    };
    map.iter().map(twice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_narrow(interval: Interval) -> bool {
        interval.high - interval.low <= 1e-13 * interval.low.abs().max(interval.high.abs())
    }

    fn number(above: i64, below: i64) -> BigRational {
        BigRational::new(above.into(), below.into())
    }

    #[test]
    fn maps_are_applied_as_exact_numbers_are() {
        // x' = x + (y - x)/3 + 1/7, y' = 9/10 y - x/5.
        let map =
            [vec![number(2, 3), number(1, 3), number(1, 7)], vec![number(-1, 5), number(9, 10), BigRational::zero()]];
        let mut exact = vec![number(4, 1), number(-3, 2)];
        for times in 0..40_u64 {
            let found = power(&map, &[number(4, 1), number(-3, 2)], times).expect("short numbers");
            let here = Interval::of(&exact[0]);
            assert!(found.low <= here.high && here.low <= found.high, "{times}: {found:?} {here:?}");
            assert!(is_narrow(found) || exact[0].is_zero(), "{times}: {found:?}");
            let next = |row: &Vec<BigRational>| &row[0] * &exact[0] + &row[1] * &exact[1] + &row[2];
            exact = map.iter().map(next).collect();
        }
    }

    #[test]
    fn what_cancels_stays_narrow() {
        // x' = 3/2 x - 1/2 y, y' = x: both converge, by factors of 1 and 1/2, with entries that add up to more.
        let map = [
            vec![number(3, 2), number(-1, 2), BigRational::zero()],
            vec![BigRational::one(), BigRational::zero(), BigRational::zero()],
        ];
        let found = power(&map, &[number(1, 3), number(1, 7)], 1_000_000).expect("short numbers");
        // x -> 2 x0 - y0.
        assert!(is_narrow(found) && found.low <= 11.0 / 21.0 + 1e-15 && found.high >= 11.0 / 21.0 - 1e-15, "{found:?}");
    }

    #[test]
    fn numbers_that_grow_without_end_are_given_up() {
        assert_eq!(power(&[vec![number(2, 1), BigRational::zero()]], &[BigRational::one()], 1_000_000), None);
    }
}
