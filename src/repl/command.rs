//! Commands: `:help`, `:why`, …; the shortest prefix that fits one of them alone will do.

use std::path::Path;

use super::help;
use super::prompt::Prompt;
use crate::diagnostic::nearest;
use crate::explain::{Chain, Why};
use crate::latex;
use crate::law::{Law, Laws};
use crate::lower::{Entity, Quantity};
use crate::mark::marked;
use crate::name::Name;
use crate::report::{Output, abbreviated};
use crate::script::read_file;
use crate::session::delays::MOST_ORDERS;
use crate::session::print::flow_for_print;

/// The commands with what may follow them and what they do.
pub const COMMANDS: [(&str, &str, &str); 15] = [
    ("help", "[topic]", "what can be typed; more about one topic"),
    ("why", "[claim]", "the proof of the last claim, or of the one with this number or name, line by line"),
    ("laws", "[word]", "the laws in force, or those that mention a word"),
    ("law", "name", "one law in full"),
    ("show", "[name]", "what a name stands for; all that was declared"),
    ("undo", "", "back to before the last input"),
    ("back", "number", "back to after the input with this number, as `:undo` tells it"),
    ("load", "file", "run a script here"),
    ("save", "file", "write the inputs so far as a script"),
    ("proof", "file [claim]", "write the proof of a claim to a file, which `pars check` checks"),
    (
        "latex",
        "[file] [claim]",
        "a proof for print, with its laws, into a file as a document; `flow Sys`: the phases of a system",
    ),
    ("lint", "file", "what is wrong with the laws of a rule file, or unwise; `lint \"file\"` does the same"),
    ("exercise", "[name]", "do an exercise of those that were read; without a name, lists them"),
    (
        "step",
        "[process] [with t = 1]",
        "run a process by hand, step by step; alone, along the last counterexample (`left`, `right`)",
    ),
    ("quit", "", "leave; Ctrl-D does the same"),
];

/// The command that a word means: its name, or a prefix that no other has.
fn resolve(word: &str) -> Result<&'static str, String> {
    let fits: Vec<&str> = COMMANDS.iter().map(|(name, ..)| *name).filter(|name| name.starts_with(word)).collect();
    if let Some(exact) = fits.iter().find(|name| **name == word) {
        return Ok(exact);
    }
    match fits.as_slice() {
        [one] => Ok(one),
        [] => Err(match nearest(word, COMMANDS.iter().map(|(name, ..)| *name)) {
            Some(name) => format!("there is no command `:{word}`; did you mean `:{name}`?\n"),
            None => format!("there is no command `:{word}`; `:help` lists them\n"),
        }),
        _ => Err(format!(
            "`:{word}` may be {}\n",
            fits.iter().map(|name| format!(":{name}")).collect::<Vec<_>>().join(", ")
        )),
    }
}

/// Whether a line `:word …` is a command.
pub(super) fn known(line: &str) -> bool {
    let word = line.trim_start_matches(':').split_whitespace().next().unwrap_or_default();
    resolve(word).is_ok()
}

/// Runs a command; true if it is the wish to leave.
pub(super) fn run(prompt: &mut Prompt, line: &str) -> bool {
    let line = line.trim();
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let name = match resolve(word) {
        Ok(name) => name,
        Err(why) => {
            prompt.print(&why);
            return false;
        }
    };
    let text = match name {
        "quit" => return true,
        "help" => help::help(rest),
        "why" => why(prompt, rest),
        "laws" => laws(&prompt.session().environment().laws, rest),
        "law" => law(&prompt.session().environment().laws, rest),
        "show" => show(prompt, rest),
        "undo" if prompt.undo() => format!("back at {}\n", prompt.session().number()),
        "undo" => "there is nothing to undo\n".to_string(),
        "back" => back(prompt, rest.trim()),
        "load" => {
            load(prompt, rest);
            String::new()
        }
        "save" => save(prompt, rest),
        "latex" => latex(prompt, rest),
        "lint" => lint(prompt, rest),
        "exercise" => {
            prompt.exercise(rest);
            String::new()
        }
        "step" => {
            prompt.walk(rest);
            String::new()
        }
        _ => proof(prompt, rest),
    };
    prompt.print(&text);
    false
}

fn why(prompt: &Prompt, which: &str) -> String {
    let session = prompt.session();
    if let Some(lines) = session.induction().filter(|_| which.is_empty()) {
        return lines.iter().map(|line| format!("    {line}\n")).collect();
    }
    let Some(record) = session.record(which) else {
        return if which.is_empty() {
            "nothing was claimed or solved yet\n".into()
        } else {
            format!("there is no claim `{which}`\n")
        };
    };
    let mut text = String::new();
    if let Some(name) = &record.stale {
        text.push_str(&format!("stale: this was settled with an earlier definition of {name}\n"));
    }
    match &record.evidence {
        Some(evidence) => text.push_str(&chain(&evidence.chain(), &evidence.theory.laws, prompt.colour())),
        None => {
            text.push_str(&Output::Claim(Box::new(record.report.clone())).text(false));
            text.push_str("there is no proof to show\n");
        }
    }
    text
}

