//! Where a run comes by: its goals in order, leg by leg.

use std::cell::OnceCell;
use std::cmp::Ordering;
use std::collections::BTreeSet;

use num_traits::ToPrimitive;

use crate::interval::Interval;
use crate::lower::Goal;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::timeline::{Ending, Timeline};
use crate::value::{Relation, Sort, Value};

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
    /// Whether it is still where the last goal was met, and that is the next one too.
    pub there: bool,
    /// For each goal, how near the first round comes to it, when, and in which stretch.
    pub closest: Vec<Option<(Distance, Value, usize)>>,
    /// Whether some place could not be compared with a goal: then nothing is known of later legs.
    pub undecided: bool,
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

/// How far two places are apart. Distances are compared by their squares, which need no roots.
#[derive(Clone, Debug, PartialEq)]
pub struct Distance {
    differences: Vec<Value>,
    /// About its square, where that is a number.
    about: Option<Interval>,
    squared: OnceCell<Option<Value>>,
}

impl Distance {
    /// How far two places are apart; none where they are no places of one space.
    pub fn between(one: &[Value], other: &[Value]) -> Option<Distance> {
        if one.len() != other.len() {
            return None;
        }
        let mut differences = Vec::new();
        for (one, other) in one.iter().zip(other) {
            let difference = one.sub(other).ok()?;
            match difference.sort() {
                Sort::Real => differences.push(difference),
                Sort::Vector(length) => {
                    for place in 0..length {
                        differences.push(difference.component(place)?);
                    }
                }
                _ => return None,
            }
        }
        let number = |one: &Value| Some(Interval::of(&one.as_rational()?));
        let numbers: Option<Vec<Interval>> = differences.iter().map(number).collect();
        let square = |sum: Interval, one: Interval| sum.plus(one.times(one));
        let about = numbers.map(|all| all.into_iter().fold(Interval::exactly(0.0), square));
        Some(Distance { differences, about, squared: OnceCell::new() })
    }

    /// About how near two things come that are so far apart at one look and at the next, where each goes straight from one
    /// place to the next; none where the places are no numbers.
    pub fn between_looks(&self, next: &Distance) -> Option<f64> {
        let numbers = |one: &Distance| {
            one.differences.iter().map(|one| one.as_rational()?.to_f64()).collect::<Option<Vec<f64>>>()
        };
        let (here, there) = (numbers(self)?, numbers(next)?);
        let step: Vec<f64> = here.iter().zip(&there).map(|(here, there)| there - here).collect();
        let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
        let long = dot(&step, &step);
        let part = if long > 0.0 { (-dot(&here, &step) / long).clamp(0.0, 1.0) } else { 0.0 };
        let nearest: Vec<f64> = here.iter().zip(&step).map(|(here, step)| here + part * step).collect();
        Some(dot(&nearest, &nearest).sqrt())
    }

    /// The square of it.
    fn squared(&self) -> Option<&Value> {
        let add = |sum: Value, one: &Value| sum.add(&one.mul(one).ok()?).ok();
        self.squared.get_or_init(|| self.differences.iter().try_fold(Value::zero(), add)).as_ref()
    }

    /// About the square of it, where that is a number.
    pub fn about(&self) -> Option<Interval> {
        self.about
    }

    /// Whether it is less than another; none where that is not found out.
    pub fn is_less(&self, other: &Distance, run: &Timeline) -> Option<bool> {
        match (self.about, other.about) {
            (Some(one), Some(other)) if one.high < other.low => Some(true),
            (Some(one), Some(other)) if one.low > other.high => Some(false),
            _ => run.decide(Relation::Lss, self.squared()?, other.squared()?),
        }
    }

    /// The distance itself.
    pub fn length(&self) -> Option<Value> {
        match self.differences.as_slice() {
            [] => Some(Value::zero()),
            [only] => only.abs().ok(),
            all => Value::vector(all.to_vec()).ok()?.norm().ok(),
        }
    }

