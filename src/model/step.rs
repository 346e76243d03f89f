//! The moves, draws, time steps and observations of settled terms.

use std::collections::BTreeSet;

use num_rational::BigRational;

use super::{Action, Meaningless, Move, Observation};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::Value;

/// Stands for the value that is read or drawn until it is known; no source text can spell it.
const BLANK: &str = "(value)";

pub(super) fn blank() -> Value {
    Value::variable(&Name::new(BLANK))
}

/// The process after a move whose value was still open.
pub(super) fn fill(term: &Term, value: &Value) -> Term {
    match term.node() {
        Node::Set(open, name) if *open == blank() => Term::new(Node::Set(value.clone(), name.clone())),
        Node::Loop(_) => term.clone(),
        Node::Seq(parts) => {
            // Only the first part that has not yet ended can hold the blank.
            let mut parts = parts.to_vec();
            if let Some(place) = parts.iter().position(|part| !is_set(part)) {
                parts[place] = fill(&parts[place], value);
            }
            for part in &mut parts {
                if is_set(part) {
                    *part = fill(part, value);
                }
            }
            Term::seq(parts)
        }
        Node::Else(first, second) => Term::otherwise(fill(first, value), second.clone()),
        _ => {
            let children = term.children();
            if children.is_empty() {
                return term.clone();
            }
            let parts = children.into_iter().map(|part| fill(part, value)).collect();
            term.with_children(parts)
        }
    }
}

fn is_set(term: &Term) -> bool {
    matches!(term.node(), Node::Set(..))
}

/// Where the running part of a settled sequence stands.
pub(super) fn active(parts: &[Term]) -> usize {
    parts.iter().position(|part| !is_set(part)).unwrap_or(0)
}

/// The same parts, with the one at this place replaced.
pub(super) fn with_part(parts: &[Term], place: usize, part: Term) -> Vec<Term> {
    let mut parts = parts.to_vec();
    parts[place] = part;
    parts
}

/// The moves of a settled term in which no draw is due.
pub(super) fn moves(term: &Term) -> Vec<Move> {
    match term.node() {
        Node::In(port, name) => {
            let next = Term::new(Node::Set(blank(), name.clone()));
            vec![Move { action: Action::In(port.clone()), rule: "receive", next }]
        }
        Node::Out(port, value) => {
            let action = Action::Out(port.clone(), value.clone());
            vec![Move { action, rule: "send", next: Term::stop() }]
        }
        Node::Seq(parts) => {
            let place = active(parts);
            within(moves(&parts[place]), |next| Term::seq(with_part(parts, place, next)))
        }
        Node::Else(first, second) => within(moves(first), |next| Term::otherwise(next, second.clone())),
        Node::Par(parts) => side_by_side(parts, &|parts| Term::par(parts)),
        Node::Disable(parts) => side_by_side(parts, &|parts| Term::disable(parts)),
        Node::New(port, body) => {
            let mut inner = moves(body);
            inner.retain(|step| !matches!(&step.action, Action::In(c) | Action::Out(c, _) if c == port));
            within(inner, |next| Term::new(Node::New(port.clone(), next)))
        }
        Node::Project(body, _) | Node::Replace(body, ..) => within(moves(body), |next| term.with_children(vec![next])),
        _ => Vec::new(),
    }
}

fn within(mut steps: Vec<Move>, around: impl Fn(Term) -> Term) -> Vec<Move> {
    for step in &mut steps {
        step.next = around(std::mem::replace(&mut step.next, Term::stop()));
    }
    steps
}

/// The moves of each part, and a communication for each pair of a writer and a reader of one port.
fn side_by_side(parts: &[Term], join: &dyn Fn(Vec<Term>) -> Term) -> Vec<Move> {
    let each: Vec<Vec<Move>> = parts.iter().map(moves).collect();
    let mut all = Vec::new();
    for (writer, sending) in each.iter().enumerate() {
        for sent in sending {
            let Action::Out(port, value) = &sent.action else { continue };
            for (reader, receiving) in each.iter().enumerate().filter(|(reader, _)| *reader != writer) {
                for received in receiving {
                    if matches!(&received.action, Action::In(open) if open == port) {
                        let mut next = with_part(parts, writer, sent.next.clone());
                        next[reader] = received.with(value);
                        let action = Action::Tau(port.clone(), value.clone());
                        all.push(Move { action, rule: "communicate", next: join(next) });
                    }
                }
            }
        }
    }
    for (place, steps) in each.into_iter().enumerate() {
        all.extend(within(steps, |next| join(with_part(parts, place, next))));
    }
    all
}

/// Calls `visit` with every leaf of a settled term that is running now.
pub(super) fn running<'t>(term: &'t Term, visit: &mut dyn FnMut(&'t Term)) {
    match term.node() {
        Node::Seq(parts) => running(&parts[active(parts)], visit),
        Node::Else(first, _) => running(first, visit),
        Node::Par(parts) | Node::Disable(parts) => parts.iter().for_each(|part| running(part, visit)),
        Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => running(body, visit),
        _ => visit(term),
    }
}

/// The time until the first delay runs out.
pub(super) fn next_event(term: &Term) -> Option<BigRational> {
    let mut least: Option<BigRational> = None;
    running(term, &mut |leaf| {
        if let Node::Delay(time) = leaf.node()
            && let Some(time) = time.as_rational()
            && least.as_ref().is_none_or(|least| time < *least)
        {
            least = Some(time);
        }
    });
    least
}

/// The term after this time, which no running delay is shorter than.
pub(super) fn pass(term: &Term, time: &BigRational) -> Result<Term, Meaningless> {
    with_delays(term, &|left| (left >= time).then(|| left - time))
}

/// The term with what is left of each running delay changed so; none says that it has run out before.
pub(super) fn with_delays(
    term: &Term,
    change: &dyn Fn(&BigRational) -> Option<BigRational>,
) -> Result<Term, Meaningless> {
    let inner = |part: &Term| with_delays(part, change);
    match term.node() {
        Node::Delay(left) => match left.as_rational().and_then(|left| change(&left)) {
            Some(left) => Ok(Term::delay(Value::rational(left))),
            None => Meaningless::because("a delay has run out before"),
        },
        Node::Seq(parts) => {
            let place = active(parts);
            Ok(Term::seq(with_part(parts, place, inner(&parts[place])?)))
        }
        Node::Else(first, second) => Ok(Term::otherwise(inner(first)?, second.clone())),
        Node::Par(parts) | Node::Disable(parts) => {
            let parts = parts.iter().map(inner).collect::<Result<Vec<_>, _>>()?;
            Ok(term.with_children(parts))
        }
        Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => {
            Ok(term.with_children(vec![inner(body)?]))
        }
        _ => Ok(term.clone()),
    }
}

/// Adds what the term shows, as far as the projections around it let it.
pub(super) fn observe(term: &Term, shown: Option<&BTreeSet<Name>>, all: &mut BTreeSet<Observation>) {
    match term.node() {
        Node::Observe(name, values) if shown.is_none_or(|shown| shown.contains(name)) => {
            all.insert((name.clone(), values.clone()));
        }
        Node::Project(body, names) => match shown {
            Some(shown) => observe(body, Some(&shown.intersection(names).cloned().collect()), all),
            None => observe(body, Some(names), all),
        },
        Node::Seq(parts) => observe(&parts[active(parts)], shown, all),
        Node::Else(first, _) => observe(first, shown, all),
        Node::Par(parts) | Node::Disable(parts) => parts.iter().for_each(|part| observe(part, shown, all)),
        Node::New(_, body) | Node::Replace(body, ..) => observe(body, shown, all),
        _ => {}
    }
}
