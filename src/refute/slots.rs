//! What varies in a claim: its metavariables and symbolic parameters, by what they stand for.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::law::Condition;
use crate::name::Name;
use crate::scope::written;
use crate::term::{Node, Term};
use crate::value::Value;
use crate::value::number::around;

/// One thing to choose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// A process, over this many parameters.
    Process(Name, usize),
    /// A value, which may read a result.
    Value(Name),
    /// A value that reads nothing, as a number of rounds.
    Count(Name),
    /// A symbol of the claim or of its definitions, which is no metavariable.
    Parameter(Name),
    /// A distribution.
    Distribution(Name),
    /// A port.
    Port(Name),
    /// The name of a result.
    Result(Name),
}

impl Slot {
    pub(super) fn name(&self) -> &Name {
        match self {
            Slot::Process(name, _)
            | Slot::Value(name)
            | Slot::Count(name)
            | Slot::Parameter(name)
            | Slot::Distribution(name)
            | Slot::Port(name)
            | Slot::Result(name) => name,
        }
    }
}

/// The concrete names and numbers of a claim, which instances use too.
pub(super) struct Vocabulary {
    pub(super) ports: Vec<Name>,
    pub(super) results: Vec<Name>,
    pub(super) inputs: Vec<Value>,
    /// Numbers on each side of those that the claim mentions, besides the few that every claim is tried with.
    pub(super) numbers: Vec<BigRational>,
}

/// What is judged: the claim, and all that is said of its names.
pub(super) struct Matter<'a> {
    pub(super) sides: [&'a Term; 2],
    pub(super) conditions: &'a [Condition],
    pub(super) definitions: &'a Definitions,
    pub(super) assumptions: &'a Assumptions,
}

/// The most values that the surroundings may write.
const MOST_INPUTS: usize = 6;

/// Everything named in some terms, by kind.
#[derive(Default)]
struct Found {
    processes: BTreeMap<Name, usize>,
    values: BTreeSet<Name>,
    distributions: BTreeSet<Name>,
    ports: BTreeSet<Name>,
    results: BTreeSet<Name>,
    indices: BTreeSet<Name>,
    counts: BTreeSet<Name>,
    compared: BTreeSet<Value>,
    numbers: BTreeSet<BigRational>,
    called: BTreeSet<Name>,
}

impl Found {
    fn add(&mut self, term: &Term) {
        let mut open = vec![term];
        while let Some(term) = open.pop() {
            for value in term.values() {
                self.values.extend(value.variables());
                self.numbers.extend(value.numbers());
            }
            if let Node::Power(_, count, _) = term.node() {
                self.counts.extend(count.variables());
            }
            match term.node() {
                Node::In(port, name) => {
                    self.ports.insert(port.clone());
                    self.results.insert(name.clone());
                }
                Node::Out(port, _) | Node::New(port, _) => {
                    self.ports.insert(port.clone());
                }
                Node::Set(_, name) | Node::Replace(_, name, _) => {
                    self.results.insert(name.clone());
                }
                Node::Ran(distribution, name) => {
                    self.results.insert(name.clone());
                    let whole = distribution.variables();
                    self.distributions.extend(whole.into_iter().filter(|name| Value::variable(name) == *distribution));
                }
                Node::Guard(_, left, right) => {
                    self.compared.extend([left.clone(), right.clone()]);
                    self.numbers.extend(left.sub(right).map(|difference| difference.numbers()).unwrap_or_default());
                }
                Node::Meta(name, arguments) => {
                    self.processes.insert(name.clone(), arguments.len());
                }
                Node::Power(_, _, Some(index)) => {
                    self.indices.insert(index.clone());
                }
                Node::Call(name, _) => {
                    self.called.insert(name.clone());
                }
                _ => {}
            }
            open.extend(term.children());
        }
    }

    /// The symbols of the definitions that are called which are neither parameters nor bound there.
    fn add_definitions(&mut self, definitions: &Definitions) -> BTreeSet<Name> {
        let mut symbols = BTreeSet::new();
        let mut done = BTreeSet::new();
        let mut open: Vec<Name> = self.called.iter().cloned().collect();
        while let Some(name) = open.pop() {
            let Some(definition) = definitions.get(&name).filter(|_| done.insert(name.clone())) else { continue };
            let mut inner = Found::default();
            inner.add(&definition.body);
            let own: BTreeSet<Name> =
                inner.results.iter().chain(&definition.parameters).chain(&inner.indices).cloned().collect();
            symbols.extend(inner.values.difference(&own).cloned());
            self.compared.extend(inner.compared);
            self.numbers.extend(inner.numbers);
            open.extend(inner.called);
        }
        symbols
    }
}

/// What a condition speaks of: terms, values and names.
fn add_condition(found: &mut Found, condition: &Condition) {
    match condition {
        Condition::Compare(_, left, right) => {
            found.values.extend(left.variables().into_iter().chain(right.variables()));
            found.numbers.extend(left.numbers().into_iter().chain(right.numbers()));
        }
        Condition::Natural(value) => found.values.extend(value.variables()),
        Condition::Is(_, term) | Condition::ShowsOnly(term, _) | Condition::ShowsNone(term, _) => found.add(term),
        Condition::Lasts(term, time) => {
            found.add(term);
            found.values.extend(time.variables());
            found.numbers.extend(time.numbers());
        }
        Condition::Complementary(one, two) | Condition::Apart(one, two) => {
            found.add(one);
            found.add(two);
        }
        Condition::NoPort(term, port) => {
            found.add(term);
            found.ports.insert(port.clone());
        }
        Condition::Unread(term, name) => {
            found.add(term);
            found.results.insert(name.clone());
        }
    }
}

