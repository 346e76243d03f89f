//! What depends on order: `max`, `min`, `abs`, `if`.
//!
//! Every maximum is a polynomial plus multiples of atoms `max(0, d1, …)`. A maximum within a maximum is taken apart:
//! `max(a, b - max(S)) = max(a + max(S), b) - max(S)` and `max(a, b + max(0, d)) = max(a, b, b + d)`.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::{Atom, Outcome, Real, Relation, Sort, Value, ValueError};
use crate::polynomial::{Monomial, Polynomial};

/// The most elements that a maximum may get by being taken apart.
const MOST_ELEMENTS: usize = 48;
/// The most elements among which those between two others are looked for.
const MOST_BETWEEN: usize = 16;

impl Value {
    /// The greatest of some numbers.
    ///
    /// # Errors
    /// Of none, of vectors or distributions, or when the result is too large.
    pub fn maximum(elements: &[Value]) -> Result<Value, ValueError> {
        for element in elements {
            element.real()?;
        }
        let numbers: Option<Vec<BigRational>> = elements.iter().map(Value::as_rational).collect();
        if let Some(numbers) = numbers {
            let greatest = numbers.into_iter().max();
            return greatest.map(Value::rational).ok_or_else(|| ValueError::new("max of nothing"));
        }
        let (elements, offset) = take_apart(elements)?;
        flat_maximum(elements)?.sub(&offset)
    }

    /// The least of some numbers.
    ///
    /// # Errors
    /// As [`Value::maximum`].
    pub fn minimum(elements: &[Value]) -> Result<Value, ValueError> {
        let negatives = elements.iter().map(Value::neg).collect::<Result<Vec<_>, _>>()?;
        Value::maximum(&negatives)?.neg()
    }

    /// The absolute value.
    ///
    /// # Errors
    /// Of a vector or distribution.
    pub fn abs(&self) -> Result<Value, ValueError> {
        self.real()?;
        Value::maximum(&[self.clone(), self.neg()?])
    }

    /// The nearest number between two bounds: `min(max(x, low), high)`.
    ///
    /// # Errors
    /// As [`Value::maximum`].
    pub fn clamp(value: &Value, low: &Value, high: &Value) -> Result<Value, ValueError> {
        Value::minimum(&[Value::maximum(&[value.clone(), low.clone()])?, high.clone()])
    }

    /// `if left REL right then … else …`. Vectors are compared as wholes, and only for (in)equality.
    ///
    /// # Errors
    /// When the sides cannot be compared, or the branches are of different sorts.
    pub fn choose(
        relation: Relation,
        left: &Value,
        right: &Value,
        then: &Value,
        other: &Value,
    ) -> Result<Value, ValueError> {
        let condition = Value::truth(relation, left, right)?;
        if then.sort() != other.sort() {
            let text = format!("the branches of `if` differ in sort: {} and {}", then.sort(), other.sort());
            return Err(ValueError(text));
        }
        match condition.as_rational() {
            Some(number) if number.is_one() => Ok(then.clone()),
            Some(_) => Ok(other.clone()),
            None if then == other => Ok(then.clone()),
            None if then.sort() == Sort::Distribution => {
                Err(ValueError::new("`if` between distributions needs a condition that is decided"))
            }
            None => other.add(&then.sub(other)?.mul(&condition)?),
        }
    }

    /// 1 when the relation holds, 0 when it does not.
    ///
    /// # Errors
    /// When the sides cannot be compared.
    pub fn truth(relation: Relation, left: &Value, right: &Value) -> Result<Value, ValueError> {
        let opposite = |value: Value| Value::one().sub(&value);
        if let (Sort::Vector(_), Relation::Eq | Relation::Neq) = (left.sort(), relation) {
            let mut equal = Value::one();
            let difference = left.sub(right)?;
            for place in 0.. {
                let Some(part) = difference.component(place) else { break };
                equal = equal.mul(&Value::truth(Relation::Eq, &part, &Value::zero())?)?;
            }
            return if relation == Relation::Eq { Ok(equal) } else { opposite(equal) };
        }
        let difference = left.sub(right)?;
        match relation {
            Relation::Gtr => difference.positive(),
            Relation::Lss => difference.neg()?.positive(),
            Relation::Gte => opposite(difference.neg()?.positive()?),
            Relation::Lte => opposite(difference.positive()?),
            Relation::Neq => difference.positive()?.add(&difference.neg()?.positive()?),
            Relation::Eq => opposite(difference.positive()?.add(&difference.neg()?.positive()?)?),
        }
    }

