//! Moves that are hardly ever taken, such as those past a leg whose goal is far from the next one: of a mission of several
//! legs there are as many as pairs of legs. And tests that hardly ever fail where the others hold: at the end of a leg the
//! next goal is far. They would cut the states finely for nothing.
//!
//! Two tests `f >= 0` and `g >= 0` hold together only where `f + c g >= 0` for any c > 0; where that leaves no state, it is
//! a number that is drawn in the round alone. If it is normal with mean m < 0, its chance is `Φ(m/σ)`, whatever the state.
//! That a test fails is such a test too.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::axes::{ratio, stateless};
use super::chain::{Chain, Linear, Move, Side, add_product};
use crate::interval::Interval;
use crate::rational::{product, quotient};
use crate::value::Relation;

/// Moves and tests that do not hold are left out where their chance is at most this.
const LEAST: f64 = 1e-25;
/// Standard deviations below 0 from which it is worth computing that chance.
const FAR: f64 = 10.0;

/// The chain without such moves and tests, and what their chances in a round come to at most, from any state.
pub(super) fn without(chain: &Chain) -> (Chain, Interval) {
    let mut lost = Interval::exactly(0.0);
    let mut likely = |moves: &[Move]| {
        let mut kept = Vec::new();
        for one in moves {
            match Forms::of(one) {
                Err(chance) => lost = lost.plus(chance),
                Ok(mut forms) => {
                    let (tests, chance) = forms.needed();
                    lost = lost.plus(chance);
                    kept.push(Move { tests, ..one.clone() });
                }
            }
        }
        kept
    };
    let initial = likely(&chain.initial);
    let phases = chain.phases.iter().map(|moves| likely(moves)).collect();
    (Chain { initial, phases, variables: Vec::new() }, lost)
}

/// That a test holds, or that it fails: where this sign times its form is at least 0.
struct Form<'a> {
    side: &'a Side,
    positive: bool,
    /// Near the factors of the state and of the draws, and what is added, with the sign.
    state: Vec<f64>,
    draws: Vec<f64>,
    constant: f64,
}

impl Form<'_> {
    /// None for an equality.
    fn of(side: &Side) -> Option<Form<'_>> {
        let positive = match side.relation {
            Relation::Gtr | Relation::Gte => true,
            Relation::Lss | Relation::Lte => false,
            Relation::Eq | Relation::Neq => return None,
        };
        Some(Form::signed(side, positive))
    }

    fn signed(side: &Side, positive: bool) -> Form<'_> {
        let number = |number: &BigRational| if positive { near(number) } else { -near(number) };
        let all = |numbers: &[BigRational]| numbers.iter().map(number).collect();
        let Linear { state, draws, constant } = &side.form;
        Form { side, positive, state: all(state), draws: all(draws), constant: number(constant) }
    }

    fn opposite(&self) -> Form<'_> {
        Form::signed(self.side, !self.positive)
    }
}

fn near(number: &BigRational) -> f64 {
    if number.is_zero() { 0.0 } else { number.to_f64().unwrap_or(f64::NAN) }
}

/// The tests of a move.
struct Forms<'a> {
    one: &'a Move,
    /// Means and variances of the draws, near enough; where they are not normal, the variance is infinite.
    draws: Vec<(f64, f64)>,
    /// By test; none for an equality.
    forms: Vec<Option<Form<'a>>>,
}

