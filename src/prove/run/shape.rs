//! The shapes of processes: two of one shape differ in values alone.

use std::collections::BTreeMap;

use crate::fact::Context;
use crate::name::Name;
use crate::scope::{bound_names, metavariables, read_names};
use crate::term::{Node, Parts, Term, in_some_order};
use crate::value::{Atom, Relation, Value};

/// How deep maxima and the like are looked into.
const DEEPEST: usize = 3;

/// A metavariable that nothing here mentions.
pub(super) fn unused(terms: &[&Term], count: &Value) -> Name {
    let mut taken = count.variables();
    for term in terms {
        taken.extend(metavariables(term).into_iter().chain(read_names(term)).chain(bound_names(term)));
    }
    let mut number = "?n".to_string();
    while taken.contains(&Name::new(&number)) {
        number.push('n');
    }
    Name::new(&number)
}

/// Whether two processes have one shape, and equal values in equal places; what stands side by side has none.
pub(super) fn alike(one: &Term, other: &Term, context: &Context<'_>) -> bool {
    let (parts, others) = (one.children(), other.children());
    let bare = |term: &Term, parts: &Parts<'_, Term>| {
        let stops = parts.clone().map(|_| Term::stop()).collect();
        if parts.is_empty() { term.clone() } else { term.with_children(stops) }
    };
    if parts.len() != others.len() || std::mem::discriminant(one.node()) != std::mem::discriminant(other.node()) {
        return false;
    }
    let own = joined(&bare(one, &parts), &bare(other, &others), &mut |one, other| {
        equal(one, other, context).then(|| other.clone())
    });
    if own.is_none() {
        return false;
    }
    let same = |one: &Term, other: &Term| one == other || alike(one, other, context);
    let straight = parts.zip(others).all(|(one, other)| same(one, other));
    straight
        || match (one.node(), other.node()) {
            (Node::Par(ours), Node::Par(theirs)) | (Node::Disable(ours), Node::Disable(theirs)) => {
                in_some_order(ours, theirs, &same)
            }
            _ => false,
        }
}

/// Where two processes differ, to be read aloud: the first values that are not known to be equal, else the whole.
pub(super) fn told_apart(found: &Term, wanted: &Term, context: &Context<'_>) -> String {
    let mut first: Option<(Value, Value)> = None;
    let shape = joined(found, wanted, &mut |one, other| {
        if first.is_none() && !equal(one, other, context) {
            first = Some((one.clone(), other.clone()));
        }
        Some(other.clone())
    });
    match first.filter(|_| shape.is_some()) {
        Some((found, wanted)) => format!("{wanted} was expected, and there is {found}"),
        None => format!("{wanted} was expected, and there is {found}"),
    }
}

fn equal(one: &Value, other: &Value, context: &Context<'_>) -> bool {
    let known = &context.assumptions;
    one == other
        || known.decide(Relation::Eq, one, other) == Some(true)
        || context.simplify(one) == context.simplify(other)
}

