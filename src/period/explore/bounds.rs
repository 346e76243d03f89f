//! What is known of the values of a phase wherever it is entered: a number that was drawn, and is held or handed on as it
//! is, is none that its distribution does not give.

use super::super::run::least;
use super::{Explorer, Held, Spot};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::Test;
use crate::value::{Relation, Value, View};

/// What a value is at least, and at most.
#[derive(Clone, Default, PartialEq, Eq)]
pub(super) struct Bounds {
    least: Option<Value>,
    most: Option<Value>,
}

/// What is drawn from a distribution is surely at most this.
fn most(distribution: &Value) -> Option<Value> {
    let View::Distribution(kind, arguments) = distribution.view() else { return None };
    match (kind.as_str(), arguments.as_slice()) {
        ("Point", [only]) | ("Uniform", [_, only]) => Some(only.clone()),
        _ => None,
    }
}

impl Bounds {
    fn is_none(&self) -> bool {
        *self == Bounds::default()
    }

    /// Keeps what another value of the same place is known to be too; whether that is less.
    fn loosen(&mut self, other: &Bounds) -> bool {
        let before = self.clone();
        if self.least != other.least {
            self.least = None;
        }
        if self.most != other.most {
            self.most = None;
        }
        *self != before
    }

    fn tests(&self, name: &Name) -> impl Iterator<Item = Test> {
        let sides = [(Relation::Gte, self.least.clone()), (Relation::Lte, self.most.clone())];
        let left = Value::variable(name);
        sides
            .into_iter()
            .filter_map(move |(relation, bound)| Some(Test { relation, left: left.clone(), right: bound? }))
    }
}

impl Spot {
    /// What is known of each variable.
    fn bounds(&self) -> impl Iterator<Item = (&Name, &Bounds)> {
        let places = self.held.iter().zip(&self.bounds).filter(|(_, bounds)| !bounds.is_none());
        places.filter_map(|(held, bounds)| match held {
            Held::Class(class) => Some((self.variables.get(*class)?, bounds)),
            Held::Constant(_) => None,
        })
    }

    /// What holds of the variables wherever the phase is entered.
    pub(super) fn told_bounds(&self) -> Vec<Test> {
        let mut all: Vec<Test> = self.bounds().flat_map(|(name, bounds)| bounds.tests(name)).collect();
        all.sort();
        all.dedup();
        all
    }
}

impl Explorer<'_> {
    /// What is known of values that come from the phase that is explored, of which some have been drawn on the way; empty
    /// where nothing is.
    pub(super) fn bounds_of(&self, entries: &[Value], draws: &[(Name, Value)]) -> Vec<Bounds> {
        if draws.is_empty() && self.here.is_empty() {
            return Vec::new();
        }
        let of = |entry: &Value| {
            let name = entry.as_variable()?;
            let Some((_, from)) = draws.iter().find(|(drawn, _)| drawn == name) else {
                return self.here.get(name).cloned();
            };
            // What depends on a variable of this phase means nothing in another.
            let fixed = |bound: &Value| !self.clock.settler.varies(bound);
            let (least, most) = (least(from, self.assumptions).filter(fixed), most(from).filter(fixed));
            Some(Bounds { least, most })
        };
        let found: Vec<Bounds> = entries.iter().map(|entry| of(entry).unwrap_or_default()).collect();
        if found.iter().all(Bounds::is_none) { Vec::new() } else { found }
    }

    /// Keeps of what is known of a phase only what is so of these values too; whether that is less.
    pub(super) fn loosen(&mut self, number: usize, bounds: &[Bounds]) -> bool {
        let nothing = Bounds::default();
        let own = self.spots[number].bounds.iter_mut().enumerate();
        own.fold(false, |less, (place, known)| known.loosen(bounds.get(place).unwrap_or(&nothing)) | less)
    }

    /// Assumes what is known of the variables of the phase that is explored now.
    pub(super) fn assume_bounds(&mut self, number: usize, assumptions: &mut Assumptions) {
        let spot = &self.spots[number];
        self.here = spot.bounds().map(|(name, bounds)| (name.clone(), bounds.clone())).collect();
        for Test { relation, left, right } in spot.told_bounds() {
            assumptions.assume(relation, &left, &right);
        }
    }
}
