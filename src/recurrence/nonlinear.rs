//! What is still known of a sequence without closed form: its first terms, its fixed points, how it moves.

use std::fmt;

use num_rational::BigRational;
use num_traits::Signed;

use super::fixed::{Place, atoms, fixed_points};
use super::stationary::{Stationary, stationary};
use super::terms::{Term, ended, listed};
use crate::assumption::Assumptions;
use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// What is known of a recurrence, closed form or not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Behaviour {
    /// The first terms of each sequence, as far as they were computed.
    pub terms: Vec<Vec<Term>>,
    /// The term that there is not any more, and why, where that is so among the first.
    pub ended: Option<(String, String)>,
    /// The values that are mapped to themselves, of a single map that does not depend on the index: those that are rational
    /// or roots of a quadratic polynomial.
    pub fixed_points: Vec<Value>,
    /// Between which two numbers each other one lies, where that is known.
    pub other_fixed_points: Option<Vec<(BigRational, BigRational)>>,
    /// Of other maps, of several sequences too, all points that are mapped to themselves, where they are found.
    pub stationary: Option<Vec<Stationary>>,
    /// How the sequence moves, if that is known.
    pub motion: Option<String>,
    /// Whether fewer terms are listed than are asked for, though there are more.
    pub stopped: bool,
}

/// How many terms are listed.
const LISTED: usize = 20;
/// What is known without a closed form.
pub fn behaviour(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Behaviour {
    let terms = listed(recurrence, LISTED, known, stop);
    let short = terms.iter().all(|terms| terms.len() < LISTED);
    let ended = if short { ended(recurrence, &terms) } else { None };
    let stopped = short && ended.is_none();
    let mut result = Behaviour { terms, ended, stopped, ..Behaviour::default() };
    let of_numbers = single(recurrence).and_then(|(map, name, _)| Some((map, fixed_points(map, &name)?, name)));
    let Some((map, (points, others), name)) = of_numbers else {
        result.stationary = stationary(recurrence, known);
        return result;
    };
    let starts = std::iter::successors(Some(recurrence.clone()), later).take(1 + LATER_STARTS);
    result.motion = starts.into_iter().find_map(|here| {
        let (_, _, start) = single(&here)?;
        let text = motion(map, &name, start, (&points, others.as_deref()), known)?.text(start);
        Some(if here.from == recurrence.from { text } else { format!("from {} = {} on {text}", here.index, here.from) })
    });
    (result.fixed_points, result.other_fixed_points) = (points, others);
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
    let (points, others) = fixed_points(map, &name)?;
    motion(map, &name, start, (&points, others.as_deref()), known)
}

/// A sequence that moves one way only.
pub(super) enum Motion {
    /// It is at a fixed point.
    Stays,
    /// It grows (else falls) in every step, and closes in on the bound, which it does not reach; without one it goes beyond
    /// every number.
    Moves { grows: bool, bound: Option<FixedPoint> },
}

/// A fixed point.
#[derive(Clone)]
pub(super) enum FixedPoint {
    At(Value),
    /// A root of higher degree, between these.
    Between(Place),
}

impl FixedPoint {
    /// The number itself, or one a little beyond it, seen from below or from above.
    pub(super) fn beyond(&self, from_below: bool) -> Value {
        match self {
            FixedPoint::At(value) => value.clone(),
            FixedPoint::Between((low, high)) => Value::rational(if from_below { high.clone() } else { low.clone() }),
        }
    }
}

impl fmt::Display for FixedPoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FixedPoint::At(value) => write!(f, "{value}"),
            FixedPoint::Between(place) => write!(f, "{}", near(place)),
        }
    }
}