impl Forms<'_> {
    /// The tests of a move; if it is next to impossible, its chance from any state.
    fn of(one: &Move) -> Result<Forms<'_>, Interval> {
        let draw = |draw: &crate::distribution::Distribution| match draw.normals().as_deref() {
            Some([(_, mean, variance)]) => (near(mean), near(variance)),
            _ => (0.0, f64::INFINITY),
        };
        let draws = one.draws.iter().map(draw).collect();
        let mut all = Forms { one, draws, forms: Vec::with_capacity(one.tests.len()) };
        for side in &one.tests {
            let form = Form::of(side);
            if let Some(chance) = form.as_ref().and_then(|form| all.chance(form, None)) {
                return Err(chance);
            }
            all.forms.push(form);
        }
        Ok(all)
    }

    /// The tests without those that hardly ever fail where the others hold, and the chance that one of them does.
    fn needed(&mut self) -> (Vec<Side>, Interval) {
        let (mut tests, mut lost) = (Vec::new(), Interval::exactly(0.0));
        for (place, side) in self.one.tests.iter().enumerate() {
            let fails = self.forms[place].as_ref().map(Form::opposite);
            match fails.and_then(|fails| self.chance(&fails, Some(place))) {
                Some(chance) => {
                    lost = lost.plus(chance);
                    self.forms[place] = None;
                }
                None => tests.push(side.clone()),
            }
        }
        (tests, lost)
    }

    /// The chance of a test together with one of the others but for that at a place, where it is seen to be next to nothing.
    fn chance(&self, form: &Form, but: Option<usize>) -> Option<Interval> {
        if self.seems_small(form, None)
            && let Some(chance) = small(form, None, self.one)
        {
            return Some(chance);
        }
        let others = self.forms.iter().enumerate().filter(|(place, _)| Some(*place) != but);
        let mut others = others.filter_map(|(_, other)| other.as_ref());
        others.find_map(
            |other| if self.seems_small(form, Some(other)) { small(form, Some(other), self.one) } else { None },
        )
    }

    /// Whether machine numbers say so: of one form without a state, or of two of which the states cancel.
    fn seems_small(&self, form: &Form, other: Option<&Form>) -> bool {
        let share = match other {
            None if stateless(&form.side.form) => 0.0,
            None => return false,
            Some(other) => match other.state.iter().zip(&form.state).find(|(factor, _)| **factor != 0.0) {
                Some((factor, own)) if own / factor < 0.0 => -own / factor,
                _ => return false,
            },
        };
        let mut mean = form.constant + other.map_or(0.0, |other| share * other.constant);
        let mut variance = 0.0;
        for (place, (middle, own)) in self.draws.iter().enumerate() {
            let factor = |form: &Form| form.draws.get(place).copied().unwrap_or(0.0);
            let (own_factor, more) = (factor(form), other.map_or(0.0, |other| share * factor(other)));
            let factor = own_factor + more;
            if factor.abs() > 1e-12 * (own_factor.abs() + more.abs()) {
                mean += factor * middle;
                variance += factor * factor * own;
            }
        }
        mean < 0.0 && mean * mean > FAR * FAR * variance
    }
}

