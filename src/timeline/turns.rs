//! A run that goes round for ever without repeating exactly, as one that repeats: each turn takes the same ways for the
//! same times, and what is shown in it stays within intervals. It tells about all that is to come what is alike for
//! the whole of these.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::{Signed, ToPrimitive};

use super::{Ending, Stretch, Timeline};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::period::{Period, Phase};
use crate::term::{Node, Term};
use crate::value::Value;
use crate::verify::influence::reduced;
use crate::verify::trajectory::walk;
use crate::verify::{Trajectory, Unit};

/// Stretches of the turns and of what comes before them, at most.
const MOST_STRETCHES: usize = 20_000;

/// The run along the phases, as far as these observers show it, where PARS finds that its turns come again and again.
pub fn turns(
    period: &Period,
    known: (&Definitions, &Assumptions),
    observers: &BTreeSet<Name>,
    interrupted: &dyn Fn() -> bool,
) -> Option<Timeline> {
    let shown = Term::par(observers.iter().map(|name| Term::new(Node::Observe(name.clone(), Vec::new()))));
    // Rounds whose length changes are no turns that come again.
    let changes = |phase: &Phase| {
        let mut times = phase.edges.iter().flat_map(|edge| &edge.segments).map(|segment| &segment.duration);
        times.any(|time| phase.variables.iter().any(|name| time.mentions(name)))
    };
    if period.phases.iter().any(changes) {
        return None;
    }
    let reduced = reduced(period, &shown);
    repeating(&walk(reduced.as_ref().unwrap_or(period), known, &shown, interrupted), observers)
}

/// A run of numbers whose legs repeat, stretch by stretch.
fn repeating(run: &Trajectory, observers: &BTreeSet<Name>) -> Option<Timeline> {
    let cycle = run.cycle?;
    let ending = Ending::Unknown("it was not followed".to_string());
    let mut line = Timeline { stretches: Vec::new(), ending, at: BTreeMap::new(), known: run.assumptions.clone() };
    let mut time = Value::zero();
    add(&run.opening, observers, &mut time, &mut line)?;
    let mut from = line.stretches.len();
    for (place, leg) in run.legs.iter().enumerate() {
        if place == cycle {
            from = line.stretches.len();
        }
        add(&leg.units, observers, &mut time, &mut line)?;
    }
    // A turn in no time would be no run.
    (from < line.stretches.len()).then_some(())?;
    line.ending = Ending::Repeats(from);
    Some(line)
}

/// What passes in these units; nothing where some time is no number.
fn add(units: &[Unit], observers: &BTreeSet<Name>, time: &mut Value, line: &mut Timeline) -> Option<()> {
    for unit in units {
        let count = match unit {
            Unit::Single(_) => 1,
            Unit::Repeat { count, .. } => {
                count.as_ref()?.as_rational().filter(|count| count.is_integer())?.to_integer().to_usize()?
            }
        };
        for number in 0..count {
            for segment in unit.round(&Value::integer(i64::try_from(number).ok()?)).ok()? {
                let duration = segment.duration.as_rational()?;
                if !duration.is_positive() {
                    continue;
                }
                if line.stretches.len() >= MOST_STRETCHES {
                    return None;
                }
                let asked = |term: &Term| matches!(term.node(), Node::Observe(name, _) if observers.contains(name));
                let shown = segment.observed.into_iter().filter(asked).collect();
                let (start, before) = (time.clone(), Vec::new());
                *time = time.add(&segment.duration).ok()?;
                let duration = Some(segment.duration);
                line.stretches.push(Stretch { start, duration, shown, before, phase: None });
            }
        }
    }
    Some(())
}