    /// 1 when it is greater than 0, else 0.
    fn positive(&self) -> Outcome {
        let (numerator, _) = self.real()?;
        if let Some(number) = self.as_rational() {
            return Ok(Value::integer(i64::from(number.is_positive())));
        }
        if let Some(order) = self.coarse_order() {
            return Ok(Value::integer(i64::from(order == Ordering::Greater)));
        }
        if self.plainly_positive() {
            return Ok(Value::one());
        }
        if self.neg()?.plainly_nonnegative() {
            return Ok(Value::zero());
        }
        Atom::Positive(self.scale(&numerator.content().recip())?).value()
    }

    /// The order in which the normal form of a maximum is made: by the sign of the leading coefficient of the
    /// difference, which adding the same value to both sides does not change.
    fn formal_order(&self, other: &Value) -> Result<Ordering, ValueError> {
        let difference = self.sub(other)?;
        let (numerator, _) = difference.real()?;
        Ok(numerator.leading().cmp(&BigRational::zero()))
    }
}

/// The rational multiples of single maxima that are summands of a value.
fn summands(value: &Value) -> Vec<(BigRational, Arc<[Value]>)> {
    let Some((numerator, denominator)) = value.parts() else {
        return Vec::new();
    };
    if !denominator.is_one() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (monomial, number) in numerator.terms() {
        if let [(Atom::Maximum(elements), 1)] = monomial.factors() {
            found.push((number.clone(), elements.clone()));
        }
    }
    found
}

fn multiple(number: &BigRational, elements: &Arc<[Value]>) -> Outcome {
    let monomial = Monomial::of([(Atom::Maximum(elements.clone()), 1)]).ok_or_else(ValueError::too_large)?;
    Value::whole(Polynomial::term(monomial, number.clone()))
}

/// Elements without maxima among their summands, and what must be subtracted from their maximum.
fn take_apart(elements: &[Value]) -> Result<(Vec<Value>, Value), ValueError> {
    let mut least: BTreeMap<Arc<[Value]>, (BigRational, usize)> = BTreeMap::new();
    for element in elements {
        for (number, atom) in summands(element) {
            let entry = least.entry(atom).or_insert_with(|| (number.clone(), 0));
            entry.0 = entry.0.clone().min(number);
            entry.1 += 1;
        }
    }
    let mut offset = Value::zero();
    for (atom, (number, count)) in &least {
        // Where an element does not have the atom its coefficient there is 0.
        let number = if *count < elements.len() { number.clone().min(BigRational::zero()) } else { number.clone() };
        offset = offset.sub(&multiple(&number, atom)?)?;
    }
    let mut flat = Vec::new();
    for element in elements {
        let element = element.add(&offset)?;
        let mut choices = vec![element.clone()];
        for (number, atom) in summands(&element) {
            let mut next = Vec::new();
            for choice in &choices {
                let without = choice.sub(&multiple(&number, &atom)?)?;
                for inner in atom.iter() {
                    next.push(without.add(&inner.scale(&number)?)?);
                }
                next.push(without);
            }
            choices = next;
            if flat.len() + choices.len() > MOST_ELEMENTS {
                return Ok((elements.to_vec(), Value::zero()));
            }
        }
        flat.extend(choices);
    }
    Ok((flat, offset))
}

/// The maximum of elements of which none is to be taken apart.
fn flat_maximum(mut elements: Vec<Value>) -> Outcome {
    elements.sort();
    elements.dedup();
    let elements = undominated(elements)?;
    let mut least = elements.first().cloned().ok_or_else(|| ValueError::new("max of nothing"))?;
    for element in &elements {
        if element.formal_order(&least)? == Ordering::Less {
            least = element.clone();
        }
    }
    let mut differences = Vec::new();
    for element in elements.iter().filter(|element| **element != least) {
        differences.push(element.sub(&least)?);
    }
    if differences.is_empty() {
        return Ok(least);
    }
    let content = common_content(&differences);
    let scale = content.recip();
    let mut scaled = differences.iter().map(|part| part.scale(&scale)).collect::<Result<Vec<_>, _>>()?;
    scaled.sort();
    multiple(&content, &scaled.into())?.add(&least)
}

/// Drops each element that is plainly not greater than another.
fn undominated(elements: Vec<Value>) -> Result<Vec<Value>, ValueError> {
    let mut kept: Vec<Value> = Vec::new();
    'elements: for element in elements {
        let mut place = 0;
        while place < kept.len() {
            let difference = kept[place].sub(&element)?;
            let order = difference.coarse_order();
            if order == Some(Ordering::Greater) || difference.plainly_nonnegative() {
                continue 'elements;
            }
            if order == Some(Ordering::Less) || difference.neg()?.plainly_nonnegative() {
                kept.swap_remove(place);
            } else {
                place += 1;
            }
        }
        kept.push(element);
    }
    drop_between(&mut kept)?;
    kept.sort();
    Ok(kept)
}

