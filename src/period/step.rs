//! What a settled system can do: offers on ports, what it shows, and how time passes.

use super::rest::Tails;
use super::run::{Env, Halt, Kind, Run, evaluate};
use crate::name::Name;
use crate::scope::read_names;
use crate::substitution::{bound_at_last, substitute_values};
use crate::term::{Node, Term};
use crate::value::{Value, ValueError};

/// A place in the system.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) struct Place {
    /// The component.
    pub component: usize,
    /// The branches of `|` and `#` in it, from outside.
    pub branches: Vec<usize>,
}

/// A read or a write that waits.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct Offer {
    /// Where.
    pub place: Place,
    /// On which port.
    pub port: Name,
    /// The value written; for a read, none.
    pub value: Option<Value>,
    /// The name that a read binds.
    pub binds: Option<Name>,
}

/// All reads and writes that wait in a part of a system, which stands at this place.
pub(crate) fn offers(run: &Run, place: &mut Place, found: &mut Vec<Offer>) -> Result<(), Halt> {
    match run {
        Run::Wait(term, env) => {
            let (port, value, binds) = match term.node() {
                Node::In(port, name) => (port, None, Some(name.clone())),
                Node::Out(port, value) => (port, Some(evaluate(value, env)?), None),
                _ => return Ok(()),
            };
            found.push(Offer { place: place.clone(), port: port.clone(), value, binds });
        }
        Run::Seq(first, ..) | Run::Else(first, ..) => offers(first, place, found)?,
        Run::Par(parts) | Run::Disable(parts) => {
            for (index, part) in parts.iter().enumerate() {
                place.branches.push(index);
                offers(part, place, found)?;
                place.branches.pop();
            }
        }
        Run::Only(_, body) => offers(body, place, found)?,
        Run::New(port, body) => {
            let before = found.len();
            offers(body, place, found)?;
            let places: Vec<String> =
                std::iter::once(&place.component).chain(&place.branches).map(usize::to_string).collect();
            for offer in found.iter_mut().skip(before).filter(|offer| offer.port == *port) {
                offer.port = Name::new(&format!("{port}{PRIVATE}{}", places.join(".")));
            }
        }
        _ => {}
    }
    Ok(())
}

/// Stands between the name of a private port and the place of its `new`.
const PRIVATE: char = '@';

/// The name of a port as it is written.
pub(crate) fn written(port: &Name) -> Name {
    match port.as_str().split_once(PRIVATE) {
        Some((plain, _)) => Name::new(plain),
        None => port.clone(),
    }
}

/// The part at a place replaced: a read or write that has taken place.
pub(crate) fn finish(run: Run, place: &[usize], results: &Env) -> Run {
    match run {
        Run::Seq(first, rest, env, carried) => Run::Seq(finish_boxed(first, place, results), rest, env, carried),
        Run::Else(first, second, env, kind) => Run::Else(finish_boxed(first, place, results), second, env, kind),
        Run::New(port, body) => Run::New(port, finish_boxed(body, place, results)),
        Run::Only(shown, body) => Run::Only(shown, finish_boxed(body, place, results)),
        Run::Par(parts) => Run::Par(finish_one(parts, place, results)),
        Run::Disable(parts) => Run::Disable(finish_one(parts, place, results)),
        _ => Run::Done(results.clone()),
    }
}

/// The same in the memory that the part has.
fn finish_boxed(mut run: Box<Run>, place: &[usize], results: &Env) -> Box<Run> {
    *run = finish(std::mem::replace(&mut *run, Run::Aborted), place, results);
    run
}

fn finish_one(parts: Vec<Run>, place: &[usize], results: &Env) -> Vec<Run> {
    let Some((chosen, below)) = place.split_first() else {
        return parts;
    };
    parts
        .into_iter()
        .enumerate()
        .map(|(index, part)| if index == *chosen { finish(part, below, results) } else { part })
        .collect()
}

/// What is left of each delay that runs, and what each observer shows.
pub(crate) fn inspect(run: &Run, delays: &mut Vec<Value>, shown: &mut Vec<Term>) -> Result<(), Halt> {
    match run {
        Run::Delay(left) => delays.push(left.clone()),
        Run::Wait(term, env) => {
            if matches!(term.node(), Node::Observe(..)) {
                shown.push(term.map_values(&mut |value| evaluate(value, env))?);
            }
        }
        Run::Seq(first, ..) | Run::Else(first, ..) => inspect(first, delays, shown)?,
        Run::Par(parts) | Run::Disable(parts) => {
            for part in parts {
                inspect(part, delays, shown)?;
            }
        }
        Run::New(_, body) => inspect(body, delays, shown)?,
        Run::Only(named, body) => {
            let mut all = Vec::new();
            inspect(body, delays, &mut all)?;
            shown.extend(
                all.into_iter().filter(|term| matches!(term.node(), Node::Observe(name, _) if named.contains(name))),
            );
        }
        _ => {}
    }
    Ok(())
}

