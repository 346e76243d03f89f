//! Pictures for a report: the run, or some that were drawn; what is shown at a time, how a probability grows.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::likely::{as_shown, distributions, many, sampled};
use super::reading::{Question, Run, Waiting};
use super::roughly::{Growth, growth};
use crate::connectivity::connectivity;
use crate::lower::{ClaimKind, Environment, Event, Goal, Likelihood};
use crate::name::Name;
use crate::picture::{Line, Picture, of_run, of_runs};
use crate::probability::direct::Shown;
use crate::report::Report;
use crate::term::{Node, Term};
use crate::timeline::{Ending, Follower};
use crate::value::{Relation, Value};

/// Stretches of a run that are drawn.
const DRAWN: usize = 600;
/// Times at which a probability is asked for, to draw how it grows.
const TIMES: i64 = 40;
/// Places of a picture that are asked whether they are within what is asked for.
const PLACES: i32 = 4_000;
/// Points of a density.
const POINTS: i32 = 200;

impl Run<'_, '_> {
    /// Adds pictures to what came of a claim, where they are wanted.
    pub(super) fn illustrate(&self, report: &mut Report, waiting: &Waiting) {
        if !self.surroundings.pictures() {
            return;
        }
        let environment = &waiting.environment;
        let relation = |relation: Relation, value: &Value| format!("{value} {} 0", relation.symbol());
        report.assumed = environment.assumptions.iter().map(|(one, value)| relation(one, &value)).collect();
        match &waiting.question {
            Question::Claim(claim) => match &claim.kind {
                ClaimKind::Satisfies { system, .. } | ClaimKind::Always { system, .. } => {
                    report.links = links(&claim.kind, environment);
                    report.pictures.extend(self.run_of(system, environment));
                }
                ClaimKind::Likely { likelihood, relation, threshold } => {
                    report.asked = asked(report, *relation, threshold);
                    report.pictures.extend(likely(likelihood, environment, &|| self.surroundings.interrupted()));
                }
                ClaimKind::Compare { .. } => {}
            },
            Question::Criteria(criteria) => {
                if let Some(assessment) = &report.assessment {
                    let mut picture = of_run(&format!("The run of {}", criteria.system), &assessment.run, None);
                    let radius = criteria.radius.to_f64().unwrap_or(0.0);
                    picture.bands = criteria.goals.iter().filter_map(|goal| band(goal, radius)).collect();
                    report.pictures.push(picture);
                }
                for criterion in &criteria.all {
                    if let crate::lower::Ask::Probability { likelihood, .. } = &criterion.kind {
                        report.pictures.extend(likely(likelihood, environment, &|| self.surroundings.interrupted()));
                    }
                }
                // Two criteria may ask the same of the same runs.
                let mut seen = BTreeSet::new();
                report.pictures.retain(|picture| !picture.alike || seen.insert(format!("{picture:?}")));
            }
            _ => {}
        }
        report.pictures.retain(|picture| !picture.lines.is_empty());
    }

    /// Pictures of a chance that is asked for, where they are wanted.
    pub(super) fn pictures_of(&self, likelihood: &Likelihood, environment: &Environment) -> Vec<Picture> {
        if !self.surroundings.pictures() {
            return Vec::new();
        }
        let mut all = likely(likelihood, environment, &|| self.surroundings.interrupted());
        all.retain(|picture| !picture.lines.is_empty());
        all
    }

    fn run_of(&self, system: &Name, environment: &Environment) -> Option<Picture> {
        let system = environment.system(system)?;
        let term = system.term(&environment.definitions);
        let mut follower = Follower::new(&term, &environment.definitions);
        follower.follow(DRAWN, &|| self.surroundings.interrupted());
        let run = follower.run();
        let title = match &run.ending {
            // A run that stands still for as long as it was followed says nothing of what comes then.
            Ending::Unknown(_) if run.stretches.len() < 2 => return None,
            Ending::Unknown(why) => format!("The run of {} as far as it is known: {why}", system.name),
            _ => format!("The run of {}", system.name),
        };
        Some(of_run(&title, run, None))
    }
}

/// The links between the components of a system, where they were asked about.
fn links(kind: &ClaimKind, environment: &Environment) -> Option<String> {
    let ClaimKind::Always { system, pattern, .. } = kind else { return None };
    let observers: Vec<Name> = pattern.observers().into_iter().collect();
    connectivity(&environment.system(system)?.components, &observers, &environment.definitions).svg()
}

/// The threshold of a probability, and how far from it the interval lies.
fn asked(report: &Report, relation: Relation, threshold: &Value) -> Option<String> {
    let (chance, bound) = (report.chance.as_ref()?, threshold.as_rational()?);
    let upward = matches!(relation, Relation::Gtr | Relation::Gte);
    let ends = if upward { [chance.low, chance.high] } else { [chance.high, chance.low] };
    let [near, far] = ends.map(|end| {
        let margin = BigRational::from_float(end).map(|end| if upward { end - &bound } else { &bound - end });
        margin.and_then(|margin| margin.to_f64()).unwrap_or(f64::NAN)
    });
    let (near, far) = (format!("{near:.3e}"), format!("{far:.3e}"));
    let margin = if near == far { near } else { format!("between {near} and {far}") };
    Some(format!("asked for {} {threshold}: margin {margin} (rounded)", relation.symbol()))
}

