//! Comparisons in products of terms of a linear system, as a distance from a point is one in squares: the products are
//! sequences of a linear system, too, whose late terms are those of exponential polynomials.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{One, Signed};

use super::late::late;
use super::reach::Wanted;
use super::solve_until;
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence};
use crate::exponential_polynomial::tail::Tail;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, View};

/// The highest degree of a product, and the most of them.
const MOST_DEGREE: usize = 3;
const MOST_PRODUCTS: usize = 24;

/// From which index on a comparison holds no more, where one that it implies is of products of terms.
pub(super) fn late_products(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Tail> {
    let difference = left.sub(right).ok()?;
    let (relation, value) = match relation {
        Relation::Gtr | Relation::Gte => (relation.mirrored(), difference.neg().ok()?),
        _ => (relation, difference),
    };
    let near = matches!(relation, Relation::Lss | Relation::Lte | Relation::Eq);
    let implied = near.then(|| in_squares(&value)).flatten();
    let of_squares = implied.is_some();
    let (relation, value) = implied.map_or((relation, value), |value| (Relation::Lte, value));
    let (wider, value) = with_products(recurrence, &value)?;
    let solved = solve_until(wider, known, stop).ok()?;
    match late(&solved, (relation, &value, &Value::zero())) {
        Tail::Never(from, why) if of_squares => {
            Some(Tail::Never(from, why.replace(": its part", ": of its squares the part")))
        }
        found @ Tail::Never(..) => Some(found),
        Tail::Unknown(_) => None,
    }
}

/// What is at most 0 wherever a sum of sizes less a number is, or the greatest of sizes: their squares are then small.
fn in_squares(difference: &Value) -> Option<Value> {
    let maxima: Vec<Atom> = difference.atoms().into_iter().filter(|atom| matches!(atom, Atom::Maximum(_))).collect();
    let square = |value: &Value| value.mul(value).ok();
    if let [atom @ Atom::Maximum(elements)] = maxima.as_slice()
        && elements.len() > 1
    {
        return of_greatest(difference, atom, elements);
    }
    // a*|e| + b*|d| + … - r, where |e| = 2*max(0,e)-e
    let (mut rest, mut whole) = (difference.clone(), Value::zero());
    for atom in &maxima {
        let Atom::Maximum(elements) = atom else { continue };
        let [inner] = &**elements else { return None };
        let name = Name::new("[maximum]");
        let (factor, others) = rest.with_atom(atom, &Value::variable(&name)).ok()?.linear_in(&name)?;
        let half = factor.as_rational().filter(Signed::is_positive)? / BigRational::from_integer(2.into());
        let own = inner.mul(&Value::rational(half)).ok()?;
        whole = whole.add(&square(&own)?).ok()?;
        rest = others.add(&own).ok()?;
    }
    let bound = Value::rational(rest.as_rational().filter(|_| !maxima.is_empty())?);
    whole.sub(&square(&bound)?).ok()
}

/// The same of `max(e, -e, d, -d, …) - r`, which is written with one of them taken out of the maximum with 0.
fn of_greatest(difference: &Value, atom: &Atom, elements: &[Value]) -> Option<Value> {
    let name = Name::new("[maximum]");
    let (factor, rest) = difference.with_atom(atom, &Value::variable(&name)).ok()?.linear_in(&name)?;
    let factor = Value::rational(factor.as_rational().filter(Signed::is_positive)?);
    let first = rest.div(&factor).ok()?;
    let others = elements.iter().map(|one| one.add(&first).ok()).collect::<Option<Vec<Value>>>()?;
    // Each less r: one and its opposite give `-2*r`.
    let double = others.iter().find_map(|other| other.add(&first).ok()?.as_rational())?;
    let bound = Value::rational(-double / BigRational::from_integer(2.into()));
    let all = others.iter().chain([&first]).map(|one| one.add(&bound).ok()).collect::<Option<Vec<Value>>>()?;
    let both = all.iter().all(|one| one.neg().is_ok_and(|opposite| all.contains(&opposite)));
    let square = |value: &Value| value.mul(value).ok();
    let whole = all.iter().try_fold(Value::zero(), |sum, one| sum.add(&square(one)?).ok())?;
    let many = Value::integer(i64::try_from(all.len()).ok()?);
    both.then_some(whole.sub(&square(&bound)?.mul(&many).ok()?).ok()).flatten()
}

/// A system with the products of terms in a value as sequences of their own, and the value in these; nothing where it has
/// none, or the system is not linear with numbers alone.
fn with_products(recurrence: &Recurrence, value: &Value) -> Option<(Recurrence, Value)> {
    let index = &recurrence.index;
    // Each term with what it is at the next index.
    let terms = recurrence.terms();
    let mut steps = BTreeMap::new();
    for (name, place, offset) in &terms {
        let sequence = &recurrence.sequences[*place];
        let next = match offset + 1 < sequence.start.len() {
            true => Value::variable(&recurrence.term(&sequence.name, offset + 1)),
            false => sequence.next.clone(),
        };
        let of_terms = next.variables().iter().all(|own| terms.iter().any(|(term, ..)| term == own));
        steps.insert(name.clone(), Some(next).filter(|_| of_terms)?);
    }
    let starts: BTreeMap<Name, Value> = terms
        .iter()
        .map(|(name, place, offset)| (name.clone(), recurrence.sequences[*place].start[*offset].clone()))
        .collect();
    let mut products: BTreeSet<Vec<Name>> = BTreeSet::new();
    let mut sequences: Vec<Sequence> = Vec::new();
    let renamed = named(value, &steps, &mut products)?;
    if products.is_empty() {
        return None;
    }
    let mut done: BTreeSet<Vec<Name>> = BTreeSet::new();
    while let Some(product) = products.iter().find(|product| !done.contains(*product)).cloned() {
        if products.len() > MOST_PRODUCTS {
            return None;
        }
        let whole = product.iter().try_fold(Value::one(), |all, name| all.mul(&Value::variable(name)).ok())?;
        let next = named(&whole.substitute(&steps).ok()?, &steps, &mut products)?;
        sequences.push(Sequence { name: called(&product), start: vec![whole.substitute(&starts).ok()?], next });
        done.insert(product);
    }
    // The index of the whole is the same, and so are its terms.
    for sequence in &mut sequences {
        sequence.next = at_index(&sequence.next, &products, index)?;
    }
    Some((Recurrence { index: index.clone(), from: recurrence.from, sequences }, at_index(&renamed, &products, index)?))
}

/// The name of the sequence of a product.
fn called(product: &[Name]) -> Name {
    let names: Vec<&str> = product.iter().map(Name::as_str).collect();
    Name::new(&format!("[{}]", names.join("*")))
}

/// The names of sequences as their terms.
fn at_index(value: &Value, products: &BTreeSet<Vec<Name>>, index: &Name) -> Option<Value> {
    let term = |product: &Vec<Name>| {
        let name = called(product);
        let term = Value::variable(&crate::closed_form::term(&name, index, 0));
        (name, term)
    };
    value.substitute(&products.iter().map(term).collect()).ok()
}

/// A polynomial in terms with a name for each product of them, of one too; each is put down. Nothing for another value, or
/// one in which the index meets a product.
fn named(value: &Value, steps: &BTreeMap<Name, Value>, products: &mut BTreeSet<Vec<Name>>) -> Option<Value> {
    let View::Real(sum, below) = value.view() else { return None };
    let [(divisor, factors)] = below.as_slice() else { return None };
    if !divisor.is_one() || !factors.is_empty() {
        return None;
    }
    let mut whole = Value::zero();
    for (number, factors) in sum {
        let (mut product, mut rest) = (Vec::new(), Value::rational(number));
        for (atom, power) in factors {
            match atom {
                Atom::Variable(name) if steps.contains_key(&name) => {
                    product.extend(std::iter::repeat_n(name, power as usize));
                }
                atom if steps.keys().any(|name| atom.mentions(name)) => return None,
                atom => rest = rest.mul(&atom.value().ok()?.power(&Value::integer(power.into())).ok()?).ok()?,
            }
        }
        if product.len() > MOST_DEGREE || (!product.is_empty() && rest.as_rational().is_none()) {
            return None;
        }
        if !product.is_empty() {
            product.sort();
            rest = rest.mul(&Value::variable(&called(&product))).ok()?;
            products.insert(product);
        }
        whole = whole.add(&rest).ok()?;
    }
    Some(whole)
}
