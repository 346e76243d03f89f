//! That a system runs as it is said to: the system is followed stretch by stretch along the run, as the kernel will
//! follow it, until the loop of the run leads back to the state at which it began.

mod draw;
mod end;
mod endless;
mod rounds;
mod shape;
mod split;
mod turn;

use std::collections::BTreeMap;

pub use draw::{draws, due, goes_on};
pub use end::{End, ends};
use num_traits::ToPrimitive;
use shape::{alike, told_apart};
pub use split::{either, passes, runs, runs_where};
pub use turn::interval_around;

use crate::advance::{Instant, stretch};
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Lemma, Proof, Script, Statement, Step, StepId, hole};
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Rounds that are followed one by one.
const MOST_ROUNDS: usize = 2_000;
/// Stretches that are followed in all; one of a large system counts for several.
const MOST_STRETCHES: usize = 20_000;

const TOO_LONG: &str = "it has too many stretches of time, for a system of this size";

/// For how many stretches one of this system counts.
fn share(state: &Term) -> usize {
    1 + width(state) / 64 + state.size() / 16_384
}

/// Why the system could not be followed.
#[derive(Clone, Debug)]
pub struct Lost(pub String);

fn lost<T>(why: impl Into<String>) -> Result<T, Lost> {
    Err(Lost(why.into()))
}

/// A proof that one network is weakly equal to these stretches and then another.
///
/// # Errors
/// As for [`runs`].
fn passes_as_they_are(
    theory: &Theory,
    hypotheses: &[Condition],
    (from, to): (&Term, &Term),
    stretches: &[Term],
) -> Result<Proof, Lost> {
    let mut follower = Follower::new(theory, hypotheses, false);
    let (start, state) = follower.settled(from)?;
    let (mut chain, mut state) = (vec![start], state);
    if stretches.len().saturating_mul(share(&state)) > MOST_STRETCHES {
        return lost(TOO_LONG);
    }
    if !stretches.is_empty() {
        let (step, next) = follower.along(stretches, state)?;
        chain.push(step);
        state = next;
    }
    let (end, wanted) = follower.settled(to)?;
    let behind = |last: &Term| Term::seq(stretches.iter().cloned().chain([last.clone()]));
    let step = follower.script.chain(chain);
    let step = follower.same(step, &behind(&state), &behind(&wanted))?;
    let back = follower.script.push(Step::Symmetric(end));
    let back = follower.behind(stretches, back);
    follower.script.chain(vec![step, back]);
    let statement = Statement {
        hypotheses: hypotheses.to_vec(),
        left: from.clone(),
        connective: Connective::Weak,
        right: behind(to),
    };
    Ok(Proof { lemmas: Vec::new(), statement, steps: follower.script.steps })
}

/// How the system may stand when each of some rounds begins, over the number of the round: what its closed forms tell.
#[derive(Clone, Debug)]
pub struct Stage {
    /// The system.
    pub network: Term,
    /// The number of the round in it.
    pub number: Name,
}

struct Follower<'t> {
    theory: &'t Theory,
    context: Context<'t>,
    stages: &'t [Stage],
    script: Script,
    lemmas: Vec<Lemma>,
    stretches: usize,
    /// Whether a lemma about rounds is being proved.
    inside: bool,
    /// Whether the run may show less than the system does.
    forgets: bool,
    /// Whether it did.
    forgot: bool,
}

/// A duration and what is shown meanwhile.
fn parts_of(item: &Term) -> Option<(Value, Vec<Term>)> {
    let all = match item.node() {
        Node::Disable(parts) => parts.clone(),
        _ => vec![item.clone()],
    };
    let mut time = None;
    let mut shown = Vec::new();
    for part in all {
        match part.node() {
            Node::Delay(length) if time.is_none() => time = Some(length.clone()),
            Node::Observe(..) => shown.push(part),
            Node::Idle => {}
            _ => return None,
        }
    }
    Some((time?, shown))
}

/// What is shown for ever, where it is nothing else.
fn observers(term: &Term) -> Option<Vec<Term>> {
    let all = match term.node() {
        Node::Disable(parts) => parts.clone(),
        _ => vec![term.clone()],
    };
    let shown = all.iter().filter(|part| !matches!(part.node(), Node::Idle));
    shown.map(|part| matches!(part.node(), Node::Observe(..)).then(|| part.clone())).collect()
}

fn items(term: &Term) -> Vec<Term> {
    match term.node() {
        Node::Seq(parts) => parts.to_vec(),
        _ => vec![term.clone()],
    }
}

/// How many parts run side by side in a network.
fn width(network: &Term) -> usize {
    let mut body = network;
    while let Node::New(_, inner) = body.node() {
        body = inner;
    }
    if let Node::Par(parts) = body.node() { parts.len() } else { 1 }
}

