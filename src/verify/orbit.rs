//! Runs that go round for ever without repeating exactly: each turn takes the same legs with the same counts of
//! rounds, and only the values at its start move on, inside an interval that they never leave.
//!
//! The turn is followed once more from a symbol in that interval. Every test on the way must be decided for the whole
//! interval, and the turn must lead back into it; then, by induction, all later turns are as this one.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::trajectory::{Leg, Rounds, Trajectory, Values, Walker};
use super::unit::Unit;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, Next, Segment};
use crate::proof::{self, going_round};
use crate::prove::run::interval_around;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Legs that a turn may have.
const MOST_SPAN: usize = 12;
/// Rounds of a turn, all of which are looked at.
const MOST_ROUNDS: usize = 1_000;
/// Rounds of a leg that are written one by one: a form in the symbols is not looked for.
const FEW_ROUNDS: usize = 20;

/// A value that moves on from turn to turn.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Moving {
    /// The state variable.
    pub variable: Name,
    /// What stands for it at the start of a turn.
    pub symbol: Name,
    /// Its value at the start of the first turn.
    pub start: Value,
    /// Its value after a turn, in the symbols.
    pub next: Value,
    /// The ends of the interval that it never leaves; nothing of the number of the turn.
    pub between: Option<(Value, Value)>,
}

/// What moves on in a part of a run that goes round.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Orbit {
    /// The values that move.
    pub moving: Vec<Moving>,
    /// The state variables that move with the first of these, on a line, and what they are at the start of a turn.
    pub along: Vec<(Name, Value)>,
}

/// A turn from symbols: what moves, and its legs.
pub(super) struct Turn {
    pub(super) orbit: Orbit,
    pub(super) legs: Vec<Leg>,
    pub(super) assumptions: Assumptions,
}

impl Orbit {
    /// One line for each value that moves.
    pub fn lines(&self) -> Vec<String> {
        let line = |moving: &Moving| {
            let Moving { variable, symbol, start, next, between } = moving;
            match between {
                Some((low, high)) => {
                    format!(
                        "{variable} = {symbol}: first {start}, then {next} after each turn, always from {low} to {high}"
                    )
                }
                None => format!("{symbol}: how many turns are over, first {start}, then {next}"),
            }
        };
        let along =
            self.along.iter().map(|(variable, value)| format!("{variable} = {value} at the start of each turn"));
        self.moving.iter().map(line).chain(along).collect()
    }

    /// The symbols themselves.
    pub(super) fn symbols(&self) -> Vec<Value> {
        self.moving.iter().map(|moving| Value::variable(&moving.symbol)).collect()
    }

    /// Whether a value depends on what moves.
    pub(super) fn moves(&self, value: &Value) -> bool {
        self.moving.iter().any(|moving| value.mentions(&moving.symbol))
    }

    /// A process that goes round, with the values that move on.
    pub(super) fn round(&self, body: Term) -> Term {
        let one = |moving: &Moving| proof::Moving {
            variable: moving.symbol.clone(),
            name: moving.symbol.clone(),
            start: moving.start.clone(),
            next: moving.next.clone(),
        };
        let moving: Vec<proof::Moving> = self.moving.iter().map(one).collect();
        going_round(&body, &moving)
    }
}

