//! The symbolic run: phases found one from another until no new one turns up.

mod along;
mod bounds;
mod clocks;
mod delays;
mod edges;
mod general;
mod kept;
mod waits;

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use self::bounds::Bounds;
use self::delays::First;
use self::kept::{Kept, steering};
use super::control::Control;
use super::held::{Held, Together, first_held, name_variables};
use super::instant::{Clock, Moment};
use super::lonely::{Ended, Waiting};
use super::merge::merge;
use super::passed_on::PassedOn;
use super::ports::System;
use super::rest::Tails;
use super::run::{Halt, Path, RawTest, Run, Settler};
use super::step::{Slot, inspect, loops, map_parts, map_values, pass, readable, standing};
use super::suppose::suppose;
use super::{Before, Blocked, Edge, End, Failure, Phase, Segment, Surroundings, drift, open_name, stuck};
use crate::assumption::Assumptions;
use crate::digest::Quick;
use crate::name::Name;
use crate::term::Term;
use crate::value::{Relation, Value, ValueError};

/// Phases that a system may have, before those of one behaviour are merged.
const MOST_PHASES: usize = 30_000;
/// Phases at the same control points that differ in the delays that remain, where these have no rational ratio.
const MOST_REMAINDERS: usize = 100;
/// The same where durations are values that processes hold, and others each time.
const MOST_HELD: usize = 300;
/// Phases that a system may have where values that change are kept apart, and those of one control point.
const MOST_APART: (usize, usize) = (1_000, 64);
/// Ways through one round.
const MOST_WAYS: usize = 128;
/// Explorations of one phase, after which components that are alike have their values generalised together: of a long
/// chain of them one after the other would change.
const MOST_EXPLORATIONS: usize = 32;

/// The initial edges and the phases.
pub(super) struct Graph {
    pub(super) initial: Vec<Edge>,
    pub(super) phases: Vec<Phase>,
    /// Reads and writes that wait for ever while the rest goes on.
    pub(super) stuck: Vec<Blocked>,
    /// Who waits for a read or a write at the end of some instant, with no delay to end the waiting.
    pub(super) waiting: Waiting,
    /// Whether which delay ends first is asked in every order.
    pub(super) in_every_order: bool,
    /// Whether the ways are those of the one run there is, and no others were looked for.
    pub(super) along_the_run: bool,
}

struct Spot {
    control: Control,
    /// The delays that remain; none for one that varies from round to round, and stands among the values held.
    delays: Vec<Option<Value>>,
    held: Vec<Held>,
    variables: Vec<Name>,
    hints: Vec<Name>,
    /// The how manyth component of a vector each value held is, if it is one.
    axes: Vec<Option<usize>>,
    ways: Vec<Way>,
    explorations: usize,
    together: Together,
    /// What is known of the values that come, place by place; empty where nothing is.
    bounds: Vec<Bounds>,
}

/// One way through a round, before the variables of the phase it reaches are final.
#[derive(Clone)]
struct Way {
    tests: Vec<RawTest>,
    segments: Vec<Segment>,
    communications: Vec<(Name, Value)>,
    draws: Vec<(Name, Value)>,
    switches: bool,
    /// The components that took part in a communication.
    moved: BTreeSet<usize>,
    next: Target,
}

#[derive(Clone)]
enum Target {
    Spot(usize, Vec<Value>),
    End(End),
}

/// The phases of one control point by the delays that remain and, where these are kept apart, by the values held.
type Remainders = Quick<Vec<Option<Value>>, usize>;

struct Explorer<'a> {
    clock: Clock<'a>,
    assumptions: &'a Assumptions,
    spots: Vec<Spot>,
    /// The phases by their control points, and then by the delays that remain.
    index: Quick<Control, Remainders>,
    kept: Kept,
    /// Whether a value that differs between two visits has been made a variable.
    general: bool,
    /// Whether how often one delay goes into another depends on a parameter, or which ends first on what varies.
    counted: bool,
    /// Whether more delays that remain were found than may be.
    grown: bool,
    /// Whether which delay ends first was asked.
    ordered: bool,
    /// Why nothing comes round, where nobody holds up components whose rounds have no rational ratio.
    drifts: Option<Failure>,
    /// The most ways beside one for each phase, those found so far, and whether they were more.
    most: Option<usize>,
    beside: usize,
    many: bool,
    /// Along one run: what the variables of the phase are.
    visit: Option<BTreeMap<Name, Value>>,
    /// The names that steer something, where these alone are kept apart.
    steering: Option<BTreeSet<Name>>,
    /// What is known of the variables of the phase that is explored.
    here: BTreeMap<Name, Bounds>,
}

