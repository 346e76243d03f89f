//! Where the states are, round by round, but for a small chance. Nothing rests on it: what leaves the window is counted.

use super::axes::AXES;
use super::kernel::{Fast, Guard, Ranges};
use super::ways::{FastEntry, FastWay};

/// Where the means may lie, and the variance of a normal number round them.
#[derive(Clone, Copy, Debug)]
struct Cloud {
    low: f64,
    high: f64,
    variance: f64,
}

/// The window of each phase in each round, by axis; none where no state is expected.
pub(super) type Windows = Vec<Vec<Option<[(f64, f64); AXES]>>>;

/// The windows for so many rounds, `wide` standard deviations on each side.
pub(super) fn windows(phases: &[Vec<FastWay>], entries: &[FastEntry], rounds: u64, wide: f64) -> Windows {
    let mut all: Windows = vec![Vec::new(); phases.len()];
    let mut now: Vec<Option<[Cloud; AXES]>> = vec![None; phases.len()];
    let mut entry = 0;
    for time in 0..=rounds {
        while let Some(one) = entries.get(entry).filter(|one| one.time == time) {
            let clouds = [0, 1].map(|axis: usize| start(&one.way.motions[axis]));
            add(&mut now[one.way.next], clouds);
            entry += 1;
        }
        let window = |cloud: &Cloud| {
            let side = wide * cloud.variance.sqrt();
            (cloud.low - side, cloud.high + side)
        };
        for (rows, clouds) in all.iter_mut().zip(&now) {
            rows.push(clouds.as_ref().map(|clouds| [window(&clouds[0]), window(&clouds[1])]));
        }
        let mut next = vec![None; phases.len()];
        for (phase, clouds) in now.iter().enumerate() {
            let Some(clouds) = clouds else { continue };
            for way in &phases[phase] {
                // What is taken out of another part comes from where that does.
                for patch in way.onward.iter().filter(|patch| patch.weight > 0.0) {
                    let cloud = |axis: usize| moved(&clouds[axis], &way.motions[axis], &patch.axes[axis].sets, wide);
                    if let (Some(one), Some(other)) = (cloud(0), cloud(1)) {
                        add(&mut next[way.next], [one, other]);
                    }
                }
            }
        }
        now = next;
    }
    all
}

fn start(motion: &Fast) -> Cloud {
    Cloud { low: motion.shift, high: motion.shift, variance: motion.sd * motion.sd }
}

fn add(entry: &mut Option<[Cloud; AXES]>, clouds: [Cloud; AXES]) {
    match entry {
        None => *entry = Some(clouds),
        Some(old) => {
            for (old, new) in old.iter_mut().zip(clouds) {
                old.low = old.low.min(new.low);
                old.high = old.high.max(new.high);
                old.variance = old.variance.max(new.variance);
            }
        }
    }
}

/// Where a motion leads from a cloud, as far as its guards let it; none where they hardly do.
fn moved(cloud: &Cloud, motion: &Fast, ranges: &[Ranges], wide: f64) -> Option<Cloud> {
    let hull = |ranges: &Ranges| Some((ranges.first()?.0, ranges.last()?.1));
    let (mut low, mut high) = hull(&ranges[0])?;
    for (factor, offset, sd, place) in motion.limits() {
        let (from, to) = hull(&ranges[place])?;
        if factor != 0.0 {
            let ends = [(from - wide * sd - offset) / factor, (to + wide * sd - offset) / factor];
            low = low.max(ends[0].min(ends[1]));
            high = high.min(ends[0].max(ends[1]));
        }
    }
    let side = wide * cloud.variance.sqrt();
    if low > cloud.high + side || high < cloud.low - side || low > high {
        return None;
    }
    let ends = [cloud.low, cloud.high].map(|end| motion.mean(end.clamp(low, high)));
    let (mut first, mut last) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
    if motion.guard == Guard::Next {
        let (from, to) = hull(&ranges[1])?;
        (first, last) = (first.clamp(from, to), last.clamp(from, to));
    }
    Some(Cloud { low: first, high: last, variance: motion.slope.powi(2) * cloud.variance + motion.sd.powi(2) })
}
