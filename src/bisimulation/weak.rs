//! The weak game: internal steps do not count, outcomes are compared exactly, and what is shown counts while time passes.
//!
//! One side makes one step; the other answers with internal steps, the step, and internal steps. An internal step may
//! be answered by none. A draw that is due, or a value that was drawn and is not known, leaves
//! a pair undecided: nothing is concluded from it.

use std::collections::BTreeSet;
use std::rc::Rc;

use num_rational::BigRational;

use super::game::{Challenge, Game, Key, Pair, Seen};
use super::{Difference, Side};
use crate::model::explore::Label;
use crate::model::{Action, Meaningless, Model, Observation, Patience, State};

impl Game<'_> {
    /// Looks into a pair of states.
    pub(super) fn look_weakly(&mut self, left: usize, right: usize) -> Result<Pair, Meaningless> {
        let (one, two) = (self.seen(left)?, self.seen(right)?);
        if left == right {
            self.sweep(left)?;
            return Ok(Pair::Choice(Vec::new()));
        }
        if unclear(&one) || unclear(&two) {
            self.undecided = true;
            return Ok(Pair::Choice(Vec::new()));
        }
        let outcomes = (one.state.outcome(), two.state.outcome());
        if outcomes.0 != outcomes.1 {
            return Ok(Pair::Apart(Box::new(Difference::Outcome(outcomes.0, outcomes.1))));
        }
        let mut challenges = Vec::new();
        for (side, mine, place, other) in [(Side::Left, &one, left, right), (Side::Right, &two, right, left)] {
            for (key, targets) in &mine.moves {
                let Some(answers) = self.weakly(other, key)? else { continue };
                for (label, target) in targets {
                    if answers.is_empty() {
                        return Ok(Pair::Apart(Box::new(Difference::Move(side, label.clone()))));
                    }
                    let answers = answers.iter().map(|answer| self.turned(side, *target, *answer)).collect();
                    challenges.push(Challenge { side, label: label.clone(), answers });
                }
            }
            match self.waits(side, mine, place, other)? {
                Ok(more) => challenges.extend(more),
                Err(difference) => return Ok(Pair::Apart(Box::new(difference))),
            }
        }
        Ok(Pair::Choice(challenges))
    }

    fn turned(&mut self, side: Side, mine: usize, answer: usize) -> usize {
        if side == Side::Right { self.pair(answer, mine) } else { self.pair(mine, answer) }
    }

    /// The challenge to let time pass, if this side does; or how the other side fails at once.
    fn waits(
        &mut self,
        side: Side,
        mine: &Seen,
        place: usize,
        other: usize,
    ) -> Result<Result<Option<Challenge>, Difference>, Meaningless> {
        if mine.patience == Patience::None {
            return Ok(Ok(None));
        }
        let mut fitting = Vec::new();
        let mut shown_else = None;
        for answer in self.closure(other)?.iter() {
            let seen = self.seen(*answer)?;
            if unclear(&seen) {
                self.undecided = true;
                return Ok(Ok(None));
            }
            if seen.patience == Patience::None {
                continue;
            }
            if self.fits(side, &mine.shown, &seen.shown) {
                fitting.push(seen);
            } else {
                shown_else = Some(seen);
            }
        }
        if fitting.is_empty() {
            return Ok(Err(match shown_else {
                Some(seen) if side == Side::Left => {
                    Difference::Observations(Box::new(mine.state.clone()), Box::new(seen.state.clone()))
                }
                Some(seen) => Difference::Observations(Box::new(seen.state.clone()), Box::new(mine.state.clone())),
                None => Difference::Time(side),
            }));
        }
        let time = self.common_slice(mine, &fitting);
        let target = if mine.patience == Patience::Unbounded { place } else { self.passed(mine, &time)? };
        let mut answers = BTreeSet::new();
        for seen in fitting {
            let after = self.passed(&seen, &time)?;
            answers.extend(self.closure(after)?.iter().copied());
        }
        let answers = answers.into_iter().map(|answer| self.turned(side, target, answer)).collect();
        Ok(Ok(Some(Challenge { side, label: Label::Wait(time), answers })))
    }

    fn fits(&self, side: Side, mine: &BTreeSet<Observation>, other: &BTreeSet<Observation>) -> bool {
        match (self.refines, side) {
            (false, _) => mine == other,
            (true, Side::Right) => mine.is_subset(other),
            (true, _) => other.is_subset(mine),
        }
    }

    /// A time within which nothing changes by itself on any of these.
    fn common_slice(&self, mine: &Seen, others: &[Rc<Seen>]) -> BigRational {
        let all = || std::iter::once(mine).chain(others.iter().map(Rc::as_ref));
        let events = all().filter_map(|seen| match &seen.patience {
            Patience::Until(time) => Some(time.clone()),
            _ => None,
        });
        match events.min() {
            Some(event) if all().any(|seen| seen.offers) => event.min(self.grain.clone()),
            Some(event) => event,
            None => self.grain.clone(),
        }
    }

    /// Where internal steps lead, from none on.
    fn closure(&mut self, place: usize) -> Result<Rc<Vec<usize>>, Meaningless> {
        if let Some(known) = self.closures.get(&place) {
            return Ok(known.clone());
        }
        let mut all = BTreeSet::from([place]);
        let mut open = vec![place];
        while let Some(next) = open.pop() {
            if all.len() > self.reach.pairs {
                self.undecided = true;
                break;
            }
            let seen = self.seen(next)?;
            let after = seen.moves.get(&Key::Tau).into_iter().flatten().map(|(_, to)| *to);
            open.extend(after.filter(|to| all.insert(*to)).collect::<Vec<_>>());
        }
        let all = Rc::new(all.into_iter().collect::<Vec<_>>());
        self.closures.insert(place, all.clone());
        Ok(all)
    }

    /// Where a step leads that is taken after and before any internal steps; none if that is not known.
    fn weakly(&mut self, place: usize, key: &Key) -> Result<Option<Vec<usize>>, Meaningless> {
        let before = self.closure(place)?;
        if *key == Key::Tau {
            return Ok(Some(before.to_vec()));
        }
        let mut all = BTreeSet::new();
        for state in before.iter() {
            let seen = self.seen(*state)?;
            if unclear(&seen) {
                self.undecided = true;
                return Ok(None);
            }
            for (_, to) in seen.moves.get(key).into_iter().flatten() {
                all.extend(self.closure(*to)?.iter().copied());
            }
        }
        Ok(Some(all.into_iter().collect()))
    }
}

/// Whether a draw is due, or what it does depends on one: then nothing is concluded.
fn unclear(seen: &Seen) -> bool {
    !seen.chances.is_empty() || seen.blurred
}

/// The most states that internal steps may lead to when a run is checked.
const MOST: usize = 10_000;

/// The states that internal steps lead to, from none on.
pub(super) fn settled(model: &Model, start: State) -> Result<Vec<State>, Meaningless> {
    let mut all = vec![start];
    let mut next = 0;
    while next < all.len() {
        for step in all[next].moves()? {
            if matches!(step.action, Action::Tau(..)) {
                let after = model.state(&step.next)?;
                if !all.contains(&after) {
                    all.push(after);
                }
            }
        }
        if all.len() > MOST {
            return Err(Meaningless { why: "its internal steps lead to too many states".into() });
        }
        next += 1;
    }
    Ok(all)
}
