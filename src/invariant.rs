//! What always holds of a system: the small checker behind `prove Sys always C`.
//!
//! It knows nothing of how an invariant was found. It re-derives every inequality, or follows every step of the
//! executable meaning, and is the only maker of [`Safe`].

pub mod cases;
pub mod circle;
mod curved;
mod sheared;
mod visited;

use std::collections::{BTreeMap, BTreeSet, HashSet};

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::model::explore::successors;
use crate::model::{Model, Patience, State};
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Test};
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value, ValueError, View};
use cases::impossible;
use circle::{Planes, Round};
pub use sheared::sheared;
pub use visited::check_visited;

/// Whenever all of these are shown for some time, the tests hold of the values shown.
#[derive(Clone, Debug)]
pub struct Claim {
    /// Observers, with names for the values they show.
    pub shown: Vec<Term>,
    /// The names that stand for what is shown.
    pub variables: BTreeSet<Name>,
    /// What must hold.
    pub tests: Vec<Test>,
}

/// What must hold at one moment.
#[derive(Clone, Debug)]
pub struct Duty {
    /// If these hold: the values shown are those that the claim names.
    pub premises: Vec<Test>,
    /// Then these must.
    pub tests: Vec<Test>,
}

impl Claim {
    /// What must hold while this is shown: one duty for each way to read the claim in it.
    ///
    /// # Errors
    /// When a value has no normal form.
    pub fn duties(&self, observed: &[Term]) -> Result<Vec<Duty>, ValueError> {
        let mut readings: Vec<Reading> = vec![Reading::default()];
        for pattern in &self.shown {
            let mut longer = Vec::new();
            for reading in &readings {
                longer.extend(observed.iter().filter_map(|term| self.read(pattern, term, reading)));
            }
            readings = longer;
        }
        let mut duties = Vec::new();
        for Reading { names, equal } in readings {
            let mut premises = Vec::new();
            for (pattern, value) in equal {
                // Only the pattern speaks in the claim's names.
                premises.push(Test { relation: Relation::Eq, left: pattern.substitute(&names)?, right: value });
            }
            let tests = self.tests.iter().map(|test| test.substitute(&names)).collect::<Result<_, _>>()?;
            duties.push(Duty { premises, tests });
        }
        Ok(duties)
    }

    /// One observer read as one pattern.
    fn read(&self, pattern: &Term, term: &Term, before: &Reading) -> Option<Reading> {
        let (Node::Observe(wanted, patterns), Node::Observe(name, values)) = (pattern.node(), term.node()) else {
            return None;
        };
        if wanted != name || patterns.len() != values.len() {
            return None;
        }
        let mut reading = before.clone();
        for (pattern, value) in patterns.iter().zip(values) {
            let free = pattern.as_variable().filter(|name| self.variables.contains(*name));
            match free {
                Some(name) if !reading.names.contains_key(name) => {
                    reading.names.insert(name.clone(), value.clone());
                }
                _ => reading.equal.push((pattern.clone(), value.clone())),
            }
        }
        Some(reading)
    }
}

/// What the names of a claim stand for, and which values must be equal for that.
#[derive(Clone, Debug, Default)]
struct Reading {
    names: BTreeMap<Name, Value>,
    equal: Vec<(Value, Value)>,
}

/// A claim that was checked. Only this module makes one.
#[derive(Clone, Debug)]
pub struct Safe {
    inequalities: usize,
    states: usize,
    trusted: Vec<String>,
}

impl Safe {
    /// How many implications were derived.
    pub fn inequalities(&self) -> usize {
        self.inequalities
    }

    /// How many states of the executable meaning were looked at.
    pub fn states(&self) -> usize {
        self.states
    }

    /// What was taken on trust.
    pub fn trusted(&self) -> &[String] {
        &self.trusted
    }
}

/// Why an invariant is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejected(pub String);

impl From<ValueError> for Rejected {
    fn from(error: ValueError) -> Rejected {
        Rejected(error.0)
    }
}

/// What is taken on trust where an invariant of the phases is checked.
pub const PERIOD: &str = "that the phases with their flow functions, as printed, are all that the system does";

/// Checks an invariant: for each phase, tests of its variables. They hold when a phase is entered, whatever the way,
/// and the claim follows from them wherever something is shown.
///
/// # Errors
/// The first implication that does not follow.
pub fn check(
    period: &Period,
    assumptions: &Assumptions,
    claim: &Claim,
    invariant: &[Vec<Test>],
) -> Result<Safe, Rejected> {
    let mut checker = Checker { period, assumptions, claim, invariant, derived: 0 };
    checker.rounds()?;
    for edge in &period.initial {
        checker.edge(edge, &[])?;
    }
    Ok(Safe { inequalities: checker.derived, states: 0, trusted: vec![PERIOD.to_string()] })
}

