//! `prelude.pars` and `rules/`, embedded as they stand; and the reading of files that import others.

use std::collections::BTreeSet;

use crate::ast::{Item, ItemKind};
use crate::diagnostic::{Diagnostic, Source};
use crate::lower::{Environment, Lowered};
use crate::parser::{Parsed, parse_until};

/// The files that every session can import, by name.
pub const FILES: [(&str, &str); 9] = [
    ("prelude.pars", include_str!("../prelude.pars")),
    ("rules/sequence.rules", include_str!("../rules/sequence.rules")),
    ("rules/parallel.rules", include_str!("../rules/parallel.rules")),
    ("rules/disable.rules", include_str!("../rules/disable.rules")),
    ("rules/delay.rules", include_str!("../rules/delay.rules")),
    ("rules/observe.rules", include_str!("../rules/observe.rules")),
    ("rules/condition.rules", include_str!("../rules/condition.rules")),
    ("rules/loop.rules", include_str!("../rules/loop.rules")),
    ("rules/port.rules", include_str!("../rules/port.rules")),
];

/// Files import each other at most this deep.
const DEEPEST: usize = 50;

/// A text with what is wrong in it.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The text.
    pub source: Source,
    /// What is wrong.
    pub diagnostics: Vec<Diagnostic>,
}

/// The embedded file of this name.
pub fn embedded(name: &str) -> Option<Source> {
    FILES.iter().find(|(known, _)| *known == name).map(|(name, text)| Source::new(*name, *text))
}

/// The rule files that are part of the program.
pub fn rules() -> Vec<Source> {
    FILES.iter().filter(|(name, _)| name.ends_with(".rules")).map(|(name, text)| Source::new(*name, *text)).collect()
}

/// What every session starts with: the prelude, and with it the laws.
///
/// # Errors
/// What is wrong in the prelude or a rule file; a test holds that nothing is.
pub fn standard() -> Result<Environment, Vec<Failure>> {
    let mut environment = Environment::new();
    let mut reader = Reader::new(|_, name| embedded(name).ok_or_else(|| "there is no such file".to_string()));
    let source = embedded("prelude.pars").unwrap_or_default();
    let failures = reader.read(&mut environment, &source, &mut |_, _, _, _| {});
    if failures.is_empty() { Ok(environment) } else { Err(failures) }
}

/// Is told of each item of a text in order, with the environment after it: the items of the text itself and of all
/// that it imports. A declaration of an imported file is in force by then.
pub type Visitor<'v> = dyn FnMut(&mut Environment, &Source, &Item, Lowered) + 'v;

/// Reads texts that import others: each once, and none while it is being read.
pub struct Reader<F> {
    find: F,
    open: Vec<String>,
    done: BTreeSet<String>,
    interrupted: Box<dyn Fn() -> bool>,
    stopped: bool,
}

impl<F: FnMut(&str, &str) -> Result<Source, String>> Reader<F> {
    /// A reader that finds what is imported with `find`: given the name of the importing text and what the import
    /// says, the text, whose name tells it from all others, or why there is none.
    pub fn new(find: F) -> Reader<F> {
        let interrupted = Box::new(|| false);
        Reader { find, open: Vec::new(), done: BTreeSet::new(), interrupted, stopped: false }
    }

    /// The same, which reads until it is interrupted.
    pub fn until(self, interrupted: impl Fn() -> bool + 'static) -> Reader<F> {
        Reader { interrupted: Box::new(interrupted), ..self }
    }

    /// Whether it was interrupted: then what stands further on was not read.
    pub fn stopped(&self) -> bool {
        self.stopped
    }

