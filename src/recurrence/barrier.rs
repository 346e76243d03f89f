//! A bound that terms keep once they have come to it: `u(n+1) = f(n)*u(n) + g(n)` with `f(n) >= 0` and
//! `f(n)*b + g(n) <= b` from some index on stays at most b. So a goal beyond the bound is met before, or never.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::numeric::Numeric;
use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{Tail, throughout};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The latest index at which a term is compared with a bound.
const LATEST: u64 = 512;

/// From which index on a bound keeps the terms of a single sequence away from what is wanted.
pub(super) fn barred(recurrence: &Recurrence, wanted: Wanted<'_>) -> Option<Tail> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let ([start], name) = (sequence.start.as_slice(), recurrence.term(&sequence.name, 0)) else { return None };
    let (factor, rest) = sequence.next.linear_in(&name)?;
    let (relation, left, right) = wanted;
    let (weight, offset) = left.sub(right).ok()?.linear_in(&name)?;
    let (weight, offset) = (weight.as_rational()?, offset.as_rational()?);
    if weight.is_zero() || relation == Relation::Neq {
        return None;
    }
    let goal = -offset / &weight;
    let relation = if weight.is_negative() { relation.mirrored() } else { relation };
    let sides: &[bool] = match relation {
        Relation::Gtr | Relation::Gte => &[false],
        Relation::Lss | Relation::Lte => &[true],
        _ => &[false, true],
    };
    let map = Map { factor, rest, index: &recurrence.index };
    let mut numbers: Numeric = Numeric::of(recurrence, wanted)?;
    let (mut term, first, mut next) = (start.as_rational()?, recurrence.from.to_u64()?, recurrence.from.to_u64()?);
    for at in first..=first.checked_add(LATEST)? {
        if numbers.holds()? {
            return None;
        }
        if at == next {
            next = at.max(1) * 2;
            for above in sides {
                // What is not met at a bound is not met beyond it.
                let strict = matches!(relation, Relation::Eq | Relation::Gte | Relation::Lte);
                let bounds = [goal.clone(), term.clone(), BigRational::zero()];
                let kept = |bound: &&BigRational| {
                    let (short, within) =
                        if *above { (*bound >= &goal, &term >= *bound) } else { (*bound <= &goal, &term <= *bound) };
                    short && within && !(strict && **bound == goal) && map.keeps(bound, *above, at).is_some()
                };
                if let Some(bound) = bounds.iter().find(kept) {
                    let sign = if *above { ">=" } else { "<=" };
                    let why =
                        format!("from {} = {at} on each term is {sign} {bound}, since the term before is", map.index);
                    return Some(Tail::Never(at, why));
                }
            }
        }
        numbers.advance()?;
        term = map.image(&term, at)?;
    }
    None
}

struct Map<'a> {
    factor: Value,
    rest: Value,
    index: &'a Name,
}

impl Map<'_> {
    fn image(&self, term: &BigRational, at: u64) -> Option<BigRational> {
        let at = Value::rational(BigRational::from_integer(at.into()));
        let [factor, rest] = [&self.factor, &self.rest].map(|value| value.with(self.index, &at).ok()?.as_rational());
        Some(factor? * term + rest?)
    }

    /// That every term from an index on is on one side of a bound if the term before is.
    fn keeps(&self, bound: &BigRational, above: bool, from: u64) -> Option<()> {
        let bound = Value::rational(bound.clone());
        let beyond = self.factor.mul(&bound).ok()?.add(&self.rest).ok()?.sub(&bound).ok()?;
        let beyond = if above { beyond } else { beyond.neg().ok()? };
        let sure = |value: &Value| {
            // A quotient has the sign of the product of what stands above and below, which is not 0 where it is defined.
            let (above, below) = (value.numerator()?, value.denominator()?);
            let below = ExponentialPolynomial::of(&below, self.index)?;
            let sum = ExponentialPolynomial::of(&above, self.index)?;
            let signs = [Relation::Gtr, Relation::Lss].map(|sign| throughout(&below, sign, from, None));
            let relation = match signs {
                [true, _] => Relation::Gte,
                [_, true] => Relation::Lte,
                _ => return None,
            };
            throughout(&sum, relation, from, None).then_some(())
        };
        sure(&self.factor)?;
        sure(&beyond)
    }
}
