//! From a period to a verdict: the run of the system leg by leg, and the property matched with it.

mod cases;
mod count;
mod lay;
mod orbit;
pub mod property;
mod round;
mod seek;
mod stretch;
pub mod trajectory;
mod turning;
pub mod unit;

use std::collections::BTreeMap;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::period::{self, Failure, Period};
use crate::term::Term;
use crate::value::Value;

pub(crate) use cases::Merge;
pub use orbit::Orbit;
pub use trajectory::{Leg, Rounds, Trajectory};
pub use unit::Unit;

/// What was found out.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// The run of the system shows what the property asks: `trajectory_term <= property_term`.
    Proved,
    /// It does not, and this run shows it.
    Refuted {
        /// Why, with the closed form where there is one.
        reason: String,
        /// Times from the start, with what is shown from then on.
        run: Vec<(Value, Vec<Term>)>,
    },
    /// Not decided.
    Open {
        /// What would have to be known.
        remaining: Vec<String>,
    },
}

/// A verdict with all that leads to it.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The verdict.
    pub verdict: Verdict,
    /// The property's unknowns in its first round.
    pub values: BTreeMap<Name, Value>,
    /// The same in later rounds.
    pub steady: BTreeMap<Name, Value>,
    /// What passes before the legs.
    pub opening: Vec<Unit>,
    /// The stretches of the run.
    pub legs: Vec<Leg>,
    /// What moves on from turn to turn, with the number of the leg at which the turns begin.
    pub orbit: Option<(usize, Orbit)>,
    /// The run as a process: what comes first, then the loop, cut where the property cuts it.
    pub trajectory_term: Option<Term>,
    /// The property with the durations found.
    pub property_term: Option<Term>,
    /// The part of the run that repeats.
    pub period_term: Option<Term>,
    /// The period, where there is one.
    pub period: Option<Period>,
    /// What is wrong or may go wrong.
    pub diagnostics: Vec<Failure>,
    /// What could be changed.
    pub feedback: Vec<String>,
}

impl Outcome {
    fn new(verdict: Verdict) -> Outcome {
        Outcome {
            verdict,
            values: BTreeMap::new(),
            steady: BTreeMap::new(),
            opening: Vec::new(),
            legs: Vec::new(),
            orbit: None,
            trajectory_term: None,
            property_term: None,
            period_term: None,
            period: None,
            diagnostics: Vec::new(),
            feedback: Vec::new(),
        }
    }
}

/// Whether the system of these components does what the property says. The property calls itself by its name. Work
/// that is `interrupted` leaves the verdict open.
pub fn verify(
    components: &[Term],
    property: (&Name, &Term),
    definitions: &Definitions,
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Outcome {
    let period = match period::analyse_until(components, definitions, assumptions, interrupted) {
        Ok(period) => period,
        // A run that comes to a halt may have shown what is asked before.
        Err(failures) => match period::followed(components, definitions, assumptions, interrupted) {
            Ok(period) => period,
            Err(_) => return without_period(failures),
        },
    };
    let mut outcome = match property::Wanted::of(property.1, property.0) {
        Err(reason) => Outcome::new(Verdict::Open { remaining: vec![reason] }),
        Ok(wanted) => cases::in_cases(assumptions, &|known| {
            property::judge(&wanted, trajectory::walk(&period, known, property.1, interrupted))
        }),
    };
    outcome.diagnostics.extend(period.warnings.iter().cloned());
    outcome.period = Some(period);
    outcome
}

fn without_period(failures: Vec<Failure>) -> Outcome {
    let reasons: Vec<String> = failures.iter().map(Failure::to_string).collect();
    let certain = |failure: &Failure| matches!(failure, Failure::NoCommunication { .. } | Failure::RateMismatch { .. });
    let verdict = if failures.iter().any(certain) {
        Verdict::Refuted { reason: reasons.join("; "), run: Vec::new() }
    } else {
        Verdict::Open { remaining: reasons }
    };
    let mut outcome = Outcome::new(verdict);
    outcome.diagnostics = failures;
    outcome
}
