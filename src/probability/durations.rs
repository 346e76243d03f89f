//! Durations that are drawn, by themselves: how exponential ones add up, alone and with a normal one.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::Enclosed;
use crate::distribution::{Distribution, standard};
use crate::interval::{Interval, normal_between};

/// The rate of exponential numbers that all have the same one.
pub(super) fn common_rate(all: &[Distribution]) -> Option<BigRational> {
    let rate = |one: &Distribution| match one {
        Distribution::Exponential { rate, rising: true, .. } => Some(rate.clone()),
        _ => None,
    };
    let first = rate(all.first()?)?;
    all.iter().all(|one| rate(one).as_ref() == Some(&first)).then_some(first)
}

pub(super) fn start(one: &Distribution) -> Option<&BigRational> {
    match one {
        Distribution::Exponential { start, .. } => Some(start),
        _ => None,
    }
}

/// The chance that so many exponential numbers of rate 1 add up to at most y: that at least so many come in that time,
/// `e^(-y) Σ y^k/k!` over all k from there on. Where these grow smaller at once, what is left behind one of them is a geometric
/// series at most; else it is what is missing to 1.
pub(super) fn erlang(count: usize, time: &BigRational) -> Enclosed {
    if !time.is_positive() {
        return Enclosed::known(BigRational::zero());
    }
    let y = Interval::of(time);
    let mut term = Interval::of(&-time).exponential();
    let (mut below, mut above) = (Interval::exactly(0.0), Interval::exactly(0.0));
    let rare = y.high < count as f64;
    let mut number = 0;
    loop {
        if number < count {
            below = below.plus(term);
        } else {
            above = above.plus(term);
        }
        number += 1;
        term = term.times(y).over(Interval::exactly(number as f64));
        let ratio = y.high / (number as f64 + 1.0);
        if number >= count && !rare {
            return Enclosed::within(Interval::exactly(1.0).minus(below).probability());
        }
        let small = term.high <= 1e-18 * above.high || term.high < f64::MIN_POSITIVE;
        if number >= count && ratio < 0.5 && small {
            // What is left is at most the next term, twice.
            let left = Interval::between(0.0, 2.1 * term.high + f64::MIN_POSITIVE);
            return Enclosed::within(above.plus(left).probability());
        }
    }
}

/// Whether a number of this distribution is never below 0.
pub(super) fn never_negative(distribution: &Distribution) -> bool {
    match distribution {
        Distribution::Point(at) => !at.is_negative(),
        Distribution::Normal { mean, variance } => variance.is_zero() && !mean.is_negative(),
        Distribution::Uniform { low, .. } => !low.is_negative(),
        Distribution::Exponential { start, rising, .. } => *rising && !start.is_negative(),
        Distribution::Poisson { .. } => true,
        Distribution::Mixture(parts) => parts.iter().all(|(_, part)| never_negative(part)),
    }
}

/// The chance that an exponential number and a normal one, which counts as 0 below that, add up to more than a number t
/// from 0 on: `P(N <= 0) e^(-lt) + ∫ from 0 to t of the density of N at y times e^(-l(t-y)) dy + P(N > t)`. The integral is
/// that of a normal density with the mean moved by `l var`, times `e^(l mean + l² var/2 - lt)`.
pub(super) fn later(rate: &BigRational, mean: &BigRational, variance: &BigRational, time: &BigRational) -> Interval {
    let zero = BigRational::zero();
    let two = BigRational::from_integer(2.into());
    let moved = mean + rate * variance;
    let power = rate * mean + rate * rate * variance / two - rate * time;
    let inside = normal_between(standard(&zero, &moved, variance), standard(time, &moved, variance));
    let none = standard(&zero, mean, variance).normal().times(Interval::of(&(-rate * time)).exponential());
    let middle = inside.times(Interval::of(&power).exponential());
    none.plus(middle).plus(standard(time, mean, variance).opposite().normal())
}
