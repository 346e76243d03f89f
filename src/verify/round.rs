//! Rounds that go on for ever: one of several that a phase has, values that come round exactly, and what keeps a phase
//! going.

use num_traits::ToPrimitive;

use super::Verdict;
use super::count::Count;
use super::trajectory::{Leg, Rounds, Trajectory, Values, Walker, is_number};
use crate::name::Name;
use crate::period::{Edge, End, Next, Test};
use crate::recurrence::Closed;
use crate::value::{Relation, Value};

/// Rounds after which values may come round.
const MOST_ROUNDS: i64 = 64;
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
        let edge = self.choose(edges, values, &self.assumptions).ok()?;
        if edge.next != Next::Phase(phase) {
            return None;
        }
        let count = self.count(edge, values).ok()?;
        let plain = count.conditions.is_empty() && (count.stays.is_none() || !values.values().all(is_number));
        plain.then_some((edge, count))
    }

    /// Of rounds without end, how many are to be taken as one leg: those after which all values are as at first, or those
    /// before values come round. Nothing where they do not.
    pub(super) fn until_it_repeats(&self, values: &Values, count: &Count) -> Option<i64> {
        if count.closed.is_empty() {
            return Some(1);
        }
        if !count.conditions.is_empty() {
            return None;
        }
        let after = |rounds: i64| self.values_at(values, &count.closed, &Value::integer(rounds)).ok();
        let comes_round = |from: i64| -> Option<i64> {
            let first = after(from)?;
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

    /// The inequality of values that change that each round of a phase asks for, over the variables of the phase.
    pub(super) fn kept(&self, phase: usize) -> Option<Test> {
        let here = self.period.phases.get(phase)?;
        let round = here.rounds(phase).next()?;
        let changes = |name: &Name| round.map.get(name).is_some_and(|image| *image != Value::variable(name));
        let asks = |test: &&Test| {
            let names = [&test.left, &test.right].into_iter().flat_map(|side| side.variables());
            test.relation == Relation::Neq && names.into_iter().any(|name| changes(&name))
        };
        round.after.iter().flatten().find(asks).cloned()
    }
}

/// What could be changed in the mission.
pub(super) fn feedback(verdict: &Verdict, trajectory: &Trajectory) -> Vec<String> {
    let mut feedback = Vec::new();
    let endless = |leg: &&Leg| matches!(leg.rounds, Rounds::Forever(_));
    let leg = trajectory.legs.iter().find(endless).or_else(|| stuck(trajectory));
    if !matches!(verdict, Verdict::Proved)
        && let Some(leg) = leg
        && let Some(kept) = &leg.kept
        && let Ok(gap) = kept.left.sub(&kept.right)
    {
        feedback.push(format!(
            "phase {} never ends, since no round comes to {} = {} exactly: allow a tolerance there, such as Gtr_{{abs({}),1/10}} in place of Neq_{{{},{}}}",
            leg.phase + 1, kept.left, kept.right, gap, kept.left, kept.right
        ));
    }
    if let Some(End::Silent { blocked, .. }) = &trajectory.end {
        feedback.extend(blocked.iter().map(|one| format!("{} waits for ever on port {}", one.component, one.port)));
    }
    feedback
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
