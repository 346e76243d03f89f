//! What is known of values that were drawn from continuous distributions: between which bounds they lie.
//!
//! A comparison of what depends on one such value by a straight line is decided where the bounds leave no doubt. Where
//! they do, the place in doubt is noted, so that it may be asked for smaller bounds. A value is on no given bound: that
//! has no chance.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::draw::is_drawn;
use crate::name::Name;
use crate::value::Value;

/// Two bounds; none where there is no bound.
pub(crate) type Bounds = (Option<BigRational>, Option<BigRational>);

/// The bounds of drawn values, by their symbols.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    known: RefCell<BTreeMap<Name, Bounds>>,
    doubt: RefCell<Option<(Name, BigRational)>>,
}

impl Cells {
    /// Notes that this value lies strictly between these bounds.
    pub(crate) fn learn(&self, symbol: &Name, bounds: Bounds) {
        self.known.borrow_mut().insert(symbol.clone(), bounds);
    }

    /// The symbol and the place that left the last comparison in doubt; forgotten then.
    pub(crate) fn take_doubt(&self) -> Option<(Name, BigRational)> {
        self.doubt.borrow_mut().take()
    }

    /// The value as a straight line of one symbol of which bounds are known: symbol, factor, shift.
    pub(crate) fn line(&self, value: &Value) -> Option<(Name, BigRational, BigRational)> {
        let mut names = value.variables().into_iter();
        let (Some(name), None) = (names.next(), names.next()) else { return None };
        if !is_drawn(&name) || !self.known.borrow().contains_key(&name) {
            return None;
        }
        let (factor, shift) = value.linear_in(&name)?;
        let (factor, shift) = (factor.as_rational()?, shift.as_rational()?);
        (!factor.is_zero()).then_some((name, factor, shift))
    }

    /// On which side of this number the symbol lies; in doubt none.
    fn side(&self, symbol: &Name, number: &BigRational) -> Option<Ordering> {
        match self.known.borrow().get(symbol)? {
            (Some(low), _) if number <= low => Some(Ordering::Greater),
            (_, Some(high)) if number >= high => Some(Ordering::Less),
            _ => None,
        }
    }

    /// The order of two values of which one at least depends on a draw.
    pub(super) fn order(&self, left: &Value, right: &Value) -> Option<Ordering> {
        if self.known.borrow().is_empty() {
            return None;
        }
        let (symbol, factor, shift) = self.line(&left.sub(right).ok()?)?;
        let root = -shift / &factor;
        match self.side(&symbol, &root) {
            Some(side) => Some(if factor.is_negative() { side.reverse() } else { side }),
            None => {
                *self.doubt.borrow_mut() = Some((symbol, root));
                None
            }
        }
    }

    /// Between which of these numbers, in order, the value lies.
    ///
    /// # Errors
    /// The symbol that it depends on, and the place of it that is in doubt.
    pub(crate) fn between(
        &self,
        (symbol, factor, shift): &(Name, BigRational, BigRational),
        numbers: &[BigRational],
    ) -> Result<usize, (Name, BigRational)> {
        let mut below = 0;
        for number in numbers {
            let place = (number - shift) / factor;
            let Some(side) = self.side(symbol, &place) else { return Err((symbol.clone(), place)) };
            below += usize::from((side == Ordering::Greater) != factor.is_negative());
        }
        Ok(below)
    }
}
