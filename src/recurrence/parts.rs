//! Sequences that can be told apart: those that have nothing to do with each other, those that are read off others, and,
//! where not all have forms, those that depend on none without.

use std::collections::{BTreeMap, BTreeSet};

use super::sequences::{Found, solve_until};
use super::{Comparison, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Solved, closures};
use crate::name::Name;
use crate::value::Value;

/// Some sequences of a recurrence of which not all have forms.
#[derive(Clone, Debug)]
pub struct Part {
    /// The sequences.
    pub names: Vec<Name>,
    /// Their forms with those of all that they depend on, or why there are none.
    pub found: Result<Solved, Unknown>,
}

/// What is found of places that depend on each other, by one attempt for each set of places that depends on no other:
/// of each with the set that it belongs to, smaller sets first. What depends on a place of which nothing is found is not tried.
pub(super) fn each_set<T>(
    closures: &[BTreeSet<usize>],
    mut attempt: impl FnMut(&BTreeSet<usize>) -> Result<T, Unknown>,
    name: impl Fn(usize) -> String,
) -> Vec<(Vec<usize>, Result<T, Unknown>)> {
    let mut sets: Vec<&BTreeSet<usize>> = closures.iter().collect();
    sets.sort_by_key(|set| (set.len(), *set));
    sets.dedup();
    let (mut told, mut without): (BTreeSet<usize>, BTreeSet<usize>) = Default::default();
    let mut found = Vec::new();
    for set in sets {
        let own: Vec<usize> = set.difference(&told).copied().collect();
        let missing: Vec<String> = set.intersection(&without).map(|place| name(*place)).collect();
        told.extend(&own);
        let result = if missing.is_empty() {
            attempt(set)
        } else {
            let verb = if own.len() == 1 { "it depends" } else { "they depend" };
            Err(Unknown::because(format!("{verb} on {}", missing.join(", "))))
        };
        if result.is_err() {
            without.extend(&own);
        }
        found.push((own, result));
    }
    found
}

/// The sequences of a recurrence that has no forms, smaller sets that depend on each other first; none where all depend on
/// all. `reason` is why all together have none.
pub fn parts(recurrence: &Recurrence, reason: &Unknown, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Part> {
    let count = recurrence.sequences.len();
    let closures = closures(count, recurrence.reads());
    if closures.iter().all(|set| set.len() == count) {
        return Vec::new();
    }
    let attempt = |set: &BTreeSet<usize>| {
        if set.len() == count {
            return Err(reason.clone());
        }
        solve_until(recurrence.only(set), known, stop)
    };
    let named = |place: usize| recurrence.sequences[place].name.clone();
    let found = each_set(&closures, attempt, |place| named(place).to_string());
    found.into_iter().map(|(own, found)| Part { names: own.into_iter().map(named).collect(), found }).collect()
}

/// The forms of sequences that fall into groups that have nothing to do with each other, of each group by itself; none where
/// there is one group alone, or one has none.
pub(super) fn each_group(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    let count = recurrence.sequences.len();
    let reads = recurrence.reads();
    let mut groups = closures(count, |one, other| reads(one, other) || reads(other, one));
    groups.sort();
    groups.dedup();
    if groups.len() < 2 {
        return None;
    }
    let (mut forms, mut conditions): (BTreeMap<usize, Form>, Vec<Comparison>) = Default::default();
    for group in groups {
        let solved = solve_until(recurrence.only(&group), known, stop).ok()?;
        forms.extend(group.into_iter().zip(solved.forms().iter().cloned()));
        conditions.extend(solved.conditions().iter().cloned());
    }
    Some((forms.into_values().collect(), conditions))
}

/// The forms of sequences of which some are read off the others: `u(n+1) = g(v(n))` is g of the form of v at the index before,
/// and `u(n+1) = u(n)+g(v(n))` a recurrence of u alone, with the form of v put in. None where there are no such sequences that
/// no other reads, or the others have no values.
pub(super) fn read_off(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    let count = recurrence.sequences.len();
    let reads = recurrence.reads();
    let unread = |place: &usize| (0..count).all(|one| one == *place || !reads(one, *place));
    let (last, first): (BTreeSet<usize>, BTreeSet<usize>) = (0..count).partition(unread);
    if last.is_empty() || (first.is_empty() && last.iter().any(|place| reads(*place, *place))) {
        return None;
    }
    let index = &recurrence.index;
    let (mut images, mut forms, mut conditions) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
    if !first.is_empty() {
        let others = recurrence.only(&first);
        let solved = solve_until(others, known, stop).ok()?;
        for (name, place, offset) in solved.recurrence().terms() {
            let value = solved.forms().get(place)?.value(index)?;
            let later = Value::variable(index).add(&Value::integer(i64::try_from(offset).ok()?)).ok()?;
            images.insert(name, value.with(index, &later).ok()?);
        }
        conditions.extend(solved.conditions().iter().cloned());
        forms.extend(first.into_iter().zip(solved.forms().iter().cloned()));
    }
    for place in last {
        let sequence = &recurrence.sequences[place];
        if reads(place, place) {
            let mut alone = recurrence.only(&BTreeSet::from([place]));
            let own = alone.sequences.first_mut()?;
            own.next = known.simplify(&own.next.substitute(&images).ok()?);
            let solved = solve_until(alone, known, stop).ok()?;
            conditions.extend(solved.conditions().iter().cloned());
            forms.insert(place, solved.forms().first()?.clone());
            continue;
        }
        let before = Value::integer(i64::try_from(sequence.start.len()).ok()?);
        let value = sequence.next.substitute(&images).ok()?;
        let value = value.with(index, &Value::variable(index).sub(&before).ok()?).ok()?;
        forms.insert(place, Form::Value(sequence.start.clone(), known.simplify(&value)));
    }
    Some((forms.into_values().collect(), conditions))
}
