//! What was asked on the ways into a phase, as tests of its own variables: where a way moves each value that was asked
//! about by a step or a factor, the value is what it is now, moved back.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::invariant::support;
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::value::{Relation, Value};

/// The tests of each way into this phase over its variables, where they can be said so.
pub(super) fn carried(period: &Period, number: usize) -> Vec<Test> {
    let mut found = Vec::new();
    for phase in &period.phases {
        let own: BTreeSet<&Name> = phase.variables.iter().collect();
        for edge in phase.edges.iter().filter(|edge| edge.next == Next::Phase(number)) {
            let back = backward(edge, &|name| varies(name, &own, edge));
            let over = |test: &Test| {
                let test = &widened(test, edge)?;
                let read = test.left.variables().into_iter().chain(test.right.variables());
                let moved = |name: &Name| back.contains_key(name) || !varies(name, &own, edge);
                if read.into_iter().all(|name| moved(&name)) { test.substitute(&back).ok() } else { None }
            };
            found.extend(edge.tests.iter().filter_map(over));
            if !edge.draws.is_empty() {
                found.extend(edge.tests.iter().filter_map(|test| through_draws(test, edge, &own)));
            }
        }
    }
    found
}

/// A comparison that holds wherever this one does, whatever is drawn: what is drawn between two bounds as that of them
/// which lets it hold most easily.
fn widened(test: &Test, edge: &Edge) -> Option<Test> {
    let drawn: Vec<_> =
        edge.draws.iter().filter(|(name, _)| test.left.mentions(name) || test.right.mentions(name)).collect();
    let mut wide = test.clone();
    for (name, distribution) in drawn {
        let difference = wide.left.sub(&wide.right).ok()?;
        let Some((factor, _)) = difference.linear_in(name) else { continue };
        let rising = match wide.relation {
            Relation::Gtr | Relation::Gte => factor.as_rational()?.is_positive(),
            Relation::Lss | Relation::Lte => factor.as_rational()?.is_negative(),
            Relation::Eq | Relation::Neq => return Some(test.clone()),
        };
        let bounds = support(name, distribution);
        let bound = |relation: Relation| bounds.iter().find(|bound| bound.relation == relation);
        let end = bound(if rising { Relation::Lte } else { Relation::Gte }).or_else(|| bound(Relation::Eq));
        let Some(end) = end else { continue };
        wide = Test { left: difference.with(name, &end.right).ok()?, right: Value::zero(), ..wide };
    }
    Some(wide)
}

/// A test over the variables behind a way, where what is drawn on it is added to them: of `b+f-a > 3` with b+f for b it is
/// `b-a > 3`, whatever f is. What does not fall away is widened.
fn through_draws(test: &Test, edge: &Edge, own: &BTreeSet<&Name>) -> Option<Test> {
    let drawn = |name: &Name| edge.draws.iter().any(|(drawn, _)| drawn == name);
    let back = backward(edge, &|name| own.contains(name) && !drawn(name));
    let read: BTreeSet<Name> = test.left.variables().union(&test.right.variables()).cloned().collect();
    if !read.iter().any(drawn) || read.iter().any(|name| own.contains(name) && !back.contains_key(name)) {
        return None;
    }
    let there = test.left.sub(&test.right).ok()?.substitute(&back).ok()?;
    let wide = widened(&Test { relation: test.relation, left: there, right: Value::zero() }, edge)?;
    let left = [&wide.left, &wide.right].into_iter().flat_map(Value::variables).any(|name| drawn(&name));
    (!left).then_some(wide)
}

/// Whether a name has another value from visit to visit, or is drawn.
fn varies(name: &Name, own: &BTreeSet<&Name>, edge: &Edge) -> bool {
    own.contains(name) || edge.draws.iter().any(|(drawn, _)| drawn == name)
}

/// What the variables were before this way, in terms of what they are behind it, of those that are made of one name that
/// varies so.
fn backward(edge: &Edge, varies: &dyn Fn(&Name) -> bool) -> BTreeMap<Name, Value> {
    let mut back = BTreeMap::new();
    for (name, image) in &edge.map {
        let mut read = image.variables().into_iter().filter(|read| varies(read));
        let (Some(only), None) = (read.next(), read.next()) else { continue };
        let Some((factor, rest)) = image.linear_in(&only) else { continue };
        let plain = factor.as_rational().is_some_and(|factor: BigRational| !factor.is_zero());
        if let (true, Ok(before)) = (plain, Value::variable(name).sub(&rest).and_then(|moved| moved.div(&factor))) {
            back.entry(only).or_insert(before);
        }
    }
    back
}
