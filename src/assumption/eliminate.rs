//! Fourier and Motzkin's elimination, as far as it makes a system of constraints shorter: a monomial with one lower
//! bound, or one upper bound, is given up for the sums of that with the others. What hangs on by a number that is drawn
//! once, `|r+w-10| <= 1/10`, falls away.
//!
//! Nothing rests on it: a row knows of which constraints it is the sum, and what is found with rows is added up and
//! looked at in the constraints themselves.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::linear::{Bound, Constraint};
use crate::polynomial::Monomial;
use crate::value::Atom;

/// A sum of constraints, each multiplied by what is not negative.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) constraint: Constraint,
    parts: BTreeMap<usize, BigRational>,
}

/// Systems that are no longer than this are solved as they are.
const SHORT: usize = 6;

/// Rows that contradict each other where the constraints do.
pub(super) fn mixed(constraints: &[&Constraint]) -> Vec<Row> {
    let own = |(place, constraint): (usize, &&Constraint)| Row {
        constraint: (*constraint).clone(),
        parts: BTreeMap::from([(place, BigRational::one())]),
    };
    let mut rows: Vec<Row> = constraints.iter().enumerate().map(own).collect();
    while rows.len() > SHORT {
        let Some((monomial, lower, upper)) = next(&rows) else { break };
        rows = eliminated(rows, &monomial, &lower, &upper);
    }
    rows
}

/// What is found with rows, as multipliers of so many constraints.
pub(super) fn in_terms_of(rows: &[Row], found: &[BigRational], count: usize) -> Vec<BigRational> {
    let mut multipliers = vec![BigRational::zero(); count];
    for (row, factor) in rows.iter().zip(found) {
        for (place, number) in &row.parts {
            multipliers[*place] += factor * number;
        }
    }
    multipliers
}

/// A monomial that stands in no equation and is bounded from one side at most once, with the rows that bound it from
/// below and from above.
fn next(rows: &[Row]) -> Option<(Monomial<Atom>, Vec<usize>, Vec<usize>)> {
    let mut bounds: BTreeMap<&Monomial<Atom>, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
    let mut equated: BTreeSet<&Monomial<Atom>> = BTreeSet::new();
    for (place, row) in rows.iter().enumerate() {
        for (monomial, number) in row.constraint.form.terms().iter().filter(|term| !term.0.factors().is_empty()) {
            if row.constraint.bound == Bound::Zero {
                equated.insert(monomial);
            }
            let (lower, upper) = bounds.entry(monomial).or_default();
            if number.is_positive() { lower.push(place) } else { upper.push(place) }
        }
    }
    bounds
        .into_iter()
        .filter(|(monomial, (lower, upper))| !equated.contains(monomial) && lower.len().min(upper.len()) <= 1)
        .min_by_key(|(_, (lower, upper))| lower.len() * upper.len())
        .map(|(monomial, (lower, upper))| (monomial.clone(), lower, upper))
}

/// The rows without those that bound a monomial, and with the sums in which it falls away.
fn eliminated(rows: Vec<Row>, monomial: &Monomial<Atom>, lower: &[usize], upper: &[usize]) -> Vec<Row> {
    let mut sums = Vec::new();
    for low in lower {
        for high in upper {
            sums.extend(sum(&rows[*low], &rows[*high], monomial));
        }
    }
    let bounding: BTreeSet<&usize> = lower.iter().chain(upper).collect();
    let rest = rows.into_iter().enumerate().filter(|(place, _)| !bounding.contains(place)).map(|(_, row)| row);
    rest.chain(sums).collect()
}

/// The sum in which the monomial falls away; nothing where that says nothing.
fn sum(low: &Row, high: &Row, monomial: &Monomial<Atom>) -> Option<Row> {
    let (up, down) = (factor_of(high, monomial).abs(), factor_of(low, monomial).abs());
    let form = low.constraint.form.scale(&up).plus(&high.constraint.form.scale(&down));
    let bound = low.constraint.bound.max(high.constraint.bound);
    if form.as_constant().is_some_and(|number| bound.admits(&number)) {
        return None;
    }
    let mut parts = BTreeMap::new();
    for (row, factor) in [(low, &up), (high, &down)] {
        for (place, number) in &row.parts {
            *parts.entry(*place).or_insert_with(BigRational::zero) += factor * number;
        }
    }
    Some(Row { constraint: Constraint { form, bound }, parts })
}

fn factor_of(row: &Row, monomial: &Monomial<Atom>) -> BigRational {
    let term = row.constraint.form.terms().iter().find(|(own, _)| own == monomial);
    term.map_or_else(BigRational::zero, |(_, number)| number.clone())
}
