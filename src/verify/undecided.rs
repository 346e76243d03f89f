//! What would have to be known for a run to go on, where several ways may be taken.

use std::collections::BTreeSet;

use super::count::of_one_component;
use super::round::{is_large, is_long};
use super::trajectory::Values;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, End, Next, Test, in_case};
use crate::recurrence::{Comparison, Unknown};
use crate::value::{Relation, Value, ValueError};

/// Legs that a run may have before it repeats.
const MOST_LEGS: usize = 1_000;
/// Changes of phase before a run must have repeated.
const MOST_CHANGES: usize = 500;

/// Why the run goes no further.
#[derive(Default)]
pub(super) struct Unsure {
    /// In words.
    pub(super) reasons: Vec<String>,
    /// What is not decided.
    pub(super) asked: Vec<Comparison>,
}

impl Unsure {
    pub(super) fn because(reason: impl Into<String>) -> Unsure {
        Unsure { reasons: vec![reason.into()], asked: Vec::new() }
    }

    /// That a comparison is not decided.
    pub(super) fn whether(relation: Relation, left: &Value, right: &Value) -> Unsure {
        let reason = format!("whether {left} {} {right}", relation.symbol());
        Unsure { reasons: vec![reason], asked: vec![(relation, left.clone(), right.clone())] }
    }

    pub(super) fn and(mut self, other: Unsure) -> Unsure {
        self.reasons.extend(other.reasons);
        self.asked.extend(other.asked);
        self
    }
}

impl From<ValueError> for Unsure {
    fn from(error: ValueError) -> Unsure {
        Unsure::because(error.0)
    }
}

impl From<Unknown> for Unsure {
    fn from(error: Unknown) -> Unsure {
        Unsure { reasons: vec![error.reason], asked: error.open.into_iter().map(|open| *open).collect() }
    }
}

/// Whether a run that has not repeated is given up: after so many legs, or where its values grow.
pub(super) fn too_far(legs: usize, changes: usize, values: &Values) -> Result<(), Unsure> {
    let (long, large) = (values.values().any(is_long), values.values().any(is_large));
    if legs < MOST_LEGS && changes <= MOST_CHANGES && !long && !large {
        return Ok(());
    }
    let why = match (long, large) {
        (true, _) => ", and its numbers grow without end: it may only converge",
        (_, true) => ", and the forms of its values grow with every leg",
        _ => "",
    };
    Err(Unsure::because(format!("after {legs} legs the run has not repeated exactly{why}")))
}

/// Ways that may be taken, each with the tests that are not decided.
type Possible<'e> = [(&'e Edge, Vec<Test>)];

/// That one of these ways is taken and it is not known which: which tests are not decided, each once, and an assumption
/// about parameters that would tell.
pub(super) fn between(possible: &Possible<'_>, assumptions: &Assumptions) -> Unsure {
    let mut reasons = Vec::new();
    for (edge, open) in possible {
        if let Next::End(End::Livelock { cycle, .. }) = &edge.next {
            let cycle: Vec<&str> = cycle.iter().map(Name::as_str).collect();
            let case = in_case(open);
            reasons.push(format!("the program goes round in no time ({}){case}", cycle.join(", ")));
        }
    }
    let mut tests: Vec<Test> = Vec::new();
    let all: BTreeSet<&Test> = possible.iter().flat_map(|(_, open)| open).collect();
    for test in all {
        let test = if test.relation == Relation::Neq { test.negated() } else { test.clone() };
        let test = plainer(test, assumptions);
        if !tests.contains(&test) && !tests.contains(&test.negated()) {
            tests.push(test);
        }
    }
    // What follows from the assumptions is no question to ask.
    let open: Vec<Test> = tests.iter().filter(|test| test.decide(assumptions).is_none()).cloned().collect();
    let tests = if open.is_empty() { tests } else { open };
    let telling = tests.iter().find_map(|test| telling(test, possible, assumptions));
    let count = tests.len();
    reasons.extend(tests.iter().enumerate().map(|(place, test)| {
        let help = telling.as_ref().filter(|_| place + 1 == count);
        let help = help.map(|test| format!("; an assumption such as `param {test}` tells")).unwrap_or_default();
        format!("it must be known whether {test}{help}")
    }));
    Unsure { reasons, asked: tests.into_iter().map(|test| (test.relation, test.left, test.right)).collect() }
}

/// A test of vectors by the one component in which they may differ, as far as it is known what its parts are.
fn plainer(test: Test, assumptions: &Assumptions) -> Test {
    match of_one_component(test.clone(), assumptions) {
        Ok(one) if one != test => Test { left: assumptions.simplify(&one.left), ..one },
        _ => test,
    }
}

/// A test, or its opposite, with which one way alone is left; where both do that, the one that holds of more values.
fn telling(test: &Test, possible: &Possible<'_>, assumptions: &Assumptions) -> Option<Test> {
    let declared = assumptions.variables();
    let names = test.left.variables().into_iter().chain(test.right.variables());
    if !names.into_iter().all(|name| declared.contains(&name)) {
        return None;
    }
    let narrow = [Relation::Eq, Relation::Lte, Relation::Lss].contains(&test.relation);
    let both = if narrow { [test.negated(), test.clone()] } else { [test.clone(), test.negated()] };
    both.into_iter().find(|test| {
        let mut known = assumptions.clone();
        known.assume(test.relation, &test.left, &test.right);
        let left = |open: &Vec<Test>| open.iter().all(|test| test.decide(&known) != Some(false));
        possible.iter().filter(|(_, open)| left(open)).count() == 1
    })
}
