//! What a process may do, read off its term: the conditions of laws are decided from this and from nothing else.
//!
//! Every `may_…` is an over-approximation, so its absence is a fact about the meaning. One definition,
//! [`Facts::of`], serves the kernel and the prover alike.

mod combine;
mod defined;
mod supposed;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::rc::Rc;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::law::Condition;
use crate::name::Name;
use crate::scope::{Spoken, calls};
use crate::term::{Node, Term, TermMap};
use crate::value::{Atom, Need, Relation, Sort, Value};
pub(crate) use defined::{BoundAndRead, Defined};

/// A set of names that may grow by all the names of some process metavariables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NameSet {
    /// The names known.
    pub names: BTreeSet<Name>,
    /// Metavariables whose names belong to the set as well.
    pub processes: BTreeSet<Name>,
}

impl NameSet {
    /// Just one name.
    pub fn one(name: &Name) -> NameSet {
        NameSet { names: BTreeSet::from([name.clone()]), processes: BTreeSet::new() }
    }

    fn of_process(name: &Name) -> NameSet {
        NameSet { names: BTreeSet::new(), processes: BTreeSet::from([name.clone()]) }
    }

    /// Adds another set to it.
    pub fn extend(&mut self, other: &NameSet) {
        self.names.extend(other.names.iter().cloned());
        self.processes.extend(other.processes.iter().cloned());
    }

    /// True of the empty set.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty() && self.processes.is_empty()
    }
}

/// What a process may do. See the module's head for the direction of each approximation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Facts {
    /// May stop at some time.
    pub may_stop: bool,
    /// May abort at some time.
    pub may_abort: bool,
    /// May be running at its start.
    pub starts_running: bool,
    /// May have stopped at its start.
    pub starts_stopped: bool,
    /// May have aborted at its start.
    pub starts_aborted: bool,
    /// May stop having neither waited nor communicated.
    pub instant_stop: bool,
    /// May abort having neither waited nor communicated.
    pub instant_abort: bool,
    /// May offer a communication, or move by itself, before it has waited.
    pub early: bool,
    /// May communicate, privately or not.
    pub communicates: bool,
    /// May draw at random.
    pub draws: bool,
    /// Ports it may use.
    pub ports: NameSet,
    /// Names that it may bind.
    pub binds: NameSet,
    /// Names that it has bound whenever it stops.
    pub surely_binds: BTreeSet<Name>,
    /// Names that it may read before it has bound them.
    pub reads: NameSet,
    /// If present: silent, binds nothing and always stops, after exactly this time.
    pub duration: Option<Value>,
    /// Never ends, does nothing, shows the same for ever.
    pub observer: bool,
    /// The observers that may be shown; nothing if any may.
    pub shows: Option<BTreeSet<Name>>,
    /// One comparison, which ends at once.
    pub guard: bool,
}

impl Default for Facts {
    /// The facts of a process that does nothing at all, not even run: the bottom of the approximation.
    fn default() -> Facts {
        Facts {
            may_stop: false,
            may_abort: false,
            starts_running: false,
            starts_stopped: false,
            starts_aborted: false,
            instant_stop: false,
            instant_abort: false,
            early: false,
            communicates: false,
            draws: false,
            ports: NameSet::default(),
            binds: NameSet::default(),
            surely_binds: BTreeSet::new(),
            reads: NameSet::default(),
            duration: None,
            observer: false,
            shows: Some(BTreeSet::new()),
            guard: false,
        }
    }
}

