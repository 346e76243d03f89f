//! Conditions on parameters that are learned from instances: tests that tell those in which the claim holds from those
//! that break it. What is learned is only a guess; it is given where the claim was proved with it.

use std::collections::BTreeSet;

use super::condition::{literals, weakest};
use super::curves::Kind;
use super::generalised::generalised;
use super::points::Points;
use super::prefix::prefix;
use super::search::{Short, by_curves, by_invariant, conditions, supposed};
use super::{Asked, Outcome, Verdict};
use crate::assumption::Assumptions;
use crate::period::{Period, Test, analyse};

/// Conditions of which none follows from another that are looked for.
const MOST_CONDITIONS: usize = 3;
/// Tests that are looked at.
const MOST_LITERALS: usize = 400;
/// The size of a test that is looked at.
const LONG: usize = 24;
/// Systems that are looked at with something supposed.
const MOST_ANALYSES: usize = 6;
/// Instances from which an invariant is taken, and different ones of these.
const MOST_TRIED: usize = 12;
const MOST_FURTHER: usize = 4;
const MOST_INVARIANTS: usize = 6;
/// Guesses that are mended by further instances before one is tried.
const MOST_MENDED: usize = 12;

/// The weakest conditions that were found: from invariants of instances in which the claim holds; else from those that were
/// tried; else from what tells the instances in which it holds from the others.
pub(super) fn learned(asked: Asked<'_>, points: Points<'_>, period: &Period, short: &[Short]) -> Vec<Vec<Test>> {
    let mut learner = Learner { asked, points, pool: Vec::new(), tried: BTreeSet::new() };
    let holding = learner.points.holding();
    let mixed = holding.contains(&true) && holding.contains(&false);
    let mut found = if mixed { learner.generalised(period) } else { Vec::new() };
    if found.is_empty() {
        found = conditions(asked, period, short, &learner.points).found;
    }
    if found.is_empty() && mixed {
        learner.note(prefix(period, asked).iter().filter(|test| test.left.size() + test.right.size() <= LONG));
        found = learner.conditions(found);
    }
    joined(asked.assumptions, found)
}

struct Learner<'a> {
    asked: Asked<'a>,
    points: Points<'a>,
    pool: Vec<Test>,
    /// What was supposed already.
    tried: BTreeSet<Vec<Test>>,
}

