//! `probability of …`, `… with probability >= q`.

use super::claim::Found;
use super::reading::{Run, Waiting};
use crate::lower::Likelihood;
use crate::value::{Relation, Value};

impl Run<'_, '_> {
    pub(super) fn likely(&mut self, _: &Likelihood, _: Relation, _: &Value, _: &Waiting) -> Found {
        Found { remains: vec!["no method".to_string()], ..Found::default() }
    }

    pub(super) fn probability(&mut self, _: &Likelihood, _: &Waiting) -> Vec<String> {
        vec!["no method".to_string()]
    }
}
