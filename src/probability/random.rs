//! Random numbers by counting: each is a function of the seed, the run, the round and the place, and of nothing else.

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use super::deviate::{self, gauss, logarithm};
use crate::distribution::Distribution;

/// The random numbers of one run.
#[derive(Clone, Copy, Debug)]
pub struct Source {
    key: (u32, u32),
    run: u64,
}

impl Source {
    /// The numbers of a run under a seed.
    pub fn new(seed: u64, run: u64) -> Source {
        Source { key: (seed as u32, (seed >> 32) as u32), run }
    }
}

/// Where random numbers come from.
pub trait Draws {
    /// Two numbers between 0 and 1, neither included: of one round and place always the same.
    fn uniform(&self, round: u64, place: u64) -> (f64, f64);

    /// Two standard normal numbers in place of these.
    fn normal(&self, round: u64, place: u64) -> (f64, f64) {
        gauss(self.uniform(round, place))
    }
}

impl Draws for Source {
    fn uniform(&self, round: u64, place: u64) -> (f64, f64) {
        deviate::uniform(self.key, self.run, round, place)
    }
}

/// The random numbers of several runs in one round, side by side.
#[derive(Clone, Copy, Debug)]
pub struct Sources<'a> {
    /// The seed.
    pub seed: u64,
    /// The runs.
    pub runs: &'a [u64],
    /// The round.
    pub round: u64,
}

/// Places between one draw and the next: for the parts of nested mixtures, the parts of large counts, and one for a pair
/// of normal numbers.
const STRIDE: u64 = 4_096;
/// A count of a larger mean is the sum of several.
const MOST_MEAN: f64 = 500.0;

/// A distribution in machine numbers, to draw from.
#[derive(Clone, Debug, PartialEq)]
pub enum Sampler {
    /// One value for certain.
    Point(f64, BigRational),
    /// Normal: the mean and the standard deviation.
    Normal(f64, f64),
    /// Uniform: the lower bound and the width.
    Uniform(f64, f64),
    /// A start, and the mean of the exponential number that is added.
    Exponential(f64, f64),
    /// A number of arrivals: how many parts of which mean add up to it.
    Poisson(u64, f64),
    /// Parts with their weights.
    Mixture(Vec<(f64, Sampler)>),
}

impl Sampler {
    /// To draw from a distribution.
    ///
    /// # Errors
    /// Where its numbers are too large.
    pub fn of(distribution: &Distribution) -> Result<Sampler, String> {
        Ok(match distribution {
            Distribution::Point(at) => Sampler::Point(near(at), at.clone()),
            Distribution::Normal { mean, variance } if variance.is_zero() => Sampler::Point(near(mean), mean.clone()),
            Distribution::Normal { mean, variance } => Sampler::Normal(near(mean), near(variance).sqrt()),
            Distribution::Uniform { low, high } if low == high => Sampler::Point(near(low), low.clone()),
            Distribution::Uniform { low, high } => Sampler::Uniform(near(low), near(&(high - low))),
            Distribution::Exponential { rate, start, rising } => {
                let mean = near(&rate.recip());
                Sampler::Exponential(near(start), if *rising { mean } else { -mean })
            }
            Distribution::Poisson { mean } => {
                let parts = (near(mean) / MOST_MEAN).ceil().max(1.0);
                if parts.is_nan() || parts > STRIDE as f64 / 2.0 {
                    return Err(format!("a mean of {mean} arrivals is too large to draw from"));
                }
                Sampler::Poisson(parts as u64, near(mean) / parts)
            }
            Distribution::Mixture(parts) => {
                let part = |(weight, part): &(BigRational, Distribution)| Ok((near(weight), Sampler::of(part)?));
                Sampler::Mixture(parts.iter().map(part).collect::<Result<_, String>>()?)
            }
        })
    }

    /// Whether all that it draws are exact numbers.
    pub fn is_discrete(&self) -> bool {
        match self {
            Sampler::Point(..) | Sampler::Poisson(..) => true,
            Sampler::Mixture(parts) => parts.iter().all(|(_, part)| part.is_discrete()),
            _ => false,
        }
    }

