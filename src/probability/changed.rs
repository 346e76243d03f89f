//! Rare events by changing runs: those that came nearest are copied, and all that is drawn in them is changed a little,
//! again and again, as long as they come as near.
//!
//! Where a run soon forgets where it was, as one that is always drawn back does, copies that go on from a place have no
//! better chance than others: what leads there is several draws in a row that all help. The draws of a run as a whole are
//! normal numbers, and a change that keeps their distribution is made of them and of new ones (the preconditioned
//! Crank-Nicolson step; Cotter, Roberts, Stuart and White, 2013). It is accepted if the run still comes nearer than the
//! level. The levels and the sizes of the changes are found by a run of their own; with these given, the product of the
//! shares that pass each level has no bias, however well the changes mix (Del Moral, Doucet and Jasra, 2006).

use std::cell::RefCell;
use std::f64::consts::TAU;

use super::random::{Draws, Source};
use super::simulation::{Program, Runner, Scratch};
use super::splitting::{Split, independent};

/// Runs that are followed at a time.
const RUNS: usize = 500;
/// Changes of each run at each level.
const CHANGES: usize = 5;
/// One in so many runs passes a level.
const PASS: usize = 5;
/// Levels.
const MOST_LEVELS: usize = 120;
/// Numbers that are kept of one run.
const MOST_KEPT: usize = 4_000;
/// How often the variance of the best measure of nearness may be had.
const MOST_EXCESS: f64 = 60.0;

/// What is drawn in a run, by round and place and in this order: two standard normal numbers each.
type Drawn = Vec<((u64, u64), (f64, f64))>;

/// A run as a whole.
#[derive(Clone)]
struct Whole {
    drawn: Drawn,
    best: f64,
}

/// The draws of a run that is like another one.
struct Changed<'a> {
    before: &'a Drawn,
    /// New numbers.
    source: Source,
    /// The size of the change: 0 is none, 1 draws all anew.
    size: f64,
    after: RefCell<Drawn>,
}

impl Draws for Changed<'_> {
    fn uniform(&self, round: u64, place: u64) -> (f64, f64) {
        // The square of the radius and the angle of two normal numbers.
        let (across, along) = self.normal(round, place);
        let angle = along.atan2(across) / TAU;
        let within = |number: f64| number.clamp(f64::MIN_POSITIVE, 1.0 - f64::EPSILON / 2.0);
        let turned = if angle < 0.0 { angle + 1.0 } else { angle };
        (within((-(across * across + along * along) / 2.0).exp()), within(turned))
    }

    fn normal(&self, round: u64, place: u64) -> (f64, f64) {
        let (mut after, at) = (self.after.borrow_mut(), (round, place));
        let here = match after.last() {
            Some((last, _)) if *last >= at => match after.binary_search_by_key(&at, |(at, _)| *at) {
                Ok(here) => return after[here].1,
                Err(here) => here,
            },
            _ => after.len(),
        };
        let fresh = self.source.normal(round, place);
        // What the run before did not draw has its own distribution, and keeps it.
        let drawn = match self.old(at, here) {
            Some(old) => {
                let kept = (1.0 - self.size * self.size).max(0.0).sqrt();
                (kept * old.0 + self.size * fresh.0, kept * old.1 + self.size * fresh.1)
            }
            None => fresh,
        };
        after.insert(here, (at, drawn));
        drawn
    }
}

impl Changed<'_> {
    /// What the run before drew there, most often as the same number of all.
    fn old(&self, at: (u64, u64), likely: usize) -> Option<(f64, f64)> {
        match self.before.get(likely) {
            Some((other, drawn)) if *other == at => Some(*drawn),
            _ => self.before.binary_search_by_key(&at, |(at, _)| *at).ok().map(|here| self.before[here].1),
        }
    }
}

/// A level that a run is to pass, and the size of the changes there.
#[derive(Clone, Copy)]
struct Level {
    nearness: f64,
    size: f64,
}

