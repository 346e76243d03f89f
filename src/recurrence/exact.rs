//! The first index at which terms compare as wanted, from the shapes of the forms: exactly, symbols included.

use num_traits::Zero;

use super::convex::part_by_part;
use super::parabola::past;
use super::ranges::joined;
use super::reach::Wanted;
use super::roots::between_roots;
use super::{Closed, Goal, Reach, Unknown, by_shape};
use crate::assumption::Assumptions;
use crate::closed_form::{Cell, NotKnown, Piece, Recurrence, Solved, cells_or_none};
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value};

/// By the shape of the sequence, where there is one sequence or a single value for all.
pub(super) fn exactly(solved: &Solved, wanted: Wanted<'_>, known: &Assumptions) -> Option<Reach> {
    let recurrence = solved.recurrence();
    let (relation, left, right) = wanted;
    let mut natural = known.clone();
    natural.assume_natural(&recurrence.index);
    let used = compared(recurrence, left, right);
    if let [one] = used.as_slice()
        && !left.mentions(&recurrence.index)
        && !right.mentions(&recurrence.index)
    {
        return of_one_sequence(solved, wanted, one, &natural);
    }
    let variable = Name::new("[difference]");
    let mut open = None;
    for bent in [bent_in_one, folded_in] {
        let Some((pieces, left, right)) = bent(solved, (left, right), &used, &natural) else { continue };
        let closed = Closed { variable: variable.clone(), pieces, conditions: Vec::new() };
        match by_shape(&closed, &recurrence.index, &Goal::Holds(relation, left, right), &natural) {
            Reach::Unknown(why) => open = open.or(why.open.is_some().then_some(why)),
            found => return Some(found),
        }
    }
    let pieces = match by_cells(solved, &left.sub(right).ok()?, &used, &natural)? {
        Ok(pieces) => pieces,
        Err(NotKnown(ends)) => return ends.map(|(end, other)| Reach::undecided(Relation::Lte, &end, &other)),
    };
    let of = |pieces: &[Piece]| of_pieces(pieces, &recurrence.index, (relation, &open), &natural);
    let found = of(&pieces);
    let Reach::Unknown(_) = &found else { return Some(found) };
    let straight: Vec<Piece> =
        pieces.iter().map(|piece| straightened(piece.clone(), &recurrence.index, &natural)).collect();
    let told = (straight != pieces).then(|| of(&straight)).filter(|told| !matches!(told, Reach::Unknown(_)));
    Some(told.unwrap_or(found))
}

/// The same of the difference of both sides, by pieces; with a reason why it was not found otherwise.
pub(super) fn of_pieces(
    pieces: &[Piece],
    index: &Name,
    (relation, open): (Relation, &Option<Unknown>),
    known: &Assumptions,
) -> Reach {
    if let Some(found) = past(pieces, index, relation, known) {
        return found;
    }
    let variable = Name::new("[difference]");
    let goal = Goal::Holds(relation, Value::variable(&variable), Value::zero());
    let shaped = |pieces: &[Piece]| {
        let closed = Closed { variable: variable.clone(), pieces: pieces.to_vec(), conditions: Vec::new() };
        by_shape(&closed, index, &goal, known)
    };
    match or_with_equations(shaped(pieces), pieces, known, &shaped) {
        Reach::Never(why) => Reach::Never(format!("of the difference of both sides: {why}")),
        Reach::Unknown(why) => match part_by_part(pieces, index, relation, known) {
            Some(found) => found,
            None if why.open.is_none() => Reach::Unknown(open.clone().unwrap_or(why)),
            None => Reach::Unknown(why),
        },
        other => other,
    }
}

/// The same of one sequence, compared with values that stay.
fn of_one_sequence(
    solved: &Solved,
    (relation, left, right): Wanted<'_>,
    (name, place): &(Name, usize),
    natural: &Assumptions,
) -> Option<Reach> {
    let recurrence = solved.recurrence();
    let index = &recurrence.index;
    let pieces = solved.forms()[*place].by_pieces(index, recurrence.from)?;
    let goal = Goal::Holds(relation, left.clone(), right.clone());
    let shaped = |pieces: &[Piece]| {
        let closed = Closed { variable: name.clone(), pieces: pieces.to_vec(), conditions: Vec::new() };
        by_shape(&closed, index, &goal, natural)
    };
    let found = or_with_equations(shaped(&pieces), &pieces, natural, &shaped);
    let Reach::Unknown(why) = &found else { return Some(found) };
    let told = why.has_no_value();
    let of_both = of_difference(solved, &left.sub(right).ok()?, &[(name.clone(), *place)], natural);
    let otherwise = of_both.and_then(|pieces| {
        let bent = bent(&pieces, index, relation, natural);
        bent.or_else(|| by_its_own_shape(pieces, index, relation, natural).filter(|_| !told))
    });
    Some(otherwise.unwrap_or(found))
}

