//! The items of one text, taken in: declarations first, then assumptions and claims in order.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::flow::names;
use super::network::impossible;
use super::scope::{Lowerer, Metas};
use super::value::FUNCTIONS;
use super::{BASIC, Claim, ClaimKind, Class, Entity, Environment, Lowered, Property, Quantity, Signature, System};
use crate::ast::{self, Ident, Item, ItemKind, Parameter, TermKind, ValueKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::term::Term;
use crate::value::{Relation, Value};

/// The wish to stop is asked once for so many declarations.
const EVERY: u32 = 16;

/// A text whose declarations have been taken in; see [`Environment::open`].
#[derive(Debug, Default)]
pub struct Batch {
    text: String,
    outcomes: Vec<Option<Result<Lowered, Vec<Diagnostic>>>>,
}

/// What is noted while the declarations of a text are taken in.
pub(super) struct Opening<'w> {
    /// The wish to stop, asked now and then; then all is as it was before.
    interrupted: &'w dyn Fn() -> bool,
    asked: Cell<u32>,
    stopped: Cell<bool>,
    /// For each item, what is wrong with it.
    pub(super) errors: Vec<Vec<Diagnostic>>,
    /// What was declared before the text.
    pub(super) before: Environment,
    /// Where each name was declared in this text.
    places: BTreeMap<Name, Span>,
    /// Names that are bound as results by processes from before.
    pub(super) bound_before: BTreeSet<Name>,
    /// The items whose names are taken already.
    twice: BTreeSet<usize>,
    /// For each item, what is to be told beside it.
    notes: BTreeMap<usize, Vec<String>>,
}

impl Entity {
    /// Whether it is a system or a property whose definition has errors.
    pub fn is_broken(&self) -> bool {
        match self {
            Entity::System(system) => system.components.is_empty(),
            Entity::Property(property) => property.body.is_none(),
            _ => false,
        }
    }

    /// `process`, `observer`, …
    pub fn word(&self) -> &'static str {
        match self {
            Entity::Process(_) => "process",
            Entity::Observer(_) => "observer",
            Entity::System(_) => "system",
            Entity::Property(_) => "property",
        }
    }
}

impl Opening<'_> {
    pub(super) fn report(&mut self, index: usize, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        if let Some(errors) = self.errors.get_mut(index) {
            errors.extend(diagnostics);
        }
    }

    /// Whether the work is to stop.
    pub(super) fn stops(&self) -> bool {
        self.asked.set(self.asked.get().wrapping_add(1));
        if self.asked.get().is_multiple_of(EVERY) && (self.interrupted)() {
            self.stopped.set(true);
        }
        self.stopped.get()
    }

    /// Notes what is to be told beside an item.
    pub(super) fn tell(&mut self, index: usize, text: String) {
        self.notes.entry(index).or_default().push(text);
    }

    /// Whether something is wrong with an item.
    pub(super) fn is_wrong(&self, index: usize) -> bool {
        self.errors.get(index).is_some_and(|errors| !errors.is_empty())
    }

    pub(super) fn is_twice(&self, index: usize) -> bool {
        self.twice.contains(&index)
    }
}

impl Environment {
    /// Takes in all declarations of a text, so that its processes see each other; then [`Environment::step`]
    /// takes the items one by one. An import belongs before the rest: split the items at imports.
    pub fn open(&mut self, items: &[Item], text: &str) -> Batch {
        self.open_until(items, text, &|| false).unwrap_or_default()
    }

