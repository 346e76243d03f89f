//! Squares, and sums of them: what a length is the root of, and what is nowhere negative.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::arithmetic::relations;
use super::root::root_of_number;
use super::{Atom, Real, Value, ValueError};
use crate::polynomial::{Budget, Monomial, Polynomial};

/// The most terms of a sum in which squares are looked for.
const MOST_TERMS: usize = 60;

/// How deep roots of numbers may stand in one another.
const DEEPEST: usize = 1;

/// Conditions that are looked at in either case.
const MOST_CASES: usize = 3;

/// The work that may go into the divisions that look for a step along a direction.
const STEP_BUDGET: u64 = 20_000;

impl Value {
    /// The components of a vector whose length is the root of this: `x-3` and `y` of `x^2-6*x+9+y^2`; none where it is
    /// not written so.
    pub(crate) fn squares(&self) -> Option<Vec<Value>> {
        let (sum, denominator) = self.parts()?;
        let parts = if denominator.is_one() { squares(sum)? } else { return None };
        parts.into_iter().map(|part| Value::whole(part).ok()).collect()
    }

    /// Whether it is written as a square or a sum of squares, so that it is nowhere negative.
    pub(crate) fn is_sum_of_squares(&self) -> bool {
        self.is_sum_of_squares_in_cases(MOST_CASES)
    }

    /// The same where each of its conditions holds and where it does not.
    fn is_sum_of_squares_in_cases(&self, more: usize) -> bool {
        let condition = self.atoms().into_iter().find(|atom| matches!(atom, Atom::Positive(_))).filter(|_| more > 0);
        let case = |atom: &Atom, holds: i64| {
            self.with_atom(atom, &Value::integer(holds)).is_ok_and(|case| case.is_sum_of_squares_in_cases(more - 1))
        };
        self.is_plainly_sum_of_squares() || condition.is_some_and(|atom| case(&atom, 1) && case(&atom, 0))
    }

    fn is_plainly_sum_of_squares(&self) -> bool {
        let product = self.parts().and_then(|(numerator, denominator)| numerator.times(denominator));
        let Some(product) = product.filter(|product| product.terms().len() <= MOST_TERMS) else { return false };
        // What stands in all terms an even number of times is a square itself.
        let shared = product.monomial_content();
        let even = shared.factors().iter().map(|(atom, exponent)| (atom.clone(), exponent - exponent % 2));
        let product = Monomial::of(even).map_or_else(|| product.clone(), |even| product.without(&even));
        let whole = product.scale(&product.content().recip());
        let whole = as_squares(&whole).map_or(whole, |(_, multiple)| multiple);
        length_of_squares(&whole).is_some()
            || sums_multiples_of_squares(&whole)
            || square_with_numbers(&whole).is_ok_and(|root| root.is_some())
            || self.after_a_step().is_some()
    }

    /// The components of `a + h*d/|d|`, whose length this is the square of, with `a`, `d` and `h` without `|d|`: where
    /// something is after a step towards something else. It is `|a|^2 + h^2 + 2*h*(a*d)/|d|`; none where it is not.
    pub(crate) fn after_a_step(&self) -> Option<Vec<Value>> {
        let (numerator, denominator) = self.parts()?;
        if denominator.is_one() || numerator.terms().len() > MOST_TERMS {
            return None;
        }
        numerator.atoms().into_iter().find_map(|atom| self.step_along(numerator, denominator, atom))
    }

    fn step_along(&self, numerator: &Real, denominator: &Real, atom: &Atom) -> Option<Vec<Value>> {
        let square = atom.square()?;
        let direction = squares(square)?;
        let mut parts = numerator.coefficients_in(atom);
        let (plain, beside) = (parts.remove(&0)?, parts.remove(&1).filter(|_| parts.is_empty())?);
        let mut budget = Budget::new(STEP_BUDGET);
        let mut rest = plain.divide(denominator, &mut budget)?;
        let beside = beside.times(square)?.divide(denominator, &mut budget)?;
        // Each part of the place stands beside the part of the direction that speaks of the same variable.
        let mut place = Vec::new();
        for part in &direction {
            let along = part.atoms().first().and_then(|atom| completed(&rest, atom)).unwrap_or_else(Polynomial::zero);
            rest = rest.minus(&along.times(&along)?);
            place.push(along);
        }
        let unit = atom.value().ok()?.div(&Value::whole(square.clone()).ok()?).ok()?;
        let moved = |step: Real, place: Vec<Real>| {
            let step = Value::whole(step).ok()?.mul(&unit).ok()?;
            let each = place.into_iter().zip(&direction).map(|(place, part)| {
                Value::whole(place).ok()?.add(&Value::whole(part.clone()).ok()?.mul(&step).ok()?).ok()
            });
            let each: Vec<Value> = each.collect::<Option<_>>()?;
            let sum = each.iter().try_fold(Value::zero(), |sum, part| sum.add(&part.mul(part).ok()?).ok())?;
            (sum == *self).then_some(each)
        };
        if place.iter().all(Polynomial::is_zero) {
            // It starts from numbers: they are what stands beside the direction.
            let step = rest.atoms().into_iter().find_map(|atom| completed(&rest, atom))?;
            let twice = beside.divide(&step.plus(&step), &mut budget)?;
            let number = |part: &Real| {
                let atom = part.atoms().first().map(|atom| Monomial::of([((*atom).clone(), 1)]))??;
                let of = |sum: &Real| {
                    sum.terms().iter().find(|(monomial, _)| *monomial == atom).map(|(_, number)| number.clone())
                };
                Some(Polynomial::constant(of(&twice).unwrap_or_else(BigRational::zero) / of(part)?))
            };
            let place: Vec<Real> = direction.iter().map(number).collect::<Option<_>>()?;
            return moved(step, place);
        }
        let [step] = squares(&rest)?.try_into().ok()?;
        moved(step.clone(), place.clone()).or_else(|| moved(step.negated(), place))
    }
}

