//! Which names, metavariables and calls stand in a term, and where.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use crate::definition::Definitions;
use crate::law::{Condition, Law};
use crate::name::Name;
use crate::term::{Node, Term, TermMap};
use crate::value::Value;

/// Every subterm, the term itself first.
pub fn subterms(term: &Term) -> Subterms<'_> {
    Subterms { next: Some(term), open: Vec::new() }
}

/// The subterms of a term, one after another.
#[derive(Clone, Debug)]
pub struct Subterms<'a> {
    next: Option<&'a Term>,
    open: Vec<&'a Term>,
}

impl<'a> Iterator for Subterms<'a> {
    type Item = &'a Term;

    fn next(&mut self) -> Option<&'a Term> {
        let term = self.next.take().or_else(|| self.open.pop())?;
        let mut parts = term.children();
        self.next = parts.next_back();
        self.open.extend(parts);
        Some(term)
    }
}

/// All names that the term writes, binds by an index or replaces, wherever.
pub fn bound_names(term: &Term) -> BTreeSet<Name> {
    subterms(term).flat_map(binds_itself).cloned().collect()
}

/// The name that an operator writes, binds by an index or replaces.
pub(crate) fn binds_itself(term: &Term) -> Option<&Name> {
    match term.node() {
        Node::In(_, name)
        | Node::Set(_, name)
        | Node::Ran(_, name)
        | Node::Power(_, _, Some(name))
        | Node::Replace(_, name, _) => Some(name),
        _ => None,
    }
}

/// All names that are read by some value of the term, wherever.
pub fn read_names(term: &Term) -> BTreeSet<Name> {
    subterms(term).flat_map(Term::values).flat_map(Value::variables).collect()
}

/// The names that the term may read before it has written them itself, seen by the order of sequences alone.
pub fn needed_names(term: &Term) -> BTreeSet<Name> {
    let mut needed: BTreeSet<Name> = term.values().flat_map(Value::variables).collect();
    let ordered = matches!(term.node(), Node::Seq(_));
    let mut written = BTreeSet::new();
    for part in term.children() {
        needed.extend(needed_names(part).into_iter().filter(|name| !written.contains(name)));
        if let (true, Node::In(_, name) | Node::Set(_, name) | Node::Ran(_, name)) = (ordered, part.node()) {
            written.insert(name.clone());
        }
    }
    needed
}

/// All metavariables of a term: of processes, values, ports, results and indices.
pub fn metavariables(term: &Term) -> BTreeSet<Name> {
    let mut names: BTreeSet<Name> = read_names(term).into_iter().chain(bound_names(term)).collect();
    for part in subterms(term) {
        match part.node() {
            Node::Meta(name, _) | Node::New(name, _) | Node::In(name, _) | Node::Out(name, _) => {
                names.insert(name.clone());
            }
            Node::Project(_, shown) => names.extend(shown.iter().cloned()),
            _ => {}
        }
    }
    names.retain(Name::is_meta);
    names
}

/// Which names stand in a term, whatever they are there for.
#[derive(Clone, Default, PartialEq, Eq, Debug)]
pub struct Spoken {
    /// Those of [`bound_names`].
    pub bound: BTreeSet<Name>,
    /// Those of [`calls`].
    pub calls: BTreeSet<Name>,
    /// The metavariables that its values read.
    pub supposed: BTreeSet<Name>,
    /// A metavariable that stands for a process, or for a name.
    pub open: Option<Name>,
}

impl Spoken {
    /// The names of a term. What is found of the term, of its parts and of what is left of its sequences is kept in
    /// `known`, so that a run through a long sequence asks of each part once.
    pub fn of(term: &Term, known: &mut TermMap<Rc<Spoken>>) -> Rc<Spoken> {
        if let Some(found) = known.get(term) {
            return Rc::clone(found);
        }
        let found = match term.node() {
            Node::Seq(parts) => {
                let mut behind = Rc::new(Spoken::default());
                for (place, part) in parts.iter().enumerate().rev() {
                    behind = Spoken::of(part, known).and(&behind);
                    known.insert(parts.after(place), Rc::clone(&behind));
                }
                return behind;
            }
            _ => {
                let mut parts: Vec<Rc<Spoken>> = term.children().map(|part| Spoken::of(part, known)).collect();
                let mut own = Spoken::operator(term);
                let first = if parts.len() == 1 { parts.pop() } else { None };
                parts.iter().for_each(|part| own.take_in(part));
                let own = Rc::new(own);
                if let Some(first) = first { own.and(&first) } else { own }
            }
        };
        known.insert(term.clone(), Rc::clone(&found));
        found
    }

