//! On which side of what a parameter lies: the comparisons on which it depends what a maximum is, or which case counts.

use std::collections::{BTreeMap, BTreeSet};

use super::cases::{Apart, as_one, same};
use super::{Outcome, Verdict};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::recurrence::Comparison;
use crate::value::{Atom, Relation, Value};

/// The longest comparison that makes cases: a longer one says nothing to a reader, and takes long to decide.
const MOST_SIZE: usize = 80;
/// Bounds on either side of which it is looked, one inside another.
const MOST_SIDES: usize = 5;

/// What was found on the sides of bounds.
enum Sides {
    /// It was found without one, with what is known there.
    One(Box<Outcome>, Assumptions),
    /// Where a difference is more than 0, and where not.
    Two(Value, Box<Sides>, Box<Sides>),
}

/// What is proved on either side of all bounds that it is open for, if it is the same on all of them: with durations that are
/// right on each, as `t*ceil(4/(t*v))`, which is t where t*v is 4 or more.
pub(super) fn on_sides(
    (known, parameters): (&Assumptions, &BTreeSet<Name>),
    whole: &Outcome,
    look: &dyn Fn(&Assumptions) -> Option<Outcome>,
) -> Option<Outcome> {
    let all = sides((known, parameters), whole, look, MOST_SIDES)?;
    let mut leaves = Vec::new();
    all.leaves(&mut leaves);
    let told = leaves.iter().map(|(outcome, _)| *outcome).find(|one| leaves.iter().all(|leaf| says(one, leaf)));
    all.as_one(told).filter(|found| found.apart.is_some())
}

fn sides(
    (known, parameters): (&Assumptions, &BTreeSet<Name>),
    whole: &Outcome,
    look: &dyn Fn(&Assumptions) -> Option<Outcome>,
    most: usize,
) -> Option<Sides> {
    match whole.verdict {
        Verdict::Proved if whole.is_told() => return Some(Sides::One(Box::new(whole.clone()), known.clone())),
        Verdict::Proved | Verdict::Open { .. } if most > 0 => {}
        _ => return None,
    }
    let bound = whole.asked.iter().find_map(|one| side(one, known, &|name| parameters.contains(name)))?;
    let (difference, zero) = (difference(&bound, known)?, Value::zero());
    let each = |relation| {
        let mut known = known.clone();
        known.assume(relation, &difference, &zero);
        sides((&known, parameters), &look(&known)?, look, most - 1).map(Box::new)
    };
    let (above, below) = (each(Relation::Gtr)?, each(Relation::Lte)?);
    Some(Sides::Two(difference, above, below))
}

/// A difference that is more than 0 where a comparison holds, or where it does not.
fn difference((relation, left, right): &Comparison, known: &Assumptions) -> Option<Value> {
    let (more, less) = (left.sub(right).ok()?, right.sub(left).ok()?);
    let open = |value: &&Value| known.decide(Relation::Gtr, value, &Value::zero()).is_none();
    match relation {
        Relation::Gtr | Relation::Lte => Some(more),
        Relation::Lss | Relation::Gte => Some(less),
        Relation::Eq | Relation::Neq => [more, less].into_iter().find(|value| open(&value)),
    }
}

/// Whether all that is said of the property in one case is so in another too.
fn says(told: &Outcome, (other, known): &(&Outcome, &Assumptions)) -> bool {
    told.property_term.is_some()
        && told.by_turns == other.by_turns
        && told.remark == other.remark
        && same(&told.values, &other.values, known).is_some()
        && same(&told.steady, &other.steady, known).is_some()
}

impl Sides {
    fn leaves<'s>(&'s self, found: &mut Vec<(&'s Outcome, &'s Assumptions)>) {
        match self {
            Sides::One(outcome, known) => found.push((outcome, known)),
            Sides::Two(_, above, below) => {
                above.leaves(found);
                below.leaves(found);
            }
        }
    }

    /// What was found on all sides, given what is so on each of them; without that, the one of two sides that says what is
    /// so on the other, if there is such a one. Of the legs nothing is said, as they are others on each side.
    fn as_one(&self, told: Option<&Outcome>) -> Option<Outcome> {
        let (difference, sides) = match self {
            Sides::One(outcome, _) => return Some((**outcome).clone()),
            Sides::Two(difference, above, below) => (difference, [above, below]),
        };
        let [above, below] = [sides[0].as_one(told)?, sides[1].as_one(told)?];
        let on_all = |one: &Outcome, other: &Sides| {
            let mut leaves = Vec::new();
            other.leaves(&mut leaves);
            leaves.iter().all(|leaf| says(one, leaf))
        };
        let chosen = || {
            let found = chosen(difference, &above, &below)?;
            (on_all(&found, sides[0]) && on_all(&found, sides[1])).then_some(found)
        };
        let by_side;
        let one = match told {
            Some(told) => told,
            None if on_all(&above, sides[1]) => &above,
            None if on_all(&below, sides[0]) => &below,
            None => {
                by_side = chosen()?;
                &by_side
            }
        };
        let mut found = Outcome { legs: Vec::new(), ..one.clone() };
        found.apart = Some(Box::new(Apart { difference: difference.clone(), above, below, otherwise: Relation::Lte }));
        Some(found)
    }
}

