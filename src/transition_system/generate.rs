//! Systems from behaviours, breadth first, up to a bound; closed processes are behaviours.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt;
use std::hash::Hash;

use num_rational::BigRational;
use num_traits::Zero;

use super::draw::Draws;
use super::{Bounds, Builder, Cut, Ending, Inputs, Label, Mark, TransitionSystem};
use crate::bisimulation::{common_divisor, grain};
use crate::definition::Definitions;
use crate::model::{Action, Meaningless, Model, Move, Outcome, Patience, State, mentions_drawn};
use crate::term::{Node, Term};
use crate::value::Value;

/// How often a pair of processes is generated anew with finer steps of time.
const MOST_GRAINS: usize = 40;

/// Why a system could not be made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// A state that is reached has no meaning.
    Meaningless(Meaningless),
    /// A delay ends between two ticks: the ticks must divide this too.
    Grain(BigRational),
    /// A communication is offered while a delay runs: it may be taken up between two ticks.
    Coarse,
    /// What it does depends on a value drawn from a continuous distribution.
    Draws,
    /// What it does depends on whether a value of this distribution is greater than this.
    Cut(Box<(Value, BigRational)>),
    /// This distribution's value, times the first plus the second, is seen.
    Probe(Box<(Value, BigRational, BigRational)>),
}

impl From<Meaningless> for Trouble {
    fn from(why: Meaningless) -> Trouble {
        Trouble::Meaningless(why)
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Trouble::Meaningless(why) => why.fmt(f),
            Trouble::Grain(_) | Trouble::Coarse => f.write_str("its delays have no common measure"),
            Trouble::Draws | Trouble::Cut(..) | Trouble::Probe(..) => {
                f.write_str("it depends on a value that is drawn from a continuous distribution")
            }
        }
    }
}

/// Something with states, steps, and what can be seen of a state.
pub trait Behaviour {
    /// Its states.
    type State: Clone + Eq + Hash;

    /// The state in which it begins.
    ///
    /// # Errors
    /// [`Trouble`] where it has no meaning.
    fn start(&self) -> Result<Self::State, Trouble>;

    /// What can be seen of a state.
    ///
    /// # Errors
    /// [`Trouble`] where it has no meaning.
    fn mark(&self, state: &Self::State) -> Result<Mark, Trouble>;

    /// All steps of a state.
    ///
    /// # Errors
    /// [`Trouble`] where one leads to a state without a meaning.
    fn steps(&self, state: &Self::State) -> Result<Vec<(Label, Self::State)>, Trouble>;

    /// The bytes that a state takes besides those before it, estimated from above; `known` holds where their parts lie.
    fn weight(&self, state: &Self::State, known: &mut HashSet<usize>) -> usize;

    /// How far the chances of one instant, all together, may be from those that are said.
    fn slack(&self) -> BigRational {
        BigRational::zero()
    }
}

impl Behaviour for TransitionSystem {
    type State = u32;

    fn start(&self) -> Result<u32, Trouble> {
        Ok(self.initial())
    }

    fn mark(&self, state: &u32) -> Result<Mark, Trouble> {
        Ok(TransitionSystem::mark(self, *state).clone())
    }

    fn steps(&self, state: &u32) -> Result<Vec<(Label, u32)>, Trouble> {
        Ok(TransitionSystem::steps(self, *state).iter().map(|(label, to)| (self.label(*label).clone(), *to)).collect())
    }

    fn weight(&self, _: &u32, _: &mut HashSet<usize>) -> usize {
        4
    }

    fn slack(&self) -> BigRational {
        self.slack.clone()
    }
}

/// How time becomes steps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Clock {
    /// From one event to the next: for people. A process for which nothing is to come has no step of time.
    Events,
    /// In ticks of one length, and without end where nothing is to come: for comparing, since every process then
    /// counts the same time in the same steps.
    Ticks {
        /// The length of a tick.
        tick: BigRational,
        /// Whether two ticks lie between any two events, so that something can happen in between.
        fine: bool,
    },
}

