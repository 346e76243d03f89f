//! What the closed forms of a run tell of the whole system, for a proof that it runs so.

use std::collections::BTreeMap;

use super::{Leg, Outcome};
use crate::name::Name;
use crate::period::{Period, Phase};
use crate::prove::run::Stage;
use crate::substitution::substitute_values;
use crate::term::Term;
use crate::value::Value;

impl Outcome {
    /// How the system stands when each of the rounds of a leg begins, piece by piece of its closed forms.
    pub fn stages(&self) -> Vec<Stage> {
        self.period.as_ref().map_or_else(Vec::new, |period| self.stages_of(period))
    }

    /// The same of a run of this period.
    pub fn stages_of(&self, period: &Period) -> Vec<Stage> {
        let mut found = Vec::new();
        for leg in self.legs.iter().filter(|leg| !leg.closed.is_empty()) {
            let Some(phase) = period.phases.get(leg.phase) else { continue };
            let pieces = leg.closed.iter().map(|(_, closed)| closed.pieces.len()).max().unwrap_or(0);
            found.extend((0..pieces).filter_map(|piece| stage(phase, leg, piece)));
        }
        found
    }
}

/// The network of a phase, with the closed forms of a leg for its variables.
fn stage(phase: &Phase, leg: &Leg, piece: usize) -> Option<Stage> {
    let mut values: BTreeMap<Name, Value> = leg.start.clone();
    for (name, closed) in &leg.closed {
        let last = closed.pieces.len().checked_sub(1)?;
        values.insert(name.clone(), closed.pieces.get(piece.min(last))?.form.clone());
    }
    let unknown = |(name, value): (Name, Value)| (Name::new(&format!("?{name}")), value);
    let values = values.into_iter().map(unknown).collect();
    let network = substitute_values(&Term::par(phase.state.iter().cloned()), &values).ok()?;
    Some(Stage { network, number: leg.index.clone() })
}
