//! What is compared, as the closed forms give it: stretch by stretch of indices in which each sequence has one form.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

use super::cells::cells_or_none;
use super::comparing::{Leaf, stands_to_zero, throughout_or_never};
use super::first::Wanted;
use super::pieces::for_all_signs;
use super::whole_parts::{is_not_before, with_known_parts};
use super::{Form, Piece, Recurrence, Solved, with_first_round};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Sort, Value};

/// Maxima and roots that one comparison is taken apart by.
const MOST_SPLITS: usize = 4;
/// Remainders of the index that are looked at one by one.
const MOST_REMAINDERS: i64 = 12;
/// How deep inside one another they are looked for.
const MOST_INSIDE: usize = 6;
/// Orders of indices, at which forms change, that are looked at.
const MOST_ORDERS: usize = 4;

/// A comparison of the terms of a recurrence, with what is known.
#[derive(Clone)]
pub(super) struct Compared<'a> {
    pub(super) recurrence: &'a Recurrence,
    pub(super) wanted: Wanted<'a>,
    pub(super) known: Assumptions,
}

/// What is compared between two indices, as the forms give it there.
pub(super) struct Stretch {
    pub(super) from: Value,
    pub(super) until: Option<Value>,
    pub(super) sides: [Value; 2],
    /// What the sides need to have a value, as they are written: in the sides of the forms it may have cancelled.
    pub(super) needs: BTreeSet<Need>,
}

