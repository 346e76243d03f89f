//! Separating runs as traces for the stepper: `take 0`, `take 1 = 5`, `wait 1/2`, each line a choice.

use num_rational::BigRational;

use super::run::RunStep;
use super::way::{Node, shortest};
use crate::model::{Action, Model, State};
use crate::transition_system::{Inputs, Label};
use crate::value::Value;

/// States that are looked into for the way that one step takes.
const MOST_STATES: usize = 20_000;

/// What is chosen at one point of a run.
#[derive(Clone)]
enum Choice {
    Take(usize, Option<Value>),
    Wait(BigRational),
}

/// The choices that lead from the first state through the states after each step; none if no way was found. A step of
/// a weak comparison may take several choices.
pub(super) fn choices(
    model: &Model,
    inputs: &Inputs,
    start: &State,
    steps: &[RunStep],
    after: &dyn Fn(&RunStep) -> Option<State>,
    weak: bool,
) -> Option<Vec<String>> {
    let mut all: Vec<Choice> = Vec::new();
    let mut at = start.clone();
    for step in steps {
        let Some(target) = after(step) else { continue };
        let way = way(model, inputs, &at, &target, &step.label, weak)?;
        for choice in way {
            match (all.last_mut(), choice) {
                (Some(Choice::Wait(time)), Choice::Wait(more)) => *time += more,
                (_, choice) => all.push(choice),
            }
        }
        at = target;
    }
    let text = |choice: &Choice| match choice {
        Choice::Take(number, None) => format!("{}", number + 1),
        Choice::Take(number, Some(value)) => format!("{} = {value}", number + 1),
        Choice::Wait(time) => format!("wait {time}"),
    };
    Some(all.iter().map(text).collect())
}

/// A shortest way from one state to another that takes one step with this label, and internal steps if `weak`.
fn way(model: &Model, inputs: &Inputs, from: &State, to: &State, label: &Label, weak: bool) -> Option<Vec<Choice>> {
    // An internal step of a weak comparison may be none, and a look at what is shown is no step.
    let at_once = matches!(label, Label::Shows(_)) || (weak && *label == Label::Tau);
    shortest((from.clone(), at_once), to, MOST_STATES, |node| nexts(model, inputs, node, label, weak))
}

fn nexts(model: &Model, inputs: &Inputs, node: &Node, label: &Label, weak: bool) -> Option<Vec<(Node, Choice)>> {
    let mut found: Vec<(Node, Choice)> = Vec::new();
    for (number, step) in node.0.moves().ok()?.iter().enumerate() {
        let values: Vec<Option<&Value>> =
            if step.needs_value() { inputs.values.iter().map(Some).collect() } else { vec![None] };
        for value in values {
            let drawn = matches!(&step.action, Action::Draw(_, Some(_)));
            let made = match (&step.action, value) {
                // A draw that comes out in one way is no step.
                (Action::Draw(_, Some(_)), _) => Label::Tau,
                (Action::Tau(..), _) => Label::Tau,
                (Action::Out(port, sent), _) => Label::Act(format!("{port}!{sent}")),
                (Action::In(port), Some(value)) => Label::Act(format!("{port}?{value}")),
                _ => continue,
            };
            let taken = !node.1 && !drawn && made == *label;
            let between = drawn || (weak && made == Label::Tau);
            if !taken && !between {
                continue;
            }
            let next = value.map_or_else(|| step.next.clone(), |value| step.with(value));
            let next = model.state(&next).ok()?;
            found.push(((next, node.1 || taken), Choice::Take(number, value.cloned())));
        }
    }
    if let (Label::Wait(time), false) = (label, node.1)
        && let Some(next) = model.wait_state(&node.0, time).ok()?
    {
        found.push(((next, true), Choice::Wait(time.clone())));
    }
    Some(found)
}
