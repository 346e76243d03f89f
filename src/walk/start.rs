//! Where a walk starts: the declarations of a file, and a process of them.

use super::{Origin, Walk};
use crate::ast::{Expect, ItemKind};
use crate::definition::Definitions;
use crate::diagnostic::{Diagnostic, Source, nearest, render_all};
use crate::lexer::lex;
use crate::library::{self, Failure, Reader};
use crate::lower::{Entity, Environment};
use crate::name::Name;
use crate::parser::{parse, parse_term};
use crate::sample::{Closed, close, reached};
use crate::scope::subterms;
use crate::stepper::{Route, Stepper};
use crate::term::{Node, Term};
use crate::value::Value;

/// What a file declares, with all that it imports; nothing in it is proved or admitted.
///
/// # Errors
/// What is wrong in it.
pub fn declarations(
    source: &Source,
    find: impl FnMut(&str, &str) -> Result<Source, String>,
) -> Result<Environment, Vec<Failure>> {
    let mut find = find;
    let mut environment = library::standard()?;
    let mut reader = Reader::new(move |importer: &str, path: &str| match library::embedded(path) {
        // In force already.
        Some(source) => Ok(Source::new(source.name, "")),
        None => find(importer, path),
    });
    let failures = reader.read(&mut environment, source, &mut |_, _, _, _| {});
    if failures.is_empty() { Ok(environment) } else { Err(failures) }
}

/// The process that is meant when none is named: the only system, or the only process without parameters.
///
/// # Errors
/// What there is to choose from.
pub fn only_process(environment: &Environment) -> Result<String, String> {
    let mut systems = Vec::new();
    let mut processes = Vec::new();
    let mut all = Vec::new();
    for (name, entity) in environment.entities() {
        match entity {
            Entity::System(_) => systems.push(name.to_string()),
            Entity::Process(signature) if signature.parameters.is_empty() => processes.push(name.to_string()),
            Entity::Process(signature) => {
                let parameters: Vec<&str> = signature.parameters.iter().map(Name::as_str).collect();
                all.push(format!("{name}_{{{}}}", parameters.join(",")));
            }
            _ => {}
        }
    }
    match (systems.as_slice(), processes.as_slice()) {
        ([one], _) | ([], [one]) => Ok(one.clone()),
        ([], []) if all.is_empty() => Err("no process is declared there".to_string()),
        _ => {
            let all: Vec<String> = systems.into_iter().chain(processes).chain(all).collect();
            Err(format!("say which process: {}", all.join(", ")))
        }
    }
}

impl Walk {
    /// At the start of a process, named or written out, perhaps with values: `Sys with t = 1, a = 3`.
    ///
    /// # Errors
    /// What is wrong with it, as text.
    pub fn new(environment: &Environment, text: &str, origin: Origin, colour: bool) -> Result<Walk, String> {
        let (subject, given) = split(text);
        let values = match given {
            None => Vec::new(),
            Some(given) => assignments(environment, given, colour)?,
        };
        let term = subject_term(environment, subject.trim(), colour)?;
        let Closed { term, definitions, values } =
            close(&term, environment, &values).map_err(|why| format!("{why}\n"))?;
        let stepper = Stepper::new(&term, &definitions)
            .map_err(|error| format!("`{}` has no meaning: {error}\n", subject.trim()))?;
        let environment = environment.clone();
        let subject = subject.trim().to_string();
        Ok(Walk { stepper, environment, origin, subject, term, values, asked: None, colour, orders: Vec::new() })
    }

    /// Along the steps of a route, as far as they are possible; each can be undone.
    ///
    /// # Errors
    /// Why its process has no meaning, as text.
    pub fn along(environment: &Environment, route: &Route, colour: bool) -> Result<Walk, String> {
        let mut definitions = Definitions::default();
        for name in reached(&route.term, &route.definitions) {
            if let Some(definition) = route.definitions.get(&name) {
                definitions.insert(definition.clone());
            }
        }
        let subject = route.term.to_string();
        let mut stepper = Stepper::new(&route.term, &definitions)
            .map_err(|error| format!("`{subject}` has no meaning: {error}\n"))?;
        for choice in &route.choices {
            if stepper.step(choice.clone()).is_err() {
                break;
            }
        }
        let environment = with_observers(environment, &route.term);
        let (term, origin) = (route.term.clone(), Origin::Prompt);
        let (values, orders) = (Vec::new(), Vec::new());
        Ok(Walk { stepper, environment, origin, subject, term, values, asked: None, colour, orders })
    }
}

/// With the observers of a process declared that were made up for it.
fn with_observers(environment: &Environment, term: &Term) -> Environment {
    let mut environment = environment.clone();
    for part in subterms(term) {
        let Node::Observe(name, values) = part.node() else { continue };
        if environment.entity(name).is_none() {
            let names: Vec<String> = (1..=values.len()).map(|number| format!("x{number}")).collect();
            let parameters = if names.is_empty() { String::new() } else { format!("({})", names.join(", ")) };
            let text = format!("observer {name}{parameters}");
            environment.declare(&parse(&text).items, &text);
        }
    }
    environment
}

/// What stands before and behind the word `with`.
fn split(text: &str) -> (&str, Option<&str>) {
    let tokens = lex(text).tokens;
    match tokens.iter().find(|token| token.span.of(text) == "with") {
        Some(token) => (text.get(..token.span.start).unwrap_or(""), text.get(token.span.end..)),
        None => (text, None),
    }
}

fn render(diagnostics: &[Diagnostic], text: &str, colour: bool) -> String {
    render_all(diagnostics, &Source::new("<step>", text), colour)
}

/// The values for parameters in a text such as `t = 1, a = 3`.
///
/// # Errors
/// What is wrong with it, as text.
pub fn assignments(environment: &Environment, text: &str, colour: bool) -> Result<Vec<(Name, Value)>, String> {
    // The same form as behind `expect`.
    let written = format!("expect {}", text.trim());
    let parsed = parse(&written);
    if !parsed.diagnostics.is_empty() {
        return Err(render(&parsed.diagnostics, &written, colour));
    }
    let [crate::ast::Item { kind: ItemKind::Expect(Expect::Values(values)), .. }] = parsed.items.as_slice() else {
        return Err("write the values behind `with` as in `with t = 1, a = 3`\n".to_string());
    };
    let one = |(name, value): &(crate::ast::Ident, crate::ast::Value)| {
        let value = environment.value(value).map_err(|errors| render(&errors, &written, colour))?;
        Ok((name.name.clone(), value))
    };
    values.iter().map(one).collect()
}

fn subject_term(environment: &Environment, text: &str, colour: bool) -> Result<Term, String> {
    if text.is_empty() {
        return Err("say what to step: a process, or the name of a system\n".to_string());
    }
    if let Some(system) = environment.system(&Name::new(text)) {
        return Ok(system.term(&environment.definitions));
    }
    let plain = text.chars().all(char::is_alphanumeric) && text.starts_with(char::is_uppercase);
    let basic = crate::lower::BASIC.contains(&text);
    if plain && !basic && environment.entity(&Name::new(text)).is_none() {
        let known = environment.entities().map(|(name, _)| name.as_str());
        let near = nearest(text, known).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
        return Err(format!("there is no process or system `{text}`{near}\n"));
    }
    let written = parse_term(text).map_err(|errors| render(&errors, text, colour))?;
    environment.term(&written).map_err(|errors| render(&errors, text, colour))
}
