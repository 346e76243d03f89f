//! `prove Sys always C`: an invariant is looked for, a run that breaks the claim, and what parameters would have to be.
//!
//! Whatever is found here is checked by [`crate::invariant`] or replayed in the executable meaning before it is said.

mod candidates;
mod carried;
mod condition;
mod curves;
pub mod drawn;
mod equality;
mod later;
pub mod orbit;

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::invariant::cases::cases;
use crate::invariant::{Claim, Rejected, Safe, check, check_states, check_visited, goals, premises};
use crate::name::Name;
use crate::period::{End, Failure, Next, Period, Test, analyse};
use crate::term::Term;
use crate::value::{Relation, Value, ValueError, View};
use crate::verify::influence::reduced;
use candidates::candidates;
use condition::{Clause, exclusion, sufficient, weakest};
use curves::{Kind, curves};
use equality::equalities;
use later::{later, reached};
use orbit::{Limits, Orbit, Run, extreme, follow};

/// States of a run that is followed to decide a claim.
const MOST_STATES: usize = 20_000;
/// States of a run that is followed only to say more of it.
const FEW_STATES: usize = 1_000;
/// Tests of an invariant of which each is tried to be left out.
const MOST_TESTS: usize = 60;
/// Rounds that are followed before an invariant is looked for again.
const ROUNDS: [usize; 3] = [4, 16, 64];

/// What was found out.
#[derive(Debug)]
pub enum Verdict {
    /// It always holds.
    Proved(Safe),
    /// It does not, as this run shows.
    Refuted(Run),
    /// Not decided.
    Open,
}

/// A verdict with all that leads to it.
#[derive(Debug)]
pub struct Outcome {
    /// The verdict.
    pub verdict: Verdict,
    /// The invariant, phase by phase.
    pub invariant: Vec<Vec<Test>>,
    /// Conditions on parameters under each of which the claim was checked, where it does not hold without.
    pub conditions: Vec<Vec<Test>>,
    /// How close to its bound the claim comes, where the run could be followed to its end.
    pub extreme: Option<String>,
    /// Whether anything that the claim speaks of is ever shown; none where that was not found out.
    pub speaks: Option<bool>,
    /// The period, where there is one.
    pub period: Option<Period>,
    /// What is wrong or may go wrong.
    pub diagnostics: Vec<Failure>,
    /// Why it was not decided.
    pub remaining: Vec<String>,
}

impl Outcome {
    /// Nothing is known yet.
    fn open() -> Outcome {
        Outcome {
            verdict: Verdict::Open,
            invariant: Vec::new(),
            conditions: Vec::new(),
            extreme: None,
            speaks: None,
            period: None,
            diagnostics: Vec::new(),
            remaining: Vec::new(),
        }
    }
}

/// A claim of some components side by side, under what is declared and assumed.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// The components.
    pub components: &'a [Term],
    /// What is claimed.
    pub claim: &'a Claim,
    /// The processes.
    pub definitions: &'a Definitions,
    /// What is assumed.
    pub assumptions: &'a Assumptions,
    /// Whether the user wants it to stop.
    pub interrupted: &'a dyn Fn() -> bool,
}

/// Whether the claim holds of the system, whose components these are, at all times.
pub fn always(system: &Term, asked: Asked<'_>) -> Outcome {
    let Asked { claim, definitions, assumptions, interrupted, .. } = asked;
    // A short run often decides it; then half planes and curves need not be looked for.
    let limits = |states: usize| Limits { states, interrupted };
    let short = follow(system, definitions, assumptions, claim, &limits(FEW_STATES));
    let search = if matches!(short, Orbit::Unknown(..)) { Search::Wide } else { Search::Narrow };
    let mut outcome = of_phases(asked, search);
    outcome.conditions = fewer(asked, std::mem::take(&mut outcome.conditions));
    // Where it is proved, the run is followed for what it shows alone, and not as far.
    let longer = search == Search::Wide && matches!(outcome.verdict, Verdict::Open);
    match if longer { follow(system, definitions, assumptions, claim, &limits(MOST_STATES)) } else { short } {
        Orbit::Closed(states) => {
            outcome.extreme = extreme(&states, claim);
            outcome.speaks = Some(orbit::speaks(&states, claim));
            // Nothing is taken on trust here, so it is the better proof even where there is an invariant.
            match check_states(system, definitions, assumptions, claim, &states) {
                Ok(safe) => outcome.verdict = Verdict::Proved(safe),
                Err(rejected) => outcome.remaining.push(rejected.0),
            }
        }
        // A run that breaks what an invariant proves shows a fault in the period, so neither is said.
        Orbit::Broken(_) if matches!(outcome.verdict, Verdict::Proved(_)) => {
            outcome.verdict = Verdict::Open;
            outcome.remaining.push("the invariant and the run contradict each other".to_string());
        }
        Orbit::Broken(run) => outcome.verdict = Verdict::Refuted(run),
        Orbit::Unknown(reason, states) if matches!(outcome.verdict, Verdict::Open) => {
            match drawn::broken(system, definitions, assumptions, claim, interrupted) {
                Some(run) => outcome.verdict = Verdict::Refuted(run),
                None => outcome.remaining.extend(not_followed(&reason, states)),
            }
        }
        Orbit::Unknown(..) => {}
    }
    outcome
}

