//! Intervals of machine numbers that surely hold the true value, and the normal distribution in them.
//!
//! Each operation is rounded to the nearest by the machine and then moved out by one number on both sides, which
//! bounds it whatever the rounding. Series are cut with a proved bound on the rest.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

/// A closed interval of reals.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Interval {
    /// Its lower end.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
}

fn down(number: f64) -> f64 {
    if number.is_nan() { f64::NEG_INFINITY } else { number.next_down() }
}

fn up(number: f64) -> f64 {
    if number.is_nan() { f64::INFINITY } else { number.next_up() }
}

/// The same as [`Interval::of`] for a quotient of whole numbers that are machine numbers: what its rounding left over is
/// known exactly, up to a rounding that keeps its sign.
fn short(number: &BigRational) -> Option<Interval> {
    const MOST: u64 = 1 << f64::MANTISSA_DIGITS;
    let (top, bottom) = (number.numer().to_i64()?, number.denom().to_i64()?);
    if top.unsigned_abs() > MOST || bottom.unsigned_abs() > MOST {
        return None;
    }
    let near = top as f64 / bottom as f64;
    let left = near.mul_add(bottom as f64, -(top as f64));
    Some(Interval { low: if left > 0.0 { down(near) } else { near }, high: if left < 0.0 { up(near) } else { near } })
}

impl Interval {
    /// A machine number, exactly.
    pub const fn exactly(number: f64) -> Interval {
        Interval { low: number, high: number }
    }

    /// Between two numbers.
    pub fn between(low: f64, high: f64) -> Interval {
        Interval { low, high }
    }

    /// What lies in both; none where nothing does.
    pub fn common(self, other: Interval) -> Option<Interval> {
        let common = Interval::between(self.low.max(other.low), self.high.min(other.high));
        (common.low <= common.high).then_some(common)
    }

    /// Both ends as rationals; none if one is infinite.
    pub fn bounds(self) -> Option<(BigRational, BigRational)> {
        Some((BigRational::from_float(self.low)?, BigRational::from_float(self.high)?))
    }

    /// The narrowest interval of machine numbers round a rational.
    pub fn of(number: &BigRational) -> Interval {
        if let Some(found) = short(number) {
            return found;
        }
        let near = number.to_f64().unwrap_or(0.0);
        let (mut low, mut high) = (near, near);
        if near.is_finite() {
            match BigRational::from_float(near) {
                Some(exact) if exact == *number => return Interval::exactly(near),
                Some(exact) if exact < *number => high = up(near),
                _ => low = down(near),
            }
            // A conversion that was off by more than a step is mended here.
            while BigRational::from_float(low).is_some_and(|exact| exact > *number) {
                low = down(low);
            }
            while BigRational::from_float(high).is_some_and(|exact| exact < *number) {
                high = up(high);
            }
            return Interval { low, high };
        }
        if number.is_negative() {
            Interval { low: f64::NEG_INFINITY, high: f64::MIN }
        } else {
            Interval { low: f64::MAX, high: f64::INFINITY }
        }
    }

    /// Whether it is 0 alone.
    fn is_nothing(self) -> bool {
        self.low == 0.0 && self.high == 0.0
    }

    /// The sum.
    pub fn plus(self, other: Interval) -> Interval {
        if self.is_nothing() || other.is_nothing() {
            return if self.is_nothing() { other } else { self };
        }
        Interval { low: down(self.low + other.low), high: up(self.high + other.high) }
    }

    /// The difference.
    pub fn minus(self, other: Interval) -> Interval {
        self.plus(other.opposite())
    }

    /// With the other sign.
    pub fn opposite(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }

