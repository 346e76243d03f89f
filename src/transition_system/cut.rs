//! Values of continuous draws by cells: between which cuts a value lies is drawn, with the chance of that cell.
//!
//! What is seen of such a value is between which of some probes it lies. That keeps less than the value, so that what
//! differs in this view differs. Any number that is written or computed from those written stays itself: a drawn value
//! is none of them, but for no chance. Chances are exact for uniform distributions, else they come with their error.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::distribution::Distribution;
use crate::model::Bounds;
use crate::value::Value;

/// The most probes.
const MOST_PROBES: usize = 12;
/// The decimals to which chances are kept that are not exact.
const DECIMALS: usize = 12;

/// Where values are cut.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cuts {
    /// The cuts of the values of a distribution.
    pub(crate) of: BTreeMap<Value, BTreeSet<BigRational>>,
    /// What is seen of a value: between which of these it lies.
    pub(crate) probes: BTreeSet<BigRational>,
    /// The values that are seen for which probes were chosen: a distribution, a factor, a shift.
    seen: BTreeSet<(Value, BigRational, BigRational)>,
}

/// One cell: its bounds, and its chance.
pub(super) type Cell = (Bounds, BigRational);

impl Cuts {
    /// One more cut; false if it is there.
    pub(crate) fn cut(&mut self, distribution: &Value, at: BigRational) -> bool {
        self.of.entry(distribution.clone()).or_default().insert(at)
    }

    /// Chooses probes for a value that is seen, the distribution's own with this factor and shift; false if that was
    /// done before.
    pub(crate) fn probe(&mut self, distribution: &Value, factor: &BigRational, shift: &BigRational) -> bool {
        let new = self.seen.insert((distribution.clone(), factor.clone(), shift.clone()));
        for place in places(distribution) {
            if new && self.probes.len() < MOST_PROBES {
                self.probes.insert(factor * place + shift);
            }
        }
        new
    }

    /// Whether probes were chosen for such a value, or enough for all.
    pub(super) fn knows(&self, distribution: &Value, factor: &BigRational, shift: &BigRational) -> bool {
        self.probes.len() >= MOST_PROBES || self.seen.contains(&(distribution.clone(), factor.clone(), shift.clone()))
    }

    /// The cells of a distribution with how far their chances may be off together; none of one that is not continuous.
    pub(super) fn cells(&self, distribution: &Value) -> Option<(Vec<Cell>, BigRational)> {
        let found = Distribution::of(distribution).ok().filter(continuous)?;
        let empty = BTreeSet::new();
        let cuts = self.of.get(distribution).unwrap_or(&empty);
        let mut error = BigRational::zero();
        let mut all = Vec::new();
        let (mut low, end) = support(&found);
        let mut before = BigRational::zero();
        let inside = |cut: &&BigRational| {
            low.as_ref().is_none_or(|low| **cut > *low) && end.as_ref().is_none_or(|end| **cut < *end)
        };
        let cuts: Vec<BigRational> = cuts.iter().filter(inside).cloned().collect();
        for cut in cuts.into_iter().map(Some).chain([None]) {
            let (below, off) = match &cut {
                Some(cut) => at_most(&found, cut)?,
                None => (BigRational::one(), BigRational::zero()),
            };
            let chance = &below - &before;
            // A cell without a chance, as far as is known, is left out.
            if chance.is_positive() {
                all.push(((low, cut.clone().or(end.clone())), chance));
                before = below;
            }
            low = cut;
            error = error.max(off);
        }
        let off = error * BigRational::from_integer((2 * all.len()).into());
        Some((all, off))
    }
}

/// Between which bounds all values lie.
fn support(distribution: &Distribution) -> Bounds {
    match distribution {
        Distribution::Uniform { low, high } => (Some(low.clone()), Some(high.clone())),
        Distribution::Exponential { start, rising: true, .. } => (Some(start.clone()), None),
        _ => (None, None),
    }
}

/// Whether no single value has a chance.
fn continuous(distribution: &Distribution) -> bool {
    match distribution {
        Distribution::Normal { variance, .. } => variance.is_positive(),
        Distribution::Uniform { low, high } => low < high,
        Distribution::Exponential { .. } => true,
        Distribution::Mixture(parts) => parts.iter().all(|(_, part)| continuous(part)),
        Distribution::Point(_) | Distribution::Poisson { .. } => false,
    }
}

/// The chance of at most this, and how far it may be off.
fn at_most(distribution: &Distribution, bound: &BigRational) -> Option<(BigRational, BigRational)> {
    match distribution {
        Distribution::Uniform { low, high } => {
            let part = (bound - low) / (high - low);
            Some((part.max(BigRational::zero()).min(BigRational::one()), BigRational::zero()))
        }
        Distribution::Exponential { start, rising: true, .. } if bound <= start => {
            Some((BigRational::zero(), BigRational::zero()))
        }
        Distribution::Normal { mean, .. } if mean == bound => {
            Some((BigRational::new(1.into(), 2.into()), BigRational::zero()))
        }
        Distribution::Mixture(parts) => {
            let (mut sum, mut error) = (BigRational::zero(), BigRational::zero());
            for (weight, part) in parts {
                let (chance, off) = at_most(part, bound)?;
                sum += weight * chance;
                error += weight * off;
            }
            Some((sum, error))
        }
        _ => {
            let (low, high) = distribution.at_most(bound).bounds()?;
            let scale = BigRational::from_integer(BigInt::from(10).pow(DECIMALS as u32));
            let near = ((&low + &high) / BigRational::from_integer(2.into()) * &scale).round() / scale;
            let error = (&near - low).abs().max((high - &near).abs());
            Some((near, error))
        }
    }
}

/// Places of a distribution at which others are likely to have other chances: the mean, and one deviation beyond.
fn places(distribution: &Value) -> Vec<BigRational> {
    let Ok(found) = Distribution::of(distribution) else { return Vec::new() };
    let (mean, variance) = (found.mean(), found.variance());
    // Any number near the deviation does: a few steps of Newton's.
    let mut root = variance.clone().max(BigRational::one());
    let hundred = BigRational::from_integer(100.into());
    for _ in 0..40 {
        root = ((&root + &variance / &root) / BigRational::from_integer(2.into()) * &hundred).ceil() / &hundred;
    }
    vec![mean.clone(), mean + root]
}
