//! Closed forms of affine maps, and what kind of sequence a form is.

use super::{Comparison, Piece, Unknown};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The forms of `x := c*x + d` from a start, and the conditions under which they are right.
pub(super) fn affine_pieces(
    map: &Value,
    variable: &Name,
    start: &Value,
    index: &Name,
    known: &Assumptions,
) -> Result<(Vec<Piece>, Vec<Comparison>), Unknown> {
    let Some((factor, constant)) = map.linear_in(variable) else {
        return Err(Unknown::because(format!("{map} is not affine in {variable}")));
    };
    let (one, count) = (Value::one(), Value::variable(index));
    let piece = |from: i64, until: Option<i64>, form: Value| Piece {
        from: Value::integer(from),
        until: until.map(Value::integer),
        form,
    };
    if known.decide(Relation::Eq, &factor, &Value::zero()) == Some(true) {
        let rest = if known.decide(Relation::Eq, start, &constant) == Some(true) {
            vec![piece(0, None, start.clone())]
        } else {
            vec![piece(0, Some(1), start.clone()), piece(1, None, constant)]
        };
        return Ok((rest, Vec::new()));
    }
    let mut conditions = Vec::new();
    let form = match known.decide(Relation::Eq, &factor, &one) {
        Some(true) => {
            let step = map.sub(&Value::variable(variable))?;
            let step = if step.mentions(variable) { constant } else { step };
            start.add(&count.mul(&step)?)?
        }
        decided => {
            if decided.is_none() {
                conditions.push((Relation::Neq, factor.clone(), one.clone()));
            }
            let limit = constant.div(&one.sub(&factor)?)?;
            limit.add(&factor.power(&count)?.mul(&start.sub(&limit)?)?)?
        }
    };
    check(map, variable, start, index, &form, known)?;
    // Where it does not divide by `1-c`, it is right for c = 1 as well: `g+(1-k)^n*(r0-g)` for k = 0.
    conditions.retain(|_| !known.gives_meaning(&form));
    Ok((vec![piece(0, None, form)], conditions))
}

/// Base and step: `form(0) = start` and `map(form(n)) = form(n+1)`.
fn check(
    map: &Value,
    variable: &Name,
    start: &Value,
    index: &Name,
    form: &Value,
    known: &Assumptions,
) -> Result<(), Unknown> {
    let same = |left: &Value, right: &Value| left == right || known.decide(Relation::Eq, left, right) == Some(true);
    let next = form.with(index, &Value::variable(index).add(&Value::one())?)?;
    if same(&form.with(index, &Value::zero())?, start) && same(&map.with(variable, form)?, &next) {
        return Ok(());
    }
    Err(Unknown::because(format!("the form {form} could not be checked")))
}

/// What kind of sequence a value is, as a function of the index.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Free of the index.
    Constant,
    /// `base + n*step`
    Linear { base: Value, step: Value },
    /// `limit + factor * ratio^n`
    Geometric { limit: Value, factor: Value, ratio: Value },
}

/// The shape of a value, found from its differences.
pub(super) fn shape(value: &Value, index: &Name) -> Result<Shape, Unknown> {
    if !value.mentions(index) {
        return Ok(Shape::Constant);
    }
    let next = |value: &Value| value.with(index, &Value::variable(index).add(&Value::one())?);
    let step = next(value)?.sub(value)?;
    let base = value.with(index, &Value::zero())?;
    if !step.mentions(index) {
        return Ok(Shape::Linear { base, step });
    }
    let ratio = next(&step)?.div(&step)?;
    if ratio.mentions(index) {
        return Err(Unknown::because(of_no_shape(value, index)));
    }
    let factor = step.with(index, &Value::zero())?.div(&ratio.sub(&Value::one())?)?;
    Ok(Shape::Geometric { limit: base.sub(&factor)?, factor, ratio })
}

/// Why it is not known where a sequence comes to a bound that is neither linear nor geometric.
fn of_no_shape(value: &Value, index: &Name) -> String {
    let grows = |atom: &Atom| matches!(atom, Atom::Power(_, exponent) if exponent.mentions(index));
    let symbolic = value.variables().iter().any(|name| name != index);
    if value.atoms().iter().any(grows) && symbolic {
        return format!("where a sum of several powers, as {value}, comes to 0 is not solved for symbols");
    }
    format!("{value} is not known to be linear or geometric in {index}")
}
