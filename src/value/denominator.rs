//! What may stand below a fraction: conditions, signs, known roots and lengths leave the denominator where nothing is lost.

use std::collections::BTreeMap;

use num_rational::BigRational;

use super::arithmetic::{DIVISOR_BUDGET, product, relations};
use super::line::{Place, placed};
use super::{Atom, Need, Real, Relation, Value, ValueError};
use crate::name::Name;
use crate::polynomial::{Budget, Monomial, Polynomial};

/// The bits of a coefficient beyond which a denominator keeps its roots: freed of one, its numbers are twice as long.
const LONGEST: u64 = 1 << 12;

/// How often a divisor with roots is multiplied with itself, to see what they are the roots of.
const ROOTS_IN_ROOTS: usize = 3;

/// Whether a fraction is not what [`Value::over`] makes of its numerator and denominator.
pub(super) fn hides_a_sign(numerator: &Real, denominator: &Real) -> bool {
    denominator.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_)))
        && without_lengths(numerator.clone(), denominator.clone()).is_ok_and(|(_, below)| below != *denominator)
}

/// 1, 0 or -1.
fn sign(of: Real) -> Result<Real, ValueError> {
    let value = Value::whole(of)?;
    let [more, less] = [Relation::Gtr, Relation::Lss].map(|relation| Value::truth(relation, &value, &Value::zero()));
    Ok(more?.sub(&less?)?.real()?.0.clone())
}

/// A fraction whose denominator has the factor `|e|` and whose numerator has `e`, without them: `e/|e|` is the sign of e,
/// `(if e > 0 then 1 else 0) - (if e < 0 then 1 else 0)`, and `e*e/|e|` is `|e|`.
pub(super) fn without_lengths(numerator: Real, denominator: Real) -> Result<(Real, Real), ValueError> {
    let halves = |atom: &Atom| match atom {
        Atom::Maximum(parts) if parts.len() == 1 => {
            let (inside, below) = parts.first()?.parts()?;
            below.is_one().then(|| inside.clone())
        }
        _ => None,
    };
    let maxima: Vec<(Real, Real)> = denominator
        .atoms()
        .into_iter()
        .filter_map(|atom| halves(atom).map(|inside| (Polynomial::atom(atom.clone()), inside)))
        .collect();
    let (mut numerator, mut denominator) = (numerator, denominator);
    for (maximum, inside) in maxima {
        let length = maximum.plus(&maximum).minus(&inside);
        let mut budget = Budget::new(DIVISOR_BUDGET);
        let both = denominator.divide(&length, &mut budget).zip(numerator.divide(&inside, &mut budget));
        let Some((below, above)) = both else { continue };
        let above = match above.divide(&inside, &mut budget) {
            Some(rest) => product(&rest, &length)?,
            None => product(&above, &sign(inside)?)?,
        };
        (numerator, denominator) = (relations(above)?, below);
    }
    Ok((numerator, denominator))
}

/// Multiplies numerator and denominator so that the denominator is free of binary atoms, signs and known roots, where
/// that is possible without multiplying by what may be 0 where the denominator is not.
pub(super) fn free_denominator(mut numerator: Real, mut denominator: Real) -> Result<(Real, Real), ValueError> {
    if let Some(root) = leading_root(&denominator) {
        (numerator, denominator) = (relations(product(&numerator, &root)?)?, relations(product(&denominator, &root)?)?);
    }
    for _ in 0..8 {
        if numerator.bits().max(denominator.bits()) > LONGEST {
            break;
        }
        let special: Vec<Atom> = denominator
            .atoms()
            .into_iter()
            .filter(|atom| atom.is_binary() || atom.is_sign() || atom.square().is_some())
            .cloned()
            .collect();
        let mut changed = false;
        for atom in special {
            if let Some((sign, rest)) = by_sign(&denominator, &atom)? {
                (numerator, denominator) = (relations(product(&numerator, &sign)?)?, rest);
                changed = true;
                break;
            }
            let mut parts = denominator.coefficients_in(&atom);
            let (constant, factor) = (parts.remove(&0), parts.remove(&1));
            let (constant, Some(factor), true) = (constant.unwrap_or_else(Polynomial::zero), factor, parts.is_empty())
            else {
                continue;
            };
            let other = if atom.is_binary() { constant.plus(&factor) } else { constant.clone() };
            // A denominator `B*s` is not 0 only where s is 1, and `A*(1 - s)` only where s is 0.
            if atom.is_binary() && (constant.is_zero() || other.is_zero()) {
                let one = constant.is_zero();
                let place = if one { Place::Holds } else { Place::Fails };
                (numerator, denominator) = (placed(&numerator, &atom, place), placed(&denominator, &atom, place));
                changed = true;
                break;
            }
            let Some((conjugate, freed)) = conjugate(&constant, &factor, &atom)? else { continue };
            (numerator, denominator) = (relations(product(&numerator, &conjugate)?)?, freed);
            changed = true;
            break;
        }
        if !changed {
            break;
        }
    }
    Ok((numerator, denominator))
}

