//! `prove Sys always C`: an invariant is looked for, a run that breaks the claim, and what parameters would have to be.
//!
//! Whatever is found here is checked by [`crate::invariant`] or replayed in the executable meaning before it is said.

mod bounds;
mod candidates;
mod carried;
mod condition;
mod curves;
mod differences;
pub mod drawn;
mod equality;
mod generalised;
mod integers;
mod later;
mod learned;
mod noise;
pub mod orbit;
mod points;
mod prefix;
mod search;
mod swings;

use std::cell::OnceCell;
use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::invariant::{Claim, Safe, check_states, check_visited};
use crate::name::Name;
use crate::period::{End, Failure, Next, Period, Test, analyse};
use crate::term::Term;
use crate::value::{Relation, Value};
use crate::verify::influence::reduced;
use curves::Kind;
use differences::by_differences;
use later::{later, reached};
use learned::learned;
use orbit::{Limits, MOST_BITS, Orbit, Run, extreme, follow};
use points::Points;
pub use points::{Instance, meets};
pub use search::supposed;
use search::{Short, by_bounds, by_curves, by_invariant};

/// States of a run that is followed to decide a claim.
const MOST_STATES: usize = 20_000;
/// States of a run that is followed only to say more of it.
const FEW_STATES: usize = 1_000;
/// Bits of the numbers of a run that is followed before more is looked for.
const FEW_BITS: u64 = 256;
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
    /// Invariants for which something is missing.
    short: Vec<Short>,
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
            short: Vec::new(),
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
    /// Numbers for the parameters that meet these tests, and whether the claim holds with them, as far as that was found
    /// out: they guide the search for conditions, and prove nothing.
    pub instances: &'a dyn Fn(&[Test]) -> Vec<Instance>,
    /// Whether the user wants it to stop.
    pub interrupted: &'a dyn Fn() -> bool,
}

/// Whether the claim holds of the system, whose components these are, at all times.
pub fn always(system: &Term, asked: Asked<'_>) -> Outcome {
    let Asked { claim, definitions, assumptions, interrupted, .. } = asked;
    let followed = Followed::new(system, asked);
    let points = Points::new(asked);
    let mut outcome = of_phases(asked, &followed, &points);
    let open = matches!(outcome.verdict, Verdict::Open);
    match if open { followed.whole() } else { followed.known() } {
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
    if let Some(period) = outcome.period.as_ref().filter(|_| !matches!(outcome.verdict, Verdict::Proved(_))) {
        outcome.conditions = learned(asked, points, period, &outcome.short);
    }
    outcome
}

/// The same by what is to come of a run that is known to some length already: proved or open.
pub fn always_of_what_comes(system: &Term, asked: Asked<'_>) -> Outcome {
    let Asked { claim, definitions, assumptions, .. } = asked;
    let followed = Followed::new(system, asked);
    let mut outcome = of_phases(asked, &followed, &Points::new(asked));
    match followed.known() {
        Orbit::Closed(states) => {
            if let Ok(safe) = check_states(system, definitions, assumptions, claim, &states) {
                outcome.verdict = Verdict::Proved(safe);
            }
        }
        // What a run breaks is not proved, whatever the phases say.
        Orbit::Broken(_) => outcome.verdict = Verdict::Open,
        Orbit::Unknown(..) => {}
    }
    outcome
}

/// The run itself, followed as far as it is asked for.
struct Followed<'a> {
    system: &'a Term,
    asked: Asked<'a>,
    short: Orbit,
    long: OnceCell<Orbit>,
}

