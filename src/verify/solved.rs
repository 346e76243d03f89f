//! What the equations among the assumptions say of a period: with `k*t = 1/2` assumed, a round `r + k*t*(g-r)` is
//! `r + (g-r)/2`, whose closed form shows the number.

use std::collections::{BTreeMap, BTreeSet};

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, Period, Test};
use crate::substitution::substitute_values;
use crate::value::{Relation, Value, ValueError};

/// The period with its maps, tests and stretches as the equations make them; none where they say nothing of it.
pub(super) fn plain(period: &Period, assumptions: &Assumptions) -> Option<Period> {
    let mut images = solutions(assumptions);
    let own: BTreeSet<&Name> = period.phases.iter().flat_map(|phase| &phase.variables).collect();
    images.retain(|name, image| !own.contains(name) && !own.iter().any(|own| image.mentions(own)));
    if images.is_empty() {
        return None;
    }
    let mut plain = period.clone();
    for edge in plain.initial.iter_mut().chain(plain.phases.iter_mut().flat_map(|phase| &mut phase.edges)) {
        *edge = put_in(edge, &images).ok()?;
    }
    Some(plain)
}

/// What the equations give, each of them for one variable, which no image mentions.
fn solutions(assumptions: &Assumptions) -> BTreeMap<Name, Value> {
    let mut found: BTreeMap<Name, Value> = BTreeMap::new();
    for (_, value) in assumptions.iter().filter(|(relation, _)| *relation == Relation::Eq) {
        let Ok(value) = value.substitute(&found) else { continue };
        let solved = value.variables().into_iter().find_map(|name| {
            let (factor, rest) = value.linear_in(&name)?;
            let sure = !assumptions.naturals().contains(&name)
                && assumptions.decide(Relation::Neq, &factor, &Value::zero()) == Some(true);
            let image = rest.neg().and_then(|rest| rest.div(&factor)).ok().filter(|image| !image.mentions(&name))?;
            sure.then_some((name, image))
        });
        let Some((name, image)) = solved else { continue };
        let only = BTreeMap::from([(name.clone(), image.clone())]);
        found = found
            .into_iter()
            .map(|(other, value)| (other, value.substitute(&only).unwrap_or(value)))
            .filter(|(_, value)| !value.mentions(&name))
            .collect();
        found.insert(name, image);
    }
    found
}

fn put_in(edge: &Edge, images: &BTreeMap<Name, Value>) -> Result<Edge, ValueError> {
    let test = |test: &Test| test.substitute(images);
    let mut edge = edge.clone();
    edge.tests = edge.tests.iter().map(test).collect::<Result<_, _>>()?;
    edge.after = edge.after.iter().map(|one| one.as_ref().map(test).transpose()).collect::<Result<_, _>>()?;
    for value in edge.map.values_mut() {
        *value = value.substitute(images)?;
    }
    for segment in &mut edge.segments {
        segment.duration = segment.duration.substitute(images)?;
        for term in &mut segment.observed {
            *term = substitute_values(term, images).map_err(|stuck| ValueError(stuck.0))?;
        }
    }
    for (_, value) in edge.communications.iter_mut().chain(&mut edge.draws) {
        *value = value.substitute(images)?;
    }
    Ok(edge)
}
