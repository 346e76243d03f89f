//! Equations that never hold because they do not hold modulo some number.

use num_traits::One;

use super::reach::Wanted;
use crate::closed_form::{Recurrence, differ};
use crate::exponential_polynomial::tail::Tail;

/// From which index on two sides are never equal, where a modulus shows that.
pub(super) fn modular(recurrence: &Recurrence, wanted: Wanted<'_>) -> Option<Tail> {
    let shown = differ(recurrence, wanted)?;
    let (index, modulus, length) = (&recurrence.index, shown.modulus, shown.length);
    let times = if shown.times.is_one() { String::new() } else { format!(", times {}^{index},", shown.times) };
    let from = u64::try_from(shown.from).unwrap_or(0);
    let why = format!(
        "modulo {modulus} the sides{times} differ from {index} = {from} on, where the terms come round after {length} steps"
    );
    Some(Tail::Never(from, why))
}
