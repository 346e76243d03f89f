//! `pars lts` and `pars compare`: transition systems from files and processes, and what tells them apart.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use clap::ValueEnum;
use serde_json::{Value as Json, json};

use crate::definition::Definitions;
use crate::diagnostic::{Diagnostic, Source, Span, render_all};
use crate::equivalence::{Evidence, Preorder, Verdict, compare, minimised_system, strong_classes, system_of};
use crate::library::{self, Failure, Reader};
use crate::lower::{Entity, Environment};
use crate::name::Name;
use crate::parser::parse_term;
use crate::progress::Watch;
use crate::report::worse;
use crate::sample::close;
use crate::script::{Printer, World, complain, read_file, read_input};
use crate::session::{Surroundings, evidence_lines};
use crate::term::Term;
use crate::transition_system::{
    Bounds, MOST_DRAWN, TransitionSystem, aut, dot, json as as_json, look, summary, svg, told,
};
use crate::walk::assignments;

/// How a system is written.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// A summary for people.
    Text,
    /// Aldebaran, which other tools read.
    Aut,
    /// Graphviz.
    Dot,
    /// JSON.
    Json,
    /// A picture.
    Svg,
}

/// What `pars lts` is asked for.
pub(super) struct Request {
    pub(super) file: PathBuf,
    pub(super) term: Option<String>,
    pub(super) with: Option<String>,
    pub(super) format: Format,
    pub(super) minimise: bool,
    pub(super) bound: Option<usize>,
    pub(super) memory: Option<usize>,
    pub(super) output: Option<PathBuf>,
}

/// What is wrong with an input, as it is shown; the exit code is 3.
pub(super) type Refused = String;

fn bounds(states: Option<usize>, memory: Option<usize>) -> Bounds {
    let usual = Bounds::default();
    Bounds {
        states: states.unwrap_or(usual.states),
        bytes: memory.map_or(usual.bytes, |megabytes| megabytes.saturating_mul(1 << 20)),
    }
}

/// The names of the relations, for the help of the command line.
pub(super) fn relation(name: &str) -> Result<Preorder, String> {
    let names: Vec<&str> = Preorder::ALL.iter().map(|(_, name)| *name).collect();
    Preorder::of(name).ok_or_else(|| format!("the relations are {}", names.join(", ")))
}

pub(super) fn read(path: &Path, colour: bool) -> Result<Source, Refused> {
    let read = if path.as_os_str() == "-" { read_input() } else { read_file(path) };
    read.map_err(|trouble| format!("{}\n", trouble.1.render(&trouble.0, colour)))
}

/// The system of a file; in an error the exit code comes first.
fn aut_file(source: &Source, bytes: usize, colour: bool) -> Result<TransitionSystem, (u8, Refused)> {
    if let Some(need) = aut::need(&source.text).map(|need| need.saturating_add(source.text.len()))
        && need > bytes
    {
        let (most, need) = (bytes >> 20, need.div_ceil(1 << 20));
        return Err((
            4,
            format!("unknown: {most} MiB of memory are not enough for `{}`, which takes {need} MiB\n", source.name),
        ));
    }
    aut::read(&source.text).map_err(|wrong| {
        let place = Span::new(wrong.offset, wrong.offset);
        let text = format!("line {}, column {}: {}", wrong.line, wrong.column, wrong.what);
        let diagnostic = Diagnostic::error("P0925", text)
            .label(place, "here")
            .help("a system is written `des (0, 1, 2)`, then a transition a line: `(0, \"a\", 1)`");
        (3, format!("{}\n", diagnostic.render(source, colour)))
    })
}

/// What a file declares, its claims left aside.
pub(super) fn declared(source: &Source, watch: &Rc<Watch>, colour: bool) -> Result<Environment, Refused> {
    let shown = |failures: Vec<Failure>| -> Refused {
        failures.iter().map(|failure| render_all(&failure.diagnostics, &failure.source, colour)).collect()
    };
    let mut environment = library::standard().map_err(shown)?;
    let world = World::new(watch.clone());
    let mut reader = Reader::new(move |importer: &str, path: &str| match library::embedded(path) {
        Some(source) => Ok(Source::new(source.name, "")),
        None => world.find(importer, path),
    });
    let failures = reader.read(&mut environment, source, &mut |_, _, _, _| {});
    if failures.is_empty() { Ok(environment) } else { Err(shown(failures)) }
}

