//! Where the states are, as masses at the points of a phase, and the step from one round to the next.

use super::axes::AXES;
use super::operator::Operator;
use super::wide::CHUNK;

/// Masses at the active points of a phase: a row for each point of the second axis, along the first one.
#[derive(Clone, Default)]
pub(super) struct Field {
    pub active: [(usize, usize); AXES],
    /// The points of the first mass.
    origin: [usize; AXES],
    /// From one row to the next.
    stride: usize,
    /// Whether there is one row, in which all other points up to the last active one have no mass.
    flat: bool,
    masses: Vec<f64>,
}

/// Chances of success along both axes.
pub(super) struct Outcome {
    pub weight: f64,
    pub chances: [Vec<f64>; AXES],
}

/// Room for what is computed on the way.
#[derive(Default)]
pub(super) struct Room {
    turned: Vec<f64>,
    halfway: Vec<f64>,
    product: Vec<f64>,
}

/// Part of a matrix: what is summed over, from this row and column on.
pub(super) struct Matrix<'a> {
    pub values: &'a [f64],
    pub stride: usize,
    /// The point of which the first row is.
    pub row: usize,
    pub column: usize,
}

/// The places that a row of so many columns takes.
pub(super) fn filled(columns: usize) -> usize {
    if columns == 1 { 1 } else { columns.next_multiple_of(CHUNK) }
}

/// Zeros, with two chunks at the end that stay zeros.
pub(super) fn clear(values: &mut Vec<f64>, size: usize) {
    values.clear();
    values.resize(size + 2 * CHUNK, 0.0);
}

impl Field {
    /// Begins anew with nothing at these points.
    pub(super) fn clear(&mut self, active: [(usize, usize); AXES]) {
        let [columns, rows] = active.map(width);
        self.active = active;
        self.origin = active.map(|(low, _)| low);
        self.stride = filled(columns);
        self.flat = rows == 1;
        if self.flat {
            self.origin[0] = 0;
            self.stride = filled(active[0].1);
        }
        if columns == 0 || rows == 0 { self.masses.clear() } else { clear(&mut self.masses, rows * self.stride) }
    }

    /// The mass of one point where there is no state.
    pub(super) fn put(&mut self, mass: f64) {
        self.clear([(0, 1), (0, 1)]);
        self.masses[0] = mass;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.masses.is_empty()
    }

