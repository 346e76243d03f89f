//! The first index at which a sequence that is quadratic in it, symbols included, gets past a bound.

use crate::assumption::Assumptions;
use crate::closed_form::Piece;
use crate::name::Name;
use crate::value::{Relation, Value, ValueError};

use super::Reach;

/// The first index at which a value compares with 0, where it is one quadratic form from index 0 on, begins on the other
/// side, and in the end lies on this one for ever: behind the greater of its roots. Below 0 for ever where nothing of it rises.
pub(super) fn past(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let [piece] = pieces else { return None };
    if !piece.from.is_zero() || piece.until.is_some() {
        return None;
    }
    let (form, relation) = match relation {
        Relation::Gtr | Relation::Gte => (piece.form.clone(), relation),
        Relation::Lss | Relation::Lte => (piece.form.neg().ok()?, relation.mirrored()),
        Relation::Eq | Relation::Neq => return None,
    };
    let [constant, linear, square] = coefficients(&form, index).ok().flatten()?;
    let zero = Value::zero();
    let is = |relation, value: &Value| known.decide(relation, value, &zero) == Some(true);
    let before = if relation == Relation::Gte { Relation::Lss } else { Relation::Lte };
    if !is(before, &constant) {
        return None;
    }
    // No step is greater than the first one.
    if is(Relation::Lte, &square) && is(Relation::Lte, &square.add(&linear).ok()?) {
        return Some(Reach::Never("it does not rise from where it begins".to_string()));
    }
    if !is(Relation::Gtr, &square) {
        return None;
    }
    let root = greater(&constant, &linear, &square).ok()?;
    let first = match relation {
        Relation::Gte => root.ceiling(),
        _ => root.floor().and_then(|floor| floor.add(&Value::one())),
    };
    Some(Reach::At(known.simplify(&first.ok()?), Vec::new()))
}

/// The coefficients of `c + b*n + a*n^2`; none of another form, or where a is 0.
fn coefficients(form: &Value, index: &Name) -> Result<Option<[Value; 3]>, ValueError> {
    let at = |number: i64| form.with(index, &Value::integer(number));
    let (zeroth, first, second) = (at(0)?, at(1)?, at(2)?);
    let square = second.sub(&first)?.sub(&first)?.add(&zeroth)?.div(&Value::integer(2))?;
    let linear = first.sub(&zeroth)?.sub(&square)?;
    let n = Value::variable(index);
    let whole = square.mul(&n)?.add(&linear)?.mul(&n)?.add(&zeroth)?;
    Ok((whole == *form && !square.is_zero()).then_some([zeroth, linear, square]))
}

/// `(-b + sqrt(b^2 - 4*a*c)) / (2*a)`
fn greater(constant: &Value, linear: &Value, square: &Value) -> Result<Value, ValueError> {
    let under = linear.mul(linear)?.sub(&square.mul(constant)?.mul(&Value::integer(4))?)?;
    under.sqrt()?.sub(linear)?.div(&square.mul(&Value::integer(2))?)
}
