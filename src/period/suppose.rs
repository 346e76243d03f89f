//! A moment in the case that a question is answered so or so.

use std::rc::Rc;

use num_rational::BigRational;
use num_traits::Zero;

use super::Test;
use super::instant::Moment;
use super::run::{Path, RawTest, Settler};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value, View};

/// The moment with an answer assumed; nothing if that contradicts what is known.
pub(super) fn suppose(settler: &Settler<'_>, moment: &Moment, question: &RawTest, answer: bool) -> Option<Moment> {
    let turn = |test: &Test| if answer { test.clone() } else { test.negated() };
    let test = turn(&question.test);
    let mut path = moment.path.clone();
    let assumptions = Rc::make_mut(&mut path.assumptions);
    assumptions.assume(test.relation, &test.left, &test.right);
    if !answer && question.surely || assumptions.contradictory() {
        return None;
    }
    let mut changed = moment.clone();
    if test.relation == Relation::Eq {
        let (from, to) = match (settler.varies(&test.left), settler.varies(&test.right)) {
            (true, false) => (Some(&test.left), &test.right),
            (false, true) => (Some(&test.right), &test.left),
            _ => (None, &test.left),
        };
        let solved = if from.is_none() { solved(settler, &test) } else { None };
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
