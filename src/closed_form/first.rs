//! That an index is the first at which terms compare as wanted: there they do, and at no index before it.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::ToPrimitive;

use super::cells::cells;
use super::divisors::{divisors, in_each_sign};
use super::{Comparison, Form, Piece, Recurrence, Solved, Unchecked, with_first_round};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::{stands, throughout};
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Sort, Value};

/// So many terms are compared one by one before the forms are asked, and where these do not tell.
const FEW: i64 = 500;
const MOST: i64 = 20_000;
/// The bits that these may have together, and the longest of them; a part of a term with symbols counts for so many.
const MOST_BITS: u64 = 1 << 24;
const LONGEST: u64 = 1 << 16;
const SYMBOLIC: u64 = 1 << 10;
/// Maxima and roots that one comparison is taken apart by.
const MOST_SPLITS: usize = 4;
/// Orders of indices, at which forms change, that are looked at.
const MOST_ORDERS: usize = 4;

/// A comparison of expressions in the terms of offset 0 and the index, as [`Recurrence::term`] names them.
pub type Wanted<'a> = (Relation, &'a Value, &'a Value);

/// How it was shown that no earlier index is the one that is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Earlier {
    /// There is none.
    None,
    /// The terms were compared one by one, as the recurrence makes them.
    OneByOne,
    /// By the closed forms, for all earlier indices at once.
    Forms,
    /// By the closed forms: what is compared only rises, or only falls, and is not yet there at the index before.
    OneWay,
}

struct Question<'a> {
    recurrence: &'a Recurrence,
    wanted: Wanted<'a>,
    at: &'a Value,
    known: Assumptions,
}

/// Checks that an index is the first at which a comparison holds, under the assumptions and conditions, and those of the
/// forms. Nothing of how it was found is believed.
///
/// # Errors
/// Where that is not shown.
pub fn first(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    wanted: Wanted<'_>,
    (at, conditions): (&Value, &[Comparison]),
    known: &Assumptions,
) -> Result<Earlier, Unchecked> {
    let mut known = solved.map_or(known, Solved::known).without_name(&recurrence.index);
    conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    let divisors = divisors([at, wanted.1, wanted.2], recurrence, &known);
    let check = |known: Assumptions| {
        let mut how = Earlier::None;
        for (at, known) in each_case(at, known) {
            how = how.max(Question { recurrence, wanted, at: &at, known }.answered(solved)?);
        }
        Ok(how)
    };
    in_each_sign(&divisors, known, &check)
}

/// An index that is the greatest of several, in each case of which of them it is.
fn each_case(at: &Value, known: Assumptions) -> Vec<(Value, Assumptions)> {
    let all = || {
        let atom = at.atoms().into_iter().find(|atom| matches!(atom, Atom::Maximum(_)))?;
        let elements = with_zero(&atom)?;
        let mut cases = Vec::new();
        for one in &elements {
            let mut known = known.clone();
            for other in elements.iter().filter(|other| *other != one) {
                known.assume(Relation::Gte, one, other);
            }
            if !known.contradictory() {
                cases.push((at.with_atom(&atom, one).ok()?, known));
            }
        }
        Some(cases)
    };
    all().unwrap_or_else(|| vec![(at.clone(), known.clone())])
}

/// What a maximum is the greatest of.
fn with_zero(atom: &Atom) -> Option<Vec<Value>> {
    let Atom::Maximum(elements) = atom else { return None };
    Some(std::iter::once(Value::zero()).chain(elements.iter().cloned()).collect())
}

