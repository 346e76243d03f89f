//! Bounds that rounds keep: of each variable by itself, as far as it swings, and those that a claim needs of what is before it.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{FromPrimitive, Signed, ToPrimitive, Zero};

use crate::assumption::Assumptions;
use crate::invariant::cases::conjunctions;
use crate::invariant::{follows, premises, support};
use crate::name::Name;
use crate::period::{Edge, Next, Period, Test};
use crate::simplest::simplest;
use crate::value::{Relation, Value};

/// Rounds that are followed to find out how far variables swing, and where one is taken to go on for ever.
const MOST_ROUNDS: usize = 1_000;
const FARTHEST: f64 = 1e9;
/// How close what was found is to where it is taken to come to, as a part of it.
const CLOSE: f64 = 1e-7;
/// The most variables of all phases.
const MOST_VARIABLES: usize = 40;
/// How many rounds a claim is carried back, and to how many tests of a phase.
const MOST_BACK: usize = 10;
const MOST_TESTS: usize = 16;
/// The longest of these tests, in nodes: through clamps they have three times as many cases each round.
const LONGEST: usize = 300;

/// The numbers between which a variable lies.
type Range = (f64, f64);
/// Those of the variables of a phase, if it is entered.
type Ranges = Option<BTreeMap<Name, Range>>;

/// For each phase bounds of its variables: how far they swing from the start on, if each goes its own way, and a little
/// more. They are guesses, in machine numbers; what is wrong of them is left out where they are checked.
pub(super) fn ranges(period: &Period) -> Vec<BTreeSet<Test>> {
    let mut found: Vec<Ranges> = vec![None; period.phases.len()];
    if period.phases.iter().map(|phase| phase.variables.len()).sum::<usize>() <= MOST_VARIABLES {
        for _ in 0..MOST_ROUNDS {
            if !widened(period, &mut found) {
                break;
            }
        }
    }
    found.iter().map(|ranges| ranges.iter().flatten().flat_map(|(name, range)| tests(name, *range)).collect()).collect()
}

/// The ranges after one round more; whether any has grown.
fn widened(period: &Period, found: &mut [Ranges]) -> bool {
    let mut grown = false;
    let none = BTreeMap::new();
    let starts = period.initial.iter().map(|edge| (edge, none.clone()));
    let rounds = period.phases.iter().zip(found.iter().cloned());
    let rounds = rounds.filter_map(|(phase, ranges)| Some((phase, ranges?)));
    let rounds = rounds.flat_map(|(phase, ranges)| phase.edges.iter().map(move |edge| (edge, ranges.clone())));
    for (edge, mut before) in starts.chain(rounds).collect::<Vec<_>>() {
        let Next::Phase(next) = edge.next else { continue };
        let drawn = edge.draws.iter().flat_map(|(name, from)| support(name, from));
        before.extend(edge.draws.iter().map(|(name, _)| (name.clone(), (f64::NEG_INFINITY, f64::INFINITY))));
        let asked = edge.tests.iter().cloned().chain(drawn);
        if !asked.into_iter().all(|test| clipped(&test, &mut before)) {
            continue;
        }
        let images = edge.map.iter().map(|(name, image)| (name.clone(), range_of(image, &before)));
        let mut images: BTreeMap<Name, Range> = images.collect();
        edge.after.iter().flatten().for_each(|test| _ = clipped(test, &mut images));
        let Some(here) = found.get_mut(next) else { continue };
        let here = here.get_or_insert_with(BTreeMap::new);
        for (name, (low, high)) in images {
            let known = here.entry(name).or_insert((f64::INFINITY, f64::NEG_INFINITY));
            let far = |end: f64| if end.abs() > FARTHEST { end.signum() * f64::INFINITY } else { end };
            let more = (known.0.min(far(low)), known.1.max(far(high)));
            grown |= more != *known;
            *known = more;
        }
    }
    grown
}

/// A value as a sum of multiples of names and a number.
fn affine(value: &Value) -> Option<(BTreeMap<Name, f64>, f64)> {
    let mut rest = value.clone();
    let mut factors = BTreeMap::new();
    for name in value.variables() {
        let (factor, more) = rest.linear_in(&name)?;
        factors.insert(name, factor.as_rational()?.to_f64()?);
        rest = more;
    }
    Some((factors, rest.as_rational()?.to_f64()?))
}

/// Where a value lies if each name in it lies where it does.
fn range_of(value: &Value, names: &BTreeMap<Name, Range>) -> Range {
    let anywhere = (f64::NEG_INFINITY, f64::INFINITY);
    let Some((factors, rest)) = affine(value) else { return anywhere };
    factors.iter().filter(|(_, factor)| **factor != 0.0).fold((rest, rest), |(low, high), (name, factor)| {
        let (from, to) = names.get(name).copied().unwrap_or(anywhere);
        let ends = if *factor > 0.0 { (factor * from, factor * to) } else { (factor * to, factor * from) };
        (low + ends.0, high + ends.1)
    })
}

