//! The first index at which terms of sequences compare as wanted.
//!
//! A sequence that is linear or geometric is asked exactly, symbols included. Of any other the terms are computed and
//! compared one by one; that none of the later ones is the first follows from the closed form, where one of its
//! parts outgrows all others (`tail`).

use std::collections::BTreeMap;

use num_traits::{ToPrimitive, Zero};

use super::barrier::barred;
use super::classes::Classes;
use super::comes_round::{comes_again, comes_round};

use super::descent::descends;
use super::far::far;
use super::late::{late, rising};
use super::modular::modular;
use super::near::near;
use super::needed::needed;
use super::numeric::Numeric;
use super::parabola::past;
use super::ranges::joined;
use super::ratio::in_ratio;
use super::roots::between_roots;
use super::sides::{furthest, squared};
use super::squares::late_products;
use super::terms::put_in;
use super::{Closed, Goal, Reach, by_shape};
use crate::assumption::Assumptions;
use crate::closed_form::{Cell, Comparison, Form, Piece, Recurrence, Solved, cells};
use crate::exponential_polynomial::tail::Tail;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The terms that are compared one by one, at most, and the bits that they may have together.
const MOST_TERMS: u64 = 20_000;
/// Those that are compared before anything is known of later ones.
const FEW_TERMS: u64 = 100;
/// Those that are compared before the forms are looked at.
const VERY_FEW_TERMS: u64 = 32;
const MOST_BITS: u64 = 1 << 26;
/// The bits that they may have together where nothing is known of later ones.
const FEW_BITS: u64 = 1 << 22;
/// The bits of the longest of them.
const LONGEST: u64 = 1 << 16;
/// The bits for which each part of a term with symbols counts, and the most parts.
const SYMBOLIC: u64 = 1 << 10;
const MOST_SIZE: usize = 2_000;
/// The same where nothing is known of later ones.
const SHORTEST: u64 = 1 << 12;

/// A comparison of expressions in the terms of offset 0.
pub(super) type Wanted<'a> = (Relation, &'a Value, &'a Value);

/// The least index at which a comparison of terms holds; of vectors, `=` or `!=`. The search ends when `stop` says so.
pub fn reach(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let zero = Value::zero();
    let needed = needed(recurrence, solved, [left, right], known, stop);
    let (recurrence, solved) = match &needed {
        Some(solved) => (solved.recurrence(), Some(solved)),
        None => (recurrence, solved),
    };
    match furthest(left, right) {
        Ok(Some(distance)) => {
            let by = |distance: &Value| of_numbers(recurrence, solved, (relation, distance, &zero), known, stop);
            let found = by(&distance);
            // Along a line with symbols the length of what is left is one number, and its parts are several.
            match (&found, left.sub(right).and_then(|left| left.norm())) {
                (Reach::Unknown(_), Ok(length)) => match by(&length) {
                    Reach::Unknown(_) => found,
                    told => told,
                },
                _ => found,
            }
        }
        Ok(None) => {
            let found = |(relation, left, right): Wanted<'_>| {
                of_numbers(recurrence, solved, (relation, left, right), known, stop)
            };
            let squares = squared((left, right), known);
            let by_squares = squares.as_ref().map(|[left, right]| found((relation, left, right)));
            match by_squares {
                Some(told @ (Reach::At(..) | Reach::Never(_))) => told,
                _ => found((relation, left, right)),
            }
        }
        Err(error) => Reach::unknown(error.to_string()),
    }
}

