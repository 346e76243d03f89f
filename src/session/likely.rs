//! `probability of …`, `… with probability >= q`.

pub(super) mod missed;
mod read;
mod several;
mod timed;

use std::borrow::Cow;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::always::claim_of;
use super::beside::{BESIDE, relevant};
use super::claim::Found;
use super::digits::{LIKELY, decimal, estimate, rational, told};
use super::drawn::{durations_are_drawn, no_two_taken, once};
use super::reading::{Run, Waiting};
use super::rounds::{Grounds, how_far};
use crate::advance::ORDER;
use crate::criteria::Likely;
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::invariant::{Claim, PERIOD};
use crate::lower::{Environment, Likelihood, Method, System};
use crate::period::{self, Period};
use crate::probability::boxes::boxes;
use crate::probability::chain::{Chain, chain, curved};
use crate::probability::{Enclosed, Question, enclosed, estimated, exact, linear, schedule};
use crate::report::{Chance, Verdict};
use crate::value::{Relation, Value};
pub(super) use read::as_shown;
use timed::{followed, raced, run, scheduled};
pub(super) use timed::{many, sampled};

/// Runs of a simulation, and its seed.
const RUNS: u64 = 100_000;
const SEED: u64 = 1;

/// What is taken on trust where a chance is compared.
const PARTS: &str = "that the process goes through its parts, their draws and their delays in a line";
const CASES: &str = "that the cases of what is drawn are all, and their chances those of the draws";
const CHECKED: &str = "the kernel has checked every way of the phases, just one of which is taken";
const ORDERS: &str = "that several communications of one moment may come in any order, as each may with the first";
const MACHINE: &str = "the arithmetic of the machine, rounded outward";

/// A chance with how it was found.
struct Answer {
    chance: Chance,
    interval: Interval,
    /// Where it surely lies; none for a simulation.
    enclosed: Option<Enclosed>,
    lines: Vec<String>,
    /// What is taken on trust.
    trusted: Vec<String>,
}

impl Run<'_, '_> {
    pub(super) fn likely(
        &mut self,
        likelihood: &Likelihood,
        relation: Relation,
        threshold: &Value,
        waiting: &Waiting,
    ) -> Found {
        let mut found = Found::default();
        let (Ok(answer), Some(bound)) = (
            answer(likelihood, Some((relation, threshold)), &waiting.environment)
                .map_err(|reasons| found.remains = reasons),
            threshold.as_rational(),
        ) else {
            return found;
        };
        found.trace = answer.lines.clone();
        match answer.enclosed.as_ref().and_then(|enclosed| enclosed.compare(relation, &bound)) {
            Some(holds) => {
                found.verdict = Some(if holds { Verdict::Proved } else { Verdict::Refuted });
                found.trusted = answer.trusted.clone();
                match checked(likelihood, &mut found.trusted, &waiting.environment, &|| self.surroundings.interrupted())
                {
                    Ok(true) => found.trace.push(CHECKED.to_string()),
                    Ok(false) => {}
                    Err(why) => return Found { remains: vec![why], ..Found::default() },
                }
            }
            None => found.remains = vec![open(&answer, relation, threshold, &bound)],
        }
        found.chance = Some(answer.chance);
        found
    }

    /// What is said of a probability, and between what it lies; nothing where that is not known.
    pub(super) fn probability(&mut self, likelihood: &Likelihood, waiting: &Waiting) -> (Vec<String>, Option<Chance>) {
        match answer(likelihood, None, &waiting.environment) {
            Ok(answer) => (answer.lines, Some(answer.chance)),
            Err(reasons) => (reasons, None),
        }
    }
}

