//! Systems of linear equations over the rationals, by Gaussian elimination.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::rational::{product, quotient, sum};

/// The reduced echelon form over the first so many columns, and the column of the leading 1 of each row that has one; all
/// other rows are 0 there.
pub(crate) fn reduced(mut rows: Vec<Vec<BigRational>>, columns: usize) -> (Vec<Vec<BigRational>>, Vec<usize>) {
    let mut pivots = Vec::new();
    for column in 0..columns {
        let target = pivots.len();
        let Some(found) = (target..rows.len()).find(|row| !rows[*row][column].is_zero()) else { continue };
        rows.swap(target, found);
        let lead = std::mem::replace(&mut rows[target][column], BigRational::one());
        let entries = rows[target].iter_mut().skip(column + 1).filter(|entry| !entry.is_zero());
        entries.for_each(|entry| *entry = quotient(entry, &lead));
        let pivot = rows[target].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(place, row)| *place != target && !row[column].is_zero()) {
            let factor = -std::mem::take(&mut row[column]);
            for (entry, other) in row.iter_mut().zip(&pivot).skip(column + 1).filter(|(_, other)| !other.is_zero()) {
                *entry = sum(entry, &product(&factor, other));
            }
        }
        pivots.push(column);
    }
    (rows, pivots)
}

/// Numbers with which the first so many columns add up to the one after them, those that are free being 0; nothing where
/// there are none.
pub(crate) fn combination(rows: Vec<Vec<BigRational>>, columns: usize) -> Option<Vec<BigRational>> {
    let (mut rows, pivots) = reduced(rows, columns);
    if rows[pivots.len()..].iter().any(|row| !row[columns].is_zero()) {
        return None;
    }
    let mut numbers = vec![BigRational::zero(); columns];
    for (row, column) in rows.iter_mut().zip(pivots) {
        numbers[column] = std::mem::take(&mut row[columns]);
    }
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(entries: &[&[i64]]) -> Vec<Vec<BigRational>> {
        let number = |entry: &i64| BigRational::from_integer((*entry).into());
        entries.iter().map(|row| row.iter().map(number).collect()).collect()
    }

    #[test]
    fn what_is_found_solves_and_what_is_not_cannot() {
        // Every system of two equations in two unknowns with small numbers.
        let all: Vec<i64> = (-2..=2).collect();
        let mut open = vec![Vec::new()];
        for _ in 0..6 {
            open =
                open.iter().flat_map(|row: &Vec<i64>| all.iter().map(|last| [&row[..], &[*last]].concat())).collect();
        }
        for entries in open {
            let [a, b, c, d, e, f] = entries[..] else { continue };
            let system = rows(&[&[a, b, c], &[d, e, f]]);
            match combination(system.clone(), 2) {
                Some(found) => {
                    for row in &system {
                        assert_eq!(&row[0] * &found[0] + &row[1] * &found[1], row[2], "{entries:?}");
                    }
                }
                // By Cramer's rule there is no solution only where the determinant is 0 and another one is not, or where
                // an equation has no unknown.
                None => {
                    let apart = (c * e - b * f, a * f - c * d) != (0, 0);
                    let empty = (a, b) == (0, 0) && c != 0 || (d, e) == (0, 0) && f != 0;
                    assert!(a * e == b * d && (apart || empty), "{entries:?}");
                }
            }
        }
    }

    #[test]
    fn columns_that_follow_from_others_lead_no_row() {
        let (found, pivots) = reduced(rows(&[&[0, 1, 2], &[0, 2, 4], &[3, 0, 6]]), 3);
        assert_eq!(pivots, [0, 1]);
        assert_eq!(found, rows(&[&[1, 0, 2], &[0, 1, 2], &[0, 0, 0]]));
    }
}
