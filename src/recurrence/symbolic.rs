//! Linear systems with symbolic coefficients: the characteristic polynomial is taken apart over the parameters, and the
//! partial fractions of the generating function at its factors are the closed form, where these are linear or quadratic.
//!
//! The roots of a quadratic factor are written with the square root of its discriminant, under the condition that this
//! is positive. Which other parameters may not be equal follows from what the form divides by.

use std::collections::BTreeSet;

use super::factors::factors;
use super::sequences::Found;
use super::{Comparison, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence};
use crate::exponential_polynomial::exponentials;
use crate::polynomial::{Budget, Polynomial};
use crate::value::{Relation, Value, ValueError};

/// The most terms that depend on each other, and the highest degree of the polynomial that they solve.
const MOST_VARIABLES: usize = 8;
const MOST_DEGREE: usize = 10;
/// The work that may go into one exact quotient.
const WORK: u64 = 20_000;

/// The coefficients of a polynomial in x, from the constant up, or of an element modulo one.
type Row = Vec<Value>;

/// A base c of the powers `c^n` in an input, and how often it counts: one more than the highest power of n with it.
type Base = (Value, usize);

/// A factor of the characteristic polynomial, of degree 1 or 2: its lower coefficients, how often it divides.
struct Factor {
    modulus: Row,
    count: usize,
}

/// The forms of a linear recurrence that begins at 0, with what must hold; nothing if it is not linear with coefficients that are
/// the same for all n.
pub(super) fn symbolic(recurrence: &Recurrence, known: &Assumptions) -> Result<Option<Found>, Unknown> {
    let Some((matrix, inputs)) = system(recurrence) else { return Ok(None) };
    if matrix.len() > MOST_VARIABLES {
        let symbols = matrix.iter().flatten().any(|entry| entry.as_rational().is_none());
        let with = if symbols { ", with symbols" } else { "" };
        return Err(Unknown::because(format!("{} terms depend on each other{with}: too many", matrix.len())));
    }
    let polynomial = characteristic(&matrix)?;
    let mut all = split(&polynomial, known)?;
    for (base, count) in inputs {
        include(&mut all, vec![base.neg()?], count);
    }
    let zeros = all.iter().position(|factor| matches!(factor.modulus.as_slice(), [zero] if zero.is_zero()));
    let zeros = zeros.map_or(0, |place| all.remove(place).count);
    let mut whole = vec![Value::one()];
    for factor in &all {
        for _ in 0..factor.count {
            whole = times(&whole, &[factor.modulus.as_slice(), &[Value::one()]].concat())?;
        }
    }
    let degree = whole.len() - 1;
    if degree + zeros > MOST_DEGREE {
        return Err(Unknown::because("the system is too large, with symbols"));
    }
    let mut conditions = real(&all, known)?;
    let mut forms = Vec::new();
    for terms in recurrence.iterate(degree + zeros)? {
        let value = form(&terms[zeros..], zeros, &whole, &all, recurrence)?;
        forms.push(Form::Value(terms[..zeros].to_vec(), known.simplify(&value)));
    }
    conditions.extend(distinct(&all, &forms, known)?);
    Ok(Some((forms, conditions)))
}

/// The matrix, and the bases of the inputs with how often each counts.
fn system(recurrence: &Recurrence) -> Option<(Vec<Row>, Vec<Base>)> {
    let index = &recurrence.index;
    let variables = recurrence.terms();
    let (mut matrix, mut inputs): (Vec<Row>, Vec<Base>) = (Vec::new(), Vec::new());
    for (at, (_, place, offset)) in variables.iter().enumerate() {
        let sequence = &recurrence.sequences[*place];
        let mut row = vec![Value::zero(); variables.len()];
        if offset + 1 < sequence.start.len() {
            row[at + 1] = Value::one();
            matrix.push(row);
            continue;
        }
        let mut rest = sequence.next.clone();
        for (column, (name, ..)) in variables.iter().enumerate().filter(|(_, (name, ..))| sequence.next.mentions(name))
        {
            let (factor, constant) = rest.linear_in(name)?;
            let free = !factor.mentions(index) && variables.iter().all(|(other, ..)| !factor.mentions(other));
            row[column] = free.then_some(factor)?;
            rest = constant;
        }
        for (base, coefficients) in exponentials(&rest, index)? {
            match inputs.iter_mut().find(|(other, _)| *other == base) {
                Some((_, count)) => *count = coefficients.len().max(*count),
                None => inputs.push((base, coefficients.len())),
            }
        }
        matrix.push(row);
    }
    Some((matrix, inputs))
}

