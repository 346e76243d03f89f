//! Patches that distances bound, in parts of which each is a product over the axes.

use num_rational::BigRational;

use super::axes::AXES;
use super::kernel::{Fast, Guard, everything, near};
use super::plan::{PLACES, Round, Way};
use super::region::{Patch, whole};
use super::slices::{Slice, rings, slices};
use super::ways::{FastPatch, Spot};

/// What cuts the distances of a way into slices.
pub(super) struct Slicer<'a> {
    pub way: &'a Way,
    pub motions: &'a [Fast; AXES],
    pub units: &'a [BigRational; AXES],
    /// What the slices of one ellipse should err by.
    pub wanted: f64,
    /// Whether the next state matters.
    pub onward: bool,
}

/// An ellipse in the plane of two numbers.
#[derive(Clone, Debug, PartialEq)]
struct Ellipse {
    /// The places of the numbers in a patch.
    places: [usize; AXES],
    middle: [f64; AXES],
    radii: [f64; AXES],
    sds: [f64; AXES],
}

/// Ellipses of different numbers, which all hold, and how often that counts.
type Term = (f64, Vec<Ellipse>);

/// How often the terms of a patch count in all; the bounds of [`super::enclosed`] allow for it.
const MOST_COUNTED: f64 = 4.0;
/// Parts of a patch.
const MOST_PARTS: usize = 4_000;

impl Slicer<'_> {
    /// Adds a patch in parts of which each is a product over the axes: what lies within a distance is a sum of slices. Gives
    /// what these err by.
    ///
    /// # Errors
    /// Where what lies within two distances of one place cannot be told, or there are too many slices.
    pub(super) fn sliced(&self, patch: &Patch, parts: &mut Vec<FastPatch>) -> Result<f64, String> {
        let Slicer { way, units, .. } = self;
        let axis =
            |axis: usize| Fast::ranges(&way.motions[axis], &units[axis], &patch[axis * PLACES..(axis + 1) * PLACES]);
        let axes = [axis(0), axis(1)];
        let mut terms: Vec<Term> = vec![(1.0, Vec::new())];
        for (round, set) in way.rounds.iter().zip(&patch[AXES * PLACES..]).filter(|(_, set)| **set != whole()) {
            if !(0..AXES).all(|axis| everything(&axes[axis][round.sides[axis].0])) {
                return Err("a round compares a distance, and its parts one by one".to_string());
            }
            let mut longer = Vec::new();
            for (low, high) in rings(set) {
                match high {
                    Some(high) => times(&terms, 1.0, &self.ellipse(round, high)?, &mut longer)?,
                    None => longer.extend(terms.iter().cloned()),
                }
                if let Some(low) = low {
                    times(&terms, -1.0, &self.ellipse(round, low)?, &mut longer)?;
                }
            }
            terms = together(longer);
        }
        if terms.iter().map(|(count, _)| count.abs()).sum::<f64>() > MOST_COUNTED {
            return Err("a round compares too many distances".to_string());
        }
        let mut error = 0.0;
        for (count, ellipses) in terms {
            let mut all = vec![FastPatch { weight: count, axes: axes.clone(), spot: None, from: None }];
            for ellipse in &ellipses {
                error += count.abs() * self.within(ellipse, &mut all)?;
            }
            parts.extend(all);
        }
        if parts.len() > MOST_PARTS { Err("distances are cut into too many slices".to_string()) } else { Ok(error) }
    }

    /// Bounds parts by an ellipse; gives what its slices err by.
    fn within(&self, ellipse: &Ellipse, parts: &mut Vec<FastPatch>) -> Result<f64, String> {
        if ellipse.places.contains(&0) {
            let from = Spot { inside: true, middle: ellipse.middle, radii: ellipse.radii };
            parts.iter_mut().for_each(|part| part.from = Some(from.clone()));
            let mixed = "a distance is compared of which one part is known with the state";
            return (ellipse.places == [0; AXES]).then_some(0.0).ok_or(mixed.to_string());
        }
        let next = (0..AXES).map(|axis| ellipse.places[axis] == 1 && self.motions[axis].guard == Guard::Next);
        let next: Vec<bool> = next.collect();
        if self.onward && next.contains(&true) {
            for part in parts.iter_mut() {
                let inside = part.weight > 0.0;
                part.spot = Some(Spot { inside, middle: ellipse.middle, radii: ellipse.radii });
                part.weight = part.weight.abs();
            }
            let fits = !next.contains(&false);
            let mixed = "a distance is compared of which one part is known with the next state";
            return fits.then_some(0.0).ok_or(mixed.to_string());
        }
        let Ellipse { places, middle, radii, sds } = ellipse;
        let found = slices(middle[1], *radii, *sds, self.wanted)?;
        let cut = |part: &FastPatch, slice: &Slice| {
            let mut part = FastPatch { weight: part.weight * slice.weight, ..part.clone() };
            part.axes[0].sets[places[0]] = vec![(middle[0] - slice.half, middle[0] + slice.half)];
            part.axes[1].points.push((places[1], slice.places.to_vec()));
            part
        };
        if parts.len() * found.slices.len() > MOST_PARTS {
            return Err("distances are cut into too many slices".to_string());
        }
        *parts = parts.iter().flat_map(|part| found.slices.iter().map(|slice| cut(part, slice))).collect();
        Ok(found.error)
    }

    /// What lies within a bound, in the scale of what it is about.
    fn ellipse(&self, round: &Round, bound: &BigRational) -> Result<Ellipse, String> {
        let scaled = |axis: usize| {
            let (place, factor, middle) = &round.sides[axis];
            let found = self.motions[axis].scaled(&self.way.motions[axis], *place, &self.units[axis]);
            let (unit, sd) = found.ok_or("a distance has no noise")?;
            let radius = near(&(bound * &unit * &unit / factor)).sqrt();
            Ok::<_, String>((*place, near(&(middle * &unit)), radius, sd))
        };
        let [one, other] = [scaled(0)?, scaled(1)?];
        Ok(Ellipse {
            places: [one.0, other.0],
            middle: [one.1, other.1],
            radii: [one.2, other.2],
            sds: [one.3, other.3],
        })
    }
}

