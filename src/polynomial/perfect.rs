//! Polynomials that are written out powers of a sum of first degree: `k^2-2*k+1` is `(k-1)^2`.

use num_bigint::BigInt;
use num_rational::BigRational;

use super::Polynomial;

impl<A: Clone + Ord> Polynomial<A> {
    /// A sum of first degree, a power of at least 2, and a number, where this is `number * sum^power`.
    pub fn as_power_of_sum(&self) -> Option<(Polynomial<A>, u32, BigRational)> {
        let power = self.0.iter().map(|(monomial, _)| monomial.degree()).max()?;
        let power = u32::try_from(power).ok().filter(|power| *power > 1 && self.0.len() > *power as usize)?;
        let (atom, number) = self.0.iter().find_map(|(monomial, number)| match monomial.factors() {
            [(atom, count)] if *count == power => Some((atom, number)),
            _ => None,
        })?;
        // Of (x + r)^d the term in x^(d-1) is d*r.
        let below = self.coefficients_in(atom).remove(&(power - 1)).filter(Polynomial::is_linear)?;
        let times = number * BigRational::from_integer(BigInt::from(power));
        let sum = Polynomial::atom(atom.clone()).plus(&below.scale(&times.recip()));
        // So many terms has a power of a sum of so many, and no two of them are alike.
        let more =
            (1..sum.0.len()).try_fold(1usize, |all, place| Some(all.checked_mul(power as usize + place)? / place))?;
        (more == self.0.len() && sum.power(power)?.scale(number) == *self).then(|| (sum, power, number.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(number: i64) -> Polynomial<char> {
        Polynomial::constant(BigRational::from_integer(number.into()))
    }

    #[test]
    fn a_power_that_is_written_out_is_known_and_nothing_else() {
        let sum = Polynomial::atom('a').plus(&Polynomial::atom('b').negated()).plus(&number(3));
        for power in 2..7 {
            let all = sum.power(power).unwrap().scale(&BigRational::from_integer((-5).into()));
            let (found, times, factor) = all.as_power_of_sum().unwrap();
            assert_eq!(all, found.power(times).unwrap().scale(&factor));
            assert_eq!(power, times);
            assert!(all.plus(&number(1)).as_power_of_sum().is_none());
        }
        let product = Polynomial::atom('a').times(&Polynomial::atom('b')).unwrap();
        for other in [sum.clone(), number(4), Polynomial::zero(), product, Polynomial::atom('a').power(3).unwrap()] {
            assert!(other.as_power_of_sum().is_none());
        }
    }
}
