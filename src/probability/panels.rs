//! Panels of Gauss points on which a function is known, and rows of weights by which its integral against a density over
//! ranges of any ends becomes a sum.
//!
//! Where a range ends inside a panel, the points of the piece get the polynomial through the points of the panel. By
//! Trefethen (2013), theorem 8.2, the best polynomial of degree n is at most `2M/(ρ^n (ρ-1))` away, where M bounds the
//! function on the ellipse of ρ; the one through the points is at most `1 + L` times as far away, with Lebesgue's constant
//! `L <= POINTS`: by Cauchy's inequality the sum of |l_j| is at most `sqrt(2 * sum of l_j²/w_j)`, which is the root of
//! twice the sum of `(2k+1)/2 P_k²`.

use super::grid::{POINTS, gauss};
use super::kernel::{Ranges, UNIT};

/// Points of all panels.
const MOST_POINTS: f64 = 6_000.0;

/// Panels that lie side by side; none for a coordinate that does not matter.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    edges: Vec<f64>,
    /// The points, in their order.
    pub nodes: Vec<f64>,
    weights: Vec<f64>,
    rule: [(f64, f64); POINTS],
}

#[derive(Clone, Copy)]
/// A point of an integral with its weight, in a panel; `at` a point of the panel itself, if it is one.
pub(super) struct Sample {
    pub place: f64,
    pub weight: f64,
    panel: usize,
    at: Option<usize>,
}

/// Weights from a place on.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    pub first: usize,
    pub values: Vec<f64>,
}

impl Panels {
    /// For a coordinate that does not matter, or that is known.
    pub(super) fn point(place: f64) -> Panels {
        Panels { edges: Vec::new(), nodes: vec![place], weights: vec![1.0], rule: [(0.0, 0.0); POINTS] }
    }

    /// Over a window, with cuts at these places, at most so wide.
    ///
    /// # Errors
    /// Where there are too many.
    pub(super) fn new((low, high): (f64, f64), cuts: &[f64], width: f64) -> Result<Panels, String> {
        let mut ends = vec![low, high];
        ends.extend(cuts.iter().filter(|cut| **cut > low && **cut < high));
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut edges = Vec::new();
        for pair in ends.windows(2) {
            let [from, to] = pair else { continue };
            let count = ((to - from) / width).ceil().max(1.0);
            if count.is_nan() || (count + edges.len() as f64) * POINTS as f64 > MOST_POINTS {
                return Err(format!("the states reach too far for their noise: more than {MOST_POINTS} points"));
            }
            edges.extend((0..count as usize).map(|number| from + (to - from) * (number as f64 / count)));
        }
        edges.push(high);
        let rule = gauss();
        let (mut nodes, mut weights) = (Vec::new(), Vec::new());
        for pair in edges.windows(2) {
            let (middle, half) = (f64::midpoint(pair[0], pair[1]), (pair[1] - pair[0]) / 2.0);
            nodes.extend(rule.iter().map(|(place, _)| middle + half * place));
            weights.extend(rule.iter().map(|(_, weight)| half * weight));
        }
        Ok(Panels { edges, nodes, weights, rule })
    }

    /// How many panels there are at most over a length.
    pub(super) fn count(&self, length: f64) -> f64 {
        let least = self.edges.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        ((length / least).ceil() + 2.0).min(self.edges.len() as f64)
    }

    /// Half of the widest panel.
    pub(super) fn half(&self) -> f64 {
        self.edges.windows(2).map(|pair| (pair[1] - pair[0]) / 2.0).fold(0.0, f64::max)
    }

    /// The whole window.
    pub(super) fn window(&self) -> Option<(f64, f64)> {
        Some((*self.edges.first()?, *self.edges.last()?))
    }

    /// The points of the panels that touch a range.
    pub(super) fn active(&self, (low, high): (f64, f64)) -> (usize, usize) {
        if self.edges.is_empty() {
            return (0, 1);
        }
        let (first, last) = self.touched((low, high));
        (first * POINTS, last * POINTS)
    }

    /// The ends of the panels that touch a range.
    pub(super) fn touching(&self, range: (f64, f64)) -> (f64, f64) {
        let (first, last) = if self.edges.is_empty() { return range } else { self.touched(range) };
        (self.edges[first], self.edges[last])
    }

    fn touched(&self, (low, high): (f64, f64)) -> (usize, usize) {
        let panels = self.edges.len() - 1;
        let first = self.edges.partition_point(|edge| *edge <= low).saturating_sub(1);
        let last = self.edges.partition_point(|edge| *edge < high).min(panels);
        (first.min(last), last)
    }

