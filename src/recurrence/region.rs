//! Regions: a map with maxima and conditions is affine where its guards hold.

use std::collections::BTreeMap;

use super::interval::Interval;
use super::{Comparison, Unknown};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// A comparison with 0 that holds at a point, and as long as it does the map has the same affine form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Guard {
    pub(super) relation: Relation,
    pub(super) value: Value,
}

/// The guard that fails first, and after how many steps.
pub(super) type Failing = Option<(Value, Guard)>;

/// Takes in the index at which a guard fails, with the conditions under which it is that one: they are assumed from then
/// on. The one that fails first is kept.
pub(super) fn fails_at(
    least: &mut Failing,
    guard: &Guard,
    (at, conditions): (Value, Vec<Comparison>),
    known: &mut Assumptions,
    needed: &mut Vec<Comparison>,
) -> Result<(), Unknown> {
    conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    needed.extend(conditions);
    let sooner = match least {
        None => true,
        Some((other, _)) => {
            known.decide(Relation::Lss, &at, other).ok_or_else(|| Unknown::undecided(Relation::Lss, &at, other))?
        }
    };
    if sooner {
        *least = Some((at, guard.clone()));
    }
    Ok(())
}

/// The most places at which an expression may change its affine form.
const MOST_BREAKS: usize = 24;

/// Where `expression REL 0`, as intervals of the variable: between the places at which a maximum or condition
/// changes the expression is affine.
pub(super) fn solutions(
    expression: &Value,
    variable: &Name,
    relation: Relation,
    known: &Assumptions,
) -> Result<Vec<Interval>, Unknown> {
    let mut breaks = Vec::new();
    breaks_of(expression, variable, known, &mut breaks)?;
    let mut found: Vec<Interval> = Vec::new();
    let zero = Value::zero();
    for place in 0..=breaks.len() {
        let (low, high) = (place.checked_sub(1).map(|before| &breaks[before]), breaks.get(place));
        let sample = match (low, high) {
            (None, None) => zero.clone(),
            (Some(low), None) => low.add(&Value::one())?,
            (None, Some(high)) => high.sub(&Value::one())?,
            (Some(low), Some(high)) => low.add(high)?.div(&Value::integer(2))?,
        };
        let (affine, _) = resolve(expression, variable, &sample, known)?;
        let between = Interval::inside(low.cloned(), high.cloned());
        found.extend(between.where_affine(&affine, variable, relation, known)?);
        if let Some(high) = high {
            let here = expression.with(variable, high)?;
            match known.decide(relation, &here, &zero) {
                Some(true) => found.push(Interval::between(high.clone(), high.clone())),
                Some(false) => {}
                None => return Err(Unknown::undecided(relation, &here, &zero)),
            }
        }
    }
    let mut merged: Vec<Interval> = Vec::new();
    for interval in found {
        match merged.pop().map(|last| last.joined(&interval)) {
            Some(Ok(joined)) => merged.push(joined),
            Some(Err(last)) => merged.extend([last, interval]),
            None => merged.push(interval),
        }
    }
    Ok(merged)
}

/// The places where elements of a maximum are equal, or a condition is 0, in order.
pub(super) fn breaks_of(
    expression: &Value,
    variable: &Name,
    known: &Assumptions,
    breaks: &mut Vec<Value>,
) -> Result<(), Unknown> {
    for atom in expression.atoms().into_iter().filter(|atom| atom.mentions(variable)) {
        let mut differences = Vec::new();
        match &atom {
            Atom::Positive(condition) => differences.push(condition.clone()),
            Atom::Maximum(elements) => {
                for (place, element) in elements.iter().enumerate() {
                    differences.push(element.clone());
                    for other in &elements[place + 1..] {
                        differences.push(element.sub(other)?);
                    }
                }
            }
            _ => continue,
        }
        for difference in differences.into_iter().filter(|difference| difference.mentions(variable)) {
            let Some((factor, rest)) = difference.linear_in(variable) else {
                return Err(Unknown::because(format!("{difference} is not affine in {variable}")));
            };
            insert(rest.neg()?.div(&factor)?, known, breaks)?;
        }
    }
    if breaks.len() > MOST_BREAKS { Err(Unknown::because(format!("{expression} has too many parts"))) } else { Ok(()) }
}

