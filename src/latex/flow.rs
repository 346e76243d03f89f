//! The phases of a system for print: what passes, the flow function, the recurrence and its closed form.

use std::fmt::Write as _;

use super::{escaped, letter, math, process};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Solved};
use crate::flow::{Carried, Exit, PhaseFlow, needed};
use crate::name::Name;
use crate::period::graph::ending;
use crate::period::{Next, Test};
use crate::recurrence::InCase;
use crate::value::{Relation, Value};

/// Before what a row says is drawn from a distribution.
const DRAWN: &str = "~";
/// Stands in a name for the sign before its number.
const NUMBERED: &str = "drawn";

/// A table of the phases, an `align*` each, for use inside a document with `amsmath`.
pub fn phases(flows: &[PhaseFlow], assumptions: &Assumptions) -> String {
    flows.iter().map(|flow| phase(flow, assumptions)).collect()
}

/// The closed forms of a phase and of its means, a row for each piece.
fn closed_forms(flow: &PhaseFlow, index: &Name, assumptions: &Assumptions) -> Vec<(String, String)> {
    let found = flow.recurrences(index, assumptions, &|| false);
    let cases = flow.recurrences_in_cases(&found, index, assumptions, &|| false);
    // In each case all are told.
    let closed = if cases.is_empty() { found.closed } else { Vec::new() };
    let closed = closed.into_iter().map(|one| ("", one));
    let means = flow.means(index, assumptions, &|| false).into_iter().map(|one| ("\\operatorname{E}", one));
    let mut rows = Vec::new();
    for (of, (name, closed)) in closed.chain(means) {
        let when = conditions(&needed(&closed), "if");
        rows.extend(pieces((of, &name), &closed.pieces, index, &when));
    }
    rows.extend(cases.iter().flat_map(|case| in_case(case, index)));
    rows
}

/// A form by pieces, a row for each.
fn pieces((of, name): (&str, &Name), pieces: &[Piece], index: &Name, when: &str) -> Vec<(String, String)> {
    let row = |piece: &Piece| {
        let from = if piece.from.is_zero() { String::new() } else { format!("{} \\le ", value(&piece.from)) };
        let range = match (&piece.until, from.is_empty()) {
            (Some(until), _) => format!(" \\quad ({from}{index} < {})", value(until)),
            (None, false) => format!(" \\quad ({from}{index})"),
            (None, true) => String::new(),
        };
        (format!("{of}{}_{{{index}}}", escaped_name(name)), value(&piece.form) + &range + when)
    };
    pieces.iter().map(row).collect()
}

/// The forms in one case; one that is no value in the index stands as it is told.
fn in_case(case: &InCase<Solved>, index: &Name) -> Vec<(String, String)> {
    let assumed = case.assumed.iter().chain(case.found.conditions());
    let tests: Vec<Test> = assumed
        .map(|(relation, left, right)| Test { relation: *relation, left: left.clone(), right: right.clone() })
        .collect();
    let when = conditions(&tests, "if");
    let forms = case.found.recurrence().sequences.iter().zip(case.found.forms());
    let rows = forms.flat_map(|(sequence, form)| match (form, form.value(index)) {
        (Form::Pieces(all), _) => pieces(("", &sequence.name), all, index, &when),
        (_, Some(form)) => {
            pieces(("", &sequence.name), &[Piece { from: Value::zero(), until: None, form }], index, &when)
        }
        _ => {
            let told = case.found.lines_of(std::slice::from_ref(&sequence.name));
            told.iter().map(|line| ("\\text{closed}".to_string(), typewriter(line))).collect()
        }
    });
    rows.collect()
}

