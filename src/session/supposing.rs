//! What is said of a property where it is not known whether the phases of the run end: which numbers of rounds would have
//! to exist, and what the property gives if they do.

use std::collections::BTreeMap;

use super::claim::Found;
use super::compare::theory;
use super::reading::Run;
use super::satisfies::{said, short};
use crate::law::Connective;
use crate::lower::Environment;
use crate::name::Name;
use crate::proof::Statement;
use crate::prove::{Answer, By, prove};
use crate::rewrite::Limits;
use crate::value::Value;
use crate::verify::Outcome;

impl Run<'_, '_> {
    /// What remains to be shown and what it would give, if the run so supposed is proved to match the property.
    pub(super) fn supposed(&self, outcome: &Outcome, environment: &Environment, found: &mut Found) {
        let Some(supposing) = outcome.supposing.as_deref() else { return };
        let (Some(run), Some(wanted)) = (&supposing.outcome.trajectory_term, &supposing.outcome.property_term) else {
            return;
        };
        let (left, right, connective) = (run.clone(), wanted.clone(), Connective::Refines);
        let statement = Statement { hypotheses: Vec::new(), left, connective, right };
        let mut theory = theory(environment);
        theory.assumptions = supposing.known.clone();
        let interrupted = || self.surroundings.interrupted();
        let Answer::Proved(..) = prove(&theory, &statement, &By::Search, Limits::default(), &interrupted) else {
            return;
        };
        let mut lines = vec!["it remains to show that these numbers of rounds exist:".to_string()];
        lines.extend(supposing.supposed.iter().map(|one| format!("  {}", said(&one.line()))));
        let told = |values: &BTreeMap<Name, Value>| {
            values.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
        };
        let first = &supposing.outcome;
        lines.push(format!("if they do: {}", told(&first.values)));
        if first.steady != first.values && !first.steady.is_empty() {
            lines.push(format!("  in later rounds {}", told(&first.steady)));
        }
        lines.push(format!("  the run would be {}", short(&run.to_string())));
        lines.push(format!("  which matches {}, by the kernel", short(&wanted.to_string())));
        // What is asked where a phase is left at once is answered by the number of its rounds.
        found.remains.retain(|line| !line.starts_with("it must be known whether"));
        found.remains.extend(lines);
    }
}
