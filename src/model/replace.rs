//! Putting values in for parameters, with regard to results that are bound again under the same name.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::{Meaningless, Model};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// How deep a term may be.
const DEEPEST: usize = 200;

type Known = BTreeMap<Name, Value>;

impl Model<'_> {
    /// The term with these values put in where it reads names that it has not bound itself.
    ///
    /// Where a part may or may not bind the name again, `P[y := x]` is left standing, for which run decides.
    pub(crate) fn put_in(&self, term: &Term, known: &Known, depth: usize) -> Result<Term, Meaningless> {
        if known.is_empty() {
            return Ok(term.clone());
        }
        if depth > DEEPEST {
            return Meaningless::because("it nests too deeply");
        }
        let inner = |part: &Term, known: &Known| self.put_in(part, known, depth + 1);
        match term.node() {
            Node::Seq(parts) => self.put_in_sequence(parts, known, depth),
            Node::Power(body, count, index) => {
                let count = value(count, known)?;
                let mut rest = known.clone();
                if let Some(index) = index {
                    rest.remove(index);
                }
                let again = self.split(body, &mut rest);
                let body = inner(body, &rest)?;
                Ok(wrap(Term::new(Node::Power(body, count, index.clone())), again))
            }
            Node::Loop(body) => {
                let mut rest = known.clone();
                let again = self.split(body, &mut rest);
                Ok(wrap(Term::new(Node::Loop(inner(body, &rest)?)), again))
            }
            Node::Replace(body, name, replaced) => {
                let replaced = value(replaced, known)?;
                let mut rest = known.clone();
                rest.remove(name);
                Ok(Term::new(Node::Replace(inner(body, &rest)?, name.clone(), replaced)))
            }
            _ => {
                let children = term.children();
                if children.is_empty() {
                    return term.map_values(&mut |expression| value(expression, known));
                }
                let parts = children.into_iter().map(|part| inner(part, known)).collect::<Result<Vec<_>, _>>()?;
                Ok(term.with_children(parts))
            }
        }
    }

    fn put_in_sequence(&self, parts: &[Term], known: &Known, depth: usize) -> Result<Term, Meaningless> {
        let mut rest = known.clone();
        let mut done = Vec::new();
        let mut standing = Known::new();
        for part in parts {
            done.push(self.put_in(part, &rest, depth + 1)?);
            if rest.is_empty() {
                continue;
            }
            let again = self.bound_names(part);
            for name in again.iter() {
                if let Some(value) = rest.remove(name)
                    && !surely_binds(part, name)
                {
                    standing.insert(name.clone(), value);
                }
            }
        }
        Ok(wrap(Term::seq(done), standing))
    }

    /// Moves out of `known` what the body may bind itself.
    fn split(&self, body: &Term, known: &mut Known) -> Known {
        let bound = self.bound_names(body);
        let (again, rest) = std::mem::take(known).into_iter().partition(|(name, _)| bound.contains(name));
        *known = rest;
        again
    }

    /// The names that a term may bind, with those of the definitions it calls.
    pub(crate) fn bound_names(&self, term: &Term) -> BTreeSet<Name> {
        let mut names = BTreeSet::new();
        let mut called = BTreeSet::new();
        collect_bound(term, &mut names, &mut called);
        for name in called {
            names.extend(self.bound_by_call(&name).iter().cloned());
        }
        names
    }

    /// The names that a term may read before it has bound them.
    pub(crate) fn free_reads(&self, term: &Term) -> BTreeSet<Name> {
        let mut reads: BTreeSet<Name> = term.values().flat_map(Value::variables).collect();
        match term.node() {
            Node::Seq(parts) => {
                let mut bound: BTreeSet<Name> = BTreeSet::new();
                for part in parts {
                    reads.extend(self.free_reads(part).difference(&bound).cloned());
                    let sure = self.bound_names(part).into_iter().filter(|name| surely_binds(part, name));
                    bound.extend(sure.collect::<Vec<_>>());
                }
            }
            Node::Replace(body, name, _) => {
                reads.extend(self.free_reads(body).into_iter().filter(|read| read != name));
            }
            Node::Power(body, _, Some(index)) => {
                reads.extend(self.free_reads(body).into_iter().filter(|read| read != index));
            }
            _ => term.children().for_each(|part| reads.extend(self.free_reads(part))),
        }
        reads
    }

    fn bound_by_call(&self, name: &Name) -> Rc<BTreeSet<Name>> {
        if let Some(names) = self.bound.borrow().get(name) {
            return names.clone();
        }
        let mut names = BTreeSet::new();
        let mut seen = BTreeSet::from([name.clone()]);
        let mut open = vec![name.clone()];
        while let Some(name) = open.pop() {
            if let Some(definition) = self.definitions.get(&name) {
                let mut called = BTreeSet::new();
                collect_bound(&definition.body, &mut names, &mut called);
                open.extend(called.into_iter().filter(|name| seen.insert(name.clone())));
            }
        }
        let names = Rc::new(names);
        self.bound.borrow_mut().insert(name.clone(), names.clone());
        names
    }
}

fn value(expression: &Value, known: &Known) -> Result<Value, Meaningless> {
    if !expression.variables().iter().any(|name| known.contains_key(name)) {
        return Ok(expression.clone());
    }
    expression.substitute(known).or_else(|error| Meaningless::because(error.0))
}

fn wrap(term: Term, standing: Known) -> Term {
    standing.into_iter().fold(term, |term, (name, value)| Term::new(Node::Replace(term, name, value)))
}

/// Adds the names bound in a term, and the definitions it calls; walks without recursion.
pub(crate) fn collect_bound(term: &Term, names: &mut BTreeSet<Name>, called: &mut BTreeSet<Name>) {
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        match term.node() {
            Node::In(_, name) | Node::Set(_, name) | Node::Ran(_, name) => {
                names.insert(name.clone());
            }
            Node::Call(name, _) => {
                called.insert(name.clone());
            }
            _ => open.extend(term.children()),
        }
    }
}

/// True only where the name is bound whenever the term stops.
fn surely_binds(term: &Term, name: &Name) -> bool {
    match term.node() {
        Node::In(_, bound) | Node::Set(_, bound) | Node::Ran(_, bound) => bound == name,
        Node::Seq(parts) => parts.iter().any(|part| surely_binds(part, name)),
        // Where the whole has stopped, a part that cannot abort has stopped too.
        Node::Par(parts) if parts.iter().any(|part| never_aborts(part) && surely_binds(part, name)) => true,
        Node::Else(..) | Node::Par(_) | Node::Disable(_) => {
            term.children().into_iter().all(|part| surely_binds(part, name))
        }
        Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => surely_binds(body, name),
        _ => false,
    }
}

/// True only where the form of the term tells that it cannot abort.
fn never_aborts(term: &Term) -> bool {
    match term.node() {
        Node::Stop | Node::Idle | Node::Delay(_) | Node::In(..) | Node::Out(..) => true,
        Node::Set(..) | Node::Ran(..) | Node::Observe(..) | Node::Loop(_) => true,
        Node::Else(_, second) => never_aborts(second),
        Node::Seq(_) | Node::Disable(_) => term.children().all(never_aborts),
        Node::Par(parts) => parts.iter().any(never_aborts),
        Node::Power(body, ..) | Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => {
            never_aborts(body)
        }
        _ => false,
    }
}