/// Adds each term, so often, where an ellipse holds too.
fn times(terms: &[Term], count: f64, ellipse: &Ellipse, all: &mut Vec<Term>) -> Result<(), String> {
    for (own, others) in terms {
        let mut term: Term = (own * count, others.clone());
        match others.iter().position(|other| other.meets(ellipse)) {
            None => term.1.push(ellipse.clone()),
            Some(place) => match others[place].common(ellipse)? {
                Common::Nothing => continue,
                Common::First => {}
                Common::Second => term.1[place] = ellipse.clone(),
            },
        }
        all.push(term);
    }
    Ok(())
}

/// The same terms, each once.
fn together(terms: Vec<Term>) -> Vec<Term> {
    let mut all: Vec<Term> = Vec::new();
    for (count, ellipses) in terms {
        match all.iter_mut().find(|(_, others)| *others == ellipses) {
            Some((sum, _)) => *sum += count,
            None => all.push((count, ellipses)),
        }
    }
    all.retain(|(count, _)| *count != 0.0);
    all
}

/// What two ellipses have in common.
enum Common {
    Nothing,
    /// One lies in the other.
    First,
    Second,
}

impl Ellipse {
    /// Whether both are about one of the numbers.
    fn meets(&self, other: &Ellipse) -> bool {
        (0..AXES).any(|axis| self.places[axis] == other.places[axis])
    }

    /// What both have in common: so scaled that the first one is a circle, the other lies between two circles.
    fn common(&self, other: &Ellipse) -> Result<Common, String> {
        let over = |axis: usize| other.radii[axis] / self.radii[axis];
        let (least, most) = (over(0).min(over(1)), over(0).max(over(1)));
        let apart = |axis: usize| (self.middle[axis] - other.middle[axis]) / self.radii[axis];
        let apart = apart(0).hypot(apart(1));
        // More than what rounding does.
        let slack = 1e-9 * (1.0 + apart + most);
        match self.places == other.places {
            true if apart > 1.0 + most + slack => Ok(Common::Nothing),
            true if apart + 1.0 + slack < least => Ok(Common::First),
            true if apart + most + slack < 1.0 => Ok(Common::Second),
            _ => Err("what lies within two distances at once is compared".to_string()),
        }
    }
}
