//! Which names are vectors, and of how many components: found from the vectors that are written, through ports,
//! parameters, results and comparisons. A name that is a vector is its components `part(r, 1)`, `part(r, 2)`, ….

use std::collections::{BTreeMap, BTreeSet};

use super::scope::Lowerer;
use super::{Entity, Environment, Quantity, Template};
use crate::ast::{Header, Ident, Item, ItemKind, Term, TermKind, Value as Written, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Relation, Sort, Value};

/// Rounds until all is known; each carries what is known over one more port, call or sum.
const MOST_ROUNDS: usize = 60;
/// Functions inside functions that are looked through.
const MOST_DEPTH: usize = 12;
/// Values that are looked at, those in functions each time.
const MOST_LOOKS: usize = 4_000_000;

/// The vectors of a text: for a process (or none, for a system) and a name in it, how many components it has.
#[derive(Default)]
pub(super) struct Shapes {
    locals: BTreeMap<(Option<Name>, Name), usize>,
    /// By the systems that use the port: two systems may use one name for different things.
    ports: BTreeMap<(usize, Name), usize>,
    /// The parameters of the whole text that must be vectors, of those that may be.
    globals: BTreeMap<Name, usize>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    Unknown,
    Number,
    Vector(usize),
}

impl Shapes {
    /// The vectors among the names of a process.
    pub(super) fn of(&self, process: &Name) -> BTreeMap<Name, usize> {
        let first = (Some(process.clone()), Name::new(""));
        let own = self.locals.range(first..).take_while(|((scope, _), _)| scope.as_ref() == Some(process));
        own.map(|((_, name), length)| (name.clone(), *length)).collect()
    }

    /// How many components the parameters of a process have that are vectors.
    pub(super) fn lengths(&self, process: &Name, parameters: &[Ident]) -> Vec<Option<usize>> {
        let length = |parameter: &Ident| self.locals.get(&(Some(process.clone()), parameter.name.clone())).copied();
        parameters.iter().map(length).collect()
    }

    /// Finds the vectors of a text.
    pub(super) fn find(items: &[Item], environment: &Environment) -> Shapes {
        Shapes::search(items, environment, BTreeSet::new())
    }

    /// Finds which of these parameters of the whole text are vectors.
    pub(super) fn globals(items: &[Item], environment: &Environment, open: BTreeSet<Name>) -> BTreeMap<Name, usize> {
        Shapes::search(items, environment, open).globals
    }

    fn search(items: &[Item], environment: &Environment, open: BTreeSet<Name>) -> Shapes {
        let mut processes: Vec<(Option<&Header>, &Term)> = Vec::new();
        for item in items {
            match &item.kind {
                ItemKind::Process(header, body) => processes.push((Some(header), body)),
                ItemKind::System(_, body) => processes.push((None, body)),
                _ => {}
            }
        }
        let groups = groups(&processes);
        let mut search = Search { environment, open, headers: BTreeMap::new(), found: Shapes::default(), looks: 0 };
        search.headers = processes
            .iter()
            .filter_map(|(header, _)| header.map(|header| (header.name.name.clone(), header)))
            .collect();
        for _ in 0..MOST_ROUNDS {
            let known = |found: &Shapes| (found.locals.len(), found.ports.len(), found.globals.len());
            let before = known(&search.found);
            for ((header, body), group) in processes.iter().zip(&groups) {
                search.process(header.map(|header| header.name.name.clone()), *group, body);
            }
            if before == known(&search.found) {
                break;
            }
        }
        search.found
    }
}

/// For each process and system a number that it shares with those that it calls, or is called by; 0 for processes that no
/// system uses.
fn groups(processes: &[(Option<&Header>, &Term)]) -> Vec<usize> {
    let mut groups: Vec<usize> = (1..=processes.len()).collect();
    let own: BTreeMap<&Name, usize> = processes
        .iter()
        .enumerate()
        .filter_map(|(place, (header, _))| header.map(|header| (&header.name.name, place)))
        .collect();
    for (place, (_, body)) in processes.iter().enumerate() {
        let called = body.all().into_iter().filter_map(|term| match &term.kind {
            TermKind::Apply { name, .. } => own.get(&name.name).copied(),
            _ => None,
        });
        for other in called {
            let (one, two) = (groups[place], groups[other]);
            groups.iter_mut().filter(|group| **group == two).for_each(|group| *group = one);
        }
    }
    let systems = processes.iter().zip(&groups).filter(|((header, _), _)| header.is_none());
    let used: Vec<usize> = systems.map(|(_, group)| *group).collect();
    groups.into_iter().map(|group| if used.contains(&group) { group } else { 0 }).collect()
}

