//! Chances as text: as many digits as are known, and no more.

use num_rational::BigRational;

use crate::interval::Interval;
use crate::probability::Enclosed;
use crate::value::Value;

/// A chance that is known exactly, as far as it can be printed.
pub(super) fn told(found: &Enclosed) -> String {
    found.number().map_or_else(|| between(&found.interval(), SURE), rational)
}

/// The longest rational that is printed, in bytes.
const LONG: usize = 40;

/// A rational exactly, where that is short, and as a decimal.
pub(super) fn rational(number: &BigRational) -> String {
    let near = num_traits::ToPrimitive::to_f64(number).unwrap_or(f64::NAN);
    if !near.is_finite() {
        // More than machine numbers hold: its size by the lengths of what stands above and below.
        let bits = i128::from(number.numer().bits()) - i128::from(number.denom().bits());
        let sign = if num_traits::Signed::is_negative(number) { "-" } else { "" };
        return format!("about {sign}10^{}", bits * 30_103 / 100_000);
    }
    let near = decimal(near);
    let exact = Value::rational(number.clone()).to_string();
    if exact == near || exact.len() > LONG { near } else { format!("{exact} = {near}") }
}

/// How wide an interval is at most, in units of the last digit that is printed.
pub(super) const SURE: f64 = 0.5;
pub(super) const LIKELY: f64 = 5.0;

/// The middle, to as many digits as are worth it, and the ends. What is printed lies in the interval.
pub(super) fn between(interval: &Interval, units: f64) -> String {
    estimate(interval, f64::midpoint(interval.low, interval.high), units)
}

/// The same of a number in the interval.
pub(super) fn estimate(interval: &Interval, middle: f64, units: f64) -> String {
    if interval.low == interval.high {
        return decimal(interval.low);
    }
    // The place of the first digit; of what may be 0, no digit is known.
    let first = if interval.low > 0.0 { middle.log10().floor() as i32 } else { 0 };
    let mut places = 12 - first;
    while places > 1 && interval.width() > units * 10f64.powi(-places) {
        places -= 1;
    }
    let ends = format!("between {} and {}", decimal(interval.low), decimal(interval.high));
    if interval.low <= 0.0 {
        return format!("at most {}, {ends}", decimal(interval.high));
    }
    let written = |places: i32| match middle < SMALL {
        true => format!("{middle:.digits$e}", digits = usize::try_from(places + first).unwrap_or_default()),
        false => format!("{middle:.places$}", places = usize::try_from(places).unwrap_or_default()),
    };
    let outside =
        |places: i32| written(places).parse().is_ok_and(|number: f64| number < interval.low || number > interval.high);
    let inside = (places..places + MOST_DIGITS).find(|places| !outside(*places)).unwrap_or(places);
    format!("{}, {ends}", written(inside))
}

/// Digits that a number of the machine has.
const MOST_DIGITS: i32 = 17;

/// Below this a number is written with a power of ten.
const SMALL: f64 = 1e-4;

/// The shortest text that is read as this number.
pub(super) fn decimal(number: f64) -> String {
    if number != 0.0 && number.abs() < SMALL { format!("{number:e}") } else { number.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_lies_in_the_interval() {
        for exponent in -20..0 {
            for (low, width) in [(1.34, 0.07), (1.3418, 0.0737), (9.96, 0.02), (5.5, 1e-9), (1.0, 8.0), (4.4999, 1e-4)]
            {
                for units in [SURE, LIKELY] {
                    let scale = 10f64.powi(exponent);
                    let interval = Interval::between(low * scale, (low + width) * scale);
                    let text = between(&interval, units);
                    let first: f64 = text.split(',').next().and_then(|number| number.parse().ok()).unwrap();
                    assert!(interval.low <= first && first <= interval.high, "{text}");
                }
            }
        }
    }
}
