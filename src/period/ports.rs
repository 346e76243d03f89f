//! The closed system: components and ports, who reads and who writes, and the balance equations.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive};

use super::{Blocked, Failure};
use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::subterms;
use crate::term::{Node, Term};

/// The components of a system: the parallel parts, without the `new` round them.
pub fn flatten(components: &[Term]) -> Vec<Term> {
    let mut flat = Vec::new();
    let mut stack: Vec<Term> = components.iter().rev().cloned().collect();
    while let Some(term) = stack.pop() {
        match term.node() {
            Node::New(_, body) => stack.push(body.clone()),
            Node::Par(parts) => stack.extend(parts.iter().rev().cloned()),
            _ => flat.push(term),
        }
    }
    flat
}

/// Components with the ports they read and write.
#[derive(Clone, Debug)]
pub struct System {
    /// What each component is called in messages.
    pub names: Vec<String>,
    /// The ports each component reads.
    pub reads: Vec<BTreeSet<Name>>,
    /// The ports each component writes.
    pub writes: Vec<BTreeSet<Name>>,
    components: Vec<Term>,
}

impl System {
    /// Who reads and writes what.
    pub fn of(components: &[Term], definitions: &Definitions) -> System {
        let mut reads = Vec::new();
        let mut writes = Vec::new();
        let mut names: Vec<String> = Vec::new();
        for (index, component) in components.iter().enumerate() {
            let (read, written) = ports_of(component, definitions);
            reads.push(read);
            writes.push(written);
            let name = match component.node() {
                Node::Call(name, _) => name.to_string(),
                _ => format!("component {}", index + 1),
            };
            let again = names.iter().filter(|other| **other == name || other.starts_with(&format!("{name} ("))).count();
            names.push(if again == 0 { name } else { format!("{name} ({})", again + 1) });
        }
        System { names, reads, writes, components: components.to_vec() }
    }

    /// The failures that show without running anything.
    pub fn failures(&self) -> Vec<Failure> {
        let groups = self.groups();
        let mut failures = Vec::new();
        if groups.len() > 1 {
            let name = |index: &usize| self.names[*index].clone();
            failures.push(Failure::NoCommunication {
                groups: groups.iter().map(|group| group.iter().map(name).collect()).collect(),
            });
        }
        let all_reads: BTreeSet<&Name> = self.reads.iter().flatten().collect();
        let all_writes: BTreeSet<&Name> = self.writes.iter().flatten().collect();
        for (index, component) in self.names.iter().enumerate() {
            for port in self.reads[index].iter().filter(|port| !all_writes.contains(port)) {
                failures.push(unmatched(component, port, true));
            }
            for port in self.writes[index].iter().filter(|port| !all_reads.contains(port)) {
                failures.push(unmatched(component, port, false));
            }
        }
        failures
    }

    /// Components that are connected by ports, directly or through others.
    fn groups(&self) -> Vec<Vec<usize>> {
        let count = self.names.len();
        let mut group: Vec<usize> = (0..count).collect();
        for one in 0..count {
            for other in 0..count {
                let shared = self.writes[one].iter().any(|port| self.reads[other].contains(port));
                if shared && group[one] != group[other] {
                    let (from, to) = (group[one].max(group[other]), group[one].min(group[other]));
                    group.iter_mut().filter(|member| **member == from).for_each(|member| *member = to);
                }
            }
        }
        let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (component, group) in group.into_iter().enumerate() {
            members.entry(group).or_default().push(component);
        }
        members.into_values().collect()
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
        for start in 0..counts.len() {
            if rates[start].is_some() {
                continue;
            }
            rates[start] = Some(BigRational::one());
            self.spread(&equations, &mut rates)?;
        }
        let rates: Vec<BigRational> = rates.into_iter().flatten().collect();
        let multiple = rates.iter().fold(BigInt::one(), |sum, rate| sum.lcm(rate.denom()));
        let whole: Vec<BigInt> = rates.iter().map(|rate| (rate * &multiple).to_integer()).collect();
        let divisor = whole.iter().fold(BigInt::from(0), |sum, rate| sum.gcd(rate));
        let small: Option<Vec<u64>> = whole.iter().map(|rate| (rate / &divisor).to_u64()).collect();
        Ok(small.map(|rates| self.names.iter().cloned().zip(rates).collect()))
    }

    /// Carries known rates along the equations until nothing new follows.
    fn spread(&self, equations: &[Equation], rates: &mut [Option<BigRational>]) -> Result<(), Failure> {
        let mut changed = true;
        while changed {
            changed = false;
            for equation in equations {
                let ((writer, written), (reader, read)) = (equation.writer, equation.reader);
                let ratio = BigRational::new(BigInt::from(written), BigInt::from(read));
                match (rates[writer].clone(), rates[reader].clone()) {
                    (Some(rate), None) => {
                        rates[reader] = Some(rate * ratio);
                        changed = true;
                    }
                    (None, Some(rate)) => {
                        rates[writer] = Some(rate / ratio);
                        changed = true;
                    }
                    (Some(one), Some(other)) if one.clone() * ratio.clone() != other => {
                        return Err(Failure::RateMismatch {
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
        let ports: BTreeSet<&Name> = self.reads.iter().chain(&self.writes).flatten().collect();
        let lone = |sets: &[BTreeSet<Name>], port: &Name| sets.iter().filter(|set| set.contains(port)).count() == 1;
        ports.into_iter().all(|port| lone(&self.reads, port) && lone(&self.writes, port)).then_some(counts)
    }
}

fn unmatched(component: &str, port: &Name, reads: bool) -> Failure {
    Failure::Unmatched(Blocked { component: component.to_string(), port: port.clone(), reads })
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
    let mut equations = Vec::new();
    for (writer, from) in counts.iter().enumerate() {
        for (port, written) in &from.writes {
            for (reader, to) in counts.iter().enumerate() {
                if let Some(read) = to.reads.get(port) {
                    equations.push(Equation {
                        port: port.clone(),
                        writer: (writer, *written),
                        reader: (reader, *read),
                    });
                }
            }
        }
    }
    equations
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
