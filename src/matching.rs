//! Matching of a law's side against a term, modulo the shape of terms and the units `Stop` of `;`, `Idle` of `#`.
//!
//! A metavariable may stand for a run of parts of `;`, or for several parts of `|` and `#`. What a match leaves
//! over beside it is handed back as the context in which the law is then applied.

mod choose;
mod shape;
mod value;

use std::rc::Rc;

use crate::fact::{Context, Facts, NameSet};
use crate::law::{Condition, Fact, Law};
use crate::name::Name;
use crate::proof::hole;
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

use choose::{Pool, choose};
use shape::{all_there, is_bare};
use value::solve;

/// One way in which a law applies to a term: `surrounding` with its hole filled by the instance is the term.
#[derive(Clone, Debug)]
pub struct Match {
    /// What the metavariables stand for.
    pub substitution: Substitution,
    /// The rest of the term, with the hole `?1`.
    pub surrounding: Term,
}

/// In a sequence with more parts a metavariable at its start is tried for one part only, as it is further on.
const LONG: usize = 64;

/// Of a rest with more parts a metavariable takes this many at once: what a law says of them it says of the next ones in
/// its turn, and the whole rest would be looked at again at every place.
const VERY_LONG: usize = 1_024;
const WINDOW: usize = 64;

/// The most matches of one law at one place that are looked at.
const MOST: usize = 64;

#[derive(Clone, Default)]
struct State {
    found: Substitution,
    /// Whether each of two metavariables in sequence may stand for Stop. Not for laws that simplification uses:
    /// they would apply to their own results for ever.
    empty: bool,
    /// Metavariables that the law wants to be guards.
    guards: Rc<[Name]>,
    /// Values that must turn out equal once their metavariables are known.
    later: Vec<(Value, Value)>,
    /// Of what is set, the law puts only this into what follows.
    read: Option<Rc<NameSet>>,
}

/// All ways in which `pattern`, a side of `law`, applies at the root of `term` with the conditions met, at most 64.
pub fn matches(law: &Law, pattern: &Term, term: &Term, context: &Context<'_>) -> Vec<Match> {
    let mut out = Vec::new();
    let fits = Fits { law, context };
    at_root(pattern, term, &start(law), &fits, &mut |state, surrounding| {
        if let Some(substitution) = settle(law, state, context) {
            out.push(Match { substitution, surrounding: surrounding() });
        }
        out.len() >= MOST
    });
    out
}

/// The first of [`matches`].
pub fn first_match(law: &Law, pattern: &Term, term: &Term, context: &Context<'_>) -> Option<Match> {
    let mut out = None;
    let fits = Fits { law, context };
    at_root(pattern, term, &start(law), &fits, &mut |state, surrounding| {
        out = settle(law, state, context).map(|substitution| Match { substitution, surrounding: surrounding() });
        out.is_some()
    });
    out
}

/// Decides conditions and the values left open; a metavariable that only a condition mentions is found from it.
fn settle(law: &Law, mut state: State, context: &Context<'_>) -> Option<Substitution> {
    for condition in &law.conditions {
        if let Condition::Lasts(subject, time) = condition
            && let Some(name) = time.as_variable().cloned()
            && name.is_meta()
            && !state.found.values.contains_key(&name)
        {
            let subject = state.found.apply(subject, context).ok()?;
            let duration = Facts::of(&subject, context).duration.clone()?;
            state.found.values.insert(name, duration);
        }
    }
    let later = std::mem::take(&mut state.later);
    for (pattern, value) in later {
        if !solve(&pattern, &value, &mut state) || !state.later.is_empty() {
            return None;
        }
    }
    for condition in &law.conditions {
        let instance = state.found.condition(condition, context).ok()?;
        if !context.holds(&instance) {
            return None;
        }
    }
    Some(state.found)
}

fn start(law: &Law) -> State {
    let mut guards = Vec::new();
    for condition in &law.conditions {
        match condition {
            Condition::Complementary(one, two) => guards.extend([one, two].into_iter().filter_map(plain_meta)),
            Condition::Is(Fact::Guard, one) => guards.extend(plain_meta(one)),
            _ => {}
        }
    }
    State { empty: !law.oriented, guards: guards.into(), ..State::default() }
}

/// The conditions that a law has on one metavariable alone.
struct Fits<'a> {
    law: &'a Law,
    context: &'a Context<'a>,
}

