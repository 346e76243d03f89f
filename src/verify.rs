//! From a period to a verdict: the run of the system leg by leg, and the property matched with it.

mod again;
mod by_turns;
mod cases;
mod copies;
mod count;
mod counted;
pub(crate) mod influence;
mod lay;
mod orbit;
pub mod property;
mod round;
mod seek;
mod sides;
mod solved;
mod stages;
mod stretch;
mod supposed;
pub mod trajectory;
mod turning;
mod undecided;
pub mod unit;

use std::collections::BTreeMap;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::period::{self, End, Failure, Period};
use crate::recurrence::Comparison;
use crate::term::Term;
use crate::value::Value;

pub use cases::{Apart, may_be_zero};
pub(crate) use cases::{Merge, equation};
pub use orbit::Orbit;
pub use round::Endless;
pub(crate) use sides::{equal, rounded, side};
use supposed::supposing;
pub(crate) use supposed::walk_supposing;
pub use supposed::{Supposed, Supposing};
pub use trajectory::{Leg, Rounds, Trajectory};
pub use unit::{Unit, total};

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
    /// Those that are not the same in all later rounds: from which round on, and then again and again.
    pub by_turns: Option<(usize, BTreeMap<Name, Vec<Value>>)>,
    /// What has to be said of a value found: that any longer time would do as well.
    pub remark: Option<String>,
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
    /// Why there is neither of these two.
    pub unwritten: Option<String>,
    /// The part of the run that repeats.
    pub period_term: Option<Term>,
    /// The period, where there is one.
    pub period: Option<Period>,
    /// What is wrong or may go wrong.
    pub diagnostics: Vec<Failure>,
    /// The phase that the run never leaves, where two values would have to be equal for that.
    pub endless: Option<Endless>,
    /// Whether the run was followed no further than a while, and what comes then is not known.
    pub cut: bool,
    /// Whether it goes on by turns in which something counts on: without what counts it may repeat exactly.
    pub counts: bool,
    /// What is not decided, where it is open.
    pub(crate) asked: Vec<Comparison>,
    /// What was found in either case, where this was made of two.
    pub apart: Option<Box<Apart>>,
    /// Where it is open, what would follow if each phase ended.
    pub supposing: Option<Box<Supposing>>,
}

impl Outcome {
    /// Whether it is proved, of a run that is a process.
    fn is_told(&self) -> bool {
        matches!(self.verdict, Verdict::Proved) && (self.trajectory_term.is_some() || self.apart.is_some())
    }

    fn new(verdict: Verdict) -> Outcome {
        Outcome {
            verdict,
            values: BTreeMap::new(),
            steady: BTreeMap::new(),
            by_turns: None,
            remark: None,
            opening: Vec::new(),
            legs: Vec::new(),
            orbit: None,
            trajectory_term: None,
            property_term: None,
            unwritten: None,
            period_term: None,
            period: None,
            diagnostics: Vec::new(),
            endless: None,
            cut: false,
            counts: false,
            asked: Vec::new(),
            apart: None,
            supposing: None,
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
        Ok(wanted) => {
            let parameters = period::parameters(components, definitions, assumptions);
            let look = |period: &Period| {
                cases::in_cases((assumptions, &parameters), &|known| {
                    let trajectory = trajectory::walk(period, (definitions, known), property.1, interrupted);
                    let told = |warning| told_of(warning, &trajectory);
                    let diagnostics = period.warnings.iter().filter_map(told).collect();
                    let asked = trajectory.asked.clone();
                    Outcome { diagnostics, asked, ..property::judge(&wanted, trajectory) }
                })
            };
            let plain = solved::plain(&period, assumptions);
            let run = plain.as_ref().unwrap_or(&period);
            let whole = look(run);
            let whole = match influence::reduced(run, property.1) {
                Some(reduced) if !whole.is_told() || whole.cut || whole.counts => better(whole, look(&reduced)),
                _ => whole,
            };
            let open = |outcome: &Outcome| matches!(outcome.verdict, Verdict::Open { .. });
            let together = if open(&whole) { run.by_cycles(assumptions).ok().flatten() } else { None };
            let mut found = together.map(|together| look(&together)).filter(|found| !open(found)).unwrap_or(whole);
            if open(&found) && !interrupted() {
                let wanted = (&wanted, property.1);
                found.supposing = supposing(run, (definitions, assumptions), wanted, interrupted).map(Box::new);
            }
            found
        }
    };
    outcome.period = Some(period);
    outcome
}

/// Of what was found with all variables and with those alone that the property depends on, what says more.
fn better(whole: Outcome, reduced: Outcome) -> Outcome {
    match (&whole.verdict, &reduced.verdict) {
        (Verdict::Proved, _) if !reduced.is_told() => whole,
        (_, Verdict::Proved) | (Verdict::Open { .. }, Verdict::Refuted { .. }) => reduced,
        (Verdict::Refuted { .. }, _) | (_, Verdict::Open { .. }) if reduced.period_term.is_none() => whole,
        _ => reduced,
    }
}

/// A warning, as far as it is true of this run: of a run that is known, it is known whether it comes to wait.
fn told_of(warning: &Failure, run: &Trajectory) -> Option<Failure> {
    let Failure::MayWait { blocked, .. } = warning else { return Some(warning.clone()) };
    match &run.end {
        Some(End::Silent { blocked: there, .. }) if there.contains(blocked) => {
            Some(Failure::Unmatched(blocked.clone()))
        }
        _ if !run.open.is_empty() || run.legs.iter().any(|leg| !leg.conditions.is_empty()) => Some(warning.clone()),
        _ => None,
    }
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
