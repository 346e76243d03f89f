//! Loops that wait for each other alone, without a choice: in the end each round takes the time of the greatest cycle of delays
//! and communications (the cycle time of a max-plus linear system: Baccelli, Cohen, Olsder and Quadrat, Synchronization and
//! Linearity, 1992, chapter 3). How many rounds it takes until then depends on how much the delays differ.

use std::collections::{BTreeMap, BTreeSet};

use num_bigint::BigInt;
use num_integer::Integer;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};

mod loops;

use self::loops::{Loop, Step, loops_of};
use super::ports::{System, flatten};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::term::Term;
use crate::value::{Relation, Value};

/// The most meetings in a round, ways into one of them, cycles that are looked at, and steps on the way to them.
const MOST_MEETINGS: usize = 40;
const MOST_WAYS: usize = 64;
const MOST_CYCLES: usize = 200;
const MOST_STEPS: usize = 20_000;
/// The most rounds that what is done before the loops may last.
const MOST_EARLY: u64 = 20;

/// Where loops wait: for each other on a port, or within one of them for all of its parts that are side by side.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Spot {
    Port(Name),
    End(usize),
}

/// What happens at a spot for the time of this number, counted from the start of the run.
type Meeting = (Spot, u64);

/// A meeting before another, with the delays between.
struct Edge {
    from: usize,
    to: usize,
    delay: Value,
    /// The rounds of the system between the two.
    rounds: i64,
}

/// How long it takes in the end until all comes round.
#[derive(Clone, Debug, PartialEq)]
pub struct InTheEnd {
    /// The time until then. Where a cycle of waits spans several rounds it is that of so many, though fewer may do.
    pub time: Value,
    /// The components, each with how often it has gone round by then.
    pub rounds: Vec<(String, u64)>,
}

/// How long rounds take in the end of components that are loops of delays and communications alone, on ports that one of them
/// writes and one reads; none of others, where their rates do not agree, or where something waits for itself, at the start or
/// in each round.
pub fn greatest_cycle(components: &[Term], definitions: &Definitions, known: &Assumptions) -> Option<InTheEnd> {
    let components = flatten(components, definitions);
    let loops = loops_of(&components, definitions, known)?;
    let (ports, times) = together(&loops)?;
    let edges = edges(&loops, &ports, &times)?;
    let meetings = edges.iter().map(|edge| edge.from.max(edge.to) + 1).max()?;
    let mut search = Search { edges: &edges, path: Vec::new(), found: BTreeMap::new(), steps: 0 };
    for start in 0..meetings {
        search.path = vec![start];
        search.cycles_from(start, (start, Value::zero(), 0))?;
    }
    let rounds = search.found.values().flatten().try_fold(1u64, |all, rounds| {
        let own = u64::try_from(*rounds).ok()?;
        all.checked_mul(own / all.gcd(&own))
    })?;
    let mut each = Vec::new();
    for (time, rounds_of) in &search.found {
        for own in rounds_of {
            each.push(time.mul(&Value::integer(i64::try_from(rounds).ok()? / own)).ok()?);
        }
    }
    let time = Value::maximum(&each).ok()?;
    let passes = known.decide(Relation::Gtr, &time, &Value::zero()) == Some(true);
    let names = System::of(&components, definitions).names;
    let times = times.iter().map(|times| times.checked_mul(rounds)).collect::<Option<Vec<_>>>()?;
    let rounds = names.into_iter().zip(times).collect();
    passes.then(|| InTheEnd { time: known.simplify(&time), rounds })
}

/// How a port is used: the component, how often before its loop, and how often in a round of it.
#[derive(Clone, Copy)]
struct Use {
    component: usize,
    before: u64,
    each: u64,
}

/// The ports, each with the component that reads it and the one that writes it.
type Ports = BTreeMap<Name, [Use; 2]>;

