//! The kernel of one axis between two grids, as rows of weighted densities.

use pulp::Simd;

use super::bell::Bell;
use super::field::{Matrix, clear, filled};
use super::grid::Grid;
use super::kernel::{AxisRanges, Fast, contains};
use super::wide::{CHUNK, Loop, product, widest};

/// Weighted densities below this share of a chance that is left out are left out too.
const TINY: f64 = 1e-2;

/// What is left out of an operator, and counted: what it leaves out of the chance of going on is found to be missing.
#[derive(Clone, Copy)]
pub(super) struct Cut {
    /// Standard deviations beyond which there are no densities.
    pub band: f64,
    /// Chances of going on that are not worth following.
    pub least: f64,
}

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

/// Where a row begins, and where it is among the values.
#[derive(Clone, Copy, Debug)]
struct Span {
    first: usize,
    start: usize,
    end: usize,
}

/// Rows of numbers that each begin somewhere; with zeros behind them up to a whole number of chunks, if they are turned.
#[derive(Clone, Debug, Default)]
struct Rows {
    spans: Vec<Span>,
    values: Vec<f64>,
}

/// Weighted densities from points to points.
#[derive(Clone, Debug)]
pub(super) struct Operator {
    pub key: Key,
    /// A row for each point to which it leads, over those from which it does.
    columns: Rows,
    /// The chance of going on from each point, and the greatest of them.
    pub chances: Vec<f64>,
    pub most: f64,
    /// From where it leads, and to where.
    support: [(usize, usize); 2],
    /// The most values in a row or a column.
    pub longest: usize,
}

impl Rows {
    #[inline(always)]
    fn row(&self, row: usize) -> (usize, &[f64]) {
        let Span { first, start, end } = self.spans[row];
        (first, &self.values[start..end])
    }

    fn add(&mut self, first: usize, values: &[f64]) {
        let start = self.values.len();
        self.values.extend_from_slice(values);
        self.spans.push(Span { first, start, end: self.values.len() });
    }

    /// The rows that are not empty, from the first to the last.
    fn support(&self) -> (usize, usize) {
        let full = |span: &Span| span.start < span.end;
        let first = self.spans.iter().position(full).unwrap_or(0);
        (first, self.spans.iter().rposition(full).map_or(first, |last| last + 1))
    }

    /// Rows for so many columns; what is missing between is 0.
    fn turned(&self, columns: usize) -> Rows {
        let mut reached = vec![(0, 0); columns];
        for (row, span) in self.spans.iter().enumerate() {
            for column in &mut reached[span.first..span.first + span.end - span.start] {
                *column = (if column.1 == 0 { row } else { column.0 }, row + 1);
            }
        }
        let mut turned = Rows::default();
        let mut start = 0;
        for (first, last) in &reached {
            let end = start + last - first;
            turned.spans.push(Span { first: *first, start, end });
            start += (end - start).next_multiple_of(CHUNK);
        }
        turned.values.resize(start, 0.0);
        for row in 0..self.spans.len() {
            let (first, values) = self.row(row);
            for (span, value) in turned.spans[first..].iter().zip(values) {
                turned.values[span.start + row - span.first] = *value;
            }
        }
        turned
    }
}

