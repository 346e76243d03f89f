//! Linear maps of normal numbers, exactly: means and covariances as rationals, mixtures as weights; other numbers beside
//! them, as long as no two of different kinds are added up.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::chain::{Chain, Linear, Move, Region, Side, Stretch};
use super::other::{Other, Share, image_of, share};
use super::{Enclosed, Question, late};
use crate::distribution::{Distribution, standard};
use crate::interval::{Interval, normal_between};
use crate::value::Relation;

/// Parts that a mixture may have.
const MOST_PARTS: usize = 4_096;
/// Rounds of parts that are followed in all.
const MOST_ROUNDS: usize = 200_000;
/// Bits of the exact numbers.
const MOST_BITS: u64 = 400_000;

type Matrix = Vec<Vec<BigRational>>;

/// A chance with what it follows from.
#[derive(Clone, Debug)]
pub struct Exact {
    /// The chance.
    pub chance: Enclosed,
    /// What is shown at the time asked for: a name with the normal parts of its distribution.
    pub shown: Vec<(crate::name::Name, Distribution)>,
}

/// A normal part of the distribution over the states, at one time.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    time: BigRational,
    phase: Option<usize>,
    mean: Vec<BigRational>,
    covariance: Matrix,
    /// What is neither normal nor certain.
    others: Vec<Other>,
}

struct Walker<'a> {
    chain: &'a Chain,
    question: &'a Question,
    /// Of parts for which it is certain, exactly.
    certain: BigRational,
    /// Of the others.
    chance: Interval,
    parts: Vec<(BigRational, BigRational, BigRational)>,
}

/// The chance, if everything on the way is linear and no guard cuts a distribution.
///
/// # Errors
/// Where that is not so.
pub fn exact(chain: &Chain, question: &Question) -> Result<Exact, String> {
    let start =
        Part { time: BigRational::zero(), phase: None, mean: Vec::new(), covariance: Vec::new(), others: Vec::new() };
    let mut walker =
        Walker { chain, question, certain: BigRational::zero(), chance: Interval::exactly(0.0), parts: Vec::new() };
    let mut work: BTreeMap<Part, BigRational> = BTreeMap::from([(start, BigRational::one())]);
    let mut rounds = 0usize;
    // The earliest part is first in the order, so parts that meet are one by the time they are followed.
    while let Some((part, weight)) = work.pop_first() {
        rounds += 1;
        if rounds > MOST_ROUNDS || work.len() > MOST_PARTS {
            return Err(format!("there are more than {MOST_PARTS} parts to follow"));
        }
        let bits = |number: &BigRational| number.denom().bits().max(number.numer().bits());
        if part.mean.iter().any(|number| bits(number) > MOST_BITS) {
            return Err("the exact numbers grow too long".to_string());
        }
        for (next, share) in walker.onward(&part, &weight)? {
            *work.entry(next).or_insert_with(BigRational::zero) += share;
        }
    }
    // Parts that are not normal are not among them; then the others are not the whole distribution.
    let whole = walker.parts.iter().map(|(weight, ..)| weight).sum::<BigRational>().is_one();
    let shown = match &question.names[..] {
        [name] if whole => {
            let normal = |(weight, mean, variance): &(BigRational, BigRational, BigRational)| {
                (weight.clone(), Distribution::Normal { mean: mean.clone(), variance: variance.clone() })
            };
            vec![(name.clone(), Distribution::Mixture(walker.parts.iter().map(normal).collect()))]
        }
        _ => Vec::new(),
    };
    // Chances that are not exact are above nothing: where there are none, the sum is this rational.
    let chance = if walker.chance == Interval::exactly(0.0) {
        Enclosed::known(walker.certain)
    } else {
        Enclosed::within(Interval::of(&walker.certain).plus(walker.chance).probability())
    };
    Ok(Exact { chance, shown })
}

