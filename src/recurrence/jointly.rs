//! Comparisons that are to hold together, some of which hold from some index on and some up to one: the first index of the
//! former is the one that is looked for if the latter hold there, and there is none if they do not. Where it is enough that
//! those of one alternative do, it is the least of the first indices of all.

use num_traits::ToPrimitive;

use super::absorbed::last_of_firsts;
use super::exact::{by_any_shape, of_difference, read};
use super::maxima::{grows, lesser};
use super::reach::Wanted;
use super::{Closed, Reach};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece, Solved};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most that are to hold, in all alternatives.
const MOST_PARTS: usize = 12;
/// The latest number before which indices are looked at one by one.
const MOST_BEFORE: i64 = 8;

/// A value that is compared with 0, and its relation.
type Compared = (Relation, Value);

/// The same with the pieces of the value.
struct Part {
    relation: Relation,
    pieces: Vec<Piece>,
}

/// What is known of what is compared: its pieces, and the first index at which it compares so with 0.
pub(super) struct Sides<'a> {
    pub(super) index: &'a Name,
    pub(super) moving: &'a dyn Fn(&Value) -> bool,
    pub(super) pieces: &'a dyn Fn(&Value) -> Option<Vec<Piece>>,
    pub(super) first: &'a dyn Fn(Wanted<'_>) -> Reach,
}

/// The first index, given the first one at which each of them holds.
pub(super) fn jointly(
    solved: &Solved,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    first: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let recurrence = solved.recurrence();
    let index = &recurrence.index;
    let mut natural = known.clone();
    natural.assume_natural(index);
    let moving = |value: &Value| value.mentions(index) || !read(recurrence, value).is_empty();
    let pieces = |value: &Value| of_difference(solved, value, &read(recurrence, value), &natural);
    let sides = Sides { index, moving: &moving, pieces: &pieces, first };
    of_alternatives((relation, &left.sub(right).ok()?), &sides, known)
}

/// The first index at which a value compares with 0, by the alternatives that it has; nothing where it has no parts.
pub(super) fn of_alternatives(
    (relation, value): (Relation, &Value),
    sides: &Sides<'_>,
    known: &Assumptions,
) -> Option<Reach> {
    let mut natural = known.clone();
    natural.assume_natural(sides.index);
    let (relation, value) = match relation {
        Relation::Gtr | Relation::Gte => (relation, value.clone()),
        Relation::Lss | Relation::Lte => (relation.mirrored(), value.neg().ok()?),
        Relation::Eq | Relation::Neq => return None,
    };
    let all = alternatives(relation, &value, &natural, sides.moving)?;
    if matches!(all.as_slice(), [parts] if matches!(parts.as_slice(), [(_, part)] if *part == value)) {
        return None;
    }
    let (mut there, mut reasons) = (Vec::new(), Vec::new());
    for parts in &all {
        match together(parts, sides, &natural, known)? {
            Reach::Never(why) => reasons.push(why),
            found => there.push(found),
        }
    }
    reasons.dedup();
    match there.as_slice() {
        [] if reasons.is_empty() => Some(Reach::Never("it is false whatever the terms are".to_string())),
        [] => Some(Reach::Never(reasons.join("; "))),
        [only] => Some(only.clone()),
        several => first_of_several(several, known).or_else(|| before_a_number(several, &all, sides, known)),
    }
}

/// The first index where one of the alternatives is there at a number: by the indices before it, one by one.
fn before_a_number(several: &[Reach], all: &[Vec<Compared>], sides: &Sides<'_>, known: &Assumptions) -> Option<Reach> {
    let numbers = several.iter().filter_map(|found| match found {
        Reach::At(at, needed) if needed.is_empty() => at.as_rational()?.to_integer().to_i64(),
        _ => None,
    });
    let last = numbers.min().filter(|last| (0..=MOST_BEFORE).contains(last))?;
    for at in 0..last {
        for parts in all {
            let mut open = None;
            let mut fails = false;
            for (relation, value) in parts {
                let (pieces, variable) = ((sides.pieces)(value)?, sides.index.clone());
                let closed = Closed { variable, pieces, conditions: Vec::new() };
                let there = known.simplify(&closed.at(sides.index, &Value::integer(at), known)?);
                match known.decide(*relation, &there, &Value::zero()) {
                    Some(holds) => fails |= !holds,
                    None => open = open.or(Some(Reach::undecided(*relation, &there, &Value::zero()))),
                }
            }
            match open {
                _ if fails => {}
                Some(open) => return Some(open),
                None => return Some(Reach::At(Value::integer(at), Vec::new())),
            }
        }
    }
    Some(Reach::At(Value::integer(last), Vec::new()))
}

