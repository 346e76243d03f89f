//! The processes of one text, defined together.

mod quick;

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use super::declare::Opening;
use super::flow::Flows;
use super::graph::{callees, callees_first, cycles};
use super::process::cannot_be_used;
use super::scope::{Lowerer, Metas};
use super::shape::Shapes;
use super::{Class, Entity, Environment, Flow, Signature};
use crate::ast::{Header, Item, ItemKind, Term as Written, TermKind};
use crate::definition::Definition;
use crate::diagnostic::Diagnostic;
use crate::name::Name;
use crate::term::Term;
use quick::Quick;

/// A process that binds more names than this, itself and by what it calls, is refused.
const MOST_RESULTS: usize = 200;

/// A definition on its way.
struct Draft<'i, 'e> {
    index: usize,
    header: &'i Header,
    written: &'i Written,
    lowerer: Lowerer<'e>,
    /// What the parameters are called in the body.
    parameters: Vec<Name>,
    body: Option<Term>,
    flow: Flow,
}

impl Environment {
    /// Defines the processes of a text.
    pub(super) fn define_processes(&mut self, opening: &mut Opening<'_>, items: &[Item]) {
        let found: Vec<_> = items
            .iter()
            .enumerate()
            .filter_map(|(index, item)| match &item.kind {
                ItemKind::Process(header, body) if !opening.is_twice(index) => Some((index, header, body)),
                _ => None,
            })
            .collect();
        if found.is_empty() {
            return;
        }
        self.announce_bindings(&found);
        let seen = self.clone();
        let shapes = Shapes::find(items, &seen);
        let until = || opening.stops();
        let mut drafts: Vec<Draft> = Vec::with_capacity(found.len());
        for (index, header, written) in found {
            if until() {
                return;
            }
            drafts.push(draft(&seen, index, (header, written), &shapes));
        }
        let loops = self.enter(&drafts);
        settle_flows(&mut drafts, &loops, &until);
        check(&mut drafts, &loops, &|| seen.supposing(items, &until), &until);
        check_calls(&mut drafts, &seen);
        check_lengths(&mut drafts, &shapes);
        refuse_callers(&mut drafts, opening);
        if until() {
            return;
        }
        for draft in drafts {
            let name = &draft.header.name.name;
            let classes = draft
                .header
                .parameters
                .iter()
                .map(|parameter| draft.lowerer.classes.get(&parameter.name).map(|(class, _)| *class));
            let parameters = draft.header.parameters.iter().map(|parameter| parameter.name.clone()).collect();
            let lengths = shapes.lengths(name, &draft.header.parameters);
            let signature = Signature { parameters, classes: classes.collect(), lengths, flow: draft.flow };
            let fine = draft.lowerer.errors.is_empty();
            self.put(name, Entity::Process(signature));
            opening.report(draft.index, draft.lowerer.errors);
            if !fine {
                self.withdraw(opening, name);
            }
        }
    }

    /// Enters for each process the names it may bind, itself or by what it calls.
    fn announce_bindings(&mut self, found: &[(usize, &Header, &Written)]) {
        let mut binds: HashMap<Name, BTreeSet<Name>> = HashMap::new();
        let mut callers: HashMap<Name, Vec<Name>> = HashMap::new();
        let mut edges: BTreeMap<Name, BTreeSet<Name>> = BTreeMap::new();
        for (_, header, written) in found {
            let name = &header.name.name;
            let (own, called) = direct(written);
            let mut own: BTreeSet<Name> = own.into_iter().map(|bound| self.apart(&bound).unwrap_or(bound)).collect();
            for callee in &called {
                if let Some(Entity::Process(signature)) = self.entity(callee) {
                    own.extend(signature.flow.binds.iter().cloned());
                }
                callers.entry(callee.clone()).or_default().push(name.clone());
            }
            binds.insert(name.clone(), own);
            edges.insert(name.clone(), called);
        }
        let mut waiting: VecDeque<Name> = callees_first(&edges).into();
        while let Some(name) = waiting.pop_front() {
            let Some(names) = binds.get(&name).cloned() else { continue };
            for caller in callers.get(&name).into_iter().flatten() {
                let Some(into) = binds.get_mut(caller) else { continue };
                let before = into.len();
                if before <= MOST_RESULTS {
                    into.extend(names.iter().cloned());
                }
                if into.len() > before {
                    waiting.push_back(caller.clone());
                }
            }
        }
        for (name, binds) in binds {
            if let Some(Entity::Process(signature)) = self.entity(&name) {
                let signature = Signature { flow: Flow { binds, ..Flow::default() }, ..signature.clone() };
                self.put(&name, Entity::Process(signature));
            }
        }
    }

