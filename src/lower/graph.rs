//! Who calls whom: loops round several definitions, and the ports that are used on the way.

use std::collections::{BTreeMap, BTreeSet, HashMap};

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
        rest.extend(term.children().map(|child| (child, private.clone())));
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
    let names: Vec<&Name> = edges.keys().collect();
    let numbers: HashMap<&Name, usize> = names.iter().enumerate().map(|(number, name)| (*name, number)).collect();
    let known = |next: &BTreeSet<Name>| next.iter().filter_map(|name| numbers.get(name).copied()).collect();
    let edges: Vec<Vec<usize>> = edges.values().map(known).collect();
    let places = vec![Place::default(); names.len()];
    let (open, on, closed) = (Vec::new(), BTreeMap::new(), Vec::new());
    let mut search = Search { names, edges, places, entered: 0, open, on, closed };
    for start in 0..search.names.len() {
        search.visit(start);
    }
    search
}

/// What is known of a name in the search.
#[derive(Clone, Copy, Default)]
struct Place {
    /// When it was entered, from 0.
    order: Option<usize>,
    /// The earliest that it leads back to.
    low: usize,
    /// Whether its component is not finished.
    open: bool,
}

/// Tarjan's search for strongly connected components, without recursion; names go by their number.
struct Search<'g> {
    names: Vec<&'g Name>,
    edges: Vec<Vec<usize>>,
    places: Vec<Place>,
    entered: usize,
    open: Vec<usize>,
    on: BTreeMap<Name, usize>,
    closed: Vec<Name>,
}

impl Search<'_> {
    fn visit(&mut self, start: usize) {
        if self.places[start].order.is_some() {
            return;
        }
        // Each name on the way, with how many of those that it leads to are still to be looked at.
        let mut path = vec![(start, self.enter(start))];
        while let Some((name, rest)) = path.pop() {
            if let Some(rest) = rest.checked_sub(1) {
                path.push((name, rest));
                let next = self.edges[name][rest];
                match self.places[next] {
                    Place { order: None, .. } => path.push((next, self.enter(next))),
                    Place { order: Some(order), open: true, .. } => self.lower(name, order),
                    _ => {}
                }
                continue;
            }
            let Place { order, low, .. } = self.places[name];
            if let Some((parent, _)) = path.last() {
                self.lower(*parent, low);
            }
            if order == Some(low) {
                self.close(name, low);
            }
        }
    }

    fn enter(&mut self, name: usize) -> usize {
        self.places[name] = Place { order: Some(self.entered), low: self.entered, open: true };
        self.entered += 1;
        self.open.push(name);
        self.edges[name].len()
    }

    fn lower(&mut self, name: usize, to: usize) {
        self.places[name].low = self.places[name].low.min(to);
    }

    /// Takes a finished component off; it is a cycle if it has several names or one that calls itself.
    fn close(&mut self, root: usize, number: usize) {
        let mut component = Vec::new();
        while let Some(name) = self.open.pop() {
            self.places[name].open = false;
            component.push(name);
            if name == root {
                break;
            }
        }
        self.closed.extend(component.iter().map(|name| self.names[*name].clone()));
        if component.len() > 1 || self.edges[root].contains(&root) {
            self.on.extend(component.into_iter().map(|name| (self.names[name].clone(), number)));
        }
    }
}
