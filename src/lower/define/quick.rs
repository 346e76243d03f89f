//! Calls in no time that guards bring to an end: `Inner_{n,0}` calls `Outer_{n-1}` at once, which calls `Inner_{n-1,3}`,
//! and there `Eq_{m,0}` does not pass.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use super::super::flow::{Flow, Flows};
use super::super::{Entity, Environment};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Calls in no time that one way goes through; far fewer than an execution unfolds at once.
const MOST_CALLS: usize = 16;
/// Calls that are looked at for one process, and for all of a text.
const MOST_LOOKS: usize = 200;
const MOST_IN_ALL: usize = 2000;

/// The definitions that are looked at, and what is known of their parameters.
pub(super) struct Quick<'q> {
    /// The parameters and the body of each.
    pub(super) bodies: BTreeMap<&'q Name, (Vec<Name>, &'q Term)>,
    /// The same of all processes of the text.
    pub(super) all: BTreeMap<&'q Name, (&'q [Name], &'q Term)>,
    /// How each process ends.
    pub(super) flows: &'q Flows,
    /// What was declared before the text, with all that is assumed of parameters before it and in it.
    pub(super) seen: &'q Environment,
    /// The names that some process binds.
    pub(super) results: BTreeSet<&'q Name>,
    /// The calls that were looked at so far.
    pub(super) looks: Cell<usize>,
}

/// What is known at a place: the guards that passed, and what each name of the definition stands for.
#[derive(Clone)]
struct Here {
    guards: Assumptions,
    values: BTreeMap<Name, Value>,
}

/// A call that is reached in no time, with its arguments and what holds there.
struct Reached {
    name: Name,
    arguments: Vec<Value>,
    guards: Assumptions,
}

/// How a process begins.
#[derive(Clone, Copy, PartialEq)]
enum Begins {
    /// It surely goes on at once.
    Passes,
    /// It may end at once.
    MayEnd,
    /// It waits or communicates before anything else.
    Waits,
}

/// One look at what a process calls in no time.
struct Look<'l, 'q> {
    quick: &'l Quick<'q>,
    unknowns: usize,
}

impl Quick<'_> {
    /// Whether from this process, whatever its arguments, no more than some calls are gone through in no time.
    pub(super) fn ends(&self, name: &Name) -> bool {
        let Some((parameters, _)) = self.bodies.get(name) else { return false };
        let mut look = Look { quick: self, unknowns: 0 };
        let until = MOST_IN_ALL.min(self.looks.get() + MOST_LOOKS);
        let arguments = parameters.iter().map(|_| look.unknown()).collect();
        let first = Reached { name: name.clone(), arguments, guards: self.seen.assumptions.clone() };
        let mut waiting = vec![(first, 0)];
        while let Some((call, depth)) = waiting.pop() {
            if depth > MOST_CALLS || self.looks.get() >= until {
                return false;
            }
            self.looks.set(self.looks.get() + 1);
            let Some((parameters, body)) = self.bodies.get(&call.name) else { continue };
            let values = parameters.iter().cloned().zip(call.arguments).collect();
            let mut calls = Vec::new();
            look.walk(body, Here { guards: call.guards, values }, &mut calls);
            waiting.extend(calls.into_iter().map(|call| (call, depth + 1)));
        }
        true
    }

    fn flow(&self, name: &Name) -> Option<&Flow> {
        self.flows.get(name).or_else(|| match self.seen.entity(name) {
            Some(Entity::Process(signature)) => Some(&signature.flow),
            _ => None,
        })
    }
}

impl Look<'_, '_> {
    /// What is known where the process has stopped in no time, if it may; the calls on the way are added.
    fn walk(&mut self, term: &Term, mut here: Here, calls: &mut Vec<Reached>) -> Option<Here> {
        match term.node() {
            Node::Guard(relation, left, right) => {
                let (left, right) = (self.resolved(left, &here), self.resolved(right, &here));
                here.guards.assume(*relation, &left, &right);
                (!here.guards.plainly_contradictory() && !here.guards.contradictory()).then_some(here)
            }
            Node::Set(value, name) => {
                let value = self.resolved(value, &here);
                here.values.insert(name.clone(), value);
                Some(here)
            }
            Node::Delay(time) => (*time == Value::zero()).then_some(here),
            Node::In(..) | Node::Out(..) | Node::Idle | Node::Abort | Node::Observe(..) => None,
            Node::Call(name, arguments) => {
                let arguments = arguments.iter().map(|argument| self.resolved(argument, &here)).collect();
                calls.push(Reached { name: name.clone(), arguments, guards: here.guards.clone() });
                let stops = self.quick.flow(name).is_none_or(|flow| flow.quick_stop);
                let stops = stops && self.begins(term, &mut here.clone(), MOST_CALLS) != Begins::Waits;
                stops.then(|| self.after(term, here))
            }
            Node::Seq(parts) => parts.iter().try_fold(here, |here, part| self.walk(part, here, calls)),
            // Rounds of which there is one at least; the names that they bind may be bound anew in each.
            Node::Power(body, count, _) if self.is_positive(count, &here) => {
                let here = self.after(term, here);
                self.walk(body, here.clone(), calls).map(|_| here)
            }
            // Of the rest it is only taken that each part may begin, and that it may stop if a part may.
            _ => {
                let here = self.after(term, here);
                let mut stops = matches!(term.node(), Node::Stop | Node::Ran(..) | Node::Power(..) | Node::Loop(_));
                for part in term.children() {
                    stops |= self.walk(part, here.clone(), calls).is_some();
                }
                stops.then_some(here)
            }
        }
    }

