//! The conditions of laws, evaluated on closed instances by exploring what they do.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use super::instance::{Choice, close, read_names, surroundings};
use crate::definition::Definitions;
use crate::law::{Condition, Fact};
use crate::model::explore::{Bounds, Graph, Label};
use crate::model::{Action, Model, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// The most states of a process whose facts are asked for; a larger one is not used.
const MOST_STATES: usize = 300;

/// Whether the condition holds of the instance; false where that cannot be told.
pub(super) fn holds(condition: &Condition, choice: &Choice, definitions: &Definitions, inputs: &[Value]) -> bool {
    let graphs = |term: &Term| reached(&choice.term(term)?, definitions, inputs);
    let number = |value: &Value| choice.value(value)?.as_rational();
    let answer = match condition {
        Condition::Compare(relation, left, right) => match (number(left), number(right)) {
            (Some(left), Some(right)) => Some(ordered(*relation, &left, &right)),
            _ => None,
        },
        Condition::Natural(value) => number(value).map(|number| number.is_integer() && number >= BigRational::zero()),
        Condition::Is(fact, term) => graphs(term).map(|graphs| graphs.iter().all(|graph| is(*fact, graph))),
        Condition::Lasts(term, time) => number(time).and_then(|time| {
            let graphs = graphs(term)?;
            Some(graphs.iter().all(|graph| lasts(graph, 0, &time, 0)))
        }),
        Condition::Complementary(one, two) => graphs(one).and_then(|ones| {
            let twos = graphs(two)?;
            let whole = choice.term(one).zip(choice.term(two))?;
            complementary(&ones, &twos, &whole, definitions, inputs)
        }),
        Condition::NoPort(term, port) => {
            let port = choice.name(port);
            choice.term(term).map(|term| !ports(&term, definitions).contains(&port))
        }
        Condition::Unread(term, name) => {
            let name = choice.name(name);
            choice.term(term).map(|term| !Model::new(definitions).free_reads(&term).contains(&name))
        }
        Condition::Apart(one, two) => choice.term(one).zip(choice.term(two)).map(|(one, two)| {
            let model = Model::new(definitions);
            let mut used = model.free_reads(&two);
            used.extend(model.bound_names(&two));
            model.bound_names(&one).is_disjoint(&used)
        }),
        Condition::ShowsOnly(term, shown) => {
            graphs(term).map(|graphs| graphs.iter().all(|graph| shows(graph).is_subset(shown)))
        }
        Condition::ShowsNone(term, shown) => {
            graphs(term).map(|graphs| graphs.iter().all(|graph| shows(graph).is_disjoint(shown)))
        }
    };
    answer.unwrap_or(false)
}

/// A comparison of two numbers.
pub(super) fn ordered(relation: Relation, left: &BigRational, right: &BigRational) -> bool {
    match relation {
        Relation::Eq => left == right,
        Relation::Neq => left != right,
        Relation::Gtr => left > right,
        Relation::Gte => left >= right,
        Relation::Lss => left < right,
        Relation::Lte => left <= right,
    }
}

/// What the term can do in each of the surroundings that its names may have.
fn reached(term: &Term, definitions: &Definitions, inputs: &[Value]) -> Option<Vec<Graph>> {
    let bounds = Bounds { states: MOST_STATES, inputs: inputs.to_vec() };
    surroundings(&read_names(term), inputs)
        .iter()
        .map(|known| Graph::of(&close(term, known), definitions, &bounds).ok().filter(|graph| graph.complete))
        .collect()
}

fn is(fact: Fact, graph: &Graph) -> bool {
    let some = |wanted: fn(&State) -> bool| graph.states.iter().any(wanted);
    let start = &graph.states[0];
    let now = at_once(graph);
    let first: Vec<&State> = now.iter().map(|place| &graph.states[*place]).collect();
    let ended = |state: &State| !matches!(state, State::Running(_));
    match fact {
        Fact::NeverAborts => !some(|state| *state == State::Aborted),
        Fact::NeverStops => !some(|state| matches!(state, State::Stopped(_))),
        Fact::Silent => !graph.transitions.iter().any(|step| communicates(&step.label)),
        Fact::DrawsNothing => !graph.transitions.iter().any(|step| draws(&step.label)),
        Fact::BindsNothing => !some(|state| matches!(state, State::Stopped(results) if !results.is_empty())),
        Fact::Observer => graph.transitions.is_empty() && matches!(start, State::Running(_)),
        Fact::Guard => match start {
            State::Stopped(results) => results.is_empty(),
            State::Aborted => true,
            State::Running(_) => false,
        },
        Fact::Immediate => matches!(start, State::Stopped(_)),
        Fact::NotStopped => !first.iter().any(|state| matches!(state, State::Stopped(_))),
        Fact::Running => !first.iter().any(|state| ended(state)),
        Fact::Guarded => !first.iter().any(|state| matches!(state, State::Stopped(_))),
        Fact::Still => {
            let acts = |label: &Label| communicates(label) || draws(label);
            !graph.transitions.iter().any(|step| now.contains(&step.from) && acts(&step.label))
        }
    }
}

/// The observers that may be shown.
fn shows(graph: &Graph) -> BTreeSet<Name> {
    graph.states.iter().flat_map(State::observations).map(|(name, _)| name).collect()
}

fn communicates(label: &Label) -> bool {
    matches!(label, Label::Act(Action::In(_) | Action::Out(..) | Action::Tau(..), _))
}

fn draws(label: &Label) -> bool {
    matches!(label, Label::Act(Action::Draw(..), _))
}

/// The states that draws alone lead to.
fn at_once(graph: &Graph) -> BTreeSet<usize> {
    let mut places = BTreeSet::from([0]);
    let mut open = vec![0];
    while let Some(place) = open.pop() {
        for step in graph.transitions.iter().filter(|step| step.from == place && draws(&step.label)) {
            if places.insert(step.to) {
                open.push(step.to);
            }
        }
    }
    places
}

/// Whether every way from this state stops, binding nothing and without communication, after exactly this time.
fn lasts(graph: &Graph, place: usize, time: &BigRational, depth: usize) -> bool {
    match &graph.states[place] {
        State::Stopped(results) => results.is_empty() && time.is_zero(),
        State::Aborted => false,
        State::Running(_) if depth > 50 => false,
        State::Running(_) => {
            let mut steps = graph.transitions.iter().filter(|step| step.from == place).peekable();
            steps.peek().is_some()
                && steps.all(|step| match &step.label {
                    Label::Wait(passed) => passed <= time && lasts(graph, step.to, &(time - passed), depth + 1),
                    label => draws(label) && lasts(graph, step.to, time, depth + 1),
                })
        }
    }
}

/// Whether both are guards, and exactly one of them stops in whatever surroundings.
fn complementary(
    ones: &[Graph],
    twos: &[Graph],
    whole: &(Term, Term),
    definitions: &Definitions,
    inputs: &[Value],
) -> Option<bool> {
    if !ones.iter().chain(twos).all(|graph| is(Fact::Guard, graph)) {
        return Some(false);
    }
    let model = Model::new(definitions);
    let mut read = read_names(&whole.0);
    read.extend(read_names(&whole.1));
    for known in surroundings(&read, inputs) {
        let stops = |term: &Term| Some(matches!(model.state(&close(term, &known)).ok()?, State::Stopped(_)));
        if stops(&whole.0)? == stops(&whole.1)? {
            return Some(false);
        }
    }
    Some(true)
}

/// The ports that a term uses, with those of the definitions it calls.
fn ports(term: &Term, definitions: &Definitions) -> BTreeSet<Name> {
    let mut all = BTreeSet::new();
    let mut called = BTreeSet::new();
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        match term.node() {
            Node::In(port, _) | Node::Out(port, _) => {
                all.insert(port.clone());
            }
            Node::Call(name, _) => {
                if let Some(definition) = definitions.get(name)
                    && called.insert(name.clone())
                {
                    open.push(&definition.body);
                }
            }
            _ => open.extend(term.children()),
        }
    }
    all
}
