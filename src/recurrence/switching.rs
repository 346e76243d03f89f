//! Sequences whose equations change as they go on: maxima and conditions in which terms, or the index and terms, are compared.
//!
//! Where the sequences begin the equations are what their guards make of them, and have forms. The first index at which a
//! guard fails under these forms is looked for, and there the next piece begins. That each holds as long as is said, the last
//! for ever, is for the induction to show.

use std::collections::BTreeMap;

use super::as_far::FirstLegs;
use super::from_zero::later;
use super::ranges::{after, as_pieces, joined, trimmed, up_to};
use super::reach::reach;
use super::region::{Failing, Guard, Point, fails_at, resolve_at};
use super::sequences::{Found, solve_until};
use super::{Closed, Comparison, Reach, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Solved};
use crate::value::{Atom, Relation, Value};

/// The most pieces.
const MOST_PIECES: usize = 24;
/// The most of those that are told where there are no forms of all.
const MOST_FIRST: usize = 4;
/// The longest value at which a piece may begin.
const MOST_SIZE: usize = 130;
/// The most first terms that are listed before forms that are no values.
const MOST_LISTED: i64 = 100;

/// Where a piece begins, and the first terms from there.
pub(super) struct Place {
    pub(super) from: Value,
    pub(super) starts: Vec<Vec<Value>>,
}

/// What holds from a place on.
pub(super) enum Leg {
    /// These equations, counted from there, as long as all guards hold.
    While(Recurrence, Vec<Guard>),
    /// One step, to these terms.
    Step(Vec<Vec<Value>>),
}

/// What holds from a place on, given what is known.
type Local<'l> = &'l dyn Fn(&Switching<'_>, &Place) -> Result<Leg, Unknown>;

/// Forms of a recurrence that begins at 0, the shortest first; none where nothing compares terms.
///
/// # Errors
/// Where a piece has no form, or it cannot be said when it ends.
pub(super) fn switching(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Found>, Unknown> {
    if !compares(recurrence) {
        return Ok(Vec::new());
    }
    Switching::new(recurrence, known, stop).legs(MOST_PIECES, &|switching, place| switching.local(place))
}

/// The forms of the first of these, where there are none of all.
pub(super) fn first_switches(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<FirstLegs, Option<Unknown>> {
    let switching = compares(recurrence).then(|| Switching::new(recurrence, known, stop)).ok_or(None)?;
    switching.first_legs(MOST_FIRST, &|switching, place| switching.local(place))
}

/// Whether a maximum or condition reads a term, or the index.
pub(super) fn compares(recurrence: &Recurrence) -> bool {
    let terms = recurrence.terms();
    let varies = |atom: &Atom| atom.mentions(&recurrence.index) || terms.iter().any(|(name, ..)| atom.mentions(name));
    let compares = |atom: &Atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)) && varies(atom);
    recurrence.sequences.iter().any(|sequence| sequence.next.atoms().iter().any(compares))
}

pub(super) struct Switching<'a> {
    pub(super) recurrence: &'a Recurrence,
    stop: &'a dyn Fn() -> bool,
    pub(super) known: Assumptions,
    conditions: Vec<Comparison>,
    /// What was found of each sequence.
    pieces: Vec<Vec<Piece>>,
}

