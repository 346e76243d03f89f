//! What parameters must be for an invariant to hold: the variables of a phase eliminated by Fourier and Motzkin.

use std::collections::BTreeSet;

use num_traits::{One, Signed};

use super::points::Points;
use super::search::supposed;
use crate::assumption::Assumptions;
use crate::invariant::cases::{Case, cases};
use crate::name::Name;
use crate::period::Test;
use crate::value::{Relation, Value, ValueError};

/// Coefficients of unknown sign that are looked at by cases, one inside the other.
const MOST_SPLITS: usize = 3;
/// Constraints that an elimination may make.
const MOST_CONSTRAINTS: usize = 400;

/// Tests that are tried as conditions.
const MOST_LITERALS: usize = 40;
/// Pairs of them.
const MOST_PAIRS: usize = 200;

/// Guesses that are mended, and clauses by which one is mended at once.
const MOST_MENDED: usize = 10;
const MOST_OPEN: usize = 4;

/// Tests of parameters, at least one of which must hold.
pub type Clause = Vec<Test>;

/// A value that is 0, positive, or at least 0.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
struct Constraint {
    form: Value,
    relation: Relation,
}

/// What parameters must be so that no values of the variables meet all tests: all clauses must hold.
///
/// # Errors
/// When the tests are not linear in the variables, or the sign of a coefficient is not known.
pub fn exclusion(
    assumptions: &Assumptions,
    tests: &[Test],
    variables: &BTreeSet<Name>,
    points: &Points<'_>,
) -> Result<Vec<Clause>, ValueError> {
    let mut clauses = Vec::new();
    for case in cases(assumptions, tests)? {
        clauses.extend(by_signs(assumptions, &case, variables, MOST_SPLITS)?);
    }
    // What some numbers do not meet need not be shown not to follow.
    clauses.retain(|clause| points.beyond(clause) || !excluded(assumptions, clause));
    Ok(clauses)
}

/// The clauses that exclude a case, where need be for each sign of a coefficient that is free of the variables.
fn by_signs(
    assumptions: &Assumptions,
    case: &Case,
    variables: &BTreeSet<Name>,
    splits: usize,
) -> Result<Vec<Clause>, ValueError> {
    let factor = match exclude(assumptions, case, variables) {
        Ok(clause) => return Ok(clause.into_iter().collect()),
        Err(Stuck::Sign(factor)) if splits > 0 && !variables.iter().any(|name| factor.mentions(name)) => factor,
        Err(stuck) => return Err(stuck.into()),
    };
    let mut clauses = Vec::new();
    for relation in [Relation::Gtr, Relation::Eq, Relation::Lss] {
        let side = Test { relation, left: factor.clone(), right: Value::zero() };
        if side.decide(assumptions) == Some(false) {
            continue;
        }
        let mut here = assumptions.clone();
        here.assume(relation, &side.left, &side.right);
        for mut clause in by_signs(&here, case, variables, splits - 1)? {
            clause.push(side.negated());
            clauses.push(clause);
        }
    }
    Ok(clauses)
}

/// Why an elimination does not go on.
enum Stuck {
    /// The sign of a coefficient is not known.
    Sign(Value),
    /// For another reason.
    Other(ValueError),
}

impl From<ValueError> for Stuck {
    fn from(error: ValueError) -> Stuck {
        Stuck::Other(error)
    }
}

impl From<Stuck> for ValueError {
    fn from(stuck: Stuck) -> ValueError {
        match stuck {
            Stuck::Sign(factor) => ValueError(format!("the sign of {factor} must be known")),
            Stuck::Other(error) => error,
        }
    }
}

/// The clause that excludes one case; none if it is impossible as it is.
fn exclude(assumptions: &Assumptions, case: &Case, variables: &BTreeSet<Name>) -> Result<Option<Clause>, Stuck> {
    let mut constraints = BTreeSet::new();
    for test in &case.tests {
        // `!=` is left out: the case is then wider than it is, and what excludes it still does.
        constraints.extend(constraint(test)?);
    }
    let mut rest: Vec<&Name> = variables.iter().collect();
    while let Some(place) = cheapest(&rest, &constraints) {
        let name = rest.swap_remove(place);
        constraints = eliminate(assumptions, constraints, name)?;
    }
    let mut clause = Clause::new();
    for one in constraints {
        match assumptions.decide(one.relation, &one.form, &Value::zero()) {
            Some(true) => {}
            Some(false) => return Ok(None),
            None => clause.push(Test { relation: one.relation, left: one.form, right: Value::zero() }.negated()),
        }
    }
    Ok(Some(clause))
}

