//! A moment in the case that a question is answered so or so.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::convert::Infallible;
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::Zero;

use super::Test;
use super::instant::Moment;
use super::run::{Path, RawTest, Settler, least};
use super::step::{Slot, map_values};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, View};

/// So many facts are kept in any case.
const FEW: usize = 4;

/// The moment with an answer assumed; nothing if that contradicts what is known.
pub(super) fn suppose(settler: &Settler<'_>, moment: &Moment, question: &RawTest, answer: bool) -> Option<Moment> {
    let turn = |test: &Test| if answer { test.clone() } else { test.negated() };
    let test = turn(&question.test);
    let mut path = moment.path.clone();
    let over = over(moment, question);
    let assumptions = Rc::make_mut(&mut path.assumptions);
    if !over.is_empty() {
        *assumptions = assumptions.without(&over);
    }
    assumptions.assume(test.relation, &test.left, &test.right);
    if !answer && question.surely || assumptions.contradictory_by_last() {
        return None;
    }
    let mut changed = moment.clone();
    if test.relation == Relation::Eq {
        let vary = (settler.varies(&test.left), settler.varies(&test.right));
        let (from, to) = match vary {
            (true, false) => (Some(&test.left), &test.right),
            (false, true) => (Some(&test.right), &test.left),
            _ => (None, &test.left),
        };
        let solved = if from.is_none() { solved(settler, &test) } else { None };
        // A place that is reached is said by its name, which varies as well.
        let (from, to) = match test.left.size().cmp(&test.right.size()) {
            _ if vary != (true, true) || solved.is_some() => (from, to),
            Ordering::Greater => (Some(&test.left), &test.right),
            Ordering::Less => (Some(&test.right), &test.left),
            Ordering::Equal => (None, to),
        };
        changed.replace(&|value: &Value| match (&solved, from) {
            (Some((name, known)), _) => value.with(name, known).unwrap_or_else(|_| value.clone()),
            (None, Some(from)) if value == from => to.clone(),
            _ => value.clone(),
        });
    }
    let raw = turn(&question.raw);
    path.tests.push(RawTest { test, raw, ..question.clone() });
    Some(changed.settled_anew(path))
}

/// What was drawn, of which nothing that is asked can turn on any more what is known: nothing holds it, it stands in one
/// fact alone, and whatever all else is, it may have been such that this fact holds.
fn over(moment: &Moment, question: &RawTest) -> BTreeSet<Name> {
    let known = &moment.path.assumptions;
    if known.count() <= FEW {
        return BTreeSet::new();
    }
    let mut held = question.test.left.variables();
    held.extend(question.test.right.variables());
    for run in &moment.state {
        let mut hold = |_: Slot<'_>, value: &Value| -> Result<Value, Infallible> {
            held.extend(value.variables());
            Ok(value.clone())
        };
        // There is nothing that could fail.
        let Ok(_) = map_values(run, &mut hold);
    }
    let facts: Vec<(Relation, Value)> = known.iter().collect();
    let alone = |name: &&Name| {
        let mut about = facts.iter().filter(|(_, value)| value.mentions(name));
        about.next().is_some_and(|(_, value)| is_free(value, name)) && about.next().is_none()
    };
    // Of what is drawn between bounds these may be asked as well.
    let free = moment.path.draws.iter().filter(|(_, distribution)| least(distribution, known).is_none());
    let draws = free.map(|(name, _)| name);
    draws.filter(|name| known.mentions(name) && !held.contains(*name)).filter(alone).cloned().collect()
}

/// Whether the values that a value can have for some number for a name are the same whatever the other names stand for:
/// it is linear in the name, or nothing but a function of one number that is.
fn is_free(value: &Value, name: &Name) -> bool {
    let shift = |value: &Value| -> Option<Value> {
        let (factor, rest) = value.linear_in(name)?;
        let number = factor.as_rational().filter(|number: &BigRational| !number.is_zero())?;
        Value::variable(name).sub(&rest).ok()?.div(&Value::rational(number)).ok()
    };
    let alone = |image: Value| {
        let moved = value.with(name, &image);
        moved.is_ok_and(|moved| moved.variables().iter().all(|variable| variable == name))
    };
    let elements = value.atoms().into_iter().flat_map(|atom| match atom {
        Atom::Maximum(elements) => elements.to_vec(),
        Atom::Positive(inner) => vec![inner],
        _ => Vec::new(),
    });
    shift(value).is_some() || elements.filter_map(|element| shift(&element)).any(alone)
}

/// Whether a test holds of all numbers that may be drawn: an exponential one is more than 0. A loop that waits for one would
/// else go round in no time.
pub(super) fn surely(path: &Path, test: &Test) -> bool {
    let exponential = |(_, distribution): &&(Name, Value)| matches!(distribution.view(), View::Distribution(kind, _) if kind.as_str() == "Exp");
    let asked = |(name, _): &&(Name, Value)| [&test.left, &test.right].into_iter().any(|side| side.mentions(name));
    let mut all = path.draws.iter().filter(exponential).filter(asked).peekable();
    if all.peek().is_none() {
        return false;
    }
    let mut known = Assumptions::clone(&path.assumptions);
    all.for_each(|(name, _)| known.assume(Relation::Gtr, &Value::variable(name), &Value::zero()));
    test.decide(&known) == Some(true)
}

/// The variable of which an equation leaves one value that does not vary, with that value: `g = -2*g` only where g = 0.
fn solved(settler: &Settler<'_>, test: &Test) -> Option<(Name, Value)> {
    let difference = test.left.sub(&test.right).ok()?;
    difference.variables().into_iter().find_map(|name| {
        let (factor, rest) = difference.linear_in(&name)?;
        let number = factor.as_rational().filter(|number: &BigRational| !number.is_zero())?;
        let known = rest.neg().ok()?.div(&Value::rational(number)).ok()?;
        (settler.varies(&Value::variable(&name)) && !settler.varies(&known)).then_some((name, known))
    })
}
