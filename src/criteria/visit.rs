//! Where a run comes by: its goals in order, leg by leg.

use std::collections::BTreeSet;

use crate::lower::Goal;
use crate::term::{Node, Term};
use crate::timeline::{Ending, Timeline};
use crate::value::{Relation, Value};

/// From one goal, or the start, to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// The round, from 0.
    pub round: usize,
    /// The goal, from 0.
    pub goal: usize,
    /// When it begins.
    pub from: Value,
    /// When the goal is first within the radius.
    pub to: Value,
    /// The stretch in which it is.
    pub stretch: usize,
}

impl Leg {
    /// How long it takes.
    pub fn duration(&self) -> Option<Value> {
        self.to.sub(&self.from).ok()
    }
}

/// All arrivals of a run.
#[derive(Clone, Debug, Default)]
pub struct Visits {
    /// How many goals there are.
    pub goals: usize,
    /// The legs that were completed, in order.
    pub legs: Vec<Leg>,
    /// Whether the legs listed are all kinds that there will ever be: from then on they repeat, or none comes.
    pub all: bool,
    /// Whether the goal after the last leg is never reached.
    pub never: bool,
    /// For each goal, how near the first round comes to it, when, and in which stretch.
    pub closest: Vec<Option<(Value, Value, usize)>>,
}

impl Visits {
    /// Whether the first round is over, and what comes close to its goals is known.
    pub fn first_round_is_over(&self) -> bool {
        self.legs.len() > self.goals || self.all
    }

    /// The leg of a round to a goal.
    pub fn leg(&self, round: usize, goal: usize) -> Option<&Leg> {
        self.legs.iter().find(|leg| leg.round == round && leg.goal == goal)
    }

    /// For each round that was completed: when it begins, when it ends, and its last leg.
    pub fn rounds(&self) -> Vec<(Value, Value, &Leg)> {
        let mut from = Value::zero();
        let mut all = Vec::new();
        for leg in self.legs.iter().filter(|leg| leg.goal + 1 == self.goals) {
            all.push((from, leg.to.clone(), leg));
            from = leg.to.clone();
        }
        all
    }
}

/// How far what is shown is from a goal; none if its observer is not shown.
pub fn distance(run: &Timeline, shown: &[Term], goal: &Goal) -> Option<Value> {
    let values = shown.iter().find_map(|term| match term.node() {
        Node::Observe(name, values) if *name == goal.observer => Some(values),
        _ => None,
    })?;
    apart(run, values, &goal.values)
}

/// How far two places are apart.
pub fn apart(run: &Timeline, one: &[Value], other: &[Value]) -> Option<Value> {
    let mut parts = Vec::new();
    for (one, other) in one.iter().zip(other) {
        parts.push(one.sub(other).ok()?);
    }
    match parts.as_slice() {
        [] => Some(Value::zero()),
        [only] if matches!(only.sort(), crate::value::Sort::Real) => {
            if run.decide(Relation::Lss, only, &Value::zero())? { only.neg().ok() } else { Some(only.clone()) }
        }
        [only] => only.norm().ok(),
        _ => Value::vector(parts).ok()?.norm().ok(),
    }
}

/// A walk over the run, arrival by arrival.
struct Walk<'a> {
    run: &'a Timeline,
    goals: &'a [Goal],
    radius: &'a Value,
    found: Visits,
    goal: usize,
    round: usize,
    from: Value,
}

/// Where a run comes by, to within a radius, in every kind of round that it has.
pub fn visits(run: &Timeline, goals: &[Goal], radius: &Value) -> Visits {
    let found = Visits { goals: goals.len(), closest: vec![None; goals.len()], ..Visits::default() };
    let mut walk = Walk { run, goals, radius, found, goal: 0, round: 0, from: Value::zero() };
    if !goals.is_empty() {
        walk.go();
    }
    walk.found
}

impl Walk<'_> {
    fn go(&mut self) {
        for (place, stretch) in self.run.stretches.iter().enumerate() {
            self.at(place, &stretch.start.clone());
        }
        let Ending::Repeats(from) = self.run.ending else {
            self.found.all = self.run.closed();
            self.found.never = self.run.closed();
            return;
        };
        let (Some(first), Some(end)) =
            (self.run.stretches.get(from), self.run.stretches.last().and_then(crate::timeline::end_of))
        else {
            return;
        };
        let Ok(period) = end.sub(&first.start) else { return };
        // Each time the loop begins anew with one of the goals; once with the same goal again, all is known.
        let mut seen = BTreeSet::new();
        let mut shift = period.clone();
        while seen.insert(self.goal) {
            let before = self.found.legs.len();
            for place in from..self.run.stretches.len() {
                let Ok(start) = self.run.stretches[place].start.add(&shift) else { return };
                self.at(place, &start);
            }
            if self.found.legs.len() == before {
                self.found.never = true;
                break;
            }
            let Ok(next) = shift.add(&period) else { return };
            shift = next;
        }
        // Once more, so that a round that begins in one turn of the loop and ends in the next is seen whole.
        for _ in 0..if self.found.never { 0 } else { self.goals.len() + 1 } {
            for place in from..self.run.stretches.len() {
                let Ok(start) = self.run.stretches[place].start.add(&shift) else { return };
                self.at(place, &start);
            }
            let Ok(next) = shift.add(&period) else { return };
            shift = next;
        }
        self.found.all = true;
    }

    /// One stretch of the run, which begins at this time.
    fn at(&mut self, place: usize, start: &Value) {
        let shown = &self.run.stretches[place].shown;
        if self.found.legs.len() <= self.goals.len() {
            self.approach(place, start, shown);
        }
        for _ in 0..self.goals.len() {
            let Some(goal) = self.goals.get(self.goal) else { return };
            let near = distance(self.run, shown, goal);
            if near.is_none_or(|near| self.run.decide(Relation::Lte, &near, self.radius) != Some(true)) {
                return;
            }
            let from = std::mem::replace(&mut self.from, start.clone());
            self.found.legs.push(Leg { round: self.round, goal: self.goal, from, to: start.clone(), stretch: place });
            self.goal += 1;
            if self.goal == self.goals.len() {
                self.goal = 0;
                self.round += 1;
            }
            if self.found.legs.len() <= self.goals.len() {
                self.approach(place, start, shown);
            }
        }
    }

    /// How near this comes to the goal that is sought, and to the last one until the next is reached.
    fn approach(&mut self, place: usize, start: &Value, shown: &[Term]) {
        let done = self.found.legs.len();
        let current = (done < self.goals.len()).then_some(done);
        let last = done.checked_sub(1).filter(|last| *last < self.goals.len());
        for number in current.into_iter().chain(last) {
            let Some(near) = distance(self.run, shown, &self.goals[number]) else { continue };
            let nearer = match &self.found.closest[number] {
                None => true,
                Some((before, ..)) => self.run.decide(Relation::Lss, &near, before) == Some(true),
            };
            if nearer {
                self.found.closest[number] = Some((near, start.clone(), place));
            }
        }
    }
}
