//! All orders of the communications of an instant, in the executable meaning.

use std::collections::HashSet;

use pars::definition::Definitions;
use pars::model::{Action, Model, Patience};
use pars::term::Term;

/// Whether the order of the communications in some of the first instants leads to different states.
pub fn order_matters(whole: &Term, definitions: &Definitions, instants: usize) -> bool {
    let model = Model::new(definitions);
    let mut state = model.state(whole).expect("a meaning");
    for _ in 0..instants {
        let (mut ends, mut seen) = (HashSet::new(), HashSet::new());
        let mut stack = vec![state.clone()];
        while let Some(state) = stack.pop() {
            if !seen.insert(state.clone()) {
                continue;
            }
            let moves = state.moves().expect("moves");
            let taken: Vec<_> = moves.iter().filter(|step| matches!(step.action, Action::Tau(..))).collect();
            if taken.is_empty() {
                ends.insert(state);
            }
            stack.extend(taken.into_iter().map(|step| model.state(&step.next).expect("a meaning")));
            if ends.len() > 1 || seen.len() > 2_000 {
                return true;
            }
        }
        let Some(end) = ends.into_iter().next() else { return true };
        let moves = end.moves().expect("moves");
        let Patience::Until(time) = end.patience(&moves) else { return false };
        state = model.wait_state(&end, &time).expect("a meaning").expect("time passes");
    }
    false
}
