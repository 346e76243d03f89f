//! One way through a round over two coordinates: what decides it, and where it leads.

use num_rational::BigRational;
use num_traits::Zero;

use super::Question;
use super::axes::{Direction, shown, stateless};
use super::chain::{Chain, Linear, Move, Region, Side};
use super::draft::moved;
use super::form::{Form, inner};
use super::pair::{Basis, COMBINATIONS, DECIDERS, Final, LOOKS, Look, PLACES, Step};
use super::region::{Patch, common, half, meet, merged, outside, whole};
use crate::value::Relation;

/// How both coordinates move, with their noise.
#[derive(Default)]
struct Motion {
    /// Whether there is a next state.
    lands: bool,
    /// Whether it ends and is summed over the first number that decides.
    summed: bool,
    first: [BigRational; 3],
    second: [BigRational; 4],
    noise: [Vec<BigRational>; 2],
}

/// A number `ratio * (v' + a u' + b u + c v) + constant` that decides.
struct Tilt {
    number: usize,
    factors: [BigRational; 3],
    ratio: BigRational,
    constant: BigRational,
}

/// A way in the making: a move with the means and variances of what it draws.
pub(super) struct Sketch<'a> {
    pub chain: &'a Chain,
    pub question: &'a Question,
    pub settled: &'a [Option<bool>],
    pub finals: &'a [Option<Final>],
    pub bases: &'a [Basis],
    pub one: &'a Move,
    /// None at the start, where there is no state.
    pub phase: Option<usize>,
    pub drawn: Vec<(BigRational, BigRational)>,
}

pub(super) const SHARED: &str = "the guards of a round share their noise with both dimensions of the state";

const EQUAL: &str = "a round asks whether the state is equal to a number";

