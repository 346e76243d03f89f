//! The sign of a number with roots of numbers, from whole numbers of a fixed length: most numbers are far enough from 0 for
//! that, however long their own parts are.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::{Atom, Real, Value};
use crate::polynomial::Monomial;

/// The bits behind the point.
pub(crate) const BITS: usize = 192;
/// The highest exponent of a root.
const MOST_EXPONENT: u32 = 64;

/// How deep roots may stand in one another.
const MOST_NESTED: usize = 8;

/// Between these, over `2^BITS`, a number lies.
pub(crate) type Range = (BigInt, BigInt);

/// A number, not in lowest terms; what is below is positive.
pub(super) type Quotient = (BigInt, BigInt);

/// The square of a number with roots of numbers, if it has any, and its roots of roots with their exponents.
pub(super) type Squared<'a> = (Option<Quotient>, Vec<(&'a Atom, u32)>);

impl Value {
    /// Whether a number with roots of numbers is less or greater than 0; none of anything else, or where that takes
    /// more digits.
    pub(crate) fn coarse_order(&self) -> Option<Ordering> {
        let (top, below) = self.coarse_parts()?;
        let (top, below) = (sign(&top)?, below.map_or(Some(Ordering::Greater), |below| sign(&below))?);
        Some(if below == Ordering::Greater { top } else { top.reverse() })
    }

    /// Where a number with roots of numbers lies, over `2^BITS`; none of anything else.
    pub(super) fn coarse_range(&self) -> Option<Range> {
        let (top, below) = self.coarse_parts()?;
        below.map_or(Some(top.clone()), |below| over(top, below))
    }

    /// Where the numerator lies, and the denominator if there is one.
    fn coarse_parts(&self) -> Option<(Range, Option<Range>)> {
        let (numerator, denominator) = self.parts()?;
        let mut roots = Roots::default();
        let top = roots.between(numerator, MOST_NESTED)?;
        let below = if denominator.is_one() { None } else { Some(roots.between(denominator, MOST_NESTED)?) };
        let any = !numerator.atoms().is_empty() || !denominator.atoms().is_empty();
        any.then_some((top, below))
    }
}

/// The same of a polynomial.
pub(crate) fn coarse_order(polynomial: &Real) -> Option<Ordering> {
    let range = Roots::default().between(polynomial, MOST_NESTED)?;
    if polynomial.atoms().is_empty() { None } else { sign(&range) }
}

fn sign((low, high): &Range) -> Option<Ordering> {
    if low.is_positive() { Some(Ordering::Greater) } else { high.is_negative().then_some(Ordering::Less) }
}

/// The ranges of roots of numbers with roots, each found once.
#[derive(Default)]
struct Roots<'a>(BTreeMap<&'a Atom, Range>);

impl<'a> Roots<'a> {
    /// Where a number with roots of numbers lies, in which roots stand at most so many deep.
    fn between(&mut self, polynomial: &'a Real, nested: usize) -> Option<Range> {
        let mut sum = (BigInt::zero(), BigInt::zero());
        for (monomial, number) in polynomial.terms() {
            let (square, deep) = squared(monomial, number)?;
            let mut term = match square {
                None => scaled(number),
                Some(square) => signed(root(&square)?, number.is_negative()),
            };
            for (atom, exponent) in deep {
                let factor = self.root(atom, nested)?;
                for _ in 0..exponent {
                    term = times(&term, &factor);
                }
            }
            sum = (sum.0 + term.0, sum.1 + term.1);
        }
        Some(sum)
    }

    /// The range of the root of a number with roots, if that is surely not negative.
    fn root(&mut self, atom: &'a Atom, nested: usize) -> Option<Range> {
        if let Some(range) = self.0.get(atom) {
            return Some(range.clone());
        }
        let Atom::Root(inner) = atom else { return None };
        let (numerator, denominator) = inner.parts()?;
        let nested = nested.checked_sub(1)?;
        let mut range = self.between(numerator, nested)?;
        if !denominator.is_one() {
            range = over(range, self.between(denominator, nested)?)?;
        }
        let (low, high) = range;
        let range = (!low.is_negative()).then(|| ((low << BITS).sqrt(), (high << BITS).sqrt() + BigInt::one()))?;
        self.0.insert(atom, range.clone());
        Some(range)
    }
}

/// The quotient by a range that is surely on one side of 0.
fn over((low, high): Range, (below, above): Range) -> Option<Range> {
    if above.is_negative() {
        return over((-high, -low), (-above, -below));
    }
    below.is_positive().then(|| {
        let least = if low.is_negative() { &below } else { &above };
        let most = if high.is_negative() { &above } else { &below };
        ((low << BITS).div_floor(least), (high << BITS).div_floor(most) + BigInt::one())
    })
}

