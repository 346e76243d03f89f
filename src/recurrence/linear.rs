//! Linear systems with rational coefficients, of any order: the generating function of each sequence is a quotient
//! `P(z)/Q(z)`, and its partial fractions at the roots of Q are the closed form.
//!
//! Q is the characteristic polynomial times a factor for each exponential in the equations. For a factor p of Q all
//! its roots are treated at once, modulo p.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::Unknown;
use super::matrix::characteristic;
use super::sequences::{go_on, interrupted};
use crate::closed_form::{Form, Recurrence};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::rational::{product, sum};
use crate::univariate::Univariate;
use crate::value::{Value, ValueError};

/// The most variables of a system, and the most terms that are needed of it.
pub(super) const MOST_VARIABLES: usize = 64;

/// A system `s(n+1) = A s(n) + b(n)`, where the state s has as many places for each sequence as its order.
pub(super) struct System {
    matrix: Vec<Vec<BigRational>>,
    /// For each place `coefficient * n^power * base^n`.
    inputs: Vec<Vec<(Value, usize, BigRational)>>,
    start: Vec<Value>,
    /// The place of each sequence.
    places: Vec<usize>,
    /// For each base the highest power of n with it, and one more.
    bases: BTreeMap<BigRational, usize>,
}

impl System {
    /// The system of a recurrence that begins at 0; `None` if it is not linear with rational coefficients.
    pub(super) fn of(recurrence: &Recurrence) -> Option<System> {
        let variables = recurrence.terms();
        let size = variables.len();
        if size == 0 || size > MOST_VARIABLES {
            return None;
        }
        let mut system = System {
            matrix: vec![vec![BigRational::zero(); size]; size],
            inputs: vec![Vec::new(); size],
            start: Vec::new(),
            places: Vec::new(),
            bases: BTreeMap::new(),
        };
        let mut row = 0;
        for sequence in &recurrence.sequences {
            system.places.push(row);
            for _ in 1..sequence.start.len() {
                system.matrix[row][row + 1] = BigRational::one();
                row += 1;
            }
            system.start.extend(sequence.start.iter().cloned());
            let mut rest = sequence.next.clone();
            for (column, (name, ..)) in variables.iter().enumerate() {
                if rest.mentions(name) {
                    let (factor, constant) = rest.linear_in(name)?;
                    system.matrix[row][column] = factor.as_rational()?;
                    rest = constant;
                }
            }
            system.input(&rest, row, recurrence)?;
            row += 1;
        }
        Some(system)
    }

    fn input(&mut self, rest: &Value, row: usize, recurrence: &Recurrence) -> Option<()> {
        let input = ExponentialPolynomial::of(rest, &recurrence.index)?;
        for (modulus, rows) in input.parts() {
            let base = -modulus.coefficient(0);
            for (power, coefficients) in rows.iter().enumerate() {
                self.inputs[row].push((coefficients[0].clone(), power, base.clone()));
            }
            let most = self.bases.entry(base).or_insert(0);
            *most = rows.len().max(*most);
        }
        Some(())
    }

    /// The closed forms of the sequences.
    pub(super) fn forms(&self, stop: &dyn Fn() -> bool) -> Result<Vec<Form>, Unknown> {
        let numbers: Option<Vec<BigRational>> = self.start.iter().map(Value::as_rational).collect();
        let inputs: Option<Vec<Inputs<BigRational>>> = self
            .inputs
            .iter()
            .map(|row| row.iter().map(|(value, power, base)| Some((value.as_rational()?, *power, base))).collect())
            .collect();
        match (numbers, inputs) {
            (Some(start), Some(inputs)) => self.solved(&start, &inputs, stop),
            _ => {
                let row = |row: &Vec<(Value, usize, BigRational)>| -> Vec<(Value, usize, BigRational)> { row.clone() };
                let rows: Vec<_> = self.inputs.iter().map(row).collect();
                let inputs: Vec<Inputs<Value>> = rows
                    .iter()
                    .map(|row| row.iter().map(|(value, power, base)| (value.clone(), *power, base)).collect())
                    .collect();
                self.solved(&self.start, &inputs, stop)
            }
        }
    }

    fn solved<T: Linear>(
        &self,
        start: &[T],
        inputs: &[Inputs<T>],
        stop: &dyn Fn() -> bool,
    ) -> Result<Vec<Form>, Unknown> {
        let polynomial = characteristic(&self.matrix, stop).ok_or_else(interrupted)?;
        let mut factors: BTreeMap<Univariate, usize> = polynomial.factors().into_iter().collect();
        for (base, count) in &self.bases {
            *factors.entry(Univariate::root(base)).or_insert(0) += count;
        }
        let zeros = factors.remove(&Univariate::root(&BigRational::zero())).unwrap_or(0);
        let whole = factors.iter().fold(Univariate::one(), |all, (factor, count)| all.times(&factor.power(*count)));
        let count = zeros + whole.degree();
        if count > MOST_VARIABLES {
            return Err(Unknown::because("the system is too large"));
        }
        let terms = self.terms(start, inputs, count)?;
        let mut fractions = Vec::new();
        for (factor, count) in &factors {
            go_on(stop)?;
            let fraction = Fraction::of(factor, *count, &whole, zeros);
            let reason = || Unknown::because("the characteristic polynomial could not be taken apart");
            fractions.push(fraction.ok_or_else(reason)?);
        }
        let one = |terms: Vec<T>| go_on(stop).and_then(|()| form(&terms, zeros, &whole, &fractions));
        terms.into_iter().map(one).collect()
    }

