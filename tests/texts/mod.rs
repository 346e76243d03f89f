//! Declarations, and what is read under them.
#![allow(dead_code)]

use pars::kernel::Theory;
use pars::law::Condition;
use pars::library;
use pars::lower::Environment;
use pars::parser::{parse, parse_condition, parse_term, parse_value};
use pars::term::Term;
use pars::value::Value;

/// The library with these declarations, none of which is wrong.
pub fn declared(text: &str) -> Environment {
    let mut environment = library::standard().expect("the library");
    let parsed = parse(text);
    assert!(parsed.diagnostics.is_empty(), "{text}\n{:?}", parsed.diagnostics);
    for outcome in environment.declare(&parsed.items, text) {
        outcome.unwrap_or_else(|wrong| panic!("{text}\n{wrong:?}"));
    }
    environment
}

pub fn theory(environment: &Environment) -> Theory {
    Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    }
}

pub fn term(environment: &Environment, text: &str) -> Term {
    let written = parse_term(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
    environment.part(&written).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
}

pub fn value(environment: &Environment, text: &str) -> Value {
    let written = parse_value(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
    environment.value(&written).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
}

pub fn condition(environment: &Environment, text: &str) -> Condition {
    let written = parse_condition(text).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"));
    environment.condition(&written).unwrap_or_else(|wrong| panic!("{text}: {wrong:?}"))
}