    /// How a process begins with the arguments that it has here: `Gtr_{n,0} ; Out_{v,0} ; …` communicates where n is 2.
    fn begins(&mut self, term: &Term, here: &mut Here, most: usize) -> Begins {
        match term.node() {
            Node::In(..) | Node::Out(..) => Begins::Waits,
            Node::Delay(time) if self.is_positive(time, here) => Begins::Waits,
            Node::Guard(relation, left, right) => {
                let (left, right) = (self.resolved(left, here), self.resolved(right, here));
                let passes = here.guards.decide(*relation, &left, &right) == Some(true);
                if passes { Begins::Passes } else { Begins::MayEnd }
            }
            Node::Set(value, name) => {
                let value = self.resolved(value, here);
                here.values.insert(name.clone(), value);
                Begins::Passes
            }
            Node::Seq(parts) => {
                let mut parts = parts.iter().map(|part| self.begins(part, here, most));
                parts.find(|begins| *begins != Begins::Passes).unwrap_or(Begins::MayEnd)
            }
            Node::Par(parts) | Node::Disable(parts) => {
                let waits = parts.iter().all(|part| self.begins(part, &mut here.clone(), most) == Begins::Waits);
                if waits { Begins::Waits } else { Begins::MayEnd }
            }
            Node::Call(name, arguments) => {
                let looks = self.quick.looks.get();
                let found = self.quick.all.get(name).copied();
                let Some((parameters, body)) = found.filter(|_| most > 0 && looks < MOST_IN_ALL) else {
                    return Begins::MayEnd;
                };
                self.quick.looks.set(looks + 1);
                let arguments: Vec<Value> = arguments.iter().map(|argument| self.resolved(argument, here)).collect();
                let values = parameters.iter().cloned().zip(arguments).collect();
                let begins = self.begins(body, &mut Here { guards: here.guards.clone(), values }, most - 1);
                if begins == Begins::Waits { Begins::Waits } else { Begins::MayEnd }
            }
            Node::Power(body, count, _) if self.is_positive(count, here) => {
                let mut inside = self.after(term, here.clone());
                if self.begins(body, &mut inside, most) == Begins::Waits { Begins::Waits } else { Begins::MayEnd }
            }
            _ => Begins::MayEnd,
        }
    }

    /// Whether a value is surely greater than 0.
    fn is_positive(&mut self, value: &Value, here: &Here) -> bool {
        let value = self.resolved(value, here);
        here.guards.decide(Relation::Gtr, &value, &Value::zero()) == Some(true)
    }

    /// What is known behind a process, whatever it bound: of the names that it may bind nothing.
    fn after(&mut self, term: &Term, mut here: Here) -> Here {
        let mut bound = BTreeSet::new();
        self.bound(term, &mut bound);
        for name in bound {
            let unknown = self.unknown();
            here.values.insert(name, unknown);
        }
        here
    }

    fn bound(&self, term: &Term, found: &mut BTreeSet<Name>) {
        match term.node() {
            Node::Set(_, name) | Node::Ran(_, name) | Node::In(_, name) | Node::Power(_, _, Some(name)) => {
                found.insert(name.clone());
            }
            Node::Call(name, _) => {
                found.extend(self.quick.flow(name).into_iter().flat_map(|flow| flow.binds.iter().cloned()));
            }
            _ => {}
        }
        term.children().for_each(|child| self.bound(child, found));
    }

    /// The value with what its names stand for; what is not known to be one value all the way is a new unknown.
    fn resolved(&mut self, value: &Value, here: &Here) -> Value {
        let lost = |name: &Name| !here.values.contains_key(name) && self.quick.results.contains(name);
        if value.variables().iter().any(lost) {
            return self.unknown();
        }
        value.substitute(&here.values).unwrap_or_else(|_| self.unknown())
    }

    /// A name that nothing is known of.
    fn unknown(&mut self) -> Value {
        self.unknowns += 1;
        Value::variable(&Name::new(&format!("unknown {}", self.unknowns)))
    }
}