    /// Takes a text and all that it imports into an environment, item by item.
    /// What cannot be read is left out and reported at the end.
    pub fn read(&mut self, environment: &mut Environment, source: &Source, visit: &mut Visitor<'_>) -> Vec<Failure> {
        // The tokens of a long text take more room than all the rest.
        let Some(Parsed { items, broken, mut diagnostics, .. }) = parse_until(&source.text, &*self.interrupted) else {
            self.stopped = true;
            return Vec::new();
        };
        let mut failures = Vec::new();
        let text = source.text.as_str();
        let mut unread = broken.iter().copied().filter(|start| text.get(*start..).is_some_and(asks)).peekable();
        let mut unasked = Unasked::default();
        let mut broken: BTreeSet<&str> = broken.iter().filter_map(|start| declared(text.get(*start..)?)).collect();
        self.open.push(source.name.clone());
        for segment in segments(&items) {
            if self.stopped {
                break;
            }
            if let [Item { kind: ItemKind::Import(path), .. }] = segment {
                unasked = Unasked::default();
                failures.extend(self.import(environment, source, segment, path, visit, &mut diagnostics));
                continue;
            }
            let Some(mut batch) = environment.open_until(segment, &source.text, &*self.interrupted) else {
                self.stopped = true;
                break;
            };
            for (index, item) in segment.iter().enumerate() {
                self.stopped = index > 0 && (self.interrupted)();
                if self.stopped {
                    break;
                }
                while unread.next_if(|start| *start < item.span.start).is_some() {
                    unasked.failed();
                }
                let lowered = environment.step_until(&mut batch, index, item, &*self.interrupted);
                if unasked.passes_over(item, lowered.is_ok()) {
                    continue;
                }
                match lowered {
                    Ok(lowered) => visit(environment, source, item, lowered),
                    Err(mut errors) => {
                        // What follows from something that could not be read is not said again.
                        errors.retain(|error| !follows(error, &broken, text));
                        if !diagnostics.is_empty() {
                            errors.retain(|error| error.code != REFUSED);
                        }
                        if errors.is_empty() {
                            broken.extend(declared(item.span.of(text)));
                        }
                        diagnostics.extend(errors);
                    }
                }
            }
        }
        self.open.pop();
        self.done.insert(source.name.clone());
        if !diagnostics.is_empty() {
            failures.push(Failure { source: source.clone(), diagnostics });
        }
        failures
    }

    fn import(
        &mut self,
        environment: &mut Environment,
        source: &Source,
        segment: &[Item],
        path: &str,
        visit: &mut Visitor<'_>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Vec<Failure> {
        let span = segment.first().map(|item| item.span).unwrap_or_default();
        let found = match (self.find)(&source.name, path) {
            Ok(found) => found,
            Err(why) => {
                let error = Diagnostic::error("P0801", format!("`{path}` cannot be imported: {why}"));
                diagnostics.push(
                    error
                        .label(span, "imported here")
                        .note("a path is looked up from the folder of the importing file"),
                );
                return Vec::new();
            }
        };
        if self.open.contains(&found.name) {
            let way =
                self.open.iter().map(String::as_str).chain([found.name.as_str()]).collect::<Vec<_>>().join(" imports ");
            let error = Diagnostic::error("P0802", format!("`{path}` imports itself"));
            diagnostics.push(error.label(span, "imported here, while it is being read").note(way));
            return Vec::new();
        }
        if self.open.len() >= DEEPEST {
            let error = Diagnostic::error("P0803", format!("files import each other more than {DEEPEST} deep"));
            diagnostics.push(error.label(span, "imported here"));
            return Vec::new();
        }
        if self.done.contains(&found.name) { Vec::new() } else { self.read(environment, &found, visit) }
    }
}

/// The error of a name whose definition has errors.
const REFUSED: &str = "P0312";

/// The name that an item declares: what stands behind its keyword.
fn declared(item: &str) -> Option<&str> {
    let rest = item.split_once(char::is_whitespace)?.1.trim_start();
    let end = rest.find(|character: char| !character.is_alphanumeric()).unwrap_or(rest.len());
    rest.get(..end).filter(|name| !name.is_empty())
}

/// Whether an item, from its first word on, asks for something that may be expected.
fn asks(item: &str) -> bool {
    let word = item.split_whitespace().next().unwrap_or("");
    !["param", "fn", "proc", "observer", "system", "property", "expect", "import", "law"].contains(&word)
}

/// Whether what was asked last could not be read: what is expected of it is expected of nothing that was asked before.
#[derive(Default)]
pub(crate) struct Unasked(bool);

impl Unasked {
    fn failed(&mut self) {
        self.0 = true;
    }

    /// Takes notice of the next item, and of whether it could be read; whether it is expected of what could not.
    pub(crate) fn passes_over(&mut self, item: &Item, read: bool) -> bool {
        use ItemKind::{Expect, Function, Import, Law, Observer, Param, Process, Property, System};
        match item.kind {
            Expect(_) => return self.0,
            Param(_) | Function(..) | Process(..) | Observer(_) | System(..) | Property(..) | Import(_) | Law(_) => {}
            _ => self.0 = !read,
        }
        false
    }
}

/// Whether an error says no more than that one of these names is not known, or has errors itself.
fn follows(error: &Diagnostic, broken: &BTreeSet<&str>, text: &str) -> bool {
    let unknown = matches!(error.code, "P0304" | "P0307" | REFUSED | "P0314" | "P0318");
    unknown && error.labels.first().is_some_and(|label| broken.contains(label.span.of(text)))
}

/// The items of a text in order, split so that each import stands alone: what stands between two imports sees itself
/// and what was imported before.
pub fn segments(items: &[Item]) -> Vec<&[Item]> {
    let imports = |item: &Item| matches!(item.kind, ItemKind::Import(_));
    items.chunk_by(|left, right| !imports(left) && !imports(right)).collect()
}