/// `det(x - A)` without its leading 1 (Faddeev and LeVerrier).
fn characteristic(matrix: &[Row]) -> Result<Row, ValueError> {
    let size = matrix.len();
    let mut coefficients = vec![Value::zero(); size];
    let mut last: Vec<Row> = vec![vec![Value::zero(); size]; size];
    let mut lead = Value::one();
    for step in 1..=size {
        // M := A*M + lead*I, and the next coefficient is -tr(A*M)/step.
        for (place, row) in last.iter_mut().enumerate() {
            row[place] = row[place].add(&lead)?;
        }
        let mut product = vec![vec![Value::zero(); size]; size];
        for (row, own) in product.iter_mut().zip(matrix) {
            for (factor, other) in own.iter().zip(&last).filter(|(factor, _)| !factor.is_zero()) {
                for (sum, value) in row.iter_mut().zip(other).filter(|(_, value)| !value.is_zero()) {
                    *sum = sum.add(&factor.mul(value)?)?;
                }
            }
        }
        let mut trace = Value::zero();
        for (place, row) in product.iter().enumerate() {
            trace = trace.add(&row[place])?;
        }
        lead = trace.div(&Value::integer(-i64::try_from(step).unwrap_or(i64::MAX)))?;
        coefficients[size - step] = lead.clone();
        last = product;
    }
    Ok(coefficients)
}

/// Its factors, which must all be of degree 1 or 2.
fn split(polynomial: &[Value], known: &Assumptions) -> Result<Vec<Factor>, Unknown> {
    let text = || {
        let mut terms = vec![format!("x^{}", polynomial.len())];
        let named = polynomial.iter().enumerate().rev().filter(|(_, value)| !value.is_zero());
        terms.extend(named.map(|(place, value)| match place {
            0 => format!("({value})"),
            1 => format!("({value})*x"),
            _ => format!("({value})*x^{place}"),
        }));
        terms.join("+")
    };
    let found = factors(polynomial).ok_or_else(|| {
        Unknown::because(format!("the characteristic polynomial {} could not be taken apart", text()))
    })?;
    let mut all = Vec::new();
    for (modulus, count) in found {
        if modulus.len() > 2 {
            return Err(Unknown::because(format!(
                "the characteristic polynomial {} has a factor of degree {} that does not come apart for all values of its symbols",
                text(),
                modulus.len()
            )));
        }
        if modulus.len() == 2 && known.decide(Relation::Gtr, &discriminant(&modulus)?[0], &Value::zero()) == Some(false)
        {
            return Err(Unknown::because(format!(
                "the characteristic polynomial {} has no two real roots, and complex ones are known of rational coefficients only",
                text()
            )));
        }
        include(&mut all, modulus, count);
    }
    Ok(all)
}

fn include(all: &mut Vec<Factor>, modulus: Row, count: usize) {
    match all.iter_mut().find(|factor| factor.modulus == modulus) {
        Some(factor) => factor.count += count,
        None => all.push(Factor { modulus, count }),
    }
}

/// A d without denominator and an e such that `d/e^2` is `b^2 - 4*c` of `x^2 + b*x + c`.
fn discriminant(modulus: &[Value]) -> Result<[Value; 2], ValueError> {
    let whole = modulus[1].mul(&modulus[1])?.sub(&modulus[0].mul(&Value::integer(4))?)?;
    let below = whole.denominator().unwrap_or_else(Value::one);
    Ok([whole.mul(&below)?.mul(&below)?, below])
}

