//! Stepping by hand, one line typed after the other: moves by number, time, undo, why something is not there, traces.

mod show;
mod start;
mod trace;

use std::path::{Path, PathBuf};

use num_rational::BigRational;

use crate::absence::{Direction, Query, why_not};
use crate::lower::Environment;
use crate::model::Patience;
use crate::name::Name;
use crate::printer::Order;
use crate::script::read_file;
use crate::stepper::{Choice, LoadError, Stepper, rational, value_of};
use crate::term::Term;
use crate::value::Value;

pub use start::{assignments, declarations, only_process};
pub use trace::{Saved, saved};

/// What can be typed.
pub const HELP: &str = "N              take move N
N V            take move N, in which V is read or drawn: `1 5`
1, wait 1, 2   several steps on one line
wait [T]       let time pass: to the next event, or T, as in `wait 3/2`
why not N      why this is not possible; also `why not c?` (read), `c!` (write), `c`, `wait 2`, `stop`, `abort`, `At`
moves          what is possible here
undo  redo     take the last step back; take it again
initial        back to the start; `redo` goes on from there
trace          the steps so far
save FILE      write the steps so far; `pars step --replay FILE` takes them again
load FILE      take the steps of a file from the start
quit           leave
";

/// Where a walk came from, for the traces that it saves.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The prompt.
    Prompt,
    /// This file.
    File(PathBuf),
}

/// What came of a line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Answer {
    /// For the person who typed it.
    pub text: String,
    /// Whether that person wants to leave.
    pub quit: bool,
    /// Whether what was asked for could not be done.
    pub failed: bool,
}

impl Answer {
    fn said(text: impl Into<String>) -> Answer {
        Answer { text: text.into(), ..Answer::default() }
    }

    fn failed(text: impl Into<String>) -> Answer {
        Answer { text: text.into(), failed: true, ..Answer::default() }
    }
}

/// A run in progress, with the person who makes it.
pub struct Walk {
    stepper: Stepper,
    environment: Environment,
    origin: Origin,
    /// As it was typed, without `with`.
    subject: String,
    term: Term,
    values: Vec<(Name, Value, bool)>,
    asked: Option<usize>,
    colour: bool,
    /// The states so far, each with the order in which its parts are written.
    orders: Vec<(Term, Order)>,
}

impl Walk {
    /// What is shown at the start.
    pub fn opening(&mut self) -> String {
        let mut text = String::new();
        for (name, value, chosen) in &self.values {
            let how = if *chosen { " (chosen here; `with` gives another)" } else { "" };
            text.push_str(&format!("{name} = {value}{how}\n"));
        }
        text + &self.show()
    }

    /// Answers one line: an input, or several with commas between them, of which the first that fails is the last.
    pub fn answer(&mut self, line: &str) -> Answer {
        let line = line.trim();
        let parts = inputs(line);
        if parts.len() < 2 || (self.asked.is_some() && value_of(line).is_some()) {
            return self.one(line);
        }
        let mut text = String::new();
        for (place, part) in parts.iter().enumerate() {
            let before = self.stepper.trace().len();
            let answer = self.one(part);
            let moved = self.stepper.trace().len() > before;
            match answer.text.lines().next() {
                Some(did) if moved && place + 1 < parts.len() => text.push_str(&format!("{did}\n")),
                _ => text.push_str(&answer.text),
            }
            if answer.failed || answer.quit {
                let state = if place > 0 && answer.failed { self.show() } else { String::new() };
                return Answer { text: text + &state, ..answer };
            }
        }
        Answer::said(text)
    }

