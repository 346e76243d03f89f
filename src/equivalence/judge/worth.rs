//! Greatest chances, judged: with what chance a formula about steps comes true when steps are chosen as well as can be.
//!
//! Around internal steps the values are proposed (`optimum`), and accepted only with what proves them: they meet the
//! equations of the best choice, and some choice that keeps them surely stops.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::super::formula::{Formulas, Node, Place};
use super::super::optimum::{Spot, once, optimum};
use super::{Doubt, Judge, Judged, MOST};
use crate::transition_system::{Behaviour, Label};

/// A greatest chance, and how far it may be off.
pub(in super::super) type Worth = (BigRational, BigRational);

/// A state on the way, and whether the step has been taken.
type Stage = (u32, bool);

impl<B: Behaviour> Judge<'_, B> {
    /// The greatest chance with which the formula comes true in the state, and how far it may be off.
    pub(in super::super) fn worth(&mut self, formulas: &Formulas, place: Place, state: u32) -> Judged<Worth> {
        if let Some(known) = self.worths.get(&(place, state)) {
            return Ok(known.clone());
        }
        self.asked += 1;
        if self.asked > MOST {
            return Err(Doubt::TooMuch);
        }
        let outcomes = self.outcomes(state)?;
        let worth = if outcomes.is_empty() {
            self.worth_at(formulas, place, state)?
        } else {
            let (mut sum, mut off) = (BigRational::zero(), BigRational::zero());
            for (chance, to) in outcomes {
                let (worth, more) = self.worth(formulas, place, to)?;
                sum += chance * worth;
                off = off.max(more);
            }
            (sum, off + self.behaviour.slack())
        };
        self.worths.insert((place, state), worth.clone());
        Ok(worth)
    }

    fn worth_at(&mut self, formulas: &Formulas, place: Place, state: u32) -> Judged<Worth> {
        match formulas.node(place) {
            Node::Some(false, label, next) => {
                let mut best = (BigRational::zero(), BigRational::zero());
                for to in self.after(state, label)? {
                    best = either(best, self.worth(formulas, *next, to)?, BigRational::max);
                }
                Ok(best)
            }
            Node::Some(true, label, next) => self.weakly_worth(formulas, label, *next, state),
            Node::And(parts) => {
                let mut least = (BigRational::one(), BigRational::zero());
                for part in parts {
                    least = either(least, self.worth(formulas, *part, state)?, BigRational::min);
                }
                Ok(least)
            }
            Node::Or(parts) => {
                let mut most = (BigRational::zero(), BigRational::zero());
                for part in parts {
                    most = either(most, self.worth(formulas, *part, state)?, BigRational::max);
                }
                Ok(most)
            }
            _ if self.holds(formulas, place, state)? => Ok((BigRational::one(), BigRational::zero())),
            _ => Ok((BigRational::zero(), BigRational::zero())),
        }
    }

    fn weakly_worth(&mut self, formulas: &Formulas, label: &Label, next: Place, state: u32) -> Judged<Worth> {
        let mut places: HashMap<Stage, usize> = HashMap::new();
        let mut stages: Vec<Stage> = Vec::new();
        let mut place = |stage: Stage, stages: &mut Vec<Stage>| {
            *places.entry(stage).or_insert_with(|| {
                stages.push(stage);
                stages.len() - 1
            })
        };
        place((state, *label == Label::Tau), &mut stages);
        let mut spots = Vec::new();
        let mut off = BigRational::zero();
        while spots.len() < stages.len() {
            let (at, taken) = stages[spots.len()];
            let outcomes = self.outcomes(at)?;
            if !outcomes.is_empty() {
                let outcomes = outcomes.into_iter().map(|(chance, to)| (chance, place((to, taken), &mut stages)));
                spots.push(Spot::Draw(outcomes.collect()));
                continue;
            }
            let mut reward = BigRational::zero();
            if taken {
                let (worth, more) = self.worth(formulas, next, at)?;
                reward = worth;
                off = off.max(more);
            }
            let mut on = Vec::new();
            for to in self.after(at, &Label::Tau)? {
                on.push(place((to, taken), &mut stages));
            }
            if !taken {
                for to in self.after(at, label)? {
                    on.push(place((to, true), &mut stages));
                }
            }
            spots.push(Spot::Choice(reward, on));
        }
        let values = optimum(&spots).filter(|values| proved(&spots, values)).ok_or(Doubt::TooMuch)?;
        // Draws that are met once each are off once each; round a cycle that has no end.
        let draws = spots.iter().filter(|spot| matches!(spot, Spot::Draw(_))).count();
        if !self.behaviour.slack().is_zero() && draws > 0 && round(&spots) {
            return Err(Doubt::Close);
        }
        off += self.behaviour.slack() * BigRational::from_integer(draws.into());
        Ok((values[0].clone(), off))
    }
}

/// The value that is chosen, and how far it may be off.
fn either(one: Worth, two: Worth, choose: fn(BigRational, BigRational) -> BigRational) -> Worth {
    (choose(one.0, two.0), one.1.max(two.1))
}

/// Whether places lead round to each other.
fn round(spots: &[Spot]) -> bool {
    let mut left: Vec<usize> = (0..spots.len()).collect();
    loop {
        let before = left.len();
        let leads = |place: usize, left: &[usize]| match &spots[place] {
            Spot::Draw(outcomes) => outcomes.iter().any(|(_, to)| left.binary_search(to).is_ok()),
            Spot::Choice(_, next) => next.iter().any(|to| left.binary_search(to).is_ok()),
        };
        left = left.iter().copied().filter(|place| leads(*place, &left)).collect();
        if left.len() == before {
            return before > 0;
        }
    }
}

/// Whether these are the greatest expected rewards: they are what the best choice makes of them, and there are choices
/// that keep them and surely stop, or where nothing can be lost.
fn proved(spots: &[Spot], values: &[BigRational]) -> bool {
    if spots.iter().zip(values).any(|(spot, value)| once(spot, values) != *value) {
        return false;
    }
    let mut ends: Vec<bool> = spots
        .iter()
        .zip(values)
        .map(|(spot, value)| value.is_zero() || matches!(spot, Spot::Choice(reward, _) if reward == value))
        .collect();
    loop {
        let joins = |place: usize| match &spots[place] {
            Spot::Draw(outcomes) => outcomes.iter().any(|(chance, to)| !chance.is_zero() && ends[*to]),
            Spot::Choice(_, next) => next.iter().any(|to| ends[*to] && values[*to] == values[place]),
        };
        let more: Vec<usize> = (0..spots.len()).filter(|place| !ends[*place] && joins(*place)).collect();
        if more.is_empty() {
            return ends.into_iter().all(|ends| ends);
        }
        more.into_iter().for_each(|place| ends[place] = true);
    }
}
