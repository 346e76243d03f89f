//! Termination: what a part of a network has become once everything that ends at once has ended.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::leaf::Leaf;
use super::{MOST_DEPTH, active, context_reads, is_set, stuck};
use crate::fact::{Context, Facts};
use crate::law::Condition;
use crate::name::Name;
use crate::scope::{bound_names, written};
use crate::substitution::{Stuck, carried_on, instantiate, substitute_known};
use crate::term::{Node, Term, TermMap, TermSet};
use crate::value::{Atom, Need, Relation, Sort, Value, ValueError};

/// What has been bound, by name.
type Results = BTreeMap<Name, Value>;

/// Operators and unfoldings that may stand inside one another.
const DEEPEST: usize = 200;
/// Parts that are looked at in one instant.
const MOST_WORK: usize = 300_000;

/// What a term has become once everything that ends at once has ended.
enum State {
    Stopped(Results),
    Aborted,
    Running(Term),
}

impl State {
    /// A part that carries nothing, as [`State::as_term`] gives it.
    fn from(part: &Term) -> State {
        match part.node() {
            Node::Stop => State::Stopped(Results::new()),
            Node::Abort => State::Aborted,
            _ => State::Running(part.clone()),
        }
    }

    /// What runs, or how it ended, with what it carries.
    fn as_term(&self) -> Term {
        match self {
            State::Running(part) => part.clone(),
            State::Stopped(results) => Term::seq(sets(results.clone())),
            State::Aborted => Term::abort(),
        }
    }
}

fn sets(results: Results) -> impl Iterator<Item = Term> {
    results.into_iter().map(|(name, value)| Term::new(Node::Set(value, name)))
}

/// Adds one part's results to those of others that stopped beside it.
fn unite(all: &mut Results, more: Results) -> Result<(), Stuck> {
    for (name, value) in more {
        if all.get(&name).is_some_and(|other| *other != value) {
            return stuck(format!("{name} is bound twice side by side"));
        }
        all.insert(name, value);
    }
    Ok(())
}

/// A running part and what it has bound so far.
fn without_sets(part: Term) -> (Results, Term) {
    let mut results = Results::new();
    let Node::Seq(parts) = part.node() else { return (results, part) };
    let place = active(parts).unwrap_or(parts.len());
    for set in &parts[..place] {
        if let Node::Set(value, name) = set.node() {
            results.insert(name.clone(), value.clone());
        }
    }
    (results, parts.after(place))
}

fn starts_with_set(part: &Term) -> bool {
    matches!(part.node(), Node::Seq(parts) if parts.first().is_some_and(is_set))
}

/// Settles the parts of a network.
pub(super) struct Runner<'c, 'd> {
    pub(super) context: &'c Context<'d>,
    /// Names that are compared if the network stops.
    kept: &'c BTreeSet<Name>,
    work: Cell<usize>,
    /// Parts of the network itself that were seen to be left as they are.
    settled: RefCell<TermSet>,
    /// Which parts are servers, and the ports that parts write to (`alone`).
    pub(super) servers: RefCell<TermMap<bool>>,
    pub(super) written: RefCell<TermMap<Rc<BTreeSet<Name>>>>,
}

impl<'c, 'd> Runner<'c, 'd> {
    pub(super) fn new(context: &'c Context<'d>, kept: &'c BTreeSet<Name>) -> Runner<'c, 'd> {
        Runner {
            context,
            kept,
            work: Cell::new(0),
            settled: RefCell::default(),
            servers: RefCell::default(),
            written: RefCell::default(),
        }
    }

    /// The body of a network, settled; it must run.
    pub(super) fn running(&self, body: &Term) -> Result<Term, Stuck> {
        match self.ended_or_running(body)? {
            (false, state) => Ok(state),
            (true, _) => stuck("the network has ended"),
        }
    }

    /// Whether the body of a network ends at once, and how it ends or else what then runs.
    pub(super) fn ended_or_running(&self, body: &Term) -> Result<(bool, Term), Stuck> {
        match self.settle(body, self.kept, 0)? {
            State::Running(state) if state.depth() <= MOST_DEPTH => Ok((false, state)),
            State::Running(_) => stuck("it is nested too deeply"),
            State::Stopped(results) => Ok((true, Term::seq(sets(results)))),
            State::Aborted => Ok((true, Term::abort())),
        }
    }

    /// One of the parts of a network that run side by side, settled; `Stop` or `Abort` if it has ended.
    pub(super) fn part(&self, part: &Term) -> Result<Term, Stuck> {
        match self.settle_part(part, 0)? {
            State::Running(state) if state.depth() > MOST_DEPTH => stuck("it is nested too deeply"),
            settled => Ok(settled.as_term()),
        }
    }

