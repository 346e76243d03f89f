//! A moment in the case that a question is answered so or so.

use std::rc::Rc;

use num_rational::BigRational;
use num_traits::Zero;

use super::Test;
use super::instant::Moment;
use super::run::{RawTest, Settler};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The moment with an answer assumed; nothing if that contradicts what is known.
pub(super) fn suppose(settler: &Settler<'_>, moment: &Moment, question: &RawTest, answer: bool) -> Option<Moment> {
    let turn = |test: &Test| if answer { test.clone() } else { test.negated() };
    let test = turn(&question.test);
    let mut path = moment.path.clone();
    let assumptions = Rc::make_mut(&mut path.assumptions);
    assumptions.assume(test.relation, &test.left, &test.right);
    if assumptions.contradictory() {
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
    path.tests.push(RawTest { test, raw, env: question.env.clone() });
    Some(changed.settled_anew(path))
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
