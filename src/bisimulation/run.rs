//! Checking a separating run anew, step by step, against the model.

use std::collections::BTreeSet;

use super::draw::{may_match, outcomes_differ, shown_differ, symbolic_draw};
use super::weak::settled;
use super::{Comparison, Difference, Reach, Run, Side, Step, compare};
use crate::definition::Definitions;
use crate::law::Connective;
use crate::model::explore::Label;
use crate::model::{Action, Meaningless, Model, Observation, Patience, State};
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
        if connective.is_weak() {
            let moved = if step.side == Side::Left { (&left, &right) } else { (&right, &left) };
            let (mine, others) = weak_answers(&model, moved, step, connective)?;
            if !answered(&mine, &others, step, connective, definitions, reach)? {
                return Ok(false);
            }
            (left, right) = (step.left.clone(), step.right.clone());
            continue;
        }
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
            (Side::Left, label) => (after(&model, &left, label, false)?, after(&model, &right, label, true)?),
            (_, label) => (after(&model, &right, label, false)?, after(&model, &left, label, true)?),
        };
        if !answered(&mine, &others, step, connective, definitions, reach)? {
            return Ok(false);
        }
        (left, right) = (step.left.clone(), step.right.clone());
    }
    differs(&model, &left, &right, connective, &run.difference)
}

/// Whether the step is among those of its side, its answer among the answers, and no other answer would do.
fn answered(
    mine: &[State],
    others: &[State],
    step: &Step,
    connective: Connective,
    definitions: &Definitions,
    reach: &Reach,
) -> Result<bool, Meaningless> {
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
    Ok(true)
}

/// Where the step may lead its side, and where internal steps, the step and internal steps lead the other.
fn weak_answers(
    model: &Model,
    (mine, other): (&State, &State),
    step: &Step,
    connective: Connective,
) -> Result<(Vec<State>, Vec<State>), Meaningless> {
    let mut answers = Vec::new();
    if matches!(&step.label, Label::Act(Action::Tau(..), _)) {
        return Ok((after(model, mine, &step.label, false)?, settled(model, other.clone())?));
    }
    let shown = mine.observations();
    for state in settled(model, other.clone())? {
        let next = match &step.label {
            Label::Wait(time) if shows(connective, step.side, &shown, &state.observations()) => {
                model.wait_state(&state, time)?.into_iter().collect()
            }
            label => after(model, &state, label, true)?,
        };
        for next in next {
            answers.extend(settled(model, next)?);
        }
    }
    let targets = match &step.label {
        Label::Wait(time) => model.wait_state(mine, time)?.into_iter().collect(),
        label => after(model, mine, label, false)?,
    };
    Ok((targets, answers))
}

/// Whether the other side shows what the side that moves shows, or, in a refinement, the right side no more.
fn shows(connective: Connective, side: Side, mine: &BTreeSet<Observation>, other: &BTreeSet<Observation>) -> bool {
    match (connective.refines(), side) {
        (false, _) => mine == other,
        (true, Side::Left) => other.is_subset(mine),
        (true, _) => mine.is_subset(other),
    }
}

/// Whether one side shows, in every state in which it can let time pass now, other things than the second state.
fn shows_apart(model: &Model, left: &State, right: &State, connective: Connective) -> Result<bool, Meaningless> {
    let waits = |state: &State| Ok::<_, Meaningless>(state.patience(&state.moves()?) != Patience::None);
    for (side, mine, other) in [(Side::Left, left, right), (Side::Right, right, left)] {
        if !waits(mine)? {
            continue;
        }
        let shown = mine.observations();
        let mut answered = false;
        for state in settled(model, other.clone())? {
            answered |= waits(&state)? && shows(connective, side, &shown, &state.observations());
        }
        if !answered {
            return Ok(true);
        }
    }
    Ok(false)
}

/// A state in which a draw with a single branch has been made, or one from a continuous distribution, as a symbol.
fn drawn(model: &Model, mut state: State) -> Result<State, Meaningless> {
    for _ in 0..1000 {
        state = match state.moves()?.as_slice() {
            [only] if matches!(only.action, Action::Draw(_, Some(_))) => model.state(&only.next)?,
            [only] if matches!(only.action, Action::Draw(_, None)) => match symbolic_draw(model, &state, only) {
                Some(state) => state,
                None => return Err(Meaningless { why: "what it does depends on a draw".into() }),
            },
            _ => break,
        };
    }
    Ok(state)
}

/// The states after a move with this label; all internal steps are alike. If `like`, also after one that may be alike.
fn after(model: &Model, state: &State, label: &Label, like: bool) -> Result<Vec<State>, Meaningless> {
    let Label::Act(action, value) = label else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for step in state.moves()? {
        let alike = match (&step.action, action) {
            (Action::Tau(..), Action::Tau(..)) => true,
            (mine, wanted) => mine == wanted || (like && may_match(mine, wanted)),
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
        Difference::Outcome(one, two) => left.outcome() == *one && right.outcome() == *two && outcomes_differ(one, two),
        Difference::Observations(..) | Difference::Time(_) if connective.is_weak() => {
            shows_apart(model, left, right, connective)?
        }
        Difference::Move(side, label) if connective.is_weak() => {
            let (mine, other) = if *side == Side::Left { (left, right) } else { (right, left) };
            let mut able = false;
            for state in settled(model, other.clone())? {
                able |= !after(model, &state, label, true)?.is_empty();
            }
            !after(model, mine, label, false)?.is_empty() && !able
        }
        Difference::Observations(..) => shown_differ(&left.observations(), &right.observations(), connective.refines()),
        Difference::Move(side, label) => {
            let (mine, other) = if *side == Side::Left { (left, right) } else { (right, left) };
            !after(model, mine, label, false)?.is_empty() && after(model, other, label, true)?.is_empty()
        }
        Difference::Time(side) => {
            let (mine, other) = if *side == Side::Left { (left, right) } else { (right, left) };
            let patience = |state: &State| Ok(state.patience(&state.moves()?) != Patience::None);
            patience(mine)? && !patience(other)?
        }
        Difference::Chances(one, two) => one != two,
    })
}
