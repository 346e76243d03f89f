//! All that a closed term can do, as a finite graph, with what is wrong in it: deadlocks, livelocks, meaningless states.

use std::collections::HashMap;

use num_rational::BigRational;

use super::{Action, Meaningless, Model, Outcome, Patience, State};
use crate::definition::Definitions;
use crate::term::Term;
use crate::value::Value;

/// What one transition does.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Label {
    /// This much time passes.
    Wait(BigRational),
    /// A move; for a value that is read or drawn, with that value.
    Act(Action, Option<Value>),
}

/// A transition: from a state, by a label, to a state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Transition {
    /// Where it starts, as a place in [`Graph::states`].
    pub from: usize,
    /// What it does.
    pub label: Label,
    /// Where it ends.
    pub to: usize,
}

/// The states that a term can reach, and how.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// The states; the first is the start.
    pub states: Vec<State>,
    /// All transitions between them, in the order of their source.
    pub transitions: Vec<Transition>,
    /// False if the bound was hit: some states have not been looked into.
    pub complete: bool,
    /// The states from which nothing happens ever again though they have not ended.
    pub deadlocks: Vec<usize>,
    /// A state on a cycle of internal steps that takes no time, if there is one.
    pub livelock: Option<usize>,
}

/// What to explore with, and how far.
#[derive(Clone, Debug)]
pub struct Bounds {
    /// The most states.
    pub states: usize,
    /// The values that the surroundings may write to a port that is read.
    pub inputs: Vec<Value>,
}

impl Graph {
    /// Explores a term breadth first. Time passes from event to event.
    ///
    /// # Errors
    /// [`Meaningless`] where a reachable state has no meaning.
    pub fn of(term: &Term, definitions: &Definitions, bounds: &Bounds) -> Result<Graph, Meaningless> {
        let model = Model::new(definitions);
        let start = model.state(term)?;
        let mut graph = Graph { states: vec![start.clone()], complete: true, ..Graph::default() };
        let mut places = HashMap::from([(start, 0)]);
        let mut next = 0;
        while next < graph.states.len() {
            let state = graph.states[next].clone();
            let steps = successors(&model, &state, &bounds.inputs)?;
            if steps.is_empty() && state.outcome() == Outcome::Running {
                graph.deadlocks.push(next);
            }
            for (label, target) in steps {
                let to = match places.get(&target) {
                    Some(place) => *place,
                    None if graph.states.len() >= bounds.states => {
                        graph.complete = false;
                        continue;
                    }
                    None => {
                        let place = graph.states.len();
                        places.insert(target.clone(), place);
                        graph.states.push(target);
                        place
                    }
                };
                graph.transitions.push(Transition { from: next, label, to });
            }
            next += 1;
        }
        graph.livelock = graph.find_livelock();
        Ok(graph)
    }

    /// How many states have stopped, and how many have aborted.
    pub fn ended(&self) -> (usize, usize) {
        let count = |wanted: fn(&State) -> bool| self.states.iter().filter(|state| wanted(state)).count();
        (count(|state| matches!(state, State::Stopped(_))), count(|state| *state == State::Aborted))
    }

    /// Takes away, again and again, the states without an internal step into what is left: the rest is on a cycle or
    /// before one.
    fn find_livelock(&self) -> Option<usize> {
        let internal = |label: &Label| matches!(label, Label::Act(Action::Tau(..) | Action::Draw(..), _));
        let mut out = vec![0usize; self.states.len()];
        let mut into = vec![Vec::new(); self.states.len()];
        for step in self.transitions.iter().filter(|step| internal(&step.label)) {
            out[step.from] += 1;
            into[step.to].push(step.from);
        }
        let mut open: Vec<usize> = (0..out.len()).filter(|state| out[*state] == 0).collect();
        while let Some(state) = open.pop() {
            for from in into[state].clone() {
                out[from] -= 1;
                if out[from] == 0 {
                    open.push(from);
                }
            }
        }
        out.iter().position(|left| *left > 0)
    }
}

/// All steps of a state: its moves, with each of the inputs for each read, and time up to the next event.
///
/// # Errors
/// [`Meaningless`] where one leads to a state without a meaning.
pub fn successors(model: &Model, state: &State, inputs: &[Value]) -> Result<Vec<(Label, State)>, Meaningless> {
    let moves = state.moves()?;
    let mut steps = Vec::new();
    for step in &moves {
        if step.needs_value() {
            for value in inputs {
                let label = Label::Act(step.action.clone(), Some(value.clone()));
                steps.push((label, model.state(&step.with(value))?));
            }
        } else {
            steps.push((Label::Act(step.action.clone(), None), model.state(&step.next)?));
        }
    }
    if let Patience::Until(time) = state.patience(&moves) {
        let after = model.pass(state, &time)?;
        steps.push((Label::Wait(time), after));
    }
    Ok(steps)
}
