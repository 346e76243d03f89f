//! A question in other units of measure: what is asked of speeds, lengths and times for every unit is so if it is for one.
//!
//! Let `s > 0` be a parameter, and each other parameter `p` and each sequence `x` have a *weight*, such that with
//! `p*s^w` for `p` and `x*s^w` for `x` the starting values and the equation of `x` become `s^w` times what they are for
//! `s = 1`, and both sides of what is asked `s^m` times that. Then, by induction, the terms for `s` and `p*s^w` are `s^w` times
//! those for 1 and `p`, and as `s^m > 0` they compare as those do. Whatever `s > 0` and the parameters are, they are of this
//! kind: so it is enough to ask where `s` is 1. Of what is assumed only that goes over which is so of 1 and `p` where it is
//! of `s` and `p*s^w`; a parameter that has a weight need be natural no more.

use std::collections::{BTreeMap, BTreeSet};

use super::{Comparison, Recurrence, Solved};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// Weights that are tried, and the most parameters beside the unit, sequences that begin with 0, and tries in all.
const WEIGHTS: [i32; 3] = [1, 0, -1];
const MOST_PARAMETERS: usize = 4;
const MOST_FROM_ZERO: usize = 3;
const MOST_TRIES: usize = 250;
/// The powers of the unit that a value may be a multiple by.
const POWERS: [i32; 5] = [0, 1, -1, 2, -2];

/// What is asked: a comparison, an index at which it holds under conditions, if one is named.
pub(super) struct Asked<'a> {
    pub(super) wanted: (Relation, &'a Value, &'a Value),
    pub(super) at: Option<&'a Value>,
    pub(super) conditions: &'a [Comparison],
}

/// The same where the unit is 1.
pub(super) struct InUnits {
    pub(super) solved: Solved,
    pub(super) wanted: Comparison,
    pub(super) at: Option<Value>,
    pub(super) conditions: Vec<Comparison>,
}

/// What a question is for 1 in place of each parameter that may be a unit, with the names of these.
pub(super) fn in_units<'a>(solved: &'a Solved, asked: &'a Asked<'a>) -> impl Iterator<Item = InUnits> + 'a {
    let known = solved.known().without_name(&solved.recurrence().index);
    let names = parameters(solved, asked);
    let is_unit = move |name: &Name| known.decide(Relation::Gtr, &Value::variable(name), &Value::zero()) == Some(true);
    let units: Vec<Name> = names.iter().filter(|name| is_unit(name)).cloned().collect();
    units.into_iter().filter_map(move |unit| {
        let others: Vec<Name> = names.iter().filter(|name| **name != unit).cloned().collect();
        (others.len() <= MOST_PARAMETERS).then(|| at_one(solved, asked, &unit, &others)).flatten()
    })
}

/// The names that are no terms, and not the index.
fn parameters(solved: &Solved, asked: &Asked<'_>) -> BTreeSet<Name> {
    let recurrence = solved.recurrence();
    let terms: BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let own = recurrence.sequences.iter().flat_map(|sequence| sequence.start.iter().chain([&sequence.next]));
    let all = own.chain([asked.wanted.1, asked.wanted.2]).chain(asked.at);
    let free = |name: &Name| *name != recurrence.index && !terms.contains(name);
    all.flat_map(Value::variables).filter(free).collect()
}

/// A question for 1 in place of this parameter, with weights of the others, if there are some.
fn at_one(solved: &Solved, asked: &Asked<'_>, unit: &Name, others: &[Name]) -> Option<InUnits> {
    let recurrence = solved.recurrence();
    let from_zero = recurrence.sequences.iter().filter(|own| own.start.iter().all(Value::is_zero)).count();
    if from_zero > MOST_FROM_ZERO {
        return None;
    }
    let all = choices(others.len());
    let of_sequences = choices(from_zero);
    let mut tries = 0;
    for weights in &all {
        let own: BTreeMap<Name, i32> = others.iter().cloned().zip(weights.iter().copied()).collect();
        for beginning in &of_sequences {
            tries += 1;
            if tries > MOST_TRIES {
                return None;
            }
            let scale = Scale::of(recurrence, unit, &own, beginning, solved.known());
            if let Some(found) = scale.and_then(|scale| scale.question(solved, asked)) {
                return Some(found);
            }
        }
    }
    None
}

/// All weights of so many.
fn choices(count: usize) -> Vec<Vec<i32>> {
    (0..count).fold(vec![Vec::new()], |all, _| {
        let with = |one: &Vec<i32>| WEIGHTS.map(|weight| one.iter().copied().chain([weight]).collect::<Vec<_>>());
        all.iter().flat_map(with).collect()
    })
}

/// What a value is for 1, times which power of the unit it is with weights; of 0, any.
type Scaled = (Value, Option<i32>);

/// Parameters and terms times powers of the unit.
struct Scale<'a> {
    unit: &'a Name,
    images: BTreeMap<Name, Value>,
    /// The parameters with a weight other than 0.
    weighty: BTreeSet<Name>,
    /// What is known of the parameters for any unit.
    known: Assumptions,
}

