//! Equivalences and preorders of transition systems, each answer with its evidence.
//!
//! Strong bisimilarity is decided by partition refinement in O(m log n); weak bisimilarity, which compares endings
//! exactly (`=c`), on the saturated branching quotient; branching bisimilarity by refinement in rounds; traces by sets
//! of states; simulation and refinement by pairs; what draws at random by the chances of classes, in rounds. "No" carries a formula that holds of one side alone and a shortest
//! run that tells the sides apart, both judged anew on the behaviours themselves; what does not stand is not shown.

mod best;
mod cells;
mod chance;
mod coupling;
mod evidence;
mod formula;
mod judge;
mod optimum;
mod pairs;
mod partition;
mod process;
mod replay;
mod rounds;
mod run;
mod stutter;
mod told;
mod trace;
pub(crate) mod way;
mod weak;

use crate::transition_system::{Bounds, TransitionSystem};

pub use evidence::Difference;
pub use formula::{Formulas, Node, Place};
pub use partition::strong_partition;
pub use process::{ProcessAnswer, compare_processes, minimised_system, system_of};
pub use run::{Evidence, RunStep};

pub use crate::preorder::Preorder;

use chance::Chances;
use coupling::Coupling;
use evidence::{Found, Lost};
use pairs::{Pairs, Rule};
use rounds::{History, Kind};
use run::Concrete;
use told::Told;

/// An answer.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// The two are related.
    Yes,
    /// They are not, for this reason.
    No(Box<Evidence>),
    /// Not decided, for this reason.
    Unknown(String),
}

