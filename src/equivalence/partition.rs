//! The coarsest stable partition: strong bisimilarity in O(m log n) time and O(m + n) space.
//!
//! Paige and Tarjan (1987), for labelled transitions as in Valmari (2009): a block is split against the smaller part
//! of what used to be one set. For each state, label and set of states that stands together, a counter says how many
//! transitions lead there, so that a state that leads to both parts is told from one that leads to the smaller alone.

use std::collections::HashMap;

use crate::transition_system::TransitionSystem;

/// Blocks that can be split in time proportional to the part that is marked.
pub(super) struct Refinable {
    members: Vec<u32>,
    place: Vec<u32>,
    block: Vec<u32>,
    first: Vec<u32>,
    end: Vec<u32>,
    /// Members before this place are marked.
    middle: Vec<u32>,
    touched: Vec<u32>,
}

impl Refinable {
    /// The blocks as given: numbered from 0 without gaps.
    pub(super) fn new(block: Vec<u32>, count: usize) -> Refinable {
        let mut first = vec![0u32; count + 1];
        for block in &block {
            first[*block as usize + 1] += 1;
        }
        for index in 1..=count {
            first[index] += first[index - 1];
        }
        let end: Vec<u32> = first[1..].to_vec();
        first.pop();
        let mut next = first.clone();
        let mut members = vec![0u32; block.len()];
        let mut place = vec![0u32; block.len()];
        for (state, block) in block.iter().enumerate() {
            let at = &mut next[*block as usize];
            members[*at as usize] = state as u32;
            place[state] = *at;
            *at += 1;
        }
        Refinable { members, place, block, middle: first.clone(), first, end, touched: Vec::new() }
    }

    pub(super) fn count(&self) -> usize {
        self.first.len()
    }

    pub(super) fn block(&self, state: u32) -> u32 {
        self.block[state as usize]
    }

    pub(super) fn size(&self, block: u32) -> u32 {
        self.end[block as usize] - self.first[block as usize]
    }

    pub(super) fn members(&self, block: u32) -> &[u32] {
        &self.members[self.first[block as usize] as usize..self.end[block as usize] as usize]
    }

    /// The members that are not marked.
    pub(super) fn unmarked(&self, block: u32) -> &[u32] {
        &self.members[self.middle[block as usize] as usize..self.end[block as usize] as usize]
    }

    pub(super) fn mark(&mut self, state: u32) {
        let block = self.block[state as usize] as usize;
        let (at, middle) = (self.place[state as usize], self.middle[block]);
        if at < middle {
            return;
        }
        if middle == self.first[block] {
            self.touched.push(block as u32);
        }
        let other = self.members[middle as usize];
        self.members.swap(at as usize, middle as usize);
        self.place[state as usize] = middle;
        self.place[other as usize] = at;
        self.middle[block] += 1;
    }

    /// Takes all marks off a block that is no longer noted as touched.
    pub(super) fn clear(&mut self, block: u32) {
        self.middle[block as usize] = self.first[block as usize];
    }

    /// The blocks with marks, which are forgotten as touched but keep their marks until they are split.
    pub(super) fn take_touched(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.touched)
    }

    /// Parts the marked members of a block from the others; gives the new block, which is the smaller part, or the
    /// marked one if `marked_leaves`. None if all or none are marked. The marks are gone.
    pub(super) fn split(&mut self, block: u32, marked_leaves: bool) -> Option<u32> {
        let place = block as usize;
        let (first, middle, end) = (self.first[place], self.middle[place], self.end[place]);
        self.middle[place] = first;
        if middle == first || middle == end {
            return None;
        }
        let new = self.first.len() as u32;
        let (from, to) = if marked_leaves || middle - first <= end - middle {
            self.first[place] = middle;
            (first, middle)
        } else {
            self.end[place] = middle;
            (middle, end)
        };
        self.middle[place] = self.first[place];
        self.first.push(from);
        self.middle.push(from);
        self.end.push(to);
        for state in &self.members[from as usize..to as usize] {
            self.block[*state as usize] = new;
        }
        Some(new)
    }

    pub(super) fn into_blocks(self) -> Vec<u32> {
        self.block
    }
}

/// For each state the transitions into it, as places in the order of all transitions.
struct Incoming {
    first: Vec<u32>,
    transitions: Vec<u32>,
    from: Vec<u32>,
}

impl Incoming {
    fn of(system: &TransitionSystem) -> Incoming {
        let states = system.states();
        let mut first = vec![0u32; states + 1];
        let mut from = Vec::with_capacity(system.transitions());
        for state in 0..states as u32 {
            for (_, to) in system.steps(state) {
                first[*to as usize + 1] += 1;
                from.push(state);
            }
        }
        for index in 1..=states {
            first[index] += first[index - 1];
        }
        let mut next = first.clone();
        let mut transitions = vec![0u32; from.len()];
        let mut place = 0u32;
        for state in 0..states as u32 {
            for (_, to) in system.steps(state) {
                let at = &mut next[*to as usize];
                transitions[*at as usize] = place;
                *at += 1;
                place += 1;
            }
        }
        Incoming { first, transitions, from }
    }

    fn arriving(&self, state: u32) -> &[u32] {
        &self.transitions[self.first[state as usize] as usize..self.first[state as usize + 1] as usize]
    }
}

