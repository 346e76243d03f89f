//! The kernel of one axis between two grids, as rows of weighted densities.

use super::bell::Bell;
use super::field::{CHUNK, Matrix, clear, filled};
use super::grid::Grid;
use super::kernel::{AxisRanges, Fast, contains};

/// Weighted densities below this are left out; like all that is left out, they are counted.
const LEAST: f64 = 1e-19;

/// What an operator is made from.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Key {
    pub motion: Fast,
    pub ranges: AxisRanges,
    /// Whether the next state matters.
    pub lands: bool,
    /// The points from which it leads, and the numbers of the grids.
    pub from: usize,
    pub to: usize,
}

/// Rows of numbers that each begin somewhere.
#[derive(Clone, Debug, Default)]
struct Rows {
    firsts: Vec<usize>,
    /// Where each row ends among the values.
    ends: Vec<usize>,
    values: Vec<f64>,
}

/// Rows of weighted densities: each begins at a point of the grid to which it leads.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    pub key: Key,
    rows: Rows,
    /// The same by the points to which they lead, where that is asked for.
    columns: Rows,
    /// The chance of going on from each point.
    pub chances: Vec<f64>,
    /// From where it leads, and to where.
    support: [(usize, usize); 2],
    /// The most values in a row or a column.
    pub longest: usize,
}

impl Rows {
    /// Where a row is among the values.
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        if row == 0 { 0..self.ends[row] } else { self.ends[row - 1]..self.ends[row] }
    }

    fn row(&self, row: usize) -> (usize, &[f64]) {
        (self.firsts[row], &self.values[self.range(row)])
    }

    fn add(&mut self, first: usize, values: &[f64]) {
        self.values.extend_from_slice(values);
        self.firsts.push(first);
        self.ends.push(self.values.len());
    }

    /// The rows that are not empty, from the first to the last.
    fn support(&self) -> (usize, usize) {
        let full = |row: &usize| !self.range(*row).is_empty();
        let mut rows = 0..self.ends.len();
        let first = rows.find(full).unwrap_or(0);
        (first, (first..self.ends.len()).rfind(full).map_or(first, |last| last + 1))
    }

    /// For each column of so many, the first row and the last one that reach it.
    fn reached(&self, columns: usize) -> Vec<(usize, usize)> {
        let mut reached = vec![(usize::MAX, 0); columns];
        for row in 0..self.ends.len() {
            let first = self.firsts[row];
            for column in &mut reached[first..first + self.range(row).len()] {
                *column = (column.0.min(row), row + 1);
            }
        }
        reached
    }

    /// Rows for the columns of which this is known; what is missing between is 0.
    fn turned(&self, reached: &[(usize, usize)]) -> Rows {
        let mut turned = Rows::default();
        let mut size = 0;
        for (first, last) in reached {
            size += last.saturating_sub(*first);
            turned.firsts.push(if last > first { *first } else { 0 });
            turned.ends.push(size);
        }
        turned.values.resize(size, 0.0);
        for row in 0..self.ends.len() {
            let (first, values) = self.row(row);
            for (column, value) in (first..).zip(values) {
                let start = if column == 0 { 0 } else { turned.ends[column - 1] };
                turned.values[start + row - turned.firsts[column]] = *value;
            }
        }
        turned
    }
}

