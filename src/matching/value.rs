//! Values of a pattern against values.

use std::collections::BTreeMap;

use super::State;
use crate::name::Name;
use crate::value::Value;

/// A pattern value against a value: equal, or linear in its one unknown metavariable, or put off.
pub(super) fn solve(pattern: &Value, value: &Value, state: &mut State) -> bool {
    if let Some(name) = pattern.as_variable().cloned() {
        if !name.is_meta() {
            return pattern == value;
        }
        if let Some(result) = state.found.names.get(&name) {
            return Value::variable(result) == *value;
        }
        return state.found.values.entry(name).or_insert_with(|| value.clone()) == value;
    }
    let mut known: BTreeMap<Name, Value> = state.found.values.clone();
    known.extend(state.found.names.iter().map(|(meta, name)| (meta.clone(), Value::variable(name))));
    let unknown: Vec<Name> =
        pattern.variables().into_iter().filter(|name| name.is_meta() && !known.contains_key(name)).collect();
    let Ok(pattern) = pattern.substitute(&known) else { return false };
    match unknown.as_slice() {
        [] => pattern == *value,
        [name] => {
            let Some((factor, rest)) = pattern.linear_in(name) else { return false };
            let solution = value.sub(&rest).and_then(|difference| difference.div(&factor));
            match solution {
                Ok(solution) => {
                    state.found.values.insert(name.clone(), solution);
                    true
                }
                Err(_) => false,
            }
        }
        _ => {
            state.later.push((pattern, value.clone()));
            true
        }
    }
}