fn constraint(test: &Test) -> Result<Option<Constraint>, ValueError> {
    let difference = test.left.sub(&test.right)?;
    Ok(match test.relation {
        Relation::Eq | Relation::Gtr | Relation::Gte => Some(Constraint { form: difference, relation: test.relation }),
        Relation::Lss => Some(Constraint { form: difference.neg()?, relation: Relation::Gtr }),
        Relation::Lte => Some(Constraint { form: difference.neg()?, relation: Relation::Gte }),
        Relation::Neq => None,
    })
}

/// The variable that stands in the fewest constraints.
fn cheapest(names: &[&Name], constraints: &BTreeSet<Constraint>) -> Option<usize> {
    let count = |name: &Name| constraints.iter().filter(|one| one.form.mentions(name)).count();
    (0..names.len()).min_by_key(|place| count(names[*place]))
}

fn eliminate(
    assumptions: &Assumptions,
    constraints: BTreeSet<Constraint>,
    name: &Name,
) -> Result<BTreeSet<Constraint>, Stuck> {
    let (mut below, mut above, mut free) = (Vec::new(), Vec::new(), BTreeSet::new());
    let mut equal: Option<Value> = None;
    for one in &constraints {
        if !one.form.mentions(name) {
            free.insert(one.clone());
            continue;
        }
        let Some((factor, rest)) = one.form.linear_in(name) else {
            return Err(ValueError(format!("{} is not linear in {name}", one.form)).into());
        };
        if assumptions.decide(Relation::Eq, &factor, &Value::zero()) == Some(true) {
            free.insert(Constraint { form: rest, relation: one.relation });
            continue;
        }
        let bound = rest.neg()?.div(&factor)?;
        if one.relation == Relation::Eq {
            if assumptions.decide(Relation::Neq, &factor, &Value::zero()) != Some(true) {
                return Err(Stuck::Sign(factor));
            }
            equal = Some(bound);
            break;
        }
        match assumptions.decide(Relation::Gtr, &factor, &Value::zero()) {
            Some(true) => below.push((bound, one.relation)),
            Some(false) if assumptions.decide(Relation::Lss, &factor, &Value::zero()) == Some(true) => {
                above.push((bound, one.relation));
            }
            _ => return Err(Stuck::Sign(factor)),
        }
    }
    if let Some(image) = equal {
        let put = |one: &Constraint| -> Result<Constraint, ValueError> {
            Ok(Constraint { form: one.form.with(name, &image)?, relation: one.relation })
        };
        return Ok(constraints.iter().map(put).collect::<Result<_, ValueError>>()?);
    }
    if below.len() * above.len() + free.len() > MOST_CONSTRAINTS {
        return Err(ValueError("there are too many constraints".to_string()).into());
    }
    for (low, first) in &below {
        for (high, second) in &above {
            let strict = *first == Relation::Gtr || *second == Relation::Gtr;
            let relation = if strict { Relation::Gtr } else { Relation::Gte };
            free.insert(Constraint { form: high.sub(low)?, relation });
        }
    }
    Ok(free)
}

/// Whether a clause holds: all its tests failing contradicts the assumptions.
fn excluded(assumptions: &Assumptions, clause: &[Test]) -> bool {
    let mut all = assumptions.clone();
    for test in clause.iter().map(Test::negated) {
        all.assume(test.relation, &test.left, &test.right);
    }
    all.plainly_contradictory() || all.contradictory()
}

/// What makes clauses hold.
#[derive(Default)]
pub struct Sufficient {
    /// Tests that do.
    pub found: Vec<Vec<Test>>,
    /// Tests that were guessed first, and with which no instance breaks the claim.
    pub guess: Option<Vec<Test>>,
}

/// Single tests, and pairs of others, that make all clauses hold, none of which follows from another: the weakest first.
/// Where there are none, more tests, that tell the points in which all clauses hold from the others.
pub fn sufficient(assumptions: &Assumptions, clauses: &[Clause], points: &Points<'_>) -> Sufficient {
    let all = literals(assumptions, clauses.iter().flatten());
    let within = points.within_all(clauses);
    let mut seen: Vec<Test> = all.iter().take(MOST_LITERALS).cloned().collect();
    let holds = |tests: &[Test]| {
        let with = supposed(assumptions, tests);
        points.only(tests, &within) && !with.contradictory() && clauses.iter().all(|clause| excluded(&with, clause))
    };
    let singles: Vec<Vec<Test>> = seen.iter().map(|test| vec![test.clone()]).filter(|tests| holds(tests)).collect();
    seen.retain(|test| !singles.iter().any(|single| single.contains(test)));
    let pairs = seen
        .iter()
        .enumerate()
        .flat_map(|(place, one)| seen.iter().skip(place + 1).map(move |other| vec![one.clone(), other.clone()]));
    let pairs: Vec<Vec<Test>> = pairs.take(MOST_PAIRS).filter(|tests| holds(tests)).collect();
    let found = weakest(assumptions, singles.into_iter().chain(pairs));
    if found.is_empty() { by_points(assumptions, clauses, &all, points) } else { Sufficient { found, guess: None } }
}

