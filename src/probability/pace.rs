//! One way through a round over two coordinates, in machine numbers, with bounds on what these err by and on how what is
//! integrated grows away from the reals.

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use super::kernel::{Ranges, UNIT, everything};
use super::normal::{DENSITY_ERROR, DISTRIBUTION_ERROR, density, distribution};
use super::pair::{LOOKS, Look, PLACES, Step};
use super::region::{Patch, Set};

/// A number that decides: `factor * u + second * v + follows * u' + offset` and noise of this standard deviation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FastLook {
    pub factor: f64,
    pub second: f64,
    pub follows: f64,
    pub offset: f64,
    pub sd: f64,
}

/// A patch in machine numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Area {
    /// The first coordinate.
    pub now: Ranges,
    /// What leans on the second coordinate.
    pub tilt: Ranges,
    pub looks: Vec<Ranges>,
}

/// A way in machine numbers.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    pub weight: f64,
    pub next: Option<usize>,
    pub summed: bool,
    pub slope: f64,
    pub shift: f64,
    pub sd: f64,
    pub keep: f64,
    pub lean: f64,
    pub drift: f64,
    pub spread: f64,
    pub looks: Vec<FastLook>,
    /// What is tilted: so much of u', u and v.
    pub tilt: [f64; 3],
    pub success: Vec<Area>,
    pub last: Vec<Area>,
    pub onward: Vec<Area>,
}

/// The greatest sizes of both coordinates.
pub(super) type Reach = [f64; 2];

fn near(number: &BigRational) -> f64 {
    number.to_f64().unwrap_or(f64::NAN)
}

fn ranges(set: &Set) -> Ranges {
    let end = |end: &Option<BigRational>, other: f64| end.as_ref().map_or(other, near);
    set.iter().map(|(low, high)| (end(low, f64::NEG_INFINITY), end(high, f64::INFINITY))).collect()
}

/// The sizes of the ends of these.
fn finite(set: &Ranges) -> impl Iterator<Item = f64> {
    set.iter().flat_map(|(low, high)| [low.abs(), high.abs()]).filter(|end| end.is_finite())
}

/// The chance that a normal number lies in these.
pub(super) fn between(ranges: &Ranges, mean: f64, sd: f64) -> f64 {
    let part = |(low, high): &(f64, f64)| (distribution((high - mean) / sd) - distribution((low - mean) / sd)).max(0.0);
    if everything(ranges) { 1.0 } else { ranges.iter().map(part).sum() }
}

/// What lies in both.
pub(super) fn meet(one: &Ranges, other: &Ranges) -> Ranges {
    let both = one.iter().flat_map(|a| other.iter().map(move |b| (a.0.max(b.0), a.1.min(b.1))));
    let mut both: Ranges = both.filter(|(low, high)| low < high).collect();
    both.sort_by(|a, b| a.0.total_cmp(&b.0));
    both
}

impl Pace {
    pub(super) fn of(step: &Step) -> Pace {
        let look = |look: &Look| FastLook {
            factor: near(&look.factor),
            second: near(&look.second),
            follows: near(&look.follows),
            offset: near(&look.offset),
            sd: if look.rest.is_zero() { 0.0 } else { near(&look.rest).sqrt() },
        };
        let count = step.looks.len();
        let area = |patch: &Patch| Area {
            now: ranges(&patch[0]),
            tilt: ranges(&patch[1]),
            looks: patch[LOOKS..PLACES].iter().take(count).map(ranges).collect(),
        };
        let areas = |patches: &Vec<Patch>| patches.iter().map(area).collect::<Vec<Area>>();
        let ([slope, shift, variance], [keep, lean, drift, spread]) = (&step.first, &step.second);
        Pace {
            weight: near(&step.weight),
            next: step.next,
            summed: step.summed,
            slope: near(slope),
            shift: near(shift),
            sd: near(variance).sqrt(),
            keep: near(keep),
            lean: near(lean),
            drift: near(drift),
            spread: near(spread).sqrt(),
            looks: step.looks.iter().map(look).collect(),
            tilt: [0, 1, 2].map(|place: usize| near(&step.tilt[place])),
            success: areas(&step.success),
            last: areas(&step.last),
            onward: areas(&step.onward),
        }
    }

    pub(super) fn areas(&self) -> impl Iterator<Item = &Area> {
        self.success.iter().chain(&self.last).chain(&self.onward)
    }

    /// Whether bounds can be computed with these numbers.
    pub(super) fn is_sound(&self) -> bool {
        let fine = |number: f64| number.is_finite() && number.abs() < 1e60;
        let spread = |sd: f64| sd == 0.0 || (sd > 1e-60 && fine(sd));
        let own = [self.slope, self.shift, self.keep, self.lean, self.drift, self.weight].into_iter().all(fine);
        let looks = self.looks.iter().all(|look| {
            let known = look.sd > 0.0 || (look.follows != 0.0 && look.follows.abs() > 1e-60);
            [look.factor, look.second, look.follows, look.offset].into_iter().all(fine) && spread(look.sd) && known
        });
        own && looks && self.tilt.into_iter().all(fine) && spread(self.sd) && spread(self.spread)
    }

