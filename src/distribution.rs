//! Distributions of one real number as data: exact parameters, sums and affine images where they are closed, chances
//! in intervals that surely hold them.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::interval::{Interval, normal_between};
use crate::rational::{difference, product, quotient};
use crate::value::{Value, View};

/// A distribution. Its parameters are valid: variances and widths are not negative, weights add up to 1.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Distribution {
    /// One value for certain.
    Point(BigRational),
    /// Normal.
    Normal {
        /// Its mean.
        mean: BigRational,
        /// Its variance, at least 0.
        variance: BigRational,
    },
    /// Uniform between two bounds.
    Uniform {
        /// The lower bound.
        low: BigRational,
        /// The upper bound.
        high: BigRational,
    },
    /// A start with an exponential number added (`rising`) or taken away.
    Exponential {
        /// The rate, positive: one over the mean of what is added.
        rate: BigRational,
        /// Where it starts.
        start: BigRational,
        /// Whether the exponential number is added.
        rising: bool,
    },
    /// The number of arrivals, when they come at random with this mean in all.
    Poisson {
        /// The mean, at least 0.
        mean: BigRational,
    },
    /// One of several, each with its weight.
    Mixture(Vec<(BigRational, Distribution)>),
}

/// The largest mean of a Poisson distribution whose chances are summed; beyond it they are only known to be chances.
const MOST_MEAN: f64 = 100_000.0;

/// Chances of which nothing is known.
const ANY: Interval = Interval { low: 0.0, high: 1.0 };
const NEVER: Interval = Interval::exactly(0.0);
const SURE: Interval = Interval::exactly(1.0);

impl Distribution {
    /// The distribution that a value stands for.
    ///
    /// # Errors
    /// What is missing: a parameter that is no number, or that no distribution has.
    pub fn of(value: &Value) -> Result<Distribution, String> {
        let View::Distribution(kind, arguments) = value.view() else {
            return Err(format!("{value} is no distribution with numbers"));
        };
        if kind == "Mix" {
            let mut parts = Vec::new();
            for pair in arguments.chunks(2) {
                let [weight, part] = pair else { return Err("a mixture lacks a weight".to_string()) };
                parts.push((number(weight)?, Distribution::of(part)?));
            }
            let total: BigRational = parts.iter().map(|(weight, _)| weight.clone()).sum();
            if !total.is_one() || parts.iter().any(|(weight, _)| weight.is_negative()) {
                return Err(format!("the weights of {value} are not chances that add up to 1"));
            }
            return Ok(Distribution::Mixture(parts));
        }
        let numbers: Vec<BigRational> = arguments.iter().map(number).collect::<Result<_, _>>()?;
        match (kind.as_str(), numbers.as_slice()) {
            ("Point", [at]) => Ok(Distribution::Point(at.clone())),
            ("Normal", [_, variance]) if variance.is_negative() => Err(format!("{value} has a negative variance")),
            ("Normal", [mean, variance]) => Ok(Distribution::Normal { mean: mean.clone(), variance: variance.clone() }),
            ("Uniform", [low, high]) if low > high => Err(format!("the bounds of {value} are the wrong way round")),
            ("Uniform", [low, high]) if low == high => Ok(Distribution::Point(low.clone())),
            ("Uniform", [low, high]) => Ok(Distribution::Uniform { low: low.clone(), high: high.clone() }),
            ("Exp", [rate]) if !rate.is_positive() => Err(format!("{value} has a rate that is not positive")),
            ("Exp", [rate]) => {
                Ok(Distribution::Exponential { rate: rate.clone(), start: BigRational::zero(), rising: true })
            }
            ("Poisson", [rate]) if !rate.is_positive() => Err(format!("{value} has a rate that is not positive")),
            ("Poisson", [rate]) => Ok(Distribution::Poisson { mean: rate.clone() }),
            _ => Err(format!("{value} is no distribution of a number")),
        }
    }

