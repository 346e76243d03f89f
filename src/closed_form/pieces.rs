//! The induction for a form by pieces: within each piece, and from one to the next.

use std::collections::BTreeMap;

use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use super::cells::{Cell, cells};
use super::check::{Induction, failed, whole};
use super::signs::{Signs, settled_by};
use super::since::{on_both_sides, since_the_start};
use super::whole_parts::same_by_whole_parts;
use super::{Form, Piece, Recurrence, Unchecked};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::{ExponentialPolynomial, exponentials};
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value};

impl Induction<'_> {
    pub(super) fn pieces(&mut self) -> Result<(), Unchecked> {
        let all = self.forms.iter().map(|form| self.piecewise(form)).collect::<Result<Vec<_>, _>>()?;
        all.iter().try_for_each(|pieces| self.without_gaps(pieces))?;
        let recurrence = self.recurrence;
        let from = Value::integer(recurrence.from);
        let cells = cells(&all, from.clone(), self.defined.known()).map_err(Unchecked)?;
        for (place, sequence) in recurrence.sequences.iter().enumerate() {
            for (offset, start) in sequence.start.iter().enumerate() {
                let term = self.in_cell(&cells, place, &from.add(&Value::integer(whole(offset)?))?)?;
                if !self.same(&term, start) {
                    return Err(failed("the form does not give the starting value"));
                }
            }
        }
        cells.iter().try_for_each(|cell| self.cell(cell, &cells))
    }

    /// A form as pieces.
    fn piecewise(&self, form: &Form) -> Result<Vec<Piece>, Unchecked> {
        match form {
            Form::Pieces(pieces) => Ok(pieces.clone()),
            form => {
                let form = form.value(&self.recurrence.index).ok_or_else(|| self.unlike())?;
                Ok(vec![Piece { from: Value::integer(self.recurrence.from), until: None, form }])
            }
        }
    }

    /// They begin with the recurrence, each at a whole number and where the one before it ends, and the last has no end.
    fn without_gaps(&self, pieces: &[Piece]) -> Result<(), Unchecked> {
        let known = self.defined.known();
        let first = Value::integer(self.recurrence.from);
        if pieces.first().is_none_or(|piece| piece.from != first) {
            return Err(failed("the form does not give the starting value"));
        }
        for (place, piece) in pieces.iter().enumerate() {
            match (&piece.until, pieces.get(place + 1)) {
                (None, None) => {}
                (Some(until), Some(next)) if *until == next.from => {
                    if !before(&piece.from, until, known) {
                        let reason = format!("it is not known that the piece from {} is not empty", piece.from);
                        return Err(Unchecked(reason));
                    }
                    if known.is_natural(&until.sub(&first)?) != Some(true) {
                        return Err(Unchecked(format!("it is not known that {until} is a whole number")));
                    }
                }
                _ => return Err(failed("the pieces have gaps")),
            }
        }
        Ok(())
    }

    /// The term of a sequence at an index.
    fn in_cell(&self, cells: &[Cell<'_>], place: usize, at: &Value) -> Result<Value, Unchecked> {
        for cell in cells {
            let here = match &cell.until {
                None => Some(true),
                Some(until) if before(at, until, self.defined.known()) => Some(true),
                Some(until) => self.defined.known().decide(Relation::Lss, at, until),
            };
            match here {
                Some(true) => return Ok(cell.forms[place].with(&self.recurrence.index, at)?),
                Some(false) => {}
                None => return Err(Unchecked(format!("it must be known in which piece {at} lies"))),
            }
        }
        Err(failed("there is no such term"))
    }

    /// The step from every index of a cell: where all terms lie in it for all at once, and from its last indices one by one.
    fn cell(&self, cell: &Cell<'_>, cells: &[Cell<'_>]) -> Result<(), Unchecked> {
        let (recurrence, known) = (self.recurrence, self.defined.known());
        let order = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max().unwrap_or(1);
        let order = whole(order)?;
        let last = cell.until.as_ref().map(|until| until.sub(&Value::integer(order))).transpose()?;
        let none = last.as_ref().is_some_and(|last| known.decide(Relation::Lte, last, &cell.from) == Some(true));
        if !none {
            self.inside(cell, last.as_ref())?;
        }
        let Some(until) = &cell.until else { return Ok(()) };
        for back in 1..=order {
            let at = until.sub(&Value::integer(back))?;
            if known.decide(Relation::Lss, &at, &cell.from) != Some(true) {
                self.last_step(&at, cells)?;
            }
        }
        Ok(())
    }

    /// The step from every index of a cell up to one, from which on terms lie beyond it.
    pub(super) fn inside(&self, cell: &Cell<'_>, last: Option<&Value>) -> Result<(), Unchecked> {
        if self.rounds_of(cell).is_some_and(|rounds| self.one_round(&cell.from, &rounds).is_ok()) {
            return Ok(());
        }
        let (index, recurrence) = (&self.recurrence.index, self.recurrence);
        let count = Value::variable(index);
        let mut known = self.defined.known().clone();
        known.assume(Relation::Gte, &count, &cell.from);
        if let Some(last) = last {
            known.assume(Relation::Lss, &count, last);
        }
        let later = |place: usize, offset: usize| -> Result<Value, Unchecked> {
            Ok(cell.forms[place].with(index, &count.add(&Value::integer(whole(offset)?))?)?)
        };
        let mut images = BTreeMap::new();
        for (name, place, offset) in recurrence.terms() {
            images.insert(name, later(place, offset)?);
        }
        for (place, sequence) in recurrence.sequences.iter().enumerate() {
            let [chosen, settled] = self.by_signs(&sequence.next, &images, cell, last)?;
            // What a maximum leaves out must have a value, too, so this is asked before any is left out.
            self.divided(chosen, &images, &known)?;
            let next = self.divided(settled, &images, &known)?;
            let (image, wanted) = (next.substitute(&images)?, later(place, sequence.start.len())?);
            let piece = Piece { from: cell.from.clone(), until: cell.until.clone(), form: cell.forms[place].clone() };
            if !same_throughout(&image, &wanted, &piece, index, &known)? {
                return Err(Unchecked(format!("the step within the piece from {} could not be checked", cell.from)));
            }
        }
        Ok(())
    }

    /// An equation with what its conditions are in a cell, and with what its maxima are, too, where they are signs of
    /// exponential polynomials.
    fn by_signs(
        &self,
        next: &Value,
        images: &BTreeMap<Name, Value>,
        cell: &Cell<'_>,
        last: Option<&Value>,
    ) -> Result<[Value; 2], Unchecked> {
        let natural = |value: &Value| value.as_rational().and_then(|number| number.to_integer().to_u64());
        let (Some(from), Some(until)) = (natural(&cell.from), last.map_or(Some(None), |last| natural(last).map(Some)))
        else {
            return Ok([next.clone(), next.clone()]);
        };
        let sum = |value: &Value| ExponentialPolynomial::of(&value.substitute(images).ok()?, &self.recurrence.index);
        let signs = Signs { sum: &sum, from, until };
        // Only what divides by a term may have no value.
        let divides = self.may_lack_a_value(next);
        let settled = signs.settled(next)?;
        Ok([if divides { signs.chosen(next)? } else { settled.clone() }, settled])
    }

    /// An equation that divides by a term, with what its conditions are where the terms are these; what it divides by is
    /// then known not to be 0.
    pub(super) fn divided(
        &self,
        next: Value,
        images: &BTreeMap<Name, Value>,
        known: &Assumptions,
    ) -> Result<Value, Unchecked> {
        if !self.may_lack_a_value(&next) {
            return Ok(next);
        }
        let zero = Value::zero();
        let holds = |relation, value: &Value| {
            let value = known.simplify(&value.substitute(images).ok()?);
            let decided = |value: &Value| known.decide(relation, &known.simplify(value), &zero);
            decided(&value).or_else(|| for_all_signs(&value, &decided))
        };
        // Maxima stay: what they leave out must have a value, too.
        let next = settled_by(&next, &|_, _| false, &|inner| holds(Relation::Gtr, inner))?;
        for need in next.needs() {
            match &need {
                Need::Nonzero(divisor) if holds(Relation::Neq, divisor) != Some(true) => {
                    return Err(Unchecked(format!("it divides by {divisor}, which may be 0")));
                }
                Need::Nonnegative(inner)
                    if reads(inner, self.recurrence)
                        && !inner.is_sum_of_squares()
                        && holds(Relation::Gte, inner) != Some(true) =>
                {
                    return Err(Unchecked(need.to_string()));
                }
                _ => {}
            }
        }
        Ok(next)
    }

    /// Whether an equation divides by a term, or takes a root of what depends on one or on the index.
    fn may_lack_a_value(&self, next: &Value) -> bool {
        let terms = self.recurrence.terms();
        terms.iter().any(|(name, ..)| divides_by(next, name))
            || next.needs().iter().any(|need| matches!(need, Need::Nonnegative(inner) if reads(inner, self.recurrence)))
    }

    /// The step from one index, between whose terms a piece ends.
    fn last_step(&self, at: &Value, cells: &[Cell<'_>]) -> Result<(), Unchecked> {
        let recurrence = self.recurrence;
        let mut images = BTreeMap::from([(recurrence.index.clone(), at.clone())]);
        let later = |place: usize, offset: usize| -> Result<Value, Unchecked> {
            self.in_cell(cells, place, &at.add(&Value::integer(whole(offset)?))?)
        };
        for (name, place, offset) in recurrence.terms() {
            images.insert(name, later(place, offset)?);
        }
        for (place, sequence) in recurrence.sequences.iter().enumerate() {
            let next = self.divided(sequence.next.clone(), &images, self.defined.known())?;
            let (image, first) = (next.substitute(&images)?, later(place, sequence.start.len())?);
            if !self.same(&image, &first) {
                let next = at.add(&Value::integer(whole(sequence.start.len())?))?;
                return Err(Unchecked(format!("{image} at {next} is not known to be {first}")));
            }
        }
        Ok(())
    }

    /// Whether two values are equal for all indices from one on.
    pub(super) fn same_since(&self, left: &Value, right: &Value, since: i64) -> Result<bool, Unchecked> {
        let (index, from) = (&self.recurrence.index, Value::integer(since));
        let mut known = self.defined.known().clone();
        known.assume(Relation::Gte, &Value::variable(index), &from);
        same_throughout(left, right, &Piece { from, until: None, form: left.clone() }, index, &known)
    }
}