    /// The product.
    pub fn times(self, other: Interval) -> Interval {
        // So it stays exact, which numbers next to 0 would not, and the machine is slow with these.
        if self.is_nothing() || other.is_nothing() {
            return Interval::exactly(0.0);
        }
        let finite = |one: Interval| one.low > f64::NEG_INFINITY && one.high < f64::INFINITY;
        if finite(self) && finite(other) {
            // Where signs are known, so are the ends.
            if self.low >= 0.0 && other.low >= 0.0 {
                return Interval { low: down(self.low * other.low), high: up(self.high * other.high) };
            }
            if self.low >= 0.0 && other.high <= 0.0 {
                return Interval { low: down(self.high * other.low), high: up(self.low * other.high) };
            }
            if self.high <= 0.0 && other.low >= 0.0 {
                return Interval { low: down(self.low * other.high), high: up(self.high * other.low) };
            }
        }
        // 0 times infinity is 0 here: the infinite end stands for finite numbers of any size.
        let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
        let all = [
            product(self.low, other.low),
            product(self.low, other.high),
            product(self.high, other.low),
            product(self.high, other.high),
        ];
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Interval { low: down(low), high: up(high) }
    }

    /// The quotient; all numbers where the divisor may be 0.
    pub fn over(self, other: Interval) -> Interval {
        if other.low <= 0.0 && other.high >= 0.0 {
            return Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };
        }
        let inverse = Interval { low: down(1.0 / other.high), high: up(1.0 / other.low) };
        self.times(inverse)
    }

    /// The quotient by a positive number.
    fn divided(self, number: f64) -> Interval {
        Interval { low: down(self.low / number), high: up(self.high / number) }
    }

    /// The square root; of what is below 0, none is taken.
    pub fn root(self) -> Interval {
        Interval { low: down(self.low.max(0.0).sqrt()).max(0.0), high: up(self.high.max(0.0).sqrt()) }
    }

    /// The smallest interval round both.
    pub fn hull(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Cut to where a probability lies.
    pub fn probability(self) -> Interval {
        Interval { low: self.low.clamp(0.0, 1.0), high: self.high.clamp(0.0, 1.0) }
    }

    /// How far its ends are apart.
    pub fn width(self) -> f64 {
        up(self.high - self.low)
    }

    /// Whether it holds a number.
    pub fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// e to its power: 2^k times the series of what is left, which is less than 0.35 in size.
    pub fn exponential(self) -> Interval {
        Interval { low: exponential(self.low).low, high: exponential(self.high).high }
    }

    /// The chance that a standard normal number is at most this.
    pub fn normal(self) -> Interval {
        let first = normal(self.low);
        let apart = up(self.high - self.low);
        // Between near places it grows by no more than the greatest density there.
        if apart < NEAR {
            let nearest = if self.low > 0.0 { self.low } else { self.high.min(0.0) };
            let grown = up(apart * Interval::exactly(nearest).normal_density().high);
            return Interval { low: first.low, high: up(first.high + grown).min(1.0) };
        }
        Interval { low: first.low, high: normal(self.high).high }
    }

    /// The density of a standard normal number, at one place.
    pub fn normal_density(self) -> Interval {
        let square = self.times(self);
        let square = Interval { low: square.low.max(0.0), high: square.high };
        square.times(Interval::exactly(-0.5)).exponential().times(ROOT_OF_TWO_PI_INVERSE)
    }
}

/// `1/sqrt(2*pi)` = 0.398942280401432677939946…
const ROOT_OF_TWO_PI_INVERSE: Interval = Interval { low: 0.398_942_280_401_432_6, high: 0.398_942_280_401_432_8 };
/// `ln 2` = 0.693147180559945309417232…
const LOGARITHM_OF_TWO: Interval = Interval { low: 0.693_147_180_559_945_2, high: 0.693_147_180_559_945_4 };
/// Terms of the exponential series: the rest is below 1.1 * 0.35^16/16! < 3e-21.
const TERMS: u32 = 16;
/// From here on the continued fraction of the tail converges fast.
const TAIL: f64 = 2.0;
/// Places that are so near count as one.
const NEAR: f64 = 1e-12;

