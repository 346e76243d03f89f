//! The run of a closed system with numbers, followed exactly in the executable meaning: when what is shown.

pub mod trail;
pub mod turns;

use std::collections::{BTreeMap, BTreeSet, HashMap};

use num_rational::BigRational;
use num_traits::Zero;

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::model::{Action, Model, Patience, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Bits of a number at which a run that only converges is given up.
const MOST_BITS: u64 = 4_000;
/// States within one instant.
const MOST_INSTANT: usize = 2_000;

/// A stretch of time in which nothing changes.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// When it begins.
    pub start: Value,
    /// How long it lasts; none: for ever.
    pub duration: Option<Value>,
    /// What is shown in it.
    pub shown: Vec<Term>,
    /// The communications right before it, in order.
    pub before: Vec<(Name, Value)>,
    /// The number of the phase that it belongs to, where that is known.
    pub phase: Option<usize>,
}

/// How a run goes on after its last stretch.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As from the stretch of this place, again and again.
    Repeats(usize),
    /// The last stretch lasts for ever.
    Still,
    /// The system ends.
    Ended,
    /// It was not followed further.
    Unknown(String),
}

/// A run.
#[derive(Clone, Debug)]
pub struct Timeline {
    /// Its stretches, in order.
    pub stretches: Vec<Stretch>,
    /// How it goes on.
    pub ending: Ending,
    /// The values at which comparisons are decided, where times and places are formulas.
    pub at: BTreeMap<Name, Value>,
    /// What is known of symbols in it.
    pub known: Assumptions,
}

impl Timeline {
    /// Whether all that ever happens is known.
    pub fn closed(&self) -> bool {
        !matches!(self.ending, Ending::Unknown(_))
    }

    /// The time up to which it is known; none: for ever.
    pub fn known_until(&self) -> Option<Value> {
        if self.closed() {
            return None;
        }
        let last = self.stretches.last();
        Some(last.map_or_else(Value::zero, |last| end_of(last).unwrap_or_else(Value::zero)))
    }

    /// How two values compare at the values at hand.
    pub fn decide(&self, relation: Relation, left: &Value, right: &Value) -> Option<bool> {
        if let (Some(left), Some(right)) = (left.as_rational(), right.as_rational()) {
            return Some(relation.holds(left.cmp(&right)));
        }
        let (left, right) = (left.substitute(&self.at).ok()?, right.substitute(&self.at).ok()?);
        self.known.decide(relation, &left, &right)
    }

    /// The stretches, each with the time at which it begins, `rounds` times round where it repeats.
    pub fn unrolled(&self, rounds: usize) -> Vec<(usize, Value)> {
        let mut all: Vec<(usize, Value)> =
            self.stretches.iter().enumerate().map(|(place, stretch)| (place, stretch.start.clone())).collect();
        let Ending::Repeats(from) = self.ending else { return all };
        let (Some(first), Some(end)) = (self.stretches.get(from), self.stretches.last().and_then(end_of)) else {
            return all;
        };
        let Ok(period) = end.sub(&first.start) else { return all };
        let mut shift = period.clone();
        for _ in 0..rounds {
            for (place, stretch) in self.stretches.iter().enumerate().skip(from) {
                let Ok(start) = stretch.start.add(&shift) else { return all };
                all.push((place, start));
            }
            let Ok(next) = shift.add(&period) else { return all };
            shift = next;
        }
        all
    }
}

/// Why a run goes no further, in the words of one who asks about a mission.
fn told(why: String) -> String {
    if why == "division by zero" {
        return "what comes then divides by zero (as `unit` of a vector of length 0 does)".to_string();
    }
    why
}

/// When a stretch ends.
pub fn end_of(stretch: &Stretch) -> Option<Value> {
    stretch.start.add(stretch.duration.as_ref()?).ok()
}

/// Follows a run, a bit further each time it is asked to.
pub struct Follower<'a> {
    model: Model<'a>,
    state: Option<State>,
    places: HashMap<State, usize>,
    time: BigRational,
    run: Timeline,
    over: bool,
}

