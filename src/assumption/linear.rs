//! Linear arithmetic: whether constraints on monomials, each taken as an unknown of its own, contradict each other.
//!
//! By Motzkin's theorem they do exactly when a combination of them with non-negative multipliers is a false constant.
//! The multipliers are looked for by the simplex method with Bland's rule; nothing rests on that search, because
//! what it finds is added up and looked at before it is believed.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::eliminate::{in_terms_of, mixed};
use crate::polynomial::{Monomial, Polynomial};
use crate::rational::{product, sum};
use crate::value::Atom;

/// What a constraint says of its polynomial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Bound {
    /// `= 0`
    Zero,
    /// `>= 0`
    Nonnegative,
    /// `> 0`
    Positive,
}

impl Bound {
    pub(super) fn admits(self, number: &BigRational) -> bool {
        match self {
            Bound::Zero => number.is_zero(),
            Bound::Nonnegative => !number.is_negative(),
            Bound::Positive => number.is_positive(),
        }
    }
}

/// A polynomial and what is said of it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Constraint {
    pub(super) form: Polynomial<Atom>,
    pub(super) bound: Bound,
}

const MOST_ROWS: usize = 90;
const MOST_COLUMNS: usize = 220;
const MOST_PIVOTS: usize = 250;
/// The time that it may take, in that of a number of 64 bits: common factors are looked for in the square of the length.
const MOST_WORK: u64 = 1_000_000;

/// Whether the constraints cannot all hold; `false` also when that was not found out within the limits.
pub(super) fn contradictory(constraints: &[Constraint]) -> bool {
    let false_constant =
        |constraint: &Constraint| constraint.form.as_constant().is_some_and(|number| !constraint.bound.admits(&number));
    if constraints.iter().any(false_constant) {
        return true;
    }
    let useful = without_loose_ends(constraints);
    if useful.is_empty() {
        return false;
    }
    let mixed = mixed(&useful);
    if mixed.is_empty() {
        return false;
    }
    let rows: Vec<&Constraint> = mixed.iter().map(|row| &row.constraint).collect();
    multipliers(&rows).is_some_and(|found| is_refutation(&useful, &in_terms_of(&mixed, &found, useful.len())))
}

/// The same without elimination.
#[cfg(test)]
pub(super) fn contradictory_as_they_are(constraints: &[Constraint]) -> bool {
    let all: Vec<&Constraint> = constraints.iter().collect();
    multipliers(&all).is_some_and(|found| is_refutation(&all, &found))
}

/// Leaves out, again and again, constraints with a monomial that nothing can cancel.
fn without_loose_ends(constraints: &[Constraint]) -> Vec<&Constraint> {
    let mut kept: Vec<&Constraint> = constraints.iter().filter(|one| one.form.as_constant().is_none()).collect();
    kept.sort();
    kept.dedup();
    loop {
        let mut signs: BTreeMap<&Monomial<Atom>, (bool, bool, usize)> = BTreeMap::new();
        for constraint in &kept {
            for (monomial, number) in constraint.form.terms() {
                let entry = signs.entry(monomial).or_insert((false, false, 0));
                entry.0 |= number.is_positive() || constraint.bound == Bound::Zero;
                entry.1 |= number.is_negative() || constraint.bound == Bound::Zero;
                entry.2 += 1;
            }
        }
        let before = kept.len();
        kept.retain(|constraint| {
            constraint.form.terms().iter().all(|(monomial, _)| {
                monomial.factors().is_empty()
                    || signs.get(monomial).is_some_and(|(plus, minus, count)| *plus && *minus && *count > 1)
            })
        });
        if kept.len() == before {
            return kept;
        }
    }
}

/// The check of a refutation: an equation may be multiplied by anything, an inequality by what is not negative, and
/// the sum must be a constant that contradicts what the parts say of it.
fn is_refutation(constraints: &[&Constraint], multipliers: &[BigRational]) -> bool {
    let mut sum = Polynomial::zero();
    let mut strict = false;
    for (constraint, factor) in constraints.iter().zip(multipliers) {
        if constraint.bound != Bound::Zero && factor.is_negative() {
            return false;
        }
        strict |= constraint.bound == Bound::Positive && factor.is_positive();
        sum = sum.plus(&constraint.form.scale(factor));
    }
    sum.as_constant().is_some_and(|number| number.is_negative() || (strict && number.is_zero()))
}