/// Whether a value stands in a relation to 0, given what tells of parts of it: what is the greatest of several, or a root, is
/// taken apart.
fn compared(value: &Value, relation: Relation, leaf: &Leaf<'_>, splits: usize) -> Option<bool> {
    if let Some(told) = leaf(value, relation) {
        return Some(told);
    }
    let splits = splits.checked_sub(1)?;
    let part = Name::new("[part]");
    value.atoms().into_iter().find_map(|atom| {
        let apart = value.with_atom(&atom, &Value::variable(&part)).ok()?;
        let (factor, rest) = apart.linear_in(&part)?;
        let up = leaf(&factor, Relation::Gtr).filter(|up| *up || leaf(&factor, Relation::Lss) == Some(true))?;
        match &atom {
            Atom::Maximum(_) => {
                let parts: Option<Vec<Value>> =
                    with_zero(&atom)?.iter().map(|one| factor.mul(one).and_then(|one| one.add(&rest)).ok()).collect();
                greatest(&parts?, up, relation, leaf, splits)
            }
            Atom::Root(inner) => {
                // factor*sqrt(S) + rest lies to 0 as sqrt(S) to what follows, and turned where the factor is below 0.
                let bound = rest.neg().and_then(|rest| rest.div(&factor)).ok()?;
                let relation = if up { relation } else { relation.mirrored() };
                let squares = inner.sub(&bound.mul(&bound).ok()?).ok()?;
                match (relation, compared(&bound, Relation::Gte, leaf, splits)) {
                    (_, Some(true)) => compared(&squares, relation, leaf, splits),
                    (Relation::Gtr | Relation::Gte | Relation::Neq, Some(false)) => Some(true),
                    (_, Some(false)) => Some(false),
                    (_, None) => None,
                }
            }
            _ => None,
        }
    })
}

/// What tells whether a value stands in a relation to 0.
type Leaf<'a> = dyn Fn(&Value, Relation) -> Option<bool> + 'a;

/// Whether the greatest of these values, or the least, stands in a relation to 0.
fn greatest(parts: &[Value], most: bool, relation: Relation, leaf: &Leaf<'_>, splits: usize) -> Option<bool> {
    let stand = |relation: Relation| parts.iter().map(move |part| compared(part, relation, leaf, splits));
    let any = |relation: Relation| stand(relation).any(|told| told == Some(true));
    let all = |relation: Relation| stand(relation).all(|told| told == Some(true));
    // Of the greatest: it is above where one is, and below where all are.
    let (above, below) = if most { (Relation::Gtr, Relation::Lss) } else { (Relation::Lss, Relation::Gtr) };
    let with_equal = |strict: Relation| if strict == Relation::Gtr { Relation::Gte } else { Relation::Lte };
    match relation {
        Relation::Eq | Relation::Neq => {
            let apart = any(above) || all(below);
            let equal = || all(with_equal(below)) && any(with_equal(above));
            if apart { Some(relation == Relation::Neq) } else { equal().then_some(relation == Relation::Eq) }
        }
        _ if relation == above || relation == with_equal(above) => {
            if any(relation) {
                Some(true)
            } else {
                all(relation.negated()).then_some(false)
            }
        }
        _ => {
            if all(relation) {
                Some(true)
            } else {
                any(relation.negated()).then_some(false)
            }
        }
    }
}

/// What is compared between two indices, as the forms give it there.
struct Stretch {
    from: Value,
    until: Option<Value>,
    sides: [Value; 2],
    /// What the sides need to have a value, as they are written: in the sides of the forms it may have cancelled.
    needs: BTreeSet<Need>,
}

