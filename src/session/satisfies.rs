//! `Sys satisfies Goal`, `period Sys`, `flow Sys`.

use super::Evidence;
use super::claim::Found;
use super::compare::theory;
use super::contradiction::contradict;
use super::reading::{Run, Waiting};
use crate::assumption::Assumptions;
use crate::closed_form::term;
use crate::flow::{PhaseFlow, component_periods, flows, needed};
use crate::kernel::{Theory, Thm, check};
use crate::law::Connective;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::{self, Period, in_case};
use crate::proof::{Lemma, Proof, Script, Statement, Step};
use crate::prove::run::{self, Stage};
use crate::prove::{Answer, By, prove};
use crate::recurrence::Closed;
use crate::refute::{self, Refutation};
use crate::report::Verdict;
use crate::rewrite::Limits;
use crate::substitution::Substitution;
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
/// The longest closed formula that is printed whole, in characters.
const WIDE: usize = 160;
/// The longest reason.
const WIDEST: usize = 480;

impl Run<'_, '_> {
    pub(super) fn satisfies(&mut self, system: &Name, property: &Name, waiting: &Waiting) -> Found {
        let environment = &waiting.environment;
        let (Some(system), Some(property)) = (environment.system(system), environment.property(property)) else {
            return Found::default();
        };
        let Some(body) = &property.body else { return Found::default() };
        let outcome = verify::verify(
            &system.components,
            (&property.name, body),
            &environment.definitions,
            &environment.assumptions,
            &|| self.surroundings.interrupted(),
        );
        let mut trace: Vec<String> = by_turns(&outcome).into_iter().chain(outcome.remark.clone()).collect();
        trace.extend(account(system, &outcome, environment));
        let mut found = Found { trace, ..Found::default() };
        found.values = outcome.values.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        found.steady = outcome.steady.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
        match &outcome.verdict {
            verify::Verdict::Proved => self.matched(system, &outcome, environment, &mut found),
            verify::Verdict::Refuted { reason, .. } => found.remains = vec![said(reason)],
            verify::Verdict::Open { remaining } => found.remains = remaining.iter().map(|line| said(line)).collect(),
        }
        if !matches!(outcome.verdict, verify::Verdict::Proved) && !self.surroundings.interrupted() {
            let interrupted = || self.surroundings.interrupted();
            contradict(system, property, &outcome, environment, &interrupted, &mut found);
            if let (None, verify::Verdict::Refuted { reason, .. }) = (found.verdict, &outcome.verdict) {
                found.remains = vec![
                    format!("no durations were found: {}", said(reason)),
                    "but that there are none could not be shown".to_string(),
                ];
            }
            self.tolerances(system, property, &outcome, environment, &mut found);
        }
        found
    }

    /// The match of the run with the property, as a theorem.
    pub(super) fn matched(&mut self, system: &System, outcome: &Outcome, environment: &Environment, found: &mut Found) {
        let (Some(run), Some(wanted)) = (&outcome.trajectory_term, &outcome.property_term) else {
            found.remains = vec!["the run or the property could not be written as a process".to_string()];
            return;
        };
        let statement = Statement {
            hypotheses: Vec::new(),
            left: run.clone(),
            connective: Connective::Refines,
            right: wanted.clone(),
        };
        let theory = theory(environment);
        let interrupted = || self.surroundings.interrupted();
        match prove(&theory, &statement, &By::Search, Limits::default(), &interrupted) {
            Answer::Proved(_, proof) => {
                found.trace.push(format!("match: {}", short(&wanted.to_string())));
                found.it = Some(run.clone());
                let whole = system.term(&theory.definitions);
                let tried = match agreement(&whole, run, environment) {
                    Ok((line, tried)) => {
                        found.trace.push(line);
                        tried
                    }
                    Err(lines) => {
                        found.remains = lines;
                        return;
                    }
                };
                let trusting = if outcome.orbit.is_some() { TURNS } else { RUN };
                let followed = followed(&theory, (&whole, run), &proof, &outcome.stages());
                if let (Err(why), false) = (&followed, tried) {
                    found.remains = vec![
                        "the run was tried on no instance of the executable meaning, and the kernel could not follow it:"
                            .to_string(),
                        format!("  {}", said(why)),
                    ];
                    return;
                }
                let checked = followed.or_else(|why| {
                    found.trace.push(format!("the kernel could not follow the run: {}", said(&why)));
                    let proof = with_run(whole, run, *proof, trusting);
                    check(&theory, &proof).map(|theorem| (theorem, proof))
                });
                match checked {
                    Ok((theorem, proof)) => {
                        let environment = environment.clone();
                        found.verdict = Some(Verdict::Proved);
                        found.evidence = Some(Evidence { theory, environment, theorem, proof });
                    }
                    Err(rejected) => {
                        found.remains = vec![format!("the kernel turned the proof down: {}", rejected.reason)]
                    }
                }
            }
            Answer::Open(gap) => {
                let sides = [&gap.left, &gap.right].map(|side| format!("  {}", short(&side.to_string())));
                found.remains = vec!["the run of the system could not be proved to match the property:".to_string()];
                found.remains.extend(sides);
            }
        }
    }

