//! Tests with maxima and conditions into cases without: in each the tests are plain.

use std::collections::BTreeSet;

use num_traits::Signed;

use crate::assumption::Assumptions;
use crate::period::Test;
use crate::value::{Atom, Relation, Sort, Value, ValueError, View};

/// Cases that one question may split into.
const MOST_CASES: usize = 4_096;

/// A conjunction of tests without maxima and conditions.
#[derive(Clone, Debug, Default)]
pub struct Case {
    /// The tests.
    pub tests: Vec<Test>,
    /// What was assumed before, with the tests.
    pub assumptions: Assumptions,
}

/// The cases in which all tests hold: together they say the same as the tests. Cases that linear arithmetic shows to
/// contradict the assumptions are left out.
///
/// # Errors
/// When there are too many, or a value has no normal form.
pub fn cases(assumptions: &Assumptions, tests: &[Test]) -> Result<Vec<Case>, ValueError> {
    let mut found = Vec::new();
    each_case(assumptions, tests, Relation::Gte, &mut |case| {
        found.push(case);
        true
    })?;
    Ok(found)
}

/// Whether no values meet all tests, under the assumptions; false also where that is not found out.
pub fn impossible(assumptions: &Assumptions, tests: &[Test]) -> bool {
    let mut all = true;
    let mut rule_out = |case: Case| {
        all = case.assumptions.contradictory();
        all
    };
    each_case(assumptions, tests, Relation::Gte, &mut rule_out).is_ok() && all
}

/// The cases in which all tests hold, of which no two hold at once: where elements of a maximum are equal, it is the
/// first of them. What is counted case by case is counted once.
///
/// # Errors
/// When there are too many, or a value has no normal form.
pub fn disjoint(assumptions: &Assumptions, tests: &[Test]) -> Result<Vec<Case>, ValueError> {
    let mut found = Vec::new();
    for tests in alternatives(conjunctions(tests)?)? {
        each_case(assumptions, &tests, Relation::Gtr, &mut |case| {
            found.push(case);
            true
        })?;
    }
    Ok(found)
}

/// The tests with `max(a,b) > c` as `a > c`, or `b > c` and not `a > c`: the cases do not compare a with b, and where
/// these are apart, so are the cases. Of two elements, which are one distance most often, the cases are as simple anyway.
fn alternatives(tests: Vec<Test>) -> Result<Vec<Vec<Test>>, ValueError> {
    let (mut work, mut all) = (vec![tests], Vec::new());
    while let Some(tests) = work.pop() {
        if work.len() + all.len() > MOST_CASES {
            return Err(ValueError("there are too many cases".to_string()));
        }
        let mut wide = None;
        for (place, test) in tests.iter().enumerate() {
            if let Some(parts) = by_element(test, false)?.filter(|parts| parts.len() > 2) {
                wide = Some((place, parts));
                break;
            }
        }
        let Some((place, parts)) = wide else {
            all.push(tests);
            continue;
        };
        for (number, part) in parts.iter().enumerate().rev() {
            let mut case = tests.clone();
            case.remove(place);
            case.extend(parts[..number].iter().map(Test::negated));
            case.push(part.clone());
            work.push(conjunctions(&case)?);
        }
    }
    Ok(all)
}

/// The tests with `max(a,b) <= c` as `a <= c` and `b <= c`, which needs no cases.
///
/// # Errors
/// When a value has no normal form.
pub fn conjunctions(tests: &[Test]) -> Result<Vec<Test>, ValueError> {
    let mut work: Vec<Test> = tests.iter().rev().cloned().collect();
    let mut all = Vec::new();
    while let Some(test) = work.pop() {
        match by_element(&test, true)? {
            Some(parts) => work.extend(parts.into_iter().rev()),
            None => all.push(test),
        }
    }
    Ok(all)
}

