//! Systems and properties, as they are declared.

mod impossible;

use std::collections::BTreeSet;

pub(super) use impossible::impossible;

use super::Pattern;
use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// `system Sys = P | Q`
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct System {
    /// Its name.
    pub name: Name,
    /// Its components as written, in order; none if its definition has errors.
    pub components: Vec<Term>,
}

impl System {
    /// The components in parallel, with every port that two of them share made private.
    pub fn term(&self, definitions: &Definitions) -> Term {
        let unshared = self.unshared(definitions);
        self.behind(self.ports(definitions).filter(|port| !unshared.contains(port)).collect())
    }

    /// The components by themselves: every port is private, as nobody else is there.
    pub fn alone(&self, definitions: &Definitions) -> Term {
        self.behind(self.ports(definitions).collect())
    }

    /// The ports that one component alone uses.
    pub fn unshared(&self, definitions: &Definitions) -> BTreeSet<Name> {
        let (mut once, mut again) = (BTreeSet::new(), BTreeSet::new());
        for port in self.ports(definitions) {
            if !once.insert(port.clone()) {
                again.insert(port);
            }
        }
        &once - &again
    }

    /// The ports of the components, one component after the other.
    fn ports(&self, definitions: &Definitions) -> impl Iterator<Item = Name> {
        self.components.iter().flat_map(|component| super::graph::ports(component, definitions))
    }

    fn behind(&self, ports: BTreeSet<Name>) -> Term {
        let whole = Term::par(self.components.iter().cloned());
        ports.into_iter().rev().fold(whole, |body, port| Term::new(Node::New(port, body)))
    }
}

/// `property Goal = P`: may call itself by its name; its unknowns are the values `?t`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Property {
    /// Its name.
    pub name: Name,
    /// What it says; nothing if its definition has errors.
    pub body: Option<Term>,
    /// `where P(x <= d) >= q`: the latest time, and how likely it must be.
    pub within: Option<(Value, Relation, Value)>,
    /// `(A_p | B_{p+q}) ; G where q > 1`: what holds whenever these are shown.
    pub always: Option<Pattern>,
}
