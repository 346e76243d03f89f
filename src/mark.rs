//! What changed between two terms, and terms written with only that marked.

mod order;

use std::ops::Range;

use crate::printer::{Order, placed};
use crate::term::{Node, Term};

pub use order::kept;

/// A text longer than this is shown around its first mark only.
const WIDEST: usize = 2_000;

/// The text of a term, with the places in it that are marked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Marked {
    /// The whole text.
    pub text: String,
    /// The marked places, in bytes, in order; none overlaps another.
    pub places: Vec<Range<usize>>,
}

impl Marked {
    /// The text with these before and behind each marked place.
    pub fn with(&self, open: &str, close: &str) -> String {
        let mut out = String::with_capacity(self.text.len() + 8 * self.places.len());
        let mut end = 0;
        for place in &self.places {
            out.push_str(self.text.get(end..place.start).unwrap_or(""));
            out.push_str(open);
            out.push_str(self.text.get(place.clone()).unwrap_or(""));
            out.push_str(close);
            end = place.end;
        }
        out.push_str(self.text.get(end..).unwrap_or(""));
        out
    }

    /// For a person: bold and underlined on a terminal, else in `⟦ ⟧`. A very long text is cut around its first mark.
    pub fn shown(&self, terminal: bool) -> String {
        let cut = self.cut();
        if terminal { cut.with("\u{1b}[1;4m", "\u{1b}[0m") } else { cut.with("⟦", "⟧") }
    }

    fn cut(&self) -> Marked {
        if self.text.len() <= WIDEST {
            return self.clone();
        }
        let first = self.places.first().map_or(0, |place| place.start);
        let boundary = |mut at: usize| {
            while !self.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = boundary(first.saturating_sub(WIDEST / 4));
        let end = boundary((start + WIDEST).min(self.text.len()));
        let before = if start > 0 { "… " } else { "" };
        let after = match self.text.len() - end {
            0 => String::new(),
            more => format!(" … ({more} letters more)"),
        };
        let shift = |at: usize| at.min(end) - start + before.len();
        let inside = self.places.iter().filter(|place| place.start < end);
        let places = inside.map(|place| shift(place.start)..shift(place.end)).collect();
        let kept = self.text.get(start..end).unwrap_or("");
        Marked { text: format!("{before}{kept}{after}"), places }
    }
}

/// The second term with what is new in it marked: the smallest parts in which it differs from the first.
pub fn marked(before: &Term, after: &Term) -> Marked {
    marked_in_order(before, after, &Order::new())
}

/// The same, with the parts of the lists written in this order.
pub fn marked_in_order(before: &Term, after: &Term, order: &Order) -> Marked {
    let (text, places) = placed(after, &changes(before, after), order);
    Marked { text, places: outermost(places) }
}

/// Where one place lies in another, the outer one alone.
fn outermost(places: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut kept: Vec<Range<usize>> = Vec::new();
    for place in places {
        match kept.last_mut() {
            Some(last) if place.start < last.end => last.end = last.end.max(place.end),
            _ => kept.push(place),
        }
    }
    kept
}

/// The runs of parts of `after`, by their numbers as in [`placed`], in which it differs from `before`.
fn changes(before: &Term, after: &Term) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut open = vec![(before.clone(), after.clone(), 0usize)];
    while let Some((before, after, number)) = open.pop() {
        if before == after {
            continue;
        }
        let numbers = numbers(&after, number);
        match (before.node(), after.node()) {
            (Node::Seq(_), _) | (_, Node::Seq(_)) => {
                sequence(&before, &after, number, &numbers, &mut runs, &mut open);
            }
            (Node::Par(old), Node::Par(new)) | (Node::Disable(old), Node::Disable(new)) => {
                beside(old, new, number, &numbers, &mut runs, &mut open);
            }
            _ => {
                let (old, new) = (before.children(), after.children());
                let parts: Vec<Term> = new.clone().cloned().collect();
                let hidden = matches!(after.node(), Node::Else(_, second) if *second.node() == Node::Stop)
                    && old.clone().nth(1) != new.clone().nth(1);
                if old.len() == new.len() && !old.is_empty() && !hidden && before.with_children(parts) == after {
                    let pairs = old.into_iter().zip(new).zip(&numbers);
                    open.extend(pairs.map(|((old, new), number)| (old.clone(), new.clone(), *number)));
                } else {
                    runs.push((number, number));
                }
            }
        }
    }
    runs
}