impl Fits<'_> {
    /// The facts that must hold of it, as bits.
    fn wants(&self, name: &Name) -> u16 {
        let own =
            |subject: &Term| matches!(subject.node(), Node::Meta(other, given) if other == name && given.is_empty());
        self.law.conditions.iter().fold(0, |all, condition| match condition {
            Condition::Is(fact, subject) if own(subject) => all | 1 << *fact as u16,
            _ => all,
        })
    }

    /// What follows a `|` may read, if the law does no more than put there what one of its parts has set.
    fn read(&self, wanted: &[Term], parts: &[Term]) -> Option<Rc<NameSet>> {
        let ([set, next], [first, rest @ ..], Node::Seq(result)) = (wanted, parts, self.law.right.node()) else {
            return None;
        };
        let (Node::Par(_), Node::Par(_), [kept, put]) = (set.node(), first.node(), &**result) else {
            return None;
        };
        let Node::Replace(process, ..) = put.node() else { return None };
        let follows = || Term::seq(rest[..most(rest.len())].iter().cloned());
        (kept == set && process == next).then(|| Rc::new(Facts::of(&follows(), self.context).reads.clone()))
    }
}

/// What is done with a match, and with the term around it, should it be wanted; true ends the search.
type Found<'f> = dyn FnMut(State, &dyn Fn() -> Term) -> bool + 'f;

/// Calls `found` with each match and what is left over, until it returns true.
fn at_root(pattern: &Term, term: &Term, start: &State, fits: &Fits<'_>, found: &mut Found<'_>) -> bool {
    let one = || Term::meta(&hole(1));
    match (pattern.node(), term.node()) {
        (Node::Seq(wanted), Node::Seq(parts)) => in_sequence(wanted, (term, parts), start, fits, found),
        (Node::Par(wanted), Node::Par(parts)) | (Node::Disable(wanted), Node::Disable(parts)) => {
            let Some(pool) = Pool::of(term, false).filter(|_| all_there(wanted, parts)) else { return false };
            // `?P | ?P` needs two of a kind, which stand together.
            if matches!(&wanted[..], [one, other] if one == other) && parts.windows(2).all(|two| two[0] != two[1]) {
                return false;
            }
            let wants = wanted.iter().filter_map(plain_meta).map(|name| (fits.wants(&name), name));
            let wants = wants.filter(|(facts, _)| *facts != 0).map(|(facts, name)| (name, facts)).collect();
            let mut pool = pool.wanting(wants, term, fits.context);
            choose(&wanted.iter().collect::<Vec<_>>(), &mut pool, start.clone(), &mut |state, pool| {
                found(state, &|| pool.joined_with(one()))
            })
        }
        _ => whole(pattern, term, start.clone(), &mut |state| found(state, &one)),
    }
}

/// The runs of a sequence, from its first part on.
fn in_sequence(
    wanted: &[Term],
    (term, parts): (&Term, &[Term]),
    start: &State,
    fits: &Fits<'_>,
    found: &mut Found<'_>,
) -> bool {
    // A metavariable at the start of a run further on stands for that one part.
    let first = wanted.first().and_then(plain_meta);
    let first = first.filter(|name| !wanted.get(1).is_some_and(|next| within(next, name)));
    let wants = first.map_or(0, |name| fits.wants(&name));
    let facts = if wants == 0 { Rc::from([]) } else { fits.context.facts_of_parts(term) };
    let meets = |place: usize| facts.get(place).is_none_or(|facts| wants & !facts == 0);
    (0..parts.len()).any(|place| {
        if (place > 0 || parts.len() > LONG) && !meets(place) || is_vain(wanted, &parts[place..], fits) {
            return false;
        }
        let at = if place == 0 && parts.len() <= LONG { Place::Start } else { Place::Later };
        let mut start = start.clone();
        start.read = fits.read(wanted, &parts[place..]);
        window(wanted, &parts[place..], at, start, &mut |state, used| {
            found(state, &|| {
                let before = parts[..place].iter().cloned();
                let after = parts[place + used..].iter().cloned();
                Term::seq(before.chain([Term::meta(&hole(1))]).chain(after))
            })
        })
    })
}

/// Whether a `|` and what follows it cannot fit, since nothing follows or nothing that meets the conditions on it: a `|`
/// of n parts is two in n ways, none of which then needs to be tried.
fn is_vain(wanted: &[Term], parts: &[Term], fits: &Fits<'_>) -> bool {
    let ([one, next], [first, rest @ ..]) = (wanted, parts) else { return false };
    let (Node::Par(_), Node::Par(_), Some(name)) = (one.node(), first.node(), plain_meta(next)) else { return false };
    let wants = fits.wants(&name);
    let meets = |run: &[Term]| wants & !fits.context.facts_held(&Term::seq(run.iter().cloned())) == 0;
    match rest.len() {
        0 => fits.law.oriented,
        all => !meets(&rest[..1]) && !meets(&rest[..most(all)]),
    }
}

