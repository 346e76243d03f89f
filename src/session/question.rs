//! Questions: the simplest form of a process, the period and the flow of a system, a projection.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::Asked;
use super::alike::Answered;
use super::compare::theory;
use super::reading::{Question, Run, Waiting};
use crate::fact::Context;
use crate::lower::{Environment, Expectation, Subject};
use crate::name::Name;
use crate::proof::{Proof, Script, Statement, Step};
use crate::prove::pruned;
use crate::report::{Answer, Expected, Output};
use crate::simplify::Simplifier;
use crate::term::{Node, Term};

impl Run<'_, '_> {
    pub(super) fn question(&mut self, waiting: &Waiting) -> Output {
        let mut answered = Answered::default();
        let (mut pictures, mut chance) = (Vec::new(), None);
        let (kind, lines, expected) = match &waiting.question {
            Question::Simplify(term) => self.simplified("simplify", term, waiting),
            Question::Project(subject, shown) => {
                let term = subject_term(subject, &waiting.environment);
                let term = Term::new(Node::Project(term, shown.clone()));
                self.simplified("project", &term, waiting)
            }
            Question::Period(name) => {
                let (lines, expected) = self.period(name, waiting);
                ("period", lines, expected)
            }
            Question::Flow(name) => {
                let (lines, expected) = self.flow(name, waiting);
                ("flow", lines, expected)
            }
            Question::Solve(solve) => {
                let (lines, expected) = super::solve::answer(solve, waiting, &|| self.surroundings.interrupted());
                let asked = Asked { question: (**solve).clone(), known: waiting.environment.assumptions.clone() };
                self.state.asked = Some((self.state.records.len(), Arc::new(asked)));
                ("solve", lines, expected)
            }
            Question::Probability(likelihood) => {
                pictures = self.pictures_of(likelihood, &waiting.environment);
                let (lines, found) = self.probability(likelihood, waiting);
                chance = found;
                ("probability", lines, Run::unmet(&waiting.expected))
            }
            Question::Claim(_) | Question::Criteria(_) | Question::Sweep(_) => ("claim", Vec::new(), Vec::new()),
            Question::Lts(subject, limits) => {
                answered = self.transition_system(&subject_term(subject, &waiting.environment), *limits, waiting);
                ("lts", std::mem::take(&mut answered.lines), Run::unmet(&waiting.expected))
            }
            Question::Minimise(subject, limits) => {
                answered = self.minimised(&subject_term(subject, &waiting.environment), *limits, waiting);
                ("minimise", std::mem::take(&mut answered.lines), Run::unmet(&waiting.expected))
            }
            Question::Alike(left, right, relation, limits) => {
                let terms = [left, right].map(|subject| subject_term(subject, &waiting.environment));
                answered = self.alike(&terms, *relation, *limits, waiting);
                ("compare", std::mem::take(&mut answered.lines), answered.expected(&waiting.expected))
            }
        };
        let (file, line, question) = (waiting.file.clone(), waiting.line, waiting.text.clone());
        if !answered.diagnostics.is_empty() {
            return Output::Trouble(waiting.source.clone(), answered.diagnostics);
        }
        let (verdict, apart) = (answered.verdict, answered.apart);
        Output::Answer(Box::new(Answer {
            file,
            line,
            kind,
            question,
            lines,
            table: Vec::new(),
            expected,
            verdict,
            chance,
            apart,
            pictures,
        }))
    }

    fn simplified(
        &mut self,
        kind: &'static str,
        term: &Term,
        waiting: &Waiting,
    ) -> (&'static str, Vec<String>, Vec<Expected>) {
        let theory = theory(&waiting.environment);
        let context = Context::new(&theory.assumptions, &theory.definitions, &[]);
        let interrupted = || self.surroundings.interrupted();
        let mut simplifier = Simplifier::new(&theory, &context, &interrupted);
        let simple = simplifier.simplify(term);
        let laws = laws_of(std::mem::take(&mut simplifier.script), simple.step, term, &simple.term);
        let mut lines = vec![format!("= {}", simple.term)];
        if !laws.is_empty() {
            let laws: Vec<&str> = laws.iter().map(Name::as_str).collect();
            lines.push(format!("by {}", laws.join(", ")));
        }
        if simplifier.exhausted() {
            lines.push("stopped before the simplest form was reached".to_string());
        }
        let expected = waiting
            .expected
            .iter()
            .map(|(expectation, text)| {
                let met = match expectation {
                    Expectation::Term(wanted) => {
                        *wanted == simple.term || simplifier.simplify(wanted).term == simple.term
                    }
                    _ => false,
                };
                Expected { text: text.clone(), met }
            })
            .collect();
        self.state.it = Some(simple.term);
        (kind, lines, expected)
    }
}

/// The process that a projection is of.
fn subject_term(subject: &Subject, environment: &Environment) -> Term {
    match subject {
        Subject::Term(term) => term.clone(),
        Subject::System(name) => {
            environment.system(name).map_or_else(Term::stop, |system| system.term(&environment.definitions))
        }
    }
}

/// The laws that the steps up to this one rest on.
fn laws_of(mut script: Script, last: usize, left: &Term, right: &Term) -> BTreeSet<Name> {
    script.steps.truncate(last + 1);
    let statement = Statement {
        hypotheses: Vec::new(),
        left: left.clone(),
        connective: crate::law::Connective::Equal,
        right: right.clone(),
    };
    let proof: Proof = pruned(&script.finish(statement));
    let named = |step: &Step| if let Step::Law(name, _) = step { Some(name.clone()) } else { None };
    proof.steps.iter().filter_map(named).collect()
}
