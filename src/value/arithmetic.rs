//! The four operations, on numbers and componentwise on vectors, and the normal form of fractions.

mod quotients;

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::{One, Signed};

use self::quotients::found_once;
use super::denominator::{divided_beside_length, free_denominator, leading_root, without_lengths};
use super::fixed::coarse_order;
use super::line::conditions;
use super::squares::sums_squares;
use super::{Atom, Content, Outcome, Real, Sort, Value, ValueError};
use crate::polynomial::{Budget, MOST_TERMS, Monomial, Polynomial};

/// The work that may go into one greatest common divisor; beyond it a fraction keeps its common factor.
pub(super) const DIVISOR_BUDGET: u64 = 100_000;
/// A numerator of no more terms is divided by a linear denominator without asking first whether that divides it.
const FEW_TERMS: usize = 32;
/// Terms of a fraction from which on its normal form is remembered.
const MANY_TERMS: usize = 7;

impl Value {
    /// The sum, of numbers or of vectors of the same length.
    ///
    /// # Errors
    /// On a sort mismatch, or when the result is too large.
    pub fn add(&self, other: &Value) -> Result<Value, ValueError> {
        self.combine(other, "add", |left, right| left.add_real(right))
    }

    /// The difference, of numbers or of vectors of the same length.
    ///
    /// # Errors
    /// As [`Value::add`].
    pub fn sub(&self, other: &Value) -> Result<Value, ValueError> {
        self.combine(other, "subtract", |left, right| {
            let ((a, b), (c, d)) = (left.real()?, right.real()?);
            if c.is_zero() {
                return Ok(left.clone());
            }
            if b.is_one() && d.is_one() {
                return Value::whole(a.minus(c));
            }
            left.add_real(&right.neg()?)
        })
    }

    /// The product of numbers, or of a number and a vector.
    ///
    /// # Errors
    /// On a sort mismatch, or when the result is too large.
    pub fn mul(&self, other: &Value) -> Result<Value, ValueError> {
        match (&self.0.content, &other.0.content) {
            (Content::Real(a, b), Content::Real(c, d)) => {
                if let Some(number) = constant(c, d) {
                    return if number.is_one() { Ok(self.clone()) } else { Value::multiple(a, b, number) };
                }
                if let Some(number) = constant(a, b) {
                    return if number.is_one() { Ok(other.clone()) } else { Value::multiple(c, d, number) };
                }
                if a.is_zero() || c.is_zero() {
                    return Ok(Value::zero());
                }
                let numerator = product(a, c)?;
                if b.is_one() && d.is_one() {
                    return Value::whole(relations(numerator)?);
                }
                Value::quotient(numerator, product(b, d)?)
            }
            (Content::Real(..), Content::Vector(parts)) => Value::each(parts, |part| self.mul(part)),
            (Content::Vector(parts), Content::Real(..)) => Value::each(parts, |part| part.mul(other)),
            _ => Err(mismatch("multiply", self, other)),
        }
    }

    /// The quotient of a number or vector by a number.
    ///
    /// # Errors
    /// On division by 0, on a sort mismatch, or when the result is too large.
    pub fn div(&self, other: &Value) -> Result<Value, ValueError> {
        match (&self.0.content, &other.0.content) {
            (_, Content::Real(c, _)) if c.is_zero() => Err(ValueError::new("division by zero")),
            (Content::Real(a, b), Content::Real(c, d)) => match constant(c, d) {
                Some(number) if number.is_one() => Ok(self.clone()),
                Some(number) => Value::multiple(a, b, &number.recip()),
                None => Value::quotient(product(a, d)?, product(b, c)?),
            },
            (Content::Vector(parts), Content::Real(..)) => Value::each(parts, |part| part.div(other)),
            _ => Err(mismatch("divide", self, other)),
        }
    }

    /// The quotient as it is written: a direction, `e/abs(e)`, is the sign of e. As cancelling does, this forgets that
    /// nothing is said where e is 0.
    ///
    /// # Errors
    /// As [`Value::div`].
    pub fn over(&self, other: &Value) -> Result<Value, ValueError> {
        match (&self.0.content, &other.0.content) {
            (Content::Real(a, b), Content::Real(c, d)) if !c.is_zero() => {
                let (numerator, denominator) = without_lengths(product(a, d)?, product(b, c)?)?;
                Value::quotient(numerator, denominator)
            }
            _ => self.div(other),
        }
    }