impl Question<'_> {
    fn answered(&self, solved: Option<&Solved>) -> Result<Earlier, Unchecked> {
        let count = self.at.as_rational().filter(|at| at.is_integer());
        let count = count.and_then(|at| at.to_integer().to_i64()?.checked_sub(self.recurrence.from));
        if count.is_some_and(|count| count < 0) {
            return Err(Unchecked(format!("there is no term {}", self.at)));
        }
        let one_by_one = |most: i64| count.filter(|count| *count <= most).is_some_and(|count| self.one_by_one(count));
        if one_by_one(FEW) {
            return Ok(if count == Some(0) { Earlier::None } else { Earlier::OneByOne });
        }
        if let Some(found) = solved.and_then(|solved| self.in_orders(solved)) {
            return Ok(found);
        }
        if one_by_one(MOST) { Ok(Earlier::OneByOne) } else { Err(Unchecked("no check of it is known".to_string())) }
    }

    /// Whether the comparison holds of these sides, where this much is known, and this tells of what is left.
    fn holds(&self, [left, right]: &[Value; 2], known: &Assumptions, otherwise: &Leaf<'_>) -> Option<bool> {
        let relation = self.wanted.0;
        if left.sort() != Sort::Real || right.sort() != Sort::Real {
            return known.decide(relation, left, right);
        }
        let leaf = |value: &Value, relation: Relation| {
            known.decide(relation, value, &Value::zero()).or_else(|| otherwise(value, relation))
        };
        compared(&left.sub(right).ok()?, relation, &leaf, MOST_SPLITS)
    }

    fn sides(&self, images: &BTreeMap<Name, Value>) -> Option<[Value; 2]> {
        Some([self.wanted.1.substitute(images).ok()?, self.wanted.2.substitute(images).ok()?])
    }

    /// Whether it holds after so many steps and not before, by the terms themselves.
    fn one_by_one(&self, count: i64) -> bool {
        let recurrence = self.recurrence;
        let terms = recurrence.terms();
        let mut now: Vec<Value> = recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
        let mut bits = 0u64;
        for step in 0..=count {
            let mut images: BTreeMap<Name, Value> =
                terms.iter().map(|(name, ..)| name.clone()).zip(now.iter().cloned()).collect();
            images.insert(recurrence.index.clone(), Value::integer(recurrence.from.saturating_add(step)));
            let Some(sides) = self.sides(&images) else { return false };
            if self.holds(&sides, &self.known, &|_, _| None) != Some(step == count) {
                return false;
            }
            if step == count {
                return self.grants([self.wanted.1, self.wanted.2], &images);
            }
            // Each term must exist, whether or not it is compared.
            if !self.grants(recurrence.sequences.iter().map(|sequence| &sequence.next), &images) {
                return false;
            }
            let Some(next) = self.following(&now, &images) else { return false };
            now = next;
            let lengths = now.iter().map(length);
            let (longest, all) = lengths.fold((0, 0), |(longest, all), own| (own.max(longest), all + own));
            bits += all;
            if longest > LONGEST || bits > MOST_BITS {
                return false;
            }
        }
        false
    }

    /// Whether these, as they are written, have a value with what is put in.
    fn grants<'v>(&self, values: impl IntoIterator<Item = &'v Value>, images: &BTreeMap<Name, Value>) -> bool {
        let granted = |need: &Need| self.known.grants(need) == Some(true);
        needs_of(values, images).is_some_and(|needs| needs.iter().all(granted))
    }

    /// The terms one index later.
    fn following(&self, now: &[Value], images: &BTreeMap<Name, Value>) -> Option<Vec<Value>> {
        let mut rest = now.iter().cloned();
        let mut later = Vec::with_capacity(now.len());
        for sequence in &self.recurrence.sequences {
            rest.next()?;
            later.extend(rest.by_ref().take(sequence.start.len().saturating_sub(1)));
            later.push(self.known.simplify(&sequence.next.substitute(images).ok()?));
        }
        Some(later)
    }

    /// By the forms, in each order of the indices at which these change.
    fn in_orders(&self, solved: &Solved) -> Option<Earlier> {
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
        let found = |known: Assumptions| Question { known, ..*self }.by_forms(solved);
        orders.into_iter().map(found).try_fold(Earlier::Forms, |all, one| Some(all.max(one?)))
    }

    /// By the forms: in each stretch before the index it never holds, or what is compared moves one way only.
    fn by_forms(&self, solved: &Solved) -> Option<Earlier> {
        let stretches = self.stretches(solved)?;
        if !self.holds_at(&stretches)? {
            return None;
        }
        if stretches.iter().all(|stretch| self.never_within(stretch)) {
            return Some(Earlier::Forms);
        }
        (stretches.len() == 1 && self.one_way(&stretches[0])).then_some(Earlier::OneWay)
    }

    /// The sides of the comparison, stretch by stretch of indices in which each sequence that it reads has one form.
    fn stretches(&self, solved: &Solved) -> Option<Vec<Stretch>> {
        let index = &self.recurrence.index;
        let read = |name: &Name| self.wanted.1.mentions(name) || self.wanted.2.mentions(name);
        let sequences: Vec<&Name> = self.recurrence.sequences.iter().map(|sequence| &sequence.name).collect();
        let sequences: Vec<&Name> = sequences.into_iter().filter(|name| read(&self.recurrence.term(name, 0))).collect();
        let first = Value::integer(self.recurrence.from);
        let pieces = |name: &&Name| match solved.form(name)? {
            Form::Pieces(pieces) => Some(pieces.clone()),
            form => Some(vec![Piece { from: first.clone(), until: None, form: form.value(index)? }]),
        };
        let rounds = |pieces: Vec<Piece>| with_first_round(pieces, index, &self.known);
        let all = sequences.iter().map(|name| pieces(name).map(rounds));
        let all: Vec<Vec<Piece>> = all.collect::<Option<_>>()?;
        let cells = cells(&all, first.clone(), &self.known).ok()?;
        let stretch = |cell: super::Cell<'_>| {
            let images = sequences.iter().zip(&cell.forms);
            let images = images.map(|(name, form)| (self.recurrence.term(name, 0), (*form).clone())).collect();
            let (sides, needs) = (self.sides(&images)?, needs_of([self.wanted.1, self.wanted.2], &images)?);
            Some(Stretch { sides, needs, from: cell.from, until: cell.until })
        };
        cells.into_iter().map(stretch).collect()
    }

    /// Whether it holds at the index, which must be a whole number that is not before the first.
    fn holds_at(&self, stretches: &[Stretch]) -> Option<bool> {
        let (index, first) = (&self.recurrence.index, Value::integer(self.recurrence.from));
        if self.known.is_natural(&self.at.sub(&first).ok()?) != Some(true) {
            return None;
        }
        if let Some(at) = natural(self.at)
            && let Some(stretch) = self.stretch_of_index(stretches)
        {
            let late =
                |value: &Value, relation: Relation| stands(&ExponentialPolynomial::of(value, index)?, relation, at);
            let defined = self.defined_at(stretch, &self.known);
            return self.holds(&stretch.sides, &Assumptions::default(), &late).filter(|_| defined);
        }
        // Of which stretch it lies in it may not be known: then it holds in either.
        let mut known = self.known.clone();
        for stretch in stretches {
            let mut here = known.clone();
            if let Some(until) = &stretch.until {
                match known.decide(Relation::Lss, self.at, until) {
                    Some(true) => return self.holds_in(stretch, &known),
                    Some(false) => continue,
                    None => here.assume(Relation::Lss, self.at, until),
                }
                known.assume(Relation::Gte, self.at, until);
            }
            if self.holds_in(stretch, &here) != Some(true) || stretch.until.is_none() {
                return self.holds_in(stretch, &here);
            }
        }
        None
    }

    /// The stretch that the index lies in, if that is known: in none before it.
    fn stretch_of_index<'s>(&self, stretches: &'s [Stretch]) -> Option<&'s Stretch> {
        for stretch in stretches {
            let Some(until) = &stretch.until else { return Some(stretch) };
            if self.known.decide(Relation::Lss, self.at, until)? {
                return Some(stretch);
            }
        }
        None
    }

    /// Whether it holds at the index, if that lies in this stretch.
    fn holds_in(&self, stretch: &Stretch, known: &Assumptions) -> Option<bool> {
        let put_in = |side: &Value| side.with(&self.recurrence.index, self.at).ok();
        let [left, right] = &stretch.sides;
        let sides = [put_in(left)?, put_in(right)?];
        let defined = self.defined_at(stretch, known);
        self.holds(&sides, known, &|_, _| None).filter(|_| defined)
    }

    /// Whether the sides, as they are written, have a value at the index.
    fn defined_at(&self, stretch: &Stretch, known: &Assumptions) -> bool {
        let image = BTreeMap::from([(self.recurrence.index.clone(), self.at.clone())]);
        let granted = |need: &Need| known.grants(&need.substitute(&image).ok()?);
        stretch.needs.iter().all(|need| granted(need) == Some(true))
    }

    /// What is known of an index from the start of a stretch on, before these ends.
    fn within<'v>(&self, stretch: &Stretch, ends: impl IntoIterator<Item = &'v Value>) -> Assumptions {
        let mut known = self.known.clone();
        let index = Value::variable(&self.recurrence.index);
        if self.recurrence.from >= 0 {
            known.assume_natural(&self.recurrence.index);
        }
        known.assume(Relation::Gte, &index, &stretch.from);
        ends.into_iter().for_each(|end| known.assume(Relation::Lss, &index, end));
        known
    }

    fn never_within(&self, stretch: &Stretch) -> bool {
        if self.known.decide(Relation::Gte, &stretch.from, self.at) == Some(true) {
            return true;
        }
        let range = || {
            let until = natural(stretch.until.as_ref().unwrap_or(self.at))?.min(natural(self.at)?);
            Some((natural(&stretch.from).filter(|_| self.recurrence.from >= 0)?, until))
        };
        let range = range();
        // Of sums of powers, at all indices between two numbers.
        let of_sums = |value: &Value, relation: Relation| {
            let (from, until) = range?;
            let sum = ExponentialPolynomial::of(value, &self.recurrence.index)?;
            let stands = |relation: Relation| throughout(&sum, relation, from, Some(until));
            if stands(relation) { Some(true) } else { stands(relation.negated()).then_some(false) }
        };
        // Of two ends the one that does not matter may hide what follows from the other.
        let until = stretch.until.as_ref().filter(|until| *until != self.at);
        let never = |known: Assumptions| self.holds(&stretch.sides, &known, &of_sums) == Some(false);
        never(self.within(stretch, [self.at]))
            || until.is_some_and(|until| {
                never(self.within(stretch, [until])) || never(self.within(stretch, [until, self.at]))
            })
    }

    /// Whether what is compared moves one way only, and is not there at the index before.
    fn one_way(&self, stretch: &Stretch) -> bool {
        let told = || {
            let index = &self.recurrence.index;
            let difference = stretch.sides[0].sub(&stretch.sides[1]).ok()?;
            let next = difference.with(index, &Value::variable(index).add(&Value::one()).ok()?).ok()?;
            let step = next.sub(&difference).ok()?;
            let known = self.within(stretch, stretch.until.iter().chain([self.at]));
            let moves = |way: Relation| known.decide(way, &step, &Value::zero()) == Some(true);
            let before = difference.with(index, &self.at.sub(&Value::one()).ok()?).ok()?;
            let stands = |relation: Relation| self.known.decide(relation, &before, &Value::zero()) == Some(true);
            let below = stands(Relation::Lss) || self.wanted.0 == Relation::Gtr && stands(Relation::Lte);
            let above = stands(Relation::Gtr) || self.wanted.0 == Relation::Lss && stands(Relation::Gte);
            Some(match self.wanted.0 {
                Relation::Gte | Relation::Gtr => below && moves(Relation::Gte),
                Relation::Lte | Relation::Lss => above && moves(Relation::Lte),
                Relation::Eq => below && moves(Relation::Gte) || above && moves(Relation::Lte),
                Relation::Neq => false,
            })
        };
        told() == Some(true)
    }
}

/// What these values need to have a meaning, with what is put in.
fn needs_of<'v>(values: impl IntoIterator<Item = &'v Value>, images: &BTreeMap<Name, Value>) -> Option<BTreeSet<Need>> {
    let each = values.into_iter().map(|value| value.needs_with(images).ok());
    each.collect::<Option<Vec<_>>>().map(|all| all.into_iter().flatten().collect())
}

fn natural(value: &Value) -> Option<u64> {
    value.as_rational().filter(|number| number.is_integer())?.to_integer().to_u64()
}

/// What a term counts for, in bits.
fn length(value: &Value) -> u64 {
    match value.as_rational() {
        Some(number) => number.numer().bits() + number.denom().bits(),
        None => SYMBOLIC.saturating_mul(value.size() as u64),
    }
}
