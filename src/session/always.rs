//! `Sys always C`.

use num_traits::ToPrimitive;

use super::beside::{BESIDE, Leaving, READERS, relevant, without_readers};
use super::claim::Found;
use super::delays::{MOST_CLAIMED, Order, in_orders};
use super::instances::{broken_instance, labelled};
use super::parts::large_part;
use super::reading::{Run, Waiting};
use super::rounds::{Grounds, how_far};
use super::satisfies::{phase_lines, said};
use crate::assumption::Assumptions;
use crate::connectivity::connectivity;
use crate::criteria::digits;
use crate::definition::Definitions;
use crate::invariant::circle::{COSINE, QUARTER};
use crate::invariant::{Claim, Safe};
use crate::lower::{Environment, Pattern};
use crate::name::Name;
use crate::period::Test;
use crate::replay::replays;
use crate::report::Verdict;
use crate::safety::{self, orbit};
use crate::term::Term;
use crate::value::{Atom, Value};

/// The most states of a run that are printed, and those of them that are its last.
const MOST_STATES: usize = 60;
const LAST_STATES: usize = 10;
/// The bits of a number that is rounded there.
const LONG: u64 = 128;

/// The longest left side that is printed, in bytes.
const WIDE: usize = 80;

/// What is left to trust of the phases once the kernel has checked the ways between them.
pub(super) const WAYS: &str =
    "that in each phase one of its ways is taken; that each does what is printed, the kernel has checked";

/// Said where nothing is left to trust of them.
pub(super) const EVERY_WAY: &str = "the kernel has checked every way of the phases, one of which is taken";

impl Run<'_, '_> {
    pub(super) fn always(
        &mut self,
        system: &Name,
        pattern: &Pattern,
        property: Option<&Name>,
        waiting: &Waiting,
    ) -> Found {
        self.always_under(system, (pattern, property), &waiting.environment, MOST_CLAIMED)
    }

