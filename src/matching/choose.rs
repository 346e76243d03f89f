//! Parts of `|` or `#`, in any order.

use std::cell::OnceCell;
use std::rc::Rc;

use super::shape::may_fit;
use super::{State, may_be_guard, plain_meta, whole};
use crate::fact::Context;
use crate::name::Name;
use crate::term::{Node, Term};

/// How the parts of a `|`, or of a `#`, are put together again.
type Join = fn(Vec<Term>) -> Term;

/// The parts of one `|` or `#`, which are sorted, some of them taken.
pub(super) struct Pool<'p> {
    parts: &'p [Term],
    taken: Vec<bool>,
    left: usize,
    join: Join,
    /// Whether all parts must be taken.
    all: bool,
    /// The facts that must hold of what these metavariables stand for alone.
    wants: Vec<(Name, u16)>,
    /// The facts that hold of each part, found when they are first asked for: most patterns fail before.
    facts: OnceCell<Rc<[u16]>>,
    /// The parts' term, and who knows facts.
    judge: Option<(&'p Term, &'p Context<'p>)>,
}

impl<'p> Pool<'p> {
    /// The parts of a `|`, or of a `#`; nothing of any other operator.
    pub(super) fn of(term: &'p Term, all: bool) -> Option<Pool<'p>> {
        let (parts, join): (&[Term], Join) = match term.node() {
            Node::Par(parts) => (parts, Term::par),
            Node::Disable(parts) => (parts, Term::disable),
            _ => return None,
        };
        let (taken, left) = (vec![false; parts.len()], parts.len());
        Some(Pool { parts, taken, left, join, all, wants: Vec::new(), facts: OnceCell::new(), judge: None })
    }

    /// The same with facts that must hold of what some metavariables stand for alone.
    pub(super) fn wanting(self, wants: Vec<(Name, u16)>, term: &'p Term, context: &'p Context<'p>) -> Pool<'p> {
        Pool { wants, judge: Some((term, context)), ..self }
    }

    fn facts(&self) -> &[u16] {
        let found = || self.judge.map_or_else(|| Rc::from([]), |(term, context)| context.facts_of_parts(term));
        self.facts.get_or_init(found)
    }

    /// What is not taken, and this.
    pub(super) fn joined_with(&self, one: Term) -> Term {
        (self.join)(self.rest().into_iter().chain([one]).collect())
    }

    fn rest(&self) -> Vec<Term> {
        self.free().map(|index| self.parts[index].clone()).collect()
    }

    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parts.len()).filter(|index| !self.taken[*index])
    }

    /// The next free part from `from` on that is no copy of `before`.
    fn next(&self, from: usize, before: Option<usize>) -> Option<usize> {
        let copy = |index: usize| before.is_some_and(|before| self.parts[before] == self.parts[index]);
        (from..self.parts.len()).find(|index| !self.taken[*index] && !copy(*index))
    }

    fn take(&mut self, index: usize) {
        self.taken[index] = true;
        self.left -= 1;
    }

    fn give_back(&mut self, index: usize) {
        self.taken[index] = false;
        self.left += 1;
    }

    /// Takes all parts of a term that is known; nothing if they are not all there.
    fn remove(&mut self, known: &Term) -> Option<Vec<usize>> {
        let one = [known.clone()];
        let pieces: &[Term] = match (known.node(), self.parallel()) {
            (Node::Par(pieces), true) | (Node::Disable(pieces), false) => pieces,
            _ => &one,
        };
        let mut removed = Vec::with_capacity(pieces.len());
        for piece in pieces {
            let start = self.parts.partition_point(|part| part < piece);
            let copies = (start..self.parts.len()).take_while(|index| self.parts[*index] == *piece);
            let Some(index) = copies.into_iter().find(|index| !self.taken[*index]) else {
                removed.into_iter().for_each(|index| self.give_back(index));
                return None;
            };
            self.take(index);
            removed.push(index);
        }
        Some(removed)
    }

    fn parallel(&self) -> bool {
        std::ptr::fn_addr_eq(self.join, Term::par as Join)
    }

    fn wanted(&self, name: &Name) -> Option<u16> {
        self.wants.iter().find(|(other, _)| other == name).map(|(_, wanted)| *wanted)
    }

