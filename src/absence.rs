//! Why something is not there: read off the state of a run and off what happened on the way to it, never guessed.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::model::{Action, Event, Meaningless, Move, Patience, State};
use crate::name::Name;
use crate::stepper::{Stepper, did};
use crate::term::{Node, Term};

/// The most uses of one port that are explained.
const MOST_USES: usize = 3;

/// What is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Query {
    /// The move of this number, from 1.
    Number(usize),
    /// A communication over this port: reading (`c?`), writing (`c!`), or either.
    Port(Name, Direction),
    /// This much time, or any.
    Time(Option<BigRational>),
    /// That it has stopped.
    Stop,
    /// That it has aborted.
    Abort,
    /// That this observer is seen.
    Observer(Name),
}

/// Which end of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// `c?`
    Read,
    /// `c!`
    Write,
    /// `c`
    Either,
}

impl Direction {
    fn covers(self, other: Direction) -> bool {
        self == Direction::Either || self == other
    }

    fn word(self) -> &'static str {
        match self {
            Direction::Read => "reads from",
            Direction::Write => "writes to",
            Direction::Either => "reads from or writes to",
        }
    }

    fn opposite(self) -> Direction {
        match self {
            Direction::Read => Direction::Write,
            Direction::Write => Direction::Read,
            Direction::Either => Direction::Either,
        }
    }
}

/// Where a port is used in a state.
enum Use<'t> {
    /// By a part that runs now; whether the port is private around it.
    Now { part: &'t Term, end: Direction, private: bool },
    /// By a part that comes after this one, which still runs.
    Later { part: &'t Term, behind: &'t Term },
    /// By the second arm of `else`, whose first still runs.
    Alternative { part: &'t Term, unless: &'t Term },
}

/// The reasons, a sentence a line.
///
/// # Errors
/// [`Meaningless`] where a draw of the state has no meaning.
pub fn why_not(run: &Stepper, query: &Query) -> Result<Vec<String>, Meaningless> {
    let moves = run.moves()?;
    let asking = Asking { run, moves };
    Ok(match query {
        Query::Number(number) => asking.number(*number)?,
        Query::Port(port, direction) => asking.port(port, *direction),
        Query::Time(time) => asking.time(time.as_ref())?,
        Query::Stop => asking.end(true),
        Query::Abort => asking.end(false),
        Query::Observer(name) => asking.observer(name),
    })
}

/// What a state offers but cannot do: communications of its running parts that nothing meets, each with what it would be.
pub fn blocked(run: &Stepper) -> Result<Vec<(Query, String)>, Meaningless> {
    let moves = run.moves()?;
    let State::Running(term) = run.state() else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    let mut seen = BTreeSet::new();
    for leaf in running(term) {
        let (port, direction, text) = match leaf.node() {
            Node::In(port, _) => (port, Direction::Read, format!("read from {port}")),
            Node::Out(port, value) => (port, Direction::Write, format!("write {value} to {port}")),
            _ => continue,
        };
        let there = moves.iter().any(|step| offers(step, port, direction));
        if !there && seen.insert(text.clone()) {
            all.push((Query::Port(port.clone(), direction), text));
        }
    }
    if run.state().patience(&moves) == Patience::None {
        all.push((Query::Time(None), "wait".to_string()));
    }
    Ok(all)
}

fn offers(step: &Move, port: &Name, direction: Direction) -> bool {
    match &step.action {
        Action::In(open) => open == port && direction.covers(Direction::Read),
        Action::Out(open, _) => open == port && direction.covers(Direction::Write),
        Action::Tau(open, _) => open == port,
        Action::Draw(..) => false,
    }
}

struct Asking<'a> {
    run: &'a Stepper,
    moves: Vec<Move>,
}

