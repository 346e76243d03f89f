//! How likely a system does something: exactly where the algebra is closed, else enclosed numerically with a bound
//! that is proved, else estimated by simulation with a stated confidence.

pub mod chain;
pub mod enclosed;
pub mod estimated;
pub mod exact;
mod grid;
pub mod normal;
pub mod random;
pub mod scalar;

use num_rational::BigRational;

use crate::name::Name;

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
