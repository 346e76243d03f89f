//! Whether a run can be what a property asks for. Time is cut into ticks, the greatest common divisor of all durations
//! that are given. If durations fit at all, then those that begin and end at the tick before do, except that a stretch
//! with an observation may become empty, where it only has to touch what is shown (differences of real numbers keep
//! whole bounds when all are rounded down). So nothing that fits is missed, and only what cannot fit is refuted.

use std::collections::{BTreeMap, BTreeSet};

use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};

use super::{After, Asking, Lasso, Sight, Stretch};
use crate::name::Name;
use crate::period::Test;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};
use crate::verify::property::{Length, Want, Wanted};

/// Ticks of a run, and of a property's segment, that are looked at.
const MOST_TICKS: u64 = 100_000;
/// Places in the property looked at, over all ticks.
const MOST_PLACES: usize = 4_000_000;

/// Where the last attempt to fit the property to the run ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misfit {
    /// Nothing fits beyond this time.
    pub time: BigRational,
    /// What is asked for then, in one of the attempts that come so far.
    pub asked: String,
    /// What is shown then; nothing where the run has ended.
    pub shown: Option<Vec<String>>,
    /// Whether the run only repeats from then on, and each of its rounds fits for itself, but not for ever.
    pub repeats: bool,
}

/// A segment of the property.
struct Asked {
    /// The fewest and the most ticks; no most where it may last as long as one likes.
    least: u64,
    most: Option<u64>,
    endless: bool,
    shown: Vec<Asking>,
    text: String,
}

/// A place in the property: a segment, and the ticks passed in it.
type Place = (usize, u64);

/// Why the property cannot be met by the run, whatever the durations; nothing where it may be, or it is not known.
pub fn misfit(lasso: &Lasso, wanted: &Wanted, values: &BTreeMap<Name, Value>) -> Option<Misfit> {
    let round = match &lasso.after {
        After::Round(round) => round.as_slice(),
        _ => &[],
    };
    let durations = lasso.stretches.iter().chain(round).map(|stretch| stretch.duration.clone());
    let tests: Vec<Test> = wanted.wants.iter().flat_map(|want| want.tests.iter().cloned()).collect();
    let given = wanted.wants.iter().flat_map(|want| given(want, &tests, values));
    let tick = durations.chain(given).filter(|time| time.is_positive()).reduce(common)?;
    let asked: Vec<Asked> =
        wanted.wants.iter().map(|want| asked(want, &tests, values, &tick)).collect::<Option<_>>()?;
    let first = cells(&lasso.stretches, &tick)?;
    let again = cells(round, &tick)?;
    let search = Search { asked: &asked, again: wanted.again, tick: &tick };
    search.fits(&first, &again, &lasso.after).err()
}

fn common(one: BigRational, two: BigRational) -> BigRational {
    let below = one.denom().lcm(two.denom());
    let whole = |number: &BigRational| number.numer() * (&below / number.denom());
    BigRational::new(whole(&one).gcd(&whole(&two)), below)
}

fn number(value: &Value, values: &BTreeMap<Name, Value>) -> Option<BigRational> {
    value.substitute(values).ok()?.as_rational()
}

/// The numbers that durations are compared with.
fn given(want: &Want, tests: &[Test], values: &BTreeMap<Name, Value>) -> Vec<BigRational> {
    let length = match &want.length {
        Length::Known(value) => number(value, values),
        _ => None,
    };
    length.into_iter().chain(bounds(want, tests, values).into_iter().map(|(_, bound)| bound)).collect()
}

/// The conditions on the duration of a segment alone. Others are passed over: nothing is refuted by them.
fn bounds(want: &Want, tests: &[Test], values: &BTreeMap<Name, Value>) -> Vec<(Relation, BigRational)> {
    let Length::Unknown(own) = &want.length else { return Vec::new() };
    let own = Value::variable(own);
    tests
        .iter()
        .filter_map(|test| match (test.left == own, test.right == own) {
            (true, false) => Some((test.relation, number(&test.right, values)?)),
            (false, true) => Some((test.relation.mirrored(), number(&test.left, values)?)),
            _ => None,
        })
        .collect()
}