impl Asking<'_> {
    fn number(&self, number: usize) -> Result<Vec<String>, Meaningless> {
        let timed = usize::from(matches!(self.run.patience()?, Patience::Until(_)));
        if number >= 1 && number <= self.moves.len() + timed {
            return Ok(vec![format!("move {number} is there")]);
        }
        let blocked = blocked(self.run)?;
        let place = number.checked_sub(self.moves.len() + timed + 1);
        if let Some((query, what)) = place.and_then(|place| blocked.get(place)) {
            let mut lines = vec![format!("{number} is: {what}")];
            lines.extend(why_not(self.run, query)?);
            return Ok(lines);
        }
        let mut lines = self.ended();
        if lines.is_empty() {
            lines.push(format!("nothing here has number {number}: the last is {}", self.moves.len() + timed));
            for (query, what) in blocked {
                lines.push(format!("{what}:"));
                lines.extend(why_not(self.run, &query)?.into_iter().map(|line| format!("  {line}")));
            }
        }
        Ok(lines)
    }

    /// That termination comes first, if the process has ended.
    fn ended(&self) -> Vec<String> {
        let how = match self.run.state() {
            State::Running(_) => return Vec::new(),
            State::Stopped(_) => "stopped",
            State::Aborted => "aborted",
        };
        vec![format!("the process has {how}: ending comes before every move, and what has ended has none")]
    }

    fn port(&self, port: &Name, direction: Direction) -> Vec<String> {
        if let Some(place) = self.moves.iter().position(|step| offers(step, port, direction)) {
            let step = &self.moves[place];
            return vec![format!("it is there: move {} is to {}", place + 1, did(&step.action, None))];
        }
        let mut lines = self.ended();
        if let State::Running(term) = self.run.state() {
            if let Some(draw) = self.moves.iter().find(|step| matches!(step.action, Action::Draw(..))) {
                lines.push(format!("a draw is due, and comes before every other move: {}", did(&draw.action, None)));
            }
            let uses = uses(term, port, direction, self.run.definitions());
            for used in &uses {
                lines.push(self.used(term, port, used));
            }
        }
        let past = self.past(&|term| mentions(term, port, direction, self.run.definitions()));
        lines.extend(past);
        if lines.is_empty() {
            lines.push(format!("nothing in this process {} {port}", direction.word()));
        }
        lines.dedup();
        lines
    }

    fn used(&self, whole: &Term, port: &Name, used: &Use) -> String {
        match used {
            Use::Now { part, end, private: true } => {
                let other = end.opposite();
                let partners = uses(whole, port, other, self.run.definitions());
                let mut text =
                    format!("`{part}` is ready, but {port} is private: it needs a partner that {} it", other.word());
                if partners.is_empty() {
                    text.push_str(", and there is none");
                    let lost = self.past(&|term| mentions(term, port, other, self.run.definitions()));
                    text.push_str(&lost.map(|line| format!("; {line}")).unwrap_or_default());
                }
                for partner in partners.into_iter().take(1) {
                    text.push_str(&match partner {
                        Use::Now { part, .. } => format!("; `{part}` is ready too, but not beside it"),
                        Use::Later { part, behind } => {
                            format!("; `{part}` comes after `{behind}`, which {}", waits(behind))
                        }
                        Use::Alternative { part, unless } => format!("; `{part}` comes only if `{unless}` aborts"),
                    });
                }
                text
            }
            Use::Now { part, .. } => format!("`{part}` is ready, but cannot go now"),
            Use::Later { part, behind } => format!("`{part}` comes after `{behind}`, which {}", waits(behind)),
            Use::Alternative { part, unless } => {
                format!("`{part}` comes only if `{unless}` aborts, and that still runs")
            }
        }
    }

    fn time(&self, time: Option<&BigRational>) -> Result<Vec<String>, Meaningless> {
        let mut lines = self.ended();
        if !lines.is_empty() {
            return Ok(lines);
        }
        let patience = self.run.state().patience(&self.moves);
        if patience == Patience::None {
            lines.extend(self.moves.iter().enumerate().filter_map(|(place, step)| hurries(step, place)));
            return Ok(lines);
        }
        let Some(time) = time else { return Ok(vec!["time can pass here: `wait`".to_string()]) };
        if *time <= BigRational::zero() {
            return Ok(vec!["time passes forwards only".to_string()]);
        }
        if self.run.after_time(time)?.is_some() {
            return Ok(vec![format!("time {time} can pass here")]);
        }
        let mut later = self.run.clone();
        let mut left = time.clone();
        while let Patience::Until(next) = later.patience()? {
            if next >= left {
                break;
            }
            left -= &next;
            later.step(crate::stepper::Choice::Wait(next))?;
        }
        let passed = time - left;
        lines.push(format!("only {passed} of time can pass; then:"));
        lines.extend(why_not(&later, &Query::Time(None))?);
        Ok(lines)
    }

    fn end(&self, stop: bool) -> Vec<String> {
        let State::Running(term) = self.run.state() else {
            let there = matches!(self.run.state(), State::Stopped(_)) == stop;
            let word = if matches!(self.run.state(), State::Stopped(_)) { "stopped" } else { "aborted" };
            let mut lines = vec![format!("it has {word}{}", if there { "" } else { " instead" })];
            if !there {
                lines.extend(self.past(&|_| true));
            }
            return lines;
        };
        let mut lines = vec!["it still runs:".to_string()];
        lines.extend(running(term).into_iter().map(|leaf| format!("`{leaf}` {}", waits(leaf))));
        lines.dedup();
        lines
    }

    fn observer(&self, name: &Name) -> Vec<String> {
        if self.run.state().observations().iter().any(|(shown, _)| shown == name) {
            return vec![format!("{name} is seen now")];
        }
        let mut lines = self.ended();
        if let State::Running(term) = self.run.state() {
            let wanted = |leaf: &&Term| matches!(leaf.node(), Node::Observe(other, _) if other == name);
            for leaf in running(term).into_iter().filter(wanted) {
                lines.push(format!("`{leaf}` runs, but a `to` around it hides it"));
            }
            for (part, behind) in later(term) {
                if shows(part, name, self.run.definitions()) {
                    lines.push(format!("`{part}` comes after `{behind}`, which {}", waits(behind)));
                }
            }
        }
        lines.extend(self.past(&|term| shows(term, name, self.run.definitions())));
        if lines.is_empty() {
            lines.push(format!("nothing in this process shows {name}"));
        }
        lines
    }

    /// The last decision on the way here that took away a part of which this is true.
    fn past(&self, concerns: &dyn Fn(&Term) -> bool) -> Option<String> {
        let steps = self.run.trace();
        for number in (0..=steps.len()).rev() {
            let events = match number.checked_sub(1) {
                Some(place) => &steps[place].events,
                None => self.run.first_events(),
            };
            let when = match number {
                0 => "at the start".to_string(),
                _ => format!("at step {number} ({})", steps[number - 1].did),
            };
            for (place, event) in events.iter().enumerate().rev() {
                if let Some(text) = taken_away(event, &events[..place], concerns) {
                    return Some(format!("{when} {text}"));
                }
            }
        }
        None
    }
}

