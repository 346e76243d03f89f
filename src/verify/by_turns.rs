//! Rounds of one phase that take the same ways by turns, for ever, though their values go on: several of them are one round.

use super::count::Count;
use super::trajectory::{Leg, Values, Walker};
use super::unit::Unit;
use crate::period::{Edge, Segment, Test, one_after_another};
use crate::recurrence::Piece;

/// Rounds after which it is first looked whether the ways come again: after so many, twice as many, and so on.
const FIRST_LOOK: usize = 8;
/// Ways that come again one after another.
const MOST_WAYS: usize = 32;

/// Rounds that come again for ever.
pub(super) struct Turns {
    /// How many rounds there are before them.
    pub(super) from: usize,
    /// They as one round.
    pub(super) round: Edge,
    /// The closed forms of it, from then on.
    pub(super) count: Count,
}

impl Leg {
    /// Whether each of its rounds shows what the others do, though values go on: then its stretches are those of one round.
    pub(super) fn shows_the_same(&mut self) -> bool {
        let [Unit::Repeat { count: None, index, segments }] = self.units.as_slice() else { return false };
        let moves = |segment: &Segment| {
            let shown = segment.observed.iter().flat_map(|term| term.values());
            segment.duration.mentions(index) || shown.into_iter().any(|value| value.mentions(index))
        };
        let same = !segments.iter().any(moves);
        if same {
            self.units = segments.iter().cloned().map(Unit::Single).collect();
        }
        same
    }
}

impl Walker<'_> {
    /// The rounds that come again for ever from some round of these on, if the last of these are those before them.
    pub(super) fn by_turns(&self, rounds: &[(&Edge, Values)]) -> Option<Turns> {
        let total = rounds.len();
        if total < FIRST_LOOK || !total.is_power_of_two() {
            return None;
        }
        let same = |one: usize, other: usize| std::ptr::eq(rounds[one].0, rounds[other].0);
        let again = |count: &usize| (total - count..total).all(|place| same(place, place - count));
        let count = (2..=MOST_WAYS.min(total / 2)).find(again)?;
        let from = (0..total - count).rev().take_while(|place| same(*place, place + count)).last()?;
        let ways: Vec<&Edge> = rounds[from..from + count].iter().map(|(edge, _)| *edge).collect();
        let round = one_after_another(&ways).ok()??;
        let count = self.for_ever(&round, &rounds[from].1)?;
        Some(Turns { from, round, count })
    }

    /// The closed forms of a round all of whose tests hold in every round.
    fn for_ever(&self, round: &Edge, values: &Values) -> Option<Count> {
        let forms = self.forms(round, values).ok()?;
        let mut known = self.assumptions.clone();
        known.assume_natural(&self.index);
        let mut terms = forms.constant;
        for (name, closed) in &forms.closed {
            let [Piece { until: None, form, .. }] = closed.pieces.as_slice() else { return None };
            terms.insert(name.clone(), form.clone());
        }
        let holds = |test: &Test| {
            let Test { relation, left, right } = test.substitute(&terms).ok()?;
            known.decide(relation, &known.simplify(&left), &known.simplify(&right))
        };
        let reason = "the same ways are taken again and again".to_string();
        let plain = forms.closed.iter().all(|(_, closed)| closed.conditions.is_empty());
        (plain && round.tests.iter().all(|test| holds(test) == Some(true))).then_some(Count {
            stays: None,
            reason,
            closed: forms.closed,
            conditions: Vec::new(),
            learned: None,
            shown: None,
        })
    }
}
