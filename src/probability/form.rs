//! Linear forms over the coordinates of a state and the draws of a round, as they decide and move it.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::axes::AXES;
use super::chain::{Linear, add_product};
use crate::rational::{difference, product, quotient};

/// What is drawn: means and variances.
pub(super) type Drawn = [(BigRational, BigRational)];

/// A form over the coordinates and the draws, which have no mean.
#[derive(Clone, Debug)]
pub(super) struct Form {
    pub factors: [BigRational; AXES],
    pub draws: Vec<BigRational>,
    pub offset: BigRational,
}

/// Which base a number is, and the ratio and the constant with which its values are said.
pub(super) type Said = (usize, BigRational, BigRational);

impl Form {
    /// A form with its part of the state still to come: the means are added up, and what is certain is no draw.
    pub(super) fn of(linear: &Linear, drawn: &Drawn) -> Form {
        let mut offset = linear.constant.clone();
        linear.draws.iter().zip(drawn).for_each(|(factor, (mean, _))| add_product(&mut offset, factor, mean));
        let mut draws = linear.draws.clone();
        draws.resize(drawn.len(), BigRational::zero());
        for (factor, _) in draws.iter_mut().zip(drawn).filter(|(_, (_, variance))| variance.is_zero()) {
            *factor = BigRational::zero();
        }
        Form { factors: Default::default(), draws, offset }
    }

    /// Which of these bases, of which there are at most so many, it is a multiple of; where it is of none, it becomes one.
    ///
    /// # Errors
    /// Where there are too many of them.
    pub(super) fn said(&self, bases: &mut Vec<Form>, most: usize) -> Result<Said, String> {
        for (number, base) in bases.iter().enumerate() {
            if let Some((ratio, constant)) = base.multiple(self) {
                return Ok((number, ratio, constant));
            }
        }
        if bases.len() >= most {
            return Err(format!("the guards of a round depend on more than {most} random numbers"));
        }
        let base = self.scaled();
        let (ratio, constant) = base.multiple(self).ok_or("a guard is lost")?;
        bases.push(base);
        Ok((bases.len() - 1, ratio, constant))
    }

    /// The same over its first draw, without what is added: what guards compare is the same number then, however written.
    fn scaled(&self) -> Form {
        let first = self.draws.iter().find(|factor| !factor.is_zero()).cloned().unwrap_or_else(One::one);
        let over = |factor: &BigRational| quotient(factor, &first);
        Form {
            factors: [over(&self.factors[0]), over(&self.factors[1])],
            draws: self.draws.iter().map(over).collect(),
            offset: BigRational::zero(),
        }
    }

    /// `(r, c)` with `other = r * self + c`.
    pub(super) fn multiple(&self, other: &Form) -> Option<(BigRational, BigRational)> {
        let place = self.draws.iter().position(|factor| !factor.is_zero())?;
        let ratio = quotient(&other.draws[place], &self.draws[place]);
        let same = |(one, two): (&BigRational, &BigRational)| match one.is_zero() || two.is_zero() {
            true => one.is_zero() == two.is_zero() || ratio.is_zero(),
            false => *two == product(one, &ratio),
        };
        let draws = || self.draws.iter().zip(&other.draws);
        let fits = draws().all(same) && self.factors.iter().zip(&other.factors).all(same);
        (fits && !ratio.is_zero()).then(|| {
            let constant = difference(&other.offset, &product(&ratio, &self.offset));
            (ratio, constant)
        })
    }
}

/// The covariance of two sums of draws.
pub(super) fn inner(left: &[BigRational], right: &[BigRational], drawn: &Drawn) -> BigRational {
    let mut sum = BigRational::zero();
    for ((left, right), (_, variance)) in left.iter().zip(right).zip(drawn) {
        if !left.is_zero() && !right.is_zero() {
            add_product(&mut sum, &product(left, right), variance);
        }
    }
    sum
}
