//! Periods and flow functions as the paper prints them (§V.A): the components' periods, and one table a phase.

mod carried;
mod drawn;
mod folded;
mod named;
mod whole;

use std::collections::{BTreeMap, BTreeSet};

pub use carried::Carried;
pub use folded::{folded, value_folded};
pub use named::Named;

use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, Solved, term};
use crate::definition::{Definition, Definitions};
use crate::lower::Environment;
use crate::name::Name;
use crate::period::graph::ending;
use crate::period::{Edge, Next, Period, Segment, Test, in_case, in_case_after, stretch, told_after};
use crate::recurrence::{Apart, Closed, Comparison, InCase, solve_all, solve_apart, solve_in_cases};
use crate::scope::calls;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// The communications of a round that a table lists.
const MOST_LISTED: usize = 40;

/// The period of a looping definition: what stands between the equals sign and the recursion.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ComponentPeriod {
    /// Its name.
    pub name: Name,
    /// Its parameters.
    pub parameters: Vec<Name>,
    /// `P'`
    pub body: Term,
    /// The process that comes next, with the parameters' images; a cycle of definitions goes to another one.
    pub next: (Name, Vec<Value>),
}

impl ComponentPeriod {
    /// Its parameter-flow function: parameters with their images, where it calls itself.
    pub fn flow(&self) -> Option<Vec<(Name, Value)>> {
        (self.next.0 == self.name).then(|| self.parameters.iter().cloned().zip(self.next.1.iter().cloned()).collect())
    }

    /// `DEnv'_r = (Delay_t # At_r # Odo_r) ; In_v<u>` and `f_DEnv(r) = r+t*u`.
    pub fn lines(&self) -> Vec<String> {
        let parameters: Vec<Value> = self.parameters.iter().map(Value::variable).collect();
        let list = self.parameters.iter().map(Name::as_str).collect::<Vec<_>>().join(",");
        let head = match parameters.len() {
            0 => String::new(),
            1 => format!("_{list}"),
            _ => format!("_{{{list}}}"),
        };
        let mut lines = vec![format!("{}'{head} = {}", self.name, folded(&self.body))];
        if let Some(flow) = self.flow().filter(|flow| !flow.is_empty()) {
            let folded: Vec<Value> = flow.iter().map(|(_, image)| value_folded(image)).collect();
            let images = images(folded.iter());
            lines.push(format!("f_{}({list}) = {images}", self.name));
        }
        lines
    }
}

/// The periods of all looping definitions that the components reach, components first.
pub fn component_periods(components: &[Term], definitions: &Definitions) -> Vec<ComponentPeriod> {
    let mut seen = BTreeSet::new();
    let mut periods = Vec::new();
    let mut queue: std::collections::VecDeque<Name> = components.iter().flat_map(calls).collect();
    while let Some(name) = queue.pop_front() {
        let Some(definition) = definitions.get(&name).filter(|_| seen.insert(name.clone())) else { continue };
        periods.extend(component_period(definition));
        queue.extend(calls(&definition.body));
    }
    periods
}

fn component_period(definition: &Definition) -> Option<ComponentPeriod> {
    let Node::Seq(parts) = definition.body.node() else {
        return None;
    };
    let (last, body) = parts.split_last()?;
    let Node::Call(name, values) = last.node() else {
        return None;
    };
    definition.recursive.then(|| ComponentPeriod {
        name: definition.name.clone(),
        parameters: definition.parameters.clone(),
        body: Term::seq(body.iter().cloned()),
        next: (name.clone(), values.clone()),
    })
}

/// What passes in a round that comes back to its phase, or, where none does, on a way out of it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Way {
    /// When it is so.
    pub tests: Vec<Test>,
    /// What passes, with what is shown.
    pub segments: Vec<Segment>,
    /// Ports with the values that pass.
    pub communications: Vec<(Name, Value)>,
}

impl Way {
    fn of(edge: &Edge) -> Way {
        let (tests, segments) = (edge.tests.clone(), edge.segments.clone());
        Way { tests, segments, communications: edge.communications.clone() }
    }

    /// What passes, projected on the observers and time.
    pub fn period_term(&self) -> Term {
        passing(&self.segments)
    }

