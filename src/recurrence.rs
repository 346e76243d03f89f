//! Exact closed forms of recurrences `x(n+1) = f(x(n))` in one variable, and the first n at which a goal is met.
//!
//! An affine map has one form, `x + n*d` or `limit + c^n*(x - limit)`. A map with `max`, `min` and `if` is affine in
//! regions: the region of the start gives a form, which holds until its guards fail; the index at which they fail is
//! found exactly, and there the next piece begins. Each form is checked, base and step, before it is returned.

mod absorbed;
mod affine;
mod approach;
mod as_far;
mod at_rest;
mod barrier;
mod behind;
mod bounds;
mod classes;
mod comes_round;
mod convex;
mod counted;
mod cut_off;
mod cycle;
mod descent;
mod difference;
mod driven;
mod either_way;
mod end;
mod exact;
mod factors;
mod far;
mod fixed;
mod fractional;
mod from_zero;
mod going_round;
mod grouped;
mod hypergeometric;
mod in_pieces;
mod inhomogeneous;
mod interleaved;
mod interval;
mod itinerary;
mod jointly;
mod kept;
mod late;
mod line;
mod linear;
mod matrix;
mod maxima;
mod meeting;
mod modes;
mod modular;
mod modulo;
mod multiplied;
mod near;
mod needed;
mod nested;
mod never;
mod nonlinear;
mod numeric;
mod orders;
mod outgrown;
mod over;
mod overlap;
mod parabola;
mod parts;
mod piece_by_piece;
mod pieces;
mod powers;
mod product;
mod ranges;
mod ratio;
mod rational;
mod reach;
mod region;
mod roots;
mod rotation;
mod scaled;
mod search;
mod sequences;
mod settled;
mod sides;
mod since;
mod special;
mod squares;
mod stationary;
mod switching;
mod symbolic;
mod terms;
mod together;
mod turns;
mod valued;

use num_traits::ToPrimitive;

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Sort, Value, ValueError};
use affine::affine_pieces;
use approach::approach;
use cut_off::cut_off;
use going_round::in_one_round;
use interval::Interval;
use overlap::overlapping;
use piece_by_piece::piece_by_piece;
use pieces::Pieces;
use region::solutions;
use search::NO_VALUE;
use search::{Entry, enter};

use crate::closed_form::Solved;
pub use crate::closed_form::{Comparison, Piece};
pub use as_far::as_far_as;
pub use at_rest::{Resting, at_rest};
pub use either_way::InCase;
pub(crate) use either_way::{either_way, in_each_case};
pub use kept::bounds;
pub(crate) use maxima::lesser;
pub(crate) use needed::read_by;
pub use nonlinear::{Behaviour, behaviour, near};
pub use orders::solve_in_cases;
pub(crate) use orders::{MOST_PAIRS, pairs, parameters};
pub use parts::{Part, parts};
pub use sequences::{solve_all, solve_until};
pub use since::reach_since;
pub use special::{Special, special_cases};
pub use stationary::Stationary;
pub use terms::Term;
pub use together::{Apart, solve_apart, solve_together};
pub use valued::reach;

/// A closed form by pieces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Closed {
    /// The variable of the recurrence, which a [`Goal::Holds`] is about.
    pub variable: Name,
    /// In order, without gaps, from 0.
    pub pieces: Vec<Piece>,
    /// What must hold for it to be right.
    pub conditions: Vec<Comparison>,
}

/// A closed form, or an index, that is not known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Why.
    pub reason: String,
    /// The comparison that would have to be decided, where the reason is that it is not.
    pub open: Option<Box<Comparison>>,
    /// The index in words, where there is one that is no value here.
    pub formula: Option<Box<Formula>>,
}

/// An index that is told by logarithms, which are no values here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Formula {
    /// The index: `ceil(log(g)/log(a))`.
    pub index: String,
    /// What it is the first index of: `a^n >= g`.
    pub test: String,
    /// The power in that, so many times, which is more than 0.
    pub power: Value,
    /// How it compares with the bound.
    pub relation: Relation,
    /// The bound.
    pub bound: Value,
}

