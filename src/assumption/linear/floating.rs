//! Where a solution of a linear program lies, looked for in numbers of 64 bits: some hundred times as fast as exactly.
//!
//! Nothing rests on it. That there is a solution is shown by solving exactly for the unknowns that are not 0 in it; where
//! it is not clear whether there is one, it is looked for exactly.

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use crate::rational::{product, sum};

/// What is taken for 0: of a coefficient, and of the amount by which the program is not solved.
const SMALL: f64 = 1e-9;
/// An amount from which on it is believed that there is no solution.
const LARGE: f64 = 1e-5;
/// Steps, and those that gain nothing before Bland's rule is used, which ends.
const MOST_PIVOTS: usize = 1_000;
const MOST_IDLE: usize = 10;

/// What was found.
pub(super) enum Guess {
    /// There is none.
    Nothing,
    /// There seems to be one in which no other unknowns but these are not 0.
    Support(Vec<usize>),
    /// It is not clear.
    Unclear,
}

/// A table of floating point numbers, with the right sides in its last column and the objective in its last row.
struct Table {
    rows: Vec<Vec<f64>>,
    basis: Vec<usize>,
    width: usize,
}

/// Looks for a non-negative solution of rows of coefficients with one right side that is not negative.
pub(super) fn guessed(table: &[Vec<BigRational>], width: usize) -> Guess {
    let Some(mut table) = Table::of(table, width) else { return Guess::Unclear };
    let mut idle = 0;
    for _ in 0..MOST_PIVOTS {
        let left = table.left();
        if !left.is_finite() {
            return Guess::Unclear;
        }
        if left <= SMALL {
            return Guess::Support(table.support());
        }
        let Some(entering) = table.entering(idle > MOST_IDLE) else {
            return if left >= LARGE { Guess::Nothing } else { Guess::Unclear };
        };
        let Some(leaving) = table.leaving(entering) else { return Guess::Unclear };
        table.pivot(leaving, entering);
        idle = if table.left() < left - SMALL { 0 } else { idle + 1 };
    }
    Guess::Unclear
}

impl Table {
    /// The same in floating point numbers, with every column and then every row but the last, whose right side is 1, divided
    /// by its greatest number.
    fn of(exact: &[Vec<BigRational>], width: usize) -> Option<Table> {
        let number = |number: &BigRational| if number.is_zero() { Some(0.0) } else { number.to_f64() };
        let mut rows: Vec<Vec<f64>> =
            exact.iter().map(|row| row.iter().map(number).collect::<Option<_>>()).collect::<Option<_>>()?;
        if rows.iter().flatten().any(|number| !number.is_finite()) {
            return None;
        }
        let greatest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0f64, |most, one| most.max(one.abs()));
        for column in 0..width {
            let scale = greatest(&mut rows.iter().map(|row| row[column]));
            if scale > 0.0 {
                rows.iter_mut().for_each(|row| row[column] /= scale);
            }
        }
        let (_, others) = rows.split_last_mut()?;
        for row in others {
            let scale = greatest(&mut row.iter().copied());
            if scale > 0.0 {
                row.iter_mut().for_each(|number| *number /= scale);
            }
        }
        let height = rows.len();
        let objective = (0..=width).map(|column| rows.iter().map(|row| row[column]).sum()).collect();
        rows.push(objective);
        Some(Table { rows, basis: (width..width + height).collect(), width })
    }

    fn objective(&self) -> &[f64] {
        self.rows.last().map_or(&[], Vec::as_slice)
    }

    /// By how much it is not solved.
    fn left(&self) -> f64 {
        self.objective().last().copied().unwrap_or(f64::NAN)
    }

    /// The unknown that gains most, or the first that gains.
    fn entering(&self, first: bool) -> Option<usize> {
        let gains = self.objective().iter().take(self.width).enumerate().filter(|(_, gain)| **gain > SMALL);
        let mut gains = gains.map(|(column, gain)| (column, *gain));
        let one = gains.next()?;
        let best = if first { one } else { gains.fold(one, |best, own| if own.1 > best.1 { own } else { best }) };
        Some(best.0)
    }

    /// The row that bounds it first.
    fn leaving(&self, entering: usize) -> Option<usize> {
        let rows = self.basis.iter().zip(&self.rows).enumerate();
        let bounds = rows.filter(|(_, (_, row))| row[entering] > SMALL);
        let bounds = bounds.map(|(place, (unknown, row))| (row[self.width].max(0.0) / row[entering], *unknown, place));
        bounds.min_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1))).map(|(.., place)| place)
    }

    fn pivot(&mut self, leaving: usize, entering: usize) {
        let mut own = std::mem::take(&mut self.rows[leaving]);
        let scale = own[entering];
        own.iter_mut().for_each(|number| *number /= scale);
        for row in self.rows.iter_mut().filter(|row| !row.is_empty()) {
            let factor = row[entering];
            if factor != 0.0 {
                row.iter_mut().zip(&own).for_each(|(number, other)| *number -= factor * other);
                row[entering] = 0.0;
            }
        }
        self.rows[leaving] = own;
        self.basis[leaving] = entering;
    }

    /// The unknowns that are not 0.
    fn support(&self) -> Vec<usize> {
        let all = self.basis.iter().zip(&self.rows);
        all.filter(|(unknown, row)| **unknown < self.width && row[self.width] > SMALL)
            .map(|(place, _)| *place)
            .collect()
    }
}

