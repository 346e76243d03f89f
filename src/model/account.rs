//! What happened while a term was settled: for people who ask why something is not there.

use std::cell::RefCell;

use super::Model;
use crate::definition::Definitions;
use crate::term::Term;
use crate::value::{Relation, Value};

/// Something that settling a term decided.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A guard compared these values, and whether it held.
    Guard(Relation, Value, Value, bool),
    /// The first part of a sequence aborted, so what follows never starts.
    Skipped {
        /// What aborted.
        aborted: Term,
        /// What never starts.
        rest: Vec<Term>,
    },
    /// Parts of `#` ended, and the others with them.
    Killed {
        /// The parts that ended; whether each stopped.
        ended: Vec<(Term, bool)>,
        /// The parts that were still running.
        killed: Vec<Term>,
    },
    /// The first arm of `else` stopped, so the second never starts.
    NotNeeded(Term),
    /// A round of this loop aborted, so the loop stopped.
    Left(Term),
}

/// The events so far, if they are kept.
pub(super) type Account = RefCell<Option<Vec<Event>>>;

impl<'a> Model<'a> {
    /// The same meaning, with an account of what settling decides.
    pub fn recording(definitions: &'a Definitions) -> Model<'a> {
        let model = Model::new(definitions);
        model.account.replace(Some(Vec::new()));
        model
    }

    /// The events since this was last asked, in order; empty where none are kept.
    pub fn events(&self) -> Vec<Event> {
        self.account.borrow_mut().as_mut().map(std::mem::take).unwrap_or_default()
    }

    pub(super) fn note(&self, event: impl FnOnce() -> Event) {
        if let Some(events) = self.account.borrow_mut().as_mut() {
            events.push(event());
        }
    }
}
