//! Panels of Gauss points, the kernel on them, and the bound on what one round errs by.

use super::enclosed::{Fast, Guard};
use super::normal::{DENSITY_ERROR, DISTRIBUTION_ERROR, density};

/// Gauss points of a panel.
const POINTS: usize = 24;
/// Panels of the whole window.
const MOST_PANELS: usize = 6_000;
/// Entries of the kernel.
const MOST_ENTRIES: usize = 30_000_000;
/// Standard deviations beyond which states are left out.
const WINDOW: f64 = 8.0;
/// Standard deviations beyond which the kernel is left out, and more than the chance beyond.
const BAND: f64 = 9.0;
const BEYOND: f64 = 2.4e-19;
/// A unit in the last place.
const UNIT: f64 = f64::EPSILON;

/// Panels with their points and weights.
pub(super) struct Grid {
    panels: Vec<(f64, f64)>,
    pub(super) nodes: Vec<f64>,
    weights: Vec<f64>,
}

/// The kernel from one state.
pub(super) struct Row {
    first: usize,
    factors: Vec<f64>,
    success: f64,
    last: f64,
}

impl Row {
    pub(super) fn kernel(&self, values: &[f64]) -> f64 {
        let values = values.get(self.first..).unwrap_or_default();
        self.factors.iter().zip(values).map(|(factor, value)| factor * value).sum()
    }

    pub(super) fn value(&self, values: &[f64], last: bool) -> f64 {
        self.kernel(values) + if last { self.last } else { self.success }
    }
}

impl Grid {
    /// The states of the rounds: a window that they leave with a chance of less than 1.3e-15 a round.
    pub(super) fn new(start: &[Fast], round: &[Fast], rounds: u64) -> Result<Grid, String> {
        Grid::within(window(start, round, rounds)?, round)
    }

    /// The states to which one way leads from 0.
    pub(super) fn of_start(way: &Fast) -> Result<Grid, String> {
        let reach = (BAND + 1e-6) * way.sd;
        Grid::within((way.shift - reach, way.shift + reach), std::slice::from_ref(way))
    }