    /// The part of a mixture that is drawn, with the place at which its number is.
    fn part(&self, source: &impl Draws, round: u64, place: u64) -> (&Sampler, u64) {
        let (mut sampler, mut place) = (self, place * STRIDE);
        while let Sampler::Mixture(parts) = sampler {
            let (mut left, _) = source.uniform(round, place);
            place += 1;
            let Some((_, last)) = parts.last() else { break };
            sampler = last;
            for (weight, part) in parts {
                left -= weight;
                if left <= 0.0 {
                    sampler = part;
                    break;
                }
            }
        }
        (sampler, place)
    }

    /// The number drawn at a place.
    pub fn draw(&self, source: &impl Draws, round: u64, place: u64) -> f64 {
        if let Sampler::Normal(mean, sd) = self {
            let (first, second) = pair(source, round, place);
            return mean + sd * if place.is_multiple_of(2) { first } else { second };
        }
        let (sampler, place) = self.part(source, round, place);
        match sampler {
            Sampler::Point(at, _) => *at,
            Sampler::Normal(mean, sd) => mean + sd * source.normal(round, place).0,
            Sampler::Uniform(low, width) => low + width * source.uniform(round, place).0,
            Sampler::Exponential(start, mean) => start - mean * logarithm(source.uniform(round, place).0),
            Sampler::Poisson(parts, mean) => {
                (0..*parts).map(|part| arrivals(*mean, source.uniform(round, place + part).0)).sum()
            }
            Sampler::Mixture(_) => f64::NAN,
        }
    }

    /// The number drawn at a place, exactly, where it is discrete.
    pub fn exactly(&self, source: &impl Draws, round: u64, place: u64) -> Option<BigRational> {
        match self.part(source, round, place).0 {
            Sampler::Point(_, at) => Some(at.clone()),
            Sampler::Poisson(..) => BigRational::from_float(self.draw(source, round, place)),
            _ => None,
        }
    }
}

impl Sources<'_> {
    /// What the first of these samplers draw at a place and beside it, by run: of one of them, or of two.
    pub fn draw(&self, samplers: &[Sampler], place: u64) -> Vec<Vec<f64>> {
        let own = |place: u64| deviate::uniforms(Source::new(self.seed, 0).key, self.runs, self.round, place);
        let scaled = |mut column: Vec<f64>, mean: f64, sd: f64| {
            column.iter_mut().for_each(|number| *number = mean + sd * *number);
            column
        };
        match samplers {
            [Sampler::Normal(mean, sd), rest @ ..] => {
                let [one, other] = deviate::normals(own(beside(place)));
                match rest {
                    [Sampler::Normal(mean2, sd2), ..] if place.is_multiple_of(2) => {
                        vec![scaled(one, *mean, *sd), scaled(other, *mean2, *sd2)]
                    }
                    _ => vec![scaled(if place.is_multiple_of(2) { one } else { other }, *mean, *sd)],
                }
            }
            [Sampler::Uniform(low, width), ..] => {
                let [one, _] = own(place * STRIDE);
                vec![scaled(one, *low, *width)]
            }
            [Sampler::Exponential(start, mean), ..] => {
                let [mut one, _] = own(place * STRIDE);
                one.iter_mut().for_each(|number| *number = start - mean * logarithm(*number));
                vec![one]
            }
            [Sampler::Point(at, _), ..] => vec![vec![*at; self.runs.len()]],
            [sampler, ..] => {
                let draw = |run: &u64| sampler.draw(&Source::new(self.seed, *run), self.round, place);
                vec![self.runs.iter().map(draw).collect()]
            }
            [] => Vec::new(),
        }
    }
}

/// Where the pair of a place and the one beside it is drawn.
fn beside(place: u64) -> u64 {
    (place & !1) * STRIDE + STRIDE - 1
}

/// Two standard normal numbers for a place and the one beside it.
pub fn pair(source: &impl Draws, round: u64, place: u64) -> (f64, f64) {
    source.normal(round, beside(place))
}

fn near(number: &BigRational) -> f64 {
    number.to_f64().unwrap_or(f64::NAN)
}

/// The count at which the chances, summed, pass a number.
fn arrivals(mean: f64, uniform: f64) -> f64 {
    let mut chance = (-mean).exp();
    let (mut sum, mut count) = (chance, 0.0);
    while sum < uniform && count < 20.0 * mean + 1_000.0 {
        count += 1.0;
        chance *= mean / count;
        sum += chance;
    }
    count
}
