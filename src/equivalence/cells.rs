//! Processes with continuous draws, compared by cells of their values: a difference in this view is one, and where
//! nothing that depends on a value is seen and the chances are exact, so is that there is none.

use super::process::{ProcessAnswer, at_ticks};
use super::{Preorder, Verdict};
use crate::definition::Definitions;
use crate::term::Term;
use crate::transition_system::{Bounds, Inputs, Trouble};

/// How often cells are made smaller.
const MOST_CUTS: usize = 30;
/// The most states that are looked into with one choice of cells.
const MOST_STATES: usize = 5_000;

const ENCLOSED: &str = "alike by cells of the values that are drawn, with chances that are not exact";
const SEEN: &str = "alike by cells of the values that are drawn, but these values are seen, or written";

/// Compares them with the cells that are needed, which are given with the answer; none where no cells tell.
pub(super) fn by_cells(
    terms: [&Term; 2],
    definitions: &Definitions,
    inputs: &Inputs,
    relation: Preorder,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Option<(Inputs, ProcessAnswer)> {
    let mut inputs = inputs.clone();
    let mut cuts = inputs.cuts.take().unwrap_or_default();
    let bounds = Bounds { states: bounds.states.min(MOST_STATES), ..*bounds };
    for _ in 0..MOST_CUTS {
        inputs.cuts = Some(cuts.clone());
        match at_ticks(terms, definitions, &inputs, relation, &bounds, 0, stop) {
            Ok(mut found) => {
                if matches!(found.verdict, Verdict::Yes) {
                    let why = if found.cells.1 { Some(SEEN) } else { found.cells.0.then_some(ENCLOSED) };
                    if let Some(why) = why {
                        found.verdict = Verdict::Unknown(why.into());
                    }
                }
                return Some((inputs, found));
            }
            Err(Trouble::Cut(cut)) if cuts.cut(&cut.0, cut.1.clone()) => {}
            Err(Trouble::Probe(seen)) if cuts.probe(&seen.0, &seen.1, &seen.2) => {}
            Err(_) => return None,
        }
    }
    None
}
