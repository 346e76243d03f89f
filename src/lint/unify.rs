//! Unification of the sides of laws: sequences up to grouping, lists of `|` and `#` up to grouping and order.
//!
//! A metavariable takes any number of parts, at least one; in lists two of them may share what is new. What is not found:
//! sequences in which two metavariables share a part of each, lists of more than six parts, and more than
//! [`MOST_WAYS`] ways.

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::fact::Context;
use crate::name::Name;
use crate::scope::metavariables;
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

/// The most ways in which two sides are unified.
const MOST_WAYS: usize = 48;
/// The most steps of one unification.
const MOST_STEPS: usize = 2_000;
/// The most parts of a list, surroundings included.
const MOST_PARTS: usize = 7;
/// The most pairs of metavariables that may share something.
const MOST_SHARED: usize = 6;

/// Two things to be made equal.
#[derive(Clone)]
pub(super) enum Goal {
    Terms(Term, Term),
    Values(Value, Value),
    Names(Name, Name),
}

/// Substitutions that make all goals equal, to be applied again and again; at most [`MOST_WAYS`].
///
/// What stands for the name of a result stands for no other value.
pub(super) fn unify(goals: Vec<Goal>, results: &BTreeSet<Name>) -> Vec<Substitution> {
    let mut ways = Vec::new();
    let mut open = vec![(goals, Substitution::default())];
    for _ in 0..MOST_STEPS {
        let Some((mut goals, way)) = open.pop() else { break };
        let Some(goal) = goals.pop() else {
            ways.push(way);
            if ways.len() >= MOST_WAYS {
                break;
            }
            continue;
        };
        let next = match goal {
            Goal::Terms(one, two) => terms(&one, &two, way),
            Goal::Values(one, two) => {
                values(&one, &two, way, results).into_iter().map(|way| (Vec::new(), way)).collect()
            }
            Goal::Names(one, two) => names(&one, &two, way).into_iter().map(|way| (Vec::new(), way)).collect(),
        };
        for (more, way) in next {
            open.push((goals.iter().cloned().chain(more).collect(), way));
        }
    }
    ways
}

type Branches = Vec<(Vec<Goal>, Substitution)>;

fn terms(one: &Term, two: &Term, way: Substitution) -> Branches {
    let (one, two) = (followed(one, &way), followed(two, &way));
    if one == two {
        return vec![(Vec::new(), way)];
    }
    for (meta, image) in [(&one, &two), (&two, &one)] {
        if let Some(name) = plain_meta(meta) {
            let (assumptions, definitions) = Default::default();
            let context = Context::new(&assumptions, &definitions, &[]);
            let Some(image) = resolved(&way, image, &context) else { return Vec::new() };
            if metavariables(&image).contains(name) {
                return Vec::new();
            }
            let mut way = way;
            way.processes.insert(name.clone(), image);
            return vec![(Vec::new(), way)];
        }
    }
    match (one.node(), two.node()) {
        (Node::Seq(a), Node::Seq(b)) => sequences(a, b).into_iter().map(|goals| (goals, way.clone())).collect(),
        (Node::Par(a), Node::Par(b)) => within(a, b, Term::par, way),
        (Node::Disable(a), Node::Disable(b)) => within(a, b, Term::disable, way),
        _ => match heads(&one, &two) {
            Some(goals) => vec![(goals, way)],
            None => Vec::new(),
        },
    }
}

fn within(one: &[Term], two: &[Term], join: fn(Vec<Term>) -> Term, way: Substitution) -> Branches {
    // Names that are in use, so that parts that are shared are new.
    let bound = way.processes.iter().flat_map(|(name, image)| metavariables(image).into_iter().chain([name.clone()]));
    let own = one.iter().chain(two).flat_map(metavariables);
    let taken: BTreeSet<Name> = bound.chain(own).collect();
    lists(one, two, &taken, None, None, join).into_iter().map(|goals| (goals, way.clone())).collect()
}

/// What a bound metavariable stands for.
fn followed(term: &Term, way: &Substitution) -> Term {
    let mut term = term.clone();
    while let Some(image) = plain_meta(&term).and_then(|name| way.processes.get(name)) {
        term = image.clone();
    }
    term
}

