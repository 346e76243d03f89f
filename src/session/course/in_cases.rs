//! Where a system comes to in each case of what would have to be known of parameters for it.

use std::cell::Cell;

use super::{Known, Unsettled, course_as_assumed};
use crate::assumption::Assumptions;
use crate::closed_form::Comparison;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::Period;
use crate::period::course::Course;
use crate::recurrence::{InCase, Unknown, in_each_case};
use crate::value::{Atom, Relation, Value};

/// The most times that a run is followed, and that it is not known where it comes to, before that is known in a case.
const MOST_RUNS: usize = 10;
const MOST_FAILURES: usize = 2;
/// The longest comparison that makes cases: a longer one says nothing to a reader, and takes long to decide.
const MOST_SIZE: usize = 60;

/// What is found in a case; or why it is open there.
pub(crate) type Found = Result<Known, Option<String>>;

/// Where it comes to in every case of what stands in the way; nothing where that is known in none of them.
pub(super) fn in_cases(
    (period, system, environment): (&Period, &System, &Environment),
    why: &Unsettled,
    interrupted: &dyn Fn() -> bool,
) -> Vec<InCase<Found>> {
    let known = &environment.assumptions;
    let declared = |name: &Name| environment.quantity(name).is_some();
    let (runs, failures, found) = (Cell::new(0), Cell::new(0), Cell::new(false));
    let hopeless = || !found.get() && failures.get() >= MOST_FAILURES;
    let enough = || runs.get() >= MOST_RUNS || interrupted();
    let ask = |known: &Assumptions| {
        if hopeless() {
            return Err((Unknown::because(String::new()), None));
        }
        runs.set(runs.get() + 1);
        let mut here = environment.clone();
        here.assumptions = known.clone();
        match course_as_assumed(period, system, &here, interrupted) {
            Ok(Some(known)) => {
                found.set(true);
                Ok(Ok(known))
            }
            Ok(None) => Err((Unknown::because(String::new()), None)),
            Err(why) => {
                failures.set(failures.get() + 1);
                Err((question(&why, known, &declared), Some(Box::new(Err(why.reason)))))
            }
        }
    };
    let cases = in_each_case(&declared, known, &question(why, known, &declared), &ask, &enough).unwrap_or_default();
    let some = cases.iter().any(|case| case.found.is_ok());
    if some && !interrupted() { cases } else { Vec::new() }
}

/// What holds in all cases, if one of them says what is so in each.
pub(super) fn in_all(cases: &[InCase<Found>]) -> Option<Known> {
    let says_all = |one: &&InCase<Found>| cases.iter().all(|case| says(&one.found, case));
    let found = cases.iter().find(says_all)?;
    let found = found.found.as_ref().ok()?;
    let moving = cases.iter().any(|case| case.found.as_ref().is_ok_and(|known| known.moving));
    let Course::Repeats { lasting, from, .. } = &found.course else { return None };
    let beside = cases.iter().flat_map(|case| match case.found.as_ref().map(|known| &known.course) {
        Ok(Course::Repeats { beside, .. }) => beside.clone(),
        _ => Default::default(),
    });
    let course = Course::Repeats { lasting: lasting.clone(), from: from.clone(), beside: beside.collect() };
    Some(Known { course, moving })
}

/// Whether what was found in one case says how long it lasts in this, and from when on.
fn says(one: &Found, case: &InCase<Found>) -> bool {
    let (Ok(one), Ok(own)) = (one, &case.found) else { return false };
    let (Course::Repeats { lasting, from, .. }, Course::Repeats { lasting: time, from: since, .. }) =
        (&one.course, &own.course)
    else {
        return false;
    };
    let known = &case.known;
    let is = |relation, one: &Value, other: &Value| known.decide(relation, one, other) == Some(true);
    [lasting, from].into_iter().all(|time| known.gives_meaning(time))
        && is(Relation::Eq, lasting, time)
        && is(Relation::Gte, from, since)
}

/// What would have to be known: of a maximum in it, first which of its elements it is.
fn question(why: &Unsettled, known: &Assumptions, declared: &dyn Fn(&Name) -> bool) -> Unknown {
    let open = why.asked.iter().find_map(|asked| of_parameters(asked, known, declared));
    Unknown { reason: why.reason.clone().unwrap_or_default(), open: open.map(Box::new) }
}

fn of_parameters(
    (relation, left, right): &Comparison,
    known: &Assumptions,
    declared: &dyn Fn(&Name) -> bool,
) -> Option<Comparison> {
    let free = |value: &Value| value.variables().iter().all(declared);
    // Of roots there are so many cases, and each so long, that they say nothing.
    // Where it may have no value, neither it nor its opposite holds: they are not all cases.
    let plain = |value: &Value| !has_root(value) && known.gives_meaning(value);
    if ![left, right].into_iter().all(|side| free(side) && plain(side)) || left.size() + right.size() > MOST_SIZE {
        return None;
    }
    let decided = |known: &Assumptions| known.decide(*relation, left, right).is_some();
    if decided(known) {
        return None;
    }
    let mut asked = Vec::new();
    signs(left, &mut asked);
    signs(right, &mut asked);
    asked.retain(|(relation, left, right)| {
        known.gives_meaning(left) && known.gives_meaning(right) && known.decide(*relation, left, right).is_none()
    });
    // With a comparison that tells in either case there are the fewest cases.
    let tells = |(relation, left, right): &&Comparison| {
        [*relation, relation.negated()].into_iter().all(|relation| {
            let mut known = known.clone();
            known.assume(relation, left, right);
            decided(&known)
        })
    };
    let best = asked.iter().find(tells).or(asked.first()).cloned();
    Some(best.unwrap_or_else(|| (*relation, left.clone(), right.clone())))
}

/// The comparisons on which it depends which element of a maximum counts, and which case; those inside others first.
fn signs(value: &Value, found: &mut Vec<Comparison>) {
    for atom in value.atoms() {
        atom.parts().into_iter().for_each(|inner| signs(inner, found));
        match &atom {
            Atom::Positive(inner) => found.extend(in_order(inner, &Value::zero()).into_iter().take(1)),
            Atom::Maximum(elements) => {
                let zero = std::iter::once(Value::zero());
                let all: Vec<Value> = elements.iter().cloned().chain(zero).collect();
                for (place, one) in all.iter().enumerate() {
                    found.extend(all[place + 1..].iter().flat_map(|other| in_order(one, other)));
                }
            }
            _ => {}
        }
    }
}

/// That one value is more than another, and that it is not less.
fn in_order(one: &Value, other: &Value) -> [Comparison; 2] {
    [Relation::Gtr, Relation::Gte].map(|order| (order, one.clone(), other.clone()))
}

fn has_root(value: &Value) -> bool {
    let root = |atom: &Atom| matches!(atom, Atom::Root(_)) || atom.parts().into_iter().any(has_root);
    value.atoms().iter().any(root)
}
