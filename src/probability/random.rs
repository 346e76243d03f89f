//! Random numbers by counting: each is a function of the seed, the run, the round and the place, and of nothing else.

use num_rational::BigRational;
use num_traits::ToPrimitive;

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

    /// Four words for a place: the generator Philox 4x32 with ten rounds (Salmon and others, 2011).
    fn words(&self, round: u64, place: u64) -> [u32; 4] {
        let mut words = [self.run as u32, (self.run >> 32) as u32, round as u32, place as u32];
        let mut key = self.key;
        for _ in 0..10 {
            let first = u64::from(words[0]) * 0xD251_1F53;
            let second = u64::from(words[2]) * 0xCD9E_8D57;
            words = [
                (second >> 32) as u32 ^ words[1] ^ key.0,
                second as u32,
                (first >> 32) as u32 ^ words[3] ^ key.1,
                first as u32,
            ];
            key = (key.0.wrapping_add(0x9E37_79B9), key.1.wrapping_add(0xBB67_AE85));
        }
        words
    }

    /// Two numbers between 0 and 1, neither included.
    pub fn uniform(&self, round: u64, place: u64) -> (f64, f64) {
        let [a, b, c, d] = self.words(round, place);
        let unit = |high: u32, low: u32| {
            let bits = (u64::from(high) << 32 | u64::from(low)) >> 12;
            (bits as f64 + 0.5) / (1u64 << 52) as f64
        };
        (unit(a, b), unit(c, d))
    }
}

/// Places between one draw and the next, for the parts of nested mixtures.
const STRIDE: u64 = 64;

/// A number drawn from a distribution.
pub fn draw(distribution: &Distribution, source: &Source, round: u64, place: u64) -> f64 {
    let mut distribution = distribution;
    let mut place = place * STRIDE;
    // A mixture first draws which of its parts it is.
    while let Distribution::Mixture(parts) = distribution {
        let (mut left, _) = source.uniform(round, place);
        place += 1;
        let Some((_, last)) = parts.last() else { return f64::NAN };
        distribution = last;
        for (weight, part) in parts {
            left -= near(weight);
            if left <= 0.0 {
                distribution = part;
                break;
            }
        }
    }
    let (one, other) = source.uniform(round, place);
    match distribution {
        Distribution::Point(at) => near(at),
        Distribution::Normal { mean, variance } => {
            let angle = std::f64::consts::TAU * other;
            near(mean) + near(variance).sqrt() * (-2.0 * one.ln()).sqrt() * angle.cos()
        }
        Distribution::Uniform { low, high } => near(low) + (near(high) - near(low)) * one,
        Distribution::Exponential { rate, start, rising } => {
            let passed = -one.ln() / near(rate);
            near(start) + if *rising { passed } else { -passed }
        }
        Distribution::Poisson { mean } => arrivals(near(mean), one),
        Distribution::Mixture(_) => f64::NAN,
    }
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
