//! Functions of one number that are linear between nodes, with what they may be wrong by; and what is expected of one
//! once noise of any kind that has a density is added to the number.
//!
//! A function is known by its values at both ends of each cell and by a bound on what it errs by inside. With noise of
//! density f and distribution F the expectation is `g(z) = ∫ f(y-z) W(y) dy`. Three errors are bounded:
//!
//! * *in a cell of W* its mean is taken for it: what is linear by as much as d over a length h errs by at most
//!   `d*h/8` times the variation of f in the cell;
//! * *between two places of g*, H apart, g is taken to be linear: it errs by at most H/4 times the variation of its slope,
//!   which is `∫ f(y-z) dW(y)`. What W's slope changes by at x varies by that times `F(x-z)`, which only falls; a jump of W
//!   at x by that times f;
//! * *what W errs by* is averaged; between two places that changes by no more than what it changes by at the nodes does.

use super::noise::Noise;

/// A function that is linear between nodes.
#[derive(Clone, Debug)]
pub struct Broken {
    /// In rising order.
    pub nodes: Vec<f64>,
    /// The values at both ends of each cell.
    pub cells: Vec<(f64, f64)>,
    /// What each cell errs by at most.
    pub errors: Vec<f64>,
    /// Below the first node and above the last: the value, and what it errs by.
    pub outside: [(f64, f64); 2],
}

/// What is expected at some places in rising order.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The values.
    pub values: Vec<f64>,
    /// What each errs by at most.
    pub errors: Vec<f64>,
    /// What a function that is linear between them errs by, between each and the next.
    pub between: Vec<f64>,
}

/// The distribution of some noise over nodes, seen from each of some places.
#[derive(Clone, Debug)]
pub struct Kernel {
    /// What `F(x-z)` gains from each node to the next: before the first, between them, behind the last; from the first of
    /// these that is not 0 to the last.
    gains: Vec<(usize, Vec<f64>)>,
    /// What it falls by at each node from a place to the next, in the same way.
    falls: Vec<(usize, Vec<f64>)>,
    places: Vec<f64>,
    /// What one of its numbers errs by.
    rounding: f64,
}

/// Less than this of a distribution is left out, and counted.
const TAIL: f64 = 1e-17;

impl Kernel {
    /// For these nodes and places, both in rising order.
    pub fn new(nodes: &[f64], places: Vec<f64>, noise: &Noise) -> Kernel {
        // From the first node at which it is not 0 to the last at which it is not 1.
        let row = |place: &f64| -> (usize, Vec<f64>) {
            let first = nodes.partition_point(|node| noise.below(node - place) <= TAIL);
            let last = nodes.partition_point(|node| noise.below(node - place) < 1.0 - f64::EPSILON);
            (first, nodes[first..last.max(first)].iter().map(|node| noise.below(node - place)).collect())
        };
        let rows: Vec<(usize, Vec<f64>)> = places.iter().map(row).collect();
        let gains = |(first, row): &(usize, Vec<f64>)| {
            let before = [0.0].into_iter().chain(row.iter().copied());
            (*first, row.iter().copied().chain([1.0]).zip(before).map(|(now, before)| now - before).collect())
        };
        let falls = |pair: &[(usize, Vec<f64>)]| {
            let [(first, row), (other, next)] = pair else { return (0, Vec::new()) };
            let until = (first + row.len()).max(other + next.len());
            let at = |first: usize, row: &[f64], node: usize| match node.checked_sub(first) {
                None => 0.0,
                Some(place) => row.get(place).copied().unwrap_or(1.0),
            };
            let fall = |node: usize| (at(*first, row, node) - at(*other, next, node)).max(0.0);
            (*first, (*first..until).map(fall).collect())
        };
        let size = |all: &[f64]| all.iter().fold(0.0, |most: f64, one| most.max(one.abs()));
        let reach = size(nodes) + size(&places);
        Kernel {
            gains: rows.iter().map(gains).collect(),
            falls: rows.windows(2).map(falls).collect(),
            rounding: f64::EPSILON * (16.0 + 4.0 * reach * noise.peak()) + TAIL,
            places,
        }
    }
}

