//! First passages that are rare, of rounds that are one linear map: what is asked for in some round is at most as likely as
//! all rounds together, and at least as the likeliest of them, or as the sum over some rounds without their pairs
//! (Bonferroni). That two rounds have it is bounded by one normal number: of two half lines by the sum that lies beyond
//! both ends. So chances far below what sums over a grid can tell from 0 are known to nearly all their digits.

use num_traits::Zero;

use super::super::chain::Chain;
use super::super::{Enclosed, Question};
use super::{Machine, Moments, NOTHING, in_range, moments, pairs};
use crate::interval::{Interval, normal_between};

/// The largest chances that are bounded so.
const RARE: f64 = 1e-4;
/// Rounds that are looked at.
const MOST_ROUNDS: u64 = 2_000;
/// Rounds of which pairs are looked at.
const MOST_PAIRED: usize = 200;
/// What does not matter, in relation to the sum.
const VAIN: f64 = 1e-9;
/// What it is worth looking at pairs for.
const LIKELY: f64 = 0.05;

/// What was found by sums over a grid, which err by as much whatever the chance is: closer, where it is a rare first passage.
///
/// # Errors
/// What was found, where nothing else is.
pub(in super::super) fn closer(
    found: Result<Enclosed, String>,
    chain: &Chain,
    question: &Question,
) -> Result<Enclosed, String> {
    if found.as_ref().is_ok_and(|found| found.interval.high > RARE) {
        return found;
    }
    match (found, passages(chain, question)) {
        // Were they apart, one of them would be wrong, and nothing closer than both be known.
        (Ok(found), Some(bounds)) => {
            let apart = || found.interval.hull(bounds);
            Ok(Enclosed::within(found.interval.common(bounds).unwrap_or_else(apart)))
        }
        (Err(_), Some(bounds)) if bounds.high <= RARE => Ok(Enclosed::within(bounds)),
        (found, _) => found,
    }
}

/// Between which numbers the chance of a first passage lies, where a round is one linear map with normal noise.
fn passages(chain: &Chain, question: &Question) -> Option<Interval> {
    if !question.first {
        return None;
    }
    let moments = moments(chain, &Question { first: false, ..question.clone() }).ok()?;
    if !moments.normal || moments.asked.is_none() || moments.rounds > MOST_ROUNDS {
        return None;
    }
    let rounds = Rounds::of(&moments)?;
    let sum = rounds.all.iter().fold(NOTHING, |sum, round| sum.plus(round.chance()));
    let likeliest = rounds.all.iter().map(|round| round.chance().low).fold(0.0, f64::max);
    let low = if sum.high < LIKELY { likeliest.max(rounds.without_pairs()) } else { likeliest };
    Some(Interval::between(low, sum.high.min(1.0)))
}

/// What is shown in a round: its mean and spread, its covariances with all forms, and the chances of the ranges.
struct Round {
    mean: Interval,
    variance: Interval,
    covariances: Vec<Interval>,
    chances: Vec<Interval>,
}

impl Round {
    fn chance(&self) -> Interval {
        self.chances.iter().fold(NOTHING, |sum, chance| sum.plus(*chance))
    }
}

struct Rounds<'a> {
    machine: &'a Machine,
    all: Vec<Round>,
    /// The covariance of a form of a round with what is shown so many rounds later is this share of it.
    later: Vec<Vec<Interval>>,
}

