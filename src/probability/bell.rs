//! Rows of weighted densities over the points of a grid.
//!
//! Over equal steps τ, in standard deviations, a bell is `e^(-(z+kτ)²/2) = e^(-z²/2) (e^(-zτ))^k e^(-k²τ²/2)`: the last factor
//! is the same for all rows, and the powers in the middle are products. From the point nearest to the middle on `|zτ| <= τ²/2`,
//! so that the base of the powers is near 1 and known to 4 units; they begin anew after [`TURNS`] products, so that none
//! errs by more than 5 units for each. The last factor errs by 4 units for each of at most 41 by which its power is. With the
//! others a value errs by less than 600 units of the last place, a share of 1.4e-13, besides what an error of its place makes:
//! [`Fast::rounding`] allows for more.

use super::grid::Grid;
use super::kernel::{AxisRanges, Fast, Guard, Ranges, at, contains, everything};
use super::normal::{density, distribution, exponential};

/// Products in a row.
const TURNS: usize = 64;
/// Standard deviations beyond which a chance is 0 or 1 in machine numbers.
const SETTLED: f64 = 9.0;

/// What the rows of one motion over a grid share.
pub(super) struct Bell {
    /// Standard deviations beyond which there is nothing.
    band: f64,
    /// The step in standard deviations, where all are equal.
    step: Option<f64>,
    /// `e^(-k²τ²/2)`
    fall: Vec<f64>,
    /// The present row.
    values: Vec<f64>,
}

impl Bell {
    pub(super) fn new(motion: &Fast, to: &Grid, band: f64) -> Bell {
        let step = to.step.map(|step| step / motion.sd).filter(|step| step.is_finite() && *step > 0.0);
        let count = step.map_or(0.0, |step| (2.0 * band / step).min(to.nodes.len() as f64) + 2.0) as usize;
        let place = |number: usize| number as f64 * step.unwrap_or_default();
        let fall = (0..count).map(|number| exponential(-0.5 * place(number) * place(number))).collect();
        Bell { band, step, fall, values: Vec::new() }
    }

    /// The densities from a state to the points of a grid, weighted; the place of the first of them.
    pub(super) fn row(&mut self, motion: &Fast, ranges: &AxisRanges, state: f64, to: &Grid) -> (usize, &[f64]) {
        let (mean, side) = (motion.mean(state), self.band * motion.sd);
        let first = to.nodes.partition_point(|node| *node < mean - side);
        let count = to.nodes[first..].partition_point(|node| *node <= mean + side);
        let (nodes, weights) = (&to.nodes[first..first + count], &to.weights[first..first + count]);
        let factor = motion.passes(ranges, state) / motion.sd;
        self.values.clear();
        if !self.equal(motion, mean, nodes, factor * to.step.unwrap_or_default()) {
            let value = |(node, weight): (&f64, &f64)| weight * factor * density((node - mean) / motion.sd);
            self.values.extend(nodes.iter().zip(weights).map(value));
        }
        guarded(motion, ranges, state, nodes, &mut self.values);
        (first, &self.values)
    }

    /// Over equal steps, if there are some and the middle lies between them.
    fn equal(&mut self, motion: &Fast, mean: f64, nodes: &[f64], factor: f64) -> bool {
        let Some(step) = self.step else { return false };
        let middle = nodes.partition_point(|node| *node < mean);
        let Some(node) = nodes.get(middle) else { return false };
        let middle = if middle > 0 && mean - nodes[middle - 1] < node - mean { middle - 1 } else { middle };
        let gap = (nodes[middle] - mean) / motion.sd;
        if gap.abs() > 0.51 * step || nodes.len() > self.fall.len() {
            return false;
        }
        let top = factor * density(gap);
        self.values.resize(nodes.len(), 0.0);
        let (before, after) = self.values.split_at_mut(middle);
        side(top, -gap * step, after.iter_mut().zip(&self.fall), 0);
        side(top, gap * step, before.iter_mut().rev().zip(&self.fall[1..]), 1);
        true
    }
}

/// From the middle on to one side: the products, from this one on, with what falls.
fn side<'a>(top: f64, power: f64, values: impl Iterator<Item = (&'a mut f64, &'a f64)>, first: usize) {
    let base = exponential(power);
    let mut product = if first == 0 { top } else { top * base };
    for (number, (value, fall)) in (first..).zip(values) {
        *value = product * fall;
        product *= base;
        if (number + 1) % TURNS == 0 {
            product = top * exponential((number + 1) as f64 * power);
        }
    }
}