/// The number whose square a fraction is, up to its sign: `d*(abs(d)-v)/abs(d)` is `abs(d)-v` or less by its sign. So far is
/// something on a line from a place towards which it has made a step.
pub(super) fn after_a_step_in_line(numerator: &Real, denominator: &Real) -> Option<Value> {
    denominator.atoms().into_iter().find_map(|atom| {
        let Atom::Maximum(elements) = atom else { return None };
        let [element] = &**elements else { return None };
        let (way, true) = element.parts().map(|(way, below)| (way, below.is_one()))? else { return None };
        let most = Polynomial::atom(atom.clone());
        let size = most.plus(&most).minus(way);
        let square = size.times(&size)?;
        let times = (denominator.leading() / square.leading()).recip();
        if denominator.scale(&times) != square {
            return None;
        }
        let root = square_root(&numerator.scale(&times))?;
        Value::whole(root.divide(way, &mut Budget::new(STEP_BUDGET))?).ok()
    })
}

/// `(plain + beside/root)/below`, where the root is the length of a vector.
pub(super) struct OverLength {
    pub(super) root: Atom,
    pub(super) plain: Real,
    pub(super) beside: Real,
    pub(super) below: Real,
}

/// A fraction over the square of a length, in which the length stands, as one over the length: `(y*s + x*n)/s` is `y + x/n`.
/// So it is shorter, and no longer than it is when something is put in for what the length is of.
pub(super) fn over_length(numerator: &Real, denominator: &Real) -> Option<OverLength> {
    numerator.atoms().into_iter().find_map(|atom| {
        let square = atom.square().filter(|square| square.as_constant().is_none())?;
        let mut parts = numerator.coefficients_in(atom);
        let (plain, beside) = (parts.remove(&0).unwrap_or_else(Polynomial::zero), parts.remove(&1)?);
        let mut budget = Budget::new(STEP_BUDGET);
        let below = denominator.divide(square, &mut budget).filter(|_| parts.is_empty())?;
        let plain = plain.divide(square, &mut budget)?;
        Some(OverLength { root: atom.clone(), plain, beside, below })
    })
}

/// Whether it is written as a sum of positive multiples of squares: `x^2+2*y^2-4*y+3`, which is `x^2+2*(y-1)^2+1`.
fn sums_multiples_of_squares(sum: &Real) -> bool {
    let mut rest = sum.clone();
    while !rest.is_zero() {
        if let Some(number) = rest.as_constant() {
            return number.is_positive();
        }
        let pivot = |atom: &Atom| {
            let coefficients = rest.coefficients_in(atom);
            let square = coefficients.get(&2).filter(|_| coefficients.len() <= 3 && rest.degree_in(atom) == 2)?;
            let number = square.as_constant().filter(BigRational::is_positive)?;
            let half = (&number + &number).recip();
            let linear = coefficients.get(&1).map_or_else(Polynomial::zero, |linear| linear.scale(&half));
            let part = Polynomial::atom(atom.clone()).plus(&linear);
            Some(part.times(&part)?.scale(&number))
        };
        let Some(square) = rest.atoms().into_iter().find_map(pivot) else { return false };
        rest = rest.minus(&square);
        if rest.terms().len() > MOST_TERMS {
            return false;
        }
    }
    true
}

/// Whether it is written as a sum of squares: `x^2-6*x+9+y^2`.
pub(super) fn sums_squares(sum: &Real) -> bool {
    squares(sum).is_some()
}

