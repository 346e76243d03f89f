//! Recurrences with conditions and maxima that depend on the index itself: between the indices at which one of them changes
//! the equation knows nothing of them, and has a form of its own. That each holds in its range is for the induction to show.

use std::collections::BTreeSet;

use num_traits::{Signed, ToPrimitive};

use super::from_zero::{counted_from, later};
use super::sequences::{Found, solve_until};
use super::{Closed, Comparison};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Layer, Nested, Piece, Recurrence, Sequence, layer, product};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most indices at which something changes.
const MOST_CHANGES: usize = 40;
/// The furthest of them where all earlier terms are listed.
const MOST_LISTED: i64 = 100;
/// Up to this length a piece is joined to one that gives the same terms.
const MOST_JOINED: i64 = 3;
/// The indices that are tried where a difference is not linear.
const MOST_TRIED: i64 = 100;

/// Forms of a recurrence that begins at 0, the shortest first; none if no condition of it depends on the index alone, or a
/// range has no form.
pub(super) fn in_ranges(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Vec<Found> {
    let Some((changes, conditions)) = changes(recurrence, known) else { return Vec::new() };
    let mut known = known.clone();
    conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    let with = |more: Vec<Comparison>| conditions.iter().cloned().chain(more).collect();
    if let Some((pieces, more)) = by_pieces(recurrence, &changes, &known, stop) {
        let joined = joined(&pieces, &recurrence.index, &known);
        return [joined, pieces].map(|pieces| (vec![Form::Pieces(pieces)], with(more.clone()))).to_vec();
    }
    listed(recurrence, &changes, &known, stop).map(|(forms, more)| (forms, with(more))).into_iter().collect()
}

/// Pieces of which none goes on as the one before it, as far as that is seen.
pub(super) fn joined(pieces: &[Piece], index: &Name, known: &Assumptions) -> Vec<Piece> {
    let mut all: Vec<Piece> = Vec::new();
    for piece in pieces {
        let Some(last) = all.last_mut() else {
            all.push(piece.clone());
            continue;
        };
        let equal = last.form == piece.form
            || known.decide(Relation::Eq, &last.form, &piece.form) == Some(true)
            || same_at_all(last, &piece.form, index) == Some(true);
        if equal {
            last.form.clone_from(&piece.form);
        } else if same_at_all(piece, &last.form, index) != Some(true) {
            all.push(piece.clone());
            continue;
        }
        last.until.clone_from(&piece.until);
    }
    all
}

/// Whether a form gives all terms of a short piece.
fn same_at_all(piece: &Piece, form: &Value, index: &Name) -> Option<bool> {
    let length = piece.until.as_ref()?.sub(&piece.from).ok()?.as_rational()?.to_integer().to_i64()?;
    if length > MOST_JOINED {
        return None;
    }
    for offset in 0..length {
        let at = piece.from.add(&Value::integer(offset)).ok()?;
        if piece.form.with(index, &at).ok()? != form.with(index, &at).ok()? {
            return Some(false);
        }
    }
    Some(true)
}

/// The indices at which a condition changes, in order, with what must hold for them to lie in this order.
fn changes(recurrence: &Recurrence, known: &Assumptions) -> Option<(Vec<Value>, Vec<Comparison>)> {
    let differences = differences(recurrence).filter(|differences| !differences.is_empty())?;
    let mut known = known.clone();
    let (mut all, mut conditions): (Vec<Value>, Vec<Comparison>) = (Vec::new(), Vec::new());
    for (strict, difference) in &differences {
        for at in turns(*strict, difference, &recurrence.index, &known)? {
            match known.decide(Relation::Gtr, &at, &Value::zero()) {
                Some(true) => {}
                Some(false) => continue,
                None => {
                    let at = above_zero(&at);
                    known.assume(Relation::Gtr, &at, &Value::zero());
                    conditions.push((Relation::Gtr, at, Value::zero()));
                }
            }
            let mut place = 0;
            while place < all.len() && known.decide(Relation::Lss, &all[place], &at)? {
                place += 1;
            }
            if all.get(place) != Some(&at) && all.len() < MOST_CHANGES {
                all.insert(place, at);
            }
        }
    }
    Some((all, conditions))
}

/// All that is compared with 0 in the equations and depends on the index and on no term.
fn differences(recurrence: &Recurrence) -> Option<Differences> {
    let mut differences = Differences::new();
    let reads_index = |sequence: &&Sequence| sequence.next.mentions(&recurrence.index);
    let mut reading = recurrence.sequences.iter().filter(reads_index).peekable();
    if reading.peek().is_some() {
        let terms: BTreeSet<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
        reading.try_for_each(|one| collect(&one.next, &recurrence.index, &terms, &mut differences))?;
    }
    Some(differences)
}

/// What is above 0 just where this is: x for `ceil(x)`.
fn above_zero(at: &Value) -> Value {
    let rounded = at.neg().ok().and_then(|below| {
        let floor = below.atoms().into_iter().find(|atom| atom.value().is_ok_and(|value| value == below))?;
        if let Atom::Floor(inner) = floor { inner.neg().ok() } else { None }
    });
    rounded.unwrap_or_else(|| at.clone())
}

/// What is compared with 0, with whether it matters that 0 itself belongs to one side: in a condition, not in a maximum.
type Differences = BTreeSet<(bool, Value)>;

/// Collects what is compared with 0 where it depends on the index and on no term.
fn collect(value: &Value, index: &Name, terms: &BTreeSet<Name>, found: &mut Differences) -> Option<()> {
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        match &atom {
            Atom::Positive(difference) => {
                let mut inner = Differences::new();
                collect(difference, index, terms, &mut inner)?;
                // The condition holds on either side of what a maximum in it compares, or there.
                for (_, one) in inner {
                    found.insert((true, one.neg().ok()?));
                    found.insert((true, one));
                }
                found.insert((true, difference.clone()));
            }
            Atom::Maximum(elements) => {
                let all: Vec<Value> = elements.iter().cloned().chain([Value::zero()]).collect();
                for (place, one) in all.iter().enumerate() {
                    collect(one, index, terms, found)?;
                    for other in &all[place + 1..] {
                        found.insert((false, one.sub(other).ok()?));
                    }
                }
            }
            Atom::Power(base, exponent) => {
                collect(base, index, terms, found)?;
                collect(exponent, index, terms, found)?;
            }
            Atom::Floor(under) | Atom::Root(under) => collect(under, index, terms, found)?,
            Atom::Apply(..) | Atom::Variable(_) => {}
        }
    }
    found.retain(|(_, one)| one.mentions(index) && one.variables().is_disjoint(terms));
    Some(())
}

