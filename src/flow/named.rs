//! What closed forms call the values with which a phase begins, and the number of a round: names that nothing else has.

use std::collections::{BTreeMap, BTreeSet};

use crate::assumption::Assumptions;
use crate::lower::Environment;
use crate::name::Name;
use crate::period::{Edge, Next, Period};
use crate::scope::read_names;
use crate::term::Term;
use crate::value::Value;

/// The names of a phase's starts and of the number of a round.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Named {
    /// The number of a round.
    pub index: Name,
    starts: BTreeMap<Name, Name>,
    /// Names of which something may be assumed that says nothing of what they are called here.
    own: BTreeSet<Name>,
}

/// All names that stand in what is said of the phases, or are declared for the whole text.
pub(super) fn spoken_of(period: &Period, environment: &Environment) -> BTreeSet<Name> {
    let mut names: BTreeSet<Name> = environment.quantities().map(|(name, _)| name.clone()).collect();
    let edges = period.ways();
    for edge in edges {
        let tests = edge.tests.iter().flat_map(|test| [&test.left, &test.right]);
        let passed = edge.communications.iter().map(|(_, value)| value);
        let drawn = edge.draws.iter().map(|(_, from)| from);
        let durations = edge.segments.iter().map(|segment| &segment.duration);
        let values = edge.map.values().chain(tests).chain(passed).chain(drawn).chain(durations);
        names.extend(values.flat_map(Value::variables));
        names.extend(edge.segments.iter().flat_map(|segment| &segment.observed).flat_map(read_names));
    }
    for phase in &period.phases {
        names.extend(phase.variables.iter().cloned());
        names.extend(phase.state.iter().chain(&phase.control).flat_map(|part: &Term| read_names(part)));
    }
    names
}

impl Named {
    /// Of a phase: `r0` for the start of r and `n` for a round, unless these names have another meaning.
    pub(super) fn of(period: &Period, number: usize, spoken_of: &BTreeSet<Name>) -> Named {
        let variables = period.phases.get(number).map_or(&[][..], |phase| &phase.variables);
        let mut own = BTreeSet::new();
        let mut starts = BTreeMap::new();
        for variable in variables {
            let first = Name::new(&format!("{variable}0"));
            let name = if spoken_of.contains(&first) && !begins_so(period, number, variable, &first) {
                let other = (0..).map(|count| format!("{variable}start{}", "0".repeat(count)));
                let mut other = other.map(|name| Name::new(&name));
                other.find(|name| !spoken_of.contains(name)).unwrap_or(first)
            } else {
                first
            };
            if !spoken_of.contains(&name) {
                own.insert(name.clone());
            }
            starts.insert(variable.clone(), name);
        }
        let free = |name: &Name| !spoken_of.contains(name) && !starts.values().any(|start| start == name);
        let index = ["n", "k", "i", "j", "m"].into_iter().map(Name::new).find(free);
        let index = index.unwrap_or_else(|| Name::new("index"));
        own.insert(index.clone());
        Named { index, starts, own }
    }

    /// What a variable is when the phase begins.
    pub fn start(&self, variable: &Name) -> Value {
        let plain = || Name::new(&format!("{variable}0"));
        Value::variable(&self.starts.get(variable).cloned().unwrap_or_else(plain))
    }

    /// What is assumed, without what is assumed of parameters that happen to be called like a start or a round.
    pub(super) fn known(&self, assumptions: &Assumptions) -> Assumptions {
        if assumptions.variables().is_disjoint(&self.own) {
            assumptions.clone()
        } else {
            assumptions.without(&self.own)
        }
    }
}

/// Whether the phase is entered with just this value, and from the start of the system alone.
fn begins_so(period: &Period, number: usize, variable: &Name, value: &Name) -> bool {
    let leads_here = |edge: &&Edge| edge.next == Next::Phase(number);
    let mut first = period.initial.iter().filter(leads_here).peekable();
    let mut others = period.phases.iter().enumerate().filter(|(other, _)| *other != number);
    let value = Value::variable(value);
    first.peek().is_some()
        && first.all(|edge| edge.map.get(variable) == Some(&value))
        && !others.any(|(_, phase)| phase.edges.iter().any(|edge| leads_here(&edge)))
}
