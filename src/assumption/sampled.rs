//! Questions that the assumptions leave open, seen from examples: numbers for the variables at which all that is assumed
//! holds, and at which a value has a sign, show that it may have this sign. What may be so and may not be so need not be
//! looked for any further.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::Assumptions;
use super::enclosed::{Ranges, signs_at};
use super::sign::Signs;
use crate::name::Name;
use crate::value::Value;

/// The most variables that numbers are put in for.
const MOST_NAMES: usize = 4;
/// The most facts that are looked at.
const MOST_FACTS: usize = 24;
/// How many examples are tried.
const EXAMPLES: usize = 12;

/// Variables, and the facts that bear on them, with the signs that they allow.
type About = (BTreeSet<Name>, Vec<(Signs, Value)>);

impl Assumptions {
    /// Whether a value is seen to have a sign that is wanted and one that is not.
    pub(super) fn seen_either_way(&self, value: &Value, wanted: Signs) -> bool {
        if self.solved.iter().any(|(name, _)| self.naturals.contains(name)) {
            return false;
        }
        let value = self.with_solved(value);
        let Some((names, facts)) = self.about(&value) else { return false };
        let points: Vec<(Name, Vec<BigRational>)> =
            names.into_iter().map(|name| (name.clone(), self.points(&name))).collect();
        let (mut inside, mut outside) = (false, false);
        for example in 0..EXAMPLES {
            let point = |(place, (name, points)): (usize, &(Name, Vec<BigRational>))| {
                let at = points.get((example * (2 * place + 1) + place) % points.len().max(1))?;
                Some((name.clone(), (Some(at.clone()), Some(at.clone()))))
            };
            let Some(at) = points.iter().enumerate().map(point).collect::<Option<Ranges>>() else { return false };
            let Some(sign) = signs_at(&value, &at) else { continue };
            let (within, without) = (sign.within(wanted), sign.and(wanted).is_empty());
            let news = (within && !inside) || (without && !outside);
            if news && facts.iter().all(|(allowed, fact)| signs_at(fact, &at).is_some_and(|own| own.within(*allowed))) {
                inside |= within;
                outside |= without;
            }
            if inside && outside {
                return true;
            }
        }
        false
    }

    /// Numbers for the variables of a value at which all holds that is assumed of them: as many different ones as are found
    /// soon, which may be none.
    pub(crate) fn examples(&self, value: &Value) -> Vec<Vec<(Name, BigRational)>> {
        if self.solved.iter().any(|(name, _)| self.naturals.contains(name)) {
            return Vec::new();
        }
        let value = self.with_solved(value);
        let Some((names, facts)) = self.about(&value) else { return Vec::new() };
        let points: Vec<(Name, Vec<BigRational>)> =
            names.into_iter().map(|name| (name.clone(), self.points(&name))).collect();
        let mut found = Vec::new();
        for example in 0..EXAMPLES {
            let point = |(place, (name, points)): (usize, &(Name, Vec<BigRational>))| {
                let at = points.get((example * (2 * place + 1) + place) % points.len().max(1))?;
                Some((name.clone(), at.clone()))
            };
            let Some(at) = points.iter().enumerate().map(point).collect::<Option<Vec<_>>>() else { break };
            let ranges: Ranges =
                at.iter().map(|(name, at)| (name.clone(), (Some(at.clone()), Some(at.clone())))).collect();
            if facts.iter().all(|(allowed, fact)| signs_at(fact, &ranges).is_some_and(|own| own.within(*allowed))) {
                found.push(at);
            }
        }
        found
    }

    /// The variables of a value and of all facts that bear on them, with these facts; none where they are too many.
    fn about(&self, value: &Value) -> Option<About> {
        let mut names = value.variables();
        if names.is_empty() {
            return None;
        }
        let mut open: Vec<(Signs, Value, BTreeSet<Name>)> = Vec::new();
        for (relation, fact) in &self.stated {
            let fact = self.with_solved(fact);
            let own = fact.variables();
            open.push((Signs::of(*relation), fact, own));
        }
        let mut facts = Vec::new();
        loop {
            if names.len() > MOST_NAMES || facts.len() > MOST_FACTS {
                return None;
            }
            let (near, far): (Vec<_>, Vec<_>) = open.into_iter().partition(|(.., own)| !own.is_disjoint(&names));
            if near.is_empty() {
                return Some((names, facts));
            }
            for (allowed, fact, own) in near {
                names.extend(own);
                facts.push((allowed, fact));
            }
            open = far;
        }
    }

    /// Numbers to try for a variable.
    fn points(&self, name: &Name) -> Vec<BigRational> {
        let whole = |number: i64| BigRational::from_integer(number.into());
        let away = [0, 1, 7, 100].map(whole);
        let natural = self.naturals.contains(name);
        let mut points: Vec<BigRational> = match self.range(name) {
            (Some(low), Some(high)) => {
                let middle = (&low + &high) / whole(2);
                vec![low, high, if natural { middle.floor() } else { middle }]
            }
            (Some(low), None) => away.iter().map(|step| &low + step).collect(),
            (None, Some(high)) => away.iter().map(|step| &high - step).collect(),
            (None, None) => [0, 1000, -1000, 1, -1, 9, -9].map(whole).into(),
        };
        if let (false, Some(second)) = (natural, points.get(1)) {
            points.push((&points[0] + second) / whole(2));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Relation;

    #[test]
    fn what_may_be_either_is_seen_and_what_is_known_is_not() {
        let variable = |name: &str| Value::variable(&Name::new(name));
        let (x, y, n) = (variable("x"), variable("y"), variable("n"));
        let root = Value::integer(10).sqrt().unwrap();
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &x, &Value::integer(2));
        known.assume(Relation::Gte, &y, &x);
        known.assume_natural(&Name::new("n"));
        let either = |value: &Value| known.seen_either_way(value, Signs::POSITIVE);
        assert!(either(&x.sub(&Value::integer(3)).unwrap()));
        assert!(either(&x.mul(&root).unwrap().sub(&Value::integer(9)).unwrap()));
        assert!(either(&n));
        // Of these one answer follows: no example may speak against it.
        let half = Value::fraction(1, 2).unwrap();
        for value in [
            x.sub(&Value::integer(1)).unwrap(),
            y.sub(&Value::integer(2)).unwrap(),
            y.mul(&y).unwrap().sub(&x.mul(&Value::integer(2)).unwrap()).unwrap(),
            n.add(&half).unwrap(),
            n.mul(&n).unwrap().sub(&n).unwrap().add(&half).unwrap(),
        ] {
            assert!(!either(&value), "{value}");
        }
    }
}