/// The ways to make two sequences equal: part by part, where a metavariable may take several parts of the other in a row.
pub(super) fn sequences(one: &[Term], two: &[Term]) -> Vec<Vec<Goal>> {
    let mut all = Vec::new();
    let mut open: Vec<(usize, usize, Vec<Goal>)> = vec![(0, 0, Vec::new())];
    while let Some((a, b, goals)) = open.pop() {
        if all.len() >= MOST_WAYS || open.len() > MOST_STEPS {
            break;
        }
        let (Some(mine), Some(theirs)) = (one.get(a), two.get(b)) else {
            if a == one.len() && b == two.len() {
                all.push(goals);
            }
            continue;
        };
        let mut next = |a: usize, b: usize, goal: Goal| {
            open.push((a, b, goals.iter().cloned().chain([goal]).collect()));
        };
        for end in (b + 2..=two.len()).filter(|_| plain_meta(mine).is_some()) {
            next(a + 1, end, Goal::Terms(mine.clone(), Term::seq(two[b..end].iter().cloned())));
        }
        for end in (a + 2..=one.len()).filter(|_| plain_meta(theirs).is_some()) {
            next(end, b + 1, Goal::Terms(theirs.clone(), Term::seq(one[a..end].iter().cloned())));
        }
        next(a + 1, b + 1, Goal::Terms(mine.clone(), theirs.clone()));
    }
    all
}

/// Where the parts of a list go: each to a part of the other list.
struct Plan {
    /// For each part of the first list that is no metavariable, its place in the second.
    first: Vec<(usize, usize)>,
    /// For each part of the second list that went to no such part, the metavariable of the first that takes it.
    second: Vec<(usize, usize)>,
}

/// The ways to make two lists of `|` or `#` equal, in any order: each part meets a part of the other list, or is among
/// what a metavariable of the other list takes; two metavariables may share a part that is new. A metavariable at one of
/// the extra places stands for the surroundings; then ways in which the lists do not meet are left out.
pub(super) fn lists(
    one: &[Term],
    two: &[Term],
    taken: &BTreeSet<Name>,
    extra_one: Option<usize>,
    extra_two: Option<usize>,
    join: fn(Vec<Term>) -> Term,
) -> Vec<Vec<Goal>> {
    if one.len() > MOST_PARTS || two.len() > MOST_PARTS {
        return Vec::new();
    }
    let metas = |parts: &[Term]| -> Vec<usize> {
        (0..parts.len()).filter(|place| plain_meta(&parts[*place]).is_some()).collect()
    };
    let (mine, theirs) = (metas(one), metas(two));
    let mut all = Vec::new();
    for plan in plans(one, two, &mine, &theirs) {
        let pairs = mine.iter().flat_map(|a| theirs.iter().map(move |b| (*a, *b)));
        let pairs: Vec<(usize, usize)> = pairs.take(MOST_SHARED).collect();
        for set in 0..1u32 << pairs.len() {
            let shared: Vec<(usize, usize)> =
                pairs.iter().enumerate().filter(|(at, _)| set >> at & 1 == 1).map(|(_, pair)| *pair).collect();
            let links: Vec<(usize, usize)> = plan.first.iter().chain(&plan.second).chain(&shared).copied().collect();
            // Two metavariables that share something leave each other as they are.
            let outer = |(a, b): &(usize, usize)| Some(*a) == extra_one || Some(*b) == extra_two;
            let open = |link: &(usize, usize)| outer(link) || mine.contains(&link.0) && theirs.contains(&link.1);
            let alone = extra_one.is_none() && extra_two.is_none();
            if !alone && links.iter().all(open) || !meet(&links, (one.len(), two.len()), extra_one, extra_two) {
                continue;
            }
            all.push(goals(one, two, &plan, &shared, taken, join));
            if all.len() >= MOST_WAYS {
                return all;
            }
        }
    }
    all
}

