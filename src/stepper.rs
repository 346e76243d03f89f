//! Running a closed term by hand: numbered moves, time as a move, undo and redo, and traces that replay.

mod route;

use std::fmt;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::lower::Environment;
use crate::model::{Action, Event, Meaningless, Model, Move, Patience, State};
use crate::parser::parse_value;
use crate::term::Term;
use crate::value::{Sort, Value};

pub use route::{Apart, Route};

/// One step that was taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The move at this place of the list, from 0, with the value that was read or drawn where it needs one.
    Take(usize, Option<Value>),
    /// This much time.
    Wait(BigRational),
}

/// As it is typed: `1`, `2 = 5/2`, `wait 1/2`.
impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Choice::Take(number, None) => write!(f, "{}", number + 1),
            Choice::Take(number, Some(value)) => write!(f, "{} = {value}", number + 1),
            Choice::Wait(time) => write!(f, "wait {time}"),
        }
    }
}

/// A step that was taken, with what came of it.
#[derive(Clone, Debug)]
pub struct Taken {
    /// The step.
    pub choice: Choice,
    /// What it did, in words: `read 5 from c`.
    pub did: String,
    /// The state before it.
    pub before: State,
    /// What was decided on the way to the state after it.
    pub events: Vec<Event>,
}

/// A run in progress.
#[derive(Clone, Debug)]
pub struct Stepper {
    definitions: Definitions,
    initial: State,
    first: Vec<Event>,
    state: State,
    history: Vec<Taken>,
    redo: Vec<Choice>,
}

/// Why a saved trace could not be taken to its end. The run stays before the line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LoadError {
    /// This line, from 1, is no step.
    Unreadable(usize, String),
    /// The step of this line, from 1, is not possible, for this reason.
    Impossible(usize, String),
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LoadError::Unreadable(line, text) => write!(f, "line {line}: `{text}` is no step"),
            LoadError::Impossible(line, why) => write!(f, "line {line}: {why}"),
        }
    }
}

impl Stepper {
    /// At the start of a term.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn new(term: &Term, definitions: &Definitions) -> Result<Stepper, Meaningless> {
        let model = Model::recording(definitions);
        let state = model.state(term)?;
        let (first, definitions) = (model.events(), definitions.clone());
        Ok(Stepper { definitions, initial: state.clone(), first, state, history: Vec::new(), redo: Vec::new() })
    }

    /// Where the run is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// What the run's calls refer to.
    pub fn definitions(&self) -> &Definitions {
        &self.definitions
    }

    /// What was decided on the way to the start.
    pub fn first_events(&self) -> &[Event] {
        &self.first
    }

    /// The moves from here; the first is number 0.
    ///
    /// # Errors
    /// [`Meaningless`] where a draw has no meaning.
    pub fn moves(&self) -> Result<Vec<Move>, Meaningless> {
        self.state.moves()
    }

    /// The state after a move that needs no value.
    ///
    /// # Errors
    /// [`Meaningless`] where what follows has no meaning.
    pub fn after(&self, step: &Move) -> Result<State, Meaningless> {
        Model::new(&self.definitions).state(&step.next)
    }

    /// The state after this much time; none if that much cannot pass.
    ///
    /// # Errors
    /// [`Meaningless`] where what follows has no meaning.
    pub fn after_time(&self, time: &BigRational) -> Result<Option<State>, Meaningless> {
        Model::new(&self.definitions).wait_state(&self.state, time)
    }

    /// How long time may pass from here before something changes by itself.
    ///
    /// # Errors
    /// [`Meaningless`] where a draw has no meaning.
    pub fn patience(&self) -> Result<Patience, Meaningless> {
        Ok(self.state.patience(&self.state.moves()?))
    }

    /// The steps taken so far.
    pub fn trace(&self) -> &[Taken] {
        &self.history
    }

    /// The time that has passed since the start.
    pub fn time(&self) -> BigRational {
        let passed = self.history.iter().map(|taken| match &taken.choice {
            Choice::Wait(time) => time.clone(),
            Choice::Take(..) => BigRational::zero(),
        });
        passed.sum()
    }

    /// Takes a step, and forgets what was undone.
    ///
    /// # Errors
    /// [`Meaningless`], with the reason, where there is no such step; the run stays where it is.
    pub fn step(&mut self, choice: Choice) -> Result<(), Meaningless> {
        self.advance(choice)?;
        self.redo.clear();
        Ok(())
    }

    fn advance(&mut self, choice: Choice) -> Result<(), Meaningless> {
        let model = Model::recording(&self.definitions);
        let (next, did) = match &choice {
            Choice::Take(number, value) => {
                let moves = self.state.moves()?;
                let Some(step) = moves.get(*number) else {
                    return Meaningless::because(format!("there is no move {}, there are {}", number + 1, moves.len()));
                };
                let next = match value {
                    Some(value) if step.needs_value() => step.with(plain(value)?),
                    None if step.needs_value() => {
                        return Meaningless::because(format!("move {} needs a value", number + 1));
                    }
                    Some(_) => return Meaningless::because(format!("move {} takes no value", number + 1)),
                    None => step.next.clone(),
                };
                (model.state(&next)?, did(&step.action, value.as_ref()))
            }
            Choice::Wait(time) if *time <= BigRational::zero() => {
                return Meaningless::because("time passes forwards only");
            }
            Choice::Wait(time) => match model.wait_state(&self.state, time)? {
                Some(state) => (state, format!("wait {time}")),
                None => return Meaningless::because(format!("time {time} cannot pass here")),
            },
        };
        let before = std::mem::replace(&mut self.state, next);
        self.history.push(Taken { choice, did, before, events: model.events() });
        Ok(())
    }

    /// Takes back the last step; false at the start.
    pub fn undo(&mut self) -> bool {
        match self.history.pop() {
            Some(taken) => {
                self.redo.push(taken.choice);
                self.state = taken.before;
                true
            }
            None => false,
        }
    }

    /// Takes again the step that was taken back last; false if there is none.
    ///
    /// # Errors
    /// [`Meaningless`] never, unless the model contradicts itself.
    pub fn redo(&mut self) -> Result<bool, Meaningless> {
        match self.redo.pop() {
            Some(choice) => self.advance(choice).map(|()| true),
            None => Ok(false),
        }
    }

    /// Back to the start; every step can be redone.
    pub fn reset(&mut self) {
        while self.undo() {}
        self.state = self.initial.clone();
    }

    /// The steps as text, one a line, the first move being 1: `1: write 0 to c`, `2 = 5/2: read 5/2 from c`, `wait 1/2`.
    pub fn save(&self) -> String {
        let line = |taken: &Taken| match &taken.choice {
            Choice::Take(..) => format!("{} : {}\n", taken.choice, taken.did),
            Choice::Wait(_) => format!("{}\n", taken.choice),
        };
        self.history.iter().map(line).collect()
    }

    /// Takes the steps of a saved text from the start. Where a line says what the step does, it must do that.
    ///
    /// # Errors
    /// Where a step is not readable or not possible; the run stays before it.
    pub fn load(&mut self, text: &str) -> Result<(), LoadError> {
        self.reset();
        self.redo.clear();
        for (number, line) in text.lines().enumerate() {
            let number = number + 1;
            let line = line.trim();
            if line.is_empty() || line.starts_with("//") {
                continue;
            }
            let Some((choice, said)) = read(line) else {
                return Err(LoadError::Unreadable(number, line.chars().take(80).collect()));
            };
            self.step(choice).map_err(|error| LoadError::Impossible(number, error.why))?;
            let done = self.history.last().map(|taken| taken.did.clone()).unwrap_or_default();
            if let Some(said) = said
                && said != done
            {
                self.undo();
                self.redo.clear();
                return Err(LoadError::Impossible(number, format!("the trace says `{said}`, but this is `{done}`")));
            }
        }
        Ok(())
    }
}

