//! Simulation and refinement of processes that draw at random (Jonsson and Larsen 1991): the outcomes of one draw are
//! coupled with those of the other, so that all the chance stands on pairs that are related.
//!
//! There is no coupling just when some outcomes are likelier than all that they are related to (Strassen 1965): the cut
//! behind a greatest flow of chance through the pairs that are left. Pairs fall in rounds, which are their ranks.

use std::collections::{BTreeSet, HashMap, VecDeque};

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::pairs::Rule;
use super::told::{Pair, Plan, Told};
use crate::transition_system::TransitionSystem;

/// The bytes that a pair with its challenges takes, about.
const PAIR_BYTES: usize = 512;
/// The most pairs that are looked into.
const MOST_PAIRS: usize = 1_000_000;

/// A step of one side, and the pairs that it makes with each answer.
struct Challenge {
    left_moves: bool,
    label: u32,
    answers: Vec<u32>,
}

/// What a pair rests on.
enum Rests {
    /// Nothing more: it is related, or plainly not.
    Nothing,
    Steps(Vec<Challenge>),
    /// The chances of both sides, and the pairs of an outcome of the left, a row, with one of the right.
    Draw(Vec<BigRational>, Vec<BigRational>, Vec<Vec<u32>>),
}

/// The pairs that matter for one, each with the round in which it fell.
pub(super) struct Coupling<'s> {
    system: &'s TransitionSystem,
    places: HashMap<Pair, u32>,
    pairs: Vec<Pair>,
    rests: Vec<Rests>,
    ranks: Vec<Option<usize>>,
}

impl<'s> Coupling<'s> {
    /// Looks into all pairs that matter for this one.
    ///
    /// # Errors
    /// The number of pairs that were not enough.
    pub(super) fn of(
        system: &'s TransitionSystem,
        rule: Rule,
        start: Pair,
        bytes: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<Coupling<'s>, usize> {
        let most = MOST_PAIRS.min(bytes / PAIR_BYTES);
        let mut found =
            Coupling { system, places: HashMap::new(), pairs: Vec::new(), rests: Vec::new(), ranks: Vec::new() };
        found.place(start);
        let mut next = 0;
        while next < found.pairs.len() {
            if next >= most || (next % 1024 == 0 && stop()) {
                return Err(next);
            }
            let pair = found.pairs[next];
            let (rests, rank) = found.look(pair, rule);
            found.rests.push(rests);
            found.ranks[next] = rank;
            next += 1;
        }
        found.fall(stop)?;
        Ok(found)
    }

    fn place(&mut self, pair: Pair) -> u32 {
        let next = self.pairs.len() as u32;
        let place = *self.places.entry(pair).or_insert(next);
        if place == next {
            self.pairs.push(pair);
            self.ranks.push(None);
        }
        place
    }

    /// The outcomes of the draw that is due; a state that draws nothing is its own.
    fn outcomes(&self, state: u32) -> Vec<(BigRational, u32)> {
        let found: Vec<_> = self.system.chances(state).into_iter().map(|(chance, to)| (chance.clone(), to)).collect();
        if found.is_empty() { vec![(BigRational::one(), state)] } else { found }
    }

    fn draws(&self, state: u32) -> bool {
        !self.system.chances(state).is_empty()
    }

    fn look(&mut self, (one, two): Pair, rule: Rule) -> (Rests, Option<usize>) {
        if one == two {
            return (Rests::Nothing, None);
        }
        if self.draws(one) || self.draws(two) {
            let (left, right) = (self.outcomes(one), self.outcomes(two));
            let row = |found: &mut Self, from: u32| right.iter().map(|(_, to)| found.place((from, *to))).collect();
            let pairs = left.iter().map(|(_, from)| row(self, *from)).collect();
            let chances = |side: Vec<(BigRational, u32)>| side.into_iter().map(|(chance, _)| chance).collect();
            return (Rests::Draw(chances(left), chances(right), pairs), None);
        }
        if !rule.agrees(self.system.mark(one), self.system.mark(two)) {
            return (Rests::Nothing, Some(0));
        }
        let system = self.system;
        let mut challenges = Vec::new();
        for (label, to) in system.steps(one) {
            let answers = system.after(two, *label).iter().map(|(_, answer)| self.place((*to, *answer))).collect();
            challenges.push(Challenge { left_moves: true, label: *label, answers });
        }
        for (label, to) in system.steps(two).iter().filter(|_| rule.both()) {
            let answers = system.after(one, *label).iter().map(|(_, answer)| self.place((*answer, *to))).collect();
            challenges.push(Challenge { left_moves: false, label: *label, answers });
        }
        (Rests::Steps(challenges), None)
    }

    /// Lets pairs fall in rounds, until no more do.
    fn fall(&mut self, stop: &dyn Fn() -> bool) -> Result<(), usize> {
        let count = self.pairs.len();
        let mut users: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (place, rests) in self.rests.iter().enumerate() {
            let on: Vec<u32> = match rests {
                Rests::Nothing => Vec::new(),
                Rests::Steps(challenges) => challenges.iter().flat_map(|one| one.answers.clone()).collect(),
                Rests::Draw(_, _, rows) => rows.iter().flatten().copied().collect(),
            };
            on.into_iter().for_each(|on| users[on as usize].push(place as u32));
        }
        let mut round = 1;
        let mut tried: BTreeSet<u32> = (0..count as u32).collect();
        while !tried.is_empty() {
            if stop() {
                return Err(count);
            }
            let falls = |place: &u32| self.ranks[*place as usize].is_none() && self.lost(*place, round);
            let fallen: Vec<u32> = tried.iter().copied().filter(falls).collect();
            fallen.iter().for_each(|place| self.ranks[*place as usize] = Some(round));
            tried = fallen.iter().flat_map(|place| users[*place as usize].clone()).collect();
            round += 1;
        }
        Ok(())
    }

