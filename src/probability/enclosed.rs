//! Chances of a chain in one dimension, by quadrature with a proved bound.
//!
//! The chance V(s) of success within n more rounds from state s satisfies V_0 = 0 and
//! V_n(s) = D(s) + ∫ k(s,x) V_(n-1)(x) dx with a kernel that is a normal density times the chance of going on. On
//! panels of Gauss points the integral is a sum. Four errors are bounded, none by experience:
//!
//! * *discretisation*: k(s,z) and V(z) are analytic between the cuts that guards make, which are ends of panels. Moving
//!   the mean of a normal density by ib multiplies its absolute integral by e^(b²/2σ²), which bounds both at a distance
//!   b from the reals, and with it the error of Gauss's rule ([`grid::Grid::error`]);
//! * *truncation*: states beyond 8 standard deviations of all that the rounds can do, and kernels beyond 9;
//! * *rounding*: each kernel value is known to a stated error, a sum of n terms to n units in the last place;
//! * all of them add up from round to round, as the kernel's total mass is at most 1.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::grid::Grid;
use super::normal::distribution;
use super::scalar::{Decider, Noisy, Range, Scalar, Way};
use crate::distribution::standard;
use crate::interval::{Interval, normal_between};

/// More than the chance beyond 8 standard deviations on both sides.
const BEYOND: f64 = 1.3e-15;

/// A way with machine numbers.
#[derive(Clone, Debug)]
pub(super) struct Fast {
    pub(super) weight: f64,
    pub(super) slope: f64,
    pub(super) shift: f64,
    pub(super) sd: f64,
    pub(super) guard: Guard,
    pub(super) success: Vec<(f64, f64)>,
    pub(super) last: Vec<(f64, f64)>,
    pub(super) onward: Vec<(f64, f64)>,
}

/// What decides a way.
#[derive(Clone, Debug)]
pub(super) enum Guard {
    Nothing,
    Next,
    Noisy {
        factor: f64,
        offset: f64,
        sd: f64,
        /// How its mean follows the next state, and its standard deviation once that is known.
        follows: f64,
        rest: f64,
    },
}

/// The chance, surely between these.
///
/// # Errors
/// Where the window or the kernel grows too large, or a way has no noise.
pub fn enclosed(scalar: &Scalar) -> Result<Interval, String> {
    let start: Vec<Fast> = scalar.start.iter().map(Fast::of).collect();
    let round: Vec<Fast> = scalar.round.iter().map(Fast::of).collect();
    let mut total = Interval::exactly(0.0);
    for way in &scalar.start {
        total = total.plus(at_start(way, if scalar.rounds == 0 { &way.last } else { &way.success }));
    }
    if scalar.rounds == 0 || start.iter().all(|way| way.onward.is_empty()) {
        return Ok(total.probability());
    }
    if round.iter().any(|way| !way.onward.is_empty() && way.sd <= 0.0) {
        return Err("a round adds no noise".to_string());
    }
    let grid = Grid::new(&start, &round, scalar.rounds)?;
    let rows = grid.rows(&round)?;
    let step = grid.error(&round, &round);
    // V_(n-1) on the grid; the last round is evaluated where the start leads.
    let (mut values, mut next) = (vec![0.0; grid.nodes.len()], vec![0.0; grid.nodes.len()]);
    let mut error = step;
    for number in 1..scalar.rounds {
        for (value, row) in next.iter_mut().zip(&rows) {
            *value = row.value(&values, number == 1);
        }
        std::mem::swap(&mut values, &mut next);
        // The kernel's mass is at most 1, and its quadrature errs by no more than a step.
        error = error * (1.0 + step) + step;
    }
    let value = |state: f64| Ok::<f64, String>(grid.row(state, &round)?.value(&values, scalar.rounds == 1));
    for (way, exact) in start.iter().zip(&scalar.start).filter(|(way, _)| !way.onward.is_empty()) {
        let part = if way.sd > 0.0 {
            let fine = Grid::of_start(way)?;
            let there: Vec<f64> = fine.nodes.iter().map(|node| value(*node)).collect::<Result<_, _>>()?;
            error += fine.error(std::slice::from_ref(way), &round);
            Interval::exactly(fine.row(0.0, std::slice::from_ref(way))?.kernel(&there))
        } else {
            Interval::exactly(value(way.shift)?).times(at_start(exact, &exact.onward))
        };
        total = total.plus(part);
    }
    let wide = error + 2.0 * step + BEYOND * (scalar.rounds as f64 + 2.0);
    Ok(Interval::between(total.low - wide, total.high + wide).probability())
}

