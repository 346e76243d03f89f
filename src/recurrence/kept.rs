//! That no term is met because each keeps what the one before keeps: a side of the goal, or bounds that the first terms, and
//! what the map leaves where it is, suggest. What is found is checked by induction (`closed_form`).

use num_rational::BigRational;

use super::behaviour;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::{Never, Recurrence, never};
use crate::exponential_polynomial::tail::Tail;
use crate::value::Value;

/// The terms of which the least and the greatest may be bounds.
const FEW: usize = 8;

/// From which index on no term is met, by induction.
pub(super) fn kept(
    recurrence: &Recurrence,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Tail> {
    let by = |bounds: &[Value]| match never(recurrence, None, wanted, (known, bounds)).ok()? {
        Never::Induction(from) => Some(from),
        _ => None,
    };
    let from = by(&[]).or_else(|| {
        let mut bounds = ends(recurrence);
        bounds.extend(behaviour(recurrence, known, stop).fixed_points);
        by(&bounds)
    })?;
    let index = &recurrence.index;
    let from = u64::try_from(from).ok()?;
    Some(Tail::Never(from, format!("from {index} = {from} on, if one term is not, the next is not")))
}

/// The least and the greatest of the first terms of a single sequence.
fn ends(recurrence: &Recurrence) -> Vec<Value> {
    let terms = recurrence.iterate(FEW).ok().filter(|all| all.len() == 1).unwrap_or_default();
    let numbers: Option<Vec<BigRational>> = terms.concat().iter().map(Value::as_rational).collect();
    let numbers = numbers.unwrap_or_default();
    let ends = [numbers.iter().min(), numbers.iter().max()];
    ends.into_iter().flatten().cloned().map(Value::rational).collect()
}
