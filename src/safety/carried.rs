//! What was asked on the ways into a phase, as tests of its own variables: where a way moves each value that was asked
//! about by a step or a factor, the value is what it is now, moved back.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::Zero;

use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::value::Value;

/// The tests of each way into this phase over its variables, where they can be said so.
pub(super) fn carried(period: &Period, number: usize) -> Vec<Test> {
    let mut found = Vec::new();
    for phase in &period.phases {
        let own: BTreeSet<&Name> = phase.variables.iter().collect();
        for edge in phase.edges.iter().filter(|edge| edge.next == Next::Phase(number)) {
            let back = backward(edge, &own);
            let over = |test: &Test| {
                let read = test.left.variables().into_iter().chain(test.right.variables());
                let moved = |name: &Name| back.contains_key(name) || !varies(name, &own, edge);
                if read.into_iter().all(|name| moved(&name)) { test.substitute(&back).ok() } else { None }
            };
            found.extend(edge.tests.iter().filter_map(over));
        }
    }
    found
}

/// Whether a name has another value from visit to visit, or is drawn.
fn varies(name: &Name, own: &BTreeSet<&Name>, edge: &Edge) -> bool {
    own.contains(name) || edge.draws.iter().any(|(drawn, _)| drawn == name)
}

/// What the variables were before this way, in terms of what they are behind it.
fn backward(edge: &Edge, own: &BTreeSet<&Name>) -> BTreeMap<Name, Value> {
    let mut back = BTreeMap::new();
    for (name, image) in &edge.map {
        let mut read = image.variables().into_iter().filter(|read| varies(read, own, edge));
        let (Some(only), None) = (read.next(), read.next()) else { continue };
        let Some((factor, rest)) = image.linear_in(&only) else { continue };
        let plain = factor.as_rational().is_some_and(|factor: BigRational| !factor.is_zero());
        if let (true, Ok(before)) = (plain, Value::variable(name).sub(&rest).and_then(|moved| moved.div(&factor))) {
            back.entry(only).or_insert(before);
        }
    }
    back
}
