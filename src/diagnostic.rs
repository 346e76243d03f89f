//! What a user is told when something is wrong: what, where, why, and one way to mend it.

use std::cmp::Ordering;
use std::fmt::Write as _;

use annotate_snippets::{AnnotationKind, Group, Level, Patch, Renderer, Snippet};

/// A piece of a source text, in bytes: from `start`, up to but not including `end`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The first byte.
    pub start: usize,
    /// The byte behind the last.
    pub end: usize,
}

impl Span {
    /// From `start` up to `end`.
    pub fn new(start: usize, end: usize) -> Span {
        Span { start, end: end.max(start) }
    }

    /// The least span that covers both.
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// The text it covers; empty where it does not fit the text.
    pub fn of(self, text: &str) -> &str {
        text.get(self.start..self.end).unwrap_or("")
    }
}

/// A text with the name of the place it came from.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Source {
    /// A file name, or `<input>`.
    pub name: String,
    /// The whole text.
    pub text: String,
}

impl Source {
    /// This text from this place.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Source {
        Source { name: name.into(), text: text.into() }
    }

    /// The bytes of a file as text.
    ///
    /// # Errors
    /// When the bytes are not UTF-8: the readable part, and a diagnostic that points behind it.
    pub fn from_bytes(name: &str, bytes: Vec<u8>) -> Result<Source, Box<(Source, Diagnostic)>> {
        match String::from_utf8(bytes) {
            Ok(text) => Ok(Source::new(name, text)),
            Err(error) => {
                let offset = error.utf8_error().valid_up_to();
                let bytes = error.into_bytes();
                let readable = String::from_utf8_lossy(bytes.get(..offset).unwrap_or(&[])).into_owned();
                let byte = bytes.get(offset).copied().unwrap_or(0);
                let diagnostic = Diagnostic::error(
                    "P0101",
                    format!("this file is not UTF-8 text: byte {offset} (0x{byte:02x}) begins no letter"),
                )
                .label(Span::new(offset, offset), "readable up to here")
                .note("save the file as UTF-8; most editors offer that under \"encoding\"");
                Err(Box::new((Source::new(name, readable), diagnostic)))
            }
        }
    }

    /// Line and column of a byte, counted from 1, the column in characters.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let before = self.text.get(..floor(&self.text, offset)).unwrap_or("");
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (line, before.get(start..).unwrap_or("").chars().count() + 1)
    }
}

/// The nearest character boundary at or before `offset`.
fn floor(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The input is refused.
    Error,
    /// The input is taken, and probably not what was meant.
    Warning,
    /// Worth knowing.
    Note,
}

impl Severity {
    /// `error`, `warning` or `note`.
    pub fn spelling(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        }
    }
}

/// A place with what is to be said about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// The place.
    pub span: Span,
    /// What is to be said; may be empty.
    pub text: String,
}

/// One way to mend it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What to do, in words.
    pub text: String,
    /// The text to put in place of a span, when that is all there is to do.
    pub edit: Option<(Span, String)>,
}

/// One thing that is wrong, or worth knowing. The first label is where to look first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// A stable code such as `P0204`, which `pars explain` describes.
    pub code: &'static str,
    /// One sentence in the user's words.
    pub message: String,
    /// Where; the first is the main place.
    pub labels: Vec<Label>,
    /// Why, and what else helps to understand.
    pub notes: Vec<String>,
    /// One way to mend it.
    pub fix: Option<Fix>,
}

impl Diagnostic {
    /// An error with this code and message and nothing else yet.
    pub fn error(code: &'static str, message: impl Into<String>) -> Diagnostic {
        let message = message.into();
        Diagnostic { severity: Severity::Error, code, message, labels: Vec::new(), notes: Vec::new(), fix: None }
    }