    /// One of the parts of a network that run side by side, settled; nothing if it has ended.
    pub(super) fn goes_on(&self, part: &Term) -> Result<Option<Term>, Stuck> {
        match self.settle_part(part, 0)? {
            State::Running(state) if state.depth() > MOST_DEPTH => stuck("it is nested too deeply"),
            State::Running(state) => Ok(Some(state)),
            State::Stopped(_) | State::Aborted => Ok(None),
        }
    }

    /// One of the parts that run side by side, settled: what comes of it depends on it, and on what is kept, alone. Where
    /// nothing is, it is the same for every network in this context, if it reads nothing that is then gone.
    fn settle_part(&self, part: &Term, depth: usize) -> Result<State, Stuck> {
        if !self.kept.is_empty() {
            if self.settled.borrow().contains(part) {
                return Ok(State::Running(part.clone()));
            }
            let found = self.settle(part, self.kept, depth)?;
            if matches!(&found, State::Running(now) if now == part) {
                self.settled.borrow_mut().insert(part.clone());
            }
            return Ok(found);
        }
        if let Some(known) = self.context.settled.borrow().get(part) {
            return Ok(State::from(known));
        }
        let before = std::mem::take(&mut *self.context.read.borrow_mut());
        let found = self.settle(part, self.kept, depth);
        let here = self.context.read.replace(before);
        if let (Ok(found), true) = (&found, here.is_empty()) {
            self.context.settled.borrow_mut().insert(part.clone(), found.as_term());
        }
        self.context.read.borrow_mut().extend(here);
        found
    }

    fn spend(&self, depth: usize) -> Result<(), Stuck> {
        let work = self.work.get() + 1;
        self.work.set(work);
        if depth > DEEPEST {
            return stuck("it unfolds for ever without waiting or communicating, or is nested too deeply");
        }
        if work > MOST_WORK {
            return stuck("too much may happen in one instant");
        }
        Ok(())
    }

    /// What a reader is that has read this value: nothing where nobody reads what it is bound to.
    pub(super) fn bound(&self, value: &Value, name: &Name, reader: &Leaf<'_>) -> Term {
        if self.is_unread(name, reader) {
            self.note(value);
            return Term::stop();
        }
        Term::new(Node::Set(value.clone(), name.clone()))
    }

    /// Whether nobody reads what this leaf may bind to this name: neither what follows it nor the end of the network.
    fn is_unread(&self, name: &Name, leaf: &Leaf<'_>) -> bool {
        let reads = |rest: Term| context_reads(&rest, self.context).map_or(true, |reads| reads.contains(name));
        !self.kept.contains(name) && !leaf.followed_by().any(reads)
    }

    /// Notes what a value needs that is read now, and perhaps stands nowhere any more.
    pub(super) fn note(&self, value: &Value) {
        let needs = value.needs();
        if !needs.is_empty() {
            let needs = self.needs_by_condition(value).unwrap_or(needs);
            self.context.read.borrow_mut().extend(needs);
        }
    }

    /// What a value needs with its conditions as they are known to be: nothing of a branch that does not count. Maxima stay:
    /// what they leave out must have a value, too.
    fn needs_by_condition(&self, value: &Value) -> Result<BTreeSet<Need>, ValueError> {
        let (mut settled, mut needs) = (value.clone(), BTreeSet::new());
        for atom in value.atoms() {
            let Atom::Positive(inner) = &atom else { continue };
            if let Some(holds) = self.context.assumptions.decide(Relation::Gtr, inner, &Value::zero()) {
                needs.extend(self.needs_by_condition(inner)?);
                settled = settled.with_atom(&atom, &Value::integer(i64::from(holds)))?;
            }
        }
        needs.extend(settled.needs());
        Ok(needs)
    }

    fn simple(&self, value: &Value) -> Value {
        self.note(value);
        self.context.simplify(value)
    }