impl Learner<'_> {
    /// Tests that conditions may be made of.
    fn note<'t>(&mut self, tests: impl Iterator<Item = &'t Test>) {
        let known: BTreeSet<Test> = self.pool.iter().cloned().collect();
        let fresh = literals(self.asked.assumptions, tests).into_iter().filter(|test| !known.contains(test));
        self.pool.extend(fresh);
        self.pool.truncate(MOST_LITERALS);
    }

    fn conditions(&mut self, mut found: Vec<Vec<Test>>) -> Vec<Vec<Test>> {
        let assumptions = self.asked.assumptions;
        while found.len() < MOST_CONDITIONS && !self.ended() {
            let Some(guess) = self.guess(&found) else { break };
            let Some(tests) = self.proved_with(guess) else { break };
            let tests = self.fewer(tests);
            found = weakest(assumptions, found.into_iter().chain([tests]));
        }
        joined(assumptions, found)
    }

    /// Conditions under which an invariant of one instance is one.
    fn generalised(&mut self, period: &Period) -> Vec<Vec<Test>> {
        let Asked { claim, assumptions, interrupted, .. } = self.asked;
        let mut known: BTreeSet<Vec<Vec<Test>>> = BTreeSet::new();
        let mut found: Vec<Vec<Test>> = Vec::new();
        let mut done: BTreeSet<usize> = BTreeSet::new();
        let mut tries = 0;
        while tries < if found.is_empty() { MOST_TRIED } else { MOST_FURTHER } {
            tries += 1;
            // In a long run the claim does not hold by chance.
            let (all, left) = (self.points.all(), self.left(&found));
            let open = (0..all.len()).filter(|place| left[*place] && !done.contains(place));
            let Some(place) = open.max_by_key(|place| (all[*place].states, std::cmp::Reverse(*place))) else { break };
            if known.len() > MOST_INVARIANTS || interrupted() {
                break;
            }
            done.insert(place);
            for invariant in generalised(period, claim, assumptions, &all[place]) {
                if !known.insert(invariant.clone()) {
                    continue;
                }
                let short = Short::new(invariant);
                let more = conditions(self.asked, period, [&short], &self.points);
                // What tells the instances apart may do for other invariants, too.
                let guess = more.guess.and_then(|guess| self.proved_with(guess));
                let more = guess.map_or(more.found, |tests| vec![self.fewer(tests)]);
                found = weakest(assumptions, found.into_iter().chain(more));
                let clauses = short.clauses(self.asked, period, &self.points);
                if clauses.is_empty() {
                    continue;
                }
                let within = self.points.within_all(clauses);
                done.extend(within.iter().enumerate().filter(|(_, within)| **within).map(|(place, _)| place));
            }
        }
        found
    }

    fn ended(&self) -> bool {
        self.tried.len() >= MOST_ANALYSES || (self.asked.interrupted)()
    }

    /// In which the claim holds and that meet none of the conditions found.
    fn left(&self, found: &[Vec<Test>]) -> Vec<bool> {
        let mut left = self.points.holding();
        for tests in found {
            left.iter_mut().zip(self.points.meeting(tests)).for_each(|(left, meets)| *left &= !meets);
        }
        left
    }

    fn cover(&self, found: &[Vec<Test>]) -> Option<Vec<Test>> {
        let broken: Vec<bool> = self.points.holding().iter().map(|holds| !holds).collect();
        self.points.cover(&self.pool, &self.left(found), &broken)
    }

    /// Tests which instances meet that hold and that meet none of the conditions found, and no instance that breaks the
    /// claim: mended by further instances on both sides of each.
    fn guess(&mut self, found: &[Vec<Test>]) -> Option<Vec<Test>> {
        let mut guess = self.cover(found)?;
        for _ in 0..MOST_MENDED {
            let mut more = self.points.sample(&guess);
            for place in 0..guess.len() {
                let mut beyond = guess.clone();
                beyond[place] = beyond[place].negated();
                more |= self.points.sample(&beyond);
            }
            if !more {
                break;
            }
            guess = self.cover(found)?;
        }
        Some(guess)
    }

    /// What comes of the claim if these tests are supposed; nothing where they were before, or enough was tried.
    fn under(&mut self, tests: &[Test], with: &Assumptions, kinds: &[Kind]) -> Option<(Period, Outcome)> {
        let Asked { components, claim, definitions, .. } = self.asked;
        if with.contradictory() || self.ended() || !self.tried.insert(tests.to_vec()) {
            return None;
        }
        let period = analyse(components, definitions, with).ok()?;
        let mut outcome = Outcome::open();
        by_invariant(&period, claim, with, &mut outcome);
        if matches!(outcome.verdict, Verdict::Open) {
            by_curves(&period, claim, with, kinds, &mut outcome);
        }
        Some((period, outcome))
    }

    /// Tests under which the claim is proved: these, or more where that is found to be needed.
    fn proved_with(&mut self, tests: Vec<Test>) -> Option<Vec<Test>> {
        let with = supposed(self.asked.assumptions, &tests);
        let (period, outcome) = self.under(&tests, &with, &Kind::EACH)?;
        if matches!(outcome.verdict, Verdict::Proved(_)) {
            return Some(tests);
        }
        let asked = Asked { assumptions: &with, ..self.asked };
        let points = self.points.within(asked, &tests);
        let held = |more: &[Test]| points.meeting(more).into_iter().filter(|meets| *meets).count();
        let more = conditions(asked, &period, &outcome.short, &points).found;
        let best = more.into_iter().max_by_key(|more| held(more)).filter(|more| held(more) > 0)?;
        Some(tests.into_iter().chain(best).collect())
    }

    /// Leaves out tests without which the claim is proved, too.
    fn fewer(&mut self, mut tests: Vec<Test>) -> Vec<Test> {
        for place in (0..tests.len()).rev() {
            let mut others = tests.clone();
            others.remove(place);
            if others.is_empty() || !self.points.allow(&others) {
                continue;
            }
            let with = supposed(self.asked.assumptions, &others);
            let proved = self.under(&others, &with, &[]);
            if proved.is_some_and(|(_, outcome)| matches!(outcome.verdict, Verdict::Proved(_))) {
                tests = others;
            }
        }
        tests
    }
}

/// `A and h < 6` and `A and h >= 6` are `A`.
fn joined(assumptions: &Assumptions, mut found: Vec<Vec<Test>>) -> Vec<Vec<Test>> {
    let split = |one: &[Test], other: &[Test]| -> Option<Vec<Test>> {
        let place = one.iter().position(|test| {
            let rest: Vec<Test> = one.iter().filter(|own| *own != test).cloned().chain([test.negated()]).collect();
            let beyond = supposed(assumptions, &rest);
            other.iter().all(|test| test.decide(&beyond) == Some(true))
        })?;
        let mut rest = one.to_vec();
        rest.remove(place);
        Some(rest)
    };
    for first in 0..found.len() {
        for second in 0..found.len() {
            if first != second
                && let Some(rest) = split(&found[first], &found[second])
                && !rest.is_empty()
            {
                found[first] = rest;
                return joined(assumptions, weakest(assumptions, found));
            }
        }
    }
    found
}
