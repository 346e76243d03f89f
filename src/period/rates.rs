//! How often each component goes round in one period: as often as its ports are used, in the ratios of the balance equations.

use std::collections::HashMap;

use num_traits::ToPrimitive;

use super::drift;
use super::explore::explore;
use super::ports::System;
use super::{Edge, Next, Period, Phase, Surroundings};
use crate::name::Name;
use crate::value::Value;

/// The rounds of the components in one period, by the ports of which it is known how often a round uses them. A component
/// without ports goes round as often as its own round fits into the period. Of what is not known, or never goes round,
/// nothing is said; nothing at all where there is no such port, or the phases are not gone through in one way only.
pub(super) fn in_one_period(period: &Period, run: &Surroundings<'_>) -> Option<Vec<(String, u64)>> {
    let closed = System::of(&period.components, run.definitions);
    let equations = closed.equations();
    if equations.is_empty() {
        return None;
    }
    let cycle = cycle(&period.initial, &period.phases)?;
    let mut used: HashMap<&Name, u64> = HashMap::new();
    for (port, _) in cycle.iter().flat_map(|edge| &edge.communications) {
        *used.entry(port).or_default() += 1;
    }
    let lasting = || cycle.iter().try_fold(Value::zero(), |sum, edge| sum.add(&edge.duration().ok()?).ok());
    let mut by_ports: Vec<Option<u64>> = vec![None; closed.names.len()];
    for equation in &equations {
        let times = used.get(&equation.port).copied().unwrap_or(0);
        for (component, each) in [equation.writer, equation.reader] {
            by_ports[component] = times.checked_div(each as u64);
        }
    }
    let silent = |component: usize| {
        if !closed.reads[component].is_empty() || !closed.writes[component].is_empty() {
            return None;
        }
        let own = [period.components.get(component)?.clone()];
        let graph = explore(&own, &System::of(&own, run.definitions), run).ok()?;
        let round = drift::round(&graph.initial, &graph.phases)?;
        lasting()?.div(&round).ok()?.as_rational()?.to_integer().to_u64()
    };
    let all = closed.names.iter().zip(by_ports).enumerate().filter_map(|(component, (name, by_ports))| {
        let rounds = by_ports.or_else(|| silent(component));
        rounds.filter(|rounds| *rounds > 0).map(|rounds| (name.clone(), rounds))
    });
    Some(all.collect::<Vec<_>>()).filter(|rounds| !rounds.is_empty())
}

/// The rounds from a phase back to it, where there is one way only.
fn cycle<'a>(initial: &'a [Edge], phases: &'a [Phase]) -> Option<Vec<&'a Edge>> {
    let (mut ways, mut passed): (&[Edge], Vec<&Edge>) = (initial, Vec::new());
    let mut entered: Vec<Option<usize>> = vec![None; phases.len()];
    loop {
        let [edge] = ways else { return None };
        passed.push(edge);
        let Next::Phase(number) = edge.next else { return None };
        if let Some(start) = entered.get(number).copied()? {
            return Some(passed.split_off(start));
        }
        *entered.get_mut(number)? = Some(passed.len());
        ways = &phases.get(number)?.edges;
    }
}
