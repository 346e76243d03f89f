//! Polynomials in one unknown over the rational numbers, and their factors.
//!
//! A polynomial stands for its roots: arithmetic with all roots of p at once is arithmetic modulo p, exact, whatever the
//! degree, and a sum over all roots is a rational number.

mod factor;
mod residue;

use std::fmt::Write as _;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::rational::{product, sum};

/// A polynomial: its coefficients from the constant up, the last one not 0.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub struct Univariate(Vec<BigRational>);

impl Univariate {
    /// The polynomial with these coefficients, from the constant up.
    pub fn new(mut coefficients: Vec<BigRational>) -> Univariate {
        while coefficients.last().is_some_and(BigRational::is_zero) {
            coefficients.pop();
        }
        Univariate(coefficients)
    }

    /// 0
    pub fn zero() -> Univariate {
        Univariate(Vec::new())
    }

    /// 1
    pub fn one() -> Univariate {
        Univariate(vec![BigRational::one()])
    }

    /// `x - root`
    pub fn root(root: &BigRational) -> Univariate {
        Univariate(vec![-root, BigRational::one()])
    }

    /// The coefficients, from the constant up; none of 0.
    pub fn coefficients(&self) -> &[BigRational] {
        &self.0
    }

    /// The coefficient of `x^place`.
    pub fn coefficient(&self, place: usize) -> BigRational {
        self.0.get(place).cloned().unwrap_or_else(BigRational::zero)
    }

    /// The degree; of 0 it is 0 too.
    pub fn degree(&self) -> usize {
        self.0.len().saturating_sub(1)
    }

    /// Whether it is 0.
    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// The sum.
    pub fn plus(&self, other: &Univariate) -> Univariate {
        let (long, short) = if self.0.len() < other.0.len() { (other, self) } else { (self, other) };
        let mut total = long.0.clone();
        for (own, coefficient) in total.iter_mut().zip(&short.0) {
            *own = sum(own, coefficient);
        }
        Univariate::new(total)
    }

    /// The difference.
    pub fn minus(&self, other: &Univariate) -> Univariate {
        self.plus(&other.scale(&-BigRational::one()))
    }

    /// A rational multiple.
    pub fn scale(&self, factor: &BigRational) -> Univariate {
        Univariate::new(self.0.iter().map(|coefficient| product(coefficient, factor)).collect())
    }

    /// The product.
    pub fn times(&self, other: &Univariate) -> Univariate {
        if self.is_zero() || other.is_zero() {
            return Univariate::zero();
        }
        let mut all = vec![BigRational::zero(); self.0.len() + other.0.len() - 1];
        for (place, left) in self.0.iter().enumerate().filter(|(_, left)| !left.is_zero()) {
            for (offset, right) in other.0.iter().enumerate().filter(|(_, right)| !right.is_zero()) {
                all[place + offset] = sum(&all[place + offset], &product(left, right));
            }
        }
        Univariate::new(all)
    }

    /// A power.
    pub fn power(&self, exponent: usize) -> Univariate {
        (0..exponent).fold(Univariate::one(), |power, _| power.times(self))
    }

    /// Quotient and remainder; `None` on division by 0.
    pub fn divide(&self, divisor: &Univariate) -> Option<(Univariate, Univariate)> {
        let lead = divisor.0.last()?;
        let mut rest = self.0.clone();
        let mut quotient = vec![BigRational::zero(); (self.0.len() + 1).saturating_sub(divisor.0.len())];
        while rest.len() >= divisor.0.len() {
            let offset = rest.len() - divisor.0.len();
            let top = rest.pop()?;
            if top.is_zero() {
                continue;
            }
            let factor = if lead.is_one() { top } else { product(&top, &lead.recip()) };
            for (place, coefficient) in divisor.0[..divisor.0.len() - 1].iter().enumerate() {
                if !coefficient.is_zero() {
                    rest[offset + place] = sum(&rest[offset + place], &-product(&factor, coefficient));
                }
            }
            quotient[offset] = factor;
        }
        Some((Univariate::new(quotient), Univariate::new(rest)))
    }

    /// What is left modulo a polynomial that is not 0.
    pub fn modulo(&self, divisor: &Univariate) -> Univariate {
        if self.0.len() < divisor.0.len() {
            return self.clone();
        }
        self.divide(divisor).map_or_else(Univariate::zero, |(_, rest)| rest)
    }

    /// Its multiple with the leading coefficient 1.
    pub fn monic(&self) -> Univariate {
        match self.0.last() {
            Some(lead) if !lead.is_one() => self.scale(&lead.recip()),
            _ => self.clone(),
        }
    }

