//! What a way does on one axis, in machine numbers: densities, the chances of its guards, and bounds on what these err
//! by and on how they grow away from the reals.

use std::ops::Deref;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::normal::{DENSITY_ERROR, DISTRIBUTION_ERROR, density, distribution};
use super::plan::{Decider, Gate, Motion, PLACES};
use super::region::Set;
use crate::rational::{difference, product, quotient};

/// A unit in the last place.
pub const UNIT: f64 = f64::EPSILON;
/// Standard deviations beyond which a density is taken for nothing.
pub const BAND: f64 = 9.0;

/// A set in machine numbers.
pub type Ranges = Vec<(f64, f64)>;

/// The sets of a patch on one axis: the state, the decider, the gates.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisRanges {
    /// The sets.
    pub sets: [Ranges; PLACES],
    /// Numbers of which the density counts: the place, and where it is taken; the sum of these.
    pub points: Vec<(usize, Vec<f64>)>,
}

impl Deref for AxisRanges {
    type Target = [Ranges; PLACES];

    fn deref(&self) -> &[Ranges; PLACES] {
        &self.sets
    }
}

impl AxisRanges {
    /// Where the density of the number at a place counts.
    pub fn at(&self, place: usize) -> Option<&[f64]> {
        self.points.iter().find(|(own, _)| *own == place).map(|(_, points)| points.as_slice())
    }
}

/// A motion in machine numbers, over a state that is scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Fast {
    /// The factor of the state.
    pub slope: f64,
    /// What is added.
    pub shift: f64,
    /// The standard deviation of the noise.
    pub sd: f64,
    /// What decides.
    pub guard: Guard,
    /// What decides too: factors, what is added, and standard deviations.
    pub gates: Vec<(f64, f64, f64)>,
}

/// What decides, in machine numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum Guard {
    /// Nothing.
    Nothing,
    /// The next state.
    Next,
    /// A number of its own, scaled to a variance of about 1.
    Noisy {
        /// How it depends on the state.
        factor: f64,
        /// What is added.
        offset: f64,
        /// Its standard deviation.
        sd: f64,
        /// How its mean follows the next state.
        follows: f64,
        /// Its standard deviation once the next state is known.
        rest: f64,
    },
}

/// The power of 4 that brings a variance near 1, and its root.
pub fn scale(variance: &BigRational) -> (BigRational, BigRational) {
    let bits = |number: &BigInt| i64::try_from(number.bits()).unwrap_or(i64::MAX);
    let half = (bits(variance.denom()) - bits(variance.numer())).div_euclid(2);
    let power = |exponent: i64| {
        let two = BigInt::from(2).pow(u32::try_from(exponent.unsigned_abs()).unwrap_or(u32::MAX));
        if exponent < 0 { BigRational::new(BigInt::one(), two) } else { BigRational::from_integer(two) }
    };
    if variance.is_zero() { (BigRational::one(), BigRational::one()) } else { (power(2 * half), power(half)) }
}

/// The nearest machine number, or almost.
pub fn near(number: &BigRational) -> f64 {
    let word = |part: &BigInt| part.to_i64().filter(|part| part.unsigned_abs() < 1 << f64::MANTISSA_DIGITS);
    if let (Some(top), Some(bottom)) = (word(number.numer()), word(number.denom())) {
        return top as f64 / bottom as f64;
    }
    number.to_f64().unwrap_or(f64::NAN)
}

