//! What processes do: termination, moves, time, observations and results of closed terms.
//!
//! This is the meaning that everything else is measured by: it knows no law, no prover and no fact about terms. A term is
//! first *settled*: everything that ends at once is ended, definitions and loops are unfolded as far as they are
//! running, and what is left is a [`State`]. The results bound so far stand as `Set` in front of what still runs, so a
//! state is itself a term. Nothing here can hang: unfolding that gets nowhere is [`Meaningless`], with the reason.

mod account;
mod cell;
mod draw;
pub mod explore;
mod replace;
mod settle;
mod step;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term, TermMap};
use crate::value::Value;

pub use account::Event;
pub(crate) use cell::{Bounds, Cells};
pub(crate) use draw::mentions_drawn;
pub use settle::Scope;

/// What a process bound when it stopped.
pub type Results = BTreeMap<Name, Value>;

/// Why a term has no meaning: a loop in no time, a name without a value, a result bound twice, …
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Meaningless {
    /// The reason, in words.
    pub why: String,
}

impl Meaningless {
    pub(crate) fn because<T>(why: impl Into<String>) -> Result<T, Meaningless> {
        Err(Meaningless { why: why.into() })
    }
}

impl fmt::Display for Meaningless {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.why)
    }
}

/// Termination, a predicate: it has priority over every move.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Outcome {
    /// Has stopped, with these results.
    Stop(Results),
    /// Has aborted, and carries nothing.
    Abort,
    /// Has not ended.
    Running,
}

/// A settled closed process.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum State {
    /// Has stopped, with these results.
    Stopped(Results),
    /// Has aborted.
    Aborted,
    /// Still runs, as this term, in which everything that had already ended is gone.
    Running(Term),
}

/// What a move does.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Action {
    /// Ready to read any value from this port.
    In(Name),
    /// Writes this value to this port.
    Out(Name, Value),
    /// An internal communication of this value over this port.
    Tau(Name, Value),
    /// Draws from these distributions, all at once; a branch with its values and chance if they are finite. Otherwise
    /// from one alone, any value.
    Draw(Vec<Value>, Option<(Vec<Value>, BigRational)>),
}

/// One thing that a process may do next.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Move {
    /// What it does.
    pub action: Action,
    /// The rule that allows it.
    pub rule: &'static str,
    /// What comes after; for `In`, and for a `Draw` without a value, see [`Move::with`].
    pub next: Term,
}

impl Move {
    /// The process after this move when the value read or drawn is this one.
    pub fn with(&self, value: &Value) -> Term {
        step::fill(&self.next, value)
    }

    /// True if the move still needs the value that is read or drawn.
    pub fn needs_value(&self) -> bool {
        matches!(self.action, Action::In(_) | Action::Draw(_, None))
    }
}

/// How long a process lets time pass before anything changes by itself.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Patience {
    /// Not at all: it has ended, an internal step is possible, or a draw is due.
    None,
    /// Until the next delay runs out, at least.
    Until(BigRational),
    /// For ever.
    Unbounded,
}

/// One thing shown: an observer with its values.
pub type Observation = (Name, Vec<Value>);

/// The meaning of closed terms under some definitions.
pub struct Model<'a> {
    definitions: &'a Definitions,
    bound: RefCell<HashMap<Name, Rc<BTreeSet<Name>>>>,
    account: account::Account,
    /// What parts that stand side by side have become, where no name is bound around them.
    settled: RefCell<TermMap<State>>,
    /// What is known of values that were drawn.
    cells: Rc<Cells>,
}

impl<'a> Model<'a> {
    /// The meaning under these definitions.
    pub fn new(definitions: &'a Definitions) -> Model<'a> {
        Model::within(definitions, Rc::default())
    }

    /// The meaning under these definitions, where this is known of values that were drawn.
    pub(crate) fn within(definitions: &'a Definitions, cells: Rc<Cells>) -> Model<'a> {
        let (bound, account, settled) = (RefCell::default(), RefCell::default(), RefCell::default());
        Model { definitions, bound, account, settled, cells }
    }

    /// The definitions that calls refer to.
    pub fn definitions(&self) -> &'a Definitions {
        self.definitions
    }

    /// The term with all that ends at once ended.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn state(&self, term: &Term) -> Result<State, Meaningless> {
        self.settle(term, &Scope::Empty, 0)
    }

