//! What is known of variables that depend on random draws: no closed form, since each round draws anew, but their means.

use std::collections::{BTreeMap, BTreeSet};

use super::PhaseFlow;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::recurrence::{Closed, solve_together};
use crate::value::{Value, View};

impl PhaseFlow {
    /// The variables that depend on what is drawn in this or an earlier round.
    pub(super) fn drawn(&self) -> BTreeSet<Name> {
        let mut drawn: BTreeSet<Name> = self.draws.iter().map(|(name, _)| name.clone()).collect();
        loop {
            let before = drawn.len();
            for (name, image) in self.maps.iter().flat_map(|(_, map)| map) {
                if image.variables().iter().any(|read| drawn.contains(read)) {
                    drawn.insert(name.clone());
                }
            }
            if drawn.len() == before {
                return drawn;
            }
        }
    }

    /// The closed forms of the means of the variables that depend on draws, from a known start, where a round always comes
    /// back and is affine in the variables and in what is drawn; none otherwise.
    ///
    /// The mean of an affine image is the image of the means, and what is drawn in a round is independent of what was before,
    /// but for the parameters of its distribution, in which its mean is affine.
    pub fn means(&self, index: &Name, assumptions: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<(Name, Closed)> {
        self.mean_map()
            .and_then(|map| {
                let starts = map.keys().map(|name| (name.clone(), self.named.start(name))).collect();
                solve_together(&map, &starts, index, &self.named.known(assumptions), stop).ok()
            })
            .map_or_else(Vec::new, |all| {
                let drawn = self.drawn();
                all.into_iter().filter(|(name, _)| drawn.contains(name)).collect()
            })
    }

    /// The map of the means of the variables.
    fn mean_map(&self) -> Option<BTreeMap<Name, Value>> {
        let [(_, map)] = self.maps.as_slice() else { return None };
        if self.draws.is_empty() || !self.exits.is_empty() || self.guard.iter().any(|tests| !tests.is_empty()) {
            return None;
        }
        let mut random: BTreeSet<Name> = self.draws.iter().map(|(name, _)| name.clone()).collect();
        random
            .extend(map.iter().filter(|(name, image)| **image != Value::variable(name)).map(|(name, _)| name.clone()));
        let mut means: BTreeMap<Name, Value> = BTreeMap::new();
        for (name, from) in &self.draws {
            let mean = mean(from)?;
            means.insert(name.clone(), affine(&mean, &random)?.substitute(&means).ok()?);
        }
        let changing = map.iter().filter(|(name, image)| **image != Value::variable(name));
        changing.map(|(name, image)| Some((name.clone(), affine(image, &random)?.substitute(&means).ok()?))).collect()
    }
}

/// The value, if it is a sum of multiples of these names and of a rest, in which none of them stands.
fn affine<'v>(value: &'v Value, names: &BTreeSet<Name>) -> Option<&'v Value> {
    let mut rest = value.clone();
    for name in names {
        let (factor, more) = rest.linear_in(name)?;
        if factor.variables().iter().any(|read| names.contains(read)) {
            return None;
        }
        rest = more;
    }
    Some(value)
}

/// The mean of a distribution of numbers.
fn mean(distribution: &Value) -> Option<Value> {
    let View::Distribution(kind, parts) = distribution.view() else { return None };
    let half = |sum: Value| sum.div(&Value::integer(2)).ok();
    match (kind.as_str(), &parts[..]) {
        ("Normal", [mean, _]) | ("Poisson" | "Point", [mean]) => Some(mean.clone()),
        ("Uniform", [low, high]) => half(low.add(high).ok()?),
        ("Exp", [rate]) => Value::one().div(rate).ok(),
        ("Mix", parts) => parts.chunks(2).try_fold(Value::zero(), |sum, pair| match pair {
            [weight, part] => sum.add(&weight.mul(&mean(part)?).ok()?).ok(),
            _ => None,
        }),
        _ => None,
    }
}