    fn one(&mut self, line: &str) -> Answer {
        let line = line.trim();
        if let Some(number) = self.asked.take()
            && let Some(value) = value_of(line)
        {
            return self.take(number, Some(value));
        }
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match word.trim_start_matches(':') {
            "" | "moves" | "m" => Answer::said(self.show()),
            "help" | "h" | "?" => Answer::said(HELP),
            "quit" | "q" | "exit" => Answer { quit: true, ..Answer::default() },
            "undo" | "u" if self.stepper.undo() => Answer::said(self.show()),
            "undo" | "u" => Answer::failed("this is the start: there is nothing to undo\n"),
            "redo" | "r" => match self.stepper.redo() {
                Ok(true) => Answer::said(self.show()),
                Ok(false) => Answer::failed("nothing was undone\n"),
                Err(error) => Answer::failed(format!("{error}\n")),
            },
            "initial" | "i" => {
                self.stepper.reset();
                Answer::said(self.show())
            }
            "trace" | "t" => Answer::said(self.steps()),
            "wait" | "w" => self.wait(rest),
            "why" => self.why(rest),
            "save" => self.save(rest),
            "load" => self.load(rest),
            _ => self.number(word, rest),
        }
    }

    fn number(&mut self, word: &str, rest: &str) -> Answer {
        let Ok(number) = word.parse::<usize>() else {
            return Answer::failed(format!(
                "`{word}` is neither a move nor a command; `help` lists what can be typed\n"
            ));
        };
        let value = match rest {
            "" => None,
            _ => match value_of(rest.trim_start_matches('=')) {
                Some(value) => Some(value),
                None => {
                    return Answer::failed(format!("`{rest}` is no value: write a number such as 5/2, or (x, y)\n"));
                }
            },
        };
        self.take(number, value)
    }

    fn take(&mut self, number: usize, value: Option<Value>) -> Answer {
        let moves = match self.stepper.moves() {
            Ok(moves) => moves,
            Err(error) => return Answer::failed(format!("{error}\n")),
        };
        let timed = matches!(self.stepper.patience(), Ok(Patience::Until(_)));
        if number == moves.len() + 1 && timed && value.is_none() {
            return self.wait("");
        }
        let Some(step) = number.checked_sub(1).and_then(|place| moves.get(place)) else {
            let lines = why_not(&self.stepper, &Query::Number(number)).unwrap_or_default();
            return Answer::failed(format!("there is no move {number}\n{}", listed(&lines)));
        };
        if step.needs_value() && value.is_none() {
            self.asked = Some(number);
            let what = crate::stepper::did(&step.action, None);
            return Answer::said(format!("{what}: which value?\n"));
        }
        self.step(Choice::Take(number - 1, value))
    }

    fn step(&mut self, choice: Choice) -> Answer {
        match self.stepper.step(choice) {
            Ok(()) => {
                let did = self.stepper.trace().last().map(|taken| taken.did.clone()).unwrap_or_default();
                Answer::said(format!("{did}\n{}", self.show()))
            }
            Err(error) => Answer::failed(format!("{error}\n")),
        }
    }

    fn wait(&mut self, time: &str) -> Answer {
        let patience = self.stepper.patience();
        let time = match (time, patience) {
            ("", Ok(Patience::Until(next))) => next,
            ("", Ok(Patience::Unbounded)) => {
                return Answer::failed("nothing changes by itself here, however long you wait; `wait 1` lets 1 pass\n");
            }
            ("", Ok(Patience::None)) => return self.refused(&Query::Time(None)),
            ("", Err(error)) => return Answer::failed(format!("{error}\n")),
            _ => match rational(time) {
                Some(time) => time,
                None => return Answer::failed(format!("`{time}` is no time: write a number such as 3/2\n")),
            },
        };
        match self.stepper.after_time(&time) {
            Ok(Some(_)) => self.step(Choice::Wait(time)),
            Ok(None) => self.refused(&Query::Time(Some(time))),
            Err(error) => Answer::failed(format!("{error}\n")),
        }
    }

    fn refused(&self, query: &Query) -> Answer {
        match why_not(&self.stepper, query) {
            Ok(lines) => Answer::failed(listed(&lines)),
            Err(error) => Answer::failed(format!("{error}\n")),
        }
    }

