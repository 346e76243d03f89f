//! Questions about a variable of which nothing is assumed, such as a reading just drawn: they do not depend on the rest.

use num_traits::Zero;

use super::Assumptions;
use super::refute::MOST_SYSTEMS;
use super::sign::Signs;
use crate::name::Name;
use crate::value::{Atom, Relation, Sort, Value};

/// Of so many facts each is asked whether the others refute it, after one more is stated.
const FEW_FACTS: usize = 6;

impl Assumptions {
    /// A value of one variable alone that can be just what this one can be, whatever the other variables are: where it
    /// speaks of a variable that no fact mentions (but the last, where that is `stated` already) only in one sum with
    /// others, as `|m-10| - 1/10` with `r+w` for m does of w, any number may stand for that sum.
    fn alone(&self, value: &Value, stated: bool) -> Option<Value> {
        let names = value.variables();
        if names.len() < 2 {
            return None;
        }
        let facts = &self.stated[..self.stated.len() - usize::from(stated)];
        let free = |name: &&Name| {
            let mentioned = self.mentions(name) && (!stated || facts.iter().any(|(_, fact)| fact.mentions(name)));
            !mentioned && !self.naturals().contains(name)
        };
        names.iter().filter(free).find_map(|name| {
            let (factor, rest) = sum_with(value, name)?;
            let own = Value::variable(name).sub(&rest).ok()?.div(&factor).ok()?;
            let image = value.with(name, &own).ok()?;
            image.variables().iter().eq([name]).then_some(image)
        })
    }

    /// The signs that the value may have, where that does not depend on what is assumed.
    pub(super) fn signs_alone(&self, value: &Value, wanted: Signs) -> Option<Signs> {
        self.alone(value, false).map(|image| Assumptions::default().possible_signs(&image, wanted))
    }

    /// Whether the assumptions are known to exclude each other, where they were not before the last was stated. Of many
    /// facts that one alone is asked; of few, each.
    pub fn contradictory_by_last(&self) -> bool {
        if self.last_is_free() {
            return false;
        }
        let last = self.stated.last().map(|(relation, value)| (*relation, self.with_solved(value)));
        let form = last.as_ref().and_then(|(relation, value)| match value.polynomials() {
            Some((numerator, denominator)) if denominator.is_one() => Some((*relation, numerator)),
            _ => None,
        });
        let many = self.constraints.len() > FEW_FACTS;
        let Some((relation, form)) = form.filter(|(relation, _)| many && *relation != Relation::Eq) else {
            return self.inconsistent();
        };
        let mut systems = MOST_SYSTEMS;
        let mut allowed = Signs::each().into_iter().filter(|sign| sign.within(Signs::of(relation)));
        self.signs.values().any(|signs| signs.is_empty())
            || allowed.all(|sign| self.refutes_form(form, sign, 1, &mut systems))
    }

    /// Whether the last fact stated can hold beside the others as well as by itself, where that is not excluded.
    fn last_is_free(&self) -> bool {
        let Some((relation, value)) = self.stated.last() else { return false };
        let image = self.alone(value, true);
        image.is_some_and(|image| {
            let wanted = Signs::of(*relation);
            let possible = Assumptions::default().possible_signs(&image, wanted);
            !possible.and(wanted).is_empty()
        })
    }
}

/// The factor of a variable, a number that is not 0, and the rest, of the first sum in a value in which it stands.
fn sum_with(value: &Value, name: &Name) -> Option<(Value, Value)> {
    let plain = |value: &Value| {
        let (factor, rest) = value.linear_in(name).filter(|_| value.sort() == Sort::Real)?;
        let number = factor.as_rational().filter(|number| !number.is_zero())?;
        let whole = rest.polynomials().is_some_and(|(_, denominator)| denominator.is_one());
        whole.then(|| (Value::rational(number), rest))
    };
    plain(value).or_else(|| {
        value.atoms().iter().filter(|atom| atom.mentions(name)).find_map(|atom| match atom {
            Atom::Maximum(parts) | Atom::Apply(_, parts) => parts.iter().find_map(|part| sum_with(part, name)),
            Atom::Positive(part) | Atom::Floor(part) | Atom::Root(part) => sum_with(part, name),
            Atom::Variable(_) | Atom::Power(..) => None,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known() -> Assumptions {
        let mut known = Assumptions::default();
        known.assume(Relation::Gte, &Value::variable(&Name::new("r")), &Value::integer(3));
        known
    }

    fn reading() -> Value {
        Value::variable(&Name::new("r")).add(&Value::variable(&Name::new("w"))).expect("a sum")
    }

    #[test]
    fn a_new_reading_may_be_anything_whatever_is_known_of_the_place() {
        let known = known();
        let off = reading().sub(&Value::integer(10)).and_then(|off| off.abs()).expect("a distance");
        assert!(known.alone(&off, false).is_some());
        assert_eq!(known.decide(Relation::Gtr, &off, &Value::integer(1)), None);
        assert_eq!(known.decide(Relation::Gte, &off, &Value::zero()), Some(true));
        assert_eq!(known.decide(Relation::Gtr, &off, &Value::integer(-1)), Some(true));
        // What is known of the reading counts.
        let mut with = known.clone();
        with.assume(Relation::Gte, &Value::variable(&Name::new("w")), &Value::integer(8));
        assert_eq!(with.alone(&off, false), None);
        assert_eq!(with.decide(Relation::Gte, &off, &Value::one()), Some(true));
    }

    #[test]
    fn the_last_fact_is_free_only_where_it_can_hold() {
        let off = reading().sub(&Value::integer(10)).and_then(|off| off.abs()).expect("a distance");
        let mut with = known();
        with.assume(Relation::Gtr, &off, &Value::one());
        assert!(with.last_is_free());
        let mut with = known();
        with.assume(Relation::Lss, &off, &Value::zero());
        assert!(!with.last_is_free());
        // Here the place is known again by what is compared.
        let place = Value::variable(&Name::new("r"));
        let mut with = known();
        with.assume(
            Relation::Gtr,
            &reading().sub(&place.mul(&place).expect("a square")).expect("a sum"),
            &Value::one(),
        );
        assert!(with.last_is_free());
        let twice = reading().add(&place.abs().expect("a size")).expect("a sum");
        assert!(known().alone(&twice.abs().expect("a size").add(&place).expect("a sum"), false).is_none());
    }
}
