//! That an index is the first at which terms compare as wanted: there they do, and at no index before it.

use std::collections::BTreeMap;

use num_traits::ToPrimitive;

use super::behind::{behind, solved_behind};
use super::comparing::with_zero;
use super::divisors::{divisors, in_each_sign};
use super::one_by_one::Terms;
use super::stretches::{Compared, Stretch, natural};
use super::units::{Asked, InUnits, in_units};
use super::whole_parts::is_not_before;
use super::{Comparison, Recurrence, Solved, Unchecked};
use crate::assumption::Assumptions;
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::stands;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value};

/// So many terms are compared one by one before the forms are asked, and where these do not tell.
const FEW: i64 = 500;
const MOST: i64 = 20_000;
/// So many indices behind one with symbols are looked at one by one.
const FEW_BEHIND: u64 = 8;
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

/// Whether this index is the first.
pub(super) struct Question<'a> {
    pub(super) compared: Compared<'a>,
    pub(super) at: &'a Value,
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
    let divisors = divisors(&[at, wanted.1, wanted.2], recurrence, &known);
    let check = |known: Assumptions| {
        let mut how = Earlier::None;
        for (at, mut known) in each_case(&known.simplify(at), known) {
            // What is the greatest of several in them may be known here.
            for (relation, left, right) in conditions {
                let [left, right] = [left, right].map(|side| known.simplify(side));
                known.assume(*relation, &left, &right);
            }
            how = how.max(Question { compared: Compared { recurrence, wanted, known }, at: &at }.answered(solved)?);
        }
        Ok(how)
    };
    let told = in_each_sign(&divisors, known.clone(), &check);
    match (told, solved) {
        (Err(why), Some(solved)) => asked_otherwise(solved, wanted, (at, conditions), &known).ok_or(why),
        (told, _) => told,
    }
}

/// The same of the later terms alone, of which it is asked, or where a unit of measure is 1.
fn asked_otherwise(
    solved: &Solved,
    wanted: Wanted<'_>,
    (at, conditions): (&Value, &[Comparison]),
    known: &Assumptions,
) -> Option<Earlier> {
    if let Some((later, (relation, left, right))) = behind(solved.recurrence(), wanted, known) {
        let forms = solved_behind(&later, solved)?;
        return first(&later, Some(&forms), (relation, &left, &right), (at, conditions), known).ok();
    }
    let asked = Asked { wanted, at: Some(at), conditions };
    let there = |one: InUnits| {
        let ((relation, left, right), solved) = (&one.wanted, &one.solved);
        let place = (one.at.as_ref()?, one.conditions.as_slice());
        first(solved.recurrence(), Some(solved), (*relation, left, right), place, solved.known()).ok()
    };
    in_units(solved, &asked).find_map(there)
}

/// Whether a comparison holds at an index, by the forms.
pub fn holds_there(solved: &Solved, wanted: Wanted<'_>, at: &Value) -> Option<bool> {
    let recurrence = solved.recurrence();
    let compared = Compared { recurrence, wanted, known: solved.known().without_name(&recurrence.index) };
    let stretches = compared.stretches(solved)?;
    Question { compared, at }.holds_at(&stretches, at, recurrence.from)
}

/// An index that is the greatest of several, in each case of which of them it is.
fn each_case(at: &Value, known: Assumptions) -> Vec<(Value, Assumptions)> {
    let all = || {
        let atom = maximum_in(at)?;
        let elements = with_zero(&atom)?;
        let mut cases = Vec::new();
        for one in &elements {
            let mut known = known.clone();
            for other in elements.iter().filter(|other| *other != one) {
                known.assume(Relation::Gte, one, other);
            }
            if !known.contradictory() {
                let image = at.replace(&mut |other| (*other == atom).then(|| one.clone())).ok()?;
                cases.push((known.simplify(&image), known));
            }
        }
        Some(cases)
    };
    all().unwrap_or_else(|| vec![(at.clone(), known.clone())])
}

/// A maximum in a value, or in what is rounded in it.
fn maximum_in(value: &Value) -> Option<Atom> {
    value.atoms().into_iter().find_map(|atom| match &atom {
        Atom::Maximum(_) => Some(atom),
        Atom::Floor(inner) => maximum_in(inner),
        _ => None,
    })
}

