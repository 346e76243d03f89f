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
//! ordered, has no such moment, but may have several (`apart.rs`).

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::{Instant, closed, is_drawing, leaves, rebuilt, stuck};
use crate::fact::Context;
use crate::name::Name;
use crate::scope::{bound_names, calls, condition_parts, subterms};
use crate::substitution::{Stuck, substitute_values};
use crate::term::{Node, Term};
use crate::value::{Sort, Value, View};

/// Whether a settled term is about to draw.
pub(super) fn is_due(state: &Term) -> bool {
    leaves(state).iter().any(|leaf| is_drawing(leaf.term))
}

/// Whether a network, or a process that it calls, draws anywhere.
pub(super) fn may_be_due(network: &Term, context: &Context<'_>) -> bool {
    let draws = |term: &Term| subterms(term).into_iter().any(is_drawing);
    let mut seen = BTreeSet::new();
    let mut work = vec![network.clone()];
    while let Some(term) = work.pop() {
        if draws(&term) {
            return true;
        }
        let more = calls(&term).into_iter().filter(|name| seen.insert(name.clone()));
        work.extend(more.filter_map(|name| context.definitions.get(&name)).map(|known| known.body.clone()));
    }
    false
}

/// What the number of this place among all that are drawn is called as long as it has no name; no source text can spell
/// it.
pub fn nth(place: usize) -> Name {
    Name::new(&format!("!{place}"))
}

/// What is drawn, and what then is.
#[derive(Clone, Debug)]
pub(super) struct Due {
    /// Under which name each value is drawn, and from what; that may mention what is drawn before it.
    pub(super) drawn: Vec<(Name, Value)>,
    /// What is drawn at each moment, in each branch one after the other.
    pub(super) branches: Vec<Vec<Range<usize>>>,
    /// Whether it communicates before.
    pub(super) later: bool,
    /// The network with what was drawn.
    pub(super) after: Term,
}

impl Due {
    /// What is due in this state.
    pub(super) fn at_once(state: &Term, later: bool) -> Due {
        let mut drawn = Vec::new();
        let after = rebuilt(state, &mut 0, &mut |_, leaf| {
            let Node::Ran(from, name) = leaf.node() else { return None };
            drawn.push((name.clone(), from.clone()));
            Some(Term::new(Node::Set(Value::variable(&nth(drawn.len() - 1)), name.clone())))
        });
        let all = 0..drawn.len();
        let branches = vec![vec![all]];
        Due { drawn, branches, later, after }
    }
}

/// A network that is about to draw, now or once it has communicated.
#[derive(Clone, Debug)]
pub struct Draws {
    instant: Instant,
    due: Due,
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
            (instant, Some(due)) => Ok(Draws { instant, due }),
        }
    }

    /// Under which name each value is drawn, and from what, in the order in which they are named. What is drawn may
    /// depend on what is drawn before in the same branch, which is called by its place ([`nth`]).
    pub fn due(&self) -> &[(Name, Value)] {
        &self.due.drawn
    }

    /// What the network is weakly equal to: the draws, each bound to one of these names, and the network with what was
    /// drawn.
    ///
    /// # Errors
    /// Where there is not one name for each draw, a name stands anywhere else, or what is drawn from is no distribution of
    /// numbers.
    pub fn made(&self, names: &[Name], context: &Context<'_>) -> Result<Term, Stuck> {
        self.may_be_named(names, context)?;
        let known = named(names);
        let mut branches = Vec::new();
        for moments in &self.due.branches {
            let mut parts = Vec::new();
            for moment in moments {
                let (due, own) = (&self.due.drawn[moment.clone()], &names[moment.clone()]);
                if self.due.later {
                    parts.push(self.tau(own)?);
                }
                for ((_, from), own) in due.iter().zip(own) {
                    parts.push(Term::new(Node::Ran(from.substitute(&known)?, own.clone())));
                }
            }
            branches.push(Term::seq(parts));
        }
        Ok(Term::seq([Term::par(branches), self.after(names)?]))
    }

    /// The network with what was drawn, under these names.
    ///
    /// # Errors
    /// Where a value has no normal form.
    pub fn after(&self, names: &[Name]) -> Result<Term, Stuck> {
        Ok(closed(&self.instant.ports, substitute_values(&self.due.after, &named(names))?))
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
        taken.extend(self.instant.names.iter().chain(self.instant.ports.iter()).cloned());
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
            taken.extend(part.values().flat_map(Value::variables));
            taken.extend(bound_names(part));
            if let Node::New(port, _) | Node::In(port, _) | Node::Out(port, _) = part.node() {
                taken.insert(port.clone());
            }
        }
        taken
    }

    /// A communication that nobody sees, and that binds nothing.
    fn tau(&self, names: &[Name]) -> Result<Term, Stuck> {
        let own = subterms(&self.instant.state).find_map(|part| match part.node() {
            Node::New(port, _) => Some(port),
            _ => None,
        });
        let (Some(port), Some(name)) = (self.instant.ports.first().or(own), names.first()) else {
            return stuck("nothing communicates");
        };
        let read = Term::seq([Term::new(Node::In(port.clone(), name.clone())), Term::abort()]);
        let write = Term::new(Node::Out(port.clone(), Value::zero()));
        Ok(Term::new(Node::New(port.clone(), Term::par([read, write]))))
    }
}

/// The names for what is drawn.
fn named(names: &[Name]) -> BTreeMap<Name, Value> {
    names.iter().enumerate().map(|(place, name)| (nth(place), Value::variable(name))).collect()
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
