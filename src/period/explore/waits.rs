//! Who waits for ever.

use std::collections::BTreeSet;

use super::super::lonely::{self, Open, Waiting};
use super::super::step::{Place, inspect, offers};
use super::super::{Blocked, Edge, Failure, stuck};
use super::{Explorer, Target, Way, failure_of};
use crate::name::Name;

impl Explorer<'_> {
    /// Who waits for a read or a write at the end of some instant, with no delay to end the waiting.
    pub(super) fn waiting<'e>(&self, edges: impl Iterator<Item = &'e Edge>) -> Waiting {
        let mut waiting = Waiting::default();
        if !self.clock.users.keys().any(|port| self.clock.is_lonely(port)) {
            return waiting;
        }
        edges.for_each(|edge| lonely::at_the_end(edge, &mut waiting));
        for spot in self.spots.iter().filter(|spot| !spot.ways.is_empty()) {
            for (component, (run, name)) in spot.control.runs.iter().zip(self.clock.names).enumerate() {
                let Open { alone, beside } = Open::of(run);
                let own = |port: Name| self.clock.is_lonely(&port).then(|| (name.clone(), port));
                let ended = |port: &Name| self.clock.settler.ended.has(component, port);
                let (perhaps, surely): (Vec<Name>, Vec<Name>) = beside.into_iter().partition(ended);
                waiting.surely.extend(alone.into_iter().chain(surely).filter_map(own));
                waiting.perhaps.extend(perhaps.into_iter().filter_map(own));
            }
        }
        waiting
    }

    /// Reads and writes that wait for ever while the rest of the system goes on. Along one run a phase may be left without a way:
    /// it became another when a value of it, and so what remains of a delay, turned out to be a variable.
    pub(super) fn stuck(&self) -> Result<Vec<Blocked>, Failure> {
        let next = |way: &Way| match &way.next {
            Target::Spot(number, _) => Some(*number),
            Target::End(_) => None,
        };
        let edges: Vec<Vec<Option<usize>>> =
            self.spots.iter().map(|spot| spot.ways.iter().map(next).collect()).collect();
        let mut found = BTreeSet::new();
        for members in stuck::final_parts(&edges) {
            let moved: BTreeSet<usize> = members
                .iter()
                .flat_map(|spot| &self.spots[*spot].ways)
                .flat_map(|way| way.moved.iter().copied())
                .collect();
            let goes_on = members.iter().any(|spot| !self.spots[*spot].ways.is_empty());
            let may_wait = goes_on && moved.len() < self.clock.names.len();
            let Some(one) = members.first().filter(|_| may_wait) else { continue };
            let state = self.state_of(*one).map_err(failure_of)?;
            for (component, run) in state.iter().enumerate().filter(|(component, _)| !moved.contains(component)) {
                let (mut delays, mut shown, mut waiting) = (Vec::new(), Vec::new(), Vec::new());
                inspect(run, &mut delays, &mut shown).map_err(failure_of)?;
                offers(run, &mut Place { component, branches: Vec::new() }, &mut waiting).map_err(failure_of)?;
                if delays.is_empty() {
                    found.extend(waiting.iter().map(|offer| self.clock.blocked(offer)));
                }
            }
        }
        Ok(found.into_iter().collect())
    }
}
