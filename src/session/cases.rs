//! A run that was found for either order of two values: a proof of each order, and from those one of both.

use super::matched::{RUN, followed, with_run};
use super::satisfies::said;
use crate::kernel::{Theory, Thm, check};
use crate::law::{Condition, Connective};
use crate::period::Period;
use crate::proof::{Proof, Statement, Step};
use crate::prove::run::{Lost, either};
use crate::prove::{Answer, By, prove};
use crate::rewrite::Limits;
use crate::term::Term;
use crate::value::{Relation, Value};
use crate::verify::{Apart, Outcome};

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
            return self.both(apart, hypotheses, lost);
        }
        let (Some(run), Some(own)) = (&outcome.trajectory_term, &outcome.property_term) else {
            return Err(unwritten(outcome));
        };
        let (left, right) = (run.clone(), own.clone());
        let statement = Statement { hypotheses: hypotheses.to_vec(), left, connective: Connective::Refines, right };
        let Answer::Proved(_, matched) =
            prove(self.theory, &statement, &By::Search, Limits::default(), self.interrupted)
        else {
            return Err("the run of the system could not be proved to match the property".to_string());
        };
        let stages = outcome.stages_of(self.period);
        let proof = match followed(self.theory, (self.whole, run), &matched, &stages) {
            Ok((_, proof)) => proof,
            Err(why) => {
                let cases: Vec<String> = hypotheses.iter().map(ToString::to_string).collect();
                lost.push(format!("where {}: {}", cases.join(", "), said(&why)));
                with_run(self.whole.clone(), run, *matched, RUN)
            }
        };
        Ok(self.as_wanted(proof))
    }

    /// The same proof, of what is written for all orders.
    fn as_wanted(&self, mut proof: Proof) -> Proof {
        if proof.statement.right != *self.wanted {
            let last = proof.steps.len().saturating_sub(1);
            proof.steps.push(Step::Arithmetic(proof.statement.right.clone(), self.wanted.clone()));
            proof.steps.push(Step::Transitive(vec![last, last + 1]));
            proof.statement.right = self.wanted.clone();
        }
        proof
    }
}

/// Why the run and the property, which agree, are no terms.
pub(super) fn unwritten(outcome: &Outcome) -> String {
    let why = outcome.unwritten.iter().map(|why| format!(": {why}"));
    format!("the run could not be written as a process, for the kernel to follow it{}", why.collect::<String>())
}
