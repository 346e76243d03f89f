//! The facts of a composition from those of its parts, one function an operator.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::rc::Rc;

use super::{Context, Facts, NameSet};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// A sequence of more parts than this is gone through from its end.
const LONG: usize = 16;

impl Facts {
    /// What never stops hands on nothing that it binds.
    pub(super) fn binding_where_it_stops(mut self) -> Facts {
        if !self.may_stop {
            self.binds = NameSet::default();
        }
        self
    }

    fn never_ends(&self) -> bool {
        !self.may_stop && !self.may_abort
    }

    /// What holds of parts together whatever the operator: what any of them may do.
    fn extend(&mut self, other: &Facts) {
        self.communicates |= other.communicates;
        self.draws |= other.draws;
        self.early |= other.early;
        self.ports.extend(&other.ports);
        self.binds.extend(&other.binds);
        self.show(other);
    }

    fn show(&mut self, other: &Facts) {
        match (&mut self.shows, &other.shows) {
            (Some(mine), Some(others)) => mine.extend(others.iter().cloned()),
            (mine, _) => *mine = None,
        }
    }

    fn joined(parts: &[Rc<Facts>]) -> Facts {
        let mut all = Facts::default();
        for part in parts {
            all.extend(part);
            all.reads.extend(&part.reads);
        }
        all
    }

    /// The facts of a long sequence, and of all that is left of it behind its first parts: a run comes to each of these.
    /// Nothing of what is no long sequence.
    pub(super) fn of_long(term: &Term, context: &Context<'_>) -> Option<Rc<Facts>> {
        let Node::Seq(parts) = term.node() else { return None };
        if parts.len() <= LONG {
            return None;
        }
        let last = parts.len() - 1;
        // Of what only begins otherwise than something before all that follows is known.
        let found = (1..last).find_map(|place| {
            let known = context.known.borrow().get(&parts.after(place)).cloned();
            known.map(|known| (place, known))
        });
        let (from, mut behind) = found.unwrap_or_else(|| (last, Facts::of(&parts.after(last), context)));
        for place in (0..from).rev() {
            let facts = Facts::clone(&Facts::of(&parts[place], context)).then(&behind);
            behind = Rc::new(facts.binding_where_it_stops());
            context.known.borrow_mut().insert(parts.after(place), Rc::clone(&behind));
        }
        Some(behind)
    }

    /// The facts of a network with ports of its own, from those of what they stand around: many are taken off at once.
    pub(super) fn of_closed(term: &Term, context: &Context<'_>) -> Option<Rc<Facts>> {
        let (mut own, mut body) = (Vec::new(), term);
        while let Node::New(port, inner) = body.node() {
            own.push(port);
            body = inner;
        }
        if own.is_empty() {
            return None;
        }
        let mut facts = Facts::clone(&Facts::of(body, context));
        own.into_iter().for_each(|port| _ = facts.ports.names.remove(port));
        Some(Rc::new(facts.binding_where_it_stops()))
    }

    pub(super) fn then(mut self, next: &Facts) -> Facts {
        (self.guard, self.observer) = (false, false);
        if !self.may_stop {
            return self;
        }
        let early = self.early || (self.instant_stop && next.early);
        self.extend(next);
        self.early = early;
        let unbound = next.reads.names.iter().filter(|name| !self.surely_binds.contains(*name));
        self.reads.names.extend(unbound.cloned());
        self.reads.processes.extend(next.reads.processes.iter().cloned());
        self.may_abort |= next.may_abort;
        self.may_stop = next.may_stop;
        self.starts_running |= self.starts_stopped && next.starts_running;
        self.starts_aborted |= self.starts_stopped && next.starts_aborted;
        self.starts_stopped &= next.starts_stopped;
        self.instant_abort |= self.instant_stop && next.instant_abort;
        self.instant_stop &= next.instant_stop;
        self.surely_binds.extend(next.surely_binds.iter().cloned());
        self.duration = match (&self.duration, &next.duration) {
            (Some(first), Some(second)) => first.add(second).ok(),
            _ => None,
        };
        self
    }

