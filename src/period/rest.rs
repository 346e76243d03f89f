//! What is still to come in a sequence: shared tails, each with the names that it reads.
//!
//! A tail stands for its parts: equal tails are one, whatever sequence they end, so that control points compare by a
//! number and a step along a sequence copies nothing.

use std::collections::BTreeSet;
use std::rc::Rc;

use super::env::Env;
use super::passed_on::PassedOn;
use crate::digest::Quick;
use crate::name::Name;
use crate::term::{Node, Term, TermMap};

/// The parts to come.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Rest(usize);

/// No parts to come.
pub(crate) const NOTHING: Rest = Rest(0);

struct Tail {
    first: Term,
    next: Rest,
    reads: Rc<BTreeSet<Name>>,
}

/// All tails met so far.
#[derive(Default)]
pub(crate) struct Tails {
    tails: Vec<Tail>,
    known: Quick<(Term, Rest), Rest>,
    sequences: TermMap<Rest>,
    nothing: Rc<BTreeSet<Name>>,
    passed_on: PassedOn,
}

impl Tails {
    /// With room for so many sequences and parts, of processes that pass this on.
    pub(super) fn with_capacity(sequences: usize, parts: usize, passed_on: PassedOn) -> Tails {
        Tails {
            tails: Vec::with_capacity(parts),
            known: Quick::with_capacity_and_hasher(parts, Default::default()),
            sequences: TermMap::with_capacity_and_hasher(sequences, Default::default()),
            nothing: Rc::default(),
            passed_on,
        }
    }

    /// The parts of a sequence; any other process is the only part of its own.
    pub(crate) fn of(&mut self, term: &Term) -> Rest {
        let Node::Seq(parts) = term.node() else { return self.before(term, NOTHING) };
        if let Some(known) = self.sequences.get(term) {
            return *known;
        }
        let mut rest = NOTHING;
        for part in parts.iter().rev() {
            rest = self.before(part, rest);
        }
        self.sequences.insert(term.clone(), rest);
        rest
    }

    fn before(&mut self, first: &Term, next: Rest) -> Rest {
        let key = (first.clone(), next);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let own = self.passed_on.needed(first);
        let later = self.reads(next);
        // What a read, a `Set` or a call is about to write is not wanted from before.
        let mut rewritten = self.passed_on.written(first);
        rewritten.retain(|name| later.contains(name) && !own.contains(name));
        let reads = if rewritten.is_empty() && own.iter().all(|name| later.contains(name)) {
            later
        } else {
            let later = later.iter().filter(|name| !rewritten.contains(*name)).cloned();
            Rc::new(own.into_iter().chain(later).collect())
        };
        self.tails.push(Tail { first: first.clone(), next, reads });
        let rest = Rest(self.tails.len());
        self.known.insert(key, rest);
        rest
    }

    fn tail(&self, rest: Rest) -> Option<&Tail> {
        rest.0.checked_sub(1).and_then(|place| self.tails.get(place))
    }

    /// The first part and the others; none when nothing is to come.
    pub(crate) fn split(&self, rest: Rest) -> Option<(Term, Rest)> {
        self.tail(rest).map(|tail| (tail.first.clone(), tail.next))
    }

    /// The parts of all sequences met so far.
    pub(super) fn terms(&self) -> impl Iterator<Item = &Term> {
        self.tails.iter().map(|tail| &tail.first)
    }

    /// The names whose values the parts need from before.
    pub(crate) fn reads(&self, rest: Rest) -> Rc<BTreeSet<Name>> {
        self.tail(rest).map_or_else(|| self.nothing.clone(), |tail| tail.reads.clone())
    }

    /// The names that a process may bind, itself and by what it calls.
    pub(super) fn may_bind(&self, term: &Term) -> BTreeSet<Name> {
        self.passed_on.may(term)
    }

    /// The values without those of the names that a read, a `Set` or a call is about to bind.
    pub(super) fn without_written(&self, part: &Term, env: Env) -> Env {
        let written = self.passed_on.written(part);
        if !written.iter().any(|name| env.contains_key(name)) {
            return env;
        }
        env.iter()
            .filter(|(name, _)| !written.contains(*name))
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect()
    }

    /// The parts in order.
    pub(crate) fn parts(&self, rest: Rest) -> Vec<Term> {
        let mut parts = Vec::new();
        let mut rest = rest;
        while let Some((first, next)) = self.split(rest) {
            parts.push(first);
            rest = next;
        }
        parts
    }
}
