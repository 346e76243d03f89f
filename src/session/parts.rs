//! A system that falls into parts without a common port: side by side they have as many ways as the product of theirs,
//! so that where these are many, each part is told by itself.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::beside::{means_something, relevant, time_passes};
use super::course::{Known, course_of};
use super::phases::whole;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{self, Failure, Next, Period, drifting, ports};
use crate::term::Term;
use crate::value::{Relation, Value};

/// So many ways from phase to phase are followed in one graph.
const MOST_TOGETHER: usize = 500;

/// So many parts are looked at one by one.
const MOST_PARTS: usize = 100;

/// Components that share no port with the others, with their period.
pub(crate) struct Part {
    /// The components, under the name of the system.
    pub(crate) system: System,
    /// Their period.
    pub(crate) period: Period,
}

impl Part {
    /// Its components by name.
    pub(crate) fn names(&self) -> String {
        self.period.names.join(", ")
    }
}

/// The parts of a system, and how many ways they have side by side; none where these are few, or a part may end, stop
/// time, or come to a value without a meaning: then it matters to the others.
pub(crate) fn parted(
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<(Vec<Part>, usize)> {
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let components = ports::flatten(&system.components, definitions);
    let groups = ports::System::of(&components, definitions).groups();
    if groups.len() < 2 || groups.len() > MOST_PARTS {
        return None;
    }
    let (mut parts, mut together) = (Vec::new(), 1usize);
    for group in groups {
        let own: Vec<Term> = group.into_iter().map(|place| components[place].clone()).collect();
        let period = period::analyse_until(&own, definitions, assumptions, interrupted).ok()?;
        together = together.saturating_mul(period.phases.iter().map(|phase| phase.edges.len()).sum::<usize>().max(1));
        let goes_on = |edge: &period::Edge| matches!(edge.next, Next::Phase(_));
        if !period.initial.iter().chain(period.phases.iter().flat_map(|phase| &phase.edges)).all(goes_on) {
            return None;
        }
        parts.push(Part { system: System { name: system.name.clone(), components: own }, period });
    }
    let passes = |part: &Part| {
        means_something(&part.system.components, environment) && time_passes(&part.system.components, environment)
    };
    (together > MOST_TOGETHER && parts.iter().all(passes)).then_some((parts, together))
}

/// Of a system that falls into parts with many ways side by side, those that show what is asked for.
pub(super) fn large_part(
    system: &System,
    shown: &[Term],
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<System> {
    parted(system, environment, interrupted)?;
    relevant(system, shown, environment)
}

/// How a part goes on that has one way alone.
pub(super) fn steady(part: &Part, environment: &Environment, interrupted: &dyn Fn() -> bool) -> Option<Known> {
    let course = part.period.course(&environment.assumptions, interrupted)?;
    Some(Known { course, moving: false })
}

/// How long all parts take together, with what is said of it; none where it is not known of one of them.
///
/// # Errors
/// Why they drift, if two of the times have no common multiple.
pub(crate) fn in_all(
    parts: &[Part],
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Result<Option<String>, Failure> {
    let (mut courses, mut moving) = (Vec::new(), false);
    for part in parts {
        let known = course_of(&part.period, &part.system, environment, interrupted).ok().flatten();
        let Some(known) = known.or_else(|| steady(part, environment, interrupted)) else { return Ok(None) };
        moving |= known.moving;
        courses.push((part.names(), known.course));
    }
    Ok(together(&courses, environment)?.map(|course| whole(&course, moving)))
}

/// How long all parts take together, from where each of them comes again so: the least common multiple of their times.
///
/// # Errors
/// Why they drift, if two of the times have no common multiple.
pub(super) fn together(parts: &[(String, Course)], environment: &Environment) -> Result<Option<Course>, Failure> {
    let known = &environment.assumptions;
    let rounds = |(name, course): &(String, Course)| match course {
        Course::Repeats { lasting, .. } => Some((name.clone(), lasting.clone())),
        Course::Ends(..) => None,
    };
    let Some(rounds) = parts.iter().map(rounds).collect::<Option<Vec<_>>>() else { return Ok(None) };
    if let Some(drift) = drifting(&rounds, known) {
        return Err(drift);
    }
    let common = || {
        let mut rounds = rounds.iter();
        let mut common = rounds.next()?.1.clone();
        for (_, lasting) in rounds {
            let ratio = lasting.div(&common).ok()?.as_rational()?;
            common = common.mul(&Value::rational(BigRational::from_integer(ratio.numer().clone()))).ok()?;
        }
        let (mut latest, mut all) = (Value::zero(), BTreeSet::<Name>::new());
        for (_, course) in parts {
            let Course::Repeats { from, beside, .. } = course else { return None };
            if known.decide(Relation::Gtr, from, &latest)? {
                latest = from.clone();
            }
            all.extend(beside.iter().cloned());
        }
        Some(Course::Repeats { lasting: common, from: latest, beside: all })
    };
    Ok(common())
}