/// The least of some first indices; otherwise what would have to be known first.
fn first_of_several(several: &[Reach], known: &Assumptions) -> Option<Reach> {
    let mut least = None;
    for found in several {
        let at = match found {
            Reach::At(at, needed) => match needed.first() {
                None => at.clone(),
                // It is asked whether this one is there.
                Some((relation, left, right)) => return Some(Reach::undecided(*relation, left, right)),
            },
            // One that has no value may be earlier or later than the others.
            Reach::Unknown(why) if why.open.is_some() => return Some(found.clone()),
            _ => return None,
        };
        least = Some(match least {
            Some(other) => lesser(other, at, known)?,
            None => at,
        });
    }
    least.map(|at| Reach::At(at, Vec::new()))
}

/// The first index at which all of these hold.
fn together(parts: &[Compared], sides: &Sides<'_>, natural: &Assumptions, known: &Assumptions) -> Option<Reach> {
    let (index, zero) = (sides.index, Value::zero());
    if let [(relation, value)] = parts {
        return Some((sides.first)((*relation, value, &zero)));
    }
    let (mut rising, mut falling) = (Vec::new(), Vec::new());
    for (relation, value) in parts {
        let part = Part { relation: *relation, pieces: (sides.pieces)(value)? };
        let upwards = matches!(relation, Relation::Gtr | Relation::Gte);
        if part.moves(index, natural, upwards) {
            rising.push((*relation, value.clone(), zero.clone()));
        } else if part.moves(index, natural, !upwards) {
            falling.push(part);
        } else {
            return behind_an_index(parts, sides, natural).or_else(|| part.way_asked(index, natural));
        }
    }
    match last_of_firsts(&rising, natural, sides.first)? {
        Reach::At(at, conditions) => held(&falling, (&at, conditions), index, known),
        never @ Reach::Never(_) => Some(never),
        Reach::Unknown(why) => why.open.is_some().then_some(Reach::Unknown(why)),
    }
}

/// The same of one comparison, and others that hold of every index from a number on: the first index from that on.
fn behind_an_index(parts: &[Compared], sides: &Sides<'_>, known: &Assumptions) -> Option<Reach> {
    let (index, zero) = (sides.index, Value::zero());
    let of_index = |(_, value): &&Compared| value.variables().iter().eq([index]);
    let (early, others): (Vec<&Compared>, Vec<&Compared>) = parts.iter().partition(of_index);
    let rises = |(relation, value): &&Compared| {
        let part =
            Part { relation: *relation, pieces: vec![Piece { from: zero.clone(), until: None, form: value.clone() }] };
        part.moves(index, known, true)
    };
    // What is not below and not above is equal.
    let (relation, value) = match others.as_slice() {
        [(relation, value)] => (relation, value),
        [(Relation::Gte, value), (Relation::Gte, other)] if value.neg().ok()? == *other => (&Relation::Eq, value),
        _ => return None,
    };
    let bounds: Vec<Comparison> =
        early.iter().map(|(relation, value)| (*relation, value.clone(), zero.clone())).collect();
    let Reach::At(from, none) = last_of_firsts(&bounds, known, sides.first).filter(|_| early.iter().all(rises))? else {
        return None;
    };
    if !none.is_empty() || from.as_rational().is_none() {
        return None;
    }
    let later = match from_on((sides.pieces)(value)?, &from, index, known)? {
        Ok(later) => later,
        Err(asked) => return Some(asked),
    };
    Some(match by_any_shape(later, index, *relation, known)? {
        Reach::At(at, conditions) => Reach::At(at.add(&from).ok()?, conditions),
        other => other,
    })
}

/// The pieces from an index on, counted from there; what would have to be known of where one ends, if that is it.
pub(super) fn from_on(
    pieces: Vec<Piece>,
    from: &Value,
    index: &Name,
    known: &Assumptions,
) -> Option<Result<Vec<Piece>, Reach>> {
    let zero = Value::zero();
    let shifted = Value::variable(index).add(from).ok()?;
    let mut later = Vec::new();
    for piece in pieces {
        let until = piece.until.as_ref().map(|until| until.sub(from)).transpose().ok()?;
        if let Some(until) = &until {
            match known.decide(Relation::Gtr, until, &zero) {
                Some(true) => {}
                Some(false) => continue,
                None => return Some(Err(Reach::undecided(Relation::Gtr, until, &zero))),
            }
        }
        let first = if later.is_empty() { zero.clone() } else { piece.from.sub(from).ok()? };
        later.push(Piece { from: first, until, form: piece.form.with(index, &shifted).ok()? });
    }
    Some(Ok(later))
}

/// The index, if all that holds up to some index holds there.
fn held(
    falling: &[Part],
    (at, mut conditions): (&Value, Vec<Comparison>),
    index: &Name,
    known: &Assumptions,
) -> Option<Reach> {
    let mut there = known.clone();
    conditions.iter().for_each(|(relation, left, right)| there.assume(*relation, left, right));
    for part in falling {
        let closed = Closed { variable: index.clone(), pieces: part.pieces.clone(), conditions: Vec::new() };
        let value = there.simplify(&closed.at(index, at, &there)?);
        match there.decide(part.relation, &value, &Value::zero()) {
            Some(true) => {}
            // Where what the index needs fails nothing is said.
            Some(false) if !conditions.is_empty() => return None,
            Some(false) => {
                let why =
                    format!("where the rest holds first, at {index} = {at}, one part holds no more, and never again");
                return Some(Reach::Never(why));
            }
            None => conditions.push((part.relation, value, Value::zero())),
        }
    }
    Some(Reach::At(at.clone(), conditions))
}

