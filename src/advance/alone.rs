//! Communications of which one order is as good as any other.

use std::collections::{BTreeSet, HashMap};
use std::rc::Rc;

use super::leaf::{Component, Components, Leaf, components, rebuilt};
use super::settle::Runner;
use crate::fact::Facts;
use crate::name::Name;
use crate::scope::{calls, subterms};
use crate::term::{Node, Term};
use crate::value::Value;

/// A communication that is possible, by the numbers of its leaves.
pub(super) struct Meeting<'t> {
    pub(super) reader: usize,
    pub(super) writer: usize,
    pub(super) port: &'t Name,
    pub(super) binder: Option<usize>,
    pub(super) name: &'t Name,
    pub(super) value: &'t Value,
}

/// The communications that need not be tried in another order, of two kinds.
///
/// Of the first each is between two parts of which each can do nothing else now, on a port that no other part ever uses
/// before it. Whatever others do before it, it stays possible and the same, as no `#` is around one part that another
/// could end, and it hinders none of them; so every order of all that happens is as good as one that begins with it, and
/// until it has happened its two parts run, and nothing that follows them begins.
///
/// Of the second each is between a part that can do nothing else now but read and a *server*: a part that can do nothing
/// else now but write, binds nothing, and is after that what it was before. On this port no other part ever writes before
/// it, though others may read. Whatever happens before it leaves the server as it is, as only reads from it touch it, so
/// it stays possible and the same, and the reader has no other partner; and it hinders no other reader, since it too
/// leaves the server as it is.
///
/// Of either part of the first kind it is enough that it could do something else with the other part alone, on a port that no
/// third one ever uses before: as long as the other can do nothing but this, it cannot. `In_v<u> # Odo_r` waits for its
/// controller, which reads before it writes.
///
/// None of two of these hinders the other, so they may all happen at once: whoever could do something else with one part
/// alone takes part in no other of them.
pub(super) fn alone(
    runner: &Runner<'_, '_>,
    state: &Term,
    leaves: &[Leaf<'_>],
    pairs: &[Meeting<'_>],
) -> BTreeSet<usize> {
    let Components { running, later } = components(state);
    let parts = Parts::of(runner, running, later, leaves);
    match parts {
        Some(parts) => (0..pairs.len()).filter(|place| parts.needs_no_other(&pairs[*place])).collect(),
        None => BTreeSet::new(),
    }
}

/// The parts of a network, with what is known of them.
struct Parts<'t, 'r, 'c, 'd> {
    runner: &'r Runner<'c, 'd>,
    leaves: &'r [Leaf<'t>],
    running: Vec<Component<'t>>,
    /// What follows when others have ended.
    later: Vec<Component<'t>>,
    facts: Vec<Rc<Facts>>,
    /// Who may use a port, by their numbers, those that follow behind those that run.
    users: HashMap<(Name, Option<usize>), Vec<usize>>,
}

impl<'t, 'r, 'c, 'd> Parts<'t, 'r, 'c, 'd> {
    /// Nothing if a part may use any port.
    fn of(
        runner: &'r Runner<'c, 'd>,
        running: Vec<Component<'t>>,
        later: Vec<Component<'t>>,
        leaves: &'r [Leaf<'t>],
    ) -> Option<Parts<'t, 'r, 'c, 'd>> {
        let of = |part: &Component<'t>| Facts::of(&part.term, runner.context);
        let facts: Vec<Rc<Facts>> = running.iter().chain(&later).map(of).collect();
        let mut users: HashMap<(Name, Option<usize>), Vec<usize>> = HashMap::new();
        for (place, (part, facts)) in running.iter().chain(&later).zip(&facts).enumerate() {
            if !facts.ports.processes.is_empty() {
                return None;
            }
            for port in &facts.ports.names {
                users.entry((port.clone(), part.binder(port))).or_default().push(place);
            }
        }
        Some(Parts { runner, leaves, running, later, facts, users })
    }

    fn needs_no_other(&self, meeting: &Meeting<'_>) -> bool {
        let of = |leaf: usize| self.running.partition_point(|component| component.inside.end <= leaf);
        let (reader, writer) = (of(meeting.reader), of(meeting.writer));
        let offers_one = |place: usize| self.running.get(place).is_some_and(|component| component.offers == 1);
        let one = [offers_one(reader), offers_one(writer)];
        if reader == writer || one == [false, false] {
            return false;
        }
        let users = || self.users.get(&(meeting.port.clone(), meeting.binder)).into_iter().flatten().copied();
        let own =
            |place: usize| place == reader || place == writer || self.waits(place, &[meeting.reader, meeting.writer]);
        if users().all(own) {
            return one == [true, true]
                || self.nothing_else(if one[0] { writer } else { reader }, meeting, [reader, writer]);
        }
        if one != [true, true] {
            return false;
        }
        // A server does not end before time passes, so what follows it does not begin.
        let reads = |place: usize| {
            own(place) || self.part(place).is_some_and(|part| !self.runner.writes_port(&part.term, meeting.port))
        };
        self.is_server(writer, meeting.writer) && users().all(reads)
    }

    /// Whether all else that a part of a meeting offers is on ports that these two parts alone ever use before it, and each
    /// on another one, so that it does not meet itself.
    fn nothing_else(&self, place: usize, meeting: &Meeting<'_>, both: [usize; 2]) -> bool {
        let Some(part) = self.running.get(place) else { return false };
        let mut ports: BTreeSet<(&Name, Option<usize>)> = BTreeSet::new();
        part.inside.clone().all(|number| {
            let Some(leaf) = self.leaves.get(number) else { return false };
            let (Node::In(port, _) | Node::Out(port, _)) = leaf.term.node() else { return true };
            let known = [meeting.reader, meeting.writer];
            let own = |place: usize| both.contains(&place) || self.waits(place, &[known[0], known[1], number]);
            let mut users = self.users.get(&(port.clone(), leaf.binder)).into_iter().flatten().copied();
            ports.insert((port, leaf.binder)) && (known.contains(&number) || users.all(own))
        })
    }

    fn part(&self, place: usize) -> Option<&Component<'t>> {
        self.running.iter().chain(&self.later).nth(place)
    }

    /// Whether a part only begins when these leaves have ended, or one of them.
    fn waits(&self, place: usize, leaves: &[usize]) -> bool {
        let behind = place.checked_sub(self.running.len()).and_then(|place| self.later.get(place));
        behind.is_some_and(|part| leaves.iter().any(|leaf| part.inside.contains(leaf)))
    }

    /// Whether a part is what it was before when this leaf of it, its one write, has been made.
    fn is_server(&self, place: usize, leaf: usize) -> bool {
        let (Some(part), Some(facts)) = (self.running.get(place), self.facts.get(place)) else { return false };
        facts.binds.is_empty() && self.runner.is_server(&part.term, leaf - part.inside.start)
    }
}

