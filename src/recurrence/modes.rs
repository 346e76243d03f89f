//! Motions in modes: `k(n+1) = if norm(g-r(n)) <= v then 1 else k(n)` says which way `r` goes. While the modes stay as they
//! are the others have equations of their own, and forms by any method; the first index at which a mode changes ends them.
//! That all of it is right is for the induction to show.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use super::Unknown;
use super::as_far::FirstLegs;
use super::region::Guard;
use super::sequences::Found;
use super::switching::{Leg, Place, Switching};
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most legs.
const MOST_LEGS: usize = 12;
/// The most values of a mode, and ways to come from one to another.
const MOST_VALUES: usize = 12;
const MOST_WAYS: usize = 256;
/// The longest first value of a mode.
const MOST_SIZE: usize = 130;

/// Forms of a recurrence that begins at 0, of which some sequences are modes of the others; none where there are no modes.
///
/// # Errors
/// Where a leg has no form, or it cannot be said when it ends.
pub(super) fn in_modes(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Found>, Unknown> {
    let Some(local) = by_modes(recurrence, false) else { return Ok(Vec::new()) };
    Switching::new(recurrence, known, stop).legs(MOST_LEGS, &local)
}

/// The forms of its first modes, where there are none of all.
pub(super) fn first_modes(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<FirstLegs, Option<Unknown>> {
    let local = by_modes(recurrence, true).ok_or(None)?;
    Switching::new(recurrence, known, stop).first_legs(MOST_LEGS, &local)
}

/// What holds from a place on, where some sequences are modes of the others; with an end where they come `once` again.
fn by_modes(recurrence: &Recurrence, once: bool) -> Option<impl Fn(&Switching<'_>, &Place) -> Result<Leg, Unknown>> {
    let modes = modes(recurrence);
    let changes = modes.values().any(|values| values.len() > 1);
    if !changes || modes.len() == recurrence.sequences.len() {
        return None;
    }
    let modes: BTreeSet<usize> = modes.into_keys().collect();
    let entered: RefCell<Vec<Vec<Vec<Value>>>> = RefCell::default();
    Some(move |switching: &Switching<'_>, place: &Place| {
        let leg = local(switching, &modes, place)?;
        // What comes back to a mode at a time that is a symbol goes round for ever.
        let own = modes.iter().map(|own| place.starts[*own].clone()).collect();
        let mut entered = entered.borrow_mut();
        let goes_on = matches!(leg, Leg::While(..));
        let round = if once { entered.last() != Some(&own) } else { goes_on && place.from.as_rational().is_none() };
        if round && entered.contains(&own) {
            return Err(Unknown::because("its modes come round again and again"));
        }
        if once || goes_on {
            entered.push(own);
        }
        Ok(leg)
    })
}

/// The sequences that go from one of few values to another, as conditions choose, each with these.
fn modes(recurrence: &Recurrence) -> BTreeMap<usize, Vec<Value>> {
    if recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        return BTreeMap::new();
    }
    (0..recurrence.sequences.len()).filter_map(|own| Some((own, values(recurrence, own)?))).collect()
}

/// All values that a sequence may come to, whatever the conditions are, if these are few.
fn values(recurrence: &Recurrence, own: usize) -> Option<Vec<Value>> {
    let terms = recurrence.terms();
    let sequence = &recurrence.sequences[own];
    let here = recurrence.term(&sequence.name, 0);
    let moving = |value: &Value| {
        let other = |name: &Name| *name != here && value.mentions(name);
        other(&recurrence.index) || terms.iter().any(|(name, ..)| other(name))
    };
    // Beside conditions nothing else may tell its value.
    let plain = |atom: &Atom| matches!(atom, Atom::Positive(_)) || atom.value().is_ok_and(|value| !moving(&value));
    if !sequence.next.atoms().iter().all(plain) {
        return None;
    }
    if sequence.start.iter().any(|start| start.size() > MOST_SIZE) {
        return None;
    }
    let mut found = sequence.start.clone();
    let mut place = 0;
    while let Some(value) = found.get(place).cloned() {
        for next in ways(&sequence.next.with(&here, &value).ok()?, &moving)? {
            if moving(&next) {
                return None;
            }
            if !found.contains(&next) {
                found.push(next);
            }
        }
        place += 1;
        if found.len() > MOST_VALUES {
            return None;
        }
    }
    Some(found)
}

