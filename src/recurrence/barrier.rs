//! A bound that terms keep once they have come to it: `u(n+1) = f(n)*u(n) + g(n)` with `f(n) >= 0` and
//! `f(n)*b + g(n) <= b` from some index on stays at most b, and so does any other map of which the assumptions decide it.
//! So a goal beyond the bound is met before, or never.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::numeric::Numeric;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{Tail, throughout};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The latest index at which a term is compared with a bound.
const LATEST: u64 = 512;
/// The most bits of a term: of a square the terms double in length, and a bound that long decides nothing in time.
const LONGEST: u64 = 4_096;

/// From which index on a bound keeps the terms of a single sequence away from what is wanted.
pub(super) fn barred(recurrence: &Recurrence, wanted: Wanted<'_>, known: &Assumptions) -> Option<Tail> {
    kept_away(recurrence, wanted, known, false)
}

/// The same, or where it is met earlier (`later`), from which index on no further term is.
pub(super) fn kept_away(recurrence: &Recurrence, wanted: Wanted<'_>, known: &Assumptions, later: bool) -> Option<Tail> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let ([start], name) = (sequence.start.as_slice(), recurrence.term(&sequence.name, 0)) else { return None };
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
    let map = Map { next: &sequence.next, name: &name, index: &recurrence.index, known };
    let mut numbers: Numeric = Numeric::of(recurrence, wanted)?;
    let (mut term, first, mut next) = (start.as_rational()?, recurrence.from.to_u64()?, recurrence.from.to_u64()?);
    for at in first..=first.checked_add(LATEST)? {
        let holds = numbers.holds()?;
        if holds && !later {
            return None;
        }
        if at >= next && !holds {
            next = at.max(1) * 2;
            for above in sides {
                // What is not met at a bound is not met beyond it.
                let strict = matches!(relation, Relation::Eq | Relation::Gte | Relation::Lte);
                let bounds = [goal.clone(), term.clone(), BigRational::zero()];
                let kept = |bound: &&BigRational| {
                    let (short, within) =
                        if *above { (*bound >= &goal, &term >= *bound) } else { (*bound <= &goal, &term <= *bound) };
                    short && within && !(strict && **bound == goal) && map.keeps(bound, *above, at)
                };
                if let Some(bound) = bounds.iter().find(kept) {
                    let sign = if *above { ">=" } else { "<=" };
                    let why =
                        format!("from {} = {at} on each term is {sign} {bound}, since the term before is", map.index);
                    return Some(Tail::Never(at, why));
                }
                let size = term.abs();
                let short = if *above { -&size >= goal } else { size <= goal };
                if short && !(strict && size == goal.abs()) && map.keeps_within(&size, at) == Some(true) {
                    let index = map.index;
                    let why = format!("from {index} = {at} on no term is larger than {size}, nor less than {}", -&size);
                    return Some(Tail::Never(at, format!("{why}, since the term before is not")));
                }
            }
        }
        numbers.advance()?;
        term = map.image(&term, at)?;
        if term.numer().bits() + term.denom().bits() > LONGEST {
            return None;
        }
    }
    None
}

struct Map<'a> {
    next: &'a Value,
    name: &'a Name,
    index: &'a Name,
    known: &'a Assumptions,
}

impl Map<'_> {
    fn image(&self, term: &BigRational, at: u64) -> Option<BigRational> {
        let at = Value::rational(BigRational::from_integer(at.into()));
        self.next.with(self.index, &at).ok()?.with(self.name, &Value::rational(term.clone())).ok()?.as_rational()
    }

    /// That every term from an index on is on one side of a bound if the term before is.
    fn keeps(&self, bound: &BigRational, above: bool, from: u64) -> bool {
        let bound = Value::rational(bound.clone());
        self.keeps_linearly(&bound, above, from) == Some(true) || self.keeps_somehow(&bound, above, from)
    }

    /// By what is assumed of a term and its index.
    fn keeps_somehow(&self, bound: &Value, above: bool, from: u64) -> bool {
        let relation = if above { Relation::Gte } else { Relation::Lte };
        let mut known = self.known.without_name(self.name).without_name(self.index);
        known.assume_natural(self.index);
        let from = Value::rational(BigRational::from_integer(from.into()));
        known.assume(Relation::Gte, &Value::variable(self.index), &from);
        known.assume(relation, &Value::variable(self.name), bound);
        known.decide(relation, &known.simplify(self.next), bound) == Some(true)
    }

    fn keeps_linearly(&self, bound: &Value, above: bool, from: u64) -> Option<bool> {
        let (factor, rest) = self.next.linear_in(self.name)?;
        let beyond = factor.mul(bound).ok()?.add(&rest).ok()?.sub(bound).ok()?;
        let beyond = if above { beyond } else { beyond.neg().ok()? };
        Some(self.never_negative(&factor, from)? && self.never_negative(&beyond, from)?)
    }

    /// That no term from an index on is larger than this, nor less than its opposite, if the term before is not: what is linear
    /// in it is largest and least at the ends.
    fn keeps_within(&self, size: &BigRational, from: u64) -> Option<bool> {
        let (factor, rest) = self.next.linear_in(self.name)?;
        let size = Value::rational(size.clone());
        let most = factor.mul(&size).ok()?;
        for far in [most.clone(), most.neg().ok()?] {
            let end = far.add(&rest).ok()?;
            let room = [size.sub(&end).ok()?, size.add(&end).ok()?];
            if !room.iter().all(|room| self.never_negative(room, from) == Some(true)) {
                return None;
            }
        }
        Some(true)
    }

    /// Whether a value of the index is at least 0 from an index on.
    fn never_negative(&self, value: &Value, from: u64) -> Option<bool> {
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
        Some(throughout(&sum, relation, from, None))
    }
}
