//! What follows from a bound of a sum of squares: strips that an ellipse lies in, and ellipses in one another.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::circle::{Bound, Round, Square, root, squares};
use crate::period::Test;
use crate::value::{Relation, Value};

/// Strips in which all lies that meets these, in the direction in which a test asks.
pub(super) fn strips(known: &[Round], test: &Test) -> Vec<Test> {
    let Ok(asked) = test.left.sub(&test.right) else { return Vec::new() };
    let strip = |round: &Round| round.strip(&round.direction(&asked)?.0);
    known.iter().filter_map(strip).flatten().collect()
}

/// Half planes beyond which a bound from below holds, in the directions in which others are known to lie.
pub(super) fn aside(claim: &Round, known: &[Test]) -> Vec<Test> {
    let mut found = Vec::new();
    for test in known {
        let Some((factors, _)) = test.left.sub(&test.right).ok().and_then(|value| claim.direction(&value)) else {
            continue;
        };
        let opposite: Vec<BigRational> = factors.iter().map(|factor| -factor).collect();
        found.extend([factors, opposite].iter().filter_map(|factors| claim.beyond(factors)));
    }
    found
}

/// Whether one bound follows from another; false also where that is not found out.
///
/// With the sums P of what is known and C of what is claimed: if `k*P - C` is a sum of squares, `P <= p` gives `C <= k*p`,
/// and if `C - k*P` is one, `P >= p` gives `C >= k*p`. And where both are circles, or ellipses of one shape, whose centres
/// are d apart, a length in one differs from that in the other by at most d.
pub(super) fn implied(known: &Round, claim: &Round) -> bool {
    let (Bound::Number(least), Bound::Number(asked)) = (&known.bound, &claim.bound) else { return false };
    if least.is_negative() || asked.is_negative() {
        return false;
    }
    let strict = matches!(known.relation, Relation::Gtr | Relation::Lss);
    let sharp = strict || matches!(claim.relation, Relation::Gte | Relation::Lte);
    let by_squares = || {
        if known.is_below() != claim.is_below() || !least.is_positive() || !(sharp && asked.is_positive()) {
            return None;
        }
        let factor = Value::rational(asked / least);
        let (known, claimed) = (sum(&known.squares)?.mul(&factor).ok()?, sum(&claim.squares)?);
        let rest = if claim.is_below() { claimed.sub(&known) } else { known.sub(&claimed) };
        squares(&rest.ok()?).map(|(_, number)| !number.is_negative())
    };
    by_squares() == Some(true) || by_distance(known, claim, least, asked, sharp) == Some(true)
}

/// The rule of the three sides, where both are ellipses of one shape.
fn by_distance(known: &Round, claim: &Round, least: &BigRational, asked: &BigRational, sharp: bool) -> Option<bool> {
    let [one, other] = [&known.squares.first()?.weight, &claim.squares.first()?.weight];
    let mut apart = BigRational::zero();
    if known.squares.len() != claim.squares.len() {
        return None;
    }
    for (first, second) in known.squares.iter().zip(&claim.squares) {
        let moved = second.form.sub(&first.form).ok()?.as_rational()?;
        let weight = &first.weight / one;
        if &second.weight / other != weight {
            return None;
        }
        apart += weight * &moved * &moved;
    }
    // All lengths in the measure in which the first weight is 1.
    let [(near, nearly), (short, shortly), (low, high)] =
        [apart, least / one, asked / other].map(|square| root(&square));
    let (surely, wanted) = match (known.is_below(), claim.is_below()) {
        (false, true) => (near - shortly, high),
        (true, true) => (short - nearly, high),
        (false, false) => (low, shortly + nearly),
        (true, false) => return None,
    };
    Some(surely > wanted || surely == wanted && sharp)
}

/// The sum of the squares.
fn sum(squares: &[Square]) -> Option<Value> {
    let mut sum = Value::zero();
    for Square { weight, form, .. } in squares {
        sum = sum.add(&Value::rational(weight.clone()).mul(form).ok()?.mul(form).ok()?).ok()?;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::assumption::Assumptions;
    use crate::invariant::{Planes, follows};
    use crate::name::Name;

    /// Numbers from -6 to 6 in steps of a half, by a linear congruence.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> BigRational {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            BigRational::new((i64::try_from((self.0 >> 33) % 25).unwrap_or(0) - 12).into(), 2.into())
        }

        fn value(&mut self) -> Value {
            Value::rational(self.next())
        }
    }

    fn number(test: &Test, point: &BTreeMap<Name, Value>) -> bool {
        test.substitute(point).unwrap().decide(&Assumptions::default()).unwrap()
    }

    /// An ellipse about some point, a circle where it is so asked.
    fn ellipse(numbers: &mut Numbers, relation: Relation, round: bool) -> Test {
        let [x, y] = ["x", "y"].map(|name| Value::variable(&Name::new(name)).sub(&numbers.value()).unwrap());
        let lean = if round { Value::zero() } else { numbers.value().div(&Value::integer(8)).unwrap() };
        let y = y.add(&x.mul(&lean).unwrap()).unwrap();
        let left = x.mul(&x).unwrap().add(&y.mul(&y).unwrap()).unwrap();
        let bound = numbers.next();
        Test { relation, left, right: Value::rational(&bound * &bound) }
    }

    #[test]
    fn what_follows_from_a_curve_holds_wherever_the_curve_does() {
        let mut numbers = Numbers(2012);
        let relations = [Relation::Lte, Relation::Lss, Relation::Gte, Relation::Gtr];
        let mut derived = 0;
        for round in 0..150 {
            let known = ellipse(&mut numbers, relations[round % 4], round % 3 > 0);
            let claim = match round % 5 {
                0 => {
                    let [x, y] =
                        ["x", "y"].map(|name| Value::variable(&Name::new(name)).mul(&numbers.value()).unwrap());
                    Test { relation: relations[round / 4 % 4], left: x.add(&y).unwrap(), right: numbers.value() }
                }
                _ => ellipse(&mut numbers, relations[round / 4 % 4], round % 3 > 0),
            };
            let claim = if round % 7 == 0 && round % 5 > 0 {
                Test { left: claim.left.sqrt().unwrap_or(claim.left.clone()), ..claim }
            } else {
                claim
            };
            if !follows(&Assumptions::default(), std::slice::from_ref(&known), &claim) {
                continue;
            }
            derived += 1;
            for _ in 0..60 {
                let point = ["x", "y"].map(|name| (Name::new(name), numbers.value())).into();
                assert!(!number(&known, &point) || number(&claim, &point), "{known} gives {claim}, not at {point:?}");
            }
        }
        assert!(derived > 5, "{derived}");
    }

    #[test]
    fn half_planes_give_what_they_stand_for() {
        let mut numbers = Numbers(7);
        for round in 0..200 {
            let relation = [Relation::Lte, Relation::Lss, Relation::Gte, Relation::Gtr][round % 4];
            let claim = ellipse(&mut numbers, relation, round % 3 > 0);
            let planes = Round::of(&claim).unwrap().planes();
            for _ in 0..60 {
                let point = ["x", "y"].map(|name| (Name::new(name), numbers.value())).into();
                let enough = match &planes {
                    Some(Planes::Any(tests)) => tests.iter().any(|test| number(test, &point)),
                    Some(Planes::All(tests)) => tests.iter().all(|test| number(test, &point)),
                    None => false,
                };
                assert!(!enough || number(&claim, &point), "{claim} at {point:?}");
            }
        }
    }
}