/// The solution in which no other unknowns but these are not 0, if there is just one, and none of it is negative.
pub(super) fn solved(table: &[Vec<BigRational>], width: usize, support: &[usize]) -> Option<Vec<BigRational>> {
    let row = |row: &Vec<BigRational>| support.iter().chain([&width]).map(|column| row[*column].clone()).collect();
    let mut rows: Vec<Vec<BigRational>> = table.iter().map(row).collect();
    let count = support.len();
    for place in 0..count {
        let found = (place..rows.len()).find(|row| !rows[*row][place].is_zero())?;
        rows.swap(place, found);
        let scale = rows[place][place].recip();
        rows[place].iter_mut().for_each(|number| *number = product(number, &scale));
        let own = rows[place].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(other, row)| *other != place && !row[place].is_zero()) {
            let factor = -row[place].clone();
            for (number, other) in row.iter_mut().zip(&own).skip(place) {
                *number = sum(number, &product(&factor, other));
            }
        }
    }
    let consistent = rows.iter().skip(count).all(|row| row[count].is_zero());
    let mut solution = vec![BigRational::zero(); width];
    for (unknown, row) in support.iter().zip(&rows) {
        solution[*unknown] = row[count].clone();
    }
    (consistent && solution.iter().all(|number| !number.is_negative())).then_some(solution)
}

#[cfg(test)]
mod tests {
    use num_traits::One;
    use proptest::prelude::*;

    use super::*;

    fn table(rows: &[Vec<i64>]) -> Vec<Vec<BigRational>> {
        let number = |number: &i64| BigRational::from_integer((*number).into());
        let homogeneous = |row: &Vec<i64>| row.iter().map(number).chain([BigRational::zero()]).collect();
        let mut table: Vec<Vec<BigRational>> = rows.iter().map(homogeneous).collect();
        let width = rows[0].len();
        table.push(vec![BigRational::one(); width + 1]);
        table
    }

    proptest! {
        #[test]
        fn it_agrees_with_the_exact_search(
            rows in prop::collection::vec(prop::collection::vec(-4i64..=4, 7), 1..6)
        ) {
            let table = table(&rows);
            let exact = super::super::feasible(table.clone(), 7);
            match guessed(&table, 7) {
                Guess::Nothing => prop_assert!(exact.is_none()),
                Guess::Support(support) => {
                    let found = solved(&table, 7, &support);
                    prop_assert!(found.is_some() && exact.is_some());
                    let found = found.unwrap_or_default();
                    for row in &table {
                        let total: BigRational = row.iter().zip(&found).map(|(factor, number)| factor * number).sum();
                        prop_assert_eq!(&total, &row[7]);
                    }
                }
                Guess::Unclear => {}
            }
        }
    }

    #[test]
    fn what_is_no_solution_is_none() {
        let table = table(&[vec![1, -1, 2]]);
        assert!(solved(&table, 3, &[0]).is_none());
        assert!(solved(&table, 3, &[0, 2]).is_none());
        assert!(solved(&table, 3, &[0, 1]).is_some());
    }
}
