//! Linear fractional maps, `x(n+1) = (a*x(n) + b)/(c*x(n) + d)`: the numerator and the denominator of x are two sequences that
//! are linear together.

use super::{Unknown, solve_all};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Form, Recurrence, Sequence, term};
use crate::name::Name;
use crate::value::{Atom, Value};

/// `a*x + b`, by a and b.
type Linear = (Value, Value);

/// A form of a sequence whose next term is a quotient of two expressions that are linear in it, with coefficients that do
/// not change; none where it is no such quotient.
///
/// # Errors
/// Where the two have roots: what they are; or when a value is too large.
pub(super) fn fractional(
    next: &Value,
    name: &Name,
    start: &Value,
    index: &Name,
    known: &Assumptions,
) -> Result<Option<(Form, Vec<Comparison>)>, Unknown> {
    let linear = |part: Option<Value>| {
        let (slope, rest) = part?.linear_in(name)?;
        (!slope.mentions(index) && !rest.mentions(index)).then_some((slope, rest))
    };
    let (Some(above), Some(below)) = (linear(next.numerator()), linear(next.denominator())) else { return Ok(None) };
    let names = [Name::new("[above]"), Name::new("[below]")];
    let [one, other] = [&names[0], &names[1]].map(|name| Value::variable(&term(name, index, 0)));
    let step = |(slope, rest): &Linear| slope.mul(&one)?.add(&rest.mul(&other)?);
    let sequence = |name: &Name, start: Value, next: Value| Sequence { name: name.clone(), start: vec![start], next };
    let sequences =
        vec![sequence(&names[0], start.clone(), step(&above)?), sequence(&names[1], Value::one(), step(&below)?)];
    let told = || apart(name, start, (&above, &below), index);
    let Ok(solved) = solve_all(Recurrence { index: index.clone(), from: 0, sequences }, known) else {
        return Err(told());
    };
    let rational = |form: &Form| form.value(index).filter(|value| !has_roots(value));
    match (rational(&solved.forms()[0]), rational(&solved.forms()[1])) {
        (Some(above), Some(below)) => {
            let quotient = solved.known().simplify(&above.div(&below)?);
            Ok(Some((Form::Value(Vec::new(), quotient), solved.conditions().to_vec())))
        }
        _ => Err(told()),
    }
}

/// Whether a value, or the base of a power in it, has roots.
fn has_roots(value: &Value) -> bool {
    value.atoms().iter().any(|atom| match atom {
        Atom::Root(_) => true,
        Atom::Power(base, _) => has_roots(base),
        _ => false,
    })
}

/// Why there is no form of a quotient whose numerator and denominator have roots: what these are.
fn apart(name: &Name, start: &Value, (above, below): (&Linear, &Linear), index: &Name) -> Unknown {
    let [one, other] = ["u", "v"].map(|letter| Value::variable(&term(&Name::new(letter), index, 0)));
    let next = |(slope, rest): &Linear| slope.mul(&one)?.add(&rest.mul(&other)?);
    let mut text = format!("no form of {name} without roots was found");
    if let (Ok(above), Ok(below)) = (next(above), next(below)) {
        text += &format!(
            "; it is u({index})/v({index}), where u({index}+1) = {above}, u(0) = {start}, v({index}+1) = {below}, v(0) = 1"
        );
    }
    Unknown::because(text)
}
