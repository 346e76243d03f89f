//! Stretches of a run: one segment, or rounds that are counted.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::count::{Measure, distance, one_difference};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::{Segment, stretch};
use crate::recurrence::{Closed, Goal, Piece, Reach, first};
use crate::substitution::substitute_values;
use crate::term::{Node, Term};
use crate::value::{Relation, Sort, Value, ValueError};

/// Rounds that are looked at one by one.
const MOST_ROUNDS: i64 = 2_000;
/// The same where two observations are to meet.
const MOST_TOGETHER: i64 = 3_000;

/// A stretch of a run.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Unit {
    /// Nothing changes.
    Single(Segment),
    /// Rounds `index = 0, 1, …, count - 1`; without a count, for ever.
    Repeat {
        /// How many rounds.
        count: Option<Value>,
        /// Their number.
        index: Name,
        /// What passes in each.
        segments: Vec<Segment>,
    },
}

/// Where an observation is shown first.
pub enum Hit {
    /// Not in this stretch; the reason matters when the stretch is endless.
    Miss(Option<String>),
    /// After these units, then in this segment, then the rest.
    Found(Vec<Unit>, Segment, Vec<Unit>),
    /// It cannot be told.
    Unknown(String),
}

/// The rounds before a round, that round, and the rounds after it.
pub type Cut = (Vec<Unit>, Vec<Segment>, Vec<Unit>);

impl Unit {
    /// Its duration; nothing if it is endless.
    ///
    /// # Errors
    /// When the product has no normal form or rounds differ in length.
    pub fn duration(&self) -> Result<Option<Value>, ValueError> {
        match self {
            Unit::Single(segment) => Ok(Some(segment.duration.clone())),
            Unit::Repeat { count, index, segments } => {
                let round = total(segments)?;
                if round.mentions(index) {
                    return Err(ValueError("the rounds differ in length".to_string()));
                }
                count.as_ref().map(|count| count.mul(&round)).transpose()
            }
        }
    }

    /// It as a process.
    pub fn term(&self) -> Term {
        match self {
            Unit::Single(segment) => stretch(&segment.duration, &segment.observed),
            Unit::Repeat { count, index, segments } => {
                let round = Term::seq(segments.iter().map(|segment| stretch(&segment.duration, &segment.observed)));
                let mentioned = segments.iter().any(|segment| {
                    segment.duration.mentions(index)
                        || segment.observed.iter().any(|term| term.values().any(|value| value.mentions(index)))
                });
                match count {
                    Some(count) => Term::new(Node::Power(round, count.clone(), mentioned.then(|| index.clone()))),
                    None => Term::new(Node::Loop(round)),
                }
            }
        }
    }

    /// The segments of one round.
    ///
    /// # Errors
    /// When a value has no normal form.
    pub fn round(&self, number: &Value) -> Result<Vec<Segment>, ValueError> {
        match self {
            Unit::Single(segment) => Ok(vec![segment.clone()]),
            Unit::Repeat { index, segments, .. } => {
                let map = BTreeMap::from([(index.clone(), number.clone())]);
                segments.iter().map(|segment| at(segment, &map)).collect()
            }
        }
    }

    /// The rounds before a number, that round, and the rounds after it.
    ///
    /// # Errors
    /// When a value has no normal form.
    pub fn split(&self, number: &Value) -> Result<Cut, ValueError> {
        let Unit::Repeat { count, index, segments } = self else {
            return Ok((Vec::new(), self.round(number)?, Vec::new()));
        };
        let next = number.add(&Value::one())?;
        let shifted = BTreeMap::from([(index.clone(), Value::variable(index).add(&next)?)]);
        let later: Vec<Segment> = segments.iter().map(|segment| at(segment, &shifted)).collect::<Result<_, _>>()?;
        let left = count.as_ref().map(|count| count.sub(&next)).transpose()?;
        let before = repeat(Some(number.clone()), index, segments.clone())?;
        Ok((before, self.round(number)?, repeat(left, index, later)?))
    }

