//! Recurrences of one or more sequences: which method fits, and the check of what it gives.

use std::collections::BTreeSet;

use super::counted::counted;
use super::cycle::repeating;
use super::difference::by_difference;
use super::driven::driven;
use super::fractional::fractional;
use super::from_zero::{at_own_index, begins, from_zero};
use super::grouped::grouped;
use super::in_pieces::in_pieces;
use super::inhomogeneous::first_order;
use super::interleaved::interleaved;
use super::itinerary::itineraries;
use super::line::straight;
use super::linear::System;
use super::modes::in_modes;
use super::modulo::modulo;
use super::nested::{Layers, nested};
use super::parts::{each_group, read_off};
use super::product::with_product;
use super::ranges::in_ranges;
use super::rotation::{rotation, with_signs};
use super::settled::after_a_start;
use super::switching::switching;
use super::symbolic::symbolic;
use super::turns::{as_one, cycle, in_turns, turning};
use super::{Comparison, Unknown, solve};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Sequence, Solved, Unchecked};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The furthest from 0 that a first index may lie.
const MOST_SHIFT: i64 = 1000;

/// The most terms on which a next one may depend.
const MOST_TERMS: usize = 150;

impl From<Unchecked> for Unknown {
    fn from(unchecked: Unchecked) -> Unknown {
        Unknown::because(unchecked.0)
    }
}

/// Checked closed forms of a recurrence.
///
/// # Errors
/// When none are found, with what stands in the way.
pub fn solve_all(recurrence: Recurrence, known: &Assumptions) -> Result<Solved, Unknown> {
    solve_until(recurrence, known, &|| false)
}

