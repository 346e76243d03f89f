//! Who offers what: the reads and writes that wait, by component and by port.

use std::collections::BTreeSet;

use super::run::{Halt, Run};
use super::step::{Offer, Place, offers};
use crate::digest::Quick;
use crate::name::Name;

/// A component, and which of its offers it is: ordered as their places are.
type Spot = (u32, u32);

/// Offers in the order of their places; most often there is one.
#[derive(Clone, Default)]
struct Spots {
    first: Option<Spot>,
    #[allow(clippy::box_collection)] // Hardly any port has others, and each has room for them.
    others: Option<Box<BTreeSet<Spot>>>,
}

impl Spots {
    fn insert(&mut self, mut spot: Spot) {
        match &mut self.first {
            None => self.first = Some(spot),
            Some(first) if *first == spot => {}
            Some(first) => {
                if spot < *first {
                    std::mem::swap(first, &mut spot);
                }
                self.others.get_or_insert_default().insert(spot);
            }
        }
    }

    fn remove(&mut self, spot: Spot) {
        if self.first == Some(spot) {
            self.first = self.others.as_mut().and_then(|others| others.pop_first());
        } else if let Some(others) = &mut self.others {
            others.remove(&spot);
        }
    }

    fn iter(&self) -> impl Iterator<Item = Spot> {
        self.first.iter().chain(self.others.iter().flat_map(|others| others.iter())).copied()
    }
}

/// What waits on one port.
#[derive(Clone, Default)]
struct Waiting {
    writers: Spots,
    readers: Spots,
}

impl Waiting {
    /// The first writer, if there is a reader.
    fn ready(&self) -> Option<Spot> {
        self.writers.first.filter(|_| self.readers.first.is_some())
    }
}

/// All offers of a system, kept up to date component by component.
#[derive(Clone)]
pub(super) struct Board {
    /// The offers of each component in the order of their places, each with the number of its port.
    own: Vec<Vec<(Offer, u32)>>,
    /// The number of each port: ports that are met together lie together.
    numbers: Quick<Name, u32>,
    /// By the number of the port.
    ports: Vec<Waiting>,
    /// Ports with a writer and a reader, by their first writer.
    ready: BTreeSet<(Spot, u32)>,
}

impl Board {
    /// Of so many components, with so many ports.
    pub(super) fn new(components: usize, ports: usize) -> Board {
        let numbers = Quick::with_capacity_and_hasher(ports, Default::default());
        let own = vec![Vec::new(); components];
        Board { own, numbers, ports: Vec::with_capacity(ports), ready: BTreeSet::new() }
    }

    /// Notes what a component offers now.
    pub(super) fn update(&mut self, component: usize, run: &Run) -> Result<(), Halt> {
        let mut found = Vec::new();
        offers(run, &mut Place { component, branches: Vec::new() }, &mut found)?;
        let mut offers = self.own.get_mut(component).map(std::mem::take).unwrap_or_default();
        for (place, (offer, port)) in offers.drain(..).enumerate() {
            self.change(spot(component, place), &offer, port, false);
        }
        offers.reserve_exact(found.len());
        for (place, offer) in found.into_iter().enumerate() {
            let port = self.number(&offer.port);
            self.change(spot(component, place), &offer, port, true);
            offers.push((offer, port));
        }
        if let Some(own) = self.own.get_mut(component) {
            *own = offers;
        }
        Ok(())
    }

    /// The number of a port, new or known.
    fn number(&mut self, port: &Name) -> u32 {
        if let Some(number) = self.numbers.get(port) {
            return *number;
        }
        let number = short(self.ports.len());
        self.ports.push(Waiting::default());
        self.numbers.insert(port.clone(), number);
        number
    }

