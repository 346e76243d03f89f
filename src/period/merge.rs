//! Phases that one behaviour goes through in a fixed order become one, whose rounds have several segments.

use std::collections::BTreeMap;

use super::{Edge, Next, Period, Phase, Segment, Test};
use crate::assumption::{Assumptions, with_fewest_corners};
use crate::name::Name;
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::{Relation, Value, ValueError};

/// Edges that one merging may make.
const MOST_PRODUCTS: usize = 32;
/// Phases up to which merging looks for more than chains.
const MOST_COMPARED: usize = 400;
/// The same where cycles are looked for.
const MOST_TOGETHER: usize = 100;

/// Initial edges, phases, and the number that each phase had.
type Merged = (Vec<Edge>, Vec<Phase>, Vec<usize>);

/// Merges every phase into those before it that it belongs to, and numbers the rest anew; phases that nothing leads to
/// are left out.
pub(super) fn merge(initial: Vec<Edge>, phases: Vec<Phase>, known: &Assumptions) -> Result<Merged, ValueError> {
    let mut initial = initial;
    let mut phases: Vec<Option<Phase>> = phases.into_iter().map(Some).collect();
    forget(&initial, &mut phases);
    chains(&mut phases, &initial, known)?;
    while phases.iter().flatten().count() <= MOST_COMPARED
        && let Some(number) = (0..phases.len()).rev().find(|number| merges(*number, &initial, &phases))
    {
        let Some(gone) = phases.get_mut(number).and_then(Option::take) else { break };
        initial = through(initial, number, &gone, known)?;
        for phase in phases.iter_mut().flatten() {
            phase.edges = through(std::mem::take(&mut phase.edges), number, &gone, known)?;
        }
    }
    forget(&initial, &mut phases);
    let numbers: Vec<usize> = (0..phases.len()).filter(|number| phases[*number].is_some()).collect();
    let anew: BTreeMap<usize, usize> = numbers.iter().enumerate().map(|(new, old)| (*old, new)).collect();
    let mut kept: Vec<Phase> = phases.into_iter().flatten().collect();
    for edge in initial.iter_mut().chain(kept.iter_mut().flat_map(|phase| &mut phase.edges)) {
        if let Next::Phase(number) = &mut edge.next {
            *number = anew.get(number).copied().unwrap_or(*number);
        }
    }
    Ok((initial, kept, numbers))
}

impl Period {
    /// The same period with phases that follow one another in a cycle taken together, also where behaviour changes, so that
    /// their rounds can be counted: of two goals that are visited in turn, a visit of both is one round. The other
    /// phases keep their numbers. Nothing where there are no such phases.
    ///
    /// # Errors
    /// When a value has no normal form.
    pub fn by_cycles(&self, known: &Assumptions) -> Result<Option<Period>, ValueError> {
        let mut phases: Vec<Option<Phase>> = self.phases.iter().cloned().map(Some).collect();
        let merges = |number: &usize, phases: &[Option<Phase>]| {
            enters_alone(*number, &self.initial, phases).is_some() && comes_back(*number, phases)
        };
        let mut merged = self.clone();
        let mut some = false;
        while self.phases.len() <= MOST_TOGETHER
            && let Some(number) = (0..phases.len()).rev().find(|number| merges(number, &phases))
        {
            let Some(gone) = phases.get_mut(number).and_then(Option::take) else { break };
            for phase in phases.iter_mut().flatten() {
                phase.edges = through(std::mem::take(&mut phase.edges), number, &gone, known)?;
            }
            some = true;
        }
        for (phase, found) in merged.phases.iter_mut().zip(phases) {
            *phase = found.unwrap_or_else(|| phase.clone());
        }
        Ok(some.then_some(merged))
    }
}