    /// How it compares with a number that is not negative; none where that is not found out.
    pub fn compares(&self, run: &Timeline, relation: Relation, limit: &Value) -> Option<bool> {
        if let (Some(about), Some(limit)) = (self.about, limit.as_rational().as_ref().map(Interval::of)) {
            let limit = limit.times(limit);
            if about.high < limit.low {
                return Some(relation.holds(Ordering::Less));
            }
            if about.low > limit.high {
                return Some(relation.holds(Ordering::Greater));
            }
        }
        let squares = || run.decide(relation, self.squared()?, &limit.mul(limit).ok()?);
        // Of a symbol within bounds what is linear is sooner known than a square.
        let [only] = self.differences.as_slice() else { return squares() };
        let sides = [only.clone(), only.neg().ok()?].map(|side| run.decide(relation, &side, limit));
        match (relation, sides) {
            (Relation::Lte | Relation::Lss, [Some(true), Some(true)]) => Some(true),
            (Relation::Lte | Relation::Lss, [Some(false), _] | [_, Some(false)]) => Some(false),
            _ => squares(),
        }
    }
}

/// The values of every observer of this name that is shown: several things may be shown by one observer.
pub fn values_of<'t>(shown: &'t [Term], observer: &Name) -> impl Iterator<Item = &'t [Value]> {
    shown.iter().filter_map(move |term| match term.node() {
        Node::Observe(name, values) if name == observer => Some(values.as_slice()),
        _ => None,
    })
}

/// How far what is shown is from a goal, the nearest where several things are shown; `Ok(None)` if its observer is not
/// shown.
///
/// # Errors
/// Where that is not found out.
pub fn distance(run: &Timeline, shown: &[Term], goal: &Goal) -> Result<Option<Distance>, Unknown> {
    let mut nearest: Option<Distance> = None;
    for values in values_of(shown, &goal.observer) {
        let near = Distance::between(values, &goal.values).ok_or(Unknown)?;
        let nearer = match &nearest {
            None => true,
            Some(before) => near.is_less(before, run).ok_or(Unknown)?,
        };
        if nearer {
            nearest = Some(near);
        }
    }
    Ok(nearest)
}

/// A comparison that could not be decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unknown;

/// A walk over the run, arrival by arrival.
struct Walk<'a> {
    run: &'a Timeline,
    goals: &'a [Goal],
    radius: &'a Value,
    found: Visits,
    goal: usize,
    round: usize,
    from: Value,
    /// Whether it is still where the goal was met that is sought again: it must be left before it is met anew.
    there: bool,
}

/// Where a run comes by, to within a radius, in every kind of round that it has.
pub fn visits(run: &Timeline, goals: &[Goal], radius: &Value) -> Visits {
    let found = Visits { goals: goals.len(), closest: vec![None; goals.len()], ..Visits::default() };
    let mut walk = Walk { run, goals, radius, found, goal: 0, round: 0, from: Value::zero(), there: false };
    if !goals.is_empty() {
        walk.go();
    }
    walk.found.there = walk.there;
    walk.found
}

impl Walk<'_> {
    fn go(&mut self) {
        for (place, stretch) in self.run.stretches.iter().enumerate() {
            self.at(place, &stretch.start.clone());
        }
        if self.found.undecided {
            return;
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
            if self.found.undecided {
                return;
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
        if self.found.undecided {
            return;
        }
        let shown = &self.run.stretches[place].shown;
        if self.found.legs.len() <= self.goals.len() {
            self.approach(place, start, shown);
        }
        for _ in 0..self.goals.len() {
            let Some(goal) = self.goals.get(self.goal) else { return };
            let near = distance(self.run, shown, goal);
            let there = near.map(|near| near.map(|near| near.compares(self.run, Relation::Lte, self.radius)));
            match there {
                Ok(Some(Some(true))) if self.there => return,
                Ok(Some(Some(true))) => {}
                Ok(None | Some(Some(false))) => {
                    self.there = false;
                    return;
                }
                Err(Unknown) | Ok(Some(None)) => {
                    self.found.undecided = true;
                    return;
                }
            }
            let from = std::mem::replace(&mut self.from, start.clone());
            self.found.legs.push(Leg { round: self.round, goal: self.goal, from, to: start.clone(), stretch: place });
            let met = self.goal;
            self.goal += 1;
            if self.goal == self.goals.len() {
                self.goal = 0;
                self.round += 1;
            }
            self.there = self.goals[met] == self.goals[self.goal];
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
            let Ok(near) = distance(self.run, shown, &self.goals[number]) else {
                self.found.undecided = true;
                return;
            };
            let Some(near) = near else { continue };
            let nearer = match &self.found.closest[number] {
                None => Some(true),
                Some((before, ..)) => near.is_less(before, self.run),
            };
            match nearer {
                Some(true) => self.found.closest[number] = Some((near, start.clone(), place)),
                Some(false) => {}
                None => self.found.undecided = true,
            }
        }
    }
}