/// Whether every part has met another, and the lists proper have parts in common where there are surroundings.
fn meet(links: &[(usize, usize)], (one, two): (usize, usize), here: Option<usize>, there: Option<usize>) -> bool {
    let whole = (0..one).all(|a| links.iter().any(|link| link.0 == a))
        && (0..two).all(|b| links.iter().any(|link| link.1 == b));
    let proper: Vec<&(usize, usize)> = links.iter().filter(|(a, b)| Some(*a) != here && Some(*b) != there).collect();
    // What lies wholly in one part of the other list leaves that list as it is.
    let within = |side: &dyn Fn(&(usize, usize)) -> usize| {
        proper.first().is_some_and(|first| proper.iter().all(|link| side(link) == side(first)))
    };
    let apart = (here.is_some() || there.is_some()) && proper.is_empty();
    // Surroundings that meet each other alone say nothing.
    let common = matches!((here, there), (Some(a), Some(b)) if links.contains(&(a, b)));
    let inside = |side: &dyn Fn(&(usize, usize)) -> usize, count: usize, extra: Option<usize>| {
        extra.is_some() && count > 2 && proper.len() == count - 1 && within(side)
    };
    whole && !apart && !common && !inside(&|link| link.0, two, there) && !inside(&|link| link.1, one, here)
}

fn plans(one: &[Term], two: &[Term], mine: &[usize], theirs: &[usize]) -> Vec<Plan> {
    let solid = |parts: &[Term], metas: &[usize]| -> Vec<usize> {
        (0..parts.len()).filter(|place| !metas.contains(place)).collect()
    };
    let (left, right) = (solid(one, mine), solid(two, theirs));
    let mut open = vec![Vec::new()];
    for a in &left {
        let longer = |plan: &Vec<(usize, usize)>| -> Vec<Vec<(usize, usize)>> {
            let free = right.iter().filter(|b| !plan.iter().any(|link| link.1 == **b));
            free.chain(theirs).map(|b| plan.iter().copied().chain([(*a, *b)]).collect()).collect()
        };
        open = open.iter().flat_map(longer).take(MOST_STEPS).collect();
    }
    let mut all = Vec::new();
    for first in open {
        let rest: Vec<usize> = right.iter().filter(|b| !first.iter().any(|link| link.1 == **b)).copied().collect();
        let mut ways = vec![Vec::new()];
        for b in &rest {
            let longer = |way: &Vec<(usize, usize)>| -> Vec<Vec<(usize, usize)>> {
                mine.iter().map(|a| way.iter().copied().chain([(*a, *b)]).collect()).collect()
            };
            ways = ways.iter().flat_map(longer).take(MOST_STEPS).collect();
        }
        all.extend(ways.into_iter().map(|second| Plan { first: first.clone(), second }));
    }
    all
}

fn goals(
    one: &[Term],
    two: &[Term],
    plan: &Plan,
    shared: &[(usize, usize)],
    taken: &BTreeSet<Name>,
    join: fn(Vec<Term>) -> Term,
) -> Vec<Goal> {
    let mut taken_now = taken.clone();
    let mut new = || {
        let mut number = 1;
        while taken_now.contains(&Name::new(&format!("?Z{number}"))) {
            number += 1;
        }
        let name = Name::new(&format!("?Z{number}"));
        taken_now.insert(name.clone());
        Term::meta(&name)
    };
    let fresh: Vec<((usize, usize), Term)> = shared.iter().map(|pair| (*pair, new())).collect();
    let mut all = Vec::new();
    let meta = |parts: &[Term], place: usize| plain_meta(&parts[place]).is_some();
    for (a, part) in one.iter().enumerate().filter(|(a, _)| meta(one, *a)) {
        let mut takes: Vec<Term> =
            plan.second.iter().filter(|link| link.0 == a).map(|link| two[link.1].clone()).collect();
        takes.extend(fresh.iter().filter(|(pair, _)| pair.0 == a).map(|(_, part)| part.clone()));
        all.push(Goal::Terms(part.clone(), join(takes)));
    }
    for (b, part) in two.iter().enumerate().filter(|(b, _)| meta(two, *b)) {
        let mut takes: Vec<Term> =
            plan.first.iter().filter(|link| link.1 == b).map(|link| one[link.0].clone()).collect();
        takes.extend(fresh.iter().filter(|(pair, _)| pair.1 == b).map(|(_, part)| part.clone()));
        all.push(Goal::Terms(part.clone(), join(takes)));
    }
    for (a, b) in plan.first.iter().filter(|(_, b)| !meta(two, *b)) {
        all.push(Goal::Terms(one[*a].clone(), two[*b].clone()));
    }
    all
}