impl Fast {
    /// The motion over a state that is multiplied by `unit`.
    pub fn of(motion: &Motion, unit: &BigRational) -> Fast {
        let variance = product(&product(&motion.variance, unit), unit);
        let guard = match &motion.decider {
            Decider::Nothing => Guard::Nothing,
            Decider::Next => Guard::Next,
            Decider::Noisy { factor, offset, variance: own, covariance } => {
                let (square, root) = scale(own);
                let (own, covariance) = (product(own, &square), product(&product(covariance, &root), unit));
                let still = variance.is_zero();
                let follows = if still { BigRational::zero() } else { quotient(&covariance, &variance) };
                let rest = difference(&own, &product(&follows, &covariance));
                Guard::Noisy {
                    factor: near(&quotient(&product(factor, &root), unit)),
                    offset: near(&product(offset, &root)),
                    sd: near(&own).sqrt(),
                    follows: near(&follows),
                    rest: near(&rest).max(0.0).sqrt(),
                }
            }
        };
        let gate = |gate: &Gate| {
            let (square, root) = scale(&gate.variance);
            let sd = near(&product(&gate.variance, &square)).sqrt();
            (near(&quotient(&product(&gate.factor, &root), unit)), near(&product(&gate.offset, &root)), sd)
        };
        Fast {
            slope: near(&motion.slope),
            shift: near(&product(&motion.shift, unit)),
            sd: near(&variance).sqrt(),
            guard,
            gates: motion.gates.iter().map(gate).collect(),
        }
    }

    /// The sets of a patch on this axis, in the scale of what they are about.
    pub fn ranges(motion: &Motion, unit: &BigRational, sets: &[Set]) -> AxisRanges {
        let ranges = |place: usize, set: &Set| {
            let variance = match (&motion.decider, place) {
                (Decider::Noisy { variance, .. }, 1) => Some(variance),
                (_, 0 | 1) => None,
                _ => motion.gates.get(place - 2).map(|gate| &gate.variance),
            };
            let scale = variance.map_or_else(|| unit.clone(), |variance| scale(variance).1);
            let end =
                |end: &Option<BigRational>, other: f64| end.as_ref().map_or(other, |end| near(&product(end, &scale)));
            set.iter().map(|(low, high)| (end(low, f64::NEG_INFINITY), end(high, f64::INFINITY))).collect()
        };
        let sets = std::array::from_fn(|place| sets.get(place).map(|set| ranges(place, set)).unwrap_or_default());
        AxisRanges { sets, points: Vec::new() }
    }

    /// How the number at a place of a patch is scaled, and its standard deviation then, once the next state is known; none
    /// for a number without noise of its own.
    pub fn scaled(&self, motion: &Motion, place: usize, unit: &BigRational) -> Option<(BigRational, f64)> {
        match (&motion.decider, &self.guard, place) {
            (Decider::Noisy { variance, .. }, Guard::Noisy { rest, .. }, 1) => Some((scale(variance).1, *rest)),
            (Decider::Next, _, 1) => Some((unit.clone(), self.sd)),
            (_, _, 0) => Some((unit.clone(), 1.0)),
            (_, _, 1) => None,
            _ => Some((scale(&motion.gates.get(place - 2)?.variance).1, self.gates.get(place - 2)?.2)),
        }
    }

    /// Whether all numbers are such that bounds can be computed with them.
    pub fn is_sound(&self) -> bool {
        let guard = match &self.guard {
            Guard::Noisy { factor, offset, sd, follows, rest } => {
                [factor, offset, sd, follows, rest].into_iter().all(|number| number.is_finite())
                    && *sd > 0.0
                    && *rest > 0.0
            }
            _ => true,
        };
        let gates = self.gates.iter().all(|(a, b, sd)| a.is_finite() && b.is_finite() && sd.is_finite() && *sd > 0.0);
        guard && gates && self.slope.is_finite() && self.shift.is_finite() && self.sd.is_finite()
    }

    /// Where the next state is expected.
    pub fn mean(&self, from: f64) -> f64 {
        self.slope * from + self.shift
    }

