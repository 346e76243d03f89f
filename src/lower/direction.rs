//! Whether a law, used from left to right, plainly fits its own result again.

use std::collections::BTreeMap;

use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Whether some part of `right` is an instance of `left`, as far as the form of processes tells.
/// Finds the common mistakes; whether simplification ends is a question of all laws together.
pub(super) fn goes_on(left: &Term, right: &Term) -> bool {
    let mut rest = vec![right];
    while let Some(part) = rest.pop() {
        if windows(left, part) {
            return true;
        }
        rest.extend(part.children());
    }
    false
}

/// Whether the process, or as many of its parts as the pattern has, is an instance of the pattern.
fn windows(pattern: &Term, term: &Term) -> bool {
    let fits = |parts: &[Term], window: &[Term]| {
        let mut found = BTreeMap::new();
        parts.iter().zip(window).all(|(pattern, term)| instance(pattern, term, &mut found))
    };
    match (pattern.node(), term.node()) {
        (Node::Seq(parts), Node::Seq(all)) => all.windows(parts.len()).any(|window| fits(parts, window)),
        (Node::Par(parts), Node::Par(all)) | (Node::Disable(parts), Node::Disable(all)) => {
            all.windows(parts.len()).any(|window| fits(parts, window))
        }
        _ => instance(pattern, term, &mut BTreeMap::new()),
    }
}

fn instance(pattern: &Term, term: &Term, found: &mut BTreeMap<Name, Term>) -> bool {
    let mut rest = vec![(pattern, term)];
    while let Some((pattern, term)) = rest.pop() {
        if let Node::Meta(name, arguments) = pattern.node() {
            if arguments.is_empty() && found.entry(name.clone()).or_insert_with(|| term.clone()) != term {
                return false;
            }
            continue;
        }
        let (parts, others) = (pattern.children(), term.children());
        let alike = std::mem::discriminant(pattern.node()) == std::mem::discriminant(term.node());
        if !alike || parts.len() != others.len() || !values_fit(pattern, term) {
            return false;
        }
        rest.extend(parts.into_iter().zip(others));
    }
    true
}

/// A value that mentions a metavariable may fit any other.
fn values_fit(pattern: &Term, term: &Term) -> bool {
    let fits = |(one, other): (&Value, &Value)| one == other || one.variables().iter().any(Name::is_meta);
    let names = match (pattern.node(), term.node()) {
        (Node::Guard(one, ..), Node::Guard(other, ..)) => one == other,
        (Node::Power(_, _, one), Node::Power(_, _, other)) => one.is_some() == other.is_some(),
        (Node::Observe(one, _), Node::Observe(other, _)) | (Node::Call(one, _), Node::Call(other, _)) => one == other,
        _ => true,
    };
    let (values, others) = (pattern.values(), term.values());
    names && values.len() == others.len() && values.into_iter().zip(others).all(fits)
}
