//! What the line editor knows of the language: colours, completion, hints, and whether an input is finished.

use std::borrow::Cow;

use rustyline::completion::{Completer, FilenameCompleter, Pair};
use rustyline::highlight::{CmdKind, Highlighter};
use rustyline::hint::Hinter;
use rustyline::validate::{ValidationContext, ValidationResult, Validator};
use rustyline::{Context, Helper, Result};

use super::command::COMMANDS;
use super::help::topics;
use crate::lexer::{Keyword, Kind, lex};
use crate::lower::{BASIC, Entity, Quantity};
use crate::parser::parse_input;
use crate::session::Session;

/// Words that may be completed, besides the keywords.
const WORDS: [&str; 16] = [
    "proved", "refuted", "open", "yes", "no", "unknown", "never", "natural", "clamp", "floor", "Normal", "Exp",
    "Poisson", "Uniform", "Mix", "Point",
];

/// Letters that have names.
const LETTERS: [(&str, &str); 22] = [
    ("\\alpha", "α"),
    ("\\beta", "β"),
    ("\\gamma", "γ"),
    ("\\delta", "δ"),
    ("\\epsilon", "ε"),
    ("\\eta", "η"),
    ("\\theta", "θ"),
    ("\\kappa", "κ"),
    ("\\lambda", "λ"),
    ("\\mu", "μ"),
    ("\\nu", "ν"),
    ("\\rho", "ρ"),
    ("\\sigma", "σ"),
    ("\\tau", "τ"),
    ("\\phi", "φ"),
    ("\\psi", "ψ"),
    ("\\omega", "ω"),
    ("\\le", "≤"),
    ("\\ge", "≥"),
    ("\\ne", "≠"),
    ("\\par", "∥"),
    ("\\langle", "⟨"),
];

/// What stands behind the name of a basic process.
const SHAPES: [(&str, &str); 11] = [
    ("Delay", "_t"),
    ("In", "_c<y>"),
    ("Out", "_{c,x}"),
    ("Eq", "_{x,y}"),
    ("Neq", "_{x,y}"),
    ("Gtr", "_{x,y}"),
    ("Gte", "_{x,y}"),
    ("Lss", "_{x,y}"),
    ("Lte", "_{x,y}"),
    ("Set", "_x<y>"),
    ("Ran", "_D<y>"),
];

/// Helps at the prompt.
pub(super) struct Assistant {
    colour: bool,
    /// Names that are declared, each with what stands behind it.
    names: Vec<(String, String)>,
    laws: Vec<String>,
    claims: Vec<String>,
    files: FilenameCompleter,
    /// Whether a line is a step of a run.
    stepping: bool,
}

impl Assistant {
    pub(super) fn new(colour: bool) -> Assistant {
        let (names, laws, claims) = (Vec::new(), Vec::new(), Vec::new());
        Assistant { colour, names, laws, claims, files: FilenameCompleter::new(), stepping: false }
    }

    /// One for the steps of a run alone.
    pub(super) fn for_steps(colour: bool) -> Assistant {
        Assistant { stepping: true, ..Assistant::new(colour) }
    }

    /// Takes note of what is declared by now.
    pub(super) fn learn(&mut self, session: &Session, stepping: bool) {
        self.stepping = stepping;
        let environment = session.environment();
        let list = |names: Vec<String>| match names.as_slice() {
            [] => String::new(),
            [one] => format!("_{one}"),
            _ => format!("_{{{}}}", names.join(",")),
        };
        self.names = environment
            .entities()
            .map(|(name, entity)| {
                let parameters = match entity {
                    Entity::Process(signature) => signature.parameters.iter().map(ToString::to_string).collect(),
                    Entity::Observer(count) => (1..=*count).map(|number| format!("x{number}")).collect(),
                    _ => Vec::new(),
                };
                (name.to_string(), list(parameters))
            })
            .chain(environment.quantities().map(|(name, quantity)| {
                let shape = match quantity {
                    Quantity::Function { parameters, .. } => {
                        format!("({})", parameters.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "))
                    }
                    Quantity::Parameter { .. } => String::new(),
                };
                (name.to_string(), shape)
            }))
            .collect();
        self.laws = environment.laws.iter().map(|law| law.name.to_string()).collect();
        self.claims = session
            .records()
            .iter()
            .filter_map(|record| record.report.name.as_ref())
            .map(ToString::to_string)
            .collect();
    }

    /// Everything that may stand where the word at the end of `before` stands.
    fn candidates(&self, before: &str, word: &str) -> Vec<String> {
        let command = before.trim_start().strip_prefix(':');
        let mut all: Vec<String> = match command.map(|command| command.split_once(char::is_whitespace)) {
            Some(None) => COMMANDS.iter().map(|(name, ..)| (*name).to_string()).collect(),
            Some(Some((command, _))) if command.starts_with('h') => topics().map(str::to_string).collect(),
            Some(Some((command, _))) if command.starts_with("law") => self.laws.clone(),
            Some(Some((command, _))) if command.starts_with('w') => self.claims.clone(),
            Some(_) => self.names.iter().map(|(name, _)| name.clone()).chain(self.claims.clone()).collect(),
            None => {
                let declared = self.names.iter().map(|(name, _)| name.clone());
                let keywords = Keyword::ALL.iter().map(|(_, word)| word);
                let words = BASIC.iter().chain(&WORDS).chain(keywords).map(|word| (*word).to_string());
                let laws = if before.contains(" by ") || before.contains('{') { self.laws.clone() } else { Vec::new() };
                declared.chain(words).chain(laws).collect()
            }
        };
        all.retain(|name| name.starts_with(word));
        all.sort();
        all.dedup();
        all
    }
}

/// Where the word at the end of a text begins; law names hold dashes.
fn word_start(text: &str) -> usize {
    let inside = |letter: char| letter.is_alphanumeric() || letter == '-' || letter == '\'';
    text.char_indices().rev().find(|(_, letter)| !inside(*letter)).map_or(0, |(at, letter)| at + letter.len_utf8())
}

impl Helper for Assistant {}

impl Completer for Assistant {
    type Candidate = Pair;

