//! Probabilities no more closely than is needed: to tell on which side of a threshold they lie, or to be drawn.

use num_rational::BigRational;
use num_traits::ToPrimitive;

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

/// A probability that grows with time.
pub(super) struct Growth {
    /// A time, a lower and an upper bound.
    pub(super) bounds: Vec<(f64, f64, f64)>,
    /// What the bounds are.
    pub(super) method: &'static str,
}

/// A probability that grows with time, at some of the times. What hardly ever happens is asked for at few of them, as each
/// takes long.
pub(super) fn growth(
    likelihood: &Likelihood,
    environment: &Environment,
    times: &[BigRational],
    interrupted: &dyn Fn() -> bool,
) -> Option<Growth> {
    let Event::Shown { .. } = likelihood.event else { return None };
    let (chain, question) = asked(likelihood, environment).ok()?;
    let at = |time: &BigRational| Question { time: time.clone(), names: question.names.clone(), ..question };
    let last = times.last()?;
    let enclosed = |time: &BigRational| enclosed::enclosed(&chain, &at(time), WIDE).ok();
    let near = |time: &BigRational| time.to_f64();
    if likelihood.method != Some(Method::Estimated) && enclosed(last).is_some() {
        let all = times.iter().take_while(|_| !interrupted());
        let all = all.map(|time| enclosed(time).and_then(|found| Some((near(time)?, found.low, found.high))));
        return Some(Growth { bounds: all.collect::<Option<_>>()?, method: "enclosed" });
    }
    let estimated = |time: &BigRational| estimated::estimated(&chain, &at(time), RUNS, 1).ok();
    let step = if estimated(last)?.rare == Rare::No { 1 } else { times.len().div_ceil(FEW) };
    let few = times.iter().rev().step_by(step).take_while(|_| !interrupted());
    let few = few.map(|time| estimated(time).and_then(|found| Some((near(time)?, found.low, found.high))));
    let mut bounds = few.collect::<Option<Vec<_>>>()?;
    bounds.reverse();
    Some(Growth { bounds, method: "estimated" })
}
