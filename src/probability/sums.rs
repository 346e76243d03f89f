//! Sums of independent numbers that are certain, uniform, exponential, normal, or mixtures of these.
//!
//! But for normal numbers the Laplace transform of the distribution function is a sum of terms
//! `c e^(-as) / (s^k (s+l)^m …)`, and by partial fractions the function itself one of terms `c (t-a)^j e^(-l(t-a))`, all of
//! whose numbers are rational: what is not is the exponentials, which are enclosed as closely as is needed. Under a normal
//! number each term is a moment of a normal density cut at 0, by a recurrence. Several normal numbers are one; where
//! each counts as 0 below 0, that errs by no more than the chance that one of them lies there.

use std::collections::BTreeMap;

use num_bigint::{BigInt, Sign};
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::Enclosed;
use crate::distribution::{Distribution, standard};
use crate::interval::{Interval, normal_between};

/// Terms that are added up.
const MOST_TERMS: usize = 4_000;
/// Poles of a term, counted as often as they are there.
const MOST_POLES: usize = 200;
/// Bits of the exponentials, as often as a closer value is needed.
const PRECISIONS: [u64; 4] = [128, 512, 2_048, 8_192];
/// How wide an answer may be.
const WIDEST: f64 = 1e-4;

/// What is common to terms: the poles of the transform with their orders, and the normal number.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    poles: BTreeMap<BigRational, usize>,
    mean: BigRational,
    variance: BigRational,
}

/// Factors of terms by where these set in.
type Shifts = BTreeMap<BigRational, BigRational>;

/// A factor of the transform: a number, where it sets in, and its pole.
type Factor = (BigRational, BigRational, Option<BigRational>);

/// A sum.
pub(super) struct Sum {
    terms: BTreeMap<Key, Shifts>,
    /// Whether each number counts as 0 below 0.
    from_nothing: bool,
    /// By how much the chance may be less, as several normal numbers count as one.
    slack: Interval,
    normals: usize,
}

impl Sum {
    /// Of nothing; `from_nothing` where each number that is added counts as 0 below 0.
    pub(super) fn new(from_nothing: bool) -> Sum {
        let poles = BTreeMap::from([(BigRational::zero(), 1)]);
        let key = Key { poles, mean: BigRational::zero(), variance: BigRational::zero() };
        let shifts = Shifts::from([(BigRational::zero(), BigRational::one())]);
        Sum { terms: BTreeMap::from([(key, shifts)]), from_nothing, slack: Interval::exactly(0.0), normals: 0 }
    }

    /// Whether what is found may be wider than rounding makes it.
    pub(super) fn is_wide(&self) -> bool {
        self.from_nothing && self.normals > 1
    }

    /// Adds an independent number.
    ///
    /// # Errors
    /// Where the sum is not known, or there are too many terms.
    pub(super) fn add(&mut self, distribution: &Distribution) -> Result<(), String> {
        let mut after: BTreeMap<Key, Shifts> = BTreeMap::new();
        let mut below = Interval::exactly(0.0);
        for (weight, part) in distribution.parts() {
            match &part {
                Distribution::Normal { mean, variance } if variance.is_positive() => {
                    let chance = standard(&BigRational::zero(), mean, variance).normal();
                    below = below.plus(chance.times(Interval::of(&weight)));
                    for (key, shifts) in &self.terms {
                        let (mean, variance) = (&key.mean + mean, &key.variance + variance);
                        let key = Key { mean, variance, ..key.clone() };
                        merge(&mut after, key, shifts, &(weight.clone(), BigRational::zero(), None));
                    }
                }
                _ => {
                    for (factor, shift, pole) in self.factors(&part)? {
                        let factor = (&weight * factor, shift, pole);
                        for (key, shifts) in &self.terms {
                            let mut key = key.clone();
                            if let Some(pole) = &factor.2 {
                                *key.poles.entry(pole.clone()).or_insert(0) += 1;
                            }
                            merge(&mut after, key, shifts, &factor);
                        }
                    }
                }
            }
        }
        let poles = after.keys().map(|key| key.poles.values().sum::<usize>()).max().unwrap_or(0);
        if after.values().map(Shifts::len).sum::<usize>() > MOST_TERMS || poles > MOST_POLES {
            return Err("the sum of what is drawn has too many terms".to_string());
        }
        if below != Interval::exactly(0.0) {
            self.normals += 1;
            self.slack = if self.normals == 1 { below } else { self.slack.plus(below) };
        }
        self.terms = after;
        Ok(())
    }