    /// The first terms of each sequence.
    fn terms<T: Linear>(&self, start: &[T], inputs: &[Inputs<T>], count: usize) -> Result<Vec<Vec<T>>, ValueError> {
        let mut state = start.to_vec();
        let mut terms = vec![Vec::new(); self.places.len()];
        let mut powers: BTreeMap<&BigRational, BigRational> =
            self.bases.keys().map(|base| (base, BigRational::one())).collect();
        for step in 0..count {
            for (sequence, place) in terms.iter_mut().zip(&self.places) {
                sequence.push(state[*place].clone());
            }
            let mut next = Vec::new();
            for (row, input) in self.matrix.iter().zip(inputs) {
                let mut sum = T::nothing();
                for (number, value) in row.iter().zip(&state).filter(|(number, _)| !number.is_zero()) {
                    sum = sum.plus(&value.times(number)?)?;
                }
                for (value, power, base) in input {
                    let count = BigRational::from_integer(step.into()).pow(i32::try_from(*power).unwrap_or(i32::MAX));
                    sum = sum.plus(&value.times(&product(&count, &powers[*base]))?)?;
                }
                next.push(sum);
            }
            state = next;
            powers.iter_mut().for_each(|(base, power)| *power = product(power, base));
        }
        Ok(terms)
    }
}

type Inputs<'a, T> = Vec<(T, usize, &'a BigRational)>;

/// What terms may be: numbers, or values with symbols in them.
trait Linear: Clone {
    fn nothing() -> Self;
    fn plus(&self, other: &Self) -> Result<Self, ValueError>;
    fn times(&self, factor: &BigRational) -> Result<Self, ValueError>;
    fn value(&self) -> Value;
    fn equals_zero(&self) -> bool;
}

impl Linear for BigRational {
    fn nothing() -> BigRational {
        BigRational::zero()
    }

    fn plus(&self, other: &BigRational) -> Result<BigRational, ValueError> {
        Ok(if self.is_zero() { other.clone() } else { sum(self, other) })
    }

    fn times(&self, factor: &BigRational) -> Result<BigRational, ValueError> {
        Ok(if factor.is_one() { self.clone() } else { product(self, factor) })
    }

    fn value(&self) -> Value {
        Value::rational(self.clone())
    }

    fn equals_zero(&self) -> bool {
        self.is_zero()
    }
}

impl Linear for Value {
    fn nothing() -> Value {
        Value::zero()
    }

    fn plus(&self, other: &Value) -> Result<Value, ValueError> {
        if self.is_zero() { Ok(other.clone()) } else { self.add(other) }
    }

    fn times(&self, factor: &BigRational) -> Result<Value, ValueError> {
        if factor.is_one() { Ok(self.clone()) } else { self.mul(&Value::rational(factor.clone())) }
    }

    fn value(&self) -> Value {
        self.clone()
    }

    fn equals_zero(&self) -> bool {
        self.is_zero()
    }
}

/// What the partial fractions at the roots of one factor p need, whatever the numerator P.
struct Fraction {
    modulus: Univariate,
    /// `x^0, x^1, …` modulo p, up to the degree of P.
    powers: Vec<Univariate>,
    /// For `1/(z - x)^m` (m from 1) and the j-th Taylor coefficient of P the factor in its coefficient, with
    /// the power of x that belongs to it.
    weights: Vec<Vec<Univariate>>,
    /// For each m the polynomial in n that is `(n - zeros) choose (m - 1)`.
    counts: Vec<Univariate>,
}

impl Fraction {
    fn of(modulus: &Univariate, count: usize, whole: &Univariate, zeros: usize) -> Option<Fraction> {
        let x = Univariate::new(vec![BigRational::zero(), BigRational::one()]);
        let mut powers = vec![Univariate::one().modulo(modulus)];
        while powers.len() <= whole.degree() {
            let next = powers[powers.len() - 1].times(&x).modulo(modulus);
            powers.push(next);
        }
        // Q(x + t) / t^count as a series in t, and its inverse.
        let series: Vec<Univariate> =
            (count..2 * count).map(|order| taylor(whole.coefficients(), order, &powers, modulus)).collect();
        let first = series.first()?.inverse_modulo(modulus)?;
        let mut inverse = vec![first.clone()];
        for order in 1..count {
            let mut sum = Univariate::zero();
            for back in 1..=order {
                sum = sum.plus(&series[back].times(&inverse[order - back]));
            }
            inverse.push(sum.times(&first).scale(&-BigRational::one()).modulo(modulus));
        }
        // x^(n - zeros - m + 1) = x^n * x^-(zeros + m - 1)
        let reciprocal = x.modulo(modulus).inverse_modulo(modulus)?;
        let mut shift = Univariate::one();
        for _ in 0..zeros {
            shift = shift.times(&reciprocal).modulo(modulus);
        }
        let (mut weights, mut counts) = (Vec::new(), Vec::new());
        let mut binomial = Univariate::one();
        for order in 1..=count {
            let row = (0..=count - order).map(|at| inverse[count - order - at].times(&shift).modulo(modulus));
            weights.push(row.collect());
            counts.push(binomial.clone());
            shift = shift.times(&reciprocal).modulo(modulus);
            let place = BigRational::from_integer((zeros + order - 1).into());
            let over = BigRational::new(1.into(), order.into());
            binomial = binomial.times(&Univariate::root(&place)).scale(&over);
        }
        Some(Fraction { modulus: modulus.clone(), powers, weights, counts })
    }