/// Multipliers that make the sum a false constant. The unknowns of the linear program are the multipliers (two for
/// an equation) and the amount s by which the sum is below 0; s and the multipliers of strict constraints add to 1.
fn multipliers(constraints: &[&Constraint]) -> Option<Vec<BigRational>> {
    let mut rows: BTreeMap<Monomial<Atom>, usize> = BTreeMap::new();
    rows.insert(Monomial::one(), 0);
    for constraint in constraints {
        for (monomial, _) in constraint.form.terms() {
            let next = rows.len();
            rows.entry(monomial.clone()).or_insert(next);
        }
    }
    let mut columns: Vec<(usize, bool)> = Vec::new();
    for (place, constraint) in constraints.iter().enumerate() {
        columns.push((place, false));
        if constraint.bound == Bound::Zero {
            columns.push((place, true));
        }
    }
    let (height, width) = (rows.len() + 1, columns.len() + 1);
    if height > MOST_ROWS || width > MOST_COLUMNS {
        return None;
    }
    let mut table = vec![vec![BigRational::zero(); width + 1]; height];
    for (column, (place, negated)) in columns.iter().enumerate() {
        for (monomial, number) in constraints[*place].form.terms() {
            let row = rows.get(monomial)?;
            table[*row][column] = if *negated { -number } else { number.clone() };
        }
        if constraints[*place].bound == Bound::Positive {
            table[height - 1][column] = BigRational::one();
        }
    }
    table[0][width - 1] = BigRational::one();
    table[height - 1][width - 1] = BigRational::one();
    table[height - 1][width] = BigRational::one();
    let solution = feasible(table, width)?;
    let mut found = vec![BigRational::zero(); constraints.len()];
    for (column, (place, negated)) in columns.iter().enumerate() {
        let number = &solution[column];
        found[*place] += if *negated { -number } else { number.clone() };
    }
    Some(found)
}

/// A non-negative solution of `table`, rows of coefficients and one right side that is not negative.
fn feasible(mut table: Vec<Vec<BigRational>>, width: usize) -> Option<Vec<BigRational>> {
    let height = table.len();
    // Artificial unknowns, one a row, are the first basis; their columns are never needed again.
    let mut basis: Vec<usize> = (width..width + height).collect();
    let mut objective = vec![BigRational::zero(); width + 1];
    for row in &table {
        for (total, number) in objective.iter_mut().zip(row) {
            *total += number;
        }
    }
    let mut work = 0;
    for _ in 0..MOST_PIVOTS {
        if objective[width].is_zero() {
            let mut solution = vec![BigRational::zero(); width];
            for (row, unknown) in basis.iter().enumerate().filter(|(_, unknown)| **unknown < width) {
                solution[*unknown] = table[row][width].clone();
            }
            return Some(solution);
        }
        let words = objective.iter().map(|number| number.numer().bits().max(number.denom().bits())).max()? / 64;
        work += (height * (width + 1)) as u64 * (1 + words + words * words / 8);
        if work > MOST_WORK {
            return None;
        }
        let entering = (0..width).find(|column| objective[*column].is_positive())?;
        let leaving = (0..height)
            .filter(|row| table[*row][entering].is_positive())
            .map(|row| (&table[row][width] / &table[row][entering], basis[row], row))
            .min()?
            .2;
        pivot(&mut table, &mut objective, leaving, entering);
        basis[leaving] = entering;
    }
    None
}

fn pivot(table: &mut [Vec<BigRational>], objective: &mut [BigRational], row: usize, column: usize) {
    let scale = table[row][column].recip();
    for number in table[row].iter_mut().filter(|number| !number.is_zero()) {
        *number = product(number, &scale);
    }
    let pivot_row = table[row].clone();
    let eliminate = |target: &mut [BigRational]| {
        let factor = target[column].clone();
        if factor.is_zero() {
            return;
        }
        for (number, other) in target.iter_mut().zip(&pivot_row).filter(|(_, other)| !other.is_zero()) {
            *number = sum(number, &-product(&factor, other));
        }
    };
    for (place, target) in table.iter_mut().enumerate() {
        if place != row {
            eliminate(target);
        }
    }
    eliminate(objective);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    fn linear(x: i64, y: i64, constant: i64) -> Polynomial<Atom> {
        let number = |number: i64| BigRational::from_integer(number.into());
        let atom = |name: &str| Polynomial::atom(Atom::Variable(Name::new(name)));
        atom("x").scale(&number(x)).plus(&atom("y").scale(&number(y))).plus(&Polynomial::constant(number(constant)))
    }

    fn constraint(form: Polynomial<Atom>, bound: Bound) -> Constraint {
        Constraint { form, bound }
    }

    #[test]
    fn refutes_what_cannot_be() {
        // x > y, y >= 3, x <= 3
        let above = constraint(linear(1, -1, 0), Bound::Positive);
        let low = constraint(linear(0, 1, -3), Bound::Nonnegative);
        let high = constraint(linear(-1, 0, 3), Bound::Nonnegative);
        assert!(contradictory(&[above.clone(), low.clone(), high.clone()]));
        let weak = constraint(linear(1, -1, 0), Bound::Nonnegative);
        assert!(!contradictory(&[weak, low.clone(), high.clone()]));
        let equal = constraint(linear(1, -1, -1), Bound::Zero);
        assert!(contradictory(&[equal, low, high]));
    }

    #[test]
    fn a_wrong_certificate_is_not_believed() {
        let low = constraint(linear(1, 0, -3), Bound::Nonnegative);
        assert!(!is_refutation(&[&low], &[BigRational::from_integer((-1).into())]));
        assert!(!is_refutation(&[&low], &[BigRational::one()]));
    }
}