/// The sum of the products of a band of numbers with those at the same places.
fn dot((first, band): &(usize, Vec<f64>), numbers: &[f64]) -> f64 {
    band.iter().zip(&numbers[(*first).min(numbers.len())..]).map(|(one, other)| one * other).sum()
}

/// Numbers of cells between those outside.
fn framed(numbers: impl Iterator<Item = f64>, ends: [f64; 2]) -> Vec<f64> {
    [ends[0]].into_iter().chain(numbers).chain([ends[1]]).collect()
}

/// Places below the first node and above the last.
fn beyond(nodes: &[f64]) -> [f64; 2] {
    let far = |place: Option<&f64>, side: f64| place.map_or(0.0, |place| place + side * (1.0 + place.abs()));
    [far(nodes.first(), -1.0), far(nodes.last(), 1.0)]
}

impl Broken {
    /// A function that has these values, the same all over a cell.
    pub fn flat(nodes: &[f64], value: &dyn Fn(f64) -> f64) -> Broken {
        let cells = nodes.windows(2).map(|ends| value((ends[0] + ends[1]) / 2.0)).map(|value| (value, value)).collect();
        let errors = vec![0.0; nodes.len().saturating_sub(1)];
        let outside = beyond(nodes).map(|place| (value(place), 0.0));
        Broken { nodes: if nodes.is_empty() { vec![0.0] } else { nodes.to_vec() }, cells, errors, outside }
    }

    /// Gives it values that are certain, the same all over a cell, where there are such.
    pub fn put(&mut self, value: &dyn Fn(f64) -> Option<f64>) {
        for (place, ends) in self.nodes.windows(2).enumerate() {
            if let Some(value) = value((ends[0] + ends[1]) / 2.0) {
                (self.cells[place], self.errors[place]) = ((value, value), 0.0);
            }
        }
        for (outside, place) in self.outside.iter_mut().zip(beyond(&self.nodes)) {
            if let Some(value) = value(place) {
                *outside = (value, 0.0);
            }
        }
    }

    /// Through these values, with nothing known outside.
    pub fn through(nodes: Vec<f64>, expected: &Expected) -> Broken {
        let cells = expected.values.windows(2).map(|pair| (pair[0], pair[1])).collect();
        Broken { nodes, cells, errors: expected.between.clone(), outside: [(0.0, 1.0); 2] }
    }

    /// What it is between each of these places, in order, and the next, without noise: linear between its values at both
    /// ends, and what that errs by; at a single place, there.
    pub fn pushed(&self, places: &[f64]) -> Vec<(f64, f64, f64)> {
        let (jumps, bends) = (self.jumps(), self.bends());
        let count = self.cells.len();
        let between = |one: f64, other: f64| {
            let (low, high) = (one.min(other), one.max(other));
            // Places that rounding may have moved across a node count on both of its sides.
            let slack = 16.0 * f64::EPSILON * (low.abs() + high.abs());
            let first = self.nodes.partition_point(|node| *node < low - slack);
            let last = self.nodes.partition_point(|node| *node <= high + slack);
            let inside = |node: &usize| self.nodes[*node] > low + slack && self.nodes[*node] < high - slack;
            let at = |place: f64, cell: usize| match cell {
                0 => self.outside[0].0,
                cell if cell > count => self.outside[1].0,
                cell => {
                    let ((left, right), ends) = (self.cells[cell - 1], &self.nodes[cell - 1..=cell]);
                    left + (right - left) * (place - ends[0]) / (ends[1] - ends[0])
                }
            };
            let error = |cell: usize| match cell {
                0 => self.outside[0].1,
                cell if cell > count => self.outside[1].1,
                cell => self.errors[cell - 1],
            };
            let worst = (first..=last).map(error).fold(0.0, f64::max);
            let jumped: f64 = (first..last).map(|node| jumps[node].abs()).sum();
            let bent: f64 = (first..last).filter(inside).map(|node| bends[node]).sum();
            let ends = (at(low, first), at(high, last));
            let wrong = worst + jumped + bent * (high - low) / 4.0 + 64.0 * f64::EPSILON * (1.0 + bent * (high - low));
            if one <= other { (ends.0, ends.1, wrong) } else { (ends.1, ends.0, wrong) }
        };
        match places {
            [only] => vec![between(*only, *only)],
            _ => places.windows(2).map(|ends| between(ends[0], ends[1])).collect(),
        }
    }