/// The process that is the first for n = 0 and the second for n = 1: its values change by some step, or are made of one
/// that does, as `min(p,a)` is of `p`, if that gives the second.
pub(super) fn between(first: &Term, second: &Term, (number, context): (&Value, &Context<'_>)) -> Option<Term> {
    let (mut moving, mut steps): (Vec<(Name, Value)>, Vec<Value>) = (Vec::new(), Vec::new());
    joined(first, second, &mut |one, other| {
        if let Ok(step) = other.sub(one)
            && !step.is_zero()
            && is_plain(&step)
        {
            // What changes by a step does so if a name that counts once in it does: `a-t` with `a`.
            let counts_once = |name: &Name| one.linear_in(name).is_some_and(|(factor, _)| factor == Value::one());
            moving.extend(one.variables().into_iter().filter(counts_once).map(|name| (name, step.clone())));
            steps.push(step);
        }
        Some(one.clone())
    })?;
    steps.dedup();
    joined(first, second, &mut |one, other| {
        if one == other {
            return Some(one.clone());
        }
        let step = other.sub(one).ok()?;
        if !is_plain(&step) {
            // What is left of a way gets less as the place does: `min(1,a-p)` by what is added to p, and p may be 0.
            let back = steps.iter().filter_map(|step| step.neg().ok());
            let names = one.variables();
            let back = back.flat_map(|step| names.iter().map(move |name| (name.clone(), step.clone())));
            let made = moving.iter().cloned().chain(back).find_map(|(name, step)| {
                let by = |value: &Value, many: &Value| {
                    let moved = step.mul(many).and_then(|moved| moved.add(&Value::variable(&name))).ok()?;
                    value.substitute(&[(name.clone(), moved)].into()).ok()
                };
                if equal(&by(one, &Value::one())?, other, context) {
                    return by(one, number);
                }
                // The first may be known more simply than it is made.
                let before = by(other, &Value::integer(-1))?;
                if equal(&before, one, context) { by(&before, number) } else { None }
            });
            if let Some(made) = made.or_else(|| part_by_part(one, other, number, DEEPEST)) {
                return Some(made);
            }
        }
        step.mul(number).and_then(|moved| moved.add(one)).ok()
    })
}

/// The value that is the first for n = 0 and the second for n = 1, if what stands in their maxima, conditions, roots and
/// integer parts changes by steps: `min(v,10-n)` of `min(v,10)` and `min(v,9)`.
fn part_by_part(one: &Value, other: &Value, number: &Value, depth: usize) -> Option<Value> {
    let folded = |value: &Value| -> Vec<Atom> {
        value.atoms().into_iter().filter(|atom| !matches!(atom, Atom::Variable(_) | Atom::Power(..))).collect()
    };
    let (mine, theirs) = (folded(one), folded(other));
    if depth == 0 || mine.is_empty() || mine.len() != theirs.len() {
        return None;
    }
    let linear = |one: &Value, other: &Value| -> Option<Value> {
        let step = other.sub(one).ok()?;
        if !is_plain(&step) {
            return part_by_part(one, other, number, depth - 1);
        }
        step.mul(number).and_then(|moved| moved.add(one)).ok()
    };
    let mut images: BTreeMap<Name, Value> = BTreeMap::new();
    for (place, (mine, theirs)) in mine.iter().zip(&theirs).enumerate() {
        let (own, others) = (mine.parts(), theirs.parts());
        if std::mem::discriminant(mine) != std::mem::discriminant(theirs) || own.len() != others.len() {
            return None;
        }
        let parts: Option<Vec<Value>> = own.into_iter().zip(others).map(|(one, other)| linear(one, other)).collect();
        images.insert(Name::new(&format!("!{place}")), mine.with_parts(parts?).ok()?);
    }
    let hidden = |value: &Value, atoms: &[Atom]| {
        let place = |atom: &Atom| atoms.iter().position(|known| known == atom);
        value.replace(&mut |atom| place(atom).map(|place| Value::variable(&Name::new(&format!("!{place}"))))).ok()
    };
    linear(&hidden(one, &mine)?, &hidden(other, &theirs)?)?.substitute(&images).ok()
}

/// The process that is the first of these for n = 0, the second for n = 1 and so on, if its values are polynomials in n
/// that fewer of them give: by Newton's forward differences.
pub(super) fn polynomial(states: &[Term], number: &Value) -> Option<Term> {
    let (first, others) = states.split_first()?;
    let mut columns: Vec<Vec<Value>> = Vec::new();
    joined(first, first, &mut |value, _| {
        columns.push(vec![value.clone()]);
        Some(value.clone())
    })?;
    for state in others {
        let mut place = 0;
        joined(first, state, &mut |value, other| {
            columns.get_mut(place)?.push(other.clone());
            place += 1;
            Some(value.clone())
        })?;
    }
    let mut columns = columns.iter();
    joined(first, first, &mut |_, _| newton(columns.next()?, number))
}

/// The polynomial in n that has these values at 0, 1, …, of a degree that leaves one of them over at least.
fn newton(values: &[Value], number: &Value) -> Option<Value> {
    let (mut sum, mut chosen) = (values.first()?.clone(), Value::one());
    let mut row = values.to_vec();
    for degree in 0.. {
        row = row.windows(2).map(|pair| pair[1].sub(&pair[0])).collect::<Result<_, _>>().ok()?;
        let first = row.first()?;
        if row.iter().all(Value::is_zero) {
            break;
        }
        let next = number.sub(&Value::integer(degree)).and_then(|factor| factor.div(&Value::integer(degree + 1)));
        chosen = chosen.mul(&next.ok()?).ok()?;
        sum = sum.add(&first.mul(&chosen).ok()?).ok()?;
    }
    Some(sum)
}

/// Whether no maximum, condition or integer part stands in it.
fn is_plain(value: &Value) -> bool {
    value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_) | Atom::Power(..)))
}

/// Two processes of one shape as one, with values made of theirs.
pub(super) fn joined(one: &Term, other: &Term, join: &mut dyn FnMut(&Value, &Value) -> Option<Value>) -> Option<Term> {
    let (parts, others) = (one.children(), other.children());
    let bare = |term: &Term, parts: &Parts<'_, Term>| {
        let stops = parts.clone().map(|_| Term::stop()).collect();
        let plain = if parts.is_empty() { term.clone() } else { term.with_children(stops) };
        plain.map_values(&mut |_| Ok::<_, ()>(Value::zero())).ok()
    };
    if parts.len() != others.len() || one.values().len() != other.values().len() {
        return None;
    }
    if bare(one, &parts) != bare(other, &others) {
        return None;
    }
    let mut values = Vec::new();
    for (mine, theirs) in one.values().zip(other.values()) {
        values.push(join(mine, theirs)?);
    }
    let mut values = values.into_iter();
    let shape = one.map_values(&mut |_| values.next().ok_or(())).ok()?;
    if parts.is_empty() {
        return Some(shape);
    }
    let all: Option<Vec<Term>> = parts.into_iter().zip(others).map(|(one, other)| joined(one, other, join)).collect();
    Some(shape.with_children(all?))
}
