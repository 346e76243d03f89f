//! Noise that sets in much more sharply than the noise of the next round.
//!
//! A grid on which it could be seen might be finer than machine numbers are. Where nothing is decided before that round,
//! both are put together, exactly: a normal number that is mapped linearly and gets more noise is normal.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::axes::AXES;
use super::plan::{Decider, Entry, Motion, PLACES, Plan, WIDTH, Way, plus, times};
use super::region::{Patch, whole};
use crate::interval::Interval;

/// Rounds that are put together.
const MOST_ROUNDS: usize = 10_000;

/// How much less noise one has than the next: in variance, as a power of two.
const SHARPLY: usize = 20;

/// Puts sharp entries together with the rounds behind them, as often as that can be done.
pub fn blunted(mut plan: Plan) -> Plan {
    let mut work = std::mem::take(&mut plan.entries);
    let mut steps = 0;
    while let Some(entry) = work.pop() {
        steps += 1;
        match if steps < MOST_ROUNDS { through(&entry, &plan) } else { None } {
            Some((entries, decided)) => {
                work.extend(entries);
                plan.decided = plus(plan.decided, decided);
            }
            None => plan.entries.push(entry),
        }
    }
    plan.entries.sort_by_key(|entry| entry.time);
    plan
}

/// An entry by the ways of the next round, with the chance of what is asked for in that round; none where it is not sharp,
/// or something is decided before.
fn through(entry: &Entry, plan: &Plan) -> Option<(Vec<Entry>, Interval)> {
    let way = &entry.way;
    let nothing = vec![whole(); WIDTH];
    let free = way.success.is_empty() && way.onward == [nothing] && way.motions.iter().all(|one| one.gates.is_empty());
    let ways = plan.phases.get(way.next)?;
    if !free || entry.time + 1 >= plan.rounds || ways.is_empty() {
        return None;
    }
    let (mut entries, mut decided) = (Vec::new(), Interval::exactly(0.0));
    for next in ways {
        // Of a distance nothing is known but where it is looked at.
        if !way.rounds.is_empty() || !next.rounds.is_empty() {
            return None;
        }
        let mut motions = Vec::new();
        for (first, second) in way.motions.iter().zip(&next.motions) {
            motions.push(composed(first, second)?);
        }
        let stateless = |patch: &Patch| (0..AXES).all(|axis| patch[axis * PLACES] == whole());
        if !next.success.iter().chain(&next.last).chain(&next.onward).all(stateless) {
            return None;
        }
        let way = Way { weight: &way.weight * &next.weight, motions: motions.try_into().ok()?, ..next.clone() };
        for patch in &way.success {
            decided = plus(decided, times(entry.chance, way.chance(patch).ok()?));
        }
        entries.push(Entry { time: entry.time + 1, way, chance: entry.chance });
    }
    Some((entries, decided))
}

/// One motion after another that starts from a known place; none where the first is not sharp.
fn composed(first: &Motion, second: &Motion) -> Option<Motion> {
    let (slope, early) = (&second.slope, &first.variance);
    let carried = slope * slope * early;
    let sharp = &carried * BigRational::from_integer(num_bigint::BigInt::one() << SHARPLY) <= second.variance;
    if !sharp || !second.gates.is_empty() || second.variance.is_zero() && !early.is_zero() {
        return None;
    }
    let decider = match &second.decider {
        Decider::Noisy { factor, offset, variance, covariance } => Decider::Noisy {
            factor: factor.clone(),
            offset: offset + factor * &first.shift,
            variance: variance + factor * factor * early,
            covariance: covariance + factor * slope * early,
        },
        other => other.clone(),
    };
    Some(Motion {
        slope: BigRational::zero(),
        shift: &second.shift + slope * &first.shift,
        variance: &second.variance + carried,
        decider,
        gates: Vec::new(),
    })
}
