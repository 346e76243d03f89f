//! Defined processes: `proc T_u = P_u ; T_{f(u)}`.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::digest::Quick;
use crate::name::Name;
use crate::term::Term;

/// One definition. A recursive one is a loop (§IV.D): a call of it means `body else Stop`, so that the loop
/// stops when a round aborts; a call of any other means its body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Definition {
    /// Its name.
    pub name: Name,
    /// The names of its parameters, all different.
    pub parameters: Vec<Name>,
    /// What a call does, in terms of the parameters.
    pub body: Term,
    /// Whether it calls itself, alone or round a cycle of definitions.
    pub recursive: bool,
}

/// All definitions in force, by name; cheap to copy.
#[derive(Clone, Debug, Default)]
pub struct Definitions(Arc<Known>);

/// The definitions in order, and where they are found at once.
#[derive(Clone, Debug, Default)]
struct Known {
    ordered: BTreeMap<Name, Arc<Definition>>,
    found: Quick<Name, Arc<Definition>>,
}

impl Definitions {
    /// The definition of this name.
    pub fn get(&self, name: &Name) -> Option<&Definition> {
        self.0.found.get(name).map(Arc::as_ref)
    }

    /// Whether these are the others themselves, and so the same: of equal ones that were made apart it is not told.
    pub fn is(&self, other: &Definitions) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Adds or replaces one.
    pub fn insert(&mut self, definition: Definition) {
        let (known, definition) = (Arc::make_mut(&mut self.0), Arc::new(definition));
        known.ordered.insert(definition.name.clone(), definition.clone());
        known.found.insert(definition.name.clone(), definition);
    }

    /// Takes one out, if it is there.
    pub fn remove(&mut self, name: &Name) {
        let known = Arc::make_mut(&mut self.0);
        known.ordered.remove(name);
        known.found.remove(name);
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = &Definition> {
        self.0.ordered.values().map(Arc::as_ref)
    }
}