    /// The coefficients of this part: by the power of n, then by that of x.
    fn part<T: Linear>(&self, numerator: &[T]) -> Result<Vec<Vec<Value>>, ValueError> {
        let degree = self.modulus.degree();
        let mut rows: Vec<Vec<T>> = vec![vec![T::nothing(); degree]; self.counts.len()];
        let mut slopes: Vec<Vec<T>> = Vec::new();
        for order in 0..self.counts.len() {
            slopes.push(self.slope(numerator, order)?);
        }
        for (weights, count) in self.weights.iter().zip(&self.counts) {
            let mut element = vec![T::nothing(); degree];
            for (slope, weight) in slopes.iter().zip(weights) {
                self.multiply(slope, weight, &mut element)?;
            }
            for (row, factor) in rows.iter_mut().zip(count.coefficients()).filter(|(_, factor)| !factor.is_zero()) {
                for (sum, value) in row.iter_mut().zip(&element).filter(|(_, value)| !value.equals_zero()) {
                    *sum = sum.plus(&value.times(factor)?)?;
                }
            }
        }
        Ok(rows.into_iter().map(|row| row.iter().map(Linear::value).collect()).collect())
    }

    /// The Taylor coefficient of this order of a polynomial at x.
    fn slope<T: Linear>(&self, polynomial: &[T], order: usize) -> Result<Vec<T>, ValueError> {
        let mut sum = vec![T::nothing(); self.modulus.degree()];
        let mut choose = BigRational::one();
        for (place, value) in polynomial.iter().enumerate().skip(order) {
            if !value.equals_zero() {
                let power = &self.powers[place - order];
                for (own, number) in sum.iter_mut().zip(power.coefficients()).filter(|(_, number)| !number.is_zero()) {
                    *own = own.plus(&value.times(&product(number, &choose))?)?;
                }
            }
            choose = product(&choose, &BigRational::new((place + 1).into(), (place + 1 - order).into()));
        }
        Ok(sum)
    }

    /// Adds the product of an element and a weight, modulo p.
    fn multiply<T: Linear>(&self, element: &[T], weight: &Univariate, sum: &mut [T]) -> Result<(), ValueError> {
        let x = &self.powers.get(1).cloned().unwrap_or_else(Univariate::zero);
        let mut moved = weight.clone();
        for (place, value) in element.iter().enumerate() {
            if place > 0 {
                moved = moved.times(x).modulo(&self.modulus);
            }
            if !value.equals_zero() {
                for (own, number) in sum.iter_mut().zip(moved.coefficients()).filter(|(_, number)| !number.is_zero()) {
                    *own = own.plus(&value.times(number)?)?;
                }
            }
        }
        Ok(())
    }
}

fn taylor(coefficients: &[BigRational], order: usize, powers: &[Univariate], modulus: &Univariate) -> Univariate {
    let mut sum = Univariate::zero();
    let mut choose = BigRational::one();
    for (place, number) in coefficients.iter().enumerate().skip(order) {
        sum = sum.plus(&powers[place - order].scale(&product(number, &choose)));
        choose = product(&choose, &BigRational::new((place + 1).into(), (place + 1 - order).into()));
    }
    sum.modulo(modulus)
}

/// The closed form of a sequence from its first terms, of which so many come before it.
fn form<T: Linear>(terms: &[T], zeros: usize, whole: &Univariate, fractions: &[Fraction]) -> Result<Form, Unknown> {
    let later = &terms[zeros..];
    let degree = whole.degree();
    let mut numerator = Vec::new();
    for place in 0..degree {
        let mut sum = T::nothing();
        for (at, value) in later.iter().enumerate().take(degree - place) {
            let number = &whole.coefficients()[place + 1 + at];
            if !number.is_zero() {
                sum = sum.plus(&value.times(number)?)?;
            }
        }
        numerator.push(sum);
    }
    let mut sum = ExponentialPolynomial::zero();
    for fraction in fractions {
        sum.include(&fraction.modulus, fraction.part(&numerator)?)?;
    }
    let mut early: Vec<Value> = terms[..zeros].iter().map(Linear::value).collect();
    while let Some(last) = early.last() {
        if sum.at(early.len() as u64 - 1)? != *last {
            break;
        }
        early.pop();
    }
    Ok(Form::Sum(early, sum))
}
