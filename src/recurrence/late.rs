//! Comparisons of terms at late indices: maxima, absolute values, conditions and a root become what they are from some
//! index on, and what is left is an exponential polynomial (`tail`). A product of ratios is followed to where it moves
//! one way only.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

use super::classes::late_in_classes;
use super::product::quotient;
use super::reach::Wanted;
use crate::closed_form::{Form, Solved, product, sum_of};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{Tail, first_by_halves, outside, tail, tail_of_all};
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Atom, Relation, Value};

/// The latest index at which a product is looked at.
const MOST: u64 = 4_096;
/// Maxima and conditions that are looked into, one in the other.
const DEEPEST: usize = 20;

/// What is known of a comparison of terms at late indices.
pub(super) fn late(solved: &Solved, (relation, left, right): Wanted<'_>) -> Tail {
    let Ok(difference) = left.sub(right) else { return unbounded() };
    if let Some(found) = of_product(solved, relation, &difference).or_else(|| on_a_side(solved, relation, &difference))
    {
        return found;
    }
    let from = solved.recurrence().from.unsigned_abs();
    let mut search = Late { solved, from };
    let found = search.compare(&difference, relation).or_else(|| of_quotients(solved, relation, &difference));
    found.unwrap_or_else(unbounded)
}

/// The same where forms are quotients: what is divided by is not 0, so that a quotient has the sign of the product of what
/// stands above and below.
fn of_quotients(solved: &Solved, relation: Relation, difference: &Value) -> Option<Tail> {
    let recurrence = solved.recurrence();
    let (mut images, mut first) = (BTreeMap::new(), 0);
    for (place, sequence) in recurrence.sequences.iter().enumerate() {
        let name = recurrence.term(&sequence.name, 0);
        if difference.mentions(&name) {
            let Form::Value(early, value) = &solved.forms()[place] else { return None };
            first = first.max(early.len());
            images.insert(name, value.clone());
        }
    }
    let whole = difference.substitute(&images).ok()?;
    let product = whole.numerator()?.mul(&whole.denominator()?).ok()?;
    let sum = ExponentialPolynomial::of(&product, &recurrence.index)?;
    let found = tail(&sum, relation, recurrence.from.to_u64()?.saturating_add(first as u64));
    let divided = whole.denominator()?.mentions(&recurrence.index);
    Some(match found {
        // What outgrows all others is a part of the product, not of the quotient.
        Tail::Never(from, why) if divided => Tail::Never(from, why.split(": ").next().unwrap_or_default().to_string()),
        found => found,
    })
}

/// From which index on some values do not all stand in a relation to 0: in each turn one of them does not.
pub(super) fn late_in_turns(solved: &Solved, values: &[Value], relation: Relation) -> Option<Tail> {
    let (mut sums, mut from) = (Vec::new(), 0);
    for value in values {
        let Some((sum, early)) = sum_of(solved, value) else { return late_in_classes(solved, values, relation) };
        sums.push(sum);
        from = from.max(early);
    }
    let found = tail_of_all(&sums, relation, solved.recurrence().from.unsigned_abs() + from);
    Some(found).filter(|found| matches!(found, Tail::Never(..)))
}

/// The first index at which a comparison holds, of terms whose difference moves one way only from the first index on.
pub(super) fn rising(solved: &Solved, (relation, left, right): Wanted<'_>, stop: &dyn Fn() -> bool) -> Option<u64> {
    let from = solved.recurrence().from.to_u64()?;
    let (sum, early) = sum_of(solved, &left.sub(right).ok()?)?;
    (early == 0).then(|| first_by_halves(&sum, relation, from, stop)).flatten()
}

fn unbounded() -> Tail {
    Tail::Unknown("no bound of its later terms is known".to_string())
}

struct Late<'a> {
    solved: &'a Solved,
    /// From which index on all that was found holds.
    from: u64,
}