    /// A warning with this code and message and nothing else yet.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Diagnostic {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, message) }
    }

    /// With one more place.
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// With one more note.
    pub fn note(mut self, text: impl Into<String>) -> Diagnostic {
        self.notes.push(text.into());
        self
    }

    /// With a way to mend it, in words.
    pub fn help(mut self, text: impl Into<String>) -> Diagnostic {
        self.fix = Some(Fix { text: text.into(), edit: None });
        self
    }

    /// With a way to mend it, as a change of the text.
    pub fn edit(mut self, text: impl Into<String>, span: Span, replacement: impl Into<String>) -> Diagnostic {
        self.fix = Some(Fix { text: text.into(), edit: Some((span, replacement.into())) });
        self
    }

    /// The main place.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|label| label.span)
    }

    /// The text for a person: message, the lines concerned with carets, notes and fix.
    pub fn render(&self, source: &Source, colour: bool) -> String {
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
            Severity::Note => Level::NOTE,
        };
        let mut groups = Vec::new();
        let mut group = level.primary_title(self.message.as_str()).id(self.code).elements(self.snippets(source));
        group = group.elements(self.notes.iter().map(|note| Level::NOTE.message(note.as_str())));
        let mut edit = None;
        if let Some(fix) = &self.fix {
            edit = fix
                .edit
                .as_ref()
                .and_then(|(span, text)| Window::of(source, *span).map(|window| (window, *span, text)));
            if edit.is_none() {
                group = group.element(Level::HELP.message(fix.text.as_str()));
            }
        }
        groups.push(group);
        if let (Some(fix), Some((window, span, text))) = (&self.fix, edit) {
            let snippet = Snippet::source(window.text)
                .line_start(window.line)
                .path(source.name.as_str())
                .patch(Patch::new(window.place(span), text.as_str()));
            groups.push(Group::with_title(Level::HELP.secondary_title(fix.text.as_str())).element(snippet));
        }
        self.with_true_columns(renderer.render(&groups), source)
    }

    /// The middle of a long line is shown without its beginning, from which the columns shown are counted.
    fn with_true_columns(&self, mut text: String, source: &Source) -> String {
        let edit = self.fix.as_ref().and_then(|fix| fix.edit.as_ref()).map(|(span, _)| (*span, *span));
        let labels = self.together().into_iter().filter_map(|(all, labels)| Some((all, labels.first()?.span)));
        for (all, span) in labels.chain(edit) {
            let Some(window) = Window::of(source, all) else { continue };
            let (line, column) = source.line_column(span.start);
            let shown = window.text.get(..window.place(span).start).unwrap_or("").chars().count() + 1;
            if line == window.line && shown != column {
                let place = |column: usize| format!("{}:{line}:{column}", source.name);
                text = text.replacen(&format!("{}\n", place(shown)), &format!("{}\n", place(column)), 1);
            }
        }
        text
    }

    /// The labels near the main one, and each that is far from it, with what they span together.
    fn together(&self) -> Vec<(Span, Vec<&Label>)> {
        let Some(main) = self.labels.first() else { return Vec::new() };
        let near = |label: &&Label| {
            label.span.start.abs_diff(main.span.start) < FAR && label.span.end.abs_diff(main.span.end) < FAR
        };
        let (beside, away): (Vec<&Label>, Vec<&Label>) = self.labels.iter().partition(near);
        let all = beside.iter().fold(main.span, |span, label| span.to(label.span));
        std::iter::once((all, beside)).chain(away.into_iter().map(|label| (label.span, vec![label]))).collect()
    }

    /// The lines that the labels stand in; labels far from the main one get a snippet of their own.
    fn snippets<'s>(&'s self, source: &'s Source) -> Vec<Snippet<'s, annotate_snippets::Annotation<'s>>> {
        let mut result = Vec::new();
        let main = self.labels.first();
        for (span, labels) in self.together() {
            let Some(window) = Window::of(source, span) else {
                continue;
            };
            let mut snippet = Snippet::source(window.text).line_start(window.line).path(source.name.as_str());
            for label in labels {
                let primary = main.is_some_and(|main| std::ptr::eq(label, main));
                let kind = if primary { AnnotationKind::Primary } else { AnnotationKind::Context };
                let annotation = kind.span(window.place(label.span));
                let text = if label.text.is_empty() { None } else { Some(label.text.as_str()) };
                snippet = snippet.annotation(annotation.label(text));
            }
            result.push(snippet);
        }
        result
    }

    /// The same as JSON: `severity`, `code`, `message`, `file`, `line`, `column`, `labels`, `notes`, `fix`.
    pub fn to_json(&self, source: &Source) -> serde_json::Value {
        let place = |span: Span| {
            let (line, column) = source.line_column(span.start);
            serde_json::json!({ "line": line, "column": column, "start": span.start, "end": span.end })
        };
        let labels: Vec<_> = self
            .labels
            .iter()
            .map(|label| serde_json::json!({ "at": place(label.span), "text": label.text }))
            .collect();
        let mut object = serde_json::json!({
            "severity": self.severity.spelling(), "code": self.code, "message": self.message, "file": source.name,
        });
        if let Some(map) = object.as_object_mut() {
            if let Some(span) = self.span() {
                let (line, column) = source.line_column(span.start);
                map.insert("line".into(), line.into());
                map.insert("column".into(), column.into());
                map.insert("labels".into(), labels.into());
            }
            if !self.notes.is_empty() {
                map.insert("notes".into(), self.notes.clone().into());
            }
            if let Some(fix) = &self.fix {
                map.insert("fix".into(), fix.text.clone().into());
                if let Some((span, replacement)) = &fix.edit {
                    map.insert("edit".into(), serde_json::json!({ "at": place(*span), "text": replacement }));
                }
            }
        }
        object
    }
}