    fn change(&mut self, spot: Spot, offer: &Offer, port: u32, here: bool) {
        let Some(waiting) = self.ports.get_mut(port as usize) else { return };
        let before = waiting.ready();
        let spots = if offer.value.is_some() { &mut waiting.writers } else { &mut waiting.readers };
        if here {
            spots.insert(spot)
        } else {
            spots.remove(spot)
        }
        let after = waiting.ready();
        if before != after {
            if let Some(writer) = before {
                self.ready.remove(&(writer, port));
            }
            self.ready.extend(after.map(|writer| (writer, port)));
        }
    }

    /// What a component offers.
    pub(super) fn of(&self, component: usize) -> impl Iterator<Item = &Offer> {
        self.own.get(component).into_iter().flatten().map(|(offer, _)| offer)
    }

    /// All offers.
    pub(super) fn all(&self) -> impl Iterator<Item = &Offer> {
        self.own.iter().flatten().map(|(offer, _)| offer)
    }

    fn at(&self, place: &Place) -> Option<&Offer> {
        self.of(place.component).find(|offer| offer.place == *place)
    }

    fn on_spot(&self, (component, place): Spot) -> Option<&Offer> {
        self.own.get(component as usize)?.get(place as usize).map(|(offer, _)| offer)
    }

    /// Whether this offer stands.
    pub(super) fn has(&self, offer: &Offer) -> bool {
        self.at(&offer.place).is_some_and(|other| same(offer, other))
    }

    /// Whether just this is offered to whoever reads.
    pub(super) fn writes_again(&self, offer: &Offer) -> bool {
        self.at(&offer.place).is_some_and(|other| same(offer, other) && offer.value == other.value)
    }

    /// The communication of the first writer that has a reader.
    pub(super) fn first(&self) -> Option<(Offer, Offer)> {
        let (writer, port) = self.ready.first()?;
        let reader = self.ports.get(*port as usize)?.readers.first?;
        Some((self.on_spot(*writer)?.clone(), self.on_spot(reader)?.clone()))
    }

    /// Every communication that is possible.
    pub(super) fn pairs(&self) -> Vec<(Offer, Offer)> {
        let writers = self.all().filter(|offer| offer.value.is_some());
        let with = |writer: &Offer| {
            let readers = self.on(&writer.port, false).filter(|reader| reader.place != writer.place);
            readers.map(|reader| (writer.clone(), reader.clone())).collect::<Vec<_>>()
        };
        writers.flat_map(with).collect()
    }

    /// Those that write, or read, a port.
    pub(super) fn on(&self, port: &Name, writes: bool) -> impl Iterator<Item = &Offer> {
        let waiting = self.numbers.get(port).and_then(|number| self.ports.get(*number as usize));
        let spots = waiting.map(|waiting| if writes { waiting.writers.iter() } else { waiting.readers.iter() });
        spots.into_iter().flatten().filter_map(|spot| self.on_spot(spot))
    }

    /// The possible communications with a part in one of the components of this one, but not with its parts.
    pub(super) fn beside(&self, writer: &Offer, reader: &Offer) -> Vec<(Offer, Offer)> {
        let apart = |place: &Place| *place != writer.place && *place != reader.place;
        let components = BTreeSet::from([writer.place.component, reader.place.component]);
        let mut found = Vec::new();
        for offer in components.iter().flat_map(|component| self.of(*component)).filter(|offer| apart(&offer.place)) {
            for partner in self.on(&offer.port, offer.value.is_none()).filter(|partner| apart(&partner.place)) {
                let pair = if offer.value.is_some() { (offer, partner) } else { (partner, offer) };
                found.push((pair.0.clone(), pair.1.clone()));
            }
        }
        found
    }
}

/// The offer of a component that has this number among its own.
fn spot(component: usize, place: usize) -> Spot {
    (short(component), short(place))
}

/// There are never so many that this says less.
fn short(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// Whether two offers are on the same port at the same place.
pub(super) fn same(one: &Offer, other: &Offer) -> bool {
    one.place == other.place && one.port == other.port && one.value.is_some() == other.value.is_some()
}
