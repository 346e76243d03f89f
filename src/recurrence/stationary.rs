//! Fixed points of maps with symbols, of several sequences, and of higher order: solutions of polynomial equations, found by
//! factors that are variables, by substitution, and by roots of quadratic polynomials. Each is put in before it is told.

use std::cell::Cell;
use std::rc::Rc;

use num_rational::BigRational;
use num_traits::One;

use super::fixed::atoms;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence};
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::value::{Relation, Value};

/// How deep cases are taken apart, and the most points.
const DEEPEST: usize = 12;
const MOST_POINTS: usize = 16;

/// A point that is mapped to itself, with a value for each sequence, where the conditions hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stationary {
    pub point: Vec<Value>,
    pub conditions: Vec<Comparison>,
}

/// All points at which each sequence stays, wherever what is divided by on the way to them is not 0; nothing where they are not
/// found, or the equations depend on the index or are no quotients of polynomials.
pub(super) fn stationary(recurrence: &Recurrence, known: &Assumptions) -> Option<Vec<Stationary>> {
    let names: Vec<Name> = recurrence.sequences.iter().map(|one| Name::new(&format!("[{}]", one.name))).collect();
    let terms = recurrence.terms();
    let images = terms.iter().map(|(name, place, _)| Some((name.clone(), Value::variable(names.get(*place)?))));
    let images = images.collect::<Option<_>>()?;
    let mut maps = Vec::new();
    for sequence in &recurrence.sequences {
        let map = sequence.next.substitute(&images).ok()?;
        if map.mentions(&recurrence.index) || names.iter().any(|name| !atoms(&map, name).is_empty()) {
            return None;
        }
        maps.push(map);
    }
    let own = known.without_name(&recurrence.index);
    let known = terms.iter().fold(own, |known, (name, ..)| known.without_name(name));
    let equation = |(map, name): (&Value, &Name)| map.sub(&Value::variable(name)).ok()?.numerator();
    let equations = maps.iter().zip(&names).map(equation).collect::<Option<Vec<Value>>>()?;
    let (mut found, lost) = (Vec::new(), Rc::new(Cell::new(false)));
    let open = Open { equations, places: Vec::new(), conditions: Vec::new(), known, lost: Rc::clone(&lost) };
    open.solve(&names, 0, &mut found)?;
    let mut all: Vec<Stationary> = Vec::new();
    for end in found {
        for told in end.verified(&maps, &names)? {
            if !all.iter().any(|other| other.point == told.point) {
                all.push(told);
            }
        }
    }
    // That a case has none where something is supposed of parameters does not say that it has none.
    (all.len() <= MOST_POINTS && !lost.get()).then_some(all)
}

/// Equations that are to be 0, with what unknowns are already, in terms of those that are left.
#[derive(Clone)]
struct Open {
    equations: Vec<Value>,
    /// Each in terms of those that are found after it.
    places: Vec<(Name, Value)>,
    conditions: Vec<Comparison>,
    /// With the conditions.
    known: Assumptions,
    /// Whether some case had no solution under conditions.
    lost: Rc<Cell<bool>>,
}

impl Open {
    /// All solutions; nothing where they are not found.
    fn solve(mut self, names: &[Name], depth: usize, found: &mut Vec<Open>) -> Option<()> {
        if depth > DEEPEST || found.len() > MOST_POINTS {
            return None;
        }
        let free = |value: &Value| !names.iter().any(|name| value.mentions(name));
        for equation in self.equations.iter().filter(|equation| free(equation)) {
            // What holds for some parameters only is no case that is told.
            match self.known.decide(Relation::Eq, equation, &Value::zero()) {
                Some(true) => {}
                Some(false) => {
                    found.extend(self.without());
                    return Some(());
                }
                None => return None,
            }
        }
        self.equations.retain(|equation| !free(equation));
        if self.equations.is_empty() {
            // Where an unknown may be anything the points are not single ones.
            let all = names.iter().all(|name| self.places.iter().any(|(other, _)| other == name));
            return all.then(|| found.push(self));
        }
        if let Some(cases) = self.factor(names) {
            return cases.into_iter().try_for_each(|case| case.solve(names, depth + 1, found));
        }
        for place in 0..self.equations.len() {
            if let Some(cases) = self.of_one(place, names) {
                return cases.into_iter().try_for_each(|case| case.solve(names, depth + 1, found));
            }
        }
        let cases = (0..self.equations.len()).find_map(|place| self.in_cases(place, names))?;
        cases.into_iter().try_for_each(|case| case.solve(names, depth + 1, found))
    }

    /// Either a variable is 0 that divides an equation, or what is left of that is.
    fn factor(&self, names: &[Name]) -> Option<Vec<Open>> {
        self.equations.iter().enumerate().find_map(|(place, equation)| {
            let divides = |name: &&Name| {
                equation.mentions(name) && equation.with(name, &Value::zero()).is_ok_and(|value| value.is_zero())
            };
            let name = names.iter().find(divides)?;
            let mut other = self.clone();
            *other.equations.get_mut(place)? = equation.div(&Value::variable(name)).ok()?;
            Some(vec![self.placed(name, &Value::zero(), place)?, other])
        })
    }

