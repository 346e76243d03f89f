//! Exact closed forms of recurrences `x(n+1) = f(x(n))` in one variable, and the first n at which a goal is met.
//!
//! An affine map has one form, `x + n*d` or `limit + c^n*(x - limit)`. A map with `max`, `min` and `if` is affine in
//! regions: the region of the start gives a form, which holds until its guards fail; the index at which they fail is
//! found exactly, and there the next piece begins. Each form is checked, base and step, before it is returned.

mod affine;
mod approach;
mod at_rest;
mod barrier;
mod classes;
mod comes_round;
mod cut_off;
mod cycle;
mod descent;
mod end;
mod factors;
mod far;
mod fractional;
mod hypergeometric;
mod in_pieces;
mod inhomogeneous;
mod interleaved;
mod interval;
mod itinerary;
mod late;
mod line;
mod linear;
mod matrix;
mod modular;
mod near;
mod needed;
mod nested;
mod nonlinear;
mod numeric;
mod outgrown;
mod over;
mod parabola;
mod parts;
mod powers;
mod product;
mod ranges;
mod ratio;
mod rational;
mod reach;
mod region;
mod roots;
mod search;
mod sequences;
mod sides;
mod special;
mod switching;
mod symbolic;
mod terms;
mod together;
mod turns;

use num_traits::ToPrimitive;

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Sort, Value, ValueError};
use affine::affine_pieces;
use approach::approach;
use cut_off::cut_off;
use interval::Interval;
use region::{Guard, resolve, solutions};
pub(crate) use search::NO_VALUE;
use search::{Entry, enter};

use crate::closed_form::Solved;
pub use crate::closed_form::{Comparison, Piece};
pub use at_rest::at_rest;
pub use nonlinear::{Behaviour, behaviour};
pub use parts::{Part, parts};
pub use reach::reach;
pub use sequences::{solve_all, solve_until};
pub use special::{Special, special_cases};
pub use terms::Term;
pub use together::{Apart, solve_apart, solve_together};

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

/// There is no closed form, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NoClosedForm(pub String);

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
    Unknown(String),
}

/// The most pieces that a form may have.
const MOST_PIECES: usize = 200;
/// The same where a piece begins with a value that has symbols, and the size of such a value: it grows from piece to
/// piece, and so does the time that a comparison takes.
const MOST_SYMBOLIC: usize = 16;
const LARGEST_SYMBOLIC: usize = 100;
/// The indices that are tried one by one where there is no better way.
const MOST_TRIED: i64 = 500;