/// What is asked of a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Goal {
    /// It is equal to this.
    Equals(Value),
    /// Its distance from the first is at most the second.
    Within(Value, Value),
    /// A comparison of two expressions in the variable of the recurrence.
    Holds(Relation, Value, Value),
}

/// When a goal is met first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reach {
    /// At this index and no earlier one, under conditions.
    At(Value, Vec<Comparison>),
    /// Never, and why.
    Never(String),
    /// Not known, and why.
    Unknown(Unknown),
}

/// The indices that are tried one by one where there is no better way.
const MOST_TRIED: i64 = 500;

impl Unknown {
    pub(crate) fn because(reason: impl Into<String>) -> Unknown {
        Unknown { reason: reason.into(), open: None, formula: None }
    }

    /// Whether there is an index, but none that can be written as a value here.
    pub fn has_no_value(&self) -> bool {
        self.reason.ends_with(NO_VALUE)
    }

    /// It is not known whether a comparison holds.
    fn undecided(relation: Relation, left: &Value, right: &Value) -> Unknown {
        let reason = format!("it must be known whether {left} {} {right}", relation.symbol());
        Unknown { reason, open: Some(Box::new((relation, left.clone(), right.clone()))), formula: None }
    }
}

impl std::fmt::Display for Unknown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.reason)
    }
}

impl Reach {
    /// Not known, for this reason.
    pub(crate) fn unknown(reason: impl Into<String>) -> Reach {
        Reach::Unknown(Unknown::because(reason))
    }

    /// It is not known whether a comparison holds.
    fn undecided(relation: Relation, left: &Value, right: &Value) -> Reach {
        Reach::Unknown(Unknown::undecided(relation, left, right))
    }
}

impl From<ValueError> for Unknown {
    fn from(error: ValueError) -> Unknown {
        Unknown::because(error.0)
    }
}

impl Closed {
    /// The value at an index; `None` when it is not known in which piece the index lies.
    pub fn at(&self, index: &Name, at: &Value, assumptions: &Assumptions) -> Option<Value> {
        for piece in &self.pieces {
            let here = match &piece.until {
                None => true,
                Some(until) => assumptions.decide(Relation::Lss, at, until)?,
            };
            if here {
                return piece.form.with(index, at).ok();
            }
        }
        None
    }
}

/// A closed form of `x(n+1) = map(x(n))`, `x(0) = start`, in the index n.
///
/// # Errors
/// When none is found, with what would have to be known.
pub fn solve(
    map: &Value,
    variable: &Name,
    start: &Value,
    index: &Name,
    assumptions: &Assumptions,
) -> Result<Closed, Unknown> {
    if map.sort() != Sort::Real || start.sort() != Sort::Real {
        return Err(Unknown::because("closed forms are known of sequences of numbers only"));
    }
    let mut known = assumptions.clone();
    known.assume_natural(index);
    let map = known.simplify(map);
    let mut closed = Closed { variable: variable.clone(), pieces: Vec::new(), conditions: Vec::new() };
    if map.linear_in(variable).is_some() {
        let pieces = affine_pieces(&map, variable, start, index, &known)?;
        closed.pieces = pieces.0;
        closed.conditions = pieces.1;
        return Ok(closed);
    }
    let pieces = Pieces { map: map.clone(), variable, index, known: known.clone(), closed, history: Vec::new() };
    let motion = Motion { map: &map, variable, start, index, known: &known };
    let reason = match pieces.collect(start) {
        Ok(found) => return Ok(in_fewer_pieces(found, &motion)),
        Err(reason) => reason,
    };
    match approach(&motion) {
        Ok(Some(found)) => Ok(found),
        other => match cut_off(&motion) {
            Ok(Some(found)) => Ok(found),
            Err(unknown) if other.is_ok() => Err(unknown),
            _ => Err(other.err().unwrap_or(reason)),
        },
    }
}

