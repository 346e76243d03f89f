//! What is still known of a sequence without closed form: its first terms, its fixed points, how it moves.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::terms::{Term, listed};
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::exponential_polynomial::exponentials;
use crate::name::Name;
use crate::univariate::Univariate;
use crate::value::{Relation, Value};

/// What is known of a recurrence, closed form or not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Behaviour {
    /// The first terms of each sequence, as far as they were computed.
    pub terms: Vec<Vec<Term>>,
    /// The values that are mapped to themselves, of a single map that does not depend on the index: those that are rational or roots of a
    /// quadratic polynomial.
    pub fixed_points: Vec<Value>,
    /// Whether these are all.
    pub all_fixed_points: bool,
    /// How the sequence moves, if that is known.
    pub motion: Option<String>,
}

/// The highest degree of a map whose fixed points are looked for.
const MOST_DEGREE: usize = 40;
/// How many terms are listed.
const LISTED: usize = 20;
/// What is known without a closed form.
pub fn behaviour(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Behaviour {
    let mut result = Behaviour { terms: listed(recurrence, LISTED, known, stop), ..Behaviour::default() };
    let Some((map, name, _)) = single(recurrence) else { return result };
    let Some((points, all)) = fixed_points(map, &name) else { return result };
    let starts = std::iter::successors(Some(recurrence.clone()), later).take(1 + LATER_STARTS);
    result.motion = starts.into_iter().find_map(|here| {
        let (_, _, start) = single(&here)?;
        let text = motion(map, &name, start, &points, all, known)?.text(start);
        Some(if here.from == recurrence.from { text } else { format!("from {} = {} on {text}", here.index, here.from) })
    });
    (result.fixed_points, result.all_fixed_points) = (points, all);
    result
}

/// How many terms after the start are looked at as starts.
pub(super) const LATER_STARTS: usize = 3;

/// A single sequence without its first term, which is a number.
pub(super) fn later(recurrence: &Recurrence) -> Option<Recurrence> {
    let (map, name, start) = single(recurrence)?;
    let next = map.with(&name, start).ok()?;
    next.as_rational()?;
    let mut later = recurrence.clone();
    later.from = recurrence.from.checked_add(1)?;
    later.sequences.first_mut()?.start = vec![next];
    Some(later)
}

/// The map, the variable and the start of a single sequence whose map does not depend on the index.
pub(super) fn single(recurrence: &Recurrence) -> Option<(&Value, Name, &Value)> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let ([start], false) = (sequence.start.as_slice(), sequence.next.mentions(&recurrence.index)) else { return None };
    Some((&sequence.next, recurrence.term(&sequence.name, 0), start))
}

/// How a single sequence moves, if it is known to move one way only.
pub(super) fn course(recurrence: &Recurrence, known: &Assumptions) -> Option<Motion> {
    let (map, name, start) = single(recurrence)?;
    let (points, all) = fixed_points(map, &name)?;
    motion(map, &name, start, &points, all, known)
}

/// A sequence that moves one way only.
pub(super) enum Motion {
    /// It is at a fixed point.
    Stays,
    /// It grows (else falls) in every step, and closes in on the bound, which it does not reach; without one it goes beyond
    /// every number.
    Moves { grows: bool, bound: Option<Value> },
}

impl Motion {
    fn text(&self, start: &Value) -> String {
        match self {
            Motion::Stays => format!("it stays {start}"),
            Motion::Moves { grows, bound } => {
                let (verb, way) = if *grows { ("grows", "below") } else { ("falls", "above") };
                match bound {
                    Some(bound) => {
                        format!("it {verb} in every step, stays {way} the fixed point {bound} and closes in on it")
                    }
                    None => format!("it {verb} in every step, without bound"),
                }
            }
        }
    }
}

/// The real fixed points of a map that is a quotient of polynomials with rational coefficients, in order, and whether these are all.
fn fixed_points(map: &Value, name: &Name) -> Option<(Vec<Value>, bool)> {
    let difference = map.sub(&Value::variable(name)).ok()?;
    let parts: Vec<_> = exponentials(&difference.numerator()?, name)?.into_iter().collect();
    let [(base, coefficients)] = parts.as_slice() else { return None };
    base.as_rational().filter(|base| *base == BigRational::from_integer(1.into()))?;
    let polynomial = Univariate::new(coefficients.iter().map(Value::as_rational).collect::<Option<_>>()?);
    if polynomial.degree() > MOST_DEGREE {
        return None;
    }
    let mut points = Vec::new();
    let mut all = true;
    for (factor, _) in polynomial.factors() {
        match factor.degree() {
            1 => points.push(Value::rational(-factor.coefficient(0))),
            2 => {
                let (middle, square) = crate::exponential_polynomial::middle_and_square(&factor);
                if square.is_positive() {
                    let distance = Value::rational(square).sqrt().ok()?;
                    let middle = Value::rational(middle);
                    points.push(middle.sub(&distance).ok()?);
                    points.push(middle.add(&distance).ok()?);
                }
            }
            _ => all = false,
        }
    }
    let none = Assumptions::default();
    let mut sorted: Vec<Value> = Vec::new();
    for point in points {
        let place = sorted.iter().position(|other| none.decide(Relation::Lss, &point, other) == Some(true));
        sorted.insert(place.unwrap_or(sorted.len()), point);
    }
    Some((sorted, all))
}

/// A map that does not fall between the start and the next fixed point on the side to which it goes moves what begins
/// there one way only: what lies between the two stays between them.
fn motion(map: &Value, name: &Name, start: &Value, points: &[Value], all: bool, known: &Assumptions) -> Option<Motion> {
    if points.iter().any(|point| known.decide(Relation::Eq, start, point) == Some(true)) {
        return Some(Motion::Stays);
    }
    if !all || map.denominator()?.as_rational().is_none_or(|number| number.is_zero()) {
        return None;
    }
    let grows = known.decide(Relation::Gtr, &map.with(name, start).ok()?, start)?;
    let low = points.iter().rev().find(|point| known.decide(Relation::Lss, point, start) == Some(true));
    let high = points.iter().find(|point| known.decide(Relation::Gtr, point, start) == Some(true));
    let bound = if grows { high } else { low };
    let (least, most) = if grows { (Some(start), bound) } else { (bound, Some(start)) };
    // For u < v within the bounds the map must not fall: (map(v) - map(u))/(v - u) >= 0.
    let (u, gap) = (Name::new("[u]"), Name::new("[gap]"));
    let (one, step) = (Value::variable(&u), Value::variable(&gap));
    let other = one.add(&step).ok()?;
    let slope = map.with(name, &other).ok()?.sub(&map.with(name, &one).ok()?).ok()?.div(&step).ok()?;
    let mut between = known.clone();
    between.assume(Relation::Gtr, &step, &Value::zero());
    if let Some(least) = least {
        between.assume(Relation::Gte, &one, least);
    }
    if let Some(most) = most {
        between.assume(Relation::Lte, &other, most);
    }
    if between.decide(Relation::Gte, &slope, &Value::zero()) != Some(true) {
        return None;
    }
    Some(Motion::Moves { grows, bound: bound.cloned() })
}
