//! Replaying a timed run in the executable meaning: what cannot be replayed is not shown as a refutation.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::model::{Action, Model, Move, Patience, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Steps after which a replay is given up: longer than any run that is looked for.
const MOST_STEPS: usize = 400_000;

/// Whether some run of a closed system shows at each given time, once its internal steps at that time are done, the
/// observers given for it, and goes on showing them until the next of these times; only observers whose names are
/// given in some entry are looked at. All internal steps are followed, and all draws that have finitely many outcomes.
pub fn replays(system: &Term, definitions: &Definitions, run: &[(Value, Vec<Term>)]) -> bool {
    let names: BTreeSet<Name> = run.iter().flat_map(|(_, shown)| shown).filter_map(observer).collect();
    let model = Model::new(definitions);
    let Ok(state) = model.state(system) else { return false };
    let mut replay = Replay { model: &model, names, steps: 0 };
    let mut states = BTreeSet::from([state]);
    let mut now = BigRational::zero();
    let mut before = None;
    for (time, shown) in run {
        let Some(time) = time.as_rational().filter(|time| *time >= now) else { return false };
        let wanted: Seen = shown.iter().filter_map(parts).collect();
        let Some(reached) = replay.wait_through(states, &(&time - &now), before.as_ref()) else { return false };
        states = reached.into_iter().filter(|state| replay.seen(state) == wanted).collect();
        if states.is_empty() {
            return false;
        }
        (now, before) = (time, Some(wanted));
    }
    !run.is_empty()
}

/// Observers with their values.
type Seen = BTreeSet<(Name, Vec<Value>)>;

struct Replay<'a> {
    model: &'a Model<'a>,
    names: BTreeSet<Name>,
    steps: usize,
}

impl Replay<'_> {
    fn seen(&self, state: &State) -> Seen {
        state.observations().into_iter().filter(|(name, _)| self.names.contains(name)).collect()
    }

    /// The states after this time with all internal steps that come up, those due at the end included, where nothing
    /// else than this is shown meanwhile; none where that is given up.
    fn wait_through(
        &mut self,
        from: BTreeSet<State>,
        time: &BigRational,
        shown: Option<&Seen>,
    ) -> Option<BTreeSet<State>> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<(State, BigRational)> = from.into_iter().map(|state| (state, time.clone())).collect();
        let mut met: BTreeSet<(State, BigRational)> = open.iter().cloned().collect();
        while let Some((state, left)) = open.pop() {
            self.steps += 1;
            if self.steps > MOST_STEPS {
                return None;
            }
            let moves = state.moves().ok()?;
            let internal = |step: &&Move| matches!(step.action, Action::Tau(..) | Action::Draw(..));
            let mut next = Vec::new();
            for step in moves.iter().filter(internal) {
                if step.needs_value() {
                    return None;
                }
                next.push((self.model.state(&step.next).ok()?, left.clone()));
            }
            if next.is_empty() && left.is_zero() {
                reached.insert(state);
                continue;
            }
            if next.is_empty() && shown.is_none_or(|shown| self.seen(&state) == *shown) {
                let passed = match state.patience(&moves) {
                    Patience::None => continue,
                    Patience::Until(next) if next < left => next,
                    _ => left.clone(),
                };
                next.push((self.model.wait_state(&state, &passed).ok()??, &left - &passed));
            }
            open.extend(next.into_iter().filter(|place| met.insert(place.clone())));
        }
        Some(reached)
    }
}

fn observer(term: &Term) -> Option<Name> {
    parts(term).map(|(name, _)| name)
}

fn parts(term: &Term) -> Option<(Name, Vec<Value>)> {
    match term.node() {
        Node::Observe(name, values) => Some((name.clone(), values.clone())),
        _ => None,
    }
}
