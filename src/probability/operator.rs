//! The kernel of one axis between two grids, as rows of weighted densities.

use super::grid::Grid;
use super::kernel::{AxisRanges, BAND, Fast, contains};

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

/// Rows of weighted densities: each begins at a point of the grid to which it leads.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    pub key: Key,
    firsts: Vec<usize>,
    /// Where each row ends among the values.
    ends: Vec<usize>,
    values: Vec<f64>,
    /// The sum of each row.
    totals: Vec<f64>,
    /// The chance of going on from each point.
    pub chances: Vec<f64>,
    /// The most values in a row.
    pub longest: usize,
}

/// A row in the making: the place of its first value, and the values.
type Row = (usize, Vec<f64>);

impl Operator {
    /// The operator from these points.
    pub(super) fn new(key: Key, from: &[f64], to: &Grid) -> Operator {
        let count = from.len();
        let mut operator = Operator {
            firsts: Vec::with_capacity(count),
            ends: Vec::with_capacity(count),
            values: Vec::new(),
            totals: Vec::with_capacity(count),
            chances: Vec::with_capacity(count),
            longest: 0,
            key,
        };
        for state in from {
            let Key { motion, ranges, lands, .. } = &operator.key;
            let chance = if contains(&ranges[0], *state) { motion.chance(ranges, *state) } else { 0.0 };
            let row = match lands {
                _ if chance <= 0.0 => (0, Vec::new()),
                true => operator.straight(*state, to),
                false => (0, vec![chance]),
            };
            operator.add(row, chance);
        }
        operator
    }

    /// Densities from a state to the points of a grid.
    fn straight(&self, state: f64, to: &Grid) -> Row {
        let Key { motion, ranges, .. } = &self.key;
        let (passes, mean) = (motion.passes(ranges, state), motion.mean(state));
        let first = to.nodes.partition_point(|node| *node < mean - BAND * motion.sd);
        let places = to.nodes[first..].iter().zip(&to.weights[first..]);
        let places = places.take_while(|(node, _)| **node <= mean + BAND * motion.sd);
        let value = |(node, weight): (&f64, &f64)| weight * passes * motion.density(&ranges[1], state, *node);
        (first, places.map(value).collect())
    }

    fn add(&mut self, (first, mut values): Row, chance: f64) {
        while values.last().is_some_and(|value| *value < LEAST) {
            values.pop();
        }
        let small = values.iter().take_while(|value| **value < LEAST).count();
        self.values.extend_from_slice(&values[small..]);
        self.totals.push(values[small..].iter().sum());
        self.longest = self.longest.max(values.len() - small);
        self.firsts.push(first + small);
        self.ends.push(self.values.len());
        self.chances.push(chance);
    }

    pub(super) fn size(&self) -> usize {
        self.values.len()
    }

    /// Where a row is among the values.
    fn range(&self, row: usize) -> std::ops::Range<usize> {
        if row == 0 { 0..self.ends[row] } else { self.ends[row - 1]..self.ends[row] }
    }

    /// A row as far as it lies in a range of points: its values, and the place of the first in that range.
    pub(super) fn within(&self, row: usize, active: (usize, usize)) -> (&[f64], usize) {
        let (first, values) = (self.firsts[row], &self.values[self.range(row)]);
        let low = first.max(active.0);
        let high = (first + values.len()).min(active.1);
        if low >= high { (&[], 0) } else { (&values[low - first..high - first], low - active.0) }
    }

    /// The sum of a row over a range of points.
    pub(super) fn total(&self, row: usize, active: (usize, usize)) -> f64 {
        let (values, _) = self.within(row, active);
        if values.len() == self.range(row).len() { self.totals[row] } else { values.iter().sum() }
    }

    /// The product with a matrix of `width` columns whose rows are the points of a range, for a range of rows.
    pub(super) fn times(&self, rows: (usize, usize), active: (usize, usize), matrix: &[f64], width: usize) -> Vec<f64> {
        let mut product = vec![0.0; (rows.1 - rows.0) * width];
        for (row, out) in (rows.0..rows.1).zip(product.chunks_exact_mut(width)) {
            let (values, place) = self.within(row, active);
            let matrix = &matrix[place * width..(place + values.len()) * width];
            let mut column = 0;
            while column + CHUNK <= width {
                let mut sums = [0.0; CHUNK];
                for (value, row) in values.iter().zip(matrix.chunks_exact(width)) {
                    for (sum, number) in sums.iter_mut().zip(&row[column..column + CHUNK]) {
                        *sum += value * number;
                    }
                }
                out[column..column + CHUNK].copy_from_slice(&sums);
                column += CHUNK;
            }
            for (value, row) in values.iter().zip(matrix.chunks_exact(width)) {
                for (sum, number) in out[column..].iter_mut().zip(&row[column..]) {
                    *sum += value * number;
                }
            }
        }
        product
    }
}

/// Columns that are summed at a time.
const CHUNK: usize = 8;