/// The block of each state: states are in one block just when they are strongly bisimilar, marks included.
pub fn strong_partition(system: &TransitionSystem) -> Vec<u32> {
    Worker::new(system).run()
}

struct Worker<'s> {
    system: &'s TransitionSystem,
    incoming: Incoming,
    blocks: Refinable,
    /// The set that each block belongs to, and the blocks of each set: blocks are stable against whole sets.
    set_of: Vec<u32>,
    sets: Vec<Vec<u32>>,
    waiting: Vec<u32>,
    /// For each transition its counter: transitions of one state with one label into one set share it.
    counter: Vec<u32>,
    counts: Vec<u32>,
    free: Vec<u32>,
    by_label: Vec<Vec<u32>>,
    /// For each state the old and the new counter of the round in which it was met last.
    met: Vec<(u32, u32, u32)>,
    round: u32,
}

impl<'s> Worker<'s> {
    fn new(system: &'s TransitionSystem) -> Worker<'s> {
        let states = system.states();
        let mut known: HashMap<(u32, Vec<u32>), u32> = HashMap::new();
        let mut block = Vec::with_capacity(states);
        let mut counter = Vec::with_capacity(system.transitions());
        let mut counts = Vec::new();
        for state in 0..states as u32 {
            let mut labels: Vec<u32> = Vec::new();
            for (label, _) in system.steps(state) {
                if labels.last() != Some(label) {
                    labels.push(*label);
                    counts.push(0);
                }
                let last = counts.len() - 1;
                counts[last] += 1;
                counter.push(last as u32);
            }
            let next = known.len() as u32;
            block.push(*known.entry((system.mark_number(state), labels)).or_insert(next));
        }
        let blocks = Refinable::new(block, known.len());
        Worker {
            system,
            incoming: Incoming::of(system),
            set_of: vec![0; blocks.count()],
            sets: vec![(0..blocks.count() as u32).collect()],
            waiting: vec![0],
            blocks,
            counter,
            counts,
            free: Vec::new(),
            by_label: vec![Vec::new(); system.labels().len()],
            met: vec![(0, 0, 0); states],
            round: 0,
        }
    }

    fn run(mut self) -> Vec<u32> {
        let labels: Vec<u32> = (0..self.system.states() as u32)
            .flat_map(|state| self.system.steps(state).iter().map(|(label, _)| *label))
            .collect();
        while let Some(set) = self.waiting.pop() {
            let Some(splitter) = self.smaller(set) else { continue };
            let mut used = Vec::new();
            for state in self.blocks.members(splitter) {
                for transition in self.incoming.arriving(*state) {
                    let label = labels[*transition as usize];
                    let list = &mut self.by_label[label as usize];
                    if list.is_empty() {
                        used.push(label);
                    }
                    list.push(*transition);
                }
            }
            for label in used {
                let list = std::mem::take(&mut self.by_label[label as usize]);
                self.against(&list);
                let mut list = list;
                list.clear();
                self.by_label[label as usize] = list;
            }
        }
        self.blocks.into_blocks()
    }

    /// Takes the smaller of two blocks of a set out of it, as a set of its own.
    fn smaller(&mut self, set: u32) -> Option<u32> {
        let list = &mut self.sets[set as usize];
        let (one, two) = (list.len().checked_sub(2)?, list.len() - 1);
        let at = if self.blocks.size(list[one]) < self.blocks.size(list[two]) { one } else { two };
        let splitter = list.swap_remove(at);
        if list.len() > 1 {
            self.waiting.push(set);
        }
        self.set_of[splitter as usize] = self.sets.len() as u32;
        self.sets.push(vec![splitter]);
        Some(splitter)
    }

    /// Splits all blocks by whether their states have one of these transitions, and whether they have none else with
    /// the label into the set from which the splitter came.
    fn against(&mut self, transitions: &[u32]) {
        self.round += 1;
        let mut sources = Vec::new();
        for transition in transitions {
            let source = self.incoming.from[*transition as usize];
            let old = self.counter[*transition as usize];
            if self.met[source as usize].0 != self.round {
                let new = match self.free.pop() {
                    Some(new) => new,
                    None => {
                        self.counts.push(0);
                        self.counts.len() as u32 - 1
                    }
                };
                self.met[source as usize] = (self.round, old, new);
                sources.push(source);
            }
            let new = self.met[source as usize].2;
            self.counts[old as usize] -= 1;
            self.counts[new as usize] += 1;
            self.counter[*transition as usize] = new;
        }
        for source in &sources {
            self.blocks.mark(*source);
        }
        self.split();
        for source in &sources {
            let old = self.met[*source as usize].1;
            if self.counts[old as usize] == 0 {
                self.blocks.mark(*source);
                self.free.push(old);
            }
        }
        self.split();
    }

    fn split(&mut self) {
        for block in self.blocks.take_touched() {
            if self.blocks.split(block, false).is_some() {
                let set = self.set_of[block as usize];
                let new = self.set_of.len() as u32;
                self.set_of.push(set);
                let list = &mut self.sets[set as usize];
                list.push(new);
                if list.len() == 2 {
                    self.waiting.push(set);
                }
            }
        }
    }
}
