//! Vectors, which are equal or not: that they are not is known of the square of their distance.

use super::{Assumptions, Relation};
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Sort, Value};

impl Assumptions {
    /// Assumes that a vector is 0, or that it is not.
    pub(super) fn assume_of_vector(&mut self, relation: Relation, vector: &Value) {
        let parts = vector.components().unwrap_or_default();
        match relation {
            Relation::Eq => parts.iter().for_each(|part| self.assume(Relation::Eq, part, &Value::zero())),
            Relation::Neq => {
                if let [part] = parts.iter().filter(|part| !part.is_zero()).collect::<Vec<_>>().as_slice() {
                    self.assume(Relation::Neq, part, &Value::zero());
                } else if let Some(square) = square_of_length(&parts) {
                    self.assume(Relation::Gtr, &square, &Value::zero());
                }
            }
            _ => {}
        }
    }

    /// Vectors and distributions are only equal or not.
    pub(super) fn decide_wholes(&self, relation: Relation, left: &Value, right: &Value) -> Option<bool> {
        if !matches!(relation, Relation::Eq | Relation::Neq) {
            return None;
        }
        let equal = match (left.sort(), right.sort()) {
            _ if left == right => Some(true),
            (Sort::Vector(length), Sort::Vector(other)) if length == other => {
                if self.are_stated_apart(left, right) {
                    return Some(relation == Relation::Neq);
                }
                let mut all = Some(true);
                for place in 0..length {
                    match self.decide(Relation::Eq, &left.component(place)?, &right.component(place)?) {
                        Some(true) => {}
                        Some(false) => return Some(relation == Relation::Neq),
                        None => all = None,
                    }
                }
                // Not equal in all places: then the distance is not 0.
                let apart = || {
                    let length = left.sub(right).ok()?.norm().ok()?;
                    self.decide(Relation::Gtr, &length.mul(&length).ok()?, &Value::zero())
                };
                if all.is_none() && apart() == Some(true) { Some(false) } else { all }
            }
            _ => None,
        };
        equal.map(|equal| equal == (relation == Relation::Eq))
    }

    /// Whether it is assumed, just so, that two vectors are not equal.
    fn are_stated_apart(&self, left: &Value, right: &Value) -> bool {
        let square = || square_of_length(&left.sub(right).ok()?.components()?);
        let stated = |value: &Value| self.as_stated(Relation::Gtr, value) == Some(true);
        square().is_some_and(|square| match of_condition(&square) {
            Some((condition, rest)) => stated(&condition) && stated(&rest),
            None => stated(&square),
        })
    }
}

/// The sum of the squares of components.
fn square_of_length(parts: &[Value]) -> Option<Value> {
    parts.iter().try_fold(Value::zero(), |sum, part| sum.add(&part.mul(part).ok()?).ok())
}

/// Of `if p > 0 then x else 0` the values p and x: where it is not 0, p is more than 0, and x is not 0.
pub(super) fn of_condition(value: &Value) -> Option<(Value, Value)> {
    let (numerator, denominator) = value.polynomials()?;
    let shared = numerator.monomial_content();
    let (condition, atom) = shared.factors().iter().find_map(|(atom, _)| match atom {
        Atom::Positive(condition) => Some((condition.clone(), atom)),
        _ => None,
    })?;
    let rest =
        Value::from_polynomials(numerator.without(&Monomial::of([(atom.clone(), 1)])?), Polynomial::one()).ok()?;
    let below = Value::from_polynomials(denominator.clone(), Polynomial::one()).ok()?;
    Some((condition, rest.div(&below).ok()?)).filter(|_| !denominator.atoms().contains(atom))
}
