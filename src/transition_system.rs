//! Labelled transition systems as data: states with what they show, transitions in compact sorted arrays, labels once.
//!
//! A system comes from a closed term ([`Process`]), from a file ([`aut`]), or from another system. What was left out
//! because a bound was hit is part of the system ([`TransitionSystem::cut`]), so that no answer can forget it.

pub mod aut;
mod cut;
mod display;
mod draw;
mod generate;
mod inputs;
mod shape;
mod svg;
mod tell;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt;

use num_rational::BigRational;
use num_traits::Zero;

pub use display::{dot, json, summary, titled_dot};
pub use generate::{Behaviour, Clock, Generated, Process, Trouble, generate, generate_pair};
pub use inputs::Inputs;
pub use svg::{MOST_DRAWN, svg, svg_of_each};
pub use tell::{look, told};

/// What one transition does.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Label {
    /// An internal step.
    Tau,
    /// This much time passes.
    Wait(BigRational),
    /// An action, as it is written: `c!1`, `c?0`, or anything from a file.
    Act(String),
    /// A draw at random comes out so, with this chance. A state has no other steps then; they add up to one.
    Chance(BigRational),
    /// What is shown while time passes, as a step that changes nothing: used where states are compared by steps alone.
    Shows(String),
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Label::Tau => f.write_str("tau"),
            Label::Wait(time) => write!(f, "wait {time}"),
            Label::Act(text) => f.write_str(text),
            Label::Chance(chance) => write!(f, "chance {chance}"),
            Label::Shows(text) => write!(f, "shows {text}"),
        }
    }
}

/// Whether and how a state has ended.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Ending {
    /// It has not.
    Running,
    /// It has stopped, with these results as text; empty without results.
    Stopped(String),
    /// It has aborted.
    Aborted,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ending::Running => f.write_str("running"),
            Ending::Stopped(results) if results.is_empty() => f.write_str("stopped"),
            Ending::Stopped(results) => write!(f, "stopped with {results}"),
            Ending::Aborted => f.write_str("aborted"),
        }
    }
}

/// What can be seen of a state without a step.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Mark {
    /// Whether it has ended.
    pub ending: Ending,
    /// The observers that it shows.
    pub shown: BTreeSet<String>,
    /// Whether it lets time pass. True of states from a file, where nothing is known of time.
    pub waits: bool,
}

impl Mark {
    /// A state that runs and shows nothing.
    pub fn plain() -> Mark {
        Mark { ending: Ending::Running, shown: BTreeSet::new(), waits: true }
    }
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.ending)?;
        if !self.shown.is_empty() {
            write!(f, ", shows {}", self.shown.iter().map(String::as_str).collect::<Vec<_>>().join(", "))?;
        }
        Ok(())
    }
}

/// Why a system is not the whole of what a process can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// This many states were not enough.
    States(usize),
    /// This many bytes were not enough, by an estimate from above.
    Memory(usize),
    /// The user stopped the work, after this many states.
    Interrupted(usize),
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cut::States(bound) => write!(f, "the bound of {bound} states was hit"),
            Cut::Memory(bytes) => write!(f, "the bound of {} MiB of memory was hit", bytes >> 20),
            Cut::Interrupted(states) => write!(f, "stopped by you after {states} states"),
        }
    }
}

/// How much may be built.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// The most states.
    pub states: usize,
    /// The most bytes for states and transitions, by an estimate from above.
    pub bytes: usize,
}

impl Default for Bounds {
    fn default() -> Bounds {
        Bounds { states: 100_000, bytes: 1 << 30 }
    }
}

/// A labelled transition system. States are numbered from 0.
#[derive(Clone, Debug)]
pub struct TransitionSystem {
    initial: u32,
    labels: Vec<Label>,
    marks: Vec<Mark>,
    /// For each state the number of its mark.
    seen: Vec<u32>,
    /// For each state where its steps begin; one entry more than states.
    first: Vec<u32>,
    /// Label and target of each transition, those of a state together and in order, each once.
    steps: Vec<(u32, u32)>,
    /// Why there may be more than this.
    pub cut: Option<Cut>,
    /// How far the chances of one instant, all together, may be from those that are said: 0 where they are exact.
    pub slack: BigRational,
    /// The states that were not looked into because of that, in order: their steps are not known.
    open: Vec<u32>,
}

impl TransitionSystem {
    /// The state in which it begins.
    pub fn initial(&self) -> u32 {
        self.initial
    }

    /// The same system begun elsewhere; elsewhere must be one of its states.
    pub fn begun_at(mut self, state: u32) -> TransitionSystem {
        if (state as usize) < self.states() {
            self.initial = state;
        }
        self
    }

    /// The number of states.
    pub fn states(&self) -> usize {
        self.seen.len()
    }