/// A number between two decimals that follow each other, as `≈` and the decimal next to 0.
pub fn near((low, high): &Place) -> String {
    let nearest = if low.is_negative() { high } else { low };
    let digits = (high - low).recip().to_integer().to_string().len() - 1;
    let scaled = (nearest.abs() * (high - low).recip()).to_integer().to_string();
    let padded = format!("{scaled:0>width$}", width = digits + 1);
    let (whole, rest) = padded.split_at(padded.len() - digits);
    format!("≈{}{whole}.{rest}…", if low.is_negative() { "-" } else { "" })
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

/// A map that does not fall between the start and the next fixed point on the side to which it goes moves what begins
/// there one way only: what lies between the two stays between them. It has to be continuous there.
fn motion(
    map: &Value,
    name: &Name,
    start: &Value,
    (points, others): (&[Value], Option<&[Place]>),
    known: &Assumptions,
) -> Option<Motion> {
    if points.iter().any(|point| known.decide(Relation::Eq, start, point) == Some(true)) {
        return Some(Motion::Stays);
    }
    let exact = points.iter().cloned().map(FixedPoint::At);
    let all: Vec<FixedPoint> = exact.chain(others?.iter().cloned().map(FixedPoint::Between)).collect();
    // On which side of a point it begins; where that is not known, the point may be the next one.
    let above = |point: &FixedPoint| {
        let beyond = |side, from_below| known.decide(side, start, &point.beyond(from_below)) == Some(true);
        if beyond(Relation::Lss, false) { Some(true) } else { beyond(Relation::Gtr, true).then_some(false) }
    };
    if jumps(map, name) || !all.iter().all(|point| above(point).is_some()) {
        return None;
    }
    let grows = known.decide(Relation::Gtr, &map.with(name, start).ok()?, start)?;
    let mut next: Option<&FixedPoint> = None;
    for point in all.iter().filter(|point| above(point) == Some(grows)) {
        let nearer = if grows { Relation::Lss } else { Relation::Gtr };
        let before = |other: &FixedPoint| known.decide(nearer, &point.beyond(grows), &other.beyond(!grows));
        match next.map(before) {
            None | Some(Some(true)) => next = Some(point),
            Some(_) => {
                // Of two of which it is not known which is nearer nothing is said.
                let other = next?;
                known.decide(nearer, &other.beyond(grows), &point.beyond(!grows)).filter(|nearer| *nearer)?;
            }
        }
    }
    let bound = next.map(|point| point.beyond(grows));
    let (least, most) = if grows { (Some(start), bound.as_ref()) } else { (bound.as_ref(), Some(start)) };
    Stretch::new(known, name, least, most).rises(map)?.then(|| Motion::Moves { grows, bound: next.cloned() })
}

/// Whether a map may jump or have no value somewhere: a condition or a whole part stands in it, however deep, that depends
/// on the variable, or in a maximum a root or a divisor, which nobody asks whether it is defined.
fn jumps(map: &Value, name: &Name) -> bool {
    let undefined = |part: &Value| {
        let root = atoms(part, name).iter().any(|atom| matches!(atom, Atom::Root(_)));
        root || part.denominator().is_none_or(|below| below.mentions(name))
    };
    atoms(map, name).iter().any(|atom| match atom {
        Atom::Positive(_) | Atom::Floor(_) | Atom::Apply(..) | Atom::Power(..) => true,
        Atom::Maximum(parts) => parts.iter().any(|part| undefined(part) || jumps(part, name)),
        Atom::Root(inner) => jumps(inner, name),
        Atom::Variable(_) => false,
    })
}

/// Two places on a stretch of numbers, of which it is known that the second lies beyond the first.
struct Stretch<'a> {
    name: &'a Name,
    least: Option<&'a Value>,
    place: Value,
    beyond: Value,
    gap: Value,
    known: Assumptions,
}

impl<'a> Stretch<'a> {
    fn new(known: &Assumptions, name: &'a Name, least: Option<&'a Value>, most: Option<&Value>) -> Stretch<'a> {
        let [place, gap] = ["[u]", "[gap]"].map(|name| Value::variable(&Name::new(name)));
        let beyond = place.add(&gap).unwrap_or_else(|_| place.clone());
        let mut between = known.clone();
        between.assume(Relation::Gtr, &gap, &Value::zero());
        if let Some(least) = least {
            between.assume(Relation::Gte, &place, least);
        }
        if let Some(most) = most {
            between.assume(Relation::Lte, &beyond, most);
        }
        Stretch { name, least, place, beyond, gap, known: between }
    }

    /// Whether a value is continuous and grows with the variable all along, as far as that is known: by itself, or as a
    /// root of what grows, and a rest that does not fall.
    fn rises(&self, value: &Value) -> Option<bool> {
        let roots: Vec<Atom> = atoms(value, self.name).into_iter().filter(|one| matches!(one, Atom::Root(_))).collect();
        match roots.as_slice() {
            [] => self.steeper(value, !atoms(value, self.name).is_empty()),
            [root @ Atom::Root(inner)] => {
                let mark = Name::new("[root]");
                let (factor, rest) = value.with_atom(root, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
                let first = self.least.unwrap_or(&self.place);
                let defined = self.known.decide(Relation::Gte, &inner.with(self.name, first).ok()?, &Value::zero());
                let grows =
                    self.known.decide(Relation::Gtr, &factor, &Value::zero())? && defined? && self.rises(inner)?;
                Some(grows && (!rest.mentions(self.name) || self.steeper(&rest, false)?))
            }
            _ => None,
        }
    }

    /// For u < v on the stretch: (value(v) - value(u))/(v - u) >= 0, or > 0 if it is asked for `strictly`; a quotient of
    /// polynomials that is not constant grows where it does not fall. Nothing where it may not be defined.
    fn steeper(&self, value: &Value, strictly: bool) -> Option<bool> {
        let [here, there] = [&self.place, &self.beyond].map(|place| value.with(self.name, place));
        let slope = there.ok()?.sub(&here.ok()?).ok()?.div(&self.gap).ok()?;
        let below = value.denominator()?.with(self.name, &self.place).ok()?;
        let defined = self.known.decide(Relation::Neq, &below, &Value::zero())?;
        let relation = if strictly { Relation::Gtr } else { Relation::Gte };
        Some(defined && self.known.decide(relation, &slope, &Value::zero())?)
    }
}
