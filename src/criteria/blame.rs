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
        self.covers(time)?;
        let before = |start: &Value| run.decide(Relation::Lte, start, time) == Some(true);
        let stretch = run.stretches.iter().rev().find(|stretch| before(&stretch.start))?;
        let number = stretch.phase.unwrap_or(0);
        Some((number + 1, period.phases.get(number)?))
    }

    /// Whether the phases were followed up to a time.
    fn covers(&self, time: &Value) -> Option<()> {
        let run = self.trail.as_ref()?;
        let last = run.stretches.last()?;
        let Some(duration) = &last.duration else { return Some(()) };
        let end = last.start.add(duration).ok()?;
        (run.decide(Relation::Gte, &end, time)?).then_some(())
    }

    /// The phase that takes most of a span of time: of several that take the same, the first.
    fn longest(&self, from: &Value, to: &Value) -> Option<Spent> {
        let (period, run) = (self.period.as_ref()?, self.trail.as_ref()?);
        self.covers(to)?;
        let greater = |one: &Value, other: &Value| run.decide(Relation::Gtr, one, other);
        let mut all: BTreeMap<usize, Spent> = BTreeMap::new();
        for (place, stretch) in run.stretches.iter().enumerate() {
            let start = if greater(from, &stretch.start)? { from.clone() } else { stretch.start.clone() };
            let mut end = to.clone();
            if let Some(duration) = &stretch.duration {
                let own = stretch.start.add(duration).ok()?;
                end = if greater(to, &own)? { own } else { end };
            }
            if greater(&end, &start)? {
                let phase = stretch.phase.unwrap_or(0);
                let spent =
                    all.entry(phase).or_insert(Spent { phase, time: Value::zero(), first: place, end: end.clone() });
                spent.time = spent.time.add(&end.sub(&start).ok()?).ok()?;
                spent.end = end;
            }
        }
        let mut most: Option<Spent> = None;
        for spent in all.into_values() {
            let more = match &most {
                None => true,
                Some(other) if greater(&spent.time, &other.time)? => true,
                Some(other) => !greater(&other.time, &spent.time)? && spent.first < other.first,
            };
            if more {
                most = Some(spent);
            }
        }
        most.filter(|most| most.phase < period.phases.len())
    }

    /// How many phases there are.
    fn phases(&self) -> usize {
        self.period.as_ref().map_or(0, |period| period.phases.len())
    }
}

/// What of a span of time is spent in one phase.
struct Spent {
    /// The phase, from 0.
    phase: usize,
    /// How long.
    time: Value,
    /// The first of its stretches.
    first: usize,
    /// When it is left for the last time.
    end: Value,
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
    let longest = finding.moment.as_ref().and_then(|moment| longest(judged, moment, parts));
    if let Some(moment) = &finding.moment {
        lines.push(when(criteria, criterion.name.as_str(), judged, moment));
        lines.extend(in_phase(moment, longest.as_ref(), parts, &commanders));
    }
    for (writer, port) in commanders {
        let name = &parts.ports.names[writer];
        // What is commanded as a phase ends is told before the stretch after it.
        let command = finding.moment.as_ref().and_then(|moment| {
            let stretch = longest.as_ref().and_then(|(spent, _)| begun(&judged.run, &spent.end));
            last_command(&judged.run, stretch.unwrap_or(moment.stretch), &port)
        });
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

/// What takes most of the span of time that a moment is about, which of a round is its longest leg.
fn longest(judged: &Judged, moment: &Moment, parts: &Parts) -> Option<(Spent, Value)> {
    let to = moment.to.as_ref()?;
    let (from, to) = leg_of(judged, moment).map_or((&moment.from, to), |leg| (&leg.from, &leg.to));
    Some((parts.longest(from, to)?, to.sub(from).ok()?))
}

/// The phase in which it is decided, with what gives the commands there.
fn in_phase(moment: &Moment, longest: Option<&(Spent, Value)>, parts: &Parts, who: &[(usize, Name)]) -> Option<String> {
    let (number, phase, part) = match longest {
        Some((spent, whole)) => {
            let part = if spent.time == *whole { String::new() } else { format!(", for {} of {whole}", spent.time) };
            (spent.phase + 1, parts.period.as_ref()?.phases.get(spent.phase)?, part)
        }
        None => parts.phase(&moment.from).map(|(number, phase)| (number, phase, String::new()))?,
    };
    let doing = who.iter().filter_map(|(writer, _)| {
        Some(format!(": {} at {}", parts.ports.names.get(*writer)?, phase.control.get(*writer)?))
    });
    Some(format!("in phase {number} of {}{part}{}", parts.phases(), doing.collect::<String>()))
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

/// The last stretch that begins at a time, or before.
fn begun(run: &Timeline, time: &Value) -> Option<usize> {
    run.stretches.iter().rposition(|stretch| run.decide(Relation::Lte, &stretch.start, time) == Some(true))
}

/// The last value that passed on a port up to a stretch, with its time.
fn last_command(run: &Timeline, stretch: usize, port: &Name) -> Option<(Value, Value)> {
    let stretches = run.stretches.iter().take(stretch + 1);
    stretches.rev().find_map(|stretch| {
        let (_, value) = stretch.before.iter().rev().find(|(other, _)| other == port)?;
        Some((stretch.start.clone(), value.clone()))
    })
}
