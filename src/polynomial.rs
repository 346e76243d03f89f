//! Polynomials in several unknowns with rational coefficients, in one normal form.
//!
//! The monomials are ordered by total degree and then alphabetically, an order that multiplication preserves, so
//! "the leading coefficient is positive" makes the polynomials an ordered ring. Terms stand in falling order.

mod divisor;
mod perfect;

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{Hash, Hasher};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::rational::{product, sum};

/// The most terms that a polynomial may have.
pub const MOST_TERMS: usize = 20_000;
/// The most bits that a coefficient may have.
pub const MOST_BITS: u64 = 1_000_000;
/// The most pairs of terms that are multiplied in one product.
const MOST_PAIRS: u64 = 300_000;
/// The highest total degree that a monomial may have.
pub const MOST_DEGREE: u64 = 1_000_000;

/// A product of powers of unknowns: sorted, each once, no exponent 0.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub struct Monomial<A>(Vec<(A, u32)>);

/// A sum of rational multiples of monomials: falling order, no coefficient 0.
#[derive(Clone, Eq, Debug)]
pub struct Polynomial<A: Ord>(Vec<(Monomial<A>, BigRational)>);

/// By the digits of the coefficients, which are in lowest terms.
impl<A: Ord> PartialEq for Polynomial<A> {
    fn eq(&self, other: &Self) -> bool {
        let number = |one: &BigRational, two: &BigRational| one.numer() == two.numer() && one.denom() == two.denom();
        let mut pairs = self.0.iter().zip(&other.0);
        self.0.len() == other.0.len() && pairs.all(|(one, two)| number(&one.1, &two.1) && one.0 == two.0)
    }
}

impl<A: Ord> PartialOrd for Polynomial<A> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Term by term.
impl<A: Ord> Ord for Polynomial<A> {
    fn cmp(&self, other: &Self) -> Ordering {
        let number = |one: &BigRational, two: &BigRational| match one.is_integer() && two.is_integer() {
            true => one.numer().cmp(two.numer()),
            false => one.cmp(two),
        };
        let pairs = self.0.iter().zip(&other.0);
        let order = pairs.map(|((left, one), (right, two))| left.cmp(right).then_with(|| number(one, two)));
        order.into_iter().find(|order| order.is_ne()).unwrap_or_else(|| self.0.len().cmp(&other.0.len()))
    }
}

/// By the digits of the coefficients: a rational number hashes itself by its continued fraction, whose depth grows with
/// its length.
impl<A: Ord + Hash> Hash for Polynomial<A> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_usize(self.0.len());
        for (monomial, number) in &self.0 {
            monomial.hash(state);
            number.numer().hash(state);
            number.denom().hash(state);
        }
    }
}

/// How much work may still be done; whoever runs out gives up, so nothing hangs.
#[derive(Debug)]
pub struct Budget(u64);

impl Budget {
    /// A budget of so many coefficient operations.
    pub fn new(steps: u64) -> Budget {
        Budget(steps)
    }

    /// Takes `steps` from what is left; `None` when that is too little.
    pub fn spend(&mut self, steps: u64) -> Option<()> {
        self.0 = self.0.checked_sub(steps)?;
        Some(())
    }
}

impl<A: Clone + Ord> Monomial<A> {
    /// The monomial 1.
    pub fn one() -> Monomial<A> {
        Monomial(Vec::new())
    }

    /// The product of these powers, given in any order; `None` above the degree limit.
    pub fn of(factors: impl IntoIterator<Item = (A, u32)>) -> Option<Monomial<A>> {
        let mut powers: BTreeMap<A, u32> = BTreeMap::new();
        for (atom, exponent) in factors {
            let entry = powers.entry(atom).or_insert(0);
            *entry = entry.checked_add(exponent)?;
        }
        let product = Monomial(powers.into_iter().filter(|(_, exponent)| *exponent > 0).collect());
        (product.degree() <= MOST_DEGREE).then_some(product)
    }

    /// Its powers, sorted by unknown.
    pub fn factors(&self) -> &[(A, u32)] {
        &self.0
    }

    /// The sum of its exponents.
    pub fn degree(&self) -> u64 {
        self.0.iter().map(|(_, exponent)| u64::from(*exponent)).sum()
    }

    /// The exponent of this unknown.
    pub fn exponent(&self, atom: &A) -> u32 {
        self.0.binary_search_by(|(other, _)| other.cmp(atom)).ok().map_or(0, |place| self.0[place].1)
    }