    /// The negative.
    ///
    /// # Errors
    /// Of a distribution.
    pub fn neg(&self) -> Result<Value, ValueError> {
        match &self.0.content {
            Content::Real(a, b) => Value::new(Content::Real(a.negated(), b.clone())),
            Content::Vector(parts) => Value::each(parts, Value::neg),
            Content::Distribution(..) => Err(ValueError::new("a distribution has no negative; draw from it first")),
        }
    }

    /// A rational multiple.
    pub(crate) fn scale(&self, factor: &BigRational) -> Outcome {
        self.mul(&Value::rational(factor.clone()))
    }

    /// A rational multiple of a fraction in normal form, which is in normal form too.
    fn multiple(numerator: &Real, denominator: &Real, number: &BigRational) -> Outcome {
        let numerator = numerator.scale(number);
        if !numerator.is_modest() {
            return Err(ValueError::too_large());
        }
        let denominator = if numerator.is_zero() { Polynomial::one() } else { denominator.clone() };
        Value::new(Content::Real(numerator, denominator))
    }

    fn add_real(&self, other: &Value) -> Outcome {
        let ((a, b), (c, d)) = (self.real()?, other.real()?);
        if a.is_zero() {
            return Ok(other.clone());
        }
        if c.is_zero() {
            return Ok(self.clone());
        }
        if b.is_one() && d.is_one() {
            return Value::whole(a.plus(c));
        }
        if b == d {
            return Value::quotient(a.plus(c), b.clone());
        }
        let numerator = product(a, d)?.plus(&product(c, b)?);
        Value::quotient(numerator, product(b, d)?)
    }

    pub(super) fn each(parts: &[Value], image: impl Fn(&Value) -> Outcome) -> Outcome {
        Value::vector(parts.iter().map(image).collect::<Result<Vec<_>, _>>()?)
    }

    fn combine(&self, other: &Value, verb: &str, image: impl Fn(&Value, &Value) -> Outcome) -> Outcome {
        match (&self.0.content, &other.0.content) {
            (Content::Real(..), Content::Real(..)) => image(self, other),
            (Content::Vector(left), Content::Vector(right)) if left.len() == right.len() => {
                let parts = left.iter().zip(right).map(|(left, right)| image(left, right));
                Value::vector(parts.collect::<Result<Vec<_>, _>>()?)
            }
            _ => Err(mismatch(verb, self, other)),
        }
    }

    /// The normal form of a fraction.
    pub(super) fn quotient(numerator: Real, denominator: Real) -> Outcome {
        if denominator.is_one() {
            return Value::whole(relations(numerator)?);
        }
        if numerator.terms().len() + denominator.terms().len() < MANY_TERMS {
            return Value::reduced(numerator, denominator);
        }
        found_once((numerator, denominator), |(numerator, denominator)| Value::reduced(numerator, denominator))
    }

    /// A fraction in lowest terms.
    fn reduced(numerator: Real, denominator: Real) -> Outcome {
        let (numerator, denominator) = free_denominator(relations(numerator)?, relations(denominator)?)?;
        if denominator.is_zero() {
            return Err(ValueError::new("division by zero"));
        }
        let (numerator, denominator) = cancel(numerator, denominator);
        let divided = divided_beside_length(&numerator, &denominator)?;
        let (numerator, denominator) = divided.unwrap_or((numerator, denominator));
        let (numerator, denominator) = cancel_beside_root(numerator, denominator)?;
        let scale = denominator.leading().recip();
        let (numerator, denominator) = (numerator.scale(&scale), denominator.scale(&scale));
        if !numerator.is_modest() || !denominator.is_modest() {
            return Err(ValueError::too_large());
        }
        Value::new(Content::Real(numerator, denominator))
    }
}

fn mismatch(verb: &str, left: &Value, right: &Value) -> ValueError {
    let text = format!("cannot {verb} {} and {}", left.sort(), right.sort());
    if left.sort() == Sort::Distribution || right.sort() == Sort::Distribution {
        return ValueError(format!("{text}; draw from the distribution first"));
    }
    ValueError(text)
}

/// The number that a fraction is, if it is one other than 0.
fn constant<'a>(numerator: &'a Real, denominator: &Real) -> Option<&'a BigRational> {
    match numerator.terms() {
        [(monomial, number)] if monomial.factors().is_empty() && denominator.is_one() => Some(number),
        _ => None,
    }
}

