//! `pars period`: the phases of a system, as text or as a picture.

use std::path::PathBuf;
use std::rc::Rc;

use clap::ValueEnum;

use super::system::{Refused, declared, read, written};
use crate::lower::{Entity, System};
use crate::name::Name;
use crate::period::course::Course;
use crate::period::{Failure, Period, analyse_until, graph};
use crate::progress::Watch;
use crate::script::{Printer, complain};
use crate::session::beside::BESIDE;
use crate::session::parts::{Part, Together, headline, in_all, parted};
use crate::transition_system::{MOST_DRAWN, dot, svg};

/// How the phases are written.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Line by line.
    Text,
    /// Graphviz.
    Dot,
    /// A picture.
    Svg,
}

/// What `pars period` is asked for.
pub(super) struct Request {
    pub(super) file: PathBuf,
    pub(super) system: Option<String>,
    pub(super) format: Format,
    pub(super) output: Option<PathBuf>,
}

/// Finds the phases and writes them; gives the exit code: 1 where there is no period, 3 for bad input.
pub(super) fn period(request: &Request, watch: &Rc<Watch>, colour: bool) -> u8 {
    watch.begins("the period");
    let made = make(request, watch, colour);
    watch.ends();
    let (found, course) = match made {
        Ok(Ok(Analysed::Whole(found, course))) => (found, course),
        Ok(Ok(Analysed::Parts(parts, ways, all))) => return each_part(request, &parts, ways, &all),
        Ok(Err(failures)) => {
            complain(&failures.iter().map(|failure| format!("{failure}\n")).collect::<String>());
            return 1;
        }
        Err(text) => {
            complain(&text);
            return 3;
        }
    };
    let warnings: String = graph::remarks(&found, course.as_ref()).iter().map(|line| format!("{line}\n")).collect();
    let text = match request.format {
        Format::Text => graph::lines(&found).iter().map(|line| format!("{line}\n")).collect::<String>() + &warnings,
        Format::Dot => dot(&graph::system(&found)),
        Format::Svg => match svg(&graph::system(&found)) {
            Some(text) => text,
            None => {
                let phases = found.phases.len();
                complain(&format!(
                    "{phases} phases are too many to draw, fewer than {MOST_DRAWN} are: try `--format dot`\n"
                ));
                return 4;
            }
        },
    };
    if request.format != Format::Text && !warnings.is_empty() {
        complain(&warnings);
    }
    match &request.output {
        None => Printer::default().print(&text),
        Some(path) => {
            if let Err(trouble) = written(path, &text) {
                complain(&trouble);
                return 3;
            }
        }
    }
    u8::from(!found.comes_again(course.as_ref()))
}

/// The phases of parts without a common port, one after the other; each of them comes back to a phase.
fn each_part(request: &Request, parts: &[Part], ways: usize, all: &Together) -> u8 {
    let (mut text, comes_again) = (String::new(), all.answer() == "yes");
    match request.format {
        Format::Text => {
            text.push_str(&format!("{}\n", headline(parts, ways)));
            for (number, part) in parts.iter().enumerate() {
                text.push_str(&format!("part {}: {}\n", number + 1, part.names()));
                let lines = graph::lines(&part.period).into_iter().chain(graph::remarks(&part.period, None));
                text.extend(lines.map(|line| format!("  {line}\n")));
            }
            text.extend(all.line().filter(|_| comes_again).map(|line| format!("{line}\n")));
            text.push_str(&format!("on trust: {BESIDE}\n"));
        }
        Format::Dot => text.extend(parts.iter().map(|part| dot(&graph::system(&part.period)))),
        Format::Svg => {
            complain("a picture shows one graph, and these parts have no common port: try `--format dot`\n");
            return 4;
        }
    }
    match request.output.as_ref().map(|path| written(path, &text)) {
        None => Printer::default().print(&text),
        Some(Ok(())) => {}
        Some(Err(trouble)) => {
            complain(&trouble);
            return 3;
        }
    }
    if let Some(line) = all.line().filter(|_| !comes_again) {
        complain(&format!("{line}\n"));
    }
    u8::from(!comes_again)
}

/// What was found of a system.
enum Analysed {
    /// A period, and where the run comes to if that is known and the phases do not say it.
    Whole(Period, Option<Course>),
    /// Parts without a common port, with the number of ways that they have side by side, and what they make together.
    Parts(Vec<Part>, usize, Together),
}

fn make(request: &Request, watch: &Rc<Watch>, colour: bool) -> Result<Result<Analysed, Vec<Failure>>, Refused> {
    let source = read(&request.file, colour)?;
    let environment = declared(&source, watch, colour)?;
    let systems: Vec<(&Name, &System)> = environment
        .entities()
        .filter_map(|(name, entity)| if let Entity::System(system) = entity { Some((name, system)) } else { None })
        .collect();
    let names = || systems.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
    let wanted = request.system.as_deref().map(str::trim);
    let (_, system) = match (wanted, systems.as_slice()) {
        (_, []) => return Err("the file declares no system: `system Sys = P | Q`\n".to_string()),
        (None, [one]) => one,
        (None, _) => return Err(format!("the file declares several systems; say which: {}\n", names())),
        (Some(wanted), all) => match all.iter().find(|(name, _)| name.as_str() == wanted) {
            Some(found) => found,
            None => return Err(format!("there is no system `{wanted}`; the file declares {}\n", names())),
        },
    };
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let interrupted = || watch.interrupted();
    if let Some((parts, ways)) = parted(system, &environment, &interrupted) {
        let all = in_all(&parts, &environment, &interrupted);
        return Ok(Ok(Analysed::Parts(parts, ways, all)));
    }
    Ok(analyse_until(&system.components, definitions, assumptions, &interrupted).map(|period| {
        let follows = period.repeats() && period.lasting().is_none();
        let course = if follows { period.course(assumptions, &interrupted) } else { None };
        Analysed::Whole(period, course)
    }))
}