/// A proof as a calculation, in which only what changed is marked.
fn chain(chain: &Chain, laws: &Laws, colour: bool) -> String {
    let mut text = format!("    {}\n", abbreviated(&chain.start.to_string()));
    let mut before = &chain.start;
    for line in &chain.lines {
        let title = match &line.why {
            Why::Law(name) => laws.get(name).map(|law| format!(": {}", law.title)).unwrap_or_default(),
            _ => String::new(),
        };
        let direction = if line.backwards { ", from right to left" } else { "" };
        text.push_str(&format!("{} {{{}{direction}}}{title}\n", line.connective, line.why));
        text.push_str(&format!("    {}\n", marked(before, &line.term).shown(colour)));
        before = &line.term;
    }
    if chain.lines.is_empty() {
        text.push_str("  both sides are the same process: `;`, `|` and `#` need no brackets, `|` and `#` no order\n");
    }
    if chain.cut {
        text.push_str("… and so on\n");
    }
    text
}

/// What is found in the laws of a file.
pub(super) fn lint(prompt: &Prompt, path: &str) -> String {
    let path = path.trim_matches('"');
    if path.is_empty() {
        return "write `:lint file`\n".to_string();
    }
    match read_file(Path::new(path)) {
        Ok(source) => match crate::lint::report(&source, prompt.session().surroundings(), prompt.colour()) {
            Ok((_, text)) | Err(text) => text,
        },
        Err(trouble) => trouble.1.render(&trouble.0, prompt.colour()) + "\n",
    }
}

/// A proof in LaTeX: here, or as a document into a file.
fn latex(prompt: &Prompt, rest: &str) -> String {
    let (first, second) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    let session = prompt.session();
    if let ("flow", name) = (first, second.trim())
        && !name.is_empty()
    {
        return flow_of(prompt, name);
    }
    // One word is the name of a claim, if there is such a claim.
    let alone = second.is_empty() && (first.is_empty() || session.record(first).is_some());
    let (path, which) = if alone { ("", first) } else { (first, second.trim()) };
    let Some(record) = session.record(which) else { return format!("there is no claim `{which}`\n") };
    let Some(evidence) = &record.evidence else { return "there is no proof to write\n".to_string() };
    let (chain, laws) = (evidence.chain(), &evidence.theory.laws);
    if path.is_empty() {
        return latex::derivation(&chain, laws);
    }
    match std::fs::write(path, latex::document(&record.report.claim, &chain, laws)) {
        Ok(()) => format!("written to `{path}`\n"),
        Err(error) => format!("`{path}` cannot be written: {error}\n"),
    }
}

/// Forgets inputs until so many are left.
fn back(prompt: &mut Prompt, number: &str) -> String {
    let here = prompt.session().number();
    match number.parse::<usize>() {
        Ok(number) if number <= here => {
            while prompt.session().number() > number && prompt.undo() {}
            format!("back at {}\n", prompt.session().number())
        }
        _ => format!("`:back` takes the number of an input, from 0 to {here}; `:undo` goes back by one\n"),
    }
}

/// The phases of a system in LaTeX.
fn flow_of(prompt: &Prompt, name: &str) -> String {
    let session = prompt.session();
    let environment = session.environment();
    let Some(system) = environment.system(&Name::new(name)) else { return format!("there is no system `{name}`\n") };
    let interrupted = || session.surroundings().interrupted();
    flow_for_print(system, environment, MOST_ORDERS, &interrupted)
        .unwrap_or_else(|failures| failures.iter().map(|failure| format!("{failure}\n")).collect())
}

fn laws(laws: &Laws, word: &str) -> String {
    let wanted = word.to_lowercase();
    let fits = |law: &Law| word.is_empty() || law.to_string().to_lowercase().contains(&wanted);
    let lines: Vec<String> =
        laws.iter().filter(|law| fits(law)).map(|law| format!("{:<18} {}\n", law.name.as_str(), law.title)).collect();
    if lines.is_empty() { format!("no law mentions `{word}`\n") } else { lines.concat() }
}

fn law(laws: &Laws, name: &str) -> String {
    match laws.get(&Name::new(name)) {
        Some(law) => format!("{law}\n"),
        None => match nearest(name, laws.iter().map(|law| law.name.as_str())) {
            Some(other) => format!("there is no law `{name}`; did you mean `{other}`?\n"),
            None => format!("there is no law `{name}`; `:laws` lists them\n"),
        },
    }
}