    /// Whether the same passes through the ports as in a round, where it is taken.
    fn communicates_as(&self, round: &Way) -> bool {
        let mut known = Assumptions::default();
        self.tests.iter().for_each(|test| known.assume(test.relation, &test.left, &test.right));
        let equal = |one: &Value, other: &Value| one == other || known.decide(Relation::Eq, one, other) == Some(true);
        let both = self.communications.iter().zip(&round.communications);
        self.communications.len() == round.communications.len()
            && both.into_iter().all(|((port, one), (other, value))| port == other && equal(one, value))
    }

    /// How long it takes, where that is known.
    pub fn duration(&self) -> Option<Value> {
        lasting(&self.segments)
    }
}

/// A way from a phase to another one, or to an end.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Exit {
    /// When it is taken.
    pub tests: Vec<Test>,
    /// Where it leads.
    pub next: Next,
    /// The variables of the next phase whose values the flow function of a round does not tell.
    pub map: Vec<(Name, Value)>,
    /// What passes with what is shown, where that is not as in the round.
    pub segments: Option<Vec<Segment>>,
}

impl Exit {
    fn of(edge: &Edge, rounds: &[&Edge]) -> Exit {
        let told = |(name, value): &(&Name, &Value)| match rounds {
            [] => **value == Value::variable(name),
            rounds => rounds.iter().all(|round| round.map.get(*name) == Some(*value)),
        };
        let map = edge.map.iter().filter(|one| !told(one)).map(|(name, value)| (name.clone(), value.clone())).collect();
        let other = rounds.iter().any(|round| round.segments != edge.segments);
        let segments = other.then(|| edge.segments.clone());
        Exit { tests: edge.tests.clone(), next: edge.next.clone(), map, segments }
    }

    /// What passes before it leads there, and how long that takes where it is known, where that is not as in the round.
    pub fn passing(&self) -> Option<(Term, Option<Value>)> {
        self.segments.as_ref().map(|segments| (passing(segments), lasting(segments)))
    }
}

fn lasting(segments: &[Segment]) -> Option<Value> {
    segments.iter().try_fold(Value::zero(), |sum, segment| sum.add(&segment.duration).ok())
}

fn passing(segments: &[Segment]) -> Term {
    Term::seq(segments.iter().map(|segment| stretch(&segment.duration, &segment.observed)))
}

/// One phase as a table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct PhaseFlow {
    /// The phase's number.
    pub phase: usize,
    /// What each component is about to do.
    pub control: Vec<String>,
    /// The state variables.
    pub variables: Vec<Name>,
    /// When a round is followed by another.
    pub guard: Vec<Vec<Test>>,
    /// What passes in each round; on each way out, where no round comes back.
    pub ways: Vec<Way>,
    /// The ways out on which something else passes through the ports than in a round.
    pub leaving: Vec<Way>,
    /// The flow function of a round that comes back; several where guards branch, each with its tests.
    pub maps: Vec<(Vec<Test>, BTreeMap<Name, Value>)>,
    /// What the parameters of its processes are before and after, where the phase does not come back to itself.
    pub carried: Vec<Carried>,
    /// Random draws: names for what is drawn, with the distribution.
    pub draws: Vec<(Name, Value)>,
    /// Where it goes on otherwise.
    pub exits: Vec<Exit>,
    /// What closed forms may call the start of each variable, and the number of a round.
    pub named: Named,
    /// The values with which it begins, where the whole run begins so and no other phase leads to it.
    pub begin: Option<BTreeMap<Name, Value>>,
}