impl Sketch<'_> {
    /// None where it is never taken.
    pub(super) fn step(&self, weight: BigRational) -> Result<Option<Step>, String> {
        let (next, [later, at_once]) = self.regions()?;
        let mut motion = next.map(|next| self.motion(next)).transpose()?.unwrap_or_default();
        let mut bases = Vec::new();
        let Some(taken) = self.patch(&self.one.tests, &mut bases, &motion)? else { return Ok(None) };
        let mut asked = [Vec::new(), Vec::new()];
        for (region, asked) in [later, at_once].iter().zip(&mut asked) {
            for sides in region {
                asked.extend(self.patch(sides, &mut bases, &motion)?.and_then(|patch| common(&taken, &patch)));
            }
        }
        let mut found = self.looks(&bases, &motion);
        if let (Err(_), None, Some(form)) = (&found, next, bases.first().filter(|form| form.factors[1].is_zero())) {
            // What ends a run shares its noise: it is summed over the first number, as if that were the next state.
            motion.first = [form.factors[0].clone(), BigRational::zero(), self.inner(&form.draws, &form.draws)];
            motion.noise[0] = form.draws.clone();
            motion.summed = true;
            found = self.looks(&bases, &motion);
        }
        let (looks, tilt) = found?;
        let mut taken = vec![taken];
        if let Some(tilt) = &tilt {
            // What leans on the second coordinate has a place of its own.
            for patch in taken.iter_mut().chain(asked.iter_mut().flatten()) {
                let set = std::mem::replace(&mut patch[LOOKS + tilt.number], whole());
                patch[1] = meet(&patch[1], &moved(&set, &tilt.ratio, &tilt.constant));
            }
        }
        let [success, last] = asked;
        let rest = || merged(last.iter().fold(taken.clone(), outside));
        let (success, last, onward) = match (next, self.question.first) {
            (None, _) => (success, last, Vec::new()),
            (Some(_), true) => (last.clone(), last.clone(), rest()),
            (Some(_), false) => (Vec::new(), last, taken),
        };
        let tilt = match (tilt, next) {
            (Some(tilt), _) => tilt.factors,
            (None, None) => [self.slope(), BigRational::zero(), BigRational::zero()],
            (None, Some(_)) => Default::default(),
        };
        let summed = motion.summed;
        if summed && success.iter().chain(&last).any(|patch| patch[1] != whole()) {
            return Err(SHARED.to_string());
        }
        Ok(Some(Step {
            weight,
            next,
            summed,
            first: motion.first,
            second: motion.second,
            looks,
            tilt,
            success,
            last,
            onward,
        }))
    }

    /// The phase in which it goes on, what is asked for in the end, and what is asked for at once.
    fn regions(&self) -> Result<(Option<usize>, Final), String> {
        let image = |region: &Region| {
            let mut region = region.clone();
            region.iter_mut().flatten().for_each(|side| side.form = side.form.after(&self.one.image));
            region
        };
        let same = |region: Region| [region.clone(), region];
        Ok(match self.one.next {
            Some(next) => match (self.settled.get(next).copied().flatten(), self.finals.get(next)) {
                (Some(true), _) => (None, same(vec![Vec::new()])),
                (Some(false), _) => (None, same(Region::new())),
                (None, Some(Some([later, at_once]))) => (None, [image(later), image(at_once)]),
                (None, _) => (Some(next), same(image(&shown(self.chain, next)?))),
            },
            None => {
                let rest = self.one.stretches.iter().find(|stretch| stretch.duration.is_none());
                (None, same(rest.map(|stretch| stretch.shown.clone()).unwrap_or_default()))
            }
        })
    }

    /// How both coordinates move.
    fn motion(&self, next: usize) -> Result<Motion, String> {
        let along = |direction: &Option<Direction>| {
            let image = |state: &Direction| Linear { state: state.clone(), ..Linear::default() }.after(&self.one.image);
            direction.as_ref().map(|direction| self.form(&image(direction))).transpose()
        };
        let basis = &self.bases[next];
        let mut motion = Motion { lands: true, ..Motion::default() };
        if let Some(form) = along(&basis.first)? {
            if !form.factors[1].is_zero() {
                return Err("what is looked at leans on two dimensions of the state".to_string());
            }
            let [slope, _] = form.factors;
            motion.first = [slope, form.offset, self.inner(&form.draws, &form.draws)];
            motion.noise[0] = form.draws;
        }
        if let Some(form) = along(&basis.second)? {
            let variance = self.inner(&form.draws, &form.draws);
            let [lean, keep] = form.factors;
            motion.second = [keep, lean, form.offset, variance];
            motion.noise[1] = form.draws;
        }
        let still = |own: &Option<Direction>, variance: &BigRational| own.is_some() && variance.is_zero();
        if self.phase.is_some() && still(&basis.first, &motion.first[2]) {
            return Err("a round adds no noise to a combination of the state".to_string());
        }
        if !self.inner(&motion.noise[0], &motion.noise[1]).is_zero() {
            return Err("two dimensions of the state share their noise in different ways".to_string());
        }
        Ok(motion)
    }

    /// The numbers that decide, given the state and the next first coordinate; and which of them leans on the next second
    /// one.
    fn looks(&self, bases: &[Form], motion: &Motion) -> Result<(Vec<Look>, Option<Tilt>), String> {
        let ([slope, shift, variance], [keep, lean, drift, spread]) = (&motion.first, &motion.second);
        let share = |form: &Form, axis: usize| {
            let variance = if axis == 0 { variance } else { spread };
            let covariance = self.inner(&form.draws, &motion.noise[axis]);
            if variance.is_zero() { BigRational::zero() } else { covariance / variance }
        };
        let (mut looks, mut tilt): (Vec<Look>, Option<Tilt>) = (Vec::new(), None);
        for (number, form) in bases.iter().enumerate() {
            let (follows, leans) = (share(form, 0), share(form, 1));
            let given = |other: &Form| {
                let known = &follows * share(other, 0) * variance + &leans * share(other, 1) * spread;
                self.inner(&form.draws, &other.draws) - known
            };
            let rest = given(form);
            let factor = &form.factors[0] - &follows * slope - &leans * lean;
            let second = &form.factors[1] - &leans * keep;
            let constant = -(&follows * shift) - &leans * drift;
            let apart = bases[..number].iter().all(|other| given(other).is_zero());
            let leaning = !leans.is_zero();
            if !apart || (leaning && (!rest.is_zero() || tilt.is_some())) {
                return Err(SHARED.to_string());
            }
            if leaning {
                let factors = [follows, factor, second].map(|factor| factor / &leans);
                tilt = Some(Tilt { number, factors, ratio: leans, constant });
                looks.push(Look::nothing());
            } else {
                looks.push(Look { factor, second, follows, offset: constant, rest });
            }
        }
        Ok((looks, tilt))
    }

    /// Where the state and the random numbers must lie for all of these to hold; none if one of them never does.
    fn patch(&self, sides: &[Side], bases: &mut Vec<Form>, motion: &Motion) -> Result<Option<Patch>, String> {
        let mut patch: Patch = vec![whole(); PLACES];
        for side in sides {
            let form = self.form(&side.form)?;
            let noisy = form.draws.iter().any(|factor| !factor.is_zero());
            let still = !noisy && form.factors[0].is_zero() && form.factors[1].is_zero();
            let (place, set) = match side.relation {
                relation if still => match relation.holds(form.offset.cmp(&BigRational::zero())) {
                    true => continue,
                    false => return Ok(None),
                },
                // A state may be known where the system begins.
                Relation::Eq | Relation::Neq if !noisy => return Err(EQUAL.to_string()),
                Relation::Eq => return Ok(None),
                Relation::Neq => continue,
                _ if !form.factors[1].is_zero() && !noisy && motion.lands => return Err(SHARED.to_string()),
                relation if noisy => {
                    let (number, ratio, constant) = form.said(bases, DECIDERS)?;
                    (LOOKS + number, half(relation, &ratio, &constant))
                }
                relation if form.factors[1].is_zero() => (0, half(relation, &form.factors[0], &form.offset)),
                _ if form.factors[0] != &form.factors[1] * self.slope() => return Err(COMBINATIONS.to_string()),
                relation => (1, half(relation, &form.factors[1], &form.offset)),
            };
            patch[place] = meet(&patch[place], &set);
            if patch[place].is_empty() {
                return Ok(None);
            }
        }
        Ok(Some(patch))
    }

    /// How much of the first coordinate is looked at with the second one where a run ends without noise.
    fn slope(&self) -> BigRational {
        self.phase.and_then(|phase| self.bases[phase].slope.clone()).unwrap_or_default()
    }

    fn form(&self, linear: &Linear) -> Result<Form, String> {
        let form = Form::of(linear, &self.drawn);
        let (first, second) = match stateless(linear) {
            true => Default::default(),
            false => {
                let basis = self.phase.and_then(|phase| self.bases.get(phase));
                let apart = basis.and_then(|basis| basis.apart(&linear.state));
                apart.ok_or("a combination of the state is not followed")?
            }
        };
        Ok(Form { factors: [first, second], ..form })
    }

    fn inner(&self, left: &[BigRational], right: &[BigRational]) -> BigRational {
        inner(left, right, &self.drawn)
    }
}
