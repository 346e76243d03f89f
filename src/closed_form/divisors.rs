//! Divisors of which it is known only that they are not 0: each sign is looked at by itself.

use std::collections::BTreeSet;

use super::{Recurrence, Unchecked};
use crate::assumption::Assumptions;
use crate::value::{Atom, Need, Relation, Value};

/// The most divisors of which either sign is looked at by itself.
const MOST_SIGNS: usize = 2;

/// What these, or the first values, divide by that is known not to be 0, and of which no sign is known.
pub(super) fn divisors(values: &[&Value], recurrence: &Recurrence, known: &Assumptions) -> Vec<Value> {
    let starts = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
    let needs: BTreeSet<Need> = values.iter().copied().chain(starts).flat_map(Value::needs).collect();
    let is = |relation: Relation, value: &Value| known.decide(relation, value, &Value::zero());
    let open = |value: &Value| is(Relation::Gtr, value).is_none();
    let of_need = |need: Need| match need {
        Need::Nonzero(divisor) if is(Relation::Neq, &divisor) == Some(true) => match open(&divisor) {
            true => vec![divisor],
            false => factors(&divisor).into_iter().filter(open).collect(),
        },
        _ => Vec::new(),
    };
    needs.into_iter().flat_map(of_need).take(MOST_SIGNS).collect()
}

/// The names of a product of several of them, none of which is 0 where the product is not.
fn factors(product: &Value) -> Vec<Value> {
    let names: Vec<Value> = product.variables().iter().map(Value::variable).collect();
    let one_term = product.polynomials().is_some_and(|(above, below)| above.terms().len() == 1 && below.is_one());
    let plain = product.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_)));
    if one_term && plain && names.len() > 1 { names } else { Vec::new() }
}

/// What is found where it is not known which signs divisors have, or in the end the greatest of what is found where each
/// has either.
pub(super) fn in_each_sign<T: Ord>(
    divisors: &[Value],
    known: Assumptions,
    check: &dyn Fn(Assumptions) -> Result<T, Unchecked>,
) -> Result<T, Unchecked> {
    let whole = check(known.clone());
    let (Err(_), Some((divisor, others))) = (&whole, divisors.split_first()) else { return whole };
    let mut greatest = None;
    for relation in [Relation::Gtr, Relation::Lss] {
        let mut known = known.clone();
        known.assume(relation, divisor, &Value::zero());
        if !known.contradictory() {
            greatest = greatest.max(Some(in_each_sign(others, known, check)?));
        }
    }
    greatest.map_or(whole, Ok)
}
