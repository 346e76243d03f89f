//! The fixed points of a map of one variable: of a quotient of polynomials with rational coefficients, also with a square
//! root in it, and in pieces.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::assumption::Assumptions;
use crate::exponential_polynomial::{exponentials, middle_and_square};
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Atom, Relation, Value};

/// The highest degree of a map whose fixed points are looked for.
const MOST_DEGREE: usize = 40;
/// The most pieces of one.
const MOST_PIECES: usize = 16;

/// Between which numbers a root lies that is no root of a quadratic polynomial, and no other root of its polynomial.
pub(super) type Place = (BigRational, BigRational);

/// The real values that are mapped to themselves and are rational or roots of quadratic polynomials, in order, and where the
/// others are, if that is known; nothing where they are not found, or are not single points.
pub(super) fn fixed_points(map: &Value, name: &Name) -> Option<(Vec<Value>, Option<Vec<Place>>)> {
    let (mut points, mut others): (Vec<Value>, Vec<Place>) = (Vec::new(), Vec::new());
    let none = Assumptions::default();
    let pieces = pieces(map, name)?;
    let plain = pieces.len() == 1 && atoms(map, name).is_empty();
    for piece in pieces {
        let (zeros, more) = zeros(&piece.sub(&Value::variable(name)).ok()?, name)?;
        others.extend(more);
        for point in zeros {
            // What is found may belong to another piece, or to the other sign of a root.
            if !points.contains(&point) && (plain || is_fixed(map, name, &point)?) {
                let place = points.iter().position(|other| none.decide(Relation::Lss, &point, other) == Some(true));
                points.insert(place.unwrap_or(points.len()), point);
            }
        }
    }
    others.sort();
    Some((points, Some(others).filter(|others| plain || others.is_empty())))
}

/// Whether a point is mapped to itself, as far as that is known; it is not where the map has no value.
fn is_fixed(map: &Value, name: &Name, point: &Value) -> Option<bool> {
    match map.with(name, point) {
        Ok(image) => Assumptions::default().decide(Relation::Eq, &image, point),
        Err(_) => Some(false),
    }
}

/// What a map depends on a variable by, beside powers of it.
pub(super) fn atoms(map: &Value, name: &Name) -> Vec<Atom> {
    let other = |atom: &Atom| atom.mentions(name) && !matches!(atom, Atom::Variable(_));
    map.atoms().into_iter().filter(other).collect()
}

/// The map with each maximum as one of its elements and each condition as met or not: in each piece it is one of these.
fn pieces(map: &Value, name: &Name) -> Option<Vec<Value>> {
    let (mut work, mut found) = (vec![map.clone()], Vec::new());
    while let Some(value) = work.pop() {
        let atoms = atoms(&value, name);
        let split = atoms.iter().find(|atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)));
        match split {
            None => found.push(value),
            Some(atom @ Atom::Maximum(parts)) => {
                for image in std::iter::once(&Value::zero()).chain(parts.iter()) {
                    work.push(value.with_atom(atom, image).ok()?);
                }
            }
            Some(atom) => {
                for image in [Value::zero(), Value::one()] {
                    work.push(value.with_atom(atom, &image).ok()?);
                }
            }
        }
        if work.len() + found.len() > MOST_PIECES {
            return None;
        }
    }
    Some(found)
}

/// Where a value may be 0 that is a quotient of polynomials, or has one square root besides, and where else.
fn zeros(value: &Value, name: &Name) -> Option<(Vec<Value>, Vec<Place>)> {
    match atoms(value, name).as_slice() {
        [] => zeros_of(&value.numerator()?, name),
        [root @ Atom::Root(inner)] => {
            // Where a + b*sqrt(c) is 0, so is a^2 - b^2*c.
            let mark = Name::new("[root]");
            let marked = value.with_atom(root, &Value::variable(&mark)).ok()?.numerator()?;
            let (factor, rest) = marked.linear_in(&mark)?;
            let square = factor.mul(&factor).ok()?.mul(inner).ok()?;
            zeros_of(&rest.mul(&rest).ok()?.sub(&square).ok()?.numerator()?, name)
        }
        _ => None,
    }
}

