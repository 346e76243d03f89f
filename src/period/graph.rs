//! The phases of a system as a graph: for people line by line, and as a transition system that can be drawn.

use std::collections::{BTreeMap, BTreeSet};

use super::course::Course;
use super::told::test_after;
use super::{Edge, End, Failure, Next, Period, Phase, Test, in_case_after, stretch};
use crate::name::Name;
use crate::term::Term;
use crate::transition_system::{Builder, Ending, Label, Mark, TransitionSystem};
use crate::value::Value;

/// The most characters of one piece of text in a picture.
const WIDE: usize = 32;

/// What each component is doing in a phase: `DEnv, MoveTo in BF`; in a mission of several states, `Mission: Carry`.
pub fn behaviour(phase: &Phase, names: &[String]) -> String {
    let one = |(name, loops): (&String, &Vec<Name>)| {
        let mut loops: Vec<&str> = loops.iter().map(Name::as_str).collect();
        loops.dedup();
        loops.reverse();
        match loops.last() {
            None => name.clone(),
            Some(outermost) if *outermost == name => loops.join(" in "),
            Some(_) => format!("{name}: {}", loops.join(" in ")),
        }
    };
    names.iter().zip(&phase.loops).map(one).collect::<Vec<_>>().join(", ")
}

/// The phases with their edges, a line each: from, to, when, and how long the round takes.
pub fn lines(period: &Period) -> Vec<String> {
    let mut lines = Vec::new();
    for edge in &period.initial {
        lines.push(format!("start{}", arrow(edge, None)));
    }
    for (number, phase) in period.phases.iter().enumerate() {
        lines.push(format!("phase {}: {}", number + 1, behaviour(phase, &period.names)));
        let first = phase.edges.first().map(|edge| &edge.segments);
        let differ = phase.edges.iter().any(|edge| Some(&edge.segments) != first);
        for edge in &phase.edges {
            let stretches = edge.segments.iter().map(|segment| stretch(&segment.duration, &segment.observed));
            let shown = if differ { format!(": {}", Term::seq(stretches)) } else { String::new() };
            let round = phase.rounds(number).next().map(|round| &round.map);
            lines.push(format!(" {}{shown}", arrow(edge, round)));
        }
    }
    lines
}

/// What is to be said of it besides: warnings, and why there is no period where nothing comes back, or where the run is known
/// to end though its phases come back.
pub fn remarks(period: &Period, course: Option<&Course>) -> Vec<String> {
    let repeats = period.repeats();
    let stops_time = |warning: &Failure| matches!(warning, Failure::Livelock { when, .. } if when.is_empty());
    let told = |warning: &Failure| {
        let word = if !repeats && stops_time(warning) { "no period" } else { "warning" };
        format!("{word}: {warning}")
    };
    let warnings = period.warnings.iter().filter_map(|warning| of_run(warning, course));
    let mut lines: Vec<String> = warnings.map(|warning| told(&warning)).collect();
    if let Some(Course::Ends(End::Livelock { cycle, changes }, _)) = course {
        let reached = Failure::Livelock { cycle: cycle.clone(), changes: changes.clone(), when: Vec::new() };
        let told = !repeats && period.warnings.iter().any(stops_time);
        lines.extend((!told).then(|| format!("no period: {reached}")));
    } else if !repeats && !period.warnings.iter().any(stops_time) {
        let why = if lines.is_empty() { "the run ends" } else { "no phase comes back" };
        lines.push(format!("no period: {why}"));
    } else if repeats && matches!(course, Some(Course::Ends(..))) {
        lines.push("no period: the run ends".to_string());
    }
    lines
}

/// A warning as far as it is true of the run, if it is known what comes of that: it does not come to wait, or it does.
fn of_run(warning: &Failure, course: Option<&Course>) -> Option<Failure> {
    match (warning, course) {
        (Failure::MayWait { .. }, Some(Course::Repeats { .. })) => None,
        // Nor does it come to where it would go round in no time.
        (Failure::Livelock { when, .. }, Some(Course::Repeats { .. })) if !when.is_empty() => None,
        (Failure::MayWait { blocked, .. }, Some(Course::Ends(end, _))) => {
            let there = matches!(end, End::Silent { blocked: there, .. } if there.contains(blocked));
            there.then(|| Failure::Unmatched(blocked.clone()))
        }
        _ => Some(warning.clone()),
    }
}

