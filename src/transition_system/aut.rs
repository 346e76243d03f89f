//! Systems as text in the Aldebaran format: `des (initial, transitions, states)`, then `(from, "label", to)`, a line each.
//!
//! `tau` and `i` are internal steps. A label may be quoted, with `\"` and `\\` inside, and must be where it holds what
//! would end it. What a state shows and how it has ended has no place in the format: it is written as a step from the
//! state to itself (`stopped`, `aborted`, `shows At_0`), which keeps different states different.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::{Builder, Ending, Label, Mark, TransitionSystem};

/// The most states and transitions of a file.
const MOST: u64 = 200_000_000;

/// What is wrong with a file, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wrong {
    /// The place, in bytes.
    pub offset: usize,
    /// The line, from 1.
    pub line: usize,
    /// The column, in characters, from 1.
    pub column: usize,
    /// What was expected.
    pub what: String,
}

/// The system that a text describes.
///
/// # Errors
/// The first thing that is [`Wrong`] with it.
pub fn read(text: &str) -> Result<TransitionSystem, Wrong> {
    let mut reader = Reader { text, at: 0 };
    reader.read().map_err(|(offset, what)| {
        let before = text.get(..offset).unwrap_or("");
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        Wrong { offset, line, column: before.get(start..).unwrap_or("").chars().count() + 1, what }
    })
}

/// The bytes that reading a text takes besides the text itself, from what its first line announces; none if that line
/// cannot be read.
pub fn need(text: &str) -> Option<usize> {
    let (_, transitions, states) = Reader { text, at: 0 }.header().ok()?;
    usize::try_from(STATE_BYTES.saturating_mul(states).saturating_add(TRANSITION_BYTES.saturating_mul(transitions)))
        .ok()
}

/// The bytes that a state takes: its mark, whether it is whole, and where its transitions begin.
const STATE_BYTES: u64 = 12;
/// The bytes that a transition takes while the system is put together.
const TRANSITION_BYTES: u64 = 20;

type Failure = (usize, String);

