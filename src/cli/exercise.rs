//! `pars exercise`: exercises done at a terminal, or with answers from standard input.

use std::io::{BufRead, IsTerminal};
use std::path::Path;
use std::rc::Rc;

use crate::diagnostic::{nearest, render_all};
use crate::exercise::{Attempt, read};
use crate::lower::{Environment, Exercise};
use crate::progress::Watch;
use crate::repl;
use crate::script::{Printer, World, complain, opened};
use crate::session::Surroundings;

/// Does the exercises of a file, or the one of this name; gives the exit code: 0 all solved, 1 not all, 3 bad input.
pub(super) fn exercise(file: &Path, name: Option<&str>, watch: Rc<Watch>, colour: bool) -> u8 {
    let Some(source) = opened(file, colour) else { return 3 };
    let world = World::new(watch.clone());
    let found = read(&source, |importer, path| world.find(importer, path), &|| watch.interrupted());
    let mut exercises = match found {
        Ok(exercises) => exercises,
        Err(failures) => {
            for failure in failures {
                complain(&render_all(&failure.diagnostics, &failure.source, colour));
            }
            return 3;
        }
    };
    if let Some(name) = name {
        let known: Vec<String> = exercises.iter().map(|(exercise, _)| exercise.name.to_string()).collect();
        exercises.retain(|(exercise, _)| exercise.name.as_str() == name);
        if exercises.is_empty() {
            let near = nearest(name, known.iter().map(String::as_str));
            let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
            complain(&format!("there is no exercise `{name}`{near}\n"));
            return 3;
        }
    }
    if exercises.is_empty() {
        complain(&format!("`{}` has no exercise\n", source.name));
        return 3;
    }
    if std::io::stdin().is_terminal() { typed(&exercises, &watch, colour) } else { piped(&exercises, &watch, colour) }
}

fn typed(exercises: &[(Exercise, Environment)], watch: &Watch, colour: bool) -> u8 {
    let mut printer = Printer::default();
    let mut left = exercises.len();
    for (exercise, environment) in exercises {
        let mut attempt = Attempt::new(exercise, environment, colour);
        printer.print(&format!("{}`help` lists what can be typed\n", attempt.show()));
        let solved = repl::ask("exercise> ", colour, &mut |line| {
            watch.reset();
            let answer = attempt.answer(line, &|| watch.interrupted());
            printer.print(&answer.text);
            (answer.quit || answer.solved).then_some(answer.solved)
        });
        if solved != Some(true) {
            break;
        }
        left -= 1;
    }
    u8::from(left > 0)
}

/// Lines from standard input, each repeated before its answer; after a solved exercise comes the next.
fn piped(exercises: &[(Exercise, Environment)], watch: &Watch, colour: bool) -> u8 {
    let mut printer = Printer::default();
    let mut lines = std::io::stdin().lock().lines();
    for (exercise, environment) in exercises {
        let mut attempt = Attempt::new(exercise, environment, colour);
        printer.print(&attempt.show());
        loop {
            let Some(line) = lines.next() else { return 1 };
            let line = match line {
                Ok(line) => line,
                Err(error) => {
                    complain(&format!("standard input cannot be read: {error}\n"));
                    return 3;
                }
            };
            if line.trim().is_empty() || line.trim_start().starts_with("//") {
                continue;
            }
            let answer = attempt.answer(&line, &|| watch.interrupted());
            printer.print(&format!("> {}\n{}", line.trim(), answer.text));
            if answer.quit {
                return 1;
            }
            if answer.solved {
                break;
            }
        }
    }
    0
}
