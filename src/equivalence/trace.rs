//! Trace equivalence: sets of states that one trace leads to, side by side.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::rc::Rc;

use super::evidence::{Difference, Found, Played};
use super::formula::{Formulas, Node};
use crate::transition_system::{Label, TransitionSystem};

/// The most pairs of sets, and the most states in all of them.
pub(super) const MOST_PAIRS: usize = 200_000;
const MOST_HELD: usize = 40_000_000;

/// What came of it.
pub(super) enum Traced {
    Same,
    Different(Box<Found>),
    TooMany,
}

type Set = Rc<Vec<u32>>;
/// A label and the mark of the state after it.
type Seen = (u32, u32);

struct Search<'s> {
    system: &'s TransitionSystem,
    /// The number of the internal label where internal steps do not count.
    silent: Option<u32>,
}

impl Search<'_> {
    fn closed(&self, states: impl IntoIterator<Item = u32>) -> Vec<u32> {
        let mut all: Vec<u32> = Vec::new();
        let mut seen = HashSet::new();
        all.extend(states.into_iter().filter(|state| seen.insert(*state)));
        let mut next = 0;
        while let Some(silent) = self.silent.filter(|_| next < all.len()) {
            for (_, to) in self.system.after(all[next], silent) {
                if seen.insert(*to) {
                    all.push(*to);
                }
            }
            next += 1;
        }
        all.sort_unstable();
        all
    }

    /// The states after each visible step, by label and mark.
    fn after(&self, set: &Set) -> BTreeMap<Seen, Vec<u32>> {
        let mut all: BTreeMap<Seen, Vec<u32>> = BTreeMap::new();
        for state in set.iter() {
            for (label, to) in self.system.steps(*state) {
                if Some(*label) != self.silent {
                    for end in self.closed([*to]) {
                        all.entry((*label, self.system.mark_number(end))).or_default().push(end);
                    }
                }
            }
        }
        for states in all.values_mut() {
            states.sort_unstable();
            states.dedup();
        }
        all
    }

    fn by_mark(&self, state: u32) -> BTreeMap<u32, Vec<u32>> {
        let mut all: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for end in self.closed([state]) {
            all.entry(self.system.mark_number(end)).or_default().push(end);
        }
        all
    }
}

/// One pair of sets with how it came about.
struct Pair {
    left: Set,
    right: Set,
    from: Option<(usize, Seen)>,
}

/// Whether two states have the same traces: the labels of their steps with what is seen after each. If `silent`,
/// internal steps do not count. Breadth first, so that the trace of one side alone is a shortest one.
pub(super) fn traces(
    system: &TransitionSystem,
    (left, right): (u32, u32),
    silent: bool,
    stop: &dyn Fn() -> bool,
) -> Traced {
    let search = Search { system, silent: system.label_number(&Label::Tau).filter(|_| silent) };
    let (one, two) = (search.by_mark(left), search.by_mark(right));
    if let Some((from_left, mark)) = only_one(&one, &two) {
        return Traced::Different(Box::new(search.found(&[], (from_left, true), mark, (left, right))));
    }
    let mut pairs: Vec<Pair> = Vec::new();
    let mut known: HashMap<(Set, Set), ()> = HashMap::new();
    for (mark, left) in one {
        let right = two.get(&mark).cloned().unwrap_or_default();
        pairs.push(Pair { left: Rc::new(left), right: Rc::new(right), from: None });
    }
    let (mut next, mut held) = (0, 0);
    while next < pairs.len() {
        if pairs.len() > MOST_PAIRS || held > MOST_HELD || (next % 256 == 0 && stop()) {
            return Traced::TooMany;
        }
        let (one, two) = (search.after(&pairs[next].left), search.after(&pairs[next].right));
        let alone = one.keys().find(|seen| !two.contains_key(seen)).map(|seen| (true, *seen));
        let alone = alone.or_else(|| two.keys().find(|seen| !one.contains_key(seen)).map(|seen| (false, *seen)));
        if let Some((from_left, seen)) = alone {
            let mut word = vec![seen];
            let mut at = next;
            while let Some((before, seen)) = pairs[at].from {
                word.push(seen);
                at = before;
            }
            word.reverse();
            let last = system.mark_number(if from_left { pairs[at].left[0] } else { pairs[at].right[0] });
            // Where the other side has the label too, it is what is seen after it that differs.
            let other = if from_left { &two } else { &one };
            let seen_differs = other.keys().any(|(label, _)| *label == seen.0);
            return Traced::Different(Box::new(search.found(&word, (from_left, seen_differs), last, (left, right))));
        }
        for (seen, states) in one {
            let others = two.get(&seen).cloned().unwrap_or_default();
            let pair = (Rc::new(states), Rc::new(others));
            // Equal sets have equal traces.
            if pair.0 == pair.1 || known.contains_key(&pair) {
                continue;
            }
            held += pair.0.len() + pair.1.len();
            known.insert(pair.clone(), ());
            pairs.push(Pair { left: pair.0, right: pair.1, from: Some((next, seen)) });
        }
        next += 1;
    }
    Traced::Same
}

