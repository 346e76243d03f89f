//! A closed instance of a process with symbolic parameters: by values that are given, or that meet what is assumed.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

use crate::assumption::Assumptions;
use crate::definition::{Definition, Definitions};
use crate::lower::{Class, Environment, Quantity};
use crate::model::Model;
use crate::name::Name;
use crate::scope::{calls, metavariables};
use crate::term::Term;
use crate::value::{Relation, Value};

/// The most choices of a value made in search of all of them.
const MOST_CHOICES: usize = 200_000;

/// A closed process.
#[derive(Clone, Debug)]
pub struct Closed {
    /// The process.
    pub term: Term,
    /// The definitions that it refers to, closed.
    pub definitions: Definitions,
    /// What was put in for the parameters, and whether it was chosen here.
    pub values: Vec<(Name, Value, bool)>,
}

/// Puts values in for the parameters of a process: those given, and for the others the first of a fixed list that meet
/// the assumptions.
///
/// # Errors
/// Why there is no such instance, in words.
pub fn close(term: &Term, environment: &Environment, given: &[(Name, Value)]) -> Result<Closed, String> {
    if let Some(name) = metavariables(term).into_iter().next() {
        return Err(format!("`{name}` stands for anything; a run needs a process without it"));
    }
    let reached = reached(term, &environment.definitions);
    let mut names = parameters(environment, term.clone(), &reached);
    for (name, value) in given {
        match environment.quantity(name) {
            Some(Quantity::Parameter { constant: None, .. }) => {}
            Some(Quantity::Parameter { .. }) => return Err(format!("`{name}` has a value already")),
            _ => return Err(format!("there is no parameter `{name}`")),
        }
        if !value.variables().is_empty() {
            return Err(format!("the value of `{name}` must be a number, not `{value}`"));
        }
        names.insert(name.clone());
    }
    // What is assumed of a parameter may speak of others.
    let assumptions = &environment.assumptions;
    loop {
        let more: BTreeSet<Name> = assumptions
            .iter()
            .map(|(_, value)| value.variables())
            .filter(|used| used.iter().any(|name| names.contains(name)))
            .flatten()
            .filter(|name| !names.contains(name))
            .collect();
        if more.is_empty() {
            break;
        }
        names.extend(more);
    }
    let mut search = Search { assumptions, environment, known: given.iter().cloned().collect(), choices: 0 };
    if let Some(broken) = search.broken(None) {
        return Err(format!("the values given break what is assumed: {broken}"));
    }
    let open: Vec<Name> = names.iter().filter(|name| !search.known.contains_key(name)).cloned().collect();
    if !search.fill(&open) {
        let list: Vec<&str> = open.iter().map(Name::as_str).collect();
        return Err(format!(
            "no values found for {} that meet what is assumed; give them: `with {} = …`",
            list.join(", "),
            list.join(" = …, ")
        ));
    }
    let known = search.known;
    let none = Definitions::default();
    let model = Model::new(&none);
    let term = model.put_in(term, &known, 0).map_err(|error| error.why)?;
    let definitions = closed(&environment.definitions, &reached, &known)?;
    let values = known.into_iter().map(|(name, value)| {
        let chosen = open.contains(&name);
        (name, value, chosen)
    });
    Ok(Closed { term, definitions, values: values.collect() })
}

fn closed(
    definitions: &Definitions,
    reached: &BTreeSet<Name>,
    known: &BTreeMap<Name, Value>,
) -> Result<Definitions, String> {
    let mut all = Definitions::default();
    let model = Model::new(definitions);
    for definition in reached.iter().filter_map(|name| definitions.get(name)) {
        let mut known = known.clone();
        known.retain(|name, _| !definition.parameters.contains(name));
        let body = model.put_in(&definition.body, &known, 0).map_err(|error| error.why)?;
        all.insert(Definition { body, ..definition.clone() });
    }
    Ok(all)
}

/// The definitions that a term refers to, directly or through others.
pub fn reached(term: &Term, definitions: &Definitions) -> BTreeSet<Name> {
    let mut all = BTreeSet::new();
    let mut open: Vec<Name> = calls(term).into_iter().collect();
    while let Some(name) = open.pop() {
        if let Some(definition) = definitions.get(&name)
            && all.insert(name)
        {
            open.extend(calls(&definition.body));
        }
    }
    all
}