/// Whether the phases that a chance rests on are theorems, and just one way of them is always taken; then they are not
/// taken on trust.
///
/// # Errors
/// Why nothing can be said, where the phases say nothing.
fn checked(
    likelihood: &Likelihood,
    trusted: &mut Vec<String>,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<bool, String> {
    let phases = trusted.iter().position(|line| line == PERIOD);
    let (Some(place), Ok((system, ..))) = (phases, event(likelihood, environment)) else { return Ok(false) };
    let found = period::analyse(&system.components, &environment.definitions, &environment.assumptions);
    let Ok(period) = found else { return Ok(false) };
    let far = how_far(&period, &system, environment, interrupted);
    if far == Grounds::Raced {
        return Err(ORDER.to_string());
    }
    let known = far == Grounds::All && no_two_taken(&period);
    if known {
        trusted.remove(place);
    }
    Ok(known)
}

/// What remains where nothing is proved.
fn open(answer: &Answer, relation: Relation, threshold: &Value, bound: &BigRational) -> String {
    let ends = [answer.interval.low, answer.interval.high].map(BigRational::from_float);
    let holds = ends.map(|end| end.map(|end| relation.holds(end.cmp(bound))));
    match holds {
        [Some(low), Some(high)] if low == high && answer.enclosed.is_none() => {
            let side = if low { "for" } else { "against" };
            format!("a simulation proves nothing; it speaks {side} the claim")
        }
        _ => work(answer, threshold),
    }
}

/// What it would take to decide.
fn work(answer: &Answer, threshold: &Value) -> String {
    let interval = &answer.interval;
    let here = format!("{threshold} lies between {} and {}", decimal(interval.low), decimal(interval.high));
    match answer.chance.runs {
        Some(runs) => {
            let target = threshold.as_rational().map_or(0.5, |number| Interval::of(&number).low);
            // Where all runs end alike, an interval for as many runs of that kind ends at the threshold.
            let alike = [(interval.low <= 0.0, target), (interval.high >= 1.0, 1.0 - target)];
            if let Some((_, far)) = alike.into_iter().find(|(alike, far)| *alike && *far > 0.0) {
                let needed = (((1.0 - estimated::CONFIDENCE) / 2.0).ln() / (-far).ln_1p()).ceil();
                return format!(
                    "{here}: it would take some {needed:.0} runs to tell them apart, if all end as these did"
                );
            }
            let middle = f64::midpoint(interval.low, interval.high);
            let apart = (middle - target).abs().max(1e-9);
            let needed = runs as f64 * (interval.width() / 2.0 / apart).powi(2);
            format!("{here}: it would take some {needed:.0} runs to tell them apart, if the share stays as it is")
        }
        None if interval.width() < CLOSE => {
            format!("{here}, and bounds as close as these are all that machine numbers give here")
        }
        None => {
            let target = threshold.as_rational().map_or(0.5, |number| Interval::of(&number).low);
            let (middle, width) = (f64::midpoint(interval.low, interval.high), interval.width());
            if target <= 0.0 || target >= 1.0 {
                return format!(
                    "{here}: this method comes no closer than {width:.1e} here, and no number of simulated runs tells \
                     whether it is {threshold}"
                );
            }
            let apart = (middle - target).abs().max(width / 10.0);
            let needed = (middle * (1.0 - middle) * (DEVIATIONS / apart).powi(2)).ceil();
            format!(
                "{here}: this method comes no closer than {width:.1e} here; a simulation, which proves nothing, would take \
                 some {needed:.0e} runs to speak for one side if they are {apart:.1e} apart (`by estimated`)"
            )
        }
    }
}

/// A probability, for criteria.
pub(super) fn chances(likelihood: &Likelihood, environment: &Environment) -> Result<Likely, Vec<String>> {
    let mut answer = answer(likelihood, None, environment)?;
    checked(likelihood, &mut answer.trusted, environment, &|| false).map_err(|why| vec![why])?;
    let Chance { low, high, method, .. } = answer.chance;
    Ok(Likely {
        low,
        high,
        sure: method != "estimated",
        method,
        number: answer.enclosed.and_then(|enclosed| enclosed.number().cloned()),
        trusted: answer.trusted,
    })
}

/// What is shown at the time asked for, where that is known exactly: names with their distributions.
pub(super) fn distributions(
    likelihood: &Likelihood,
    environment: &Environment,
) -> Vec<(crate::name::Name, Distribution)> {
    let asked = asked(likelihood, environment);
    let exact = asked.ok().and_then(|(chain, question)| exact::exact(&chain, &question).ok());
    exact.map(|exact| exact.shown).unwrap_or_default()
}

/// Finds a chance, in the part of the system that it is about.
fn answer(
    likelihood: &Likelihood,
    threshold: Option<(Relation, &Value)>,
    environment: &Environment,
) -> Result<Answer, Vec<String>> {
    if let Some(found) = several::several(likelihood, environment) {
        return Ok(found);
    }
    let mut found = sought(likelihood, threshold, environment).map_err(without_value)?;
    if let Ok((Cow::Owned(_), ..)) = event(likelihood, environment) {
        found.trusted.push(BESIDE.to_string());
    }
    Ok(found)
}

/// Where a parameter has no value, that is the reason.
fn without_value(reasons: Vec<String>) -> Vec<String> {
    let missing = reasons.iter().find_map(|reason| reason.strip_suffix(" has no value here"));
    let Some(name) = missing.and_then(|line| line.rsplit(' ').next()) else { return reasons };
    let example = name.trim_matches('`');
    vec![
        format!("{name} has no value, and a chance is computed where every parameter that matters is a number:"),
        format!("declare one with `param {example} = …`, or look at several with `sweep {example} in …`"),
    ]
}

/// Finds a chance: by the method that is named, or by the first that applies.
fn sought(
    likelihood: &Likelihood,
    threshold: Option<(Relation, &Value)>,
    environment: &Environment,
) -> Result<Answer, Vec<String>> {
    // Rounds of drawn length are no chain, and may be many.
    let mut unraced = None;
    if let Ok((system, ..)) = event(likelihood, environment)
        && durations_are_drawn(&system.term(&environment.definitions), environment)
    {
        let found = followed(likelihood, environment).or_else(|| scheduled(likelihood, environment).ok());
        if let Some(answer) = found.or_else(|| raced(likelihood, environment).map_err(|reason| unraced = reason).ok()) {
            return Ok(answer);
        }
    }
    let (chain, question) = match asked(likelihood, environment) {
        Ok(asked) => asked,
        Err(reasons) => match around(likelihood, threshold, environment) {
            Some(Ok(answer)) => return Ok(answer),
            Some(Err(reason)) => return without_rounds(likelihood, environment, vec![reason], unraced),
            None => return without_rounds(likelihood, environment, reasons, unraced),
        },
    };
    let methods: &[Method] = match &likelihood.method {
        Some(method) => std::slice::from_ref(method),
        None => &[Method::Exact, Method::Enclosed, Method::Estimated],
    };
    let mut reasons = Vec::new();
    for method in methods {
        let simulated = (likelihood.runs.unwrap_or(RUNS), likelihood.seed.unwrap_or(SEED));
        let found = by_method(*method, &chain, &question, threshold, simulated);
        let exactly = |reason| match method {
            Method::Exact => followed(likelihood, environment).ok_or(reason),
            Method::Enclosed => boxed(likelihood, environment, &|_| true).ok_or(reason),
            Method::Estimated => Err(reason),
        };
        match found.or_else(exactly) {
            Ok(answer) => {
                let mut answer = more_closely(answer, likelihood, environment);
                answer.lines.extend(reasons.iter().map(|reason| format!("note: {reason}")));
                return Ok(answer);
            }
            Err(reason) => reasons.push(format!("not {}: {reason}", name(*method))),
        }
    }
    Err(reasons)
}

/// The answer for a system that compares distances in the plane; none where it does not.
fn around(
    likelihood: &Likelihood,
    threshold: Option<(Relation, &Value)>,
    environment: &Environment,
) -> Option<Result<Answer, String>> {
    if !matches!(likelihood.method, None | Some(Method::Enclosed)) {
        return None;
    }
    let (system, event, question) = event(likelihood, environment).ok()?;
    let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions).ok()?;
    let chain = curved(&period, &event, &environment.assumptions).ok()?;
    Some(by_method(Method::Enclosed, &chain.with_lasting_ends(&question), &question, threshold, (RUNS, SEED)))
}

