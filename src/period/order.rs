//! Whether the communications of one instant come out alike in every order: one order of them is followed, and of what
//! reads or writes a port it must be known that it came to that because of the communications made on it before, or else
//! it could have been first.
//!
//! What a part does comes after what the same part did, what it did before it branched, and what its branches did before
//! they were joined: all these stand at a place of which one begins with the other. What a reader does comes after what
//! its writer did, and the other way round. Nothing else is taken for a cause, so a race may be suspected where there is
//! none, but none is passed over.

use std::collections::BTreeSet;

use super::board::Board;
use super::step::{Offer, Place};
use crate::digest::Quick;
use crate::name::Name;

/// A communication that was made.
#[derive(Clone, Debug)]
struct Event {
    writer: Place,
    reader: Place,
}

/// What was communicated on a port in the instant.
#[derive(Clone, Copy, Debug)]
struct Last {
    /// The last communication.
    event: usize,
    /// The last one after which the writer did not write the same again at once: no other reader could have had it.
    taken: Option<usize>,
}

/// The communications of one instant, in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    events: Vec<Event>,
    on: Quick<Name, Last>,
}

/// Components that could have met on a port in another order.
pub(super) struct Rivals {
    pub(super) port: Name,
    pub(super) components: BTreeSet<usize>,
}

impl Order {
    /// Notes a communication.
    pub(super) fn made(&mut self, writer: &Offer, reader: &Offer) {
        let event = self.events.len();
        self.events.push(Event { writer: writer.place.clone(), reader: reader.place.clone() });
        let taken = self.on.get(&writer.port).and_then(|last| last.taken);
        self.on.insert(writer.port.clone(), Last { event, taken });
    }

    /// Notes that the writer of the last communication does not write the same again.
    pub(super) fn taken(&mut self, port: &Name) {
        if let Some(last) = self.on.get_mut(port) {
            last.taken = Some(last.event);
        }
    }

    /// Those that could have met this reader or writer, or been in its place, in another order.
    pub(super) fn rivals(&self, offer: &Offer) -> Option<Rivals> {
        let last = self.on.get(&offer.port)?;
        let writes = offer.value.is_some();
        let before = if writes { last.event } else { last.taken? };
        let same = self.events.get(before)?;
        let own = if writes { &same.writer } else { &same.reader };
        if one_part(own, &offer.place) || self.follows(&offer.place, before) {
            return None;
        }
        let components = BTreeSet::from([own.component, offer.place.component]);
        Some(Rivals { port: offer.port.clone(), components })
    }

    /// The same of all that waits, at the end of the instant, on a port on which something was communicated in it.
    pub(super) fn left(&self, board: &Board) -> Option<Rivals> {
        let mut ports: Vec<&Name> = self.on.keys().collect();
        ports.sort();
        ports.into_iter().find_map(|port| {
            [true, false].into_iter().find_map(|writes| board.on(port, writes).find_map(|offer| self.rivals(offer)))
        })
    }

    /// Whether what stands at a place now came to stand there because of this communication, among others.
    fn follows(&self, place: &Place, cause: usize) -> bool {
        // Of each component, where something stood that is known to be a cause; all that its part did before is one too.
        let mut causes: Quick<usize, Vec<&Place>> = Quick::default();
        causes.entry(place.component).or_default().push(place);
        for (number, event) in self.events.iter().enumerate().skip(cause).rev() {
            let parts = [&event.writer, &event.reader];
            let known =
                |part: &Place| causes.get(&part.component).is_some_and(|all| all.iter().any(|one| one_part(one, part)));
            if !parts.into_iter().any(known) {
                continue;
            }
            if number == cause {
                return true;
            }
            for part in parts {
                let all = causes.entry(part.component).or_default();
                if !all.contains(&part) {
                    all.push(part);
                }
            }
        }
        false
    }
}

/// Whether one of two places is in the other, or is the other.
fn one_part(one: &Place, other: &Place) -> bool {
    one.component == other.component && one.branches.iter().zip(&other.branches).all(|(one, other)| one == other)
}
