//! Exact closed forms of one-variable recurrences.

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
            return Ok(Closed { pieces: vec![piece(0, Some(1), start), piece(1, None, &constant)], conditions: vec![] });
        }
        let power = factor.power(&count).map_err(no)?;
        start.sub(&fixed).and_then(|gap| gap.mul(&power)).and_then(|gap| gap.add(&fixed)).map_err(no)?
    } else {
        return Err(NoClosedForm(format!("it must be known whether {factor} = 1")));
    };
    Ok(Closed { pieces: vec![Piece { from: Value::zero(), until: None, form }], conditions: vec![] })
}

/// The first index at which a goal is met.
pub fn first(closed: &Closed, index: &Name, goal: &Goal, assumptions: &Assumptions) -> Reach {
    for number in 0..500 {
        let at = Value::integer(number);
        let Some(piece) = closed.pieces.iter().find(|piece| match &piece.until {
            Some(until) => assumptions.decide(Relation::Lss, &at, until) == Some(true),
            None => true,
        }) else {
            return Reach::Unknown("no piece".to_string());
        };
        let Ok(value) = piece.form.with(index, &at) else {
            return Reach::Unknown("no value".to_string());
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
    }
    Reach::Unknown("not within 500 rounds".to_string())
}