/// The ports, each written by one component and read by another, with how often each component goes round while the
/// system does so once: the balance equations.
fn together(loops: &[Loop]) -> Option<(Ports, Vec<u64>)> {
    let mut users: BTreeMap<Name, [Option<Use>; 2]> = BTreeMap::new();
    for (component, own) in loops.iter().enumerate() {
        for (within, in_round) in [(&own.before, false), (&own.round, true)] {
            let mut used = Vec::new();
            uses(within, &mut used)?;
            for (port, writes) in used {
                let user = &mut users.entry(port).or_default()[usize::from(writes)];
                let user = user.get_or_insert(Use { component, before: 0, each: 0 });
                if user.component != component {
                    return None;
                }
                *(if in_round { &mut user.each } else { &mut user.before }) += 1;
            }
        }
    }
    let mut ports = BTreeMap::new();
    for (port, both) in users {
        let [Some(reader), Some(writer)] = both else { return None };
        if reader.component == writer.component || reader.each == 0 || writer.each == 0 {
            return None;
        }
        ports.insert(port, [reader, writer]);
    }
    let mut rates: Vec<Option<BigRational>> = vec![None; loops.len()];
    *rates.first_mut()? = Some(BigRational::one());
    let mut open = vec![0usize];
    while let Some(component) = open.pop() {
        let own = rates[component].clone()?;
        for [reader, writer] in ports.values() {
            for (one, other) in [(reader, writer), (writer, reader)] {
                if one.component == component {
                    let rate = &own * BigRational::new(one.each.into(), other.each.into());
                    match &rates[other.component] {
                        Some(before) if *before != rate => return None,
                        Some(_) => {}
                        None => {
                            rates[other.component] = Some(rate);
                            open.push(other.component);
                        }
                    }
                }
            }
        }
    }
    let rates = rates.into_iter().collect::<Option<Vec<_>>>()?;
    let whole = rates.iter().fold(BigInt::one(), |all, rate| all.lcm(rate.denom()));
    let times: Vec<BigInt> = rates.iter().map(|rate| (rate * &whole).to_integer()).collect();
    let common = times.iter().fold(BigInt::zero(), |all, times| all.gcd(times));
    Some((ports, times.iter().map(|times| (times / &common).to_u64()).collect::<Option<_>>()?))
}

/// The ports that these steps use, each time; none where two parts side by side use the same.
fn uses(steps: &[Step], found: &mut Vec<(Name, bool)>) -> Option<()> {
    for step in steps {
        match step {
            Step::Delay(_) => {}
            Step::Port(port, writes) => found.push((port.clone(), *writes)),
            Step::Together(parts) => {
                let mut taken: BTreeSet<Name> = BTreeSet::new();
                for part in parts {
                    let mut own = Vec::new();
                    uses(part, &mut own)?;
                    let ports: BTreeSet<Name> = own.iter().map(|(port, _)| port.clone()).collect();
                    if ports.iter().any(|port| !taken.insert(port.clone())) {
                        return None;
                    }
                    found.extend(own);
                }
            }
        }
    }
    Some(())
}

/// A component on its way through a round.
struct Walk {
    component: usize,
    /// The meetings that were passed at each spot.
    passed: BTreeMap<Spot, u64>,
    /// What each meeting waits for.
    met: Vec<(Meeting, Meeting, Value)>,
}

/// The meetings that a component comes from, and the delays since.
type Since = Vec<(Meeting, Value)>;

impl Walk {
    fn through(&mut self, steps: &[Step], since: Since) -> Option<Since> {
        steps.iter().try_fold(since, |since, step| match step {
            Step::Delay(time) => since.into_iter().map(|(from, delay)| Some((from, delay.add(time).ok()?))).collect(),
            Step::Port(port, _) => Some(self.met(Spot::Port(port.clone()), since)),
            Step::Together(parts) => {
                let mut all: Since = Vec::new();
                for part in parts {
                    for way in self.through(part, since.clone())? {
                        if !all.contains(&way) {
                            all.push(way);
                        }
                    }
                }
                let end = Spot::End(self.component);
                (all.len() <= MOST_WAYS).then(|| self.met(end, all))
            }
        })
    }

    fn met(&mut self, spot: Spot, since: Since) -> Since {
        let number = self.passed.entry(spot.clone()).or_default();
        let here: Meeting = (spot, *number);
        *number += 1;
        self.met.extend(since.into_iter().map(|(from, delay)| (from, here.clone(), delay)));
        vec![(here, Value::zero())]
    }
}

/// The meetings of a round: for each spot the first of them, and how many.
struct Meetings {
    first: BTreeMap<Spot, (usize, u64)>,
    all: usize,
}

impl Meetings {
    fn add(&mut self, spot: Spot, each: u64) -> Option<()> {
        self.first.insert(spot, (self.all, each));
        self.all = self.all.checked_add(each.to_usize()?)?;
        (self.all <= MOST_MEETINGS).then_some(())
    }

    /// Which of them it is, and in which round.
    fn place(&self, (spot, number): &Meeting) -> Option<(usize, i64)> {
        let (start, each) = self.first.get(spot)?;
        Some((start + (number % each).to_usize()?, i64::try_from(number / each).ok()?))
    }
}