/// Tests that tell the points in which all clauses hold from the others; where a clause does not follow from them, points
/// are asked for in which it does not hold.
fn by_points(assumptions: &Assumptions, clauses: &[Clause], literals: &[Test], points: &Points<'_>) -> Sufficient {
    let mut told = Sufficient::default();
    for _ in 0..MOST_MENDED {
        let within = points.within_all(clauses);
        let beyond: Vec<bool> = within.iter().map(|inside| !inside).collect();
        let Some(tests) = points.cover(literals, &within, &beyond).filter(|tests| !tests.is_empty()) else { break };
        let with = supposed(assumptions, &tests);
        if told.guess.is_none() && points.allow(&tests) {
            told.guess = Some(tests.clone());
        }
        let open: Vec<&Clause> = clauses.iter().filter(|clause| !excluded(&with, clause)).take(MOST_OPEN).collect();
        if open.is_empty() {
            told.found = vec![tests];
            break;
        }
        let against =
            |clause: &Clause| tests.iter().cloned().chain(clause.iter().map(Test::negated)).collect::<Vec<_>>();
        // Each is asked for, whatever came of the others.
        let fresh = open.iter().filter(|clause| points.sample(&against(clause))).count();
        if fresh == 0 {
            break;
        }
    }
    told
}

/// Those conditions of which none follows from another.
pub fn weakest(assumptions: &Assumptions, found: impl IntoIterator<Item = Vec<Test>>) -> Vec<Vec<Test>> {
    let implies = |one: &[Test], other: &[Test]| {
        let with = supposed(assumptions, one);
        other.iter().all(|test| test.decide(&with) == Some(true))
    };
    let mut weakest: Vec<Vec<Test>> = Vec::new();
    for one in found {
        if weakest.iter().any(|other| implies(&one, other)) {
            continue;
        }
        weakest.retain(|other| !implies(other, &one));
        weakest.push(one);
    }
    weakest
}

/// Tests in the form in which they are printed, each once, the shortest first.
pub fn literals<'a>(assumptions: &Assumptions, tests: impl Iterator<Item = &'a Test>) -> Vec<Test> {
    let all: BTreeSet<Test> = tests.map(|test| solved(assumptions, test)).collect();
    let mut all: Vec<Test> = all.into_iter().collect();
    all.sort_by_key(|test| test.left.size() + test.right.size());
    all
}

/// `h >= 1 + v*t` for `h - 1 - v*t >= 0`: a variable alone on the left, where one stands alone, of those that leave the
/// fewest minus signs behind. A factor that is known to be positive is left out.
pub fn solved(assumptions: &Assumptions, test: &Test) -> Test {
    let Ok(difference) = test.left.sub(&test.right).map(|difference| without_factors(assumptions, difference)) else {
        return test.clone();
    };
    let mut best: Option<((usize, bool), Test)> = None;
    for name in difference.variables() {
        let Some((factor, rest)) = difference.linear_in(&name) else { continue };
        let Some(number) = factor.as_rational() else { continue };
        let Ok(right) = rest.neg().and_then(|rest| rest.div(&factor)) else { continue };
        let relation = if number.is_negative() { test.relation.mirrored() } else { test.relation };
        let rank = (minus_signs(&right), !number.abs().is_one());
        if best.as_ref().is_none_or(|(good, _)| rank < *good) {
            best = Some((rank, Test { relation, left: Value::variable(&name), right }));
        }
    }
    let plain = || Test { relation: test.relation, left: difference.clone(), right: Value::zero() };
    best.map_or_else(plain, |(_, test)| test)
}

fn minus_signs(value: &Value) -> usize {
    value.to_string().matches('-').count()
}

/// The value without the variables that are positive and stand in each of its products: of the same sign.
fn without_factors(assumptions: &Assumptions, mut value: Value) -> Value {
    for name in value.variables() {
        let variable = Value::variable(&name);
        while let Some((factor, rest)) = value.linear_in(&name)
            && rest == Value::zero()
            && !factor.variables().is_empty()
            && assumptions.decide(Relation::Gtr, &variable, &Value::zero()) == Some(true)
        {
            value = factor;
        }
    }
    value
}
