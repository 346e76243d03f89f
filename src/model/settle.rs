//! Termination: what a term has become once everything that ends at once has ended.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use super::draw::{is_drawn, mentions_drawn};
use super::{Event, Meaningless, Model, Results, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// How deep terms may stand inside one another, and how often definitions may be unfolded without anything happening.
const DEEPEST: usize = 200;
/// How many settled parts are remembered.
const MOST_SETTLED: usize = 10_000;
/// Letters of a value in a message.
const LONGEST: usize = 80;
/// How many copies of a power may end at once in a row.
const MOST_COPIES: u64 = 10_000;

/// The names bound so far where a term stands, the innermost first.
pub enum Scope<'s> {
    /// None.
    Empty,
    /// These, and those outside.
    Inner(&'s Results, &'s Scope<'s>),
}

impl Scope<'_> {
    fn is_empty(&self) -> bool {
        let mut scope = self;
        while let Scope::Inner(results, outer) = scope {
            if !results.is_empty() {
                return false;
            }
            scope = outer;
        }
        true
    }

    fn get(&self, name: &Name) -> Option<&Value> {
        let mut scope = self;
        while let Scope::Inner(results, outer) = scope {
            if let Some(value) = results.get(name) {
                return Some(value);
            }
            scope = outer;
        }
        None
    }

    /// The value of an expression here, with every name that is bound put in.
    pub(super) fn evaluate(&self, value: &Value) -> Result<Value, Meaningless> {
        let mut names = value.variables();
        // A value that was drawn and is not known is carried about, as long as nothing depends on it.
        names.retain(|name| !is_drawn(name));
        if names.is_empty() {
            return Ok(value.clone());
        }
        let mut known = BTreeMap::new();
        for name in names {
            match self.get(&name) {
                Some(bound) => known.insert(name, bound.clone()),
                None => return Meaningless::because(format!("`{name}` has no value here")),
            };
        }
        value.substitute(&known).or_else(|error| Meaningless::because(error.0))
    }

    fn number(&self, value: &Value) -> Result<BigRational, Meaningless> {
        let value = self.evaluate(value)?;
        match value.as_rational() {
            Some(number) => Ok(number),
            None => Meaningless::because(format!("`{value}` is not a number")),
        }
    }
}

/// A term that has stopped with these results.
pub(super) fn carried(results: &Results) -> Term {
    Term::seq(results.iter().map(|(name, value)| Term::new(Node::Set(value.clone(), name.clone()))))
}

/// The running term with these results in front; what it carries itself overrides them.
fn carrying(mut results: Results, running: Term, rest: &[Term]) -> Term {
    if results.is_empty() && rest.is_empty() {
        return running;
    }
    let mut tail = Vec::new();
    match running.node() {
        Node::Seq(parts) => {
            for part in parts {
                match part.node() {
                    Node::Set(value, name) if tail.is_empty() => {
                        results.insert(name.clone(), value.clone());
                    }
                    _ => tail.push(part.clone()),
                }
            }
        }
        _ => tail.push(running.clone()),
    }
    let sets = results.into_iter().map(|(name, value)| Term::new(Node::Set(value, name)));
    Term::seq(sets.chain(tail).chain(rest.iter().cloned()))
}

/// True only of terms that cannot abort; looks no deeper than `depth`.
fn cannot_abort(term: &Term, depth: usize) -> bool {
    if depth == 0 {
        return false;
    }
    let safe = |part: &Term| cannot_abort(part, depth - 1);
    match term.node() {
        Node::Stop | Node::Idle | Node::Delay(_) | Node::In(..) | Node::Out(..) | Node::Loop(_) => true,
        Node::Set(..) | Node::Ran(..) | Node::Observe(..) => true,
        Node::Seq(_) | Node::Disable(_) => term.children().all(safe),
        Node::Par(parts) => parts.iter().any(safe),
        Node::Else(_, second) => safe(second),
        Node::Power(body, ..) | Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => safe(body),
        _ => false,
    }
}