/// The numbers of the parts of a term that has this number.
fn numbers(term: &Term, number: usize) -> Vec<usize> {
    let mut next = number + 1;
    let mut all = Vec::new();
    for part in term.children() {
        all.push(next);
        next = next.saturating_add(part.size());
    }
    all
}

type Open = Vec<(Term, Term, usize)>;

fn parts(term: &Term) -> Vec<Term> {
    match term.node() {
        Node::Seq(parts) => parts.to_vec(),
        _ => vec![term.clone()],
    }
}

/// The parts between those that both sequences end and begin with.
fn sequence(
    before: &Term,
    after: &Term,
    number: usize,
    numbers: &[usize],
    runs: &mut Vec<(usize, usize)>,
    open: &mut Open,
) {
    let (old, new) = (parts(before), parts(after));
    let whole = !matches!(after.node(), Node::Seq(_));
    let at = |place: usize| if whole { number } else { numbers.get(place).copied().unwrap_or(number) };
    let most = old.len().min(new.len());
    let tail = old.iter().rev().zip(new.iter().rev()).take_while(|(one, two)| one == two).count();
    let head = old.iter().zip(&new).take(most - tail).take_while(|(one, two)| one == two).count();
    let (gone, come) = (&old[head..old.len() - tail], &new[head..new.len() - tail]);
    match (gone, come) {
        // What follows has moved up.
        (_, []) => {
            let place = head.min(new.len().saturating_sub(1));
            runs.push((at(place), at(place)));
        }
        ([one], [two]) if !matches!((one.node(), two.node()), (Node::Seq(_), _) | (_, Node::Seq(_))) => {
            open.push((one.clone(), two.clone(), at(head)));
        }
        _ => runs.push((at(head), at(head + come.len() - 1))),
    }
}

/// Parts whose order says nothing: equal ones are set aside, the others paired with what they most likely were.
fn beside(
    old: &[Term],
    new: &[Term],
    number: usize,
    numbers: &[usize],
    runs: &mut Vec<(usize, usize)>,
    open: &mut Open,
) {
    let mut gone: Vec<&Term> = old.iter().collect();
    let mut come: Vec<(&Term, usize)> = Vec::new();
    for (part, number) in new.iter().zip(numbers) {
        match gone.iter().position(|other| *other == part) {
            Some(place) => {
                gone.remove(place);
            }
            None => come.push((part, *number)),
        }
    }
    if come.is_empty() {
        runs.push((number, number));
        return;
    }
    for (part, number) in come {
        let best = (0..gone.len()).max_by_key(|place| alike(gone[*place], part));
        match best {
            Some(place) => open.push((gone.remove(place).clone(), part.clone(), number)),
            None => runs.push((number, number)),
        }
    }
}

/// How much two parts have in common: the size of their equal direct parts.
fn alike(one: &Term, two: &Term) -> usize {
    let (one, two) = (parts(one), parts(two));
    let ends: usize = one.iter().rev().zip(two.iter().rev()).take_while(|(a, b)| a == b).map(|(a, _)| a.size()).sum();
    let heads = one.iter().zip(&two).filter(|(a, b)| a == b).count();
    let kinds =
        one.iter().zip(&two).filter(|(a, b)| std::mem::discriminant(a.node()) == std::mem::discriminant(b.node()));
    4 * ends + 2 * heads + kinds.count()
}
