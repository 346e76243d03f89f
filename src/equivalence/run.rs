//! Evidence made concrete, and judged anew on the behaviours themselves before anybody sees it.

use super::Preorder;
use super::evidence::{Difference, Found};
use super::formula::{Formulas, Place};
use super::judge::{Doubt, Judge};
use crate::transition_system::{Behaviour, Label, TransitionSystem};

/// One step of a separating run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunStep {
    /// Whether the left side moves, and the right side answers.
    pub left_moves: bool,
    /// What is done.
    pub label: Label,
    /// The state of the left system after it; none where only the right side moves.
    pub left: Option<u32>,
    /// The state of the right system after it.
    pub right: Option<u32>,
}

/// Why two systems differ.
#[derive(Clone, Debug)]
pub struct Evidence {
    /// The formulas.
    pub formulas: Formulas,
    /// Holds of one side only.
    pub root: Place,
    /// Whether that is the left side.
    pub holds_left: bool,
    /// A shortest run that tells the two apart: each step of one side with the answer of the other that lasts longest.
    pub run: Vec<RunStep>,
    /// What then differs.
    pub difference: Difference,
}

impl Evidence {
    /// The formula as text, cut where it has more than this many letters.
    pub fn formula(&self, longest: usize) -> String {
        self.formulas.text(self.root, longest)
    }
}

/// How the classes of the compared system come from states.
pub(super) struct Concrete<'u> {
    /// The two systems side by side.
    pub(super) union: &'u TransitionSystem,
    /// Where the right system begins in it.
    pub(super) right: u32,
    /// The class of each state.
    pub(super) class: &'u [u32],
    /// Whether steps have internal steps around them.
    pub(super) weak: bool,
    /// Whether one side moves alone.
    pub(super) alone: bool,
    /// Whether the sides were exchanged.
    pub(super) turned: bool,
}

impl Concrete<'_> {
    /// The evidence with states of the two systems; `first` states are the left one's. None if the run cannot be
    /// followed, which would be a mistake of the search.
    pub(super) fn evidence(&self, found: Found, first: u32) -> Option<Evidence> {
        let mut judge = Judge::new(self.union);
        let (left, right) = (self.union.initial(), self.right);
        let (left, right) = if self.turned { (right, left) } else { (left, right) };
        let mut at = [judge.number(&left), judge.number(&right)];
        let mut run = Vec::new();
        for step in &found.steps {
            for (side, class) in [(0, step.left), (1, step.right)] {
                let moves = (side == 0) == step.left_moves;
                if self.alone && !moves {
                    continue;
                }
                let targets = if self.weak {
                    judge.weakly_after(at[side], &step.label)
                } else {
                    judge.after(at[side], &step.label)
                };
                let fits = |state: &u32| self.class[*judge.state(*state) as usize] == class;
                at[side] = targets.ok()?.into_iter().find(fits)?;
            }
            let state = |side: usize| {
                let state = *judge.state(at[side]);
                if state < first { state } else { state - first }
            };
            let stands = |side: usize| (!self.alone || (side == 0) == step.left_moves).then(|| state(side));
            run.push(RunStep {
                left_moves: step.left_moves != self.turned,
                label: step.label.clone(),
                left: stands(usize::from(self.turned)),
                right: stands(usize::from(!self.turned)),
            });
        }
        let difference = match found.difference {
            Difference::Looks(one, two) if self.turned => Difference::Looks(two, one),
            Difference::Step(left, label) => Difference::Step(left != self.turned, label),
            Difference::Chances(place, one, two) if self.turned => Difference::Chances(place, two, one),
            other => other,
        };
        let holds_left = found.holds_left != self.turned;
        Some(Evidence { formulas: found.formulas, root: found.root, holds_left, run, difference })
    }
}

/// Whether the formula holds of one behaviour and not of the other, and the run can be taken in both.
pub(super) fn stands<B: Behaviour>(
    evidence: &Evidence,
    sides: [&B; 2],
    states: [&dyn Fn(u32) -> Option<B::State>; 2],
    relation: Preorder,
) -> Result<bool, Doubt> {
    let weak = relation.is_weak();
    for (side, behaviour) in sides.into_iter().enumerate() {
        let mut judge = Judge::new(behaviour);
        let start = judge.start()?;
        let holds = judge.holds(&evidence.formulas, evidence.root, start)?;
        if holds != (evidence.holds_left == (side == 0)) {
            return Ok(false);
        }
        let mut at = start;
        for step in &evidence.run {
            let Some(number) = (if side == 0 { step.left } else { step.right }) else { continue };
            let Some(state) = states[side](number) else { return Ok(false) };
            let next = judge.number(&state);
            let targets = if weak { judge.weakly_after(at, &step.label)? } else { judge.after(at, &step.label)? };
            if !targets.contains(&next) {
                return Ok(false);
            }
            at = next;
        }
        let ends = match &evidence.difference {
            Difference::Chances(place, one, two) => {
                let wanted = if side == 0 { one } else { two };
                one != two && judge.chance(&evidence.formulas, *place, at)? == *wanted
            }
            Difference::Best(place, one, two) => {
                let wanted = if side == 0 { one } else { two };
                one != two && judge.worth(&evidence.formulas, *place, at)?.0 == *wanted
            }
            Difference::Step(left, label) => {
                let can = if weak { judge.weakly_after(at, label)? } else { judge.after(at, label)? };
                let moves = *left == (side == 0);
                // Otherwise that it cannot, in the way that counts, is what the formula says.
                let plain = !matches!(relation, Preorder::Branching | Preorder::Trace | Preorder::WeakTrace);
                if moves { !can.is_empty() || relation.is_trace() } else { can.is_empty() || !plain }
            }
            Difference::Looks(..) if relation == Preorder::WeakTrace => true,
            Difference::Looks(one, two) => {
                let (wanted, seen) = (if side == 0 { one } else { two }, judge.mark(at)?);
                seen.ending == wanted.ending && (weak || seen.shown == wanted.shown)
            }
        };
        if !ends {
            return Ok(false);
        }
    }
    Ok(true)
}
