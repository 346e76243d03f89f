//! Terms, conditions, laws and definitions as text that parses back to them; and the layout of files.

mod layout;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;

use crate::definition::Definition;
use crate::law::{Condition, Connective, Law};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

pub use layout::format;

/// How tightly the surroundings of a process bind: a weaker operator inside needs brackets.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// Nothing around: anything may stand here.
    Free,
    /// Under `|`, or behind `else`.
    Branch,
    /// Before `else`.
    Arm,
    /// Under `;` or `#`.
    Step,
    /// Before `^`, `[…]` or `to`.
    Base,
}

/// What is still to be written.
#[derive(Clone)]
enum Piece<'t> {
    Text(String),
    Part(&'t Term, Place),
}

/// Writes without recursion, for terms may be deep.
fn write_term(term: &Term, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let mut rest = vec![Piece::Part(term, Place::Free)];
    while let Some(piece) = rest.pop() {
        match piece {
            Piece::Text(text) => f.write_str(&text)?,
            Piece::Part(term, place) => {
                let mut pieces = pieces(term);
                if place > loosest(term) {
                    f.write_str("(")?;
                    pieces.push(Piece::Text(")".to_string()));
                }
                rest.extend(pieces.into_iter().rev());
            }
        }
    }
    Ok(())
}

/// The text of a term, and where in it some runs of neighbouring parts stand. A run is given by the numbers of its first
/// and last part, where the whole term is 0 and the parts of each term follow it in order. A run that is not written
/// (the `Stop` of `try`) is left out. The parts of a list are numbered as the term keeps them, and written in this order.
pub fn placed(term: &Term, runs: &[(usize, usize)], order: &Order) -> (String, Vec<Range<usize>>) {
    let (mut text, mut places) = (String::new(), Vec::new());
    let mut starts: BTreeMap<usize, usize> = BTreeMap::new();
    let mut rest = vec![Next::Piece(Piece::Part(term, Place::Free), 0)];
    while let Some(next) = rest.pop() {
        match next {
            Next::Piece(Piece::Text(piece), _) => text.push_str(&piece),
            Next::End(number) => {
                for (first, _) in runs.iter().filter(|(_, last)| *last == number) {
                    if let Some(start) = starts.get(first) {
                        places.push(*start..text.len());
                    }
                }
            }
            Next::Piece(Piece::Part(term, place), number) => {
                starts.insert(number, text.len());
                let bracketed = place > loosest(term);
                text.push_str(if bracketed { "(" } else { "" });
                rest.push(Next::End(number));
                if bracketed {
                    rest.push(Next::Piece(Piece::Text(")".to_string()), 0));
                }
                let mut inner = number + 1;
                let mut numbered = Vec::new();
                for piece in pieces(term) {
                    let own = inner;
                    if let Piece::Part(part, _) = &piece {
                        inner = inner.saturating_add(part.size());
                    }
                    numbered.push(Next::Piece(piece, own));
                }
                if let Some(places) = order.get(&number) {
                    reorder(&mut numbered, places);
                }
                rest.extend(numbered.into_iter().rev());
            }
        }
    }
    places.sort_by_key(|place| (place.start, place.end));
    (text, places)
}

/// What is still to be written: a piece with its number, or the end of the part that has this number.
#[derive(Clone)]
enum Next<'t> {
    Piece(Piece<'t>, usize),
    End(usize),
}

/// For the number of a list, the places of its parts in the order in which they are written.
pub type Order = BTreeMap<usize, Vec<usize>>;

/// Puts the parts of a list in this order; the operators between them stay.
fn reorder(pieces: &mut [Next<'_>], order: &[usize]) {
    let before = pieces.to_vec();
    for (to, from) in order.iter().enumerate() {
        if let (Some(slot), Some(piece)) = (pieces.get_mut(2 * to), before.get(2 * from)) {
            *slot = piece.clone();
        }
    }
}

/// The tightest place where a process can stand without brackets.
fn loosest(term: &Term) -> Place {
    match term.node() {
        Node::Par(_) | Node::Disable(_) | Node::New(..) | Node::Project(..) => Place::Free,
        Node::Else(_, second) if *second.node() != Node::Stop => Place::Branch,
        Node::Seq(_) => Place::Arm,
        Node::Power(..) | Node::Replace(..) => Place::Step,
        _ => Place::Base,
    }
}

fn pieces(term: &Term) -> Vec<Piece<'_>> {
    let text = |text: String| vec![Piece::Text(text)];
    match term.node() {
        Node::Stop => text("Stop".to_string()),
        Node::Abort => text("Abort".to_string()),
        Node::Idle => text("Idle".to_string()),
        Node::Delay(time) => text(format!("Delay{}", subscript(std::slice::from_ref(time)))),
        Node::In(port, result) => text(format!("In_{port}<{result}>")),
        Node::Out(port, value) => text(format!("Out_{{{port},{value}}}")),
        Node::Guard(relation, left, right) => text(format!("{}_{{{left},{right}}}", relation.spelling())),
        Node::Set(value, result) => text(format!("Set{}<{result}>", subscript(std::slice::from_ref(value)))),
        Node::Ran(value, result) => text(format!("Ran{}<{result}>", subscript(std::slice::from_ref(value)))),
        Node::Observe(name, values) | Node::Call(name, values) | Node::Meta(name, values) => {
            text(format!("{name}{}", subscript(values)))
        }
        Node::Seq(parts) => joined(parts, " ; ", Place::Step),
        Node::Par(parts) => joined(parts, " | ", Place::Branch),
        Node::Disable(parts) => joined(parts, " # ", Place::Step),
        Node::Else(body, second) if *second.node() == Node::Stop => around("try(", body, Place::Free, ")"),
        Node::Else(first, second) => {
            vec![Piece::Part(first, Place::Arm), Piece::Text(" else ".to_string()), Piece::Part(second, Place::Branch)]
        }
        Node::Power(body, count, None) => around("", body, Place::Base, &exponent(count)),
        Node::Power(body, count, Some(index)) => around("", body, Place::Base, &format!("^{{{index}<{count}}}")),
        Node::Loop(body) => around("loop(", body, Place::Free, ")"),
        Node::New(port, body) => around(&format!("new {port}. "), body, Place::Step, ""),
        Node::Project(body, shown) => around("", body, Place::Base, &format!(" to {}", set(shown))),
        Node::Replace(body, name, value) => around("", body, Place::Base, &format!("[{name} := {value}]")),
    }
}