/// The comparisons with 0 of which all of one alternative must hold for a value to be above 0: of a maximum one of its elements is,
/// of a minimum all are, and of a choice the one that its condition chooses.
fn alternatives(
    relation: Relation,
    value: &Value,
    known: &Assumptions,
    moving: &dyn Fn(&Value) -> bool,
) -> Option<Vec<Vec<Compared>>> {
    let zero = Value::zero();
    match known.decide(relation, value, &zero) {
        Some(true) => return Some(vec![Vec::new()]),
        Some(false) => return Some(Vec::new()),
        None => {}
    }
    let of = |relation: Relation, value: &Value| alternatives(relation, value, known, moving);
    let with = |atom: &Atom, image: &Value| value.with_atom(atom, image).ok();
    // What the condition chooses, where it is known to hold, or to fail.
    let chosen = |atom: &Atom, image: &Value, (side, inner): (Relation, &Value)| {
        let mut here = known.clone();
        here.assume(side, inner, &zero);
        alternatives(relation, &here.simplify(&with(atom, image)?), &here, moving)
    };
    for atom in value.atoms() {
        match &atom {
            Atom::Positive(inner) if moving(inner) => {
                let (above, below) = ((Relation::Gtr, inner), (Relation::Lte, inner));
                let holds = both(of(Relation::Gtr, inner)?, chosen(&atom, &Value::one(), above)?)?;
                let fails = both(of(Relation::Gte, &inner.neg().ok()?)?, chosen(&atom, &zero, below)?)?;
                return limited(holds.into_iter().chain(fails).collect());
            }
            Atom::Maximum(elements) if elements.iter().any(moving) => {
                let Some(grows) = grows(value, &atom, known) else { continue };
                let mut each =
                    [&zero].into_iter().chain(elements.iter()).map(|element| of(relation, &with(&atom, element)?));
                return if grows {
                    limited(each.collect::<Option<Vec<_>>>()?.concat())
                } else {
                    each.try_fold(vec![Vec::new()], |all, one| both(all, one?))
                };
            }
            _ => {}
        }
    }
    Some(vec![vec![(relation, value.clone())]])
}

/// The alternatives in which those of both hold.
fn both(one: Vec<Vec<Compared>>, other: Vec<Vec<Compared>>) -> Option<Vec<Vec<Compared>>> {
    let joined = |parts: &Vec<Compared>| other.iter().map(|more| [parts.as_slice(), more].concat()).collect::<Vec<_>>();
    limited(one.iter().flat_map(joined).collect())
}

/// No more than there may be, each once.
fn limited(mut all: Vec<Vec<Compared>>) -> Option<Vec<Vec<Compared>>> {
    all.iter_mut().for_each(|parts| {
        parts.sort();
        parts.dedup();
    });
    all.sort();
    all.dedup();
    (all.iter().map(Vec::len).sum::<usize>() <= MOST_PARTS).then_some(all)
}

impl Part {
    /// Of one line whether it rises, where that is not known.
    fn way_asked(&self, index: &Name, known: &Assumptions) -> Option<Reach> {
        let [piece] = self.pieces.as_slice() else { return None };
        let (slope, rest) = piece.form.linear_in(index)?;
        let open = !slope.mentions(index) && !rest.mentions(index);
        let (slope, zero) = (known.simplify(&slope), Value::zero());
        let asked = known.decide(Relation::Gte, &slope, &zero).is_none()
            && known.decide(Relation::Lte, &slope, &zero).is_none();
        (open && asked).then(|| Reach::undecided(Relation::Gte, &slope, &zero))
    }

    /// Whether it never falls, or never rises, from index to index.
    fn moves(&self, index: &Name, known: &Assumptions, up: bool) -> bool {
        let relation = if up { Relation::Gte } else { Relation::Lte };
        let later = |form: &Value| form.with(index, &Value::variable(index).add(&Value::one()).ok()?).ok();
        let within = |piece: &Piece| {
            let mut known = known.clone();
            known.assume(Relation::Gte, &Value::variable(index), &piece.from);
            if let Some(until) = &piece.until {
                if known.decide(Relation::Lss, &piece.from, until) != Some(true) {
                    return false;
                }
                known.assume(Relation::Lss, &Value::variable(index), until);
            }
            later(&piece.form).is_some_and(|next| known.decide(relation, &next, &piece.form) == Some(true))
        };
        let joined = |pair: &[Piece]| {
            let [before, after] = pair else { return false };
            let last = after.from.sub(&Value::one()).ok().and_then(|last| before.form.with(index, &last).ok());
            let next = after.form.with(index, &after.from).ok();
            last.zip(next).is_some_and(|(last, next)| known.decide(relation, &next, &last) == Some(true))
        };
        self.pieces.iter().all(within) && self.pieces.windows(2).all(joined)
    }
}
