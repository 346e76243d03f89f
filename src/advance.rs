//! What a closed network does next, derived from its text and the assumptions alone.
//!
//! A network `new k1. … new km. (A1 | … | An)` is first *settled*: everything that ends at once is ended, as far as it
//! is running calls and loops are unfolded, and what has been bound is put where it is read. Then it communicates until
//! time has to pass. All orders of the communications of this instant are followed, and only if every one of them leads
//! to the same state is there an [`Instant`]; of orders that surely lead to the same state one is followed. From there time passes, or nothing happens any more.
//!
//! Why a network is weakly equal to the state that its instant leads to: the network is closed and may always
//! communicate on the way, so by maximal progress it neither lets time pass nor does anything that others see; every
//! state on the way is running, so no outcome differs, however an enclosing `#` may end it; and from each of them the
//! one last state is reached. The pairs of these states with the last one are thus a weak bisimulation that compares
//! outcomes exactly, which is a congruence. No two orders lead to different states, so no communication was chosen
//! where another could have come first: neither two readers of one writer nor a part killed in the same instant pass.
//!
//! Why results may be left out that nobody reads: if the network never stops, what it carries at its end is never
//! compared, and inside it whatever follows was given the values that it reads. Of a network that may stop, all results
//! are kept. It may end as a time has passed, for both sides then end there with the same outcome. Where it ends behind a
//! communication, nothing is concluded: an enclosing `#` tells a state that has ended from one that is about to end.
//!
//! Whatever is not decided here for all values that meet the assumptions is an error, never a guess.

mod alone;
mod apart;
pub mod draw;
mod handed;
mod instantly;
mod leaf;
mod settle;

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::rc::Rc;

use alone::{Meeting, alone};
use handed::handed_on;
use leaf::{Leaf, active, is_drawing, is_set, leaves, rebuilt};
use settle::Runner;

use crate::fact::{BoundAndRead, Context, Facts, NameSet, Reached};
use crate::name::Name;
use crate::scope::{Spoken, condition_metavariables, metavariables};
use crate::substitution::Stuck;
use crate::term::room::levels;
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value};

/// The deepest term that is looked at.
const MOST_DEPTH: usize = 400;
/// Orders of communications that are followed in one instant beside the first.
const MOST_ORDERS: usize = 10_000;
/// States that several moments of one instant may go through, where something is drawn.
const MOST_STATES: usize = 10_000;

/// Different orders lead to different states.
pub const ORDER: &str = "the order in which parts communicate in one instant matters";

fn stuck<T>(why: impl Into<String>) -> Result<T, Stuck> {
    Err(Stuck(why.into()))
}

fn open_port(port: &Name) -> String {
    format!("the port {port} is open: no two components share it, and no `new {port}.` stands around all of them")
}

/// A network at the end of an instant: no communication is possible any more.
#[derive(Clone, Debug)]
pub struct Instant {
    ports: Rc<[Name]>,
    state: Term,
    names: Rc<BTreeSet<Name>>,
    /// What is bound and may be carried on to the end.
    kept: BTreeSet<Name>,
}

impl Instant {
    /// The end of the instant in which this network is.
    ///
    /// # Errors
    /// Where the network is not closed, where a guard, a duration or the order of two communications is not decided or
    /// matters, where it ends or may ever stop, and where a name would change its meaning.
    pub fn of(network: &Term, context: &Context<'_>) -> Result<Instant, Stuck> {
        let (instant, drawing) = Instant::or_draws(network, context)?;
        if drawing.is_some() { stuck("a random draw") } else { Ok(instant) }
    }

    /// The end of the instant, or the moment in it at which draws are due, and then what is drawn; the network as it
    /// begins where it draws at several moments.
    fn or_draws(network: &Term, context: &Context<'_>) -> Result<(Instant, Option<draw::Due>), Stuck> {
        if let Some(instant) = Instant::reached(network, context) {
            return Ok((instant, None));
        }
        let names = names_apart(network, context)?;
        // What it carries when it stops is compared, so all that is bound is kept.
        let kept = if Facts::of(network, context).may_stop { names.clone() } else { BTreeSet::new() };
        let mut ports = Vec::new();
        let mut body = network;
        while let Node::New(port, inner) = body.node() {
            ports.push(port.clone());
            body = inner;
        }
        let runner = Runner::new(context, &kept);
        let start = runner.running(body)?;
        let (state, due) = last_or_draws(&runner, start, (&ports, &names, &kept))?;
        Ok((Instant { ports: ports.into(), state, names: Rc::new(names), kept }, due))
    }

