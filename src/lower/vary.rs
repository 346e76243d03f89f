//! The same declarations with other values for parameters.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, OnceLock};

use num_rational::BigRational;

use super::{Class, Environment, Quantity};
use crate::ast::{Item, ItemKind};
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::parser::parse;
use crate::value::Value;

/// How an environment came about, so that it can come about otherwise.
#[derive(Clone, Default)]
pub(super) struct History {
    /// What it began from; without one nothing is kept.
    base: Option<Arc<Environment>>,
    steps: Arc<Vec<Arc<Entry>>>,
    /// The values that parameters have instead of those written; none: left open.
    pub(super) instead: Arc<BTreeMap<Name, Option<Value>>>,
}

enum Entry {
    /// A text was opened.
    Open(Opened),
    /// The parameters of this place in the last text that was opened took effect.
    Step(usize),
}

/// A text that was opened, with the places of its declarations: few texts are ever taken in again.
struct Opened {
    text: String,
    places: Vec<Span>,
    /// The declarations, read again when they are first needed.
    items: OnceLock<Vec<Item>>,
}

impl Opened {
    fn items(&self) -> &[Item] {
        self.items.get_or_init(|| {
            let mut items = parse(&self.text).items;
            items.retain(|item| declares(&item.kind) && self.place(item.span).is_some());
            items
        })
    }

    /// The number of the declaration that stands here: they stand in the order of the text.
    fn place(&self, span: Span) -> Option<usize> {
        self.places.binary_search_by_key(&span.start, |place| place.start).ok()
    }
}

fn declares(kind: &ItemKind) -> bool {
    matches!(
        kind,
        ItemKind::Param(_)
            | ItemKind::Function(..)
            | ItemKind::Process(..)
            | ItemKind::Observer(_)
            | ItemKind::System(..)
            | ItemKind::Property(..)
            | ItemKind::Criteria(_)
    )
}

impl History {
    pub(super) fn opened(&mut self, items: &[Item], text: &str) {
        if self.base.is_some() {
            let places: Vec<Span> = items.iter().filter(|item| declares(&item.kind)).map(|item| item.span).collect();
            if !places.is_empty() {
                let opened = Opened { text: text.to_string(), places, items: OnceLock::new() };
                Arc::make_mut(&mut self.steps).push(Arc::new(Entry::Open(opened)));
            }
        }
    }

    /// The parameters that stand here took effect.
    pub(super) fn stepped(&mut self, item: &Item) {
        let place = self.steps.iter().rev().find_map(|entry| match &**entry {
            Entry::Open(opened) => opened.place(item.span),
            Entry::Step(_) => None,
        });
        if let (Some(_), Some(place)) = (&self.base, place) {
            Arc::make_mut(&mut self.steps).push(Arc::new(Entry::Step(place)));
        }
    }
}

impl Environment {
    /// Begins to keep what is declared from now on, for [`Environment::varied`].
    pub fn keep_history(&mut self) {
        let base = Arc::new(Environment { history: History::default(), ..self.clone() });
        self.history = History { base: Some(base), ..History::default() };
    }

    /// The same declarations with other values for parameters that have one; without a value a parameter is left open. A
    /// declaration that is wrong as it is written is left out here as it was there.
    ///
    /// # Errors
    /// What is wrong with the declarations then: an assumption that does not hold, for one.
    pub fn varied(&self, instead: &BTreeMap<Name, Option<Value>>) -> Result<Environment, Vec<Diagnostic>> {
        let mut all = (*self.history.instead).clone();
        all.extend(instead.iter().map(|(name, value)| (name.clone(), value.clone())));
        let all = Arc::new(all);
        self.declared(all.clone(), &mut |_, wrong| Err(wrong)).or_else(|wrong| {
            let mut before = BTreeSet::new();
            self.declared(self.history.instead.clone(), &mut |place, _| {
                before.insert(place);
                Ok(())
            })?;
            if before.is_empty() {
                return Err(wrong);
            }
            self.declared(all, &mut |place, wrong| if before.contains(&place) { Ok(()) } else { Err(wrong) })
        })
    }

    /// All declarations once more, with these values; of each that is wrong it is asked, by its place among all, whether
    /// the others still count.
    fn declared(
        &self,
        instead: Arc<BTreeMap<Name, Option<Value>>>,
        wrong: &mut dyn FnMut(usize, Vec<Diagnostic>) -> Result<(), Vec<Diagnostic>>,
    ) -> Result<Environment, Vec<Diagnostic>> {
        let Some(base) = &self.history.base else { return Ok(self.clone()) };
        let mut environment = (**base).clone();
        environment.history = History { base: Some(base.clone()), instead, steps: Arc::default() };
        let mut current: Option<(super::Batch, &[Item])> = None;
        let mut place = 0;
        let mut step = |environment: &mut Environment, batch: &mut super::Batch, index: usize, item: &Item| {
            place += 1;
            environment.step(batch, index, item).map(drop).or_else(|diagnostics| wrong(place, diagnostics))
        };
        for entry in self.history.steps.iter() {
            match &**entry {
                Entry::Open(opened) => {
                    let items = opened.items();
                    let mut batch = environment.open(items, &opened.text);
                    for (index, item) in items.iter().enumerate() {
                        if !matches!(item.kind, ItemKind::Param(_)) {
                            step(&mut environment, &mut batch, index, item)?;
                        }
                    }
                    current = Some((batch, items));
                }
                Entry::Step(place) => {
                    if let Some((batch, items)) = &mut current
                        && let Some(item) = items.get(*place)
                    {
                        step(&mut environment, batch, *place, item)?;
                    }
                }
            }
        }
        environment.laws = self.laws.clone();
        Ok(environment)
    }

    /// The parameters that have a number for a value, with it.
    pub fn valued(&self) -> Vec<(Name, BigRational)> {
        let number = |(name, quantity): (&Name, &Quantity)| match quantity {
            Quantity::Parameter { class: Class::Number, constant: Some(value) } => {
                value.as_rational().map(|number| (name.clone(), number))
            }
            _ => None,
        };
        self.quantities().filter_map(number).collect()
    }

    /// The names that are declared from other values, `param v = 2*k`: they move with those.
    pub(super) fn instead_of(&self, name: &Name) -> Option<&Option<Value>> {
        self.history.instead.get(name)
    }

    /// The names of all criteria.
    pub fn criteria_names(&self) -> impl Iterator<Item = &Name> {
        self.criteria.keys()
    }

    /// The criteria of this name, as written.
    pub fn criteria_of(&self, name: &Name) -> Option<&Arc<crate::ast::Criteria>> {
        self.criteria.get(name)
    }

    /// The names that a declaration of this environment gives a value to.
    pub fn parameters(&self) -> BTreeSet<Name> {
        self.valued().into_iter().map(|(name, _)| name).collect()
    }
}
