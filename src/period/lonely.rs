//! Reads and writes that nobody answers, and whether anything waits for them.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;

use super::ports::Users;
use super::rest::NOTHING;
use super::run::{Kind, Run};
use super::{Blocked, Edge, End, Failure, Next};
use crate::name::Name;
use crate::term::Node;

/// Components with the ports on which they wait: for ever, and perhaps, beside what has ended such a wait here or there.
#[derive(Default)]
pub(super) struct Waiting {
    pub(super) surely: BTreeSet<(String, Name)>,
    pub(super) perhaps: BTreeSet<(String, Name)>,
}

/// A failure as it is, knowing who waits.
pub(super) fn judged(failure: Failure, waiting: &Waiting) -> Failure {
    match failure {
        Failure::Unmatched(blocked) => {
            let one = (blocked.component.clone(), blocked.port.clone());
            match waiting.surely.contains(&one) {
                true => Failure::Unmatched(blocked),
                false if waiting.perhaps.contains(&one) => Failure::Lonely(blocked),
                false => Failure::Unanswered(blocked),
            }
        }
        other => other,
    }
}

/// A failure as far as it is known where no run of the system is: that nobody answers.
pub(super) fn unjudged(failure: Failure) -> Failure {
    match failure {
        Failure::Unmatched(blocked) => Failure::Lonely(blocked),
        other => other,
    }
}

/// Adds who waits where a run ends.
pub(super) fn at_the_end(edge: &Edge, waiting: &mut Waiting) {
    if let Next::End(End::Silent { blocked, .. }) = &edge.next {
        waiting.surely.extend(blocked.iter().map(|Blocked { component, port, .. }| (component.clone(), port.clone())));
    }
}

/// What waits when an instant is over.
#[derive(Default)]
pub(super) struct Open {
    /// The ports of reads and writes that nothing ends.
    pub(super) alone: BTreeSet<Name>,
    /// The same beside what may end them: in a branch of `#`, where no other is sure to end by itself.
    pub(super) beside: BTreeSet<Name>,
}

impl Open {
    /// Of a part; what is under `#` with a delay waits for that delay alone.
    pub(super) fn of(run: &Run) -> Open {
        let mut open = Open::default();
        open.add(run, false);
        open
    }

    fn add(&mut self, run: &Run, beside: bool) {
        match run {
            Run::Wait(term, _) => {
                if let Node::In(port, _) | Node::Out(port, _) = term.node() {
                    let found = if beside { &mut self.beside } else { &mut self.alone };
                    found.insert(port.clone());
                }
            }
            Run::Seq(part, ..) | Run::Else(part, ..) | Run::New(_, part) | Run::Only(_, part) => self.add(part, beside),
            Run::Par(parts) => parts.iter().for_each(|part| self.add(part, beside)),
            Run::Disable(parts) if !parts.iter().any(ends_by_itself) => {
                parts.iter().for_each(|part| self.add(part, true));
            }
            Run::Disable(_) | Run::Done(_) | Run::Aborted | Run::Fresh(..) | Run::Delay(_) => {}
        }
    }
}

/// The reads and writes that a run has ended as another branch of their `#` ended first.
#[derive(Default)]
pub(crate) struct Ended {
    /// Whether it is asked for: somebody is answered by nobody.
    asked: bool,
    /// The component that is being settled.
    pub(super) component: Cell<usize>,
    found: RefCell<BTreeSet<(usize, Name)>>,
}

impl Ended {
    /// Nothing so far, in a system of which the ports are used so.
    pub(super) fn of(users: &Users) -> Ended {
        let asked = users.values().any(|(readers, writers)| readers.is_empty() || writers.is_empty());
        Ended { asked, ..Ended::default() }
    }

    /// Notes what waits in the branches of a `#` that ends.
    pub(super) fn note(&self, branches: &[Run]) {
        if !self.asked {
            return;
        }
        let mut open = Open::default();
        branches.iter().for_each(|branch| open.add(branch, true));
        self.found.borrow_mut().extend(open.beside.into_iter().map(|port| (self.component.get(), port)));
    }

    /// Whether what this component waits for on this port was ended so, here or there.
    pub(super) fn has(&self, component: usize, port: &Name) -> bool {
        self.found.borrow().contains(&(component, port.clone()))
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
