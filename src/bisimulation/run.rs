//! Checking a separating run anew, step by step, against the model.

use super::{Comparison, Difference, Reach, Run, Side, compare};
use crate::definition::Definitions;
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Meaningless, Model, Patience, State};
use crate::term::Term;

/// Whether the run does tell the two terms apart: every step is possible, every answer that the other side could have
/// given instead differs too, and the difference at its end is there.
///
/// # Errors
/// [`Meaningless`] where a state that is reached has no meaning.
pub fn replay(
    left: &Term,
    right: &Term,
    connective: Connective,
    definitions: &Definitions,
    reach: &Reach,
    run: &Run,
) -> Result<bool, Meaningless> {
    let model = Model::new(definitions);
    let (mut left, mut right) = (drawn(&model, model.state(left)?)?, drawn(&model, model.state(right)?)?);
    for step in &run.steps {
        let (mine, others) = match (step.side, &step.label) {
            (Side::Both, Label::Wait(time)) => {
                let (Some(one), Some(two)) = (model.wait_state(&left, time)?, model.wait_state(&right, time)?) else {
                    return Ok(false);
                };
                (left, right) = (drawn(&model, one)?, drawn(&model, two)?);
                if left != step.left || right != step.right {
                    return Ok(false);
                }
                continue;
            }
            (Side::Left, label) => (after(&model, &left, label)?, after(&model, &right, label)?),
            (_, label) => (after(&model, &right, label)?, after(&model, &left, label)?),
        };
        let (target, answer) = match step.side {
            Side::Left => (&step.left, &step.right),
            _ => (&step.right, &step.left),
        };
        if !mine.contains(target) || !others.contains(answer) {
            return Ok(false);
        }
        for other in others.iter().filter(|other| *other != answer) {
            let (one, two) = if step.side == Side::Left { (target, other) } else { (other, target) };
            let judged = compare(&one.term(), &two.term(), connective, definitions, reach)?;
            if !matches!(judged, Comparison::Different(_)) {
                return Ok(false);
            }
        }
        (left, right) = (step.left.clone(), step.right.clone());
    }
    differs(&model, &left, &right, connective, &run.difference)
}

/// A state in which a draw with a single branch has been made.
fn drawn(model: &Model, mut state: State) -> Result<State, Meaningless> {
    for _ in 0..1000 {
        match state.moves()?.as_slice() {
            [only] if matches!(only.action, Action::Draw(_, Some(_))) => state = model.state(&only.next)?,
            _ => break,
        }
    }
    Ok(state)
}

/// The states after a move with this label; all internal steps are alike.
fn after(model: &Model, state: &State, label: &Label) -> Result<Vec<State>, Meaningless> {
    let Label::Act(action, value) = label else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for step in state.moves()? {
        let alike = match (&step.action, action) {
            (Action::Tau(..), Action::Tau(..)) => true,
            (mine, wanted) => mine == wanted,
        };
        if alike {
            let next = value.as_ref().map_or_else(|| step.next.clone(), |value| step.with(value));
            all.push(drawn(model, model.state(&next)?)?);
        }
    }
    Ok(all)
}

fn differs(
    model: &Model,
    left: &State,
    right: &State,
    connective: Connective,
    difference: &Difference,
) -> Result<bool, Meaningless> {
    Ok(match difference {
        Difference::Outcome(one, two) => left.outcome() == *one && right.outcome() == *two && one != two,
        Difference::Observations(..) => {
            let (one, two) = (left.observations(), right.observations());
            if connective == Connective::Refines { !two.is_subset(&one) } else { one != two }
        }
        Difference::Move(side, label) => {
            let (mine, other) = if *side == Side::Left { (left, right) } else { (right, left) };
            !after(model, mine, label)?.is_empty() && after(model, other, label)?.is_empty()
        }
        Difference::Time(side) => {
            let (mine, other) = if *side == Side::Left { (left, right) } else { (right, left) };
            let patience = |state: &State| Ok(state.patience(&state.moves()?) != Patience::None);
            patience(mine)? && !patience(other)?
        }
        Difference::Chances(one, two) => one != two,
    })
}
