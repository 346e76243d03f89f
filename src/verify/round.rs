//! Rounds that go on for ever: one of several that a phase has, values that come round exactly, and what keeps a phase
//! going.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use super::count::Count;
use super::trajectory::{Leg, Rounds, Trajectory, Values, Walker};
use super::unit::Unit;
use crate::name::Name;
use crate::period::{Edge, End, Next, Test};
use crate::recurrence::{Closed, Piece};
use crate::value::{Atom, Relation, Value};

/// A phase that a run never leaves, since two values never come to be equal.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Endless {
    /// The phase.
    pub phase: usize,
    /// The inequality that holds after every round.
    pub kept: Test,
    /// How far apart its sides are when the phase begins, where that is a number.
    pub first: Option<BigRational>,
    /// How far apart they are at the closest of the rounds looked at.
    pub closest: Option<BigRational>,
}

/// Rounds that are taken as one leg where rounds have no end.
pub(super) struct Turn {
    /// How many.
    pub(super) rounds: Value,
    /// The values behind them.
    pub(super) onward: Values,
    /// The forms within them.
    pub(super) shown: Vec<(Name, Closed)>,
}

/// Rounds after which values may come round.
const MOST_ROUNDS: i64 = 64;
/// Digits of a value at which following a run one by one is given up.
const MOST_BITS: u64 = 2_000;
/// The size of a form at which following a run leg by leg is given up.
const MOST_SIZE: usize = 120;
/// The latest round from which on they may.
const LATEST: i64 = 1_000;

