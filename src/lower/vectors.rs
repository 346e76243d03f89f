//! Parameters of the whole text that are vectors because of where they stand: `g` of `Go_g`, where `Go` heads for a place
//! in the plane. Each becomes a vector of new parameters, `(gx,gy)`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::declare::Opening;
use super::flow::names;
use super::shape::Shapes;
use super::{Class, Environment, Quantity, Template};
use crate::ast::{Item, ItemKind, Parameter, Term, TermKind, Value as Written, ValueKind};
use crate::law::Law;
use crate::name::Name;
use crate::scope::read_names;
use crate::value::{Relation, Value};

/// What the processes, systems and assumptions of a text say of parameters.
#[derive(Default)]
struct Said {
    /// Those that are compared with a vector, with its length.
    vectors: BTreeMap<Name, usize>,
    /// Those that are compared as numbers.
    numbers: BTreeSet<Name>,
    /// All names that stand in it.
    names: BTreeSet<Name>,
    /// Those that a process binds.
    bound: BTreeSet<Name>,
    /// Whether a vector is written anywhere.
    any: bool,
}

impl Said {
    fn of(items: &[Item]) -> Said {
        let mut said = Said::default();
        for item in items {
            match &item.kind {
                ItemKind::Param(parameters) => parameters.iter().for_each(|parameter| said.parameter(parameter)),
                ItemKind::Process(header, body) => {
                    said.bound.extend(header.parameters.iter().chain(&header.results).map(|one| one.name.clone()));
                    said.term(body);
                }
                ItemKind::System(_, body) | ItemKind::Property(_, body, _) => said.term(body),
                _ => {}
            }
        }
        said
    }

    fn parameter(&mut self, parameter: &Parameter) {
        let (relation, left, right) = match parameter {
            Parameter::Plain(name) => {
                self.names.insert(name.name.clone());
                return;
            }
            Parameter::Sorted(name, _) => {
                self.numbers.insert(name.name.clone());
                return;
            }
            Parameter::Assumed(relation, left, right) => (relation, left, right),
        };
        for (one, other) in [(left, right), (right, left)] {
            self.value(one);
            let ValueKind::Name(name) = &one.kind else { continue };
            match &other.kind {
                ValueKind::Vector(parts) if matches!(relation, Relation::Eq | Relation::Neq) => {
                    self.vectors.insert(name.name.clone(), parts.len());
                }
                _ => {
                    self.numbers.insert(name.name.clone());
                }
            }
        }
    }

    fn term(&mut self, term: &Term) {
        for part in term.all() {
            if let TermKind::Apply { arguments, results, .. } = &part.kind {
                self.bound.extend(results.iter().map(|result| result.name.clone()));
                arguments.iter().for_each(|argument| self.value(argument));
            }
        }
    }

    fn value(&mut self, value: &Written) {
        let mut own = Vec::new();
        names(value, &mut own);
        self.names.extend(own.into_iter().map(|name| name.name.clone()));
        self.any |= has_vector(value);
    }
}

fn has_vector(value: &Written) -> bool {
    match &value.kind {
        ValueKind::Vector(_) => true,
        ValueKind::Number(_) | ValueKind::Name(_) | ValueKind::Power(..) => false,
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().any(|(_, part)| has_vector(part)),
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => has_vector(inner),
        ValueKind::If(_, parts) => parts.iter().any(has_vector),
        ValueKind::Call(_, arguments) | ValueKind::Iterate(_, arguments) => {
            arguments.iter().any(|one| has_vector(&one.value))
        }
        ValueKind::Cases(cases) => cases.iter().any(|(value, _)| has_vector(value)),
    }
}

