//! The match of a run with a property, as a theorem about the system.

use num_rational::BigRational;

use super::Evidence;
use super::beside::open_need;
use super::cases::{InEach, unwritten};
use super::claim::Found;
use super::compare::theory;
use super::reading::Run;
use super::rounds::no_value;
use super::satisfies::{said, short};
use crate::closed_form::compared;
use crate::definition::Definitions;
use crate::kernel::{Rejected, Theory, Thm, check};
use crate::law::Connective;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::proof::{Lemma, Proof, Script, Statement, Step};
use crate::prove::run::{self, Stage};
use crate::prove::{Answer, By, prove};
use crate::refute::{self, Refutation};
use crate::report::Verdict;
use crate::rewrite::Limits;
use crate::substitution::Substitution;
use crate::term::Term;
use crate::verify::{Orbit, Outcome};

impl Run<'_, '_> {
    /// The match of the run with the property, as a theorem.
    pub(super) fn matched(&mut self, system: &System, outcome: &Outcome, environment: &Environment, found: &mut Found) {
        let (Some(run), Some(wanted)) = (&outcome.trajectory_term, &outcome.property_term) else {
            found.remains = vec![unwritten(outcome)];
            return;
        };
        let theory = theory(environment);
        if outcome.apart.is_some() {
            return self.matched_in_each(system, outcome, (run, wanted), environment, found);
        }
        let statement = Statement {
            hypotheses: Vec::new(),
            left: run.clone(),
            connective: Connective::Refines,
            right: wanted.clone(),
        };
        let interrupted = || self.surroundings.interrupted();
        match prove(&theory, &statement, &By::Search, Limits::default(), &interrupted) {
            Answer::Proved(_, proof) => {
                found.trace.push(format!("match: {}", short(&wanted.to_string())));
                found.it = Some(run.clone());
                let whole = system.alone(&theory.definitions);
                found.trace.extend(closed(system, &theory.definitions));
                let Some(tried) = tried((&whole, run), environment, found) else { return };
                let within = |orbit: &Orbit| orbit.moving.iter().any(|one| one.between.is_some());
                let moves = outcome.orbit.as_ref().is_some_and(|(_, orbit)| within(orbit));
                let trusting = if moves { TURNS } else { RUN };
                let followed = followed(&theory, (&whole, run), &proof, &outcome.stages());
                if let Err(Unfollowed { why, undefined: true }) = &followed {
                    found.remains = vec![no_value(why)];
                    return;
                }
                if followed.is_err()
                    && let Some(why) = may_have_no_value(system, environment)
                {
                    found.remains = vec![why];
                    return;
                }
                let followed = followed.map_err(|lost| lost.why);
                if let (Err(why), false) = (&followed, tried) {
                    found.remains = untried(std::slice::from_ref(why));
                    return;
                }
                let checked = followed.or_else(|why| {
                    found.trace.push(format!("the kernel could not follow the run: {}", said(&why)));
                    let proof = with_run(whole, run, *proof, trusting);
                    check(&theory, &proof).map(|theorem| (theorem, proof))
                });
                found.checked(theory, environment, checked);
            }
            Answer::Open(gap) => {
                let sides = [&gap.left, &gap.right].map(|side| format!("  {}", short(&side.to_string())));
                found.remains = vec!["the run of the system could not be proved to match the property:".to_string()];
                found.remains.extend(sides);
            }
        }
    }

    /// The same where the run was found in cases.
    fn matched_in_each(
        &self,
        system: &System,
        outcome: &Outcome,
        (run, wanted): (&Term, &Term),
        environment: &Environment,
        found: &mut Found,
    ) {
        let (Some(apart), Some(period)) = (&outcome.apart, &outcome.period) else { return };
        let theory = theory(environment);
        let whole = system.alone(&theory.definitions);
        found.trace.extend(closed(system, &theory.definitions));
        found.trace.push(format!("match: {}", short(&wanted.to_string())));
        let Some(tried) = tried_in_each(&whole, outcome, environment, found) else { return };
        let interrupted = || self.surroundings.interrupted();
        let each = InEach { theory: &theory, period, whole: &whole, wanted, interrupted: &interrupted };
        let proof = each.proof(apart);
        if proof.as_ref().is_ok_and(|(_, lost)| !lost.is_empty())
            && let Some(why) = may_have_no_value(system, environment)
        {
            found.remains = vec![why];
            return;
        }
        match proof {
            Ok((_, lost)) if !lost.is_empty() && !tried => found.remains = untried(&lost),
            Ok((checked, lost)) => {
                found.it = Some(run.clone()).filter(|_| !outcome.is_on_sides());
                found.trace.extend(lost.iter().map(|why| format!("the kernel could not follow the run {why}")));
                found.checked(theory, environment, Ok(checked));
            }
            Err(why) => found.remains = vec![said(&why)],
        }
    }
}

impl Found {
    /// The claim is proved, if the kernel says so.
    fn checked(&mut self, theory: Theory, environment: &Environment, checked: Result<(Thm, Proof), Rejected>) {
        match checked {
            Ok((theorem, proof)) => {
                let environment = environment.clone();
                self.verdict = Some(Verdict::Proved);
                self.evidence = Some(Evidence { theory, environment, theorem, proof });
            }
            Err(rejected) => self.remains = vec![format!("the kernel turned the proof down: {}", rejected.reason)],
        }
    }
}

