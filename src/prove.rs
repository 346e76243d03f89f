//! Proving a claim: by simplification, then by saturation; every success goes through the kernel.

mod lemma;
mod opened;
mod recursion;
pub mod run;
mod stepwise;

pub use lemma::{Earlier, prove_from};

use crate::fact::Context;
use crate::kernel::{Rejected, Theory, Thm, check};
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Proof, Script, Statement, Step, StepId};
use crate::refine::{equal, refine};
use crate::rewrite::{Ended, Limits, Saturation};
use crate::simplify::Simplifier;
use crate::term::Term;

/// What came of a claim. There is no "false" here: only a run can show that.
#[derive(Clone, Debug)]
pub enum Answer {
    /// Proved, and the kernel has checked it.
    Proved(Box<Thm>, Box<Proof>),
    /// Not proved.
    Open(Gap),
}

/// What remains of a claim that could not be proved.
#[derive(Clone, Debug)]
pub struct Gap {
    /// The simplest form of the left side.
    pub left: Term,
    /// The simplest form of the right side.
    pub right: Term,
    /// Why the search ended.
    pub ended: Ended,
    /// The e-classes and e-nodes looked at.
    pub size: (usize, usize),
    /// What the kernel said, should it have turned a proof away.
    pub rejected: Option<Rejected>,
    /// For a calculation: the number of the step that could not be proved, from 1.
    pub step: Option<usize>,
}

/// The road to take.
#[derive(Clone, Debug)]
pub enum By<'a> {
    /// All laws.
    Search,
    /// These laws alone.
    Laws(&'a [Name]),
    /// Line by line: each with its laws (none: all).
    Calculation(&'a [(Connective, Vec<Name>, Term)]),
}

/// Proves `left connective right` under hypotheses.
pub fn prove(
    theory: &Theory,
    statement: &Statement,
    by: &By<'_>,
    limits: Limits,
    interrupted: &dyn Fn() -> bool,
) -> Answer {
    match find(theory, statement, by, limits, interrupted) {
        Err(gap) => Answer::Open(gap),
        Ok(proof) => judged(theory, proof),
    }
}

/// A proof as the search finds it: the kernel has not seen it.
fn find(
    theory: &Theory,
    statement: &Statement,
    by: &By<'_>,
    limits: Limits,
    interrupted: &dyn Fn() -> bool,
) -> Result<Proof, Gap> {
    let context = Context::new(&theory.assumptions, &theory.definitions, &statement.hypotheses);
    let search = Search { theory, context: &context, limits, interrupted };
    let mut script = Script::default();
    let step = match by {
        By::Search => search.one(&statement.left, statement.connective, &statement.right, None, &mut script),
        By::Laws(laws) => search.one(&statement.left, statement.connective, &statement.right, Some(laws), &mut script),
        By::Calculation(lines) => search.calculation(statement, lines, &mut script),
    }?;
    if step + 1 != script.steps.len() {
        script.push(Step::Transitive(vec![step]));
    }
    Ok(pruned(&script.finish(statement.clone())))
}

fn judged(theory: &Theory, proof: Proof) -> Answer {
    match check(theory, &proof) {
        Ok(theorem) => Answer::Proved(Box::new(theorem), Box::new(proof)),
        Err(rejected) => {
            let (left, right) = (proof.statement.left, proof.statement.right);
            let ended = Ended::Limit;
            Answer::Open(Gap { left, right, ended, size: (0, 0), rejected: Some(rejected), step: None })
        }
    }
}

struct Search<'a> {
    theory: &'a Theory,
    context: &'a Context<'a>,
    limits: Limits,
    interrupted: &'a dyn Fn() -> bool,
}

