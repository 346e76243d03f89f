//! What saturation cannot prove because it repeats: induction on a number of rounds, and the one solution of a guarded
//! recursion.

use std::collections::{BTreeMap, BTreeSet};

use super::Search;
use crate::fact::Facts;
use crate::kernel::check;
use crate::law::Connective;
use crate::name::Name;
use crate::proof::{Proof, Script, Statement, Step, StepId, successor};
use crate::rewrite::{Limits, Saturation};
use crate::scope::subterms;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::Value;

/// These proofs are tried before the search for others, with this fraction of its size.
const FRACTION: usize = 4;

impl Search<'_> {
    /// Proves `left = right` by one of the two, if the kernel takes the proof: it asks more of an induction than is
    /// asked here.
    pub(super) fn recursively(&self, left: &Term, right: &Term, script: &mut Script) -> Option<StepId> {
        let step = self.repeated(left, right, script)?;
        let (hypotheses, connective) = (self.context.hypotheses.to_vec(), Connective::Equal);
        let statement = Statement { hypotheses, left: left.clone(), connective, right: right.clone() };
        let steps = script.steps.get(..=step)?.to_vec();
        check(self.theory, &Proof::new(statement, steps)).ok().map(|_| step)
    }

    fn repeated(&self, left: &Term, right: &Term, script: &mut Script) -> Option<StepId> {
        if let Some(step) = self.solution(left, right, script) {
            return Some(step);
        }
        if let Some(step) = self.solution(right, left, script) {
            return Some(script.push(Step::Symmetric(step)));
        }
        let mut counts = BTreeSet::new();
        for term in [left, right].into_iter().flat_map(subterms) {
            counts.extend(term.values().flat_map(Value::variables));
        }
        let natural = |name: &Name| self.context.assumptions.is_natural(&Value::variable(name)) == Some(true);
        counts.into_iter().filter(natural).find_map(|variable| self.induction(&variable, left, right, script))
    }

    /// `candidate = fixed` where the fixed side is a loop or a recursive process: because the candidate solves its
    /// equation, which has no other solution.
    fn solution(&self, candidate: &Term, fixed: &Term, script: &mut Script) -> Option<StepId> {
        match fixed.node() {
            Node::Loop(body) if !Facts::of(body, self.context).instant_stop => {
                let round = Term::attempt(Term::seq([body.clone(), candidate.clone()]));
                let equation = self.saturated(candidate, &round, None, script)?;
                Some(script.push(Step::UniqueLoop { body: body.clone(), equation }))
            }
            Node::Call(name, arguments) if arguments.is_empty() => {
                let definition = self.theory.definitions.get(name).filter(|definition| definition.recursive)?;
                let round = Term::attempt(replaced(&definition.body, name, candidate));
                let equation = self.saturated(candidate, &round, None, script)?;
                Some(script.push(Step::Unique { name: name.clone(), candidate: candidate.clone(), equation }))
            }
            _ => None,
        }
    }

    fn induction(&self, variable: &Name, left: &Term, right: &Term, script: &mut Script) -> Option<StepId> {
        let at = |term: &Term, value: Value| substitute_values(term, &BTreeMap::from([(variable.clone(), value)])).ok();
        let none = Value::integer(0);
        let base = self.saturated(&at(left, none.clone())?, &at(right, none)?, None, script)?;
        let next = successor(&Value::variable(variable))?;
        let supposed = script.push(Step::Suppose(left.clone(), right.clone()));
        let (one, two) = (at(left, next.clone())?, at(right, next)?);
        let step = self.saturated(&one, &two, Some((left, right, supposed)), script)?;
        let (left, right) = (left.clone(), right.clone());
        Some(script.push(Step::Induction { variable: variable.clone(), left, right, base, step }))
    }

    /// Proves an equality by saturation alone, with one more equation if one is supposed.
    fn saturated(
        &self,
        left: &Term,
        right: &Term,
        supposed: Option<(&Term, &Term, StepId)>,
        script: &mut Script,
    ) -> Option<StepId> {
        if left == right {
            return Some(script.push(Step::Reflexive(left.clone())));
        }
        let limits = Limits { nodes: self.limits.nodes / FRACTION, ..self.limits };
        let mut saturation = Saturation::new(self.theory, self.context, None, limits, self.interrupted);
        if let Some((one, two, step)) = supposed {
            saturation.suppose(one, two, step);
        }
        saturation.search(left, right, script).ok()
    }
}

/// A body with each call of a process without parameters replaced.
fn replaced(body: &Term, name: &Name, candidate: &Term) -> Term {
    match body.node() {
        Node::Call(called, _) if called == name => candidate.clone(),
        _ if body.children().is_empty() => body.clone(),
        _ => body.with_children(body.children().map(|part| replaced(part, name, candidate)).collect()),
    }
}
