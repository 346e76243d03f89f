//! Equality and refinement of closed terms, decided on what they do, with the shortest run that tells two apart.
//!
//! Strong timed bisimulation over outcomes, results, observations, actions, chances and time. Pairs of states are
//! explored breadth first; then those that differ at once are marked, then those from which one side can force such a
//! pair in one step, and so on, so that the first mark a pair gets is its shortest separation.
//!
//! Time is dense. Between two events nothing changes but the residual delays, so a pair in which neither side offers a
//! communication steps to the next event of either side. Where there is an offer, it may be taken up at any moment:
//! such pairs step by half of the greatest common divisor of all delays, which reaches every event and a moment
//! between any two ([`compare_densely`] tries every moment that matters). What is drawn from a continuous distribution is a symbol (`draw.rs`): a difference never rests on
//! its value. `Different` is always exact; `Same` is exact for terms that take up one offer between two events.

mod draw;
mod game;
mod grain;
mod lottery;
mod region;
mod run;
mod weak;

use num_rational::BigRational;

use crate::definition::Definitions;
use crate::law::Connective;
use crate::model::{Meaningless, Outcome, State, explore::Label};
use crate::term::Term;
use crate::value::Value;

pub(crate) use grain::{common_divisor, grain};
pub use run::replay;

/// How two terms compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Comparison {
    /// They are equal, or the first is refined by the second, whichever was asked.
    Same,
    /// They are not, as this run shows.
    Different(Run),
    /// Not decided: this many pairs of states were not enough.
    Unknown(usize),
}

/// One of the two terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The first.
    Left,
    /// The second.
    Right,
    /// Both at once, in time.
    Both,
}

/// One step of a run: one side's move with the other's best answer, or time for both.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// Who moves first; the other answers.
    pub side: Side,
    /// What is done.
    pub label: Label,
    /// The left state after it.
    pub left: State,
    /// The right state after it.
    pub right: State,
}

/// Where two states differ at once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    /// They have ended differently (running, stopped with these results, aborted).
    Outcome(Outcome, Outcome),
    /// They show different things.
    Observations(Box<State>, Box<State>),
    /// This side can do this, the other cannot.
    Move(Side, Label),
    /// This side lets time pass, the other does not.
    Time(Side),
    /// They draw with different chances.
    Chances(Vec<(BigRational, State)>, Vec<(BigRational, State)>),
}

/// A shortest run that tells two terms apart: steps that both can take, and how the states after them differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The steps, none if the terms differ at once.
    pub steps: Vec<Step>,
    /// What then differs.
    pub difference: Difference,
}

/// How far to look.
#[derive(Clone, Debug)]
pub struct Reach {
    /// The most pairs of states.
    pub pairs: usize,
    /// The values that the surroundings may write to a port that is read (and that a draw may give).
    pub inputs: Vec<Value>,
}

impl Default for Reach {
    fn default() -> Reach {
        Reach { pairs: 20_000, inputs: vec![Value::integer(0), Value::integer(1)] }
    }
}

/// Compares two closed terms.
///
/// # Errors
/// [`Meaningless`] where a state that is reached has no meaning.
pub fn compare(
    left: &Term,
    right: &Term,
    connective: Connective,
    definitions: &Definitions,
    reach: &Reach,
) -> Result<Comparison, Meaningless> {
    game::Game::new(definitions, connective, reach, left, right).decide(left, right)
}

/// Compares two closed terms with regard to every moment at which something may happen; the unit divides every delay.
/// Both answers are exact, but for the values that are read from outside; there is no weak comparison of this kind.
///
/// # Errors
/// [`Meaningless`] where a state that is reached has no meaning.
pub fn compare_densely(
    left: &Term,
    right: &Term,
    refines: bool,
    definitions: &Definitions,
    reach: &Reach,
    unit: &BigRational,
) -> Result<Comparison, Meaningless> {
    let connective = if refines { Connective::Refines } else { Connective::Equal };
    let mut game = game::Game::new(definitions, connective, reach, left, right);
    game.unit = Some(unit.clone());
    game.decide(left, right)
}