fn asked(want: &Want, tests: &[Test], values: &BTreeMap<Name, Value>, tick: &BigRational) -> Option<Asked> {
    let ticks = |time: &BigRational| (time / tick).to_integer().to_u64().filter(|ticks| *ticks <= MOST_TICKS);
    let mut asked = Asked { least: 0, most: None, endless: false, shown: Vec::new(), text: String::new() };
    match &want.length {
        Length::Endless => asked.endless = true,
        Length::Unknown(_) => {}
        Length::Known(value) => {
            let time = number(value, values)?;
            asked.least = ticks(&time).filter(|_| !time.is_negative())?;
            asked.most = Some(asked.least);
        }
    }
    for (relation, bound) in bounds(want, tests, values) {
        if bound.is_negative() {
            return None;
        }
        let bound = ticks(&bound)?;
        if matches!(relation, Relation::Gtr | Relation::Gte | Relation::Eq) {
            asked.least = asked.least.max(bound);
        }
        if matches!(relation, Relation::Lss | Relation::Lte | Relation::Eq) {
            asked.most = Some(asked.most.map_or(bound, |most| most.min(bound)));
        }
    }
    for term in &want.shown {
        asked.shown.push(Asking::of(term, tests, values)?);
    }
    let names: Vec<String> = want.shown.iter().map(Term::to_string).collect();
    asked.text = names.join(" with ");
    Some(asked)
}

/// One entry for each tick.
fn cells<'s>(stretches: &'s [Stretch], tick: &BigRational) -> Option<Vec<&'s BTreeSet<Sight>>> {
    let mut cells = Vec::new();
    for stretch in stretches {
        let ticks = (&stretch.duration / tick).to_integer().to_usize()?;
        if cells.len() + ticks > MOST_TICKS as usize {
            return None;
        }
        cells.extend(std::iter::repeat_n(&stretch.shown, ticks));
    }
    Some(cells)
}

struct Search<'s> {
    asked: &'s [Asked],
    again: bool,
    tick: &'s BigRational,
}

/// Places reached, and whether a segment was left, or an endless one gone on with, since the round began.
type Reached = BTreeSet<(Place, bool)>;

