//! A look at the shapes of a pattern and a term, before values and metavariables are looked at.

use crate::term::{Node, Term};

/// Whether the shapes allow that the pattern fits the whole term. Where they do not, it fits for no values.
pub(super) fn may_fit(pattern: &Term, term: &Term) -> bool {
    if is_bare(pattern) {
        return true;
    }
    match (pattern.node(), term.node()) {
        (Node::Seq(wanted), Node::Seq(parts)) => all_there(wanted, parts),
        (Node::Seq(wanted), Node::Stop) => all_there(wanted, &[]),
        (Node::Seq(wanted), _) => all_there(wanted, std::slice::from_ref(term)),
        (Node::Par(wanted), Node::Par(parts)) | (Node::Disable(wanted), Node::Disable(parts)) => {
            all_there(wanted, parts)
        }
        // Its metavariables stand for Idle.
        (Node::Disable(wanted), _) => all_there(wanted, std::slice::from_ref(term)),
        (wanted, given) => {
            let (inner, parts) = (pattern.children(), term.children());
            std::mem::discriminant(wanted) == std::mem::discriminant(given)
                && inner.len() == parts.len()
                && inner.zip(parts).all(|(one, part)| may_fit(one, part))
        }
    }
}

/// Whether there may be a part of its own for each pattern that is no bare metavariable.
pub(super) fn all_there(wanted: &[Term], parts: &[Term]) -> bool {
    let solid = || wanted.iter().filter(|pattern| !is_bare(pattern));
    solid().count() <= parts.len() && solid().all(|pattern| parts.iter().any(|part| may_fit(pattern, part)))
}

/// Whether it is a metavariable without values.
pub(super) fn is_bare(pattern: &Term) -> bool {
    matches!(pattern.node(), Node::Meta(_, arguments) if arguments.is_empty())
}
