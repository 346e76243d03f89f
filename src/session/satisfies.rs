//! `Sys satisfies Goal`, and how a system is told in each order of its delays.

use super::beside::{BESIDE, Leaving, READERS, relevant, without_readers};
use super::claim::Found;
use super::contradiction::contradict;
use super::delays::{self, MOST_CLAIMED, Order, either_case, in_orders};
use super::parts::{large_part, separate};
use super::reading::{Run, Waiting};
use crate::assumption::Assumptions;
use crate::closed_form::compared;
use crate::flow::{PhaseFlow, component_periods, flows, needed};
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::{self, Period, in_case};
use crate::recurrence::Closed;
use crate::term::Term;
use crate::value::Value;
use crate::verify::trajectory::{Leg, Rounds};
use crate::verify::{self, Outcome};

/// The legs that are printed, before those that repeat.
const MOST_LEGS: usize = 12;
/// Phases that are printed beside a verdict.
const MOST_PHASES: usize = 12;
/// Values that come by turns that are listed.
const MOST_TURNS: usize = 8;
/// Said of phases that were followed along the run alone.
pub(super) const ALONG: &str = "the ways are those that the run takes; no others were looked for";
/// The longest closed formula that is printed whole, in characters.
const WIDE: usize = 160;
/// The longest reason.
const WIDEST: usize = 480;

impl Run<'_, '_> {
    pub(super) fn satisfies(&mut self, system: &Name, property: &Name, waiting: &Waiting) -> Found {
        self.satisfies_under(system, property, &waiting.environment, MOST_CLAIMED)
    }

    /// The same under what was declared, and where it is not known which of two delays ends first in each order; `most`: so
    /// many times.
    fn satisfies_under(&mut self, system: &Name, property: &Name, environment: &Environment, most: usize) -> Found {
        let names = (system, property);
        let (Some(system), Some(property)) = (environment.system(system), environment.property(property)) else {
            return Found::default();
        };
        let Some(body) = &property.body else { return Found::default() };
        let part = large_part(system, std::slice::from_ref(body), environment, &|| self.surroundings.interrupted());
        let verified = |system: &System| {
            let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
            let stop = || self.surroundings.interrupted();
            verify::verify(&system.components, (&property.name, body), definitions, assumptions, &stop)
        };
        let (whole, mut system, mut part) = (system, part.as_ref().unwrap_or(system).clone(), part);
        let mut outcome = verified(&system);
        let mut beside = BESIDE;
        if part.is_none()
            && let Some((alone, own, why)) = of_part(whole, body, environment, &outcome, &verified)
        {
            (outcome, system, part, beside) = (alone, own.clone(), Some(own), why);
        }
        let system = &system;
        if matches!(outcome.verdict, verify::Verdict::Open { .. }) {
            let each = |order: &Order| self.satisfies_under(names.0, names.1, &order.environment, most - 1);
            let (orders, cases) = in_orders(&outcome.diagnostics, environment, most, each);
            let in_cases = || self.in_either_case(names, &outcome, environment, most);
            if let Some(found) = Found::in_each(&orders, cases, false).or_else(in_cases) {
                return found;
            }
        }
        let told = by_turns(&outcome).into_iter().chain(outcome.remark.clone());
        let trace = told.chain(account(system, &outcome, environment)).collect();
        let mut found = Found { trace, ..Found::default() };
        found.values = outcome.values.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        found.steady = outcome.steady.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        match &outcome.verdict {
            verify::Verdict::Proved => {
                found.trusted.extend(part.iter().map(|_| beside.to_string()));
                self.matched(system, &outcome, environment, &mut found);
            }
            verify::Verdict::Refuted { reason, .. } => found.remains = vec![said(reason)],
            verify::Verdict::Open { remaining } => found.remains = remaining.iter().map(|line| said(line)).collect(),
        }
        if !matches!(outcome.verdict, verify::Verdict::Proved) && !self.surroundings.interrupted() {
            let interrupted = || self.surroundings.interrupted();
            contradict(whole, property, &outcome, environment, &interrupted, &mut found);
            if let (None, verify::Verdict::Refuted { reason, .. }) = (found.verdict, &outcome.verdict) {
                found.remains = vec![
                    format!("no durations were found: {}", said(reason)),
                    "but that there are none could not be shown".to_string(),
                ];
            }
            self.tolerances(system, property, &outcome, environment, &mut found);
            if found.verdict.is_none() {
                self.supposed(&outcome, environment, &mut found);
            }
        }
        found
    }

    /// The same in either case of what would have to be known of parameters, if it is settled in one of them.
    fn in_either_case(
        &mut self,
        (system, property): (&Name, &Name),
        outcome: &Outcome,
        environment: &Environment,
        most: usize,
    ) -> Option<Found> {
        let cases = if most > 0 { either_case(&outcome.asked, environment) } else { Vec::new() };
        let found = |case: &Order| self.satisfies_under(system, property, &case.environment, most - 1);
        Found::in_each(&cases, cases.iter().map(found).collect(), false)
    }
}

