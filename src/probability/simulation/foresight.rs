//! How far a run is from what is asked for if it goes on as it does: the least effort of chance that brings it there.
//!
//! After j more moves `s' = A s + b + noise` a form f of the state has the mean `f A^j s + …` and a variance V, and it is where
//! it is asked to be with a chance of about `exp(-gap^2/(2V))`: the least of `gap^2/(2V)` over all j for which there is time
//! is an effort. For a walk it is the square of the gap over the time that is left; a run that is drawn back to its middle is
//! far away even where its gap is small, unless that is soon enough. Where one move alone goes most of the way, no measure helps.

use num_traits::Zero;

use super::near;
use crate::probability::chain::{Linear, Move, Side};
use crate::value::Relation;

/// The numbers of moves that are looked ahead: all up to the first of these, then about a quarter more each time.
const EACH: usize = 8;
const MOST: usize = 2_000;
/// The most numbers of a state.
const MOST_WIDTH: usize = 8;
/// The most tests that are looked at for one number of moves.
const MOST_TESTS: usize = 16;

/// A test some moves ahead, as a form of the state now.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Later {
    relation: Relation,
    factors: [f64; MOST_WIDTH],
    constant: f64,
    /// Of what is drawn on the way.
    variance: f64,
}

/// What is asked for after so many moves of one kind.
#[derive(Debug)]
struct Ahead {
    moves: usize,
    /// Ticks that pass.
    time: u64,
    /// Alternatives of tests.
    asked: Vec<Vec<Later>>,
}

/// What a phase looks ahead to.
#[derive(Debug, Default)]
pub(super) struct Foresight {
    ahead: Vec<Ahead>,
}

impl Foresight {
    /// Of a phase with these moves, each with what it is asked for and how many ticks it takes. Nothing is asked for later
    /// than in so many ticks.
    pub(super) fn of(phase: usize, moves: &[(&Move, Vec<&Vec<Side>>, u64)], deadline: u64) -> Foresight {
        let mut ahead = Vec::new();
        let width = moves.iter().flat_map(|(one, ..)| &one.image).map(|form| form.state.len()).max();
        let mut asked: Vec<Vec<Later>> = Vec::new();
        for (there, sides) in moves.iter().flat_map(|(there, asked, _)| asked.iter().map(move |sides| (there, sides))) {
            let tests = sides.iter().map(|side| Later::new(side, there)).collect();
            if !asked.contains(&tests) {
                asked.push(tests);
            }
        }
        let mut maps: Vec<(Map, u64)> = Vec::new();
        for (one, _, ticks) in moves.iter().filter(|(one, ..)| one.next == Some(phase)) {
            let map = (Map::of(one), *ticks);
            if !maps.contains(&map) {
                maps.push(map);
            }
        }
        let tests = maps.len() * asked.iter().map(Vec::len).sum::<usize>();
        if width.is_some_and(|width| width > MOST_WIDTH) || tests > MOST_TESTS {
            return Foresight::default();
        }
        for (map, ticks) in maps {
            let (mut asked, mut wanted) = (asked.clone(), 0);
            for number in 0..=MOST {
                let time = ticks.saturating_mul(number as u64);
                if time > deadline {
                    break;
                }
                if number == wanted {
                    ahead.push(Ahead { moves: number, time, asked: asked.clone() });
                    wanted += if number < EACH { 1 } else { number / 4 };
                }
                asked.iter_mut().flatten().for_each(|test| test.before(&map));
            }
        }
        Foresight { ahead }
    }

    /// The least effort that brings a state to what is asked for within so many ticks; none where that is not known.
    pub(super) fn effort(&self, state: &[f64], left: u64) -> Option<f64> {
        let there = self.ahead.iter().filter(|ahead| ahead.moves == 0 || ahead.time <= left);
        let alternatives = there.flat_map(|ahead| &ahead.asked);
        let all = alternatives.map(|tests| tests.iter().map(|test| test.effort(state)).fold(0.0, f64::max));
        all.filter(|effort| effort.is_finite()).reduce(f64::min)
    }
}

/// A move in machine numbers.
#[derive(PartialEq)]
struct Map {
    /// The factors of the state in each of its images.
    factors: Vec<[f64; MOST_WIDTH]>,
    /// The means of what is added.
    added: Vec<f64>,
    /// The factors of what is drawn, by its images, and the variances of that.
    noise: Vec<Vec<f64>>,
    variances: Vec<f64>,
}

impl Map {
    fn of(one: &Move) -> Map {
        let noise = |form: &Linear| (0..one.draws.len()).map(|place| form.draws.get(place).map_or(0.0, near)).collect();
        Map {
            factors: one.image.iter().map(factors).collect(),
            added: one.image.iter().map(|form| mean(form, one)).collect(),
            noise: one.image.iter().map(noise).collect(),
            variances: one.draws.iter().map(|draw| near(&draw.variance())).collect(),
        }
    }
}

impl Later {
    fn new(side: &Side, one: &Move) -> Later {
        let (factors, constant) = (factors(&side.form), mean(&side.form, one));
        let spread = side.form.draws.iter().zip(&one.draws);
        let variance = spread.map(|(factor, draw)| near(factor).powi(2) * near(&draw.variance())).sum();
        Later { relation: side.relation, factors, constant, variance }
    }

    /// The same test before a move.
    fn before(&mut self, map: &Map) {
        let mut sum = [0.0; MOST_WIDTH];
        let mut noise = vec![0.0; map.variances.len()];
        for (place, factor) in self.factors.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            let (Some(image), Some(drawn)) = (map.factors.get(place), map.noise.get(place)) else { continue };
            sum.iter_mut().zip(image).for_each(|(sum, own)| *sum += factor * own);
            noise.iter_mut().zip(drawn).for_each(|(noise, own)| *noise += factor * own);
            self.constant += factor * map.added.get(place).copied().unwrap_or_default();
        }
        self.variance +=
            noise.iter().zip(&map.variances).map(|(factor, variance)| factor * factor * variance).sum::<f64>();
        self.factors = sum;
    }

    fn effort(&self, state: &[f64]) -> f64 {
        let value = self.factors.iter().zip(state).fold(self.constant, |sum, (factor, number)| sum + factor * number);
        let gap = match self.relation {
            Relation::Gtr | Relation::Gte => (-value).max(0.0),
            Relation::Lss | Relation::Lte => value.max(0.0),
            Relation::Eq => value.abs(),
            Relation::Neq => 0.0,
        };
        if gap == 0.0 { 0.0 } else { gap * gap / (2.0 * self.variance) }
    }
}

fn factors(form: &Linear) -> [f64; MOST_WIDTH] {
    std::array::from_fn(|place| form.state.get(place).map_or(0.0, near))
}

/// The constant of a form, with the means of what is drawn in it.
fn mean(form: &Linear, one: &Move) -> f64 {
    let drawn = form.draws.iter().zip(&one.draws).filter(|(factor, _)| !factor.is_zero());
    drawn.fold(near(&form.constant), |sum, (factor, draw)| sum + near(factor) * near(&draw.mean()))
}
