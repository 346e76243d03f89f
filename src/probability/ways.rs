//! The ways of a plan in machine numbers.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::axes::AXES;
use super::kernel::{AxisRanges, Fast, Guard, near, scale};
use super::plan::{Plan, Way};
use super::region::Patch;
use super::slicer::Slicer;
use crate::interval::Interval;

/// A patch in machine numbers, or a part of one.
#[derive(Clone)]
pub(super) struct FastPatch {
    /// How much it counts; less than nothing where it is taken out of another.
    pub weight: f64,
    pub axes: [AxisRanges; AXES],
    /// Where it leads only into a part of the plane.
    pub spot: Option<Spot>,
    /// Where it leads only from a part of the plane.
    pub from: Option<Spot>,
}

/// An ellipse in the plane of the states of a phase.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    /// Whether what leads there counts, or is taken out of what leads into the whole plane.
    pub inside: bool,
    pub middle: [f64; AXES],
    pub radii: [f64; AXES],
}

/// A way in machine numbers.
#[derive(Clone)]
pub(super) struct FastWay {
    pub weight: f64,
    pub motions: [Fast; AXES],
    pub success: Vec<FastPatch>,
    pub last: Vec<FastPatch>,
    pub onward: Vec<FastPatch>,
    pub next: usize,
    /// What the slices of distances err by at most.
    pub error: f64,
}

/// An entry in machine numbers.
pub(super) struct FastEntry {
    pub time: u64,
    pub way: FastWay,
    pub chance: Interval,
}

/// A power of 2 for each axis that brings the least noise near 1.
pub(super) fn units(plan: &Plan) -> Result<[BigRational; AXES], String> {
    let ways = || plan.phases.iter().flatten().chain(plan.entries.iter().map(|entry| &entry.way));
    let unit = |axis: usize| {
        let variances = ways().map(|way| &way.motions[axis].variance).filter(|variance| !variance.is_zero());
        variances.min().map_or_else(BigRational::one, |least| scale(least).1)
    };
    let (one, other) = (unit(0), unit(1));
    if [&one, &other].iter().any(|unit| unit.numer().bits().max(unit.denom().bits()) > 1_000) {
        return Err("the noise is too small or too large for machine numbers".to_string());
    }
    Ok([one, other])
}

/// More than the chance that a normal number is 12 standard deviations off, a million times.
pub(super) const UNLIKELY: f64 = 1e-26;

impl FastWay {
    /// From where there is no state, without the ends of ranges that the next state does not come near to.
    pub(super) fn near(mut self) -> FastWay {
        for (axis, motion) in self.motions.iter().enumerate().filter(|(_, motion)| motion.guard == Guard::Next) {
            let (low, high) = (motion.shift - 12.1 * motion.sd, motion.shift + 12.1 * motion.sd);
            let few = |patch: &&mut FastPatch| patch.axes[axis][1].len() < 100;
            for patch in self.onward.iter_mut().filter(few) {
                let ranges = &mut patch.axes[axis].sets[1];
                ranges.retain(|(first, last)| *first < high && *last > low);
                for (first, last) in ranges {
                    *first = if *first < low { f64::NEG_INFINITY } else { *first };
                    *last = if *last > high { f64::INFINITY } else { *last };
                }
            }
        }
        self
    }

    /// A way in machine numbers, whose slices should err by so much.
    ///
    /// # Errors
    /// Where a distance cannot be cut into slices.
    pub(super) fn of(way: &Way, units: &[BigRational; AXES], wanted: f64) -> Result<FastWay, String> {
        let motions = [0, 1].map(|axis: usize| Fast::of(&way.motions[axis], &units[axis]));
        let mut error = 0.0;
        let mut fast = |patches: &[Patch], onward: bool| -> Result<Vec<FastPatch>, String> {
            let mut all = Vec::new();
            for patch in patches {
                error += Slicer { way, motions: &motions, units, wanted, onward }.sliced(patch, &mut all)?;
            }
            Ok(all)
        };
        let [success, last, onward] = [fast(&way.success, false)?, fast(&way.last, false)?, fast(&way.onward, true)?];
        Ok(FastWay { weight: near(&way.weight), motions, success, last, onward, next: way.next, error })
    }

    /// Whether a distance decides it.
    pub(super) fn is_sliced(&self) -> bool {
        let sliced = |patch: &FastPatch| {
            patch.spot.is_some() || patch.from.is_some() || patch.axes.iter().any(|ranges| !ranges.points.is_empty())
        };
        self.patches().any(sliced)
    }

    pub(super) fn patches(&self) -> impl Iterator<Item = &FastPatch> {
        self.success.iter().chain(&self.last).chain(&self.onward)
    }
}
