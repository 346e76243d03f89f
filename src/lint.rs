//! What is wrong with the laws of a file, or only unwise: each finding with its evidence and its place.
//!
//! A law is unsound where the judge has a run that contradicts it; one of the known traps; a law with which simplification
//! goes on for ever; an instance of another; or one that takes a process elsewhere than another law does, so that
//! simplification does not bring the two together.

mod overlap;
mod subsume;
mod unify;
mod trap;

use std::collections::BTreeSet;

use crate::admission::{endless_term, untried};
use crate::ast::{Item, ItemKind};
use crate::diagnostic::{Diagnostic, Severity, Source, Span, render_all};
use crate::explain::run_lines;
use crate::fact::Context;
use crate::kernel::Theory;
use crate::law::{Law, Laws};
use crate::library::{self, Failure, Reader, segments};
use crate::lower::{Environment, Lowered};
use crate::name::Name;
use crate::parser::parse;
use crate::proof::Statement;
use crate::refute::{Limits, Refutation, judge};
use crate::remedy::{in_words, remedies};
use crate::session::Surroundings;
use crate::simplify::Simplifier;
use crate::term::Term;

pub use trap::traps;

/// Instances tried for each law.
const INSTANCES: usize = 4_000;

/// What was looked at, and what was found.
#[derive(Clone, Debug, Default)]
pub struct Lint {
    /// The number of laws.
    pub laws: usize,
    /// The findings, in the order of the laws.
    pub findings: Vec<Diagnostic>,
}

/// A law of the file.
struct Entry {
    law: Law,
    span: Span,
    /// What lowering says of its direction.
    looping: Option<Diagnostic>,
}

/// What a file says.
struct Read {
    environment: Environment,
    /// The laws in force without it.
    own: Laws,
    entries: Vec<Entry>,
    /// Laws with a loop in no time, which have no meaning.
    timeless: Vec<Diagnostic>,
}

/// Looks at the laws of a file.
///
/// # Errors
/// What is wrong with the file, so that its laws cannot be looked at.
pub fn lint(
    source: &Source,
    find: impl FnMut(&str, &str) -> Result<Source, String>,
    interrupted: &dyn Fn() -> bool,
) -> Result<Lint, Vec<Failure>> {
    let Read { environment, own, entries, timeless } = laws_of(source, find)?;
    let mut laws = own.clone();
    // Laws that simplification can live with so far.
    let mut tame = own.clone();
    let mut lint = Lint { laws: entries.len() + timeless.len(), findings: timeless };
    for entry in &entries {
        laws.push(entry.law.clone());
    }
    for (place, entry) in entries.iter().enumerate() {
        if interrupted() {
            break;
        }
        let law = &entry.law;
        let unsound = soundness(entry, &environment, interrupted, &mut lint.findings);
        let loops = looping(entry, &tame, interrupted, &mut lint.findings);
        if !loops {
            tame.push(law.clone());
        }
        let others =
            own.iter().map(|law| (**law).clone()).chain(entries.iter().enumerate().filter_map(|(other, one)| {
                // Of two that are instances of each other the later is one too many.
                let earlier =
                    other < place || (other > place && subsume::subsumes(law, &one.law, &environment).is_none());
                (other != place && earlier).then(|| one.law.clone())
            }));
        let subsumed = subsume::finding(law, entry.span, others, &environment);
        // What it overlaps with, the law that it follows from does too.
        let follows = subsumed.is_some();
        lint.findings.extend(subsumed);
        if !loops && !unsound && !follows {
            let tame_theory = Theory { laws: tame.clone(), ..Theory::default() };
            lint.findings.extend(overlap::findings(law, entry.span, &tame_theory, &environment, interrupted));
        }
    }
    Ok(lint)
}

/// Whether something was found in a file, and what; for a person.
///
/// # Errors
/// What is wrong with the file.
pub fn report(source: &Source, surroundings: &dyn Surroundings, colour: bool) -> Result<(bool, String), String> {
    surroundings.begins(&format!("lint {}", source.name));
    let found = lint(source, |importer, path| surroundings.find(importer, path), &|| surroundings.interrupted());
    surroundings.ends();
    match found {
        Ok(found) => {
            let count = found.findings.len();
            let laws = if found.laws == 1 { "1 law".to_string() } else { format!("{} laws", found.laws) };
            let findings = match count {
                0 => "nothing found".to_string(),
                1 => "1 finding".to_string(),
                _ => format!("{count} findings"),
            };
            let text = if count == 0 { String::new() } else { render_all(&found.findings, source, colour) };
            Ok((count > 0, format!("{text}{}: {laws}, {findings}\n", source.name)))
        }
        Err(failures) => Err(failures.iter().map(|one| render_all(&one.diagnostics, &one.source, colour)).collect()),
    }
}

