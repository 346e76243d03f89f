//! Terms within a distance of a place, where nothing bounds the distance itself: they would lie on both sides of the ends, and
//! what stays beyond one end is not among them; of whole numbers only a few lie there.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::barrier::kept_away;
use super::late::distance;
use super::modular::modular;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::tail::Tail;
use crate::value::{Atom, Relation, Sum, Value, View};

/// Whole numbers that are looked at.
const MOST_NUMBERS: i64 = 32;

/// That no late term lies so near.
pub(super) fn near(recurrence: &Recurrence, (relation, left, right): Wanted<'_>, known: &Assumptions) -> Option<Tail> {
    let (inner, bound) = distance(&left.sub(right).ok()?, relation)?;
    let zero = Value::zero();
    let end = Value::rational(bound.clone());
    let beyond = |relation: Relation, value: Value| {
        kept_away(recurrence, (relation, &value, &zero), known, true).filter(|found| matches!(found, Tail::Never(..)))
    };
    beyond(Relation::Lte, inner.sub(&end).ok()?)
        .or_else(|| beyond(Relation::Gte, inner.add(&end).ok()?))
        .or_else(|| none_of_few(recurrence, &inner, &bound))
}

/// Of whole numbers those that lie so near, none of which is a late term.
fn none_of_few(recurrence: &Recurrence, inner: &Value, bound: &BigRational) -> Option<Tail> {
    if !recurrence.sequences.iter().all(|one| is_whole(&one.next) && one.start.iter().all(is_whole)) {
        return None;
    }
    // With s*e = t + q, where t is a whole number, it lies between -s*b - q and s*b - q.
    let scale = Value::rational(BigRational::from_integer(denominator(inner)?));
    let scaled = inner.mul(&scale).ok()?;
    let constant = constant(&scaled)?;
    let whole = scaled.sub(&Value::rational(constant.clone())).ok().filter(is_whole)?;
    let reach = bound * scale.as_rational()?;
    let (low, high) = ((-&reach - &constant).ceil().to_integer(), (reach - constant).floor().to_integer());
    let count = (&high - &low).to_i64().filter(|count| *count < MOST_NUMBERS)?;
    let mut from = recurrence.from.to_u64()?;
    for step in 0..=count {
        let number = Value::rational(BigRational::from_integer(&low + BigInt::from(step)));
        match modular(recurrence, (Relation::Eq, &whole, &number))? {
            Tail::Never(since, _) => from = from.max(since),
            Tail::Unknown(_) => return None,
        }
    }
    let index = &recurrence.index;
    Some(Tail::Never(from, format!("from {index} = {from} on {whole} is none of the whole numbers that lie so near")))
}

/// Whether it is a whole number wherever its terms are.
fn is_whole(value: &Value) -> bool {
    let View::Real(numerator, denominator) = value.view() else { return false };
    is_one(&denominator)
        && numerator.iter().all(|(coefficient, atoms)| {
            coefficient.is_integer() && atoms.iter().all(|(atom, _)| matches!(atom, Atom::Variable(_)))
        })
}

fn is_one(denominator: &Sum) -> bool {
    matches!(denominator.as_slice(), [(one, atoms)] if one.is_one() && atoms.is_empty())
}

/// What is added to all else.
fn constant(value: &Value) -> Option<BigRational> {
    let View::Real(numerator, _) = value.view() else { return None };
    let own = numerator.iter().find(|(_, atoms)| atoms.is_empty());
    Some(own.map_or_else(BigRational::zero, |(coefficient, _)| coefficient.clone()))
}

/// What all coefficients but the constant are divided by.
fn denominator(value: &Value) -> Option<BigInt> {
    let View::Real(numerator, below) = value.view() else { return None };
    let parts = numerator.iter().filter(|(_, atoms)| !atoms.is_empty());
    is_one(&below).then(|| parts.fold(BigInt::one(), |all, (coefficient, _)| all.lcm(coefficient.denom())))
}