/// The answer for a system that draws a few numbers in all, if its phases are such; none where it draws more, or too much
/// stays open.
fn boxed(likelihood: &Likelihood, environment: &Environment, may: &dyn Fn(&Period) -> bool) -> Option<Answer> {
    if !matches!(likelihood.method, None | Some(Method::Enclosed)) {
        return None;
    }
    let (system, event, question) = event(likelihood, environment).ok()?;
    let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions).ok()?;
    let found = if may(&period) { boxes(&period, &event, &question).ok()? } else { return None };
    Some(surely(found, Method::Enclosed, Vec::new(), PERIOD))
}

/// The answer, or a closer one by boxes, where it is wide and all that is drawn is drawn before the first phase: a number
/// with a jump in its density is followed better by itself than on a grid.
fn more_closely(answer: Answer, likelihood: &Likelihood, environment: &Environment) -> Answer {
    if answer.chance.method != name(Method::Enclosed) || answer.interval.width() < JUMPY {
        return answer;
    }
    let at_first = |period: &Period| period.phases.iter().all(|one| one.edges.iter().all(|edge| edge.draws.is_empty()));
    let closer = boxed(likelihood, environment, &at_first);
    closer.filter(|closer| closer.interval.width() < answer.interval.width()).unwrap_or(answer)
}