    /// The points of an integral over these ranges, as far as their panels touch the band.
    pub(super) fn samples(&self, ranges: &Ranges, band: (f64, f64)) -> Vec<Sample> {
        let mut samples = Vec::new();
        if self.edges.is_empty() {
            return self
                .nodes
                .iter()
                .map(|place| Sample { place: *place, weight: 1.0, panel: 0, at: Some(0) })
                .collect();
        }
        let (first, last) = self.touched(band);
        for (low, high) in ranges {
            for panel in first..last {
                let (start, end) = (self.edges[panel], self.edges[panel + 1]);
                let (from, to) = (start.max(*low), end.min(*high));
                if from >= to {
                    continue;
                }
                let whole = from == start && to == end;
                let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0);
                for (number, (place, weight)) in self.rule.iter().enumerate() {
                    let at = panel * POINTS + number;
                    samples.push(match whole {
                        true => Sample { place: self.nodes[at], weight: self.weights[at], panel, at: Some(at) },
                        false => Sample { place: middle + half * place, weight: half * weight, panel, at: None },
                    });
                }
            }
        }
        samples
    }

    /// Weights of the points of the panels that make the sum of these values of a function.
    pub(super) fn row(&self, samples: &[(Sample, f64)]) -> Row {
        let panels = samples.iter().map(|(sample, _)| sample.panel);
        let (Some(first), Some(last)) = (panels.clone().min(), panels.max()) else { return Row::default() };
        let mut row = Row { first: first * POINTS, values: vec![0.0; (last + 1 - first) * POINTS] };
        for (sample, value) in samples {
            match sample.at {
                Some(at) => row.values[at - row.first] += value,
                None => {
                    let start = (sample.panel - first) * POINTS;
                    let polynomials = self.polynomials(sample);
                    row.values[start..start + POINTS]
                        .iter_mut()
                        .zip(polynomials)
                        .for_each(|(sum, l)| *sum += value * l);
                }
            }
        }
        row
    }

    /// The polynomials that are 1 at one point of a panel and 0 at the others, at a place.
    fn polynomials(&self, sample: &Sample) -> [f64; POINTS] {
        let (start, end) = (self.edges[sample.panel], self.edges[sample.panel + 1]);
        let place = (sample.place - f64::midpoint(start, end)) / ((end - start) / 2.0);
        let mut factors = [0.0; POINTS];
        for (number, (node, weight)) in self.rule.iter().enumerate() {
            let gap = place - node;
            if gap.abs() < 4.0 * UNIT {
                factors = [0.0; POINTS];
                factors[number] = 1.0;
                return factors;
            }
            // The barycentric weights of Legendre's points.
            let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
            factors[number] = sign * ((1.0 - node * node) * weight).sqrt() / gap;
        }
        let sum: f64 = factors.iter().sum();
        factors.iter_mut().for_each(|factor| *factor /= sum);
        factors
    }
}

impl Row {
    /// As far as it lies in a range of points: the values, and the place of the first of them.
    pub(super) fn within(&self, (low, high): (usize, usize)) -> (&[f64], usize) {
        let from = self.first.max(low);
        let to = (self.first + self.values.len()).min(high);
        if from >= to { (&[], low) } else { (&self.values[from - self.first..to - self.first], from) }
    }

    /// Adds another.
    pub(super) fn add(&mut self, other: Row) {
        if self.values.is_empty() || other.values.is_empty() {
            if self.values.is_empty() {
                *self = other;
            }
            return;
        }
        let first = self.first.min(other.first);
        let last = (self.first + self.values.len()).max(other.first + other.values.len());
        let mut values = vec![0.0; last - first];
        for row in [&*self, &other] {
            let places = &mut values[row.first - first..];
            places.iter_mut().zip(&row.values).for_each(|(sum, value)| *sum += value);
        }
        *self = Row { first, values };
    }
}

fn ellipses() -> impl Iterator<Item = f64> {
    (3..=60).map(|number| 1.0 + f64::from(number) / 4.0)
}

fn height(half: f64, rho: f64) -> f64 {
    half * (rho - rho.recip()) / 2.0
}

/// What Gauss's rule errs by on a panel for a function that is at most `e^(growth * b²/2)` at a distance b from the reals
/// (Trefethen, 2008, theorem 4.5).
pub(super) fn quadrature(growth: f64, half: f64) -> f64 {
    let points = POINTS as i32;
    let error = |rho: f64| {
        let size = (growth * height(half, rho).powi(2) / 2.0).exp();
        64.0 / 15.0 * half * size * rho.powi(2 - 2 * points) / (1.0 - rho.powi(-2))
    };
    1.001 * ellipses().map(error).fold(f64::INFINITY, f64::min)
}

/// What the polynomial through the points of a panel errs by.
pub(super) fn interpolation(growth: f64, half: f64) -> f64 {
    let points = POINTS as i32;
    let error = |rho: f64| {
        let size = (growth * height(half, rho).powi(2) / 2.0).exp();
        2.0 * size * rho.powi(1 - points) / (rho - 1.0)
    };
    1.001 * (1.0 + POINTS as f64) * ellipses().map(error).fold(f64::INFINITY, f64::min)
}
