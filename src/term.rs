//! Process terms: immutable, shared, and always in one shape modulo the structural equivalences.
//!
//! `;` is associative, `|` and `#` are associative and commutative (§IV.B; `docs/language.md`), so
//! [`Term::seq`], [`Term::par`] and [`Term::disable`] flatten, and the last two sort. Two terms that
//! differ only in this are the same term. Units (`Stop ; P`, `P # Idle`) are kept: they are laws.
//!
//! There are two binders only, the index of `P^{i<n}` and the private port of `new c. P`. A result `<y>` is a
//! write and a parameter expression a read of what was written, so nothing else needs renaming.

pub mod room;
mod sequence;

use std::cmp::Ordering;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hash, Hasher};
use std::sync::Arc;

use crate::digest::Digest;
use crate::name::Name;
use crate::value::{Relation, Value};
pub use sequence::Sequence;

/// A process, shared and immutable.
#[derive(Clone)]
pub struct Term(Arc<Shared>);

struct Shared {
    node: Node,
    hash: u64,
    size: usize,
    depth: usize,
}

/// The outermost operator of a process with its parts.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Node {
    /// `Stop`
    Stop,
    /// `Abort`
    Abort,
    /// `Idle`
    Idle,
    /// `Delay_t`
    Delay(Value),
    /// `In_c<y>`
    In(Name, Name),
    /// `Out_{c,x}`
    Out(Name, Value),
    /// `Eq_{x,y}`, `Neq`, `Gtr`, `Gte`, `Lss`, `Lte`
    Guard(Relation, Value, Value),
    /// `Set_x<y>`
    Set(Value, Name),
    /// `Ran_D<y>`
    Ran(Value, Name),
    /// `At_r`: a declared observer
    Observe(Name, Vec<Value>),
    /// `MoveTo_g`: a defined process
    Call(Name, Vec<Value>),
    /// `?P`, `?P_{u}`: any process, in a law or a claim
    Meta(Name, Vec<Value>),
    /// `P ; Q ; …`: at least two parts, none of them a `Seq`
    Seq(Sequence),
    /// `P else Q`
    Else(Term, Term),
    /// `P | Q | …`: at least two parts, sorted, none of them a `Par`
    Par(Vec<Term>),
    /// `P # Q # …`: at least two parts, sorted, none of them a `Disable`
    Disable(Vec<Term>),
    /// `P^n`, or `P^{i<n}`: the copies for i = 0, 1, …, n-1 in sequence
    Power(Term, Value, Option<Name>),
    /// `loop(P)`: P again and again, until it aborts; then it stops
    Loop(Term),
    /// `new c. P`: port c is private to P
    New(Name, Term),
    /// `P to {At, …}`: observers that are not named become `Idle`
    Project(Term, BTreeSet<Name>),
    /// `P[y := x]`, in laws only: evaluated as soon as P is known
    Replace(Term, Name, Value),
}

impl Term {
    /// A term with this node; the constructors below keep the canonical shape.
    pub fn new(node: Node) -> Term {
        match node {
            Node::Par(parts) => Term::par(parts),
            Node::Disable(parts) => Term::disable(parts),
            // What is certain is not drawn.
            Node::Ran(from, name) => match from.certain() {
                Some(value) => Term::raw(Node::Set(value, name)),
                None => Term::raw(Node::Ran(from, name)),
            },
            node => Term::raw(node),
        }
    }

    fn raw(node: Node) -> Term {
        let (size, depth) = match &node {
            Node::Seq(parts) => parts.size_and_depth(),
            node => node.children().fold((0usize, 0usize), |(size, depth), part| {
                (size.saturating_add(part.size()), depth.max(part.depth()))
            }),
        };
        let mut hasher = Digest::default();
        node.hash(&mut hasher);
        let hash = hasher.finish();
        Term(Arc::new(Shared { node, hash, size: size.saturating_add(1), depth: depth + 1 }))
    }

    /// `Stop`
    pub fn stop() -> Term {
        Term::raw(Node::Stop)
    }

    /// `Abort`
    pub fn abort() -> Term {
        Term::raw(Node::Abort)
    }

    /// `Idle`
    pub fn idle() -> Term {
        Term::raw(Node::Idle)
    }

    /// `Delay_t`
    pub fn delay(time: Value) -> Term {
        Term::raw(Node::Delay(time))
    }

    /// `?P`
    pub fn meta(name: &Name) -> Term {
        Term::raw(Node::Meta(name.clone(), Vec::new()))
    }

    /// The parts in sequence: flattened; of one part, that part; of none, `Stop`.
    pub fn seq(parts: impl IntoIterator<Item = Term>) -> Term {
        let mut parts = parts.into_iter();
        let Some(first) = parts.next() else { return Term::stop() };
        let Some(second) = parts.next() else { return first };
        let mut flat = Vec::new();
        for part in [first, second].into_iter().chain(parts) {
            match part.node() {
                Node::Seq(inner) => flat.extend(inner.iter().cloned()),
                _ => flat.push(part),
            }
        }
        Term::raw(Node::Seq(Sequence::new(flat)))
    }