/// The same by the phases of the system alone, for a run that was followed already: proved or open.
pub fn always_of_phases(asked: Asked<'_>) -> Outcome {
    of_phases(asked, Search::Wide)
}

/// How much is looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Search {
    /// What is claimed, and what is asked on the way.
    Narrow,
    /// Half planes, curves, and what holds after some rounds as well.
    Wide,
}

impl Search {
    fn kinds(self) -> &'static [Kind] {
        match self {
            Search::Narrow => &[],
            Search::Wide => &Kind::EACH,
        }
    }
}

fn of_phases(asked: Asked<'_>, search: Search) -> Outcome {
    let Asked { components, claim, definitions, assumptions, .. } = asked;
    let mut outcome = Outcome::open();
    match analyse(components, definitions, assumptions) {
        Ok(period) => {
            outcome.diagnostics.extend(period.warnings.iter().cloned());
            outcome.speaks = (!may_speak(&period, claim)).then_some(false);
            by_invariant(&period, claim, assumptions, search.kinds(), &mut outcome);
            by_what_matters(&period, asked, search, &mut outcome);
            if search == Search::Wide {
                from_later_on(&period, asked, &mut outcome);
            }
            outcome.period = Some(period);
        }
        Err(failures) => {
            outcome.remaining.extend(failures.iter().map(Failure::to_string));
            outcome.diagnostics = failures;
        }
    }
    outcome
}

/// Follows the phases in what the claim depends on alone, where something else never comes round; or in all variables, where
/// the run itself cannot be followed, as times in it are symbols.
fn by_what_matters(period: &Period, asked: Asked<'_>, search: Search, outcome: &mut Outcome) {
    let Asked { claim, assumptions, interrupted, .. } = asked;
    if !matches!(outcome.verdict, Verdict::Open) {
        return;
    }
    let (followed, most) = match reduced(period, &Term::par(claim.shown.iter().cloned())) {
        Some(reduced) => (variables(&reduced), MOST_STATES),
        None if search == Search::Wide => (variables(period), FEW_STATES),
        None => return,
    };
    let enough = |states: usize| states > most || interrupted();
    if let Ok(safe) = check_visited(period, assumptions, claim, &followed, None, &enough) {
        outcome.verdict = Verdict::Proved(safe);
        outcome.conditions.clear();
        outcome.remaining.clear();
    }
}

/// The variables of each phase.
fn variables(period: &Period) -> Vec<BTreeSet<Name>> {
    period.phases.iter().map(|phase| phase.variables.iter().cloned().collect()).collect()
}

/// Looks for an invariant that holds from some round on, where the rounds before are followed one by one.
fn from_later_on(period: &Period, asked: Asked<'_>, outcome: &mut Outcome) {
    let Asked { claim, assumptions, interrupted, .. } = asked;
    let followed = variables(period);
    let enough = |states: usize| states > MOST_STATES || interrupted();
    // The numbers of later rounds are long: what takes little work is tried for all of them first.
    let ways = [&Kind::EACH[..1], &Kind::EACH[1..]].into_iter().flat_map(|kinds| ROUNDS.map(|rounds| (kinds, rounds)));
    for (kinds, rounds) in ways {
        if !matches!(outcome.verdict, Verdict::Open) || interrupted() {
            return;
        }
        let Some(later) = later(period, assumptions, rounds) else { return };
        let mut found = Outcome::open();
        by_invariant(&later, claim, assumptions, kinds, &mut found);
        if !matches!(found.verdict, Verdict::Proved(_)) {
            continue;
        }
        // Where it never comes again, nothing holds.
        let reached = reached(&later);
        let never = Test { relation: Relation::Eq, left: Value::zero(), right: Value::one() };
        let gone = found.invariant.iter_mut().enumerate().filter(|(number, _)| !reached.contains(number));
        gone.for_each(|(_, tests)| *tests = vec![never.clone()]);
        let checked = check_visited(period, assumptions, claim, &followed, Some(&found.invariant), &enough);
        if let Ok(safe) = checked {
            outcome.verdict = Verdict::Proved(safe);
            outcome.invariant = found.invariant;
            outcome.conditions.clear();
            outcome.remaining.clear();
        }
    }
}

