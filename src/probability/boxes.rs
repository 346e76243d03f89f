//! Chances of systems that draw a few numbers in all, whatever is asked of them: the numbers are followed box by box.
//!
//! In a box each number lies in a range of known chance. Interval arithmetic tells whether a test holds of all of a box or
//! of none; where it tells neither, the box is halved. What is still open in the end, and the numbers beyond all ranges,
//! may count or not: the chance lies between that of the boxes in which it surely happens and that with all open ones.

mod form;
mod range;

use std::cmp::Ordering;
use std::collections::{BTreeMap, BinaryHeap};

use form::Look;
use num_rational::BigRational;
use num_traits::Signed;
use range::{Range, beyond, ranges};

use super::{Enclosed, Question};
use crate::distribution::Distribution;
use crate::interval::Interval;
use crate::invariant::Claim;
use crate::name::Name;
use crate::period::{Edge, End, Next, Period, Test};
use crate::term::Term;
use crate::value::{Relation, Value, ValueError};

/// Numbers that are drawn on one way.
const MOST_DRAWS: usize = 3;
/// Ways through rounds that are followed.
const MOST_WAYS: usize = 3_000;
/// Boxes that are looked at, with so many numbers.
const MOST_BOXES: [usize; MOST_DRAWS] = [20_000, 400_000, 150_000];
/// The chance that may stay open, and that is too much.
const ENOUGH: f64 = 1e-14;
const WIDE: f64 = 1e-3;

/// What is shown for a while: when it is in time, and in which cases it is what is asked for.
struct Showing {
    timely: Vec<Look>,
    cases: Vec<Vec<Look>>,
    /// What must hold for the question to have a meaning of it.
    needs: Vec<Look>,
}

/// One way through a round, and what came before it.
struct Way {
    /// What must hold for the tests to have a meaning.
    first: Vec<Look>,
    /// When it is taken.
    tests: Vec<Look>,
    /// What must hold for all else on it to have a meaning.
    then: Vec<Look>,
    /// What is shown on it, in order.
    shown: Vec<Showing>,
    /// What comes after it; none at the end.
    after: Option<State>,
    /// What is drawn on it.
    draws: Vec<Vec<Range>>,
    /// The ways behind it, once they are known.
    onward: Option<Vec<usize>>,
}

/// Where a phase is come to.
#[derive(Clone)]
struct State {
    phase: usize,
    /// The variables, over what was drawn.
    values: BTreeMap<Name, Value>,
    time: Value,
    names: Vec<Name>,
    /// When there is still time.
    timely: Vec<Look>,
}

/// How values of a way read over what was drawn.
struct Reading {
    values: BTreeMap<Name, Value>,
    names: Vec<Name>,
}

impl Reading {
    fn value(&self, value: &Value) -> Result<Value, String> {
        value.substitute(&self.values).map_err(odd)
    }

    fn look(&self, test: &Test) -> Result<Look, String> {
        let (left, right) = (self.value(&test.left)?, self.value(&test.right)?);
        Look::of(&Test { relation: test.relation, left, right }, &self.names)
    }

    fn looks<'t>(&self, tests: impl IntoIterator<Item = &'t Test>) -> Result<Vec<Look>, String> {
        tests.into_iter().map(|test| self.look(test)).collect()
    }

    /// What must hold for these values to have a meaning.
    fn needs<'v>(&self, values: impl IntoIterator<Item = &'v Value>) -> Result<Vec<Look>, String> {
        let each = values.into_iter().map(|value| Look::needs(&self.value(value)?, &self.names));
        Ok(each.collect::<Result<Vec<_>, _>>()?.concat())
    }
}

/// Numbers, each in a range, on a way.
struct Cell {
    way: usize,
    ranges: Vec<Range>,
    chance: Interval,
}

impl PartialEq for Cell {
    fn eq(&self, other: &Cell) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Cell {}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Cell) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The likelier, the sooner.
