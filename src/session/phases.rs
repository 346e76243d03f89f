//! `period Sys`: the components' periods, what repeats, and the phase graph.

use super::course::course_of;
use super::digits::rational;
use super::reading::{Run, Waiting};
use super::rounds::checked;
use super::satisfies::components;
use crate::definition::Definitions;
use crate::flow::flows;
use crate::lower::Expectation;
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{self, Failure, Period, graph, in_case};
use crate::report::Expected;
use crate::value::{Relation, Value};

impl Run<'_, '_> {
    /// The answer, and what came of the expectations: `yes` or `no` (does it repeat?), `lasting = 2*t`, `phases = 3`.
    pub(super) fn period(&mut self, system: &Name, waiting: &Waiting) -> (Vec<String>, Vec<Expected>) {
        let environment = &waiting.environment;
        let Some(found) = environment.system(system) else {
            return (vec![format!("there is no system {system}")], Run::unmet(&waiting.expected));
        };
        let interrupted = || self.surroundings.interrupted();
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        let period = period::analyse_until(&found.components, definitions, assumptions, &interrupted);
        let (course, unknown) = match period.as_ref().map(|period| course_of(period, found, environment, &interrupted))
        {
            Ok(Err(unknown)) => (None, unknown),
            Ok(Ok(course)) => (course, None),
            Err(_) => (None, None),
        };
        let lines = match &period {
            Ok(period) => {
                let mut lines = components(found, environment);
                let rounds = period.repetitions(definitions, assumptions, &interrupted);
                lines.extend(told(period, course.as_ref(), rounds, definitions));
                lines.extend(course.iter().map(whole));
                lines.extend(unknown.map(|reason| format!("whether it all repeats is not known: {reason}")));
                lines.extend(checked(period, found, environment, &|| self.surroundings.interrupted()));
                lines
            }
            Err(failures) => failures.iter().map(ToString::to_string).collect(),
        };
        let expected = waiting.expected.iter().map(|(expectation, text)| {
            let met = is_met(expectation, (&period, course.as_ref()), waiting);
            Expected { text: text.clone(), met }
        });
        (lines, expected.collect())
    }
}

fn told(
    period: &Period,
    course: Option<&Course>,
    rounds: Option<Vec<(String, u64)>>,
    definitions: &Definitions,
) -> Vec<String> {
    let mut lines = Vec::new();
    for flow in flows(period, definitions) {
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

fn whole(course: &Course) -> String {
    let time = |time: &Value| time.as_rational().map_or_else(|| time.to_string(), |number| rational(&number));
    match course {
        Course::Repeats { lasting, from, beside } => {
            let from = if *from == Value::zero() { String::new() } else { format!(" from {} on", time(from)) };
            let names: Vec<&str> = beside.iter().map(Name::as_str).collect();
            let beside = match names.as_slice() {
                [] => String::new(),
                [name] => format!(", whatever {name} is then"),
                names => format!(", whatever {} are then", names.join(", ")),
            };
            format!("lasting: {} in all, as the system runs{from}{beside}", time(lasting))
        }
        Course::Ends(end, after) => format!("after {} in all: {}", time(after), graph::ending(end)),
    }
}

fn is_met(
    expectation: &Expectation,
    (period, course): (&Result<Period, Vec<Failure>>, Option<&Course>),
    waiting: &Waiting,
) -> bool {
    let repeats = period.as_ref().is_ok_and(|period| period.comes_again(course));
    let round = course.and_then(|course| match course {
        Course::Repeats { lasting, .. } => Some(lasting.clone()),
        Course::Ends(..) => None,
    });
    let is = |found: Option<Value>, wanted: &Value| {
        let decide = |found: &Value| waiting.environment.assumptions.decide(Relation::Eq, found, wanted);
        found.is_some_and(|found| decide(&found) == Some(true))
    };
    match expectation {
        Expectation::Answer(word) => {
            let open = period.as_ref().is_err_and(|failures| failures.iter().all(Failure::is_open));
            let answer = match (repeats, open) {
                (true, _) => "yes",
                (false, true) => "unknown",
                (false, false) => "no",
            };
            word.as_str() == answer
        }
        Expectation::Values(values) => values.iter().all(|(name, wanted)| match (name.as_str(), period) {
            ("lasting", Ok(period)) => is(period.lasting().or_else(|| round.clone()), wanted),
            ("phases", Ok(period)) => is(i64::try_from(period.phases.len()).ok().map(Value::integer), wanted),
            _ => false,
        }),
        _ => false,
    }
}
