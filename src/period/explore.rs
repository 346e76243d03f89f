//! The symbolic run: phases found one from another until no new one turns up.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::instant::{Clock, Moment};
use super::run::{Env, Halt, Path, RawTest, Run, Settler};
use super::step::{Slot, inspect, map_values, readable};
use super::{Edge, End, Failure, Next, Phase, Segment, Test};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::{bound_names, read_names};
use crate::term::Term;
use crate::value::{Relation, Sort, Value};

/// Phases that a system may have.
const MOST_PHASES: usize = 300;
/// Ways through one round.
const MOST_WAYS: usize = 128;
/// Explorations in all; values are generalised at most a few times a phase, so this is never met in practice.
const MOST_EXPLORATIONS: usize = 3_000;

/// The initial edges and the phases, before merging.
pub(crate) struct Graph {
    pub initial: Vec<Edge>,
    pub phases: Vec<Phase>,
}

/// What a place of a phase holds.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Held {
    Constant(Value),
    Class(usize),
}

struct Spot {
    shape: Vec<Run>,
    held: Vec<Held>,
    variables: Vec<Name>,
    hints: Vec<Name>,
    ways: Vec<Way>,
}

/// One way through a round, before the variables of the phase it reaches are final.
#[derive(Clone)]
struct Way {
    tests: Vec<RawTest>,
    segments: Vec<Segment>,
    communications: Vec<(Name, Value)>,
    draws: Vec<(Name, Value)>,
    switches: bool,
    next: Target,
}

#[derive(Clone)]
enum Target {
    Spot(usize, Vec<Value>),
    End(End),
}

struct Explorer<'a> {
    clock: Clock<'a>,
    assumptions: &'a Assumptions,
    spots: Vec<Spot>,
    index: HashMap<String, usize>,
}

/// Runs the system.
pub(crate) fn explore(
    components: &[Term],
    names: &[String],
    definitions: &Definitions,
    assumptions: &Assumptions,
) -> Result<Graph, Failure> {
    let reserved = reserved(components, definitions, assumptions);
    let settler = Settler { definitions, reserved: &reserved };
    let mut explorer =
        Explorer { clock: Clock { settler, names }, assumptions, spots: Vec::new(), index: HashMap::new() };
    let start: Vec<Run> = components.iter().map(|term| Run::Fresh(term.clone(), Env::new())).collect();
    let mut work = Vec::new();
    let initial = explorer.ways(start, Vec::new(), assumptions.clone(), &mut work)?;
    let mut explorations = 0usize;
    while let Some(spot) = work.pop() {
        explorations += 1;
        if explorations > MOST_EXPLORATIONS {
            return Err(Failure::NoPeriod { reason: "the control points do not settle".to_string() });
        }
        explorer.explore_spot(spot, &mut work)?;
    }
    explorer.finish(&initial)
}

/// The names that have one value throughout: all that are free in what is given.
fn reserved(components: &[Term], definitions: &Definitions, assumptions: &Assumptions) -> BTreeSet<Name> {
    let mut names = assumptions.variables();
    for component in components {
        let bound = bound_names(component);
        names.extend(read_names(component).into_iter().filter(|name| !bound.contains(name)));
    }
    for definition in definitions.iter() {
        let bound = bound_names(&definition.body);
        let local = |name: &Name| bound.contains(name) || definition.parameters.contains(name);
        names.extend(read_names(&definition.body).into_iter().filter(|name| !local(name)));
    }
    names
}

