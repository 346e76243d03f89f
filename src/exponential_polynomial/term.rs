//! Single terms, exactly, for any n: powers modulo an integer polynomial, by squaring.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ExponentialPolynomial;
use crate::univariate::Univariate;
use crate::value::{Value, ValueError};

/// The most bits of a term.
const MOST_BITS: u64 = 1 << 25;
/// Divisors that are looked for in a denominator.
const MOST_FACTOR: u32 = 10_000;

impl ExponentialPolynomial {
    /// The term of this index.
    ///
    /// # Errors
    /// When it is too large.
    pub fn at(&self, place: u64) -> Result<Value, ValueError> {
        let mut numbers = Quotient { top: BigInt::zero(), small: BigInt::one(), bottom: Factors::default() };
        let mut rest = Value::zero();
        for (modulus, rows) in &self.parts {
            let traces = Traces::of(modulus, place)?;
            let mut weights = vec![Value::zero(); modulus.degree()];
            for row in rows.iter().rev() {
                for (weight, value) in weights.iter_mut().zip(row) {
                    *weight = weight.mul(&Value::rational(BigRational::from_integer(place.into())))?.add(value)?;
                }
            }
            let rational: Option<Vec<BigRational>> = weights.iter().map(Value::as_rational).collect();
            if let Some(weights) = rational {
                numbers = numbers.plus(traces.weighted(&weights));
                continue;
            }
            for (offset, weight) in weights.iter().enumerate().filter(|(_, weight)| !weight.is_zero()) {
                let mut only = vec![BigRational::zero(); weights.len()];
                only[offset] = BigRational::one();
                rest = rest.add(&weight.mul(&Value::rational(traces.weighted(&only).reduced()))?)?;
            }
        }
        let numbers = Value::rational(numbers.reduced());
        if rest.is_zero() { Ok(numbers) } else { rest.add(&numbers) }
    }
}

/// The sums of `x^n, x^(n+1), …` over the roots of p: `sums[l] / scale^(n+l)`.
struct Traces {
    sums: Vec<BigInt>,
    scale: BigInt,
    place: u64,
}

impl Traces {
    fn of(modulus: &Univariate, place: u64) -> Result<Traces, ValueError> {
        let degree = modulus.degree();
        let scale = modulus.coefficients().iter().fold(BigInt::one(), |all, number| all.lcm(number.denom()));
        // The roots times the scale are those of a monic integer polynomial.
        let mut power = BigInt::one();
        let mut whole = vec![BigInt::zero(); degree + 1];
        for at in (0..=degree).rev() {
            let number = modulus.coefficient(at);
            whole[at] = number.numer() * &power / number.denom();
            power *= &scale;
        }
        // No root is larger than twice the greatest k-th root of the k-th coefficient from the top (Fujiwara).
        let roots =
            whole.iter().rev().enumerate().skip(1).map(|(back, number)| number.bits().div_ceil(back as u64) + 1);
        let height = roots.max().unwrap_or(1).max(scale.bits());
        if place.saturating_mul(height) > MOST_BITS {
            return Err(ValueError("this term is too large to compute".to_string()));
        }
        let residue = power_of_root(&whole, place);
        let monic = Univariate::new(whole.into_iter().map(BigRational::from_integer).collect());
        let newton = monic.power_sums(2 * degree);
        let sums = (0..degree).map(|offset| {
            residue.iter().enumerate().map(|(at, number)| number * newton[at + offset].numer()).sum::<BigInt>()
        });
        Ok(Traces { sums: sums.collect(), scale, place })
    }

    fn weighted(&self, weights: &[BigRational]) -> Quotient {
        let denominator = weights.iter().fold(BigInt::one(), |all, weight| all.lcm(weight.denom()));
        let mut top = BigInt::zero();
        for (sum, weight) in self.sums.iter().zip(weights) {
            top *= &self.scale;
            top += sum * weight.numer() * (&denominator / weight.denom());
        }
        let mut bottom = Factors::default();
        bottom.include(&self.scale, self.place + weights.len() as u64 - 1);
        Quotient { top, small: denominator, bottom }
    }
}

/// `x^place` modulo a monic integer polynomial.
fn power_of_root(modulus: &[BigInt], place: u64) -> Vec<BigInt> {
    let degree = modulus.len() - 1;
    if degree == 1 {
        return vec![power(&-&modulus[0], place)];
    }
    let mut result = vec![BigInt::zero(); degree];
    result[0] = BigInt::one();
    for bit in (0..u64::BITS - place.leading_zeros()).rev() {
        result = square(&result, modulus);
        if place >> bit & 1 == 1 {
            let top = result.pop().unwrap_or_default();
            result.insert(0, BigInt::zero());
            if !top.is_zero() {
                result.iter_mut().zip(modulus).for_each(|(value, number)| *value -= &top * number);
            }
        }
    }
    result
}

