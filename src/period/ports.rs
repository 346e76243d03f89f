//! The closed system: components and ports, who reads and who writes, and the balance equations.

use std::collections::{BTreeSet, VecDeque};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::One;

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
    /// How often each port is read, and written, in one round, where all components are straight lines.
    counts: Option<Counts>,
}

impl System {
    /// Who reads and writes what.
    pub fn of(components: &[Term], definitions: &Definitions) -> System {
        let mut reads = Vec::with_capacity(components.len());
        let mut writes = Vec::with_capacity(components.len());
        let mut names: Vec<String> = Vec::with_capacity(components.len());
        let mut called: Quick<&Name, usize> = Quick::with_capacity_and_hasher(components.len(), Default::default());
        let mut operations = 0;
        let mut counts = Some(Counts::with_capacity_and_hasher(components.len(), Default::default()));
        for (index, component) in components.iter().enumerate() {
            let uses = Uses::of(component, definitions);
            operations += uses.reads.len() + uses.writes.len();
            if !uses.straight {
                counts = None;
            }
            if let Some(counts) = &mut counts {
                uses.reads.iter().for_each(|port| counts.entry((*port).clone()).or_default().0 += 1);
                uses.writes.iter().for_each(|port| counts.entry((*port).clone()).or_default().1 += 1);
            }
            let (read, written) = uses.ports();
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
        System { names, reads, writes, users, operations, counts }
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

    /// Whether `q_i · k_ic = q_j · k_jc` has a solution for straight-line components over one-to-one ports; nothing is asked
    /// where they are not.
    ///
    /// # Errors
    /// [`Failure::RateMismatch`] when there is no solution.
    pub fn balance(&self) -> Result<(), Failure> {
        let equations = self.equations().unwrap_or_default();
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

    /// The equations of one-to-one ports between straight-line components, in the order of the writers.
    pub(super) fn equations(&self) -> Option<Vec<Equation>> {
        let counts = self.counts.as_ref()?;
        let mut equations = Vec::with_capacity(self.users.len());
        for port in self.writes.iter().flatten() {
            let (readers, writers) = self.users.get(port)?;
            let ([reader], [writer]) = (readers.as_slice(), writers.as_slice()) else { return None };
            let (read, written) = counts.get(port)?;
            equations.push(Equation { port: port.clone(), writer: (*writer, *written), reader: (*reader, *read) });
        }
        (equations.len() == self.users.len()).then_some(equations)
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
    /// Whether it is `T = P ; T` where P is a sequence of delays, sets, reads and writes, possibly side by side.
    straight: bool,
}

impl<'a> Uses<'a> {
    fn of(component: &'a Term, definitions: &'a Definitions) -> Uses<'a> {
        let mut uses = Uses { reads: Vec::new(), writes: Vec::new(), straight: goes_round(component, definitions) };
        let mut seen: BTreeSet<&Name> = BTreeSet::new();
        let mut stack = vec![component];
        let mut calls = 0;
        while let Some(term) = stack.pop() {
            for part in subterms(term) {
                match part.node() {
                    Node::In(port, _) => uses.reads.push(port),
                    Node::Out(port, _) => uses.writes.push(port),
                    Node::Call(name, _) => {
                        calls += 1;
                        if let Some(definition) = definitions.get(name).filter(|_| seen.insert(name)) {
                            stack.push(&definition.body);
                        }
                    }
                    Node::Delay(_) | Node::Set(..) | Node::Seq(_) | Node::Par(_) | Node::Stop => {}
                    Node::Loop(_) if part == component => {}
                    _ => uses.straight = false,
                }
            }
        }
        // A loop calls nothing; a process that goes round is called, and calls itself.
        let own = if matches!(component.node(), Node::Loop(_)) { 0 } else { 2 };
        uses.straight &= calls == own;
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

/// Whether a component is a loop, or a process that ends by calling itself.
fn goes_round(component: &Term, definitions: &Definitions) -> bool {
    match component.node() {
        Node::Loop(_) => true,
        Node::Call(name, _) => {
            let body = definitions.get(name).map(|definition| definition.body.node());
            let last = if let Some(Node::Seq(parts)) = body { parts.last() } else { None };
            last.is_some_and(|last| matches!(last.node(), Node::Call(called, _) if called == name))
        }
        _ => false,
    }
}
