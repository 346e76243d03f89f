//! Reads and writes that nobody answers, and whether anything waits for them.

use std::collections::BTreeSet;

use super::rest::NOTHING;
use super::run::{Kind, Run};
use super::{Blocked, Edge, End, Failure, Next};
use crate::name::Name;
use crate::term::Node;

/// Components with the ports on which they wait.
pub(super) type Waiting = BTreeSet<(String, Name)>;

/// A failure as it is, knowing who waits.
pub(super) fn judged(failure: Failure, waiting: &Waiting) -> Failure {
    match failure {
        Failure::Unmatched(blocked) if !waiting.contains(&(blocked.component.clone(), blocked.port.clone())) => {
            Failure::Unanswered(blocked)
        }
        other => other,
    }
}

/// Adds who waits where a run ends.
pub(super) fn at_the_end(edge: &Edge, waiting: &mut Waiting) {
    if let Next::End(End::Silent { blocked, .. }) = &edge.next {
        waiting.extend(blocked.iter().map(|Blocked { component, port, .. }| (component.clone(), port.clone())));
    }
}

/// Adds the ports of the reads and writes that wait in a part when an instant is over, and that no delay beside them
/// will end: what is under `#` with a delay waits for that delay alone.
pub(super) fn waits(run: &Run, found: &mut BTreeSet<Name>) {
    match run {
        Run::Wait(term, _) => {
            if let Node::In(port, _) | Node::Out(port, _) = term.node() {
                found.insert(port.clone());
            }
        }
        Run::Seq(part, ..) | Run::Else(part, ..) | Run::New(_, part) | Run::Only(_, part) => waits(part, found),
        Run::Par(parts) => parts.iter().for_each(|part| waits(part, found)),
        Run::Disable(parts) => {
            if !parts.iter().any(ends_by_itself) {
                parts.iter().for_each(|part| waits(part, found));
            }
        }
        Run::Done(_) | Run::Aborted | Run::Fresh(..) | Run::Delay(_) => {}
    }
}

/// Whether it ends when the delays that run in it are over.
fn ends_by_itself(run: &Run) -> bool {
    match run {
        Run::Delay(_) => true,
        Run::Seq(first, rest, ..) => *rest == NOTHING && ends_by_itself(first),
        Run::Else(first, _, _, Kind::Choice) | Run::New(_, first) | Run::Only(_, first) => ends_by_itself(first),
        Run::Par(parts) => parts.iter().all(ends_by_itself),
        Run::Disable(parts) => parts.iter().any(ends_by_itself),
        _ => false,
    }
}