    /// The number of transitions.
    pub fn transitions(&self) -> usize {
        self.steps.len()
    }

    /// All labels; a step names one by its place.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// All marks.
    pub fn marks(&self) -> &[Mark] {
        &self.marks
    }

    /// The label of this number.
    pub fn label(&self, number: u32) -> &Label {
        &self.labels[number as usize]
    }

    /// The number of a label.
    pub fn label_number(&self, label: &Label) -> Option<u32> {
        self.labels.iter().position(|known| known == label).map(|place| place as u32)
    }

    /// The number of the mark of a state.
    pub fn mark_number(&self, state: u32) -> u32 {
        self.seen[state as usize]
    }

    /// What can be seen of a state.
    pub fn mark(&self, state: u32) -> &Mark {
        &self.marks[self.seen[state as usize] as usize]
    }

    /// The steps of a state: label and target, sorted.
    pub fn steps(&self, state: u32) -> &[(u32, u32)] {
        let place = state as usize;
        &self.steps[self.first[place] as usize..self.first[place + 1] as usize]
    }

    /// Where a state's steps begin in the order of all transitions.
    pub fn first(&self, state: u32) -> usize {
        self.first[state as usize] as usize
    }

    /// A state's steps with this label.
    pub fn after(&self, state: u32, label: u32) -> &[(u32, u32)] {
        let steps = self.steps(state);
        let start = steps.partition_point(|(other, _)| *other < label);
        let end = start + steps[start..].partition_point(|(other, _)| *other == label);
        &steps[start..end]
    }

    /// Whether some state draws at random.
    pub fn draws(&self) -> bool {
        self.labels.iter().any(|label| matches!(label, Label::Chance(_)))
    }

    /// The outcomes of the draw that is due in a state, with their chances; none if it draws nothing.
    pub fn chances(&self, state: u32) -> Vec<(&BigRational, u32)> {
        let steps = self.steps(state).iter();
        steps
            .filter_map(|(label, to)| match self.label(*label) {
                Label::Chance(chance) => Some((chance, *to)),
                _ => None,
            })
            .collect()
    }

    /// Whether a bound was hit before this state was looked into.
    pub fn is_open(&self, state: u32) -> bool {
        self.open.binary_search(&state).is_ok()
    }

    /// The number of states that were not looked into because a bound was hit.
    pub fn unexplored(&self) -> usize {
        self.open.len()
    }

    /// The bytes that the arrays take.
    pub fn bytes(&self) -> usize {
        4 * (self.seen.len() + self.first.len()) + 8 * self.steps.len()
    }

    /// Both systems side by side, with the state in which the second begins; the union begins where the first does.
    pub fn union(&self, other: &TransitionSystem) -> (TransitionSystem, u32) {
        let mut builder = Builder::new();
        for system in [self, other] {
            let base = builder.states();
            builder.open.extend(system.open.iter().map(|state| base + state));
            let labels: Vec<u32> = system.labels.iter().map(|label| builder.label(label.clone())).collect();
            for state in 0..system.states() as u32 {
                builder.state(system.mark(state).clone());
            }
            for state in 0..system.states() as u32 {
                for (label, to) in system.steps(state) {
                    builder.transition(base + state, labels[*label as usize], base + to);
                }
            }
        }
        let second = self.states() as u32 + other.initial;
        let mut whole = builder.finish(self.initial, self.cut.or(other.cut));
        whole.slack = self.slack.clone().max(other.slack.clone());
        (whole, second)
    }

    /// The system of the blocks of a partition: `block` gives each state's block, blocks are numbered from 0 without
    /// gaps. Internal steps inside a block are left out if `inert`.
    pub fn quotient(&self, block: &[u32], inert: bool) -> TransitionSystem {
        let count = block.iter().max().map_or(0, |most| *most as usize + 1);
        let mut builder = Builder { labels: self.labels.clone(), marks: self.marks.clone(), ..Builder::new() };
        builder.index();
        let mut member = vec![u32::MAX; count];
        // A draw all of whose outcomes are in its own block is like them, so that they stand for the block.
        let draws = self.draws();
        for drawing in [false, true] {
            for (state, block) in block.iter().enumerate() {
                let fits = !draws || drawing != self.chances(state as u32).is_empty();
                if fits && member[*block as usize] == u32::MAX {
                    member[*block as usize] = state as u32;
                }
            }
        }
        builder.seen = member.iter().map(|state| self.seen[*state as usize]).collect();
        for state in 0..self.states() as u32 {
            let own = block[state as usize];
            // Bisimilar states have the same steps up to blocks; inert ones may be spread over the members.
            if !inert && member[own as usize] != state {
                continue;
            }
            let mut chances: BTreeMap<u32, BigRational> = BTreeMap::new();
            for (chance, to) in if draws { self.chances(state) } else { Vec::new() } {
                *chances.entry(block[to as usize]).or_default() += chance;
            }
            for (to, chance) in &chances {
                let label = builder.label(Label::Chance(chance.clone()));
                builder.transition(own, label, *to);
            }
            for (label, to) in self.steps(state).iter().filter(|_| chances.is_empty()) {
                let to = block[*to as usize];
                if !(inert && own == to && *self.label(*label) == Label::Tau) {
                    builder.transition(own, *label, to);
                }
            }
        }
        let mut open: Vec<u32> = self.open.iter().map(|state| block[*state as usize]).collect();
        open.sort_unstable();
        open.dedup();
        builder.open = open;
        builder.finish(block.get(self.initial as usize).copied().unwrap_or(0), self.cut)
    }
}

