//! How long it takes until a system that goes through several phases is as it was: as its run in the executable meaning
//! shows, or as the phases follow each other, with numbers or by closed forms.

use std::cell::Cell;
use std::collections::BTreeSet;

use crate::lasso::Lasso;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{Next, Period};
use crate::recurrence::Closed;
use crate::term::Term;
use crate::value::{Relation, Value};
use crate::verify::influence::reduced;
use crate::verify::trajectory::{Leg, Rounds, Trajectory, walk};
use crate::verify::{Unit, may_be_zero};

/// The longest system, in operators, that is run for its round.
const MOST_TERM: usize = 1_000;
/// How often it is looked whether to go on, while legs are followed by closed forms.
const MOST_LOOKS: usize = 150;

/// Assumptions that a value is not less than another of which either case is looked at.
const MOST_CASES: usize = 3;

/// Where a system comes to.
pub(super) struct Known {
    /// Where, and in what time.
    pub(super) course: Course,
    /// Whether the values beside it are asked for, and go on so that the same ways are taken.
    pub(super) moving: bool,
}

/// Where a system comes to, if it is gone through several phases, or one in several ways.
///
/// # Errors
/// Why that is not known; nothing where something is drawn, so that there is no such time.
pub(super) fn course_of(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Known>, Option<String>> {
    let found = course_as_assumed(period, system, environment, interrupted);
    found.or_else(|why| in_either_case(period, system, environment, interrupted).map(Some).ok_or(why))
}

/// The same where a value is only known not to be less than another: where it is more and where it is equal, if it all takes
/// the same time in either case.
fn in_either_case(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<Known> {
    may_be_zero(&environment.assumptions).into_iter().take(MOST_CASES).find_map(|value| {
        let [more, equal] = [Relation::Gtr, Relation::Eq].map(|relation| {
            let mut environment = environment.clone();
            environment.assumptions.assume(relation, &value, &Value::zero());
            let found = course_as_assumed(period, system, &environment, interrupted).ok().flatten();
            found.map(|found| (found, environment.assumptions))
        });
        let ((more, _), (equal, known)) = (more?, equal?);
        let same = |one: &Value, other: &Value| known.decide(Relation::Eq, one, other) == Some(true);
        let (Course::Repeats { lasting, from, beside }, Course::Repeats { lasting: other, from: since, beside: also }) =
            (&more.course, &equal.course)
        else {
            return None;
        };
        // All that is beside in one of the cases may be another each time.
        let beside = beside.union(also).cloned().collect();
        let course = Course::Repeats { lasting: lasting.clone(), from: from.clone(), beside };
        let moving = more.moving || equal.moving;
        (same(lasting, other) && same(from, since)).then_some(Known { course, moving })
    })
}

fn course_as_assumed(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Known>, Option<String>> {
    let ways = period.phases.iter().map(|phase| phase.edges.len());
    if period.lasting().is_some() || ways.sum::<usize>() < 2 {
        return Ok(None);
    }
    let term = system.term(&environment.definitions);
    let run = (term.size() <= MOST_TERM).then(|| Lasso::of(&term, &environment.definitions, interrupted).round());
    let phases = period.course(&environment.assumptions, interrupted);
    let Some((lasting, from)) = run.flatten() else {
        let whole = |course| Ok(Known { course, moving: false });
        return phases.map_or_else(|| by_legs(period, environment, interrupted), whole).map(Some);
    };
    let (lasting, from) = (Value::rational(lasting), Value::rational(from));
    let course = match phases {
        // What was read last and is read by nobody again does not make one state another.
        Some(Course::Repeats { lasting: same, from: earlier, beside })
            if same == lasting && beside.is_empty() && earlier.as_rational() < from.as_rational() =>
        {
            Course::Repeats { lasting, from: earlier, beside }
        }
        _ => Course::Repeats { lasting, from, beside: BTreeSet::new() },
    };
    Ok(Some(Known { course, moving: false }))
}

/// By the closed forms of leg after leg: a leg that goes on for ever, or legs that come again and take the same times.
fn by_legs(
    period: &Period,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Known, Option<String>> {
    let mut edges = period.initial.iter().chain(period.phases.iter().flat_map(|phase| &phase.edges));
    if edges.any(|edge| !edge.draws.is_empty()) {
        return Err(None);
    }
    let nothing = Term::par([]);
    let looks = Cell::new(0usize);
    let enough = || {
        looks.set(looks.get() + 1);
        looks.get() > MOST_LOOKS || interrupted()
    };
    let steered = reduced(period, &nothing);
    let known = (&environment.definitions, &environment.assumptions);
    let run = walk(steered.as_ref().unwrap_or(period), known, &nothing, &enough);
    if looks.get() > MOST_LOOKS {
        return Err(Some(match run.legs.len() {
            0 => unfinished(period),
            legs => format!("it was followed through {legs} legs, and has not come again"),
        }));
    }
    let declared = |value: &Value| value.variables().iter().all(|name| environment.quantity(name).is_some());
    // What a closed form rests on must be known: nothing is said of the other cases.
    let known = |leg: &Leg| leg.conditions.iter().all(|test| test.decide(&environment.assumptions) == Some(true));
    let found = again(&run, period).filter(|_| run.legs.iter().all(known));
    let found = found.filter(|course| match course {
        Course::Repeats { lasting, from, .. } => declared(lasting) && declared(from),
        Course::Ends(_, after) => declared(after),
    });
    found.map(|course| Known { course, moving: true }).ok_or_else(|| run.open.first().cloned())
}

/// That the first leg was not followed to an end: where, and in how many ways it goes on there.
fn unfinished(period: &Period) -> String {
    let first = period.initial.iter().find_map(|edge| match edge.next {
        Next::Phase(number) => Some(number),
        Next::End(_) => None,
    });
    let back = |number: usize| period.phases.get(number).map_or(0, |phase| phase.rounds(number).count());
    let place = match first.map(|number| (number + 1, back(number))) {
        None => "at its start".to_string(),
        Some((number, ways @ 2..)) => format!("in phase {number}, which comes back to itself in {ways} ways,"),
        Some((number, _)) => format!("in phase {number}"),
    };
    format!("{place} its values were followed for a while, and neither came again nor led elsewhere")
}

/// From when on, and in what time, the legs come again; or when the run ends.
fn again(run: &Trajectory, period: &Period) -> Option<Course> {
    if let (Some(end), true) = (&run.end, run.open.is_empty()) {
        let legs = run.legs.iter().map(|leg| time_of(&leg.units));
        let after = legs.chain([time_of(&run.opening)]).try_fold(Value::zero(), |sum, time| sum.add(&time?).ok())?;
        return Some(Course::Ends(end.clone(), after));
    }
    let from = run.cycle.or_else(|| {
        let last = run.legs.len().checked_sub(1)?;
        matches!(run.legs[last].rounds, Rounds::Forever(_)).then_some(last)
    })?;
    let mut start = time_of(&run.opening)?;
    for leg in run.legs.get(..from)? {
        start = start.add(&time_of(&leg.units)?).ok()?;
    }
    let again = run.legs.get(from..)?;
    let mut lasting = Value::zero();
    for leg in again {
        lasting = lasting.add(&round_of(leg)?).ok()?;
    }
    // Of legs that come again exactly all their values do; of one that goes on for ever those that it does not change.
    let told: BTreeSet<Name> = match (run.cycle, &run.orbit, again) {
        (Some(_), None, legs) => legs.iter().flat_map(|leg| leg.start.keys().cloned()).collect(),
        (None, _, [leg]) => {
            let moves =
                |form: &Closed| form.pieces.len() > 1 || form.pieces.iter().any(|one| one.form.mentions(&leg.index));
            let changes = |name: &Name| leg.closed.iter().any(|(changed, form)| changed == name && moves(form));
            leg.start.keys().filter(|name| !changes(name)).cloned().collect()
        }
        _ => BTreeSet::new(),
    };
    let phases = again.iter().filter_map(|leg| period.phases.get(leg.phase));
    let beside = phases.flat_map(|phase| &phase.variables).filter(|name| !told.contains(name)).cloned().collect();
    (!lasting.is_zero()).then_some(Course::Repeats { lasting, from: start, beside })
}

/// How long a leg takes; of one that goes on for ever, a round of it.
fn round_of(leg: &Leg) -> Option<Value> {
    match (&leg.rounds, leg.units.as_slice()) {
        (Rounds::Forever(_), [Unit::Repeat { count: None, .. }]) => time_of(&leg.units),
        (Rounds::Forever(_), _) => None,
        (Rounds::Count(_), units) => time_of(units),
    }
}

/// How long it all takes, where each round takes the same; of what goes on for ever, one round.
fn time_of(units: &[Unit]) -> Option<Value> {
    let mut sum = Value::zero();
    for unit in units {
        let (count, segments) = match unit {
            Unit::Single(segment) => (Value::one(), std::slice::from_ref(segment)),
            Unit::Repeat { count, index, segments } => {
                if segments.iter().any(|segment| segment.duration.mentions(index)) {
                    return None;
                }
                (count.clone().unwrap_or_else(Value::one), segments.as_slice())
            }
        };
        for segment in segments {
            sum = sum.add(&count.mul(&segment.duration).ok()?).ok()?;
        }
    }
    Some(sum)
}