    pub(super) fn otherwise(mut self, second: &Facts) -> Facts {
        (self.guard, self.observer) = (false, false);
        if !self.may_abort {
            return self;
        }
        if self.may_stop || !self.starts_aborted || self.starts_running {
            self.duration = None;
        } else {
            self.duration = second.duration.clone();
        }
        // Where only one of them stops, what that one binds is bound.
        match (self.may_stop, second.may_stop) {
            (true, true) => self.surely_binds.retain(|name| second.surely_binds.contains(name)),
            (true, false) => {}
            (false, _) => self.surely_binds.clone_from(&second.surely_binds),
        }
        self.extend(second);
        self.reads.extend(&second.reads);
        self.may_stop |= second.may_stop;
        self.may_abort = second.may_abort;
        self.starts_running |= self.starts_aborted && second.starts_running;
        self.starts_stopped |= self.starts_aborted && second.starts_stopped;
        self.starts_aborted &= second.starts_aborted;
        self.instant_stop |= self.instant_abort && second.instant_stop;
        self.instant_abort &= second.instant_abort;
        self
    }

    pub(super) fn attempt(self) -> Facts {
        self.otherwise(&Facts::ended(true, false, Some(Value::integer(0))))
    }

    pub(super) fn parallel(parts: &[Rc<Facts>]) -> Facts {
        let mut all = Facts::joined(parts);
        let endless = parts.iter().any(|part| part.never_ends());
        all.may_stop = !endless && parts.iter().any(|part| part.may_stop);
        all.may_abort = !endless && parts.iter().all(|part| part.may_abort);
        all.starts_running = parts.iter().any(|part| part.starts_running);
        let ended = |part: &Facts| part.starts_stopped || part.starts_aborted;
        all.starts_stopped = parts.iter().all(|part| ended(part)) && parts.iter().any(|part| part.starts_stopped);
        all.starts_aborted = parts.iter().all(|part| part.starts_aborted);
        let instant = |part: &Facts| part.instant_stop || part.instant_abort;
        all.instant_stop = parts.iter().all(|part| instant(part)) && parts.iter().any(|part| part.instant_stop);
        all.instant_abort = parts.iter().all(|part| part.instant_abort);
        all.observer = parts.iter().all(|part| part.observer);
        all.surely_binds = Facts::bound_by_all(parts.iter());
        for part in parts.iter().filter(|part| !part.may_abort) {
            all.surely_binds.extend(part.surely_binds.iter().cloned());
        }
        all.duration = Facts::durations(parts, |times| Value::maximum(times).ok(), false);
        all
    }

    pub(super) fn disabling(parts: &[Rc<Facts>]) -> Facts {
        let mut all = Facts::joined(parts);
        let stopped = parts.iter().any(|part| !part.starts_running && !part.starts_aborted);
        let ended = parts.iter().any(|part| !part.starts_running);
        all.early &= !ended;
        all.may_stop = parts.iter().any(|part| part.may_stop);
        all.may_abort = !stopped && parts.iter().any(|part| part.may_abort);
        all.starts_running = parts.iter().all(|part| part.starts_running);
        all.starts_stopped = parts.iter().any(|part| part.starts_stopped);
        all.starts_aborted = !stopped && parts.iter().any(|part| part.starts_aborted);
        all.instant_stop = parts.iter().any(|part| part.instant_stop);
        all.instant_abort = !stopped && parts.iter().any(|part| part.instant_abort);
        all.observer = parts.iter().all(|part| part.observer);
        all.surely_binds = Facts::bound_by_all(parts.iter().filter(|part| part.may_stop));
        all.duration = Facts::durations(parts, |times| Value::minimum(times).ok(), true);
        all
    }