    /// Ends all that ends at once. `wanted` are the names that are read later.
    fn settle(&self, term: &Term, wanted: &BTreeSet<Name>, depth: usize) -> Result<State, Stuck> {
        self.spend(depth)?;
        match term.node() {
            Node::Stop => Ok(State::Stopped(Results::new())),
            Node::Abort => Ok(State::Aborted),
            Node::Idle | Node::In(..) => Ok(State::Running(term.clone())),
            Node::Out(..) | Node::Observe(..) | Node::Ran(..) => {
                Ok(State::Running(term.map_values(&mut |value| Ok::<_, Stuck>(self.simple(value)))?))
            }
            Node::Delay(time) => self.settle_delay(time),
            Node::Guard(relation, left, right) => self.settle_guard(*relation, left, right),
            Node::Set(value, name) if wanted.contains(name) => {
                Ok(State::Stopped(Results::from([(name.clone(), self.simple(value))])))
            }
            Node::Set(value, _) => {
                self.note(value);
                Ok(State::Stopped(Results::new()))
            }
            Node::Seq(_) => self.settle_sequence(term, wanted, depth),
            Node::Else(first, second) => match self.settle(first, wanted, depth + 1)? {
                State::Aborted => self.settle(second, wanted, depth + 1),
                State::Running(first) if Facts::of(&first, self.context).may_abort => {
                    Ok(State::Running(Term::otherwise(first, second.clone())))
                }
                other => Ok(other),
            },
            Node::Par(parts) => self.settle_parallel(parts, wanted, depth),
            Node::Disable(parts) => self.settle_disabling(parts, wanted, depth),
            Node::Power(body, count, index) => self.settle_power(body, count, index.as_ref(), wanted, depth),
            Node::Loop(body) => {
                let round = Term::attempt(Term::seq([body.clone(), term.clone()]));
                self.settle(&round, wanted, depth + 1)
            }
            Node::Call(name, arguments) => self.settle_call(name, arguments, wanted, depth),
            Node::New(_, body) | Node::Project(body, _) => Ok(match self.settle(body, wanted, depth + 1)? {
                State::Running(part) => {
                    let (results, part) = without_sets(part);
                    State::Running(Term::seq(sets(results).chain([term.with_children(vec![part])])))
                }
                ended => ended,
            }),
            Node::Meta(name, _) | Node::Replace(_, name, _) => stuck(format!("{name} is not known")),
        }
    }

    fn settle_delay(&self, time: &Value) -> Result<State, Stuck> {
        let (time, zero) = (self.simple(time), Value::zero());
        let known = &self.context.assumptions;
        if time.sort() == Sort::Real && known.decide(Relation::Eq, &time, &zero) == Some(true) {
            return Ok(State::Stopped(Results::new()));
        }
        if time.sort() == Sort::Real && known.decide(Relation::Gtr, &time, &zero) == Some(true) {
            return Ok(State::Running(Term::delay(time)));
        }
        stuck(format!("whether {time} > 0"))
    }

    fn settle_guard(&self, relation: Relation, left: &Value, right: &Value) -> Result<State, Stuck> {
        [left, right].into_iter().for_each(|value| self.note(value));
        let real = left.sort() == Sort::Real && right.sort() == Sort::Real;
        let decided = match relation {
            Relation::Eq | Relation::Neq => self.context.assumptions.decide(relation, left, right),
            _ if real => self.context.assumptions.decide(relation, left, right),
            _ => None,
        };
        match decided.or_else(|| self.supposed(relation, left, right)) {
            Some(true) => Ok(State::Stopped(Results::new())),
            Some(false) => Ok(State::Aborted),
            None => stuck(format!("whether {left} {} {right}", relation.symbol())),
        }
    }

    /// Whether just this comparison, or the contrary, is supposed: so it counts where not all is known of what stands in it.
    fn supposed(&self, relation: Relation, left: &Value, right: &Value) -> Option<bool> {
        let supposes = |relation| self.context.supposes(&Condition::Compare(relation, left.clone(), right.clone()));
        if supposes(relation) { Some(true) } else { supposes(relation.negated()).then_some(false) }
    }

    fn settle_sequence(&self, whole: &Term, wanted: &BTreeSet<Name>, depth: usize) -> Result<State, Stuck> {
        let mut carried = Results::new();
        let mut now = whole.clone();
        loop {
            let (first, rest) = match now.node() {
                Node::Seq(parts) => (parts.first().cloned().unwrap_or_else(Term::stop), Some(parts.after(1))),
                _ => (now.clone(), None),
            };
            let mut all = wanted.clone();
            if let Some(rest) = &rest {
                all.extend(context_reads(rest, self.context)?);
            }
            let (results, running) = match self.settle(&first, &all, depth + 1)? {
                State::Aborted => return Ok(State::Aborted),
                State::Stopped(results) => (results, None),
                State::Running(part) if part == first && !starts_with_set(&part) => (Results::new(), Some(now)),
                State::Running(part) => {
                    let (results, part) = without_sets(part);
                    (results, Some(Term::seq(std::iter::once(part).chain(rest.clone()))))
                }
            };
            let stops = running.is_none();
            let mut left = running.or(rest);
            // What the running part has bound is read by what follows, unless it binds it again.
            for (name, value) in &results {
                left = left.map(|left| carried_on(&left, name, value, self.context)).transpose()?;
            }
            carried.extend(results.into_iter().filter(|(name, _)| wanted.contains(name)));
            match left {
                None => return Ok(State::Stopped(carried)),
                Some(left) if !stops => return Ok(State::Running(Term::seq(sets(carried).chain([left])))),
                Some(left) => now = left,
            }
        }
    }