struct Search<'a> {
    environment: &'a Environment,
    /// Parameters of the whole text that may be vectors.
    open: BTreeSet<Name>,
    headers: BTreeMap<Name, &'a Header>,
    found: Shapes,
    /// Values that were looked at.
    looks: usize,
}

/// The process whose names these are, or a function's parameters with what they are.
struct Place {
    process: Option<Name>,
    /// The systems it is used in.
    group: usize,
    parameters: Option<BTreeMap<Name, Shape>>,
    depth: usize,
}

impl Search<'_> {
    fn process(&mut self, process: Option<Name>, group: usize, body: &Term) {
        let place = Place { process, group, parameters: None, depth: 0 };
        for term in body.all() {
            if let TermKind::Apply { name, arguments, results } = &term.kind {
                let result = results.first().map(|result| &result.name);
                let apart = result.and_then(|result| self.environment.apart(result));
                self.apply(&place, name.name.as_str(), arguments, apart.as_ref().or(result));
            }
        }
    }

    fn apply(&mut self, place: &Place, name: &str, arguments: &[Written], result: Option<&Name>) {
        let port = arguments.first().and_then(|port| match &port.kind {
            ValueKind::Name(port) => Some(port.name.clone()),
            _ => None,
        });
        match (name, arguments, port) {
            ("In", [_], Some(port)) => {
                let Some(result) = result else { return };
                if let Some(length) = self.found.ports.get(&(place.group, port.clone())).copied() {
                    self.set(place, result, length);
                }
                if let Some(length) = self.local(place, result) {
                    self.found.ports.entry((place.group, port)).or_insert(length);
                }
            }
            ("Out", [_, value], Some(port)) => {
                if let Shape::Vector(length) = self.shape(place, value) {
                    self.found.ports.entry((place.group, port)).or_insert(length);
                } else if let Some(length) = self.found.ports.get(&(place.group, port.clone())).copied() {
                    self.expect(place, value, length);
                }
            }
            ("Set", [value], _) => {
                let Some(result) = result else { return };
                if let Shape::Vector(length) = self.shape(place, value) {
                    self.set(place, result, length);
                } else if let Some(length) = self.local(place, result) {
                    self.expect(place, value, length);
                }
            }
            ("Eq" | "Neq", [one, other], _) => {
                self.alike(place, &[one, other]);
            }
            _ => self.call(place, &Name::new(name), arguments),
        }
    }

    /// A call: parameters are what the arguments are; results are seen under the same names.
    fn call(&mut self, place: &Place, name: &Name, arguments: &[Written]) {
        let Some(header) = self.headers.get(name).copied() else { return self.call_of_before(place, name, arguments) };
        for (parameter, argument) in header.parameters.iter().zip(arguments) {
            let key = (Some(name.clone()), parameter.name.clone());
            match (self.shape(place, argument), self.found.locals.get(&key).copied()) {
                (Shape::Vector(length), None) => {
                    self.found.locals.insert(key, length);
                }
                (Shape::Unknown, Some(length)) => self.expect(place, argument, length),
                (Shape::Number, Some(length)) => self.expect_global(place, argument, length),
                _ => {}
            }
        }
        let Some(Entity::Process(signature)) = self.environment.entity(name) else { return };
        for bound in &signature.flow.binds {
            if let Some(length) = self.found.locals.get(&(Some(name.clone()), bound.clone())).copied() {
                self.set(place, bound, length);
            }
        }
    }

    /// A call of a process of an earlier text.
    fn call_of_before(&mut self, place: &Place, name: &Name, arguments: &[Written]) {
        let environment = self.environment;
        let Some(Entity::Process(signature)) = environment.entity(name) else { return };
        for (length, argument) in signature.lengths.iter().zip(arguments) {
            if let Some(length) = *length {
                self.expect_global(place, argument, length);
            }
        }
    }

    fn local(&self, place: &Place, name: &Name) -> Option<usize> {
        self.found.locals.get(&(place.process.clone(), name.clone())).copied()
    }

    fn set(&mut self, place: &Place, name: &Name, length: usize) {
        if place.parameters.is_none() {
            self.found.locals.entry((place.process.clone(), name.clone())).or_insert(length);
        }
    }

    /// Values that must be of one shape.
    fn alike(&mut self, place: &Place, values: &[&Written]) -> Shape {
        let shapes: Vec<Shape> = values.iter().map(|value| self.shape(place, value)).collect();
        let vector = shapes.iter().find(|shape| matches!(shape, Shape::Vector(_)));
        if let Some(Shape::Vector(length)) = vector {
            values.iter().for_each(|value| self.expect(place, value, *length));
            return Shape::Vector(*length);
        }
        if shapes.contains(&Shape::Number) { Shape::Number } else { Shape::Unknown }
    }

    fn shape(&mut self, place: &Place, value: &Written) -> Shape {
        self.looks += 1;
        if self.looks > MOST_LOOKS {
            return Shape::Unknown;
        }
        match &value.kind {
            ValueKind::Number(_) | ValueKind::Power(..) | ValueKind::Absolute(_) => Shape::Number,
            ValueKind::Vector(parts) => Shape::Vector(parts.len()),
            ValueKind::Negative(inner) => self.shape(place, inner),
            ValueKind::Sum(parts) => self.alike(place, &parts.iter().map(|(_, part)| part).collect::<Vec<_>>()),
            ValueKind::If(_, parts) => self.alike(place, &[&parts[2], &parts[3]]),
            ValueKind::Product(parts) => {
                let shapes: Vec<Shape> = parts.iter().map(|(_, part)| self.shape(place, part)).collect();
                let vector = shapes.iter().find(|shape| matches!(shape, Shape::Vector(_)));
                vector.copied().unwrap_or(if shapes.contains(&Shape::Unknown) { Shape::Unknown } else { Shape::Number })
            }
            ValueKind::Name(name) => self.name(place, &name.name),
            ValueKind::Cases(cases) => self.alike(place, &cases.iter().map(|(value, _)| value).collect::<Vec<_>>()),
            ValueKind::Iterate(_, arguments) => {
                self.alike(place, &arguments.iter().map(|argument| &argument.value).collect::<Vec<_>>())
            }
            ValueKind::Call(name, arguments) => {
                let arguments: Vec<&Written> = arguments.iter().map(|argument| &argument.value).collect();
                match (name.name.as_str(), arguments.as_slice()) {
                    ("unit", [only]) => self.shape(place, only),
                    _ => self.function(place, &name.name, &arguments),
                }
            }
        }
    }

    fn name(&self, place: &Place, name: &Name) -> Shape {
        if let Some(shape) = place.parameters.as_ref().and_then(|parameters| parameters.get(name)) {
            return *shape;
        }
        let apart = self.environment.apart(name);
        let local = self.local(place, name).or_else(|| self.local(place, apart.as_ref()?));
        if let (None, Some(length)) = (&place.parameters, local) {
            return Shape::Vector(length);
        }
        if let (None, Some(length)) = (&place.parameters, self.found.globals.get(name)) {
            return Shape::Vector(*length);
        }
        match self.environment.quantity(name) {
            Some(Quantity::Parameter { constant, .. }) => match constant.as_ref().map(Value::sort) {
                Some(Sort::Vector(length)) => Shape::Vector(length),
                _ => Shape::Number,
            },
            _ => Shape::Unknown,
        }
    }

    /// What a function gives for what it is given.
    fn function(&mut self, place: &Place, name: &Name, arguments: &[&Written]) -> Shape {
        let environment = self.environment;
        let Some(template) = environment.templates.get(name).filter(|_| place.depth < MOST_DEPTH) else {
            return Shape::Number;
        };
        let shapes = arguments.iter().map(|argument| self.shape(place, argument)).collect::<Vec<_>>();
        let parameters = Some(template.parameters.iter().cloned().zip(shapes).collect());
        let inside = Place { process: None, group: place.group, parameters, depth: place.depth + 1 };
        self.shape(&inside, &template.body)
    }

    /// A parameter of the whole text that must be a vector, if it may be one.
    fn expect_global(&mut self, place: &Place, value: &Written, length: usize) {
        let ValueKind::Name(name) = &value.kind else { return };
        if self.open.contains(&name.name) && place.parameters.is_none() && self.local(place, &name.name).is_none() {
            self.found.globals.entry(name.name.clone()).or_insert(length);
        }
    }

    /// A value that must be a vector.
    fn expect(&mut self, place: &Place, value: &Written, length: usize) {
        match &value.kind {
            ValueKind::Name(name) if self.open.contains(&name.name) => self.expect_global(place, value, length),
            ValueKind::Name(name) => {
                let global = self.environment.quantity(&name.name).is_some();
                if !global && !name.name.is_meta() && place.process.is_some() {
                    self.set(place, &name.name, length);
                }
            }
            ValueKind::Sum(parts) => parts.iter().for_each(|(_, part)| self.expect(place, part, length)),
            ValueKind::Negative(inner) => self.expect(place, inner, length),
            ValueKind::If(_, parts) => [&parts[2], &parts[3]].iter().for_each(|part| self.expect(place, part, length)),
            ValueKind::Cases(cases) => cases.iter().for_each(|(value, _)| self.expect(place, value, length)),
            ValueKind::Product(parts) => {
                let shapes: Vec<Shape> = parts.iter().map(|(_, part)| self.shape(place, part)).collect();
                let open = |(_, (shape, (divides, _))): &(usize, (&Shape, &(bool, Written)))| {
                    **shape == Shape::Unknown && !divides
                };
                let open: Vec<usize> = shapes.iter().zip(parts).enumerate().filter(open).map(|(at, _)| at).collect();
                let has_vector = shapes.iter().any(|shape| matches!(shape, Shape::Vector(_)));
                if let ([only], false) = (open.as_slice(), has_vector) {
                    self.expect(place, &parts[*only].1, length);
                }
            }
            ValueKind::Call(name, arguments) if name.name.as_str() == "unit" => {
                arguments.iter().for_each(|argument| self.expect(place, &argument.value, length));
            }
            _ => {}
        }
    }
}

