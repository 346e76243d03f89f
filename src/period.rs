//! The period of a closed system: who talks to whom, and one symbolic run that ends where the control points and
//! residual delays repeat (§IV.E, §IV.F; DESIGN section 6).
//!
//! The run is a graph. A *phase* is a moment at which nothing more can happen without time passing; its edges are
//! the rounds that lead from it to the next phase, each under the tests that make it happen. Values are abstracted
//! to variables only where they differ between two visits of the same control point, so the graph is finite
//! whenever the control points are.

pub mod course;
pub mod graph;
pub mod ports;
mod blocked;
mod board;
mod call;
mod closed;
mod congruent;
mod control;
mod copies;
mod drift;
mod env;
mod explore;
mod forever;
mod greatest_cycle;
mod held;
mod instant;
mod lonely;
mod merge;
mod onward;
mod order;
mod passed_on;
mod rates;
mod rest;
mod run;
mod step;
mod stuck;
mod suppose;
mod surroundings;
mod tally;
mod told;

use std::collections::BTreeMap;
use std::fmt;

use num_bigint::BigInt;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value, ValueError};
pub use blocked::{Before, Blocked};
use closed::analysed;
pub use drift::drifting;
pub use greatest_cycle::{InTheEnd, greatest_cycle};
pub(crate) use merge::one_after_another;
use surroundings::Surroundings;
pub use surroundings::analyse_each;
pub(crate) use surroundings::parameters;
pub(crate) use told::{in_case, in_case_after, told_after};

/// A comparison of two values.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Test {
    /// How they are compared.
    pub relation: Relation,
    /// The left value.
    pub left: Value,
    /// The right value.
    pub right: Value,
}

impl Test {
    /// Whether it holds, if the assumptions say so.
    pub fn decide(&self, assumptions: &Assumptions) -> Option<bool> {
        assumptions.decide(self.relation, &self.left, &self.right)
    }

    /// The opposite.
    pub fn negated(&self) -> Test {
        Test { relation: self.relation.negated(), left: self.left.clone(), right: self.right.clone() }
    }

    /// With values for names.
    ///
    /// # Errors
    /// When a value has no normal form.
    pub fn substitute(&self, map: &BTreeMap<Name, Value>) -> Result<Test, ValueError> {
        Ok(Test { relation: self.relation, left: self.left.substitute(map)?, right: self.right.substitute(map)? })
    }
}

/// Why a system has no period, as data.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Failure {
    /// The first failure of §IV.F: groups of components between which there is no port.
    NoCommunication {
        /// Components that share ports, group by group.
        groups: Vec<Vec<String>>,
    },
    /// The second failure: a communication that is never matched.
    Unmatched(Blocked),
    /// The same where nothing waits for it: something beside it ends it each time, or the run never comes to it.
    Unanswered(Blocked),
    /// The same where it is not known whether anything waits: the system was not followed to its end, or something beside
    /// it ends it here or there.
    Lonely(Blocked),
    /// The same in a part of the system that a run may never come to.
    MayWait {
        /// Who waits there.
        blocked: Blocked,
        /// The phases, counted from 0, whose end leads there; none where the start does.
        phases: Vec<usize>,
    },
    /// The balance equations have no solution.
    RateMismatch {
        /// The port at which they contradict the others.
        port: Name,
        /// Who writes, and how often a round.
        writer: (String, usize),
        /// Who reads, and how often a round.
        reader: (String, usize),
        /// How many rounds of the writer go with how many of the reader, by the other ports.
        rounds: Box<(BigInt, BigInt)>,
    },
    /// The third failure.
    NoPeriod {
        /// What would have to be known, or what grows.
        reason: String,
    },
    /// Parts that do not communicate, with the durations of their rounds, which have no common multiple.
    Drift {
        /// Components, and how long one round of them takes.
        one: (String, Value),
        /// Others.
        other: (String, Value),
        /// A natural number for each value of which there is one.
        rational: Option<Name>,
    },
    /// Two delays run, and it is not known which ends first.
    Order {
        /// A component with the delay that remains.
        one: (String, Value),
        /// Another.
        other: (String, Value),
    },
    /// The system goes round in no time.
    Livelock {
        /// The loops that go round.
        cycle: Vec<Name>,
        /// What changes each time, and what it is then.
        changes: Vec<(Name, Value)>,
        /// When it does.
        when: Vec<Test>,
    },
    /// Two communications in one instant, of which either prevents the other.
    KillRace {
        /// Where.
        component: String,
        /// The two ports.
        ports: (Name, Name),
    },
    /// The work was interrupted.
    Interrupted,
    /// Several writers or several readers compete for one communication.
    Contention {
        /// Where they compete.
        port: Name,
        /// Who.
        components: Vec<String>,
        /// Who writes there at once again, but another value.
        anew: Option<String>,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::NoCommunication { groups } => {
                write!(f, "no communication: {} share no port", told::groups(groups))
            }
            Failure::Unmatched(blocked) => write!(f, "unmatched communication: {blocked}"),
            Failure::Unanswered(blocked) => write!(f, "{}; nothing waits for that", blocked.unanswered()),
            Failure::Lonely(blocked) => write!(f, "{}", blocked.unanswered()),
            Failure::MayWait { blocked, phases } => {
                let phases: Vec<String> = phases.iter().map(|phase| format!("phase {}", phase + 1)).collect();
                let place = if phases.is_empty() { "the start".to_string() } else { phases.join(" or ") };
                write!(f, "unmatched communication, if the run comes from {place} to where {blocked}")
            }
            Failure::RateMismatch { port, writer, reader, rounds } => write!(
                f,
                "rates do not match on port {port}: {} writes {} a round, {} reads {} a round, but by the other ports \
                 {} of its rounds go with {} of {}",
                writer.0, writer.1, reader.0, reader.1, rounds.1, rounds.0, writer.0
            ),
            Failure::NoPeriod { reason } => write!(f, "no period found: {reason}"),
            Failure::Drift { one, other, rational } => {
                let found = if self.is_open() { " found" } else { "" };
                let why = match rational {
                    Some(name) => drift::rational_told(&one.1, &other.1, name),
                    None => drift::what_would_do(&one.1, &other.1, "only if"),
                };
                write!(f, "no period{found}: {} goes round in {} and {} in {}{why}", one.0, one.1, other.0, other.1)
            }
            Failure::Order { one, other } => {
                let why = drift::what_tells(&one.1, &other.1);
                write!(
                    f,
                    "no period found: it must be known whether {} <= {}, what remains of the delays of {} and {}{why}",
                    one.1, other.1, one.0, other.0
                )
            }
            Failure::Interrupted => write!(f, "interrupted"),
            Failure::Livelock { cycle, changes, when } => {
                write!(f, "{}{}{}", told::go_round(cycle), in_case(when), told::each_time(changes))
            }
            Failure::KillRace { component, ports } => write!(
                f,
                "in {component} a communication on {} and one on {} are possible in the same instant, and one ends the other",
                ports.0, ports.1
            ),
            Failure::Contention { port, components, anew } => {
                let who = if let [one] = components.as_slice() {
                    &format!("two parts of {one}")
                } else {
                    &components.join(" and ")
                };
                write!(f, "{who} compete for one communication on port {port}{}", told::another_each_time(anew, port))
            }
        }
    }
}

