//! The numbers that a value mentions: where it may change its way.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Value;

/// The most of them that [`around`] goes by.
const MOST: usize = 6;

impl Value {
    /// The constants in it at any depth, the factors other than 1 and -1, and where a linear part of it is 0: of
    /// `max(0, 2*x - 10)` these are 2 and 5.
    pub fn numbers(&self) -> BTreeSet<BigRational> {
        let mut found = BTreeSet::new();
        let mut open = vec![self.clone()];
        while let Some(value) = open.pop() {
            if let Some((numerator, denominator)) = value.polynomials() {
                for polynomial in [numerator, denominator] {
                    let constant = polynomial.constant_term();
                    if polynomial.as_constant().is_some() {
                        found.insert(constant);
                        continue;
                    }
                    for (monomial, factor) in polynomial.terms() {
                        if !monomial.factors().is_empty() && !factor.abs().is_one() {
                            found.insert(factor.clone());
                        }
                        if monomial.factors().len() == 1 && !constant.is_zero() {
                            found.insert(-&constant / factor);
                        }
                    }
                }
            }
            open.extend(value.direct_parts());
        }
        found
    }
}

/// The numbers with those just beside and between them, the former first: one of them lies on each side of every bound
/// that is mentioned.
pub fn around(numbers: &BTreeSet<BigRational>) -> Vec<BigRational> {
    let one = BigRational::from_integer(1.into());
    let two = &one + &one;
    let mut sorted: Vec<&BigRational> = numbers.iter().collect();
    // The shortest say most of what was meant.
    sorted.sort_by_key(|number| number.numer().bits() + number.denom().bits());
    sorted.truncate(MOST);
    let mut all: Vec<BigRational> = sorted.iter().map(|number| (*number).clone()).collect();
    sorted.sort();
    all.extend(sorted.windows(2).map(|pair| (pair[0] + pair[1]) / &two));
    all.extend(sorted.iter().flat_map(|number| [*number + &one, *number - &one]));
    let mut seen = BTreeSet::new();
    all.retain(|number| seen.insert(number.clone()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_a_bound_are_found_inside_it() {
        let x = Value::variable(&"x".into());
        let doubled = x.add(&x).and_then(|both| both.add(&Value::integer(-10))).expect("2x - 10");
        let most = Value::maximum(&[doubled, Value::zero()]).expect("a maximum");
        let found: Vec<String> = most.numbers().iter().map(ToString::to_string).collect();
        assert!(["2", "5"].iter().all(|number| found.contains(&(*number).to_string())), "{found:?}");
        let beside = around(&BTreeSet::from([BigRational::from_integer(100.into())]));
        assert_eq!(beside.iter().map(ToString::to_string).collect::<Vec<_>>(), ["100", "101", "99"]);
    }
}
