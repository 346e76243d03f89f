//! Maxima, conditions and integer parts that the assumptions decide.

use std::cell::Cell;
use std::collections::BTreeSet;

use super::pieces::with_fewest_corners;
use super::sign::Signs;
use super::{Assumptions, Relation};
use crate::polynomial::{Budget, Monomial, Polynomial};
use crate::value::{Atom, Sort, Value, ValueError, View};

/// How often a value is gone through: what is resolved in one place may let another be.
const MOST_PASSES: usize = 3;
/// The most terms of what may have a factor in common, and the steps in which that is looked for.
const MOST_TERMS: usize = 40;
const MOST_STEPS: u64 = 200_000;

impl Assumptions {
    /// A value with the variables that equations give replaced.
    pub(super) fn with_solved(&self, value: &Value) -> Value {
        let mut value = value.clone();
        for (name, image) in &self.solved {
            if value.mentions(name)
                && let Ok(replaced) = value.with(name, image)
            {
                value = replaced;
            }
        }
        value
    }

    /// The value with the variables that assumed equations give, and what that decides; the same where they give none.
    pub(crate) fn with_equations(&self, value: Value) -> Value {
        if self.solved.is_empty() { value } else { self.simplify(&self.with_solved(&value)) }
    }

    /// Compares a value with 0 by what it is with the variables put in that equations give, where that can be simplified.
    pub(super) fn decided_by_equations(&self, relation: Relation, value: &Value) -> Option<bool> {
        let given = |value: &Value| self.solved.iter().any(|(name, _)| value.mentions(name));
        if value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_))) || !given(value) {
            return None;
        }
        let replaced = self.with_solved(value);
        let simple = within_depth(|| self.simplify(&replaced))?;
        // What an equation makes shorter may be the value as it was.
        let new = simple != replaced && !given(&simple);
        new.then(|| self.decide_unless_contradictory(relation, &simple))?
    }

    /// What is decided of a value with its maxima resolved, where the assumptions decide one of them.
    pub(super) fn decided_without_maxima(&self, relation: Relation, value: &Value) -> Option<bool> {
        let maxima = |value: &Value| value.atoms().iter().filter(|atom| matches!(atom, Atom::Maximum(_))).count();
        let before = maxima(value);
        if before == 0 {
            return None;
        }
        let simple = within_depth(|| self.simplify(value))?;
        (maxima(&simple) < before).then(|| self.decide_unless_contradictory(relation, &simple))?
    }

    /// The value with `min`, `max`, `abs`, `if`, `floor` and roots resolved where the assumptions decide them.
    pub fn simplify(&self, value: &Value) -> Value {
        if value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_))) {
            return value.clone();
        }
        self.simplified_once(value, || self.gone_through(value))
    }

    fn gone_through(&self, value: &Value) -> Value {
        let mut simple = with_fewest_corners(value);
        for _ in 0..MOST_PASSES {
            match self.resolved(&simple) {
                Ok(next) if next != simple => simple = next,
                _ => break,
            }
        }
        simple
    }

    /// Whether a value is not 0: as it is, or with its maxima and lengths decided, as in `abs(x*sqrt(2)-2)`.
    pub(super) fn is_nonzero(&self, value: &Value) -> Option<bool> {
        let nonzero = |value: &Value| self.decide(Relation::Neq, value, &Value::zero());
        let simpler = || Some(self.simplify(value)).filter(|simple| simple != value).and_then(|one| nonzero(&one));
        // The square of a distance, of which it may be known that it is more than 0.
        let of_distance = || {
            let distance = value.sqrt().ok().filter(|_| value.is_sum_of_squares())?;
            (self.decide(Relation::Gtr, &distance, &Value::zero()) == Some(true)).then_some(true)
        };
        // A fraction is 0 where its numerator is.
        let of_fraction = || nonzero(&value.numerator().filter(|numerator| numerator != value)?);
        // A root is 0 just where what it is taken of is.
        let of_root = || {
            let alone = |atom: &Atom| atom.value().is_ok_and(|one| one == *value);
            value
                .atoms()
                .iter()
                .find_map(|atom| if let Atom::Root(inner) = atom { alone(atom).then(|| nonzero(inner))? } else { None })
        };
        nonzero(value).or_else(of_fraction).or_else(simpler).or_else(of_distance).or_else(of_root)
    }

    fn resolved(&self, value: &Value) -> Result<Value, ValueError> {
        match value.view() {
            View::Vector(parts) => Value::vector(self.all(&parts)?),
            View::Distribution(kind, parts) => Value::distribution(&kind, self.all(&parts)?),
            View::Real(..) => {
                let atoms = value.atoms();
                if atoms.iter().all(|atom| matches!(atom, Atom::Variable(_))) {
                    return Ok(value.clone());
                }
                if let Some(number) = self.stated_number(value) {
                    return Ok(number);
                }
                let mut value = self.shorter(value.clone());
                let atoms = value.atoms();
                for atom in atoms {
                    if let Some(image) = self.image(&atom)? {
                        value = value.with_atom(&atom, &image)?;
                    }
                }
                self.squares(&value)
            }
        }
    }

    /// The number that an assumed equation says a value to be, just as it is written.
    fn stated_number(&self, value: &Value) -> Option<Value> {
        let (_, below) = value.polynomials()?;
        // What differs by a number is over the same.
        let near = |zero: &Value| zero.polynomials().is_some_and(|(_, other)| other == below);
        let equal = self.stated.iter().filter(|(relation, zero)| *relation == Relation::Eq && near(zero));
        equal.flat_map(|(_, zero)| [value.sub(zero), value.add(zero)]).find_map(|rest| {
            let rest = rest.ok()?;
            rest.as_rational().is_some().then_some(rest)
        })
    }

    fn all(&self, parts: &[Value]) -> Result<Vec<Value>, ValueError> {
        parts.iter().map(|part| self.resolved(part)).collect()
    }

    /// What an atom is under the assumptions; `None` when that is nothing new.
    fn image(&self, atom: &Atom) -> Result<Option<Value>, ValueError> {
        let image = match atom {
            Atom::Variable(_) => return Ok(None),
            Atom::Power(base, exponent) => {
                let (base, exponent) = (self.resolved(base)?, self.resolved(exponent)?);
                let counts = || self.decide(Relation::Gtr, &exponent, &Value::zero()) == Some(true);
                if base.is_zero() && self.is_natural(&exponent) == Some(true) && counts() {
                    Value::zero()
                } else {
                    base.power(&exponent)?
                }
            }
            Atom::Apply(function, parts) => {
                let parts: Vec<Value> = self.all(parts)?.into_iter().map(|part| self.shorter(part)).collect();
                Value::apply(function, &parts)?
            }
            Atom::Root(inner) => self.resolved(inner)?.sqrt()?,
            Atom::Floor(inner) => {
                let inner = self.resolved(inner)?;
                if self.fraction_part(&inner).is_some_and(|fraction| fraction == num_traits::Zero::zero()) {
                    inner
                } else if let Some(floor) = self.floor_enclosed(&inner) {
                    Value::rational(floor)
                } else if let Some(floor) = self.floor_stated(&inner)? {
                    floor
                } else {
                    inner.floor()?
                }
            }
            Atom::Positive(inner) => {
                let inner = self.resolved(inner)?;
                match self.decide(Relation::Gtr, &inner, &Value::zero()) {
                    Some(holds) => Value::integer(i64::from(holds)),
                    None => Value::truth(Relation::Gtr, &inner, &Value::zero())?,
                }
            }
            Atom::Maximum(parts) => self.greatest(self.all(parts)?)?,
        };
        Ok(if image.as_atom() == Some(atom) { None } else { Some(image) })
    }

    /// The integer part of a fraction of which something is assumed, where only one rest is left that it may have:
    /// `floor(m/2)` is `m/2` where `2*floor(m/2) > m-1`.
    fn floor_stated(&self, inner: &Value) -> Result<Option<Value>, ValueError> {
        let part = inner.floor()?;
        // Of the same fraction, or of its opposite, but for a number.
        let near = |other: &Value| {
            let number = |value: Result<Value, ValueError>| value.is_ok_and(|value| value.as_rational().is_some());
            number(other.sub(inner)) || number(other.add(inner))
        };
        let stated = |atom: &Atom| matches!(atom, Atom::Floor(other) if near(other));
        if !self.stated.iter().any(|(_, value)| value.atoms().iter().any(stated)) {
            return Ok(None);
        }
        let Some(divisor) = self.divisor_of_integers(inner) else { return Ok(None) };
        for rest in 1..divisor {
            let image = inner.sub(&Value::fraction(rest, divisor)?)?;
            if self.decide(Relation::Eq, &part, &image) == Some(true) {
                return Ok(Some(image));
            }
        }
        Ok((self.decide(Relation::Eq, &part, inner) == Some(true)).then(|| inner.clone()))
    }

    /// The same value by an assumed equation, where that makes it shorter: where something has come to is said by where
    /// that is, and of a function that nothing is known about only its argument tells which value it is.
    fn shorter(&self, mut value: Value) -> Value {
        loop {
            let equal = self.stated.iter().filter(|(relation, _)| *relation == Relation::Eq);
            let others = equal.flat_map(|(_, zero)| [value.sub(zero), value.add(zero)]).flatten();
            match others.min_by_key(Value::size) {
                Some(other) if other.size() < value.size() => value = other,
                _ => return value,
            }
        }
    }

    /// The maximum of 0 and these, without those that are not greater than another.
    fn greatest(&self, mut elements: Vec<Value>) -> Result<Value, ValueError> {
        elements.push(Value::zero());
        let mut place = 0;
        while place < elements.len() && elements.len() > 1 {
            let below = |other: &Value| self.decide(Relation::Lte, &elements[place], other) == Some(true);
            let dominated = elements.iter().enumerate().any(|(at, other)| at != place && below(other));
            if dominated {
                elements.swap_remove(place);
                place = 0;
            } else {
                place += 1;
            }
        }
        let factor = self.common_factor(&elements).or_else(|| self.common_line(&elements));
        let Some(factor) = factor else {
            return Value::maximum(&elements);
        };
        let parts = elements.iter().map(|element| element.div(&factor)).collect::<Result<Vec<_>, _>>()?;
        Value::maximum(&parts)?.mul(&factor)
    }

    /// A product of atoms that divides all elements and is certainly greater than 0.
    fn common_factor(&self, elements: &[Value]) -> Option<Value> {
        let mut shared: Option<Monomial<Atom>> = None;
        let mut divisor: Option<&Polynomial<Atom>> = None;
        for element in elements.iter().filter(|element| !element.is_zero()) {
            let (numerator, below) = element.polynomials()?;
            let content = numerator.monomial_content();
            shared = Some(shared.map_or_else(|| content.clone(), |shared| shared.common(&content)));
            if divisor.is_some_and(|divisor| divisor != below) {
                return None;
            }
            divisor = Some(below);
        }
        let positive = |atom: &Atom| self.atom_signs(atom).within(Signs::POSITIVE);
        let known = shared?.factors().iter().filter(|(atom, _)| positive(atom)).cloned().collect::<Vec<_>>();
        let below = divisor?;
        let stated = || {
            let below = Value::from_polynomials(below.clone(), Polynomial::one()).ok()?;
            self.as_stated(Relation::Gtr, &below)
        };
        let positive = self.quick_signs(below).within(Signs::POSITIVE) || stated() == Some(true);
        let below = if positive { below.clone() } else { Polynomial::one() };
        let top = Polynomial::term(Monomial::of(known)?, num_traits::One::one());
        if top.is_one() && below.is_one() {
            return None;
        }
        Value::from_polynomials(top, below).ok()
    }

    /// What is linear in a variable, divides all elements and is certainly not negative: `D-n*v` of the ways `a*(D-n*v)` and
    /// `b*(D-n*v)` that are left in two directions.
    fn common_line(&self, elements: &[Value]) -> Option<Value> {
        let mut budget = Budget::new(MOST_STEPS);
        let mut shared: Option<Polynomial<Atom>> = None;
        for element in elements.iter().filter(|element| !element.is_zero()) {
            let (numerator, _) = element.polynomials()?;
            if !(2..=MOST_TERMS).contains(&numerator.terms().len()) {
                return None;
            }
            shared = Some(match shared {
                None => numerator.clone(),
                Some(shared) => shared.common_divisor(numerator, &mut budget)?,
            });
        }
        let shared = shared?;
        let atoms =
            shared.atoms().into_iter().filter(|atom| matches!(atom, Atom::Variable(_)) && shared.degree_in(atom) == 1);
        let lines = atoms.filter_map(|atom| {
            let mut parts = shared.coefficients_in(atom).into_values();
            let content = parts.next()?.common_divisor(&parts.next()?, &mut budget)?;
            let line =
                if content.as_constant().is_some() { shared.clone() } else { shared.divide(&content, &mut budget)? };
            let whole = elements.len() == 2 && line == shared;
            (!whole && line.terms().len() > 1).then(|| Value::from_polynomials(line, Polynomial::one()).ok())?
        });
        let lines: BTreeSet<Value> = lines.collect();
        let not_negative = |line: &Value| self.decide(Relation::Gte, line, &Value::zero()) == Some(true);
        lines.into_iter().flat_map(|line| [line.neg().ok(), Some(line)]).flatten().find(not_negative)
    }

    /// Squares of roots of what is certainly not negative.
    fn squares(&self, value: &Value) -> Result<Value, ValueError> {
        if value.sort() != Sort::Real {
            return Ok(value.clone());
        }
        let mut value = value.clone();
        for atom in value.atoms() {
            let Atom::Root(inner) = &atom else { continue };
            let Some((numerator, denominator)) = value.polynomials() else {
                continue;
            };
            let high = numerator.degree_in(&atom) > 1 || denominator.degree_in(&atom) > 1;
            if high && self.decide(Relation::Gte, inner, &Value::zero()) == Some(true) {
                let reduce = |part: &Polynomial<Atom>| -> Result<Value, ValueError> {
                    let mut sum = Value::zero();
                    for (exponent, factor) in part.coefficients_in(&atom) {
                        let factor = Value::from_polynomials(factor, Polynomial::one())?;
                        let square = inner.power(&Value::integer(i64::from(exponent / 2)))?;
                        let rest = if exponent % 2 == 1 { atom.value()? } else { Value::one() };
                        sum = sum.add(&factor.mul(&square)?.mul(&rest)?)?;
                    }
                    Ok(sum)
                };
                value = reduce(numerator)?.div(&reduce(denominator)?)?;
            }
        }
        Ok(value)
    }
}

