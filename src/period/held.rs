//! What the places of a phase hold: a value, or a variable where it differs from visit to visit.

use std::collections::{BTreeMap, BTreeSet};

use crate::name::Name;
use crate::value::Value;

/// What a place of a phase holds.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Held {
    Constant(Value),
    Class(usize),
}

/// What the places of a phase hold at the first visit.
pub(super) fn first_held(entries: &[Value], varies: impl Fn(&Value) -> bool) -> Vec<Held> {
    let mut classes: BTreeMap<&Value, usize> = BTreeMap::new();
    entries
        .iter()
        .map(|entry| {
            if !varies(entry) {
                return Held::Constant(entry.clone());
            }
            let next = classes.len();
            Held::Class(*classes.entry(entry).or_insert(next))
        })
        .collect()
}

/// Variables are called after the first place they stand in, with a number where that is taken.
pub(super) fn name_variables(held: &[Held], hints: &[Name], reserved: &BTreeSet<Name>) -> Vec<Name> {
    let mut names: Vec<Name> = Vec::new();
    let mut taken: BTreeSet<Name> = BTreeSet::new();
    let mut numbers: BTreeMap<&Name, usize> = BTreeMap::new();
    for (held, hint) in held.iter().zip(hints) {
        if *held != Held::Class(names.len()) {
            continue;
        }
        let number = numbers.entry(hint).or_insert(0);
        let mut name = hint.clone();
        loop {
            *number += 1;
            if *number > 1 {
                name = Name::new(&format!("{hint}{number}"));
            }
            if !reserved.contains(&name) && taken.insert(name.clone()) {
                break;
            }
        }
        names.push(name);
    }
    names
}
