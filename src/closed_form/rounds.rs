//! Forms that go round for ever: a value in `n-m*floor((n-s)/m)` is the same again after m indices. So what holds of its
//! first m indices, and of the step from the last of them to the first, holds of all.

use std::collections::BTreeMap;

use super::cells::Cell;
use super::check::{Induction, failed};
use super::pieces::same_settled;
use super::{Piece, Unchecked};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The first round of a form that holds from an index on: the index after it, and the form in it, where no integer part of
/// the index stands. None where the form is not known to go round.
///
/// With q for the number of rounds before it, the index is `n+m*q` with one n of the first round, and the integer part
/// `floor((n+m*q-s)/m)` is `q` and what it is there: if q then stands in the form no more, all rounds are alike.
pub(crate) fn first_round(form: &Value, index: &Name, from: &Value, known: &Assumptions) -> Option<(Value, Value)> {
    let part = integer_part(form, index)?;
    let Atom::Floor(inner) = &part else { return None };
    let (factor, _) = inner.linear_in(index)?;
    let length = known.simplify(&Value::one().div(&factor).ok()?);
    let one = Value::one();
    let whole = !length.mentions(index) && known.is_natural(&length.sub(&one).ok()?) == Some(true);
    let before = inner.with(index, from).ok()?.as_rational().filter(|before| before.is_integer() && whole)?;
    let rounds = Name::new("[rounds]");
    let number = Value::variable(&rounds);
    let image = number.add(&Value::rational(before)).ok()?;
    let apart = form.replace(&mut |atom| (*atom == part).then(|| image.clone())).ok()?;
    let moved = Value::variable(index).add(&length.mul(&number).ok()?).ok()?;
    let first = apart.with(index, &moved).ok()?;
    (!first.mentions(&rounds)).then(|| Some((from.add(&length).ok()?, first))).flatten()
}

/// What a form is before an integer part of the index in it grows for the first time, and the index at which that does.
///
/// From an index on at which it is b, `floor(a*n+c)` with a above 0 stays b as long as `a*n+c` is less than `b+1`.
pub(crate) fn first_lap(form: &Value, index: &Name, from: &Value, known: &Assumptions) -> Option<(Value, Value)> {
    let part = integer_part(form, index)?;
    let Atom::Floor(inner) = &part else { return None };
    let (slope, rest) = inner.linear_in(index)?;
    if known.decide(Relation::Gtr, &slope, &Value::zero()) != Some(true) {
        return None;
    }
    let before = known.simplify(&inner.with(index, from).and_then(|inner| inner.floor()).ok()?);
    let before = Value::rational(before.as_rational()?);
    let until = before.add(&Value::one()).and_then(|next| next.sub(&rest)?.div(&slope)?.ceiling()).ok()?;
    let until = known.simplify(&until);
    let later = known.is_natural(&until.sub(from).ok()?.sub(&Value::one()).ok()?) == Some(true);
    let lap = form.replace(&mut |atom| (*atom == part).then(|| before.clone())).ok()?;
    later.then_some((until, lap))
}

/// An integer part of the index in a value, at any depth.
fn integer_part(value: &Value, index: &Name) -> Option<Atom> {
    let mut found = None;
    let look = value.replace(&mut |atom| {
        if matches!(atom, Atom::Floor(_)) && atom.mentions(index) {
            found.get_or_insert_with(|| atom.clone());
        }
        None
    });
    look.ok().and(found)
}

/// The pieces of a form, of which the last is its first round where it goes round, or what it is before an integer part of
/// the index grows; the rest of it follows as one more.
pub(crate) fn with_first_round(pieces: Vec<Piece>, index: &Name, known: &Assumptions) -> Vec<Piece> {
    let round = pieces.last().filter(|last| last.until.is_none());
    let first = round.and_then(|last| {
        first_round(&last.form, index, &last.from, known).or_else(|| first_lap(&last.form, index, &last.from, known))
    });
    let Some((until, form)) = first else { return pieces };
    let mut all = pieces;
    let Some(last) = all.pop() else { return all };
    let first = Piece { from: last.from.clone(), until: Some(until.clone()), form };
    all.extend(by_place(first, index, known));
    all.push(Piece { from: until, ..last });
    all
}