fn of_numbers(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let known = &solved.map_or(known, Solved::known).without_name(&recurrence.index);
    let mut reason = None;
    // Where all are numbers the first few terms cost less than any reasoning about them.
    let quickly = Numeric::of(recurrence, wanted)
        .and_then(|mut numbers| counted(&mut numbers, recurrence, &Tail::Unknown(String::new()), stop, VERY_FEW_TERMS));
    if let Some(found @ Reach::At(..)) = quickly {
        return found;
    }
    // Of the terms nothing is known here but that they are numbers.
    if Assumptions::default().decide(wanted.0, wanted.1, wanted.2) == Some(false) {
        return Reach::Never("no numbers at all compare so".to_string());
    }
    if let Some(solved) = solved.filter(|_| recurrence.from >= 0) {
        match exactly(solved, wanted, known) {
            Some(Reach::Unknown(why)) => reason = Some(why),
            Some(found) => return found,
            None => {}
        }
        if let Some(found) = by_roots(solved, wanted, known) {
            return found;
        }
    }
    let classes = solved.filter(|_| recurrence.from >= 0).and_then(|solved| Classes::of(solved, wanted));
    if let Some(found) = classes.as_ref().and_then(|classes| classes.first(known)) {
        return found;
    }
    // Most first indices are early ones, and to find these nothing need be known of later terms.
    let early = tried(recurrence, wanted, &Tail::Unknown(String::new()), known, stop, FEW_TERMS);
    if let Reach::At(..) = early {
        return early;
    }
    if let Some(found) = comes_round(recurrence, wanted, stop) {
        return found;
    }
    if let Some(found) = in_ratio(recurrence, wanted, known, stop) {
        return found;
    }
    let mut tail = match (classes, solved) {
        (Some(classes), _) => classes.tail(),
        (None, Some(solved)) => late(solved, wanted),
        (None, None) => Tail::Unknown("no bound of its later terms is known".to_string()),
    };
    if let Tail::Unknown(_) = tail {
        let found = modular(recurrence, wanted).or_else(|| barred(recurrence, wanted, known));
        let found = found.or_else(|| near(recurrence, wanted, known));
        tail = found.or_else(|| late_products(recurrence, wanted, known, stop)).unwrap_or(tail);
    }
    if let Tail::Unknown(_) = tail
        && let Some(found) = descends(recurrence, wanted, known, stop)
    {
        return found;
    }
    match (by_terms((recurrence, solved), wanted, &tail, known, stop), reason) {
        (Reach::Unknown(_), Some(reason)) if symbolic(recurrence, wanted) => Reach::Unknown(reason),
        (Reach::Unknown(why), _) => {
            far(recurrence, wanted, &tail, stop).unwrap_or_else(|count| {
                let (Tail::Unknown(late) | Tail::Never(_, late)) = &tail;
                let later = recurrence.from.checked_add_unsigned(count).filter(|_| count > MOST_TERMS);
                Reach::Unknown(later.map_or(why, |at| {
                    super::Unknown::because(format!("not before {} = {at}; {late}", recurrence.index))
                }))
            })
        }
        (found, _) => found,
    }
}

/// The first index by the terms one after the other, or by halves where they rise.
fn by_terms(
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    wanted: Wanted<'_>,
    tail: &Tail,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    let by_halves = || solved.and_then(|solved| rising(solved, wanted, stop));
    let at_once = |at: u64| Reach::At(Value::rational(num_rational::BigRational::from_integer(at.into())), Vec::new());
    let all = || tried(recurrence, wanted, tail, known, stop, MOST_TERMS);
    // Where no late term is met the early ones say all.
    match tail {
        Tail::Never(..) => match all() {
            Reach::Unknown(why) => by_halves().map_or(Reach::Unknown(why), at_once),
            found => found,
        },
        Tail::Unknown(_) => by_halves().map_or_else(all, at_once),
    }
}

/// Whether there are parameters in it.
fn symbolic(recurrence: &Recurrence, (_, left, right): Wanted<'_>) -> bool {
    let mut known: std::collections::BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    known.insert(recurrence.index.clone());
    let starts = recurrence.sequences.iter().flat_map(|sequence| sequence.start.iter().chain([&sequence.next]));
    starts.chain([left, right]).any(|value| value.variables().iter().any(|name| !known.contains(name)))
}