fn power(unit: &Name, weight: i32) -> Option<Value> {
    let unit = Value::variable(unit);
    let powers = (0..weight.unsigned_abs()).try_fold(Value::one(), |all, _| all.mul(&unit)).ok()?;
    if weight < 0 { Value::one().div(&powers).ok() } else { Some(powers) }
}

impl<'a> Scale<'a> {
    /// By weights of the parameters and, in turn, of the sequences that begin with 0; those of the others follow.
    fn of(
        recurrence: &Recurrence,
        unit: &'a Name,
        weights: &BTreeMap<Name, i32>,
        of_zero: &[i32],
        assumed: &Assumptions,
    ) -> Option<Scale<'a>> {
        let times = |name: &Name, weight: i32| Value::variable(name).mul(&power(unit, weight)?).ok();
        let parameters = weights.iter().map(|(name, weight)| Some((name.clone(), times(name, *weight)?)));
        let images: BTreeMap<Name, Value> = parameters.collect::<Option<_>>()?;
        let weighty = weights.iter().filter(|(_, weight)| **weight != 0).map(|(name, _)| name.clone()).collect();
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &Value::variable(unit), &Value::zero());
        let mut scale = Scale { unit, images, weighty, known };
        scale.take_over(&assumed.without_name(&recurrence.index));
        let mut of_zero = of_zero.iter();
        let mut own = Vec::new();
        for sequence in &recurrence.sequences {
            let first = sequence.start.iter().find(|start| !start.is_zero());
            own.push(match first {
                Some(first) => scale.scaled(first)?.1?,
                None => *of_zero.next()?,
            });
        }
        for (term, place, _) in recurrence.terms() {
            scale.images.insert(term.clone(), times(&term, own[place])?);
        }
        let goes_over = recurrence.sequences.iter().zip(&own).all(|(sequence, weight)| {
            let mut all = sequence.start.iter().chain([&sequence.next]);
            all.all(|value| scale.scaled(value).is_some_and(|(_, found)| found.is_none_or(|found| found == *weight)))
        });
        goes_over.then_some(scale)
    }

    /// Assumes what is so of the parameters for any unit where it is for one.
    fn take_over(&mut self, assumed: &Assumptions) {
        for name in assumed.naturals() {
            if self.weighty.contains(name) {
                self.known.assume(Relation::Gte, &Value::variable(name), &Value::zero());
            } else if name != self.unit {
                self.known.assume_natural(name);
            }
        }
        // What is known tells more of values, so first what needs least.
        let mut facts: Vec<(Relation, Value)> = assumed.iter().collect();
        facts.sort_by_key(|(_, zero)| zero.atoms().len());
        for (relation, zero) in facts {
            if let Some((zero, _)) = self.scaled(&zero) {
                self.known.assume(relation, &zero, &Value::zero());
            }
        }
    }

    /// What a value is for 1, if with all images in it it is some power of the unit times that.
    fn scaled(&self, value: &Value) -> Option<Scaled> {
        let one = value.with(self.unit, &Value::one()).ok()?;
        let image = value.substitute(&self.images).ok()?;
        let is_zero = |value: &Value| value.is_zero() || self.known.simplify(value).is_zero();
        let apart = |weight: i32| image.sub(&one.mul(&power(self.unit, weight)?).ok()?).ok();
        let nothing = |value: &Value| match value.components() {
            Some(parts) => parts.iter().all(is_zero),
            None => is_zero(value),
        };
        if nothing(&one) {
            return nothing(&image).then_some((one, None));
        }
        let weight = POWERS.into_iter().find(|weight| apart(*weight).is_some_and(|apart| nothing(&apart)))?;
        Some((one, Some(weight)))
    }

    /// Both sides of a comparison, if they go over by the same power.
    fn sides(&self, (relation, left, right): (Relation, &Value, &Value)) -> Option<Comparison> {
        let ((left, one), (right, other)) = (self.scaled(left)?, self.scaled(right)?);
        let same = one.is_none() || other.is_none() || one == other;
        same.then_some((relation, left, right))
    }

    /// The question where the unit is 1, of forms that are checked there.
    fn question(&self, solved: &Solved, asked: &Asked<'_>) -> Option<InUnits> {
        let wanted = self.sides(asked.wanted)?;
        let at = match asked.at {
            Some(at) => Some(self.scaled(at).filter(|(_, weight)| weight.is_none_or(|weight| weight == 0))?.0),
            None => None,
        };
        let conditions =
            asked.conditions.iter().filter_map(|(relation, left, right)| self.sides((*relation, left, right)));
        let conditions = conditions.collect();
        // The forms rest on their conditions at 1, which must be so of the question that was asked.
        if !solved.conditions().iter().all(|(relation, left, right)| self.sides((*relation, left, right)).is_some()) {
            return None;
        }
        let known = self.known.without_name(self.unit);
        let solved = solved.instance(self.unit, &Value::one(), &known).ok()?;
        Some(InUnits { solved, wanted, at, conditions })
    }
}