fn exponential(number: f64) -> Interval {
    if number < -740.0 {
        return Interval { low: 0.0, high: 1e-320 };
    }
    if number > 709.0 {
        return Interval { low: 1e307, high: f64::INFINITY };
    }
    let count = (number * std::f64::consts::LOG2_E).round();
    let rest = Interval::exactly(number).minus(Interval::exactly(count).times(LOGARITHM_OF_TWO));
    let mut sum = Interval::exactly(1.0);
    for term in (1..TERMS).rev() {
        sum = sum.times(rest).divided(f64::from(term)).plus(Interval::exactly(1.0));
    }
    sum = sum.plus(Interval { low: -3e-21, high: 3e-21 });
    // Two factors, so that neither is too small or too large for the machine.
    let half = (count / 2.0).trunc();
    let power = |exponent: f64| Interval::exactly(2f64.powi(exponent as i32));
    let result = sum.times(power(half)).times(power(count - half));
    Interval { low: result.low.max(0.0), high: result.high }
}

/// The chance that a standard normal number is at most this one.
fn normal(number: f64) -> Interval {
    if number == f64::NEG_INFINITY {
        return Interval::exactly(0.0);
    }
    if number == f64::INFINITY {
        return Interval::exactly(1.0);
    }
    if number <= -TAIL {
        return tail(-number).probability();
    }
    if number >= TAIL {
        return Interval::exactly(1.0).minus(tail(number)).probability();
    }
    // 1/2 + density * (x + x^3/3 + x^5/(3*5) + …): all terms have the sign of x, and fall by x^2/(2n+3) < 4/(2n+3).
    let x = Interval::exactly(number.abs());
    let square = x.times(x);
    let (mut term, mut sum) = (x, x);
    let mut divisor = 3.0;
    for place in 0..40 {
        term = term.times(square).divided(divisor);
        sum = sum.plus(term);
        divisor += 2.0;
        if place > 3 && term.high.abs().max(term.low.abs()) < 1e-18 * sum.high.abs() {
            break;
        }
    }
    // After five terms the factor is below 4/13, so the rest is less than the last term.
    let rest = term.low.abs().max(term.high.abs());
    sum = sum.plus(Interval { low: -rest, high: rest });
    let part = sum.times(x.normal_density());
    let part = if number < 0.0 { part.opposite() } else { part };
    Interval::exactly(0.5).plus(part).probability()
}

/// The chance that a standard normal number is more than this one, which is at least [`TAIL`]:
/// `density / (x + 1/(x + 2/(x + 3/(x + …))))`.
fn tail(number: f64) -> Interval {
    let x = Interval::exactly(number);
    // Convergents of even and odd depth lie on both sides of the value, so any depth is right.
    let depth = 16 + (420.0 / (number * number)) as u32;
    let density = x.normal_density();
    let below =
        |place: f64, value: Interval| x.plus(Interval { low: down(place / value.high), high: up(place / value.low) });
    // Both at once, as each waits for its own divisions.
    let (mut one, mut other) = (x, below(f64::from(depth + 1), x));
    for place in (1..=depth).rev() {
        let place = f64::from(place);
        (one, other) = (below(place, one), below(place, other));
    }
    let both = density.over(one).hull(density.over(other));
    Interval { low: both.low.max(0.0), high: both.high }
}

/// The chance that a standard normal number lies between two others, to full relative accuracy in the tails.
pub fn normal_between(low: Interval, high: Interval) -> Interval {
    // Half of all lies on either side of the middle.
    let (middle, ends) = (Interval::exactly(0.0), [f64::NEG_INFINITY, f64::INFINITY].map(Interval::exactly));
    if (low == middle && high == ends[1]) || (low == ends[0] && high == middle) {
        return Interval::exactly(0.5);
    }
    // On the right, the difference of small tails; elsewhere that of small chances.
    let right = low.low > 0.0;
    let (from, to) = if right { (high.opposite(), low.opposite()) } else { (low, high) };
    let difference = to.normal().minus(from.normal());
    Interval { low: difference.low.max(0.0), high: difference.high.clamp(0.0, 1.0) }
}
