//! Runs that tell two processes apart, as steps that the stepper takes.

use super::Choice;
use crate::bisimulation::{Difference, Side};
use crate::definition::Definitions;
use crate::equivalence::way::{Node, shortest};
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Model, State};
use crate::refute::Counterexample;
use crate::term::Term;
use crate::value::Value;

/// States that are looked into for the way that one step takes.
const MOST_STATES: usize = 5_000;

/// A process, with the first steps of a run of it.
#[derive(Clone, Debug)]
pub struct Route {
    /// The process, closed.
    pub term: Term,
    /// What its calls refer to, closed.
    pub definitions: Definitions,
    /// The steps; no more than are known.
    pub choices: Vec<Choice>,
}

impl Route {
    /// The steps as they are typed: `1, 2 = 5, wait 1/2`.
    pub fn typed(&self) -> String {
        self.choices.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
    }
}

/// Two processes that differ, each with its side of a run that shows it.
#[derive(Clone, Debug)]
pub struct Apart {
    /// The left one.
    pub left: Route,
    /// The right one.
    pub right: Route,
    /// Whether what the other cannot do is done by the right one.
    pub right_first: bool,
}

/// The most steps of a side that are told; more of them are in the stepper.
const MOST_TOLD: usize = 40;

impl Apart {
    /// The steps of each side that has some, as they are typed.
    pub fn lines(&self) -> Vec<String> {
        let few = |route: &&Route| !route.choices.is_empty() && route.choices.len() <= MOST_TOLD;
        let line = |side: &str, route: &Route| format!("for the stepper, {side}: {}", route.typed());
        let sides = [("left", &self.left), ("right", &self.right)];
        sides.into_iter().filter(|(_, route)| few(route)).map(|(side, route)| line(side, route)).collect()
    }

    /// A counterexample with its run.
    pub fn of(found: &Counterexample, connective: Connective) -> Apart {
        let side = |term: &Term, after: &dyn Fn(&crate::bisimulation::Step) -> State| {
            let model = Model::new(&found.definitions);
            let mut choices = Vec::new();
            let mut at = model.state(term).ok();
            for step in &found.run.steps {
                let target = after(step);
                let way = at.and_then(|at| way(&model, &at, &target, &step.label, connective.is_weak()));
                let Some(way) = way else { break };
                choices.extend(way);
                at = Some(target);
            }
            Route { term: term.clone(), definitions: found.definitions.clone(), choices }
        };
        let right_first =
            matches!(&found.run.difference, Difference::Move(Side::Right, _) | Difference::Time(Side::Right));
        Apart {
            left: side(&found.left, &|step| step.left.clone()),
            right: side(&found.right, &|step| step.right.clone()),
            right_first,
        }
    }
}

/// A shortest way from one state to another by one step with this label, with internal steps around it if `weak`.
fn way(model: &Model<'_>, from: &State, to: &State, label: &Label, weak: bool) -> Option<Vec<Choice>> {
    // An internal step of a weak comparison may be answered by none.
    let at_once = weak && matches!(label, Label::Act(Action::Tau(..), _));
    shortest((from.clone(), at_once), to, MOST_STATES, |node| nexts(model, node, label, weak))
}

fn nexts(model: &Model<'_>, node: &Node, label: &Label, weak: bool) -> Option<Vec<(Node, Choice)>> {
    let mut found = Vec::new();
    for (number, step) in node.0.moves().ok()?.iter().enumerate() {
        let (same, value): (bool, Option<&Value>) = match label {
            Label::Act(action, value) => {
                let internal = matches!((&step.action, action), (Action::Tau(..), Action::Tau(..)));
                (internal || step.action == *action, value.as_ref())
            }
            Label::Wait(_) => (false, None),
        };
        let taken = same && !node.1 && step.needs_value() == value.is_some();
        let between =
            matches!(step.action, Action::Draw(_, Some(_))) || (weak && matches!(step.action, Action::Tau(..)));
        if !taken && !between {
            continue;
        }
        let value = value.filter(|_| taken && step.needs_value());
        let next = value.map_or_else(|| step.next.clone(), |value| step.with(value));
        found.push(((model.state(&next).ok()?, node.1 || taken), Choice::Take(number, value.cloned())));
    }
    if let (Label::Wait(time), false) = (label, node.1)
        && let Some(next) = model.wait_state(&node.0, time).ok()?
    {
        found.push(((next, true), Choice::Wait(time.clone())));
    }
    Some(found)
}
