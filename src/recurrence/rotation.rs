//! Two steps of fixed size against each other, `if x(n) > c then x(n)-p else x(n)+q`, as of a tank that is filled and drained
//! or of a heater that is switched on and off: modulo p+q both are the same step, so from when the terms lie between c-p
//! and c+q they are a rotation, `c+q-mod(c+q-x+p*n, p+q)`; before that they go straight there.

use super::Unknown;
use super::sequences::Found;
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence};
use crate::name::Name;
use crate::value::{Atom, Relation, Value, ValueError};

/// Steps down above a bound and up below it.
struct Steps {
    bound: Value,
    /// Whether the step at the bound itself goes down.
    at_bound: bool,
    down: Value,
    up: Value,
}

impl Steps {
    fn of(next: &Value, name: &Name) -> Option<Steps> {
        let mark = Name::new("[above]");
        let mut parts = next.atoms().into_iter().filter(|atom| atom.mentions(name));
        let conditions: Vec<Atom> = parts.by_ref().filter(|atom| *atom != Atom::Variable(name.clone())).collect();
        let [part @ Atom::Positive(inner)] = conditions.as_slice() else { return None };
        let (change, rest) = next.with_atom(part, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
        let step = rest.sub(&Value::variable(name)).ok()?;
        let (slope, constant) = inner.linear_in(name)?;
        if [&change, &step, &slope].iter().any(|value| value.mentions(name)) {
            return None;
        }
        let bound = constant.neg().and_then(|constant| constant.div(&slope)).ok()?;
        let other = step.add(&change).ok()?;
        // With a slope below 0 the condition is that of the values below the bound.
        let [plain, turned] = [
            Steps { bound: bound.clone(), at_bound: false, down: other.neg().ok()?, up: step.clone() },
            Steps { bound, at_bound: true, down: step.neg().ok()?, up: other },
        ];
        match slope.as_rational() {
            Some(number) if num_traits::Signed::is_positive(&number) => Some(plain),
            Some(_) => Some(turned),
            None => None,
        }
    }

    /// The terms from a first one on, once they lie between the bounds: by steps down from above, and by steps up from below.
    fn rotated(&self, start: &Value, above: bool, index: &Value) -> Result<Value, ValueError> {
        let around = self.down.add(&self.up)?;
        let step = if above { self.down.neg()? } else { self.up.clone() };
        let there = start.add(&index.mul(&step)?)?;
        if self.at_bound {
            let least = self.bound.sub(&self.down)?;
            return least.add(&modulo(&there.sub(&least)?, &around)?);
        }
        let most = self.bound.add(&self.up)?;
        most.sub(&modulo(&most.sub(&there)?, &around)?)
    }

    /// The straight way from a first term, and the first index on the other side.
    fn straight(&self, start: &Value, above: bool, index: &Value) -> Result<(Value, Value), ValueError> {
        let one = Value::one();
        if above {
            let way = start.sub(&self.bound)?.div(&self.down)?;
            let count = if self.at_bound { way.floor()?.add(&one)? } else { ceiling(&way)? };
            return Ok((start.sub(&index.mul(&self.down)?)?, count));
        }
        let way = self.bound.sub(start)?.div(&self.up)?;
        let count = if self.at_bound { ceiling(&way)? } else { way.floor()?.add(&one)? };
        Ok((start.add(&index.mul(&self.up)?)?, count))
    }
}

fn modulo(value: &Value, around: &Value) -> Result<Value, ValueError> {
    value.sub(&around.mul(&value.div(around)?.floor()?)?)
}

fn ceiling(value: &Value) -> Result<Value, ValueError> {
    value.neg()?.floor()?.neg()
}

/// The forms of one sequence with two such steps; none where its steps are others.
///
/// # Errors
/// Where it must be known which way a step goes, or on which side the first term lies.
pub(super) fn rotation(recurrence: &Recurrence, known: &Assumptions) -> Result<Option<Vec<Found>>, Unknown> {
    let [sequence] = recurrence.sequences.as_slice() else { return Ok(None) };
    let [start] = sequence.start.as_slice() else { return Ok(None) };
    let name = recurrence.term(&sequence.name, 0);
    let Some(steps) = Steps::of(&sequence.next, &name) else { return Ok(None) };
    let index = Value::variable(&recurrence.index);
    if [&steps.bound, &steps.down, &steps.up].iter().any(|value| value.mentions(&recurrence.index)) {
        return Ok(None);
    }
    let zero = Value::zero();
    for step in [&steps.down, &steps.up] {
        match known.decide(Relation::Gtr, step, &zero) {
            Some(true) => {}
            Some(false) => return Ok(None),
            None => return Err(Unknown::undecided(Relation::Gtr, step, &zero)),
        }
    }
    let (least, most) = (steps.bound.sub(&steps.down)?, steps.bound.add(&steps.up)?);
    let (from, until) = if steps.at_bound { (Relation::Gte, Relation::Lss) } else { (Relation::Gtr, Relation::Lte) };
    if known.decide(from, start, &least) == Some(true) && known.decide(until, start, &most) == Some(true) {
        let rotated = known.simplify(&steps.rotated(start, true, &index)?);
        return Ok(Some(vec![(vec![Form::Value(Vec::new(), rotated)], Vec::new())]));
    }
    let above = if steps.at_bound { Relation::Gte } else { Relation::Gtr };
    let Some(side) = known.decide(above, start, &steps.bound) else {
        return Err(Unknown::undecided(above, start, &steps.bound));
    };
    let rotated = known.simplify(&steps.rotated(start, side, &index)?);
    let (form, count) = steps.straight(start, side, &index)?;
    let count = known.simplify(&count);
    let pieces =
        vec![Piece { from: zero, until: Some(count.clone()), form }, Piece { from: count, until: None, form: rotated }];
    Ok(Some(vec![(vec![Form::Pieces(pieces)], Vec::new())]))
}

/// What is known, with what follows of the parameters of two such steps: that each is above 0, if it is. What an integer part
/// is between is known of a divisor of which that is said.
pub(super) fn with_signs(recurrence: &Recurrence, mut known: Assumptions) -> Assumptions {
    let [sequence] = recurrence.sequences.as_slice() else { return known };
    let name = recurrence.term(&sequence.name, 0);
    if Steps::of(&sequence.next, &name).is_none() {
        return known;
    }
    for name in sequence.next.variables().into_iter().filter(|other| *other != name && *other != recurrence.index) {
        let (value, zero) = (Value::variable(&name), Value::zero());
        if known.decide(Relation::Gtr, &value, &zero) == Some(true) {
            known.assume(Relation::Gtr, &value, &zero);
        }
    }
    known
}
