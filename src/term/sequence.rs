//! The parts of a sequence, which share what follows with the sequence that they are taken from.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::ops::Deref;
use std::sync::atomic::{AtomicU64, Ordering as Memory};
use std::sync::{Arc, OnceLock};

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
    /// No other has this number.
    number: u64,
    /// Another of which it is known that so many of the last parts are equal to as many of its own.
    alike: OnceLock<(u64, usize)>,
}

static NEXT: AtomicU64 = AtomicU64::new(0);

impl Whole {
    /// Whether so many of the last parts are known to be equal to as many of those of another.
    fn is_known_as(&self, other: &Whole, last: usize) -> bool {
        let seen = |whole: &Whole| whole.alike.get().copied().filter(|(_, equal)| last <= *equal);
        match (seen(self), seen(other)) {
            (Some((number, _)), _) if number == other.number => true,
            (_, Some((number, _))) if number == self.number => true,
            (Some((one, _)), Some((number, _))) => one == number,
            _ => false,
        }
    }
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
        let number = NEXT.fetch_add(1, Memory::Relaxed);
        Sequence { whole: Arc::new(Whole { parts, ends, number, alike: OnceLock::new() }), from: 0 }
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
    /// Two of which one part after the other is taken are compared once, not again for all that is left each time.
    fn eq(&self, other: &Sequence) -> bool {
        if self.same_place(other) {
            return true;
        }
        if self.len() != other.len() || self.end().hash != other.end().hash {
            return false;
        }
        if self.whole.is_known_as(&other.whole, self.len()) {
            return true;
        }
        let equal = **self == **other;
        if equal {
            // The first to be known is kept.
            let _ = self.whole.alike.set((other.whole.number, self.len()));
        }
        equal
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
        let same =
            self.same_place(other) || (self.len() == other.len() && self.whole.is_known_as(&other.whole, self.len()));
        if same { Ordering::Equal } else { (**self).cmp(&**other) }
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
    }

    #[test]
    fn what_is_known_to_be_equal_says_nothing_of_what_stands_before() {
        let of = |first: i64| {
            let number = |number: i64| if number == 0 { first } else { number };
            Term::seq((0..40).map(|place| Term::new(Node::Out(Name::new("c"), Value::integer(number(place))))))
        };
        let (one, other, third) = (of(100), of(200), of(300));
        let (Node::Seq(a), Node::Seq(b), Node::Seq(c)) = (one.node(), other.node(), third.node()) else {
            panic!("sequences")
        };
        for (mine, theirs) in [(a, b), (c, b), (a, c), (c, a)] {
            assert_eq!(mine.after(3), theirs.after(3));
            assert_eq!(mine.after(1), theirs.after(1));
            assert_eq!(mine.after(20), theirs.after(20));
            assert_ne!(mine.after(0), theirs.after(0));
            assert_ne!(mine.after(20), theirs.after(21));
            assert_ne!(mine.after(0).cmp(&theirs.after(0)), Ordering::Equal);
        }
    }

    #[test]
    fn what_follows_comes_after_what_stands_before() {
        let number = |number: i64| Term::new(Node::Out(Name::new("c"), Value::integer(number)));
        let whole = Term::seq((0..40).map(number));
        let Node::Seq(sequence) = whole.node() else { panic!("a sequence") };
        assert!(sequence.after(1) > sequence.after(0), "the numbers go up");
    }
}