impl<'a> Switching<'a> {
    pub(super) fn new(recurrence: &'a Recurrence, known: &Assumptions, stop: &'a dyn Fn() -> bool) -> Switching<'a> {
        let pieces = vec![Vec::new(); recurrence.sequences.len()];
        Switching { recurrence, stop, known: known.clone(), conditions: Vec::new(), pieces }
    }

    fn start(&self) -> Place {
        let starts = self.recurrence.sequences.iter().map(|sequence| sequence.start.clone()).collect();
        Place { from: Value::zero(), starts }
    }

    /// The forms, leg by leg, so many at most.
    pub(super) fn legs(mut self, most: usize, local: Local<'_>) -> Result<Vec<Found>, Unknown> {
        let mut place = self.start();
        self.go(&mut place, most, local)
    }

    /// The forms of the first legs, so many at most, where there are none of all, and where they end.
    ///
    /// # Errors
    /// What would have to be known for the first of them; nothing where it is something else.
    pub(super) fn first_legs(mut self, most: usize, local: Local<'_>) -> Result<FirstLegs, Option<Unknown>> {
        let mut place = self.start();
        let why = self.go(&mut place, most, local).err().ok_or(None)?;
        if place.from.is_zero() || !self.conditions.is_empty() {
            return Err(Some(why).filter(|why| why.open.is_some() && self.conditions.is_empty()));
        }
        let index = &self.recurrence.index;
        for (pieces, start) in self.pieces.iter_mut().zip(&place.starts) {
            let form = start.first().ok_or(None)?.clone();
            pieces.push(Piece { from: place.from.clone(), until: None, form });
        }
        let forms = self.pieces.iter().map(|pieces| as_form(joined(pieces, index, &self.known))).collect();
        Ok((forms, place.from, why.reason))
    }

    /// Goes on from a place, leg by leg, to the last one, which is for ever.
    fn go(&mut self, place: &mut Place, most: usize, local: Local<'_>) -> Result<Vec<Found>, Unknown> {
        for _ in 0..most {
            *place = match local(self, place)? {
                Leg::Step(next) => self.step(place, next)?,
                Leg::While(local, guards) => {
                    let solved = self.solved(local, place)?;
                    let Some((length, failed)) = self.length(&solved, &guards, &place.from)? else {
                        return self.found(&solved, place);
                    };
                    self.go_on(&solved, place, &length, &failed)?
                }
            };
            if place.starts.iter().flatten().chain([&place.from]).any(|value| value.size() > MOST_SIZE) {
                return Err(Unknown::because("where its maxima and conditions change becomes too long an expression"));
            }
        }
        Err(Unknown::because(format!("its maxima and conditions change more than {most} times")))
    }

    /// The equations from a place on, and the guards under which they hold.
    fn local(&self, place: &Place) -> Result<Leg, Unknown> {
        let recurrence = self.recurrence;
        let index = &recurrence.index;
        let terms = recurrence.terms();
        let mut values: BTreeMap<_, _> =
            terms.iter().map(|(name, own, offset)| (name.clone(), place.starts[*own][*offset].clone())).collect();
        values.insert(index.clone(), place.from.clone());
        let point = Point { values, index: Some(index) };
        let shifted = Value::variable(index).add(&place.from)?;
        let mut local = recurrence.clone();
        let mut guards: Vec<Guard> = Vec::new();
        for (sequence, start) in local.sequences.iter_mut().zip(&place.starts) {
            let (next, own) = resolve_at(&sequence.next, &point, &self.known)?;
            sequence.next = next.with(index, &shifted)?;
            sequence.start.clone_from(start);
            for guard in own {
                if !guards.contains(&guard) {
                    guards.push(guard);
                }
            }
        }
        for guard in &mut guards {
            guard.value = guard.value.with(index, &shifted)?;
        }
        Ok(Leg::While(local, guards))
    }

    /// The forms from a place on, counted from there.
    fn solved(&mut self, local: Recurrence, place: &Place) -> Result<Solved, Unknown> {
        let solved = solve_until(local, &self.known, self.stop).map_err(|unknown| self.counted_from(place, unknown))?;
        for (relation, left, right) in solved.conditions() {
            self.known.assume(*relation, left, right);
            self.conditions.push((*relation, left.clone(), right.clone()));
        }
        Ok(solved)
    }

    /// Keeps one term of each sequence; the place after it.
    fn step(&mut self, place: &Place, next: Vec<Vec<Value>>) -> Result<Place, Unknown> {
        let until = self.known.simplify(&place.from.add(&Value::one())?);
        for (pieces, start) in self.pieces.iter_mut().zip(&place.starts) {
            let first = start.first().cloned().unwrap_or_else(Value::zero);
            pieces.push(Piece { from: place.from.clone(), until: Some(until.clone()), form: first });
        }
        Ok(Place { from: until, starts: next })
    }

    /// A reason that names an index, where it is counted from the place.
    fn counted_from(&self, place: &Place, unknown: Unknown) -> Unknown {
        let index = &self.recurrence.index;
        let mut words = unknown.reason.split(|one: char| !one.is_alphanumeric() && one != '_');
        if unknown.open.is_some() || place.from.is_zero() || !words.any(|word| word == index.as_str()) {
            return unknown;
        }
        Unknown::because(format!(
            "from {index} = {} on, with {index} counted from there: {}",
            place.from, unknown.reason
        ))
    }

    /// How many steps all guards hold, and the one that fails then; `None` if they hold for ever.
    fn length(&mut self, solved: &Solved, guards: &[Guard], from: &Value) -> Result<Failing, Unknown> {
        let mut least: Failing = None;
        for guard in guards {
            // It holds where the piece begins.
            let wanted = (guard.relation.negated(), &guard.value, &Value::zero());
            match reach(solved.recurrence(), Some(solved), wanted, &self.known, self.stop) {
                Reach::Never(_) => {}
                Reach::Unknown(unknown) => return Err(self.until_when(guard, from, unknown)),
                Reach::At(at, conditions) => {
                    fails_at(&mut least, guard, (at, conditions), &mut self.known, &mut self.conditions)?;
                }
            }
        }
        Ok(least)
    }

    /// It is not known how long a guard holds.
    fn until_when(&self, guard: &Guard, from: &Value, unknown: Unknown) -> Unknown {
        let index = &self.recurrence.index;
        // What would have to be known of parameters says it all.
        let own = Value::variable(index).sub(from).and_then(|place| guard.value.with(index, &place));
        match own {
            Ok(own) if !unknown.reason.starts_with("it must be known") => {
                let relation = guard.relation.symbol();
                Unknown::because(format!("it is not known how long {own} {relation} 0 holds from {index} = {from} on"))
            }
            _ => unknown,
        }
    }

    /// Keeps the forms for so many steps; the place where the next ones begin.
    fn go_on(&mut self, solved: &Solved, place: &Place, length: &Value, failed: &Guard) -> Result<Place, Unknown> {
        let index = &self.recurrence.index;
        // All guards hold where the piece begins.
        self.known.assume(Relation::Gte, length, &Value::one());
        let mut starts = Vec::new();
        for (own, form) in solved.forms().iter().enumerate() {
            let pieces = as_pieces(form, index).ok_or_else(|| self.no_value(own))?;
            let whole = Closed { variable: index.clone(), pieces, conditions: Vec::new() };
            let mut start = Vec::new();
            for offset in 0..self.recurrence.sequences[own].start.len() {
                let at = length.add(&Value::integer(i64::try_from(offset).unwrap_or(i64::MAX)))?;
                let term = whole.at(index, &at, &self.known).ok_or_else(|| self.no_value(own))?;
                start.push(self.known.simplify(&term));
            }
            starts.push(start);
            let kept = up_to(whole.pieces, length, &self.known).ok_or_else(|| self.no_value(own))?;
            self.pieces[own].extend(later(kept, index, &place.from)?);
        }
        let terms = self.recurrence.terms();
        let mut values: BTreeMap<_, _> =
            terms.iter().map(|(name, own, offset)| (name.clone(), starts[*own][*offset].clone())).collect();
        values.insert(index.clone(), length.clone());
        self.known.assume(failed.relation.negated(), &failed.value.substitute(&values)?, &Value::zero());
        Ok(Place { from: self.known.simplify(&place.from.add(length)?), starts })
    }

    fn no_value(&self, own: usize) -> Unknown {
        let recurrence = self.recurrence;
        Unknown::because(format!("the form of {} is no value in {}", recurrence.sequences[own].name, recurrence.index))
    }

    /// All forms, of which these are the last.
    fn found(&mut self, solved: &Solved, place: &Place) -> Result<Vec<Found>, Unknown> {
        let index = &self.recurrence.index;
        let mut all = Vec::new();
        let after_others = self.after_all(solved, place);
        let last: Option<Vec<_>> = solved.forms().iter().map(|form| as_pieces(form, index)).collect();
        if let Some(last) = last {
            for (own, last) in self.pieces.iter_mut().zip(last) {
                own.extend(later(last, index, &place.from)?);
            }
            let joined: Vec<Vec<Piece>> = self.pieces.iter().map(|pieces| joined(pieces, index, &self.known)).collect();
            if let Some(listed) = joined.iter().map(|pieces| listed(pieces)).collect::<Option<Vec<_>>>() {
                all.push(listed);
            }
            let pieces = std::mem::take(&mut self.pieces);
            all.extend([joined, pieces].map(|all| all.into_iter().map(as_form).collect()));
        }
        all.extend(after_others);
        if all.is_empty() {
            let none = solved.forms().iter().position(|form| as_pieces(form, index).is_none());
            return Err(self.no_value(none.unwrap_or_default()));
        }
        Ok(all.into_iter().map(|forms| (forms, self.conditions.clone())).collect())
    }

    /// All terms up to a place, and these forms from there on.
    fn after_all(&self, solved: &Solved, place: &Place) -> Option<Vec<Form>> {
        let since = place.from.as_rational().filter(|from| from.is_integer() && *from <= whole(MOST_LISTED))?;
        let count = usize::try_from(since.to_integer()).ok()?;
        let terms = self.recurrence.iterate(count).ok()?;
        if solved.forms().iter().any(|form| matches!(form, Form::Product(..) | Form::Nested(_))) {
            return None;
        }
        let turns = solved.forms().iter().map(|form| if let Form::Turns(forms) = form { forms.len() } else { 1 });
        if turns.max().is_none_or(|turns| !count.is_multiple_of(turns)) {
            return None;
        }
        let pairs = solved.forms().iter().zip(&terms);
        let index = &self.recurrence.index;
        pairs.map(|(form, terms)| Some(trimmed(after(form.clone(), terms, index)?, index))).collect()
    }
}

fn whole(number: i64) -> num_rational::BigRational {
    num_rational::BigRational::from_integer(number.into())
}

fn as_form(pieces: Vec<Piece>) -> Form {
    match pieces.as_slice() {
        [only] => Form::Value(Vec::new(), only.form.clone()),
        _ => Form::Pieces(pieces),
    }
}

/// Pieces of one term each, and the last, as a list of these terms.
fn listed(pieces: &[Piece]) -> Option<Form> {
    let (last, first) = pieces.split_last()?;
    let single = |(place, piece): (i64, &Piece)| {
        let until = piece.until.as_ref() == Some(&Value::integer(place + 1));
        (piece.from == Value::integer(place) && until).then(|| piece.form.clone())
    };
    Some(Form::Value((0..).zip(first).map(single).collect::<Option<_>>()?, last.form.clone()))
}
