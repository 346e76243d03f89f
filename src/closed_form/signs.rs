//! What maxima and conditions are at all indices of a range: the signs of exponential polynomials there.

use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::throughout;
use crate::value::{Atom, Relation, Value, ValueError};

/// The indices at which signs are asked for, and how a value in the terms becomes a sum in the index.
pub(super) struct Signs<'a> {
    pub(super) sum: &'a dyn Fn(&Value) -> Option<ExponentialPolynomial>,
    pub(super) from: u64,
    pub(super) until: Option<u64>,
}

impl Signs<'_> {
    /// Whether a value stands in a relation to 0 at all indices.
    fn hold(&self, value: &Value, relation: Relation) -> bool {
        (self.sum)(value).is_some_and(|sum| throughout(&sum, relation, self.from, self.until))
    }

    /// A value in the terms and the index with what its maxima and conditions are at all indices, where that is known.
    pub(super) fn settled(&self, value: &Value) -> Result<Value, ValueError> {
        let at_least = |one: &Value, other: &Value| one.sub(other).is_ok_and(|rest| self.hold(&rest, Relation::Gte));
        settled_by(value, &at_least, &|inner| self.positive(inner))
    }

    /// The same with its conditions alone: its maxima stay.
    pub(super) fn chosen(&self, value: &Value) -> Result<Value, ValueError> {
        settled_by(value, &|_, _| false, &|inner| self.positive(inner))
    }

    fn positive(&self, inner: &Value) -> Option<bool> {
        let never = || self.hold(inner, Relation::Lte).then_some(false);
        if self.hold(inner, Relation::Gtr) { Some(true) } else { never() }
    }
}

/// A value with what its maxima and conditions are, given whether one value is known to be at least another, and whether
/// one is known to be positive or not to be.
pub(crate) fn settled_by(
    value: &Value,
    at_least: &dyn Fn(&Value, &Value) -> bool,
    positive: &dyn Fn(&Value) -> Option<bool>,
) -> Result<Value, ValueError> {
    let mut result = value.clone();
    for atom in value.atoms() {
        let image = match &atom {
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(settled_by(element, at_least, positive)?);
                }
                let most = |one: &&Value| all.iter().all(|other| *one == other || at_least(one, other));
                all.iter().find(most).cloned()
            }
            Atom::Positive(inner) => {
                positive(&settled_by(inner, at_least, positive)?).map(|holds| Value::integer(i64::from(holds)))
            }
            _ => None,
        };
        if let Some(image) = image {
            result = result.with_atom(&atom, &image)?;
        }
    }
    Ok(result)
}