pub(super) fn product(left: &Real, right: &Real) -> Result<Real, ValueError> {
    left.times(right).ok_or_else(ValueError::too_large)
}

/// Divides out the greatest common divisor: all of it, or, beyond the budget, the common monomial.
pub(super) fn cancel(numerator: Real, denominator: Real) -> (Real, Real) {
    if numerator.is_zero() {
        return (numerator, Polynomial::one());
    }
    if denominator.as_constant().is_some() {
        return (numerator, denominator);
    }
    let shared = numerator.monomial_content().common(&denominator.monomial_content());
    let (numerator, denominator) = (numerator.without(&shared), denominator.without(&shared));
    if denominator.terms().len() == 1 || numerator.terms().len() == 1 {
        return (numerator, denominator);
    }
    let mut budget = Budget::new(DIVISOR_BUDGET);
    // What is linear in its atoms is irreducible: it divides the numerator, or nothing does.
    if numerator.terms().len() <= FEW_TERMS && denominator.is_linear() {
        return match numerator.divide(&denominator, &mut budget) {
            Some(quotient) => (quotient, Polynomial::one()),
            None => (numerator, denominator),
        };
    }
    let reduced = || {
        let divisor = numerator.common_divisor(&denominator, &mut budget)?;
        Some((numerator.divide(&divisor, &mut budget)?, denominator.divide(&divisor, &mut budget)?))
    };
    let mut reduced = reduced;
    match reduced() {
        Some(pair) => pair,
        None => (numerator, denominator),
    }
}

/// The same where the roots of numbers in the numerator hide what both share: `x*sqrt(2)-2` is `sqrt(2)*(x-sqrt(2))`.
fn cancel_beside_root(numerator: Real, denominator: Real) -> Result<(Real, Real), ValueError> {
    let hidden = denominator.atoms().iter().any(|atom| atom.is_root_of_number());
    let Some(root) = leading_root(&numerator).filter(|_| hidden) else { return Ok((numerator, denominator)) };
    let (above, below) = cancel(relations(product(&numerator, &root)?)?, denominator.clone());
    if below == denominator {
        return Ok((numerator, denominator));
    }
    let square = relations(product(&root, &root)?)?;
    match square.as_constant() {
        Some(square) => Ok((relations(product(&above, &root)?)?.scale(&square.recip()), below)),
        None => Ok((numerator, denominator)),
    }
}

impl Atom {
    /// The root of a number.
    pub(crate) fn is_root_of_number(&self) -> bool {
        matches!(self, Atom::Root(inner) if inner.as_rational().is_some())
    }

    /// 0 or 1 always: `if` and `0^n`.
    pub(crate) fn is_binary(&self) -> bool {
        match self {
            Atom::Positive(_) => true,
            Atom::Power(base, _) => base.is_zero(),
            _ => false,
        }
    }

    /// 1 or -1 always: `(-1)^n`.
    pub(crate) fn is_sign(&self) -> bool {
        matches!(self, Atom::Power(base, _) if base.as_rational().is_some_and(|base| (-base).is_one()))
    }

    /// The polynomial that is its square, for roots of what is certainly not negative.
    pub(super) fn square(&self) -> Option<&Real> {
        match self {
            Atom::Root(inner) => {
                let (numerator, _) = inner.parts().filter(|(_, denominator)| denominator.is_one())?;
                let surely = inner.plainly_nonnegative() || sums_squares(numerator) || is_positive_number(numerator);
                surely.then_some(numerator)
            }
            _ => None,
        }
    }
}

/// Whether it is a number with roots of rational numbers, and surely greater than 0. Squares of deeper roots, written out,
/// grow with each step of a way.
fn is_positive_number(polynomial: &Real) -> bool {
    let roots = polynomial.atoms().into_iter().all(Atom::is_root_of_number);
    roots && coarse_order(polynomial) == Some(Ordering::Greater)
}