/// The chance that a way is taken at the start and leads into ranges.
fn at_start(way: &Way, ranges: &[Range]) -> Interval {
    let mut sum = Interval::exactly(0.0);
    for (low, high) in ranges {
        let (mean, variance) = match &way.decider {
            Decider::Nothing => {
                sum = sum.plus(Interval::exactly(1.0));
                continue;
            }
            Decider::Next => (&way.shift, &way.variance),
            Decider::Noisy(noisy) => (&noisy.offset, &noisy.variance),
        };
        let place = |bound: &Option<BigRational>, otherwise: f64| {
            bound.as_ref().map_or(Interval::exactly(otherwise), |bound| standard(bound, mean, variance))
        };
        sum = sum.plus(normal_between(place(low, f64::NEG_INFINITY), place(high, f64::INFINITY)));
    }
    sum.times(Interval::of(&way.weight))
}

fn near(number: &BigRational) -> f64 {
    number.to_f64().unwrap_or(f64::NAN)
}

impl Fast {
    fn of(way: &Way) -> Fast {
        let bounds = |ranges: &[Range]| {
            let bound = |bound: &Option<BigRational>, otherwise: f64| bound.as_ref().map_or(otherwise, near);
            let ends = |(low, high): &Range| (bound(low, f64::NEG_INFINITY), bound(high, f64::INFINITY));
            ranges.iter().map(ends).collect::<Vec<_>>()
        };
        let guard = match &way.decider {
            Decider::Nothing => Guard::Nothing,
            Decider::Next => Guard::Next,
            Decider::Noisy(noisy) => {
                let Noisy { factor, offset, variance, covariance } = noisy.as_ref();
                let next = near(&way.variance);
                let follows = if next > 0.0 { near(&(covariance / &way.variance)) } else { 0.0 };
                let known = if next > 0.0 { covariance * covariance / &way.variance } else { covariance * covariance };
                Guard::Noisy {
                    factor: near(factor),
                    offset: near(offset),
                    sd: near(variance).sqrt(),
                    follows,
                    rest: near(&(variance - known)).sqrt(),
                }
            }
        };
        Fast {
            weight: near(&way.weight),
            slope: near(&way.slope),
            shift: near(&way.shift),
            sd: near(&way.variance).sqrt(),
            guard,
            success: bounds(&way.success),
            last: bounds(&way.last),
            onward: bounds(&way.onward),
        }
    }

    /// The chance of going on, given where from and where to.
    pub(super) fn goes_on(&self, from: f64, to: f64) -> f64 {
        match &self.guard {
            Guard::Nothing => 1.0,
            Guard::Next => f64::from(u8::from(self.onward.iter().any(|(low, high)| *low <= to && to <= *high))),
            Guard::Noisy { factor, offset, follows, rest, .. } => {
                let mean = factor * from + offset + follows * (to - (self.slope * from + self.shift));
                between(&self.onward, mean, *rest)
            }
        }
    }

    /// The chance of success in this round.
    pub(super) fn succeeds(&self, from: f64, last: bool) -> f64 {
        let ranges = if last { &self.last } else { &self.success };
        let chance = match &self.guard {
            _ if ranges.is_empty() => 0.0,
            Guard::Nothing => 1.0,
            Guard::Next => between(ranges, self.slope * from + self.shift, self.sd),
            Guard::Noisy { factor, offset, sd, .. } => between(ranges, factor * from + offset, *sd),
        };
        self.weight * chance
    }
}

fn between(ranges: &[(f64, f64)], mean: f64, sd: f64) -> f64 {
    ranges.iter().map(|(low, high)| distribution((high - mean) / sd) - distribution((low - mean) / sd)).sum()
}
