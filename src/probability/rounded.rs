//! Long numbers of a run that is simulated, rounded to numbers of the machine: what follows from draws has more digits, and
//! roots in roots, after every round, and an estimate needs none of them.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::term::Term;
use crate::value::{Atom, Sum, Value, View};

/// Bits that a number may have, with roots and without: ties of rationals are decided by their digits.
const WITH_ROOTS: u64 = 160;
const LONG: u64 = 4_096;

/// The process with numbers that are not long.
pub(super) fn rounded(term: &Term) -> Term {
    let children: Vec<Term> = term.children().map(rounded).collect();
    let term = if children.is_empty() { term.clone() } else { term.with_children(children) };
    let image = |value: &Value| Ok::<Value, std::convert::Infallible>(short(value).unwrap_or_else(|| value.clone()));
    match term.map_values(&mut { image }) {
        Ok(term) => term,
    }
}

/// A long number, rounded; none of one that is short, or no number.
fn short(value: &Value) -> Option<Value> {
    match value.view() {
        View::Vector(parts) => {
            let short = parts.iter().map(|part| short(part).unwrap_or_else(|| part.clone())).collect();
            Value::vector(short).ok()
        }
        View::Real(top, bottom) if bits(value) > if value.as_rational().is_some() { LONG } else { WITH_ROOTS } => {
            let number = BigRational::from_float(near(&top)? / near(&bottom)?)?;
            Some(Value::rational(number))
        }
        _ => None,
    }
}

/// The bits of the longest coefficient, also in roots.
fn bits(value: &Value) -> u64 {
    let within = |atom: &Atom| match atom {
        Atom::Root(square) => bits(square),
        _ => 0,
    };
    value.atoms().iter().map(within).max().unwrap_or(0).max(value.bits())
}

fn near(sum: &Sum) -> Option<f64> {
    let mut all = 0.0;
    for (factor, atoms) in sum {
        let mut term = factor.to_f64()?;
        for (atom, exponent) in atoms {
            let Atom::Root(square) = atom else { return None };
            let View::Real(top, bottom) = square.view() else { return None };
            term *= (near(&top)? / near(&bottom)?).max(0.0).sqrt().powi(i32::try_from(*exponent).ok()?);
        }
        all += term;
    }
    Some(all)
}
