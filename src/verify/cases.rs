//! Parameters that are only known to differ: the system is looked at once for either order, and what was found is
//! written as one, with the distance `abs(x - y)` and the direction `(x - y)/abs(x - y)`. The same where one is only known
//! not to be less than another: where it is more, and where it is equal. And where it is not known on which side of a bound
//! something lies, as a speed of the distance to a goal, on either side of it.
//!
//! What is written as one must be, in either case and under its assumptions, what was found there.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use super::sides::{equal, on_sides};
use super::trajectory::{Leg, Rounds};
use super::{Outcome, Verdict};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::recurrence::{Closed, Comparison, Piece};
use crate::term::{Parts, Term};
use crate::value::{Relation, Value};

/// Pairs of parameters whose order is looked at either way.
const MOST_SPLITS: usize = 3;
/// Runs that are followed before no other side of a bound is looked at.
const MOST_RUNS: usize = 30;

/// What was found for either order of two values, from which what is found as one was made.
#[derive(Clone, Debug)]
pub struct Apart {
    /// Of the two values, the one less the other.
    pub difference: Value,
    /// Where it is more than 0.
    pub above: Outcome,
    /// Where it is less than 0, and known not to be 0; or where it is 0, and known not to be less; or where it is not more.
    pub below: Outcome,
    /// How it stands to 0 there: `<`, `=` or `<=`. Where it is not more, the run is another on each side, and not written as
    /// one.
    pub otherwise: Relation,
}

impl Outcome {
    /// The runs as processes, each with the comparisons under which it is the run.
    pub fn runs(&self) -> Vec<(Vec<Comparison>, &Term)> {
        let Some(apart) = self.apart.as_ref().filter(|_| self.is_on_sides()) else {
            return self.trajectory_term.iter().map(|run| (Vec::new(), run)).collect();
        };
        let mut runs = Vec::new();
        for (outcome, relation) in [(&apart.above, Relation::Gtr), (&apart.below, apart.otherwise)] {
            let here = (relation, apart.difference.clone(), Value::zero());
            let with = |(when, run): (Vec<Comparison>, _)| ([vec![here.clone()], when].concat(), run);
            runs.extend(outcome.runs().into_iter().map(with));
        }
        runs
    }

    /// Whether the run is another on each side of some value, in some case.
    pub fn is_on_sides(&self) -> bool {
        let on_sides = |apart: &Apart| apart.otherwise == Relation::Lte;
        let in_case = |apart: &Apart| on_sides(apart) || apart.above.is_on_sides() || apart.below.is_on_sides();
        self.apart.as_ref().is_some_and(|apart| in_case(apart))
    }
}

/// The outcome under assumptions of parameters, in cases where it is open without.
pub(super) fn in_cases(
    (assumptions, parameters): (&Assumptions, &BTreeSet<Name>),
    look: &dyn Fn(&Assumptions) -> Outcome,
) -> Outcome {
    let runs = Cell::new(0);
    let counted = |known: &Assumptions| {
        runs.set(runs.get() + 1);
        look(known)
    };
    let on_sides = |known: &Assumptions, whole: &Outcome| {
        let look = |known: &Assumptions| if runs.get() < MOST_RUNS { Some(counted(known)) } else { None };
        on_sides((known, parameters), whole, &look)
    };
    split(assumptions, &counted, &on_sides, MOST_SPLITS)
}

fn split(
    assumptions: &Assumptions,
    look: &dyn Fn(&Assumptions) -> Outcome,
    on_sides: &dyn Fn(&Assumptions, &Outcome) -> Option<Outcome>,
    most: usize,
) -> Outcome {
    let whole = look(assumptions);
    let Verdict::Open { remaining } = &whole.verdict else {
        // What is shown before something is open is proved, and the run is no process that the kernel could follow.
        let untold = matches!(whole.verdict, Verdict::Proved) && !whole.is_told();
        return if untold { on_sides(assumptions, &whole).unwrap_or(whole) } else { whole };
    };
    if most == 0 {
        return on_sides(assumptions, &whole).unwrap_or(whole);
    }
    let zero = Value::zero();
    let undirected = |difference: &Value| {
        difference.variables().iter().any(|name| solved(difference, name).is_some())
            && assumptions.decide(Relation::Gtr, difference, &zero).is_none()
    };
    let differ = |wanted| assumptions.iter().filter(move |(relation, _)| *relation == wanted).map(|(_, value)| value);
    let orders = differ(Relation::Neq).filter(undirected).map(|value| (value, Relation::Lss));
    // Only what it is open for is looked at in cases: of many that are not known each would take as long as all of it.
    let asked = |value: &Value| {
        let names = value.variables();
        remaining.iter().any(|reason| {
            let words: Vec<&str> = reason.split(|letter: char| !letter.is_alphanumeric() && letter != '_').collect();
            reason.contains("must be known whether") && names.iter().all(|name| words.contains(&name.as_str()))
        })
    };
    let weak = may_be_zero(assumptions).into_iter().filter(undirected).filter(asked).map(|value| (value, Relation::Eq));
    for (difference, otherwise) in orders.chain(weak) {
        let [mut above, mut below] = [assumptions.clone(), assumptions.clone()];
        above.assume(Relation::Gtr, &difference, &zero);
        below.assume(otherwise, &difference, &zero);
        let one = split(&above, look, on_sides, most - 1);
        if !matches!(one.verdict, Verdict::Proved) {
            continue;
        }
        let other = split(&below, look, on_sides, most - 1);
        if !matches!(other.verdict, Verdict::Proved) {
            continue;
        }
        let merge = Merge { difference, above, below };
        let found = match otherwise {
            Relation::Eq => merge.equal_or_more(&one, &other),
            _ => merge.outcomes(&one, &other),
        };
        if let Some(found) = found {
            return found;
        }
    }
    on_sides(assumptions, &whole).unwrap_or(whole)
}

