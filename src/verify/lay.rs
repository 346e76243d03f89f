//! One round of a property laid along a run, segment by segment.

use std::collections::{BTreeMap, VecDeque};

use super::property::{Length, Want, Wanted};
use super::seek::{has_unknowns, length_with, with_values};
use super::trajectory::{Trajectory, at_rest};
use super::unit::{Hit, Unit, shows, total};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{End, Segment, Test, stretch};
use crate::term::Term;
use crate::value::{Relation, Value, ValueError};

/// Places at which a segment of known length is tried.
const MOST_TRIED: usize = 500;

/// A round of the property laid along the run.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    /// What was found.
    pub(super) values: BTreeMap<Name, Value>,
    /// The run, cut where the property cuts it.
    pub(super) run: Vec<Unit>,
    /// The property's segments with their durations; a segment that takes no time is left out.
    pub(super) property: Vec<Term>,
    /// What is left of the run.
    pub(super) rest: Vec<Unit>,
    /// Conditions that the run meets in every turn, each behind so many of its stretches.
    pub(super) guards: Vec<(usize, Term)>,
}

impl Laid {
    /// The run as processes.
    pub(super) fn terms(&self) -> Vec<Term> {
        let mut terms = Vec::new();
        for place in 0..=self.run.len() {
            terms.extend(self.guards.iter().filter(|(at, _)| *at == place).map(|(_, guard)| guard.clone()));
            terms.extend(self.run.get(place).map(Unit::term));
        }
        terms
    }
}

/// Why a property does not fit.
pub(super) enum Missed {
    /// The run does not show it.
    Never(String),
    /// It cannot be told.
    Unsure(String),
}

impl Missed {
    /// Why something is not known: a sentence, or `whether x > 0`.
    pub(super) fn unknown(reason: &str) -> Missed {
        let question =
            ["whether ", "if ", "how ", "which ", "where ", "when "].iter().any(|word| reason.starts_with(word));
        Missed::Unsure(if question { format!("it must be known {reason}") } else { reason.to_string() })
    }
}

impl From<ValueError> for Missed {
    fn from(error: ValueError) -> Missed {
        Missed::Unsure(error.0)
    }
}

/// Lays a property along a run.
pub(super) struct Matcher<'a> {
    pub(super) wanted: &'a Wanted,
    pub(super) assumptions: &'a Assumptions,
}

/// That nothing shows this for so long.
fn too_short(shown: &[Term], time: &Value) -> Missed {
    let shown: Vec<String> = shown.iter().map(Term::to_string).collect();
    Missed::Never(match shown.as_slice() {
        [] => format!("the run ends before {time} has passed"),
        shown => format!("{} is not shown for {time}", shown.join(" with ")),
    })
}

/// What is missed, where something else may be found.
fn unsure(missed: Missed) -> Missed {
    match missed {
        Missed::Never(reason) => {
            Missed::Unsure(format!("{reason}, and whether another value would be was not looked at"))
        }
        other => other,
    }
}

