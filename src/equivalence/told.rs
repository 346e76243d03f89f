//! From how pairs of states are told apart, where draws count, to a formula and a shortest run.

use std::collections::HashMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::evidence::{Difference, Found, Played, atom};
use super::formula::{Formulas, Node, Place};
use super::judge::Judge;
use crate::transition_system::{Label, TransitionSystem};

/// A state of the left side with one of the right.
pub(super) type Pair = (u32, u32);

/// How two states are told apart.
pub(super) enum Plan {
    /// They look different.
    Looks,
    /// One side does this; the pairs are that step with each answer, the first that which lasts longest.
    Step { left_moves: bool, label: Label, next: Vec<Pair> },
    /// Some outcomes, each told from others by these pairs, have at least this chance on the left alone.
    Draw { tell: Vec<Vec<Pair>>, least: BigRational },
}

impl Plan {
    fn pairs(&self) -> Vec<Pair> {
        match self {
            Plan::Looks => Vec::new(),
            Plan::Step { next, .. } => next.clone(),
            Plan::Draw { tell, .. } => tell.iter().flatten().copied().collect(),
        }
    }
}

/// A comparison that was lost.
pub(super) trait Told {
    /// The system that both states are of.
    fn system(&self) -> &TransitionSystem;

    /// In how many steps the pair is told apart; none if it is not.
    fn rank(&self, pair: Pair) -> Option<usize>;

    /// How the pair of this rank is told apart: by pairs of lower rank, a draw by outcomes of at most its own.
    fn plan(&self, pair: Pair, rank: usize) -> Option<Plan>;

    /// Why the two differ; none if they do not.
    fn evidence(&self, start: Pair) -> Option<Found> {
        let system = self.system();
        let draws = |(one, two): Pair| [one, two].into_iter().any(|state| !system.chances(state).is_empty());
        let mut plans: HashMap<Pair, Plan> = HashMap::new();
        let mut order = Vec::new();
        let mut open = vec![start];
        while let Some(pair) = open.pop() {
            if plans.contains_key(&pair) {
                continue;
            }
            let rank = self.rank(pair)?;
            let plan = self.plan(pair, rank)?;
            open.extend(plan.pairs());
            order.push((rank, draws(pair), pair));
            plans.insert(pair, plan);
        }
        order.sort_unstable();
        let mut writer = Writer { system, formulas: Formulas::default(), places: HashMap::new() };
        writer.formulas.draws = true;
        for (_, _, pair) in order {
            let node = writer.node(pair, plans.get(&pair)?)?;
            let place = writer.formulas.add(node);
            writer.places.insert(pair, place);
        }
        let root = *writer.places.get(&start)?;
        let (steps, difference) = writer.run(start, &plans)?;
        Some(Found { formulas: writer.formulas, root, holds_left: true, steps, difference })
    }
}

/// The decimal number with the fewest places that lies strictly between two numbers; none if nothing does.
pub(super) fn between(low: &BigRational, high: &BigRational) -> Option<BigRational> {
    let mut scale = BigRational::from_integer(10.into());
    if low >= high {
        return None;
    }
    loop {
        let number = ((low * &scale).floor() + BigRational::one()) / &scale;
        if number < *high {
            return Some(number);
        }
        scale *= BigRational::from_integer(10.into());
    }
}

struct Writer<'s> {
    system: &'s TransitionSystem,
    formulas: Formulas,
    places: HashMap<Pair, Place>,
}

impl Writer<'_> {
    fn parts(&self, pairs: &[Pair]) -> Option<Vec<Place>> {
        pairs.iter().map(|pair| self.places.get(pair).copied()).collect()
    }

    fn node(&mut self, pair: Pair, plan: &Plan) -> Option<Node> {
        Some(match plan {
            Plan::Looks => atom(self.system, pair),
            Plan::Step { left_moves: true, label, next } => {
                let next = Node::And(self.parts(next)?);
                Node::Some(false, label.clone(), self.formulas.add(next))
            }
            Plan::Step { label, next, .. } => {
                let next = Node::Or(self.parts(next)?);
                Node::All(false, label.clone(), self.formulas.add(next))
            }
            Plan::Draw { tell, least } => {
                let told = self.outcomes(tell)?;
                let least = if self.system.slack.is_zero() { least.clone() } else { self.between(told, pair)? };
                Node::Chance(told, least)
            }
        })
    }

    fn outcomes(&mut self, tell: &[Vec<Pair>]) -> Option<Place> {
        let mut parts = Vec::new();
        for pairs in tell {
            let all = Node::And(self.parts(pairs)?);
            parts.push(self.formulas.add(all));
        }
        Some(self.formulas.add(Node::Or(parts)))
    }

    /// The chances of the formula on both sides.
    fn chances(&self, told: Place, (left, right): Pair) -> Option<(BigRational, BigRational)> {
        let mut judge = Judge::new(self.system);
        let (left, right) = (judge.number(&left), judge.number(&right));
        let left = judge.chance(&self.formulas, told, left).ok()?;
        Some((left, judge.chance(&self.formulas, told, right).ok()?))
    }

    /// A number that lies between the chances of both sides, which are known only up to some error.
    fn between(&self, told: Place, pair: Pair) -> Option<BigRational> {
        let (left, right) = self.chances(told, pair)?;
        between(&(right + &self.system.slack), &(left - &self.system.slack))
    }

    /// The challenges with the answers that last longest, up to where the states look different or draw.
    fn run(&mut self, start: Pair, plans: &HashMap<Pair, Plan>) -> Option<(Vec<Played>, Difference)> {
        let mut steps = Vec::new();
        let mut pair = start;
        loop {
            match plans.get(&pair)? {
                Plan::Looks => {
                    let looks = |state| self.system.mark(state).clone();
                    return Some((steps, Difference::Looks(looks(pair.0), looks(pair.1))));
                }
                Plan::Draw { tell, .. } => {
                    let told = self.outcomes(tell)?;
                    let (left, right) = self.chances(told, pair)?;
                    return Some((steps, Difference::Chances(told, left, right)));
                }
                Plan::Step { left_moves, label, next } => {
                    let Some(longest) = next.first() else {
                        return Some((steps, Difference::Step(*left_moves, label.clone())));
                    };
                    pair = *longest;
                    let (left, right) = pair;
                    steps.push(Played { left_moves: *left_moves, label: label.clone(), left, right });
                }
            }
        }
    }
}
