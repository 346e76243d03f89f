//! How chances over two coordinates grow away from the reals.
//!
//! Moving the state by iy moves the noise so that all that is compared stays real; a normal density whose noise is moved by
//! ib is `e^(b²/2σ²)` times as large. Where a guard gives the step away, the next state moves too, and the growth of one
//! round adds to that of the next. The exponents are quadratic forms of y; a bound on several of them is one that is at
//! least as large as each everywhere.

use super::kernel::{BAND, Ranges};
use super::pace::Pace;
use super::panels::{interpolation, quadrature};

/// What is known of all rounds together.
pub(super) struct Growth {
    /// Of what is integrated over the next first coordinate, and of a chance with it.
    pub first: f64,
    pub chance: f64,
    /// The same for the second.
    pub second: f64,
    pub kept: f64,
    /// Whether places of cuts depend on the state, by coordinate.
    pub tied: bool,
    pub tilted: bool,
}

/// `p y1² + 2 q y1 y2 + r y2²`
type Square = [f64; 3];

/// A square of a linear form over a standard deviation.
fn square(one: f64, other: f64, sd: f64) -> Square {
    let (one, other) = (one / sd, other / sd);
    [one * one, one * other, other * other]
}

fn sum(one: Square, other: Square) -> Square {
    [one[0] + other[0], one[1] + other[1], one[2] + other[2]]
}

/// At least as large as both everywhere: one of them with what the other is larger by, where it is.
fn upper(one: Square, other: Square) -> Square {
    let [p, q, r] = [other[0] - one[0], other[1] - one[1], other[2] - one[2]];
    let (middle, apart) = (f64::midpoint(p, r), ((p - r) / 2.0).hypot(q));
    let (low, high) = (middle - apart, middle + apart);
    if high <= 0.0 {
        return one;
    }
    if low >= 0.0 {
        return other;
    }
    // The positive part of the difference, along the vector of its positive eigenvalue.
    let (x, y) = if p >= r { (high - r, q) } else { (q, high - p) };
    let factor = 1.000_001 * high / (x * x + y * y);
    sum(one, [factor * x * x, factor * x * y, factor * y * y])
}

/// A form of what a map makes of y.
fn through([p, q, r]: Square, [[a, b], [c, d]]: [[f64; 2]; 2]) -> Square {
    [
        p * a * a + 2.0 * q * a * c + r * c * c,
        p * a * b + q * (a * d + b * c) + r * c * d,
        p * b * b + 2.0 * q * b * d + r * d * d,
    ]
}

/// How the next state moves with this one where all that is compared stays real, and the growth of that.
type Move = ([[f64; 2]; 2], Square);

/// The move of a way into a phase that may end by a form of this slope, and where a chance may jump.
fn moved(pace: &Pace, ends: Option<f64>, jumps: bool) -> Result<Move, String> {
    let drag = if pace.is_tied() { pace.drag().ok_or("a round gives away several numbers that decide")? } else { 0.0 };
    if jumps && drag != 0.0 {
        return Err("a guard gives the step to the next state away, which is cut too".to_string());
    }
    let [along, now, second] = pace.tilt;
    let own = pace.is_tilted().then_some([-(along * drag + now), -second]);
    let other = ends.map(|slope| [-(slope * drag), 0.0]);
    let near = |one: f64, other: f64| (one - other).abs() <= 1e-12 * (one.abs() + other.abs());
    let [first, kept] = match (own, other) {
        (Some(one), Some(other)) if near(one[0], other[0]) && near(one[1], other[1]) => one,
        (Some(_), Some(_)) => return Err("several combinations of the state are looked at".to_string()),
        (one, other) => one.or(other).unwrap_or_default(),
    };
    let mut cost = [0.0; 3];
    for look in pace.looks.iter().filter(|look| look.sd > 0.0) {
        cost = sum(cost, square(look.factor + look.follows * drag, look.second, look.sd));
    }
    if pace.sd > 0.0 {
        cost = sum(cost, square(drag - pace.slope, 0.0, pace.sd));
    }
    if pace.spread > 0.0 {
        cost = sum(cost, square(first - pace.lean, kept - pace.keep, pace.spread));
    }
    Ok(([[drag, 0.0], [first, kept]], cost))
}

/// Where a first coordinate is cut at a fixed place.
pub(super) fn cuts(phases: &[Vec<Pace>], phase: usize) -> Vec<f64> {
    let ends = |set: &Ranges| set.iter().flat_map(|(low, high)| [*low, *high]).collect::<Vec<f64>>();
    let all = phases[phase].iter().flat_map(Pace::areas).flat_map(|area| ends(&area.now));
    all.filter(|end| end.is_finite()).collect()
}

