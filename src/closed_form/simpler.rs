//! A comparison of parameters without what is known to have one sign: `(2*a-3)/(a-1) < 0` is `a < 3/2` where a > 1.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Comparison;
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// A comparison that holds where this one does, if what is known holds: without divisors and factors of one sign, without a
/// maximum of which one part counts, or an integer part beside a number, and with a name alone on the left where the rest is a
/// number. Unchanged where it is none of numbers.
pub(crate) fn simpler(comparison: &Comparison, known: &Assumptions) -> Comparison {
    let mut simple = comparison.clone();
    // The parts of a maximum are no maxima of it.
    for _ in 0..MOST_PARTS {
        match of_a_size(&simple).or_else(|| of_one_part(&simple, known)).or_else(|| of_what_is_rounded(&simple)) {
            Some(simpler) => simple = simpler,
            None => break,
        }
    }
    without_signs(&simple, known).unwrap_or(simple)
}

/// How many maxima and integer parts in one another are opened.
const MOST_PARTS: usize = 4;

/// `E = 0` of `abs(E) = 0`, `E != 0` of `abs(E) > 0`.
fn of_a_size((relation, left, right): &Comparison) -> Option<Comparison> {
    let size = left.sub(right).ok()?;
    let maximum = size.atoms().into_iter().find(|atom| matches!(atom, Atom::Maximum(_)));
    let Some(Atom::Maximum(elements)) = &maximum else { return None };
    let [inner] = &**elements else { return None };
    // abs(E) = 2*max(0,E) - E
    let one = inner.abs().ok()?;
    let turned = if size == one { *relation } else { (size == one.neg().ok()?).then(|| relation.mirrored())? };
    let relation = match turned {
        Relation::Eq | Relation::Lte => Relation::Eq,
        Relation::Neq | Relation::Gtr => Relation::Neq,
        Relation::Lss | Relation::Gte => return None,
    };
    Some((relation, inner.clone(), Value::zero()))
}

/// `E < b` of `max(0,E) < b` where b is above 0.
fn of_one_part(comparison: &Comparison, known: &Assumptions) -> Option<Comparison> {
    let (atom, relation, bound) = atom_and_bound(comparison, &|atom| matches!(atom, Atom::Maximum(_)))?;
    let Atom::Maximum(elements) = &atom else { return None };
    let zero = Value::zero();
    let is = |relation: Relation, part: &Value| known.decide(relation, part, &bound) == Some(true);
    let parts = std::iter::once(&zero).chain(elements.iter());
    // It is below a bound where each part is, and above where one is.
    let open: Vec<&Value> = match relation {
        Relation::Lss | Relation::Lte => parts.filter(|part| !is(relation, part)).collect(),
        Relation::Gtr | Relation::Gte => parts.filter(|part| !is(relation.negated(), part)).collect(),
        Relation::Eq | Relation::Neq => parts.filter(|part| !is(Relation::Lss, part)).collect(),
    };
    if let [part] = open.as_slice() { Some((relation, (*part).clone(), bound)) } else { None }
}

/// `y < 3` of `floor(y) < 3`.
fn of_what_is_rounded(comparison: &Comparison) -> Option<Comparison> {
    let (atom, relation, bound) = atom_and_bound(comparison, &|atom| matches!(atom, Atom::Floor(_)))?;
    let (Atom::Floor(inner), Some(bound)) = (&atom, bound.as_rational()) else { return None };
    let (relation, bound) = match relation {
        Relation::Lss | Relation::Gte => (relation, bound.ceil()),
        Relation::Lte => (Relation::Lss, bound.floor() + BigRational::one()),
        Relation::Gtr => (Relation::Gte, bound.floor() + BigRational::one()),
        Relation::Eq | Relation::Neq => return None,
    };
    Some((relation, inner.clone(), Value::rational(bound)))
}

/// Such an atom alone on the left of a comparison in which it stands with a number as its factor.
fn atom_and_bound(
    (relation, left, right): &Comparison,
    wanted: &dyn Fn(&Atom) -> bool,
) -> Option<(Atom, Relation, Value)> {
    let difference = left.sub(right).ok()?;
    let atom = difference.atoms().into_iter().find(wanted)?;
    let part = Name::new("[part]");
    let (factor, rest) = difference.with_atom(&atom, &Value::variable(&part)).ok()?.linear_in(&part)?;
    let number = factor.as_rational().filter(|number| !number.is_zero())?;
    let relation = if number.is_negative() { relation.mirrored() } else { *relation };
    Some((atom, relation, rest.neg().ok()?.div(&factor).ok()?))
}

fn without_signs((relation, left, right): &Comparison, known: &Assumptions) -> Option<Comparison> {
    let difference = left.sub(right).ok()?;
    let (mut above, below) = (difference.numerator()?, difference.denominator()?);
    let mut relation = *relation;
    let constant = below.as_rational().is_some();
    if !constant {
        // What has no value everywhere would have one without it.
        let plain = |value: &Value| value.atoms().iter().all(|atom| matches!(atom, Atom::Variable(_)));
        match divided(relation, &below, known).filter(|_| plain(&below)) {
            Some(turned) => relation = turned,
            // What is not 0 above has the sign of what is below, or the other one.
            None => (relation, above) = (divided(strict(relation)?, &above, known).filter(|_| plain(&above))?, below),
        }
    }
    let common = above.polynomials()?.0.monomial_content();
    let mut dropped = constant;
    for (atom, power) in common.factors() {
        let Atom::Variable(name) = atom else { continue };
        let factor = Value::variable(name);
        let turned = (0..*power).try_fold(relation, |relation, _| divided(relation, &factor, known));
        if let Some(turned) = turned {
            above = (0..*power).try_fold(above, |above, _| above.div(&factor).ok())?;
            (relation, dropped) = (turned, false);
        }
    }
    let alone = isolated(relation, &above);
    let content = above.polynomials()?.0.content();
    if alone.is_none() && dropped && content.is_one() {
        return None;
    }
    let whole = above.div(&Value::rational(content)).ok()?;
    Some(alone.unwrap_or((relation, whole, Value::zero())))
}

/// The relation of a value to 0 where that is not 0.
fn strict(relation: Relation) -> Option<Relation> {
    match relation {
        Relation::Gtr | Relation::Gte => Some(Relation::Gtr),
        Relation::Lss | Relation::Lte => Some(Relation::Lss),
        Relation::Eq | Relation::Neq => None,
    }
}

/// The relation of a value to 0 after it is divided by something, if the sign of this is known as far as it matters.
fn divided(relation: Relation, factor: &Value, known: &Assumptions) -> Option<Relation> {
    let is = |relation: Relation| known.decide(relation, factor, &Value::zero()) == Some(true);
    if matches!(relation, Relation::Eq | Relation::Neq) {
        return is(Relation::Neq).then_some(relation);
    }
    if is(Relation::Gtr) {
        return Some(relation);
    }
    is(Relation::Lss).then(|| relation.mirrored())
}

/// `a < 3/2` of `2*a-3 < 0`.
fn isolated(relation: Relation, value: &Value) -> Option<Comparison> {
    let names = value.variables();
    let (Some(name), true) = (names.first(), names.len() == 1) else { return None };
    let (factor, rest) = value.linear_in(name)?;
    let (factor, rest) = (factor.as_rational()?, rest.as_rational()?);
    let relation = if factor.is_negative() { relation.mirrored() } else { relation };
    Some((relation, Value::variable(name), Value::rational(-rest / factor)))
}
