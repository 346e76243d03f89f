//! Why two states differ: a formula that holds of one alone, and a shortest run that tells them apart.
//!
//! A pair of rank k has a challenge, a step of one side all of whose answers are pairs of lower rank; the formula says
//! that there is such a step, or that there is none (Cleaveland 1990), and is made from those of the answers. Formulas
//! of states that earlier rounds could not tell apart are not repeated.

use std::collections::HashMap;

use num_rational::BigRational;

use super::formula::{Formulas, Node, Place};
use super::rounds::History;
use crate::transition_system::{Label, Mark, TransitionSystem};

/// One step of the separating run: who does what, and where both are then, by the states of the compared system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Played {
    /// Whether the left side moves, and the right side answers.
    pub(super) left_moves: bool,
    pub(super) label: Label,
    pub(super) left: u32,
    pub(super) right: u32,
}

/// What then differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    /// The states look different: the left, the right.
    Looks(Mark, Mark),
    /// The left side, if true, can do this, the other cannot.
    Step(bool, Label),
    /// The formula holds with these chances, on the left and on the right, once the draws that are due have been made.
    Chances(Place, BigRational, BigRational),
    /// The formula comes true with these greatest chances, on the left and on the right.
    Best(Place, BigRational, BigRational),
}

/// What is needed to tell two states apart, in a system whose states are classes of states.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) formulas: Formulas,
    /// Holds of one side only.
    pub(super) root: Place,
    /// Whether that is the left side.
    pub(super) holds_left: bool,
    pub(super) steps: Vec<Played>,
    pub(super) difference: Difference,
}

/// How a pair is told apart: by which step, and the pairs that are its answers.
struct Plan {
    left_moves: bool,
    label: Label,
    /// Pairs for the states before the step, which must be told from others on the way.
    hold: Vec<(u32, u32)>,
    /// Pairs for the states after the step.
    next: Vec<(u32, u32)>,
    /// The pair after the step that lasts longest.
    longest: Option<(u32, u32)>,
}

/// Where evidence comes from.
pub(super) trait Ranks {
    /// In how many steps the pair is told apart.
    fn rank(&self, one: u32, two: u32) -> Option<u32>;

    /// Whether a formula of this rank that tells the second from the first also tells the third, or the other way.
    fn covers(&self, _rank: u32, _known: u32, _other: u32) -> bool {
        false
    }
}

impl Ranks for History {
    fn rank(&self, one: u32, two: u32) -> Option<u32> {
        History::rank(self, one, two)
    }

    fn covers(&self, rank: u32, known: u32, other: u32) -> bool {
        self.block(known, rank) == self.block(other, rank)
    }
}

impl Ranks for super::pairs::Pairs {
    fn rank(&self, one: u32, two: u32) -> Option<u32> {
        super::pairs::Pairs::rank(self, one, two)
    }
}

/// A comparison that was lost.
pub(super) struct Lost<'a, R: Ranks> {
    pub(super) system: &'a TransitionSystem,
    pub(super) ranks: &'a R,
    /// Whether the right side may challenge.
    pub(super) both: bool,
    /// Whether the steps have internal steps around them.
    pub(super) weak: bool,
    /// Whether internal steps within a class do not count: the rounds are those of branching bisimilarity.
    pub(super) branching: Option<&'a History>,
    /// The most bytes for it.
    pub(super) bytes: usize,
}

/// The bytes that a pair takes that is told apart, with its formula and its step of the run, by the peak on chains.
const PAIR_BYTES: usize = 800;