/// The most parts of a rest that a metavariable takes at once.
fn most(rest: usize) -> usize {
    if rest > VERY_LONG { WINDOW } else { rest }
}

/// Where a run of parts begins: what may be taken there differs, to keep the number of ways small.
#[derive(Clone, Copy)]
enum Place {
    /// At the first part of the sequence at which a law is applied.
    Start,
    /// At a later part of it.
    Later,
    /// In a sequence inside, which must be used up; a metavariable may stand for no part at all, that is for Stop.
    Inside,
}

impl Place {
    fn next(self) -> Place {
        match self {
            Place::Inside => Place::Inside,
            _ => Place::Later,
        }
    }
}

/// A run of parts of a sequence, from its start; gives how many parts it took.
fn window(
    wanted: &[Term],
    parts: &[Term],
    at: Place,
    state: State,
    found: &mut dyn FnMut(State, usize) -> bool,
) -> bool {
    let Some((first, rest)) = wanted.split_first() else {
        return found(state, 0);
    };
    let Some(name) = plain_meta(first) else {
        let Some((part, others)) = parts.split_first() else { return false };
        return whole(first, part, state, &mut |state| {
            window(rest, others, at.next(), state, &mut |state, used| found(state, used + 1))
        });
    };
    if let Some(known) = state.found.processes.get(&name) {
        let known = sequence_of(known);
        let fits = parts.len() >= known.len() && parts[..known.len()] == known[..];
        let taken = known.len();
        return fits && window(rest, &parts[taken..], at.next(), state, &mut |state, used| found(state, used + taken));
    }
    let last = match rest {
        [only] if matches!(at, Place::Inside) => plain_meta(only).and_then(|name| state.found.processes.get(&name)),
        _ => None,
    };
    let lengths: Vec<usize> = match (at, rest.is_empty(), parts.len()) {
        // What ends the run is known, and with it how much is left.
        (Place::Inside, false, all) if last.is_some() => {
            all.checked_sub(last.map_or(0, |last| sequence_of(last).len())).into_iter().collect()
        }
        (Place::Inside, true, all) => vec![all],
        (Place::Inside, false, all) => (0..=all).collect(),
        (_, true, 0) if state.empty => vec![0],
        (_, true, 0) => return false,
        (_, true, 1) => vec![1],
        (_, true, all) => vec![most(all), 1],
        (_, false, 0) => return false,
        (Place::Start, false, all) => (1..=all).collect(),
        (Place::Later, false, all) if rest.first().is_some_and(|next| within(next, &name)) => (1..=all).collect(),
        (Place::Later, false, _) => vec![1],
    };
    // A guard is one part, and known at once.
    let guard = state.guards.contains(&name);
    lengths.into_iter().any(|length| {
        if guard && (length != 1 || !parts.first().is_some_and(may_be_guard)) {
            return false;
        }
        if rest.first().is_some_and(|next| differs(next, parts.get(length))) {
            return false;
        }
        let mut state = state.clone();
        state.found.processes.insert(name.clone(), Term::seq(parts[..length].iter().cloned()));
        window(rest, &parts[length..], at.next(), state, &mut |state, used| found(state, used + length))
    })
}

/// Whether a pattern is a loop or power of this metavariable, which then is known by its body.
fn within(pattern: &Term, name: &Name) -> bool {
    match pattern.node() {
        Node::Loop(body) | Node::Power(body, ..) => plain_meta(body).as_ref() == Some(name),
        _ => false,
    }
}

/// Whether a pattern that fits one kind of part alone cannot fit this one.
fn differs(pattern: &Term, part: Option<&Term>) -> bool {
    match pattern.node() {
        Node::Loop(_) | Node::Power(..) | Node::Guard(..) | Node::In(..) | Node::Out(..) | Node::New(..) => {
            part.is_none_or(|part| std::mem::discriminant(pattern.node()) != std::mem::discriminant(part.node()))
        }
        _ => false,
    }
}

fn may_be_guard(term: &Term) -> bool {
    matches!(term.node(), Node::Guard(..) | Node::Meta(..) | Node::Replace(..))
}

fn sequence_of(term: &Term) -> Vec<Term> {
    match term.node() {
        Node::Seq(parts) => parts.to_vec(),
        Node::Stop => Vec::new(),
        _ => vec![term.clone()],
    }
}

fn plain_meta(pattern: &Term) -> Option<Name> {
    match pattern.node() {
        Node::Meta(name, arguments) if arguments.is_empty() => Some(name.clone()),
        _ => None,
    }
}

