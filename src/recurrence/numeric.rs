//! Terms of recurrences without parameters as plain rational numbers: the expressions are laid out once, and each term is
//! computed from those before it without building values.

mod arithmetic;
mod number;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::polynomial::{Monomial, Polynomial};
use crate::value::{Atom, Relation, Value};
pub(super) use arithmetic::{Arithmetic, Near};
pub(super) use number::Number;

/// A quotient of polynomials in numbered numbers and in what is computed from these, beside a polynomial.
struct Expression<N> {
    /// None for 0.
    whole: Option<Vec<Summand<N>>>,
    numerator: Vec<Summand<N>>,
    /// None for 1.
    denominator: Option<Vec<Summand<N>>>,
}

struct Summand<N> {
    coefficient: N,
    factors: Vec<(Factor<N>, u32)>,
}

enum Factor<N> {
    /// A number of the state, the last of which is the index.
    Place(usize),
    /// The greatest of 0 and these.
    Maximum(Vec<Expression<N>>),
    /// 1 where this is above 0, else 0.
    Positive(Expression<N>),
    Floor(Expression<N>),
    Power(Expression<N>, Expression<N>),
    Root(Expression<N>),
}

/// A recurrence of numbers and a comparison of its terms.
pub(super) struct Numeric<N = Number> {
    /// For each number of the state the place of the next one, or the expression that gives it.
    steps: Vec<Result<usize, Expression<N>>>,
    goal: Goal<N>,
    /// The numbers of the state, and the index.
    state: Vec<N>,
    /// The first index.
    from: BigRational,
}

/// Terms, to be compared with others.
#[derive(PartialEq, Eq)]
pub(super) struct Terms(Vec<Number>);

/// A comparison with 0.
enum Goal<N> {
    Plain(Relation, Expression<N>),
    /// Of `factor*sqrt(inner) + rest`.
    Root {
        relation: Relation,
        factor: Expression<N>,
        inner: Expression<N>,
        rest: Expression<N>,
    },
}

impl<N: Arithmetic> Numeric<N> {
    /// The same as numbers; nothing where there are parameters, or what is no rational number.
    pub(super) fn of(recurrence: &Recurrence, (relation, left, right): Wanted<'_>) -> Option<Numeric<N>> {
        let terms = recurrence.terms();
        let mut places: BTreeMap<Name, usize> =
            terms.iter().enumerate().map(|(place, (name, ..))| (name.clone(), place)).collect();
        places.insert(recurrence.index.clone(), terms.len());
        let mut steps = Vec::new();
        for (place, (_, own, offset)) in terms.iter().enumerate() {
            let sequence = &recurrence.sequences[*own];
            steps.push(if offset + 1 < sequence.start.len() {
                Ok(place + 1)
            } else {
                Err(Expression::of(&sequence.next, &places)?)
            });
        }
        let starts = recurrence.sequences.iter().flat_map(|sequence| &sequence.start);
        let mut state = starts.map(|value| N::of(&value.as_rational()?)).collect::<Option<Vec<_>>>()?;
        let from = BigRational::from_integer(recurrence.from.into());
        state.push(N::of(&from)?);
        let goal = Goal::of(relation, &left.sub(right).ok()?, &places)?;
        Some(Numeric { steps, goal, state, from })
    }

    /// Whether the comparison holds now; nothing where it is not defined.
    pub(super) fn holds(&self) -> Option<bool> {
        self.goal.holds(&self.state)
    }

    /// Puts in the terms of the index that is so many steps behind the first; nothing where one is no number of this kind.
    pub(super) fn put(&mut self, terms: &[BigRational], steps: u64) -> Option<()> {
        let index = self.from.clone() + BigRational::from_integer(steps.into());
        self.state = terms.iter().chain([&index]).map(N::of).collect::<Option<_>>()?;
        Some(())
    }

