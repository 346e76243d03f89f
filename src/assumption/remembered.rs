//! What was already found of a value under the same assumptions, so that it is found once: the prover asks what the
//! kernel asks after it.
//!
//! Nothing but what was found for equal assumptions, the same question and an equal value is given again, and the
//! search is a function of these alone: an answer does not depend on what is remembered.

use std::cell::RefCell;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};

use super::Assumptions;
use super::refute::MOST_SYSTEMS;
use super::sign::Signs;
use crate::value::Value;

/// How many sets of assumptions are remembered with what was found under them.
const MOST_SETS: usize = 512;
/// How many answers are remembered under one set.
const MOST_ANSWERS: usize = 1_000;

#[derive(Default)]
struct Answers {
    signs: HashMap<(Signs, Value), Signs>,
    simple: HashMap<Value, Value>,
}

thread_local! {
    static KNOWN: RefCell<HashMap<Assumptions, Answers>> = RefCell::new(HashMap::new());
}

impl Hash for Assumptions {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // All else is derived from these, or tells the cases of one question apart.
        self.stated.hash(state);
        self.naturals.hash(state);
    }
}

impl Assumptions {
    /// The signs that the value may have; the search stops when they are all `wanted` or none is.
    pub(super) fn possible_signs(&self, value: &Value, wanted: Signs) -> Signs {
        let decided = |signs: &Signs| signs.within(wanted) || signs.and(wanted).is_empty();
        let one_term = value.polynomials().is_some_and(|(numerator, _)| numerator.terms().len() == 1);
        if let Some(signs) = one_term.then(|| self.quick(value)).filter(|signs| !signs.is_empty() && decided(signs)) {
            return signs;
        }
        let question = (wanted, value.clone());
        let known =
            KNOWN.with_borrow(|known| known.get(self).and_then(|answers| answers.signs.get(&question).copied()));
        if let Some(signs) = known {
            return signs;
        }
        if let Some(signs) = self.signs_alone(value, wanted) {
            return signs;
        }
        if let Some(signs) = self.signs_enclosed(value).filter(decided) {
            return signs;
        }
        let (within, all) = self.signs_in_pieces(&self.with_solved(value)).unwrap_or((Signs::ANY, false));
        if all || decided(&within) {
            self.remember(question, within);
            return within;
        }
        if self.seen_either_way(value, wanted) {
            self.remember(question, within);
            return within;
        }
        let mut systems = MOST_SYSTEMS;
        let signs = self.signs_of_value(value, wanted, 3, &mut systems).and(within);
        if systems < MOST_SYSTEMS {
            self.remember(question, signs);
        }
        signs
    }

    /// Keeps what took a search.
    fn remember(&self, question: (Signs, Value), signs: Signs) {
        self.answers(|answers| {
            if answers.signs.len() >= MOST_ANSWERS {
                answers.signs.clear();
            }
            answers.signs.insert(question, signs);
        });
    }

    /// A value as `find` simplifies it, which is asked once.
    pub(super) fn simplified_once(&self, value: &Value, find: impl FnOnce() -> Value) -> Value {
        let known = KNOWN.with_borrow(|known| known.get(self).and_then(|answers| answers.simple.get(value).cloned()));
        if let Some(simple) = known {
            return simple;
        }
        let simple = find();
        self.answers(|answers| {
            if answers.simple.len() >= MOST_ANSWERS {
                answers.simple.clear();
            }
            answers.simple.insert(value.clone(), simple.clone());
        });
        simple
    }

    /// What is remembered under these assumptions; when there are too many sets of them, all is forgotten.
    fn answers(&self, keep: impl FnOnce(&mut Answers)) {
        KNOWN.with_borrow_mut(|known| {
            if !known.contains_key(self) && known.len() >= MOST_SETS {
                known.clear();
            }
            keep(known.entry(self.clone()).or_default());
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;
    use crate::value::Relation;

    fn positive(known: &Assumptions, value: &Value) -> Option<bool> {
        known.decide(Relation::Gtr, value, &Value::zero())
    }

    #[test]
    fn what_was_found_is_not_taken_for_other_assumptions() {
        let (x, y) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("y")));
        let difference = x.mul(&x).unwrap().sub(&y).unwrap();
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &x, &Value::integer(2));
        for _ in 0..2 {
            assert_eq!(positive(&known, &difference), None);
        }
        let mut more = known.clone();
        more.assume(Relation::Lte, &y, &Value::integer(3));
        for _ in 0..2 {
            assert_eq!(positive(&more, &difference), Some(true));
            assert_eq!(positive(&known, &difference), None);
        }
    }

    #[test]
    fn no_more_than_so_much_is_kept() {
        let (x, y) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("y")));
        for bound in 0..200 {
            let mut known = Assumptions::default();
            known.assume(Relation::Gtr, &x, &Value::integer(bound));
            known.assume(Relation::Gtr, &y, &x);
            assert_eq!(positive(&known, &y.sub(&Value::integer(bound)).unwrap()), Some(true));
        }
        assert!(KNOWN.with_borrow(|known| !known.is_empty() && known.len() <= MOST_SETS));
    }
}
