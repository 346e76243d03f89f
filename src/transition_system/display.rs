//! Systems for people and for other programs: a summary, DOT, JSON.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Value as Json, json};

use super::{Ending, Label, TransitionSystem};

/// How many states a summary names one by one.
const MOST_NAMED: usize = 8;

/// What is to be known of a system, a line each: its size, its ends, what is wrong in it, and a bound that was hit.
pub fn summary(system: &TransitionSystem) -> Vec<String> {
    let found = system.analysis();
    let count = |number: usize, one: &str| format!("{number} {one}{}", if number == 1 { "" } else { "s" });
    let mut lines = Vec::new();
    if let Some(cut) = system.cut {
        lines.push(format!("not the whole system: {cut}, {} not looked into", count(system.unexplored(), "state")));
    }
    lines.push(format!("{}, {}", count(found.states, "state"), count(found.transitions, "transition")));
    lines.push(format!("outcomes: {} stopped, {} aborted", found.stopped, found.aborted));
    let known = if system.cut.is_some() { " found" } else { "" };
    for (word, states) in
        [("deadlock", &found.deadlocks), ("livelock", &found.livelocks), ("time-stop", &found.time_stops)]
    {
        let named: Vec<String> = states.iter().take(MOST_NAMED).map(u32::to_string).collect();
        let more = if states.len() > MOST_NAMED { ", …" } else { "" };
        lines.push(match states.len() {
            0 => format!("{word}s: none{known}"),
            1 => format!("{word}s: in state {}", named.concat()),
            number => format!("{word}s: in {number} states: {}{more}", named.join(", ")),
        });
    }
    lines
}

/// All labels from one state to another, together.
pub(super) fn edges(system: &TransitionSystem) -> BTreeMap<(u32, u32), Vec<String>> {
    let mut edges: BTreeMap<(u32, u32), Vec<String>> = BTreeMap::new();
    for state in 0..system.states() as u32 {
        for (label, to) in system.steps(state) {
            let label = match system.label(*label) {
                Label::Tau => "τ".to_string(),
                label => label.to_string(),
            };
            edges.entry((state, *to)).or_default().push(label);
        }
    }
    edges
}

/// What a state's mark says in a picture; empty when it runs and shows nothing.
pub(super) fn caption(system: &TransitionSystem, state: u32) -> Vec<String> {
    let mark = system.mark(state);
    let mut lines: Vec<String> = mark.shown.iter().cloned().collect();
    if mark.ending != Ending::Running {
        lines.push(mark.ending.to_string());
    }
    if system.is_open(state) {
        lines.push("…".to_string());
    }
    lines
}

/// A text between quotation marks.
fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', " ")
}

/// The system in the language of Graphviz under a title, by which it is told from others in the same file.
pub fn titled_dot(system: &TransitionSystem, title: &str) -> String {
    let title = quoted(title);
    dot(system).replacen("digraph system {\n", &format!("digraph \"{title}\" {{\n  label=\"{title}\";\n"), 1)
}

/// The system in the language of Graphviz.
pub fn dot(system: &TransitionSystem) -> String {
    let lines = |lines: &[String]| lines.iter().map(|line| quoted(line)).collect::<Vec<_>>().join("\\n");
    let mut text = String::from("digraph system {\n");
    if let Some(cut) = system.cut {
        let _ = writeln!(text, "  label=\"not the whole system: {cut}\";");
    }
    text.push_str("  node [shape=circle, fontname=\"sans-serif\"];\n  edge [fontname=\"sans-serif\"];\n");
    text.push_str("  start [shape=point, label=\"\"];\n");
    for state in 0..system.states() as u32 {
        let mut caption = caption(system, state);
        caption.insert(0, state.to_string());
        let shape = match system.mark(state).ending {
            Ending::Running => "circle",
            Ending::Stopped(_) => "doublecircle",
            Ending::Aborted => "box",
        };
        let _ = writeln!(text, "  {state} [shape={shape}, label=\"{}\"];", lines(&caption));
    }
    let _ = writeln!(text, "  start -> {};", system.initial());
    for ((from, to), labels) in edges(system) {
        let _ = writeln!(text, "  {from} -> {to} [label=\"{}\"];", lines(&labels));
    }
    text.push_str("}\n");
    text
}

/// The system as JSON: labels once, and a transition as source, place of the label, target.
pub fn json(system: &TransitionSystem) -> Json {
    let states: Vec<Json> = (0..system.states() as u32)
        .map(|state| {
            let mark = system.mark(state);
            let (ending, results) = match &mark.ending {
                Ending::Running => ("running", ""),
                Ending::Stopped(results) => ("stopped", results.as_str()),
                Ending::Aborted => ("aborted", ""),
            };
            let mut object = json!({ "ending": ending });
            if let Some(map) = object.as_object_mut() {
                if !results.is_empty() {
                    map.insert("results".into(), json!(results));
                }
                if !mark.shown.is_empty() {
                    map.insert("shows".into(), json!(mark.shown));
                }
                if system.is_open(state) {
                    map.insert("open".into(), json!(true));
                }
            }
            object
        })
        .collect();
    let transitions: Vec<[u32; 3]> = (0..system.states() as u32)
        .flat_map(|state| system.steps(state).iter().map(move |(label, to)| [state, *label, *to]))
        .collect();
    let labels: Vec<String> = system.labels().iter().map(ToString::to_string).collect();
    let found = system.analysis();
    let mut object = json!({
        "initial": system.initial(), "labels": labels, "states": states, "transitions": transitions,
        "deadlocks": found.deadlocks, "livelocks": found.livelocks, "timestops": found.time_stops,
    });
    if let (Some(cut), Some(map)) = (system.cut, object.as_object_mut()) {
        map.insert("cut".into(), json!(cut.to_string()));
    }
    object
}
