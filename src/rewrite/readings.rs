//! The terms that the e-nodes of a search stand for.

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use egg::Id;

use super::{Operator, Saturation, rebuild};
use crate::simplify::clean;
use crate::term::Term;

/// An e-node with the smallest readings of its parts.
struct Plain {
    shape: Term,
    parts: Vec<Term>,
}

/// An e-node, with another reading of one of its parts or none.
type Reading = (Rc<Plain>, Option<(usize, Rc<Plain>)>);

/// The size of a term with these parts.
fn total(parts: &[Term]) -> usize {
    parts.iter().fold(1, |size, part| size.saturating_add(part.size()))
}

impl Saturation<'_> {
    /// The terms that the e-nodes stand for: parts by their smallest readings, and one part at a time by another.
    pub(super) fn readings(&mut self) -> Vec<Term> {
        let mut found: BTreeSet<(usize, Term)> = BTreeSet::new();
        let mut nested: Vec<(usize, Reading)> = Vec::new();
        let plain = |node: &Operator| {
            let parts: Vec<Term> = node.parts.iter().map(|id| self.egraph[*id].data.clone()).collect();
            (total(&parts), Rc::new(Plain { shape: node.shape.clone(), parts }))
        };
        let classes = self.egraph.classes();
        let plains: HashMap<Id, Vec<_>> =
            classes.map(|class| (class.id, class.nodes.iter().map(plain).collect())).collect();
        for class in self.egraph.classes() {
            for (node, (size, whole)) in class.nodes.iter().zip(plains.get(&class.id).into_iter().flatten()) {
                nested.push((*size, (whole.clone(), None)));
                for (position, id) in node.parts.iter().enumerate() {
                    // One alone is the smallest.
                    let others = plains.get(&self.egraph.find(*id)).filter(|others| others.len() > 1);
                    for (inner, other) in others.into_iter().flatten() {
                        let size = (size + inner).saturating_sub(whole.parts[position].size());
                        // A list inside a list is one operator less.
                        if size <= self.largest + node.parts.len() + other.parts.len() {
                            nested.push((size, (whole.clone(), Some((position, other.clone())))));
                        }
                    }
                }
            }
        }
        // The smallest first: a class of many nodes has more readings than fit in the limit.
        nested.sort_by_key(|(size, ..)| *size);
        for (number, (_, (whole, varied))) in nested.into_iter().enumerate() {
            if number % 64 == 0 && self.is_full() {
                break;
            }
            let (shape, mut parts) = (whole.shape.clone(), whole.parts.clone());
            if let Some((position, other)) = varied {
                parts[position] = rebuild(&other.shape, other.parts.clone());
            }
            let term = rebuild(&shape, parts.clone());
            if term.size() <= self.largest && found.insert((term.size(), term.clone())) {
                self.flatten(shape, parts, &term);
            }
        }
        self.egraph.rebuild();
        // A reading with units says no more than the one without, which is there as well.
        found.into_iter().map(|(_, term)| term).filter(|term| clean(term) == *term).collect()
    }

    /// A reading in the shape of terms belongs to the class of its e-node: it is the same term, so the step costs
    /// the kernel nothing.
    pub(super) fn flatten(&mut self, shape: Term, parts: Vec<Term>, term: &Term) {
        let parts = parts.iter().map(|part| self.add(part)).collect();
        let nested = self.egraph.add_uncanonical(Operator { shape, parts });
        let flat = self.add(term);
        if self.egraph.find(nested) != self.egraph.find(flat) {
            self.egraph.union_trusted(nested, flat, "ac");
        }
    }
}