impl Lowerer<'_> {
    /// A value to be found, by its components where it stands beside a vector.
    pub(super) fn beside(&mut self, value: &Value, other: &Value) -> Value {
        let unknown = value.as_variable().filter(|name| name.is_meta());
        let (Some(name), Sort::Vector(length)) = (unknown, other.sort()) else { return value.clone() };
        self.components_of(name, length).unwrap_or_else(|| value.clone())
    }

    /// A name, by its components where it is known to be a vector.
    pub(super) fn whole_or_components(&mut self, name: &Name) -> Option<Value> {
        match self.shapes.get(name).copied() {
            Some(length) => self.components_of(name, length),
            None => Some(Value::variable(name)),
        }
    }

    /// A value that is shown: a name for what is looked for stands for it as a whole.
    pub(super) fn as_shown(&mut self, argument: &Written) -> Option<Value> {
        let value = self.number(argument)?;
        match &argument.kind {
            ValueKind::Name(ident) if ident.name.is_meta() => Some(Value::variable(&ident.name)),
            _ => Some(value),
        }
    }

    /// Notes which names for what is looked for are vectors, from what the observers show.
    pub(super) fn vectors_shown(&mut self, body: &Term) {
        for term in body.all() {
            let TermKind::Apply { name, arguments, .. } = &term.kind else { continue };
            let names = arguments.iter().map(|argument| match &argument.kind {
                ValueKind::Name(ident) if ident.name.is_meta() => Some(&ident.name),
                _ => None,
            });
            if !matches!(self.environment.entity(&name.name), Some(Entity::Observer(_)))
                || names.clone().all(|name| name.is_none())
            {
                continue;
            }
            for (shown, length) in names.zip(self.environment.lengths(&name.name, None)) {
                if let (Some(shown), Some(length)) = (shown, length) {
                    self.shapes.insert(shown.clone(), length);
                }
            }
        }
    }

    /// A name that is a vector, by its components.
    pub(super) fn components_of(&mut self, name: &Name, length: usize) -> Option<Value> {
        let parts = (1..=length).map(|place| {
            Value::apply(&Name::new("part"), &[Value::variable(name), Value::integer(i64::try_from(place).ok()?)]).ok()
        });
        Value::vector(parts.collect::<Option<Vec<_>>>()?).ok()
    }

    /// What a function gives for vectors: its body, read anew with them in place of the parameters.
    pub(super) fn read_anew(&mut self, template: &Template, values: Vec<Value>) -> Option<Value> {
        if self.readings == 0 || self.depth >= MOST_DEPTH {
            let name = template.parameters.first().map_or("", Name::as_str);
            return self.fail(
                Diagnostic::error("P0402", "functions of vectors are nested too deep, or used too often")
                    .label(template.body.span, format!("with a vector for `{name}`")),
            );
        }
        let mut environment = self.environment.clone();
        environment.quantities = template.quantities.clone();
        environment.templates = template.templates.clone();
        let mut inside = Lowerer::new(&environment, self.metas);
        inside.images = template.parameters.iter().cloned().zip(values).collect();
        (inside.readings, inside.depth) = (self.readings - 1, self.depth + 1);
        let result = inside.number(&template.body);
        self.readings = inside.readings;
        let errors: Vec<Diagnostic> = std::mem::take(&mut inside.errors);
        errors.into_iter().for_each(|error| self.report(error));
        result
    }
}

