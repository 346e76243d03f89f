//! Legs and rounds of which there is no end, where the places never repeat and the times do.

use std::cell::Cell;
use std::collections::BTreeSet;

use super::super::{Finding, Standing, visits};
use super::{Scene, exact};
use crate::invariant::PERIOD;
use crate::lower::{Ask, Criterion};
use crate::name::Name;
use crate::period::analyse_until;
use crate::timeline::turns::turns;

/// Communications that are followed to find the phases.
const MOST_LOOKS: usize = 20_000;

impl Scene<'_> {
    /// Those of these criteria about every leg or every round that are met by turns that come again and again.
    pub(in super::super) fn by_turns(&self, open: &[&Criterion]) -> Vec<Finding> {
        let every =
            |one: &&&Criterion| matches!(one.kind, Ask::Leg { every: true, .. } | Ask::Round { every: true, .. });
        let asked: Vec<&&Criterion> = open.iter().filter(every).collect();
        if asked.is_empty() || self.run.stretches.is_empty() {
            return Vec::new();
        }
        let (definitions, known) = (&self.environment.definitions, &self.environment.assumptions);
        let interrupted = self.judge.interrupted;
        // Where the phases are very many, nothing is found out by them in good time.
        let looks = Cell::new(0usize);
        let enough = || looks.replace(looks.get() + 1) > MOST_LOOKS || interrupted();
        let Ok(period) = analyse_until(&self.system.components, definitions, known, &enough) else {
            return Vec::new();
        };
        let observers: BTreeSet<Name> = self.criteria.goals.iter().map(|goal| goal.observer.clone()).collect();
        let Some(run) = turns(&period, (definitions, known), &observers, interrupted) else { return Vec::new() };
        let visits = visits(&run, &self.criteria.goals, &exact(&self.criteria.radius));
        let scene = Scene { run: &run, visits: &visits, ..*self };
        let found = asked.into_iter().filter_map(|one| scene.on_the_run(one));
        let met = found.filter(|finding| finding.standing == Standing::Met);
        met.map(|mut finding| {
            finding.notes.push("the places differ from turn to turn, the times do not".to_string());
            finding.trusted.push(PERIOD.to_string());
            finding
        })
        .collect()
    }
}