/// By the shape of the sequence, where there is one sequence or a single value for all.
fn exactly(solved: &Solved, wanted: Wanted<'_>, known: &Assumptions) -> Option<Reach> {
    let recurrence = solved.recurrence();
    let (relation, left, right) = wanted;
    let mut natural = known.clone();
    natural.assume_natural(&recurrence.index);
    let used = compared(recurrence, left, right);
    let conditions: Vec<Comparison> = Vec::new();
    if let [(name, place)] = used.as_slice()
        && !left.mentions(&recurrence.index)
        && !right.mentions(&recurrence.index)
    {
        let pieces = pieces(&solved.forms()[*place], &recurrence.index, recurrence.from)?;
        let closed = Closed { variable: name.clone(), pieces, conditions };
        let goal = Goal::Holds(relation, left.clone(), right.clone());
        let found = by_shape(&closed, &recurrence.index, &goal, &natural);
        return Some(match (&found, of_difference(solved, &left.sub(right).ok()?, &used, &natural)) {
            (Reach::Unknown(_), Some(pieces)) => past(&pieces, &recurrence.index, relation, &natural).unwrap_or(found),
            _ => found,
        });
    }
    let variable = Name::new("[difference]");
    if let Some((one, [left, right])) = through_one((left, right), &used, &variable)
        && let Some(pieces) = of_difference(solved, &one, &used, &natural)
    {
        let closed = Closed { variable: variable.clone(), pieces, conditions: Vec::new() };
        match by_shape(&closed, &recurrence.index, &Goal::Holds(relation, left, right), &natural) {
            Reach::Unknown(_) => {}
            found => return Some(found),
        }
    }
    let pieces = of_difference(solved, &left.sub(right).ok()?, &used, &natural)?;
    let smooth = joined(&pieces, &recurrence.index, &natural);
    if let Some((pieces, rest)) = folded(&smooth, &recurrence.index, &natural) {
        let closed = Closed { variable: variable.clone(), pieces, conditions: Vec::new() };
        let goal = Goal::Holds(relation, Value::variable(&variable).abs().ok()?, rest.neg().ok()?);
        match by_shape(&closed, &recurrence.index, &goal, &natural) {
            Reach::Unknown(_) => {}
            found => return Some(found),
        }
    }
    if let Some(found) = past(&pieces, &recurrence.index, relation, &natural) {
        return Some(found);
    }
    let closed = Closed { variable: variable.clone(), pieces, conditions };
    let goal = Goal::Holds(relation, Value::variable(&variable), Value::zero());
    match by_shape(&closed, &recurrence.index, &goal, &natural) {
        Reach::Never(why) => Some(Reach::Never(format!("of the difference of both sides: {why}"))),
        other => Some(other),
    }
}

/// The terms that are compared, with the places of their sequences.
fn compared(recurrence: &Recurrence, left: &Value, right: &Value) -> Vec<(Name, usize)> {
    let terms = recurrence.terms().into_iter();
    let read = terms.filter(|(name, _, offset)| *offset == 0 && (left.mentions(name) || right.mentions(name)));
    read.map(|(name, place, _)| (name, place)).collect()
}

/// Where the difference of both sides is a polynomial in the index, piece by piece.
fn by_roots(solved: &Solved, (relation, left, right): Wanted<'_>, known: &Assumptions) -> Option<Reach> {
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
fn of_difference(
    solved: &Solved,
    difference: &Value,
    used: &[(Name, usize)],
    known: &Assumptions,
) -> Option<Vec<Piece>> {
    let recurrence = solved.recurrence();
    let own = used.iter().map(|(_, place)| pieces(&solved.forms()[*place], &recurrence.index, recurrence.from));
    let all = own.collect::<Option<Vec<_>>>()?;
    let cells = cells(&all, Value::integer(recurrence.from), known).ok()?;
    let of = |cell: Cell<'_>| {
        let images = used.iter().zip(&cell.forms).map(|((name, _), form)| (name.clone(), (*form).clone())).collect();
        Some(Piece { from: cell.from, until: cell.until, form: difference.substitute(&images).ok()? })
    };
    cells.into_iter().map(of).collect()
}

/// A form by pieces, where it is one.
pub(super) fn pieces(form: &Form, index: &Name, from: i64) -> Option<Vec<Piece>> {
    let (early, value) = match form {
        Form::Pieces(pieces) => return Some(pieces.clone()),
        Form::Value(early, value) => (early, value.clone()),
        Form::Sum(early, sum) => (early, sum.value(index)?),
        _ => return None,
    };
    let mut all = Vec::new();
    let mut place = from;
    for term in early {
        let next = place.checked_add(1)?;
        all.push(Piece { from: Value::integer(place), until: Some(Value::integer(next)), form: term.clone() });
        place = next;
    }
    all.push(Piece { from: Value::integer(place), until: None, form: value });
    Some(all)
}

