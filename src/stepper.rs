//! Running a closed term by hand: numbered moves, time as a move, undo and redo, and traces that replay.

use std::fmt::Write as _;

use num_rational::BigRational;
use num_traits::Zero;

use crate::definition::Definitions;
use crate::model::{Meaningless, Model, Move, Patience, State};
use crate::term::Term;
use crate::value::Value;

/// One step that was taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The move of this number, with the value that was read or drawn where it needs one.
    Take(usize, Option<Value>),
    /// This much time.
    Wait(BigRational),
}

/// A run in progress.
#[derive(Clone, Debug)]
pub struct Stepper {
    definitions: Definitions,
    initial: State,
    state: State,
    history: Vec<(Choice, State)>,
    redo: Vec<Choice>,
}

impl Stepper {
    /// At the start of a term.
    ///
    /// # Errors
    /// [`Meaningless`] where the term has no meaning.
    pub fn new(term: &Term, definitions: &Definitions) -> Result<Stepper, Meaningless> {
        let state = Model::new(definitions).state(term)?;
        let definitions = definitions.clone();
        Ok(Stepper { definitions, initial: state.clone(), state, history: Vec::new(), redo: Vec::new() })
    }

    /// Where the run is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The moves from here; the first is number 0.
    ///
    /// # Errors
    /// [`Meaningless`] where a draw has no meaning.
    pub fn moves(&self) -> Result<Vec<Move>, Meaningless> {
        self.state.moves()
    }

    /// How long time may pass from here before something changes by itself.
    ///
    /// # Errors
    /// [`Meaningless`] where a draw has no meaning.
    pub fn patience(&self) -> Result<Patience, Meaningless> {
        Ok(self.state.patience(&self.state.moves()?))
    }

    /// The steps taken so far.
    pub fn trace(&self) -> impl Iterator<Item = &Choice> {
        self.history.iter().map(|(choice, _)| choice)
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
        let model = Model::new(&self.definitions);
        let next = match &choice {
            Choice::Take(number, value) => {
                let moves = self.state.moves()?;
                let Some(step) = moves.get(*number) else {
                    return Meaningless::because(format!("there is no move {number}, there are {}", moves.len()));
                };
                match value {
                    Some(value) if step.needs_value() => model.state(&step.with(value))?,
                    None if step.needs_value() => return Meaningless::because("this move needs a value"),
                    _ => model.state(&step.next)?,
                }
            }
            Choice::Wait(time) if *time <= BigRational::zero() => {
                return Meaningless::because("time passes forwards only");
            }
            Choice::Wait(time) => match model.wait_state(&self.state, time)? {
                Some(state) => state,
                None => return Meaningless::because(format!("time {time} cannot pass here")),
            },
        };
        self.history.push((choice, std::mem::replace(&mut self.state, next)));
        Ok(())
    }

    /// Takes back the last step; false at the start.
    pub fn undo(&mut self) -> bool {
        match self.history.pop() {
            Some((choice, before)) => {
                self.redo.push(choice);
                self.state = before;
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

    /// The trace as text, a step a line: `take 0`, `take 1 = 5/2`, `wait 1/2`.
    pub fn save(&self) -> String {
        let mut text = String::new();
        for choice in self.trace() {
            let _ = match choice {
                Choice::Take(number, None) => writeln!(text, "take {number}"),
                Choice::Take(number, Some(value)) => writeln!(text, "take {number} = {value}"),
                Choice::Wait(time) => writeln!(text, "wait {time}"),
            };
        }
        text
    }

    /// Takes the steps of a saved trace from the start.
    ///
    /// # Errors
    /// [`Meaningless`], with the line, where a step is not readable or not possible; the run stays before it.
    pub fn load(&mut self, text: &str) -> Result<(), Meaningless> {
        self.reset();
        self.redo.clear();
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            let place = |why: String| Meaningless { why: format!("line {}: {why}", number + 1) };
            let choice = read(line).ok_or_else(|| place(format!("`{line}` is no step")))?;
            self.step(choice).map_err(|error| place(error.why))?;
        }
        Ok(())
    }
}

/// One line of a saved trace; values are rational numbers.
fn read(line: &str) -> Option<Choice> {
    let line = line.trim();
    if let Some(time) = line.strip_prefix("wait ") {
        return Some(Choice::Wait(number(time)?));
    }
    let rest = line.strip_prefix("take ")?;
    match rest.split_once('=') {
        Some((place, value)) => {
            let value = Value::rational(number(value)?);
            Some(Choice::Take(place.trim().parse().ok()?, Some(value)))
        }
        None => Some(Choice::Take(rest.trim().parse().ok()?, None)),
    }
}

/// A rational number, if its denominator is not zero.
fn number(text: &str) -> Option<BigRational> {
    text.trim().parse().ok()
}