/// What comes of a property of what shows it alone, with what that takes on trust: where the whole has no period, or nothing
/// is told of it, and of that it is.
fn of_part(
    whole: &System,
    shown: &Term,
    environment: &Environment,
    outcome: &Outcome,
    verified: &dyn Fn(&System) -> Outcome,
) -> Option<(Outcome, System, &'static str)> {
    let open = matches!(outcome.verdict, verify::Verdict::Open { .. });
    if !open && outcome.period.is_some() {
        return None;
    }
    let shown = std::slice::from_ref(shown);
    let parts = [(relevant as Leaving, BESIDE), (without_readers, READERS)];
    let (own, why) = parts.into_iter().find_map(|(leaving, why)| Some((leaving(whole, shown, environment)?, why)))?;
    let alone = verified(&own);
    let told = outcome.period.is_none() || !matches!(alone.verdict, verify::Verdict::Open { .. });
    told.then_some((alone, own, why))
}

/// What is said of the period of a system, where it is not known which of two delays ends first in each order; whether one
/// was found, and whether in every order. `most`: so many times.
pub(super) fn examined(
    system: &System,
    environment: &Environment,
    describe: &dyn Fn(&System, &Period, &Environment) -> Vec<String>,
    most: usize,
    interrupted: &dyn Fn() -> bool,
) -> (Vec<String>, bool, bool) {
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    match period::analyse_until(&system.components, definitions, assumptions, interrupted) {
        Ok(period) => {
            let mut lines = describe(system, &period, environment);
            lines.extend(period.warnings.iter().map(|warning| format!("warning: {warning}")));
            (lines, true, true)
        }
        Err(failures) => {
            let each = |order: &Order| examined(system, &order.environment, describe, most - 1, interrupted);
            let (orders, cases) = in_orders(&failures, environment, most, each);
            if cases.iter().any(|(_, found, _)| *found) {
                let every = cases.iter().all(|(_, _, every)| *every);
                let all = orders.iter().zip(cases);
                let lines = all.flat_map(|(order, (lines, ..))| delays::told(&order.title, lines)).collect();
                return (lines, true, every);
            }
            let mut lines: Vec<String> = failures.iter().map(ToString::to_string).collect();
            // What drifts apart is told part by part.
            let parts = separate(system, environment, interrupted).map(|(parts, _)| parts).unwrap_or_default();
            for part in parts {
                lines.push(format!("{}:", part.names()));
                lines.extend(
                    describe(&part.system, &part.period, environment).into_iter().map(|line| format!("  {line}")),
                );
            }
            (lines, false, false)
        }
    }
}

/// The closed forms of a phase, and why there are none of some variables.
pub(super) fn recurrence_lines(
    flow: &PhaseFlow,
    index: &Name,
    assumptions: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<String> {
    let found = flow.recurrences(index, assumptions, stop);
    let sums = if found.missing.is_empty() { Vec::new() } else { flow.sums(index, assumptions) };
    if !sums.is_empty() {
        return sums.into_iter().map(|line| format!("  closed    {line}")).collect();
    }
    let mut lines: Vec<String> =
        found.closed.iter().flat_map(|(name, closed)| closed_lines(name, closed, index)).collect();
    // An order that is open is told as `solve` tells it.
    let orders = flow.recurrences_in_cases(&found, index, assumptions, stop);
    if !orders.is_empty() {
        lines.clear();
        for case in orders {
            lines.push(format!("  closed    if {}:", case.title()));
            lines.extend(case.found.lines().into_iter().map(|line| format!("              {line}")));
        }
        return lines;
    }
    for (names, reason) in &found.missing {
        let names: Vec<&str> = names.iter().map(Name::as_str).collect();
        let of = if found.closed.is_empty() && found.missing.len() == 1 {
            String::new()
        } else {
            format!(" of {}", names.join(", "))
        };
        lines.push(format!("  no closed form{of}: {}", reason.reason));
    }
    let own = if found.missing.is_empty() { None } else { flow.from_begin(index, assumptions, stop) };
    if let (Some(solved), Some(begin)) = (own, &flow.begin) {
        let begin: Vec<String> = begin.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        lines.push(format!("  closed    from {}, with which the run begins:", begin.join(", ")));
        lines.extend(solved.lines().into_iter().map(|line| format!("              {line}")));
    }
    lines
}

pub(super) fn components(system: &System, environment: &Environment) -> Vec<String> {
    component_periods(&system.components, &environment.definitions).iter().flat_map(|one| one.lines()).collect()
}

/// What was found in the rounds that come again and again, where it is not the same in each.
fn by_turns(outcome: &Outcome) -> Option<String> {
    let (from, turns) = outcome.by_turns.as_ref()?;
    let told = |(name, values): (&Name, &Vec<Value>)| {
        if values.iter().all(|value| *value == values[0]) {
            return format!("{name} = {}", values[0]);
        }
        let all: Vec<String> = values.iter().take(MOST_TURNS).map(Value::to_string).collect();
        let more = if values.len() > MOST_TURNS { ", …" } else { "" };
        format!("{name} = {}{more} by turns", all.join(", "))
    };
    let told: Vec<String> = turns.iter().filter(|(_, values)| !values.is_empty()).map(told).collect();
    Some(format!("from round {from} on {}", told.join("; "))).filter(|_| !told.is_empty())
}

/// The road to the verdict: component periods, phases with their flow functions, legs with closed forms, the run.
fn account(system: &System, outcome: &Outcome, environment: &Environment) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(period) = &outcome.period {
        lines.extend(components(system, environment));
        lines.extend(phase_lines(period, &system.name, environment));
    }
    lines.extend(legs(outcome, environment));
    for (when, run) in outcome.runs() {
        let when = when.iter().map(compared).collect::<Vec<_>>().join(" and ");
        let when = if when.is_empty() { when } else { format!(" where {when}") };
        lines.push(format!("projected{when}: {}", short(&run.to_string())));
    }
    lines.extend(outcome.diagnostics.iter().map(|failure| format!("note: {failure}")));
    lines
}

