//! What happens in one instant: everything that ends at once, and every communication, until time has to pass.

mod again;
mod changing;
mod orders;

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::hash::{Hash, Hasher};

use self::again::{Earlier, again};
use self::changing::changing;
use super::board::{Board, same};
use super::order::Order;
use super::ports::Users;
use super::run::{Env, Halt, Path, Run, Settler};
use super::step::{Offer, Place, Slot, finish, inspect, map_values, offers, written};
use super::{Before, Blocked, End, Failure, Test, in_case};
use crate::digest::Digest;
use crate::name::Name;
use crate::value::Value;

/// Communications in one instant, for each read or write that the system has.
const MOST_EACH: usize = 50;
/// Communications in one instant besides those.
const MOST_COMMUNICATIONS: usize = 20_000;

/// A state on its way through an instant.
#[derive(Clone)]
pub(super) struct Moment {
    pub(super) state: Vec<Run>,
    pub(super) path: Path,
    pub(super) communications: Vec<(Name, Value)>,
    /// The components that took part in a communication.
    pub(super) moved: BTreeSet<usize>,
    /// Components that have changed since they were settled.
    dirty: BTreeSet<usize>,
    /// A number for what each component is about to do, and the sum of these numbers.
    hashes: (Vec<u64>, u64),
    board: Board,
    /// An earlier state of this instant, to be met again if it goes round in no time.
    earlier: Option<Earlier>,
    /// A loop is known to go round with other values until so many communications have been made, or that is not asked
    /// again before that.
    quiet: usize,
    /// What the communication just made must not have prevented.
    besides: Option<Besides>,
    order: Order,
}

/// A communication just made, with what was possible besides it.
#[derive(Clone)]
struct Besides {
    writer: Offer,
    reader: Place,
    cuts: Vec<Cut>,
    rivals: Vec<usize>,
    pairs: Vec<(Offer, Offer)>,
    /// Numbers for what the components that wrote and read were before.
    before: [u64; 2],
}

/// A `#` in a branch of which something was communicated, as it then was, with what waits in its other branches.
#[derive(Clone)]
struct Cut {
    place: Place,
    depth: usize,
    run: Run,
    beside: Vec<Offer>,
}

impl Moment {
    /// Of a system with so many ports.
    pub(super) fn new(state: Vec<Run>, path: Path, ports: usize) -> Moment {
        let dirty = (0..state.len()).collect();
        let board = Board::new(state.len(), ports);
        let (communications, moved) = (Vec::new(), BTreeSet::new());
        let hashes = (vec![0; state.len()], 0);
        Moment {
            state,
            path,
            communications,
            moved,
            dirty,
            hashes,
            board,
            earlier: None,
            quiet: 0,
            besides: None,
            order: Order::default(),
        }
    }

    /// Puts other values in the place of all those that come up again, also of what was just communicated.
    pub(super) fn replace(&mut self, image: &dyn Fn(&Value) -> Value) {
        if let Some(earlier) = &mut self.earlier {
            self.state.iter().enumerate().for_each(|(component, run)| earlier.keep(component, run));
        }
        let replaced = |run: &Run| -> Run {
            let Ok(run) = map_values(run, &mut |_: Slot<'_>, value: &Value| Ok::<_, Infallible>(image(value)));
            run
        };
        self.state = self.state.iter().map(replaced).collect();
        let Some(besides) = &mut self.besides else { return };
        let pairs = besides.pairs.iter_mut().flat_map(|(writer, reader)| [writer, reader]);
        let beside = besides.cuts.iter_mut().flat_map(|cut| &mut cut.beside);
        for offer in [&mut besides.writer].into_iter().chain(pairs).chain(beside) {
            offer.value = offer.value.as_ref().map(image);
        }
        besides.cuts.iter_mut().for_each(|cut| cut.run = replaced(&cut.run));
    }

    /// The same on another path, and all of it to be settled anew.
    pub(super) fn settled_anew(self, path: Path) -> Moment {
        let dirty = (0..self.state.len()).collect();
        Moment { path, dirty, ..self }
    }

    /// A number for what a component is about to do.
    fn number(&self, component: usize) -> u64 {
        self.hashes.0.get(component).copied().unwrap_or_default()
    }

    /// Puts a settled component in its place.
    fn place(&mut self, component: usize, settled: Run) -> Result<(), Halt> {
        self.board.update(component, &settled)?;
        let mut hasher = Digest::default();
        (component, &settled).hash(&mut hasher);
        let (hashes, sum) = &mut self.hashes;
        if let (Some(place), Some(own)) = (self.state.get_mut(component), hashes.get_mut(component)) {
            let before = std::mem::replace(own, hasher.finish());
            *sum = sum.wrapping_sub(before).wrapping_add(*own);
            *place = settled;
        }
        self.dirty.remove(&component);
        Ok(())
    }
}

/// What an instant needs to know.
pub(super) struct Clock<'a> {
    pub(super) settler: Settler<'a>,
    /// The components' names.
    pub(super) names: &'a [String],
    /// Who reads and who writes each port.
    pub(super) users: &'a Users,
    /// How many reads and writes the processes have.
    pub(super) operations: usize,
    /// The wish to stop.
    pub(super) interrupted: &'a dyn Fn() -> bool,
}

