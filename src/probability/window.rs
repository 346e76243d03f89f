//! Where the states are, round by round, but for a small chance. Nothing rests on it: what leaves the window is counted.

use super::axes::AXES;
use super::chain::{Chain, Linear, Move, Side};
use super::kernel::{Fast, Guard, Ranges, near};
use super::random::{Sampler, Source};
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
/// Runs that are sampled, and rounds of them in all.
const RUNS: u64 = 2_000;
const SAMPLES: u64 = 400_000;
/// How much more room there is on each side than the runs took.
const ROOM: f64 = 0.75;

/// Where the number of each phase lies in most of so many rounds, as some runs tell; none of a phase without one, or that
/// no run comes to.
pub(super) fn sampled(chain: &Chain, rounds: u64) -> Vec<Option<(f64, f64)>> {
    let samplers = |one: &Move| one.draws.iter().map(Sampler::of).collect::<Result<Vec<Sampler>, String>>().ok();
    let all = |moves: &[Move]| moves.iter().map(samplers).collect::<Option<Vec<_>>>().unwrap_or_default();
    let (initial, phases) = (all(&chain.initial), chain.phases.iter().map(|moves| all(moves)).collect::<Vec<_>>());
    let mut found: Vec<Option<(f64, f64)>> = vec![None; chain.phases.len()];
    for run in 0..(SAMPLES / rounds.max(1)).clamp(RUNS / 10, RUNS) {
        let source = Source::new(1, run);
        let (mut phase, mut place) = (None, 0.0);
        for round in 0..=rounds {
            let (moves, samplers) = match phase {
                None => (&chain.initial, &initial),
                Some(phase) => (&chain.phases[phase], &phases[phase]),
            };
            let taken = moves.iter().zip(samplers).find_map(|(one, samplers)| {
                let drawn = samplers.iter().zip(0..).map(|(sampler, at)| sampler.draw(&source, round, at));
                let drawn: Vec<f64> = drawn.collect();
                let holds = |side: &Side| {
                    let order = value(&side.form, place, &drawn).partial_cmp(&0.0);
                    order.is_some_and(|order| side.relation.holds(order))
                };
                one.tests.iter().all(holds).then_some((one, drawn))
            });
            let Some((one, drawn)) = taken else { break };
            let Some(next) = one.next else { break };
            phase = Some(next);
            let Some(image) = one.image.first() else { continue };
            place = value(image, place, &drawn);
            let (low, high) = found[next].unwrap_or((place, place));
            found[next] = Some((low.min(place), high.max(place)));
        }
    }
    let wider = |(low, high): (f64, f64)| {
        let room = ROOM * (high - low);
        (low - room, high + room)
    };
    found.into_iter().map(|one| one.map(wider).filter(|(low, high)| low.is_finite() && high.is_finite())).collect()
}

fn value(form: &Linear, place: f64, drawn: &[f64]) -> f64 {
    let state = form.state.first().map_or(0.0, |factor| near(factor) * place);
    state + near(&form.constant) + form.draws.iter().zip(drawn).map(|(factor, one)| near(factor) * one).sum::<f64>()
}