impl From<ValueError> for NoClosedForm {
    fn from(error: ValueError) -> NoClosedForm {
        NoClosedForm(error.0)
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
) -> Result<Closed, NoClosedForm> {
    if map.sort() != Sort::Real || start.sort() != Sort::Real {
        return Err(NoClosedForm("closed forms are known of sequences of numbers only".to_string()));
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
    pieces.collect(start).or_else(|reason| match approach(&motion) {
        Ok(Some(found)) => Ok(found),
        other => match cut_off(&motion) {
            Ok(Some(found)) => Ok(found),
            Err(unknown) if other.is_ok() => Err(unknown),
            _ => Err(other.err().unwrap_or(reason)),
        },
    })
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

/// A piecewise form in the making.
struct Pieces<'a> {
    map: Value,
    variable: &'a Name,
    index: &'a Name,
    known: Assumptions,
    closed: Closed,
    /// Where the pieces began, and with which values.
    history: Vec<(Value, Value)>,
}

impl Pieces<'_> {
    fn collect(mut self, start: &Value) -> Result<Closed, NoClosedForm> {
        let mut from = Value::zero();
        let mut value = self.known.simplify(start);
        for number in 0..MOST_PIECES {
            if let Some(place) = self.history.iter().position(|(_, earlier)| *earlier == value) {
                return self.periodic(place, &from);
            }
            let grown = number >= MOST_SYMBOLIC || value.size() > LARGEST_SYMBOLIC;
            if grown && !value.variables().is_empty() {
                let map = &self.map;
                return Err(NoClosedForm(format!("the guards of {map} change {number} times and more")));
            }
            self.history.push((from.clone(), value.clone()));
            let Some((next, image)) = self.piece(&from, &value)? else { return Ok(self.closed) };
            from = next;
            value = image;
        }
        Err(NoClosedForm(format!("the guards of {} change more than {MOST_PIECES} times", self.map)))
    }

    /// The piece that begins here; where the next begins and with which value.
    fn piece(&mut self, from: &Value, value: &Value) -> Result<Option<(Value, Value)>, NoClosedForm> {
        let (local, guards) = resolve(&self.map, self.variable, value, &self.known)?;
        if local.linear_in(self.variable).is_none() {
            return Err(NoClosedForm(format!("{local} is not affine in {}", self.variable)));
        }
        let (pieces, conditions) = affine_pieces(&local, self.variable, value, self.index, &self.known)?;
        for (relation, left, right) in &conditions {
            self.known.assume(*relation, left, right);
        }
        self.closed.conditions.extend(conditions);
        let Some((length, failed)) = self.length(&pieces, &guards)? else {
            self.append(&pieces, from, None)?;
            return Ok(None);
        };
        self.append(&pieces, from, Some(&length))?;
        let local_form = Closed { variable: self.variable.clone(), pieces, conditions: Vec::new() };
        let Some(image) = local_form.at(self.index, &length, &self.known) else {
            return Err(NoClosedForm(format!("it must be known which piece holds at {length}")));
        };
        let failing = failed.value.with(self.variable, &image)?;
        self.known.assume(failed.relation.negated(), &failing, &Value::zero());
        Ok(Some((from.add(&length)?, self.known.simplify(&image))))
    }

    /// How many steps all guards hold, and the one that fails then; `None` if they hold for ever.
    fn length(&mut self, pieces: &[Piece], guards: &[Guard]) -> Result<Option<(Value, Guard)>, NoClosedForm> {
        let local = Closed { variable: self.variable.clone(), pieces: pieces.to_vec(), conditions: Vec::new() };
        let mut least: Option<(Value, Guard)> = None;
        for guard in guards {
            let goal = Goal::Holds(guard.relation.negated(), guard.value.clone(), Value::zero());
            match first(&local, self.index, &goal, &self.known) {
                Reach::Never(_) => {}
                Reach::Unknown(reason) if reason.ends_with(NO_VALUE) => {
                    let (value, sign) = (&guard.value, guard.relation.negated().symbol());
                    return Err(NoClosedForm(format!("of the first index at which {value} {sign} 0: {reason}")));
                }
                Reach::Unknown(reason) => return Err(NoClosedForm(reason)),
                Reach::At(at, conditions) => {
                    for (relation, left, right) in &conditions {
                        self.known.assume(*relation, left, right);
                    }
                    self.closed.conditions.extend(conditions);
                    let sooner = match &least {
                        None => true,
                        Some((other, _)) => self
                            .known
                            .decide(Relation::Lss, &at, other)
                            .ok_or_else(|| NoClosedForm(format!("it must be known whether {at} < {other}")))?,
                    };
                    if sooner {
                        least = Some((at, guard.clone()));
                    }
                }
            }
        }
        Ok(least)
    }

    /// Adds forms that count from `from`, up to `length` steps after it.
    fn append(&mut self, pieces: &[Piece], from: &Value, length: Option<&Value>) -> Result<(), NoClosedForm> {
        let shifted = Value::variable(self.index).sub(from)?;
        for piece in pieces {
            if let Some(length) = length
                && self.known.decide(Relation::Gte, &piece.from, length) == Some(true)
            {
                break;
            }
            let until = match (&piece.until, length) {
                (Some(until), Some(length)) => {
                    if self.known.decide(Relation::Lte, until, length) == Some(true) {
                        Some(until)
                    } else {
                        Some(length)
                    }
                }
                (until, length) => until.as_ref().or(length),
            };
            self.closed.pieces.push(Piece {
                from: from.add(&piece.from)?,
                until: until.map(|until| from.add(until)).transpose()?,
                form: piece.form.with(self.index, &shifted)?,
            });
        }
        Ok(())
    }

    /// The value at `from` was there before: of two values in turn there is a form, with `(-1)^n`.
    fn periodic(mut self, place: usize, from: &Value) -> Result<Closed, NoClosedForm> {
        let since = self.history[place].0.clone();
        let period = from.sub(&since)?;
        let mut values = Vec::new();
        for step in 0..2 {
            let at = since.add(&Value::integer(step))?;
            values.extend(self.closed.at(self.index, &at, &self.known));
        }
        let ([first, second], true) = (values.as_slice(), period == Value::integer(2)) else {
            return Err(NoClosedForm(format!("from n = {since} on it goes round in {period} steps")));
        };
        let half = Value::fraction(1, 2)?;
        let (middle, swing) = (first.add(second)?.mul(&half)?, first.sub(second)?.mul(&half)?);
        let turn = Value::integer(-1).power(&Value::variable(self.index).sub(&since)?)?;
        self.closed.pieces.retain(|piece| self.known.decide(Relation::Lss, &piece.from, &since) == Some(true));
        self.closed.pieces.push(Piece { from: since, until: None, form: middle.add(&swing.mul(&turn)?)? });
        Ok(self.closed)
    }
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
    let mut reason = "there is no piece".to_string();
    for (place, piece) in closed.pieces.iter().enumerate() {
        // Whether the first index behind the piece has it.
        let next = closed.pieces.get(place + 1);
        let value = next.and_then(|next| next.form.with(index, &next.from).ok());
        let at_end = value.is_some_and(|value| meets(&value, closed, goal, known) == Some(true));
        match in_piece((piece, at_end), closed, index, goal, known) {
            Ok(Reach::Never(why)) => reason = why,
            Err(NoClosedForm(why)) => return Reach::Unknown(why),
            Ok(found) => return found,
        }
    }
    Reach::Never(reason)
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
) -> Result<Reach, NoClosedForm> {
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
) -> Result<Reach, NoClosedForm> {
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
            (Reach::Unknown(why), _) | (_, Reach::Unknown(why)) if why.ends_with(NO_VALUE) && intervals.len() > 1 => {
                Reach::Unknown("it may be met on either side, and when first is not known".to_string())
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
                    None => Reach::Unknown(format!("it must be known whether {one} <= {other}")),
                }
            }
        };
    }
    Ok(best)
}