impl Operator {
    /// The operator from these points.
    ///
    /// # Errors
    /// Where it has more than so many values.
    pub(super) fn new(key: Key, from: &[f64], to: &Grid, cut: Cut, most_values: usize) -> Result<Operator, String> {
        let Key { motion, ranges, lands, .. } = &key;
        let (mut rows, mut chances) = (Rows::default(), Vec::with_capacity(from.len()));
        let mut bell = Bell::new(motion, to, cut.band);
        let mut longest = 0;
        for state in from {
            let chance = if contains(&ranges[0], *state) { motion.chance(ranges, *state).max(0.0) } else { 0.0 };
            chances.push(chance);
            if chance <= cut.least || !lands {
                rows.add(0, if chance <= cut.least { &[] } else { std::slice::from_ref(&chance) });
                continue;
            }
            let (first, values) = bell.row(motion, ranges, *state, to);
            let small = |value: &&f64| **value < TINY * cut.least;
            let values = &values[..values.len() - values.iter().rev().take_while(small).count()];
            let before = values.iter().take_while(small).count();
            longest = longest.max(values.len() - before);
            if rows.values.len() + values.len() > most_values {
                return Err("the kernel is too large".to_string());
            }
            rows.add(first + before, &values[before..]);
        }
        let columns = rows.turned(if *lands { to.nodes.len() } else { 1 });
        let deep = columns.spans.iter().map(|span| span.end - span.start).max().unwrap_or(0);
        let support = [rows.support(), columns.support()];
        let most = chances.iter().copied().fold(0.0, f64::max);
        Ok(Operator { key, columns, chances, most, support, longest: longest.max(deep) })
    }

    pub(super) fn size(&self) -> usize {
        self.columns.values.len()
    }

    /// From where it leads, and to where.
    pub(super) fn support(&self) -> [(usize, usize); 2] {
        self.support
    }

    /// Multiplications to reach these points once.
    pub(super) fn work(&self, (low, high): (usize, usize)) -> usize {
        if low >= high { 0 } else { self.columns.spans[high - 1].end - self.columns.spans[low].start }
    }

    /// The value from one point to another.
    pub(super) fn at(&self, row: usize, column: usize) -> f64 {
        let (first, values) = self.columns.row(column);
        row.checked_sub(first).and_then(|place| values.get(place)).copied().unwrap_or(0.0)
    }

    /// The values with which a point is reached from a range of others, and the first of these.
    #[inline(always)]
    pub(super) fn into(&self, column: usize, from: (usize, usize)) -> (&[f64], usize) {
        let (first, values) = self.columns.row(column);
        let (low, high) = (first.max(from.0), (first + values.len()).min(from.1));
        if low >= high { (&[], from.0) } else { (&values[low - first..high - first], low) }
    }

    /// Adds to these points, from one on, what they are reached with from masses, of which the first is that of point 0 and
    /// those outside a range are 0; times a weight.
    pub(super) fn add(
        &self,
        [from, to]: [(usize, usize); 2],
        weight: f64,
        masses: &[f64],
        sums: &mut [f64],
        start: usize,
    ) {
        widest(Add { operator: self, from, to, weight, masses, sums, start });
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
        widest(Times { operator: self, from, to, matrix, columns, product, stride });
        stride
    }
}

/// [`Operator::add`]
struct Add<'a> {
    operator: &'a Operator,
    from: (usize, usize),
    to: (usize, usize),
    weight: f64,
    masses: &'a [f64],
    sums: &'a mut [f64],
    start: usize,
}

impl Loop for Add<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Rows { spans, values } = &self.operator.columns;
        for (span, sum) in spans[self.to.0..self.to.1].iter().zip(&mut self.sums[self.to.0 - self.start..]) {
            let length = span.end - span.start;
            if span.first < self.from.1 && span.first + length > self.from.0 {
                let (values, _) = values[span.start..].as_chunks();
                // What is not a whole chunk at the end of the masses is 0.
                let (masses, _) = self.masses[span.first..].as_chunks();
                *sum += self.weight * product(simd, &values[..length.div_ceil(CHUNK)], masses);
            }
        }
    }
}

/// [`Operator::times`]
struct Times<'a> {
    operator: &'a Operator,
    from: (usize, usize),
    to: (usize, usize),
    matrix: &'a Matrix<'a>,
    columns: usize,
    product: &'a mut [f64],
    stride: usize,
}

impl Loop for Times<'_> {
    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let Times { operator, from, to, matrix, columns, product, stride } = self;
        for (place, reached) in (to.0..to.1).enumerate() {
            let (values, low) = operator.into(reached, from);
            if values.is_empty() {
                continue;
            }
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
    }
}

/// The sums of rows that are so far from each other, weighted.
#[inline(always)]
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
