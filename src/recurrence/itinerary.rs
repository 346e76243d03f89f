//! Maps by regions whose sequences go through regions in turn, for ever: each turn is a linear recurrence of its own.
//!
//! The turns are read off the first terms, and are no more than a guess: that the guards hold for all later terms is for the
//! induction to show.

use std::collections::BTreeMap;

use super::ranges::{after, trimmed};
use super::region::{Point, resolve_at};
use super::sequences::solve_until;
use super::switching::compares;
use super::turns::round;
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, closures, in_class};
use crate::value::{Atom, Value};

/// The terms that are looked at, and the most bits of one.
const MOST_TERMS: usize = 400;
const MOST_BITS: u64 = 5_000;
/// The most turns.
const MOST_TURNS: usize = 60;
/// How often all turns must have been seen, and how many terms.
const ROUNDS: usize = 3;
const TERMS: usize = 10;

/// The forms in turns of sequences of numbers that begin at 0, as they may be; none if their regions do not repeat soon.
pub(super) fn itineraries(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Vec<Form>> {
    if !compares(recurrence) {
        return Vec::new();
    }
    let Some(maps) = maps(recurrence, known, stop) else { return Vec::new() };
    let repeats = |count: usize| {
        let since = (0..maps.len().checked_sub(count)?).rev().find(|at| maps[*at] != maps[at + count]);
        let since = since.map_or(0, |at| at + 1);
        (maps.len() - since >= (ROUNDS * count).max(TERMS) + count).then_some((since, count))
    };
    // What has come again only lately may be part of a longer round.
    let early = |(since, _): &(usize, usize)| 2 * since <= maps.len();
    let mut all = (1..=MOST_TURNS).filter_map(repeats);
    let Some((since, count)) = all.clone().find(early).or_else(|| all.next()) else { return Vec::new() };
    // What is multiplied by a negative number in each round keeps its sign in every other one.
    [count, 2 * count].into_iter().filter_map(|count| in_turn(recurrence, &maps, (since, count), known, stop)).collect()
}

/// The equations as they are at each of the first terms.
fn maps(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Vec<Vec<Value>>> {
    let variables = recurrence.terms();
    let mut state: Vec<Value> = recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
    let mut maps = Vec::new();
    let short =
        |value: &Value| value.as_rational().map(|number| number.numer().bits() + number.denom().bits() < MOST_BITS);
    while maps.len() < MOST_TERMS
        && !stop()
        && state.iter().map(short).collect::<Option<Vec<_>>>()?.into_iter().all(|short| short)
    {
        let mut values: BTreeMap<_, _> =
            variables.iter().map(|(name, ..)| name.clone()).zip(state.iter().cloned()).collect();
        values.insert(recurrence.index.clone(), Value::integer(i64::try_from(maps.len()).ok()?));
        let point = Point { values, index: Some(&recurrence.index) };
        let mut map = Vec::new();
        for sequence in &recurrence.sequences {
            let (local, _) = resolve_at(&sequence.next, &point, known).ok()?;
            variables.iter().all(|(name, ..)| local.linear_in(name).is_some()).then_some(())?;
            map.push(local);
        }
        let mut next = Vec::new();
        for (at, (_, own, offset)) in variables.iter().enumerate() {
            let ordered = *offset + 1 < recurrence.sequences[*own].start.len();
            next.push(if ordered { state[at + 1].clone() } else { map[*own].substitute(&point.values).ok()? });
        }
        maps.push(map);
        state = next;
    }
    Some(maps)
}

/// The forms in so many turns, from the first index on that is a multiple of their number and not before another one.
fn in_turn(
    recurrence: &Recurrence,
    maps: &[Vec<Value>],
    (since, count): (usize, usize),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<Form>> {
    let index = &recurrence.index;
    let first = since.div_ceil(count) * count;
    let turns = (first..first + count).map(|at| {
        let equations = maps.get(at)?.iter();
        equations.map(|one| in_class(one, index, i64::try_from(count).ok()?, i64::try_from(at).ok()?).ok()).collect()
    });
    let turns: Vec<Vec<Value>> = turns.collect::<Option<_>>()?;
    let longest = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max()?;
    let terms = recurrence.iterate(first + longest).ok()?;
    let mut moved = recurrence.clone();
    let shifted = Value::variable(index).add(&Value::integer(i64::try_from(first).ok()?)).ok()?;
    for (sequence, terms) in moved.sequences.iter_mut().zip(&terms) {
        sequence.next = sequence.next.with(index, &shifted).ok()?;
        sequence.start = terms[first..first + sequence.start.len()].to_vec();
    }
    let forms = round(&moved, &turns, known, stop).ok()?;
    let mut all = Vec::new();
    for (place, (form, terms)) in forms.into_iter().zip(&terms).enumerate() {
        all.push(match alone(recurrence, place, known, stop) {
            Some(form) => form,
            None => trimmed(after(only(form), &terms[..first], index)?, index),
        });
    }
    Some(all)
}

/// The form of one turn, if there is but one.
fn only(form: Form) -> Form {
    match form {
        Form::Turns(mut forms) if forms.len() == 1 => forms.remove(0),
        form => form,
    }
}

/// The form of a sequence that depends on none with conditions, where it is one value for all indices.
fn alone(recurrence: &Recurrence, place: usize, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Form> {
    let group = closures(recurrence.sequences.len(), recurrence.reads()).swap_remove(place);
    let all = recurrence.only(&group);
    let compares = |atom: &Atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_));
    if all.sequences.iter().any(|sequence| sequence.next.atoms().iter().any(compares)) {
        return None;
    }
    let own = group.iter().position(|own| *own == place)?;
    let solved = solve_until(all, known, stop).ok()?;
    let form = solved.forms().get(own)?;
    let fine = solved.conditions().is_empty() && matches!(form, Form::Value(..) | Form::Sum(..));
    (fine && form.value(&recurrence.index).is_some()).then(|| form.clone())
}