/// A closed process as a behaviour.
pub struct Process<'a> {
    model: Model<'a>,
    term: Term,
    clock: Clock,
    inputs: Inputs,
    reads: Cell<bool>,
    draws: Draws,
    /// The state whose moves were asked for last, with how long it waits.
    last: RefCell<Option<(State, Patience)>>,
}

impl<'a> Process<'a> {
    /// This term under these definitions; what it reads from outside is one of the inputs.
    pub fn new(term: Term, definitions: &'a Definitions, clock: Clock, inputs: Inputs) -> Process<'a> {
        let draws = Draws::new(inputs.cuts.clone());
        Process {
            model: Model::within(definitions, draws.cells()),
            term,
            clock,
            inputs,
            reads: Cell::new(false),
            draws,
            last: RefCell::new(None),
        }
    }

    /// Whether a state was met that reads from outside.
    pub fn reads(&self) -> bool {
        self.reads.get()
    }

    /// Whether its ticks leave a moment between any two events, as is needed where it offers something meanwhile.
    pub fn is_fine(&self) -> bool {
        matches!(self.clock, Clock::Ticks { fine: true, .. })
    }

    /// What it draws from continuous distributions, and whether that was met.
    pub(crate) fn draws(&self) -> &Draws {
        &self.draws
    }

    /// The state that a term is in; in ticks, a draw with one outcome is that outcome.
    fn arrive(&self, from: &State, term: &Term) -> Result<State, Trouble> {
        let state = self.draws.sure(from, self.model.state(term))?;
        if self.clock == Clock::Events { Ok(state) } else { self.draws.arrive(&self.model, state) }
    }

    /// The length of its ticks.
    pub fn tick(&self) -> Option<&BigRational> {
        match &self.clock {
            Clock::Ticks { tick, .. } => Some(tick),
            Clock::Events => None,
        }
    }

    /// What it may read.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    fn time(&self, state: &State, moves: &[Move], offers: bool, all: &mut Vec<(Label, State)>) -> Result<(), Trouble> {
        let patience = state.patience(moves);
        *self.last.borrow_mut() = Some((state.clone(), patience.clone()));
        match (&self.clock, patience) {
            (_, Patience::None) | (Clock::Events, Patience::Unbounded) => {}
            (Clock::Events, Patience::Until(time)) => {
                let after = self.draws.sure(state, self.model.pass(state, &time))?;
                all.push((Label::Wait(time), after));
            }
            (Clock::Ticks { tick, .. }, Patience::Unbounded) => all.push((Label::Wait(tick.clone()), state.clone())),
            (Clock::Ticks { tick, fine }, Patience::Until(time)) => {
                if offers && !fine {
                    return Err(Trouble::Coarse);
                }
                if !(&time / tick).is_integer() {
                    return Err(Trouble::Grain(common_divisor(tick, &time)));
                }
                let after = self.draws.sure(state, self.model.pass(state, tick))?;
                all.push((Label::Wait(tick.clone()), self.draws.arrive(&self.model, after)?));
            }
        }
        Ok(())
    }
}

