//! How likely a system does something: exactly where the algebra is closed, else enclosed numerically with a bound
//! that is proved, else estimated by simulation with a stated confidence.

pub mod axes;
pub mod chain;
pub mod direct;
mod draft;
pub mod enclosed;
pub mod estimated;
pub mod exact;
mod field;
pub mod grid;
mod kernel;
pub mod linear;
pub mod normal;
mod operator;
mod other;
pub mod plan;
pub mod random;
pub mod region;
pub mod schedule;
mod sharp;
mod simulation;
mod splitting;
mod unrolled;
mod window;

use num_rational::BigRational;

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

/// A chance that surely lies in an interval. Only [`exact`], [`enclosed`], [`linear`] and [`schedule`] make one, and only with one is a threshold proved or refuted: a simulation has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Enclosed(Interval);

impl Enclosed {
    /// The interval.
    pub fn interval(self) -> Interval {
        self.0
    }

    /// Whether the chance compares so with a bound; none where that is open, because the bound lies in the interval.
    pub fn compare(self, relation: Relation, bound: &BigRational) -> Option<bool> {
        let (low, high) = (BigRational::from_float(self.low)?, BigRational::from_float(self.high)?);
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
        &self.0
    }
}
