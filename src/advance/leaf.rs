//! What runs in a settled term: its leaves, each with the `new` that binds its port and with what `to` leaves shown.

use std::collections::BTreeSet;
use std::ops::Range;

use crate::name::Name;
use crate::term::{Node, Sequence, Term};

/// Whether this draws at once.
pub(super) fn is_drawing(leaf: &Term) -> bool {
    matches!(leaf.node(), Node::Ran(..))
}

pub(super) fn is_set(term: &Term) -> bool {
    matches!(term.node(), Node::Set(..))
}

/// Where the running part of a settled sequence stands, if one runs.
pub(super) fn active(parts: &[Term]) -> Option<usize> {
    parts.iter().position(|part| !is_set(part))
}

/// A read, write, delay, observer or draw that runs in a settled term.
pub(super) struct Leaf<'t> {
    pub(super) term: &'t Term,
    /// Which `new` of the term binds the port of a read or write, by their numbers in order.
    pub(super) binder: Option<usize>,
    /// Whether no `to` around it hides what it shows.
    pub(super) shown: bool,
    /// How many parts of which sequences around it have begun.
    begun: Vec<(&'t Sequence, usize)>,
}

impl Leaf<'_> {
    /// What follows in the sequences around it.
    pub(super) fn followed_by(&self) -> impl Iterator<Item = Term> {
        self.begun.iter().map(|(parts, begun)| parts.after(*begun))
    }
}

/// The reads, writes, delays, observers and draws that run in a settled term, in order.
pub(super) fn leaves(term: &Term) -> Vec<Leaf<'_>> {
    let mut walk = Leaves::default();
    walk.through(term);
    walk.found
}

