//! Chances by simulation: runs that are numbered, so that the answer depends on the seed alone, and a confidence
//! interval.

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::Question;
use super::chain::{Chain, Linear, Move, Side};
use super::random::{Source, draw};
use crate::distribution::Distribution;
use crate::value::Relation;

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
}

/// The confidence of the interval: in the long run so large a share of such intervals holds the true value.
pub const CONFIDENCE: f64 = 0.99;
/// The standard normal number that is exceeded, on both sides together, with the chance that is left.
const QUANTILE: f64 = 2.575_829_303_548_901;
/// Rounds of one run.
const MOST_ROUNDS: usize = 1_000_000;

/// A form with machine numbers.
struct Form {
    state: Vec<f64>,
    draws: Vec<f64>,
    constant: f64,
}

/// Tests that must all hold.
type Tests = Vec<(Relation, Form)>;

struct Step {
    draws: Vec<Distribution>,
    tests: Tests,
    /// Durations, and when what is asked for is shown.
    stretches: Vec<(Option<f64>, Vec<Tests>)>,
    image: Vec<Form>,
    next: Option<usize>,
}

/// Simulates so many runs with this seed, on all cores.
///
/// # Errors
/// When a run gets stuck, or never ends.
pub fn estimated(chain: &Chain, question: &Question, runs: u64, seed: u64) -> Result<Estimate, String> {
    let compile = |moves: &[Move]| moves.iter().map(step).collect::<Vec<Step>>();
    let initial = compile(&chain.initial);
    let phases: Vec<Vec<Step>> = chain.phases.iter().map(|moves| compile(moves)).collect();
    let time = question.time.to_f64().ok_or("the time is too large")?;
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get) as u64;
    let one = |first: u64| -> Result<u64, String> {
        let mut count = 0;
        let mut run = first;
        while run < runs {
            count += u64::from(happens(&initial, &phases, question.first, time, Source::new(seed, run))?);
            run += threads;
        }
        Ok(count)
    };
    let counts: Vec<Result<u64, String>> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || one(first))).collect();
        let join = |worker: std::thread::ScopedJoinHandle<'_, Result<u64, String>>| {
            worker.join().unwrap_or_else(|_| Err("a simulation stopped".to_string()))
        };
        workers.into_iter().map(join).collect()
    });
    let mut happened = 0;
    for count in counts {
        happened += count?;
    }
    Ok(interval(happened, runs))
}

/// Wilson's interval for a share.
pub fn interval(happened: u64, runs: u64) -> Estimate {
    let (count, square) = (runs as f64, QUANTILE * QUANTILE);
    let share = happened as f64 / count;
    let middle = (share + square / (2.0 * count)) / (1.0 + square / count);
    let spread = (share * (1.0 - share) / count + square / (4.0 * count * count)).sqrt();
    let half = QUANTILE * spread / (1.0 + square / count);
    let low = if happened == 0 { 0.0 } else { middle - half };
    let high = if happened == runs { 1.0 } else { middle + half };
    Estimate { low, high, share, runs }
}

fn step(one: &Move) -> Step {
    let side = |side: &Side| (side.relation, form(&side.form));
    let near = |number: &BigRational| number.to_f64().unwrap_or(f64::INFINITY);
    Step {
        draws: one.draws.clone(),
        tests: one.tests.iter().map(side).collect(),
        stretches: one
            .stretches
            .iter()
            .map(|stretch| {
                let shown = stretch.shown.iter().map(|sides| sides.iter().map(side).collect()).collect();
                (stretch.duration.as_ref().map(near), shown)
            })
            .collect(),
        image: one.image.iter().map(form).collect(),
        next: one.next,
    }
}

fn form(linear: &Linear) -> Form {
    let near = |number: &BigRational| number.to_f64().unwrap_or(f64::NAN);
    Form {
        state: linear.state.iter().map(near).collect(),
        draws: linear.draws.iter().map(near).collect(),
        constant: near(&linear.constant),
    }
}

impl Form {
    fn at(&self, state: &[f64], draws: &[f64]) -> f64 {
        let sum = |factors: &[f64], numbers: &[f64]| factors.iter().zip(numbers).map(|(a, b)| a * b).sum::<f64>();
        self.constant + sum(&self.state, state) + sum(&self.draws, draws)
    }
}

fn holds(tests: &[(Relation, Form)], state: &[f64], draws: &[f64]) -> bool {
    tests.iter().all(|(relation, form)| relation.holds(form.at(state, draws).total_cmp(&0.0)))
}

/// Whether it happens in one run.
fn happens(initial: &[Step], phases: &[Vec<Step>], first: bool, time: f64, source: Source) -> Result<bool, String> {
    let mut state: Vec<f64> = Vec::new();
    let mut now = 0.0;
    let mut steps = initial;
    let mut drawn: Vec<f64> = Vec::new();
    // Times are sums of machine numbers; a little late is not too late.
    let late = time + 1e-9 * (1.0 + time);
    for round in 0..MOST_ROUNDS {
        let mut chosen = None;
        for one in steps {
            // The same place of the same round gives the same number, whichever way it is drawn on.
            drawn.clear();
            let places = one.draws.iter().enumerate();
            drawn.extend(places.map(|(place, distribution)| draw(distribution, &source, round as u64, place as u64)));
            if holds(&one.tests, &state, &drawn) {
                chosen = Some(one);
                break;
            }
        }
        let Some(one) = chosen else { return Err("a run got stuck".to_string()) };
        for (duration, shown) in &one.stretches {
            let end = duration.map_or(f64::INFINITY, |duration| now + duration);
            let counts = now <= late && (first || end > late);
            let here = counts && shown.iter().any(|tests| holds(tests, &state, &drawn));
            if here || (counts && !first) {
                return Ok(here);
            }
            now = end;
        }
        match one.next {
            Some(next) if now <= late => {
                state = one.image.iter().map(|form| form.at(&state, &drawn)).collect();
                steps = phases.get(next).map(Vec::as_slice).unwrap_or_default();
            }
            _ => return Ok(false),
        }
    }
    Err("a run has more than a million rounds".to_string())
}