impl Behaviour for Process<'_> {
    type State = State;

    fn start(&self) -> Result<State, Trouble> {
        let state = self.model.state(&self.term)?;
        if self.clock == Clock::Events { Ok(state) } else { self.draws.arrive(&self.model, state) }
    }

    fn mark(&self, state: &State) -> Result<Mark, Trouble> {
        let mut shown = BTreeSet::new();
        for (name, values) in state.observations() {
            let plain = !values.iter().any(mentions_drawn);
            shown.insert(if plain || self.inputs.cuts.is_none() {
                Term::new(Node::Observe(name, values)).to_string()
            } else {
                let views: Vec<String> = values.iter().map(|value| self.draws.view(value)).collect::<Result<_, _>>()?;
                format!("{name}_{{{}}}", views.join(", "))
            });
        }
        let ending = match state.outcome() {
            Outcome::Running => Ending::Running,
            Outcome::Abort => Ending::Aborted,
            Outcome::Stop(results) => {
                let told = |(name, value)| Ok(format!("{name} = {}", self.draws.view(value)?));
                let results: Vec<String> = results.iter().map(told).collect::<Result<_, Trouble>>()?;
                Ending::Stopped(results.join(", "))
            }
        };
        let waits = match self.clock {
            Clock::Events => match &*self.last.borrow() {
                Some((last, patience)) if last == state => *patience != Patience::None,
                _ => state.patience(&state.moves()?) != Patience::None,
            },
            Clock::Ticks { .. } => ending == Ending::Running,
        };
        Ok(Mark { ending, shown, waits })
    }

    fn steps(&self, state: &State) -> Result<Vec<(Label, State)>, Trouble> {
        let moves = self.draws.look(state)?;
        let mut all = Vec::new();
        let mut offers = false;
        if self.clock != Clock::Events && moves.first().is_some_and(|step| self.draws.is_made(step)) {
            let outcomes = self.draws.outcomes(&self.model, state)?;
            return Ok(outcomes.into_iter().map(|(state, chance)| (Label::Chance(chance), state)).collect());
        }
        for step in &moves {
            let label = match &step.action {
                Action::Tau(..) => Label::Tau,
                Action::Out(port, value) => {
                    offers = true;
                    Label::Act(format!("{port}!{}", self.draws.view(value)?))
                }
                Action::In(port) => {
                    offers = true;
                    self.reads.set(true);
                    for value in &self.inputs.values {
                        all.push((Label::Act(format!("{port}?{value}")), self.arrive(state, &step.with(value))?));
                    }
                    continue;
                }
                Action::Draw(_, Some((values, chance))) => {
                    let values: Vec<String> = values.iter().map(ToString::to_string).collect();
                    Label::Act(format!("draw {} ({chance})", values.join(", ")))
                }
                Action::Draw(_, None) => {
                    let (value, after) = self.draws.symbolic(&self.model, state, step)?;
                    all.push((Label::Act(value.to_string()), self.arrive(state, &after.term())?));
                    continue;
                }
            };
            all.push((label, self.arrive(state, &step.next)?));
        }
        self.time(state, &moves, offers, &mut all)?;
        Ok(all)
    }

    fn weight(&self, state: &State, known: &mut HashSet<usize>) -> usize {
        let mut bytes = STATE_BYTES;
        let mut open = Vec::new();
        match state {
            State::Running(term) => open.push(term),
            State::Stopped(results) => bytes = bytes.saturating_add(results.len().saturating_mul(VALUE_BYTES)),
            State::Aborted => {}
        }
        while let Some(term) = open.pop() {
            if !known.insert(std::ptr::from_ref(term.node()).addr()) {
                continue;
            }
            let values = term.values().len().saturating_mul(VALUE_BYTES);
            bytes = bytes.saturating_add(NODE_BYTES).saturating_add(values);
            open.extend(term.children());
        }
        bytes
    }

    fn slack(&self) -> BigRational {
        self.draws.slack()
    }
}

// By the peak of the release build on up to 40,000 states of counters, of clocks and of timed loops beside each other.
/// The bytes that a state takes in the tables, without its term.
const STATE_BYTES: usize = 200;
/// The bytes that a part of a term takes with its place among its neighbours, without its values.
const NODE_BYTES: usize = 180;
/// The bytes that a value takes.
const VALUE_BYTES: usize = 450;
/// The bytes that a transition takes.
const TRANSITION_BYTES: usize = 20;
/// The bytes that a label, or what is seen of a state, takes where there was none like it.
const TEXT_BYTES: usize = 400;

/// A system with the states from which it was made.
#[derive(Clone, Debug)]
pub struct Generated<S> {
    /// The system.
    pub system: TransitionSystem,
    /// What each of its states is.
    pub states: Vec<S>,
}