    /// How the value jumps at each node.
    fn jumps(&self) -> Vec<f64> {
        let lefts = self.cells.iter().map(|cell| cell.0).chain([self.outside[1].0]);
        let rights = [self.outside[0].0].into_iter().chain(self.cells.iter().map(|cell| cell.1));
        lefts.zip(rights).map(|(left, right)| left - right).collect()
    }

    /// How much its slope changes at each node.
    fn bends(&self) -> Vec<f64> {
        let slope = |(cell, ends): (&(f64, f64), &[f64])| (cell.1 - cell.0) / (ends[1] - ends[0]);
        changes(&framed(self.cells.iter().zip(self.nodes.windows(2)).map(slope), [0.0; 2]))
    }

    /// What is expected of it at the places of the kernel once this noise is added.
    pub fn expected(&self, kernel: &Kernel, noise: &Noise) -> Expected {
        let means = framed(self.cells.iter().map(|(left, right)| (left + right) / 2.0), self.outside.map(|one| one.0));
        let errors = framed(self.errors.iter().copied(), self.outside.map(|one| one.1));
        let widest = self.cells.iter().zip(self.nodes.windows(2));
        let widest = widest.map(|(cell, ends)| (cell.1 - cell.0).abs() * (ends[1] - ends[0])).fold(0.0, f64::max);
        let (bends, wrong) = (self.bends(), changes(&errors));
        let jumps: Vec<(f64, f64)> =
            self.nodes.iter().copied().zip(self.jumps()).filter(|(_, jump)| *jump != 0.0).collect();
        // Sums of so many terms, each of two numbers of the kernel that err.
        let rounded = errors.len() as f64 * (2.0 * kernel.rounding + 2.0 * f64::EPSILON);
        let flat = widest / 8.0 * noise.variation() + rounded;
        let values = kernel.gains.iter().map(|band| dot(band, &means)).collect();
        let own: Vec<f64> = kernel.gains.iter().map(|band| dot(band, &errors)).collect();
        let steepest = bends.iter().fold(0.0, |most: f64, bend| most.max(*bend));
        let between = kernel.falls.iter().enumerate().map(|(place, falls)| {
            let (low, high) = (kernel.places[place], kernel.places[place + 1]);
            let kinks: f64 = jumps.iter().map(|(node, jump)| jump.abs() * noise.varies(node - high, node - low)).sum();
            let slopes = dot(falls, &bends) + kinks + rounded * (1.0 + steepest + jumps.len() as f64 * noise.peak());
            own[place].min(own[place + 1]) + dot(falls, &wrong) + slopes * (high - low) / 4.0 + 2.0 * flat
        });
        let between = between.collect();
        Expected { values, errors: own.iter().map(|own| own + flat).collect(), between }
    }
}

/// What neighbouring numbers differ by.
fn changes(numbers: &[f64]) -> Vec<f64> {
    numbers.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect()
}

#[cfg(test)]
mod tests {
    use super::super::noise::Part;
    use super::*;