/// How an event took away a part, if it did.
fn taken_away(event: &Event, before: &[Event], concerns: &dyn Fn(&Term) -> bool) -> Option<String> {
    match event {
        Event::Killed { ended, killed } => {
            let lost = killed.iter().find(|part| concerns(part))?;
            let by = ended
                .iter()
                .map(|(part, stopped)| format!("`{part}` {}", if *stopped { "stopped" } else { "aborted" }));
            let by: Vec<String> = by.collect();
            Some(format!("`{lost}` was killed by `#`: {} beside it, and ending comes before every move", by.join(", ")))
        }
        Event::Skipped { aborted, rest } => {
            rest.iter().find(|part| concerns(part))?;
            let lost = Term::seq(rest.iter().cloned());
            let guard = before.iter().rev().find_map(|event| match event {
                Event::Guard(relation, left, right, false) => {
                    Some(format!("{left} {} {right} is false", relation.symbol()))
                }
                _ => None,
            });
            let why = guard.map(|why| format!(": {why}")).unwrap_or_default();
            Some(format!("`{aborted}` aborted{why}; so `{lost}` behind it never starts"))
        }
        Event::NotNeeded(second) => {
            concerns(second).then(|| format!("`{second}` was not needed: what stands before its `else` stopped"))
        }
        Event::Left(of) => concerns(of).then(|| {
            let guard = before.iter().rev().find_map(|event| match event {
                Event::Guard(relation, left, right, false) => {
                    Some(format!("{left} {} {right} is false", relation.symbol()))
                }
                _ => None,
            });
            let why = guard.map(|why| format!(" ({why})")).unwrap_or_default();
            format!("the loop `{of}` was left: its round aborted{why}")
        }),
        Event::Guard(..) => None,
    }
}

fn hurries(step: &Move, place: usize) -> Option<String> {
    let number = place + 1;
    let what = did(&step.action, None);
    match &step.action {
        Action::Tau(..) => {
            Some(format!("no time passes while an internal step is possible (maximal progress): move {number}, {what}"))
        }
        Action::Draw(..) => Some(format!("no time passes while a draw is due: move {number}, {what}")),
        _ => None,
    }
}

/// What a running part waits for, or how it has ended.
fn waits(term: &Term) -> String {
    let mut unique: Vec<String> = Vec::new();
    for leaf in running(term) {
        let text = match leaf.node() {
            Node::Delay(time) => format!("still waits for {time} of time"),
            Node::In(port, _) => format!("waits for a value from {port}"),
            Node::Out(port, _) => format!("waits for a reader of {port}"),
            Node::Idle | Node::Observe(..) => "never ends".to_string(),
            Node::Ran(..) => "is about to draw".to_string(),
            Node::Set(..) | Node::Stop => "has stopped".to_string(),
            Node::Abort => "has aborted".to_string(),
            _ => "still runs".to_string(),
        };
        if !unique.contains(&text) {
            unique.push(text);
        }
    }
    unique.join(", ")
}

