//! Chances of systems that are no chain of rounds, from the draws and times themselves: one process that waits and shows,
//! all branches of finitely many values, cases of which time comes first, runs.

use super::{Answer, CASES, Method, ORDERS, PARTS, SEED, event, name, surely, trust};
use crate::interval::Interval;
use crate::invariant::PERIOD;
use crate::lower::{Environment, Likelihood};
use crate::probability::direct::{Sample, Shown};
use crate::probability::{branches, direct, estimated, races, schedule};
use crate::report::Chance;
use crate::session::digits::{LIKELY, between};
use crate::session::drawn::durations_below_are_drawn;
use crate::term::Term;

/// Runs that are drawn as pictures.
const DRAWN: u64 = 12;

/// The answer for one process that draws how long it lasts.
pub(super) fn scheduled(likelihood: &Likelihood, environment: &Environment) -> Result<Answer, String> {
    let (system, event, question) = event(likelihood, environment).map_err(|reasons| reasons.join("; "))?;
    let found = schedule::schedule(&system.components, &environment.definitions, &event, &question)?;
    let method = if found.wide { Method::Enclosed } else { Method::Exact };
    if likelihood.method.is_some_and(|asked| asked != method) {
        return Err(format!("it is {} only", name(method)));
    }
    let lines = below(&system.term(&environment.definitions), environment);
    Ok(surely(found.chance, method, lines, PARTS))
}

/// The answer by the cases of which of several drawn times comes first.
///
/// # Errors
/// Why there is none; no reason where another method is asked for.
pub(super) fn raced(likelihood: &Likelihood, environment: &Environment) -> Result<Answer, Option<String>> {
    if likelihood.method == Some(Method::Estimated) {
        return Err(None);
    }
    cases(likelihood, environment).map_err(Some)
}

fn cases(likelihood: &Likelihood, environment: &Environment) -> Result<Answer, String> {
    let (system, event, question) = event(likelihood, environment).map_err(|reasons| reasons.join("; "))?;
    let term = system.term(&environment.definitions);
    let found = races::races(&term, &environment.definitions, &environment.assumptions, &event, &question)?;
    let method = if found.wide { Method::Enclosed } else { Method::Exact };
    if likelihood.method.is_some_and(|asked| asked != method) {
        return Err(format!("it is {} only", name(method)));
    }
    let mut lines = vec![format!("it happens in {} of the cases of what is drawn", found.cases)];
    lines.extend(below(&term, environment));
    Ok(surely(found.chance, method, lines, CASES))
}

/// The answer by all branches of the executable meaning, of which hardly anything is left to trust; none where there are
/// too many.
pub(super) fn followed(likelihood: &Likelihood, environment: &Environment) -> Option<Answer> {
    if !matches!(likelihood.method, None | Some(Method::Exact)) {
        return None;
    }
    let (system, event, question) = event(likelihood, environment).ok()?;
    let term = system.term(&environment.definitions);
    let found = branches::branches(&term, &environment.definitions, &event, &question).ok()?;
    let mut lines = vec!["all branches of the executable meaning were followed".to_string()];
    lines.extend(below(&term, environment));
    let trusted = if found.orders { vec![ORDERS.to_string()] } else { Vec::new() };
    Some(Answer { trusted, ..surely(found.chance, Method::Exact, lines, PARTS) })
}

/// What is said of durations that are drawn.
pub(super) fn below(system: &Term, environment: &Environment) -> Vec<String> {
    let said = durations_below_are_drawn(system, environment);
    said.then(|| "a duration that is drawn below 0 counts as 0".to_string()).into_iter().collect()
}

/// The answer by runs of the executable meaning; none where another method is asked for.
pub(super) fn run(likelihood: &Likelihood, environment: &Environment) -> Option<Result<Answer, Vec<String>>> {
    if !matches!(likelihood.method, None | Some(Method::Estimated)) {
        return None;
    }
    let answer = || -> Result<Answer, Vec<String>> {
        let (system, event, question) = event(likelihood, environment)?;
        let term = system.term(&environment.definitions);
        let (runs, seed) = (likelihood.runs, likelihood.seed.unwrap_or(SEED));
        let found = direct::direct(&term, &environment.definitions, &event, &question, (runs, seed))
            .map_err(|reason| vec![format!("not estimated: {reason}")])?;
        let interval = Interval::between(found.low, found.high);
        let mut lines = vec![
            format!("probability {} (estimated)", between(&interval, LIKELY)),
            format!("{} runs of the executable meaning, seed {seed}, confidence {}", found.runs, estimated::CONFIDENCE),
        ];
        lines.extend(below(&term, environment));
        let Interval { low, high } = interval;
        let (confidence, runs) = (Some(estimated::CONFIDENCE), Some(found.runs));
        let chance = Chance { low, high, method: name(Method::Estimated), confidence, runs };
        Ok(Answer { chance, interval, enclosed: None, lines, trusted: trust(PERIOD, None) })
    };
    Some(answer())
}

/// Some runs of what is asked about, with the seed of their draws; none where nothing is drawn, or they cannot be followed.
pub(in crate::session) fn sampled(
    likelihood: &Likelihood,
    environment: &Environment,
) -> Option<(Vec<Vec<Shown>>, u64)> {
    let (system, event, question) = event(likelihood, environment).ok()?;
    let term = system.term(&environment.definitions);
    let seed = likelihood.seed.unwrap_or(SEED);
    let found = direct::trajectories(&term, &environment.definitions, &event, &question, (DRAWN, seed)).ok()?;
    Some((found, seed))
}

/// Runs of which a curve is drawn.
const CURVE: u64 = 1_000;

/// Many runs of what is asked about, as far as they say when it happens and what is shown in the end, with the seed.
pub(in crate::session) fn many(likelihood: &Likelihood, environment: &Environment) -> Option<(Sample, u64)> {
    let (system, event, question) = event(likelihood, environment).ok()?;
    let term = system.term(&environment.definitions);
    let seed = likelihood.seed.unwrap_or(SEED);
    let found = direct::sample(&term, &environment.definitions, &event, &question, (CURVE, seed)).ok()?;
    Some((found, seed))
}
