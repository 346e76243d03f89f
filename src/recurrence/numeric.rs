//! Terms of recurrences without parameters as plain rational numbers: the expressions are laid out once, and each term is
//! computed from those before it without building values.

mod number;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::polynomial::Polynomial;
use crate::value::{Atom, Relation, Value};
use number::Number;

/// A quotient of polynomials in numbered numbers and in what is computed from these.
struct Expression {
    numerator: Vec<Summand>,
    /// None for 1.
    denominator: Option<Vec<Summand>>,
}

struct Summand {
    coefficient: Number,
    factors: Vec<(Factor, u32)>,
}

enum Factor {
    /// A number of the state, the last of which is the index.
    Place(usize),
    /// The greatest of 0 and these.
    Maximum(Vec<Expression>),
    /// 1 where this is above 0, else 0.
    Positive(Expression),
    Floor(Expression),
    Power(Expression, Expression),
}

/// A recurrence of numbers and a comparison of its terms.
pub(super) struct Numeric {
    /// For each number of the state the place of the next one, or the expression that gives it.
    steps: Vec<Result<usize, Expression>>,
    goal: Goal,
    /// The numbers of the state, and the index.
    state: Vec<Number>,
}

/// Terms, to be compared with others.
#[derive(PartialEq, Eq)]
pub(super) struct Terms(Vec<Number>);

/// A comparison with 0.
enum Goal {
    Plain(Relation, Expression),
    /// Of `factor*sqrt(inner) + rest`.
    Root {
        relation: Relation,
        factor: Expression,
        inner: Expression,
        rest: Expression,
    },
}

impl Numeric {
    /// The same as numbers; nothing where there are parameters, or what is no rational number.
    pub(super) fn of(recurrence: &Recurrence, (relation, left, right): Wanted<'_>) -> Option<Numeric> {
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
        let mut state = starts.map(|value| Some(Number::of(&value.as_rational()?))).collect::<Option<Vec<_>>>()?;
        state.push(Number::integer(recurrence.from));
        let goal = Goal::of(relation, &left.sub(right).ok()?, &places)?;
        Some(Numeric { steps, goal, state })
    }

    /// Whether the comparison holds now; nothing where it is not defined.
    pub(super) fn holds(&self) -> Option<bool> {
        self.goal.holds(&self.state)
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
        next.push(self.state.last()?.plus(&Number::integer(1)));
        self.state = next;
        Some(())
    }

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

impl Goal {
    fn of(relation: Relation, difference: &Value, places: &BTreeMap<Name, usize>) -> Option<Goal> {
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

    fn holds(&self, state: &[Number]) -> Option<bool> {
        let (relation, order) = match self {
            Goal::Plain(relation, difference) => (relation, difference.at(state)?.sign()),
            Goal::Root { relation, factor, inner, rest } => {
                let (factor, inner, rest) = (factor.at(state)?, inner.at(state)?, rest.at(state)?);
                if inner.sign() == Ordering::Less {
                    return None;
                }
                let (one, other) =
                    (if inner.sign() == Ordering::Equal { Ordering::Equal } else { factor.sign() }, rest.sign());
                // Of opposite signs, the one with the larger square wins.
                let order = if one == other.reverse() {
                    let squares = (factor.times(&factor).times(&inner), rest.times(&rest));
                    match squares.0.compared(&squares.1) {
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

impl Expression {
    fn of(value: &Value, places: &BTreeMap<Name, usize>) -> Option<Expression> {
        let (numerator, denominator) = value.polynomials()?;
        let numerator = summands(numerator, places)?;
        let denominator = if denominator.is_one() { None } else { Some(summands(denominator, places)?) };
        Some(Expression { numerator, denominator })
    }

    fn at(&self, state: &[Number]) -> Option<Number> {
        let above = total(&self.numerator, state)?;
        let Some(below) = &self.denominator else { return Some(above) };
        Some(above.times(&total(below, state)?.inverse()?))
    }
}

fn summands(polynomial: &Polynomial<Atom>, places: &BTreeMap<Name, usize>) -> Option<Vec<Summand>> {
    let mut all = Vec::new();
    for (monomial, coefficient) in polynomial.terms() {
        let factors = monomial.factors().iter().map(|(atom, exponent)| Some((factor(atom, places)?, *exponent)));
        all.push(Summand { coefficient: Number::of(coefficient), factors: factors.collect::<Option<_>>()? });
    }
    Some(all)
}

fn factor(atom: &Atom, places: &BTreeMap<Name, usize>) -> Option<Factor> {
    Some(match atom {
        Atom::Variable(name) => Factor::Place(*places.get(name)?),
        Atom::Maximum(elements) => {
            Factor::Maximum(elements.iter().map(|one| Expression::of(one, places)).collect::<Option<_>>()?)
        }
        Atom::Positive(inner) => Factor::Positive(Expression::of(inner, places)?),
        Atom::Floor(inner) => Factor::Floor(Expression::of(inner, places)?),
        Atom::Power(base, exponent) => Factor::Power(Expression::of(base, places)?, Expression::of(exponent, places)?),
        Atom::Root(_) | Atom::Apply(..) => return None,
    })
}

fn total(summands: &[Summand], state: &[Number]) -> Option<Number> {
    let mut all = Number::integer(0);
    for summand in summands {
        let mut whole = summand.coefficient.clone();
        for (factor, exponent) in &summand.factors {
            match (factor, exponent) {
                (Factor::Place(place), 1) => whole = whole.times(&state[*place]),
                _ => whole = whole.times(&factor.at(state)?.raised(i64::from(*exponent))?),
            }
        }
        all = all.plus(&whole);
    }
    Some(all)
}

impl Factor {
    fn at(&self, state: &[Number]) -> Option<Number> {
        Some(match self {
            Factor::Place(place) => state[*place].clone(),
            Factor::Maximum(elements) => {
                let mut most = Number::integer(0);
                for one in elements {
                    let one = one.at(state)?;
                    if one.compared(&most) == Ordering::Greater {
                        most = one;
                    }
                }
                most
            }
            Factor::Positive(inner) => Number::integer(i64::from(inner.at(state)?.sign() == Ordering::Greater)),
            Factor::Floor(inner) => inner.at(state)?.floor(),
            Factor::Power(base, exponent) => {
                let exponent = exponent.at(state)?.whole()?;
                base.at(state)?.raised(exponent)?
            }
        })
    }
}
