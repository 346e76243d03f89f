//! As text: powers of numbers and of real square roots written out, complex pairs as real parts, roots of higher degree
//! as a sum over the roots of their polynomial.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::{ExponentialPolynomial, is_unit, middle_and_square};
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Value, ValueError};

/// What the imaginary unit is called, the first that nothing else is.
const UNITS: [&str; 4] = ["i", "j", "I", "J"];
/// What the unknown of a polynomial is called, the first that nothing else is.
const UNKNOWNS: [&str; 4] = ["x", "y", "z", "w"];

impl ExponentialPolynomial {
    /// As text in the index.
    ///
    /// # Errors
    /// When a coefficient is too large.
    pub fn text(&self, index: &Name) -> Result<String, ValueError> {
        let count = Value::variable(index);
        let mut rational = Value::zero();
        let mut pieces = Vec::new();
        for (modulus, rows) in &self.parts {
            let row = collected(rows, &count, modulus.degree())?;
            match modulus.degree() {
                1 => {
                    let root = Value::rational(-modulus.coefficient(0));
                    rational = rational.add(&row[0].mul(&root.power(&count)?)?)?;
                }
                2 => pieces.extend(quadratic(modulus, &row, index)?),
                _ => pieces.push(over_roots(modulus, &row, index)),
            }
        }
        if pieces.is_empty() || !rational.is_zero() {
            pieces.insert(0, rational.to_string());
        }
        Ok(joined(&pieces, " "))
    }
}

/// The coefficients by the power of x, as values in the index.
fn collected(rows: &[Vec<Value>], count: &Value, degree: usize) -> Result<Vec<Value>, ValueError> {
    let mut all = vec![Value::zero(); degree];
    for row in rows.iter().rev() {
        for (sum, value) in all.iter_mut().zip(row) {
            *sum = sum.mul(count)?.add(value)?;
        }
    }
    Ok(all)
}

fn quadratic(modulus: &Univariate, row: &[Value], index: &Name) -> Result<Vec<String>, ValueError> {
    let (middle, square) = middle_and_square(modulus);
    let inner = row[0].add(&row[1].mul(&Value::rational(middle.clone()))?)?;
    let distance = Value::rational(square.abs()).sqrt()?;
    let outer = row[1].mul(&distance)?;
    let middle = Value::rational(middle);
    if square.is_positive() {
        let of = |coefficient: Value, root: Value| times(&coefficient, &root, index);
        let plus = of(inner.add(&outer)?, middle.add(&distance)?);
        let minus = of(inner.sub(&outer)?, middle.sub(&distance)?);
        return Ok([plus, minus].into_iter().flatten().collect());
    }
    let unit = free(&UNITS, row, index);
    let coefficient = complex(&inner, &outer, unit);
    let root = complex(&middle, &distance, unit);
    let text = if is_sum(&coefficient) { format!("({coefficient})") } else { coefficient };
    Ok(vec![format!("2*Re({text}*({root})^{index})")])
}

/// `coefficient * root^n`, if it is not 0.
fn times(coefficient: &Value, root: &Value, index: &Name) -> Option<String> {
    if coefficient.is_zero() {
        return None;
    }
    let power = format!("({root})^{index}");
    let factor = match coefficient.as_rational() {
        Some(number) if is_unit(&number) => return Some(power),
        _ => coefficient.to_string(),
    };
    Some(if is_sum(&factor) { format!("({factor})*{power}") } else { format!("{factor}*{power}") })
}

/// The first of these names that neither the index nor anything in the coefficients is called.
fn free(names: &[&'static str], row: &[Value], index: &Name) -> &'static str {
    let taken = |name: &str| index.as_str() == name || row.iter().any(|value| value.mentions(&Name::new(name)));
    names.iter().copied().find(|name| !taken(name)).unwrap_or(names[0])
}

/// `a+b*i`, given what the imaginary unit is called.
fn complex(real: &Value, imaginary: &Value, unit: &str) -> String {
    let unit = |value: &Value| match value.as_rational() {
        Some(number) if is_unit(&number) => unit.to_string(),
        _ => {
            let text = value.to_string();
            if is_sum(&text) { format!("({text})*{unit}") } else { format!("{text}*{unit}") }
        }
    };
    if imaginary.is_zero() {
        return real.to_string();
    }
    let negative = imaginary.to_string().strip_prefix('-').is_some_and(|rest| !is_sum(rest));
    let part = match (negative, imaginary.neg()) {
        (true, Ok(opposite)) => format!("-{}", unit(&opposite)),
        _ => format!("+{}", unit(imaginary)),
    };
    if real.is_zero() { part.trim_start_matches('+').to_string() } else { format!("{real}{part}") }
}

/// Whether a text has a sign outside all brackets, but for one before it.
fn is_sum(text: &str) -> bool {
    let mut depth = 0usize;
    let sign = text.chars().enumerate().any(|(place, letter)| {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        place > 0 && depth == 0 && matches!(letter, '+' | '-')
    });
    sign || text.starts_with("if ")
}

/// The sum of some texts: `a - b + c`.
fn joined(pieces: &[String], space: &str) -> String {
    let mut text = String::new();
    for piece in pieces {
        match (piece.strip_prefix('-').filter(|rest| !is_sum(rest)), text.is_empty()) {
            (_, true) => text.push_str(piece),
            (Some(size), false) => text.push_str(&format!("{space}-{space}{size}")),
            (None, false) => text.push_str(&format!("{space}+{space}{piece}")),
        }
    }
    text
}

fn over_roots(modulus: &Univariate, row: &[Value], index: &Name) -> String {
    let unknown = free(&UNKNOWNS, row, index);
    let numbers: Option<Vec<BigRational>> = row.iter().map(Value::as_rational).collect();
    let coefficient = match numbers {
        Some(numbers) => Univariate::new(numbers).text(unknown),
        None => {
            let terms = row.iter().enumerate().filter(|(_, value)| !value.is_zero()).map(|(place, value)| {
                let text = value.to_string();
                let text = if is_sum(&text) { format!("({text})") } else { text };
                match place {
                    0 => text,
                    1 => format!("{text}*{unknown}"),
                    _ => format!("{text}*{unknown}^{place}"),
                }
            });
            joined(&terms.collect::<Vec<_>>(), "")
        }
    };
    let polynomial = modulus.text(unknown);
    let factor = if coefficient == "1" {
        String::new()
    } else if is_sum(&coefficient) {
        format!("({coefficient})*")
    } else {
        format!("{coefficient}*")
    };
    let zero = BigRational::zero();
    format!("sum over the roots {unknown} of {polynomial} = {zero} of {factor}{unknown}^{index}")
}
