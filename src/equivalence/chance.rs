//! Strong bisimilarity of processes that draw at random (Larsen and Skou 1991): two states are alike if their draws come
//! to each class of states with the same chance.
//!
//! A draw takes no step: a state in which one is due stands for its outcomes, and is in the class of these if they are all
//! in one. Classes are refined in rounds that are kept: in round k two states part just when k steps tell them apart.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_rational::BigRational;
use num_traits::One;

use super::told::{Pair, Plan, Told};
use crate::transition_system::TransitionSystem;

/// What a class is made of.
#[derive(PartialEq, Eq, Hash)]
enum Kind {
    Looks(u32),
    Does(u32, Vec<(u32, u32)>),
    Draws(Vec<(u32, BigRational)>),
}

/// The classes of each round.
pub(super) struct Chances<'s> {
    system: &'s TransitionSystem,
    /// The outcomes of the draw of each state; empty where it draws nothing.
    outcomes: Vec<Vec<(BigRational, u32)>>,
    rounds: Vec<Vec<u32>>,
}

impl<'s> Chances<'s> {
    /// Refines until nothing changes, or until these two are apart; none where the rounds take more bytes than this.
    pub(super) fn of(system: &'s TransitionSystem, pair: Option<(u32, u32)>, bytes: usize) -> Option<Chances<'s>> {
        let states = 0..system.states() as u32;
        let owned = |state: u32| {
            let outcomes = system.chances(state).into_iter();
            outcomes.map(|(chance, to)| (chance.clone(), to)).collect::<Vec<_>>()
        };
        let mut found = Chances { system, outcomes: states.map(owned).collect(), rounds: Vec::new() };
        let mut before = 0;
        loop {
            let classes = found.round();
            let count = classes.iter().max().map_or(0, |most| *most as usize + 1);
            found.rounds.push(classes);
            let apart = pair.is_some_and(|(one, two)| found.last(one) != found.last(two));
            if apart || count == before {
                return Some(found);
            }
            if found.rounds.len().saturating_mul(4 * system.states()) > bytes {
                return None;
            }
            before = count;
        }
    }

    /// The classes of the next round.
    fn round(&self) -> Vec<u32> {
        let mut known: HashMap<Kind, u32> = HashMap::new();
        let mut class = vec![0; self.system.states()];
        let mut number = |kind: Kind| {
            let next = known.len() as u32;
            *known.entry(kind).or_insert(next)
        };
        let draws = |state: &u32| !self.outcomes[*state as usize].is_empty();
        let states = 0..self.system.states() as u32;
        for state in states.clone().filter(|state| !draws(state)) {
            class[state as usize] = number(match self.rounds.last() {
                None => Kind::Looks(self.system.mark_number(state)),
                Some(last) => {
                    let steps = self.system.steps(state).iter();
                    let steps: BTreeSet<(u32, u32)> = steps.map(|(label, to)| (*label, last[*to as usize])).collect();
                    Kind::Does(last[state as usize], steps.into_iter().collect())
                }
            });
        }
        // What a draw comes to draws nothing more.
        for state in states.filter(draws) {
            let spread = self.spread(&class, state);
            class[state as usize] = match spread.iter().next() {
                Some((only, _)) if spread.len() == 1 => *only,
                _ => number(Kind::Draws(spread.into_iter().collect())),
            };
        }
        class
    }

    /// The chance of each class once the draws that are due have been made.
    fn spread(&self, class: &[u32], state: u32) -> BTreeMap<u32, BigRational> {
        let mut all: BTreeMap<u32, BigRational> = BTreeMap::new();
        for (chance, to) in &self.outcomes[state as usize] {
            *all.entry(class[*to as usize]).or_default() += chance;
        }
        if all.is_empty() {
            all.insert(class[state as usize], BigRational::one());
        }
        all
    }

    fn last(&self, state: u32) -> Option<u32> {
        self.rounds.last().and_then(|classes| classes.get(state as usize)).copied()
    }

    /// The last classes.
    pub(super) fn classes(self) -> Vec<u32> {
        self.rounds.into_iter().next_back().unwrap_or_default()
    }

    /// In how many steps two states are told apart; none if they are not.
    pub(super) fn rank(&self, one: u32, two: u32) -> Option<usize> {
        let apart = |classes: &Vec<u32>| classes[one as usize] != classes[two as usize];
        let rank = self.rounds.partition_point(|classes| !apart(classes));
        (rank < self.rounds.len()).then_some(rank)
    }

    /// An outcome that is likelier on the left, and what tells it from all others.
    fn draw(&self, (one, two): (u32, u32), rank: usize) -> Option<Plan> {
        let class = self.rounds.get(rank)?;
        let (left, right) = (self.spread(class, one), self.spread(class, two));
        let chance = |class: &u32| right.get(class).cloned().unwrap_or_default();
        let (likelier, most) = left.iter().find(|(class, most)| **most > chance(class))?;
        let mut members: BTreeMap<u32, u32> = BTreeMap::new();
        for state in [one, two] {
            let outcomes = &self.outcomes[state as usize];
            let all = outcomes.iter().map(|(_, to)| *to).chain(outcomes.is_empty().then_some(state));
            all.for_each(|state| {
                members.entry(class[state as usize]).or_insert(state);
            });
        }
        let own = *members.get(likelier)?;
        let others = members.iter().filter(|(class, _)| *class != likelier);
        let tell = others.map(|(_, other)| (own, *other)).collect();
        Some(Plan::Draw { tell: vec![tell], least: most.clone() })
    }
}

impl Told for Chances<'_> {
    fn system(&self) -> &TransitionSystem {
        self.system
    }

    fn rank(&self, (one, two): Pair) -> Option<usize> {
        Chances::rank(self, one, two)
    }

    fn plan(&self, pair: Pair, rank: usize) -> Option<Plan> {
        if [pair.0, pair.1].into_iter().any(|state| !self.outcomes[state as usize].is_empty()) {
            return self.draw(pair, rank);
        }
        let Some(last) = rank.checked_sub(1).and_then(|before| self.rounds.get(before)) else {
            return Some(Plan::Looks);
        };
        for left_moves in [true, false] {
            let (mover, other) = if left_moves { pair } else { (pair.1, pair.0) };
            for (label, to) in self.system.steps(mover) {
                let answers = self.system.after(other, *label);
                if answers.iter().any(|(_, answer)| last[*answer as usize] == last[*to as usize]) {
                    continue;
                }
                let turned = |answer: u32| if left_moves { (*to, answer) } else { (answer, *to) };
                let mut next: Vec<(u32, u32)> = answers.iter().map(|(_, answer)| turned(*answer)).collect();
                next.sort_by_key(|pair| std::cmp::Reverse(Chances::rank(self, pair.0, pair.1)));
                return Some(Plan::Step { left_moves, label: self.system.label(*label).clone(), next });
            }
        }
        None
    }
}
