//! Chances that two independent numbers lie in an ellipse, as sums over slices.
//!
//! With `y = d + r sin θ` the chance is the integral of `r cos θ f(y) (G(c + q cos θ) - G(c - q cos θ))` over half a circle, with the density f
//! of one number and the distribution G of the other. The integrand is analytic and the same on the other half of the
//! circle, so equal steps err by at most `2πM/(e^(aN)-1)`, where N is the number of steps of the whole circle and M bounds
//! the integrand up to the distance a from the reals (Trefethen and Weideman, 2014, theorem 3.2).
//! There a normal density with the standard deviation s is at most `0.4/s e^(b²/2s²)` for numbers b away from the reals, and
//! `|cos θ| <= cosh a`, so that `M <= 2 q r cosh² a (0.4/s) (0.4/t) e^(k² sinh² a / 2)` with k the greater one of q/s and r/t:
//! what is beside the reals is `q sin α sinh a` in one direction and `r cos α sinh a` in the other.

use num_rational::BigRational;
use num_traits::Signed;

use super::axes::AXES;
use super::kernel::{UNIT, near};
use super::normal::{DENSITY_ERROR, DISTRIBUTION_ERROR, density, distribution};
use super::plan::{Decider, Motion, Round};
use super::region::Set;
use crate::interval::Interval;

/// Steps of a whole circle.
const MOST_STEPS: usize = 1_200;

/// A part of an ellipse: that the first number is at most `half` away from the middle, at places of the second one, with
/// the weight of both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slice {
    pub weight: f64,
    pub half: f64,
    pub places: [f64; 2],
}

/// An ellipse in slices, and what their sum errs by.
pub(super) struct Slices {
    pub slices: Vec<Slice>,
    pub error: f64,
}

/// The slices of an ellipse with this middle and these radii, for numbers with at least so much noise.
///
/// # Errors
/// Where there would be too many.
pub(super) fn slices(middle: f64, radii: [f64; 2], sds: [f64; 2], wanted: f64) -> Result<Slices, String> {
    let [k, l] = [radii[0] / sds[0], radii[1] / sds[1]];
    if !(k > 0.0 && l > 0.0 && k.is_finite() && l.is_finite() && middle.is_finite()) {
        return Err("a distance is too large or too small for its noise".to_string());
    }
    let steps = (2..=MOST_STEPS / 4).map(|count| 4 * count);
    let found = steps.map(|steps| (steps, error(k, l, steps as f64))).find(|(_, error)| *error <= wanted);
    let (steps, error) = found.ok_or("a distance is too large for its noise")?;
    let step = 2.0 * std::f64::consts::PI / steps as f64;
    let slice = |number: usize| {
        let (sin, cos) = ((number as f64 + 0.5) * step).sin_cos();
        let places = [middle - radii[1] * sin, middle + radii[1] * sin];
        Slice { weight: step * radii[1] * cos, half: radii[0] * cos, places }
    };
    Ok(Slices { slices: (0..steps / 4).map(slice).collect(), error })
}

/// What so many steps err by at most, for radii of so many standard deviations.
fn error(k: f64, l: f64, steps: f64) -> f64 {
    let at = |distance: f64| {
        let growth = (k.max(l) * distance.sinh()).powi(2) / 2.0;
        let size = (0.32 * k * l * distance.cosh().powi(2)).ln() + growth;
        // The denominator is at least half its first part.
        (1.01 * 4.0 * std::f64::consts::PI).ln() + size - distance * steps
    };
    let distances = (0..60).map(|number| 0.02 * 1.1f64.powi(number));
    let fits = |distance: &f64| distance * steps > 1.0;
    distances.filter(fits).map(at).fold(f64::INFINITY, f64::min).exp()
}

/// The ranges of a set that a sum of squares may lie in.
pub(super) fn rings(set: &Set) -> impl Iterator<Item = (Option<&BigRational>, Option<&BigRational>)> {
    let reached = set.iter().filter(|(_, high)| high.as_ref().is_none_or(Signed::is_positive));
    reached.map(|(low, high)| (low.as_ref().filter(|low| low.is_positive()), high.as_ref()))
}

