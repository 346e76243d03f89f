//! Maps by regions whose sequence goes through regions in turn, for ever: each turn is a sequence of its own, and affine.
//!
//! The turns are read off the first terms, and are no more than a guess: that the guards hold for all later terms is for the
//! induction to show.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::region::resolve;
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence};
use crate::name::Name;
use crate::value::{Value, ValueError};

/// The terms that are looked at, and the most bits of one.
const MOST_TERMS: usize = 240;
const MOST_BITS: u64 = 3_000;
/// The most turns.
const MOST_TURNS: usize = 24;
/// How often all turns must have been seen, and how many terms.
const ROUNDS: usize = 3;
const TERMS: usize = 10;

/// `x := slope*x + constant`
type Affine = (BigRational, BigRational);

/// The form in turns of one sequence of numbers that begins at 0; nothing if its regions do not repeat soon.
pub(super) fn itinerary(recurrence: &Recurrence, known: &Assumptions) -> Option<Form> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let [start] = sequence.start.as_slice() else { return None };
    let name = recurrence.term(&sequence.name, 0);
    if sequence.next.mentions(&recurrence.index) || sequence.next.variables().iter().any(|other| *other != name) {
        return None;
    }
    let mut terms = vec![start.as_rational()?];
    let mut maps = Vec::new();
    while let Some(last) = terms.last().filter(|last| last.numer().bits() + last.denom().bits() < MOST_BITS)
        && maps.len() < MOST_TERMS
    {
        let map = near(&sequence.next, &name, last, known)?;
        let next = &map.0 * last + &map.1;
        maps.push(map);
        terms.push(next);
    }
    let (since, count) = (1..=MOST_TURNS).find_map(|count| {
        let since = (0..maps.len().checked_sub(count)?).rev().find(|at| maps[*at] != maps[at + count]);
        let since = since.map_or(0, |at| at + 1);
        (maps.len() - since >= (ROUNDS * count).max(TERMS) + count).then_some((since, count))
    })?;
    let slope = maps[since..since + count].iter().fold(BigRational::one(), |all, (slope, _)| all * slope);
    // A slope below 0 turns round in every round, and there is more than one turn.
    let count = if slope.is_negative() || count == 1 { 2 * count } else { count };
    let rounds = since.div_ceil(count);
    if terms.len() <= (rounds + 1) * count + count || maps.len() < (rounds + 1) * count + count {
        return None;
    }
    let forms = (0..count).map(|turn| {
        let first = rounds * count + turn;
        let whole = maps[first..first + count]
            .iter()
            .fold((BigRational::one(), BigRational::zero()), |all, map| (&all.0 * &map.0, &all.1 * &map.0 + &map.1));
        in_turn(&terms, turn, count, rounds, &whole, &recurrence.index)
    });
    Some(Form::Turns(forms.collect::<Result<_, _>>().ok()?))
}

/// The affine map that this one is at a number.
fn near(map: &Value, name: &Name, at: &BigRational, known: &Assumptions) -> Option<Affine> {
    let (local, _) = resolve(map, name, &Value::rational(at.clone()), known).ok()?;
    let (slope, constant) = local.linear_in(name)?;
    Some((slope.as_rational()?, constant.as_rational()?))
}

/// The terms of one turn, from that round on in which the turns begin.
fn in_turn(
    terms: &[BigRational],
    turn: usize,
    count: usize,
    rounds: usize,
    (slope, constant): &Affine,
    index: &Name,
) -> Result<Form, ValueError> {
    let term = |round: usize| Value::rational(terms[round * count + turn].clone());
    let settled = rounds + usize::from(slope.is_zero());
    let early = (0..settled).map(term).collect();
    if slope.is_zero() {
        return Ok(Form::Value(early, Value::rational(constant.clone())));
    }
    let since = Value::integer(i64::try_from(rounds).unwrap_or(i64::MAX));
    let (first, step) = (term(rounds), Value::variable(index).sub(&since)?);
    let form = if slope.is_one() {
        first.add(&step.mul(&Value::rational(constant.clone()))?)?
    } else {
        let limit = Value::rational(constant / (BigRational::one() - slope));
        limit.add(&first.sub(&limit)?.mul(&Value::rational(slope.clone()).power(&step)?)?)?
    };
    Ok(Form::Value(early, form))
}
