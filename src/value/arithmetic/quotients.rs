//! The normal forms of long fractions, each found once: a robot in the plane is at places that are asked for again and
//! again, by the run, by the prover and by the kernel.
//!
//! The normal form is a function of the two polynomials alone: an answer does not depend on what is remembered.

use std::cell::RefCell;
use std::collections::HashMap;

use crate::value::{Outcome, Real, Value};

/// How many fractions are remembered; then all are forgotten.
const MOST_FRACTIONS: usize = 4_000;

thread_local! {
    static KNOWN: RefCell<HashMap<(Real, Real), Value>> = RefCell::new(HashMap::new());
}

/// What `find` makes of a fraction, numerator and denominator; what is no value is found again.
pub(super) fn found_once(fraction: (Real, Real), find: impl FnOnce((Real, Real)) -> Outcome) -> Outcome {
    if let Some(known) = KNOWN.with_borrow(|known| known.get(&fraction).cloned()) {
        return Ok(known);
    }
    let found = find(fraction.clone())?;
    KNOWN.with_borrow_mut(|known| {
        if known.len() >= MOST_FRACTIONS {
            known.clear();
        }
        known.insert(fraction, found.clone());
    });
    Ok(found)
}