/// Whether some way leads from a phase back to it.
fn comes_back(number: usize, phases: &[Option<Phase>]) -> bool {
    let mut seen = vec![false; phases.len()];
    let mut stack = vec![number];
    while let Some(from) = stack.pop() {
        for edge in phases[from].iter().flat_map(|phase| &phase.edges) {
            match edge.next {
                Next::Phase(next) if next == number => return true,
                Next::Phase(next) if !std::mem::replace(&mut seen[next], true) => stack.push(next),
                _ => {}
            }
        }
    }
    false
}

/// Takes away the phases that nothing leads to.
fn forget(initial: &[Edge], phases: &mut [Option<Phase>]) {
    let mut reached = vec![false; phases.len()];
    let target = |edge: &Edge| if let Next::Phase(number) = edge.next { Some(number) } else { None };
    let mut stack: Vec<usize> = initial.iter().filter_map(target).collect();
    while let Some(number) = stack.pop() {
        if !std::mem::replace(&mut reached[number], true) {
            let edges = phases[number].iter().flat_map(|phase| &phase.edges);
            stack.extend(edges.filter_map(target));
        }
    }
    phases.iter_mut().zip(reached).filter(|(_, reached)| !reached).for_each(|(phase, _)| *phase = None);
}

/// Merges the phases that one edge enters and one edge leaves, without a change of behaviour, along whole chains.
fn chains(phases: &mut [Option<Phase>], initial: &[Edge], known: &Assumptions) -> Result<(), ValueError> {
    let mut entries = vec![0usize; phases.len()];
    let mut apart = vec![false; phases.len()];
    for edge in initial {
        if let Next::Phase(number) = edge.next {
            apart[number] = true;
        }
    }
    for edge in phases.iter().flatten().flat_map(|phase| &phase.edges) {
        if let Next::Phase(number) = edge.next {
            entries[number] += 1;
            apart[number] |= edge.switches;
        }
    }
    let link = |number: usize, phases: &[Option<Phase>]| {
        let single = phases[number].as_ref().is_some_and(|phase| phase.edges.len() == 1);
        single && entries[number] == 1 && !apart[number]
    };
    for start in 0..phases.len() {
        if phases[start].is_none() || link(start, phases) {
            continue;
        }
        let mut edges = phases[start].as_mut().map(|phase| std::mem::take(&mut phase.edges)).unwrap_or_default();
        for edge in &mut edges {
            while let Next::Phase(number) = edge.next
                && number != start
                && link(number, phases)
                && let Some(second) = phases[number].take().and_then(|mut phase| phase.edges.pop())
            {
                append(edge, &second)?;
                settle(edge, known);
            }
        }
        if let Some(phase) = &mut phases[start] {
            phase.edges = edges;
        }
    }
    Ok(())
}

/// A phase merges if it is entered from other phases only, never by a change of behaviour, nor at the very start.
fn merges(number: usize, initial: &[Edge], phases: &[Option<Phase>]) -> bool {
    enters_alone(number, initial, phases).is_some_and(|entries| entries.iter().all(|edge| !edge.switches))
}

/// The ways into a phase, where it is entered from other phases only, and not at the very start.
fn enters_alone<'p>(number: usize, initial: &[Edge], phases: &'p [Option<Phase>]) -> Option<Vec<&'p Edge>> {
    let phase = phases.get(number).and_then(Option::as_ref)?;
    let enters = |edge: &&Edge| edge.next == Next::Phase(number);
    if phase.rounds(number).next().is_some() || initial.iter().any(|edge| enters(&edge)) {
        return None;
    }
    let entries: Vec<&Edge> = phases.iter().flatten().flat_map(|phase| &phase.edges).filter(enters).collect();
    let few = entries.len() * phase.edges.len() <= MOST_PRODUCTS;
    (!entries.is_empty() && few).then_some(entries)
}

fn through(edges: Vec<Edge>, number: usize, gone: &Phase, known: &Assumptions) -> Result<Vec<Edge>, ValueError> {
    let mut all = Vec::new();
    for edge in edges {
        if edge.next == Next::Phase(number) {
            for second in &gone.edges {
                let mut composed = edge.clone();
                append(&mut composed, second)?;
                if settle(&mut composed, known) {
                    all.push(composed);
                }
            }
        } else {
            all.push(edge);
        }
    }
    Ok(all)
}

