//! The property, segment by segment, and its match with a run: free durations are as short as they can be,
//! observed ones as long.

use std::collections::BTreeMap;

use num_traits::{Signed, ToPrimitive};

use super::lay::{Laid, Matcher, Missed};
use super::orbit::{Moving, Orbit, observers, only, standing};
use super::round::endless;
use super::trajectory::{Leg, Trajectory};
use super::unit::{Unit, shows, without_end};
use super::{Outcome, Verdict};
use crate::name::Name;
use crate::period::{End, Segment, Test};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// How long a segment of a property lasts.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Length {
    /// `?t`: to be found.
    Unknown(Name),
    /// So long.
    Known(Value),
    /// For ever.
    Endless,
}

/// A segment of a property.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Want {
    /// How long.
    pub length: Length,
    /// What must be shown all the while.
    pub shown: Vec<Term>,
    /// What must hold of the unknowns, said behind the segment.
    pub tests: Vec<Test>,
}

fn shown(terms: &[Term]) -> String {
    terms.iter().map(Term::to_string).collect::<Vec<_>>().join(" # ")
}

impl Want {
    /// The unknown duration of a segment that asks for nothing.
    pub(super) fn free(&self) -> Option<&Name> {
        match &self.length {
            Length::Unknown(name) if self.shown.is_empty() => Some(name),
            _ => None,
        }
    }
}

/// A property.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Wanted {
    /// Its segments in order.
    pub wants: Vec<Want>,
    /// Whether it starts again.
    pub again: bool,
}

impl Wanted {
    /// The segments of a property that calls itself by this name.
    ///
    /// # Errors
    /// What cannot be matched, in words.
    pub fn of(body: &Term, name: &Name) -> Result<Wanted, String> {
        if let Node::Loop(body) = body.node() {
            return Ok(Wanted { again: true, ..Wanted::of(body, name)? });
        }
        let mut wants: Vec<Want> = Vec::new();
        let mut again = false;
        let parts = match body.node() {
            Node::Seq(parts) => parts.to_vec(),
            _ => vec![body.clone()],
        };
        for part in &parts {
            if again || wants.last().is_some_and(|want| want.length == Length::Endless) {
                return Err(format!(
                    "a property has something after its end: what has no `Delay` lasts for ever, so `{part}` is never reached; \
                     with a duration to be found it is `(Delay_{{?s}} # {}) ; {part}`",
                    wants.last().map_or_else(|| "…".to_string(), |want| shown(&want.shown)),
                ));
            }
            match part.node() {
                Node::Call(called, _) if called == name => again = true,
                Node::Stop => {}
                Node::Guard(relation, left, right) => {
                    let Some(want) = wants.last_mut() else {
                        return Err("a condition in a property stands behind the segment that it is about".to_string());
                    };
                    want.tests.push(Test { relation: *relation, left: left.clone(), right: right.clone() });
                }
                _ => wants.push(want_of(part)?),
            }
        }
        if again && wants.is_empty() {
            return Err("the property has no segments".to_string());
        }
        Ok(Wanted { wants, again })
    }
}

fn want_of(part: &Term) -> Result<Want, String> {
    let parts = match part.node() {
        Node::Disable(parts) => parts.clone(),
        _ => vec![part.clone()],
    };
    let mut want = Want { length: Length::Endless, shown: Vec::new(), tests: Vec::new() };
    let observer = |part: &Term| matches!(part.node(), Node::Observe(..) | Node::Idle);
    for part in parts {
        match part.node() {
            Node::Par(all) if all.iter().all(observer) => {
                want.shown.extend(all.iter().filter(|part| !matches!(part.node(), Node::Idle)).cloned());
            }
            Node::Delay(time) if want.length == Length::Endless => {
                want.length = match time.as_variable().filter(|name| name.is_meta()) {
                    Some(name) => Length::Unknown(name.clone()),
                    None => Length::Known(time.clone()),
                };
            }
            Node::Observe(..) => want.shown.push(part.clone()),
            Node::Idle => {}
            _ => {
                return Err(
                    "a property consists of delays, each beside the observers it asks for, and of conditions, one after the other"
                        .to_string(),
                );
            }
        }
    }
    Ok(want)
}

