//! Linear inequalities over monomials, and whether a set of them has no solution.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::value::{Atom, Exponent, Value, View};

type Product = Vec<(Atom, Exponent)>;

/// `sum > 0` if strict, else `sum >= 0`; the empty product is the constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inequality {
    terms: BTreeMap<Product, BigRational>,
    strict: bool,
}

/// The most inequalities that elimination may come to before it gives up, undecided.
const MOST: usize = 400;

impl Inequality {
    /// `numerator of value > 0`, or `>= 0`.
    pub fn of(value: &Value, strict: bool) -> Inequality {
        let terms = match value.view() {
            View::Real(sum, _) => sum.into_iter().map(|(number, factors)| (factors, number)).collect(),
            _ => BTreeMap::new(),
        };
        Inequality { terms, strict }
    }

    /// `product > 0`, or `>= 0`.
    pub fn monomial(product: &[(Atom, Exponent)], strict: bool) -> Inequality {
        Inequality { terms: BTreeMap::from([(product.to_vec(), BigRational::one())]), strict }
    }

    /// The same with every coefficient's sign changed.
    pub fn negated_terms(mut self) -> Inequality {
        self.terms.values_mut().for_each(|number| *number = -number.clone());
        self
    }

    /// As [`Inequality::negated_terms`]: of `p > 0`, `-p > 0`; of `p >= 0`, `-p >= 0`.
    pub fn negative(self) -> Inequality {
        self.negated_terms()
    }

    /// Of a sum that is a whole number and more than 0: it is at least 1.
    pub fn at_least_one(mut self) -> Inequality {
        *self.terms.entry(Vec::new()).or_insert_with(BigRational::zero) -= BigRational::one();
        self.strict = false;
        self
    }

    /// Its products but for the constant.
    pub fn monomials(&self) -> BTreeSet<Product> {
        self.terms.keys().filter(|product| !product.is_empty()).cloned().collect()
    }

    /// The product of two: at least 0, and more if both are.
    pub fn times(&self, other: &Inequality) -> Option<Inequality> {
        if self.terms.len() * other.terms.len() > 36 {
            return None;
        }
        let mut terms: BTreeMap<Product, BigRational> = BTreeMap::new();
        for (one, a) in &self.terms {
            for (two, b) in &other.terms {
                let mut factors: BTreeMap<Atom, Exponent> = one.iter().cloned().collect();
                for (atom, exponent) in two {
                    let sum = factors.entry(atom.clone()).or_insert(0);
                    *sum = sum.checked_add(*exponent)?;
                }
                *terms.entry(factors.into_iter().collect()).or_insert_with(BigRational::zero) += a * b;
            }
        }
        Some(Inequality { terms, strict: self.strict && other.strict })
    }

    fn coefficient(&self, product: &Product) -> BigRational {
        self.terms.get(product).cloned().unwrap_or_else(BigRational::zero)
    }

    /// A positive combination of two in which a product cancels.
    fn without(&self, other: &Inequality, product: &Product) -> Inequality {
        let (a, b) = (self.coefficient(product).abs(), other.coefficient(product).abs());
        let mut terms: BTreeMap<Product, BigRational> =
            self.terms.iter().map(|(key, number)| (key.clone(), number * &b)).collect();
        for (key, number) in &other.terms {
            *terms.entry(key.clone()).or_insert_with(BigRational::zero) += number * &a;
        }
        terms.retain(|_, number| !number.is_zero());
        Inequality { terms, strict: self.strict || other.strict }
    }

    /// True of `0 > 0` and of a negative constant that should be at least 0.
    fn absurd(&self) -> bool {
        if self.terms.keys().any(|product| !product.is_empty()) {
            return false;
        }
        let constant = self.coefficient(&Vec::new());
        constant.is_negative() || (self.strict && constant.is_zero())
    }
}

/// Whether no assignment of reals to the products meets all; false also when it is too much to decide.
pub fn infeasible(mut all: Vec<Inequality>) -> bool {
    all.iter_mut().for_each(|one| one.terms.retain(|_, number| !number.is_zero()));
    loop {
        if all.iter().any(Inequality::absurd) {
            return true;
        }
        let products: BTreeSet<Product> = all.iter().flat_map(Inequality::monomials).collect();
        let cost = |product: &Product| {
            let signs = all.iter().map(|one| one.coefficient(product));
            let (above, below) = signs.fold((0usize, 0usize), |(above, below), number| {
                (above + usize::from(number.is_positive()), below + usize::from(number.is_negative()))
            });
            above * below
        };
        let Some(product) = products.iter().min_by_key(|product| cost(product)) else { return false };
        let (with, mut rest): (Vec<Inequality>, Vec<Inequality>) =
            all.into_iter().partition(|one| !one.coefficient(product).is_zero());
        let (above, below): (Vec<&Inequality>, Vec<&Inequality>) =
            with.iter().partition(|one| one.coefficient(product).is_positive());
        if rest.len() + above.len() * below.len() > MOST {
            return false;
        }
        for one in &above {
            for other in &below {
                let sum = one.without(other, product);
                if !rest.contains(&sum) {
                    rest.push(sum);
                }
            }
        }
        all = rest;
    }
}
