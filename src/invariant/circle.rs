//! Lengths and sums of squares compared with a bound, by half planes: a circle, or an ellipse, without roots.
//!
//! For a direction n of length 1, n·x is at most the length of x; so `n·x > c` for one n gives `norm(x) > c`. Of twenty
//! directions one makes an angle of less than 9.5 degrees with x, so that n·x is at least 0.986 of its length; so
//! `n·x <= 0.986*c` for all n gives `norm(x) <= c`. Along a line, where one square is left, both are exact.

use std::collections::BTreeSet;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::Test;
use crate::simplest::simplest;
use crate::value::{Atom, Relation, Value};

/// Directions of a quarter turn, as quotients: a side and the other over the third.
pub const QUARTER: [(i64, i64, i64); 5] = [(1, 0, 1), (35, 12, 37), (4, 3, 5), (3, 4, 5), (12, 35, 37)];

/// What the cosine of half the angle between neighbours is at least: its square is at most (1 + n·m)/2 for each pair.
pub const COSINE: (i64, i64) = (986, 1_000);

/// Squares that a sum is taken apart into.
const MOST_SQUARES: usize = 4;

/// Half planes in place of a circle.
#[derive(Clone, Debug)]
pub enum Planes {
    /// Any one of them is enough.
    Any(Vec<Test>),
    /// All of them are.
    All(Vec<Test>),
}

impl Planes {
    /// The half planes.
    pub fn tests(&self) -> &[Test] {
        match self {
            Planes::Any(tests) | Planes::All(tests) => tests,
        }
    }
}

/// A square with a positive weight.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Square {
    /// Its weight.
    pub weight: BigRational,
    /// A variable that has the factor 1 in what is squared, and stands in none of the squares behind it.
    pub lead: Name,
    /// What is squared.
    pub form: Value,
}

/// What a sum of squares is compared with.
#[derive(Clone, Debug)]
pub enum Bound {
    /// The sum itself with a number.
    Number(BigRational),
    /// Its root, which may be over a greater sum where `whole` is false, with a value.
    Length {
        /// The value.
        value: Value,
        /// Whether nothing else stands under the root.
        whole: bool,
    },
}

/// A sum of squares compared with a bound, from above or from below.
#[derive(Clone, Debug)]
pub struct Round {
    /// The squares: at least one.
    pub squares: Vec<Square>,
    /// How they are compared: never `=` or `!=`.
    pub relation: Relation,
    /// With what.
    pub bound: Bound,
}

/// Squares, with a number, that a value is the sum of; none where it is not found to be one.
pub fn squares(sum: &Value) -> Option<(Vec<Square>, BigRational)> {
    let mut found = Vec::new();
    let mut rest = sum.clone();
    loop {
        if let Some(number) = rest.as_rational() {
            return Some((found, number));
        }
        if found.len() == MOST_SQUARES {
            return None;
        }
        let square = rest.variables().into_iter().find_map(|name| leading(&rest, name))?;
        let weighed = Value::rational(square.weight.clone()).mul(&square.form).ok()?.mul(&square.form).ok()?;
        rest = rest.sub(&weighed).ok()?;
        found.push(square);
    }
}

/// A square that leaves nothing of this variable in a value of degree 2.
fn leading(sum: &Value, lead: Name) -> Option<Square> {
    let at = |number: i64| sum.with(&lead, &Value::integer(number)).ok();
    let (here, ahead, behind) = (at(0)?, at(1)?, at(-1)?);
    let half = Value::fraction(1, 2).ok()?;
    let weight = ahead.add(&behind).ok()?.mul(&half).ok()?.sub(&here).ok()?.as_rational()?;
    let linear = ahead.sub(&behind).ok()?.mul(&half).ok()?;
    if !weight.is_positive() {
        return None;
    }
    let twice = Value::rational(&weight + &weight);
    let form = Value::variable(&lead).add(&linear.div(&twice).ok()?).ok()?;
    Some(Square { weight, lead, form })
}

impl Round {
    /// A test read as one; none where it is linear, or no sum of squares is found.
    pub fn of(test: &Test) -> Option<Round> {
        if matches!(test.relation, Relation::Eq | Relation::Neq) {
            return None;
        }
        let difference = test.left.sub(&test.right).ok()?;
        let mut curved = BTreeSet::new();
        for atom in difference.atoms() {
            match atom {
                Atom::Variable(_) => {}
                Atom::Root(ref inner) if inner.variables().is_empty() => {}
                Atom::Root(_) | Atom::Maximum(_) => {
                    curved.insert(atom);
                }
                _ => return None,
            }
        }
        match (curved.len(), curved.pop_first()) {
            (0, _) => Round::of_sum(&difference, test.relation),
            (1, Some(atom)) => Round::of_length(&difference, &atom, test.relation),
            _ => None,
        }
    }

