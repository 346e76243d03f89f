//! A counterexample in words: what was taken, what both sides then do, and where they part.

use std::collections::BTreeMap;

use crate::bisimulation::{Difference, Side};
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Outcome, State};
use crate::name::Name;
use crate::refute::Counterexample;
use crate::term::{Node, Term};
use crate::value::Value;

/// The counterexample as a story.
pub fn run_lines(found: &Counterexample, connective: Connective) -> Vec<String> {
    let mut lines = Vec::new();
    let mut chosen = instance(&found.processes, &found.values);
    chosen.extend(found.names.iter().map(|(name, image)| format!("{name} = {image}")));
    chosen.extend(found.surroundings.iter().map(|(name, value)| format!("{name} = {value}")));
    if !chosen.is_empty() {
        lines.push(format!("take {}", chosen.join(", ")));
    }
    lines.push(format!("then it says {} {connective} {}", found.left, found.right));
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