impl Lowerer<'_> {
    /// The number that is written here; an error where it is a vector.
    pub(super) fn real(&mut self, written: &Written) -> Option<Value> {
        let value = self.number(written)?;
        if let sort @ Sort::Vector(_) = value.sort() {
            return self.fail(
                Diagnostic::error("P0402", format!("a number is needed here, and this is {sort}"))
                    .label(written.span, "in this value")
                    .help("take a component, `part(d,1)`, or the length, `norm(d)`"),
            );
        }
        Some(value)
    }

    /// Two values that are compared: numbers, or vectors of one length that are equal or not.
    pub(super) fn compared_sides(
        &mut self,
        relation: Relation,
        one: &Written,
        other: &Written,
    ) -> Option<(Value, Value)> {
        if !matches!(relation, Relation::Eq | Relation::Neq) {
            let one = self.real(one);
            let other = self.real(other)?;
            return Some((one?, other));
        }
        let left = self.number(one);
        let right = self.number(other)?;
        let left = left?;
        let (first, second) = (left.sort(), right.sort());
        // Outside of processes nothing tells of a name that is bound there, or stands for any value, whether it is a vector.
        let open = |name: &Name| self.settled && (name.is_meta() || self.environment.quantity(name).is_none());
        if first != second && ![&left, &right].iter().any(|side| side.variables().iter().any(open)) {
            return self.fail(
                Diagnostic::error("P0402", "these two can be neither equal nor different")
                    .label(one.span, first.to_string())
                    .label(other.span, second.to_string())
                    .help("compare a component, `part(r,1)`, or the length, `norm(r)`, with a number"),
            );
        }
        Some((left, right))
    }

    /// Notes what is given to a process, to be compared with what its parameter must be.
    pub(super) fn note_sort(&mut self, callee: &Ident, index: usize, value: &Value, written: &Written) {
        if matches!(written.kind, ValueKind::Name(_)) {
            return;
        }
        match self.settled {
            true => self.of_length(&callee.name, index, None, (value.sort(), written.span)),
            false => self.given.push((callee.name.clone(), index, value.sort(), written.span)),
        }
    }

    /// Reports a number where a process needs a vector, and a vector of another length.
    pub(super) fn of_length(
        &mut self,
        callee: &Name,
        index: usize,
        needed: Option<usize>,
        (given, span): (Sort, Span),
    ) {
        let Some(Entity::Process(signature)) = self.environment.entity(callee) else { return };
        let needed = needed.or_else(|| signature.lengths.get(index).copied().flatten()).map(Sort::Vector);
        let Some(needed) = needed.filter(|needed| *needed != given && given != Sort::Distribution) else { return };
        let parameter = signature.parameters.get(index).map_or("", Name::as_str);
        let text = format!("the parameter `{parameter}` of `{callee}` is {needed}, but {given} is given");
        self.report(Diagnostic::error("P0401", text).label(span, format!("{given} here")));
    }
}
