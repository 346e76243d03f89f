//! Parts side by side of which at most one passes its guards.

use super::flow::{Flow, Walk};
use super::process::guard;
use crate::assumption::Assumptions;
use crate::ast::{Term, TermKind, Value as Written};
use crate::value::{Relation, Value};

/// Parts of which each two are compared.
const MOST_PARTS: usize = 32;
/// Ways in which guards may fail that are looked at.
const MOST_LOOKS: usize = 200;

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

    /// Whether of these parts one surely stops: whatever the values of the names, the guards of one pass that aborts nowhere
    /// else.
    pub(super) fn one_stops(&mut self, parts: &[Term], flows: &[Flow]) -> bool {
        let mut guards = Vec::new();
        for (part, flow) in parts.iter().zip(flows) {
            let TermKind::Seq(all) = &part.kind else { continue };
            let count = all.iter().take_while(|one| is_guard(one)).count();
            let own = self.first_guards(part);
            if count > 0 && own.len() == count && !flow.aborts_later {
                guards.push(own);
            }
        }
        let few = !guards.is_empty() && guards.len() <= MOST_PARTS;
        few && all_fail(&guards, &Assumptions::default(), &mut { MOST_LOOKS }) == Some(false)
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

/// Whether a process is a single comparison.
pub(super) fn is_guard(term: &Term) -> bool {
    matches!(&term.kind, TermKind::Apply { name, .. } if guard(name.name.as_str()).is_some())
}

/// Whether of each of these a guard may fail; none where that was not found out.
fn all_fail(parts: &[Vec<(Relation, Value, Value)>], known: &Assumptions, looks: &mut usize) -> Option<bool> {
    *looks = looks.checked_sub(1)?;
    if known.plainly_contradictory() || known.contradictory() {
        return Some(false);
    }
    let Some((first, rest)) = parts.split_first() else { return Some(true) };
    for (relation, left, right) in first {
        let mut here = known.clone();
        here.assume(relation.negated(), left, right);
        if all_fail(rest, &here, looks)? {
            return Some(true);
        }
    }
    Some(false)
}
