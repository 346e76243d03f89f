//! Equations that go in the direction of a point and have no value at it: `r + min(w, norm(g-r))*unit(g-r)` at g.

use std::collections::BTreeMap;

use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value};

/// A distance by which equations divide, and the sequences that stay once it is 0.
pub type Resting = (Value, Vec<Name>);

/// The same recurrence where the sequences whose equations divide by a distance stay once that is 0, with each distance and
/// its sequences; none where none does, or one divides by something else that has terms.
pub fn at_rest(recurrence: &Recurrence) -> Option<(Recurrence, Vec<Resting>)> {
    let terms = recurrence.terms();
    let (mut found, mut resting): (Vec<Resting>, Recurrence) = (Vec::new(), recurrence.clone());
    for sequence in &mut resting.sequences {
        let mut own: Option<Value> = None;
        for need in sequence.next.needs() {
            let Need::Nonzero(divisor) = need else { continue };
            if !terms.iter().any(|(name, ..)| divisor.mentions(name)) {
                continue;
            }
            let one = divisor.atoms().into_iter().find(|atom| atom.value().is_ok_and(|value| value == divisor));
            let Some(Atom::Root(square)) = one else { return None };
            // A condition may have said already what comes then.
            let components = square.squares()?;
            if has_value_where_zero(&sequence.next, &components)? {
                continue;
            }
            if sequence.start.len() != 1 || own.replace(square.sqrt().ok()?).is_some() {
                return None;
            }
        }
        let Some(distance) = own else { continue };
        let here = Value::variable(&recurrence.term(&sequence.name, 0));
        sequence.next = Value::choose(Relation::Gtr, &distance, &Value::zero(), &sequence.next, &here).ok()?;
        match found.iter_mut().find(|(other, _)| *other == distance) {
            Some((_, staying)) => staying.push(sequence.name.clone()),
            None => found.push((distance, vec![sequence.name.clone()])),
        }
    }
    (!found.is_empty()).then_some((resting, found))
}

/// Whether an equation has a value where all these are 0; none where that is not found out.
fn has_value_where_zero(next: &Value, components: &[Value]) -> Option<bool> {
    let mut images: BTreeMap<Name, Value> = BTreeMap::new();
    for component in components {
        let component = component.substitute(&images).ok()?;
        if component.is_zero() {
            continue;
        }
        let name = component.variables().into_iter().find(|name| component.linear_in(name).is_some())?;
        let (slope, rest) = component.linear_in(&name)?;
        let image = rest.neg().ok()?.div(&slope).ok()?;
        // A parameter may stand in both: of `g-x` and `g-y` that x is y says what g is, too.
        for earlier in images.values_mut() {
            *earlier = earlier.with(&name, &image).ok()?;
        }
        images.insert(name, image);
    }
    Some(next.substitute(&images).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::{Sequence, term};

    #[test]
    fn each_robot_stays_at_a_goal_of_its_own_which_may_be_the_origin() {
        let index = Name::new("n");
        let names = ["rx", "ry", "qx", "qy"].map(Name::new);
        let now: Vec<Value> = names.iter().map(|name| Value::variable(&term(name, &index, 0))).collect();
        let mut sequences = Vec::new();
        for (place, goal) in [(0, [0, 0]), (2, [6, 7])] {
            let way = [0, 1].map(|axis| Value::integer(goal[axis]).sub(&now[place + axis]).expect("a way"));
            let way = Value::vector(way.to_vec()).expect("a vector");
            let length = way.norm().expect("a length");
            let speed = Value::minimum(&[Value::one(), length.clone()]).expect("a speed");
            let step = way
                .unit()
                .and_then(|unit| unit.mul(&speed))
                .and_then(|step| step.components().ok_or_else(|| crate::value::ValueError::new("no vector")))
                .expect("a step");
            for axis in [0, 1] {
                let next = now[place + axis].add(&step[axis]).expect("a place");
                sequences.push(Sequence { name: names[place + axis].clone(), start: vec![Value::integer(3)], next });
            }
        }
        let (_, found) = at_rest(&Recurrence { index, from: 0, sequences }).expect("all divide by their distances");
        assert_eq!(found.iter().map(|(_, staying)| staying.len()).collect::<Vec<_>>(), [2, 2]);
    }
}
