//! The step of time that meets every event and a moment between any two.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::definition::Definitions;
use crate::term::{Node, Term};

/// Half of the greatest common divisor of all constant delays in the terms and in what they call; 1/2 without any.
pub(crate) fn grain(terms: [&Term; 2], definitions: &Definitions) -> BigRational {
    let mut divisor = BigRational::zero();
    let mut called = BTreeSet::new();
    let mut open: Vec<&Term> = terms.to_vec();
    while let Some(term) = open.pop() {
        match term.node() {
            Node::Delay(time) => {
                if let Some(time) = time.as_rational() {
                    divisor = common_divisor(&divisor, &time);
                }
            }
            Node::Call(name, _) => {
                if let Some(definition) = definitions.get(name)
                    && called.insert(name.clone())
                {
                    open.push(&definition.body);
                }
            }
            _ => open.extend(term.children()),
        }
    }
    if divisor.is_zero() {
        divisor = BigRational::one();
    }
    divisor / BigRational::from_integer(BigInt::from(2))
}

/// The greatest number of which both are whole multiples.
pub(crate) fn common_divisor(left: &BigRational, right: &BigRational) -> BigRational {
    let denominator = left.denom().lcm(right.denom());
    let numerator = |number: &BigRational| number.numer() * (&denominator / number.denom());
    BigRational::new(numerator(left).gcd(&numerator(right)), denominator.clone())
}