/// Leaves out the tests that hold with the values that came with the first round; false where one of them does not. The
/// delay that ends first runs in the phase that the way leaves, so it is more than 0.
fn settle(edge: &mut Edge, known: &Assumptions) -> bool {
    let mut known = known.clone();
    if let Some(first) = edge.segments.first()
        && known.decide(Relation::Gtr, &first.duration, &Value::zero()).is_none()
    {
        known.assume(Relation::Gtr, &first.duration, &Value::zero());
    }
    let decided: Vec<Option<bool>> =
        edge.tests.iter().map(|test| known.decide(test.relation, &test.left, &test.right)).collect();
    let open = |place: usize| decided.get(place) != Some(&Some(true));
    let mut place = 0..;
    edge.tests.retain(|_| place.next().is_none_or(open));
    let mut place = 0..;
    edge.after.retain(|_| place.next().is_none_or(open));
    !decided.contains(&Some(false)) && possible(edge, known)
}

/// Whether its tests may hold together: `n = 2` in one round and `n = 5` in the next do not.
fn possible(edge: &Edge, mut known: Assumptions) -> bool {
    if edge.tests.len() < 2 {
        return true;
    }
    edge.tests.iter().all(|test| {
        let decided = test.decide(&known);
        known.assume(test.relation, &test.left, &test.right);
        decided != Some(false)
    })
}

/// Several rounds one after another, as one; none where there are none.
///
/// # Errors
/// Where a value has no normal form.
pub(crate) fn one_after_another(rounds: &[&Edge]) -> Result<Option<Edge>, ValueError> {
    let Some((first, rest)) = rounds.split_first() else { return Ok(None) };
    let mut all = (*first).clone();
    rest.iter().try_for_each(|round| append(&mut all, round))?;
    Ok(Some(all))
}

/// One round after another.
fn append(first: &mut Edge, second: &Edge) -> Result<(), ValueError> {
    let mut map = std::mem::take(&mut first.map);
    let short = |value: Value| with_fewest_corners(&value);
    // A draw of the second round is another draw, even where it was given the same name.
    for (name, distribution) in &second.draws {
        let plain = name.as_str().split('~').next().unwrap_or_default();
        let drawn = Name::new(&format!("{plain}~{}", first.draws.len() + 1));
        first.draws.push((drawn.clone(), distribution.substitute(&map)?));
        map.insert(name.clone(), Value::variable(&drawn));
    }
    first.after.iter_mut().for_each(|after| *after = None);
    for (test, after) in second.tests.iter().zip(&second.after) {
        let Test { relation, left, right } = test.substitute(&map)?;
        let test = Test { relation, left: short(left), right: short(right) };
        // What was asked in the first round, of the same values, is answered.
        if !first.tests.contains(&test) {
            first.tests.push(test);
            first.after.push(after.clone());
        }
    }
    for segment in &second.segments {
        let shown = |term: &Term| {
            let term = substitute_values(term, &map).map_err(|stuck| ValueError(stuck.0))?;
            term.map_values(&mut |value| Ok(with_fewest_corners(value)))
        };
        let observed = segment.observed.iter().map(shown).collect::<Result<Vec<_>, ValueError>>()?;
        first.segments.push(Segment { duration: segment.duration.substitute(&map)?, observed });
    }
    first.map = second
        .map
        .iter()
        .map(|(name, value)| Ok((name.clone(), short(value.substitute(&map)?))))
        .collect::<Result<_, ValueError>>()?;
    for (port, value) in &second.communications {
        first.communications.push((port.clone(), short(value.substitute(&map)?)));
    }
    first.switches |= second.switches;
    first.next = second.next.clone();
    Ok(())
}
