//! A first index with all that must hold for what was asked to have a value there.

use std::collections::{BTreeMap, BTreeSet};

use num_traits::{Signed, ToPrimitive};

use super::exact::{of_difference, of_pieces, read, straightened};
use super::reach::{self, Wanted};
use super::{Formula, Reach, Unknown};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece, Recurrence, Solved};
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value, View};

/// The sizes in a formula of which both signs are looked at, at most.
const MOST_SIGNS: usize = 2;
/// The terms that are computed for it, at most.
const MOST_TERMS: u64 = 1_000;

/// The least index at which a comparison of terms holds; of vectors, `=` or `!=`. Its conditions name what the sides need
/// to have a value there, as they are written, where that is not known: `r(n)/v` needs `v != 0` also where r(n) is
/// `v+n*v`. The search ends when `stop` says so.
pub fn reach(
    recurrence: &Recurrence,
    solved: Option<&Solved>,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Reach {
    match reach::reach(recurrence, solved, wanted, known, stop) {
        Reach::At(at, conditions) => valued(at, conditions, (recurrence, solved), wanted, known),
        Reach::Unknown(why) => Reach::Unknown(Unknown {
            formula: why.formula.filter(|formula| is_asked(formula, solved, wanted, known, MOST_SIGNS)),
            ..why
        }),
        found => found,
    }
}

/// Whether the formula of an index tells of what was asked itself: at every index the one holds where the other does. Of a part of
/// that, or of later terms alone, the first index may be another. A size in it may be that of either sign.
fn is_asked(formula: &Formula, solved: Option<&Solved>, wanted: Wanted<'_>, known: &Assumptions, most: usize) -> bool {
    let zero = Value::zero();
    let same = || {
        let solved = solved?;
        let (relation, left, right) = wanted;
        let difference = left.sub(right).ok()?;
        let recurrence = solved.recurrence();
        let pieces = of_difference(solved, &difference, &read(recurrence, &difference), known)?;
        let [earlier @ .., last @ Piece { from, until: None, .. }] = pieces.as_slice() else { return None };
        let mut natural = with_powers(formula, &recurrence.index, known)?;
        natural.assume(Relation::Gte, &Value::variable(&recurrence.index), from);
        let form = straightened(last.clone(), &recurrence.index, known).form;
        let form = with_sizes(&form, &recurrence.index, known).unwrap_or(form);
        let where_it = |holds: Relation| {
            let mut there = natural.clone();
            there.assume(holds, &formula.power, &formula.bound);
            // What is 0 times a power is one value: where it meets the bound it does so at once.
            if formula.power.is_zero() && there.contradictory() {
                return Some(holds == formula.relation);
            }
            there.decide(relation, &there.simplify(&form), &zero)
        };
        let both = (where_it(formula.relation), where_it(formula.relation.negated()));
        let begins = pieces.first().is_some_and(|piece| piece.from.is_zero());
        let none_earlier = || {
            let earlier: Vec<Piece> =
                earlier.iter().map(|piece| straightened(piece.clone(), &recurrence.index, known)).collect();
            let found = of_pieces(&earlier, &recurrence.index, (relation, &None), known);
            matches!(found, Reach::Never(_))
        };
        Some(begins && both == (Some(true), Some(false)) && (earlier.is_empty() || none_earlier()))
    };
    if same() == Some(true) {
        return true;
    }
    let Some(sign) = open_sign(&formula.power, known).filter(|_| most > 0) else { return false };
    [Relation::Gtr, Relation::Lss, Relation::Eq].into_iter().all(|relation| {
        let mut known = known.clone();
        known.assume(relation, &sign, &zero);
        let simple = |value: &Value| known.simplify(value);
        let (power, bound) = (simple(&formula.power), simple(&formula.bound));
        let here = Formula { power, bound, ..formula.clone() };
        known.contradictory() || is_asked(&here, solved, wanted, &known, most - 1)
    })
}

/// A value where the size of a power is the power of a size: `(1-k)^n` for `abs((k-1)^n)`.
fn with_sizes(value: &Value, index: &Name, known: &Assumptions) -> Option<Value> {
    let mut all = value.clone();
    for atom in value.atoms() {
        let Atom::Maximum(elements) = &atom else { continue };
        let [inner] = &**elements else { continue };
        let View::Real(above, below) = inner.view() else { continue };
        let ([(number, factors)], [(divisor, ones)]) = (above.as_slice(), below.as_slice()) else { continue };
        if !ones.is_empty() || !inner.mentions(index) {
            continue;
        }
        let mut size = Value::rational((number / divisor).abs());
        for (factor, power) in factors {
            let own = match factor {
                Atom::Power(base, exponent) => known.simplify(&base.abs().ok()?).power(exponent).ok()?,
                other => known.simplify(&other.value().ok()?.abs().ok()?),
            };
            size = size.mul(&own.power(&Value::integer(i64::from(*power))).ok()?).ok()?;
        }
        // Half of the size and what it is the size of.
        all = all.with_atom(&atom, &size.add(inner).ok()?.mul(&Value::fraction(1, 2).ok()?).ok()?).ok()?;
    }
    Some(all)
}

/// What a size in a value is the size of, where it is not known which sign that has.
fn open_sign(value: &Value, known: &Assumptions) -> Option<Value> {
    let zero = Value::zero();
    value.atoms().into_iter().find_map(|atom| {
        let Atom::Maximum(elements) = &atom else {
            let Atom::Power(base, _) = &atom else { return None };
            return open_sign(base, known);
        };
        let sign = elements.iter().find(|element| !element.is_zero())?;
        let told = [Relation::Gtr, Relation::Lss, Relation::Eq].into_iter();
        let open = told.map(|relation| known.decide(relation, sign, &zero)).all(|told| told != Some(true));
        open.then(|| sign.clone())
    })
}

/// What is known of an index and of the powers in a formula: those of what is more than 0 are too, and go one way.
fn with_powers(formula: &Formula, index: &Name, known: &Assumptions) -> Option<Assumptions> {
    let (zero, one) = (Value::zero(), Value::one());
    let mut natural = known.clone();
    natural.assume_natural(index);
    if !formula.power.is_zero() {
        natural.assume(Relation::Gtr, &formula.power, &zero);
    }
    for atom in formula.power.atoms() {
        let Atom::Power(base, exponent) = &atom else { continue };
        if exponent.as_variable() != Some(index) {
            continue;
        }
        let power = atom.value().ok()?;
        let is = |relation, bound: &Value| known.decide(relation, base, bound) == Some(true);
        if is(Relation::Gtr, &zero) {
            natural.assume(Relation::Gtr, &power, &zero);
        }
        if is(Relation::Gtr, &zero) && is(Relation::Lte, &one) {
            natural.assume(Relation::Lte, &power, &one);
        }
        if is(Relation::Gte, &one) {
            natural.assume(Relation::Gte, &power, &one);
        }
    }
    Some(natural)
}

fn valued(
    at: Value,
    mut conditions: Vec<Comparison>,
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    (_, left, right): Wanted<'_>,
    known: &Assumptions,
) -> Reach {
    let Some(mut terms) = terms(recurrence, solved, &at) else { return Reach::At(at, conditions) };
    // What is known to be a number divides by nothing else.
    let here = solved.map_or(known, Solved::known);
    terms.values_mut().for_each(|image| *image = here.with_equations(image.clone()));
    let without = || Reach::unknown(format!("at {} = {at} it has no value", recurrence.index));
    let (Ok(needs), Ok(others)) = (left.needs_with(&terms), right.needs_with(&terms)) else { return without() };
    // A form splits its powers: `a^(n-m)` has a value from m on, whatever `a^(-m)` has.
    let asked: BTreeSet<Need> =
        [left, right].into_iter().flat_map(Value::needs).filter_map(|need| need.substitute(&terms).ok()).collect();
    let mut known = solved.map_or(known, Solved::known).without_name(&recurrence.index);
    conditions.iter().for_each(|(relation, left, right)| known.assume(*relation, left, right));
    for need in needs.union(&others).flat_map(Need::apart) {
        match (known.grants(&need), &need) {
            (Some(true), _) | (None, Need::Natural(_)) => {}
            (Some(false), Need::Natural(_)) if !asked.contains(&need) => {}
            (Some(false), _) => return without(),
            (None, Need::Nonzero(value) | Need::Nonnegative(value)) => {
                let relation = if matches!(need, Need::Nonzero(_)) { Relation::Neq } else { Relation::Gte };
                known.assume(relation, value, &Value::zero());
                conditions.push((relation, value.clone(), Value::zero()));
            }
        }
    }
    Reach::At(at, conditions)
}

/// All that is read at an index: the terms there and the index itself; nothing where the terms are not known by one form
/// and the index is far, or no number.
fn terms(recurrence: &Recurrence, solved: Option<&Solved>, at: &Value) -> Option<BTreeMap<Name, Value>> {
    let index = &recurrence.index;
    let mut images = BTreeMap::from([(index.clone(), at.clone())]);
    let count = at.as_rational().filter(|at| at.is_integer()).and_then(|at| at.to_integer().to_i64());
    let count = count.and_then(|at| u64::try_from(at.checked_sub(recurrence.from)?).ok());
    let iterated = match count {
        Some(count) if count < MOST_TERMS && solved.is_none() => Some(recurrence.iterate(count as usize + 1).ok()?),
        _ => None,
    };
    for (place, sequence) in recurrence.sequences.iter().enumerate() {
        let image = match (&iterated, solved) {
            (Some(terms), _) => terms.get(place)?.last()?.clone(),
            (None, Some(solved)) => match count.and_then(|count| recurrence.from.checked_add_unsigned(count)) {
                Some(at) => solved.at(&sequence.name, at).ok()?,
                None => solved.forms().get(place)?.value(index)?.with(index, at).ok()?,
            },
            (None, None) => return None,
        };
        images.insert(recurrence.term(&sequence.name, 0), image);
    }
    Some(images)
}
