//! Refinements that are named: each takes a part of a process to one that shows less.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use super::Search;
use crate::law::{Connective, Law};
use crate::matching::matches;
use crate::name::Name;
use crate::proof::{Step, StepId, hole};
use crate::refine::refine;
use crate::simplify::{Simplified, Simplifier, surround};
use crate::term::Term;

/// The most processes looked at on the way from one side to the other.
const MOST: usize = 200;

impl Search<'_> {
    /// The refinements among the laws that are named, as strong as the claim asks; what `forget` does is tried anyway.
    pub(super) fn refinements(&self, connective: Connective, only: Option<&[Name]>) -> Vec<Arc<Law>> {
        let named = |name: &&Name| name.as_str() != "forget";
        let laws = only.unwrap_or_default().iter().filter(named).filter_map(|name| self.theory.laws.get(name));
        laws.filter(|law| law.connective.refines() && law.connective.gives(connective)).cloned().collect()
    }

    /// Searches for `left <= right` by way of these refinements, the fewest first.
    pub(super) fn stepwise(
        &self,
        left: &Term,
        right: &Term,
        laws: &[Arc<Law>],
        simplifier: &mut Simplifier<'_>,
    ) -> Option<StepId> {
        if laws.is_empty() {
            return None;
        }
        let target = simplifier.simplify(right);
        let start = simplifier.script.push(Step::Reflexive(left.clone()));
        let mut open = VecDeque::from([Simplified { term: left.clone(), step: start }]);
        let mut seen = BTreeSet::from([left.clone()]);
        while let Some(now) = open.pop_front() {
            let simple = simplifier.simplify(&now.term);
            if now.term == *right {
                return Some(now.step);
            }
            if let Some(rest) = refine(&simple.term, &target.term, simplifier, self.context) {
                let back = simplifier.script.push(Step::Symmetric(target.step));
                return Some(simplifier.script.chain(vec![now.step, simple.step, rest, back]));
            }
            if (self.interrupted)() {
                return None;
            }
            let forms =
                if simple.term == now.term { vec![now.term.clone()] } else { vec![now.term, simple.term.clone()] };
            for (number, form) in forms.iter().enumerate() {
                let before = if number == 0 { vec![now.step] } else { vec![now.step, simple.step] };
                for next in self.refined(form, laws, simplifier) {
                    if seen.len() < MOST && seen.insert(next.term.clone()) {
                        let step = simplifier.script.chain(before.iter().copied().chain([next.step]).collect());
                        open.push_back(Simplified { term: next.term, step });
                    }
                }
            }
        }
        None
    }

    /// All that one of the refinements makes of a process, at its root or in a part.
    fn refined(&self, term: &Term, laws: &[Arc<Law>], simplifier: &mut Simplifier<'_>) -> Vec<Simplified> {
        let mut found = Vec::new();
        for law in laws {
            for one in matches(law, &law.left, term, self.context) {
                found.extend(simplifier.instance(term, law, true, &one.substitution, &one.surrounding));
            }
        }
        let children: Vec<Term> = term.children().cloned().collect();
        for (place, child) in children.iter().enumerate() {
            for inner in self.refined(child, laws, simplifier) {
                if found.len() >= MOST {
                    return found;
                }
                let mut parts = children.clone();
                parts[place] = Term::meta(&hole(1));
                let shape = term.with_children(parts);
                let step = simplifier.script.push(Step::Congruence(shape.clone(), vec![inner.step]));
                found.push(Simplified { term: surround(&shape, &inner.term), step });
            }
        }
        found
    }
}
