//! A first index that depends on how two values lie to each other: the recurrence is solved in each order of them, and
//! where both orders give the same but for the side, that is written as one.

use std::collections::BTreeMap;

use super::solve::found_lines;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Sequence, Solved};
use crate::lower::Question;
use crate::name::Name;
use crate::recurrence::{Reach, reach, solve_until};
use crate::value::{Atom, Relation, Sort, Value};
use crate::verify::Merge;

/// Pairs of values whose order is looked at.
const MOST_PAIRS: usize = 8;

/// The answer in each order of two values.
pub(super) struct InOrders {
    pub(super) lines: Vec<String>,
    /// What was found in each.
    pub(super) found: Vec<Reach>,
    /// The same as one, where it can be written so.
    pub(super) merged: Option<Reach>,
}

/// One order: what is assumed, the forms, and what was found.
struct Case {
    order: Relation,
    known: Assumptions,
    title: String,
    solved: Solved,
    found: Reach,
}

/// The answer in each order of two values, where it is open without and known in each; nothing if there is no such pair.
pub(super) fn in_orders(
    question: &Question,
    solved: Option<&Solved>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<InOrders> {
    let recurrence = &question.recurrence;
    let (relation, left, right) = question.find.as_ref()?;
    let pairs = pairs(recurrence, left, right, known);
    if pairs.is_empty()
        || !matches!(reach(recurrence, solved, (*relation, left, right), known, stop), Reach::Unknown(_))
    {
        return None;
    }
    pairs.iter().take(MOST_PAIRS).find_map(|(one, other)| {
        let orders = [Relation::Lss, Relation::Eq, Relation::Gtr].into_iter();
        let mut cases = Vec::new();
        for order in orders {
            if known.decide(order, one, other) == Some(false) {
                continue;
            }
            let mut known = known.clone();
            known.assume(order, one, other);
            let solved = solve_until(recurrence.clone(), &known, stop).ok()?;
            let found = reach(recurrence, Some(&solved), (*relation, left, right), &known, stop);
            if stop() || matches!(found, Reach::Unknown(_)) {
                return None;
            }
            cases.push(Case { order, known, title: format!("{one} {} {other}", order.symbol()), solved, found });
        }
        told(&cases, question, (one, other))
    })
}

/// The forms in each order of two values, where there is none without and one in each; nothing if there is no such pair.
pub(super) fn forms_in_orders(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Vec<(String, Solved)>> {
    let zero = Value::zero();
    pairs(recurrence, &zero, &zero, known).iter().take(MOST_PAIRS).find_map(|(one, other)| {
        let orders = [Relation::Lss, Relation::Eq, Relation::Gtr].into_iter();
        let possible = orders.filter(|order| known.decide(*order, one, other) != Some(false));
        let solved = possible.map(|order| {
            let mut known = known.clone();
            known.assume(order, one, other);
            Some((format!("{one} {} {other}", order.symbol()), solve_until(recurrence.clone(), &known, stop).ok()?))
        });
        solved.collect::<Option<Vec<_>>>().filter(|all| !all.is_empty())
    })
}

/// Pairs of values of which it is not known which is greater: where a sequence starts, and a parameter that it may
/// go to.
fn pairs(recurrence: &Recurrence, left: &Value, right: &Value, known: &Assumptions) -> Vec<(Value, Value)> {
    let terms: Vec<_> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let sides: Vec<Value> =
        [left, right].into_iter().flat_map(|side| side.components().unwrap_or_else(|| vec![side.clone()])).collect();
    let values = recurrence.sequences.iter().map(|sequence| &sequence.next).chain(&sides);
    let mut others: Vec<Value> = Vec::new();
    for name in values.flat_map(Value::variables) {
        let value = Value::variable(&name);
        if !terms.contains(&name) && name != recurrence.index && !others.contains(&value) {
            others.push(value);
        }
    }
    let starts: Vec<&Value> = recurrence.sequences.iter().flat_map(|sequence| &sequence.start).collect();
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
    found.extend(first_guards(recurrence, known));
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

fn told(cases: &[Case], question: &Question, (one, other): (&Value, &Value)) -> Option<InOrders> {
    let recurrence = &question.recurrence;
    let (relation, left, right) = question.find.as_ref()?;
    let mut lines = Vec::new();
    for case in cases {
        lines.push(format!("if {}:", case.title));
        lines.extend(case.solved.lines().into_iter().map(|line| format!("  {line}")));
        let found = found_lines(&case.found, recurrence, (*relation, left, right));
        lines.extend(found.into_iter().map(|line| format!("  {line}")));
    }
    let merged = merged(cases, one, other);
    if let Some(found) = &merged {
        let all = found_lines(found, recurrence, (*relation, left, right));
        lines.extend(
            all.into_iter().enumerate().map(
                |(place, line)| {
                    if place == 0 { format!("in every order: {line}") } else { line }
                },
            ),
        );
    }
    (!cases.is_empty()).then(|| InOrders {
        lines,
        found: cases.iter().map(|case| case.found.clone()).collect(),
        merged,
    })
}

/// What was found in all orders, as one: it must be what was found in each, under what is assumed there.
fn merged(cases: &[Case], one: &Value, other: &Value) -> Option<Reach> {
    let of = |order: Relation| cases.iter().find(|case| case.order == order);
    let (below, above) = (of(Relation::Lss)?, of(Relation::Gtr)?);
    let merge = Merge { difference: one.sub(other).ok()?, above: above.known.clone(), below: below.known.clone() };
    let (Reach::At(first, before), Reach::At(second, after)) = (&above.found, &below.found) else { return None };
    let at = merge.values(first, second)?;
    if before.len() != after.len() {
        return None;
    }
    let pair = |((relation, left, right), (own, low, high)): (&Comparison, &Comparison)| {
        Some((*relation, merge.values(left, low)?, merge.values(right, high)?)).filter(|_| relation == own)
    };
    let conditions = before.iter().zip(after).map(pair).collect::<Option<Vec<Comparison>>>()?;
    // It must have a value in each of them.
    if !cases.iter().all(|case| at.needs().iter().all(|need| case.known.grants(need) == Some(true))) {
        return None;
    }
    // Where both are equal the conditions must hold, and the index be the same.
    let same = of(Relation::Eq).is_none_or(|equal| {
        let known = |value: &Value| equal.known.simplify(value);
        let met = |(relation, left, right): &Comparison| {
            equal.known.decide(*relation, &known(left), &known(right)) == Some(true)
        };
        let Reach::At(here, none) = &equal.found else { return false };
        none.is_empty()
            && conditions.iter().all(met)
            && equal.known.decide(Relation::Eq, &known(&at), here) == Some(true)
    });
    same.then_some(Reach::At(at, conditions))
}