    /// A sum of squares and a number, or the opposite of one, compared with 0.
    fn of_sum(difference: &Value, relation: Relation) -> Option<Round> {
        let curved = |name: &Name| difference.linear_in(name).is_none();
        if !difference.variables().iter().any(curved) {
            return None;
        }
        let (found, rest, relation) = match squares(difference) {
            Some((found, rest)) => (found, rest, relation),
            None => squares(&difference.neg().ok()?).map(|(found, rest)| (found, rest, relation.mirrored()))?,
        };
        (!found.is_empty()).then(|| Round { squares: found, relation, bound: Bound::Number(-rest) })
    }

    /// The root of such a sum, or an absolute value, times a number, with a value beside it, compared with 0.
    fn of_length(difference: &Value, atom: &Atom, relation: Relation) -> Option<Round> {
        let name = Name::new("length~");
        let length = Value::variable(&name);
        let (inner, image) = match atom {
            Atom::Root(inner) => (inner.clone(), length),
            // `abs(x)` is `2*max(0,x)-x`.
            Atom::Maximum(parts) => {
                let [part] = &parts[..] else { return None };
                let image = length.add(part).ok()?.div(&Value::integer(2)).ok()?;
                (part.mul(part).ok()?, image)
            }
            _ => return None,
        };
        let (factor, rest) = difference.with_atom(atom, &image).ok()?.linear_in(&name)?;
        let value = rest.neg().ok()?.div(&factor).ok()?;
        let negative = signed_square(&factor)?.is_negative();
        let relation = if negative { relation.mirrored() } else { relation };
        let (squares, rest) = squares(&inner).filter(|(found, rest)| !found.is_empty() && !rest.is_negative())?;
        let bound = match signed_square(&value) {
            // A length is never less than 0, nor is a sum of squares.
            Some(square) if square.is_negative() => Bound::Number(square),
            Some(square) => Bound::Number(square - rest),
            None => Bound::Length { value, whole: rest.is_zero() },
        };
        Some(Round { squares, relation, bound })
    }

    /// Whether it bounds the squares from below.
    pub fn is_below(&self) -> bool {
        matches!(self.relation, Relation::Gtr | Relation::Gte)
    }

    /// The factors of what is squared in a value, and what else is in it; none where they are not numbers, or all 0.
    pub fn direction(&self, value: &Value) -> Option<(Vec<BigRational>, Value)> {
        let (mut factors, mut rest) = (Vec::new(), value.clone());
        for square in &self.squares {
            let (factor, _) = rest.linear_in(&square.lead)?;
            rest = rest.sub(&factor.mul(&square.form).ok()?).ok()?;
            factors.push(factor.as_rational()?);
        }
        factors.iter().any(|factor| !factor.is_zero()).then_some((factors, rest))
    }

    /// The sum of what is squared with these factors.
    fn along(&self, factors: &[BigRational]) -> Option<Value> {
        let mut sum = Value::zero();
        for (factor, square) in factors.iter().zip(&self.squares) {
            sum = sum.add(&square.form.mul(&Value::rational(factor.clone())).ok()?).ok()?;
        }
        Some(sum)
    }

    /// The square of the length of these factors, which what is squared with them is at most times the root of the sum.
    fn length(&self, factors: &[BigRational]) -> BigRational {
        factors.iter().zip(&self.squares).map(|(factor, square)| factor * factor / &square.weight).sum()
    }

    /// A half plane from which a bound from below follows, with these factors of what is squared.
    pub fn beyond(&self, factors: &[BigRational]) -> Option<Test> {
        let (_, above) = match &self.bound {
            Bound::Number(number) if !number.is_negative() => root(&(self.length(factors) * number)),
            Bound::Length { .. } => root(&self.length(factors)),
            Bound::Number(_) => return None,
        };
        let right = match &self.bound {
            Bound::Number(_) => Value::rational(above),
            Bound::Length { value, .. } => value.mul(&Value::rational(above)).ok()?,
        };
        self.is_below().then_some(Test { relation: self.relation, left: self.along(factors)?, right })
    }

    /// Two half planes that follow from a bound of the squares from above by a number: a strip in this direction.
    pub fn strip(&self, factors: &[BigRational]) -> Option<[Test; 2]> {
        let Bound::Number(number) = &self.bound else { return None };
        if self.is_below() || number.is_negative() {
            return None;
        }
        let (_, above) = root(&(self.length(factors) * number));
        let left = self.along(factors)?;
        let least = Test { relation: Relation::Gte, left: left.clone(), right: Value::rational(-above.clone()) };
        Some([Test { relation: Relation::Lte, left, right: Value::rational(above) }, least])
    }

