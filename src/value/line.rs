//! Conditions on one line, `u > a` and `u < b` for numbers a and b: every product of them is a sum of single ones.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::Signed;

use super::arithmetic::product;
use super::{Atom, Real, Value, ValueError};
use crate::polynomial::{Monomial, Polynomial};

/// `u > at`, or `u < at`: where `along` is u, without a constant and primitive, its leading coefficient positive.
struct Bound {
    along: Real,
    above: bool,
    at: BigRational,
}

/// Where on its line a condition `u > a` is looked at.
#[derive(Clone, Copy)]
pub(super) enum Place {
    /// Where it holds.
    Holds,
    /// Where it does not.
    Fails,
    /// Where u is a.
    On,
}

/// The strongest conditions of a product along one line.
#[derive(Default)]
struct Stretch<'a> {
    above: Option<(BigRational, &'a Atom)>,
    below: Option<(BigRational, &'a Atom)>,
}

impl Atom {
    /// The condition as a bound of what stands before its constant.
    fn bound(&self) -> Option<Bound> {
        let Atom::Positive(inside) = self else { return None };
        let (numerator, denominator) = inside.parts()?;
        if !denominator.is_one() {
            return None;
        }
        let constant = numerator.constant_term();
        let rest = numerator.minus(&Polynomial::constant(constant.clone()));
        let above = rest.leading().is_positive();
        let factor = if above { rest.content() } else { -rest.content() };
        Some(Bound { along: rest.scale(&factor.recip()), above, at: -constant / factor })
    }

    /// How the number of this condition compares with that of another on the same line.
    pub(super) fn passes(&self, other: &Atom) -> Option<Ordering> {
        let (own, other) = (self.bound()?, other.bound()?);
        (own.along == other.along).then(|| own.at.cmp(&other.at))
    }

    /// Whether another condition on the line of this one holds in a place of that line, where that alone tells.
    pub(super) fn decides(&self, place: Place, other: &Atom) -> Option<bool> {
        let (mut own, mut asked) = (self.bound()?, other.bound()?);
        if own.along != asked.along {
            return None;
        }
        if !own.above {
            (own.at, asked.at, asked.above) = (-own.at, -asked.at, !asked.above);
        }
        let order = own.at.cmp(&asked.at);
        match (place, asked.above) {
            (Place::On, true) => Some(order.is_gt()),
            (Place::On, false) => Some(order.is_lt()),
            (Place::Holds, above) => order.is_ge().then_some(above),
            (Place::Fails, true) => order.is_le().then_some(false),
            (Place::Fails, false) => order.is_lt().then_some(true),
        }
    }
}

/// A polynomial in one place of the line of a condition.
pub(super) fn placed(polynomial: &Real, condition: &Atom, place: Place) -> Real {
    let opposite = |atom: &Atom| match (atom, condition) {
        (Atom::Positive(one), Atom::Positive(other)) => one.neg().is_ok_and(|one| one == *other),
        _ => false,
    };
    decided(polynomial, |atom| match place {
        Place::Holds | Place::On if opposite(atom) => Some(false),
        Place::Holds if atom == condition => Some(true),
        Place::Fails | Place::On if atom == condition => Some(false),
        _ => condition.decides(place, atom),
    })
}

/// A polynomial with 1 for the conditions that hold and 0 for those that do not.
pub(super) fn decided(polynomial: &Real, holds: impl Fn(&Atom) -> Option<bool>) -> Real {
    let terms = polynomial.terms().iter().filter_map(|(monomial, number)| {
        let zero = monomial.factors().iter().any(|(atom, _)| holds(atom) == Some(false));
        let rest = monomial.factors().iter().filter(|(atom, _)| holds(atom).is_none()).cloned();
        if zero { None } else { Some((Monomial::of(rest)?, number.clone())) }
    });
    Polynomial::of(terms)
}

impl Value {
    /// What is chosen by the conditions in a number, in each case of these; none where they are too many, or it has no value
    /// in a case.
    pub fn choices(&self) -> Option<Vec<Value>> {
        let (mut open, mut found) = (vec![self.clone()], Vec::new());
        while let Some(value) = open.pop() {
            let conditions = value.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_)));
            let Some(atom) = conditions.into_iter().next() else {
                found.push(value);
                continue;
            };
            if open.len() + found.len() > MOST_CHOICES {
                return None;
            }
            let (above, below) = value.parts()?;
            for place in [Place::Holds, Place::Fails] {
                open.push(Value::quotient(placed(above, &atom, place), placed(below, &atom, place)).ok()?);
            }
        }
        Some(found)
    }
}

/// The most cases of a choice that are told apart.
const MOST_CHOICES: usize = 32;

