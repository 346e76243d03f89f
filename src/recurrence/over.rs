//! Quotients of functions of the index: where what is divided by has one sign at all indices, a quotient is beyond a bound
//! just where its numerator is beyond as many times the denominator.

use super::interval::Interval;
use super::never::for_none;
use super::search::{Entry, enter};
use super::{Reach, Unknown};
use crate::value::{Relation, Value};

/// When a quotient comes to one side of a bound first, or meets it; `None` of any other question.
pub(super) fn of_quotient(entry: &Entry<'_>) -> Option<Result<Reach, Unknown>> {
    let (above, below) = (entry.value.numerator()?, entry.value.denominator()?);
    if !below.mentions(entry.index) {
        return None;
    }
    let (relation, bound) = match (entry.interval.bound(true), entry.interval.bound(false)) {
        (Some((low, strict)), None) => (if *strict { Relation::Gtr } else { Relation::Gte }, low),
        (None, Some((high, strict))) => (if *strict { Relation::Lss } else { Relation::Lte }, high),
        (Some((low, false)), Some((high, false))) if low == high => (Relation::Eq, low),
        _ => return None,
    };
    let (count, mut known) = (Value::variable(entry.index), entry.known.clone());
    known.assume(Relation::Gte, &count, entry.from);
    if let Some(until) = entry.until {
        known.assume(Relation::Lss, &count, until);
    }
    let sign = |relation| known.decide(relation, &below, &Value::zero()) == Some(true);
    let relation = match (sign(Relation::Gtr), sign(Relation::Lss)) {
        (true, _) => relation,
        (_, true) => relation.mirrored(),
        _ => return None,
    };
    let value = above.sub(&bound.mul(&below).ok()?).ok()?;
    Some(match enter(&Entry { value, interval: Interval::of(relation), ..*entry }) {
        // Why the numerator never does says nothing of the quotient.
        Ok(Reach::Never(_)) => Ok(Reach::Never(for_none(entry, &known))),
        found => found,
    })
}