impl<'a> Compared<'a> {
    /// The same where this is known.
    pub(super) fn knowing(&self, known: Assumptions) -> Compared<'a> {
        Compared { known, ..*self }
    }

    /// What is known of any index and any terms.
    pub(super) fn anywhere(&self) -> Assumptions {
        let names = self.recurrence.terms().into_iter().map(|(name, ..)| name);
        let mut known = names.fold(self.known.clone(), |known, name| known.without_name(&name));
        if self.recurrence.from >= 0 {
            known.assume_natural(&self.recurrence.index);
        }
        known
    }

    /// Whether the comparison holds of these sides, where this much is known, and this tells of what is left.
    pub(super) fn holds(&self, [left, right]: &[Value; 2], known: &Assumptions, otherwise: &Leaf<'_>) -> Option<bool> {
        let relation = self.wanted.0;
        if left.sort() != Sort::Real || right.sort() != Sort::Real {
            return known.decide(relation, left, right);
        }
        let leaf = |value: &Value, relation: Relation| {
            let decided = |value: &Value| known.decide(relation, value, &Value::zero());
            let by_parts = || with_known_parts(value, known).and_then(|value| decided(&value));
            decided(value).or_else(by_parts).or_else(|| otherwise(value, relation))
        };
        let stands = |value: &Value| stands_to_zero(value, relation, &leaf, MOST_SPLITS);
        let difference = left.sub(right).ok()?;
        let as_it_is_here =
            || Some(known.simplify(&difference)).filter(|here| *here != difference).and_then(|here| stands(&here));
        stands(&difference).or_else(|| for_all_signs(&difference, &stands)).or_else(as_it_is_here)
    }

    pub(super) fn sides(&self, images: &BTreeMap<Name, Value>) -> Option<[Value; 2]> {
        Some([self.wanted.1.substitute(images).ok()?, self.wanted.2.substitute(images).ok()?])
    }

    /// What is known, in each order of the indices at which forms change; none where these are too many.
    pub(super) fn orders(&self, solved: &Solved) -> Option<Vec<Assumptions>> {
        let pieces = |form: &Form| if let Form::Pieces(pieces) = form { pieces.clone() } else { Vec::new() };
        let mut ends: Vec<Value> = solved.forms().iter().flat_map(pieces).filter_map(|piece| piece.until).collect();
        ends.sort();
        ends.dedup();
        let mut orders = vec![self.known.clone()];
        for (place, one) in ends.iter().enumerate() {
            for other in ends.iter().skip(place + 1) {
                let apart = |known: Assumptions| {
                    if known.decide(Relation::Lss, one, other).is_some() {
                        return vec![known];
                    }
                    let assumed = |relation: Relation| {
                        let mut known = known.clone();
                        known.assume(relation, one, other);
                        known
                    };
                    vec![assumed(Relation::Lss), assumed(Relation::Gte)]
                };
                orders = orders.into_iter().flat_map(apart).collect();
                if orders.len() > MOST_ORDERS {
                    return None;
                }
            }
        }
        Some(orders)
    }

    /// The sides of the comparison, stretch by stretch of indices in which each sequence that it reads has one form: the first
    /// round of those that go round, or their first lap, stands by itself. A stretch may be of no index, where it is not known that
    /// one form changes before another.
    pub(super) fn stretches(&self, solved: &Solved) -> Option<Vec<Stretch>> {
        let index = &self.recurrence.index;
        let rounds = |pieces: Vec<Piece>| with_first_round(pieces, index, &self.known);
        let forms = self.read().into_iter().map(|name| Some((name, solved.form(name)?.clone())));
        self.stretches_of(forms.collect::<Option<_>>()?, &Value::variable(index), &rounds)
    }

    /// The same of the terms in one turn of forms that come in so many, where the index counts the turns.
    pub(super) fn stretches_in_turn(&self, solved: &Solved, count: i64, place: i64) -> Option<Vec<Stretch>> {
        let index = &self.recurrence.index;
        let own = |name: &'a Name| {
            let form = match solved.form(name)? {
                Form::Turns(forms) => forms.get(usize::try_from(place).ok()?)?.clone(),
                Form::Pieces(pieces) => {
                    let offset = self.recurrence.from.checked_add(place)?;
                    Form::Pieces(super::pieces_in_class(pieces, index, count, offset).ok()?)
                }
                form => {
                    let offset = self.recurrence.from.checked_add(place)?;
                    Form::Value(Vec::new(), super::in_class(&form.value(index)?, index, count, offset).ok()?)
                }
            };
            Some((name, form))
        };
        let first = Value::integer(self.recurrence.from.checked_add(place)?);
        let image = Value::variable(index).mul(&Value::integer(count)).and_then(|turns| turns.add(&first)).ok()?;
        self.stretches_of(self.read().into_iter().map(own).collect::<Option<_>>()?, &image, &|pieces| pieces)
    }

    /// The sequences that the comparison reads.
    fn read(&self) -> Vec<&'a Name> {
        let read = |name: &Name| self.wanted.1.mentions(name) || self.wanted.2.mentions(name);
        let names = self.recurrence.sequences.iter().map(|sequence| &sequence.name);
        names.filter(|name| read(&self.recurrence.term(name, 0))).collect()
    }

    /// The stretches of these forms, with this in place of the index, where `apart` takes their pieces apart.
    fn stretches_of(
        &self,
        forms: Vec<(&Name, Form)>,
        image: &Value,
        apart: &dyn Fn(Vec<Piece>) -> Vec<Piece>,
    ) -> Option<Vec<Stretch>> {
        let index = &self.recurrence.index;
        let plain = image.as_variable() == Some(index);
        let first = if plain { self.recurrence.from } else { 0 };
        let all = forms.iter().map(|(_, form)| Some(apart(form.by_pieces(index, first)?)));
        let all: Vec<Vec<Piece>> = all.collect::<Option<_>>()?;
        let cells = cells_or_none(&all, Value::integer(first), &self.known).ok()?;
        let stretch = |cell: super::Cell<'_>| {
            let images = forms.iter().zip(&cell.forms);
            let mut images: BTreeMap<Name, Value> =
                images.map(|((name, _), form)| (self.recurrence.term(name, 0), (*form).clone())).collect();
            if !plain {
                images.insert(index.clone(), image.clone());
            }
            let (sides, needs) = (self.sides(&images)?, needs_of([self.wanted.1, self.wanted.2], &images)?);
            Some(Stretch { sides, needs, from: cell.from, until: cell.until })
        };
        cells.into_iter().map(stretch).collect()
    }

    /// What is known of an index from the start of a stretch on, before these ends.
    pub(super) fn within<'v>(&self, stretch: &Stretch, ends: impl IntoIterator<Item = &'v Value>) -> Assumptions {
        let mut known = self.known.clone();
        let index = Value::variable(&self.recurrence.index);
        if self.recurrence.from >= 0 {
            known.assume_natural(&self.recurrence.index);
        }
        known.assume(Relation::Gte, &index, &stretch.from);
        ends.into_iter().for_each(|end| known.assume(Relation::Lss, &index, end));
        known
    }

    /// Whether it holds at no index of a stretch, from one on that is written as a number, and before this one.
    pub(super) fn never_within(&self, stretch: &Stretch, from: i64, before: Option<&Value>) -> bool {
        let begins_later = |before: &Value| {
            self.known.decide(Relation::Gte, &stretch.from, before) == Some(true)
                || is_not_before(&stretch.from, before, &self.known)
        };
        if before.is_some_and(begins_later) {
            return true;
        }
        let index = &self.recurrence.index;
        let range = || {
            let last = stretch.until.as_ref().or(before);
            let until = last.map(natural);
            let until = match (until, before.map(natural)) {
                (Some(until), Some(before)) => Some(until?.min(before?)),
                (until, _) => until.map_or(Some(None), |until| until.map(Some))?,
            };
            let start = natural(&stretch.from).filter(|_| self.recurrence.from >= 0)?;
            Some((start.max(u64::try_from(from).ok()?), until))
        };
        let range = range();
        // Of sums of powers, at all indices between two numbers.
        let of_sums = |value: &Value, relation: Relation| {
            let (from, until) = range?;
            let sum = ExponentialPolynomial::of(value, index)?;
            throughout_or_never(&sum, relation, from, until)
        };
        let never = |ends: &[&Value]| {
            let mut known = self.within(stretch, ends.iter().copied());
            if from > self.recurrence.from {
                known.assume(Relation::Gte, &Value::variable(index), &Value::integer(from));
            }
            self.holds(&stretch.sides, &known, &of_sums) == Some(false)
        };
        // Of two ends the one that does not matter may hide what follows from the other.
        match (before, stretch.until.as_ref().filter(|until| Some(*until) != before)) {
            (Some(before), Some(until)) => never(&[before]) || never(&[until]) || never(&[until, before]),
            (one, other) => never(&one.into_iter().chain(other).collect::<Vec<_>>()),
        }
    }
}

