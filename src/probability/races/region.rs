//! The chance that independent numbers with densities meet linear inequalities: of one alone by its distribution
//! function, of two by an integral along one of them.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::pair::{Line, Pair};
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::name::Name;
use crate::value::{Atom, Value, ValueError};

/// A linear form of what is drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Form {
    factors: BTreeMap<Name, BigRational>,
    constant: BigRational,
}

impl Form {
    /// The form that a value is; none where it is not linear, or mentions what is not drawn.
    pub(super) fn of(value: &Value, region: &Region) -> Option<Form> {
        let (numerator, denominator) = value.polynomials()?;
        let below = denominator.as_constant()?;
        let mut form = Form { factors: BTreeMap::new(), constant: BigRational::zero() };
        for (monomial, number) in numerator.terms() {
            match monomial.factors() {
                [] => form.constant = number / &below,
                [(Atom::Variable(name), 1)] if region.drawn.contains_key(name) => {
                    form.factors.insert(name.clone(), number / &below);
                }
                _ => return None,
            }
        }
        Some(form)
    }

    /// Whether nothing drawn stands in it.
    pub(super) fn is_constant(&self) -> bool {
        self.factors.is_empty()
    }

    /// With the other sign.
    pub(super) fn opposite(&self) -> Form {
        let factors = self.factors.iter().map(|(name, factor)| (name.clone(), -factor)).collect();
        Form { factors, constant: -&self.constant }
    }

    fn value(&self) -> Result<Value, ValueError> {
        let constant = Value::rational(self.constant.clone());
        self.factors.iter().try_fold(constant, |sum, (name, factor)| sum.add(&Value::variable(name).scale(factor)?))
    }
}

/// Between what a number lies; no bound where there is none.
#[derive(Clone, Debug, Default)]
struct Bounds {
    low: Option<BigRational>,
    high: Option<BigRational>,
}

impl Bounds {
    fn chance(&self, distribution: &Distribution) -> Interval {
        match (&self.low, &self.high) {
            (None, None) => Interval::exactly(1.0),
            (Some(low), None) => distribution.more_than(low),
            (None, Some(high)) => distribution.at_most(high),
            (Some(low), Some(high)) => distribution.between(low, high),
        }
    }

    fn is_empty(&self) -> bool {
        matches!((&self.low, &self.high), (Some(low), Some(high)) if low >= high)
    }
}

/// What was drawn, and the inequalities that it meets; each is strict, as equality has no chance.
#[derive(Clone, Debug, Default)]
pub(super) struct Region {
    drawn: BTreeMap<Name, Distribution>,
    bounds: BTreeMap<Name, Bounds>,
    /// What is positive, of several numbers.
    mixed: Vec<Form>,
}

impl Region {
    /// With one more number, if it has a density that is known here.
    pub(super) fn with(&self, name: &Name, distribution: &Distribution) -> Option<Region> {
        let bounds = match distribution {
            Distribution::Normal { variance, .. } if variance.is_positive() => Bounds::default(),
            Distribution::Uniform { low, high } if low < high => {
                Bounds { low: Some(low.clone()), high: Some(high.clone()) }
            }
            Distribution::Exponential { start, rising: true, .. } => Bounds { low: Some(start.clone()), high: None },
            _ => return None,
        };
        let mut region = self.clone();
        region.bounds.insert(name.clone(), bounds);
        region.drawn.insert(name.clone(), distribution.clone());
        Some(region)
    }

    /// What of it has a form positive; none where hardly anything can have.
    pub(super) fn cut(&self, form: &Form) -> Option<Region> {
        let mut region = self.clone();
        let mut factors = form.factors.iter();
        match (factors.next(), factors.next()) {
            (None, _) => return form.constant.is_positive().then_some(region),
            (Some((name, factor)), None) => {
                let bounds = region.bounds.entry(name.clone()).or_default();
                let bound = -&form.constant / factor;
                if factor.is_positive() {
                    bounds.low = Some(bounds.low.take().map_or(bound.clone(), |low| low.max(bound)));
                } else {
                    bounds.high = Some(bounds.high.take().map_or(bound.clone(), |high| high.min(bound)));
                }
                if bounds.is_empty() {
                    return None;
                }
            }
            _ => region.mixed.push(form.clone()),
        }
        Some(region)
    }

