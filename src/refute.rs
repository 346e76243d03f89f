//! Counterexamples: small closed instances of an open claim, in growing order, tried on the model.
//!
//! Every metavariable gets processes, values, ports or names from a fixed list in which simpler ones cost less; the
//! instances are tried by total cost, so the counterexample is the simplest there is in the list. Conditions are
//! evaluated on the model too, by exploring the instance, never from facts about terms. The order and the amount of
//! work depend on the claim and the limits alone.

mod candidates;
mod conditions;
mod instance;
mod slots;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::bisimulation::{Comparison, Reach, Run, compare, replay};
use crate::definition::Definitions;
use crate::law::{Condition, Connective, Law};
use crate::model::explore::{Bounds, Graph};
use crate::name::Name;
use crate::term::Term;
use crate::value::{Relation, Value};

use candidates::Candidate;
use instance::Choice;
use slots::{Matter, Slot, Vocabulary, slots_of, with_assumed};

/// How hard to try.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The most instances compared.
    pub instances: usize,
    /// The most choices made on the way, with those that fail a condition.
    pub choices: usize,
    /// The largest total cost.
    pub cost: usize,
    /// The most pairs of states in one comparison.
    pub pairs: usize,
    /// More numbers for values and parameters than the usual ones and those near what the claim mentions.
    pub numbers: Vec<BigRational>,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { instances: 20_000, choices: 1_000_000, cost: 12, pairs: 1_000, numbers: Vec::new() }
    }
}

/// A closed instance on which the two sides differ.
#[derive(Clone, Debug)]
pub struct Counterexample {
    /// What the process metavariables stand for; those with parameters in terms of `$0`, `$1`, ….
    pub processes: BTreeMap<Name, Term>,
    /// What the value metavariables and the parameters stand for.
    pub values: BTreeMap<Name, Value>,
    /// What the metavariables for ports and results stand for.
    pub names: BTreeMap<Name, Name>,
    /// The values of the names that the instance reads from its surroundings.
    pub surroundings: BTreeMap<Name, Value>,
    /// The left side of the instance, closed.
    pub left: Term,
    /// The right side, closed.
    pub right: Term,
    /// The definitions that the instance refers to, closed.
    pub definitions: Definitions,
    /// A shortest run that separates the sides.
    pub run: Run,
}

/// What came of an attempt to refute.
#[derive(Clone, Debug)]
pub enum Refutation {
    /// The claim is false.
    Refuted(Box<Counterexample>),
    /// No counterexample among the instances tried.
    None {
        /// All instances up to this cost were tried.
        cost: usize,
        /// The instances compared.
        instances: usize,
        /// Of these, those that have no meaning (a loop in no time, a result bound twice, …).
        meaningless: usize,
        /// Of these, those that the bound on states left open.
        open: usize,
        /// Whether the limits ended the search before the largest cost was reached.
        cut: bool,
    },
}

impl Refutation {
    /// The counterexample, if there is one.
    pub fn counterexample(&self) -> Option<&Counterexample> {
        match self {
            Refutation::Refuted(found) => Some(found),
            Refutation::None { .. } => None,
        }
    }
}

/// Looks for a counterexample to a law.
pub fn judge(law: &Law, limits: &Limits) -> Refutation {
    let (definitions, assumptions) = (Definitions::default(), Assumptions::default());
    refute(&law.left, &law.right, law.connective, &law.conditions, &definitions, &assumptions, limits)
}

/// Looks for a counterexample to a claim under conditions and assumptions.
pub fn refute(
    left: &Term,
    right: &Term,
    connective: Connective,
    conditions: &[Condition],
    definitions: &Definitions,
    assumptions: &Assumptions,
    limits: &Limits,
) -> Refutation {
    let slots = with_assumed(slots_of(left, right, conditions, definitions), assumptions);
    let mut search = Search::new(left, right, connective, conditions, definitions, assumptions, limits, slots);
    for cost in search.slots.len()..=limits.cost.max(search.slots.len()) {
        search.extend(&mut Vec::new(), cost);
        if let Some(found) = search.found {
            return Refutation::Refuted(Box::new(found));
        }
        if search.cut {
            break;
        }
        search.cost = cost;
        if search.slots.is_empty() {
            break;
        }
    }
    Refutation::None {
        cost: search.cost,
        instances: search.instances,
        meaningless: search.meaningless,
        open: search.open,
        cut: search.cut,
    }
}

