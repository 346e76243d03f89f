//! What a system shows in all values that some variables of its phases come to: the others may be anything.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use super::{Checker, Claim, PERIOD, Rejected, Safe};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Test};
use crate::value::Value;

/// The bits of a value.
const MOST_BITS: u64 = 512;

/// A phase with the values of those of its variables that are followed and known.
type State = (usize, BTreeMap<Name, Value>);

/// Checks the claim in every state that the phases come to, where of each phase these variables alone are followed. Of what
/// is not followed nothing is known: a test that asks for it may come out either way, and a claim that does is not met.
///
/// From a state in which the tests of its phase in `invariant` hold, nothing needs to be followed further: they lead to the
/// claim, and to each other, whatever way is taken. It is given up after so many states as are `enough`.
///
/// # Errors
/// What does not meet the claim, that the states do not come round, or the implication that does not follow.
pub fn check_visited(
    period: &Period,
    assumptions: &Assumptions,
    claim: &Claim,
    followed: &[BTreeSet<Name>],
    invariant: Option<&[Vec<Test>]>,
    enough: &dyn Fn(usize) -> bool,
) -> Result<Safe, Rejected> {
    if assumptions.contradictory() {
        return Err(Rejected("the assumptions contradict each other".to_string()));
    }
    let mut inequalities = 0;
    if let Some(invariant) = invariant {
        let mut checker = Checker { period, assumptions, claim, invariant, derived: 0 };
        checker.rounds()?;
        inequalities = checker.derived;
    }
    let visitor = Visitor { period, assumptions, claim, followed };
    let mut visited: HashSet<State> = HashSet::new();
    let mut open: Vec<State> = Vec::new();
    for edge in &period.initial {
        open.extend(visitor.step(edge, &BTreeMap::new())?);
    }
    while let Some(state) = open.pop() {
        if !visited.insert(state.clone()) {
            continue;
        }
        if enough(visited.len()) {
            return Err(Rejected(format!("after {} states nothing has repeated", visited.len())));
        }
        if let Some(tests) = invariant.and_then(|invariant| invariant.get(state.0))
            && holds(tests, &state.1, assumptions)?
        {
            continue;
        }
        let Some(phase) = period.phases.get(state.0) else { return Err(Rejected("a phase is missing".to_string())) };
        for edge in &phase.edges {
            open.extend(visitor.step(edge, &state.1)?);
        }
    }
    Ok(Safe { inequalities, states: visited.len(), trusted: vec![PERIOD.to_string()] })
}

/// Whether all tests surely hold of these values.
fn holds(tests: &[Test], values: &BTreeMap<Name, Value>, assumptions: &Assumptions) -> Result<bool, Rejected> {
    for test in tests {
        if test.substitute(values)?.decide(assumptions) != Some(true) {
            return Ok(false);
        }
    }
    Ok(true)
}

struct Visitor<'a> {
    period: &'a Period,
    assumptions: &'a Assumptions,
    claim: &'a Claim,
    followed: &'a [BTreeSet<Name>],
}

impl Visitor<'_> {
    /// Where a way leads from these values, if it may be taken and leads on; what is shown on it must meet the claim.
    fn step(&self, edge: &Edge, values: &BTreeMap<Name, Value>) -> Result<Option<State>, Rejected> {
        for test in &edge.tests {
            if test.substitute(values)?.decide(self.assumptions) == Some(false) {
                return Ok(None);
            }
        }
        let shown = edge.segments.iter().map(|segment| &segment.observed);
        let at_end = match &edge.next {
            Next::End(End::Silent { observed, .. }) => Some(observed),
            _ => None,
        };
        for observed in shown.chain(at_end) {
            for duty in self.claim.duties(observed)? {
                let tests =
                    |tests: &[Test]| tests.iter().map(|test| test.substitute(values)).collect::<Result<Vec<_>, _>>();
                let excluded = |test: &Test| test.decide(self.assumptions) == Some(false);
                if tests(&duty.premises)?.iter().any(excluded) {
                    continue;
                }
                if let Some(test) = tests(&duty.tests)?.iter().find(|test| test.decide(self.assumptions) != Some(true))
                {
                    return Err(Rejected(format!("it must be known whether {test}")));
                }
            }
        }
        let Next::Phase(next) = edge.next else { return Ok(None) };
        let (Some(phase), Some(followed)) = (self.period.phases.get(next), self.followed.get(next)) else {
            return Err(Rejected("a phase is missing".to_string()));
        };
        let mut reached = BTreeMap::new();
        for name in phase.variables.iter().filter(|name| followed.contains(*name)) {
            let Some(image) = edge.map.get(name) else { continue };
            let image = image.substitute(values)?;
            // A value that hangs on what is not followed, or was drawn, is not known.
            if image.variables().is_empty() && image.bits() <= MOST_BITS {
                reached.insert(name.clone(), image);
            }
        }
        Ok(Some((next, reached)))
    }
}