/// The indices from which on a difference has another sign than before.
fn turns(strict: bool, difference: &Value, index: &Name, known: &Assumptions) -> Option<Vec<Value>> {
    if let Some((slope, rest)) = difference.linear_in(index) {
        let root = rest.neg().ok()?.div(&slope).ok()?;
        let rises = strict && known.decide(Relation::Gtr, &slope, &Value::zero())?;
        let at = if rises { root.floor().ok()?.add(&Value::one()).ok()? } else { root.ceiling().ok()? };
        let at = known.simplify(&at);
        let natural = known.is_natural(&at) == Some(true) || at.as_rational().is_some();
        return natural.then(|| vec![at]);
    }
    let sign = |at: i64| Some(difference.with(index, &Value::integer(at)).ok()?.as_rational()?.signum());
    let Some(signs) = (0..=MOST_TRIED).map(sign).collect::<Option<Vec<_>>>() else {
        // What stands in it has been collected, too.
        let compares = |atom: &Atom| matches!(atom, Atom::Positive(_) | Atom::Maximum(_)) && atom.mentions(index);
        return difference.atoms().iter().any(compares).then(Vec::new);
    };
    let pairs = (1..).zip(signs.windows(2)).filter(|(_, pair)| pair[0] != pair[1]);
    Some(pairs.map(|(at, _)| Value::integer(at)).collect())
}

