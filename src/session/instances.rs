//! `Sys always C` with parameters that have no values: small values that meet what is assumed of them, and a run of the
//! system with these values that breaks the claim, which is made for all of them.

use std::collections::{BTreeMap, BTreeSet};

use crate::assumption::Assumptions;
use crate::invariant::Claim;
use crate::lower::Environment;
use crate::name::Name;
use crate::period::Test;
use crate::safety::drawn;
use crate::safety::orbit::{self, Limits, Orbit, follow};
use crate::sample::{Closed, close};
use crate::scope::read_names;
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::Value;

/// Instances in which one parameter is changed.
const MOST_INSTANCES: usize = 12;
/// Instances with other values for all of them, and these values.
const MOST_MIXED: u64 = 30;
const MIXED: [(i64, i64); 10] = [(1, 3), (1, 2), (2, 3), (1, 1), (3, 2), (2, 1), (5, 2), (3, 1), (5, 1), (10, 1)];
/// Instances of which draws are tried.
const MOST_DRAWN: usize = 4;
/// States of one instance.
const MOST_STATES: usize = 600;

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
    // The parameters of the claim need values too; beside the system they are found with its own.
    let beside = Term::par([system.clone(), Term::new(Node::Observe(Name::new("Asked"), asked(claim, environment)))]);
    let Ok(first) = close(&beside, environment, &[]) else { return Err(0) };
    let chosen: Vec<(Name, Value)> =
        first.values.iter().map(|(name, value, _)| (name.clone(), value.clone())).collect();
    if chosen.is_empty() {
        return Err(0);
    }
    let half = Value::fraction(1, 2).unwrap_or_else(|_| Value::one());
    let others = || [Value::integer(2), half.clone(), Value::integer(3), Value::integer(10), Value::zero()].into_iter();
    let changed = others().flat_map(|value| chosen.iter().map(move |(name, _)| vec![(name.clone(), value.clone())]));
    let bounds = bounds(&chosen, &environment.assumptions);
    let mut tried: BTreeSet<Vec<(Name, Value)>> = BTreeSet::new();
    let mixed = (1..=MOST_MIXED).map(|turn| mixed(&chosen, turn));
    let all = std::iter::once(Vec::new()).chain(bounds.into_iter().chain(changed).take(MOST_INSTANCES)).chain(mixed);
    for given in all {
        if interrupted() {
            break;
        }
        // One value may ask for others than those found at first.
        let Ok(values) = close(&beside, environment, &given).map(|closed| closed.values) else { continue };
        let values: Vec<(Name, Value)> = values.into_iter().map(|(name, value, _)| (name, value)).collect();
        if !tried.insert(values.clone()) {
            continue;
        }
        let Some(claim) = with_values(claim, &values.iter().cloned().collect()) else { continue };
        let Ok(closed) = close(system, environment, &values) else { continue };
        let limits = Limits { states: MOST_STATES, interrupted };
        let found = follow(&closed.term, &closed.definitions, &Assumptions::default(), &claim, &limits);
        let run = match found {
            Orbit::Broken(run) => Some(run),
            Orbit::Unknown(..) if tried.len() <= MOST_DRAWN => {
                drawn::broken(&closed.term, &closed.definitions, &Assumptions::default(), &claim, interrupted)
            }
            _ => None,
        };
        if let Some(run) = run {
            return Ok(Box::new(Instance { closed, claim, run }));
        }
    }
    Err(tried.len())
}

/// For each parameter the numbers that bound it, where these are assumed.
fn bounds(chosen: &[(Name, Value)], assumptions: &Assumptions) -> Vec<Vec<(Name, Value)>> {
    let mut found = Vec::new();
    for (name, _) in chosen {
        for (_, value) in assumptions.iter() {
            let Some((factor, rest)) = value.linear_in(name) else { continue };
            let bound =
                rest.neg().and_then(|rest| rest.div(&factor)).ok().filter(|bound| bound.as_rational().is_some());
            found.extend(bound.map(|bound| vec![(name.clone(), bound)]));
        }
    }
    found
}

/// Other values for all parameters at once, different ones in each turn.
fn mixed(chosen: &[(Name, Value)], turn: u64) -> Vec<(Name, Value)> {
    let mut dice = turn;
    let mut value = || {
        dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let (numerator, denominator) = MIXED[usize::try_from(dice >> 33).unwrap_or(0) % MIXED.len()];
        Value::fraction(numerator, denominator).unwrap_or_else(|_| Value::one())
    };
    chosen.iter().map(|(name, _)| (name.clone(), value())).collect()
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
