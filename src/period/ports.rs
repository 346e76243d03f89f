//! The closed system: components and ports, who reads and who writes, and the balance equations.

use std::collections::{BTreeSet, VecDeque};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::One;

use super::tally::{Counter, Tally};
use super::{Before, Blocked, Failure};
use crate::definition::Definitions;
use crate::digest::Quick;
use crate::name::Name;
use crate::scope::subterms;
use crate::term::{Node, Term};

/// The components of a system: the parallel parts, without the `new` round them. Where a port is private to some of
/// the parts and others use a port of the same name, these parts stay together.
pub fn flatten(components: &[Term], definitions: &Definitions) -> Vec<Term> {
    let mut flat: Vec<Term> = Vec::new();
    let mut stack: Vec<Term> = components.iter().rev().cloned().collect();
    while let Some(term) = stack.pop() {
        match term.node() {
            Node::New(port, body) => {
                let uses = |other: &Term| {
                    let uses = Uses::of(other, definitions);
                    uses.reads.iter().chain(&uses.writes).any(|used| *used == port)
                };
                if flat.iter().chain(&stack).any(uses) { flat.push(term.clone()) } else { stack.push(body.clone()) }
            }
            Node::Par(parts) => stack.extend(parts.iter().rev().cloned()),
            _ => flat.push(term),
        }
    }
    flat
}

/// The components that read a port, and those that write it.
pub type Users = Quick<Name, (Vec<usize>, Vec<usize>)>;

/// Components with the ports they read and write.
#[derive(Clone, Debug)]
pub struct System {
    /// What each component is called in messages.
    pub names: Vec<String>,
    /// The ports each component reads, in order.
    pub reads: Vec<Vec<Name>>,
    /// The ports each component writes, in order.
    pub writes: Vec<Vec<Name>>,
    /// The components that read each port, and those that write it.
    pub users: Users,
    /// How many reads and writes the components have, as they are written.
    pub operations: usize,
    /// How often each port is read, and written, in one round of a component of which that is known.
    counts: Counts,
    /// The components that go round for ever, in no other way, each of whose ports they use a known number of times a round.
    counted: Vec<bool>,
}

