//! What calls bind: a process passes on the names that it binds, and so do those that call it.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::{binds_itself, bound_names, needed_names, subterms};
use crate::term::{Node, Term};
use crate::value::Value;

/// The names that calls bind.
#[derive(Debug, Default)]
pub(crate) struct PassedOn {
    /// Those that a call may bind, of all processes that may bind one.
    may: BTreeMap<Name, BTreeSet<Name>>,
    /// Those that are bound whenever a call stops, of all processes that surely bind one.
    surely: BTreeMap<Name, BTreeSet<Name>>,
}

impl PassedOn {
    /// Of all that these call: from what calls nothing on, each again when something that it calls binds more.
    pub(super) fn of(components: &[Term], definitions: &Definitions) -> PassedOn {
        let mut callers: BTreeMap<&Name, BTreeSet<&Name>> = BTreeMap::new();
        let (mut binding, mut reached) = (BTreeSet::new(), BTreeSet::new());
        let mut open: Vec<(Option<&Name>, &Term)> = components.iter().map(|term| (None, term)).collect();
        while let Some((caller, term)) = open.pop() {
            for part in subterms(term) {
                let Node::Call(called, _) = part.node() else { continue };
                if let Some(caller) = caller {
                    callers.entry(called).or_default().insert(caller);
                }
                if let Some(definition) = definitions.get(called).filter(|_| reached.insert(called)) {
                    open.push((Some(&definition.name), &definition.body));
                    if subterms(&definition.body).any(|part| binds_itself(part).is_some()) {
                        binding.insert(&definition.name);
                    }
                }
            }
        }
        let mut waiting: VecDeque<&Name> = binding.into_iter().collect();
        let mut found = PassedOn::default();
        while let Some(name) = waiting.pop_front() {
            let Some(definition) = definitions.get(name) else { continue };
            let may = found.may(&definition.body);
            // A loop that goes round no more has stopped, whatever its last round came to.
            let surely = if definition.recursive { BTreeSet::new() } else { found.surely(&definition.body) };
            if found.may.get(name) != Some(&may) || (!surely.is_empty() && found.surely.get(name) != Some(&surely)) {
                found.may.insert(name.clone(), may);
                if !surely.is_empty() {
                    found.surely.insert(name.clone(), surely);
                }
                waiting.extend(callers.get(name).into_iter().flatten());
            }
        }
        found
    }

    /// The names that a process may bind.
    pub(super) fn may(&self, term: &Term) -> BTreeSet<Name> {
        let mut names = bound_names(term);
        if !self.may.is_empty() {
            let called =
                subterms(term).filter_map(|part| if let Node::Call(name, _) = part.node() { Some(name) } else { None });
            names.extend(called.filter_map(|name| self.may.get(name)).flatten().cloned());
        }
        names
    }

    /// The names that are bound whenever a process stops.
    pub(super) fn surely(&self, term: &Term) -> BTreeSet<Name> {
        match term.node() {
            Node::In(_, name) | Node::Set(_, name) | Node::Ran(_, name) => BTreeSet::from([name.clone()]),
            Node::Call(name, _) => self.surely.get(name).cloned().unwrap_or_default(),
            Node::Seq(parts) => parts.iter().flat_map(|part| self.surely(part)).collect(),
            Node::New(_, body) | Node::Project(body, _) => self.surely(body),
            Node::Else(..) | Node::Par(_) | Node::Disable(_) => {
                let mut all = term.children().map(|part| self.surely(part));
                let first = all.next().unwrap_or_default();
                all.fold(first, |common, own| common.intersection(&own).cloned().collect())
            }
            _ => BTreeSet::new(),
        }
    }

    /// The names whose values a process needs from before: what a sequence reads behind what binds it, it does not.
    pub(super) fn needed(&self, term: &Term) -> BTreeSet<Name> {
        if self.surely.is_empty() {
            return needed_names(term);
        }
        let mut needed: BTreeSet<Name> = term.values().flat_map(Value::variables).collect();
        let ordered = matches!(term.node(), Node::Seq(_));
        let mut written = BTreeSet::new();
        for part in term.children() {
            needed.extend(self.needed(part).into_iter().filter(|name| !written.contains(name)));
            if ordered {
                written.extend(self.written(part));
            }
        }
        needed
    }

    /// What a read, a `Set` or a call is about to bind.
    pub(super) fn written(&self, part: &Term) -> BTreeSet<Name> {
        match part.node() {
            Node::In(..) | Node::Set(..) | Node::Ran(..) | Node::Call(..) => self.surely(part),
            _ => BTreeSet::new(),
        }
    }
}
