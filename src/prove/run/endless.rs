//! What comes behind all that a property asks for, where the run is not written out: time passes for ever, and what is
//! asked for to the end is shown.

use super::shape::joined;
use super::turn::Turn;
use super::{Follower, Lost, lost};
use crate::advance::stretch;
use crate::name::Name;
use crate::proof::{Step, StepId, hole};
use crate::substitution::Substitution;
use crate::term::{Node, Term};
use crate::value::Value;

/// Stretches of time in which a turn is looked for, of a small system, and of the largest.
const MOST_AHEAD: usize = 300;
const LEAST_AHEAD: usize = 4;
/// Stretches of the turns that are tried in all, of a small system; one turn is tried of any.
const MOST_TRIED: usize = 2_000;

/// What a stretch of this system counts for.
fn weight(state: &Term) -> usize {
    1 + state.size() / 64
}

/// The states of a system, one stretch after the other.
struct Ahead {
    /// One more than there are stretches.
    states: Vec<Term>,
    times: Vec<Value>,
}

impl Ahead {
    /// Whether two turns of so many stretches follow one another from here, as far as durations and shapes tell.
    fn turns(&self, from: usize, turn: usize) -> bool {
        let like = |one: &Term, other: &Term| joined(one, other, &mut |one, _| Some(one.clone())).is_some();
        from + 2 * turn < self.states.len()
            && like(&self.states[from + turn], &self.states[from + 2 * turn])
            && (from..from + turn).all(|place| {
                self.times[place] == self.times[place + turn] && like(&self.states[place], &self.states[place + turn])
            })
    }

    fn time(&self, from: usize, stretches: usize) -> Result<Value, Lost> {
        let mut sum = Value::zero();
        for time in &self.times[from..from + stretches] {
            sum = sum.add(time).map_err(|error| Lost(error.0))?;
        }
        Ok(sum)
    }
}

impl Follower<'_> {
    /// Proves that a state is weakly refined by what it goes on to show, `Idle` where that is nothing: it neither ends nor
    /// stands still, as turns follow one another.
    pub(super) fn for_ever(&mut self, state: &Term, shown: &[Term]) -> Result<StepId, Lost> {
        let ahead = self.ahead(state)?;
        let (mut tried, mut first) = (0, None);
        for (from, turn) in
            (2..=ahead.times.len()).flat_map(|sum| (1..=sum / 2).map(move |turn| (sum - 2 * turn, turn)))
        {
            if !ahead.turns(from, turn) {
                continue;
            }
            if tried > 0 && tried + turn * weight(state) > MOST_TRIED {
                break;
            }
            tried += turn * weight(state);
            let (steps, lemmas) = (self.script.steps.len(), self.lemmas.len());
            match self.turns_from(&ahead, (from, turn), shown) {
                Ok(step) => return Ok(step),
                Err(why) => first = first.or(Some(why)),
            }
            self.script.steps.truncate(steps);
            self.lemmas.truncate(lemmas);
        }
        Err(first.unwrap_or_else(|| Lost("no turn is seen that comes again".to_string())))
    }

    fn ahead(&self, state: &Term) -> Result<Ahead, Lost> {
        let mut ahead = Ahead { states: vec![state.clone()], times: Vec::new() };
        let mut state = state.clone();
        let mut spent = 0;
        while ahead.times.len() < LEAST_AHEAD || spent < MOST_AHEAD {
            spent += weight(&state);
            let Ok(instant) = self.instant(&state) else { break };
            let delays = instant.delays();
            let Some(time) = delays.first().and_then(|first| self.least(&delays, first).ok()) else { break };
            let Ok(next) = instant.after(&time, &self.context) else { break };
            ahead.times.push(time);
            ahead.states.push(next.clone());
            state = next;
        }
        if ahead.times.is_empty() { lost("no time passes") } else { Ok(ahead) }
    }

    /// `X <~ (Delay_s # O) ; loop(Delay_t # O) = O`, with turns of length t behind what takes s.
    fn turns_from(&mut self, ahead: &Ahead, (from, turn): (usize, usize), shown: &[Term]) -> Result<StepId, Lost> {
        let time = ahead.time(from, turn)?;
        let turn = Turn::plain(vec![stretch(&time, shown)]);
        let again = self.turning(&turn, &[], &ahead.states[from])?;
        let all = self.loop_is_one(&time, shown);
        let again = self.script.chain(vec![again, all]);
        if from == 0 {
            return Ok(again);
        }
        let time = ahead.time(0, from)?;
        let before = [stretch(&time, shown)];
        let (first, next) = self.along(&before, ahead.states[0].clone())?;
        if next != ahead.states[from] {
            return lost("a turn begins elsewhere");
        }
        let again = self.behind(&before, again);
        let all = self.loop_is_one(&time, shown);
        let back = self.script.push(Step::Symmetric(all));
        let unrolled = self.behind(&before, back);
        let processes = [(Name::new("?P"), before[0].clone())].into();
        let with = Substitution { processes, ..Substitution::default() };
        let fold = self.script.push(Step::Law(Name::new("loop-fold"), with));
        Ok(self.script.chain(vec![first, again, unrolled, fold, all]))
    }

    /// `loop(Delay_t # O) = O`; of nothing, `loop(Delay_t) = Idle`.
    fn loop_is_one(&mut self, time: &Value, shown: &[Term]) -> StepId {
        let with = Substitution {
            values: [(Name::new("?a"), time.clone())].into(),
            processes: [(Name::new("?O"), Term::disable(shown.iter().cloned()))].into(),
            ..Substitution::default()
        };
        if !shown.is_empty() {
            return self.script.push(Step::Law(Name::new("loop-forever"), with));
        }
        let processes = [(Name::new("?P"), Term::delay(time.clone()))].into();
        let idle = Substitution { processes, ..Substitution::default() };
        let alone = self.script.push(Step::Law(Name::new("disable-idle"), idle));
        let shape = Term::new(Node::Loop(Term::meta(&hole(1))));
        let alone = self.script.push(Step::Congruence(shape, vec![alone]));
        let observed = self.script.push(Step::Symmetric(alone));
        let forever = self.script.push(Step::Law(Name::new("loop-forever"), with));
        self.script.chain(vec![observed, forever])
    }
}
