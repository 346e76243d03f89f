//! Chances by simulation: runs that are numbered, so that the answer depends on the seed alone, and a confidence
//! interval.

use std::collections::BTreeMap;

use super::Question;
use super::chain::Chain;
use super::changed::changed;
use super::random::Source;
use super::simulation::lanes::LANES;
use super::simulation::{Numbers, Program, Scratch};
use super::splitting::{Split, split};

/// What a simulation found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The lower end of the confidence interval.
    pub low: f64,
    /// Its upper end.
    pub high: f64,
    /// The share of runs in which it happened.
    pub share: f64,
    /// How many runs there were.
    pub runs: u64,
    /// What was done where hardly any of the runs came there.
    pub rare: Rare,
}

/// How a chance was estimated that is too small for plain simulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rare {
    /// It is not.
    No,
    /// Runs were split where they came nearer.
    Split,
    /// Runs were changed as a whole.
    Changed,
    /// Both in vain: what they gave was too uneven to be relied on.
    InVain,
}

impl Estimate {
    /// What is said of the runs where it hardly ever happened.
    pub fn how(&self) -> &'static str {
        match self.rare {
            Rare::No => "",
            Rare::Split => ", of which those that came nearest were split again and again",
            Rare::Changed => ", of which those that came nearest were copied and changed again and again",
            Rare::InVain => {
                ", hardly any of which came there; splitting or changing those that came nearest gave nothing to be relied on"
            }
        }
    }
}

/// The confidence of the interval: in the long run so large a share of such intervals holds the true value.
pub const CONFIDENCE: f64 = 0.99;
/// The standard normal number that is exceeded, on both sides together, with the chance that is left.
pub const QUANTILE: f64 = 2.575_829_303_548_901;
/// Runs that are tried with exact numbers first, where machine numbers may be next to each other.
const PROBED: u64 = 128;
/// Those of them that are.
const MOST_TIED: usize = 16;
/// Where it happened in a smaller share of the runs, they are split.
const RARE: u64 = 2_000;

/// Rounds of all runs that are followed to see where they are.
const MOST_TURNS: u64 = 2_000_000;

/// The phase in which most runs are that miss what is asked for, how many of them, and how many miss it; none if none does.
///
/// # Errors
/// Where it cannot be simulated.
pub fn missed_in(
    chain: &Chain,
    question: &Question,
    runs: u64,
    seed: u64,
) -> Result<Option<(usize, u64, u64)>, String> {
    let program = Program::new(chain, question, Numbers::Mixed)?;
    let (mut space, mut found, mut left) = (Scratch::default(), BTreeMap::new(), MOST_TURNS);
    for run in 0..runs {
        if let Some(phase) = program.missed(&Source::new(seed, run), &mut space, &mut left)? {
            *found.entry(phase).or_insert(0) += 1;
        }
    }
    let all = found.values().sum();
    // Of phases with equally many the first.
    let most = found.into_iter().rev().max_by_key(|(_, count)| *count);
    Ok(most.map(|(phase, count)| (phase, count, all)))
}

/// Simulates so many runs with this seed, on all cores; where it hardly ever happens, runs are split.
///
/// # Errors
/// When a run gets stuck, or never ends.
pub fn estimated(chain: &Chain, question: &Question, runs: u64, seed: u64) -> Result<Estimate, String> {
    let program = Program::new(chain, question, Numbers::Whole)?;
    if Program::new(chain, question, Numbers::Mixed)?.may_tie() {
        let exact = Program::new(chain, question, Numbers::Exact)?;
        if errs(&program, &exact, runs.min(PROBED), seed)? {
            return simulated(&exact, runs, seed);
        }
    }
    match simulated(&program, runs, seed) {
        // Numbers that grow too large for the machine are rationals.
        Err(_) if program.is_whole() => simulated(&Program::new(chain, question, Numbers::Mixed)?, runs, seed),
        found => found,
    }
}

/// Whether a run in which numbers next to each other were taken for equal ends otherwise with exact numbers: a robot that
/// comes ever nearer to its goal never is there.
///
/// # Errors
/// Where that cannot be told.
fn errs(program: &Program, exact: &Program, runs: u64, seed: u64) -> Result<bool, String> {
    let mut space = Scratch::default();
    let tied = (0..runs).filter_map(|run| {
        let source = Source::new(seed, run);
        space.tied.set(false);
        let found = program.happens(&source, &mut space);
        space.tied.get().then_some((source, found))
    });
    let tied: Vec<_> = tied.take(MOST_TIED).collect();
    for (source, found) in tied {
        let exactly = exact.happens(&source, &mut Scratch::default());
        let exactly = exactly.map_err(|why| format!("numbers next to each other could not be told apart: {why}"))?;
        if found != Ok(exactly) {
            return Ok(true);
        }
    }
    Ok(false)
}

