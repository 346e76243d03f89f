//! Who calls whom: loops round several definitions, and the ports that are used on the way.

use std::collections::{BTreeMap, BTreeSet};

use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term};

/// The names that a term calls.
pub(super) fn callees(term: &Term) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    let mut rest = vec![term];
    while let Some(term) = rest.pop() {
        if let Node::Call(name, _) = term.node() {
            found.insert(name.clone());
        }
        rest.extend(term.children());
    }
    found
}

/// The ports that a term uses and does not keep private, through all definitions.
pub(super) fn ports(term: &Term, definitions: &Definitions) -> BTreeSet<Name> {
    let mut found = BTreeSet::new();
    let mut called = BTreeSet::new();
    let mut rest: Vec<(&Term, BTreeSet<Name>)> = vec![(term, BTreeSet::new())];
    while let Some((term, private)) = rest.pop() {
        match term.node() {
            Node::In(port, _) | Node::Out(port, _) if !private.contains(port) => {
                found.insert(port.clone());
            }
            Node::New(port, body) => {
                let mut private = private;
                private.insert(port.clone());
                rest.push((body, private));
                continue;
            }
            // A call means its body in its place, so what is private here is private there.
            Node::Call(name, _) if called.insert((name.clone(), private.clone())) => {
                rest.extend(definitions.get(name).map(|definition| (&definition.body, private.clone())));
            }
            _ => {}
        }
        rest.extend(term.children().into_iter().map(|child| (child, private.clone())));
    }
    found
}

/// The names that stand on a cycle of the graph, each with a number that those of the same cycle share.
pub(super) fn cycles(edges: &BTreeMap<Name, BTreeSet<Name>>) -> BTreeMap<Name, usize> {
    search(edges).on
}

/// The names of the graph, each after those it leads to, as far as cycles allow.
pub(super) fn callees_first(edges: &BTreeMap<Name, BTreeSet<Name>>) -> Vec<Name> {
    search(edges).closed
}

fn search(edges: &BTreeMap<Name, BTreeSet<Name>>) -> Search<'_> {
    let (order, low) = (BTreeMap::new(), BTreeMap::new());
    let mut search = Search { edges, order, low, open: Vec::new(), on: BTreeMap::new(), closed: Vec::new() };
    for name in edges.keys() {
        search.visit(name);
    }
    search
}

/// Tarjan's search for strongly connected components, without recursion.
struct Search<'g> {
    edges: &'g BTreeMap<Name, BTreeSet<Name>>,
    order: BTreeMap<&'g Name, usize>,
    low: BTreeMap<&'g Name, usize>,
    open: Vec<&'g Name>,
    on: BTreeMap<Name, usize>,
    closed: Vec<Name>,
}

impl<'g> Search<'g> {
    fn visit(&mut self, start: &'g Name) {
        if self.order.contains_key(start) {
            return;
        }
        let mut path = vec![(start, self.enter(start))];
        let mut opened: BTreeSet<&Name> = BTreeSet::from([start]);
        while let Some((name, mut rest)) = path.pop() {
            if let Some(next) = rest.pop() {
                path.push((name, rest));
                if !self.order.contains_key(next) {
                    opened.insert(next);
                    path.push((next, self.enter(next)));
                } else if opened.contains(next) {
                    self.lower(name, self.order.get(next).copied().unwrap_or(0));
                }
                continue;
            }
            let low = self.low.get(name).copied().unwrap_or(0);
            if let Some((parent, _)) = path.last() {
                let parent = *parent;
                self.lower(parent, low);
            }
            if self.order.get(name) == Some(&low) {
                self.close(name, low, &mut opened);
            }
        }
    }

    fn enter(&mut self, name: &'g Name) -> Vec<&'g Name> {
        let number = self.order.len();
        self.order.insert(name, number);
        self.low.insert(name, number);
        self.open.push(name);
        self.edges.get_key_value(name).map_or(Vec::new(), |(_, next)| {
            next.iter().filter_map(|next| self.edges.get_key_value(next).map(|(next, _)| next)).collect()
        })
    }

    fn lower(&mut self, name: &'g Name, to: usize) {
        if let Some(low) = self.low.get_mut(name) {
            *low = (*low).min(to);
        }
    }

    /// Takes a finished component off; it is a cycle if it has several names or one that calls itself.
    fn close(&mut self, root: &'g Name, number: usize, opened: &mut BTreeSet<&'g Name>) {
        let mut component = Vec::new();
        while let Some(name) = self.open.pop() {
            opened.remove(name);
            component.push(name);
            if name == root {
                break;
            }
        }
        self.closed.extend(component.iter().map(|name| (*name).clone()));
        let itself = self.edges.get(root).is_some_and(|next| next.contains(root));
        if component.len() > 1 || itself {
            self.on.extend(component.into_iter().map(|name| (name.clone(), number)));
        }
    }
}
