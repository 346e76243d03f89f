//! Exponential polynomials: `sum of c(n, x) * x^n over all roots x of p`, for some polynomials p over the rational numbers.
//!
//! The terms of every linear recurrence with constant coefficients are of this form. The roots are never computed:
//! what is done to all of them at once is done modulo p, where p need not even be irreducible, and a sum over all
//! roots is a number. The coefficients are polynomials in n and x whose own coefficients are any values.

mod dominant;
pub mod enclosed;
mod halves;
pub mod tail;
mod term;
mod text;

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Atom, Relation, Value, ValueError};

/// For each monic polynomial without the root 0 the coefficients: first by the power of n, then by that of x.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExponentialPolynomial {
    parts: BTreeMap<Univariate, Vec<Vec<Value>>>,
}

type Outcome = Result<ExponentialPolynomial, ValueError>;

impl ExponentialPolynomial {
    /// 0
    pub fn zero() -> ExponentialPolynomial {
        ExponentialPolynomial::default()
    }

    /// Its parts: each polynomial with the coefficients, first by the power of n, then by that of x.
    pub fn parts(&self) -> impl Iterator<Item = (&Univariate, &Vec<Vec<Value>>)> {
        self.parts.iter()
    }

    /// Adds the sum over the roots of a monic polynomial p, which has not the root 0.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn include(&mut self, modulus: &Univariate, coefficients: Vec<Vec<Value>>) -> Result<(), ValueError> {
        let own = self.parts.entry(modulus.clone()).or_default();
        for (power, row) in coefficients.into_iter().enumerate() {
            if own.len() <= power {
                own.resize(power + 1, vec![Value::zero(); modulus.degree()]);
            }
            for (place, value) in row.into_iter().enumerate().filter(|(_, value)| !value.is_zero()) {
                own[power][place] = if own[power][place].is_zero() { value } else { own[power][place].add(&value)? };
            }
        }
        while own.last().is_some_and(|row| row.iter().all(Value::is_zero)) {
            own.pop();
        }
        if own.is_empty() {
            self.parts.remove(modulus);
        }
        Ok(())
    }

    /// The sum.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn plus(&self, other: &ExponentialPolynomial) -> Outcome {
        self.clone().joined(other.clone())
    }

    /// The sum, of two that are not needed any more.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn joined(mut self, other: ExponentialPolynomial) -> Outcome {
        for (modulus, coefficients) in other.parts {
            self.include(&modulus, coefficients)?;
        }
        Ok(self)
    }

    /// A multiple by a value that is free of n.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn scale(&self, factor: &Value) -> Outcome {
        let mut product = ExponentialPolynomial::zero();
        for (modulus, rows) in &self.parts {
            let scaled = rows.iter().map(|row| row.iter().map(|value| value.mul(factor)).collect());
            product.include(modulus, scaled.collect::<Result<Vec<_>, _>>()?)?;
        }
        Ok(product)
    }

    /// The same with `n + 1` in place of n: `c(n+1, x) * x`, modulo p.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn next(&self) -> Outcome {
        self.moved(1, |modulus, row| {
            // x * (c_0 + … + c_d x^d), where x^(d+1) is what p says.
            let top = row[row.len() - 1].clone();
            let mut image = vec![Value::zero()];
            image.extend(row[..row.len() - 1].iter().cloned());
            lessen(&mut image, &top, modulus.coefficients())?;
            Ok(image)
        })
    }

    /// The same with `n - 1` in place of n.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn previous(&self) -> Outcome {
        self.moved(-1, |modulus, row| {
            // c_0/x, where 1/x = -(p_1 + p_2 x + … + x^d)/p_0.
            let lowest = row[0].clone();
            let mut image = row[1..].to_vec();
            image.push(Value::zero());
            let scale = modulus.coefficient(0).recip();
            let inverse: Vec<BigRational> = modulus.coefficients()[1..].iter().map(|number| number * &scale).collect();
            lessen(&mut image, &lowest, &inverse)?;
            Ok(image)
        })
    }

    fn moved(&self, by: i64, times_root: impl Fn(&Univariate, &[Value]) -> Result<Vec<Value>, ValueError>) -> Outcome {
        let mut result = ExponentialPolynomial::zero();
        for (modulus, rows) in &self.parts {
            // (n + by)^j, by Horner's rule in n.
            let mut moved: Vec<Vec<Value>> = Vec::new();
            for row in rows.iter().rev() {
                let mut next = vec![vec![Value::zero(); modulus.degree()]; moved.len() + 1];
                for (power, part) in moved.iter().enumerate() {
                    for (place, value) in part.iter().enumerate().filter(|(_, value)| !value.is_zero()) {
                        next[power + 1][place] = next[power + 1][place].add(value)?;
                        next[power][place] = next[power][place].add(&value.mul(&Value::integer(by))?)?;
                    }
                }
                for (place, value) in row.iter().enumerate() {
                    next[0][place] = next[0][place].add(value)?;
                }
                moved = next;
            }
            let rows = moved.iter().map(|row| times_root(modulus, row)).collect::<Result<Vec<_>, _>>()?;
            result.include(modulus, rows)?;
        }
        Ok(result)
    }

    /// Whether every coefficient is 0, so that it is 0 for all n.
    pub fn is_zero(&self, known: &Assumptions) -> bool {
        let zero = Value::zero();
        self.is_plainly_zero()
            || self
                .parts
                .values()
                .flatten()
                .flatten()
                .all(|value| known.decide(Relation::Eq, value, &zero) == Some(true))
    }

    /// Whether every coefficient has the normal form 0.
    pub fn is_plainly_zero(&self) -> bool {
        self.parts.is_empty()
    }

    /// A value in the index as an exponential polynomial; `None` when it has another form than polynomials in the index times powers
    /// of rational numbers.
    pub fn of(value: &Value, index: &Name) -> Option<ExponentialPolynomial> {
        let mut sum = ExponentialPolynomial::zero();
        for (base, coefficients) in exponentials(value, index)? {
            let modulus = Univariate::root(&base.as_rational().filter(|base| !base.is_zero())?);
            let rows = coefficients.into_iter().map(|coefficient| vec![coefficient]);
            sum.include(&modulus, rows.collect()).ok()?;
        }
        Some(sum)
    }

    /// As a value in the index; `None` when a root is neither rational nor a real quadratic number.
    pub fn value(&self, index: &Name) -> Option<Value> {
        let count = Value::variable(index);
        let mut sum = Value::zero();
        for (modulus, rows) in &self.parts {
            for root in roots(modulus)? {
                let mut coefficient = Value::zero();
                for (power, row) in rows.iter().enumerate() {
                    let inner = at_root(row, &root)?;
                    let power = count.power(&Value::integer(i64::try_from(power).ok()?)).ok()?;
                    coefficient = coefficient.add(&inner.mul(&power).ok()?).ok()?;
                }
                sum = sum.add(&coefficient.mul(&root.power(&count).ok()?).ok()?).ok()?;
            }
        }
        Some(sum)
    }
}

