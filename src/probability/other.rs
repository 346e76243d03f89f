//! Random numbers that are neither normal nor certain, in linear maps: followed one by one, and added up where the sum is
//! of the same kind.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::chain::{Linear, Region, Side};
use super::sums::Sum;
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::value::Relation;

/// Numbers that are followed at a time.
const MOST: usize = 64;

/// A number, with its factors in the state, or its place among the draws of this round.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Other {
    factors: Vec<BigRational>,
    draw: Option<usize>,
    distribution: Distribution,
}

/// What a form has of these numbers.
pub(super) enum Share {
    /// Nothing.
    Nothing,
    /// One of them, times this.
    One(usize, BigRational),
    /// More than one.
    Several,
}

impl Other {
    /// Drawn at this place of the round.
    pub(super) fn drawn(place: usize, distribution: Distribution) -> Other {
        Other { factors: Vec::new(), draw: Some(place), distribution }
    }

    fn factor(&self, form: &Linear) -> BigRational {
        match self.draw {
            Some(place) => form.draws.get(place).cloned().unwrap_or_default(),
            None => form.state.iter().zip(&self.factors).map(|(one, other)| one * other).sum(),
        }
    }
}

/// What a form has of these.
pub(super) fn share(others: &[Other], form: &Linear) -> Share {
    let factors = others.iter().enumerate().map(|(place, other)| (place, other.factor(form)));
    let mut found = factors.filter(|(_, factor)| !factor.is_zero());
    match (found.next(), found.next()) {
        (None, _) => Share::Nothing,
        (Some((place, factor)), None) => Share::One(place, factor),
        _ => Share::Several,
    }
}

/// These numbers after a move; those that move alike are added up.
///
/// # Errors
/// Where there are too many.
pub(super) fn image_of(others: &[Other], image: &[Linear]) -> Result<Vec<Other>, String> {
    let mut after: Vec<Other> = Vec::new();
    for other in others {
        let factors: Vec<BigRational> = image.iter().map(|form| other.factor(form)).collect();
        if factors.iter().all(Zero::is_zero) {
            continue;
        }
        let alike = |old: &&mut Other| old.factors == factors && old.distribution.plus(&other.distribution).is_some();
        match after.iter_mut().find(alike) {
            Some(old) => {
                if let Some(sum) = old.distribution.plus(&other.distribution) {
                    old.distribution = sum;
                }
            }
            None => after.push(Other { factors, draw: None, distribution: other.distribution.clone() }),
        }
    }
    if after.len() > MOST {
        return Err(format!("more than {MOST} random numbers add up to no distribution that has a name"));
    }
    after.sort();
    Ok(after)
}

/// A range of one number, with whether its ends belong to it.
#[derive(Default)]
struct Within {
    low: Option<(BigRational, bool)>,
    high: Option<(BigRational, bool)>,
    never: bool,
}

/// The chance of a region that depends on one of these numbers and on what is certain, or on one sum of them and of what
/// is normal; `normal` gives the mean and the variance of what is not one of these.
///
/// # Errors
/// Where it depends on more.
pub(super) fn chance(
    others: &[Other],
    region: &Region,
    normal: &impl Fn(&Linear) -> (BigRational, BigRational),
) -> Result<Interval, String> {
    let several = |side: &Side| matches!(share(others, &side.form), Share::Several) || !normal(&side.form).1.is_zero();
    if region.iter().flatten().any(several) {
        return summed(others, region, normal);
    }
    let mut number = None;
    let mut all = Vec::new();
    for alternative in region {
        let mut within = Within::default();
        for side in alternative {
            let (mean, _) = normal(&side.form);
            match share(others, &side.form) {
                Share::Nothing => within.never |= !side.relation.holds(mean.cmp(&BigRational::zero())),
                Share::One(place, _) if number.is_some_and(|number| number != place) => {
                    return Err("what is asked for depends on several random numbers at once".to_string());
                }
                Share::One(place, factor) => {
                    number = Some(place);
                    within.cut(side, &factor, &mean)?;
                }
                Share::Several => {
                    return Err("what is asked for adds up random numbers whose sum has no name".to_string());
                }
            }
        }
        if !within.never {
            all.push(within);
        }
    }
    let Some(distribution) = number.and_then(|number| others.get(number)).map(|other| &other.distribution) else {
        return Err("what is asked for is lost".to_string());
    };
    let chance = match distribution {
        Distribution::Poisson { .. } => counted(distribution, all),
        _ => {
            let part = |within: &Within| match (&within.low, &within.high) {
                (Some((low, _)), Some((high, _))) if low >= high => Interval::exactly(0.0),
                (Some((low, _)), Some((high, _))) => distribution.between(low, high),
                (Some((low, _)), None) => distribution.more_than(low),
                (None, Some((high, _))) => distribution.at_most(high),
                (None, None) => Interval::exactly(1.0),
            };
            // Alternatives overlap at their ends alone, which have no chance.
            all.iter().map(part).reduce(Interval::plus).unwrap_or(Interval::exactly(0.0)).probability()
        }
    };
    if chance.width() < 1.0 {
        Ok(chance)
    } else {
        Err("there are too many arrivals to add up their chances".to_string())
    }
}

