//! What a closed form leaves out: where it needs `a != b`, the recurrence is solved once more with b in place of a.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved};
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Atom, Need, Relation, Value, View};

use super::solve_until;

/// The most cases, and the most equations that one may need.
const MOST_CASES: usize = 6;
const MOST_EQUATIONS: usize = 2;
/// The highest degree of an equation in one parameter of which the roots are looked for.
const MOST_DEGREE: usize = 12;

/// A recurrence with values in place of parameters, and its forms.
#[derive(Clone, Debug)]
pub struct Special {
    /// What is equal here.
    pub equations: Vec<(Value, Value)>,
    /// The recurrence in which it has been put in, with its forms.
    pub solved: Solved,
}

/// The cases that are left out by conditions of forms, as far as they have forms of their own.
pub fn special_cases(solved: &Solved, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Special> {
    let mut found: Vec<Special> = Vec::new();
    let mut open = vec![(Vec::new(), solved.clone(), known.clone())];
    while let Some((equations, general, known)) = open.pop() {
        if equations.len() >= MOST_EQUATIONS {
            continue;
        }
        for (relation, left, right) in general.conditions() {
            if !matches!(relation, Relation::Neq | Relation::Gtr) || found.len() >= MOST_CASES {
                continue;
            }
            for images in alternatives(left, right, general.recurrence(), &known) {
                let mut known = known.clone();
                let mut equations = equations.clone();
                for (name, image) in &images {
                    if let Some(below) = image.denominator() {
                        known.assume(Relation::Neq, &below, &Value::zero());
                    }
                    known.assume(Relation::Eq, &Value::variable(name), image);
                    equations.push((Value::variable(name), image.clone()));
                }
                if known.contradictory() {
                    continue;
                }
                let Some(special) = with(general.recurrence(), &images, &known) else { continue };
                // One recurrence may come of several equations in turn, and of two values of one parameter.
                let known_already = |other: &Special| {
                    let alone = other.equations.len() == 1 && equations.len() == 1;
                    other.solved.recurrence() == &special && (!alone || other.equations == equations)
                };
                if found.iter().any(known_already) {
                    continue;
                }
                if let Ok(solved) = solve_until(special, &known, stop) {
                    open.push((equations.clone(), solved.clone(), known));
                    found.push(Special { equations, solved });
                }
            }
        }
    }
    found.sort_by_key(|special| special.equations.len());
    found
}

/// What an equation gives, in each way in which it may hold: one parameter, or all that a length must be 0 by.
fn alternatives(left: &Value, right: &Value, recurrence: &Recurrence, known: &Assumptions) -> Vec<Vec<(Name, Value)>> {
    let length = left.sub(right).ok().and_then(|difference| parts_of_length(&difference));
    match length {
        Some(parts) => no_length(&parts, recurrence, known).into_iter().collect(),
        None => parameters(left, right, recurrence, known).into_iter().map(|one| vec![one]).collect(),
    }
}

/// The parts of which a value is the length, up to a number as its factor.
fn parts_of_length(value: &Value) -> Option<Vec<Value>> {
    let View::Real(terms, below) = value.view() else { return None };
    let ([(_, factors)], true) = (terms.as_slice(), below.iter().all(|(_, factors)| factors.is_empty())) else {
        return None;
    };
    let mut roots = factors.iter().filter_map(|(atom, _)| match atom {
        Atom::Root(inner) if inner.as_rational().is_none() => Some(inner.squares()),
        Atom::Root(_) => None,
        _ => Some(None),
    });
    roots.next().flatten().filter(|_| roots.next().is_none())
}

/// The parameters by which all these are 0, each with a value free of the others; `None` where they cannot be, or each of
/// them does not give one.
fn no_length(parts: &[Value], recurrence: &Recurrence, known: &Assumptions) -> Option<Vec<(Name, Value)>> {
    let mut images: Vec<(Name, Value)> = Vec::new();
    for part in parts {
        let part = images.iter().try_fold(part.clone(), |part, (name, image)| part.with(name, image).ok())?;
        if part.is_zero() {
            continue;
        }
        let (name, image) = parameters(&part, &Value::zero(), recurrence, known).into_iter().next()?;
        for (_, earlier) in &mut images {
            *earlier = earlier.with(&name, &image).ok()?;
        }
        images.push((name, image));
    }
    (!images.is_empty()).then_some(images)
}

/// The parameters that an equation gives, each with a value: the first of which it is linear in with a factor that is not
/// 0, or the rational roots of an equation in one alone.
fn parameters(left: &Value, right: &Value, recurrence: &Recurrence, known: &Assumptions) -> Vec<(Name, Value)> {
    let Ok(difference) = left.sub(right) else { return Vec::new() };
    let whole = difference.denominator().and_then(|below| difference.mul(&below).ok()).unwrap_or(difference);
    let terms = recurrence.terms();
    let free = |name: &Name| *name != recurrence.index && terms.iter().all(|(term, ..)| term != name);
    let solved = |name: &Name| {
        let (factor, rest) = whole.linear_in(name)?;
        // Where the rest is not 0 the factor is not either.
        if [&factor, &rest].iter().all(|part| known.decide(Relation::Neq, part, &Value::zero()) != Some(true)) {
            return None;
        }
        Some((name.clone(), rest.neg().ok()?.div(&factor).ok()?))
    };
    let names: Vec<Name> = whole.variables().into_iter().filter(free).collect();
    // With a number as factor before one with a parameter.
    let plain = |name: &Name| whole.linear_in(name).is_some_and(|(factor, _)| factor.as_rational().is_some());
    let found = names.iter().filter(|name| plain(name)).find_map(solved).or_else(|| names.iter().find_map(solved));
    let possible =
        |(name, image): &(Name, Value)| known.decide(Relation::Eq, &Value::variable(name), image) != Some(false);
    found.map_or_else(|| roots(&whole), |one| vec![one]).into_iter().filter(possible).collect()
}

/// The rational roots of a polynomial in one variable.
fn roots(polynomial: &Value) -> Vec<(Name, Value)> {
    let names = polynomial.variables();
    let (Some(name), View::Real(terms, _)) = (names.first(), polynomial.view()) else { return Vec::new() };
    let mut coefficients: Vec<BigRational> = Vec::new();
    for (number, factors) in terms {
        let power = match factors.as_slice() {
            [] => 0,
            [(Atom::Variable(own), power)] if own == name => *power as usize,
            _ => return Vec::new(),
        };
        if power > MOST_DEGREE {
            return Vec::new();
        }
        coefficients.resize(coefficients.len().max(power + 1), BigRational::zero());
        coefficients[power] += number;
    }
    let linear = Univariate::new(coefficients).factors().into_iter().filter(|(factor, _)| factor.degree() == 1);
    let root = |factor: Univariate| -factor.coefficient(0) / factor.coefficient(1);
    linear.map(|(factor, _)| (name.clone(), Value::rational(root(factor)))).collect()
}

/// A value with others in place of parameters; `None` where it may then have none: `1/0^n` is not 1.
fn put_in<'i>(
    value: &Value,
    images: impl IntoIterator<Item = (&'i Name, &'i Value)>,
    known: &Assumptions,
) -> Option<Value> {
    let one = |value: Value, (name, image): (&Name, &Value)| {
        let images = BTreeMap::from([(name.clone(), image.clone())]);
        let (needs, image) = (value.needs_with(&images).ok()?, value.substitute(&images).ok()?);
        let shown = image.needs();
        // Where it divides by 0 and yet has a value, a condition has excluded the division. Exponents count.
        let kept = |need: &Need| {
            let counts = matches!(need, Need::Natural(_)) || need.value().is_zero();
            counts || need.follows_from(&shown) || known.grants(need) == Some(true)
        };
        needs.iter().all(kept).then_some(image)
    };
    images.into_iter().try_fold(value.clone(), one)
}

/// A recurrence with values in place of parameters.
fn with(recurrence: &Recurrence, images: &[(Name, Value)], known: &Assumptions) -> Option<Recurrence> {
    let put_in = |value: &Value| put_in(value, images.iter().map(|(name, image)| (name, image)), known);
    let mut special = recurrence.clone();
    for sequence in &mut special.sequences {
        sequence.next = put_in(&sequence.next)?;
        for value in &mut sequence.start {
            *value = put_in(value)?;
        }
    }
    Some(special)
}

impl Special {
    /// `a = b, c = 1`
    pub fn title(&self) -> String {
        let each = |(left, right): &(Value, Value)| format!("{left} = {right}");
        self.equations.iter().map(each).collect::<Vec<_>>().join(", ")
    }

    /// A value with what is equal here.
    pub fn put_in(&self, value: &Value) -> Option<Value> {
        let images = self.equations.iter().map(|(name, image)| Some((name.as_variable()?, image)));
        put_in(value, images.collect::<Option<Vec<_>>>()?, self.solved.known())
    }

    /// What must hold beyond that.
    pub fn conditions(&self) -> &[Comparison] {
        self.solved.conditions()
    }
}