    /// Goes on to the next index; nothing where a term is not defined.
    pub(super) fn advance(&mut self) -> Option<()> {
        let mut next = Vec::with_capacity(self.state.len());
        for step in &self.steps {
            next.push(match step {
                Ok(place) => self.state[*place].clone(),
                Err(expression) => expression.at(&self.state)?,
            });
        }
        next.push(self.state.last()?.plus(&N::of(&BigRational::one())?)?);
        self.state = next;
        Some(())
    }
}

impl Numeric {
    /// The terms from which the next ones follow.
    pub(super) fn terms(&self) -> Terms {
        Terms(self.state[..self.steps.len()].to_vec())
    }

    /// The bits of all numbers together, and of the longest one.
    pub(super) fn bits(&self) -> (u64, u64) {
        let numbers = &self.state[..self.steps.len()];
        let sizes = numbers.iter().map(Number::bits);
        sizes.fold((0, 0), |(all, longest), (top, bottom)| (all + top + bottom, longest.max(top).max(bottom)))
    }
}

impl<N: Arithmetic> Goal<N> {
    fn of(relation: Relation, difference: &Value, places: &BTreeMap<Name, usize>) -> Option<Goal<N>> {
        if let Some(plain) = Expression::of(difference, places) {
            return Some(Goal::Plain(relation, plain));
        }
        let root = difference.atoms().into_iter().find(|atom| matches!(atom, Atom::Root(_)))?;
        let Atom::Root(inner) = &root else { return None };
        let name = Name::new("[root]");
        let (factor, rest) = difference.with_atom(&root, &Value::variable(&name)).ok()?.linear_in(&name)?;
        let [factor, inner, rest] = [&factor, inner, &rest].map(|value| Expression::of(value, places));
        Some(Goal::Root { relation, factor: factor?, inner: inner?, rest: rest? })
    }

    fn holds(&self, state: &[N]) -> Option<bool> {
        let (relation, order) = match self {
            Goal::Plain(relation, difference) => (relation, difference.at(state)?.sign()?),
            Goal::Root { relation, factor, inner, rest } => {
                let (factor, inner, rest) = (factor.at(state)?, inner.at(state)?, rest.at(state)?);
                let signs = [factor.sign()?, inner.sign()?, rest.sign()?];
                if signs[1] == Ordering::Less {
                    return None;
                }
                let (one, other) = (if signs[1] == Ordering::Equal { Ordering::Equal } else { signs[0] }, signs[2]);
                // Of opposite signs, the one with the larger square wins.
                let order = if one == other.reverse() {
                    let squares = (factor.times(&factor)?.times(&inner)?, rest.times(&rest)?);
                    match squares.0.compared(&squares.1)? {
                        Ordering::Greater => one,
                        Ordering::Less => other,
                        Ordering::Equal => Ordering::Equal,
                    }
                } else if one == Ordering::Equal {
                    other
                } else {
                    one
                };
                (relation, order)
            }
        };
        Some(relation.holds(order))
    }
}

impl<N: Arithmetic> Expression<N> {
    fn of(value: &Value, places: &BTreeMap<Name, usize>) -> Option<Expression<N>> {
        let (numerator, denominator) = value.polynomials()?;
        if denominator.is_one() {
            return Some(Expression { whole: None, numerator: summands(numerator, places)?, denominator: None });
        }
        let apart = if N::ROOTS { divided(numerator, denominator) } else { None };
        let (whole, rest) = match &apart {
            Some((whole, rest)) => (Some(summands(whole, places)?), rest),
            None => (None, numerator),
        };
        let (numerator, denominator) = (summands(rest, places)?, Some(summands(denominator, places)?));
        Some(Expression { whole, numerator, denominator })
    }

    fn at(&self, state: &[N]) -> Option<N> {
        let above = total(&self.numerator, state)?;
        let Some(below) = &self.denominator else { return Some(above) };
        let quotient = above.times(&total(below, state)?.inverse()?)?;
        match &self.whole {
            Some(whole) => total(whole, state)?.plus(&quotient),
            None => Some(quotient),
        }
    }
}

