//! Questions answered by transition systems: `lts P`, `minimise P`, `compare P ~ Q`.

use std::sync::Arc;

use num_bigint::BigInt;
use num_rational::BigRational;

use super::reading::{Run, Waiting};
use crate::ast::Limits;
use crate::definition::Definitions;
use crate::diagnostic::Diagnostic;
use crate::equivalence::{Difference, Evidence, Preorder, Verdict, compare_processes, minimised_system, system_of};
use crate::lower::Expectation;
use crate::model::State;
use crate::report::Expected;
use crate::sample::close;
use crate::stepper::{Apart, Route, choice_of};
use crate::term::Term;
use crate::transition_system::{Bounds, Label, Trouble, look, summary, told};

/// An answer before it is put into words for a person or a program.
#[derive(Default)]
pub(super) struct Answered {
    pub(super) lines: Vec<String>,
    pub(super) verdict: Option<&'static str>,
    /// Why there is no answer.
    pub(super) diagnostics: Vec<Diagnostic>,
    /// For "no": the sides, for the stepper.
    pub(super) apart: Option<Arc<Apart>>,
}

impl Answered {
    /// Which expectations it meets.
    pub(super) fn expected(&self, expected: &[(Expectation, String)]) -> Vec<Expected> {
        let met = |expectation: &Expectation| match expectation {
            Expectation::Answer(word) => Some(word.as_str()) == self.verdict,
            _ => false,
        };
        expected.iter().map(|(one, text)| Expected { text: text.clone(), met: met(one) }).collect()
    }

    /// There is no answer, since the process has no meaning, or none that steps alone could show.
    fn trouble(trouble: &Trouble, waiting: &Waiting) -> Answered {
        let message = match trouble {
            Trouble::Meaningless(why) => format!("this has no meaning: {why}"),
            other => format!("steps alone do not say what this does: {other}"),
        };
        let diagnostic = Diagnostic::error("P0920", message).label(waiting.span, "asked here");
        let diagnostic = match trouble {
            Trouble::Meaningless(why) if why.why.contains("has no value") || why.why.contains("is not a number") => {
                diagnostic.help("a system is made of closed processes: give each parameter a value, `param t = 1`")
            }
            _ => diagnostic,
        };
        Answered { diagnostics: vec![diagnostic], ..Answered::default() }
    }
}

/// States of a process that is compared with itself.
const MOST_OF_ITSELF: usize = 2_000;

/// The bounds that were asked for.
fn bounds(limits: Limits) -> Bounds {
    let usual = Bounds::default();
    Bounds {
        states: limits.states.unwrap_or(usual.states),
        bytes: limits.memory.map_or(usual.bytes, |megabytes| megabytes.saturating_mul(1 << 20)),
    }
}

/// Processes with values for the parameters that have none, and a line that says which; as they are where there are no
/// such parameters, or none meet what is assumed.
struct Instance {
    terms: Vec<Term>,
    definitions: Definitions,
    values: Vec<String>,
}

impl Instance {
    fn of(terms: &[Term], waiting: &Waiting) -> Instance {
        let plain = || Instance {
            terms: terms.to_vec(),
            definitions: waiting.environment.definitions.clone(),
            values: Vec::new(),
        };
        let Ok(both) = close(&Term::par(terms.to_vec()), &waiting.environment, &[]) else { return plain() };
        let given: Vec<_> = both.values.into_iter().map(|(name, value, _)| (name, value)).collect();
        let closed = terms.iter().map(|term| close(term, &waiting.environment, &given)).collect::<Result<Vec<_>, _>>();
        let Ok(closed) = closed else { return plain() };
        let values = given.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        let mut definitions = Definitions::default();
        for definition in closed.iter().flat_map(|one| one.definitions.iter()) {
            definitions.insert(definition.clone());
        }
        Instance { terms: closed.into_iter().map(|one| one.term).collect(), definitions, values }
    }

    fn line(&self) -> Option<String> {
        let first = self.values.first()?;
        Some(format!("take {}; for others say so before: `param {first}`", self.values.join(", ")))
    }
}