impl Explorer<'_> {
    fn explore_spot(&mut self, spot: usize, work: &mut Vec<usize>) -> Result<(), Failure> {
        let state = self.state_of(spot).map_err(failure_of)?;
        let (mut delays, mut shown) = (Vec::new(), Vec::new());
        for run in &state {
            inspect(run, &mut delays, &mut shown).map_err(failure_of)?;
        }
        shown.sort();
        shown.dedup();
        let mut assumptions = self.assumptions.clone();
        for delay in &delays {
            assumptions.assume(Relation::Gtr, delay, &Value::integer(0));
        }
        let least = self.least(&delays, &assumptions)?;
        let passed: Result<Vec<Run>, Failure> = state.iter().map(|run| pass(run, &least)).collect();
        let segments = vec![Segment { duration: least, observed: shown }];
        let ways = self.ways(passed?, segments, assumptions, work)?;
        self.spots[spot].ways = ways;
        Ok(())
    }

    fn least(&self, delays: &[Value], assumptions: &Assumptions) -> Result<Value, Failure> {
        let mut least: Option<&Value> = None;
        for delay in delays {
            least = match least {
                None => Some(delay),
                Some(other) => match assumptions.decide(Relation::Lte, other, delay) {
                    Some(true) => Some(other),
                    Some(false) => Some(delay),
                    None => {
                        let reason = format!("it must be known whether {other} <= {delay}");
                        return Err(Failure::NoPeriod { reason });
                    }
                },
            };
        }
        least.cloned().ok_or_else(|| Failure::NoPeriod { reason: "nothing waits".to_string() })
    }

    /// All that may happen in the instant at which this state is entered.
    fn ways(
        &mut self,
        state: Vec<Run>,
        segments: Vec<Segment>,
        assumptions: Assumptions,
        work: &mut Vec<usize>,
    ) -> Result<Vec<Way>, Failure> {
        let path = Path { assumptions, ..Path::default() };
        let mut moments = vec![Moment { state, path, communications: Vec::new(), history: Vec::new(), besides: None }];
        let mut ways = Vec::new();
        let mut forks = 0usize;
        while let Some(mut moment) = moments.pop() {
            match self.clock.instant(&mut moment) {
                Ok(next) => {
                    let next = match next {
                        Some(end) => Target::End(end),
                        None => self.arrive(&moment.state, work)?,
                    };
                    ways.push(Way {
                        tests: moment.path.tests,
                        segments: segments.clone(),
                        communications: moment.communications,
                        draws: moment.path.draws,
                        switches: moment.path.exits > 0,
                        next,
                    });
                }
                Err(Halt::Failed(failure)) => return Err(*failure),
                Err(Halt::Split(question)) => {
                    forks += 1;
                    if forks > MOST_WAYS {
                        return Err(Failure::NoPeriod { reason: "too many ways through one round".to_string() });
                    }
                    for answer in [false, true] {
                        moments.extend(self.suppose(&moment, &question, answer));
                    }
                }
            }
        }
        Ok(ways)
    }

    /// The moment with an answer assumed; nothing if that contradicts what is known.
    fn suppose(&self, moment: &Moment, question: &RawTest, answer: bool) -> Option<Moment> {
        let mut moment = moment.clone();
        let turn = |test: &Test| if answer { test.clone() } else { test.negated() };
        let test = turn(&question.test);
        moment.path.assumptions.assume(test.relation, &test.left, &test.right);
        if moment.path.assumptions.contradictory() {
            return None;
        }
        if test.relation == Relation::Eq {
            let (from, to) = match (self.clock.settler.varies(&test.left), self.clock.settler.varies(&test.right)) {
                (true, false) => (Some(&test.left), &test.right),
                (false, true) => (Some(&test.right), &test.left),
                _ => (None, &test.left),
            };
            if let Some(from) = from {
                let mut replace = |_: Slot<'_>, value: &Value| -> Result<Value, std::convert::Infallible> {
                    Ok(if value == from { to.clone() } else { value.clone() })
                };
                let Ok(state) = moment.state.iter().map(|run| map_values(run, &mut replace)).collect();
                moment.state = state;
            }
        }
        let raw = turn(&question.raw);
        moment.path.tests.push(RawTest { test, raw, env: question.env.clone() });
        Some(moment)
    }

    /// The phase of a state, new or known; a known one may have to be generalised and explored again.
    fn arrive(&mut self, state: &[Run], work: &mut Vec<usize>) -> Result<Target, Failure> {
        let mut entries = Vec::new();
        let mut hints = Vec::new();
        let mut take = |slot: Slot<'_>, value: &Value| -> Result<Value, std::convert::Infallible> {
            if matches!(slot, Slot::Delay) && !self.clock.settler.varies(value) {
                return Ok(value.clone());
            }
            let hint = if let Slot::Name(name) = slot { name.clone() } else { Name::new("rest") };
            let Sort::Vector(length) = value.sort() else {
                entries.push(value.clone());
                hints.push(hint);
                return Ok(Value::integer(0));
            };
            // The components of a vector are variables of their own.
            for (place, part) in (0..length).filter_map(|place| Some((place, value.component(place)?))) {
                entries.push(part);
                hints.push(component_name(&hint, place, length));
            }
            Ok(value.sub(value).unwrap_or_else(|_| value.clone()))
        };
        let Ok(shape) = state.iter().map(|run| map_values(run, &mut take)).collect::<Result<Vec<Run>, _>>();
        let key = format!("{shape:?}");
        if let Some(found) = self.index.get(&key).copied() {
            if self.absorb(found, &entries) && !work.contains(&found) {
                work.push(found);
            }
            return Ok(Target::Spot(found, entries));
        }
        let number = self.spots.len();
        if number >= MOST_PHASES {
            return Err(Failure::NoPeriod { reason: self.growth() });
        }
        let held = first_held(&entries, |value| self.clock.settler.varies(value));
        let mut spot = Spot { shape, held, variables: Vec::new(), hints, ways: Vec::new() };
        name_variables(&mut spot, self.clock.settler.reserved);
        self.spots.push(spot);
        self.index.insert(key, number);
        work.push(number);
        Ok(Target::Spot(number, entries))
    }

    fn growth(&self) -> String {
        let delays = |spot: &Spot| {
            let mut found = Vec::new();
            let mut shown = Vec::new();
            let _ = spot.shape.iter().try_for_each(|run| inspect(run, &mut found, &mut shown).map_err(|_| ()));
            found
        };
        let last = self.spots.last().map(delays).unwrap_or_default();
        let last: Vec<String> = last.iter().map(Value::to_string).collect();
        format!(
            "after {MOST_PHASES} phases neither the control points nor the delays that remain ({}) have repeated",
            last.join(", ")
        )
    }

    /// Makes a phase general enough for another visit; true if it had to change.
    fn absorb(&mut self, number: usize, entries: &[Value]) -> bool {
        let varying: Vec<bool> = entries.iter().map(|entry| self.clock.settler.varies(entry)).collect();
        let spot = &mut self.spots[number];
        let mut classes: BTreeMap<(Held, Value), usize> = BTreeMap::new();
        let mut held = Vec::new();
        for ((old, entry), varies) in spot.held.iter().zip(entries).zip(varying) {
            match old {
                Held::Constant(value) if value == entry && !varies => held.push(old.clone()),
                _ => {
                    let next = classes.len();
                    held.push(Held::Class(*classes.entry((old.clone(), entry.clone())).or_insert(next)));
                }
            }
        }
        let changed = held != spot.held;
        spot.held = held;
        name_variables(spot, self.clock.settler.reserved);
        changed
    }

    fn state_of(&self, number: usize) -> Result<Vec<Run>, Halt> {
        let spot = &self.spots[number];
        let mut held = spot.held.iter();
        let mut fill = |slot: Slot<'_>, value: &Value| -> Result<Value, Halt> {
            if matches!(slot, Slot::Delay) && *value != Value::integer(0) {
                return Ok(value.clone());
            }
            let mut one = || match held.next() {
                Some(Held::Constant(value)) => value.clone(),
                Some(Held::Class(class)) => Value::variable(&spot.variables[*class]),
                None => Value::zero(),
            };
            Ok(match value.sort() {
                Sort::Vector(length) => {
                    Value::vector((0..length).map(|_| one()).collect()).unwrap_or_else(|_| value.clone())
                }
                _ => one(),
            })
        };
        spot.shape.iter().map(|run| map_values(run, &mut fill)).collect()
    }

    fn finish(&self, initial: &[Way]) -> Result<Graph, Failure> {
        let mut phases = Vec::new();
        for (number, spot) in self.spots.iter().enumerate() {
            let state = self.state_of(number).map_err(failure_of)?;
            phases.push(Phase {
                control: state.iter().map(|run| readable(run).to_string()).collect(),
                variables: spot.variables.clone(),
                edges: spot.ways.iter().map(|way| self.edge(way)).collect::<Result<_, Failure>>()?,
            });
        }
        let initial = initial.iter().map(|way| self.edge(way)).collect::<Result<_, Failure>>()?;
        Ok(Graph { initial, phases })
    }

    fn edge(&self, way: &Way) -> Result<Edge, Failure> {
        let mut map = BTreeMap::new();
        let next = match &way.next {
            Target::End(end) => Next::End(end.clone()),
            Target::Spot(number, entries) => {
                let spot = &self.spots[*number];
                for (held, entry) in spot.held.iter().zip(entries) {
                    if let Held::Class(class) = held {
                        map.insert(spot.variables[*class].clone(), entry.clone());
                    }
                }
                Next::Phase(*number)
            }
        };
        let after = way.tests.iter().map(|test| self.after(test, &map)).collect();
        Ok(Edge {
            tests: way.tests.iter().map(|test| test.test.clone()).collect(),
            after,
            segments: way.segments.clone(),
            map,
            communications: way.communications.clone(),
            draws: way.draws.clone(),
            switches: way.switches,
            next,
        })
    }

    /// A test said over the variables that the round leads to.
    fn after(&self, test: &RawTest, map: &BTreeMap<Name, Value>) -> Option<Test> {
        let mut renamed = Env::new();
        let said = |value: &Value| match map.iter().find(|(_, image)| *image == value) {
            Some((variable, _)) => Some(Value::variable(variable)),
            None if !self.clock.settler.varies(value) => Some(value.clone()),
            None => None,
        };
        for (name, value) in &test.env {
            let value = match value.sort() {
                Sort::Vector(length) => {
                    let parts = (0..length).map(|place| said(&value.component(place)?));
                    Value::vector(parts.collect::<Option<Vec<_>>>()?).ok()?
                }
                _ => said(value)?,
            };
            renamed.insert(name.clone(), value);
        }
        test.raw.substitute(&renamed).ok()
    }
}