    /// Enters the definitions, and says which stand on a loop, with a number for each loop.
    fn enter(&mut self, drafts: &[Draft]) -> BTreeMap<Name, usize> {
        for draft in drafts {
            if let Some(body) = &draft.body {
                let (parameters, name) = (draft.parameters.clone(), draft.header.name.name.clone());
                self.definitions.insert(Definition { name, parameters, body: body.clone(), recursive: false });
            }
        }
        let edges =
            self.definitions.iter().map(|definition| (definition.name.clone(), callees(&definition.body))).collect();
        let loops = cycles(&edges);
        let wrong: Vec<Definition> = self
            .definitions
            .iter()
            .filter(|definition| definition.recursive != loops.contains_key(&definition.name))
            .map(|definition| Definition { recursive: !definition.recursive, ..definition.clone() })
            .collect();
        for definition in wrong {
            self.definitions.insert(definition);
        }
        loops
    }

    /// The same with all that the text says of parameters, wherever it stands.
    fn supposing(&self, items: &[Item], interrupted: &dyn Fn() -> bool) -> Environment {
        let mut all = self.clone();
        for item in items {
            if let ItemKind::Param(parameters) = &item.kind {
                // What is wrong with it is reported in its turn.
                let _ = all.assume_all(parameters, interrupted);
            }
        }
        all
    }

    /// Takes back a definition that has errors; what the name stood for before the text holds again.
    fn withdraw(&mut self, opening: &Opening<'_>, name: &Name) {
        match opening.before.definitions.get(name) {
            Some(before) => self.definitions.insert(before.clone()),
            None => self.definitions.remove(name),
        }
        self.restore(opening, name);
    }
}

/// Refuses what calls a process that has errors and was not defined before, itself or through others: with a part missing
/// it would be another process than was meant.
fn refuse_callers(drafts: &mut [Draft], opening: &Opening<'_>) {
    let gone = |draft: &Draft| {
        let name = &draft.header.name.name;
        (!draft.lowerer.errors.is_empty() && opening.before.definitions.get(name).is_none()).then(|| name.clone())
    };
    let mut waiting: Vec<Name> = drafts.iter().filter_map(gone).collect();
    if waiting.is_empty() {
        return;
    }
    let mut callers: HashMap<Name, Vec<usize>> = HashMap::new();
    for (position, draft) in drafts.iter().enumerate() {
        for callee in direct(draft.written).1 {
            callers.entry(callee).or_default().push(position);
        }
    }
    while let Some(name) = waiting.pop() {
        for position in callers.remove(&name).unwrap_or_default() {
            let Some(draft) = drafts.get_mut(position).filter(|draft| draft.lowerer.errors.is_empty()) else {
                continue;
            };
            draft.lowerer.report(cannot_be_used(&name, draft.header.name.span));
            waiting.extend(gone(draft));
        }
    }
}