    pub(super) fn flow(&mut self, system: &Name, waiting: &Waiting) -> Vec<String> {
        let surroundings = self.surroundings;
        self.examined(system, waiting, |_, period, environment| {
            let mut lines = Vec::new();
            for flow in flows(period, &environment.definitions) {
                lines.extend(flow.lines());
                let n = flow.index();
                let next = |(name, next): &(Name, Value)| format!("  next      {} = {next}", term(name, &n, 1));
                lines.extend(flow.steps(&n).iter().map(next));
                let stop = || surroundings.interrupted();
                lines.extend(recurrence_lines(&flow, &n, &environment.assumptions, &stop));
                let means = flow.means(&n, &environment.assumptions, &stop);
                let means = means.iter().flat_map(|(name, closed)| closed_lines(name, closed, &n));
                lines.extend(means.map(|line| line.replacen("closed", "mean  ", 1)));
            }
            lines
        })
    }

    fn examined(
        &mut self,
        system: &Name,
        waiting: &Waiting,
        describe: impl Fn(&System, &Period, &Environment) -> Vec<String>,
    ) -> Vec<String> {
        let environment = &waiting.environment;
        let Some(found) = environment.system(system) else { return vec![format!("there is no system {system}")] };
        let interrupted = || self.surroundings.interrupted();
        let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
        match period::analyse_until(&found.components, definitions, assumptions, &interrupted) {
            Ok(period) => {
                let mut lines = describe(found, &period, environment);
                lines.extend(period.warnings.iter().map(|warning| format!("warning: {warning}")));
                lines
            }
            Err(failures) => failures.iter().map(ToString::to_string).collect(),
        }
    }
}