/// A chance that is too small for plain simulation; none where nothing was found, or nothing to be relied on.
pub(super) fn changed(program: &Program, seed: u64) -> Result<Option<Split>, String> {
    let mut levels = Vec::new();
    let mut pilot = Ladder::new(program, seed, 1 << 20);
    let mut all = pilot.first()?;
    let mut size = 0.5;
    loop {
        all.sort_by(|one, other| other.best.total_cmp(&one.best));
        let nearness = all[RUNS / PASS].best;
        if nearness == f64::INFINITY {
            break;
        }
        if levels.len() >= MOST_LEVELS || !all.iter().any(|one| one.best > nearness) {
            return Ok(None);
        }
        all.retain(|one| one.best > nearness);
        all = pilot.copies(&all);
        for _ in 0..CHANGES {
            let accepted = pilot.change(&mut all, Level { nearness, size })?;
            // About three of ten are to be accepted.
            size = (size * (accepted - 0.3).exp()).clamp(0.01, 1.0);
        }
        levels.push(Level { nearness, size });
    }
    independent(MOST_EXCESS, RUNS, &|number| {
        let mut ladder = Ladder::new(program, seed, 1 << 21 | number);
        ladder.climb(&levels).map(|share| (share, ladder.runs))
    })
}

/// Runs that come nearer, level by level.
struct Ladder<'p> {
    program: &'p Program,
    seed: u64,
    number: u64,
    runs: u64,
    space: Scratch,
}

impl<'p> Ladder<'p> {
    fn new(program: &'p Program, seed: u64, number: u64) -> Ladder<'p> {
        Ladder { program, seed, number, runs: 0, space: Scratch::default() }
    }

    /// New numbers, apart from those of plain simulation and of splitting.
    fn source(&mut self) -> Source {
        self.runs += 1;
        Source::new(self.seed, 1 << 63 | self.number << 40 | self.runs)
    }

    fn first(&mut self) -> Result<Vec<Whole>, String> {
        let none = Whole { drawn: Drawn::new(), best: f64::NEG_INFINITY };
        (0..RUNS).map(|_| self.like(&none, 1.0)).collect()
    }

    /// A run like another one.
    fn like(&mut self, whole: &Whole, size: f64) -> Result<Whole, String> {
        let draws = Changed { before: &whole.drawn, source: self.source(), size, after: RefCell::default() };
        let (mut run, mut best) = (Runner::default(), f64::NEG_INFINITY);
        let best = loop {
            match self.program.turn(&mut run, &draws, &mut self.space)? {
                Some(true) => break f64::INFINITY,
                Some(false) => break best,
                None => best = best.max(self.program.closeness(&run)),
            }
            if draws.after.borrow().len() > MOST_KEPT {
                return Err("the runs that are changed are too long".to_string());
            }
        };
        Ok(Whole { drawn: draws.after.into_inner(), best })
    }

    /// As many runs as there were, drawn from these.
    fn copies(&mut self, all: &[Whole]) -> Vec<Whole> {
        let source = self.source();
        let any = |number: usize| {
            let place = (source.uniform(u64::from(u32::MAX), number as u64).0 * all.len() as f64) as usize;
            all[place.min(all.len() - 1)].clone()
        };
        (0..RUNS).map(any).collect()
    }

    /// Changes each run, if it then still passes the level; the share that was changed.
    fn change(&mut self, all: &mut [Whole], level: Level) -> Result<f64, String> {
        let mut accepted = 0;
        for whole in &mut *all {
            let other = self.like(whole, level.size)?;
            if other.best > level.nearness {
                *whole = other;
                accepted += 1;
            }
        }
        Ok(f64::from(accepted) / all.len() as f64)
    }

    /// The product of the shares that pass each of these levels, and come there in the end.
    fn climb(&mut self, levels: &[Level]) -> Result<f64, String> {
        let mut all = self.first()?;
        let mut share = 1.0;
        for level in levels {
            all.retain(|one| one.best > level.nearness);
            share *= all.len() as f64 / RUNS as f64;
            if all.is_empty() {
                return Ok(0.0);
            }
            all = self.copies(&all);
            for _ in 0..CHANGES {
                self.change(&mut all, *level)?;
            }
        }
        let reached = all.iter().filter(|one| one.best == f64::INFINITY).count();
        Ok(share * reached as f64 / RUNS as f64)
    }
}
