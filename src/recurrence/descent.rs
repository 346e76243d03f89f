//! First indices of a single sequence without closed form: its terms are enclosed between numbers of a fixed length, and
//! where it moves one way only, terms that have passed the goal end the search.

use std::cmp::Ordering;

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::Reach;
use super::nonlinear::{LATER_STARTS, Motion, course, later, single};
use super::product::quotient;
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Relation, Value};

/// The terms that are enclosed at most, and the most bits of one.
const MOST_TERMS: u64 = 20_000;
const MOST_BITS: u64 = 1 << 14;
/// The bits behind the point, of one attempt after the other.
const PRECISIONS: [usize; 2] = [192, 1_024];

/// The first index at which a comparison of a term with a number holds, or why there is none; nothing where neither is found.
/// Where it does not move one way from its start, it may from a term after it.
pub(super) fn descends(
    recurrence: &Recurrence,
    wanted: Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let at_once = descends_at_once(recurrence, wanted, known, stop);
    if at_once.is_some() || course(recurrence, known).is_some() {
        return at_once;
    }
    let (relation, left, right) = wanted;
    let mut here = recurrence.clone();
    for _ in 0..LATER_STARTS {
        let (_, name, start) = single(&here)?;
        let sides = [left, right].map(|side| side.with(&name, start).ok());
        if known.decide(relation, sides[0].as_ref()?, sides[1].as_ref()?) != Some(false) {
            return None;
        }
        here = later(&here)?;
        if course(&here, known).is_none() {
            continue;
        }
        match descends_at_once(&here, wanted, known, stop) {
            Some(Reach::Never(why)) => {
                let (index, from) = (&here.index, here.from);
                return Some(Reach::Never(format!("no term before {index} = {from} is, and from there on {why}")));
            }
            Some(found) => return Some(found),
            None => {}
        }
    }
    None
}