/// Multiplies with the chance that what decides lies in these, once the next state is known.
fn guarded(motion: &Fast, all: &AxisRanges, state: f64, nodes: &[f64], values: &mut [f64]) {
    let ranges: &Ranges = &all[1];
    match &motion.guard {
        _ if everything(ranges) && all.points.is_empty() => {}
        Guard::Nothing => {}
        Guard::Next => {
            let outside = nodes.iter().zip(values).filter(|(node, _)| !contains(ranges, **node));
            outside.for_each(|(_, value)| *value = 0.0);
        }
        Guard::Noisy { factor, offset, follows, rest, .. } => {
            let Some((low, high)) = nodes.first().zip(nodes.last()) else { return };
            let (alone, from) = (factor * state + offset, motion.mean(state));
            let mean = |node: f64| alone + follows * (node - from);
            if let Some(points) = all.at(1) {
                return nodes.iter().zip(values).for_each(|(node, value)| *value *= at(points, mean(*node), *rest));
            }
            // It is monotone in the next state: where both ends say the same, so does everything between.
            let settled = |end: f64| {
                let places = [*low, *high].map(|node| (end - mean(node)) / rest);
                let all = |test: fn(f64) -> bool| places.iter().all(|place| test(*place));
                let one = all(|place| place >= SETTLED).then_some(1.0);
                one.or(all(|place| place <= -SETTLED).then_some(0.0))
            };
            let known: Vec<(Option<f64>, Option<f64>)> =
                ranges.iter().map(|(low, high)| (settled(*low), settled(*high))).collect();
            let same: Option<f64> = known.iter().map(|(low, high)| Some((*high)? - (*low)?)).sum();
            if let Some(same) = same {
                values.iter_mut().for_each(|value| *value *= same);
                return;
            }
            // What is settled of the ends, and what is not with its sign.
            let ends = ranges
                .iter()
                .zip(&known)
                .flat_map(|(range, known)| [(range.1, known.1, 1.0), (range.0, known.0, -1.0)]);
            let settled: f64 = ends.clone().filter_map(|(_, known, sign)| Some(sign * known?)).sum();
            let open: Vec<(f64, f64)> = ends.filter(|end| end.1.is_none()).map(|(end, _, sign)| (end, sign)).collect();
            for (node, value) in nodes.iter().zip(values) {
                let mean = mean(*node);
                let part = |(end, sign): &(f64, f64)| sign * distribution((end - mean) / rest);
                *value *= (settled + open.iter().map(part).sum::<f64>()).max(0.0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::grid::Smooth;
    use super::super::normal::DENSITY_ERROR;
    use super::*;

    #[test]
    fn rows_over_equal_steps_are_the_densities_themselves() {
        let sets = std::array::from_fn(|_| vec![(f64::NEG_INFINITY, f64::INFINITY)]);
        let everywhere = AxisRanges { sets, points: Vec::new() };
        let mut met = 0;
        for (number, sd) in [0.013, 0.1, 0.37, 2.9].into_iter().enumerate() {
            let motion = Fast { slope: 0.9, shift: 0.7, sd, guard: Guard::Nothing, gates: Vec::new() };
            let smooth = Smooth { growth: 1.3 / (sd * sd), size: 1.0, sd: (sd, sd), cuts: Vec::new() };
            let grid = Grid::new((-40.0 * sd, 60.0 * sd), &smooth, [1e-4, 1e-7, 1e-10, 1e-13][number]).expect("a grid");
            let mut bell = Bell::new(&motion, &grid, 8.7);
            for place in 0..400 {
                let state = (f64::from(place) * 0.37 - 60.0) * sd;
                let (first, row) = bell.row(&motion, &everywhere, state, &grid);
                let mean = motion.mean(state);
                let nodes = grid.nodes[first..].iter().zip(&grid.weights[first..]);
                for (value, (node, weight)) in row.iter().zip(nodes) {
                    let wanted = weight / sd * density((node - mean) / sd);
                    assert!(
                        (value - wanted).abs() <= 5.0 * DENSITY_ERROR * wanted,
                        "{sd} {state} {node}: {value} {wanted}"
                    );
                    met += 1;
                }
                // Nothing that lies within the band is left out.
                let within = grid.nodes.iter().filter(|node| (*node - mean).abs() <= 8.69 * sd).count();
                assert!(row.len() >= within, "{sd} {state}");
            }
        }
        assert!(met > 10_000, "{met}");
    }
}