    /// The parts in parallel: flattened and sorted; of one part, that part; of none, `Abort`, the unit of `|`.
    pub fn par(parts: impl IntoIterator<Item = Term>) -> Term {
        let mut flat = Vec::new();
        for part in parts {
            match part.node() {
                Node::Par(inner) => flat.extend(inner.iter().cloned()),
                _ => flat.push(part),
            }
        }
        match flat.len() {
            0 => Term::abort(),
            1 => flat.swap_remove(0),
            _ => {
                flat.sort();
                Term::raw(Node::Par(flat))
            }
        }
    }

    /// The parts under `#`: flattened and sorted; of one part, that part; of none, `Idle`, the unit of `#`.
    pub fn disable(parts: impl IntoIterator<Item = Term>) -> Term {
        let mut flat = Vec::new();
        for part in parts {
            match part.node() {
                Node::Disable(inner) => flat.extend(inner.iter().cloned()),
                _ => flat.push(part),
            }
        }
        match flat.len() {
            0 => Term::idle(),
            1 => flat.swap_remove(0),
            _ => {
                flat.sort();
                Term::raw(Node::Disable(flat))
            }
        }
    }

    /// `P else Q`
    pub fn otherwise(first: Term, second: Term) -> Term {
        Term::raw(Node::Else(first, second))
    }

    /// `try(P)`, which is `P else Stop`
    pub fn attempt(body: Term) -> Term {
        Term::otherwise(body, Term::stop())
    }

    /// Its outermost operator.
    pub fn node(&self) -> &Node {
        &self.0.node
    }

    /// The number of operators in it, capped at the largest machine number.
    pub fn size(&self) -> usize {
        self.0.size
    }

    /// The length of the longest way down.
    pub fn depth(&self) -> usize {
        self.0.depth
    }

    /// The direct parts, in order.
    pub fn children(&self) -> Parts<'_, Term> {
        self.node().children()
    }

    /// Its parts for one who goes through many terms and remembers them: of a long sequence some, and then what follows as
    /// one term, so that what it has in common with a sequence seen before is met at once.
    pub(crate) fn portions(&self) -> impl Iterator<Item = Term> + '_ {
        const PORTION: usize = 32;
        let (count, rest) = match self.node() {
            Node::Seq(parts) if parts.len() > PORTION => {
                // So many that those of all that follow are as many again: they begin at the same places.
                let count = (parts.len() - 1) % PORTION + 1;
                (count, Some(parts.after(count)))
            }
            _ => (usize::MAX, None),
        };
        self.children().take(count).cloned().chain(rest)
    }

    /// The same operator over other parts, as many as [`Term::children`] gives; flattened and sorted anew.
    pub fn with_children(&self, parts: Vec<Term>) -> Term {
        let mut parts = parts.into_iter();
        let mut next = || parts.next().unwrap_or_else(Term::stop);
        match self.node() {
            Node::Seq(_) => Term::seq(parts),
            Node::Par(_) => Term::par(parts),
            Node::Disable(_) => Term::disable(parts),
            Node::Else(..) => {
                let first = next();
                Term::otherwise(first, next())
            }
            Node::Power(_, count, index) => Term::raw(Node::Power(next(), count.clone(), index.clone())),
            Node::Loop(_) => Term::raw(Node::Loop(next())),
            Node::New(port, _) => Term::raw(Node::New(port.clone(), next())),
            Node::Project(_, shown) => Term::raw(Node::Project(next(), shown.clone())),
            Node::Replace(_, name, value) => Term::raw(Node::Replace(next(), name.clone(), value.clone())),
            _ => self.clone(),
        }
    }

    /// The value expressions that stand directly in this operator, in order.
    pub fn values(&self) -> Parts<'_, Value> {
        match self.node() {
            Node::Delay(value) | Node::Out(_, value) | Node::Set(value, _) | Node::Ran(value, _) => Parts::of(value),
            Node::Guard(_, left, right) => Parts::of(left).and(right),
            Node::Observe(_, values) | Node::Call(_, values) | Node::Meta(_, values) => Parts::all(values),
            Node::Power(_, value, _) | Node::Replace(_, _, value) => Parts::of(value),
            _ => Parts::all(&[]),
        }
    }

    /// The same operator with each direct value replaced by its image, the parts unchanged.
    ///
    /// # Errors
    /// The first error that `image` gives.
    pub fn map_values<E>(&self, image: &mut impl FnMut(&Value) -> Result<Value, E>) -> Result<Term, E> {
        let mut each = |values: &[Value]| values.iter().map(&mut *image).collect::<Result<Vec<_>, E>>();
        Ok(Term::new(match self.node() {
            Node::Observe(name, values) => Node::Observe(name.clone(), each(values)?),
            Node::Call(name, values) => Node::Call(name.clone(), each(values)?),
            Node::Meta(name, values) => Node::Meta(name.clone(), each(values)?),
            Node::Delay(value) => Node::Delay(image(value)?),
            Node::Out(port, value) => Node::Out(port.clone(), image(value)?),
            Node::Set(value, name) => Node::Set(image(value)?, name.clone()),
            Node::Ran(value, name) => Node::Ran(image(value)?, name.clone()),
            Node::Guard(relation, left, right) => Node::Guard(*relation, image(left)?, image(right)?),
            Node::Power(body, count, index) => Node::Power(body.clone(), image(count)?, index.clone()),
            Node::Replace(body, name, value) => Node::Replace(body.clone(), name.clone(), image(value)?),
            _ => return Ok(self.clone()),
        }))
    }
}

