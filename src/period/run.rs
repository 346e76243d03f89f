//! The running system: terms with their values beside them, and all that ends at once ended.
//!
//! Values are kept in environments, never put into terms, so that the control point (the terms) and the values
//! are apart. A question about values that the assumptions leave open stops the settling; the caller asks again
//! with the answer assumed, once each way.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use super::call::cycle_of;
pub(crate) use super::env::{Called, Env, one, restrict};
use super::lonely::Ended;
use super::rest::{NOTHING, Rest, Tails};
use super::suppose::surely;
use super::{Failure, Test};
use crate::assumption::{Assumptions, with_fewest_corners};
use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::read_names;
use crate::term::{Node, Term};
use crate::value::{Relation, Value, View, keeps_divisors};

/// A process that runs, or has ended.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Run {
    /// Has stopped, and carries this.
    Done(Env),
    /// Has aborted.
    Aborted,
    /// Not looked at yet.
    Fresh(Term, Env),
    /// A read, a write, an observer, or `Idle`.
    Wait(Term, Env),
    /// A delay with what is left of it.
    Delay(Value),
    /// The part that runs, the parts to come, their values, and what is carried so far.
    Seq(Box<Run>, Rest, Env, Env),
    /// With the alternative.
    Else(Box<Run>, Term, Env, Kind),
    /// Side by side.
    Par(Vec<Run>),
    /// The first that ends ends all.
    Disable(Vec<Run>),
    /// With a port of its own.
    New(Name, Box<Run>),
    /// Shows these observers alone.
    Only(BTreeSet<Name>, Box<Run>),
}

/// What an alternative belongs to.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub(crate) enum Kind {
    /// `P else Q`
    Choice,
    /// A loop, whose alternative is `Stop`.
    Loop(Called),
}

/// A question that came up, with the names it was asked in.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) struct RawTest {
    /// What was asked, of values.
    pub test: Test,
    /// The same, of names.
    pub raw: Test,
    /// What the names stood for.
    pub env: Env,
    /// Whether it holds, as surely as anything that is drawn.
    pub surely: bool,
}

/// What has been assumed, and what has happened, on the way to a state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Path {
    /// What is assumed.
    pub assumptions: Rc<Assumptions>,
    /// The answers given, in order.
    pub tests: Vec<RawTest>,
    /// How many loops have ended.
    pub exits: usize,
    /// Random draws: the name that stands for the value, and the distribution.
    pub draws: Vec<(Name, Value)>,
    /// Calls unfolded while settling last.
    pub unfolded: Vec<Name>,
    /// The length of the numbers that calls were made with, in units of 16 bits.
    pub lengths: usize,
    /// The calls and loops that are being settled, one inside the other, with how many draws were made before each.
    pub open: Vec<(Term, Env, usize)>,
}

/// How far a path had come.
#[derive(Clone, Copy)]
pub(crate) struct Mark {
    exits: usize,
    draws: usize,
    unfolded: usize,
    lengths: usize,
}

impl Path {
    /// What is assumed, with the least values of the numbers that were drawn, where their distributions give them.
    fn with_draws(&self) -> Rc<Assumptions> {
        let mut with = Rc::clone(&self.assumptions);
        for (name, distribution) in &self.draws {
            if let Some(least) = least(distribution, &self.assumptions) {
                Rc::make_mut(&mut with).assume(Relation::Gte, &Value::variable(name), &least);
            }
        }
        with
    }

    /// How far it has come, to go back to after a trial.
    pub(crate) fn mark(&self) -> Mark {
        Mark { exits: self.exits, draws: self.draws.len(), unfolded: self.unfolded.len(), lengths: self.lengths }
    }

    /// Takes back what has happened since; a trial gives no answers.
    pub(crate) fn back_to(&mut self, mark: Mark) {
        (self.exits, self.lengths) = (mark.exits, mark.lengths);
        self.draws.truncate(mark.draws);
        self.unfolded.truncate(mark.unfolded);
        self.open.clear();
    }

