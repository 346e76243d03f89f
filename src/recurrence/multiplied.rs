//! The product of a quotient of polynomials over the index: factors that meet again further on leave a quotient.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::One;

use super::Unknown;
use super::product::value_of;
use super::rational::{distance, shifted};
use crate::univariate::Univariate;
use crate::value::Value;

/// The furthest that a factor of a ratio is moved to meet another.
const MOST_APART: i64 = 30;

/// `base^n * value`, and the product of a ratio: a multiple of the product of another.
pub(super) struct Multiplied {
    pub base: Value,
    pub value: Value,
    /// What is left above and below, with integer coefficients, where nothing meets any more.
    pub ratio: [Univariate; 2],
}

impl Multiplied {
    /// Over all indices before `count`.
    ///
    /// # Errors
    /// When a value becomes too large.
    pub(super) fn of([above, below]: &[Univariate; 2], count: &Value) -> Result<Multiplied, Unknown> {
        let mut base = above.coefficient(above.degree()) / below.coefficient(below.degree());
        let (mut tops, mut bottoms) = (listed(above), listed(below));
        let (mut value, mut at) = (Value::one(), 0);
        while let Some(f) = tops.get(at) {
            let met = bottoms.iter().enumerate().find_map(|(place, g)| {
                let apart = distance(f, g).filter(|apart| apart.abs() <= MOST_APART)?;
                Some((place, apart))
            });
            let Some((place, apart)) = met else {
                at += 1;
                continue;
            };
            let (f, g) = (tops.swap_remove(at), bottoms.swap_remove(place));
            // f(n) = g(n+i): the product of f/g is that of i values of g, now over those at first.
            for step in 0..apart.abs() {
                let factor = value_of(&shifted(if apart > 0 { &g } else { &f }, step), count)?;
                value = if apart > 0 { value.mul(&factor)? } else { value.div(&factor)? };
            }
        }
        let mut whole = |all: &[Univariate], over: bool| {
            all.iter().fold(Univariate::one(), |product, one| {
                let scale = one.coefficients().iter().fold(BigInt::one(), |all, next| all.lcm(next.denom()));
                let scale = BigRational::from_integer(scale);
                base = if over { &base / &scale } else { &base * &scale };
                product.times(&one.scale(&scale))
            })
        };
        let ratio = [whole(&tops, true), whole(&bottoms, false)];
        Ok(Multiplied { base: Value::rational(base), value, ratio })
    }
}

/// A power of a quotient, above and below.
pub(super) fn raised([above, below]: &[Univariate; 2], power: i64) -> [Univariate; 2] {
    let [above, below] = if power < 0 { [below, above] } else { [above, below] };
    let times = |one: &Univariate| (0..power.abs()).fold(Univariate::one(), |all, _| all.times(one));
    [times(above), times(below)]
}

/// The monic factors, each as often as it divides.
fn listed(polynomial: &Univariate) -> Vec<Univariate> {
    polynomial.factors().into_iter().flat_map(|(factor, count)| vec![factor; count]).collect()
}
