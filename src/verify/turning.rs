//! A property whose rounds begin inside a turn that moves on: its rounds are laid along the turns from a symbol, until one
//! begins where the one before began, a turn later.

use std::collections::BTreeMap;

use super::Outcome;
use super::lay::{Laid, Matcher};
use super::orbit::{Moving, Orbit};
use super::property::{outcome_of, units_of};
use super::trajectory::Trajectory;
use super::unit::Unit;
use crate::name::Name;
use crate::period::Segment;
use crate::substitution::substitute_values;
use crate::value::Value;

/// Rounds of the property before they must begin at the same place of a turn.
const MOST_ROUNDS: usize = 64;
/// Turns that one round of the property may span.
const MOST_TURNS: usize = 6;

type Images = BTreeMap<Name, Value>;

impl Matcher<'_> {
    /// The match round by round, where the rounds of the property come into step with the turns.
    pub(super) fn turn_by_turn(&self, trajectory: &Trajectory, cycle: usize) -> Option<Outcome> {
        let orbit = trajectory.orbit.as_ref()?;
        let turns = Turns { turn: units_of(&trajectory.legs[cycle..]), orbit };
        // Where a round of the property ends that begins with a turn; then a round from there.
        let (_, first) = self.one(Vec::new(), &turns.from(orbit.symbols())?, trajectory)?;
        let ahead = turns.ahead(orbit.symbols(), first.turns)?;
        let (steady, rest) = self.one(first.units.clone(), &turns.from(ahead)?, trajectory)?;
        // It must end at the same place, so many turns later.
        let next = turns.ahead(orbit.symbols(), rest.turns)?;
        if rest.turns == 0 || rest.units != images(&first.units, &turns.named(&next))? {
            return None;
        }
        let mut prefix = trajectory.opening.clone();
        prefix.extend(units_of(&trajectory.legs[..cycle]));
        let (rounds, starts) = self.first_rounds(prefix, &turns, &first, trajectory)?;
        let moved = orbit.moving.iter().cloned().zip(starts.into_iter().zip(next));
        let moving = moved.map(|(one, (start, next))| Moving { start, next, ..one }).collect();
        Some(outcome_of(rounds, vec![steady], Some(&Orbit { moving, along: orbit.along.clone() })))
    }

    /// A round along these units and the turns behind them, and what is left of the last turn that was begun.
    fn one(&self, units: Vec<Unit>, turns: &[Vec<Unit>], trajectory: &Trajectory) -> Option<(Laid, Left)> {
        let all = units.into_iter().chain(turns.iter().flatten().cloned()).collect();
        let laid = self.lay(all, false, (&[], trajectory)).ok()?;
        let left = left(&laid.rest, turns)?;
        Some((laid, left))
    }

    /// The first rounds, with numbers, up to one that ends where the steady ones begin, and the values of what moves
    /// there.
    fn first_rounds(
        &self,
        prefix: Vec<Unit>,
        turns: &Turns<'_>,
        steady: &Left,
        trajectory: &Trajectory,
    ) -> Option<(Vec<Laid>, Vec<Value>)> {
        let mut partial = prefix;
        let start: Vec<Value> = turns.orbit.moving.iter().map(|one| one.start.clone()).collect();
        let mut begun = 0;
        let mut rounds = Vec::new();
        for _ in 0..MOST_ROUNDS {
            let (laid, left) = self.one(partial, &turns.from(turns.ahead(start.clone(), begun)?)?, trajectory)?;
            begun += left.turns;
            rounds.push(laid);
            if let Some(back) = begun.checked_sub(steady.turns) {
                let values = turns.ahead(start.clone(), back)?;
                if images(&steady.units, &turns.named(&values))? == left.units {
                    return Some((rounds, values));
                }
            }
            partial = left.units;
        }
        None
    }
}

/// A turn from symbols, and what moves on.
struct Turns<'a> {
    turn: Vec<Unit>,
    orbit: &'a Orbit,
}

impl Turns<'_> {
    fn named(&self, values: &[Value]) -> Images {
        self.orbit.moving.iter().map(|one| one.symbol.clone()).zip(values.iter().cloned()).collect()
    }

    /// The values of what moves, so many turns later.
    fn ahead(&self, values: Vec<Value>, turns: usize) -> Option<Vec<Value>> {
        (0..turns).try_fold(values, |values, _| {
            let map = self.named(&values);
            self.orbit.moving.iter().map(|one| one.next.substitute(&map).ok()).collect()
        })
    }

    /// Some turns from these values on.
    fn from(&self, values: Vec<Value>) -> Option<Vec<Vec<Unit>>> {
        let at = |turn| images(&self.turn, &self.named(&self.ahead(values.clone(), turn)?));
        (0..MOST_TURNS).map(at).collect()
    }
}

/// What is left of a run behind which turns come.
struct Left {
    /// Up to the next turn.
    units: Vec<Unit>,
    /// The turns that have been begun.
    turns: usize,
}

fn left(rest: &[Unit], turns: &[Vec<Unit>]) -> Option<Left> {
    let mut units = rest.to_vec();
    let mut begun = turns.len();
    for turn in turns.iter().rev() {
        if !units.ends_with(turn) {
            break;
        }
        units.truncate(units.len() - turn.len());
        begun -= 1;
    }
    // With turns to spare, nothing was cut for want of any.
    (begun < turns.len()).then_some(Left { units, turns: begun })
}

/// Stretches with values for symbols.
fn images(units: &[Unit], map: &Images) -> Option<Vec<Unit>> {
    let segment = |segment: &Segment| -> Option<Segment> {
        let observed = segment.observed.iter().map(|term| substitute_values(term, map).ok());
        Some(Segment { duration: segment.duration.substitute(map).ok()?, observed: observed.collect::<Option<_>>()? })
    };
    let unit = |unit: &Unit| -> Option<Unit> {
        Some(match unit {
            Unit::Single(one) => Unit::Single(segment(one)?),
            Unit::Repeat { count, index, segments } => Unit::Repeat {
                count: count.as_ref().map(|count| count.substitute(map)).transpose().ok()?,
                index: index.clone(),
                segments: segments.iter().map(segment).collect::<Option<_>>()?,
            },
        })
    };
    units.iter().map(unit).collect()
}