/// The pattern against the whole term.
fn whole(pattern: &Term, term: &Term, state: State, found: &mut dyn FnMut(State) -> bool) -> bool {
    if let Some(name) = plain_meta(pattern) {
        return match state.found.processes.get(&name) {
            Some(known) => known == term && found(state),
            None => {
                let mut state = state;
                state.found.processes.insert(name, term.clone());
                found(state)
            }
        };
    }
    match (pattern.node(), term.node()) {
        (Node::Seq(wanted), _) => {
            let solid = state.empty || wanted.len() > 2 || wanted.iter().any(|pattern| !is_bare(pattern));
            if !solid && !matches!(term.node(), Node::Seq(_)) {
                return false;
            }
            let parts = sequence_of(term);
            let total = parts.len();
            let mut full = |state: State, used: usize| {
                let empty = |name: Name| state.found.processes.get(&name) == Some(&Term::stop());
                let proper = solid || !wanted.iter().filter_map(plain_meta).any(empty);
                used == total && proper && found(state)
            };
            window(wanted, &parts, Place::Inside, state, &mut full)
        }
        (Node::Par(wanted), Node::Par(_)) | (Node::Disable(wanted), Node::Disable(_)) => {
            let Some(mut pool) = Pool::of(term, true) else { return false };
            choose(&wanted.iter().collect::<Vec<_>>(), &mut pool, state, &mut |state, _| found(state))
        }
        (Node::Disable(wanted), _) => beside_idle(wanted, term, state, found),
        _ => leaf(pattern, term, state, found),
    }
}

/// `P # ?O` against a term without `#`: ?O is Idle.
fn beside_idle(wanted: &[Term], term: &Term, mut state: State, found: &mut dyn FnMut(State) -> bool) -> bool {
    let mut solid = None;
    for pattern in wanted {
        match plain_meta(pattern) {
            Some(name) => match state.found.processes.get(&name) {
                Some(known) if *known != Term::idle() => return false,
                _ => {
                    state.found.processes.insert(name, Term::idle());
                }
            },
            None if solid.is_none() => solid = Some(pattern),
            None => return false,
        }
    }
    solid.is_some_and(|pattern| whole(pattern, term, state, found))
}

fn leaf(pattern: &Term, term: &Term, mut state: State, found: &mut dyn FnMut(State) -> bool) -> bool {
    if !head(pattern, term, &mut state) {
        return false;
    }
    let (wanted, given) = (pattern.values(), term.values());
    if wanted.len() != given.len() || !wanted.into_iter().zip(given).all(|(w, g)| solve(w, g, &mut state)) {
        return false;
    }
    let (wanted, given): (Vec<&Term>, Vec<&Term>) = (pattern.children().collect(), term.children().collect());
    match (wanted.as_slice(), given.as_slice()) {
        ([], []) => found(state),
        ([one], [given]) => whole(one, given, state, found),
        ([one, two], [first, second]) => whole(one, first, state, &mut |state| whole(two, second, state, found)),
        _ => false,
    }
}

/// Operators and names, not values and parts.
fn head(pattern: &Term, term: &Term, state: &mut State) -> bool {
    let mut name = |wanted: &Name, given: &Name| {
        if !wanted.is_meta() {
            return wanted == given;
        }
        state.found.names.entry(wanted.clone()).or_insert_with(|| given.clone()) == given
    };
    match (pattern.node(), term.node()) {
        (Node::Stop, Node::Stop) | (Node::Abort, Node::Abort) | (Node::Idle, Node::Idle) => true,
        (Node::Delay(_), Node::Delay(_)) | (Node::Else(..), Node::Else(..)) | (Node::Loop(_), Node::Loop(_)) => true,
        (Node::In(port, result), Node::In(other, given)) => name(port, other) && name(result, given),
        (Node::Out(port, _), Node::Out(other, _)) | (Node::New(port, _), Node::New(other, _)) => name(port, other),
        (Node::Guard(relation, ..), Node::Guard(other, ..)) => relation == other,
        (Node::Set(_, result), Node::Set(_, given)) | (Node::Ran(_, result), Node::Ran(_, given)) => {
            name(result, given)
        }
        (Node::Observe(wanted, _), Node::Observe(given, _)) | (Node::Call(wanted, _), Node::Call(given, _)) => {
            wanted == given
        }
        (Node::Meta(wanted, _), Node::Meta(given, _)) => wanted == given,
        (Node::Power(_, _, None), Node::Power(_, _, None)) => true,
        (Node::Power(_, _, Some(index)), Node::Power(_, _, Some(given))) => name(index, given),
        (Node::Project(_, wanted), Node::Project(_, given)) => {
            let meta = wanted.iter().next().filter(|first| wanted.len() == 1 && first.is_meta());
            match meta {
                Some(meta) => state.found.sets.entry(meta.clone()).or_insert_with(|| given.clone()) == given,
                None => wanted == given,
            }
        }
        _ => false,
    }
}
