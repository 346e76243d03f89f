//! Phases that one behaviour goes through in a fixed order become one, whose rounds have several segments.

use std::collections::BTreeMap;

use super::explore::Graph;
use super::{Edge, Next, Phase, Segment};
use crate::substitution::substitute_values;
use crate::value::ValueError;

/// Edges that one merging may make.
const MOST_PRODUCTS: usize = 32;

/// Merges every phase into those before it that it belongs to, and numbers the rest anew.
pub(crate) fn merge(graph: Graph) -> Result<(Vec<Edge>, Vec<Phase>), ValueError> {
    let Graph { mut initial, phases } = graph;
    let mut phases: Vec<Option<Phase>> = phases.into_iter().map(Some).collect();
    while let Some(number) = (0..phases.len()).rev().find(|number| merges(*number, &initial, &phases)) {
        let Some(gone) = phases.get_mut(number).and_then(Option::take) else { break };
        initial = through(initial, number, &gone)?;
        for phase in phases.iter_mut().flatten() {
            phase.edges = through(std::mem::take(&mut phase.edges), number, &gone)?;
        }
    }
    let mut numbers = BTreeMap::new();
    for (old, phase) in phases.iter().enumerate() {
        if phase.is_some() {
            numbers.insert(old, numbers.len());
        }
    }
    let mut kept: Vec<Phase> = phases.into_iter().flatten().collect();
    for edge in initial.iter_mut().chain(kept.iter_mut().flat_map(|phase| &mut phase.edges)) {
        if let Next::Phase(number) = &mut edge.next {
            *number = numbers.get(number).copied().unwrap_or(*number);
        }
    }
    Ok((initial, kept))
}

/// A phase merges if it is entered from other phases only, never by a change of behaviour, nor at the very start.
fn merges(number: usize, initial: &[Edge], phases: &[Option<Phase>]) -> bool {
    let Some(phase) = phases.get(number).and_then(Option::as_ref) else {
        return false;
    };
    let enters = |edge: &&Edge| edge.next == Next::Phase(number);
    if phase.rounds(number).next().is_some() || initial.iter().any(|edge| enters(&edge)) {
        return false;
    }
    let entries: Vec<&Edge> = phases.iter().flatten().flat_map(|phase| &phase.edges).filter(enters).collect();
    !entries.is_empty()
        && entries.iter().all(|edge| !edge.switches)
        && entries.len() * phase.edges.len() <= MOST_PRODUCTS
}

fn through(edges: Vec<Edge>, number: usize, gone: &Phase) -> Result<Vec<Edge>, ValueError> {
    let mut all = Vec::new();
    for edge in edges {
        if edge.next == Next::Phase(number) {
            for second in &gone.edges {
                all.push(compose(&edge, second)?);
            }
        } else {
            all.push(edge);
        }
    }
    Ok(all)
}

/// One round after another.
pub(crate) fn compose(first: &Edge, second: &Edge) -> Result<Edge, ValueError> {
    let map = &first.map;
    let mut composed = first.clone();
    for test in &second.tests {
        composed.tests.push(test.substitute(map)?);
    }
    composed.after = first.after.iter().map(|_| None).chain(second.after.iter().cloned()).collect();
    for segment in &second.segments {
        let observed: Result<Vec<_>, _> = segment.observed.iter().map(|term| substitute_values(term, map)).collect();
        let observed = observed.map_err(|stuck| ValueError(stuck.0))?;
        composed.segments.push(Segment { duration: segment.duration.substitute(map)?, observed });
    }
    composed.map = second
        .map
        .iter()
        .map(|(name, value)| Ok((name.clone(), value.substitute(map)?)))
        .collect::<Result<_, ValueError>>()?;
    for (port, value) in &second.communications {
        composed.communications.push((port.clone(), value.substitute(map)?));
    }
    for (name, distribution) in &second.draws {
        composed.draws.push((name.clone(), distribution.substitute(map)?));
    }
    composed.switches |= second.switches;
    composed.next = second.next.clone();
    Ok(composed)
}
