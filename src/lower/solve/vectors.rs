//! Parameters that are vectors because of where they stand: `g` of `unit(g-r(n))`, where the terms `r(n)` are vectors.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Lengths;
use crate::ast::{self, Ident, Value as Written, ValueKind};
use crate::lower::{Class, Environment, Quantity};
use crate::name::Name;
use crate::value::Value;

impl Environment {
    /// The same with vectors of new parameters for those of which nothing is known and that are added to vectors or compared with
    /// them, and what is to be said of it; nothing where there are none.
    pub(in crate::lower) fn with_vectors(&self, solve: &ast::Solve) -> Option<(Environment, Vec<String>)> {
        let mut lengths = Lengths::new();
        for (left, right) in &solve.equations {
            if let (ValueKind::Call(name, _), ValueKind::Vector(parts)) = (&left.kind, &right.kind) {
                lengths.insert(name.name.clone(), parts.len());
            }
        }
        let mut used = BTreeSet::new();
        for value in solve.equations.iter().flat_map(|(left, right)| [left, right]) {
            names_in(value, &mut used);
        }
        used.extend(lengths.iter().flat_map(|(name, length)| (0..*length).map(|place| name.component(place, *length))));
        let mut search = Search { environment: self, lengths, used, found: BTreeMap::new() };
        let asked = solve.find.iter().flat_map(|find| find.either.comparisons());
        let sides: Vec<[&Written; 2]> = asked.map(|one| [&one.left, &one.right]).collect();
        // What is a vector in one place is one in all.
        for _ in 0..2 {
            solve.equations.iter().for_each(|(_, right)| search.look_in(right));
            sides.iter().for_each(|sides| search.alike(sides));
        }
        let found = search.found;
        if found.is_empty() {
            return None;
        }
        let (mut environment, mut notes) = (self.clone(), Vec::new());
        for (name, length) in found {
            let parts: Vec<Name> = (0..length).map(|place| name.component(place, length)).collect();
            let values: Vec<Value> = parts.iter().map(Value::variable).collect();
            notes.push(format!(
                "{name} is the vector ({})",
                parts.iter().map(Name::as_str).collect::<Vec<_>>().join(",")
            ));
            let quantity = Quantity::Parameter { class: Class::Number, constant: Some(Value::vector(values).ok()?) };
            Arc::make_mut(&mut environment.quantities).insert(name, quantity);
        }
        Some((environment, notes))
    }
}

struct Search<'e> {
    environment: &'e Environment,
    /// Of each sequence that begins with a vector how many components it has.
    lengths: Lengths,
    /// The names in the equations, and those of components of sequences.
    used: BTreeSet<Name>,
    /// The parameters that are vectors.
    found: BTreeMap<Name, usize>,
}

