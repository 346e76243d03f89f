//! Laws that are instances of others.

use super::warning;
use crate::diagnostic::{Diagnostic, Span};
use crate::fact::Context;
use crate::law::{Connective, Law};
use crate::lower::Environment;
use crate::matching::{Match, matches};
use crate::proof::hole;
use crate::simplify::{clean, surround};
use crate::term::{Node, Term};

/// What the other law's metavariables stand for, if the law follows by one use of it.
pub(super) fn subsumes(other: &Law, law: &Law, environment: &Environment) -> Option<Match> {
    // A law that simplification uses does more than one that it does not.
    if (law.oriented && !other.oriented)
        || (law.connective == Connective::Equal && other.connective != Connective::Equal)
    {
        return None;
    }
    let context = Context::new(&environment.assumptions, &environment.definitions, &law.conditions);
    let both = other.connective == Connective::Equal && !law.oriented;
    let ways = [(&other.left, &other.right), (&other.right, &other.left)];
    for (from, to) in ways.into_iter().take(if both { 2 } else { 1 }) {
        // `?P = …` fits everything.
        if matches!(from.node(), Node::Meta(..)) {
            continue;
        }
        for found in matches(other, from, &law.left, &context) {
            let Ok(image) = found.substitution.apply(to, &context) else { continue };
            let image = surround(&found.surrounding, &image);
            // What differs in units alone is no use of the law, but where the law says just that.
            let moved = clean(&image) != clean(&law.left);
            let units = clean(&law.left) == clean(&law.right);
            if (moved || units) && image == law.right || moved && clean(&image) == clean(&law.right) {
                return Some(found);
            }
        }
    }
    None
}

/// The first of the other laws that the law is an instance of.
pub(super) fn finding(
    law: &Law,
    span: Span,
    others: impl Iterator<Item = Law>,
    environment: &Environment,
) -> Option<Diagnostic> {
    for other in others {
        let Some(found) = subsumes(&other, law, environment) else { continue };
        let message = format!("the law `{}` follows from `{}` in one step", law.name, other.name);
        let mut finding = warning("P0922", message, span);
        finding = finding.note(format!("{} {} {}", other.left, other.connective, other.right));
        let with = crate::explain::instance(&found.substitution.processes, &found.substitution.values);
        if !with.is_empty() {
            finding = finding.note(format!("with {}", with.join(", ")));
        }
        if found.surrounding != Term::meta(&hole(1)) {
            finding = finding.note(format!("inside {}", found.surrounding));
        }
        return Some(finding.help("leave it out, unless its name helps the reader"));
    }
    None
}
