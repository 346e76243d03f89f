//! `criteria Name for Sys { … }`: each judged, with its margin; for those not met, what to do.

use std::sync::Arc;

use super::Record;
use super::always::{EVERY_WAY, WAYS};
use super::claim::expectations;
use super::likely::missed::missed;
use super::reading::{Run, Waiting, names_in};
use super::roughly::{closely, roughly};
use super::rounds::{Grounds, how_far};
use crate::criteria::blame::{Parts, blame};
use crate::criteria::repair::{MOST_PARAMETERS, Workshop};
use crate::criteria::{FEW_STRETCHES, Finding, Judge, MOST_STRETCHES, Measure, Standing};
use crate::invariant::PERIOD;
use crate::lower::{Ask, Criteria, Environment, System};
use crate::period::analyse;
use crate::report::{Assessment, Report, Verdict};

impl Run<'_, '_> {
    /// Judges criteria.
    pub(super) fn criteria(&mut self, criteria: &Criteria, waiting: &Waiting) -> Record {
        let uses = self.state.closure(names_in(&waiting.text));
        let assessment = self.assess(criteria, waiting, &uses);
        let findings = &assessment.findings;
        let standing = findings.iter().map(|finding| finding.standing).min().unwrap_or(Standing::Open);
        let verdict = match standing {
            Standing::Met => Verdict::Met,
            Standing::NotMet => Verdict::NotMet,
            Standing::Open => Verdict::Open,
        };
        let exact = |finding: &Finding| match &finding.value {
            Some(Measure::Exact(value)) => Some((finding.name.clone(), value.clone())),
            _ => None,
        };
        let mut trusted: Vec<String> = findings.iter().flat_map(|finding| finding.trusted.clone()).collect();
        trusted.dedup();
        let mut report = Report {
            number: self.state.records.len() + 1,
            name: Some(criteria.name.clone()),
            file: waiting.file.clone(),
            line: waiting.line,
            claim: format!("criteria {} for {}", criteria.name, criteria.system),
            kind: "criteria",
            verdict,
            values: findings.iter().filter_map(exact).collect(),
            trusted,
            trace: assessment.lines(),
            feedback: assessment.advice(),
            interrupted: standing == Standing::Open && self.surroundings.interrupted(),
            assessment: Some(Arc::new(assessment)),
            ..Report::default()
        };
        report.expected = expectations(&report, &waiting.environment, &waiting.expected);
        Record { report, evidence: None, uses, stale: None }
    }

    fn assess(
        &self,
        criteria: &Criteria,
        waiting: &Waiting,
        uses: &std::collections::BTreeSet<crate::name::Name>,
    ) -> Assessment {
        let environment = &waiting.environment;
        let interrupted = || self.surroundings.interrupted();
        let judge = Judge { chances: &closely, interrupted: &interrupted, stretches: MOST_STRETCHES, invariants: true };
        let mut judged = judge.judge(criteria, environment);
        if let Some(system) = environment.system(&criteria.system) {
            rest_on(&mut judged.findings, system, environment, &interrupted);
        }
        let mut parameters = environment.valued();
        parameters.retain(|(name, _)| uses.contains(name));
        parameters.truncate(MOST_PARAMETERS);
        let judge = Judge { stretches: FEW_STRETCHES, invariants: false, ..judge };
        let workshop = Workshop::new(judge, &roughly, criteria, environment, &judged, &parameters);
        let parts = Parts::of(criteria, environment, judged.run.stretches.len().saturating_mul(2).max(FEW_STRETCHES));
        let failing = judged.findings.iter().filter(|finding| finding.standing == Standing::NotMet).map(|finding| {
            let mut lines = parts.as_ref().map(|parts| blame(criteria, finding, &judged, parts)).unwrap_or_default();
            let own = criteria.all.iter().find(|one| one.name == finding.name);
            if let Some(Ask::Probability { likelihood, .. }) = own.map(|one| &one.kind) {
                lines.splice(0..0, missed(likelihood, environment));
            }
            (finding, lines)
        });
        let advice = workshop.advice(failing.collect());
        let sensitivities = workshop.sensitivities();
        let run = judged.run.clone();
        Assessment { criteria: criteria.clone(), findings: judged.findings, run, advice, sensitivities }
    }
}

/// Of findings that rest on the phases: how far the kernel has checked these.
fn rest_on(findings: &mut [Finding], system: &System, environment: &Environment, interrupted: &dyn Fn() -> bool) {
    let on_phases = |finding: &Finding| finding.trusted.iter().any(|line| line == PERIOD);
    if !findings.iter().any(on_phases) {
        return;
    }
    let Ok(period) = analyse(&system.components, &environment.definitions, &environment.assumptions) else { return };
    let far = how_far(&period, system, environment, interrupted);
    for finding in findings.iter_mut().filter(|finding| on_phases(finding)) {
        if let Some(why) = far.open().filter(|_| finding.standing == Standing::Met) {
            finding.standing = Standing::Open;
            (finding.value, finding.margin) = (None, None);
            finding.trusted.retain(|line| line != PERIOD);
            finding.notes.push(why);
            continue;
        }
        let rest = match &far {
            Grounds::Less | Grounds::Undefined(_) | Grounds::Raced => PERIOD,
            Grounds::Ways => WAYS,
            Grounds::All => {
                finding.notes.push(EVERY_WAY.to_string());
                finding.trusted.retain(|line| line != PERIOD);
                continue;
            }
        };
        finding.trusted.iter_mut().filter(|line| *line == PERIOD).for_each(|line| *line = rest.to_string());
    }
}