    /// A value as people wrote it: what was drawn has the name that it was given.
    fn named(&self, value: &Value) -> Value {
        let plain = |name: &Name| Value::variable(&Name::new(name.as_str().split('~').next().unwrap_or_default()));
        let names = self.draws.iter().map(|(name, _)| (name.clone(), plain(name))).collect();
        value.substitute(&names).unwrap_or_else(|_| value.clone())
    }
}

/// What is drawn from a distribution is surely at least this; of a mixture of several, 0 alone is found.
pub(super) fn least(distribution: &Value, assumptions: &Assumptions) -> Option<Value> {
    let (mut parts, mut all) = (vec![distribution.clone()], Vec::new());
    while let Some(part) = parts.pop() {
        let View::Distribution(kind, arguments) = part.view() else { return None };
        match (kind.as_str(), arguments.as_slice()) {
            ("Exp", _) => all.push(Value::zero()),
            ("Point" | "Uniform", [low, ..]) => all.push(low.clone()),
            ("Mix", pairs) => parts.extend(pairs.iter().skip(1).step_by(2).cloned()),
            _ => return None,
        }
    }
    if let [one] = all.as_slice() {
        return Some(one.clone());
    }
    let positive = |low: &Value| assumptions.decide(Relation::Gte, low, &Value::zero()) == Some(true);
    (!all.is_empty() && all.iter().all(positive)).then(Value::zero)
}

/// Why settling stopped.
pub(crate) enum Halt {
    /// An open question.
    Split(Box<RawTest>),
    /// A failure.
    Failed(Box<Failure>),
}

impl Halt {
    pub(crate) fn because<T>(reason: impl Into<String>) -> Result<T, Halt> {
        Err(Halt::Failed(Box::new(Failure::not_found(reason))))
    }
}

impl From<Failure> for Halt {
    fn from(failure: Failure) -> Halt {
        Halt::Failed(Box::new(failure))
    }
}

/// Nested operators and unfoldings that one settling may go through.
const DEEPEST: usize = 300;
/// Durations held that are told apart: more of them are others each time.
const MOST_DURATIONS: usize = 64;

/// What settling needs to know.
pub(crate) struct Settler<'a> {
    pub(crate) definitions: &'a Definitions,
    /// The names that have one value throughout; all others vary from round to round.
    pub(crate) reserved: &'a BTreeSet<Name>,
    /// The sequences met so far.
    pub(crate) tails: RefCell<Tails>,
    /// The first durations met that are values which processes hold.
    pub(crate) durations: RefCell<BTreeSet<Value>>,
    /// What was ended while it waited.
    pub(crate) ended: Ended,
}

/// A process at its start.
pub(crate) fn fresh(term: &Term, env: &Env) -> Run {
    if env.is_empty() {
        return Run::Fresh(term.clone(), Env::new());
    }
    Run::Fresh(term.clone(), restrict(env, &read_names(term)))
}

pub(crate) fn evaluate(value: &Value, env: &Env) -> Result<Value, Halt> {
    if env.is_empty() {
        return Ok(value.clone());
    }
    match keeps_divisors(value, env).and_then(|()| value.substitute(env)) {
        Ok(value) => Ok(with_fewest_corners(&value)),
        Err(error) => Halt::because(format!("{value} has no value: {}", error.0)),
    }
}

impl Run {
    fn ended(&self) -> bool {
        matches!(self, Run::Done(_) | Run::Aborted)
    }
}

/// What is in a box, which may then hold what becomes of it.
fn taken(run: &mut Run) -> Run {
    std::mem::replace(run, Run::Aborted)
}

/// Parts side by side at their start, at least one of which runs. A branch that aborts at once adds nothing to one that
/// goes on: without it, a loop that is called from a branch behind guards stands where it would stand without them.
fn begun(mut parts: Vec<Run>) -> Run {
    parts.retain(|part| *part != Run::Aborted);
    match (parts.pop(), parts.is_empty()) {
        (Some(only), true) => only,
        (last, _) => {
            parts.extend(last);
            Run::Par(parts)
        }
    }
}