/// Subtracts a multiple of a polynomial, place by place.
fn lessen(row: &mut [Value], factor: &Value, polynomial: &[BigRational]) -> Result<(), ValueError> {
    if factor.is_zero() {
        return Ok(());
    }
    for (value, number) in row.iter_mut().zip(polynomial).filter(|(_, number)| !number.is_zero()) {
        *value = value.sub(&factor.mul(&Value::rational(number.clone()))?)?;
    }
    Ok(())
}

/// The value of a polynomial in x at a root.
fn at_root(row: &[Value], root: &Value) -> Option<Value> {
    row.iter().rev().try_fold(Value::zero(), |sum, value| sum.mul(root).ok()?.add(value).ok())
}

/// The middle of the two roots of a monic quadratic polynomial, and the square of their distance from it.
pub fn middle_and_square(modulus: &Univariate) -> (BigRational, BigRational) {
    let middle = -modulus.coefficient(1) / BigRational::from_integer(2.into());
    let square = &middle * &middle - modulus.coefficient(0);
    (middle, square)
}

/// The roots of a monic polynomial, as values: of degree 1, or of degree 2 when they are real.
fn roots(modulus: &Univariate) -> Option<Vec<Value>> {
    match modulus.degree() {
        1 => Some(vec![Value::rational(-modulus.coefficient(0))]),
        2 => {
            let (middle, square) = middle_and_square(modulus);
            let (middle, distance) = (Value::rational(middle), Value::rational(square).sqrt().ok()?);
            Some(vec![middle.add(&distance).ok()?, middle.sub(&distance).ok()?])
        }
        _ => None,
    }
}