impl Walker<'_> {
    /// The turns from here on, if the last two took the same legs with the same counts, and all later ones do.
    pub(super) fn turn(&self, trajectory: &Trajectory, phase: usize, values: &Values) -> Option<Turn> {
        let legs = &trajectory.legs;
        let here = legs.len();
        (1..=MOST_SPAN.min(here / 2)).find_map(|span| {
            let (first, second) = (&legs[here - 2 * span..here - span], &legs[here - span..]);
            let alike = |(one, other): (&Leg, &Leg)| {
                one.phase == other.phase && one.rounds == other.rounds && !one.continues && !other.continues
            };
            if !first.iter().zip(second).all(alike) || second.first()?.phase != phase {
                return None;
            }
            if !is_aligned(legs, span) {
                return None;
            }
            self.turn_of(second, (&first.first()?.start, &second.first()?.start, values))
        })
    }

    fn turn_of(&self, legs: &[Leg], starts: (&Values, &Values, &Values)) -> Option<Turn> {
        let mut walker = self.clone();
        let mut taken = self.taken.clone();
        taken.insert(self.index.clone());
        let mut values = Values::new();
        let (mut moving, mut along) = (Vec::new(), Vec::new());
        let mut line: Option<([Value; 3], Value)> = None;
        for (name, now) in starts.2 {
            let numbers = [starts.0.get(name)?.clone(), starts.1.get(name)?.clone(), now.clone()];
            if numbers[0] == numbers[1] && numbers[1] == numbers[2] {
                values.insert(name.clone(), now.clone());
                continue;
            }
            // What moves in proportion to another value is what it is where that is.
            if let Some(along_it) = line.as_ref().and_then(|(first, symbol)| on_a_line(first, &numbers, symbol)) {
                values.insert(name.clone(), along_it.clone());
                along.push((name.clone(), along_it));
                continue;
            }
            let (low, high) = interval_around(&numbers)?;
            let symbol = fresh(name, &mut taken);
            let (low, high) = (Value::rational(low), Value::rational(high));
            let variable = Value::variable(&symbol);
            walker.assumptions.assume(Relation::Gte, &variable, &low);
            walker.assumptions.assume(Relation::Lte, &variable, &high);
            values.insert(name.clone(), variable.clone());
            line.get_or_insert_with(|| (numbers, variable.clone()));
            let (start, next) = (now.clone(), variable);
            moving.push(Moving { variable: name.clone(), symbol, start, next, between: Some((low, high)) });
        }
        let mut rounds = 0usize;
        let mut again = Vec::new();
        for (place, leg) in legs.iter().enumerate() {
            let Rounds::Count(count) = &leg.rounds else { return None };
            let count = count.as_rational().filter(BigRational::is_integer)?.to_integer().to_usize()?;
            rounds = rounds.saturating_add(count);
            if rounds > MOST_ROUNDS {
                return None;
            }
            let (leg, next, onward) = walker.same_leg(leg.phase, &values, count)?;
            let wanted = legs.get(place + 1).or(legs.first())?.phase;
            if next != Next::Phase(wanted) {
                return None;
            }
            values = onward;
            again.push(leg);
        }
        for one in &mut moving {
            one.next = values.get(&one.variable)?.clone();
            let inside = |relation, bound: &Value| walker.assumptions.decide(relation, &one.next, bound) == Some(true);
            let (low, high) = one.between.as_ref()?;
            if !inside(Relation::Gte, low) || !inside(Relation::Lte, high) {
                return None;
            }
        }
        let ahead = moving.iter().map(|one: &Moving| (one.symbol.clone(), one.next.clone())).collect();
        let stays = |(name, value): (&Name, &Value)| {
            let same = |before: &Value| walker.assumptions.decide(Relation::Eq, value, before) == Some(true);
            if let Some((_, place)) = along.iter().find(|(other, _)| other == name) {
                return place.substitute(&ahead).is_ok_and(|place| same(&place));
            }
            moving.iter().any(|one| one.variable == *name) || starts.2.get(name).is_some_and(same)
        };
        values.iter().all(stays).then_some(())?;
        Some(Turn { orbit: Orbit { moving, along }, legs: again, assumptions: walker.assumptions })
    }

    /// A leg of so many rounds from symbolic values; nothing if a test on the way is not decided, or differently.
    fn same_leg(&self, phase: usize, values: &Values, count: usize) -> Option<(Leg, Next, Values)> {
        let here = self.period.phases.get(phase)?;
        let mut rounds: Vec<(&Edge, Values)> = Vec::new();
        let mut now = values.clone();
        let next = loop {
            let edge = self.choose(&here.edges, &now, &self.assumptions).ok()?;
            let onward = self.image(edge, &now).ok()?;
            let onward = onward.into_iter().map(|(name, value)| (name, self.assumptions.simplify(&value))).collect();
            rounds.push((edge, std::mem::replace(&mut now, onward)));
            if edge.next != Next::Phase(phase) {
                break edge.next.clone();
            }
            if rounds.len() >= count {
                return None;
            }
        };
        if rounds.len() != count {
            return None;
        }
        let by_form = if rounds.len() > FEW_ROUNDS { self.by_form(&rounds, values) } else { None };
        let units = match by_form {
            Some(units) => units,
            None => self.compressed(&rounds).ok()?,
        };
        let leg = Leg {
            phase,
            rounds: Rounds::Count(Value::integer(i64::try_from(count).ok()?)),
            start: values.clone(),
            closed: Vec::new(),
            index: self.index.clone(),
            conditions: Vec::new(),
            continues: false,
            units,
            kept: None,
        };
        Some((leg, next, now))
    }

    /// The rounds in closed form, where that gives the values that were found one by one.
    fn by_form(&self, rounds: &[(&Edge, Values)], values: &Values) -> Option<Vec<Unit>> {
        let (round, _) = rounds.first()?;
        if round.next == rounds.last()?.0.next || !rounds.iter().all(|(edge, _)| edge.segments == round.segments) {
            return None;
        }
        let forms = self.forms(round, values).ok()?;
        if !forms.closed.iter().all(|(_, closed)| closed.conditions.is_empty()) {
            return None;
        }
        for (number, (_, now)) in rounds.iter().enumerate() {
            let found = self.values_at(values, &forms.closed, &Value::integer(number as i64)).ok()?;
            let same = |(name, value): (&Name, &Value)| {
                found.get(name).is_some_and(|other| self.assumptions.decide(Relation::Eq, value, other) == Some(true))
            };
            if !now.iter().all(same) {
                return None;
            }
        }
        let total = Value::integer(i64::try_from(rounds.len()).ok()?);
        self.units(&round.segments, values, &forms.closed, Some(&total)).ok()
    }
}