/// The process that is meant: a system by its name, any closed process, or the only system that there is.
fn meant(environment: &Environment, term: Option<&str>, colour: bool) -> Result<Term, Refused> {
    let systems: Vec<&Name> = environment
        .entities()
        .filter(|(_, entity)| matches!(entity, Entity::System(_)))
        .map(|(name, _)| name)
        .collect();
    let Some(text) = term else {
        return match systems.as_slice() {
            [name] => Ok(system(environment, name)),
            [] => Err("the file declares no system: say which process, `pars lts FILE 'P ; Q'`\n".to_string()),
            names => {
                let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
                Err(format!("the file declares several systems; say which: {}\n", names.join(", ")))
            }
        };
    };
    if let Some(name) = systems.iter().find(|name| name.as_str() == text.trim()) {
        return Ok(system(environment, name));
    }
    let lowered = parse_term(text).and_then(|term| environment.term(&term));
    lowered.map_err(|diagnostics| render_all(&diagnostics, &Source::new("<process>", text), colour))
}

fn system(environment: &Environment, name: &Name) -> Term {
    environment.system(name).map_or_else(Term::stop, |system| system.term(&environment.definitions))
}

/// Makes a system and writes it; gives the exit code: 4 if a bound was hit.
pub(super) fn lts(request: &Request, watch: &Rc<Watch>, colour: bool) -> u8 {
    watch.begins("the transition system");
    let made = make(request, watch, colour);
    watch.ends();
    let (system, states) = match made {
        Ok(made) => made,
        Err((code, text)) => {
            complain(&text);
            return code;
        }
    };
    let text = match request.format {
        Format::Text => {
            let mut lines = summary(&system);
            lines.extend(told(&system, &|state| states(state).unwrap_or_else(|| look(system.mark(state)))));
            lines.iter().map(|line| format!("{line}\n")).collect()
        }
        Format::Aut => aut::write(&system),
        Format::Dot => dot(&system),
        Format::Json => format!("{}\n", as_json(&system)),
        Format::Svg => match svg(&system) {
            Some(text) => text,
            None => {
                let states = system.states();
                complain(&format!(
                    "{states} states are too many to draw, at most {MOST_DRAWN} are: try `--minimise`, or a smaller \
                     process\n"
                ));
                return 4;
            }
        },
    };
    match &request.output {
        None => Printer::default().print(&text),
        Some(path) => {
            if let Err(trouble) = written(path, &text) {
                complain(&trouble);
                return 3;
            }
        }
    }
    match system.cut {
        None => 0,
        Some(cut) => {
            complain(&format!("not the whole system: {cut}\n"));
            4
        }
    }
}

/// Writes a file.
pub(super) fn written(path: &Path, text: &str) -> Result<(), Refused> {
    std::fs::write(path, text).map_err(|error| format!("`{}` cannot be written: {error}\n", path.display()))
}

type Names = Box<dyn Fn(u32) -> Option<String>>;

fn make(request: &Request, watch: &Rc<Watch>, colour: bool) -> Result<(TransitionSystem, Names), (u8, Refused)> {
    let wrong = |text: Refused| (3, text);
    let source = read(&request.file, colour).map_err(wrong)?;
    let unnamed: Names = Box::new(|_| None);
    let stop = || watch.interrupted();
    let bounds = bounds(request.bound, request.memory);
    let script = request.file.extension().is_some_and(|extension| extension == "pars" || extension == "rules");
    if !script {
        if request.term.is_some() {
            return Err(wrong("a process belongs to a `.pars` file; an `.aut` file is a system itself\n".to_string()));
        }
        let system = aut_file(&source, bounds.bytes, colour)?;
        if !request.minimise {
            return Ok((system, unnamed));
        }
        let Some(classes) = strong_classes(&system, bounds.bytes) else {
            let (most, states) = (bounds.bytes >> 20, system.states());
            return Err((4, format!("unknown: {most} MiB of memory are not enough to minimise {states} states\n")));
        };
        return Ok((system.quotient(&classes, false).reachable(), unnamed));
    }
    let environment = declared(&source, watch, colour).map_err(wrong)?;
    let term = meant(&environment, request.term.as_deref(), colour).map_err(wrong)?;
    let (term, definitions) = instance(&term, &environment, request.with.as_deref(), colour).map_err(wrong)?;
    let refuse = |trouble| wrong(format!("this process has no transition system: {trouble}\n"));
    if request.minimise {
        let (system, _) = minimised_system(&term, &definitions, &bounds, &stop).map_err(refuse)?;
        return Ok((system, unnamed));
    }
    let found = system_of(&term, &definitions, &bounds, &stop).map_err(refuse)?;
    let states = found.states;
    let named: Names = Box::new(move |state| states.get(state as usize).map(|state| state.term().to_string()));
    Ok((found.system, named))
}

