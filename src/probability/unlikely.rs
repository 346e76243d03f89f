//! Moves that are hardly ever taken, such as those past a leg whose goal is far from the next one: of a mission of several
//! legs there are as many as pairs of legs.
//!
//! Two tests `f >= 0` and `g >= 0` hold together only where `f + c g >= 0` for any c > 0; where that leaves no state, it is
//! a number that is drawn in the round alone. If it is normal with mean m < 0, its chance is `Φ(m/σ)`, whatever the state.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::axes::{ratio, stateless};
use super::chain::{Chain, Linear, Move, Side, add_product};
use crate::distribution::standard;
use crate::interval::Interval;
use crate::rational::product;
use crate::value::Relation;

/// Moves of a chance below this are left out.
const LEAST: f64 = 1e-25;

/// The chain without such moves, and what their chances in a round come to at most, from any state.
pub(super) fn without(chain: &Chain) -> (Chain, Interval) {
    let mut lost = Interval::exactly(0.0);
    let mut likely = |moves: &[Move]| {
        let mut kept = Vec::new();
        for one in moves {
            match chance(one) {
                Some(chance) => lost = lost.plus(chance),
                None => kept.push(one.clone()),
            }
        }
        kept
    };
    let initial = likely(&chain.initial);
    let phases = chain.phases.iter().map(|moves| likely(moves)).collect();
    (Chain { initial, phases }, lost)
}

/// The chance of a move, from any state, where it is seen to be next to nothing.
fn chance(one: &Move) -> Option<Interval> {
    let forms: Vec<Linear> = one.tests.iter().filter_map(positive).collect();
    for (place, first) in forms.iter().enumerate() {
        if let Some(found) = small(first, one) {
            return Some(found);
        }
        for second in &forms[..place] {
            let Some(share) = ratio(&second.state, &first.state).filter(Signed::is_negative) else { continue };
            if let Some(found) = small(&first.plus(&second.scaled(&-share)), one) {
                return Some(found);
            }
        }
    }
    None
}

/// The form that is at least 0 where a test holds.
fn positive(side: &Side) -> Option<Linear> {
    match side.relation {
        Relation::Gtr | Relation::Gte => Some(side.form.clone()),
        Relation::Lss | Relation::Lte => Some(side.form.scaled(&-BigRational::from_integer(1.into()))),
        Relation::Eq | Relation::Neq => None,
    }
}

/// The chance that a form without a state is not negative, where that is next to nothing.
fn small(form: &Linear, one: &Move) -> Option<Interval> {
    if !stateless(form) {
        return None;
    }
    let (mut mean, mut variance) = (form.constant.clone(), BigRational::zero());
    for (factor, draw) in form.draws.iter().zip(&one.draws).filter(|(factor, _)| !factor.is_zero()) {
        let parts = draw.normals()?;
        let [(_, middle, own)] = parts.as_slice() else { return None };
        add_product(&mut mean, factor, middle);
        add_product(&mut variance, &product(factor, factor), own);
    }
    if !mean.is_negative() {
        return None;
    }
    let chance = match variance.is_zero() {
        true => Interval::exactly(0.0),
        // That a number of mean 0 is at most this one.
        false => standard(&mean, &BigRational::zero(), &variance).normal(),
    };
    (chance.high <= LEAST).then_some(chance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Distribution;

    /// A test of the state with noise: `state + draw - bound`.
    fn side(draw: usize, bound: i64, relation: Relation) -> Side {
        let number = |number: i64| BigRational::from_integer(number.into());
        let draws = (0..2).map(|place| number(i64::from(place == draw))).collect();
        Side { form: Linear { state: vec![number(1)], draws, constant: number(-bound) }, relation }
    }

    fn one(tests: Vec<Side>) -> Move {
        let normal = Distribution::Normal { mean: BigRational::zero(), variance: BigRational::new(1.into(), 2.into()) };
        Move { draws: vec![normal.clone(), normal], tests, stretches: Vec::new(), image: Vec::new(), next: None }
    }

    #[test]
    fn what_no_state_makes_likely_is_left_out() {
        use Relation::{Gte, Lss};
        // Two looks that differ by 12, where their difference has variance 1: Φ(-12) = 1.776e-33.
        let far = one(vec![side(0, 10, Gte), side(1, -2, Lss)]);
        let found = chance(&far).expect("unlikely");
        assert!(found.low <= 1.776_482_112_077_679e-33 && 1.776_482_112_077_678e-33 <= found.high, "{found:?}");
        // Two that differ by 8: Φ(-8) = 6e-16 is counted.
        assert_eq!(chance(&one(vec![side(0, 10, Gte), side(1, 2, Lss)])), None);
        // One look cannot be on both sides, and any two may be on the same.
        assert_eq!(chance(&one(vec![side(0, 1, Gte), side(0, 0, Lss)])), Some(Interval::exactly(0.0)));
        assert_eq!(chance(&one(vec![side(0, 10, Gte), side(1, -2, Gte)])), None);
        let chain = Chain { initial: vec![one(Vec::new()), far.clone()], phases: vec![vec![far, one(Vec::new())]] };
        let (left, lost) = without(&chain);
        assert_eq!((left.initial.len(), left.phases[0].len()), (1, 1));
        assert!(lost.low >= 3.5e-33 && lost.high < 3.6e-33, "{lost:?}");
    }
}