    /// The same under what was declared, and where it is not known which of two delays ends first in each order; `most`: so
    /// many times.
    fn always_under(
        &mut self,
        system: &Name,
        (pattern, property): (&Pattern, Option<&Name>),
        environment: &Environment,
        most: usize,
    ) -> Found {
        let name = system;
        let Some(system) = environment.system(system) else { return Found::default() };
        let claim = claim_of(pattern);
        let mut found = Found::default();
        found.trace.extend(property.map(|property| meant(property, &claim)));
        let observers: Vec<Name> = pattern.observers().into_iter().collect();
        let links = connectivity(&system.components, &observers, &environment.definitions);
        if !observers.is_empty() {
            found.trace.extend(links.lines());
        }
        let term = system.term(&environment.definitions);
        let interrupted = || self.surroundings.interrupted();
        let instances = |tests: &[Test]| labelled(&term, &claim, environment, tests, &interrupted);
        // Many ways side by side are not followed where what is asked for is shown by some of the parts alone.
        let large = large_part(system, &claim.shown, environment, &interrupted);
        let asked = safety::Asked {
            instances: &instances,
            components: &large.as_ref().unwrap_or(system).components,
            claim: &claim,
            definitions: &environment.definitions,
            assumptions: &environment.assumptions,
            interrupted: &interrupted,
        };
        let mut outcome = safety::always(&term, asked);
        let open = matches!(outcome.verdict, safety::Verdict::Open);
        let left_out = || {
            let alone = |leaving: Leaving, why| Some((leaving(system, &claim.shown, environment)?, why));
            alone(relevant, BESIDE).or_else(|| alone(without_readers, READERS))
        };
        let part = if open && large.is_none() { left_out() } else { None };
        if let Some((part, why)) = &part {
            let term = part.term(&environment.definitions);
            let instances = |tests: &[Test]| labelled(&term, &claim, environment, tests, &interrupted);
            let asked = safety::Asked { components: &part.components, instances: &instances, ..asked };
            let alone = safety::always(&term, asked);
            if matches!(alone.verdict, safety::Verdict::Proved(_)) {
                outcome = alone;
                found.trusted.push(why.to_string());
            }
        }
        if matches!(outcome.verdict, safety::Verdict::Open) {
            let each = |order: &Order| self.always_under(name, (pattern, property), &order.environment, most - 1);
            let (orders, cases) = in_orders(&outcome.diagnostics, environment, most, each);
            if let Some(found) = Found::in_each(&orders, cases, true) {
                return found;
            }
        }
        if large.is_some() && matches!(outcome.verdict, safety::Verdict::Proved(_)) {
            found.trusted.push(BESIDE.to_string());
        }
        // Of a part, no more is said than is proved.
        let part = part.map(|(part, _)| part).or(large);
        let system = part.as_ref().filter(|_| !found.trusted.is_empty()).unwrap_or(system);
        let refuted = matches!(outcome.verdict, safety::Verdict::Refuted(_));
        if let Some(period) = outcome.period.as_ref().filter(|_| !refuted) {
            found.trace.extend(phase_lines(period, &system.name, environment));
        }
        found.trace.extend(outcome.diagnostics.iter().map(|failure| format!("note: {failure}")));
        match &outcome.verdict {
            safety::Verdict::Proved(safe) => {
                found.verdict = Some(Verdict::Proved);
                found.trace.extend(grounds(safe, &outcome.invariant));
                found.trace.extend(enclosed(&claim).filter(|_| safe.inequalities() > 0));
                found.trace.extend(outcome.extreme.clone());
                found.trace.extend(never_together(&claim, &outcome));
                let period = outcome.period.as_ref().filter(|_| !safe.trusted().is_empty());
                let far = period.map(|period| how_far(period, system, environment, &interrupted));
                rests_on(far, safe.trusted(), &mut found);
            }
            safety::Verdict::Refuted(run) => {
                let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
                broken(&term, definitions, run, (&claim, assumptions), &mut found);
            }
            safety::Verdict::Open => {
                found.remains = outcome.remaining.iter().map(|line| said(line)).collect();
                found.trace.extend(enclosed(&claim));
                by_instance((&term, &outcome.conditions), &claim, environment, &interrupted, &mut found);
            }
        }
        found.feedback.extend(conditions(&outcome.conditions));
        found
    }
}

/// The states of a run, a line each: of a long one the first and the last, with long numbers rounded.
fn states(shown: &orbit::Shown) -> Vec<String> {
    let line = |(time, shown): &(Value, Vec<Term>)| {
        let near = |value: &Value| {
            Ok::<_, ()>(rounded(value).map_or_else(|| value.clone(), |near| Value::variable(&Name::new(&near))))
        };
        let read = |term: &Term| term.map_values(&mut { near }).unwrap_or_else(|()| term.clone()).to_string();
        let shown: Vec<String> = shown.iter().map(read).collect();
        format!("  at {time}: {}", shown.join(", "))
    };
    if shown.len() <= MOST_STATES {
        return shown.iter().map(line).collect();
    }
    let (first, rest) = shown.split_at(MOST_STATES - LAST_STATES);
    let (between, last) = rest.split_at(rest.len() - LAST_STATES);
    let more = format!("  … {} states more, all as claimed", between.len());
    first.iter().map(line).chain([more]).chain(last.iter().map(line)).collect()
}

/// The leading digits of a long number, behind `≈`; none where it is too large or too small to tell them so.
fn rounded(value: &Value) -> Option<String> {
    let long = value.as_rational().filter(|number| number.numer().bits() + number.denom().bits() > LONG)?;
    let near = long.to_f64().filter(|near| near.is_finite() && *near != 0.0)?;
    Some(format!("≈{}", digits(near)))
}

/// The same of what is compared with another, as long as the digits tell the one from the other.
fn rounded_beside(value: &Value, other: &Value) -> Option<String> {
    let near = |value: &Value| value.as_rational()?.to_f64();
    rounded(value).filter(|_| near(value) != near(other))
}