    /// Merges two factor lists by an operation on exponents; `None` when the operation refuses.
    fn merge(&self, other: &Self, combine: impl Fn(u32, u32) -> Option<u32>) -> Option<Self> {
        let (left, right) = (&self.0, &other.0);
        let mut merged = Vec::with_capacity(left.len() + right.len());
        let (mut i, mut j) = (0, 0);
        while i < left.len() || j < right.len() {
            let order = match (left.get(i), right.get(j)) {
                (Some((a, _)), Some((b, _))) => a.cmp(b),
                (Some(_), None) => Ordering::Less,
                _ => Ordering::Greater,
            };
            let atom = if order == Ordering::Greater { &right[j].0 } else { &left[i].0 };
            let first = if order == Ordering::Greater { 0 } else { left[i].1 };
            let second = if order == Ordering::Less { 0 } else { right[j].1 };
            i += usize::from(order != Ordering::Greater);
            j += usize::from(order != Ordering::Less);
            let exponent = combine(first, second)?;
            if exponent > 0 {
                merged.push((atom.clone(), exponent));
            }
        }
        Some(Monomial(merged))
    }

    /// The product; `None` above the degree limit.
    pub fn times(&self, other: &Self) -> Option<Self> {
        self.merge(other, u32::checked_add).filter(|product| product.degree() <= MOST_DEGREE)
    }

    /// The quotient, when `other` divides it.
    pub fn over(&self, other: &Self) -> Option<Self> {
        self.merge(other, u32::checked_sub)
    }

    /// The greatest common divisor.
    pub fn common(&self, other: &Self) -> Self {
        self.merge(other, |a, b| Some(a.min(b))).unwrap_or_else(Monomial::one)
    }
}

impl<A: Ord> PartialOrd for Monomial<A> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<A: Ord> Ord for Monomial<A> {
    fn cmp(&self, other: &Self) -> Ordering {
        let degree = |monomial: &Self| monomial.0.iter().map(|(_, exponent)| u64::from(*exponent)).sum::<u64>();
        let lexical = || {
            for ((a, m), (b, n)) in self.0.iter().zip(&other.0) {
                let order = b.cmp(a).then(m.cmp(n));
                if order != Ordering::Equal {
                    return order;
                }
            }
            self.0.len().cmp(&other.0.len())
        };
        degree(self).cmp(&degree(other)).then_with(lexical)
    }
}

fn bits(number: &BigRational) -> u64 {
    number.numer().bits().max(number.denom().bits())
}

impl<A: Clone + Ord> Polynomial<A> {
    /// The polynomial 0.
    pub fn zero() -> Self {
        Polynomial(Vec::new())
    }

    /// A constant.
    pub fn constant(number: BigRational) -> Self {
        Polynomial::term(Monomial::one(), number)
    }

    /// The polynomial 1.
    pub fn one() -> Self {
        Polynomial::constant(BigRational::one())
    }

    /// One unknown.
    pub fn atom(atom: A) -> Self {
        Polynomial::term(Monomial(vec![(atom, 1)]), BigRational::one())
    }

    /// One monomial with its coefficient.
    pub fn term(monomial: Monomial<A>, coefficient: BigRational) -> Self {
        if coefficient.is_zero() { Polynomial::zero() } else { Polynomial(vec![(monomial, coefficient)]) }
    }

    /// The sum of these terms, given in any order.
    pub fn of(terms: impl IntoIterator<Item = (Monomial<A>, BigRational)>) -> Self {
        let mut all: Vec<(Monomial<A>, BigRational)> = terms.into_iter().collect();
        all.sort_by(|(one, _), (two, _)| two.cmp(one));
        let mut total: Vec<(Monomial<A>, BigRational)> = Vec::with_capacity(all.len());
        for (monomial, coefficient) in all {
            match total.last_mut() {
                Some((last, before)) if *last == monomial => *before = sum(before, &coefficient),
                _ => total.push((monomial, coefficient)),
            }
        }
        total.retain(|(_, coefficient)| !coefficient.is_zero());
        Polynomial(total)
    }

    /// The sum of terms that are in falling order, none of them 0.
    pub(crate) fn sorted(terms: Vec<(Monomial<A>, BigRational)>) -> Self {
        debug_assert!(terms.is_sorted_by(|(one, _), (two, _)| one > two));
        Polynomial(terms)
    }

    /// The negative.
    pub fn negated(&self) -> Self {
        Polynomial(self.0.iter().map(|(monomial, number)| (monomial.clone(), -number)).collect())
    }

    /// Its terms in falling order.
    pub fn terms(&self) -> &[(Monomial<A>, BigRational)] {
        &self.0
    }

