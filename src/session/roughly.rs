//! Probabilities no more closely than is needed: to tell on which side of a threshold they lie, or to be drawn.

use num_rational::BigRational;

use super::likely::{asked, chances};
use crate::criteria::Likely;
use crate::interval::Interval;
use crate::lower::{Environment, Event, Likelihood, Method};
use crate::probability::estimated::Rare;
use crate::probability::{Question, enclosed, estimated};
use crate::value::Relation;

/// How wide a probability may be that is drawn, or compared with a threshold that is far away.
const WIDE: f64 = 1e-3;
/// Runs of a simulation that is drawn.
const RUNS: u64 = 2_000;
/// Times at which what hardly ever happens is asked for.
const FEW: usize = 5;

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

/// A probability that grows with time, at some of the times: each with lower and upper bounds, and a word on what they are.
/// What hardly ever happens is asked for at few times, as each takes long.
pub(super) fn growth<'t>(
    likelihood: &Likelihood,
    environment: &Environment,
    times: &'t [BigRational],
    interrupted: &dyn Fn() -> bool,
) -> Option<(Vec<(&'t BigRational, f64, f64)>, &'static str)> {
    let Event::Shown { .. } = likelihood.event else { return None };
    let (chain, question) = asked(likelihood, environment).ok()?;
    let at = |time: &BigRational| Question { time: time.clone(), names: question.names.clone(), ..question };
    let last = times.last()?;
    let enclosed = |time: &BigRational| enclosed::enclosed(&chain, &at(time), WIDE).ok();
    if likelihood.method != Some(Method::Estimated) && enclosed(last).is_some() {
        let all = times.iter().take_while(|_| !interrupted());
        let all = all.map(|time| enclosed(time).map(|found| (time, found.low, found.high)));
        return Some((all.collect::<Option<_>>()?, "enclosed"));
    }
    let estimated = |time: &BigRational| estimated::estimated(&chain, &at(time), RUNS, 1).ok();
    let step = if estimated(last)?.rare == Rare::No { 1 } else { times.len().div_ceil(FEW) };
    let few = times.iter().rev().step_by(step).take_while(|_| !interrupted());
    let mut all =
        few.map(|time| estimated(time).map(|found| (time, found.low, found.high))).collect::<Option<Vec<_>>>()?;
    all.reverse();
    Some((all, "estimated"))
}
