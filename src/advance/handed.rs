//! Communications between two parts on a port that nobody else uses, one after the other, so that a chain of n parts is
//! gone through in about n steps.
//!
//! They are of the first kind of [`super::alone`]: the two parts can do nothing else now, and no other part ever uses
//! the port before it. So every order of all that happens is as good as one that begins with these. Only the two parts
//! are looked at again after each. What ends, draws or splits is left to those who look at the whole network.

use std::collections::{BTreeSet, HashMap, HashSet, VecDeque};
use std::rc::Rc;

use super::draw::is_due;
use super::leaf::{leaves, rebuilt};
use super::settle::Runner;
use crate::fact::Facts;
use crate::name::Name;
use crate::substitution::Stuck;
use crate::term::{Node, Term};

/// So many communications for each part, and some more, are made in one instant before the whole is looked at.
const EACH: usize = 20;

/// The settled network after these communications: itself where there are none.
///
/// # Errors
/// Where one of the two parts cannot be settled.
pub(super) fn handed_on(runner: &Runner<'_, '_>, state: &Term, ports: &BTreeSet<&Name>) -> Result<Term, Stuck> {
    let Node::Par(parts) = state.node() else { return Ok(state.clone()) };
    // A draw that is due comes first.
    if is_due(state) {
        return Ok(state.clone());
    }
    let Some(mut hands) = Hands::of(runner, parts) else { return Ok(state.clone()) };
    let mut open: VecDeque<Name> = ports.iter().map(|port| (*port).clone()).collect();
    let (mut left, mut moved) = (EACH * (parts.len() + 5), false);
    while let Some(port) = open.pop_front() {
        let Some((writer, reader)) = hands.pair(&port).filter(|_| ports.contains(&port)) else { continue };
        let Some([wrote, read]) = hands.met(writer, reader)? else { break };
        let drawn = is_due(&wrote) || is_due(&read);
        moved = true;
        let known = [hands.put(writer, wrote, &mut open), hands.put(reader, read, &mut open)] == [true, true];
        left -= 1;
        if drawn || !known || left == 0 {
            break;
        }
    }
    Ok(if moved { Term::par(hands.parts) } else { state.clone() })
}

/// The one thing that a part can do now.
#[derive(Clone, PartialEq, Eq)]
struct Offer {
    port: Name,
    writes: bool,
}

/// The parts of a network, with what each offers and who uses which port.
struct Hands<'r, 'c, 'd> {
    runner: &'r Runner<'c, 'd>,
    parts: Vec<Term>,
    facts: Vec<Rc<Facts>>,
    offers: Vec<Option<Offer>>,
    users: HashMap<Name, BTreeSet<usize>>,
}

/// What a settled part offers, if it is one read or write on a port that it does not bind itself and it can do nothing
/// else.
fn offered(part: &Term) -> Option<Offer> {
    let leaves = leaves(part);
    let [leaf] = leaves.as_slice() else { return None };
    match leaf.term.node() {
        Node::In(port, _) | Node::Out(port, _) if leaf.binder.is_none() => {
            Some(Offer { port: port.clone(), writes: matches!(leaf.term.node(), Node::Out(..)) })
        }
        _ => None,
    }
}

impl<'r, 'c, 'd> Hands<'r, 'c, 'd> {
    /// Nothing if no two of them meet now, or a part may use any port.
    fn of(runner: &'r Runner<'c, 'd>, parts: &[Term]) -> Option<Hands<'r, 'c, 'd>> {
        let offers: Vec<Option<Offer>> = parts.iter().map(offered).collect();
        let writes: HashSet<&Name> =
            offers.iter().flatten().filter(|offer| offer.writes).map(|offer| &offer.port).collect();
        if !offers.iter().flatten().any(|offer| !offer.writes && writes.contains(&offer.port)) {
            return None;
        }
        let facts: Vec<Rc<Facts>> = parts.iter().map(|part| Facts::of(part, runner.context)).collect();
        let mut users: HashMap<Name, BTreeSet<usize>> = HashMap::new();
        for (place, facts) in facts.iter().enumerate() {
            if !facts.ports.processes.is_empty() {
                return None;
            }
            for port in &facts.ports.names {
                users.entry(port.clone()).or_default().insert(place);
            }
        }
        Some(Hands { runner, parts: parts.to_vec(), facts, offers, users })
    }

    /// Who writes and who reads on this port, if both can do nothing else and nobody else ever uses it.
    fn pair(&self, port: &Name) -> Option<(usize, usize)> {
        let users = self.users.get(port).filter(|users| users.len() == 2)?;
        let writes = |place: &&usize| {
            let offer = self.offers.get(**place)?.as_ref().filter(|offer| offer.port == *port)?;
            Some((**place, offer.writes))
        };
        let both: Option<Vec<(usize, bool)>> = users.iter().map(|place| writes(&place)).collect();
        match both?.as_slice() {
            [(writer, true), (reader, false)] | [(reader, false), (writer, true)] => Some((*writer, *reader)),
            _ => None,
        }
    }

    /// The writer and the reader after they have communicated, settled; nothing where one of them has then ended.
    fn met(&self, writer: usize, reader: usize) -> Result<Option<[Term; 2]>, Stuck> {
        let (writes, reads) = (leaves(&self.parts[writer]), leaves(&self.parts[reader]));
        let (Some(write), Some(read)) = (writes.first(), reads.first()) else { return Ok(None) };
        let (Node::Out(_, value), Node::In(_, name)) = (write.term.node(), read.term.node()) else { return Ok(None) };
        let bound = self.runner.bound(value, name, read);
        let after = |place: usize, leaf: Term| {
            let part = rebuilt(&self.parts[place], &mut 0, &mut |_, _| Some(leaf.clone()));
            self.runner.goes_on(&part)
        };
        let (Some(wrote), Some(read)) = (after(writer, Term::stop())?, after(reader, bound)?) else { return Ok(None) };
        Ok(Some([wrote, read]))
    }

    /// Puts what a part has become in its place, and the ports that may now be communicated on in the queue; false if it
    /// may use any port.
    fn put(&mut self, place: usize, part: Term, open: &mut VecDeque<Name>) -> bool {
        let facts = Facts::of(&part, self.runner.context);
        let known = facts.ports.processes.is_empty();
        let before = std::mem::replace(&mut self.facts[place], facts.clone());
        if before.ports != facts.ports {
            for port in before.ports.names.difference(&facts.ports.names) {
                if let Some(users) = self.users.get_mut(port) {
                    users.remove(&place);
                }
                open.push_back(port.clone());
            }
            for port in facts.ports.names.difference(&before.ports.names) {
                self.users.entry(port.clone()).or_default().insert(place);
            }
        }
        self.offers[place] = offered(&part);
        open.extend(self.offers[place].iter().map(|offer| offer.port.clone()));
        self.parts[place] = part;
        known
    }
}