fn draft<'i, 'e>(
    environment: &'e Environment,
    index: usize,
    (header, written): (&'i Header, &'i Written),
    shapes: &Shapes,
) -> Draft<'i, 'e> {
    let mut lowerer = Lowerer::new(environment, Metas::Forbidden);
    lowerer.shapes = shapes.of(&header.name.name);
    lowerer.settled = false;
    lowerer.parameters(&header.parameters);
    let parameters: Vec<Name> = header.parameters.iter().map(|parameter| parameter.name.clone()).collect();
    let bound = match environment.entity(&header.name.name) {
        Some(Entity::Process(signature)) => signature.flow.binds.len(),
        _ => 0,
    };
    if bound > MOST_RESULTS {
        let text = format!("`{}` binds more than {MOST_RESULTS} names, itself and by what it calls", header.name.name);
        lowerer.report(Diagnostic::error("P0508", text).label(header.name.span, "this process"));
        return Draft { index, header, written, lowerer, parameters, body: None, flow: Flow::default() };
    }
    lowerer.bind(&[written]);
    lowerer.check_passed_on(&header.results);
    let (parameters, body) = match lowerer.process(written) {
        Some(body) => {
            let (parameters, body) = lowerer.kept_apart(parameters, body);
            (parameters, Some(body))
        }
        None => (parameters, None),
    };
    Draft { index, header, written, lowerer, parameters, body, flow: Flow::default() }
}

/// Finds how each process can end: the least solution, so that what never ends is known to.
fn settle_flows(drafts: &mut [Draft], loops: &BTreeMap<Name, usize>, interrupted: &dyn Fn() -> bool) {
    let mut flows: Flows = Flows::new();
    let mut callers: HashMap<Name, Vec<usize>> = HashMap::new();
    let mut edges: BTreeMap<Name, BTreeSet<Name>> = BTreeMap::new();
    let mut places: HashMap<Name, usize> = HashMap::new();
    for (position, draft) in drafts.iter().enumerate().filter(|(_, draft)| draft.body.is_some()) {
        let called = direct(draft.written).1;
        for callee in &called {
            callers.entry(callee.clone()).or_default().push(position);
        }
        flows.insert(draft.header.name.name.clone(), Flow::default());
        places.insert(draft.header.name.name.clone(), position);
        edges.insert(draft.header.name.name.clone(), called);
    }
    let mut waiting: VecDeque<usize> =
        callees_first(&edges).iter().filter_map(|name| places.get(name).copied()).collect();
    let mut queued: BTreeSet<usize> = waiting.iter().copied().collect();
    while let Some(position) = waiting.pop_front().filter(|_| !interrupted()) {
        queued.remove(&position);
        let Some(draft) = drafts.get_mut(position) else {
            continue;
        };
        let name = &draft.header.name.name;
        draft.flow = draft.lowerer.quiet_flow(draft.written, &flows);
        let called = draft.flow.clone().called(loops.contains_key(name));
        if flows.get(name) != Some(&called) {
            flows.insert(name.clone(), called);
            let again = callers.get(name).into_iter().flatten().filter(|caller| queued.insert(**caller));
            waiting.extend(again.copied().collect::<Vec<_>>());
        }
    }
}

/// Reports loops that take no time, calls that are not last, and names that are read before they are bound.
fn check(
    drafts: &mut [Draft],
    loops: &BTreeMap<Name, usize>,
    supposing: &dyn Fn() -> Environment,
    interrupted: &dyn Fn() -> bool,
) {
    let flows: Flows = drafts
        .iter()
        .map(|draft| {
            (draft.header.name.name.clone(), draft.flow.clone().called(loops.contains_key(&draft.header.name.name)))
        })
        .collect();
    let quick = in_no_time(drafts, &flows, supposing);
    for draft in drafts.iter_mut() {
        if interrupted() {
            return;
        }
        let name = &draft.header.name.name;
        let own = loops.get(name);
        let on_loop = |called: &Name| own.is_some() && loops.get(called) == own;
        draft.lowerer.check_tails(draft.written, &on_loop);
        if quick.contains(name) {
            draft.lowerer.report(
                Diagnostic::error("P0603", format!("`{name}` can go round without waiting or communicating"))
                    .label(draft.header.name.span, "calls itself again in no time")
                    .note("a loop that takes no time never lets anything else happen")
                    .help("put a `Delay_t`, an `In` or an `Out` before the call, or guards that cannot all pass in one round"),
            );
        }
        // A wrong name would only be reported a second time.
        if draft.lowerer.errors.is_empty() {
            let flow = draft.lowerer.check_flow(draft.written, Some(&flows));
            draft.lowerer.check_results(&draft.header.results, &flow);
        }
        draft.flow = draft.flow.clone().called(own.is_some());
    }
}

