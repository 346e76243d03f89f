//! The first index of a sequence that grows until it becomes another, which has what is asked for at once: it comes near
//! before it is there, or as it is.

use super::Reach;
use super::interval::Interval;
use super::search::Entry;
use crate::value::{Atom, Relation, Value};

impl Entry<'_> {
    /// The first index `at` of this interval, or the end where that comes first, if the end has it too and no index
    /// before the end is beyond the interval.
    pub(super) fn up_to_end(&self, at: &Value, interval: &Interval) -> Option<Reach> {
        let until = self.until.filter(|_| self.at_end)?;
        let known = |relation, one: &Value, other: &Value| self.known.decide(relation, one, other) == Some(true);
        let end = not_rounded(until).unwrap_or_else(|| until.clone());
        // Whole numbers are before the end if they are before what it is rounded from.
        if interval.bound(false).is_some_and(|(high, _)| !known(Relation::Lte, &end, high)) {
            return None;
        }
        let (low, strict) = interval.bound(true)?;
        let rounded = known(if *strict { Relation::Lss } else { Relation::Lte }, low, &end);
        let never_later = rounded && known(Relation::Lte, self.from, until) || known(Relation::Lte, at, until);
        let first = if never_later { at.clone() } else { Value::minimum(&[at.clone(), until.clone()]).ok()? };
        Some(Reach::At(first, Vec::new()))
    }
}

/// x, where the value is x rounded up: `y - 1` of `ceil(y) - 1`.
pub(super) fn not_rounded(value: &Value) -> Option<Value> {
    let opposite = value.neg().ok()?;
    opposite.atoms().iter().find_map(|atom| {
        let Atom::Floor(inner) = atom else { return None };
        let rest = opposite.sub(&atom.value().ok()?).ok()?;
        let whole = rest.as_rational().is_some_and(|rest| rest.is_integer());
        whole.then(|| inner.add(&rest).and_then(|sum| sum.neg()).ok()).flatten()
    })
}