/// A fraction whose numerator is a multiple of what stands in the denominator as the squares of lengths are known: `S + m*n`
/// is `n*(n + m)` where n is the root of S, so that `(S + m*n)/(n + m)` is n; and of the roots of numbers beside variables, as
/// `(x^2 - 2)/(x + sqrt(2))` is `x - sqrt(2)`. None where nothing divides.
pub(super) fn divided_beside_length(numerator: &Real, denominator: &Real) -> Result<Option<(Real, Real)>, ValueError> {
    for atom in denominator.atoms() {
        let known = |square: &&Real| atom.is_root_of_number() || is_of_variables(square);
        let Some(square) = atom.square().filter(known) else { continue };
        let mut parts = denominator.coefficients_in(atom);
        let (Some(constant), Some(factor), true) = (parts.remove(&0), parts.remove(&1), parts.is_empty()) else {
            continue;
        };
        let mut budget = Budget::new(DIVISOR_BUDGET);
        let Some(shared) = constant.common_divisor(&factor, &mut budget) else { continue };
        let parts = constant.divide(&shared, &mut budget).zip(factor.divide(&shared, &mut budget));
        let Some((constant, factor)) = parts else { continue };
        let beside = product(&factor, &Polynomial::atom(atom.clone()))?;
        let below = relations(product(&constant, &constant)?.minus(&product(&product(&factor, &factor)?, square)?))?;
        let above = relations(product(numerator, &relations(constant.minus(&beside))?)?)?;
        // What comes of it is the same wherever both have a value, if it is when the rest of the denominator is put back.
        let Some(above) = above.divide(&below, &mut budget) else { continue };
        if relations(product(&above, &constant.plus(&beside))?)? == *numerator {
            return Ok(Some((above, shared)));
        }
    }
    Ok(None)
}

/// Whether variables stand in it, and not only in its atoms.
fn is_of_variables(polynomial: &Real) -> bool {
    polynomial.atoms().into_iter().any(|atom| matches!(atom, Atom::Variable(_)))
}

/// The roots of numbers in the first term of a polynomial in its variables, where all that stands at these variables has
/// them: of `x*sqrt(2)-2`, which is `sqrt(2)*(x-sqrt(2))`, the root of 2. Multiplied by them, it has none there.
pub(super) fn leading_root(polynomial: &Real) -> Option<Real> {
    let mut parts = Vec::with_capacity(polynomial.terms().len());
    for (monomial, _) in polynomial.terms() {
        let (roots, rest): (Vec<_>, Vec<_>) =
            monomial.factors().iter().cloned().partition(|(atom, _)| atom.is_root_of_number());
        parts.push((Monomial::of(rest)?, roots));
    }
    let first = parts.iter().map(|(rest, _)| rest).max()?.clone();
    let mut leading = parts.into_iter().filter(|(rest, _)| *rest == first);
    let (rest, roots) = leading.next()?;
    let alone = leading.next().is_none() && !rest.factors().is_empty() && !roots.is_empty();
    alone.then_some(())?;
    Some(Polynomial::term(Monomial::of(roots)?, BigRational::from_integer(1.into())))
}

