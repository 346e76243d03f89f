//! Parameters of the whole text that are vectors because of where they stand: `g` of `Go_g`, where `Go` heads for a place
//! in the plane. Each becomes a vector of new parameters, `(gx,gy)`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::declare::Opening;
use super::flow::names;
use super::shape::Shapes;
use super::{Class, Environment, Quantity};
use crate::ast::{Item, ItemKind, Parameter, Term, TermKind, Value as Written, ValueKind};
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
                    said.names.extend(header.parameters.iter().chain(&header.results).map(|one| one.name.clone()));
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
                self.names.extend(results.iter().map(|result| result.name.clone()));
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
    pub(super) fn settle_vectors(&mut self, opening: &mut Opening<'_>, items: &[Item]) {
        let said = Said::of(items);
        if !said.any {
            return;
        }
        let open: BTreeSet<Name> = said.names.iter().filter(|name| self.is_open(name, &said)).cloned().collect();
        if open.is_empty() {
            return;
        }
        let mut found = Shapes::globals(items, self, open.clone());
        found.extend(said.vectors.iter().filter(|(name, _)| open.contains(*name)).map(|(name, n)| (name.clone(), *n)));
        found.retain(|name, length| {
            let free = |own: &Name| self.quantity(own).is_none() && !said.names.contains(own);
            (0..*length).all(|place| free(&name.component(place, *length)))
        });
        for (name, length) in &found {
            let parts: Vec<Name> = (0..*length).map(|place| name.component(place, *length)).collect();
            let Ok(vector) = Value::vector(parts.iter().map(Value::variable).collect()) else { continue };
            let quantities = Arc::make_mut(&mut self.quantities);
            for part in &parts {
                quantities.insert(part.clone(), Quantity::Parameter { class: Class::Number, constant: None });
            }
            let text = format!("{name} is the vector {vector}");
            quantities.insert(name.clone(), Quantity::Parameter { class: Class::Number, constant: Some(vector) });
            let place = items.iter().position(|item| matches!(&item.kind, ItemKind::Param(own) if declares(own, name)));
            let place = place.or_else(|| items.iter().position(|item| stands_in(item, name)));
            opening.tell(place.unwrap_or_default(), text);
        }
        if !found.is_empty() {
            for (index, item) in items.iter().enumerate() {
                if let (ItemKind::Function(header, body), false) = (&item.kind, opening.is_wrong(index)) {
                    self.declare_function(opening, index, header, body.as_ref());
                }
            }
        }
    }

    /// Whether nothing is known of a parameter yet, and nothing stands on it.
    fn is_open(&self, name: &Name, said: &Said) -> bool {
        let parameter =
            matches!(self.quantity(name), Some(Quantity::Parameter { class: Class::Number, constant: None }));
        let used = || self.definitions.iter().any(|definition| read_names(&definition.body).contains(name));
        parameter
            && !said.numbers.contains(name)
            && !self.assumptions.mentions(name)
            && !self.assumptions.naturals().contains(name)
            && !used()
    }
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
