//! What is plain is done before any search: calls with numbers for parameters are unfolded and simplified one after
//! the other, so that a process that counts is followed as far as it goes; and in an induction one more round is
//! unfolded and what is supposed is put in.

use super::{Saturation, Why, shape};
use crate::term::{Node, Term};

/// The most calls that are unfolded on either side of a claim.
const MOST: usize = 64;

/// What a part may be replaced by, and why.
type Replacing<'r> = dyn Fn(&Saturation<'_>, &Term) -> Option<(Term, Why)> + 'r;

impl Saturation<'_> {
    /// Unfolds the calls of a side of the claim, first to last.
    pub(super) fn unroll(&mut self, term: &Term, room: usize) {
        let mut current = term.clone();
        for _ in 0..MOST {
            let Some(next) = self.first(&current, &|search, part| search.called(part, true)) else { break };
            if next.size() > room {
                return;
            }
            self.egraph.rebuild();
            current = self.simplified(&next);
        }
        let Some((left, right, step)) = self.supposed.clone() else { return };
        if let Some(next) = self.first(&current, &|search, part| search.called(part, false)) {
            self.egraph.rebuild();
            current = self.simplified(&next);
        }
        for (from, to) in [(&left, &right), (&right, &left)] {
            let put = |_: &Saturation<'_>, part: &Term| (part == from).then(|| (to.clone(), Why::Supposed(step)));
            if let Some(next) = self.first(&current, &put) {
                self.egraph.rebuild();
                self.simplified(&next);
            }
        }
    }

    fn called(&self, term: &Term, numbers: bool) -> Option<(Term, Why)> {
        let Node::Call(name, arguments) = term.node() else { return None };
        let plain = arguments.iter().all(|argument| argument.as_rational().is_some());
        if arguments.is_empty() || (numbers && !plain) {
            return None;
        }
        Some((self.unfolding(name, arguments)?, Why::Unfolded { call: term.clone() }))
    }

    /// The term with its first part that can be replaced replaced, known to the e-graph as the same.
    fn first(&mut self, term: &Term, replace: &Replacing<'_>) -> Option<Term> {
        if let Some((other, why)) = replace(self, term) {
            self.unite(term, &other, why);
            return Some(other);
        }
        let parts: Vec<Term> = term.children().cloned().collect();
        for (position, part) in parts.iter().enumerate() {
            if let Some(replaced) = self.first(part, replace) {
                let mut parts = parts.clone();
                parts[position] = replaced;
                let whole = term.with_children(parts.clone());
                self.flatten(shape(term), parts, &whole);
                return Some(whole);
            }
        }
        None
    }
}
