//! The period of a closed system: what its ports and their balance equations say, and what its run does.

use super::explore::{Graph, explore};
use super::ports;
use super::{Blocked, Failure, Period, Surroundings, drift, drifting, lonely, repeats, stuck};
use crate::term::Term;

/// The period; `strict`: what plainly leaves none is looked for first.
pub(super) fn analysed(components: &[Term], run: &Surroundings<'_>, strict: bool) -> Result<Period, Vec<Failure>> {
    let definitions = run.definitions;
    let components = ports::flatten(components, definitions);
    let closed = ports::System::of(&components, definitions);
    let groups = closed.groups();
    let mut warnings: Vec<Failure> = no_communication(&closed, &groups).into_iter().collect();
    let unmatched = closed.unmatched();
    let explored = (!unmatched.is_empty()).then(|| explore(&components, &closed, run));
    let (mut failures, others_go_on) = told(unmatched, explored.as_ref())?;
    if strict && !others_go_on && failures.iter().any(|failure| matches!(failure, Failure::Unmatched(_))) {
        failures.splice(0..0, warnings);
        return Err(failures);
    }
    warnings.append(&mut failures);
    let mismatch = closed.balance().err();
    if strict && mismatch.is_some() && closed.rests_on_equations() {
        let mut all = livelocks(&groups, &components, run)?;
        all.extend(mismatch);
        return Err(all);
    }
    warnings.extend(mismatch.clone());
    // Beside a reason why there is none, that nobody answers is said.
    let lonely: Vec<Failure> =
        warnings.iter().filter(|warning| matches!(warning, Failure::Lonely(_))).cloned().collect();
    let with_lonely = |mut failures: Vec<Failure>| {
        if !failures.contains(&Failure::Interrupted) {
            failures.extend(lonely.iter().cloned());
        }
        failures
    };
    let drift = if strict && groups.len() > 1 { apart(&groups, &components, run).map_err(with_lonely)? } else { None };
    // Where how often each goes round depends on a number of times, phases in every order may tell.
    if let Some(Failure::Drift { rational: None, .. }) = &drift {
        failures.extend(drift);
        failures.append(&mut warnings);
        return Err(failures);
    }
    let found = explored.unwrap_or_else(|| explore(&components, &closed, run));
    let graph = found.map_err(|failure| match drift {
        Some(drift) if failure != Failure::Interrupted => [drift].into_iter().chain(warnings.drain(..)).collect(),
        _ => with_lonely(vec![failure]),
    })?;
    let period = made(components, closed.names, graph, warnings);
    if strict && !period.repeats() {
        // Of all that waits for ever it is the reason.
        if let Some(mismatch) = mismatch {
            let mut all = livelocks(&groups, &period.components, run)?;
            all.push(mismatch);
            return Err(all);
        }
        // Parts without communication may each have a period; where every run ends, there is none.
        if groups.len() > 1 {
            return Err(period.warnings);
        }
    }
    Ok(period)
}

/// That groups share no port, where there are several.
fn no_communication(closed: &ports::System, groups: &[Vec<usize>]) -> Option<Failure> {
    let name = |index: &usize| closed.names.get(*index).cloned().unwrap_or_default();
    let named = || groups.iter().map(|group| group.iter().map(name).collect()).collect();
    (groups.len() > 1).then(|| Failure::NoCommunication { groups: named() })
}

/// What is said of ports that nobody answers as far as the run of the system tells, if it was asked, and whether that repeats.
fn told(
    unmatched: Vec<Failure>,
    explored: Option<&Result<Graph, Failure>>,
) -> Result<(Vec<Failure>, bool), Vec<Failure>> {
    match explored {
        None => Ok((unmatched, false)),
        Some(Ok(graph)) => {
            let judged = unmatched.into_iter().map(|failure| lonely::judged(failure, &graph.waiting)).collect();
            Ok((judged, repeats(&graph.phases)))
        }
        Some(Err(Failure::Interrupted)) => Err(vec![Failure::Interrupted]),
        Some(Err(_)) => Ok((unmatched.into_iter().map(lonely::unjudged).collect(), false)),
    }
}

/// What goes round in no time, of the groups that share no port: with it time stops for all.
fn livelocks(groups: &[Vec<usize>], components: &[Term], run: &Surroundings<'_>) -> Result<Vec<Failure>, Vec<Failure>> {
    let mut found = Vec::new();
    for group in groups {
        let own: Vec<Term> = group.iter().filter_map(|place| components.get(*place).cloned()).collect();
        match explore(&own, &ports::System::of(&own, run.definitions), run) {
            Err(Failure::Interrupted) => return Err(vec![Failure::Interrupted]),
            Ok(graph) => {
                let ends = stuck::ends(&graph.initial, &graph.phases).into_iter();
                found.extend(ends.filter(|end| matches!(end, Failure::Livelock { .. })));
            }
            Err(_) => {}
        }
    }
    Ok(found)
}

/// The period of these components, with what waits for ever among the warnings.
fn made(components: Vec<Term>, names: Vec<String>, graph: Graph, mut warnings: Vec<Failure>) -> Period {
    let Graph { initial, phases, stuck, in_every_order, along_the_run, .. } = graph;
    let waits = |blocked: &Blocked| {
        stuck.iter().any(|own: &Blocked| own.component == blocked.component && own.port == blocked.port)
    };
    // What the run shows is said in place of what may be.
    warnings.retain(|warning| !matches!(warning, Failure::Lonely(one) | Failure::Unanswered(one) if waits(one)));
    warnings.extend(stuck.into_iter().map(Failure::Unmatched));
    warnings.extend(stuck::ends(&initial, &phases));
    let mut once = Vec::new();
    for warning in warnings {
        if !once.contains(&warning) {
            once.push(warning);
        }
    }
    Period { components, names, initial, phases, warnings: once, in_every_order, along_the_run }
}

/// Why groups of components between which there is no port have no common period, each run on its own.
fn apart(groups: &[Vec<usize>], components: &[Term], run: &Surroundings<'_>) -> Result<Option<Failure>, Vec<Failure>> {
    let mut rounds = Vec::new();
    for group in groups {
        let own: Vec<Term> = group.iter().filter_map(|index| components.get(*index)).cloned().collect();
        let closed = ports::System::of(&own, run.definitions);
        let graph = explore(&own, &closed, run).map_err(|failure| vec![failure])?;
        let time = drift::round(&graph.initial, &graph.phases)
            .or_else(|| drift::round_of_values(&graph.initial, &graph.phases, run.assumptions));
        rounds.extend(time.map(|time| (closed.names.join(" with "), time)));
    }
    Ok(drifting(&rounds, run.assumptions))
}
