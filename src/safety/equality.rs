//! Variables of a phase that go together whichever way it is entered: a distance that was read is the difference of the
//! positions it was read from.

use std::collections::BTreeSet;

use super::candidates::entries;
use crate::name::Name;
use crate::period::{Edge, Period, Test};
use crate::value::{Relation, Value};

/// Variables of a phase that are looked at.
const MOST_VARIABLES: usize = 12;

/// Variables, and sums and differences of up to three, that are the same value of the parameters on every way into a phase.
pub fn equalities(period: &Period, number: usize) -> BTreeSet<Test> {
    let ways: Vec<&Edge> = entries(period, number).collect();
    let variables: Vec<Value> =
        period.phases[number].variables.iter().take(MOST_VARIABLES).map(Value::variable).collect();
    let mut found = BTreeSet::new();
    for form in forms(&variables) {
        if let Some(constant) = common(&form, &ways, period) {
            // With 0 on the right it holds by normal form where it is put in.
            if let Ok(left) = form.sub(&constant) {
                found.insert(Test { relation: Relation::Eq, left, right: Value::zero() });
            }
        }
    }
    found
}

/// `x`, `x - y`, `x + y`, `x - y - z`, …: the first sign is always plus.
fn forms(variables: &[Value]) -> Vec<Value> {
    let mut forms = variables.to_vec();
    for (place, one) in variables.iter().enumerate() {
        for (at, two) in variables.iter().enumerate().skip(place + 1) {
            let pairs = [one.sub(two), one.add(two)];
            for pair in pairs.into_iter().flatten() {
                for three in &variables[at + 1..] {
                    forms.extend([pair.sub(three), pair.add(three)].into_iter().flatten());
                }
                forms.push(pair);
            }
        }
    }
    forms
}

/// The value of a form on every way, if it is the same and has no variable of a phase.
fn common(form: &Value, ways: &[&Edge], period: &Period) -> Option<Value> {
    // A way on which it stays what it was says nothing of what it is.
    let mut values =
        ways.iter().map(|edge| form.substitute(&edge.map).ok()).filter(|value| value.as_ref() != Some(form));
    let first = values.next()??;
    let free = |name: &Name| {
        let drawn = ways.iter().any(|edge| edge.draws.iter().any(|(draw, _)| draw == name));
        !drawn && !period.phases.iter().any(|phase| phase.variables.contains(name))
    };
    (first.variables().iter().all(free) && values.all(|value| value.as_ref() == Some(&first))).then_some(first)
}
