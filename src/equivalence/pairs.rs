//! Simulation and refinement: pairs of states, and in how many steps one side can do what the other cannot answer.

use std::collections::HashMap;

use crate::transition_system::{Mark, TransitionSystem};

/// What a pair of states must have in common, and who may challenge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// The second does whatever the first does, and looks like it.
    Simulates,
    /// Both do whatever the other does; the second may show less.
    Refines,
}

impl Rule {
    /// Whether two states may stand together as far as can be seen.
    pub(super) fn agrees(self, one: &Mark, two: &Mark) -> bool {
        let shown = match self {
            Rule::Simulates => one.shown == two.shown,
            Rule::Refines => two.shown.is_subset(&one.shown),
        };
        one.ending == two.ending && shown
    }

    /// Whether the second may challenge too.
    pub(super) fn both(self) -> bool {
        self == Rule::Refines
    }
}

/// The pairs that were met, each with the least number of steps that tells them apart.
pub(super) struct Pairs {
    places: HashMap<(u32, u32), u32>,
    ranks: Vec<Option<u32>>,
}

/// The most pairs that are looked into.
const MOST_PAIRS: usize = 4_000_000;
/// The bytes that a pair with its challenges takes, about.
const PAIR_BYTES: usize = 256;

struct Search<'s> {
    system: &'s TransitionSystem,
    rule: Rule,
    places: HashMap<(u32, u32), u32>,
    pairs: Vec<(u32, u32)>,
    ranks: Vec<Option<u32>>,
    /// For each challenge its pair and how many answers are left.
    challenges: Vec<(u32, u32)>,
    /// For each pair the challenges that it answers.
    answers: Vec<Vec<u32>>,
}

impl Pairs {
    /// Looks into all pairs that matter for this one, with no more than so many bytes.
    ///
    /// # Errors
    /// The number of pairs that were not enough.
    pub(super) fn of(
        system: &TransitionSystem,
        rule: Rule,
        pair: (u32, u32),
        bytes: usize,
        stop: &dyn Fn() -> bool,
    ) -> Result<Pairs, usize> {
        let most = MOST_PAIRS.min(bytes / PAIR_BYTES);
        let mut search = Search {
            system,
            rule,
            places: HashMap::new(),
            pairs: Vec::new(),
            ranks: Vec::new(),
            challenges: Vec::new(),
            answers: Vec::new(),
        };
        search.place(pair.0, pair.1);
        let mut next = 0;
        let mut level = Vec::new();
        while next < search.pairs.len() {
            if search.pairs.len() > most || search.challenges.len() > 8 * most {
                return Err(most);
            }
            if next % 4096 == 0 && stop() {
                return Err(next);
            }
            let (one, two) = search.pairs[next];
            if !rule.agrees(system.mark(one), system.mark(two)) {
                search.ranks[next] = Some(0);
                level.push(next as u32);
            } else if one != two {
                search.look(next as u32, one, two);
            }
            next += 1;
        }
        search.spread(level);
        Ok(Pairs { places: search.places, ranks: search.ranks })
    }

    /// In how many steps the second fails to answer the first; none if it never does, or the pair was not met.
    pub(super) fn rank(&self, one: u32, two: u32) -> Option<u32> {
        self.places.get(&(one, two)).and_then(|place| self.ranks[*place as usize])
    }
}

impl Search<'_> {
    fn place(&mut self, one: u32, two: u32) -> u32 {
        let next = self.pairs.len() as u32;
        let place = *self.places.entry((one, two)).or_insert(next);
        if place == next {
            self.pairs.push((one, two));
            self.ranks.push(None);
            self.answers.push(Vec::new());
        }
        place
    }

    fn look(&mut self, pair: u32, one: u32, two: u32) {
        let system = self.system;
        for (label, target) in system.steps(one) {
            let answers: Vec<(u32, u32)> = system.after(two, *label).iter().map(|(_, to)| (*target, *to)).collect();
            self.challenge(pair, &answers);
        }
        if self.rule.both() {
            for (label, target) in system.steps(two) {
                let answers: Vec<(u32, u32)> = system.after(one, *label).iter().map(|(_, to)| (*to, *target)).collect();
                self.challenge(pair, &answers);
            }
        }
    }

    fn challenge(&mut self, pair: u32, answers: &[(u32, u32)]) {
        let number = self.challenges.len() as u32;
        self.challenges.push((pair, answers.len() as u32));
        for (one, two) in answers {
            let answer = self.place(*one, *two);
            self.answers[answer as usize].push(number);
        }
    }

    /// Gives each pair the rank in which the last answer to one of its challenges falls.
    fn spread(&mut self, mut level: Vec<u32>) {
        let mut rank = 1;
        // A challenge without any answer falls in one step.
        let mut falling: Vec<u32> =
            self.challenges.iter().filter(|(_, left)| *left == 0).map(|(pair, _)| *pair).collect();
        loop {
            for pair in std::mem::take(&mut level) {
                for challenge in std::mem::take(&mut self.answers[pair as usize]) {
                    let (of, left) = &mut self.challenges[challenge as usize];
                    *left -= 1;
                    if *left == 0 {
                        falling.push(*of);
                    }
                }
            }
            for pair in std::mem::take(&mut falling) {
                let slot = &mut self.ranks[pair as usize];
                if slot.is_none() {
                    *slot = Some(rank);
                    level.push(pair);
                }
            }
            if level.is_empty() {
                return;
            }
            rank += 1;
        }
    }
}