/// The value that is on a line with another one, which the symbol stands for, at the start of three turns: `n + s*(x-m)`.
fn on_a_line(first: &[Value; 3], other: &[Value; 3], symbol: &Value) -> Option<Value> {
    let moved = |numbers: &[Value; 3], turn: usize| numbers[turn + 1].sub(&numbers[turn]).ok();
    let (before, after) = (moved(first, 0)?, moved(first, 1)?);
    let slope = moved(other, 1)?.div(&after).ok()?;
    let same = |one: &Value, other: &Value| Assumptions::default().decide(Relation::Eq, one, other) == Some(true);
    if before.is_zero() || !same(&moved(other, 0)?, &slope.mul(&before).ok()?) {
        return None;
    }
    let rest = other[2].sub(&slope.mul(&first[2]).ok()?).ok()?;
    symbol.mul(&slope).ok()?.add(&rest).ok()
}

/// Whether the next leg begins a round of the system: as many legs a round as it takes for their order to repeat.
pub(super) fn is_aligned(legs: &[Leg], span: usize) -> bool {
    let repeats = |from: usize| (from..legs.len() - span).all(|place| legs[place].phase == legs[place + span].phase);
    let lead = (0..legs.len() - span).find(|from| repeats(*from)).unwrap_or(legs.len());
    legs.len() >= lead + span && (legs.len() - lead).is_multiple_of(span)
}

pub(super) fn fresh(variable: &Name, taken: &mut BTreeSet<Name>) -> Name {
    let base = variable.as_str();
    let numbered = (0..).map(|number| Name::new(&format!("{base}{number}")));
    let mut all = ["x", "y", "z"].into_iter().map(Name::new).chain(numbered);
    let name = all.find(|name| !taken.contains(name)).unwrap_or_else(|| variable.clone());
    taken.insert(name.clone());
    taken.insert(Name::new(&format!("{name}1")));
    name
}

/// The legs without what the property does not ask for and what would move on.
pub(super) fn without_moving(legs: &mut [Leg], orbit: &Orbit, asked: &BTreeSet<Name>) {
    for leg in legs {
        leg.units = only(&leg.units, &|term| {
            matches!(term.node(), Node::Observe(name, _) if asked.contains(name)) || !shows_moving(term, orbit)
        });
    }
}

/// Stretches without what moves on.
pub(super) fn standing(units: &[Unit], orbit: &Orbit) -> Vec<Unit> {
    only(units, &|term| !shows_moving(term, orbit))
}

fn shows_moving(term: &Term, orbit: &Orbit) -> bool {
    term.values().into_iter().any(|value| orbit.moves(value))
}

/// Stretches with what is to be kept of what they show.
pub(super) fn only(units: &[Unit], keep: &dyn Fn(&Term) -> bool) -> Vec<Unit> {
    let mut units = units.to_vec();
    let only = |segment: &mut Segment| segment.observed.retain(|term| keep(term));
    for unit in &mut units {
        match unit {
            Unit::Single(segment) => only(segment),
            Unit::Repeat { segments, .. } => segments.iter_mut().for_each(only),
        }
    }
    units
}

/// The observers that a property names.
pub(super) fn observers(property: &Term) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    let mut rest = vec![property];
    while let Some(term) = rest.pop() {
        if let Node::Observe(name, _) = term.node() {
            found.insert(name.clone());
        }
        rest.extend(term.children());
    }
    found
}