    /// The first segment in which all of these are shown.
    pub fn find(&self, wanted: &[Term], assumptions: &Assumptions) -> Hit {
        match self {
            Unit::Single(segment) => match shows(&segment.observed, wanted, assumptions) {
                Ok(true) => Hit::Found(Vec::new(), segment.clone(), Vec::new()),
                Ok(false) => Hit::Miss(None),
                Err(question) => Hit::Unknown(question),
            },
            Unit::Repeat { count, index, segments } => {
                match first_round(count.as_ref(), index, segments, wanted, assumptions) {
                    Round::Never(reason) => Hit::Miss(reason),
                    Round::Unknown(reason) => Hit::Unknown(reason),
                    Round::At(number, place) => match self.split(&number) {
                        Err(error) => Hit::Unknown(error.0),
                        Ok((mut before, round, after)) => {
                            let mut after_this: Vec<Unit> =
                                round.iter().skip(place + 1).cloned().map(Unit::Single).collect();
                            after_this.extend(after);
                            before.extend(round.iter().take(place).cloned().map(Unit::Single));
                            match round.get(place) {
                                Some(segment) => Hit::Found(before, segment.clone(), after_this),
                                None => Hit::Miss(None),
                            }
                        }
                    },
                }
            }
        }
    }
}

/// Rounds of a count: none for 0, plain segments for 1.
///
/// # Errors
/// When a value has no normal form.
pub fn repeat(count: Option<Value>, index: &Name, segments: Vec<Segment>) -> Result<Vec<Unit>, ValueError> {
    let unit = Unit::Repeat { count: count.clone(), index: index.clone(), segments };
    match count {
        Some(count) if count.is_zero() => Ok(Vec::new()),
        Some(count) if count == Value::one() => Ok(unit.round(&Value::zero())?.into_iter().map(Unit::Single).collect()),
        _ => Ok(vec![unit]),
    }
}

/// The duration of segments.
///
/// # Errors
/// When the sum has no normal form.
pub fn total(segments: &[Segment]) -> Result<Value, ValueError> {
    segments.iter().try_fold(Value::zero(), |sum, segment| sum.add(&segment.duration))
}

/// A stretch; of one without end, what lasts as long and shows nothing.
///
/// # Errors
/// When the sum has no normal form.
pub(super) fn without_end(unit: &Unit) -> Result<Unit, ValueError> {
    let Unit::Repeat { count: None, index, segments } = unit else { return Ok(unit.clone()) };
    let segments = vec![Segment { duration: total(segments)?, observed: Vec::new() }];
    Ok(Unit::Repeat { count: None, index: index.clone(), segments })
}

fn at(segment: &Segment, map: &BTreeMap<Name, Value>) -> Result<Segment, ValueError> {
    let observed: Result<Vec<Term>, _> = segment.observed.iter().map(|term| substitute_values(term, map)).collect();
    Ok(Segment {
        duration: segment.duration.substitute(map)?,
        observed: observed.map_err(|stuck| ValueError(stuck.0))?,
    })
}

enum Round {
    At(Value, usize),
    Never(Option<String>),
    Unknown(String),
}

/// The first round, and place in it, that shows what is wanted.
fn first_round(
    count: Option<&Value>,
    index: &Name,
    segments: &[Segment],
    wanted: &[Term],
    assumptions: &Assumptions,
) -> Round {
    let mut best: Option<(Value, usize)> = None;
    let mut why = None;
    for (place, segment) in segments.iter().enumerate() {
        match first_in(count, index, segment, wanted, assumptions) {
            Round::Unknown(reason) => return Round::Unknown(reason),
            Round::Never(reason) => why = why.or(reason),
            Round::At(number, _) => {
                let sooner = match &best {
                    None => Some(true),
                    Some((other, _)) => assumptions.decide(Relation::Lss, &number, other),
                };
                match sooner {
                    Some(true) => best = Some((number, place)),
                    Some(false) => {}
                    None => return Round::Unknown("which of two moments comes first".to_string()),
                }
            }
        }
    }
    best.map_or(Round::Never(why), |(number, place)| Round::At(number, place))
}

