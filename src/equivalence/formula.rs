//! Hennessy–Milner formulas with time, outcomes and observations, each part once.

use std::collections::HashMap;
use std::fmt::Write as _;

use num_rational::BigRational;

use crate::transition_system::{Ending, Label, Mark};

/// A formula: its place among the formulas of one evidence.
pub type Place = u32;

/// The outermost part of a formula.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// Holds everywhere.
    True,
    /// Holds nowhere.
    False,
    /// The state has ended so.
    Ends(Ending),
    /// The state shows this observer.
    Shows(String),
    /// The state does not show this observer.
    Hides(String),
    /// The state looks just so.
    Looks(Mark),
    /// After some step with this label; if weak, with internal steps before and behind it.
    Some(bool, Label, Place),
    /// After every such step.
    All(bool, Label, Place),
    /// All of them.
    And(Vec<Place>),
    /// One of them.
    Or(Vec<Place>),
    /// It does not hold.
    Not(Place),
    /// Internal steps through states with the first, then a step with this label to a state with the second; for an
    /// internal step, the second may also hold at once.
    Until(Place, Label, Place),
    /// It holds with at least this chance once the draws that are due have been made.
    Chance(Place, BigRational),
    /// Steps can be chosen so that it comes true with at least this chance.
    Best(Place, BigRational),
}

/// Formulas that share their parts; a part stands before what is made of it.
#[derive(Clone, Debug, Default)]
pub struct Formulas {
    nodes: Vec<Node>,
    /// Whether they speak of what may draw: then steps, and what is seen, are said of each outcome of the draws that are due.
    pub draws: bool,
    places: HashMap<Node, Place>,
}

/// A piece of a formula that is still to be written.
enum Piece<'f> {
    Text(&'static str),
    Label(&'f Label),
    /// A part, and whether it stands inside another.
    Part(Place, bool),
}

impl Formulas {
    /// The place of a formula, which is added if it is new.
    pub fn add(&mut self, node: Node) -> Place {
        let node = self.simple(node);
        if let Some(place) = self.places.get(&node) {
            return *place;
        }
        let place = self.nodes.len() as Place;
        self.nodes.push(node.clone());
        self.places.insert(node, place);
        place
    }

    fn simple(&self, node: Node) -> Node {
        let joined = |mut parts: Vec<Place>, drop: &Node| {
            parts.retain(|part| self.node(*part) != drop);
            parts.sort_unstable();
            parts.dedup();
            parts
        };
        match node {
            Node::And(parts) => match joined(parts, &Node::True).as_slice() {
                [] => Node::True,
                [one] => self.node(*one).clone(),
                parts => Node::And(parts.to_vec()),
            },
            Node::Or(parts) => match joined(parts, &Node::False).as_slice() {
                [] => Node::False,
                [one] => self.node(*one).clone(),
                parts => Node::Or(parts.to_vec()),
            },
            node => node,
        }
    }

    /// The outermost part of a formula.
    pub fn node(&self, place: Place) -> &Node {
        &self.nodes[place as usize]
    }

    /// The number of different parts.
    pub fn size(&self) -> usize {
        self.nodes.len()
    }

    /// The formula as text, cut where it has more than this many letters.
    pub fn text(&self, root: Place, longest: usize) -> String {
        let mut out = String::new();
        let mut open = vec![Piece::Part(root, false)];
        while let Some(piece) = open.pop() {
            if out.len() > longest {
                out.push_str(" …");
                return out;
            }
            match piece {
                Piece::Text(text) => out.push_str(text),
                Piece::Label(label) => {
                    let _ = write!(out, "<{label}> ");
                }
                Piece::Part(place, inside) => self.part(place, inside, &mut out, &mut open),
            }
        }
        out
    }

    /// Writes how a part begins, and notes what follows, the last first.
    fn part<'f>(&'f self, place: Place, inside: bool, out: &mut String, open: &mut Vec<Piece<'f>>) {
        match self.node(place) {
            Node::True => out.push_str("true"),
            Node::False => out.push_str("false"),
            Node::Ends(ending) => out.push_str(&ending.to_string()),
            Node::Shows(shown) => out.push_str(&format!("shows {shown}")),
            Node::Hides(shown) => out.push_str(&format!("not shows {shown}")),
            Node::Looks(mark) => out.push_str(&format!("{{{mark}}}")),
            Node::Some(weak, label, _) | Node::All(weak, label, _) => {
                let some = matches!(self.node(place), Node::Some(..));
                let (label, next) = self.waits(place, label);
                let signs = match (some, weak) {
                    (true, false) => ["<", ">"],
                    (true, true) => ["<<", ">>"],
                    (false, false) => ["[", "]"],
                    (false, true) => ["[[", "]]"],
                };
                let _ = write!(out, "{}{label}{}", signs[0], signs[1]);
                // `<a>` alone says that there is such a step.
                if !some || *self.node(next) != Node::True {
                    out.push(' ');
                    open.push(Piece::Part(next, true));
                }
            }
            Node::And(parts) | Node::Or(parts) => {
                let word = if matches!(self.node(place), Node::And(_)) { " and " } else { " or " };
                let mut pieces = vec![Piece::Text(if inside { "(" } else { "" })];
                for (index, part) in parts.iter().enumerate() {
                    pieces.push(Piece::Text(if index > 0 { word } else { "" }));
                    pieces.push(Piece::Part(*part, true));
                }
                pieces.push(Piece::Text(if inside { ")" } else { "" }));
                open.extend(pieces.into_iter().rev());
            }
            Node::Not(part) => {
                out.push_str("not ");
                open.push(Piece::Part(*part, true));
            }
            Node::Chance(part, least) => {
                let _ = write!(out, "chance >= {least} of ");
                open.push(Piece::Part(*part, true));
            }
            Node::Best(part, least) => {
                let _ = write!(out, "best chance >= {least} of ");
                open.push(Piece::Part(*part, true));
            }
            Node::Until(hold, label, next) => {
                out.push('(');
                open.extend([Piece::Text(")"), Piece::Part(*next, true), Piece::Label(label)]);
                if *self.node(*hold) != Node::True {
                    open.extend([Piece::Text(" "), Piece::Part(*hold, true)]);
                }
            }
        }
    }

    /// Steps of time that follow one another, as one.
    fn waits(&self, place: Place, label: &Label) -> (Label, Place) {
        let (mut place, mut label) = (place, label.clone());
        loop {
            let next = match self.node(place) {
                Node::Some(_, _, next) | Node::All(_, _, next) => *next,
                _ => return (label, place),
            };
            let more = match (self.node(place), self.node(next), &label) {
                (Node::Some(weak, ..), Node::Some(also, Label::Wait(more), _), Label::Wait(_)) if weak == also => more,
                (Node::All(weak, ..), Node::All(also, Label::Wait(more), _), Label::Wait(_)) if weak == also => more,
                _ => return (label, next),
            };
            label = Label::Wait(sum(&label, more));
            place = next;
        }
    }
}

fn sum(label: &Label, more: &BigRational) -> BigRational {
    match label {
        Label::Wait(time) => time + more,
        _ => more.clone(),
    }
}