    /// The same, as long as it is not interrupted; when it is, nothing is declared.
    pub fn open_until(&mut self, items: &[Item], text: &str, interrupted: &dyn Fn() -> bool) -> Option<Batch> {
        let mut opening = Opening {
            interrupted,
            asked: Cell::default(),
            stopped: Cell::default(),
            errors: vec![Vec::new(); items.len()],
            before: self.clone(),
            places: BTreeMap::new(),
            bound_before: self.bound(),
            twice: BTreeSet::new(),
            notes: BTreeMap::new(),
        };
        self.history.opened(items, text);
        for (index, item) in items.iter().enumerate() {
            self.announce(&mut opening, index, &item.kind);
        }
        for (index, item) in items.iter().enumerate() {
            if opening.stops() {
                break;
            }
            match &item.kind {
                ItemKind::Param(parameters) => self.declare_parameters(&mut opening, index, parameters),
                ItemKind::Function(header, body) => self.declare_function(&mut opening, index, header, body.as_ref()),
                _ => {}
            }
        }
        self.settle_vectors(&mut opening, items, text);
        self.define_processes(&mut opening, items);
        for (index, item) in items
            .iter()
            .enumerate()
            .filter(|(_, item)| matches!(item.kind, ItemKind::System(..) | ItemKind::Property(..)))
        {
            if !opening.is_twice(index) && !opening.stops() {
                self.define_network(&mut opening, index, &item.kind);
            }
        }
        if opening.stopped.get() {
            *self = opening.before;
            return None;
        }
        let mut notes = opening.notes;
        let outcomes = items.iter().enumerate().zip(opening.errors).map(|((index, item), errors)| {
            if !errors.is_empty() {
                return Some(Err(errors));
            }
            let names = declared(&item.kind)?;
            // An item of parameters takes effect in its turn.
            let redefined = names.iter().filter(|name| opening.before.knows(name)).cloned().collect();
            Some(Ok(Lowered::Declared { names, redefined, notes: notes.remove(&index).unwrap_or_default() }))
        });
        Some(Batch { text: text.to_string(), outcomes: outcomes.collect() })
    }

