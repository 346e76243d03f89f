//! Where runs are that miss what is asked for: the phase that a chance is too small for.

use super::{chain, event};
use crate::lower::{Environment, Likelihood};
use crate::period::{self, graph::behaviour};
use crate::probability::estimated::missed_in;

/// Runs that are simulated, and where their numbers begin.
const RUNS: u64 = 2_000;
const SEED: u64 = 1;

/// In which phase most of the runs are that miss it, by simulation; nothing where none does, or no run is known.
pub(in super::super) fn missed(likelihood: &Likelihood, environment: &Environment) -> Option<String> {
    let (system, event, question) = event(likelihood, environment).ok()?;
    let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions).ok()?;
    // In a single phase there is nothing to tell.
    (period.phases.len() > 1).then_some(())?;
    let chain = chain(&period, &event, &environment.assumptions).ok()?;
    let (phase, there, all) = missed_in(&chain, &question, RUNS, SEED).ok()??;
    let doing = behaviour(period.phases.get(phase)?, &period.names);
    let share = 100.0 * there as f64 / all as f64;
    Some(format!(
        "in phase {} of {} ({doing}) are {share:.0} % of the runs that miss it, of {RUNS} simulated ones",
        phase + 1,
        period.phases.len()
    ))
}