impl Runner<'_, '_> {
    /// Whether a settled part that binds nothing comes back to itself when this leaf of it has ended.
    fn is_server(&self, part: &Term, leaf: usize) -> bool {
        if let Some(known) = self.servers.borrow().get(part) {
            return *known;
        }
        let after = rebuilt(part, &mut 0, &mut |number, _| (number == leaf).then(Term::stop));
        let is = self.part(&after).is_ok_and(|after| after == *part);
        self.servers.borrow_mut().insert(part.clone(), is);
        is
    }

    /// Whether a part may write to a port of this name, itself or in a process that it calls; yes, where it is not known.
    fn writes_port(&self, part: &Term, port: &Name) -> bool {
        self.written_ports(part).is_none_or(|written| written.contains(port))
    }

    /// The names of ports that a part writes to, itself or in a process that it calls.
    fn written_ports(&self, part: &Term) -> Option<Rc<BTreeSet<Name>>> {
        if let Some(known) = self.written.borrow().get(part) {
            return Some(Rc::clone(known));
        }
        let mut written = BTreeSet::new();
        let collect = |term: &Term, written: &mut BTreeSet<Name>| {
            for part in subterms(term) {
                if let Node::Out(port, _) = part.node() {
                    written.insert(port.clone());
                }
            }
        };
        collect(part, &mut written);
        let mut seen = BTreeSet::new();
        let mut open: Vec<Name> = calls(part).into_iter().collect();
        while let Some(name) = open.pop() {
            if seen.insert(name.clone()) {
                let body = &self.context.definitions.get(&name)?.body;
                collect(body, &mut written);
                open.extend(calls(body));
            }
        }
        let written = Rc::new(written);
        self.written.borrow_mut().insert(part.clone(), Rc::clone(&written));
        Some(written)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::{Orders, closed, last, last_of};
    use super::*;
    use crate::fact::Context;
    use crate::lower::Environment;
    use crate::parser::parse;
    use crate::substitution::Stuck;

    /// Servers, writers that are none (one that counts, one that ends, one that hears), and readers of all kinds.
    const PROCESSES: &str = "observer See(x)\nproc Odo_r = Out_{p,r} ; Odo_r\nproc Beam_r = Out_{q,r} ; Beam_r\n\
        proc Counts_n = Out_{p,n} ; Counts_{n+1}\nproc Once = Out_{p,5} ; Idle\nproc Turns = Out_{p,1} ; Out_{p,2} ; Turns\n\
        proc Shows_r = (Delay_1 # Odo_r # See_r) ; Idle\nproc Both_r = (Odo_r # Beam_r) ; Idle\n\
        proc Hears = In_q<x> ; Odo_x\nproc Binds = Set_3<z> ; Out_{p,z} ; Binds\n\
        proc Reads = In_p<x> ; (Delay_x # See_x) ; Idle\nproc Twice = In_p<x> ; In_q<y> ; (Delay_1 # See_{x-y}) ; Idle\n\
        proc Later = In_q<x> ; Out_{p,9} ; Idle\nproc Asks = In_p<x> ; Out_{c,x} ; Idle\nproc Told = In_c<y> ; In_p<x> ; (Delay_1 # See_{x+y}) ; Idle\n\
        proc Either = (In_p<x> | In_q<y>) ; (Delay_1 # See_{x+2*y}) ; Idle\nproc Cut = (In_p<x> # In_q<y>) ; Idle\n\
        proc Behind = (In_p<x> ; Stop | In_q<y>) ; Out_{p,x+y} ; Idle\n\
        proc Goes = Out_{q,1} ; Goes\nproc Comes = In_q<x> ; Comes\nproc Passes = In_p<x> ; Out_{c,x+1} ; Passes\nproc Sends = Out_{p,2} ; Out_{c,1} ; Delay_1 ; Sends\nproc Sinks = In_c<y> ; Sinks\n\
        proc Ends = In_c<y> ; Abort\nproc Splits = In_c<y> ; (Out_{q,y} | (Delay_1 # See_y)) ; Idle\n\
        proc Waits_r = (In_c<u> # Odo_r) ; (Delay_1 # See_{r+u}) ; Idle\nproc Turned_r = (In_p<x> # Out_{c,r}) ; (Delay_1 # See_r) ; Idle\n\
        proc Steers = In_p<x> ; Out_{c,x+1} ; Idle\nproc Asked = In_c<y> ; Out_{p,y} ; Idle\nproc Selves = (In_c<u> # Out_{c,2} # Odo_3) ; Idle\n\
        proc Draws = In_c<y> ; Ran_{Uniform(0,1)}<w> ; Out_{q,w} ; Idle\n";
    const PARTS: [&str; 33] = [
        "Odo_4", "Odo_7", "Beam_6", "Counts_0", "Once", "Turns", "Shows_3", "Both_2", "Hears", "Binds", "Reads",
        "Twice", "Later", "Asks", "Told", "Either", "Cut", "Behind", "Passes", "Sends", "Sinks", "Ends", "Splits",
        "Draws", "Passes", "Sends", "Waits_2", "Turned_3", "Steers", "Asked", "Selves", "Waits_5", "Steers",
    ];

    fn environment(last: &str) -> Environment {
        let text = format!("{PROCESSES}proc Whole = {last}\n");
        let parsed = parse(&text);
        let mut environment = Environment::default();
        let mut batch = environment.open(&parsed.items, &text);
        for (index, item) in parsed.items.iter().enumerate() {
            environment.step(&mut batch, index, item).unwrap();
        }
        environment
    }

    fn ends(network: &str, orders: Orders) -> Result<Term, Stuck> {
        let environment = environment(network);
        let context = Context::new(&environment.assumptions, &environment.definitions, &[]);
        let body = environment.definitions.get(&Name::new("Whole")).unwrap().body.clone();
        let (kept, ports) = (BTreeSet::new(), ["p", "q", "c"].map(Name::new));
        let runner = Runner::new(&context, &kept);
        let first = runner.running(&body)?;
        let end = if orders == Orders::Alike {
            last(&runner, first, &ports)
        } else {
            last_of(&runner, first, &ports, orders)
        };
        end.map(|state| closed(&ports, state))
    }

    #[test]
    fn what_some_orders_lead_to_all_do() {
        let mut seed = 7_u64;
        let mut next = |count: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % count
        };
        let (mut found, mut refused) = (0, 0);
        for _ in 0..3_000 {
            let parts: Vec<&str> = (0..2 + next(4)).map(|_| PARTS[next(PARTS.len())]).collect();
            let network = format!("{} | Delay_9 ; Idle", parts.join(" | "));
            let [some, all] = [Orders::Alike, Orders::All].map(|orders| ends(&network, orders));
            match (some, all) {
                (Ok(some), Ok(all)) => {
                    assert_eq!(some, all, "{network}");
                    found += 1;
                }
                (Ok(some), Err(why)) => panic!("{network}: {some}, but {}", why.0),
                (Err(_), _) => refused += 1,
            }
        }
        assert!(found > 300 && refused > 300, "{found} {refused}");
    }