/// The same, as long as `stop` does not say that it is to end.
///
/// # Errors
/// As [`solve_all`], and where it was stopped.
pub fn solve_until(recurrence: Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Result<Solved, Unknown> {
    if recurrence.from.abs() > MOST_SHIFT {
        return Err(Unknown::because(format!("the first index is {}, too far from 0", recurrence.from)));
    }
    let size = recurrence.terms().len();
    if size > MOST_TERMS {
        return Err(Unknown::because(format!(
            "{size} terms depend on each other, and no more than {MOST_TERMS} are looked at"
        )));
    }
    go_on(stop)?;
    let moved = from_zero(&recurrence)?;
    let known = &with_signs(&moved, known.without_name(&recurrence.index));
    let checked = |(forms, conditions): Found| {
        let own = |form| begins(form, &moved.index, &recurrence);
        let forms = forms.into_iter().map(own).collect::<Result<Vec<_>, _>>()?;
        Ok::<_, Unknown>(with_fewest(&recurrence, forms, conditions, known)?)
    };
    let reason = match by_methods(&moved, known, stop, &checked) {
        Ok(solved) => return Ok(solved),
        Err(reason) => reason,
    };
    go_on(stop)?;
    // What is read off the other sequences, and sequences that have nothing to do with each other.
    let read_off = read_off(&moved, known, stop).and_then(|found| checked(found).ok());
    let found = read_off
        .or_else(|| checked(each_group(&moved, known, stop)?).ok())
        .or_else(|| checked(driven(&moved, known, stop)?).ok());
    let with_one = |one: Recurrence, known: &Assumptions| solve_until(one, known, stop).ok();
    found
        .or_else(|| grouped(&recurrence, known, &with_one))
        .or_else(|| after_a_start(&recurrence, &reason, known, stop))
        .or_else(|| counted(&moved, (known, stop), &checked))
        .map_or_else(|| by_difference(&moved, reason, (known, stop), &checked), Ok)
        .map_err(|reason| at_own_index(reason, &recurrence, &moved.index))
}

/// Forms that can be checked, without those conditions that they do not need: what they were found by may have divided by
/// something that they do not.
fn with_fewest(
    recurrence: &Recurrence,
    forms: Vec<Form>,
    conditions: Vec<Comparison>,
    known: &Assumptions,
) -> Result<Solved, Unchecked> {
    let mut solved = Solved::check(recurrence.clone(), forms.clone(), conditions.clone(), known)?;
    for condition in conditions.iter().filter(|(relation, ..)| *relation == Relation::Neq) {
        let others = solved.conditions().iter().filter(|other| *other != condition).cloned().collect();
        if let Ok(fewer) = Solved::check(recurrence.clone(), forms.clone(), others, known)
            && fewer.conditions().len() < solved.conditions().len()
        {
            solved = fewer;
        }
    }
    Ok(solved)
}

/// The first forms that can be checked, of a recurrence that begins at 0.
fn by_methods(
    moved: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
    checked: &dyn Fn(Found) -> Result<Solved, Unknown>,
) -> Result<Solved, Unknown> {
    if let Some(solved) = in_ranges(moved, known, stop).into_iter().find_map(|found| checked(found).ok()) {
        return Ok(solved);
    }
    if let Some((form, conditions)) = modulo(moved, known, stop)
        && let Ok(solved) = checked((vec![form], conditions))
    {
        return Ok(solved);
    }
    let reason = match found(moved, known, stop).and_then(checked) {
        Ok(solved) => return Ok(solved),
        Err(reason) => reason,
    };
    if let Ok(Some(form)) = nested(moved)
        && let Ok(solved) = checked((vec![form], Vec::new()))
    {
        return Ok(solved);
    }
    let turning = rotation(moved, known);
    let numbers = moved.iterate(2).is_ok_and(|terms| terms.iter().flatten().all(|term| term.as_rational().is_some()));
    if let (Ok(Some(all)), false) = (&turning, numbers)
        && let Some(solved) = all.iter().find_map(|found| checked(found.clone()).ok())
    {
        return Ok(solved);
    }
    let general = reason.reason.contains("not linear");
    let reason = match switching(moved, known, stop) {
        Ok(all) => {
            let mut reason = reason;
            for found in all {
                match checked(found) {
                    Ok(solved) => return Ok(solved),
                    Err(more) if general => reason = more,
                    Err(_) => {}
                }
            }
            reason
        }
        Err(more) if general => more,
        Err(_) => reason,
    };
    let reason = match in_modes(moved, known, stop) {
        Ok(all) => match all.into_iter().find_map(|found| checked(found).ok()) {
            Some(solved) => return Ok(solved),
            None => reason,
        },
        Err(more) if more.open.is_some() => more,
        Err(_) => reason,
    };
    let reason = match straight(moved, known).map(|found| found.map(checked)) {
        Ok(Some(Ok(solved))) => return Ok(solved),
        // That may be asked in either case.
        Err(more) if more.open.is_some() => more,
        _ => reason,
    };
    coming_round(moved, (known, stop), (turning, reason), checked)
}

/// The forms of what comes round: its terms, the regions that it goes through, or a rotation, if that is known; else the reason.
fn coming_round(
    moved: &Recurrence,
    (known, stop): (&Assumptions, &dyn Fn() -> bool),
    (turning, reason): (Result<Option<Vec<Found>>, Unknown>, Unknown),
    checked: &dyn Fn(Found) -> Result<Solved, Unknown>,
) -> Result<Solved, Unknown> {
    let repeating = repeating(moved).unwrap_or_default();
    if let Some(solved) = repeating.into_iter().find_map(|forms| checked((forms, Vec::new())).ok()) {
        return Ok(solved);
    }
    let all = itineraries(moved, known, stop).into_iter().map(|forms| (forms, Vec::new()));
    let (rotated, reason) = match turning {
        Ok(all) => (all.unwrap_or_default(), reason),
        Err(asked) => (Vec::new(), asked),
    };
    all.chain(rotated).find_map(|found| checked(found).ok()).ok_or(reason)
}

/// An error where the work is to end.
pub(super) fn go_on(stop: &dyn Fn() -> bool) -> Result<(), Unknown> {
    if stop() { Err(interrupted()) } else { Ok(()) }
}

pub(super) fn interrupted() -> Unknown {
    Unknown::because("interrupted")
}

pub(super) type Found = (Vec<Form>, Vec<Comparison>);

/// The forms of a recurrence that begins at 0.
pub(super) fn found(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Result<Found, Unknown> {
    go_on(stop)?;
    let count = cycle(recurrence);
    if count > 1 {
        return Ok((in_turns(recurrence, count, known, stop)?, Vec::new()));
    }
    if let Some(system) = System::of(recurrence) {
        return Ok((system.forms(stop)?, Vec::new()));
    }
    if let [sequence] = recurrence.sequences.as_slice() {
        return match alone(sequence, recurrence, known, stop) {
            // A product whose factors meet again is a quotient of polynomials.
            Ok((form @ Form::Product(..), conditions)) => match nested(recurrence)? {
                Some(plain @ Form::Value(..)) => Ok((vec![plain], conditions)),
                _ => Ok((vec![form], conditions)),
            },
            Ok((form, conditions)) => Ok((vec![form], conditions)),
            Err(reason) => Ok((vec![nested(recurrence)?.ok_or(reason)?], Vec::new())),
        };
    }
    one_after_the_other(recurrence, known, stop)
}

/// Sequences of which each depends on itself and earlier ones only.
fn one_after_the_other(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Found, Unknown> {
    let mut rest: Vec<usize> = (0..recurrence.sequences.len()).collect();
    let mut forms: Vec<Option<Form>> = vec![None; rest.len()];
    let mut conditions = Vec::new();
    let mut open = recurrence.clone();
    let variables = recurrence.terms();
    let mut layers = Layers::none();
    while !rest.is_empty() {
        let free = |place: &usize| {
            let next = &open.sequences[*place].next;
            variables.iter().all(|(name, own, _)| own == place || !next.mentions(name))
        };
        let Some(place) = rest.iter().copied().find(|place| free(place)) else {
            let group = Recurrence {
                index: open.index.clone(),
                from: 0,
                sequences: rest.iter().map(|place| open.sequences[*place].clone()).collect(),
            };
            if layers.are_read(&group) {
                return Err(Layers::no_form(&group));
            }
            let (own, more) = together(&group, known, stop)?;
            conditions.extend(more);
            for (place, form) in rest.iter().zip(own) {
                forms[*place] = Some(form);
            }
            break;
        };
        rest.retain(|other| *other != place);
        let single = Recurrence { index: open.index.clone(), from: 0, sequences: vec![open.sequences[place].clone()] };
        let form = match layers.above(&single)? {
            Some(form) => form,
            None => {
                let (mut own, more) = match by_ranges(&single, known, stop) {
                    Some(found) => found,
                    None => {
                        found(&single, known, stop).or_else(|reason| by_itself(&single, known, stop).ok_or(reason))?
                    }
                };
                conditions.extend(more);
                let Some(form) = own.pop() else { continue };
                form
            }
        };
        let read = |(name, own, _): &(Name, usize, usize)| {
            *own == place && rest.iter().any(|other| open.sequences[*other].next.mentions(name))
        };
        let form = if variables.iter().any(read) { by_first_terms(form, &single) } else { form };
        if let Form::Pieces(pieces) = &form
            && let Some((own, more)) = in_pieces(&open, (place, pieces), &rest, (known, stop))?
        {
            conditions.extend(more);
            rest.iter().zip(own).for_each(|(place, form)| forms[*place] = Some(form));
            forms[place] = Some(form);
            break;
        }
        for (name, _, offset) in variables.iter().filter(|(_, own, _)| *own == place) {
            if !rest.iter().any(|other| open.sequences[*other].next.mentions(name)) {
                continue;
            }
            let value = match &form {
                Form::Turns(turns) => as_one(turns, &open.index, *offset)?,
                form => layers.value(form, &open.index, *offset)?,
            };
            let value = value.ok_or_else(|| {
                Unknown::because(format!("the form of {} cannot be put into the others", open.sequences[place].name))
            })?;
            for other in &rest {
                open.sequences[*other].next = open.sequences[*other].next.with(name, &value)?;
            }
        }
        forms[place] = Some(form);
    }
    Ok((forms.into_iter().flatten().collect(), conditions))
}

/// A form that others read, with first terms of its own as pieces of one term each, or in turns.
fn by_first_terms(form: Form, single: &Recurrence) -> Form {
    let (early, last) = match &form {
        Form::Value(early, last) => (early, Some(last.clone())),
        Form::Sum(early, sum) => (early, sum.value(&single.index)),
        _ => return form,
    };
    let (false, Some(last)) = (early.is_empty(), last) else { return turning(form, single) };
    let rest = Piece { from: place(early.len()), until: None, form: last };
    Form::Pieces(of_one_term_each(early).chain([rest]).collect())
}

fn place(index: usize) -> Value {
    Value::integer(i64::try_from(index).unwrap_or(i64::MAX))
}

/// The first terms as pieces.
pub(super) fn of_one_term_each(terms: &[Value]) -> impl Iterator<Item = Piece> {
    let terms = terms.iter().cloned().enumerate();
    terms.map(|(index, form)| Piece { from: place(index), until: Some(place(index + 1)), form })
}

/// One sequence whose equation is the same for all indices, by any method there is.
fn by_itself(single: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    if single.sequences.iter().any(|sequence| sequence.next.mentions(&single.index)) {
        return None;
    }
    let solved = solve_until(single.clone(), known, stop).ok()?;
    Some((solved.forms().to_vec(), solved.conditions().to_vec()))
}

/// One sequence whose conditions, now that others are put in, depend on the index alone.
fn by_ranges(single: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    let [sequence] = single.sequences.as_slice() else { return None };
    let term = single.term(&sequence.name, 0);
    let mut conditions = Vec::new();
    for atom in sequence.next.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_) | Atom::Maximum(_))) {
        conditions.push((atom.mentions(&single.index), atom.mentions(&term)));
    }
    if conditions.is_empty() || conditions.iter().any(|(index, own)| !index || *own) {
        return None;
    }
    let is_one =
        |(forms, conditions): &Found| Solved::check(single.clone(), forms.clone(), conditions.clone(), known).is_ok();
    in_ranges(single, known, stop).into_iter().find(is_one)
}

