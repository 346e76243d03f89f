//! Polynomials that are whole numbers wherever their unknowns are, as `n*(n+1)/2` is: by their binomial coefficients.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::super::{Atom, Value};

/// The highest exponent of an unknown, and the most unknowns of a term.
const MOST_EXPONENT: u32 = 8;
const MOST_UNKNOWNS: usize = 3;

impl Value {
    /// Whether it is known to be a whole number wherever its variables are: only then.
    pub(crate) fn is_whole(&self) -> bool {
        let whole = |atom: &Atom| matches!(atom, Atom::Variable(_)) || atom.is_integral();
        self.in_binomials(&whole).is_some_and(|all| all.iter().all(BigRational::is_integer))
    }

    /// Whether it is a whole number whatever its variables are: made of integer parts and conditions.
    pub(crate) fn is_always_whole(&self) -> bool {
        let rounded = |atom: &Atom| matches!(atom, Atom::Floor(_) | Atom::Positive(_));
        self.in_binomials(&rounded).is_some_and(|all| all.iter().all(BigRational::is_integer))
    }

    /// Whether it is known to be a natural number wherever its variables are.
    pub(crate) fn counts(&self) -> bool {
        let natural = |atom: &Atom| matches!(atom, Atom::Variable(_) | Atom::Positive(_));
        let all = self.in_binomials(&natural);
        all.is_some_and(|all| all.iter().all(|number| number.is_integer() && !number.is_negative()))
    }

    /// Whether it is made of variables alone and may be below 0 where these are natural numbers.
    pub(crate) fn may_be_negative(&self) -> bool {
        let all = self.in_binomials(&|atom| matches!(atom, Atom::Variable(_)));
        all.is_some_and(|all| all.iter().any(BigRational::is_negative))
    }

    /// The coefficients of a polynomial as a sum of products of `binomial(u,k)` of its unknowns u. At whole numbers these
    /// products are whole numbers, and natural ones at natural numbers. `None` where an unknown is none of those that are
    /// asked for, or it is too large.
    fn in_binomials(&self, unknown: &dyn Fn(&Atom) -> bool) -> Option<Vec<BigRational>> {
        let (numerator, denominator) = self.polynomials()?;
        if !denominator.is_one() {
            return None;
        }
        let mut sum: BTreeMap<Vec<(&Atom, usize)>, BigRational> = BTreeMap::new();
        for (monomial, number) in numerator.terms() {
            let mut products = vec![(Vec::new(), number.clone())];
            for (atom, exponent) in monomial.factors() {
                if !unknown(atom) || *exponent > MOST_EXPONENT || monomial.factors().len() > MOST_UNKNOWNS {
                    return None;
                }
                let parts = power_in_binomials(*exponent);
                let mut next = Vec::new();
                for (product, number) in &products {
                    for (lower, part) in parts.iter().enumerate().filter(|(_, part)| !part.is_zero()) {
                        let mut product = product.clone();
                        product.extend((lower > 0).then_some((atom, lower)));
                        next.push((product, number * part));
                    }
                }
                products = next;
            }
            for (product, number) in products {
                *sum.entry(product).or_insert_with(BigRational::zero) += number;
            }
        }
        Some(sum.into_values().collect())
    }
}

/// The coefficients of `u^exponent` by the binomial coefficients `binomial(u,0), binomial(u,1), …`.
fn power_in_binomials(exponent: u32) -> Vec<BigRational> {
    // u*binomial(u,k) = k*binomial(u,k) + (k+1)*binomial(u,k+1)
    let mut all = vec![BigRational::one()];
    for _ in 0..exponent {
        let mut next = vec![BigRational::zero(); all.len() + 1];
        for (lower, number) in all.iter().enumerate() {
            next[lower] += number * BigRational::from_integer(lower.into());
            next[lower + 1] += number * BigRational::from_integer((lower + 1).into());
        }
        all = next;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn what_is_whole_is_so_at_whole_numbers() {
        let [n, m] = ["n", "m"].map(|name| Value::variable(&Name::new(name)));
        let half = |value: Value| value.div(&Value::integer(2)).unwrap();
        let squared = n.mul(&n).unwrap();
        let triangle = half(squared.add(&n).unwrap());
        assert!(triangle.is_whole() && triangle.counts() && !triangle.may_be_negative());
        assert!(!half(n.clone()).is_whole() && !half(n.mul(&m).unwrap()).is_whole());
        let later = half(squared.sub(&n.mul(&Value::integer(3)).unwrap()).unwrap());
        assert!(later.is_whole() && !later.counts() && later.may_be_negative());
        assert!(n.mul(&m).unwrap().counts() && n.sub(&m).unwrap().may_be_negative());
        for at in 0..9i64 {
            let terms: Vec<BigRational> = power_in_binomials(4);
            let binomial = |lower: usize| {
                (0..lower as i64).fold(BigRational::one(), |all, place| {
                    all * BigRational::new((at - place).into(), (place + 1).into())
                })
            };
            let sum = terms.iter().enumerate().map(|(lower, number)| number * binomial(lower)).sum::<BigRational>();
            assert_eq!(sum, BigRational::from_integer(at.pow(4).into()));
        }
    }
}