    #[test]
    fn sequences_of_two_that_meet_on_a_port_of_their_own_are_gone_through() {
        // One after the other, to a delay, to the end, to two parts, and to a draw.
        for last in ["Sinks", "Ends", "Splits", "Draws"] {
            let network = format!("Out_{{q,1}} ; Idle | Asks | In_q<x> ; Out_{{p,x}} ; Idle | {last} | Delay_9 ; Idle");
            let [some, all] = [Orders::Alike, Orders::All].map(|orders| ends(&network, orders));
            assert_eq!(some.expect(last), all.expect(last));
        }
        let why = ends("Out_{q,1} ; Goes | In_q<x> ; Comes | Delay_9 ; Idle", Orders::Alike).unwrap_err();
        assert_eq!(why.0, "it communicates for ever in no time");
    }

    #[test]
    fn readers_of_one_server_are_not_put_in_order() {
        let readers = (0..14).map(|_| "Reads").collect::<Vec<_>>().join(" | ");
        assert!(ends(&format!("Shows_3 | {readers}"), Orders::Alike).is_ok());
        // Whoever reads first gets another value.
        let why = ends("Counts_0 | Twice | Beam_1 | Reads", Orders::Alike).unwrap_err();
        assert_eq!(why.0, super::super::ORDER);
    }
}