/// Where facts are asked: the assumptions on values, the definitions, the hypotheses on metavariables.
pub struct Context<'a> {
    /// Facts about parameters, those of the hypotheses included.
    pub assumptions: Assumptions,
    /// The definitions in force.
    pub definitions: &'a Definitions,
    /// What a claim supposes of its metavariables.
    pub hypotheses: &'a [Condition],
    /// What the definitions may do.
    pub(crate) defined: Rc<Defined>,
    /// What [`Facts::of`] has found here: nothing that it rests on changes while the context lives.
    known: RefCell<TermMap<Rc<Facts>>>,
    /// What [`Context::facts_of_parts`] was last asked about, with its answer.
    pub(crate) last: RefCell<Option<(Term, Rc<[u16]>)>>,
    /// Which facts hold of a term, as bits: what `Context::facts_held` has found.
    pub(crate) held: RefCell<TermMap<u16>>,
    /// What [`Context::simplify`] has found.
    simple: RefCell<HashMap<Value, Value>>,
    /// The names that stand in terms: what `advance` has found.
    pub(crate) spoken: RefCell<TermMap<Rc<Spoken>>>,
    /// What the values need that `advance` has read here: those of guards and others stand in nothing that comes of it.
    pub(crate) read: RefCell<BTreeSet<Need>>,
    /// What parts of networks that never stop become once all that ends at once has ended, where that reads nothing that
    /// is not there any more: what `advance` has found.
    pub(crate) settled: RefCell<TermMap<Term>>,
    /// Where `advance` has last come to: a run asks next how that goes on.
    pub(crate) reached: RefCell<Option<Reached>>,
}

/// A network that never stops, at the end of its instant.
#[derive(Clone)]
pub(crate) struct Reached {
    pub(crate) network: Term,
    /// What runs inside its ports.
    pub(crate) state: Term,
    pub(crate) ports: Rc<[Name]>,
    /// All names that it may bind, and perhaps more.
    pub(crate) names: Rc<BTreeSet<Name>>,
}

/// The most hypotheses that are read in the light of each other.
const MOST_READ: usize = 16;

/// Whether a maximum or a condition stands in a value, be it under a root.
fn folded(value: &Value) -> bool {
    value.atoms().iter().any(|atom| match atom {
        Atom::Maximum(_) | Atom::Positive(_) => true,
        Atom::Root(inner) => folded(inner),
        _ => false,
    })
}

/// What each hypothesis in which a maximum or a condition stands says where the others hold: `min(r,3) = 3` with `r < 2`
/// that 2 is more than 3.
fn as_others_say(plain: &Assumptions, hypotheses: &[Condition]) -> Vec<(Relation, Value, Value)> {
    let mut found = Vec::new();
    for (place, hypothesis) in hypotheses.iter().enumerate().take(MOST_READ) {
        let Condition::Compare(relation, left, right) = hypothesis else { continue };
        if !folded(left) && !folded(right) {
            continue;
        }
        let mut known = plain.clone();
        for other in hypotheses[..place].iter().chain(&hypotheses[place + 1..]).take(MOST_READ) {
            if let Condition::Compare(relation, left, right) = other {
                known.assume(*relation, left, right);
            }
        }
        let both = (known.simplify(left), known.simplify(right));
        if (&both.0, &both.1) != (left, right) {
            found.push((*relation, both.0, both.1));
        }
    }
    found
}

/// What is assumed where these hypotheses hold.
pub(crate) fn supposing(plain: &Assumptions, hypotheses: &[Condition]) -> Assumptions {
    let mut assumptions = plain.clone();
    for hypothesis in hypotheses {
        match hypothesis {
            Condition::Compare(relation, left, right) => assumptions.assume(*relation, left, right),
            Condition::Natural(value) => {
                if let Some(name) = value.as_variable().cloned() {
                    assumptions.assume_natural(&name);
                }
            }
            _ => {}
        }
    }
    // The same as the values of a network are simplified.
    let simple = |value: &Value| plain.simplify(value);
    let compared: Vec<(Relation, Value, Value)> = hypotheses
        .iter()
        .filter_map(|hypothesis| match hypothesis {
            Condition::Compare(relation, left, right) => Some((*relation, simple(left), simple(right))),
            _ => None,
        })
        .collect();
    for (relation, left, right) in compared.into_iter().chain(as_others_say(plain, hypotheses)) {
        assumptions.assume(relation, &left, &right);
    }
    assumptions
}

