//! First indices of sequences whose forms are given in turn, class by class: of the indices `M*k + c` with one c the form
//! is an ordinary one in k.

use std::collections::BTreeMap;

use super::exact::by_any_shape;
use super::jointly::{Sides, of_alternatives};
use super::reach::{Wanted, asks_of_parameters};
use super::{Closed, Goal, Reach, Unknown, by_shape};
use crate::assumption::Assumptions;
use crate::closed_form::{Cell, Form, Piece, Solved, cells_or_none, in_class, pieces_in_class, remainders};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{Tail, tail, tail_of_all};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The most classes of which each may be told by itself.
const MOST_OPEN: usize = 6;

/// A comparison of terms whose forms come in turn.
pub(super) struct Classes<'a> {
    solved: &'a Solved,
    wanted: Wanted<'a>,
    /// The sequences that it reads: the variable of the term, with the place.
    used: Vec<(Name, usize)>,
    /// After how many indices the forms are the same again.
    count: usize,
    /// Whether they are no forms that come in turn, but powers of a negative number.
    alternating: bool,
}

impl<'a> Classes<'a> {
    /// The classes of a comparison; nothing if no form comes in turn.
    pub(super) fn of(solved: &'a Solved, wanted: Wanted<'a>) -> Option<Classes<'a>> {
        let used = used(solved, wanted);
        let mut counts = used.iter().filter_map(|(_, place)| match &solved.forms()[*place] {
            Form::Turns(forms) => Some(forms.len()),
            _ => None,
        });
        let count = counts.next().filter(|count| *count > 0)?;
        counts.all(|other| other == count).then_some(Classes { solved, wanted, used, count, alternating: false })
    }

    /// The even and the odd indices, where powers of a negative number are in the forms.
    pub(super) fn even_and_odd(solved: &'a Solved, wanted: Wanted<'a>) -> Option<Classes<'a>> {
        let (used, index) = (used(solved, wanted), &solved.recurrence().index);
        let alternating = used.iter().any(|(_, place)| solved.forms()[*place].alternates(index));
        alternating.then_some(Classes { solved, wanted, used, count: 2, alternating })
    }

    /// The classes of as many indices as what is compared has by remainders of the index: `mod(n,4) = 0 and x(n) >= 10`.
    pub(super) fn by_remainders(solved: &'a Solved, wanted: Wanted<'a>) -> Option<Classes<'a>> {
        let (used, index) = (used(solved, wanted), &solved.recurrence().index);
        let count = remainders([wanted.1, wanted.2], index).and_then(|count| usize::try_from(count).ok())?;
        (count > 1).then_some(Classes { solved, wanted, used, count, alternating: false })
    }

    /// The first index, where each class has a first one that is known, or none.
    pub(super) fn first(&self, known: &Assumptions) -> Option<Reach> {
        let index = &self.solved.recurrence().index;
        let mut natural = known.clone();
        natural.assume_natural(index);
        let mut best: Option<Value> = None;
        let mut reasons: Vec<String> = Vec::new();
        let each = (0..self.count).map(|class| self.in_class(class, &natural)).collect::<Option<Vec<_>>>()?;
        let alone = each.iter().filter(|found| !matches!(found, Reach::Never(_))).count() == 1;
        let mut needed = Vec::new();
        for (class, found) in each.into_iter().enumerate() {
            match found {
                // The numbers in a reason are those of a difference, and its index counts the turns.
                Reach::Never(why) => reasons.push(why.split(": ").next().unwrap_or_default().to_string()),
                Reach::At(round, conditions) if conditions.is_empty() || alone => {
                    needed = conditions;
                    let at = round.mul(&self.number(self.count)?).ok()?.add(&self.place(class)?).ok()?;
                    best = Some(match &best {
                        None => at,
                        Some(other) => match known.decide(Relation::Lss, &at, other) {
                            Some(true) => at,
                            Some(false) => other.clone(),
                            None => match self.open_at_first(known) {
                                Some(open) => return Some(open),
                                None => sooner(&at, other)?,
                            },
                        },
                    });
                }
                // That of one turn is no first index of all.
                Reach::Unknown(why) if self.alternating && !why.has_no_value() => return Some(Reach::Unknown(why)),
                _ => return None,
            }
        }
        reasons.sort();
        reasons.dedup();
        Some(match best {
            Some(at) => Reach::At(at, needed),
            None if self.alternating => Reach::Never(format!("at even n and at odd n: {}", reasons.join("; "))),
            None => Reach::Never(format!("in each of the {} turns: {}", self.count, reasons.join("; "))),
        })
    }

    /// What would have to be known of parameters in the first of few classes in which it is open.
    pub(super) fn open(&self, known: &Assumptions) -> Option<Unknown> {
        let index = &self.solved.recurrence().index;
        let mut natural = known.clone();
        natural.assume_natural(index);
        let open = |class: usize| match self.in_class(class, &natural)? {
            Reach::Unknown(why) => why.open.is_some().then_some(why),
            _ => None,
        };
        if self.count > MOST_OPEN {
            return None;
        }
        (0..self.count).find_map(open).filter(|why| asks_of_parameters(why, index))
    }

    /// What would have to be known at the first index, if it is not: the lesser of several indices is written as such where
    /// none of them is the first.
    fn open_at_first(&self, known: &Assumptions) -> Option<Reach> {
        let (recurrence, (relation, left, right)) = (self.solved.recurrence(), self.wanted);
        let mut images: BTreeMap<Name, Value> =
            BTreeMap::from([(recurrence.index.clone(), Value::integer(recurrence.from))]);
        for (name, place) in &self.used {
            images.insert(name.clone(), recurrence.sequences.get(*place)?.start.first()?.clone());
        }
        let [left, right] = [left, right].map(|side| side.substitute(&images).ok());
        let (left, right) = (left?, right?);
        known.decide(relation, &left, &right).is_none().then(|| Reach::undecided(relation, &left, &right))
    }

    /// From which index on it holds no more, where that is so in each class.
    pub(super) fn tail(&self) -> Tail {
        let mut latest = (0, String::new());
        let count = self.count as u64;
        for class in 0..self.count {
            let Some((sum, early)) = self.difference(class) else {
                return Tail::Unknown("no bound of its later terms is known".to_string());
            };
            match tail(&sum, self.wanted.0, early) {
                Tail::Never(until, reason) => {
                    let at = self.solved.recurrence().from.unsigned_abs() + until * count + class as u64;
                    if at >= latest.0 {
                        latest = (at, reason);
                    }
                }
                unknown => return unknown,
            }
        }
        Tail::Never(latest.0, format!("so it is in each of the {count} turns: {}", latest.1))
    }

    fn number(&self, number: usize) -> Option<Value> {
        i64::try_from(number).ok().map(Value::integer)
    }

    /// The index of the first term of a class.
    fn place(&self, class: usize) -> Option<Value> {
        Some(Value::integer(self.solved.recurrence().from.checked_add(i64::try_from(class).ok()?)?))
    }

    /// A value in the index, at the indices of a class.
    fn at_class(&self, value: &Value, class: usize) -> Option<Value> {
        let (count, from) = (i64::try_from(self.count).ok()?, self.solved.recurrence().from);
        in_class(value, &self.solved.recurrence().index, count, from.checked_add(i64::try_from(class).ok()?)?).ok()
    }

    /// The first terms of a sequence in a class, and its form for all later ones; none for one that is a sum over roots.
    fn form(&self, place: usize, class: usize) -> Option<(Vec<Value>, Option<Value>, Option<ExponentialPolynomial>)> {
        let index = &self.solved.recurrence().index;
        match &self.solved.forms()[place] {
            Form::Turns(forms) => match forms.get(class)? {
                Form::Value(early, value) => {
                    Some((early.clone(), Some(value.clone()), ExponentialPolynomial::of(value, index)))
                }
                Form::Sum(early, sum) => Some((early.clone(), sum.value(index), Some(sum.clone()))),
                _ => None,
            },
            form => {
                let value = self.at_class(&form.value(index)?, class)?;
                let sum = ExponentialPolynomial::of(&value, index);
                Some((Vec::new(), Some(value), sum))
            }
        }
    }

    /// The pieces of a sequence in a class.
    fn pieces(&self, place: usize, class: usize) -> Option<Vec<Piece>> {
        let recurrence = self.solved.recurrence();
        if let Form::Pieces(pieces) = &self.solved.forms()[place] {
            let offset = recurrence.from.checked_add(i64::try_from(class).ok()?)?;
            return pieces_in_class(pieces, &recurrence.index, i64::try_from(self.count).ok()?, offset).ok();
        }
        let (early, value, _) = self.form(place, class)?;
        Form::Value(early, value?).by_pieces(&recurrence.index, 0)
    }

    /// The first round in which a class has it.
    fn in_class(&self, class: usize, natural: &Assumptions) -> Option<Reach> {
        let index = &self.solved.recurrence().index;
        let (relation, left, right) = self.wanted;
        let (left, right) = (self.at_class(left, class)?, self.at_class(right, class)?);
        let mut open = None;
        if let [(name, place)] = self.used.as_slice()
            && !left.mentions(index)
            && !right.mentions(index)
        {
            let pieces = self.pieces(*place, class)?;
            let closed = Closed { variable: name.clone(), pieces, conditions: Vec::new() };
            match by_shape(&closed, index, &Goal::Holds(relation, left.clone(), right.clone()), natural) {
                Reach::Unknown(why) => open = Some(why),
                found => return Some(found),
            }
        }
        let told = self.difference_in_class((relation, &left.sub(&right).ok()?), class, natural);
        match (told, open) {
            (Some(Reach::Unknown(told)), Some(why)) if why.open.is_none() && told.open.is_some() => {
                Some(Reach::Unknown(told))
            }
            (None | Some(Reach::Unknown(_)), Some(why)) => Some(Reach::Unknown(why)),
            (told, _) => told,
        }
    }

    /// The first round in which a difference compares so with 0, by its own shape in a class, or by its parts.
    fn difference_in_class(
        &self,
        (relation, difference): (Relation, &Value),
        class: usize,
        natural: &Assumptions,
    ) -> Option<Reach> {
        let index = &self.solved.recurrence().index;
        let own = self.used.iter().map(|(_, place)| self.pieces(*place, class)).collect::<Option<Vec<_>>>()?;
        let pieces = |value: &Value| {
            if self.used.is_empty() {
                return Some(vec![Piece { from: Value::zero(), until: None, form: value.clone() }]);
            }
            let cell = |cell: Cell<'_>| {
                let names = self.used.iter().map(|(name, _)| name.clone());
                let images = names.zip(cell.forms.iter().map(|form| (*form).clone())).collect();
                Some(Piece { from: cell.from, until: cell.until, form: value.substitute(&images).ok()? })
            };
            cells_or_none(&own, Value::zero(), natural).ok()?.into_iter().map(cell).collect::<Option<Vec<_>>>()
        };
        let first = |(relation, left, right): Wanted<'_>| {
            let all = left.sub(right).ok().and_then(|difference| pieces(&difference));
            let shaped = |pieces| by_any_shape(pieces, index, relation, natural);
            all.and_then(shaped).unwrap_or_else(|| Reach::unknown("it has no shape in each of its turns"))
        };
        let found = first((relation, difference, &Value::zero()));
        let Reach::Unknown(_) = &found else { return Some(found) };
        let used = |value: &Value| self.used.iter().any(|(name, _)| value.mentions(name));
        let moving = |value: &Value| value.mentions(index) || used(value);
        let sides = Sides { index, moving: &moving, pieces: &pieces, first: &first };
        Some(of_alternatives((relation, difference), &sides, natural).unwrap_or(found))
    }

    /// The difference of both sides in a class, and after how many rounds it is that.
    fn difference(&self, class: usize) -> Option<(ExponentialPolynomial, u64)> {
        let (_, left, right) = self.wanted;
        let mut rest = self.at_class(&left.sub(right).ok()?, class)?;
        let mut sum = ExponentialPolynomial::zero();
        let mut early = 0;
        for (name, place) in &self.used {
            let (factor, constant) = rest.linear_in(name)?;
            factor.as_rational()?;
            let (first, _, own) = self.form(*place, class)?;
            early = early.max(first.len() as u64);
            sum = sum.plus(&own?.scale(&factor).ok()?).ok()?;
            rest = constant;
        }
        Some((sum.plus(&ExponentialPolynomial::of(&rest, &self.solved.recurrence().index)?).ok()?, early))
    }
}