/// The declared parameters without a value that are read in a term or in what it refers to.
fn parameters(environment: &Environment, term: Term, reached: &BTreeSet<Name>) -> BTreeSet<Name> {
    let mut names = crate::scope::read_names(&term);
    for definition in reached.iter().filter_map(|name| environment.definitions.get(name)) {
        let own = crate::scope::read_names(&definition.body);
        names.extend(own.into_iter().filter(|name| !definition.parameters.contains(name)));
    }
    names.retain(|name| matches!(environment.quantity(name), Some(Quantity::Parameter { constant: None, .. })));
    names
}

struct Search<'a> {
    assumptions: &'a Assumptions,
    environment: &'a Environment,
    known: BTreeMap<Name, Value>,
    choices: usize,
}

impl Search<'_> {
    /// An assumption that is false by now, among those that mention this name.
    fn broken(&self, name: Option<&Name>) -> Option<String> {
        let concerns = |used: &BTreeSet<Name>| {
            name.is_none_or(|name| used.contains(name)) && used.iter().all(|name| self.known.contains_key(name))
        };
        for natural in self.assumptions.naturals() {
            let Some(value) = self.known.get(natural) else { continue };
            if !value.as_rational().is_some_and(|number| number.is_integer() && !number.is_negative()) {
                return Some(format!("{natural} is natural, not {value}"));
            }
        }
        for (relation, value) in self.assumptions.iter().filter(|(_, value)| concerns(&value.variables())) {
            let number = value.substitute(&self.known).ok().and_then(|value| value.as_rational());
            let holds = number.is_some_and(|number| holds(relation, &number));
            if !holds {
                return Some(format!("{value} {} 0", relation.symbol()));
            }
        }
        None
    }

    /// The numbers that bound a parameter, by what is assumed of it and the values that are known; those between them, and
    /// those one further.
    fn bounds(&self, name: &Name) -> Vec<Value> {
        let mut bounds = BTreeSet::new();
        for (_, value) in self.assumptions.iter().filter(|(_, value)| value.mentions(name)) {
            let mut others = self.known.clone();
            others.remove(name);
            let Some((factor, rest)) = value.substitute(&others).ok().and_then(|value| value.linear_in(name)) else {
                continue;
            };
            bounds.extend(rest.neg().and_then(|rest| rest.div(&factor)).ok().and_then(|bound| bound.as_rational()));
        }
        let bounds: Vec<BigRational> = bounds.into_iter().collect();
        let between = bounds.windows(2).map(|pair| (&pair[0] + &pair[1]) / BigRational::from_integer(2.into()));
        let beside =
            bounds.iter().flat_map(|bound| [0, 1, -1].map(|step| bound + BigRational::from_integer(step.into())));
        between.chain(beside).map(Value::rational).collect()
    }

    /// Finds a value for each of these names, in this order.
    fn fill(&mut self, open: &[Name]) -> bool {
        let Some((name, rest)) = open.split_first() else { return true };
        for value in candidates(self.environment, name).into_iter().chain(self.bounds(name)) {
            self.choices += 1;
            if self.choices > MOST_CHOICES {
                break;
            }
            self.known.insert(name.clone(), value);
            if self.broken(Some(name)).is_none() && self.fill(rest) {
                return true;
            }
        }
        self.known.remove(name);
        false
    }
}

fn holds(relation: Relation, number: &BigRational) -> bool {
    relation.holds(number.cmp(&BigRational::zero()))
}

/// What may be put in for a parameter, the simplest first.
fn candidates(environment: &Environment, name: &Name) -> Vec<Value> {
    if let Some(Quantity::Parameter { class: Class::Distribution, .. }) = environment.quantity(name) {
        let half = Value::rational(BigRational::new(BigInt::from(1), BigInt::from(2)));
        let point = |number| Value::distribution("Point", vec![Value::integer(number)]);
        let coin = point(0).and_then(|zero| Value::distribution("Mix", vec![half.clone(), zero, half, point(1)?]));
        return coin.into_iter().collect();
    }
    let part = |top: i64, bottom: i64| Value::rational(BigRational::new(BigInt::from(top), BigInt::from(bottom)));
    let whole = [1, 2, 3, 0, -1, 4, 5, 10, -2, 100].map(Value::integer);
    whole.into_iter().chain([part(1, 2), part(3, 2), part(1, 4), part(1, 10)]).collect()
}