impl Search<'_> {
    /// # Errors
    /// Where nothing fits any more.
    fn fits(&self, first: &[&BTreeSet<Sight>], again: &[&BTreeSet<Sight>], after: &After) -> Result<(), Misfit> {
        let mut reached: Reached = [((0, 0), false)].into();
        let mut work = 0;
        for (position, cell) in first.iter().enumerate() {
            let before = position.checked_sub(1).map(|position| first[position]);
            self.leave(&mut reached, &[Some(*cell), before]);
            work += reached.len();
            if work > MOST_PLACES || reached.iter().any(|(place, _)| self.done(*place)) {
                return Ok(());
            }
            let next = self.pass(&reached, cell);
            if next.is_empty() {
                return Err(self.at(position, &reached, Some(cell)));
            }
            reached = next;
        }
        let last = first.last().copied();
        match after {
            After::Unknown => Ok(()),
            After::End | After::TimeStop => {
                self.leave(&mut reached, &[last]);
                let done = reached.iter().any(|(place, _)| self.done(*place));
                if done { Ok(()) } else { Err(self.at(first.len(), &reached, None)) }
            }
            After::Round(_) => self.goes_on(&reached, last, again, work, first.len()),
        }
    }

    /// Whether some place at the start of the round comes back to itself, with something of the property done.
    fn goes_on(
        &self,
        start: &Reached,
        last: Option<&BTreeSet<Sight>>,
        again: &[&BTreeSet<Sight>],
        mut work: usize,
        since: usize,
    ) -> Result<(), Misfit> {
        let mut edges: BTreeMap<Place, Reached> = BTreeMap::new();
        // What is shown just before the first round is touched at its start, and not again.
        let mut start = start.clone();
        self.leave(&mut start, &[again.first().copied(), last]);
        if start.iter().any(|(place, _)| self.done(*place)) {
            return Ok(());
        }
        let mut open: Vec<Place> = start.iter().map(|(place, _)| *place).collect();
        while let Some(place) = open.pop() {
            if edges.contains_key(&place) {
                continue;
            }
            let mut reached: Reached = [(place, false)].into();
            for (position, cell) in again.iter().enumerate() {
                let before =
                    position.checked_sub(1).map_or(again.last().copied(), |position| again.get(position).copied());
                self.leave(&mut reached, &[Some(*cell), before]);
                work += reached.len();
                if work > MOST_PLACES || reached.iter().any(|(place, _)| self.done(*place)) {
                    return Ok(());
                }
                reached = self.pass(&reached, cell);
            }
            open.extend(reached.iter().map(|(place, _)| *place));
            edges.insert(place, reached);
        }
        let comes_back = |from: Place, to: Place| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
            while let Some(place) = open.pop() {
                if place == to {
                    return true;
                }
                if seen.insert(place) {
                    open.extend(edges.get(&place).into_iter().flatten().map(|(next, _)| *next));
                }
            }
            false
        };
        let forever = edges
            .iter()
            .any(|(place, next)| next.iter().any(|(next, progress)| *progress && comes_back(*next, *place)));
        if forever { Ok(()) } else { Err(Misfit { repeats: true, ..self.at(since, &start, again.first().copied()) }) }
    }

    fn done(&self, place: Place) -> bool {
        place.0 == self.asked.len()
    }

    /// Adds the places that are reached by leaving segments, where these may end now: `near` is what is shown just
    /// before and just after.
    fn leave(&self, reached: &mut Reached, near: &[Option<&BTreeSet<Sight>>]) {
        let mut open: Vec<(Place, bool)> = reached.iter().copied().collect();
        while let Some(((number, ticks), _)) = open.pop() {
            let Some(asked) = self.asked.get(number) else { continue };
            let touches = asked.shown.is_empty() || near.iter().flatten().any(|cell| asked.is_shown(cell));
            if asked.endless || ticks < asked.least || !(touches || asked.most == Some(0)) {
                continue;
            }
            let next = if number + 1 == self.asked.len() && self.again { 0 } else { number + 1 };
            let place = ((next, 0), true);
            if reached.insert(place) {
                open.push(place);
            }
        }
    }

    /// One tick, in which this is shown.
    fn pass(&self, reached: &Reached, cell: &BTreeSet<Sight>) -> Reached {
        let mut next = Reached::new();
        for ((number, ticks), progress) in reached {
            let Some(asked) = self.asked.get(*number) else { continue };
            if asked.is_shown(cell) && asked.most.is_none_or(|most| *ticks < most) {
                // Beyond what is compared the ticks need not be counted.
                let counted = asked.most.unwrap_or(asked.least).max(asked.least);
                next.insert(((*number, (ticks + 1).min(counted)), *progress || asked.endless));
            }
        }
        next
    }

    fn at(&self, position: usize, reached: &Reached, cell: Option<&BTreeSet<Sight>>) -> Misfit {
        let time = self.tick * BigRational::from_integer(position.into());
        let furthest = reached.iter().map(|((number, _), _)| *number).max().unwrap_or(0);
        let asked = self.asked.get(furthest).map(|asked| asked.text.clone()).unwrap_or_default();
        let text = |(name, values): &Sight| match values {
            Some(values) => Term::new(Node::Observe(name.clone(), values.clone())).to_string(),
            None => name.to_string(),
        };
        Misfit { time, asked, shown: cell.map(|cell| cell.iter().map(text).collect()), repeats: false }
    }
}

impl Asked {
    fn is_shown(&self, cell: &BTreeSet<Sight>) -> bool {
        self.shown.iter().all(|asking| cell.iter().any(|(name, values)| asking.may_be(name, values.as_deref())))
    }
}
