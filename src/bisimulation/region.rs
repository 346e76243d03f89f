//! Dense time, exactly: all that two states will do depends on the whole units left of each running delay, on which of
//! them have no fraction of a unit left, and on the order of the fractions (Alur and Dill 1994), of both states together.
//!
//! Where something may happen at any moment, time passes to the next moment at which a fraction is used up, and to one
//! moment before it; then the fractions are spread evenly in their order, so that there are finitely many pairs. The
//! unit must divide every delay.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use super::game::{Game, Seen};
use crate::model::{Meaningless, State};

fn number(whole: usize) -> BigRational {
    BigRational::from_integer(whole.into())
}

/// What is left of this time when all whole units are taken off.
fn fraction(time: &BigRational, unit: &BigRational) -> BigRational {
    time - (time / unit).floor() * unit
}

fn fractions(states: [&State; 2], unit: &BigRational) -> BTreeSet<BigRational> {
    states.iter().flat_map(|state| state.residues()).map(|time| fraction(&time, unit)).collect()
}

/// The time to the next region: to where the least fraction is used up, or half way there where one is used up now.
pub(super) fn next(states: [&State; 2], unit: &BigRational) -> BigRational {
    let all = fractions(states, unit);
    let least = all.iter().find(|part| !part.is_zero()).unwrap_or(unit);
    if all.contains(&BigRational::zero()) || all.is_empty() { least / number(2) } else { least.clone() }
}

/// Both states with their fractions spread evenly.
fn spread(states: [State; 2], unit: &BigRational) -> Result<[State; 2], Meaningless> {
    let mut all = fractions([&states[0], &states[1]], unit);
    all.remove(&BigRational::zero());
    let order: Vec<&BigRational> = all.iter().collect();
    let change = |time: &BigRational| {
        let part = fraction(time, unit);
        let place = order.iter().position(|known| **known == part).map_or(0, |place| place + 1);
        time - &part + unit * number(place) / number(order.len() + 1)
    };
    let [one, two] = states;
    Ok([one.with_residues(&change)?, two.with_residues(&change)?])
}

impl Game<'_> {
    /// The places of both states after this time.
    pub(super) fn both_passed(
        &mut self,
        one: &Seen,
        two: &Seen,
        time: &BigRational,
    ) -> Result<(usize, usize), Meaningless> {
        let unit = match &self.unit {
            Some(unit) if !one.blurred && !two.blurred => unit.clone(),
            _ => return Ok((self.passed(one, time)?, self.passed(two, time)?)),
        };
        let after = [self.model.pass(&one.state, time)?, self.model.pass(&two.state, time)?];
        let [one, two] = spread(after, &unit)?;
        Ok((self.place(one)?, self.place(two)?))
    }
}
