//! A round that goes several ways as one map: in each variable, by the tests of the ways.

use std::collections::{BTreeMap, BTreeSet};

use super::PhaseFlow;
use crate::assumption::Assumptions;
use crate::closed_form::Solved;
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::recurrence::solve_until;
use crate::value::{Sort, Value, ValueError};

/// The most ways that are told as one.
const MOST_WAYS: usize = 4;
/// The most choices of one test of each way.
const MOST_FAILING: usize = 64;

impl PhaseFlow {
    /// The map of a round that comes back: of several, the last is what happens where the tests of no other hold. Several are
    /// none where what is drawn decides, something else may happen than to come back, or there are too many.
    pub(super) fn whole(&self) -> Option<BTreeMap<Name, Value>> {
        let (last, others) = self.maps.split_last().filter(|_| self.maps.len() <= MOST_WAYS)?;
        if others.is_empty() {
            return Some(last.1.clone());
        }
        if !self.exits.is_empty() || !self.leave_nothing_out() {
            return None;
        }
        let drawn: BTreeSet<Name> = self.drawn();
        let by_draw = |test: &Test| drawn.iter().any(|name| test.left.mentions(name) || test.right.mentions(name));
        let real = |image: &Value| image.sort() == Sort::Real;
        if self.maps.iter().any(|(tests, map)| tests.iter().any(by_draw) || !map.values().all(real)) {
            return None;
        }
        let mut whole = last.1.clone();
        for (tests, map) in others.iter().rev() {
            let met = all_hold(tests).ok()?;
            for (name, image) in map {
                let otherwise = whole.get(name)?;
                let either = image.sub(otherwise).and_then(|more| met.mul(&more)?.add(otherwise)).ok()?;
                whole.insert(name.clone(), either);
            }
        }
        Some(whole)
    }
}

impl PhaseFlow {
    /// Whether the tests of some way surely hold, whatever the values are: that one of each fails is a contradiction.
    fn leave_nothing_out(&self) -> bool {
        let mut failing = vec![Assumptions::default()];
        for (tests, _) in &self.maps {
            let fails = |known: &Assumptions, test: &Test| {
                let (mut known, test) = (known.clone(), test.negated());
                known.assume(test.relation, &test.left, &test.right);
                known
            };
            failing = failing.iter().flat_map(|known| tests.iter().map(move |test| fails(known, test))).collect();
            if failing.len() > MOST_FAILING {
                return false;
            }
        }
        failing.iter().all(Assumptions::contradictory)
    }

    /// The checked forms from the start of the run itself, where a round goes several ways and there are none from any start.
    pub fn from_begin(&self, index: &Name, assumptions: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Solved> {
        let begin = self.begin.as_ref().filter(|_| self.maps.len() > 1)?;
        let mut recurrence = self.recurrence(index);
        for sequence in &mut recurrence.sequences {
            sequence.start = vec![begin.get(&sequence.name)?.clone()];
        }
        solve_until(recurrence, &self.named.known(assumptions), stop).ok()
    }
}

/// The values with which a phase begins, where it is the first and no other leads to it.
pub(super) fn begin(period: &Period, number: usize) -> Option<BTreeMap<Name, Value>> {
    let here = |edge: &&Edge| edge.next == Next::Phase(number);
    let others = period.phases.iter().enumerate().filter(|(other, _)| *other != number);
    if others.flat_map(|(_, phase)| &phase.edges).any(|edge| here(&edge)) {
        return None;
    }
    let mut entries = period.initial.iter().filter(here);
    let entry = entries.next().filter(|entry| entry.tests.is_empty() && entry.draws.is_empty())?;
    entries.next().is_none().then(|| entry.map.clone())
}

/// 1 where all tests hold, else 0.
fn all_hold(tests: &[Test]) -> Result<Value, ValueError> {
    tests.iter().try_fold(Value::one(), |all, test| all.mul(&Value::truth(test.relation, &test.left, &test.right)?))
}
