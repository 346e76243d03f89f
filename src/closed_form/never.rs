//! That terms never compare as wanted: by their forms, by induction from one term to the next, or one by one until they
//! come again or end.

use std::collections::BTreeMap;

use super::behind::{behind, solved_behind};
use super::divisors::{divisors, in_each_sign};
use super::first::Wanted;
use super::one_by_one::Terms;
use super::stretches::{Compared, Stretch};
use super::units::{Asked, InUnits, in_units};
use super::{Comparison, Form, Recurrence, Solved, Unchecked, remainders};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// So many terms are compared one by one, those with symbols less.
const MOST: i64 = 3_000;
const MOST_SYMBOLIC: i64 = 1;
/// The latest index from which on the forms, or an induction, are asked.
const LATEST: i64 = 512;

/// How it was shown that terms never compare as wanted.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Never {
    /// Whatever the terms are.
    Always,
    /// The terms were compared one by one, as the recurrence makes them, until they came again.
    ComesAgain,
    /// The terms were compared one by one, until there was no next.
    Ends,
    /// By induction from one term to the next from this index on, where each is as these say, and one by one before.
    Induction(i64, Vec<Comparison>),
    /// By the closed forms from this index on, and one by one before.
    Forms(i64),
    /// Modulo a number from this index on, where all terms were looked at until they came round, and one by one before.
    Modulo(i64, u64),
}

/// Whether a form has powers of numbers that are not rational.
fn has_powers_of_roots(form: &Form, index: &Name) -> bool {
    let Form::Sum(_, sum) = form else { return false };
    let of_root = |atom: Atom| matches!(&atom, Atom::Power(base, _) if base.as_rational().is_none() && base.variables().is_empty());
    sum.value(index).is_none_or(|value| value.atoms().into_iter().any(of_root))
}

/// Checks that a comparison holds at no index, under the assumptions and the conditions of the forms. Nothing of how it was
/// found is believed; the bounds are only tried as such of the terms.
///
/// # Errors
/// Where that is not shown.
pub fn never(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    wanted: Wanted<'_>,
    (known, bounds): (&Assumptions, &[Value]),
) -> Result<Never, Unchecked> {
    let known = solved.map_or(known, Solved::known).without_name(&recurrence.index);
    if let Some((later, (relation, left, right))) = behind(recurrence, wanted, &known) {
        let later_forms = solved.and_then(|solved| solved_behind(&later, solved));
        // Forms in pieces are not moved: these are asked as they are.
        if later_forms.is_some() || solved.is_none() {
            return never(&later, later_forms.as_ref(), (relation, &left, &right), (&known, bounds));
        }
    }
    let divisors = divisors(&[wanted.1, wanted.2], recurrence, &known);
    let check = |known: Assumptions| {
        let compared = Compared { recurrence, wanted, known };
        compared.never(solved, bounds).ok_or_else(|| Unchecked("no check of it is known".to_string()))
    };
    in_each_sign(&divisors, known, &check).or_else(|why| {
        let asked = Asked { wanted, at: None, conditions: &[] };
        let there = |one: InUnits| {
            let ((relation, left, right), solved) = (&one.wanted, &one.solved);
            never(solved.recurrence(), Some(solved), (*relation, left, right), (solved.known(), &[])).ok()
        };
        solved.and_then(|solved| in_units(solved, &asked).find_map(there)).ok_or(why)
    })
}