/// The whole part of a quotient of polynomials by one atom that stands in the divisor alone, and what is left above it: of
/// `(x^2+1)/x` that is x and 1. Bounds of x that are read once grow less apart than those of `x^2` over those of x.
fn divided(above: &Polynomial<Atom>, below: &Polynomial<Atom>) -> Option<(Polynomial<Atom>, Polynomial<Atom>)> {
    let atoms = below.atoms();
    let (Some(atom), 1) = (atoms.first(), atoms.len()) else { return None };
    let by = below.degree_in(atom);
    let leading = below.coefficients_in(atom).get(&by)?.as_constant().filter(|leading| !leading.is_zero())?;
    let (mut whole, mut rest) = (Polynomial::zero(), above.clone());
    for degree in (by..=above.degree_in(atom).min(MOST_DEGREE)).rev() {
        let Some(coefficient) = rest.coefficients_in(atom).remove(&degree) else { continue };
        let power = Monomial::of([((*atom).clone(), degree - by)])?;
        let part = coefficient.times_term(&power, &leading.recip())?;
        rest = rest.minus(&part.times(below)?);
        whole = whole.plus(&part);
    }
    (!whole.is_zero() && rest.degree_in(atom) < by).then_some((whole, rest))
}

/// The highest power that is divided.
const MOST_DEGREE: u32 = 64;

fn summands<N: Arithmetic>(polynomial: &Polynomial<Atom>, places: &BTreeMap<Name, usize>) -> Option<Vec<Summand<N>>> {
    let mut all = Vec::new();
    for (monomial, coefficient) in polynomial.terms() {
        let factors = monomial.factors().iter().map(|(atom, exponent)| Some((factor(atom, places)?, *exponent)));
        all.push(Summand { coefficient: N::of(coefficient)?, factors: factors.collect::<Option<_>>()? });
    }
    Some(all)
}

fn factor<N: Arithmetic>(atom: &Atom, places: &BTreeMap<Name, usize>) -> Option<Factor<N>> {
    Some(match atom {
        Atom::Variable(name) => Factor::Place(*places.get(name)?),
        Atom::Maximum(elements) => {
            Factor::Maximum(elements.iter().map(|one| Expression::of(one, places)).collect::<Option<_>>()?)
        }
        Atom::Positive(inner) => Factor::Positive(Expression::of(inner, places)?),
        Atom::Floor(inner) => Factor::Floor(Expression::of(inner, places)?),
        Atom::Power(base, exponent) => Factor::Power(Expression::of(base, places)?, Expression::of(exponent, places)?),
        Atom::Root(inner) if N::ROOTS => Factor::Root(Expression::of(inner, places)?),
        Atom::Root(_) | Atom::Apply(..) => return None,
    })
}

fn total<N: Arithmetic>(summands: &[Summand<N>], state: &[N]) -> Option<N> {
    let mut all: Option<N> = None;
    for summand in summands {
        let mut whole = summand.coefficient.clone();
        for (factor, exponent) in &summand.factors {
            match (factor, exponent) {
                (Factor::Place(place), 1) => whole = whole.times(&state[*place])?,
                _ => whole = whole.times(&factor.at(state)?.raised(i64::from(*exponent))?)?,
            }
        }
        all = Some(match all {
            None => whole,
            Some(all) => all.plus(&whole)?,
        });
    }
    all.or_else(|| N::of(&BigRational::zero()))
}

impl<N: Arithmetic> Factor<N> {
    fn at(&self, state: &[N]) -> Option<N> {
        let whole = |number: i64| N::of(&BigRational::from_integer(number.into()));
        match self {
            Factor::Place(place) => Some(state[*place].clone()),
            Factor::Maximum(elements) => elements.iter().try_fold(whole(0)?, |most, one| one.at(state)?.greater(&most)),
            Factor::Positive(inner) => whole(i64::from(inner.at(state)?.sign()? == Ordering::Greater)),
            Factor::Floor(inner) => inner.at(state)?.floor(),
            Factor::Power(base, exponent) => base.at(state)?.raised(exponent.at(state)?.whole()?),
            Factor::Root(inner) => inner.at(state)?.root(),
        }
    }
}