/// The polynomials the sum of whose squares this is, each of degree 1 in an atom that the later ones do not have; none
/// where it is not written so.
pub(super) fn squares(sum: &Real) -> Option<Vec<Real>> {
    let mut rest = sum.clone();
    let mut parts = Vec::new();
    while !rest.is_zero() {
        // What stands under a root may bring a name back.
        if rest.terms().len() > MOST_TERMS || parts.len() > MOST_TERMS {
            return None;
        }
        let part = match rest.as_constant() {
            Some(number) => Polynomial::constant(rational_root(&number)?),
            None => rest.atoms().into_iter().find_map(|atom| completed(&rest, atom))?,
        };
        // The square of the root of a number is that number.
        rest = relations(rest.minus(&part.times(&part)?)).ok()?;
        parts.push(part);
    }
    Some(parts)
}

/// The multiple of a sum without content that is written as a square or a shorter sum of squares than it is itself, and the
/// number that it is times the sum: `4*x^2-20*x+4*y^2-28*y+74` of the half of it, which is `(2*x-5)^2+(2*y-7)^2`.
pub(super) fn as_squares(sum: &Real) -> Option<(BigRational, Real)> {
    if sum.terms().len() > MOST_TERMS {
        return None;
    }
    let is_square = |monomial: &Monomial<Atom>| matches!(monomial.factors(), [(_, 2)]);
    let squared = sum.terms().iter().filter(|(monomial, number)| is_square(monomial) && number.is_positive());
    let roots = squared.filter_map(|(_, number)| Some((number, root_of_number(number).ok()?.parts()?.0.content())));
    let multiples = roots.map(|(number, root)| number / (&root * &root)).filter(|times| !times.is_one());
    let multiples: BTreeSet<BigRational> = multiples.collect();
    if multiples.is_empty() {
        return None;
    }
    let multiples = multiples.into_iter().map(|times| (sum.scale(&times), times));
    let found = multiples.filter_map(|(multiple, times)| Some((length_of_squares(&multiple)?, times, multiple)));
    let (shorter, times, multiple) = found.min_by_key(|(length, ..)| *length)?;
    length_of_squares(sum).is_none_or(|length| shorter < length).then_some((times, multiple))
}

/// How many terms are squared in a sum of squares, 0 in one square; none where it is not written so.
fn length_of_squares(sum: &Real) -> Option<usize> {
    if square_root(sum).is_some() || square_with_root(sum).is_some() {
        return Some(0);
    }
    squares(sum).map(|parts| parts.iter().map(|part| part.terms().len()).sum())
}

/// The polynomial of which this is the square, found term by term from the first.
pub(super) fn square_root(sum: &Real) -> Option<Real> {
    let (first, number) = sum.terms().first()?;
    let half = first.factors().iter().map(|(atom, exponent)| (exponent % 2 == 0).then(|| (atom.clone(), exponent / 2)));
    let lead = Monomial::of(half.collect::<Option<Vec<_>>>()?)?;
    let twice = rational_root(number)?;
    let mut root = Polynomial::term(lead.clone(), twice.clone());
    let twice = (&twice + &twice).recip();
    for _ in 0..MOST_TERMS {
        let rest = sum.minus(&root.times(&root)?);
        let Some((next, number)) = rest.terms().first() else { return Some(root) };
        root = root.plus(&Polynomial::term(next.over(&lead)?, number * &twice));
    }
    None
}

/// A number and the polynomial whose square, so many times, this is; of what is made of more than one term.
pub(crate) fn square_of(sum: &Real) -> Option<(BigRational, Real)> {
    if !(2..=MOST_TERMS).contains(&sum.terms().len()) {
        return None;
    }
    let content = if sum.leading().is_negative() { -sum.content() } else { sum.content() };
    let whole = sum.scale(&content.recip());
    let (content, whole) = match as_squares(&whole) {
        Some((times, multiple)) => (content / times, multiple),
        None => (content, whole),
    };
    let plain = square_root(&whole).or_else(|| square_with_root(&whole)?.pop());
    let root = plain.or_else(|| square_with_numbers(&whole).ok().flatten())?;
    Some((content, root))
}

/// `q*x + b/(2*q)` of `q^2*x^2 + b*x + c`.
fn completed(sum: &Real, atom: &Atom) -> Option<Real> {
    let coefficients = sum.coefficients_in(atom);
    let square = coefficients.get(&2).filter(|_| coefficients.len() <= 3 && sum.degree_in(atom) == 2)?;
    let root = rational_root(&square.as_constant()?)?;
    let half = (&root + &root).recip();
    let linear = coefficients.get(&1).map_or_else(Polynomial::zero, |linear| linear.scale(&half));
    Some(Polynomial::atom(atom.clone()).scale(&root).plus(&linear))
}