impl Operator {
    /// The operator from these points, with densities up to so many standard deviations.
    pub(super) fn new(key: Key, from: &[f64], to: &Grid, band: f64) -> Operator {
        let Key { motion, ranges, lands, .. } = &key;
        let (mut rows, mut chances) = (Rows::default(), Vec::with_capacity(from.len()));
        let mut bell = Bell::new(motion, to, band);
        let mut longest = 0;
        for state in from {
            let chance = if contains(&ranges[0], *state) { motion.chance(ranges, *state).max(0.0) } else { 0.0 };
            chances.push(chance);
            if chance <= 0.0 || !lands {
                rows.add(0, if chance <= 0.0 { &[] } else { std::slice::from_ref(&chance) });
                continue;
            }
            let (first, values) = bell.row(motion, ranges, *state, to);
            let values = &values[..values.iter().rposition(|value| *value >= LEAST).map_or(0, |last| last + 1)];
            let small = values.iter().take_while(|value| **value < LEAST).count();
            longest = longest.max(values.len() - small);
            rows.add(first + small, &values[small..]);
        }
        let reached = rows.reached(if *lands { to.nodes.len() } else { 1 });
        let deep = reached.iter().map(|(first, last)| last.saturating_sub(*first)).max().unwrap_or(0);
        let low = reached.iter().position(|(first, last)| first < last).unwrap_or(0);
        let high = reached.iter().rposition(|(first, last)| first < last).map_or(low, |last| last + 1);
        let support = [rows.support(), (low, high)];
        Operator { key, rows, columns: Rows::default(), chances, support, longest: longest.max(deep) }
    }

    /// Makes products with matrices possible.
    pub(super) fn turn(&mut self, columns: usize) {
        self.columns = self.rows.turned(&self.rows.reached(columns));
    }

    pub(super) fn size(&self) -> usize {
        self.rows.values.len()
    }

    /// From where it leads, and to where.
    pub(super) fn support(&self) -> [(usize, usize); 2] {
        self.support
    }

    /// Multiplications to reach these points once.
    pub(super) fn work(&self, (low, high): (usize, usize)) -> usize {
        if low >= high { 0 } else { self.columns.range(high - 1).end - self.columns.range(low).start }
    }

    /// A row as far as it lies in a range of points: its values, and the place of the first in that range.
    pub(super) fn within(&self, row: usize, active: (usize, usize)) -> (&[f64], usize) {
        let (first, values) = self.rows.row(row);
        let low = first.max(active.0);
        let high = (first + values.len()).min(active.1);
        if low >= high { (&[], 0) } else { (&values[low - first..high - first], low - active.0) }
    }

    /// The first value of a row in a range of points, which is one point.
    pub(super) fn at(&self, row: usize, active: (usize, usize)) -> f64 {
        self.within(row, active).0.first().copied().unwrap_or(0.0)
    }

    /// The sums over one range of points with which another is reached, for so many columns of a matrix; a row for each
    /// column. Gives the places from one row to the next.
    pub(super) fn times(
        &self,
        [from, to]: [(usize, usize); 2],
        matrix: &Matrix,
        columns: usize,
        product: &mut Vec<f64>,
    ) -> usize {
        let stride = filled(to.1 - to.0);
        clear(product, columns.next_multiple_of(CHUNK) * stride);
        for (place, reached) in (to.0..to.1).enumerate() {
            let (first, values) = self.columns.row(reached);
            let (low, high) = (first.max(from.0), (first + values.len()).min(from.1));
            if low >= high {
                continue;
            }
            let values = &values[low - first..high - first];
            let rows = &matrix.values[(low - matrix.row) * matrix.stride + matrix.column..];
            let mut column = 0;
            while column < columns {
                let places = product[column * stride + place..].iter_mut().step_by(stride);
                if columns - column > CHUNK {
                    let sums: [f64; 2 * CHUNK] = summed(values, &rows[column..], matrix.stride);
                    places.zip(sums).for_each(|(place, sum)| *place = sum);
                    column += 2 * CHUNK;
                } else {
                    let sums: [f64; CHUNK] = summed(values, &rows[column..], matrix.stride);
                    places.zip(sums).for_each(|(place, sum)| *place = sum);
                    column += CHUNK;
                }
            }
        }
        stride
    }
}

/// The sums of rows that are so far from each other, weighted.
fn summed<const COUNT: usize>(weights: &[f64], rows: &[f64], stride: usize) -> [f64; COUNT] {
    let mut sums = [0.0; COUNT];
    for (number, weight) in weights.iter().enumerate() {
        let row = &rows[number * stride..number * stride + COUNT];
        for (sum, number) in sums.iter_mut().zip(row) {
            *sum += weight * number;
        }
    }
    sums
}