    /// The bits of the longest numerator or denominator among the coefficients.
    pub fn bits(&self) -> u64 {
        self.0.iter().map(|(_, coefficient)| bits(coefficient)).max().unwrap_or(0)
    }

    /// True of 0.
    pub fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// True of 1.
    pub fn is_one(&self) -> bool {
        matches!(self.0.as_slice(), [(monomial, number)] if monomial.0.is_empty() && number.is_one())
    }

    /// Its value, when it is a constant.
    pub fn as_constant(&self) -> Option<BigRational> {
        match self.0.as_slice() {
            [] => Some(BigRational::zero()),
            [(monomial, number)] if monomial.0.is_empty() => Some(number.clone()),
            _ => None,
        }
    }

    /// Its constant term.
    pub fn constant_term(&self) -> BigRational {
        match self.0.last() {
            Some((monomial, number)) if monomial.0.is_empty() => number.clone(),
            _ => BigRational::zero(),
        }
    }

    /// The coefficient of its greatest monomial; 0 of the polynomial 0.
    pub fn leading(&self) -> BigRational {
        self.0.first().map_or_else(BigRational::zero, |(_, number)| number.clone())
    }

    /// The unknowns in it.
    pub fn atoms(&self) -> BTreeSet<&A> {
        self.0.iter().flat_map(|(monomial, _)| monomial.0.iter().map(|(atom, _)| atom)).collect()
    }

    /// The highest exponent of an unknown.
    pub fn degree_in(&self, atom: &A) -> u32 {
        self.0.iter().map(|(monomial, _)| monomial.exponent(atom)).max().unwrap_or(0)
    }

    /// Whether no term of it has a degree above 1.
    pub fn is_linear(&self) -> bool {
        self.0.iter().all(|(monomial, _)| monomial.degree() <= 1)
    }

    /// Whether its size stays within the limits.
    pub fn is_modest(&self) -> bool {
        self.0.len() <= MOST_TERMS && self.0.iter().all(|(_, number)| bits(number) <= MOST_BITS)
    }

    fn widest(&self) -> u64 {
        self.0.iter().map(|(_, number)| bits(number)).max().unwrap_or(0)
    }

    fn zip(&self, other: &Self, negated: bool) -> Self {
        let mut terms = Vec::with_capacity(self.0.len() + other.0.len());
        let signed = |number: &BigRational| if negated { -number } else { number.clone() };
        let (mut i, mut j) = (0, 0);
        while let (Some((a, x)), Some((b, y))) = (self.0.get(i), other.0.get(j)) {
            match a.cmp(b) {
                Ordering::Greater => terms.push((a.clone(), x.clone())),
                Ordering::Less => terms.push((b.clone(), signed(y))),
                Ordering::Equal => {
                    let total = if negated { sum(x, &-y) } else { sum(x, y) };
                    if !total.is_zero() {
                        terms.push((a.clone(), total));
                    }
                }
            }
            i += usize::from(a >= b);
            j += usize::from(b >= a);
        }
        terms.extend(self.0[i..].iter().cloned());
        terms.extend(other.0[j..].iter().map(|(monomial, number)| (monomial.clone(), signed(number))));
        Polynomial(terms)
    }

    /// The sum.
    pub fn plus(&self, other: &Self) -> Self {
        self.zip(other, false)
    }

    /// The difference.
    pub fn minus(&self, other: &Self) -> Self {
        self.zip(other, true)
    }

    /// Every coefficient multiplied by a number.
    pub fn scale(&self, factor: &BigRational) -> Self {
        if factor.is_one() {
            return self.clone();
        }
        if factor.is_zero() {
            return Polynomial::zero();
        }
        Polynomial(self.0.iter().map(|(monomial, number)| (monomial.clone(), product(number, factor))).collect())
    }

    /// The product with one term; the order of the terms stays. `None` above the degree limit.
    pub fn times_term(&self, factor: &Monomial<A>, coefficient: &BigRational) -> Option<Self> {
        if coefficient.is_zero() {
            return Some(Polynomial::zero());
        }
        let terms =
            self.0.iter().map(|(monomial, number)| Some((monomial.times(factor)?, product(number, coefficient))));
        terms.collect::<Option<Vec<_>>>().map(Polynomial)
    }

