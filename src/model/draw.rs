//! Random draws: due as soon as they are reached, and made all at once, whatever the order of the parts.

use num_rational::BigRational;
use num_traits::{One, Zero};

use super::step::{active, blank, running, with_part};
use super::{Action, Meaningless, Move, State};
use crate::name::Name;
use crate::term::{Node, Term};
use crate::value::{Value, View};

/// The most branches of all draws that are due at once.
const MOST_BRANCHES: usize = 1_000;

/// The values of a finite distribution, with their chances.
type Chances = Vec<(BigRational, Value)>;

/// The branches of the draws that are due in a settled term; none if no draw is.
pub(super) fn draws(term: &Term) -> Result<Option<Vec<Move>>, Meaningless> {
    let mut due = Vec::new();
    running(term, &mut |leaf| {
        if let Node::Ran(distribution, _) = leaf.node() {
            due.push(distribution.clone());
        }
    });
    if due.is_empty() {
        return Ok(None);
    }
    let mut branches: Vec<(BigRational, Vec<Value>)> = vec![(BigRational::one(), Vec::new())];
    for (place, distribution) in due.iter().enumerate() {
        let Some(chances) = finite(distribution, &BigRational::one(), 0)? else {
            let next = drawn(term, &mut due.iter().enumerate().map(|(other, _)| (other == place).then(blank)));
            let action = Action::Draw(vec![distribution.clone()], None);
            return Ok(Some(vec![Move { action, rule: "draw", next }]));
        };
        let total: BigRational = chances.iter().map(|(chance, _)| chance.clone()).sum();
        if !total.is_one() {
            return Meaningless::because(format!("the chances of `{distribution}` add up to {total}"));
        }
        if branches.len() * chances.len() > MOST_BRANCHES {
            return Meaningless::because("too many draws at once");
        }
        let longer = |(before, values): &(BigRational, Vec<Value>)| {
            let extend = |(chance, value): &(BigRational, Value)| {
                (before * chance, values.iter().chain([value]).cloned().collect())
            };
            chances.iter().map(extend).collect::<Vec<_>>()
        };
        branches = branches.iter().flat_map(longer).filter(|(chance, _)| !chance.is_zero()).collect();
    }
    let branch = |(chance, values): (BigRational, Vec<Value>)| {
        let next = drawn(term, &mut values.iter().cloned().map(Some));
        Move { action: Action::Draw(due.clone(), Some((values, chance))), rule: "draw", next }
    };
    Ok(Some(branches.into_iter().map(branch).collect()))
}

/// The term with the draws that are due made, in the order in which [`running`] meets them; none leaves one due.
fn drawn(term: &Term, values: &mut dyn Iterator<Item = Option<Value>>) -> Term {
    match term.node() {
        Node::Ran(_, name) => match values.next().flatten() {
            Some(value) => Term::new(Node::Set(value, name.clone())),
            None => term.clone(),
        },
        Node::Seq(parts) => {
            let place = active(parts);
            Term::seq(with_part(parts, place, drawn(&parts[place], values)))
        }
        Node::Else(first, second) => Term::otherwise(drawn(first, values), second.clone()),
        Node::Par(parts) | Node::Disable(parts) => {
            term.with_children(parts.iter().map(|part| drawn(part, values)).collect())
        }
        Node::New(_, body) | Node::Project(body, _) | Node::Replace(body, ..) => {
            term.with_children(vec![drawn(body, values)])
        }
        _ => term.clone(),
    }
}

fn finite(distribution: &Value, scale: &BigRational, depth: usize) -> Result<Option<Chances>, Meaningless> {
    let View::Distribution(kind, arguments) = distribution.view() else {
        return Meaningless::because(format!("`{distribution}` is not a distribution"));
    };
    if depth > 20 {
        return Meaningless::because("a mixture nests too deeply");
    }
    match (kind.as_str(), arguments.as_slice()) {
        ("Point", [value]) => Ok(Some(vec![(scale.clone(), value.clone())])),
        ("Mix", parts) => {
            let mut all = Vec::new();
            for pair in parts.chunks(2) {
                let [weight, part] = pair else { return Meaningless::because("a mixture lacks a weight") };
                let Some(weight) = weight.as_rational().filter(|weight| *weight >= BigRational::zero()) else {
                    return Meaningless::because(format!("`{weight}` is not a weight"));
                };
                match finite(part, &(scale * weight), depth + 1)? {
                    Some(more) => all.extend(more),
                    None => return Ok(None),
                }
            }
            Ok(Some(all))
        }
        _ => Ok(None),
    }
}

/// How the names of values begin that were drawn and are not known; no source text can spell it.
const DRAWN: &str = "(draw ";

/// Whether this is the name of a value that was drawn and is not known.
pub(super) fn is_drawn(name: &Name) -> bool {
    name.as_str().starts_with(DRAWN)
}

/// Whether the value depends on one that was drawn and is not known.
pub(crate) fn mentions_drawn(value: &Value) -> bool {
    value.variables().iter().any(is_drawn)
}

impl State {
    /// Whether it holds a value that was drawn and is not known.
    pub(crate) fn holds_drawn(&self) -> bool {
        !self.drawn_names().is_empty()
    }

    /// Whether it holds this symbol.
    pub(crate) fn mentions(&self, symbol: &Value) -> bool {
        self.drawn_names().iter().any(|name| symbol.mentions(name))
    }

    fn drawn_names(&self) -> Vec<Name> {
        let of = |value: &Value| value.variables().into_iter().filter(is_drawn).collect::<Vec<_>>();
        match self {
            State::Stopped(results) => results.values().flat_map(of).collect(),
            State::Aborted => Vec::new(),
            State::Running(term) => {
                let (mut open, mut found) = (vec![term], Vec::new());
                while let Some(term) = open.pop() {
                    term.values().for_each(|value| found.extend(of(value)));
                    open.extend(term.children());
                }
                found
            }
        }
    }

    /// A name for the next value that this state draws from this distribution, which it does not hold yet.
    pub(crate) fn next_drawn(&self, distribution: &impl std::fmt::Display) -> Value {
        let held = self.drawn_names();
        let name = |number: usize| match number {
            1 => Name::new(&format!("{DRAWN}from {distribution})")),
            _ => Name::new(&format!("{DRAWN}{number} from {distribution})")),
        };
        // One of the first is free: it holds no more than those.
        let free = (1..=held.len() + 1).map(name).find(|name| !held.contains(name));
        Value::variable(&free.unwrap_or_else(|| name(held.len() + 2)))
    }
}
