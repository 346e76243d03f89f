//! Names with their values; most often there are none, which takes no memory. And what people call what runs with them.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::rc::Rc;

use crate::name::Name;
use crate::value::Value;

/// Names with their values, shared until they change; never an empty map, so that what is equal is told by what is in it.
#[derive(Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) struct Env(Option<Rc<BTreeMap<Name, Value>>>);

static NOTHING: BTreeMap<Name, Value> = BTreeMap::new();

impl Env {
    /// Without names.
    pub(crate) fn new() -> Env {
        Env::default()
    }

    /// Gives a name a value.
    pub(crate) fn insert(&mut self, name: Name, value: Value) {
        Rc::make_mut(self.0.get_or_insert_default()).insert(name, value);
    }

    /// Takes on the values of another.
    pub(crate) fn add(&mut self, other: &Env) {
        match (&mut self.0, &other.0) {
            (_, None) => {}
            (own @ None, _) => *own = other.0.clone(),
            (Some(own), Some(other)) => {
                let values = other.iter().map(|(name, value)| (name.clone(), value.clone()));
                Rc::make_mut(own).extend(values);
            }
        }
    }
}

impl Deref for Env {
    type Target = BTreeMap<Name, Value>;

    fn deref(&self) -> &BTreeMap<Name, Value> {
        self.0.as_deref().unwrap_or(&NOTHING)
    }
}

impl FromIterator<(Name, Value)> for Env {
    fn from_iter<I: IntoIterator<Item = (Name, Value)>>(values: I) -> Env {
        let mut env = Env::new();
        values.into_iter().for_each(|(name, value)| env.insert(name, value));
        env
    }
}

/// The values of the names that are needed.
pub(crate) fn restrict(env: &Env, names: &BTreeSet<Name>) -> Env {
    if env.keys().all(|name| names.contains(name)) {
        return env.clone();
    }
    env.iter().filter(|(name, _)| names.contains(*name)).map(|(name, value)| (name.clone(), value.clone())).collect()
}

/// One value, if its name is needed.
pub(crate) fn one(name: &Name, value: Value, needed: &BTreeSet<Name>) -> Env {
    if needed.contains(name) { Env::from_iter([(name.clone(), value)]) } else { Env::new() }
}

/// What people call a running part. It says nothing of what the part does, so all are equal.
#[derive(Clone, Debug)]
pub(crate) struct Called(pub(crate) Option<Name>);

impl PartialEq for Called {
    fn eq(&self, _: &Called) -> bool {
        true
    }
}

impl Eq for Called {}

impl PartialOrd for Called {
    fn partial_cmp(&self, other: &Called) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Called {
    fn cmp(&self, _: &Called) -> Ordering {
        Ordering::Equal
    }
}

impl Hash for Called {
    fn hash<H: Hasher>(&self, _: &mut H) {}
}
