//! The first index at which a polynomial in it compares with 0: its sign changes at its roots alone, so an index next to a
//! root, or the very first, is the first one.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Reach;
use super::product::quotient;
use crate::closed_form::Piece;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Relation, Value};

/// The highest degree of a polynomial, and the most bits of its coefficients together.
const MOST_DEGREE: usize = 40;
const MOST_BITS: u64 = 1 << 14;

/// The first index at which a value compares with 0, where it is a polynomial with rational coefficients in each piece.
pub(super) fn between_roots(pieces: &[Piece], index: &Name, relation: Relation) -> Option<Reach> {
    // All later indices must be looked at before it can be said that none compares so.
    pieces.last().filter(|last| last.until.is_none())?;
    for piece in pieces {
        let whole = |value: &Value| value.as_rational().filter(BigRational::is_integer).map(|at| at.to_integer());
        let from = whole(&piece.from)?;
        let until = match &piece.until {
            Some(until) => Some(whole(until)?),
            None => None,
        };
        let [polynomial, below] = quotient(&piece.form, index)?;
        let bits = |number: &BigRational| number.numer().bits() + number.denom().bits();
        let bits: u64 = polynomial.coefficients().iter().map(bits).sum();
        if below.degree() > 0 || polynomial.degree() > MOST_DEGREE || bits > MOST_BITS {
            return None;
        }
        let polynomial = polynomial.scale(&below.coefficient(0).recip());
        let holds = |at: &&BigInt| relation.holds(sign(&polynomial, at));
        let mut candidates = vec![from.clone()];
        candidates.extend(units(&polynomial, &from).into_iter().flat_map(|unit| [unit.clone(), unit + BigInt::one()]));
        let within = |at: &&BigInt| **at >= from && until.as_ref().is_none_or(|until| *at < until);
        if let Some(first) = candidates.iter().filter(within).filter(holds).min() {
            return Some(Reach::At(Value::rational(BigRational::from_integer(first.clone())), Vec::new()));
        }
    }
    Some(Reach::Never(format!(
        "the difference of both sides is a polynomial in {index}: its sign changes at its roots alone, and next to none of \
         these does it compare so"
    )))
}

fn sign(polynomial: &Univariate, at: &BigInt) -> Ordering {
    polynomial.at(&BigRational::from_integer(at.clone())).cmp(&BigRational::zero())
}

/// Whole numbers b in order, such that every root that is not less than the first index lies in some `[b, b+1)`: next
/// to those of the derivative, or where the polynomial, which is monotone between these, changes its sign.
fn units(polynomial: &Univariate, from: &BigInt) -> Vec<BigInt> {
    if polynomial.degree() == 0 {
        return Vec::new();
    }
    let turns = units(&polynomial.derivative(), from);
    let last = beyond(polynomial).max(from.clone());
    let mut all = Vec::new();
    let mut low = from.clone();
    for turn in &turns {
        all.extend(crossing(polynomial, &low, turn));
        all.push(turn.clone());
        low = turn + BigInt::one();
    }
    all.extend(crossing(polynomial, &low, &last));
    all
}

/// Where a polynomial that is monotone between two whole numbers has its root there, if it has one.
fn crossing(polynomial: &Univariate, low: &BigInt, high: &BigInt) -> Option<BigInt> {
    if low > high {
        return None;
    }
    let (mut low, mut high) = (low.clone(), high.clone());
    let (first, last) = (sign(polynomial, &low), sign(polynomial, &high));
    if last == Ordering::Equal {
        return Some(high);
    }
    if first == last {
        return None;
    }
    while &high - &low > BigInt::one() {
        let middle: BigInt = (&low + &high) >> 1;
        if sign(polynomial, &middle) == last {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(low)
}

/// A number that is greater than every root: 1 more than the greatest quotient of a coefficient by the leading one.
fn beyond(polynomial: &Univariate) -> BigInt {
    let leading = polynomial.coefficient(polynomial.degree());
    let greatest = polynomial.coefficients().iter().map(|number| (number / &leading).abs()).max();
    greatest.unwrap_or_else(BigRational::zero).ceil().to_integer() + BigInt::from(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::univariate::polynomial;

    #[test]
    fn it_finds_what_a_look_at_every_index_finds() {
        let mut seed = 1u64;
        let mut random = |most: i64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            i64::try_from((seed >> 33) % u64::try_from(2 * most + 1).unwrap()).unwrap() - most
        };
        let index = Name::new("n");
        let relations = [Relation::Eq, Relation::Neq, Relation::Lss, Relation::Lte, Relation::Gtr, Relation::Gte];
        let (mut found, mut never) = (0, 0);
        for round in 0..400 {
            let roots: Vec<i64> = (0..round % 4 + 1).map(|_| random(12)).collect();
            let mut all = roots.iter().fold(polynomial(&[random(3)]), |all, root| all.times(&polynomial(&[-root, 1])));
            if round % 3 == 0 {
                all = all.plus(&polynomial(&[random(4)]));
            }
            let form = crate::recurrence::product::value_of(&all, &Value::variable(&index)).unwrap();
            let piece = Piece { from: Value::zero(), until: None, form };
            if all.is_zero() {
                continue;
            }
            for relation in relations {
                let by_hand = (0..200i64).find(|at| relation.holds(sign(&all, &BigInt::from(*at))));
                match (between_roots(std::slice::from_ref(&piece), &index, relation), by_hand) {
                    (Some(Reach::At(at, _)), Some(wanted)) => {
                        assert_eq!(at, Value::integer(wanted), "{all:?} {relation:?}");
                        found += 1;
                    }
                    (Some(Reach::Never(_)), None) => never += 1,
                    (other, wanted) => panic!("{all:?} {relation:?}: {other:?}, {wanted:?}"),
                }
            }
        }
        assert!(found > 1_000 && never > 100, "{found} {never}");
    }
}