impl Walker<'_> {
    /// Where a part goes, with its share of the weight; what is asked for is counted on the way.
    fn onward(&mut self, part: &Part, weight: &BigRational) -> Result<Vec<(Part, BigRational)>, String> {
        let moves = match part.phase {
            None => &self.chain.initial,
            Some(phase) => self.chain.phases.get(phase).ok_or("a phase is missing")?,
        };
        let mut onward = Vec::new();
        let mut taken = BigRational::zero();
        for one in moves {
            for (share, joint) in joint(part, one)? {
                if !one.tests.iter().try_fold(true, |all, side| Ok::<_, String>(all && joint.surely(side)?))? {
                    continue;
                }
                taken += &share;
                if let Some(next) = self.pass(part, one, &joint, &(weight * &share))? {
                    onward.push((next, weight * &share));
                }
            }
        }
        if !taken.is_one() {
            return Err("the ways through a round overlap, or leave something out".to_string());
        }
        Ok(onward)
    }

    /// One move: what is asked for is counted; the part after it, unless it is decided by then.
    fn pass(&mut self, part: &Part, one: &Move, joint: &Joint, weight: &BigRational) -> Result<Option<Part>, String> {
        let mut time = part.time.clone();
        for stretch in &one.stretches {
            let end = stretch.duration.as_ref().map(|duration| &time + duration);
            let counts = if self.question.first {
                time <= self.question.time
            } else {
                time <= self.question.time && end.as_ref().is_none_or(|end| *end > self.question.time)
            };
            // Where it was not shown before, and no later stretch counts, its chance here is what is asked for.
            let last = end.as_ref().is_none_or(|end| *end > self.question.time);
            if counts && self.count(stretch, joint, weight, last)? {
                return Ok(None);
            }
            match end {
                Some(end) => time = end,
                None => return Ok(None),
            }
        }
        let Some(next) = one.next.filter(|_| !late(&time, self.question)) else { return Ok(None) };
        if time == part.time && part.phase.is_some() {
            return Err("a round takes no time".to_string());
        }
        let (mean, covariance) = joint.image(&one.image);
        let others = image_of(&joint.others, &one.image)?;
        Ok(Some(Part { time, phase: Some(next), mean, covariance, others }))
    }

    /// Counts what is asked for in a stretch; true if that decides it for this part.
    fn count(&mut self, stretch: &Stretch, joint: &Joint, weight: &BigRational, last: bool) -> Result<bool, String> {
        if self.question.first && !last {
            let mut reached = false;
            for alternative in &stretch.shown {
                let mut all = true;
                for side in alternative {
                    all &= joint.surely(side)?;
                }
                reached |= all;
            }
            if reached {
                self.certain += weight;
            }
            return Ok(reached);
        }
        let chance = joint.chance(&stretch.shown)?;
        if chance == Interval::exactly(1.0) {
            self.certain += weight;
        } else if chance == Interval::exactly(0.5) {
            self.certain += weight / BigRational::from_integer(2.into());
        } else if chance != Interval::exactly(0.0) {
            self.chance = self.chance.plus(chance.times(Interval::of(weight)));
        }
        if let ([value], true) = (stretch.values.as_slice(), joint.others.is_empty() && !self.question.first) {
            self.parts.push((weight.clone(), joint.mean(value), joint.variance(value)));
        }
        Ok(true)
    }
}

/// State and draws together.
struct Joint {
    mean: Vec<BigRational>,
    covariance: Matrix,
    draws: Vec<(BigRational, BigRational)>,
    others: Vec<Other>,
}

/// A part of the draws: its weight, the means and variances of what is normal, and what is not.
type Drawn = (BigRational, Vec<(BigRational, BigRational)>, Vec<Other>);

/// The state with each combination of the normal parts of the draws.
fn joint(part: &Part, one: &Move) -> Result<Vec<(BigRational, Joint)>, String> {
    let mut all: Vec<Drawn> = vec![(BigRational::one(), Vec::new(), part.others.clone())];
    for (place, draw) in one.draws.iter().enumerate() {
        let shares = draw.parts();
        let mut longer = Vec::new();
        for (weight, draws, others) in &all {
            for (share, drawn) in &shares {
                let (mut draws, mut others) = (draws.clone(), others.clone());
                match drawn.normals().as_deref() {
                    Some([(_, mean, variance)]) => draws.push((mean.clone(), variance.clone())),
                    _ => {
                        draws.push((BigRational::zero(), BigRational::zero()));
                        others.push(Other::drawn(place, drawn.clone()));
                    }
                }
                longer.push((weight * share, draws, others));
            }
        }
        if longer.len() > MOST_PARTS {
            return Err(format!("a round has more than {MOST_PARTS} combinations of draws"));
        }
        all = longer;
    }
    let with = |(weight, draws, others): Drawn| {
        (weight, Joint { mean: part.mean.clone(), covariance: part.covariance.clone(), draws, others })
    };
    Ok(all.into_iter().map(with).collect())
}

impl Joint {
    fn mean(&self, form: &Linear) -> BigRational {
        let state: BigRational = form.state.iter().zip(&self.mean).map(|(factor, mean)| factor * mean).sum();
        let draws: BigRational = form.draws.iter().zip(&self.draws).map(|(factor, (mean, _))| factor * mean).sum();
        state + draws + &form.constant
    }