/// What must be equal for two operators of one kind to be; none where they are of different kinds.
fn heads(one: &Term, two: &Term) -> Option<Vec<Goal>> {
    let mut goals = Vec::new();
    let mut name = |a: &Name, b: &Name| goals.push(Goal::Names(a.clone(), b.clone()));
    match (one.node(), two.node()) {
        (Node::In(a, b), Node::In(c, d)) => {
            name(a, c);
            name(b, d);
        }
        (Node::Out(a, _), Node::Out(b, _)) | (Node::New(a, _), Node::New(b, _)) => name(a, b),
        (Node::Set(_, a), Node::Set(_, b)) | (Node::Ran(_, a), Node::Ran(_, b)) => name(a, b),
        (Node::Guard(a, ..), Node::Guard(b, ..)) if a != b => return None,
        (Node::Observe(a, _), Node::Observe(b, _)) | (Node::Call(a, _), Node::Call(b, _)) if a != b => return None,
        (Node::Power(_, _, None), Node::Power(_, _, None)) => {}
        (Node::Power(..) | Node::Project(..) | Node::Replace(..) | Node::Meta(..), _) => return None,
        (a, b) if std::mem::discriminant(a) != std::mem::discriminant(b) => return None,
        _ => {}
    }
    let (a, b) = (one.values(), two.values());
    let (c, d) = (one.children(), two.children());
    if a.len() != b.len() || c.len() != d.len() {
        return None;
    }
    goals.extend(a.into_iter().zip(b).map(|(a, b)| Goal::Values(a.clone(), b.clone())));
    goals.extend(c.into_iter().zip(d).map(|(c, d)| Goal::Terms(c.clone(), d.clone())));
    Some(goals)
}

fn values(one: &Value, two: &Value, mut way: Substitution, results: &BTreeSet<Name>) -> Option<Substitution> {
    let (mut one, mut two) = (one.clone(), two.clone());
    let definitions = Definitions::default();
    let context = Context::new(&Assumptions::default(), &definitions, &[]);
    for _ in 0..10 {
        (one, two) = (way.value(&one, &context).ok()?, way.value(&two, &context).ok()?);
    }
    if one == two {
        return Some(way);
    }
    let bound =
        |value: &Value| value.variables().iter().any(|name| results.contains(name) || way.names.contains_key(name));
    if bound(&one) || bound(&two) {
        return names(one.as_variable()?, two.as_variable()?, way);
    }
    for (meta, image) in [(&one, &two), (&two, &one)] {
        if let Some(name) = meta.as_variable().filter(|name| name.is_meta() && !image.mentions(name)) {
            way.values.insert(name.clone(), image.clone());
            return Some(way);
        }
    }
    None
}

fn names(one: &Name, two: &Name, mut way: Substitution) -> Option<Substitution> {
    let follow = |name: &Name| {
        let mut name = name.clone();
        while let Some(image) = way.names.get(&name) {
            name = image.clone();
        }
        name
    };
    let (one, two) = (follow(one), follow(two));
    if one == two {
        return Some(way);
    }
    let (meta, image) = if one.is_meta() { (one, two) } else { (two, one) };
    meta.is_meta().then(|| {
        way.names.insert(meta, image);
        way
    })
}

/// The image of a term when the substitution has been applied until nothing changes.
pub(super) fn resolved(way: &Substitution, term: &Term, context: &Context<'_>) -> Option<Term> {
    let mut term = term.clone();
    for _ in 0..20 {
        let next = way.apply(&term, context).ok()?;
        if next == term {
            return Some(next);
        }
        term = next;
    }
    None
}

/// The name of a metavariable without arguments.
pub(super) fn plain_meta(term: &Term) -> Option<&Name> {
    match term.node() {
        Node::Meta(name, arguments) if arguments.is_empty() => Some(name),
        _ => None,
    }
}