impl Round {
    /// The chance that the sum of squares lies in a set, from where there is no state.
    ///
    /// # Errors
    /// Where it would take too many slices.
    pub(super) fn chance(&self, motions: &[Motion; AXES], set: &Set) -> Result<Interval, String> {
        let numbers = [0, 1].map(|axis: usize| motions[axis].number(self.sides[axis].0));
        let [Some(one), Some(other)] = numbers else { return Err("a distance is lost".to_string()) };
        let mut sum = Interval::exactly(0.0);
        for (low, high) in rings(set) {
            let high = high.map_or(Ok(Interval::exactly(1.0)), |high| self.below([one, other], high))?;
            let low = low.map_or(Ok(Interval::exactly(0.0)), |low| self.below([one, other], low))?;
            sum = sum.plus(high.minus(low).probability());
        }
        Ok(sum.probability())
    }

    /// The chance that it is at most this, for normal numbers with these means and variances.
    fn below(&self, numbers: [(&BigRational, &BigRational); 2], bound: &BigRational) -> Result<Interval, String> {
        // In standard deviations from the means; a number that is scaled so errs by a few units.
        let scaled = |axis: usize| {
            let ((_, factor, middle), (mean, variance)) = (&self.sides[axis], numbers[axis]);
            let sd = near(variance).sqrt();
            ((near(&(middle - mean)) / sd), near(&(bound / factor / variance)).sqrt())
        };
        let [(middle, radius), (place, other)] = [scaled(0), scaled(1)];
        let found = slices(place, [radius, other], [1.0, 1.0], 1e-15)?;
        let chance = |slice: &Slice| {
            let across = distribution(middle + slice.half) - distribution(middle - slice.half);
            slice.weight * across * slice.places.map(density).iter().sum::<f64>()
        };
        let sum: f64 = found.slices.iter().map(chance).sum();
        // The weights sum up to less than twice the radius.
        let moved = 12.0 * UNIT * (middle.abs() + place.abs() + radius + other);
        let each = moved + 2.0 * DISTRIBUTION_ERROR + 2.0 * DENSITY_ERROR + found.slices.len() as f64 * UNIT;
        let error = found.error + 2.0 * other.max(1.0) * each;
        Ok(Interval::between(sum - error, sum + error).probability())
    }
}

impl Motion {
    /// Mean and variance of the number at a place of a patch, from where there is no state.
    fn number(&self, place: usize) -> Option<(&BigRational, &BigRational)> {
        match (&self.decider, place) {
            (Decider::Noisy { offset, variance, .. }, 1) => Some((offset, variance)),
            (Decider::Next, 1) => Some((&self.shift, &self.variance)),
            (_, 0 | 1) => None,
            _ => self.gates.get(place - 2).map(|gate| (&gate.offset, &gate.variance)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chance that two standard normal numbers lie so near a place on the second axis.
    fn near_place(radius: f64, place: f64) -> (f64, f64) {
        let found = slices(place, [radius; 2], [1.0; 2], 1e-14).expect("slices");
        let part = |slice: &Slice| {
            let across = distribution(slice.half) - distribution(-slice.half);
            slice.weight * across * slice.places.map(density).iter().sum::<f64>()
        };
        (found.slices.iter().map(part).sum(), found.error)
    }

    #[test]
    fn slices_of_a_circle_add_up_to_its_chance() {
        for radius in [0.001f64, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0] {
            let (sum, error) = near_place(radius, 0.0);
            let wanted = 1.0 - (-radius * radius / 2.0).exp();
            assert!((sum - wanted).abs() <= error + 4e-13, "{radius}: {sum} {wanted}");
            assert!(error <= 1e-14);
        }
    }

    #[test]
    fn circles_beside_the_middle_have_rices_chances() {
        // By scipy's rice.cdf.
        for (radius, place, wanted) in RICE {
            let (sum, error) = near_place(radius, place);
            assert!((sum - wanted).abs() <= error + 4e-13, "{radius} {place}: {sum} {wanted}");
        }
    }

    const RICE: [(f64, f64, f64); 4] = [
        (0.5, 1.0, 0.07347260204335203),
        (2.0, 1.5, 0.5763207195219995),
        (3.0, 6.0, 0.0009144226729152039),
        (10.0, 9.0, 0.8282374028426617),
    ];
}