impl Environment {
    /// Makes vectors of those parameters that a text uses as such, and of which nothing was known so far; what is to be
    /// told of them is noted beside the item that declares them, or the first that uses them.
    pub(super) fn settle_vectors(&mut self, opening: &mut Opening<'_>, items: &[Item], text: &str) {
        let said = Said::of(items);
        if !said.any {
            return;
        }
        let elsewhere = |item: &&Item| {
            matches!(item.kind, ItemKind::Function(..) | ItemKind::Law(_) | ItemKind::Solve(_) | ItemKind::Criteria(_))
        };
        let read: BTreeSet<&str> = items.iter().filter(elsewhere).flat_map(|item| words(item.span.of(text))).collect();
        let may_be = |name: &&Name| {
            // What is compared with a vector is no number anywhere.
            let whole = said.vectors.contains_key(*name) || !read.contains(name.as_str());
            whole && self.is_open(name, &said, opening)
        };
        let open: BTreeSet<Name> = said.names.iter().filter(may_be).cloned().collect();
        if open.is_empty() {
            return;
        }
        let mut found = Shapes::globals(items, self, open.clone());
        found.extend(said.vectors.iter().filter(|(name, _)| open.contains(*name)).map(|(name, n)| (name.clone(), *n)));
        let place_of = |name: &Name| {
            let place = items.iter().position(|item| matches!(&item.kind, ItemKind::Param(own) if declares(own, name)));
            place.or_else(|| items.iter().position(|item| stands_in(item, name))).unwrap_or_default()
        };
        // What is claimed and expected may name the components.
        let binds = |item: &&Item| {
            elsewhere(item)
                || matches!(item.kind, ItemKind::Process(..) | ItemKind::System(..) | ItemKind::Property(..))
        };
        let used: BTreeSet<&str> = items.iter().filter(binds).flat_map(|item| words(item.span.of(text))).collect();
        found.retain(|name, length| {
            let taken = |own: &Name| {
                self.quantity(own).is_some() || used.contains(own.as_str()) || opening.bound_before.contains(own)
            };
            let taken = (0..*length).map(|place| name.component(place, *length)).find(taken);
            if let Some(own) = &taken {
                opening.tell(
                    place_of(name),
                    format!(
                        "{name} stands where a vector must, and is not read as one: {own} is the name of something else"
                    ),
                );
            }
            taken.is_none()
        });
        for (name, length) in &found {
            if let Some(text) = self.made_vector(name, *length) {
                opening.tell(place_of(name), text);
            }
        }
        if !found.is_empty() {
            for (index, item) in items.iter().enumerate() {
                if let (ItemKind::Function(header, body), false) = (&item.kind, opening.is_wrong(index)) {
                    self.declare_function(opening, index, header, body.as_ref());
                }
            }
        }
    }

    /// Makes a parameter a vector of new ones; what is to be told of it.
    fn made_vector(&mut self, name: &Name, length: usize) -> Option<String> {
        let parts: Vec<Name> = (0..length).map(|place| name.component(place, length)).collect();
        let vector = Value::vector(parts.iter().map(Value::variable).collect()).ok()?;
        let quantities = Arc::make_mut(&mut self.quantities);
        for part in &parts {
            quantities.insert(part.clone(), Quantity::Parameter { class: Class::Number, constant: None });
        }
        let text = format!("{name} is the vector {vector}");
        quantities.insert(name.clone(), Quantity::Parameter { class: Class::Number, constant: Some(vector) });
        Some(text)
    }

    /// Whether nothing is known of a parameter yet, and nothing stands on it.
    fn is_open(&self, name: &Name, said: &Said, opening: &Opening<'_>) -> bool {
        let parameter =
            matches!(self.quantity(name), Some(Quantity::Parameter { class: Class::Number, constant: None }));
        let in_laws = || {
            let sides = |law: &Law| [&law.left, &law.right].into_iter().any(|side| read_names(side).contains(name));
            self.laws.iter().any(|law| sides(law))
        };
        let before = |template: &Template| template.quantities.contains_key(name);
        let used = || {
            self.definitions.iter().any(|definition| read_names(&definition.body).contains(name))
                || opening.before.templates.values().any(before)
                || in_laws()
        };
        parameter
            && !said.numbers.contains(name)
            && !said.bound.contains(name)
            && !self.assumptions.mentions(name)
            && !self.assumptions.naturals().contains(name)
            && !used()
    }
}

/// The words of a text, names among them.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_' && letter != '\'').flat_map(|word| {
        // `At_gx` shows gx.
        std::iter::once(word).chain(word.split('_'))
    })
}

fn declares(parameters: &[Parameter], name: &Name) -> bool {
    parameters.iter().any(|parameter| match parameter {
        Parameter::Plain(own) => own.name == *name,
        Parameter::Sorted(..) => false,
        Parameter::Assumed(_, left, right) => [left, right].iter().any(|side| mentions(side, name)),
    })
}

fn stands_in(item: &Item, name: &Name) -> bool {
    let (ItemKind::Process(_, body) | ItemKind::System(_, body) | ItemKind::Property(_, body, _)) = &item.kind else {
        return false;
    };
    body.all().into_iter().any(|term| match &term.kind {
        TermKind::Apply { arguments, .. } => arguments.iter().any(|argument| mentions(argument, name)),
        _ => false,
    })
}

fn mentions(value: &Written, name: &Name) -> bool {
    let mut own = Vec::new();
    names(value, &mut own);
    own.iter().any(|one| one.name == *name)
}
