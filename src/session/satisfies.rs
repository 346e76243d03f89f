//! `Sys satisfies Goal`, `period Sys`, `flow Sys`.

use super::claim::Found;
use super::reading::{Run, Waiting};
use crate::name::Name;

impl Run<'_, '_> {
    pub(super) fn satisfies(&mut self, system: &Name, property: &Name, _waiting: &Waiting) -> Found {
        let remains = vec![format!("whether {system} satisfies {property}: systems are not examined yet")];
        Found { remains, ..Found::default() }
    }

    pub(super) fn period(&mut self, system: &Name, _waiting: &Waiting) -> Vec<String> {
        vec![format!("the period of {system}: systems are not examined yet")]
    }

    pub(super) fn flow(&mut self, system: &Name, _waiting: &Waiting) -> Vec<String> {
        vec![format!("the flow of {system}: systems are not examined yet")]
    }
}