/// The least index of a piece at which a value is not 0.
fn differs(value: &Value, piece: &Piece, index: &Name, known: &Assumptions) -> Result<Reach, NoClosedForm> {
    if !value.mentions(index) {
        return Ok(match known.decide(Relation::Neq, value, &Value::zero()) {
            Some(true) => Reach::At(piece.from.clone(), Vec::new()),
            Some(false) => Reach::Never(format!("it stays {}", piece.form)),
            None => Reach::Unknown(format!("it must be known whether {value} = 0")),
        });
    }
    let mut at = piece.from.clone();
    // Two equal values in a row would be values of a constant sequence, or of one that came to rest.
    for _ in 0..2 {
        if let Some(until) = &piece.until {
            match known.decide(Relation::Lss, &at, until) {
                Some(true) => {}
                Some(false) => return Ok(Reach::Never("it stays the same in this piece".to_string())),
                None => return Ok(Reach::Unknown(format!("it must be known whether {at} < {until}"))),
            }
        }
        let here = value.with(index, &at)?;
        match known.decide(Relation::Neq, &here, &Value::zero()) {
            Some(true) => return Ok(Reach::At(at, Vec::new())),
            Some(false) => at = at.add(&Value::one())?,
            None => return Ok(Reach::Unknown(format!("it must be known whether {here} = 0"))),
        }
    }
    Ok(Reach::Unknown(format!("when {value} differs from 0 first")))
}
