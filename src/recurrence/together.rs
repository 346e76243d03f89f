//! The variables of a system that change together: groups that do not depend on each other are solved apart, and what
//! is found is checked by the induction of [`Solved`].

use std::collections::{BTreeMap, BTreeSet};

use super::line::along_a_line;
use super::parts::each_set;
use super::{Closed, Solved, Unknown, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, closures, term};
use crate::name::Name;
use crate::value::{Sort, Value};

/// Checked closed forms of `x(n+1) = map(x(n), y(n), …)`, `x(0) = start` for every variable that has a map.
///
/// # Errors
/// When one has none, or none that could be checked, with what stands in the way.
pub fn solve_together(
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    index: &Name,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<(Name, Closed)>, Unknown> {
    let names: Vec<&Name> = maps.keys().collect();
    let reads = |one: usize, other: usize| maps[names[one]].mentions(names[other]);
    let mut groups = closures(names.len(), |one, other| reads(one, other) || reads(other, one));
    groups.sort();
    groups.dedup();
    let mut found = Vec::new();
    for group in groups {
        let group = group.into_iter().map(|place| names[place]).collect();
        found.extend(one_group(&group, maps, starts, index, known, stop)?);
    }
    found.sort_by(|one, other| one.0.cmp(&other.0));
    Ok(found)
}

/// What is found of variables of which not all have closed forms.
pub struct Apart {
    /// The checked closed forms of those that depend on none without.
    pub closed: Vec<(Name, Closed)>,
    /// The others, with what stands in the way.
    pub missing: Vec<(Vec<Name>, Unknown)>,
}

/// The same for as many of the variables as have closed forms.
pub fn solve_apart(
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    index: &Name,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Apart {
    let reason = match solve_together(maps, starts, index, known, stop) {
        Ok(closed) => return Apart { closed, missing: Vec::new() },
        Err(reason) => reason,
    };
    let names: Vec<&Name> = maps.keys().collect();
    let closures = closures(names.len(), |one, other| maps[names[one]].mentions(names[other]));
    let attempt = |set: &BTreeSet<usize>| {
        if set.len() == names.len() {
            return Err(reason.clone());
        }
        let own = set.iter().map(|place| (names[*place].clone(), maps[names[*place]].clone())).collect();
        solve_together(&own, starts, index, known, stop)
    };
    let (mut closed, mut missing) = (Vec::new(), Vec::new());
    for (own, found) in each_set(&closures, attempt, |place| names[place].to_string()) {
        let own: Vec<Name> = own.into_iter().map(|place| names[place].clone()).collect();
        match found {
            Ok(all) => closed.extend(all.into_iter().filter(|(name, _)| own.contains(name))),
            Err(reason) => missing.push((own, reason)),
        }
    }
    closed.sort_by(|one, other| one.0.cmp(&other.0));
    Apart { closed, missing }
}

fn one_group(
    group: &BTreeSet<&Name>,
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    index: &Name,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<(Name, Closed)>, Unknown> {
    let names: BTreeMap<Name, Value> =
        group.iter().map(|name| ((*name).clone(), Value::variable(&term(name, index, 0)))).collect();
    let mut sequences = Vec::new();
    for name in group {
        let start = starts.get(*name).ok_or_else(|| Unknown::because(format!("{name} has no first value")))?;
        if start.sort() != Sort::Real {
            return Err(Unknown::because("closed forms are known of sequences of numbers only"));
        }
        let next = known.simplify(&maps[*name]).substitute(&names)?;
        sequences.push(Sequence { name: (*name).clone(), start: vec![known.simplify(start)], next });
    }
    let solved = solve_until(Recurrence { index: index.clone(), from: 0, sequences }, known, stop);
    let all = |solved: Solved| group.iter().map(|name| Ok(((*name).clone(), closed(&solved, name)?))).collect();
    solved.and_then(all).or_else(|reason: Unknown| {
        // Where the equations have no value at the goal the induction fails there. What is left of the way has a form that was
        // checked, and the equations keep to the line wherever they have a value: so does what is found, up to the goal.
        let own = |map: &BTreeMap<Name, Value>| {
            group.iter().filter_map(|name| Some(((*name).clone(), map.get(*name)?.clone()))).collect()
        };
        along_a_line(&own(maps), &own(starts), index, known).ok().flatten().ok_or(reason)
    })
}

/// The form of one sequence by pieces.
pub(super) fn closed(solved: &Solved, name: &Name) -> Result<Closed, Unknown> {
    let recurrence = solved.recurrence();
    let by_pieces = solved.form(name).and_then(|form| form.by_pieces(&recurrence.index, recurrence.from));
    let pieces =
        by_pieces.ok_or_else(|| Unknown::because(format!("the form of {name} is no value in {}", recurrence.index)))?;
    Ok(Closed { variable: name.clone(), pieces, conditions: solved.conditions().to_vec() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coupled_and_apart() {
        let [x, y, z, n] = ["x", "y", "z", "n"].map(Name::new);
        let [vx, vy, vz] = [&x, &y, &z].map(Value::variable);
        let half = Value::fraction(1, 2).unwrap();
        let maps = BTreeMap::from([
            (x.clone(), vx.add(&vy).unwrap()),
            (y.clone(), vy.mul(&half).unwrap()),
            (z.clone(), vz.add(&Value::one()).unwrap()),
        ]);
        let starts = BTreeMap::from([(x, Value::zero()), (y, Value::one()), (z, Value::integer(5))]);
        let found = solve_together(&maps, &starts, &n, &Assumptions::default(), &|| false).unwrap();
        let at = |place: usize, number: i64| found[place].1.at(&n, &Value::integer(number), &Assumptions::default());
        assert_eq!(at(0, 3), Some(Value::fraction(7, 4).unwrap()));
        assert_eq!(at(1, 3), Some(Value::fraction(1, 8).unwrap()));
        assert_eq!(at(2, 3), Some(Value::integer(8)));
    }
}