    /// Half planes from which it follows.
    pub fn planes(&self) -> Option<Planes> {
        match &self.bound {
            Bound::Number(number) if self.is_below() => {
                let surely = number.is_negative() || number.is_zero() && self.relation == Relation::Gte;
                let nothing = Test { relation: Relation::Eq, left: Value::zero(), right: Value::zero() };
                if surely { Some(Planes::Any(vec![nothing])) } else { self.outside() }
            }
            Bound::Number(number) => {
                if number.is_negative() {
                    None
                } else {
                    self.inside(number)
                }
            }
            Bound::Length { .. } if self.is_below() => self.outside(),
            Bound::Length { value, whole } => whole.then(|| self.polygon(value))?,
        }
    }

    fn outside(&self) -> Option<Planes> {
        let ways = match self.squares.as_slice() {
            [_] => [BigRational::one(), -BigRational::one()].map(|factor| vec![factor]).to_vec(),
            [one, other] => {
                let [first, second] = [&one.weight, &other.weight].map(|weight| root(weight).1);
                turns().into_iter().map(|(x, y)| vec![x * &first, y * &second]).collect()
            }
            _ => return None,
        };
        Some(Planes::Any(ways.iter().map(|factors| self.beyond(factors)).collect::<Option<_>>()?))
    }

    /// Half planes between which the squares are at most a number.
    fn inside(&self, number: &BigRational) -> Option<Planes> {
        let [only] = self.squares.as_slice() else { return self.polygon(&Value::rational(root(number).0)) };
        let (below, _) = root(&(number / &only.weight));
        let half = |relation: Relation, right: BigRational| Test {
            relation,
            left: only.form.clone(),
            right: Value::rational(right),
        };
        Some(Planes::All(vec![half(self.relation, below.clone()), half(self.relation.mirrored(), -below)]))
    }

    /// Half planes between which the root of the squares is at most a value.
    fn polygon(&self, value: &Value) -> Option<Planes> {
        let [one, other] = self.squares.as_slice() else { return None };
        let [first, second] = [&one.weight, &other.weight].map(|weight| root(weight).1);
        let nearer = value.mul(&Value::fraction(COSINE.0, COSINE.1).ok()?).ok()?;
        let half = |(x, y): (BigRational, BigRational)| {
            let left = self.along(&[x * &first, y * &second])?;
            Some(Test { relation: self.relation, left, right: nearer.clone() })
        };
        Some(Planes::All(turns().into_iter().map(half).collect::<Option<_>>()?))
    }
}

/// The twenty directions.
fn turns() -> Vec<(BigRational, BigRational)> {
    let mut all = Vec::new();
    for (first, second, third) in QUARTER {
        let part = |side: i64| BigRational::new(BigInt::from(side), BigInt::from(third));
        let (x, y) = (part(first), part(second));
        // A quarter turn takes (x, y) to (-y, x).
        all.extend([(x.clone(), y.clone()), (-y.clone(), x.clone()), (-x.clone(), -y.clone()), (y, -x)]);
    }
    all
}

/// The square of a number, with the sign of the number; none of a value that is no number, or whose square is no quotient.
fn signed_square(value: &Value) -> Option<BigRational> {
    let square = value.mul(value).ok()?.as_rational().filter(|_| value.variables().is_empty())?;
    let negative = Assumptions::default().decide(Relation::Lss, value, &Value::zero())?;
    Some(if negative { -square } else { square })
}

/// Two quotients between which the root of a number that is not negative lies, both the root where that is one, and else
/// no further apart than about a part in 10^9.
pub fn root(number: &BigRational) -> (BigRational, BigRational) {
    let exact = BigRational::new(number.numer().sqrt(), number.denom().sqrt());
    if &exact * &exact == *number {
        return (exact.clone(), exact);
    }
    let digits = BigInt::from(10).pow(12) << number.denom().bits();
    let whole = (number.numer() * &digits * &digits / number.denom()).sqrt();
    let below = BigRational::new(whole.clone(), digits.clone());
    let above = BigRational::new(whole + 1, digits);
    let slack = BigRational::new(BigInt::one(), BigInt::from(10).pow(9));
    let (less, more) = (&below * (BigRational::one() - &slack), &above * (BigRational::one() + slack));
    (simplest(&less, &below), simplest(&above, &more))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_number_lies_between_both() {
        for (top, bottom) in [(2, 1), (49, 4), (1, 1_000_000_007), (123_456_789, 7), (0, 1), (3, 1_i64 << 40)] {
            let number = BigRational::new(BigInt::from(top), BigInt::from(bottom));
            let (below, above) = root(&number);
            assert!(&below * &below <= number && number <= &above * &above, "{number}");
            assert!(&above - &below <= &above / BigInt::from(100_000_000), "{number}: {below} {above}");
        }
    }
}
