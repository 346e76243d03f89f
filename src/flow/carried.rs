//! What a phase that does not come back to itself does to the parameters of its processes: a dead-beat leg is over
//! after one round, and its flow function is what the parameters are where the next phase begins.

use std::collections::BTreeMap;

use crate::definition::{Definition, Definitions};
use crate::name::Name;
use crate::period::{Edge, Next, Phase, open_name};
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Value, ValueError};

/// A term is compared with a definition so deep only.
const DEEPEST: usize = 300;

/// A parameter of a process before and after a phase.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Carried {
    /// The parameter.
    pub parameter: Name,
    /// Its value where the phase begins, over the variables of the phase.
    pub before: Value,
    /// Its value where the next phase begins, over the same.
    pub after: Value,
}

/// What the parameters become, as a function of what they are where these are names; a number becomes another.
pub(super) fn line(all: &[Carried]) -> Option<String> {
    let list = |values: Vec<String>| values.join(", ");
    if all.iter().any(|one| one.before.as_variable().is_none()) {
        let becomes = all.iter().map(|one| format!("{} from {} to {}", one.parameter, one.before, one.after));
        return Some(format!("  flow      {}", list(becomes.collect())));
    }
    let before = list(all.iter().map(|one| one.before.to_string()).collect());
    let after = list(all.iter().map(|one| one.after.to_string()).collect());
    match all.len() {
        0 => None,
        1 => Some(format!("  flow      f({before}) = {after}")),
        _ => Some(format!("  flow      f({before}) = ({after})")),
    }
}

/// The parameters that change along this edge, in components that are as far in their definitions before as after.
pub(super) fn carried(phase: &Phase, edge: &Edge, phases: &[Phase], definitions: &Definitions) -> Vec<Carried> {
    let Next::Phase(number) = edge.next else { return Vec::new() };
    let Some(next) = phases.get(number) else { return Vec::new() };
    let plain = |names: &[Name]| -> BTreeMap<Name, Value> {
        names.iter().map(|name| (open_name(name), Value::variable(name))).collect()
    };
    let images: BTreeMap<Name, Value> = edge.map.iter().map(|(name, value)| (open_name(name), value.clone())).collect();
    let (own, own_names) = (phase.state.iter().zip(&phase.loops), plain(&phase.variables));
    let mut found = Vec::new();
    for ((before, loops), (after, others)) in own.zip(next.state.iter().zip(&next.loops)) {
        let Some(definition) = loops.last().filter(|name| others.last() == Some(*name)) else { continue };
        let Some(definition) = definitions.get(definition) else { continue };
        let before =
            substitute_values(before, &own_names).ok().and_then(|state| parameters(&state, definition, definitions));
        let after =
            substitute_values(after, &images).ok().and_then(|state| parameters(&state, definition, definitions));
        let (Some(before), Some(after)) = (before, after) else { continue };
        for parameter in &definition.parameters {
            let (Some(before), Some(after)) = (before.get(parameter), after.get(parameter)) else { continue };
            if before != after {
                let (before, after) = (before.clone(), after.clone());
                found.push(Carried { parameter: parameter.clone(), before, after });
            }
        }
    }
    found
}

/// The parameters for which this process is the body of the definition, with calls in it unfolded or not; none when it
/// is not.
fn parameters(state: &Term, definition: &Definition, definitions: &Definitions) -> Option<BTreeMap<Name, Value>> {
    let (mut found, mut equal) = (BTreeMap::new(), Vec::new());
    let mut pairs = vec![(definition.body.clone(), state, 0)];
    while let Some((shape, term, depth)) = pairs.pop() {
        // A loop that goes round stands as its body with what it ends by.
        let term = match (shape.node(), term.node()) {
            (Node::Else(..), _) => term,
            (_, Node::Else(first, last)) if matches!(last.node(), Node::Stop) => first,
            _ => term,
        };
        let shape = match (shape.node(), term.node()) {
            (Node::Call(name, _), Node::Call(other, _)) if name == other => shape,
            (Node::Call(name, values), _) => unfolded(definitions.get(name)?, values)?,
            _ => shape,
        };
        let (parts, others) = (shape.children(), term.children());
        let (values, seen) = (shape.values(), term.values());
        let alike = parts.len() == others.len() && values.len() == seen.len() && depth <= DEEPEST;
        if !alike || blank(&shape)? != blank(term)? {
            return None;
        }
        for (value, seen) in values.into_iter().zip(seen) {
            if let Some(name) = value.as_variable().filter(|name| definition.parameters.contains(name)) {
                found.entry(name.clone()).or_insert_with(|| seen.clone());
            }
            equal.push((value.clone(), seen.clone()));
        }
        let parts: Vec<Term> = parts.into_iter().cloned().collect();
        pairs.extend(parts.into_iter().zip(others).map(|(shape, term)| (shape, term, depth + 1)));
    }
    let fits = |(value, seen): &(Value, Value)| value.substitute(&found).is_ok_and(|value| value == *seen);
    equal.iter().all(fits).then_some(found)
}

fn unfolded(definition: &Definition, values: &[Value]) -> Option<Term> {
    let images = definition.parameters.iter().cloned().zip(values.iter().cloned()).collect();
    substitute_values(&definition.body, &images).ok()
}

/// The operator, or the leaf, without its values.
fn blank(term: &Term) -> Option<(std::mem::Discriminant<Node>, Option<Term>)> {
    let kind = std::mem::discriminant(term.node());
    if !term.children().is_empty() {
        return Some((kind, None));
    }
    let leaf = term.map_values(&mut |_| Ok::<_, ValueError>(Value::zero())).ok()?;
    Some((kind, Some(leaf)))
}