    /// The end of the instant of a network that has just been reached by [`Instant::after`], and is there already. What
    /// it binds and reads was in what it came from, and in the time that passed: so its names are apart as they were.
    fn reached(network: &Term, context: &Context<'_>) -> Option<Instant> {
        let reached = context.reached.borrow();
        let Reached { state, ports, names, .. } = reached.as_ref().filter(|reached| reached.network == *network)?;
        Some(Instant { ports: Rc::clone(ports), state: state.clone(), names: Rc::clone(names), kept: BTreeSet::new() })
    }

    /// The network as it is now.
    pub fn network(&self) -> Term {
        closed(&self.ports, self.state.clone())
    }

    /// What is shown from now on until something ends.
    pub fn shown(&self) -> Vec<Term> {
        let seen = |leaf: &Leaf<'_>| leaf.shown && matches!(leaf.term.node(), Node::Observe(..));
        let mut shown: Vec<Term> = leaves(&self.state).into_iter().filter(seen).map(|leaf| leaf.term.clone()).collect();
        shown.sort();
        shown.dedup();
        shown
    }

    /// What is left of each delay that runs.
    pub fn delays(&self) -> Vec<Value> {
        let left = |leaf: Leaf<'_>| if let Node::Delay(left) = leaf.term.node() { Some(left.clone()) } else { None };
        leaves(&self.state).into_iter().filter_map(left).collect()
    }

    /// The network after this time, in which no delay runs out before, and after the instant in which it then is, or at
    /// the start of that instant if something is drawn in it; if it ends as the time has passed, its end: `Stop` behind
    /// what it carries, or `Abort`.
    ///
    /// # Errors
    /// Where it is not certain that the time is more than 0 and no longer than any delay that runs, or where what
    /// follows is not decided.
    pub fn after(&self, time: &Value, context: &Context<'_>) -> Result<Term, Stuck> {
        let known = &context.assumptions;
        if time.sort() != Sort::Real || known.decide(Relation::Gtr, time, &Value::zero()) != Some(true) {
            return stuck(format!("it is not certain that {time} > 0"));
        }
        if time.variables().iter().any(|name| self.names.contains(name)) {
            return stuck(format!("{time} reads a name that the network binds"));
        }
        known_metavariables(&time.variables(), context)?;
        let mut late = None;
        let passed = rebuilt(&self.state, &mut 0, &mut |_, leaf| {
            let Node::Delay(left) = leaf.node() else { return None };
            if known.decide(Relation::Eq, left, time) == Some(true) {
                return Some(Term::stop());
            }
            match left.sub(time) {
                Ok(rest) if known.decide(Relation::Gtr, left, time) == Some(true) => {
                    Some(Term::delay(known.simplify(&rest)))
                }
                _ => {
                    late = Some(left.clone());
                    None
                }
            }
        });
        if let Some(left) = late {
            return stuck(format!("it is not certain that {time} <= {left}"));
        }
        let runner = Runner::new(context, &self.kept);
        match runner.ended_or_running(&passed)? {
            (true, end) => Ok(end),
            (false, now) => {
                // Where something is drawn before the instant is over, that is another step.
                let (last, due) = last_or_draws(&runner, now.clone(), (&self.ports, &self.names, &self.kept))?;
                if due.is_some() {
                    return Ok(closed(&self.ports, now));
                }
                let network = closed(&self.ports, last.clone());
                if self.kept.is_empty() {
                    let (ports, names) = (Rc::clone(&self.ports), Rc::clone(&self.names));
                    let reached = Reached { network: network.clone(), state: last, ports, names };
                    context.reached.replace(Some(reached));
                }
                Ok(network)
            }
        }
    }

    /// What the network is weakly equal to: for this time what it shows, and then [`Instant::after`]; for no time what it
    /// is now; if no time is given, for ever what it shows.
    ///
    /// # Errors
    /// As for [`Instant::after`] and [`Instant::rest`].
    pub fn onward(&self, time: Option<&Value>, context: &Context<'_>) -> Result<Term, Stuck> {
        match time {
            None => self.rest(),
            Some(time) if time.is_zero() => Ok(self.network()),
            Some(time) => Ok(Term::seq([stretch(time, &self.shown()), self.after(time, context)?])),
        }
    }

    /// What it is from now on, if nothing happens any more: what it shows.
    ///
    /// # Errors
    /// Where a delay still runs.
    pub fn rest(&self) -> Result<Term, Stuck> {
        match self.delays().first() {
            Some(left) => stuck(format!("a delay of {left} still runs")),
            None => Ok(Term::disable(self.shown())),
        }
    }
}

/// This long, with this shown.
pub fn stretch(time: &Value, shown: &[Term]) -> Term {
    Term::disable(std::iter::once(Term::delay(time.clone())).chain(shown.iter().cloned()))
}