/// Makes the range of a variable as small as a test of it alone says; false where nothing is left.
fn clipped(test: &Test, names: &mut BTreeMap<Name, Range>) -> bool {
    let Some((factors, rest)) = test.left.sub(&test.right).ok().as_ref().and_then(affine) else { return true };
    let Some((name, factor)) = factors.iter().next().filter(|_| factors.len() == 1) else { return true };
    let Some(range) = names.get_mut(name) else { return true };
    let end = -rest / factor;
    let relation = if *factor > 0.0 { test.relation } else { test.relation.mirrored() };
    match relation {
        Relation::Gtr | Relation::Gte => range.0 = range.0.max(end),
        Relation::Lss | Relation::Lte => range.1 = range.1.min(end),
        Relation::Eq => *range = (range.0.max(end), range.1.min(end)),
        Relation::Neq => {}
    }
    range.0 <= range.1
}

/// That a variable lies within its range, and within a little more.
fn tests(name: &Name, (low, high): Range) -> Vec<Test> {
    let number = |one: f64, other: f64| {
        let ends = (BigRational::from_f64(one)?, BigRational::from_f64(other)?);
        Some(Value::rational(simplest(&ends.0, &ends.1)))
    };
    let mut found = Vec::new();
    let middle = if low.is_finite() && high.is_finite() { f64::midpoint(low, high) } else { 0.0 };
    for (end, relation) in [(low, Relation::Gte), (high, Relation::Lte)] {
        let close = CLOSE * end.abs().max(1.0);
        let away = (end - middle) / 100.0;
        let ends = [number(end - close, end + close), number(end + away, end + 2.0 * away)];
        let test = |right| Test { relation, left: Value::variable(name), right };
        found.extend(ends.into_iter().flatten().map(test));
    }
    found
}

/// For each phase what must hold there so that what is claimed does in the rounds that follow, whatever is drawn.
pub(super) fn carried_back(
    period: &Period,
    claimed: &[BTreeSet<Test>],
    assumptions: &Assumptions,
) -> Vec<BTreeSet<Test>> {
    let mut known: Vec<BTreeSet<Test>> = claimed.to_vec();
    let mut latest: Vec<BTreeSet<Test>> = claimed.to_vec();
    for _ in 0..MOST_BACK {
        let mut earlier: Vec<BTreeSet<Test>> = vec![BTreeSet::new(); known.len()];
        for (number, phase) in period.phases.iter().enumerate() {
            for edge in &phase.edges {
                let Next::Phase(next) = edge.next else { continue };
                for test in latest.get(next).into_iter().flatten() {
                    let before = before(test, edge).filter(|before| before.left.size() <= LONGEST);
                    let before = before.and_then(|before| conjunctions(&[before]).ok());
                    let before = before.into_iter().flatten().filter(|before| speaks(before, &phase.variables));
                    for before in before {
                        let own: Vec<Test> = known[number].iter().cloned().collect();
                        if own.len() < MOST_TESTS && !follows(assumptions, &premises(edge, &own), &before) {
                            known[number].insert(before.clone());
                            earlier[number].insert(before);
                        }
                    }
                }
            }
        }
        if earlier.iter().all(BTreeSet::is_empty) {
            break;
        }
        latest = earlier;
    }
    known.iter().zip(claimed).map(|(known, claimed)| known.difference(claimed).cloned().collect()).collect()
}

fn speaks(test: &Test, variables: &[Name]) -> bool {
    variables.iter().any(|name| test.left.mentions(name) || test.right.mentions(name))
}

/// What must hold before a way so that a test holds behind it, whatever is drawn: of what is drawn between two bounds that of
/// them counts which lets it hold least easily.
fn before(test: &Test, edge: &Edge) -> Option<Test> {
    let there = test.left.sub(&test.right).ok()?.substitute(&edge.map).ok()?;
    let upper = matches!(test.relation, Relation::Gtr | Relation::Gte);
    let mut left = there;
    for (name, from) in edge.draws.iter().rev() {
        let (factor, rest) = left.linear_in(name)?;
        let factor: BigRational = factor.as_rational()?;
        if factor.is_zero() {
            continue;
        }
        let side = if factor.is_positive() == upper { Relation::Gte } else { Relation::Lte };
        let bounds = support(name, from);
        let bound = bounds.iter().find(|bound| bound.relation == side || bound.relation == Relation::Eq)?;
        left = rest.add(&bound.right.mul(&Value::rational(factor)).ok()?).ok()?;
    }
    (test.relation != Relation::Neq).then_some(Test { relation: test.relation, left, right: Value::zero() })
}