/// A stretch of time in which nothing changes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Segment {
    /// How long.
    pub duration: Value,
    /// What is shown.
    pub observed: Vec<Term>,
}

/// `Delay_d # O1 # …`
pub fn stretch(duration: &Value, observed: &[Term]) -> Term {
    Term::disable(std::iter::once(Term::delay(duration.clone())).chain(observed.iter().cloned()))
}

/// How a run ends.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum End {
    /// All components ended, one of them stopped.
    Stopped,
    /// All components aborted.
    Aborted,
    /// Nothing will change any more.
    Silent {
        /// Communications that wait for ever.
        blocked: Vec<Blocked>,
        /// What is shown for ever.
        observed: Vec<Term>,
    },
    /// Time stops.
    Livelock {
        /// The loops that go round in no time.
        cycle: Vec<Name>,
        /// What changes each time, and what it is then.
        changes: Vec<(Name, Value)>,
    },
}

/// What comes after a round.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Next {
    /// The phase with this number.
    Phase(usize),
    /// The end.
    End(End),
}

/// One way through a round.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Edge {
    /// When it is taken, over the variables of the phase it leaves.
    pub tests: Vec<Test>,
    /// The same tests over the variables of the phase it reaches, where they can be said so.
    pub after: Vec<Option<Test>>,
    /// What passes.
    pub segments: Vec<Segment>,
    /// The variables of the next phase over those of this one: the flow function.
    pub map: BTreeMap<Name, Value>,
    /// Ports with the values that passed, in order.
    pub communications: Vec<(Name, Value)>,
    /// Random draws: names that stand for the value drawn, with the distribution.
    pub draws: Vec<(Name, Value)>,
    /// Whether a loop ended: the system changed its behaviour.
    pub switches: bool,
    /// Where it leads.
    pub next: Next,
}

impl Edge {
    /// Its whole duration.
    ///
    /// # Errors
    /// When the sum has no normal form.
    pub fn duration(&self) -> Result<Value, ValueError> {
        self.segments.iter().try_fold(Value::integer(0), |sum, segment| sum.add(&segment.duration))
    }

    /// The values that are shown and those that pass.
    fn shown_and_passed(&self) -> impl Iterator<Item = &Value> {
        let shown = self.segments.iter().flat_map(|segment| &segment.observed).flat_map(|term| match term.node() {
            Node::Observe(_, values) => values.as_slice(),
            _ => &[],
        });
        shown.chain(self.communications.iter().map(|(_, value)| value))
    }
}