fn closed(ports: &[Name], body: Term) -> Term {
    ports.iter().rev().fold(body, |body, port| Term::new(Node::New(port.clone(), body)))
}

/// The names that the network binds, itself or in a process that it calls. None of them is read where it is not bound,
/// and no metavariable stands for a name or a process: so a value that is known is the same wherever it is put.
fn names_apart(network: &Term, context: &Context<'_>) -> Result<BTreeSet<Name>, Stuck> {
    let (mut ports, mut body) = (0, network);
    while let Node::New(_, inner) = body.node() {
        (ports, body) = (ports + 1, inner);
    }
    let most = levels();
    if ports > most {
        return stuck(format!("it has {ports} ports of its own, and no more than {most} are taken"));
    }
    if body.depth() > MOST_DEPTH {
        return stuck("it is nested too deeply");
    }
    let spoken = Spoken::of(network, &mut context.spoken.borrow_mut());
    let called = names_of_called(&spoken.calls, context)?;
    let (bound_there, read_there) = &*called;
    let mut bound = spoken.bound.clone();
    bound.extend(bound_there.iter().cloned());
    let free = context_reads(network, context)?;
    if let Some(name) = free.iter().chain(read_there).find(|name| bound.contains(*name)) {
        return stuck(format!("{name} is read where it may be bound by somebody else"));
    }
    known_metavariables(&spoken.supposed, context)?;
    match &spoken.open {
        Some(name) => stuck(format!("{name} is not known: it stands for any name or process")),
        None => Ok(bound),
    }
}

/// What the processes bind that are called here, and what they read that they have not bound.
fn names_of_called(calls_here: &BTreeSet<Name>, context: &Context<'_>) -> Result<Rc<BoundAndRead>, Stuck> {
    if let Some(known) = context.defined.called.borrow().get(calls_here) {
        return Ok(Rc::clone(known));
    }
    let (mut bound, mut free, mut seen) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    let mut open: Vec<Name> = calls_here.iter().cloned().collect();
    while let Some(name) = open.pop() {
        if !seen.insert(name.clone()) {
            continue;
        }
        let Some(definition) = context.definitions.get(&name) else { return stuck(format!("{name} is not defined")) };
        if definition.body.depth() > MOST_DEPTH {
            return stuck(format!("{name} is nested too deeply"));
        }
        let spoken = context.defined.spoken_in(&definition.body);
        if (spoken.open.is_some() || !spoken.supposed.is_empty())
            && let Some(meta) = metavariables(&definition.body).into_iter().next()
        {
            return stuck(format!("{name} mentions the metavariable {meta}"));
        }
        bound.extend(spoken.bound.iter().cloned());
        let reads = context.defined.reads(&name);
        free.extend(known_names(&reads)?.iter().cloned());
        open.extend(spoken.calls.iter().cloned());
    }
    let found = Rc::new((bound, free));
    context.defined.remember_called(calls_here, &found);
    Ok(found)
}

/// Metavariables stand for values of which something is supposed: no instance puts in a name that the network binds
/// (see the kernel's `lemma`).
fn known_metavariables(read: &BTreeSet<Name>, context: &Context<'_>) -> Result<(), Stuck> {
    let supposed: BTreeSet<Name> = context.hypotheses.iter().flat_map(condition_metavariables).collect();
    match read.iter().find(|name| name.is_meta() && !supposed.contains(*name)) {
        Some(meta) => stuck(format!("nothing is supposed of {meta}")),
        None => Ok(()),
    }
}

/// The names that a process may read before it has bound them.
fn context_reads(term: &Term, context: &Context<'_>) -> Result<BTreeSet<Name>, Stuck> {
    known_names(&Facts::of(term, context).reads).cloned()
}

/// Names, where none of them belong to a process that is not known.
fn known_names(set: &NameSet) -> Result<&BTreeSet<Name>, Stuck> {
    match set.processes.first() {
        Some(unknown) => stuck(format!("{unknown} is not known")),
        None => Ok(&set.names),
    }
}

/// The one state to which all orders of communications lead, or what is drawn before, with the state in which that is
/// due, or the first one where it is due at several moments; given the ports, the names that are bound and those kept.
fn last_or_draws(
    runner: &Runner<'_, '_>,
    first: Term,
    (ports, names, kept): (&[Name], &BTreeSet<Name>, &BTreeSet<Name>),
) -> Result<(Term, Option<draw::Due>), Stuck> {
    match last(runner, first.clone(), ports) {
        Ok(state) => {
            let due = draw::is_due(&state).then(|| draw::Due::at_once(&state, state != first));
            Ok((state, due))
        }
        // What is drawn by a network that may stop would be carried.
        Err(why) if why.0 == ORDER && kept.is_empty() && draw::may_be_due(&first, runner.context) => {
            let due = apart::due(runner, &first, ports, names)?;
            Ok((first, Some(due)))
        }
        Err(why) => Err(why),
    }
}

