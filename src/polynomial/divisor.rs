//! Greatest common divisors by primitive remainder sequences, recursive on the unknowns.
//!
//! Before any remainder is formed, an image modulo a prime tells most coprime pairs apart: where the images have no
//! common factor in an unknown, neither have the polynomials (the leading coefficients do not vanish there).

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::{Budget, Monomial, Polynomial};

const PRIME: u64 = 2_147_483_647;
const MOST_ATOMS: usize = 24;
const MOST_GCD_DEGREE: u32 = 200;

impl<A: Clone + Ord> Polynomial<A> {
    /// A greatest common divisor with coprime integer coefficients; `None` when the budget runs out.
    pub fn common_divisor(&self, other: &Self, budget: &mut Budget) -> Option<Self> {
        divisor(self, other, budget, 0)
    }
}

fn divisor<A: Clone + Ord>(
    left: &Polynomial<A>,
    right: &Polynomial<A>,
    budget: &mut Budget,
    depth: usize,
) -> Option<Polynomial<A>> {
    budget.spend((left.terms().len() + right.terms().len()) as u64)?;
    if depth > 4 * MOST_ATOMS {
        return None;
    }
    if left.is_zero() || right.is_zero() {
        return Some(if left.is_zero() { right.primitive() } else { left.primitive() });
    }
    let (left_power, right_power) = (left.monomial_content(), right.monomial_content());
    let shared = Polynomial::term(left_power.common(&right_power), BigRational::one());
    let (left, right) = (left.without(&left_power).primitive(), right.without(&right_power).primitive());
    if left.as_constant().is_some() || right.as_constant().is_some() {
        return Some(shared);
    }
    if left == right {
        return shared.times(&left);
    }
    let (left_atoms, right_atoms) = (left.atoms(), right.atoms());
    if left_atoms.len() > MOST_ATOMS || right_atoms.len() > MOST_ATOMS {
        return None;
    }
    if let Some(true) = coprime(&left, &right, (&left_atoms, &right_atoms), budget) {
        return Some(shared);
    }
    let lone =
        |atoms: &BTreeSet<&A>, others: &BTreeSet<&A>| atoms.difference(others).next().map(|atom| (*atom).clone());
    // A divisor of both is free of an unknown that only one of them has: it divides each coefficient there.
    let found = if let Some(atom) = lone(&left_atoms, &right_atoms) {
        divisor(&content_in(&left, &atom, budget, depth)?, &right, budget, depth + 1)?
    } else if let Some(atom) = lone(&right_atoms, &left_atoms) {
        divisor(&left, &content_in(&right, &atom, budget, depth)?, budget, depth + 1)?
    } else {
        over_common_atoms(&left, &right, budget, depth)?
    };
    shared.times(&found)
}

/// Of primitive polynomials in the same unknowns.
fn over_common_atoms<A: Clone + Ord>(
    left: &Polynomial<A>,
    right: &Polynomial<A>,
    budget: &mut Budget,
    depth: usize,
) -> Option<Polynomial<A>> {
    let atoms: Vec<A> = left.atoms().into_iter().cloned().collect();
    let mut candidates: Vec<(u32, &A)> = Vec::new();
    for atom in &atoms {
        let degree = left.degree_in(atom).max(right.degree_in(atom));
        if degree > MOST_GCD_DEGREE {
            return None;
        }
        budget.spend((left.terms().len() + right.terms().len()) as u64)?;
        if !coprime_in(left, right, atom, &atoms) {
            candidates.push((degree, atom));
        }
    }
    // Free of every unknown: a constant.
    let Some((_, main)) = candidates.into_iter().min() else {
        return Some(Polynomial::one());
    };
    for (large, small) in [(left, right), (right, left)] {
        if large.divide(small, budget).is_some() {
            return Some(small.clone());
        }
    }
    let (left_content, right_content) =
        (content_in(left, main, budget, depth)?, content_in(right, main, budget, depth)?);
    let content = divisor(&left_content, &right_content, budget, depth + 1)?;
    let (mut first, mut second) = (left.divide(&left_content, budget)?, right.divide(&right_content, budget)?);
    if first.degree_in(main) < second.degree_in(main) {
        std::mem::swap(&mut first, &mut second);
    }
    loop {
        if second.degree_in(main) == 0 {
            return Some(content);
        }
        let rest = pseudo_remainder(&first, &second, main, budget)?;
        if rest.is_zero() {
            return content.times(&second.primitive());
        }
        first = second;
        second = if rest.degree_in(main) == 0 {
            Polynomial::one()
        } else {
            rest.divide(&content_in(&rest, main, budget, depth)?, budget)?.primitive()
        };
    }
}