/// Runs the system. Where that fails with variables for what changes, a few values that come again and again may do:
/// a delay of x that is 1 and 2 by turns is positive, of which the variable x says nothing.
pub(super) fn explore(components: &[Term], system: &System, run: &Surroundings<'_>) -> Result<Graph, Failure> {
    let Surroundings { definitions, assumptions, interrupted, .. } = *run;
    let reserved = run.reserved(components);
    // Beside reads and writes stand calls and delays.
    let room = |wanted: usize| wanted.min(MOST_PHASES);
    let (parts, passed_on) = (room(2 * system.operations), PassedOn::of(components, definitions));
    let tails = RefCell::new(Tails::with_capacity(room(components.len()), parts, passed_on));
    let (durations, ended) = (RefCell::default(), Ended::of(&system.users));
    let settler = Settler { definitions, reserved: &reserved, tails, durations, ended };
    let (names, users, operations) = (system.names.as_slice(), &system.users, system.operations);
    let clock = Clock { settler, names, users, operations, interrupted };
    let (found, explorer) = Explorer::new(clock, assumptions, Kept::Delays).graph(components);
    let mut failure = match found {
        Err(failure) if failure != Failure::Interrupted => failure,
        found => return found,
    };
    let grown = explorer.grown && explorer.clock.settler.durations_differ();
    let counted = explorer.counted
        || grown
        || matches!(&failure, Failure::Order { one, other } if drift::counted([&one.1, &other.1].into_iter(), assumptions));
    let general = explorer.general;
    let others = [(general, Kept::Values), (general, Kept::Steering), (counted, Kept::Nothing)];
    let drifts = explorer.grown || matches!(failure, Failure::Order { .. });
    let follow = explorer.general && matches!(failure, Failure::NoPeriod { .. });
    let mut clock = explorer.clock;
    for kept in others.into_iter().filter_map(|(may, kept)| may.then_some(kept)) {
        let mut explorer = Explorer::new(clock, assumptions, kept);
        if kept == Kept::Steering {
            explorer.steering = Some(steering(components, definitions));
        }
        match explorer.run(components) {
            Err(other) if other != Failure::Interrupted => {
                clock = explorer.clock;
                if grown && kept == Kept::Nothing {
                    failure = failure.with_variables(other);
                }
            }
            found => return found,
        }
    }
    if follow {
        // What a variable may be the run need not come to.
        let (found, kept) = Explorer::alone(components, clock, assumptions);
        match found {
            found @ (Ok(_) | Err(Failure::Interrupted)) => return found,
            Err(_) => clock = kept,
        }
    }
    if drifts && !counted {
        let mut explorer = Explorer::new(clock, assumptions, Kept::Nothing);
        match explorer.run(components) {
            Err(Failure::Interrupted) => failure = Failure::Interrupted,
            _ => failure = explorer.drifts.unwrap_or(failure),
        }
    }
    Err(failure)
}

