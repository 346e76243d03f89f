//! Forms by pieces: the region of the start gives a form, which holds until its guards fail; there the next piece begins.

use num_rational::BigRational;

use super::affine::affine_pieces;
use super::region::{Failing, Guard, fails_at, resolve};
use super::{Closed, Goal, Piece, Reach, Unknown, first, meets};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The most pieces that a form may have.
const MOST_PIECES: usize = 200;
/// The same where a piece begins with a value that has symbols, and the size of such a value: it grows from piece to
/// piece, and so does the time that a comparison takes.
const MOST_SYMBOLIC: usize = 16;
const LARGEST_SYMBOLIC: usize = 100;
/// A round of no more steps is told step by step; the most pieces of one that is told as a whole.
const FEW_STEPS: i64 = 6;
const MOST_IN_ROUND: usize = 3;

/// A piecewise form in the making.
pub(super) struct Pieces<'a> {
    pub(super) map: Value,
    pub(super) variable: &'a Name,
    pub(super) index: &'a Name,
    pub(super) known: Assumptions,
    pub(super) closed: Closed,
    /// Where the pieces began, and with which values.
    pub(super) history: Vec<(Value, Value)>,
}

impl Pieces<'_> {
    pub(super) fn collect(mut self, start: &Value) -> Result<Closed, Unknown> {
        let mut from = Value::zero();
        let mut value = self.known.simplify(start);
        for number in 0..MOST_PIECES {
            if let Some(place) = self.history.iter().position(|(_, earlier)| *earlier == value) {
                return self.periodic(place, &from);
            }
            let grown = number >= MOST_SYMBOLIC || value.size() > LARGEST_SYMBOLIC;
            if grown && !value.variables().is_empty() {
                let map = &self.map;
                return Err(Unknown::because(format!("the guards of {map} change {number} times and more")));
            }
            self.history.push((from.clone(), value.clone()));
            let Some((next, image)) = self.piece(&from, &value)? else { return Ok(self.closed) };
            from = next;
            value = image;
        }
        Err(Unknown::because(format!("the guards of {} change more than {MOST_PIECES} times", self.map)))
    }

    /// The piece that begins here; where the next begins and with which value.
    fn piece(&mut self, from: &Value, value: &Value) -> Result<Option<(Value, Value)>, Unknown> {
        let (local, guards) = resolve(&self.map, self.variable, value, &self.known)?;
        if local.linear_in(self.variable).is_none() {
            return Err(Unknown::because(format!("{local} is not affine in {}", self.variable)));
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
            return Err(Unknown::because(format!("it must be known which piece holds at {length}")));
        };
        let failing = failed.value.with(self.variable, &image)?;
        self.known.assume(failed.relation.negated(), &failing, &Value::zero());
        Ok(Some((from.add(&length)?, self.known.simplify(&image))))
    }

    /// How many steps all guards hold, and the one that fails then; `None` if they hold for ever.
    fn length(&mut self, pieces: &[Piece], guards: &[Guard]) -> Result<Failing, Unknown> {
        let local = Closed { variable: self.variable.clone(), pieces: pieces.to_vec(), conditions: Vec::new() };
        let mut least: Failing = None;
        for guard in guards {
            let goal = Goal::Holds(guard.relation.negated(), guard.value.clone(), Value::zero());
            match first(&local, self.index, &goal, &self.known) {
                Reach::Never(_) => {}
                Reach::Unknown(reason) if reason.has_no_value() => {
                    let (value, sign) = (&guard.value, guard.relation.negated().symbol());
                    return Err(Unknown::because(format!(
                        "its form changes at the first index with {value} {sign} 0, which is a logarithm"
                    )));
                }
                Reach::Unknown(unknown) => return Err(unknown),
                Reach::At(at, conditions) => {
                    let at_once = at.as_rational().is_none() && self.fails_at_once(&local, &goal);
                    let (at, conditions) = if at_once { (Value::one(), Vec::new()) } else { (at, conditions) };
                    fails_at(&mut least, guard, (at, conditions), &mut self.known, &mut self.closed.conditions)?;
                }
            }
        }
        Ok(least)
    }

    /// Whether a guard, which holds where a piece begins, is known to fail after one step: `ceil(l)-floor(l)` is 1 where l is
    /// no whole number.
    fn fails_at_once(&self, local: &Closed, goal: &Goal) -> bool {
        let after = local.at(self.index, &Value::one(), &self.known);
        after.is_some_and(|after| meets(&after, local, goal, &self.known) == Some(true))
    }

    /// Adds forms that count from `from`, up to `length` steps after it.
    fn append(&mut self, pieces: &[Piece], from: &Value, length: Option<&Value>) -> Result<(), Unknown> {
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

    /// The value at `from` was there before: of two values in turn there is a form, with `(-1)^n`; of more one of the place
    /// in the round, which is the index modulo its length.
    fn periodic(mut self, place: usize, from: &Value) -> Result<Closed, Unknown> {
        let since = self.history[place].0.clone();
        let period = from.sub(&since)?;
        let begun = |piece: &Piece| self.known.decide(Relation::Gte, &piece.from, &since) == Some(true);
        let (round, mut pieces): (Vec<Piece>, Vec<Piece>) = self.closed.pieces.iter().cloned().partition(begun);
        let form = if period == Value::integer(2) {
            let mut values = Vec::new();
            for step in 0..2 {
                let at = since.add(&Value::integer(step))?;
                values.extend(self.closed.at(self.index, &at, &self.known));
            }
            let [first, second] = values.as_slice() else { return Err(goes_round(&since, &period)) };
            let half = Value::fraction(1, 2)?;
            let (middle, swing) = (first.add(second)?.mul(&half)?, first.sub(second)?.mul(&half)?);
            let turn = Value::integer(-1).power(&Value::variable(self.index).sub(&since)?)?;
            middle.add(&swing.mul(&turn)?)?
        } else {
            let few = period.as_rational().is_some_and(|period| period <= BigRational::from_integer(FEW_STEPS.into()));
            match in_rounds(&joined(round, self.index, &self.known), &since, &period, self.index)?.filter(|_| !few) {
                Some(form) => form,
                None => return Err(goes_round(&since, &period)),
            }
        };
        pieces.push(Piece { from: since, until: None, form });
        self.closed.pieces = pieces;
        Ok(self.closed)
    }
}

