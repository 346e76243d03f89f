//! Ranges of a drawn number, with the chance of each.

use std::rc::Rc;

use num_rational::BigRational;
use num_traits::Zero;

use crate::distribution::{Distribution, arrivals_of_each};
use crate::interval::{Interval, normal_between};

/// Standard deviations, and mean lengths, beyond which a number is left out; what is left out is counted with what is open.
const FAR: f64 = 38.0;
const LONG: f64 = 740.0;
/// The standard deviations beyond which whole numbers are left out.
const FAR_COUNTS: f64 = 40.0;

/// A range of a drawn number.
#[derive(Clone, Debug)]
pub(super) struct Range {
    kind: Kind,
    /// What it may be.
    pub(super) over: Interval,
    /// The chance that it is there.
    pub(super) chance: Interval,
    /// The standard deviation of all of it.
    scale: f64,
}

#[derive(Clone, Debug)]
enum Kind {
    Point,
    /// A mean and a standard deviation.
    Normal([Interval; 2], Interval),
    /// The ends of all, and the weight.
    Uniform([Interval; 2], Interval),
    /// A rate, and the weight.
    Exponential(Interval, Interval),
    /// Whole numbers: the first, the sums of the chances up to each, and the weight.
    Counts(u64, Rc<[Interval]>, Interval),
}

/// The ranges that a number may be in, at first.
///
/// # Errors
/// For a distribution without such ranges.
pub(super) fn ranges(distribution: &Distribution) -> Result<Vec<Range>, String> {
    let mut all = Vec::new();
    for (weight, part) in distribution.parts() {
        let weight = Interval::of(&weight);
        let variance = Interval::of(&part.variance());
        let (scale, mean) = (variance.high.sqrt().max(f64::MIN_POSITIVE), Interval::of(&part.mean()));
        let range = |kind: Kind, low: f64, high: f64| {
            let over = Interval::between(low, high);
            let chance = kind.chance(over);
            Range { kind, over, chance, scale }
        };
        let about = |far: f64| (mean.low - far * scale, mean.high + far * scale);
        match &part {
            Distribution::Point(at) => all.push(point(at, weight)),
            Distribution::Normal { mean: at, variance } if variance.is_zero() => all.push(point(at, weight)),
            Distribution::Normal { .. } => {
                let (low, high) = about(FAR);
                all.push(range(Kind::Normal([mean, variance.root()], weight), low, high));
            }
            Distribution::Uniform { low, high } => {
                let (low, high) = (Interval::of(low), Interval::of(high));
                let mut found = range(Kind::Uniform([low, high], weight), low.low, high.high);
                found.chance = weight;
                all.push(found);
            }
            Distribution::Exponential { rate, start, rising: true } if start.is_zero() => {
                let rate = Interval::of(rate);
                all.push(range(Kind::Exponential(rate, weight), 0.0, LONG / rate.high));
            }
            Distribution::Poisson { mean: rate } => {
                let (low, high) = about(FAR_COUNTS);
                let (low, high) = (low.floor().max(0.0), (high + FAR_COUNTS).ceil());
                let each = arrivals_of_each(rate, low as u64, high as u64).ok_or("there are too many arrivals")?;
                let mut sum = Interval::exactly(0.0);
                let sums = each.into_iter().map(|chance| {
                    sum = sum.plus(chance);
                    sum
                });
                all.push(range(Kind::Counts(low as u64, sums.collect(), weight), low, high));
            }
            _ => return Err("a distribution that is not followed is drawn from".to_string()),
        }
    }
    Ok(all)
}

fn point(at: &BigRational, weight: Interval) -> Range {
    Range { kind: Kind::Point, over: Interval::of(at), chance: weight, scale: 1.0 }
}