/// From which index on not all values compare so with 0, of terms whose forms come in turn: where that is so in each class.
pub(super) fn late_in_classes(solved: &Solved, values: &[Value], relation: Relation) -> Option<Tail> {
    let zero = Value::zero();
    let turns = |form: &Form| if let Form::Turns(forms) = form { Some(forms.len()) } else { None };
    let count = solved.forms().iter().find_map(turns).filter(|count| *count > 0)?;
    let mut latest = (0, String::new());
    for class in 0..count {
        let (mut sums, mut from) = (Vec::new(), 0);
        for value in values {
            let wanted = (relation, value, &zero);
            let used = used(solved, wanted);
            let (sum, early) = Classes { solved, wanted, used, count, alternating: false }.difference(class)?;
            sums.push(sum);
            from = from.max(early);
        }
        let Tail::Never(until, reason) = tail_of_all(&sums, relation, from) else { return None };
        let at = solved.recurrence().from.unsigned_abs() + until * count as u64 + class as u64;
        if at >= latest.0 {
            latest = (at, reason);
        }
    }
    Some(Tail::Never(latest.0, format!("so it is in each of the {count} turns: {}", latest.1)))
}

/// The sequences that a comparison reads: the variable of the term, with the place.
fn used(solved: &Solved, (_, left, right): Wanted<'_>) -> Vec<(Name, usize)> {
    let terms = solved.recurrence().terms().into_iter();
    let read = terms.filter(|(name, _, offset)| *offset == 0 && (left.mentions(name) || right.mentions(name)));
    read.map(|(name, place, _)| (name, place)).collect()
}

/// The lesser of two indices.
fn sooner(one: &Value, other: &Value) -> Option<Value> {
    Value::maximum(&[one.neg().ok()?, other.neg().ok()?]).ok()?.neg().ok()
}
