//! Long numbers of a run that is simulated, rounded to numbers of the machine: what follows from draws has more digits, and
//! roots in roots, after every round, and an estimate needs none of them.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use crate::term::Term;
use crate::value::{Atom, Sum, Value, View};

/// Bits that a number may have, with roots, where one that is drawn has more, and without: ties of rationals are decided by
/// their digits.
const WITH_ROOTS: u64 = 48;
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
            BigRational::from_float(near(&top)? / near(&bottom)?).map(Value::rational)
        }
        _ => None,
    }
}

/// The bits of the longest coefficient, also in roots, maxima and conditions.
fn bits(value: &Value) -> u64 {
    let within = |atom: &Atom| match atom {
        Atom::Root(part) | Atom::Positive(part) | Atom::Floor(part) => bits(part),
        Atom::Maximum(parts) => parts.iter().map(bits).max().unwrap_or(0),
        _ => 0,
    };
    value.atoms().iter().map(within).max().unwrap_or(0).max(value.bits())
}

fn near(sum: &Sum) -> Option<f64> {
    let mut all = 0.0;
    for (factor, atoms) in sum {
        let mut term = factor.to_f64()?;
        for (atom, exponent) in atoms {
            let number = match atom {
                Atom::Root(part) => number(part)?.max(0.0).sqrt(),
                Atom::Positive(part) => f64::from(number(part)? > 0.0),
                Atom::Floor(part) => number(part)?.floor(),
                // A maximum in normal form is over 0 as well.
                Atom::Maximum(parts) => {
                    parts.iter().map(number).try_fold(0.0, |most: f64, part| Some(most.max(part?)))?
                }
                _ => return None,
            };
            term *= number.powi(i32::try_from(*exponent).ok()?);
        }
        all += term;
    }
    Some(all)
}

fn number(value: &Value) -> Option<f64> {
    let View::Real(top, bottom) = value.view() else { return None };
    Some(near(&top)? / near(&bottom)?)
}