impl Walker<'_> {
    /// Of several rounds of a phase, the one that is taken from these values, where it is then taken for ever, or so
    /// often as the symbols tell.
    pub(super) fn one_of_several<'e>(
        &self,
        phase: usize,
        edges: &'e [Edge],
        values: &Values,
    ) -> Option<(&'e Edge, Count)> {
        let Ok(edge) = self.choose(edges, values, &self.assumptions) else {
            return self.counted_from_none(phase, edges, values);
        };
        if edge.next != Next::Phase(phase) {
            return None;
        }
        let count = self.count(edge, values).ok()?;
        // Numbers are followed one by one, as long as a number says.
        let one_by_one = count.stays.as_ref().is_some_and(is_number) && values.values().all(is_number);
        (count.conditions.is_empty() && !one_by_one).then_some((edge, count))
    }

    /// The same where it is not known which round comes: one that comes so many times, none perhaps, before another does.
    fn counted_from_none<'e>(&self, phase: usize, edges: &'e [Edge], values: &Values) -> Option<(&'e Edge, Count)> {
        edges.iter().filter(|edge| edge.next == Next::Phase(phase)).find_map(|edge| {
            let count = self.count(edge, values).ok()?;
            let onward = self.values_at(values, &count.closed, count.stays.as_ref()?).ok()?;
            // Where nothing has changed there may have been no round.
            (count.conditions.is_empty() && onward != *values).then_some((edge, count))
        })
    }

    /// Of rounds without end, how many are to be taken as one leg: those after which all values are as at first, or those
    /// before values come round. Nothing where they do not.
    pub(super) fn until_it_repeats(&self, values: &Values, count: &Count) -> Option<Turn> {
        if !count.conditions.is_empty() && !count.closed.is_empty() {
            return None;
        }
        let some = |rounds: i64| {
            let rounds = Value::integer(rounds);
            let onward = self.values_at(values, &count.closed, &rounds).ok()?;
            Some(Turn { rounds, onward, shown: count.closed.clone() })
        };
        self.number_of_rounds(values, count).and_then(some).or_else(|| self.turns_to_a_symbol(values, count))
    }

    /// The rounds of a turn that is counted modulo a symbol: n of `mod(i,n)`.
    fn turns_to_a_symbol(&self, values: &Values, count: &Count) -> Option<Turn> {
        let index = Value::variable(&self.index);
        let floors = count.closed.iter().flat_map(|(_, closed)| &closed.pieces).flat_map(|piece| piece.form.atoms());
        let turns = floors.filter_map(|atom| match &atom {
            Atom::Floor(inner) => Value::one().div(&inner.linear_in(&self.index)?.0).ok(),
            _ => None,
        });
        let turns = turns.filter(|turn| {
            let least = self.assumptions.decide(Relation::Gte, turn, &Value::one()) == Some(true);
            least && !turn.mentions(&self.index) && self.assumptions.is_natural(turn) == Some(true)
        });
        // From any round on it comes again after so many: what is shown does, too.
        let comes_round = |turn: &Value| {
            count.closed.iter().all(|(_, closed)| {
                let [Piece { until: None, form, .. }] = closed.pieces.as_slice() else { return false };
                let mut known = self.assumptions.clone();
                known.assume_natural(&self.index);
                let later = index.add(turn).and_then(|later| form.with(&self.index, &later));
                later.is_ok_and(|later| known.decide(Relation::Eq, &later, form) == Some(true))
            })
        };
        let rounds = turns.into_iter().find(comes_round)?;
        // Within one turn `mod(i,n)` is i.
        let mut known = self.assumptions.clone();
        known.assume_natural(&self.index);
        known.assume(Relation::Lss, &index, &rounds);
        let mut shown = count.closed.clone();
        for piece in shown.iter_mut().flat_map(|(_, closed)| &mut closed.pieces) {
            for atom in piece.form.atoms() {
                let Atom::Floor(inner) = &atom else { continue };
                let is = |relation, bound: i64| known.decide(relation, inner, &Value::integer(bound)) == Some(true);
                if is(Relation::Gte, 0) && is(Relation::Lss, 1) {
                    piece.form = piece.form.with_atom(&atom, &Value::zero()).ok()?;
                }
            }
        }
        Some(Turn { rounds, onward: values.clone(), shown })
    }

    fn number_of_rounds(&self, values: &Values, count: &Count) -> Option<i64> {
        if count.closed.is_empty() {
            return Some(1);
        }
        let after = |rounds: i64| self.values_at(values, &count.closed, &Value::integer(rounds)).ok();
        let comes_round = |from: i64| -> Option<i64> {
            let first = after(from)?;
            let rests = |(_, closed): &(Name, Closed)| {
                closed.pieces.last().is_some_and(|last| last.until.is_none() && !last.form.mentions(&self.index))
                    && last_piece(closed).is_some_and(|last| last <= from)
            };
            if count.closed.iter().all(rests) {
                return Some(1);
            }
            let changing = |name: &Name| first.get(name).is_some_and(is_number);
            if !count.closed.iter().all(|(name, _)| changing(name)) {
                return None;
            }
            (1..=MOST_ROUNDS).find(|rounds| from.checked_add(*rounds).and_then(after).as_ref() == Some(&first))
        };
        if let Some(rounds) = comes_round(0) {
            return Some(rounds);
        }
        let settled = count.closed.iter().map(|(_, closed)| last_piece(closed)).collect::<Option<Vec<_>>>()?;
        let from = settled.into_iter().max().filter(|from| (1..=LATEST).contains(from))?;
        comes_round(from).map(|_| from)
    }

    /// The inequality of values that change that a round asks for before it is followed by another, over the variables
    /// of the phase, where equality would end the phase.
    pub(super) fn kept(&self, phase: usize, round: &Edge) -> Option<Test> {
        let here = self.period.phases.get(phase)?;
        let changes = |name: &Name| round.map.get(name).is_some_and(|image| *image != Value::variable(name));
        let ends = |test: &Test| {
            let equal = test.negated();
            let mut others = here.edges.iter().filter(|edge| edge.tests.contains(&equal)).peekable();
            let left =
                |edge: &Edge| !matches!(&edge.next, Next::End(End::Livelock { .. })) && edge.next != Next::Phase(phase);
            others.peek().is_some() && others.all(left)
        };
        round.tests.iter().zip(&round.after).find_map(|(test, after)| {
            let after = after.as_ref()?;
            let names = [&after.left, &after.right].into_iter().flat_map(|side| side.variables());
            let asks = after.relation == Relation::Neq && names.into_iter().any(|name| changes(&name)) && ends(test);
            asks.then(|| after.clone())
        })
    }
}

impl Walker<'_> {
    /// The same of rounds that were followed one by one, where it is one kind of round all the while.
    pub(super) fn always_kept(&self, phase: usize, rounds: &[(&Edge, Values)]) -> Option<Test> {
        let (round, _) = rounds.first()?;
        let same = |(edge, _): &(&Edge, Values)| std::ptr::eq(*edge, *round) && edge.next == Next::Phase(phase);
        if rounds.iter().all(same) { self.kept(phase, round) } else { None }
    }
}