/// Makes sure that nothing is lost where these are put in for names: what the value divides by may become 0 in a case, and
/// the normal form is then what the fraction is in the others.
///
/// # Errors
/// Where it is 0.
pub fn keeps_divisors(value: &Value, images: &BTreeMap<Name, Value>) -> Result<(), ValueError> {
    let plain = value.polynomials().is_some_and(|(_, below)| below.is_one())
        && value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_)));
    if plain {
        return Ok(());
    }
    let cased = |name: &Name| {
        images.get(name).is_some_and(|image| image.atoms().iter().any(|atom| matches!(atom, Atom::Positive(_))))
    };
    let needs = value.needs().into_iter().filter(|need| matches!(need, Need::Nonzero(_)));
    for need in needs.filter(|need| need.value().variables().iter().any(cased)) {
        if let Some((relation, inside)) = taken_for_granted(&need.value().substitute(images)?) {
            return Err(ValueError(format!("division by 0 where {inside} {} 0", relation.negated().symbol())));
        }
    }
    Ok(())
}

/// What must hold where this is divided by, so that it is not all 0: the condition s of `B*s`, or the contrary of that of
/// `A*(1 - s)`. The normal form of a fraction takes it for granted. A root whose square is known leaves the denominator with
/// it, as that of `if x > 0 then 61 else 0` does.
pub fn taken_for_granted(divisor: &Value) -> Option<(Relation, Value)> {
    let mut power = divisor.clone();
    for _ in 0..ROOTS_IN_ROOTS {
        if let Some(granted) = granted_alone(&power) {
            return Some(granted);
        }
        if !power.atoms().iter().any(|atom| matches!(atom, Atom::Root(_))) {
            return None;
        }
        power = power.mul(&power).ok()?;
    }
    granted_alone(&power)
}

/// The same of a divisor as it is.
fn granted_alone(divisor: &Value) -> Option<(Relation, Value)> {
    let (above, _) = divisor.polynomials()?;
    above.atoms().into_iter().find_map(|atom| {
        let Atom::Positive(inside) = atom else { return None };
        let mut parts = above.coefficients_in(atom);
        let (constant, factor) = (parts.remove(&0).unwrap_or_else(Polynomial::zero), parts.remove(&1)?);
        let relation = match (constant.is_zero(), constant.plus(&factor).is_zero()) {
            (true, _) => Relation::Gtr,
            (_, true) => Relation::Lte,
            _ => return None,
        };
        parts.is_empty().then(|| (relation, inside.clone()))
    })
}

/// What `A + B*s` is multiplied by, and what it is then: (A + B*s)(A - B*s) = A^2 - B^2*s^2 and, where s^2 = s,
/// (A + B*s)(A + B - B*s) = A*(A + B), each after the common factor of A and B. That must be a number other than 0, as the
/// conjugate may be 0 elsewhere; or `B*s` is alone.
fn conjugate(constant: &Real, factor: &Real, atom: &Atom) -> Result<Option<(Real, Real)>, ValueError> {
    let root = Polynomial::atom(atom.clone());
    if constant.is_zero() {
        let freed = relations(product(&product(factor, &root)?, &root)?)?;
        return Ok((freed.degree_in(atom) == 0).then_some((root, freed)));
    }
    let mut budget = Budget::new(DIVISOR_BUDGET);
    let mut apart = || {
        let shared = constant.common_divisor(factor, &mut budget)?;
        Some((constant.divide(&shared, &mut budget)?, factor.divide(&shared, &mut budget)?, shared))
    };
    let Some((constant, factor, shared)) = apart() else { return Ok(None) };
    let other = if atom.is_binary() { constant.plus(&factor) } else { constant.clone() };
    let rooted = product(&factor, &root)?;
    let conjugate = relations(other.minus(&rooted))?;
    let number = relations(product(&constant.plus(&rooted), &conjugate)?)?;
    let sure = match number.as_constant() {
        Some(number) => !num_traits::Zero::is_zero(&number),
        None => Value::whole(number.clone())?.order_of_roots().is_some(),
    };
    if sure { Ok(Some((conjugate, relations(product(&number, &shared)?)?))) } else { Ok(None) }
}

