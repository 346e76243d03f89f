//! Replaying a timed run in the executable meaning: what cannot be replayed is not shown as a refutation.

use std::collections::BTreeSet;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::model::{Action, Model};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Steps after which a replay is given up.
const MOST_STEPS: usize = 20_000;

/// Whether a closed system shows at each given time, once its internal steps at that time are done, the observers
/// given for it; only observers whose names are given in some entry are looked at. The system must be
/// deterministic: of several internal steps the first is taken.
pub fn replays(system: &Term, definitions: &Definitions, run: &[(Value, Vec<Term>)]) -> bool {
    let names: BTreeSet<Name> = run.iter().flat_map(|(_, shown)| shown).filter_map(observer).collect();
    let model = Model::new(definitions);
    let mut now = BigRational::zero();
    let mut steps = 0;
    let Ok(mut state) = model.state(system) else { return false };
    for (time, shown) in run {
        let Some(time) = time.as_rational() else { return false };
        if time < now {
            return false;
        }
        match model.wait_through(&state, &(&time - &now), &mut steps) {
            Some(next) => state = next,
            None => return false,
        }
        now = time;
        let wanted: BTreeSet<(Name, Vec<Value>)> = shown.iter().filter_map(parts).collect();
        let seen: BTreeSet<(Name, Vec<Value>)> =
            state.observations().into_iter().filter(|(name, _)| names.contains(name)).collect();
        if wanted != seen {
            return false;
        }
    }
    !run.is_empty()
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

impl Model<'_> {
    /// Lets time pass with all internal steps that come up, those due at the end included.
    fn wait_through(
        &self,
        from: &crate::model::State,
        time: &BigRational,
        steps: &mut usize,
    ) -> Option<crate::model::State> {
        let mut state = from.clone();
        let mut left = time.clone();
        loop {
            *steps += 1;
            if *steps > MOST_STEPS {
                return None;
            }
            let moves = state.moves().ok()?;
            if let Some(step) = moves.iter().find(|step| matches!(step.action, Action::Tau(..))) {
                state = self.state(&step.next).ok()?;
                continue;
            }
            if left.is_zero() {
                return Some(state);
            }
            let passed = match state.patience(&moves) {
                crate::model::Patience::None => return None,
                crate::model::Patience::Until(next) if next < left => next,
                _ => left.clone(),
            };
            state = self.wait_state(&state, &passed).ok()??;
            left -= passed;
        }
    }
}
