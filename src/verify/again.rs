//! A property that starts again and again: its rounds are those of the system, or begin wherever the one before ended.

use super::Outcome;
use super::lay::{Laid, Matcher, Missed};
use super::property::{Length, outcome_of, units_of};
use super::round::{in_step, stuck};
use super::seek::with_values;
use super::trajectory::{Rounds, Trajectory};
use super::unit::{Unit, shows};
use crate::name::Name;
use crate::period::{End, Segment};
use crate::term::Term;
use crate::value::{Relation, Value};

/// Rounds of the run that one round of the property is laid along at most.
const MOST_SPANNED: i64 = 256;

/// Rounds of the system that are taken together as one.
const MOST_TOGETHER: usize = 16;

impl Matcher<'_> {
    /// A property that starts again and again.
    pub(super) fn again(&self, trajectory: &Trajectory) -> Result<Outcome, Missed> {
        let Some(cycle) = trajectory.cycle else {
            // A run that comes to rest goes round in what it shows then.
            let resting = trajectory.resting();
            let found = resting.and_then(|(resting, cycle)| self.round_by_round(&resting, cycle).ok());
            return found.ok_or_else(|| self.no_cycle(trajectory));
        };
        let free = self
            .wanted
            .wants
            .last()
            .is_some_and(|want| matches!(want.length, Length::Unknown(_)) && want.shown.is_empty());
        let mut first = None;
        if free && let Some((opening, later)) = in_step(trajectory, cycle) {
            match self.round_for_round(&opening, &later, trajectory) {
                Ok((rounds, steady)) => {
                    let whole = if self.is_cut(&rounds, &steady) { self.elsewhere(trajectory, cycle) } else { None };
                    let orbit = trajectory.orbit.as_ref();
                    return Ok(whole.unwrap_or_else(|| outcome_of(rounds, steady, orbit)));
                }
                Err(missed) => first = Some(missed),
            }
        }
        match first {
            Some(Missed::Unsure(reason)) => return Err(Missed::Unsure(reason)),
            _ if let Some(found) = self.turn_by_turn(trajectory, cycle) => return Ok(found),
            // What no turn shows, is not shown wherever the rounds of the property begin.
            _ if trajectory.orbit.is_some() => {
                let mut units = trajectory.opening.clone();
                units.extend(units_of(&trajectory.legs));
                units.extend(units_of(&trajectory.legs[cycle..]));
                return Err(match self.lay(units, false, (&[], trajectory)) {
                    Err(missed) => missed,
                    Ok(_) => {
                        Missed::Unsure("the rounds of the property and of the run do not come into step".to_string())
                    }
                });
            }
            _ => {}
        }
        let several = || self.over_several(trajectory, cycle).filter(|_| free);
        match (self.round_by_round(trajectory, cycle), stuck(trajectory)) {
            (Err(Missed::Never(_)), _) if let Some(found) = several() => Ok(found),
            (Err(Missed::Never(reason)), Some(leg)) => {
                let text = format!("{reason}: phase {} never ends, its values repeat for ever", leg.phase + 1);
                Err(Missed::Never(text))
            }
            (answer, _) => answer,
        }
    }

    /// A round of the property for each round of the system: those before it repeats, and those that come again.
    fn round_for_round(
        &self,
        opening: &[Vec<Unit>],
        later: &[Vec<Unit>],
        trajectory: &Trajectory,
    ) -> Result<(Vec<Laid>, Vec<Laid>), Missed> {
        let lay = |rounds: &[Vec<Unit>]| -> Result<Vec<Laid>, Missed> {
            rounds.iter().map(|units| self.lay(units.clone(), true, (&[], trajectory))).collect()
        };
        Ok((lay(opening)?, lay(later)?))
    }

    /// A round of the property for each so many rounds of the system, where what is asked for a given time takes longer than one.
    fn over_several(&self, trajectory: &Trajectory, cycle: usize) -> Option<Outcome> {
        let (opening, later) = in_step(trajectory, cycle).filter(|_| trajectory.orbit.is_none())?;
        let most = self.spanned(&units_of(&trajectory.legs[cycle..]))?.checked_add(1)?;
        (2..=most.min(MOST_TOGETHER)).find_map(|count| {
            let round = |number: usize| {
                opening.get(number).unwrap_or_else(|| &later[(number - opening.len()) % later.len()]).clone()
            };
            let together = |from: usize| (from..from + count).flat_map(round).collect::<Vec<Unit>>();
            let first = opening.len().div_ceil(count);
            let before: Vec<Vec<Unit>> = (0..first).map(|number| together(number * count)).collect();
            // After as many as this the rounds of both begin together again.
            let again = (1..=later.len()).find(|rounds| (rounds * count).is_multiple_of(later.len()))?;
            let after: Vec<Vec<Unit>> = (first..first + again).map(|number| together(number * count)).collect();
            let (rounds, steady) = self.round_for_round(&before, &after, trajectory).ok()?;
            Some(outcome_of(rounds, steady, None))
        })
    }

    /// Why a run that does not repeat cannot show a property that starts again for ever.
    fn no_cycle(&self, trajectory: &Trajectory) -> Missed {
        let mut units = trajectory.opening.clone();
        units.extend(units_of(&trajectory.legs));
        let reason = match &trajectory.end {
            Some(End::Livelock { cycle, .. }) => {
                let cycle: Vec<&str> = cycle.iter().map(Name::as_str).collect();
                format!("the program goes round in no time ({}): time stops", cycle.join(", "))
            }
            Some(End::Silent { blocked, .. }) if !blocked.is_empty() => {
                let blocked: Vec<String> = blocked.iter().map(|one| one.to_string()).collect();
                format!("the run comes to a halt: {}", blocked.join("; "))
            }
            Some(End::Silent { observed, .. }) => {
                let shown: Vec<String> = observed.iter().map(Term::to_string).collect();
                let shown = if shown.is_empty() { "nothing".to_string() } else { shown.join(" with ") };
                format!("the run comes to rest: {shown} is shown for ever")
            }
            Some(_) => "the run ends".to_string(),
            None => match trajectory.legs.last().map(|leg| (&leg.rounds, leg)) {
                Some((Rounds::Forever(reason), leg)) => {
                    let forms: Vec<String> = leg.closed.iter().map(|(name, closed)| form_text(name, closed)).collect();
                    // What the endless leg shows may still be what is asked, again and again.
                    let shows_once = self.lay(units, false, (&[], trajectory)).is_ok();
                    let forms =
                        if forms.is_empty() { reason.clone() } else { format!("{}; {reason}", forms.join(", ")) };
                    let text = format!("phase {} never ends: {forms}", leg.phase + 1);
                    if shows_once && leg.units.iter().any(|unit| self.constant(unit)) {
                        return Missed::Unsure(text);
                    }
                    text
                }
                _ => {
                    let so_far = match self.lay(units, false, (&[], trajectory)) {
                        Err(Missed::Never(reason)) => format!("; so far {reason}"),
                        _ => String::new(),
                    };
                    let open = trajectory.open.first().cloned().unwrap_or_default();
                    return Missed::Unsure(format!("{open}{so_far}"));
                }
            },
        };
        Missed::Never(reason)
    }

    fn constant(&self, unit: &Unit) -> bool {
        let Unit::Repeat { index, segments, .. } = unit else { return false };
        segments
            .iter()
            .any(|segment| !segment.observed.iter().any(|term| term.values().any(|value| value.mentions(index))))
    }

    /// Rounds one after the other, wherever they start, until one starts where an earlier one did.
    fn round_by_round(&self, trajectory: &Trajectory, cycle: usize) -> Result<Outcome, Missed> {
        let round = units_of(&trajectory.legs[cycle..]);
        let mut partial = trajectory.opening.clone();
        partial.extend(units_of(&trajectory.legs[..cycle]));
        let mut seen: Vec<Vec<Unit>> = Vec::new();
        let mut laid: Vec<Laid> = Vec::new();
        for _ in 0..64 {
            if let Some(start) = seen.iter().position(|earlier| *earlier == partial) {
                let steady = laid.split_off(start);
                return Ok(outcome_of(laid, steady, None));
            }
            seen.push(partial.clone());
            let one = self.beginning_with(&partial, &round, trajectory)?;
            partial = one.rest.clone();
            while partial.ends_with(&round) {
                partial.truncate(partial.len() - round.len());
            }
            laid.push(one);
        }
        Err(Missed::Unsure("the rounds of the property and of the run do not come into step".to_string()))
    }

    /// A round of the property from here on, along as many rounds of the run as it takes for it to end before they do: what is
    /// shown last may go on. Where it always goes on, two rounds are enough.
    fn beginning_with(&self, partial: &[Unit], round: &[Unit], trajectory: &Trajectory) -> Result<Laid, Missed> {
        let along = |rounds: usize| {
            let units = partial.iter().chain(std::iter::repeat_n(round, rounds).flatten()).cloned().collect();
            self.lay(units, false, (&[], trajectory))
        };
        // What is asked for so long may span more of them.
        let first = match (along(2), self.spanned(round)) {
            (Err(Missed::Never(_)), Some(spanned)) => along(spanned + 2)?,
            (found, _) => found?,
        };
        if !first.rest.is_empty() {
            return Ok(first);
        }
        let later =
            (3..=self.wanted.wants.len() + 3).map(along).find(|one| matches!(one, Ok(one) if !one.rest.is_empty()));
        later.unwrap_or(Ok(first))
    }

    /// The rounds of the run that take as long as all that a round of the property asks for a given time, where there
    /// are so few.
    fn spanned(&self, round: &[Unit]) -> Option<usize> {
        let given = self.wanted.wants.iter().filter_map(|want| match &want.length {
            Length::Known(time) => Some(time),
            _ => None,
        });
        let asked = given.into_iter().try_fold(Value::zero(), |sum, time| sum.add(time)).ok()?;
        let lasting = self.durations(round).ok()?;
        let long_enough = |rounds: &i64| {
            let together = lasting.mul(&Value::integer(*rounds));
            together.is_ok_and(|together| self.assumptions.decide(Relation::Lte, &asked, &together) == Some(true))
        };
        (1..=MOST_SPANNED).find(long_enough).and_then(|rounds| usize::try_from(rounds).ok())
    }

    /// Whether a round ends while something is shown that is asked for, and that goes on at the start of the next one.
    fn is_cut(&self, rounds: &[Laid], steady: &[Laid]) -> bool {
        let [.., last, free] = self.wanted.wants.as_slice() else { return false };
        if free.free().is_none() || !matches!(last.length, Length::Unknown(_)) || last.shown.is_empty() {
            return false;
        }
        let segments = |unit: &Unit| unit.round(&Value::zero()).unwrap_or_default();
        let follows = rounds.iter().chain(steady).zip(rounds.iter().chain(steady).skip(1).chain(steady.first()));
        follows.into_iter().any(|(one, next)| {
            let Ok(shown) = with_values(&last.shown, &one.values) else { return false };
            let shows = |segment: &Segment| shows(&segment.observed, &shown, self.assumptions);
            let ends = one.run.last().and_then(|unit| segments(unit).pop());
            let begins = next.run.first().and_then(|unit| segments(unit).into_iter().next());
            // What is shown all the time has no end that could be waited for.
            let other = |unit: &Unit| segments(unit).iter().any(|segment| shows(segment) == Ok(false));
            let both = [ends, begins].into_iter().all(|segment| segment.is_some_and(|one| shows(&one) == Ok(true)));
            both && steady.iter().flat_map(|one| &one.run).any(other)
        })
    }

    /// The rounds of the property wherever they begin.
    fn elsewhere(&self, trajectory: &Trajectory, cycle: usize) -> Option<Outcome> {
        match &trajectory.orbit {
            Some(_) => self.turn_by_turn(trajectory, cycle),
            None => self.round_by_round(trajectory, cycle).ok(),
        }
    }
}

fn form_text(name: &Name, closed: &crate::recurrence::Closed) -> String {
    let forms: Vec<String> = closed.pieces.iter().map(|piece| piece.form.to_string()).collect();
    format!("{name} = {}", forms.join(", then "))
}