/// The stretch of what is drawn in which the conditions of an event hold; none where it is no one stretch.
fn within(likelihood: &Likelihood, name: &Name, points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let Event::Shown { pattern, .. } = &likelihood.event else { return None };
    if pattern.conditions.is_empty() || pattern.variables.len() != 1 {
        return None;
    }
    let holds = |x: f64| {
        let place = Value::rational(BigRational::from_float(x)?);
        let met = |(relation, left, right): &(Relation, Value, Value)| {
            let (left, right) = (left.with(name, &place).ok()?.as_rational()?, right.with(name, &place).ok()?);
            Some(relation.holds(left.cmp(&right.as_rational()?)))
        };
        pattern.conditions.iter().map(met).try_fold(true, |all, met| Some(all && met?))
    };
    let inside: Vec<bool> = points.iter().map(|(x, _)| holds(*x)).collect::<Option<_>>()?;
    let (first, last) = (inside.iter().position(|met| *met)?, inside.iter().rposition(|met| *met)?);
    let whole = inside.get(first..=last)?.iter().all(|met| *met);
    whole.then(|| Some((points.get(first)?.0, points.get(last)?.0))).flatten()
}

/// A goal with its radius, where it is a number.
fn band(goal: &Goal, radius: f64) -> Option<(f64, f64, String)> {
    let [value] = goal.values.as_slice() else { return None };
    let place = crate::criteria::near(value)?;
    Some((place - radius, place + radius, goal.to_string()))
}

/// The distribution at a time, or the probability as it grows up to the time.
fn likely(likelihood: &Likelihood, environment: &Environment, interrupted: &dyn Fn() -> bool) -> Vec<Picture> {
    let likelihood = &*as_shown(likelihood, environment);
    let mut all = Vec::new();
    for (name, distribution) in distributions(likelihood, environment) {
        all.extend(distribution.normals().map(|parts| {
            let mut picture = density(&name, &parts, &at(likelihood));
            let points = picture.lines.first().map(|line| line.points.clone()).unwrap_or_default();
            picture.filled = within(likelihood, &name, &points);
            picture
        }));
    }
    all.extend(grown(likelihood, environment, interrupted));
    if all.is_empty() && !interrupted() {
        all.extend(counted(likelihood, environment));
    }
    if !interrupted() {
        all.extend(drawn(likelihood, environment));
    }
    all
}

/// How the probability of being there grows up to the time; none where it is not asked for, or could not be found.
fn grown(likelihood: &Likelihood, environment: &Environment, interrupted: &dyn Fn() -> bool) -> Option<Picture> {
    let Event::Shown { first: true, time, .. } = &likelihood.event else { return None };
    let whole = time.as_rational()?;
    let moments = (0..=TIMES).map(|part| &whole * BigRational::new(part.into(), TIMES.into()));
    let moments: Vec<BigRational> = moments.collect();
    let Growth { bounds, method } = growth(likelihood, environment, &moments, interrupted)?;
    let wide = bounds.iter().any(|(_, low, high)| high - low > 5e-3);
    let low = stairs(bounds.iter().map(|(time, low, _)| (*time, *low)));
    let high = stairs(bounds.iter().map(|(time, _, high)| (*time, *high)));
    // Bounds that are not told apart in the picture are the probability itself.
    let how = if wide || method != "enclosed" { format!(" ({method})") } else { String::new() };
    let name = if wide { "lower bound" } else { "probability" };
    let mut lines = vec![Line { name: name.to_string(), points: low }];
    if wide {
        lines.push(Line { name: "upper bound".to_string(), points: high });
    }
    Some(Picture {
        title: format!("Probability of being there by a time, {}{how}", likelihood.system),
        across: "time".to_string(),
        up: "probability".to_string(),
        lines,
        ..Picture::default()
    })
}

