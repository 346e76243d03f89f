//! What is left of a division: `mod(7*n,360)` in place of `7*n-360*floor(7*n/360)`.

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::One;

use super::{Printer, Value};
use crate::name::Name;
use crate::value::Atom;

/// The size of a value in which remainders are looked for.
const MOST_SIZE: usize = 400;

impl Printer {
    /// The value with a name in place of a remainder, where an integer part is subtracted from what it is taken of: less is
    /// then left, or nothing but a number.
    pub(super) fn remainder(&mut self, value: &Value) -> Option<Value> {
        if self.expansions == 0 {
            return None;
        }
        let (numerator, denominator) = value.parts()?;
        let whole = |atom: &&Atom| matches!(atom, Atom::Floor(_));
        if !denominator.is_one() || !numerator.atoms().iter().any(whole) || value.size() > MOST_SIZE {
            return None;
        }
        self.expansions -= 1;
        let atoms: Vec<Atom> = numerator.atoms().into_iter().filter(whole).cloned().collect();
        atoms.iter().find_map(|part| self.remainder_of(value, part))
    }

    fn remainder_of(&mut self, value: &Value, part: &Atom) -> Option<Value> {
        let Atom::Floor(inner) = part else { return None };
        let mark = Name::new("[whole part]");
        let (factor, rest) = value.with_atom(part, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
        let left = rest.add(&factor.mul(inner).ok()?).ok()?;
        let fewer = left.as_rational().is_some() && rest.as_rational().is_none() || terms(&left)? < terms(&rest)?;
        if !fewer {
            return None;
        }
        let (above, below) = whole_sides(inner)?;
        let times = factor.neg().and_then(|factor| factor.div(&below)).ok()?;
        if !times.parts()?.1.is_one() {
            return None;
        }
        let mut text = |above: Value, below: Value| {
            let sides = [self.value(&above).0, self.value(&below).0];
            // `L-v*ceil(L/v)` is read more easily than `-mod(-L,v)`.
            let plain = sides.iter().all(|side| !side.starts_with('-'));
            plain.then(|| format!("mod({},{})", sides[0], sides[1]))
        };
        let turned = text(above.neg().ok()?, below.neg().ok()?);
        let (times, text) = match (text(above, below), turned) {
            (Some(plain), _) => (times, plain),
            (None, turned) => (times.neg().ok()?, turned?),
        };
        left.add(&times.mul(&Value::variable(&Name::new(&text))).ok()?).ok()
    }
}

/// The number of terms of a sum that is over nothing.
fn terms(value: &Value) -> Option<usize> {
    let (numerator, denominator) = value.parts()?;
    denominator.is_one().then(|| numerator.terms().len())
}

/// A quotient by numerator and denominator, both with whole numbers.
fn whole_sides(quotient: &Value) -> Option<(Value, Value)> {
    let (above, below) = quotient.polynomials()?;
    let numbers = above.terms().iter().chain(below.terms()).map(|(_, number)| number.denom().clone());
    let scale = numbers.fold(BigInt::one(), |all, one| all.lcm(&one));
    let scale = Value::rational(BigRational::from_integer(scale));
    Some((quotient.numerator()?.mul(&scale).ok()?, quotient.denominator()?.mul(&scale).ok()?))
}