/// The place of the running part of a settled sequence.
fn active(parts: &[Term]) -> usize {
    parts.iter().position(|part| !matches!(part.node(), Node::Set(..))).unwrap_or(0)
}

/// The leaves of a settled term that run now.
fn running(term: &Term) -> Vec<&Term> {
    let mut leaves = Vec::new();
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        match term.node() {
            Node::Seq(parts) => open.extend(parts.get(active(parts))),
            Node::Else(first, _) => open.push(first),
            Node::Par(parts) | Node::Disable(parts) => open.extend(parts.iter().rev()),
            Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => open.push(body),
            _ => leaves.push(term),
        }
    }
    leaves
}

/// The parts that have not been reached, each with the running part before it.
fn later(term: &Term) -> Vec<(&Term, &Term)> {
    let mut all = Vec::new();
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        match term.node() {
            Node::Seq(parts) => {
                let place = active(parts);
                if let Some(now) = parts.get(place) {
                    open.push(now);
                    all.extend(parts.iter().skip(place + 1).map(|part| (part, now)));
                }
            }
            Node::Else(first, _) => open.push(first),
            Node::Par(parts) | Node::Disable(parts) => open.extend(parts.iter().rev()),
            Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => open.push(body),
            _ => {}
        }
    }
    all
}

/// Every use of a port in a settled term, the nearest of each part.
fn uses<'t>(term: &'t Term, port: &Name, direction: Direction, definitions: &Definitions) -> Vec<Use<'t>> {
    let mut all = Vec::new();
    let mut open = vec![(term, false)];
    while let Some((term, private)) = open.pop() {
        match term.node() {
            Node::In(other, _) if other == port && direction.covers(Direction::Read) => {
                all.push(Use::Now { part: term, end: Direction::Read, private });
            }
            Node::Out(other, _) if other == port && direction.covers(Direction::Write) => {
                all.push(Use::Now { part: term, end: Direction::Write, private });
            }
            Node::Seq(parts) => {
                let place = active(parts);
                let Some(now) = parts.get(place) else { continue };
                let found = parts.iter().skip(place + 1).find(|part| mentions(part, port, direction, definitions));
                all.extend(found.map(|part| Use::Later { part, behind: now }));
                open.push((now, private));
            }
            Node::Else(first, second) => {
                if mentions(second, port, direction, definitions) {
                    all.push(Use::Alternative { part: second, unless: first });
                }
                open.push((first, private));
            }
            Node::Par(parts) | Node::Disable(parts) => open.extend(parts.iter().rev().map(|part| (part, private))),
            Node::New(own, body) => open.push((body, private || own == port)),
            Node::Project(body, _) | Node::Replace(body, ..) => open.push((body, private)),
            _ => {}
        }
    }
    // What is ready explains more than what comes later, and what comes sooner more than what comes later still.
    if all.iter().any(|used| matches!(used, Use::Now { .. })) {
        all.retain(|used| matches!(used, Use::Now { .. }));
    }
    all.reverse();
    all.truncate(MOST_USES);
    all
}

/// Whether a term, with the definitions it calls, has a leaf of which this is true.
fn has(term: &Term, definitions: &Definitions, wanted: &dyn Fn(&Node) -> bool) -> bool {
    let mut seen = BTreeSet::new();
    let mut open = vec![term];
    while let Some(term) = open.pop() {
        if wanted(term.node()) {
            return true;
        }
        if let Node::Call(name, _) = term.node()
            && let Some(definition) = definitions.get(name)
            && seen.insert(name.clone())
        {
            open.push(&definition.body);
        }
        open.extend(term.children());
    }
    false
}

fn mentions(term: &Term, port: &Name, direction: Direction, definitions: &Definitions) -> bool {
    has(term, definitions, &|node| match node {
        Node::In(other, _) => other == port && direction.covers(Direction::Read),
        Node::Out(other, _) => other == port && direction.covers(Direction::Write),
        _ => false,
    })
}

fn shows(term: &Term, name: &Name, definitions: &Definitions) -> bool {
    has(term, definitions, &|node| matches!(node, Node::Observe(other, _) if other == name))
}
