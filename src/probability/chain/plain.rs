//! Draws that are told apart, or moved, so that what is left is linear: a normal number whose mean is drawn or known by then is
//! that mean and a normal number round 0, and where a number with finitely many values multiplies others there is a way for
//! each of its values.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;

use crate::distribution::Distribution;
use crate::name::Name;
use crate::period::{Edge, End, Next, Segment, Test};
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::{Relation, Value, View};

/// Values of one number that are told apart, and ways that come of it.
const MOST_VALUES: usize = 8;
const MOST_WAYS: usize = 64;

/// The edge with plain draws; several, of which one is taken, where values are told apart. What cannot be helped stays.
pub(super) fn plain(edge: &Edge, state: &[Name]) -> Vec<Edge> {
    let Some(edge) = centred(edge) else { return vec![edge.clone()] };
    let names: BTreeSet<Name> = state.iter().cloned().chain(edge.draws.iter().map(|(name, _)| name.clone())).collect();
    let mut ways = vec![edge.clone()];
    for (name, distribution) in &edge.draws {
        let Some(values) = values(distribution).filter(|_| multiplies(name, &edge, &names)) else { continue };
        if ways.len() * values.len() > MOST_WAYS {
            break;
        }
        let each = ways.iter().flat_map(|way| values.iter().map(|value| told(way, name, value)));
        let Some(each) = each.collect::<Option<Vec<Edge>>>() else { break };
        ways = each;
    }
    ways
}

/// Normal numbers with their means taken out where these are no numbers.
fn centred(edge: &Edge) -> Option<Edge> {
    let mut all = edge.clone();
    for place in 0..all.draws.len() {
        let (name, distribution) = all.draws[place].clone();
        let View::Distribution(kind, arguments) = distribution.view() else { continue };
        let ("Normal", [mean, variance]) = (kind.as_str(), arguments.as_slice()) else { continue };
        if mean.as_rational().is_some() {
            continue;
        }
        let moved = Value::variable(&name).add(mean).ok()?;
        let round = Value::distribution("Normal", vec![Value::zero(), variance.clone()]).ok()?;
        all = replaced(&all, &name, &moved)?;
        all.draws[place].1 = round;
    }
    Some(all)
}

/// The values of a number that has finitely many.
fn values(distribution: &Value) -> Option<Vec<BigRational>> {
    let parts = Distribution::of(distribution).ok()?.parts();
    let values = parts.into_iter().map(|(_, part)| match part {
        Distribution::Point(at) => Some(at),
        _ => None,
    });
    let values = values.collect::<Option<BTreeSet<BigRational>>>()?;
    (1..=MOST_VALUES).contains(&values.len()).then(|| values.into_iter().collect())
}

/// Whether something that passes is not linear in a number, or linear with another number as its factor.
fn multiplies(name: &Name, edge: &Edge, names: &BTreeSet<Name>) -> bool {
    let shown = observed(edge);
    let observed = shown.iter().flat_map(Term::values);
    let tests = edge.tests.iter().flat_map(|test| [&test.left, &test.right]);
    let mut all = observed.chain(tests).chain(edge.map.values());
    all.any(|value| {
        value.mentions(name)
            && value.linear_in(name).is_none_or(|(factor, _)| factor.variables().iter().any(|one| names.contains(one)))
    })
}

/// All that is shown.
fn observed(edge: &Edge) -> Vec<Term> {
    let mut all: Vec<_> = edge.segments.iter().flat_map(|segment| segment.observed.iter().cloned()).collect();
    if let Next::End(End::Silent { observed, .. }) = &edge.next {
        all.extend(observed.iter().cloned());
    }
    all
}

/// The way of one value.
fn told(edge: &Edge, name: &Name, value: &BigRational) -> Option<Edge> {
    let value = Value::rational(value.clone());
    let mut way = replaced(edge, name, &value)?;
    way.tests.push(Test { relation: Relation::Eq, left: Value::variable(name), right: value });
    Some(way)
}

/// The edge with a value in place of a draw, which is still drawn.
fn replaced(edge: &Edge, name: &Name, value: &Value) -> Option<Edge> {
    let map = BTreeMap::from([(name.clone(), value.clone())]);
    let terms =
        |terms: &[Term]| terms.iter().map(|term| substitute_values(term, &map).ok()).collect::<Option<Vec<_>>>();
    let mut all = edge.clone();
    all.tests = edge.tests.iter().map(|test| test.substitute(&map).ok()).collect::<Option<_>>()?;
    for segment in &mut all.segments {
        let duration = segment.duration.substitute(&map).ok()?;
        *segment = Segment { duration, observed: terms(&segment.observed)? };
    }
    for image in all.map.values_mut() {
        *image = image.substitute(&map).ok()?;
    }
    for (_, distribution) in &mut all.draws {
        *distribution = distribution.substitute(&map).ok()?;
    }
    if let Next::End(End::Silent { observed, .. }) = &mut all.next {
        *observed = terms(observed)?;
    }
    Some(all)
}