    /// Whether the pair had fallen before this round.
    fn gone(&self, place: u32, round: usize) -> bool {
        self.ranks[place as usize].is_some_and(|rank| rank < round)
    }

    fn lost(&self, place: u32, round: usize) -> bool {
        match &self.rests[place as usize] {
            Rests::Nothing => false,
            Rests::Steps(challenges) => {
                challenges.iter().any(|one| one.answers.iter().all(|answer| self.gone(*answer, round)))
            }
            Rests::Draw(left, right, rows) => {
                let open = |row: usize, column: usize| !self.gone(rows[row][column], round);
                uncoupled(left, right, &open).is_some()
            }
        }
    }
}

impl Told for Coupling<'_> {
    fn system(&self) -> &TransitionSystem {
        self.system
    }

    fn rank(&self, pair: Pair) -> Option<usize> {
        self.ranks[*self.places.get(&pair)? as usize]
    }

    fn plan(&self, pair: Pair, rank: usize) -> Option<Plan> {
        match &self.rests[*self.places.get(&pair)? as usize] {
            Rests::Nothing => Some(Plan::Looks),
            Rests::Steps(challenges) => {
                let won = challenges.iter().filter(|one| one.answers.iter().all(|answer| self.gone(*answer, rank)));
                let best = won.min_by_key(|one| one.answers.len())?;
                let mut answers = best.answers.clone();
                answers.sort_by_key(|answer| std::cmp::Reverse(self.ranks[*answer as usize]));
                let next = answers.iter().map(|answer| self.pairs[*answer as usize]).collect();
                let label = self.system.label(best.label).clone();
                Some(Plan::Step { left_moves: best.left_moves, label, next })
            }
            Rests::Draw(left, right, rows) => {
                let open = |row: usize, column: usize| !self.gone(rows[row][column], rank);
                let cut = uncoupled(left, right, &open)?;
                let beyond = |column: &usize| !cut.iter().any(|row| open(*row, *column));
                let others: Vec<usize> = (0..right.len()).filter(beyond).collect();
                let tell = |row: &usize| others.iter().map(|other| self.pairs[rows[*row][*other] as usize]).collect();
                let least = cut.iter().map(|row| left[*row].clone()).sum();
                Some(Plan::Draw { tell: cut.iter().map(tell).collect(), least })
            }
        }
    }
}

/// Outcomes of the left that are likelier than all that they are still related to; none if there is a coupling.
fn uncoupled(left: &[BigRational], right: &[BigRational], open: &dyn Fn(usize, usize) -> bool) -> Option<Vec<usize>> {
    let (rows, columns) = (left.len(), right.len());
    let mut flow = vec![vec![BigRational::zero(); columns]; rows];
    let (mut more, mut room) = (left.to_vec(), right.to_vec());
    loop {
        // Breadth first through rows that have chance left, forward over open pairs and back over flow.
        let mut came: Vec<Option<usize>> = vec![None; rows + columns];
        let mut seen: Vec<bool> = (0..rows + columns).map(|at| at < rows && !more[at].is_zero()).collect();
        let mut queue: VecDeque<usize> = (0..rows).filter(|row| seen[*row]).collect();
        let mut end = None;
        while let Some(at) = queue.pop_front() {
            if at >= rows && !room[at - rows].is_zero() {
                end = Some(at);
                break;
            }
            let next: Vec<usize> = if at < rows {
                (0..columns).filter(|column| open(at, *column)).map(|column| rows + column).collect()
            } else {
                (0..rows).filter(|row| !flow[*row][at - rows].is_zero()).collect()
            };
            for to in next {
                if !seen[to] {
                    seen[to] = true;
                    came[to] = Some(at);
                    queue.push_back(to);
                }
            }
        }
        let Some(end) = end else {
            let cut: Vec<usize> = (0..rows).filter(|row| seen[*row]).collect();
            return (!cut.is_empty()).then_some(cut);
        };
        push(&mut flow, &mut more, &mut room, &came, end);
    }
}

/// Sends as much as can go along the way to this column.
fn push(
    flow: &mut [Vec<BigRational>],
    more: &mut [BigRational],
    room: &mut [BigRational],
    came: &[Option<usize>],
    end: usize,
) {
    let rows = more.len();
    let mut way = vec![end];
    while let Some(before) = way.last().and_then(|at| came[*at]) {
        way.push(before);
    }
    way.reverse();
    let mut amount = more[way[0]].clone().min(room[end - rows].clone());
    for pair in way.windows(2).filter(|pair| pair[0] >= rows) {
        amount = amount.min(flow[pair[1]][pair[0] - rows].clone());
    }
    for pair in way.windows(2) {
        if pair[0] < rows {
            flow[pair[0]][pair[1] - rows] += &amount;
        } else {
            flow[pair[1]][pair[0] - rows] -= &amount;
        }
    }
    more[way[0]] -= &amount;
    room[end - rows] -= &amount;
}
