//! Distances in the plane: what is compared as a sum of two squares of linear forms.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::chain::{Linear, Names, Side};
use crate::value::{Atom, Relation, Value, View};

/// `a*x² + b*y²`, of forms that do not depend on each other; a and b are positive.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Disc {
    /// Factors and forms.
    pub squares: [(BigRational, Linear); 2],
}

impl Disc {
    /// The same over other forms.
    pub(super) fn with(&self, change: impl Fn(&Linear) -> Linear) -> Disc {
        Disc { squares: self.squares.clone().map(|(factor, form)| (factor, change(&form))) }
    }
}

/// `difference REL 0` as a comparison of a length, or of its square, with a number; none where it is none of two squares.
pub(super) fn round(names: &Names, difference: &Value, relation: Relation) -> Option<Side> {
    let root = difference.atoms().into_iter().find(|atom| matches!(atom, Atom::Root(_)));
    let Some(Atom::Root(square)) = &root else { return compared(names, difference, BigRational::zero(), relation) };
    let at = |place: Value| difference.with_atom(root.as_ref()?, &place).ok();
    let rest = at(Value::zero())?;
    let factor = at(Value::one())?.sub(&rest).ok()?;
    let whole = factor.mul(&root.as_ref()?.value().ok()?).ok()?.add(&rest).ok()?;
    let (factor, rest) = (factor.as_rational()?, rest.as_rational()?);
    if whole != *difference || factor.is_zero() {
        return None;
    }
    let relation = if factor.is_negative() { relation.mirrored() } else { relation };
    let bound = -rest / factor;
    if bound.is_negative() {
        // A length is no less than 0.
        let form = Linear { constant: -bound, ..Linear::default() };
        return Some(Side::flat(form, relation));
    }
    compared(names, square, &bound * &bound, relation)
}

/// `value REL bound`, where the value is a sum of two squares and a number.
fn compared(names: &Names, value: &Value, bound: BigRational, relation: Relation) -> Option<Side> {
    let (squares, constant) = Quadratic::of(names, value)?.squares()?;
    let form = Linear { constant: constant - bound, ..Linear::default() };
    Some(Side { form, relation, disc: Some(Box::new(Disc { squares })) })
}

/// A polynomial of the second degree over the state and the draws.
struct Quadratic {
    /// How many of the places are those of the state.
    state: usize,
    /// Twice the part of the second degree, as a symmetric matrix.
    twice: Vec<Vec<BigRational>>,
    linear: Vec<BigRational>,
    constant: BigRational,
}

impl Quadratic {
    fn of(names: &Names, value: &Value) -> Option<Quadratic> {
        let View::Real(sum, denominator) = value.view() else { return None };
        let over = match denominator.as_slice() {
            [(number, factors)] if factors.is_empty() => number.clone(),
            _ => return None,
        };
        let all: Vec<_> = names.state.iter().chain(&names.draws).collect();
        let place = |atom: &Atom| match atom {
            Atom::Variable(name) => all.iter().position(|other| *other == name),
            _ => None,
        };
        let zeros = vec![BigRational::zero(); all.len()];
        let mut found = Quadratic {
            state: names.state.len(),
            twice: vec![zeros.clone(); all.len()],
            linear: zeros,
            constant: BigRational::zero(),
        };
        for (number, factors) in &sum {
            let number = number / &over;
            match factors.as_slice() {
                [] => found.constant += number,
                [(atom, 1)] => found.linear[place(atom)?] += number,
                [(atom, 2)] => {
                    let place = place(atom)?;
                    found.twice[place][place] += &number + &number;
                }
                [(one, 1), (other, 1)] => {
                    let (one, other) = (place(one)?, place(other)?);
                    found.twice[one][other] += &number;
                    found.twice[other][one] += &number;
                }
                _ => return None,
            }
        }
        Some(found)
    }

    /// Two squares and a number, by completing squares; none where it is no such sum.
    fn squares(mut self) -> Option<([(BigRational, Linear); 2], BigRational)> {
        let mut squares = Vec::new();
        while let Some(place) = (0..self.linear.len()).find(|place| !self.twice[*place][*place].is_zero()) {
            squares.push(self.take(place).filter(|(factor, _)| factor.is_positive() && squares.len() < 2)?);
        }
        let empty = self.twice.iter().flatten().chain(&self.linear).all(Zero::is_zero);
        Some((squares.try_into().ok().filter(|_| empty)?, self.constant))
    }

    /// Takes out the square in which all of a variable lies: of `c*v² + v*L + …` it is `c*(v + L/(2c))²`.
    fn take(&mut self, place: usize) -> Option<(BigRational, Linear)> {
        let twice = self.twice[place][place].clone();
        let factor = &twice / BigRational::from_integer(2.into());
        let form: Vec<BigRational> = self.twice[place].iter().map(|number| number / &twice).collect();
        let constant = &self.linear[place] / &twice;
        for (row, one) in self.twice.iter_mut().zip(&form) {
            row.iter_mut().zip(&form).for_each(|(entry, other)| *entry -= &twice * one * other);
        }
        self.linear.iter_mut().zip(&form).for_each(|(entry, other)| *entry -= &twice * other * &constant);
        self.constant -= &factor * &constant * &constant;
        let (state, draws) = form.split_at_checked(self.state)?;
        Some((factor, Linear { state: state.to_vec(), draws: draws.to_vec(), constant }))
    }
}