    fn bound_by_all<'f>(mut parts: impl Iterator<Item = &'f Rc<Facts>>) -> BTreeSet<Name> {
        let mut common = parts.next().map(|part| part.surely_binds.clone()).unwrap_or_default();
        for part in parts {
            common.retain(|name| part.surely_binds.contains(name));
        }
        common
    }

    fn durations(
        parts: &[Rc<Facts>],
        combine: impl Fn(&[Value]) -> Option<Value>,
        beside_observers: bool,
    ) -> Option<Value> {
        let mut times = Vec::new();
        for part in parts {
            match &part.duration {
                Some(time) => times.push(time.clone()),
                None if beside_observers && part.observer => {}
                None => return None,
            }
        }
        if times.is_empty() { None } else { combine(&times) }
    }

    pub(super) fn power(body: Facts, count: &Value, index: &Option<Name>, context: &Context<'_>) -> Facts {
        let zero = Value::integer(0);
        let never_none = context.assumptions.decide(Relation::Gtr, count, &zero) == Some(true);
        let duration = match (&body.duration, index) {
            (Some(time), Some(index)) if time.mentions(index) => None,
            (Some(time), _) if context.assumptions.is_natural(count) == Some(true) => time.mul(count).ok(),
            _ => None,
        };
        let mut facts = Facts { guard: false, observer: false, duration, ..body };
        if !never_none {
            facts.surely_binds.clear();
            (facts.may_stop, facts.starts_stopped, facts.instant_stop) = (true, true, true);
        }
        facts
    }

    pub(super) fn repeated(body: Facts) -> Facts {
        Facts {
            may_stop: body.may_abort,
            may_abort: false,
            starts_running: body.starts_running || body.starts_stopped,
            starts_stopped: body.starts_aborted,
            starts_aborted: false,
            instant_stop: body.instant_abort,
            instant_abort: false,
            surely_binds: BTreeSet::new(),
            duration: None,
            guard: false,
            observer: false,
            ..body
        }
    }
}

/// Whether of these branches one does not abort, whatever the values: guards stand before some that compare the same
/// values in ways of which one holds, and nothing behind these guards aborts.
pub(super) fn one_goes_on(branches: &[Term], context: &Context<'_>) -> bool {
    let mut compared: Vec<((&Value, &Value), [bool; 3])> = Vec::new();
    for branch in branches {
        let (first, rest) = match branch.node() {
            Node::Seq(parts) => match parts.split_first() {
                Some((first, rest)) => (first, rest),
                None => continue,
            },
            _ => (branch, &[][..]),
        };
        let Node::Guard(relation, left, right) = first.node() else { continue };
        if rest.iter().any(|part| Facts::of(part, context).may_abort) {
            continue;
        }
        let place = compared.iter().position(|(values, _)| *values == (left, right)).unwrap_or_else(|| {
            compared.push(((left, right), [false; 3]));
            compared.len() - 1
        });
        for (holds, order) in compared[place].1.iter_mut().zip([Ordering::Less, Ordering::Equal, Ordering::Greater]) {
            *holds |= relation.holds(order);
        }
    }
    compared.iter().any(|(_, holds)| holds.iter().all(|holds| *holds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assumption::Assumptions;
    use crate::definition::Definitions;
    use crate::term::Term;

    /// Parts of every kind that a fold may tell apart: that bind, read, end at once, abort, never end, show, last.
    fn part(number: usize) -> Term {
        let name = |text: &str| Name::new(text);
        let (x, y) = (Value::variable(&name("x")), Value::variable(&name("y")));
        match number % 11 {
            0 => Term::new(Node::In(name("c"), name("x"))),
            1 => Term::new(Node::Out(name("d"), x)),
            2 => Term::delay(Value::one()),
            3 => Term::delay(y),
            4 => Term::new(Node::Set(x, name("y"))),
            5 => Term::new(Node::Guard(Relation::Gtr, y, x)),
            6 => Term::stop(),
            7 => Term::attempt(Term::new(Node::Set(y, name("z")))),
            8 => Term::disable([Term::delay(Value::one()), Term::new(Node::Observe(name("At"), vec![x]))]),
            9 => Term::new(Node::Guard(Relation::Gtr, Value::one(), Value::zero())),
            _ => Term::new(Node::Ran(Value::variable(&name("q")), name("x"))),
        }
    }

    #[test]
    fn a_long_sequence_is_known_as_a_short_one() {
        let (known, definitions) = (Assumptions::default(), Definitions::default());
        let mut seed = 11_usize;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            seed >> 33
        };
        for round in 0..300 {
            let mut parts: Vec<Term> = (0..LONG + 1 + next() % 8).map(|_| part(next())).collect();
            if round % 3 == 0 {
                let place = next() % parts.len();
                parts[place] = [Term::idle(), Term::abort()][round % 2].clone();
            }
            let whole = Term::seq(parts.clone());
            let context = Context::new(&known, &definitions, &[]);
            let each: Vec<Rc<Facts>> = parts.iter().map(|part| Facts::of(part, &context)).collect();
            assert_eq!(*Facts::of(&whole, &context), Facts::combine(&whole, &each, &context), "{whole:?}");
        }
    }
}