/// Takes this time from each delay that runs.
pub(crate) fn pass(run: &mut Run, time: &Value) -> Result<(), ValueError> {
    match run {
        Run::Delay(left) => *left = left.sub(time)?,
        Run::Seq(first, ..) | Run::Else(first, ..) | Run::New(_, first) | Run::Only(_, first) => pass(first, time)?,
        Run::Par(parts) | Run::Disable(parts) => parts.iter_mut().try_for_each(|part| pass(part, time))?,
        Run::Done(_) | Run::Aborted | Run::Fresh(..) | Run::Wait(..) => {}
    }
    Ok(())
}

/// Every value of a running system replaced by its image: delays, environments, what is carried.
pub(crate) fn map_values<E>(run: &Run, image: &mut impl FnMut(Slot<'_>, &Value) -> Result<Value, E>) -> Result<Run, E> {
    let over = |env: &Env, image: &mut dyn FnMut(Slot<'_>, &Value) -> Result<Value, E>| -> Result<Env, E> {
        env.iter().map(|(name, value)| Ok((name.clone(), image(Slot::Name(name), value)?))).collect()
    };
    Ok(match run {
        Run::Done(carried) => Run::Done(over(carried, image)?),
        Run::Aborted => Run::Aborted,
        Run::Fresh(term, env) => Run::Fresh(term.clone(), over(env, image)?),
        Run::Wait(term, env) => Run::Wait(term.clone(), over(env, image)?),
        Run::Delay(left) => Run::Delay(image(Slot::Delay, left)?),
        Run::Seq(first, rest, env, carried) => {
            let first = map_boxed(first, image)?;
            let env = over(env, image)?;
            Run::Seq(first, *rest, env, over(carried, image)?)
        }
        Run::Else(first, second, env, kind) => {
            let first = map_boxed(first, image)?;
            Run::Else(first, second.clone(), over(env, image)?, kind.clone())
        }
        Run::New(port, body) => Run::New(port.clone(), map_boxed(body, image)?),
        Run::Only(shown, body) => Run::Only(shown.clone(), map_boxed(body, image)?),
        Run::Par(parts) => Run::Par(map_parts(parts, image)?),
        Run::Disable(parts) => Run::Disable(map_parts(parts, image)?),
    })
}

fn map_boxed<E>(run: &Run, image: &mut impl FnMut(Slot<'_>, &Value) -> Result<Value, E>) -> Result<Box<Run>, E> {
    Ok(Box::new(map_values(run, image)?))
}

/// The same for several parts.
pub(crate) fn map_parts<E>(
    parts: &[Run],
    image: &mut impl FnMut(Slot<'_>, &Value) -> Result<Value, E>,
) -> Result<Vec<Run>, E> {
    let mut mapped = Vec::with_capacity(parts.len());
    for part in parts {
        mapped.push(map_values(part, image)?);
    }
    Ok(mapped)
}

/// Where a value of a running system stands.
#[derive(Clone, Copy)]
pub(crate) enum Slot<'a> {
    /// What is left of a delay.
    Delay,
    /// The value of a name.
    Name(&'a Name),
}

/// What a running part is about to do, as a process; for people, who need not see the loops round it.
pub(crate) fn readable(run: &Run, tails: &Tails) -> Term {
    let filled = |term: &Term, env: &Env| match env.is_empty() {
        true => term.clone(),
        false => substitute_values(term, env).unwrap_or_else(|_| term.clone()),
    };
    let all = |parts: &[Run]| parts.iter().map(|part| readable(part, tails)).collect::<Vec<_>>();
    match run {
        Run::Done(_) => Term::stop(),
        Run::Aborted => Term::abort(),
        Run::Delay(left) => Term::delay(left.clone()),
        Run::Wait(term, env) | Run::Fresh(term, env) => filled(term, env),
        Run::Seq(first, rest, env, _) => {
            let (first, env) = bound_in(readable(first, tails), env, tails);
            let rest = tails.parts(*rest);
            Term::seq(std::iter::once(first).chain(rest.iter().map(|term| filled(term, &env))))
        }
        Run::New(port, body) => Term::new(Node::New(port.clone(), readable(body, tails))),
        Run::Only(shown, body) => Term::new(Node::Project(readable(body, tails), shown.clone())),
        Run::Else(first, _, _, Kind::Loop(_)) => readable(first, tails),
        Run::Else(first, second, env, Kind::Choice) => Term::otherwise(readable(first, tails), filled(second, env)),
        Run::Par(parts) => Term::par(all(parts)),
        Run::Disable(parts) => Term::disable(all(parts)),
    }
}

/// A running part as a process, with the loops round it and what it carries.
pub(crate) fn standing(run: &Run, tails: &Tails) -> Term {
    let all = |parts: &[Run]| parts.iter().map(|part| standing(part, tails)).collect::<Vec<_>>();
    let sets = |env: &Env| {
        env.iter().map(|(name, value)| Term::new(Node::Set(value.clone(), name.clone()))).collect::<Vec<_>>()
    };
    match run {
        Run::Done(carried) => Term::seq(sets(carried)),
        Run::Wait(term, env) | Run::Fresh(term, env) => known(term, env, tails),
        Run::Seq(first, rest, env, carried) => {
            let (first, env) = bound_in(standing(first, tails), env, tails);
            let rest = known(&Term::seq(tails.parts(*rest).iter().cloned()), &env, tails);
            let rest = if matches!(rest.node(), Node::Stop) { Vec::new() } else { vec![rest] };
            Term::seq(sets(carried).into_iter().chain([first]).chain(rest))
        }
        Run::Else(first, second, env, _) => Term::otherwise(standing(first, tails), known(second, env, tails)),
        Run::New(port, body) => Term::new(Node::New(port.clone(), standing(body, tails))),
        Run::Only(shown, body) => Term::new(Node::Project(standing(body, tails), shown.clone())),
        Run::Par(parts) => Term::par(all(parts)),
        Run::Disable(parts) => Term::disable(all(parts)),
        Run::Aborted | Run::Delay(_) => readable(run, tails),
    }
}

/// What runs first, and the values of what follows it: of a name that it binds in some runs only, it binds that value in the
/// others, and what follows reads what was bound.
fn bound_in(mut first: Term, env: &Env, tails: &Tails) -> (Term, Env) {
    let bound = tails.may_bind(&first);
    let mut behind = Env::new();
    for (name, value) in env.iter() {
        match bound_at_last(&first, name, value).filter(|_| bound.contains(name)) {
            Some(with) => first = with,
            None => behind.insert(name.clone(), value.clone()),
        }
    }
    (first, behind)
}

/// A process with the values of the names that it reads before it binds them.
fn known(term: &Term, env: &Env, tails: &Tails) -> Term {
    if env.is_empty() {
        return term.clone();
    }
    let (bound, read) = (tails.may_bind(term), read_names(term));
    let of = |keep: &dyn Fn(&Name) -> bool| -> Env {
        let kept = env.iter().filter(|(name, _)| read.contains(*name) && keep(name));
        kept.map(|(name, value)| (name.clone(), value.clone())).collect()
    };
    let anew = of(&|name| bound.contains(name));
    match term.node() {
        Node::Seq(parts) if !anew.is_empty() => {
            let mut now = of(&|_| true);
            let each = parts.iter().map(|part| {
                let part_now = known(part, &now, tails);
                let bound = tails.may_bind(part);
                now = now
                    .iter()
                    .filter(|(name, _)| !bound.contains(*name))
                    .map(|(name, value)| (name.clone(), value.clone()))
                    .collect();
                part_now
            });
            Term::seq(each.collect::<Vec<_>>())
        }
        Node::Par(_) | Node::Disable(_) | Node::Else(..) | Node::New(..) | Node::Project(..) if !anew.is_empty() => {
            term.with_children(term.children().map(|part| known(part, env, tails)).collect())
        }
        // A part without parts reads what it is of before it binds what comes of it.
        _ if term.children().is_empty() => substitute_values(term, &of(&|_| true)).unwrap_or_else(|_| term.clone()),
        _ => substitute_values(term, &of(&|name| !bound.contains(name))).unwrap_or_else(|_| term.clone()),
    }
}

/// The loops that a part goes round in, outermost first.
pub(crate) fn loops(run: &Run) -> Vec<Name> {
    let mut names = Vec::new();
    let mut run = run;
    loop {
        run = match run {
            Run::Else(first, _, _, kind) => {
                if let Kind::Loop(called) = kind {
                    names.extend(called.0.clone());
                }
                first
            }
            Run::Seq(first, ..) => first,
            Run::New(_, body) | Run::Only(_, body) => body,
            _ => return names,
        };
    }
}
