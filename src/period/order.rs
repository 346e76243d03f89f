//! Whether the communications of one instant come out alike in every order: one order of them is followed, and wherever
//! two of them exclude each other it must be known that the one had to come first.
//!
//! They do in two ways. What reads or writes a port again could have been in the place of who did before, unless it came
//! to that because of the communication before. What ends a `#` could have come before what its other branches did, and
//! what they waited for could have come before it.
//!
//! What a part does comes after what the same part did, what it did before it branched, and what its branches did before
//! they were joined: all these stand at a place of which one begins with the other. What a reader does comes after what
//! its writer did, and the other way round. A communication that leaves a part as it was, such as the value of a sensor
//! that is read, is no cause of what that part does later. Nothing else is taken for a cause, so a race may be suspected where there is
//! none, but none is passed over.

use std::collections::BTreeSet;

use super::step::{Offer, Place};
use crate::digest::Quick;
use crate::name::Name;

/// A communication that was made.
#[derive(Clone, Debug)]
struct Event {
    port: Name,
    writer: Place,
    reader: Place,
    /// Whether the component that wrote, or read, then was as before: so nothing that it does later has it as a cause.
    as_before: [bool; 2],
}

/// What was communicated on a port in the instant.
#[derive(Clone, Copy, Debug)]
struct Last {
    /// The last communication.
    event: usize,
    /// The last one after which the writer did not write the same again at once: no other reader could have had it.
    taken: Option<usize>,
}

/// A read or write that waited in vain when a communication ended the `#` around it.
#[derive(Clone, Debug)]
struct Killed {
    component: usize,
    writes: bool,
    event: usize,
}

/// The communications of one instant, in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub(super) struct Order {
    events: Vec<Event>,
    on: Quick<Name, Last>,
    killed: Quick<Name, Vec<Killed>>,
}

impl Order {
    /// Notes a communication.
    pub(super) fn made(&mut self, writer: &Offer, reader: &Offer) {
        let event = self.events.len();
        let port = writer.port.clone();
        let (writer, reader) = (writer.place.clone(), reader.place.clone());
        self.events.push(Event { port: port.clone(), writer, reader, as_before: [false; 2] });
        let taken = self.on.get(&port).and_then(|last| last.taken);
        self.on.insert(port, Last { event, taken });
    }

    /// Notes whether the components that wrote and read last are as they were before.
    pub(super) fn left(&mut self, as_before: [bool; 2]) {
        if let Some(event) = self.events.last_mut() {
            event.as_before = as_before;
        }
    }

    /// Notes that the writer of the last communication does not write the same again.
    pub(super) fn taken(&mut self, port: &Name) {
        if let Some(last) = self.on.get_mut(port) {
            last.taken = Some(last.event);
        }
    }

    /// Notes that the last communication ended what waits here.
    pub(super) fn kills(&mut self, offer: &Offer) {
        let (component, writes) = (offer.place.component, offer.value.is_some());
        let killed = Killed { component, writes, event: self.events.len().saturating_sub(1) };
        self.killed.entry(offer.port.clone()).or_default().push(killed);
    }

    /// The components of which one now reads or writes a port and the other did before, where it could be otherwise.
    pub(super) fn rivals(&self, offer: &Offer) -> Option<BTreeSet<usize>> {
        let last = self.on.get(&offer.port)?;
        let writes = offer.value.is_some();
        let before = if writes { last.event } else { last.taken? };
        let same = self.events.get(before)?;
        let own = if writes { &same.writer } else { &same.reader };
        if one_part(own, &offer.place) || self.follows(&offer.place, before) {
            return None;
        }
        Some(BTreeSet::from([own.component, offer.place.component]))
    }

    /// The component in which a communication ended what would have answered this, and the port of that communication,
    /// where it needs not have come first.
    pub(super) fn missed(&self, offer: &Offer) -> Option<(usize, &Name)> {
        let mut killed = self.killed.get(&offer.port)?.iter().filter(|killed| killed.writes != offer.value.is_some());
        let first = killed.find(|killed| !self.follows(&offer.place, killed.event))?;
        self.events.get(first.event).map(|event| (first.component, &event.port))
    }

    /// The port of a communication in another branch than this place at this depth, which the last communication, made
    /// here, needs not have waited for.
    pub(super) fn cut_off(&self, place: &Place, depth: usize) -> Option<&Name> {
        let (own, earlier) = (place.branches.get(depth)?, self.events.split_last()?.1);
        let beside = |part: &Place| {
            part.component == place.component
                && part.branches.get(..depth) == place.branches.get(..depth)
                && part.branches.get(depth).is_some_and(|branch| branch != own)
        };
        let mut all = earlier.iter().enumerate().filter(|(_, event)| beside(&event.writer) || beside(&event.reader));
        all.find(|(number, _)| !self.follows(place, *number)).map(|(_, event)| &event.port)
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
            if !parts.into_iter().zip(event.as_before).any(|(part, as_before)| !as_before && known(part)) {
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