impl Compared<'_> {
    fn never(&self, solved: Option<&Solved>, bounds: &[Value]) -> Option<Never> {
        let index = &self.recurrence.index;
        let plain = [self.wanted.1.clone(), self.wanted.2.clone()];
        if self.holds(&plain, &self.anywhere(), &|_, _| None) == Some(false) {
            return Some(Never::Always);
        }
        let mut terms = Terms::of(self);
        let nexts = self.recurrence.sequences.iter().map(|sequence| &sequence.next);
        let repeats = !nexts.chain(&plain).any(|value| value.mentions(index));
        let (mut earlier, mut next) = (None, 0);
        let modulo = || remainders::differ(self.recurrence, self.wanted);
        // Where powers of roots are to be compared that takes long, and this does not.
        let with_roots =
            solved.is_some_and(|solved| solved.forms().iter().any(|form| has_powers_of_roots(form, index)));
        let mut differ = if with_roots { modulo() } else { None };
        loop {
            let count = terms.index().saturating_sub(self.recurrence.from);
            let holds = terms.holds();
            if holds == Some(true) {
                return None;
            }
            if let Some(shown) = differ.as_ref().filter(|shown| terms.index() >= shown.from) {
                return Some(Never::Modulo(shown.from, shown.modulus));
            }
            if count == next && count <= LATEST {
                next = (count * 2).max(1);
                let told = solved.and_then(|solved| self.by_forms(solved, terms.index(), with_roots));
                if let Some(told) = told.or_else(|| self.by_induction(&terms, bounds)) {
                    return Some(told);
                }
                if repeats {
                    earlier = Some(terms.state().to_vec());
                }
                if count == 0 && !with_roots {
                    differ = modulo();
                    continue;
                }
            }
            if holds != Some(false) {
                return None;
            }
            let symbolic = terms.state().iter().any(|value| value.as_rational().is_none());
            if count >= if symbolic { MOST_SYMBOLIC } else { MOST } {
                return None;
            }
            if !terms.advance()? {
                // Of several sequences one may end that is not read.
                return (self.recurrence.sequences.len() == 1).then_some(Never::Ends);
            }
            if earlier.as_deref() == Some(terms.state()) {
                return Some(Never::ComesAgain);
            }
        }
    }

    /// By the forms from an index on, in each order of the indices at which these change.
    fn by_forms(&self, solved: &Solved, from: i64, with_roots: bool) -> Option<Never> {
        let never = |known: Assumptions| {
            let compared = self.knowing(known);
            let away = |compared: &Compared<'_>, stretch: &Stretch| compared.away(stretch, from);
            compared.in_none(&compared.stretches(solved)?, (from, None), &away).then_some(())
        };
        let in_orders = || self.orders(solved)?.into_iter().map(never).collect::<Option<Vec<_>>>();
        // What stands in powers of roots is told by which of them outgrows the others, or by nothing.
        let told = self.never_of_sums(solved, from)
            || !with_roots && (in_orders().is_some() || self.in_turns(solved, from) == Some(true));
        told.then_some(Never::Forms(from))
    }

    /// The same in each turn of forms that come in turn.
    fn in_turns(&self, solved: &Solved, from: i64) -> Option<bool> {
        let count = self.turns(solved)?;
        for place in 0..count {
            let later = from.checked_sub(self.recurrence.from)?.saturating_sub(place).max(0);
            let from = later.checked_add(count - 1)? / count;
            let stretches = self.stretches_in_turn(solved, count, place)?;
            if !stretches.iter().all(|stretch| self.away(stretch, from)) {
                return Some(false);
            }
        }
        Some(true)
    }

    fn away(&self, stretch: &Stretch, from: i64) -> bool {
        self.never_within(stretch, from, None)
            || self.moves_away(stretch, from) == Some(true)
            || self.steps_over(stretch) == Some(true)
            || self.is_below_its_bound(stretch) == Some(true)
            || self.is_below_up_to_the_end(stretch) == Some(true)
    }

    /// Whether two sides could be equal at one index alone, which is none: no whole number.
    fn steps_over(&self, stretch: &Stretch) -> Option<bool> {
        let difference = stretch.sides[0].sub(&stretch.sides[1]).ok().filter(|_| self.wanted.0 == Relation::Eq)?;
        let (factor, rest) = difference.linear_in(&self.recurrence.index)?;
        let index = rest.neg().and_then(|rest| rest.div(&factor)).ok()?;
        let alone = self.known.decide(Relation::Neq, &factor, &Value::zero()) == Some(true);
        let whole = || self.known.decide(Relation::Eq, &self.known.simplify(&index.floor().ok()?), &index);
        let natural = self.recurrence.from < 0 || self.known.is_natural(&index) != Some(false);
        Some(alone && (!natural || whole() == Some(false)))
    }

    /// Whether it does not hold where a stretch begins, and what is compared only moves away within it.
    fn moves_away(&self, stretch: &Stretch, from: i64) -> Option<bool> {
        let index = &self.recurrence.index;
        let difference = stretch.sides[0].sub(&stretch.sides[1]).ok()?;
        let step =
            difference.with(index, &Value::variable(index).add(&Value::one()).ok()?).ok()?.sub(&difference).ok()?;
        let from = Value::integer(from);
        let later = self.known.decide(Relation::Gte, &stretch.from, &from)?;
        let start = if later { &stretch.from } else { &from };
        let mut known = self.within(stretch, &stretch.until);
        known.assume(Relation::Gte, &Value::variable(index), start);
        if !known.gives_meaning(&difference) {
            return None;
        }
        let first = difference.with(index, start).ok()?;
        let stands = |relation: Relation| self.known.decide(relation, &first, &Value::zero()) == Some(true);
        let moves = |way: Relation| known.decide(way, &step, &Value::zero()) == Some(true);
        Some(kept_sides(self.wanted.0).iter().any(|(side, way)| stands(*side) && moves(*way)))
    }

    /// By induction from these terms on.
    fn by_induction(&self, terms: &Terms<'_>, bounds: &[Value]) -> Option<Never> {
        if self.recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
            return None;
        }
        let index = Value::variable(&self.recurrence.index);
        let next = self.recurrence.sequences.iter();
        let mut later: BTreeMap<Name, Value> =
            next.map(|sequence| (self.recurrence.term(&sequence.name, 0), sequence.next.clone())).collect();
        later.insert(self.recurrence.index.clone(), index.add(&Value::one()).ok()?);
        let mut known = self.anywhere();
        known.assume(Relation::Gte, &index, &Value::integer(terms.index()));
        let within = |region: &[Comparison]| {
            let mut known = known.clone();
            region.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
            // Each term must exist, whether or not it is compared.
            let sides = region.iter().flat_map(|(_, left, right)| [left, right]);
            let mut values = self.recurrence.sequences.iter().map(|sequence| &sequence.next).chain(sides);
            values.all(|value| known.gives_meaning(value)).then_some(known)
        };
        let stays = |(relation, left, right): &Comparison, known: &Assumptions| {
            let sides = [left, right].map(|side| side.substitute(&later).ok().map(|side| known.simplify(&side)));
            let [Some(next), Some(bound)] = sides else { return false };
            known.decide(*relation, &next, &bound) == Some(true)
                || recedes(*relation, [left, right], [&next, &bound], known)
        };
        let kept = |region: &Region| within(region).is_some_and(|known| region.iter().all(|one| stays(one, &known)));
        let regions = self.regions(terms, bounds)?;
        if let Some(region) = regions.iter().find(|region| kept(region)) {
            return Some(Never::Induction(terms.index(), region.clone()));
        }
        // The signs of the terms and of their steps may help each other: those that do not stay are left out.
        let beside = self.signs(terms);
        let with_signs = |region: &Region| {
            let mut all = [region.as_slice(), &beside].concat();
            loop {
                let known = within(&all)?;
                let staying: Vec<Comparison> = all.iter().filter(|one| stays(one, &known)).cloned().collect();
                if !region.iter().all(|one| staying.contains(one)) {
                    return None;
                }
                if staying.len() < all.len() {
                    all = staying;
                    continue;
                }
                // No more of them than are needed.
                for one in staying.iter().rev().filter(|one| !region.contains(one)) {
                    let fewer: Region = all.iter().filter(|other| *other != one).cloned().collect();
                    if kept(&fewer) {
                        all = fewer;
                    }
                }
                return Some(all);
            }
        };
        let region = regions.iter().filter(|_| !beside.is_empty()).find_map(with_signs)?;
        Some(Never::Induction(terms.index(), region))
    }

    /// The signs that the terms of several sequences have here, and those of their steps.
    fn signs(&self, terms: &Terms<'_>) -> Vec<Comparison> {
        let (recurrence, zero) = (self.recurrence, Value::zero());
        if recurrence.sequences.len() < 2 {
            return Vec::new();
        }
        let mut here: BTreeMap<Name, Value> = recurrence
            .sequences
            .iter()
            .zip(terms.state())
            .map(|(own, now)| (recurrence.term(&own.name, 0), now.clone()))
            .collect();
        here.insert(recurrence.index.clone(), Value::integer(terms.index()));
        let sign = |value: Value| {
            let now = value.substitute(&here).ok()?;
            let holds = |relation: &Relation| self.known.decide(*relation, &now, &zero) == Some(true);
            let relation = [Relation::Gtr, Relation::Lss, Relation::Gte, Relation::Lte].into_iter().find(holds)?;
            Some((relation, value, zero.clone()))
        };
        let values = recurrence.sequences.iter().flat_map(|sequence| {
            let own = Value::variable(&recurrence.term(&sequence.name, 0));
            let step = sequence.next.sub(&own).ok();
            [Some(own), step].into_iter().flatten()
        });
        values.filter_map(sign).collect()
    }

    /// Regions in which these terms lie, and in which none is as wanted.
    fn regions(&self, terms: &Terms<'_>, bounds: &[Value]) -> Option<Vec<Region>> {
        let (difference, [left, right]) = (self.wanted.1.sub(self.wanted.2).ok()?, terms.sides()?);
        let (here, zero) = (left.sub(&right).ok()?, Value::zero());
        let mut regions: Vec<Region> = Vec::new();
        for (side, way) in kept_sides(self.wanted.0) {
            if self.known.decide(*side, &here, &zero) == Some(true) {
                regions.push(vec![(*side, difference.clone(), zero.clone())]);
                regions.push(vec![(*way, difference.clone(), here.clone())]);
            }
        }
        let ([sequence], [now]) = (self.recurrence.sequences.as_slice(), terms.state()) else { return Some(regions) };
        let own = Value::variable(&self.recurrence.term(&sequence.name, 0));
        let at = |relation: Relation, bound: &Value| (relation, own.clone(), bound.clone());
        let opposite = now.neg().ok()?;
        // Of bounds that move with the index one is enough.
        let (moving, fixed): (Vec<&Value>, Vec<&Value>) =
            bounds.iter().partition(|bound| bound.mentions(&self.recurrence.index));
        let ends = |near: Relation, far: Relation| -> Vec<Option<Comparison>> {
            let strict = fixed.iter().map(|bound| at(far, bound));
            let near = [now, &opposite].into_iter().chain(fixed.iter().copied()).map(|bound| at(near, bound));
            near.chain(strict).map(Some).chain([None]).collect()
        };
        let (above, below) = (ends(Relation::Gte, Relation::Gtr), ends(Relation::Lte, Relation::Lss));
        let moving =
            moving.iter().flat_map(|bound| [Relation::Gte, Relation::Lte].map(|relation| vec![at(relation, bound)]));
        let of_term =
            above.iter().flat_map(|one| below.iter().map(move |other| one.iter().chain(other).cloned().collect()));
        let of_term = of_term.chain(moving);
        let plain = [self.wanted.1.clone(), self.wanted.2.clone()];
        let lies = |region: &Region| {
            let inside = |(relation, _, bound): &Comparison| {
                let bound = bound.with(&self.recurrence.index, &Value::integer(terms.index()));
                bound.is_ok_and(|bound| self.known.decide(*relation, now, &bound) == Some(true))
            };
            let mut known = self.anywhere();
            region.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
            region.iter().all(inside) && self.holds(&plain, &known, &|_, _| None) == Some(false)
        };
        regions.extend(of_term.filter(|region: &Region| !region.is_empty()).filter(lies));
        Some(regions)
    }
}

