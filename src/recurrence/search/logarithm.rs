//! When powers with symbols come to a bound: a logarithm, which no value here is.

use super::Entry;
use crate::closed_form::bracketed;
use crate::recurrence::NoClosedForm;
use crate::value::{Relation, Value};

/// What a reason ends on where the first index is known, but not as a value.
pub(crate) const NO_VALUE: &str = "logarithms are no values here";

impl Entry<'_> {
    /// The least index at which `limit + factor*ratio^n` is in the interval, where it surely is from some index on.
    pub(super) fn logarithm(
        &self,
        limit: &Value,
        factor: &Value,
        ratio: &Value,
    ) -> Result<Option<String>, NoClosedForm> {
        let zero = Value::zero();
        let surely = |relation, one: &Value, other: &Value| self.known.decide(relation, one, other) == Some(true);
        let falls = surely(Relation::Gtr, ratio, &zero) && surely(Relation::Lss, ratio, &Value::one());
        if self.until.is_some() || !self.from.is_zero() || !(falls || surely(Relation::Gtr, ratio, &Value::one())) {
            return Ok(None);
        }
        let (above, below) = (surely(Relation::Gtr, factor, &zero), surely(Relation::Lss, factor, &zero));
        // By how much the bound is away from the limit, and whether it is excluded.
        let (far, strict) = match (&self.interval.low, &self.interval.high) {
            (Some((low, false)), Some((high, false))) if falls && limit.sub(low)? == high.sub(limit)? => {
                (high.sub(limit)?, false)
            }
            (None, Some((high, strict))) if falls && above => (high.sub(limit)?, *strict),
            (Some((low, strict)), None) if falls && below => (limit.sub(low)?, *strict),
            (Some((low, strict)), None) if !falls && above => (low.sub(limit)?, *strict),
            (None, Some((high, strict))) if !falls && below => (limit.sub(high)?, *strict),
            _ => return Ok(None),
        };
        if !surely(Relation::Gtr, &far, &zero) {
            return Ok(None);
        }
        let relation = match (falls, strict) {
            (true, false) => "<=",
            (true, true) => "<",
            (false, false) => ">=",
            (false, true) => ">",
        };
        let (size, index) = (self.known.simplify(&factor.abs()?), self.index);
        let power = format!("({ratio})^{index}");
        let text = |value: &Value| bracketed(value.to_string());
        let (power, part) = if size == Value::one() {
            (power, format!("log({far})"))
        } else {
            (format!("{}*{power}", text(&size)), format!("log({}/({size}))", text(&far)))
        };
        let least = format!("{part}/log({ratio})");
        let least = if strict { format!("floor({least})+1") } else { format!("ceil({least})") };
        Ok(Some(format!(
            "the first is the least {index} with {power} {relation} {far}: 0 if {size} {relation} {far}, else {least}, \
             and {NO_VALUE}",
        )))
    }
}
