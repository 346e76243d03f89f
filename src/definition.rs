//! Defined processes: `proc T_u = P_u ; T_{f(u)}`.

use std::collections::BTreeMap;
use std::sync::Arc;

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
pub struct Definitions(Arc<BTreeMap<Name, Definition>>);

impl Definitions {
    /// The definition of this name.
    pub fn get(&self, name: &Name) -> Option<&Definition> {
        self.0.get(name)
    }

    /// Adds or replaces one.
    pub fn insert(&mut self, definition: Definition) {
        Arc::make_mut(&mut self.0).insert(definition.name.clone(), definition);
    }

    /// Takes one out, if it is there.
    pub fn remove(&mut self, name: &Name) {
        Arc::make_mut(&mut self.0).remove(name);
    }

    /// All of them, by name.
    pub fn iter(&self) -> impl Iterator<Item = &Definition> {
        self.0.values()
    }
}
