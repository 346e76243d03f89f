//! How a process can end and what it has bound by then, as far as its form tells.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::exclusive::is_guard;
use super::process::guard;
use super::scope::{Lowerer, Metas};
use super::{Entity, Quantity};
use crate::ast::{Either, Ident, Term, TermKind, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::Value;

/// How a process can end. Every part errs to the side of "it may".
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Flow {
    /// The names that are bound whenever it stops; none when it never stops.
    pub stop: Option<BTreeSet<Name>>,
    /// Whether it may abort.
    pub aborts: bool,
    /// Whether it may abort otherwise than by the guards that it begins with, where it is a sequence.
    pub aborts_later: bool,
    /// Every name that it may bind.
    pub binds: BTreeSet<Name>,
    /// Whether it may stop having neither waited nor communicated.
    pub quick_stop: bool,
    /// Whether it may abort having neither waited nor communicated.
    pub quick_abort: bool,
    /// The processes it may call having neither waited nor communicated.
    pub reaches: BTreeSet<Name>,
}

impl Flow {
    fn stops() -> Flow {
        Flow { stop: Some(BTreeSet::new()), ..Flow::default() }
    }

    fn at_once(mut self) -> Flow {
        self.quick_stop = true;
        self
    }

    fn binding(name: &Name) -> Flow {
        let names = BTreeSet::from([name.clone()]);
        Flow { stop: Some(names.clone()), binds: names, ..Flow::default() }
    }

    fn ends(&self) -> bool {
        self.stop.is_some() || self.aborts
    }

    fn quick_end(&self) -> bool {
        self.quick_stop || self.quick_abort
    }

    /// That of a call of a process with this body: a loop stops when its body aborts.
    pub(super) fn called(mut self, recursive: bool) -> Flow {
        if recursive {
            if self.aborts {
                self.stop = Some(BTreeSet::new());
            }
            self.quick_stop |= self.quick_abort;
            (self.aborts, self.quick_abort) = (false, false);
        }
        self.reaches.clear();
        self
    }
}

/// How processes can end, by their names; only ever looked up.
pub(super) type Flows = HashMap<Name, Flow>;

/// What is bound at a place.
#[derive(Clone, Default)]
pub(super) struct Bound {
    /// Control never gets here, so anything may be read.
    nowhere: bool,
    names: BTreeSet<Name>,
}

/// Walks over a process as written.
pub(super) struct Walk<'w, 'e> {
    pub(super) lowerer: &'w mut Lowerer<'e>,
    /// The flows of the processes that are being defined.
    pub(super) flows: &'w Flows,
    /// Whether errors are reported, and reads checked.
    pub(super) report: bool,
}

impl Walk<'_, '_> {
    /// The flow of a process, with this bound before it.
    pub(super) fn flow(&mut self, term: &Term, bound: &Bound) -> Flow {
        match &term.kind {
            TermKind::Apply { name, arguments, results } => {
                let ports = usize::from(matches!(name.name.as_str(), "In" | "Out"));
                arguments.iter().skip(ports).for_each(|argument| self.reads(argument, bound));
                self.application(name, arguments, results)
            }
            TermKind::Meta(_, arguments) => {
                arguments.iter().for_each(|argument| self.reads(argument, bound));
                Flow { aborts: true, ..Flow::stops() }
            }
            TermKind::Seq(parts) => self.sequence(parts, bound),
            TermKind::Else(first, second) => {
                let first = self.flow(first, bound);
                let second = self.flow(second, bound);
                alternative(first, second)
            }
            TermKind::Try(body) => alternative(self.flow(body, bound), Flow::stops().at_once()),
            TermKind::Par(parts) => self.parallel(parts, bound),
            TermKind::Disable(parts) => self.disabling(parts, bound),
            TermKind::Power(body, count, index) => {
                self.reads(count, bound);
                let mut inner = bound.clone();
                inner.names.extend(index.iter().map(|index| index.name.clone()));
                self.power(body, count, &inner)
            }
            TermKind::Loop(body) => self.looping(body, bound, term.span),
            TermKind::New(_, body) | TermKind::Project(body, _) => self.flow(body, bound),
            TermKind::Replace(body, name, value) => {
                self.reads(value, bound);
                let mut inner = bound.clone();
                inner.names.insert(self.lowerer.result_name(&name.name).clone());
                self.flow(body, &inner)
            }
        }
    }

    fn sequence(&mut self, parts: &[Term], bound: &Bound) -> Flow {
        let mut bound = bound.clone();
        let mut whole = Flow::stops().at_once();
        let mut guards = true;
        for part in parts {
            let next = self.flow(part, &bound);
            if let Some(names) = &next.stop {
                bound.names.extend(names.iter().cloned());
            } else {
                bound.nowhere = true;
            }
            let reached = whole.stop.is_some();
            whole.aborts |= reached && next.aborts;
            guards &= is_guard(part);
            whole.aborts_later |= !guards && next.aborts;
            if whole.quick_stop {
                whole.quick_abort |= next.quick_abort;
                whole.reaches.extend(next.reaches);
            }
            whole.quick_stop &= next.quick_stop;
            whole.stop = match (whole.stop, next.stop) {
                (Some(mut before), Some(names)) => {
                    before.extend(names);
                    Some(before)
                }
                _ => None,
            };
            whole.binds.extend(next.binds);
        }
        whole
    }

    fn parallel(&mut self, parts: &[Term], bound: &Bound) -> Flow {
        let flows: Vec<Flow> = parts.iter().map(|part| self.flow(part, bound)).collect();
        self.once_bound(parts, &flows, "|");
        let ends = flows.iter().all(Flow::ends);
        let certain = flows.iter().filter(|flow| !flow.aborts).filter_map(|flow| flow.stop.clone());
        let certain = certain.reduce(|left, right| left.union(&right).cloned().collect());
        let stop = certain.or_else(|| common(flows.iter().filter_map(|flow| flow.stop.as_ref())));
        let quick = flows.iter().all(Flow::quick_end);
        let aborts = flows.iter().all(|flow| flow.aborts) && !self.one_stops(parts, &flows);
        let mut whole = Flow {
            stop: stop.filter(|_| ends),
            aborts,
            quick_stop: quick && flows.iter().any(|flow| flow.quick_stop),
            quick_abort: aborts && flows.iter().all(|flow| flow.quick_abort),
            ..Flow::default()
        };
        gather(&mut whole, flows);
        whole
    }

    fn disabling(&mut self, parts: &[Term], bound: &Bound) -> Flow {
        let flows: Vec<Flow> = parts.iter().map(|part| self.flow(part, bound)).collect();
        self.once_bound(parts, &flows, "#");
        let mut whole = Flow {
            stop: common(flows.iter().filter_map(|flow| flow.stop.as_ref())),
            aborts: flows.iter().any(|flow| flow.aborts),
            quick_stop: flows.iter().any(|flow| flow.quick_stop),
            quick_abort: flows.iter().any(|flow| flow.quick_abort),
            ..Flow::default()
        };
        gather(&mut whole, flows);
        whole
    }

    fn power(&mut self, body: &Term, count: &Written, bound: &Bound) -> Flow {
        let flow = self.flow(body, bound);
        match self.quiet(count).and_then(|value| value.as_rational()) {
            Some(count) if count > num_rational::BigRational::from_integer(0.into()) => flow,
            Some(_) => Flow::stops().at_once(),
            // The number of rounds may turn out to be 0.
            None => Flow { stop: Some(BTreeSet::new()), ..flow },
        }
    }

    fn looping(&mut self, body: &Term, bound: &Bound, span: Span) -> Flow {
        let flow = self.flow(body, bound);
        if flow.quick_stop && self.report {
            self.lowerer.report(
                Diagnostic::error("P0602", "this loop can go round without waiting or communicating")
                    .label(span, "goes round in no time")
                    .note("a loop that takes no time never lets anything else happen")
                    .help("put a `Delay_t`, an `In` or an `Out` into its body"),
            );
        }
        let stop = if flow.aborts { Some(BTreeSet::new()) } else { None };
        Flow { stop, quick_stop: flow.quick_abort, binds: flow.binds, reaches: flow.reaches, ..Flow::default() }
    }

    fn application(&mut self, name: &Ident, arguments: &[Written], results: &[Ident]) -> Flow {
        match name.name.as_str() {
            "Stop" => Flow::stops().at_once(),
            "Abort" => Flow { aborts: true, quick_abort: true, ..Flow::default() },
            "Idle" => Flow::default(),
            "Delay" => {
                let zero = arguments.first().and_then(|time| self.quiet(time)) == Some(Value::integer(0));
                if zero { Flow::stops().at_once() } else { Flow::stops() }
            }
            "Out" => Flow::stops(),
            "In" => self.binding(results),
            "Set" | "Ran" => self.binding(results).at_once(),
            text if guard(text).is_some() => Flow { aborts: true, quick_abort: true, ..Flow::stops().at_once() },
            _ => self.call(name, results),
        }
    }

    fn binding(&self, results: &[Ident]) -> Flow {
        results.first().map_or(Flow::stops(), |result| Flow::binding(self.lowerer.result_name(&result.name)))
    }

    fn call(&mut self, name: &Ident, results: &[Ident]) -> Flow {
        let mut flow = match (self.flows.get(&name.name), self.lowerer.environment.entity(&name.name)) {
            (Some(flow), _) => flow.clone(),
            (None, Some(Entity::Process(signature))) => signature.flow.clone(),
            (None, Some(Entity::System(_))) => Flow::stops(),
            _ => Flow::default(),
        };
        if self.report && !self.lowerer.settled {
            self.lowerer.check_passed(name, results, &flow);
        }
        flow.reaches.insert(name.name.clone());
        flow
    }

    /// Reports a name that two parts may bind at the same time.
    fn once_bound(&mut self, parts: &[Term], flows: &[Flow], operator: &str) {
        if !self.report {
            return;
        }
        let mut binders: BTreeMap<&Name, Vec<usize>> = BTreeMap::new();
        for (index, flow) in flows.iter().enumerate().filter(|(_, flow)| flow.stop.is_some()) {
            for name in &flow.binds {
                let others = binders.entry(name).or_default();
                let clash = others.iter().copied().find(|other| !self.exclusive(parts.get(*other), parts.get(index)));
                if let (Some(first), Some(second)) = (clash.and_then(|other| parts.get(other)), parts.get(index)) {
                    self.lowerer.report(
                        Diagnostic::error("P0505", format!("`{name}` is bound on both sides of `{operator}`"))
                            .label(second.span, "bound in this part")
                            .label(first.span, "and in this part")
                            .note("if both parts stop, it would not be clear which value counts")
                            .help("give the results different names, or begin the parts with guards that exclude each other, such as `Eq_{x,y}` and `Neq_{x,y}`, or `Lss_{x,6}`, `Gte_{x,6} ; Lss_{x,9}` and `Gte_{x,9}`"),
                    );
                    return;
                }
                others.push(index);
            }
        }
    }

    /// Reports what a value reads that is not bound whenever control gets there.
    fn reads(&mut self, value: &Written, bound: &Bound) {
        if !self.report || bound.nowhere {
            return;
        }
        let mut idents = Vec::new();
        names(value, &mut idents);
        for ident in idents {
            self.one_meaning(ident, bound);
            if self.lowerer.metas == Metas::Law {
                continue;
            }
            let name = &self.lowerer.result_name(&ident.name).clone();
            let known = name.is_meta() || self.lowerer.locals.contains_key(name) || bound.names.contains(name);
            if known || !self.lowerer.results.contains_key(name) {
                continue;
            }
            if matches!(self.lowerer.environment.quantity(name), Some(Quantity::Parameter { .. })) {
                continue;
            }
            let place = self.lowerer.results.get(name).copied().unwrap_or(ident.span);
            let text = &ident.name;
            let diagnostic = Diagnostic::error("P0502", format!("`{text}` is not bound whenever control gets here"))
                .label(ident.span, "read here")
                .label(place, "bound here, but not always, or not before")
                .note("after `P | Q`, a name is bound only if every way in which it can stop binds it; after `P # Q`, only if every part that can stop binds it")
                .help(format!("bind it before: `Set_x<{text}>` or `In_c<{text}>`"));
            self.lowerer.report(if name == text {
                diagnostic
            } else {
                diagnostic.note(format!(
                    "`{text}` is a result here, so everywhere in this item it is not the `{text}` of the whole text"
                ))
            });
        }
    }

    /// Reports a name that could be the value of the whole text as well as a result of a process called before.
    fn one_meaning(&mut self, ident: &Ident, bound: &Bound) {
        let name = &ident.name;
        let Some(apart) = self.lowerer.environment.apart(name).filter(|apart| bound.names.contains(apart)) else {
            return;
        };
        if self.lowerer.apart.contains_key(name) || self.lowerer.locals.contains_key(name) {
            return;
        }
        let place = self.lowerer.results.get(&apart).copied().unwrap_or(ident.span);
        self.lowerer.report(
            Diagnostic::error(
                "P0503",
                format!("`{name}` is declared for the whole text, and a result of this name was bound before"),
            )
            .label(ident.span, "which of the two?")
            .label(place, format!("binds a result `{name}`, kept as `{apart}`"))
            .help(format!(
                "to read the result write `{apart}`; to read the declared value give the result another name"
            )),
        );
    }
}

/// The flow of `P else Q`.
fn alternative(first: Flow, second: Flow) -> Flow {
    let stop = match (first.stop, second.stop) {
        (Some(one), Some(other)) if first.aborts => Some(one.intersection(&other).cloned().collect()),
        (None, other) if first.aborts => other,
        (one, _) => one,
    };
    let mut whole = Flow {
        stop,
        aborts: first.aborts && second.aborts,
        binds: first.binds,
        quick_stop: first.quick_stop || (first.quick_abort && second.quick_stop),
        quick_abort: first.quick_abort && second.quick_abort,
        reaches: first.reaches,
        ..Flow::default()
    };
    whole.binds.extend(second.binds);
    if first.quick_abort {
        whole.reaches.extend(second.reaches);
    }
    whole
}

/// The names that all of them have; none when there is none of them.
fn common<'s>(sets: impl Iterator<Item = &'s BTreeSet<Name>>) -> Option<BTreeSet<Name>> {
    sets.fold(None, |whole, set| match whole {
        None => Some(set.clone()),
        Some(whole) => Some(whole.intersection(set).cloned().collect()),
    })
}