impl<'a> Context<'a> {
    /// The context of a claim with these hypotheses.
    pub fn new(assumptions: &Assumptions, definitions: &'a Definitions, hypotheses: &'a [Condition]) -> Context<'a> {
        let assumptions = supposing(assumptions, hypotheses);
        let defined = Defined::under(&assumptions, definitions, hypotheses);
        Context::of(assumptions, (definitions, defined), hypotheses)
    }

    /// The context in which the definitions may do this.
    fn of(
        assumptions: Assumptions,
        (definitions, defined): (&'a Definitions, Rc<Defined>),
        hypotheses: &'a [Condition],
    ) -> Context<'a> {
        Context {
            assumptions,
            definitions,
            hypotheses,
            defined,
            known: RefCell::default(),
            last: RefCell::default(),
            held: RefCell::default(),
            simple: RefCell::default(),
            spoken: RefCell::default(),
            read: RefCell::default(),
            settled: RefCell::default(),
            reached: RefCell::default(),
        }
    }

    /// The value as [`Assumptions::simplify`] leaves it: the same is asked for at every state of a run.
    pub fn simplify(&self, value: &Value) -> Value {
        if value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_))) && value.sort() == Sort::Real {
            return value.clone();
        }
        if let Some(known) = self.simple.borrow().get(value) {
            return known.clone();
        }
        let found = self.assumptions.simplify(value);
        self.simple.borrow_mut().insert(value.clone(), found.clone());
        found
    }

    /// The names that the processes called in a term read where they are called: no parameter, index or replacement
    /// around the call changes what such a name means there.
    fn read_in_calls(&self, term: &Term) -> BTreeSet<Name> {
        let called = calls(term);
        called
            .iter()
            .filter_map(|name| self.defined.facts.get(name))
            .flat_map(|facts| facts.reads.names.clone())
            .collect()
    }

    /// Whether the claim supposes just this.
    pub fn supposes(&self, condition: &Condition) -> bool {
        self.hypotheses.contains(condition)
    }
}

impl Facts {
    /// The facts of a term.
    pub fn of(term: &Term, context: &Context<'_>) -> Rc<Facts> {
        if let Some(known) = context.known.borrow().get(term) {
            return known.clone();
        }
        if let Some(found) = Facts::of_long(term, context) {
            return found;
        }
        if let Some(facts) = Facts::of_closed(term, context) {
            context.known.borrow_mut().insert(term.clone(), Rc::clone(&facts));
            return facts;
        }
        let parts: Vec<Rc<Facts>> = term.children().map(|part| Facts::of(part, context)).collect();
        let facts = Rc::new(Facts::combine(term, &parts, context));
        context.known.borrow_mut().insert(term.clone(), facts.clone());
        facts
    }

    /// The facts of a term from those of its direct parts: the step that [`Facts::of`] folds.
    pub fn combine(term: &Term, parts: &[Rc<Facts>], context: &Context<'_>) -> Facts {
        let body = || parts.first().map_or_else(Facts::default, |part| Facts::clone(part));
        let mut facts = match term.node() {
            Node::Seq(_) => parts.iter().skip(1).fold(body(), |before, next| before.then(next)),
            Node::Par(branches) => {
                let mut facts = Facts::parallel(parts);
                if facts.may_abort && combine::one_goes_on(branches, context) {
                    (facts.may_abort, facts.starts_aborted, facts.instant_abort) = (false, false, false);
                }
                facts
            }
            Node::Disable(_) => Facts::disabling(parts),
            Node::Else(..) => match parts {
                [first, second] => Facts::otherwise(Facts::clone(first), second),
                _ => Facts::default(),
            },
            Node::Power(_, count, index) => Facts::power(body(), count, index, context),
            Node::Loop(_) => Facts::repeated(body()),
            Node::New(port, _) => {
                let mut facts = body();
                facts.ports.names.remove(port);
                facts
            }
            Node::Project(_, shown) => {
                let mut facts = body();
                let all = facts.shows.unwrap_or_else(|| shown.clone());
                facts.shows = Some(all.intersection(shown).cloned().collect());
                facts
            }
            Node::Replace(_, name, _) => {
                let Facts { binds, ports, reads, .. } = body();
                Facts { binds, ports, reads, ..Facts::anything(name) }
            }
            _ => Facts::leaf(term, context),
        };
        if let Node::Power(body, _, Some(name)) | Node::Replace(body, name, _) = term.node()
            && !context.read_in_calls(body).contains(name)
        {
            facts.reads.names.remove(name);
        }
        for value in term.values() {
            facts.reads.names.extend(value.variables());
        }
        facts.binding_where_it_stops()
    }

