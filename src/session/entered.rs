//! What holds in a phase wherever it is entered: delays that run have time left, copies that are to come are counted, and
//! what stands in it has a value.

use std::collections::BTreeSet;

use crate::law::Condition;
use crate::name::Name;
use crate::period::{Phase, Test, open_name};
use crate::scope::{bound_names, subterms};
use crate::term::{Node, Term};
use crate::value::{Need, Relation, Value};

/// What is left of the delays that run in a state, where that is no number.
pub(super) fn delays(state: &[Term]) -> impl Iterator<Item = &Value> {
    let (mut open, mut found): (Vec<&Term>, Vec<&Value>) = (state.iter().collect(), Vec::new());
    while let Some(term) = open.pop() {
        match term.node() {
            Node::Delay(left) if left.as_rational().is_none() => found.push(left),
            Node::Seq(_) | Node::Else(..) => open.extend(term.children().next()),
            Node::Par(_) | Node::Disable(_) | Node::New(..) | Node::Project(..) => open.extend(term.children()),
            _ => {}
        }
    }
    found.into_iter()
}

/// The numbers of copies that are to come in a state, where they are variables.
pub(super) fn counts(state: &[Term]) -> impl Iterator<Item = &Value> {
    state.iter().flat_map(subterms).filter_map(|term| match term.node() {
        Node::Power(_, count, _) if count.variables().iter().any(Name::is_meta) => Some(count),
        _ => None,
    })
}

/// A guard: a comparison.
pub(super) type Guard = (Relation, Value, Value);

/// What the values of a state need that read nothing but its variables and parameters, with the guards that stand before
/// each.
pub(super) fn needs(state: &[Term]) -> Vec<(Need, Vec<Guard>)> {
    let bound: BTreeSet<Name> = state.iter().flat_map(bound_names).collect();
    let (mut found, mut open) = (Vec::new(), Vec::new());
    open.extend(state.iter().map(|term| (term.clone(), Vec::new())));
    while let Some((term, guards)) = open.pop() {
        let own = term.values().flat_map(Value::needs);
        let plain = own.filter(|need| need.value().variables().is_disjoint(&bound));
        found.extend(plain.map(|need| (need, guards.clone())));
        let mut before: Vec<Guard> = guards;
        for child in term.children() {
            open.push((child.clone(), before.clone()));
            if let (Node::Seq(_), Node::Guard(relation, left, right)) = (term.node(), child.node())
                && left.variables().union(&right.variables()).all(|name| !bound.contains(name))
            {
                before.push((*relation, left.clone(), right.clone()));
            }
        }
    }
    let mut seen = BTreeSet::new();
    found.retain(|one| seen.insert(one.clone()));
    found
}

/// That a need is met, as a condition.
pub(super) fn met(need: &Need) -> Condition {
    let relation = match need {
        Need::Nonzero(_) => Relation::Neq,
        Need::Nonnegative(_) => Relation::Gte,
        Need::Natural(value) => return Condition::Natural(value.clone()),
    };
    Condition::Compare(relation, need.value().clone(), Value::zero())
}

/// What is known of the variables of a phase, each under the name that it has in its state.
pub(super) fn bounds(phase: &Phase) -> impl Iterator<Item = Test> {
    let open = phase.variables.iter().map(|name| (name.clone(), Value::variable(&open_name(name)))).collect();
    phase.bounds.iter().filter_map(move |test| test.substitute(&open).ok())
}

pub(super) fn more_than_none(left: &Value) -> Condition {
    Condition::Compare(Relation::Gtr, left.clone(), Value::zero())
}