/// Whether a term, or the index, stands in a value.
pub(super) fn reads(value: &Value, recurrence: &Recurrence) -> bool {
    value.mentions(&recurrence.index) || recurrence.terms().iter().any(|(name, ..)| value.mentions(name))
}

/// Whether a value divides by something in which a variable stands.
pub(super) fn divides_by(value: &Value, name: &Name) -> bool {
    value.needs().iter().any(|need| matches!(need, Need::Nonzero(divisor) if divisor.mentions(name)))
}

/// Whether an index is known to lie before another one: `floor(v) + k` is above 0 where v is at least `1 - k`.
fn before(from: &Value, until: &Value, known: &Assumptions) -> bool {
    if known.decide(Relation::Lss, from, until) == Some(true) {
        return true;
    }
    let Ok(length) = until.sub(from) else { return false };
    let inner = length.atoms().into_iter().find_map(|atom| {
        let Atom::Floor(inner) = &atom else { return None };
        let rest = length.sub(&atom.value().ok()?).ok()?.as_rational().filter(|rest| rest.is_integer())?;
        Some((inner.clone(), Value::rational(BigRational::from_integer(1.into()) - rest)))
    });
    inner.is_some_and(|(inner, least)| known.decide(Relation::Gte, &inner, &least) == Some(true))
}

