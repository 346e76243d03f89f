//! Lengths in the plane, by half planes: `norm(x) > c` and `norm(x) <= c` without roots.
//!
//! For a direction n of length 1, n·x is at most the length of x; so `n·x > c` for one n gives `norm(x) > c`. Of twenty
//! directions one makes an angle of less than 9.5 degrees with x, so that n·x is at least 0.986 of its length; so
//! `n·x <= 0.986*c` for all n gives `norm(x) <= c`.

use std::collections::BTreeSet;

use crate::name::Name;
use crate::period::Test;
use crate::value::{Atom, Relation, Value};

/// Directions of a quarter turn, as quotients: a side and the other over the third.
const QUARTER: [(i64, i64, i64); 5] = [(1, 0, 1), (35, 12, 37), (4, 3, 5), (3, 4, 5), (12, 35, 37)];

/// What the cosine of half the angle between neighbours is at least: its square is at most (1 + n·m)/2 for each pair.
const COSINE: (i64, i64) = (986, 1_000);

/// Half planes in place of a circle.
#[derive(Clone, Debug)]
pub enum Planes {
    /// Any one of them is enough.
    Any(Vec<Test>),
    /// All of them are.
    All(Vec<Test>),
}

impl Planes {
    /// The half planes.
    pub fn tests(&self) -> &[Test] {
        match self {
            Planes::Any(tests) | Planes::All(tests) => tests,
        }
    }
}

/// Half planes from which a comparison of the length of a vector of two numbers with another value follows; none where it
/// is none.
pub fn planes(test: &Test) -> Option<Planes> {
    let difference = test.left.sub(&test.right).ok()?;
    let mut roots = BTreeSet::new();
    for atom in difference.atoms() {
        match atom {
            Atom::Root(inner) => {
                roots.insert(inner);
            }
            Atom::Variable(_) => {}
            _ => return None,
        }
    }
    let inner = roots.first().filter(|_| roots.len() == 1)?;
    let length = Name::new("length~");
    let (factor, rest) =
        difference.with_atom(&Atom::Root(inner.clone()), &Value::variable(&length)).ok()?.linear_in(&length)?;
    let number = factor.as_rational()?;
    let bound = rest.neg().ok()?.div(&factor).ok()?;
    let relation = if num_traits::Signed::is_negative(&number) { test.relation.mirrored() } else { test.relation };
    let (one, other) = squares(inner)?;
    let half = |side: Value, bound: &Value| Test { relation, left: side, right: bound.clone() };
    match relation {
        Relation::Gtr | Relation::Gte => {
            Some(Planes::Any(sides(&one, &other)?.into_iter().map(|side| half(side, &bound)).collect()))
        }
        Relation::Lss | Relation::Lte => {
            let nearer = bound.mul(&Value::fraction(COSINE.0, COSINE.1).ok()?).ok()?;
            Some(Planes::All(sides(&one, &other)?.into_iter().map(|side| half(side, &nearer)).collect()))
        }
        Relation::Eq | Relation::Neq => None,
    }
}

/// n·x for each direction n.
fn sides(one: &Value, other: &Value) -> Option<Vec<Value>> {
    let mut sides = Vec::new();
    for (first, second, third) in QUARTER {
        let (x, y) = (Value::fraction(first, third).ok()?, Value::fraction(second, third).ok()?);
        let (back, down) = (x.neg().ok()?, y.neg().ok()?);
        // A quarter turn takes (x, y) to (-y, x).
        for (x, y) in [(&x, &y), (&down, &x), (&back, &down), (&y, &back)] {
            sides.push(one.mul(x).ok()?.add(&other.mul(y).ok()?).ok()?);
        }
    }
    Some(sides)
}

/// Two values whose squares add up to this one.
fn squares(sum: &Value) -> Option<(Value, Value)> {
    let one = leading(sum)?;
    let rest = sum.sub(&one.mul(&one).ok()?).ok()?;
    let other = match rest.as_rational() {
        Some(number) if !num_traits::Signed::is_negative(&number) => {
            rest.sqrt().ok().filter(|root| root.as_rational().is_some())?
        }
        Some(_) => return None,
        None => leading(&rest)?,
    };
    (rest == other.mul(&other).ok()?).then_some((one, other))
}

/// A linear value whose square leaves nothing of some variable.
fn leading(sum: &Value) -> Option<Value> {
    sum.variables().into_iter().find_map(|name| {
        let at = |number: i64| sum.with(&name, &Value::integer(number)).ok();
        let (here, ahead, behind) = (at(0)?, at(1)?, at(-1)?);
        let half = Value::fraction(1, 2).ok()?;
        let square = ahead.add(&behind).ok()?.mul(&half).ok()?.sub(&here).ok()?;
        let linear = ahead.sub(&behind).ok()?.mul(&half).ok()?;
        if !square.as_rational().is_some_and(|number| num_traits::Signed::is_positive(&number)) {
            return None;
        }
        let root = square.sqrt().ok()?;
        root.as_rational()?;
        let twice = root.add(&root).ok()?;
        root.mul(&Value::variable(&name)).ok()?.add(&linear.div(&twice).ok()?).ok()
    })
}
