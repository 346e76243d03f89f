//! One claim: the prover, the kernel, and the model where the prover has no answer.

use std::sync::Arc;

use super::reading::{Run, Waiting, names_in};
use super::{Evidence, Record};
use crate::lower::{Claim, ClaimKind, Environment, Expectation};
use crate::name::Name;
use crate::report::{Expected, Report, Verdict};
use crate::stepper::Apart;
use crate::value::Relation;

/// The name under which the round of a loop is expected: `t1` for `?t1`.
fn same_name(found: &Name, expected: &Name) -> bool {
    found.as_str().trim_start_matches('?') == expected.as_str().trim_start_matches('?')
}

/// Which expectations a report meets. Values are compared under the assumptions of the environment.
pub(super) fn expectations(
    report: &Report,
    environment: &Environment,
    expected: &[(Expectation, String)],
) -> Vec<Expected> {
    let mut result = Vec::new();
    for (expectation, text) in expected {
        let verdict = |verdict: Verdict| Expected { text: text.clone(), met: report.verdict == verdict };
        match expectation {
            Expectation::Proved => result.push(verdict(Verdict::Proved)),
            Expectation::Refuted => result.push(verdict(Verdict::Refuted)),
            Expectation::Met => result.push(verdict(Verdict::Met)),
            Expectation::NotMet => result.push(verdict(Verdict::NotMet)),
            Expectation::Open => result.push(verdict(Verdict::Open)),
            Expectation::Term(_) | Expectation::Answer(_) | Expectation::Never => {
                result.push(Expected { text: text.clone(), met: false })
            }
            Expectation::Values(values) => result.extend(values.iter().map(|(name, value)| {
                let found = report.values.iter().find(|(found, _)| same_name(found, name));
                let met = found.is_some_and(|(_, found)| {
                    found == value || environment.assumptions.decide(Relation::Eq, found, value) == Some(true)
                });
                Expected { text: format!("{name} = {value}"), met }
            })),
        }
    }
    result
}

/// What came of a claim, before it is numbered.
#[derive(Default)]
pub(super) struct Found {
    pub(super) verdict: Option<Verdict>,
    pub(super) evidence: Option<Evidence>,
    pub(super) values: Vec<(Name, crate::value::Value)>,
    pub(super) steady: Vec<(Name, crate::value::Value)>,
    pub(super) trace: Vec<String>,
    pub(super) feedback: Vec<String>,
    pub(super) remains: Vec<String>,
    pub(super) trusted: Vec<String>,
    pub(super) chance: Option<crate::report::Chance>,
    pub(super) diagnostics: Vec<(crate::diagnostic::Source, crate::diagnostic::Diagnostic)>,
    pub(super) it: Option<crate::term::Term>,
    /// The sides of what refutes it, for the stepper.
    pub(super) apart: Option<Arc<Apart>>,
}

impl Run<'_, '_> {
    /// Settles a claim as far as it can be.
    pub(super) fn claim(&mut self, claim: &Claim, waiting: &Waiting) -> Record {
        let (kind, found) = match &claim.kind {
            ClaimKind::Compare { left, right, connective, when, by } => {
                let statement = crate::proof::Statement {
                    hypotheses: when.clone(),
                    left: left.clone(),
                    connective: *connective,
                    right: right.clone(),
                };
                (kind_of(*connective), self.compare(statement, by, waiting))
            }
            ClaimKind::Satisfies { system, property } => ("satisfies", self.satisfies(system, property, waiting)),
            ClaimKind::Always { system, pattern, property } => {
                ("always", self.always(system, pattern, property.as_ref(), waiting))
            }
            ClaimKind::Likely { likelihood, relation, threshold } => {
                ("probability", self.likely(likelihood, *relation, threshold, waiting))
            }
        };
        let verdict = found.verdict.unwrap_or(Verdict::Open);
        let mut report = Report {
            number: self.state.records.len() + 1,
            name: claim.name.clone(),
            file: waiting.file.clone(),
            line: waiting.line,
            claim: waiting.text.clone(),
            kind,
            verdict,
            values: found.values,
            steady: found.steady,
            chance: found.chance,
            trace: found.trace,
            feedback: found.feedback,
            remains: found.remains,
            diagnostics: found.diagnostics,
            apart: found.apart,
            interrupted: verdict == Verdict::Open && self.surroundings.interrupted(),
            ..Report::default()
        };
        if let Some(evidence) = &found.evidence {
            report.laws = evidence.theorem.lemmas().iter().chain(evidence.theorem.laws()).cloned().collect();
            report.trusted = evidence.theorem.trusted().iter().cloned().collect();
            for law in evidence.theorem.laws().iter().filter(|law| self.own.get(law).is_none()) {
                report.trusted.push(format!("the law {law}, which is not one of PARS's own"));
            }
        }
        report.trusted.extend(found.trusted.iter().cloned());
        report.expected = expectations(&report, &waiting.environment, &waiting.expected);
        if found.it.is_some() {
            self.state.it = found.it;
        }
        let mut uses = self.state.closure(names_in(&waiting.text));
        if let Some(evidence) = &found.evidence {
            let lemmas = evidence.theorem.lemmas();
            let named = |record: &&Arc<Record>| record.report.name.as_ref().is_some_and(|name| lemmas.contains(name));
            if !lemmas.is_empty() {
                uses.extend(self.state.records.iter().filter(named).flat_map(|record| record.uses.clone()));
            }
        }
        Record { report, evidence: found.evidence.map(Arc::new), uses, stale: None }
    }
}

/// What a comparison by this connective is called.
fn kind_of(connective: crate::law::Connective) -> &'static str {
    match connective {
        crate::law::Connective::Equal => "equality",
        crate::law::Connective::Refines => "refinement",
        crate::law::Connective::Weak => "weak equality",
        crate::law::Connective::WeaklyRefines => "weak refinement",
    }
}