fn around<'t>(before: &str, body: &'t Term, place: Place, after: &str) -> Vec<Piece<'t>> {
    vec![Piece::Text(before.to_string()), Piece::Part(body, place), Piece::Text(after.to_string())]
}

fn joined<'t>(parts: &'t [Term], operator: &str, place: Place) -> Vec<Piece<'t>> {
    let mut pieces = Vec::with_capacity(parts.len() * 2);
    for (index, part) in parts.iter().enumerate() {
        if index > 0 {
            pieces.push(Piece::Text(operator.to_string()));
        }
        pieces.push(Piece::Part(part, place));
    }
    pieces
}

/// Whether a value's text is one name or number, so that it needs no braces.
fn simple(text: &str) -> bool {
    text.trim_start_matches('?').chars().all(|letter| letter.is_alphanumeric() || letter == '_' || letter == '\'')
}

/// `_x`, `_{x,y}`, or nothing.
fn subscript(values: &[Value]) -> String {
    let texts: Vec<String> = values.iter().map(Value::to_string).collect();
    match texts.as_slice() {
        [] => String::new(),
        [text] if simple(text) => format!("_{text}"),
        _ => format!("_{{{}}}", texts.join(",")),
    }
}

fn set(names: &BTreeSet<Name>) -> String {
    let names: Vec<&str> = names.iter().map(Name::as_str).collect();
    format!("{{{}}}", names.join(", "))
}

/// As the second part of a condition, where `?S` needs no braces.
fn any_set(names: &BTreeSet<Name>) -> String {
    match names.first() {
        Some(only) if names.len() == 1 && only.is_meta() => only.to_string(),
        _ => set(names),
    }
}

/// A name with a capital stands in braces: a process could begin with it.
fn exponent(count: &Value) -> String {
    let text = count.to_string();
    if simple(&text) && !text.starts_with(char::is_uppercase) { format!("^{text}") } else { format!("^{{{text}}}") }
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_term(self, f)
    }
}

impl fmt::Display for Connective {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Connective::Equal => "=",
            Connective::Refines => "<=",
            Connective::Weak => "~~",
            Connective::WeaklyRefines => "<~",
        })
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Condition::Compare(relation, left, right) => write!(f, "{left} {} {right}", relation.symbol()),
            Condition::Natural(value) => write!(f, "natural({value})"),
            Condition::Is(fact, process) => write!(f, "{}({process})", fact.spelling()),
            Condition::Lasts(process, time) => write!(f, "lasts({process}, {time})"),
            Condition::Complementary(left, right) => write!(f, "complementary({left}, {right})"),
            Condition::NoPort(process, port) => write!(f, "no_port({process}, {port})"),
            Condition::Unread(process, name) => write!(f, "unread({process}, {name})"),
            Condition::Apart(left, right) => write!(f, "apart({left}, {right})"),
            Condition::ShowsOnly(process, shown) => write!(f, "shows_only({process}, {})", any_set(shown)),
            Condition::ShowsNone(process, shown) => write!(f, "shows_none({process}, {})", any_set(shown)),
        }
    }
}

impl fmt::Display for Law {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "law {} \"{}\"", self.name, self.title)?;
        if !self.source.is_empty() {
            writeln!(f, "  {}", self.source)?;
        }
        let conditions: Vec<String> = self.conditions.iter().map(Condition::to_string).collect();
        if !conditions.is_empty() {
            writeln!(f, "  when {}", conditions.join(", "))?;
        }
        let connective = if self.oriented { "=>".to_string() } else { self.connective.to_string() };
        write!(f, "  {} {connective} {}", self.left, self.right)?;
        for (left, right) in &self.examples {
            write!(f, "\n  try {left} {} {right}", self.connective)?;
        }
        Ok(())
    }
}

impl fmt::Display for Definition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parameters: Vec<&str> = self.parameters.iter().map(Name::as_str).collect();
        let parameters = match parameters.as_slice() {
            [] => String::new(),
            [only] => format!("_{only}"),
            _ => format!("_{{{}}}", parameters.join(",")),
        };
        write!(f, "proc {}{parameters} = {}", self.name, self.body)
    }
}