/// A piece in whose form the index is compared with places within it, cut there.
pub(crate) fn by_place(piece: Piece, index: &Name, known: &Assumptions) -> Vec<Piece> {
    let (mut rest, mut all) = (piece, Vec::new());
    while let Some((before, after)) = cut(&rest, index, known).filter(|_| all.len() < MOST_PLACES) {
        all.push(before);
        rest = after;
    }
    all.push(rest);
    all
}

/// The most places at which a piece is cut.
const MOST_PLACES: usize = 4;

/// A piece before and after the first place with which its form compares the index, `if n < u then … else …`.
fn cut(piece: &Piece, index: &Name, known: &Assumptions) -> Option<(Piece, Piece)> {
    let places = piece.form.atoms().into_iter().filter_map(|atom| {
        let Atom::Positive(inner) = &atom else { return None };
        let (slope, rest) = inner.linear_in(index)?;
        let falls = known.decide(Relation::Lss, &slope, &Value::zero()) == Some(true);
        let place = known.simplify(&rest.div(&slope.neg().ok()?).ok()?);
        let inside = known.is_natural(&place.sub(&piece.from).ok()?.sub(&Value::one()).ok()?) == Some(true)
            && known.decide(Relation::Lss, &place, piece.until.as_ref()?) == Some(true);
        (falls && inside).then_some((atom, place))
    });
    let sooner = |one: (Atom, Value), other: (Atom, Value)| {
        if known.decide(Relation::Lss, &other.1, &one.1) == Some(true) { other } else { one }
    };
    let (atom, place) = places.reduce(sooner)?;
    let with = |number: i64| piece.form.replace(&mut |one| (*one == atom).then(|| Value::integer(number))).ok();
    let before = Piece { from: piece.from.clone(), until: Some(place.clone()), form: with(1)? };
    Some((before, Piece { from: place, until: piece.until.clone(), form: with(0)? }))
}

impl Induction<'_> {
    /// The first rounds of the forms of a cell without an end, where all go round together and what is next depends on the
    /// terms alone.
    pub(super) fn rounds_of(&self, cell: &Cell<'_>) -> Option<(Value, Vec<Value>)> {
        let (recurrence, known) = (self.recurrence, self.defined.known());
        let plain = |next: &Value, order: usize| order == 1 && !next.mentions(&recurrence.index);
        if cell.until.is_some()
            || !recurrence.sequences.iter().all(|sequence| plain(&sequence.next, sequence.start.len()))
        {
            return None;
        }
        let mut end: Option<Value> = None;
        let mut first = Vec::new();
        for form in &cell.forms {
            if !form.mentions(&recurrence.index) {
                first.push((*form).clone());
                continue;
            }
            let (until, form) = first_round(form, &recurrence.index, &cell.from, known)?;
            if end.as_ref().is_some_and(|end| *end != until) {
                return None;
            }
            (end, _) = (Some(until), first.push(form));
        }
        Some((end?, first))
    }

    /// The steps within one round, and the step from its last index to its first one.
    pub(super) fn one_round(&self, from: &Value, (until, forms): &(Value, Vec<Value>)) -> Result<(), Unchecked> {
        let (recurrence, known) = (self.recurrence, self.defined.known());
        let last = until.sub(&Value::one())?;
        let cell = Cell { from: from.clone(), until: Some(until.clone()), forms: forms.iter().collect() };
        if known.decide(Relation::Lte, &last, from) != Some(true) {
            self.inside(&cell, Some(&last))?;
        }
        let mut images = BTreeMap::new();
        for (name, place, _) in recurrence.terms() {
            images.insert(name, forms[place].with(&recurrence.index, &last)?);
        }
        for (place, sequence) in recurrence.sequences.iter().enumerate() {
            let next = self.divided(sequence.next.clone(), &images, known)?;
            let first = forms[place].with(&recurrence.index, from)?;
            if !same_settled(&next.substitute(&images)?, &first, known)? {
                return Err(failed("it is not known that a round ends where it began"));
            }
        }
        Ok(())
    }
}
