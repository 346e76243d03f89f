//! The relations by their definitions, as greatest fixpoints over all pairs of states and sets of states.

#![allow(dead_code)]

use std::collections::{BTreeSet, HashSet};

use pars::equivalence::Preorder;
use pars::transition_system::{Label, Mark, TransitionSystem};

type Pairs = HashSet<(u32, u32)>;

/// Signatures of signatures until nothing changes.
pub fn partition(system: &TransitionSystem) -> Vec<usize> {
    let mut block: Vec<usize> = (0..system.states() as u32).map(|state| system.mark_number(state) as usize).collect();
    loop {
        let signature = |state: usize| {
            let steps = system.steps(state as u32).iter();
            (block[state], steps.map(|(label, to)| (*label, block[*to as usize])).collect::<BTreeSet<_>>())
        };
        let all: Vec<_> = (0..system.states()).map(signature).collect();
        let mut known: Vec<_> = all.clone();
        known.sort();
        known.dedup();
        let next: Vec<usize> = all.iter().map(|one| known.iter().position(|other| other == one).unwrap()).collect();
        let size = |block: &[usize]| block.iter().collect::<HashSet<_>>().len();
        if size(&next) == size(&block) {
            return next;
        }
        block = next;
    }
}

struct World {
    system: TransitionSystem,
}

impl World {
    fn after(&self, state: u32, label: &Label) -> Vec<u32> {
        if *label == shown_label() {
            return if self.shows(state) { vec![state] } else { Vec::new() };
        }
        self.system.steps(state).iter().filter(|(l, _)| self.system.label(*l) == label).map(|(_, to)| *to).collect()
    }

    fn shows(&self, state: u32) -> bool {
        self.system.internal(state).next().is_none() && !self.system.mark(state).shown.is_empty()
    }

    fn labels(&self, weak: bool) -> Vec<Label> {
        let mut all = self.system.labels().to_vec();
        if weak {
            all.push(shown_label());
            all.push(Label::Tau);
        }
        all
    }

    fn internal(&self, state: u32) -> BTreeSet<u32> {
        let mut all = BTreeSet::from([state]);
        loop {
            let more: BTreeSet<u32> = all.iter().flat_map(|state| self.after(*state, &Label::Tau)).collect();
            let size = all.len();
            all.extend(more);
            if all.len() == size {
                return all;
            }
        }
    }

    fn weakly(&self, state: u32, label: &Label) -> BTreeSet<u32> {
        let before = self.internal(state);
        if *label == Label::Tau {
            return before;
        }
        let middle: BTreeSet<u32> = before.iter().flat_map(|state| self.after(*state, label)).collect();
        middle.iter().flat_map(|state| self.internal(*state)).collect()
    }

    /// The greatest set of pairs in which every pair passes the test.
    fn greatest(&self, test: impl Fn(&Pairs, u32, u32) -> bool) -> Pairs {
        let states = self.system.states() as u32;
        let mut pairs: Pairs = (0..states).flat_map(|one| (0..states).map(move |two| (one, two))).collect();
        loop {
            let next: Pairs = pairs.iter().copied().filter(|(one, two)| test(&pairs, *one, *two)).collect();
            if next.len() == pairs.len() {
                return next;
            }
            pairs = next;
        }
    }

    /// Whether each step of the first is answered by the second within the pairs.
    fn answered(&self, one: u32, two: u32, weak: bool, related: impl Fn(u32, u32) -> bool) -> bool {
        self.labels(weak).iter().all(|label| {
            self.after(one, label).into_iter().all(|target| {
                let answers: Vec<u32> =
                    if weak { self.weakly(two, label).into_iter().collect() } else { self.after(two, label) };
                answers.into_iter().any(|answer| related(target, answer))
            })
        })
    }

    /// Whether each step of the first is answered in the branching way.
    fn branches(&self, one: u32, two: u32, related: impl Fn(u32, u32) -> bool) -> bool {
        self.labels(true).iter().all(|label| {
            self.after(one, label).into_iter().all(|target| {
                let stays = *label == Label::Tau && related(target, two);
                stays
                    || self.internal(two).into_iter().any(|middle| {
                        related(one, middle) && self.after(middle, label).into_iter().any(|end| related(target, end))
                    })
            })
        })
    }

