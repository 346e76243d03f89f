//! `pars step`: a run by hand, typed at a terminal or read from standard input, or taken again from a file.

use std::io::{BufRead, IsTerminal};
use std::path::Path;
use std::rc::Rc;

use crate::diagnostic::{Source, render_all};
use crate::library::Failure;
use crate::progress::Watch;
use crate::repl;
use crate::script::{Printer, World, complain, opened};
use crate::session::Surroundings;
use crate::stepper::LoadError;
use crate::walk::{Origin, Saved, Walk, declarations, only_process, saved};

/// Steps a process of a file; gives the exit code: 0 all steps were possible, 1 one was not, 3 bad input.
pub(super) fn step(file: Option<&Path>, name: Option<&str>, with: Option<&str>, watch: Rc<Watch>, colour: bool) -> u8 {
    let source = match file {
        None => Source::new("<prompt>", ""),
        Some(path) => match opened(path, colour) {
            Some(source) => source,
            None => return 3,
        },
    };
    let origin = file.map_or(Origin::Prompt, |path| Origin::File(path.to_path_buf()));
    let walk = begin(&source, name, with, origin, watch, colour);
    match walk {
        Ok(walk) if std::io::stdin().is_terminal() => repl::walk(walk, colour),
        Ok(walk) => piped(walk),
        Err(why) => {
            complain(&why);
            3
        }
    }
}

/// Takes the steps of a trace again; gives the exit code: 0 all were possible, 1 one was not, 3 bad input.
pub(super) fn replay(trace: &Path, watch: Rc<Watch>, colour: bool) -> u8 {
    let Some(source) = opened(trace, colour) else { return 3 };
    let trace = saved(&source.text);
    let Some(start) = &trace.start else {
        complain(&format!("`{}` does not say what the run is of: no line begins with `start`\n", source.name));
        return 3;
    };
    let head = Source::new(source.name.clone(), trace.head.clone());
    match begin(&head, Some(start), None, Origin::Prompt, watch, colour) {
        Ok(walk) => again(walk, &trace, &source.name),
        Err(why) => {
            complain(&why);
            3
        }
    }
}

fn again(mut walk: Walk, trace: &Saved, name: &str) -> u8 {
    let mut printer = Printer::default();
    match walk.replay(trace) {
        Ok(()) => {
            printer.print(&format!(
                "{name}: all {} steps taken\n{}",
                walk.run().trace().len(),
                walk.answer("moves").text
            ));
            0
        }
        Err(error) => {
            printer.print(&format!("{}{}", walk.answer("trace").text, walk.answer("moves").text));
            let (line, why) = match &error {
                LoadError::Unreadable(line, _) => (line, "unreadable"),
                LoadError::Impossible(line, _) => (line, "no longer possible"),
            };
            let taken = walk.run().trace().len();
            let steps = if taken == 1 { "step" } else { "steps" };
            complain(&format!("{name}:{line}: {why} after {taken} {steps}: {error}\n"));
            if matches!(error, LoadError::Unreadable(..)) { 3 } else { 1 }
        }
    }
}

fn begin(
    source: &Source,
    name: Option<&str>,
    with: Option<&str>,
    origin: Origin,
    watch: Rc<Watch>,
    colour: bool,
) -> Result<Walk, String> {
    let world = World::new(watch);
    let environment = declarations(source, |importer, path| world.find(importer, path)).map_err(|failures| {
        let text = |failure: &Failure| render_all(&failure.diagnostics, &failure.source, colour);
        failures.iter().map(text).collect::<String>()
    })?;
    let mut subject = match name {
        Some(name) => name.to_string(),
        None => only_process(&environment).map_err(|why| format!("{}: {why}\n", source.name))?,
    };
    if let Some(values) = with {
        subject.push_str(&format!(" with {values}"));
    }
    Walk::new(&environment, &subject, origin, colour)
}

/// Lines from standard input, each repeated before its answer.
fn piped(mut walk: Walk) -> u8 {
    let mut printer = Printer::default();
    let mut code = 0;
    printer.print(&walk.opening());
    for (number, line) in std::io::stdin().lock().lines().enumerate() {
        let line = match line {
            Ok(line) => line,
            Err(error) => {
                complain(&format!("line {}: it cannot be read: {error}\n", number + 1));
                return 3;
            }
        };
        if line.trim().is_empty() || line.trim_start().starts_with("//") {
            continue;
        }
        let answer = walk.answer(&line);
        if answer.quit {
            break;
        }
        printer.print(&format!("> {}\n{}", line.trim(), answer.text));
        if answer.failed {
            complain(&format!("line {}: `{}` was not possible\n", number + 1, line.trim()));
            code = 1;
        }
    }
    code
}
