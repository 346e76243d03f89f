//! The closed system: components and ports, who reads and who writes, and the balance equations.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive};

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
                    let (reads, writes) = ports_of(other, definitions);
                    reads.contains(port) || writes.contains(port)
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
    /// The ports each component reads.
    pub reads: Vec<BTreeSet<Name>>,
    /// The ports each component writes.
    pub writes: Vec<BTreeSet<Name>>,
    /// How many reads and writes the processes have, as they are written.
    pub operations: usize,
    components: Vec<Term>,
}

impl System {
    /// Who reads and writes what.
    pub fn of(components: &[Term], definitions: &Definitions) -> System {
        let mut reads = Vec::new();
        let mut writes = Vec::new();
        let mut names: Vec<String> = Vec::new();
        let mut called: Quick<String, usize> = Quick::default();
        let mut counted = 0;
        for (index, component) in components.iter().enumerate() {
            let (read, written) = ports_of(component, definitions);
            reads.push(read);
            writes.push(written);
            counted += operations(component);
            let name = match component.node() {
                Node::Call(name, _) => name.to_string(),
                _ => format!("component {}", index + 1),
            };
            let again = called.entry(name.clone()).or_default();
            *again += 1;
            names.push(if *again == 1 { name } else { format!("{name} ({again})") });
        }
        let operations = counted + definitions.iter().map(|definition| operations(&definition.body)).sum::<usize>();
        System { names, reads, writes, operations, components: components.to_vec() }
    }

