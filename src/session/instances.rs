//! `Sys always C` with parameters that have no values: small values that meet what is assumed of them, and a run of the
//! system with these values that breaks the claim, which is made for all of them.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::Signed;

use crate::assumption::Assumptions;
use crate::invariant::Claim;
use crate::lower::Environment;
use crate::name::Name;
use crate::period::Test;
use crate::safety::orbit::{self, Limits, MOST_BITS, Orbit, follow};
use crate::safety::{self, drawn};
use crate::sample::{Closed, close, reached};
use crate::scope::{read_names, subterms};
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::Value;

/// Instances in which one parameter is changed.
const MOST_INSTANCES: usize = 24;
/// Numbers of the text, the largest ones, that parameters are given.
const MOST_WRITTEN: usize = 3;
/// Instances with other values for all of them, and these values.
const MOST_MIXED: u64 = 30;
const MIXED: [(i64, i64); 10] = [(1, 3), (1, 2), (2, 3), (1, 1), (3, 2), (2, 1), (5, 2), (3, 1), (5, 1), (10, 1)];
/// Instances of which draws are tried.
const MOST_DRAWN: usize = 4;
/// States of one instance.
const MOST_STATES: usize = 600;
/// Instances by which conditions are looked for, those of them that meet a guess, and the values that are drawn for them.
const MOST_LABELLED: usize = 200;
const MOST_WITHIN: usize = 10;
const MOST_DRAWS: u64 = 600;
/// States of all of them.
const ALL_STATES: usize = 20_000;
/// States of one of them.
const FEW_STATES: usize = 200;

/// A run of an instance that breaks a claim.
pub(super) struct Instance {
    /// The system with values, and the values.
    pub(super) closed: Closed,
    /// The claim with these values.
    pub(super) claim: Claim,
    /// The run.
    pub(super) run: orbit::Run,
}

/// The first instance with a run that breaks the claim; else how many were followed. Those come first that do not meet
/// any of the conditions under which it is proved.
pub(super) fn broken_instance(
    system: &Term,
    claim: &Claim,
    environment: &Environment,
    conditions: &[Vec<Test>],
    interrupted: &dyn Fn() -> bool,
) -> Result<Box<Instance>, usize> {
    let mut beyond = environment.clone();
    for test in conditions.iter().filter_map(|tests| tests.first()).map(Test::negated) {
        beyond.assumptions.assume(test.relation, &test.left, &test.right);
    }
    let mut tried = 0;
    let telling = !conditions.is_empty() && !beyond.assumptions.contradictory();
    for environment in telling.then_some(&beyond).into_iter().chain([environment]) {
        match broken_among(system, claim, environment, interrupted) {
            Err(more) => tried += more,
            found => return found,
        }
    }
    Err(tried)
}

