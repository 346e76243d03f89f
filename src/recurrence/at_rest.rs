//! Equations that go in the direction of a point and have no value at it: `r + min(w, norm(g-r))*unit(g-r)` at g.

use std::collections::BTreeMap;

use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::polynomial::{Budget, Polynomial};
use crate::value::{Atom, Need, Relation, Value};

/// The work that may go into one exact quotient.
const WORK: u64 = 20_000;

/// A distance by which equations divide.
pub struct Resting {
    /// The distance.
    pub distance: Value,
    /// The sequences whose equations do.
    pub sequences: Vec<Name>,
    /// Whether they stay once it is 0; else it depends on other conditions whether what is divided by it counts, which is
    /// taken to be 0 then.
    pub stay: bool,
}

impl Resting {
    /// What is taken to be so at that point.
    pub fn told(&self) -> String {
        let names: Vec<&str> = self.sequences.iter().map(Name::as_str).collect();
        let (verb, names) = (if names.len() == 1 { "is" } else { "are" }, names.join(", "));
        let what = match self.stay {
            true => format!("the equation has no value: there {names} {verb} taken to stay"),
            false => {
                format!("the equation of {names} may have no value: what it divides by that is taken to be 0 there")
            }
        };
        format!("where {} = 0 {what}", self.distance)
    }
}

/// The same recurrence where the sequences whose equations divide by a distance have a value once that is 0, with each distance
/// and its sequences; none where none does, or one divides by something else that has terms.
pub fn at_rest(recurrence: &Recurrence) -> Option<(Recurrence, Vec<Resting>)> {
    let terms = recurrence.terms();
    let (mut found, mut resting): (Vec<Resting>, Recurrence) = (Vec::new(), recurrence.clone());
    for sequence in &mut resting.sequences {
        let mut own: Vec<Value> = Vec::new();
        for need in sequence.next.needs().iter().flat_map(Need::apart) {
            let Need::Nonzero(divisor) = need else { continue };
            if !terms.iter().any(|(name, ..)| divisor.mentions(name)) {
                continue;
            }
            let one = divisor.atoms().into_iter().find(|atom| atom.value().is_ok_and(|value| value == divisor));
            // Beside other divisors its square may stand for it.
            let square = if let Some(Atom::Root(square)) = &one { square.clone() } else { divisor.clone() };
            // A condition may have said already what comes then.
            let components = square.squares()?;
            if has_value_where_zero(&sequence.next, &components)? {
                continue;
            }
            if sequence.start.len() != 1 {
                return None;
            }
            own.push(square);
        }
        let alone = own.len() == 1;
        for square in own {
            let distance = square.sqrt().ok()?;
            let here = match alone {
                true => Value::variable(&recurrence.term(&sequence.name, 0)),
                false => without(&sequence.next, &square)?,
            };
            sequence.next = Value::choose(Relation::Gtr, &distance, &Value::zero(), &sequence.next, &here).ok()?;
            match found.iter_mut().find(|other| other.distance == distance) {
                Some(other) => {
                    other.sequences.push(sequence.name.clone());
                    other.stay &= alone;
                }
                None => found.push(Resting { distance, sequences: vec![sequence.name.clone()], stay: alone }),
            }
        }
    }
    (!found.is_empty()).then_some((resting, found))
}

/// A value without what is divided by a length in it, of which this is the square: what stays of `r + v*(g-r)/norm(g-r)` at
/// g, where another part may go elsewhere.
fn without(value: &Value, square: &Value) -> Option<Value> {
    let (above, below) = value.polynomials()?;
    let length = Atom::Root(square.clone());
    let mut above = above.coefficients_in(&length);
    let mut below = below.coefficients_in(&length);
    let (free, once) = (above.remove(&0), above.remove(&1).unwrap_or_else(Polynomial::zero));
    let (plain, rest) = (below.remove(&0), below.remove(&1));
    if !above.is_empty() || !below.is_empty() {
        return None;
    }
    let (kept, rest) = match (plain, rest) {
        (None, Some(rest)) => (once, rest),
        // Divided by the square, once with the length as a factor.
        (Some(plain), None) => {
            let (whole, one) = square.polynomials()?;
            let divided = |all: &Polynomial<Atom>| all.divide(whole, &mut Budget::new(WORK));
            let kept = free.as_ref().map_or_else(|| Some(Polynomial::zero()), divided)?;
            (kept, one.is_one().then(|| divided(&plain)).flatten()?)
        }
        _ => return None,
    };
    Value::from_polynomials(kept, rest).ok()
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
        assert_eq!(found.iter().map(|one| one.sequences.len()).collect::<Vec<_>>(), [2, 2]);
    }
}