/// By the shape of what is compared with 0, where that is a shape though the goal is none of the term: the square of a power.
fn by_its_own_shape(pieces: Vec<Piece>, index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let variable = Name::new("[difference]");
    let goal = Goal::Holds(relation, Value::variable(&variable), Value::zero());
    match by_shape(&Closed { variable, pieces, conditions: Vec::new() }, index, &goal, known) {
        Reach::Unknown(why) if why.open.is_none() && !why.has_no_value() => None,
        Reach::Never(why) => Some(Reach::Never(format!("of the difference of both sides: {why}"))),
        found => Some(found),
    }
}

/// By the shape of what is compared with 0, as a parabola, or by the parts of its maxima.
pub(super) fn by_any_shape(pieces: Vec<Piece>, index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    bent(&pieces, index, relation, known).or_else(|| by_its_own_shape(pieces, index, relation, known))
}

/// As a parabola, or by the parts of its maxima.
fn bent(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    past(pieces, index, relation, known).or_else(|| part_by_part(pieces, index, relation, known))
}

/// What both sides are bent in, by pieces, and both as functions of it.
fn bent_in_one(
    solved: &Solved,
    sides: (&Value, &Value),
    used: &[(Name, usize)],
    known: &Assumptions,
) -> Option<(Vec<Piece>, Value, Value)> {
    let (one, [left, right]) = through_one(sides, used, &Name::new("[difference]"))?;
    Some((of_difference(solved, &one, used, known)?, left, right))
}

/// The difference of both sides as a size beside what is the same everywhere.
fn folded_in(
    solved: &Solved,
    (left, right): (&Value, &Value),
    used: &[(Name, usize)],
    known: &Assumptions,
) -> Option<(Vec<Piece>, Value, Value)> {
    let index = &solved.recurrence().index;
    let pieces = of_difference(solved, &left.sub(right).ok()?, used, known)?;
    let (pieces, rest) = folded(&joined(&pieces, index, known), index, known)?;
    Some((pieces, Value::variable(&Name::new("[difference]")).abs().ok()?, rest.neg().ok()?))
}

/// What is found of pieces, or where that is nothing of these as what is known of parameters makes them: `p+a*n` is p where a is 0.
fn or_with_equations(found: Reach, pieces: &[Piece], known: &Assumptions, shaped: &dyn Fn(&[Piece]) -> Reach) -> Reach {
    let Reach::Unknown(_) = &found else { return found };
    let settled: Vec<Piece> =
        pieces.iter().map(|piece| Piece { form: known.with_equations(piece.form.clone()), ..piece.clone() }).collect();
    if settled == pieces {
        return found;
    }
    match shaped(&settled) {
        Reach::Unknown(why) if why.open.is_none() => found,
        other => other,
    }
}

/// The terms that are compared, with the places of their sequences.
fn compared(recurrence: &Recurrence, left: &Value, right: &Value) -> Vec<(Name, usize)> {
    let terms = recurrence.terms().into_iter();
    let read = terms.filter(|(name, _, offset)| *offset == 0 && (left.mentions(name) || right.mentions(name)));
    read.map(|(name, place, _)| (name, place)).collect()
}

/// The same of one value.
pub(super) fn read(recurrence: &Recurrence, value: &Value) -> Vec<(Name, usize)> {
    compared(recurrence, value, &Value::zero())
}

/// Where the difference of both sides is a polynomial in the index, piece by piece.
pub(super) fn by_roots(solved: &Solved, (relation, left, right): Wanted<'_>, known: &Assumptions) -> Option<Reach> {
    let used = compared(solved.recurrence(), left, right);
    let pieces = of_difference(solved, &left.sub(right).ok()?, &used, known)?;
    between_roots(&pieces, &solved.recurrence().index, relation)
}

