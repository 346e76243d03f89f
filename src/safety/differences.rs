//! What depends on differences alone: two that go on for ever, and of which only the gap counts.

use std::cell::Cell;
use std::collections::BTreeSet;

use super::Asked;
use crate::invariant::{Safe, check_visited, sheared};
use crate::name::Name;
use crate::period::Period;

/// Variables of all phases among which differences are looked for.
const MOST_VARIABLES: usize = 6;
/// States that are visited in one choice of differences, and in all.
const MOST_STATES: usize = 5_000;
const ALL_STATES: usize = 20_000;

/// Follows the phases in the differences of some variables from one, which is not followed itself.
pub(super) fn by_differences(period: &Period, asked: Asked<'_>) -> Option<Safe> {
    let Asked { claim, assumptions, interrupted, .. } = asked;
    let all: BTreeSet<Name> = period.phases.iter().flat_map(|phase| phase.variables.iter().cloned()).collect();
    if all.len() < 2 || all.len() > MOST_VARIABLES {
        return None;
    }
    let visited = Cell::new(0);
    let enough = |states: usize| {
        visited.set(visited.get() + 1);
        states > MOST_STATES || visited.get() > ALL_STATES || interrupted()
    };
    for base in &all {
        let rest: Vec<&Name> = all.iter().filter(|name| *name != base).collect();
        // The larger sets first: what drifts mostly drifts with all that is a position.
        for chosen in (1..1_usize << rest.len()).rev() {
            let others = rest.iter().enumerate().filter(|(place, _)| chosen >> place & 1 == 1);
            let others: BTreeSet<Name> = others.map(|(_, name)| (*name).clone()).collect();
            let Ok(sheared) = sheared(period, base, &others) else { continue };
            let followed: Vec<BTreeSet<Name>> = sheared
                .phases
                .iter()
                .map(|phase| phase.variables.iter().filter(|name| *name != base).cloned().collect())
                .collect();
            if let Ok(safe) = check_visited(&sheared, assumptions, claim, &followed, None, &enough) {
                return Some(safe);
            }
            if visited.get() > ALL_STATES || interrupted() {
                return None;
            }
        }
    }
    None
}