    /// What was drawn.
    pub(super) fn names(&self) -> impl Iterator<Item = &Name> {
        self.drawn.keys()
    }

    /// The values that are positive in it.
    pub(super) fn positive(&self) -> Result<Vec<Value>, ValueError> {
        let mut found = Vec::new();
        for (name, bounds) in &self.bounds {
            let number = Value::variable(name);
            if let Some(low) = &bounds.low {
                found.push(number.sub(&Value::rational(low.clone()))?);
            }
            if let Some(high) = &bounds.high {
                found.push(Value::rational(high.clone()).sub(&number)?);
            }
        }
        for form in &self.mixed {
            found.push(form.value()?);
        }
        Ok(found)
    }

    /// Its chance, and whether that is wider than rounding makes it.
    pub(super) fn chance(&self) -> (Interval, bool) {
        let (mut chance, mut wide) = (Interval::exactly(1.0), false);
        let mut left: BTreeSet<&Name> = self.drawn.keys().collect();
        while let Some(first) = left.pop_first() {
            let (group, forms) = self.group(first);
            left.retain(|name| !group.contains(name));
            let group: Vec<&Name> = group.into_iter().collect();
            let alone: Vec<Interval> = group.iter().map(|name| self.bounds[*name].chance(&self.drawn[*name])).collect();
            let own = match group.as_slice() {
                [_] => alone[0],
                [one, other] => {
                    let (found, exact) = self.pair(one, other, &forms);
                    wide |= !exact;
                    found
                }
                // No more than if each had to keep to its bounds alone.
                _ => {
                    wide = true;
                    Interval::between(0.0, alone.iter().fold(1.0, |most, one| (most * one.high * 1.000_001).min(1.0)))
                }
            };
            chance = chance.times(own);
        }
        (chance.probability(), wide)
    }