/// What was found on either side of 0 with durations that are chosen by the side: `if a > b then 1 else 2`.
fn chosen(difference: &Value, above: &Outcome, below: &Outcome) -> Option<Outcome> {
    let side = Value::truth(Relation::Gtr, difference, &Value::zero()).ok()?;
    let value = |one: &Value, other: &Value| {
        if one == other {
            return Some(one.clone());
        }
        one.sub(other).and_then(|more| side.mul(&more)?.add(other)).ok()
    };
    let values = |one: &BTreeMap<Name, Value>, other: &BTreeMap<Name, Value>| {
        let pair = |(name, here): (&Name, &Value)| Some((name.clone(), value(here, other.get(name)?)?));
        if one.len() == other.len() { one.iter().map(pair).collect::<Option<BTreeMap<_, _>>>() } else { None }
    };
    let term = as_one(above.property_term.as_ref()?, below.property_term.as_ref()?, &value)?;
    let (first, steady) = (values(&above.values, &below.values)?, values(&above.steady, &below.steady)?);
    Some(Outcome { values: first, steady, property_term: Some(term), ..above.clone() })
}

/// A value with a number for one of its integer parts, where it is known which: 1 for `ceil(4/(t*v))` where `t*v >= 4`.
pub(crate) fn rounded(value: &Value, known: &Assumptions) -> Option<Value> {
    value.atoms().iter().find_map(|atom| {
        let Atom::Floor(inner) = atom else { return None };
        let inner = known.simplify(inner);
        let between = |least: &i64| {
            let is = |relation, bound: i64| known.decide(relation, &inner, &Value::integer(bound)) == Some(true);
            is(Relation::Gte, *least) && is(Relation::Lss, *least + 1)
        };
        let number = [-1, 0, -2, 1].into_iter().find(between)?;
        value.with_atom(atom, &Value::integer(number)).ok()
    })
}

/// Whether two values are known to be equal, with their integer parts one after the other.
pub(crate) fn equal(one: &Value, other: &Value, known: &Assumptions) -> bool {
    let simply = || known.simplify(one) == known.simplify(other);
    if one == other || known.decide(Relation::Eq, one, other) == Some(true) || simply() {
        return true;
    }
    rounded(one, known).is_some_and(|one| equal(&one, other, known))
}

/// A comparison of these names alone that tells, or helps to tell, what is not decided: of a maximum in it, first which of its
/// elements it is.
pub(crate) fn side(
    (relation, left, right): &Comparison,
    known: &Assumptions,
    declared: &dyn Fn(&Name) -> bool,
) -> Option<Comparison> {
    let free = |value: &Value| value.variables().iter().all(declared);
    // Of roots there are so many cases, and each so long, that they say nothing.
    // Where it may have no value, neither it nor its opposite holds: they are not all cases.
    let plain = |value: &Value| !has_root(value) && known.gives_meaning(value);
    // What is left out where it is made shorter must have a value, too.
    if ![left, right].into_iter().all(|side| free(side) && plain(side)) {
        return None;
    }
    let (left, right) = &(known.simplify(left), known.simplify(right));
    if left.size() + right.size() > MOST_SIZE {
        return None;
    }
    let decided = |known: &Assumptions| known.decide(*relation, left, right).is_some();
    if decided(known) {
        return None;
    }
    let mut asked = Vec::new();
    signs(left, &mut asked);
    signs(right, &mut asked);
    asked.retain(|(relation, left, right)| {
        known.gives_meaning(left) && known.gives_meaning(right) && known.decide(*relation, left, right).is_none()
    });
    // With a comparison that tells in either case there are the fewest cases.
    let tells = |(relation, left, right): &&Comparison| {
        [*relation, relation.negated()].into_iter().all(|relation| {
            let mut known = known.clone();
            known.assume(relation, left, right);
            decided(&known)
        })
    };
    let best = asked.iter().find(tells).or(asked.first()).cloned();
    Some(best.unwrap_or_else(|| (*relation, left.clone(), right.clone())))
}

/// The comparisons on which it depends which element of a maximum counts, and which case; those inside others first.
fn signs(value: &Value, found: &mut Vec<Comparison>) {
    for atom in value.atoms() {
        atom.parts().into_iter().for_each(|inner| signs(inner, found));
        match &atom {
            Atom::Positive(inner) => found.extend(in_order(inner, &Value::zero()).into_iter().take(1)),
            Atom::Maximum(elements) => {
                let zero = std::iter::once(Value::zero());
                let all: Vec<Value> = elements.iter().cloned().chain(zero).collect();
                for (place, one) in all.iter().enumerate() {
                    found.extend(all[place + 1..].iter().flat_map(|other| in_order(one, other)));
                }
            }
            _ => {}
        }
    }
}

/// That one value is more than another, and that it is not less.
fn in_order(one: &Value, other: &Value) -> [Comparison; 2] {
    [Relation::Gtr, Relation::Gte].map(|order| (order, one.clone(), other.clone()))
}

fn has_root(value: &Value) -> bool {
    let root = |atom: &Atom| matches!(atom, Atom::Root(_)) || atom.parts().into_iter().any(has_root);
    value.atoms().iter().any(root)
}