/// The verdict on a run.
pub fn judge(wanted: &Wanted, trajectory: Trajectory) -> Outcome {
    let matcher = Matcher { wanted, assumptions: &trajectory.assumptions };
    let answer = if wanted.again { matcher.again(&trajectory) } else { matcher.once(&trajectory) };
    let asked = || wanted.wants.iter().flat_map(|want| &want.shown).flat_map(observers).collect();
    let turning = if wanted.again && answer.is_err() { trajectory.counted(&asked()) } else { None };
    let by_number = turning.and_then(|turning| {
        let found = Matcher { wanted, assumptions: &turning.assumptions }.again(&turning).ok()?;
        Some((Ok(found), turning))
    });
    let (answer, trajectory) = by_number.unwrap_or((answer, trajectory));
    let conditions: Vec<String> = trajectory
        .legs
        .iter()
        .flat_map(|leg| &leg.conditions)
        .map(|condition| format!("{condition} must hold"))
        .collect();
    let mut outcome = match answer {
        Ok(found) => {
            let verdict = if conditions.is_empty() { Verdict::Proved } else { Verdict::Open { remaining: conditions } };
            Outcome { verdict, ..found }
        }
        Err(Missed::Never(reason)) if conditions.is_empty() => {
            Outcome::new(Verdict::Refuted { reason, run: shown_run(&trajectory) })
        }
        Err(Missed::Never(reason) | Missed::Unsure(reason)) => {
            let said = |open: &&String| !reason.starts_with(open.as_str());
            let mut remaining: Vec<String> = trajectory.open.iter().filter(said).cloned().collect();
            remaining.insert(0, reason);
            remaining.extend(conditions);
            Outcome::new(Verdict::Open { remaining })
        }
    };
    outcome.endless = endless(&trajectory);
    outcome.period_term = trajectory.cycle.map(|cycle| {
        let round = term_of(&units_of(&trajectory.legs[cycle..]));
        trajectory.orbit.as_ref().map_or(round.clone(), |orbit| orbit.round(round))
    });
    outcome.orbit = trajectory.cycle.zip(trajectory.orbit);
    outcome.cut = !trajectory.open.is_empty();
    outcome.counts = trajectory.counts;
    outcome.opening = trajectory.opening;
    outcome.legs = trajectory.legs;
    outcome
}

pub(super) fn units_of(legs: &[Leg]) -> Vec<Unit> {
    legs.iter().flat_map(|leg| leg.units.iter().cloned()).collect()
}

fn term_of(units: &[Unit]) -> Term {
    Term::seq(units.iter().map(Unit::term))
}

/// The first moments of a run.
fn shown_run(trajectory: &Trajectory) -> Vec<(Value, Vec<Term>)> {
    let mut run = Vec::new();
    let mut time = Value::zero();
    let units = trajectory.opening.iter().chain(trajectory.certain().iter().flat_map(|leg| &leg.units));
    for unit in units {
        for number in 0..12 {
            let number = Value::integer(number);
            let within = match unit {
                Unit::Single(_) => number.is_zero(),
                Unit::Repeat { count: None, .. } => true,
                Unit::Repeat { count: Some(count), .. } => {
                    trajectory.assumptions.decide(Relation::Lss, &number, count) == Some(true)
                }
            };
            let Ok(round) = unit.round(&number) else { break };
            if !within || run.len() >= 12 {
                break;
            }
            for segment in round {
                run.push((time.clone(), segment.observed.clone()));
                time = time.add(&segment.duration).unwrap_or(time);
            }
        }
    }
    run
}