/// Whether what lies on a side of a bound moves away from it, or with it, to the next term.
fn recedes(relation: Relation, [left, right]: [&Value; 2], [next, bound]: [&Value; 2], known: &Assumptions) -> bool {
    let way = match relation {
        Relation::Lss | Relation::Lte => Relation::Lte,
        Relation::Gtr | Relation::Gte => Relation::Gte,
        Relation::Eq | Relation::Neq => return false,
    };
    let moved = || next.sub(bound)?.sub(&left.sub(right)?);
    moved().is_ok_and(|moved| known.decide(way, &moved, &Value::zero()) == Some(true))
}

/// What terms are compared with, all of it at once.
type Region = Vec<Comparison>;

/// The sides of 0 on which a difference is not as wanted, each with the way in which it may move there.
fn kept_sides(wanted: Relation) -> &'static [(Relation, Relation)] {
    match wanted {
        Relation::Gtr => &[(Relation::Lte, Relation::Lte)],
        Relation::Gte => &[(Relation::Lss, Relation::Lte)],
        Relation::Lss => &[(Relation::Gte, Relation::Gte)],
        Relation::Lte => &[(Relation::Gtr, Relation::Gte)],
        Relation::Eq => &[(Relation::Gtr, Relation::Gte), (Relation::Lss, Relation::Lte)],
        Relation::Neq => &[],
    }
}