impl<'a> Follower<'a> {
    /// At the start of a system.
    pub fn new(system: &Term, definitions: &'a Definitions) -> Follower<'a> {
        let model = Model::new(definitions);
        let ending = Ending::Unknown("it was not followed".to_string());
        let known = Assumptions::default();
        let mut run = Timeline { stretches: Vec::new(), ending, at: BTreeMap::new(), known };
        let state = match model.state(system) {
            Ok(state) => Some(state),
            Err(error) => {
                run.ending = Ending::Unknown(told(error.why));
                None
            }
        };
        let over = state.is_none();
        Follower { model, state, places: HashMap::new(), time: BigRational::zero(), run, over }
    }

    /// The run as far as it was followed.
    pub fn run(&self) -> &Timeline {
        &self.run
    }

    /// Whether following it further gives no more.
    pub fn over(&self) -> bool {
        self.over
    }

    /// Follows it up to so many stretches in all.
    pub fn follow(&mut self, stretches: usize, interrupted: &dyn Fn() -> bool) {
        while !self.over && self.run.stretches.len() < stretches {
            if self.run.stretches.len() % 64 == 63 && interrupted() {
                self.finish(Ending::Unknown("interrupted".to_string()));
                return;
            }
            if let Err(ending) = self.step() {
                self.finish(ending);
                return;
            }
        }
        if !self.over {
            let text = format!("after {} stretches of time nothing has repeated", self.run.stretches.len());
            self.run.ending = Ending::Unknown(text);
        }
    }

    fn finish(&mut self, ending: Ending) {
        self.run.ending = ending;
        self.over = true;
    }

    /// One stretch further, or how it ends.
    fn step(&mut self) -> Result<(), Ending> {
        let unknown = |why: &str| Ending::Unknown(why.to_string());
        let state = self.state.take().ok_or_else(|| unknown("it is over"))?;
        let (state, before) = self.settle(state)?;
        if !matches!(state, State::Running(_)) {
            return Err(Ending::Ended);
        }
        if let Some(place) = self.places.get(&state) {
            return Err(Ending::Repeats(*place));
        }
        if is_long(&state) {
            return Err(unknown("its numbers grow longer and longer, and it is not followed any further"));
        }
        let moves = state.moves().map_err(|error| Ending::Unknown(told(error.why)))?;
        let patience = state.patience(&moves);
        let duration = match &patience {
            Patience::Until(time) => Some(time.clone()),
            _ => None,
        };
        let start = Value::rational(self.time.clone());
        let shown = shown(&state);
        let phase = None;
        self.places.insert(state.clone(), self.run.stretches.len());
        let lasts = duration.clone().map(Value::rational);
        self.run.stretches.push(Stretch { start, duration: lasts, shown, before, phase });
        let Some(time) = duration else { return Err(Ending::Still) };
        let next = self.model.wait_state(&state, &time).map_err(|error| Ending::Unknown(told(error.why)))?;
        self.state = Some(next.ok_or_else(|| unknown("time stops"))?);
        self.time += time;
        Ok(())
    }

    /// Makes all communications that are due; whatever their order, they must lead to one state.
    fn settle(&self, from: State) -> Result<(State, Vec<(Name, Value)>), Ending> {
        let unknown = |why: &str| Ending::Unknown(why.to_string());
        let mut seen: BTreeSet<State> = BTreeSet::from([from.clone()]);
        let mut open = vec![(from, Vec::new())];
        let mut found: Option<(State, Vec<(Name, Value)>)> = None;
        while let Some((state, passed)) = open.pop() {
            let moves = state.moves().map_err(|error| Ending::Unknown(told(error.why)))?;
            let mut still = true;
            for step in &moves {
                match &step.action {
                    Action::Draw(..) => return Err(unknown("it draws from a distribution: ask for a probability")),
                    Action::Tau(port, value) => {
                        still = false;
                        let next = self.model.state(&step.next).map_err(|error| Ending::Unknown(told(error.why)))?;
                        if seen.len() > MOST_INSTANT {
                            return Err(unknown("too much happens in one instant: time may stop"));
                        }
                        if seen.insert(next.clone()) {
                            let mut passed: Vec<(Name, Value)> = passed.clone();
                            passed.push((port.clone(), value.clone()));
                            open.push((next, passed));
                        }
                    }
                    _ => {}
                }
            }
            match &found {
                _ if !still => {}
                None => found = Some((state, passed)),
                Some((other, _)) if *other == state => {}
                Some(_) => {
                    return Err(unknown("it may matter which of several communications in one instant comes first"));
                }
            }
        }
        found.ok_or_else(|| unknown("time stops: internal communications go on for ever"))
    }
}

fn shown(state: &State) -> Vec<Term> {
    let observations = state.observations().into_iter();
    observations.map(|(name, values)| Term::new(Node::Observe(name, values))).collect()
}

fn is_long(state: &State) -> bool {
    state.observations().iter().any(|(_, values)| values.iter().any(|value| value.bits() > MOST_BITS))
}
