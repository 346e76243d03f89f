//! The course of a system through its phases, where the values that its guards look at are numbers: durations may be
//! symbols.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::{Edge, End, Next, Period};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Value};

/// Rounds that a course is followed for.
const MOST_ROUNDS: usize = 10_000;
/// How often the phases may come again before all that is beside them does.
const MOST_TURNS: usize = 20;
/// The bits and the nodes that a value may grow to: one that grows on and on does not come again.
const MOST_BITS: u64 = 1_024;
const MOST_BITS_BESIDE_ROOTS: u64 = 160;
pub(super) const MOST_SIZE: usize = 200;

/// What comes of following the phases from the start.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Course {
    /// The system is again as it was, but for what is beside: after this time, from that time on.
    Repeats {
        /// From one state to the same again.
        lasting: Value,
        /// When it is so for the first time.
        from: Value,
        /// The variables that no way and no duration depends on and that may be others each time; none where all is as it was.
        beside: BTreeSet<Name>,
    },
    /// It ends so, after this time.
    Ends(End, Value),
}

/// A way that a run takes, from a phase or from the start, with what is kept of the values there.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Taken<'a> {
    /// The phase that it leaves; none for the start.
    pub phase: Option<usize>,
    /// The way.
    pub edge: &'a Edge,
    /// The values of variables of that phase.
    pub values: BTreeMap<Name, Value>,
}

/// A run and the ways that it took.
struct Followed<'a> {
    end: Course,
    taken: Vec<Taken<'a>>,
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
pub(super) fn way<'a>(edges: &'a [Edge], state: &BTreeMap<Name, Value>, assumptions: &Assumptions) -> Option<&'a Edge> {
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

/// The variables of the phase it leaves that a way depends on, where it leads to phases that depend on these.
fn steering(edge: &Edge, after: &[BTreeSet<Name>]) -> BTreeSet<Name> {
    let mut names = BTreeSet::new();
    for test in &edge.tests {
        names.extend(test.left.variables());
        names.extend(test.right.variables());
    }
    // Where a time is not known the course is not, either.
    names.extend(edge.duration().iter().flat_map(Value::variables));
    let with_needs = edge.shown_and_passed().chain(edge.map.values()).filter(|value| !value.needs().is_empty());
    names.extend(with_needs.flat_map(Value::variables));
    if let Next::Phase(next) = &edge.next {
        let counts = |name: &Name| after.get(*next).is_some_and(|names| names.contains(name));
        names.extend(edge.map.iter().filter(|(name, _)| counts(name)).flat_map(|(_, value)| value.variables()));
    }
    names
}

/// For each phase, by its ways, the variables that what comes, how long it takes, or whether it has a meaning depends on.
pub(super) fn steering_of(phases: &[&[Edge]]) -> Vec<BTreeSet<Name>> {
    let mut all: Vec<BTreeSet<Name>> = vec![BTreeSet::new(); phases.len()];
    loop {
        let mut grown = false;
        for (number, edges) in phases.iter().enumerate() {
            let names: BTreeSet<Name> = edges.iter().flat_map(|edge| steering(edge, &all)).collect();
            if let Some(own) = all.get_mut(number) {
                grown |= names.iter().any(|name| !own.contains(name));
                own.extend(names);
            }
        }
        if !grown {
            return all;
        }
    }
}

impl Period {
    /// Whether a phase comes again, and the run is not known to end all the same; of phases in every order of their delays,
    /// if it is known that the run comes again, or no way of all these ends.
    pub fn comes_again(&self, course: Option<&Course>) -> bool {
        match course {
            Some(Course::Ends(..)) => false,
            Some(Course::Repeats { .. }) => self.repeats(),
            None => self.repeats() && !(self.in_every_order && self.may_end()),
        }
    }

    /// Whether some way leads to an end.
    fn may_end(&self) -> bool {
        self.ways().any(|edge| matches!(edge.next, Next::End(_)))
    }

    fn steering(&self) -> Vec<BTreeSet<Name>> {
        let ways: Vec<&[Edge]> = self.phases.iter().map(|phase| phase.edges.as_slice()).collect();
        steering_of(&ways)
    }

    /// Where the system comes to from the start. None where the assumptions do not say which way it takes, something is
    /// drawn, or it goes on for too long or with values that grow too long.
    pub fn course(&self, assumptions: &Assumptions, interrupted: &dyn Fn() -> bool) -> Option<Course> {
        let steering = self.steering();
        let kept = |number: usize, name: &Name| steering.get(number).is_some_and(|names| names.contains(name));
        let course = self.follow(&kept, MOST_ROUNDS, assumptions, interrupted)?;
        if matches!(&course.end, Course::Repeats { beside, .. } if !beside.is_empty()) {
            let most = course.taken.len().saturating_mul(MOST_TURNS).min(MOST_ROUNDS);
            if let Some(whole) = self.follow(&|_, _| true, most, assumptions, interrupted) {
                return Some(whole.end);
            }
        }
        Some(course.end)
    }

    /// The ways that the run takes until it comes round or ends, as far as what it depends on is kept. None where
    /// [`Period::course`] gives none.
    pub fn taken(&self, assumptions: &Assumptions, interrupted: &dyn Fn() -> bool) -> Option<Vec<Taken<'_>>> {
        let steering = self.steering();
        let kept = |number: usize, name: &Name| steering.get(number).is_some_and(|names| names.contains(name));
        Some(self.follow(&kept, MOST_ROUNDS, assumptions, interrupted)?.taken)
    }

    /// Where it comes to, when in each phase only these variables are kept.
    fn follow(
        &self,
        kept: &dyn Fn(usize, &Name) -> bool,
        most: usize,
        assumptions: &Assumptions,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Followed<'_>> {
        let (mut edges, mut state, mut time) = (self.initial.as_slice(), BTreeMap::new(), Value::zero());
        let (mut phase, mut ways) = (None, Vec::new());
        let mut seen: HashMap<(usize, BTreeMap<Name, Value>), Value> = HashMap::new();
        for _ in 0..most {
            if interrupted() {
                return None;
            }
            let edge = way(edges, &state, assumptions)?;
            time = time.add(&edge.duration().ok()?.substitute(&state).ok()?).ok()?;
            ways.push(Taken { phase, edge, values: state.clone() });
            let number = match &edge.next {
                Next::Phase(number) => *number,
                Next::End(end) => return Some(Followed { end: Course::Ends(end.clone(), time), taken: ways }),
            };
            let next = edge.map.iter().filter(|(name, _)| kept(number, name));
            let next = next
                .map(|(name, value)| Some((name.clone(), assumptions.with_equations(value.substitute(&state).ok()?))));
            state = next.collect::<Option<BTreeMap<Name, Value>>>()?;
            let root = |value: &Value| value.atoms().iter().any(|atom| matches!(atom, Atom::Root(_)));
            let most = |value: &Value| if root(value) { MOST_BITS_BESIDE_ROOTS } else { MOST_BITS };
            if state.values().any(|value| value.bits() > most(value) || value.size() > MOST_SIZE) {
                return None;
            }
            if let Some(from) = seen.insert((number, state.clone()), time.clone()) {
                let beside = edge.map.keys().filter(|name| !kept(number, name)).cloned().collect();
                let end = Course::Repeats { lasting: time.sub(&from).ok()?, from, beside };
                return Some(Followed { end, taken: ways });
            }
            phase = Some(number);
            edges = &self.phases.get(number)?.edges;
        }
        None
    }
}