impl<R: Ranks> Lost<'_, R> {
    /// The evidence; none if the pair has no rank, or where it takes too much memory.
    pub(super) fn evidence(&self, left: u32, right: u32) -> Option<Found> {
        let mut plans: HashMap<(u32, u32), Plan> = HashMap::new();
        let mut order: Vec<(u32, (u32, u32))> = Vec::new();
        let mut open = vec![(left, right)];
        while let Some(pair) = open.pop() {
            if plans.contains_key(&pair) {
                continue;
            }
            if plans.len() >= self.bytes / PAIR_BYTES {
                return None;
            }
            let rank = self.ranks.rank(pair.0, pair.1)?;
            let plan = if rank == 0 { Plan::nothing() } else { self.plan(pair, rank)? };
            open.extend(plan.hold.iter().chain(&plan.next).chain(&plan.longest).copied());
            order.push((rank, pair));
            plans.insert(pair, plan);
        }
        order.sort_unstable();
        let mut formulas = Formulas::default();
        let mut places: HashMap<(u32, u32), Place> = HashMap::new();
        for (rank, pair) in order {
            let plan = &plans[&pair];
            let place = if rank == 0 {
                formulas.add(atom(self.system, pair))
            } else {
                self.made(plan, &places, &mut formulas)?
            };
            places.insert(pair, place);
        }
        let root = *places.get(&(left, right))?;
        let (steps, difference) = self.run(left, right, &plans)?;
        Some(Found { formulas, root, holds_left: true, steps, difference })
    }

    fn made(&self, plan: &Plan, places: &HashMap<(u32, u32), Place>, formulas: &mut Formulas) -> Option<Place> {
        let parts =
            |pairs: &[(u32, u32)]| pairs.iter().map(|pair| places.get(pair).copied()).collect::<Option<Vec<_>>>();
        let (hold, next) = (parts(&plan.hold)?, parts(&plan.next)?);
        let label = plan.label.clone();
        if self.branching.is_some() {
            let (hold, next) = (formulas.add(Node::And(hold)), formulas.add(Node::And(next)));
            let until = formulas.add(Node::Until(hold, label, next));
            return Some(if plan.left_moves { until } else { formulas.add(Node::Not(until)) });
        }
        Some(if plan.left_moves {
            let next = formulas.add(Node::And(next));
            formulas.add(Node::Some(self.weak, label, next))
        } else {
            let next = formulas.add(Node::Or(next));
            formulas.add(Node::All(self.weak, label, next))
        })
    }

    fn plan(&self, pair: (u32, u32), rank: u32) -> Option<Plan> {
        if let Some(history) = self.branching {
            return branching_plan(self.system, history, pair, rank);
        }
        let (one, two) = pair;
        let mut best: Option<(usize, u64, Plan)> = None;
        let sides: &[bool] = if self.both { &[true, false] } else { &[true] };
        for left_moves in sides {
            let (mover, other) = if *left_moves { (one, two) } else { (two, one) };
            for (label, target) in self.system.steps(mover) {
                let answers = self.system.after(other, *label);
                if best.as_ref().is_some_and(|(count, ..)| *count == 0) {
                    break;
                }
                let pair_of = |to: u32| if *left_moves { (*target, to) } else { (to, *target) };
                let ranks: Option<Vec<u32>> = answers
                    .iter()
                    .map(|(_, to)| {
                        let (one, two) = pair_of(*to);
                        self.ranks.rank(one, two).filter(|found| *found < rank)
                    })
                    .collect();
                let Some(ranks) = ranks else { continue };
                let sum: u64 = ranks.iter().map(|rank| u64::from(*rank)).sum();
                if best.as_ref().is_none_or(|(count, least, _)| (answers.len(), sum) < (*count, *least)) {
                    let next = answers.iter().map(|(_, to)| pair_of(*to)).collect();
                    let label = self.system.label(*label).clone();
                    let longest = answers.iter().zip(&ranks).max_by_key(|(_, rank)| **rank);
                    let longest = longest.map(|((_, to), _)| pair_of(*to));
                    let plan = Plan { left_moves: *left_moves, label, hold: Vec::new(), next, longest };
                    best = Some((answers.len(), sum, plan));
                }
            }
        }
        let (_, _, mut plan) = best?;
        plan.next = self.needed(plan.next, plan.left_moves);
        Some(plan)
    }

    /// Those of the pairs whose formulas do for all. The pairs share their left state, or their right one.
    fn needed(&self, pairs: Vec<(u32, u32)>, left_shared: bool) -> Vec<(u32, u32)> {
        let mut ranked: Vec<(u32, (u32, u32))> =
            pairs.into_iter().map(|pair| (self.ranks.rank(pair.0, pair.1).unwrap_or(0), pair)).collect();
        ranked.sort_unstable();
        ranked.dedup();
        let mut kept: Vec<(u32, (u32, u32))> = Vec::new();
        for (rank, pair) in ranked {
            let own = |pair: (u32, u32)| if left_shared { pair.1 } else { pair.0 };
            if !kept.iter().any(|(lower, known)| self.ranks.covers(*lower, own(*known), own(pair))) {
                kept.push((rank, pair));
            }
        }
        kept.into_iter().map(|(_, pair)| pair).collect()
    }

    /// The challenges with the answers that last longest.
    fn run(&self, left: u32, right: u32, plans: &HashMap<(u32, u32), Plan>) -> Option<(Vec<Played>, Difference)> {
        let mut steps = Vec::new();
        let mut pair = (left, right);
        // Whether the pair has the right side first.
        let mut turned = false;
        loop {
            let plan = plans.get(&pair)?;
            if self.ranks.rank(pair.0, pair.1)? == 0 {
                let looks = |state| self.system.mark(state).clone();
                let (left, right) = if turned { (pair.1, pair.0) } else { pair };
                return Some((steps, Difference::Looks(looks(left), looks(right))));
            }
            let left_moves = plan.left_moves != turned;
            let Some(next) = plan.longest else {
                return Some((steps, Difference::Step(left_moves, plan.label.clone())));
            };
            pair = next;
            turned ^= self.branching.is_some() && !plan.left_moves;
            let (left, right) = if turned { (pair.1, pair.0) } else { pair };
            steps.push(Played { left_moves, label: plan.label.clone(), left, right });
        }
    }
}