fn zeros_of(numerator: &Value, name: &Name) -> Option<(Vec<Value>, Vec<Place>)> {
    let parts: Vec<_> = exponentials(numerator, name)?.into_iter().collect();
    let [(base, coefficients)] = parts.as_slice() else { return None };
    base.as_rational().filter(BigRational::is_one)?;
    let polynomial = Univariate::new(coefficients.iter().map(Value::as_rational).collect::<Option<_>>()?);
    if polynomial.degree() > MOST_DEGREE {
        return None;
    }
    let (mut points, mut others) = (Vec::new(), Vec::new());
    for (factor, _) in polynomial.factors() {
        match factor.degree() {
            1 => points.push(Value::rational(-factor.coefficient(0))),
            2 => {
                let (middle, square) = middle_and_square(&factor);
                if square.is_positive() {
                    let distance = Value::rational(square).sqrt().ok()?;
                    let middle = Value::rational(middle);
                    points.push(middle.sub(&distance).ok()?);
                    points.push(middle.add(&distance).ok()?);
                }
            }
            _ => others.extend(real_roots(&factor)?),
        }
    }
    Some((points, others))
}

/// The units in which roots are told apart: so many in 1.
const UNITS: [u32; 2] = [6, 30];

/// Between which two decimals that follow each other each real root of an irreducible polynomial lies, in ascending order.
fn real_roots(polynomial: &Univariate) -> Option<Vec<Place>> {
    let mut chain = vec![polynomial.clone(), polynomial.derivative()];
    while let [.., before, last] = chain.as_slice()
        && !last.is_zero()
    {
        let next = Univariate::zero().minus(&before.modulo(last));
        chain.push(next);
    }
    chain.retain(|one| !one.is_zero());
    let largest = polynomial.monic().coefficients().iter().map(Signed::abs).max()?;
    let bound = largest.ceil().to_integer() + BigInt::one();
    UNITS.iter().find_map(|digits| roots_within(&chain, &bound, &BigInt::from(10).pow(*digits)))
}

/// The same with so many units in 1, all between this bound and its opposite; nothing where two roots lie in one unit.
fn roots_within(chain: &[Univariate], bound: &BigInt, units: &BigInt) -> Option<Vec<Place>> {
    let number = |place: &BigInt| BigRational::new(place.clone(), units.clone());
    // How often the signs of the Sturm chain change: between two places it falls by the number of roots there.
    let changes = |place: &BigInt| {
        let signs = chain.iter().map(|one| one.at(&number(place))).filter(|value| !value.is_zero());
        let signs: Vec<bool> = signs.map(|value| value.is_positive()).collect();
        signs.windows(2).filter(|pair| pair.first() != pair.last()).count()
    };
    let most = bound * units;
    let (low, high) = (-most.clone(), most);
    let mut found = Vec::new();
    let mut open = vec![(low.clone(), changes(&low), high.clone(), changes(&high))];
    while let Some((low, before, high, after)) = open.pop() {
        match before.saturating_sub(after) {
            0 => {}
            roots if &high - &low <= BigInt::one() => {
                (roots == 1).then_some(())?;
                found.push((number(&low), number(&high)));
            }
            _ => {
                let middle: BigInt = (&low + &high) >> 1;
                let there = changes(&middle);
                open.push((low, before, middle.clone(), there));
                open.push((middle, there, high, after));
            }
        }
    }
    found.sort();
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(number: i64) -> BigRational {
        BigRational::from_integer(number.into())
    }

    #[test]
    fn real_roots_are_counted() {
        let of = |numbers: &[i64]| {
            let polynomial = Univariate::new(numbers.iter().map(|one| number(*one)).collect());
            let found = real_roots(&polynomial).expect("places");
            for (low, high) in &found {
                let (before, after) = (polynomial.at(low), polynomial.at(high));
                let close = (high - low) * number(1_000_000) == number(1);
                assert!(close && (before.is_positive() != after.is_positive() || after.is_zero()), "{low} {high}");
            }
            found.len()
        };
        assert_eq!(of(&[2, 0, 0, 0, 1]), 0);
        assert_eq!(of(&[-2, 0, 0, 0, 1]), 2);
        assert_eq!(of(&[1, -3, 0, 1]), 3);
        assert_eq!(of(&[5, 1, 0, 1]), 1);
        assert_eq!(of(&[1, 0, 2, 0, 1]), 0);
        // (x-1)^2 (x+2): two different ones.
        assert_eq!(of(&[2, -3, 0, 1]), 2);
        // As many as products of lines have.
        for count in 1..7 {
            let line = |root: i64| Univariate::root(&number(root * root));
            let product = (1..=count).map(line).fold(Univariate::one(), |all, one| all.times(&one));
            let all = real_roots(&product.times(&Univariate::new(vec![number(3), number(0), number(1)])));
            assert_eq!(all.expect("places").len(), count as usize);
        }
    }
}