impl Compared<'_> {
    /// Whether it holds in none of these stretches, from one index on and before another, as `never` tells of each, where it is
    /// known as well that it does not hold in those before.
    pub(super) fn in_none(
        &self,
        stretches: &[Stretch],
        (from, before): (i64, Option<&Value>),
        never: &dyn Fn(&Compared<'_>, &Stretch) -> bool,
    ) -> bool {
        let mut compared = self.clone();
        for stretch in stretches {
            if !never(&compared, stretch) {
                return false;
            }
            let longer = stretch.longer().filter(|longer| never(&compared, longer));
            compared.learn_the_end(longer.as_ref().unwrap_or(stretch), (from, before));
        }
        true
    }

    /// Learns of a stretch in which it does not hold that it does not at the last indices.
    fn learn_the_end(&mut self, stretch: &Stretch, (from, before): (i64, Option<&Value>)) {
        let (index, [left, right]) = (&self.recurrence.index, &stretch.sides);
        let Some(until) = stretch.symbolic_end().filter(|_| self.recurrence.from >= 0) else { return };
        if left.sort() != Sort::Real || right.sort() != Sort::Real || self.known.is_natural(until) != Some(true) {
            return;
        }
        for back in 1..=LAST {
            let Ok(at) = until.sub(&Value::integer(back)) else { return };
            let known = &self.known;
            let lies = [&stretch.from, &Value::integer(from)]
                .iter()
                .all(|first| known.decide(Relation::Gte, &at, first) == Some(true))
                && before.is_none_or(|before| known.decide(Relation::Lss, &at, before) == Some(true));
            let there = || left.sub(right)?.with(index, &at);
            let there = there().ok().filter(|there| lies && known.gives_meaning(there));
            if let Some(there) = there.map(|there| known.simplify(&there)) {
                self.known.assume(self.wanted.0.negated(), &there, &Value::zero());
            }
        }
    }
}

