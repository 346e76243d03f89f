//! One sequence `x(n+1) = a(n)*x(n) + b(n)`, where a is a quotient of polynomials in n: the solution of the
//! homogeneous part is the product of a, and a particular solution is looked for among rational functions times the
//! powers that b has.

use num_rational::BigRational;
use num_traits::One;

use super::Unknown;
use super::rational::solution;
use crate::closed_form::{Form, product};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::Value;

/// The form of a sequence that begins at 0.
pub(super) fn with_product(factor: &Value, input: &Value, start: &Value, index: &Name) -> Result<Form, Unknown> {
    let whole = Value::variable(&product());
    if input.is_zero() {
        return Ok(Form::Product(factor.clone(), start.mul(&whole)?));
    }
    let none = || {
        if factor.is_zero() {
            return Unknown::because(format!("the next term is {input}, of which no form could be checked"));
        }
        Unknown::because(format!(
            "without {input} it is a product of {factor}; with it a sum remains, and no closed form of that is known"
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

/// A polynomial at a value.
pub(super) fn value_of(polynomial: &Univariate, count: &Value) -> Result<Value, crate::value::ValueError> {
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
    solution(&below.times(q).scale(base), &above.times(q), &p.times(below))
}
