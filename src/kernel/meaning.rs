//! That what stands in a proof has a value: an equation says nothing where one of its sides has none, so nothing may be
//! chained through a term that has no value where the claim has one.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::{Reason, Theory};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::proof::{Statement, Step};
use crate::scope::{condition_parts, read_names, subterms};
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::{Need, Value};

/// Calls of the claim, and of what they call, that are looked into.
const MOST_CALLS: usize = 400;
/// The bits and the nodes of the arguments of a call that is looked into: they may grow from call to call.
const LONGEST: u64 = 2_000;
const LARGEST: usize = 100;

/// What the values of a proof need to have a meaning: it must follow from the assumptions, or be needed by the claim
/// itself, which says nothing where it fails.
pub(super) struct Meaning<'a> {
    claim: (&'a Statement, &'a Theory),
    /// The names that the definitions read.
    defined: &'a BTreeSet<Name>,
    /// The names that the claim, the definitions and the assumptions read but as indices of rounds.
    outside: OnceCell<BTreeSet<Name>>,
    /// What the claim needs, what is taken on trust, or a process that they call.
    claimed: BTreeSet<Need>,
    /// Indices of rounds that the claim counts: an exponent may read them in what is said of one round.
    indices: BTreeSet<Name>,
    /// What was needed on the way, and does not follow from the assumptions.
    met: BTreeSet<Need>,
    /// What was asked before, and whether it follows from the assumptions.
    known: HashMap<Need, Option<bool>>,
    /// Terms that were looked at, with the indices around them.
    looked: HashSet<(Term, Vec<Name>)>,
}

impl<'a> Meaning<'a> {
    /// What the claim of a proof needs; the names that definitions read, and whether some value in one needs anything.
    pub(super) fn of(
        statement: &'a Statement,
        steps: &[Step],
        theory: &'a Theory,
        (defined, partial): (&'a BTreeSet<Name>, bool),
    ) -> Meaning<'a> {
        let mut claimed: BTreeSet<Need> = theory.assumptions.iter().flat_map(|(_, value)| value.needs()).collect();
        let mut open = vec![statement.left.clone(), statement.right.clone()];
        for hypothesis in &statement.hypotheses {
            let (terms, values, _) = condition_parts(hypothesis);
            open.extend(terms.into_iter().cloned());
            claimed.extend(values.into_iter().flat_map(Value::needs));
        }
        for step in steps {
            // What is taken on trust is trusted to have a meaning.
            if let Step::Trust(left, _, right, _) = step {
                open.extend([left.clone(), right.clone()]);
            }
        }
        let mut called: BTreeSet<Term> = BTreeSet::new();
        let mut indices: BTreeSet<Name> = BTreeSet::new();
        while let Some(term) = open.pop() {
            for part in subterms(&term) {
                if let Node::Power(_, _, Some(index)) = part.node() {
                    indices.insert(index.clone());
                }
                claimed.extend(part.values().flat_map(Value::needs));
                let Node::Call(name, arguments) = part.node() else { continue };
                let Some(definition) = theory.definitions.get(name).filter(|_| partial) else { continue };
                // What is not looked into is not needed by the claim: fewer needs are tolerated, not more.
                if arguments.iter().any(|argument| argument.bits() > LONGEST || argument.size() > LARGEST) {
                    continue;
                }
                if called.len() < MOST_CALLS && called.insert(part.clone()) {
                    let parameters = definition.parameters.iter().cloned();
                    let map: BTreeMap<Name, Value> = parameters.zip(arguments.iter().cloned()).collect();
                    open.extend(subterms(&definition.body).filter_map(|part| image(part, &map, &mut claimed)));
                }
            }
        }
        Meaning {
            claim: (statement, theory),
            defined,
            outside: OnceCell::new(),
            claimed,
            indices,
            met: BTreeSet::new(),
            known: HashMap::new(),
            looked: HashSet::new(),
        }
    }

    /// What was needed, and does not follow from the assumptions.
    pub(super) fn met(&self) -> &BTreeSet<Need> {
        &self.met
    }

    /// What an instance of the claim needs. That an index of rounds is a natural number was needed of what is said of one
    /// round; it says nothing of a claim, and of a definition, that reads the index in its rounds alone: there it is one.
    pub(super) fn needed_by(&self) -> BTreeSet<Need> {
        if self.met.is_empty() {
            return BTreeSet::new();
        }
        let kept = |need: &&Need| match need {
            Need::Natural(value) => !value.variables().is_disjoint(self.outside()),
            _ => true,
        };
        self.met.iter().filter(kept).cloned().collect()
    }

    /// All values of a term have a meaning wherever those of the claim have. An index is a natural number within its
    /// rounds.
    pub(super) fn look(&mut self, term: &Term, known: &Assumptions) -> Result<(), Reason> {
        let mut open = vec![(term.clone(), Vec::new())];
        while let Some((part, indices)) = open.pop() {
            if !self.looked.insert((part.clone(), indices.clone())) {
                continue;
            }
            for need in part.values().flat_map(Value::needs) {
                if !follows_within(&need, &indices, known) {
                    self.require(need, known)?;
                }
            }
            let mut inside = indices;
            if let Node::Power(_, _, Some(index)) = part.node() {
                inside.push(index.clone());
            }
            open.extend(part.portions().map(|child| (child, inside.clone())));
        }
        Ok(())
    }

    /// Values that are put in for metavariables have a meaning too; processes that are stand in what comes of it.
    pub(super) fn put_in(&mut self, substitution: &Substitution, known: &Assumptions) -> Result<(), Reason> {
        let mut needs = substitution.values.values().flat_map(Value::needs);
        needs.try_for_each(|need| self.require(need, known))
    }