    /// The mean.
    pub fn mean(&self) -> BigRational {
        match self {
            Distribution::Point(at) => at.clone(),
            Distribution::Normal { mean, .. } | Distribution::Poisson { mean } => mean.clone(),
            Distribution::Uniform { low, high } => (low + high) / two(),
            Distribution::Exponential { rate, start, rising } => {
                if *rising {
                    start + rate.recip()
                } else {
                    start - rate.recip()
                }
            }
            Distribution::Mixture(parts) => parts.iter().map(|(weight, part)| weight * part.mean()).sum(),
        }
    }

    /// The variance.
    pub fn variance(&self) -> BigRational {
        match self {
            Distribution::Point(_) => BigRational::zero(),
            Distribution::Normal { variance, .. } => variance.clone(),
            Distribution::Poisson { mean } => mean.clone(),
            Distribution::Uniform { low, high } => {
                let width = high - low;
                &width * &width / BigRational::from_integer(12.into())
            }
            Distribution::Exponential { rate, .. } => (rate * rate).recip(),
            Distribution::Mixture(parts) => {
                let mean = self.mean();
                let part = |(weight, part): &(BigRational, Distribution)| {
                    let apart = part.mean() - &mean;
                    weight * (part.variance() + &apart * &apart)
                };
                parts.iter().map(part).sum()
            }
        }
    }

    /// Of `factor` times the number, plus `shift`; nothing where that is no distribution of this kind.
    pub fn affine(&self, factor: &BigRational, shift: &BigRational) -> Option<Distribution> {
        let image = |number: &BigRational| factor * number + shift;
        if factor.is_zero() {
            return Some(Distribution::Point(shift.clone()));
        }
        Some(match self {
            Distribution::Point(at) => Distribution::Point(image(at)),
            Distribution::Normal { mean, variance } => {
                Distribution::Normal { mean: image(mean), variance: factor * factor * variance }
            }
            Distribution::Uniform { low, high } if factor.is_negative() => {
                Distribution::Uniform { low: image(high), high: image(low) }
            }
            Distribution::Uniform { low, high } => Distribution::Uniform { low: image(low), high: image(high) },
            Distribution::Exponential { rate, start, rising } => Distribution::Exponential {
                rate: rate / factor.abs(),
                start: image(start),
                rising: *rising != factor.is_negative(),
            },
            Distribution::Poisson { .. } if factor.is_one() && shift.is_zero() => self.clone(),
            Distribution::Poisson { .. } => return None,
            Distribution::Mixture(parts) => {
                let part =
                    |(weight, part): &(BigRational, Distribution)| Some((weight.clone(), part.affine(factor, shift)?));
                Distribution::Mixture(parts.iter().map(part).collect::<Option<_>>()?)
            }
        })
    }

    /// Of the sum with an independent number; nothing where that is no distribution of this kind.
    pub fn plus(&self, other: &Distribution) -> Option<Distribution> {
        use Distribution::{Mixture, Normal, Point, Poisson};
        match (self, other) {
            (Mixture(parts), other) | (other, Mixture(parts)) => {
                let part = |(weight, part): &(BigRational, Distribution)| Some((weight.clone(), part.plus(other)?));
                Some(Mixture(parts.iter().map(part).collect::<Option<_>>()?))
            }
            (Point(at), other) | (other, Point(at)) => other.affine(&BigRational::one(), at),
            (Normal { mean, variance }, Normal { mean: mean2, variance: variance2 }) => {
                Some(Normal { mean: mean + mean2, variance: variance + variance2 })
            }
            (Poisson { mean }, Poisson { mean: mean2 }) => Some(Poisson { mean: mean + mean2 }),
            _ => None,
        }
    }

