//! Half planes that a run stays within: of what guards and clamps compare, and of pairs of variables, such as the speed and
//! the place of a cart whose acceleration is limited.
//!
//! They are guesses, of the run in machine numbers as far as it is followed; what is wrong of them is left out where they
//! are checked.

use std::collections::{BTreeMap, BTreeSet};

use num_rational::BigRational;
use num_traits::{FromPrimitive, ToPrimitive, Zero};

use crate::name::Name;
use crate::period::{Edge, Next, Period, Phase, Test};
use crate::polynomial::Polynomial;
use crate::simplest::simplest;
use crate::value::{Atom, Relation, Sort, Value};

/// Rounds that are followed, and how far values may go.
const MOST_ROUNDS: usize = 2_000;
const FARTHEST: f64 = 1e9;
/// The most variables of a phase: of one alone `ranges` tells.
const MOST_VARIABLES: usize = 3;
/// The most directions in which a phase is bounded.
const MOST_DIRECTIONS: usize = 14;
/// How far beyond what was seen a bound may lie, as parts of what was seen.
const BEYOND: [f64; 3] = [0.0, 0.1, 1.0];
/// How close what was seen is to where it is taken to come to.
const CLOSE: f64 = 1e-7;
/// By what one variable counts beside another.
const FACTORS: [(i64, i64); 3] = [(1, 2), (1, 1), (2, 1)];

/// Where a run is, in machine numbers.
type Place = BTreeMap<Name, f64>;

/// For each phase half planes that hold in the run as far as it was followed, and some that lie beyond; none of a run that
/// draws, or has symbols.
pub(super) fn swings(period: &Period) -> Vec<BTreeSet<Test>> {
    let nothing = || vec![BTreeSet::new(); period.phases.len()];
    if !period.phases.iter().any(|phase| (2..=MOST_VARIABLES).contains(&phase.variables.len())) {
        return nothing();
    }
    let Some(seen) = followed(period) else { return nothing() };
    let of = |(phase, seen): (&Phase, &Vec<Place>)| {
        if seen.is_empty() || !(2..=MOST_VARIABLES).contains(&phase.variables.len()) {
            return BTreeSet::new();
        }
        directions(phase).iter().flat_map(|direction| bounds(direction, seen)).collect()
    };
    period.phases.iter().zip(&seen).map(of).collect()
}

/// The places of each phase at which the run is, round after round.
fn followed(period: &Period) -> Option<Vec<Vec<Place>>> {
    let mut seen: Vec<Vec<Place>> = vec![Vec::new(); period.phases.len()];
    let (mut phase, mut place) = step(&period.initial, &Place::new())??;
    for _ in 0..MOST_ROUNDS {
        seen.get_mut(phase)?.push(place.clone());
        let Some(next) = step(&period.phases.get(phase)?.edges, &place)? else { break };
        (phase, place) = next;
        if place.values().any(|value| value.is_nan() || value.abs() > FARTHEST) {
            break;
        }
    }
    Some(seen)
}

/// Where the first way leads that is taken; nothing inside where that is no phase, and none where it is not known.
fn step(edges: &[Edge], place: &Place) -> Option<Option<(usize, Place)>> {
    for edge in edges {
        let mut taken = edge.draws.is_empty().then_some(true)?;
        for test in &edge.tests {
            let order = value_at(&test.left, place)?.partial_cmp(&value_at(&test.right, place)?)?;
            taken &= test.relation.holds(order);
        }
        if taken {
            let Next::Phase(next) = edge.next else { return Some(None) };
            let image = edge.map.iter().map(|(name, image)| Some((name.clone(), value_at(image, place)?)));
            return Some(Some((next, image.collect::<Option<Place>>()?)));
        }
    }
    Some(None)
}

fn value_at(value: &Value, place: &Place) -> Option<f64> {
    let (numerator, denominator) = value.polynomials().filter(|_| value.sort() == Sort::Real)?;
    let sum = |polynomial: &Polynomial<Atom>| {
        polynomial.terms().iter().try_fold(0.0, |sum, (monomial, number)| {
            let product = monomial.factors().iter().try_fold(number.to_f64()?, |product, (atom, exponent)| {
                Some(product * atom_at(atom, place)?.powi(i32::try_from(*exponent).ok()?))
            });
            Some(sum + product?)
        })
    };
    Some(sum(numerator)? / sum(denominator)?)
}

