//! Rare events by splitting: runs that come nearest are copied where they did so, and what that favours is paid for.
//!
//! Adaptive multilevel splitting: again and again the runs that came least near are dropped, and copies of others, from
//! where these first came nearer, take their places; each time the estimate shrinks by the share that was left. With any
//! measure of nearness the mean of the estimate is the chance (Bréhier, Gazeau, Goudenège, Lelièvre and Rousset, 2016).
//! Several such estimates, independent of each other, give the confidence interval, by Student's distribution, longer above
//! where they are skewed. That holds
//! where they are much alike, as they are with a good measure of nearness. Where they differ far more than such a measure
//! would let them, most of the mean may be in estimates that none of these came to: they say nothing then.

use std::rc::Rc;

use super::random::{Draws, Source};
use super::simulation::{Program, Runner, Scratch};

/// Independent estimates.
pub const TIMES: u64 = 64;
/// Runs that are followed at a time.
pub const RUNS: usize = 1_000;
/// How many of them are dropped at a time, at least.
const DROPPED: usize = 100;
/// What a number of Student's distribution with 63 degrees of freedom exceeds in size once in a hundred times.
const QUANTILE: f64 = 2.656_144_8;
/// How often the variance of the best measure of nearness may be had. That one is the logarithm of the chance over the
/// number of runs (Cérou and Guyader, 2007), relative to the square of the chance. Sums of what is drawn stay below 7
/// times; where intervals missed the chance it was 40 times and more.
const MOST_EXCESS: f64 = 10.0;
/// Levels.
const MOST_LEVELS: usize = 20_000;
/// Records of runs that are kept.
const MOST_RECORDS: usize = 4_000_000;

/// What splitting found.
pub(super) struct Split {
    pub low: f64,
    pub high: f64,
    pub share: f64,
    /// Runs, in all.
    pub runs: u64,
}

/// A run with the places at which it came nearer than before.
struct Path {
    records: Vec<(f64, Rc<Runner>)>,
}

impl Path {
    fn best(&self) -> f64 {
        self.records.last().map_or(f64::NEG_INFINITY, |(nearness, _)| *nearness)
    }
}

/// A chance that is too small for plain simulation; none where nothing was found, or nothing to be relied on.
pub(super) fn split(program: &Program, seed: u64) -> Result<Option<Split>, String> {
    independent(MOST_EXCESS, RUNS, &|number| estimate(program, seed, number))
}

/// The interval that independent estimates without bias give, each with its runs; none where their variance is more than
/// so often that of the best measure of nearness with so many runs at a time.
pub(super) fn independent(
    most_excess: f64,
    runs_at_a_time: usize,
    estimate: &(dyn Fn(u64) -> Result<(f64, u64), String> + Sync),
) -> Result<Option<Split>, String> {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get) as u64;
    let work = |first: u64| -> Result<Vec<(u64, f64, u64)>, String> {
        let mine = (first..TIMES).step_by(threads as usize);
        mine.map(|number| estimate(number).map(|(share, runs)| (number, share, runs))).collect()
    };
    let found = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || work(first))).collect();
        let join = |worker: std::thread::ScopedJoinHandle<'_, _>| {
            worker.join().unwrap_or_else(|_| Err("a simulation stopped".to_string()))
        };
        workers.into_iter().map(join).collect::<Result<Vec<Vec<_>>, String>>()
    })?;
    let mut all: Vec<(u64, f64, u64)> = found.into_iter().flatten().collect();
    // Sums depend on their order, which must not depend on the number of cores.
    all.sort_by_key(|(number, ..)| *number);
    let times = TIMES as f64;
    let mean = all.iter().map(|(_, share, _)| share).sum::<f64>() / times;
    if mean <= 0.0 {
        return Ok(None);
    }
    let square = all.iter().map(|(_, share, _)| (share / mean - 1.0).powi(2)).sum::<f64>() / (times - 1.0);
    if square > most_excess * -mean.ln() / runs_at_a_time as f64 {
        return Ok(None);
    }
    // Estimates that are products have a long tail above: a mean of few of them is too low more often than too high, by what
    // the first term of its expansion says (Johnson, 1978). Few of them hardly show the tail: it is taken to be no shorter
    // than that of a number whose logarithm is normal. The interval is only made longer by it.
    let cube = all.iter().map(|(_, share, _)| (share / mean - 1.0).powi(3)).sum::<f64>() / times;
    let shown = if square > 0.0 { cube / square.powf(1.5) } else { 0.0 };
    let skewness = shown.max((square + 3.0) * square.sqrt());
    let above = QUANTILE + skewness * (2.0 * QUANTILE * QUANTILE + 1.0) / (6.0 * times.sqrt());
    let spread = mean * (square / times).sqrt();
    let runs = all.iter().map(|(.., runs)| runs).sum();
    Ok(Some(Split {
        low: (mean - QUANTILE * spread).max(0.0),
        high: (mean + above * spread).min(1.0),
        share: mean,
        runs,
    }))
}