    fn settle_parallel(&self, parts: &[Term], wanted: &BTreeSet<Name>, depth: usize) -> Result<State, Stuck> {
        let mut running = Vec::new();
        let mut stopped: Option<Results> = None;
        let outermost = std::ptr::eq(wanted, self.kept);
        for part in parts {
            let settled =
                if outermost { self.settle_part(part, depth + 1) } else { self.settle(part, wanted, depth + 1) };
            match settled? {
                State::Stopped(results) => unite(stopped.get_or_insert_default(), results)?,
                State::Aborted => {}
                State::Running(now) => running.push(now),
            }
        }
        if running.is_empty() {
            return Ok(stopped.map_or(State::Aborted, State::Stopped));
        }
        if let Some(results) = stopped {
            let surely = running.iter().any(|part| !Facts::of(part, self.context).may_abort);
            if !(surely && results.is_empty()) {
                running.push(Term::seq(sets(results)));
            }
        }
        Ok(State::Running(Term::par(running)))
    }

    fn settle_disabling(&self, parts: &[Term], wanted: &BTreeSet<Name>, depth: usize) -> Result<State, Stuck> {
        let mut running = Vec::new();
        let mut stopped: Option<Results> = None;
        let mut ended = false;
        for part in parts {
            match self.settle(part, wanted, depth + 1)? {
                State::Stopped(results) => {
                    unite(stopped.get_or_insert_default(), results)?;
                    ended = true;
                }
                State::Aborted => ended = true,
                State::Running(part) if *part.node() == Node::Idle => {}
                State::Running(part) => running.push(part),
            }
        }
        Ok(match stopped {
            Some(results) => State::Stopped(results),
            None if ended => State::Aborted,
            None => State::Running(Term::disable(running)),
        })
    }

    fn settle_power(
        &self,
        body: &Term,
        count: &Value,
        index: Option<&Name>,
        wanted: &BTreeSet<Name>,
        depth: usize,
    ) -> Result<State, Stuck> {
        let count = self.simple(count);
        let known = &self.context.assumptions;
        if known.is_natural(&count) != Some(true) {
            return stuck(format!("{count} copies"));
        }
        if index.is_some_and(|index| bound_names(body).contains(index) || self.writes(body, index)) {
            return stuck("the index of copies is bound in them");
        }
        match known.decide(Relation::Gtr, &count, &Value::zero()) {
            Some(true) => {}
            Some(false) => return Ok(State::Stopped(Results::new())),
            None => return stuck(format!("whether {count} > 0")),
        }
        let left = count.sub(&Value::one())?;
        let (first, others) = match index {
            Some(index) => {
                let at = |value: Value| {
                    substitute_known(body, &BTreeMap::from([(index.clone(), value)]), &self.context.assumptions)
                };
                // The index of the copies left starts again at 0, so they read it one higher.
                let shifted = at(Value::variable(index).add(&Value::one())?)?;
                (at(Value::zero())?, shifted)
            }
            None => (body.clone(), body.clone()),
        };
        // One copy is that copy.
        if left.is_zero() {
            return self.settle(&first, wanted, depth + 1);
        }
        let rest = match index {
            None if left == Value::one() => others,
            Some(index) if left == Value::one() => {
                let map = BTreeMap::from([(index.clone(), Value::zero())]);
                substitute_known(&others, &map, &self.context.assumptions)?
            }
            _ => Term::new(Node::Power(others, left, index.cloned())),
        };
        self.settle(&Term::seq([first, rest]), wanted, depth + 1)
    }

    fn writes(&self, body: &Term, name: &Name) -> bool {
        written(body, self.context.definitions).contains(name)
    }

    fn settle_call(
        &self,
        name: &Name,
        arguments: &[Value],
        wanted: &BTreeSet<Name>,
        depth: usize,
    ) -> Result<State, Stuck> {
        let known = self.context.definitions.get(name);
        let Some(definition) = known.filter(|known| known.parameters.len() == arguments.len()) else {
            return stuck(format!("{name} is not defined so"));
        };
        let arguments: Vec<Value> = arguments.iter().map(|value| self.simple(value)).collect();
        let body = instantiate(&definition.body, &definition.parameters, &arguments, self.context)?;
        let body = if definition.recursive { Term::attempt(body) } else { body };
        self.settle(&body, wanted, depth + 1)
    }
}