struct Checker<'a> {
    period: &'a Period,
    assumptions: &'a Assumptions,
    claim: &'a Claim,
    invariant: &'a [Vec<Test>],
    derived: usize,
}

impl Checker<'_> {
    /// What holds in a phase leads to the claim, and to what holds in the next, whatever way is taken.
    fn rounds(&mut self) -> Result<(), Rejected> {
        if self.assumptions.contradictory() {
            return Err(Rejected("the assumptions contradict each other".to_string()));
        }
        if self.invariant.len() != self.period.phases.len() {
            return Err(Rejected("an invariant says something of each phase".to_string()));
        }
        for (phase, known) in self.period.phases.iter().zip(self.invariant) {
            for edge in &phase.edges {
                self.edge(edge, known)?;
            }
        }
        Ok(())
    }

    fn edge(&mut self, edge: &Edge, known: &[Test]) -> Result<(), Rejected> {
        for goal in goals(self.period, self.claim, self.invariant, edge)? {
            let mut premises = premises(edge, known);
            premises.extend(goal.premises.iter().cloned());
            for test in &goal.tests {
                if !follows(self.assumptions, &premises, test) {
                    let premises: Vec<String> = premises.iter().map(Test::to_string).collect();
                    return Err(Rejected(match premises.as_slice() {
                        [] if test.decide(self.assumptions) == Some(false) => {
                            format!("what was tried would need {test}")
                        }
                        [] => format!("nothing is known from which {test} would follow"),
                        premises => format!("{test} does not follow from {}", premises.join(" and ")),
                    }));
                }
                self.derived += 1;
            }
        }
        Ok(())
    }
}

/// Whether a test follows from others under the assumptions; false also where that is not found out.
pub fn follows(assumptions: &Assumptions, premises: &[Test], test: &Test) -> bool {
    let from = |known: &[Test], test: &Test| {
        premises.contains(test) || impossible(assumptions, &[premises, known, &[test.negated()]].concat())
    };
    if from(&[], test) {
        return true;
    }
    let curved: Vec<Round> = premises.iter().filter_map(Round::of).collect();
    let within = |test: &Test| {
        let strips = curved::strips(&curved, test);
        from(&strips, test)
    };
    let Some(claim) = Round::of(test) else { return !curved.is_empty() && within(test) };
    let planes = claim.planes();
    let inside = || match &planes {
        Some(Planes::Any(tests)) => tests.iter().any(within),
        Some(Planes::All(tests)) => tests.iter().all(within),
        None => false,
    };
    let tried = planes.as_ref().map_or(&[][..], Planes::tests);
    let beyond = || curved::aside(&claim, premises).iter().any(|test| !tried.contains(test) && within(test));
    curved.iter().any(|known| curved::implied(known, &claim)) || inside() || beyond()
}

/// What holds on the way along an edge.
pub fn premises(edge: &Edge, known: &[Test]) -> Vec<Test> {
    let mut all = known.to_vec();
    all.extend(edge.tests.iter().cloned());
    all.extend(edge.draws.iter().flat_map(|(name, distribution)| support(name, distribution)));
    all
}

/// What must follow along an edge: the claim wherever something is shown, and the invariant of the phase it reaches.
///
/// # Errors
/// When a value has no normal form, or there is no such phase.
pub fn goals(period: &Period, claim: &Claim, invariant: &[Vec<Test>], edge: &Edge) -> Result<Vec<Duty>, ValueError> {
    let mut goals = Vec::new();
    for segment in &edge.segments {
        goals.extend(claim.duties(&segment.observed)?);
    }
    match &edge.next {
        Next::Phase(number) => {
            let Some(next) = invariant.get(*number).filter(|_| *number < period.phases.len()) else {
                return Err(ValueError("a phase is missing".to_string()));
            };
            let tests = next.iter().map(|test| test.substitute(&edge.map)).collect::<Result<_, _>>()?;
            goals.push(Duty { premises: Vec::new(), tests });
        }
        Next::End(End::Silent { observed, .. }) => goals.extend(claim.duties(observed)?),
        Next::End(_) => {}
    }
    Ok(goals)
}