    fn is_unfit(&self, name: &Name, index: usize) -> bool {
        self.wanted(name).is_some_and(|wanted| wanted & !self.facts()[index] != 0)
    }

    /// How many parts a metavariable may stand for alone.
    fn fitting(&self, name: &Name) -> usize {
        let fitting = |wanted: u16| self.facts().iter().filter(|facts| wanted & !**facts == 0).count();
        self.wanted(name).map_or(self.parts.len(), fitting)
    }
}

/// What is done with a match and what it leaves over; true ends the search.
pub(super) type Found<'f> = dyn FnMut(State, &Pool<'_>) -> bool + 'f;

/// Matches the patterns with parts of the pool: first what is no bare metavariable, then those that are known, then
/// those that the fewest parts may stand for.
pub(super) fn choose(wanted: &[&Term], pool: &mut Pool<'_>, state: State, found: &mut Found<'_>) -> bool {
    let known = |pattern: &&Term| plain_meta(pattern).is_some_and(|name| state.found.processes.contains_key(&name));
    let fitting = |pattern: &&Term| plain_meta(pattern).map_or(0, |name| pool.fitting(&name));
    let position = wanted.iter().position(|pattern| plain_meta(pattern).is_none());
    let position = position.or_else(|| wanted.iter().position(known));
    let fewest = || (0..wanted.len()).min_by_key(|index| fitting(&wanted[*index]));
    let Some(next) = position.or_else(fewest) else {
        return (!pool.all || pool.left == 0) && found(state, pool);
    };
    let others: Vec<&Term> =
        wanted.iter().enumerate().filter(|(index, _)| *index != next).map(|(_, one)| *one).collect();
    if let Some(name) = plain_meta(wanted[next]) {
        return choose_for_meta(&name, &others, pool, state, found);
    }
    let mut current = pool.next(0, None);
    while let Some(index) = current {
        if !may_fit(wanted[next], &pool.parts[index]) || is_unread(&pool.parts[index], &state) {
            current = pool.next(index + 1, Some(index));
            continue;
        }
        pool.take(index);
        let done =
            whole(wanted[next], &pool.parts[index], state.clone(), &mut |state| choose(&others, pool, state, found));
        pool.give_back(index);
        if done {
            return true;
        }
        current = pool.next(index + 1, Some(index));
    }
    false
}

/// Whether a part sets what nobody reads to whom the law would tell it.
fn is_unread(part: &Term, state: &State) -> bool {
    let (Some(read), Node::Set(_, name)) = (&state.read, part.node()) else { return false };
    let metas = read.names.range(Name::new("?")..).next().is_some_and(Name::is_meta);
    !metas && read.processes.is_empty() && !read.names.contains(name) && !name.is_meta()
}

fn choose_for_meta(name: &Name, others: &[&Term], pool: &mut Pool<'_>, state: State, found: &mut Found<'_>) -> bool {
    if let Some(known) = state.found.processes.get(name).cloned() {
        let Some(removed) = pool.remove(&known) else { return false };
        let done = choose(others, pool, state, found);
        removed.into_iter().for_each(|index| pool.give_back(index));
        return done;
    }
    if others.is_empty() && (pool.all || pool.left > 1) && !state.guards.contains(name) {
        let rest: Vec<usize> = pool.free().collect();
        let mut state = state.clone();
        state.found.processes.insert(name.clone(), (pool.join)(pool.rest()));
        rest.iter().for_each(|index| pool.take(*index));
        let done = found(state, pool);
        rest.into_iter().for_each(|index| pool.give_back(index));
        if done || pool.all {
            return done;
        }
    }
    let guard = state.guards.contains(name);
    let mut current = pool.next(0, None);
    while let Some(index) = current {
        if !(guard && !may_be_guard(&pool.parts[index]) || pool.is_unfit(name, index)) {
            let mut state = state.clone();
            state.found.processes.insert(name.clone(), pool.parts[index].clone());
            pool.take(index);
            let done = choose(others, pool, state, found);
            pool.give_back(index);
            if done {
                return true;
            }
        }
        current = pool.next(index + 1, Some(index));
    }
    false
}