    /// The derivative.
    pub fn derivative(&self) -> Univariate {
        let times = |(place, coefficient): (usize, &BigRational)| {
            product(coefficient, &BigRational::from_integer(place.into()))
        };
        Univariate::new(self.0.iter().enumerate().skip(1).map(times).collect())
    }

    /// The monic greatest common divisor.
    pub fn common_divisor(&self, other: &Univariate) -> Univariate {
        let (mut one, mut two) = (self.monic(), other.monic());
        while !two.is_zero() {
            (one, two) = (two.clone(), one.modulo(&two).monic());
        }
        one
    }

    /// The polynomial u with `self*u = 1` modulo a polynomial; `None` if they have a common root.
    pub fn inverse_modulo(&self, modulus: &Univariate) -> Option<Univariate> {
        let (mut old, mut new) = (modulus.clone(), self.modulo(modulus));
        let (mut before, mut factor) = (Univariate::zero(), Univariate::one());
        while new.degree() > 0 {
            let (quotient, rest) = old.divide(&new)?;
            let next = before.minus(&quotient.times(&factor));
            (old, new, before, factor) = (new, rest, factor, next);
        }
        Some(factor.scale(&new.0.first()?.recip()).modulo(modulus))
    }

    /// Its value at a number.
    pub fn at(&self, number: &BigRational) -> BigRational {
        self.0.iter().rev().fold(BigRational::zero(), |all, coefficient| sum(&product(&all, number), coefficient))
    }

    /// The integer multiple without common divisor of its coefficients.
    pub fn integral(&self) -> Vec<BigInt> {
        let denominator = self.0.iter().fold(BigInt::one(), |all, coefficient| all.lcm(coefficient.denom()));
        let whole: Vec<BigInt> =
            self.0.iter().map(|coefficient| coefficient.numer() * (&denominator / coefficient.denom())).collect();
        let content = whole.iter().fold(BigInt::zero(), |all, number| all.gcd(number));
        if content.is_zero() { whole } else { whole.into_iter().map(|number| number / &content).collect() }
    }

    /// The sums of the powers 0, 1, … of all roots, for a monic polynomial (Newton's identities).
    pub fn power_sums(&self, count: usize) -> Vec<BigRational> {
        let degree = self.degree();
        let mut sums: Vec<BigRational> = vec![BigRational::from_integer(degree.into())];
        for power in 1..count {
            let mut all = BigRational::zero();
            for back in 1..=power.min(degree) {
                let coefficient = &self.0[degree - back];
                let earlier =
                    if back == power { BigRational::from_integer(power.into()) } else { sums[power - back].clone() };
                all = sum(&all, &-product(coefficient, &earlier));
            }
            sums.push(all);
        }
        sums
    }

    /// In the unknown of this name: `x^3-2*x+1`.
    pub fn text(&self, unknown: &str) -> String {
        let mut text = String::new();
        for (place, coefficient) in self.0.iter().enumerate().rev().filter(|(_, number)| !number.is_zero()) {
            if coefficient.is_negative() {
                text.push('-');
            } else if !text.is_empty() {
                text.push('+');
            }
            let size = coefficient.abs();
            let power = match place {
                0 => String::new(),
                1 => unknown.to_string(),
                _ => format!("{unknown}^{place}"),
            };
            let _ = match (size.is_one(), power.is_empty()) {
                (_, true) => write!(text, "{size}"),
                (true, false) => write!(text, "{power}"),
                (false, false) => write!(text, "{size}*{power}"),
            };
        }
        if text.is_empty() { "0".to_string() } else { text }
    }
}

/// The polynomial with these coefficients, the lowest first.
#[cfg(test)]
pub(crate) fn polynomial(coefficients: &[i64]) -> Univariate {
    Univariate::new(coefficients.iter().map(|number| BigRational::from_integer((*number).into())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverses_and_sums() {
        let modulus = polynomial(&[-2, 0, 0, 1]);
        let element = polynomial(&[1, 1, 3]);
        let inverse = element.inverse_modulo(&modulus).unwrap();
        assert_eq!(element.times(&inverse).modulo(&modulus), Univariate::one());
        assert!(polynomial(&[-1, 1]).inverse_modulo(&polynomial(&[-1, 0, 1])).is_none());
        let sums = polynomial(&[-1, -1, 1]).power_sums(7);
        let lucas = [2, 1, 3, 4, 7, 11, 18].map(|number| BigRational::from_integer(number.into()));
        assert_eq!(sums, lucas);
        assert_eq!(polynomial(&[1, -2, 0, 1]).text("x"), "x^3-2*x+1");
    }
}
