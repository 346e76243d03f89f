//! Hypergeometric solutions of linear recurrences with polynomial coefficients: those whose ratio `y(n+1)/y(n)` is a
//! quotient of polynomials (M. Petkovšek, "Hypergeometric solutions of linear recurrences with polynomial coefficients",
//! 1992). All are found whose ratio has rational coefficients.

use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::rational::{relation, shifted};
use crate::univariate::Univariate;

/// The most pairs of divisors that are tried.
const MOST_PAIRS: usize = 2_000;
/// The highest degree of a polynomial solution.
const MOST_DEGREE: usize = 40;

/// The ratio, above and below, of a solution of `p_0(n)*y(n) + … + p_d(n)*y(n+d) = 0`, where neither p_0 nor p_d is 0.
pub(super) fn ratio(operator: &[Univariate]) -> Option<[Univariate; 2]> {
    let order = operator.len().checked_sub(1).filter(|order| *order > 0)?;
    let last = i64::try_from(order - 1).ok()?;
    let (above, below) = (divisors(operator.first()?)?, divisors(&shifted(operator.last()?, -last))?);
    if above.len() * below.len() > MOST_PAIRS {
        return None;
    }
    let mut pairs: Vec<(&Univariate, &Univariate)> =
        above.iter().flat_map(|one| below.iter().map(move |other| (one, other))).collect();
    pairs.sort_by_key(|(one, other)| one.degree() + other.degree());
    pairs.into_iter().find_map(|(one, other)| with(operator, one, other))
}

/// A ratio `z * a(n)/b(n) * c(n+1)/c(n)` with these a and b.
fn with(operator: &[Univariate], a: &Univariate, b: &Univariate) -> Option<[Univariate; 2]> {
    let order = operator.len() - 1;
    let own: Vec<Univariate> = (0..=order)
        .map(|place| {
            (0..order).fold(operator[place].clone(), |all, at| {
                all.times(&shifted(if at < place { a } else { b }, i64::try_from(at).unwrap_or(0)))
            })
        })
        .collect();
    let degree = own.iter().map(Univariate::degree).max()?;
    let leading = Univariate::new(own.iter().map(|one| one.coefficient(degree)).collect());
    let roots = leading.factors().into_iter().filter(|(factor, _)| factor.degree() == 1);
    roots.map(|(factor, _)| -factor.coefficient(0)).filter(|root| !root.is_zero()).find_map(|z| {
        let mut power = BigRational::one();
        let mut scaled = Vec::new();
        for one in &own {
            scaled.push(one.scale(&power));
            power *= &z;
        }
        let c = polynomial(&scaled)?;
        let (top, bottom) = (a.scale(&z).times(&shifted(&c, 1)), b.times(&c));
        let common = top.common_divisor(&bottom);
        Some([top.divide(&common)?.0, bottom.divide(&common)?.0])
    })
}

/// A polynomial c, not 0, with `q_0(n)*c(n) + … + q_d(n)*c(n+d) = 0`.
fn polynomial(operator: &[Univariate]) -> Option<Univariate> {
    // In differences: the part of order j lowers the degree by j and raises it by that of its coefficient.
    let differences: Vec<Univariate> = (0..operator.len())
        .map(|order| {
            let rest = operator.iter().enumerate().skip(order);
            rest.fold(Univariate::zero(), |sum, (place, one)| sum.plus(&one.scale(&choose(place, order))))
        })
        .collect();
    let height = |(order, one): (usize, &Univariate)| (!one.is_zero()).then(|| one.degree() as i64 - order as i64);
    let top = differences.iter().enumerate().filter_map(height).max()?;
    let leading = differences.iter().enumerate().filter(|pair| height(*pair) == Some(top));
    let indicial = leading.fold(Univariate::zero(), |sum, (order, one)| {
        let falling = (0..order)
            .fold(Univariate::one(), |all, back| all.times(&Univariate::root(&BigRational::from_integer(back.into()))));
        sum.plus(&falling.scale(&one.coefficient(one.degree())))
    });
    let roots = indicial.factors().into_iter().filter(|(factor, _)| factor.degree() == 1);
    let most = roots.map(|(factor, _)| -factor.coefficient(0)).filter(|root| root.is_integer() && !root.is_negative());
    let most = most.max()?.to_integer().to_usize().filter(|most| *most <= MOST_DEGREE)?;
    let columns: Vec<Univariate> = (0..=most)
        .map(|power| {
            let mut monomial = vec![BigRational::zero(); power];
            monomial.push(BigRational::one());
            let monomial = Univariate::new(monomial);
            operator.iter().enumerate().fold(Univariate::zero(), |sum, (place, one)| {
                sum.plus(&one.times(&shifted(&monomial, i64::try_from(place).unwrap_or(0))))
            })
        })
        .collect();
    relation(&columns)
}

fn choose(above: usize, below: usize) -> BigRational {
    (0..below).fold(BigRational::one(), |all, step| all * BigRational::new((above - step).into(), (step + 1).into()))
}

/// The monic divisors.
fn divisors(polynomial: &Univariate) -> Option<Vec<Univariate>> {
    let mut all = vec![Univariate::one()];
    for (factor, count) in polynomial.factors() {
        let mut more = Vec::new();
        for one in &all {
            let mut power = one.clone();
            for _ in 0..count {
                power = power.times(&factor);
                more.push(power.clone());
            }
        }
        all.extend(more);
        if all.len() > MOST_PAIRS {
            return None;
        }
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::univariate::polynomial;

    #[test]
    fn solutions_by_their_ratios() {
        // (n+2)*y(n+2) - (2*n+3)*y(n+1) + (n+1)*y(n) = 0 has the constants.
        let constant = ratio(&[polynomial(&[1, 1]), polynomial(&[-3, -2]), polynomial(&[2, 1])]).unwrap();
        assert_eq!(constant, [Univariate::one(), Univariate::one()]);
        // y(n+2) = (n+1)*(y(n+1) + y(n)) has n!.
        let below = polynomial(&[-1, -1]);
        let [above, under] = ratio(&[below.clone(), below, Univariate::one()]).unwrap();
        assert_eq!((above.divide(&under).unwrap().0, under.degree()), (polynomial(&[1, 1]), 0));
        // y(n+2) = y(n+1) + y(n) and y(n+2) = (n+1)*y(n+1) + y(n) have none.
        let minus = polynomial(&[-1]);
        assert!(ratio(&[minus.clone(), minus.clone(), Univariate::one()]).is_none());
        assert!(ratio(&[minus, polynomial(&[-1, -1]), Univariate::one()]).is_none());
    }
}