    fn why(&self, rest: &str) -> Answer {
        let rest = rest.strip_prefix("not").unwrap_or(rest).trim();
        let Some(query) = query(rest) else {
            let text =
                "write `why not 2`, `why not c?`, `why not c!`, `why not wait 2`, `why not stop` or `why not At`\n";
            return Answer::failed(text);
        };
        match why_not(&self.stepper, &query) {
            Ok(lines) => Answer::said(listed(&lines)),
            Err(error) => Answer::failed(format!("{error}\n")),
        }
    }

    fn save(&self, path: &str) -> Answer {
        if path.is_empty() {
            return Answer::failed("write `save FILE`\n");
        }
        let text = self.trace_file(Path::new(path));
        match std::fs::write(path, text) {
            Ok(()) => Answer::said(format!("{} steps written to `{path}`\n", self.stepper.trace().len())),
            Err(error) => Answer::failed(format!("`{path}` cannot be written: {error}\n")),
        }
    }

    fn load(&mut self, path: &str) -> Answer {
        if path.is_empty() {
            return Answer::failed("write `load FILE`\n");
        }
        let source = match read_file(Path::new(path)) {
            Ok(source) => source,
            Err(trouble) => return Answer::failed(trouble.1.render(&trouble.0, self.colour) + "\n"),
        };
        let saved = saved(&source.text);
        match self.replay(&saved) {
            Ok(()) => Answer::said(self.show()),
            Err(error) => Answer::failed(format!("{path}: {error}\n{}", self.show())),
        }
    }

    /// Takes the steps of a saved trace from the start.
    ///
    /// # Errors
    /// Where a step is not readable or not possible, by its line in the file; the run stays before it.
    pub fn replay(&mut self, saved: &Saved) -> Result<(), LoadError> {
        self.stepper.load(&saved.steps).map_err(|error| match error {
            LoadError::Unreadable(line, text) => LoadError::Unreadable(line + saved.line, text),
            LoadError::Impossible(line, why) => LoadError::Impossible(line + saved.line, why),
        })
    }

    /// The run.
    pub fn run(&self) -> &Stepper {
        &self.stepper
    }
}

/// The inputs of a line: it is divided at commas outside brackets, unless it names a file.
fn inputs(line: &str) -> Vec<&str> {
    let word = line.trim_start_matches(':').split_whitespace().next().unwrap_or_default();
    if ["save", "load", "why"].contains(&word) {
        return vec![line];
    }
    let (mut parts, mut depth, mut start) = (Vec::new(), 0usize, 0);
    for (place, letter) in line.char_indices() {
        match letter {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(line.get(start..place).unwrap_or(""));
                start = place + 1;
            }
            _ => {}
        }
    }
    parts.push(line.get(start..).unwrap_or(""));
    parts
}

fn listed(lines: &[String]) -> String {
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

/// What `why not …` asks.
fn query(text: &str) -> Option<Query> {
    let name = |text: &str| {
        let fine = text.chars().all(|letter| letter.is_alphanumeric() || letter == '_' || letter == '\'');
        (fine && !text.is_empty()).then(|| Name::new(text))
    };
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let time = |rest: &str| -> Option<Option<BigRational>> {
        if rest.trim().is_empty() { Some(None) } else { rational(rest).map(Some) }
    };
    if let Ok(number) = text.parse() {
        return Some(Query::Number(number));
    }
    match word {
        "stop" => return Some(Query::Stop),
        "abort" => return Some(Query::Abort),
        "wait" | "time" => return time(rest).map(Query::Time),
        _ => {}
    }
    if let Some(port) = text.strip_suffix('?') {
        return name(port.trim()).map(|port| Query::Port(port, Direction::Read));
    }
    if let Some(port) = text.strip_suffix('!') {
        return name(port.trim()).map(|port| Query::Port(port, Direction::Write));
    }
    let name = name(text)?;
    if name.as_str().starts_with(char::is_uppercase) {
        return Some(Query::Observer(name));
    }
    Some(Query::Port(name, Direction::Either))
}