impl Search<'_> {
    fn simplifier(&self, only: Option<&[Name]>, script: &mut Script) -> Simplifier<'_> {
        let simplifier = Simplifier::new(self.theory, self.context, self.interrupted);
        let mut simplifier = match only {
            Some(laws) => simplifier.only(laws),
            None => simplifier,
        };
        simplifier.script = std::mem::take(script);
        simplifier
    }

    fn one(
        &self,
        left: &Term,
        connective: Connective,
        right: &Term,
        only: Option<&[Name]>,
        script: &mut Script,
    ) -> Result<StepId, Gap> {
        if left == right {
            return Ok(script.push(Step::Reflexive(left.clone())));
        }
        let mut simplifier = self.simplifier(only, script);
        if connective.is_weak() {
            simplifier = simplifier.weakly(only);
        }
        let (one, two) = (simplifier.simplify(left), simplifier.simplify(right));
        let joined = match connective {
            _ if one.term == two.term => Some(simplifier.script.push(Step::Reflexive(one.term.clone()))),
            _ if connective.refines() => refine(&one.term, &two.term, &mut simplifier, self.context),
            _ => None,
        };
        let direct = match joined {
            None if connective.refines() => refine(left, right, &mut simplifier, self.context)
                .or_else(|| self.stepwise(left, right, &self.refinements(connective, only), &mut simplifier)),
            _ => None,
        };
        let opened = match (joined, direct, only) {
            (None, None, None) if connective == Connective::Equal => self.written_out(left, right, &mut simplifier),
            _ => None,
        };
        *script = std::mem::take(&mut simplifier.script);
        if let Some(step) = opened {
            return Ok(step);
        }
        if let Some(step) = joined {
            let back = script.push(Step::Symmetric(two.step));
            return Ok(script.chain(vec![one.step, step, back]));
        }
        if let Some(step) = direct {
            return Ok(step);
        }
        if (connective, only) == (Connective::Equal, None)
            && let Some(step) = self.recursively(left, right, script)
        {
            return Ok(step);
        }
        let mut saturation = Saturation::new(self.theory, self.context, only, self.limits, self.interrupted);
        let found = if connective.is_weak() {
            saturation = saturation.weakly();
            saturation.search(&one.term, &two.term, script).map(|step| {
                let back = script.push(Step::Symmetric(two.step));
                script.chain(vec![one.step, step, back])
            })
        } else {
            saturation.search(left, right, script)
        };
        found.map_err(|ended| Gap {
            left: one.term.clone(),
            right: two.term.clone(),
            ended,
            size: saturation.size(),
            rejected: None,
            step: None,
        })
    }

    fn calculation(
        &self,
        statement: &Statement,
        lines: &[(Connective, Vec<Name>, Term)],
        script: &mut Script,
    ) -> Result<StepId, Gap> {
        let mut current = statement.left.clone();
        let mut chain = vec![script.push(Step::Reflexive(current.clone()))];
        for (number, (connective, laws, term)) in lines.iter().enumerate() {
            let only = if laws.is_empty() { None } else { Some(laws.as_slice()) };
            let step = self.one(&current, *connective, term, only, script);
            chain.push(step.map_err(|gap| Gap { step: Some(number + 1), ..gap })?);
            current = term.clone();
        }
        if current != statement.right {
            let step = self.one(&current, Connective::Equal, &statement.right, None, script);
            chain.push(step.map_err(|gap| Gap { step: Some(lines.len() + 1), ..gap })?);
        }
        Ok(script.chain(chain))
    }
}

/// The proof without the steps that its conclusion does not use.
pub fn pruned(proof: &Proof) -> Proof {
    let mut used = vec![false; proof.steps.len()];
    if let Some(last) = used.last_mut() {
        *last = true;
    }
    for number in (0..proof.steps.len()).rev() {
        if used[number] {
            for earlier in proof.steps[number].uses() {
                if earlier < number {
                    used[earlier] = true;
                }
            }
        }
    }
    let mut renumbered = vec![0; proof.steps.len()];
    let mut steps: Vec<Step> = Vec::new();
    for (number, step) in proof.steps.iter().enumerate().filter(|(number, _)| used[*number]) {
        renumbered[number] = steps.len();
        steps.push(step.renumbered(&renumbered));
    }
    Proof { lemmas: proof.lemmas.clone(), statement: proof.statement.clone(), steps }
}

/// A claim of equality without hypotheses.
pub fn equation(left: Term, right: Term) -> Statement {
    Statement { hypotheses: Vec::<Condition>::new(), left, connective: Connective::Equal, right }
}

/// Whether simplification alone makes two terms the same; used where a full search would be too much.
pub fn same_form(theory: &Theory, left: &Term, right: &Term) -> bool {
    let context = Context::new(&theory.assumptions, &theory.definitions, &[]);
    let never = || false;
    equal(left, right, &mut Simplifier::new(theory, &context, &never)).is_some()
}
