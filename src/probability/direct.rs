//! Chances by running the executable meaning: for systems that are no chain of linear rounds, such as those in which
//! drawn durations run beside each other.

use num_rational::BigRational;
use num_traits::{ToPrimitive, Zero};

use super::Question;
use super::estimated::{Estimate, counted, interval};
use super::random::{Draws, Sampler, Source};
use super::rounded::rounded;
use crate::assumption::Assumptions;
use crate::definition::{Definition, Definitions};
use crate::distribution::Distribution;
use crate::invariant::Claim;
use crate::model::{Action, Meaningless, Model, Move, Patience, State};
use crate::period::Test;
use crate::term::{Node, Term};
use crate::value::{Value, ValueError};

/// Runs, at most and at least.
const RUNS: (u64, u64) = (4_000, 400);
/// Steps of all runs together, as far as the first lets that be seen.
const STEPS: u64 = 400_000;
/// Steps of one run.
const MOST_STEPS: u64 = 100_000;
/// Steps of one run that is drawn.
const MOST_DRAWN: u64 = 5_000;

/// Of a state in which time passes, since when and until when: whether that is enough.
type Enough<'a> = dyn FnMut(&State, (&BigRational, Option<&BigRational>)) -> Result<bool, String> + 'a;

/// The share of so many runs in which it happens; of as many as take not too long, where that is not said. Durations that are drawn below 0 count as 0.
///
/// # Errors
/// Where a run has no meaning, never ends, or depends on which of several communications comes first.
pub fn direct(
    system: &Term,
    definitions: &Definitions,
    event: &Claim,
    question: &Question,
    (runs, seed): (Option<u64>, u64),
) -> Result<Estimate, String> {
    let (system, lasted) = counted_from_nothing(system, definitions)?;
    let subject = Subject { system: &system, event, question };
    let (_, steps) = subject.run(&Model::new(&lasted), &Source::new(seed, 0))?;
    let runs = runs.unwrap_or((STEPS / steps.max(1)).clamp(RUNS.1, RUNS.0));
    let model = || Model::new(&lasted);
    let happened = counted(runs, model, &|run, model| Ok(subject.run(model, &Source::new(seed, run))?.0.into()))?;
    Ok(interval(happened, runs))
}

/// What is shown for a while.
pub struct Shown {
    /// Since when.
    pub from: BigRational,
    /// Until when.
    pub until: BigRational,
    /// What.
    pub what: Vec<Term>,
}

/// What some runs show over time, up to the time that is asked about.
///
/// # Errors
/// As of [`direct`].
pub fn trajectories(
    system: &Term,
    definitions: &Definitions,
    event: &Claim,
    question: &Question,
    (runs, seed): (u64, u64),
) -> Result<Vec<Vec<Shown>>, String> {
    let (system, lasted) = counted_from_nothing(system, definitions)?;
    let subject = Subject { system: &system, event, question };
    let model = Model::new(&lasted);
    (0..runs).map(|run| subject.trajectory(&model, &Source::new(seed, run))).collect()
}

/// What is asked about in some runs: when it happens first, where it does by the time asked about; and what is shown then.
pub struct Sample {
    /// Since when, in each run.
    pub arrivals: Vec<Option<BigRational>>,
    /// What is shown at the time that is asked about.
    pub ends: Vec<Vec<Term>>,
}

/// So many runs at most, to be drawn as one curve.
///
/// # Errors
/// As of [`direct`].
pub fn sample(
    system: &Term,
    definitions: &Definitions,
    event: &Claim,
    question: &Question,
    (runs, seed): (u64, u64),
) -> Result<Sample, String> {
    let (system, lasted) = counted_from_nothing(system, definitions)?;
    let subject = Subject { system: &system, event, question };
    let model = Model::new(&lasted);
    let mut sample = Sample { arrivals: Vec::new(), ends: Vec::new() };
    let (mut run, mut left) = (0, STEPS);
    while run < runs && left > 0 {
        let (mut arrival, mut end) = (None, Vec::new());
        let steps = subject.follow(&model, &Source::new(seed, run), MOST_STEPS, &mut |state, (from, until)| {
            if arrival.is_none() && subject.shown(state)? {
                arrival = Some(from.clone());
            }
            let last = until.is_none_or(|until| *until > question.time);
            if last && !question.first {
                end = crate::invariant::shown(state);
            }
            // Of what is asked of the first time nothing more is looked at.
            Ok(question.first && arrival.is_some())
        })?;
        sample.arrivals.push(arrival);
        sample.ends.push(end);
        left = left.saturating_sub(steps.max(1));
        run += 1;
    }
    Ok(sample)
}

/// A system and its definitions, in which durations that are drawn below 0 count as 0.
pub(super) fn counted_from_nothing(system: &Term, definitions: &Definitions) -> Result<(Term, Definitions), String> {
    let mut lasted = Definitions::default();
    for one in definitions.iter() {
        lasted.insert(Definition { body: lasting(&one.body)?, ..one.clone() });
    }
    Ok((lasting(system)?, lasted))
}

/// A process whose delays last no time where their durations are negative.
fn lasting(term: &Term) -> Result<Term, String> {
    let children = term.children().map(lasting).collect::<Result<Vec<_>, _>>()?;
    let term = if children.is_empty() { term.clone() } else { term.with_children(children) };
    match term.node() {
        Node::Delay(time) if time.as_rational().is_none() => {
            let lasts = Value::maximum(&[Value::zero(), time.clone()]).map_err(|error| error.0)?;
            Ok(Term::delay(lasts))
        }
        _ => Ok(term),
    }
}