impl Matcher<'_> {
    pub(super) fn durations(&self, units: &[Unit]) -> Result<Value, Missed> {
        let mut sum = Value::zero();
        for unit in units {
            match unit.duration()? {
                Some(duration) => sum = sum.add(&duration)?,
                None => {
                    return Err(Missed::Unsure(
                        "what would have to pass before lasts for ever: a phase is never left".to_string(),
                    ));
                }
            }
        }
        Ok(self.assumptions.simplify(&sum))
    }

    /// One round of the property along these units. `whole`: the last free segment takes all that is left.
    pub(super) fn lay(
        &self,
        units: Vec<Unit>,
        whole: bool,
        (cycle, trajectory): (&[Unit], &Trajectory),
    ) -> Result<Laid, Missed> {
        let (run, property, guards) = (Vec::new(), Vec::new(), Vec::new());
        let mut laid = Laid { values: BTreeMap::new(), run, property, rest: units, guards };
        let wants = &self.wanted.wants;
        let mut free: Option<&Name> = None;
        let mut pending: Vec<Test> = Vec::new();
        for (place, want) in wants.iter().enumerate() {
            let last = place + 1 == wants.len();
            pending.extend(want.tests.iter().cloned());
            let mut want = want.clone();
            want.shown = with_values(&want.shown, &laid.values)?;
            want.length = length_with(&want.length, &laid.values)?;
            match &want.length {
                Length::Unknown(_) if want.shown.is_empty() && !last && free.is_none() => {
                    free = wants[place].free();
                    continue;
                }
                Length::Unknown(name) if want.shown.is_empty() => {
                    let rest = if last && whole { std::mem::take(&mut laid.rest) } else { Vec::new() };
                    self.take(&mut laid, Some(name), rest, &[])?;
                }
                Length::Unknown(name) => {
                    if has_unknowns(&want.shown) {
                        self.seek(&mut laid, free.take(), &want)?;
                        want.shown = with_values(&want.shown, &laid.values)?;
                    } else {
                        self.as_long(&mut laid, free.take(), (name, &want.shown), &mut pending, trajectory)?;
                        continue;
                    }
                    let taken = self.longest(&mut laid, &want.shown)?;
                    self.take(&mut laid, Some(name), taken, &want.shown)?;
                }
                Length::Known(time) if has_unknowns(&want.shown) => {
                    self.seek(&mut laid, free.take(), &want)?;
                    want.shown = with_values(&want.shown, &laid.values)?;
                    // Of what is shown first it is known how long; another may be shown for longer.
                    self.known(&mut laid, None, time, &want, trajectory).map_err(unsure)?;
                }
                Length::Endless if has_unknowns(&want.shown) => {
                    let shown: Vec<String> = want.shown.iter().map(Term::to_string).collect();
                    let why = "has no `Delay`, so it would be shown for ever, and then its values must be given";
                    return Err(Missed::Unsure(format!("{} {why}", shown.join(" with "))));
                }
                Length::Known(time) => self.known(&mut laid, free.take(), time, &want, trajectory)?,
                Length::Endless => self.endless(&mut laid, free.take(), &want, (cycle, trajectory))?,
            }
            self.settle(&mut laid, &mut pending, trajectory)?;
        }
        match pending.first() {
            Some(test) => Err(Missed::Unsure(format!("the condition {test} is about what is found nowhere"))),
            None => Ok(laid),
        }
    }

    /// Passes these units under one segment of the property.
    pub(super) fn take(
        &self,
        laid: &mut Laid,
        name: Option<&Name>,
        units: Vec<Unit>,
        shown: &[Term],
    ) -> Result<(), Missed> {
        let duration = self.durations(&units)?;
        if let Some(name) = name
            && let Some(other) = laid.values.insert(name.clone(), duration.clone())
            && self.assumptions.decide(Relation::Eq, &other, &duration) != Some(true)
        {
            return Err(Missed::Unsure(format!("{name} was found twice, as {other} and as {duration}")));
        }
        if !duration.is_zero() {
            laid.property.push(stretch(&duration, shown));
        }
        laid.run.extend(units);
        Ok(())
    }

    /// A segment of unknown length beside what is shown: the first stretch that shows it and of which the conditions
    /// hold that can be told then. Only behind a free segment may it be a later one.
    fn as_long(
        &self,
        laid: &mut Laid,
        free: Option<&Name>,
        (name, shown): (&Name, &[Term]),
        pending: &mut Vec<Test>,
        trajectory: &Trajectory,
    ) -> Result<(), Missed> {
        let mut rest = laid.rest.clone();
        let mut passed: Vec<Unit> = Vec::new();
        let mut first: Option<String> = None;
        for _ in 0..MOST_TRIED {
            let mut probe =
                Laid { rest, values: BTreeMap::new(), run: Vec::new(), property: Vec::new(), guards: Vec::new() };
            let found =
                self.skip_to(&mut probe, free, shown, trajectory).and_then(|()| self.longest(&mut probe, shown));
            let taken = match (found, first.take()) {
                (Ok(mut taken), earlier) => {
                    first = earlier;
                    taken.extend(self.resting((name, shown), &taken, &probe.rest, (pending, &laid.values))?);
                    taken
                }
                (Err(Missed::Never(_)), Some(reason)) => return Err(Missed::Never(reason)),
                (Err(missed), _) => return Err(missed),
            };
            passed.append(&mut probe.run);
            let (mut attempt, mut tests) = (laid.clone(), pending.clone());
            attempt.rest = probe.rest.clone();
            if let Some(free) = free {
                self.take(&mut attempt, Some(free), passed.clone(), &[])?;
            }
            self.take(&mut attempt, Some(name), taken.clone(), shown)?;
            match self.settle(&mut attempt, &mut tests, trajectory) {
                Ok(()) => {
                    (*laid, *pending) = (attempt, tests);
                    return Ok(());
                }
                Err(Missed::Never(reason)) if free.is_some() => {
                    first.get_or_insert(reason);
                    passed.extend(taken);
                    rest = probe.rest;
                }
                Err(missed) => return Err(missed),
            }
        }
        Err(Missed::Unsure("no stretch of those looked at lasts as long as is asked".to_string()))
    }

    /// Goes on to the first moment that shows this; a free segment takes what is passed over.
    fn skip_to(
        &self,
        laid: &mut Laid,
        free: Option<&Name>,
        shown: &[Term],
        trajectory: &Trajectory,
    ) -> Result<(), Missed> {
        let Some(free) = free else { return Ok(()) };
        let mut passed = Vec::new();
        let mut why = None;
        let rest = std::mem::take(&mut laid.rest);
        let mut rest = rest.into_iter();
        for unit in rest.by_ref() {
            match unit.find(shown, self.assumptions) {
                Hit::Unknown(reason) => return Err(Missed::unknown(&reason)),
                Hit::Miss(reason) => {
                    why = reason.or(why);
                    passed.push(unit);
                }
                Hit::Found(before, segment, after) => {
                    passed.extend(before);
                    laid.rest = std::iter::once(Unit::Single(segment)).chain(after).collect();
                    laid.rest.extend(rest);
                    return self.take(laid, Some(free), passed, &[]);
                }
            }
        }
        if let Some(End::Silent { observed, .. }) = &trajectory.end
            && shows(observed, shown, self.assumptions) == Ok(true)
        {
            return self.take(laid, Some(free), passed, &[]);
        }
        let found = |unit: &Unit| matches!(unit.find(shown, self.assumptions), Hit::Found(..));
        let earlier = trajectory.opening.iter().chain(trajectory.legs.iter().flat_map(|leg| &leg.units)).any(found);
        let again = if earlier { " again" } else { "" };
        let shown: Vec<String> = shown.iter().map(Term::to_string).collect();
        let why = why.map(|why| format!(": {why}")).unwrap_or_default();
        Err(Missed::Never(format!("{} is not shown{again}{why}", shown.join(" with "))))
    }

    /// The longest stretch from here that shows this.
    fn longest(&self, laid: &mut Laid, shown: &[Term]) -> Result<Vec<Unit>, Missed> {
        let mut taken = Vec::new();
        let mut rest: VecDeque<Unit> = std::mem::take(&mut laid.rest).into();
        while let Some(unit) = rest.pop_front() {
            let fits = |segment: &Segment| shows(&segment.observed, shown, self.assumptions);
            match &unit {
                Unit::Single(segment) => match fits(segment) {
                    Ok(true) => taken.push(unit),
                    Ok(false) => {
                        rest.push_front(unit);
                        break;
                    }
                    Err(reason) => return Err(Missed::unknown(&reason)),
                },
                Unit::Repeat { count, segments, .. } if segments.iter().all(|segment| fits(segment) == Ok(true)) => {
                    if count.is_some() {
                        taken.push(unit);
                        continue;
                    }
                    if at_rest(&unit).is_some() && !taken.is_empty() {
                        rest.push_front(unit);
                        break;
                    }
                    // Shown for ever: one round of it has a duration.
                    let (_, round, after) = unit.split(&Value::zero())?;
                    taken.extend(round.into_iter().map(Unit::Single));
                    after.into_iter().rev().for_each(|unit| rest.push_front(unit));
                    break;
                }
                Unit::Repeat { .. } => {
                    let first = unit.round(&Value::zero())?;
                    match first.first().map(fits) {
                        Some(Ok(true)) if taken.len() < 10_000 => {
                            let (_, round, after) = unit.split(&Value::zero())?;
                            after.into_iter().rev().for_each(|unit| rest.push_front(unit));
                            round.into_iter().rev().for_each(|segment| rest.push_front(Unit::Single(segment)));
                        }
                        Some(Err(reason)) => return Err(Missed::unknown(&reason)),
                        _ => {
                            rest.push_front(unit);
                            break;
                        }
                    }
                }
            }
        }
        laid.rest = rest.into();
        if taken.is_empty() {
            let shown: Vec<String> = shown.iter().map(Term::to_string).collect();
            return Err(Missed::Never(format!("{} is not shown when it should be", shown.join(" with "))));
        }
        Ok(taken)
    }

    /// A segment of known length, at the first moment from which it is shown so long.
    fn known(
        &self,
        laid: &mut Laid,
        free: Option<&Name>,
        time: &Value,
        want: &Want,
        trajectory: &Trajectory,
    ) -> Result<(), Missed> {
        let mut passed: Vec<Unit> = Vec::new();
        for _ in 0..MOST_TRIED {
            let mut probe = Laid { run: Vec::new(), property: Vec::new(), guards: Vec::new(), ..laid.clone() };
            if free.is_some() && !want.shown.is_empty() {
                match self.skip_to(&mut probe, free, &want.shown, trajectory) {
                    Err(Missed::Never(_)) if !passed.is_empty() => return Err(too_short(&want.shown, time)),
                    found => found?,
                }
                passed.append(&mut probe.run);
            }
            match self.exactly(&mut probe.rest, time, &want.shown)? {
                Some(taken) => {
                    if let Some(free) = free {
                        self.take(laid, Some(free), passed, &[])?;
                    }
                    laid.rest = probe.rest;
                    return self.take(laid, None, taken, &want.shown);
                }
                None if free.is_none() || probe.rest.is_empty() => return Err(too_short(&want.shown, time)),
                None => {
                    laid.rest = probe.rest;
                    passed.extend(if want.shown.is_empty() {
                        vec![laid.rest.remove(0)]
                    } else {
                        self.longest(laid, &want.shown)?
                    });
                }
            }
        }
        Err(Missed::Unsure(format!("what is asked for {time} was not found at the first {MOST_TRIED} places")))
    }

    /// Units of exactly this duration that show this, if the run starts so; else the run is left as it was.
    fn exactly(&self, rest: &mut Vec<Unit>, time: &Value, shown: &[Term]) -> Result<Option<Vec<Unit>>, Missed> {
        let unknown =
            |left: &Value, other: &Value| Missed::Unsure(format!("it must be known whether {other} <= {left}"));
        let mut queue: VecDeque<Unit> = rest.clone().into();
        let mut left = time.clone();
        let mut taken = Vec::new();
        for _ in 0..100_000 {
            if self.assumptions.decide(Relation::Eq, &left, &Value::zero()) == Some(true) {
                *rest = queue.into();
                return Ok(Some(taken));
            }
            let Some(mut unit) = queue.pop_front() else { return Ok(None) };
            if let Some(observed) = at_rest(&unit).map(<[Term]>::to_vec) {
                queue.push_front(std::mem::replace(
                    &mut unit,
                    Unit::Single(Segment { duration: left.clone(), observed }),
                ));
            }
            match unit {
                Unit::Single(segment) => {
                    if !shows(&segment.observed, shown, self.assumptions).map_err(Missed::Unsure)? {
                        return Ok(None);
                    }
                    match self.assumptions.decide(Relation::Lte, &segment.duration, &left) {
                        Some(true) => {
                            left = left.sub(&segment.duration)?;
                            taken.push(Unit::Single(segment));
                        }
                        Some(false) => {
                            let over = Segment { duration: segment.duration.sub(&left)?, ..segment.clone() };
                            queue.push_front(Unit::Single(over));
                            taken.push(Unit::Single(Segment { duration: left, ..segment }));
                            left = Value::zero();
                        }
                        None => return Err(unknown(&left, &segment.duration)),
                    }
                }
                Unit::Repeat { ref segments, .. } => {
                    let whole = unit.duration()?;
                    let plain = shown.is_empty()
                        || segments.iter().all(|s| shows(&s.observed, shown, self.assumptions) == Ok(true));
                    let fits = whole.as_ref().and_then(|whole| self.assumptions.decide(Relation::Lte, whole, &left));
                    match (plain, fits, &whole) {
                        (true, Some(true), Some(whole)) => {
                            left = left.sub(whole)?;
                            taken.push(unit);
                        }
                        (true, _, _) if left.div(&total(segments)?)?.as_rational().is_some_and(|n| n.is_integer()) => {
                            let number = left.div(&total(segments)?)?;
                            let (before, round, after) = unit.split(&number)?;
                            taken.extend(before);
                            after.into_iter().rev().for_each(|unit| queue.push_front(unit));
                            round.into_iter().rev().for_each(|segment| queue.push_front(Unit::Single(segment)));
                            left = Value::zero();
                        }
                        _ => {
                            let (_, round, after) = unit.split(&Value::zero())?;
                            after.into_iter().rev().for_each(|unit| queue.push_front(unit));
                            round.into_iter().rev().for_each(|segment| queue.push_front(Unit::Single(segment)));
                        }
                    }
                }
            }
        }
        Err(Missed::Unsure("a segment of the property spans too many rounds".to_string()))
    }

    /// A segment that must be shown for ever.
    fn endless(
        &self,
        laid: &mut Laid,
        free: Option<&Name>,
        want: &Want,
        (cycle, trajectory): (&[Unit], &Trajectory),
    ) -> Result<(), Missed> {
        let ever = |units: &[Unit]| {
            units.iter().all(|unit| match unit {
                Unit::Single(segment) => shows(&segment.observed, &want.shown, self.assumptions) == Ok(true),
                Unit::Repeat { segments, .. } => {
                    segments.iter().all(|segment| shows(&segment.observed, &want.shown, self.assumptions) == Ok(true))
                }
            })
        };
        let at_end = match &trajectory.end {
            Some(End::Silent { observed, .. }) => shows(observed, &want.shown, self.assumptions) == Ok(true),
            Some(_) => false,
            None => trajectory.open.is_empty(),
        };
        if !at_end || !ever(cycle) {
            let shown: Vec<String> = want.shown.iter().map(Term::to_string).collect();
            let end = match &trajectory.end {
                Some(End::Silent { blocked, .. }) if !blocked.is_empty() => {
                    "in the end nothing shows it any more: the run waits"
                }
                Some(End::Silent { .. }) => "in the end it is not shown",
                Some(_) => "the run ends",
                None => "the run moves on",
            };
            return Err(Missed::Never(format!("from no time on is {} shown for ever: {end}", shown.join(" with "))));
        }
        let mut start = laid.rest.len();
        while start > 0 && ever(&laid.rest[start - 1..]) {
            start -= 1;
        }
        let passed: Vec<Unit> = laid.rest.drain(..start).collect();
        match free {
            Some(free) => self.take(laid, Some(free), passed, &[])?,
            None if passed.is_empty() => {}
            None => return Err(Missed::Never("what is asked for ever is not shown at once".to_string())),
        }
        laid.property.push(Term::disable(want.shown.iter().cloned()));
        Ok(())
    }
}