fn atom_at(atom: &Atom, place: &Place) -> Option<f64> {
    match atom {
        Atom::Variable(name) => place.get(name).copied(),
        Atom::Maximum(parts) => parts.iter().try_fold(0.0, |most: f64, part| Some(most.max(value_at(part, place)?))),
        Atom::Positive(inner) => Some(f64::from(u8::from(value_at(inner, place)? > 0.0))),
        Atom::Root(inner) => Some(value_at(inner, place)?.sqrt()),
        Atom::Floor(inner) => Some(value_at(inner, place)?.floor()),
        Atom::Power(..) | Atom::Apply(..) => None,
    }
}

/// Sums of multiples of variables in which a phase may be bounded: what is compared in it, each variable, and pairs.
fn directions(phase: &Phase) -> Vec<Value> {
    let mut found: Vec<Value> = phase.variables.iter().map(Value::variable).collect();
    let tests = phase.edges.iter().flat_map(|edge| &edge.tests).filter_map(|test| test.left.sub(&test.right).ok());
    let images = phase.edges.iter().flat_map(|edge| edge.map.values().cloned());
    let mut compared: Vec<Value> = tests.clone().collect();
    tests.chain(images).for_each(|value| inside(&value, &mut compared));
    found.extend(compared.iter().filter_map(|value| without_constant(value, &phase.variables)));
    for (number, one) in phase.variables.iter().enumerate() {
        for other in &phase.variables[number + 1..] {
            let pairs = FACTORS.iter().flat_map(|(above, below)| [(*above, *below), (-above, *below)]);
            found.extend(pairs.filter_map(|(above, below)| {
                let part = Value::variable(one).mul(&Value::fraction(above, below).ok()?).ok()?;
                Value::variable(other).add(&part).ok()
            }));
        }
    }
    let mut seen = BTreeSet::new();
    found.retain(|direction| seen.insert(direction.clone()));
    found.truncate(MOST_DIRECTIONS);
    found
}

/// What maxima and conditions in a value compare with 0.
fn inside(value: &Value, found: &mut Vec<Value>) {
    for atom in value.atoms() {
        let parts: Vec<Value> = match &atom {
            Atom::Maximum(parts) => parts.to_vec(),
            Atom::Positive(part) => vec![part.clone()],
            _ => continue,
        };
        for part in parts {
            inside(&part, found);
            found.push(part);
        }
    }
}

/// A sum of multiples of at least two of the variables, without its constant; none of anything else.
fn without_constant(value: &Value, variables: &[Name]) -> Option<Value> {
    let (mut sum, mut rest, mut count) = (Value::zero(), value.clone(), 0);
    for name in variables {
        let (factor, more) = rest.linear_in(name)?;
        let number = factor.as_rational()?;
        count += usize::from(!number.is_zero());
        sum = sum.add(&Value::variable(name).scale(&number).ok()?).ok()?;
        rest = more;
    }
    (count > 1 && rest.as_rational().is_some()).then_some(sum)
}

/// Bounds of a sum of variables: about the least and the greatest that was seen, and beyond.
fn bounds(direction: &Value, seen: &[Place]) -> Vec<Test> {
    let values: Option<Vec<f64>> = seen.iter().map(|place| value_at(direction, place)).collect();
    let Some(values) = values else { return Vec::new() };
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let near = |end: f64| {
        let close = CLOSE * end.abs().max(1.0);
        let ends = (BigRational::from_f64(end - close)?, BigRational::from_f64(end + close)?);
        Some(Value::rational(simplest(&ends.0, &ends.1)))
    };
    let test = |relation: Relation, end: f64| Some(Test { relation, left: direction.clone(), right: near(end)? });
    let beyond = BEYOND.iter().map(|part| part * (high - low));
    beyond.flat_map(|more| [test(Relation::Gte, low - more), test(Relation::Lte, high + more)]).flatten().collect()
}
