//! Closed forms that depend on how two values lie to each other: the recurrence is solved in each order of them, and else
//! in either case of what would have to be known.

use std::collections::BTreeMap;

use super::either_way::{InCase, either_way};
use super::{Unknown, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Sequence, Solved};
use crate::name::Name;
use crate::value::{Atom, Relation, Sort, Value};

/// Pairs of values whose order is looked at.
pub(crate) const MOST_PAIRS: usize = 8;

/// The most parameters of which the sign is asked.
const MOST_SIGNS: usize = 2;

/// The three ways in which two values may lie to each other.
const ORDERS: [Relation; 3] = [Relation::Lss, Relation::Eq, Relation::Gtr];

/// The forms in each order of two values, or in either case of what would have to be known, where there is none without,
/// for this reason, and one in each; nothing if there is no such pair or case.
pub fn solve_in_cases(
    recurrence: &Recurrence,
    reason: &Unknown,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Vec<InCase<Solved>> {
    let zero = Value::zero();
    let in_order = |(one, other): (Value, Value)| {
        let possible = ORDERS.into_iter().filter(|order| known.decide(*order, &one, &other) != Some(false));
        let solved = possible.map(|order| {
            let mut known = known.clone();
            known.assume(order, &one, &other);
            let found = solve_until(recurrence.clone(), &known, stop).ok()?;
            Some(InCase { assumed: vec![(order, one.clone(), other.clone())], known, found })
        });
        solved.collect::<Option<Vec<_>>>().filter(|all| !all.is_empty())
    };
    let found = pairs(recurrence, &zero, &zero, known).into_iter().take(MOST_PAIRS).find_map(in_order);
    let found = found.or_else(|| in_either_way(recurrence, reason, known, stop));
    let within = |pair| within_orders(recurrence, pair, known, stop);
    found.or_else(|| signs(reason, known).into_iter().find_map(within)).unwrap_or_default()
}

fn in_either_way(
    recurrence: &Recurrence,
    reason: &Unknown,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<InCase<Solved>>> {
    let ask = |known: &Assumptions| solve_until(recurrence.clone(), known, stop).map_err(|unknown| (unknown, None));
    either_way(recurrence, known, reason, &ask, stop)
}

/// The forms in each order of two values, or in the cases that there are in each.
fn within_orders(
    recurrence: &Recurrence,
    (one, other): (Value, Value),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<InCase<Solved>>> {
    let mut found = Vec::new();
    for order in ORDERS.into_iter().filter(|order| known.decide(*order, &one, &other) != Some(false)) {
        let assumed = (order, one.clone(), other.clone());
        let mut here = known.clone();
        here.assume(order, &one, &other);
        match solve_until(recurrence.clone(), &here, stop) {
            Ok(solved) => found.push(InCase { assumed: vec![assumed], known: here, found: solved }),
            Err(reason) => {
                let cases = in_either_way(recurrence, &reason, &here, stop)?;
                found.extend(cases.into_iter().map(|case| within(&assumed, case, known)));
            }
        }
    }
    Some(found)
}

/// A case within another, which is not told where it follows.
fn within(outer: &Comparison, case: InCase<Solved>, known: &Assumptions) -> InCase<Solved> {
    let mut alone = known.clone();
    case.assumed.iter().for_each(|(relation, left, right)| alone.assume(*relation, left, right));
    let follows = alone.decide(outer.0, &outer.1, &outer.2) == Some(true);
    let outer = Some(outer.clone()).filter(|_| !follows);
    InCase { assumed: outer.into_iter().chain(case.assumed).collect(), ..case }
}

/// The sides of what is open, and its parameters, each with 0, where its sign is not known.
fn signs(reason: &Unknown, known: &Assumptions) -> Vec<(Value, Value)> {
    let Some((_, left, right)) = reason.open.as_deref() else { return Vec::new() };
    let names = left.variables().into_iter().chain(right.variables());
    let open = |value: &Value| known.decide(Relation::Gtr, value, &Value::zero()).is_none();
    let names = names.map(|name| Value::variable(&name)).filter(open).map(|value| (value, Value::zero()));
    std::iter::once((left.clone(), right.clone())).chain(names.take(MOST_SIGNS)).collect()
}

/// Pairs of values of which it is not known which is greater: where a sequence starts, and a parameter that it may
/// go to.
pub(crate) fn pairs(recurrence: &Recurrence, left: &Value, right: &Value, known: &Assumptions) -> Vec<(Value, Value)> {
    let terms: Vec<_> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let sides = sides(left, right);
    let others = parameters(recurrence, left, right);
    let starts: Vec<&Value> = recurrence.sequences.iter().flat_map(|sequence| &sequence.start).collect();
    // Of numbers the order is known.
    if others.is_empty() && starts.iter().all(|start| start.variables().is_empty()) {
        return Vec::new();
    }
    let mut found = Vec::new();
    // A comparison with one value asks for the order of the start and that value first.
    let first = sides.iter().filter(|side| terms.iter().all(|name| !side.mentions(name)));
    for other in first.cloned().chain(resting(recurrence, known)).chain(others) {
        for start in &starts {
            let symbolic = !start.variables().is_empty() || !other.variables().is_empty();
            let open = |relation| known.decide(relation, start, &other).is_none();
            let pair = ((*start).clone(), other.clone());
            if symbolic
                && other.sort() == Sort::Real
                && !other.mentions(&recurrence.index)
                && (open(Relation::Lss) || open(Relation::Eq))
                && !found.contains(&pair)
            {
                found.push(pair);
            }
        }
    }
    found.extend(steps(recurrence, known));
    found.extend(two_steps(recurrence, &sides, known));
    found.extend(first_guards(recurrence, known));
    found
}

/// The components of both sides.
fn sides(left: &Value, right: &Value) -> Vec<Value> {
    [left, right].into_iter().flat_map(|side| side.components().unwrap_or_else(|| vec![side.clone()])).collect()
}

/// The parameters in the equations and in the sides of a comparison of terms.
pub(crate) fn parameters(recurrence: &Recurrence, left: &Value, right: &Value) -> Vec<Value> {
    let terms: Vec<_> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let sides = sides(left, right);
    let values = recurrence.sequences.iter().map(|sequence| &sequence.next).chain(&sides);
    let mut found: Vec<Value> = Vec::new();
    for name in values.flat_map(Value::variables) {
        let value = Value::variable(&name);
        if !terms.contains(&name) && name != recurrence.index && !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

/// What a condition compares with 0 where the sequences start, where it is not known how it does.
fn first_guards(recurrence: &Recurrence, known: &Assumptions) -> Vec<(Value, Value)> {
    let zero = Value::zero();
    let first = |sequence: &Sequence| Some((recurrence.term(&sequence.name, 0), sequence.start.first()?.clone()));
    let starts: BTreeMap<Name, Value> = recurrence.sequences.iter().filter_map(first).collect();
    let terms: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let atoms = recurrence.sequences.iter().flat_map(|sequence| sequence.next.atoms());
    let at_start = |atom: Atom| {
        let Atom::Positive(inner) = atom else { return None };
        let value = known.simplify(&inner.substitute(&starts).ok()?);
        let free = value.variables().iter().all(|name| *name != recurrence.index && !terms.contains(name));
        (free && known.decide(Relation::Gtr, &value, &zero).is_none()).then(|| (value, zero.clone()))
    };
    let mut found: Vec<(Value, Value)> = Vec::new();
    for pair in atoms.filter_map(at_start) {
        if !found.contains(&pair) {
            found.push(pair);
        }
    }
    found
}

/// What is added in every step, and 0, where it is symbolic and its sign is not known.
fn steps(recurrence: &Recurrence, known: &Assumptions) -> Vec<(Value, Value)> {
    let terms: Vec<_> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let zero = Value::zero();
    let of = |sequence: &Sequence| {
        let step = sequence.next.sub(&Value::variable(&recurrence.term(&sequence.name, 0))).ok()?;
        let free = step.variables().iter().all(|name| *name != recurrence.index && !terms.contains(name));
        let open = [Relation::Lss, Relation::Eq].iter().any(|relation| known.decide(*relation, &step, &zero).is_none());
        (sequence.start.len() == 1 && free && open).then_some((step, zero.clone()))
    };
    recurrence.sequences.iter().filter_map(of).collect()
}

/// What is added to one sequence and to another in each step, where both are symbolic and a comparison reads both.
fn two_steps(recurrence: &Recurrence, sides: &[Value], known: &Assumptions) -> Vec<(Value, Value)> {
    let terms: Vec<_> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let of = |sequence: &Sequence| {
        let term = recurrence.term(&sequence.name, 0);
        let step = sequence.next.sub(&Value::variable(&term)).ok()?;
        let free = step.variables().iter().all(|name| *name != recurrence.index && !terms.contains(name));
        let read = sequence.start.len() == 1 && sides.iter().any(|side| side.mentions(&term));
        (free && read && step.as_rational().is_none()).then_some(step)
    };
    let steps: Vec<Value> = recurrence.sequences.iter().filter_map(of).collect();
    let pairs = steps.iter().enumerate().flat_map(|(place, one)| steps[..place].iter().map(move |other| (other, one)));
    let open = pairs.filter(|(one, other)| known.decide(Relation::Lss, one, other).is_none());
    open.map(|(one, other)| (one.clone(), other.clone())).collect()
}

/// Where a clamped motion goes to: what follows a place at which the recurrence turns, where it stays there.
fn resting(recurrence: &Recurrence, known: &Assumptions) -> Vec<Value> {
    let mut found: Vec<Value> = Vec::new();
    for sequence in recurrence.sequences.iter().filter(|sequence| sequence.start.len() == 1) {
        let term = recurrence.term(&sequence.name, 0);
        for place in turns(&sequence.next, &term) {
            let Ok(next) = sequence.next.with(&term, &place) else { continue };
            let next = known.simplify(&next);
            let stays = sequence.next.with(&term, &next).is_ok_and(|after| known.simplify(&after) == next);
            if stays && !found.contains(&next) {
                found.push(next);
            }
        }
    }
    found
}

/// The values of a term at which a maximum or a condition turns, where these are linear in it.
fn turns(next: &Value, term: &Name) -> Vec<Value> {
    let mut differences = Vec::new();
    for atom in next.atoms() {
        match atom {
            Atom::Maximum(elements) => {
                for (place, element) in elements.iter().enumerate() {
                    differences.push(element.clone());
                    differences.extend(elements[..place].iter().filter_map(|other| element.sub(other).ok()));
                }
            }
            Atom::Positive(inner) => differences.push(inner),
            _ => {}
        }
    }
    let zero = |difference: &Value| {
        let at = |number: i64| difference.with(term, &Value::integer(number)).ok();
        let (none, one, two) = (at(0)?, at(1)?, at(2)?);
        let slope = one.sub(&none).ok()?;
        (two.sub(&one).ok()? == slope && !slope.is_zero()).then(|| none.neg().ok()?.div(&slope).ok()).flatten()
    };
    differences.iter().filter_map(zero).collect()
}