/// The table of every phase.
pub fn flows(period: &Period, environment: &Environment) -> Vec<PhaseFlow> {
    let definitions = &environment.definitions;
    let spoken_of = named::spoken_of(period, environment);
    period
        .phases
        .iter()
        .enumerate()
        .map(|(number, phase)| {
            let rounds: Vec<&Edge> = phase.rounds(number).collect();
            let ways = if rounds.is_empty() { phase.edges.iter().collect() } else { rounds.clone() };
            let mut on = phase.edges.iter().filter(|edge| matches!(edge.next, Next::Phase(_)));
            let only = on.next().filter(|_| rounds.is_empty() && on.next().is_none());
            let carried = only.map_or_else(Vec::new, |edge| carried::carried(phase, edge, &period.phases, definitions));
            let ways: Vec<Way> = ways.into_iter().map(Way::of).collect();
            let leaving: Vec<&Edge> = phase.edges.iter().filter(|edge| edge.next != Next::Phase(number)).collect();
            let out = leaving.iter().map(|edge| Way::of(edge)).filter(|_| !rounds.is_empty());
            let other = |way: &Way| !ways.iter().any(|round| way.communicates_as(round));
            let out: Vec<Way> = out.filter(other).collect();
            let mut draws: Vec<(Name, Value)> = Vec::new();
            for draw in phase.edges.iter().flat_map(|edge| &edge.draws) {
                if !draws.contains(draw) {
                    draws.push(draw.clone());
                }
            }
            PhaseFlow {
                phase: number,
                control: phase.control.iter().map(Term::to_string).collect(),
                variables: phase.variables.clone(),
                guard: phase.guard(number),
                ways,
                leaving: out,
                maps: rounds.iter().map(|edge| (edge.tests.clone(), edge.map.clone())).collect(),
                carried,
                draws,
                exits: leaving.into_iter().map(|edge| Exit::of(edge, &rounds)).collect(),
                named: Named::of(period, number, &spoken_of),
                begin: whole::begin(period, number),
            }
        })
        .collect()
}

impl PhaseFlow {
    /// The rounds with what tells when they are so: one, without, where all pass alike.
    pub fn periods(&self) -> Vec<(&Way, &[Test])> {
        told_apart(&self.ways, |one, other| one.segments == other.segments)
    }

    /// The rounds with what passes through their ports, as [`PhaseFlow::periods`], and the ways out on which other things do.
    pub fn communications(&self) -> Vec<(&Way, &[Test])> {
        if !self.leaving.is_empty() {
            return self.ways.iter().chain(&self.leaving).map(|way| (way, way.tests.as_slice())).collect();
        }
        told_apart(&self.ways, |one, other| one.communications == other.communications)
    }

    /// The checked closed form of each variable that depends on no random draw, from a start that may be any
    /// number, and why others have none.
    pub fn recurrences(&self, index: &Name, assumptions: &Assumptions, stop: &dyn Fn() -> bool) -> Apart {
        let Some(map) = self.whole() else { return Apart { closed: Vec::new(), missing: Vec::new() } };
        let drawn = self.drawn();
        let changes = |(name, image): &(&Name, &Value)| **image != Value::variable(name) && !drawn.contains(*name);
        let changing: BTreeMap<Name, Value> =
            map.iter().filter(changes).map(|(name, image)| (name.clone(), image.clone())).collect();
        let starts = map.keys().map(|name| (name.clone(), self.named.start(name))).collect();
        solve_apart(&changing, &starts, index, &self.named.known(assumptions), stop)
    }

    /// The closed forms of all variables in each case of what is open for some, for the reasons that are given.
    pub fn recurrences_in_cases(
        &self,
        found: &Apart,
        index: &Name,
        assumptions: &Assumptions,
        stop: &dyn Fn() -> bool,
    ) -> Vec<InCase<Solved>> {
        let open = found.missing.iter().map(|(_, reason)| reason).find(|reason| reason.open.is_some());
        match open {
            Some(reason) => solve_in_cases(&self.recurrence(index), reason, assumptions, stop),
            None => Vec::new(),
        }
    }

    /// The checked closed forms as text, where one of them is no single value: a sum over the roots of a polynomial.
    pub fn sums(&self, index: &Name, assumptions: &Assumptions) -> Vec<String> {
        let solved = solve_all(self.recurrence(index), &self.named.known(assumptions));
        solved.map_or_else(|_| Vec::new(), |solved| solved.lines())
    }

    /// The recurrence of the variables that depend on no random draw, each from a symbolic start.
    pub fn recurrence(&self, index: &Name) -> Recurrence {
        let drawn = self.drawn();
        let sequences = self.steps(index).into_iter().filter(|(name, _)| !drawn.contains(name));
        let sequences =
            sequences.map(|(name, next)| Sequence { start: vec![self.named.start(&name)], name, next }).collect();
        Recurrence { index: index.clone(), from: 0, sequences }
    }

    /// A name for the number of a round: `n`, where nothing else is called so.
    pub fn index(&self) -> Name {
        self.named.index.clone()
    }

    /// The recurrence: each variable that changes with its next value, in the terms `r(n)` of the sequences.
    pub fn steps(&self, index: &Name) -> Vec<(Name, Value)> {
        let Some(map) = self.whole() else { return Vec::new() };
        let terms = map.keys().map(|name| (name.clone(), Value::variable(&term(name, index, 0)))).collect();
        let changes = map.iter().filter(|(name, image)| **image != Value::variable(name));
        changes.filter_map(|(name, image)| Some((name.clone(), image.substitute(&terms).ok()?))).collect()
    }