impl Ord for Cell {
    fn cmp(&self, other: &Cell) -> Ordering {
        self.chance.high.total_cmp(&other.chance.high)
    }
}

/// What a cell comes to.
enum Found {
    /// It happens in all of it.
    Happens,
    /// It happens in none of it.
    Never,
    /// It depends on these draws.
    Open(Vec<usize>),
    /// It has no meaning.
    Meaningless,
    /// It goes on with the ways behind it.
    Onward,
}

struct Follower<'a> {
    period: &'a Period,
    event: &'a Claim,
    question: &'a Question,
    ways: Vec<Way>,
    open: BinaryHeap<Cell>,
    /// The chance of all that is open.
    left: f64,
    low: Interval,
    /// What may happen as well.
    rest: Interval,
    most: usize,
}

/// A chance, surely between these, of a system that draws a few numbers on each way.
///
/// # Errors
/// What keeps it from being one, or where too much stays open.
pub fn boxes(period: &Period, event: &Claim, question: &Question) -> Result<Enclosed, String> {
    let nothing = Interval::exactly(0.0);
    let (ways, open) = (Vec::new(), BinaryHeap::new());
    let mut follower =
        Follower { period, event, question, ways, open, left: 0.0, low: nothing, rest: nothing, most: MOST_BOXES[0] };
    let start = State { phase: 0, values: BTreeMap::new(), time: Value::zero(), names: Vec::new(), timely: Vec::new() };
    let first = follower.ways_from(&start, &period.initial)?;
    let sure = Cell { way: 0, ranges: Vec::new(), chance: Interval::exactly(1.0) };
    follower.enter(&sure, &first);
    let mut count = 0;
    while follower.left > ENOUGH && count < follower.most {
        let Some(cell) = follower.open.pop() else { break };
        follower.left -= cell.chance.high;
        count += 1;
        follower.look(cell)?;
    }
    let rest = follower.open.iter().fold(follower.rest, |sum, cell| sum.plus(Interval::between(0.0, cell.chance.high)));
    if rest.high > WIDE {
        return Err(format!("too much stays open after {count} boxes of numbers: {:.1e}", rest.high));
    }
    let high = follower.low.plus(Interval::between(0.0, rest.high));
    Ok(Enclosed::within(Interval::between(follower.low.low, high.high).probability()))
}

fn odd(error: ValueError) -> String {
    error.0
}