/// Reads a file without asking its laws to hold.
fn laws_of(source: &Source, find: impl FnMut(&str, &str) -> Result<Source, String>) -> Result<Read, Vec<Failure>> {
    let mut find = find;
    let mut environment = library::standard()?;
    let failure = |diagnostics| Failure { source: source.clone(), diagnostics };
    let parsed = parse(&source.text);
    if !parsed.diagnostics.is_empty() {
        return Err(vec![failure(parsed.diagnostics)]);
    }
    stand_aside(&mut environment, &parsed.items);
    let own = environment.laws.clone();
    let mut entries = Vec::new();
    let mut timeless = Vec::new();
    let mut failures = Vec::new();
    for segment in segments(&parsed.items) {
        if let [Item { kind: ItemKind::Import(_), span }] = segment {
            let import = Source::new(source.name.clone(), span.of(&source.text));
            let mut reader = Reader::new(|importer: &str, path: &str| match library::embedded(path) {
                // In force already.
                Some(source) => Ok(Source::new(source.name, "")),
                None => find(importer, path),
            });
            failures.extend(reader.read(&mut environment, &import, &mut |_, _, _, _| {}));
            continue;
        }
        let mut batch = environment.open(segment, &source.text);
        for (index, item) in segment.iter().enumerate() {
            match one(&mut environment, &mut batch, index, item) {
                Ok(entry) => entries.extend(entry),
                Err(diagnostics) if matches!(&item.kind, ItemKind::Law(_)) && diagnostics.iter().all(in_no_time) => {
                    let tamed = |one: Diagnostic| Diagnostic { severity: Severity::Warning, ..one };
                    let note = "a known trap: a loop that can go round in no time proves anything";
                    timeless.extend(diagnostics.into_iter().take(1).map(|one| tamed(one).note(note)));
                }
                Err(diagnostics) => failures.push(failure(diagnostics)),
            }
        }
    }
    if failures.is_empty() { Ok(Read { environment, own, entries, timeless }) } else { Err(failures) }
}

/// A file with most of the laws of one that is part of the program is looked at in its place.
fn stand_aside(environment: &mut Environment, items: &[Item]) {
    let here = names_of(items);
    for source in library::rules() {
        let own = names_of(&parse(&source.text).items);
        if 2 * own.intersection(&here).count() > own.len() {
            own.iter().for_each(|name| environment.laws = without(&environment.laws, name));
        }
    }
}

fn names_of(items: &[Item]) -> BTreeSet<Name> {
    items
        .iter()
        .filter_map(|item| if let ItemKind::Law(law) = &item.kind { Some(law.name.name.clone()) } else { None })
        .collect()
}

/// One item; a law that plainly loops is looked at without its direction.
fn one(
    environment: &mut Environment,
    batch: &mut crate::lower::Batch,
    index: usize,
    item: &Item,
) -> Result<Option<Entry>, Vec<Diagnostic>> {
    let entry = |lowered, looping| match lowered {
        Lowered::Law(law) => Some(Entry { law, span: item.span, looping }),
        _ => None,
    };
    let diagnostics = match environment.step(batch, index, item) {
        Ok(lowered) => return Ok(entry(lowered, None)),
        Err(diagnostics) => diagnostics,
    };
    match (&item.kind, diagnostics.as_slice()) {
        (ItemKind::Law(law), [only]) if only.code == LOOPS_PLAINLY => {
            let mut tame = law.clone();
            tame.oriented = false;
            let item = Item { span: item.span, kind: ItemKind::Law(tame) };
            let lowered = environment.step(batch, index, &item)?;
            Ok(entry(lowered, Some(only.clone())))
        }
        _ => Err(diagnostics),
    }
}

/// Whether a loop is refused because it goes round in no time.
fn in_no_time(diagnostic: &Diagnostic) -> bool {
    diagnostic.code == "P0602"
}

/// The code under which lowering refuses a law that fits its own right side again.
const LOOPS_PLAINLY: &str = "P0707";