fn broken_among(
    system: &Term,
    claim: &Claim,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Box<Instance>, usize> {
    let Some(mut choices) = Choices::of(system, claim, environment) else { return Err(0) };
    let others = choices.changed(environment, MOST_INSTANCES);
    let mixed: Vec<_> = (1..=MOST_MIXED).map(|turn| mixed(&choices.chosen, turn)).collect();
    for given in std::iter::once(Vec::new()).chain(others).chain(mixed) {
        if interrupted() {
            break;
        }
        let Some(Followed { closed, claim, orbit }) = choices.follow(environment, &given, MOST_STATES, interrupted)
        else {
            continue;
        };
        let run = match orbit {
            Orbit::Broken(run) => Some(run),
            Orbit::Unknown(..) if choices.tried.len() <= MOST_DRAWN => {
                drawn::broken(&closed.term, &closed.definitions, &Assumptions::default(), &claim, interrupted)
            }
            _ => None,
        };
        if let Some(run) = run {
            return Ok(Box::new(Instance { closed, claim, run }));
        }
    }
    Err(choices.tried.len())
}

/// Instances that meet these tests, and whether the claim holds in each as far as it was followed. They guide a search.
pub(super) fn labelled(
    system: &Term,
    claim: &Claim,
    environment: &Environment,
    tests: &[Test],
    interrupted: &dyn Fn() -> bool,
) -> Vec<safety::Instance> {
    let mut within = environment.clone();
    within.assumptions = safety::supposed(&environment.assumptions, tests);
    let Some(mut choices) = Choices::of(system, claim, &within) else { return Vec::new() };
    let meets = |given: &Vec<(Name, Value)>| {
        let values = given.iter().cloned().collect();
        tests.iter().all(|test| safety::meets(&values, test))
    };
    let most = if tests.is_empty() { MOST_LABELLED } else { MOST_WITHIN };
    let others = choices.changed(&within, most / 2);
    let mixed = (1..=MOST_DRAWS).map(|turn| fine(&choices.chosen, turn)).filter(meets).take(most);
    let given: Vec<_> = std::iter::once(Vec::new()).chain(others).chain(mixed).collect();
    let (mut all, mut states) = (Vec::new(), 0);
    for given in given {
        if interrupted() || all.len() >= most || states > ALL_STATES {
            break;
        }
        let Some(Followed { closed, orbit, .. }) = choices.follow(&within, &given, FEW_STATES, interrupted) else {
            continue;
        };
        let (holds, ended, followed) = match orbit {
            Orbit::Closed(all) => (true, all.len(), all.len()),
            Orbit::Broken(run) => (false, run.shown.len(), run.shown.len()),
            // Nothing broke it for long.
            Orbit::Unknown(_, states) if states >= FEW_STATES => (true, 0, states),
            Orbit::Unknown(..) => continue,
        };
        states += followed;
        let values = closed.values.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
        all.push(safety::Instance { values, holds, states: ended });
    }
    all
}

/// Values of the parameters of a system and of what is claimed of it.
struct Choices<'a> {
    system: &'a Term,
    claim: &'a Claim,
    /// The system with the parameters of the claim beside it: they need values too, and are found with its own.
    beside: Term,
    /// The first choice.
    chosen: Vec<(Name, Value)>,
    /// What was tried.
    tried: BTreeSet<Vec<(Name, Value)>>,
}

/// An instance that was followed.
struct Followed {
    closed: Closed,
    claim: Claim,
    orbit: Orbit,
}

impl<'a> Choices<'a> {
    /// None where there is nothing to choose.
    fn of(system: &'a Term, claim: &'a Claim, environment: &Environment) -> Option<Choices<'a>> {
        let asked = Term::new(Node::Observe(Name::new("Asked"), asked(claim, environment)));
        let beside = Term::par([system.clone(), asked]);
        let first = close(&beside, environment, &[]).ok()?;
        let chosen: Vec<(Name, Value)> =
            first.values.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
        (!chosen.is_empty()).then_some(Choices { system, claim, beside, chosen, tried: BTreeSet::new() })
    }

    /// One parameter with another value: those that bound it come first.
    fn changed(&self, environment: &Environment, most: usize) -> Vec<Vec<(Name, Value)>> {
        let half = Value::fraction(1, 2).unwrap_or_else(|_| Value::one());
        let near = [Value::integer(2), half, Value::integer(3), Value::integer(10), Value::zero()];
        let others = near.into_iter().chain(written(self.system, environment)).collect::<Vec<_>>();
        let changed = others
            .iter()
            .flat_map(|value| self.chosen.iter().map(move |(name, _)| vec![(name.clone(), value.clone())]));
        bounds(&self.chosen, &environment.assumptions).into_iter().chain(changed).take(most).collect()
    }

    /// The instance with these values and others that go with them; none where there is none, or it was tried.
    fn follow(
        &mut self,
        environment: &Environment,
        given: &[(Name, Value)],
        states: usize,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Followed> {
        // One value may ask for others than those found at first.
        let values = close(&self.beside, environment, given).ok()?.values;
        let values: Vec<(Name, Value)> = values.into_iter().map(|(name, value, _)| (name, value)).collect();
        if !self.tried.insert(values.clone()) {
            return None;
        }
        let claim = with_values(self.claim, &values.iter().cloned().collect())?;
        let closed = close(self.system, environment, &values).ok()?;
        let limits = Limits { states, bits: MOST_BITS, interrupted };
        let orbit = follow(&closed.term, &closed.definitions, &Assumptions::default(), &claim, &limits);
        Some(Followed { closed, claim, orbit })
    }
}