/// What a property says, in the words of a claim.
fn meant(property: &Name, claim: &Claim) -> String {
    let (tests, shown) = (listed(&claim.tests, ", "), listed(&claim.shown, ", "));
    format!("{property} says: always {tests} when {shown}")
}

fn listed<T: ToString>(all: &[T], between: &str) -> String {
    all.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}

/// Under which conditions on parameters it is proved; several are alternatives of which none follows from another.
fn conditions(all: &[Vec<Test>]) -> Option<String> {
    let said: Vec<String> = all.iter().map(|tests| listed(tests, " and ")).collect();
    match said.as_slice() {
        [] => None,
        [one] => Some(format!("it is proved if {one}, the weakest condition found")),
        _ => Some(format!(
            "it is proved if {}: the weakest conditions found, of which none follows from another",
            said.join(", or if ")
        )),
    }
}

pub(super) fn claim_of(pattern: &Pattern) -> Claim {
    let test = |(relation, left, right): &(crate::value::Relation, crate::value::Value, crate::value::Value)| Test {
        relation: *relation,
        left: left.clone(),
        right: right.clone(),
    };
    Claim {
        shown: pattern.terms.clone(),
        variables: pattern.variables.clone(),
        tests: pattern.conditions.iter().map(test).collect(),
    }
}

/// That what a claim speaks of is never shown, so that it says nothing.
fn never_together(claim: &Claim, outcome: &safety::Outcome) -> Option<String> {
    if claim.shown.is_empty() || outcome.speaks != Some(false) {
        return None;
    }
    let names: Vec<String> = claim.shown.iter().map(ToString::to_string).collect();
    Some(format!("note: it holds for want of anything to hold of: {} is never shown", names.join(" # ")))
}

/// How closely lengths in the plane are told, where a claim compares some.
fn enclosed(claim: &Claim) -> Option<String> {
    let length =
        |atom: &Atom| matches!(atom, Atom::Root(inner) if inner.squares().is_some_and(|parts| parts.len() > 1));
    let circle = |test: &Test| test.left.atoms().iter().chain(&test.right.atoms()).any(length);
    let (cosine, whole) = COSINE;
    let lost = 100.0 * (whole - cosine) as f64 / whole as f64;
    claim.tests.iter().any(circle).then(|| {
        format!("circles are enclosed by {} half planes, which tell a length to within {lost} %", 4 * QUARTER.len())
    })
}

/// What the proof rests on, and the invariant where there is one.
fn grounds(safe: &Safe, invariant: &[Vec<Test>]) -> Vec<String> {
    let mut lines = Vec::new();
    let mut said: Vec<(String, Vec<usize>)> = Vec::new();
    for (number, tests) in invariant.iter().enumerate() {
        let mut together = Assumptions::default();
        tests.iter().for_each(|test| together.assume(test.relation, &test.left, &test.right));
        let never = tests.iter().any(|test| test.decide(&Assumptions::default()) == Some(false))
            || together.plainly_contradictory();
        let tests: Vec<String> = tests.iter().map(Test::to_string).collect();
        let text = match tests.as_slice() {
            _ if never && safe.states() > 0 => format!("it is not reached after the first {} states", safe.states()),
            _ if never => "it is never reached".to_string(),
            [] => "anything".to_string(),
            tests => tests.join(" and "),
        };
        match said.iter_mut().find(|(other, _)| *other == text) {
            Some((_, phases)) => phases.push(number + 1),
            None => said.push((text, vec![number + 1])),
        }
    }
    lines.extend(said.iter().map(|(text, phases)| format!("invariant of {}: {text}", numbered(phases))));
    if safe.inequalities() > 0 {
        let word = if safe.inequalities() == 1 { "implication" } else { "implications" };
        lines.push(format!("{} {word} checked", safe.inequalities()));
    }
    if safe.states() > 0 && safe.inequalities() > 0 {
        lines.push(format!("it holds in the first {} states, behind which the invariant does", safe.states()));
    } else if safe.states() > 0 && !safe.trusted().is_empty() {
        let states = safe.states();
        lines.push(format!(
            "what it depends on repeats: it holds in each of the {states} states that the phases come to"
        ));
    } else if safe.states() > 0 {
        lines.push(format!("the run repeats: it holds in each of the {} states that can be reached", safe.states()));
    }
    lines
}

