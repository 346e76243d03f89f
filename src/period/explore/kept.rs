//! By what phases of the same control points are apart, and which values steer nothing: what is counted beside a run, handed on,
//! or only shown. Of which values there are phases of their own, and which are variables, is a choice alone: whichever is made,
//! the phases are right.

use std::collections::BTreeSet;

use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::{calls, subterms};
use crate::term::{Node, Term};
use crate::value::Value;

/// By what phases of the same control points are apart.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// By the delays that remain.
    Delays,
    /// By these and by the values held.
    Values,
    /// By these and by those values held that steer something.
    Steering,
    /// By nothing: what differs between two visits is a variable, also what remains of a delay. Which of them ends first is
    /// then asked in every order, and the phases may ask of their variables what never comes.
    Nothing,
}

impl Kept {
    /// Whether values held are kept apart.
    pub(super) fn values(self) -> bool {
        matches!(self, Kept::Values | Kept::Steering)
    }
}

/// The names that a guard, duration or draw reads, also by what they are handed on as, or a value that may have no meaning.
pub(super) fn steering(components: &[Term], definitions: &Definitions) -> BTreeSet<Name> {
    let (mut terms, mut seen) = (components.to_vec(), BTreeSet::new());
    let mut next = 0;
    while let Some(term) = terms.get(next) {
        let called: Vec<Name> = calls(term).into_iter().filter(|name| seen.insert(name.clone())).collect();
        terms.extend(called.iter().filter_map(|name| Some(definitions.get(name)?.body.clone())));
        next += 1;
    }
    let mut steering: BTreeSet<Name> = BTreeSet::new();
    loop {
        let before = steering.len();
        let read: BTreeSet<Name> = terms.iter().flat_map(|term| reads(term, &steering, definitions)).collect();
        steering.extend(read);
        let ports = terms.iter().flat_map(|term| read_ports(term, &steering)).collect::<BTreeSet<_>>();
        let written = terms.iter().flat_map(|term| written(term, &ports)).collect::<BTreeSet<_>>();
        steering.extend(written);
        if steering.len() == before {
            return steering;
        }
    }
}

/// What steers in a term, and what becomes something that does.
fn reads(term: &Term, steering: &BTreeSet<Name>, definitions: &Definitions) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    let mut take = |value: &Value, steers: bool| {
        if steers || !value.needs().is_empty() {
            found.extend(value.variables());
        }
    };
    for part in subterms(term) {
        match part.node() {
            Node::Delay(value) | Node::Ran(value, _) | Node::Power(_, value, _) => take(value, true),
            Node::Guard(_, left, right) => [left, right].into_iter().for_each(|side| take(side, true)),
            Node::Out(_, value) => take(value, false),
            Node::Set(value, name) | Node::Replace(_, name, value) => take(value, steering.contains(name)),
            Node::Observe(_, values) => values.iter().for_each(|value| take(value, false)),
            Node::Call(name, values) => {
                let parameters = definitions.get(name).map(|definition| definition.parameters.as_slice());
                for (parameter, value) in parameters.unwrap_or_default().iter().zip(values) {
                    take(value, steering.contains(parameter));
                }
            }
            _ => {}
        }
    }
    found
}

/// The ports from which something that steers is read.
fn read_ports(term: &Term, steering: &BTreeSet<Name>) -> Vec<Name> {
    let port = |part: &Term| match part.node() {
        Node::In(port, name) if steering.contains(name) => Some(port.clone()),
        _ => None,
    };
    subterms(term).filter_map(port).collect()
}

/// What is written to these ports.
fn written(term: &Term, ports: &BTreeSet<Name>) -> BTreeSet<Name> {
    let names = |part: &Term| match part.node() {
        Node::Out(port, value) if ports.contains(port) => value.variables(),
        _ => BTreeSet::new(),
    };
    subterms(term).flat_map(names).collect()
}