impl Late<'_> {
    fn compare(&mut self, difference: &Value, relation: Relation) -> Option<Tail> {
        if let Some(found) = self.outside(difference, relation) {
            return Some(found);
        }
        let settled = self.settled(difference, 0)?;
        let root = settled.atoms().into_iter().find(|atom| matches!(atom, Atom::Root(_)) && self.varies(atom));
        let Some(Atom::Root(inner)) = &root else { return self.tail(&settled, relation) };
        // a*sqrt(q) + b: with a > 0 it compares with 0 as q does with (b/a)^2, where b is not positive.
        let name = Name::new("[root]");
        let (factor, rest) = settled.with_atom(root.as_ref()?, &Value::variable(&name)).ok()?.linear_in(&name)?;
        let bound = -rest.as_rational()? / factor.as_rational()?;
        let relation = if factor.as_rational()?.is_positive() { relation } else { relation.mirrored() };
        if bound.is_negative() {
            let never = matches!(relation, Relation::Eq | Relation::Lss | Relation::Lte);
            return never.then(|| Tail::Never(self.from, "a square root is never negative".to_string()));
        }
        self.tail(&inner.sub(&Value::rational(&bound * &bound)).ok()?, relation)
    }

    /// `a*abs(e) + b` that is never at most 0, or 0, since e outgrows `b/a` on either side of 0.
    fn outside(&self, difference: &Value, relation: Relation) -> Option<Tail> {
        let (inner, bound) = distance(difference, relation)?;
        let (sum, early) = sum_of(self.solved, &inner)?;
        let from = self.solved.recurrence().from.unsigned_abs() + early;
        match outside(&sum, &bound, from.max(self.from)) {
            found @ Tail::Never(..) => Some(found),
            Tail::Unknown(_) => None,
        }
    }

    /// Whether an atom is not the same at all indices.
    fn varies(&self, atom: &Atom) -> bool {
        let recurrence = self.solved.recurrence();
        atom.mentions(&recurrence.index) || recurrence.terms().iter().any(|(name, ..)| atom.mentions(name))
    }

    /// The value with what its maxima and conditions are from some index on.
    fn settled(&mut self, value: &Value, depth: usize) -> Option<Value> {
        if depth > DEEPEST {
            return None;
        }
        let mut result = value.clone();
        let atoms: Vec<Atom> = value.atoms().into_iter().filter(|atom| self.varies(atom)).collect();
        for atom in atoms {
            let image = match &atom {
                Atom::Variable(_) | Atom::Power(..) => continue,
                Atom::Root(inner) => self.settled(inner, depth + 1)?.sqrt().ok()?,
                Atom::Positive(condition) => {
                    let condition = self.settled(condition, depth + 1)?;
                    if self.never(&condition, Relation::Lte) {
                        Value::one()
                    } else if self.never(&condition, Relation::Gtr) {
                        Value::zero()
                    } else {
                        return None;
                    }
                }
                Atom::Maximum(elements) => {
                    let mut all = vec![Value::zero()];
                    for element in elements.iter() {
                        all.push(self.settled(element, depth + 1)?);
                    }
                    self.greatest(&all)?
                }
                Atom::Floor(_) | Atom::Apply(..) => return None,
            };
            result = result.with_atom(&atom, &image).ok()?;
        }
        Some(result)
    }

    /// The one of some values that no other exceeds from some index on.
    fn greatest(&mut self, all: &[Value]) -> Option<Value> {
        for candidate in all {
            let from = self.from;
            let mut is = true;
            for other in all.iter().filter(|other| *other != candidate) {
                let difference = candidate.sub(other).ok()?;
                is = is && self.never(&difference, Relation::Lss);
            }
            if is {
                return Some(candidate.clone());
            }
            self.from = from;
        }
        None
    }

    /// Whether a value is never in a relation to 0 from some index on, which is then the one that all is known from.
    fn never(&mut self, value: &Value, relation: Relation) -> bool {
        match self.tail(value, relation) {
            Some(Tail::Never(from, _)) => {
                self.from = self.from.max(from);
                true
            }
            _ => false,
        }
    }

    fn tail(&self, value: &Value, relation: Relation) -> Option<Tail> {
        let (sum, early) = sum_of(self.solved, value)?;
        let from = self.solved.recurrence().from.unsigned_abs() + early;
        Some(tail(&sum, relation, from.max(self.from)))
    }
}

/// The e and b/a of `a*abs(e) + b`, where the relation to 0 asks e not to be farther from 0 than that.
pub(super) fn distance(difference: &Value, relation: Relation) -> Option<(Value, BigRational)> {
    let atoms: Vec<Atom> = difference.atoms().into_iter().filter(|atom| matches!(atom, Atom::Maximum(_))).collect();
    let [atom @ Atom::Maximum(elements)] = atoms.as_slice() else { return None };
    let [inner] = &**elements else { return None };
    let name = Name::new("[maximum]");
    let (factor, rest) = difference.with_atom(atom, &Value::variable(&name)).ok()?.linear_in(&name)?;
    // a*abs(e) = 2*a*max(0, e) - a*e
    let half = factor.as_rational()? / BigRational::from_integer(2.into());
    let constant = rest.add(&inner.mul(&Value::rational(half.clone())).ok()?).ok()?.as_rational()?;
    let near = match relation {
        Relation::Eq => true,
        Relation::Lss | Relation::Lte => half.is_positive(),
        Relation::Gtr | Relation::Gte => half.is_negative(),
        Relation::Neq => false,
    };
    let bound = -constant / half;
    (near && !bound.is_negative()).then(|| (inner.clone(), bound))
}