/// Applies the equations between atoms: binary atoms are idempotent, `(-1)^n` and roots have known squares, and products
/// of conditions along one line are sums of them.
pub(super) fn relations(polynomial: Real) -> Result<Real, ValueError> {
    let touched = |monomial: &Monomial<Atom>| {
        let mut conditions = 0;
        monomial.factors().iter().any(|(atom, exponent)| {
            conditions += usize::from(matches!(atom, Atom::Positive(_)));
            conditions > 1 || (*exponent > 1 && (atom.is_binary() || atom.is_sign() || atom.square().is_some()))
        })
    };
    if !polynomial.terms().iter().any(|(monomial, _)| touched(monomial)) {
        return Ok(polynomial);
    }
    let mut terms = Vec::new();
    for (monomial, number) in polynomial.terms() {
        if !touched(monomial) {
            terms.push((monomial.clone(), number.clone()));
        } else {
            terms.extend_from_slice(reduced_monomial(monomial, number)?.terms());
        }
        // One sum of all terms, but no more of them at a time than two polynomials may have.
        if terms.len() > 2 * MOST_TERMS {
            terms = Polynomial::of(terms).terms().to_vec();
            if terms.len() > MOST_TERMS {
                return Err(ValueError::too_large());
            }
        }
    }
    Ok(Polynomial::of(terms))
}

fn reduced_monomial(monomial: &Monomial<Atom>, number: &BigRational) -> Result<Real, ValueError> {
    let mut factors = Vec::new();
    let several = monomial.factors().iter().filter(|(atom, _)| matches!(atom, Atom::Positive(_))).count() > 1;
    let held = if several { conditions(monomial)? } else { Polynomial::one() };
    let mut squares = Polynomial::one();
    for (atom, exponent) in monomial.factors() {
        if several && matches!(atom, Atom::Positive(_)) {
            continue;
        } else if atom.is_binary() {
            factors.push((atom.clone(), 1));
        } else if atom.is_sign() {
            factors.push((atom.clone(), exponent % 2));
        } else if let Some(square) = atom.square() {
            factors.push((atom.clone(), exponent % 2));
            let power = square.power(exponent / 2).ok_or_else(ValueError::too_large)?;
            squares = product(&squares, &power)?;
        } else {
            factors.push((atom.clone(), *exponent));
        }
    }
    let rest = Monomial::of(factors).ok_or_else(ValueError::too_large)?;
    if squares.is_one() {
        return held.times_term(&rest, number).ok_or_else(ValueError::too_large);
    }
    // What stands under a root is nested less deeply than the root, so this ends.
    let whole = relations(squares.times_term(&rest, number).ok_or_else(ValueError::too_large)?)?;
    if several { relations(product(&whole, &held)?) } else { Ok(whole) }
}

impl Value {
    /// Not negative, as its form alone shows: sums of squares and of things that are never negative.
    pub(super) fn plainly_nonnegative(&self) -> bool {
        self.parts().is_some_and(|(numerator, denominator)| {
            numerator.terms().iter().chain(denominator.terms()).all(|(monomial, number)| {
                number.is_positive()
                    && monomial.factors().iter().all(|(atom, exponent)| exponent % 2 == 0 || atom.plainly_nonnegative())
            })
        })
    }

    /// Greater than 0, as its form alone shows.
    pub(super) fn plainly_positive(&self) -> bool {
        self.plainly_nonnegative()
            && self.parts().is_some_and(|(numerator, _)| {
                numerator.terms().iter().any(|(monomial, _)| {
                    monomial
                        .factors()
                        .iter()
                        .all(|(atom, _)| matches!(atom, Atom::Power(base, _) if base.plainly_positive()))
                })
            })
    }
}

impl Atom {
    fn plainly_nonnegative(&self) -> bool {
        match self {
            Atom::Maximum(_) | Atom::Positive(_) | Atom::Root(_) => true,
            Atom::Power(base, _) => base.plainly_nonnegative(),
            Atom::Floor(inner) => inner.plainly_nonnegative(),
            Atom::Variable(_) | Atom::Apply(..) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    fn variable(name: &str) -> Value {
        Value::variable(&Name::new(name))
    }

    #[test]
    fn fractions_cancel() {
        let (x, y) = (variable("x"), variable("y"));
        let difference = x.mul(&x).unwrap().sub(&y.mul(&y).unwrap()).unwrap();
        let quotient = difference.div(&x.sub(&y).unwrap()).unwrap();
        assert_eq!(quotient, x.add(&y).unwrap());
        assert!(Value::zero().is_zero() && x.div(&Value::zero()).is_err());
    }

    #[test]
    fn roots_leave_denominators() {
        let two = Value::integer(2).sqrt().unwrap();
        let value = Value::one().div(&Value::one().add(&two).unwrap()).unwrap();
        assert_eq!(value, two.sub(&Value::one()).unwrap());
        assert_eq!(two.mul(&two).unwrap(), Value::integer(2));
    }
}