impl Clock<'_> {
    /// Settles and communicates until time has to pass. On a question, the moment is left as it was when that came up.
    pub(super) fn instant(&self, moment: &mut Moment) -> Result<Option<End>, Halt> {
        loop {
            if (self.interrupted)() {
                return Err(Failure::Interrupted.into());
            }
            if let Some(end) = self.beat(moment)? {
                return Ok(end);
            }
        }
    }

    /// One settling and one communication: `Some` when the instant is over.
    fn beat(&self, moment: &mut Moment) -> Result<Option<Option<End>>, Halt> {
        if let Some(end) = self.settle(moment)? {
            return Ok(Some(Some(end)));
        }
        let end = match again(moment) {
            None => changing(self, moment)?,
            end => end,
        };
        if end.is_some() {
            return Ok(Some(end));
        }
        self.check_besides(moment)?;
        self.communicate_once(moment)
    }

    /// The communications in one instant that are followed.
    fn most_communications(&self) -> usize {
        MOST_COMMUNICATIONS.saturating_add(MOST_EACH.saturating_mul(self.operations))
    }

    /// What the communication just made must not have prevented, of a moment that has settled since.
    fn check_besides(&self, moment: &mut Moment) -> Result<(), Halt> {
        let Some(besides) = moment.besides.take() else { return Ok(()) };
        self.check_race(&besides, &moment.board)?;
        if let Err(halt) = self.check_order(&besides, moment) {
            // On a question the same is checked again.
            moment.besides = Some(besides);
            return Err(halt);
        }
        Ok(())
    }

    /// One communication: `Some` when there is none, and the instant is over.
    fn communicate_once(&self, moment: &mut Moment) -> Result<Option<Option<End>>, Halt> {
        let Some((writer, reader)) = moment.board.first() else {
            return Ok(Some(self.ending(moment)?));
        };
        self.check_contention(&writer, &moment.board)?;
        let pairs = moment.board.beside(&writer, &reader);
        self.check_others(moment, (&writer, &reader), &pairs)?;
        let most = self.most_communications();
        if moment.communications.len() >= most {
            let tests: Vec<Test> = moment.path.tests.iter().map(|test| test.test.clone()).collect();
            return Halt::because(format!(
                "more than {most} communications in one instant{}: time may stop there",
                in_case(&tests)
            ));
        }
        if moment.path.lengths > most {
            let made = moment.communications.len();
            return Halt::because(format!("{made} communications in one instant, with numbers that grow on and on"));
        }
        let readers = || moment.board.on(&writer.port, false).map(|offer| offer.place.component);
        let rivals = if readers().nth(1).is_some() { readers().take(2).collect() } else { Vec::new() };
        for component in [writer.place.component, reader.place.component] {
            if let (Some(earlier), Some(run)) = (&mut moment.earlier, moment.state.get(component)) {
                earlier.keep(component, run);
            }
        }
        moment.order.made(&writer, &reader);
        let before = [&writer, &reader].map(|offer| moment.number(offer.place.component));
        let value = communicate(&mut moment.state, &writer, &reader);
        let cuts = [&writer.place, &reader.place].into_iter().flat_map(|place| cuts(moment, place)).collect();
        moment.communications.push((written(&writer.port), value));
        for component in [writer.place.component, reader.place.component] {
            moment.dirty.insert(component);
            moment.moved.insert(component);
        }
        moment.besides = Some(Besides { rivals, pairs, writer, reader: reader.place, cuts, before });
        Ok(None)
    }

    /// Ends all that ends at once in the components that have changed.
    fn settle(&self, moment: &mut Moment) -> Result<Option<End>, Halt> {
        let wanted = BTreeSet::new();
        while let Some(component) = moment.dirty.first().copied() {
            let Some(run) = moment.state.get(component).cloned() else { break };
            let (draws, exits) = (moment.path.draws.len(), moment.path.exits);
            moment.path.unfolded.clear();
            moment.path.open.clear();
            self.settler.ended.component.set(component);
            let settled = match self.settler.settle(run, &wanted, &mut moment.path, 0) {
                Ok(settled) => settled,
                Err(Halt::Failed(failure)) => {
                    if let Failure::Livelock { cycle, changes, .. } = *failure {
                        return Ok(Some(End::Livelock { cycle, changes }));
                    }
                    return Err(Halt::Failed(Box::new(match *failure {
                        Failure::NoPeriod { reason } => {
                            Failure::NoPeriod { reason: format!("in {}: {reason}", self.name(component)) }
                        }
                        other => other,
                    })));
                }
                Err(question) => {
                    moment.path.draws.truncate(draws);
                    moment.path.exits = exits;
                    return Err(question);
                }
            };
            if let Some(earlier) = &mut moment.earlier {
                earlier.unfolded.append(&mut moment.path.unfolded);
            }
            moment.place(component, settled)?;
        }
        Ok(None)
    }

    /// A communication that was possible besides the one made must still be possible.
    fn check_race(&self, besides: &Besides, board: &Board) -> Result<(), Halt> {
        let port = &besides.writer.port;
        if !besides.rivals.is_empty() && !board.writes_again(&besides.writer) {
            let components = besides.rivals.iter().map(|component| self.name(*component)).collect();
            let anew = board.on(port, true).find(|offer| offer.place == besides.writer.place);
            let anew = anew.map(|offer| self.name_of(offer));
            return Err(Failure::Contention { port: written(port), components, anew }.into());
        }
        for (writer, reader) in &besides.pairs {
            if let Some(gone) = [reader, writer].into_iter().find(|offer| !board.has(offer)) {
                let component = self.name_of(gone);
                return Err(Failure::KillRace { component, ports: (written(port), written(&writer.port)) }.into());
            }
        }
        Ok(())
    }

    /// Any other communication of the same components, made first, must leave this one possible.
    fn check_others(&self, moment: &mut Moment, made: (&Offer, &Offer), pairs: &[(Offer, Offer)]) -> Result<(), Halt> {
        let (writer, reader) = made;
        let wanted = BTreeSet::new();
        for (from, to) in pairs {
            let own = [writer, reader, from, to].into_iter().map(|offer| offer.place.component);
            let mut few: BTreeMap<usize, Run> =
                own.filter_map(|index| Some((index, moment.state.get(index)?.clone()))).collect();
            let value = from.value.clone().unwrap_or_else(Value::zero);
            put(few.get_mut(&from.place.component), from, &Env::new());
            put(few.get_mut(&to.place.component), to, &results(to, &value));
            let mark = moment.path.mark();
            let mut standing = Vec::new();
            let mut known = true;
            for (index, run) in few {
                // What cannot be told here comes up again when that communication is made.
                self.settler.ended.component.set(index);
                match self.settler.settle(run, &wanted, &mut moment.path, 0) {
                    Ok(run) => offers(&run, &mut Place { component: index, branches: Vec::new() }, &mut standing)?,
                    Err(_) => known = false,
                }
            }
            moment.path.back_to(mark);
            if let Some(one) =
                [writer, reader].into_iter().find(|one| known && !standing.iter().any(|other| same(one, other)))
            {
                let component = self.name_of(one);
                return Err(Failure::KillRace { component, ports: (written(&from.port), written(&one.port)) }.into());
            }
        }
        Ok(())
    }

    /// The communication just made, and what its components read or write now, could not have come otherwise.
    fn check_order(&self, besides: &Besides, moment: &mut Moment) -> Result<(), Halt> {
        let port = &besides.writer.port;
        if !moment.board.writes_again(&besides.writer) {
            moment.order.taken(port);
        }
        let race = |component: usize, one: &Name, other: &Name| {
            let ports = (written(one), written(other));
            Err(Failure::KillRace { component: self.name(component), ports }.into())
        };
        for Cut { place, depth, run, beside } in &besides.cuts {
            let mark = moment.path.mark();
            self.settler.ended.component.set(place.component);
            let settled = self.settler.settle(run.clone(), &BTreeSet::new(), &mut moment.path, 0);
            moment.path.back_to(mark);
            if !matches!(settled?, Run::Done(_) | Run::Aborted) {
                continue;
            }
            if let Some(other) = moment.order.cut_off(place, *depth) {
                return race(place.component, other, port);
            }
            // Who stands there now is another one, also where it offers the same.
            let is_beside = |one: &Offer| beside.iter().any(|offer| same(offer, one));
            if let Some((other, _)) = besides.pairs.iter().find(|(from, to)| is_beside(from) || is_beside(to)) {
                return race(place.component, &other.port, port);
            }
            beside.iter().for_each(|offer| moment.order.kills(offer));
        }
        let components = BTreeSet::from([besides.writer.place.component, besides.reader.component]);
        for offer in components.iter().flat_map(|component| moment.board.of(*component)) {
            if let Some(components) = moment.order.rivals(offer) {
                let components = components.into_iter().map(|component| self.name(component)).collect();
                return Err(Failure::Contention { port: written(&offer.port), components, anew: None }.into());
            }
            if let Some((component, other)) = moment.order.missed(offer) {
                return race(component, &offer.port, other);
            }
        }
        // Of what came of it at once it is a cause all the same.
        let now = [&besides.writer.place, &besides.reader].map(|place| moment.number(place.component));
        moment.order.left([0, 1].map(|side| now.get(side) == besides.before.get(side)));
        Ok(())
    }

    /// One writer only.
    fn check_contention(&self, writer: &Offer, board: &Board) -> Result<(), Halt> {
        if board.on(&writer.port, true).nth(1).is_some() {
            let components: BTreeSet<usize> = board.on(&writer.port, true).map(|offer| offer.place.component).collect();
            let components = components.into_iter().map(|component| self.name(component)).collect();
            return Err(Failure::Contention { port: written(&writer.port), components, anew: None }.into());
        }
        Ok(())
    }

    fn name(&self, component: usize) -> String {
        self.names.get(component).cloned().unwrap_or_default()
    }

    fn name_of(&self, offer: &Offer) -> String {
        self.name(offer.place.component)
    }

    /// What an offer that is never taken waits for.
    pub(super) fn blocked(&self, offer: &Offer) -> Blocked {
        let reads = offer.value.is_none();
        let partners = self.users.get(&offer.port).map(|(readers, writers)| if reads { writers } else { readers });
        let partners = partners.into_iter().flatten().filter(|other| **other != offer.place.component);
        let partners = partners.map(|other| self.name(*other)).collect();
        Blocked { component: self.name_of(offer), port: written(&offer.port), reads, partners, before: Before::Never }
    }

    /// Whether nobody reads the port, or nobody writes it.
    pub(super) fn is_lonely(&self, port: &Name) -> bool {
        self.users.get(port).is_none_or(|(readers, writers)| readers.is_empty() || writers.is_empty())
    }

    /// Whether only one component, and not what waits itself, uses the port in the way that it waits for.
    pub(super) fn only_partner(&self, blocked: &Blocked) -> bool {
        let of_port = self.users.iter().find(|(port, _)| written(port) == blocked.port);
        let partners = of_port.map(|(_, (readers, writers))| if blocked.reads { writers } else { readers });
        partners.is_some_and(|partners| {
            partners.len() == 1 && partners.iter().all(|one| self.name(*one) != blocked.component)
        })
    }

    /// How the run ends here, if no delay is left.
    fn ending(&self, moment: &Moment) -> Result<Option<End>, Halt> {
        let state = &moment.state;
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
        let blocked: BTreeSet<Blocked> = moment.board.all().map(|offer| self.blocked(offer)).collect();
        Ok(Some(End::Silent { blocked: blocked.into_iter().collect(), observed }))
    }
}

