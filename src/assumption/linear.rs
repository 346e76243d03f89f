//! Linear arithmetic: whether constraints on monomials, each taken as an unknown of its own, contradict each other.
//!
//! By Motzkin's theorem they do exactly when a combination of them with non-negative multipliers is a false constant.
//! The multipliers are looked for by the simplex method with Bland's rule; nothing rests on that search, because
//! what it finds is added up and looked at before it is believed.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

use dashu_int::IBig;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::eliminate::{in_terms_of, mixed};
use super::simplex::Table;
use crate::polynomial::{Monomial, Polynomial};
use crate::rational::{from_whole, quotient, to_whole};
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
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Constraint {
    pub(super) form: Polynomial<Atom>,
    pub(super) bound: Bound,
}

const MOST_ROWS: usize = 90;
const MOST_COLUMNS: usize = 220;
/// How many systems are remembered with what was found of them.
const MOST_SYSTEMS: usize = 4_000;

thread_local! {
    /// What was found of a system; it depends on nothing else, and the same is asked under many sets of assumptions.
    static KNOWN: RefCell<HashMap<Vec<Constraint>, bool>> = RefCell::new(HashMap::new());
}

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
    let key: Vec<Constraint> = useful.iter().map(|one| (*one).clone()).collect();
    if let Some(known) = KNOWN.with_borrow(|known| known.get(&key).copied()) {
        return known;
    }
    let found = refuted(&useful);
    KNOWN.with_borrow_mut(|known| {
        if known.len() >= MOST_SYSTEMS {
            known.clear();
        }
        known.insert(key, found);
    });
    found
}

/// The same of constraints that may all be of use.
fn refuted(useful: &[&Constraint]) -> bool {
    let mixed = mixed(useful);
    if mixed.is_empty() {
        return false;
    }
    let rows: Vec<&Constraint> = mixed.iter().map(|row| &row.constraint).collect();
    multipliers(&rows).is_some_and(|found| is_refutation(useful, &in_terms_of(&mixed, &found, useful.len())))
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
/// an equation), each of the constraint in coprime whole numbers, and the amount s by which the sum is below 0; s and the
/// multipliers of strict constraints add to 1.
fn multipliers(constraints: &[&Constraint]) -> Option<Vec<BigRational>> {
    let mut rows: BTreeMap<&Monomial<Atom>, usize> = BTreeMap::new();
    let one = Monomial::one();
    rows.insert(&one, 0);
    for constraint in constraints {
        for (monomial, _) in constraint.form.terms() {
            let next = rows.len();
            rows.entry(monomial).or_insert(next);
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
    let contents: Vec<BigRational> = constraints.iter().map(|constraint| constraint.form.content()).collect();
    let mut table = vec![vec![IBig::ZERO; width + 1]; height];
    for (column, (place, negated)) in columns.iter().enumerate() {
        for (monomial, number) in constraints[*place].form.terms() {
            let whole = to_whole(&quotient(number, &contents[*place]).to_integer());
            table[*rows.get(monomial)?][column] = if *negated { -whole } else { whole };
        }
        if constraints[*place].bound == Bound::Positive {
            table[height - 1][column] = IBig::ONE;
        }
    }
    table[0][width - 1] = IBig::ONE;
    table[height - 1][width - 1] = IBig::ONE;
    table[height - 1][width] = IBig::ONE;
    let solution = Table::new(table).solution()?;
    let mut found = vec![BigRational::zero(); constraints.len()];
    for ((place, negated), number) in columns.iter().zip(&solution).filter(|(_, number)| !number.is_zero()) {
        let number = quotient(&BigRational::from_integer(from_whole(number)), &contents[*place]);
        found[*place] += if *negated { -number } else { number };
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use num_traits::One;

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