impl Run<'_, '_> {
    pub(super) fn transition_system(&self, term: &Term, limits: Limits, waiting: &Waiting) -> Answered {
        let stop = || self.surroundings.interrupted();
        let instance = Instance::of(std::slice::from_ref(term), waiting);
        match system_of(&instance.terms[0], &instance.definitions, &bounds(limits), &stop) {
            Err(trouble) => Answered::trouble(&trouble, waiting),
            Ok(found) => {
                let mut lines: Vec<String> = instance.line().into_iter().collect();
                lines.extend(summary(&found.system));
                lines.extend(told(&found.system, &|state| named(found.states.get(state as usize))));
                Answered { lines, ..Answered::default() }
            }
        }
    }

    pub(super) fn minimised(&self, term: &Term, limits: Limits, waiting: &Waiting) -> Answered {
        let stop = || self.surroundings.interrupted();
        let instance = Instance::of(std::slice::from_ref(term), waiting);
        match minimised_system(&instance.terms[0], &instance.definitions, &bounds(limits), &stop) {
            Err(trouble) => Answered::trouble(&trouble, waiting),
            Ok((system, before)) => {
                let mut lines: Vec<String> = instance.line().into_iter().collect();
                lines.push(format!("from {before} states"));
                lines.extend(summary(&system));
                lines.extend(told(&system, &|state| look(system.mark(state))));
                Answered { lines, ..Answered::default() }
            }
        }
    }

    pub(super) fn alike(&self, terms: &[Term; 2], relation: Preorder, limits: Limits, waiting: &Waiting) -> Answered {
        let stop = || self.surroundings.interrupted();
        let instance = Instance::of(terms, waiting);
        let (definitions, [left, right]) = (&instance.definitions, [&instance.terms[0], &instance.terms[1]]);
        // Every relation holds between a process and itself, which is looked at for its meaning alone.
        let same = terms[0] == terms[1];
        let mut bounds = bounds(limits);
        if same {
            bounds.states = bounds.states.min(MOST_OF_ITSELF);
        }
        let itself = || {
            let line = format!("yes: {}: both sides are one process", relation.says(true));
            Answered { lines: vec![line], verdict: Some("yes"), ..Answered::default() }
        };
        let answer = match compare_processes(left, right, definitions, relation, &bounds, &stop) {
            Err(Trouble::Draws) if same => return itself(),
            Err(Trouble::Draws) => {
                let line =
                    "unknown: what a side does depends on a value drawn from a continuous distribution".to_string();
                return Answered { lines: vec![line], verdict: Some("unknown"), ..Answered::default() };
            }
            Err(trouble) => return Answered::trouble(&trouble, waiting),
            Ok(answer) => answer,
        };
        let sizes = format!("{} and {} states", answer.sizes[0], answer.sizes[1]);
        let mut apart = None;
        let (verdict, lines) = match &answer.verdict {
            Verdict::Yes if same && !instance.values.is_empty() => return itself(),
            Verdict::Yes => ("yes", {
                let (one, other) = match instance.values.is_empty() {
                    true => ("yes", ""),
                    false => ("unknown", ", with these values; others were not tried"),
                };
                let mut lines = vec![format!("{one}: {} ({sizes}){other}", relation.says(true))];
                if let Some(moments) = answer.moments.as_ref().filter(|_| left != right) {
                    lines.push(format!("as far as communications happen at multiples of {moments}"));
                }
                lines
            }),
            Verdict::No(evidence) => {
                let mut lines = vec![format!("no: {} ({sizes})", relation.says(false))];
                let name = |side: usize, state: u32| named(answer.states[side].get(state as usize));
                lines.extend(evidence_lines(evidence, &name));
                let route = |side: usize| Route {
                    term: instance.terms[side].clone(),
                    definitions: definitions.clone(),
                    choices: answer.choices[side].iter().map_while(|text| choice_of(text)).collect(),
                };
                let right_first = matches!(evidence.difference, Difference::Step(false, _));
                let found = Apart { left: route(0), right: route(1), right_first };
                lines.extend(found.lines());
                apart = Some(Arc::new(found));
                ("no", lines)
            }
            Verdict::Unknown(_) if same => return itself(),
            Verdict::Unknown(why) => ("unknown", vec![format!("unknown: {why}")]),
        };
        let Some(line) = instance.line() else {
            return Answered { lines, verdict: Some(verdict), diagnostics: Vec::new(), apart };
        };
        // One instance refutes; it proves nothing of the others.
        let verdict = if verdict == "yes" { "unknown" } else { verdict };
        let lines = [line].into_iter().chain(lines).collect();
        Answered { lines, verdict: Some(verdict), diagnostics: Vec::new(), apart }
    }
}

