//! Terms, values and conditions of a proof: any name may stand in them, for the kernel is their judge.

use super::Environment;
use super::scope::{Lowerer, Metas};
use crate::ast::{self, ValueKind};
use crate::diagnostic::Diagnostic;
use crate::law::Condition;
use crate::term::Term;
use crate::value::Value;

impl Environment {
    /// The process written here; names that are not declared are variables.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn free_term(&self, term: &ast::Term) -> Result<Term, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Free);
        let lowered = lowerer.process(term);
        lowerer.finish(lowered)
    }

    /// The number, vector or distribution written here; names that are not declared are variables.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn free_value(&self, value: &ast::Value) -> Result<Value, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Free);
        let capital = |name: &ast::Ident| name.name.as_str().starts_with(char::is_uppercase);
        let lowered = match &value.kind {
            ValueKind::Call(name, _) if capital(name) => lowerer.distribution(value),
            _ => lowerer.number(value),
        };
        lowerer.finish(lowered)
    }

    /// The condition written here; names that are not declared are variables.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn free_condition(&self, condition: &ast::Condition) -> Result<Condition, Vec<Diagnostic>> {
        let mut lowerer = Lowerer::new(self, Metas::Free);
        let lowered = lowerer.condition(condition);
        lowerer.finish(lowered)
    }
}
