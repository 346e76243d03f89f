//! Exercises: what is to be shown, by which laws, and what is given.

use super::scope::Lowerer;
use super::{By, ClaimKind, Exercise, Gap};
use crate::ast::ExerciseItem;
use crate::diagnostic::{Diagnostic, Span};
use crate::law::Connective;

impl Lowerer<'_> {
    pub(super) fn exercise(&mut self, item: &ExerciseItem, span: Span, text: &str) -> Option<Exercise> {
        let claim = self.claim(&item.claim, span, text)?;
        let ClaimKind::Compare { left, right, connective, when, by: By::Search } = claim.kind else { return None };
        let laws = self.laws(&item.laws)?;
        let mut steps = Vec::new();
        for step in &item.steps {
            if connective == Connective::Equal && step.connective != connective {
                self.wrong_end(step.span, "the goal is an equality, so no step may be `<=`");
            }
            let given = match &step.laws {
                Some(names) => Some(self.laws(names)?),
                None => None,
            };
            let outside = given.iter().flatten().find(|law| !laws.is_empty() && !laws.contains(law));
            if let Some(law) = outside {
                let message = format!("the exercise gives the law `{law}`, but does not allow it");
                self.report(Diagnostic::error("P0701", message).label(step.span, "in this step"));
            }
            let term = match &step.term {
                Some(term) => Some(self.whole(&[term])?.pop()?),
                None => None,
            };
            steps.push(Gap { connective: step.connective, laws: given, term });
        }
        if let (Some(Gap { term: Some(last), .. }), Some(written)) = (steps.last(), item.steps.last())
            && *last != right
        {
            self.wrong_end(written.span, "the steps must end with the right side of the goal");
        }
        let (name, title, hints) = (item.name.name.clone(), item.title.clone(), item.hints.clone());
        Some(Exercise { name, title, left, connective, right, when, laws, steps, hints })
    }
}