/// Sequences that depend on each other.
fn together(group: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Result<Found, Unknown> {
    if let Some(system) = System::of(group) {
        return Ok((system.forms(stop)?, Vec::new()));
    }
    let names: Vec<&str> = group.sequences.iter().map(|sequence| sequence.name.as_str()).collect();
    symbolic(group, known)?.ok_or_else(|| Unknown::because(coupled(group, &names)))
}

/// Why sequences that depend on each other have no form.
fn coupled(group: &Recurrence, names: &[&str]) -> String {
    let variables = group.terms();
    // In all of them together: no coefficient reads another.
    let free = |factor: &Value| variables.iter().all(|(name, ..)| !factor.mentions(name));
    let linear = group.sequences.iter().all(|sequence| {
        let linear = |name: &Name| sequence.next.linear_in(name).is_some_and(|(factor, _)| free(&factor));
        variables.iter().all(|(name, ..)| !sequence.next.mentions(name) || linear(name))
    });
    let names = names.join(", ");
    if variables.len() > super::linear::MOST_VARIABLES {
        return format!("{} terms depend on each other, too many", variables.len());
    }
    if linear {
        format!("{names} depend on each other, and their coefficients or inputs depend on {}", group.index)
    } else {
        format!("{names} depend on each other, and not linearly")
    }
}

/// One sequence.
fn alone(
    sequence: &Sequence,
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<(Form, Vec<Comparison>), Unknown> {
    let index = &recurrence.index;
    let [start] = sequence.start.as_slice() else { return of_higher_order(sequence, recurrence, known, stop) };
    let name = recurrence.term(&sequence.name, 0);
    let mut general = known.clone();
    general.assume_natural(index);
    let next = general.simplify(&sequence.next);
    if let Some((factor, input)) = next.linear_in(&name) {
        if !factor.mentions(index) {
            let linear = first_order(&factor, &input, start, index, known)?;
            if let Some(linear) = linear {
                return Ok(linear);
            }
        }
        return Ok((with_product(&factor, &input, start, index)?, Vec::new()));
    }
    if next.mentions(index) {
        return Err(Unknown::because(format!("it is not linear in {name} and depends on {index}")));
    }
    let quotient = fractional(&next, &name, start, index, known);
    if let Ok(Some(found)) = quotient {
        return Ok(found);
    }
    by_pieces(&next, &name, start, index, known).map_err(|reason| quotient.err().unwrap_or(reason))
}

/// One sequence whose next term depends on more than one before it.
fn of_higher_order(
    sequence: &Sequence,
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<(Form, Vec<Comparison>), Unknown> {
    if let Some(found) = interleaved(sequence, recurrence, known, stop)? {
        return Ok(found);
    }
    match symbolic(recurrence, known)?.map(|(forms, conditions)| (forms.into_iter().next(), conditions)) {
        Some((Some(form), conditions)) => Ok((form, conditions)),
        _ => Err(Unknown::because(format!(
            "of the order {} closed forms are known where the equation is linear, and its coefficients are the same for all {} or a hypergeometric solution takes it apart",
            sequence.start.len(),
            recurrence.index
        ))),
    }
}

/// A map that does not depend on the index.
fn by_pieces(
    map: &Value,
    name: &Name,
    start: &Value,
    index: &Name,
    known: &Assumptions,
) -> Result<(Form, Vec<Comparison>), Unknown> {
    let closed = solve(map, name, start, index, known)?;
    let mut known = known.clone();
    closed.conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    // A piece of no length is none.
    let empty = |piece: &Piece| {
        let equal = |until: &Value| known.decide(Relation::Lte, until, &piece.from) == Some(true);
        piece.until.as_ref().is_some_and(equal)
    };
    let mut pieces = closed.pieces;
    pieces.retain(|piece| !empty(piece));
    let unique: BTreeSet<Comparison> = closed.conditions.into_iter().collect();
    Ok((Form::Pieces(pieces), unique.into_iter().collect()))
}