fn gather(whole: &mut Flow, parts: Vec<Flow>) {
    for part in parts {
        whole.binds.extend(part.binds);
        whole.reaches.extend(part.reaches);
    }
}

/// The names that a value mentions, where they stand.
pub(super) fn names<'v>(value: &'v Written, into: &mut Vec<&'v Ident>) {
    match &value.kind {
        ValueKind::Number(_) => {}
        ValueKind::Name(name) => into.push(name),
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().for_each(|(_, part)| names(part, into)),
        ValueKind::Power(base, exponent) => {
            names(base, into);
            names(exponent, into);
        }
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => names(inner, into),
        ValueKind::If(_, parts) => parts.iter().for_each(|part| names(part, into)),
        ValueKind::Vector(parts) => parts.iter().for_each(|part| names(part, into)),
        ValueKind::Call(_, arguments) => arguments.iter().for_each(|argument| names(&argument.value, into)),
        ValueKind::Iterate(chain, arguments) => {
            chain.iter().filter_map(|(_, count)| count.as_ref()).for_each(|count| names(count, into));
            arguments.iter().for_each(|argument| names(&argument.value, into));
        }
        ValueKind::Cases(cases) => {
            for (value, condition) in cases {
                names(value, into);
                condition
                    .iter()
                    .flat_map(Either::comparisons)
                    .flat_map(|one| [&one.left, &one.right])
                    .for_each(|side| names(side, into));
            }
        }
    }
}