impl Question<'_> {
    fn answered(&self, solved: Option<&Solved>) -> Result<Earlier, Unchecked> {
        let count = self.at.as_rational().filter(|at| at.is_integer());
        let count = count.and_then(|at| at.to_integer().to_i64()?.checked_sub(self.compared.recurrence.from));
        if count.is_some_and(|count| count < 0) {
            return Err(Unchecked(format!("there is no term {}", self.at)));
        }
        let one_by_one = |most: i64, terms: Terms<'_>| {
            count.filter(|count| *count <= most).is_some_and(|count| self.one_by_one(count, terms))
        };
        if one_by_one(FEW, Terms::of(&self.compared)) {
            return Ok(if count == Some(0) { Earlier::None } else { Earlier::OneByOne });
        }
        if let Some(found) = solved.and_then(|solved| self.in_orders(solved)) {
            return Ok(found);
        }
        if one_by_one(MOST, Terms::at_last(&self.compared)) {
            Ok(Earlier::OneByOne)
        } else {
            Err(Unchecked("no check of it is known".to_string()))
        }
    }

    /// Whether it holds after so many steps and not before, by the terms themselves.
    fn one_by_one(&self, count: i64, mut terms: Terms<'_>) -> bool {
        for step in 0..=count {
            if terms.holds() != Some(step == count) {
                return false;
            }
            if step == count {
                return terms.compares();
            }
            if terms.advance() != Some(true) {
                return false;
            }
        }
        false
    }

    /// The same by the forms, in each order of the indices at which these change.
    fn in_orders(&self, solved: &Solved) -> Option<Earlier> {
        let found =
            |known: Assumptions| Question { compared: self.compared.knowing(known), at: self.at }.by_forms(solved);
        let orders = self.compared.orders(solved)?;
        let told = orders.into_iter().map(found).try_fold(Earlier::Forms, |all, one| Some(all.max(one?)));
        told.or_else(|| self.in_turns(solved))
    }

    /// The same of forms that come in turn: the index lies in one of the turns, and in each it never holds before.
    fn in_turns(&self, solved: &Solved) -> Option<Earlier> {
        let (count, from) = (self.compared.turns(solved)?, self.compared.recurrence.from);
        let mut met = false;
        for place in 0..count {
            let stretches = self.compared.stretches_in_turn(solved, count, place)?;
            let since = self.at.sub(&Value::integer(from.checked_add(place)?)).ok()?;
            let round = since.div(&Value::integer(count)).ok()?;
            if !stretches.iter().all(|stretch| self.compared.never_within(stretch, 0, Some(&round))) {
                return None;
            }
            met = met || self.holds_at(&stretches, &round, 0) == Some(true);
        }
        met.then_some(Earlier::Forms)
    }

    /// By the forms: in each stretch before the index it never holds, or what is compared moves one way only.
    fn by_forms(&self, solved: &Solved) -> Option<Earlier> {
        let stretches = self.compared.stretches(solved)?;
        if !self.holds_at(&stretches, self.at, self.compared.recurrence.from)? {
            return None;
        }
        let from = self.compared.recurrence.from;
        let never = |compared: &Compared<'_>, stretch: &Stretch| {
            compared.never_within(stretch, from, Some(self.at))
                || compared.is_below_up_to_the_end(stretch) == Some(true)
                || self.behind_the_root(stretch) == Some(true)
                || self.none_of_few(compared, stretch) == Some(true)
        };
        if self.compared.in_none(&stretches, (from, Some(self.at)), &never) {
            return Some(Earlier::Forms);
        }
        let single = if let [only] = stretches.as_slice() { self.one_way(only) } else { false };
        (single || self.one_way_by_steps(solved, &stretches) == Some(true)).then_some(Earlier::OneWay)
    }

    /// The same of what goes on through several stretches: each step, as the equations make it of the terms, goes one way.
    fn one_way_by_steps(&self, solved: &Solved, stretches: &[Stretch]) -> Option<bool> {
        let Compared { recurrence, wanted: (relation, left, right), known } = &self.compared;
        let against = match relation {
            Relation::Gte | Relation::Gtr => Relation::Lss,
            Relation::Lte | Relation::Lss => Relation::Gtr,
            Relation::Eq | Relation::Neq => return None,
        };
        if recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
            return None;
        }
        let one = Value::one();
        if self.holds_at(stretches, &self.at.sub(&one).ok()?, recurrence.from)? {
            return Some(false);
        }
        let grants = |compared: &Compared<'_>, stretch: &Stretch| {
            let known = compared.within(stretch, stretch.until.iter().chain([self.at]));
            stretch.needs.iter().all(|need| known.grants(need) == Some(true))
        };
        let mut images: BTreeMap<Name, Value> =
            recurrence.sequences.iter().map(|own| (recurrence.term(&own.name, 0), own.next.clone())).collect();
        images.insert(recurrence.index.clone(), Value::variable(&recurrence.index).add(&one).ok()?);
        let difference = left.sub(right).ok()?;
        let step = difference.substitute(&images).ok()?.sub(&difference).ok()?;
        let zero = Value::zero();
        let steps = Compared { recurrence, wanted: (against, &step, &zero), known: known.clone() };
        let back = |stretch: &Stretch| {
            !grants(&steps, stretch) || !steps.never_within(stretch, recurrence.from, Some(self.at))
        };
        let meant = stretches.iter().all(|stretch| grants(&self.compared, stretch));
        Some(meant && !steps.stretches(solved)?.iter().any(back))
    }

    /// Whether a stretch that begins at an index with symbols has a few indices before this one, and it holds at none of them.
    fn none_of_few(&self, compared: &Compared<'_>, stretch: &Stretch) -> Option<bool> {
        let known = &compared.known;
        if stretch.from.as_rational().is_some() {
            return None;
        }
        let few = natural(&known.simplify(&self.at.sub(&stretch.from).ok()?)).filter(|few| *few <= FEW_BEHIND)?;
        let holds = |back: u64| {
            let at = stretch.from.add(&Value::integer(i64::try_from(back).ok()?)).ok()?;
            let [left, right] = &stretch.sides;
            let sides = [left, right].map(|side| side.with(&compared.recurrence.index, &at).ok());
            let [Some(left), Some(right)] = sides else { return None };
            compared.holds(&[left, right], known, &|_, _| None)
        };
        Some((0..few).all(|back| holds(back) == Some(false)))
    }

    /// Whether it holds at the index, which must be a whole number that is not before the first.
    fn holds_at(&self, stretches: &[Stretch], at: &Value, first: i64) -> Option<bool> {
        let index = &self.compared.recurrence.index;
        if self.compared.known.is_natural(&at.sub(&Value::integer(first)).ok()?) != Some(true) {
            return None;
        }
        if let Some(place) = natural(at)
            && let Some(stretch) = self.stretch_of_index(stretches, at)
        {
            let late =
                |value: &Value, relation: Relation| stands(&ExponentialPolynomial::of(value, index)?, relation, place);
            let defined = self.defined_at(stretch, at, &self.compared.known);
            return self.compared.holds(&stretch.sides, &Assumptions::default(), &late).filter(|_| defined);
        }
        // Of which stretch it lies in it may not be known: then it holds in either.
        let (mut known, mut at) = (self.compared.known.clone(), at);
        for stretch in stretches {
            let mut here = known.clone();
            // Not before where it begins, nor behind that: it is that.
            let is = |relation: Relation| known.decide(relation, at, &stretch.from) == Some(true);
            if is(Relation::Eq) || is(Relation::Gte) && is_not_before(&stretch.from, at, &known) {
                at = &stretch.from;
            }
            if let Some(until) = &stretch.until {
                match is_before(at, until, &known) {
                    Some(true) => return self.holds_in(stretch, at, &known),
                    Some(false) => continue,
                    None => here.assume(Relation::Lss, at, until),
                }
                known.assume(Relation::Gte, at, until);
            }
            if self.holds_in(stretch, at, &here) != Some(true) || stretch.until.is_none() {
                return self.holds_in(stretch, at, &here);
            }
        }
        None
    }

    /// The stretch that the index lies in, if that is known: in none before it.
    fn stretch_of_index<'s>(&self, stretches: &'s [Stretch], at: &Value) -> Option<&'s Stretch> {
        for stretch in stretches {
            let Some(until) = &stretch.until else { return Some(stretch) };
            if self.compared.known.decide(Relation::Lss, at, until)? {
                return Some(stretch);
            }
        }
        None
    }

    /// Whether it holds at the index, if that lies in this stretch.
    fn holds_in(&self, stretch: &Stretch, at: &Value, known: &Assumptions) -> Option<bool> {
        let put_in = |side: &Value| side.with(&self.compared.recurrence.index, at).ok();
        let [left, right] = &stretch.sides;
        let sides = [put_in(left)?, put_in(right)?];
        let defined = self.defined_at(stretch, at, known);
        let told = self.compared.holds(&sides, known, &|_, _| None).filter(|_| defined);
        let found = |told: Option<bool>| told.filter(|holds| *holds && at == self.at);
        let behind = || found(self.holds_behind_the_root(stretch));
        told.or_else(behind).or_else(|| found(self.holds_between_the_roots(stretch, known)))
    }

    /// Whether the sides, as they are written, have a value at the index.
    pub(super) fn defined_at(&self, stretch: &Stretch, at: &Value, known: &Assumptions) -> bool {
        let image = BTreeMap::from([(self.compared.recurrence.index.clone(), at.clone())]);
        let here = |need: &Need| need.substitute(&image).is_ok_and(|need| known.grants(&need) == Some(true));
        // Late powers are too long to be written out: `10^n` is 0 for no n.
        let anywhere = |need: &Need| self.compared.anywhere().grants(need) == Some(true);
        stretch.needs.iter().all(|need| here(need) || anywhere(need))
    }

    /// Whether what is compared moves one way only, and is not there at the index before.
    fn one_way(&self, stretch: &Stretch) -> bool {
        let told = || {
            let index = &self.compared.recurrence.index;
            let difference = stretch.sides[0].sub(&stretch.sides[1]).ok()?;
            let next = difference.with(index, &Value::variable(index).add(&Value::one()).ok()?).ok()?;
            let step = next.sub(&difference).ok()?;
            let known = self.compared.within(stretch, stretch.until.iter().chain([self.at]));
            if !known.gives_meaning(&difference) {
                return None;
            }
            let moves = |way: Relation| known.decide(way, &step, &Value::zero()) == Some(true);
            let before = |relation: Relation| self.stands_before(&difference, relation) == Some(true);
            let below = before(Relation::Lss) || self.compared.wanted.0 == Relation::Gtr && before(Relation::Lte);
            let above = before(Relation::Gtr) || self.compared.wanted.0 == Relation::Lss && before(Relation::Gte);
            Some(match self.compared.wanted.0 {
                Relation::Gte | Relation::Gtr => below && moves(Relation::Gte),
                Relation::Lte | Relation::Lss => above && moves(Relation::Lte),
                Relation::Eq => below && moves(Relation::Gte) || above && moves(Relation::Lte),
                Relation::Neq => false,
            })
        };
        told() == Some(true)
    }
    /// How what is compared stands to 0 at the index before. Late powers of numbers are too long to be written out.
    fn stands_before(&self, difference: &Value, relation: Relation) -> Option<bool> {
        let index = &self.compared.recurrence.index;
        let late = || {
            let place = natural(self.at)?.checked_sub(1)?;
            stands(&ExponentialPolynomial::of(difference, index)?, relation, place)
        };
        late().or_else(|| {
            let before = difference.with(index, &self.at.sub(&Value::one()).ok()?).ok()?;
            self.compared.known.decide(relation, &before, &Value::zero())
        })
    }
}

/// Whether an index is before another, or a multiple of it before the same of the other by a name that is above 0.
fn is_before(at: &Value, until: &Value, known: &Assumptions) -> Option<bool> {
    let decided = || known.decide(Relation::Lss, at, until);
    let by = |name: &Name| {
        let factor = Value::variable(name);
        let positive = known.decide(Relation::Gtr, &factor, &Value::zero()) == Some(true);
        let sides = at.mul(&factor).and_then(|at| Ok((at, until.mul(&factor)?))).ok().filter(|_| positive)?;
        known.decide(Relation::Lss, &sides.0, &sides.1)
    };
    decided().or_else(|| at.variables().union(&until.variables()).find_map(by))
}