impl Matcher<'_> {
    /// A property that is asked once: what comes after it is free.
    fn once(&self, trajectory: &Trajectory) -> Result<Outcome, Missed> {
        let cycle = trajectory.cycle.map(|cycle| units_of(&trajectory.legs[cycle..])).unwrap_or_default();
        let laid = self.lay_once(trajectory, &cycle)?;
        let endless = self.wanted.wants.iter().any(|want| want.length == Length::Endless);
        let remark = self.any_longer(&laid, &cycle, trajectory);
        if !trajectory.open.is_empty() && trajectory.unending && !endless {
            return Ok(Outcome { remark, ..going_on(laid) });
        }
        let (rest, cycle) = match &trajectory.orbit {
            // What is shown from here on is of no interest any more, or what moves on from turn to turn is not.
            Some(_) if !endless => (vec![self.bare(&laid.rest)?], vec![self.bare(&cycle)?]),
            None if !endless => (laid.rest.iter().map(without_end).collect::<Result<_, _>>()?, cycle),
            Some(orbit) => (laid.rest.clone(), standing(&cycle, orbit)),
            // Beside what is asked for ever, what is shown for a while is of no interest.
            None if cycle.is_empty() => match &trajectory.end {
                Some(End::Silent { observed, .. }) => {
                    (only(&laid.rest, &|term| observed.contains(term) || self.asked_last(term)), cycle)
                }
                _ => (laid.rest.clone(), cycle),
            },
            None => (laid.rest.clone(), cycle),
        };
        if endless && let Some(shown) = self.shown_for_ever(&rest) {
            let run = Term::seq(laid.terms().into_iter().chain([Term::disable(shown)]));
            let property = Some(Term::seq(laid.property));
            let found = Outcome { remark, values: laid.values, ..Outcome::new(Verdict::Proved) };
            return Ok(Outcome { trajectory_term: Some(run), property_term: property, ..found });
        }
        let mut run: Vec<Term> = laid.terms();
        let mut property = laid.property.clone();
        run.extend(rest.iter().map(Unit::term));
        let stopped = matches!(trajectory.end, Some(End::Stopped));
        if !cycle.is_empty() {
            run.push(Term::new(Node::Loop(term_of(&cycle))));
        } else if let Some(End::Silent { observed, .. }) = &trajectory.end {
            run.push(Term::disable(observed.iter().cloned()));
        } else if matches!(trajectory.end, Some(End::Aborted)) {
            run.push(Term::abort());
        }
        if !endless && cycle.is_empty() && trajectory.end.as_ref().is_some_and(|end| !matches!(end, End::Silent { .. }))
        {
            let left = self.durations(&laid.rest)?;
            if !left.is_zero() {
                property.push(Term::delay(left));
            }
            if !stopped {
                property.push(Term::abort());
            }
        } else if !endless {
            property.push(Term::idle());
        }
        let mut outcome = Outcome::new(Verdict::Proved);
        outcome.remark = remark;
        outcome.values = laid.values;
        // A run that is not known to its end has no term.
        let forever = |unit: &Unit| matches!(unit, Unit::Repeat { count: None, .. });
        let changes = laid.run.iter().any(forever) || (endless && laid.rest.iter().any(forever));
        outcome.unwritten = match (&trajectory.open.first(), &trajectory.end) {
            (Some(open), _) => Some((*open).clone()),
            (None, Some(End::Livelock { .. })) => Some("it ends in a loop that takes no time".to_string()),
            _ => changes.then(|| CHANGES.to_string()),
        };
        if outcome.unwritten.is_none() {
            outcome.trajectory_term = Some(Term::seq(run));
            outcome.property_term = Some(Term::seq(property));
        }
        Ok(outcome)
    }

    /// Whether what is shown is asked for by the last segment of the property.
    fn asked_last(&self, shown: &Term) -> bool {
        let wanted = self.wanted.wants.last().into_iter().flat_map(|want| &want.shown);
        wanted.cloned().any(|one| shows(std::slice::from_ref(shown), &[one], self.assumptions) == Ok(true))
    }

    /// What is shown to the end as the last segment asks, where rounds that change follow one another for ever.
    fn shown_for_ever(&self, rest: &[Unit]) -> Option<Vec<Term>> {
        let Some(Unit::Repeat { count: None, index, .. }) = rest.last() else { return None };
        let kept = only(rest, &|term| self.asked_last(term));
        let shown = kept.iter().flat_map(segments_of).next()?.observed.clone();
        let steady = shown.iter().all(|term| term.values().all(|value| !value.mentions(index)));
        // Rounds that grow shorter and shorter may all be over before some time.
        let same = |segment: &Segment| segment.observed == shown && !segment.duration.mentions(index);
        (!shown.is_empty() && steady && kept.iter().flat_map(segments_of).all(same)).then_some(shown)
    }

    /// Stretches as one in which nothing is shown.
    fn bare(&self, units: &[Unit]) -> Result<Unit, Missed> {
        Ok(Unit::Single(Segment { duration: self.durations(units)?, observed: Vec::new() }))
    }

    fn lay_once(&self, trajectory: &Trajectory, cycle: &[Unit]) -> Result<Laid, Missed> {
        let mut units = trajectory.opening.clone();
        units.extend(units_of(trajectory.certain()));
        if let Some(still) = trajectory.still() {
            units.push(still.clone());
            let mut laid = self.lay(units, false, (cycle, trajectory))?;
            // What is left of it is said by the end of the run.
            while laid.rest.last() == Some(&still) {
                laid.rest.pop();
            }
            return Ok(laid);
        }
        let mut further = units.clone();
        further.extend(cycle.iter().cloned());
        if trajectory.orbit.is_none() {
            units.clone_from(&further);
        }
        let mut laid = self.lay(units.clone(), false, (cycle, trajectory));
        // What is asked for may last longer than the first rounds.
        if let (Err(Missed::Never(_)), None) = (&laid, &trajectory.orbit)
            && let Some(more) = self.rounds_missing(&units, cycle)
        {
            units.extend(std::iter::repeat_n(cycle, more).flatten().cloned());
            laid = self.lay(units, false, (cycle, trajectory));
        }
        match laid {
            Err(Missed::Never(reason)) if !trajectory.open.is_empty() => {
                Err(Missed::Unsure(trajectory.open.first().cloned().unwrap_or(reason)))
            }
            // Later turns are looked at as well, all at once.
            Err(Missed::Never(_)) if trajectory.orbit.is_some() => {
                match self.lay(further, false, (cycle, trajectory)) {
                    Ok(_) => Err(Missed::Unsure("in which turn it is shown".to_string())),
                    missed => missed,
                }
            }
            laid => laid,
        }
    }

    /// How many rounds more it takes until all has passed whose length the property tells, when what is to be found before
    /// takes as long as these; none where they are too many, or this is no number.
    fn rounds_missing(&self, units: &[Unit], cycle: &[Unit]) -> Option<usize> {
        let number = |units: &[Unit]| self.durations(units).ok()?.as_rational();
        let round = number(cycle).filter(Signed::is_positive)?;
        let so_far = number(units)?;
        let mut missing = -so_far.clone();
        for want in &self.wanted.wants {
            missing += match &want.length {
                Length::Known(length) => length.as_rational()?,
                Length::Unknown(_) => so_far.clone(),
                Length::Endless => round.clone(),
            };
        }
        let rounds = (missing / round).ceil().to_integer().to_usize()? + 1;
        (rounds.saturating_mul(cycle.len()) <= MOST_FURTHER).then_some(rounds)
    }
}