impl<'t> Follower<'t> {
    fn new(theory: &'t Theory, hypotheses: &'t [Condition], inside: bool) -> Follower<'t> {
        let context = Context::new(&theory.assumptions, &theory.definitions, hypotheses);
        let (script, lemmas) = (Script::default(), Vec::new());
        Follower { theory, context, stages: &[], script, lemmas, stretches: 0, inside, forgets: false, forgot: false }
    }

    /// What has been proved so far is at least this.
    fn connective(&self) -> Connective {
        if self.forgot { Connective::WeaklyRefines } else { Connective::Weak }
    }

    fn instant(&self, state: &Term) -> Result<Instant, Lost> {
        Instant::of(state, &self.context).map_err(|stuck| Lost(stuck.0))
    }

    /// The end of the instant in which the system is.
    fn settled(&mut self, system: &Term) -> Result<(StepId, Term), Lost> {
        let state = self.instant(system)?.network();
        Ok((self.script.push(Step::Advance(system.clone(), Some(Value::zero()))), state))
    }

    /// Proves that a state is weakly equal to a whole run.
    fn whole(&mut self, run: &Term, state: Term) -> Result<StepId, Lost> {
        let mut parts = items(run);
        if end::comes_to_an_end(&parts) {
            return self.ending(parts, state);
        }
        let Some(last) = parts.pop() else { return lost("the run is empty") };
        let starts = if matches!(last.node(), Node::Loop(_)) { turn::starts(&mut parts) } else { Vec::new() };
        let (end, state_at_end, before) = if parts.is_empty() {
            (None, state, Vec::new())
        } else {
            let (step, next) = self.along(&parts, state)?;
            (Some(step), next, parts)
        };
        let tail = match last.node() {
            Node::Loop(body) => self.round_and_round(body, &starts, &state_at_end)?,
            _ => self.at_rest(&state_at_end, &last)?,
        };
        Ok(match end {
            None => tail,
            Some(step) => {
                let behind = self.behind(&before, tail);
                self.script.chain(vec![step, behind])
            }
        })
    }

    /// Proves that a state is weakly equal to what it shows for ever, or that it goes on for ever.
    fn at_rest(&mut self, state: &Term, shown: &Term) -> Result<StepId, Lost> {
        let instant = self.instant(state)?;
        if self.forgets
            && !instant.delays().is_empty()
            && let Some(shown) = observers(shown)
        {
            return self.for_ever(state, &shown);
        }
        let rest = instant.rest().map_err(|stuck| Lost(stuck.0))?;
        let step = self.script.push(Step::Advance(state.clone(), None));
        self.same(step, &rest, shown)
    }

    /// From `… ~~ found`, `… ~~ wanted`, if their values are equal.
    fn same(&mut self, step: StepId, found: &Term, wanted: &Term) -> Result<StepId, Lost> {
        if found == wanted {
            return Ok(step);
        }
        if !alike(found, wanted, &self.context) {
            return lost(told_apart(found, wanted, &self.context));
        }
        let equal = self.script.push(Step::Arithmetic(found.clone(), wanted.clone()));
        Ok(self.script.chain(vec![step, equal]))
    }

    /// A step used behind these parts.
    fn behind(&mut self, before: &[Term], step: StepId) -> StepId {
        let shape = Term::seq(before.iter().cloned().chain([Term::meta(&hole(1))]));
        self.script.push(Step::Congruence(shape, vec![step]))
    }

    /// A step used before a term.
    fn before(&mut self, step: StepId, after: &Term) -> StepId {
        self.script.push(Step::Congruence(Term::seq([Term::meta(&hole(1)), after.clone()]), vec![step]))
    }

    /// Proves `state ~~ parts ; next`: of both halves, so that what is said of all does not grow with each part.
    fn along(&mut self, parts: &[Term], state: Term) -> Result<(StepId, Term), Lost> {
        match parts {
            [] => lost("nothing passes"),
            [part] => self.past(part, &state),
            _ => {
                let (first, rest) = parts.split_at(parts.len() / 2);
                let (step, middle) = self.along(first, state)?;
                let (onward, next) = self.along(rest, middle)?;
                let behind = self.behind(first, onward);
                Ok((self.script.chain(vec![step, behind]), next))
            }
        }
    }

    /// Proves `state ~~ part ; next`.
    fn past(&mut self, part: &Term, state: &Term) -> Result<(StepId, Term), Lost> {
        if let Some((time, shown)) = parts_of(part) {
            return self.stretch(part, (&time, &shown), state);
        }
        match part.node() {
            Node::Seq(parts) => self.along(parts, state.clone()),
            Node::Power(body, count, index) => {
                let number = count.as_rational().filter(|number| number.is_integer());
                match number.and_then(|number| number.to_integer().to_usize()) {
                    Some(number) if number <= MOST_ROUNDS => self.counted(body, index.as_ref(), number, state),
                    _ => self.rounds(body, index.as_ref(), count, state),
                }
            }
            Node::Guard(relation, left, right) => Ok((self.holding((*relation, left, right), state), state.clone())),
            _ => lost(format!("{part} is no stretch of time")),
        }
    }

    /// Proves `state = guard ; state` for a guard that holds; the kernel asks whether it does.
    fn holding(&mut self, (relation, left, right): (Relation, &Value, &Value), state: &Term) -> StepId {
        let law = match relation {
            Relation::Eq => "eq-true",
            Relation::Neq => "neq-true",
            Relation::Gtr => "gtr-true",
            Relation::Gte => "gte-true",
            Relation::Lss => "lss-true",
            Relation::Lte => "lte-true",
        };
        let values = [(Name::new("?x"), left.clone()), (Name::new("?y"), right.clone())];
        let with = Substitution { values: values.into(), ..Substitution::default() };
        let holds = self.script.push(Step::Law(Name::new(law), with));
        let holds = self.before(holds, state);
        let processes = [(Name::new("?P"), state.clone())];
        let with = Substitution { processes: processes.into(), ..Substitution::default() };
        let stop = self.script.push(Step::Law(Name::new("seq-stop-left"), with));
        let forward = self.script.chain(vec![holds, stop]);
        self.script.push(Step::Symmetric(forward))
    }

    /// One stretch of the run, in which parts of the system that show nothing may end.
    fn stretch(&mut self, part: &Term, (time, shown): (&Value, &[Term]), state: &Term) -> Result<(StepId, Term), Lost> {
        let mut state = state.clone();
        let mut passed: Option<(StepId, Value)> = None;
        let mut left = time.clone();
        loop {
            self.stretches += share(&state);
            if self.stretches > MOST_STRETCHES {
                return lost(TOO_LONG);
            }
            let instant = self.instant(&state)?;
            let step_time = self.least(&instant.delays(), &left)?;
            let next = instant.after(&step_time, &self.context).map_err(|stuck| Lost(stuck.0))?;
            let step = self.script.push(Step::Advance(state.clone(), Some(step_time.clone())));
            let whole = step_time == left;
            let step = self.showing(step, (&step_time, &instant.shown()), shown, &next)?;
            let (step, sum) = match passed {
                None => (step, step_time.clone()),
                Some((before, so_far)) => {
                    let behind = self.behind(&[stretch(&so_far, shown)], step);
                    let chained = self.script.chain(vec![before, behind]);
                    let (added, sum) = self.added(&so_far, &step_time, shown)?;
                    let added = self.before(added, &next);
                    (self.script.chain(vec![chained, added]), sum)
                }
            };
            state = next;
            if whole {
                let found = Term::seq([stretch(&sum, shown), state.clone()]);
                let step = self.same(step, &found, &Term::seq([part.clone(), state.clone()]))?;
                return Ok((step, state));
            }
            left = left.sub(&step_time).map_err(|error| Lost(error.0))?;
            passed = Some((step, sum));
        }
    }

    /// The time until the next delay runs out, no more than what is left.
    fn least(&self, delays: &[Value], left: &Value) -> Result<Value, Lost> {
        let mut least = left.clone();
        for delay in delays {
            match self.context.assumptions.decide(Relation::Lte, &least, delay) {
                Some(true) => {}
                Some(false) => least = delay.clone(),
                None => return lost(format!("whether {least} <= {delay}")),
            }
        }
        Ok(least)
    }

    /// `(Delay_a # O) ; (Delay_b # O) = Delay_{a+b} # O`, with the sum.
    fn added(&mut self, first: &Value, second: &Value, shown: &[Term]) -> Result<(StepId, Value), Lost> {
        let sum = first.add(second).map_err(|error| Lost(error.0))?;
        let meta = |name: &str| Name::new(name);
        let with = Substitution {
            values: BTreeMap::from([(meta("?a"), first.clone()), (meta("?b"), second.clone())]),
            processes: BTreeMap::from([(meta("?O"), Term::disable(shown.iter().cloned()))]),
            ..Substitution::default()
        };
        let law = self.script.push(Step::Law(Name::new("delay-sum"), with));
        if !shown.is_empty() {
            return Ok((law, sum));
        }
        let alone = |time: &Value, script: &mut Script| {
            let processes = BTreeMap::from([(Name::new("?P"), Term::delay(time.clone()))]);
            let with = Substitution { processes, ..Substitution::default() };
            script.push(Step::Law(Name::new("disable-idle"), with))
        };
        let (one, other) = (alone(first, &mut self.script), alone(second, &mut self.script));
        let both = Term::seq([Term::meta(&hole(1)), Term::meta(&hole(2))]);
        let both = self.script.push(Step::Congruence(both, vec![one, other]));
        let back = self.script.push(Step::Symmetric(both));
        let all = alone(&sum, &mut self.script);
        Ok((self.script.chain(vec![back, law, all]), sum))
    }
}
