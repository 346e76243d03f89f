//! Rounds of one phase that take the same ways by turns, for ever, though their values go on: several of them are one round.
//! So are legs through several phases that come again.

use num_traits::ToPrimitive;

use super::count::Count;
use super::orbit::is_aligned;
use super::trajectory::{Leg, Rounds, Values, Walker};
use super::unit::Unit;
use crate::name::Name;
use crate::period::{Edge, Next, Segment, Test, one_after_another};
use crate::recurrence::Piece;
use crate::value::{Relation, Value};

/// Rounds after which it is first looked whether the ways come again: after so many, twice as many, and so on.
const FIRST_LOOK: usize = 8;
/// Ways that come again one after another; legs that do, and their ways.
const MOST_WAYS: usize = 32;
const MOST_LEGS: usize = 64;
const MOST_WAYS_OF_LEGS: usize = 200;

/// Rounds that come again for ever.
pub(super) struct Turns {
    /// How many rounds there are before them.
    pub(super) from: usize,
    /// They as one round.
    pub(super) round: Edge,
    /// The closed forms of it, from then on.
    pub(super) count: Count,
}

/// Of each of several legs the phase, its rounds, and how many stretches they have.
pub(super) type Parts = Vec<(usize, Value, usize)>;

/// Legs that come again for ever.
pub(super) struct LegTurns {
    /// They as one round, and its closed forms.
    pub(super) round: Edge,
    pub(super) count: Count,
    /// Its legs.
    pub(super) legs: Parts,
}

impl Leg {
    /// It as several legs, one for each phase with so many of its stretches; nothing where these are not all.
    pub(super) fn in_parts(self, parts: &[(usize, Value, usize)]) -> Option<Vec<Leg>> {
        let all = self.units.len() == parts.iter().map(|(.., count)| count).sum::<usize>();
        let mut units = self.units.iter();
        let leg = |place: usize| {
            let (phase, rounds, count) = parts[place].clone();
            let units = units.by_ref().take(count).cloned().collect();
            let continues = place > 0 && parts[place - 1].0 == phase;
            let own = if place == 0 { self.clone() } else { self.without_values() };
            Leg { phase, rounds: Rounds::Count(rounds), units, continues, ..own }
        };
        all.then(|| (0..parts.len()).map(leg).collect())
    }

    /// Nothing is said of its values.
    fn without_values(&self) -> Leg {
        Leg { start: Values::new(), closed: Vec::new(), conditions: Vec::new(), kept: None, ..self.clone() }
    }

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

impl<'a> Walker<'a> {
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

    /// The legs through several phases that come again for ever from here on, where a round of the system begins, if the
    /// last of the legs are those before them. The places from which each leg went, and this one, are given.
    pub(super) fn legs_by_turns(&self, legs: &[Leg], places: &[(usize, Values)]) -> Option<LegTurns> {
        let here = legs.len();
        if here < FIRST_LOOK || places.len() != here + 1 {
            return None;
        }
        let since = here - (1 << here.ilog2());
        let alike = |place: usize, span: usize| {
            let (one, other) = (&legs[place], &legs[place - span]);
            one.phase == other.phase && one.rounds == other.rounds
        };
        (since + 1..=MOST_LEGS.min(here / 2)).find_map(|span| {
            let again = (here - span..here).all(|place| alike(place, span)) && places[here].0 == places[here - span].0;
            if !again || !is_aligned(legs, span) {
                return None;
            }
            let (ways, legs) = self.ways_of(&legs[here - span..], &places[here - span..])?;
            let round = one_after_another(&ways).ok()??;
            let count = self.for_ever(&round, &places[here].1)?;
            Some(LegTurns { round, count, legs })
        })
    }

    /// The ways that these legs took between these places, and of each leg the phase and how many stretches it has.
    fn ways_of(&self, legs: &[Leg], places: &[(usize, Values)]) -> Option<(Vec<&'a Edge>, Parts)> {
        let period = self.period;
        let (mut ways, mut parts) = (Vec::new(), Vec::new());
        for (leg, between) in legs.iter().zip(places.windows(2)) {
            let [(phase, values), (to, wanted)] = between else { return None };
            let Rounds::Count(count) = &leg.rounds else { return None };
            let count = count.as_rational().filter(|count| count.is_integer())?.to_integer().to_usize()?;
            let (mut now, first) = (values.clone(), ways.len());
            for number in 1..=count {
                let way = self.choose(&period.phases.get(*phase)?.edges, &now, &self.assumptions).ok()?;
                now = self.image(way, &now).ok()?;
                let next = if number == count { to } else { phase };
                if way.next != Next::Phase(*next) || ways.len() >= MOST_WAYS_OF_LEGS {
                    return None;
                }
                ways.push(way);
            }
            let same = |(name, value): (&Name, &Value)| {
                wanted.get(name).is_some_and(|other| self.assumptions.decide(Relation::Eq, value, other) == Some(true))
            };
            if now.len() != wanted.len() || !now.iter().all(same) {
                return None;
            }
            let stretches = ways[first..].iter().map(|way: &&Edge| way.segments.len()).sum();
            parts.push((*phase, Value::integer(i64::try_from(count).ok()?), stretches));
        }
        Some((ways, parts))
    }

    /// The closed forms of a round all of whose tests hold in every round.
    fn for_ever(&self, round: &Edge, values: &Values) -> Option<Count> {
        let forms = self.forms(round, values).ok()?;
        let mut known = self.assumptions.clone();
        known.assume_natural(&self.index);
        let mut terms = forms.constant;
        for (name, closed) in &forms.closed {
            let [Piece { from, until: None, form }] = closed.pieces.as_slice() else { return None };
            if !from.is_zero() {
                return None;
            }
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