/// Each `#` around a place at which something was just communicated, if its other branches communicate too.
fn cuts(moment: &Moment, place: &Place) -> Vec<Cut> {
    let (mut found, mut depth) = (Vec::new(), 0);
    let Some(mut here) = moment.state.get(place.component) else { return found };
    loop {
        let parts = match here {
            Run::Seq(first, ..) | Run::Else(first, ..) | Run::New(_, first) | Run::Only(_, first) => {
                here = first;
                continue;
            }
            Run::Par(parts) | Run::Disable(parts) => parts,
            _ => return found,
        };
        let Some((own, next)) = place.branches.get(depth).and_then(|own| Some((own, parts.get(*own)?))) else {
            return found;
        };
        if matches!(here, Run::Disable(_)) {
            let others = moment.board.of(place.component).filter(|offer| {
                offer.place.branches.get(..depth) == place.branches.get(..depth)
                    && offer.place.branches.get(depth) != Some(own)
            });
            let beside: Vec<Offer> = others.cloned().collect();
            if !beside.is_empty() || moment.moved.contains(&place.component) {
                found.push(Cut { place: place.clone(), depth, run: here.clone(), beside });
            }
        }
        (here, depth) = (next, depth + 1);
    }
}

fn put(run: Option<&mut Run>, offer: &Offer, results: &Env) {
    if let Some(run) = run {
        *run = finish(std::mem::replace(run, Run::Aborted), &offer.place.branches, results);
    }
}

fn results(reader: &Offer, value: &Value) -> Env {
    reader.binds.iter().map(|name| (name.clone(), value.clone())).collect()
}

/// Makes a communication; gives the value that passes.
fn communicate(state: &mut [Run], writer: &Offer, reader: &Offer) -> Value {
    let value = writer.value.clone().unwrap_or_else(Value::zero);
    put(state.get_mut(writer.place.component), writer, &Env::new());
    put(state.get_mut(reader.place.component), reader, &results(reader, &value));
    value
}
