//! One sequence `x(n+1) = a*x(n) + b(n)`, where a and the parts of b may be symbolic.

use num_rational::BigRational;
use num_traits::One;

use super::{Comparison, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::Form;
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The form, and the conditions under which it is right; `None` if the input is no sum of polynomials times powers.
pub(super) fn first_order(
    factor: &Value,
    input: &Value,
    start: &Value,
    index: &Name,
    known: &Assumptions,
) -> Result<Option<(Form, Vec<Comparison>)>, Unknown> {
    let Some(parts) = exponentials(input, index) else { return Ok(None) };
    let count = Value::variable(index);
    if known.decide(Relation::Eq, factor, &Value::zero()) == Some(true) {
        let (mut early, mut rest) = (vec![start.clone()], input.clone());
        // 0^n counts at 0 alone, and has no value at an index before.
        if let Some((_, coefficients)) = parts.iter().find(|(base, _)| base.is_zero()) {
            early.push(input.with(index, &Value::zero())?);
            rest = input.sub(&times_power(&Value::zero(), coefficients, &count)?)?;
        }
        let before = rest.with(index, &count.sub(&Value::one())?)?;
        return Ok(Some((Form::Value(early, before), Vec::new())));
    }
    let mut particular = Value::zero();
    let mut conditions: Vec<Comparison> = Vec::new();
    for (base, coefficients) in parts {
        let polynomial = match known.decide(Relation::Eq, &base, factor) {
            Some(true) => resonant(factor, &coefficients)?,
            decided => {
                if decided.is_none() {
                    conditions.extend(apart(factor, &base, known)?);
                }
                off_resonance(&base, factor, &coefficients)?
            }
        };
        particular = particular.add(&times_power(&base, &polynomial, &count)?)?;
    }
    let rest = start.sub(&particular.with(index, &Value::zero())?)?;
    let form = known.simplify(&particular.add(&rest.mul(&factor.power(&count)?)?)?);
    Ok(Some((Form::Value(Vec::new(), form), conditions)))
}

/// `p(n)*base^n`
fn times_power(base: &Value, polynomial: &[Value], count: &Value) -> Result<Value, Unknown> {
    let mut value = Value::zero();
    for coefficient in polynomial.iter().rev() {
        value = value.mul(count)?.add(coefficient)?;
    }
    Ok(value.mul(&base.power(count)?)?)
}

/// That two values differ: what they have in common as a factor is not 0, and the others differ. `K != 0` and `r != 1` for
/// K*r and K.
fn apart(one: &Value, other: &Value, known: &Assumptions) -> Result<Vec<Comparison>, Unknown> {
    let whole = || vec![(Relation::Neq, one.clone(), other.clone())];
    let difference = one.sub(other)?;
    let Some((numerator, denominator)) = difference.polynomials() else { return Ok(whole()) };
    let content = numerator.monomial_content();
    let plain = content.factors().iter().all(|(atom, _)| matches!(atom, Atom::Variable(_)));
    if denominator.as_constant().is_none() || content.factors().is_empty() || !plain {
        return Ok(whole());
    }
    let (mut common, mut all) = (Value::one(), Vec::new());
    for (atom, exponent) in content.factors() {
        let value = atom.value()?;
        common = common.mul(&value.power(&Value::integer(i64::from(*exponent)))?)?;
        if known.decide(Relation::Neq, &value, &Value::zero()) != Some(true) {
            all.push((Relation::Neq, value, Value::zero()));
        }
    }
    let (one, other) = (one.div(&common)?, other.div(&common)?);
    if known.decide(Relation::Neq, &one, &other) != Some(true) {
        // A number stands on the right.
        let (left, right) = if one.as_rational().is_some() { (other, one) } else { (one, other) };
        all.push((Relation::Neq, left, right));
    }
    Ok(all)
}

/// The polynomial q with `base*q(n+1) - factor*q(n) = p(n)`.
fn off_resonance(base: &Value, factor: &Value, p: &[Value]) -> Result<Vec<Value>, Unknown> {
    let mut q = vec![Value::zero(); p.len()];
    let divisor = base.sub(factor)?;
    for place in (0..p.len()).rev() {
        let mut rest = p[place].clone();
        for (above, value) in q.iter().enumerate().skip(place + 1) {
            rest = rest.sub(&value.mul(base)?.mul(&binomial(above, place))?)?;
        }
        q[place] = rest.div(&divisor)?;
    }
    Ok(q)
}

/// The polynomial q without constant with `factor*(q(n+1) - q(n)) = p(n)`.
fn resonant(factor: &Value, p: &[Value]) -> Result<Vec<Value>, Unknown> {
    let mut q = vec![Value::zero(); p.len() + 1];
    for place in (0..p.len()).rev() {
        let mut rest = p[place].div(factor)?;
        for (above, value) in q.iter().enumerate().skip(place + 2) {
            rest = rest.sub(&value.mul(&binomial(above, place))?)?;
        }
        q[place + 1] = rest.mul(&Value::rational(BigRational::new(1.into(), (place + 1).into())))?;
    }
    Ok(q)
}

fn binomial(above: usize, below: usize) -> Value {
    let mut number = BigRational::one();
    for step in 0..below {
        number *= BigRational::new((above - step).into(), (step + 1).into());
    }
    Value::rational(number)
}