/// Why there is no answer, method by method.
type Reasons = Vec<String>;

/// The answer for a system that is no chain of linear rounds, for these reasons; where it draws durations, for the reason
/// why its cases were not followed.
fn without_rounds(
    likelihood: &Likelihood,
    environment: &Environment,
    mut reasons: Reasons,
    unraced: Option<String>,
) -> Result<Answer, Reasons> {
    if let Some(answer) = followed(likelihood, environment) {
        return Ok(answer);
    }
    if let Some(answer) = boxed(likelihood, environment, &|_| true) {
        return Ok(answer);
    }
    let raced = unraced.is_some();
    if let Some(reason) = unraced {
        reasons = vec![reason];
    }
    let note = match scheduled(likelihood, environment) {
        Ok(answer) => return Ok(answer),
        Err(reason) if (reason == schedule::SEVERAL || raced) && !reasons.is_empty() => {
            format!("neither exact nor enclosed: {}", reasons.join("; "))
        }
        Err(reason) => {
            reasons.extend((reasons.join("; ") != reason).then(|| format!("not exact: {reason}")));
            reasons.last().cloned().unwrap_or_default()
        }
    };
    let mut answer = run(likelihood, environment).unwrap_or(Err(Vec::new())).map_err(|more| once(reasons, more))?;
    answer.lines.push(format!("note: {note}"));
    Ok(answer)
}

fn surely(found: Enclosed, method: Method, mut lines: Vec<String>, trusted: &str) -> Answer {
    lines.insert(0, format!("probability {} ({})", told(&found), name(method)));
    let interval @ Interval { low, high } = found.interval();
    let chance = Chance { low, high, method: name(method), confidence: None, runs: None };
    let trusted = trust(trusted, Some(&found));
    Answer { chance, interval, enclosed: Some(found), lines, trusted }
}

/// What is taken on trust: where a chance is a rational, no arithmetic of the machine.
fn trust(first: &str, found: Option<&Enclosed>) -> Vec<String> {
    let rounded = found.is_none_or(|found| found.number().is_none());
    [first].into_iter().chain(rounded.then_some(MACHINE)).map(str::to_string).collect()
}

/// The system as a chain, and what is asked of it.
pub(super) fn asked(likelihood: &Likelihood, environment: &Environment) -> Result<(Chain, Question), Vec<String>> {
    let (system, event, question) = event(likelihood, environment)?;
    let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions)
        .map_err(|failures| failures.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    let chain = chain(&period, &event, &environment.assumptions).map_err(|reason| vec![reason])?;
    Ok((chain.with_lasting_ends(&question), question))
}

/// The system, what is to be shown, and when.
fn event<'e>(
    likelihood: &Likelihood,
    environment: &'e Environment,
) -> Result<(Cow<'e, System>, Claim, Question), Vec<String>> {
    let Some(system) = environment.system(&likelihood.system) else {
        return Err(vec![format!("there is no system {}", likelihood.system)]);
    };
    let (pattern, first, time) = read::shown(likelihood, environment)?;
    let time = time.as_rational().ok_or_else(|| vec![format!("the time {time} must be a number")])?;
    if time.is_negative() {
        return Err(vec![format!("the time {} is past: times count from the start, which is 0", rational(&time))]);
    }
    let question = Question { first, time, names: pattern.variables.iter().cloned().collect() };
    let relevant = relevant(system, &pattern.terms, environment);
    Ok((relevant.map_or(Cow::Borrowed(system), Cow::Owned), claim_of(&pattern), question))
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::Enclosed => "enclosed",
        Method::Estimated => "estimated",
    }
}

