//! In which order the parts of `|` and `#` are written: as they stood before, though a term keeps them sorted.

use std::collections::BTreeMap;

use super::{alike, numbers};
use crate::printer::Order;
use crate::term::{Node, Term};

/// The order for a term that keeps each part where it, or what it was before, stood; what is new comes last.
pub fn kept(before: &Term, order: &Order, after: &Term) -> Order {
    let mut found = Order::new();
    let mut open = vec![(before.clone(), 0usize, after.clone(), 0usize)];
    while let Some((before, old, after, new)) = open.pop() {
        if before == after {
            let inside = order.range(old..old.saturating_add(before.size()));
            found.extend(inside.map(|(number, places)| (number - old + new, places.clone())));
            continue;
        }
        let (was, now) = (numbered(&before, old), numbered(&after, new));
        match (before.node(), after.node()) {
            (Node::Par(_), Node::Par(_)) | (Node::Disable(_), Node::Disable(_)) => {
                let written: Vec<(Term, usize)> = match order.get(&old) {
                    Some(places) => places.iter().filter_map(|place| was.get(*place).cloned()).collect(),
                    None => was,
                };
                let came = paired(&written, &now);
                let mut places: Vec<usize> = (0..now.len()).collect();
                places.sort_by_key(|place| came.get(place).copied().unwrap_or(usize::MAX));
                if !places.is_sorted() {
                    found.insert(new, places);
                }
                for (place, from) in came {
                    open.push((written[from].0.clone(), written[from].1, now[place].0.clone(), now[place].1));
                }
            }
            (Node::Seq(_), _) | (_, Node::Seq(_)) => {
                // What is left of a sequence is its end.
                let pairs = ends(&before, old, was).into_iter().rev().zip(ends(&after, new, now).into_iter().rev());
                open.extend(pairs.map(|((one, old), (two, new))| (one, old, two, new)));
            }
            (one, two) if std::mem::discriminant(one) == std::mem::discriminant(two) && was.len() == now.len() => {
                open.extend(was.into_iter().zip(now).map(|((one, old), (two, new))| (one, old, two, new)));
            }
            _ => {}
        }
    }
    found
}

/// The direct parts, each with its number.
fn numbered(term: &Term, number: usize) -> Vec<(Term, usize)> {
    term.children().cloned().zip(numbers(term, number)).collect()
}

/// The parts of a sequence; what is none is one part.
fn ends(term: &Term, number: usize, parts: Vec<(Term, usize)>) -> Vec<(Term, usize)> {
    match term.node() {
        Node::Seq(_) => parts,
        _ => vec![(term.clone(), number)],
    }
}

/// For the parts now there, by their places, the places of what they were: equal ones first, then the likest.
fn paired(was: &[(Term, usize)], now: &[(Term, usize)]) -> BTreeMap<usize, usize> {
    let mut found = BTreeMap::new();
    let mut left: Vec<usize> = (0..was.len()).collect();
    for (place, (part, _)) in now.iter().enumerate() {
        if let Some(at) = left.iter().position(|from| was[*from].0 == *part) {
            found.insert(place, left.remove(at));
        }
    }
    for (place, (part, _)) in now.iter().enumerate() {
        if found.contains_key(&place) {
            continue;
        }
        let best = (0..left.len()).rev().max_by_key(|at| alike(&was[left[*at]].0, part));
        if let Some(at) = best {
            found.insert(place, left.remove(at));
        }
    }
    found
}