    /// The table, line by line.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("phase {}: {}", self.phase + 1, self.control.join(" | "))];
        for (way, tests) in self.periods() {
            if let Some(duration) = way.duration() {
                lines.push(format!("  period    {}, lasting {duration}{}", way.period_term(), in_case(tests)));
            }
        }
        for (tests, map) in &self.maps {
            let list = map.keys().map(Name::as_str).collect::<Vec<_>>().join(",");
            let images = images(map.values());
            let when = if self.maps.len() > 1 || self.guard.is_empty() { in_case(tests) } else { String::new() };
            lines.push(format!("  flow      f({list}) = {images}{when}"));
        }
        lines.extend(carried::line(&self.carried));
        for (name, distribution) in &self.draws {
            lines.push(format!("  draws     {name} from {distribution}"));
        }
        if !self.guard.is_empty() {
            let all = |tests: &Vec<Test>| tests.iter().map(Test::to_string).collect::<Vec<_>>().join(" and ");
            let ways: Vec<String> = self.guard.iter().map(all).collect();
            lines.push(format!("  again     while {} after the round", ways.join(", or ")));
        }
        lines.extend(self.exits.iter().map(|exit| self.exit_line(exit)));
        for (way, tests) in self.communications() {
            let (all, when) = (&way.communications, self.when(tests));
            let most = all.len().min(MOST_LISTED);
            let value = |value: &Value| match told_after(value, self.round(), false) {
                Some(after) => format!("{after} after the round"),
                None => value.to_string(),
            };
            lines.extend(all[..most].iter().map(|(port, passed)| format!("  port {port}    {}{when}", value(passed))));
            if let more @ 1.. = all.len() - most {
                lines.push(format!("  … and {more} more communications{when}"));
            }
        }
        lines
    }

    /// Where it goes on otherwise, with the variables of the next phase that no other line tells.
    fn exit_line(&self, exit: &Exit) -> String {
        let to = match &exit.next {
            Next::Phase(number) => format!("to phase {}", number + 1),
            Next::End(end) => ending(end),
        };
        let after = match exit.passing() {
            Some((term, Some(lasting))) => format!(" after {term}, lasting {lasting}"),
            Some((term, None)) => format!(" after {term}"),
            None => String::new(),
        };
        let all: Vec<String> = exit.map.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let carried = |(name, value): &(Name, Value)| {
            self.carried.iter().any(|one| one.parameter == *name && one.after == *value)
        };
        let with = if exit.map.iter().all(carried) { String::new() } else { format!(" with {}", all.join(", ")) };
        format!("  then      {to}{after}{with}{}", self.when(&exit.tests))
    }

    /// The map of a round.
    fn round(&self) -> Option<&BTreeMap<Name, Value>> {
        self.maps.first().map(|(_, map)| map)
    }

    fn when(&self, tests: &[Test]) -> String {
        in_case_after(tests, self.round())
    }
}

/// The images of a flow function; a condition that all of them ask is written once.
fn images<'a>(values: impl Iterator<Item = &'a Value> + Clone) -> String {
    let texts: Vec<String> = values.clone().map(Value::to_string).collect();
    if let [only] = texts.as_slice() {
        return only.clone();
    }
    let together = Value::vector(values.cloned().collect()).map(|vector| vector.to_string());
    together.ok().filter(|text| text.starts_with("if ")).unwrap_or_else(|| format!("({})", texts.join(", ")))
}

/// Each way with its tests; the first without, where all are alike.
fn told_apart(ways: &[Way], alike: impl Fn(&Way, &Way) -> bool) -> Vec<(&Way, &[Test])> {
    match ways {
        [first, others @ ..] if others.iter().all(|other| alike(first, other)) => vec![(first, &[])],
        _ => ways.iter().map(|way| (way, way.tests.as_slice())).collect(),
    }
}

/// What must hold for a closed form to be right, beyond what was assumed.
pub(crate) fn needed(closed: &Closed) -> Vec<Test> {
    let test =
        |(relation, left, right): &Comparison| Test { relation: *relation, left: left.clone(), right: right.clone() };
    closed.conditions.iter().map(test).collect()
}