/// The greatest common divisor of the coefficients of a polynomial in one unknown.
fn content_in<A: Clone + Ord>(
    polynomial: &Polynomial<A>,
    atom: &A,
    budget: &mut Budget,
    depth: usize,
) -> Option<Polynomial<A>> {
    let mut parts: Vec<Polynomial<A>> = polynomial.coefficients_in(atom).into_values().collect();
    parts.sort_by_key(|part| part.terms().len());
    let mut common = Polynomial::zero();
    for part in parts {
        common = divisor(&common, &part, budget, depth + 1)?;
        if common.is_one() {
            break;
        }
    }
    Some(common)
}

fn pseudo_remainder<A: Clone + Ord>(
    dividend: &Polynomial<A>,
    divisor: &Polynomial<A>,
    atom: &A,
    budget: &mut Budget,
) -> Option<Polynomial<A>> {
    let mut rest = dividend.clone();
    let (low, head) = divisor.coefficients_in(atom).pop_last()?;
    while !rest.is_zero() && rest.degree_in(atom) >= low {
        let (high, lead) = rest.coefficients_in(atom).pop_last()?;
        let work = rest.terms().len() * head.terms().len() + divisor.terms().len() * lead.terms().len();
        budget.spend(work as u64)?;
        let shift = Polynomial::term(Monomial::of([(atom.clone(), high - low)])?, BigRational::one());
        rest = rest.times(&head)?.minus(&divisor.times(&lead)?.times(&shift)?).primitive();
    }
    Some(rest)
}

/// Whether the images modulo the prime prove that no common divisor depends on any unknown; none beyond the budget.
fn coprime<A: Clone + Ord>(
    left: &Polynomial<A>,
    right: &Polynomial<A>,
    (left_atoms, right_atoms): (&BTreeSet<&A>, &BTreeSet<&A>),
    budget: &mut Budget,
) -> Option<bool> {
    let atoms: Vec<A> = left_atoms.union(right_atoms).map(|atom| (*atom).clone()).collect();
    for atom in left_atoms.intersection(right_atoms) {
        budget.spend((left.terms().len() + right.terms().len()) as u64)?;
        let low = left.degree_in(atom).max(right.degree_in(atom)) <= MOST_GCD_DEGREE;
        if !low || !coprime_in(left, right, atom, &atoms) {
            return Some(false);
        }
    }
    Some(true)
}

/// Whether the images modulo the prime prove that no common divisor depends on this unknown.
fn coprime_in<A: Clone + Ord>(left: &Polynomial<A>, right: &Polynomial<A>, main: &A, atoms: &[A]) -> bool {
    let (Some(left), Some(right)) = (image(left, main, atoms), image(right, main, atoms)) else {
        return false;
    };
    let (mut first, mut second) = (left, right);
    loop {
        while second.last() == Some(&0) {
            second.pop();
        }
        if second.len() <= 1 {
            return second.len() == 1;
        }
        while first.len() >= second.len() {
            let factor = multiply(first[first.len() - 1], inverse(second[second.len() - 1]));
            let shift = first.len() - second.len();
            for (place, number) in second.iter().enumerate() {
                first[shift + place] = (first[shift + place] + PRIME - multiply(factor, *number)) % PRIME;
            }
            first.pop();
            while first.last() == Some(&0) {
                first.pop();
            }
        }
        std::mem::swap(&mut first, &mut second);
    }
}

/// The polynomial in `main` modulo the prime, with fixed scattered numbers for the other unknowns; `None` when the
/// leading coefficient vanishes or a denominator does.
fn image<A: Clone + Ord>(polynomial: &Polynomial<A>, main: &A, atoms: &[A]) -> Option<Vec<u64>> {
    let prime = BigInt::from(PRIME);
    let residue = |number: &BigInt| (((number % &prime) + &prime) % &prime).to_u64();
    let degree = polynomial.degree_in(main) as usize;
    let mut image = vec![0u64; degree + 1];
    for (monomial, number) in polynomial.terms() {
        let mut product = residue(number.numer())?;
        if !number.denom().is_one() {
            let denominator = residue(number.denom())?;
            if denominator.is_zero() {
                return None;
            }
            product = multiply(product, inverse(denominator));
        }
        for (atom, exponent) in monomial.factors().iter().filter(|(atom, _)| atom != main) {
            let place = atoms.binary_search(atom).unwrap_or(0) as u64;
            let point = (place + 2).wrapping_mul(6_364_136_223_846_793_005) % PRIME;
            product = multiply(product, raise(point, u64::from(*exponent)));
        }
        let place = monomial.exponent(main) as usize;
        image[place] = (image[place] + product) % PRIME;
    }
    (image[degree] != 0).then_some(image)
}

fn multiply(left: u64, right: u64) -> u64 {
    left * right % PRIME
}

fn raise(base: u64, exponent: u64) -> u64 {
    let (mut result, mut square, mut left) = (1, base % PRIME, exponent);
    while left > 0 {
        if left & 1 == 1 {
            result = multiply(result, square);
        }
        square = multiply(square, square);
        left >>= 1;
    }
    result
}

fn inverse(number: u64) -> u64 {
    raise(number, PRIME - 2)
}