fn arrow(edge: &Edge, round: Option<&BTreeMap<Name, Value>>) -> String {
    let lasting = match edge.duration() {
        Ok(time) if time.is_zero() => String::new(),
        Ok(time) => format!(", lasting {time}"),
        Err(_) => String::new(),
    };
    format!(" -> {}{lasting}{}", place(&edge.next), in_case_after(&edge.tests, round))
}

fn place(next: &Next) -> String {
    match next {
        Next::Phase(number) => format!("phase {}", number + 1),
        Next::End(end) => ending(end),
    }
}

/// How a run ends, in words.
pub fn ending(end: &End) -> String {
    match end {
        End::Stopped => "stops".to_string(),
        End::Aborted => "aborts".to_string(),
        End::Livelock { cycle, .. } => {
            let cycle: Vec<&str> = cycle.iter().map(Name::as_str).collect();
            format!("goes round in no time ({})", cycle.join(", "))
        }
        End::Silent { blocked, .. } if blocked.is_empty() => "idles".to_string(),
        End::Silent { blocked, .. } => blocked.iter().map(|one| one.to_string()).collect::<Vec<_>>().join("; "),
    }
}

/// The graph as a transition system: state 0 is the start, then the phases by their numbers, then the ends.
pub fn system(period: &Period) -> TransitionSystem {
    let mut builder = Builder::new();
    let mark = |lines: Vec<String>, ending: Ending| Mark {
        ending,
        shown: lines.iter().map(|line| short(line)).collect::<BTreeSet<String>>(),
        waits: true,
    };
    let start = builder.state(mark(Vec::new(), Ending::Running));
    let phases: Vec<u32> = period
        .phases
        .iter()
        .map(|phase| builder.state(mark(vec![behaviour(phase, &period.names)], Ending::Running)))
        .collect();
    let mut ends: Vec<(End, u32)> = Vec::new();
    let sources = std::iter::once((start, &period.initial));
    let rounds = phases.iter().copied().zip(period.phases.iter().map(|phase| &phase.edges));
    for (place, (from, edges)) in sources.chain(rounds).enumerate() {
        let number = place.checked_sub(1);
        let phase = number.and_then(|number| Some((number, period.phases.get(number)?)));
        let round = phase.and_then(|(number, phase)| phase.rounds(number).next().map(|round| &round.map));
        let tests: Vec<Vec<String>> = edges.iter().map(|edge| tests_of(edge, round)).collect();
        for edge in edges {
            let to = match &edge.next {
                Next::Phase(number) => phases.get(*number).copied().unwrap_or(start),
                Next::End(end) => match ends.iter().find(|(known, _)| known == end) {
                    Some((_, state)) => *state,
                    None => {
                        let state = builder.state(match end {
                            End::Stopped => mark(Vec::new(), Ending::Stopped(String::new())),
                            End::Aborted => mark(Vec::new(), Ending::Aborted),
                            other => mark(vec![ending(other)], Ending::Running),
                        });
                        ends.push((end.clone(), state));
                        state
                    }
                },
            };
            let label = builder.label(Label::Act(caption(edge, round, &tests)));
            builder.transition(from, label, to);
        }
    }
    builder.finish(start, None)
}

/// The tests of an edge, one by one; long ones over the variables after the round, where that is shorter.
fn tests_of(edge: &Edge, round: Option<&BTreeMap<Name, Value>>) -> Vec<String> {
    let text = |test: &Test| {
        let text = test.to_string();
        let long = text.chars().count() > WIDE / 2;
        let after = test_after(test, round).filter(|_| long).map(|after| format!("then {after}"));
        after.filter(|after| after.chars().count() < text.chars().count()).unwrap_or(text)
    };
    edge.tests.iter().map(text).collect()
}

/// When an edge is taken, and how long its round lasts, given the tests of all edges from its phase. Tests that tell it from
/// the others come first, and such as are easily read: what is cut is the rest.
fn caption(edge: &Edge, round: Option<&BTreeMap<Name, Value>>, all: &[Vec<String>]) -> String {
    let time = edge.duration().ok().filter(|time| !time.is_zero()).map(|time| short(&time.to_string()));
    let mut tests = tests_of(edge, round);
    let shared = |test: &String| all.iter().filter(|other| other.contains(test)).count();
    tests.sort_by_cached_key(|test| (shared(test), test.chars().count()));
    let tests = (!tests.is_empty()).then(|| short(&tests.join(" and ")));
    tests.into_iter().chain(time).collect::<Vec<_>>().join("; ")
}

fn short(text: &str) -> String {
    if text.chars().count() <= WIDE {
        return text.to_string();
    }
    let head: String = text.chars().take(WIDE - 1).collect();
    format!("{head}…")
}