    /// The rows of the active points of the second axis, each over those of the first.
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        let [(first, last), (low, high)] = self.active;
        let [column, row] = self.origin;
        let rows = self.masses.chunks(self.stride.max(1)).take(high - row).skip(low - row);
        rows.map(move |masses| &masses[first - column..last - column])
    }

    /// The sum of all masses.
    pub(super) fn mass(&self) -> f64 {
        self.rows().map(sum).sum()
    }

    /// The sum of all masses, each weighted with a number for each axis.
    pub(super) fn weighted(&self, one: &[f64], other: &[f64]) -> f64 {
        let [(first, last), (low, high)] = self.active;
        let rows = self.rows().zip(&other[low..high]).filter(|(_, number)| **number != 0.0);
        rows.map(|(row, number)| number * product(row, &one[first..last])).sum()
    }

    /// Leaves out points at the ends of each axis on which there is less than this.
    pub(super) fn trim(&mut self, least: f64) {
        if self.is_empty() {
            return;
        }
        let [(first, last), (low, _)] = self.active;
        if width(self.active[1]) == 1 {
            let along = self.rows().next().map_or((first, first), |row| within(row, first, least));
            if along.0 >= along.1 {
                return self.clear([(0, 0), (0, 0)]);
            }
            if self.flat {
                self.masses[first..along.0].fill(0.0);
                self.masses[along.1..last].fill(0.0);
            }
            self.active[0] = along;
            return;
        }
        let across: Vec<f64> = self.rows().map(sum).collect();
        let mut along = vec![0.0; last - first];
        self.rows().for_each(|row| along.iter_mut().zip(row).for_each(|(sum, mass)| *sum += mass));
        self.active = [within(&along, first, least), within(&across, low, least)];
        if self.active.iter().any(|(low, high)| low >= high) {
            self.clear([(0, 0), (0, 0)]);
        }
    }

    /// Adds to the next round what one patch of a way leads to.
    pub(super) fn go(&self, weight: f64, one: &Operator, other: &Operator, next: &mut Field, room: &mut Room) {
        if self.is_empty() || next.is_empty() {
            return;
        }
        let thin = |axis: usize| width(self.active[axis]) == 1 && width(next.active[axis]) == 1;
        match (thin(0), thin(1)) {
            (_, true) => self.along(0, weight * other.at(self.active[1].0, next.active[1].0), one, next),
            (true, _) => self.along(1, weight * one.at(self.active[0].0, next.active[0].0), other, next),
            _ => self.across(weight, [one, other], next, room),
        }
    }

    /// The same, taken out of the next round; gives what is found to be taken out.
    pub(super) fn take(&self, weight: f64, one: &Operator, other: &Operator, next: &mut Field, room: &mut Room) -> f64 {
        let mut taken = Field::default();
        taken.clear(next.active);
        self.go(weight, one, other, &mut taken, room);
        next.masses.iter_mut().zip(&taken.masses).for_each(|(mass, part)| *mass -= part);
        taken.mass()
    }

    /// The same along one axis, where the other has one point.
    fn along(&self, axis: usize, weight: f64, operator: &Operator, next: &mut Field) {
        if weight == 0.0 {
            return;
        }
        let [sources, reached] = operator.support();
        let (from, to) = (meet(self.active[axis], sources), meet(next.active[axis], reached));
        if from.0 >= from.1 || to.0 >= to.1 {
            return;
        }
        let [origin, start] = [self.origin[axis], next.origin[axis]];
        if axis == 0 && self.flat {
            return operator.add([from, to], weight, &self.masses, &mut next.masses, start);
        }
        for point in to.0..to.1 {
            let (values, first) = operator.into(point, from);
            if axis == 0 {
                next.masses[point - start] += weight * product(values, &self.masses[first - origin..]);
            } else {
                let masses = self.masses[(first - origin) * self.stride..].iter().step_by(self.stride);
                let sum: f64 = values.iter().zip(masses).map(|(value, mass)| value * mass).sum();
                next.masses[(point - start) * next.stride] += weight * sum;
            }
        }
    }

    /// The same on a plane: along one axis, then along the other, in the order that takes less.
    fn across(&self, weight: f64, operators: [&Operator; AXES], next: &mut Field, room: &mut Room) {
        let spans: [[(usize, usize); 2]; AXES] = std::array::from_fn(|axis| {
            let [from, to] = operators[axis].support();
            [meet(from, self.active[axis]), meet(to, next.active[axis])]
        });
        if spans.iter().flatten().any(|(low, high)| low >= high) {
            return;
        }
        let work = |axis: usize| operators[axis].work(spans[axis][1]);
        let cost =
            |early: usize, late: usize| work(early) * width(spans[late][0]) + work(late) * width(spans[early][1]);
        let (early, late) = if cost(0, 1) < cost(1, 0) { (0, 1) } else { (1, 0) };
        let (values, stride) = match early {
            0 => self.turned(&mut room.turned),
            _ => (self.masses.as_slice(), self.stride),
        };
        let (column, end) = (spans[late][0].0, spans[late][0].1);
        let source = Matrix { values, stride, row: self.origin[early], column: column - self.origin[late] };
        let stride = operators[early].times(spans[early], &source, end - column, &mut room.halfway);
        let source = Matrix { values: &room.halfway, stride, row: column, column: 0 };
        let [low, high] = [spans[early][1], spans[late][1]];
        let stride = operators[late].times(spans[late], &source, width(low), &mut room.product);
        let rows = room.product.chunks(stride).take(width(low));
        // Nothing is left out of it yet.
        let start = spans[0][1].0 - next.origin[0] + (spans[1][1].0 - next.origin[1]) * next.stride;
        for (place, row) in rows.enumerate() {
            let row = row[..width(high)].iter().map(|value| weight * value);
            match early {
                // A row for each point of the first axis.
                0 => {
                    let sums = next.masses[start + place..].iter_mut().step_by(next.stride);
                    sums.zip(row).for_each(|(sum, value)| *sum += value);
                }
                _ => {
                    let sums = next.masses[start + place * next.stride..].iter_mut();
                    sums.zip(row).for_each(|(sum, value)| *sum += value);
                }
            }
        }
    }

    /// With a row for each point of the first axis, and the places from one row to the next.
    fn turned<'a>(&self, turned: &'a mut Vec<f64>) -> (&'a [f64], usize) {
        let columns = self.stride;
        let rows = self.masses.len() / columns;
        let stride = filled(rows);
        clear(turned, columns * stride);
        for (place, row) in self.masses.chunks_exact(columns).enumerate() {
            let places = turned[place..].iter_mut().step_by(stride);
            places.zip(row).for_each(|(place, mass)| *place = *mass);
        }
        (turned, stride)
    }
}

/// The points without those at both ends on which there is less than this together.
fn within(masses: &[f64], first: usize, least: f64) -> (usize, usize) {
    let small = |masses: &mut dyn Iterator<Item = &f64>| {
        let mut sum = 0.0;
        let small = |mass: &&f64| {
            sum += **mass;
            sum < least
        };
        masses.take_while(small).count()
    };
    let (low, high) = (small(&mut masses.iter()), small(&mut masses.iter().rev()));
    (first + low, (first + masses.len()).saturating_sub(high).max(first + low))
}

/// The sum of products, several at a time: of n of them with n/8 + 11 roundings, counting that of the products.
#[inline]
fn product(one: &[f64], other: &[f64]) -> f64 {
    let other = &other[..one.len()];
    let (some, rest) = one.as_chunks::<CHUNK>();
    let (others, last) = other.as_chunks::<CHUNK>();
    let mut sums = [0.0; CHUNK];
    for (one, other) in some.iter().zip(others) {
        for (sum, (one, other)) in sums.iter_mut().zip(one.iter().zip(other)) {
            *sum += one * other;
        }
    }
    together(sums) + rest.iter().zip(last).map(|(one, other)| one * other).sum::<f64>()
}

/// The sum, in the same way.
fn sum(numbers: &[f64]) -> f64 {
    let (some, rest) = numbers.as_chunks::<CHUNK>();
    let mut sums = [0.0; CHUNK];
    for numbers in some {
        sums.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += number);
    }
    together(sums) + rest.iter().sum::<f64>()
}

fn together([a, b, c, d, e, f, g, h]: [f64; CHUNK]) -> f64 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

fn meet(one: (usize, usize), other: (usize, usize)) -> (usize, usize) {
    (one.0.max(other.0), one.1.min(other.1))
}

fn width((low, high): (usize, usize)) -> usize {
    high.saturating_sub(low)
}
