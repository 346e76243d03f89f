//! Who offers what: the reads and writes that wait, by component and by port.

use std::collections::BTreeSet;

use super::run::{Halt, Run};
use super::step::{Offer, offers};
use crate::digest::Quick;
use crate::name::Name;

/// A place in the system: the component, then the branches of `|` and `#`.
type Place = Vec<usize>;

/// The places that wait on one port.
#[derive(Clone, Default)]
struct Waiting {
    writers: BTreeSet<Place>,
    readers: BTreeSet<Place>,
}

/// All offers of a system, kept up to date component by component.
#[derive(Clone, Default)]
pub(super) struct Board {
    own: Vec<Vec<Offer>>,
    ports: Quick<Name, Waiting>,
    /// Ports with a writer and a reader, by their first writer.
    ready: BTreeSet<(Place, Name)>,
}

impl Board {
    pub(super) fn new(components: usize) -> Board {
        Board { own: vec![Vec::new(); components], ..Board::default() }
    }

    /// Notes what a component offers now.
    pub(super) fn update(&mut self, component: usize, run: &Run) -> Result<(), Halt> {
        let mut found = Vec::new();
        offers(run, &mut vec![component], &mut found)?;
        let Some(own) = self.own.get_mut(component) else { return Ok(()) };
        let before = std::mem::replace(own, found);
        for offer in &before {
            self.change(offer, false);
        }
        for offer in self.own.get(component).cloned().unwrap_or_default() {
            self.change(&offer, true);
        }
        Ok(())
    }

    fn change(&mut self, offer: &Offer, here: bool) {
        let waiting = self.ports.entry(offer.port.clone()).or_default();
        let first = |waiting: &Waiting| {
            let writer = waiting.writers.first().filter(|_| !waiting.readers.is_empty());
            writer.map(|writer| (writer.clone(), offer.port.clone()))
        };
        if let Some(known) = first(waiting) {
            self.ready.remove(&known);
        }
        let places = if offer.value.is_some() { &mut waiting.writers } else { &mut waiting.readers };
        if here {
            places.insert(offer.place.clone());
        } else {
            places.remove(&offer.place);
        }
        self.ready.extend(first(waiting));
    }

    /// What a component offers.
    pub(super) fn of(&self, component: usize) -> &[Offer] {
        self.own.get(component).map_or(&[], Vec::as_slice)
    }

    /// All offers.
    pub(super) fn all(&self) -> impl Iterator<Item = &Offer> {
        self.own.iter().flatten()
    }

    fn at(&self, place: &Place) -> Option<&Offer> {
        self.of(*place.first()?).iter().find(|offer| offer.place == *place)
    }

    /// Whether this offer stands.
    pub(super) fn has(&self, offer: &Offer) -> bool {
        self.at(&offer.place).is_some_and(|other| same(offer, other))
    }

    /// The communication of the first writer that has a reader.
    pub(super) fn first(&self) -> Option<(Offer, Offer)> {
        let (writer, port) = self.ready.first()?;
        let reader = self.ports.get(port)?.readers.first()?;
        Some((self.at(writer)?.clone(), self.at(reader)?.clone()))
    }

    /// Who writes, or reads, a port.
    pub(super) fn on(&self, port: &Name, writes: bool) -> impl Iterator<Item = &Place> {
        self.ports
            .get(port)
            .into_iter()
            .flat_map(move |waiting| if writes { &waiting.writers } else { &waiting.readers })
    }

    /// The possible communications with a part in one of the components of this one, but not with its parts.
    pub(super) fn beside(&self, writer: &Offer, reader: &Offer) -> Vec<(Offer, Offer)> {
        let apart = |place: &Place| *place != writer.place && *place != reader.place;
        let components: BTreeSet<usize> =
            [&writer.place, &reader.place].into_iter().filter_map(|place| place.first().copied()).collect();
        let mut found = Vec::new();
        for offer in components.iter().flat_map(|component| self.of(*component)).filter(|offer| apart(&offer.place)) {
            let partners = self.on(&offer.port, offer.value.is_none()).filter(|place| apart(place));
            for partner in partners.filter_map(|place| self.at(place)) {
                let pair = if offer.value.is_some() { (offer, partner) } else { (partner, offer) };
                found.push((pair.0.clone(), pair.1.clone()));
            }
        }
        found
    }
}

/// Whether two offers are on the same port at the same place.
pub(super) fn same(one: &Offer, other: &Offer) -> bool {
    one.place == other.place && one.port == other.port && one.value.is_some() == other.value.is_some()
}
