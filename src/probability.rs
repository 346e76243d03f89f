//! How likely a system does something: exactly where the algebra is closed, else enclosed numerically with a bound
//! that is proved, else estimated by simulation with a stated confidence.

pub mod axes;
pub mod boxes;
pub mod branches;
pub mod chain;
mod changed;
pub mod direct;
mod deviate;
pub mod disc;
mod draft;
mod durations;
mod ellipse;
pub mod enclosed;
pub mod estimated;
pub mod exact;
mod bell;
mod broken;
mod field;
mod foreseen;
mod form;
pub mod grid;
mod growth;
mod joint;
mod kernel;
mod lattice;
pub mod linear;
mod noise;
pub mod normal;
mod operator;
mod other;
mod pace;
mod pair;
mod panels;
mod piecewise;
pub mod plan;
pub mod races;
pub mod random;
mod recut;
pub mod region;
mod rounded;
mod rows;
pub mod schedule;
mod sharp;
mod simulation;
mod slicer;
mod slices;
mod splitting;
mod spots;
mod spread;
mod step;
mod stretches;
mod sums;
mod tabled;
mod unlikely;
mod unrolled;
mod ways;
mod wide;
mod window;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::interval::Interval;
use crate::name::Name;
use crate::value::Relation;

/// What is asked of a chain.
#[derive(Clone, Debug)]
pub struct Question {
    /// Whether any time up to the given one counts.
    pub first: bool,
    /// The time, from the start.
    pub time: BigRational,
    /// The names that stand for what is shown.
    pub names: Vec<Name>,
}

/// Whether a time is too late to count.
pub(crate) fn late(time: &BigRational, question: &Question) -> bool {
    *time > question.time
}

/// A chance that surely lies in an interval. Only [`exact`], [`branches`], [`boxes`], [`enclosed`], [`linear`], [`races`] and [`schedule`] make one, and only with one is a threshold proved or refuted: a simulation has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Enclosed {
    interval: Interval,
    /// Closer than machine numbers are, where that is known.
    ends: Option<(BigRational, BigRational)>,
}

impl Enclosed {
    /// Somewhere in an interval.
    fn within(interval: Interval) -> Enclosed {
        Enclosed { interval, ends: None }
    }

    /// A rational, exactly.
    pub(crate) fn known(number: BigRational) -> Enclosed {
        Enclosed::from(number.clone(), number)
    }

    /// Between two rationals.
    fn from(low: BigRational, high: BigRational) -> Enclosed {
        let (low, high) = (low.max(BigRational::zero()), high.min(BigRational::one()));
        let interval = Interval::between(Interval::of(&low).low, Interval::of(&high).high).probability();
        Enclosed { interval, ends: Some((low, high)) }
    }

    /// The difference of two, where the other is part of this one.
    fn less(&self, other: &Enclosed) -> Enclosed {
        match (&self.ends, &other.ends) {
            (Some((low, high)), Some((least, most))) => Enclosed::from(low - most, high - least),
            _ => Enclosed::within(self.interval.minus(other.interval).probability()),
        }
    }

    /// The sum of two that exclude each other.
    fn or(&self, other: &Enclosed) -> Enclosed {
        match (&self.ends, &other.ends) {
            (Some((low, high)), Some((least, most))) => Enclosed::from(low + least, high + most),
            _ => Enclosed::within(self.interval.plus(other.interval).probability()),
        }
    }

    /// The product of two, which are independent.
    pub(crate) fn and(&self, other: &Enclosed) -> Enclosed {
        match (&self.ends, &other.ends) {
            (Some((low, high)), Some((least, most))) if !low.is_negative() && !least.is_negative() => {
                Enclosed::from(low * least, high * most)
            }
            _ => Enclosed::within(self.interval.times(other.interval).probability()),
        }
    }

    /// The interval.
    pub fn interval(&self) -> Interval {
        self.interval
    }

    /// The chance itself, where it is known to be this rational: where all that is drawn takes finitely many values.
    pub fn number(&self) -> Option<&BigRational> {
        self.ends.as_ref().filter(|(low, high)| low == high).map(|(low, _)| low)
    }

    /// Whether the chance compares so with a bound; none where that is open, because the bound lies in the interval.
    pub fn compare(&self, relation: Relation, bound: &BigRational) -> Option<bool> {
        let machine = || Some((BigRational::from_float(self.low)?, BigRational::from_float(self.high)?));
        let (low, high) = self.ends.clone().or_else(machine)?;
        match relation {
            Relation::Eq | Relation::Neq if low != high && low <= *bound && *bound <= high => None,
            Relation::Eq | Relation::Neq if low != high => Some(relation == Relation::Neq),
            _ => {
                let (first, second) = (relation.holds(low.cmp(bound)), relation.holds(high.cmp(bound)));
                (first == second).then_some(first)
            }
        }
    }
}

impl std::ops::Deref for Enclosed {
    type Target = Interval;

    fn deref(&self) -> &Interval {
        &self.interval
    }
}
