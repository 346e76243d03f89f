//! Observations with unknowns, `At_{?x}`, and conditions on what was found: the first moment at which an observer shows
//! a value of which the conditions hold.

use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::count::goal_of;
use super::lay::{Laid, Matcher, Missed};
use super::property::{Length, Want};
use super::trajectory::{Trajectory, at_rest};
use super::unit::{Unit, same_observer, shows};
use crate::name::Name;
use crate::period::{End, Segment, Test};
use crate::recurrence::{Closed, Piece, Reach, first};
use crate::term::{Node, Term};
use crate::value::{Relation, Value, ValueError};

/// Rounds that are looked at one by one.
const MOST_ROUNDS: usize = 2_000;
/// Rounds of those without end that are looked at one by one.
const FEW_ROUNDS: usize = 200;

type Values = BTreeMap<Name, Value>;

/// The place of a moment in a stretch: the number of the round, the segment in it, and what was found there.
enum Moment {
    At(Value, usize, Values),
    Never(Option<String>),
    Unknown(String),
}

/// Terms with what is known of the unknowns put in.
pub(super) fn with_values(terms: &[Term], values: &Values) -> Result<Vec<Term>, ValueError> {
    terms.iter().map(|term| term.map_values(&mut |value| value.substitute(values))).collect()
}

/// A length with what is known of the unknowns put in.
pub(super) fn length_with(length: &Length, values: &Values) -> Result<Length, ValueError> {
    Ok(match length {
        Length::Unknown(name) => values.get(name).map_or(length.clone(), |value| Length::Known(value.clone())),
        Length::Known(time) => Length::Known(time.substitute(values)?),
        Length::Endless => Length::Endless,
    })
}

/// Whether terms have unknowns left.
pub(super) fn has_unknowns(terms: &[Term]) -> bool {
    terms.iter().flat_map(Term::values).any(|value| value.variables().iter().any(Name::is_meta))
}