    /// Of the outermost operator alone.
    fn operator(term: &Term) -> Spoken {
        let mut spoken = Spoken::default();
        let names: Vec<&Name> = match term.node() {
            Node::Meta(name, _) | Node::Replace(_, name, _) => {
                spoken.open = Some(name.clone());
                vec![name]
            }
            Node::Call(name, _) => {
                spoken.calls.insert(name.clone());
                Vec::new()
            }
            Node::In(port, name) => vec![port, name],
            Node::Out(name, _) | Node::New(name, _) | Node::Set(_, name) | Node::Ran(_, name) => vec![name],
            Node::Power(_, _, Some(name)) => vec![name],
            Node::Project(_, shown) => shown.iter().collect(),
            _ => Vec::new(),
        };
        spoken.open = spoken.open.or_else(|| names.into_iter().find(|name| name.is_meta()).cloned());
        spoken.bound.extend(binds_itself(term).cloned());
        spoken.supposed.extend(term.values().flat_map(Value::variables).filter(Name::is_meta));
        spoken
    }

    /// With those of another part; nothing is copied where it adds none.
    fn and(self: Rc<Spoken>, other: &Rc<Spoken>) -> Rc<Spoken> {
        let holds = |one: &Spoken, other: &Spoken| {
            other.bound.is_subset(&one.bound)
                && other.calls.is_subset(&one.calls)
                && other.supposed.is_subset(&one.supposed)
                && (one.open.is_some() || other.open.is_none())
        };
        if holds(&self, other) {
            return self;
        }
        if self.open.is_none() && holds(other, &self) {
            return Rc::clone(other);
        }
        let mut all = Spoken::clone(&self);
        all.take_in(other);
        Rc::new(all)
    }

    fn take_in(&mut self, other: &Spoken) {
        self.bound.extend(other.bound.iter().cloned());
        self.calls.extend(other.calls.iter().cloned());
        self.supposed.extend(other.supposed.iter().cloned());
        self.open = self.open.take().or_else(|| other.open.clone());
    }
}

/// The terms and values of a condition.
pub fn condition_parts(condition: &Condition) -> (Vec<&Term>, Vec<&Value>, Vec<&Name>) {
    match condition {
        Condition::Compare(_, left, right) => (vec![], vec![left, right], vec![]),
        Condition::Natural(value) => (vec![], vec![value], vec![]),
        Condition::Is(_, term) => (vec![term], vec![], vec![]),
        Condition::Lasts(term, time) => (vec![term], vec![time], vec![]),
        Condition::Complementary(first, second) | Condition::Apart(first, second) => {
            (vec![first, second], vec![], vec![])
        }
        Condition::ShowsOnly(term, names) | Condition::ShowsNone(term, names) => {
            (vec![term], vec![], names.iter().collect())
        }
        Condition::NoPort(term, name) | Condition::Unread(term, name) => (vec![term], vec![], vec![name]),
    }
}

/// All metavariables of a condition.
pub fn condition_metavariables(condition: &Condition) -> BTreeSet<Name> {
    let (terms, values, names) = condition_parts(condition);
    let mut all: BTreeSet<Name> = terms.into_iter().flat_map(metavariables).collect();
    all.extend(values.into_iter().flat_map(Value::variables));
    all.extend(names.into_iter().cloned());
    all.retain(Name::is_meta);
    all
}

/// Whether a condition mentions a name in any of its parts.
pub fn condition_mentions(condition: &Condition, name: &Name) -> bool {
    let (terms, values, names) = condition_parts(condition);
    terms.into_iter().any(|term| read_names(term).contains(name))
        || values.into_iter().any(|value| value.mentions(name))
        || names.contains(&name)
}