    /// What was needed before is needed of the instance as well.
    pub(super) fn instance(
        &mut self,
        before: &BTreeSet<Need>,
        values: &BTreeMap<Name, Value>,
        known: &Assumptions,
    ) -> Result<(), Reason> {
        before.iter().try_for_each(|need| match need.substitute(values) {
            Ok(need) => self.require(need, known),
            Err(_) => Err(Reason::Undefined(Box::new(need.clone()))),
        })
    }

    pub(super) fn require(&mut self, need: Need, known: &Assumptions) -> Result<(), Reason> {
        let granted = *self.known.entry(need.clone()).or_insert_with(|| known.grants(&need));
        match granted {
            Some(true) => Ok(()),
            None if self.tolerates(&need, known) => {
                self.met.insert(need);
                Ok(())
            }
            None if self.has_value_in_rounds(&need, known) => Ok(()),
            _ => Err(Reason::Undefined(Box::new(need))),
        }
    }

    /// Whether the claim needs it as well. It does not make an exponent a natural number, unless it counts by it.
    fn tolerates(&self, need: &Need, known: &Assumptions) -> bool {
        match need {
            Need::Natural(value) => {
                let counts: Vec<Name> = value.variables().intersection(&self.indices).cloned().collect();
                follows_within(need, &counts, known)
            }
            _ => need.follows_from(&self.claimed),
        }
    }

    /// Whether it follows where what the claim does not read is natural, as `1/(3*i-17)` has a value then; that is needed.
    fn has_value_in_rounds(&mut self, need: &Need, known: &Assumptions) -> bool {
        let indices = self.counted_alone(need);
        let follows = !matches!(need, Need::Natural(_)) && follows_within(need, &indices, known);
        if follows {
            self.met.extend(indices.iter().map(|index| Need::Natural(Value::variable(index))));
        }
        follows
    }

    /// The names in a need that the claim does not read but as indices of rounds, if at all: whatever is said of one round
    /// on the way, they are natural numbers in it.
    fn counted_alone(&self, need: &Need) -> Vec<Name> {
        need.value().variables().difference(self.outside()).cloned().collect()
    }

    fn is_counted(&self, name: &Name) -> bool {
        self.indices.contains(name) || !self.outside().contains(name)
    }

    /// The names that the claim, the definitions and the assumptions read but as indices of rounds.
    pub(super) fn outside(&self) -> &BTreeSet<Name> {
        let (statement, theory) = self.claim;
        self.outside.get_or_init(|| read_outside_of_rounds(statement, theory, self.defined))
    }

    /// The names that are read as indices of rounds: nothing else may bind them.
    pub(super) fn counted(&self) -> impl Iterator<Item = Name> + '_ {
        let exponents = self.met.iter().filter(|need| matches!(need, Need::Natural(_)));
        exponents.flat_map(|need| need.value().variables()).filter(|name| self.is_counted(name))
    }

    /// In the claim itself such a name is an index.
    pub(super) fn closed(&self, term: &Term, known: &Assumptions) -> Result<(), Reason> {
        let mut open = vec![(term, Vec::new())];
        while let Some((part, mut indices)) = open.pop() {
            let exponents = part.values().flat_map(Value::needs);
            for need in exponents.filter(|need| matches!(need, Need::Natural(_))) {
                if !follows_within(&need, &indices, known) && known.grants(&need) != Some(true) {
                    return Err(Reason::Undefined(Box::new(need)));
                }
            }
            if let Node::Power(_, _, Some(index)) = part.node() {
                indices.push(index.clone());
            }
            open.extend(part.children().map(|child| (child, indices.clone())));
        }
        Ok(())
    }
}

/// The names that a claim reads but as indices of the rounds around them, with those that the definitions and the
/// assumptions read.
fn read_outside_of_rounds(statement: &Statement, theory: &Theory, defined: &BTreeSet<Name>) -> BTreeSet<Name> {
    let mut outside: BTreeSet<Name> = defined.clone();
    for hypothesis in &statement.hypotheses {
        let (terms, values, names) = condition_parts(hypothesis);
        outside.extend(terms.into_iter().flat_map(read_names));
        outside.extend(values.into_iter().flat_map(Value::variables).chain(names.into_iter().cloned()));
    }
    outside.extend(theory.assumptions.iter().flat_map(|(_, value)| value.variables()));
    let mut open = vec![(&statement.left, BTreeSet::new()), (&statement.right, BTreeSet::new())];
    while let Some((term, indices)) = open.pop() {
        let read = term.values().flat_map(Value::variables);
        outside.extend(read.filter(|name| !indices.contains(name)));
        let mut inside = indices;
        if let Node::Power(_, _, Some(index)) = term.node() {
            inside.insert(index.clone());
        }
        open.extend(term.children().map(|child| (child, inside.clone())));
    }
    outside
}

/// Whether a need follows where these are natural numbers.
fn follows_within(need: &Need, indices: &[Name], known: &Assumptions) -> bool {
    let mut inside: Option<Assumptions> = None;
    for index in indices.iter().filter(|index| need.value().mentions(index)) {
        inside.get_or_insert_with(|| known.clone()).assume_natural(index);
    }
    inside.is_some_and(|inside| inside.grants(need) == Some(true))
}

/// An operator of a process that is called, as far as it calls others; what its values need is added.
fn image(part: &Term, map: &BTreeMap<Name, Value>, claimed: &mut BTreeSet<Need>) -> Option<Term> {
    let needs = part.values().flat_map(Value::needs);
    claimed.extend(needs.filter_map(|need| need.substitute(map).ok()));
    let Node::Call(..) = part.node() else { return None };
    part.map_values(&mut |value| value.substitute(map)).ok()
}