impl<'a> Followed<'a> {
    /// A short run often decides it.
    fn new(system: &'a Term, asked: Asked<'a>) -> Followed<'a> {
        Followed { system, asked, short: run(system, asked, FEW_STATES, MOST_BITS), long: OnceCell::new() }
    }

    /// A long run, as far as its numbers are short.
    fn long(&self) -> &Orbit {
        self.long.get_or_init(|| run(self.system, self.asked, MOST_STATES, FEW_BITS))
    }

    /// Whether neither a short run nor a long one decides it.
    fn is_open(&self) -> bool {
        matches!(self.short, Orbit::Unknown(..)) && matches!(self.long(), Orbit::Unknown(..))
    }

    /// What the longest run that was asked for tells.
    fn known(self) -> Orbit {
        self.long.into_inner().unwrap_or(self.short)
    }

    /// What a run tells that is followed as far as its numbers can be told.
    fn whole(self) -> Orbit {
        let Orbit::Unknown(..) = self.short else { return self.short };
        self.long();
        match self.long.into_inner() {
            Some(Orbit::Unknown(_, states)) if states < MOST_STATES => {
                run(self.system, self.asked, MOST_STATES, MOST_BITS)
            }
            long => long.unwrap_or(self.short),
        }
    }
}

fn run(system: &Term, asked: Asked<'_>, states: usize, bits: u64) -> Orbit {
    let Asked { claim, definitions, assumptions, interrupted, .. } = asked;
    follow(system, definitions, assumptions, claim, &Limits { states, bits, interrupted })
}

fn of_phases(asked: Asked<'_>, followed: &Followed<'_>, points: &Points<'_>) -> Outcome {
    let Asked { components, claim, definitions, assumptions, .. } = asked;
    let mut outcome = Outcome::open();
    match analyse(components, definitions, assumptions) {
        Ok(period) => {
            outcome.diagnostics.extend(period.warnings.iter().cloned());
            outcome.speaks = (!may_speak(&period, claim)).then_some(false);
            by_invariant(&period, claim, assumptions, &mut outcome);
            // Where the run decides it, half planes and curves need not be looked for; and what it breaks, or an instance,
            // is not proved, however far one looks.
            let open = matches!(outcome.verdict, Verdict::Open);
            let wide = open && followed.is_open() && !points.break_it();
            if wide {
                by_curves(&period, claim, assumptions, &Kind::EACH, &mut outcome);
            }
            by_what_matters(&period, asked, wide, &mut outcome);
            if wide {
                from_later_on(&period, asked, &mut outcome);
            }
            if wide && matches!(outcome.verdict, Verdict::Open) {
                by_bounds(&period, claim, assumptions, &mut outcome);
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

/// Follows the phases in what the claim depends on alone, where something else never comes round; or in all variables (`wide`),
/// where the run itself cannot be followed, as times in it are symbols.
fn by_what_matters(period: &Period, asked: Asked<'_>, wide: bool, outcome: &mut Outcome) {
    let Asked { claim, assumptions, interrupted, .. } = asked;
    if !matches!(outcome.verdict, Verdict::Open) {
        return;
    }
    let enough = |most: usize| move |states: usize| states > most || interrupted();
    let visited = |followed: &[BTreeSet<Name>], most: usize| {
        check_visited(period, assumptions, claim, followed, None, &enough(most)).ok()
    };
    let safe = match reduced(period, &Term::par(claim.shown.iter().cloned())) {
        Some(reduced) => visited(&variables(&reduced), MOST_STATES),
        None if wide => visited(&variables(period), FEW_STATES),
        None => return,
    };
    if let Some(safe) = safe.or_else(|| by_differences(period, asked)) {
        outcome.verdict = Verdict::Proved(safe);
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
        by_invariant(&later, claim, assumptions, &mut found);
        if matches!(found.verdict, Verdict::Open) {
            by_curves(&later, claim, assumptions, kinds, &mut found);
        }
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
    let edges = period.ways();
    let speaks = |observed: &[Term]| claim.duties(observed).map_or(true, |duties| !duties.is_empty());
    edges.into_iter().any(|edge| {
        let silent = matches!(&edge.next, Next::End(End::Silent { observed, .. }) if speaks(observed));
        silent || edge.segments.iter().any(|segment| speaks(&segment.observed))
    })
}