/// What passes through the ports, a row for each communication.
fn ports(flow: &PhaseFlow) -> Vec<(String, String)> {
    let all = flow.communications().into_iter().flat_map(|(way, tests)| {
        let when = conditions(tests, "if");
        way.communications
            .iter()
            .map(move |(port, passed)| (format!("\\text{{port }}{}", escaped_name(port)), value(passed) + &when))
    });
    let mut rows: Vec<(String, String)> = Vec::new();
    for row in all {
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    rows
}

fn phase(flow: &PhaseFlow, assumptions: &Assumptions) -> String {
    let mut rows: Vec<(String, String)> = Vec::new();
    for (way, tests) in flow.periods() {
        rows.push(("P'".to_string(), process(&way.period_term()) + &conditions(tests, "if")));
        if let Some(duration) = way.duration() {
            rows.push(("\\text{duration}".to_string(), value(&duration) + &conditions(tests, "if")));
        }
    }
    for (tests, map) in &flow.maps {
        let names: Vec<String> = map.keys().map(|name| value(&Value::variable(name))).collect();
        let images: Vec<String> = map.values().map(value).collect();
        let images = if images.len() == 1 { images.concat() } else { format!("({})", images.join(", ")) };
        let when = if flow.maps.len() > 1 || flow.guard.is_empty() { conditions(tests, "if") } else { String::new() };
        rows.push((format!("f({})", names.join(", ")), images + &when));
    }
    rows.extend(carried(&flow.carried));
    if !flow.guard.is_empty() {
        let ways = flow.guard.iter().enumerate();
        let ways = ways.map(|(place, tests)| conditions(tests, if place == 0 { "while" } else { "or" }));
        let ways = ways.collect::<String>();
        rows.push(("\\text{again}".to_string(), format!("{}\\ \\text{{after the round}}", ways.trim_start())));
    }
    rows.extend(flow.draws.iter().map(|(name, from)| (escaped_name(name), format!("{DRAWN}{}", value(from)))));
    rows.extend(ports(flow));
    let index = flow.index();
    // The terms and first values of the sequences, with the index below them.
    let indexed = |text: String| {
        flow.variables.iter().fold(text, |text, name| {
            let below = |index: &str| format!("{}_{{{index}}}", escaped_name(name));
            let text = text.replace(&format!("\\operatorname{{{name}}}({index})"), &below(index.as_str()));
            let start = flow.named.start(name).to_string();
            if start == format!("{name}0") { text.replace(&format!("\\mathit{{{start}}}"), &below("0")) } else { text }
        })
    };
    for (name, next) in flow.steps(&index) {
        rows.push((format!("{}_{{{index}+1}}", escaped_name(&name)), indexed(value(&next))));
    }
    let forms = closed_forms(flow, &index, assumptions);
    rows.extend(forms.into_iter().map(|(left, right)| (left, indexed(right))));
    rows.extend(flow.exits.iter().map(|exit| ("\\text{then}".to_string(), leaving(flow, exit))));
    let control = escaped(&flow.control.join(" | "));
    let mut out = format!("{{\\raggedright\\noindent Phase {}: \\texttt{{{control}}}\\par}}\n", flow.phase + 1);
    out.push_str("\\begin{align*}\n");
    let row = |(left, right): &(String, String)| match right.strip_prefix(DRAWN) {
        Some(right) => format!("  {left} &\\sim {right}"),
        None => format!("  {left} &= {right}"),
    };
    let rows: Vec<String> = rows.iter().map(row).collect();
    let _ = writeln!(out, "{}", rows.join(" \\\\\n"));
    out + "\\end{align*}\n"
}

/// A way out: where it leads, what passes before and how long that takes where it is not as in the round, the variables
/// that no other row tells, and when it is taken.
fn leaving(flow: &PhaseFlow, exit: &Exit) -> String {
    let to = match &exit.next {
        Next::Phase(number) => format!("phase {}", number + 1),
        Next::End(end) => escaped(&ending(end)),
    };
    let after = exit.passing().map_or(String::new(), |(term, lasting)| {
        let lasting = lasting.map_or(String::new(), |time| format!("\\text{{, lasting }}{}", value(&time)));
        format!("\\text{{ after }}{}{lasting}", process(&term))
    });
    let known = flow.carried.is_empty().then_some(&exit.map).into_iter().flatten();
    let known: Vec<String> = known.map(|(name, image)| format!("{} = {}", escaped_name(name), value(image))).collect();
    let with = if known.is_empty() { String::new() } else { format!("\\text{{ with }}{}", known.join(", ")) };
    format!("\\text{{{to}}}{after}{with}{}", conditions(&exit.tests, "if"))
}

/// What the phase does to the parameters of its processes, where it does not come back to itself: a function of what
/// they are where these are names; a number becomes another.
fn carried(all: &[Carried]) -> Option<(String, String)> {
    if all.iter().any(|one| one.before.as_variable().is_none()) {
        let becomes = all.iter().map(|one| {
            let (before, after) = (value(&one.before), value(&one.after));
            format!("{}\\text{{ from }}{before}\\text{{ to }}{after}", escaped_name(&one.parameter))
        });
        return Some(("\\text{flow}".to_string(), becomes.collect::<Vec<_>>().join(",\\ ")));
    }
    let list = |values: Vec<String>| values.join(", ");
    let before = list(all.iter().map(|one| value(&one.before)).collect());
    let after = list(all.iter().map(|one| value(&one.after)).collect());
    match all.len() {
        0 => None,
        1 => Some((format!("f({before})"), after)),
        _ => Some((format!("f({before})"), format!("({after})"))),
    }
}

fn escaped_name(name: &Name) -> String {
    value(&Value::variable(name))
}

fn conditions(tests: &[Test], word: &str) -> String {
    if tests.is_empty() {
        return String::new();
    }
    let sign = |relation: Relation| match relation {
        Relation::Eq => "=",
        Relation::Neq => "\\neq",
        Relation::Gtr => ">",
        Relation::Gte => "\\ge",
        Relation::Lss => "<",
        Relation::Lte => "\\le",
    };
    let tests =
        tests.iter().map(|test| format!("{} {} {}", value(&test.left), sign(test.relation), value(&test.right)));
    format!(" \\quad \\text{{{word} }} {}", tests.collect::<Vec<_>>().join(",\\ "))
}

/// A value in mathematics: as the parameter of a process, which is then taken away. What is drawn has a name that nobody
/// could write, `e~1`, and is set with its number above.
fn value(value: &Value) -> String {
    let text = value.to_string();
    let whole = math(&format!("Delay_{{{}}}", text.replace('~', NUMBERED)), &[]);
    let inside = whole.strip_prefix("\\mathsf{Delay}_{").and_then(|rest| rest.strip_suffix('}'));
    let Some(inside) = inside else { return typewriter(&text) };
    let mut parts = inside.split("\\mathit{");
    let mut out = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let drawn = part.split_once('}').and_then(|(name, rest)| Some((name.split_once(NUMBERED)?, rest)));
        out += &match drawn {
            Some(((name, number), rest)) => format!("{}^{{({number})}}{rest}", letter(name)),
            None => format!("\\mathit{{{part}"),
        };
    }
    out
}

/// As it is written.
fn typewriter(text: &str) -> String {
    format!("\\text{{\\texttt{{{}}}}}", escaped(text))
}