fn simulated(program: &Program, runs: u64, seed: u64) -> Result<Estimate, String> {
    if program.is_certain() {
        let happens = program.happens(&Source::new(seed, 0), &mut Scratch::default())?;
        return Ok(interval(if happens { runs } else { 0 }, runs));
    }
    let happened = if program.is_plain() {
        let lanes = |first: u64| first * LANES..runs.min((first + 1) * LANES);
        counted(runs.div_ceil(LANES), || (), &|first, ()| program.count(seed, lanes(first)))?
    } else {
        let one = |run, space: &mut Scratch| program.happens(&Source::new(seed, run), space).map(u64::from);
        counted(runs, Scratch::default, &one)?
    };
    let plain = interval(happened, runs);
    // Runs that are too long to be split leave the plain answer, which is right too; so do two that contradict each other.
    let rare = happened * RARE < runs;
    // Exact numbers are too long for that.
    let agrees = |found: &Split| found.low <= plain.high && plain.low <= found.high;
    if !rare || program.is_exact() {
        return Ok(plain);
    }
    let split = split(program, seed).ok().flatten().filter(agrees).map(|found| (found, Rare::Split));
    // Where a run soon forgets where it was, runs are changed as a whole.
    let changed = || Some((changed(program, seed).ok()?.filter(agrees)?, Rare::Changed));
    Ok(match split.or_else(changed) {
        Some((found, rare)) => {
            let runs = runs + found.runs;
            Estimate { low: found.low, high: found.high, share: found.share, runs, rare }
        }
        None => Estimate { rare: Rare::InVain, ..plain },
    })
}

/// The sum over so many runs, or groups of them, of how often it happens, on all cores; each core has a space of its own.
///
/// # Errors
/// That of a run.
pub(super) fn counted<S>(
    runs: u64,
    space: impl Fn() -> S + Sync,
    happens: &(dyn Fn(u64, &mut S) -> Result<u64, String> + Sync),
) -> Result<u64, String> {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get) as u64;
    let some = |first: u64| -> Result<u64, String> {
        let (mut count, mut run, mut space) = (0, first, space());
        while run < runs {
            count += happens(run, &mut space)?;
            run += threads;
        }
        Ok(count)
    };
    std::thread::scope(|scope| {
        let some = &some;
        let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || some(first))).collect();
        let join = |worker: std::thread::ScopedJoinHandle<'_, Result<u64, String>>| {
            worker.join().unwrap_or_else(|_| Err("a simulation stopped".to_string()))
        };
        // All are waited for before one that failed is told of.
        let counts: Vec<Result<u64, String>> = workers.into_iter().map(join).collect();
        counts.into_iter().sum()
    })
}

/// Numbers of runs up to which the interval is that of Clopper and Pearson: it holds the share at least as often as is said.
const FEW: u64 = 50;

/// Wilson's interval for a share; where it happened, or did not, in few runs, that of Clopper and Pearson.
pub fn interval(happened: u64, runs: u64) -> Estimate {
    let (count, square) = (runs as f64, QUANTILE * QUANTILE);
    let share = happened as f64 / count;
    let middle = (share + square / (2.0 * count)) / (1.0 + square / count);
    let spread = (share * (1.0 - share) / count + square / (4.0 * count * count)).sqrt();
    let half = QUANTILE * spread / (1.0 + square / count);
    let (low, high) = match (happened, runs.saturating_sub(happened)) {
        (few, _) if few <= FEW => (least(few, runs), most(few, runs)),
        (_, few) if few <= FEW => (1.0 - most(few, runs), 1.0 - least(few, runs)),
        _ => (middle - half, middle + half),
    };
    Estimate { low, high, share, runs, rare: Rare::No }
}

/// The share from which so many runs or more come with half the chance that the confidence leaves; 0 for none.
fn least(happened: u64, runs: u64) -> f64 {
    let Some(fewer) = happened.checked_sub(1) else { return 0.0 };
    halved(|share| 1.0 - at_most(fewer, runs, share) <= (1.0 - CONFIDENCE) / 2.0)
}

/// The share from which so many runs or fewer come with half the chance that the confidence leaves; 1 for all.
fn most(happened: u64, runs: u64) -> f64 {
    if happened >= runs { 1.0 } else { halved(|share| at_most(happened, runs, share) > (1.0 - CONFIDENCE) / 2.0) }
}

/// Where shares stop being below what is looked for.
fn halved(below: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if below(middle) { low = middle } else { high = middle }
    }
    high
}

/// The chance of so many of independent runs or fewer, each with this share.
fn at_most(happened: u64, runs: u64, share: f64) -> f64 {
    let odds = (share.ln() - (-share).ln_1p(), runs as f64 * (-share).ln_1p());
    let (mut sum, mut choices) = (0.0, 0.0);
    for count in 0..=happened {
        sum += (choices + count as f64 * odds.0 + odds.1).exp();
        choices += ((runs - count) as f64 / (count + 1) as f64).ln();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_runs_give_the_interval_of_clopper_and_pearson() {
        // By scipy.stats.beta.ppf.
        for (happened, runs, low, high) in
            [(0, 1_000, 0.0, 5.284_306e-3), (2, 100_000, 1.034_950e-6, 9.273_455e-5), (1, 4, 1.252_351e-3, 0.889_115_0)]
        {
            let found = interval(happened, runs);
            assert!((found.low - low).abs() <= 1e-5 * low, "{happened} of {runs}: {found:?}");
            assert!((found.high - high).abs() <= 1e-5 * high, "{happened} of {runs}: {found:?}");
            let mirrored = interval(runs - happened, runs);
            assert!((1.0 - mirrored.high - found.low).abs() < 1e-12, "{mirrored:?} {found:?}");
            assert!((1.0 - mirrored.low - found.high).abs() < 1e-12, "{mirrored:?} {found:?}");
        }
    }
}
