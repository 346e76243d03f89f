//! Ellipses in the plane of the states, into or from which a way leads alone: a phase for each of their slices.
//!
//! Where the next state decides a round by its distance from a place, the density of the states has a hole. It is the density
//! over the whole plane, which is smooth, and less what is within the distance. That part is a sum of slices
//! ([`super::slices`]): each is a phase of its own, with points on lines through the ellipse, that goes on as the whole
//! plane does, and counts against it. Where the state itself decides, all that leads into the plane leads into slices of it,
//! too, from which the ways lead that the distance decides.

use super::axes::AXES;
use super::grid::{Grid, Smooth, panels};
use super::slices::slices;
use super::ways::{FastEntry, FastPatch, FastWay, Spot};

/// A slice of an ellipse, as a phase.
pub(super) struct Slice {
    /// The phase to the plane of which the ellipse belongs.
    base: usize,
    pub grids: [Grid; AXES],
    spot: Spot,
    /// Whether ways lead from it alone, and not into it alone.
    from: bool,
}

/// The slices of all ellipses.
#[derive(Default)]
pub(super) struct Spots {
    pub slices: Vec<Slice>,
    /// What a sum over all of them errs by.
    pub error: f64,
}

impl Spots {
    /// The slices of all ellipses into or from which ways lead, where so much is known of the integrals over a phase; what
    /// they err by should be about so much.
    ///
    /// # Errors
    /// Where there are too many, or the ellipses of a plane meet.
    pub(super) fn of(
        phases: &[Vec<FastWay>],
        entries: &[FastEntry],
        smooth: impl Fn(usize) -> [Smooth; AXES],
        wanted: f64,
    ) -> Result<Spots, String> {
        let mut known: Vec<(usize, bool, &Spot)> = Vec::new();
        let ways = phases.iter().flatten().chain(entries.iter().map(|entry| &entry.way));
        for way in ways {
            known.extend(way.onward.iter().filter_map(|patch| Some((way.next, false, patch.spot.as_ref()?))));
        }
        for (phase, ways) in phases.iter().enumerate() {
            let patches = ways.iter().flat_map(FastWay::patches);
            known.extend(patches.filter_map(|patch| Some((phase, true, patch.from.as_ref()?))));
        }
        let mut found = Spots::default();
        for (number, (base, from, spot)) in known.iter().enumerate() {
            if known[..number].contains(&(*base, *from, *spot)) {
                continue;
            }
            if known.iter().any(|(other, way, _)| other == base && way != from) {
                return Err("a distance is compared with the state, and another with the next one".to_string());
            }
            found.add((*base, *from), spot, &smooth(*base), wanted)?;
        }
        Ok(found)
    }

    fn add(
        &mut self,
        (base, from): (usize, bool),
        spot: &Spot,
        smooth: &[Smooth; AXES],
        wanted: f64,
    ) -> Result<(), String> {
        // A test of the state that cuts the ellipse would leave corners in its slices.
        let meets = |axis: usize| {
            let ends = (spot.middle[axis] - 1.001 * spot.radii[axis], spot.middle[axis] + 1.001 * spot.radii[axis]);
            smooth[axis].cuts.iter().any(|cut| ends.0 <= *cut && *cut <= ends.1)
        };
        if (0..AXES).any(meets) {
            return Err("the state is compared by its parts within a distance".to_string());
        }
        // What is integrated grows no faster than a normal density with so much noise.
        let sds = [0, 1].map(|axis: usize| smooth[axis].growth.sqrt().recip());
        let [Smooth { size, .. }, _] = smooth;
        let cut = slices(spot.middle[1], spot.radii, sds, wanted / size)?;
        self.error += cut.error * size;
        // Beyond the band of the kernel.
        self.error += 1e-16 * size * (spot.radii[0] / sds[0] * spot.radii[1] / sds[1]).max(1.0);
        for slice in cut.slices {
            let ends = (spot.middle[0] - slice.half, spot.middle[0] + slice.half);
            let along = panels(ends, &Smooth { cuts: Vec::new(), ..smooth[0].clone() })?;
            self.error += slice.weight * 0.8 / sds[1] * along.error;
            let across = Grid { nodes: slice.places.to_vec(), weights: vec![slice.weight; 2], step: None, error: 0.0 };
            self.slices.push(Slice { base, grids: [along, across], spot: spot.clone(), from });
        }
        Ok(())
    }

    /// A way without ellipses into which it leads, and one into each of their slices; of so many phases, behind which they
    /// are.
    fn split(&self, way: &FastWay, phases: usize) -> Vec<FastWay> {
        let (parts, plain): (Vec<FastPatch>, Vec<FastPatch>) =
            way.onward.iter().cloned().partition(|patch| patch.spot.is_some());
        let mut all = vec![FastWay { onward: plain.clone(), ..way.clone() }];
        for (number, slice) in self.slices.iter().enumerate().filter(|(_, slice)| slice.base == way.next) {
            let onward: Vec<FastPatch> = match slice.from {
                true => plain.clone(),
                false => parts.iter().filter(|part| part.spot.as_ref() == Some(&slice.spot)).cloned().collect(),
            };
            let onward: Vec<FastPatch> = onward.into_iter().map(|part| FastPatch { spot: None, ..part }).collect();
            if !onward.is_empty() {
                let (success, last, next) = (Vec::new(), Vec::new(), phases + number);
                all.push(FastWay { success, last, onward, next, ..way.clone() });
            }
        }
        all
    }

    /// Phases and entries with the slices as phases behind the others.
    pub(super) fn place(&self, phases: &mut Vec<Vec<FastWay>>, entries: &mut Vec<FastEntry>) {
        if self.slices.is_empty() {
            return;
        }
        let count = phases.len();
        let split = |ways: &[FastWay]| ways.iter().flat_map(|way| self.split(way, count)).collect::<Vec<FastWay>>();
        let whole: Vec<Vec<FastWay>> = phases.iter().map(|ways| split(&from(ways, None))).collect();
        let slices: Vec<Vec<FastWay>> = self
            .slices
            .iter()
            .map(|slice| match slice.from {
                true => split(&from(&phases[slice.base], Some(&slice.spot))),
                false => {
                    let sign = if slice.spot.inside { 1.0 } else { -1.0 };
                    let signed = |way: &FastWay| FastWay { weight: sign * way.weight, ..way.clone() };
                    whole[slice.base].iter().map(signed).collect()
                }
            })
            .collect();
        *phases = whole.into_iter().chain(slices).collect();
        let split = |entry: &FastEntry| {
            let ways = self.split(&entry.way, count).into_iter();
            ways.map(|way| FastEntry { time: entry.time, way, chance: entry.chance }).collect::<Vec<FastEntry>>()
        };
        *entries = entries.iter().flat_map(split).collect();
    }
}

/// The ways from an ellipse in the plane of the states, or from the whole plane.
fn from(ways: &[FastWay], spot: Option<&Spot>) -> Vec<FastWay> {
    let own = |patches: &[FastPatch]| -> Vec<FastPatch> {
        let own = patches.iter().filter(|patch| patch.from.as_ref() == spot);
        own.map(|patch| FastPatch { from: None, ..patch.clone() }).collect()
    };
    let way = |way: &FastWay| FastWay {
        success: own(&way.success),
        last: own(&way.last),
        onward: own(&way.onward),
        ..way.clone()
    };
    ways.iter().map(way).collect()
}
