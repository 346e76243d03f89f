//! The values that a process may read from outside, and when a few of them stand for all.
//!
//! A process that only copies what it reads, and compares it with `Eq` and `Neq` alone, behaves alike under every
//! renaming of the values that it does not mention. Two such processes that hold at most `r` foreign values together
//! are told apart by some reading, if at all, among the values they mention and `r + 1` others: what is read next is a
//! value they mention, one of those they hold, or a new one, and all new ones are alike.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::cut::Cuts;
use super::generate::Process;
use crate::definition::Definitions;
use crate::model::State;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::number::around;
use crate::value::{Relation, Value, View};

/// The values that may be read.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// All of them.
    pub values: Vec<Value>,
    /// Those that the processes do not mention.
    pub foreign: BTreeSet<Value>,
    /// Whether the processes only copy what they read and compare it with `Eq` and `Neq`.
    pub symmetric: bool,
    /// Whether each delay is written as a number.
    pub fixed_delays: bool,
    /// Where the values of continuous draws are cut into cells; none where they are symbols.
    pub(crate) cuts: Option<Cuts>,
}

impl Inputs {
    /// The values that these terms mention, and this many others.
    pub fn of(terms: &[&Term], definitions: &Definitions, others: usize) -> Inputs {
        let mut found =
            Walk { mentioned: BTreeSet::new(), numbers: BTreeSet::new(), symmetric: true, fixed_delays: true };
        let mut called = BTreeSet::new();
        let mut open: Vec<&Term> = terms.to_vec();
        while let Some(term) = open.pop() {
            found.visit(term);
            if let Node::Call(name, _) = term.node()
                && let Some(definition) = definitions.get(name)
                && called.insert(name.clone())
            {
                open.push(&definition.body);
            }
            open.extend(term.children());
        }
        // Not enough for all values, but enough to meet many differences.
        found.mentioned.extend(around(&found.numbers).into_iter().map(Value::rational));
        let mut foreign = BTreeSet::new();
        let mut number = 0;
        while foreign.len() < others {
            let value = Value::integer(number);
            if !found.mentioned.contains(&value) {
                foreign.insert(value);
            }
            number += 1;
        }
        let values = found.mentioned.iter().chain(&foreign).cloned().collect();
        Inputs { values, foreign, symmetric: found.symmetric, fixed_delays: found.fixed_delays, cuts: None }
    }

    /// How many foreign values a state holds.
    pub fn held(&self, state: &State) -> usize {
        let mut held = BTreeSet::new();
        let mut note = |value: &Value| {
            if self.foreign.contains(value) {
                held.insert(value.clone());
            }
        };
        match state {
            State::Stopped(results) => results.values().for_each(&mut note),
            State::Aborted => {}
            State::Running(term) => {
                let mut open = vec![term];
                while let Some(term) = open.pop() {
                    term.values().for_each(&mut note);
                    open.extend(term.children());
                }
            }
        }
        held.len()
    }

    /// Whether these values stand for all that the two processes could read, given their states.
    pub fn suffice(&self, processes: &[Process; 2], states: [&[State]; 2]) -> bool {
        if !processes.iter().any(Process::reads) {
            return true;
        }
        let most = |states: &[State]| states.iter().map(|state| self.held(state)).max().unwrap_or(0);
        self.symmetric && most(states[0]) + most(states[1]) < self.foreign.len()
    }
}

struct Walk {
    mentioned: BTreeSet<Value>,
    /// Those at which what is computed, or compared by size, may change its way.
    numbers: BTreeSet<BigRational>,
    symmetric: bool,
    fixed_delays: bool,
}

impl Walk {
    /// Notes a value that is copied or compared.
    fn plain(&mut self, value: &Value) {
        let names = value.variables();
        match names.first() {
            None => {
                self.mentioned.insert(value.clone());
            }
            Some(name) if names.len() == 1 && *value == Value::variable(&Name::new(name.as_str())) => {}
            Some(_) => {
                self.symmetric = false;
                self.numbers.extend(value.numbers());
            }
        }
    }

    /// Notes the values that a draw may come to, of which there are finitely many.
    fn outcomes(&mut self, distribution: &Value) {
        let mut open = vec![distribution.clone()];
        while let Some(value) = open.pop() {
            match value.view() {
                View::Distribution(kind, parts) if kind == "Mix" => {
                    open.extend(parts.chunks(2).filter_map(|pair| pair.get(1)).cloned());
                }
                View::Distribution(kind, parts) if kind == "Point" => parts.iter().for_each(|value| self.plain(value)),
                _ => {}
            }
        }
    }

    fn visit(&mut self, term: &Term) {
        match term.node() {
            Node::Guard(relation, left, right) => {
                self.plain(left);
                self.plain(right);
                let closed = left.variables().is_empty() && right.variables().is_empty();
                let alike = matches!(relation, Relation::Eq | Relation::Neq);
                self.symmetric &= closed || alike;
                let plain = |value: &Value| value.variables().is_empty() || value.as_variable().is_some();
                if !(closed || plain(left) && plain(right)) {
                    self.numbers.extend(left.sub(right).map(|difference| difference.numbers()).unwrap_or_default());
                }
                if !closed && !alike {
                    self.numbers.extend([left, right].into_iter().filter_map(Value::as_rational));
                }
            }
            // A time or a count that is read is more than copied.
            Node::Delay(value) => {
                self.symmetric &= value.variables().is_empty();
                self.fixed_delays &= value.as_rational().is_some();
            }
            Node::Ran(value, _) => {
                self.symmetric &= value.variables().is_empty();
                self.outcomes(value);
            }
            Node::Power(_, value, index) => self.symmetric &= value.variables().is_empty() && index.is_none(),
            _ => term.values().for_each(|value| self.plain(value)),
        }
    }
}