/// The end of parts that have ended together: stopped if one of them stopped.
fn joint_end(parts: &[Run]) -> Run {
    let mut carried = Env::new();
    let mut stopped = false;
    for part in parts {
        if let Run::Done(results) = part {
            stopped = true;
            carried.add(results);
        }
    }
    if stopped { Run::Done(carried) } else { Run::Aborted }
}

impl Settler<'_> {
    /// Ends all that ends at once. `wanted` are the names that are read later.
    pub(crate) fn settle(&self, run: Run, wanted: &BTreeSet<Name>, path: &mut Path, depth: usize) -> Result<Run, Halt> {
        if depth > DEEPEST {
            let Some(last) = path.unfolded.last() else {
                return Halt::because("the processes are nested too deeply");
            };
            let cycle: Vec<String> = cycle_of(&path.unfolded, last).iter().map(ToString::to_string).collect();
            let called = cycle.join(", ");
            return Halt::because(format!("the processes are nested too deeply, or {called} is called without end"));
        }
        match run {
            Run::Done(carried) => Ok(Run::Done(restrict(&carried, wanted))),
            Run::Aborted | Run::Wait(..) => Ok(run),
            Run::Delay(left) => self.left_of_delay(left, path),
            Run::Fresh(term, env) => self.start(&term, &env, wanted, path, depth),
            Run::Seq(first, rest, env, carried) => {
                self.settle_sequence(first, rest, (env, carried), wanted, path, depth)
            }
            Run::Else(mut first, second, env, kind) => {
                let looped = matches!(kind, Kind::Loop(_));
                match self.settle(taken(&mut first), wanted, path, depth + 1)? {
                    Run::Done(carried) => Ok(Run::Done(carried)),
                    Run::Aborted => {
                        path.exits += usize::from(looped);
                        self.settle(Run::Fresh(second, env), wanted, path, depth + 1)
                    }
                    // A loop never aborts, so a loop round it that has come to its last part adds nothing.
                    inner @ Run::Else(_, _, _, Kind::Loop(_)) if looped => Ok(inner),
                    inner => {
                        *first = inner;
                        Ok(Run::Else(first, second, env, kind))
                    }
                }
            }
            Run::Par(parts) => {
                let parts = self.settle_all(parts, wanted, path, depth)?;
                Ok(if parts.iter().all(Run::ended) { joint_end(&parts) } else { Run::Par(parts) })
            }
            Run::Disable(parts) => {
                let parts = self.settle_all(parts, wanted, path, depth)?;
                if parts.iter().any(Run::ended) {
                    self.ended.note(&parts);
                    return Ok(joint_end(&parts));
                }
                Ok(Run::Disable(parts))
            }
            Run::New(port, body) => match self.settle(*body, wanted, path, depth + 1)? {
                ended @ (Run::Done(_) | Run::Aborted) => Ok(ended),
                running => Ok(Run::New(port, Box::new(running))),
            },
            Run::Only(shown, body) => match self.settle(*body, wanted, path, depth + 1)? {
                ended @ (Run::Done(_) | Run::Aborted) => Ok(ended),
                running => Ok(Run::Only(shown, Box::new(running))),
            },
        }
    }

    fn settle_all(
        &self,
        parts: Vec<Run>,
        wanted: &BTreeSet<Name>,
        path: &mut Path,
        depth: usize,
    ) -> Result<Vec<Run>, Halt> {
        parts.into_iter().map(|part| self.settle(part, wanted, path, depth + 1)).collect()
    }

    fn settle_sequence(
        &self,
        mut first: Box<Run>,
        mut rest: Rest,
        (mut env, mut carried): (Env, Env),
        wanted: &BTreeSet<Name>,
        path: &mut Path,
        depth: usize,
    ) -> Result<Run, Halt> {
        let mut begun: Option<Term> = None;
        loop {
            let reads = self.tails.borrow().reads(rest);
            let both = if reads.is_subset(wanted) { None } else { Some(reads.union(wanted).cloned().collect()) };
            match self.settle(taken(&mut first), both.as_ref().unwrap_or(wanted), path, depth + 1)? {
                Run::Done(results) => {
                    carried.add(&results);
                    env.add(&results);
                    let Some((next, others)) = self.tails.borrow().split(rest) else {
                        return Ok(Run::Done(restrict(&carried, wanted)));
                    };
                    rest = others;
                    *first = fresh(&next, &env);
                    begun = Some(next);
                }
                Run::Aborted => return Ok(Run::Aborted),
                running => {
                    let carried = restrict(&carried, wanted);
                    if rest == NOTHING && carried.is_empty() {
                        return Ok(running);
                    }
                    // A last part that is a sequence carries on: so copies do not nest.
                    let running = match running {
                        Run::Seq(inner, others, env, later) if rest == NOTHING => {
                            let mut carried = carried;
                            carried.add(&later);
                            return Ok(Run::Seq(inner, others, env, carried));
                        }
                        other => other,
                    };
                    *first = running;
                    let mut kept = restrict(&env, &reads);
                    if let Some(begun) = begun.filter(|_| !kept.is_empty()) {
                        // What it is about to bind, nothing reads from before.
                        kept = self.tails.borrow().without_written(&begun, kept);
                    }
                    return Ok(Run::Seq(first, rest, kept, carried));
                }
            }
        }
    }

    fn start(
        &self,
        term: &Term,
        env: &Env,
        wanted: &BTreeSet<Name>,
        path: &mut Path,
        depth: usize,
    ) -> Result<Run, Halt> {
        let next = match term.node() {
            Node::Stop => return Ok(Run::Done(Env::new())),
            Node::Abort => return Ok(Run::Aborted),
            Node::Idle | Node::Observe(..) | Node::In(..) | Node::Out(..) => {
                return Ok(Run::Wait(term.clone(), env.clone()));
            }
            Node::Delay(time) => return self.start_delay(time, env, path),
            Node::Guard(relation, left, right) => {
                let raw = Test { relation: *relation, left: left.clone(), right: right.clone() };
                return Ok(if self.ask(raw, env, path)? { Run::Done(Env::new()) } else { Run::Aborted });
            }
            Node::Set(value, name) => {
                return Ok(Run::Done(one(name, evaluate(value, env)?, wanted)));
            }
            Node::Ran(distribution, name) => {
                let drawn = self.draw(name, evaluate(distribution, env)?, path);
                return Ok(Run::Done(one(name, drawn, wanted)));
            }
            Node::Seq(_) => {
                let rest = self.tails.borrow_mut().of(term);
                Run::Seq(Box::new(Run::Done(Env::new())), rest, env.clone(), Env::new())
            }
            Node::Else(first, second) => {
                Run::Else(Box::new(fresh(first, env)), second.clone(), restrict(env, &read_names(second)), Kind::Choice)
            }
            Node::Loop(body) => {
                let again = self.tails.borrow_mut().of(term);
                let round = Run::Seq(Box::new(fresh(body, env)), again, env.clone(), Env::new());
                let round = Run::Else(Box::new(round), Term::stop(), Env::new(), Kind::Loop(Called(None)));
                return self.once(term.clone(), restrict(env, &read_names(body)), round, wanted, path, depth);
            }
            Node::Par(parts) => {
                let parts = parts.iter().map(|part| fresh(part, env)).collect();
                let parts = self.settle_all(parts, wanted, path, depth + 1)?;
                return Ok(if parts.iter().all(Run::ended) { joint_end(&parts) } else { begun(parts) });
            }
            Node::Disable(parts) => Run::Disable(parts.iter().map(|part| fresh(part, env)).collect()),
            Node::Call(name, arguments) => {
                let arguments: Vec<Value> =
                    arguments.iter().map(|value| evaluate(value, env)).collect::<Result<_, Halt>>()?;
                let call = Term::new(Node::Call(name.clone(), arguments.clone()));
                let body = self.unfold(name, arguments, path)?;
                return self.once(call, Env::new(), body, wanted, path, depth);
            }
            Node::Power(body, count, index) => self.copies(body, count, index.as_ref(), env, path)?,
            Node::Meta(name, _) => return Halt::because(format!("{name} is no process but stands for any")),
            Node::New(port, body) => Run::New(port.clone(), Box::new(fresh(body, env))),
            Node::Project(body, shown) => Run::Only(shown.clone(), Box::new(fresh(body, env))),
            Node::Replace(..) => return Halt::because("`P[y := x]` stands in laws only, not in a component"),
        };
        self.settle(next, wanted, path, depth + 1)
    }

    /// Whether durations that processes hold are many different ones.
    pub(super) fn durations_differ(&self) -> bool {
        self.durations.borrow().len() > MOST_DURATIONS
    }

    fn start_delay(&self, time: &Value, env: &Env, path: &Path) -> Result<Run, Halt> {
        let left = evaluate(time, env)?;
        if left != *time && !self.durations_differ() {
            self.durations.borrow_mut().insert(left.clone());
        }
        let zero = Value::zero();
        let assumptions = path.with_draws();
        let is = |relation| assumptions.decide(relation, &left, &zero);
        if path.assumptions.decide(Relation::Eq, &left, &zero) == Some(true) || is(Relation::Eq) == Some(true) {
            return Ok(Run::Done(Env::new()));
        }
        match is(Relation::Gtr) {
            Some(true) => Ok(Run::Delay(left)),
            Some(false) => {
                let negative = if is(Relation::Lss) == Some(true) { "is negative" } else { "may be negative" };
                Halt::because(format!("the duration {} {negative}", path.named(&left)))
            }
            None if self.varies(&left) || is(Relation::Gte) == Some(true) => {
                let raw = Test { relation: Relation::Gtr, left: time.clone(), right: zero };
                Ok(if self.ask(raw, env, path)? { Run::Delay(left) } else { Run::Done(Env::new()) })
            }
            None => Halt::because(format!("it must be known whether {left} > 0")),
        }
    }

    /// What is left of a delay is not negative; where it is not known whether there is something left, it is asked.
    fn left_of_delay(&self, left: Value, path: &Path) -> Result<Run, Halt> {
        let zero = Value::zero();
        let positive = match path.assumptions.decide(Relation::Gtr, &left, &zero) {
            Some(positive) => positive,
            None if path.assumptions.decide(Relation::Eq, &left, &zero) == Some(true) => false,
            None => self.ask(Test { relation: Relation::Gtr, left: left.clone(), right: zero }, &Env::new(), path)?,
        };
        Ok(if positive { Run::Delay(left) } else { Run::Done(Env::new()) })
    }

    /// The answer to a question, if the assumptions give it.
    pub(crate) fn ask(&self, raw: Test, env: &Env, path: &Path) -> Result<bool, Halt> {
        let test = Test { relation: raw.relation, left: evaluate(&raw.left, env)?, right: evaluate(&raw.right, env)? };
        match test.decide(&path.assumptions) {
            Some(answer) => Ok(answer),
            None => {
                let reads = raw.left.variables().union(&raw.right.variables()).cloned().collect();
                let (env, surely) = (restrict(env, &reads), surely(path, &test));
                Err(Halt::Split(Box::new(RawTest { test, raw, env, surely })))
            }
        }
    }

    /// Whether a value differs from round to round.
    pub(crate) fn varies(&self, value: &Value) -> bool {
        value.variables().iter().any(|name| self.varies_by(name))
    }

    /// Whether it is another from round to round what is called so.
    pub(crate) fn varies_by(&self, name: &Name) -> bool {
        !self.reserved.contains(name)
    }

    fn draw(&self, name: &Name, distribution: Value, path: &mut Path) -> Value {
        let number = path.draws.len() + 1;
        let drawn = Name::new(&format!("{name}~{number}"));
        path.draws.push((drawn.clone(), distribution));
        Value::variable(&drawn)
    }
}