/// The recurrence from an index on, counted from there; it holds up to another one.
fn range(
    recurrence: &Recurrence,
    from: &Value,
    length: Option<&Value>,
    starts: Vec<Vec<Value>>,
    known: &Assumptions,
) -> Option<Recurrence> {
    let index = Value::variable(&recurrence.index);
    let mut inside = known.clone();
    inside.assume_natural(&recurrence.index);
    if let Some(length) = length {
        inside.assume(Relation::Lss, &index, length);
    }
    let single = length == Some(&Value::one());
    let image = if single { from.clone() } else { index.add(from).ok()? };
    let mut found = recurrence.clone();
    for (sequence, start) in found.sequences.iter_mut().zip(starts) {
        let next = sequence.next.with(&recurrence.index, &image).ok()?;
        sequence.next = inside.simplify(&next);
        sequence.start = start;
    }
    let mut left = BTreeSet::new();
    let terms = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    for sequence in &found.sequences {
        collect(&sequence.next, &recurrence.index, &terms, &mut left)?;
    }
    left.is_empty().then_some(found)
}

/// A form for each range, of one sequence whose next term depends on the one before it.
fn by_pieces(
    recurrence: &Recurrence,
    changes: &[Value],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<(Vec<Piece>, Vec<Comparison>)> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let [start] = sequence.start.as_slice() else { return None };
    let (index, mut known) = (&recurrence.index, known.clone());
    let (mut pieces, mut conditions) = (Vec::new(), Vec::new());
    let (mut from, mut value) = (Value::zero(), start.clone());
    for place in 0..=changes.len() {
        let end = changes.get(place);
        let length = end.map(|end| end.sub(&from)).transpose().ok()?;
        let own = range(recurrence, &from, length.as_ref(), vec![vec![value.clone()]], &known)?;
        let solved = solve_until(own, &known, stop).ok()?;
        for (relation, left, right) in solved.conditions() {
            known.assume(*relation, left, right);
            conditions.push((*relation, left.clone(), right.clone()));
        }
        let [form] = solved.forms() else { return None };
        let found = as_pieces(form, index)?;
        let (Some(end), Some(length)) = (end, &length) else {
            pieces.extend(later(found, index, &from).ok()?);
            continue;
        };
        let whole = Closed { variable: index.clone(), pieces: found.clone(), conditions: Vec::new() };
        value = known.simplify(&whole.at(index, length, &known)?);
        pieces.extend(later(up_to(found, length, &known)?, index, &from).ok()?);
        from = end.clone();
    }
    Some((pieces, conditions))
}

/// The pieces of a form that begins at 0.
pub(super) fn as_pieces(form: &Form, index: &Name) -> Option<Vec<Piece>> {
    let followed = |early: &[Value], rest: Value| {
        let from = Value::integer(i64::try_from(early.len()).ok()?);
        Some([singles(early), vec![Piece { from, until: None, form: rest }]].concat())
    };
    match form {
        Form::Value(early, value) => followed(early, value.clone()),
        Form::Sum(early, sum) => followed(early, sum.value(index)?),
        Form::Pieces(pieces) => Some(pieces.clone()),
        Form::Product(..) | Form::Nested(_) | Form::Turns(_) => None,
    }
}

/// Pieces as far as this index.
pub(super) fn up_to(pieces: Vec<Piece>, length: &Value, known: &Assumptions) -> Option<Vec<Piece>> {
    let mut kept = Vec::new();
    for mut piece in pieces {
        if !known.decide(Relation::Lss, &piece.from, length)? {
            break;
        }
        let ends = match &piece.until {
            Some(until) => known.decide(Relation::Gte, until, length)?,
            None => true,
        };
        if ends {
            piece.until = Some(length.clone());
        }
        kept.push(piece);
    }
    Some(kept)
}

