//! Who offers what: the reads and writes that wait, by component and by port.

use std::collections::BTreeSet;

use super::run::{Halt, Run};
use super::step::{Offer, Place, offers};
use crate::digest::Quick;
use crate::name::Name;

/// Places in order; most often there is one.
#[derive(Clone, Default)]
struct Places {
    first: Option<Place>,
    others: BTreeSet<Place>,
}

impl Places {
    fn insert(&mut self, mut place: Place) {
        match &mut self.first {
            None => self.first = Some(place),
            Some(first) if *first == place => {}
            Some(first) => {
                if place < *first {
                    std::mem::swap(first, &mut place);
                }
                self.others.insert(place);
            }
        }
    }

    fn remove(&mut self, place: &Place) {
        if self.first.as_ref() == Some(place) {
            self.first = self.others.pop_first();
        } else {
            self.others.remove(place);
        }
    }

    fn iter(&self) -> impl Iterator<Item = &Place> {
        self.first.iter().chain(&self.others)
    }
}

/// The places that wait on one port.
#[derive(Clone, Default)]
struct Waiting {
    writers: Places,
    readers: Places,
}

/// All offers of a system, kept up to date component by component.
#[derive(Clone)]
pub(super) struct Board {
    own: Vec<Vec<Offer>>,
    ports: Quick<Name, Waiting>,
    /// Ports with a writer and a reader, by their first writer.
    ready: BTreeSet<(Place, Name)>,
}

impl Board {
    /// Of so many components, with so many ports.
    pub(super) fn new(components: usize, ports: usize) -> Board {
        let ports = Quick::with_capacity_and_hasher(ports, Default::default());
        Board { own: vec![Vec::new(); components], ports, ready: BTreeSet::new() }
    }

    /// Notes what a component offers now.
    pub(super) fn update(&mut self, component: usize, run: &Run) -> Result<(), Halt> {
        let mut found = Vec::new();
        offers(run, &mut Place { component, branches: Vec::new() }, &mut found)?;
        found.shrink_to_fit();
        let before = self.own.get_mut(component).map(std::mem::take).unwrap_or_default();
        before.iter().for_each(|offer| self.change(offer, false));
        found.iter().for_each(|offer| self.change(offer, true));
        if let Some(own) = self.own.get_mut(component) {
            *own = found;
        }
        Ok(())
    }

    fn change(&mut self, offer: &Offer, here: bool) {
        let waiting = self.ports.entry(offer.port.clone()).or_default();
        let first = |waiting: &Waiting| {
            let writer = waiting.writers.first.as_ref().filter(|_| waiting.readers.first.is_some());
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
        self.of(place.component).iter().find(|offer| offer.place == *place)
    }

    /// Whether this offer stands.
    pub(super) fn has(&self, offer: &Offer) -> bool {
        self.at(&offer.place).is_some_and(|other| same(offer, other))
    }

    /// The communication of the first writer that has a reader.
    pub(super) fn first(&self) -> Option<(Offer, Offer)> {
        let (writer, port) = self.ready.first()?;
        let reader = self.ports.get(port)?.readers.first.as_ref()?;
        Some((self.at(writer)?.clone(), self.at(reader)?.clone()))
    }

    /// Who writes, or reads, a port.
    pub(super) fn on(&self, port: &Name, writes: bool) -> impl Iterator<Item = &Place> {
        self.ports
            .get(port)
            .into_iter()
            .flat_map(move |waiting| if writes { waiting.writers.iter() } else { waiting.readers.iter() })
    }

    /// The possible communications with a part in one of the components of this one, but not with its parts.
    pub(super) fn beside(&self, writer: &Offer, reader: &Offer) -> Vec<(Offer, Offer)> {
        let apart = |place: &Place| *place != writer.place && *place != reader.place;
        let components = BTreeSet::from([writer.place.component, reader.place.component]);
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