    /// The chance of a number of at most `bound`.
    pub fn at_most(&self, bound: &BigRational) -> Interval {
        match self {
            Distribution::Point(at) => certain(at <= bound),
            Distribution::Normal { mean, variance } if variance.is_zero() => certain(mean <= bound),
            Distribution::Normal { mean, variance } => standard(bound, mean, variance).normal(),
            Distribution::Uniform { low, high } if low == high => certain(low <= bound),
            Distribution::Uniform { low, high } => {
                if bound <= low {
                    NEVER
                } else if bound >= high {
                    SURE
                } else {
                    Interval::of(&((bound - low) / (high - low))).probability()
                }
            }
            Distribution::Exponential { rate, start, rising } => {
                let passed = if *rising { bound - start } else { start - bound } * rate;
                if passed.is_positive() {
                    if *rising { arrived(&passed) } else { Interval::of(&-passed).exponential().probability() }
                } else {
                    certain(!rising)
                }
            }
            Distribution::Poisson { mean } => poisson_at_most(mean, bound),
            Distribution::Mixture(parts) => weighted(parts, |part| part.at_most(bound)),
        }
    }

    /// The chance of a number greater than `bound`, to full relative accuracy where that is small.
    pub fn more_than(&self, bound: &BigRational) -> Interval {
        match self {
            Distribution::Normal { mean, variance } if !variance.is_zero() => {
                standard(bound, mean, variance).opposite().normal()
            }
            Distribution::Uniform { low, high } if bound > low && bound < high => {
                Interval::of(&((high - bound) / (high - low))).probability()
            }
            Distribution::Exponential { .. } => match self.affine(&-BigRational::one(), &BigRational::zero()) {
                Some(mirrored) => mirrored.at_most(&-bound.clone()),
                None => ANY,
            },
            Distribution::Poisson { mean } => poisson_more_than(mean, bound),
            Distribution::Mixture(parts) => weighted(parts, |part| part.more_than(bound)),
            _ => SURE.minus(self.at_most(bound)).probability(),
        }
    }

    /// The chance of a number from `low` to `high`, both included.
    pub fn between(&self, low: &BigRational, high: &BigRational) -> Interval {
        if low > high {
            return NEVER;
        }
        match self {
            Distribution::Point(at) => certain(low <= at && at <= high),
            Distribution::Normal { mean, variance } if variance.is_zero() => certain(low <= mean && mean <= high),
            Distribution::Normal { mean, variance } => {
                normal_between(standard(low, mean, variance), standard(high, mean, variance))
            }
            Distribution::Mixture(parts) => weighted(parts, |part| part.between(low, high)),
            Distribution::Poisson { mean } => poisson_between(mean, low, high),
            Distribution::Uniform { low: start, high: end } if start < end => {
                let (from, to) = (low.max(start), high.min(end));
                if from >= to { NEVER } else { Interval::of(&((to - from) / (end - start))).probability() }
            }
            // Without atoms; the smaller of the two tails is subtracted from.
            _ => {
                let left = self.at_most(high).minus(self.at_most(low));
                let right = self.more_than(low).minus(self.more_than(high));
                let both = Interval::between(left.low.max(right.low), left.high.min(right.high));
                if self.is_certain() {
                    certain(low <= &self.mean() && &self.mean() <= high)
                } else {
                    both.probability()
                }
            }
        }
    }

    /// Whether nothing below a number is ever drawn.
    pub fn is_never_below(&self, number: &BigRational) -> bool {
        match self {
            Distribution::Point(at) => at >= number,
            Distribution::Normal { mean, variance } => variance.is_zero() && mean >= number,
            Distribution::Uniform { low, .. } => low >= number,
            Distribution::Exponential { start, rising, .. } => *rising && start >= number,
            Distribution::Poisson { .. } => !number.is_positive(),
            Distribution::Mixture(parts) => parts.iter().all(|(_, part)| part.is_never_below(number)),
        }
    }

    /// Whether a number has a positive chance, or lies where the density is positive.
    pub fn supports(&self, number: &BigRational) -> bool {
        match self {
            Distribution::Point(at) => at == number,
            Distribution::Normal { mean, variance } => variance.is_positive() || mean == number,
            Distribution::Uniform { low, high } => (low < number && number < high) || (low == high && low == number),
            Distribution::Exponential { start, rising: true, .. } => number > start,
            Distribution::Exponential { start, .. } => number < start,
            Distribution::Poisson { mean } => {
                number.is_integer() && !number.is_negative() && (mean.is_positive() || number.is_zero())
            }
            Distribution::Mixture(parts) => {
                parts.iter().any(|(weight, part)| weight.is_positive() && part.supports(number))
            }
        }
    }

