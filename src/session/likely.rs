//! `probability of …`, `… with probability >= q`.

use num_rational::BigRational;

use super::always::claim_of;
use super::claim::Found;
use super::drawn::{durations_are_drawn, no_two_taken, once};
use super::reading::{Run, Waiting};
use super::rounds::{Grounds, how_far};
use crate::criteria::Likely;
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::invariant::Claim;
use crate::lower::{Environment, Event, Likelihood, Method, Pattern, Property, System};
use crate::period;
use crate::probability::chain::{Chain, chain};
use crate::probability::{Enclosed, Question, branches, direct, enclosed, estimated, exact, linear, schedule};
use crate::report::{Chance, Verdict};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Runs of a simulation, and its seed.
const RUNS: u64 = 100_000;
const SEED: u64 = 1;

/// What is taken on trust where a chance is compared.
const PARTS: &str = "that the process goes through its parts, their draws and their delays in a line";
const PHASES: &str = "that the phases with their flow functions, as printed, are all that the system does";
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
                if checked(likelihood, &mut found.trusted, &waiting.environment, &|| self.surroundings.interrupted()) {
                    found.trace.push(CHECKED.to_string());
                }
            }
            None => found.remains = vec![open(&answer, relation, threshold, &bound)],
        }
        found.chance = Some(answer.chance);
        found
    }

    pub(super) fn probability(&mut self, likelihood: &Likelihood, waiting: &Waiting) -> Vec<String> {
        match answer(likelihood, None, &waiting.environment) {
            Ok(answer) => answer.lines,
            Err(reasons) => reasons,
        }
    }
}

/// Whether the phases that a chance rests on are theorems, and just one way of them is always taken; then they are not
/// taken on trust.
fn checked(
    likelihood: &Likelihood,
    trusted: &mut Vec<String>,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> bool {
    let phases = trusted.iter().position(|line| line == PHASES);
    let (Some(place), Ok((system, ..))) = (phases, event(likelihood, environment)) else { return false };
    let found = period::analyse(&system.components, &environment.definitions, &environment.assumptions);
    let known = found.is_ok_and(|period| {
        no_two_taken(&period) && how_far(&period, system, environment, interrupted) == Grounds::All
    });
    if known {
        trusted.remove(place);
    }
    known
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
            let middle = f64::midpoint(interval.low, interval.high);
            let apart = (middle - target).abs().max(1e-9);
            let needed = runs as f64 * (interval.width() / 2.0 / apart).powi(2);
            format!("{here}: it would take some {needed:.0} runs to tell them apart, if the share stays as it is")
        }
        None => format!("{here}, and bounds as close as these are all that machine numbers give here"),
    }
}