    pub(super) fn mean(&self, first: f64) -> f64 {
        self.slope * first + self.shift
    }

    pub(super) fn second_mean(&self, first: f64, second: f64) -> f64 {
        self.keep * second + self.lean * first + self.drift
    }

    pub(super) fn density(&self, from: f64, to: f64) -> f64 {
        density((to - self.mean(from)) / self.sd) / self.sd
    }

    pub(super) fn second_density(&self, mean: f64, to: f64) -> f64 {
        density((to - mean) / self.spread) / self.spread
    }

    /// The chance of all that decides and is not known from both first coordinates.
    pub(super) fn passes(&self, area: &Area, [first, second]: [f64; 2], to: f64) -> f64 {
        let both = self.looks.iter().zip(&area.looks).filter(|(look, _)| look.sd > 0.0);
        let mean = |look: &FastLook| look.factor * first + look.second * second + look.follows * to + look.offset;
        both.map(|(look, set)| between(set, mean(look), look.sd)).product()
    }

    /// Whether the chance of what decides depends on the second coordinate.
    pub(super) fn leans(&self) -> bool {
        self.looks.iter().any(|look| look.second != 0.0)
    }

    /// Whether something that leans on the second coordinate is cut.
    pub(super) fn is_tilted(&self) -> bool {
        self.areas().any(|area| !everything(&area.tilt))
    }

    /// Where the next second coordinate must lie, but for `slope` of the next first one.
    pub(super) fn tilted(&self, tilt: &Ranges, [first, second]: [f64; 2]) -> Ranges {
        let moved = self.tilt[1] * first + self.tilt[2] * second;
        tilt.iter().map(|(low, high)| (low - moved, high - moved)).collect()
    }

    /// Where the next first coordinate must lie.
    pub(super) fn reach(&self, area: &Area, from: f64) -> Ranges {
        let mut all = vec![(f64::NEG_INFINITY, f64::INFINITY)];
        for (look, set) in self.looks.iter().zip(&area.looks).filter(|(look, set)| look.sd == 0.0 && !everything(set)) {
            let place = |end: f64| (end - look.offset - look.factor * from) / look.follows;
            let piece = |(low, high): &(f64, f64)| {
                let (one, other) = (place(*low), place(*high));
                (one.min(other), one.max(other))
            };
            all = meet(&all, &set.iter().map(piece).collect());
        }
        all
    }

    /// Whether something that decides is known from both first coordinates, and cut.
    pub(super) fn is_tied(&self) -> bool {
        let tied = |(look, set): (&FastLook, &Ranges)| look.sd == 0.0 && !everything(set);
        self.areas().any(|area| self.looks.iter().zip(&area.looks).any(tied))
    }

    /// By how much the next first coordinate moves with this one where all that decides stays as it is; none where that
    /// is different for different numbers.
    pub(super) fn drag(&self) -> Option<f64> {
        let mut drags = self.looks.iter().filter(|look| look.sd == 0.0).map(|look| -look.factor / look.follows);
        let first = drags.next()?;
        drags.all(|other| (other - first).abs() <= 1e-12 * first.abs()).then_some(first)
    }

    /// What rounding changes in the sums of a row, for states of at most this size.
    ///
    /// As in [`super::kernel`]: an error d of a standardised place changes a density by a share |z| d, of which the mean is
    /// below 3/2, and a chance by at most 0.4 d.
    pub(super) fn rounding(&self, reach: Reach) -> f64 {
        let [one, other] = reach;
        let mean = 3.0 * UNIT * (self.slope.abs() * one + self.shift.abs() + one);
        let mut sum = if self.sd > 0.0 { 1.6 * mean / self.sd + 5.0 * DENSITY_ERROR } else { 0.0 };
        let size = self.keep.abs() * other + self.lean.abs() * one + self.drift.abs() + other;
        let [along, now, second] = self.tilt.map(f64::abs);
        let size = size + (along + now) * one + (1.0 + second) * other;
        if self.spread > 0.0 {
            sum += 3.2 * 4.0 * UNIT * size / self.spread + 5.0 * DENSITY_ERROR;
        }
        for area in self.areas() {
            for (look, set) in self.looks.iter().zip(&area.looks) {
                let known =
                    (look.factor.abs() + look.follows.abs()) * one + look.second.abs() * other + look.offset.abs();
                for end in finite(set) {
                    sum += DISTRIBUTION_ERROR + UNIT;
                    sum += match look.sd > 0.0 {
                        true => 0.4 * 8.0 * UNIT * (known + end) / look.sd,
                        // The place of a cut.
                        false => 0.4 * 8.0 * UNIT * ((known + end) / look.follows.abs() + one) / self.sd,
                    };
                }
            }
            for end in finite(&area.tilt) {
                let per = if self.spread > 0.0 { 0.4 * 8.0 * UNIT * (size + end) / self.spread } else { 0.0 };
                sum += 2.0 * (per + DISTRIBUTION_ERROR + UNIT);
            }
        }
        self.weight * sum
    }
}