/// The processes that may call themselves again and again in no time.
fn in_no_time(drafts: &[Draft], flows: &Flows, supposing: &dyn Fn() -> Environment) -> BTreeSet<Name> {
    let edges: BTreeMap<Name, BTreeSet<Name>> =
        drafts.iter().map(|draft| (draft.header.name.name.clone(), draft.flow.reaches.clone())).collect();
    let round = cycles(&edges);
    if round.is_empty() {
        return BTreeSet::new();
    }
    let seen = supposing();
    let on_round = drafts.iter().filter(|draft| round.contains_key(&draft.header.name.name));
    let bodies =
        on_round.filter_map(|draft| Some((&draft.header.name.name, (draft.parameters.clone(), draft.body.as_ref()?))));
    let all = drafts
        .iter()
        .filter_map(|draft| Some((&draft.header.name.name, (draft.parameters.as_slice(), draft.body.as_ref()?))));
    let results = flows.values().flat_map(|flow| &flow.binds).collect();
    let quick =
        Quick { bodies: bodies.collect(), all: all.collect(), flows, seen: &seen, results, looks: Cell::default() };
    round.keys().filter(|name| !quick.ends(name)).cloned().collect()
}

/// Reports arguments that are numbers where the process needs a distribution, and the other way round.
fn check_calls(drafts: &mut [Draft], seen: &Environment) {
    let mut needs: HashMap<(Name, usize), Class> = HashMap::new();
    for draft in drafts.iter() {
        for (index, parameter) in draft.header.parameters.iter().enumerate() {
            if let Some((class, _)) = draft.lowerer.classes.get(&parameter.name) {
                needs.insert((draft.header.name.name.clone(), index), *class);
            }
        }
    }
    for draft in drafts.iter_mut() {
        let wrong = draft.lowerer.calls.iter().filter(|(callee, index, class, _)| {
            let known = match seen.entity(callee) {
                Some(Entity::Process(signature)) => signature.classes.get(*index).copied().flatten(),
                _ => None,
            };
            needs.get(&(callee.clone(), *index)).copied().or(known).is_some_and(|need| need != *class)
        });
        for (callee, index, class, span) in wrong.cloned().collect::<Vec<_>>() {
            draft.lowerer.wrong_class(&callee, index, class, span);
        }
    }
}

/// Reports arguments that are numbers where the process needs a vector, and the other way round.
fn check_lengths(drafts: &mut [Draft], shapes: &Shapes) {
    let own: BTreeMap<Name, Vec<Option<usize>>> = drafts
        .iter()
        .map(|draft| {
            (draft.header.name.name.clone(), shapes.lengths(&draft.header.name.name, &draft.header.parameters))
        })
        .collect();
    for draft in drafts.iter_mut() {
        for (callee, index, sort, span) in std::mem::take(&mut draft.lowerer.given) {
            let needed = own.get(&callee).and_then(|lengths| lengths.get(index).copied().flatten());
            draft.lowerer.of_length(&callee, index, needed, (sort, span));
        }
    }
}

/// The names that a process binds itself, and those it calls.
fn direct(written: &Written) -> (BTreeSet<Name>, BTreeSet<Name>) {
    let (mut binds, mut calls) = (BTreeSet::new(), BTreeSet::new());
    for term in written.all() {
        if let TermKind::Apply { name, results, .. } = &term.kind {
            binds.extend(results.iter().map(|result| result.name.clone()));
            calls.insert(name.name.clone());
        }
    }
    (binds, calls)
}
