//! The chance that one of two independent numbers lies between lines over the other.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::distribution::{Distribution, standard};
use crate::interval::{Interval, normal_between};

/// How many means, or spreads, an unbounded number is followed for; what lies beyond is bounded.
const FAR: i64 = 40;
const FAR_NORMAL: i64 = 8;
/// Into how many cells an integral is cut that has no closed form.
const CELLS: usize = 4_000;

/// The line `slope*x + shift`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) slope: BigRational,
    pub(super) shift: BigRational,
}

impl Line {
    fn at(&self, place: &BigRational) -> BigRational {
        &self.slope * place + &self.shift
    }

    fn crossing(&self, other: &Line) -> Option<BigRational> {
        let apart = &self.slope - &other.slope;
        (!apart.is_zero()).then(|| (&other.shift - &self.shift) / apart)
    }
}

/// A number x and one that is to lie above and below lines over x.
pub(super) struct Pair<'a> {
    pub(super) along: &'a Distribution,
    pub(super) other: &'a Distribution,
    pub(super) above: Vec<Line>,
    pub(super) below: Vec<Line>,
}

impl Pair<'_> {
    /// The chance for x between these bounds, and whether it is as close as rounding lets it be.
    pub(super) fn chance(&self, low: Option<&BigRational>, high: Option<&BigRational>) -> (Interval, bool) {
        let Some((from, to, beyond)) = reach(self.along, low, high) else {
            return (Interval::between(0.0, 1.0), false);
        };
        let mut places = vec![from.clone(), to.clone()];
        let ends = [support(self.other).0, support(self.other).1];
        let level = |bound: BigRational| Line { slope: BigRational::zero(), shift: bound };
        let lines: Vec<Line> =
            self.above.iter().chain(&self.below).cloned().chain(ends.into_iter().flatten().map(level)).collect();
        for (place, line) in lines.iter().enumerate() {
            places.extend(lines[..place].iter().filter_map(|other| line.crossing(other)));
        }
        places.retain(|place| *place >= from && *place <= to);
        places.sort();
        places.dedup();
        let (mut sum, mut exact) = (Interval::exactly(0.0), true);
        for ends in places.windows(2) {
            let [a, b] = ends else { continue };
            let middle = (a + b) / BigRational::from_integer(2.into());
            let lowest = self.above.iter().max_by_key(|line| line.at(&middle));
            let highest = self.below.iter().min_by_key(|line| line.at(&middle));
            if let (Some(lowest), Some(highest)) = (lowest, highest)
                && lowest.at(&middle) >= highest.at(&middle)
            {
                continue;
            }
            let all = self.along.between(a, b);
            let mut below = |line: Option<&Line>, none: Interval| match line {
                Some(line) => {
                    let (found, closed) = self.under(line, a, b);
                    exact &= closed;
                    found
                }
                None => none,
            };
            let (under, over) = (below(highest, all), below(lowest, Interval::exactly(0.0)));
            sum = sum.plus(within(under.minus(over), all));
        }
        let sum = sum.plus(Interval::between(0.0, beyond)).probability();
        (sum, exact)
    }

    /// The chance that x lies from a to b, and the other number below a line over x that does not cross an end of its
    /// support there; and whether it has a closed form.
    fn under(&self, line: &Line, a: &BigRational, b: &BigRational) -> (Interval, bool) {
        let all = self.along.between(a, b);
        let middle = line.at(&((a + b) / BigRational::from_integer(2.into())));
        let (least, most) = support(self.other);
        if least.is_some_and(|least| middle <= least) {
            return (Interval::exactly(0.0), true);
        }
        if most.is_some_and(|most| middle >= most) {
            return (all, true);
        }
        if line.slope.is_zero() {
            return (within(self.other.at_most(&line.shift).times(all), all), true);
        }
        if let Some(above) = self.decayed(line, a, b) {
            return (within(all.minus(above), all), true);
        }
        if let (Distribution::Uniform { .. }, Distribution::Uniform { .. }) = (self.along, self.other) {
            // Along the line the chance grows evenly.
            return (within(self.other.at_most(&middle).times(all), all), true);
        }
        (within(self.cells(line, a, b), all), false)
    }

    /// For an exponential number: the chance that x lies from a to b, and the number above a line over x, that is the
    /// integral of `e^(-rate (line(x) - start))`; none where that is not computed well.
    fn decayed(&self, line: &Line, a: &BigRational, b: &BigRational) -> Option<Interval> {
        let Distribution::Exponential { rate, start, rising: true } = self.other else { return None };
        let slope = rate * &line.slope;
        let shift = rate * (&line.shift - start);
        let power = |exponent: BigRational| Interval::of(&exponent).exponential();
        // The integral of e^(-fall x - constant) from a to b.
        let integral = |fall: &BigRational, constant: &BigRational| {
            if fall.is_zero() {
                return Interval::of(&(b - a)).times(power(-constant));
            }
            let (first, last) = (power(-(fall * a) - constant), power(-(fall * b) - constant));
            first.minus(last).over(Interval::of(fall))
        };
        let found = match self.along {
            Distribution::Exponential { rate: own, start: from, rising: true } => {
                Interval::of(own).times(integral(&(own + &slope), &(&shift - own * from)))
            }
            Distribution::Uniform { low, high } => integral(&slope, &shift).over(Interval::of(&(high - low))),
            Distribution::Normal { mean, variance } => {
                let moved = mean - &slope * variance;
                let two = BigRational::from_integer(2.into());
                let exponent = &slope * &slope * variance / two - &slope * mean - &shift;
                let inside = normal_between(standard(a, &moved, variance), standard(b, &moved, variance));
                power(exponent).times(inside)
            }
            _ => return None,
        };
        (found.width() < 1e-9).then_some(found)
    }

    /// The same by cells. In a cell round m the distribution function is `F(m) + F'(m) slope (x-m)` and an error of second
    /// order; the integral of `x-m` is one of third order, by how fast the density of x changes.
    fn cells(&self, line: &Line, a: &BigRational, b: &BigRational) -> Interval {
        let count = BigRational::from_integer(CELLS.into());
        let width = (b - a) / &count;
        let half = Interval::of(&(&width / BigRational::from_integer(2.into()))).high;
        let slope = Interval::of(&line.slope.abs()).high;
        let (density, change) = steepness(self.other);
        let (_, own_change) = steepness(self.along);
        let first = slope * density * own_change * half * half * half * 0.7;
        let second = slope * slope * change * half * half * 0.51;
        let mut sum = Interval::exactly(0.0);
        let mut from = a.clone();
        for _ in 0..CELLS {
            let to = &from + &width;
            let middle = &from + &width / BigRational::from_integer(2.into());
            let weight = self.along.between(&from, &to);
            let level = self.other.at_most(&line.at(&middle));
            let error = (second * weight.high + first) * 1.000_001;
            sum = sum.plus(level.times(weight)).plus(Interval::between(-error, error));
            from = to;
        }
        sum
    }
}

