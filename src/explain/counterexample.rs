//! A counterexample in words: what was taken, what both sides then do, and where they part.

use std::collections::{BTreeMap, BTreeSet};

use crate::bisimulation::{Difference, Side};
use crate::definition::Definitions;
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Model, Outcome, State};
use crate::name::Name;
use crate::proof::Statement;
use crate::refute::Counterexample;
use crate::sample::reached;
use crate::scope::{condition_mentions, read_names};
use crate::term::{Node, Term};
use crate::value::Value;

/// The counterexample to a claim as a story; of parameters that assumptions alone tie to the claim's nothing is said.
pub fn claim_lines(found: &Counterexample, statement: &Statement, definitions: &Definitions) -> Vec<String> {
    let mut names = BTreeSet::new();
    for term in [&statement.left, &statement.right] {
        names.extend(read_names(term));
        for definition in reached(term, definitions).iter().filter_map(|name| definitions.get(name)) {
            names.extend(read_names(&definition.body));
        }
    }
    let mut found = found.clone();
    found.values.retain(|name, _| {
        let supposed = statement.hypotheses.iter().any(|condition| condition_mentions(condition, name));
        name.is_meta() || names.contains(name) || supposed
    });
    run_lines(&found, statement.connective)
}

/// A side without the names that it does not read from its surroundings, and those that it does.
fn shorn(side: &Term) -> (Term, BTreeSet<Name>) {
    let none = Definitions::default();
    let model = Model::new(&none);
    let (mut inner, mut read) = (side, Vec::new());
    while let Node::Replace(body, name, value) = inner.node() {
        let known = BTreeMap::from([(name.clone(), value.clone())]);
        if !matches!(model.put_in(body, &known, 0), Ok(same) if same == *body) {
            read.push((name.clone(), value.clone()));
        }
        inner = body;
    }
    let names = read.iter().map(|(name, _)| name.clone()).collect();
    let around = |term: Term, (name, value): (Name, Value)| Term::new(Node::Replace(term, name, value));
    (read.into_iter().rev().fold(inner.clone(), around), names)
}

/// The counterexample as a story.
pub fn run_lines(found: &Counterexample, connective: Connective) -> Vec<String> {
    let ((left, mut read), (right, more)) = (shorn(&found.left), shorn(&found.right));
    read.extend(more);
    let mut lines = Vec::new();
    let mut chosen = instance(&found.processes, &found.values);
    chosen.extend(found.names.iter().map(|(name, image)| format!("{name} = {image}")));
    let around = found.surroundings.iter().filter(|(name, _)| read.contains(*name));
    chosen.extend(around.map(|(name, value)| format!("{name} = {value}")));
    if !chosen.is_empty() {
        lines.push(format!("take {}", chosen.join(", ")));
        lines.push(format!("then it says {left} {connective} {right}"));
    }
    for step in &found.run.steps {
        let who = match step.side {
            Side::Left => "left:  ",
            Side::Right => "right: ",
            Side::Both => "both:  ",
        };
        lines.push(format!("{who}{}", label(&step.label)));
    }
    lines.push(difference(&found.run.difference));
    lines
}

fn label(label: &Label) -> String {
    match label {
        Label::Wait(time) => format!("{time} of time passes"),
        Label::Act(Action::In(port), Some(value)) => format!("reads {value} from {port}"),
        Label::Act(Action::In(port), None) => format!("reads from {port}"),
        Label::Act(Action::Out(port, value), _) => format!("writes {value} to {port}"),
        Label::Act(Action::Tau(port, value), _) => format!("communicates {value} over {port}"),
        Label::Act(Action::Draw(from, _), Some(value)) => format!("draws {value} from {}", listed(from)),
        Label::Act(Action::Draw(from, _), None) => format!("draws from {}", listed(from)),
    }
}

fn difference(difference: &Difference) -> String {
    let side = |side: &Side| if *side == Side::Right { "right" } else { "left" };
    let other = |side: &Side| if *side == Side::Right { "left" } else { "right" };
    match difference {
        Difference::Outcome(left, right) => {
            format!("the left side {}, the right side {}", outcome(left), outcome(right))
        }
        Difference::Observations(left, right) => {
            format!("the left side shows {}, the right side shows {}", shown(left), shown(right))
        }
        Difference::Move(who, what) => {
            format!("the {} side {}, the {} side cannot", side(who), label(what), other(who))
        }
        Difference::Time(who) => format!("the {} side lets time pass, the {} side does not", side(who), other(who)),
        Difference::Chances(..) => "the two sides draw with different chances".to_string(),
    }
}

fn outcome(outcome: &Outcome) -> String {
    match outcome {
        Outcome::Stop(results) if results.is_empty() => "has stopped".to_string(),
        Outcome::Stop(results) => {
            let results: Vec<String> = results.iter().map(|(name, value)| format!("{name} = {value}")).collect();
            format!("has stopped with {}", results.join(", "))
        }
        Outcome::Abort => "has aborted".to_string(),
        Outcome::Running => "still runs".to_string(),
    }
}

fn shown(state: &State) -> String {
    let shown: Vec<String> = state
        .observations()
        .into_iter()
        .map(|(name, values)| Term::new(Node::Observe(name, values)).to_string())
        .collect();
    if shown.is_empty() { "nothing".to_string() } else { shown.join(", ") }
}

fn listed(values: &[Value]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// The metavariables of a law with what they stand for, for a person.
pub fn instance(processes: &BTreeMap<Name, Term>, values: &BTreeMap<Name, Value>) -> Vec<String> {
    let processes = processes.iter().map(|(name, term)| format!("{name} = {term}"));
    processes.chain(values.iter().map(|(name, value)| format!("{name} = {value}"))).collect()
}