/// The phase that the run never leaves, with the inequality that keeps it there.
pub(super) fn endless(trajectory: &Trajectory) -> Option<Endless> {
    let forever = |leg: &&Leg| matches!(leg.rounds, Rounds::Forever(_));
    let first = trajectory.legs.iter().find(forever).or_else(|| stuck(trajectory))?;
    let from = trajectory.legs.iter().position(|leg| std::ptr::eq(leg, first))?;
    let kept = first.kept.clone()?;
    let legs = &trajectory.legs[from..];
    if !legs.iter().all(|leg| leg.kept.as_ref() == Some(&kept)) {
        return None;
    }
    let gap = kept.left.sub(&kept.right).ok()?;
    // The legs of the phase before those that repeat begin further off.
    let before = trajectory.legs[..from].iter().rev().take_while(|leg| leg.phase == first.phase);
    let start = before.last().unwrap_or(first);
    let distance = |values: &Values| gap.substitute(values).ok()?.as_rational().map(|gap| gap.abs());
    let seen = legs.iter().flat_map(|leg| {
        (0..MOST_ROUNDS).filter_map(|round| {
            let mut here = leg.start.clone();
            for (name, closed) in &leg.closed {
                here.insert(name.clone(), closed.at(&leg.index, &Value::integer(round), &trajectory.assumptions)?);
            }
            distance(&here)
        })
    });
    Some(Endless { phase: first.phase, closest: seen.min(), first: distance(&start.start), kept })
}

/// A leg of a phase in which the run goes round for ever.
pub(super) fn stuck(trajectory: &Trajectory) -> Option<&Leg> {
    let legs = trajectory.legs.get(trajectory.cycle?..)?;
    let first = legs.first()?;
    legs.iter().all(|leg| leg.phase == first.phase).then_some(first)
}

/// The index from which on the last form holds.
fn last_piece(closed: &Closed) -> Option<i64> {
    let from = closed.pieces.last()?.from.as_rational()?;
    from.is_integer().then(|| from.to_integer().to_i64()).flatten()
}

/// One round of a system.
type Stretches = Vec<Unit>;

/// The run in rounds of the system: as many phases a round as it takes for their order to repeat. The first
/// rounds, then those that repeat; nothing if the run repeats in the middle of a leg.
pub(super) fn in_step(trajectory: &Trajectory, cycle: usize) -> Option<(Vec<Stretches>, Vec<Stretches>)> {
    let mut groups: Vec<(usize, Vec<Unit>)> = Vec::new();
    let mut start = None;
    for (number, leg) in trajectory.legs.iter().enumerate() {
        if number == cycle {
            if leg.continues {
                return None;
            }
            start = Some(groups.len());
        }
        match groups.last_mut() {
            Some((_, units)) if leg.continues => units.extend(leg.units.iter().cloned()),
            _ => groups.push((leg.phase, leg.units.clone())),
        }
    }
    let start = start?;
    let length = groups.len() - start;
    let at = |number: usize| &groups[if number < groups.len() { number } else { start + (number - start) % length }];
    let far = groups.len() + 2 * length;
    let (lead, span) = (0..=start).find_map(|lead| {
        let span = (1..=length).find(|span| (lead..far).all(|number| at(number).0 == at(number + span).0))?;
        Some((lead, span))
    })?;
    let round = |from: usize, to: usize| (from..to).flat_map(|number| at(number).1.clone()).collect::<Vec<Unit>>();
    let mut opening = vec![round(0, lead + span)];
    if let Some(first) = opening.first_mut() {
        first.splice(0..0, trajectory.opening.iter().cloned());
    }
    let mut from = lead + span;
    while from < start {
        opening.push(round(from, from + span));
        from += span;
    }
    // What moves on from turn to turn begins with a turn.
    if trajectory.orbit.is_some() && from != start {
        return None;
    }
    let mut steady = Vec::new();
    let mut covered = 0usize;
    while covered == 0 || !covered.is_multiple_of(length) {
        steady.push(round(from + covered, from + covered + span));
        covered += span;
    }
    Some((opening, steady))
}

pub(super) fn is_long(value: &Value) -> bool {
    value.bits() > MOST_BITS
}

/// A form of symbols in which each leg has left roundings of the roundings of the leg before: what it is compared with
/// costs some times more from leg to leg.
pub(super) fn is_large(value: &Value) -> bool {
    value.size() > MOST_SIZE && !is_known(value)
}

/// A number, or one with roots of numbers: two of them can be compared.
pub(super) fn is_known(value: &Value) -> bool {
    let root = |atom: &Atom| matches!(atom, Atom::Root(inner) if inner.as_rational().is_some());
    is_number(value) || value.atoms().iter().all(root)
}

fn is_number(value: &Value) -> bool {
    value.as_rational().is_some()
}
