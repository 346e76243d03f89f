//! Factors of a polynomial whose coefficients are themselves polynomials in parameters: each parameter becomes a power
//! of one large number, the image is factored over the rational numbers, and the digits of its factors' coefficients to that
//! base are the coefficients of the factors (Kronecker). What is returned multiplies to the whole, by exact arithmetic.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::polynomial::{Budget, Monomial, Polynomial};
use crate::univariate::Univariate;
use crate::value::{Atom, Value};

type Parameters = Polynomial<Atom>;

/// The most bits of an image.
const MOST_BITS: u64 = 40_000;
/// The work that may go into common divisors and exact quotients.
const WORK: u64 = 200_000;
/// How many images are tried: in a few of them a factor comes apart that does not in the parameters.
const IMAGES: u32 = 3;

/// The monic factors of a monic polynomial with their multiplicity, coefficients from the constant up, all but the
/// leading 1; none if it is too large.
pub(super) fn factors(polynomial: &[Value]) -> Option<Vec<(Vec<Value>, usize)>> {
    let scale = denominator(polynomial)?;
    let degree = u32::try_from(polynomial.len()).ok()?;
    // With y = scale*x all coefficients are polynomials with whole coefficients, and so are those of every factor.
    let mut whole = Vec::new();
    for (coefficient, place) in polynomial.iter().zip(0..) {
        let factor = Value::from_polynomials(scale.power(degree - place)?, Parameters::one()).ok()?;
        let (numerator, below) = coefficient.mul(&factor).ok()?.polynomials().map(|(a, b)| (a.clone(), b.clone()))?;
        below.is_one().then(|| whole.push(numerator))?;
    }
    let found = (1..=IMAGES).find_map(|step| Images::of(&whole, step)?.factors(&whole))?;
    let scale = Value::from_polynomials(scale, Parameters::one()).ok()?;
    let back = |factor: Vec<Parameters>| -> Option<Vec<Value>> {
        let degree = factor.len();
        let mut own = Vec::new();
        for (place, coefficient) in factor.into_iter().enumerate() {
            let power = Value::integer(i64::try_from(degree - place).ok()?);
            let coefficient = Value::from_polynomials(coefficient, Parameters::one()).ok()?;
            own.push(coefficient.div(&scale.power(&power).ok()?).ok()?);
        }
        Some(own)
    };
    found.into_iter().map(|(factor, count)| Some((back(factor)?, count))).collect()
}

/// A common multiple of all denominators, those of the numbers included.
fn denominator(polynomial: &[Value]) -> Option<Parameters> {
    let mut common = Parameters::one();
    let mut numbers = BigInt::one();
    for coefficient in polynomial {
        let (above, below) = coefficient.polynomials()?;
        let shared = common.common_divisor(below, &mut Budget::new(WORK))?;
        common = common.times(&below.divide(&shared, &mut Budget::new(WORK))?)?;
        let all = above.terms().iter().chain(below.terms());
        numbers = all.fold(numbers, |all, (_, number)| all.lcm(number.denom()).lcm(&BigInt::one()));
        let lead = below.terms().iter().fold(BigInt::one(), |all, (_, number)| all.lcm(number.numer()));
        numbers = if below.as_constant().is_some() { numbers.lcm(&lead) } else { numbers };
    }
    Some(common.primitive().scale(&BigRational::from_integer(numbers)))
}

/// How parameters become numbers and digits parameters.
struct Images {
    /// Each parameter with the number of digits that one of its exponents takes.
    atoms: Vec<(Atom, usize)>,
    digits: usize,
    /// No coefficient of a factor exceeds half of it.
    base: BigInt,
}

impl Images {
    /// One of several ways: a product of parameters that is a square in one of them need not be so in the next.
    fn of(whole: &[Parameters], step: u32) -> Option<Images> {
        let all: BTreeSet<&Atom> = whole.iter().flat_map(Polynomial::atoms).collect();
        let (mut atoms, mut digits, mut total) = (Vec::new(), 1usize, whole.len() as u64);
        for atom in all {
            // The degree of the whole in it, and so no less than that of a factor.
            let most = whole.iter().map(|part| part.degree_in(atom)).max()?;
            atoms.push((atom.clone(), digits));
            digits = digits.checked_mul(usize::try_from(most.checked_add(step)?).ok()?)?;
            total += u64::from(most);
        }
        let numbers = whole.iter().flat_map(Polynomial::terms);
        let size: BigInt = numbers.map(|(_, number)| number.numer().abs()).sum::<BigInt>() + BigInt::one();
        // Gelfond: the factors' coefficients are less than 2^(sum of the degrees) times those of the whole.
        let bits = size.bits() + total + 2;
        let modest = bits.checked_mul(u64::try_from(digits).ok()?)?.checked_mul(whole.len() as u64)? <= MOST_BITS;
        modest.then(|| Images { atoms, digits, base: (BigInt::one() << bits) + BigInt::from(2 * step - 1) })
    }

