//! Runs that break a claim because of what they draw from densities: values are tried, from the middle of a distribution
//! and ever further out, each where its density is positive.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::orbit::{MOST_BITS, Run, is_long, shown_on};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::distribution::Distribution;
use crate::invariant::{Claim, meets};
use crate::model::{Action, Model, Move, Patience, State};
use crate::replay::Drawn;
use crate::term::Term;
use crate::value::Value;

/// States of one run, and of all.
const MOST_STATES: usize = 400;
const MOST_IN_ALL: usize = 30_000;
/// How far out values are tried, in standard deviations or means, about.
const REACHES: [i64; 6] = [1, 2, 4, 8, 32, 1_024];

/// On which side of the middle the draws of a run lie, by their turn: `steady` for all on one side, else by the bits of
/// a number, which come round.
struct Sides {
    bits: u64,
    length: u32,
}

impl Sides {
    fn upper(&self, turn: usize) -> bool {
        self.bits >> (turn % self.length as usize) & 1 == 1
    }
}

/// A run that breaks the claim, if trying values finds one.
pub fn broken(
    system: &Term,
    definitions: &Definitions,
    assumptions: &Assumptions,
    claim: &Claim,
    interrupted: &dyn Fn() -> bool,
) -> Option<Run> {
    let model = Model::new(definitions);
    let mut left = MOST_IN_ALL;
    // All on one side, then by turns: up to three draws a round go their own ways.
    let lengths = (1..=3u32).flat_map(|length| (0..1u64 << length).map(move |bits| Sides { bits, length }));
    let sides: Vec<Sides> = lengths.filter(|sides| sides.length != 3 || sides.bits % 7 != 0).collect();
    for reach in REACHES {
        for sides in &sides {
            let follower = Follower { model: &model, assumptions, claim, sides, reach };
            match follower.run(system, &mut left) {
                Found::Broken(run) => return Some(run),
                Found::Still => return None,
                Found::Nothing if left == 0 || interrupted() => return None,
                Found::Nothing => {}
            }
        }
    }
    None
}

/// What came of a run.
enum Found {
    Broken(Run),
    /// It meets the claim as far as it was followed.
    Nothing,
    /// It draws nothing from a density.
    Still,
}

struct Follower<'a> {
    model: &'a Model<'a>,
    assumptions: &'a Assumptions,
    claim: &'a Claim,
    sides: &'a Sides,
    reach: i64,
}

impl Follower<'_> {
    fn run(&self, system: &Term, left: &mut usize) -> Found {
        let (mut visits, mut drawn): (Vec<(BigRational, State)>, Vec<Drawn>) = (Vec::new(), Vec::new());
        let mut dense = false;
        let mut now = BigRational::zero();
        let Ok(mut state) = self.model.state(system) else { return Found::Still };
        while visits.len() < MOST_STATES && *left > 0 && !is_long(&state, MOST_BITS) {
            *left -= 1;
            visits.push((now.clone(), state.clone()));
            match meets(self.claim, &state, self.assumptions) {
                Ok(true) => {}
                Ok(false) => {
                    let shown = shown_on(visits.iter().map(|(time, state)| (time, state)), self.claim);
                    return Found::Broken(Run { shown, drawn });
                }
                Err(_) => break,
            }
            let Some(next) = self.step(&state, &mut now, &mut drawn, &mut dense) else { break };
            state = next;
        }
        if dense || *left == 0 { Found::Nothing } else { Found::Still }
    }

    /// One draw, one internal step, or time that passes.
    fn step(&self, state: &State, now: &mut BigRational, drawn: &mut Vec<Drawn>, dense: &mut bool) -> Option<State> {
        let moves = state.moves().ok()?;
        let draws: Vec<&Move> = moves.iter().filter(|one| matches!(one.action, Action::Draw(..))).collect();
        let upper = self.sides.upper(drawn.len());
        if let Some(one) = if upper { draws.last() } else { draws.first() } {
            let Action::Draw(from, outcome) = &one.action else { return None };
            let values = match outcome {
                Some((values, _)) => values.clone(),
                None => {
                    *dense = true;
                    let [from] = from.as_slice() else { return None };
                    vec![Value::rational(place(&Distribution::of(from).ok()?, self.reach, upper)?)]
                }
            };
            let draw = Drawn { from: from.clone(), values };
            let next = self.model.state(&draw.taken(one)?).ok()?;
            drawn.push(draw);
            return Some(next);
        }
        if let Some(one) = moves.iter().find(|one| matches!(one.action, Action::Tau(..))) {
            return self.model.state(&one.next).ok();
        }
        let Patience::Until(time) = state.patience(&moves) else { return None };
        *now += &time;
        self.model.pass(state, &time).ok()
    }
}

/// A power of two near the root of a number, so that what is drawn has a short name.
fn about(variance: &BigRational) -> BigRational {
    let bits = |number: &BigInt| i64::try_from(number.bits()).unwrap_or(i64::MAX);
    let half = (bits(variance.numer()) - bits(variance.denom())).div_euclid(2).clamp(-1_000, 1_000);
    let power = BigRational::from_integer(BigInt::one() << half.unsigned_abs());
    if half < 0 { power.recip() } else { power }
}

/// A value so far out, where the density is positive.
fn place(distribution: &Distribution, reach: i64, upper: bool) -> Option<BigRational> {
    let whole = |number: i64| BigRational::from_integer(number.into());
    let far = whole(if upper { reach } else { -reach });
    let value = match distribution {
        Distribution::Point(at) => at.clone(),
        Distribution::Normal { mean, variance } if variance.is_zero() => mean.clone(),
        Distribution::Normal { mean, variance } => mean + far * about(variance),
        Distribution::Uniform { low, high } if low == high => low.clone(),
        // Ever nearer to an end.
        Distribution::Uniform { low, high } => {
            let part = (high - low) / whole(2 * reach);
            if upper { high - part } else { low + part }
        }
        // Far out, or ever nearer to the start.
        Distribution::Exponential { rate, start, rising } => {
            let away = if upper == *rising { whole(reach) / rate } else { (whole(reach) * rate).recip() };
            if *rising { start + away } else { start - away }
        }
        Distribution::Poisson { mean } => {
            if upper {
                (mean.ceil() + whole(1)) * whole(reach)
            } else {
                whole(0)
            }
        }
        Distribution::Mixture(parts) => {
            let likely = parts.iter().filter(|(weight, _)| weight.is_positive());
            let values = likely.filter_map(|(_, part)| place(part, reach, upper));
            if upper { values.max()? } else { values.min()? }
        }
    };
    distribution.supports(&value).then_some(value)
}