    /// The chance that the decider and the gates lie in these.
    pub fn chance(&self, ranges: &AxisRanges, from: f64) -> f64 {
        let own = match (&self.guard, ranges.at(1)) {
            (Guard::Noisy { factor, offset, sd, .. }, Some(points)) => at(points, factor * from + offset, *sd),
            (Guard::Next, Some(points)) => at(points, self.mean(from), self.sd),
            _ if everything(&ranges[1]) => 1.0,
            (Guard::Nothing, _) => 1.0,
            (Guard::Next, _) => between(&ranges[1], self.mean(from), self.sd),
            (Guard::Noisy { factor, offset, sd, .. }, None) => between(&ranges[1], factor * from + offset, *sd),
        };
        own * self.passes(ranges, from)
    }

    /// The chance that the gates lie in these.
    pub fn passes(&self, ranges: &AxisRanges, from: f64) -> f64 {
        let pass = |(place, (factor, offset, sd)): (usize, &(f64, f64, f64))| match ranges.at(place) {
            Some(points) => at(points, factor * from + offset, *sd),
            None if everything(&ranges[place]) => 1.0,
            None => between(&ranges[place], factor * from + offset, *sd),
        };
        (2..).zip(&self.gates).map(pass).product()
    }

    /// Everything that decides: factor of the state, what is added, standard deviation, place of the set.
    pub fn limits(&self) -> impl Iterator<Item = (f64, f64, f64, usize)> {
        let own = match &self.guard {
            Guard::Nothing => None,
            Guard::Next => Some((self.slope, self.shift, self.sd, 1)),
            Guard::Noisy { factor, offset, sd, .. } => Some((*factor, *offset, *sd, 1)),
        };
        let gates =
            self.gates.iter().enumerate().map(|(place, (factor, offset, sd))| (*factor, *offset, *sd, place + 2));
        own.into_iter().chain(gates)
    }

    /// How fast the density grows with the square of the distance from the reals: it is at most `e^(growth * b²/2)`
    /// times as large, in absolute integral over what decides too.
    pub fn growth(&self) -> f64 {
        let guard = match &self.guard {
            Guard::Noisy { follows, rest, .. } if *follows != 0.0 => (follows / rest).powi(2),
            _ => 0.0,
        };
        self.sd.powi(-2) + guard
    }

    /// The same for the state from which it starts; `onward` unless the next state is of no interest.
    pub fn growth_before(&self, onward: bool) -> f64 {
        let gates = self.gates.iter().map(|gate| square(gate.0, gate.2)).sum::<f64>();
        let own = match &self.guard {
            Guard::Noisy { factor, follows, rest, .. } if onward && self.sd > 0.0 => {
                square(self.slope, self.sd) + square(factor - follows * self.slope, *rest)
            }
            Guard::Noisy { factor, sd, .. } => square(*factor, *sd),
            _ => square(self.slope, self.sd),
        };
        own + gates
    }

    /// A bound on what the sum of densities, weighted with chances, errs by in relation to its size, if the states are at
    /// most `reach` in size.
    ///
    /// Each number and each operation errs by at most a unit of the last place. An error d of the standardised place z
    /// changes a density by a share |z| d, and the sum over |z| is below 3/2: `|z| <= 1.22 e^(z²/8)`, and a normal density
    /// times `e^(z²/8)` is one again, wider, of mass 1.155. Densities themselves and weights have their own errors.
    pub fn rounding(&self, reach: f64) -> f64 {
        let mean = 3.0 * UNIT * (self.slope.abs() * reach + self.shift.abs() + reach);
        if self.sd > 0.0 { 1.6 * mean / self.sd + 5.0 * DENSITY_ERROR } else { 0.0 }
    }

