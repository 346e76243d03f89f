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
/// The longest numbers, in bits, and the most terms that a sum may have: longer ones are found no sooner by it.
const MOST_BITS: u64 = 64;
const MOST_TERMS: usize = 16;

/// Rows that contradict each other where the constraints do.
pub(super) fn mixed(constraints: &[&Constraint]) -> Vec<Row> {
    let own = |(place, constraint): (usize, &&Constraint)| Row {
        constraint: (*constraint).clone(),
        parts: BTreeMap::from([(place, BigRational::one())]),
    };
    let mut rows: Vec<Row> = constraints.iter().enumerate().map(own).collect();
    while rows.len() > SHORT {
        let next = next(&rows);
        let mut gone: BTreeSet<usize> = BTreeSet::new();
        let mut sums = Vec::new();
        for (monomial, lower, upper) in &next {
            let Some(more) = sums_without(&rows, monomial, lower, upper) else { break };
            sums.extend(more);
            gone.extend(lower.iter().chain(upper));
        }
        if gone.is_empty() {
            break;
        }
        let rest = rows.into_iter().enumerate().filter(|(place, _)| !gone.contains(place));
        rows = rest.map(|(_, row)| row).chain(sums).collect();
    }
    rows
}

/// A monomial with the rows that bound it from below and from above.
type Bounded = (Monomial<Atom>, Vec<usize>, Vec<usize>);

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

/// A monomial that stands in no equation and is bounded from one side at most once; and with it others that leave no more
/// than one row each, of which none has a row of another.
fn next(rows: &[Row]) -> Vec<Bounded> {
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
    let single = |(_, (lower, upper)): &(&Monomial<Atom>, (Vec<usize>, Vec<usize>))| lower.len() * upper.len();
    let mut all: Vec<_> = bounds
        .into_iter()
        .filter(|(monomial, (lower, upper))| !equated.contains(monomial) && lower.len().min(upper.len()) <= 1)
        .collect();
    all.sort_by_key(single);
    let mut used: BTreeSet<usize> = BTreeSet::new();
    let mut found: Vec<Bounded> = Vec::new();
    for one in all {
        let (alone, (monomial, (lower, upper))) = (single(&one) <= 1, one);
        let mut own = lower.iter().chain(&upper);
        if found.is_empty() || (alone && own.all(|place| !used.contains(place))) {
            used.extend(lower.iter().chain(&upper));
            found.push((monomial.clone(), lower, upper));
        }
        if !alone {
            break;
        }
    }
    found
}

/// The sums in which a monomial falls away, of the rows that bound it; none where one is too long.
fn sums_without(rows: &[Row], monomial: &Monomial<Atom>, lower: &[usize], upper: &[usize]) -> Option<Vec<Row>> {
    let mut sums = Vec::new();
    for low in lower {
        for high in upper {
            let sum = sum(&rows[*low], &rows[*high], monomial);
            let Constraint { form, bound } = &sum.constraint;
            if form.bits() > MOST_BITS || form.terms().len() > MOST_TERMS {
                return None;
            }
            // What says nothing is left out.
            if form.as_constant().is_none_or(|number| !bound.admits(&number)) {
                sums.push(sum);
            }
        }
    }
    Some(sums)
}

/// The sum in which the monomial falls away, of coprime numbers.
fn sum(low: &Row, high: &Row, monomial: &Monomial<Atom>) -> Row {
    let (up, down) = (factor_of(high, monomial).abs(), factor_of(low, monomial).abs());
    let form = low.constraint.form.scale(&up).plus(&high.constraint.form.scale(&down));
    let scale = if form.is_zero() { BigRational::one() } else { form.content().recip() };
    let bound = low.constraint.bound.max(high.constraint.bound);
    let mut parts = BTreeMap::new();
    for (row, factor) in [(low, &up), (high, &down)] {
        for (place, number) in &row.parts {
            *parts.entry(*place).or_insert_with(BigRational::zero) += factor * number * &scale;
        }
    }
    Row { constraint: Constraint { form: form.scale(&scale), bound }, parts }
}

fn factor_of(row: &Row, monomial: &Monomial<Atom>) -> BigRational {
    let term = row.constraint.form.terms().iter().find(|(own, _)| own == monomial);
    term.map_or_else(BigRational::zero, |(_, number)| number.clone())
}

#[cfg(test)]
mod tests {
    use super::super::linear::{contradictory, contradictory_as_they_are};
    use super::*;
    use crate::name::Name;
    use crate::polynomial::Polynomial;

    /// A small number, other each time.
    fn small(state: &mut u64) -> i64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        i64::try_from((*state >> 33) % 7).unwrap() - 3
    }

    fn constraint(state: &mut u64, unknowns: usize) -> Constraint {
        let number = |number: i64| BigRational::from_integer(number.into());
        let mut form = Polynomial::constant(number(small(state)));
        for unknown in 0..unknowns {
            let factor = if small(state) > 0 { small(state) } else { 0 };
            let atom = Polynomial::atom(Atom::Variable(Name::new(&format!("x{unknown}"))));
            form = form.plus(&atom.scale(&number(factor)));
        }
        let bound = match small(state) {
            3 => Bound::Zero,
            2 | 1 => Bound::Positive,
            _ => Bound::Nonnegative,
        };
        Constraint { form, bound }
    }

    #[test]
    fn a_shorter_system_is_contradictory_where_the_longer_is() {
        let mut state = 1;
        let (mut contradictions, mut shorter) = (0, 0);
        for _ in 0..2_000 {
            let all: Vec<Constraint> = (0..12).map(|_| constraint(&mut state, 6)).collect();
            let found = contradictory(&all);
            assert_eq!(found, contradictory_as_they_are(&all), "{all:?}");
            contradictions += usize::from(found);
            let every: Vec<&Constraint> = all.iter().collect();
            shorter += usize::from(mixed(&every).len() < every.len());
        }
        assert!(contradictions > 200 && contradictions < 1_800, "{contradictions}");
        assert!(shorter > 500, "{shorter}");
    }

    #[test]
    fn what_hangs_on_by_a_number_of_its_own_falls_away() {
        // 1 + r+w_i >= 0 and 1 - r-w_i >= 0, for many i: of r nothing follows.
        let atom = |name: &str| Polynomial::atom(Atom::Variable(Name::new(name)));
        let both = |number: usize| {
            let sum = atom("r").plus(&atom(&format!("w{number}")));
            let one = Polynomial::constant(BigRational::one());
            let bounds = [one.plus(&sum), one.minus(&sum)];
            bounds.map(|form| Constraint { form, bound: Bound::Nonnegative })
        };
        let all: Vec<Constraint> = (0..40).flat_map(both).collect();
        let every: Vec<&Constraint> = all.iter().collect();
        assert!(mixed(&every).len() <= SHORT, "{}", mixed(&every).len());
    }
}
