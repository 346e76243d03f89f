//! The parts of a graph that are never left, and the ends that a run may come to.

use std::collections::BTreeSet;

use super::{Before, Blocked, Edge, End, Failure, Next, Phase};
use crate::name::Name;

/// The ports through which something passed before a phase is reached: in some run, and in every one.
type Passed = [BTreeSet<Name>; 2];

/// Says of everything that waits for ever at an end whether something passed through its port before; `alone` tells of what
/// waits whether it was its partner's doing where something did.
pub(super) fn note_earlier(initial: &mut [Edge], phases: &mut [Phase], alone: &dyn Fn(&Blocked) -> bool) {
    let waits = |edge: &Edge| matches!(&edge.next, Next::End(End::Silent { blocked, .. }) if !blocked.is_empty());
    if !initial.iter().chain(phases.iter().flat_map(|phase| &phase.edges)).any(waits) {
        return;
    }
    let passed = passed(initial, phases);
    let note = |edge: &mut Edge, before: &Passed| {
        let own: BTreeSet<Name> = edge.communications.iter().map(|(port, _)| port.clone()).collect();
        let Next::End(End::Silent { blocked, .. }) = &mut edge.next else { return };
        for one in blocked {
            let [some, every] = before.each_ref().map(|ports| ports.contains(&one.port) || own.contains(&one.port));
            one.before = match (some, every) {
                (false, _) => Before::Never,
                (true, true) if alone(one) => Before::Always,
                (true, _) => Before::Perhaps,
            };
        }
    };
    initial.iter_mut().for_each(|edge| note(edge, &Passed::default()));
    for (phase, before) in phases.iter_mut().zip(&passed) {
        // What no run comes to is left as it is.
        if let Some(before) = before {
            phase.edges.iter_mut().for_each(|edge| note(edge, before));
        }
    }
}

/// What passed before each phase; none where no run comes to it.
fn passed(initial: &[Edge], phases: &[Phase]) -> Vec<Option<Passed>> {
    let mut found: Vec<Option<Passed>> = vec![None; phases.len()];
    let mut work: Vec<(Passed, &Edge)> = initial.iter().map(|edge| (Passed::default(), edge)).collect();
    while let Some(([mut some, mut every], edge)) = work.pop() {
        let Next::Phase(number) = edge.next else { continue };
        let ports = || edge.communications.iter().map(|(port, _)| port.clone());
        some.extend(ports());
        every.extend(ports());
        let joined = match &found[number] {
            None => [some, every],
            Some([one, other]) => [one | &some, other & &every],
        };
        if found[number].as_ref() != Some(&joined) {
            found[number] = Some(joined.clone());
            work.extend(phases[number].edges.iter().map(|edge| (joined.clone(), edge)));
        }
    }
    found
}

/// What is wrong where runs end: what waits for ever, surely or in some case, and what goes round in no time.
pub(super) fn ends(initial: &[Edge], phases: &[Phase]) -> Vec<Failure> {
    let sure = sure_end(initial, phases);
    let mut found = Vec::new();
    let mut waiting: Vec<(Blocked, Vec<usize>)> = Vec::new();
    let starts = initial.iter().map(|edge| (None, edge));
    let rounds =
        phases.iter().enumerate().flat_map(|(number, phase)| phase.edges.iter().map(move |edge| (Some(number), edge)));
    for (from, edge) in starts.chain(rounds) {
        match &edge.next {
            Next::End(End::Silent { blocked, .. }) => {
                for one in blocked {
                    match waiting.iter_mut().find(|(other, _)| other == one) {
                        Some((_, places)) => places.extend(from.filter(|from| !places.contains(from))),
                        None => waiting.push((one.clone(), from.into_iter().collect())),
                    }
                }
            }
            Next::End(End::Livelock { cycle, changes }) => {
                let (cycle, changes, when) = (cycle.clone(), changes.clone(), edge.tests.clone());
                found.push(Failure::Livelock { cycle, changes, when });
            }
            _ => {}
        }
    }
    let said = |(blocked, phases): (Blocked, Vec<usize>)| match sure {
        Some(End::Silent { blocked: there, .. }) if there.contains(&blocked) => Failure::Unmatched(blocked),
        _ => Failure::MayWait { blocked, phases },
    };
    found.splice(0..0, waiting.into_iter().map(said));
    found
}

/// The end that every run comes to, where there is one way alone.
fn sure_end<'e>(initial: &'e [Edge], phases: &'e [Phase]) -> Option<&'e End> {
    let mut edges = initial;
    for _ in 0..=phases.len() {
        let [only] = edges else { return None };
        match &only.next {
            Next::End(end) => return Some(end),
            Next::Phase(number) => edges = &phases.get(*number)?.edges,
        }
    }
    None
}

/// The sets of places that all reach each other and nothing else; an edge to nowhere leaves its part.
pub(super) fn final_parts(edges: &[Vec<Option<usize>>]) -> Vec<Vec<usize>> {
    let count = edges.len();
    let mut backwards: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (from, edges) in edges.iter().enumerate() {
        for to in edges.iter().flatten() {
            backwards[*to].push(from);
        }
    }
    let forwards = |place: usize| edges[place].iter().flatten().copied().collect::<Vec<_>>();
    let mut seen = vec![false; count];
    let mut order = Vec::with_capacity(count);
    for start in 0..count {
        let mut stack = vec![(start, false)];
        while let Some((place, done)) = stack.pop() {
            if done {
                order.push(place);
            } else if !std::mem::replace(&mut seen[place], true) {
                stack.push((place, true));
                stack.extend(forwards(place).into_iter().map(|next| (next, false)));
            }
        }
    }
    let mut part = vec![usize::MAX; count];
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for start in order.into_iter().rev().filter(|_| count > 0) {
        let mut stack = vec![start];
        let mut members = Vec::new();
        while let Some(place) = stack.pop() {
            if part[place] == usize::MAX {
                part[place] = parts.len();
                members.push(place);
                stack.extend(backwards[place].iter().copied());
            }
        }
        if !members.is_empty() {
            parts.push(members);
        }
    }
    let stays = |place: &usize| edges[*place].iter().all(|to| to.is_some_and(|to| part[to] == part[*place]));
    parts.into_iter().filter(|members| members.iter().all(stays)).collect()
}