fn insert(value: Value, known: &Assumptions, sorted: &mut Vec<Value>) -> Result<(), Unknown> {
    let mut place = 0;
    while let Some(other) = sorted.get(place) {
        if known.decide(Relation::Eq, &value, other) == Some(true) {
            return Ok(());
        }
        match known.decide(Relation::Lss, &value, other) {
            Some(true) => break,
            Some(false) => place += 1,
            None => return Err(Unknown::undecided(Relation::Lss, &value, other)),
        }
    }
    sorted.insert(place, value);
    Ok(())
}

/// Where a map is looked at: values of the variables that it is affine in, and of the index, if that has one.
pub(super) struct Point<'a> {
    pub(super) values: BTreeMap<Name, Value>,
    pub(super) index: Option<&'a Name>,
}

impl Point<'_> {
    fn mentioned(&self, value: &Value) -> bool {
        self.values.keys().any(|name| value.mentions(name))
    }

    fn in_atom(&self, atom: &Atom) -> bool {
        self.values.keys().any(|name| atom.mentions(name))
    }

    /// Whether an atom depends on the index alone.
    fn of_index(&self, atom: &Atom) -> bool {
        self.values.keys().all(|name| self.index == Some(name) || !atom.mentions(name))
    }

    fn at(&self, value: &Value) -> Result<Value, Unknown> {
        Ok(value.substitute(&self.values)?)
    }
}

/// An expression as it is near a point: its maxima and conditions replaced by what they are there, and the guards.
pub(super) fn resolve(
    expression: &Value,
    variable: &Name,
    point: &Value,
    known: &Assumptions,
) -> Result<(Value, Vec<Guard>), Unknown> {
    let point = Point { values: BTreeMap::from([(variable.clone(), point.clone())]), index: None };
    resolve_at(expression, &point, known)
}

/// The same in several variables, and in the index.
pub(super) fn resolve_at(
    expression: &Value,
    point: &Point<'_>,
    known: &Assumptions,
) -> Result<(Value, Vec<Guard>), Unknown> {
    let mut guards = Vec::new();
    let value = local(expression, point, known, &mut guards)?;
    guards.retain(|guard| point.mentioned(&guard.value));
    guards.sort_by(|a, b| (a.relation, &a.value).cmp(&(b.relation, &b.value)));
    guards.dedup();
    Ok((value, guards))
}

fn local(
    expression: &Value,
    point: &Point<'_>,
    known: &Assumptions,
    guards: &mut Vec<Guard>,
) -> Result<Value, Unknown> {
    let mut value = expression.clone();
    for atom in expression.atoms().into_iter().filter(|atom| point.in_atom(atom)) {
        let image = match &atom {
            Atom::Variable(_) => continue,
            Atom::Positive(condition) => {
                let condition = local(condition, point, known, guards)?;
                let here = point.at(&condition)?;
                let Some(holds) = known.decide(Relation::Gtr, &here, &Value::zero()) else {
                    return Err(Unknown::undecided(Relation::Gtr, &here, &Value::zero()));
                };
                let relation = if holds { Relation::Gtr } else { Relation::Lte };
                guards.push(Guard { relation, value: condition });
                Value::integer(i64::from(holds))
            }
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(local(element, point, known, guards)?);
                }
                greatest(&all, point, known, guards)?
            }
            other if point.of_index(other) => continue,
            _ => {
                let names = point.values.keys().filter(|name| point.index != Some(name));
                let names = names.map(Name::as_str).collect::<Vec<_>>().join(", ");
                return Err(Unknown::because(format!("{expression} is not affine in {names}, not even by pieces")));
            }
        };
        value = value.with_atom(&atom, &image)?;
    }
    Ok(value)
}

/// The greatest of some values at a point, and that it is.
fn greatest(all: &[Value], point: &Point<'_>, known: &Assumptions, guards: &mut Vec<Guard>) -> Result<Value, Unknown> {
    let here = all.iter().map(|one| point.at(one)).collect::<Result<Vec<_>, _>>()?;
    let mut missing = None;
    'candidates: for (place, candidate) in all.iter().enumerate() {
        for (at, other) in here.iter().enumerate().filter(|(at, _)| *at != place) {
            match known.decide(Relation::Gte, &here[place], other) {
                Some(true) => {}
                Some(false) => continue 'candidates,
                None => {
                    missing = Some((here[place].clone(), here[at].clone()));
                    continue 'candidates;
                }
            }
        }
        for other in all.iter().filter(|other| *other != candidate) {
            guards.push(Guard { relation: Relation::Gte, value: candidate.sub(other)? });
        }
        return Ok(candidate.clone());
    }
    let (left, right) = missing.unwrap_or_else(|| (here[0].clone(), Value::zero()));
    Err(Unknown::undecided(Relation::Gte, &left, &right))
}