/// A behavioural state.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Phase {
    /// What the system is about to do, component by component.
    pub control: Vec<Term>,
    /// What each component is then, in terms of the variables, each with a `?` before its name.
    pub state: Vec<Term>,
    /// The loops that each component goes round in, outermost first.
    pub loops: Vec<Vec<Name>>,
    /// Its state variables.
    pub variables: Vec<Name>,
    /// What holds of them wherever it is entered: of numbers that were drawn, what their distributions give.
    pub bounds: Vec<Test>,
    /// The ways through a round.
    pub edges: Vec<Edge>,
}

impl Phase {
    /// The rounds that come back to this phase, which has this number.
    pub fn rounds(&self, own: usize) -> impl Iterator<Item = &Edge> {
        self.edges.iter().filter(move |edge| edge.next == Next::Phase(own))
    }

    /// The guard of the phase: when a round of it is followed by another, over its variables; one way in which it is for
    /// each kind of round. None where there is no condition, or one that these variables do not say.
    pub fn guard(&self, own: usize) -> Vec<Vec<Test>> {
        let ways = self.rounds(own).map(|edge| edge.after.iter().cloned().collect::<Option<Vec<Test>>>());
        let mut ways: Vec<Vec<Test>> = ways.collect::<Option<_>>().unwrap_or_default();
        ways.sort();
        ways.dedup();
        if ways.iter().any(Vec::is_empty) { Vec::new() } else { ways }
    }
}

/// What a variable of a phase is called in a statement for all its values: a name that no process can bind.
pub(crate) fn open_name(name: &Name) -> Name {
    Name::new(&format!("?{name}"))
}

/// The period of a system.
#[derive(Clone, Debug)]
pub struct Period {
    /// The components, as they were given.
    pub components: Vec<Term>,
    /// Their names.
    pub names: Vec<String>,
    /// From the start to the first phase: takes no time unless phases were merged into it.
    pub initial: Vec<Edge>,
    /// The phases.
    pub phases: Vec<Phase>,
    /// Communications that wait for ever in some run.
    pub warnings: Vec<Failure>,
    /// Whether its ways may never be taken: what remains of delays is a variable, and asked for in every order.
    pub in_every_order: bool,
    /// Whether its ways are those that the one run takes, and no others were looked for: all that might be are too many, or some of
    /// them mean nothing.
    pub along_the_run: bool,
}

impl Period {
    /// All ways: those from the start, then those from each phase.
    pub fn ways(&self) -> impl Iterator<Item = &Edge> {
        self.initial.iter().chain(self.phases.iter().flat_map(|phase| &phase.edges))
    }

    /// How long one round takes, where the phases are gone through in one way only and take the same time for ever.
    pub fn lasting(&self) -> Option<Value> {
        drift::round(&self.initial, &self.phases)
    }

    /// How often each component goes round in one period, where the balance equations say so; what a component without
    /// ports does is looked at for this.
    pub fn repetitions(
        &self,
        definitions: &Definitions,
        assumptions: &Assumptions,
        interrupted: &dyn Fn() -> bool,
    ) -> Option<Vec<(String, u64)>> {
        rates::in_one_period(self, &Surroundings::new(definitions, assumptions, interrupted))
    }

    /// Whether some way through the phases comes back to one of them.
    pub fn repeats(&self) -> bool {
        repeats(&self.phases)
    }
}

/// Whether some way through these phases comes back to one of them.
fn repeats(phases: &[Phase]) -> bool {
    let target = |edge: &Edge| if let Next::Phase(number) = edge.next { Some(number) } else { None };
    let mut entries = vec![0usize; phases.len()];
    for number in phases.iter().flat_map(|phase| phase.edges.iter().filter_map(target)) {
        entries[number] += 1;
    }
    let mut free: Vec<usize> = (0..entries.len()).filter(|number| entries[*number] == 0).collect();
    let mut left = entries.len();
    while let Some(number) = free.pop() {
        left -= 1;
        for next in phases[number].edges.iter().filter_map(target) {
            entries[next] -= 1;
            if entries[next] == 0 {
                free.push(next);
            }
        }
    }
    left > 0
}

/// Finds the period of the system of these components.
///
/// # Errors
/// The failures that leave no period, static ones first.
pub fn analyse(
    components: &[Term],
    definitions: &Definitions,
    assumptions: &Assumptions,
) -> Result<Period, Vec<Failure>> {
    analyse_until(components, definitions, assumptions, &|| false)
}

/// The same, as long as it is not interrupted.
///
/// # Errors
/// The failures that leave no period, [`Failure::Interrupted`] among them.
pub fn analyse_until(
    components: &[Term],
    definitions: &Definitions,
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Result<Period, Vec<Failure>> {
    analysed(components, &Surroundings::new(definitions, assumptions, interrupted), true)
}

/// The phases of a system whether it has a period or not, for a question that an end of the run may answer; what stands
/// in the way of a period is among the warnings.
///
/// # Errors
/// What leaves the run unknown.
pub fn followed(
    components: &[Term],
    definitions: &Definitions,
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Result<Period, Vec<Failure>> {
    analysed(components, &Surroundings::new(definitions, assumptions, interrupted), false)
}
