//! Noise that has a density, in machine numbers: its distribution, and how much its density varies.

use super::kernel::near;
use super::normal::{density, distribution};
use crate::distribution::Distribution;

/// How far an exponential number is followed, in its means, and a normal one, in its standard deviations.
const FAR: f64 = 36.0;
const BAND: f64 = 8.3;
/// Densities are known to this share.
const SLACK: f64 = 1e-9;

/// Some noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// The shares, which add up to 1, and the parts.
    pub parts: Vec<(f64, Part)>,
}

/// A kind of noise.
#[derive(Clone, Debug, PartialEq)]
pub enum Part {
    /// Between two numbers.
    Uniform(f64, f64),
    /// With this rate, from a number on upwards or downwards.
    Exponential {
        /// One over the mean of what is added.
        rate: f64,
        /// The number.
        start: f64,
        /// Whether upwards.
        rising: bool,
    },
    /// With this mean and standard deviation.
    Normal(f64, f64),
}

impl Part {
    fn below(&self, place: f64) -> f64 {
        match *self {
            Part::Uniform(low, high) => ((place - low) / (high - low)).clamp(0.0, 1.0),
            Part::Exponential { rate, start, rising: true } => -(-rate * (place - start).max(0.0)).exp_m1(),
            Part::Exponential { rate, start, rising: false } => (-rate * (start - place).max(0.0)).exp(),
            Part::Normal(mean, sd) => distribution((place - mean) / sd),
        }
    }

    fn peak(&self) -> f64 {
        match *self {
            Part::Uniform(low, high) => 1.0 / (high - low),
            Part::Exponential { rate, .. } => rate,
            Part::Normal(_, sd) => 0.4 / sd,
        }
    }

    /// The density; at an edge, where it is positive.
    fn density(&self, place: f64) -> f64 {
        match *self {
            Part::Uniform(low, high) if place < low || place > high => 0.0,
            Part::Uniform(..) => self.peak(),
            Part::Exponential { rate, start, rising } => {
                let passed = if rising { place - start } else { start - place };
                if passed < 0.0 { 0.0 } else { rate * (-rate * passed).exp() }
            }
            Part::Normal(mean, sd) => density((place - mean) / sd) / sd,
        }
    }

    fn varies(&self, low: f64, high: f64) -> f64 {
        let both = |place: f64| self.density(place);
        match *self {
            Part::Uniform(start, end) => {
                let inside = |edge: f64| f64::from(low <= edge && edge <= high);
                (inside(start) + inside(end)) * self.peak()
            }
            Part::Exponential { start, .. } | Part::Normal(start, _) if low <= start && start <= high => {
                2.0 * self.peak() - both(low) - both(high)
            }
            _ => (both(low) - both(high)).abs(),
        }
    }
}

impl Noise {
    /// The noise of a distribution.
    ///
    /// # Errors
    /// Where some number has a chance of its own.
    pub fn of(distribution: &Distribution) -> Result<Noise, String> {
        let part = |part: &Distribution| match part {
            Distribution::Uniform { low, high } if low < high => Ok(Part::Uniform(near(low), near(high))),
            Distribution::Exponential { rate, start, rising } => {
                Ok(Part::Exponential { rate: near(rate), start: near(start), rising: *rising })
            }
            Distribution::Normal { mean, variance } if !num_traits::Zero::is_zero(variance) => {
                Ok(Part::Normal(near(mean), near(variance).sqrt()))
            }
            _ => Err("a round draws one of single numbers as well (`Point`, `Poisson`)".to_string()),
        };
        let parts = distribution.parts().into_iter().map(|(share, one)| Ok((near(&share), part(&one)?)));
        Ok(Noise { parts: parts.collect::<Result<_, String>>()? })
    }

    /// Numbers between which it lies but for a share that is not worth following.
    pub fn reach(&self) -> (f64, f64) {
        let reach = |(_, part): &(f64, Part)| match *part {
            Part::Uniform(low, high) => (low, high),
            Part::Exponential { rate, start, rising: true } => (start, start + FAR / rate),
            Part::Exponential { rate, start, rising: false } => (start - FAR / rate, start),
            Part::Normal(mean, sd) => (mean - BAND * sd, mean + BAND * sd),
        };
        let reaches = self.parts.iter().map(reach);
        reaches.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))).unwrap_or((0.0, 0.0))
    }

    /// The chance of less than a number.
    pub fn below(&self, place: f64) -> f64 {
        match self.parts.as_slice() {
            [(_, only)] => only.below(place),
            parts => parts.iter().map(|(share, part)| share * part.below(place)).sum(),
        }
    }

    /// A bound on the density.
    pub fn peak(&self) -> f64 {
        self.parts.iter().map(|(share, part)| share * part.peak()).sum()
    }

    /// What the density varies by in all.
    pub fn variation(&self) -> f64 {
        2.0 * self.peak()
    }

    /// What the density varies by between two numbers, at most.
    pub fn varies(&self, low: f64, high: f64) -> f64 {
        // Edges are met where rounding might miss them.
        let slack = 8.0 * f64::EPSILON * (low.abs() + high.abs());
        let varies =
            |(share, part): &(f64, Part)| share * (part.varies(low - slack, high + slack) + SLACK * part.peak());
        self.parts.iter().map(varies).sum()
    }
}