/// `running else other`, without the alternative where it cannot be taken.
fn otherwise(running: Term, other: &Term) -> Term {
    if cannot_abort(&running, 8) { running } else { Term::otherwise(running, other.clone()) }
}

/// Adds one part's results to those of others that stopped beside it.
fn unite(all: &mut Results, more: Results) -> Result<(), Meaningless> {
    for (name, value) in more {
        match all.get(&name) {
            Some(other) if *other != value => {
                return Meaningless::because(format!("`{name}` is bound to {other} and to {value} side by side"));
            }
            _ => all.insert(name, value),
        };
    }
    Ok(())
}

/// A value as it is read, cut off where it is long.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= LONGEST { text } else { text.chars().take(LONGEST).chain(['…']).collect() }
}

/// Whether a comparison of two closed values is true.
fn compare(relation: Relation, left: &Value, right: &Value) -> Result<bool, Meaningless> {
    if let (Some(left), Some(right)) = (left.as_rational(), right.as_rational()) {
        return Ok(match relation {
            Relation::Eq => left == right,
            Relation::Neq => left != right,
            Relation::Gtr => left > right,
            Relation::Gte => left >= right,
            Relation::Lss => left < right,
            Relation::Lte => left <= right,
        });
    }
    if let Some(order) = left.sub(right).ok().and_then(|difference| difference.order_of_roots()) {
        return Ok(relation.holds(order));
    }
    match relation {
        _ if left != right && (mentions_drawn(left) || mentions_drawn(right)) => {
            Meaningless::because(format!("whether `{left}` and `{right}` are equal depends on a draw"))
        }
        Relation::Eq => Ok(left == right),
        Relation::Neq => Ok(left != right),
        _ => Meaningless::because(format!("`{}` and `{}` cannot be put in order", short(left), short(right))),
    }
}