/// A bound on the chance that a form without a state is not negative, or one that another holds with it, where that is
/// next to nothing: by Φ(-21/2) < 1e-25.
fn small(form: &Form, other: Option<&Form>, one: &Move) -> Option<Interval> {
    let share = match other {
        None if stateless(&form.side.form) => BigRational::zero(),
        None => return None,
        Some(other) => {
            let share = ratio(&other.side.form.state, &form.side.form.state)?;
            // What has this share is the other as it is written, not as it holds.
            if share.is_negative() != (form.positive == other.positive) {
                return None;
            }
            -share
        }
    };
    let second = other.map(|other| &other.side.form);
    let with = |own: Option<&BigRational>, more: Option<&BigRational>| {
        let mut sum = own.cloned().unwrap_or_else(BigRational::zero);
        if let Some(more) = more {
            add_product(&mut sum, &share, more);
        }
        sum
    };
    let mut mean = with(Some(&form.side.form.constant), second.map(|second| &second.constant));
    let mut variance = BigRational::zero();
    for (place, draw) in one.draws.iter().enumerate() {
        let factor = with(form.side.form.draws.get(place), second.and_then(|second| second.draws.get(place)));
        if factor.is_zero() {
            continue;
        }
        let parts = draw.normals()?;
        let [(_, middle, own)] = parts.as_slice() else { return None };
        add_product(&mut mean, &factor, middle);
        add_product(&mut variance, &product(&factor, &factor), own);
    }
    let far = BigRational::new(21.into(), 2.into());
    let apart = product(&mean, &mean) >= product(&product(&far, &far), &variance);
    let negative = if form.positive { mean.is_negative() } else { mean.is_positive() };
    let bound = match variance.is_zero() {
        true => 0.0,
        // Φ(-z) < e^(-z²/2), which may be below all machine numbers.
        false => {
            let square = near(&quotient(&product(&mean, &mean), &variance));
            let tail = (-0.499_999 * square).exp();
            if tail < LEAST { tail.max(f64::MIN_POSITIVE) } else { LEAST }
        }
    };
    (negative && apart).then_some(Interval::between(0.0, bound))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::Distribution;

    /// A test of the state with noise: `state + draw - bound`.
    fn side(draw: usize, bound: i64, relation: Relation) -> Side {
        let number = |number: i64| BigRational::from_integer(number.into());
        let draws = (0..2).map(|place| number(i64::from(place == draw))).collect();
        Side::flat(Linear { state: vec![number(1)], draws, constant: number(-bound) }, relation)
    }

    fn one(tests: Vec<Side>) -> Move {
        let normal = Distribution::Normal { mean: BigRational::zero(), variance: BigRational::new(1.into(), 2.into()) };
        Move { draws: vec![normal.clone(), normal], tests, stretches: Vec::new(), image: Vec::new(), next: None }
    }

    #[test]
    fn what_no_state_makes_likely_is_left_out() {
        use Relation::{Gte, Lss};
        let next_to_nothing = Interval::exactly(-10.5).normal();
        assert!(next_to_nothing.high < LEAST, "{next_to_nothing:?}");
        // Two looks that differ by 12, where their difference has variance 1: Φ(-12) = 1.776e-33.
        let far = one(vec![side(0, 10, Gte), side(1, -2, Lss)]);
        let chance = |one: &Move| Forms::of(one).err();
        let bound = |chance: Interval| chance.low == 0.0 && chance.high > 1.777e-33 && chance.high < 1e-31;
        assert!(chance(&far).is_some_and(bound), "{:?}", chance(&far));
        // Two that differ by 8: Φ(-8) = 6e-16 is counted.
        assert_eq!(chance(&one(vec![side(0, 10, Gte), side(1, 2, Lss)])), None);
        // One look cannot be on both sides, and any two may be on the same.
        assert_eq!(chance(&one(vec![side(0, 1, Gte), side(0, 0, Lss)])), Some(Interval::exactly(0.0)));
        assert_eq!(chance(&one(vec![side(0, 10, Gte), side(1, -2, Gte)])), None);
        // What hardly ever fails where the others hold is not asked: by itself it is, as it depends on the state.
        let tests = vec![side(0, 10, Gte), side(1, -2, Gte)];
        let long = one(tests.clone());
        let (kept, lost) = Forms::of(&long).map(|mut forms| forms.needed()).expect("likely");
        assert_eq!(kept, tests[..1]);
        assert!(bound(lost), "{lost:?}");
        // Of two that are the same, one; what fails with 6e-16 is asked.
        let twice = one(vec![side(0, 1, Gte), side(0, 0, Gte), side(1, -7, Gte)]);
        assert_eq!(Forms::of(&twice).map(|mut forms| forms.needed().0), Ok(vec![side(0, 1, Gte), side(1, -7, Gte)]));
        let chain = Chain {
            initial: vec![one(Vec::new()), far.clone()],
            phases: vec![vec![far, one(Vec::new())]],
            variables: Vec::new(),
        };
        let (left, lost) = without(&chain);
        assert_eq!((left.initial.len(), left.phases[0].len()), (1, 1));
        assert!(lost.low <= 3.6e-33 && lost.high >= 3.5e-33 && lost.high < 2e-31, "{lost:?}");
    }
}
