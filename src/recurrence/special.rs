//! What a closed form leaves out: where it needs `a != b`, the recurrence is solved once more with b in place of a.

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence, Solved};
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Atom, Relation, Value, View};

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
            for (name, image) in parameters(left, right, general.recurrence(), &known) {
                let mut known = known.clone();
                known.assume(Relation::Eq, &Value::variable(&name), &image);
                let mut equations = equations.clone();
                equations.push((Value::variable(&name), image.clone()));
                let Some(special) = with(general.recurrence(), &name, &image) else { continue };
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

/// The parameters that an equation gives, each with a value: the first of which it is linear in with a factor that is not
/// 0, or the rational roots of an equation in one alone.
fn parameters(left: &Value, right: &Value, recurrence: &Recurrence, known: &Assumptions) -> Vec<(Name, Value)> {
    let Ok(difference) = left.sub(right) else { return Vec::new() };
    let whole = difference.denominator().and_then(|below| difference.mul(&below).ok()).unwrap_or(difference);
    let terms = recurrence.terms();
    let free = |name: &Name| *name != recurrence.index && terms.iter().all(|(term, ..)| term != name);
    let solved = |name: &Name| {
        let (factor, rest) = whole.linear_in(name)?;
        if known.decide(Relation::Neq, &factor, &Value::zero()) != Some(true) {
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

/// A recurrence with a value in place of a parameter.
fn with(recurrence: &Recurrence, name: &Name, image: &Value) -> Option<Recurrence> {
    let mut special = recurrence.clone();
    for sequence in &mut special.sequences {
        sequence.next = sequence.next.with(name, image).ok()?;
        for value in &mut sequence.start {
            *value = value.with(name, image).ok()?;
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
        images
            .collect::<Option<Vec<_>>>()?
            .into_iter()
            .try_fold(value.clone(), |value, (name, image)| value.with(name, image).ok())
    }

    /// What must hold beyond that.
    pub fn conditions(&self) -> &[Comparison] {
        self.solved.conditions()
    }
}
