//! Where a value is to lie: between two bounds.

use super::Unknown;
use super::powers::Numbers;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The values between two bounds, each with whether it is excluded.
#[derive(Clone, Debug)]
pub(super) struct Interval {
    pub(super) low: Option<(Value, bool)>,
    pub(super) high: Option<(Value, bool)>,
}

impl Interval {
    /// What stands in the relation to 0; for `!=`, everything.
    pub(super) fn of(relation: Relation) -> Interval {
        let bound = |strict: bool| Some((Value::zero(), strict));
        let (low, high) = match relation {
            Relation::Eq => (bound(false), bound(false)),
            Relation::Gtr => (bound(true), None),
            Relation::Gte => (bound(false), None),
            Relation::Lss => (None, bound(true)),
            Relation::Lte => (None, bound(false)),
            Relation::Neq => (None, None),
        };
        Interval { low, high }
    }

    /// From one value to another, both included.
    pub(super) fn between(low: Value, high: Value) -> Interval {
        Interval { low: Some((low, false)), high: Some((high, false)) }
    }

    /// What lies between bounds, of which the first is the lower one, or the upper.
    pub(super) fn of_bounds(low: bool, first: Option<(Value, bool)>, second: Option<(Value, bool)>) -> Interval {
        if low { Interval { low: first, high: second } } else { Interval { low: second, high: first } }
    }

    /// What is between two values, neither of them included.
    pub(super) fn inside(low: Option<Value>, high: Option<Value>) -> Interval {
        Interval { low: low.map(|low| (low, true)), high: high.map(|high| (high, true)) }
    }

    /// The part of an open interval where an affine expression stands in the relation to 0.
    pub(super) fn where_affine(
        self,
        affine: &Value,
        variable: &Name,
        relation: Relation,
        known: &Assumptions,
    ) -> Result<Option<Interval>, Unknown> {
        let Some((factor, rest)) = affine.linear_in(variable) else {
            return Err(Unknown::because(format!("{affine} is not affine in {variable}")));
        };
        let zero = Value::zero();
        if known.decide(Relation::Eq, &factor, &zero) == Some(true) {
            let holds =
                known.decide(relation, &rest, &zero).ok_or_else(|| Unknown::undecided(relation, &rest, &zero))?;
            return Ok(holds.then_some(self));
        }
        let positive = known.decide(Relation::Gtr, &factor, &zero) == Some(true);
        if !positive && known.decide(Relation::Lss, &factor, &zero) != Some(true) {
            return Err(Unknown::undecided(Relation::Gtr, &factor, &zero));
        }
        let wanted = Interval::of(relation).pulled_back(&rest, &factor, positive)?;
        // The tighter of two bounds; where they are equal the open one, which is that of the interval itself.
        let tighter = |own: &Option<(Value, bool)>, other: &Option<(Value, bool)>, tight: Relation| match (own, other) {
            (Some((a, _)), Some((b, _))) => match known.decide(tight, a, b) {
                Some(true) => Ok(own.clone()),
                Some(false) => Ok(other.clone()),
                None => Err(Unknown::undecided(tight, a, b)),
            },
            (own, other) => Ok(own.clone().or(other.clone())),
        };
        let low = tighter(&self.low, &wanted.low, Relation::Gte)?;
        let high = tighter(&self.high, &wanted.high, Relation::Lte)?;
        if let (Some((low, first)), Some((high, second))) = (&low, &high) {
            let relation = if *first || *second { Relation::Lss } else { Relation::Lte };
            match known.decide(relation, low, high) {
                Some(true) => {}
                Some(false) => return Ok(None),
                None => return Err(Unknown::undecided(relation, low, high)),
            }
        }
        Ok(Some(Interval { low, high }))
    }

    /// The union with an interval that begins where this one ends; else this one.
    pub(super) fn joined(self, next: &Interval) -> Result<Interval, Interval> {
        match (&self.high, &next.low) {
            (Some((end, first)), Some((begin, second))) if end == begin && !(*first && *second) => {
                Ok(Interval { low: self.low, high: next.high.clone() })
            }
            _ => Err(self),
        }
    }

    /// The interval of y where `base + factor*y` lies in this one; the factor is positive or negative.
    pub(super) fn pulled_back(&self, base: &Value, factor: &Value, positive: bool) -> Result<Interval, Unknown> {
        let back = |bound: &Option<(Value, bool)>| -> Result<Option<(Value, bool)>, Unknown> {
            match bound {
                None => Ok(None),
                Some((value, strict)) => Ok(Some((value.sub(base)?.div(factor)?, *strict))),
            }
        };
        let (low, high) = (back(&self.low)?, back(&self.high)?);
        Ok(if positive { Interval { low, high } } else { Interval { low: high, high: low } })
    }

    /// Its lower bound, or its upper.
    pub(super) fn bound(&self, low: bool) -> Option<&(Value, bool)> {
        if low { self.low.as_ref() } else { self.high.as_ref() }
    }

    pub(super) fn numbers(&self) -> Option<Numbers> {
        let number = |bound: &Option<(Value, bool)>| match bound {
            None => Some(None),
            Some((value, strict)) => value.as_rational().map(|value| Some((value, *strict))),
        };
        Some(Numbers { low: number(&self.low)?, high: number(&self.high)? })
    }

    /// Whether a value lies in it.
    pub(super) fn holds(&self, value: &Value, known: &Assumptions) -> Option<bool> {
        if let (Some((wanted, _)), true) = (&self.low, self.is_point()) {
            return known.decide(Relation::Eq, value, wanted);
        }
        let above = self
            .low
            .as_ref()
            .map(|(low, strict)| known.decide(if *strict { Relation::Gtr } else { Relation::Gte }, value, low));
        let below = self
            .high
            .as_ref()
            .map(|(high, strict)| known.decide(if *strict { Relation::Lss } else { Relation::Lte }, value, high));
        match (above.unwrap_or(Some(true)), below.unwrap_or(Some(true))) {
            (Some(false), _) | (_, Some(false)) => Some(false),
            (Some(true), Some(true)) => Some(true),
            _ => None,
        }
    }

    pub(super) fn is_point(&self) -> bool {
        matches!((&self.low, &self.high), (Some((low, false)), Some((high, false))) if low == high)
    }
}