    /// The cases of an equation that is linear in an unknown by a factor without any, or quadratic in its only one.
    fn of_one(&self, place: usize, names: &[Name]) -> Option<Vec<Open>> {
        let equation = self.equations.get(place)?;
        let free = |value: &Value| !names.iter().any(|name| value.mentions(name));
        let own: Vec<&Name> = names.iter().filter(|name| equation.mentions(name)).collect();
        for name in &own {
            let Some(coefficients) = coefficients(equation, name) else { continue };
            match coefficients.as_slice() {
                [rest, factor] if free(factor) => {
                    let Some(here) = self.given(Relation::Neq, factor) else { continue };
                    return Some(vec![here.placed(name, &rest.neg().ok()?.div(factor).ok()?, place)?]);
                }
                [rest, middle, factor] if own.len() == 1 => {
                    let Some(here) = self.given(Relation::Neq, factor) else { continue };
                    let square =
                        middle.mul(middle).ok()?.sub(&rest.mul(factor).ok()?.mul(&Value::integer(4)).ok()?).ok()?;
                    let square = here.known.simplify(&square);
                    let Some(here) = here.given(Relation::Gte, &square) else { return Some(here.without()) };
                    let root = here.known.simplify(&square.sqrt().ok()?);
                    let double = factor.mul(&Value::integer(2)).ok()?;
                    let images = [root.neg().ok()?, root].map(|side| side.sub(middle).ok()?.div(&double).ok());
                    let cases = images.into_iter().map(|image| here.placed(name, &here.known.simplify(&image?), place));
                    return cases.collect();
                }
                _ => {}
            }
        }
        None
    }

    /// The cases of an equation that is linear in an unknown, by whether its factor is 0.
    fn in_cases(&self, place: usize, names: &[Name]) -> Option<Vec<Open>> {
        let equation = self.equations.get(place)?;
        names.iter().filter(|name| equation.mentions(name)).find_map(|name| {
            let coefficients = coefficients(equation, name)?;
            let [rest, factor] = coefficients.as_slice() else { return None };
            let mut zero = self.clone();
            *zero.equations.get_mut(place)? = factor.clone();
            zero.equations.push(rest.clone());
            Some(vec![zero, self.placed(name, &rest.neg().ok()?.div(factor).ok()?, place)?])
        })
    }

    /// With a value for an unknown, from one of the equations.
    fn placed(&self, name: &Name, image: &Value, place: usize) -> Option<Open> {
        let mut here = self.clone();
        here.equations.remove(place);
        for equation in &mut here.equations {
            *equation = here.known.simplify(&equation.with(name, image).ok()?).numerator()?;
        }
        here.places.push((name.clone(), image.clone()));
        Some(here)
    }

    /// The solutions of a case that has none, which is noted where conditions are supposed in it.
    fn without<T>(&self) -> Vec<T> {
        self.lost.set(self.lost.get() || !self.conditions.is_empty());
        Vec::new()
    }

    /// Where a value compares so with 0, which may be a condition; nothing where it does not.
    fn given(&self, relation: Relation, value: &Value) -> Option<Open> {
        let mut here = self.clone();
        match here.known.decide(relation, value, &Value::zero()) {
            Some(true) => {}
            Some(false) => return None,
            None => {
                here.known.assume(relation, value, &Value::zero());
                here.conditions.push((relation, value.clone(), Value::zero()));
            }
        }
        Some(here)
    }

    /// The point, if the maps lead from it to itself, and none where they have no value there; nothing where that is not known.
    fn verified(self, maps: &[Value], names: &[Name]) -> Option<Vec<Stationary>> {
        let mut here = self;
        let mut values: Vec<(Name, Value)> = Vec::new();
        for (name, image) in here.places.iter().rev() {
            let image = values.iter().try_fold(image.clone(), |image, (other, value)| image.with(other, value));
            // Where its factor is 0 after all it is another case.
            let Ok(image) = image else { return Some(here.without()) };
            values.push((name.clone(), here.known.simplify(&image)));
        }
        let images = values.iter().cloned().collect();
        let point =
            names.iter().map(|name| values.iter().find(|(other, _)| other == name).map(|(_, value)| value.clone()));
        let point = point.collect::<Option<Vec<Value>>>()?;
        let of_maps = maps.iter().map(|map| map.denominator()?.substitute(&images).ok());
        let below = point.iter().map(Value::denominator).chain(of_maps).collect::<Option<Vec<Value>>>()?;
        for divisor in below {
            match here.given(Relation::Neq, &here.known.simplify(&divisor)) {
                Some(defined) => here = defined,
                None => return Some(here.without()),
            }
        }
        for (map, value) in maps.iter().zip(&point) {
            let image = here.known.simplify(&map.substitute(&images).ok()?);
            match here.known.decide(Relation::Eq, &image, value) {
                Some(true) => {}
                Some(false) => return Some(here.without()),
                None => return None,
            }
        }
        Some(vec![Stationary { point, conditions: here.conditions }])
    }
}

/// The coefficients of a polynomial in a variable; those of the highest power are not all 0.
fn coefficients(value: &Value, name: &Name) -> Option<Vec<Value>> {
    let parts: Vec<_> = exponentials(value, name)?.into_iter().collect();
    let [(base, coefficients)] = parts.as_slice() else { return None };
    base.as_rational().filter(BigRational::is_one)?;
    Some(coefficients.clone())
}