/// What a value may be as those conditions in it hold or not that move.
fn ways(value: &Value, moving: &dyn Fn(&Value) -> bool) -> Option<Vec<Value>> {
    let atoms = value.atoms();
    let conditions: Vec<(&Atom, &Value)> = atoms
        .iter()
        .filter_map(|atom| if let Atom::Positive(condition) = atom { Some((atom, condition)) } else { None })
        .filter(|(_, condition)| moving(condition))
        .collect();
    let mut all: Vec<(Value, Vec<&Value>)> = vec![(value.clone(), Vec::new())];
    for (atom, condition) in conditions {
        let opposite = condition.neg().ok()?;
        let mut next = Vec::new();
        for (value, holding) in all {
            next.push((value.with_atom(atom, &Value::zero()).ok()?, holding.clone()));
            // Nothing is both more than 0 and less.
            if !holding.contains(&&opposite) {
                let holding = holding.into_iter().chain([condition]).collect();
                next.push((value.with_atom(atom, &Value::one()).ok()?, holding));
            }
        }
        all = next;
        if all.len() > MOST_WAYS {
            return None;
        }
    }
    Some(all.into_iter().map(|(value, _)| value).collect())
}

/// The terms of some sequences, each with a value.
fn values_of<'v>(
    recurrence: &Recurrence,
    of: &BTreeSet<usize>,
    value: impl Fn(usize) -> &'v Value,
) -> BTreeMap<Name, Value> {
    let terms = recurrence.terms();
    terms.into_iter().filter(|(_, own, _)| of.contains(own)).map(|(name, own, _)| (name, value(own).clone())).collect()
}

/// What holds from a place on: for one step where a mode changes, and else as long as the guards do by which they stay.
fn local(switching: &Switching<'_>, modes: &BTreeSet<usize>, place: &Place) -> Result<Leg, Unknown> {
    let (recurrence, known) = (switching.recurrence, &switching.known);
    let index = &recurrence.index;
    let all = (0..recurrence.sequences.len()).collect();
    let mut here = values_of(recurrence, &all, |own| &place.starts[own][0]);
    here.insert(index.clone(), place.from.clone());
    let held = values_of(recurrence, modes, |own| &place.starts[own][0]);
    let shifted = Value::variable(index).add(&place.from)?;
    let (mut equations, mut guards, mut changes): (Vec<Value>, Vec<Guard>, bool) = (Vec::new(), Vec::new(), false);
    for (own, sequence) in recurrence.sequences.iter().enumerate() {
        let mut next = known.simplify(&sequence.next.substitute(&held)?);
        if modes.contains(&own) {
            for atom in next.atoms() {
                let Atom::Positive(condition) = &atom else { continue };
                let then = condition.substitute(&here)?;
                let Some(holds) = known.decide(Relation::Gtr, &then, &Value::zero()) else {
                    return Err(Unknown::undecided(Relation::Gtr, &then, &Value::zero()));
                };
                let relation = if holds { Relation::Gtr } else { Relation::Lte };
                let guard = Guard { relation, value: condition.with(index, &shifted)? };
                if !guards.contains(&guard) {
                    guards.push(guard);
                }
                next = next.with_atom(&atom, &Value::integer(i64::from(holds)))?;
            }
            changes |= known.decide(Relation::Eq, &next, &place.starts[own][0]) != Some(true);
        }
        equations.push(next);
    }
    if changes {
        let step = |next: &Value| Ok::<_, Unknown>(vec![known.simplify(&next.substitute(&here)?)]);
        return Ok(Leg::Step(equations.iter().map(step).collect::<Result<_, _>>()?));
    }
    let mut local = recurrence.clone();
    for ((sequence, start), next) in local.sequences.iter_mut().zip(&place.starts).zip(&equations) {
        sequence.next = next.with(index, &shifted)?;
        sequence.start.clone_from(start);
    }
    Ok(Leg::While(local, guards))
}