impl Stretch {
    /// Its end, if that is none that is written as a number.
    fn symbolic_end(&self) -> Option<&Value> {
        self.until.as_ref().filter(|until| until.as_rational().is_none())
    }

    /// One with an end of symbols, and with the first index behind it, as its sides give it there.
    fn longer(&self) -> Option<Stretch> {
        let until = Some(self.symbolic_end()?.add(&Value::one()).ok()?);
        Some(Stretch { until, from: self.from.clone(), sides: self.sides.clone(), needs: self.needs.clone() })
    }
}

/// The last indices of a stretch of which it is learned that it does not hold there.
const LAST: i64 = 2;

impl Compared<'_> {
    /// After how many indices forms that come in turn are the same again; where there is none of these two if powers of a negative
    /// number are in one, or as many as what is compared has by remainders of the index.
    pub(super) fn turns(&self, solved: &Solved) -> Option<i64> {
        let turns = |form: &Form| if let Form::Turns(forms) = form { Some(forms.len()) } else { None };
        let mut counts = solved.forms().iter().filter_map(turns);
        let index = &self.recurrence.index;
        let Some(count) = counts.next() else {
            return match remainders([self.wanted.1, self.wanted.2], index) {
                Some(count) => Some(count),
                None => solved.forms().iter().any(|form| form.alternates(index)).then_some(2),
            };
        };
        let all = count > 0 && counts.all(|other| other == count);
        all.then(|| i64::try_from(count).ok()).flatten()
    }
}

/// After how many indices what is rounded of the index alone, in these values, has gone on by whole numbers: 4 for `mod(n,4)`.
/// None where nothing is, or these are too many.
pub(crate) fn remainders(values: [&Value; 2], index: &Name) -> Option<i64> {
    let mut steps: Vec<BigRational> = Vec::new();
    values.into_iter().for_each(|value| rounded_steps(value, index, MOST_INSIDE, &mut steps));
    let count = steps.iter().fold(BigInt::one(), |all, step| all.lcm(step.denom()));
    count.to_i64().filter(|count| !steps.is_empty() && *count <= MOST_REMAINDERS)
}

/// By how much what is rounded in a value goes on with the index, so deep inside at most.
fn rounded_steps(value: &Value, index: &Name, depth: usize, steps: &mut Vec<BigRational>) {
    let Some(depth) = depth.checked_sub(1).filter(|_| value.mentions(index)) else { return };
    for atom in value.atoms() {
        match &atom {
            Atom::Floor(inner) => {
                let step = inner.linear_in(index).and_then(|(step, _)| step.as_rational());
                match step {
                    Some(step) if !step.is_zero() => steps.push(step),
                    _ => rounded_steps(inner, index, depth, steps),
                }
            }
            Atom::Maximum(elements) => elements.iter().for_each(|one| rounded_steps(one, index, depth, steps)),
            Atom::Positive(inner) => rounded_steps(inner, index, depth, steps),
            _ => {}
        }
    }
}

/// What these values need to have a meaning, with what is put in.
pub(super) fn needs_of<'v>(
    values: impl IntoIterator<Item = &'v Value>,
    images: &BTreeMap<Name, Value>,
) -> Option<BTreeSet<Need>> {
    let each = values.into_iter().map(|value| value.needs_with(images).ok());
    each.collect::<Option<Vec<_>>>().map(|all| all.into_iter().flatten().collect())
}

pub(super) fn natural(value: &Value) -> Option<u64> {
    value.as_rational().filter(|number| number.is_integer())?.to_integer().to_u64()
}