/// Values that are assumed not to be less than 0, and may be 0 and may be more; of a number of rounds it, and it less 1.
pub fn may_be_zero(assumptions: &Assumptions) -> Vec<Value> {
    let zero = Value::zero();
    let weak = assumptions.iter().filter(|(relation, _)| *relation == Relation::Gte).map(|(_, value)| value);
    let counted = assumptions.naturals().iter().map(Value::variable);
    let counts = counted.flat_map(|count| [Some(count.clone()), count.sub(&Value::one()).ok()]).flatten();
    let open = |value: &Value| {
        assumptions.decide(Relation::Gte, value, &zero) == Some(true)
            && assumptions.decide(Relation::Gtr, value, &zero).is_none()
    };
    weak.chain(counts).filter(open).collect()
}

/// The factor of a variable in a difference that it occurs in once, with the rest.
fn solved(difference: &Value, name: &Name) -> Option<(Value, Value)> {
    let (factor, rest) = difference.linear_in(name)?;
    let number = factor.as_rational()?;
    (!num_traits::Zero::is_zero(&number)).then_some((factor, rest))
}

/// The first name that an equation of two values gives, with its value.
pub(crate) fn equation(left: &Value, right: &Value) -> Option<(Name, Value)> {
    let difference = left.sub(right).ok()?;
    difference.variables().into_iter().find_map(|name| {
        let (factor, rest) = solved(&difference, &name)?;
        Some((name, rest.neg().ok()?.div(&factor).ok()?))
    })
}

/// Two cases of one difference: above 0, and below 0 or equal to it.
pub(crate) struct Merge {
    pub(crate) difference: Value,
    pub(crate) above: Assumptions,
    pub(crate) below: Assumptions,
}

impl Merge {
    fn outcomes(&self, one: &Outcome, other: &Outcome) -> Option<Outcome> {
        let mut found = one.clone();
        found.values = self.maps(&one.values, &other.values)?;
        found.steady = self.maps(&one.steady, &other.steady)?;
        found.by_turns = one.by_turns.clone().filter(|turns| other.by_turns.as_ref() == Some(turns));
        found.trajectory_term = Some(self.terms(one.trajectory_term.as_ref()?, other.trajectory_term.as_ref()?)?);
        found.property_term = Some(self.terms(one.property_term.as_ref()?, other.property_term.as_ref()?)?);
        found.period_term = match (&one.period_term, &other.period_term) {
            (Some(one), Some(other)) => self.terms(one, other),
            _ => None,
        };
        let (above, below) = (one.clone(), other.clone());
        found.apart =
            Some(Box::new(Apart { difference: self.difference.clone(), above, below, otherwise: Relation::Lss }));
        if one.legs.len() != other.legs.len() {
            return None;
        }
        found.legs =
            one.legs.iter().zip(&other.legs).map(|(one, other)| self.legs(one, other)).collect::<Option<_>>()?;
        Some(found)
    }

    /// What was found where a difference is more than 0, if all that is said of the property is so where it is 0 too. The
    /// legs, which may be fewer there, are those of the first.
    fn equal_or_more(&self, one: &Outcome, other: &Outcome) -> Option<Outcome> {
        let mut found = one.clone();
        found.values = same(&one.values, &other.values, &self.below)?;
        found.steady = same(&one.steady, &other.steady, &self.below)?;
        found.by_turns = one.by_turns.clone().filter(|turns| other.by_turns.as_ref() == Some(turns));
        // Where a duration is 0 the property may be written without it.
        if [one, other].iter().any(|case| case.trajectory_term.is_none() || case.property_term.is_none()) {
            return None;
        }
        let (above, below) = (one.clone(), other.clone());
        found.apart =
            Some(Box::new(Apart { difference: self.difference.clone(), above, below, otherwise: Relation::Eq }));
        Some(found)
    }

    fn maps(&self, one: &BTreeMap<Name, Value>, other: &BTreeMap<Name, Value>) -> Option<BTreeMap<Name, Value>> {
        let pair = |(name, value): (&Name, &Value)| Some((name.clone(), self.values(value, other.get(name)?)?));
        if one.len() == other.len() { one.iter().map(pair).collect() } else { None }
    }

