//! That no term is met because each keeps what the one before keeps: a side of the goal, or bounds that the first terms, the
//! map, and what it leaves where it is suggest. What is found is checked by induction (`closed_form`).

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::behaviour;
use super::reach::{Wanted, symbolic};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Never, Recurrence, compared, never};
use crate::exponential_polynomial::tail::Tail;
use crate::value::{Atom, Value};

/// The terms of which the least and the greatest may be bounds.
const FEW: usize = 8;
/// The terms from which a sum of what falls faster than `1/n^2` is bounded.
const SUMMED: [usize; 3] = [1, 8, 64];
/// A late index, and the parts of 1 in which a weight is rounded up.
const FAR: i64 = 1 << 20;
const PARTS: i64 = 1 << 10;

/// From which index on no term is met, by induction.
pub(super) fn kept(
    recurrence: &Recurrence,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Tail> {
    // With symbols it takes long to tell what is joined of several comparisons.
    let plain = |value: &Value| value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_)));
    if symbolic(recurrence, wanted) && !plain(&wanted.1.sub(wanted.2).ok()?) {
        return None;
    }
    let by = |bounds: &[Value]| match never(recurrence, None, wanted, (known, bounds)).ok()? {
        Never::Induction(from, region) => Some((from, region)),
        _ => None,
    };
    let tried = |bounds: Vec<Value>| if bounds.is_empty() { None } else { by(&bounds) };
    let (from, region) = by(&[]).or_else(|| tried(bounds(recurrence, known, stop)))?;
    let index = &recurrence.index;
    let from = u64::try_from(from).ok()?;
    if !region.iter().all(|(_, left, _)| plain(left)) {
        return Some(Tail::Never(from, format!("from {index} = {from} on, if one term is not, the next is not")));
    }
    let told = |comparison: &Comparison| match comparison {
        (relation, left, right) if left.as_variable().is_some() => format!("{left} {} {right}", relation.symbol()),
        _ => compared(comparison),
    };
    let region: Vec<String> = region.iter().map(told).collect();
    Some(Tail::Never(
        from,
        format!("from {index} = {from} on {}, since it is so of the term before", region.join(" and ")),
    ))
}

/// What may bound the terms of a single sequence: nothing of it is believed.
pub fn bounds(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Value> {
    if recurrence.sequences.len() != 1 {
        return Vec::new();
    }
    let mut bounds = ends(recurrence);
    let fixed = behaviour(recurrence, known, stop).fixed_points;
    bounds.extend(fixed.iter().filter_map(|point| point.neg().ok()));
    bounds.extend(fixed);
    bounds.extend(turning(recurrence));
    bounds.extend(summed(recurrence).unwrap_or_default());
    let mut seen = Vec::new();
    bounds.retain(|bound| {
        !seen.contains(bound) && {
            seen.push(bound.clone());
            true
        }
    });
    bounds
}

/// The least and the greatest of the first terms.
fn ends(recurrence: &Recurrence) -> Vec<Value> {
    let terms = recurrence.iterate(FEW).ok().filter(|all| all.len() == 1).unwrap_or_default();
    let numbers: Option<Vec<BigRational>> = terms.concat().iter().map(Value::as_rational).collect();
    let numbers = numbers.unwrap_or_default();
    let ends = [numbers.iter().min(), numbers.iter().max()];
    ends.into_iter().flatten().cloned().map(Value::rational).collect()
}

/// The greatest or least value of a map that is a square with rational coefficients.
fn turning(recurrence: &Recurrence) -> Option<Value> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let name = recurrence.term(&sequence.name, 0);
    let at = |point: i64| sequence.next.with(&name, &Value::integer(point)).ok()?.as_rational();
    let (below, middle, above) = (at(-1)?, at(0)?, at(1)?);
    let two = BigRational::from_integer(2.into());
    let square = (&above + &below) / &two - &middle;
    let slope = (above - below) / &two;
    if square.is_zero() {
        return None;
    }
    sequence.next.with(&name, &Value::rational(-slope / (two * square))).ok()
}

/// Of `u(n+1) = u(n) + g(n)` with `0 < g(n) <= c/((n+d)*(n+d+1))`: from each of some terms on `u(n) + c/(n+d)` does not grow.
fn summed(recurrence: &Recurrence) -> Option<Vec<Value>> {
    let ([sequence], index) = (recurrence.sequences.as_slice(), Value::variable(&recurrence.index)) else {
        return None;
    };
    let own = Value::variable(&recurrence.term(&sequence.name, 0));
    let step = sequence.next.sub(&own).ok()?;
    if sequence.start.len() != 1 || !step.variables().iter().all(|name| *name == recurrence.index) {
        return None;
    }
    let terms = recurrence.iterate(SUMMED.iter().max()? + 1).ok()?;
    let mut found = Vec::new();
    for count in SUMMED {
        let place = recurrence.from.checked_add(i64::try_from(count).ok()?)?;
        for shift in [1, 0, -1] {
            let shift = Value::rational(BigRational::new(shift.into(), 2.into()));
            found.extend(receding(&step, (&index, place), &shift, terms.first()?.get(count)?));
        }
    }
    Some(found)
}

/// What does not grow from an index on, where the term is this, if all steps from there on are small enough.
fn receding(step: &Value, (index, place): (&Value, i64), shift: &Value, term: &Value) -> Option<Value> {
    let next = shift.add(&Value::one()).ok()?;
    let name = index.as_variable()?;
    // What a step comes to when it is multiplied by (n+d)*(n+d+1): it goes to a limit, mostly one way.
    let whole = index.add(shift).and_then(|own| own.mul(&index.add(&next)?)).and_then(|own| own.mul(step)).ok()?;
    let at = |place: i64| whole.with(name, &Value::integer(place)).ok()?.as_rational();
    let (here, far) = (at(place)?, at(FAR)?);
    let most = if here.abs() < far.abs() { far } else { here };
    // A limit that is never reached.
    let parts = BigRational::from_integer(PARTS.into());
    let weight = (most.abs() * &parts).ceil() / parts;
    let weight = if most.is_negative() { -weight } else { weight };
    let rest = |at: &Value| Value::rational(weight.clone()).div(&at.add(shift)?);
    rest(&Value::integer(place)).and_then(|ahead| term.add(&ahead)?.sub(&rest(index)?)).ok()
}