/// Labels further apart than this many bytes are shown apart.
const FAR: usize = 20_000;

/// How much of a line is shown on each side of a place, at most.
const REACH: usize = 400;

/// The whole lines around a span, or the middle of them where they are very long.
struct Window<'s> {
    text: &'s str,
    start: usize,
    line: usize,
}

impl<'s> Window<'s> {
    fn of(source: &'s Source, span: Span) -> Option<Window<'s>> {
        let text = source.text.as_str();
        let first = floor(text, span.start);
        let last = floor(text, span.end).max(first);
        let start = text.get(..first)?.rfind('\n').map_or(0, |newline| newline + 1);
        let start = floor(text, start.max(first.saturating_sub(REACH)));
        let end = text.get(last..)?.find('\n').map_or(text.len(), |newline| last + newline);
        let end = floor(text, end.min(last + REACH)).max(last);
        let line = text.get(..start)?.bytes().filter(|byte| *byte == b'\n').count() + 1;
        Some(Window { text: text.get(start..end)?, start, line })
    }

    fn place(&self, span: Span) -> std::ops::Range<usize> {
        let start = floor(self.text, span.start.saturating_sub(self.start));
        let end = floor(self.text, span.end.saturating_sub(self.start)).max(start);
        start..end
    }
}

/// The name in `known` that `wrong` is most likely a slip of; none when all are far.
pub fn nearest<'n>(wrong: &str, known: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    let letters: Vec<char> = wrong.chars().take(40).collect();
    // In names of one or two letters every change makes another good name.
    let limit = if letters.len() < 3 { 0 } else { (letters.len() / 3).clamp(1, 3) };
    let mut best: Option<(usize, &str)> = None;
    for name in known {
        let distance = if name.eq_ignore_ascii_case(wrong) { 0 } else { edits(&letters, name) };
        let better = match best {
            None => true,
            Some((least, shown)) => distance.cmp(&least).then_with(|| name.cmp(shown)) == Ordering::Less,
        };
        if distance <= limit && name != wrong && better {
            best = Some((distance, name));
        }
    }
    best.map(|(_, name)| name)
}

/// The longest name that is looked at for names in it.
const LONGEST_PRODUCT: usize = 40;

/// A name as a product of names that stand side by side in it: `u*t` for `ut`, of as few as will do.
pub fn product(text: &str, known: impl Fn(&str) -> bool) -> Option<String> {
    let ends: Vec<usize> = text.char_indices().map(|(place, _)| place).skip(1).chain([text.len()]).collect();
    if ends.len() > LONGEST_PRODUCT {
        return None;
    }
    // For each place the factors of what stands before it.
    let mut found: Vec<(usize, Vec<&str>)> = vec![(0, Vec::new())];
    for end in ends {
        let ways = found.iter().filter_map(|(start, before)| {
            let part = text.get(*start..end).filter(|part| known(part))?;
            Some(before.iter().copied().chain([part]).collect::<Vec<&str>>())
        });
        if let Some(fewest) = ways.min_by_key(Vec::len) {
            found.push((end, fewest));
        }
    }
    let (end, parts) = found.pop()?;
    (end == text.len() && parts.len() > 1).then(|| parts.join("*"))
}

/// The number of letters to change, add, drop or swap with a neighbour.
fn edits(left: &[char], right: &str) -> usize {
    let right: Vec<char> = right.chars().take(40).collect();
    let mut before: Vec<usize> = Vec::new();
    let mut above: Vec<usize> = (0..=right.len()).collect();
    for (i, letter) in left.iter().enumerate() {
        let mut row = vec![i + 1];
        for (j, other) in right.iter().enumerate() {
            let keep = above.get(j).copied().unwrap_or(0) + usize::from(letter != other);
            let drop = above.get(j + 1).copied().unwrap_or(0) + 1;
            let add = row.get(j).copied().unwrap_or(0) + 1;
            let swapped = i > 0 && j > 0 && left.get(i - 1) == Some(other) && right.get(j - 1) == Some(letter);
            let swap = if swapped { before.get(j - 1).copied().unwrap_or(usize::MAX - 1) + 1 } else { usize::MAX };
            row.push(keep.min(drop).min(add).min(swap));
        }
        before = std::mem::replace(&mut above, row);
    }
    above.last().copied().unwrap_or(0)
}

/// All of them, one after the other, with a line that counts the errors.
pub fn render_all(diagnostics: &[Diagnostic], source: &Source, colour: bool) -> String {
    let mut text = String::new();
    for diagnostic in diagnostics {
        let _ = writeln!(text, "{}\n", diagnostic.render(source, colour));
    }
    let errors = diagnostics.iter().filter(|diagnostic| diagnostic.severity == Severity::Error).count();
    if errors > 1 {
        let _ = writeln!(text, "{errors} errors");
    }
    text
}
