//! The search for an invariant of the phases, and for what parameters must be where none holds for all of them.

use std::cell::{LazyCell, OnceCell};
use std::collections::BTreeSet;

use super::bounds::{carried_back, ranges};
use super::candidates::{Kept, candidates, claimed};
use super::condition::{Clause, Sufficient, exclusion, sufficient, weakest};
use super::curves::{Kind, curves};
use super::equality::equalities;
use super::integers::integers;
use super::points::Points;
use super::swings::swings;
use super::{Asked, Outcome, Verdict};
use crate::assumption::Assumptions;
use crate::invariant::cases::{cases, conjunctions};
use crate::invariant::{Claim, Rejected, check, goals, premises};
use crate::name::Name;
use crate::period::{Period, Test};
use crate::value::{Relation, ValueError, View};

/// Phases of which bounds are looked for.
const MOST_PHASES: usize = 12;
/// Tests of an invariant of which each is tried to be left out.
const MOST_TESTS: usize = 60;

/// An invariant that holds where some more is known of the parameters.
#[derive(Debug)]
pub(super) struct Short {
    invariant: Vec<Vec<Test>>,
    clauses: OnceCell<Vec<Clause>>,
}

impl Short {
    pub(super) fn new(invariant: Vec<Vec<Test>>) -> Short {
        Short { invariant, clauses: OnceCell::new() }
    }

    /// What parameters must be for it to hold; none at all where that is not known.
    pub(super) fn clauses(&self, asked: Asked<'_>, period: &Period, points: &Points<'_>) -> &[Clause] {
        let Asked { claim, assumptions, .. } = asked;
        self.clauses.get_or_init(|| {
            let clauses = missing(period, claim, assumptions, points, &self.invariant).unwrap_or_default();
            // Where a clause cannot hold, nothing helps.
            if clauses.iter().any(Vec::is_empty) { Vec::new() } else { clauses }
        })
    }
}

/// Looks for an invariant of the phases: with parts of what is claimed, one after the other, then with all of it.
pub(super) fn by_invariant(period: &Period, claim: &Claim, assumptions: &Assumptions, outcome: &mut Outcome) {
    let parts = cases(&Assumptions::default(), &claim.tests).unwrap_or_default();
    let stronger = parts.into_iter().filter(|part| !part.tests.is_empty());
    let stronger = stronger.map(|part| Claim { tests: part.tests, ..claim.clone() });
    let mut reasons = BTreeSet::new();
    let mut tried: Vec<Vec<Vec<Test>>> = Vec::new();
    let equal: Vec<BTreeSet<Test>> = (0..period.phases.len()).map(|phase| equalities(period, phase)).collect();
    let nothing = vec![BTreeSet::new(); equal.len()];
    // Equalities are told apart, as most proofs do without.
    let kinds = [Kept::Following, Kept::Reached, Kept::All];
    let mut whole = integers(period, claim);
    let rounds = whole.iter().any(|whole| !whole.is_empty());
    whole.iter_mut().zip(&equal).for_each(|(whole, equal)| whole.extend(equal.iter().cloned()));
    let ways = [&nothing, &equal].into_iter().flat_map(|known| kinds.map(|kept| (kept, known)));
    let ways = ways.chain(rounds.then_some((Kept::Following, &whole)));
    for candidate in stronger.chain([claim.clone()]) {
        for (kept, known) in ways.clone() {
            let invariant = match candidates(period, &candidate, assumptions, kept, known) {
                Ok(invariant) if tried.contains(&invariant) => continue,
                Ok(invariant) => invariant,
                Err(error) => {
                    reasons.insert(error.0);
                    continue;
                }
            };
            tried.push(invariant.clone());
            match prove(period, claim, assumptions, invariant.clone(), outcome) {
                Ok(()) if std::ptr::eq(known, &whole) => return needed(period, claim, assumptions, outcome),
                Ok(()) => return,
                Err(rejected) => reasons.insert(rejected.0),
            };
            outcome.short.push(Short::new(invariant));
        }
    }
    outcome.remaining.extend(reasons);
}