/// The chance of a region whose forms are multiples of one sum of random numbers.
fn summed(
    others: &[Other],
    region: &Region,
    normal: &impl Fn(&Linear) -> (BigRational, BigRational),
) -> Result<Interval, String> {
    let random = |form: &Linear| !normal(form).1.is_zero() || !matches!(share(others, form), Share::Nothing);
    let base = region.iter().flatten().map(|side| &side.form).find(|form| random(form)).ok_or("nothing is drawn")?;
    let factors = |form: &Linear| others.iter().map(|other| other.factor(form)).collect::<Vec<BigRational>>();
    let (own, (mean, variance)) = (factors(base), normal(base));
    let place = own.iter().position(|factor| !factor.is_zero());
    let mut all = Vec::new();
    for alternative in region {
        let mut within = Within::default();
        for side in alternative.iter() {
            if !random(&side.form) {
                within.never |= !side.relation.holds(normal(&side.form).0.cmp(&BigRational::zero()));
                continue;
            }
            let several = "what is asked for depends on several random numbers at once";
            let place = place.ok_or(several)?;
            let ratio = &factors(&side.form)[place] / &own[place];
            let (rest, noise) = normal(&side.form.plus(&base.scaled(&-&ratio)));
            let same = factors(&side.form).iter().zip(&own).all(|(one, other)| *one == other * &ratio);
            if ratio.is_zero() || !same || !noise.is_zero() {
                return Err(several.to_string());
            }
            within.cut(side, &ratio, &rest)?;
        }
        if !within.never {
            all.push(within);
        }
    }
    let drawn: Vec<_> =
        others.iter().map(|other| &other.distribution).zip(&own).filter(|one| !one.1.is_zero()).collect();
    let (sum, mirrored) = sum_of(&mean, &variance, &drawn)?;
    let at_most = |bound: &BigRational| -> Result<Interval, String> {
        let at = if mirrored { sum.at_most(&-bound)? } else { sum.at_most(bound)? };
        Ok(if mirrored { Interval::exactly(1.0).minus(at.interval()) } else { at.interval() })
    };
    let mut total = Interval::exactly(0.0);
    for within in &all {
        if within.low.as_ref().zip(within.high.as_ref()).is_some_and(|(low, high)| low.0 >= high.0) {
            continue;
        }
        let high = within.high.as_ref().map_or(Ok(Interval::exactly(1.0)), |(high, _)| at_most(high))?;
        let low = within.low.as_ref().map_or(Ok(Interval::exactly(0.0)), |(low, _)| at_most(low))?;
        // One number has no chance, so it does not matter to which side the ends belong.
        total = total.plus(high.minus(low).probability());
    }
    Ok(total.probability())
}

/// The sum of a normal number and of multiples of others; or, where these reach down without end, that of all with the
/// other sign, and true.
fn sum_of(
    mean: &BigRational,
    variance: &BigRational,
    drawn: &[(&Distribution, &BigRational)],
) -> Result<(Sum, bool), String> {
    let with = |sign: &BigRational| -> Result<Sum, String> {
        let mut sum = Sum::new(false);
        sum.add(&Distribution::Normal { mean: sign * mean, variance: variance.clone() })?;
        for (one, factor) in drawn {
            let scaled = one.affine(&(sign * *factor), &BigRational::zero());
            sum.add(&scaled.ok_or("what is asked for adds up random numbers whose sum has no name")?)?;
        }
        Ok(sum)
    };
    let one = BigRational::one();
    match with(&one) {
        Ok(sum) => Ok((sum, false)),
        Err(reason) => with(&-one).map(|sum| (sum, true)).map_err(|_| reason),
    }
}

impl Within {
    /// `factor * X + mean REL 0`
    fn cut(&mut self, side: &Side, factor: &BigRational, mean: &BigRational) -> Result<(), String> {
        let bound = -mean / factor;
        let (above, closed) = match side.relation {
            Relation::Eq => {
                self.raise(bound.clone(), true);
                self.lower(bound, true);
                return Ok(());
            }
            Relation::Neq => return Err("what is asked for leaves out one number".to_string()),
            Relation::Gtr => (true, false),
            Relation::Gte => (true, true),
            Relation::Lss => (false, false),
            Relation::Lte => (false, true),
        };
        if above != factor.is_negative() {
            self.raise(bound, closed)
        } else {
            self.lower(bound, closed)
        }
        Ok(())
    }

    fn raise(&mut self, bound: BigRational, closed: bool) {
        let tighter = |(old, was): &(BigRational, bool)| bound > *old || (bound == *old && *was && !closed);
        if self.low.as_ref().is_none_or(tighter) {
            self.low = Some((bound, closed));
        }
    }

    fn lower(&mut self, bound: BigRational, closed: bool) {
        let tighter = |(old, was): &(BigRational, bool)| bound < *old || (bound == *old && *was && !closed);
        if self.high.as_ref().is_none_or(tighter) {
            self.high = Some((bound, closed));
        }
    }

    /// The whole numbers in it, from 0 on: the first and the last.
    fn counts(&self) -> (BigRational, Option<BigRational>) {
        let first = self.low.as_ref().map_or_else(BigRational::zero, |(low, closed)| {
            if *closed { low.ceil() } else { low.floor() + BigRational::one() }
        });
        let last = self.high.as_ref().map(
            |(high, closed)| {
                if *closed { high.floor() } else { high.ceil() - BigRational::one() }
            },
        );
        (first.max(BigRational::zero()), last)
    }
}

/// The chance of a count in one of these, each count once.
fn counted(distribution: &Distribution, all: Vec<Within>) -> Interval {
    let mut ranges: Vec<_> = all.iter().map(Within::counts).collect();
    ranges.sort();
    let mut total = Interval::exactly(0.0);
    let mut from = BigRational::zero();
    for (first, last) in ranges {
        let first = first.max(from.clone());
        match last {
            Some(last) if first <= last => {
                total = total.plus(distribution.between(&first, &last));
                from = last + BigRational::one();
            }
            Some(_) => {}
            None => {
                let tail = distribution.more_than(&(first - BigRational::one()));
                return total.plus(tail).probability();
            }
        }
    }
    total.probability()
}