impl Kind {
    /// The chance of a range, with the weight.
    fn chance(&self, over: Interval) -> Interval {
        let [low, high] = [over.low, over.high].map(Interval::exactly);
        match self {
            Kind::Point => Interval::exactly(1.0),
            Kind::Normal([mean, deviation], weight) => {
                let standard = |end: Interval| end.minus(*mean).over(*deviation);
                weight.times(normal_between(standard(low), standard(high)))
            }
            Kind::Uniform([start, end], weight) => {
                // What is left out of the range at its ends is no part of it.
                let from = Interval::between(over.low.max(start.low), over.low.max(start.high));
                let to = Interval::between(over.high.min(end.low), over.high.min(end.high));
                weight.times(to.minus(from).over(end.minus(*start)).probability())
            }
            Kind::Exponential(rate, weight) => {
                let left = |end: Interval| end.times(*rate).opposite().exponential();
                weight.times(left(low).minus(left(high)).probability())
            }
            Kind::Counts(first, sums, weight) => {
                let upto = |number: u64| sums.get(number.checked_sub(*first)? as usize).copied();
                let (from, to) = (over.low as u64, over.high as u64);
                let before = from.checked_sub(1).and_then(upto).unwrap_or(Interval::exactly(0.0));
                let chance = upto(to).unwrap_or(Interval::between(0.0, 1.0)).minus(before);
                weight.times(Interval::between(chance.low.max(0.0), chance.high.clamp(0.0, 1.0)))
            }
        }
    }
}

impl Range {
    /// How wide it is, in standard deviations of all; 0 where it has no parts.
    pub(super) fn width(&self) -> f64 {
        match self.halves() {
            true => (self.over.high - self.over.low) / self.scale,
            false => 0.0,
        }
    }

    fn halves(&self) -> bool {
        let Interval { low, high } = self.over;
        match self.kind {
            Kind::Point => false,
            Kind::Counts(..) => low < high,
            _ => {
                let middle = f64::midpoint(low, high);
                low < middle && middle < high
            }
        }
    }

    /// Its two halves.
    pub(super) fn split(&self) -> Option<[Range; 2]> {
        if !self.halves() {
            return None;
        }
        let Interval { low, high } = self.over;
        let middle = f64::midpoint(low, high);
        let (end, start) = match self.kind {
            Kind::Counts(..) => (middle.floor(), middle.floor() + 1.0),
            _ => (middle, middle),
        };
        let part = |over: Interval| {
            let chance = self.kind.chance(over).common(Interval::between(0.0, self.chance.high));
            let chance = chance.unwrap_or(Interval::between(0.0, self.chance.high));
            Range { over, chance, ..self.clone() }
        };
        Some([part(Interval::between(low, end)), part(Interval::between(start, high))])
    }
}

/// The chance that a number lies in none of its ranges, at most.
pub(super) fn beyond(ranges: &[Range]) -> f64 {
    let least: f64 = ranges.iter().map(|range| range.chance.low).sum();
    let ulp = f64::EPSILON * (ranges.len() as f64 + 2.0);
    (1.0 - least + ulp).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_the_chance_of_the_whole() {
        let number = |text: &str| text.parse::<BigRational>().expect("a rational");
        for distribution in [
            Distribution::Normal { mean: number("1"), variance: number("4") },
            Distribution::Uniform { low: number("-1/3"), high: number("5/7") },
            Distribution::Exponential { rate: number("3/2"), start: number("0"), rising: true },
            Distribution::Poisson { mean: number("37/10") },
        ] {
            let first = ranges(&distribution).expect("ranges");
            assert!(beyond(&first) < 1e-12, "{distribution:?}");
            let mut open: Vec<Range> = first;
            for _ in 0..6 {
                open =
                    open.iter().flat_map(|one| one.split().map_or(vec![one.clone()], |both| both.to_vec())).collect();
            }
            let low: f64 = open.iter().map(|one| one.chance.low).sum();
            let high: f64 = open.iter().map(|one| one.chance.high).sum();
            assert!(low <= 1.0 && high >= 1.0 - 1e-13 && high - low < 1e-11, "{distribution:?}: {low} to {high}");
        }
    }
}
