//! Systems in which internal steps do not count: what is shown becomes a step, and steps are taken with any number of
//! internal steps around them.

use std::collections::BTreeSet;

use super::rounds::{History, Kind};
use crate::transition_system::{Builder, Label, Mark, TransitionSystem};

/// The system in which a state looks like its ending alone, and what it shows while time passes is a step to itself.
///
/// An ending is compared exactly, so that `Tau ; Stop` and `Stop` differ: without that, weak equality is not preserved
/// by `#`. What is shown in an instant in which an internal step is due is not compared.
pub(super) fn observed(system: &TransitionSystem) -> TransitionSystem {
    let mut builder = Builder::new();
    let labels: Vec<u32> = system.labels().iter().map(|label| builder.label(label.clone())).collect();
    for state in 0..system.states() as u32 {
        let mark = system.mark(state);
        builder.state(Mark { shown: BTreeSet::new(), waits: true, ending: mark.ending.clone() });
    }
    for state in 0..system.states() as u32 {
        for (label, to) in system.steps(state) {
            builder.transition(state, labels[*label as usize], *to);
        }
        if let Some(text) = shows(system.mark(state), system.internal(state).next().is_some()) {
            let label = builder.label(Label::Shows(text));
            builder.transition(state, label, state);
        }
    }
    let mut observed = builder.finish(system.initial(), system.cut);
    observed.slack = system.slack.clone();
    observed
}

/// What a state shows while time passes; none if it shows nothing, or lets no time pass.
pub(super) fn shows(mark: &Mark, unstable: bool) -> Option<String> {
    let seen = mark.waits && !unstable && !mark.shown.is_empty();
    seen.then(|| mark.shown.iter().map(String::as_str).collect::<Vec<_>>().join(", "))
}

/// The branching bisimulation quotient, in which no cycle of internal steps is left, and the state of it that each
/// state has become. Livelocks are not told from states that wait for ever doing nothing.
pub(super) fn branching_quotient(system: &TransitionSystem) -> (TransitionSystem, Vec<u32>) {
    let (acyclic, group) = without_cycles(system);
    let history = History::of(&acyclic, Kind::Branching, None);
    let block = history.partition();
    let quotient = acyclic.quotient(&block, true);
    let whole = group.iter().map(|group| block[*group as usize]).collect();
    (quotient, whole)
}

/// The system with the states on a cycle of internal steps made one, internal steps leading to smaller numbers; and
/// the number that each state has got.
pub(super) fn without_cycles(system: &TransitionSystem) -> (TransitionSystem, Vec<u32>) {
    let group = system.components().of;
    (system.quotient(&group, true), group)
}

/// For each state those that internal steps lead to, itself included; none if they are more than this in all.
fn closures(system: &TransitionSystem, most: usize) -> Option<Vec<Vec<u32>>> {
    let states = system.states();
    let order = system.components();
    let mut by_number: Vec<u32> = (0..states as u32).collect();
    by_number.sort_by_key(|state| order.of[*state as usize]);
    let mut closure: Vec<Vec<u32>> = vec![Vec::new(); states];
    let mut held = 0usize;
    // Internal steps lead to smaller numbers or round a cycle, whose states have one number.
    let mut at = 0;
    while at < states {
        let number = order.of[by_number[at] as usize];
        let end = at + by_number[at..].iter().take_while(|state| order.of[**state as usize] == number).count();
        let members = &by_number[at..end];
        let mut all: Vec<u32> = members.to_vec();
        for state in members {
            for to in system.internal(*state).filter(|to| order.of[*to as usize] != number) {
                all.extend(&closure[to as usize]);
            }
        }
        all.sort_unstable();
        all.dedup();
        held = held.saturating_add(all.len() * members.len());
        if held > most {
            return None;
        }
        for state in members {
            closure[*state as usize] = all.clone();
        }
        at = end;
    }
    Some(closure)
}

/// The system whose steps are those of this one with any number of internal steps before and behind; an internal step
/// is any number of them, none included. None if it would have more transitions than this.
pub(super) fn saturated(system: &TransitionSystem, most: usize) -> Option<TransitionSystem> {
    let states = system.states();
    let closure = closures(system, most)?;
    let mut builder = Builder::new();
    for state in 0..states as u32 {
        builder.state(system.mark(state).clone());
    }
    let labels: Vec<u32> = system.labels().iter().map(|label| builder.label(label.clone())).collect();
    let tau = builder.label(Label::Tau);
    let mut count = 0;
    for state in 0..states as u32 {
        let mut found: Vec<(u32, u32)> = closure[state as usize].iter().map(|to| (tau, *to)).collect();
        for middle in &closure[state as usize] {
            for (label, to) in system.steps(*middle).iter().filter(|(label, _)| labels[*label as usize] != tau) {
                found.extend(closure[*to as usize].iter().map(|end| (labels[*label as usize], *end)));
            }
            // Much is found many times over.
            if found.len() > 1 << 22 {
                found.sort_unstable();
                found.dedup();
                if found.len() > most {
                    return None;
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        count += found.len();
        if count > most {
            return None;
        }
        for (label, to) in found {
            builder.transition(state, label, to);
        }
    }
    Some(builder.finish(system.initial(), system.cut))
}
