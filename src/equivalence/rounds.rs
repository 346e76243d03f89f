//! Partition refinement in rounds that are remembered: in round k two states part just when k steps tell them apart.
//!
//! In each round the signatures of the states whose successors moved to another block are computed anew, and of the
//! parts of a block all but the largest move (Blom and Orzan 2005, with the smaller half as in Paige and Tarjan).
//! Branching bisimilarity has the same rounds with other signatures; its systems must have no cycle of internal
//! steps, and their internal steps must lead to states with smaller numbers.

use std::collections::HashMap;
use std::rc::Rc;

use super::partition::Refinable;
use crate::transition_system::{Label, TransitionSystem};

type Signature = Rc<Vec<(u32, u32)>>;

/// Which steps count as steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Each.
    Strong,
    /// Each that is not internal within a block.
    Branching,
}

/// How the partition came to be.
pub(super) struct History {
    /// For each state the rounds in which it moved, and where to.
    moved: Vec<Vec<(u32, u32)>>,
    rounds: u32,
}

impl History {
    /// Refines by rounds until nothing changes, or until these two states are apart.
    pub(super) fn of(system: &TransitionSystem, kind: Kind, pair: Option<(u32, u32)>) -> History {
        let mut worker = Worker::new(system, kind);
        let mut changed: Vec<u32> = (0..system.states() as u32).collect();
        let apart =
            |worker: &Worker| pair.is_some_and(|(one, two)| worker.blocks.block(one) != worker.blocks.block(two));
        let mut rounds = 0;
        while !changed.is_empty() && !apart(&worker) {
            rounds += 1;
            let dirty = if rounds == 1 { changed } else { worker.dirty(&changed) };
            changed = worker.round(dirty, rounds);
        }
        History { moved: worker.moved, rounds }
    }

    /// The block of a state after this many rounds.
    pub(super) fn block(&self, state: u32, round: u32) -> u32 {
        let moved = &self.moved[state as usize];
        let at = moved.partition_point(|(when, _)| *when <= round);
        at.checked_sub(1).map_or(0, |at| moved[at].1)
    }

    /// The round in which two states part; none if they do not.
    pub(super) fn rank(&self, one: u32, two: u32) -> Option<u32> {
        let apart = |round| self.block(one, round) != self.block(two, round);
        if !apart(self.rounds) {
            return None;
        }
        let (mut low, mut high) = (0, self.rounds);
        while low < high {
            let middle = low + (high - low) / 2;
            if apart(middle) { high = middle } else { low = middle + 1 }
        }
        Some(low)
    }

    /// The last partition, numbered without gaps.
    pub(super) fn partition(&self) -> Vec<u32> {
        let mut number = HashMap::new();
        (0..self.moved.len() as u32)
            .map(|state| {
                let next = number.len() as u32;
                *number.entry(self.block(state, self.rounds)).or_insert(next)
            })
            .collect()
    }
}

struct Worker<'s> {
    system: &'s TransitionSystem,
    kind: Kind,
    tau: Option<u32>,
    blocks: Refinable,
    before: Vec<Vec<u32>>,
    signatures: Vec<Signature>,
    moved: Vec<Vec<(u32, u32)>>,
}

impl<'s> Worker<'s> {
    fn new(system: &'s TransitionSystem, kind: Kind) -> Worker<'s> {
        let states = system.states();
        let mut known: HashMap<u32, u32> = HashMap::new();
        let mut block = Vec::with_capacity(states);
        let mut before = vec![Vec::new(); states];
        for state in 0..states as u32 {
            let next = known.len() as u32;
            block.push(*known.entry(system.mark_number(state)).or_insert(next));
            for (_, to) in system.steps(state) {
                if before[*to as usize].last() != Some(&state) {
                    before[*to as usize].push(state);
                }
            }
        }
        let moved = block.iter().map(|block| vec![(0, *block)]).collect();
        Worker {
            system,
            kind,
            tau: system.label_number(&Label::Tau).filter(|_| kind == Kind::Branching),
            blocks: Refinable::new(block, known.len()),
            before,
            signatures: vec![Signature::default(); states],
            moved,
        }
    }

    /// The states whose signatures may have changed, in order, after these moved.
    fn dirty(&self, changed: &[u32]) -> Vec<u32> {
        let mut all: Vec<u32> = changed.iter().flat_map(|state| self.before[*state as usize].clone()).collect();
        if let Some(tau) = self.tau {
            all.extend(changed);
            let mut seen: std::collections::HashSet<u32> = all.iter().copied().collect();
            let mut open: Vec<u32> = seen.iter().copied().collect();
            while let Some(state) = open.pop() {
                for other in &self.before[state as usize] {
                    let inert = self.blocks.block(*other) == self.blocks.block(state)
                        && self.system.after(*other, tau).iter().any(|(_, to)| *to == state);
                    if inert && seen.insert(*other) {
                        open.push(*other);
                    }
                }
            }
            all = seen.into_iter().collect();
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    fn signature(&self, state: u32) -> Signature {
        let own = self.blocks.block(state);
        let mut all = Vec::new();
        for (label, to) in self.system.steps(state) {
            let block = self.blocks.block(*to);
            if self.kind == Kind::Branching && Some(*label) == self.tau && block == own {
                all.extend(self.signatures[*to as usize].iter().copied());
            } else {
                all.push((*label, block));
            }
        }
        all.sort_unstable();
        all.dedup();
        Rc::new(all)
    }

    /// One round; gives the states that moved to another block.
    fn round(&mut self, dirty: Vec<u32>, round: u32) -> Vec<u32> {
        for state in &dirty {
            self.signatures[*state as usize] = self.signature(*state);
        }
        for state in &dirty {
            self.blocks.mark(*state);
        }
        let mut leaving: Vec<Vec<u32>> = Vec::new();
        let touched = self.blocks.take_touched();
        for block in &touched {
            let rest = self.blocks.unmarked(*block).first().copied();
            let marked = self.blocks.size(*block) as usize - self.blocks.unmarked(*block).len();
            let mut groups: HashMap<Signature, Vec<u32>> = HashMap::new();
            for state in &self.blocks.members(*block)[..marked] {
                groups.entry(self.signatures[*state as usize].clone()).or_default().push(*state);
            }
            let unmarked = self.blocks.unmarked(*block).len();
            let resting = rest.map(|state| self.signatures[state as usize].clone());
            let joined = resting.as_ref().and_then(|signature| groups.remove(signature)).unwrap_or_default();
            let mut parts: Vec<Vec<u32>> = groups.into_values().collect();
            parts.sort_by(|one, two| (two.len(), one.iter().min()).cmp(&(one.len(), two.iter().min())));
            let stay = unmarked + joined.len();
            if parts.first().is_none_or(|largest| largest.len() <= stay) {
                leaving.extend(parts);
            } else {
                let mut others = joined;
                others.extend(self.blocks.unmarked(*block));
                leaving.extend(parts.into_iter().skip(1));
                if !others.is_empty() {
                    leaving.push(others);
                }
            }
        }
        for block in touched {
            self.blocks.clear(block);
        }
        let mut changed = Vec::new();
        for part in leaving {
            let old = self.blocks.block(part[0]);
            part.iter().for_each(|state| self.blocks.mark(*state));
            self.blocks.take_touched();
            let Some(new) = self.blocks.split(old, true) else { continue };
            for state in &part {
                self.moved[*state as usize].push((round, new));
            }
            changed.extend(part);
        }
        changed
    }
}
