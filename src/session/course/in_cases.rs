//! Where a system comes to in each case of what would have to be known of parameters for it.

use std::cell::Cell;

use super::{Known, Unsettled, course_as_assumed};
use crate::assumption::Assumptions;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::Period;
use crate::period::course::Course;
use crate::recurrence::{InCase, Unknown, in_each_case};
use crate::value::{Relation, Value};
use crate::verify::{equal, rounded, side};

/// The most times that a run is followed, and that it is not known where it comes to, before that is known in a case.
const MOST_RUNS: usize = 24;
/// The most comparisons that one case may depend on.
const MOST_ASKED: usize = 5;
const MOST_FAILURES: usize = 6;

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
    let cases = in_each_case((&declared, MOST_ASKED), known, &question(why, known, &declared), &ask, &enough)
        .unwrap_or_default();
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
    let plain = |value: &Value| std::iter::successors(rounded(value, known), |value| rounded(value, known)).last();
    let later = |from: &Value| known.decide(Relation::Gte, from, since) == Some(true);
    [lasting, from].into_iter().all(|time| known.gives_meaning(time))
        && equal(lasting, time, known)
        && (later(from) || plain(from).is_some_and(|from| later(&from)))
}

/// What would have to be known: of a maximum in it, first which of its elements it is.
fn question(why: &Unsettled, known: &Assumptions, declared: &dyn Fn(&Name) -> bool) -> Unknown {
    let open = why.asked.iter().find_map(|asked| side(asked, known, declared));
    Unknown { open: open.map(Box::new), ..Unknown::because(why.reason.clone().unwrap_or_default()) }
}