/// A comparison that bounds a maximum from above, or from below, as one of each of its elements.
fn by_element(test: &Test, from_above: bool) -> Result<Option<Vec<Test>>, ValueError> {
    if test.left.sort() != Sort::Real || test.right.sort() != Sort::Real {
        return Ok(None);
    }
    let (difference, zero) = (test.left.sub(&test.right)?, Value::zero());
    for atom in difference.atoms() {
        let Atom::Maximum(elements) = &atom else { continue };
        let places = [Value::zero(), Value::one()].map(|place| difference.with_atom(&atom, &place));
        let [Ok(rest), Ok(once)] = places else { continue };
        let factor = once.sub(&rest)?;
        let Some(number) = factor.as_rational() else { continue };
        let above = match test.relation {
            Relation::Lss | Relation::Lte => number.is_positive(),
            Relation::Gtr | Relation::Gte => number.is_negative(),
            _ => false,
        };
        let ordered = !matches!(test.relation, Relation::Eq | Relation::Neq);
        if !ordered || above != from_above || factor.mul(&atom.value()?)?.add(&rest)? != difference {
            continue;
        }
        let part = |element: &Value| {
            let left = factor.mul(element)?.add(&rest)?;
            Ok(Test { relation: test.relation, left, right: Value::zero() })
        };
        // A maximum in normal form is over 0 as well.
        let all = std::iter::once(&zero).chain(elements.iter());
        return all.map(part).collect::<Result<_, _>>().map(Some);
    }
    Ok(None)
}

/// Hands out case after case, for as long as the taker wants more; `earlier` is how the element that is the maximum
/// compares with those before it.
fn each_case(
    assumptions: &Assumptions,
    tests: &[Test],
    earlier: Relation,
    take: &mut dyn FnMut(Case) -> bool,
) -> Result<(), ValueError> {
    let start = Case { tests: Vec::new(), assumptions: with_products(assumptions, tests)? };
    let mut work = vec![(start, tests.to_vec())];
    let mut steps = 0usize;
    while let Some((mut case, pending)) = work.pop() {
        steps += 1;
        if steps > MOST_CASES {
            return Err(ValueError("there are too many cases".to_string()));
        }
        let (rest, plain): (Vec<Test>, Vec<Test>) = pending.into_iter().partition(|test| piecewise(test).is_some());
        for test in plain {
            if constant(&test) != Some(true) && !case.tests.contains(&test) {
                case.assumptions.assume(test.relation, &test.left, &test.right);
                case.tests.push(test);
            }
        }
        if case.tests.iter().any(|test| constant(test) == Some(false)) || case.assumptions.plainly_contradictory() {
            continue;
        }
        let Some(atom) = rest.iter().find_map(piecewise) else {
            if take(case) {
                continue;
            }
            return Ok(());
        };
        for (mut pending, image) in branches(&atom, earlier)? {
            for test in &rest {
                pending.push(Test {
                    relation: test.relation,
                    left: replaced(&test.left, &atom, &image)?,
                    right: replaced(&test.right, &atom, &image)?,
                });
            }
            work.push((case.clone(), pending));
        }
    }
    Ok(())
}

/// The assumptions with the signs of the products that stand in the tests, where they are known: linear arithmetic
/// does not see them by itself.
fn with_products(assumptions: &Assumptions, tests: &[Test]) -> Result<Assumptions, ValueError> {
    let mut products = BTreeSet::new();
    for value in tests.iter().flat_map(|test| [&test.left, &test.right]) {
        collect_products(value, &mut products)?;
    }
    let mut with = assumptions.clone();
    for product in products {
        if assumptions.decide(Relation::Gtr, &product, &Value::zero()) == Some(true) {
            with.assume(Relation::Gtr, &product, &Value::zero());
        }
    }
    Ok(with)
}

fn collect_products(value: &Value, found: &mut BTreeSet<Value>) -> Result<(), ValueError> {
    let View::Real(numerator, denominator) = value.view() else { return Ok(()) };
    for (_, factors) in numerator.iter().chain(&denominator) {
        let mut product = Value::one();
        for (atom, exponent) in factors {
            for part in parts(atom) {
                collect_products(&part, found)?;
            }
            product = product.mul(&atom.value()?.power(&Value::integer(i64::from(*exponent)))?)?;
        }
        let plain = factors.iter().all(|(atom, _)| matches!(atom, Atom::Variable(_)));
        if plain && (factors.len() > 1 || factors.iter().any(|(_, exponent)| *exponent > 1)) {
            found.insert(product);
        }
    }
    Ok(())
}