/// `a + q*sqrt(d)` of `a^2 + q^2*d + 2*a*q*sqrt(d)`, alone.
pub(super) fn square_with_root(sum: &Real) -> Option<Vec<Real>> {
    sum.atoms().into_iter().find_map(|atom| {
        let Atom::Root(inner) = atom else { return None };
        let (radicand, _) = inner.parts().filter(|(top, below)| below.is_one() && top.terms().len() <= MOST_TERMS)?;
        let mut coefficients = sum.coefficients_in(atom);
        let (rest, mixed) = (coefficients.remove(&0)?, coefficients.remove(&1).filter(|_| coefficients.is_empty())?);
        let mut ratios = radicand.terms().iter().filter_map(|(monomial, number)| {
            let (_, own) = rest.terms().iter().find(|(other, _)| other == monomial)?;
            Some(own / number).filter(|ratio| ratio.is_positive())
        });
        ratios.find_map(|ratio| {
            let factor = root_of_number(&ratio).ok()?.parts()?.0.clone();
            // Half of the mixed part over the root of the ratio.
            let other = relations(mixed.times(&factor)?.scale(&(&ratio + &ratio).recip())).ok()?;
            let whole = relations(other.times(&other)?).ok()?.plus(&radicand.scale(&ratio));
            let root = Polynomial::atom(atom.clone()).times(&factor)?.plus(&other);
            (whole == rest).then(|| vec![root])
        })
    })
}

impl Atom {
    /// Whether it is the root of a number, in which roots of numbers may stand at most so many deep.
    fn is_root_of_fixed(&self, deep: usize) -> bool {
        let Atom::Root(inner) = self else { return false };
        inner.as_rational().is_some() || (deep > 0 && inner.atoms().iter().all(|atom| atom.is_root_of_fixed(deep - 1)))
    }
}

/// `sqrt(q)*(m + b/(2*q))` of its square, for a product m, where b has roots of numbers, whose squares are numbers.
pub(super) fn square_with_numbers(sum: &Real) -> Result<Option<Real>, ValueError> {
    let is_root = |atom: &Atom| atom.is_root_of_fixed(DEEPEST);
    if sum.terms().len() > MOST_TERMS || !sum.atoms().into_iter().any(is_root) {
        return Ok(None);
    }
    let whole = Value::whole(sum.clone())?;
    let free = |square: &Monomial<Atom>| !square.factors().iter().any(|(atom, _)| is_root(atom));
    let squares = sum.terms().iter().filter(|(square, _)| !square.factors().is_empty() && free(square));
    for (square, number) in squares {
        let Some(part) = completed_by(sum, square, number) else { continue };
        let root = root_of_number(number)?.mul(&Value::whole(part)?)?;
        if root.mul(&root)? == whole {
            return Ok(root.parts().map(|(part, _)| part.clone()));
        }
    }
    Ok(None)
}

/// `m + b/(2*q)` of `q*m^2 + b*m + c`.
fn completed_by(sum: &Real, square: &Monomial<Atom>, number: &BigRational) -> Option<Real> {
    let half = square.factors().iter().map(|(atom, count)| (count % 2 == 0).then(|| (atom.clone(), count / 2)));
    let lead = Monomial::of(half.collect::<Option<Vec<_>>>()?)?;
    let half = number.is_positive().then(|| (number + number).recip())?;
    let linear = sum.terms().iter().filter(|(monomial, _)| monomial.over(square).is_none());
    let linear = linear.filter_map(|(monomial, factor)| Some(Polynomial::term(monomial.over(&lead)?, factor * &half)));
    Some(linear.fold(Polynomial::term(lead.clone(), BigRational::one()), |sum, term| sum.plus(&term)))
}

pub(super) fn rational_root(number: &BigRational) -> Option<BigRational> {
    Some(BigRational::new(number.numer().sqrt_exactly()?, number.denom().sqrt_exactly()?))
}

/// Roots that are whole.
trait ExactRoot: Sized {
    fn sqrt_exactly(&self) -> Option<Self>;
}

impl ExactRoot for BigInt {
    fn sqrt_exactly(&self) -> Option<BigInt> {
        if self.is_negative() {
            return None;
        }
        let root = self.sqrt();
        (&root * &root == *self).then_some(root)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_with_roots_in_roots_completes_a_square() {
        let whole = Value::integer;
        let root = |value: &Value| value.sqrt().unwrap();
        let inner = whole(15).sub(&whole(4).mul(&root(&whole(5))).unwrap()).unwrap();
        let shift = root(&whole(10)).mul(&root(&inner)).unwrap();
        let length = Value::variable(&crate::name::Name::new("n")).sub(&shift).unwrap();
        let square = length.mul(&length).unwrap();
        // It is not the product that is remembered: what stands under a root is the number.
        assert_eq!(square.to_string(), "n^2-40*sqrt(5)-2*n*sqrt(15-4*sqrt(5))*sqrt(10)+150");
        assert_eq!(square.sqrt().unwrap(), length.abs().unwrap());
    }
}