fn square(polynomial: &[BigInt], modulus: &[BigInt]) -> Vec<BigInt> {
    let degree = polynomial.len();
    let mut product = vec![BigInt::zero(); 2 * degree - 1];
    for (place, one) in polynomial.iter().enumerate().filter(|(_, one)| !one.is_zero()) {
        product[2 * place] += one * one;
        for (offset, other) in polynomial.iter().enumerate().skip(place + 1).filter(|(_, other)| !other.is_zero()) {
            product[place + offset] += (one * other) << 1;
        }
    }
    while product.len() > degree {
        let top = product.pop().unwrap_or_default();
        if !top.is_zero() {
            let offset = product.len() - degree;
            product[offset..].iter_mut().zip(modulus).for_each(|(value, number)| *value -= &top * number);
        }
    }
    product
}

fn power(base: &BigInt, exponent: u64) -> BigInt {
    let mut result = BigInt::one();
    for bit in (0..u64::BITS - exponent.leading_zeros()).rev() {
        result = &result * &result;
        if exponent >> bit & 1 == 1 {
            result *= base;
        }
    }
    result
}

/// A product of powers; its bases are small primes, or what is left after dividing by them.
#[derive(Default)]
struct Factors {
    powers: BTreeMap<BigInt, u64>,
    /// Whether a base may be no prime.
    unsure: bool,
}

impl Factors {
    fn include(&mut self, number: &BigInt, exponent: u64) {
        if number.is_one() {
            return;
        }
        let mut left = number.clone();
        for candidate in 2..MOST_FACTOR {
            let divisor = BigInt::from(candidate);
            if left.is_one() || &divisor * &divisor > left {
                break;
            }
            while left.is_multiple_of(&divisor) {
                left /= candidate;
                *self.powers.entry(divisor.clone()).or_insert(0) += exponent;
            }
        }
        if !left.is_one() {
            self.unsure |= left > BigInt::from(MOST_FACTOR) * BigInt::from(MOST_FACTOR - 2);
            *self.powers.entry(left).or_insert(0) += exponent;
        }
    }

    fn product(&self) -> BigInt {
        self.powers.iter().fold(BigInt::one(), |all, (base, exponent)| all * power(base, *exponent))
    }
}

/// A fraction whose denominator is known in factors, so that no common divisor of large numbers is needed.
struct Quotient {
    top: BigInt,
    /// A divisor that does not grow with n.
    small: BigInt,
    /// The rest of the denominator.
    bottom: Factors,
}

impl Quotient {
    fn plus(self, other: Quotient) -> Quotient {
        if self.top.is_zero() {
            return other;
        }
        let small = self.small.lcm(&other.small);
        let (mut own, mut their) = (self.top * (&small / &self.small), other.top * (&small / &other.small));
        let mut bottom = Factors { powers: BTreeMap::new(), unsure: self.bottom.unsure || other.bottom.unsure };
        let all: Vec<&BigInt> = self.bottom.powers.keys().chain(other.bottom.powers.keys()).collect();
        for base in all {
            let count = |factors: &Factors| factors.powers.get(base).copied().unwrap_or(0);
            let (mine, its) = (count(&self.bottom), count(&other.bottom));
            if bottom.powers.insert(base.clone(), mine.max(its)).is_none() {
                if its > mine {
                    own *= power(base, its - mine);
                }
                if mine > its {
                    their *= power(base, mine - its);
                }
            }
        }
        Quotient { top: own + their, small, bottom }
    }

    fn reduced(mut self) -> BigRational {
        if self.top.is_zero() {
            return BigRational::zero();
        }
        let shared = self.small.gcd(&(&self.top % &self.small));
        self.top /= &shared;
        self.small /= shared;
        for (base, exponent) in &mut self.bottom.powers {
            if *base == BigInt::from(2) {
                let count = self.top.trailing_zeros().unwrap_or(0).min(*exponent);
                self.top >>= count;
                *exponent -= count;
                continue;
            }
            // Powers of the base with doubled exponents while they divide, then back.
            let mut powers = vec![(base.clone(), 1u64)];
            while let Some((power, count)) = powers.last() {
                if *count > *exponent || !self.top.is_multiple_of(power) {
                    break;
                }
                self.top /= power;
                *exponent -= count;
                let next = (power * power, 2 * count);
                powers.push(next);
            }
            for (power, count) in powers.iter().rev() {
                while *count <= *exponent && self.top.is_multiple_of(power) {
                    self.top /= power;
                    *exponent -= count;
                }
            }
        }
        let bottom = self.bottom.product() * self.small;
        if self.bottom.unsure { BigRational::new(self.top, bottom) } else { BigRational::new_raw(self.top, bottom) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_agree_with_iteration() {
        // x^3 = x/2 - 1/3: the sums of powers themselves.
        let numbers = [(1, 3), (-1, 2), (0, 1), (1, 1)];
        let modulus = Univariate::new(numbers.map(|(a, b)| BigRational::new(a.into(), i64::into(b))).to_vec());
        let newton = modulus.power_sums(60);
        let mut sum = ExponentialPolynomial::zero();
        sum.include(&modulus, vec![vec![Value::one(), Value::zero(), Value::zero()]]).unwrap();
        for (place, number) in newton.iter().enumerate() {
            let term = sum.at(place as u64).unwrap().as_rational().unwrap();
            assert_eq!((term.numer(), term.denom()), (number.numer(), number.denom()), "{place}");
        }
        assert!(sum.at(u64::MAX).is_err());
    }
}