/// The names of the functions that a value calls, where they stand.
pub(super) fn functions<'v>(value: &'v Written, into: &mut Vec<&'v Ident>) {
    match &value.kind {
        ValueKind::Number(_) | ValueKind::Name(_) => {}
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().for_each(|(_, part)| functions(part, into)),
        ValueKind::Power(base, exponent) => {
            functions(base, into);
            functions(exponent, into);
        }
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => functions(inner, into),
        ValueKind::If(_, parts) => parts.iter().for_each(|part| functions(part, into)),
        ValueKind::Vector(parts) => parts.iter().for_each(|part| functions(part, into)),
        ValueKind::Call(name, arguments) => {
            into.push(name);
            arguments.iter().for_each(|argument| functions(&argument.value, into));
        }
        ValueKind::Iterate(chain, arguments) => {
            for (name, count) in chain {
                into.push(name);
                match count.as_ref().map(|count| (&count.kind, count)) {
                    // In `x^g(y)` it is g that is called.
                    Some((ValueKind::Name(called), _)) => into.push(called),
                    Some((_, count)) => functions(count, into),
                    None => {}
                }
            }
            arguments.iter().for_each(|argument| functions(&argument.value, into));
        }
        ValueKind::Cases(cases) => {
            for (value, condition) in cases {
                functions(value, into);
                condition
                    .iter()
                    .flat_map(Either::comparisons)
                    .flat_map(|one| [&one.left, &one.right])
                    .for_each(|side| functions(side, into));
            }
        }
    }
}