impl Follower<'_> {
    /// What a cell comes to, and the cells that it leads to.
    fn look(&mut self, cell: Cell) -> Result<(), String> {
        let over: Vec<Interval> = cell.ranges.iter().map(|range| range.over).collect();
        match self.ways[cell.way].found(&over) {
            Found::Happens => self.low = self.low.plus(cell.chance),
            Found::Never => {}
            Found::Meaningless => self.keep(cell.chance.high),
            Found::Open(places) => self.halve(cell, &places),
            Found::Onward => {
                let onward = match self.ways[cell.way].onward.clone() {
                    Some(onward) => Ok(onward),
                    None => self.behind(cell.way),
                };
                match onward {
                    Ok(onward) => self.enter(&cell, &onward),
                    // What is too far off to be followed stays open, if it is unlikely.
                    Err(reason) => {
                        self.keep(cell.chance.high);
                        if self.rest.high > WIDE {
                            return Err(reason);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// What may happen or not, for good.
    fn keep(&mut self, chance: f64) {
        self.rest = self.rest.plus(Interval::between(0.0, chance));
    }

    /// The two halves of a cell, by the widest of the ranges that it depends on.
    fn halve(&mut self, cell: Cell, places: &[usize]) {
        let width = |place: &&usize| cell.ranges.get(**place).map_or(0.0, Range::width);
        let widest = places.iter().max_by(|one, other| width(one).total_cmp(&width(other)));
        let both = widest.and_then(|place| Some((*place, cell.ranges.get(*place)?.split()?)));
        let Some((place, both)) = both else {
            self.keep(cell.chance.high);
            return;
        };
        for half in both {
            let mut ranges = cell.ranges.clone();
            ranges[place] = half;
            self.add(cell.way, ranges);
        }
    }

    fn add(&mut self, way: usize, ranges: Vec<Range>) {
        let chance = ranges.iter().fold(Interval::exactly(1.0), |product, range| product.times(range.chance));
        if chance.high > 0.0 {
            self.left += chance.high;
            self.open.push(Cell { way, ranges, chance });
        }
    }

    /// A cell on each of these ways, with all ranges of what is drawn on them.
    fn enter(&mut self, cell: &Cell, ways: &[usize]) {
        for way in ways {
            let draws = self.ways[*way].draws.clone();
            for all in &draws {
                let out = Interval::exactly(beyond(all)).times(cell.chance);
                self.keep(out.high);
            }
            let mut all = vec![cell.ranges.clone()];
            for draw in &draws {
                let longer = |ranges: &Vec<Range>| -> Vec<Vec<Range>> {
                    draw.iter().map(|range| ranges.iter().cloned().chain([range.clone()]).collect()).collect()
                };
                all = all.iter().flat_map(longer).collect();
            }
            all.into_iter().for_each(|ranges| self.add(*way, ranges));
        }
    }

    /// The ways behind a way.
    fn behind(&mut self, way: usize) -> Result<Vec<usize>, String> {
        let found = match self.ways[way].after.clone() {
            Some(state) => {
                let period = self.period;
                let phase = period.phases.get(state.phase).ok_or("there is no such phase")?;
                self.ways_from(&state, &phase.edges)?
            }
            None => Vec::new(),
        };
        self.ways[way].onward = Some(found.clone());
        Ok(found)
    }

    fn ways_from(&mut self, state: &State, edges: &[Edge]) -> Result<Vec<usize>, String> {
        let mut found = Vec::new();
        for edge in edges {
            if self.ways.len() >= MOST_WAYS {
                return Err(format!("there are more than {MOST_WAYS} ways to follow"));
            }
            let way = self.way(state, edge)?;
            found.push(self.ways.len());
            self.ways.push(way);
        }
        Ok(found)
    }

    /// A way from a state: what is drawn on it gets names of its own.
    fn way(&mut self, state: &State, edge: &Edge) -> Result<Way, String> {
        let (mut names, mut values, mut draws) = (state.names.clone(), state.values.clone(), Vec::new());
        for (name, distribution) in &edge.draws {
            let own = Name::new(&format!("drawn~{}", names.len()));
            let distribution = distribution.substitute(&values).map_err(odd)?;
            draws.push(ranges(&Distribution::of(&distribution)?)?);
            values.insert(name.clone(), Value::variable(&own));
            names.push(own);
        }
        if names.len() > MOST_DRAWS {
            return Err(format!("more than {MOST_DRAWS} numbers are drawn on one way"));
        }
        self.most = self.most.max(MOST_BOXES[names.len().saturating_sub(1)]);
        let here = Reading { values, names };
        let mut tests: Vec<Look> = state.timely.clone();
        tests.extend(here.looks(&edge.tests)?);
        let first = here.needs(edge.tests.iter().flat_map(|test| [&test.left, &test.right]))?;
        let mut then = here.needs(values_of(edge))?;
        let (mut time, mut shown) = (state.time.clone(), Vec::new());
        for segment in &edge.segments {
            let mut lasts = here.value(&segment.duration)?;
            if lasts.as_rational().is_none_or(|number| number.is_negative()) {
                lasts = Value::maximum(&[Value::zero(), lasts]).map_err(odd)?;
            }
            let end = time.add(&lasts).map_err(odd)?;
            shown.extend(self.showing(&segment.observed, (&time, Some(&end)), &here)?);
            time = end;
        }
        if let Next::End(End::Silent { observed, .. }) = &edge.next {
            shown.extend(self.showing(observed, (&time, None), &here)?);
        }
        then.extend(shown.iter().flat_map(|showing| showing.needs.iter().cloned()));
        let after = match &edge.next {
            Next::Phase(phase) => {
                let image = |(name, value): (&Name, &Value)| Ok((name.clone(), here.value(value)?));
                let values = edge.map.iter().map(image).collect::<Result<_, String>>()?;
                let timely = vec![Look::of(&in_time(&time, &self.question.time), &here.names)?];
                Some(State { phase: *phase, values, time, names: here.names, timely })
            }
            Next::End(_) => None,
        };
        Ok(Way { first, tests, then, shown, after, draws, onward: None })
    }

    /// What is shown for a while, from a time to another (none: for ever); nothing where it is not what is asked for.
    fn showing(
        &self,
        observed: &[Term],
        (start, end): (&Value, Option<&Value>),
        here: &Reading,
    ) -> Result<Option<Showing>, String> {
        let (mut cases, mut needs) = (Vec::new(), Vec::new());
        for duty in self.event.duties(observed).map_err(odd)? {
            let tests: Vec<&Test> = duty.premises.iter().chain(&duty.tests).collect();
            needs.extend(here.needs(tests.iter().flat_map(|test| [&test.left, &test.right]))?);
            cases.push(here.looks(tests)?);
        }
        if cases.is_empty() {
            return Ok(None);
        }
        let mut timely = vec![in_time(start, &self.question.time)];
        if let Some(end) = end {
            let (relation, left) = (Relation::Gtr, end.clone());
            let right = if self.question.first { start.clone() } else { Value::rational(self.question.time.clone()) };
            timely.push(Test { relation, left, right });
        }
        // Times are over what was drawn already.
        let timely = timely.iter().map(|test| Look::of(test, &here.names)).collect::<Result<_, _>>()?;
        Ok(Some(Showing { timely, cases, needs }))
    }
}

/// All values of a way but those that are compared when it is taken.
fn values_of(edge: &Edge) -> Vec<&Value> {
    let mut all: Vec<&Value> = edge.map.values().collect();
    for segment in &edge.segments {
        all.push(&segment.duration);
        all.extend(segment.observed.iter().flat_map(Term::values));
    }
    if let Next::End(End::Silent { observed, .. }) = &edge.next {
        all.extend(observed.iter().flat_map(Term::values));
    }
    all.extend(edge.communications.iter().map(|(_, value)| value));
    all
}

/// Whether a time is not too late.
fn in_time(time: &Value, latest: &BigRational) -> Test {
    Test { relation: Relation::Lte, left: time.clone(), right: Value::rational(latest.clone()) }
}

/// Whether all of these hold; where that is open, what it depends on.
fn all<'a>(looks: impl Iterator<Item = &'a Look>, over: &[Interval]) -> Result<bool, Vec<usize>> {
    let mut open = Vec::new();
    for look in looks {
        match look.holds(over) {
            Some(true) => {}
            Some(false) => return Ok(false),
            None => open.extend(look.places(over)),
        }
    }
    if open.is_empty() { Ok(true) } else { Err(open) }
}

impl Way {
    /// What numbers in these ranges come to on this way.
    fn found(&self, over: &[Interval]) -> Found {
        for (looks, otherwise) in
            [(&self.first, Found::Meaningless), (&self.tests, Found::Never), (&self.then, Found::Meaningless)]
        {
            match all(looks.iter(), over) {
                Ok(true) => {}
                Ok(false) => return otherwise,
                Err(open) => return Found::Open(open),
            }
        }
        let mut open = Vec::new();
        for showing in &self.shown {
            for case in &showing.cases {
                match all(showing.timely.iter().chain(case), over) {
                    Ok(true) => return Found::Happens,
                    Ok(false) => {}
                    Err(places) => open.extend(places),
                }
            }
        }
        match (open.is_empty(), &self.after) {
            (false, _) => Found::Open(open),
            (true, Some(_)) => Found::Onward,
            (true, None) => Found::Never,
        }
    }
}
