//! Every second term of an exponential polynomial is one again, of the squares of its roots: roots that differ in sign alone,
//! of which neither outgrows the other, become one.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

use super::ExponentialPolynomial;
use crate::univariate::Univariate;
use crate::value::Value;

impl ExponentialPolynomial {
    /// The terms at the indices `2*n`, or at `2*n + 1`, as a sum in n; nothing where a coefficient is no number.
    pub fn half(&self, odd: bool) -> Option<ExponentialPolynomial> {
        let mut result = ExponentialPolynomial::zero();
        for (modulus, rows) in self.parts() {
            let squares = Squares::of(modulus)?;
            let mut images = vec![Univariate::zero(); rows.len()];
            for (power, row) in rows.iter().enumerate() {
                let own = row.iter().map(Value::as_rational).collect::<Option<Vec<_>>>()?;
                let own = Univariate::new(own);
                let shifted = if odd { own.times(&Univariate::root(&BigRational::zero())) } else { own };
                let image = squares.image(&shifted.modulo(modulus));
                // (2n)^j has one part, (2n+1)^j those of the binomial theorem.
                let mut binomial = BigInt::one();
                for exponent in (0..=power).rev() {
                    let factor = BigRational::from_integer(&binomial * (BigInt::one() << exponent));
                    images[exponent] = images[exponent].plus(&image.scale(&factor));
                    if !odd {
                        break;
                    }
                    binomial = binomial * BigInt::from(exponent) / BigInt::from(power - exponent + 1);
                }
            }
            let places = 0..squares.modulus.degree();
            let row = |image: &Univariate| places.clone().map(|at| Value::rational(image.coefficient(at))).collect();
            result.include(&squares.modulus, images.iter().map(row).collect()).ok()?;
        }
        Some(result)
    }
}

/// The squares of the roots of an irreducible polynomial.
struct Squares {
    /// Their polynomial, monic.
    modulus: Univariate,
    /// The root by its square; nothing where with each root its negative is one.
    root: Option<Univariate>,
}

impl Squares {
    fn of(polynomial: &Univariate) -> Option<Squares> {
        let [even, odd] = parted(polynomial);
        if odd.is_zero() {
            return Some(Squares { modulus: even.monic(), root: None });
        }
        // p(x) = a(x^2) + x*b(x^2) is 0 where x = -a/b, and its square is a root of a(y)^2 - y*b(y)^2.
        let unknown = Univariate::root(&BigRational::zero());
        let modulus = even.times(&even).minus(&unknown.times(&odd.times(&odd))).monic();
        let inverse = odd.modulo(&modulus).inverse_modulo(&modulus)?;
        let root = even.times(&inverse).scale(&-BigRational::one()).modulo(&modulus);
        Some(Squares { modulus, root: Some(root) })
    }

    /// The coefficient at a square, of a coefficient at the root, or of both that have this square.
    fn image(&self, coefficient: &Univariate) -> Univariate {
        match &self.root {
            None => {
                let [even, _] = parted(coefficient);
                even.scale(&BigRational::from_integer(2.into()))
            }
            Some(root) => {
                let step = |sum: Univariate, number: &BigRational| {
                    sum.times(root).plus(&Univariate::new(vec![number.clone()])).modulo(&self.modulus)
                };
                coefficient.coefficients().iter().rev().fold(Univariate::zero(), step)
            }
        }
    }
}

/// The a and b of `a(x^2) + x*b(x^2)`.
fn parted(polynomial: &Univariate) -> [Univariate; 2] {
    let every_second =
        |first: usize| Univariate::new(polynomial.coefficients().iter().skip(first).step_by(2).cloned().collect());
    [every_second(0), every_second(1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::univariate::polynomial;

    fn sum_of(parts: &[(&[i64], &[&[i64]])]) -> ExponentialPolynomial {
        let mut sum = ExponentialPolynomial::zero();
        for (modulus, rows) in parts {
            let row = |row: &&[i64]| row.iter().map(|number| Value::integer(*number)).collect();
            sum.include(&polynomial(modulus), rows.iter().map(row).collect()).unwrap();
        }
        sum
    }

    #[test]
    fn every_second_term_is_that_of_the_half() {
        // Roots: 3 and -3 with n^2, the golden ratio, those of 3, of x^3 - 2, of x^4 - x + 3, of x^2 + 5.
        let sums = [
            sum_of(&[(&[-3, 1], &[&[1], &[-2], &[5]]), (&[3, 1], &[&[4], &[0], &[7]])]),
            sum_of(&[(&[-1, -1, 1], &[&[1, 2], &[3, -1]]), (&[-3, 0, 1], &[&[2, 7], &[-1, 4], &[1, 1]])]),
            sum_of(&[(&[-2, 0, 0, 1], &[&[1, 2, 3]]), (&[3, -1, 0, 0, 1], &[&[1, 0, -2, 6], &[2, 1, 1, 1]])]),
            sum_of(&[(&[5, 0, 1], &[&[3, 8]]), (&[-1, 1], &[&[0], &[2]])]),
        ];
        for sum in sums {
            for odd in [false, true] {
                let half = sum.half(odd).unwrap();
                for at in 0..12 {
                    assert_eq!(half.at(at).unwrap(), sum.at(2 * at + u64::from(odd)).unwrap(), "{sum:?} at {at}");
                }
            }
        }
    }
}