/// Whether two values are equal for all indices of a piece. A power of a number above 1 is known to grow, and
/// `(-1)^n` is looked at as 1 and as -1.
fn same_throughout(
    left: &Value,
    right: &Value,
    piece: &Piece,
    index: &Name,
    known: &Assumptions,
) -> Result<bool, Unchecked> {
    if left == right {
        return Ok(true);
    }
    let mut known = known.clone();
    let mut bases = std::collections::BTreeSet::new();
    collect_bases(left, index, &mut bases);
    collect_bases(right, index, &mut bases);
    for base in bases {
        let power = base.power(&Value::variable(index))?;
        if base.as_rational().is_some_and(|base| base > BigRational::from_integer(1.into())) {
            if let Ok(least) = base.power(&piece.from) {
                known.assume(Relation::Gte, &power, &least);
            }
            if let Some(Ok(most)) = piece.until.as_ref().map(|until| base.power(until)) {
                known.assume(Relation::Lte, &power, &most);
            }
        }
    }
    assume_powers(piece, index, &mut known);
    if same_whatever_the_signs(left, right, &known, MOST_SIGNS)? {
        return Ok(true);
    }
    match since_the_start(&[left, right], piece, index, &mut known) {
        Some([left, right]) => same_whatever_the_signs(&left, &right, &known, MOST_SIGNS),
        None => same_by_whole_parts(left, right, &known),
    }
}