/// The ways from meeting to meeting in a round of the system; what a meeting of the first round waits for in the round before
/// is found by going round twice.
fn edges(loops: &[Loop], ports: &Ports, times: &[u64]) -> Option<Vec<Edge>> {
    let mut meetings = Meetings { first: BTreeMap::new(), all: 0 };
    for (port, [reader, _]) in ports {
        meetings.add(Spot::Port(port.clone()), reader.each.checked_mul(times[reader.component])?)?;
    }
    for (component, own) in loops.iter().enumerate().filter(|(_, own)| ends(&own.round) > 0) {
        meetings.add(Spot::End(component), ends(&own.round).checked_mul(times[component])?)?;
    }
    let early = early_rounds(ports, times)?;
    let (mut all, mut waits) = (Vec::new(), Vec::new());
    for ((component, own), times) in loops.iter().enumerate().zip(times) {
        let mut walk = Walk { component, passed: BTreeMap::new(), met: Vec::new() };
        let mut since = walk.through(&own.before, Vec::new())?;
        for _ in 0..times.checked_mul(early)? {
            since = walk.through(&own.round, since)?;
        }
        let before = walk.met.len();
        for _ in 0..*times {
            since = walk.through(&own.round, since)?;
        }
        if since.is_empty() {
            return None;
        }
        for (from, to, delay) in &walk.met[before..] {
            let ((from, round), (to, later)) = (meetings.place(from)?, meetings.place(to)?);
            all.push(Edge { from, to, delay: delay.clone(), rounds: later - round });
        }
        waits.extend(walk.met.into_iter().map(|(from, to, _)| (from, to)));
    }
    all_happen(&waits).then_some(all)
}

/// So many rounds that in them every port is used as often as both sides use it before their loops, and once more by both.
fn early_rounds(ports: &Ports, times: &[u64]) -> Option<u64> {
    let uses = ports.values().flatten();
    let early = uses.map(|own| Some(own.before.div_ceil(own.each.checked_mul(times[own.component])?)));
    let most = early.collect::<Option<Vec<_>>>()?.into_iter().max()?;
    (most <= MOST_EARLY).then_some(most + 2)
}

/// Whether no meeting waits for itself, directly or through others.
fn all_happen(waits: &[(Meeting, Meeting)]) -> bool {
    let mut open: BTreeMap<&Meeting, usize> = BTreeMap::new();
    let mut next: BTreeMap<&Meeting, Vec<&Meeting>> = BTreeMap::new();
    for (from, to) in waits {
        open.entry(from).or_default();
        *open.entry(to).or_default() += 1;
        next.entry(from).or_default().push(to);
    }
    let mut ready: Vec<&Meeting> = open.iter().filter(|(_, waits)| **waits == 0).map(|(one, _)| *one).collect();
    let mut happened = 0;
    while let Some(one) = ready.pop() {
        happened += 1;
        for later in next.get(one).into_iter().flatten() {
            if let Some(waits) = open.get_mut(later) {
                *waits -= 1;
                if *waits == 0 {
                    ready.push(later);
                }
            }
        }
    }
    happened == open.len()
}

/// How often parts that are side by side end in these steps.
fn ends(steps: &[Step]) -> u64 {
    let each = |step: &Step| match step {
        Step::Together(parts) => 1 + parts.iter().map(|part| ends(part)).sum::<u64>(),
        _ => 0,
    };
    steps.iter().map(each).sum()
}

/// The cycles of a round.
struct Search<'a> {
    edges: &'a [Edge],
    path: Vec<usize>,
    /// The times of the cycles, with the rounds that they span.
    found: BTreeMap<Value, BTreeSet<i64>>,
    steps: usize,
}

impl Search<'_> {
    /// The cycles through a meeting and later ones; none where these are too many, or one spans no round: what waits
    /// for itself never happens.
    fn cycles_from(&mut self, start: usize, (at, time, rounds): (usize, Value, i64)) -> Option<()> {
        for edge in self.edges.iter().filter(|edge| edge.from == at && edge.to >= start) {
            self.steps += 1;
            let (time, rounds) = (time.add(&edge.delay).ok()?, rounds + edge.rounds);
            if edge.to == start {
                if rounds <= 0 {
                    return None;
                }
                self.found.entry(time).or_default().insert(rounds);
            } else if !self.path.contains(&edge.to) {
                self.path.push(edge.to);
                self.cycles_from(start, (edge.to, time, rounds))?;
                self.path.pop();
            }
            if self.steps > MOST_STEPS || self.found.len() > MOST_CYCLES {
                return None;
            }
        }
        Some(())
    }
}