    fn complete(&self, line: &str, position: usize, context: &Context<'_>) -> Result<(usize, Vec<Pair>)> {
        let before = line.get(..position).unwrap_or("");
        if let Some(at) = before.rfind('\\') {
            let word = before.get(at..).unwrap_or("");
            if word.chars().skip(1).all(char::is_alphabetic) {
                let fits = LETTERS.iter().filter(|(name, _)| name.starts_with(word));
                let exact = LETTERS.iter().find(|(name, _)| *name == word);
                let fits = exact.into_iter().chain(fits.filter(|_| exact.is_none()));
                let pair = |(name, letter): &(&str, &str)| Pair {
                    display: format!("{letter} {name}"),
                    replacement: (*letter).to_string(),
                };
                return Ok((at, fits.map(pair).collect()));
            }
        }
        let command = before.trim_start();
        if [":l", ":s", ":p"].iter().any(|start| command.starts_with(start))
            && let Some((word, _)) = command.split_once(char::is_whitespace)
            && [":load", ":save", ":proof"].iter().any(|name| name.starts_with(word) && word.len() > 2)
        {
            return self.files.complete(line, position, context);
        }
        let start = word_start(before);
        let word = before.get(start..).unwrap_or("");
        let pair = |name: String| Pair { display: name.clone(), replacement: name };
        Ok((start, self.candidates(before, word).into_iter().map(pair).collect()))
    }
}

impl Hinter for Assistant {
    type Hint = String;

    fn hint(&self, line: &str, position: usize, _context: &Context<'_>) -> Option<String> {
        if self.stepping || position < line.len() || line.trim_start().starts_with(':') {
            return None;
        }
        let word = line.get(word_start(line)..)?;
        let basic = SHAPES.iter().find(|(name, _)| *name == word).map(|(_, shape)| (*shape).to_string());
        let declared = self.names.iter().find(|(name, _)| name == word).map(|(_, shape)| shape.clone());
        basic.or(declared).filter(|shape| !shape.is_empty())
    }
}

impl Validator for Assistant {
    fn validate(&self, context: &mut ValidationContext<'_>) -> Result<ValidationResult> {
        let text = context.input();
        // Two empty lines end an input that is not finished; then its error is shown.
        let command = text.trim_start().starts_with(':');
        if self.stepping || command || text.ends_with("\n\n") || !parse_input(text).incomplete {
            return Ok(ValidationResult::Valid(None));
        }
        Ok(ValidationResult::Incomplete)
    }
}

impl Highlighter for Assistant {
    fn highlight<'l>(&self, line: &'l str, _position: usize) -> Cow<'l, str> {
        if self.stepping || !self.colour || line.len() > 20_000 {
            return Cow::Borrowed(line);
        }
        if line.trim_start().starts_with(':') {
            return Cow::Owned(format!("\u{1b}[36m{line}\u{1b}[0m"));
        }
        Cow::Owned(coloured(line))
    }

    fn highlight_hint<'h>(&self, hint: &'h str) -> Cow<'h, str> {
        if self.colour { Cow::Owned(format!("\u{1b}[2m{hint}\u{1b}[0m")) } else { Cow::Borrowed(hint) }
    }

    fn highlight_prompt<'b, 's: 'b, 'p: 'b>(&'s self, prompt: &'p str, _default: bool) -> Cow<'b, str> {
        if self.colour { Cow::Owned(format!("\u{1b}[1;34m{prompt}\u{1b}[0m")) } else { Cow::Borrowed(prompt) }
    }

    fn highlight_char(&self, _line: &str, _position: usize, _kind: CmdKind) -> bool {
        self.colour
    }
}

/// The line with colours; the letters stay as they are.
fn coloured(line: &str) -> String {
    let lexed = lex(line);
    let mut pieces: Vec<(usize, usize, &str)> = lexed
        .tokens
        .iter()
        .filter_map(|token| {
            let colour = match token.kind {
                Kind::Word(_) => "35",
                Kind::Upper if BASIC.contains(&token.span.of(line)) => "34",
                Kind::Upper => "36",
                Kind::Meta => "33",
                Kind::Number => "32",
                Kind::Text | Kind::Origin => "32",
                Kind::Unknown => "31",
                _ => return None,
            };
            Some((token.span.start, token.span.end, colour))
        })
        .chain(lexed.comments.iter().map(|span| (span.start, span.end, "2")))
        .collect();
    pieces.sort_unstable();
    let mut out = String::with_capacity(line.len() * 2);
    let mut end = 0;
    for (start, stop, colour) in pieces.into_iter().filter(|(start, stop, _)| start < stop) {
        if start < end {
            continue;
        }
        out.push_str(line.get(end..start).unwrap_or(""));
        out.push_str(&format!("\u{1b}[{colour}m{}\u{1b}[0m", line.get(start..stop).unwrap_or("")));
        end = stop;
    }
    out.push_str(line.get(end..).unwrap_or(""));
    out
}
