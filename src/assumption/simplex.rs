//! The first phase of the simplex method in whole numbers, with Bland's rule: no common factors are looked for.
//!
//! A table is kept times the determinant of its basis, so that all of it is whole and a pivot divides by the determinant
//! before without a remainder (Edmonds' integer pivoting; Bareiss' elimination). A row that a pivot leaves alone keeps the
//! determinant that it had.

use dashu_int::IBig;
use dashu_int::ops::BitTest;

/// The most steps.
const MOST_PIVOTS: usize = 250;
/// The time that it may take, in that of a number of 64 bits.
const MOST_WORK: usize = 1_000_000;

/// A system of equations, of which a solution is looked for in numbers that are not negative.
pub(super) struct Table {
    /// Equations: the coefficients of the unknowns, and a right side that is not negative.
    rows: Vec<Row>,
    /// Their sum, which is to become 0.
    objective: Row,
    /// The unknown that each row stands for; those from the width on are artificial, and their columns are not kept.
    basis: Vec<usize>,
    determinant: IBig,
    work: usize,
}

#[derive(Clone)]
struct Row {
    entries: Vec<IBig>,
    /// What the entries are multiplied by.
    scale: IBig,
}

impl Table {
    /// Of rows of one length, at least one.
    pub(super) fn new(rows: Vec<Vec<IBig>>) -> Self {
        let width = rows.first().map_or(0, |row| row.len().saturating_sub(1));
        let basis = (width..width + rows.len()).collect();
        let mut objective = vec![IBig::ZERO; width + 1];
        for row in &rows {
            for (total, number) in objective.iter_mut().zip(row) {
                *total += number;
            }
        }
        let whole = |entries| Row { entries, scale: IBig::ONE };
        let rows = rows.into_iter().map(whole).collect();
        Self { rows, objective: whole(objective), basis, determinant: IBig::ONE, work: 0 }
    }

    fn width(&self) -> usize {
        self.objective.entries.len() - 1
    }

    /// Numbers in the proportion of unknowns that are not negative and solve the equations; `None` where there are none, or
    /// where that was not found out within the limits.
    pub(super) fn solution(mut self) -> Option<Vec<IBig>> {
        let width = self.width();
        for _ in 0..MOST_PIVOTS {
            if self.objective.entries[width].is_zero() {
                return Some(self.read());
            }
            if self.work > MOST_WORK {
                return None;
            }
            let entering = self.objective.entries[..width].iter().position(is_positive)?;
            let leaving = self.leaving(entering)?;
            self.pivot(leaving, entering);
        }
        None
    }

    /// The row that bounds the unknown first; of several the one that stands for the first unknown.
    fn leaving(&self, entering: usize) -> Option<usize> {
        let width = self.width();
        let bounds = self.rows.iter().enumerate().filter(|(_, row)| is_positive(&row.entries[entering]));
        let sooner = |one: &(usize, &Row), other: &(usize, &Row)| {
            let left = &one.1.entries[width] * &other.1.entries[entering];
            let right = &other.1.entries[width] * &one.1.entries[entering];
            left.cmp(&right).then(self.basis[one.0].cmp(&self.basis[other.0]))
        };
        bounds.min_by(sooner).map(|(place, _)| place)
    }

    fn pivot(&mut self, leaving: usize, entering: usize) {
        let mut chosen = self.rows[leaving].clone();
        if chosen.scale != self.determinant {
            for entry in chosen.entries.iter_mut().filter(|entry| !entry.is_zero()) {
                *entry = &*entry * &self.determinant / &chosen.scale;
            }
        }
        let next = chosen.entries[entering].clone();
        for (place, row) in self.rows.iter_mut().enumerate() {
            if place != leaving {
                self.work += row.without(entering, &chosen.entries, &next);
            }
        }
        self.work += self.objective.without(entering, &chosen.entries, &next);
        chosen.scale.clone_from(&next);
        self.rows[leaving] = chosen;
        self.basis[leaving] = entering;
        self.determinant = next;
    }

    fn read(&self) -> Vec<IBig> {
        let width = self.width();
        let mut solution = vec![IBig::ZERO; width];
        for (row, unknown) in self.rows.iter().zip(&self.basis).filter(|(_, unknown)| **unknown < width) {
            solution[*unknown] = &row.entries[width] * &self.determinant / &row.scale;
        }
        solution
    }
}

impl Row {
    /// Takes so much of the other row off that the column falls away; returns the time that it took.
    fn without(&mut self, column: usize, other: &[IBig], next: &IBig) -> usize {
        let factor = self.entries[column].clone();
        if factor.is_zero() {
            return 0;
        }
        let longest = self.entries.iter().chain(other).map(BitTest::bit_len).max().unwrap_or(0);
        let words = longest.max(next.bit_len()) / 64;
        for (entry, other) in self.entries.iter_mut().zip(other) {
            if entry.is_zero() && other.is_zero() {
                continue;
            }
            let times = if other.is_zero() { &*entry * next } else { &*entry * next - &factor * other };
            *entry = if self.scale.is_one() { times } else { times / &self.scale };
        }
        self.scale.clone_from(next);
        self.entries.len() * (1 + words + words * words / 8)
    }
}

fn is_positive(number: &IBig) -> bool {
    *number > IBig::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of coefficients, each with its right side last.
    fn table(rows: &[&[i64]]) -> (Vec<Vec<IBig>>, Table) {
        let rows: Vec<Vec<IBig>> = rows.iter().map(|row| row.iter().copied().map(IBig::from).collect()).collect();
        (rows.clone(), Table::new(rows))
    }

    #[test]
    fn what_is_found_solves_the_equations() {
        let all: [&[&[i64]]; 3] = [
            &[&[1, 1, 1, 1], &[2, -1, 0, 0]],
            &[&[3, -2, 5, -7, 0], &[-4, 6, 1, 2, 0], &[1, 1, 1, 1, 1]],
            &[&[2, 3, 5, 7, 11, 100], &[13, -17, 19, -23, 29, 31], &[1, 0, -1, 0, 1, 0]],
        ];
        for rows in all {
            let (rows, table) = table(rows);
            let found = table.solution().expect("a solution");
            assert!(found.iter().all(|number| *number >= IBig::ZERO) && found.iter().any(is_positive));
            // All right sides are met to the same scale.
            let sides: Vec<(IBig, &IBig)> = rows
                .iter()
                .map(|row| {
                    let sum = row.iter().zip(&found).map(|(factor, number)| factor * number).sum();
                    (sum, &row[row.len() - 1])
                })
                .collect();
            for (one, wanted) in &sides {
                for (other, right) in &sides {
                    assert_eq!(one * *right, other * *wanted, "{rows:?} {found:?}");
                }
            }
        }
    }

    #[test]
    fn there_is_none_where_equations_contradict_each_other() {
        let all: [&[&[i64]]; 3] = [&[&[1, 1, 1], &[1, 1, 2]], &[&[-1, -2, 1]], &[&[1, -1, 0], &[1, 1, 0], &[2, 1, 3]]];
        for rows in all {
            assert_eq!(table(rows).1.solution(), None, "{rows:?}");
        }
    }
}
