//! The normal distribution in machine numbers, fast and with a stated error.

use std::sync::OnceLock;

use crate::interval::Interval;

/// A bound on the relative error of [`density`] for a given argument of at most 14 in size, beyond what the rounding
/// of that argument's square makes: the series errs by less than 1e-17, the rest by a few units in the last place.
pub const DENSITY_ERROR: f64 = 1e-13;
/// A bound on the absolute error of [`distribution`].
pub const DISTRIBUTION_ERROR: f64 = 2e-15;

/// `ln 2` in two parts, of which the first has so few digits that its multiples are exact.
const LOGARITHM_HIGH: f64 = 0.693_147_180_369_123_8;
const LOGARITHM_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// `1/sqrt(2*pi)`
const FACTOR: f64 = 0.398_942_280_401_432_7;

/// The density of a standard normal number.
pub fn density(place: f64) -> f64 {
    FACTOR * exponential(-0.5 * place * place)
}

/// `e^power`, or 0 where that is next to it, for a power of at most 700.
pub fn exponential(power: f64) -> f64 {
    if power < -700.0 {
        return 0.0;
    }
    let count = (power * std::f64::consts::LOG2_E + WHOLE) - WHOLE;
    let rest = (power - count * LOGARITHM_HIGH) - count * LOGARITHM_LOW;
    // |rest| < 0.35: after the 13th power comes less than 0.35^14/14! < 5e-18.
    let mut sum = 1.0;
    for term in INVERSES.iter().rev() {
        sum = 1.0 + sum * rest * term;
    }
    sum * f64::from_bits(((1023 + count as i64) as u64) << 52)
}

/// `3 * 2^51`: adding and subtracting it rounds to the nearest whole number, as machine numbers of its size have no places
/// behind the point.
const WHOLE: f64 = 6_755_399_441_055_744.0;

const INVERSES: [f64; 13] = [
    1.0,
    1.0 / 2.0,
    1.0 / 3.0,
    1.0 / 4.0,
    1.0 / 5.0,
    1.0 / 6.0,
    1.0 / 7.0,
    1.0 / 8.0,
    1.0 / 9.0,
    1.0 / 10.0,
    1.0 / 11.0,
    1.0 / 12.0,
    1.0 / 13.0,
];

/// Beyond this the chance is less than 1e-18 away from 0 or 1.
const LARGEST: f64 = 9.0;
/// Places of the table for each unit.
const DENSE: f64 = 32.0;
/// Places on each side of 0.
const SIDE: usize = 289;

/// The chance that a standard normal number is at most this: by Taylor's series to the seventh power round a place of
/// a table at most 1/64 away. The eighth derivative is at most 0.4*1.09*sqrt(7!) < 31, so the rest is less than
/// 31*(1/64)^8/8! < 3e-18.
pub fn distribution(place: f64) -> f64 {
    if place <= -LARGEST {
        return 0.0;
    }
    if place >= LARGEST {
        return 1.0;
    }
    if place.is_nan() {
        return 0.0;
    }
    let number = (place * DENSE + WHOLE) - WHOLE;
    let gap = place - number / DENSE;
    let index = (number + SIDE as f64 - 1.0) as usize;
    let Some(row) = TABLE.get_or_init(table).get(index) else { return f64::NAN };
    let mut sum = 0.0;
    for factor in row[1..].iter().rev() {
        sum = (sum + factor) * gap;
    }
    row[0] + sum
}

/// Chance and seven derivatives over their factorials.
type Row = [f64; 8];

static TABLE: OnceLock<Vec<Row>> = OnceLock::new();

fn table() -> Vec<Row> {
    let half: Vec<f64> = (0..SIDE)
        .map(|number| {
            let chance = Interval::exactly(-(number as f64) / DENSE).normal();
            f64::midpoint(chance.low, chance.high)
        })
        .collect();
    let side = SIDE as i32 - 1;
    (-side..=side)
        .map(|number| {
            let place = f64::from(number) / DENSE;
            let below = half[number.unsigned_abs() as usize];
            let mut row = [if number > 0 { 1.0 - below } else { below }; 8];
            // The derivatives are (-1)^n He_n(x) density(x), with He_(n+1) = x He_n - n He_(n-1).
            let (mut before, mut now, mut factorial) = (0.0, 1.0, 1.0);
            for order in 1..8 {
                factorial *= f64::from(order);
                let sign = if order % 2 == 1 { 1.0 } else { -1.0 };
                row[order as usize] = sign * now * density(place) / factorial;
                (before, now) = (now, place * now - f64::from(order - 1) * before);
            }
            row
        })
        .collect()
}
