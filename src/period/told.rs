//! Conditions in words, in the shorter of two forms: over the variables before a round, or over those after it.

use std::collections::BTreeMap;
use std::fmt;

use super::Test;
use crate::name::Name;
use crate::value::{Atom, Sort, Value};

/// Longer texts than this are said over the variables after the round, where that can be.
const LONG: usize = 48;

impl fmt::Display for Test {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A choice would take in what stands behind it.
        let side = |value: &Value| match value.to_string() {
            text if text.starts_with("if ") => format!("({text})"),
            text => text,
        };
        let text = |test: &Test| format!("{} {} {}", side(&test.left), test.relation.symbol(), side(&test.right));
        let own = text(self);
        let distance = distance(self).map(|distance| text(&distance)).filter(|other| other.len() < own.len());
        f.write_str(&distance.unwrap_or(own))
    }
}

/// A comparison of a distance with a number, where its parts stand on both sides: `2*max(0,x) > x+5` is `abs(x) > 5`.
fn distance(test: &Test) -> Option<Test> {
    let both = |atom: &Atom| matches!(atom, Atom::Maximum(elements) if elements.len() == 1);
    if test.left.sort() != Sort::Real || !test.left.atoms().iter().chain(&test.right.atoms()).any(both) {
        return None;
    }
    let difference = test.left.sub(&test.right).ok()?;
    let atoms: Vec<Atom> = difference.atoms().into_iter().filter(both).collect();
    let [atom @ Atom::Maximum(elements)] = atoms.as_slice() else { return None };
    let name = Name::new("[maximum]");
    let (factor, _) = difference.with_atom(atom, &Value::variable(&name)).ok()?.linear_in(&name)?;
    let half = factor.mul(&Value::fraction(1, 2).ok()?).ok().filter(|half| half.as_rational().is_some())?;
    let distance = elements.first()?.abs().ok()?;
    let rest = difference.div(&half).ok()?.sub(&distance).ok()?.neg().ok()?;
    rest.as_rational()?;
    let negative = half.as_rational()? < num_traits::Zero::zero();
    Some(Test {
        relation: if negative { test.relation.mirrored() } else { test.relation },
        left: distance,
        right: rest,
    })
}

/// Groups of components that are named; of more, their number is said.
const MOST_GROUPS: usize = 6;

/// `A with B and C with D`, of many the first ones.
pub(super) fn groups(groups: &[Vec<String>]) -> String {
    let named = groups.iter().take(MOST_GROUPS).map(|group| group.join(" with "));
    let rest = groups.len().saturating_sub(MOST_GROUPS);
    let rest = (rest > 0).then(|| format!("{rest} more"));
    named.chain(rest).collect::<Vec<_>>().join(" and ")
}

/// `A goes round in no time`, `A, B and C go round in no time`.
pub(super) fn go_round(names: &[Name]) -> String {
    let names: Vec<&str> = names.iter().map(Name::as_str).collect();
    match names.as_slice() {
        [first @ .., last] if !first.is_empty() => format!("{} and {last} go round in no time", first.join(", ")),
        _ => format!("{} goes round in no time", names.concat()),
    }
}

/// `, each time with k+1 for k and …`, or nothing.
pub(super) fn each_time(changes: &[(Name, Value)]) -> String {
    let changes: Vec<String> = changes.iter().map(|(name, value)| format!("{value} for {name}")).collect();
    if changes.is_empty() { String::new() } else { format!(", each time with {}", changes.join(" and ")) }
}

/// That it matters who reads first where each is written another value, and what would tell.
pub(super) fn another_each_time(writer: &Option<String>, port: &Name) -> String {
    let Some(writer) = writer else { return String::new() };
    format!(
        ": {writer} writes another value there each time, so it matters who reads first; one value for both would be \
         `(Out_{{{port},…}} | Out_{{{port}2,…}})`, on a port for each"
    )
}

/// ` if a = b and …`, or nothing.
pub(crate) fn in_case(tests: &[Test]) -> String {
    in_case_after(tests, None)
}

/// The same, where long tests are said over the variables after a round with this flow function.
pub(crate) fn in_case_after(tests: &[Test], round: Option<&BTreeMap<Name, Value>>) -> String {
    let text = |test: &Test| match test_after(test, round) {
        Some(after) if test.to_string().len() > LONG => format!("{after} after the round"),
        _ => test.to_string(),
    };
    let tests: Vec<String> = tests.iter().map(text).collect();
    if tests.is_empty() { String::new() } else { format!(" if {}", tests.join(" and ")) }
}

/// A test over the variables as they are after a round, where it can be said so.
pub(super) fn test_after(test: &Test, round: Option<&BTreeMap<Name, Value>>) -> Option<Test> {
    let [left, right] = [&test.left, &test.right].map(|side| told_after(side, round, true));
    Some(Test { relation: test.relation, left: left?, right: right? })
}

/// A value as the variables are after a round: of one whose variable's image it is; a number, where asked for, as itself.
pub(crate) fn told_after(value: &Value, round: Option<&BTreeMap<Name, Value>>, numbers: bool) -> Option<Value> {
    let round = round?;
    let one = |value: &Value| {
        let image = || round.iter().find(|(_, image)| *image == value).map(|(name, _)| Value::variable(name));
        if value.variables().is_empty() { Some(value.clone()) } else { image() }
    };
    let Sort::Vector(count) = value.sort() else {
        return one(value).filter(|_| numbers || value.to_string().len() > LONG);
    };
    let parts = (0..count).map(|place| one(&value.component(place)?)).collect::<Option<Vec<Value>>>()?;
    let told = Value::vector(parts).ok()?;
    (numbers || !told.variables().is_empty() && value.to_string().len() > LONG).then_some(told)
}