thread_local! {
    static DEPTH: Cell<usize> = const { Cell::new(0) };
}

/// Equations that are put in while another is looked at.
const DEEPEST: usize = 4;

/// What is found, if not too many of these are open at once.
fn within_depth<T>(find: impl FnOnce() -> T) -> Option<T> {
    let depth = DEPTH.get();
    if depth >= DEEPEST {
        return None;
    }
    DEPTH.set(depth + 1);
    let found = find();
    DEPTH.set(depth);
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    #[test]
    fn arguments_are_equal_by_what_is_assumed() {
        let [a, b, r, t] = ["a", "b", "r", "t"].map(|name| Value::variable(&Name::new(name)));
        let s = |value: Value| Value::apply(&Name::new("s"), &[value]).unwrap();
        let next = r.add(&t.mul(&s(a.sub(&r).unwrap())).unwrap()).unwrap();
        let command = s(b.sub(&next).unwrap());
        let mut known = Assumptions::default();
        assert_eq!(known.simplify(&command), command);
        known.assume(Relation::Eq, &next, &a);
        assert_eq!(known.simplify(&command), s(b.sub(&a).unwrap()));
    }

    #[test]
    fn resolves_what_is_known() {
        let (x, t) = (Value::variable(&Name::new("x")), Value::variable(&Name::new("t")));
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &t, &Value::zero());
        assert_eq!(known.simplify(&t.abs().unwrap()), t);
        let product = Value::maximum(&[Value::zero(), x.mul(&t).unwrap()]).unwrap();
        let expected = t.mul(&Value::maximum(&[Value::zero(), x.clone()]).unwrap()).unwrap();
        assert_eq!(known.simplify(&product), expected);
        known.assume(Relation::Gte, &x, &Value::integer(2));
        assert_eq!(known.simplify(&Value::clamp(&x, &Value::integer(-1), &Value::one()).unwrap()), Value::one());
    }
}