/// Every name in a condition.
pub(super) fn names_in(condition: &Condition) -> BTreeSet<Name> {
    let mut found = Found::default();
    add_condition(&mut found, condition);
    let mut names: BTreeSet<Name> = found.processes.into_keys().collect();
    names.extend(found.values);
    names.extend(found.ports);
    names.extend(found.results);
    names
}

/// All slots of a claim: names first, then values, then processes, so that conditions bite early.
pub(super) fn slots_of(left: &Term, right: &Term, conditions: &[Condition], definitions: &Definitions) -> Vec<Slot> {
    let mut found = Found::default();
    found.add(left);
    found.add(right);
    let mut symbols = found.add_definitions(definitions);
    // What is bound in the claim, or in a process that it calls, is no symbol of it: it is read from the surroundings.
    let bound: BTreeSet<Name> = [left, right].into_iter().flat_map(|side| written(side, definitions)).collect();
    let free = |name: &Name| name.is_meta() || !bound.contains(name);
    found.values.retain(free);
    symbols.retain(free);
    let mut in_conditions = Found::default();
    conditions.iter().for_each(|condition| add_condition(&mut in_conditions, condition));
    found.values.extend(in_conditions.values);
    found.ports.extend(in_conditions.ports);
    found.results.extend(in_conditions.results);
    found.processes.extend(in_conditions.processes);
    let meta = |names: &BTreeSet<Name>| names.iter().filter(|name| name.is_meta()).cloned().collect::<Vec<_>>();
    let mut slots: Vec<Slot> = meta(&found.ports).into_iter().map(Slot::Port).collect();
    slots.extend(meta(&found.results).into_iter().map(Slot::Result));
    slots.extend(found.distributions.iter().cloned().map(Slot::Distribution));
    for name in &found.values {
        if found.results.contains(name) || found.distributions.contains(name) || found.indices.contains(name) {
            continue;
        }
        slots.push(match name {
            name if !name.is_meta() => Slot::Parameter(name.clone()),
            name if found.counts.contains(name) => Slot::Count(name.clone()),
            name => Slot::Value(name.clone()),
        });
    }
    for name in symbols {
        let slot = Slot::Parameter(name);
        if !slots.contains(&slot) {
            slots.push(slot);
        }
    }
    slots.extend(found.processes.into_iter().map(|(name, arity)| Slot::Process(name, arity)));
    slots
}

/// With the parameters that assumptions tie to those of the claim: without a value for `b` nothing is known of `a < b`.
pub(super) fn with_assumed(mut slots: Vec<Slot>, assumptions: &Assumptions) -> Vec<Slot> {
    let together: Vec<BTreeSet<Name>> = assumptions.iter().map(|(_, value)| value.variables()).collect();
    let mut known: BTreeSet<Name> = slots.iter().map(|slot| slot.name().clone()).collect();
    let first = slots.iter().position(|slot| matches!(slot, Slot::Process(..))).unwrap_or(slots.len());
    loop {
        let tied = together.iter().filter(|names| !names.is_disjoint(&known)).flatten();
        let Some(name) = tied.into_iter().find(|name| !known.contains(*name)).cloned() else { return slots };
        known.insert(name.clone());
        slots.insert(first, Slot::Parameter(name));
    }
}

impl Vocabulary {
    /// With these numbers too.
    pub(super) fn also(&mut self, numbers: &[BigRational]) {
        let more: Vec<BigRational> =
            numbers.iter().filter(|one| !self.numbers.contains(one) && !usual().contains(one)).cloned().collect();
        self.numbers.extend(more);
    }

    /// The claim's own ports and results first, then `c`, `d` and `y`, `z`, two of each; and the inputs to try.
    pub(super) fn of(matter: &Matter<'_>) -> Vocabulary {
        let mut found = Found::default();
        matter.sides.into_iter().for_each(|side| found.add(side));
        let mut wide = Found { called: found.called.clone(), ..Found::default() };
        wide.add_definitions(matter.definitions);
        matter.conditions.iter().for_each(|condition| add_condition(&mut wide, condition));
        let names = &found.values;
        let about = matter.assumptions.iter().filter(|(_, value)| !value.variables().is_disjoint(names));
        let mut numbers = wide.numbers;
        numbers.extend(about.flat_map(|(_, value)| value.numbers()).chain(found.numbers.iter().cloned()));
        let unusual = |number: &BigRational| !usual().contains(number);
        let numbers = if numbers.iter().any(unusual) { around(&numbers) } else { Vec::new() };
        let numbers: Vec<BigRational> = numbers.into_iter().filter(unusual).collect();
        let two = |own: &BTreeSet<Name>, spare: [&str; 2]| {
            let mut names: Vec<Name> = own.iter().filter(|name| !name.is_meta()).take(2).cloned().collect();
            for name in spare.map(Name::new) {
                if names.len() < 2 && !names.contains(&name) {
                    names.push(name);
                }
            }
            names
        };
        let mut inputs = vec![Value::integer(0), Value::integer(1)];
        for value in found.compared {
            if inputs.len() < 4 && value.as_rational().is_some() && !inputs.contains(&value) {
                inputs.push(value);
            }
        }
        for number in numbers.iter().map(|number| Value::rational(number.clone())) {
            if inputs.len() < MOST_INPUTS && !inputs.contains(&number) {
                inputs.push(number);
            }
        }
        Vocabulary { ports: two(&found.ports, ["c", "d"]), results: two(&found.results, ["y", "z"]), inputs, numbers }
    }
}

/// The numbers that every claim is tried with, simplest first.
pub(super) fn usual() -> [BigRational; 6] {
    let number = |above: i64, below: i64| BigRational::new(above.into(), below.into());
    [number(0, 1), number(1, 1), number(2, 1), number(-1, 1), number(1, 2), number(3, 1)]
}