/// `phase 3`, `phases 1, 4 to 7`.
fn numbered(phases: &[usize]) -> String {
    let runs = phases.chunk_by(|one, next| one + 1 == *next);
    let run = |run: &[usize]| match run {
        [first, .., last] if run.len() > 2 => format!("{first} to {last}"),
        run => listed(run, ", "),
    };
    let runs: Vec<String> = runs.map(run).collect();
    format!("{} {}", if phases.len() == 1 { "phase" } else { "phases" }, runs.join(", "))
}

/// What is open for all values of the parameters may be refuted by some.
fn by_instance(
    (system, conditions): (&Term, &[Vec<Test>]),
    claim: &Claim,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
    found: &mut Found,
) {
    match broken_instance(system, claim, environment, conditions, interrupted) {
        Ok(instance) => {
            let open = std::mem::take(&mut found.remains);
            let values = instance.closed.values.iter().map(|(name, value, _)| format!("{name} = {value}"));
            found.trace.push(format!("take {}", listed(&values.collect::<Vec<_>>(), ", ")));
            let known = (&instance.claim, &Assumptions::default());
            broken(&instance.closed.term, &instance.closed.definitions, &instance.run, known, found);
            if found.verdict.is_none() {
                found.remains.extend(open);
            }
        }
        Err(0) => {}
        Err(tried) => {
            found.remains.retain(|line| !line.ends_with("has no value here"));
            found.remains.push(format!(
                "of {tried} instances with small values for the parameters, none breaks it in its first states"
            ));
        }
    }
}

/// What a proof rests on, by how far the kernel has checked the phases.
fn rests_on(far: Option<Grounds>, trusted: &[String], found: &mut Found) {
    if let Some(why) = far.as_ref().and_then(Grounds::open) {
        found.verdict = None;
        found.remains = vec![why];
        return;
    }
    match far {
        Some(Grounds::All) => {
            found.trace.push(EVERY_WAY.into());
        }
        Some(Grounds::Ways) => found.trusted.push(WAYS.to_string()),
        _ => found.trusted.extend(trusted.iter().cloned()),
    }
}

/// A refutation stands only with a run that replays in the executable meaning.
fn broken(
    system: &Term,
    definitions: &Definitions,
    run: &orbit::Run,
    (claim, assumptions): (&Claim, &Assumptions),
    found: &mut Found,
) {
    if !replays(system, definitions, &run.shown, &run.drawn) {
        found.remains = vec!["a run that breaks it was found, but could not be replayed".to_string()];
        return;
    }
    found.verdict = Some(Verdict::Refuted);
    found.trace.push("the run:".to_string());
    found.trace.extend(states(&run.shown));
    found.trace.extend(run.draws());
    if let Some((_, shown)) = run.shown.last() {
        for duty in claim.duties(shown).unwrap_or_default() {
            for (test, asked) in duty.tests.iter().zip(&claim.tests) {
                if test.decide(assumptions) == Some(false) {
                    let left = asked.left.to_string();
                    found.trace.push(format!(
                        "there {} {}, and it must be {} {}",
                        if left.len() > WIDE { "the left side" } else { &left },
                        rounded_beside(&test.left, &test.right)
                            .map_or_else(|| format!("= {}", test.left), |near| format!("is {near}")),
                        test.relation.symbol(),
                        test.right
                    ));
                }
            }
        }
    }
}