fn show(prompt: &Prompt, name: &str) -> String {
    let environment = prompt.session().environment();
    if name.is_empty() {
        let entities = environment.entities().map(|(name, _)| one(prompt, name));
        let quantities = environment.quantities().map(|(name, _)| one(prompt, name));
        let assumed = environment.assumptions.iter();
        let assumed = assumed.map(|(relation, value)| format!("assumed: {value} {} 0\n", relation.symbol()));
        let all: String = entities.chain(quantities).chain(assumed).chain([prompt.waiting()]).collect();
        return all;
    }
    let found = one(prompt, &Name::new(name));
    if !found.is_empty() {
        return found;
    }
    if environment.laws.get(&Name::new(name)).is_some() {
        return law(&environment.laws, name);
    }
    if let Some(record) = prompt.session().record(name) {
        let stale = record.stale.as_ref().map(|name| format!("stale since {name} was defined anew\n"));
        return Output::Claim(Box::new(record.report.clone())).text(false) + &stale.unwrap_or_default();
    }
    let known = environment.entities().map(|(name, _)| name.as_str());
    match nearest(name, known.chain(environment.quantities().map(|(name, _)| name.as_str()))) {
        Some(other) => format!("nothing is named `{name}`; did you mean `{other}`?\n"),
        None => format!("nothing is named `{name}`\n"),
    }
}

/// What a name stands for; empty when it is not declared.
fn one(prompt: &Prompt, name: &Name) -> String {
    let environment = prompt.session().environment();
    let joined = |names: &[Name]| names.iter().map(Name::as_str).collect::<Vec<_>>().join(", ");
    match (environment.entity(name), environment.quantity(name)) {
        (Some(Entity::Process(_)), _) => {
            environment.definitions.get(name).map(|definition| format!("{definition}\n")).unwrap_or_default()
        }
        (Some(Entity::Observer(0)), _) => format!("observer {name}\n"),
        (Some(Entity::Observer(count)), _) => {
            let names: Vec<String> = (1..=*count).map(|number| format!("x{number}")).collect();
            format!("observer {name}({})\n", names.join(", "))
        }
        (Some(Entity::System(system)), _) => {
            let parts: Vec<String> = system.components.iter().map(ToString::to_string).collect();
            format!("system {name} = {}\n", parts.join(" | "))
        }
        (Some(Entity::Property(property)), _) => match &property.body {
            Some(body) => format!("property {name} = {body}\n"),
            None => format!("property {name}: its definition has errors\n"),
        },
        (None, Some(Quantity::Parameter { constant: Some(value), .. })) => format!("param {name} = {value}\n"),
        (None, Some(Quantity::Parameter { .. })) => format!("param {name}\n"),
        (None, Some(Quantity::Function { parameters, body: Some(body) })) => {
            format!("fn {name}({}) = {body}\n", joined(parameters))
        }
        (None, Some(Quantity::Function { parameters, body: None })) => format!("fn {name}({})\n", joined(parameters)),
        (None, None) => String::new(),
    }
}

fn load(prompt: &mut Prompt, path: &str) {
    if path.is_empty() {
        prompt.print("write `:load file`\n");
        return;
    }
    match read_file(Path::new(path)) {
        Ok(source) => {
            let input = format!("import \"{path}\"");
            prompt.run(&input, |session, emit| session.run(&source, emit));
        }
        Err(trouble) => {
            let (source, diagnostic) = *trouble;
            prompt.print(&Output::Trouble(source, vec![diagnostic]).text(false));
        }
    }
}

fn save(prompt: &Prompt, path: &str) -> String {
    if path.is_empty() {
        return "write `:save file`\n".to_string();
    }
    let text: String = prompt.inputs().iter().map(|input| format!("{}\n", as_item(input))).collect();
    match std::fs::write(path, text) {
        Ok(()) => format!("{} inputs written to `{path}`\n", prompt.inputs().len()),
        Err(error) => format!("`{path}` cannot be written: {error}\n"),
    }
}

/// A term alone is a question in a script only with its keyword.
fn as_item(input: &str) -> String {
    let alone = crate::parser::parse(input);
    if alone.diagnostics.is_empty() { input.to_string() } else { format!("simplify {input}") }
}

fn proof(prompt: &Prompt, rest: &str) -> String {
    let (path, which) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    if path.is_empty() {
        return "write `:proof file`\n".to_string();
    }
    let session = prompt.session();
    let Some(evidence) = session.record(which.trim()).and_then(|record| record.evidence.as_ref()) else {
        return "there is no such proof\n".to_string();
    };
    let written = session.proof_file(evidence);
    match written.and_then(|text| std::fs::write(path, text).map_err(|error| error.to_string())) {
        Ok(()) => format!("written to `{path}`\n"),
        Err(error) => format!("`{path}` cannot be written: {error}\n"),
    }
}