/// Compares two systems from the states in which they begin.
pub fn compare(
    left: &TransitionSystem,
    right: &TransitionSystem,
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Verdict {
    let verdict = decide(left, right, relation, bounds, stop);
    let Verdict::No(evidence) = &verdict else { return verdict };
    let here = |system: &TransitionSystem, state: u32| ((state as usize) < system.states()).then_some(state);
    let (one, two) = (|state| here(left, state), |state| here(right, state));
    match run::stands(evidence, [left, right], [&one, &two], relation) {
        Ok(true) if left.cut.is_none() && right.cut.is_none() => verdict,
        Ok(true) => Verdict::Unknown(cut(left, right)),
        Ok(false) => Verdict::Unknown("a difference was found that did not stand up to being checked".into()),
        Err(_) => Verdict::Unknown("a difference was found, but checking it takes too much".into()),
    }
}

/// What is missing of systems that are not whole.
fn cut(left: &TransitionSystem, right: &TransitionSystem) -> String {
    left.cut.or(right.cut).map_or_else(String::new, |cut| cut.to_string())
}

/// Compares two systems; the evidence is not judged yet. Where a system is not whole, "yes" is unknown.
fn decide(
    left: &TransitionSystem,
    right: &TransitionSystem,
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Verdict {
    if left.states().saturating_add(right.states()) >= u32::MAX as usize {
        return Verdict::Unknown("the systems have too many states".into());
    }
    let (union, second) = left.union(right);
    let pair = (union.initial(), second);
    let first = left.states() as u32;
    let task = Task { union: &union, pair, first, bounds, stop };
    let cost = match relation {
        Preorder::Weak | Preorder::WeakTrace | Preorder::Branching => STUTTERING,
        _ => PARTITION,
    };
    if cost.of(&union) > bounds.bytes {
        let (states, most) = (union.states(), bounds.bytes >> 20);
        return Verdict::Unknown(format!("{most} MiB of memory are not enough for {states} states"));
    }
    let verdict = match relation {
        _ if union.draws() => task.chances(relation),
        Preorder::Strong => task.strong(),
        Preorder::Weak => task.weak(),
        Preorder::Branching => task.branching(),
        Preorder::Trace => task.traces(false),
        Preorder::WeakTrace => task.traces(true),
        Preorder::Simulation => task.pairs(Rule::Simulates, false),
        Preorder::Refinement => task.pairs(Rule::Refines, false),
        Preorder::SimulationEquivalence => match task.pairs(Rule::Simulates, false) {
            Verdict::Yes => task.pairs(Rule::Simulates, true),
            other => other,
        },
    };
    match verdict {
        Verdict::Yes if union.cut.is_some() => Verdict::Unknown(cut(left, right)),
        verdict => verdict,
    }
}

struct Task<'t> {
    union: &'t TransitionSystem,
    pair: (u32, u32),
    first: u32,
    bounds: &'t Bounds,
    stop: &'t dyn Fn() -> bool,
}

/// The bytes that each state and each transition of a system takes, by the peak of the release build on chains of 300,000
/// states and on random systems with two and with ten transitions a state.
#[derive(Clone, Copy)]
struct Cost {
    state: usize,
    transition: usize,
}

/// A system with its partition by strong bisimilarity.
const PARTITION: Cost = Cost { state: 104, transition: 36 };
/// A system without what cannot be seen, with its branching quotient.
const STUTTERING: Cost = Cost { state: 320, transition: 60 };
/// The rounds in which the states of a system part.
const ROUNDS: Cost = Cost { state: 160, transition: 12 };

impl Cost {
    fn of(self, system: &TransitionSystem) -> usize {
        let states = system.states().saturating_mul(self.state);
        states.saturating_add(system.transitions().saturating_mul(self.transition))
    }
}

/// The bytes that a weak step takes while the systems are compared, about.
const WEAK_BYTES: usize = 100;

impl Task<'_> {
    /// The answer from what was found between classes of states.
    fn no(&self, found: Option<Found>, class: &[u32], weak: bool, alone: bool, turned: bool) -> Verdict {
        let concrete = Concrete { union: self.union, right: self.pair.1, class, weak, alone, turned };
        match found.and_then(|found| concrete.evidence(found, self.first)) {
            Some(evidence) => Verdict::No(Box::new(evidence)),
            None => {
                let most = self.bounds.bytes >> 20;
                Verdict::Unknown(format!("a difference was found, but no run that shows it in {most} MiB of memory"))
            }
        }
    }

    fn classes(&self, class: &[u32]) -> (u32, u32) {
        (class[self.pair.0 as usize], class[self.pair.1 as usize])
    }

    fn strong(&self) -> Verdict {
        let class = strong_partition(self.union);
        let (one, two) = self.classes(&class);
        if one == two {
            return Verdict::Yes;
        }
        let quotient = self.union.quotient(&class, false);
        self.lost_bisimulation(&quotient, &class, (one, two), false)
    }

    /// Processes that draw at random: strong bisimilarity is finer than every relation, so its "yes" does for all.
    fn chances(&self, relation: Preorder) -> Verdict {
        let Some(found) = Chances::of(self.union, Some(self.pair), self.bounds.bytes) else {
            let most = self.bounds.bytes >> 20;
            return Verdict::Unknown(format!("{most} MiB of memory are not enough for the rounds"));
        };
        let (one, two) = self.pair;
        if found.rank(one, two).is_none() {
            return Verdict::Yes;
        }
        match relation {
            Preorder::Strong => self.no(found.evidence(self.pair), &self.itself(), false, false, false),
            Preorder::Simulation => self.coupled(Rule::Simulates, false),
            Preorder::Refinement => self.coupled(Rule::Refines, false),
            Preorder::SimulationEquivalence => match self.coupled(Rule::Simulates, false) {
                Verdict::Yes => self.coupled(Rule::Simulates, true),
                other => other,
            },
            Preorder::Trace => self.best(best::traces(self.union, self.pair, false, self.stop)),
            Preorder::WeakTrace => self.best(best::traces(&weak::observed(self.union), self.pair, true, self.stop)),
            Preorder::Weak => self.best(best::weakly(&weak::observed(self.union), self.pair, self.stop)),
            Preorder::Branching => match self.best(best::weakly(&weak::observed(self.union), self.pair, self.stop)) {
                Verdict::Yes => Verdict::Unknown(
                    "not strongly bisimilar, but weakly: what lies between is not decided where a side draws".into(),
                ),
                other => other,
            },
        }
    }

    /// Each state in a class of its own.
    fn itself(&self) -> Vec<u32> {
        (0..self.union.states() as u32).collect()
    }

    fn coupled(&self, rule: Rule, turned: bool) -> Verdict {
        let (one, two) = self.pair;
        let pair = if turned { (two, one) } else { (one, two) };
        match Coupling::of(self.union, rule, pair, self.bounds.bytes, self.stop) {
            Err(pairs) => Verdict::Unknown(format!("{pairs} pairs of states were not enough")),
            Ok(found) if found.rank(pair).is_none() => Verdict::Yes,
            Ok(found) => self.no(found.evidence(pair), &self.itself(), false, false, turned),
        }
    }

    fn best(&self, told: best::Told) -> Verdict {
        match told {
            best::Told::Same => Verdict::Yes,
            best::Told::Different(found) => self.no(Some(*found), &self.itself(), false, false, false),
            best::Told::Unknown(why) => Verdict::Unknown(why),
        }
    }

    /// Evidence for two classes of a quotient that are not bisimilar.
    fn lost_bisimulation(
        &self,
        quotient: &TransitionSystem,
        class: &[u32],
        (one, two): (u32, u32),
        weak: bool,
    ) -> Verdict {
        let taken = PARTITION.of(self.union).saturating_add(ROUNDS.of(quotient));
        if taken > self.bounds.bytes {
            return self.no(None, class, weak, false, false);
        }
        let ranks = History::of(quotient, Kind::Strong, Some((one, two)));
        let bytes = self.bounds.bytes - taken;
        let lost = Lost { system: quotient, ranks: &ranks, both: true, weak, branching: None, bytes };
        self.no(lost.evidence(one, two), class, weak, false, false)
    }

    fn weak(&self) -> Verdict {
        let observed = weak::observed(self.union);
        let (quotient, class) = weak::branching_quotient(&observed);
        let (one, two) = self.classes(&class);
        if one == two {
            return Verdict::Yes;
        }
        let most = self.bounds.bytes / WEAK_BYTES;
        let Some(saturated) = weak::saturated(&quotient, most) else {
            let most = self.bounds.bytes >> 20;
            return Verdict::Unknown(format!("{most} MiB of memory are not enough for the weak steps"));
        };
        let parts = strong_partition(&saturated);
        if parts[one as usize] == parts[two as usize] {
            return Verdict::Yes;
        }
        self.lost_bisimulation(&saturated, &class, (one, two), true)
    }

    fn branching(&self) -> Verdict {
        let observed = weak::observed(self.union);
        let (acyclic, class) = weak::without_cycles(&observed);
        let (one, two) = self.classes(&class);
        let history = History::of(&acyclic, Kind::Branching, Some((one, two)));
        if history.rank(one, two).is_none() {
            return Verdict::Yes;
        }
        let bytes = self.bounds.bytes.saturating_sub(STUTTERING.of(self.union));
        let lost = Lost { system: &acyclic, ranks: &history, both: true, weak: true, branching: Some(&history), bytes };
        let found = lost.evidence(one, two);
        // The rounds give a formula; the run is shortest on the quotient, where all internal steps count.
        let (quotient, blocks) = weak::branching_quotient(&observed);
        match (found, stutter::shortest(&quotient, self.classes(&blocks), self.stop)) {
            (Some(found), Some((steps, difference))) => {
                self.no(Some(Found { steps, difference, ..found }), &blocks, true, false, false)
            }
            (found, _) => self.no(found, &class, true, false, false),
        }
    }

    fn traces(&self, silent: bool) -> Verdict {
        let observed;
        let (system, class) = if silent {
            observed = weak::observed(self.union);
            weak::branching_quotient(&observed)
        } else {
            let class = strong_partition(self.union);
            (self.union.quotient(&class, false), class)
        };
        match trace::traces(&system, self.classes(&class), silent, self.stop) {
            trace::Traced::Same => Verdict::Yes,
            trace::Traced::TooMany => {
                Verdict::Unknown(format!("more than {} pairs of sets of states, or sets too large", trace::MOST_PAIRS))
            }
            trace::Traced::Different(found) => self.no(Some(*found), &class, silent, true, false),
        }
    }

    fn pairs(&self, rule: Rule, turned: bool) -> Verdict {
        let class = strong_partition(self.union);
        let quotient = self.union.quotient(&class, false);
        let (one, two) = self.classes(&class);
        let (one, two) = if turned { (two, one) } else { (one, two) };
        let ranks = match Pairs::of(&quotient, rule, (one, two), self.bounds.bytes, self.stop) {
            Ok(ranks) => ranks,
            Err(pairs) => return Verdict::Unknown(format!("{pairs} pairs of states were not enough")),
        };
        if ranks.rank(one, two).is_none() {
            return Verdict::Yes;
        }
        let bytes = self.bounds.bytes.saturating_sub(PARTITION.of(self.union));
        let lost = Lost { system: &quotient, ranks: &ranks, both: rule.both(), weak: false, branching: None, bytes };
        self.no(lost.evidence(one, two), &class, false, false, turned)
    }
}

/// The classes of strong bisimilarity; none where more bytes than this are needed.
pub fn strong_classes(system: &TransitionSystem, bytes: usize) -> Option<Vec<u32>> {
    if PARTITION.of(system) > bytes {
        return None;
    }
    if system.draws() { Some(Chances::of(system, None, bytes)?.classes()) } else { Some(strong_partition(system)) }
}
