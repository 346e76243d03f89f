//! An instant in which the system comes back to where it was: time stops.

use super::Moment;
use crate::digest::Quick;
use crate::name::Name;
use crate::period::End;
use crate::period::run::Run;

/// An earlier state of an instant.
#[derive(Clone)]
pub(super) struct Earlier {
    /// What those components were that have changed since.
    pub(super) changed: Quick<usize, Run>,
    pub(super) hash: u64,
    /// How many communications had been made, and how much had been drawn.
    pub(super) at: usize,
    pub(super) draws: usize,
    /// The loops that have gone round since.
    pub(super) unfolded: Vec<Name>,
    /// How often it was looked for since, with other values.
    pub(super) tried: usize,
}

impl Earlier {
    /// The loops that have gone round since, each once.
    pub(super) fn cycle(&self) -> Vec<Name> {
        let mut cycle: Vec<Name> = Vec::new();
        for name in &self.unfolded {
            if !cycle.contains(name) {
                cycle.push(name.clone());
            }
        }
        cycle
    }

    /// Keeps what a component was before its first change.
    pub(super) fn keep(&mut self, component: usize, run: &Run) {
        self.changed.entry(component).or_insert_with(|| run.clone());
    }

    /// Whether all components are what they were.
    fn is(&self, state: &[Run]) -> bool {
        self.changed.iter().all(|(component, run)| state.get(*component) == Some(run))
    }
}

/// The end of time, if the system is where it was earlier in this instant. The earlier state is one of those after
/// 1, 2, 4, 8, … communications, so that any cycle is met in a few times its length.
pub(super) fn again(moment: &mut Moment) -> Option<End> {
    let made = moment.communications.len();
    if made == 0 {
        return None;
    }
    let hash = moment.hashes.1;
    if let Some(earlier) = moment.earlier.as_ref().filter(|earlier| earlier.hash == hash && earlier.at < made)
        && earlier.is(&moment.state)
        && earlier.draws == moment.path.draws.len()
    {
        return Some(End::Livelock { cycle: earlier.cycle(), changes: Vec::new() });
    }
    if made.is_power_of_two() && moment.earlier.as_ref().is_none_or(|earlier| earlier.at < made) {
        let draws = moment.path.draws.len();
        // By the next time as many communications will have been made again.
        let most = made.saturating_mul(2).min(moment.state.len());
        let changed = Quick::with_capacity_and_hasher(most, Default::default());
        moment.earlier = Some(Earlier { changed, hash, at: made, draws, unfolded: Vec::new(), tried: 0 });
    }
    None
}
