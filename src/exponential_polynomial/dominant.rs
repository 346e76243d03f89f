//! The one root of a polynomial that is larger than all others, if there is one: it is real, and lies between bounds
//! that are found by exact bisection.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::tail::{root_bounds, rounded_up};
use crate::univariate::Univariate;

/// How often the roots are squared to tell them apart.
const SQUARINGS: u32 = 6;
/// How often the interval of the root is halved.
const HALVINGS: usize = 80;

/// A root between two numbers of the same sign, and a number below its size that all others are below too.
pub(super) struct Dominant {
    pub(super) low: BigRational,
    pub(super) high: BigRational,
    pub(super) others: BigRational,
}

/// The polynomial whose roots are the powers `2^times` of the roots of a monic one (Graeffe).
pub(super) fn with_squared_roots(polynomial: &Univariate, times: u32) -> Univariate {
    let degree = polynomial.degree();
    let mut squared = polynomial.clone();
    for _ in 0..times {
        let alternating =
            |(place, number): (usize, &BigRational)| if place % 2 == 1 { -number } else { number.clone() };
        let mirrored = Univariate::new(squared.coefficients().iter().enumerate().map(alternating).collect());
        let product = squared.times(&mirrored);
        squared = Univariate::new((0..=degree).map(|place| product.coefficient(2 * place)).collect()).monic();
    }
    squared
}

/// The largest root of a monic polynomial, if all others are smaller.
pub(super) fn dominant(polynomial: &Univariate, largest: &BigRational) -> Option<Dominant> {
    let degree = polynomial.degree();
    let powers = with_squared_roots(polynomial, SQUARINGS);
    let (first, second) = (powers.coefficient(degree - 1).abs(), powers.coefficient(degree - 2).abs());
    if first.is_zero() {
        return None;
    }
    // Between the largest and the next root, if the estimates of both are good.
    let middle = root_bounds(&second, 2).1.max(BigRational::new(BigInt::one(), BigInt::one() << 200));
    separates(&powers, &middle, degree - 1).then_some(())?;
    let others = rounded_up(&root_bounds(&middle, 1 << SQUARINGS).1);
    let sides = [BigRational::one(), -BigRational::one()];
    sides.iter().find_map(|side| bisected(polynomial, &others, largest, side))
}

/// Whether so many roots are smaller than a number and none has its size (Pellet).
fn separates(polynomial: &Univariate, size: &BigRational, count: usize) -> bool {
    let mut power = BigRational::one();
    let (mut own, mut rest) = (BigRational::zero(), BigRational::zero());
    for (place, number) in polynomial.coefficients().iter().enumerate() {
        let part = number.abs() * &power;
        if place == count {
            own = part
        } else {
            rest += part
        }
        power *= size;
    }
    own > rest
}

/// The root on one side of 0 between two sizes, by the signs of the polynomial.
fn bisected(polynomial: &Univariate, least: &BigRational, most: &BigRational, side: &BigRational) -> Option<Dominant> {
    let at = |size: &BigRational| polynomial.at(&(size * side));
    let (mut low, mut high) = (least.clone(), most + BigRational::one());
    let positive = at(&low).is_positive();
    if at(&high).is_positive() == positive {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = (&low + &high) / BigRational::from_integer(2.into());
        if at(&middle).is_positive() == positive { low = middle } else { high = middle }
    }
    let (low, high) = if side.is_positive() { (low, high) } else { (-high, -low) };
    Some(Dominant { low, high, others: least.clone() })
}

/// The bounds of a polynomial with these coefficients between two numbers.
pub(super) fn between(
    coefficients: &[BigRational],
    low: &BigRational,
    high: &BigRational,
) -> (BigRational, BigRational) {
    let mut bounds = (BigRational::zero(), BigRational::zero());
    for number in coefficients.iter().rev() {
        let products = [&bounds.0 * low, &bounds.0 * high, &bounds.1 * low, &bounds.1 * high];
        let least = products.iter().min().cloned().unwrap_or_else(BigRational::zero);
        let most = products.into_iter().max().unwrap_or_else(BigRational::zero);
        bounds = (least + number, most + number);
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plastic_number_is_found() {
        let polynomial = |numbers: &[i64]| {
            Univariate::new(numbers.iter().map(|number| BigRational::from_integer((*number).into())).collect())
        };
        let found = dominant(&polynomial(&[-1, -1, 0, 1]), &BigRational::from_integer(2.into())).unwrap();
        let thousand = BigRational::from_integer(1000.into());
        assert_eq!((&found.low * &thousand).floor(), BigRational::from_integer(1324.into()));
        assert!(found.high > found.low && found.others < found.low);
        assert!(dominant(&polynomial(&[-2, 0, 0, 1]), &BigRational::from_integer(2.into())).is_none());
    }
}
