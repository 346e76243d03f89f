//! Comparisons that are to hold together, some of which hold from some index on and some up to one: the first index of the
//! former is the one that is looked for if the latter hold there, and there is none if they do not.

use super::absorbed::last_of_firsts;
use super::exact::{of_difference, read};
use super::reach::Wanted;
use super::{Closed, Reach};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece, Solved};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most that are to hold together.
const MOST_PARTS: usize = 6;

/// A value that is compared with 0, by pieces, and its relation.
struct Part {
    relation: Relation,
    pieces: Vec<Piece>,
}

/// The first index, given the first one at which each of them holds.
pub(super) fn jointly(
    solved: &Solved,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    first: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let index = &solved.recurrence().index;
    let mut natural = known.clone();
    natural.assume_natural(index);
    let mut all = Vec::new();
    apart(relation, &left.sub(right).ok()?, &natural, &mut all)?;
    if all.len() < 2 {
        return None;
    }
    let (mut rising, mut falling) = (Vec::new(), Vec::new());
    for (relation, value) in all {
        let pieces = of_difference(solved, &value, &read(solved.recurrence(), &value), &natural)?;
        let upwards = matches!(relation, Relation::Gtr | Relation::Gte);
        let part = Part { relation, pieces };
        if part.moves(index, &natural, upwards) {
            rising.push((relation, value, Value::zero()));
        } else if part.moves(index, &natural, !upwards) {
            falling.push(part);
        } else {
            return None;
        }
    }
    match last_of_firsts(&rising, &natural, first)? {
        Reach::At(at, conditions) => held(&falling, (&at, conditions), index, known),
        never @ Reach::Never(_) => Some(never),
        Reach::Unknown(_) => None,
    }
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

/// What must hold together for a value to stand in a relation to 0: of a minimum each of its elements, and of a choice that
/// is below 0 where its condition fails that condition.
fn apart(relation: Relation, value: &Value, known: &Assumptions, found: &mut Vec<(Relation, Value)>) -> Option<()> {
    if found.len() > MOST_PARTS || !matches!(relation, Relation::Gtr | Relation::Gte) {
        return None;
    }
    for atom in value.atoms() {
        let with = |image: &Value| value.with_atom(&atom, image).ok();
        match &atom {
            Atom::Positive(inner) => {
                let fails = with(&Value::zero())?;
                if known.decide(relation, &fails, &Value::zero()) == Some(false) {
                    apart(Relation::Gtr, inner, known, found)?;
                    return apart(relation, &with(&Value::one())?, known, found);
                }
            }
            Atom::Maximum(elements) => {
                let mark = Name::new("[part]");
                let (factor, rest) = with(&Value::variable(&mark))?.linear_in(&mark)?;
                if known.decide(Relation::Lss, &factor, &Value::zero()) == Some(true) {
                    for element in [Value::zero()].iter().chain(elements.iter()) {
                        apart(relation, &factor.mul(element).ok()?.add(&rest).ok()?, known, found)?;
                    }
                    return Some(());
                }
            }
            _ => {}
        }
    }
    found.push((relation, value.clone()));
    Some(())
}

impl Part {
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
