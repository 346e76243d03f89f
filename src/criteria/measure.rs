//! What each kind of criterion measures, and by what margin it is met.

mod nearest;
mod turns;

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::visit::{Visits, values_of};
use super::{Finding, Judge, Measure, Moment, Passing, Standing};
use crate::lower::{Ask, Criteria, Criterion, Environment, Likelihood, System};
use crate::name::Name;
use crate::safety;
use crate::term::Term;
use crate::timeline::{Ending, Timeline, end_of};
use crate::value::{Relation, Value};

/// One system with its run, to measure on.
pub(super) struct Scene<'a> {
    pub(super) judge: &'a Judge<'a>,
    pub(super) criteria: &'a Criteria,
    pub(super) environment: &'a Environment,
    pub(super) system: &'a System,
    pub(super) run: &'a Timeline,
    pub(super) visits: &'a Visits,
}

fn exact(value: &BigRational) -> Value {
    Value::rational(value.clone())
}

impl Scene<'_> {
    pub(super) fn finding(&self, criterion: &Criterion) -> Finding {
        let mut finding = match &criterion.kind {
            Ask::Probability { likelihood, relation, threshold } => {
                self.probability(criterion, likelihood, *relation, threshold)
            }
            Ask::Clearance { strict, limit, between } => self.clearance(criterion, *strict, limit, between),
            _ => self.on_the_run(criterion).unwrap_or_else(|| Finding::new(criterion)),
        };
        if let (Standing::Open, Ending::Unknown(why), true) =
            (finding.standing, &self.run.ending, finding.notes.is_empty())
        {
            finding.notes.push(format!("the run could not be followed: {why}"));
        }
        finding
    }

    /// What the run alone tells.
    pub(super) fn on_the_run(&self, criterion: &Criterion) -> Option<Finding> {
        Some(match &criterion.kind {
            Ask::Radius(goal) => self.radius(criterion, *goal),
            Ask::Leg { goal, every, limit } => self.times(criterion, *every, limit, Some(*goal)),
            Ask::Round { every, limit } => self.times(criterion, *every, limit, None),
            Ask::Battery { start, rates, keep, time } => self.battery(criterion, start, rates, keep, time.as_ref()),
            Ask::Clearance { strict, limit, between } => {
                let mut finding = Finding::new(criterion);
                self.least_distance(between, limit, *strict, &mut finding);
                finding
            }
            Ask::Probability { .. } => return None,
        })
    }

    /// A margin: `high - low`.
    fn room(&self, low: &Value, high: &Value) -> Option<Value> {
        high.sub(low).ok()
    }

    fn holds(&self, relation: Relation, left: &Value, right: &Value) -> bool {
        self.run.decide(relation, left, right) == Some(true)
    }

    fn radius(&self, criterion: &Criterion, goal: usize) -> Finding {
        let mut finding = Finding::new(criterion);
        let radius = exact(&self.criteria.radius);
        let Some((near, time, stretch)) = self.visits.closest.get(goal).cloned().flatten() else {
            finding.notes.push(match goal.checked_sub(1).and_then(|before| self.criteria.goals.get(before)) {
                Some(before) if self.visits.never => format!("{before} is never reached, and this goal comes after it"),
                _ => "nothing is shown of it".to_string(),
            });
            if self.visits.never {
                finding.standing = Standing::NotMet;
            }
            return finding;
        };
        let reached = self.visits.leg(0, goal).is_some();
        let Some(near) = near.length() else { return finding };
        let margin = self.room(&near, &radius);
        if reached {
            finding.standing = Standing::Met;
        } else if self.visits.never {
            finding.standing = Standing::NotMet;
        }
        // Nearer may still come, as long as the run is not known to its end; never nearer than the goal itself.
        let whole = self.visits.legs.len() > goal + 1 || self.visits.all || near.is_zero();
        finding.value = Some(if whole { Measure::Exact(near) } else { Measure::AtMost(near) });
        finding.margin = margin.map(|margin| if whole { Measure::Exact(margin) } else { Measure::AtLeast(margin) });
        finding.moment = Some(Moment { stretch, from: time, to: None, leg: Some(goal) });
        finding
    }

    /// Legs to one goal, or rounds.
    fn times(&self, criterion: &Criterion, every: bool, limit: &BigRational, goal: Option<usize>) -> Finding {
        let mut finding = Finding::new(criterion);
        let limit = exact(limit);
        let spans: Vec<(Value, Value, usize, usize)> = match goal {
            Some(goal) => {
                let legs = self.visits.legs.iter().filter(|leg| leg.goal == goal);
                legs.map(|leg| (leg.from.clone(), leg.to.clone(), leg.stretch, leg.goal)).collect()
            }
            None => {
                let rounds = self.visits.rounds().into_iter();
                rounds
                    .map(|(from, to, leg)| (from, to, leg.stretch, self.slowest(leg.round).unwrap_or(leg.goal)))
                    .collect()
            }
        };
        let mut worst: Option<(Value, Moment)> = None;
        for (from, to, stretch, leg) in if every { &spans[..] } else { spans.get(..1).unwrap_or(&[]) } {
            let Some(time) = self.room(from, to) else { continue };
            if worst.as_ref().is_none_or(|(before, _)| self.holds(Relation::Gtr, &time, before)) {
                let moment = Moment { stretch: *stretch, from: from.clone(), to: Some(to.clone()), leg: Some(*leg) };
                worst = Some((time, moment));
            }
        }
        let whole = if every { self.visits.all && !self.visits.never } else { worst.is_some() };
        if let Some((time, moment)) = worst {
            let margin = self.room(&time, &limit);
            let late = self.holds(Relation::Gtr, &time, &limit);
            finding.standing = match (late, whole) {
                (true, _) => Standing::NotMet,
                (false, true) => Standing::Met,
                (false, false) => Standing::Open,
            };
            finding.value = Some(if whole { Measure::Exact(time) } else { Measure::AtLeast(time) });
            finding.margin = margin.map(|margin| if whole { Measure::Exact(margin) } else { Measure::AtMost(margin) });
            finding.moment = Some(moment);
        }
        if !whole {
            self.missing(&limit, goal, every, &mut finding);
        }
        finding
    }

    /// Why it is not known when a goal is reached.
    fn unknown_arrival(&self) -> String {
        for goal in &self.criteria.goals {
            let shown = self.sorts(&goal.observer, goal.values.len());
            let other = shown.iter().zip(&goal.values).find(|(shown, value)| **shown != value.sort());
            if let Some((shown, value)) = other {
                return format!("{} shows {shown}, and {value} in the goal {goal} is {}", goal.observer, value.sort());
            }
        }
        "it could not be found out when a goal is reached".to_string()
    }

    /// The leg that takes longest in a round.
    fn slowest(&self, round: usize) -> Option<usize> {
        let mut slowest: Option<(Value, usize)> = None;
        for leg in self.visits.legs.iter().filter(|leg| leg.round == round) {
            let time = leg.duration()?;
            if slowest.as_ref().is_none_or(|(before, _)| self.holds(Relation::Gtr, &time, before)) {
                slowest = Some((time, leg.goal));
            }
        }
        slowest.map(|(_, goal)| goal)
    }

    /// What is to be said of a leg or a round that was not seen to its end.
    fn missing(&self, limit: &Value, goal: Option<usize>, every: bool, finding: &mut Finding) {
        if self.visits.undecided {
            finding.notes.push(self.unknown_arrival());
            return;
        }
        let done = self.visits.legs.len();
        let sought = done % self.criteria.goals.len().max(1);
        let at = self.criteria.goals.get(sought).map(ToString::to_string).unwrap_or_default();
        let since = self.visits.legs.last().map_or_else(Value::zero, |leg| leg.to.clone());
        let begun = match goal {
            Some(goal) if goal != sought && !self.visits.never => return,
            Some(_) => since.clone(),
            None => self.visits.rounds().last().map_or_else(Value::zero, |(_, to, _)| to.clone()),
        };
        let radius = exact(&self.criteria.radius);
        let within = if radius.is_zero() { String::new() } else { format!(" to within {radius}") };
        if self.visits.never {
            // A program that has done its rounds and stands still owes no further one.
            if every && done > 0 && sought == 0 && matches!(self.run.ending, Ending::Still | Ending::Ended) {
                if finding.standing == Standing::Open && finding.value.is_some() {
                    finding.standing = Standing::Met;
                    finding.notes.push("the mission ends after its last round".to_string());
                }
                return;
            }
            finding.standing = Standing::NotMet;
            finding.notes.push(match self.visits.there {
                true => format!("after {since} it stays at {at}{within}, and never comes there anew"),
                false => format!("after {since} it never reaches {at}{within}"),
            });
        } else if let Some(until) = self.run.known_until() {
            let waited = self.room(&begun, &until);
            let longer = |waited: &Value| match &finding.value {
                Some(Measure::Exact(seen) | Measure::AtLeast(seen)) => self.holds(Relation::Gtr, waited, seen),
                _ => true,
            };
            if waited.as_ref().is_some_and(|waited| self.holds(Relation::Gtr, waited, limit) && longer(waited)) {
                finding.standing = Standing::NotMet;
                finding.value = waited.clone().map(Measure::AtLeast);
                finding.margin = waited.as_ref().and_then(|waited| self.room(waited, limit)).map(Measure::AtMost);
            }
            if let (Ending::Unknown(why), Some(waited)) = (&self.run.ending, &waited)
                && (finding.standing == Standing::Open || finding.value == Some(Measure::AtLeast(waited.clone())))
            {
                let [since, until] = [&since, &until].map(|time| Measure::Exact(time.clone()).readable());
                finding.notes.push(match done {
                    _ if self.visits.there => {
                        format!("it stays at {at}{within} between {since} and {until}, and {why}")
                    }
                    0 => format!("{at} is not reached{within} by {until}, and {why}"),
                    _ => format!("{at} is not reached{within} between {since} and {until}, and {why}"),
                });
            }
        }
        let stretch = self.run.stretches.len().saturating_sub(1);
        if finding.moment.is_none() {
            finding.moment = Some(Moment { stretch, from: begun, to: None, leg: Some(sought) });
        }
    }

    fn battery(
        &self,
        criterion: &Criterion,
        start: &BigRational,
        rates: &[(BigRational, Option<Name>)],
        keep: &BigRational,
        time: Option<&BigRational>,
    ) -> Finding {
        let mut finding = Finding::new(criterion);
        let keep = exact(keep);
        let full = exact(start);
        let end = match time {
            Some(time) => Some(exact(time)),
            None => self.visits.rounds().first().map(|(_, to, _)| to.clone()),
        };
        if end.is_none() && self.visits.undecided {
            finding.notes.push(self.unknown_arrival());
            return finding;
        }
        let mut charge = full.clone();
        let mut least = (full.clone(), Value::zero(), 0);
        let turns = end.as_ref().map_or(0, |end| self.turns(end));
        let mut reached = false;
        for (place, begin) in self.run.unrolled(turns) {
            let stretch = &self.run.stretches[place];
            if end.as_ref().is_some_and(|end| !self.holds(Relation::Lss, &begin, end)) {
                reached = true;
                break;
            }
            let mut until = stretch.duration.as_ref().and_then(|duration| begin.add(duration).ok());
            if let Some(end) = &end
                && until.as_ref().is_none_or(|until| self.holds(Relation::Gtr, until, end))
            {
                until = Some(end.clone());
            }
            let Some(until) = until else { break };
            let Some(left) = drained(&charge, &rate(rates, &stretch.shown), &begin, &until) else { return finding };
            charge = if self.holds(Relation::Gtr, &left, &full) { full.clone() } else { left };
            if self.holds(Relation::Lss, &charge, &least.0) {
                least = (charge.clone(), until.clone(), place);
            }
            reached = end.as_ref() == Some(&until);
        }
        // What is always used at one rate is known where the run is not, such as beside noise.
        if let (false, Ending::Unknown(_), Some(end)) = (reached, &self.run.ending, &end)
            && let Some(left) = evenly(rates).and_then(|rate| drained(&full, &rate, &Value::zero(), end))
        {
            least.0 = if self.holds(Relation::Gtr, &left, &full) { full.clone() } else { left };
            least.1 = end.clone();
            reached = true;
        }
        let margin = self.room(&keep, &least.0);
        let low = self.holds(Relation::Lss, &least.0, &keep);
        finding.standing = match (low, reached) {
            (true, _) => Standing::NotMet,
            (false, true) => Standing::Met,
            (false, false) => Standing::Open,
        };
        if !reached {
            let why = if end.is_none() { "the round is not completed" } else { "the run is not known that far" };
            finding.notes.push(why.to_string());
        }
        finding.value = Some(if reached { Measure::Exact(least.0) } else { Measure::AtMost(least.0) });
        finding.margin = margin.map(|margin| if reached { Measure::Exact(margin) } else { Measure::AtMost(margin) });
        finding.moment = Some(Moment { stretch: least.2, from: least.1, to: None, leg: None });
        finding
    }

    /// How often a run that repeats goes round before this time; bounded.
    fn turns(&self, end: &Value) -> usize {
        let Ending::Repeats(from) = self.run.ending else { return 0 };
        let (Some(first), Some(last)) = (self.run.stretches.get(from), self.run.stretches.last().and_then(end_of))
        else {
            return 0;
        };
        let period = last.sub(&first.start).ok().and_then(|period| period.as_rational());
        let (Some(period), Some(end)) = (period, end.as_rational()) else { return 1 };
        let most = BigRational::from_integer((super::MOST_STRETCHES / self.run.stretches.len().max(1) + 1).into());
        let turns = (end / period).ceil().min(most);
        num_traits::ToPrimitive::to_usize(&turns.to_integer()).unwrap_or(0)
    }

    /// A clearance that is proved of the phases; none for what is asked otherwise, or where no proof is found.
    pub(super) fn by_invariant(&self, criterion: &Criterion) -> Option<Finding> {
        let Ask::Clearance { strict, limit, between } = &criterion.kind else { return None };
        Some(self.clearance(criterion, *strict, limit, between)).filter(|finding| finding.standing == Standing::Met)
    }

    fn clearance(
        &self,
        criterion: &Criterion,
        strict: bool,
        limit: &BigRational,
        between: &[(Name, usize); 2],
    ) -> Finding {
        let mut finding = Finding::new(criterion);
        self.least_distance(between, limit, strict, &mut finding);
        if finding.standing != Standing::Open || !self.judge.invariants {
            return finding;
        }
        // The run goes on; what always holds may be proved of its phases.
        let claim =
            nearest::claim(&between.each_ref().map(|(name, arity)| (name, self.sorts(name, *arity))), strict, limit);
        let Ok(claim) = claim else { return finding };
        let asked = safety::Asked {
            components: &self.system.components,
            claim: &claim,
            definitions: &self.environment.definitions,
            assumptions: &self.environment.assumptions,
            instances: &|_| Vec::new(),
            interrupted: self.judge.interrupted,
        };
        let outcome = safety::always_of_what_comes(&self.system.term(&self.environment.definitions), asked);
        if let safety::Verdict::Proved(safe) = &outcome.verdict {
            finding.standing = Standing::Met;
            let least = if strict { "always more than" } else { "never less than" };
            finding.notes = vec![format!("by an invariant of the phases: it is {least} {}", exact(limit))];
            finding.notes.extend(finding.passing.as_ref().map(Passing::note));
            if outcome.speaks == Some(false) {
                finding.shows_nothing();
            }
            // What is seen of the run is as near as the proof allows.
            if let Some(Measure::AtMost(seen)) = &finding.value
                && *seen == exact(limit)
            {
                finding.value = Some(Measure::Exact(seen.clone()));
                finding.margin = Some(Measure::Exact(Value::zero()));
            }
            finding.trusted.extend(safe.trusted().iter().cloned());
        } else if !self.run.closed() && self.broken_by_draws(&claim, limit, &mut finding) {
            return finding;
        } else {
            finding.notes.extend(outcome.remaining);
        }
        finding
    }

    fn probability(
        &self,
        criterion: &Criterion,
        likelihood: &Likelihood,
        relation: Relation,
        threshold: &BigRational,
    ) -> Finding {
        let mut finding = Finding::new(criterion);
        let likely = match (self.judge.chances)(likelihood, self.environment, (relation, threshold)) {
            Ok(likely) => likely,
            Err(reasons) => {
                finding.notes = reasons;
                return finding;
            }
        };
        let end = |end: f64| likely.number.clone().or_else(|| BigRational::from_float(end));
        let ends = (end(likely.low), end(likely.high));
        if let (Some(low), Some(high)) = ends {
            let (first, second) = (relation.holds(low.cmp(threshold)), relation.holds(high.cmp(threshold)));
            finding.standing = match (first == second && likely.sure, first) {
                (true, true) => Standing::Met,
                (true, false) => Standing::NotMet,
                _ => Standing::Open,
            };
            let upward = matches!(relation, Relation::Gtr | Relation::Gte);
            let (near, far) =
                if upward { (&low - threshold, &high - threshold) } else { (threshold - &high, threshold - &low) };
            finding.margin = Some(outward(&near, &far));
        }
        let certain = likely.number.as_ref().filter(|number| number.is_integer());
        finding.value =
            Some(certain.map_or(Measure::Between(likely.low, likely.high), |one| Measure::Exact(exact(one))));
        finding.notes.push(likely.method.to_string());
        finding.trusted = likely.trusted;
        finding
    }
}

/// Two numbers as machine numbers, rounded outward.
fn outward(low: &BigRational, high: &BigRational) -> Measure {
    let (low, high) = (crate::interval::Interval::of(low), crate::interval::Interval::of(high));
    Measure::Between(low.low, high.high)
}

fn drained(charge: &Value, rate: &BigRational, from: &Value, until: &Value) -> Option<Value> {
    let time = until.sub(from).ok()?;
    if rate.is_zero() && !rate.is_negative() {
        return Some(charge.clone());
    }
    charge.sub(&exact(rate).mul(&time).ok()?).ok()
}

/// What is used in a unit of time while this is shown.
fn rate(rates: &[(BigRational, Option<Name>)], shown: &[Term]) -> BigRational {
    let counts = |observer: &Option<Name>| observer.as_ref().is_none_or(|name| values_of(shown, name).next().is_some());
    rates.iter().filter(|(_, observer)| counts(observer)).map(|(rate, _)| rate.clone()).sum()
}

/// What is used in a unit of time whatever is shown; none where that matters.
fn evenly(rates: &[(BigRational, Option<Name>)]) -> Option<BigRational> {
    rates.iter().all(|(_, observer)| observer.is_none()).then(|| rate(rates, &[]))
}