    fn leaf(term: &Term, context: &Context<'_>) -> Facts {
        match term.node() {
            Node::Stop => Facts::ended(true, false, Some(Value::integer(0))),
            Node::Abort => Facts::ended(false, true, None),
            Node::Idle => Facts { starts_running: true, observer: true, ..Facts::default() },
            Node::Observe(name, _) => {
                let shows = Some(BTreeSet::from([name.clone()]));
                Facts { starts_running: true, observer: true, shows, ..Facts::default() }
            }
            Node::Delay(time) => Facts::delay(time, context),
            Node::In(port, name) => Facts {
                binds: NameSet::one(name),
                surely_binds: BTreeSet::from([name.clone()]),
                ..Facts::communication(port)
            },
            Node::Out(port, _) => Facts::communication(port),
            Node::Guard(relation, left, right) => {
                let decided = context.assumptions.decide(*relation, left, right);
                let duration = (decided == Some(true)).then(|| Value::integer(0));
                Facts { guard: true, ..Facts::ended(decided != Some(false), decided != Some(true), duration) }
            }
            Node::Set(_, name) => Facts {
                binds: NameSet::one(name),
                surely_binds: BTreeSet::from([name.clone()]),
                ..Facts::ended(true, false, None)
            },
            Node::Ran(_, name) => Facts {
                starts_running: true,
                early: true,
                draws: true,
                binds: NameSet::one(name),
                surely_binds: BTreeSet::from([name.clone()]),
                ..Facts::ended(true, false, None)
            },
            Node::Call(name, arguments) => Facts::call(name, arguments, context),
            Node::Meta(name, _) => Facts::metavariable(name, term, context),
            _ => Facts::default(),
        }
    }

    pub(super) fn ended(stopped: bool, aborted: bool, duration: Option<Value>) -> Facts {
        Facts {
            may_stop: stopped,
            may_abort: aborted,
            starts_stopped: stopped,
            starts_aborted: aborted,
            instant_stop: stopped,
            instant_abort: aborted,
            duration,
            ..Facts::default()
        }
    }

    fn delay(time: &Value, context: &Context<'_>) -> Facts {
        let zero = Value::integer(0);
        let positive = context.assumptions.decide(Relation::Gtr, time, &zero);
        let natural = context.assumptions.decide(Relation::Gte, time, &zero) == Some(true);
        Facts {
            may_stop: true,
            starts_running: positive != Some(false),
            starts_stopped: positive != Some(true),
            instant_stop: positive != Some(true),
            duration: natural.then(|| time.clone()),
            ..Facts::default()
        }
    }

    fn communication(port: &Name) -> Facts {
        Facts {
            may_stop: true,
            starts_running: true,
            early: true,
            communicates: true,
            ports: NameSet::one(port),
            ..Facts::default()
        }
    }

    fn anything(name: &Name) -> Facts {
        Facts {
            may_stop: true,
            may_abort: true,
            starts_running: true,
            starts_stopped: true,
            starts_aborted: true,
            instant_stop: true,
            instant_abort: true,
            early: true,
            communicates: true,
            draws: true,
            shows: None,
            ports: NameSet::of_process(name),
            binds: NameSet::of_process(name),
            reads: NameSet::of_process(name),
            ..Facts::default()
        }
    }

    fn call(name: &Name, arguments: &[Value], context: &Context<'_>) -> Facts {
        let (Some(definition), Some(known)) = (context.definitions.get(name), context.defined.facts.get(name)) else {
            return Facts::anything(name);
        };
        let mut facts = known.clone();
        let map: BTreeMap<Name, Value> = definition.parameters.iter().cloned().zip(arguments.iter().cloned()).collect();
        facts.duration = facts.duration.and_then(|duration| context.assumptions.put_in(&duration, &map).ok());
        facts
    }
}
