//! What happens in one instant: everything that ends at once, and every communication, until time has to pass.

use std::collections::BTreeSet;

use super::run::{Env, Halt, Path, Run, Settler};
use super::step::{Offer, all_offers, finish, inspect};
use super::{Blocked, End, Failure};
use crate::name::Name;
use crate::value::Value;

/// Communications in one instant.
const MOST_COMMUNICATIONS: usize = 2_000;

/// A state on its way through an instant.
#[derive(Clone)]
pub(super) struct Moment {
    pub(super) state: Vec<Run>,
    pub(super) path: Path,
    pub(super) communications: Vec<(Name, Value)>,
    pub(super) history: Vec<Vec<Run>>,
    /// What the communication just made must not have prevented.
    pub(super) besides: Option<Besides>,
}

/// A communication just made, with what was possible besides it.
#[derive(Clone)]
pub(super) struct Besides {
    writer: Offer,
    rivals: Vec<Offer>,
    pairs: Vec<(Offer, Offer)>,
}

/// What an instant needs to know.
pub(super) struct Clock<'a> {
    pub(super) settler: Settler<'a>,
    /// The components' names.
    pub(super) names: &'a [String],
}

impl Clock<'_> {
    /// Settles and communicates until time has to pass. On a question, the moment is left as it was when that came up.
    pub(super) fn instant(&self, moment: &mut Moment) -> Result<Option<End>, Halt> {
        loop {
            if let Some(end) = self.beat(moment)? {
                return Ok(end);
            }
        }
    }

    /// One settling and one communication: `Some` when the instant is over.
    fn beat(&self, moment: &mut Moment) -> Result<Option<Option<End>>, Halt> {
        let mut path = moment.path.clone();
        path.unfolded.clear();
        let wanted = BTreeSet::new();
        let settled: Result<Vec<Run>, Halt> =
            moment.state.iter().map(|run| self.settler.settle(run.clone(), &wanted, &mut path, 0)).collect();
        moment.state = match settled {
            Err(Halt::Failed(failure)) => {
                if let Failure::Livelock { cycle, .. } = *failure {
                    return Ok(Some(Some(End::Livelock { cycle })));
                }
                return Err(Halt::Failed(failure));
            }
            settled => settled?,
        };
        if moment.history.contains(&moment.state) {
            return Ok(Some(Some(End::Livelock { cycle: loops_of(&path, &moment.path) })));
        }
        let unfolded: Vec<Name> = moment.path.unfolded.iter().chain(&path.unfolded).cloned().collect();
        moment.path = path;
        moment.path.unfolded = unfolded;
        let offers = all_offers(&moment.state)?;
        let pairs = pairs(&offers);
        if let Some(besides) = moment.besides.take() {
            self.check_race(&besides, &pairs, &offers)?;
        }
        let Some((writer, reader)) = pairs.first().cloned() else {
            return Ok(Some(self.ending(&moment.state, &offers)?));
        };
        self.check_contention(&writer, &offers)?;
        self.check_others(moment, (&writer, &reader), &pairs)?;
        if moment.communications.len() >= MOST_COMMUNICATIONS {
            return Halt::because(format!("more than {MOST_COMMUNICATIONS} communications in one instant"));
        }
        moment.history.push(moment.state.clone());
        let value = communicate(&mut moment.state, &writer, &reader);
        moment.communications.push((writer.port.clone(), value));
        let apart = |pair: &&(Offer, Offer)| {
            let places = [&pair.0.place, &pair.1.place];
            !places.contains(&&writer.place) && !places.contains(&&reader.place)
        };
        let readers = offers.iter().filter(|offer| offer.value.is_none() && offer.port == writer.port);
        let rivals: Vec<Offer> = readers.cloned().collect();
        moment.besides = Some(Besides {
            rivals: if rivals.len() > 1 { rivals } else { Vec::new() },
            pairs: pairs.iter().filter(apart).cloned().collect(),
            writer,
        });
        Ok(None)
    }

    /// A communication that was possible besides the one made must still be possible.
    fn check_race(&self, besides: &Besides, pairs: &[(Offer, Offer)], offers: &[Offer]) -> Result<(), Halt> {
        let port = &besides.writer.port;
        let same = |a: &Offer, b: &Offer| a.place == b.place && a.port == b.port;
        let again = |offer: &Offer| offer.value.is_some() && same(offer, &besides.writer);
        if !besides.rivals.is_empty() && !offers.iter().any(again) {
            let components = besides.rivals.iter().map(|offer| self.name_of(offer)).collect();
            return Err(Failure::Contention { port: port.clone(), components }.into());
        }
        for (writer, reader) in &besides.pairs {
            if pairs.iter().any(|(w, r)| same(w, writer) && same(r, reader)) {
                continue;
            }
            let gone = if offers.iter().any(|offer| same(offer, writer)) { reader } else { writer };
            let component = self.name_of(gone);
            return Err(Failure::KillRace { component, ports: (port.clone(), writer.port.clone()) }.into());
        }
        Ok(())
    }

    /// Any other communication, made first, must leave this one possible.
    fn check_others(&self, moment: &Moment, made: (&Offer, &Offer), pairs: &[(Offer, Offer)]) -> Result<(), Halt> {
        let (writer, reader) = made;
        for (from, to) in pairs {
            let places = [&from.place, &to.place];
            if places.contains(&&writer.place) || places.contains(&&reader.place) {
                continue;
            }
            let mut state = moment.state.clone();
            communicate(&mut state, from, to);
            let mut path = moment.path.clone();
            let wanted = BTreeSet::new();
            let settled: Result<Vec<Run>, Halt> =
                state.into_iter().map(|run| self.settler.settle(run, &wanted, &mut path, 0)).collect();
            // What cannot be told here comes up again when that communication is made.
            let Ok(state) = settled else { continue };
            let offers = all_offers(&state)?;
            let same = |a: &Offer, b: &Offer| a.place == b.place && a.port == b.port;
            for one in [writer, reader] {
                if !offers.iter().any(|offer| same(offer, one)) {
                    let component = self.name_of(one);
                    return Err(Failure::KillRace { component, ports: (from.port.clone(), one.port.clone()) }.into());
                }
            }
        }
        Ok(())
    }

    /// One writer only, unless all write the same.
    fn check_contention(&self, writer: &Offer, offers: &[Offer]) -> Result<(), Halt> {
        let rivals: Vec<&Offer> = offers.iter().filter(|o| o.port == writer.port && o.value.is_some()).collect();
        if rivals.len() > 1 {
            let components = rivals.iter().map(|offer| self.name_of(offer)).collect();
            return Err(Failure::Contention { port: writer.port.clone(), components }.into());
        }
        Ok(())
    }

    fn name_of(&self, offer: &Offer) -> String {
        offer.place.first().and_then(|index| self.names.get(*index)).cloned().unwrap_or_default()
    }

    /// How the run ends here, if no delay is left.
    fn ending(&self, state: &[Run], offers: &[Offer]) -> Result<Option<End>, Halt> {
        if state.iter().all(|run| matches!(run, Run::Done(_) | Run::Aborted)) {
            let stopped = state.iter().any(|run| matches!(run, Run::Done(_)));
            return Ok(Some(if stopped { End::Stopped } else { End::Aborted }));
        }
        let (mut delays, mut observed) = (Vec::new(), Vec::new());
        for run in state {
            inspect(run, &mut delays, &mut observed)?;
        }
        if !delays.is_empty() {
            return Ok(None);
        }
        observed.sort();
        observed.dedup();
        let blocked: BTreeSet<Blocked> = offers
            .iter()
            .map(|offer| Blocked {
                component: self.name_of(offer),
                port: offer.port.clone(),
                reads: offer.value.is_none(),
            })
            .collect();
        Ok(Some(End::Silent { blocked: blocked.into_iter().collect(), observed }))
    }
}

