//! One sequence `x(n+1) = a(n)*x(n) + b(n)`, where a is a quotient of polynomials in n: the solution of the
//! homogeneous part is the product of a, and a particular solution is looked for among rational functions times the
//! powers that b has.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::NoClosedForm;
use crate::closed_form::{Form, product};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::Value;

/// The highest degree of the numerator of a particular solution, above that of what is given.
const MORE_DEGREE: usize = 3;
/// The highest degree that is tried at all.
const MOST_DEGREE: usize = 24;

/// The form of a sequence that begins at 0.
pub(super) fn with_product(factor: &Value, input: &Value, start: &Value, index: &Name) -> Result<Form, NoClosedForm> {
    let whole = Value::variable(&product());
    if input.is_zero() {
        return Ok(Form::Product(factor.clone(), start.mul(&whole)?));
    }
    let none = || {
        NoClosedForm(format!(
            "the product of {factor} solves it without {input}; with it a sum remains, and no closed form of that is known"
        ))
    };
    let [above, below] = quotient(factor, index).ok_or_else(none)?;
    let mut particular = Value::zero();
    let (top, bottom) = (input.numerator().ok_or_else(none)?, input.denominator().ok_or_else(none)?);
    let count = Value::variable(index);
    let bottoms: Vec<_> = exponentials(&bottom, index).ok_or_else(none)?.into_iter().collect();
    let [(under, coefficients)] = bottoms.as_slice() else { return Err(none()) };
    let divisor = rational(coefficients).ok_or_else(none)?;
    for (base, coefficients) in exponentials(&top, index).ok_or_else(none)? {
        let base = base.div(under)?;
        let (numerator, number) = (rational(&coefficients).ok_or_else(none)?, base.as_rational().ok_or_else(none)?);
        let found = particular_of(&above, &below, [&numerator, &divisor], &number).ok_or_else(none)?;
        let [top, bottom] = found.map(|part| value_of(&part, &count));
        particular = particular.add(&top?.div(&bottom?)?.mul(&base.power(&count)?)?)?;
    }
    let rest = start.sub(&particular.with(index, &Value::zero())?)?;
    Ok(Form::Product(factor.clone(), particular.add(&rest.mul(&whole)?)?))
}

/// Numerator and denominator of a quotient of polynomials in the index with rational coefficients.
pub(super) fn quotient(value: &Value, index: &Name) -> Option<[Univariate; 2]> {
    let part = |part: Value| {
        let all: Vec<_> = exponentials(&part, index)?.into_iter().collect();
        match all.as_slice() {
            [(base, coefficients)] if base.as_rational().is_some_and(|base| base.is_one()) => rational(coefficients),
            _ => None,
        }
    };
    Some([part(value.numerator()?)?, part(value.denominator()?)?])
}

fn rational(coefficients: &[Value]) -> Option<Univariate> {
    coefficients.iter().map(Value::as_rational).collect::<Option<Vec<_>>>().map(Univariate::new)
}

fn value_of(polynomial: &Univariate, count: &Value) -> Result<Value, crate::value::ValueError> {
    let mut value = Value::zero();
    for coefficient in polynomial.coefficients().iter().rev() {
        value = value.mul(count)?.add(&Value::rational(coefficient.clone()))?;
    }
    Ok(value)
}

/// A quotient y with `base*y(n+1) - (above/below)(n)*y(n) = (p/q)(n)`.
fn particular_of(
    above: &Univariate,
    below: &Univariate,
    [p, q]: [&Univariate; 2],
    base: &BigRational,
) -> Option<[Univariate; 2]> {
    let back = |polynomial: &Univariate| shifted(polynomial, &-BigRational::one());
    let one = Univariate::one();
    let candidates =
        [one.clone(), back(below), above.clone(), back(q), back(below).times(&back(q)), back(below).times(above)];
    candidates.into_iter().find_map(|denominator| {
        // With y = u/d: base*below*q*d(n)*u(n+1) - above*q*d(n+1)*u(n) = p*below*d(n)*d(n+1).
        let next = shifted(&denominator, &BigRational::one());
        let ahead = below.times(q).times(&denominator).scale(base);
        let here = above.times(q).times(&next);
        let wanted = p.times(below).times(&denominator).times(&next);
        let most = (wanted.degree() + MORE_DEGREE).min(MOST_DEGREE);
        solve_polynomial(&ahead, &here, &wanted, most).map(|numerator| [numerator, denominator])
    })
}

/// `p(n + by)`
fn shifted(polynomial: &Univariate, by: &BigRational) -> Univariate {
    let step = Univariate::new(vec![by.clone(), BigRational::one()]);
    polynomial
        .coefficients()
        .iter()
        .rev()
        .fold(Univariate::zero(), |sum, number| sum.times(&step).plus(&Univariate::new(vec![number.clone()])))
}

/// A polynomial u of at most this degree with `ahead*u(n+1) - here*u(n) = wanted`.
fn solve_polynomial(ahead: &Univariate, here: &Univariate, wanted: &Univariate, most: usize) -> Option<Univariate> {
    let columns: Vec<Univariate> = (0..=most)
        .map(|power| {
            let mut monomial = vec![BigRational::zero(); power];
            monomial.push(BigRational::one());
            let monomial = Univariate::new(monomial);
            ahead.times(&shifted(&monomial, &BigRational::one())).minus(&here.times(&monomial))
        })
        .collect();
    let height = columns.iter().chain([wanted]).map(Univariate::degree).max()? + 1;
    let mut rows: Vec<Vec<BigRational>> = (0..height)
        .map(|place| columns.iter().chain([wanted]).map(|column| column.coefficient(place)).collect())
        .collect();
    let mut pivots = Vec::new();
    for column in 0..=most {
        let Some(found) = (pivots.len()..height).find(|row| !rows[*row][column].is_zero()) else { continue };
        let target = pivots.len();
        rows.swap(target, found);
        let scale = rows[target][column].recip();
        rows[target].iter_mut().for_each(|number| *number *= &scale);
        let pivot = rows[target].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(place, row)| *place != target && !row[column].is_zero()) {
            let factor = row[column].clone();
            row.iter_mut().zip(&pivot).for_each(|(number, other)| *number -= &factor * other);
        }
        pivots.push(column);
    }
    if rows[pivots.len()..].iter().any(|row| !row[most + 1].is_zero()) {
        return None;
    }
    let mut coefficients = vec![BigRational::zero(); most + 1];
    for (row, column) in rows.iter().zip(&pivots) {
        coefficients[*column] = row[most + 1].clone();
    }
    Some(Univariate::new(coefficients))
}