/// Why a run is not taken on trust whose values need something of parameters that is not known.
fn may_have_no_value(system: &System, environment: &Environment) -> Option<String> {
    open_need(&system.components, environment).map(|need| no_value(&need.to_string()))
}

/// Why a run is not taken on trust that was tried nowhere.
fn untried(lost: &[String]) -> Vec<String> {
    let said = lost.iter().map(|why| format!("  {}", said(why)));
    let first = "the run was tried on no instance of the executable meaning, and the kernel could not follow it:";
    std::iter::once(first.to_string()).chain(said).collect()
}

/// Whether the run was tried on any instance of the executable meaning, which is said; nothing if it is another there.
fn tried((whole, run): (&Term, &Term), environment: &Environment, found: &mut Found) -> Option<bool> {
    match agreement(whole, run, environment) {
        Ok((line, tried)) => {
            found.trace.push(line);
            Some(tried)
        }
        Err(lines) => {
            found.remains = lines;
            None
        }
    }
}

/// The same of the run of each case, where there is one.
fn tried_in_each(whole: &Term, outcome: &Outcome, environment: &Environment, found: &mut Found) -> Option<bool> {
    let mut all = true;
    for (when, run) in outcome.runs() {
        let mut here = environment.clone();
        when.iter().for_each(|(relation, left, right)| here.assumptions.assume(*relation, left, right));
        all &= tried((whole, run), &here, found)?;
        if let Some(line) = found.trace.last_mut().filter(|_| !when.is_empty()) {
            let when: Vec<String> = when.iter().map(compared).collect();
            *line = format!("where {}: {line}", when.join(" and "));
        }
    }
    Some(all)
}

/// So many halves are tried for parameters for which smaller numbers meet no case that is looked at.
const MORE_HALVES: [i64; 9] = [3, 5, 6, 7, 8, 10, 14, 18, 20];

/// What is taken on trust is tried on the executable meaning first: small values for the parameters, the system beside
/// its run. A difference would be a mistake of ours, and nothing is then proved. What was found is said, with whether
/// any instance was followed at all.
fn agreement(system: &Term, run: &Term, environment: &Environment) -> Result<(String, bool), Vec<String>> {
    let few = refute::Limits { instances: 12, choices: 4_000, cost: 12, pairs: 2_000, numbers: Vec::new() };
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let within = |limits: &refute::Limits| {
        refute::refute(system, run, Connective::WeaklyRefines, &[], definitions, assumptions, limits)
    };
    let found = match within(&few) {
        Refutation::None { instances, meaningless, .. } if instances <= meaningless => {
            let half = |number: i64| BigRational::new(number.into(), 2.into());
            within(&refute::Limits { choices: 20_000, numbers: MORE_HALVES.map(half).into(), ..few })
        }
        found => found,
    };
    match found {
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

/// Why the kernel could not follow a run.
pub(super) struct Unfollowed {
    pub(super) why: String,
    /// Whether that is because something may have no value: then nothing may be trusted either.
    pub(super) undefined: bool,
}

/// The verdict with the run of the system proved as well; otherwise why the kernel could not follow the run.
pub(super) fn followed(
    theory: &Theory,
    (whole, run): (&Term, &Term),
    matched: &Proof,
    stages: &[Stage],
) -> Result<(Thm, Proof), Unfollowed> {
    let hypotheses = &matched.statement.hypotheses;
    let lost = |lost: run::Lost| Unfollowed { why: lost.0, undefined: false };
    let ran = run::runs_where(theory, hypotheses, (whole, run), stages).map_err(lost)?;
    // Where the match speaks of one round by itself, it needs a claim that counts the rounds: a lemma.
    let ways = [behind(ran.clone(), matched), by_lemma(ran, matched)];
    let mut why = Unfollowed { why: String::new(), undefined: false };
    for proof in ways {
        match check(theory, &proof) {
            // What the system reads besides must have a value wherever the claim is made.
            Ok(theorem) => match theorem.reads().first() {
                None => return Ok((theorem, proof)),
                Some(need) => return Err(Unfollowed { why: need.to_string(), undefined: true }),
            },
            Err(rejected) => {
                why = Unfollowed { why: rejected.reason.to_string(), undefined: rejected.reason.is_undefined() }
            }
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
pub(super) const RUN: &str = "that the system runs as printed: its period and the closed forms";
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
pub(super) fn with_run(system: Term, run: &Term, matched: Proof, trusting: &str) -> Proof {
    let statement = Statement { left: system.clone(), connective: Connective::WeaklyRefines, ..matched.statement };
    let mut script = Script { steps: matched.steps };
    let last = script.steps.len().saturating_sub(1);
    let trusted = script.push(Step::Trust(system, Connective::WeaklyRefines, run.clone(), trusting.to_string()));
    script.push(Step::Transitive(vec![trusted, last]));
    script.finish(statement)
}

/// Which ports are taken as private though only one component uses them.
fn closed(system: &System, definitions: &Definitions) -> Option<String> {
    let ports: Vec<String> = system.unshared(definitions).iter().map(ToString::to_string).collect();
    (!ports.is_empty()).then(|| format!("closed, as nobody else is there: port {}", ports.join(", ")))
}
