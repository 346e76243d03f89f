//! Rounds of a phase that go on for ever and of which each shows something else, as turns that are counted: what is shown in
//! each is told by its number, so a property that starts again and again is laid along any of them.

use std::collections::{BTreeMap, BTreeSet};

use super::by_turns::Parts;
use super::orbit::{Moving, Orbit, without_moving};
use super::trajectory::{Leg, Rounds, Trajectory, Values};
use super::unit::Unit;
use crate::name::Name;
use crate::period::Segment;
use crate::recurrence::{Closed, Piece};
use crate::substitution::substitute_values;
use crate::value::Value;

impl Trajectory {
    /// Adds a last leg, which is for ever: where each of its rounds shows what the others do, the run comes round in it.
    pub(super) fn goes_on(&mut self, mut leg: Leg, parts: Parts) {
        self.counts = !parts.is_empty();
        if leg.shows_the_same() {
            self.cycle = Some(self.legs.len());
            if let Some(legs) = leg.clone().in_parts(&parts).filter(|legs| !legs.is_empty()) {
                self.legs.extend(legs);
                return;
            }
        }
        self.legs.push(leg);
        self.parts = parts;
    }

    /// The run with its last leg, which is for ever, as one turn in the number of the turn, without what moves on and is
    /// not asked for.
    pub(super) fn counted(&self, asked: &BTreeSet<Name>) -> Option<Trajectory> {
        if self.cycle.is_some() || self.end.is_some() || !self.open.is_empty() {
            return None;
        }
        let (last, before) = self.legs.split_last()?;
        let (Rounds::Forever(_), [Unit::Repeat { count: None, index, segments }]) =
            (&last.rounds, last.units.as_slice())
        else {
            return None;
        };
        let symbol = self.symbol.clone()?;
        let number = Value::variable(&symbol);
        let at = BTreeMap::from([(index.clone(), number.clone())]);
        let segment = |segment: &Segment| {
            let observed = segment.observed.iter().map(|term| substitute_values(term, &at).ok());
            let duration = segment.duration.substitute(&at).ok()?;
            Some(Unit::Single(Segment { duration, observed: observed.collect::<Option<_>>()? }))
        };
        let units = segments.iter().map(segment).collect::<Option<Vec<Unit>>>()?;
        let along = along(last, &at)?;
        let mut start: Values = last.start.clone();
        start.extend(along.iter().cloned());
        let turn = Leg { rounds: Rounds::Count(Value::one()), start, closed: Vec::new(), units, ..last.clone() };
        let next = number.add(&Value::one()).ok()?;
        let moving =
            vec![Moving { variable: index.clone(), symbol: symbol.clone(), start: Value::zero(), next, between: None }];
        let mut found = self.clone();
        found.assumptions.assume_natural(&symbol);
        found.cycle = Some(before.len());
        found.counts = true;
        let turns = turn.clone().in_parts(&self.parts).filter(|legs| !legs.is_empty()).unwrap_or_else(|| vec![turn]);
        found.legs = before.iter().cloned().chain(turns).collect();
        let orbit = Orbit { moving, along };
        without_moving(&mut found.legs[before.len()..], &orbit, asked);
        found.orbit = Some(orbit);
        Some(found)
    }
}

/// What the variables of a leg are at the start of a turn; nothing where one of its forms does not hold from the first on.
fn along(leg: &Leg, at: &Values) -> Option<Vec<(Name, Value)>> {
    let form = |(name, closed): &(Name, Closed)| {
        let [Piece { from, until: None, form }] = closed.pieces.as_slice() else { return None };
        from.is_zero().then(|| form.substitute(at).ok()).flatten().map(|form| (name.clone(), form))
    };
    leg.closed.iter().map(form).collect()
}