impl Search<'_> {
    /// What a value must be for its sums to have a meaning.
    fn look_in(&mut self, value: &Written) {
        match &value.kind {
            ValueKind::Sum(parts) => self.alike(&parts.iter().map(|(_, part)| part).collect::<Vec<_>>()),
            ValueKind::Product(parts) => parts.iter().for_each(|(_, part)| self.look_in(part)),
            ValueKind::Negative(inner) | ValueKind::Absolute(inner) => self.look_in(inner),
            ValueKind::If(_, parts) => {
                let [left, right, first, second] = parts.as_ref();
                self.alike(&[left, right]);
                self.alike(&[first, second]);
            }
            ValueKind::Call(_, arguments) => arguments.iter().for_each(|one| self.look_in(&one.value)),
            ValueKind::Cases(cases) => {
                self.alike(&cases.iter().map(|(value, _)| value).collect::<Vec<_>>());
                for one in cases.iter().filter_map(|(_, when)| when.as_ref()).flat_map(ast::Either::comparisons) {
                    self.alike(&[&one.left, &one.right]);
                }
            }
            _ => {}
        }
    }

    /// The same of values of which one is a vector where the others are.
    fn alike(&mut self, values: &[&Written]) {
        if let Some(length) = values.iter().find_map(|value| self.length(value)) {
            let own: Vec<Name> = values.iter().filter_map(|value| self.vector_in(value, length)).cloned().collect();
            self.found.extend(own.into_iter().map(|name| (name, length)));
        }
        values.iter().for_each(|value| self.look_in(value));
    }

    /// The parameter that must be a vector for a value to be one: `g`, or that of `g/2`.
    fn vector_in<'v>(&self, value: &'v Written, length: usize) -> Option<&'v Name> {
        match &value.kind {
            ValueKind::Name(name) => self.is_open(name, length).then_some(&name.name),
            ValueKind::Negative(inner) => self.vector_in(inner, length),
            ValueKind::Product(parts) if self.length(value).is_none() => {
                let mut all =
                    parts.iter().filter(|(divides, _)| !divides).filter_map(|(_, part)| self.vector_in(part, length));
                all.next().filter(|_| all.next().is_none())
            }
            _ => None,
        }
    }

    /// How many components it surely has.
    fn length(&self, value: &Written) -> Option<usize> {
        match &value.kind {
            ValueKind::Vector(parts) => Some(parts.len()),
            ValueKind::Call(name, _) if name.name.as_str() == "norm" => None,
            ValueKind::Call(name, arguments) => self.lengths.get(&name.name).copied().or_else(|| {
                let unit = name.name.as_str() == "unit";
                arguments.first().filter(|_| unit).and_then(|argument| self.length(&argument.value))
            }),
            ValueKind::Name(name) => self.found.get(&name.name).copied(),
            ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().find_map(|(_, part)| self.length(part)),
            ValueKind::Negative(inner) => self.length(inner),
            _ => None,
        }
    }

    /// Whether it is a parameter of which nothing is known, whose components have names of their own.
    fn is_open(&self, name: &Ident, length: usize) -> bool {
        let quantity = self.environment.quantity(&name.name);
        let parameter = matches!(quantity, Some(Quantity::Parameter { class: Class::Number, constant: None }));
        let taken = |place: usize| {
            let own = name.name.component(place, length);
            self.environment.quantity(&own).is_some() || self.used.contains(&own)
        };
        let assumed = self.environment.assumptions.mentions(&name.name);
        parameter && !assumed && !(0..length).any(taken) && !self.lengths.contains_key(&name.name)
    }
}

/// All names in a value, those of functions, sequences and indices among them.
fn names_in(value: &Written, into: &mut BTreeSet<Name>) {
    match &value.kind {
        ValueKind::Number(_) => {}
        ValueKind::Name(name) => {
            into.insert(name.name.clone());
        }
        ValueKind::Sum(parts) | ValueKind::Product(parts) => parts.iter().for_each(|(_, part)| names_in(part, into)),
        ValueKind::Power(base, exponent) => [base, exponent].into_iter().for_each(|part| names_in(part, into)),
        ValueKind::Negative(inner) | ValueKind::Absolute(inner) => names_in(inner, into),
        ValueKind::If(_, parts) => parts.iter().for_each(|part| names_in(part, into)),
        ValueKind::Vector(parts) => parts.iter().for_each(|part| names_in(part, into)),
        ValueKind::Call(name, arguments) => {
            into.insert(name.name.clone());
            arguments.iter().for_each(|one| names_in(&one.value, into));
        }
        ValueKind::Iterate(functions, arguments) => {
            into.extend(functions.iter().map(|(name, _)| name.name.clone()));
            arguments.iter().for_each(|one| names_in(&one.value, into));
        }
        ValueKind::Cases(cases) => {
            for (value, when) in cases {
                names_in(value, into);
                let compared = when.iter().flat_map(ast::Either::comparisons);
                compared.flat_map(|one| [&one.left, &one.right]).for_each(|side| names_in(side, into));
            }
        }
    }
}