/// A distance from a product or a quotient that is never small enough, since it stays on one side.
fn on_a_side(solved: &Solved, relation: Relation, difference: &Value) -> Option<Tail> {
    let (inner, bound) = distance(difference, relation)?;
    let bound = Value::rational(bound);
    let never = |relation: Relation, value: Value| {
        let found = of_product(solved, relation, &value).or_else(|| of_quotients(solved, relation, &value));
        found.filter(|found| matches!(found, Tail::Never(..)))
    };
    never(Relation::Lte, inner.sub(&bound).ok()?).or_else(|| never(Relation::Gte, inner.add(&bound).ok()?))
}

/// A comparison that is linear in one product of ratios: from where its factors are positive and all at most 1, or all
/// at least 1, it moves one way only and keeps its sign.
fn of_product(solved: &Solved, relation: Relation, difference: &Value) -> Option<Tail> {
    let recurrence = solved.recurrence();
    let index = &recurrence.index;
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let [Form::Product(ratio, form)] = solved.forms() else { return None };
    let own = recurrence.term(&sequence.name, 0);
    let (factor, constant) = difference.with(&own, form).ok()?.linear_in(&product())?;
    let factor = factor.as_rational()?;
    let [top, bottom] = quotient(&constant, index)?;
    let whole = bottom.degree() == 0 && !bottom.is_zero();
    let beside = whole.then(|| top.scale(&bottom.coefficient(0).recip()))?;
    let slope = beside.derivative();
    let [above, below] = quotient(ratio, index)?;
    let beyond = above.minus(&below);
    let all = [&above, &below, &beyond, &slope];
    let bound = all.iter().filter_map(|one| largest(one)).max()?.to_u64().filter(|bound| *bound < MOST)?;
    let from = bound.max(recurrence.from.unsigned_abs());
    let at =
        |from: u64| -> Option<BigRational> { solved.at(&sequence.name, i64::try_from(from).ok()?).ok()?.as_rational() };
    let value = |from: u64| {
        let here = difference.with(&own, &Value::rational(at(from)?)).ok()?;
        here.with(index, &Value::integer(i64::try_from(from).ok()?)).ok()?.as_rational()
    };
    let constant = beside.at(&BigRational::from_integer(from.into()));
    let part = value(from)? - &constant;
    if !slope.is_zero() && (part.is_zero() || factor.is_zero()) {
        return None;
    }
    if part.is_zero() || factor.is_zero() {
        return (!compares(relation, &constant)).then(|| Tail::Never(from, "from there on it is 0".to_string()));
    }
    let number = BigRational::from_integer((from + 1).into());
    let (top, bottom) = (above.at(&number), below.at(&number));
    if !(&top / &bottom).is_positive() {
        return None;
    }
    // With rising = true the difference grows from here on; all is told of a difference that grows.
    let swells = (&top / &bottom) > BigRational::one();
    let rising = swells == part.is_positive();
    // What stands beside the product has to move the same way.
    if !slope.is_zero() && slope.coefficient(slope.degree()).is_positive() != rising {
        return None;
    }
    let turn = |number: BigRational| if rising { number } else { -number };
    let (relation, part, constant) = (if rising { relation } else { relation.mirrored() }, turn(part), turn(constant));
    let reason = |what: &str| {
        let ratio = if swells { "at least" } else { "at most" };
        format!("from there on {what}: its factors stay positive and {ratio} 1")
    };
    match relation {
        // The part that is a product keeps its sign, so that the whole stays beyond the constant.
        Relation::Eq | Relation::Gtr | Relation::Gte
            if part.is_negative() && !constant.is_positive() && slope.is_zero() =>
        {
            Some(Tail::Never(from, reason("it does not come there")))
        }
        Relation::Eq | Relation::Lss | Relation::Lte => {
            let mut at = from;
            while at < MOST {
                if turn(value(at)?).is_positive() {
                    return Some(Tail::Never(at, reason("it moves away")));
                }
                at = (at + 1) * 2;
            }
            None
        }
        _ => None,
    }
}

/// Whether a number stands in a relation to 0.
fn compares(relation: Relation, number: &BigRational) -> bool {
    match relation {
        Relation::Eq => number.is_zero(),
        Relation::Neq => !number.is_zero(),
        Relation::Gtr => number.is_positive(),
        Relation::Gte => !number.is_negative(),
        Relation::Lss => number.is_negative(),
        Relation::Lte => !number.is_positive(),
    }
}

/// A whole number beyond all real roots of a polynomial (Cauchy's bound); none for 0.
fn largest(polynomial: &Univariate) -> Option<BigInt> {
    let lead = polynomial.coefficient(polynomial.degree());
    if lead.is_zero() {
        return None;
    }
    let most = polynomial.coefficients().iter().map(|number| (number / &lead).abs()).max()?;
    Some(most.ceil().to_integer() + BigInt::one())
}
