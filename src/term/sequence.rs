//! The parts of a sequence, which share what follows with the sequence that they are taken from.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::Arc;

use super::{Node, Term};
use crate::digest::Digest;

/// The parts of a sequence, at least two and none of them a sequence, as a slice.
///
/// What is left of it behind some of them ([`Sequence::after`]) is no copy: a run through a long sequence takes for each
/// part the same time, however many follow.
#[derive(Clone)]
pub struct Sequence {
    whole: Arc<Whole>,
    from: usize,
}

struct Whole {
    parts: Vec<Term>,
    /// For each part what is known of it and of all that follow.
    ends: Vec<End>,
}

#[derive(Clone, Copy)]
struct End {
    hash: u64,
    size: usize,
    depth: usize,
}

impl Sequence {
    pub(super) fn new(parts: Vec<Term>) -> Sequence {
        let mut end = End { hash: 0, size: 0, depth: 0 };
        let mut ends = vec![end; parts.len()];
        for (part, place) in parts.iter().zip(&mut ends).rev() {
            let mut hasher = Digest::default();
            hasher.write_u64(part.0.hash);
            hasher.write_u64(end.hash);
            let (size, depth) = (end.size.saturating_add(part.size()), end.depth.max(part.depth()));
            end = End { hash: hasher.finish(), size, depth };
            *place = end;
        }
        Sequence { whole: Arc::new(Whole { parts, ends }), from: 0 }
    }

    /// What follows so many parts, as one process: `Stop` where nothing does.
    pub fn after(&self, count: usize) -> Term {
        match self.get(count..) {
            None | Some([]) => Term::stop(),
            Some([last]) => last.clone(),
            Some(_) => Term::raw(Node::Seq(Sequence { whole: Arc::clone(&self.whole), from: self.from + count })),
        }
    }

    fn end(&self) -> End {
        self.whole.ends.get(self.from).copied().unwrap_or(End { hash: 0, size: 0, depth: 0 })
    }

    /// The number of operators in all its parts, and the longest way down in one of them.
    pub(super) fn size_and_depth(&self) -> (usize, usize) {
        let end = self.end();
        (end.size, end.depth)
    }

    fn same_place(&self, other: &Sequence) -> bool {
        self.from == other.from && Arc::ptr_eq(&self.whole, &other.whole)
    }
}

impl Deref for Sequence {
    type Target = [Term];

    fn deref(&self) -> &[Term] {
        self.whole.parts.get(self.from..).unwrap_or_default()
    }
}

impl<'a> IntoIterator for &'a Sequence {
    type Item = &'a Term;
    type IntoIter = std::slice::Iter<'a, Term>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl Hash for Sequence {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.end().hash);
    }
}

impl PartialEq for Sequence {
    fn eq(&self, other: &Sequence) -> bool {
        self.same_place(other) || (self.end().hash == other.end().hash && **self == **other)
    }
}

impl Eq for Sequence {}

impl PartialOrd for Sequence {
    fn partial_cmp(&self, other: &Sequence) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Sequence {
    fn cmp(&self, other: &Sequence) -> Ordering {
        if self.same_place(other) { Ordering::Equal } else { (**self).cmp(&**other) }
    }
}

impl std::fmt::Debug for Sequence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;
    use crate::value::Value;

    #[test]
    fn what_is_left_is_what_is_made_of_the_same_parts() {
        let parts: Vec<Term> =
            (0..40).map(|number| Term::new(Node::Out(Name::new("c"), Value::integer(number)))).collect();
        let whole = Term::seq(parts.clone());
        let Node::Seq(sequence) = whole.node() else { panic!("a sequence") };
        for place in 0..=parts.len() + 1 {
            let (left, made) = (sequence.after(place), Term::seq(parts.iter().skip(place).cloned()));
            assert_eq!(left, made);
            assert_eq!(left.0.hash, made.0.hash);
            assert_eq!((left.size(), left.depth()), (made.size(), made.depth()));
            assert_eq!(left.cmp(&made), Ordering::Equal);
        }
        assert_ne!(sequence.after(1), sequence.after(2));
        assert!(sequence.after(1) > sequence.after(0), "the numbers go up");
    }
}