fn goes_round(since: &Value, period: &Value) -> Unknown {
    Unknown::because(format!("from n = {since} on it goes round in {period} steps"))
}

/// The pieces of a round, where one of a single index whose value the form before it gives, too, is taken into that.
fn joined(round: Vec<Piece>, index: &Name, known: &Assumptions) -> Vec<Piece> {
    let mut all: Vec<Piece> = Vec::new();
    for piece in round {
        let follows = |last: &&mut Piece| {
            let next = piece.from.add(&Value::one()).ok();
            let [one, other] = [&last.form, &piece.form].map(|form| form.with(index, &piece.from).ok());
            piece.until.is_some()
                && next == piece.until
                && one.zip(other).is_some_and(|(one, other)| known.decide(Relation::Eq, &one, &other) == Some(true))
        };
        match all.last_mut().filter(follows) {
            Some(last) => last.until = piece.until,
            None => all.push(piece),
        }
    }
    all
}

/// The pieces of one round, for all rounds: of the place in the round, `n-m*floor((n-s)/m)`.
fn in_rounds(round: &[Piece], since: &Value, period: &Value, index: &Name) -> Result<Option<Value>, Unknown> {
    let count = Value::variable(index);
    let before = count.sub(since)?.div(period)?.floor()?;
    let place = count.sub(&period.mul(&before)?)?;
    let Some((last, earlier)) = round.split_last().filter(|(_, earlier)| earlier.len() < MOST_IN_ROUND) else {
        return Ok(None);
    };
    let mut form = last.form.with(index, &place)?;
    for piece in earlier.iter().rev() {
        let Some(until) = &piece.until else { return Ok(None) };
        form = Value::choose(Relation::Lss, &place, until, &piece.form.with(index, &place)?, &form)?;
    }
    Ok(Some(form))
}