/// Term by term, as far as the tail needs it, and so many at most.
fn tried(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    tail: &Tail,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
    most_terms: u64,
) -> Reach {
    if let Some(mut numbers) = Numeric::of(recurrence, (relation, left, right))
        && let Some(found) = counted(&mut numbers, recurrence, tail, stop, most_terms)
    {
        return found;
    }
    let variables = recurrence.terms();
    let mut state: Vec<Value> = recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
    let (mut at, mut bits) = (recurrence.from, 0u64);
    let mut earlier = None;
    for count in 0..=most_terms {
        if let Some(ended) = ended(recurrence, at, count, tail, stop) {
            return ended;
        }
        if let Some(never) = comes_again(recurrence, [left, right], (at, count, &state), &mut earlier) {
            return never;
        }
        let mut images: BTreeMap<Name, Value> =
            variables.iter().map(|(name, ..)| name.clone()).zip(state.iter().cloned()).collect();
        images.insert(recurrence.index.clone(), Value::integer(at));
        let [Ok(one), Ok(other)] = [left, right].map(|side| side.substitute(&images)) else {
            return Reach::unknown(format!("it is not defined at {} = {at}", recurrence.index));
        };
        match known.decide(relation, &one, &other) {
            Some(true) => return Reach::At(Value::integer(at), Vec::new()),
            Some(false) => {}
            None => {
                return Reach::unknown(format!(
                    "it must be known whether {one} {} {other}, at {} = {at}",
                    relation.symbol(),
                    recurrence.index
                ));
            }
        }
        bits += state.iter().map(cost).sum::<u64>();
        state = match following(recurrence, &state, &images, known) {
            Ok(next) => next,
            Err(error) => return Reach::unknown(format!("not up to {} = {at}; then {error}", recurrence.index)),
        };
        at += 1;
        let most = if matches!(tail, Tail::Never(..)) { MOST_BITS } else { FEW_BITS };
        let own = |value: &Value| match value.as_rational() {
            Some(number) => number.numer().bits().max(number.denom().bits()) > longest(most_terms),
            None => value.size() > MOST_SIZE,
        };
        if bits > most || state.iter().any(own) || count == most_terms {
            break;
        }
    }
    not_before(recurrence, at, tail)
}

/// What a term costs, in bits: one with symbols as much as a long number.
fn cost(value: &Value) -> u64 {
    match value.as_rational() {
        Some(number) => number.numer().bits() + number.denom().bits(),
        None => SYMBOLIC.saturating_mul(value.size() as u64),
    }
}

/// The same for numbers; nothing where one is not defined.
fn counted(
    numbers: &mut Numeric,
    recurrence: &Recurrence,
    tail: &Tail,
    stop: &dyn Fn() -> bool,
    most_terms: u64,
) -> Option<Reach> {
    let (mut at, mut bits) = (recurrence.from, 0u64);
    let most = if matches!(tail, Tail::Never(..)) { MOST_BITS } else { FEW_BITS };
    for count in 0..=most_terms {
        if let Some(ended) = ended(recurrence, at, count, tail, stop) {
            return Some(ended);
        }
        if numbers.holds()? {
            return Some(Reach::At(Value::integer(at), Vec::new()));
        }
        bits += numbers.bits().0;
        numbers.advance()?;
        at += 1;
        if bits > most || numbers.bits().1 > longest(most_terms) {
            break;
        }
    }
    Some(not_before(recurrence, at, tail))
}

/// What ends a search before it looks at a term: that it is to stop, or that no later term is met.
fn ended(recurrence: &Recurrence, at: i64, count: u64, tail: &Tail, stop: &dyn Fn() -> bool) -> Option<Reach> {
    if stop() {
        return Some(Reach::unknown(format!("not before {} = {at}; interrupted", recurrence.index)));
    }
    let Tail::Never(until, reason) = tail else { return None };
    at.to_u64().filter(|at| at >= until)?;
    Some(Reach::Never(match count {
        0 => reason.clone(),
        _ => format!("no term before {} = {at} is, and {reason}", recurrence.index),
    }))
}

/// The bits of the longest term of so many: the first look is a short one.
fn longest(most_terms: u64) -> u64 {
    if most_terms <= FEW_TERMS { SHORTEST } else { LONGEST }
}

fn not_before(recurrence: &Recurrence, at: i64, tail: &Tail) -> Reach {
    let why = match tail {
        Tail::Unknown(why) => why.clone(),
        Tail::Never(until, _) => format!("it can be met up to {} = {until} only", recurrence.index),
    };
    Reach::unknown(format!("not before {} = {at}; {why}", recurrence.index))
}

/// The terms that the recurrence reads next, from those that it reads now.
fn following(
    recurrence: &Recurrence,
    state: &[Value],
    images: &BTreeMap<Name, Value>,
    known: &Assumptions,
) -> Result<Vec<Value>, crate::value::ValueError> {
    let next = |(place, (_, own, offset)): (usize, (Name, usize, usize))| {
        let sequence = &recurrence.sequences[own];
        if offset + 1 < sequence.start.len() {
            return Ok(state[place + 1].clone());
        }
        put_in(&sequence.next, images, known)
    };
    recurrence.terms().into_iter().enumerate().map(next).collect()
}
