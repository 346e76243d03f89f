//! What a chain is read for before it is run: which numbers are known exactly, in which unit time is counted, how far it is
//! to what is asked for.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::{Form, MOST_FACTORS, Numbers};
use crate::distribution::Distribution;
use crate::probability::Question;
use crate::probability::chain::{Chain, Linear, Move};
use crate::probability::random::Sampler;

/// Whether all numbers of a chain that are not drawn from a density are whole, and so small that no sum of a round of them
/// is rounded.
pub(super) fn whole(chain: &Chain) -> bool {
    let small = |number: &BigRational| number.is_integer() && number.to_i64().is_some_and(|n| n.abs() < MOST_FACTORS);
    let form = |form: &Linear| {
        let numbers = || form.state.iter().chain(&form.draws);
        let sum: i64 = numbers().filter_map(|number| number.to_integer().to_i64()).map(i64::abs).sum();
        numbers().chain([&form.constant]).all(small) && sum < MOST_FACTORS
    };
    let draw = |draw: &Distribution| {
        let point = |part: &Distribution| match part {
            Distribution::Point(at) => small(at),
            Distribution::Normal { mean, variance } => !variance.is_zero() || small(mean),
            Distribution::Uniform { low, high } => low != high || small(low),
            _ => true,
        };
        draw.parts().iter().all(|(_, part)| point(part))
    };
    let fits = |one: &Move| {
        let shown = one.stretches.iter().flat_map(|stretch| stretch.shown.iter().flatten());
        let sides = one.tests.iter().chain(shown).map(|side| &side.form);
        sides.chain(&one.image).all(form) && one.draws.iter().all(draw)
    };
    chain.initial.iter().chain(chain.phases.iter().flatten()).all(fits)
}

/// Whether one number is drawn with a chance.
pub(super) fn has_atoms(draw: &Distribution) -> bool {
    draw.parts().iter().any(|(_, part)| match part {
        Distribution::Normal { variance, .. } => variance.is_zero(),
        Distribution::Uniform { low, high } => low == high,
        Distribution::Exponential { .. } => false,
        _ => true,
    })
}

pub(super) fn near(number: &BigRational) -> f64 {
    number.to_f64().unwrap_or(f64::NAN)
}

pub(super) fn form(linear: &Linear, width: usize, known: &[bool], discrete: &[bool]) -> Form {
    let term = |start: usize| move |(place, factor): (usize, &BigRational)| (start + place, near(factor));
    let used = |numbers: &'_ [BigRational]| {
        let all = numbers.iter().enumerate().filter(|(_, factor)| !factor.is_zero());
        all.map(|(place, factor)| (place, factor.clone())).collect::<Vec<_>>()
    };
    let (state, draws) = (used(&linear.state), used(&linear.draws));
    let exact = state.iter().all(|(place, _)| known.get(*place) == Some(&true))
        && draws.iter().all(|(place, _)| discrete.get(*place) == Some(&true));
    let terms = state.iter().map(|(place, factor)| term(0)((*place, factor)));
    let terms = terms.chain(draws.iter().map(|(place, factor)| term(width)((*place, factor)))).collect();
    Form { terms, constant: near(&linear.constant), exact: exact.then(|| linear.clone()) }
}

/// Which variables of each phase are always known exactly.
pub(super) fn known(chain: &Chain, numbers: Numbers) -> Result<Vec<Vec<bool>>, String> {
    let mut known: Vec<Vec<bool>> = vec![Vec::new(); chain.phases.len()];
    let all =
        || std::iter::once((None, &chain.initial)).chain(chain.phases.iter().enumerate().map(|(a, b)| (Some(a), b)));
    for one in all().flat_map(|(_, moves)| moves) {
        if let Some(next) = one.next {
            known[next] = vec![true; one.image.len()];
        }
    }
    let mut changed = true;
    while changed {
        changed = false;
        for (from, moves) in all() {
            for one in moves {
                let Some(next) = one.next else { continue };
                let mut discrete = Vec::new();
                for draw in &one.draws {
                    let sampler = Sampler::of(draw)?;
                    discrete.push(numbers == Numbers::Exact || sampler.is_discrete());
                }
                let here = from.map_or(Vec::new(), |phase: usize| known[phase].clone());
                let exact = |linear: &Linear| form(linear, here.len(), &here, &discrete).exact.is_some();
                for (place, linear) in one.image.iter().enumerate() {
                    if known[next][place] && !exact(linear) {
                        known[next][place] = false;
                        changed = true;
                    }
                }
            }
        }
    }
    Ok(known)
}

/// The finest part of the times: one over this.
pub(super) fn unit(chain: &Chain, question: &Question) -> BigInt {
    let moves = chain.initial.iter().chain(chain.phases.iter().flatten());
    let durations = moves.flat_map(|one| one.stretches.iter().filter_map(|stretch| stretch.duration.as_ref()));
    durations.chain([&question.time]).fold(BigInt::one(), |unit, time| unit.lcm(time.denom()))
}

pub(super) fn ticks(time: &BigRational, unit: &BigInt) -> Option<u64> {
    (time * BigRational::from_integer(unit.clone())).to_integer().to_u64().filter(|ticks| *ticks < u64::MAX / 4)
}

/// How many moves it takes from each phase until what is asked for may be shown.
pub(super) fn distances(chain: &Chain) -> Vec<f64> {
    let shows = |one: &Move| one.stretches.iter().any(|stretch| !stretch.shown.is_empty());
    let start = |moves: &Vec<Move>| if moves.iter().any(shows) { 0.0 } else { f64::MAX };
    let mut distances: Vec<f64> = chain.phases.iter().map(start).collect();
    for _ in 0..chain.phases.len() {
        let next = |(phase, moves): (usize, &Vec<Move>)| {
            let least = moves.iter().filter_map(|one| Some(distances[one.next?] + 1.0)).fold(f64::MAX, f64::min);
            least.min(distances[phase])
        };
        let after: Vec<f64> = chain.phases.iter().enumerate().map(next).collect();
        if after == distances {
            break;
        }
        distances = after;
    }
    distances
}
