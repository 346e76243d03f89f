//! Runs that come to an end, or to a state in which nothing happens any more.

use super::{Follower, Lost, items, lost, parts_of, turn};
use crate::kernel::Theory;
use crate::law::Condition;
use crate::name::Name;
use crate::proof::{Proof, Statement, Step, StepId};
use crate::substitution::Substitution;
use crate::term::{Node, Term};

/// How a way through a network comes to an end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// It stops, whatever it then carries.
    Stopped,
    /// It aborts.
    Aborted,
    /// It goes on for ever as it is, and shows this.
    Silent(Vec<Term>),
}

/// Whether a run ends, and does not go on for ever.
pub(super) fn comes_to_an_end(parts: &[Term]) -> bool {
    parts.last().is_some_and(|last| match last.node() {
        Node::Stop | Node::Abort | Node::Set(..) | Node::Power(..) | Node::Guard(..) => true,
        _ => parts_of(last).is_some(),
    })
}

/// A proof that a network is weakly equal to these stretches and then such an end.
///
/// # Errors
/// Where the network cannot be followed, or ends otherwise.
pub fn ends(
    theory: &Theory,
    hypotheses: &[Condition],
    from: &Term,
    (stretches, end): (&[Term], &End),
) -> Result<Proof, Lost> {
    let mut follower = Follower::new(theory, hypotheses, false);
    let (start, mut state) = follower.settled(from)?;
    let mut chain = vec![start];
    if !stretches.is_empty() {
        let (step, next) = follower.along(stretches, state)?;
        chain.push(step);
        state = next;
    }
    if let End::Silent(shown) = end {
        let step = follower.script.push(Step::Advance(state.clone(), None));
        let rest = follower.instant(&state)?.rest().map_err(|stuck| Lost(stuck.0))?;
        state = Term::disable(shown.iter().cloned());
        let step = follower.same(step, &rest, &state)?;
        chain.push(follower.behind(stretches, step));
    } else if is_an_end(&state).as_ref() != Some(end) {
        return lost("it does not end so");
    }
    follower.script.chain(chain);
    let right = Term::seq(stretches.iter().cloned().chain([state]));
    let (connective, hypotheses) = (follower.connective(), hypotheses.to_vec());
    let statement = Statement { hypotheses, left: from.clone(), connective, right };
    Ok(Proof { lemmas: follower.lemmas, statement, steps: follower.script.steps })
}

/// `Abort`, or `Stop` behind what is carried.
fn is_an_end(state: &Term) -> Option<End> {
    match state.node() {
        Node::Abort => Some(End::Aborted),
        Node::Stop => Some(End::Stopped),
        _ => items(state).iter().all(|part| matches!(part.node(), Node::Set(..))).then_some(End::Stopped),
    }
}

impl Follower<'_> {
    /// Proves that a state is weakly equal to a run that ends.
    pub(super) fn ending(&mut self, mut parts: Vec<Term>, state: Term) -> Result<StepId, Lost> {
        let run = Term::seq(parts.iter().cloned());
        let written = matches!(parts.last().map(Term::node), Some(Node::Stop | Node::Abort));
        let end = match (written, parts.last().cloned()) {
            (true, Some(last)) => {
                parts.pop();
                last
            }
            _ => {
                let set = |(name, value)| Term::new(Node::Set(value, name));
                Term::seq(turn::starts(&mut parts).into_iter().map(set))
            }
        };
        let (step, found) = self.along(&parts, state)?;
        let behind = |end: &Term| Term::seq(parts.iter().cloned().chain([end.clone()]));
        if is_an_end(&found).is_none() {
            return lost("the run ends, and the system does not");
        }
        let step = self.same(step, &behind(&found), &behind(&end))?;
        if behind(&end) == run {
            return Ok(step);
        }
        let processes = [(Name::new("?P"), Term::seq(parts))].into();
        let with = Substitution { processes, ..Substitution::default() };
        let law = self.script.push(Step::Law(Name::new("seq-stop-right"), with));
        Ok(self.script.chain(vec![step, law]))
    }
}