/// The processes that a term calls directly.
pub fn calls(term: &Term) -> BTreeSet<Name> {
    subterms(term)
        .filter_map(|part| if let Node::Call(name, _) = part.node() { Some(name.clone()) } else { None })
        .collect()
}

/// Whether `from` calls `to`, directly or through other definitions.
pub fn reaches(definitions: &Definitions, from: &Name, to: &Name) -> bool {
    let mut seen = BTreeSet::new();
    let mut stack = vec![from.clone()];
    while let Some(name) = stack.pop() {
        if let Some(definition) = definitions.get(&name) {
            for called in calls(&definition.body) {
                if called == *to {
                    return true;
                }
                if seen.insert(called.clone()) {
                    stack.push(called);
                }
            }
        }
    }
    false
}

/// All names that the term, or a process it calls, writes by `In`, `Set` or `Ran`, or replaces.
pub fn written(term: &Term, definitions: &Definitions) -> BTreeSet<Name> {
    let mut names = BTreeSet::new();
    let mut seen = BTreeSet::new();
    let mut open = vec![term];
    while let Some(next) = open.pop() {
        for part in subterms(next) {
            match part.node() {
                Node::In(_, name) | Node::Set(_, name) | Node::Ran(_, name) | Node::Replace(_, name, _) => {
                    names.insert(name.clone());
                }
                Node::Call(called, _) if seen.insert(called.clone()) => {
                    open.extend(definitions.get(called).map(|definition| &definition.body));
                }
                _ => {}
            }
        }
    }
    names
}

/// A context with its holes filled: the process metavariables named in `parts` replaced, and nothing else.
pub fn fill(shape: &Term, parts: &BTreeMap<Name, Term>) -> Term {
    filled(shape, parts).unwrap_or_else(|| shape.clone())
}

/// The context filled; nothing if it has no hole.
fn filled(shape: &Term, parts: &BTreeMap<Name, Term>) -> Option<Term> {
    if let Node::Meta(name, arguments) = shape.node() {
        return if arguments.is_empty() { parts.get(name).cloned() } else { None };
    }
    changed(shape, &mut |child| filled(child, parts))
}

/// The term with some of its parts changed; nothing if none is.
pub fn changed(term: &Term, change: &mut dyn FnMut(&Term) -> Option<Term>) -> Option<Term> {
    let children: Vec<&Term> = term.children().collect();
    let first = children.iter().enumerate().find_map(|(place, child)| Some((place, change(child)?)));
    let (place, new) = first?;
    let before = children[..place].iter().map(|child| (*child).clone());
    let mut parts: Vec<Term> = before.chain([new]).collect();
    parts.extend(children[place + 1..].iter().map(|child| change(child).unwrap_or_else(|| (*child).clone())));
    Some(term.with_children(parts))
}

/// The index metavariables of a law with the metavariables that also stand outside their reach: what such a one
/// stands for must not mention the index, or it would change its meaning on the way out.
pub fn index_escapes(law: &Law) -> Vec<(Name, Name)> {
    let mut escapes = Vec::new();
    let sides = [&law.left, &law.right];
    let indices: BTreeSet<Name> = sides
        .iter()
        .flat_map(|side| subterms(side))
        .filter_map(|part| if let Node::Power(_, _, Some(index)) = part.node() { Some(index.clone()) } else { None })
        .collect();
    for index in indices {
        let mut outside = BTreeSet::new();
        for side in sides {
            outside_of(side, &index, &mut outside);
        }
        for condition in &law.conditions {
            let (terms, values, _) = condition_parts(condition);
            terms.into_iter().for_each(|term| outside_of(term, &index, &mut outside));
            outside.extend(values.into_iter().flat_map(Value::variables));
        }
        outside.remove(&index);
        escapes.extend(outside.into_iter().filter(Name::is_meta).map(|meta| (index.clone(), meta)));
    }
    escapes
}

fn outside_of(term: &Term, index: &Name, found: &mut BTreeSet<Name>) {
    found.extend(term.values().flat_map(Value::variables));
    match term.node() {
        Node::Power(_, _, Some(bound)) | Node::Replace(_, bound, _) if bound == index => {}
        Node::Meta(name, _) => {
            found.insert(name.clone());
        }
        _ => term.children().for_each(|part| outside_of(part, index, found)),
    }
}
