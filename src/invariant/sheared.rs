//! The phases in other coordinates: some variables are written as what they are more than another one.

use std::collections::{BTreeMap, BTreeSet};

use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Phase, Test};
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::{Value, ValueError};

/// The same phases where each of `others` stands for what it is more than `base`, in all phases that have both: what
/// depends on differences alone then depends on fewer variables. It says the same of the system, as each value of the one is
/// one value of the other.
///
/// # Errors
/// When a value has no normal form, or a way leaves a variable without one.
pub fn sheared(period: &Period, base: &Name, others: &BTreeSet<Name>) -> Result<Period, ValueError> {
    let within = |phase: &Phase| -> Vec<Name> {
        let both = phase.variables.contains(base);
        phase.variables.iter().filter(|name| both && *name != base && others.contains(*name)).cloned().collect()
    };
    let moved: Vec<Vec<Name>> = period.phases.iter().map(within).collect();
    let base_value = Value::variable(base);
    let put = |names: &[Name]| -> Result<BTreeMap<Name, Value>, ValueError> {
        names.iter().map(|name| Ok((name.clone(), Value::variable(name).add(&base_value)?))).collect()
    };
    let turned = |edge: &Edge, from: &BTreeMap<Name, Value>| -> Result<Edge, ValueError> {
        let mut edge = written(edge, from)?;
        let Next::Phase(next) = edge.next else { return Ok(edge) };
        let names = moved.get(next).map_or(&[][..], Vec::as_slice);
        if !names.is_empty() {
            let lost = || ValueError("a way gives no value to a variable".to_string());
            let image = edge.map.get(base).cloned().ok_or_else(lost)?;
            for name in names {
                let value = edge.map.get_mut(name).ok_or_else(lost)?;
                *value = value.sub(&image)?;
            }
        }
        Ok(edge)
    };
    let mut all = period.clone();
    for edge in &mut all.initial {
        *edge = turned(edge, &BTreeMap::new())?;
    }
    for (phase, names) in all.phases.iter_mut().zip(&moved) {
        let from = put(names)?;
        for edge in &mut phase.edges {
            *edge = turned(edge, &from)?;
        }
    }
    Ok(all)
}

/// A way with other values for the variables of the phase that it leaves.
fn written(edge: &Edge, from: &BTreeMap<Name, Value>) -> Result<Edge, ValueError> {
    let terms = |terms: &mut Vec<Term>| -> Result<(), ValueError> {
        for term in terms {
            *term = substitute_values(term, from).map_err(|stuck| ValueError(stuck.0))?;
        }
        Ok(())
    };
    let mut edge = edge.clone();
    edge.tests = edge.tests.iter().map(|test| test.substitute(from)).collect::<Result<Vec<Test>, _>>()?;
    edge.after.iter_mut().for_each(|after| *after = None);
    for segment in &mut edge.segments {
        segment.duration = segment.duration.substitute(from)?;
        terms(&mut segment.observed)?;
    }
    if let Next::End(End::Silent { observed, .. }) = &mut edge.next {
        terms(observed)?;
    }
    let values = edge.map.values_mut().chain(edge.communications.iter_mut().map(|(_, value)| value));
    for value in values.chain(edge.draws.iter_mut().map(|(_, distribution)| distribution)) {
        *value = value.substitute(from)?;
    }
    Ok(edge)
}