/// A value as a sum of polynomials in the index (their coefficients from the constant up) times powers with the index
/// as exponent, by base; `None` when it has another form.
pub fn exponentials(value: &Value, index: &Name) -> Option<BTreeMap<Value, Vec<Value>>> {
    let mut found: BTreeMap<Value, Vec<Value>> = BTreeMap::new();
    if !value.mentions(index) {
        if !value.is_zero() {
            found.insert(Value::one(), vec![value.clone()]);
        }
        return Some(found);
    }
    let (numerator, denominator) = value.polynomials()?;
    let content = denominator.monomial_content();
    let rest = denominator.without(&content);
    if rest.atoms().iter().any(|atom| atom.mentions(index)) {
        return None;
    }
    let scale = Value::one().div(&Value::from_polynomials(rest, crate::polynomial::Polynomial::one()).ok()?).ok()?;
    for (monomial, number) in numerator.terms() {
        let mut term = Term { base: Value::one(), power: 0, coefficient: scale.scale(number).ok()? };
        for (atom, exponent) in monomial.factors() {
            term.include(atom, i64::from(*exponent), index)?;
        }
        for (atom, exponent) in content.factors() {
            term.include(atom, -i64::from(*exponent), index)?;
        }
        let row = found.entry(term.base).or_default();
        if row.len() <= term.power {
            row.resize(term.power + 1, Value::zero());
        }
        row[term.power] = row[term.power].add(&term.coefficient).ok()?;
    }
    found.retain(|_, row| !row.iter().all(Value::is_zero));
    Some(found)
}

/// `coefficient * n^power * base^n`
struct Term {
    base: Value,
    power: usize,
    coefficient: Value,
}

impl Term {
    fn include(&mut self, atom: &Atom, exponent: i64, index: &Name) -> Option<()> {
        let times = |value: &Value, base: &Value| value.mul(&base.power(&Value::integer(exponent)).ok()?).ok();
        match atom {
            other if !other.mentions(index) => self.coefficient = times(&self.coefficient, &other.value().ok()?)?,
            Atom::Variable(_) => self.power += usize::try_from(exponent).ok()?,
            Atom::Power(base, inner) if inner.as_variable() == Some(index) && !base.mentions(index) => {
                self.base = times(&self.base, base)?;
            }
            _ => return None,
        }
        Some(())
    }
}

/// Whether a rational number is 1.
fn is_unit(number: &BigRational) -> bool {
    number.is_one()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fibonacci() -> ExponentialPolynomial {
        let number = |top: i64, bottom: i64| Value::fraction(top, bottom).unwrap();
        let modulus = Univariate::new([-1, -1, 1].map(|number| BigRational::from_integer(i64::into(number))).to_vec());
        let mut sum = ExponentialPolynomial::zero();
        sum.include(&modulus, vec![vec![number(-1, 5), number(2, 5)]]).unwrap();
        sum
    }

    #[test]
    fn fibonacci_numbers() {
        let sum = fibonacci();
        let terms: Vec<Value> = (0..8).map(|place| sum.at(place).unwrap()).collect();
        assert_eq!(terms, [0, 1, 1, 2, 3, 5, 8, 13].map(Value::integer));
        let next = sum.next().unwrap();
        let difference = next.next().unwrap().plus(&next.plus(&sum).unwrap().scale(&Value::integer(-1)).unwrap());
        assert!(difference.unwrap().is_zero(&Assumptions::default()));
        assert_eq!(next.previous().unwrap(), sum);
        let index = Name::new("n");
        let value = sum.value(&index).unwrap();
        assert_eq!(value.with(&index, &Value::integer(7)).unwrap(), Value::integer(13));
        assert_eq!(sum.at(1000).unwrap().as_rational().unwrap().numer().to_string().len(), 209);
    }

    #[test]
    fn values_come_apart() {
        let index = Name::new("n");
        let n = Value::variable(&index);
        let half = Value::fraction(1, 2).unwrap();
        let value = n.mul(&half.power(&n).unwrap()).unwrap().add(&Value::variable(&Name::new("a"))).unwrap();
        let sum = ExponentialPolynomial::of(&value, &index).unwrap();
        assert_eq!(sum.parts().count(), 2);
        assert_eq!(sum.value(&index).unwrap(), value);
        assert!(ExponentialPolynomial::of(&Value::one().div(&n).unwrap(), &index).is_none());
    }
}
