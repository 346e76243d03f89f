//! What a closed network draws: all draws that are due at once, before anything else happens.
//!
//! `N` is weakly equal to `Ran_D1<e1> ; … ; Ran_Dm<em> ; N(e1, …, em)` if the draws are due at once, and to `Tau ;` that
//! if `N` communicates before, whatever the order, until they are. Each draw is bound to a name of its own, that stands
//! nowhere else: so no two are one, and what follows is said of every value that they may have.
//!
//! Why: draws are made before any move, all that are due together and independently, and `N` has then become
//! `N(v1, …, vm)`, whichever side drew; so this is strong equality. It is of a network that never stops, for what is drawn
//! first would be carried too. The communications before the draws do not go: weak equality tells whether a draw was made
//! before something beside it moved. But all states on the way to the draws are one up to weak equality: each runs,
//! lets no time pass, does nothing but communicate inside, and comes to that one moment, whatever the order. `Tau`
//! does that too, and binds nothing. A network that may come to one draw before another, as its communications are
//! ordered, has no such moment.

use std::collections::BTreeSet;

use super::{Instant, closed, leaves, rebuilt, stuck};
use crate::fact::Context;
use crate::name::Name;
use crate::scope::{bound_names, condition_parts, subterms};
use crate::substitution::Stuck;
use crate::term::{Node, Term};
use crate::value::{Sort, Value, View};

/// Whether a settled term is about to draw.
pub(super) fn is_due(state: &Term) -> bool {
    leaves(state).into_iter().any(|leaf| matches!(leaf.node(), Node::Ran(..)))
}

/// A network that is about to draw, now or once it has communicated.
#[derive(Clone, Debug)]
pub struct Draws {
    instant: Instant,
    /// Whether it communicates before.
    later: bool,
}

impl Draws {
    /// What the network draws in the instant in which it is.
    ///
    /// # Errors
    /// As for [`Instant::of`]; and where nothing is drawn, or the network may stop.
    pub fn of(network: &Term, context: &Context<'_>) -> Result<Draws, Stuck> {
        match Instant::or_draws(network, context)? {
            (_, None) => stuck("nothing is drawn"),
            (instant, _) if !instant.kept.is_empty() => stuck("it draws, and may stop: what is drawn may be carried"),
            (instant, Some(later)) => Ok(Draws { instant, later }),
        }
    }

    /// Under which name each value is drawn, and from what, in the order of the network.
    pub fn due(&self) -> Vec<(Name, Value)> {
        let drawn = |leaf: &Term| match leaf.node() {
            Node::Ran(from, name) => Some((name.clone(), from.clone())),
            _ => None,
        };
        leaves(&self.instant.state).into_iter().filter_map(drawn).collect()
    }

    /// What the network is weakly equal to: the draws, each bound to one of these names, and the network with what was
    /// drawn.
    ///
    /// # Errors
    /// Where there is not one name for each draw, a name stands anywhere else, or what is drawn from is no distribution of
    /// numbers.
    pub fn made(&self, names: &[Name], context: &Context<'_>) -> Result<Term, Stuck> {
        self.may_be_named(names, context)?;
        let due = self.due();
        let draws = due.iter().zip(names).map(|((_, from), own)| Term::new(Node::Ran(from.clone(), own.clone())));
        let before = if self.later { Some(self.tau(names)?) } else { None };
        Ok(Term::seq(before.into_iter().chain(draws).chain([self.after(names)])))
    }

    /// The network with what was drawn, under these names.
    pub fn after(&self, names: &[Name]) -> Term {
        let mut fresh = names.iter();
        let drawn = rebuilt(&self.instant.state, &mut 0, &mut |_, leaf| {
            let Node::Ran(_, name) = leaf.node() else { return None };
            fresh.next().map(|own| Term::new(Node::Set(Value::variable(own), name.clone())))
        });
        closed(&self.instant.ports, drawn)
    }

    /// There is one name for each draw, which stands nowhere else, and numbers are drawn.
    fn may_be_named(&self, names: &[Name], context: &Context<'_>) -> Result<(), Stuck> {
        let due = self.due();
        if names.len() != due.len() {
            return stuck(format!("{} names for {} draws", names.len(), due.len()));
        }
        let mut taken = self.taken(context);
        if let Some(name) = names.iter().find(|name| name.is_meta() || !taken.insert((*name).clone())) {
            return stuck(format!("{name} stands for something else"));
        }
        match due.iter().find(|(_, from)| !of_numbers(from)) {
            Some((_, from)) => stuck(format!("{from} is no distribution of numbers")),
            None => Ok(()),
        }
    }

    /// All names that the network, a definition, an assumption or a hypothesis speaks of.
    fn taken(&self, context: &Context<'_>) -> BTreeSet<Name> {
        let mut taken = context.assumptions.variables();
        taken.extend(self.instant.names.iter().chain(&self.instant.ports).cloned());
        let mut terms = vec![&self.instant.state];
        for definition in context.definitions.iter() {
            taken.extend(definition.parameters.iter().cloned());
            terms.push(&definition.body);
        }
        for hypothesis in context.hypotheses {
            let (inside, values, names) = condition_parts(hypothesis);
            terms.extend(inside);
            taken.extend(values.into_iter().flat_map(Value::variables).chain(names.into_iter().cloned()));
        }
        for part in terms.into_iter().flat_map(subterms) {
            taken.extend(part.values().into_iter().flat_map(Value::variables));
            taken.extend(bound_names(part));
            if let Node::New(port, _) | Node::In(port, _) | Node::Out(port, _) = part.node() {
                taken.insert(port.clone());
            }
        }
        taken
    }

    /// A communication that nobody sees, and that binds nothing.
    fn tau(&self, names: &[Name]) -> Result<Term, Stuck> {
        let (Some(port), Some(name)) = (self.instant.ports.first(), names.first()) else {
            return stuck("nothing communicates");
        };
        let read = Term::seq([Term::new(Node::In(port.clone(), name.clone())), Term::abort()]);
        let write = Term::new(Node::Out(port.clone(), Value::zero()));
        Ok(Term::new(Node::New(port.clone(), Term::par([read, write]))))
    }
}

/// Whether this is a distribution of numbers that PARS knows: a name, or one of vectors, is not.
fn of_numbers(value: &Value) -> bool {
    let View::Distribution(kind, parts) = value.view() else { return false };
    let real = |part: &Value| part.sort() == Sort::Real;
    match kind.as_str() {
        "Mix" => parts.chunks(2).all(|pair| matches!(pair, [weight, part] if real(weight) && of_numbers(part))),
        "Normal" | "Uniform" | "Exp" | "Poisson" | "Point" => parts.iter().all(real),
        _ => false,
    }
}
