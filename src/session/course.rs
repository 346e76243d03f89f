//! How long it takes until a system that goes through several phases is as it was: as its run in the executable meaning
//! shows, or as the phases follow each other, with numbers or by closed forms.

mod equalities;
mod in_cases;
mod supposing;

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use super::phases::whole;
use crate::assumption::Assumptions;
use crate::closed_form::Comparison;
use crate::lasso::Lasso;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{Next, Period, Test};
use crate::recurrence::{Closed, InCase, solve_together};
use crate::term::Term;
use crate::value::{Relation, Value};
use crate::verify::influence::reduced;
use crate::verify::trajectory::{Leg, Rounds, Trajectory, walk};
use crate::verify::{Merge, Unit, may_be_zero, total};
use equalities::{by_equalities, with_equals};
use in_cases::{Found, in_all, in_cases};
use supposing::{Supposed, supposing};

/// The longest system, in operators, that is run for its round.
const MOST_TERM: usize = 1_000;
/// How often it is looked whether to go on, while legs are followed by closed forms.
const MOST_LOOKS: usize = 150;

/// Rounds of a leg without end after which their times may come again.
const MOST_ROUNDS: i64 = 64;

/// Values of which it is not known whether they are 0 and of which either case is looked at.
const MOST_CASES: usize = 3;
/// Cases that are looked at inside one another.
const MOST_SPLITS: usize = 2;

/// Where a system comes to.
pub(crate) struct Known {
    /// Where, and in what time.
    pub(crate) course: Course,
    /// Whether the values beside it are asked for, and go on so that the same ways are taken.
    pub(super) moving: bool,
}

impl Known {
    /// How long it all takes, or when and how it ends.
    pub(crate) fn line(&self) -> String {
        whole(&self.course, self.moving)
    }
}

/// Why it is not known where a system comes to.
#[derive(Default)]
pub(crate) struct Unsettled {
    /// In words; nothing where something is drawn, so that there is no such time.
    pub(super) reason: Option<String>,
    /// What is not decided.
    asked: Vec<Comparison>,
    /// Where it comes to in each case of that, where it is known in some.
    pub(super) cases: Vec<InCase<Found>>,
    /// Where it would come to if each phase ended.
    supposed: Option<Box<Supposed>>,
}

impl Unsettled {
    fn because(reason: String) -> Unsettled {
        Unsettled { reason: Some(reason), ..Unsettled::default() }
    }

    /// How long it lasts in each case, with what is known there, if it repeats in all.
    pub(super) fn lasting(&self) -> Option<Vec<(&Value, &Assumptions)>> {
        let lasting = self.cases.iter().map(|case| match &case.found.as_ref().ok()?.course {
            Course::Repeats { lasting, .. } => Some((lasting, &case.known)),
            Course::Ends(..) => None,
        });
        lasting.collect::<Option<Vec<_>>>().filter(|cases| !cases.is_empty())
    }

    /// What is said of it.
    pub(super) fn lines(&self) -> Vec<String> {
        let unknown = "whether it all repeats is not known";
        let open = |reason: &String| format!("{unknown}: {reason}");
        if let Some(supposed) = &self.supposed {
            return supposed.lines(unknown);
        }
        if self.cases.is_empty() {
            return self.reason.iter().map(open).collect();
        }
        let line = |case: &InCase<Found>| {
            let told = match &case.found {
                Ok(known) => known.line(),
                Err(reason) => reason.as_ref().map_or_else(|| unknown.to_string(), open),
            };
            format!("if {}: {told}", case.title())
        };
        self.cases.iter().map(line).collect()
    }
}