struct Reader<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Reader<'t> {
    fn rest(&self) -> &'t str {
        self.text.get(self.at..).unwrap_or("")
    }

    fn skip(&mut self) {
        let rest = self.rest();
        self.at += rest.len() - rest.trim_start_matches([' ', '\t', '\r', '\n', '\u{feff}']).len();
    }

    fn wrong<T>(&self, what: &str) -> Result<T, Failure> {
        let found = match self.rest().chars().next() {
            None => "the text ends".to_string(),
            Some(letter) => format!("found `{}`", letter.escape_debug()),
        };
        Err((self.at, format!("expected {what}, {found}")))
    }

    fn sign(&mut self, sign: char) -> Result<(), Failure> {
        self.skip();
        if self.rest().starts_with(sign) {
            self.at += sign.len_utf8();
            return Ok(());
        }
        self.wrong(&format!("`{sign}`"))
    }

    fn number(&mut self, what: &str) -> Result<u64, Failure> {
        self.skip();
        let rest = self.rest();
        let length = rest.bytes().take_while(u8::is_ascii_digit).count();
        if length == 0 {
            return self.wrong(what);
        }
        let digits = rest.get(..length).unwrap_or_default();
        let number = digits.parse::<u64>().ok().filter(|number| *number <= MOST);
        let Some(number) = number else {
            return Err((self.at, format!("{what} of more than {MOST} is not read")));
        };
        self.at += length;
        Ok(number)
    }

    /// A state, which must be smaller than the number of states.
    fn state(&mut self, states: u64) -> Result<u32, Failure> {
        self.skip();
        let at = self.at;
        let number = self.number("the number of a state")?;
        if number >= states {
            return Err((at, format!("state {number}, but there are only {states} states, numbered from 0")));
        }
        Ok(number as u32)
    }

    fn label(&mut self) -> Result<String, Failure> {
        self.skip();
        let rest = self.rest();
        if let Some(inner) = rest.strip_prefix('"') {
            let mut label = String::new();
            let mut letters = inner.char_indices();
            while let Some((place, letter)) = letters.next() {
                match letter {
                    '"' => {
                        self.at += place + 2;
                        return Ok(label);
                    }
                    '\n' => break,
                    '\\' => match letters.next() {
                        Some((_, escaped @ ('"' | '\\'))) => label.push(escaped),
                        Some((_, '\n')) | None => break,
                        Some((_, other)) => label.extend(['\\', other]),
                    },
                    _ => label.push(letter),
                }
            }
            return Err((self.at, "this label is quoted, and the quotes do not end on its line".to_string()));
        }
        // Not quoted: up to the last comma of the line, as other tools read it.
        let line = rest.split('\n').next().unwrap_or("");
        let before = line.rsplit_once(')').and_then(|(inside, _)| inside.rsplit_once(','));
        match before.filter(|(label, _)| !label.trim().is_empty()) {
            Some((label, _)) => {
                self.at += label.len();
                Ok(label.trim().to_string())
            }
            None => self.wrong("a label, a comma and the state it leads to"),
        }
    }

    /// `des (initial, transitions, states)`: the three numbers.
    fn header(&mut self) -> Result<(u64, u64, u64), Failure> {
        self.skip();
        if !self.rest().starts_with("des") {
            return self.wrong("`des (initial, transitions, states)`");
        }
        self.at += 3;
        self.sign('(')?;
        self.skip();
        let initial_at = self.at;
        let initial = self.number("the number of the initial state")?;
        self.sign(',')?;
        let count = self.number("the number of transitions")?;
        self.sign(',')?;
        self.skip();
        let states_at = self.at;
        let states = self.number("the number of states")?;
        self.sign(')')?;
        if initial >= states {
            return Err((initial_at, format!("the initial state is {initial}, but there are {states} states")));
        }
        // Each state is written at least in the number: a short text that claims many states takes no memory for them
        // beyond this bound.
        if states > 64 + 1_000_000 + 16 * self.text.len() as u64 {
            return Err((states_at, format!("{states} states, which this text does not describe")));
        }
        Ok((initial, count, states))
    }

    fn read(&mut self) -> Result<TransitionSystem, Failure> {
        let (initial, count, states) = self.header()?;
        let mut builder = Builder::new();
        (0..states).for_each(|_| {
            builder.state(Mark::plain());
        });
        let mut known: HashMap<String, u32> = HashMap::new();
        for done in 0.. {
            self.skip();
            if self.rest().is_empty() {
                if done != count {
                    let line = format!("{count} transitions were announced, the text ends after {done}");
                    return Err((self.at, line));
                }
                break;
            }
            if done == count {
                return self.wrong(&format!("the end after the {count} transitions that were announced"));
            }
            self.sign('(')?;
            let from = self.state(states)?;
            self.sign(',')?;
            let text = self.label()?;
            self.sign(',')?;
            let to = self.state(states)?;
            self.sign(')')?;
            let label = match known.get(&text) {
                Some(label) => *label,
                None => {
                    let label = builder.label(match text.as_str() {
                        "tau" | "i" => Label::Tau,
                        _ => Label::Act(text.clone()),
                    });
                    known.insert(text, label);
                    label
                }
            };
            builder.transition(from, label, to);
        }
        Ok(builder.finish(initial as u32, None))
    }
}

fn quoted(text: &str) -> String {
    let text = text.replace(['\n', '\r'], " ");
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The system as text. A bound that was hit cannot be written down: the caller must say so beside it.
pub fn write(system: &TransitionSystem) -> String {
    let labels: Vec<String> = system.labels().iter().map(|label| quoted(&label.to_string())).collect();
    let loops: Vec<Vec<String>> =
        system.marks().iter().map(|mark| seen(mark).iter().map(|text| quoted(text)).collect()).collect();
    let mut lines = String::new();
    let mut count = 0;
    for state in 0..system.states() as u32 {
        for text in &loops[system.mark_number(state) as usize] {
            count += 1;
            let _ = writeln!(lines, "({state}, {text}, {state})");
        }
        for (label, to) in system.steps(state) {
            count += 1;
            let _ = writeln!(lines, "({state}, {}, {to})", labels[*label as usize]);
        }
    }
    format!("des ({}, {count}, {})\n{lines}", system.initial(), system.states())
}

/// What a mark says, as labels of steps that change nothing.
fn seen(mark: &Mark) -> Vec<String> {
    let mut all: Vec<String> = mark.shown.iter().map(|shown| format!("shows {shown}")).collect();
    if mark.ending != Ending::Running {
        all.push(mark.ending.to_string());
    }
    all
}