    fn legs(&self, one: &Leg, other: &Leg) -> Option<Leg> {
        let mut leg = one.clone();
        leg.start = self.maps(&one.start, &other.start)?;
        leg.units = Vec::new();
        leg.rounds = match (&one.rounds, &other.rounds) {
            (Rounds::Count(one), Rounds::Count(other)) => Rounds::Count(self.values(one, other)?),
            (one, other) if one == other => one.clone(),
            _ => return None,
        };
        leg.closed = one
            .closed
            .iter()
            .zip(&other.closed)
            .map(|((name, one), (second, other))| {
                Some((name.clone(), self.closed((name == second).then_some(one)?, other)?))
            })
            .collect::<Option<_>>()?;
        (one.phase == other.phase && one.closed.len() == other.closed.len()).then_some(leg)
    }

    fn closed(&self, one: &Closed, other: &Closed) -> Option<Closed> {
        let pieces = one.pieces.iter().zip(&other.pieces).map(|(one, other)| {
            let until = match (&one.until, &other.until) {
                (Some(one), Some(other)) => Some(self.values(one, other)?),
                (None, None) => None,
                _ => return None,
            };
            Some(Piece {
                from: self.values(&one.from, &other.from)?,
                until,
                form: self.values(&one.form, &other.form)?,
            })
        });
        let pieces = pieces.collect::<Option<Vec<_>>>()?;
        (one.pieces.len() == other.pieces.len()).then(|| Closed { pieces, ..one.clone() })
    }

    /// Two processes that differ in values alone.
    fn terms(&self, one: &Term, other: &Term) -> Option<Term> {
        as_one(one, other, &|one, other| self.values(one, other))
    }

    /// One value that is the first in the one case and the second in the other.
    pub(crate) fn values(&self, one: &Value, other: &Value) -> Option<Value> {
        if one == other {
            return Some(one.clone());
        }
        let found = self.written_as_one(one, other)?;
        let is = |known: &Assumptions, wanted: &Value| {
            known.decide(Relation::Eq, &known.simplify(&found), wanted) == Some(true)
        };
        (is(&self.above, one) && is(&self.below, other)).then_some(found)
    }

    fn written_as_one(&self, one: &Value, other: &Value) -> Option<Value> {
        let distance = Name::new("[distance]");
        let size = Value::variable(&distance);
        let (name, (factor, rest)) = self
            .difference
            .variables()
            .into_iter()
            .find_map(|name| Some((name.clone(), solved(&self.difference, &name)?)))?;
        let at = |signed: &Value| signed.sub(&rest).and_then(|value| value.div(&factor)).ok();
        let above = one.with(&name, &at(&size)?).ok()?;
        let below = other.with(&name, &at(&size.neg().ok()?)?).ok()?;
        let half = Value::fraction(1, 2).ok()?;
        let length = self.difference.abs().ok()?;
        let middle = above.add(&below).ok()?.mul(&half).ok()?.with(&distance, &length).ok()?;
        let side = above.sub(&below).ok()?.mul(&half).ok()?.with(&distance, &length).ok()?;
        middle.add(&side.mul(&self.difference.div(&length).ok()?).ok()?).ok()
    }
}

/// Two processes that differ in values alone, with one value for each two.
pub(super) fn as_one(one: &Term, other: &Term, value: &dyn Fn(&Value, &Value) -> Option<Value>) -> Option<Term> {
    let (parts, others) = (one.children(), other.children());
    let bare = |term: &Term, parts: &Parts<'_, Term>| {
        let plain = if parts.is_empty() {
            term.clone()
        } else {
            term.with_children(parts.clone().map(|_| Term::stop()).collect())
        };
        plain.map_values(&mut |_| Ok::<_, ()>(Value::zero())).ok()
    };
    if parts.len() != others.len() || bare(one, &parts) != bare(other, &others) {
        return None;
    }
    let values = other.values();
    let mut values = values.into_iter();
    let merged = if parts.is_empty() {
        one.clone()
    } else {
        let parts = parts.into_iter().zip(others).map(|(one, other)| as_one(one, other, value));
        one.with_children(parts.collect::<Option<Vec<_>>>()?)
    };
    merged.map_values(&mut |here| values.next().and_then(|other| value(here, other)).ok_or(())).ok()
}

/// Values that are in another case, where they have a meaning, what was found there.
pub(super) fn same(
    one: &BTreeMap<Name, Value>,
    other: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Option<BTreeMap<Name, Value>> {
    let is = |(name, value): (&Name, &Value)| {
        let wanted = other.get(name)?;
        let same = value == wanted || (known.gives_meaning(value) && equal(value, wanted, known));
        same.then(|| (name.clone(), value.clone()))
    };
    if one.len() == other.len() { one.iter().map(is).collect() } else { None }
}