/// The process with values for its parameters: those given, and for the others small ones, which are said.
fn instance(
    term: &Term,
    environment: &Environment,
    with: Option<&str>,
    colour: bool,
) -> Result<(Term, Definitions), Refused> {
    let given = with.map_or(Ok(Vec::new()), |text| assignments(environment, text, colour))?;
    let closed = close(term, environment, &given).map_err(|why| format!("{why}\n"))?;
    let chosen = closed.values.iter().filter(|(_, _, chosen)| *chosen);
    let chosen: Vec<String> = chosen.map(|(name, value, _)| format!("{name} = {value}")).collect();
    if let Some(first) = chosen.first() {
        complain(&format!("take {}; others are given by `--with \"{first}\"`\n", chosen.join(", ")));
    }
    Ok((closed.term, closed.definitions))
}

/// Compares two files; gives the exit code: 0 yes, 1 no, 4 unknown.
pub(super) fn compare_files(
    files: [&Path; 2],
    relation: Preorder,
    memory: Option<usize>,
    json: bool,
    watch: &Rc<Watch>,
    colour: bool,
) -> u8 {
    let bounds = bounds(None, memory);
    let load = |path: &Path| {
        let source = read(path, colour).map_err(|text| (3, text))?;
        aut_file(&source, bounds.bytes, colour)
    };
    let (left, right) = match (load(files[0]), load(files[1])) {
        (Ok(left), Ok(right)) => (left, right),
        (left, right) => {
            let errors: Vec<(u8, Refused)> = [left.err(), right.err()].into_iter().flatten().collect();
            let code = errors.iter().fold(0, |worst, (code, _)| worse(worst, *code));
            if code != 4 {
                errors.iter().for_each(|(_, text)| complain(text));
                return code;
            }
            let texts: Vec<&str> = errors.iter().map(|(_, text)| text.trim_end()).collect();
            let names = files.map(|path| path.display().to_string());
            let object = json!({ "files": names, "kind": relation.name(), "verdict": "unknown", "trace": texts });
            let text = if json { object.to_string() } else { texts.join("\n") };
            Printer::default().print(&format!("{text}\n"));
            return code;
        }
    };
    watch.begins("the comparison");
    let verdict = compare(&left, &right, relation, &bounds, &|| watch.interrupted());
    watch.ends();
    let sizes = format!("{} and {} states", left.states(), right.states());
    let (code, word, lines) = match &verdict {
        Verdict::Yes => (0, "yes", vec![format!("yes: {} ({sizes})", relation.says(true))]),
        Verdict::No(evidence) => {
            let mut lines = vec![format!("no: {} ({sizes})", relation.says(false))];
            lines.extend(evidence_lines(evidence, &|_, state| state.to_string()));
            (1, "no", lines)
        }
        Verdict::Unknown(why) => (4, "unknown", vec![format!("unknown: {why}")]),
    };
    let text = if json {
        format!("{}\n", answer_json(files, relation, word, &verdict, &lines))
    } else {
        lines.iter().map(|line| format!("{line}\n")).collect()
    };
    Printer::default().print(&text);
    code
}

fn answer_json(files: [&Path; 2], relation: Preorder, word: &str, verdict: &Verdict, lines: &[String]) -> Json {
    let names = files.map(|path| path.display().to_string());
    let mut object = json!({ "files": names, "kind": relation.name(), "verdict": word, "trace": lines });
    if let (Verdict::No(evidence), Some(map)) = (verdict, object.as_object_mut()) {
        map.insert("formula".into(), json!(evidence.formula(1 << 20)));
        map.insert("holds".into(), json!(if evidence.holds_left { "left" } else { "right" }));
        map.insert("run".into(), json!(run_json(evidence)));
    }
    object
}

fn run_json(evidence: &Evidence) -> Vec<Json> {
    let side = |left: bool| if left { "left" } else { "right" };
    let step = |step: &crate::equivalence::RunStep| {
        json!({
            "side": side(step.left_moves), "label": step.label.to_string(), "left": step.left, "right": step.right,
        })
    };
    evidence.run.iter().map(step).collect()
}