/// Where a system comes to, if it is gone through several phases, or one in several ways.
///
/// # Errors
/// Why that is not known.
pub(crate) fn course_of(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Known>, Unsettled> {
    within_cases(period, system, environment, MOST_SPLITS, interrupted).or_else(|why| {
        // Of a speed that is cut off there would be a case for each side of each bound.
        let mut cases = by_equalities(period, system, environment, interrupted);
        if cases.is_empty() {
            cases = in_cases((period, system, environment), &why, interrupted);
        }
        in_all(&cases).map(Some).ok_or_else(|| {
            // Where it is known in each case that is told.
            let open = cases.is_empty() || cases.iter().any(|case| case.found.is_err());
            let supposed = open.then(|| supposing(period, environment, interrupted)).flatten().map(Box::new);
            Unsettled { cases, supposed, ..why }
        })
    })
}

/// The same, where it takes the same time in either case of what is not known, at most so many cases inside one another.
fn within_cases(
    period: &Period,
    system: &System,
    environment: &Environment,
    splits: usize,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Known>, Unsettled> {
    let found = course_as_assumed(period, system, environment, interrupted);
    if splits == 0 || interrupted() {
        return found;
    }
    let either = || {
        let open = may_be_zero(&environment.assumptions).into_iter().chain(may_be_equal(period, environment));
        open.take(MOST_CASES)
            .find_map(|value| in_either_case(period, system, environment, (&value, splits), interrupted))
    };
    let on_each_side = || {
        let open = of_unknown_sign(&environment.assumptions);
        open.into_iter()
            .take(MOST_CASES)
            .find_map(|value| on_either_side(period, system, environment, (&value, splits), interrupted))
    };
    // What is assumed to differ matters more often than what may be equal.
    found.or_else(|why| on_each_side().or_else(either).map(Some).ok_or(why))
}

/// Where a value stands so to 0, with what is assumed then.
fn in_case(
    period: &Period,
    system: &System,
    environment: &Environment,
    (relation, value, splits): (Relation, &Value, usize),
    interrupted: &dyn Fn() -> bool,
) -> Option<(Known, Assumptions)> {
    let mut environment = environment.clone();
    // Of a vector, to one that is 0.
    environment.assumptions.assume(relation, value, &value.sub(value).ok()?);
    let found = within_cases(period, system, &environment, splits - 1, interrupted).ok().flatten()?;
    Some((found, environment.assumptions))
}

/// Where a value is 0 and where it is not, if it all takes the same time in either case.
fn in_either_case(
    period: &Period,
    system: &System,
    environment: &Environment,
    (value, splits): (&Value, usize),
    interrupted: &dyn Fn() -> bool,
) -> Option<Known> {
    let case = |relation| in_case(period, system, environment, (relation, value, splits), interrupted);
    let never_less = environment.assumptions.decide(Relation::Gte, value, &Value::zero()) == Some(true);
    let other = if never_less { Relation::Gtr } else { Relation::Neq };
    let ((more, apart), (equal, known)) = (case(other)?, case(Relation::Eq)?);
    let (Course::Repeats { lasting, from, beside }, Course::Repeats { lasting: other, from: since, beside: also }) =
        (&more.course, &equal.course)
    else {
        return None;
    };
    if known.decide(Relation::Eq, lasting, other) != Some(true) || !known.gives_meaning(lasting) {
        return None;
    }
    // What is so from some time on is so from any later time on.
    let in_both = |time: &&Value| {
        let later = |known: &Assumptions, own: &Value| known.decide(Relation::Gte, time, own) == Some(true);
        later(&apart, from) && later(&known, since)
    };
    let from = [from, since].into_iter().find(in_both)?.clone();
    // All that is beside in one of the cases may be another each time.
    let beside = beside.union(also).cloned().collect();
    let course = Course::Repeats { lasting: lasting.clone(), from, beside };
    Some(Known { course, moving: more.moving || equal.moving })
}

/// Where a value that is not 0 is more and where it is less, with the times of both written as one.
fn on_either_side(
    period: &Period,
    system: &System,
    environment: &Environment,
    (value, splits): (&Value, usize),
    interrupted: &dyn Fn() -> bool,
) -> Option<Known> {
    let case = |relation| in_case(period, system, environment, (relation, value, splits), interrupted);
    let ((more, above), (less, below)) = (case(Relation::Gtr)?, case(Relation::Lss)?);
    let merge = Merge { difference: value.clone(), above, below };
    let known = &environment.assumptions;
    let merged = |one: &Value, other: &Value| merge.values(&with_equals(one, known), &with_equals(other, known));
    let course = match (&more.course, &less.course) {
        (Course::Repeats { lasting, from, beside }, Course::Repeats { lasting: other, from: since, beside: also }) => {
            let beside = beside.union(also).cloned().collect();
            Course::Repeats { lasting: merged(lasting, other)?, from: merged(from, since)?, beside }
        }
        (Course::Ends(end, after), Course::Ends(same, other)) if end == same => {
            Course::Ends(end.clone(), merged(after, other)?)
        }
        _ => return None,
    };
    Some(Known { course, moving: more.moving || less.moving })
}

/// What is assumed not to be 0, and may be more and may be less.
fn of_unknown_sign(known: &Assumptions) -> Vec<Value> {
    let apart = known.iter().filter(|(relation, _)| *relation == Relation::Neq).map(|(_, value)| value);
    apart.filter(|value| known.decide(Relation::Gtr, value, &Value::zero()).is_none()).collect()
}

/// Differences of parameters of which a way from the start, or the first way on from there, asks whether they are 0.
fn may_be_equal(period: &Period, environment: &Environment) -> Vec<Value> {
    let mut tests: Vec<Test> = period.initial.iter().flat_map(|edge| edge.tests.iter().cloned()).collect();
    for edge in &period.initial {
        let Next::Phase(next) = edge.next else { continue };
        let ways = period.phases.get(next).into_iter().flat_map(|phase| &phase.edges);
        tests.extend(ways.flat_map(|way| &way.tests).filter_map(|test| test.substitute(&edge.map).ok()));
    }
    let declared = |name: &Name| environment.quantity(name).is_some();
    let mut found: Vec<Value> = Vec::new();
    for Test { relation, left, right } in tests {
        let Ok(difference) = left.sub(&right) else { continue };
        let asks = matches!(relation, Relation::Eq | Relation::Neq) && difference.variables().iter().all(declared);
        let open = || environment.assumptions.decide(Relation::Eq, &left, &right).is_none();
        if asks && !found.contains(&difference) && open() {
            found.push(difference);
        }
    }
    found
}

fn course_as_assumed(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<Known>, Unsettled> {
    let ways = period.phases.iter().map(|phase| phase.edges.len()).sum::<usize>();
    let first = period.initial.len().saturating_sub(1);
    if period.lasting().is_some() || ways + first < 2 {
        return Ok(None);
    }
    let term = system.term(&environment.definitions);
    let run = (term.size() <= MOST_TERM).then(|| Lasso::of(&term, &environment.definitions, interrupted).round());
    let phases = period.course(&environment.assumptions, interrupted);
    let Some((lasting, from)) = run.flatten() else {
        let whole = |course| Ok(Known { course, moving: false });
        if phases.is_none()
            && let Some(course) = period.congruent(&environment.assumptions, interrupted)
        {
            return Ok(Some(Known { course, moving: true }));
        }
        return phases.map_or_else(|| by_legs(period, environment, interrupted), whole).map(Some).or_else(|why| {
            // Where something is drawn there is no such time.
            let onward = why.reason.as_ref().and_then(|_| period.onward(&environment.assumptions, interrupted));
            onward.map(|course| Some(Known { course, moving: true })).ok_or(why)
        });
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
fn by_legs(period: &Period, environment: &Environment, interrupted: &dyn Fn() -> bool) -> Result<Known, Unsettled> {
    let mut edges = period.ways();
    if edges.any(|edge| !edge.draws.is_empty()) {
        return Err(Unsettled::default());
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
        return Err(Unsettled::because(match run.legs.len() {
            0 => unfinished(period),
            1 => "it was followed through one leg, and has not come again".to_string(),
            legs => format!("it was followed through {legs} legs, and has not come again"),
        }));
    }
    let declared = |value: &Value| value.variables().iter().all(|name| environment.quantity(name).is_some());
    // What a closed form rests on must be known: nothing is said of the other cases.
    let open = |test: &&Test| test.decide(&environment.assumptions) != Some(true);
    let rests: Vec<Comparison> = run
        .legs
        .iter()
        .flat_map(|leg| &leg.conditions)
        .filter(open)
        .map(|test| (test.relation, test.left.clone(), test.right.clone()))
        .collect();
    let found = again(&run, period, &environment.assumptions).filter(|_| rests.is_empty());
    let found = found.filter(|course| match course {
        Course::Repeats { lasting, from, .. } => declared(lasting) && declared(from),
        Course::Ends(_, after) => declared(after),
    });
    let unsettled = || {
        let rests_on = |(relation, left, right): &Comparison| format!("whether {left} {} {right}", relation.symbol());
        let reason = run.open.first().cloned().or_else(|| rests.first().map(rests_on));
        let reason =
            reason.unwrap_or_else(|| "no form was found of the time that its rounds take together".to_string());
        let reason = Some(if reason.starts_with("whether ") { format!("it must be known {reason}") } else { reason });
        Unsettled { reason, asked: run.asked.iter().chain(&rests).cloned().collect(), ..Unsettled::default() }
    };
    found.map(|course| Known { course, moving: true }).ok_or_else(unsettled)
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
fn again(run: &Trajectory, period: &Period, known: &Assumptions) -> Option<Course> {
    if let (Some(end), true) = (&run.end, run.open.is_empty()) {
        let legs = run.legs.iter().map(|leg| time_of(&leg.units, known));
        let after =
            legs.chain([time_of(&run.opening, known)]).try_fold(Value::zero(), |sum, time| sum.add(&time?).ok())?;
        return Some(Course::Ends(end.clone(), after));
    }
    let from = run.cycle.or_else(|| {
        let last = run.legs.len().checked_sub(1)?;
        matches!(run.legs[last].rounds, Rounds::Forever(_)).then_some(last)
    })?;
    let mut start = time_of(&run.opening, known)?;
    for leg in run.legs.get(..from)? {
        start = start.add(&time_of(&leg.units, known)?).ok()?;
    }
    let again = run.legs.get(from..)?;
    let mut lasting = Value::zero();
    for leg in again {
        lasting = lasting.add(&round_of(leg, known)?).ok()?;
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
    let (lasting, start) = (known.simplify(&lasting), known.simplify(&start));
    (!lasting.is_zero()).then_some(Course::Repeats { lasting, from: start, beside })
}

/// How long a leg takes; of one that goes on for ever, a round of it.
fn round_of(leg: &Leg, known: &Assumptions) -> Option<Value> {
    match (&leg.rounds, leg.units.as_slice()) {
        (Rounds::Forever(_), [Unit::Repeat { count: None, index, segments }]) => {
            let round = total(segments).ok()?;
            if round.mentions(index) { until_it_comes_round(&round, index) } else { Some(round) }
        }
        (Rounds::Forever(_), _) => None,
        (Rounds::Count(_), units) => time_of(units, known),
    }
}

/// How long it all takes; of what goes on for ever, one round, if each takes the same.
fn time_of(units: &[Unit], known: &Assumptions) -> Option<Value> {
    let mut sum = Value::zero();
    for unit in units {
        let time = match unit {
            Unit::Single(segment) => segment.duration.clone(),
            Unit::Repeat { count, index, segments } => {
                let round = total(segments).ok()?;
                match count {
                    Some(count) if round.mentions(index) => summed(&round, index, count, known)?,
                    _ if round.mentions(index) => return None,
                    Some(count) => count.mul(&round).ok()?,
                    None => round,
                }
            }
        };
        sum = sum.add(&time).ok()?;
    }
    Some(sum)
}

/// The sum of a form over the least number of indices after which it is what it was, whatever the index.
fn until_it_comes_round(form: &Value, index: &Name) -> Option<Value> {
    let at = |by: &Value| form.with(index, by).ok();
    let later = |by: i64| Value::variable(index).add(&Value::integer(by)).ok();
    let rounds = (1..=MOST_ROUNDS).find(|rounds| later(*rounds).and_then(|later| at(&later)).as_ref() == Some(form))?;
    (0..rounds).try_fold(Value::zero(), |sum, round| sum.add(&at(&Value::integer(round))?).ok())
}

/// The sum of a form over so many indices from 0 on, where it has a closed form that was checked.
fn summed(form: &Value, index: &Name, count: &Value, known: &Assumptions) -> Option<Value> {
    let sum = Name::new("[sum]");
    let next = BTreeMap::from([(sum.clone(), Value::variable(&sum).add(form).ok()?)]);
    let start = BTreeMap::from([(sum.clone(), Value::zero())]);
    let found = solve_together(&next, &start, index, known, &|| false).ok()?;
    match found.as_slice() {
        [(_, closed)] if closed.conditions.is_empty() => closed.at(index, count, known).map(|sum| known.simplify(&sum)),
        _ => None,
    }
}
