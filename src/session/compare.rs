//! `P = Q` and `P <= Q`: proved, refuted by a small instance, or open with what remains.

use std::sync::Arc;

use super::claim::Found;
use super::reading::{Run, Waiting};
use super::{Evidence, at};
use crate::diagnostic::{Severity, Span};
use crate::explain::claim_lines;
use crate::kernel::Theory;
use crate::law::Connective;
use crate::lower::{By, CalcStep, Environment};
use crate::name::Name;
use crate::proof::Statement;
use crate::prove::{self, Answer, Gap, prove_from};
use crate::refute::{self, Counterexample, Refutation};
use crate::report::Verdict;
use crate::rewrite::{Ended, Limits};
use crate::stepper::Apart;
use crate::term::Term;

/// What a theorem may rest on in this environment.
pub(super) fn theory(environment: &Environment) -> Theory {
    Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    }
}

impl Run<'_, '_> {
    pub(super) fn compare(&mut self, statement: Statement, by: &By, waiting: &Waiting) -> Found {
        let theory = theory(&waiting.environment);
        let interrupted = || self.surroundings.interrupted();
        let lines: Vec<(Connective, Vec<Name>, Term)>;
        let by = match by {
            By::Search => prove::By::Search,
            By::Laws(laws) => prove::By::Laws(laws),
            By::Calc(steps) => {
                lines = steps.iter().map(|step| (step.connective, step.laws.clone(), step.term.clone())).collect();
                prove::By::Calculation(&lines)
            }
        };
        // What is plainly false is answered at once. A calculation is followed first: it has a step that is wrong.
        if !matches!(by, prove::By::Calculation(_)) {
            let limits = refute::Limits { instances: 200, choices: 4_000, cost: 6, pairs: 100, numbers: Vec::new() };
            if let Some(found) = refuted(&statement, waiting, &limits).counterexample() {
                return contradicted(found, &statement, waiting);
            }
        }
        let proved = match self.state.earlier(&by, &theory) {
            Ok(earlier) => prove_from(&theory, &earlier, &statement, &by, Limits::default(), &interrupted),
            Err(unproved) => Err(unproved),
        };
        let answer = match proved {
            Ok(answer) => answer,
            Err((name, why)) => {
                return Found { remains: vec![format!("`{name}` cannot be used: {why}")], ..Found::default() };
            }
        };
        match answer {
            Answer::Proved(theorem, proof) => {
                let it = Some(statement.right.clone());
                let environment = waiting.environment.clone();
                let evidence = Evidence { theory, environment, theorem: *theorem, proof: *proof };
                Found { verdict: Some(Verdict::Proved), evidence: Some(evidence), it, ..Found::default() }
            }
            Answer::Open(gap) => self.open(&statement, &gap, waiting),
        }
    }

    /// Looks for an instance that refutes the claim; if there is none, says what remains.
    fn open(&self, statement: &Statement, gap: &Gap, waiting: &Waiting) -> Found {
        if self.surroundings.interrupted() {
            return Found { remains: remains(gap, None, named(waiting, gap.step)), ..Found::default() };
        }
        let refutation = refuted(statement, waiting, &refute::Limits::default());
        let mut found = match refutation.counterexample() {
            Some(counterexample) => contradicted(counterexample, statement, waiting),
            None => Found { remains: remains(gap, Some(&refutation), named(waiting, gap.step)), ..Found::default() },
        };
        if let (Some(number), Some(steps)) = (gap.step, calculation(waiting)) {
            found.diagnostics = step_diagnostic(number, steps, waiting);
        }
        found
    }
}

fn refuted(statement: &Statement, waiting: &Waiting, limits: &refute::Limits) -> Refutation {
    let Statement { hypotheses, left, connective, right } = statement;
    let environment = &waiting.environment;
    refute::refute(left, right, *connective, hypotheses, &environment.definitions, &environment.assumptions, limits)
}

fn contradicted(found: &Counterexample, statement: &Statement, waiting: &Waiting) -> Found {
    let mut trace = claim_lines(found, statement, &waiting.environment.definitions);
    let apart = Apart::of(found, statement.connective);
    trace.extend(apart.lines());
    Found { verdict: Some(Verdict::Refuted), trace, apart: Some(Arc::new(apart)), ..Found::default() }
}

/// Whether the claim says by which laws.
fn named(waiting: &Waiting, step: Option<usize>) -> bool {
    if let (Some(steps), Some(step)) = (calculation(waiting), step) {
        return step.checked_sub(1).and_then(|index| steps.get(index)).is_some_and(|step| !step.laws.is_empty());
    }
    match &waiting.question {
        super::reading::Question::Claim(claim) => {
            matches!(&claim.kind, crate::lower::ClaimKind::Compare { by: By::Laws(_), .. })
        }
        _ => false,
    }
}

fn calculation(waiting: &Waiting) -> Option<&[CalcStep]> {
    match &waiting.question {
        super::reading::Question::Claim(claim) => match &claim.kind {
            crate::lower::ClaimKind::Compare { by: By::Calc(steps), .. } => Some(steps),
            _ => None,
        },
        _ => None,
    }
}

fn step_diagnostic(
    number: usize,
    steps: &[CalcStep],
    waiting: &Waiting,
) -> Vec<(crate::diagnostic::Source, crate::diagnostic::Diagnostic)> {
    let span = number.checked_sub(1).and_then(|index| steps.get(index)).map_or(Span::default(), |step| step.span);
    let text = format!("step {number} of the calculation could not be proved");
    let mut diagnostic = at("P0902", text, span, "this step");
    diagnostic.severity = Severity::Note;
    vec![(waiting.source.clone(), diagnostic.help("add a step between, or name no law to try all"))]
}

/// What is left of an open claim, and what was tried.
fn remains(gap: &Gap, refutation: Option<&Refutation>, named: bool) -> Vec<String> {
    let laws = if named { "the laws named" } else { "all laws" };
    let mut lines = vec![
        "what remains, in the simplest forms found:".to_string(),
        format!("  {}", gap.left),
        format!("  {}", gap.right),
    ];
    let (classes, nodes) = gap.size;
    lines.push(match (&gap.rejected, gap.ended) {
        (Some(rejected), _) => format!("a proof was found, but the kernel turned it down: {}", rejected.reason),
        (None, Ended::Saturated) => format!("tried: {laws}, until nothing new came ({classes} classes, {nodes} nodes)"),
        (None, Ended::Limit) => {
            format!("tried: {laws}, up to the limit of the search ({classes} classes, {nodes} nodes)")
        }
        (None, Ended::Interrupted) => format!("stopped by you after {classes} classes, {nodes} nodes"),
    });
    if let Some(Refutation::None { instances, cost, cut, open, .. }) = refutation {
        let how = if *cut { "not all of them" } else { "all in the list of candidates" };
        lines.push(match instances {
            0 => "no small instance meets the conditions, so none could be tried".to_string(),
            1 if *cost == 0 => format!(
                "no counterexample: 1 instance was tried{}; `compare … ~ …` asks the model alone",
                undecided(*open)
            ),
            1 => format!("no counterexample: 1 instance was tried{}", undecided(*open)),
            _ => format!(
                "no counterexample among {instances} small instances (up to size {cost}, {how}){}",
                undecided(*open)
            ),
        });
    }
    lines
}

/// How many of the instances tried were not decided either.
fn undecided(open: usize) -> String {
    match open {
        0 => String::new(),
        1 => ", and 1 comparison was not decided".to_string(),
        _ => format!(", and {open} comparisons were not decided"),
    }
}
