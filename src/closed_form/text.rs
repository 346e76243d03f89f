//! Closed forms as text.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive};

use super::{Form, Solved, product};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Value, ValueError};

impl Solved {
    /// One line for each form of each sequence, and one for each condition.
    pub fn lines(&self) -> Vec<String> {
        let recurrence = &self.recurrence;
        let mut lines = Vec::new();
        for (sequence, form) in recurrence.sequences.iter().zip(&self.forms) {
            lines.extend(form_lines(form, &sequence.name, &recurrence.index, recurrence.from));
        }
        for (relation, left, right) in &self.conditions {
            lines.push(format!("if {left} {} {right}", relation.symbol()));
        }
        lines
    }
}

fn form_lines(form: &Form, name: &Name, index: &Name, from: i64) -> Vec<String> {
    let first = |early: &[Value]| {
        let terms = early.iter().enumerate();
        terms.map(|(place, value)| format!("{name}({}) = {value}", from + place as i64)).collect::<Vec<_>>()
    };
    let (mut lines, value) = match form {
        Form::Value(early, value) => (first(early), Ok(value.to_string())),
        Form::Sum(early, sum) => (first(early), sum.text(index)),
        Form::Product(ratio, value) => (Vec::new(), product_text(ratio, value, index, from)),
        Form::Turns(forms) => return turns(forms, name, index, from),
        Form::Pieces(pieces) => {
            let line = |piece: &super::Piece| {
                let range = match (&piece.until, piece.from.is_zero()) {
                    (None, true) => String::new(),
                    (None, false) => format!(" for {} <= {index}", piece.from),
                    (Some(until), true) => format!(" for {index} < {until}"),
                    (Some(until), false) => format!(" for {} <= {index} < {until}", piece.from),
                };
                format!("{name}({index}) = {}{range}", piece.form)
            };
            return pieces.iter().map(line).collect();
        }
    };
    let text = value.unwrap_or_else(|error| error.to_string());
    let range = if lines.is_empty() { String::new() } else { format!(" for {} <= {index}", from + lines.len() as i64) };
    lines.push(format!("{name}({index}) = {text}{range}"));
    lines
}

fn turns(forms: &[Form], name: &Name, index: &Name, from: i64) -> Vec<String> {
    let mut lines = Vec::new();
    for (turn, form) in forms.iter().enumerate() {
        let offset = from + turn as i64;
        let place = match offset {
            0 => format!("{}*{index}", forms.len()),
            _ if offset > 0 => format!("{}*{index}+{offset}", forms.len()),
            _ => format!("{}*{index}{offset}", forms.len()),
        };
        let (early, text) = match form {
            Form::Value(early, value) => (early.as_slice(), Ok(value.to_string())),
            Form::Sum(early, sum) => (early.as_slice(), sum.text(index)),
            Form::Product(ratio, value) => ([].as_slice(), product_text(ratio, value, index, 0)),
            _ => continue,
        };
        let text = text.unwrap_or_else(|error| error.to_string());
        lines.extend(
            early
                .iter()
                .enumerate()
                .map(|(round, value)| format!("{name}({}) = {value}", offset + (round * forms.len()) as i64)),
        );
        let range = if early.is_empty() { String::new() } else { format!(" for {} <= {index}", early.len()) };
        lines.push(format!("{name}({place}) = {text}{range}"));
    }
    lines
}

/// The product in factorials where its factors are `n + a` with whole numbers a.
fn product_text(ratio: &Value, value: &Value, index: &Name, from: i64) -> Result<String, ValueError> {
    let whole = match factorials(ratio, index, from) {
        Some(whole) => whole,
        None => {
            let (count, under) = (Name::new("k"), format!("prod(k={from}..{index}-1, "));
            Value::variable(&Name::new(&format!("{under}{})", ratio.with(index, &Value::variable(&count))?)))
        }
    };
    Ok(value.with(&product(), &whole)?.to_string())
}

/// `ratio(from) * … * ratio(n-1)` in factorials and powers.
fn factorials(ratio: &Value, index: &Name, from: i64) -> Option<Value> {
    let count = Value::variable(index).sub(&Value::integer(from)).ok()?;
    let mut whole = Value::one();
    for (part, below) in [(ratio.numerator()?, false), (ratio.denominator()?, true)] {
        // A power c^n in the ratio is c^(0 + 1 + … ) in the product.
        let parts: Vec<_> = exponentials(&part, index)?.into_iter().collect();
        let [(base, coefficients)] = parts.as_slice() else { return None };
        let base = base.as_rational()?;
        let coefficients: Vec<BigRational> = coefficients.iter().map(Value::as_rational).collect::<Option<_>>()?;
        let polynomial = Univariate::new(coefficients);
        if polynomial.degree() > 40 {
            return None;
        }
        let lead = Value::rational(polynomial.coefficient(polynomial.degree()));
        let mut factor = lead.power(&count).ok()?;
        if !base.is_one() {
            let n = Value::variable(index);
            let twice = n.mul(&n).ok()?.sub(&n).ok()?.sub(&Value::integer(from * (from - 1))).ok()?;
            let sum = twice.mul(&Value::fraction(1, 2).ok()?).ok()?;
            factor = factor.mul(&Value::rational(base).power(&sum).ok()?).ok()?;
        }
        for (linear, times) in polynomial.factors() {
            let shift = (linear.degree() == 1).then(|| linear.coefficient(0))?;
            let first = &shift + BigRational::from_integer(BigInt::from(from));
            if !first.is_integer() || !first.is_positive() || first.to_i64()? > 20 {
                return None;
            }
            let top = Value::variable(index).add(&Value::rational(shift - BigRational::one())).ok()?;
            let bottom = (1..first.to_i64()?).product::<i64>();
            let name = if top.as_variable().is_some() { format!("{top}!") } else { format!("({top})!") };
            let quotient = Value::variable(&Name::new(&name)).div(&Value::integer(bottom)).ok()?;
            factor = factor.mul(&quotient.power(&Value::integer(i64::try_from(times).ok()?)).ok()?).ok()?;
        }
        whole = if below { whole.div(&factor).ok()? } else { whole.mul(&factor).ok()? };
    }
    Some(whole)
}
