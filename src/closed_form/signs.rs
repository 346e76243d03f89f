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
}

/// A value in the terms and the index with what its maxima and conditions are at all indices, where that is known.
pub(super) fn settled_by_signs(value: &Value, signs: &Signs<'_>) -> Result<Value, ValueError> {
    let mut result = value.clone();
    for atom in value.atoms() {
        let image = match &atom {
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(settled_by_signs(element, signs)?);
                }
                let most = |one: &&Value| {
                    let least = |other: &Value| one.sub(other).is_ok_and(|rest| signs.hold(&rest, Relation::Gte));
                    all.iter().all(|other| *one == other || least(other))
                };
                all.iter().find(most).cloned()
            }
            Atom::Positive(inner) => {
                let inner = settled_by_signs(inner, signs)?;
                if signs.hold(&inner, Relation::Gtr) {
                    Some(Value::one())
                } else {
                    signs.hold(&inner, Relation::Lte).then(Value::zero)
                }
            }
            _ => None,
        };
        if let Some(image) = image {
            result = result.with_atom(&atom, &image)?;
        }
    }
    Ok(result)
}
