//! Both sides of a comparison of terms, as numbers that are easier to look at: the squares of distances, and the greatest
//! difference of two vectors.

use crate::assumption::Assumptions;
use crate::value::{Atom, Relation, Value, ValueError};

/// The squares of both sides, where one is or has a root and both are not negative: they compare alike, and a distance is a
/// polynomial then.
pub(super) fn squared((left, right): (&Value, &Value), known: &Assumptions) -> Option<[Value; 2]> {
    let has_root = |side: &Value| side.atoms().into_iter().any(|atom| matches!(atom, Atom::Root(_)));
    let moves = |side: &Value| {
        side.atoms().into_iter().any(|atom| matches!(atom, Atom::Root(inner) if !inner.variables().is_empty()))
    };
    let positive = |side: &Value| known.decide(Relation::Gte, side, &Value::zero()) == Some(true);
    if !(moves(left) || moves(right)) || !positive(left) || !positive(right) {
        return None;
    }
    let squares = [left.mul(left).ok()?, right.mul(right).ok()?];
    squares.iter().any(|side| !has_root(side)).then_some(squares)
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
