//! `period Sys`: the components' periods, what repeats, and the phase graph.

use std::cell::LazyCell;

use super::abreast::each;
use super::beside::BESIDE;
use super::course::{Known, Unsettled, course_of};
use super::delays::{self, Order, in_orders};
use super::digits::rational;
use super::parts::{Part, Together, headline, parted, parted_after, steady, together};
use super::reading::{Run, Waiting};
use super::rounds::checked;
use super::satisfies::components;
use crate::assumption::Assumptions;
use crate::flow::flows;
use crate::lower::{Environment, Expectation, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{self, Failure, InTheEnd, Period, graph, in_case};
use crate::report::Expected;
use crate::value::{Relation, Value};
use crate::verify::equal;

/// The answer where it is not known whether a period comes again.
const UNKNOWN: &str = "unknown";

/// What is taken on trust where not each order of delays is followed to its end.
const GREATEST_CYCLE: &str =
    "that loops which only wait for each other go round in the end in the time of their greatest cycle";

/// What is said where the time in the end is that of several rounds in some order.
const FEWER: &str = "in some order fewer rounds come again, as is told there";

/// What is said of a period.
struct Told {
    lines: Vec<String>,
    /// Whether it comes again: `yes`, `no` or `unknown`.
    answer: &'static str,
    /// Which of the expectations are of values that it has.
    met: Vec<bool>,
    /// How long it lasts, where that is one value.
    lasting: Option<Value>,
    /// Whether that was found in each order of delays.
    in_orders: bool,
    /// How long it lasts in each order, with what is known there, but for those in which two delays are equal.
    apart: Vec<(Value, Environment)>,
}

impl Told {
    /// Whether it is told in some order of delays, and not in all, or in none; what has no period has none in the end.
    fn open(&self) -> bool {
        self.answer == UNKNOWN || self.answer == "yes" && self.in_orders && self.lasting.is_none()
    }

    /// Whether it lasts otherwise in some order: what it takes in the end may be several rounds there.
    fn lasts_otherwise(&self, time: &Value) -> bool {
        let other = |(own, environment): &(Value, Environment)| {
            environment.assumptions.decide(Relation::Eq, own, time) == Some(false)
        };
        self.apart.iter().any(other)
    }
}

/// How long a round of a system takes in the end, of loops that only wait for each other.
fn in_the_end(system: &System, environment: &Environment) -> Option<InTheEnd> {
    period::greatest_cycle(&system.components, &environment.definitions, &environment.assumptions)
}

impl Run<'_, '_> {
    /// The answer, and what came of the expectations: `yes` or `no` (does it repeat?), `lasting = 2*t`, `phases = 3`.
    pub(super) fn period(&mut self, system: &Name, waiting: &Waiting) -> (Vec<String>, Vec<Expected>) {
        let environment = &waiting.environment;
        let Some(found) = environment.system(system) else {
            return (vec![format!("there is no system {system}")], Run::unmet(&waiting.expected));
        };
        self.period_of(found, environment, &waiting.expected)
    }

    /// The same of a system, and of what is expected with its text.
    pub(super) fn period_of(
        &mut self,
        found: &System,
        environment: &Environment,
        expected: &[(Expectation, String)],
    ) -> (Vec<String>, Vec<Expected>) {
        let wanted: Vec<&Expectation> = expected.iter().map(|(expectation, _)| expectation).collect();
        let (told, in_the_end) = told_in_all(found, environment, &wanted, &|| self.surroundings.interrupted());
        let of_the_end = |expectation: &Expectation| {
            let found = in_the_end.as_ref().filter(|_| is_of_time(expectation));
            found.is_some_and(|found| has_time(expectation, &found.time, &environment.assumptions))
        };
        let met = |expectation: &Expectation, own: bool| match expectation {
            Expectation::Answer(word) => word.as_str() == told.answer,
            _ => own || of_the_end(expectation),
        };
        let all = expected.iter().zip(&told.met);
        let expected = all
            .map(|((expectation, text), own)| Expected { text: text.clone(), met: met(expectation, *own) })
            .collect();
        (told.lines, expected)
    }
}

/// What is said of the period of a system, and whether it is known to come again.
pub(crate) fn period_lines(
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> (Vec<String>, bool) {
    let (told, _) = told_in_all(system, environment, &[], interrupted);
    (told.lines, told.answer == "yes")
}

/// What is said of a system in each order of its delays and of all of them, and what it takes in the end, where that is said.
fn told_in_all(
    system: &System,
    environment: &Environment,
    wanted: &[&Expectation],
    interrupted: &dyn Fn() -> bool,
) -> (Told, Option<InTheEnd>) {
    let end = LazyCell::new(|| in_the_end(system, environment));
    let most = delays::orders_beside(system, environment, || end.is_some());
    let mut told = told_of(system, environment, wanted, most, interrupted);
    let whole = told.lasting.iter().filter(|_| told.in_orders);
    told.lines.extend(whole.map(|time| format!("in every order, lasting: {time}")));
    let in_the_end = if told.open() { end.clone() } else { None };
    if let Some(InTheEnd { time, rounds }) = &in_the_end {
        told.answer = "yes";
        told.lines.push(format!("in every order it goes round in the end, lasting: {time}"));
        let rounds: Vec<String> = rounds.iter().map(|(name, times)| format!("{name} {times}")).collect();
        told.lines.push(format!("  rounds: {}", rounds.join(", ")));
        if told.lasts_otherwise(time) {
            told.lines.push(format!("  {FEWER}"));
        }
        told.lines.push(format!("on trust: {GREATEST_CYCLE}"));
    }
    (told, in_the_end)
}

/// What is said of a system, where it is not known which of two delays ends first in each order; `most`: so many times.
fn told_of(
    system: &System,
    environment: &Environment,
    wanted: &[&Expectation],
    most: usize,
    interrupted: &dyn Fn() -> bool,
) -> Told {
    if let Some((parts, ways)) = parted(system, environment, interrupted) {
        return by_parts(&parts, ways, environment, wanted, interrupted);
    }
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let period = period::analyse_until(&system.components, definitions, assumptions, interrupted);
    let (lines, course) = match &period {
        Ok(period) => told_whole(period, system, environment, interrupted),
        Err(failures) => {
            let each = |order: &Order| told_of(system, &order.environment, wanted, most - 1, interrupted);
            let (orders, cases) = in_orders(failures, environment, most, each);
            if cases.iter().any(|case| case.answer != UNKNOWN) {
                return in_each(&orders, cases);
            }
            if let Some((parts, ways)) = parted_after(failures, system, environment, interrupted) {
                return by_parts(&parts, ways, environment, wanted, interrupted);
            }
            (failures.iter().map(ToString::to_string).collect(), Ok(None))
        }
    };
    let in_cases = course.as_ref().err().and_then(Unsettled::lasting);
    let course = course.as_ref().ok().and_then(|known| known.as_ref()).map(|known| &known.course);
    let met = wanted.iter().map(|wanted| match &in_cases {
        Some(cases) if is_of_time(wanted) => cases.iter().all(|(time, known)| has_time(wanted, time, known)),
        _ => is_met(wanted, (&period, course), environment),
    });
    let answer = if in_cases.is_some() { "yes" } else { answer(&period, course) };
    let own = period.as_ref().ok().and_then(Period::lasting);
    let lasting = own.or_else(|| match course {
        Some(Course::Repeats { lasting, .. }) => Some(lasting.clone()),
        _ => None,
    });
    Told { met: met.collect(), lines, answer, lasting, in_orders: false, apart: Vec::new() }
}

/// Whether it is expected how long it lasts, and nothing else.
fn is_of_time(expectation: &Expectation) -> bool {
    matches!(expectation, Expectation::Values(values) if values.iter().all(|(name, _)| name.as_str() == "lasting"))
}

/// Whether what was found is what is expected, with the integer parts of either.
fn same(found: &Value, wanted: &Value, known: &Assumptions) -> bool {
    equal(found, wanted, known) || equal(wanted, found, known)
}

/// Whether it lasts as long as is expected.
fn has_time(expectation: &Expectation, time: &Value, known: &Assumptions) -> bool {
    let Expectation::Values(values) = expectation else { return false };
    values.iter().all(|(_, wanted)| known.gives_meaning(wanted) && equal(time, wanted, known))
}

/// What is said in each order, and what holds in all.
fn in_each(orders: &[Order], cases: Vec<Told>) -> Told {
    let answer = cases.first().map_or(UNKNOWN, |case| case.answer);
    let answer = if cases.iter().all(|case| case.answer == answer) { answer } else { UNKNOWN };
    let count = cases.first().map_or(0, |case| case.met.len());
    let met = (0..count).map(|place| cases.iter().all(|case| case.met.get(place) == Some(&true))).collect();
    let known = orders.iter().zip(&cases).map(|(order, case)| Some((case.lasting.as_ref()?, &order.environment)));
    let lasting = known.collect::<Option<Vec<_>>>().and_then(|cases| as_one(&cases));
    let different = orders.iter().zip(&cases).filter(|(order, _)| !order.title.contains(" = "));
    let apart = different.flat_map(|(order, case)| {
        let own = case.lasting.clone().map(|time| (time, order.environment.clone()));
        if case.in_orders { case.apart.clone() } else { own.into_iter().collect() }
    });
    let apart = apart.collect();
    let lines = orders.iter().zip(cases).flat_map(|(order, case)| delays::told(&order.title, case.lines)).collect();
    Told { lines, answer, met, lasting, in_orders: true, apart }
}

/// The greatest of some of these times, if it is the time of each case.
fn as_one(cases: &[(&Value, &Environment)]) -> Option<Value> {
    let mut times: Vec<&Value> = cases.iter().map(|(time, _)| *time).collect();
    times.sort();
    times.dedup();
    let in_each = |time: &Value| {
        let same = |(own, environment): &(&Value, &Environment)| {
            environment.assumptions.decide(Relation::Eq, own, time) == Some(true)
        };
        cases.iter().all(same)
    };
    let without = |left_out: Option<usize>| {
        let kept = times.iter().enumerate().filter(|(place, _)| Some(*place) != left_out);
        Value::maximum(&kept.map(|(_, time)| (*time).clone()).collect::<Vec<_>>()).ok().filter(&in_each)
    };
    // What is written otherwise where two delays are equal is none of its own.
    (times.len() > 1)
        .then(|| (0..times.len()).find_map(|place| without(Some(place))))
        .flatten()
        .or_else(|| without(None))
}

/// All that is said of a system with a period, and where it comes to.
fn told_whole(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> (Vec<String>, Result<Option<Known>, Unsettled>) {
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let found = course_of(period, system, environment, interrupted);
    let course = found.as_ref().ok().and_then(|known| known.as_ref());
    let mut lines = components(system, environment);
    let rounds = period.repetitions(definitions, assumptions, interrupted);
    lines.extend(told(period, course.map(|known| &known.course), rounds, environment));
    lines.extend(course.iter().map(|known| known.line()));
    lines.extend(found.as_ref().err().into_iter().flat_map(Unsettled::lines));
    lines.extend(checked(period, system, environment, interrupted));
    (lines, found)
}

/// The same of a system that falls into parts, part by part, with what they make together.
fn by_parts(
    parts: &[Part],
    ways: usize,
    environment: &Environment,
    wanted: &[&Expectation],
    interrupted: &dyn Fn() -> bool,
) -> Told {
    let mut lines = vec![headline(parts, ways)];
    let mut courses = Vec::new();
    let told = each(parts, interrupted, &|part, interrupted| {
        let (told, course) = told_whole(&part.period, &part.system, environment, interrupted);
        (told, course.ok().flatten().or_else(|| steady(part, environment, interrupted)))
    });
    for (number, (part, (told, course))) in parts.iter().zip(told).enumerate() {
        lines.push(format!("part {}: {}", number + 1, part.names()));
        lines.extend(told.into_iter().map(|line| format!("  {line}")));
        courses.push(course);
    }
    let all = together(parts, courses, environment);
    lines.extend(all.line());
    lines.push(format!("on trust: {BESIDE}"));
    let met = |wanted: &&Expectation| match (wanted, &all) {
        (Expectation::Values(values), Together::Again(Course::Repeats { lasting, .. }, _)) => {
            let same = |wanted| environment.assumptions.decide(Relation::Eq, lasting, wanted) == Some(true);
            values.iter().all(|(name, wanted)| name.as_str() == "lasting" && same(wanted))
        }
        _ => false,
    };
    let lasting = match &all {
        Together::Again(Course::Repeats { lasting, .. }, _) => Some(lasting.clone()),
        _ => None,
    };
    let met = wanted.iter().map(met).collect();
    Told { lines, answer: all.answer(), met, lasting, in_orders: false, apart: Vec::new() }
}

fn told(
    period: &Period,
    course: Option<&Course>,
    rounds: Option<Vec<(String, u64)>>,
    environment: &Environment,
) -> Vec<String> {
    let mut lines = Vec::new();
    for flow in flows(period, environment) {
        let periods = flow.periods().into_iter();
        lines.extend(
            periods.map(|(way, tests)| format!("phase {}: {}{}", flow.phase + 1, way.period_term(), in_case(tests))),
        );
    }
    if let Some(rounds) = rounds {
        let rates: Vec<String> = rounds.iter().map(|(name, count)| format!("{name} {count}")).collect();
        lines.push(format!("rounds: {}", rates.join(", ")));
    }
    if let Some(time) = period.lasting() {
        lines.push(format!("lasting: {time}"));
    }
    if period.phases.len() > 1 || period.phases.iter().any(|phase| phase.edges.len() > 1) {
        lines.push("phase graph:".to_string());
        lines.extend(graph::lines(period).into_iter().map(|line| format!("  {line}")));
    }
    lines.extend(graph::remarks(period, course));
    lines
}

/// How long it all takes; `moving` where what is beside is asked for as well, and goes on.
pub(crate) fn whole(course: &Course, moving: bool) -> String {
    let time = |time: &Value| time.as_rational().map_or_else(|| time.to_string(), |number| rational(&number));
    match course {
        Course::Repeats { lasting, from, beside } => {
            let from = if *from == Value::zero() { String::new() } else { format!(" from {} on", time(from)) };
            let names: Vec<&str> = beside.iter().map(Name::as_str).collect();
            let beside = match names.as_slice() {
                names @ [_, ..] if moving => format!(", while {} may go on", names.join(", ")),
                [] => String::new(),
                [name] => format!(", whatever {name} is then"),
                names => format!(", whatever {} are then", names.join(", ")),
            };
            format!("lasting: {} in all, as the system runs{from}{beside}", time(lasting))
        }
        Course::Ends(end, after) => format!("after {} in all: {}", time(after), graph::ending(end)),
    }
}

/// Whether a period comes again.
fn answer(period: &Result<Period, Vec<Failure>>, course: Option<&Course>) -> &'static str {
    let repeats = period.as_ref().is_ok_and(|period| period.comes_again(course));
    // That parts share no port, or nobody answers, is no reason: side by side they may have a period all the same.
    let reason = |failure: &&Failure| !matches!(failure, Failure::NoCommunication { .. } | Failure::Lonely(_));
    let open = match period {
        Ok(period) => period.repeats() && course.is_none(),
        Err(failures) => failures.iter().filter(reason).all(Failure::is_open),
    };
    match (repeats, open) {
        (true, _) => "yes",
        (false, true) => UNKNOWN,
        (false, false) => "no",
    }
}

/// Whether a period has the values that are expected of it.
fn is_met(
    expectation: &Expectation,
    (period, course): (&Result<Period, Vec<Failure>>, Option<&Course>),
    environment: &Environment,
) -> bool {
    let round = course.and_then(|course| match course {
        Course::Repeats { lasting, .. } => Some(lasting.clone()),
        Course::Ends(..) => None,
    });
    let is = |found: Option<Value>, wanted: &Value| {
        found.is_some_and(|found| same(&found, wanted, &environment.assumptions))
    };
    match expectation {
        Expectation::Values(values) => values.iter().all(|(name, wanted)| match (name.as_str(), period) {
            ("lasting", Ok(period)) => is(period.lasting().or_else(|| round.clone()), wanted),
            ("phases", Ok(period)) => is(i64::try_from(period.phases.len()).ok().map(Value::integer), wanted),
            _ => false,
        }),
        _ => false,
    }
}
