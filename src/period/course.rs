//! The course of a system through its phases, where the values that its guards look at are numbers: durations may be
//! symbols.

use std::collections::{BTreeMap, HashMap};

use super::{Edge, End, Next, Period};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::Value;

/// Rounds that a course is followed for.
const MOST_ROUNDS: usize = 10_000;
/// The bits and the nodes that a value may grow to: one that grows on and on does not come again.
const MOST_BITS: u64 = 1_024;
const MOST_SIZE: usize = 200;

/// What comes of following the phases from the start.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Course {
    /// The system is again as it was: after this time, from that time on.
    Repeats {
        /// From one state to the same again.
        lasting: Value,
        /// When it is so for the first time.
        from: Value,
    },
    /// It ends so, after this time.
    Ends(End, Value),
}

/// Whether a way is taken in a state of the phase it leaves.
fn taken(edge: &Edge, state: &BTreeMap<Name, Value>, assumptions: &Assumptions) -> Option<bool> {
    let mut all = Some(true);
    for test in &edge.tests {
        match test.substitute(state).ok().and_then(|test| test.decide(assumptions)) {
            Some(false) => return Some(false),
            Some(true) => {}
            None => all = None,
        }
    }
    all
}

/// The one way that is taken, if the assumptions say which, and nothing is drawn on it.
fn way<'a>(edges: &'a [Edge], state: &BTreeMap<Name, Value>, assumptions: &Assumptions) -> Option<&'a Edge> {
    let mut found = None;
    for edge in edges {
        match taken(edge, state, assumptions)? {
            true if found.is_some() => return None,
            true => found = Some(edge),
            false => {}
        }
    }
    found.filter(|edge| edge.draws.is_empty())
}

impl Period {
    /// Where the system comes to from the start. None where the assumptions do not say which way it takes, something is
    /// drawn, or it goes on for too long or with values that grow too long.
    pub fn course(&self, assumptions: &Assumptions, interrupted: &dyn Fn() -> bool) -> Option<Course> {
        let (mut edges, mut state, mut time) = (self.initial.as_slice(), BTreeMap::new(), Value::zero());
        let mut seen: HashMap<(usize, BTreeMap<Name, Value>), Value> = HashMap::new();
        for _ in 0..MOST_ROUNDS {
            if interrupted() {
                return None;
            }
            let edge = way(edges, &state, assumptions)?;
            time = time.add(&edge.duration().ok()?.substitute(&state).ok()?).ok()?;
            let number = match &edge.next {
                Next::Phase(number) => *number,
                Next::End(end) => return Some(Course::Ends(end.clone(), time)),
            };
            let next = edge.map.iter().map(|(name, value)| Some((name.clone(), value.substitute(&state).ok()?)));
            state = next.collect::<Option<BTreeMap<Name, Value>>>()?;
            if state.values().any(|value| value.bits() > MOST_BITS || value.size() > MOST_SIZE) {
                return None;
            }
            if let Some(from) = seen.insert((number, state.clone()), time.clone()) {
                return Some(Course::Repeats { lasting: time.sub(&from).ok()?, from });
            }
            edges = &self.phases.get(number)?.edges;
        }
        None
    }
}