fn only_one(one: &BTreeMap<u32, Vec<u32>>, two: &BTreeMap<u32, Vec<u32>>) -> Option<(bool, u32)> {
    let left = one.keys().find(|mark| !two.contains_key(mark)).map(|mark| (true, *mark));
    left.or_else(|| two.keys().find(|mark| !one.contains_key(mark)).map(|mark| (false, *mark)))
}

impl Search<'_> {
    /// The evidence: the trace as a formula, and as a run of the side that has it. `side` says whether that is the left
    /// one, and whether the other side has the same steps and looks different after them; `start` is the mark from which
    /// the trace starts.
    fn found(&self, word: &[Seen], side: (bool, bool), start: u32, (left, right): (u32, u32)) -> Found {
        let (from_left, seen_differs) = side;
        let weak = self.silent.is_some();
        // Where internal steps do not count, what is shown is a step, and a state looks like its ending alone.
        let looks = |mark: u32| {
            let mark = self.system.marks()[mark as usize].clone();
            if weak { Node::Ends(mark.ending) } else { Node::Looks(mark) }
        };
        let (all_alike, same_marks) = (self.system.marks().len() == 1, self.same_marks());
        let mut formulas = Formulas::default();
        let mut root = formulas.add(Node::True);
        for (place, (label, mark)) in word.iter().enumerate().rev() {
            let needed = if place + 1 < word.len() { !same_marks[*label as usize] } else { seen_differs };
            if needed && !all_alike {
                let look = formulas.add(looks(*mark));
                root = formulas.add(Node::And(vec![look, root]));
            }
            root = formulas.add(Node::Some(weak, self.system.label(*label).clone(), root));
        }
        if !all_alike && (weak || word.is_empty()) {
            let look = formulas.add(looks(start));
            root = formulas.add(Node::And(vec![look, root]));
            if weak {
                root = formulas.add(Node::Some(true, Label::Tau, root));
            }
        }
        let mut steps = Vec::new();
        let mut path = self.path(if from_left { left } else { right }, word, start);
        let last = word.last().map(|(label, _)| self.system.label(*label).clone());
        path.pop();
        for ((label, _), state) in word.iter().zip(path) {
            let label = self.system.label(*label).clone();
            let (left, right) = if from_left { (state, right) } else { (left, state) };
            steps.push(Played { left_moves: from_left, label, left, right });
        }
        let difference = match last {
            Some(label) => Difference::Step(from_left, label),
            None => {
                let has = self.system.marks()[start as usize].clone();
                let other = self.system.mark(if from_left { right } else { left }).clone();
                if from_left { Difference::Looks(has, other) } else { Difference::Looks(other, has) }
            }
        };
        Found { formulas, root, holds_left: from_left, steps, difference }
    }

    /// For each label whether all states after a step with it look alike.
    fn same_marks(&self) -> Vec<bool> {
        let mut marks: Vec<Option<u32>> = vec![None; self.system.labels().len()];
        let mut same = vec![self.silent.is_none(); marks.len()];
        for state in 0..self.system.states() as u32 {
            for (label, to) in self.system.steps(state) {
                let (mark, known) = (self.system.mark_number(*to), &mut marks[*label as usize]);
                same[*label as usize] &= *known.get_or_insert(mark) == mark;
            }
        }
        same
    }

    /// States along the trace, after each of its steps.
    fn path(&self, start: u32, word: &[Seen], mark: u32) -> Vec<u32> {
        let looks = |state: &u32, mark: u32| self.system.mark_number(*state) == mark;
        let mut levels: Vec<Vec<u32>> =
            vec![self.closed([start]).into_iter().filter(|state| looks(state, mark)).collect()];
        for seen in word {
            let before = Rc::new(levels.last().cloned().unwrap_or_default());
            levels.push(self.after(&before).remove(seen).unwrap_or_default());
        }
        // Backwards, so that each state does lead on.
        let mut path = Vec::new();
        let mut wanted = levels.last().and_then(|level| level.first().copied());
        for place in (0..word.len()).rev() {
            let Some(state) = wanted else { break };
            path.push(state);
            wanted = levels[place].iter().copied().find(|before| {
                let after = self.after(&Rc::new(vec![*before])).remove(&word[place]).unwrap_or_default();
                after.contains(&state)
            });
        }
        path.reverse();
        path
    }
}