/// The first round in which one segment shows what is wanted: the observations must meet in the same round.
fn first_in(
    count: Option<&Value>,
    index: &Name,
    segment: &Segment,
    wanted: &[Term],
    assumptions: &Assumptions,
) -> Round {
    let mut firsts: Vec<Value> = Vec::new();
    for one in wanted {
        let mut reached = None;
        let mut why = None;
        for shown in segment.observed.iter().filter(|shown| same_observer(shown, one)) {
            match first_equal((count, index), shown, one, assumptions) {
                Round::At(at, _) => reached = Some(at),
                Round::Never(reason) => why = reason,
                Round::Unknown(reason) => return Round::Unknown(reason),
            }
        }
        let Some(reached) = reached else { return Round::Never(why) };
        // What is shown in every round does not choose one.
        let changes = |shown: &Term| shown.values().any(|value| value.mentions(index));
        let chooses = segment.observed.iter().any(|shown| same_observer(shown, one) && changes(shown));
        if chooses && !firsts.contains(&reached) {
            firsts.push(reached);
        }
    }
    let number = match firsts.as_slice() {
        [] => Value::zero(),
        [only] => only.clone(),
        several => match first_together((count, index), segment, wanted, several, assumptions) {
            Round::At(number, _) => number,
            other => return other,
        },
    };
    match count.map(|count| assumptions.decide(Relation::Lss, &number, count)) {
        None | Some(Some(true)) => Round::At(number, 0),
        Some(Some(false)) => Round::Never(None),
        Some(None) => Round::Unknown(format!("whether round {number} is among the rounds")),
    }
}

pub(super) fn same_observer(shown: &Term, wanted: &Term) -> bool {
    matches!((shown.node(), wanted.node()), (Node::Observe(a, x), Node::Observe(b, y)) if a == b && x.len() == y.len())
}

/// The first round in which observations meet that are first shown in these: not before the last of them, and looked for
/// round by round from there on.
fn first_together(
    (count, index): (Option<&Value>, &Name),
    segment: &Segment,
    wanted: &[Term],
    firsts: &[Value],
    assumptions: &Assumptions,
) -> Round {
    let unknown = || Round::Unknown("whether two observations are shown together".to_string());
    let numbers: Option<Vec<BigRational>> = firsts.iter().map(Value::as_rational).collect();
    let last = numbers.and_then(|numbers| numbers.into_iter().max()).and_then(|last| last.to_integer().to_i64());
    let Some(last) = last else { return unknown() };
    let rounds = count.map(|count| count.as_rational().and_then(|count| count.to_integer().to_i64()));
    let until = rounds.flatten().unwrap_or(i64::MAX).min(last.saturating_add(MOST_TOGETHER));
    for at in (last..until).map(Value::integer) {
        let mut all = Some(true);
        for one in wanted {
            let here = segment.observed.iter().filter(|shown| same_observer(shown, one));
            let shown = here.map(|shown| shows_at(shown, one, (index, &at), assumptions));
            let any = shown.reduce(|all, one| if all == Some(true) || one == Some(false) { all } else { one });
            match any.flatten() {
                Some(true) => {}
                Some(false) => {
                    all = Some(false);
                    break;
                }
                None => all = None,
            }
        }
        match all {
            Some(true) => return Round::At(at, 0),
            Some(false) => {}
            None => return unknown(),
        }
    }
    if rounds.flatten() == Some(until) { Round::Never(None) } else { unknown() }
}

/// Whether an observation has the wanted values in a round.
fn shows_at(shown: &Term, wanted: &Term, (index, at): (&Name, &Value), assumptions: &Assumptions) -> Option<bool> {
    let mut all = Some(true);
    for (form, value) in shown.values().zip(wanted.values()) {
        match assumptions.decide(Relation::Eq, &form.with(index, at).ok()?, value) {
            Some(true) => {}
            Some(false) => return Some(false),
            None => all = None,
        }
    }
    all
}

/// The first round in which one observation has the wanted values. Values that count must agree with those that do not.
fn first_equal(
    (count, index): (Option<&Value>, &Name),
    shown: &Term,
    wanted: &Term,
    assumptions: &Assumptions,
) -> Round {
    let mut number: Option<Value> = None;
    for (form, value) in shown.values().zip(wanted.values()) {
        if !form.mentions(index) {
            match assumptions.decide(Relation::Eq, form, value) {
                Some(true) => continue,
                Some(false) => return Round::Never(None),
                None => return Round::Unknown(format!("whether {form} = {value}")),
            }
        }
        if let Some(round) = first_linear(index, form, value) {
            match round {
                Some(at) if number.as_ref().is_none_or(|other| *other == at) => number = Some(at),
                _ => return Round::Never(None),
            }
            continue;
        }
        match first_of_form(form, value, (count, index), assumptions) {
            Reach::At(at, conditions) if conditions.is_empty() => match &number {
                None => number = Some(at),
                Some(other) if *other == at => {}
                Some(_) => return Round::Unknown(format!("whether {shown} is ever {wanted}")),
            },
            Reach::At(at, conditions) => {
                let conditions: Vec<String> =
                    conditions.iter().map(|(relation, a, b)| format!("{a} {} {b}", relation.symbol())).collect();
                return Round::Unknown(format!("{form} = {value} at {index} = {at} if {}", conditions.join(" and ")));
            }
            Reach::Never(reason) => return Round::Never(Some(format!("{form} is {value} for no {index}: {reason}"))),
            // What is so in no round may be assumed of the round by its number.
            Reach::Unknown(_) if assumptions.decide(Relation::Eq, form, value) == Some(false) => {
                return Round::Never(None);
            }
            Reach::Unknown(unknown) => return Round::Unknown(unknown.reason),
        }
    }
    Round::At(number.unwrap_or_else(Value::zero), 0)
}

