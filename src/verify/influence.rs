//! The cone of influence of a property: a run may repeat in all that the property depends on while something else, such
//! as what is left of a battery, only runs down.
//!
//! Let a variable of a phase matter if a test or a duration of its rounds reads it, if an observer that the property
//! names shows it, or if the image of a variable that matters reads it. Then of two runs that agree in what matters:
//! the tests decide alike, so both take the same way; the way leads to the same phase, and there they agree again in
//! what matters, since no image of that reads anything else; and what passes on the way takes as long and shows the
//! same of what the property names. So by induction the whole run, as far as the property can see it, is a function
//! of what matters at its start, and a run that repeats in what matters repeats for the property.

use std::collections::BTreeSet;

use super::orbit::observers;
use crate::name::Name;
use crate::period::{Edge, End, Next, Period};
use crate::term::{Node, Term};

/// Variables by the number of their phase: one name may mean different things in different phases.
type Matters = BTreeSet<(usize, Name)>;

/// The phases without the variables that a property does not depend on, and without what shows them; nothing where it
/// depends on all, or rounds draw at random.
pub(crate) fn reduced(period: &Period, property: &Term) -> Option<Period> {
    let asked = observers(property);
    let mut matters = Matters::new();
    let mut open = Vec::new();
    let edges = || {
        period.phases.iter().enumerate().flat_map(|(number, phase)| phase.edges.iter().map(move |edge| (number, edge)))
    };
    if period.initial.iter().chain(edges().map(|(_, edge)| edge)).any(|edge| !edge.draws.is_empty()) {
        return None;
    }
    for (number, edge) in edges() {
        open.extend(read(edge, &asked).into_iter().map(|name| (number, name)));
        if let Next::Phase(next) = edge.next {
            let after = edge.after.iter().flatten().flat_map(|test| [&test.left, &test.right]);
            open.extend(after.flat_map(|value| value.variables()).map(|name| (next, name)));
        }
    }
    while let Some((number, name)) = open.pop() {
        if !matters.insert((number, name.clone())) {
            continue;
        }
        let into = edges().filter(|(_, edge)| edge.next == Next::Phase(number));
        open.extend(into.flat_map(|(from, edge)| {
            let images = edge.map.get(&name).into_iter().flat_map(|image| image.variables());
            images.map(move |name| (from, name)).collect::<Vec<_>>()
        }));
    }
    let idle = |number: usize, name: &Name| !matters.contains(&(number, name.clone()));
    let mut reduced = period.clone();
    let mut some = false;
    for (number, phase) in reduced.phases.iter_mut().enumerate() {
        let gone: BTreeSet<Name> = phase.variables.iter().filter(|name| idle(number, name)).cloned().collect();
        some |= !gone.is_empty();
        phase.variables.retain(|name| !gone.contains(name));
        for segment in phase.edges.iter_mut().flat_map(|edge| &mut edge.segments) {
            let reads = |term: &Term| term.values().any(|value| gone.iter().any(|name| value.mentions(name)));
            segment.observed.retain(|term| !reads(term));
        }
    }
    for edge in reduced.initial.iter_mut().chain(reduced.phases.iter_mut().flat_map(|phase| &mut phase.edges)) {
        if let Next::Phase(next) = edge.next {
            edge.map.retain(|name, _| !idle(next, name));
        }
    }
    some.then_some(reduced)
}

/// The variables that a round reads for its tests, its durations, and what it shows of these observers.
fn read(edge: &Edge, asked: &BTreeSet<Name>) -> BTreeSet<Name> {
    let shown = |term: &&Term| matches!(term.node(), Node::Observe(name, _) if asked.contains(name));
    let tests = edge.tests.iter().flat_map(|test| [&test.left, &test.right]);
    let durations = edge.segments.iter().map(|segment| &segment.duration);
    let mut terms: Vec<&Term> = edge.segments.iter().flat_map(|segment| &segment.observed).filter(shown).collect();
    if let Next::End(End::Silent { observed, .. }) = &edge.next {
        terms.extend(observed);
    }
    tests.chain(durations).chain(terms.into_iter().flat_map(Term::values)).flat_map(|value| value.variables()).collect()
}
