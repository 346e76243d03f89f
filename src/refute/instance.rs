//! Putting a choice into a claim.

use std::collections::{BTreeMap, BTreeSet};

use super::candidates::{Candidate, formal};
use crate::definition::{Definition, Definitions};
use crate::model::Model;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// What the slots are filled with.
#[derive(Clone, Debug, Default)]
pub(super) struct Choice {
    pub(super) processes: BTreeMap<Name, Term>,
    pub(super) values: BTreeMap<Name, Value>,
    pub(super) names: BTreeMap<Name, Name>,
}

impl Choice {
    pub(super) fn put(&mut self, slot: &Name, candidate: &Candidate) {
        match candidate {
            Candidate::Process(term, _) => {
                self.processes.insert(slot.clone(), term.clone());
            }
            Candidate::Value(value, _) => {
                self.values.insert(slot.clone(), value.clone());
            }
            Candidate::Name(name, _) => {
                self.names.insert(slot.clone(), name.clone());
            }
        }
    }

    /// The name that this one stands for.
    pub(super) fn name(&self, name: &Name) -> Name {
        self.names.get(name).unwrap_or(name).clone()
    }

    /// The value with all that is chosen put in.
    pub(super) fn value(&self, value: &Value) -> Option<Value> {
        let names = value.variables();
        if names.is_empty() {
            return Some(value.clone());
        }
        let mut known = BTreeMap::new();
        for name in names {
            if let Some(value) = self.values.get(&name) {
                known.insert(name, value.clone());
            } else if let Some(other) = self.names.get(&name) {
                known.insert(name, Value::variable(other));
            }
        }
        value.substitute(&known).ok()
    }

    /// The term with all that is chosen put in; none where that has no meaning (a division by zero).
    pub(super) fn term(&self, term: &Term) -> Option<Term> {
        if term.depth() > 100 {
            return None;
        }
        let children: Option<Vec<Term>> = term.children().map(|part| self.term(part)).collect();
        let mut children = children?;
        Some(match term.node() {
            Node::Meta(name, arguments) => {
                let body = self.processes.get(name)?;
                let mut known = BTreeMap::new();
                for (place, argument) in arguments.iter().enumerate() {
                    known.insert(formal(place), self.value(argument)?);
                }
                let none = Definitions::default();
                Model::new(&none).put_in(body, &known, 0).ok()?
            }
            Node::In(port, name) => Term::new(Node::In(self.name(port), self.name(name))),
            Node::Out(port, value) => Term::new(Node::Out(self.name(port), self.value(value)?)),
            Node::Set(value, name) => Term::new(Node::Set(self.value(value)?, self.name(name))),
            Node::Ran(value, name) => Term::new(Node::Ran(self.value(value)?, self.name(name))),
            Node::Power(_, count, Some(index)) => {
                Term::new(Node::Power(children.pop()?, self.value(count)?, Some(self.name(index))))
            }
            Node::New(port, _) => Term::new(Node::New(self.name(port), children.pop()?)),
            Node::Replace(_, name, value) => {
                Term::new(Node::Replace(children.pop()?, self.name(name), self.value(value)?))
            }
            _ => term.with_children(children).map_values(&mut |value| self.value(value).ok_or(())).ok()?,
        })
    }

    /// The definitions with the values of the parameters put in.
    pub(super) fn definitions(&self, definitions: &Definitions) -> Definitions {
        let mut closed = Definitions::default();
        let model = Model::new(definitions);
        for definition in definitions.iter() {
            let mut known = self.values.clone();
            known.retain(|name, _| !name.is_meta() && !definition.parameters.contains(name));
            let body = model.put_in(&definition.body, &known, 0).unwrap_or_else(|_| definition.body.clone());
            closed.insert(Definition { body, ..definition.clone() });
        }
        closed
    }
}

/// The names that stand in values of a term.
pub(super) fn read_names(term: &Term) -> BTreeSet<Name> {
    let mut names = BTreeSet::new();
    let mut indices = BTreeSet::new();
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        for value in term.values() {
            names.extend(value.variables());
        }
        if let Node::Power(_, _, Some(index)) = term.node() {
            indices.insert(index.clone());
        }
        open.extend(term.children());
    }
    names.difference(&indices).cloned().collect()
}

/// The values that the surroundings may have bound these names to: as many ways as there are inputs, in which
/// neighbours differ.
pub(super) fn surroundings(read: &BTreeSet<Name>, inputs: &[Value]) -> Vec<BTreeMap<Name, Value>> {
    if read.is_empty() {
        return vec![BTreeMap::new()];
    }
    let way = |first: usize| {
        let values = inputs.iter().cycle().skip(first);
        read.iter().zip(values).map(|(name, value)| (name.clone(), value.clone())).collect()
    };
    (0..inputs.len()).map(way).collect()
}

/// The term in surroundings that have bound these names.
pub(super) fn close(term: &Term, surroundings: &BTreeMap<Name, Value>) -> Term {
    surroundings
        .iter()
        .fold(term.clone(), |term, (name, value)| Term::new(Node::Replace(term, name.clone(), value.clone())))
}
