//! Properties that name a defined process: each instance of it then shows its name and parameters while it runs.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Entity, Environment};
use crate::definition::{Definition, Definitions};
use crate::name::Name;
use crate::scope::{calls, subterms};
use crate::term::{Node, Term};
use crate::value::{Sort, Value};

impl Environment {
    /// Makes the processes that a property names show that they run. Where one of them has a form of which it cannot be
    /// said when it runs, all is left as it is.
    pub fn show_named(&mut self, property: &Name) {
        let Some(Entity::Property(found)) = self.entity(property) else { return };
        let Some(body) = found.body.clone() else { return };
        let mut named = BTreeSet::new();
        let body = with_observers(&body, property, &self.definitions, &mut named);
        if !self.show_instances(&named) {
            return;
        }
        if let Some(Entity::Property(found)) = Arc::make_mut(&mut self.entities).get_mut(property) {
            found.body = Some(body);
        }
    }

    /// Makes instances of the processes of these names show that they run; false, and all is left as it is, where there is
    /// none, or one of them has a form of which it cannot be said when it runs.
    pub fn show_instances(&mut self, names: &BTreeSet<Name>) -> bool {
        let named: Vec<&Definition> = names.iter().filter_map(|name| self.definitions.get(name)).collect();
        let shown: Option<Vec<Definition>> = named.into_iter().map(|one| shown(one, &self.definitions)).collect();
        let Some(shown) = shown.filter(|shown| !shown.is_empty()) else { return false };
        shown.into_iter().for_each(|definition| self.definitions.insert(definition));
        true
    }

    /// Whether it can be said when an instance of a process runs.
    pub(super) fn can_show(&self, name: &Name) -> bool {
        self.definitions.get(name).is_some_and(|one| shown(one, &self.definitions).is_some())
    }

    /// By place, how many components the vectors have that an observer, or an instance of a process, shows in a system, or
    /// in any: none where it shows numbers, or now one thing and now another.
    pub(super) fn lengths(&self, name: &Name, system: Option<&Name>) -> Vec<Option<usize>> {
        let mut found: Option<Vec<Option<usize>>> = None;
        let systems = self.entities.iter().filter_map(|(name, entity)| match entity {
            Entity::System(found) if system.is_none_or(|system| system == name) => Some(&found.components),
            _ => None,
        });
        let components: Vec<&Term> = systems.flatten().collect();
        let mut called: BTreeSet<Name> = components.iter().flat_map(|term| calls(term)).collect();
        let mut work: Vec<Name> = called.iter().cloned().collect();
        while let Some(name) = work.pop() {
            let more = self.definitions.get(&name).map(|definition| calls(&definition.body)).unwrap_or_default();
            work.extend(more.into_iter().filter(|name| called.insert(name.clone())));
        }
        let reached = |one: &&Definition| system.is_none() || called.contains(&one.name);
        let bodies = self.definitions.iter().filter(reached).map(|one| &one.body);
        for term in bodies.chain(components.iter().copied()).flat_map(subterms) {
            let (Node::Observe(other, values) | Node::Call(other, values)) = term.node() else { continue };
            if other != name {
                continue;
            }
            let length = |value: &Value| match value.sort() {
                Sort::Vector(length) => Some(length),
                _ => None,
            };
            let here: Vec<Option<usize>> = values.iter().map(length).collect();
            match &mut found {
                None => found = Some(here),
                Some(all) => {
                    all.iter_mut().zip(here).filter(|(one, other)| *one != other).for_each(|(one, _)| *one = None)
                }
            }
        }
        found.unwrap_or_default()
    }
}

/// A property with an observer for each call of a process, and the processes called. The calls stand in sequence, and
/// beside delays.
fn with_observers(term: &Term, own: &Name, definitions: &Definitions, named: &mut BTreeSet<Name>) -> Term {
    match term.node() {
        Node::Call(name, values) if name != own && definitions.get(name).is_some() => {
            named.insert(name.clone());
            Term::new(Node::Observe(name.clone(), values.clone()))
        }
        Node::Seq(parts) => Term::seq(parts.iter().map(|part| with_observers(part, own, definitions, named))),
        Node::Disable(parts) => Term::disable(parts.iter().map(|part| with_observers(part, own, definitions, named))),
        Node::Par(parts) => Term::par(parts.iter().map(|part| with_observers(part, own, definitions, named))),
        Node::Loop(body) => Term::new(Node::Loop(with_observers(body, own, definitions, named))),
        _ => term.clone(),
    }
}

/// A definition whose instances show that they run: `T_u = (P_u # T_u) ; T_{f(u)}` with the observer of that name, or
/// `P_u # T_u` where it calls no loop that it is in.
fn shown(definition: &Definition, definitions: &Definitions) -> Option<Definition> {
    let parameters = definition.parameters.iter().map(Value::variable).collect();
    let observer = Term::new(Node::Observe(definition.name.clone(), parameters));
    let body = if !definition.recursive {
        Term::disable([definition.body.clone(), observer])
    } else {
        let Node::Seq(parts) = definition.body.node() else { return None };
        let (last, front) = parts.split_last()?;
        let Node::Call(next, _) = last.node() else { return None };
        let looped = definitions.get(next).is_some_and(|next| next.recursive);
        let elsewhere = front.iter().any(|part| reaches(part, &definition.name, definitions));
        if !looped || elsewhere {
            return None;
        }
        Term::seq([Term::disable([Term::seq(front.iter().cloned()), observer]), last.clone()])
    };
    Some(Definition { body, ..definition.clone() })
}

/// Whether a process may call one of this name.
fn reaches(term: &Term, name: &Name, definitions: &Definitions) -> bool {
    let mut seen: BTreeSet<Name> = BTreeSet::new();
    let mut stack: Vec<Name> = crate::scope::calls(term).into_iter().collect();
    while let Some(next) = stack.pop() {
        if next == *name {
            return true;
        }
        if seen.insert(next.clone())
            && let Some(definition) = definitions.get(&next)
        {
            stack.extend(crate::scope::calls(&definition.body));
        }
    }
    false
}
