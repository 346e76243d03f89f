//! Both sides of a comparison of terms, as numbers that are easier to look at: the squares of distances, and the greatest
//! difference of two vectors.

use num_traits::Signed;

use crate::assumption::Assumptions;
use crate::closed_form::Comparison;
use crate::value::{Atom, Relation, Value, ValueError, View};

/// The squares of both sides, where one is a distance and both are not negative: they compare alike, and the square of a
/// distance is a polynomial.
pub(super) fn squared((left, right): (&Value, &Value), known: &Assumptions) -> Option<[Value; 2]> {
    let square = |side: &Value| match square_of_distance(side) {
        None if known.decide(Relation::Gte, side, &Value::zero()) == Some(true) => Some((side.mul(side).ok()?, false)),
        None => None,
        Some(square) => Some((square, true)),
    };
    let ((left, one), (right, other)) = (square(left)?, square(right)?);
    (one || other).then_some([left, right])
}

/// The square of the length of a vector, times a number that is not negative; none of another form. It has a meaning
/// wherever the vector has one.
fn square_of_distance(side: &Value) -> Option<Value> {
    let View::Real(terms, below) = side.view() else { return None };
    let ([(number, factors)], [(divisor, others)]) = (terms.as_slice(), below.as_slice()) else { return None };
    let [(Atom::Root(inner), 1)] = factors.as_slice() else { return None };
    let factor = number / divisor;
    if !others.is_empty() || factor.is_negative() || inner.variables().is_empty() || !inner.is_sum_of_squares() {
        return None;
    }
    inner.mul(&Value::rational(&factor * &factor)).ok()
}

/// That each component of vectors is equal to that of the other.
pub(super) fn each_part(left: &Value, right: &Value) -> Option<Vec<Comparison>> {
    let (left, right) = (left.components()?, right.components()?);
    Some(left.into_iter().zip(right).map(|(left, right)| (Relation::Eq, left, right)).collect())
}

/// The largest difference of two components of vectors: they are equal where it is 0.
pub(super) fn furthest(left: &Value, right: &Value) -> Result<Option<Value>, ValueError> {
    let (Some(left), Some(right)) = (left.components(), right.components()) else { return Ok(None) };
    let mut distance = Value::zero();
    for (one, other) in left.iter().zip(&right) {
        distance = Value::maximum(&[distance, one.sub(other)?.abs()?])?;
    }
    Ok(Some(distance))
}
