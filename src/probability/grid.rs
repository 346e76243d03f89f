//! Points and weights by which integrals become sums, with a bound on what a sum errs by.
//!
//! What is integrated is a kernel times a chance, analytic but for cuts. Moving the mean of a normal density by ib
//! multiplies its absolute integral by e^(b²/2σ²), which bounds the whole at a distance b from the reals by
//! `size * e^(growth * b²/2)`. Without cuts equal steps over all reals err by at most `2M/(e^(2πa/h)-1)`, where M bounds the
//! absolute integral up to the distance a (Trefethen and Weideman, 2014, theorem 5.1); with cuts, Gauss's rule on
//! panels between them by `64/15 M ρ^(-2n)/(1-ρ^(-2))` for n+1 points, where M bounds the size on the ellipse of ρ
//! (Trefethen, 2008, theorem 4.5).

use std::sync::OnceLock;

use super::kernel::{BAND, UNIT};

/// Gauss points of a panel.
pub const POINTS: usize = 24;
/// Points of a grid.
const MOST_POINTS: f64 = 40_000.0;

/// Points with their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// The points, in their order.
    pub nodes: Vec<f64>,
    /// Their weights.
    pub weights: Vec<f64>,
    /// How far they are from each other, where that is the same everywhere.
    pub step: Option<f64>,
    /// A bound on what a sum over all points of the reals, or over all panels, errs by.
    pub error: f64,
}

/// What is known of the integrals over a grid.
#[derive(Clone, Debug)]
pub struct Smooth {
    /// How fast what is integrated grows away from the reals.
    pub growth: f64,
    /// Its factor.
    pub size: f64,
    /// The least standard deviation of a kernel, and the greatest.
    pub sd: (f64, f64),
    /// Where it is cut.
    pub cuts: Vec<f64>,
}

impl Grid {
    /// For a state that does not matter.
    pub fn single() -> Grid {
        Grid { nodes: vec![0.0], weights: vec![1.0], step: None, error: 0.0 }
    }

    /// Over a window, so that a sum errs by about as much as is wanted at most.
    ///
    /// # Errors
    /// Where that takes too many points.
    pub fn new(window: (f64, f64), smooth: &Smooth, wanted: f64) -> Result<Grid, String> {
        let sound = smooth.growth.is_finite() && smooth.growth > 0.0 && smooth.sd.0 > 0.0;
        if !sound || !window.0.is_finite() || !window.1.is_finite() {
            return Err("the noise of a round is too uneven for machine numbers".to_string());
        }
        if smooth.cuts.is_empty() { equal(window, smooth, wanted) } else { panels(window, smooth) }
    }
}

fn too_many() -> String {
    format!("the states reach too far for their noise: more than {MOST_POINTS} points")
}

/// Equal steps; they are multiples of a number of 8 digits, so that every point is exact.
fn equal((low, high): (f64, f64), smooth: &Smooth, wanted: f64) -> Result<Grid, String> {
    let square = std::f64::consts::PI.powi(2);
    let step = (2.0 * square / (smooth.growth * (4.0 * smooth.size / wanted).ln().max(2.0))).sqrt();
    let digit = 2f64.powi(step.log2().floor() as i32 - 7);
    let step = (step / digit).floor() * digit;
    let (first, last) = ((low / step).floor(), (high / step).ceil());
    if (last - first).is_nan() || last - first > MOST_POINTS || first.abs().max(last.abs()) > 1e12 {
        return Err(too_many());
    }
    let nodes: Vec<f64> = (first as i64..=last as i64).map(|number| number as f64 * step).collect();
    // The best distance is 2π/(h*growth).
    let power = 2.0 * square / (smooth.growth * step * step);
    let error = 1.01 * 2.0 * smooth.size * (-power).exp() / (1.0 - (-2.0 * power).exp());
    Ok(Grid { weights: vec![step; nodes.len()], nodes, step: Some(step), error })
}

/// Panels of Gauss points between the cuts.
///
/// # Errors
/// Where there are too many.
pub(super) fn panels((low, high): (f64, f64), smooth: &Smooth) -> Result<Grid, String> {
    let width = (4.5 * smooth.sd.0).min(6.4 / smooth.growth.sqrt());
    let mut cuts = vec![low, high];
    cuts.extend(smooth.cuts.iter().filter(|cut| **cut > low && **cut < high));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let mut panels = Vec::new();
    for pair in cuts.windows(2) {
        let [from, to] = pair else { continue };
        let count = ((to - from) / width).ceil().max(1.0);
        if count.is_nan() || (count + panels.len() as f64) * POINTS as f64 > MOST_POINTS {
            return Err(too_many());
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
    let half = panels.iter().map(|(from, to)| (to - from) / 2.0).fold(0.0, f64::max);
    let size = |height: f64| 0.4 / smooth.sd.0 * smooth.size * (smooth.growth * height * height / 2.0).exp();
    let rho = (2..=14).map(f64::from).map(|rho| {
        let height = half * (rho - 1.0 / rho) / 2.0;
        64.0 / 15.0 * half * size(height) * rho.powi(2 - 2 * POINTS as i32) / (1.0 - rho.powi(-2))
    });
    let quadrature = 1.001 * panels.len() as f64 * rho.fold(f64::INFINITY, f64::min);
    // The points are rounded; by Cauchy's inequality the slope of what is summed is at most its size at a distance
    // over that distance.
    let reach = low.abs().max(high.abs());
    let band = 2.0 * BAND * smooth.sd.1 + 4.0 * half;
    let distance = smooth.growth.sqrt().recip();
    let points = band * size(distance) / distance * 4.0 * UNIT * (reach + half);
    Ok(Grid { nodes, weights, step: None, error: quadrature + points })
}

/// A point of a rule, and its weight.
pub type Weighted = (f64, f64);

/// Points and weights of Gauss's rule on [-1,1].
pub fn gauss() -> [Weighted; POINTS] {
    static RULE: OnceLock<[Weighted; POINTS]> = OnceLock::new();
    *RULE.get_or_init(legendre)
}

/// The roots of Legendre's polynomial by Newton's method, with their weights.
fn legendre() -> [Weighted; POINTS] {
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
