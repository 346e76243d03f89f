//! What is a draw between two bounds whenever a phase begins: a disturbance that is kept, or by how much a look is off.

use num_traits::{Signed, Zero};

use super::candidates::entries;
use crate::invariant::support;
use crate::name::Name;
use crate::period::{Edge, Period, Test};
use crate::value::{Relation, Sort, Value};

/// The most variables of a phase of which two are compared.
const MOST_VARIABLES: usize = 12;

/// Bounds of variables, and of the difference of two, that hold on each way into a phase since they are drawn on it.
pub(super) fn noise(period: &Period, number: usize) -> Vec<Test> {
    let Some(phase) = period.phases.get(number) else { return Vec::new() };
    let drawn = entries(period, number).any(|edge| !edge.draws.is_empty());
    if !drawn || phase.variables.len() > MOST_VARIABLES {
        return Vec::new();
    }
    let all: Vec<Value> = phase.variables.iter().map(Value::variable).collect();
    let later = |place: usize| all.get(place + 1..).unwrap_or_default();
    let pairs = all.iter().enumerate().flat_map(|(place, one)| later(place).iter().map(move |other| one.sub(other)));
    let values = all.iter().cloned().chain(pairs.flatten());
    values.flat_map(|value| bounds(period, number, &value)).collect()
}

fn bounds(period: &Period, number: usize, value: &Value) -> Vec<Test> {
    let ends = |relation: Relation| {
        let mut outermost: Option<Value> = None;
        for edge in entries(period, number) {
            let end = end(edge, value.substitute(&edge.map).ok()?, relation)?;
            let inside = |other: &Value| {
                let (end, other) = (end.as_rational()?, other.as_rational()?);
                Some(if relation == Relation::Gte { other <= end } else { other >= end })
            };
            match &outermost {
                Some(other) if *other == end || inside(other)? => {}
                _ => outermost = Some(end),
            }
        }
        Some(Test { relation, left: value.clone(), right: outermost? })
    };
    [Relation::Gte, Relation::Lte].into_iter().filter_map(ends).collect()
}

/// What was asked on the ways into a phase of what a variable is behind it, but for a draw between bounds: of a look that
/// is off by at most so much.
pub(super) fn asked_roughly(period: &Period, number: usize) -> Vec<Test> {
    let drawing = entries(period, number).filter(|edge| !edge.draws.is_empty());
    let mut found = Vec::new();
    for edge in drawing {
        let asked = edge.tests.iter().filter(|test| test.left.sort() == Sort::Real);
        found.extend(
            asked.flat_map(|test| edge.map.iter().filter_map(|(name, image)| roughly(edge, test, name, image))),
        );
    }
    found
}

/// A test that is linear in what a variable becomes, said of that variable: the rest of it is as great as can be.
fn roughly(edge: &Edge, test: &Test, name: &Name, image: &Value) -> Option<Test> {
    let upper = match test.relation {
        Relation::Gtr | Relation::Gte => true,
        Relation::Lss | Relation::Lte => false,
        Relation::Eq | Relation::Neq => return None,
    };
    let difference = test.left.sub(&test.right).ok()?;
    let drawn = |name: &Name| edge.draws.iter().any(|(drawn, _)| drawn == name);
    let pivot = image.variables().into_iter().find(|name| edge.map.contains_key(name) && !drawn(name))?;
    let (factor, _) = difference.linear_in(&pivot)?;
    let (own, _) = image.linear_in(&pivot)?;
    let factor = factor.div(&own).ok().filter(|factor| factor.as_rational().is_some_and(|factor| !factor.is_zero()))?;
    let rest = difference.sub(&factor.mul(image).ok()?).ok()?;
    rest.variables().iter().find(|name| drawn(name))?;
    let end = end(edge, rest, if upper { Relation::Lte } else { Relation::Gte })?;
    let left = factor.mul(&Value::variable(name)).ok()?.add(&end).ok()?;
    Some(Test { relation: test.relation, left, right: Value::zero() })
}

/// The least or the greatest value on a way, where it depends on nothing but what is drawn on it, between bounds.
fn end(edge: &Edge, value: Value, relation: Relation) -> Option<Value> {
    let mut end = value;
    for (name, distribution) in &edge.draws {
        let (factor, rest) = end.linear_in(name)?;
        let factor = factor.as_rational()?;
        if factor.is_zero() {
            continue;
        }
        // Of a negative multiple the least is that of the greatest.
        let side = if factor.is_positive() { relation } else { relation.mirrored() };
        let bounds = support(name, distribution);
        let bound = bounds.iter().find(|bound| bound.relation == side || bound.relation == Relation::Eq)?;
        end = rest.add(&bound.right.mul(&Value::rational(factor)).ok()?).ok()?;
    }
    let own = |name: &Name| edge.map.contains_key(name) || edge.draws.iter().any(|(drawn, _)| drawn == name);
    (!end.variables().iter().any(own)).then_some(end)
}
