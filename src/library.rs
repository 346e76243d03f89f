//! What every session starts with: `prelude.pars` and the laws of `rules/`, which are part of the program.

use crate::ast::ItemKind;
use crate::diagnostic::{Diagnostic, Severity, Source};
use crate::kernel::Theory;
use crate::lower::{Environment, Lowered};
use crate::parser::parse;

/// The texts that are part of the program, each under the path by which it is imported.
const TEXTS: [(&str, &str); 9] = [
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

/// A text that could not be taken in, with what is wrong with it.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The text.
    pub source: Source,
    /// What is wrong.
    pub diagnostics: Vec<Diagnostic>,
}

impl Broken {
    /// For a person.
    pub fn render(&self, colour: bool) -> String {
        crate::diagnostic::render_all(&self.diagnostics, &self.source, colour)
    }
}

/// The text that is imported by this path, if it is part of the program.
pub fn text(path: &str) -> Option<&'static str> {
    TEXTS.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}

/// The paths of all texts that are part of the program.
pub fn paths() -> impl Iterator<Item = &'static str> {
    TEXTS.iter().map(|(name, _)| *name)
}

/// The environment after the prelude.
///
/// # Errors
/// The first text with an error in it.
pub fn prelude() -> Result<Environment, Broken> {
    let mut environment = Environment::new();
    load(&mut environment, "prelude.pars", TEXTS.len())?;
    Ok(environment)
}

/// Takes in one of the program's own texts; imports inside it come before what follows them.
fn load(environment: &mut Environment, path: &str, depth: usize) -> Result<(), Broken> {
    let source = Source::new(path, text(path).unwrap_or_default());
    let parsed = parse(&source.text);
    let mut diagnostics = parsed.diagnostics;
    if diagnostics.is_empty() {
        for part in parsed.items.split_inclusive(|item| matches!(item.kind, ItemKind::Import(_))) {
            for outcome in environment.declare(part, &source.text) {
                match outcome {
                    Ok(Lowered::Import(other)) if depth > 0 => load(environment, &other, depth - 1)?,
                    Ok(_) => {}
                    Err(more) => diagnostics.extend(more),
                }
            }
        }
    }
    if diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
        return Err(Broken { source, diagnostics });
    }
    Ok(())
}

/// What a theorem may rest on in this environment.
pub fn theory(environment: &Environment) -> Theory {
    Theory {
        assumptions: environment.assumptions.clone(),
        definitions: environment.definitions.clone(),
        laws: environment.laws.clone(),
    }
}
