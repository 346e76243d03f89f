//! Equations between forms with integer parts of an index and of one further on: `floor((a*(n+1)+b)/m)` is what
//! `floor((a*n+b)/m)` is, or one more, where a/m lies between 0 and 1. Either is looked at.

use super::Unchecked;
use super::pieces::same_settled;
use crate::assumption::Assumptions;
use crate::value::{Atom, Relation, Value};

/// Whether two values are equal, whichever of its two possible values the greater of two integer parts has.
pub(super) fn same_by_whole_parts(left: &Value, right: &Value, known: &Assumptions) -> Result<bool, Unchecked> {
    let mut parts: Vec<Value> = Vec::new();
    for atom in left.atoms().into_iter().chain(right.atoms()) {
        if let Atom::Floor(inner) = atom
            && !parts.contains(&inner)
        {
            parts.push(inner.clone());
        }
    }
    let [one, other] = parts.as_slice() else { return Ok(false) };
    // A whole number that is taken out of one of them is apart from it.
    let apart = known.simplify(&other.sub(one)?);
    for whole in -MOST..=MOST {
        let rest = apart.sub(&Value::integer(whole))?;
        let within = known.decide(Relation::Gte, &rest, &Value::zero()) == Some(true)
            && known.decide(Relation::Lss, &rest, &Value::one()) == Some(true);
        if within {
            return of_each(left, right, (one, other, whole), known);
        }
    }
    Ok(false)
}

/// The most whole steps between two such parts.
const MOST: i64 = 2;

fn of_each(
    left: &Value,
    right: &Value,
    (less, more, whole): (&Value, &Value, i64),
    known: &Assumptions,
) -> Result<bool, Unchecked> {
    let (Some(top), Some(below)) = (more.numerator(), more.denominator()) else { return Ok(false) };
    if known.decide(Relation::Gtr, &below, &Value::zero()) != Some(true) {
        return Ok(false);
    }
    let atom = Atom::Floor(more.clone());
    for step in [0, 1] {
        let whole = less.floor()?.add(&Value::integer(whole + step))?;
        let put = |value: &Value| value.replace(&mut |other| (*other == atom).then(|| whole.clone()));
        let mut known = known.clone();
        let multiple = below.mul(&whole)?;
        known.assume(Relation::Gte, &top, &multiple);
        known.assume(Relation::Lss, &top, &multiple.add(&below)?);
        if !same_settled(&put(left)?, &put(right)?, &known)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// A value with each integer part that is known to be one of a few small numbers as that number.
pub(super) fn with_known_parts(value: &Value, known: &Assumptions) -> Option<Value> {
    let part = |inner: &Value| {
        (-1..=1).find(|whole| {
            let [least, most] = [*whole, whole + 1].map(Value::integer);
            known.decide(Relation::Gte, inner, &least) == Some(true)
                && known.decide(Relation::Lss, inner, &most) == Some(true)
        })
    };
    let image = |atom: &Atom| if let Atom::Floor(inner) = atom { part(inner).map(Value::integer) } else { None };
    value.atoms().iter().any(|atom| matches!(atom, Atom::Floor(_))).then(|| value.replace(&mut |atom| image(atom)).ok())?
}
