//! Legs that are gone through a number of times that is a parameter, as of `(Go_7 ; Go_0)^k`: where it is asked whether a further
//! copy is to come, the turn before is followed once more for any number of copies that are left, and for the last of them.

use super::trajectory::{Leg, Rounds, Values, Walker};
use super::unit::Unit;
use crate::name::Name;
use crate::period::{Next, Segment};
use crate::recurrence::{Closed, Piece};
use crate::value::{Relation, Value};

/// Legs that a turn may have, and its stretches, all of which are written out.
const MOST_SPAN: usize = 12;
const MOST_STRETCHES: usize = 1_000;

/// All turns as one leg, from which leg on they are, and where the last of them leads.
pub(super) struct Copies {
    pub(super) from: usize,
    pub(super) leg: Leg,
    pub(super) onward: (Next, Values),
}

impl Walker<'_> {
    /// The turns of which the run, having come to these values, begins the last leg of the first: those after it are as it is, each
    /// with one copy less to come, until none is.
    pub(super) fn copies(&self, history: &[(usize, Values)]) -> Option<Copies> {
        let last = history.len().checked_sub(1)?;
        (last.saturating_sub(MOST_SPAN)..=last).rev().find_map(|from| {
            let (phase, start) = &history[from];
            let counters = start.iter().flat_map(|(counter, value)| {
                self.last_ones(value).into_iter().map(move |(last_one, up)| (counter, value, last_one, up))
            });
            counters.into_iter().find_map(|(counter, value, last_one, up)| {
                let turns = Turns { phase: *phase, start, counter, value, last_one, up, span: last + 1 - from };
                let (leg, onward) = turns.followed(self)?;
                Some(Copies { from, leg, onward })
            })
        })
    }

    /// What a counter may be in the last turn, and whether it counts up: down to 0 where it counts the copies behind this one,
    /// or to 1 where it counts this one, too; up to a parameter, or to one less.
    fn last_ones(&self, value: &Value) -> Vec<(Value, bool)> {
        let known = &self.assumptions;
        if known.is_natural(value) != Some(true) {
            return Vec::new();
        }
        let symbolic = !value.variables().is_empty();
        let down = [Value::zero(), Value::one()].into_iter().filter(|_| symbolic).map(|last| (last, false));
        let limits = known.naturals().iter().map(Value::variable).filter(|limit| limit != value);
        let up = limits.flat_map(|limit| [Some(limit.clone()), limit.sub(&Value::one()).ok()]).flatten();
        down.chain(up.map(|last| (last, true))).collect()
    }
}

/// Turns from a phase with these values, of which one counts the copies that are left.
struct Turns<'a> {
    phase: usize,
    start: &'a Values,
    counter: &'a Name,
    value: &'a Value,
    /// What the counter is in the last turn, and whether it counts up to that.
    last_one: Value,
    up: bool,
    span: usize,
}

impl Turns<'_> {
    fn followed(&self, walker: &Walker<'_>) -> Option<(Leg, (Next, Values))> {
        let last_one = &self.last_one;
        let further = if self.up { last_one.sub(self.value) } else { self.value.sub(last_one) }.ok()?;
        let moved = |value: &Value, by: &Value| if self.up { value.add(by) } else { value.sub(by) }.ok();
        if walker.assumptions.is_natural(&further) != Some(true) {
            return None;
        }
        let mut some = walker.clone();
        let left = self.fresh(walker);
        let number = Value::variable(&left);
        some.assumptions.assume_natural(&left);
        some.assumptions.assume(if self.up { Relation::Lss } else { Relation::Gtr }, &number, last_one);
        let (stretches, (next, onward)) = self.once(&mut some, &number)?;
        let same = |(name, value): (&Name, &Value)| {
            let wanted =
                if name == self.counter { moved(&number, &Value::one()) } else { self.start.get(name).cloned() };
            wanted.is_some_and(|wanted| some.assumptions.decide(Relation::Eq, value, &wanted) == Some(true))
        };
        if next != Next::Phase(self.phase) || onward.len() != self.start.len() || !onward.iter().all(same) {
            return None;
        }
        let (in_last, onward) = self.once(&mut walker.clone(), last_one)?;
        if stretches != in_last || stretches.iter().any(|stretch| mentions(stretch, &left)) {
            return None;
        }
        let index = &walker.index;
        let form = moved(self.value, &Value::variable(index))?;
        let pieces = vec![Piece { from: Value::zero(), until: None, form }];
        let closed = Closed { variable: self.counter.clone(), pieces, conditions: Vec::new() };
        let count = further.add(&Value::one()).ok()?;
        let leg = Leg {
            phase: self.phase,
            rounds: Rounds::Count(count.clone()),
            start: self.start.clone(),
            closed: vec![(self.counter.clone(), closed)],
            index: index.clone(),
            conditions: Vec::new(),
            continues: false,
            units: vec![Unit::Repeat { count: Some(count), index: index.clone(), segments: stretches }],
            kept: None,
        };
        Some((leg, onward))
    }

    /// One turn, stretch by stretch, with so many copies left; and where it leads.
    fn once(&self, walker: &mut Walker<'_>, left: &Value) -> Option<(Vec<Segment>, (Next, Values))> {
        let mut values = self.start.clone();
        values.insert(self.counter.clone(), left.clone());
        let (mut phase, mut stretches) = (self.phase, Vec::new());
        for place in 1..=self.span {
            let (leg, (next, onward)) = walker.leg(phase, &values).ok()?;
            if !leg.conditions.is_empty() || matches!(leg.rounds, Rounds::Forever(_)) {
                return None;
            }
            for unit in &leg.units {
                stretches.extend(written_out(unit)?);
                if stretches.len() > MOST_STRETCHES {
                    return None;
                }
            }
            match next {
                _ if place == self.span => return Some((stretches, (next, onward))),
                Next::Phase(next) => (phase, values) = (next, onward),
                Next::End(_) => return None,
            }
        }
        None
    }

    /// A name for how many copies are left.
    fn fresh(&self, walker: &Walker<'_>) -> Name {
        let names = (1..).map(|number| Name::new(&format!("{}{number}", self.counter)));
        let used = |name: &Name| walker.taken.contains(name) || *name == walker.index;
        names.into_iter().find(|name| !used(name)).unwrap_or_else(|| self.counter.clone())
    }
}

fn mentions(stretch: &Segment, name: &Name) -> bool {
    let shown = stretch.observed.iter().any(|term| term.values().any(|value| value.mentions(name)));
    shown || stretch.duration.mentions(name)
}

/// The stretches of a number of rounds that is known, if they are so few.
fn written_out(unit: &Unit) -> Option<Vec<Segment>> {
    let Unit::Repeat { count, segments, .. } = unit else { return unit.round(&Value::zero()).ok() };
    let count = count.as_ref()?.as_rational().filter(|count| count.is_integer())?.to_integer();
    let count = usize::try_from(count).ok().filter(|count| count.saturating_mul(segments.len()) <= MOST_STRETCHES)?;
    let rounds = (0..count).map(|number| unit.round(&Value::integer(i64::try_from(number).ok()?)).ok());
    Some(rounds.collect::<Option<Vec<_>>>()?.concat())
}