/// The most powers of -1 that are looked at as 1 and as -1.
const MOST_SIGNS: usize = 3;

/// Whether two values are equal with each power of -1 as 1 and as -1.
fn same_whatever_the_signs(left: &Value, right: &Value, known: &Assumptions, more: usize) -> Result<bool, Unchecked> {
    let Some(sign) = sign_in(left).or_else(|| sign_in(right)).filter(|_| more > 0) else {
        return same_settled(left, right, known);
    };
    for side in [1, -1] {
        let (left, right) = (with_sign(left, &sign, side)?, with_sign(right, &sign, side)?);
        if !same_whatever_the_signs(&left, &right, known, more - 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What is decided of a value with each power of -1 as 1 and as -1, if that is the same: what goes back and forth between two
/// places may be known to be at a third one never.
pub(crate) fn for_all_signs(value: &Value, decide: &dyn Fn(&Value) -> Option<bool>) -> Option<bool> {
    fn of_signs(value: &Value, decide: &dyn Fn(&Value) -> Option<bool>, more: usize) -> Option<bool> {
        let Some(sign) = sign_in(value).filter(|_| more > 0) else { return decide(value) };
        let [one, other] =
            [1, -1].map(|side| with_sign(value, &sign, side).ok().and_then(|value| of_signs(&value, decide, more - 1)));
        one.filter(|_| one == other)
    }
    of_signs(value, decide, MOST_SIGNS)
}

/// Of the powers of numbers that a form consists of: those of a number above 1 grow with the index, the others fall.
fn assume_powers(piece: &Piece, index: &Name, known: &mut Assumptions) {
    let one = BigRational::from_integer(1.into());
    for base in exponentials(&piece.form, index).unwrap_or_default().into_keys() {
        let Some(size) = base.as_rational().map(|base| base.abs()).filter(|size| !size.is_zero() && *size != one)
        else {
            continue;
        };
        let base = Value::rational(size.clone());
        let Ok(power) = base.power(&Value::variable(index)) else { continue };
        let (first, last) = if size > one { (Relation::Gte, Relation::Lte) } else { (Relation::Lte, Relation::Gte) };
        if let Ok(bound) = base.power(&piece.from) {
            known.assume(first, &power, &bound);
        }
        if let Some(Ok(bound)) = piece.until.as_ref().map(|until| base.power(until)) {
            known.assume(last, &power, &bound);
        }
    }
}

/// Whether two values are equal, after each maximum and condition has become what it is known to be.
pub(super) fn same_settled(left: &Value, right: &Value, known: &Assumptions) -> Result<bool, Unchecked> {
    same_in_cases(left, right, known, MOST_CASES)
}

/// Maxima and conditions of which it is not known what they are, and which are looked at in either case.
const MOST_CASES: usize = 3;

fn same_in_cases(left: &Value, right: &Value, known: &Assumptions, more: usize) -> Result<bool, Unchecked> {
    let (left, right) = (settled(left, known)?, settled(right, known)?);
    if left == right || known.decide(Relation::Eq, &left, &right) == Some(true) {
        return Ok(true);
    }
    let Some(open) = undecided(&left).or_else(|| undecided(&right)).filter(|_| more > 0) else { return Ok(false) };
    // One of them is the greatest, whatever the values are.
    let zero = Value::zero();
    let cases: Vec<Vec<(Relation, Value, Value)>> = match &open {
        Atom::Maximum(elements) => {
            let all: Vec<&Value> = elements.iter().chain([&zero]).collect();
            let greatest =
                |one: &&Value| all.iter().map(|other| (Relation::Gte, (*one).clone(), (*other).clone())).collect();
            all.iter().map(greatest).collect()
        }
        Atom::Positive(inner) => {
            [Relation::Gtr, Relation::Lte].map(|relation| vec![(relation, inner.clone(), zero.clone())]).into()
        }
        _ => return Ok(false),
    };
    for case in cases {
        let mut here = known.clone();
        case.iter().for_each(|(relation, left, right)| here.assume(*relation, left, right));
        if !here.contradictory() && !same_in_cases(&left, &right, &here, more - 1)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// A maximum or condition that stands in a value, with none inside it.
fn undecided(value: &Value) -> Option<Atom> {
    value.atoms().into_iter().find_map(|atom| match &atom {
        Atom::Maximum(elements) => elements.iter().find_map(undecided).or(Some(atom)),
        Atom::Positive(inner) => undecided(inner).or(Some(atom)),
        _ => None,
    })
}

fn settled(value: &Value, known: &Assumptions) -> Result<Value, Unchecked> {
    let stands = |relation: Relation, value: &Value| {
        known.decide(relation, value, &Value::zero()).or_else(|| on_both_sides(relation, value, known))
    };
    let at_least = |one: &Value, other: &Value| {
        one.sub(other).is_ok_and(|difference| stands(Relation::Gte, &difference) == Some(true))
    };
    Ok(settled_by(value, &at_least, &|inner| stands(Relation::Gtr, inner))?)
}

/// The rational bases of powers with the index as exponent.
fn collect_bases(value: &Value, index: &Name, found: &mut std::collections::BTreeSet<Value>) {
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        match &atom {
            Atom::Power(base, exponent) if exponent.as_variable() == Some(index) => {
                found.insert(base.clone());
            }
            Atom::Maximum(elements) => elements.iter().for_each(|element| collect_bases(element, index, found)),
            Atom::Positive(inner) | Atom::Floor(inner) | Atom::Root(inner) => collect_bases(inner, index, found),
            _ => {}
        }
    }
}

/// A power of -1 in a value, or in its maxima and conditions.
fn sign_in(value: &Value) -> Option<Atom> {
    value.atoms().into_iter().find_map(|atom| match &atom {
        Atom::Maximum(elements) => elements.iter().find_map(sign_in),
        Atom::Positive(inner) | Atom::Root(inner) => sign_in(inner),
        other => other.is_sign().then_some(atom),
    })
}

/// A value with a power of -1 replaced by 1 or -1.
fn with_sign(value: &Value, sign: &Atom, side: i64) -> Result<Value, Unchecked> {
    let mut result = value.clone();
    for atom in value.atoms() {
        let image = match &atom {
            one if one == sign => Value::integer(side),
            Atom::Maximum(elements) => {
                let mut all = vec![Value::zero()];
                for element in elements.iter() {
                    all.push(with_sign(element, sign, side)?);
                }
                Value::maximum(&all)?
            }
            Atom::Positive(inner) => Value::truth(Relation::Gtr, &with_sign(inner, sign, side)?, &Value::zero())?,
            Atom::Root(inner) => with_sign(inner, sign, side)?.sqrt()?,
            _ => continue,
        };
        result = result.with_atom(&atom, &image)?;
    }
    Ok(result)
}
