//! Linear forms of a state and of what is drawn, for many states and draws: what a form makes of each draw is kept, and of
//! a state it is found once. Most signs are certain in machine numbers already; the others are decided exactly.

use std::cmp::Ordering;

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::chain::{Linear, Move, Side};
use crate::interval::Interval;
use crate::value::Relation;

/// A number, and an interval round it.
struct Near {
    exact: BigRational,
    near: Interval,
}

impl Near {
    fn of(exact: BigRational) -> Near {
        Near { near: Interval::of(&exact), exact }
    }
}

/// A form: the factors of the state, what is added, and what it makes of each draw.
struct Form {
    state: Vec<BigRational>,
    constant: BigRational,
    drawn: Vec<Near>,
}

/// A side without a disc; none where it has one, which holds for nothing here.
type Test = Option<(Form, Relation)>;

/// The forms of one way.
pub(super) struct Tables {
    tests: Vec<Test>,
    /// By stretch: any of these, each of them all.
    shown: Vec<Vec<Vec<Test>>>,
    image: Vec<Form>,
}

fn product(factors: &[BigRational], numbers: &[BigRational], constant: &BigRational) -> BigRational {
    let products = factors.iter().zip(numbers).filter(|(factor, _)| !factor.is_zero());
    products.fold(
        constant.clone(),
        |sum, (factor, number)| {
            if factor.is_one() { sum + number } else { sum + factor * number }
        },
    )
}

impl Form {
    fn of(form: &Linear, all: &[Vec<BigRational>]) -> Form {
        let drawn = all.iter().map(|drawn| Near::of(product(&form.draws, drawn, &BigRational::zero())));
        Form { state: form.state.clone(), constant: form.constant.clone(), drawn: drawn.collect() }
    }

    fn at(&self, state: &[BigRational]) -> Near {
        Near::of(product(&self.state, state, &self.constant))
    }
}

fn test(side: &Side, all: &[Vec<BigRational>]) -> Test {
    side.disc.is_none().then(|| (Form::of(&side.form, all), side.relation))
}

impl Tables {
    /// Of a way, and all that may be drawn on it.
    pub(super) fn of(one: &Move, all: &[Vec<BigRational>]) -> Tables {
        let tests = |sides: &Vec<Side>| sides.iter().map(|side| test(side, all)).collect::<Vec<Test>>();
        Tables {
            tests: tests(&one.tests),
            shown: one.stretches.iter().map(|stretch| stretch.shown.iter().map(tests).collect()).collect(),
            image: one.image.iter().map(|form| Form::of(form, all)).collect(),
        }
    }

    /// In a state.
    pub(super) fn at(&self, state: &[BigRational]) -> Here<'_> {
        let tests =
            |tests: &Vec<Test>| tests.iter().map(|test| test.as_ref().map(|(form, _)| form.at(state))).collect();
        Here {
            tables: self,
            tests: tests(&self.tests),
            shown: self.shown.iter().map(|region| region.iter().map(tests).collect()).collect(),
            image: self.image.iter().map(|form| form.at(state)).collect(),
        }
    }
}

/// A state, and what the forms make of it.
pub(super) struct Here<'a> {
    tables: &'a Tables,
    tests: Vec<Option<Near>>,
    shown: Vec<Vec<Vec<Option<Near>>>>,
    image: Vec<Near>,
}

/// Whether the sum of both is as the relation says to 0.
fn compares(relation: Relation, one: &Near, other: &Near) -> bool {
    let sum = one.near.plus(other.near);
    let order = match sum {
        Interval { low, .. } if low > 0.0 => Ordering::Greater,
        Interval { high, .. } if high < 0.0 => Ordering::Less,
        _ => (&one.exact + &other.exact).cmp(&BigRational::zero()),
    };
    relation.holds(order)
}

fn all_hold(tests: &[Test], here: &[Option<Near>], drawn: usize) -> bool {
    tests.iter().zip(here).all(|(test, here)| match (test, here) {
        (Some((form, relation)), Some(here)) => compares(*relation, here, &form.drawn[drawn]),
        _ => false,
    })
}

impl Here<'_> {
    /// Whether the way is taken where this one of what may be drawn is drawn.
    pub(super) fn taken(&self, drawn: usize) -> bool {
        all_hold(&self.tables.tests, &self.tests, drawn)
    }

    /// Whether what is asked for is shown in a stretch.
    pub(super) fn shows(&self, stretch: usize, drawn: usize) -> bool {
        let both = self.tables.shown[stretch].iter().zip(&self.shown[stretch]);
        both.into_iter().any(|(tests, here)| all_hold(tests, here, drawn))
    }

    /// The state of the next phase.
    pub(super) fn image(&self, drawn: usize) -> Vec<BigRational> {
        self.tables.image.iter().zip(&self.image).map(|(form, here)| &here.exact + &form.drawn[drawn].exact).collect()
    }
}