    fn is_certain(&self) -> bool {
        self.variance().is_zero()
    }

    /// The parts that it is a mixture of, none of them a mixture itself, with their weights.
    pub fn parts(&self) -> Vec<(BigRational, Distribution)> {
        let Distribution::Mixture(parts) = self else { return vec![(BigRational::one(), self.clone())] };
        let mut all = Vec::new();
        for (weight, part) in parts.iter().filter(|(weight, _)| !weight.is_zero()) {
            all.extend(part.parts().into_iter().map(|(share, part)| (weight * share, part)));
        }
        all
    }

    /// The same as a mixture of normals and points, if it is one: weights, means, variances.
    pub fn normals(&self) -> Option<Vec<(BigRational, BigRational, BigRational)>> {
        match self {
            Distribution::Point(at) => Some(vec![(BigRational::one(), at.clone(), BigRational::zero())]),
            Distribution::Normal { mean, variance } => Some(vec![(BigRational::one(), mean.clone(), variance.clone())]),
            Distribution::Mixture(parts) => {
                let mut all = Vec::new();
                for (weight, part) in parts.iter().filter(|(weight, _)| !weight.is_zero()) {
                    let inner = part.normals()?;
                    all.extend(inner.into_iter().map(|(share, mean, variance)| (weight * share, mean, variance)));
                }
                Some(all)
            }
            _ => None,
        }
    }
}

fn two() -> BigRational {
    BigRational::from_integer(2.into())
}

fn number(value: &Value) -> Result<BigRational, String> {
    value.as_rational().ok_or_else(|| format!("{value} is not a number"))
}

fn certain(holds: bool) -> Interval {
    if holds { SURE } else { NEVER }
}

/// `(bound - mean) / sd`
pub(crate) fn standard(bound: &BigRational, mean: &BigRational, variance: &BigRational) -> Interval {
    let gap = difference(bound, mean);
    if gap.is_zero() && !variance.is_zero() {
        return Interval::exactly(0.0);
    }
    // Squared, the quotient is exact; its root is then taken once.
    let square = Interval::of(&quotient(&product(&gap, &gap), variance)).root();
    if gap.is_negative() { square.opposite() } else { square }
}

fn weighted(parts: &[(BigRational, Distribution)], chance: impl Fn(&Distribution) -> Interval) -> Interval {
    let parts = parts.iter().filter(|(weight, _)| !weight.is_zero());
    let all = parts.map(|(weight, part)| Interval::of(weight).times(chance(part)));
    all.reduce(Interval::plus).unwrap_or(NEVER).probability()
}

/// `1 - e^-passed` for a positive number.
fn arrived(passed: &BigRational) -> Interval {
    let exact = Interval::of(passed);
    if exact.high > 0.5 {
        return SURE.minus(exact.opposite().exponential()).probability();
    }
    // x - x^2/2 + x^3/6 - …: the terms fall and alternate, so the rest is less than the last.
    let (mut term, mut sum) = (exact, exact);
    for place in 2..24u32 {
        term = term.times(exact).over(Interval::exactly(-f64::from(place)));
        sum = sum.plus(term);
    }
    let rest = term.low.abs().max(term.high.abs());
    sum.plus(Interval::between(-rest, rest)).probability()
}

/// The chances of `from`, `from + 1`, …, `to` arrivals.
fn poisson_sum(mean: &BigRational, from: u64, to: Option<u64>) -> Interval {
    let rate = Interval::of(mean);
    if rate.high > MOST_MEAN {
        return ANY;
    }
    let mut arrivals = Arrivals::none(rate);
    for place in 1..=from {
        arrivals.next(rate, place);
    }
    let mut term = arrivals.chance();
    let mut sum = term;
    let mut place = from;
    while to.is_none_or(|to| place < to) {
        place += 1;
        arrivals.next(rate, place);
        term = arrivals.chance();
        sum = sum.plus(term);
        // From twice the mean on each term is less than half of the one before: the rest is less than this term.
        if place as f64 > 2.0 * rate.high && (term.high < sum.low * 1e-18 || term.high <= 2.0f64.powi(-SCALED)) {
            sum = sum.plus(Interval::between(0.0, term.high));
            break;
        }
    }
    sum.probability()
}

