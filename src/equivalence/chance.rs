//! Strong bisimilarity of processes that draw at random (Larsen and Skou 1991): two states are alike if their draws come
//! to each class of states with the same chance.
//!
//! A draw takes no step: a state in which one is due stands for its outcomes, and is in the class of these if they are all
//! in one. Classes are refined in rounds that are kept: in round k two states part just when k steps tell them apart.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_rational::BigRational;
use num_traits::One;

use super::evidence::{Difference, Found, Played, atom};
use super::formula::{Formulas, Node, Place};
use crate::transition_system::{Label, TransitionSystem};

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

/// How two states are told apart.
enum Plan {
    /// They look different.
    Looks,
    /// One side does this; the pairs are that step with each answer, the first that which lasts longest.
    Step { left_moves: bool, label: Label, next: Vec<(u32, u32)> },
    /// What tells an outcome from others has these chances.
    Draw { tell: Vec<(u32, u32)>, left: BigRational, right: BigRational },
}

type Plans = HashMap<(u32, u32), Plan>;

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

    fn draws(&self, (one, two): (u32, u32)) -> bool {
        [one, two].into_iter().any(|state| !self.outcomes[state as usize].is_empty())
    }

    /// Why two states differ; none if they do not.
    pub(super) fn evidence(&self, left: u32, right: u32) -> Option<Found> {
        let mut plans = Plans::new();
        let mut order = Vec::new();
        let mut open = vec![(left, right)];
        while let Some(pair) = open.pop() {
            if plans.contains_key(&pair) {
                continue;
            }
            let rank = self.rank(pair.0, pair.1)?;
            let plan = self.plan(pair, rank)?;
            if let Plan::Step { next, .. } | Plan::Draw { tell: next, .. } = &plan {
                open.extend(next);
            }
            // What a draw comes to is told apart in as many steps as the draw.
            order.push((rank, self.draws(pair), pair));
            plans.insert(pair, plan);
        }
        order.sort_unstable();
        let mut formulas = Formulas::default();
        formulas.draws = true;
        let mut places: HashMap<(u32, u32), Place> = HashMap::new();
        for (_, _, pair) in order {
            let part =
                |pairs: &[(u32, u32)]| pairs.iter().map(|pair| places.get(pair).copied()).collect::<Option<Vec<_>>>();
            let node = match plans.get(&pair)? {
                Plan::Looks => atom(self.system, pair),
                Plan::Step { left_moves: true, label, next } => {
                    let next = formulas.add(Node::And(part(next)?));
                    Node::Some(false, label.clone(), next)
                }
                Plan::Step { label, next, .. } => {
                    let next = formulas.add(Node::Or(part(next)?));
                    Node::All(false, label.clone(), next)
                }
                Plan::Draw { tell, left, .. } => {
                    let told = formulas.add(Node::And(part(tell)?));
                    Node::Chance(told, left.clone())
                }
            };
            places.insert(pair, formulas.add(node));
        }
        let root = *places.get(&(left, right))?;
        let (steps, difference) = self.run((left, right), &plans, &formulas, root, &places)?;
        Some(Found { formulas, root, holds_left: true, steps, difference })
    }

    fn plan(&self, pair: (u32, u32), rank: usize) -> Option<Plan> {
        if self.draws(pair) {
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
                next.sort_by_key(|pair| std::cmp::Reverse(self.rank(pair.0, pair.1)));
                return Some(Plan::Step { left_moves, label: self.system.label(*label).clone(), next });
            }
        }
        None
    }

    /// An outcome that is likelier on the left, and what tells it from all others.
    fn draw(&self, (one, two): (u32, u32), rank: usize) -> Option<Plan> {
        let class = self.rounds.get(rank)?;
        let (left, right) = (self.spread(class, one), self.spread(class, two));
        let chance = |side: &BTreeMap<u32, BigRational>, class: &u32| side.get(class).cloned().unwrap_or_default();
        let (likelier, most) = left.iter().find(|(class, most)| **most > chance(&right, class))?;
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
        Some(Plan::Draw { tell, left: most.clone(), right: chance(&right, likelier) })
    }

    /// The challenges with the answers that last longest, up to where the states look different or draw.
    fn run(
        &self,
        start: (u32, u32),
        plans: &Plans,
        formulas: &Formulas,
        root: Place,
        places: &HashMap<(u32, u32), Place>,
    ) -> Option<(Vec<Played>, Difference)> {
        let mut steps = Vec::new();
        let (mut pair, mut place) = (start, root);
        loop {
            match plans.get(&pair)? {
                Plan::Looks => {
                    let looks = |state| self.system.mark(state).clone();
                    return Some((steps, Difference::Looks(looks(pair.0), looks(pair.1))));
                }
                Plan::Draw { left, right, .. } => {
                    let Node::Chance(told, _) = formulas.node(place) else { return None };
                    return Some((steps, Difference::Chances(*told, left.clone(), right.clone())));
                }
                Plan::Step { left_moves, label, next } => {
                    let Some(longest) = next.first() else {
                        return Some((steps, Difference::Step(*left_moves, label.clone())));
                    };
                    (pair, place) = (*longest, *places.get(longest)?);
                    let (left, right) = pair;
                    steps.push(Played { left_moves: *left_moves, label: label.clone(), left, right });
                }
            }
        }
    }
}