/// Looks for one among bounds that rounds keep: of each variable, and those that a claim needs of what is before it. They are
/// many, so nothing is told of them where they do not help.
pub(super) fn by_bounds(period: &Period, claim: &Claim, assumptions: &Assumptions, outcome: &mut Outcome) {
    if period.phases.len() > MOST_PHASES {
        return;
    }
    // `|x| <= 1` is two tests, and each is carried back by itself.
    let Ok(plain) = conjunctions(&claim.tests) else { return };
    let plain = Claim { tests: plain, ..claim.clone() };
    let back = claimed(period, &plain).map(|claimed| carried_back(period, &claimed, assumptions));
    let known = ranges(period).into_iter().zip(back.into_iter().flatten()).enumerate();
    let known: Vec<BTreeSet<Test>> = known
        .map(|(phase, (swings, back))| equalities(period, phase).into_iter().chain(swings).chain(back).collect())
        .collect();
    let mut by = |known: &[BTreeSet<Test>], claimed: &Claim| {
        known.len() == period.phases.len()
            && candidates(period, claimed, assumptions, Kept::Following, known)
                .is_ok_and(|invariant| prove(period, claim, assumptions, invariant, outcome).is_ok())
    };
    let nothing = Claim { tests: Vec::new(), ..claim.clone() };
    // The run that they are read from is followed once.
    let swings = LazyCell::new(|| swings(period));
    if by(&known, &plain) || [&plain, &nothing].into_iter().any(|claimed| by(&swings, claimed)) {
        needed(period, claim, assumptions, outcome);
        outcome.remaining.clear();
    }
}

/// Looks for one among half planes in place of circles, and curves that a map keeps.
pub(super) fn by_curves(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    kinds: &[Kind],
    outcome: &mut Outcome,
) {
    let equal: Vec<BTreeSet<Test>> = (0..period.phases.len()).map(|phase| equalities(period, phase)).collect();
    let mut reasons = BTreeSet::new();
    for kind in kinds {
        for invariant in round(period, claim, assumptions, &equal, *kind) {
            match prove(period, claim, assumptions, invariant, outcome) {
                Ok(()) => return needed(period, claim, assumptions, outcome),
                Err(rejected) => reasons.insert(rejected.0),
            };
        }
    }
    outcome.remaining.extend(reasons);
}

/// Conditions on parameters under each of which one of the invariants is checked.
pub(super) fn conditions<'s>(
    asked: Asked<'_>,
    period: &Period,
    short: impl IntoIterator<Item = &'s Short>,
    points: &Points<'_>,
) -> Sufficient {
    let Asked { claim, assumptions, .. } = asked;
    let mut all = Sufficient::default();
    for one in short {
        let Sufficient { found, guess } = sufficient(assumptions, one.clauses(asked, period, points), points);
        all.guess = all.guess.or(guess);
        for tests in found {
            let with = drawable(period, &supposed(assumptions, &tests));
            let empty = with.contradictory() || is_thin(&with, &tests);
            let with = supposed(assumptions, &tests);
            if !empty && !all.found.contains(&tests) && check(period, &with, claim, &one.invariant).is_ok() {
                all.found.push(tests);
            }
        }
    }
    all.found = weakest(assumptions, all.found);
    all
}

/// Whether `>=` in place of `>` is all that these tests allow, as in `t >= 2` and `t <= 2`.
fn is_thin(with: &Assumptions, tests: &[Test]) -> bool {
    let strict = |test: &Test| {
        let relation = match test.relation {
            Relation::Gte => Relation::Gtr,
            Relation::Lte => Relation::Lss,
            relation => relation,
        };
        Test { relation, ..test.clone() }
    };
    tests.len() > 1 && supposed(with, &tests.iter().map(strict).collect::<Vec<_>>()).contradictory()
}

/// What is assumed, and these tests.
pub fn supposed(assumptions: &Assumptions, tests: &[Test]) -> Assumptions {
    let mut with = assumptions.clone();
    tests.iter().for_each(|test| with.assume(test.relation, &test.left, &test.right));
    with
}

/// What is assumed, and that what is drawn from has its lower bound first.
fn drawable(period: &Period, assumptions: &Assumptions) -> Assumptions {
    let mut known = assumptions.clone();
    let edges = period.ways();
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
    outcome.short.clear();
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
    let both = [&nothing, claim].map(|claim| candidates(period, claim, assumptions, Kept::Following, &known));
    both.into_iter().flatten().collect()
}

/// What parameters must be for an invariant to be one.
fn missing(
    period: &Period,
    claim: &Claim,
    assumptions: &Assumptions,
    points: &Points<'_>,
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
                let tests = [&tests[..], &[test.negated()]].concat();
                clauses.extend(exclusion(assumptions, &tests, &variables, points)?);
            }
        }
    }
    Ok(shortest(clauses))
}

/// Without the clauses that hold where another does.
fn shortest(clauses: Vec<Clause>) -> Vec<Clause> {
    let mut all: Vec<BTreeSet<Test>> = clauses.into_iter().map(|clause| clause.into_iter().collect()).collect();
    all.sort_by(|one, other| one.len().cmp(&other.len()).then_with(|| one.cmp(other)));
    let mut kept: Vec<BTreeSet<Test>> = Vec::new();
    for clause in all {
        if !kept.iter().any(|other| other.is_subset(&clause)) {
            kept.push(clause);
        }
    }
    kept.into_iter().map(|clause| clause.into_iter().collect()).collect()
}