    /// The factors of the transform of a density.
    fn factors(&self, part: &Distribution) -> Result<Vec<Factor>, String> {
        let (zero, one) = (BigRational::zero(), BigRational::one());
        let cut = |number: &BigRational| if self.from_nothing { number.max(&zero).clone() } else { number.clone() };
        Ok(match part {
            Distribution::Point(at) | Distribution::Normal { mean: at, .. } => vec![(one, cut(at), None)],
            Distribution::Uniform { low, high } if low == high => vec![(one, cut(low), None)],
            Distribution::Uniform { high, .. } if self.from_nothing && !high.is_positive() => vec![(one, zero, None)],
            Distribution::Uniform { low, high } => {
                let (height, start) = ((high - low).recip(), cut(low));
                let pole = || Some(BigRational::zero());
                // Below 0 lies a chance that counts as 0.
                let nothing = (&height * (&start - low), zero.clone(), None);
                let both = [(height.clone(), start, pole()), (-height, high.clone(), pole())];
                std::iter::once(nothing).filter(|(factor, ..)| !factor.is_zero()).chain(both).collect()
            }
            Distribution::Exponential { rate, start, rising: true } if !self.from_nothing || !start.is_negative() => {
                vec![(rate.clone(), start.clone(), Some(rate.clone()))]
            }
            Distribution::Exponential { .. } => return Err("an exponential number may be below 0".to_string()),
            _ => return Err("what is drawn adds up to no distribution that is known here".to_string()),
        })
    }

    /// The chance that the sum is at most this.
    ///
    /// # Errors
    /// Where machine numbers do not tell it.
    pub(super) fn at_most(&self, bound: &BigRational) -> Result<Enclosed, String> {
        let (still, moved): (Vec<_>, Vec<_>) = self.terms.iter().partition(|(key, _)| key.variance.is_zero());
        let known: Vec<(Vec<Form>, &Shifts)> = still.iter().map(|(key, shifts)| (forms(&key.poles), *shifts)).collect();
        let found = closely(&known, bound);
        if moved.is_empty() {
            return Ok(Enclosed::from(found.0, found.1));
        }
        let mut total = round(&found.0, &found.1);
        for (key, shifts) in moved {
            let forms = forms(&key.poles);
            for (shift, factor) in shifts {
                let part = self.under_normal(key, &forms, &(bound - shift));
                total = total.plus(part.times(Interval::of(factor)));
            }
        }
        if self.is_wide() {
            total.low = total.minus(self.slack).low;
        }
        let total = total.probability();
        if total.width() > WIDEST {
            Err("the sum of what is drawn is not known closely enough".to_string())
        } else {
            Ok(Enclosed::within(total))
        }
    }

    /// The part of terms that set in at 0, over a normal number, up to a place.
    fn under_normal(&self, key: &Key, forms: &[Form], place: &BigRational) -> Interval {
        let Key { mean, variance, .. } = key;
        let mut total = Interval::exactly(0.0);
        let mut upper = None;
        if self.from_nothing {
            if place.is_negative() {
                return total;
            }
            let here = Shifts::from([(BigRational::zero(), BigRational::one())]);
            let (low, high) = closely(&[(forms.to_vec(), &here)], place);
            let nothing = standard(&BigRational::zero(), mean, variance).normal();
            total = nothing.times(round(&low, &high));
            upper = Some(place);
        }
        let two = BigRational::from_integer(2.into());
        for Form { rate, factors } in forms {
            let middle = place - mean;
            let power = rate * rate * variance / &two - rate * &middle;
            let moments = moments(&(middle - rate * variance), variance, upper, factors.len());
            let sum = moments.iter().zip(factors).map(|(moment, factor)| moment.times(Interval::of(factor)));
            let sum = sum.fold(Interval::exactly(0.0), Interval::plus);
            total = total.plus(sum.times(Interval::of(&power).exponential()));
        }
        total
    }
}

fn merge(all: &mut BTreeMap<Key, Shifts>, key: Key, shifts: &Shifts, (factor, shift, _): &Factor) {
    let entry = all.entry(key).or_default();
    for (old, number) in shifts {
        *entry.entry(old + shift).or_insert_with(BigRational::zero) += number * factor;
    }
}

/// `(c_0 + c_1 t + c_2 t² + …) e^(-rate t)`
#[derive(Clone)]
struct Form {
    rate: BigRational,
    factors: Vec<BigRational>,
}

/// The function with the transform `1/((s+l)^m …)`, by partial fractions: at each pole, the series of the others.
fn forms(poles: &BTreeMap<BigRational, usize>) -> Vec<Form> {
    let form = |(rate, order): (&BigRational, &usize)| {
        let mut series = vec![BigRational::zero(); *order];
        if let Some(first) = series.first_mut() {
            *first = BigRational::one();
        }
        for (other, times) in poles.iter().filter(|(other, _)| *other != rate) {
            let gap = other - rate;
            for _ in 0..*times {
                // Divided by (gap + x).
                let mut carried = BigRational::zero();
                for entry in &mut series {
                    *entry = (&*entry - carried) / &gap;
                    carried = entry.clone();
                }
            }
        }
        // The factor of 1/(s+rate)^(j+1) is that of x^(order-1-j), and its function is t^j/j! e^(-rate t).
        let mut factorial = BigRational::one();
        let mut factors = Vec::new();
        for (power, entry) in series.into_iter().rev().enumerate() {
            if power > 0 {
                factorial *= BigRational::from_integer(power.into());
            }
            factors.push(entry / &factorial);
        }
        Form { rate: rate.clone(), factors }
    };
    poles.iter().map(form).collect()
}