/// The one state to which all orders of communications lead, at which nothing is communicated any more or draws are due.
fn last(runner: &Runner<'_, '_>, first: Term, ports: &[Name]) -> Result<Term, Stuck> {
    let found = last_of(runner, first.clone(), ports, Orders::Alike)?;
    // A draw is made before anything else is communicated, so communications that commute do not in all orders lead to
    // the moment at which it is due: all of them are followed.
    if draw::is_due(&found) { last_of(runner, first, ports, Orders::All) } else { Ok(found) }
}

/// Which orders of communications are followed.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Orders {
    /// All.
    All,
    /// Of orders that surely lead to the same state one.
    Alike,
}

/// The one state to which these orders of communications lead.
fn last_of(runner: &Runner<'_, '_>, first: Term, ports: &[Name], orders: Orders) -> Result<Term, Stuck> {
    let ports: BTreeSet<&Name> = ports.iter().collect();
    let (mut last, mut ways): (Option<Term>, usize) = (None, 0);
    let (mut seen, mut on_the_way) = (HashSet::new(), HashSet::new());
    let mut way: Vec<(Term, Vec<Term>)> = Vec::new();
    let first = if orders == Orders::Alike { handed_on(runner, &first, &ports)? } else { first };
    let mut here = Some(first);
    loop {
        if let Some(state) = here.take() {
            if on_the_way.contains(&state) {
                return stuck("it communicates for ever in no time");
            }
            if seen.insert(state.clone()) {
                let next = communications(runner, &state, &ports, orders)?;
                ways += next.len().saturating_sub(1);
                if next.is_empty() && last.replace(state.clone()).is_some_and(|other| other != state) {
                    return stuck(ORDER);
                }
                on_the_way.insert(state.clone());
                way.push((state, next));
            }
            if ways > MOST_ORDERS {
                return stuck("too much may happen in one instant");
            }
        }
        match way.last_mut() {
            None => break,
            Some((_, next)) => here = next.pop(),
        }
        if here.is_none()
            && let Some((state, _)) = way.pop()
        {
            on_the_way.remove(&state);
        }
    }
    last.map_or_else(|| stuck("nothing was found"), Ok)
}

/// Who writes what to each port, with the `new` that binds it.
type Writers<'t> = BTreeMap<(&'t Name, Option<usize>), Vec<(usize, &'t Value)>>;

/// The states after each communication that is possible; after some at once, if they commute with all others and not
/// all orders are asked for. None is possible while a draw is due.
fn communications(
    runner: &Runner<'_, '_>,
    state: &Term,
    ports: &BTreeSet<&Name>,
    orders: Orders,
) -> Result<Vec<Term>, Stuck> {
    let leaves = leaves(state);
    let mut writers = Writers::new();
    for (writer, leaf) in leaves.iter().enumerate() {
        if let Node::In(port, _) | Node::Out(port, _) = leaf.term.node()
            && leaf.binder.is_none()
            && !ports.contains(port)
        {
            return stuck(open_port(port));
        }
        if let Node::Out(port, value) = leaf.term.node() {
            writers.entry((port, leaf.binder)).or_default().push((writer, value));
        }
    }
    let mut pairs = Vec::new();
    for (reader, leaf) in leaves.iter().enumerate() {
        let Node::In(port, name) = leaf.term.node() else { continue };
        for (writer, value) in writers.get(&(port, leaf.binder)).into_iter().flatten().copied() {
            pairs.push(Meeting { reader, writer, port, binder: leaf.binder, name, value });
        }
    }
    if pairs.is_empty() || draw::is_due(state) {
        return Ok(Vec::new());
    }
    let alone = if orders == Orders::Alike { alone(runner, state, &leaves, &pairs) } else { BTreeSet::new() };
    let mut next = Vec::new();
    let mut meet = |meetings: &[&Meeting<'_>]| -> Result<(), Stuck> {
        let mut met: HashMap<usize, Term> = HashMap::new();
        for meeting in meetings {
            met.insert(meeting.reader, runner.bound(meeting.value, meeting.name, &leaves[meeting.reader]));
            met.insert(meeting.writer, Term::stop());
        }
        next.push(runner.running(&rebuilt(state, &mut 0, &mut |number, _| met.get(&number).cloned()))?);
        Ok(())
    };
    if alone.is_empty() {
        pairs.iter().try_for_each(|meeting| meet(&[meeting]))?;
    } else {
        meet(&alone.iter().map(|place| &pairs[*place]).collect::<Vec<_>>())?;
    }
    Ok(next)
}
