//! Exact closed forms of one-variable recurrences.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// A closed form by pieces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closed {
    /// In order, without gaps, from 0.
    pub pieces: Vec<Piece>,
    /// What must hold for it to be right.
    pub conditions: Vec<(Relation, Value, Value)>,
}

/// One piece of a closed form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The first index.
    pub from: Value,
    /// The index after the last; none for the last piece.
    pub until: Option<Value>,
    /// The value at an index.
    pub form: Value,
}

/// There is no closed form.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoClosedForm(pub String);

/// What is asked of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Goal {
    /// It is equal to this.
    Equals(Value),
    /// It is within the second of the first.
    Within(Value, Value),
    /// A comparison.
    Holds(Relation, Value, Value),
}

/// When a goal is met first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reach {
    /// At this index, under conditions.
    At(Value, Vec<(Relation, Value, Value)>),
    /// Never, and why.
    Never(String),
    /// Not known, and why.
    Unknown(String),
}

/// A closed form of `x(n+1) = map(x(n))`, `x(0) = start`.
///
/// # Errors
/// When none is found.
pub fn solve(
    map: &Value,
    variable: &Name,
    start: &Value,
    index: &Name,
    assumptions: &Assumptions,
) -> Result<Closed, NoClosedForm> {
    let no = |error: crate::value::ValueError| NoClosedForm(error.0);
    let Some((factor, constant)) = map.linear_in(variable) else {
        return Err(NoClosedForm(format!("{map} is not affine in {variable}")));
    };
    let one = Value::one();
    let count = Value::variable(index);
    let form = if assumptions.decide(Relation::Eq, &factor, &one) == Some(true) {
        constant.mul(&count).and_then(|sum| sum.add(start)).map_err(no)?
    } else if assumptions.decide(Relation::Eq, &factor, &one) == Some(false) {
        let fixed = one.sub(&factor).and_then(|rest| constant.div(&rest)).map_err(no)?;
        if factor.is_zero() {
            let piece = |from: i64, until: Option<i64>, form: &Value| Piece {
                from: Value::integer(from),
                until: until.map(Value::integer),
                form: form.clone(),
            };
            return Ok(Closed {
                pieces: vec![piece(0, Some(1), start), piece(1, None, &constant)],
                conditions: vec![],
            });
        }
        let power = factor.power(&count).map_err(no)?;
        start.sub(&fixed).and_then(|gap| gap.mul(&power)).and_then(|gap| gap.add(&fixed)).map_err(no)?
    } else {
        return Err(NoClosedForm(format!("it must be known whether {factor} = 1")));
    };
    Ok(Closed { pieces: vec![Piece { from: Value::zero(), until: None, form }], conditions: vec![] })
}

/// The first index at which a goal is met: the least one, since every earlier index is looked at or excluded.
pub fn first(closed: &Closed, index: &Name, goal: &Goal, assumptions: &Assumptions) -> Reach {
    let tail = Orbit::of(closed, index);
    for number in 0..MOST_LOOKED_AT {
        let at = Value::integer(number);
        let Some(piece) = closed.pieces.iter().find(|piece| match &piece.until {
            Some(until) => assumptions.decide(Relation::Lss, &at, until) == Some(true),
            None => true,
        }) else {
            return Reach::Unknown("no piece of the closed form covers the index".to_string());
        };
        let Ok(value) = piece.form.with(index, &at) else {
            return Reach::Unknown("the closed form is too large to evaluate".to_string());
        };
        let met = match goal {
            Goal::Equals(wanted) => assumptions.decide(Relation::Eq, &value, wanted),
            Goal::Within(centre, radius) => value
                .sub(centre)
                .and_then(|gap| gap.abs())
                .ok()
                .and_then(|gap| assumptions.decide(Relation::Lte, &gap, radius)),
            Goal::Holds(..) => None,
        };
        match met {
            Some(true) => return Reach::At(at, vec![]),
            Some(false) => {}
            None => return Reach::Unknown(format!("it must be known whether {value} meets the goal")),
        }
        if let Some(reason) = tail.as_ref().and_then(|tail| tail.out_of_reach(&value, goal)) {
            return Reach::Never(reason);
        }
    }
    Reach::Unknown(format!("not within {MOST_LOOKED_AT} rounds"))
}

/// Indices looked at one by one before the answer is left open.
const MOST_LOOKED_AT: i64 = 500;

/// A rational orbit `x(n+1) = c*x(n) + k`, which moves one way, or closes in on its fixed point.
struct Orbit {
    factor: BigRational,
    step: BigRational,
    fixed: Option<BigRational>,
}

impl Orbit {
    fn of(closed: &Closed, index: &Name) -> Option<Orbit> {
        let [piece] = closed.pieces.as_slice() else { return None };
        let at = |number: i64| piece.form.with(index, &Value::integer(number)).ok()?.as_rational();
        let (zero, one, two) = (at(0)?, at(1)?, at(2)?);
        let step = &one - &zero;
        if step.is_zero() {
            return None;
        }
        let factor = (two - &one) / &step;
        let fixed = (!factor.is_one()).then(|| &zero + &step / (BigRational::one() - &factor));
        Some(Orbit { factor, step, fixed })
    }

    /// Why no later value meets a goal that this value does not meet: the distance left to go is more than what is
    /// still to come, or the goal lies behind.
    fn out_of_reach(&self, value: &Value, goal: &Goal) -> Option<String> {
        let value = value.as_rational()?;
        let (low, high) = match goal {
            Goal::Equals(wanted) => (wanted.as_rational()?, wanted.as_rational()?),
            Goal::Within(centre, radius) => {
                let (centre, radius) = (centre.as_rational()?, radius.as_rational()?);
                (&centre - &radius, centre + radius)
            }
            Goal::Holds(..) => return None,
        };
        let Some(fixed) = &self.fixed else {
            let passed = if self.step.is_positive() { value > high } else { value < low };
            return passed.then(|| format!("it steps over the goal: {} is beyond it", Value::rational(value)));
        };
        let (gap, size) = ((&value - fixed).abs(), self.factor.abs());
        let nearest = if *fixed < low {
            &low - fixed
        } else if *fixed > high {
            fixed - &high
        } else {
            BigRational::zero()
        };
        let farthest = (&low - fixed).abs().max((&high - fixed).abs());
        if size < BigRational::one() && low == high && low == *fixed && !self.factor.is_zero() && !gap.is_zero() {
            let fixed = Value::rational(fixed.clone());
            let factor = Value::rational(self.factor.clone());
            return Some(format!(
                "what is left to {fixed} shrinks by the factor {factor} each round, ({factor})^n, and is never 0: no n"
            ));
        }
        if size < BigRational::one() && !nearest.is_zero() && gap < nearest {
            return Some(format!(
                "it closes in on {} and stays nearer to that than the goal is",
                Value::rational(fixed.clone())
            ));
        }
        (size > BigRational::one() && gap > farthest)
            .then(|| format!("it runs away from {} and has passed the goal", Value::rational(fixed.clone())))
    }
}