    /// A bound on what the chances that everything that decides lies in these err by.
    ///
    /// An error d of a standardised place changes a chance by at most 0.4 d; the standard deviation errs by less than two
    /// units, which changes it by less than one.
    pub fn chance_error(&self, ranges: &AxisRanges, reach: f64) -> f64 {
        let moved = self.slope.abs() * reach + self.shift.abs();
        let ends = |ranges: &Ranges, part: &dyn Fn(f64) -> f64| {
            let ends = ranges.iter().flat_map(|(low, high)| [low.abs(), high.abs()]);
            ends.filter(|end| end.is_finite()).map(part).sum::<f64>()
        };
        let part = |units: f64, argument: f64, sd: f64| UNIT * (0.4 * units * argument / sd + 1.0) + DISTRIBUTION_ERROR;
        let own = match &self.guard {
            Guard::Nothing => 0.0,
            Guard::Next => ends(&ranges[1], &|end| part(3.0, moved + end, self.sd)),
            Guard::Noisy { factor, offset, sd, follows, rest } => {
                // What is left of the variance was computed exactly.
                let alone = factor.abs() * reach + offset.abs();
                let given = alone + follows.abs() * (reach + moved);
                let both = |end: f64| {
                    let given = if self.sd > 0.0 { part(6.0, given + end, *rest) } else { 0.0 };
                    part(3.0, alone + end, *sd) + given
                };
                ends(&ranges[1], &both)
            }
        };
        let gate = |((factor, offset, sd), ranges): (&(f64, f64, f64), &Ranges)| {
            ends(ranges, &|end| part(3.0, factor.abs() * reach + offset.abs() + end, *sd))
        };
        let alone = own + self.gates.iter().zip(&ranges[2..]).map(gate).sum::<f64>();
        alone * self.most(ranges) + self.density_error(ranges, reach)
    }

    /// The same of densities that count: the slope of one is at most 0.25 over the variance.
    fn density_error(&self, ranges: &AxisRanges, reach: f64) -> f64 {
        let moved = self.slope.abs() * reach + self.shift.abs();
        let error = |(place, points): &(usize, Vec<f64>)| {
            let argument = match (&self.guard, place) {
                (Guard::Noisy { factor, offset, follows, .. }, 1) => {
                    factor.abs() * reach + offset.abs() + follows.abs() * (reach + moved)
                }
                (_, 0 | 1) => moved,
                _ => self.gates.get(place - 2).map_or(0.0, |gate| gate.0.abs() * reach + gate.1.abs()),
            };
            let sd = self.least(*place);
            let part = |point: &f64| (1.5 * UNIT * (argument + point.abs()) / sd + DENSITY_ERROR) / sd;
            2.0 * points.iter().map(part).sum::<f64>() * sd / (0.4 * points.len() as f64)
        };
        ranges.points.iter().map(error).sum::<f64>() * self.most(ranges)
    }

    /// A bound on [`Fast::chance`], once the next state is known too: densities may be more than 1.
    pub fn most(&self, ranges: &AxisRanges) -> f64 {
        ranges.points.iter().map(|(place, points)| 0.4 * points.len() as f64 / self.least(*place)).product()
    }

    /// The least standard deviation of the number at a place.
    fn least(&self, place: usize) -> f64 {
        match (&self.guard, place) {
            (Guard::Noisy { rest, .. }, 1) => *rest,
            (_, 0 | 1) => self.sd,
            _ => self.gates.get(place - 2).map_or(self.sd, |gate| gate.2),
        }
    }
}

fn square(factor: f64, sd: f64) -> f64 {
    if factor == 0.0 { 0.0 } else { (factor / sd).powi(2) }
}

/// Whether these are all numbers.
pub fn everything(ranges: &Ranges) -> bool {
    matches!(ranges.as_slice(), [(low, high)] if *low == f64::NEG_INFINITY && *high == f64::INFINITY)
}

/// Whether a number lies in one of these.
pub fn contains(ranges: &Ranges, place: f64) -> bool {
    ranges.iter().any(|(low, high)| *low <= place && place <= *high)
}

/// The density at these places.
pub fn at(points: &[f64], mean: f64, sd: f64) -> f64 {
    points.iter().map(|point| density((point - mean) / sd)).sum::<f64>() / sd
}

fn between(ranges: &Ranges, mean: f64, sd: f64) -> f64 {
    ranges.iter().map(|(low, high)| distribution((high - mean) / sd) - distribution((low - mean) / sd)).sum()
}