/// The share of many runs that are there by a time, or in which what is shown at the time is at most a number; nothing
/// where they cannot be followed, or nothing is drawn.
fn counted(likelihood: &Likelihood, environment: &Environment) -> Option<Picture> {
    let Event::Shown { first: arrival, time, pattern } = &likelihood.event else { return None };
    let arrival = *arrival;
    let (sample, seed) = many(likelihood, environment)?;
    let (runs, near) = (sample.arrivals.len(), |number: &BigRational| number.to_f64());
    let (title, across, mut places, last) = if arrival {
        let places: Vec<f64> = sample.arrivals.iter().flatten().filter_map(near).collect();
        let title = format!("Share of {runs} runs of {} that are there by a time, seed {seed}", likelihood.system);
        (title, "time".to_string(), places, near(&time.as_rational()?)?)
    } else {
        let [asked] = pattern.terms.as_slice() else { return None };
        let Node::Observe(observer, values) = asked.node() else { return None };
        let [value] = values.as_slice() else { return None };
        let shown = |what: &Vec<Term>| {
            let values = what.iter().find_map(|term| match term.node() {
                Node::Observe(name, values) if name == observer => Some(values),
                _ => None,
            });
            values?.first()?.as_rational().as_ref().and_then(near)
        };
        let places: Vec<f64> = sample.ends.iter().filter_map(shown).collect();
        let title = format!(
            "Share of {runs} runs of {} in which {value} is at most so much at {time}, seed {seed}",
            likelihood.system
        );
        let last = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (title, value.to_string(), places, last)
    };
    places.sort_by(f64::total_cmp);
    let (first, alike) = (places.first().copied()?, places.windows(2).all(|pair| pair[0] == pair[1]));
    if alike && (!arrival || places.len() == runs) {
        return None;
    }
    let start = if arrival { 0.0 } else { first };
    let share = |count: usize| count as f64 / runs as f64;
    let steps = places.iter().enumerate().map(|(count, place)| (*place, share(count + 1)));
    let points = stairs([(start, 0.0)].into_iter().chain(steps).chain([(last, share(places.len()))]));
    let lines = vec![Line { name: "share".to_string(), points }];
    Some(Picture { title, across, up: "share of the runs".to_string(), lines, ..Picture::default() })
}

/// Some runs that were drawn, up to the time that is asked about, and what is asked for in them; nothing where they cannot
/// be followed.
fn drawn(likelihood: &Likelihood, environment: &Environment) -> Vec<Picture> {
    let Some((runs, seed)) = sampled(likelihood, environment) else { return Vec::new() };
    let near = |number: &BigRational| number.to_f64().unwrap_or(f64::NAN);
    let of = |run: Vec<Shown>| run.into_iter().map(|one| (near(&one.from), near(&one.until), one.what)).collect();
    let runs: Vec<Vec<(f64, f64, Vec<Term>)>> = runs.into_iter().map(of).collect();
    let title = format!("{} runs of {} drawn at random, seed {seed}", runs.len(), likelihood.system);
    let mut pictures = of_runs(&title, &runs);
    let Event::Shown { pattern, .. } = &likelihood.event else { return pictures };
    let [asked] = pattern.terms.as_slice() else { return pictures };
    let Node::Observe(observer, values) = asked.node() else { return pictures };
    let [place] = values.as_slice() else { return pictures };
    for picture in pictures.iter_mut().filter(|picture| picture.title.ends_with(&format!(": {observer}"))) {
        let heights = || picture.lines.iter().flat_map(|line| &line.points).map(|(_, y)| *y).filter(|y| y.is_finite());
        let (low, high) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let spots = (0..=PLACES).map(|step| (low + (high - low) * f64::from(step) / f64::from(PLACES), 0.0));
        let spots: Vec<(f64, f64)> = spots.collect();
        let band = match place.as_variable() {
            Some(name) => within(likelihood, name, &spots),
            None => crate::criteria::near(place).map(|place| (place, place)),
        };
        picture.bands.extend(band.map(|(low, high)| (low, high, "asked for".to_string())));
    }
    pictures
}

/// What was found at some times, each as it stays until the next of them: it changes with the rounds, and not between.
fn stairs(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (time, height) in points {
        if let Some((_, before)) = all.last().filter(|(_, before)| *before != height) {
            all.push((time, *before));
        }
        all.push((time, height));
    }
    all
}

fn at(likelihood: &Likelihood) -> String {
    match &likelihood.event {
        Event::Shown { time, .. } => format!("of {} at {time}", likelihood.system),
        Event::Satisfies(property) => format!("of {} for {property}", likelihood.system),
    }
}

/// The density of a mixture of normal parts: weights, means, variances.
fn density(name: &Name, parts: &[(BigRational, BigRational, BigRational)], when: &str) -> Picture {
    let near = |number: &BigRational| number.to_f64().unwrap_or(f64::NAN);
    let parts: Vec<(f64, f64, f64)> =
        parts.iter().map(|(weight, mean, variance)| (near(weight), near(mean), near(variance).sqrt())).collect();
    let spread = |sign: f64| parts.iter().map(move |(_, mean, deviation)| mean + sign * 4.0 * deviation);
    let (low, high) = (spread(-1.0).fold(f64::INFINITY, f64::min), spread(1.0).fold(f64::NEG_INFINITY, f64::max));
    let at = |x: f64| -> f64 {
        parts
            .iter()
            .filter(|(.., deviation)| *deviation > 0.0)
            .map(|(weight, mean, deviation)| {
                let far = (x - mean) / deviation;
                weight * (-far * far / 2.0).exp() / (deviation * std::f64::consts::TAU.sqrt())
            })
            .sum()
    };
    let points = (0..=POINTS).map(|step| low + (high - low) * f64::from(step) / f64::from(POINTS));
    Picture {
        title: format!("Distribution of {name}, {when}"),
        across: name.to_string(),
        up: "density".to_string(),
        lines: vec![Line { name: name.to_string(), points: points.map(|x| (x, at(x))).collect() }],
        ..Picture::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_stays_until_the_next_round() {
        let found = stairs([(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (3.0, 0.5)].into_iter());
        assert_eq!(found, vec![(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 0.5), (3.0, 0.5)]);
    }
}
