//! Regions: a map with maxima and conditions is affine where its guards hold.

use super::NoClosedForm;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// A comparison with 0 that holds at a point, and as long as it does the map has the same affine form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Guard {
    pub(super) relation: Relation,
    pub(super) value: Value,
}

/// An expression as it is near a point: its maxima and conditions replaced by what they are there, and the guards.
pub(super) fn resolve(
    expression: &Value,
    variable: &Name,
    point: &Value,
    known: &Assumptions,
) -> Result<(Value, Vec<Guard>), NoClosedForm> {
    let mut guards = Vec::new();
    let value = local(expression, variable, point, known, &mut guards)?;
    guards.retain(|guard| guard.value.mentions(variable));
    guards.sort_by(|a, b| (a.relation, &a.value).cmp(&(b.relation, &b.value)));
    guards.dedup();
    Ok((value, guards))
}

fn local(
    expression: &Value,
    variable: &Name,
    point: &Value,
    known: &Assumptions,
    guards: &mut Vec<Guard>,
) -> Result<Value, NoClosedForm> {
    let mut value = expression.clone();
    for atom in expression.atoms().into_iter().filter(|atom| atom.mentions(variable)) {
        let image = match &atom {
            Atom::Variable(_) => continue,
            Atom::Positive(condition) => {
                let condition = local(condition, variable, point, known, guards)?;
                let here = condition.with(variable, point)?;
                let Some(holds) = known.decide(Relation::Gtr, &here, &Value::zero()) else {
                    return Err(NoClosedForm(format!("it must be known whether {here} > 0")));
                };
                let relation = if holds { Relation::Gtr } else { Relation::Lte };
                guards.push(Guard { relation, value: condition });
                Value::integer(i64::from(holds))
            }
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(local(element, variable, point, known, guards)?);
                }
                greatest(&all, variable, point, known, guards)?
            }
            _ => return Err(NoClosedForm(format!("{expression} is not affine in {variable}, not even by pieces"))),
        };
        value = value.with_atom(&atom, &image)?;
    }
    Ok(value)
}

/// The greatest of some values at a point, and that it is.
fn greatest(
    all: &[Value],
    variable: &Name,
    point: &Value,
    known: &Assumptions,
    guards: &mut Vec<Guard>,
) -> Result<Value, NoClosedForm> {
    let here = all.iter().map(|one| one.with(variable, point)).collect::<Result<Vec<_>, _>>()?;
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
    Err(NoClosedForm(format!("it must be known whether {left} >= {right}")))
}
