//! Values that are drawn from continuous distributions: carried along as symbols, so that whatever is concluded holds for
//! almost all of them.
//!
//! Two draws need not give the same value on both sides, nor need they be from one distribution for the behaviours to be
//! equally likely (`x` and `1 - x`). So what depends on a symbol is never taken for a difference: labels, results and
//! what is shown may be alike if one of them mentions a symbol, and nothing is known of a state once a guard or a delay
//! asks for its value.

use std::collections::BTreeSet;

use super::game::{Key, Seen};
use super::{Difference, Side};
use crate::model::explore::Label;
use crate::model::{Action, Model, Move, Observation, Outcome, Patience, State, mentions_drawn};

/// The state after a draw from a continuous distribution, its value a symbol; none where what follows asks for it.
pub(super) fn symbolic_draw(model: &Model, state: &State, draw: &Move) -> Option<State> {
    let Action::Draw(from, None) = &draw.action else { return None };
    model.state(&draw.with(&state.next_drawn(from.first()?))).ok()
}

/// Whether two moves may be the same.
pub(super) fn alike(one: &Key, two: &Key) -> bool {
    match (one, two) {
        (Key::Act(Label::Act(one, _)), Key::Act(Label::Act(two, _))) if may_match(one, two) => true,
        _ => one == two,
    }
}

/// Whether both write to one port, and one of them a value that depends on a draw.
pub(super) fn may_match(one: &Action, two: &Action) -> bool {
    match (one, two) {
        (Action::Out(port, one), Action::Out(other, two)) => {
            port == other && (mentions_drawn(one) || mentions_drawn(two))
        }
        _ => false,
    }
}

/// Whether two outcomes surely differ.
pub(super) fn outcomes_differ(one: &Outcome, two: &Outcome) -> bool {
    match (one, two) {
        (Outcome::Stop(one), Outcome::Stop(two)) if one.values().chain(two.values()).any(mentions_drawn) => {
            !one.keys().eq(two.keys())
        }
        _ => one != two,
    }
}

/// Whether what is shown surely differs; in a refinement, whether the second surely shows something more.
pub(super) fn shown_differ(one: &BTreeSet<Observation>, two: &BTreeSet<Observation>, refines: bool) -> bool {
    if one.iter().chain(two).any(|(_, values)| values.iter().any(mentions_drawn)) {
        let names = |all: &BTreeSet<Observation>| all.iter().map(|(name, _)| name.clone()).collect::<BTreeSet<_>>();
        return shown_differ_plainly(&names(one), &names(two), refines);
    }
    shown_differ_plainly(one, two, refines)
}

fn shown_differ_plainly<T: Ord>(one: &BTreeSet<T>, two: &BTreeSet<T>, refines: bool) -> bool {
    if refines { !two.is_subset(one) } else { one != two }
}

/// How two states without a draw surely differ at once, if they do.
pub(super) fn difference(one: &Seen, two: &Seen, refines: bool) -> Option<Difference> {
    let (left, right) = (one.state.outcome(), two.state.outcome());
    if outcomes_differ(&left, &right) {
        return Some(Difference::Outcome(left, right));
    }
    if shown_differ(&one.shown, &two.shown, refines) {
        return Some(Difference::Observations(Box::new(one.state.clone()), Box::new(two.state.clone())));
    }
    for (side, mine, other) in [(Side::Left, one, two), (Side::Right, two, one)] {
        let answered = |key: &Key| other.moves.contains_key(key) || other.moves.keys().any(|answer| alike(answer, key));
        if let Some((_, targets)) = mine.moves.iter().find(|(key, _)| !answered(key)) {
            return targets.first().map(|(label, _)| Difference::Move(side, label.clone()));
        }
        if mine.patience != Patience::None && other.patience == Patience::None {
            return Some(Difference::Time(side));
        }
    }
    None
}

/// Each place once.
pub(super) fn distinct(places: impl Iterator<Item = usize>) -> Vec<usize> {
    places.collect::<BTreeSet<_>>().into_iter().collect()
}