/// A system, and what is asked of it.
pub(super) struct Subject<'a> {
    pub system: &'a Term,
    pub event: &'a Claim,
    pub question: &'a Question,
}

impl Subject<'_> {
    /// Whether it happens in one run, and how many steps that took.
    fn run(&self, model: &Model, source: &Source) -> Result<(bool, u64), String> {
        let mut happened = false;
        let steps = self.follow(model, source, MOST_STEPS, &mut |state, (_, end)| {
            let last = end.is_none_or(|end| *end > self.question.time);
            happened = (self.question.first || last) && self.shown(state)?;
            Ok(happened)
        })?;
        Ok((happened, steps))
    }

    /// Follows one run until it ends, or time passes the time that is asked about, or `enough` says so of a state in which
    /// time passes, since when and until when (none: for ever). The steps that it took.
    fn follow(&self, model: &Model, source: &Source, most: u64, enough: &mut Enough<'_>) -> Result<u64, String> {
        let meaning = |error: Meaningless| error.why;
        let mut state = model.state(self.system).map_err(meaning)?;
        let mut now = BigRational::zero();
        for step in 0..most {
            let moves = state.moves().map_err(meaning)?;
            if let Some(one) = moves.iter().find(|one| matches!(one.action, Action::Draw(..))) {
                state = model.state(&drawn(one, &moves, source, step)?).map_err(meaning)?;
                continue;
            }
            let due: Vec<&Move> = moves.iter().filter(|one| matches!(one.action, Action::Tau(..))).collect();
            if let Some(first) = due.first() {
                state = self.communicated(model, first, &due[1..])?;
                continue;
            }
            let patience = state.patience(&moves);
            let end = match &patience {
                Patience::Until(time) => Some(&now + time),
                Patience::Unbounded => None,
                Patience::None => return Ok(step),
            };
            let last = end.as_ref().is_none_or(|end| *end > self.question.time);
            if enough(&state, (&now, end.as_ref()))? {
                return Ok(step);
            }
            let (Patience::Until(time), Some(end), false) = (patience, end, last) else { return Ok(step) };
            state = model.pass(&state, &time).map_err(meaning)?;
            now = end;
        }
        Err(format!("a run takes more than {most} steps"))
    }

    /// What one run shows over time, up to the time that is asked about.
    fn trajectory(&self, model: &Model, source: &Source) -> Result<Vec<Shown>, String> {
        let mut all = Vec::new();
        self.follow(model, source, MOST_DRAWN, &mut |state, (from, end)| {
            let until = end.filter(|end| **end <= self.question.time).unwrap_or(&self.question.time);
            all.push(Shown { from: from.clone(), until: until.clone(), what: crate::invariant::shown(state) });
            Ok(false)
        })?;
        Ok(all)
    }

    /// One communication; those that are due beside it must lead to the same state in either order.
    pub(super) fn communicated(&self, model: &Model, first: &Move, others: &[&Move]) -> Result<State, String> {
        let meaning = |error: Meaningless| error.why;
        let after = model.state(&first.next).map_err(meaning)?;
        let then = |state: &State, action: &Action| -> Result<Option<State>, String> {
            let moves = state.moves().map_err(meaning)?;
            match moves.iter().find(|one| one.action == *action) {
                Some(one) => model.state(&one.next).map(Some).map_err(meaning),
                None => Ok(None),
            }
        };
        for other in others {
            let instead = model.state(&other.next).map_err(meaning)?;
            if instead == after {
                continue;
            }
            let both = (then(&after, &other.action)?, then(&instead, &first.action)?);
            if both.0.is_none() || both.0 != both.1 {
                return Err("what happens depends on which of several communications comes first".to_string());
            }
        }
        Ok(after)
    }

    /// Whether what is asked for is shown in a state in which time passes.
    pub(super) fn shown(&self, state: &State) -> Result<bool, String> {
        let why = |error: ValueError| error.0;
        let nothing = Assumptions::default();
        let shown = crate::invariant::shown(state);
        for duty in self.event.duties(&shown).map_err(why)? {
            let decide = |test: &Test| test.decide(&nothing).ok_or_else(|| format!("it must be known whether {test}"));
            let mut all = true;
            for test in duty.premises.iter().chain(&duty.tests) {
                all = all && decide(test)?;
            }
            if all {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The process after a draw: one of finitely many outcomes, or a number drawn from a density.
fn drawn(one: &Move, all: &[Move], source: &Source, step: u64) -> Result<Term, String> {
    let Action::Draw(distributions, outcome) = &one.action else { return Err("this is no draw".to_string()) };
    if outcome.is_none() {
        let [distribution] = distributions.as_slice() else { return Err("several draws at once".to_string()) };
        let sampler = Sampler::of(&Distribution::of(distribution)?)?;
        let exact = sampler.exactly(source, step, 0);
        let number = exact.or_else(|| BigRational::from_float(sampler.draw(source, step, 0)));
        let number = number.ok_or("a number is drawn that is too large")?;
        return Ok(rounded(&one.with(&Value::rational(number))));
    }
    let (mut left, _) = source.uniform(step, 0);
    let mut chosen = one;
    for other in all {
        let Action::Draw(_, Some((_, chance))) = &other.action else { continue };
        chosen = other;
        left -= chance.to_f64().unwrap_or(0.0);
        if left <= 0.0 {
            break;
        }
    }
    Ok(chosen.next.clone())
}