    /// All traces up to a length that no two small systems agree on by chance, found set by set.
    fn same_traces(&self, left: u32, right: u32, silent: bool) -> bool {
        type Sets = (BTreeSet<u32>, BTreeSet<u32>);
        let closed = |states: BTreeSet<u32>| {
            if silent { states.iter().flat_map(|state| self.internal(*state)).collect() } else { states }
        };
        let start: Sets = (closed([left].into()), closed([right].into()));
        let mut known: HashSet<Sets> = HashSet::new();
        let mut open = vec![start];
        let marks = self.system.marks().to_vec();
        let looks = |set: &BTreeSet<u32>, mark: &Mark| -> BTreeSet<u32> {
            let fits = |state: &&u32| silent || self.system.mark(**state) == mark;
            set.iter().filter(fits).copied().collect()
        };
        while let Some((left, right)) = open.pop() {
            for mark in &marks {
                let (one, two) = (looks(&left, mark), looks(&right, mark));
                if one.is_empty() != two.is_empty() {
                    return false;
                }
                if one.is_empty() || !known.insert((one.clone(), two.clone())) {
                    continue;
                }
                for label in self.labels(silent).into_iter().filter(|label| !silent || *label != Label::Tau) {
                    let step =
                        |set: &BTreeSet<u32>| closed(set.iter().flat_map(|state| self.after(*state, &label)).collect());
                    open.push((step(&one), step(&two)));
                }
            }
        }
        true
    }
}

fn shown_label() -> Label {
    Label::Shows("A".to_string())
}

/// Whether two systems are related.
pub fn related(left: &TransitionSystem, right: &TransitionSystem, relation: Preorder) -> bool {
    let (system, second) = left.union(right);
    let first = system.initial();
    let world = World { system };
    let mark = |state: u32| world.system.mark(state);
    let ending = |one: u32, two: u32| mark(one).ending == mark(two).ending;
    let simulation = || {
        world.greatest(|pairs, one, two| {
            mark(one) == mark(two) && world.answered(one, two, false, |a, b| pairs.contains(&(a, b)))
        })
    };
    match relation {
        Preorder::Strong => world
            .greatest(|pairs, one, two| {
                mark(one) == mark(two)
                    && world.answered(one, two, false, |a, b| pairs.contains(&(a, b)))
                    && world.answered(two, one, false, |a, b| pairs.contains(&(b, a)))
            })
            .contains(&(first, second)),
        Preorder::Weak => world
            .greatest(|pairs, one, two| {
                ending(one, two)
                    && world.answered(one, two, true, |a, b| pairs.contains(&(a, b)))
                    && world.answered(two, one, true, |a, b| pairs.contains(&(b, a)))
            })
            .contains(&(first, second)),
        Preorder::Branching => world
            .greatest(|pairs, one, two| {
                ending(one, two)
                    && world.branches(one, two, |a, b| pairs.contains(&(a, b)))
                    && world.branches(two, one, |a, b| pairs.contains(&(b, a)))
            })
            .contains(&(first, second)),
        Preorder::Simulation => simulation().contains(&(first, second)),
        Preorder::SimulationEquivalence => {
            let pairs = simulation();
            pairs.contains(&(first, second)) && pairs.contains(&(second, first))
        }
        Preorder::Refinement => world
            .greatest(|pairs, one, two| {
                mark(two).shown.is_subset(&mark(one).shown)
                    && ending(one, two)
                    && world.answered(one, two, false, |a, b| pairs.contains(&(a, b)))
                    && world.answered(two, one, false, |a, b| pairs.contains(&(b, a)))
            })
            .contains(&(first, second)),
        Preorder::Trace => world.same_traces(first, second, false),
        Preorder::WeakTrace => world.same_traces(first, second, true),
    }
}
