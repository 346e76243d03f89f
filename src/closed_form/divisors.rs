//! Divisors of which it is known only that they are not 0: each sign is looked at by itself.

use std::collections::BTreeSet;

use super::{Recurrence, Unchecked};
use crate::assumption::Assumptions;
use crate::value::{Need, Relation, Value};

/// The most divisors of which either sign is looked at by itself.
const MOST_SIGNS: usize = 2;

/// What these, or the first values, divide by that is known not to be 0, and of which no sign is known.
pub(super) fn divisors(values: &[&Value], recurrence: &Recurrence, known: &Assumptions) -> Vec<Value> {
    let starts = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
    let needs: BTreeSet<Need> = values.iter().copied().chain(starts).flat_map(Value::needs).collect();
    let open = |need: Need| match need {
        Need::Nonzero(divisor) => Some(divisor).filter(|divisor| {
            let is = |relation: Relation| known.decide(relation, divisor, &Value::zero());
            is(Relation::Neq) == Some(true) && is(Relation::Gtr).is_none()
        }),
        _ => None,
    };
    needs.into_iter().filter_map(open).take(MOST_SIGNS).collect()
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