/// What holds of the first alone at once.
pub(super) fn atom(system: &TransitionSystem, (one, two): (u32, u32)) -> Node {
    let (one, two) = (system.mark(one), system.mark(two));
    if one.ending != two.ending {
        return Node::Ends(one.ending.clone());
    }
    match (two.shown.difference(&one.shown).next(), one.shown.difference(&two.shown).next()) {
        (Some(more), _) => Node::Hides(more.clone()),
        (None, Some(more)) => Node::Shows(more.clone()),
        (None, None) => Node::False,
    }
}

impl Plan {
    fn nothing() -> Plan {
        Plan { left_moves: true, label: Label::Tau, hold: Vec::new(), next: Vec::new(), longest: None }
    }
}

/// The step that one side can take after internal steps within its class, and the other cannot. The pairs of a plan of
/// the right side have the right side first.
fn branching_plan(system: &TransitionSystem, history: &History, (one, two): (u32, u32), rank: u32) -> Option<Plan> {
    let before = rank - 1;
    let block = |state: u32| history.block(state, before);
    // The states within the class after internal steps, and those just outside.
    let around = |start: u32| {
        let own = block(start);
        let (mut inside, mut outside) = (vec![start], Vec::new());
        let mut seen = std::collections::HashSet::from([start]);
        let mut next = 0;
        while next < inside.len() {
            for to in system.internal(inside[next]) {
                if seen.insert(to) {
                    if block(to) == own { inside.push(to) } else { outside.push(to) }
                }
            }
            next += 1;
        }
        (inside, outside)
    };
    for left_moves in [true, false] {
        let (mover, other) = if left_moves { (one, two) } else { (two, one) };
        let (own, _) = around(mover);
        let (inside, outside) = around(other);
        for state in own {
            for (label, target) in system.steps(state) {
                let internal = *system.label(*label) == Label::Tau;
                if internal && block(*target) == block(mover) {
                    continue;
                }
                let answers: Vec<u32> =
                    inside.iter().flat_map(|state| system.after(*state, *label).iter().map(|(_, to)| *to)).collect();
                if answers.iter().any(|to| block(*to) == block(*target)) {
                    continue;
                }
                let pairs = |from: u32, all: Vec<u32>| {
                    let mut kept: Vec<(u32, (u32, u32))> = Vec::new();
                    let mut ranked: Vec<(u32, u32)> =
                        all.into_iter().filter_map(|to| Some((History::rank(history, from, to)?, to))).collect();
                    ranked.sort_unstable();
                    for (rank, to) in ranked {
                        if !kept.iter().any(|(lower, (_, known))| history.covers(*lower, *known, to)) {
                            kept.push((rank, (from, to)));
                        }
                    }
                    kept.into_iter().map(|(_, pair)| pair).collect::<Vec<_>>()
                };
                let stay = internal.then_some(other);
                let answers: Vec<u32> = answers.into_iter().chain(stay).collect();
                let longest = answers.iter().max_by_key(|to| history.rank(*target, **to)).map(|to| (*target, *to));
                let next = pairs(*target, answers);
                let label = system.label(*label).clone();
                return Some(Plan { left_moves, label, hold: pairs(mover, outside), next, longest });
            }
        }
    }
    None
}