/// Whether the law is refuted; then what contradicts it, whether it is a known trap, and what would mend it.
fn soundness(
    entry: &Entry,
    environment: &Environment,
    interrupted: &dyn Fn() -> bool,
    findings: &mut Vec<Diagnostic>,
) -> bool {
    let law = &entry.law;
    if law.left == law.right {
        let message = format!("the law `{}` says nothing: both sides are the same", law.name);
        findings.push(warning("P0924", message, entry.span).note(format!("both are {}", law.left)));
        return false;
    }
    let limits = Limits { instances: INSTANCES, choices: 50 * INSTANCES, ..Limits::default() };
    let found = match judge(law, &limits) {
        Refutation::Refuted(found) => found,
        none => {
            findings.extend(untried(law, &none).map(|message| {
                warning("P0924", message, entry.span)
                    .note("a loop that goes round in no time, for one, has no meaning: it would prove anything")
            }));
            return false;
        }
    };
    let mut finding = warning("P0906", format!("the law `{}` does not hold", law.name), entry.span);
    for line in run_lines(&found, law.connective) {
        finding = finding.note(line);
    }
    let theory = Theory { laws: environment.laws.clone(), ..Theory::default() };
    let statement = Statement {
        hypotheses: law.conditions.clone(),
        left: law.left.clone(),
        connective: law.connective,
        right: law.right.clone(),
    };
    let theory = Theory { laws: without(&theory.laws, &law.name), ..theory };
    if let Some(remedy) = remedies(&theory, &statement, interrupted).first() {
        let when: Vec<String> = remedy.conditions.iter().map(ToString::to_string).collect();
        let needs: Vec<String> = remedy.conditions.iter().map(in_words).collect();
        let then = if remedy.proved { "then the other laws prove it" } else { "then no small instance contradicts it" };
        finding = finding.help(format!("it needs {}: `when {}`; {then}", needs.join(", and "), when.join(", ")));
    }
    findings.push(finding);
    if let Some(trap) = trap::known(law) {
        let message = format!("the law `{}` is a known trap", law.name);
        let finding = warning("P0921", message, entry.span).note(format!("{} = {}", trap.left, trap.right));
        findings.push(finding.note(trap.title.clone()));
    }
    true
}

fn without(laws: &Laws, name: &Name) -> Laws {
    let mut kept = Laws::default();
    laws.iter().filter(|law| law.name != *name).for_each(|law| kept.push((**law).clone()));
    kept
}

/// Whether simplification goes on with the law, after those before it; then the terms it goes through.
fn looping(entry: &Entry, tame: &Laws, interrupted: &dyn Fn() -> bool, findings: &mut Vec<Diagnostic>) -> bool {
    let law = &entry.law;
    if let Some(diagnostic) = &entry.looping {
        let mut diagnostic = diagnostic.clone();
        diagnostic.severity = Severity::Warning;
        findings.push(diagnostic);
        return true;
    }
    if !law.oriented {
        return false;
    }
    let Some(term) = endless_term(tame, law, interrupted) else { return false };
    let mut finding = warning("P0903", format!("with the law `{}` simplification does not end", law.name), entry.span);
    finding = finding.note(format!("it goes from {term}"));
    for form in first_forms(tame, law, &term) {
        finding = finding.note(format!("to {form}"));
    }
    findings.push(finding.help("write `=` in place of `=>`: then it is used in proofs, but not to simplify"));
    true
}

/// The first forms that simplification goes through.
fn first_forms(tame: &Laws, law: &Law, term: &Term) -> Vec<String> {
    let never = || false;
    let mut laws = tame.clone();
    laws.push(law.clone());
    let theory = Theory { laws, ..Theory::default() };
    let context = Context::new(&theory.assumptions, &theory.definitions, &law.conditions);
    let mut forms: Vec<String> = Vec::new();
    for fuel in 1..12 {
        let form = Simplifier::new(&theory, &context, &never).with_fuel(fuel).simplify(term).term.to_string();
        if forms.last() != Some(&form) && form != term.to_string() {
            forms.push(crate::report::abbreviated(&form));
        }
        if forms.len() >= 3 {
            break;
        }
    }
    forms
}

fn warning(code: &'static str, message: String, span: Span) -> Diagnostic {
    Diagnostic::warning(code, message).label(span, "this law")
}