impl<'a> Explorer<'a> {
    fn new(clock: Clock<'a>, assumptions: &'a Assumptions, kept: Kept) -> Explorer<'a> {
        let (spots, index) = (Vec::new(), Quick::default());
        Explorer {
            clock,
            assumptions,
            spots,
            index,
            kept,
            general: false,
            counted: false,
            grown: false,
            ordered: false,
            drifts: None,
            most: None,
            beside: 0,
            many: false,
            visit: None,
            steering: None,
            here: BTreeMap::new(),
        }
    }

    fn run(&mut self, components: &[Term]) -> Result<Graph, Failure> {
        let mut work = BTreeSet::new();
        let initial = self.begin(components, &mut work)?;
        // This comes to an end: a phase is explored again only after one of its values became a variable, or one of its
        // variables two.
        while let Some(spot) = work.pop_first() {
            self.explore_spot(spot, &mut work)?;
        }
        if self.kept == Kept::Nothing {
            self.drifts = self.drifting_clocks(&initial).ok().flatten();
        }
        self.finish(&initial)
    }

    fn explore_spot(&mut self, spot: usize, work: &mut BTreeSet<usize>) -> Result<(), Failure> {
        let state = self.state_of(spot).map_err(failure_of)?;
        let (mut delays, mut shown) = (Vec::new(), Vec::new());
        for run in &state {
            inspect(run, &mut delays, &mut shown).map_err(failure_of)?;
        }
        shown.sort();
        shown.dedup();
        delays.sort();
        delays.dedup();
        let mut assumptions = self.assumptions.clone();
        self.assume_bounds(spot, &mut assumptions);
        for delay in &delays {
            if assumptions.decide(Relation::Gtr, delay, &Value::zero()) != Some(true) {
                assumptions.assume(Relation::Gtr, delay, &Value::zero());
            }
        }
        let mut ways = Vec::new();
        let firsts = self.first(&state, &delays, assumptions)?;
        self.ordered |= firsts.len() > 1;
        for First { path, least } in firsts {
            let mut state = state.clone();
            state.iter_mut().try_for_each(|run| pass(run, &least)).map_err(unreduced)?;
            let segments = vec![Segment { duration: least, observed: shown.clone() }];
            ways.extend(self.ways(state, segments, path, work)?);
        }
        self.count_ways(ways.len(), self.spots[spot].ways.len())?;
        self.spots[spot].ways = ways;
        self.spots[spot].explorations += 1;
        Ok(())
    }

    /// All that may happen in the instant at which this state is entered.
    fn ways(
        &mut self,
        state: Vec<Run>,
        segments: Vec<Segment>,
        path: Path,
        work: &mut BTreeSet<usize>,
    ) -> Result<Vec<Way>, Failure> {
        let start = Moment::new(state, path, self.clock.users.len());
        let mut moments = vec![start.clone()];
        let mut ways = Vec::new();
        let mut forks = 0usize;
        while let Some(mut moment) = moments.pop() {
            let found = match self.clock.instant(&mut moment) {
                Err(Halt::Failed(failure)) => {
                    let anew = start.clone().settled_anew(moment.path);
                    let (same, end) = self.clock.whatever_order(anew, *failure)?;
                    moment = same;
                    Ok(end)
                }
                found => found,
            };
            match found {
                Ok(next) => {
                    let next = match next {
                        Some(end) => Target::End(end),
                        None => self.arrive(&moment.state, &moment.path.draws, work)?,
                    };
                    ways.push(Way {
                        tests: moment.path.tests,
                        segments: segments.clone(),
                        communications: moment.communications,
                        draws: moment.path.draws,
                        switches: moment.path.exits > 0,
                        moved: moment.moved,
                        next,
                    });
                }
                Err(Halt::Failed(failure)) => return Err(*failure),
                Err(Halt::Split(question)) => {
                    forks += 1;
                    if forks > MOST_WAYS {
                        self.many = true;
                        let asked = format!("too many ways through one round, by questions such as {}", question.raw);
                        return Err(Failure::not_found(asked));
                    }
                    for answer in self.answers(&question)? {
                        moments.extend(suppose(&self.clock.settler, &moment, &question, answer));
                    }
                }
            }
        }
        Ok(ways)
    }

    /// Whether what stands there steers nothing, if that matters.
    fn is_beside(&self, slot: &Slot<'_>) -> bool {
        matches!(slot, Slot::Name(name) if self.steering.as_ref().is_some_and(|steering| !steering.contains(name)))
    }

    /// The phase of a state, new or known; a known one may have to be generalised and explored again.
    fn arrive(
        &mut self,
        state: &[Run],
        draws: &[(Name, Value)],
        work: &mut BTreeSet<usize>,
    ) -> Result<Target, Failure> {
        let (mut entries, mut hints, mut delays, mut beside) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut axes: Vec<Option<usize>> = Vec::new();
        let mut take = |slot: Slot<'_>, value: &Value| -> Result<Value, std::convert::Infallible> {
            if matches!(slot, Slot::Delay) {
                if self.kept != Kept::Nothing && !self.clock.settler.varies(value) {
                    delays.push(Some(value.clone()));
                    return Ok(Value::zero());
                }
                delays.push(None);
            }
            let hint = if let Slot::Name(name) = slot { name.clone() } else { Name::new("rest") };
            let nothing = self.is_beside(&slot);
            let Some(parts) = value.components() else {
                entries.push(value.clone());
                axes.push(None);
                beside.push(nothing);
                hints.push(hint);
                return Ok(Value::zero());
            };
            axes.extend((0..parts.len()).map(Some));
            beside.extend(parts.iter().map(|_| nothing));
            hints.extend((0..parts.len()).map(|place| hint.component(place, parts.len())));
            let nothing = Value::vector(vec![Value::zero(); parts.len()]);
            entries.extend(parts);
            Ok(nothing.unwrap_or_else(|_| Value::zero()))
        };
        let Ok(runs) = map_parts(state, &mut take);
        let bounds = self.bounds_of(&entries, draws);
        let control = Control::of(runs);
        let control = self.index.get_key_value(&control).map_or(control, |(known, _)| known.clone());
        let remainders = self.index.entry(control.clone()).or_default();
        let mut key = delays.clone();
        if self.kept.values() {
            let kept = |(entry, beside): (&Value, &bool)| {
                (!beside && !self.clock.settler.varies(entry)).then(|| entry.clone())
            };
            key.extend(entries.iter().zip(&beside).map(kept));
        }
        if let Some(found) = remainders.get(&key).copied() {
            if self.absorb(found, &entries) | self.loosen(found, &bounds) {
                work.insert(found);
            }
            return Ok(Target::Spot(found, entries));
        }
        let number = self.spots.len();
        let left = || remainders.keys().chain([&delays]).flat_map(|delays| delays.iter().flatten());
        let apart = || drift::apart(left(), self.assumptions);
        let held = remainders.len() >= MOST_HELD && self.clock.settler.durations_differ();
        let many = held || self.kept.values() && (number >= MOST_APART.0 || remainders.len() >= MOST_APART.1);
        if many || number >= MOST_PHASES || (remainders.len() == MOST_REMAINDERS && apart()) {
            (self.counted, self.grown) = (drift::counted(left(), self.assumptions), true);
            return Err(drift::growth(self.clock.names, state, number, self.assumptions));
        }
        remainders.insert(key, number);
        let held = first_held(&entries, &axes, |value| self.clock.settler.varies(value));
        let variables = name_variables(&held, &hints, self.clock.settler.reserved);
        let (ways, explorations, together) = (Vec::new(), 0, Together::SoFar);
        self.spots.push(Spot { control, delays, held, variables, hints, axes, ways, explorations, together, bounds });
        work.insert(number);
        Ok(Target::Spot(number, entries))
    }

    fn state_of(&self, number: usize) -> Result<Vec<Run>, Halt> {
        let mut state = Vec::with_capacity(self.clock.names.len());
        self.each_over(number, &self.spots[number].variables, &mut |run| state.push(run))?;
        Ok(state)
    }

    /// What each component is at a phase, for these variables.
    fn each_over(&self, number: usize, variables: &[Name], take: &mut dyn FnMut(Run)) -> Result<(), Halt> {
        let spot = &self.spots[number];
        let mut held = spot.held.iter();
        let mut delays = spot.delays.iter();
        let mut fill = |slot: Slot<'_>, value: &Value| -> Result<Value, Halt> {
            if matches!(slot, Slot::Delay)
                && let Some(Some(left)) = delays.next()
            {
                return Ok(left.clone());
            }
            let mut next = |value: Value| match held.next() {
                Some(Held::Constant(value)) => value.clone(),
                Some(Held::Class(class)) => Value::variable(&variables[*class]),
                None => value,
            };
            match value.components() {
                None => Ok(next(value.clone())),
                Some(parts) => {
                    Value::vector(parts.into_iter().map(next).collect()).or_else(|error| Halt::because(error.0))
                }
            }
        };
        spot.control.runs.iter().try_for_each(|run| {
            take(map_values(run, &mut fill)?);
            Ok(())
        })
    }

    fn finish(&self, initial: &[Way]) -> Result<Graph, Failure> {
        let mut phases = Vec::new();
        for spot in &self.spots {
            phases.push(Phase {
                control: Vec::new(),
                state: Vec::new(),
                loops: Vec::new(),
                variables: spot.variables.clone(),
                bounds: spot.told_bounds(),
                edges: spot.ways.iter().map(|way| self.edge(way)).collect::<Result<_, Failure>>()?,
            });
        }
        let initial = initial.iter().map(|way| self.edge(way)).collect::<Result<_, Failure>>()?;
        let (mut initial, mut phases, numbers) = merge(initial, phases, self.assumptions).map_err(unreduced)?;
        let tails = self.clock.settler.tails.borrow();
        for (phase, number) in phases.iter_mut().zip(numbers) {
            let open: Vec<Name> = phase.variables.iter().map(open_name).collect();
            let Phase { variables, loops: gone_round, control, state, .. } = phase;
            let mut told = |run: Run| {
                gone_round.push(loops(&run));
                control.push(readable(&run, &tails));
                if open.is_empty() {
                    state.push(standing(&run, &tails));
                }
            };
            self.each_over(number, variables, &mut told).map_err(failure_of)?;
            if !open.is_empty() {
                let mut stands = |run: Run| state.push(standing(&run, &tails));
                self.each_over(number, &open, &mut stands).map_err(failure_of)?;
            }
        }
        drop(tails);
        let mut stuck = self.stuck()?;
        let used = |port: &Name| {
            let edges = initial.iter().chain(phases.iter().flat_map(|phase| &phase.edges));
            edges.flat_map(|edge| &edge.communications).any(|(other, _)| other == port)
        };
        for one in stuck.iter_mut().filter(|one| used(&one.port)) {
            one.before = Before::Perhaps;
        }
        stuck::note_earlier(&mut initial, &mut phases, &|blocked| self.clock.only_partner(blocked));
        let waiting = self.waiting(initial.iter().chain(phases.iter().flat_map(|phase| &phase.edges)));
        Ok(Graph { initial, phases, stuck, waiting, in_every_order: self.ordered, along_the_run: self.visit.is_some() })
    }
}

fn unreduced(error: ValueError) -> Failure {
    Failure::not_found(error.0)
}

fn failure_of(halt: Halt) -> Failure {
    match halt {
        Halt::Failed(failure) => *failure,
        Halt::Split(question) => Failure::not_found(format!("it must be known whether {}", question.test)),
    }
}
