//! A run that was found for either order of two values, or where one is more and where both are equal: a proof of each case,
//! and from those one of both.

use super::matched::{RUN, Unfollowed, followed, with_run};
use super::rounds::no_value;
use super::satisfies::said;
use crate::assumption::Assumptions;
use crate::closed_form::compared;
use crate::fact::supposing;
use crate::kernel::{Theory, Thm, check};
use crate::law::{Condition, Connective};
use crate::period::Period;
use crate::proof::{Proof, Statement, Step};
use crate::prove::run::{Lost, either};
use crate::prove::{Answer, By, prove};
use crate::rewrite::Limits;
use crate::term::Term;
use crate::value::{Relation, Value};
use crate::verify::{Apart, Outcome, equal, equation, rounded};

/// What is proved in each order: that the system shows what is wanted, which is written for all orders.
pub(super) struct InEach<'a> {
    pub(super) theory: &'a Theory,
    pub(super) period: &'a Period,
    pub(super) whole: &'a Term,
    pub(super) wanted: &'a Term,
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

impl InEach<'_> {
    /// The proof for all orders, and in which the kernel could not follow the run, and why.
    pub(super) fn proof(&self, apart: &Apart) -> Result<((Thm, Proof), Vec<String>), String> {
        let mut lost = Vec::new();
        let proof = self.both(apart, &[], &mut lost)?;
        let theorem = check(self.theory, &proof).map_err(|rejected| rejected.reason.to_string())?;
        Ok(((theorem, proof), lost))
    }

    fn both(&self, apart: &Apart, hypotheses: &[Condition], lost: &mut Vec<String>) -> Result<Proof, String> {
        let lines = std::cell::RefCell::new(std::mem::take(lost));
        let each = |all: &[Condition]| {
            let above = matches!(all.last(), Some(Condition::Compare(Relation::Gtr, ..)));
            let outcome = if above { &apart.above } else { &apart.below };
            self.one(outcome, all, &mut lines.borrow_mut()).map_err(Lost)
        };
        let (sides, zero) = ((self.whole, self.wanted), Value::zero());
        let proof = either(hypotheses, sides, (&apart.difference, &zero), &each).map_err(|lost| lost.0);
        *lost = lines.into_inner();
        proof
    }

    fn one(&self, outcome: &Outcome, hypotheses: &[Condition], lost: &mut Vec<String>) -> Result<Proof, String> {
        if let Some(apart) = &outcome.apart {
            return match self.inside(outcome, hypotheses) {
                Some(inside) => {
                    let known = supposing(&self.theory.assumptions, hypotheses);
                    inside.both(apart, hypotheses, lost).map(|proof| self.as_wanted(proof, &known))
                }
                None => self.both(apart, hypotheses, lost),
            };
        }
        let (Some(run), Some(own)) = (&outcome.trajectory_term, &outcome.property_term) else {
            return Err(unwritten(outcome));
        };
        let mut open = String::new();
        let matched = self.alike(own, hypotheses).into_iter().find_map(|right| {
            let (hypotheses, left) = (hypotheses.to_vec(), run.clone());
            let statement = Statement { hypotheses, left, connective: Connective::Refines, right };
            match prove(self.theory, &statement, &By::Search, Limits::default(), self.interrupted) {
                Answer::Proved(_, matched) => Some(matched),
                Answer::Open(gap) => {
                    let (left, right) = (said(&gap.left.to_string()), said(&gap.right.to_string()));
                    open = format!("the run of the system, {left}, could not be proved to match {right}");
                    None
                }
            }
        });
        let Some(matched) = matched else { return Err(open) };
        let stages = outcome.stages_of(self.period);
        let proof = match followed(self.theory, (self.whole, run), &matched, &stages) {
            Ok((_, proof)) => proof,
            Err(Unfollowed { why, undefined: true }) => return Err(no_value(&why)),
            Err(Unfollowed { why, .. }) => {
                let case = |one: &Condition| match one {
                    Condition::Compare(relation, left, right) => compared(&(*relation, left.clone(), right.clone())),
                    other => other.to_string(),
                };
                let cases: Vec<String> = hypotheses.iter().map(case).collect();
                lost.push(format!("where {}: {}", cases.join(" and "), said(&why)));
                with_run(self.whole.clone(), run, *matched, RUN)
            }
        };
        Ok(self.as_wanted(proof, &supposing(&self.theory.assumptions, hypotheses)))
    }

    /// The same, of what is wanted as it is written for the cases of this case alone, where that is what is wanted: what is
    /// equal to it is shown step by step, one case inside another.
    fn inside<'o>(&'o self, outcome: &'o Outcome, hypotheses: &[Condition]) -> Option<InEach<'o>> {
        let wanted = outcome.property_term.as_ref()?;
        let known = supposing(&self.theory.assumptions, hypotheses);
        let (mut own, mut all) = (Vec::new(), Vec::new());
        values_in(wanted, &mut own);
        values_in(self.wanted, &mut all);
        let mut pairs = own.iter().zip(&all);
        let same = blank(wanted) == blank(self.wanted) && pairs.all(|(one, other)| equal(other, one, &known));
        same.then_some(InEach { wanted, ..*self })
    }

    /// What is wanted in this case, written as it is for all of them: as it is, or with durations that are 0 here written
    /// out, or with all that is equal here.
    fn alike(&self, own: &Term, hypotheses: &[Condition]) -> Vec<Term> {
        if blank(own) == blank(self.wanted) {
            return vec![own.clone()];
        }
        let (known, zero) = (supposing(&self.theory.assumptions, hypotheses), Value::zero());
        let plain = |value: &Value| Some(if equal(value, &zero, &known) { zero.clone() } else { value.clone() });
        let mut put_in = Some(self.wanted.clone());
        for hypothesis in hypotheses {
            if let Condition::Compare(Relation::Lte, left, right) = hypothesis
                && equal(left, right, &known)
                && let Some((name, image)) = equation(left, right)
            {
                put_in = put_in.and_then(|wanted| everywhere(&wanted, &|value| value.with(&name, &image).ok()));
            }
        }
        // With what each value is in this case, where its own property says so.
        let mut told = Vec::new();
        values_in(own, &mut told);
        let here = |value: &Value| {
            let known = || told.iter().find(|told| known.gives_meaning(value) && equal(value, told, &known)).cloned();
            plain(value).map(|plain| if plain == *value { known().unwrap_or(plain) } else { plain })
        };
        let settled = everywhere(self.wanted, &here);
        everywhere(self.wanted, &plain).into_iter().chain(put_in).chain(settled).collect()
    }

    /// The same proof, of what is written for all orders: one integer part after the other is what it is here.
    fn as_wanted(&self, mut proof: Proof, known: &Assumptions) -> Proof {
        let here = &proof.statement.right;
        if here == self.wanted {
            return proof;
        }
        let mut told = Vec::new();
        values_in(here, &mut told);
        let mut stages = vec![self.wanted.clone()];
        let nearer = |value: &Value| match told.contains(value) {
            true => Some(value.clone()),
            false => Some(rounded(value, known).unwrap_or_else(|| value.clone())),
        };
        while let Some(next) = stages.last().and_then(|last| everywhere(last, &nearer)) {
            if stages.last() == Some(&next) {
                break;
            }
            stages.push(next);
        }
        for next in stages.into_iter().rev() {
            let last = proof.steps.len().saturating_sub(1);
            if proof.statement.right != next {
                proof.steps.push(Step::Arithmetic(proof.statement.right.clone(), next.clone()));
                proof.steps.push(Step::Transitive(vec![last, last + 1]));
                proof.statement.right = next;
            }
        }
        proof
    }
}

/// A term with 0 for all its values.
fn blank(term: &Term) -> Option<Term> {
    everywhere(term, &|_| Some(Value::zero()))
}

fn values_in(term: &Term, found: &mut Vec<Value>) {
    found.extend(term.values().cloned());
    term.children().for_each(|part| values_in(part, found));
}

fn everywhere(term: &Term, change: &dyn Fn(&Value) -> Option<Value>) -> Option<Term> {
    let parts = term.children().map(|part| everywhere(part, change)).collect::<Option<Vec<_>>>()?;
    let whole = if parts.is_empty() { term.clone() } else { term.with_children(parts) };
    whole.map_values(&mut |value| change(value).ok_or(())).ok()
}

/// Why the run and the property, which agree, are no terms.
pub(super) fn unwritten(outcome: &Outcome) -> String {
    let why = outcome.unwritten.iter().map(|why| format!(": {why}"));
    format!("the run could not be written as a process, for the kernel to follow it{}", why.collect::<String>())
}
