//! Probabilities no more closely than is needed: to tell on which side of a threshold they lie, or to be drawn.

use num_rational::BigRational;

use super::likely::{asked, chances};
use crate::criteria::Likely;
use crate::interval::Interval;
use crate::lower::{Environment, Event, Likelihood, Method};
use crate::probability::{Question, enclosed, estimated};
use crate::value::Relation;

/// How wide a probability may be that is drawn, or compared with a threshold that is far away.
const WIDE: f64 = 1e-3;
/// Runs of a simulation that is drawn.
const RUNS: u64 = 2_000;

/// A probability as closely as it is needed to compare it with a threshold.
pub(super) fn roughly(
    likelihood: &Likelihood,
    environment: &Environment,
    (relation, threshold): (Relation, &BigRational),
) -> Result<Likely, Vec<String>> {
    let wide = match &likelihood.event {
        Event::Shown { .. } if likelihood.method.is_none_or(|method| method == Method::Enclosed) => {
            let asked = asked(likelihood, environment).ok();
            let enclosed = asked.and_then(|(chain, question)| enclosed::enclosed(&chain, &question, WIDE).ok());
            enclosed.filter(|enclosed| enclosed.compare(relation, threshold).is_some())
        }
        _ => None,
    };
    match wide {
        Some(enclosed) => {
            let Interval { low, high } = enclosed.interval();
            let number = enclosed.number().cloned();
            Ok(Likely { low, high, number, sure: true, method: "enclosed", trusted: Vec::new() })
        }
        None => chances(likelihood, environment),
    }
}

/// As closely as it comes, whatever it is compared with.
pub(super) fn closely(
    likelihood: &Likelihood,
    environment: &Environment,
    _: (Relation, &BigRational),
) -> Result<Likely, Vec<String>> {
    chances(likelihood, environment)
}

/// A probability that grows with time, at some of the times: lower and upper bounds, with a word on what they are.
pub(super) fn growth(
    likelihood: &Likelihood,
    environment: &Environment,
    times: &[BigRational],
    interrupted: &dyn Fn() -> bool,
) -> Option<(Vec<(f64, f64)>, &'static str)> {
    let Event::Shown { .. } = likelihood.event else { return None };
    let (chain, question) = asked(likelihood, environment).ok()?;
    let at = |time: &BigRational| Question { time: time.clone(), names: question.names.clone(), ..question };
    let by_simulation = likelihood.method == Some(Method::Estimated)
        || times.last().is_none_or(|last| enclosed::enclosed(&chain, &at(last), WIDE).is_err());
    let mut all = Vec::new();
    for time in times.iter().take_while(|_| !interrupted()) {
        all.push(if by_simulation {
            let found = estimated::estimated(&chain, &at(time), RUNS, 1).ok()?;
            (found.low, found.high)
        } else {
            let found = enclosed::enclosed(&chain, &at(time), WIDE).ok()?;
            (found.low, found.high)
        });
    }
    Some((all, if by_simulation { "estimated" } else { "enclosed" }))
}