/// One estimate, and the number of runs that it took.
fn estimate(program: &Program, seed: u64, number: u64) -> Result<(f64, u64), String> {
    let mut space = Scratch::default();
    let mut runs = 0u64;
    let mut source = || {
        runs += 1;
        // Apart from the numbers of plain simulation.
        Source::new(seed, 1 << 63 | number << 40 | runs)
    };
    let mut paths = Vec::with_capacity(RUNS);
    for _ in 0..RUNS {
        let mut path = Path { records: Vec::new() };
        follow(program, Runner::default(), &mut path, &source(), &mut space)?;
        paths.push(path);
    }
    let mut share = 1.0;
    for _ in 0..MOST_LEVELS {
        let mut order: Vec<f64> = paths.iter().map(Path::best).collect();
        order.sort_by(f64::total_cmp);
        let level = order[DROPPED - 1];
        if level == f64::INFINITY {
            break;
        }
        let (dropped, kept): (Vec<usize>, Vec<usize>) = (0..RUNS).partition(|place| paths[*place].best() <= level);
        if kept.is_empty() {
            return Ok((0.0, runs));
        }
        share *= kept.len() as f64 / RUNS as f64;
        for place in dropped {
            let source = source();
            // Rounds count from 0, so the last of them is free to choose by.
            let choice = (source.uniform(u64::from(u32::MAX), 0).0 * kept.len() as f64) as usize;
            let other = &paths[kept[choice.min(kept.len() - 1)]].records;
            let nearer = other.iter().position(|(nearness, _)| *nearness > level).unwrap_or(other.len() - 1);
            let mut path = Path { records: other[..=nearer].to_vec() };
            let here = Runner::clone(&path.records[nearer].1);
            if path.best() < f64::INFINITY {
                follow(program, here, &mut path, &source, &mut space)?;
            }
            paths[place] = path;
        }
        if paths.iter().map(|path| path.records.len()).sum::<usize>() > MOST_RECORDS {
            return Err("the runs that are split are too long".to_string());
        }
    }
    let reached = paths.iter().filter(|path| path.best() == f64::INFINITY).count();
    Ok((share * reached as f64 / RUNS as f64, runs))
}

/// Follows a run to its end, and records where it comes nearer.
fn follow(
    program: &Program,
    mut run: Runner,
    path: &mut Path,
    source: &Source,
    space: &mut Scratch,
) -> Result<(), String> {
    let mut best = path.best();
    loop {
        match program.turn(&mut run, source, space)? {
            Some(true) => {
                path.records.push((f64::INFINITY, Rc::new(run)));
                return Ok(());
            }
            Some(false) => return Ok(()),
            None => {}
        }
        let nearness = program.nearness(&run);
        if nearness > best {
            best = nearness;
            path.records.push((nearness, Rc::new(run.clone())));
        }
    }
}