/// A requirement on an instance, with the slots that it depends on.
struct Requirement<'a> {
    what: What<'a>,
    slots: Vec<usize>,
}

enum What<'a> {
    Condition(&'a Condition),
    Assumption(Relation, Value),
    Natural(Value),
}

struct Search<'a> {
    left: &'a Term,
    right: &'a Term,
    connective: Connective,
    definitions: &'a Definitions,
    limits: &'a Limits,
    reach: Reach,
    slots: Vec<Slot>,
    candidates: Vec<Vec<Candidate>>,
    /// By the last slot that each depends on.
    requirements: Vec<Vec<Requirement<'a>>>,
    known: HashMap<(usize, usize, Vec<usize>), bool>,
    open_definitions: bool,
    choices: usize,
    instances: usize,
    meaningless: usize,
    open: usize,
    cost: usize,
    cut: bool,
    found: Option<Counterexample>,
}

impl<'a> Search<'a> {
    #[allow(clippy::too_many_arguments)]
    fn new(
        left: &'a Term,
        right: &'a Term,
        connective: Connective,
        conditions: &'a [Condition],
        definitions: &'a Definitions,
        assumptions: &Assumptions,
        limits: &'a Limits,
        slots: Vec<Slot>,
    ) -> Search<'a> {
        let whats = conditions.iter().map(What::Condition);
        let whats = whats.chain(assumptions.iter().map(|(relation, value)| What::Assumption(relation, value)));
        let whats = whats.chain(assumptions.naturals().iter().map(|name| What::Natural(Value::variable(name))));
        // With nothing to choose there is still one place for the conditions.
        let mut requirements: Vec<Vec<Requirement>> = (0..slots.len().max(1)).map(|_| Vec::new()).collect();
        for what in whats {
            let names = match &what {
                What::Condition(condition) => slots::names_in(condition),
                What::Assumption(_, value) | What::Natural(value) => value.variables(),
            };
            let depends: Vec<usize> = (0..slots.len()).filter(|place| names.contains(slots[*place].name())).collect();
            // An assumption on what does not occur says nothing of the instance.
            if depends.is_empty() && !matches!(what, What::Condition(_)) {
                continue;
            }
            // A condition on nothing that varies is checked with the first slot.
            let last = depends.last().copied().unwrap_or(0);
            if let Some(list) = requirements.get_mut(last) {
                list.push(Requirement { what, slots: depends });
            }
        }
        let mut vocabulary = Vocabulary::of(&Matter { sides: [left, right], conditions, definitions, assumptions });
        vocabulary.also(&limits.numbers);
        let reach = Reach { pairs: limits.pairs, inputs: vocabulary.inputs.clone() };
        let candidates = slots.iter().map(|slot| candidates::candidates(slot, &vocabulary)).collect();
        let open_definitions = slots.iter().any(|slot| matches!(slot, Slot::Parameter(_)));
        Search {
            left,
            right,
            connective,
            definitions,
            limits,
            reach,
            slots,
            candidates,
            requirements,
            known: HashMap::new(),
            open_definitions,
            choices: 0,
            instances: 0,
            meaningless: 0,
            open: 0,
            cost: 0,
            cut: false,
            found: None,
        }
    }

    /// Tries all ways to fill the remaining slots at exactly this total cost.
    fn extend(&mut self, chosen: &mut Vec<usize>, cost: usize) {
        if self.cut || self.found.is_some() {
            return;
        }
        let place = chosen.len();
        if place == self.slots.len() {
            if self.slots.is_empty() && !self.admissible(0, chosen) {
                return;
            }
            if cost == 0 || self.slots.is_empty() {
                self.attempt(chosen);
            }
            return;
        }
        let after = self.slots.len() - place - 1;
        for pick in 0..self.candidates[place].len() {
            let price = self.candidates[place][pick].cost();
            if price + after > cost || (after == 0 && price != cost) {
                continue;
            }
            self.choices += 1;
            if self.choices > self.limits.choices {
                self.cut = true;
                return;
            }
            chosen.push(pick);
            if self.admissible(place, chosen) {
                self.extend(chosen, cost - price);
            }
            chosen.pop();
        }
    }

    fn choice(&self, chosen: &[usize]) -> Choice {
        let mut choice = Choice::default();
        for (slot, (list, pick)) in self.slots.iter().zip(self.candidates.iter().zip(chosen)) {
            choice.put(slot.name(), &list[*pick]);
        }
        choice
    }

    /// Whether the requirements that this slot completes hold.
    fn admissible(&mut self, place: usize, chosen: &[usize]) -> bool {
        for number in 0..self.requirements[place].len() {
            let requirement = &self.requirements[place][number];
            let picks = requirement.slots.iter().map(|slot| chosen[*slot]).collect();
            let key = (place, number, picks);
            let holds = match self.known.get(&key) {
                Some(holds) => *holds,
                None => {
                    let holds = self.holds(&self.choice(chosen), &requirement.what);
                    self.known.insert(key, holds);
                    holds
                }
            };
            if !holds {
                return false;
            }
        }
        true
    }

    fn holds(&self, choice: &Choice, what: &What) -> bool {
        match what {
            What::Condition(condition) => conditions::holds(condition, choice, self.definitions, &self.reach.inputs),
            What::Natural(value) => {
                conditions::holds(&Condition::Natural(value.clone()), choice, self.definitions, &self.reach.inputs)
            }
            What::Assumption(relation, value) => choice
                .value(value)
                .and_then(|value| value.as_rational())
                .is_some_and(|value| conditions::ordered(*relation, &value, &Zero::zero())),
        }
    }

    /// Whether no state that the term is seen to reach lacks a meaning.
    fn has_meaning(&self, term: &Term, definitions: &Definitions) -> bool {
        let bounds = Bounds { states: self.limits.pairs, inputs: self.reach.inputs.clone() };
        Graph::of(term, definitions, &bounds).is_ok()
    }

    fn attempt(&mut self, chosen: &[usize]) {
        self.instances += 1;
        if self.instances > self.limits.instances {
            self.instances -= 1;
            self.cut = true;
            return;
        }
        let choice = self.choice(chosen);
        let (Some(left), Some(right)) = (choice.term(self.left), choice.term(self.right)) else {
            self.meaningless += 1;
            return;
        };
        let definitions =
            if self.open_definitions { choice.definitions(self.definitions) } else { self.definitions.clone() };
        let mut read: BTreeSet<Name> = instance::read_names(&left);
        read.extend(instance::read_names(&right));
        for surroundings in instance::surroundings(&read, &self.reach.inputs) {
            let (left, right) = (instance::close(&left, &surroundings), instance::close(&right, &surroundings));
            match compare(&left, &right, self.connective, &definitions, &self.reach) {
                Ok(Comparison::Same) => {}
                Ok(Comparison::Unknown(_)) => self.open += 1,
                Err(_) => {
                    self.meaningless += 1;
                    return;
                }
                Ok(Comparison::Different(run)) => {
                    if !self.has_meaning(&left, &definitions) || !self.has_meaning(&right, &definitions) {
                        self.meaningless += 1;
                        return;
                    }
                    let again = replay(&left, &right, self.connective, &definitions, &self.reach, &run);
                    if again != Ok(true) {
                        self.open += 1;
                        continue;
                    }
                    let Choice { processes, values, names } = choice;
                    self.found =
                        Some(Counterexample { processes, values, names, surroundings, left, right, definitions, run });
                    return;
                }
            }
        }
    }
}
