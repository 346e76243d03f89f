//! Where a system comes to in each case of which values are equal: two goals, or a goal and the place where it begins.

use std::collections::BTreeMap;

use super::in_cases::Found;
use super::{MOST_SPLITS, may_be_equal, within_cases};
use crate::assumption::Assumptions;
use crate::closed_form::Comparison;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::{Edge, Next, Period};
use crate::recurrence::InCase;
use crate::value::{Atom, Relation, Value};

/// Of so many differences of parameters either case is looked at.
const MOST_EQUALITIES: usize = 2;

/// Where it comes to in every case of what the ways that end, and those from the start, ask to be equal, where maxima are
/// among what is asked; nothing where that is not known in one of them. In each it is looked for on both sides of what is
/// not equal, and told as one.
pub(super) fn by_equalities(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Vec<InCase<Found>> {
    let cut_off = |value: &Value| value.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_)));
    if !period.ways().flat_map(|edge| &edge.tests).any(|test| cut_off(&test.left) || cut_off(&test.right)) {
        return Vec::new();
    }
    let mut leaves: Vec<(Vec<Comparison>, Assumptions)> = vec![(Vec::new(), environment.assumptions.clone())];
    for difference in asked(period, environment) {
        leaves = leaves.iter().flat_map(|leaf| split(leaf, &difference)).collect();
    }
    let mut cases = Vec::new();
    for (assumed, known) in leaves.into_iter().filter(|(_, known)| !known.contradictory()) {
        let mut here = environment.clone();
        here.assumptions = known.clone();
        match within_cases(period, system, &here, MOST_SPLITS, interrupted) {
            Ok(Some(found)) if !interrupted() => cases.push(InCase { assumed, known, found: Ok(found) }),
            _ => return Vec::new(),
        }
    }
    if cases.len() > 1 { cases } else { Vec::new() }
}

/// A case in the two of a difference, where it is open.
fn split((assumed, known): &(Vec<Comparison>, Assumptions), difference: &Value) -> Vec<(Vec<Comparison>, Assumptions)> {
    let zero = Value::zero();
    if known.decide(Relation::Eq, difference, &zero).is_some() {
        return vec![(assumed.clone(), known.clone())];
    }
    let case = |relation: Relation| {
        let (mut assumed, mut known) = (assumed.clone(), known.clone());
        known.assume(relation, difference, &zero);
        assumed.push((relation, difference.clone(), zero.clone()));
        (assumed, known)
    };
    [Relation::Eq, Relation::Neq].map(case).to_vec()
}

/// The differences of names that are asked to be 0, those of the most ways that end first.
fn asked(period: &Period, environment: &Environment) -> Vec<Value> {
    let mut found = may_be_equal(period, environment);
    let ends = || period.ways().filter(|edge| matches!(edge.next, Next::End(_)));
    let differences = |edge: &Edge| {
        let equal = edge.tests.iter().filter(|test| test.relation == Relation::Eq);
        equal.filter_map(|test| test.left.sub(&test.right).ok()).collect::<Vec<_>>()
    };
    found.extend(ends().flat_map(differences));
    let declared = |name: &Name| environment.quantity(name).is_some();
    let plain = |value: &Value| {
        value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(name) if declared(name)))
            && value.polynomials().is_some_and(|(_, denominator)| denominator.is_one())
    };
    let is = |one: &Value, other: &Value| one == other || one.neg().is_ok_and(|one| one == *other);
    let mut all: Vec<(usize, Value)> = Vec::new();
    for value in found.into_iter().filter(plain) {
        let open = environment.assumptions.decide(Relation::Eq, &value, &Value::zero()).is_none();
        if open && !all.iter().any(|(_, known)| is(known, &value)) {
            let often = ends().filter(|edge| differences(edge).iter().any(|one| is(one, &value))).count();
            all.push((often, value));
        }
    }
    all.sort_by_key(|(often, _)| std::cmp::Reverse(*often));
    all.into_iter().take(MOST_EQUALITIES).map(|(_, value)| value).collect()
}

/// A value with one name in place of another that is known to be equal to it.
pub(super) fn with_equals(value: &Value, known: &Assumptions) -> Value {
    let mut value = value.clone();
    for (_, difference) in known.iter().filter(|(relation, _)| *relation == Relation::Eq) {
        let image = difference.variables().into_iter().rev().find_map(|name| {
            let (factor, rest) = difference.linear_in(&name)?;
            factor.as_rational()?;
            Some((name, rest.neg().ok()?.div(&factor).ok()?))
        });
        if let Some(image) = image
            && let Ok(same) = known.put_in(&value, &BTreeMap::from([image]))
        {
            value = same;
        }
    }
    value
}