impl Rounds<'_> {
    fn of(moments: &Moments) -> Option<Rounds<'_>> {
        let machine = &moments.machine;
        let count = moments.names.len();
        let ((steps, start), (spread, begun)) = (&machine.means, &machine.covariances);
        let (mut means, mut spreads) = (start.clone(), begun.clone());
        let mut all = Vec::new();
        for number in 0..=moments.rounds {
            let place = |other: usize| pairs(count).position(|pair| pair == (0, other));
            let covariances =
                (0..count).map(|other| Some(spreads[place(other)?])).collect::<Option<Vec<Interval>>>()?;
            let certain = number == 0 && moments.start.1[0][0].is_zero();
            let chances = machine.asked.iter().map(|range| chance(range, means[0], covariances[0], certain));
            let chances = chances.collect::<Option<Vec<Interval>>>()?;
            all.push(Round { mean: means[0], variance: covariances[0], covariances, chances });
            (means, spreads) = (applied(steps, &means), applied(spread, &spreads));
        }
        let mut later = vec![(0..count).map(|place| Interval::exactly(f64::from(u8::from(place == 0)))).collect()];
        while later.len() < all.len() {
            let last: &Vec<Interval> = later.last()?;
            let next = |place: usize| (0..count).fold(NOTHING, |sum, row| sum.plus(last[row].times(steps[row][place])));
            later.push((0..count).map(next).collect());
        }
        Some(Rounds { machine, all, later })
    }

    /// The sum over rounds without that over their pairs, over rounds that make it larger.
    fn without_pairs(&self) -> f64 {
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        order.sort_by(|one, other| self.all[*other].chance().low.total_cmp(&self.all[*one].chance().low));
        let (mut chosen, mut sum): (Vec<usize>, _) = (Vec::new(), NOTHING);
        for round in order.into_iter().take(MOST_PAIRED) {
            if self.all[round].chance().low < VAIN * sum.low {
                break;
            }
            let both =
                chosen.iter().fold(NOTHING, |sum, other| sum.plus(self.both(round.min(*other), round.max(*other))));
            let more = self.all[round].chance().minus(both);
            if more.low > 0.0 {
                sum = sum.plus(more);
                chosen.push(round);
            }
        }
        sum.low
    }

    /// A bound on the chance that two rounds have it.
    fn both(&self, first: usize, second: usize) -> Interval {
        let (one, other) = (&self.all[first], &self.all[second]);
        let share = one.covariances.iter().zip(&self.later[second - first]);
        let covariance = share.fold(NOTHING, |sum, (own, factor)| sum.plus(own.times(*factor)));
        let mut sum = 0.0;
        for (place, range) in self.machine.asked.iter().enumerate() {
            for (other_place, other_range) in self.machine.asked.iter().enumerate() {
                let least = one.chances[place].high.min(other.chances[other_place].high);
                let beyond = beyond((one, range), (other, other_range), covariance);
                sum = Interval::exactly(sum)
                    .plus(Interval::exactly(beyond.map_or(least, |beyond| beyond.min(least))))
                    .high;
            }
        }
        Interval::between(0.0, sum)
    }
}

/// The chance that the sum of how far two rounds are beyond the ends before their ranges is not negative.
fn beyond(
    (one, range): (&Round, &(Interval, Interval)),
    (other, other_range): (&Round, &(Interval, Interval)),
    covariance: Interval,
) -> Option<f64> {
    let ((sign, far), (other_sign, other_far)) = (before(one, range)?, before(other, other_range)?);
    let twice = Interval::exactly(2.0 * sign * other_sign).times(covariance);
    let variance = one.variance.plus(other.variance).plus(twice);
    let far = far.plus(other_far);
    (variance.low > 0.0 && far.low > 0.0).then(|| {
        let nearest = far.over(variance.root());
        normal_between(nearest, Interval::exactly(f64::INFINITY)).high
    })
}

/// The end of a range that lies between it and the mean: whether the range is above it, and how far it is.
fn before(round: &Round, (low, high): &(Interval, Interval)) -> Option<(f64, Interval)> {
    let (above, below) = (low.minus(round.mean), round.mean.minus(*high));
    if low.low.is_finite() && above.low > 0.0 {
        return Some((1.0, above));
    }
    (high.high.is_finite() && below.low > 0.0).then_some((-1.0, below))
}

/// The chance of a range; none where it is not known at all.
fn chance((low, high): &(Interval, Interval), mean: Interval, variance: Interval, certain: bool) -> Option<Interval> {
    if certain {
        let outside = mean.high < low.low || mean.low > high.high;
        let inside = mean.low > low.high && mean.high < high.low;
        return (outside || inside).then(|| Interval::exactly(f64::from(u8::from(inside))));
    }
    in_range((*low, *high), mean, variance)
}

/// An affine map, by its rows of factors and what is added.
fn applied(map: &super::Matrix, state: &[Interval]) -> Vec<Interval> {
    let row = |row: &Vec<Interval>| {
        row.iter().zip(state).fold(row[state.len()], |sum, (factor, number)| sum.plus(factor.times(*number)))
    };
    map.iter().map(row).collect()
}
