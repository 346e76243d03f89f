//! Rational solutions of `a(n)*y(n+1) - b(n)*y(n) = c(n)` with polynomials a, b, c: there is one exactly if one is found.
//!
//! The denominator divides one that follows from a and b alone (S. Abramov, "Rational solutions of linear difference and
//! q-difference equations with polynomial coefficients", 1989); the degree of the numerator is bounded as in R. W. Gosper,
//! "Decision procedure for indefinite hypergeometric summation", 1978.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::elimination;
use crate::univariate::Univariate;

/// The furthest that two roots may be apart, to be looked at together.
const MOST_APART: usize = 60;
/// The highest degree of a numerator.
const MOST_DEGREE: usize = 60;

/// Numerator and denominator of a solution.
pub(super) fn solution(a: &Univariate, b: &Univariate, c: &Univariate) -> Option<[Univariate; 2]> {
    let below = denominator(a, b)?;
    let next = shifted(&below, 1);
    // With y = z/below: a*below*z(n+1) - b*next*z(n) = c*below*next.
    let (ahead, here, wanted) = (a.times(&below), b.times(&next), c.times(&below).times(&next));
    let above = numerator(&ahead, &here, &wanted, degree(&ahead, &here, &wanted)?)?;
    let common = above.common_divisor(&below);
    Some([above.divide(&common)?.0, below.divide(&common)?.0])
}

/// `p(n + by)`
pub(super) fn shifted(polynomial: &Univariate, by: i64) -> Univariate {
    let step = Univariate::new(vec![BigRational::from_integer(by.into()), BigRational::one()]);
    polynomial
        .coefficients()
        .iter()
        .rev()
        .fold(Univariate::zero(), |sum, number| sum.times(&step).plus(&Univariate::new(vec![number.clone()])))
}

/// The whole number i with `f(n) = g(n + i)`, for monic polynomials that are no constants.
pub(super) fn distance(f: &Univariate, g: &Univariate) -> Option<i64> {
    let degree = f.degree();
    if degree == 0 || degree != g.degree() {
        return None;
    }
    let apart = (f.coefficient(degree - 1) - g.coefficient(degree - 1)) / BigRational::from_integer(degree.into());
    let apart = if apart.is_integer() { apart.to_integer().to_i64()? } else { return None };
    (shifted(g, apart) == *f).then_some(apart)
}

/// A multiple of the denominator of every rational solution.
fn denominator(a: &Univariate, b: &Univariate) -> Option<Univariate> {
    let (mut ahead, mut here) = (shifted(a, -1), b.clone());
    let mut apart: Vec<usize> = Vec::new();
    let own = here.factors();
    for (f, _) in ahead.factors() {
        for (g, _) in &own {
            if let Some(found) = distance(&f, g).and_then(|found| usize::try_from(found).ok()) {
                apart.push(found);
            }
        }
    }
    apart.sort_unstable_by(|one, other| other.cmp(one));
    apart.dedup();
    let mut all = Univariate::one();
    for by in apart {
        if by > MOST_APART {
            return None;
        }
        let whole = i64::try_from(by).ok()?;
        let common = ahead.common_divisor(&shifted(&here, whole));
        if common.degree() == 0 {
            continue;
        }
        ahead = ahead.divide(&common)?.0;
        here = here.divide(&shifted(&common, -whole))?.0;
        all = (0..=whole).fold(all, |all, back| all.times(&shifted(&common, -back)));
    }
    Some(all)
}

/// The highest degree that a polynomial u with `ahead*u(n+1) - here*u(n) = wanted` may have.
fn degree(ahead: &Univariate, here: &Univariate, wanted: &Univariate) -> Option<usize> {
    let (less, more) = (ahead.minus(here), ahead.plus(here));
    // It is less*(u(n+1)+u(n))/2 + more*(u(n+1)-u(n))/2, and a difference has one degree less.
    let height = |one: &Univariate| if one.is_zero() { -1 } else { one.degree() as i64 };
    let (less_height, more_height, wanted_height) = (height(&less), height(&more), height(wanted));
    let mut most = wanted_height - less_height.max(more_height - 1);
    if less_height < more_height {
        let place = usize::try_from(more_height).ok()?;
        let top = more.coefficient(place);
        let under = if place == 0 { BigRational::zero() } else { less.coefficient(place - 1) };
        let special = -under * BigRational::from_integer(BigInt::from(2)) / top;
        if special.is_integer() && !special.is_negative() {
            most = most.max(special.to_integer().to_i64()?);
        }
    }
    usize::try_from(most).ok().filter(|most| *most <= MOST_DEGREE)
}

/// A polynomial u of at most this degree with `ahead*u(n+1) - here*u(n) = wanted`.
fn numerator(ahead: &Univariate, here: &Univariate, wanted: &Univariate, most: usize) -> Option<Univariate> {
    let columns = (0..=most).map(|power| {
        let mut monomial = vec![BigRational::zero(); power];
        monomial.push(BigRational::one());
        let monomial = Univariate::new(monomial);
        ahead.times(&shifted(&monomial, 1)).minus(&here.times(&monomial))
    });
    combination(&columns.collect::<Vec<_>>(), wanted)
}

/// Coefficients with which some polynomials add up to another; those that are free are 0.
fn combination(columns: &[Univariate], wanted: &Univariate) -> Option<Univariate> {
    elimination::combination(equations(columns, wanted)?, columns.len()).map(Univariate::new)
}

/// Coefficients, not all 0, with which some polynomials add up to 0.
pub(super) fn relation(columns: &[Univariate]) -> Option<Univariate> {
    let (rows, pivots) = elimination::reduced(equations(columns, &Univariate::zero())?, columns.len());
    let free = (0..columns.len()).find(|column| !pivots.contains(column))?;
    let mut coefficients = vec![BigRational::zero(); columns.len()];
    coefficients[free] = BigRational::one();
    for (row, column) in rows.iter().zip(&pivots) {
        coefficients[*column] = -row[free].clone();
    }
    Some(Univariate::new(coefficients))
}

/// An equation for each coefficient, with that of what is wanted in the end.
fn equations(columns: &[Univariate], wanted: &Univariate) -> Option<Vec<Vec<BigRational>>> {
    let height = columns.iter().chain([wanted]).map(Univariate::degree).max()? + 1;
    let row = |place| columns.iter().chain([wanted]).map(|column| column.coefficient(place)).collect();
    Some((0..height).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::univariate::polynomial;

    #[test]
    fn sums_that_telescope_and_one_that_does_not() {
        // y(n+1) - y(n) = 1/((n+1)*(n+2)) and, with a gap of three, 1/((n+1)*(n+4)).
        for (gap, most) in [(2, 1), (4, 3)] {
            let below = polynomial(&[1, 1]).times(&polynomial(&[gap, 1]));
            let [above, found] = solution(&below, &below, &Univariate::one()).unwrap();
            assert_eq!(found.degree(), most);
            let left = shifted(&above, 1).times(&found).minus(&above.times(&shifted(&found, 1))).times(&below);
            assert_eq!(left, found.times(&shifted(&found, 1)));
        }
        let harmonic = polynomial(&[1, 1]);
        assert!(solution(&harmonic, &harmonic, &Univariate::one()).is_none());
        // n*n! telescopes and n! does not: (n+1)*y(n+1) - y(n) = n, or 1.
        assert!(solution(&polynomial(&[1, 1]), &Univariate::one(), &polynomial(&[0, 1])).is_some());
        assert!(solution(&polynomial(&[1, 1]), &Univariate::one(), &Univariate::one()).is_none());
    }
}
