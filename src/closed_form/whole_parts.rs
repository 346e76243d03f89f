//! Equations between forms with integer parts of an index and of one further on: `floor((a*(n+1)+b)/m)` is what
//! `floor((a*n+b)/m)` is, or one more, where a/m lies between 0 and 1. Either is looked at.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::Unchecked;
use super::comparing::stands_to_zero;
use super::pieces::same_settled;
use crate::assumption::Assumptions;
use crate::name::Name;
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
    // What an integer part is between is known of a divisor of which it is said that it is above 0.
    let mut known = known.clone();
    for divisor in less.denominator().iter().chain([&below]) {
        if known.decide(Relation::Gtr, divisor, &Value::zero()) != Some(true) {
            return Ok(false);
        }
        known.assume(Relation::Gtr, divisor, &Value::zero());
    }
    scaled(left, less, &mut known)?;
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

/// What an integer part is between, as many times as it stands in a value: `(3+sqrt(2))*floor(x)`.
fn scaled(value: &Value, inner: &Value, known: &mut Assumptions) -> Result<(), Unchecked> {
    let (whole, mark) = (inner.floor()?, Name::new("[part]"));
    let atom = Atom::Floor(inner.clone());
    let times = value.with_atom(&atom, &Value::variable(&mark))?.linear_in(&mark).map(|(times, _)| times);
    let Some(times) = times.filter(|times| !times.mentions(&mark)) else { return Ok(()) };
    for times in [times.clone(), times.neg()?] {
        if known.decide(Relation::Gtr, &times, &Value::zero()) == Some(true) {
            let (inner, whole) = (inner.mul(&times)?, whole.mul(&times)?);
            known.assume(Relation::Gte, &inner, &whole);
            known.assume(Relation::Lss, &inner, &whole.add(&times)?);
        }
    }
    Ok(())
}

/// A value with each integer part that is known to be one of a few small numbers as that number, or as one of these more or
/// less than another integer part in it: of `floor((w-d-m*w)/v)` an m that is whole was taken out.
pub(crate) fn with_known_parts(value: &Value, known: &Assumptions) -> Option<Value> {
    let part = |inner: &Value| {
        let inside = inner.atoms().into_iter().filter(|atom| matches!(atom, Atom::Floor(_)));
        let mut around = vec![Value::zero()];
        for atom in inside.take(MOST_INSIDE) {
            let whole = atom.value().ok()?;
            around.extend([whole.neg().ok()?, whole]);
        }
        around.iter().find_map(|whole| {
            let rest = known.simplify(&inner.sub(whole).ok()?);
            let more = Value::integer(seen(&rest, known)?);
            let rest = rest.sub(&more).ok()?;
            let within = known.decide(Relation::Gte, &rest, &Value::zero()) == Some(true)
                && known.decide(Relation::Lss, &rest, &Value::one()) == Some(true);
            within.then(|| whole.add(&more).ok())?
        })
    };
    let image = |atom: &Atom| if let Atom::Floor(inner) = atom { part(inner) } else { None };
    value
        .atoms()
        .iter()
        .any(|atom| matches!(atom, Atom::Floor(_)))
        .then(|| value.replace(&mut |atom| image(atom)).ok())?
}

/// The integer part of a value in all examples of what is assumed, where that is the same and small.
fn seen(value: &Value, known: &Assumptions) -> Option<i64> {
    let part = |example: Vec<(Name, BigRational)>| {
        let numbers =
            example.into_iter().map(|(name, number)| (name, Value::rational(number))).collect::<BTreeMap<_, _>>();
        let whole = value.substitute(&numbers).ok()?.floor().ok()?.as_rational()?;
        whole.to_integer().to_i64().filter(|whole| (-1..=1).contains(whole))
    };
    let mut parts = known.examples(value).into_iter().map(part);
    let first = parts.next()??;
    parts.all(|other| other == Some(first)).then_some(first)
}

/// The most integer parts inside one that are looked at.
const MOST_INSIDE: usize = 2;

/// An index `ceil(E) + k` or `floor(E)+1 + k`.
pub(super) struct Rounded {
    pub(super) up: bool,
    pub(super) exact: Value,
    pub(super) rest: Value,
}

pub(super) fn rounded(at: &Value) -> Option<Rounded> {
    let atom = at.atoms().into_iter().find(|atom| matches!(atom, Atom::Floor(_)))?;
    let Atom::Floor(inner) = &atom else { return None };
    let part = Name::new("[part]");
    let (factor, rest) = at.with_atom(&atom, &Value::variable(&part)).ok()?.linear_in(&part)?;
    if factor == Value::one() {
        return Some(Rounded { up: false, exact: inner.clone(), rest: rest.sub(&Value::one()).ok()? });
    }
    let up = factor == Value::integer(-1);
    up.then(|| Some(Rounded { up, exact: inner.neg().ok()?, rest })).flatten()
}

/// Whether an index is not before `ceil(E) + k`, or `floor(E)+1 + k`: where it is `ceil(X) + k` and X is not before E, or behind
/// it; or where the index without k is whole, and not before E, or behind it.
pub(super) fn is_not_before(index: &Value, other: &Value, known: &Assumptions) -> bool {
    let Some(behind) = rounded(other) else { return false };
    let relation = if behind.up { Relation::Gte } else { Relation::Gtr };
    let exactly = rounded(index).is_some_and(|one| {
        one.up && one.rest == behind.rest && known.decide(relation, &one.exact, &behind.exact) == Some(true)
    });
    let leaf = |value: &Value, relation: Relation| known.decide(relation, value, &Value::zero());
    let with_roots = || {
        let apart = index.sub(&behind.rest).and_then(|index| index.sub(&behind.exact)).ok()?;
        let whole = [index, other].into_iter().all(|index| known.is_natural(index) == Some(true));
        let meant = whole && known.gives_meaning(&behind.exact);
        Some(meant && stands_to_zero(&apart, relation, &leaf, MOST_ROOTS) == Some(true))
    };
    exactly || with_roots() == Some(true)
}

/// The most roots that one comparison is taken apart by.
const MOST_ROOTS: usize = 1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behind_a_way_that_is_cut_up() {
        let [c, d, p, q] = ["c", "d", "p", "q"].map(|name| Value::variable(&Name::new(name)));
        let mut known = Assumptions::default();
        [&p, &q].into_iter().for_each(|step| known.assume(Relation::Gtr, step, &Value::zero()));
        known.assume(Relation::Lss, &d, &c);
        let count = d.sub(&c).unwrap().div(&q).unwrap().floor().unwrap().neg().unwrap();
        let inside = d.sub(&c).unwrap().sub(&q).unwrap().add(&count.mul(&q).unwrap()).unwrap();
        let part = inside.div(&p.add(&q).unwrap()).unwrap().floor().unwrap();
        assert_eq!(with_known_parts(&part, &known), Some(Value::integer(-1)), "{part}");
    }
}