/// Values that are bent in the index, as sizes of values that are not, and what is added to these everywhere: with
/// `max(0,z)` as `|z/2|+z/2`, `max(5-n*v-e,n*v-5-e)` is `|n*v-5|`, and `-e`. One that is not bent is at least what is added.
fn folded(pieces: &[Piece], index: &Name, known: &Assumptions) -> Option<(Vec<Piece>, Value)> {
    let bent = |form: &Value| {
        form.atoms()
            .into_iter()
            .find(|atom| matches!(atom, Atom::Maximum(parts) if parts.len() == 1) && atom.mentions(index))
    };
    let unfold = |form: &Value| {
        let Atom::Maximum(parts) = bent(form)? else { return None };
        let mark = Name::new("[bent]");
        let open = form.with_atom(&Atom::Maximum(parts.clone()), &Value::variable(&mark)).ok()?;
        let (factor, rest) = open.linear_in(&mark)?;
        let half = factor.mul(&parts.first()?.clone()).ok()?.div(&Value::integer(2)).ok()?;
        let added = rest.add(&half).ok()?;
        let positive = known.decide(Relation::Gtr, &factor, &Value::zero()) == Some(true) && !factor.mentions(index);
        (positive && !added.mentions(index) && bent(&half).is_none()).then_some((half, added))
    };
    let (_, added) = pieces.iter().find_map(|piece| unfold(&piece.form))?;
    let mut all = Vec::new();
    for piece in pieces {
        let form = match unfold(&piece.form) {
            Some((half, same)) => (same == added).then_some(half)?,
            None => {
                let size = piece.form.sub(&added).ok()?;
                (known.decide(Relation::Gte, &size, &Value::zero()) == Some(true)).then_some(size)?
            }
        };
        all.push(Piece { form, ..piece.clone() });
    }
    Some((all, added))
}

/// The one value in which both sides are bent, as functions of that value alone: `x-y` of `abs(x-y) <= e`.
fn through_one(
    (left, right): (&Value, &Value),
    used: &[(Name, usize)],
    variable: &Name,
) -> Option<(Value, [Value; 2])> {
    let difference = left.sub(right).ok()?;
    let bends = difference.atoms().into_iter().filter_map(|atom| match atom {
        Atom::Maximum(parts) => Some(parts.to_vec()),
        _ => None,
    });
    bends.flatten().find_map(|inner| {
        let (name, (factor, rest)) = used.iter().find_map(|(name, _)| Some((name, inner.linear_in(name)?)))?;
        factor.as_rational().filter(|factor| !factor.is_zero())?;
        let image = Value::variable(variable).sub(&rest).ok()?.div(&factor).ok()?;
        let [left, right] = [left, right].map(|side| side.with(name, &image).ok());
        let sides = [left?, right?];
        let free = |side: &Value| !used.iter().any(|(other, _)| side.mentions(other));
        sides.iter().all(free).then_some((inner, sides))
    })
}

/// A value in these terms and the index, by pieces between all indices at which one of them has another form.
pub(super) fn of_difference(
    solved: &Solved,
    difference: &Value,
    used: &[(Name, usize)],
    known: &Assumptions,
) -> Option<Vec<Piece>> {
    by_cells(solved, difference, used, known)?.ok()
}

/// The same, or of which indices it is not known which is sooner.
fn by_cells(
    solved: &Solved,
    difference: &Value,
    used: &[(Name, usize)],
    known: &Assumptions,
) -> Option<Result<Vec<Piece>, NotKnown>> {
    let recurrence = solved.recurrence();
    let own = used.iter().map(|(_, place)| solved.forms()[*place].by_pieces(&recurrence.index, recurrence.from));
    let all = own.collect::<Option<Vec<_>>>()?;
    let cells = match cells_or_none(&all, Value::integer(recurrence.from), known) {
        Ok(cells) => cells,
        Err(why) => return Some(Err(why)),
    };
    let of = |cell: Cell<'_>| {
        let images = used.iter().zip(&cell.forms).map(|((name, _), form)| (name.clone(), (*form).clone())).collect();
        Some(Piece { from: cell.from, until: cell.until, form: difference.substitute(&images).ok()? })
    };
    cells.into_iter().map(of).collect::<Option<_>>().map(Ok)
}

/// A piece with what is bent in the index as it is there: ways that are left along one line are so much of the first one.
pub(super) fn straightened(piece: Piece, index: &Name, known: &Assumptions) -> Piece {
    let bent = |atom: &Atom| matches!(atom, Atom::Maximum(_)) && atom.mentions(index);
    if !piece.form.atoms().iter().any(bent) {
        return piece;
    }
    let mut within = known.clone();
    within.assume_natural(index);
    within.assume(Relation::Gte, &Value::variable(index), &piece.from);
    if let Some(until) = &piece.until {
        within.assume(Relation::Lss, &Value::variable(index), until);
    }
    // Where it has a value it divides by no length that is 0.
    for need in piece.form.needs() {
        let Need::Nonzero(below) = need else { continue };
        let root = matches!(below.as_atom(), Some(Atom::Root(_)));
        let length = if root { Some(below) } else { below.sqrt().ok().filter(|_| below.is_sum_of_squares()) };
        length.iter().for_each(|length| within.assume(Relation::Gtr, length, &Value::zero()));
    }
    let form = within.simplify(&piece.form);
    if form.atoms().iter().any(bent) { piece } else { Piece { form, ..piece } }
}
