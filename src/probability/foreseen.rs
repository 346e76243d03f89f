//! A chain in which some variables are known for certain, round by round, as odometry that is read exactly and slips by
//! nothing: with a copy of each phase for the values that they have, what remains of the state is the rest.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::Zero;

use super::chain::{Chain, Linear, Move, Region, Side, Stretch};

/// Copies of phases.
const MOST_COPIES: usize = 400;
/// Bits of a known number.
const MOST_BITS: u64 = 4_000;

/// What each variable of a phase is known to be.
type Known = Vec<Option<BigRational>>;

/// The chain over what is not known; none where nothing is, or there would be too many copies within so many rounds.
pub(super) fn foreseen(chain: &Chain, rounds: u64) -> Option<Chain> {
    let certain = certain(chain);
    if certain.iter().flatten().all(|certain| !certain) {
        return None;
    }
    let mut copies = Copies { certain, places: BTreeMap::new(), states: Vec::new() };
    let initial = copies.moves(&chain.initial, &Vec::new(), 0)?;
    let mut phases = Vec::new();
    while let Some((phase, known, round)) = copies.states.get(phases.len()).cloned() {
        // Nothing is asked of the rounds behind the last one.
        let moves = if round > rounds + 1 { Vec::new() } else { copies.moves(&chain.phases[phase], &known, round)? };
        phases.push(moves);
        if copies.states.len() > MOST_COPIES {
            return None;
        }
    }
    Some(Chain { initial, phases, variables: Vec::new() })
}

/// Which variables of each phase are certain: those that come of certain ones without noise, whichever way is taken.
fn certain(chain: &Chain) -> Vec<Vec<bool>> {
    let width = |moves: &Vec<Move>| {
        let tests = moves.iter().flat_map(|one| one.tests.iter().map(|side| side.form.state.len()));
        let images = moves.iter().flat_map(|one| one.image.iter().map(|form| form.state.len()));
        tests.chain(images).max().unwrap_or(0)
    };
    let mut certain: Vec<Vec<bool>> = chain.phases.iter().map(|moves| vec![true; width(moves)]).collect();
    loop {
        let before = certain.clone();
        let from =
            chain.phases.iter().zip(&before).flat_map(|(moves, known)| moves.iter().map(move |one| (one, known)));
        let nothing = Vec::new();
        for (one, known) in chain.initial.iter().map(|one| (one, &nothing)).chain(from) {
            let Some(next) = one.next else { continue };
            for (place, form) in one.image.iter().enumerate() {
                let states = form.state.iter().zip(known).all(|(factor, known)| *known || factor.is_zero());
                let still = states && form.draws.iter().all(Zero::is_zero);
                if let Some(entry) = certain[next].get_mut(place) {
                    *entry = *entry && still;
                }
            }
        }
        if certain == before {
            return certain;
        }
    }
}

/// The copies of phases in the making, by phase and values, with the round in which each is first reached.
struct Copies {
    certain: Vec<Vec<bool>>,
    places: BTreeMap<(usize, Known), usize>,
    states: Vec<(usize, Known, u64)>,
}

impl Copies {
    /// The moves from known values; none where these grow too long.
    fn moves(&mut self, moves: &[Move], known: &Known, round: u64) -> Option<Vec<Move>> {
        let mut all = Vec::new();
        for one in moves {
            let Some(tests) = sides(&one.tests, known) else { continue };
            let image: Vec<Linear> = one.image.iter().map(|form| seen(form, known)).collect();
            let next = match one.next {
                Some(next) => Some(self.place(next, &image, round)?),
                None => None,
            };
            let stretch = |stretch: &Stretch| Stretch {
                duration: stretch.duration.clone(),
                shown: stretch.shown.iter().filter_map(|all| sides(all, known)).collect::<Region>(),
                values: stretch.values.iter().map(|form| seen(form, known)).collect(),
            };
            let stretches = one.stretches.iter().map(stretch).collect();
            all.push(Move { draws: one.draws.clone(), tests, stretches, image, next });
        }
        Some(all)
    }

    /// The copy for what is known of an image.
    fn place(&mut self, next: usize, image: &[Linear], round: u64) -> Option<usize> {
        let certain = &self.certain[next];
        let value = |(place, form): (usize, &Linear)| {
            let here = certain.get(place).copied().unwrap_or(false);
            here.then(|| form.constant.clone())
        };
        let known: Known = image.iter().enumerate().map(value).collect();
        if known.iter().flatten().any(|number| number.denom().bits() > MOST_BITS || number.numer().bits() > MOST_BITS) {
            return None;
        }
        let count = self.states.len();
        let place = *self.places.entry((next, known.clone())).or_insert(count);
        if place == count {
            self.states.push((next, known, round + 1));
        }
        Some(place)
    }
}

/// What is left of tests where these values are known; none where one of them fails.
fn sides(tests: &[Side], known: &Known) -> Option<Vec<Side>> {
    let mut left = Vec::new();
    for test in tests {
        let form = seen(&test.form, known);
        let number = form.state.iter().chain(&form.draws).all(Zero::is_zero);
        match number.then(|| test.relation.holds(form.constant.cmp(&BigRational::zero()))) {
            Some(true) => {}
            Some(false) => return None,
            None => left.push(Side::flat(form, test.relation)),
        }
    }
    Some(left)
}

/// A form over what is not known.
fn seen(form: &Linear, known: &Known) -> Linear {
    let mut form = form.clone();
    for (factor, value) in form.state.iter_mut().zip(known) {
        if let Some(value) = value {
            form.constant += std::mem::take(factor) * value;
        }
    }
    form
}