/// The closed forms of a phase, and why there are none of some variables.
fn recurrence_lines(flow: &PhaseFlow, index: &Name, assumptions: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<String> {
    let found = flow.recurrences(index, assumptions, stop);
    let sums = if found.missing.is_empty() { Vec::new() } else { flow.sums(index, assumptions) };
    if !sums.is_empty() {
        return sums.into_iter().map(|line| format!("  closed    {line}")).collect();
    }
    let mut lines: Vec<String> =
        found.closed.iter().flat_map(|(name, closed)| closed_lines(name, closed, index)).collect();
    for (names, reason) in &found.missing {
        let names: Vec<&str> = names.iter().map(Name::as_str).collect();
        let of = if found.closed.is_empty() && found.missing.len() == 1 {
            String::new()
        } else {
            format!(" of {}", names.join(", "))
        };
        lines.push(format!("  no closed form{of}: {}", reason.0));
    }
    lines
}

/// What is taken on trust is tried on the executable meaning first: small values for the parameters, the system beside
/// its run. A difference would be a mistake of ours, and nothing is then proved. What was found is said, with whether
/// any instance was followed at all.
fn agreement(system: &Term, run: &Term, environment: &Environment) -> Result<(String, bool), Vec<String>> {
    let limits = refute::Limits { instances: 12, choices: 4_000, cost: 12, pairs: 2_000 };
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    match refute::refute(system, run, Connective::WeaklyRefines, &[], definitions, assumptions, &limits) {
        Refutation::Refuted(found) => {
            let mut lines = vec!["the printed run is not what the system does, so nothing is proved:".to_string()];
            lines.extend(crate::explain::run_lines(&found, Connective::WeaklyRefines));
            Err(lines)
        }
        Refutation::None { instances, meaningless, open, .. } => {
            let whole = instances.saturating_sub(meaningless).saturating_sub(open);
            let count =
                |count: usize| if count == 1 { "one instance".to_string() } else { format!("{count} instances") };
            let line = match (whole, open) {
                (0, 0) => "the run was not tried on the executable meaning".to_string(),
                (0, open) => {
                    format!(
                        "the run agrees with the executable meaning as far as that was followed, on {}",
                        count(open)
                    )
                }
                (whole, _) => format!("the run agrees with the executable meaning on {}", count(whole)),
            };
            Ok((line, whole + open > 0))
        }
    }
}

/// The verdict with the run of the system proved as well; otherwise why the kernel could not follow the run.
fn followed(
    theory: &Theory,
    (whole, run): (&Term, &Term),
    matched: &Proof,
    stages: &[Stage],
) -> Result<(Thm, Proof), String> {
    let ran = run::runs(theory, (whole, run), stages).map_err(|lost| lost.0)?;
    // Where the match speaks of one round by itself, it needs a claim that counts the rounds: a lemma.
    let ways = [behind(ran.clone(), matched), by_lemma(ran, matched)];
    let mut why = String::new();
    for proof in ways {
        match check(theory, &proof) {
            Ok(theorem) => return Ok((theorem, proof)),
            Err(rejected) => why = rejected.reason.to_string(),
        }
    }
    Err(why)
}

/// From a proof that the system runs so, and one that the run matches the property as a lemma, one that the system does.
fn by_lemma(ran: Proof, matched: &Proof) -> Proof {
    let (mut script, mut lemmas) = (Script { steps: ran.steps }, ran.lemmas);
    let followed = script.steps.len().saturating_sub(1);
    let name = Name::new("Match");
    lemmas.push(Lemma { name, statement: matched.statement.clone(), steps: matched.steps.clone() });
    let step = script.push(Step::Lemma(lemmas.len() - 1, Substitution::default()));
    script.push(Step::Transitive(vec![followed, step]));
    let connective = Connective::WeaklyRefines;
    let statement = Statement { left: ran.statement.left, connective, ..matched.statement.clone() };
    Proof { lemmas, ..script.finish(statement) }
}

/// What is taken on trust where a system is proved to satisfy a property.
const RUN: &str = "that the system runs as printed: its period and the closed forms";
/// The same where values move on from turn to turn.
const TURNS: &str =
    "that the system runs as printed: its period, the closed forms, and the intervals that values never leave";

/// From a proof that the system runs so, and one that the run matches the property, one that the system does.
fn behind(ran: Proof, matched: &Proof) -> Proof {
    let mut script = Script { steps: ran.steps };
    let followed = script.steps.len().saturating_sub(1);
    let numbers: Vec<usize> = (0..matched.steps.len()).map(|number| number + followed + 1).collect();
    script.steps.extend(matched.steps.iter().map(|step| step.renumbered(&numbers)));
    let last = script.steps.len().saturating_sub(1);
    script.push(Step::Transitive(vec![followed, last]));
    let connective = Connective::WeaklyRefines;
    let statement = Statement { left: ran.statement.left, connective, ..matched.statement.clone() };
    Proof { lemmas: ran.lemmas, ..script.finish(statement) }
}

/// From a proof that the run matches the property, one that the system does; that it runs so is taken on trust.
fn with_run(system: Term, run: &Term, matched: Proof, trusting: &str) -> Proof {
    let statement = Statement { left: system.clone(), connective: Connective::WeaklyRefines, ..matched.statement };
    let mut script = Script { steps: matched.steps };
    let last = script.steps.len().saturating_sub(1);
    let trusted = script.push(Step::Trust(system, Connective::WeaklyRefines, run.clone(), trusting.to_string()));
    script.push(Step::Transitive(vec![trusted, last]));
    script.finish(statement)
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
    if let Some(run) = &outcome.trajectory_term {
        lines.push(format!("projected: {}", short(&run.to_string())));
    }
    lines.extend(outcome.diagnostics.iter().map(|failure| format!("note: {failure}")));
    lines
}

/// The phases with their flow functions, the first of them where there are many.
pub(super) fn phase_lines(period: &Period, system: &Name, environment: &Environment) -> Vec<String> {
    let all = flows(period, &environment.definitions);
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
    let phases = outcome.period.as_ref().map_or_else(Vec::new, |period| flows(period, &environment.definitions));
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
    if leg.closed.is_empty() && matches!(&leg.rounds, Rounds::Count(count) if *count == Value::integer(1)) {
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

fn closed_lines(name: &Name, closed: &Closed, index: &Name) -> Vec<String> {
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
fn short(text: &str) -> String {
    cut(text, WIDE)
}

/// A reason, abbreviated.
pub(super) fn said(text: &str) -> String {
    cut(text, WIDEST)
}

fn cut(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_string();
    }
    let head: String = text.chars().take(most).collect();
    format!("{head} … ({} characters)", text.chars().count())
}
