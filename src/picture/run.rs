//! A run as a picture: what each observer shows over time.

use std::collections::BTreeMap;

use super::{Line, Picture};
use crate::criteria::near;
use crate::term::{Node, Term};
use crate::timeline::{Ending, Timeline};

/// Stretches that are drawn, at most.
const MOST_DRAWN: usize = 2_000;

/// What a run shows over time, up to a time or to its end; empty where nothing is shown as a number.
pub fn of_run(title: &str, run: &Timeline, until: Option<f64>) -> Picture {
    let turns = usize::from(matches!(run.ending, Ending::Repeats(_)));
    let unrolled = run.unrolled(turns);
    let last = unrolled.iter().filter_map(|(_, start)| near(start)).fold(0.0, f64::max);
    let limit = until.unwrap_or(f64::INFINITY);
    let mut lines: BTreeMap<String, Line> = BTreeMap::new();
    for (place, start) in unrolled.iter().take(MOST_DRAWN) {
        let Some(stretch) = run.stretches.get(*place) else { continue };
        let Some(from) = near(start).filter(|from| *from <= limit) else { continue };
        let lasts = stretch.duration.as_ref().and_then(near);
        let to = lasts.map_or(last * 1.1 + 1.0, |lasts| from + lasts);
        add(&mut lines, &stretch.shown, (from, to));
    }
    Picture { title: title.to_string(), lines: lines.into_values().collect(), ..over_time() }
}

/// What each observer shows over time in several runs, a picture each: in every run, from when to when what is shown.
pub fn of_runs(title: &str, runs: &[Vec<(f64, f64, Vec<Term>)>]) -> Vec<Picture> {
    let mut pictures: BTreeMap<String, Picture> = BTreeMap::new();
    for run in runs {
        let mut lines = BTreeMap::new();
        for (from, to, shown) in run {
            add(&mut lines, shown, (*from, *to));
        }
        for (key, line) in lines {
            let fresh = || Picture { title: format!("{title}: {key}"), alike: true, ..over_time() };
            pictures.entry(key.clone()).or_insert_with(fresh).lines.push(line);
        }
    }
    pictures.into_values().collect()
}

fn over_time() -> Picture {
    Picture { across: "time".to_string(), up: "shown".to_string(), ..Picture::default() }
}

/// Adds what is shown as numbers from one time to another.
fn add(lines: &mut BTreeMap<String, Line>, shown: &[Term], (from, to): (f64, f64)) {
    for term in shown {
        let Node::Observe(name, values) = term.node() else { continue };
        for (number, value) in values.iter().enumerate() {
            let parts = component_values(value);
            let many = values.len() > 1 || parts.len() > 1;
            for (part, value) in parts.iter().enumerate() {
                let Some(value) = near(value) else { continue };
                let key = if many { format!("{name} {}", number + part + 1) } else { name.to_string() };
                let line = lines.entry(key.clone()).or_insert_with(|| Line { name: key, points: Vec::new() });
                // What was not shown for a while is not joined.
                if line.points.last().is_some_and(|(before, _)| (before - from).abs() > 1e-9) {
                    line.points.push((from, f64::NAN));
                }
                line.points.extend([(from, value), (to, value)]);
            }
        }
    }
}

/// The components of a vector, or the number itself.
fn component_values(value: &crate::value::Value) -> Vec<crate::value::Value> {
    if value.sort() == crate::value::Sort::Real {
        return vec![value.clone()];
    }
    (0..8).map_while(|place| value.component(place)).collect()
}