fn first_held(entries: &[Value], varies: impl Fn(&Value) -> bool) -> Vec<Held> {
    let mut classes: BTreeMap<&Value, usize> = BTreeMap::new();
    entries
        .iter()
        .map(|entry| {
            if !varies(entry) {
                return Held::Constant(entry.clone());
            }
            let next = classes.len();
            Held::Class(*classes.entry(entry).or_insert(next))
        })
        .collect()
}

/// The components of `r` are `rx`, `ry`, `rz`; of longer vectors `r1`, `r2`, ….
fn component_name(whole: &Name, place: usize, length: usize) -> Name {
    match ["x", "y", "z"].get(place).filter(|_| length <= 3) {
        Some(letter) => Name::new(&format!("{whole}{letter}")),
        None => Name::new(&format!("{whole}{}", place + 1)),
    }
}

/// Variables are called after the first place they stand in, with a number where that is taken.
fn name_variables(spot: &mut Spot, reserved: &BTreeSet<Name>) {
    let mut names: Vec<Name> = Vec::new();
    for (held, hint) in spot.held.iter().zip(&spot.hints) {
        let Held::Class(class) = held else { continue };
        if *class != names.len() {
            continue;
        }
        let mut name = hint.clone();
        let mut number = 1usize;
        while reserved.contains(&name) || names.contains(&name) {
            number += 1;
            name = Name::new(&format!("{hint}{number}"));
        }
        names.push(name);
    }
    spot.variables = names;
}

fn pass(run: &Run, time: &Value) -> Result<Run, Failure> {
    let mut less = |slot: Slot<'_>, value: &Value| match slot {
        Slot::Delay => value.sub(time),
        Slot::Name(_) => Ok(value.clone()),
    };
    map_values(run, &mut less).map_err(|error| Failure::NoPeriod { reason: error.0 })
}

fn failure_of(halt: Halt) -> Failure {
    match halt {
        Halt::Failed(failure) => *failure,
        Halt::Split(question) => Failure::NoPeriod { reason: format!("it must be known whether {}", question.test) },
    }
}
