//! Sums over both coordinates of a round: rows of weights along one, then along the other.

use std::rc::Rc;

use super::panels::Row;

/// Rows of weights of the second coordinate.
pub(super) enum Second {
    /// It does not matter.
    Nothing,
    /// The same for every first coordinate.
    Same(Vec<Rc<Row>>),
    /// By the first coordinate now.
    Now(Vec<Vec<Rc<Row>>>),
    /// By the next first coordinate.
    Next(Vec<Vec<Rc<Row>>>),
}

/// The weights of a way, by both coordinates.
pub(super) struct Operator {
    pub next: usize,
    pub first: Vec<Row>,
    pub second: Second,
}

/// Functions over the points of a phase: chances, and what they err by.
#[derive(Clone, Default)]
pub(super) struct Field {
    pub active: [(usize, usize); 2],
    pub values: Vec<f64>,
    pub errors: Vec<f64>,
}

impl Operator {
    /// Adds the sums over both coordinates of the next fields.
    pub(super) fn apply(&self, field: &mut Field, width: usize, next: &Field, after: usize) {
        let [rows, columns] = field.active;
        let [firsts, seconds] = next.active;
        let turned = match &self.second {
            Second::Next(all) => Some(along(all, firsts, columns, seconds, next, after, width)),
            _ => None,
        };
        for row in rows.0..rows.1 {
            let (weights, place) = self.first[row].within(firsts);
            let (source, wide, range) = match &turned {
                Some(turned) => (turned, width, columns),
                None => (next, after, seconds),
            };
            let mut sums = [vec![0.0; wide], vec![0.0; wide]];
            for (weight, first) in weights.iter().zip(place..) {
                let here = first * wide + range.0..first * wide + range.1;
                axpy(&mut sums[0][range.0..range.1], *weight, &source.values[here.clone()]);
                axpy(&mut sums[1][range.0..range.1], weight.abs(), &source.errors[here]);
            }
            let second = match &self.second {
                Second::Same(all) => Some(all),
                Second::Now(all) => all.get(row),
                _ => None,
            };
            for column in columns.0..columns.1 {
                let at = row * width + column;
                let (value, error) = match (second, &self.second) {
                    (Some(second), _) => dot(&second[column], seconds, &sums),
                    (None, Second::Nothing) => (sums[0][0], sums[1][0]),
                    (None, _) => (sums[0][column], sums[1][column]),
                };
                field.values[at] += value;
                field.errors[at] += error;
            }
        }
    }
}

/// The sums over the second coordinate for each next first one.
fn along(
    all: &[Vec<Rc<Row>>],
    firsts: (usize, usize),
    columns: (usize, usize),
    seconds: (usize, usize),
    next: &Field,
    after: usize,
    width: usize,
) -> Field {
    let mut turned =
        Field { values: vec![0.0; firsts.1 * width], errors: vec![0.0; firsts.1 * width], ..Field::default() };
    for (first, all) in all.iter().enumerate().take(firsts.1).skip(firsts.0) {
        let rows = first * after..(first + 1) * after;
        let here = [next.values[rows.clone()].to_vec(), next.errors[rows].to_vec()];
        for (column, row) in all.iter().enumerate().take(columns.1).skip(columns.0) {
            let (value, error) = dot(row, seconds, &here);
            turned.values[first * width + column] = value;
            turned.errors[first * width + column] = error;
        }
    }
    turned
}

fn axpy(sums: &mut [f64], weight: f64, numbers: &[f64]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += weight * number);
}

/// A row of the second coordinate times two functions, the second with absolute weights.
fn dot(row: &Row, range: (usize, usize), [values, errors]: &[Vec<f64>; 2]) -> (f64, f64) {
    let (weights, place) = row.within(range);
    let places = place..place + weights.len();
    let value = weights.iter().zip(&values[places.clone()]).map(|(weight, value)| weight * value).sum();
    let error = weights.iter().zip(&errors[places]).map(|(weight, error)| weight.abs() * error).sum();
    (value, error)
}