fn named(state: Option<&State>) -> String {
    match state {
        Some(State::Stopped(results)) if results.is_empty() => "has stopped".to_string(),
        Some(State::Stopped(results)) => {
            let results: Vec<String> = results.iter().map(|(name, value)| format!("{name} = {value}")).collect();
            format!("has stopped with {}", results.join(", "))
        }
        Some(State::Aborted) => "has aborted".to_string(),
        Some(State::Running(term)) => term.to_string(),
        None => String::new(),
    }
}

/// A chance in short: one with a long denominator to six places.
fn chance(exact: &BigRational) -> String {
    if *exact.denom() < BigInt::from(1_000_000) {
        return exact.to_string();
    }
    let places = (exact * BigRational::from_integer(BigInt::from(1_000_000))).round().to_integer();
    format!("about 0.{places:0>6}")
}

/// The longest formula that is shown in full, in letters.
const LONGEST: usize = 1_500;
/// Steps of a run that are told; of a longer one, the first and the last.
const MOST_TOLD: usize = 40;

/// Why two systems differ, a line each; `name` says what a state of the left (0) or right (1) system is.
pub fn evidence_lines(evidence: &Evidence, name: &dyn Fn(usize, u32) -> String) -> Vec<String> {
    let side = |left: bool| if left { "left" } else { "right" };
    let mut lines =
        vec![format!("the {} side alone satisfies {}", side(evidence.holds_left), evidence.formula(LONGEST))];
    let mut told: Vec<(bool, Label, Option<u32>, Option<u32>)> = Vec::new();
    for step in &evidence.run {
        match (told.last_mut(), &step.label) {
            // Time passes for both, so that it does not matter who moves.
            (Some((_, Label::Wait(time), left, right)), Label::Wait(more)) => {
                *time += more;
                (*left, *right) = (step.left, step.right);
            }
            _ => told.push((step.left_moves, step.label.clone(), step.left, step.right)),
        }
    }
    let count = told.len();
    for (place, (left_moves, label, left, right)) in told.into_iter().enumerate() {
        if count > MOST_TOLD && place == MOST_TOLD / 2 {
            lines.push(format!("… {} steps more …", count - MOST_TOLD));
        }
        if count > MOST_TOLD && (MOST_TOLD / 2..count - MOST_TOLD / 2).contains(&place) {
            continue;
        }
        let states = [left.map(|state| ("left", name(0, state))), right.map(|state| ("right", name(1, state)))];
        let states: Vec<String> =
            states.into_iter().flatten().map(|(side, state)| format!("{side}: {state}")).collect();
        let who = if matches!(label, Label::Wait(_)) { "both".to_string() } else { side(left_moves).to_string() };
        lines.push(format!("{who}: {label}; then {}", states.join(", ")));
    }
    lines.push(match &evidence.difference {
        Difference::Chances(place, one, two) => {
            let told = evidence.formulas.text(*place, LONGEST);
            let (one, two) = (chance(one), chance(two));
            format!("the left side then satisfies {told} with chance {one}, the right side with chance {two}")
        }
        Difference::Best(place, one, two) => {
            let told = evidence.formulas.text(*place, LONGEST);
            let (one, two) = (chance(one), chance(two));
            format!("the greatest chance of {told} is {one} on the left side, {two} on the right side")
        }
        Difference::Looks(one, two) => format!("the left side is {one}, the right side is {two}"),
        Difference::Step(left, label) => {
            format!("the {} side can do {label}, the {} side cannot", side(*left), side(!left))
        }
    });
    lines
}