fn root((above, below): &Quotient) -> Option<Range> {
    if above.is_negative() {
        return None;
    }
    let low = ((above << (2 * BITS)) / below).sqrt();
    let high = &low + BigInt::one();
    Some((low, high))
}

/// Where a rational number lies.
pub(crate) fn scaled(number: &BigRational) -> Range {
    let (low, rest) = (number.numer() << BITS).div_mod_floor(number.denom());
    let high = if rest.is_zero() { low.clone() } else { &low + BigInt::one() };
    (low, high)
}

/// The square of a number times roots of numbers, nothing where there are none, and the roots of roots behind it: a
/// small number times the root of a large one has all its digits behind the point.
pub(super) fn squared<'a>(monomial: &'a Monomial<Atom>, number: &BigRational) -> Option<Squared<'a>> {
    let mut square: Option<Quotient> = None;
    let mut nested = Vec::new();
    for (atom, exponent) in monomial.factors() {
        (*exponent <= MOST_EXPONENT).then_some(())?;
        match atom {
            Atom::Root(inner) if let Some(inner) = inner.as_rational() => {
                let (above, below) =
                    square.unwrap_or_else(|| (number.numer() * number.numer(), number.denom() * number.denom()));
                square = Some((above * inner.numer().pow(*exponent), below * inner.denom().pow(*exponent)));
            }
            _ => nested.push((atom, *exponent)),
        }
    }
    Some((square, nested))
}

fn signed((low, high): Range, negative: bool) -> Range {
    if negative { (-high, -low) } else { (low, high) }
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
    fn small_numbers_times_large_roots() {
        // A way of sqrt(104), of which 999/1000 are left in each step: 2.0005 after 1,630 steps, 1.9985 after the next.
        let share = Value::fraction(999, 1000).unwrap();
        for steps in [10, 300, 1_629, 1_630, 1_700] {
            let left = share.power(&Value::integer(steps)).unwrap();
            let parts = [10, 2].map(|part| left.mul(&Value::integer(part)).unwrap());
            let squares = parts[0].mul(&parts[0]).unwrap().add(&parts[1].mul(&parts[1]).unwrap()).unwrap();
            let added = squares.add(&left.mul(&left).unwrap()).unwrap();
            for (square, more) in [(squares, 0.0), (added, 1.0)] {
                let difference = square.sqrt().unwrap().sub(&Value::integer(2)).unwrap();
                let near = (104.0f64 + more).sqrt() * 0.999f64.powi(i32::try_from(steps).unwrap()) - 2.0;
                assert!(near.abs() > 1e-4);
                let wanted = if near > 0.0 { Ordering::Greater } else { Ordering::Less };
                assert_eq!(difference.coarse_order(), Some(wanted), "{steps}");
                if let Some((low, high)) = difference.enclosure() {
                    assert!(low < high && (low.is_positive() == (near > 0.0)));
                }
            }
        }
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
        // Of what is negative there is no root, and very deep ones are left to others.
        assert!(root(&whole(2)).sub(&whole(3)).unwrap().sqrt().is_err());
        let deep = |times: usize| {
            let value = (0..times).fold(whole(2), |value, _| root(&value.add(&whole(1)).unwrap()));
            value.sub(&whole(1)).unwrap().coarse_order()
        };
        assert_eq!(deep(6), Some(Ordering::Greater));
        assert_eq!(deep(12), None);
    }

    #[test]
    fn roots_of_fractions_with_roots() {
        let whole = Value::integer;
        let root = |value: &Value| value.sqrt().unwrap();
        let mut decided = 0;
        for (top, below) in [(3, 5), (-3, 5), (2, -4), (-7, -1)] {
            // (√2 + top) / (√(√3 + 2) + below), where that is positive.
            let above = root(&whole(2)).add(&whole(top)).unwrap();
            let under = root(&root(&whole(3)).add(&whole(2)).unwrap()).add(&whole(below)).unwrap();
            let near = (2f64.sqrt() + top as f64) / ((3f64.sqrt() + 2.0).sqrt() + below as f64);
            let quotient = above.div(&under).unwrap();
            let order = if near < 0.0 { Ordering::Less } else { Ordering::Greater };
            assert_eq!(quotient.coarse_order(), Some(order), "{quotient}");
            if near < 0.0 {
                assert!(quotient.sqrt().is_err());
                continue;
            }
            for (nudge, wanted) in [(-1, Ordering::Greater), (1, Ordering::Less)] {
                let close = Value::fraction((near.sqrt() * 1e6).round() as i64 + 2 * nudge, 1_000_000).unwrap();
                let difference = root(&quotient).sub(&close).unwrap();
                assert_eq!(difference.coarse_order(), Some(wanted), "{difference}");
                decided += 1;
            }
        }
        assert!(decided >= 2);
    }
}