/// Whether a comparison of numbers holds.
fn constant(test: &Test) -> Option<bool> {
    let (left, right) = (test.left.as_rational()?, test.right.as_rational()?);
    Some(test.relation.holds(left.cmp(&right)))
}

/// A maximum or condition whose own parts are plain.
fn piecewise(test: &Test) -> Option<Atom> {
    innermost(&test.left).or_else(|| innermost(&test.right))
}

fn innermost(value: &Value) -> Option<Atom> {
    if value.sort() != Sort::Real {
        return None;
    }
    for atom in value.atoms() {
        if let Some(inner) = parts(&atom).iter().find_map(innermost) {
            return Some(inner);
        }
        if matches!(atom, Atom::Maximum(_) | Atom::Positive(_)) {
            return Some(atom);
        }
    }
    None
}

fn parts(atom: &Atom) -> Vec<Value> {
    match atom {
        Atom::Variable(_) => Vec::new(),
        Atom::Power(base, exponent) => vec![base.clone(), exponent.clone()],
        Atom::Maximum(parts) | Atom::Apply(_, parts) => parts.to_vec(),
        Atom::Positive(part) | Atom::Floor(part) | Atom::Root(part) => vec![part.clone()],
    }
}

/// A value with another for an atom, however deep that stands.
fn replaced(value: &Value, atom: &Atom, image: &Value) -> Result<Value, ValueError> {
    if value.sort() != Sort::Real {
        return Ok(value.clone());
    }
    let mut result = value.clone();
    for other in value.atoms() {
        let new = if other == *atom {
            image.clone()
        } else {
            let old = parts(&other);
            let new: Vec<Value> = old.iter().map(|part| replaced(part, atom, image)).collect::<Result<_, _>>()?;
            if new == old {
                continue;
            }
            rebuilt(&other, &new)?
        };
        result = result.with_atom(&other, &new)?;
    }
    Ok(result)
}

/// An atom with new parts.
fn rebuilt(atom: &Atom, parts: &[Value]) -> Result<Value, ValueError> {
    match (atom, parts) {
        (Atom::Power(..), [base, exponent]) => base.power(exponent),
        (Atom::Maximum(_), parts) => {
            Value::maximum(&std::iter::once(Value::zero()).chain(parts.iter().cloned()).collect::<Vec<_>>())
        }
        (Atom::Apply(function, _), parts) => Value::apply(function, parts),
        (Atom::Positive(_), [part]) => Value::truth(Relation::Gtr, part, &Value::zero()),
        (Atom::Floor(_), [part]) => part.floor(),
        (Atom::Root(_), [part]) => part.sqrt(),
        _ => atom.value(),
    }
}

/// What an atom is, and when: the conditions of the branches cover all values.
fn branches(atom: &Atom, earlier: Relation) -> Result<Vec<(Vec<Test>, Value)>, ValueError> {
    let zero = Value::zero();
    let test =
        |relation: Relation, left: &Value, right: &Value| Test { relation, left: left.clone(), right: right.clone() };
    match atom {
        Atom::Positive(inner) => Ok(vec![
            (vec![test(Relation::Gtr, inner, &zero)], Value::one()),
            (vec![test(Relation::Lte, inner, &zero)], zero.clone()),
        ]),
        Atom::Maximum(parts) => {
            let elements: Vec<Value> = std::iter::once(zero).chain(parts.iter().cloned()).collect();
            let greatest = |place: usize| {
                let others = elements.iter().enumerate().filter(move |(other, _)| *other != place);
                let relation = |other: usize| if other < place { earlier } else { Relation::Gte };
                others.map(|(at, other)| test(relation(at), &elements[place], other)).collect::<Vec<_>>()
            };
            Ok(elements.iter().enumerate().map(|(place, element)| (greatest(place), element.clone())).collect())
        }
        _ => Err(ValueError("this value has no cases".to_string())),
    }
}