/// The discriminants must be positive.
fn real(all: &[Factor], known: &Assumptions) -> Result<Vec<Comparison>, Unknown> {
    let mut conditions = Vec::new();
    for factor in all.iter().filter(|factor| factor.modulus.len() == 2) {
        let [discriminant, _] = discriminant(&factor.modulus)?;
        if known.decide(Relation::Gtr, &discriminant, &Value::zero()) != Some(true) {
            conditions.push((Relation::Gtr, discriminant, Value::zero()));
        }
    }
    Ok(conditions)
}

/// The roots that the forms need to differ: those by whose difference a form divides.
fn distinct(all: &[Factor], forms: &[Form], known: &Assumptions) -> Result<Vec<Comparison>, Unknown> {
    let roots: Vec<Value> = all
        .iter()
        .filter(|factor| factor.modulus.len() == 1)
        .map(|factor| factor.modulus[0].neg())
        .collect::<Result<_, _>>()?;
    let values = forms.iter().filter_map(|form| if let Form::Value(_, value) = form { Some(value) } else { None });
    let below: Vec<_> = values.filter_map(|value| value.polynomials().map(|(_, below)| below.clone())).collect();
    let mut found = BTreeSet::new();
    for (place, one) in roots.iter().enumerate() {
        for other in &roots[..place] {
            let difference = one.sub(other)?;
            let Some((above, _)) = difference.polynomials() else { continue };
            if above.as_constant().is_some() {
                continue;
            }
            if below.iter().any(|below| below.divide(above, &mut Budget::new(WORK)).is_some())
                && known.decide(Relation::Neq, one, other) != Some(true)
            {
                // `2*k` is 0 only where k is.
                let part = Value::from_polynomials(above.primitive(), Polynomial::one())?;
                found.insert(match part.as_atom() {
                    Some(_) => (Relation::Neq, part, Value::zero()),
                    None => (Relation::Neq, one.clone(), other.clone()),
                });
            }
        }
    }
    Ok(found.into_iter().collect())
}

fn times(left: &[Value], right: &[Value]) -> Result<Row, ValueError> {
    let mut product = vec![Value::zero(); (left.len() + right.len()).saturating_sub(1)];
    for (place, one) in left.iter().enumerate().filter(|(_, one)| !one.is_zero()) {
        for (offset, other) in right.iter().enumerate().filter(|(_, other)| !other.is_zero()) {
            product[place + offset] = product[place + offset].add(&one.mul(other)?)?;
        }
    }
    Ok(product)
}

impl Factor {
    /// What is left of a polynomial in x modulo this one.
    fn reduced(&self, mut row: Row) -> Result<Row, ValueError> {
        let degree = self.modulus.len();
        while row.len() > degree {
            let Some(top) = row.pop().filter(|top| !top.is_zero()) else { continue };
            let place = row.len() - degree;
            for (offset, coefficient) in self.modulus.iter().enumerate() {
                row[place + offset] = row[place + offset].sub(&top.mul(coefficient)?)?;
            }
        }
        row.resize(degree, Value::zero());
        Ok(row)
    }

    fn multiplied(&self, left: &[Value], right: &[Value]) -> Result<Row, ValueError> {
        self.reduced(times(left, right)?)
    }

    fn inverse(&self, row: &[Value]) -> Result<Row, ValueError> {
        let ([constant, linear], [free, middle]) = (row, self.modulus.as_slice()) else {
            return Ok(vec![Value::one().div(&row[0])?]);
        };
        // The conjugate of c + d*x is c + d*(-b - x), and their product is free of x.
        let other = constant.sub(&linear.mul(middle)?)?;
        let norm = constant.mul(&other)?.add(&linear.mul(linear)?.mul(free)?)?;
        Ok(vec![other.div(&norm)?, linear.neg()?.div(&norm)?])
    }

    /// The Taylor coefficient of this order of a polynomial, at the root.
    fn taylor(&self, polynomial: &[Value], order: usize) -> Result<Row, ValueError> {
        let mut choose = Value::one();
        let mut row = Vec::new();
        for (place, value) in polynomial.iter().enumerate().skip(order) {
            row.push(value.mul(&choose)?);
            let number = |number: usize| Value::integer(i64::try_from(number).unwrap_or(i64::MAX));
            choose = choose.mul(&number(place + 1))?.div(&number(place + 1 - order))?;
        }
        self.reduced(row)
    }