/// A system under construction.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    labels: Vec<Label>,
    label_places: HashMap<Label, u32>,
    marks: Vec<Mark>,
    mark_places: HashMap<Mark, u32>,
    seen: Vec<u32>,
    transitions: Vec<(u32, u32, u32)>,
    open: Vec<u32>,
}

impl Builder {
    /// Nothing yet.
    pub fn new() -> Builder {
        Builder::default()
    }

    fn index(&mut self) {
        let number = |place: usize| place as u32;
        self.label_places = self.labels.iter().cloned().enumerate().map(|(at, label)| (label, number(at))).collect();
        self.mark_places = self.marks.iter().cloned().enumerate().map(|(at, mark)| (mark, number(at))).collect();
    }

    /// How many labels and marks there are.
    pub fn texts(&self) -> usize {
        self.labels.len() + self.marks.len()
    }

    /// The number of a label.
    pub fn label(&mut self, label: Label) -> u32 {
        if let Some(place) = self.label_places.get(&label) {
            return *place;
        }
        let place = self.labels.len() as u32;
        self.labels.push(label.clone());
        self.label_places.insert(label, place);
        place
    }

    /// A new state with this mark.
    pub fn state(&mut self, mark: Mark) -> u32 {
        let place = self.mark(mark);
        self.seen.push(place);
        self.seen.len() as u32 - 1
    }

    /// Gives a state that is there another mark.
    pub fn look(&mut self, state: u32, mark: Mark) {
        let place = self.mark(mark);
        if let Some(seen) = self.seen.get_mut(state as usize) {
            *seen = place;
        }
    }

    fn mark(&mut self, mark: Mark) -> u32 {
        if let Some(place) = self.mark_places.get(&mark) {
            return *place;
        }
        let place = self.marks.len() as u32;
        self.marks.push(mark.clone());
        self.mark_places.insert(mark, place);
        place
    }

    /// The number of states so far.
    pub fn states(&self) -> u32 {
        self.seen.len() as u32
    }

    /// The number of transitions so far.
    pub fn transitions(&self) -> usize {
        self.transitions.len()
    }

    /// A transition between two states that are there, with a label that is there.
    pub fn transition(&mut self, from: u32, label: u32, to: u32) {
        self.transitions.push((from, label, to));
    }

    /// Notes that this state, the last of those noted, is not looked into.
    pub fn leave_open(&mut self, state: u32) {
        self.open.push(state);
    }

    /// The system, begun in this state.
    pub fn finish(mut self, initial: u32, cut: Option<Cut>) -> TransitionSystem {
        if self.seen.is_empty() {
            self.state(Mark::plain());
        }
        self.transitions.sort_unstable();
        self.transitions.dedup();
        let mut first = vec![0u32; self.seen.len() + 1];
        for (from, _, _) in &self.transitions {
            first[*from as usize + 1] += 1;
        }
        for place in 1..first.len() {
            first[place] += first[place - 1];
        }
        let steps = self.transitions.iter().map(|(_, label, to)| (*label, *to)).collect();
        let initial = if (initial as usize) < self.seen.len() { initial } else { 0 };
        let open = self.open;
        let (labels, marks, seen) = (self.labels, self.marks, self.seen);
        TransitionSystem { initial, labels, marks, seen, first, steps, cut, slack: BigRational::zero(), open }
    }
}

/// What is to be known of a system at a glance.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Analysis {
    /// The number of states.
    pub states: usize,
    /// The number of transitions.
    pub transitions: usize,
    /// How many states have stopped.
    pub stopped: usize,
    /// How many have aborted.
    pub aborted: usize,
    /// States that run, can do nothing, and let time pass for ever without anything to come.
    pub deadlocks: Vec<u32>,
    /// The states on cycles of internal steps, which take no time.
    pub livelocks: Vec<u32>,
    /// States that run, can do nothing, and let no time pass.
    pub time_stops: Vec<u32>,
}
