//! Rounds whose number is a small one, written out: `P^2 # Q` is `(P ; P) # Q`. The laws of loop-free processes are
//! complete once no round is left folded.

use num_traits::ToPrimitive;

use super::Search;
use crate::name::Name;
use crate::proof::{Step, StepId, hole};
use crate::simplify::{Simplified, Simplifier};
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

/// The most rounds that are written out of one power.
const MOST_ROUNDS: usize = 64;

/// A term is not written out to more than this size.
const LARGEST: usize = 4_000;

/// Deeper in a term nothing is written out.
const DEEPEST: usize = 400;

impl Search<'_> {
    /// Whether both sides are the same once their rounds are written out and they are simplified again: the step that
    /// proves it.
    pub(super) fn written_out(&self, left: &Term, right: &Term, simplifier: &mut Simplifier<'_>) -> Option<StepId> {
        if left.depth() > DEEPEST || right.depth() > DEEPEST || !(has_rounds(left) || has_rounds(right)) {
            return None;
        }
        let (one, two) = (self.opened(left, simplifier)?, self.opened(right, simplifier)?);
        let (from, to) = (simplifier.simplify(&one.term), simplifier.simplify(&two.term));
        if from.term != to.term {
            return None;
        }
        let script = &mut simplifier.script;
        let there = script.chain(vec![one.step, from.step]);
        let other = script.chain(vec![two.step, to.step]);
        let back = script.push(Step::Symmetric(other));
        Some(script.chain(vec![there, back]))
    }

    /// The term with its rounds written out; none where that is too long.
    fn opened(&self, term: &Term, simplifier: &mut Simplifier<'_>) -> Option<Simplified> {
        if !has_rounds(term) {
            let step = simplifier.script.push(Step::Reflexive(term.clone()));
            return Some(Simplified { term: term.clone(), step });
        }
        let mut parts = Vec::new();
        for part in term.children() {
            parts.push(self.opened(part, simplifier)?);
        }
        let shape = term.with_children((1..=parts.len()).map(|number| Term::meta(&hole(number))).collect());
        let steps = parts.iter().map(|part| part.step).collect();
        let inside = simplifier.script.push(Step::Congruence(shape, steps));
        let whole = term.with_children(parts.into_iter().map(|part| part.term).collect());
        if whole.size() > LARGEST {
            return None;
        }
        let Some(next) = self.rounds(&whole, simplifier) else { return Some(Simplified { term: whole, step: inside }) };
        if next.term.size() > LARGEST {
            return None;
        }
        let step = simplifier.script.chain(vec![inside, next.step]);
        Some(Simplified { term: next.term, step })
    }

    /// `P^3 = Stop ; P ; P ; P`, round by round from the last.
    fn rounds(&self, term: &Term, simplifier: &mut Simplifier<'_>) -> Option<Simplified> {
        let Node::Power(body, count, index) = term.node() else { return None };
        let rounds = small(count)?;
        if body.size().saturating_mul(rounds) > LARGEST {
            return None;
        }
        let (zero, one_more) =
            if index.is_some() { ("rounds-zero", "rounds-step") } else { ("power-zero", "power-step") };
        let (zero, one_more) =
            (self.theory.laws.get(&Name::new(zero))?.clone(), self.theory.laws.get(&Name::new(one_more))?.clone());
        let mut with = Substitution::default();
        with.processes.insert(Name::new("?P"), body.clone());
        if let Some(index) = index {
            with.names.insert(Name::new("?i"), index.clone());
        }
        let mut current = term.clone();
        let mut chain = vec![simplifier.script.push(Step::Reflexive(term.clone()))];
        let mut behind: Vec<Term> = Vec::new();
        for done in (0..=rounds).rev() {
            let law = if done == 0 { &zero } else { &one_more };
            if done > 0 {
                with.values.insert(Name::new("?n"), Value::integer(i64::try_from(done - 1).ok()?));
            } else {
                with.values.remove(&Name::new("?n"));
            }
            let around = Term::seq([Term::meta(&hole(1))].into_iter().chain(behind.iter().cloned()));
            let next = simplifier.instance(&current, law, true, &with, &around)?;
            chain.push(next.step);
            current = next.term;
            if done > 0 {
                let right = with.apply(&law.right, simplifier.context()).ok()?;
                let Node::Seq(parts) = right.node() else { return None };
                let round = parts.get(1..)?.iter().cloned();
                behind = round.chain(behind).collect();
            }
        }
        let step = simplifier.script.chain(chain);
        Some(Simplified { term: current, step })
    }
}

/// The number of rounds, where it is small enough to write them out.
fn small(count: &Value) -> Option<usize> {
    let number = count.as_rational().filter(|number| number.is_integer())?;
    number.to_integer().to_usize().filter(|number| *number <= MOST_ROUNDS)
}

fn has_rounds(term: &Term) -> bool {
    let mut rest = vec![term];
    while let Some(term) = rest.pop() {
        if let Node::Power(_, count, _) = term.node()
            && small(count).is_some()
        {
            return true;
        }
        rest.extend(term.children());
    }
    false
}
