//! Chances as rationals, by following every branch of the executable meaning: for systems that draw finitely many values
//! alone, whatever else they do.
//!
//! States that meet at one time are one from then on, with the sum of their chances; nothing is rounded.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::direct::{Subject, counted_from_nothing};
use super::{Enclosed, Question, late};
use crate::definition::Definitions;
use crate::invariant::Claim;
use crate::model::{Action, Meaningless, Model, Move, Patience, State};
use crate::term::Term;

/// States that are followed.
const MOST_STATES: usize = 20_000;
/// Bits of a chance.
const MOST_BITS: u64 = 100_000;

/// States with their chances.
type Weighted = BTreeMap<State, BigRational>;

/// A chance, and whether several communications were due at one moment on the way; of these each was found to commute with
/// the first.
pub struct Found {
    /// The chance.
    pub chance: Enclosed,
    /// Whether there were such.
    pub orders: bool,
}

/// The chance that it happens. Durations that are drawn below 0 count as 0.
///
/// # Errors
/// Where a number is drawn from a density, there are too many branches, or a run has no meaning or depends on which of
/// several communications comes first.
pub fn branches(system: &Term, definitions: &Definitions, event: &Claim, question: &Question) -> Result<Found, String> {
    let (system, definitions) = counted_from_nothing(system, definitions)?;
    let model = Model::new(&definitions);
    let start = model.state(&system).map_err(|error| error.why)?;
    let mut walk = Walk {
        subject: Subject { system: &system, event, question },
        model,
        happened: BigRational::zero(),
        orders: false,
        later: BTreeMap::from([(BigRational::zero(), Weighted::from([(start, BigRational::one())]))]),
    };
    let mut count = 0;
    while let Some((now, mut open)) = walk.later.pop_first() {
        while let Some((state, chance)) = open.pop_first() {
            count += 1;
            if count > MOST_STATES || chance.denom().bits() > MOST_BITS {
                return Err(format!("there are more than {MOST_STATES} states to follow"));
            }
            walk.follow(&now, &state, chance, &mut open)?;
        }
    }
    Ok(Found { chance: Enclosed::known(walk.happened), orders: walk.orders })
}

struct Walk<'a> {
    subject: Subject<'a>,
    model: Model<'a>,
    happened: BigRational,
    orders: bool,
    /// By time.
    later: BTreeMap<BigRational, Weighted>,
}

impl Walk<'_> {
    /// One state: what it leads to at once is added to what is open, the rest to what comes later.
    fn follow(
        &mut self,
        now: &BigRational,
        state: &State,
        chance: BigRational,
        open: &mut Weighted,
    ) -> Result<(), String> {
        let meaning = |error: Meaningless| error.why;
        let moves = state.moves().map_err(meaning)?;
        if moves.iter().any(|one| matches!(one.action, Action::Draw(_, None))) {
            return Err("a number is drawn from a density".to_string());
        }
        let mut drawn = moves.iter().filter_map(|one| match &one.action {
            Action::Draw(_, Some((_, share))) => Some((one, share)),
            _ => None,
        });
        if let Some(first) = drawn.next() {
            for (one, share) in std::iter::once(first).chain(drawn) {
                add(open, self.model.state(&one.next).map_err(meaning)?, &chance * share);
            }
            return Ok(());
        }
        let due: Vec<&Move> = moves.iter().filter(|one| matches!(one.action, Action::Tau(..))).collect();
        if let Some((first, others)) = due.split_first() {
            self.orders |= !others.is_empty();
            add(open, self.subject.communicated(&self.model, first, others)?, chance);
            return Ok(());
        }
        let passes = match state.patience(&moves) {
            Patience::Until(time) => Some(time),
            Patience::Unbounded => None,
            Patience::None => return Ok(()),
        };
        let end = passes.as_ref().map(|time| now + time);
        let last = end.as_ref().is_none_or(|end| late(end, self.subject.question));
        if (self.subject.question.first || last) && self.subject.shown(state)? {
            self.happened += chance;
        } else if let (Some(time), Some(end), false) = (passes, end, last) {
            let next = self.model.pass(state, &time).map_err(meaning)?;
            add(self.later.entry(end).or_default(), next, chance);
        }
        Ok(())
    }
}

fn add(all: &mut Weighted, state: State, chance: BigRational) {
    *all.entry(state).or_insert_with(BigRational::zero) += chance;
}
