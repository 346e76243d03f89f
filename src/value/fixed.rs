//! The sign of a number with roots of numbers, from whole numbers of a fixed length: most numbers are far enough from 0 for
//! that, however long their own parts are.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::{Atom, Real, Value};

/// The bits behind the point.
const BITS: usize = 192;
/// The highest exponent of a root.
const MOST_EXPONENT: u32 = 64;

/// How deep roots may stand in one another.
const MOST_NESTED: usize = 3;

/// Between these, over `2^BITS`, a number lies.
type Range = (BigInt, BigInt);

impl Value {
    /// Whether a number with roots of numbers is less or greater than 0; none of anything else, or where that takes
    /// more digits.
    pub(crate) fn coarse_order(&self) -> Option<Ordering> {
        let (numerator, denominator) = self.parts()?;
        let roots = roots(numerator.atoms().into_iter().chain(denominator.atoms()), MOST_NESTED)?;
        if roots.is_empty() {
            return None;
        }
        let top = sign(&between(numerator, &roots)?)?;
        let below = if denominator.is_one() { Ordering::Greater } else { sign(&between(denominator, &roots)?)? };
        Some(if below == Ordering::Greater { top } else { top.reverse() })
    }
}

/// The same of a polynomial.
pub(crate) fn coarse_order(polynomial: &Real) -> Option<Ordering> {
    let roots = roots(polynomial.atoms().into_iter(), MOST_NESTED)?;
    if roots.is_empty() { None } else { sign(&between(polynomial, &roots)?) }
}

fn sign((low, high): &Range) -> Option<Ordering> {
    if low.is_positive() { Some(Ordering::Greater) } else { high.is_negative().then_some(Ordering::Less) }
}

/// The ranges of roots, and of the roots in them so many deep.
fn roots<'a>(atoms: impl Iterator<Item = &'a Atom>, nested: usize) -> Option<BTreeMap<&'a Atom, Range>> {
    let mut roots = BTreeMap::new();
    for atom in atoms {
        let Atom::Root(inner) = atom else { return None };
        if !roots.contains_key(atom) {
            let range = inner.as_rational().map_or_else(|| root_of_roots(inner, nested), |number| root(&number))?;
            roots.insert(atom, range);
        }
    }
    Some(roots)
}

/// The range of the root of a number with roots, if that is surely not negative.
fn root_of_roots(inner: &Value, nested: usize) -> Option<Range> {
    let (numerator, _) = inner.parts().filter(|(_, denominator)| denominator.is_one())?;
    let inside = roots(numerator.atoms().into_iter(), nested.checked_sub(1)?)?;
    let (low, high) = between(numerator, &inside)?;
    (!low.is_negative()).then(|| ((low << BITS).sqrt(), (high << BITS).sqrt() + BigInt::one()))
}

fn root(number: &BigRational) -> Option<Range> {
    if number.is_negative() {
        return None;
    }
    let low = ((number.numer() << (2 * BITS)) / number.denom()).sqrt();
    let high = &low + BigInt::one();
    Some((low, high))
}

fn range(number: &BigRational) -> Range {
    let scaled = number.numer() << BITS;
    let low = scaled.div_floor(number.denom());
    let high = if number.is_integer() { low.clone() } else { &low + BigInt::one() };
    (low, high)
}

fn between(polynomial: &Real, roots: &BTreeMap<&Atom, Range>) -> Option<Range> {
    let mut sum = (BigInt::zero(), BigInt::zero());
    for (monomial, number) in polynomial.terms() {
        let mut term = range(number);
        for (atom, exponent) in monomial.factors() {
            (*exponent <= MOST_EXPONENT).then_some(())?;
            let factor = roots.get(atom)?;
            for _ in 0..*exponent {
                term = times(&term, factor);
            }
        }
        sum = (sum.0 + term.0, sum.1 + term.1);
    }
    Some(sum)
}

/// The product with a range that is not negative.
fn times((low, high): &Range, factor: &Range) -> Range {
    let least = low * if low.is_negative() { &factor.1 } else { &factor.0 };
    let most = high * if high.is_negative() { &factor.0 } else { &factor.1 };
    // A shift to the right goes down.
    (least >> BITS, (most >> BITS) + BigInt::one())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_agrees_with_the_enclosure() {
        let number = |top: i64, bottom: i64| Value::fraction(top, bottom).unwrap();
        let roots = [2, 3, 10].map(|inner| Value::integer(inner).sqrt().unwrap());
        let mut decided = 0;
        for one in -9..10 {
            for other in -9..10i64 {
                for (place, root) in roots.iter().enumerate() {
                    let product = root.mul(&roots[(place + 1) % 3]).unwrap().mul(&number(other, 5)).unwrap();
                    let below = root.add(&number(one, 2)).unwrap();
                    let value = product.add(&number(one, 7)).unwrap().div(&below).unwrap();
                    let Some(order) = value.coarse_order() else { continue };
                    let (low, high) = value.enclosure().unwrap();
                    assert_eq!(
                        (order == Ordering::Greater, order == Ordering::Less),
                        (low.is_positive(), high.is_negative())
                    );
                    decided += 1;
                }
            }
        }
        assert!(decided > 900, "{decided}");
        let near = roots[0].sub(&number(665_857, 470_832)).unwrap();
        assert_eq!(near.coarse_order(), Some(Ordering::Less));
    }

    #[test]
    fn roots_in_roots() {
        let whole = Value::integer;
        let root = |value: &Value| value.sqrt().unwrap();
        // 143 - 32 √13 = 27.6…, of which the root is 5.25….
        let inner = whole(143).sub(&root(&whole(13)).mul(&whole(32)).unwrap()).unwrap();
        let nested = root(&inner);
        for (top, bottom, wanted) in [(525, 100, Ordering::Greater), (526, 100, Ordering::Less)] {
            let near = Value::fraction(top, bottom).unwrap();
            let value = nested.sub(&near).unwrap();
            let squares = inner.sub(&near.mul(&near).unwrap()).unwrap();
            assert_eq!(value.coarse_order(), Some(wanted), "{value}");
            assert_eq!(squares.coarse_order(), Some(wanted), "{squares}");
        }
        // Of what is negative there is no root, and deep ones are left to others.
        let negative = root(&root(&whole(2)).sub(&whole(3)).unwrap());
        assert_eq!(negative.coarse_order(), None);
        let deep = (0..6).fold(whole(2), |value, _| root(&value.add(&whole(1)).unwrap()));
        assert_eq!(deep.sub(&whole(1)).unwrap().coarse_order(), None);
    }
}
