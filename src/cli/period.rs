//! `pars period`: the phases of a system, as text or as a picture.

use std::path::PathBuf;
use std::rc::Rc;

use clap::ValueEnum;

use super::system::{Refused, declared, read, written};
use crate::lower::{Entity, Environment, System};
use crate::name::Name;
use crate::period::{Failure, Period, analyse_until, graph};
use crate::progress::Watch;
use crate::script::{Printer, complain};
use crate::session::course::{Known, course_of};
use crate::session::delays::{MOST_ORDERS, Order, in_orders, told};
use crate::session::parts::{Part, Together, in_all, parted, parted_after};
use crate::session::phases::period_lines;
use crate::session::print::flow_for_print;
use crate::transition_system::{MOST_DRAWN, TransitionSystem, dot, svg, svg_of_each, titled_dot};

/// How the phases are written.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Line by line.
    Text,
    /// Graphviz.
    Dot,
    /// A picture.
    Svg,
    /// The flow as tables for LaTeX, with `amsmath`.
    Latex,
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
    let shown = match made {
        Ok(Ok(shown)) => shown,
        Ok(Err(too_many)) => {
            complain(&too_many);
            return 4;
        }
        Err(text) => {
            complain(&text);
            return 3;
        }
    };
    match request.output.as_ref().filter(|_| !shown.text.is_empty()).map(|path| written(path, &shown.text)) {
        None => Printer::default().print(&shown.text),
        Some(Ok(())) => {}
        Some(Err(trouble)) => {
            complain(&trouble);
            return 3;
        }
    }
    if !shown.remarks.is_empty() {
        complain(&shown.remarks);
    }
    u8::from(!shown.again)
}

/// What is written, what is said beside it, and whether the system comes again.
struct Shown {
    text: String,
    remarks: String,
    again: bool,
}

fn lines(lines: impl IntoIterator<Item = String>) -> String {
    lines.into_iter().map(|line| format!("{line}\n")).collect()
}

/// The graphs that were found, as they are asked for; or why they cannot be drawn.
fn drawn(found: &Analysed, format: Format) -> Result<Shown, String> {
    let mut graphs = Vec::new();
    titled(found, "", &mut graphs);
    let single = matches!(found, Analysed::Whole(..));
    let text = match format {
        Format::Svg => {
            let most = graphs.iter().map(|(_, graph)| graph.states()).max().unwrap_or(0);
            let picture = match graphs.as_slice() {
                [] => Some(String::new()),
                [(_, graph)] if single => svg(graph),
                all => svg_of_each(all),
            };
            picture.ok_or_else(|| too_many(most))?
        }
        _ if single => graphs.iter().map(|(_, graph)| dot(graph)).collect(),
        _ => graphs.iter().map(|(title, graph)| titled_dot(graph, title)).collect(),
    };
    let (remarks, again) = beside(found);
    Ok(Shown { text, remarks: lines(remarks), again })
}

fn too_many(phases: usize) -> String {
    format!("{phases} phases are too many to draw, fewer than {MOST_DRAWN} are: try `--format dot`\n")
}

/// What is said beside graphs, and whether the system comes again.
fn beside(found: &Analysed) -> (Vec<String>, bool) {
    match found {
        Analysed::Whole(period, known) => {
            let course = known.as_ref().map(|known| &known.course);
            let remarks = graph::remarks(period, course).into_iter().chain(known.as_ref().map(Known::line));
            (remarks.collect(), period.comes_again(course))
        }
        Analysed::Parts(_, all) => {
            let again = all.answer() == "yes";
            (all.line().filter(|_| !again).into_iter().collect(), again)
        }
        Analysed::Orders(orders) => {
            let (mut remarks, mut again) = (Vec::new(), true);
            for (title, found) in orders {
                let (own, comes_again) = beside(found);
                again &= comes_again;
                remarks.extend((!own.is_empty()).then(|| told(title, own)).into_iter().flatten());
            }
            (remarks, again)
        }
        Analysed::Nothing(failures) => (failures.iter().map(Failure::to_string).collect(), false),
    }
}

fn titled(found: &Analysed, title: &str, graphs: &mut Vec<(String, TransitionSystem)>) {
    let under = |own: String| if title.is_empty() { own } else { format!("{title}, {own}") };
    match found {
        Analysed::Whole(period, _) => graphs.push((title.to_string(), graph::system(period))),
        Analysed::Parts(parts, _) => graphs.extend(parts.iter().enumerate().map(|(number, part)| {
            (under(format!("part {}: {}", number + 1, part.names())), graph::system(&part.period))
        })),
        Analysed::Orders(orders) => {
            orders.iter().for_each(|(order, inner)| titled(inner, &under(order.clone()), graphs));
        }
        Analysed::Nothing(_) => {}
    }
}

/// What was found of a system.
enum Analysed {
    /// A period, and where the run comes to if that is known and the phases do not say it.
    Whole(Period, Option<Known>),
    /// Parts without a common port, and what they make together.
    Parts(Vec<Part>, Together),
    /// Of two delays it is not known which ends first: in each order, by its title.
    Orders(Vec<(String, Analysed)>),
    /// No period, and why.
    Nothing(Vec<Failure>),
}

fn make(request: &Request, watch: &Rc<Watch>, colour: bool) -> Result<Result<Shown, String>, Refused> {
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
    let interrupted = || watch.interrupted();
    if request.format == Format::Text {
        let (text, again) = period_lines(system, &environment, &interrupted);
        return Ok(Ok(Shown { text: lines(text), remarks: String::new(), again }));
    }
    if request.format == Format::Latex {
        return Ok(Ok(match flow_for_print(system, &environment, MOST_ORDERS, &interrupted) {
            Ok(text) => {
                let (_, again) = beside(&analysed(system, &environment, MOST_ORDERS, &interrupted));
                Shown { text, remarks: String::new(), again }
            }
            Err(failures) => {
                Shown { text: String::new(), remarks: lines(failures.iter().map(Failure::to_string)), again: false }
            }
        }));
    }
    Ok(drawn(&analysed(system, &environment, MOST_ORDERS, &interrupted), request.format))
}

/// What is found of a system, in at most so many orders inside one another.
fn analysed(system: &System, environment: &Environment, most: usize, interrupted: &dyn Fn() -> bool) -> Analysed {
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    let together = |parts: Vec<Part>| {
        let all = in_all(&parts, environment, interrupted);
        Analysed::Parts(parts, all)
    };
    if let Some((parts, _)) = parted(system, environment, interrupted) {
        return together(parts);
    }
    match analyse_until(&system.components, definitions, assumptions, interrupted) {
        Ok(period) => {
            let follows = period.repeats() && period.lasting().is_none();
            let course = follows.then(|| course_of(&period, system, environment, interrupted).ok().flatten()).flatten();
            Analysed::Whole(period, course)
        }
        Err(failures) => {
            let each = |order: &Order| analysed(system, &order.environment, most - 1, interrupted);
            let (orders, found) = in_orders(&failures, environment, most, each);
            let some = found.iter().any(|one| !matches!(one, Analysed::Nothing(_)));
            let titled = || orders.into_iter().map(|order| order.title).zip(found).collect();
            if some {
                return Analysed::Orders(titled());
            }
            match parted_after(&failures, system, environment, interrupted) {
                Some((parts, _)) => together(parts),
                None => Analysed::Nothing(failures),
            }
        }
    }
}