/// The phases with their flow functions, the first of them where there are many.
pub(super) fn phase_lines(period: &Period, system: &Name, environment: &Environment) -> Vec<String> {
    let all = flows(period, environment);
    let mut lines: Vec<String> = Vec::new();
    for flow in all.iter().take(MOST_PHASES) {
        lines.extend(flow.lines().iter().map(|line| said(line)));
    }
    if let more @ 1.. = all.len().saturating_sub(MOST_PHASES) {
        lines.push(format!("… and {more} more phases: `flow {system}` shows them all"));
    }
    lines
}

/// The legs, the first and the last where there are many, and what moves on in legs that repeat.
fn legs(outcome: &Outcome, environment: &Environment) -> Vec<String> {
    let phases = outcome.period.as_ref().map_or_else(Vec::new, |period| flows(period, environment));
    let turns = outcome.orbit.as_ref().map(|(from, _)| *from);
    let mut lines = Vec::new();
    for (number, leg) in outcome.legs.iter().enumerate() {
        let shown = number < MOST_LEGS || turns.is_some_and(|from| number >= from) || number + 2 > outcome.legs.len();
        if number == MOST_LEGS && !shown {
            lines.push("…".to_string());
        }
        if let Some((_, orbit)) = outcome.orbit.as_ref().filter(|(from, _)| *from == number) {
            lines.push(format!("from leg {} on, again and again:", number + 1));
            lines.extend(orbit.lines().iter().map(|line| format!("  {}", short(line))));
        }
        if shown {
            lines.extend(leg_lines(number, leg, phases.get(leg.phase)));
        }
    }
    lines
}

fn leg_lines(number: usize, leg: &Leg, phase: Option<&PhaseFlow>) -> Vec<String> {
    let rounds = match &leg.rounds {
        Rounds::Count(count) => format!("n = {}", short(&count.to_string())),
        Rounds::Forever(why) => format!("for ever: {why}"),
    };
    let mut lines = vec![format!("leg {}: phase {}, {rounds}", number + 1, leg.phase + 1)];
    for (name, closed) in &leg.closed {
        lines.extend(closed_lines(name, closed, &leg.index));
    }
    if !leg.start.is_empty()
        && leg.closed.is_empty()
        && matches!(&leg.rounds, Rounds::Count(count) if *count == Value::integer(1))
    {
        for one in phase.into_iter().flat_map(|phase| &phase.carried) {
            let (before, after) = (one.before.substitute(&leg.start), one.after.substitute(&leg.start));
            let (Ok(before), Ok(after)) = (before, after) else { continue };
            lines.push(format!(
                "  closed    {} = {} from {index} = 0 until {index} = 1",
                one.parameter,
                short(&before.to_string()),
                index = leg.index
            ));
            lines.push(format!("  closed    {} = {} from {} = 1", one.parameter, short(&after.to_string()), leg.index));
        }
    }
    lines
}

pub(super) fn closed_lines(name: &Name, closed: &Closed, index: &Name) -> Vec<String> {
    let when = in_case(&needed(closed));
    closed
        .pieces
        .iter()
        .map(|piece| {
            let until = piece.until.as_ref().map_or(String::new(), |until| format!(" until {index} = {until}"));
            format!(
                "  closed    {name} = {} from {index} = {}{until}{when}",
                short(&piece.form.to_string()),
                piece.from
            )
        })
        .collect()
}

/// A formula, abbreviated.
pub(super) fn short(text: &str) -> String {
    cut(text, WIDE)
}

/// A reason, abbreviated.
pub(super) fn said(text: &str) -> String {
    cut(text, WIDEST)
}

/// A text, with its beginning alone where it has more characters than these.
pub(super) fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_string();
    }
    let head: String = text.chars().take(most).collect();
    format!("{head} … ({} characters)", text.chars().count())
}
