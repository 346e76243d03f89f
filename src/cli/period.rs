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
use crate::session::beside::BESIDE;
use crate::session::course::{Known, course_of};
use crate::session::delays::{MOST_ORDERS, Order, in_orders, told};
use crate::session::parts::{Part, Together, headline, in_all, parted, parted_after};
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
    let shown = match made.map(|found| shown(&found, request.format)) {
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

/// What was found, as it is asked for; or why it cannot be drawn.
fn shown(found: &Analysed, format: Format) -> Result<Shown, String> {
    match found {
        Analysed::Parts(..) | Analysed::Orders(_) if format == Format::Svg => in_one_picture(found),
        Analysed::Whole(period, known) => whole(period, known.as_ref(), format),
        Analysed::Parts(..) | Analysed::Orders(_) if format == Format::Dot => in_graphs(found),
        Analysed::Parts(parts, ways, all) => Ok(each_part(parts, *ways, all, format)),
        Analysed::Orders(orders) => each_order(orders, format),
        Analysed::Nothing(failures) => {
            let remarks = lines(failures.iter().map(Failure::to_string));
            Ok(Shown { text: String::new(), remarks, again: false })
        }
    }
}

fn whole(period: &Period, known: Option<&Known>, format: Format) -> Result<Shown, String> {
    let course = known.map(|known| &known.course);
    let again = period.comes_again(course);
    let remarks = lines(graph::remarks(period, course).into_iter().chain(known.map(Known::line)));
    Ok(match format {
        Format::Text => Shown { text: lines(graph::lines(period)) + &remarks, remarks: String::new(), again },
        Format::Dot => Shown { text: dot(&graph::system(period)), remarks, again },
        Format::Svg => match svg(&graph::system(period)) {
            Some(text) => Shown { text, remarks, again },
            None => return Err(too_many(period.phases.len())),
        },
    })
}

fn too_many(phases: usize) -> String {
    format!("{phases} phases are too many to draw, fewer than {MOST_DRAWN} are: try `--format dot`\n")
}

/// The phases of each part, or in each order, one below the other under its title; what is said of them is said beside it.
fn in_one_picture(found: &Analysed) -> Result<Shown, String> {
    let mut graphs = Vec::new();
    titled(found, "", &mut graphs);
    let most = graphs.iter().map(|(_, graph)| graph.states()).max().unwrap_or(0);
    let text = svg_of_each(&graphs).ok_or_else(|| too_many(most))?;
    Ok(Shown { text, ..beside(found)? })
}

/// The same as graphs one after the other, each with its title.
fn in_graphs(found: &Analysed) -> Result<Shown, String> {
    let mut graphs = Vec::new();
    titled(found, "", &mut graphs);
    let text = graphs.iter().map(|(title, graph)| titled_dot(graph, title)).collect();
    Ok(Shown { text, ..beside(found)? })
}

/// What is said beside the graphs or pictures of parts and orders.
fn beside(found: &Analysed) -> Result<Shown, String> {
    match found {
        Analysed::Parts(parts, ways, all) => Ok(each_part(parts, *ways, all, Format::Dot)),
        Analysed::Orders(orders) => each_order(orders, Format::Dot),
        found => shown(found, Format::Dot),
    }
}

fn titled(found: &Analysed, title: &str, graphs: &mut Vec<(String, TransitionSystem)>) {
    let under = |own: String| if title.is_empty() { own } else { format!("{title}, {own}") };
    match found {
        Analysed::Whole(period, _) => graphs.push((title.to_string(), graph::system(period))),
        Analysed::Parts(parts, ..) => graphs.extend(parts.iter().enumerate().map(|(number, part)| {
            (under(format!("part {}: {}", number + 1, part.names())), graph::system(&part.period))
        })),
        Analysed::Orders(orders) => {
            orders.iter().for_each(|(order, inner)| titled(inner, &under(order.clone()), graphs));
        }
        Analysed::Nothing(_) => {}
    }
}

/// The phases of parts without a common port, one after the other; each of them comes back to a phase.
fn each_part(parts: &[Part], ways: usize, all: &Together, format: Format) -> Shown {
    let (mut text, again) = (String::new(), all.answer() == "yes");
    match format {
        Format::Text => {
            text.push_str(&format!("{}\n", headline(parts, ways)));
            for (number, part) in parts.iter().enumerate() {
                text.push_str(&format!("part {}: {}\n", number + 1, part.names()));
                let lines = graph::lines(&part.period).into_iter().chain(graph::remarks(&part.period, None));
                text.extend(lines.map(|line| format!("  {line}\n")));
            }
            text.extend(all.line().filter(|_| again).map(|line| format!("{line}\n")));
            text.push_str(&format!("on trust: {BESIDE}\n"));
        }
        Format::Dot | Format::Svg => text.extend(parts.iter().map(|part| dot(&graph::system(&part.period)))),
    }
    Shown { text, remarks: lines(all.line().filter(|_| !again)), again }
}

/// The phases in each order of two delays, one after the other.
fn each_order(orders: &[(String, Analysed)], format: Format) -> Result<Shown, String> {
    let (mut all, mut again) = (String::new(), true);
    let mut remarks = String::new();
    for (title, found) in orders {
        let inner = shown(found, format)?;
        again &= inner.again;
        let own = |text: &str| lines(told(title, text.lines().map(str::to_string).collect()));
        match format {
            Format::Text => all.push_str(&own(&(inner.text + &inner.remarks))),
            _ => {
                all.push_str(&inner.text);
                remarks.extend((!inner.remarks.is_empty()).then(|| own(&inner.remarks)));
            }
        }
    }
    Ok(Shown { text: all, remarks, again })
}

/// What was found of a system.
enum Analysed {
    /// A period, and where the run comes to if that is known and the phases do not say it.
    Whole(Period, Option<Known>),
    /// Parts without a common port, with the number of ways that they have side by side, and what they make together.
    Parts(Vec<Part>, usize, Together),
    /// Of two delays it is not known which ends first: in each order, by its title.
    Orders(Vec<(String, Analysed)>),
    /// No period, and why.
    Nothing(Vec<Failure>),
}

fn make(request: &Request, watch: &Rc<Watch>, colour: bool) -> Result<Analysed, Refused> {
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
    Ok(analysed(system, &environment, MOST_ORDERS, &|| watch.interrupted()))
}

/// What is found of a system, in at most so many orders inside one another.
fn analysed(system: &System, environment: &Environment, most: usize, interrupted: &dyn Fn() -> bool) -> Analysed {
    let (definitions, assumptions) = (&environment.definitions, &environment.assumptions);
    if let Some((parts, ways)) = parted(system, environment, interrupted) {
        let all = in_all(&parts, environment, interrupted);
        return Analysed::Parts(parts, ways, all);
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
                Some((parts, ways)) => {
                    let all = in_all(&parts, environment, interrupted);
                    Analysed::Parts(parts, ways, all)
                }
                None => Analysed::Nothing(failures),
            }
        }
    }
}
