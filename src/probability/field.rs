//! Chances of success at the points of a phase, and the step from one round to the one before.

use super::axes::AXES;
use super::operator::Operator;

/// Chances at the active points of a phase, and what was left out.
#[derive(Clone, Default)]
pub(super) struct Field {
    pub active: [(usize, usize); AXES],
    pub values: Vec<f64>,
    pub leaks: Vec<f64>,
}

/// Chances of success along both axes.
pub(super) struct Outcome {
    pub weight: f64,
    pub chances: [Vec<f64>; AXES],
}

impl Field {
    /// Adds what one patch of a way leads to.
    pub(super) fn go(&mut self, weight: f64, one: &Operator, other: &Operator, after: &Field) {
        let [rows, columns] = self.active;
        let width = columns.1 - columns.0;
        if width == 1 && (after.values.is_empty() || after.active[1].1 - after.active[1].0 == 1) {
            return self.go_along(weight, one, other, after);
        }
        let chances = |operator: &Operator, range: (usize, usize)| operator.chances[range.0..range.1].to_vec();
        add(&mut self.leaks, &chances(one, rows), &chances(other, columns), weight);
        if after.values.is_empty() {
            return;
        }
        let totals = |operator: &Operator, range: (usize, usize), active: (usize, usize)| {
            (range.0..range.1).map(|row| operator.total(row, active)).collect::<Vec<f64>>()
        };
        let (inner, outer) = (after.active[0].1 - after.active[0].0, after.active[1].1 - after.active[1].0);
        add(&mut self.leaks, &totals(one, rows, after.active[0]), &totals(other, columns, after.active[1]), -weight);
        // Chances and leaks side by side: along the second axis first, then along the first.
        let turned = beside(&turn(&after.values, inner, outer), &turn(&after.leaks, inner, outer), inner);
        let along = other.times(columns, after.active[1], &turned, 2 * inner);
        let (values, leaks) = apart(&along, inner);
        let turned = beside(&turn(&values, width, inner), &turn(&leaks, width, inner), width);
        let product = one.times(rows, after.active[0], &turned, 2 * width);
        for (place, row) in product.chunks_exact(2 * width).enumerate() {
            let (values, leaks) = row.split_at(width);
            let here = place * width..(place + 1) * width;
            self.values[here.clone()].iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            self.leaks[here].iter_mut().zip(leaks).for_each(|(sum, leak)| *sum += weight * leak);
        }
    }
}

impl Field {
    /// The same where the second axis has one point.
    fn go_along(&mut self, weight: f64, one: &Operator, other: &Operator, after: &Field) {
        let [rows, (column, _)] = self.active;
        let along = if after.values.is_empty() { 0.0 } else { other.total(column, after.active[1]) };
        let sums = self.values.iter_mut().zip(&mut self.leaks);
        for (row, (value, leak)) in (rows.0..rows.1).zip(sums) {
            *leak += weight * one.chances[row] * other.chances[column];
            if along == 0.0 {
                continue;
            }
            let (weights, place) = one.within(row, after.active[0]);
            let places = place..place + weights.len();
            let [passed, left] = products(weights, [&after.values[places.clone()], &after.leaks[places]]);
            *leak += weight * along * (left - one.total(row, after.active[0]));
            *value += weight * along * passed;
        }
    }
}

/// The products of a row with two columns, several sums at a time.
fn products(row: &[f64], columns: [&[f64]; 2]) -> [f64; 2] {
    columns.map(|column| {
        let (some, rest) = row.as_chunks::<4>();
        let (others, last) = column.as_chunks::<4>();
        let mut sums = [0.0; 4];
        for (one, other) in some.iter().zip(others) {
            for (sum, (one, other)) in sums.iter_mut().zip(one.iter().zip(other)) {
                *sum += one * other;
            }
        }
        let rest: f64 = rest.iter().zip(last).map(|(one, other)| one * other).sum();
        (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
    })
}

/// Adds a product of two vectors to a matrix.
pub(super) fn add(matrix: &mut [f64], one: &[f64], other: &[f64], weight: f64) {
    for (row, factor) in matrix.chunks_exact_mut(other.len().max(1)).zip(one) {
        let factor = weight * factor;
        row.iter_mut().zip(other).for_each(|(entry, number)| *entry += factor * number);
    }
}

/// The transpose of a matrix of so many rows and columns.
fn turn(matrix: &[f64], rows: usize, columns: usize) -> Vec<f64> {
    let mut turned = vec![0.0; matrix.len()];
    for (place, row) in matrix.chunks_exact(columns.max(1)).enumerate().take(rows) {
        for (column, number) in row.iter().enumerate() {
            turned[column * rows + place] = *number;
        }
    }
    turned
}

/// Two matrices of so many columns, side by side.
fn beside(one: &[f64], other: &[f64], columns: usize) -> Vec<f64> {
    let mut both = Vec::with_capacity(2 * one.len());
    for (row, other) in one.chunks_exact(columns).zip(other.chunks_exact(columns)) {
        both.extend_from_slice(row);
        both.extend_from_slice(other);
    }
    both
}

fn apart(both: &[f64], columns: usize) -> (Vec<f64>, Vec<f64>) {
    let (mut one, mut other) = (Vec::with_capacity(both.len() / 2), Vec::with_capacity(both.len() / 2));
    for row in both.chunks_exact(2 * columns) {
        one.extend_from_slice(&row[..columns]);
        other.extend_from_slice(&row[columns..]);
    }
    (one, other)
}