/// The sum of all terms at a place, between two rationals that are as near as machine numbers need; equal where no
/// exponentials are in it.
fn closely(all: &[(Vec<Form>, &Shifts)], bound: &BigRational) -> (BigRational, BigRational) {
    let (mut sum, mut powers) = (BigRational::zero(), BTreeMap::<BigRational, BigRational>::new());
    for (forms, shifts) in all {
        for (shift, factor) in *shifts {
            let place = bound - shift;
            if place.is_negative() {
                continue;
            }
            for Form { rate, factors } in forms {
                let value = factors.iter().rev().fold(BigRational::zero(), |value, factor| value * &place + factor);
                *powers.entry(rate * &place).or_insert_with(BigRational::zero) += value * factor;
            }
        }
    }
    sum += powers.remove(&BigRational::zero()).unwrap_or_default();
    powers.retain(|_, factor| !factor.is_zero());
    let (mut low, mut high) = (sum.clone(), sum.clone());
    for bits in PRECISIONS {
        if powers.is_empty() {
            break;
        }
        (low, high) = (sum.clone(), sum.clone());
        for (power, factor) in &powers {
            let (least, most) = exponential(power, bits);
            let (first, second) = if factor.is_negative() { (most, least) } else { (least, most) };
            low += factor * first;
            high += factor * second;
        }
        let near = low.clone().min(BigRational::one() - &high);
        if near.is_positive() && &high - &low <= near / BigRational::from_integer(BigInt::one() << 60u32) {
            break;
        }
    }
    (low, high)
}

/// `e^-power` for a power from 0 on, to so many bits behind the point: fixed-point numbers, by the series of the power
/// over 2^k, squared k times.
fn exponential(power: &BigRational, bits: u64) -> (BigRational, BigRational) {
    let unit = |places: u64| BigInt::one() << places;
    if *power > BigRational::from_integer(unit(14)) {
        // e^-16384 < 2^-23000
        return (BigRational::zero(), BigRational::new(BigInt::one(), unit(bits.clamp(1, 20_000))));
    }
    let places = bits + 64;
    let halvings = power.ceil().to_integer().bits() + 1;
    let small = (power * BigRational::from_integer(unit(places))).floor().to_integer() >> halvings;
    // Each term errs by less than 4 in the last place, what is left out by less than 5, the power by less than 2.
    let (mut term, mut sum, mut count) = (unit(places), unit(places), 0u32);
    while term.sign() != Sign::NoSign {
        count += 1;
        term = ((term * &small) >> places) / count;
        if count % 2 == 1 { sum -= &term } else { sum += &term }
    }
    let error = BigInt::from(4 * count + 16);
    let (mut low, mut high) = ((&sum - &error).max(BigInt::zero()), sum + error);
    for _ in 0..halvings {
        low = (&low * &low) >> places;
        high = ((&high * &high) >> places) + 1;
    }
    (BigRational::new(low, unit(places)), BigRational::new(high, unit(places)))
}

fn round(low: &BigRational, high: &BigRational) -> Interval {
    Interval::between(Interval::of(low).low, Interval::of(high).high)
}

/// `∫ z^j` times a normal density, from 0 to an upper end, for each j below a count.
fn moments(mean: &BigRational, variance: &BigRational, upper: Option<&BigRational>, count: usize) -> Vec<Interval> {
    let spread = Interval::of(variance).root();
    let (first, last) = (
        standard(&BigRational::zero(), mean, variance),
        upper.map_or(Interval::exactly(f64::INFINITY), |upper| standard(upper, mean, variance)),
    );
    // The variance times the density at an end.
    let height = |place: Interval| place.normal_density().times(spread);
    let (low, high) = (height(first), upper.map_or(Interval::exactly(0.0), |_| height(last)));
    let (middle, variance) = (Interval::of(mean), Interval::of(variance));
    let end = upper.map_or(Interval::exactly(0.0), Interval::of);
    let mut all = vec![normal_between(first, last)];
    let mut power = Interval::exactly(1.0);
    for order in 1..count {
        let mut next = middle.times(all[order - 1]).minus(power.times(high));
        if order == 1 {
            next = next.plus(low);
        } else {
            let before = variance.times(all[order - 2]);
            next = next.plus(before.times(Interval::exactly((order - 1).to_f64().unwrap_or(f64::INFINITY))));
        }
        // What is integrated is not negative.
        next.low = next.low.max(0.0);
        all.push(next);
        power = power.times(end);
    }
    all
}