/// The largest numbers that a system is written with, itself and in what it calls: at such a place a parameter may tell.
fn written(system: &Term, environment: &Environment) -> Vec<Value> {
    let mut numbers: BTreeSet<BigRational> = BTreeSet::new();
    let mut collect = |term: &Term| {
        for value in subterms(term).flat_map(Term::values) {
            let parts = value.components().unwrap_or_else(|| vec![value.clone()]);
            let constants = parts.iter().filter_map(|part| Some(part.polynomials()?.0.constant_term()));
            numbers.extend(constants.map(|number| number.abs()));
        }
    };
    collect(system);
    let called = reached(system, &environment.definitions);
    called.iter().filter_map(|name| environment.definitions.get(name)).for_each(|one| collect(&one.body));
    numbers.into_iter().rev().take(MOST_WRITTEN).map(Value::rational).collect()
}

/// For each parameter the numbers that bound it, where these are assumed, and places a little beyond them.
fn bounds(chosen: &[(Name, Value)], assumptions: &Assumptions) -> Vec<Vec<(Name, Value)>> {
    let mut found = Vec::new();
    for (name, _) in chosen {
        for (_, value) in assumptions.iter() {
            let Some((factor, rest)) = value.linear_in(name) else { continue };
            let bound =
                rest.neg().and_then(|rest| rest.div(&factor)).ok().filter(|bound| bound.as_rational().is_some());
            let half = Value::fraction(1, 2).unwrap_or_else(|_| Value::one());
            if let Some(bound) = bound {
                let beyond = [bound.add(&half), bound.sub(&half)];
                found.extend(
                    std::iter::once(bound).chain(beyond.into_iter().flatten()).map(|at| vec![(name.clone(), at)]),
                );
            }
        }
    }
    found
}

/// Other values for all parameters at once, different ones in each turn.
fn mixed(chosen: &[(Name, Value)], turn: u64) -> Vec<(Name, Value)> {
    let mut dice = Dice(turn);
    let mut value = || {
        let (numerator, denominator) = MIXED[dice.below(MIXED.len())];
        Value::fraction(numerator, denominator).unwrap_or_else(|_| Value::one())
    };
    chosen.iter().map(|(name, _)| (name.clone(), value())).collect()
}

/// The same of more values.
fn fine(chosen: &[(Name, Value)], turn: u64) -> Vec<(Name, Value)> {
    let mut dice = Dice(turn);
    let mut value = || {
        let whole = dice.below(12) as i64 + 1;
        let part = [1, 1, 2, 2, 3, 4][dice.below(6)];
        let sign = if dice.below(10) == 0 { -1 } else { 1 };
        Value::fraction(sign * whole, part).unwrap_or_else(|_| Value::one())
    };
    chosen.iter().map(|(name, _)| (name.clone(), value())).collect()
}

/// Numbers that are the same on every run.
struct Dice(u64);

impl Dice {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(self.0 >> 33).unwrap_or(0) % most
    }
}

/// The parameters that a claim reads.
fn asked(claim: &Claim, environment: &Environment) -> Vec<Value> {
    let tests = claim.tests.iter().flat_map(|test| [&test.left, &test.right]).flat_map(Value::variables);
    let names: BTreeSet<Name> = claim.shown.iter().flat_map(read_names).chain(tests).collect();
    let parameter = |name: &&Name| environment.quantity(name).is_some() && !claim.variables.contains(*name);
    names.iter().filter(parameter).map(Value::variable).collect()
}

fn with_values(claim: &Claim, values: &BTreeMap<Name, Value>) -> Option<Claim> {
    let mut values = values.clone();
    values.retain(|name, _| !claim.variables.contains(name));
    let shown = claim.shown.iter().map(|term| substitute_values(term, &values).ok()).collect::<Option<_>>()?;
    let tests: Vec<Test> = claim.tests.iter().map(|test| test.substitute(&values).ok()).collect::<Option<_>>()?;
    Some(Claim { shown, tests, ..claim.clone() })
}