    /// Numbers from 0 to 1 that are the same in every run.
    fn numbers() -> impl FnMut() -> f64 {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    fn some(next: &mut impl FnMut() -> f64) -> Broken {
        let mut nodes: Vec<f64> = (0..12).map(|_| 6.0 * next() - 3.0).collect();
        nodes.sort_by(f64::total_cmp);
        let cells = (1..nodes.len()).map(|_| (next(), next())).collect();
        let errors = vec![0.0; nodes.len() - 1];
        Broken { nodes, cells, errors, outside: [(next(), 0.0), (next(), 0.0)] }
    }

    fn value(of: &Broken, place: f64) -> f64 {
        match of.nodes.partition_point(|node| *node <= place) {
            0 => of.outside[0].0,
            cell if cell == of.nodes.len() => of.outside[1].0,
            cell => {
                let ((left, right), ends) = (of.cells[cell - 1], &of.nodes[cell - 1..=cell]);
                left + (right - left) * (place - ends[0]) / (ends[1] - ends[0])
            }
        }
    }

    fn kinds(next: &mut impl FnMut() -> f64) -> [Noise; 4] {
        let exponential = Part::Exponential { rate: 0.5 + next(), start: next(), rising: next() > 0.5 };
        let (uniform, normal) = (Part::Uniform(-next(), next()), Part::Normal(next(), 0.1 + next()));
        [
            Noise { parts: vec![(1.0, uniform.clone())] },
            Noise { parts: vec![(1.0, exponential.clone())] },
            Noise { parts: vec![(1.0, normal.clone())] },
            Noise { parts: vec![(0.25, uniform), (0.25, exponential), (0.5, normal)] },
        ]
    }

    /// Summed over so many equal steps of the noise, far finer than the cells.
    fn summed(of: &Broken, noise: &Noise, place: f64) -> f64 {
        let (low, high) = noise.reach();
        let steps = 40_000;
        let step = (high - low) / f64::from(steps);
        let mut before = noise.below(low);
        let mut sum = before * value(of, place + low);
        for number in 0..steps {
            let here = low + step * f64::from(number);
            let now = noise.below(here + step);
            sum += (now - before) * value(of, place + here + step / 2.0);
            before = now;
        }
        sum
    }

    #[test]
    fn what_is_expected_errs_by_no_more_than_is_said() {
        let mut next = numbers();
        for _ in 0..12 {
            let function = some(&mut next);
            for noise in kinds(&mut next) {
                let places: Vec<f64> = (0..9).map(|place| 0.7 * f64::from(place) - 3.0).collect();
                let found = function.expected(&Kernel::new(&function.nodes, places.clone(), &noise), &noise);
                for (place, (value, error)) in places.iter().zip(found.values.iter().zip(&found.errors)) {
                    let exact = summed(&function, &noise, *place);
                    assert!((value - exact).abs() <= error + 1e-3, "{noise:?} at {place}: {value} {exact} {error}");
                }
                for (cell, ends) in places.windows(2).enumerate() {
                    for share in [0.2, 0.5, 0.9] {
                        let exact = summed(&function, &noise, ends[0] + share * (ends[1] - ends[0]));
                        let line = found.values[cell] + share * (found.values[cell + 1] - found.values[cell]);
                        let wrong = (line - exact).abs();
                        assert!(wrong <= found.between[cell] + 1e-3, "{noise:?}: {line} {exact} {wrong}");
                    }
                }
            }
        }
    }

    #[test]
    fn without_noise_it_is_what_it_was() {
        let mut next = numbers();
        for _ in 0..200 {
            let function = some(&mut next);
            let mut places = [7.0 * next() - 3.5, 7.0 * next() - 3.5];
            if next() > 0.5 {
                places.swap(0, 1);
            }
            let [(left, right, error)] = function.pushed(&places)[..] else { panic!("one cell") };
            for share in [0.01, 0.3, 0.5, 0.99] {
                let place = places[0] + share * (places[1] - places[0]);
                let wrong = (left + share * (right - left) - value(&function, place)).abs();
                assert!(wrong <= error + 1e-12, "{wrong} {error}");
            }
        }
    }

    /// A bound that did not get smaller with the cells would be of no use.
    #[test]
    fn finer_cells_err_by_less() {
        let bound = |cells: u32| {
            let nodes: Vec<f64> = (0..=cells).map(|place| 4.0 * f64::from(place) / f64::from(cells) - 2.0).collect();
            let bell = |node: &f64| 1.0 / (1.0 + node * node);
            let cells = nodes.windows(2).map(|ends| (bell(&ends[0]), bell(&ends[1]))).collect();
            let errors = vec![0.0; nodes.len() - 1];
            let function = Broken { nodes: nodes.clone(), cells, errors, outside: [(0.2, 0.0); 2] };
            let noise = Noise { parts: vec![(1.0, Part::Uniform(-0.5, 0.5))] };
            let found = function.expected(&Kernel::new(&nodes, nodes.clone(), &noise), &noise);
            found.between.iter().copied().fold(0.0, f64::max)
        };
        assert!(bound(400) < bound(100) / 12.0, "{} {}", bound(400), bound(100));
    }
}