/// A walk through a settled term: what was found, and the `new` and `to` around the place where it is.
#[derive(Default)]
struct Leaves<'t> {
    found: Vec<Leaf<'t>>,
    bound: Vec<(&'t Name, usize)>,
    binders: usize,
    shows: Vec<&'t BTreeSet<Name>>,
    begun: Vec<(&'t Sequence, usize)>,
}

/// Which `new` binds a port behind all these.
fn binder(bound: &[(&Name, usize)], port: &Name) -> Option<usize> {
    bound.iter().rev().find(|(name, _)| *name == port).map(|(_, number)| *number)
}

impl<'t> Leaves<'t> {
    /// Goes on inside a `new` or a `to`.
    fn inside(&mut self, around: &'t Term, go: impl FnOnce(&mut Self)) {
        match around.node() {
            Node::New(port, _) => {
                self.bound.push((port, self.binders));
                self.binders += 1;
                go(self);
                self.bound.pop();
            }
            Node::Project(_, shown) => {
                self.shows.push(shown);
                go(self);
                self.shows.pop();
            }
            _ => go(self),
        }
    }

    /// Goes through the parts that run side by side, each with its ports and those of them that are its own, and
    /// through what follows when some of them have ended.
    fn side_by_side(&mut self, term: &'t Term, found: &mut Components<'t>) {
        let first = self.found.len();
        match term.node() {
            Node::Par(parts) => parts.iter().for_each(|part| self.side_by_side(part, found)),
            Node::New(_, body) | Node::Project(body, _) => self.inside(term, |walk| walk.side_by_side(body, found)),
            Node::Seq(parts) => {
                if let Some(place) = active(parts) {
                    self.begun.push((parts, place + 1));
                    self.side_by_side(&parts[place], found);
                    self.begun.pop();
                    self.follows(parts.after(place + 1), first, found);
                }
            }
            Node::Else(running, other) => {
                self.side_by_side(running, found);
                self.follows(other.clone(), first, found);
            }
            _ => {
                self.through(term);
                let inside = first..self.found.len();
                let offers = |leaf: &&Leaf<'_>| matches!(leaf.term.node(), Node::In(..) | Node::Out(..));
                let offers = self.found[inside.clone()].iter().filter(offers).count();
                found.running.push(Component { term: term.clone(), inside, offers, bound: self.bound.clone() });
            }
        }
    }

    /// Notes what follows when all has ended that was found from this leaf on.
    fn follows(&self, term: Term, first: usize, found: &mut Components<'t>) {
        let inside = first..self.found.len();
        found.later.push(Component { term, inside, offers: 0, bound: self.bound.clone() });
    }

    fn find(&mut self, term: &'t Term, binder: Option<usize>, shown: bool) {
        self.found.push(Leaf { term, binder, shown, begun: self.begun.clone() });
    }

    fn through(&mut self, term: &'t Term) {
        match term.node() {
            Node::Seq(parts) => {
                if let Some(place) = active(parts) {
                    self.begun.push((parts, place + 1));
                    self.through(&parts[place]);
                    self.begun.pop();
                }
            }
            Node::Else(first, _) => self.through(first),
            Node::Par(parts) | Node::Disable(parts) => parts.iter().for_each(|part| self.through(part)),
            Node::New(_, body) | Node::Project(body, _) => self.inside(term, |walk| walk.through(body)),
            Node::In(port, _) | Node::Out(port, _) => {
                self.find(term, binder(&self.bound, port), true);
            }
            Node::Observe(name, _) => {
                let shown = self.shows.iter().all(|shown| shown.contains(name));
                self.find(term, None, shown);
            }
            Node::Delay(_) | Node::Idle | Node::Ran(..) => self.find(term, None, true),
            _ => {}
        }
    }
}

/// A settled term with some of its leaves, numbered as [`leaves`] gives them, replaced.
pub(super) fn rebuilt(term: &Term, number: &mut usize, change: &mut dyn FnMut(usize, &Term) -> Option<Term>) -> Term {
    changed(term, number, change).unwrap_or_else(|| term.clone())
}

/// The same; nothing where no leaf is replaced.
fn changed(term: &Term, number: &mut usize, change: &mut dyn FnMut(usize, &Term) -> Option<Term>) -> Option<Term> {
    match term.node() {
        Node::Seq(parts) => {
            let place = active(parts)?;
            let part = changed(&parts[place], number, change)?;
            if place == 0 && *part.node() == Node::Stop {
                return Some(parts.after(1));
            }
            let mut parts = parts.to_vec();
            parts[place] = part;
            Some(Term::seq(parts))
        }
        Node::Else(first, second) => Some(Term::otherwise(changed(first, number, change)?, second.clone())),
        Node::Par(parts) | Node::Disable(parts) => {
            let mut new: Option<Vec<Term>> = None;
            for (place, part) in parts.iter().enumerate() {
                if let Some(part) = changed(part, number, change) {
                    new.get_or_insert_with(|| parts.clone())[place] = part;
                }
            }
            new.map(|parts| term.with_children(parts))
        }
        Node::New(_, body) | Node::Project(body, _) => Some(term.with_children(vec![changed(body, number, change)?])),
        Node::In(..) | Node::Out(..) | Node::Delay(_) | Node::Observe(..) | Node::Idle | Node::Ran(..) => {
            let here = *number;
            *number += 1;
            change(here, term)
        }
        _ => None,
    }
}

/// A part of a settled network.
pub(super) struct Component<'t> {
    pub(super) term: Term,
    /// The numbers of its leaves, or of those behind which it follows.
    pub(super) inside: Range<usize>,
    /// How many of its leaves are reads and writes.
    pub(super) offers: usize,
    bound: Vec<(&'t Name, usize)>,
}

impl Component<'_> {
    /// Which `new` binds the port of this name here.
    pub(super) fn binder(&self, port: &Name) -> Option<usize> {
        binder(&self.bound, port)
    }
}

/// The parts of a settled network of which none ends or hinders another.
#[derive(Default)]
pub(super) struct Components<'t> {
    /// Those that run, around which there is nothing but `|`, `new`, `to`, what follows and what is there instead.
    pub(super) running: Vec<Component<'t>>,
    /// What follows when others have ended.
    pub(super) later: Vec<Component<'t>>,
}

/// The components of a settled network, in the order of their leaves.
pub(super) fn components(state: &Term) -> Components<'_> {
    let (mut walk, mut found) = (Leaves::default(), Components::default());
    walk.side_by_side(state, &mut found);
    found
}