/// A form whose pieces end at symbols, or one that needs fewer of them: a way of steps that a goal cuts off ends at
/// `ceil(d/s)`, where the last step that is whole and the rest are pieces of their own otherwise.
fn in_fewer_pieces(found: Closed, motion: &Motion<'_>) -> Closed {
    let symbolic = |piece: &Piece| piece.until.as_ref().is_some_and(|until| until.as_rational().is_none());
    if found.pieces.len() <= 2 || !found.pieces.iter().any(symbolic) {
        return found;
    }
    match approach(motion) {
        Ok(Some(other)) if other.pieces.len() < found.pieces.len() && other.conditions.is_empty() => other,
        _ => found,
    }
}

/// `x(n+1) = map(x(n))` from a start on, where the index is known to be natural.
#[derive(Clone, Copy)]
struct Motion<'a> {
    map: &'a Value,
    variable: &'a Name,
    start: &'a Value,
    index: &'a Name,
    known: &'a Assumptions,
}

/// The least index at which a goal is met.
pub fn first(closed: &Closed, index: &Name, goal: &Goal, assumptions: &Assumptions) -> Reach {
    let mut known = assumptions.clone();
    known.assume_natural(index);
    match by_shape(closed, index, goal, &known) {
        Reach::Unknown(why) => tried(closed, index, goal, &known).unwrap_or(Reach::Unknown(why)),
        found => found,
    }
}

/// The same from the shapes of the pieces alone, which costs little; the index is known to be natural.
fn by_shape(closed: &Closed, index: &Name, goal: &Goal, known: &Assumptions) -> Reach {
    if let Some(found) = in_one_round(closed, index, goal, known) {
        return found;
    }
    match piece_by_piece(closed, index, goal, known) {
        Reach::Unknown(why) => {
            let longer = overlapping(closed, index, known);
            match longer.map(|closed| piece_by_piece(&closed, index, goal, known)) {
                Some(found @ (Reach::At(..) | Reach::Never(_))) => found,
                _ => Reach::Unknown(why),
            }
        }
        found => found,
    }
}

/// The first index at which the goal is decided to hold, where it is decided not to at all earlier ones.
fn tried(closed: &Closed, index: &Name, goal: &Goal, known: &Assumptions) -> Option<Reach> {
    let from = closed.pieces.first()?.from.as_rational()?.to_integer().to_i64()?;
    for number in from..from.checked_add(MOST_TRIED)? {
        let at = Value::integer(number);
        let value = closed.at(index, &at, known)?;
        if meets(&value, closed, goal, known)? {
            return Some(Reach::At(at, Vec::new()));
        }
    }
    None
}

/// Whether a value meets the goal.
fn meets(value: &Value, closed: &Closed, goal: &Goal, known: &Assumptions) -> Option<bool> {
    match goal {
        Goal::Equals(wanted) => known.decide(Relation::Eq, value, wanted),
        Goal::Within(center, tolerance) => known.decide(Relation::Lte, &value.sub(center).ok()?.abs().ok()?, tolerance),
        Goal::Holds(relation, left, right) => {
            let [left, right] = [left, right].map(|side| side.with(&closed.variable, value).ok());
            known.decide(*relation, &left?, &right?)
        }
    }
}

/// The least index of a piece at which a goal is met; `at_end`: the first index behind it surely meets it.
fn in_piece(
    (piece, at_end): (&Piece, bool),
    closed: &Closed,
    index: &Name,
    goal: &Goal,
    known: &Assumptions,
) -> Result<Reach, Unknown> {
    let entry = |value: Value, interval: Interval| {
        let (from, until) = (&piece.from, piece.until.as_ref());
        enter(&Entry { value, interval, from, until, at_end, form: &piece.form, index, known })
    };
    let (relation, difference) = match goal {
        Goal::Equals(wanted) => {
            return entry(piece.form.sub(wanted)?, Interval::of(Relation::Eq));
        }
        Goal::Within(center, tolerance) => {
            let interval = Interval::between(tolerance.neg()?, tolerance.clone());
            return entry(piece.form.sub(center)?, interval);
        }
        Goal::Holds(relation, left, right) => (*relation, left.sub(right)?),
    };
    if relation == Relation::Neq {
        return differs(&difference.with(&closed.variable, &piece.form)?, piece, index, known);
    }
    if !piece.form.mentions(index) {
        return entry(difference.with(&closed.variable, &piece.form)?, Interval::of(relation));
    }
    if difference.linear_in(&closed.variable).is_some() {
        let value = difference.with(&closed.variable, &piece.form)?;
        // An index is not negative, so neither is a length along the way: `abs(n)` is n.
        let bent = value.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_)));
        return entry(if bent { known.simplify(&value) } else { value }, Interval::of(relation));
    }
    // Of a quotient of terms it is asked as a function of the index, of which the reasons then speak.
    if difference.denominator().is_some_and(|below| below.mentions(&closed.variable)) {
        let value = difference.with(&closed.variable, &piece.form)?;
        let (form, from, until) = (&value.clone(), &piece.from, piece.until.as_ref());
        let asked = Entry { value, interval: Interval::of(relation), from, until, at_end, form, index, known };
        if let found @ Ok(Reach::At(..) | Reach::Never(_)) = enter(&asked) {
            return found;
        }
    }
    earliest(&solutions(&difference, &closed.variable, relation, known)?, (piece, at_end), index, known)
}

