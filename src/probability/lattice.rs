//! Chances of a chain in which all that is drawn are numbers of arrivals or one of some numbers: its states are followed one
//! by one, each with its chance, and those that are the same are put together. What is next to impossible is left out and
//! counted. All numbers are exact, so a test may ask for equality; only chances are rounded.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::chain::{Chain, Move};
use super::plan::{plus, times};
use super::tabled::{Here, Tables};
use super::{Enclosed, Question};
use crate::distribution::Distribution;
use crate::interval::Interval;

/// Chances that are left out, of a number that is drawn and of a state.
const UNLIKELY: f64 = 1e-17;
/// Numbers that one draw is followed for, draws together on one way, and states in all.
const MOST_NUMBERS: u64 = 2_000;
const MOST_DRAWS: usize = 20_000;
const MOST_STATES: usize = 40_000;
/// Ways that are looked at.
const MOST_WORK: u64 = 20_000_000;

/// Numbers with their chances, and what those that are left out amount to.
type Numbers = (Vec<(BigRational, Interval)>, f64);

/// All that is drawn on one way, what the forms make of it, and the chance of what is left out.
struct Drawn {
    chances: Vec<Interval>,
    tables: Tables,
    lost: f64,
}

/// A time, a phase (none before the first), and its state.
type Place = (BigRational, Option<usize>, Vec<BigRational>);

/// A chance, surely between these.
///
/// # Errors
/// Where a number with a density is drawn, a round may take no time, or there are too many states.
pub fn lattice(chain: &Chain, question: &Question) -> Result<Enclosed, String> {
    let drawn = |moves: &[Move]| moves.iter().map(draws).collect::<Result<Vec<Drawn>, String>>();
    let (initial, phases) = (drawn(&chain.initial)?, chain.phases.iter().map(|moves| drawn(moves)).collect::<Vec<_>>());
    let phases = phases.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut open: BTreeMap<Place, Interval> = BTreeMap::new();
    open.insert((BigRational::zero(), None, Vec::new()), Interval::exactly(1.0));
    let (mut won, mut lost, mut work) = (Interval::exactly(0.0), 0.0, 0u64);
    while let Some(((time, phase, state), chance)) = open.pop_first() {
        if chance.high < UNLIKELY {
            lost += chance.high;
            continue;
        }
        let (moves, drawn) = match phase {
            None => (&chain.initial, &initial),
            Some(phase) => (&chain.phases[phase], &phases[phase]),
        };
        lost += chance.high * drawn.iter().map(|drawn| drawn.lost).fold(0.0, f64::max);
        for (one, drawn) in moves.iter().zip(drawn) {
            let here = drawn.tables.at(&state);
            for (number, own) in drawn.chances.iter().enumerate() {
                work += 1;
                if !here.taken(number) {
                    continue;
                }
                let chance = times(chance, *own);
                match passes(&here, number, one, &time, question)? {
                    Passed::Decided(true) => won = plus(won, chance),
                    Passed::Decided(false) => {}
                    Passed::Until(later) => {
                        let next = here.image(number);
                        let entry = open.entry((later, one.next, next)).or_insert(Interval::exactly(0.0));
                        *entry = plus(*entry, chance);
                    }
                }
            }
        }
        if work > MOST_WORK || open.len() > MOST_STATES {
            return Err("there are too many states".to_string());
        }
    }
    Ok(Enclosed::within(Interval::between(won.low, won.high + lost * (1.0 + 1e-9)).probability()))
}

/// All that is drawn on one way, with the chances.
fn draws(one: &Move) -> Result<Drawn, String> {
    let (mut all, mut lost) = (vec![(Vec::new(), Interval::exactly(1.0))], 0.0);
    for distribution in &one.draws {
        let (numbers, rest) = numbers(distribution)?;
        lost += rest;
        if all.len().saturating_mul(numbers.len()) > MOST_DRAWS {
            return Err("too many numbers may be drawn in a round".to_string());
        }
        let longer = all.iter().flat_map(|(drawn, chance): &(Vec<BigRational>, Interval)| {
            let with = |(number, own): &(BigRational, Interval)| {
                (drawn.iter().cloned().chain([number.clone()]).collect(), times(*chance, *own))
            };
            numbers.iter().map(with).collect::<Vec<_>>()
        });
        all = longer.collect();
    }
    let (drawn, chances): (Vec<Vec<BigRational>>, Vec<Interval>) = all.into_iter().unzip();
    Ok(Drawn { tables: Tables::of(one, &drawn), chances, lost })
}

/// The numbers of a distribution.
fn numbers(distribution: &Distribution) -> Result<Numbers, String> {
    match distribution {
        Distribution::Point(at) => Ok((vec![(at.clone(), Interval::exactly(1.0))], 0.0)),
        Distribution::Normal { mean, variance } if variance.is_zero() => {
            Ok((vec![(mean.clone(), Interval::exactly(1.0))], 0.0))
        }
        Distribution::Uniform { low, high } if low == high => Ok((vec![(low.clone(), Interval::exactly(1.0))], 0.0)),
        Distribution::Poisson { .. } => {
            let mut found = Vec::new();
            for number in (0..MOST_NUMBERS).map(|number| BigRational::from_integer(number.into())) {
                found.push((number.clone(), distribution.between(&number, &number)));
                let rest = distribution.more_than(&number).high;
                if rest < UNLIKELY {
                    return Ok((found, rest));
                }
            }
            Err("too many may arrive in a round".to_string())
        }
        Distribution::Mixture(parts) => {
            let (mut all, mut lost): (BTreeMap<BigRational, Interval>, f64) = (BTreeMap::new(), 0.0);
            for (share, part) in parts {
                let (numbers, rest) = numbers(part)?;
                lost += rest;
                for (number, chance) in numbers {
                    let entry = all.entry(number).or_insert(Interval::exactly(0.0));
                    *entry = plus(*entry, times(Interval::of(share), chance));
                }
            }
            Ok((all.into_iter().collect(), lost))
        }
        _ => Err("a number with a density is drawn".to_string()),
    }
}

/// Where a way through a round comes to.
enum Passed {
    /// Whether what is asked for is shown, which is certain now.
    Decided(bool),
    /// The next phase, at this time.
    Until(BigRational),
}

/// What is seen on the way from this time on, where this one of what may be drawn is drawn.
fn passes(here: &Here, drawn: usize, one: &Move, time: &BigRational, question: &Question) -> Result<Passed, String> {
    let mut now = time.clone();
    for (number, stretch) in one.stretches.iter().enumerate() {
        if now > question.time {
            return Ok(Passed::Decided(false));
        }
        let end = match &stretch.duration {
            None => None,
            Some(length) if length.is_positive() => Some(&now + length),
            Some(_) => return Err("a round takes no time".to_string()),
        };
        let asked = question.first || end.as_ref().is_none_or(|end| question.time < *end);
        if asked && here.shows(number, drawn) {
            return Ok(Passed::Decided(true));
        }
        match end {
            Some(end) if question.first || end <= question.time => now = end,
            _ => return Ok(Passed::Decided(false)),
        }
    }
    let over = now > question.time || one.next.is_none();
    Ok(if over { Passed::Decided(false) } else { Passed::Until(now) })
}