/// The product of the conditions in a monomial: of those along one line the strongest, and `u > a` beside `u < b` is 0, or
/// where a < b, when one of them holds always, the sum of both without 1.
pub(super) fn conditions(monomial: &Monomial<Atom>) -> Result<Real, ValueError> {
    let mut stretches: BTreeMap<Real, Stretch<'_>> = BTreeMap::new();
    let mut apart = Vec::new();
    for (atom, _) in monomial.factors().iter().filter(|(atom, _)| matches!(atom, Atom::Positive(_))) {
        let Some(bound) = atom.bound() else {
            // Of fractions no more is asked than whether one is the opposite of another.
            if let Atom::Positive(inside) = atom
                && apart.contains(&&Atom::Positive(inside.neg()?))
            {
                return Ok(Polynomial::zero());
            }
            apart.push(atom);
            continue;
        };
        let stretch = stretches.entry(bound.along).or_default();
        let held = if bound.above { &mut stretch.above } else { &mut stretch.below };
        let weaker = |at: &BigRational| if bound.above { *at >= bound.at } else { *at <= bound.at };
        if !held.as_ref().is_some_and(|(at, _)| weaker(at)) {
            *held = Some((bound.at, atom));
        }
    }
    let single = |atom: &Atom| Polynomial::atom(atom.clone());
    let mut whole = Polynomial::one();
    for atom in apart {
        whole = product(&whole, &single(atom))?;
    }
    for stretch in stretches.values() {
        let factor = match (&stretch.above, &stretch.below) {
            (Some((above, _)), Some((below, _))) if above >= below => return Ok(Polynomial::zero()),
            (Some((_, above)), Some((_, below))) => single(above).plus(&single(below)).minus(&Polynomial::one()),
            (Some((_, atom)), None) | (None, Some((_, atom))) => single(atom),
            (None, None) => continue,
        };
        whole = product(&whole, &factor)?;
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use crate::name::Name;
    use crate::value::{Relation, Value};

    fn condition(relation: Relation, value: &Value, at: i64) -> Value {
        Value::truth(relation, value, &Value::integer(at)).unwrap()
    }

    /// Products of conditions on a line are what they are in every place of it, and alike in all places means one normal form.
    #[test]
    fn alike_everywhere_is_one_form() {
        let (x, y) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("y")));
        let line = x.add(&x).unwrap().sub(&y).unwrap();
        let single: Vec<Value> = Relation::ALL
            .into_iter()
            .flat_map(|relation| (0..3).map(move |at| (relation, at)))
            .map(|(relation, at)| condition(relation, &line, at))
            .collect();
        let at = |value: &Value, place: i64| {
            value
                .with(&Name::new("x"), &Value::zero())
                .and_then(|value| value.with(&Name::new("y"), &Value::fraction(-place, 2).unwrap()))
                .unwrap()
        };
        let mut forms: Vec<(Vec<Value>, Value)> = Vec::new();
        for (first, second, third) in single
            .iter()
            .flat_map(|first| single.iter().map(move |second| (first, second)))
            .flat_map(|(first, second)| single.iter().step_by(4).map(move |third| (first, second, third)))
        {
            let whole = first.mul(second).unwrap().sub(third).unwrap().mul(second).unwrap();
            let places: Vec<Value> = (-2..7).map(|place| at(&whole, place)).collect();
            for (place, found) in (-2..7).zip(&places) {
                let [first, second, third] = [first, second, third].map(|value| at(value, place));
                assert_eq!(*found, first.mul(&second).unwrap().sub(&third).unwrap().mul(&second).unwrap());
            }
            forms.push((places, whole));
        }
        forms.sort_by_key(|(places, _)| format!("{places:?}"));
        assert!(forms.windows(2).all(|pair| (pair[0].0 == pair[1].0) == (pair[0].1 == pair[1].1)));
    }

    /// Chains of comparisons are read back as they are written.
    #[test]
    fn chains_are_read_in_order() {
        let x = Value::variable(&Name::new("x"));
        let chain = |relation: Relation| {
            (0..4).rev().fold(Value::integer(9), |rest, at| {
                let holds = condition(relation, &x, at);
                let fails = Value::one().sub(&holds).unwrap();
                holds.mul(&Value::integer(at + 5)).unwrap().add(&fails.mul(&rest).unwrap()).unwrap()
            })
        };
        assert_eq!(
            chain(Relation::Eq).to_string(),
            "if x = 0 then 5 else if x = 1 then 6 else if x = 2 then 7 else if x = 3 then 8 else 9"
        );
        assert_eq!(
            chain(Relation::Lss).to_string(),
            "if x < 0 then 5 else if x < 1 then 6 else if x < 2 then 7 else if x < 3 then 8 else 9"
        );
    }
}