/// A probability, for criteria.
pub(super) fn chances(likelihood: &Likelihood, environment: &Environment) -> Result<Likely, Vec<String>> {
    let mut answer = answer(likelihood, None, environment)?;
    checked(likelihood, &mut answer.trusted, environment, &|| false);
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

/// Finds a chance: by the method that is named, or by the first that applies.
fn answer(
    likelihood: &Likelihood,
    threshold: Option<(Relation, &Value)>,
    environment: &Environment,
) -> Result<Answer, Vec<String>> {
    let (chain, question) = match asked(likelihood, environment) {
        Ok(asked) => asked,
        Err(reasons) => return without_rounds(likelihood, environment, reasons),
    };
    let methods: &[Method] = match &likelihood.method {
        Some(method) => std::slice::from_ref(method),
        None => &[Method::Exact, Method::Enclosed, Method::Estimated],
    };
    let mut reasons = Vec::new();
    for method in methods {
        let found = by_method(*method, &chain, &question, threshold);
        let exactly = |reason| match method {
            Method::Exact => followed(likelihood, environment).ok_or(reason),
            _ => Err(reason),
        };
        match found.or_else(exactly) {
            Ok(mut answer) => {
                answer.lines.extend(reasons.iter().map(|reason| format!("note: {reason}")));
                return Ok(answer);
            }
            Err(reason) => reasons.push(format!("not {}: {reason}", name(*method))),
        }
    }
    Err(reasons)
}

/// Why there is no answer, method by method.
type Reasons = Vec<String>;

/// The answer for a system that is no chain of linear rounds, for these reasons.
fn without_rounds(likelihood: &Likelihood, environment: &Environment, mut reasons: Reasons) -> Result<Answer, Reasons> {
    if let Some(answer) = followed(likelihood, environment) {
        return Ok(answer);
    }
    let note = match scheduled(likelihood, environment) {
        Ok(answer) => return Ok(answer),
        Err(reason) if reason == schedule::SEVERAL && !reasons.is_empty() => {
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

/// The answer for one process that draws how long it lasts.
fn scheduled(likelihood: &Likelihood, environment: &Environment) -> Result<Answer, String> {
    let (system, event, question) = event(likelihood, environment).map_err(|reasons| reasons.join("; "))?;
    let found = schedule::schedule(&system.components, &environment.definitions, &event, &question)?;
    let method = if found.wide { Method::Enclosed } else { Method::Exact };
    if likelihood.method.is_some_and(|asked| asked != method) {
        return Err(format!("it is {} only", name(method)));
    }
    let lines = below(&system.term(&environment.definitions), environment);
    Ok(surely(found.chance, method, lines, PARTS))
}

/// The answer by all branches of the executable meaning, of which hardly anything is left to trust; none where there are
/// too many.
fn followed(likelihood: &Likelihood, environment: &Environment) -> Option<Answer> {
    if !matches!(likelihood.method, None | Some(Method::Exact)) {
        return None;
    }
    let (system, event, question) = event(likelihood, environment).ok()?;
    let term = system.term(&environment.definitions);
    let found = branches::branches(&term, &environment.definitions, &event, &question).ok()?;
    let mut lines = vec!["all branches of the executable meaning were followed".to_string()];
    lines.extend(below(&term, environment));
    let trusted = if found.orders { vec![ORDERS.to_string()] } else { Vec::new() };
    Some(Answer { trusted, ..surely(found.chance, Method::Exact, lines, PARTS) })
}

/// What is said of durations that are drawn.
fn below(system: &Term, environment: &Environment) -> Vec<String> {
    let said = durations_are_drawn(system, environment);
    said.then(|| "a duration that is drawn below 0 counts as 0".to_string()).into_iter().collect()
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

/// A chance that is known exactly, as far as it can be printed.
fn told(found: &Enclosed) -> String {
    found.number().map_or_else(|| between(&found.interval(), SURE), rational)
}

/// The longest rational that is printed, in bytes.
const LONG: usize = 40;

/// A rational exactly, where that is short, and as a decimal.
fn rational(number: &BigRational) -> String {
    let near = decimal(num_traits::ToPrimitive::to_f64(number).unwrap_or(f64::NAN));
    let exact = Value::rational(number.clone()).to_string();
    if exact == near || exact.len() > LONG { near } else { format!("{exact} = {near}") }
}

/// The answer by runs of the executable meaning; none where another method is asked for.
fn run(likelihood: &Likelihood, environment: &Environment) -> Option<Result<Answer, Vec<String>>> {
    if !matches!(likelihood.method, None | Some(Method::Estimated)) {
        return None;
    }
    let answer = || -> Result<Answer, Vec<String>> {
        let (system, event, question) = event(likelihood, environment)?;
        let term = system.term(&environment.definitions);
        let found = direct::direct(&term, &environment.definitions, &event, &question, SEED)
            .map_err(|reason| vec![format!("not estimated: {reason}")])?;
        let interval = Interval::between(found.low, found.high);
        let mut lines = vec![
            format!("probability {} (estimated)", between(&interval, LIKELY)),
            format!("{} runs of the executable meaning, seed {SEED}, confidence {}", found.runs, estimated::CONFIDENCE),
        ];
        lines.extend(below(&term, environment));
        let Interval { low, high } = interval;
        let (confidence, runs) = (Some(estimated::CONFIDENCE), Some(found.runs));
        let chance = Chance { low, high, method: name(Method::Estimated), confidence, runs };
        Ok(Answer { chance, interval, enclosed: None, lines, trusted: trust(PHASES, None) })
    };
    Some(answer())
}

/// The system as a chain, and what is asked of it.
pub(super) fn asked(likelihood: &Likelihood, environment: &Environment) -> Result<(Chain, Question), Vec<String>> {
    let (system, event, question) = event(likelihood, environment)?;
    let period = period::analyse(&system.components, &environment.definitions, &environment.assumptions)
        .map_err(|failures| failures.iter().map(ToString::to_string).collect::<Vec<_>>())?;
    let chain = chain(&period, &event, &environment.assumptions).map_err(|reason| vec![reason])?;
    Ok((chain, question))
}

/// The system, what is to be shown, and when.
fn event<'e>(
    likelihood: &Likelihood,
    environment: &'e Environment,
) -> Result<(&'e System, Claim, Question), Vec<String>> {
    let Some(system) = environment.system(&likelihood.system) else {
        return Err(vec![format!("there is no system {}", likelihood.system)]);
    };
    let (pattern, first, time) = match &likelihood.event {
        Event::Shown { first, pattern, time } => (pattern.clone(), *first, time.clone()),
        Event::Satisfies(property) => read(environment.property(property)).ok_or_else(|| {
            vec![
                format!("the probability of {property} is understood for `Delay_d ; At_a`,"),
                "and for `Ran_D<x> ; Delay_x ; At_a where P(x <= d) >= q` with a distribution D that is a parameter"
                    .to_string(),
                "ask for `probability of Sys reaching At_a within d`, or `showing At_a at d`".to_string(),
            ]
        })?,
    };
    let time = time.as_rational().ok_or_else(|| vec![format!("the time {time} must be a number")])?;
    let question = Question { first, time, names: pattern.variables.iter().cloned().collect() };
    Ok((system, claim_of(&pattern), question))
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
) -> Result<Answer, String> {
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
            let found = estimated::estimated(chain, question, RUNS, SEED)?;
            let (runs, how) = (found.runs, found.how());
            let line = format!("{runs} runs{how}, seed {SEED}, confidence {}", estimated::CONFIDENCE);
            (Interval::between(found.low, found.high), None, Some(found.runs), vec![line])
        }
    };
    let method = name(method);
    let text = enclosed.as_ref().map_or_else(|| between(&interval, LIKELY), told);
    lines.insert(0, format!("probability {text} ({method})"));
    let chance = Chance {
        low: interval.low,
        high: interval.high,
        method,
        confidence: runs.map(|_| estimated::CONFIDENCE),
        runs,
    };
    let trusted = trust(PHASES, enclosed.as_ref());
    Ok(Answer { chance, interval, enclosed, lines, trusted })
}

/// How wide an interval is at most, in units of the last digit that is printed.
const SURE: f64 = 0.5;
const LIKELY: f64 = 5.0;

/// The middle, to as many digits as are worth it, and the ends. What is printed lies in the interval.
fn between(interval: &Interval, units: f64) -> String {
    if interval.low == interval.high {
        return decimal(interval.low);
    }
    let middle = f64::midpoint(interval.low, interval.high);
    // The place of the first digit; of what may be 0, no digit is known.
    let first = if interval.low > 0.0 { middle.log10().floor() as i32 } else { 0 };
    let mut places = 12 - first;
    while places > 1 && interval.width() > units * 10f64.powi(-places) {
        places -= 1;
    }
    let ends = format!("between {} and {}", decimal(interval.low), decimal(interval.high));
    if interval.low <= 0.0 && interval.high < SMALL {
        return format!("at most {}, {ends}", decimal(interval.high));
    }
    let written = |places: i32| match middle < SMALL {
        true => format!("{middle:.digits$e}", digits = usize::try_from(places + first).unwrap_or_default()),
        false => format!("{middle:.places$}", places = usize::try_from(places).unwrap_or_default()),
    };
    let outside =
        |places: i32| written(places).parse().is_ok_and(|number: f64| number < interval.low || number > interval.high);
    let inside = (places..places + MOST_DIGITS).find(|places| !outside(*places)).unwrap_or(places);
    format!("{}, {ends}", written(inside))
}

/// Digits that a number of the machine has.
const MOST_DIGITS: i32 = 17;

/// Below this a number is written with a power of ten.
const SMALL: f64 = 1e-4;

/// The shortest text that is read as this number.
fn decimal(number: f64) -> String {
    if number != 0.0 && number.abs() < SMALL { format!("{number:e}") } else { number.to_string() }
}

/// Mean and variance, exactly where that is short, and as decimals.
fn described(name: &str, parts: &Distribution) -> Vec<String> {
    let kind = match parts {
        Distribution::Mixture(all) if all.len() > 1 => format!("a mixture of {} normal parts", all.len()),
        _ => "normal".to_string(),
    };
    vec![format!(
        "{name} is {kind}, with mean {} and variance {}",
        rational(&parts.mean()),
        rational(&parts.variance())
    )]
}

/// What a property asks for, whether any time up to the given one counts, and that time: `Delay_d ; At_a` asks what is
/// shown at d; `Ran_D<x> ; Delay_x ; At_a where P(x <= d) >= q` with an unknown D says that there is a distribution of
/// the time of arrival of which this holds, so it asks for the first passage.
fn read(property: Option<&Property>) -> Option<(Pattern, bool, Value)> {
    let Property { body, within, .. } = property?;
    let Node::Seq(parts) = body.as_ref()?.node() else { return None };
    let (drawn, delay, shown) = match parts.as_slice() {
        [delay, shown] => (None, delay, shown),
        [drawn, delay, shown] => (Some(drawn), delay, shown),
        _ => return None,
    };
    let (Node::Delay(time), Node::Observe(..)) = (delay.node(), shown.node()) else { return None };
    let pattern = Pattern { terms: vec![shown.clone()], variables: Default::default(), conditions: Vec::new() };
    match (drawn.map(Term::node), within) {
        (None, None) => Some((pattern, false, time.clone())),
        (Some(Node::Ran(distribution, name)), Some((latest, ..))) => {
            let arrival = time.as_variable() == Some(name) && distribution.as_variable().is_some();
            arrival.then(|| (pattern, true, latest.clone()))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_lies_in_the_interval() {
        for exponent in -20..0 {
            for (low, width) in [(1.34, 0.07), (1.3418, 0.0737), (9.96, 0.02), (5.5, 1e-9), (1.0, 8.0), (4.4999, 1e-4)]
            {
                for units in [SURE, LIKELY] {
                    let scale = 10f64.powi(exponent);
                    let interval = Interval::between(low * scale, (low + width) * scale);
                    let text = between(&interval, units);
                    let first: f64 = text.split(',').next().and_then(|number| number.parse().ok()).unwrap();
                    assert!(interval.low <= first && first <= interval.high, "{text}");
                }
            }
        }
    }
}
