//! The ways that one run takes: where the values at the start tell how every question is answered, phases are followed along
//! the run alone. Of many components that ask at one moment these are few ways, where all that might be are a product.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::rc::Rc;

use super::super::course::steering_of;
use super::super::instant::Clock;
use super::super::run::{Env, Path, RawTest, Run};
use super::super::{Edge, End, Failure};
use super::{Explorer, Graph, Held, Kept, Spot, Target, Way};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::term::Term;
use crate::value::Value;

/// So many ways beside one for each phase are looked at before it is asked whether there is one run.
const MANY_WAYS: usize = 250;
/// The most rounds that a run is followed, and the largest value and its longest number in bits that it may come to.
const MOST_ROUNDS: usize = 3_000;
const MOST_SIZE: usize = 60;
const MOST_BITS: u64 = 512;
/// After so many rounds, and twice as many each time, it is asked whether what steers the run has come again.
const FIRST_LOOK: usize = 16;
/// How often it is followed anew because a value turned out to be a variable.
const MOST_PASSES: usize = 64;

/// What the variables of a phase are at one visit.
type Visit = BTreeMap<Name, Value>;

impl<'a> Explorer<'a> {
    /// The phases with all their ways; along the run alone, where these are many and there is one run.
    pub(super) fn graph(mut self, components: &[Term]) -> (Result<Graph, Failure>, Explorer<'a>) {
        self.most = Some(MANY_WAYS);
        let found = self.run(components);
        if !self.many || matches!(found, Err(Failure::Interrupted)) {
            return (found, self);
        }
        let assumptions = self.assumptions;
        match Explorer::alone(components, self.clock, assumptions) {
            (found @ (Ok(_) | Err(Failure::Interrupted)), clock) => {
                (found, Explorer::new(clock, assumptions, Kept::Delays))
            }
            (Err(_), clock) => {
                let mut all = Explorer::new(clock, assumptions, Kept::Delays);
                (all.run(components), all)
            }
        }
    }

    /// The phases along the run alone, where there is one.
    pub(super) fn alone(
        components: &[Term],
        clock: Clock<'a>,
        assumptions: &'a Assumptions,
    ) -> (Result<Graph, Failure>, Clock<'a>) {
        let mut along = Explorer::new(clock, assumptions, Kept::Delays);
        (along.run_along(components), along.clock)
    }

    /// Whether more ways were found than are looked at before it is asked whether there is one run.
    pub(super) fn count_ways(&mut self, new: usize, old: usize) -> Result<(), Failure> {
        self.beside = (self.beside + new.saturating_sub(1)).saturating_sub(old.saturating_sub(1));
        if self.most.is_some_and(|most| self.beside > most) {
            self.many = true;
            return Err(Failure::not_found("too many ways"));
        }
        Ok(())
    }

    /// The answers of a question that are looked at: both, or along a run the one that it gives.
    pub(super) fn answers(&self, question: &RawTest) -> Result<Vec<bool>, Failure> {
        let Some(visit) = &self.visit else { return Ok(vec![false, true]) };
        let told = question.test.substitute(visit).map_err(super::unreduced)?;
        match told.decide(self.assumptions) {
            Some(answer) => Ok(vec![answer]),
            None => Err(Failure::not_found(format!("it must be known whether {told}"))),
        }
    }

    /// The ways from the start.
    pub(super) fn begin(&mut self, components: &[Term], work: &mut BTreeSet<usize>) -> Result<Vec<Way>, Failure> {
        let start: Vec<Run> = components.iter().map(|term| Run::Fresh(term.clone(), Env::new())).collect();
        let path = Path { assumptions: Rc::new(self.assumptions.clone()), ..Path::default() };
        self.ways(start, Vec::new(), path, work)
    }

    fn run_along(&mut self, components: &[Term]) -> Result<Graph, Failure> {
        self.visit = Some(Visit::new());
        let initial = self.begin(components, &mut BTreeSet::new())?;
        let [first] = initial.as_slice() else { return Err(several()) };
        for _ in 0..MOST_PASSES {
            self.spots.iter_mut().for_each(|spot| spot.ways.clear());
            if self.follow(first)? {
                return self.finish(&initial);
            }
        }
        Err(Failure::not_found("the values of the phases do not settle"))
    }