/// A piece for each of the first terms.
fn singles(early: &[Value]) -> Vec<Piece> {
    let single = |(place, term): (i64, &Value)| {
        let until = Some(Value::integer(place + 1));
        Piece { from: Value::integer(place), until, form: term.clone() }
    };
    (0..).zip(early).map(single).collect()
}

/// All terms up to the last change, and the forms of what is left.
fn listed(recurrence: &Recurrence, changes: &[Value], known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    let mut since = changes.last().map_or(Some(0), |last| last.as_rational()?.to_integer().to_i64())?;
    for _ in 0..2 {
        if since > MOST_LISTED {
            return None;
        }
        let count = usize::try_from(since).ok()?;
        let longest = recurrence.sequences.iter().map(|sequence| sequence.start.len()).max()?;
        let terms = recurrence.iterate(count + longest).ok()?;
        let order = recurrence.sequences.iter().map(|sequence| sequence.start.len());
        let starts = terms.iter().zip(order).map(|(terms, order)| terms[count..count + order].to_vec()).collect();
        let solved = solve_until(range(recurrence, &Value::integer(since), None, starts, known)?, known, stop).ok()?;
        let turns = |form: &Form| if let Form::Turns(forms) = form { forms.len() } else { 1 };
        let turns = i64::try_from(solved.forms().iter().map(turns).max()?).ok()?;
        if since % turns != 0 {
            since += turns - since % turns;
            continue;
        }
        let forms = solved.forms().iter().zip(&terms);
        let forms = forms.map(|(form, terms)| after(form.clone(), &terms[..count], &recurrence.index));
        let forms = forms.map(|form| Some(trimmed(form?, &recurrence.index)));
        return Some((forms.collect::<Option<_>>()?, solved.conditions().to_vec()));
    }
    None
}

/// A form that begins at 0 without the first terms that it gives itself.
pub(super) fn trimmed(form: Form, index: &Name) -> Form {
    let own = |form: &Form, at: usize| match form {
        Form::Value(_, value) => value.with(index, &Value::integer(i64::try_from(at).ok()?)).ok(),
        Form::Sum(_, sum) => sum.at(at as u64).ok(),
        _ => None,
    };
    let fewer = |mut early: Vec<Value>, form: &Form| {
        while early.last().is_some_and(|last| own(form, early.len() - 1).as_ref() == Some(last)) {
            early.pop();
        }
        early
    };
    match form {
        Form::Turns(forms) => Form::Turns(forms.into_iter().map(|form| trimmed(form, index)).collect()),
        Form::Value(early, value) => {
            let form = Form::Value(Vec::new(), value.clone());
            Form::Value(fewer(early, &form), value)
        }
        Form::Sum(early, sum) => {
            let form = Form::Sum(Vec::new(), sum.clone());
            Form::Sum(fewer(early, &form), sum)
        }
        form => form,
    }
}

/// A form of the terms after these.
pub(super) fn after(form: Form, early: &[Value], index: &Name) -> Option<Form> {
    let by = i64::try_from(early.len()).ok()?;
    if let Form::Turns(forms) = form {
        let count = forms.len();
        let own = |(turn, form)| {
            let early: Vec<Value> = early.iter().skip(turn).step_by(count).cloned().collect();
            after(form, &early, index)
        };
        return Some(Form::Turns(forms.into_iter().enumerate().map(own).collect::<Option<_>>()?));
    }
    Some(match counted_from(form, index, by).ok()? {
        Form::Value(first, value) => Form::Value([early, &first].concat(), value),
        Form::Sum(first, sum) => Form::Sum([early, &first].concat(), sum),
        Form::Nested(nested) => Form::Nested(Nested { early: [early, &nested.early].concat(), ..nested }),
        Form::Product(ratio, value) => {
            let value = value.with(&product(), &Value::variable(&layer(0))).ok()?;
            Form::Nested(Nested { early: early.to_vec(), layers: vec![Layer::Product(ratio)], value })
        }
        Form::Pieces(pieces) => Form::Pieces([singles(early), pieces].concat()),
        Form::Turns(_) => return None,
    })
}
