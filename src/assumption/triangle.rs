//! The triangle inequality: what is near to one place is not near to another that is far from it.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use super::Assumptions;
use super::atoms::root_between;
use super::linear::{Bound, Constraint};
use super::refute::Form;
use crate::polynomial::Polynomial;
use crate::value::{Atom, Value, ValueError};

/// The longest vectors.
const MOST_PARTS: usize = 4;

impl Assumptions {
    /// Of the length of a vector of variables, `norm(r-a)`, and each other length in these polynomials and in what is
    /// assumed, `norm(r-b)`, that differs by a vector of numbers: `norm(r-a) + norm(r-b) >= norm(a-b)`, and they differ by
    /// no more than that.
    pub(super) fn facts_of_lengths<'f>(&'f self, own: &Atom, forms: impl Iterator<Item = &'f Form>) -> Vec<Constraint> {
        let Atom::Root(inner) = own else { return Vec::new() };
        let others = forms.chain(self.constraints.iter().map(|one| &one.form));
        let others: BTreeSet<&Atom> = others.flat_map(Form::atoms).filter(|atom| *atom != own).collect();
        let others = others.into_iter().filter_map(|atom| match atom {
            Atom::Root(other) if near(inner, other) => Some((atom, other)),
            _ => None,
        });
        let mut vector = None;
        let mut found = Vec::new();
        for (atom, other) in others {
            let Some(parts) = vector.get_or_insert_with(|| components(inner)) else { break };
            let between =
                components(other).and_then(|other| apart(parts, &other)).and_then(|square| root_between(&square));
            let Some((low, high)) = between else { continue };
            let (one, other) = (Polynomial::atom(own.clone()), Polynomial::atom(atom.clone()));
            let (low, high) = (Polynomial::constant(low), Polynomial::constant(high));
            let least = |form: Form| Constraint { form, bound: Bound::Nonnegative };
            found.push(least(one.plus(&other).minus(&low)));
            found.push(least(high.plus(&one).minus(&other)));
            found.push(least(high.plus(&other).minus(&one)));
        }
        found
    }
}

/// Whether two squares differ by what is linear in variables, as those of distances from two fixed places do.
fn near(one: &Value, other: &Value) -> bool {
    let plain = |value: &Value| value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_)));
    let linear = |value: Value| value.polynomials().is_some_and(|(top, below)| below.is_one() && top.is_linear());
    plain(one) && plain(other) && one.sub(other).is_ok_and(linear)
}

/// The components of a vector of variables, of whose squares this is the sum.
fn components(square: &Value) -> Option<Vec<Value>> {
    let parts = square.squares().filter(|parts| parts.len() <= MOST_PARTS)?;
    let sum = parts.iter().try_fold(Value::zero(), |sum, part| sum.add(&part.mul(part).ok()?).ok())?;
    (sum == *square).then_some(parts)
}

/// The square of the distance of two vectors, where that is a number; the components of the other in any order, and with
/// either sign: that changes no length.
fn apart(one: &[Value], other: &[Value]) -> Option<BigRational> {
    let mut rest: Vec<&Value> = other.iter().collect();
    let mut sum = BigRational::zero();
    let number = |value: Result<Value, ValueError>| value.ok().and_then(|value| value.as_rational());
    for part in one {
        let near = |other: &Value| number(part.sub(other)).or_else(|| number(part.add(other)));
        let found = rest.iter().enumerate().find_map(|(place, other)| Some((place, near(other)?)));
        let distance = match found {
            Some((place, distance)) => {
                rest.swap_remove(place);
                distance
            }
            None => part.as_rational()?,
        };
        sum += &distance * &distance;
    }
    for part in rest {
        let number = part.as_rational()?;
        sum += &number * &number;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;
    use crate::value::Relation;

    fn length(x: i64, y: i64) -> Value {
        let part = |name: &str, at: i64| Value::variable(&Name::new(name)).sub(&Value::integer(at)).unwrap();
        Value::vector(vec![part("x", x), part("y", y)]).unwrap().norm().unwrap()
    }

    #[test]
    fn near_one_place_is_far_from_another() {
        let mut known = Assumptions::default();
        known.assume(Relation::Lte, &length(4, 0), &Value::one());
        let far = |at: i64| known.decide(Relation::Gte, &length(0, 3), &Value::integer(at));
        assert_eq!(far(4), Some(true), "5 apart, and 1 away from one");
        assert_eq!(far(5), None);
        assert_eq!(known.decide(Relation::Lte, &length(0, 3), &Value::integer(6)), Some(true));
        known.assume(Relation::Lss, &length(0, 3), &Value::integer(4));
        assert!(known.contradictory());
    }

    #[test]
    fn the_distance_of_lengths_is_that_of_some_order_of_their_components() {
        let x = Value::variable(&Name::new("x"));
        let (up, down) = (x.add(&Value::integer(3)).unwrap(), x.neg().unwrap());
        let square =
            |one: &[Value], other: &[Value]| apart(one, other).map(|number| Value::rational(number).to_string());
        assert_eq!(square(&[up.clone(), Value::integer(4)], std::slice::from_ref(&down)), Some("25".to_string()));
        assert_eq!(square(&[Value::integer(2)], &[up.clone(), Value::integer(1)]), None);
        assert_eq!(square(&[up, Value::one()], &[Value::one(), down]), Some("9".to_string()));
    }
}