/// The chances of `from`, `from + 1`, …, `to` arrivals, each by itself; none where the mean is too large.
pub(crate) fn arrivals_of_each(mean: &BigRational, from: u64, to: u64) -> Option<Vec<Interval>> {
    let rate = Interval::of(mean);
    if rate.high > MOST_MEAN {
        return None;
    }
    let mut arrivals = Arrivals::none(rate);
    (1..=from).for_each(|place| arrivals.next(rate, place));
    let mut all = vec![arrivals.chance()];
    for place in from + 1..=to {
        arrivals.next(rate, place);
        all.push(arrivals.chance());
    }
    Some(all)
}

/// The chance of so many arrivals, which may be less than a machine number is: times a power of two.
struct Arrivals {
    times: Interval,
    exponent: i32,
}

/// The power of two by which it is scaled.
const SCALED: i32 = 512;

impl Arrivals {
    /// Of none.
    fn none(rate: Interval) -> Arrivals {
        // The exponential of a rate that is large is that of equal parts of it, multiplied.
        let parts = (rate.high / 300.0).ceil().max(1.0);
        let part = rate.over(Interval::exactly(parts)).opposite().exponential();
        let mut found = Arrivals { times: Interval::exactly(1.0), exponent: 0 };
        for _ in 0..parts as u64 {
            found.times = found.times.times(part);
            found.scale();
        }
        found
    }

    /// Of this number, from that of one fewer.
    fn next(&mut self, rate: Interval, place: u64) {
        self.times = self.times.times(rate).over(Interval::exactly(place as f64));
        self.scale();
    }

    fn scale(&mut self) {
        let power = |exponent: i32| Interval::exactly(2.0f64.powi(exponent));
        if self.times.high > 0.0 && self.times.high < 2.0f64.powi(-SCALED) {
            self.times = self.times.times(power(SCALED));
            self.exponent = self.exponent.saturating_sub(SCALED);
        } else if self.times.low > 1.0 && self.exponent < 0 {
            self.times = self.times.times(power(-SCALED));
            self.exponent += SCALED;
        }
    }

    fn chance(&self) -> Interval {
        match self.exponent {
            0 => self.times,
            exponent if exponent >= -SCALED => self.times.times(Interval::exactly(2.0f64.powi(exponent))),
            // Less than 2^512 times 2^-1024.
            _ => Interval::between(0.0, 2.0f64.powi(-SCALED)),
        }
    }
}

/// The whole number up to which arrivals count.
fn whole(bound: &BigRational) -> Option<u64> {
    bound.floor().to_integer().to_u64().filter(|count| *count < 1_000_000)
}

fn poisson_at_most(mean: &BigRational, bound: &BigRational) -> Interval {
    match whole(bound) {
        _ if bound.is_negative() => NEVER,
        None => ANY,
        Some(count) if bound > mean => SURE.minus(poisson_sum(mean, count + 1, None)).probability(),
        Some(count) => poisson_sum(mean, 0, Some(count)),
    }
}

fn poisson_more_than(mean: &BigRational, bound: &BigRational) -> Interval {
    match whole(bound) {
        _ if bound.is_negative() => SURE,
        None => ANY,
        // The tail falls from its first number on, or nearly so: it is summed itself, to full relative accuracy.
        Some(count) if bound + BigRational::one() > *mean => poisson_sum(mean, count + 1, None),
        Some(count) => SURE.minus(poisson_sum(mean, 0, Some(count))).probability(),
    }
}

fn poisson_between(mean: &BigRational, low: &BigRational, high: &BigRational) -> Interval {
    let first = if low.is_positive() { low.ceil() } else { BigRational::zero() };
    if high.is_negative() || first > *high {
        return NEVER;
    }
    match (whole(&first), whole(high)) {
        (Some(from), Some(to)) => poisson_sum(mean, from, Some(to)),
        _ => ANY,
    }
}