    /// Whether it has ended, and how.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn outcome(&self, term: &Term) -> Result<Outcome, Meaningless> {
        Ok(self.state(term)?.outcome())
    }

    /// All that it may do next; nothing once it has ended. While a draw is due, the draw alone.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn moves(&self, term: &Term) -> Result<Vec<Move>, Meaningless> {
        self.state(term)?.moves()
    }

    /// What it shows now.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn observations(&self, term: &Term) -> Result<BTreeSet<Observation>, Meaningless> {
        Ok(self.state(term)?.observations())
    }

    /// How long it lets time pass before anything changes by itself.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn max_wait(&self, term: &Term) -> Result<Patience, Meaningless> {
        let state = self.state(term)?;
        let moves = state.moves()?;
        Ok(state.patience(&moves))
    }

    /// The process after this time; none if it does not let that much time pass.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn wait(&self, term: &Term, time: &BigRational) -> Result<Option<Term>, Meaningless> {
        let state = self.state(term)?;
        Ok(self.wait_state(&state, time)?.map(|state| state.term()))
    }

    /// The state after this time; none if it does not let that much time pass.
    ///
    /// # Errors
    /// [`Meaningless`] where what follows has no meaning, or too much happens in this time.
    pub fn wait_state(&self, state: &State, time: &BigRational) -> Result<Option<State>, Meaningless> {
        let mut state = state.clone();
        let mut left = time.clone();
        for _ in 0..MOST_EVENTS {
            if left <= BigRational::zero() {
                return Ok(Some(state));
            }
            let moves = state.moves()?;
            let slice = match state.patience(&moves) {
                Patience::None => return Ok(None),
                Patience::Until(bound) if bound < left => bound,
                _ => left.clone(),
            };
            state = self.pass(&state, &slice)?;
            left -= slice;
        }
        Meaningless::because("too many delays end within this time")
    }

    /// The state after this time, which its patience allows.
    pub(crate) fn pass(&self, state: &State, time: &BigRational) -> Result<State, Meaningless> {
        match state {
            State::Running(term) => self.state(&step::pass(term, time)?),
            ended => Ok(ended.clone()),
        }
    }
}

/// The delays that may end within one call of `wait`.
const MOST_EVENTS: usize = 100_000;

impl State {
    /// Whether it has ended, and how.
    pub fn outcome(&self) -> Outcome {
        match self {
            State::Stopped(results) => Outcome::Stop(results.clone()),
            State::Aborted => Outcome::Abort,
            State::Running(_) => Outcome::Running,
        }
    }

    /// A term that is in this state.
    pub fn term(&self) -> Term {
        match self {
            State::Stopped(results) => settle::carried(results),
            State::Aborted => Term::abort(),
            State::Running(term) => term.clone(),
        }
    }

    /// All that it may do next; while a draw is due, the draw alone.
    ///
    /// # Errors
    /// [`Meaningless`] where a distribution's chances are not numbers that add up to one.
    pub fn moves(&self) -> Result<Vec<Move>, Meaningless> {
        match self {
            State::Running(term) => Ok(draw::draws(term)?.unwrap_or_else(|| step::moves(term))),
            _ => Ok(Vec::new()),
        }
    }

    /// What it shows now.
    pub fn observations(&self) -> BTreeSet<Observation> {
        let mut shown = BTreeSet::new();
        if let State::Running(term) = self {
            step::observe(term, None, &mut shown);
        }
        shown
    }

    /// How long each running delay still takes.
    pub(crate) fn residues(&self) -> Vec<BigRational> {
        let mut all = Vec::new();
        if let State::Running(term) = self {
            step::running(term, &mut |leaf| {
                if let Node::Delay(time) = leaf.node() {
                    all.extend(time.as_rational());
                }
            });
        }
        all
    }

    /// The state with other times left for its running delays, none of them 0.
    ///
    /// # Errors
    /// [`Meaningless`] where a delay is not a number.
    pub(crate) fn with_residues(&self, change: &dyn Fn(&BigRational) -> BigRational) -> Result<State, Meaningless> {
        match self {
            State::Running(term) => Ok(State::Running(step::with_delays(term, &|left| Some(change(left)))?)),
            ended => Ok(ended.clone()),
        }
    }

    /// How long it lets time pass, given its moves.
    pub fn patience(&self, moves: &[Move]) -> Patience {
        let State::Running(term) = self else { return Patience::None };
        if moves.iter().any(|step| matches!(step.action, Action::Tau(..) | Action::Draw(..))) {
            return Patience::None;
        }
        step::next_event(term).map_or(Patience::Unbounded, Patience::Until)
    }
}
