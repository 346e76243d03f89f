//! Loops that wait for each other alone, without a choice: in the end each round takes the time of the greatest cycle of delays
//! and communications (the cycle time of a max-plus linear system: Baccelli, Cohen, Olsder and Quadrat, Synchronization and
//! Linearity, 1992, chapter 3). How many rounds it takes until then depends on how much the delays differ.

use std::collections::{BTreeMap, BTreeSet};

use super::ports::flatten;
use super::surroundings::parameters;
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::bound_names;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// The most ports, and cycles that are looked at.
const MOST_PORTS: usize = 16;
const MOST_CYCLES: usize = 200;
/// Calls that are followed until a loop comes round.
const MOST_CALLS: usize = 32;

/// A step of a component.
#[derive(Clone)]
enum Step {
    Delay(Value),
    Port(Name, bool),
}

/// From one communication of a component to its next one: the delays between, and whether a round of the component ends there.
struct Edge {
    from: usize,
    to: usize,
    delay: Value,
    wraps: bool,
}

/// How long a round takes in the end of components that are loops of delays and communications alone, on ports that one of them
/// writes and one reads, once a round each; none of others, or where a cycle spans several rounds or none.
pub fn greatest_cycle(components: &[Term], definitions: &Definitions, known: &Assumptions) -> Option<Value> {
    let components = flatten(components, definitions);
    let fixed = parameters(&components, definitions, known);
    let loops = components.iter().map(|one| loop_of(one, definitions, &fixed)).collect::<Option<Vec<_>>>()?;
    let ports = paired(&loops)?;
    let edges = edges(&loops, &ports)?;
    let lasts = |edge: &Edge| {
        known.gives_meaning(&edge.delay) && known.decide(Relation::Gte, &edge.delay, &Value::zero()) == Some(true)
    };
    if ports.len() > MOST_PORTS || !edges.iter().all(lasts) || !connected(&edges, ports.len()) {
        return None;
    }
    let mut cycles = Vec::new();
    for start in 0..ports.len() {
        cycles_from(start, (start, Value::zero(), 0), &mut vec![start], &edges, &mut cycles)?;
    }
    // What goes round within a round never happens, and what takes several has a period of several.
    let once = cycles.iter().map(|(time, rounds)| (*rounds == 1).then(|| time.clone())).collect::<Option<Vec<_>>>()?;
    let time = Value::maximum(&once).ok()?;
    (known.decide(Relation::Gtr, &time, &Value::zero()) == Some(true)).then(|| known.simplify(&time))
}

/// The steps of a round of a component that comes to a loop without communicating before; none where it chooses, or a delay is
/// not the same in each round.
fn loop_of(component: &Term, definitions: &Definitions, fixed: &BTreeSet<Name>) -> Option<Vec<Step>> {
    let (mut steps, mut opened): (Vec<Step>, Vec<(Name, usize)>) = (Vec::new(), Vec::new());
    let mut body = component.clone();
    let mut own: BTreeSet<Name> = BTreeSet::new();
    for _ in 0..MOST_CALLS {
        own.extend(bound_names(&body));
        let parts: Vec<Term> = match body.node() {
            Node::Seq(parts) => parts.iter().cloned().collect(),
            _ => vec![body.clone()],
        };
        let (last, before) = parts.split_last()?;
        for part in before {
            steps.push(step(part)?);
        }
        // What is carried from round to round may come to where something has no value.
        let Node::Call(name, arguments) = last.node() else { return None };
        if !arguments.is_empty() {
            return None;
        }
        if let Some((_, from)) = opened.iter().find(|(other, _)| other == name) {
            let delays = steps.iter().filter_map(|step| if let Step::Delay(time) = step { Some(time) } else { None });
            let same = |time: &Value| time.variables().iter().all(|name| fixed.contains(name) && !own.contains(name));
            let silent = steps[..*from].iter().all(|step| matches!(step, Step::Delay(_)));
            return (delays.into_iter().all(same) && silent).then(|| steps[*from..].to_vec());
        }
        opened.push((name.clone(), steps.len()));
        let definition = definitions.get(name)?;
        own.extend(definition.parameters.iter().cloned());
        body = definition.body.clone();
    }
    None
}