impl System {
    /// Who reads and writes what.
    pub fn of(components: &[Term], definitions: &Definitions) -> System {
        let mut reads = Vec::with_capacity(components.len());
        let mut writes = Vec::with_capacity(components.len());
        let mut names: Vec<String> = Vec::with_capacity(components.len());
        let mut called: Quick<&Name, usize> = Quick::with_capacity_and_hasher(components.len(), Default::default());
        let mut operations = 0;
        let mut counts = Counts::with_capacity_and_hasher(components.len(), Default::default());
        let mut counted = Vec::with_capacity(components.len());
        let mut counter = Counter::new(definitions);
        for (index, component) in components.iter().enumerate() {
            let uses = Uses::of(component, definitions);
            operations += uses.reads.len() + uses.writes.len();
            let round = counter.round(component);
            let (read, written) = uses.ports();
            let known = |round: &Tally<'_>| {
                let used =
                    |port: &Name, reads| round.uses.get(&(port, reads)).copied().flatten().is_some_and(|used| used > 0);
                !round.busy && read.iter().all(|port| used(port, true)) && written.iter().all(|port| used(port, false))
            };
            counted.push(round.as_ref().is_some_and(known));
            for ((port, reads), count) in round.into_iter().flat_map(|round| round.uses) {
                let entry = counts.entry(port.clone()).or_default();
                *(if reads { &mut entry.0 } else { &mut entry.1 }) = count.unwrap_or(0);
            }
            reads.push(read);
            writes.push(written);
            names.push(match component.node() {
                Node::Call(name, _) => {
                    let again = called.entry(name).or_default();
                    *again += 1;
                    if *again == 1 { name.to_string() } else { format!("{name} ({again})") }
                }
                _ => format!("component {}", index + 1),
            });
        }
        let users = users(&reads, &writes);
        System { names, reads, writes, users, operations, counts, counted }
    }

    /// Ports that one component uses and no other answers.
    pub fn unmatched(&self) -> Vec<Failure> {
        let unread = |port: &&Name| self.users.get(*port).is_none_or(|(readers, _)| readers.is_empty());
        let unwritten = |port: &&Name| self.users.get(*port).is_none_or(|(_, writers)| writers.is_empty());
        let mut failures = Vec::new();
        for (index, component) in self.names.iter().enumerate() {
            for port in self.reads[index].iter().filter(unwritten) {
                failures.push(unmatched(component, port, true));
            }
            for port in self.writes[index].iter().filter(unread) {
                failures.push(unmatched(component, port, false));
            }
        }
        failures
    }

    /// Components that are connected by ports, directly or through others.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); self.names.len()];
        for (readers, writers) in self.users.values() {
            let (Some(reader), Some(writer)) = (readers.first(), writers.first()) else { continue };
            for (one, others) in [(*reader, writers), (*writer, readers)] {
                for other in others.iter().copied().filter(|other| *other != one) {
                    beside[one].push(other);
                    beside[other].push(one);
                }
            }
        }
        let mut seen = vec![false; self.names.len()];
        let mut groups = Vec::new();
        for start in 0..self.names.len() {
            let mut stack = vec![start];
            let mut group = Vec::new();
            while let Some(component) = stack.pop() {
                if !std::mem::replace(&mut seen[component], true) {
                    group.push(component);
                    stack.extend(beside[component].iter().copied());
                }
            }
            group.sort_unstable();
            if !group.is_empty() {
                groups.push(group);
            }
        }
        groups
    }

    /// Whether `q_i · k_ic = q_j · k_jc` has a solution for all ports c between one reader j and one writer i of whose rounds
    /// it is known how often they use it. Where there is none, the components on these ports do not go round for ever:
    /// each round uses each of these ports as often as any other, and none is used more often by one side than by the other.
    ///
    /// # Errors
    /// [`Failure::RateMismatch`] when there is no solution.
    pub fn balance(&self) -> Result<(), Failure> {
        let equations = self.equations();
        // Where every port is read as often as it is written, all go round together.
        if equations.iter().all(|equation| equation.writer.1 == equation.reader.1) {
            return Ok(());
        }
        let mut rates: Vec<Option<BigRational>> = vec![None; self.names.len()];
        let mut touching: Vec<Vec<&Equation>> = vec![Vec::new(); self.names.len()];
        for equation in &equations {
            touching[equation.writer.0].push(equation);
            touching[equation.reader.0].push(equation);
        }
        for start in 0..self.names.len() {
            if rates[start].is_none() {
                rates[start] = Some(BigRational::one());
                self.spread(start, &touching, &mut rates)?;
            }
        }
        Ok(())
    }

    /// Carries the rate of a component along the equations as far as they lead.
    fn spread(
        &self,
        start: usize,
        touching: &[Vec<&Equation>],
        rates: &mut [Option<BigRational>],
    ) -> Result<(), Failure> {
        let mut waiting = VecDeque::from([start]);
        while let Some(component) = waiting.pop_front() {
            for equation in &touching[component] {
                let ((writer, written), (reader, read)) = (equation.writer, equation.reader);
                let ratio = || BigRational::new(BigInt::from(written), BigInt::from(read));
                let times = |rate: &BigRational| if written == read { rate.clone() } else { rate * ratio() };
                let over = |rate: &BigRational| if written == read { rate.clone() } else { rate / ratio() };
                match (&rates[writer], &rates[reader]) {
                    (Some(rate), None) => {
                        rates[reader] = Some(times(rate));
                        waiting.push_back(reader);
                    }
                    (None, Some(rate)) => {
                        rates[writer] = Some(over(rate));
                        waiting.push_back(writer);
                    }
                    (Some(one), Some(other)) if times(one) != *other => {
                        let rounds = one / other;
                        return Err(Failure::RateMismatch {
                            rounds: Box::new((rounds.numer().clone(), rounds.denom().clone())),
                            port: equation.port.clone(),
                            writer: (self.names[writer].clone(), written),
                            reader: (self.names[reader].clone(), read),
                        });
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// The equations of one-to-one ports of which it is known how often they are used in one round on either side, in the
    /// order of the writers.
    pub(super) fn equations(&self) -> Vec<Equation> {
        let equation = |port: &Name| {
            let (readers, writers) = self.users.get(port)?;
            let ([reader], [writer]) = (readers.as_slice(), writers.as_slice()) else { return None };
            let (read, written) = self.counts.get(port).filter(|(read, written)| *read > 0 && *written > 0)?;
            Some(Equation { port: port.clone(), writer: (*writer, *written), reader: (*reader, *read) })
        };
        self.writes.iter().flatten().filter_map(equation).collect()
    }

    /// Whether the balance equations say all that there is to say: every component goes round for ever by them, and one that
    /// stops holds up all others sooner or later.
    pub(super) fn rests_on_equations(&self) -> bool {
        self.counted.iter().all(|counted| *counted)
            && self.equations().len() == self.users.len()
            && self.groups().len() == 1
    }
}

fn users(reads: &[Vec<Name>], writes: &[Vec<Name>]) -> Users {
    let most = reads.iter().chain(writes).map(Vec::len).sum::<usize>() / 2;
    let mut users = Users::with_capacity_and_hasher(most, Default::default());
    for (index, (reads, writes)) in reads.iter().zip(writes).enumerate() {
        reads.iter().for_each(|port| users.entry(port.clone()).or_default().0.push(index));
        writes.iter().for_each(|port| users.entry(port.clone()).or_default().1.push(index));
    }
    users
}

fn unmatched(component: &str, port: &Name, reads: bool) -> Failure {
    Failure::Unmatched(Blocked {
        component: component.to_string(),
        port: port.clone(),
        reads,
        partners: Vec::new(),
        before: Before::Never,
    })
}

/// How often each port is read, and written, in one round of those that use it.
type Counts = Quick<Name, (usize, usize)>;

/// A port between two components, each with how often it uses the port in one round.
pub(super) struct Equation {
    pub(super) port: Name,
    pub(super) writer: (usize, usize),
    pub(super) reader: (usize, usize),
}

/// The reads and writes of a component, as often as they are written, with those of all processes that it calls.
struct Uses<'a> {
    reads: Vec<&'a Name>,
    writes: Vec<&'a Name>,
}

impl<'a> Uses<'a> {
    fn of(component: &'a Term, definitions: &'a Definitions) -> Uses<'a> {
        let mut uses = Uses { reads: Vec::new(), writes: Vec::new() };
        let mut seen: BTreeSet<&Name> = BTreeSet::new();
        let mut stack = vec![component];
        while let Some(term) = stack.pop() {
            for part in subterms(term) {
                match part.node() {
                    Node::In(port, _) => uses.reads.push(port),
                    Node::Out(port, _) => uses.writes.push(port),
                    Node::Call(name, _) => {
                        if let Some(definition) = definitions.get(name).filter(|_| seen.insert(name)) {
                            stack.push(&definition.body);
                        }
                    }
                    _ => {}
                }
            }
        }
        uses
    }

    /// The ports that it reads and those that it writes, each once and in order.
    fn ports(self) -> (Vec<Name>, Vec<Name>) {
        let once = |mut ports: Vec<&Name>| {
            ports.sort_unstable();
            ports.dedup();
            ports.into_iter().cloned().collect()
        };
        (once(self.reads), once(self.writes))
    }
}