    /// Ports that one component uses and no other answers.
    pub fn unmatched(&self) -> Vec<Failure> {
        let users = self.users();
        let unread = |port: &&Name| users.get(*port).is_none_or(|(readers, _)| readers.is_empty());
        let unwritten = |port: &&Name| users.get(*port).is_none_or(|(_, writers)| writers.is_empty());
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

    /// The components that read each port, and those that write it.
    pub fn users(&self) -> Users {
        let mut users = Users::default();
        for (index, (reads, writes)) in self.reads.iter().zip(&self.writes).enumerate() {
            reads.iter().for_each(|port| users.entry(port.clone()).or_default().0.push(index));
            writes.iter().for_each(|port| users.entry(port.clone()).or_default().1.push(index));
        }
        users
    }

    /// Components that are connected by ports, directly or through others.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let mut beside: Vec<Vec<usize>> = vec![Vec::new(); self.names.len()];
        for (readers, writers) in self.users().into_values() {
            let (Some(reader), Some(writer)) = (readers.first(), writers.first()) else { continue };
            for (one, others) in [(*reader, writers.clone()), (*writer, readers.clone())] {
                for other in others.into_iter().filter(|other| *other != one) {
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

    /// Solves `q_i · k_ic = q_j · k_jc` for straight-line components over one-to-one ports; nothing where they are not.
    ///
    /// # Errors
    /// [`Failure::RateMismatch`] when there is no solution.
    pub fn balance(&self, definitions: &Definitions) -> Result<Option<Vec<(String, u64)>>, Failure> {
        let Some(counts) = self.straight_counts(definitions) else {
            return Ok(None);
        };
        let equations = equations(&counts);
        if equations.is_empty() {
            return Ok(None);
        }
        let mut rates: Vec<Option<BigRational>> = vec![None; counts.len()];
        let mut touching: Vec<Vec<&Equation>> = vec![Vec::new(); counts.len()];
        for equation in &equations {
            touching[equation.writer.0].push(equation);
            touching[equation.reader.0].push(equation);
        }
        for start in 0..counts.len() {
            if rates[start].is_none() {
                rates[start] = Some(BigRational::one());
                self.spread(start, &touching, &mut rates)?;
            }
        }
        let rates: Vec<BigRational> = rates.into_iter().flatten().collect();
        let multiple = rates.iter().fold(BigInt::one(), |sum, rate| sum.lcm(rate.denom()));
        let whole: Vec<BigInt> = rates.iter().map(|rate| (rate * &multiple).to_integer()).collect();
        let divisor = whole.iter().fold(BigInt::from(0), |sum, rate| sum.gcd(rate));
        let small: Option<Vec<u64>> = whole.iter().map(|rate| (rate / &divisor).to_u64()).collect();
        Ok(small.map(|rates| self.names.iter().cloned().zip(rates).collect()))
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
                let ratio = BigRational::new(BigInt::from(written), BigInt::from(read));
                match (rates[writer].clone(), rates[reader].clone()) {
                    (Some(rate), None) => {
                        rates[reader] = Some(rate * ratio);
                        waiting.push_back(reader);
                    }
                    (None, Some(rate)) => {
                        rates[writer] = Some(rate / ratio);
                        waiting.push_back(writer);
                    }
                    (Some(one), Some(other)) if one.clone() * ratio.clone() != other => {
                        let rounds = &one / &other;
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

    fn straight_counts(&self, definitions: &Definitions) -> Option<Vec<Counts>> {
        let counts: Vec<Counts> =
            self.components.iter().map(|component| straight_period(component, definitions)).collect::<Option<_>>()?;
        let single = |(readers, writers): &(Vec<usize>, Vec<usize>)| readers.len() == 1 && writers.len() == 1;
        self.users().values().all(single).then_some(counts)
    }
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

/// Reads and writes of each port in one round.
#[derive(Clone, Debug, Default)]
struct Counts {
    reads: BTreeMap<Name, usize>,
    writes: BTreeMap<Name, usize>,
}

struct Equation {
    port: Name,
    writer: (usize, usize),
    reader: (usize, usize),
}

fn equations(counts: &[Counts]) -> Vec<Equation> {
    let mut readers: Quick<&Name, Vec<(usize, usize)>> = Quick::default();
    for (reader, counts) in counts.iter().enumerate() {
        counts.reads.iter().for_each(|(port, read)| readers.entry(port).or_default().push((reader, *read)));
    }
    let mut equations = Vec::new();
    for (writer, from) in counts.iter().enumerate() {
        for (port, written) in &from.writes {
            for reader in readers.get(port).into_iter().flatten() {
                equations.push(Equation { port: port.clone(), writer: (writer, *written), reader: *reader });
            }
        }
    }
    equations
}

fn operations(term: &Term) -> usize {
    subterms(term).into_iter().filter(|part| matches!(part.node(), Node::In(..) | Node::Out(..))).count()
}

/// The counts of `T = P ; T` where P is a sequence of delays, sets, reads and writes, possibly side by side.
fn straight_period(component: &Term, definitions: &Definitions) -> Option<Counts> {
    let body = match component.node() {
        Node::Loop(body) => body.clone(),
        Node::Call(name, _) => {
            let Node::Seq(parts) = definitions.get(name)?.body.node() else {
                return None;
            };
            let (last, front) = parts.split_last()?;
            if !matches!(last.node(), Node::Call(called, _) if called == name) {
                return None;
            }
            Term::seq(front.iter().cloned())
        }
        _ => return None,
    };
    let mut counts = Counts::default();
    for part in subterms(&body) {
        match part.node() {
            Node::In(port, _) => *counts.reads.entry(port.clone()).or_default() += 1,
            Node::Out(port, _) => *counts.writes.entry(port.clone()).or_default() += 1,
            Node::Delay(_) | Node::Set(..) | Node::Seq(_) | Node::Par(_) | Node::Stop => {}
            _ => return None,
        }
    }
    Some(counts)
}

fn ports_of(component: &Term, definitions: &Definitions) -> (BTreeSet<Name>, BTreeSet<Name>) {
    let mut reads = BTreeSet::new();
    let mut writes = BTreeSet::new();
    let mut seen = BTreeSet::new();
    let mut stack = vec![component.clone()];
    while let Some(term) = stack.pop() {
        for part in subterms(&term) {
            match part.node() {
                Node::In(port, _) => {
                    reads.insert(port.clone());
                }
                Node::Out(port, _) => {
                    writes.insert(port.clone());
                }
                Node::Call(name, _) => {
                    if let Some(definition) = definitions.get(name).filter(|_| seen.insert(name.clone())) {
                        stack.push(definition.body.clone());
                    }
                }
                _ => {}
            }
        }
    }
    (reads, writes)
}