/// The first round in which a form has a value: by its shape, or else round by round.
fn first_of_form(
    form: &Value,
    value: &Value,
    (count, index): (Option<&Value>, &Name),
    assumptions: &Assumptions,
) -> Reach {
    let found = first_of_difference(form, value, (count, index), (assumptions, &one_difference));
    let found = match found {
        Reach::Unknown(_) if matches!(form.sort(), Sort::Vector(_)) => {
            match first_of_difference(form, value, (count, index), (assumptions, &distance)) {
                Reach::Unknown(_) => found,
                by_distance => by_distance,
            }
        }
        found => found,
    };
    let number = count.and_then(Value::as_rational).and_then(|count| count.to_integer().to_i64());
    let (Reach::Unknown(_), Some(number)) = (&found, number.filter(|number| *number <= MOST_ROUNDS)) else {
        return found;
    };
    for number in (0..number).map(Value::integer) {
        let equal = form.with(index, &number).ok().and_then(|here| assumptions.decide(Relation::Eq, &here, value));
        match equal {
            Some(true) => return Reach::At(number, Vec::new()),
            Some(false) => {}
            None => return found,
        }
    }
    Reach::Never("in no round".to_string())
}

/// The first round in which a form has a value, of two places by one number that tells how they differ.
fn first_of_difference(
    form: &Value,
    value: &Value,
    (count, index): (Option<&Value>, &Name),
    (assumptions, measure): (&Assumptions, Measure),
) -> Reach {
    let one = form.sub(value).ok().and_then(|difference| measure(&difference, index, assumptions));
    let Some(difference) = one else { return Reach::unknown(format!("whether ever {form} = {value}")) };
    let variable = Name::new("[difference]");
    // Of a number the form itself is asked, so that a reason speaks of it and not of a difference.
    let number = !matches!(form.sort(), Sort::Vector(_));
    let (form_asked, goal) = if number { (form.clone(), value.clone()) } else { (difference, Value::zero()) };
    let pieces = vec![Piece { from: Value::zero(), until: count.cloned(), form: form_asked }];
    let closed = Closed { variable, pieces, conditions: Vec::new() };
    match first(&closed, index, &Goal::Equals(goal), assumptions) {
        Reach::Never(reason) if !number => Reach::Never(format!("of what lies between them, {reason}")),
        found => found,
    }
}

/// Where a value that grows by a fixed number is equal to another: nowhere, or at a number; nothing if that is not clear.
fn first_linear(index: &Name, form: &Value, value: &Value) -> Option<Option<Value>> {
    let (step, start) = form.linear_in(index)?;
    let at = value.sub(&start).and_then(|gap| gap.div(&step)).ok()?;
    let number = at.as_rational()?;
    let natural = number.is_integer() && number >= num_rational::BigRational::from_integer(0.into());
    Some(natural.then_some(at))
}

/// Whether all that is wanted is shown.
///
/// # Errors
/// The question that would have to be answered.
pub fn shows(observed: &[Term], wanted: &[Term], assumptions: &Assumptions) -> Result<bool, String> {
    for one in wanted {
        let mut question = None;
        let mut shown = false;
        for other in observed.iter().filter(|other| same_observer(other, one)) {
            let mut equal = Some(true);
            let mut open = None;
            for (left, right) in other.values().zip(one.values()) {
                match assumptions.decide(Relation::Eq, left, right) {
                    Some(true) => {}
                    Some(false) => equal = Some(false),
                    None => {
                        equal = equal.filter(|equal| !equal);
                        open = open.or(Some(format!("whether {left} = {right}")));
                    }
                }
            }
            shown |= equal == Some(true);
            question = if equal.is_none() { question.or(open) } else { question };
        }
        if !shown {
            return question.map_or(Ok(false), Err);
        }
    }
    Ok(true)
}
