//! Comparisons of values with maxima in them, taken apart: a maximum is above a number where one of its elements is, and
//! below one where all of them are. Sums and positive multiples of maxima are maxima of sums; `abs` and `min` are written
//! with maxima.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Reach;
use super::absorbed::first_of_all;
use super::late::late_in_turns;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved};
use crate::exponential_polynomial::tail::Tail;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, View};

/// The most parts that are asked.
const MOST_PARTS: usize = 32;
/// The most parts with one reason that are named.
const MOST_NAMED: usize = 4;

/// A comparison with 0, by `>` or `>=`, that holds exactly where in one of the alternatives all parts compare so; by `=`, one
/// that holds only where in one of them all do.
struct Apart {
    relation: Relation,
    alternatives: Vec<Vec<Value>>,
}

/// From which index on a comparison holds no more, as that is so of its parts, each of which is asked; nothing where it has
/// none, or these do not say so.
pub(super) fn late_parts(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    ask: &dyn Fn(Wanted<'_>) -> Tail,
) -> Option<Tail> {
    let difference = left.sub(right).ok()?;
    let needed: &[Relation] = match relation {
        // Where both sides are equal each is at least the other, and one of the parts is 0.
        Relation::Eq => &[Relation::Gte, Relation::Lte, Relation::Eq],
        Relation::Neq => &[],
        _ => &[relation],
    };
    let solved = solved.filter(|_| recurrence.from >= 0);
    needed.iter().find_map(|relation| Apart::of(&difference, *relation, known)?.tail(solved, ask))
}

/// The first index at which a comparison holds, where that is one of those of its parts, each of which is asked.
pub(super) fn first_of_parts(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    ask: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    if matches!(relation, Relation::Eq | Relation::Neq) {
        return None;
    }
    let apart = Apart::of(&left.sub(right).ok()?, relation, known)?;
    let (mut least, mut all): (Option<Value>, Vec<Comparison>) = (None, Vec::new());
    for alternative in &apart.alternatives {
        let parts = both_sides(alternative, apart.relation);
        let found = match parts.as_slice() {
            [(relation, left, right)] => ask((*relation, left, right)),
            parts => first_of_all(recurrence, parts, known, ask)?,
        };
        match found {
            Reach::Never(_) => {}
            Reach::At(at, conditions) if conditions.is_empty() || apart.alternatives.len() == 1 => {
                all = conditions;
                least = Some(match least {
                    Some(other) => lesser(other, at, known)?,
                    None => at,
                });
            }
            _ => return None,
        }
    }
    least.map(|at| Reach::At(at, all))
}

/// The comparisons of parts with 0, where one and its opposite that are both at least 0 are one that is 0.
fn both_sides(parts: &[Value], relation: Relation) -> Vec<Comparison> {
    let opposite = |one: &Value| {
        let negative = one.neg().ok().filter(|_| relation == Relation::Gte);
        negative.and_then(|negative| parts.iter().position(|other| *other == negative))
    };
    let mut all = Vec::new();
    for (place, part) in parts.iter().enumerate() {
        match opposite(part) {
            Some(other) if other < place => {}
            Some(other) if other > place => all.push(comparison(part, Relation::Eq)),
            _ => all.push(comparison(part, relation)),
        }
    }
    all
}

/// The lesser of two indices.
pub(crate) fn lesser(one: Value, other: Value, known: &Assumptions) -> Option<Value> {
    match known.decide(Relation::Lte, &one, &other) {
        Some(true) => Some(one),
        Some(false) => Some(other),
        None => Value::maximum(&[one.neg().ok()?, other.neg().ok()?]).ok()?.neg().ok(),
    }
}

impl Apart {
    fn of(difference: &Value, relation: Relation, known: &Assumptions) -> Option<Apart> {
        let (relation, value) = match relation {
            Relation::Gtr | Relation::Gte => (relation, difference.clone()),
            Relation::Lss | Relation::Lte => (relation.mirrored(), difference.neg().ok()?),
            Relation::Eq => (relation, difference.clone()),
            Relation::Neq => return None,
        };
        let mut alternatives = alternatives(&value, known)?;
        if matches!(alternatives.as_slice(), [parts] if *parts == [value]) {
            return None;
        }
        if relation == Relation::Eq {
            // The whole is one of its parts.
            alternatives = alternatives.into_iter().flatten().map(|part| vec![part]).collect();
        }
        let decided = |part: &Value, side: bool| known.decide(relation, part, &Value::zero()) == Some(side);
        alternatives.retain(|parts| !parts.iter().any(|part| decided(part, false)));
        alternatives.iter_mut().for_each(|parts| {
            parts.retain(|part| !decided(part, true));
            parts.sort();
            parts.dedup();
        });
        alternatives.sort();
        alternatives.dedup();
        Some(Apart { relation, alternatives })
    }

    fn tail(&self, solved: Option<&Solved>, ask: &dyn Fn(Wanted<'_>) -> Tail) -> Option<Tail> {
        let of_one = |parts: &Vec<Value>| self.of_alternative(parts, solved, ask);
        let told = self.alternatives.iter().map(of_one).collect::<Option<Vec<Told>>>()?;
        let Some(from) = told.iter().map(|one| one.from).max() else {
            return Some(Tail::Never(0, "it is false whatever the terms are".to_string()));
        };
        Some(Tail::Never(from, together(told)))
    }

    /// From which index on not all parts compare so, by the one of which that is known from the least index on, by two that are
    /// a distance, or by one in one turn and another in the other.
    fn of_alternative(
        &self,
        parts: &[Value],
        solved: Option<&Solved>,
        ask: &dyn Fn(Wanted<'_>) -> Tail,
    ) -> Option<Told> {
        let told = |tail: Tail, what: String| match tail {
            Tail::Never(from, why) => Some(Told { from, what, why }),
            Tail::Unknown(_) => None,
        };
        let name = |part: &Value| {
            let (relation, left, right) = comparison(part, self.relation);
            text((relation, &left, &right))
        };
        let single = |part: &Value| {
            let (relation, left, right) = comparison(part, self.relation);
            told(ask((relation, &left, &right)), name(part))
        };
        if let Some(found) = parts.iter().filter_map(single).min_by_key(|told| told.from) {
            return Some(found);
        }
        // One and its opposite are both at least 0 where it is 0.
        let opposite = pairs(parts).find(|(one, other)| one.neg().is_ok_and(|negative| negative == **other));
        if let (Some((one, _)), Relation::Gte) = (opposite, self.relation) {
            let (relation, left, right) = comparison(one, Relation::Eq);
            let equal = (relation, &left, &right);
            return told(ask(equal), text(equal));
        }
        if self.relation != Relation::Eq && (parts.len() > 2 || self.alternatives.len() > 1) {
            let distances = pairs(parts).filter_map(|(one, other)| distance(one, other));
            let near = self.relation.mirrored();
            let found =
                distances.filter_map(|(size, bound)| told(ask((near, &size, &bound)), text((near, &size, &bound))));
            if let Some(found) = found.min_by_key(|told| told.from) {
                return Some(found);
            }
        }
        let names: Vec<String> = parts.iter().map(name).collect();
        told(late_in_turns(solved?, parts, self.relation)?, names.join(" and "))
    }
}

/// What is not met from an index on, and why.
struct Told {
    from: u64,
    what: String,
    why: String,
}

/// Why none of all is met: those with one reason together.
fn together(mut told: Vec<Told>) -> String {
    told.sort_by(|one, other| one.what.cmp(&other.what));
    told.dedup_by(|one, other| one.what == other.what);
    // Above 0 or below it: the same reason, once it is for both.
    let of_both = |why: &str| why.replace("stays above 0", "keeps its sign").replace("stays below 0", "keeps its sign");
    let kinds: BTreeSet<(&str, String)> = told.iter().map(|one| (one.why.as_str(), of_both(&one.why))).collect();
    let whys: BTreeSet<&String> = kinds.iter().map(|(_, why)| why).collect();
    if let (Some(why), 1, 2..) = (whys.first().map(|why| why.to_string()), whys.len(), kinds.len()) {
        told.iter_mut().for_each(|one| one.why.clone_from(&why));
    }
    let mut groups: Vec<(String, Vec<String>)> = Vec::new();
    for one in told {
        match groups.iter_mut().find(|(why, _)| *why == one.why) {
            Some((_, names)) => names.push(one.what),
            None => groups.push((one.why, vec![one.what])),
        }
    }
    let none = |names: &[String]| match names {
        [name] => format!("{name} is not met"),
        [names @ .., last] if names.len() < MOST_NAMED => format!("neither {} nor {last} is met", names.join(" nor ")),
        _ => format!("of {} parts none is met", names.len()),
    };
    let told = groups.iter().map(|(why, names)| format!("{}: {why}", none(names)));
    told.collect::<Vec<String>>().join("; ")
}

/// All pairs of different places.
fn pairs(parts: &[Value]) -> impl Iterator<Item = (&Value, &Value)> {
    parts.iter().enumerate().flat_map(move |(place, one)| parts.iter().skip(place + 1).map(move |other| (one, other)))
}

/// The size of e, and b, where two parts are `b-e` and `b+e` with a number b.
fn distance(one: &Value, other: &Value) -> Option<(Value, Value)> {
    let half = |value: Value| value.div(&Value::integer(2)).ok();
    let bound = half(one.add(other).ok()?)?;
    bound.as_rational()?;
    Some((half(other.sub(one).ok()?)?.abs().ok()?, bound))
}

/// The parts of a value that is above 0 where in one of the alternatives all are.
fn alternatives(value: &Value, known: &Assumptions) -> Option<Vec<Vec<Value>>> {
    let maxima = value.atoms().into_iter().filter(|atom| matches!(atom, Atom::Maximum(_)));
    let signed: Vec<(Atom, bool)> =
        maxima.filter_map(|atom| Some((atom.clone(), grows(value, &atom, known)?))).collect();
    let next = signed.iter().find(|(_, grows)| *grows).or(signed.first());
    let Some((atom @ Atom::Maximum(elements), grows)) = next else { return Some(vec![vec![value.clone()]]) };
    let zero = Value::zero();
    let mut found: Vec<Vec<Value>> = if *grows { Vec::new() } else { vec![Vec::new()] };
    for element in std::iter::once(&zero).chain(elements.iter()) {
        let own = alternatives(&value.with_atom(atom, element).ok()?, known)?;
        if *grows {
            found.extend(own);
        } else {
            let joined =
                |parts: &Vec<Value>| own.iter().map(|more| [parts.as_slice(), more].concat()).collect::<Vec<_>>();
            found = found.iter().flat_map(joined).collect();
        }
        if found.iter().map(Vec::len).sum::<usize>() > MOST_PARTS {
            return None;
        }
    }
    Some(found)
}

/// Whether a value grows with an atom in it, in which it is linear, else falls; nothing where it is not known to do either.
pub(super) fn grows(value: &Value, atom: &Atom, known: &Assumptions) -> Option<bool> {
    let mark = Name::new("[maximum]");
    let (factor, rest) = value.with_atom(atom, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
    let is = |relation| known.decide(relation, &factor, &Value::zero()) == Some(true);
    if rest.mentions(&mark) {
        return None;
    }
    match (is(Relation::Gtr), is(Relation::Lss)) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

/// A comparison of a value with 0, the number in it on the other side, and without a sign in front where that can be.
fn comparison(value: &Value, relation: Relation) -> Comparison {
    let moved = || {
        let View::Real(sum, below) = value.view() else { return None };
        let plain = matches!(below.as_slice(), [(one, factors)] if one.is_one() && factors.is_empty());
        let others = || sum.iter().filter(|(_, factors)| !factors.is_empty());
        let number = sum.iter().find(|(_, factors)| factors.is_empty()).filter(|_| plain);
        let number = Value::rational(number.map_or_else(BigRational::zero, |(own, _)| own.clone()));
        let rest = value.sub(&number).ok()?;
        Some(match plain && others().all(|(own, _)| own.is_negative()) {
            true => (relation.mirrored(), rest.neg().ok()?, number),
            false => (relation, rest, number.neg().ok()?),
        })
    };
    moved().unwrap_or_else(|| (relation, value.clone(), Value::zero()))
}

fn text((relation, left, right): Wanted<'_>) -> String {
    format!("{left} {} {right}", relation.symbol())
}