    /// The numbers that this one is compared with, itself among them, and the comparisons.
    fn group<'a>(&'a self, first: &'a Name) -> (BTreeSet<&'a Name>, Vec<&'a Form>) {
        let mut group = BTreeSet::from([first]);
        loop {
            let forms: Vec<&Form> =
                self.mixed.iter().filter(|form| form.factors.keys().any(|name| group.contains(name))).collect();
            let before = group.len();
            group.extend(forms.iter().flat_map(|form| form.factors.keys()));
            if group.len() == before {
                return (group, forms);
            }
        }
    }

    /// The chance for two numbers.
    fn pair(&self, one: &Name, other: &Name, forms: &[&Form]) -> (Interval, bool) {
        // An exponential number is the one whose distribution function is put in.
        let exponential = matches!(self.drawn[one], Distribution::Exponential { .. });
        let (along, other) = if exponential { (other, one) } else { (one, other) };
        let (mut above, mut below) = (Vec::new(), Vec::new());
        for form in forms {
            let (slope, factor) = (&form.factors[along], &form.factors[other]);
            let line = Line { slope: -slope / factor, shift: -&form.constant / factor };
            if factor.is_positive() { above.push(line) } else { below.push(line) }
        }
        let level = |bound: &BigRational| Line { slope: BigRational::zero(), shift: bound.clone() };
        let own = &self.bounds[other];
        above.extend(own.low.iter().map(level));
        below.extend(own.high.iter().map(level));
        let bounds = &self.bounds[along];
        let pair = Pair { along: &self.drawn[along], other: &self.drawn[other], above, below };
        pair.chance(bounds.low.as_ref(), bounds.high.as_ref())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(top: i64, below: i64) -> BigRational {
        BigRational::new(top.into(), below.into())
    }

    fn exponential(top: i64, below: i64) -> Distribution {
        Distribution::Exponential { rate: ratio(top, below), start: ratio(0, 1), rising: true }
    }

    fn two(one: &Distribution, other: &Distribution) -> Region {
        Region::default().with(&Name::new("x"), one).unwrap().with(&Name::new("y"), other).unwrap()
    }

    fn cut(region: &Region, [x, y, constant]: [i64; 3]) -> Region {
        let factors = [("x", x), ("y", y)].into_iter().filter(|(_, factor)| *factor != 0);
        let factors = factors.map(|(name, factor)| (Name::new(name), ratio(factor, 1))).collect();
        region.cut(&Form { factors, constant: ratio(constant, 1) }).unwrap()
    }

    fn is(region: &Region, expected: f64, width: f64) {
        let (found, _) = region.chance();
        assert!(found.low <= expected + 1e-13 && expected - 1e-13 <= found.high, "{found:?} is not {expected}");
        assert!(found.width() <= width, "{found:?} is wide");
    }

    #[test]
    fn of_two_exponential_numbers() {
        // By hand: the first of rate 1/3 before the second of rate 1/5.
        let both = two(&exponential(1, 3), &exponential(1, 5));
        is(&cut(&both, [-1, 1, 0]), 5.0 / 8.0, 1e-12);
        // Both within 4, the first before the second: integral of e^(-x/3)/3 (e^(-x/5)-e^(-4/5)) from 0 to 4.
        let within = cut(&cut(&cut(&both, [-1, 1, 0]), [0, -1, 4]), [-1, 0, 4]);
        let expected = 5.0 / 8.0 * (1.0 - (-32.0f64 / 15.0).exp()) - (-0.8f64).exp() * (1.0 - (-4.0f64 / 3.0).exp());
        is(&within, expected, 1e-12);
        // Their sum within 3.
        let (l, m): (f64, f64) = (1.0 / 3.0, 1.0 / 5.0);
        let sum = 1.0 - (l * (-3.0 * m).exp() - m * (-3.0 * l).exp()) / (l - m);
        is(&cut(&both, [-1, -1, 3]), sum, 1e-12);
        // The same rate: a sum of two is Erlang.
        let same = two(&exponential(1, 2), &exponential(1, 2));
        is(&cut(&same, [-1, -1, 3]), 1.0 - (-1.5f64).exp() * 2.5, 1e-12);
    }

    #[test]
    fn of_other_numbers() {
        let uniform = Distribution::Uniform { low: ratio(2, 1), high: ratio(6, 1) };
        // A time from 2 to 6 before a failure at rate 1/20.
        is(&cut(&two(&uniform, &exponential(1, 20)), [-1, 1, 0]), 5.0 * ((-0.1f64).exp() - (-0.3f64).exp()), 1e-12);
        let other = Distribution::Uniform { low: ratio(0, 1), high: ratio(4, 1) };
        is(&cut(&two(&uniform, &other), [-1, 1, 0]), 1.0 / 8.0, 1e-12);
        let normal =
            |mean: i64, variance: i64| Distribution::Normal { mean: ratio(mean, 1), variance: ratio(variance, 1) };
        // Their difference is normal with mean 2 and variance 5: by tables, 0.8144533.
        is(&cut(&two(&normal(10, 1), &normal(12, 4)), [-1, 1, 0]), 0.814_453_315_238_652, 1e-5);
        // By quadrature elsewhere.
        is(&cut(&two(&normal(10, 1), &exponential(1, 20)), [-1, 1, 0]), (-0.5f64 + 1.0 / 800.0).exp(), 1e-12);
    }

    #[test]
    fn of_many_numbers() {
        let both = two(&exponential(1, 1), &exponential(1, 1));
        let three = both.with(&Name::new("z"), &exponential(1, 1)).unwrap();
        let order = |first: &str, second: &str, region: &Region| {
            let factors = BTreeMap::from([(Name::new(first), ratio(-1, 1)), (Name::new(second), ratio(1, 1))]);
            region.cut(&Form { factors, constant: ratio(0, 1) }).unwrap()
        };
        let (found, wide) = order("y", "z", &order("x", "y", &three)).chance();
        assert!(wide && found.low <= 1.0 / 6.0 && 1.0 / 6.0 <= found.high);
        // What is not compared with each other is multiplied.
        let apart = cut(&cut(&three, [-1, 0, 1]), [0, -1, 1]);
        is(&apart, (1.0 - (-1.0f64).exp()).powi(2), 1e-12);
    }
}