    /// Takes the next item of an opened text.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn step(&mut self, batch: &mut Batch, index: usize, item: &Item) -> Result<Lowered, Vec<Diagnostic>> {
        self.step_until(batch, index, item, &|| false)
    }

    /// The same, as long as it is not interrupted; when it is, nothing is assumed, and nothing said of it.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn step_until(
        &mut self,
        batch: &mut Batch,
        index: usize,
        item: &Item,
        interrupted: &dyn Fn() -> bool,
    ) -> Result<Lowered, Vec<Diagnostic>> {
        if let Some(outcome) = batch.outcomes.get_mut(index).and_then(Option::take) {
            let lowered = outcome?;
            if let ItemKind::Param(parameters) = &item.kind {
                self.assume_all(parameters, interrupted)?;
                self.history.stepped(item);
            }
            return Ok(lowered);
        }
        let lowered = self.lower_item(item, &batch.text)?;
        if let Lowered::Law(law) = &lowered {
            self.laws.push(law.clone());
        }
        if let Lowered::Claim(Claim { name: Some(name), kind: ClaimKind::Compare { .. }, .. }) = &lowered {
            Arc::make_mut(&mut self.claims).insert(name.clone());
        }
        Ok(lowered)
    }

    fn knows(&self, name: &Name) -> bool {
        self.entities.contains_key(name)
            || match self.quantity(name) {
                Some(Quantity::Parameter { constant, .. }) => constant.is_some(),
                Some(Quantity::Function { .. }) => true,
                None => false,
            }
    }

    fn bound(&self) -> BTreeSet<Name> {
        let mut bound = BTreeSet::new();
        for entity in self.entities.values() {
            if let Entity::Process(signature) = entity {
                bound.extend(signature.flow.binds.iter().cloned());
            }
        }
        bound
    }

    pub(super) fn put(&mut self, name: &Name, entity: Entity) {
        Arc::make_mut(&mut self.entities).insert(name.clone(), entity);
    }

    /// Enters the name of a process, observer, system or property.
    fn announce(&mut self, opening: &mut Opening<'_>, index: usize, kind: &ItemKind) {
        let (name, entity) = match kind {
            ItemKind::Observer(headers) => {
                for header in headers {
                    self.enter_name(opening, index, &header.name, Entity::Observer(header.parameters.len()));
                }
                return;
            }
            ItemKind::Process(header, _) => {
                let parameters = header.parameters.iter().map(|parameter| parameter.name.clone()).collect();
                (&header.name, Entity::Process(Signature { parameters, ..Signature::default() }))
            }
            ItemKind::System(name, _) => {
                (name, Entity::System(System { name: name.name.clone(), components: Vec::new() }))
            }
            ItemKind::Property(name, ..) => {
                (name, Entity::Property(Property { name: name.name.clone(), body: None, within: None, always: None }))
            }
            ItemKind::Function(header, _) => {
                if FUNCTIONS.iter().any(|(known, _)| *known == header.name.name.as_str()) {
                    opening.report(index, [taken(&header.name, "a function of the language")]);
                    opening.twice.insert(index);
                }
                self.once(opening, index, &header.name);
                return;
            }
            ItemKind::Criteria(criteria) => {
                if self.once(opening, index, &criteria.name) {
                    Arc::make_mut(&mut self.criteria).insert(criteria.name.name.clone(), criteria.clone());
                }
                return;
            }
            _ => return,
        };
        self.enter_name(opening, index, name, entity);
    }

    fn enter_name(&mut self, opening: &mut Opening<'_>, index: usize, name: &Ident, entity: Entity) {
        if BASIC.contains(&name.name.as_str()) {
            opening.report(index, [taken(name, "a basic process")]);
            opening.twice.insert(index);
        } else if self.once(opening, index, name) {
            self.put(&name.name, entity);
        }
    }

    /// Whether the name is new in this text; else it is reported.
    fn once(&mut self, opening: &mut Opening<'_>, index: usize, name: &Ident) -> bool {
        let Some(first) = opening.places.get(&name.name).copied() else {
            opening.places.insert(name.name.clone(), name.span);
            return true;
        };
        opening.twice.insert(index);
        opening.report(
            index,
            [Diagnostic::error("P0319", format!("`{}` is declared twice", name.name))
                .label(name.span, "again here")
                .label(first, "first here")
                .help("give one of them another name")],
        );
        false
    }

    fn declare_parameters(&mut self, opening: &mut Opening<'_>, index: usize, parameters: &[Parameter]) {
        for parameter in parameters {
            match parameter {
                Parameter::Plain(name) => self.declare_parameter(opening, index, name, Class::Number, None),
                Parameter::Sorted(name, sort) => match sort.name.as_str() {
                    "natural" | "real" => self.declare_parameter(opening, index, name, Class::Number, None),
                    "distribution" => self.declare_parameter(opening, index, name, Class::Distribution, None),
                    _ => opening.report(index, [wrong_sort(sort)]),
                },
                Parameter::Assumed(relation, left, right) => {
                    if let Some(name) = self.constant(*relation, left, right) {
                        let name = name.clone();
                        let mut lowerer = Lowerer::new(self, Metas::Forbidden);
                        let value = lowerer.number(right);
                        match lowerer.finish(value) {
                            Ok(value) if self.once(opening, index, &name) => {
                                let value = self.instead_of(&name.name).cloned().unwrap_or(Some(value));
                                self.declare_parameter(opening, index, &name, Class::Number, value);
                            }
                            Ok(_) => {}
                            Err(errors) => opening.report(index, errors),
                        }
                        continue;
                    }
                    let mut idents = Vec::new();
                    names(left, &mut idents);
                    names(right, &mut idents);
                    for ident in idents {
                        if self.quantity(&ident.name).is_none() && !ident.name.is_meta() {
                            self.declare_parameter(opening, index, ident, Class::Number, None);
                        }
                    }
                }
            }
        }
    }

    /// Whether `x = 3` is a value that is passed over here.
    pub(super) fn left_open(&self, relation: Relation, left: &ast::Value) -> bool {
        let ValueKind::Name(name) = &left.kind else { return false };
        relation == Relation::Eq && self.instead_of(&name.name).is_some()
    }

    /// The name that `x = 3` gives a value to: one that is new, or had a value before.
    pub(super) fn constant<'p>(
        &self,
        relation: Relation,
        left: &'p ast::Value,
        right: &ast::Value,
    ) -> Option<&'p Ident> {
        let ValueKind::Name(name) = &left.kind else { return None };
        let mut mentioned = Vec::new();
        names(right, &mut mentioned);
        let open = matches!(self.quantity(&name.name), None | Some(Quantity::Parameter { constant: Some(_), .. }));
        let fits = relation == Relation::Eq && open && !name.name.is_meta();
        (fits && mentioned.iter().all(|other| other.name != name.name)).then_some(name)
    }

    fn declare_parameter(
        &mut self,
        opening: &mut Opening<'_>,
        index: usize,
        name: &Ident,
        class: Class,
        constant: Option<Value>,
    ) {
        if opening.bound_before.contains(&name.name) {
            let user = self.entities.iter().find(
                |(_, entity)| matches!(entity, Entity::Process(signature) if signature.flow.binds.contains(&name.name)),
            );
            let user = user.map_or("a process", |(user, _)| user.as_str());
            opening.report(
                index,
                [Diagnostic::error("P0507", format!("`{}` is the name of a result in `{user}`", name.name))
                    .label(name.span, "so it cannot be declared for the whole text")
                    .help(format!("declare it under another name, or rename the result in `{user}`"))],
            );
            return;
        }
        if matches!(self.quantity(&name.name), Some(Quantity::Function { .. })) {
            opening.report(index, [taken(name, "a function")]);
            return;
        }
        let known = matches!(self.quantity(&name.name), Some(Quantity::Parameter { constant: None, class: before }) if *before == class);
        if !known || constant.is_some() {
            Arc::make_mut(&mut self.quantities).insert(name.name.clone(), Quantity::Parameter { class, constant });
        }
    }

    /// Takes in a system or a property; all processes are defined by now.
    fn define_network(&mut self, opening: &mut Opening<'_>, index: usize, kind: &ItemKind) {
        let (name, result) = match kind {
            ItemKind::System(name, body) => (
                name,
                self.components(body).map(|components| Entity::System(System { name: name.name.clone(), components })),
            ),
            ItemKind::Property(name, body, restriction) => {
                (name, self.network(name, body, restriction.as_ref()).map(Entity::Property))
            }
            _ => return,
        };
        match result {
            Ok(entity) => self.put(&name.name, entity),
            Err(errors) => {
                opening.report(index, errors);
                self.restore(opening, &name.name);
            }
        }
    }

    /// Puts back what a name stood for before the text, if anything.
    pub(super) fn restore(&mut self, opening: &Opening<'_>, name: &Name) {
        if let Some(entity) = opening.before.entity(name) {
            self.put(name, entity.clone());
        }
    }

    fn components(&self, body: &ast::Term) -> Result<Vec<Term>, Vec<Diagnostic>> {
        let parts = match &body.kind {
            TermKind::Par(parts) => parts.as_slice(),
            _ => std::slice::from_ref(body),
        };
        let mut components = Vec::new();
        let mut errors = Vec::new();
        for part in parts {
            let mut lowerer = Lowerer::new(self, Metas::Forbidden);
            let lowered = lowerer.whole(&[part]);
            match lowerer.finish(lowered) {
                Ok(terms) => {
                    errors.extend(terms.iter().filter_map(|term| self.impossible(term, part)));
                    components.extend(terms);
                }
                Err(more) => errors.extend(more),
            }
        }
        if errors.is_empty() { Ok(components) } else { Err(errors) }
    }

    /// That a component draws from no distribution, or waits for a negative time, with the values that it is given.
    fn impossible(&self, component: &Term, written: &ast::Term) -> Option<Diagnostic> {
        let found = impossible(component, &self.definitions, &self.assumptions)?;
        Some(Diagnostic::error(found.code, found.text).label(written.span, "with the values that are given here"))
    }
}