impl Node {
    fn children(&self) -> Parts<'_, Term> {
        match self {
            Node::Seq(parts) => Parts::all(parts),
            Node::Par(parts) | Node::Disable(parts) => Parts::all(parts),
            Node::Else(first, second) => Parts::of(first).and(second),
            Node::Power(body, ..)
            | Node::Loop(body)
            | Node::New(_, body)
            | Node::Project(body, _)
            | Node::Replace(body, ..) => Parts::of(body),
            _ => Parts::all(&[]),
        }
    }
}

/// Whether what stands side by side here and there is the same in some order, both laid out as [`Term::par`] and
/// [`Term::disable`] do it: what differs, which is not much, is compared with each other.
pub(crate) fn in_some_order(ones: &[Term], others: &[Term], same: &dyn Fn(&Term, &Term) -> bool) -> bool {
    const MOST: usize = 32;
    let (mut ones, mut others) = (ones.iter().peekable(), others.iter().peekable());
    let (mut mine, mut theirs) = (Vec::new(), Vec::new());
    while let (Some(one), Some(other)) = (ones.peek(), others.peek()) {
        match one.cmp(other) {
            Ordering::Equal => {
                ones.next();
                others.next();
            }
            Ordering::Less => mine.extend(ones.next()),
            Ordering::Greater => theirs.extend(others.next()),
        }
    }
    mine.extend(ones);
    theirs.extend(others);
    let mut meets = |one: &Term| theirs.iter().position(|other| same(one, other)).map(|place| theirs.remove(place));
    mine.len() <= MOST && mine.into_iter().all(|one| meets(one).is_some()) && theirs.is_empty()
}

/// What stands directly in an operator, in order.
#[derive(Clone, Debug)]
pub struct Parts<'a, T> {
    first: Option<&'a T>,
    rest: std::slice::Iter<'a, T>,
}

impl<'a, T> Parts<'a, T> {
    fn all(parts: &'a [T]) -> Parts<'a, T> {
        Parts { first: None, rest: parts.iter() }
    }

    fn of(part: &'a T) -> Parts<'a, T> {
        Parts { first: Some(part), rest: [].iter() }
    }

    fn and(self, last: &'a T) -> Parts<'a, T> {
        Parts { rest: std::slice::from_ref(last).iter(), ..self }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'a, T> Iterator for Parts<'a, T> {
    type Item = &'a T;

    fn next(&mut self) -> Option<&'a T> {
        self.first.take().or_else(|| self.rest.next())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let count = usize::from(self.first.is_some()) + self.rest.len();
        (count, Some(count))
    }
}

impl<T> DoubleEndedIterator for Parts<'_, T> {
    fn next_back(&mut self) -> Option<Self::Item> {
        self.rest.next_back().or_else(|| self.first.take())
    }
}

impl<T> ExactSizeIterator for Parts<'_, T> {}

impl PartialEq for Term {
    fn eq(&self, other: &Term) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || (self.0.hash == other.0.hash && self.0.node == other.0.node)
    }
}

impl Eq for Term {}

impl Hash for Term {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.0.hash);
    }
}

impl PartialOrd for Term {
    fn partial_cmp(&self, other: &Term) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Term {
    fn cmp(&self, other: &Term) -> Ordering {
        if Arc::ptr_eq(&self.0, &other.0) { Ordering::Equal } else { self.0.node.cmp(&other.0.node) }
    }
}

/// A map with terms for keys, which bring their hashes along.
pub type TermMap<V> = HashMap<Term, V, BuildHasherDefault<Kept>>;

/// A set of terms, which bring their hashes along.
pub type TermSet = HashSet<Term, BuildHasherDefault<Kept>>;

/// The hash that a term was given when it was made.
#[derive(Clone, Default, Debug)]
pub struct Kept(u64);

impl Hasher for Kept {
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = self.0.rotate_left(8) ^ u64::from(*byte);
        }
    }

    fn write_u64(&mut self, hash: u64) {
        self.0 = hash;
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

impl std::fmt::Debug for Term {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.node().fmt(f)
    }
}
