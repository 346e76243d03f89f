//! `period Sys`: the components' periods, what repeats, and the phase graph.

use num_rational::BigRational;
use num_traits::Zero;

use super::digits::rational;
use super::reading::{Run, Waiting};
use super::rounds::checked;
use super::satisfies::components;
use crate::definition::Definitions;
use crate::flow::flows;
use crate::lasso::Lasso;
use crate::lower::{Environment, Expectation, System};
use crate::name::Name;
use crate::period::{self, Failure, Period, graph, in_case};
use crate::report::Expected;
use crate::value::{Relation, Value};

/// The longest system, in operators, that is run for its round.
const MOST_TERM: usize = 1_000;

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
        let round = period.as_ref().ok().and_then(|period| run_of(period, found, environment, &interrupted));
        let lines = match &period {
            Ok(period) => {
                let mut lines = components(found, environment);
                let rounds = period.repetitions(definitions, assumptions, &interrupted);
                lines.extend(told(period, rounds, definitions));
                lines.extend(round.iter().map(|(time, start)| {
                    let start = if start.is_zero() { String::new() } else { format!(" from {} on", rational(start)) };
                    format!("lasting: {} in all, as the system runs{start}", rational(time))
                }));
                lines.extend(checked(period, found, environment, &|| self.surroundings.interrupted()));
                lines
            }
            Err(failures) => failures.iter().map(ToString::to_string).collect(),
        };
        let expected = waiting.expected.iter().map(|(expectation, text)| {
            let met = is_met(expectation, (&period, round.as_ref().map(|(time, _)| time)), waiting);
            Expected { text: text.clone(), met }
        });
        (lines, expected.collect())
    }
}

fn told(period: &Period, rounds: Option<Vec<(String, u64)>>, definitions: &Definitions) -> Vec<String> {
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
    lines.extend(graph::remarks(period));
    lines
}

/// How long it takes until the system is again as it was, and from when on: where it is gone through several phases, as
/// its run in the executable meaning shows.
fn run_of(
    period: &Period,
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<(BigRational, BigRational)> {
    let term = system.term(&environment.definitions);
    if period.lasting().is_some() || term.size() > MOST_TERM {
        return None;
    }
    Lasso::of(&term, &environment.definitions, interrupted).round()
}

fn is_met(
    expectation: &Expectation,
    (period, round): (&Result<Period, Vec<Failure>>, Option<&BigRational>),
    waiting: &Waiting,
) -> bool {
    let repeats = period.as_ref().is_ok_and(Period::repeats);
    let is = |found: Option<Value>, wanted: &Value| {
        let decide = |found: &Value| waiting.environment.assumptions.decide(Relation::Eq, found, wanted);
        found.is_some_and(|found| decide(&found) == Some(true))
    };
    match expectation {
        Expectation::Answer(word) => word.as_str() == if repeats { "yes" } else { "no" },
        Expectation::Values(values) => values.iter().all(|(name, wanted)| match (name.as_str(), period) {
            ("lasting", Ok(period)) => is(period.lasting().or_else(|| round.cloned().map(Value::rational)), wanted),
            ("phases", Ok(period)) => is(i64::try_from(period.phases.len()).ok().map(Value::integer), wanted),
            _ => false,
        }),
        _ => false,
    }
}