/// The slope of the form by which a phase ends.
pub(super) fn ending(phases: &[Vec<Pace>], phase: usize) -> Option<f64> {
    phases[phase].iter().find(|pace| pace.next.is_none() && pace.is_tilted()).map(|pace| pace.tilt[0])
}

/// How chances of so many rounds grow.
///
/// # Errors
/// Where nothing keeps all that is compared real, or the numbers are too uneven.
pub(super) fn growth(phases: &[Vec<Pace>], rounds: u64) -> Result<Growth, String> {
    let paces = || phases.iter().flatten();
    let mut ended = [0.0; 3];
    for pace in paces().filter(|pace| pace.next.is_none()) {
        let looks = pace.looks.iter().filter(|look| look.sd > 0.0);
        let cost = looks.map(|look| square(look.factor, look.second, look.sd)).fold([0.0; 3], sum);
        ended = upper(ended, cost);
    }
    let mut moves: Vec<Move> = Vec::new();
    for pace in paces() {
        let Some(next) = pace.next else { continue };
        let one = moved(pace, ending(phases, next), !cuts(phases, next).is_empty())?;
        if !moves.contains(&one) {
            moves.push(one);
        }
    }
    let mut chance = ended;
    for _ in 0..=rounds {
        let grown = moves.iter().map(|(map, cost)| sum(*cost, through(chance, *map))).fold(ended, upper);
        if grown == chance {
            break;
        }
        chance = grown;
        if chance.iter().any(|number| number.is_nan() || number.abs() > 1e100) {
            return Err("the noise of a round is too uneven for machine numbers".to_string());
        }
    }
    let [p, q, r] = chance.map(|number| 1.001 * number);
    let (mut first, mut second, mut along) = (0.0f64, 0.0f64, 0.0f64);
    for pace in paces() {
        let Some(next) = pace.next else { continue };
        let looks = pace.looks.iter().filter(|look| look.sd > 0.0);
        let looks: f64 = looks.map(|look| (look.follows / look.sd).powi(2)).sum();
        if pace.sd > 0.0 {
            first = first.max(1.001 * (pace.sd.powi(-2) + looks));
        }
        if pace.spread > 0.0 {
            second = second.max(1.001 * pace.spread.powi(-2));
        }
        let own = pace.is_tilted().then_some(pace.tilt[0]);
        for slope in own.into_iter().chain(ending(phases, next)).chain([0.0]) {
            let spread = if pace.spread > 0.0 { (slope / pace.spread).powi(2) } else { 0.0 };
            along = along.max(1.001 * (spread + p - 2.0 * slope * q + slope * slope * r));
        }
    }
    let tied = paces().any(|pace| pace.next.is_some() && pace.is_tied());
    let tilted = paces().any(|pace| pace.next.is_some() && pace.is_tilted());
    Ok(Growth { first: first + along, chance: along, second: second + r, kept: r, tied, tilted })
}

/// Whether a phase ends by a jump that cannot be integrated in closed form.
pub(super) fn unfit(phases: &[Vec<Pace>], phase: usize) -> bool {
    let leans = |pace: &Pace| {
        let looks = pace.looks.iter().any(|look| look.second != 0.0);
        pace.next.is_none() && pace.is_tilted() && (looks || pace.success != pace.last)
    };
    let into = phases.iter().flatten().filter(|pace| pace.next == Some(phase));
    let still = ending(phases, phase).is_some() && into.into_iter().any(|pace| pace.spread <= 0.0);
    still || phases[phase].iter().any(leans)
}

/// How wide the panels of a phase may be along a coordinate.
pub(super) fn width(phases: &[Vec<Pace>], phase: usize, axis: usize, growth: &Growth, share: f64) -> f64 {
    let into = phases.iter().flatten().filter(|pace| pace.next == Some(phase));
    let sd = into.map(|pace| if axis == 0 { pace.sd } else { pace.spread }).fold(f64::INFINITY, f64::min);
    let (rate, own, cut) = match axis {
        0 => (growth.first, growth.chance, growth.tied),
        _ => (growth.second, growth.kept, growth.tilted),
    };
    let fine = |width: f64| {
        let pieces = 2.0 * BAND * sd / width + 6.0;
        let error = pieces * 0.4 / sd * quadrature(rate, width / 2.0);
        error < share && (!cut || interpolation(own, width / 2.0) < share)
    };
    let mut width = 9.0 * sd;
    while !fine(width) && width > 0.1 * sd {
        width *= 0.93;
    }
    width
}
