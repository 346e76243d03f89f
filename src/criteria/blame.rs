//! What decides a criterion: the leg, the phase of the system, and the component that gives the commands there.

use std::collections::{BTreeMap, BTreeSet};

use super::{Finding, Judged, Leg, Measure, Moment};
use crate::definition::Definitions;
use crate::lower::{Ask, Criteria, Environment};
use crate::name::Name;
use crate::period::{self, Period, ports};
use crate::scope::subterms;
use crate::term::{Node, Term};
use crate::timeline::Timeline;
use crate::timeline::trail::trail;
use crate::value::{Relation, Value};

/// A system's components, as far as blame goes.
pub struct Parts {
    ports: ports::System,
    shows: Vec<BTreeSet<Name>>,
    /// Whether time passes in a component: one in which none does is a program.
    waits: Vec<bool>,
    period: Option<Period>,
    trail: Option<Timeline>,
}

impl Parts {
    /// The parts of the system that criteria are about.
    pub fn of(criteria: &Criteria, environment: &Environment, stretches: usize) -> Option<Parts> {
        let system = environment.system(&criteria.system)?;
        let components = ports::flatten(&system.components, &environment.definitions);
        let ports = ports::System::of(&components, &environment.definitions);
        let known = &environment.definitions;
        let (shows, waits) = components.iter().map(|component| shown_by(component, known)).unzip();
        let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions).ok();
        let trail = period.as_ref().map(|period| trail(period, &BTreeMap::new(), &environment.assumptions, stretches));
        Some(Parts { ports, shows, waits, period, trail })
    }

    /// The components that command what shows this observer, with the ports they do it by; a program that shows it itself
    /// commands those in which time passes.
    fn commanders(&self, observer: &Name) -> Vec<(usize, Name)> {
        let mut found = Vec::new();
        for (place, shown) in self.shows.iter().enumerate() {
            if !shown.contains(observer) {
                continue;
            }
            let own = self.ports.writes[place].iter();
            let own = own
                .filter(|port| (0..self.waits.len()).any(|to| self.waits[to] && self.ports.reads[to].contains(*port)));
            let own: Vec<(usize, Name)> = own.map(|port| (place, port.clone())).collect();
            if !self.waits[place] && !own.is_empty() {
                found.extend(own);
                continue;
            }
            for port in &self.ports.reads[place] {
                for (writer, writes) in self.ports.writes.iter().enumerate() {
                    if writer != place && writes.contains(port) {
                        found.push((writer, port.clone()));
                    }
                }
            }
        }
        found
    }

    /// The phase at a time, from 1, with what each component is about to do in it.
    fn phase(&self, time: &Value) -> Option<(usize, &period::Phase)> {
        let (period, run) = (self.period.as_ref()?, self.trail.as_ref()?);
        let before = |start: &Value| run.decide(Relation::Lte, start, time) == Some(true);
        let stretch = run.stretches.iter().rev().find(|stretch| before(&stretch.start))?;
        let number = stretch.phase.unwrap_or(0);
        Some((number + 1, period.phases.get(number)?))
    }

    /// How many phases there are.
    fn phases(&self) -> usize {
        self.period.as_ref().map_or(0, |period| period.phases.len())
    }
}

/// The observers that a component can show, and whether time passes in it.
fn shown_by(component: &Term, definitions: &Definitions) -> (BTreeSet<Name>, bool) {
    let (mut shown, mut waits) = (BTreeSet::new(), false);
    let mut seen = BTreeSet::new();
    let mut stack = vec![component.clone()];
    while let Some(term) = stack.pop() {
        for part in subterms(&term) {
            match part.node() {
                Node::Observe(name, _) => {
                    shown.insert(name.clone());
                }
                Node::Delay(_) => waits = true,
                Node::Call(name, _) => {
                    if let Some(definition) = definitions.get(name).filter(|_| seen.insert(name.clone())) {
                        stack.push(definition.body.clone());
                    }
                }
                _ => {}
            }
        }
    }
    (shown, waits)
}