fn step(part: &Term) -> Option<Step> {
    match part.node() {
        Node::Delay(time) => Some(Step::Delay(time.clone())),
        Node::In(port, _) => Some(Step::Port(port.clone(), false)),
        Node::Out(port, value) => value.needs().is_empty().then(|| Step::Port(port.clone(), true)),
        Node::Disable(parts) => {
            let (delays, shown): (Vec<&Term>, Vec<&Term>) =
                parts.iter().partition(|part| matches!(part.node(), Node::Delay(_)));
            let [delay] = delays.as_slice() else { return None };
            shown
                .iter()
                .all(|part| matches!(part.node(), Node::Observe(..) | Node::Idle))
                .then(|| step(delay))
                .flatten()
        }
        _ => None,
    }
}

/// The ports, each of which one loop writes and another reads, once a round.
fn paired(loops: &[Vec<Step>]) -> Option<BTreeMap<Name, usize>> {
    let mut users: BTreeMap<Name, [usize; 2]> = BTreeMap::new();
    for step in loops.iter().flatten() {
        if let Step::Port(port, writes) = step {
            users.entry(port.clone()).or_default()[usize::from(*writes)] += 1;
        }
    }
    let all = users.values().all(|users| *users == [1, 1]);
    all.then(|| users.into_keys().enumerate().map(|(number, port)| (port, number)).collect())
}

/// The ways from communication to communication; none where a component has none.
fn edges(loops: &[Vec<Step>], ports: &BTreeMap<Name, usize>) -> Option<Vec<Edge>> {
    let mut all = Vec::new();
    for steps in loops {
        let first = steps.iter().position(|step| matches!(step, Step::Port(..)))?;
        let (mut at, mut delay) = (None, Value::zero());
        let turned = (0..=steps.len()).map(|place| (first + place, &steps[(first + place) % steps.len()]));
        let mut wraps = false;
        for (place, step) in turned {
            wraps |= place == steps.len();
            match step {
                Step::Delay(time) => delay = delay.add(time).ok()?,
                Step::Port(port, _) => {
                    let to = *ports.get(port)?;
                    let passed = std::mem::replace(&mut delay, Value::zero());
                    if let Some(from) = at.replace(to) {
                        all.push(Edge { from, to, delay: passed, wraps: std::mem::take(&mut wraps) });
                    }
                }
            }
        }
    }
    Some(all)
}

/// Whether every communication is reached from the first.
fn connected(edges: &[Edge], ports: usize) -> bool {
    let mut reached = BTreeSet::from([0usize]);
    while let Some(edge) = edges.iter().find(|edge| reached.contains(&edge.from) && !reached.contains(&edge.to)) {
        reached.insert(edge.to);
    }
    ports > 0 && reached.len() == ports
}

/// The cycles through a communication and later ones, with their times and rounds; none where these are too many.
fn cycles_from(
    start: usize,
    (at, time, rounds): (usize, Value, usize),
    path: &mut Vec<usize>,
    edges: &[Edge],
    found: &mut Vec<(Value, usize)>,
) -> Option<()> {
    for edge in edges.iter().filter(|edge| edge.from == at && edge.to >= start) {
        let (time, rounds) = (time.add(&edge.delay).ok()?, rounds + usize::from(edge.wraps));
        if edge.to == start {
            found.push((time, rounds));
            if found.len() > MOST_CYCLES {
                return None;
            }
        } else if !path.contains(&edge.to) {
            path.push(edge.to);
            cycles_from(start, (edge.to, time, rounds), path, edges, found)?;
            path.pop();
        }
    }
    Some(())
}