/// Why a run was not followed to its end.
fn not_followed(reason: &str, states: usize) -> Vec<String> {
    let met = (states > 1).then(|| format!("its first {states} states meet the claim"));
    std::iter::once(format!("the run could not be followed to its end: {reason}")).chain(met).collect()
}

/// Whether some phase shows all that the claim speaks of.
fn may_speak(period: &Period, claim: &Claim) -> bool {
    let edges = period.initial.iter().chain(period.phases.iter().flat_map(|phase| &phase.edges));
    let speaks = |observed: &[Term]| claim.duties(observed).map_or(true, |duties| !duties.is_empty());
    edges.into_iter().any(|edge| {
        let silent = matches!(&edge.next, Next::End(End::Silent { observed, .. }) if speaks(observed));
        silent || edge.segments.iter().any(|segment| speaks(&segment.observed))
    })
}

/// Leaves out of several conditions that are asked for together those without which the claim is proved, too: the system is
/// looked at as if the others were assumed.
fn fewer(asked: Asked<'_>, mut conditions: Vec<Vec<Test>>) -> Vec<Vec<Test>> {
    let Asked { components, claim, definitions, assumptions, interrupted } = asked;
    let enough = |tests: &[Test]| {
        let mut with = assumptions.clone();
        tests.iter().for_each(|test| with.assume(test.relation, &test.left, &test.right));
        let mut found = Outcome::open();
        if !interrupted()
            && let Ok(period) = analyse(components, definitions, &with)
        {
            by_invariant(&period, claim, &with, &Kind::EACH, &mut found);
        }
        matches!(found.verdict, Verdict::Proved(_))
    };
    for tests in &mut conditions {
        for place in (0..tests.len()).rev() {
            let mut others = tests.clone();
            others.remove(place);
            if !others.is_empty() && enough(&others) {
                *tests = others;
            }
        }
    }
    weakest(assumptions, conditions)
}

/// Looks for an invariant of the phases: with parts of what is claimed, one after the other, then with all of it.
fn by_invariant(period: &Period, claim: &Claim, assumptions: &Assumptions, kinds: &[Kind], outcome: &mut Outcome) {
    let parts = cases(&Assumptions::default(), &claim.tests).unwrap_or_default();
    let stronger = parts.into_iter().filter(|part| !part.tests.is_empty());
    let stronger = stronger.map(|part| Claim { tests: part.tests, ..claim.clone() });
    let mut reasons = BTreeSet::new();
    let mut tried: Vec<Vec<Vec<Test>>> = Vec::new();
    let equal: Vec<BTreeSet<Test>> = (0..period.phases.len()).map(|phase| equalities(period, phase)).collect();
    let nothing = vec![BTreeSet::new(); equal.len()];
    // Equalities are told apart, as most proofs do without.
    let ways = [(false, &nothing), (true, &nothing), (false, &equal), (true, &equal)];
    for candidate in stronger.chain([claim.clone()]) {
        for (kept, known) in ways {
            let missing = candidates(period, &candidate, assumptions, kept, known).and_then(|invariant| {
                if tried.contains(&invariant) {
                    return Ok(None);
                }
                tried.push(invariant.clone());
                Ok(Some((missing(period, claim, assumptions, &invariant)?, invariant)))
            });
            match missing {
                Ok(None) => {}
                Ok(Some((missing, invariant))) if missing.is_empty() => {
                    match prove(period, claim, assumptions, invariant, outcome) {
                        Ok(()) => return,
                        Err(rejected) => reasons.insert(rejected.0),
                    };
                }
                Ok(Some((missing, _))) if missing.iter().any(Vec::is_empty) => {}
                Ok(Some((missing, invariant))) => {
                    for tests in sufficient(assumptions, &missing) {
                        let mut with = assumptions.clone();
                        tests.iter().for_each(|test| with.assume(test.relation, &test.left, &test.right));
                        let empty = drawable(period, &with).contradictory();
                        if !empty
                            && !outcome.conditions.contains(&tests)
                            && check(period, &with, claim, &invariant).is_ok()
                        {
                            outcome.conditions.push(tests);
                        }
                    }
                }
                Err(error) => {
                    reasons.insert(error.0);
                }
            }
        }
    }
    for kind in kinds {
        for invariant in round(period, claim, assumptions, &equal, *kind) {
            match prove(period, claim, assumptions, invariant, outcome) {
                Ok(()) => return needed(period, claim, assumptions, outcome),
                Err(rejected) => reasons.insert(rejected.0),
            };
        }
    }
    outcome.conditions = weakest(assumptions, std::mem::take(&mut outcome.conditions));
    outcome.remaining.extend(reasons);
}