/// Rounds from which on mean and variance are no longer computed as rationals.
const FAR: u64 = 300;
/// So wide an interval is looked at by boxes, too.
const JUMPY: f64 = 1e-5;
/// An interval that is not narrower for want of digits alone, and the standard deviations of a share to either side.
const CLOSE: f64 = 1e-11;
const DEVIATIONS: f64 = 2.6;
/// How wide an enclosed chance may be; where a threshold lies in it, a narrower one is looked for.
const WIDTH: f64 = 1e-8;
const NARROW: f64 = 1e-12;

fn enclosed_for(chain: &Chain, question: &Question, threshold: Option<(Relation, &Value)>) -> Result<Enclosed, String> {
    let found = enclosed::enclosed(chain, question, WIDTH)?;
    let Some((relation, bound)) = threshold else { return Ok(found) };
    match bound.as_rational().map(|bound| found.compare(relation, &bound)) {
        Some(None) => Ok(enclosed::enclosed(chain, question, NARROW).unwrap_or(found)),
        _ => Ok(found),
    }
}

fn by_method(
    method: Method,
    chain: &Chain,
    question: &Question,
    threshold: Option<(Relation, &Value)>,
    (runs, seed): (u64, u64),
) -> Result<Answer, String> {
    let mut share = f64::NAN;
    let (interval, enclosed, runs, mut lines) = match method {
        Method::Exact => {
            let moments = linear::moments(chain, question);
            let far = moments.as_ref().ok().filter(|moments| moments.rounds() > FAR).map(linear::Moments::chance);
            let (chance, mut lines) = match far {
                Some(Ok(chance)) => (chance, Vec::new()),
                _ => {
                    let exact = exact::exact(chain, question)?;
                    let lines = exact.shown.iter().flat_map(|(name, parts)| described(name.as_str(), parts));
                    (exact.chance, lines.collect::<Vec<String>>())
                }
            };
            if let Ok(solved) = moments.and_then(|moments| moments.solved()) {
                lines.push("after n rounds, by induction:".to_string());
                lines.extend(solved.lines().iter().map(|line| format!("  {line}")));
            }
            (chance.interval(), Some(chance), None, lines)
        }
        Method::Enclosed => {
            let found = enclosed_for(chain, question, threshold)?;
            (found.interval(), Some(found), None, Vec::new())
        }
        Method::Estimated => {
            let found = estimated::estimated(chain, question, runs, seed)?;
            let (runs, how) = (found.runs, found.how());
            let line = format!("{runs} runs{how}, seed {seed}, confidence {}", estimated::CONFIDENCE);
            // Of what happened always or never the middle of what is likely says more.
            share = if found.share < 1.0 { found.share } else { f64::midpoint(found.low, found.high) };
            (Interval::between(found.low, found.high), None, Some(found.runs), vec![line])
        }
    };
    let method = name(method);
    let text = enclosed.as_ref().map_or_else(|| estimate(&interval, share, LIKELY), told);
    lines.insert(0, format!("probability {text} ({method})"));
    let chance = Chance {
        low: interval.low,
        high: interval.high,
        method,
        confidence: runs.map(|_| estimated::CONFIDENCE),
        runs,
    };
    let trusted = trust(PERIOD, enclosed.as_ref());
    Ok(Answer { chance, interval, enclosed, lines, trusted })
}

/// Mean and variance, exactly where that is short, and as decimals.
fn described(name: &str, parts: &Distribution) -> Vec<String> {
    if parts.variance().is_zero() {
        return vec![format!("{name} is {}, whatever is drawn", rational(&parts.mean()))];
    }
    let kind = match parts {
        Distribution::Mixture(all) if all.len() > 1 && all.iter().all(|(_, part)| part.variance().is_zero()) => {
            format!("one of {} values", all.len())
        }
        Distribution::Mixture(all) if all.len() > 1 => format!("a mixture of {} normal parts", all.len()),
        _ => "normal".to_string(),
    };
    vec![format!(
        "{name} is {kind}, with mean {} and variance {}",
        rational(&parts.mean()),
        rational(&parts.variance())
    )]
}