/// A chance that is part of another.
fn within(found: Interval, all: Interval) -> Interval {
    Interval::between(found.low.clamp(0.0, all.high), found.high.clamp(0.0, all.high))
}

/// Where a number may lie.
fn support(distribution: &Distribution) -> (Option<BigRational>, Option<BigRational>) {
    match distribution {
        Distribution::Uniform { low, high } => (Some(low.clone()), Some(high.clone())),
        Distribution::Exponential { start, rising: true, .. } => (Some(start.clone()), None),
        _ => (None, None),
    }
}

/// Bounds where there is none, and the chance of what lies beyond those.
fn reach(
    distribution: &Distribution,
    low: Option<&BigRational>,
    high: Option<&BigRational>,
) -> Option<(BigRational, BigRational, f64)> {
    let (least, most) = match distribution {
        Distribution::Normal { mean, variance } => {
            // At least the spread.
            let spread = BigRational::from_float(Interval::of(variance).root().high)?;
            let far = spread * BigRational::from_integer(FAR_NORMAL.into());
            (mean - &far, mean + &far)
        }
        Distribution::Exponential { rate, start, rising: true } => {
            (start.clone(), start + BigRational::from_integer(FAR.into()) / rate)
        }
        Distribution::Uniform { low, high } => (low.clone(), high.clone()),
        _ => return None,
    };
    let (from, to) = (
        low.map_or(least.clone(), |low| low.max(&least).clone()),
        high.map_or(most.clone(), |high| high.min(&most).clone()),
    );
    let cut = |bounded: bool, chance: Interval| if bounded { 0.0 } else { chance.high };
    let (below, above) = (low.is_some_and(|low| *low >= least), high.is_some_and(|high| *high <= most));
    let beyond = cut(below, distribution.at_most(&least)) + cut(above, distribution.more_than(&most));
    Some((from.min(to.clone()), to, beyond * 1.000_001))
}

/// How great the density is at most, and how fast it changes within the support.
fn steepness(distribution: &Distribution) -> (f64, f64) {
    match distribution {
        Distribution::Normal { variance, .. } => {
            let variance = Interval::of(variance);
            (Interval::exactly(0.4).over(variance.root()).high, Interval::exactly(0.243).over(variance).high)
        }
        Distribution::Exponential { rate, .. } => {
            let rate = Interval::of(rate);
            (rate.high, rate.times(rate).high)
        }
        Distribution::Uniform { low, high } => (Interval::of(&(BigRational::one() / (high - low))).high, 0.0),
        _ => (f64::INFINITY, f64::INFINITY),
    }
}