    /// The product; `None` when it is too large to be worth having.
    pub fn times(&self, other: &Self) -> Option<Self> {
        let (short, long) = if self.0.len() <= other.0.len() { (self, other) } else { (other, self) };
        match short.0.as_slice() {
            [] => return Some(Polynomial::zero()),
            [(monomial, number)] => return long.times_term(monomial, number).filter(Polynomial::is_modest),
            _ => {}
        }
        let pairs = short.0.len().saturating_mul(long.0.len()) as u64;
        let words = (1 + short.widest() / 64).saturating_mul(1 + long.widest() / 64);
        if pairs > MOST_PAIRS || pairs.saturating_mul(words) > 100_000_000 {
            return None;
        }
        let mut terms = Vec::new();
        for (monomial, number) in &short.0 {
            for (other, factor) in &long.0 {
                terms.push((monomial.times(other)?, product(number, factor)));
            }
        }
        Some(Polynomial::of(terms)).filter(Polynomial::is_modest)
    }

    /// A natural power; `None` when it is too large to be worth having.
    pub fn power(&self, exponent: u32) -> Option<Self> {
        let fits = |number: &BigRational| {
            bits(number) <= 1 || bits(number).saturating_mul(u64::from(exponent)) <= MOST_BITS.saturating_mul(2)
        };
        if self.0.len() == 1 && !self.0.iter().all(|(_, number)| fits(number)) {
            return None;
        }
        // Two terms have a power of one term more than the exponent; its square root would be the last to be squared.
        let half = u64::from(exponent) / 2;
        if self.0.len() > 1 && half.saturating_mul(half) > MOST_PAIRS {
            return None;
        }
        let (mut result, mut square, mut left) = (Polynomial::one(), self.clone(), exponent);
        while left > 0 {
            if left & 1 == 1 {
                result = result.times(&square)?;
            }
            left >>= 1;
            if left > 0 {
                square = square.times(&square)?;
            }
        }
        Some(result)
    }

    /// The positive rational that leaves coprime integer coefficients when divided out; 1 of the polynomial 0.
    pub fn content(&self) -> BigRational {
        let (mut numerator, mut denominator) = (BigInt::zero(), BigInt::one());
        for (_, number) in &self.0 {
            if !numerator.is_one() {
                numerator = numerator.gcd(number.numer());
            }
            if !number.denom().is_one() {
                denominator = denominator.lcm(number.denom());
            }
        }
        if numerator.is_zero() { BigRational::one() } else { BigRational::new(numerator.abs(), denominator) }
    }

    /// It with coprime integer coefficients, the leading one positive.
    pub fn primitive(&self) -> Self {
        let content = self.content();
        let signed = if self.leading().is_negative() { -content } else { content };
        self.scale(&signed.recip())
    }

    /// The greatest monomial that divides every term.
    pub fn monomial_content(&self) -> Monomial<A> {
        let mut terms = self.0.iter();
        let Some((first, _)) = terms.next() else {
            return Monomial::one();
        };
        terms.fold(first.clone(), |common, (monomial, _)| common.common(monomial))
    }

    /// It divided by a monomial that divides every term; else unchanged.
    pub fn without(&self, factor: &Monomial<A>) -> Self {
        if factor.0.is_empty() {
            return self.clone();
        }
        let terms = self.0.iter().map(|(monomial, number)| Some((monomial.over(factor)?, number.clone())));
        terms.collect::<Option<Vec<_>>>().map_or_else(|| self.clone(), Polynomial)
    }

    /// Its coefficients as a polynomial in one unknown, by exponent; none is 0.
    pub fn coefficients_in(&self, atom: &A) -> BTreeMap<u32, Polynomial<A>> {
        let mut parts: BTreeMap<u32, Vec<(Monomial<A>, BigRational)>> = BTreeMap::new();
        for (monomial, number) in &self.0 {
            let rest = monomial.0.iter().filter(|(other, _)| other != atom).cloned().collect();
            parts.entry(monomial.exponent(atom)).or_default().push((Monomial(rest), number.clone()));
        }
        parts.into_iter().map(|(exponent, terms)| (exponent, Polynomial::of(terms))).collect()
    }

    /// The exact quotient; `None` when there is none, or when the budget runs out.
    pub fn divide(&self, divisor: &Self, budget: &mut Budget) -> Option<Self> {
        let (head, number) = divisor.0.first()?;
        if let Some((monomial, _)) = self.0.first() {
            monomial.over(head)?;
        }
        let (mut rest, mut quotient) = (self.clone(), Vec::new());
        while let Some((monomial, coefficient)) = rest.0.first() {
            let factor = (monomial.over(head)?, coefficient / number);
            budget.spend(divisor.0.len() as u64 + rest.0.len() as u64 + bits(&factor.1) / 16)?;
            rest = rest.minus(&divisor.times_term(&factor.0, &factor.1)?);
            quotient.push(factor);
        }
        Some(Polynomial(quotient))
    }
}