/// The most stretches beyond the first rounds along which a property is laid.
const MOST_FURTHER: usize = 512;

fn segments_of(unit: &Unit) -> &[Segment] {
    match unit {
        Unit::Single(segment) => std::slice::from_ref(segment),
        Unit::Repeat { segments, .. } => segments,
    }
}

/// Why a run has no term.
const CHANGES: &str = "what is shown changes in every round of a phase that goes on for ever";

/// A property that is met by what is known of a run that goes on for ever: nothing is said of the rest of it.
fn going_on(laid: Laid) -> Outcome {
    let mut outcome = Outcome::new(Verdict::Proved);
    let forever = |unit: &Unit| matches!(unit, Unit::Repeat { count: None, .. });
    if laid.run.iter().any(forever) {
        outcome.unwritten = Some(CHANGES.to_string());
    } else {
        let idle = || std::iter::once(Term::idle());
        outcome.trajectory_term = Some(Term::seq(laid.terms().into_iter().chain(idle())));
        outcome.property_term = Some(Term::seq(laid.property.iter().cloned().chain(idle())));
    }
    outcome.values = laid.values;
    outcome
}

pub(super) fn outcome_of(rounds: Vec<Laid>, steady: Vec<Laid>, orbit: Option<&Orbit>) -> Outcome {
    let mut outcome = Outcome::new(Verdict::Proved);
    let both = |laid: &[Laid]| {
        let run = Term::seq(laid.iter().flat_map(Laid::terms));
        let property = Term::seq(laid.iter().flat_map(|one| one.property.iter().cloned()));
        (run, property)
    };
    let (run, property) = both(&steady);
    let again =
        |round: Term| orbit.map_or_else(|| Term::new(Node::Loop(round.clone())), |orbit| orbit.round(round.clone()));
    let (mut run, mut property) = (again(run), again(property));
    if !rounds.is_empty() {
        let (first_run, first_property) = both(&rounds);
        run = Term::seq([first_run, run]);
        property = Term::seq([first_property, property]);
    }
    outcome.trajectory_term = Some(run);
    outcome.property_term = Some(property);
    outcome.values = rounds.first().or(steady.first()).map(|laid| laid.values.clone()).unwrap_or_default();
    // What is said of later rounds is true of each of them.
    let later = || rounds.iter().skip(1).chain(&steady);
    let in_all = |(name, value): &(&Name, &Value)| later().all(|laid| laid.values.get(*name) == Some(*value));
    let first = steady.first().map(|laid| laid.values.iter().filter(in_all)).into_iter().flatten();
    outcome.steady = first.map(|(name, value)| (name.clone(), value.clone())).collect();
    let turns = |name: &Name| steady.iter().map(|laid| laid.values.get(name).cloned()).collect::<Option<Vec<Value>>>();
    let others = outcome.values.keys().filter(|name| !outcome.steady.contains_key(name));
    let by_turns: BTreeMap<Name, Vec<Value>> = others.filter_map(|name| Some((name.clone(), turns(name)?))).collect();
    outcome.by_turns = (!by_turns.is_empty() && orbit.is_none()).then_some((rounds.len() + 1, by_turns));
    let numbered = orbit.into_iter().flat_map(|orbit| &orbit.moving).find(|one| one.between.is_none());
    let read = |one: &&Moving| outcome.steady.values().any(|value| value.mentions(&one.symbol));
    outcome.remark = numbered.filter(read).map(|Moving { symbol, start, next, .. }| {
        format!("in round {} {symbol} is {start}, and in each round after it {next}", rounds.len() + 1)
    });
    outcome
}