/// The sign `[x > 0] - [x < 0]` in a denominator, which is its own inverse where it is not 0, with the other factor.
fn by_sign(denominator: &Real, atom: &Atom) -> Result<Option<(Real, Real)>, ValueError> {
    let Atom::Positive(inside) = atom else { return Ok(None) };
    let opposite = Atom::Positive(inside.neg()?);
    let mut parts = denominator.coefficients_in(atom);
    let (rest, factor) = (parts.remove(&0), parts.remove(&1));
    let (Some(rest), Some(factor), true) = (rest, factor, parts.is_empty()) else { return Ok(None) };
    let sign = Polynomial::atom(atom.clone()).minus(&Polynomial::atom(opposite.clone()));
    let negated = product(&factor.negated(), &Polynomial::atom(opposite.clone()))?;
    Ok((rest == negated && factor.degree_in(&opposite) == 0).then_some((sign, factor)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(letter: char) -> Value {
        Value::variable(&Name::new(&letter.to_string()))
    }

    fn number(of: i64) -> Value {
        Value::integer(of)
    }

    fn condition(relation: Relation, value: &Value) -> Value {
        Value::truth(relation, value, &number(0)).unwrap()
    }

    /// What is made of a fraction has the fraction's value wherever the denominator has one that is not 0.
    #[test]
    fn nothing_is_lost_below_a_fraction() {
        let (x, y) = (name('x'), name('y'));
        let sign = y.over(&y.abs().unwrap()).unwrap();
        let (more, less) = (condition(Relation::Gtr, &y), condition(Relation::Lss, &y));
        let root = |value: &Value| value.sqrt().unwrap();
        let plus = |one: &Value, other: &Value| one.add(other).unwrap();
        let times = |one: &Value, other: &Value| one.mul(other).unwrap();
        let length = Value::vector(vec![x.clone(), y.clone()]).unwrap().norm().unwrap();
        let denominators = [
            sign.clone(),
            times(&x, &sign),
            plus(&number(2), &condition(Relation::Eq, &y)).sub(&number(1)).unwrap(),
            plus(&number(1), &condition(Relation::Eq, &y)),
            plus(&x, &more),
            plus(&more, &less),
            plus(&number(1), &root(&more)),
            plus(&number(1), &root(&plus(&x, &number(4)))),
            plus(&x, &length),
            times(&x, &plus(&number(1), &more)),
            plus(&number(3), &times(&number(2), &sign)),
            plus(&x, &root(&number(2))),
            plus(&plus(&number(1), &root(&number(2))), &root(&number(3))),
            plus(&x.abs().unwrap(), &y.abs().unwrap()),
        ];
        let farther = condition(Relation::Gtr, &y.sub(&number(1)).unwrap());
        let denominators = denominators.into_iter().chain([
            more.clone(),
            farther.clone(),
            number(1).sub(&farther).unwrap(),
            plus(&more, &farther),
            times(&plus(&x, &number(2)), &farther),
        ]);
        let denominators: Vec<Value> = denominators.collect();
        let apart = plus(&times(&x, &farther), &less);
        let numerators = [number(1), y.clone(), x.mul(&x).unwrap(), plus(&more, &x), sign, farther, apart];
        let put = |value: &Value, here: i64, there: i64| {
            value.with(&Name::new("x"), &number(here)).and_then(|value| value.with(&Name::new("y"), &number(there)))
        };
        for denominator in &denominators {
            for numerator in &numerators {
                let fraction = numerator.over(denominator).unwrap();
                for (here, there) in (-4..5).flat_map(|here| (-2..3).map(move |there| (here, there))) {
                    let (Ok(below), Ok(above)) = (put(denominator, here, there), put(numerator, here, there)) else {
                        continue;
                    };
                    if below.is_zero() {
                        continue;
                    }
                    let wanted = above.div(&below).unwrap();
                    let found = put(&fraction, here, there);
                    assert_eq!(
                        found.as_ref(),
                        Ok(&wanted),
                        "({numerator})/({denominator}) = {fraction} at {here}, {there}"
                    );
                }
            }
        }
    }
}