impl Matcher<'_> {
    /// Goes on to the first moment that shows what is wanted with values of which the conditions hold; a free segment
    /// takes what is passed over.
    pub(super) fn seek(&self, laid: &mut Laid, free: Option<&Name>, want: &Want) -> Result<(), Missed> {
        let mut passed = Vec::new();
        let mut why = None;
        let rest = std::mem::take(&mut laid.rest);
        let mut rest = rest.into_iter();
        for unit in rest.by_ref() {
            match self.moment(&unit, want, &laid.values) {
                Moment::Unknown(reason) => return Err(Missed::unknown(&reason)),
                Moment::Never(reason) => {
                    if free.is_none() {
                        break;
                    }
                    why = reason.or(why);
                    passed.push(unit);
                }
                Moment::At(number, place, found) => {
                    let (before, round, after) = unit.split(&number)?;
                    passed.extend(before);
                    passed.extend(round.iter().take(place).cloned().map(Unit::Single));
                    laid.rest = round.into_iter().skip(place).map(Unit::Single).chain(after).chain(rest).collect();
                    laid.values.extend(found);
                    return match free {
                        Some(free) => self.take(laid, Some(free), passed, &[]),
                        None if passed.is_empty() => Ok(()),
                        None => Err(self.not_shown(want, None)),
                    };
                }
            }
        }
        Err(self.not_shown(want, why))
    }

    fn not_shown(&self, want: &Want, why: Option<String>) -> Missed {
        let shown: Vec<String> = want.shown.iter().map(Term::to_string).collect();
        let tests: Vec<String> = want.tests.iter().map(Test::to_string).collect();
        let such = if tests.is_empty() { String::new() } else { format!(" with {}", tests.join(" and ")) };
        let why = why.map(|why| format!(": {why}")).unwrap_or_default();
        Missed::Never(format!("{}{such} is not shown{why}", shown.join(" with ")))
    }

    fn moment(&self, unit: &Unit, want: &Want, known: &Values) -> Moment {
        let Unit::Repeat { count, index, segments } = unit else {
            let Unit::Single(segment) = unit else { return Moment::Never(None) };
            return match self.binding(&segment.observed, want, known) {
                Ok(Some(found)) => Moment::At(Value::zero(), 0, found),
                Ok(None) => Moment::Never(None),
                Err(question) => Moment::Unknown(question),
            };
        };
        let number = count.as_ref().and_then(Value::as_rational).and_then(|count| count.to_integer().to_usize());
        match number.filter(|number| *number <= MOST_ROUNDS) {
            Some(number) => self.one_by_one(unit, number, want, known),
            None => match self.by_form(count.as_ref(), index, segments, (want, known)) {
                Moment::Unknown(reason) if count.is_none() => match self.one_by_one(unit, FEW_ROUNDS, want, known) {
                    Moment::Never(_) => Moment::Unknown(reason),
                    found => found,
                },
                found => found,
            },
        }
    }

    fn one_by_one(&self, unit: &Unit, count: usize, want: &Want, known: &Values) -> Moment {
        for number in (0..count).map(|number| Value::integer(number as i64)) {
            let round = match unit.round(&number) {
                Ok(round) => round,
                Err(error) => return Moment::Unknown(error.0),
            };
            for (place, segment) in round.iter().enumerate() {
                match self.binding(&segment.observed, want, known) {
                    Ok(Some(found)) => return Moment::At(number, place, found),
                    Ok(None) => {}
                    Err(question) => return Moment::Unknown(question),
                }
            }
        }
        Moment::Never(None)
    }

    /// Without a number of rounds: one observer with one unknown in one condition, whose sequence is asked.
    fn by_form(
        &self,
        count: Option<&Value>,
        index: &Name,
        segments: &[Segment],
        (want, known): (&Want, &Values),
    ) -> Moment {
        let unsure = || Moment::Unknown("which of many rounds is the first with what is asked".to_string());
        let ([wanted], [segment]) = (want.shown.as_slice(), segments) else { return unsure() };
        let shown: Vec<&Term> = segment.observed.iter().filter(|shown| same_observer(shown, wanted)).collect();
        let unknown = wanted.values().next().and_then(|value| value.as_variable()).filter(|name| name.is_meta());
        let ([shown], Some(unknown), 1) = (shown.as_slice(), unknown, wanted.values().len()) else {
            return if shown.is_empty() { Moment::Never(None) } else { unsure() };
        };
        let Some(form) = shown.values().next().cloned() else { return unsure() };
        let found = |number: Value| match form.with(index, &number) {
            Ok(value) => Moment::At(number, 0, Values::from([(unknown.clone(), value)])),
            Err(error) => Moment::Unknown(error.0),
        };
        let tests: Vec<&Test> = want.tests.iter().filter(|test| mentions(test, unknown)).collect();
        let test = match tests.as_slice() {
            [] => return found(Value::zero()),
            [test] => test.substitute(known),
            _ => return unsure(),
        };
        let Some(goal) = test.ok().and_then(|test| goal_of(&test, unknown)) else { return unsure() };
        let pieces = vec![Piece { from: Value::zero(), until: None, form: form.clone() }];
        let closed = Closed { variable: unknown.clone(), pieces, conditions: Vec::new() };
        match first(&closed, index, &goal, self.assumptions) {
            Reach::Never(reason) => Moment::Never(Some(reason)),
            Reach::At(number, conditions) if conditions.is_empty() => {
                match count.map(|count| self.assumptions.decide(Relation::Lss, &number, count)) {
                    None | Some(Some(true)) => found(number),
                    Some(Some(false)) => Moment::Never(None),
                    Some(None) => Moment::Unknown(format!("whether round {number} is among the rounds")),
                }
            }
            Reach::At(..) => unsure(),
            Reach::Unknown(unknown) => Moment::Unknown(unknown.reason),
        }
    }

    /// Values of the unknowns for which all that is wanted is shown and the conditions on them hold.
    fn binding(&self, observed: &[Term], want: &Want, known: &Values) -> Result<Option<Values>, String> {
        let mut ways = vec![Values::new()];
        let mut question = None;
        for wanted in &want.shown {
            let mut longer = Vec::new();
            for way in &ways {
                for shown in observed.iter().filter(|shown| same_observer(shown, wanted)) {
                    match self.matched(shown, wanted, way) {
                        Ok(found) => longer.extend(found),
                        Err(open) => question = Some(open),
                    }
                }
            }
            ways = longer;
        }
        'ways: for way in ways {
            let mut all = known.clone();
            all.extend(way.clone());
            for test in &want.tests {
                let test = test.substitute(&all).map_err(|error| error.0)?;
                if test.left.variables().iter().chain(&test.right.variables()).any(Name::is_meta) {
                    continue;
                }
                match test.decide(self.assumptions) {
                    Some(true) => {}
                    Some(false) => continue 'ways,
                    None => return Err(format!("whether {test}")),
                }
            }
            return Ok(Some(way));
        }
        question.map_or(Ok(None), Err)
    }

    fn matched(&self, shown: &Term, wanted: &Term, way: &Values) -> Result<Option<Values>, String> {
        let mut way = way.clone();
        for (value, asked) in shown.values().zip(wanted.values()) {
            if let Some(name) = asked.as_variable().filter(|name| name.is_meta() && !way.contains_key(*name)) {
                way.insert(name.clone(), value.clone());
                continue;
            }
            let asked = asked.substitute(&way).map_err(|error| error.0)?;
            match self.assumptions.decide(Relation::Eq, value, &asked) {
                Some(true) => {}
                Some(false) => return Ok(None),
                None => return Err(format!("whether {value} = {asked}")),
            }
        }
        Ok(Some(way))
    }

    /// That what the last segment asks for is shown for longer than the time that was found, for ever or as far as is known.
    pub(super) fn any_longer(&self, laid: &Laid, cycle: &[Unit], trajectory: &Trajectory) -> Option<String> {
        let want = self.wanted.wants.last().filter(|want| !want.shown.is_empty() && laid.rest.is_empty())?;
        let Length::Unknown(name) = &want.length else { return None };
        if !trajectory.open.is_empty() {
            return Some(format!("{name} is as long as the run was followed; it may be shown for longer"));
        }
        let wanted = with_values(&want.shown, &laid.values).ok()?;
        let fits = |observed: &[Term]| shows(observed, &wanted, self.assumptions) == Ok(true);
        let goes_on = match &trajectory.end {
            Some(End::Silent { observed, .. }) => fits(observed),
            Some(_) => false,
            None => {
                !cycle.is_empty()
                    && cycle.iter().all(|unit| match unit {
                        Unit::Single(segment) => fits(&segment.observed),
                        Unit::Repeat { segments, .. } => segments.iter().all(|segment| fits(&segment.observed)),
                    })
            }
        };
        goes_on.then(|| format!("it is shown for ever: {name} could be any longer"))
    }

    /// Where what is asked is shown for ever from here, how much longer it has to be shown for the conditions on its
    /// duration.
    pub(super) fn resting(
        &self,
        (name, shown): (&Name, &[Term]),
        taken: &[Unit],
        rest: &[Unit],
        (tests, known): (&[Test], &Values),
    ) -> Result<Option<Unit>, Missed> {
        let Some(observed) = rest.first().and_then(at_rest) else { return Ok(None) };
        if shows(observed, shown, self.assumptions) != Ok(true) {
            return Ok(None);
        }
        let own = Value::variable(name);
        let so_far = self.durations(taken)?;
        let mut longest: Option<Value> = None;
        for test in tests {
            let (relation, bound) = match (test.left == own, test.right == own) {
                (true, false) => (test.relation, test.right.substitute(known)?),
                (false, true) => (test.relation.mirrored(), test.left.substitute(known)?),
                _ => continue,
            };
            let wanted = match relation {
                Relation::Gte | Relation::Eq => bound,
                Relation::Gtr => bound.add(&Value::one())?,
                _ => continue,
            };
            if self.assumptions.decide(Relation::Gtr, &wanted, longest.as_ref().unwrap_or(&so_far)) == Some(true) {
                longest = Some(wanted);
            }
        }
        let more = longest.map(|longest| longest.sub(&so_far)).transpose()?;
        Ok(more.map(|duration| Unit::Single(Segment { duration, observed: observed.to_vec() })))
    }

    /// Decides the conditions whose unknowns have been found, and writes them down.
    pub(super) fn settle(
        &self,
        laid: &mut Laid,
        pending: &mut Vec<Test>,
        trajectory: &Trajectory,
    ) -> Result<(), Missed> {
        for test in std::mem::take(pending) {
            let said = test.substitute(&laid.values)?;
            if said.left.variables().iter().chain(&said.right.variables()).any(Name::is_meta) {
                pending.push(test);
                continue;
            }
            match said.decide(self.assumptions) {
                Some(true) => {}
                Some(false) => return Err(Missed::Never(format!("{test} does not hold: {said}"))),
                None => return Err(Missed::Unsure(format!("it must be known whether {said}"))),
            }
            let guard = Term::new(Node::Guard(said.relation, said.left.clone(), said.right.clone()));
            if trajectory.orbit.as_ref().is_some_and(|orbit| orbit.moves(&said.left) || orbit.moves(&said.right)) {
                laid.guards.push((laid.run.len(), guard.clone()));
            }
            laid.property.push(guard);
        }
        Ok(())
    }
}

fn mentions(test: &Test, name: &Name) -> bool {
    test.left.mentions(name) || test.right.mentions(name)
}
