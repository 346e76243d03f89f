//! A shortest run that tells two states apart that are not branching bisimilar.
//!
//! One side makes a step; the other answers by the step, with internal steps before it, or, if the step is internal, by
//! none. After internal steps before its answer the pair to go on from may be the one in which the answer is not yet
//! made, whichever is worse for who answers (van Glabbeek 1993). Internal steps within a class are no steps here.

use std::collections::HashMap;

use super::evidence::{Difference, Played};
use crate::transition_system::{Label, TransitionSystem};

/// The most pairs, and the most answers, that are looked into.
const MOST_PAIRS: usize = 200_000;
const MOST_ANSWERS: usize = 4_000_000;

/// A step of one side.
struct Challenge {
    pair: u32,
    left_moves: bool,
    label: u32,
    /// Answers that are not lost yet.
    left: u32,
}

/// An answer: the pairs from which the game may go on, and whether it is lost.
struct Answer {
    challenge: u32,
    pairs: [u32; 2],
    lost: bool,
}

#[derive(Default)]
struct Search {
    places: HashMap<(u32, u32), u32>,
    pairs: Vec<(u32, u32)>,
    challenges: Vec<Challenge>,
    answers: Vec<Answer>,
    /// For each pair the answers that it is part of.
    part_of: Vec<Vec<u32>>,
    /// For each pair in how many steps it is told apart, and by which challenge.
    ranks: Vec<Option<(u32, u32)>>,
    closures: HashMap<u32, Vec<u32>>,
}

/// The run from this pair, and what differs at its end; none if the two are alike, or there are too many pairs.
pub(super) fn shortest(
    system: &TransitionSystem,
    pair: (u32, u32),
    stop: &dyn Fn() -> bool,
) -> Option<(Vec<Played>, Difference)> {
    let mut search = Search::default();
    search.place(pair);
    let mut next = 0;
    let mut level = Vec::new();
    while next < search.pairs.len() {
        let many = search.pairs.len() > MOST_PAIRS || search.answers.len() > MOST_ANSWERS;
        if many || (next % 1024 == 0 && stop()) {
            return None;
        }
        let (one, two) = search.pairs[next];
        if system.mark_number(one) != system.mark_number(two) {
            search.ranks[next] = Some((0, u32::MAX));
            level.push(next as u32);
        } else if one != two {
            search.look(system, next as u32);
        }
        next += 1;
    }
    search.spread(level);
    search.run(system)
}

impl Search {
    fn place(&mut self, pair: (u32, u32)) -> u32 {
        let next = self.pairs.len() as u32;
        let place = *self.places.entry(pair).or_insert(next);
        if place == next {
            self.pairs.push(pair);
            self.part_of.push(Vec::new());
            self.ranks.push(None);
        }
        place
    }

    /// The states that internal steps lead to, from none on.
    fn closure(&mut self, system: &TransitionSystem, state: u32) -> Vec<u32> {
        if let Some(known) = self.closures.get(&state) {
            return known.clone();
        }
        let mut all = vec![state];
        let mut next = 0;
        let mut seen = std::collections::HashSet::from([state]);
        while next < all.len() {
            all.extend(system.internal(all[next]).filter(|to| seen.insert(*to)).collect::<Vec<_>>());
            next += 1;
        }
        self.closures.insert(state, all.clone());
        all
    }

    fn look(&mut self, system: &TransitionSystem, pair: u32) {
        let (one, two) = self.pairs[pair as usize];
        for left_moves in [true, false] {
            let (mover, other) = if left_moves { (one, two) } else { (two, one) };
            let ordered = |mine: u32, answer: u32| if left_moves { (mine, answer) } else { (answer, mine) };
            let before = self.closure(system, other);
            for (label, target) in system.steps(mover) {
                let challenge = self.challenges.len() as u32;
                self.challenges.push(Challenge { pair, left_moves, label: *label, left: 0 });
                if *system.label(*label) == Label::Tau {
                    let stays = self.place(ordered(*target, other));
                    self.answer(challenge, [stays, stays]);
                }
                for middle in &before {
                    for (_, to) in system.after(*middle, *label) {
                        let made = self.place(ordered(*target, *to));
                        let waits = if *middle == other { made } else { self.place(ordered(mover, *middle)) };
                        self.answer(challenge, [made, waits]);
                    }
                }
            }
        }
    }

    fn answer(&mut self, challenge: u32, pairs: [u32; 2]) {
        let number = self.answers.len() as u32;
        self.answers.push(Answer { challenge, pairs, lost: false });
        self.challenges[challenge as usize].left += 1;
        self.part_of[pairs[0] as usize].push(number);
        if pairs[1] != pairs[0] {
            self.part_of[pairs[1] as usize].push(number);
        }
    }

    /// Gives each pair the round in which the last answer to one of its challenges is lost.
    fn spread(&mut self, mut level: Vec<u32>) {
        let unanswered = self.challenges.iter().enumerate().filter(|(_, challenge)| challenge.left == 0);
        let mut falling: Vec<u32> = unanswered.map(|(number, _)| number as u32).collect();
        let mut rank = 1;
        loop {
            for pair in std::mem::take(&mut level) {
                for answer in std::mem::take(&mut self.part_of[pair as usize]) {
                    let answer = &mut self.answers[answer as usize];
                    if std::mem::replace(&mut answer.lost, true) {
                        continue;
                    }
                    let challenge = &mut self.challenges[answer.challenge as usize];
                    challenge.left -= 1;
                    if challenge.left == 0 {
                        falling.push(answer.challenge);
                    }
                }
            }
            for challenge in std::mem::take(&mut falling) {
                let pair = self.challenges[challenge as usize].pair;
                let slot = &mut self.ranks[pair as usize];
                if slot.is_none() {
                    *slot = Some((rank, challenge));
                    level.push(pair);
                }
            }
            if level.is_empty() {
                return;
            }
            rank += 1;
        }
    }

    fn rank(&self, pair: u32) -> u32 {
        self.ranks[pair as usize].map_or(u32::MAX, |(rank, _)| rank)
    }

    /// The challenges with the answers that last longest.
    fn run(&self, system: &TransitionSystem) -> Option<(Vec<Played>, Difference)> {
        let mut by_challenge: HashMap<u32, Vec<&Answer>> = HashMap::new();
        for answer in &self.answers {
            by_challenge.entry(answer.challenge).or_default().push(answer);
        }
        let mut steps = Vec::new();
        let mut at = 0;
        loop {
            let (rank, number) = self.ranks[at as usize]?;
            let (one, two) = self.pairs[at as usize];
            if rank == 0 {
                let looks = |state| system.mark(state).clone();
                return Some((steps, Difference::Looks(looks(one), looks(two))));
            }
            let challenge = self.challenges.get(number as usize)?;
            let label = system.label(challenge.label).clone();
            let next = |answer: &&Answer| if self.rank(answer.pairs[1]) < self.rank(answer.pairs[0]) { 1 } else { 0 };
            let answers = by_challenge.get(&number).map_or(&[] as &[&Answer], Vec::as_slice);
            let Some(best) = answers.iter().copied().max_by_key(|answer| self.rank(answer.pairs[next(answer)])) else {
                return Some((steps, Difference::Step(challenge.left_moves, label)));
            };
            let waits = next(&best) == 1;
            at = best.pairs[usize::from(waits)];
            let (left, right) = self.pairs[at as usize];
            // Where the step is not made yet, only the other side has moved, by internal steps.
            let (left_moves, label) =
                if waits { (!challenge.left_moves, Label::Tau) } else { (challenge.left_moves, label) };
            steps.push(Played { left_moves, label, left, right });
        }
    }
}