fn descends_at_once(
    recurrence: &Recurrence,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<Reach> {
    let (map, name, start) = single(recurrence)?;
    let motion = course(recurrence, known);
    let (between, why) =
        motion.as_ref().map_or_else(|| (known.clone(), None), |motion| within(motion, (&name, start), known));
    if let Some(why) = why.filter(|_| between.decide(relation, left, right) == Some(false)) {
        return Some(Reach::Never(why));
    }
    let (factor, rest) = left.sub(right).ok()?.linear_in(&name)?;
    let (factor, rest) = (factor.as_rational()?, rest.as_rational()?);
    if factor.is_zero() || relation == Relation::Neq {
        return None;
    }
    let goal = -rest / &factor;
    let relation = if factor.is_negative() { relation.mirrored() } else { relation };
    if let Some(why) = motion.as_ref().and_then(|motion| beyond(motion, relation, &goal, known)) {
        return Some(Reach::Never(why));
    }
    let [above, below] = quotient(map, &name)?;
    let start = start.as_rational()?;
    let search =
        Search { above, below, relation, goal, motion, index: recurrence.index.to_string(), from: recurrence.from };
    PRECISIONS.into_iter().find_map(|precision| search.run(&start, precision, stop))
}

/// What holds of the terms of a sequence that moves one way only, in words too: it lies between its start and its bound.
fn within(motion: &Motion, (name, start): (&Name, &Value), known: &Assumptions) -> (Assumptions, Option<String>) {
    let Motion::Moves { grows, bound } = motion else { return (known.clone(), None) };
    let mut between = known.without_name(name);
    let term = Value::variable(name);
    let (from, to) = if *grows { (Relation::Gte, Relation::Lss) } else { (Relation::Lte, Relation::Gtr) };
    between.assume(from, &term, start);
    let mut why = format!("it {} in every step, from {start}", if *grows { "grows" } else { "falls" });
    if let Some(bound) = bound {
        between.assume(to, &term, &bound.beyond(*grows));
        why = format!("{why}, and stays {} the fixed point {bound}", if *grows { "below" } else { "above" });
    }
    (between, Some(why))
}

/// Why a sequence that stays on one side of a fixed point does not come to a number at it or on its other side.
fn beyond(motion: &Motion, relation: Relation, goal: &BigRational, known: &Assumptions) -> Option<String> {
    let Motion::Moves { grows, bound: Some(bound) } = motion else { return None };
    let (towards, there) = if *grows { (Relation::Gtr, Relation::Gte) } else { (Relation::Lss, Relation::Lte) };
    let asks = [Relation::Eq, towards, there].contains(&relation);
    let far = known.decide(there, &Value::rational(goal.clone()), &bound.beyond(*grows)) == Some(true);
    let (verb, side) = if *grows { ("grows", "below") } else { ("falls", "above") };
    (asks && far).then(|| format!("it {verb} in every step and stays {side} the fixed point {bound}"))
}

struct Search {
    above: Univariate,
    below: Univariate,
    relation: Relation,
    goal: BigRational,
    motion: Option<Motion>,
    index: String,
    from: i64,
}

/// Whole numbers between which, over a power of 2, a number lies.
type Range = (BigInt, BigInt);

impl Search {
    /// The answer with numbers of so many bits behind the point; nothing where these do not decide it.
    fn run(&self, start: &BigRational, precision: usize, stop: &dyn Fn() -> bool) -> Option<Reach> {
        let fixed = |polynomial: &Univariate| -> Vec<Range> {
            polynomial.coefficients().iter().rev().map(|number| range(number, precision)).collect()
        };
        let map = [fixed(&self.above), fixed(&self.below)];
        let goal = range(&self.goal, precision);
        let mut here = range(start, precision);
        for step in 0..MOST_TERMS {
            if stop() || here.0.bits().max(here.1.bits()) > MOST_BITS {
                return None;
            }
            let at = self.from.checked_add_unsigned(step)?;
            if self.holds(&here, &goal)? {
                return Some(Reach::At(Value::integer(at), Vec::new()));
            }
            if let Some(why) = self.passed(&here, &goal, at) {
                return Some(Reach::Never(why));
            }
            here = next(&map, &here, precision)?;
        }
        None
    }

    /// Whether every number of a range compares as wanted; nothing where that is not sure.
    fn holds(&self, here: &Range, goal: &Range) -> Option<bool> {
        let order = if here.0 > goal.1 {
            Ordering::Greater
        } else if here.1 < goal.0 {
            Ordering::Less
        } else {
            (here.0 == here.1 && goal.0 == goal.1).then_some(Ordering::Equal)?
        };
        Some(self.relation.holds(order))
    }

    /// Why no later term does, where none of these does.
    fn passed(&self, here: &Range, goal: &Range, at: i64) -> Option<String> {
        let grows = match &self.motion {
            Some(Motion::Stays) => return Some("it stays the same".to_string()),
            Some(Motion::Moves { grows, .. }) => *grows,
            None => return None,
        };
        let (gone, verb) = if grows { (here.0 > goal.1, "grows") } else { (here.1 < goal.0, "falls") };
        let never = !self.relation.holds(if grows { Ordering::Greater } else { Ordering::Less });
        let index = &self.index;
        (gone && never).then(|| match at == self.from {
            true => format!("it {verb} in every step, and is past it at the start"),
            false => format!("no term before {index} = {at} is; there it has passed it, and it {verb} in every step"),
        })
    }
}

/// The two whole numbers next to a number, or itself, over `2^precision`.
fn range(number: &BigRational, precision: usize) -> Range {
    let (low, rest) = (number.numer() << precision).div_mod_floor(number.denom());
    let high = if rest.is_zero() { low.clone() } else { &low + BigInt::one() };
    (low, high)
}

/// Where the image of a range lies, of a quotient of two polynomials by Horner's rule.
fn next(map: &[Vec<Range>; 2], here: &Range, precision: usize) -> Option<Range> {
    let [above, below] = map.each_ref().map(|polynomial| {
        polynomial.iter().fold((BigInt::zero(), BigInt::zero()), |all, (low, high)| {
            let product = times(&all, here, precision);
            (product.0 + low, product.1 + high)
        })
    });
    let one = BigInt::one() << precision;
    if below.0 == one && below.1 == one {
        return Some(above);
    }
    if !below.0.is_positive() && !below.1.is_negative() {
        return None;
    }
    let inverse = |number: &BigInt| (BigInt::one() << (2 * precision)).div_mod_floor(number);
    let (low, (high, rest)) = (inverse(&below.1).0, inverse(&below.0));
    let high = if rest.is_zero() { high } else { high + BigInt::one() };
    Some(times(&above, &(low, high), precision))
}

fn times(one: &Range, other: &Range, precision: usize) -> Range {
    let products = [&one.0 * &other.0, &one.0 * &other.1, &one.1 * &other.0, &one.1 * &other.1];
    let least = products.iter().min().cloned().unwrap_or_default();
    let most = products.into_iter().max().unwrap_or_default();
    // A shift to the right goes down.
    (least >> precision, -(-most >> precision))
}
