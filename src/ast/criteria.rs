//! What an operator asks of a mission, and parameters that run through values, as written.

use super::{Ident, Item, Likelihood, Term, Value};
use crate::diagnostic::Span;
use crate::value::Relation;

/// What an operator asks of a mission.
#[derive(Clone, Debug)]
pub struct Criteria {
    /// Their name.
    pub name: Ident,
    /// The system.
    pub system: Ident,
    /// What is asked, in order.
    pub clauses: Vec<Clause>,
}

/// One line of criteria.
#[derive(Clone, Debug)]
pub struct Clause {
    /// Its place.
    pub span: Span,
    /// What it says.
    pub kind: ClauseKind,
}

/// The kinds of criteria.
#[derive(Clone, Debug)]
pub enum ClauseKind {
    /// `goals At_10, At_0`
    Goals(Vec<Term>),
    /// `radius 1/10`
    Radius(Value),
    /// `leg within 12`, `every leg to At_10 within 12`
    Leg {
        /// Whether all rounds count, not the first alone.
        every: bool,
        /// The goal; all legs when none is named.
        to: Option<Term>,
        /// The longest time.
        limit: Value,
    },
    /// `round within 20`, `every round within 20`
    Round {
        /// Whether all rounds count, not the first alone.
        every: bool,
        /// The longest time.
        limit: Value,
    },
    /// `clearance > 1 between At, Rock`
    Clearance {
        /// Whether the distance itself does not count.
        strict: bool,
        /// The distance.
        limit: Value,
        /// The two observers.
        between: [Ident; 2],
    },
    /// `battery 100 rate 2, rate 1 while Rough keep 20 for 30`
    Battery {
        /// The charge at the start.
        start: Value,
        /// What is used up in a unit of time, always or while something is shown.
        rates: Vec<(Value, Option<Ident>)>,
        /// What must be left.
        keep: Value,
        /// For how long; the first round when it is not said.
        time: Option<Value>,
    },
    /// `probability of reaching At_p where … within 10 >= 9/10`
    Probability(Likelihood, Relation, Value),
}

/// Parameters that run through values, and what is asked at each point.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The parameters.
    pub axes: Vec<(Ident, AxisKind)>,
    /// What is asked: `prove …`, `probability …`, or criteria by their name.
    pub questions: Vec<SweepQuestion>,
}

/// The values of a parameter in a sweep.
#[derive(Clone, Debug)]
pub enum AxisKind {
    /// `a .. b step c`
    Range(Box<[Value; 3]>),
    /// `[a, b, c]`
    List(Vec<Value>),
}

/// One question of a sweep.
#[derive(Clone, Debug)]
pub enum SweepQuestion {
    /// The name of criteria.
    Criteria(Ident),
    /// `prove …`, `probability …`
    Item(Box<Item>),
}