/// The least index of a piece at which the sequence lies in one of the intervals.
fn earliest(
    intervals: &[Interval],
    (piece, at_end): (&Piece, bool),
    index: &Name,
    known: &Assumptions,
) -> Result<Reach, Unknown> {
    let (from, until) = (&piece.from, piece.until.as_ref());
    let mut best = Reach::Never(format!("it is never met from n = {from} on"));
    for interval in intervals {
        let (value, interval) = (piece.form.clone(), interval.clone());
        let found = enter(&Entry { value, interval, from, until, at_end, form: &piece.form, index, known })?;
        best = match (best, found) {
            (_, Reach::At(at, conditions)) if at == *from && conditions.is_empty() => {
                return Ok(Reach::At(at, conditions));
            }
            // Of several intervals the first one that is come to counts.
            (Reach::Unknown(why), _) | (_, Reach::Unknown(why)) if why.has_no_value() && intervals.len() > 1 => {
                Reach::unknown("it may be met on either side, and when first is not known")
            }
            (Reach::Unknown(why), _) | (_, Reach::Unknown(why)) => Reach::Unknown(why),
            (Reach::Never(_), found) => found,
            (best, Reach::Never(_)) => best,
            (Reach::At(one, first), Reach::At(other, second)) => {
                match (first.is_empty() && second.is_empty())
                    .then(|| known.decide(Relation::Lte, &one, &other))
                    .flatten()
                {
                    Some(true) => Reach::At(one, first),
                    Some(false) => Reach::At(other, second),
                    None => Reach::undecided(Relation::Lte, &one, &other),
                }
            }
        };
    }
    Ok(best)
}

/// The least index of a piece at which a value is not 0.
fn differs(value: &Value, piece: &Piece, index: &Name, known: &Assumptions) -> Result<Reach, Unknown> {
    if !value.mentions(index) {
        return Ok(match known.decide(Relation::Neq, value, &Value::zero()) {
            Some(true) => Reach::At(piece.from.clone(), Vec::new()),
            Some(false) => Reach::Never(format!("it stays {}", piece.form)),
            None => Reach::undecided(Relation::Eq, value, &Value::zero()),
        });
    }
    let mut at = piece.from.clone();
    // Two equal values in a row would be values of a constant sequence, or of one that came to rest.
    for _ in 0..2 {
        if let Some(until) = &piece.until {
            match known.decide(Relation::Lss, &at, until) {
                Some(true) => {}
                Some(false) => return Ok(Reach::Never("it stays the same in this piece".to_string())),
                None => return Ok(Reach::undecided(Relation::Lss, &at, until)),
            }
        }
        let here = value.with(index, &at)?;
        match known.decide(Relation::Neq, &here, &Value::zero()) {
            Some(true) => return Ok(Reach::At(at, Vec::new())),
            Some(false) => at = at.add(&Value::one())?,
            None => return Ok(Reach::undecided(Relation::Eq, &here, &Value::zero())),
        }
    }
    Ok(Reach::unknown(format!("when {value} differs from 0 first")))
}