/// What decides a criterion, in words: when, in which phase, by whose commands.
pub fn blame(criteria: &Criteria, finding: &Finding, judged: &Judged, parts: &Parts) -> Vec<String> {
    let Some(criterion) = criteria.all.iter().find(|one| one.name == finding.name) else { return Vec::new() };
    let observer = match &criterion.kind {
        Ask::Clearance { between, .. } => Some(between[0].0.clone()),
        Ask::Probability { likelihood, .. } => match &likelihood.event {
            crate::lower::Event::Shown { pattern, .. } => pattern.observers().into_iter().next(),
            crate::lower::Event::Satisfies(_) => None,
        },
        _ => criteria.goals.first().map(|goal| goal.observer.clone()),
    };
    let commanders = observer.as_ref().map(|observer| parts.commanders(observer)).unwrap_or_default();
    let mut lines = Vec::new();
    if let Some(moment) = &finding.moment {
        lines.push(when(criteria, criterion.name.as_str(), judged, moment));
        let time = if moment.to.is_some() { leg_start(judged, moment) } else { moment.from.clone() };
        if let Some((number, phase)) = parts.phase(&time) {
            let doing = commanders.iter().filter_map(|(writer, _)| {
                Some(format!(": {} at {}", parts.ports.names.get(*writer)?, phase.control.get(*writer)?))
            });
            lines.push(format!("in phase {number} of {}{}", parts.phases(), doing.collect::<String>()));
        }
    }
    for (writer, port) in commanders {
        let name = &parts.ports.names[writer];
        let command = finding.moment.as_ref().and_then(|moment| last_command(&judged.run, moment, &port));
        lines.push(match command {
            Some((time, value)) => {
                let value = Measure::Exact(value).readable();
                format!("commanded by {name} on port {port}: {value} at {time}")
            }
            None => format!("commanded by {name} on port {port}"),
        });
    }
    lines
}

/// When the leg begins that a moment is about.
fn leg_start(judged: &Judged, moment: &Moment) -> Value {
    leg_of(judged, moment).map_or_else(|| moment.from.clone(), |leg| leg.from.clone())
}

/// The leg that a moment is about, of the round that it lies in.
fn leg_of<'j>(judged: &'j Judged, moment: &Moment) -> Option<&'j Leg> {
    let not_before = |leg: &&Leg| judged.run.decide(Relation::Gte, &leg.from, &moment.from) == Some(true);
    let legs = || judged.visits.legs.iter().filter(|leg| Some(leg.goal) == moment.leg);
    legs().find(not_before).or_else(|| legs().next())
}

fn when(criteria: &Criteria, name: &str, judged: &Judged, moment: &Moment) -> String {
    let goal = moment.leg.and_then(|leg| criteria.goals.get(leg));
    match (&moment.to, goal) {
        (Some(to), Some(goal)) if name.starts_with("round") => {
            let longest = leg_of(judged, moment)
                .and_then(|leg| Some(format!(", longest the leg to {goal}: {}", leg.duration()?)));
            format!("from {} to {to}{}", moment.from, longest.unwrap_or_default())
        }
        (Some(to), Some(goal)) => format!("on the leg to {goal}, from {} to {to}", moment.from),
        (Some(to), None) => format!("from {} to {to}", moment.from),
        (None, Some(goal)) => format!("on the leg to {goal}, at {}", moment.from),
        (None, None) => format!("at {}", moment.from),
    }
}

/// The last value that passed on a port up to the stretch of a moment, with its time.
fn last_command(run: &Timeline, moment: &Moment, port: &Name) -> Option<(Value, Value)> {
    let stretches = run.stretches.get(..=moment.stretch)?;
    stretches.iter().rev().find_map(|stretch| {
        let (_, value) = stretch.before.iter().rev().find(|(other, _)| other == port)?;
        Some((stretch.start.clone(), value.clone()))
    })
}