    /// Panels that are narrow for these ways, cut where their guards cut.
    fn within((low, high): (f64, f64), ways: &[Fast]) -> Result<Grid, String> {
        let ways: Vec<&Fast> = ways.iter().filter(|way| !way.onward.is_empty()).collect();
        let width = 4.5 * ways.iter().map(|way| way.sd).fold(f64::INFINITY, f64::min);
        let mut cuts = vec![low, high];
        for way in ways.iter().filter(|way| matches!(way.guard, Guard::Next)) {
            cuts.extend(way.onward.iter().flat_map(|(from, to)| [*from, *to]).filter(|cut| *cut > low && *cut < high));
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup();
        let mut panels = Vec::new();
        for pair in cuts.windows(2) {
            let [from, to] = pair else { continue };
            let count = ((to - from) / width).ceil().max(1.0);
            if count.is_nan() || count + panels.len() as f64 > MOST_PANELS as f64 {
                return Err(format!("the states reach too far for their noise: more than {MOST_PANELS} panels"));
            }
            let place = |number: f64| from + (to - from) * (number / count);
            panels.extend((0..count as usize).map(|number| (place(number as f64), place(number as f64 + 1.0))));
        }
        let rule = gauss();
        let (mut nodes, mut weights) = (Vec::new(), Vec::new());
        for (from, to) in &panels {
            let (middle, half) = (f64::midpoint(*from, *to), (to - from) / 2.0);
            for (place, weight) in rule {
                nodes.push(middle + half * place);
                weights.push(half * weight);
            }
        }
        Ok(Grid { panels, nodes, weights })
    }

    pub(super) fn rows(&self, round: &[Fast]) -> Result<Vec<Row>, String> {
        let mut rows = Vec::with_capacity(self.nodes.len());
        let mut entries = 0usize;
        for node in &self.nodes {
            let row = self.row(*node, round)?;
            entries += row.factors.len();
            if entries > MOST_ENTRIES {
                return Err("the kernel is too large".to_string());
            }
            rows.push(row);
        }
        Ok(rows)
    }

    /// The kernel from one state: whole panels, as far as it reaches.
    pub(super) fn row(&self, from: f64, round: &[Fast]) -> Result<Row, String> {
        let onward = || round.iter().filter(|way| !way.onward.is_empty());
        let reach = |way: &Fast| {
            let mean = way.slope * from + way.shift;
            (mean - BAND * way.sd, mean + BAND * way.sd)
        };
        let low = onward().map(|way| reach(way).0).fold(f64::INFINITY, f64::min);
        let high = onward().map(|way| reach(way).1).fold(f64::NEG_INFINITY, f64::max);
        let first = self.panels.partition_point(|(_, to)| *to < low);
        let end = self.panels.partition_point(|(from, _)| *from <= high).max(first);
        let places = first * POINTS..end * POINTS;
        let mut factors = vec![0.0; places.len()];
        for way in onward() {
            let mean = way.slope * from + way.shift;
            let nodes = self.nodes[places.clone()].iter().zip(&self.weights[places.clone()]);
            for (factor, (to, weight)) in factors.iter_mut().zip(nodes) {
                let near = density((to - mean) / way.sd) / way.sd;
                *factor += way.weight * weight * near * way.goes_on(from, *to);
            }
        }
        let success = |last: bool| round.iter().map(|way| way.succeeds(from, last)).sum();
        Ok(Row { first: first * POINTS, factors, success: success(false), last: success(true) })
    }

    /// What the sum over this grid errs by at most, everything included, for the kernel of these ways and the values
    /// that the rounds make.
    pub(super) fn error(&self, ways: &[Fast], round: &[Fast]) -> f64 {
        let ways: Vec<&Fast> = ways.iter().filter(|way| !way.onward.is_empty()).collect();
        let least = ways.iter().map(|way| way.sd).fold(f64::INFINITY, f64::min);
        let most = ways.iter().map(|way| way.sd).fold(0.0, f64::max);
        let half = self.panels.iter().map(|(from, to)| (to - from) / 2.0).fold(0.0, f64::max);
        // Panels that one row may reach; where cuts make them narrow, all of them.
        let panels = self.panels.len() as f64;
        let size = |height: f64| size(&ways, round, height);
        let rho = (2..=14).map(f64::from).map(|rho| {
            let height = half * (rho - 1.0 / rho) / 2.0;
            64.0 / 15.0 * half * size(height) * rho.powi(2 - 2 * POINTS as i32) / (1.0 - rho.powi(-2))
        });
        let quadrature = 1.001 * panels * rho.fold(f64::INFINITY, f64::min);
        let reach = self
            .panels
            .first()
            .map_or(0.0, |panel| panel.0.abs())
            .max(self.panels.last().map_or(0.0, |panel| panel.1.abs()));
        // The points are rounded; by Cauchy's inequality the slope of what is summed is at most its size at a distance
        // over that distance.
        let band = 2.0 * BAND * most + 4.0 * half;
        let points = band * size(least) / least * 4.0 * UNIT * (reach + half);
        // The parts of the kernel have a mass of at most 1 together, but each guard's chance errs by itself.
        let rounding = ways.iter().map(|way| rounding(way, reach)).fold(0.0, f64::max)
            + ways.iter().map(|way| way.weight * deciding(way, reach, false)).sum::<f64>();
        let terms = (band / half + 4.0).min(2.0 * panels) * POINTS as f64;
        let decided = round.iter().map(|way| deciding(way, reach, true)).sum::<f64>();
        quadrature + points + rounding + decided + (terms + 50.0) * UNIT + BEYOND
    }
}

/// A bound on |k(s,z) V(z)| at a distance from the reals.
fn size(ways: &[&Fast], round: &[Fast], height: f64) -> f64 {
    let square = height * height / 2.0;
    let kernel = |way: &Fast| {
        let guard = match &way.guard {
            Guard::Noisy { follows, rest, .. } => (follows / rest).powi(2),
            _ => 0.0,
        };
        way.weight * 0.4 / way.sd * (square * (1.0 / way.sd.powi(2) + guard)).exp()
    };
    // The mean of the next state, and of the decider, moves with the state: the absolute integral over both.
    let value = |way: &Fast| {
        let moved = match &way.guard {
            Guard::Noisy { factor, follows, rest, .. } if way.sd > 0.0 && !way.onward.is_empty() => {
                (way.slope / way.sd).powi(2) + ((factor - follows * way.slope) / rest).powi(2)
            }
            Guard::Noisy { factor, sd, .. } => (factor / sd).powi(2),
            _ if way.sd > 0.0 => (way.slope / way.sd).powi(2),
            _ => 0.0,
        };
        way.weight * (square * moved).exp()
    };
    ways.iter().map(|way| kernel(way)).sum::<f64>() * round.iter().map(value).sum::<f64>().max(1.0)
}

/// A bound on the relative error of a density.
fn rounding(way: &Fast, reach: f64) -> f64 {
    // The mean of the next state errs by a few units of the largest number in it; the exponent is at most 14 times that.
    let mean = 4.0 * UNIT * (way.slope.abs() * reach + way.shift.abs() + reach);
    16.0 * mean / way.sd + 4.0 * DENSITY_ERROR
}

/// A bound on the error of a decider's chance.
fn deciding(way: &Fast, reach: f64, alone: bool) -> f64 {
    let ranges = way.onward.len().max(way.success.len()).max(way.last.len()) as f64;
    let bounds = way.onward.iter().chain(&way.success).chain(&way.last).flat_map(|(low, high)| [low.abs(), high.abs()]);
    let bound = bounds.filter(|bound| bound.is_finite()).fold(0.0, f64::max);
    let (argument, sd) = match &way.guard {
        Guard::Nothing => return 0.0,
        Guard::Next if alone => (way.slope.abs() * reach + way.shift.abs() + bound, way.sd),
        Guard::Next => return 0.0,
        Guard::Noisy { factor, offset, sd, .. } if alone => (factor.abs() * reach + offset.abs() + bound, *sd),
        Guard::Noisy { factor, offset, follows, rest, .. } => {
            let next = reach + way.slope.abs() * reach + way.shift.abs();
            (factor.abs() * reach + offset.abs() + follows.abs() * next + bound, *rest)
        }
    };
    2.0 * ranges * (4.0 * UNIT * argument / sd + 2.0 * DISTRIBUTION_ERROR)
}

/// Where the states are, but for a chance of 1.3e-15 a round.
fn window(start: &[Fast], round: &[Fast], rounds: u64) -> Result<(f64, f64), String> {
    let onward = |ways: &[Fast]| ways.iter().filter(|way| !way.onward.is_empty()).cloned().collect::<Vec<Fast>>();
    let (start, round) = (onward(start), onward(round));
    let around = |mean: f64, sd: f64| (mean - (WINDOW + 1e-6) * sd, mean + (WINDOW + 1e-6) * sd);
    let hull = |one: (f64, f64), other: (f64, f64)| (one.0.min(other.0), one.1.max(other.1));
    let mut whole = (f64::INFINITY, f64::NEG_INFINITY);
    let alike = |way: &Fast| (way.slope, way.shift, way.sd) == (round[0].slope, round[0].shift, round[0].sd);
    if !round.is_empty() && round.iter().all(alike) {
        // One linear map: the state of each round is normal, were nothing cut off.
        for way in &start {
            let (mut mean, mut variance) = (way.shift, way.sd * way.sd);
            for _ in 0..=rounds {
                let now = hull(whole, around(mean, variance.sqrt()));
                let (next, wider) =
                    (round[0].slope * mean + round[0].shift, round[0].slope.powi(2) * variance + round[0].sd.powi(2));
                let still = now == whole && (next - mean).abs() < 1e-12 && (wider - variance).abs() < 1e-12 * wider;
                (whole, mean, variance) = (now, next, wider);
                if still {
                    break;
                }
            }
        }
    } else {
        for way in &start {
            whole = hull(whole, around(way.shift, way.sd));
        }
        for _ in 0..rounds {
            let mut now = whole;
            for way in &round {
                for end in [whole.0, whole.1] {
                    now = hull(now, around(way.slope * end + way.shift, way.sd));
                }
            }
            let still = now == whole;
            whole = now;
            if still || !whole.0.is_finite() || !whole.1.is_finite() {
                break;
            }
        }
    }
    let pad = 1e-9 * (1.0 + whole.0.abs() + whole.1.abs());
    if whole.0.is_finite() && whole.1.is_finite() && whole.0 <= whole.1 {
        Ok((whole.0 - pad, whole.1 + pad))
    } else {
        Err("the states have no bound".to_string())
    }
}

/// Points and weights of Gauss's rule on [-1,1]: the roots of Legendre's polynomial by Newton's method.
fn gauss() -> [(f64, f64); POINTS] {
    let count = POINTS as f64;
    let mut rule = [(0.0, 0.0); POINTS];
    for (number, entry) in rule.iter_mut().enumerate() {
        let mut place = (std::f64::consts::PI * (number as f64 + 0.75) / (count + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..60 {
            let (mut before, mut now) = (1.0, place);
            for degree in 2..=POINTS {
                let degree = degree as f64;
                (before, now) = (now, ((2.0 * degree - 1.0) * place * now - (degree - 1.0) * before) / degree);
            }
            slope = count * (place * now - before) / (place * place - 1.0);
            place -= now / slope;
        }
        *entry = (place, 2.0 / ((1.0 - place * place) * slope * slope));
    }
    rule.sort_by(|one, other| one.0.total_cmp(&other.0));
    rule
}
