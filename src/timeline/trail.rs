//! The same run along the phases of a system, with a parameter left open: times and places as formulas of it, true
//! for all values near the one at hand for which the same ways are taken.

use std::collections::BTreeMap;

use super::{Ending, Stretch, Timeline};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, End, Next, Period};
use crate::substitution::substitute_values;
use crate::value::Value;

/// The largest formula that is carried along.
const MOST_SIZE: usize = 200;

/// Follows a system along its phases through at most so many stretches, deciding by the values at hand which way it
/// takes; `near` is what is known of the parameter. It ends early where something is drawn, or no way can be chosen.
pub fn trail(period: &Period, at: &BTreeMap<Name, Value>, near: &Assumptions, most: usize) -> Timeline {
    let ending = Ending::Unknown("it was not followed further".to_string());
    let known = Assumptions::default();
    let mut run = Timeline { stretches: Vec::new(), ending, at: at.clone(), known };
    let mut state: BTreeMap<Name, Value> = BTreeMap::new();
    let mut edges = &period.initial;
    let mut phase = None;
    let mut time = Value::zero();
    while run.stretches.len() < most {
        let Some(edge) = edges.iter().find(|edge| taken(edge, &state, &run)) else { break };
        if !edge.draws.is_empty() {
            break;
        }
        let Some(next) = pass(edge, &state, near, phase, &mut time, &mut run) else { break };
        match &edge.next {
            Next::Phase(number) => {
                let Some(there) = period.phases.get(*number) else { break };
                phase = Some(*number);
                edges = &there.edges;
                state = next;
            }
            Next::End(End::Silent { observed, .. }) => {
                let shown = observed.iter().filter_map(|term| substitute_values(term, &state).ok()).collect();
                let before = Vec::new();
                run.stretches.push(Stretch { start: time, duration: None, shown, before, phase });
                run.ending = Ending::Still;
                break;
            }
            Next::End(_) => {
                run.ending = Ending::Ended;
                break;
            }
        }
    }
    run
}

/// Whether a way is taken from this state.
fn taken(edge: &Edge, state: &BTreeMap<Name, Value>, run: &Timeline) -> bool {
    edge.tests.iter().all(|test| {
        test.substitute(state).is_ok_and(|test| run.decide(test.relation, &test.left, &test.right) == Some(true))
    })
}

/// Notes what passes on a way, and gives the state after it.
fn pass(
    edge: &Edge,
    state: &BTreeMap<Name, Value>,
    near: &Assumptions,
    phase: Option<usize>,
    time: &mut Value,
    run: &mut Timeline,
) -> Option<BTreeMap<Name, Value>> {
    for segment in &edge.segments {
        let duration = segment.duration.substitute(state).ok()?;
        let shown = segment.observed.iter().map(|term| substitute_values(term, state));
        let shown = shown.collect::<Result<Vec<_>, _>>().ok()?;
        let start = time.clone();
        *time = time.add(&duration).ok()?;
        // A way says what is communicated on it, and not between which of its stretches.
        let before = Vec::new();
        run.stretches.push(Stretch { start, duration: Some(duration), shown, before, phase });
    }
    let mut next = BTreeMap::new();
    for (name, value) in &edge.map {
        let value = near.simplify(&value.substitute(state).ok()?);
        if value.size() > MOST_SIZE {
            return None;
        }
        next.insert(name.clone(), value);
    }
    Some(next)
}