fn put(state: &mut [Run], place: &[usize], results: &Env) {
    if let Some((component, below)) = place.split_first()
        && let Some(run) = state.get_mut(*component)
    {
        *run = finish(run.clone(), below, results);
    }
}

/// Makes a communication; gives the value that passes.
fn communicate(state: &mut [Run], writer: &Offer, reader: &Offer) -> Value {
    let value = writer.value.clone().unwrap_or_else(Value::zero);
    let results = reader.binds.iter().map(|name| (name.clone(), value.clone())).collect();
    put(state, &writer.place, &Env::new());
    put(state, &reader.place, &results);
    value
}

fn pairs(offers: &[Offer]) -> Vec<(Offer, Offer)> {
    let mut found = Vec::new();
    for writer in offers.iter().filter(|offer| offer.value.is_some()) {
        for reader in offers.iter().filter(|offer| offer.value.is_none() && offer.port == writer.port) {
            found.push((writer.clone(), reader.clone()));
        }
    }
    found
}

fn loops_of(path: &Path, before: &Path) -> Vec<Name> {
    let mut cycle: Vec<Name> = Vec::new();
    for name in before.unfolded.iter().chain(&path.unfolded) {
        if !cycle.contains(name) {
            cycle.push(name.clone());
        }
    }
    cycle
}
