//! Clocks: components that are within one delay whenever time passes, so that nobody holds them up. What remains of the
//! delays of two of them comes again only after a common multiple of their rounds.

use super::super::run::Run;
use super::super::step::inspect;
use super::super::{Edge, Failure, Next, drift};
use super::{Explorer, Way, failure_of};
use crate::digest::Quick;
use crate::value::{Relation, Value};

/// What a component is within, apart from the values, with the delay that it began.
type Begun<'s> = (&'s Run, Value);

/// How a component stands in each phase: what remains of its delay, if that is one; and whether there is any.
struct Standing {
    left: Vec<Option<Value>>,
    delays: bool,
}

impl Explorer<'_> {
    /// Two components whose rounds have no rational ratio, as far as is known, where nobody holds them up: what remains of
    /// their delays then never comes again. If it is not known, all that delays is such a component.
    pub(super) fn drifting_clocks(&self, initial: &[Way]) -> Result<Option<Failure>, Failure> {
        let starts: Vec<Edge> = initial.iter().map(|way| self.edge(way)).collect::<Result<_, _>>()?;
        let edges = self.spots.iter().map(|spot| spot.ways.iter().map(|way| self.edge(way)).collect());
        let edges: Vec<Vec<Edge>> = edges.collect::<Result<_, _>>()?;
        let mut rounds: Vec<(String, Value)> = Vec::new();
        let mut alone = true;
        for (component, name) in self.clock.names.iter().enumerate() {
            let standing = self.standing(component)?;
            let round = self.round_of(component, &standing.left, (&starts, &edges));
            alone &= round.is_some() || !standing.delays;
            rounds.extend(round.map(|time| (name.clone(), time)));
        }
        let found = drift::drifting(&rounds, self.assumptions);
        Ok(found.filter(|failure| alone || !failure.is_open()))
    }

    fn standing(&self, component: usize) -> Result<Standing, Failure> {
        let mut standing = Standing { left: Vec::with_capacity(self.spots.len()), delays: false };
        for (number, spot) in self.spots.iter().enumerate() {
            let (mut place, mut delays) = (0, Vec::new());
            let mut look = |run: Run| {
                if place == component {
                    standing.delays |= inspect(&run, &mut delays, &mut Vec::new()).is_err() || !delays.is_empty();
                }
                place += 1;
            };
            self.each_over(number, &spot.variables, &mut look).map_err(failure_of)?;
            standing.left.push(if let [one] = delays.as_slice() { Some(one.clone()) } else { None });
        }
        Ok(standing)
    }

    /// How long a component takes to come round, if it does so in one way only, whatever the others do.
    fn round_of(
        &self,
        component: usize,
        left: &[Option<Value>],
        (starts, edges): (&[Edge], &[Vec<Edge>]),
    ) -> Option<Value> {
        let within = |number: usize| self.spots.get(number)?.control.runs.get(component);
        let begun = |edge: &Edge| -> Option<Begun<'_>> {
            let Next::Phase(next) = edge.next else { return None };
            Some((within(next)?, left.get(next)?.as_ref()?.substitute(&edge.map).ok()?))
        };
        let mut first: Option<Begun<'_>> = None;
        for edge in starts {
            let start = begun(edge)?;
            if *first.get_or_insert(start.clone()) != start {
                return None;
            }
        }
        let mut following: Quick<&Run, Begun<'_>> = Quick::default();
        for (number, edge) in
            edges.iter().enumerate().flat_map(|(number, own)| own.iter().map(move |edge| (number, edge)))
        {
            let (here, remains) = (within(number)?, left.get(number)?.as_ref()?);
            let (next, delay) = begun(edge)?;
            let passed = edge.duration().ok()?;
            let mut known = self.assumptions.clone();
            edge.tests.iter().for_each(|test| known.assume(test.relation, &test.left, &test.right));
            let equal =
                |one: &Value, other: &Value| one == other || known.decide(Relation::Eq, one, other) == Some(true);
            if here == next && equal(&delay, &remains.sub(&passed).ok()?) {
                continue;
            }
            if !equal(remains, &passed) || self.clock.settler.varies(&delay) {
                return None;
            }
            let found = (next, delay);
            if *following.entry(here).or_insert_with(|| found.clone()) != found {
                return None;
            }
        }
        let (mut here, _) = first?;
        let (mut time, mut entered) = (Value::zero(), Quick::default());
        loop {
            if let Some(before) = entered.insert(here, time.clone()) {
                return time.sub(&before).ok();
            }
            let (next, delay) = following.get(here)?;
            (here, time) = (next, time.add(delay).ok()?);
        }
    }
}