    /// Follows the run until it comes again to a phase with equal values, or with equal ones of those that steer it, or ends; false
    /// where a phase has become more general on the way.
    fn follow(&mut self, first: &Way) -> Result<bool, Failure> {
        let mut visited: HashSet<(usize, Vec<Value>)> = HashSet::new();
        let mut way = first.clone();
        let mut visit = Visit::new();
        let (mut trail, mut look): (Vec<(usize, Visit)>, usize) = (Vec::new(), FIRST_LOOK);
        loop {
            if !way.draws.is_empty() {
                return Err(several());
            }
            let (spot, entries) = match &way.next {
                Target::End(End::Livelock { .. }) => return Err(several()),
                Target::End(_) => return Ok(true),
                Target::Spot(spot, entries) => (*spot, entries),
            };
            let entries: Vec<Value> = entries.iter().map(|entry| self.at(entry, &visit)).collect::<Result<_, _>>()?;
            if !visited.insert((spot, entries.clone())) {
                return Ok(true);
            }
            if visited.len() > MOST_ROUNDS
                || entries.iter().any(|entry| entry.size() > MOST_SIZE || entry.bits() > MOST_BITS)
            {
                return Err(Failure::not_found("the run does not come round soon"));
            }
            visit = self.visit_of(spot, &entries);
            trail.push((spot, visit.clone()));
            if trail.len() >= look {
                if self.comes_again(&trail)? {
                    return Ok(true);
                }
                look *= 2;
            }
            way = match self.taken(spot, &visit).cloned() {
                Some(way) => way,
                None => {
                    let known = self.spots.len();
                    let mut work = BTreeSet::new();
                    let before = std::mem::take(&mut self.spots[spot].ways);
                    self.visit = Some(visit.clone());
                    self.explore_spot(spot, &mut work)?;
                    let [only] = self.spots[spot].ways.as_slice() else { return Err(several()) };
                    let only = only.clone();
                    self.spots[spot].ways.splice(0..0, before);
                    if work.iter().any(|spot| *spot < known) {
                        return Ok(false);
                    }
                    only
                }
            };
        }
    }

    /// Whether the last of these visits is as an earlier one in all that the ways taken so far depend on: what is counted beside
    /// goes on, and the same ways are taken again.
    fn comes_again(&self, trail: &[(usize, Visit)]) -> Result<bool, Failure> {
        let Some(((spot, visit), earlier)) = trail.split_last() else { return Ok(false) };
        if self.spots[*spot].ways.is_empty() {
            return Ok(false);
        }
        let edges = |spot: &Spot| spot.ways.iter().map(|way| self.edge(way)).collect::<Result<Vec<_>, _>>();
        let edges = self.spots.iter().map(edges).collect::<Result<Vec<_>, _>>()?;
        let ways: Vec<&[Edge]> = edges.iter().map(Vec::as_slice).collect();
        let steering = steering_of(&ways);
        let same = |(other, before): &(usize, Visit)| {
            other == spot && steering[*spot].iter().all(|name| before.get(name) == visit.get(name))
        };
        Ok(earlier.iter().any(same))
    }

    fn at(&self, value: &Value, visit: &Visit) -> Result<Value, Failure> {
        value.substitute(visit).map(|value| self.assumptions.simplify(&value)).map_err(super::unreduced)
    }

    /// What the variables of a phase are, where its places hold these.
    fn visit_of(&self, spot: usize, entries: &[Value]) -> Visit {
        let spot = &self.spots[spot];
        let places = spot.held.iter().zip(entries);
        let classes = places.filter_map(|(held, entry)| match held {
            Held::Class(class) => Some((spot.variables[*class].clone(), entry.clone())),
            Held::Constant(_) => None,
        });
        classes.collect()
    }

    /// The way of a phase that is known, and taken with these values.
    fn taken(&self, spot: usize, visit: &Visit) -> Option<&Way> {
        let holds =
            |test: &RawTest| test.test.substitute(visit).is_ok_and(|test| test.decide(self.assumptions) == Some(true));
        self.spots[spot].ways.iter().find(|way| way.tests.iter().all(holds))
    }
}

fn several() -> Failure {
    Failure::not_found("there is more than one run")
}