    /// Its roots.
    fn roots(&self) -> Result<Row, ValueError> {
        let [_, middle] = self.modulus.as_slice() else { return Ok(vec![self.modulus[0].neg()?]) };
        let half = Value::fraction(1, 2)?;
        let [square, below] = discriminant(&self.modulus)?;
        let (middle, distance) = (middle.neg()?.mul(&half)?, square.sqrt()?.mul(&half)?.div(&below)?);
        Ok(vec![middle.add(&distance)?, middle.sub(&distance)?])
    }
}

/// The closed form of a sequence from its first terms, of which so many came before.
fn form(
    terms: &[Value],
    zeros: usize,
    whole: &[Value],
    all: &[Factor],
    recurrence: &Recurrence,
) -> Result<Value, ValueError> {
    let mut numerator = Vec::new();
    for place in 0..terms.len() {
        let mut sum = Value::zero();
        for (at, value) in terms.iter().enumerate().take(terms.len() - place) {
            sum = sum.add(&value.mul(&whole[place + 1 + at])?)?;
        }
        numerator.push(sum);
    }
    let mut sum = Value::zero();
    for factor in all {
        let parts = fractions(factor, &numerator, whole, zeros)?;
        for root in factor.roots()? {
            sum = sum.add(&at_root(&parts, &root, zeros, recurrence)?)?;
        }
    }
    Ok(sum)
}

/// For each m from 1 the coefficient of `(n - zeros) choose (m - 1)` times `x^n`, as an element modulo the factor.
fn fractions(factor: &Factor, numerator: &[Value], whole: &[Value], zeros: usize) -> Result<Vec<Row>, ValueError> {
    let count = factor.count;
    // Q(x + t)/t^count as a series in t, and its inverse.
    let series = (count..2 * count).map(|order| factor.taylor(whole, order)).collect::<Result<Vec<_>, _>>()?;
    let first = factor.inverse(&series[0])?;
    let mut inverse = vec![first.clone()];
    for order in 1..count {
        let mut sum = vec![Value::zero(); factor.modulus.len()];
        for back in 1..=order {
            for (own, value) in sum.iter_mut().zip(factor.multiplied(&series[back], &inverse[order - back])?) {
                *own = own.sub(&value)?;
            }
        }
        inverse.push(factor.multiplied(&sum, &first)?);
    }
    let slopes = (0..count).map(|order| factor.taylor(numerator, order)).collect::<Result<Vec<_>, _>>()?;
    let mut parts = Vec::new();
    for order in 1..=count {
        let mut sum = vec![Value::zero(); factor.modulus.len()];
        for at in 0..=count - order {
            for (own, value) in sum.iter_mut().zip(factor.multiplied(&slopes[at], &inverse[count - order - at])?) {
                *own = own.add(&value)?;
            }
        }
        for _ in 0..zeros + order - 1 {
            if sum.iter().any(|value| !value.is_zero()) {
                let root = factor.reduced(vec![Value::zero(), Value::one()])?;
                sum = factor.multiplied(&sum, &factor.inverse(&root)?)?;
            }
        }
        parts.push(sum);
    }
    Ok(parts)
}

/// The part of the form that belongs to a root.
fn at_root(parts: &[Row], root: &Value, zeros: usize, recurrence: &Recurrence) -> Result<Value, ValueError> {
    let count = Value::variable(&recurrence.index);
    let (mut sum, mut binomial) = (Value::zero(), Value::one());
    for (order, row) in parts.iter().enumerate() {
        let mut coefficient = Value::zero();
        for value in row.iter().rev() {
            coefficient = coefficient.mul(root)?.add(value)?;
        }
        sum = sum.add(&coefficient.mul(&binomial)?)?;
        let number = |number: usize| Value::integer(i64::try_from(number).unwrap_or(i64::MAX));
        binomial = binomial.mul(&count.sub(&number(zeros + order))?)?.div(&number(order + 1))?;
    }
    if sum.is_zero() { Ok(sum) } else { sum.mul(&root.power(&count)?) }
}