    fn factors(&self, whole: &[Parameters]) -> Option<Vec<(Vec<Parameters>, usize)>> {
        let mut image = whole.iter().map(|part| self.number(part)).collect::<Option<Vec<_>>>()?;
        image.push(BigRational::one());
        let mut found = Vec::new();
        let mut product = vec![Parameters::one()];
        for (factor, count) in Univariate::new(image).factors() {
            let own: Vec<Parameters> =
                (0..factor.degree()).map(|place| self.parameters(&factor.coefficient(place))).collect::<Option<_>>()?;
            for _ in 0..count {
                product = times(&product, &own)?;
            }
            found.push((own, count));
        }
        (product.len() == whole.len() + 1 && product[..whole.len()] == *whole).then_some(found)
    }

    /// A polynomial in the parameters with its powers of the base in place of them.
    fn number(&self, polynomial: &Parameters) -> Option<BigRational> {
        let mut sum = BigRational::zero();
        for (monomial, number) in polynomial.terms() {
            let mut exponent = 0usize;
            for (atom, count) in monomial.factors() {
                let (_, digits) = self.atoms.iter().find(|(other, _)| other == atom)?;
                exponent += digits * usize::try_from(*count).ok()?;
            }
            sum += number * BigRational::from_integer(self.base.pow(u32::try_from(exponent).ok()?));
        }
        Some(sum)
    }

    /// The polynomial whose coefficients are the digits of a number, between minus and plus half the base.
    fn parameters(&self, number: &BigRational) -> Option<Parameters> {
        let base = &self.base;
        let mut rest = number.is_integer().then(|| number.to_integer())?;
        let half = base / BigInt::from(2);
        let mut terms = Vec::new();
        for place in 0..self.digits {
            if rest.is_zero() {
                break;
            }
            let digit = rest.mod_floor(base);
            let digit = if digit > half { digit - base } else { digit };
            rest = (rest - &digit) / base;
            if digit.is_zero() {
                continue;
            }
            let mut left = place;
            let mut monomial = Vec::new();
            for (atom, digits) in self.atoms.iter().rev() {
                monomial.push((atom.clone(), u32::try_from(left / digits).ok()?));
                left %= digits;
            }
            monomial.retain(|(_, count)| *count > 0);
            terms.push((Monomial::of(monomial)?, BigRational::from_integer(digit)));
        }
        rest.is_zero().then(|| Polynomial::of(terms))
    }
}

/// The product of a polynomial, with its leading coefficient, and a monic one, without.
fn times(left: &[Parameters], right: &[Parameters]) -> Option<Vec<Parameters>> {
    let mut product = vec![Parameters::zero(); left.len() + right.len()];
    for (place, one) in left.iter().enumerate() {
        for (offset, other) in right.iter().enumerate() {
            product[place + offset] = product[place + offset].plus(&one.times(other)?);
        }
        product[place + right.len()] = product[place + right.len()].plus(one);
    }
    Some(product)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::name::Name;

    fn variable(name: &str) -> Value {
        Value::variable(&Name::new(name))
    }

    /// The coefficients of a product of monic polynomials, all but the leading one.
    fn multiplied(parts: &[Vec<Value>]) -> Vec<Value> {
        let mut product = vec![Value::one()];
        for part in parts {
            let mut next = vec![Value::zero(); product.len() + part.len()];
            for (place, one) in product.iter().enumerate() {
                for (offset, other) in part.iter().chain([&Value::one()]).enumerate() {
                    next[place + offset] = next[place + offset].add(&one.mul(other).unwrap()).unwrap();
                }
            }
            product = next;
        }
        product.pop();
        product
    }

    #[test]
    fn products_over_parameters_come_apart_again() {
        let (a, b, c) = (variable("a"), variable("b"), variable("c"));
        let half = Value::fraction(1, 2).unwrap();
        let pool: Vec<Vec<Value>> = vec![
            vec![a.clone()],
            vec![b.neg().unwrap()],
            vec![a.mul(&half).unwrap().sub(&b).unwrap()],
            vec![b.div(&a).unwrap()],
            vec![Value::integer(-3)],
            vec![b.clone(), a.clone()],
            vec![c.clone(), Value::zero()],
            vec![a.add(&c).unwrap(), Value::zero(), b.mul(&half).unwrap()],
        ];
        for one in 0..pool.len() {
            for other in one..pool.len() {
                for third in [0, 3, 5] {
                    let mut wanted: Vec<Vec<Value>> = [one, other, third].map(|place| pool[place].clone()).into();
                    let found = factors(&multiplied(&wanted)).unwrap();
                    let mut again: Vec<Vec<Value>> =
                        found.iter().flat_map(|(factor, count)| vec![factor.clone(); *count]).collect();
                    wanted.sort();
                    again.sort();
                    assert_eq!(again, wanted);
                }
            }
        }
    }
}