impl Model<'_> {
    /// What the term has become where it stands.
    pub(super) fn settle(&self, term: &Term, scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        if depth > DEEPEST {
            return Meaningless::because("it unfolds for ever without waiting or communicating (or nests too deeply)");
        }
        match term.node() {
            Node::Stop => Ok(State::Stopped(Results::new())),
            Node::Abort => Ok(State::Aborted),
            Node::Idle | Node::In(..) => Ok(State::Running(term.clone())),
            Node::Delay(time) => settle_delay(time, scope),
            Node::Out(..) | Node::Observe(..) | Node::Ran(..) => {
                Ok(State::Running(term.map_values(&mut |value| scope.evaluate(value))?))
            }
            Node::Guard(relation, left, right) => {
                let (left, right) = (scope.evaluate(left)?, scope.evaluate(right)?);
                let holds = match self.cells.order(&left, &right) {
                    Some(order) => relation.holds(order),
                    None => compare(*relation, &left, &right)?,
                };
                self.note(|| Event::Guard(*relation, left, right, holds));
                Ok(if holds { State::Stopped(Results::new()) } else { State::Aborted })
            }
            Node::Set(value, name) => Ok(State::Stopped(Results::from([(name.clone(), scope.evaluate(value)?)]))),
            Node::Seq(parts) => self.settle_sequence(parts, scope, depth),
            Node::Else(first, second) => match self.settle(first, scope, depth + 1)? {
                State::Aborted => self.settle(second, scope, depth + 1),
                State::Running(first) => Ok(State::Running(otherwise(first, second))),
                stopped => {
                    self.note(|| Event::NotNeeded(second.clone()));
                    Ok(stopped)
                }
            },
            Node::Par(parts) => self.settle_parallel(parts, scope, depth),
            Node::Disable(parts) => self.settle_disabling(parts, scope, depth),
            Node::Power(body, count, index) => self.settle_power(body, count, index.as_ref(), scope, depth),
            Node::Loop(body) => self.settle_loop(term, body, scope, depth),
            Node::Call(name, arguments) => self.settle_call(name, arguments, scope, depth),
            Node::New(_, body) | Node::Project(body, _) => Ok(match self.settle(body, scope, depth + 1)? {
                State::Running(body) => State::Running(term.with_children(vec![body])),
                ended => ended,
            }),
            Node::Replace(body, name, value) => self.settle_replace(body, name, value, scope, depth),
            Node::Meta(name, _) => Meaningless::because(format!("`{name}` stands for any process")),
        }
    }

    fn settle_sequence(&self, parts: &[Term], scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        let mut results = Results::new();
        for (place, part) in parts.iter().enumerate() {
            let state = self.settle(part, &Scope::Inner(&results, scope), depth + 1)?;
            match state {
                State::Stopped(more) => results.extend(more),
                State::Aborted => {
                    self.note(|| Event::Skipped { aborted: part.clone(), rest: parts[place + 1..].to_vec() });
                    return Ok(State::Aborted);
                }
                State::Running(part) => return Ok(State::Running(carrying(results, part, &parts[place + 1..]))),
            }
        }
        Ok(State::Stopped(results))
    }

    /// One of several parts side by side: most of them stay as they are while one moves.
    fn settle_part(&self, part: &Term, scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        // An account is kept of what is decided, so all of it is decided anew.
        if !scope.is_empty() || self.account.borrow().is_some() {
            return self.settle(part, scope, depth);
        }
        if let Some(state) = self.settled.borrow().get(part) {
            return Ok(state.clone());
        }
        let state = self.settle(part, scope, depth)?;
        let mut settled = self.settled.borrow_mut();
        if settled.len() >= MOST_SETTLED {
            settled.clear();
        }
        settled.insert(part.clone(), state.clone());
        Ok(state)
    }

    fn settle_parallel(&self, parts: &[Term], scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        let mut running = Vec::new();
        let mut stopped: Option<Results> = None;
        for part in parts {
            match self.settle_part(part, scope, depth + 1)? {
                State::Stopped(results) => unite(stopped.get_or_insert_default(), results)?,
                State::Aborted => {}
                State::Running(part) => running.push(part),
            }
        }
        if running.is_empty() {
            return Ok(stopped.map_or(State::Aborted, State::Stopped));
        }
        if let Some(results) = stopped {
            let surely = results.is_empty() && running.iter().any(|part| cannot_abort(part, 8));
            if !surely {
                running.push(carried(&results));
            }
        }
        Ok(State::Running(Term::par(running)))
    }

    fn settle_disabling(&self, parts: &[Term], scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        let mut running = Vec::new();
        let mut stopped: Option<Results> = None;
        let mut ended = Vec::new();
        for part in parts {
            match self.settle_part(part, scope, depth + 1)? {
                State::Stopped(results) => {
                    unite(stopped.get_or_insert_default(), results)?;
                    ended.push((part.clone(), true));
                }
                State::Aborted => ended.push((part.clone(), false)),
                State::Running(part) if *part.node() == Node::Idle => {}
                State::Running(part) => running.push(part),
            }
        }
        let any = !ended.is_empty();
        if any && !running.is_empty() {
            self.note(|| Event::Killed { ended, killed: running.clone() });
        }
        Ok(match stopped {
            Some(results) => State::Stopped(results),
            None if any => State::Aborted,
            None => State::Running(Term::disable(running)),
        })
    }

    fn settle_power(
        &self,
        body: &Term,
        count: &Value,
        index: Option<&Name>,
        scope: &Scope,
        depth: usize,
    ) -> Result<State, Meaningless> {
        let number = scope.number(count)?;
        let copies = match number.is_integer().then(|| number.to_integer().to_u64()).flatten() {
            Some(copies) => copies,
            None => return Meaningless::because(format!("`{number}` is not a number of copies")),
        };
        let copy = |place: i64, whole: &Value| match index {
            Some(index) => self.put_in(body, &BTreeMap::from([(index.clone(), whole.clone())]), place as usize),
            None => Ok(body.clone()),
        };
        let mut results = Results::new();
        for done in 0..copies {
            if done > MOST_COPIES {
                return Meaningless::because("a power takes too many rounds in no time");
            }
            let this = copy(0, &Value::integer(done as i64))?;
            let state = self.settle(&this, &Scope::Inner(&results, scope), depth + 1)?;
            match state {
                State::Stopped(more) => results.extend(more),
                State::Aborted => return Ok(State::Aborted),
                State::Running(part) => {
                    let left = Value::integer((copies - done - 1) as i64);
                    let rest = match index {
                        Some(index) => {
                            let shifted = Value::variable(index).add(&Value::integer(done as i64 + 1));
                            let shifted = shifted.or_else(|error| Meaningless::because(error.0))?;
                            Term::new(Node::Power(copy(0, &shifted)?, left, Some(index.clone())))
                        }
                        None => Term::new(Node::Power(body.clone(), left, None)),
                    };
                    let rest = if copies - done == 1 { Vec::new() } else { vec![rest] };
                    return Ok(State::Running(carrying(results, part, &rest)));
                }
            }
        }
        Ok(State::Stopped(results))
    }

    fn settle_loop(&self, term: &Term, body: &Term, scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        match self.settle(body, scope, depth + 1)? {
            State::Stopped(_) => Meaningless::because("a loop goes round in no time"),
            State::Aborted => {
                self.note(|| Event::Left(term.clone()));
                Ok(State::Stopped(Results::new()))
            }
            State::Running(round) => {
                let round = carrying(Results::new(), round, std::slice::from_ref(term));
                Ok(State::Running(otherwise(round, &Term::stop())))
            }
        }
    }

    fn settle_call(&self, name: &Name, arguments: &[Value], scope: &Scope, depth: usize) -> Result<State, Meaningless> {
        let Some(definition) = self.definitions.get(name) else {
            return Meaningless::because(format!("`{name}` is not defined"));
        };
        if definition.parameters.len() != arguments.len() {
            return Meaningless::because(format!("`{name}` takes {} parameters", definition.parameters.len()));
        }
        let mut known = BTreeMap::new();
        for (parameter, argument) in definition.parameters.iter().zip(arguments) {
            known.insert(parameter.clone(), scope.evaluate(argument)?);
        }
        let body = self.put_in(&definition.body, &known, 0)?;
        match self.settle(&body, scope, depth + 1)? {
            State::Aborted if definition.recursive => {
                let values = definition.parameters.iter().filter_map(|name| known.get(name).cloned()).collect();
                self.note(|| Event::Left(Term::new(Node::Call(name.clone(), values))));
                Ok(State::Stopped(Results::new()))
            }
            State::Running(body) if definition.recursive => Ok(State::Running(otherwise(body, &Term::stop()))),
            state => Ok(state),
        }
    }

    fn settle_replace(
        &self,
        body: &Term,
        name: &Name,
        value: &Value,
        scope: &Scope,
        depth: usize,
    ) -> Result<State, Meaningless> {
        let value = scope.evaluate(value)?;
        let known = Results::from([(name.clone(), value.clone())]);
        let put_in = self.put_in(body, &known, 0)?;
        match put_in.node() {
            Node::Replace(body, other, same) if other == name && *same == value => {
                Ok(match self.settle(body, &Scope::Inner(&known, scope), depth + 1)? {
                    State::Running(body) => State::Running(Term::new(Node::Replace(body, name.clone(), value))),
                    ended => ended,
                })
            }
            _ => self.settle(&put_in, scope, depth + 1),
        }
    }
}

fn settle_delay(time: &Value, scope: &Scope) -> Result<State, Meaningless> {
    let time = scope.number(time)?;
    if time < BigRational::zero() {
        return Meaningless::because(format!("a delay of {time} is negative"));
    }
    if time.is_zero() {
        return Ok(State::Stopped(Results::new()));
    }
    Ok(State::Running(Term::delay(Value::rational(time))))
}