    fn covariance(&self, one: &Linear, other: &Linear) -> BigRational {
        let mut sum = BigRational::zero();
        for (row, left) in self.covariance.iter().zip(&one.state).filter(|(_, left)| !left.is_zero()) {
            for (number, right) in row.iter().zip(&other.state) {
                sum += left * number * right;
            }
        }
        for ((left, right), (_, variance)) in one.draws.iter().zip(&other.draws).zip(&self.draws) {
            sum += left * right * variance;
        }
        sum
    }

    fn variance(&self, form: &Linear) -> BigRational {
        self.covariance(form, form)
    }

    fn image(&self, image: &[Linear]) -> (Vec<BigRational>, Matrix) {
        let mean = image.iter().map(|form| self.mean(form)).collect();
        let row = |one: &Linear| image.iter().map(|other| self.covariance(one, other)).collect();
        (mean, image.iter().map(row).collect())
    }

    /// Whether a test holds for certain, or fails for certain.
    fn surely(&self, side: &Side) -> Result<bool, String> {
        if !matches!(share(&self.others, &side.form), Share::Nothing) {
            return Err("a guard cuts a distribution that is not followed".to_string());
        }
        if self.variance(&side.form).is_zero() {
            return Ok(side.relation.holds(self.mean(&side.form).cmp(&BigRational::zero())));
        }
        match side.relation {
            Relation::Eq => Ok(false),
            Relation::Neq => Ok(true),
            _ => Err("a guard cuts a distribution, so that what is left is not normal".to_string()),
        }
    }

    /// The chance of a region in which all forms are multiples of one.
    fn chance(&self, region: &Region) -> Result<Interval, String> {
        let sides = region.iter().flatten();
        if sides.clone().any(|side| !matches!(share(&self.others, &side.form), Share::Nothing)) {
            let normal = |form: &Linear| (self.mean(form), self.variance(form));
            return super::other::chance(&self.others, region, &normal);
        }
        let mut sum = Interval::exactly(0.0);
        for alternative in region {
            match self.stretch(alternative)? {
                Some(chance) if chance == Interval::exactly(0.0) => {}
                Some(chance) if sum == Interval::exactly(0.0) => sum = chance,
                Some(chance) => sum = sum.plus(chance),
                // All that is asked is certain.
                None => return Ok(Interval::exactly(1.0)),
            }
        }
        Ok(if sum == Interval::exactly(0.0) { sum } else { sum.probability() })
    }

    /// The chance of one alternative; none if it is certain.
    fn stretch(&self, alternative: &[Side]) -> Result<Option<Interval>, String> {
        let mut base: Option<(&Linear, BigRational, BigRational)> = None;
        let (mut low, mut high): (Option<BigRational>, Option<BigRational>) = (None, None);
        for side in alternative {
            let (mean, variance) = (self.mean(&side.form), self.variance(&side.form));
            if variance.is_zero() {
                if !side.relation.holds(mean.cmp(&BigRational::zero())) {
                    return Ok(Some(Interval::exactly(0.0)));
                }
                continue;
            }
            match side.relation {
                Relation::Eq => return Ok(Some(Interval::exactly(0.0))),
                Relation::Neq => continue,
                _ => {}
            }
            let (first, first_mean, first_variance) =
                base.get_or_insert_with(|| (&side.form, mean.clone(), variance.clone()));
            let factor = self.covariance(first, &side.form) / &*first_variance;
            if variance != &factor * &factor * &*first_variance {
                return Err("what is asked for depends on several random numbers at once".to_string());
            }
            // mean + factor * (f - first_mean) REL 0, so f REL bound, mirrored for a negative factor.
            let bound = &*first_mean - mean / &factor;
            let above = matches!(side.relation, Relation::Gtr | Relation::Gte) != factor.is_negative();
            let end = if above { &mut low } else { &mut high };
            let tighter = end.as_ref().is_none_or(|old| if above { bound > *old } else { bound < *old });
            if tighter {
                *end = Some(bound);
            }
        }
        let Some((_, mean, variance)) = base else { return Ok(None) };
        if low.as_ref().zip(high.as_ref()).is_some_and(|(low, high)| low >= high) {
            return Ok(Some(Interval::exactly(0.0)));
        }
        let place = |bound: Option<BigRational>, otherwise: f64| {
            bound.map_or(Interval::exactly(otherwise), |bound| standard(&bound, &mean, &variance))
        };
        Ok(Some(normal_between(place(low, f64::NEG_INFINITY), place(high, f64::INFINITY))))
    }
}