/// The bytes that transitions, labels and marks take.
fn taken(builder: &Builder) -> usize {
    let texts = builder.texts().saturating_mul(TEXT_BYTES);
    texts.saturating_add(builder.transitions().saturating_mul(TRANSITION_BYTES))
}

/// Explores a behaviour breadth first, up to the bounds or until `stop` says so.
///
/// # Errors
/// [`Trouble`] where a state that is reached has no meaning.
pub fn generate<B: Behaviour>(
    behaviour: &B,
    bounds: &Bounds,
    stop: &dyn Fn() -> bool,
) -> Result<Generated<B::State>, Trouble> {
    let most = bounds.states.clamp(1, u32::MAX as usize - 1);
    let mut builder = Builder::new();
    let start = behaviour.start()?;
    builder.state(Mark::plain());
    let mut known = HashSet::new();
    let mut bytes = behaviour.weight(&start, &mut known);
    let mut states = vec![start.clone()];
    let mut places: HashMap<B::State, u32> = HashMap::from([(start, 0)]);
    let (mut next, mut cut) = (0, None);
    while next < states.len() && cut.is_none() {
        if next % 256 == 0 && stop() {
            cut = Some(Cut::Interrupted(states.len()));
            break;
        }
        let state = states[next].clone();
        let mut found = Vec::new();
        for (label, target) in behaviour.steps(&state)? {
            let to = match places.get(&target) {
                Some(place) => *place,
                None if states.len() >= most => {
                    cut = Some(Cut::States(bounds.states));
                    break;
                }
                None if bytes.saturating_add(taken(&builder)) >= bounds.bytes => {
                    cut = Some(Cut::Memory(bounds.bytes));
                    break;
                }
                None => {
                    bytes = bytes.saturating_add(behaviour.weight(&target, &mut known));
                    let place = builder.state(Mark::plain());
                    places.insert(target.clone(), place);
                    states.push(target);
                    place
                }
            };
            found.push((label, to));
        }
        // Right behind its steps, when its moves are at hand.
        builder.look(next as u32, behaviour.mark(&state)?);
        for (label, to) in found {
            let label = builder.label(label);
            builder.transition(next as u32, label, to);
        }
        if cut.is_none() {
            next += 1;
        }
    }
    for (state, term) in states.iter().enumerate().skip(next) {
        builder.look(state as u32, behaviour.mark(term)?);
        builder.leave_open(state as u32);
    }
    let mut system = builder.finish(0, cut);
    system.slack = behaviour.slack();
    Ok(Generated { system, states })
}

/// Both terms with the same ticks, made finer as far as needed, and halved so often more; the processes say which ticks
/// those are.
///
/// # Errors
/// [`Trouble`] where a state that is reached has no meaning, or the delays have no common measure.
pub fn generate_pair<'a>(
    terms: [&Term; 2],
    definitions: &'a Definitions,
    inputs: &Inputs,
    bounds: &Bounds,
    finer: u32,
    stop: &dyn Fn() -> bool,
) -> Result<([Process<'a>; 2], [Generated<State>; 2]), Trouble> {
    let half = grain(terms, definitions);
    let mut fine = finer > 0;
    let mut tick = if fine { half / BigRational::from_integer(2.into()).pow(finer as i32) } else { &half + &half };
    let mut last = Trouble::Coarse;
    for _ in 0..MOST_GRAINS {
        let clock = Clock::Ticks { tick: tick.clone(), fine };
        let [left, right] = terms.map(|term| Process::new(term.clone(), definitions, clock.clone(), inputs.clone()));
        let made = generate(&left, bounds, stop).and_then(|one| Ok((one, generate(&right, bounds, stop)?)));
        match made {
            Ok((one, two)) => return Ok(([left, right], [one, two])),
            Err(Trouble::Coarse) if !fine => {
                fine = true;
                tick /= BigRational::from_integer(2.into());
            }
            Err(Trouble::Grain(finer)) if !finer.is_zero() => {
                last = Trouble::Grain(finer.clone());
                tick = finer;
            }
            Err(other) => return Err(other),
        }
    }
    Err(last)
}
