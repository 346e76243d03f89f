//! Vectors, whose components are variables of their own.

use crate::name::Name;
use crate::value::{Sort, Value};

/// The components of a vector.
pub(super) fn components(value: &Value) -> Option<Vec<Value>> {
    let Sort::Vector(length) = value.sort() else { return None };
    (0..length).map(|place| value.component(place)).collect()
}

/// The components of `r` are `rx`, `ry`, `rz`; of longer vectors `r1`, `r2`, ….
pub(super) fn component_name(whole: &Name, place: usize, length: usize) -> Name {
    match ["x", "y", "z"].get(place).filter(|_| length <= 3) {
        Some(letter) => Name::new(&format!("{whole}{letter}")),
        None => Name::new(&format!("{whole}{}", place + 1)),
    }
}
