//! What a part of a network may do before time passes, whatever values it has: more than it does, never less.

use std::collections::BTreeSet;

use super::stuck;
use crate::fact::Context;
use crate::name::Name;
use crate::substitution::{Stuck, instantiate};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Parts that are looked at.
const MOST_WORK: usize = 20_000;
/// Parts that may stand inside one another.
const DEEPEST: usize = 200;

/// What a part may do in this instant.
#[derive(Default)]
pub(super) struct Reach {
    /// The ports that it may read.
    pub(super) reads: BTreeSet<Name>,
    /// The ports that it may write.
    pub(super) writes: BTreeSet<Name>,
    /// Whether it may draw.
    pub(super) draws: bool,
    seen: BTreeSet<Term>,
    named: BTreeSet<Name>,
    work: usize,
}

impl Reach {
    /// What this part may do; `bound` are the names of which nothing is known.
    ///
    /// # Errors
    /// Where that is not known.
    pub(super) fn of(part: &Term, bound: &BTreeSet<Name>, context: &Context<'_>) -> Result<Reach, Stuck> {
        let mut reach = Reach::default();
        reach.through(part, bound, context, 0)?;
        Ok(reach)
    }

    /// Whether this port may be used.
    pub(super) fn uses(&self, port: &Name) -> bool {
        self.reads.contains(port) || self.writes.contains(port)
    }

    /// Whether it may both read and write this port.
    pub(super) fn answers(&self, port: &Name) -> bool {
        self.reads.contains(port) && self.writes.contains(port)
    }

    /// All ports that may be used.
    pub(super) fn ports(&self) -> impl Iterator<Item = &Name> {
        self.reads.iter().chain(&self.writes)
    }

    /// Notes what a part may do; whether it may end in this instant.
    fn through(
        &mut self,
        part: &Term,
        bound: &BTreeSet<Name>,
        context: &Context<'_>,
        depth: usize,
    ) -> Result<bool, Stuck> {
        self.work += 1;
        if self.work > MOST_WORK || depth > DEEPEST {
            return stuck("too much may happen in one instant");
        }
        let mut each = |parts: &[Term]| -> Result<Vec<bool>, Stuck> {
            parts.iter().map(|part| self.through(part, bound, context, depth + 1)).collect()
        };
        Ok(match part.node() {
            Node::Stop | Node::Abort | Node::Guard(..) | Node::Set(..) => true,
            Node::Idle | Node::Observe(..) => false,
            Node::Delay(time) => !surely_positive(time, bound, context),
            Node::Ran(..) => {
                self.draws = true;
                true
            }
            Node::In(port, _) => {
                self.reads.insert(port.clone());
                true
            }
            Node::Out(port, _) => {
                self.writes.insert(port.clone());
                true
            }
            Node::Seq(parts) => {
                for part in parts {
                    if !self.through(part, bound, context, depth + 1)? {
                        return Ok(false);
                    }
                }
                true
            }
            Node::Else(first, second) => {
                let ends = self.through(first, bound, context, depth + 1)?;
                if ends {
                    self.through(second, bound, context, depth + 1)?;
                }
                ends
            }
            Node::Par(parts) => each(parts)?.into_iter().all(|ends| ends),
            Node::Disable(parts) => each(parts)?.into_iter().any(|ends| ends),
            Node::Loop(body) => self.through(body, bound, context, depth + 1)?,
            Node::Power(body, ..) => {
                self.through(body, bound, context, depth + 1)?;
                true
            }
            Node::Call(name, arguments) => self.called(name, arguments, (bound, context), depth)?,
            // A port of its own counts as that of others of this name: more than it does.
            Node::New(_, body) | Node::Project(body, _) => self.through(body, bound, context, depth + 1)?,
            Node::Meta(name, _) | Node::Replace(_, name, _) => return stuck(format!("{name} is not known")),
        })
    }

    /// A call: with its arguments the first time, and then with any at all, so that calls come to an end; with any also
    /// where an argument reads a name that is bound, which may be bound again in the body.
    fn called(
        &mut self,
        name: &Name,
        arguments: &[Value],
        (bound, context): (&BTreeSet<Name>, &Context<'_>),
        depth: usize,
    ) -> Result<bool, Stuck> {
        let known = context.definitions.get(name);
        let Some(definition) = known.filter(|known| known.parameters.len() == arguments.len()) else {
            return stuck(format!("{name} is not defined so"));
        };
        let own = Term::new(Node::Call(name.clone(), arguments.to_vec()));
        if self.seen.contains(&own) {
            return Ok(true);
        }
        let any: Vec<Value> = (0..arguments.len()).map(|place| Value::variable(&anything(place))).collect();
        let reads = |value: &Value| value.variables().iter().any(|read| bound.contains(read));
        let plain = self.named.insert(name.clone()) && !arguments.iter().any(reads);
        let arguments = if plain { arguments.to_vec() } else { any };
        let call = Term::new(Node::Call(name.clone(), arguments.clone()));
        if !self.seen.insert(call) {
            return Ok(true);
        }
        let body = instantiate(&definition.body, &definition.parameters, &arguments, context)?;
        self.through(&body, bound, context, depth + 1)
    }
}

/// A value of which nothing is known; no source text can spell it.
fn anything(place: usize) -> Name {
    Name::new(&format!("!any{place}"))
}

/// Whether a delay surely lasts, whatever the names have that the network binds.
fn surely_positive(time: &Value, bound: &BTreeSet<Name>, context: &Context<'_>) -> bool {
    let known = &context.assumptions;
    !time.variables().iter().any(|name| bound.contains(name))
        && known.decide(Relation::Gtr, time, &Value::zero()) == Some(true)
}
