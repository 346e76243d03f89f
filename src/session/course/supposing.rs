//! Where a system would come to if every phase ended of which that is not known: in numbers of rounds that are symbols.

use std::cell::Cell;

use super::{MOST_LOOKS, again};
use crate::lower::Environment;
use crate::period::Period;
use crate::period::course::Course;
use crate::session::phases::whole;
use crate::term::Term;
use crate::verify::influence::reduced;
use crate::verify::trajectory::{Leg, Rounds};
use crate::verify::walk_supposing;

/// Where it would come to, and what is supposed.
pub(super) struct Supposed {
    course: Course,
    /// The legs in words.
    legs: String,
    /// What the numbers of rounds are.
    numbers: Vec<String>,
}

impl Supposed {
    pub(super) fn lines(&self, unknown: &str) -> Vec<String> {
        let does = if matches!(self.course, Course::Repeats { .. }) { ", it does" } else { "" };
        let mut lines = vec![format!("{unknown}; if these numbers of rounds exist{does}:")];
        lines.extend(self.numbers.iter().map(|line| format!("  {line}")));
        lines.push(format!("  {}", self.legs));
        lines.push(format!("  {}", whole(&self.course, true)));
        lines
    }
}

/// Where the run comes to if each phase ends that is left at all, with as many rounds as symbols stand for.
pub(super) fn supposing(
    period: &Period,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<Supposed> {
    if interrupted() || period.ways().any(|edge| !edge.draws.is_empty()) {
        return None;
    }
    let nothing = Term::par([]);
    let steered = reduced(period, &nothing);
    let known = (&environment.definitions, &environment.assumptions);
    let looks = Cell::new(0usize);
    let enough = || {
        looks.set(looks.get() + 1);
        looks.get() > MOST_LOOKS || interrupted()
    };
    let run = walk_supposing(steered.as_ref().unwrap_or(period), known, &nothing, &enough)?;
    let rests = run.legs.iter().flat_map(|leg| &leg.conditions);
    if rests.into_iter().any(|test| test.decide(&environment.assumptions) != Some(true)) {
        return None;
    }
    let course = again(&run, period, &run.assumptions)?;
    let numbers = run.supposed.iter().map(|one| one.line()).collect();
    let legs = |legs: &[Leg]| legs.iter().map(leg).collect::<Vec<_>>().join(", ");
    let legs = match run.cycle.and_then(|from| run.legs.split_at_checked(from)) {
        Some(([], turn)) => format!("again and again {}", legs(turn)),
        Some((first, turn)) => format!("{}, then again and again {}", legs(first), legs(turn)),
        None => legs(&run.legs),
    };
    Some(Supposed { course, legs, numbers })
}

fn leg(leg: &Leg) -> String {
    match &leg.rounds {
        Rounds::Count(count) if count.as_rational().is_some_and(|count| num_traits::One::is_one(&count)) => {
            format!("phase {} once", leg.phase + 1)
        }
        Rounds::Count(count) => format!("phase {} {count} times", leg.phase + 1),
        Rounds::Forever(_) => format!("phase {} for ever", leg.phase + 1),
    }
}
