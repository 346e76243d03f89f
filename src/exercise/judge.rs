//! Whether a step is right, and if not, why.

use std::fmt::Write as _;

use super::{Attempt, Done};
use crate::explain::claim_lines;
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::Laws;
use crate::name::Name;
use crate::proof::Statement;
use crate::prove::{Answer, By, prove};
use crate::refute::{self, Counterexample, refute};
use crate::remedy::{in_words, near_misses, remedies};
use crate::rewrite::Limits;
use crate::simplify::alone;

/// Instances tried before a proof is looked for.
const INSTANCES: usize = 3_000;

impl Attempt {
    /// The laws by which a step is proved.
    ///
    /// # Errors
    /// What to tell the learner, where it is not.
    pub(super) fn judge(&self, step: &Done, interrupted: &dyn Fn() -> bool) -> Result<Vec<Name>, String> {
        let statement = self.statement(step);
        let named = if step.laws.is_empty() { &self.exercise.laws } else { &step.laws };
        let mut proved = self.proved(&statement, named, interrupted);
        if let Some(laws) = proved.take() {
            return self.as_named(&statement, step, laws, interrupted);
        }
        if let Some(found) = self.refuted(&statement) {
            return Err(self.wrong(&statement, step, &found, interrupted));
        }
        if !step.laws.is_empty()
            && let Some(laws) = self.proved(&statement, &self.exercise.laws, interrupted)
        {
            return Err(format!(
                "the step holds, but not by {} alone; it follows by {}\n",
                list(&step.laws),
                list(&laws)
            ));
        }
        if !self.exercise.laws.is_empty()
            && let Some(laws) = self.proved(&statement, &[], interrupted)
        {
            let other: Vec<Name> = laws.into_iter().filter(|law| !self.exercise.laws.contains(law)).collect();
            return Err(format!("the step holds, but it needs {}, which this exercise does not allow\n", list(&other)));
        }
        let mut text = "this step could be neither proved nor refuted; try a smaller one\n".to_string();
        text.push_str(&self.missed(&statement, step));
        Err(text)
    }

    /// A proof found by the laws named and those about units, which are always allowed: one that was named must be in it.
    fn as_named(
        &self,
        statement: &Statement,
        step: &Done,
        used: Vec<Name>,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Vec<Name>, String> {
        if step.laws.is_empty() || used.iter().any(|law| step.laws.contains(law)) {
            return Ok(used);
        }
        // A law about units may have been taken where one that was named does as well.
        let mut strictly = Laws::default();
        for law in self.theory.laws.iter().filter(|law| step.laws.contains(&law.name)) {
            strictly.push((**law).clone());
        }
        if let Some(laws) = self.proved_in(statement, strictly, interrupted).filter(|laws| !laws.is_empty()) {
            return Ok(laws);
        }
        let by = if used.is_empty() { "computing with values".to_string() } else { list(&used) };
        Err(format!("the step holds, but not by {}: by {by}\n", list(&step.laws)))
    }

    /// The laws of a proof by these laws (none: by all) and those about units, which the kernel has checked.
    fn proved(&self, statement: &Statement, laws: &[Name], interrupted: &dyn Fn() -> bool) -> Option<Vec<Name>> {
        self.proved_in(statement, alone(&self.theory.laws, laws), interrupted)
    }

    fn proved_in(&self, statement: &Statement, laws: Laws, interrupted: &dyn Fn() -> bool) -> Option<Vec<Name>> {
        let theory = Theory { laws, ..self.theory.clone() };
        match prove(&theory, statement, &By::Search, Limits::default(), interrupted) {
            Answer::Proved(theorem, _) => Some(theorem.laws().iter().cloned().collect()),
            Answer::Open(_) => None,
        }
    }

    fn refuted(&self, statement: &Statement) -> Option<Counterexample> {
        let limits = refute::Limits { instances: INSTANCES, choices: 50 * INSTANCES, ..refute::Limits::default() };
        let judged = refute(
            &statement.left,
            &statement.right,
            statement.connective,
            &statement.hypotheses,
            &self.theory.definitions,
            &self.theory.assumptions,
            &limits,
        );
        judged.counterexample().cloned()
    }

    /// A wrong step: a run that contradicts it, and what would make it right.
    fn wrong(
        &self,
        statement: &Statement,
        step: &Done,
        found: &Counterexample,
        interrupted: &dyn Fn() -> bool,
    ) -> String {
        let mut text = "no, this step does not hold:\n".to_string();
        for line in claim_lines(found, statement, &self.theory.definitions) {
            let _ = writeln!(text, "    {line}");
        }
        let missed = self.missed(statement, step);
        text.push_str(&missed);
        for remedy in remedies(&self.theory, statement, interrupted) {
            let needs: Vec<String> = remedy.conditions.iter().map(in_words).collect();
            let then = match remedy.proved {
                true => "then it is proved".to_string(),
                false => format!("then none of {} small instances contradicts it", remedy.instances),
            };
            let _ = writeln!(text, "  it needs {} ({then})", needs.join(", and "));
        }
        text
    }

    /// Laws that would give the step, if their conditions were met.
    fn missed(&self, statement: &Statement, step: &Done) -> String {
        let context = Context::new(&self.theory.assumptions, &self.theory.definitions, &statement.hypotheses);
        let laws = if step.laws.is_empty() { &self.exercise.laws } else { &step.laws };
        let mut text = String::new();
        for miss in near_misses(&self.theory, &context, laws, &statement.left, &statement.right) {
            let needs: Vec<String> = miss.unmet.iter().map(in_words).collect();
            let _ = writeln!(text, "  the law {} would give it, but needs {}", miss.law, needs.join(", and "));
        }
        text
    }
}

fn list(laws: &[Name]) -> String {
    laws.iter().map(Name::as_str).collect::<Vec<_>>().join(", ")
}