/// What a draw surely is.
pub fn support(name: &Name, distribution: &Value) -> Vec<Test> {
    let View::Distribution(kind, arguments) = distribution.view() else { return Vec::new() };
    let drawn = Value::variable(name);
    let test = |relation: Relation, right: &Value| Test { relation, left: drawn.clone(), right: right.clone() };
    match (kind.as_str(), arguments.as_slice()) {
        ("Point", [value]) if value.sort() == Sort::Real => vec![test(Relation::Eq, value)],
        ("Uniform", [low, high]) => vec![test(Relation::Gte, low), test(Relation::Lte, high)],
        ("Exp", [_]) => vec![test(Relation::Gtr, &Value::zero())],
        ("Poisson", [_]) => vec![test(Relation::Gte, &Value::zero())],
        ("Mix", _) => {
            let (low, high) = bounds(distribution);
            if let (Some(only), true) = (&low, low == high) {
                return vec![test(Relation::Eq, &Value::rational(only.clone()))];
            }
            let low = low.map(|low| test(Relation::Gte, &Value::rational(low)));
            low.into_iter().chain(high.map(|high| test(Relation::Lte, &Value::rational(high)))).collect()
        }
        _ => Vec::new(),
    }
}

/// Numbers between which all lies that is drawn from a distribution, as far as there are such; of a mixture those of all
/// its parts.
fn bounds(distribution: &Value) -> (Option<BigRational>, Option<BigRational>) {
    let View::Distribution(kind, arguments) = distribution.view() else { return (None, None) };
    match (kind.as_str(), arguments.as_slice()) {
        ("Point", [value]) => (value.as_rational(), value.as_rational()),
        ("Uniform", [low, high]) => (low.as_rational(), high.as_rational()),
        ("Exp" | "Poisson", [_]) => (Some(BigRational::zero()), None),
        ("Mix", _) => {
            let parts: Vec<_> = arguments.chunks(2).filter_map(|pair| pair.get(1)).map(bounds).collect();
            let lows: Option<Vec<BigRational>> = parts.iter().map(|(low, _)| low.clone()).collect();
            let highs: Option<Vec<BigRational>> = parts.into_iter().map(|(_, high)| high).collect();
            (lows.and_then(|all| all.into_iter().min()), highs.and_then(|all| all.into_iter().max()))
        }
        _ => (None, None),
    }
}

/// Checks that a set of states is closed under every step of the executable meaning, holds the start, and meets the
/// claim wherever time can pass.
///
/// # Errors
/// The state that is missing, or that does not meet the claim.
pub fn check_states(
    system: &Term,
    definitions: &Definitions,
    assumptions: &Assumptions,
    claim: &Claim,
    states: &[State],
) -> Result<Safe, Rejected> {
    let model = Model::new(definitions);
    let meaning = |error: crate::model::Meaningless| Rejected(error.why);
    let known: HashSet<&State> = states.iter().collect();
    let start = model.state(system).map_err(meaning)?;
    if !known.contains(&start) {
        return Err(Rejected("the start is missing".to_string()));
    }
    for state in states {
        if !meets(claim, state, assumptions)? {
            return Err(Rejected("a state does not meet the claim".to_string()));
        }
        if state.moves().map_err(meaning)?.iter().any(crate::model::Move::needs_value) {
            return Err(Rejected("a state waits for a value that may be any".to_string()));
        }
        for (_, next) in successors(&model, state, &[]).map_err(meaning)? {
            if !known.contains(&next) {
                return Err(Rejected("a state that can be reached is missing".to_string()));
            }
        }
    }
    Ok(Safe { inequalities: 0, states: states.len(), trusted: Vec::new() })
}

/// Whether a state meets a claim: surely so if no time can pass in it.
///
/// # Errors
/// When that is not known.
pub fn meets(claim: &Claim, state: &State, assumptions: &Assumptions) -> Result<bool, Rejected> {
    let moves = state.moves().map_err(|error| Rejected(error.why))?;
    if state.patience(&moves) == Patience::None {
        return Ok(true);
    }
    for duty in claim.duties(&shown(state))? {
        let mut applies = true;
        for premise in &duty.premises {
            applies &= decided(premise, assumptions)?;
        }
        for test in duty.tests.iter().filter(|_| applies) {
            if !decided(test, assumptions)? {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// What a state shows.
pub fn shown(state: &State) -> Vec<Term> {
    state.observations().into_iter().map(|(name, values)| Term::new(Node::Observe(name, values))).collect()
}

fn decided(test: &Test, assumptions: &Assumptions) -> Result<bool, Rejected> {
    test.decide(assumptions).ok_or_else(|| Rejected(format!("it must be known whether {test}")))
}
