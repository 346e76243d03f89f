//! Parts side by side of which at most one passes its guards.

use super::flow::Walk;
use super::process::guard;
use crate::assumption::Assumptions;
use crate::ast::{Term, TermKind, Value as Written};
use crate::value::{Relation, Value};

/// Parts of which each two are compared.
const MOST_PARTS: usize = 32;

impl Walk<'_, '_> {
    /// Whether two parts begin with guards that cannot all pass, whatever the values of the names in them.
    pub(super) fn exclusive(&mut self, left: Option<&Term>, right: Option<&Term>) -> bool {
        let (Some(left), Some(right)) = (left, right) else { return false };
        let mut both = Assumptions::default();
        for (relation, one, other) in self.first_guards(left).into_iter().chain(self.first_guards(right)) {
            both.assume(relation, &one, &other);
        }
        both.plainly_contradictory() || both.contradictory()
    }

    /// Whether of these parts at most one can pass its guards.
    pub(super) fn all_exclusive(&mut self, parts: &[Term]) -> bool {
        parts.len() <= MOST_PARTS
            && parts
                .iter()
                .enumerate()
                .all(|(index, left)| parts.iter().skip(index + 1).all(|right| self.exclusive(Some(left), Some(right))))
    }

    /// The guards that a process begins with, one after the other.
    fn first_guards(&mut self, term: &Term) -> Vec<(Relation, Value, Value)> {
        match &term.kind {
            TermKind::Seq(parts) => {
                let mut guards = Vec::new();
                for part in parts {
                    let own = self.first_guards(part);
                    let is_guard = matches!(part.kind, TermKind::Apply { .. }) && !own.is_empty();
                    guards.extend(own);
                    // What follows anything else comes later, when names may be bound anew.
                    if !is_guard {
                        break;
                    }
                }
                guards
            }
            TermKind::Apply { name, arguments, .. } => self.guard(name.name.as_str(), arguments).into_iter().collect(),
            _ => Vec::new(),
        }
    }

    fn guard(&mut self, name: &str, arguments: &[Written]) -> Option<(Relation, Value, Value)> {
        let [left, right] = arguments else { return None };
        Some((guard(name)?, self.quiet(left)?, self.quiet(right)?))
    }

    /// A value, if it can be had without errors; they have been reported before.
    pub(super) fn quiet(&mut self, written: &Written) -> Option<Value> {
        let count = self.lowerer.errors.len();
        let value = self.lowerer.number(written);
        let fine = self.lowerer.errors.len() == count;
        self.lowerer.errors.truncate(count);
        value.filter(|_| fine)
    }
}
