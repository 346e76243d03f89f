//! A system that falls into parts without a common port: side by side they have as many ways as the product of theirs,
//! so that where these are many, each part is told by itself.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::beside::{each_way_means_something, means_something, relevant, time_passes_in};
use super::course::{Known, course_of};
use super::phases::whole;
use crate::lower::{Environment, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{self, Failure, Next, Period, drifting, ports};
use crate::term::Term;
use crate::value::{Relation, Value};

/// So many ways from phase to phase are followed in one graph: of more the graph, and each round of it that the kernel follows, cost
/// far more than those of the parts.
const MOST_TOGETHER: usize = 40;

/// So many parts are looked at one by one.
const MOST_PARTS: usize = 2_000;

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
    let found = separate(system, environment, interrupted)?;
    (found.1 > MOST_TOGETHER && leave_each_other(&found.0, environment)).then_some(found)
}

/// The same of a system that was followed as a whole, and no period found: its parts may have one each, as those do that
/// go round in 1 and in 40009.
pub(crate) fn parted_after(
    failures: &[Failure],
    system: &System,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
) -> Option<(Vec<Part>, usize)> {
    let given_up = |failure: &Failure| matches!(failure, Failure::NoPeriod { .. });
    let open = |failure: &Failure| {
        given_up(failure) || matches!(failure, Failure::NoCommunication { .. } | Failure::Lonely(_))
    };
    if !failures.iter().any(given_up) || !failures.iter().all(open) {
        return None;
    }
    separate(system, environment, interrupted).filter(|(parts, _)| leave_each_other(parts, environment))
}

/// Whether nothing in one part matters to another.
fn leave_each_other(parts: &[Part], environment: &Environment) -> bool {
    parts.iter().all(|part| {
        let components = &part.system.components;
        let meant = means_something(components, environment) || each_way_means_something(&part.period, environment);
        meant && time_passes_in(components, Some(&part.period), environment)
    })
}

/// The same, however few they are, and whether or not their values have a meaning and time passes in them.
pub(crate) fn separate(
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
    let groups: Vec<Vec<Term>> =
        groups.into_iter().map(|group| group.into_iter().map(|place| components[place].clone()).collect()).collect();
    let periods = period::analyse_each(&groups, definitions, assumptions, interrupted).ok()?;
    for (own, period) in groups.into_iter().zip(periods) {
        together = together.saturating_mul(period.phases.iter().map(|phase| phase.edges.len()).sum::<usize>().max(1));
        let goes_on = |edge: &period::Edge| matches!(edge.next, Next::Phase(_));
        if !period.ways().all(goes_on) {
            return None;
        }
        parts.push(Part { system: System { name: system.name.clone(), components: own }, period });
    }
    Some((parts, together))
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

/// What is said of parts before they are told one by one.
pub(crate) fn headline(parts: &[Part], ways: usize) -> String {
    let why = if ways == usize::MAX {
        "they have more ways from phase to phase than can be counted here".to_string()
    } else if ways > MOST_TOGETHER {
        format!("they have {ways} ways from phase to phase")
    } else {
        "they are not followed to the end".to_string()
    };
    format!("{} parts without a common port, told one by one: side by side {why}", parts.len())
}

/// What parts make together.
pub(crate) enum Together {
    /// All comes again so, as is said.
    Again(Course, String),
    /// Some phase of all of them comes again; not known is when.
    Returns,
    /// Why that is not so, or not known.
    Not(Failure),
    /// Whether that is so is not known.
    Unknown,
}

impl Together {
    /// Whether some phase comes again.
    pub(crate) fn answer(&self) -> &'static str {
        match self {
            Together::Again(..) | Together::Returns => "yes",
            Together::Not(failure) if !failure.is_open() => "no",
            Together::Not(_) | Together::Unknown => "unknown",
        }
    }

    /// What is said of it.
    pub(crate) fn line(&self) -> Option<String> {
        match self {
            Together::Again(_, line) => Some(line.clone()),
            Together::Returns => None,
            Together::Not(failure) => Some(failure.to_string()),
            Together::Unknown => Some("whether they come to a common phase again is not known".to_string()),
        }
    }
}

/// What parts make together.
pub(crate) fn in_all(parts: &[Part], environment: &Environment, interrupted: &dyn Fn() -> bool) -> Together {
    let course = |part: &Part| {
        let several = course_of(&part.period, &part.system, environment, interrupted).ok().flatten();
        several.or_else(|| steady(part, environment, interrupted))
    };
    together(parts, parts.iter().map(course).collect(), environment)
}

/// How a part goes on that has one way alone.
pub(super) fn steady(part: &Part, environment: &Environment, interrupted: &dyn Fn() -> bool) -> Option<Known> {
    let known = &environment.assumptions;
    let course = part.period.course(known, interrupted).map(|course| Known { course, moving: false });
    course.or_else(|| Some(Known { course: part.period.congruent(known, interrupted)?, moving: true }))
}

/// The same, of parts of which it is known, or not, where each comes to.
pub(super) fn together(parts: &[Part], courses: Vec<Option<Known>>, environment: &Environment) -> Together {
    let moving = courses.iter().flatten().any(|known| known.moving);
    let Some(courses) = courses.into_iter().map(|known| Some(known?.course)).collect::<Option<Vec<Course>>>() else {
        return if in_step(parts, environment) { Together::Returns } else { Together::Unknown };
    };
    let round = |(part, course): (&Part, &Course)| match course {
        Course::Repeats { lasting, .. } => Some((part.names(), lasting.clone())),
        Course::Ends(..) => None,
    };
    let Some(rounds) = parts.iter().zip(&courses).map(round).collect::<Option<Vec<_>>>() else {
        return Together::Unknown;
    };
    if let Some(drift) = drifting(&rounds, &environment.assumptions) {
        return Together::Not(drift);
    }
    match common(&rounds, &courses, environment) {
        Some(course) => {
            let line = whole(&course, moving);
            Together::Again(course, line)
        }
        None => Together::Returns,
    }
}

/// Whether all times in all parts are multiples of one: what is left of delays side by side is then one of finitely many.
fn in_step(parts: &[Part], environment: &Environment) -> bool {
    let mut times = Vec::new();
    for part in parts {
        for phase in &part.period.phases {
            for segment in phase.edges.iter().flat_map(|edge| &edge.segments) {
                if segment.duration.variables().iter().any(|name| environment.quantity(name).is_none()) {
                    return false;
                }
                times.push((String::new(), segment.duration.clone()));
            }
        }
    }
    drifting(&times, &environment.assumptions).is_none()
}

/// The least common multiple of the rounds, from where each part comes again so.
fn common(rounds: &[(String, Value)], courses: &[Course], environment: &Environment) -> Option<Course> {
    let mut rounds = rounds.iter();
    let mut lasting = rounds.next()?.1.clone();
    for (_, other) in rounds {
        let ratio = other.div(&lasting).ok()?.as_rational()?;
        lasting = lasting.mul(&Value::rational(BigRational::from_integer(ratio.numer().clone()))).ok()?;
    }
    let (mut latest, mut all) = (Value::zero(), BTreeSet::<Name>::new());
    for course in courses {
        let Course::Repeats { from, beside, .. } = course else { return None };
        if environment.assumptions.decide(Relation::Gtr, from, &latest)? {
            latest = from.clone();
        }
        all.extend(beside.iter().cloned());
    }
    Some(Course::Repeats { lasting, from: latest, beside: all })
}