/// Drops each element that lies between two others: it is never greater than both.
fn drop_between(kept: &mut Vec<Value>) -> Result<(), ValueError> {
    let mut place = 0;
    while place < kept.len() && kept.len() <= MOST_BETWEEN {
        let mut differences = Vec::new();
        for other in kept.iter().filter(|other| **other != kept[place]) {
            differences.push(other.sub(&kept[place])?);
        }
        let between = differences.iter().enumerate().any(|(count, first)| {
            differences[count + 1..].iter().any(|second| is_opposite(first, second).unwrap_or(false))
        });
        if between {
            kept.swap_remove(place);
        } else {
            place += 1;
        }
    }
    Ok(())
}

/// Whether one is a negative rational multiple of the other.
fn is_opposite(first: &Value, second: &Value) -> Result<bool, ValueError> {
    let ((top, _), (other, _)) = (first.real()?, second.real()?);
    let ratio = top.leading() / other.leading();
    Ok(ratio.is_negative() && *first == second.scale(&ratio)?)
}

/// The positive rational that leaves all numerators together with coprime integer coefficients.
fn common_content(values: &[Value]) -> BigRational {
    let numerators: Vec<&Real> = values.iter().filter_map(|value| value.parts().map(|(top, _)| top)).collect();
    let contents = numerators.iter().map(|numerator| numerator.content());
    contents.reduce(|a, b| gcd(&a, &b)).unwrap_or_else(BigRational::one)
}

fn gcd(left: &BigRational, right: &BigRational) -> BigRational {
    use num_integer::Integer;
    BigRational::new(left.numer().gcd(right.numer()), left.denom().lcm(right.denom()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    fn variable(name: &str) -> Value {
        Value::variable(&Name::new(name))
    }

    #[test]
    fn one_form_of_clamp_and_abs() {
        let (x, one) = (variable("x"), Value::one());
        let minus = Value::integer(-1);
        let inside = Value::maximum(&[Value::minimum(&[x.clone(), one.clone()]).unwrap(), minus.clone()]).unwrap();
        assert_eq!(Value::clamp(&x, &minus, &one).unwrap(), inside);
        assert_eq!(x.abs().unwrap(), x.neg().unwrap().abs().unwrap());
        assert_eq!(x.abs().unwrap().abs().unwrap(), x.abs().unwrap());
        let all = Value::maximum(&[Value::maximum(&[x.clone(), variable("y")]).unwrap(), variable("z")]).unwrap();
        let other = Value::maximum(&[x, Value::maximum(&[variable("z"), variable("y")]).unwrap()]).unwrap();
        assert_eq!(all, other);
    }

    #[test]
    fn roots_of_numbers_are_compared() {
        let root = |number: i64| Value::integer(number).sqrt().unwrap();
        let (one, three) = (Value::one(), Value::integer(3));
        assert_eq!(Value::maximum(&[Value::zero(), root(10).sub(&one).unwrap()]).unwrap(), root(10).sub(&one).unwrap());
        assert_eq!(Value::minimum(&[root(10), three.clone()]).unwrap(), three);
        let sum = root(2).add(&root(3)).unwrap();
        assert_eq!(Value::choose(Relation::Gtr, &sum, &three, &one, &three).unwrap(), one);
        assert_eq!(Value::choose(Relation::Gte, &root(2), &sum, &one, &three).unwrap(), three);
        let x = variable("x");
        let clamped = Value::maximum(&[x.clone(), root(2), one]).unwrap();
        assert_eq!(clamped, Value::maximum(&[x, root(2)]).unwrap());
    }

    #[test]
    fn conditions_are_exclusive() {
        let (x, zero, one) = (variable("x"), Value::zero(), Value::one());
        let more = Value::choose(Relation::Gtr, &x, &zero, &one, &zero).unwrap();
        let less = Value::choose(Relation::Lss, &x, &zero, &one, &zero).unwrap();
        assert!(more.mul(&less).unwrap().is_zero());
        assert_eq!(more.mul(&more).unwrap(), more);
        let same = Value::choose(Relation::Eq, &x, &zero, &one, &zero).unwrap();
        assert_eq!(more.add(&less).unwrap().add(&same).unwrap(), one);
    }
}