/// A value that can be read or drawn: without names, and no distribution.
fn plain(value: &Value) -> Result<&Value, Meaningless> {
    if value.variables().is_empty() && value.sort() != Sort::Distribution {
        return Ok(value);
    }
    Meaningless::because(format!("`{value}` is not a number or a vector of numbers"))
}

/// What a step does, in words.
pub fn did(action: &Action, value: Option<&Value>) -> String {
    let list = |values: &[Value]| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    match (action, value) {
        (Action::In(port), Some(value)) => format!("read {value} from {port}"),
        (Action::In(port), None) => format!("read from {port}"),
        (Action::Out(port, value), _) => format!("write {value} to {port}"),
        (Action::Tau(port, value), _) => format!("pass {value} over {port}"),
        (Action::Draw(from, Some((values, chance))), _) => {
            format!("draw {} from {} (chance {chance})", list(values), list(from))
        }
        (Action::Draw(from, None), Some(value)) => format!("draw {value} from {}", list(from)),
        (Action::Draw(from, None), None) => format!("draw from {}", list(from)),
    }
}

/// A step as it is typed, or as a trace holds it.
pub fn choice_of(text: &str) -> Option<Choice> {
    read(text).map(|(choice, _)| choice)
}

/// One line of a saved trace: the step, and what it is said to do.
fn read(line: &str) -> Option<(Choice, Option<String>)> {
    if let Some(time) = line.strip_prefix("wait ") {
        return Some((Choice::Wait(rational(time)?), None));
    }
    let (choice, said) = match line.split_once(" : ") {
        Some((choice, said)) => (choice, Some(said.trim().to_string())),
        None => (line, None),
    };
    let (number, value) = match choice.split_once('=') {
        Some((number, value)) => (number, Some(value_of(value)?)),
        None => (choice, None),
    };
    let number: usize = number.trim().parse().ok()?;
    Some((Choice::Take(number.checked_sub(1)?, value), said))
}

/// A rational number as it is written in the language; none if it is no such number.
pub fn rational(text: &str) -> Option<BigRational> {
    value_of(text)?.as_rational()
}

/// A value without names as it is written in the language.
pub fn value_of(text: &str) -> Option<Value> {
    let value = Environment::new().value(&parse_value(text.trim()).ok()?).ok()?;
    value.variables().is_empty().then_some(value)
}