fn wrong_sort(sort: &Ident) -> Diagnostic {
    let diagnostic =
        Diagnostic::error("P0322", format!("there is no sort `{}`", sort.name)).label(sort.span, "this sort");
    if sort.name.as_str() == "vector" {
        return diagnostic.help("declare the components as numbers and write the vector `(x, y)`");
    }
    diagnostic.help("the sorts are `natural`, `real` and `distribution`")
}

pub(super) fn taken(name: &Ident, what: &str) -> Diagnostic {
    Diagnostic::error("P0320", format!("the name `{}` is taken: it is {what}", name.name))
        .label(name.span, "declared here")
        .help("choose another name")
}

/// The names that an item declares; none when it declares nothing.
fn declared(kind: &ItemKind) -> Option<Vec<Name>> {
    Some(match kind {
        ItemKind::Param(parameters) => {
            let mut all = Vec::new();
            for parameter in parameters {
                match parameter {
                    Parameter::Plain(name) | Parameter::Sorted(name, _) => all.push(name.name.clone()),
                    Parameter::Assumed(_, left, right) => {
                        let mut idents = Vec::new();
                        names(left, &mut idents);
                        if !matches!(left.kind, ValueKind::Name(_)) {
                            names(right, &mut idents);
                        }
                        all.extend(idents.into_iter().map(|ident| ident.name.clone()));
                    }
                }
            }
            all.dedup();
            all
        }
        ItemKind::Observer(headers) => headers.iter().map(|header| header.name.name.clone()).collect(),
        ItemKind::Function(header, _) | ItemKind::Process(header, _) => vec![header.name.name.clone()],

        ItemKind::System(name, _) | ItemKind::Property(name, ..) => vec![name.name.clone()],
        _ => return None,
    })
}