/// What is assumed, and that what is drawn from has its lower bound first.
fn drawable(period: &Period, assumptions: &Assumptions) -> Assumptions {
    let mut known = assumptions.clone();
    let edges = period.initial.iter().chain(period.phases.iter().flat_map(|phase| &phase.edges));
    for (_, distribution) in edges.flat_map(|edge| &edge.draws) {
        if let View::Distribution(kind, ends) = distribution.view()
            && let ("Uniform", [low, high]) = (kind.as_str(), ends.as_slice())
        {
            known.assume(Relation::Lte, low, high);
        }
    }
    known
}

/// Has an invariant checked, and notes that it proves the claim.
fn prove(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    invariant: Vec<Vec<Test>>,
    outcome: &mut Outcome,
) -> Result<(), Rejected> {
    outcome.verdict = Verdict::Proved(check(period, assumptions, claim, &invariant)?);
    outcome.invariant = invariant;
    outcome.conditions.clear();
    Ok(())
}

/// Leaves out of an invariant what the proof does without.
fn needed(period: &Period, claim: &Claim, assumptions: &Assumptions, outcome: &mut Outcome) {
    let all: usize = outcome.invariant.iter().map(Vec::len).sum();
    if all > MOST_TESTS {
        return;
    }
    for phase in 0..outcome.invariant.len() {
        for place in (0..outcome.invariant[phase].len()).rev() {
            let mut fewer = outcome.invariant.clone();
            fewer[phase].remove(place);
            // The proof that is kept is the one that was found without it.
            let _ = prove(period, claim, assumptions, fewer, outcome);
        }
    }
}

/// Of half planes in place of circles, and of curves that a map keeps, all that hold: by themselves, and with the claim.
fn round(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    equal: &[BTreeSet<Test>],
    kind: Kind,
) -> Vec<Vec<Vec<Test>>> {
    let Some(mut known) = curves(period, claim, assumptions, kind) else { return Vec::new() };
    known.iter_mut().zip(equal).for_each(|(known, equal)| known.extend(equal.iter().cloned()));
    let nothing = Claim { tests: Vec::new(), ..claim.clone() };
    let both = [&nothing, claim].map(|claim| candidates(period, claim, assumptions, false, &known));
    both.into_iter().flatten().collect()
}

/// What parameters must be for an invariant to be one.
fn missing(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    invariant: &[Vec<Test>],
) -> Result<Vec<Clause>, ValueError> {
    let mut clauses = Vec::new();
    let nothing = Vec::new();
    let starts = period.initial.iter().map(|edge| (edge, &nothing, BTreeSet::new()));
    let rounds = period.phases.iter().zip(invariant).flat_map(|(phase, known)| {
        let variables: BTreeSet<Name> = phase.variables.iter().cloned().collect();
        phase.edges.iter().map(move |edge| (edge, known, variables.clone()))
    });
    for (edge, known, mut variables) in starts.chain(rounds) {
        variables.extend(edge.draws.iter().map(|(name, _)| name.clone()));
        for goal in goals(period, claim, invariant, edge)? {
            let mut tests = premises(edge, known);
            tests.extend(goal.premises.iter().cloned());
            for test in goal.tests.iter().filter(|test| !tests.contains(test)) {
                clauses.extend(exclusion(assumptions, &[&tests[..], &[test.negated()]].concat(), &variables)?);
            }
        }
    }
    clauses.sort();
    clauses.dedup();
    Ok(clauses)
}
