//! Steps about what runs: a network through an instant and on, rounds that are counted, rounds without end.

use std::collections::{BTreeMap, BTreeSet};

use super::{Checker, Derived, Reason, no_supposition, same};
use crate::advance::Instant;
use crate::advance::draw::Draws;
use crate::fact::{Context, Facts};
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{StepId, successor};
use crate::scope::{bound_names, condition_mentions, metavariables, read_names, subterms, written};
use crate::substitution::{Stuck, substitute_known};
use crate::term::{Node, Term};
use crate::value::{Need, Relation, Value};

impl Checker<'_> {
    /// A network is weakly equal to what it shows for this time and what it then is, to what it is at the end of this
    /// instant, or to what it shows for ever.
    pub(super) fn advance(&mut self, network: &Term, time: Option<&Value>) -> Result<Derived, Reason> {
        let stuck = |stuck: Stuck| Reason::Advance(stuck.0);
        let instant = Instant::of(network, &self.context).map_err(stuck)?;
        let right = instant.onward(time, &self.context).map_err(stuck)?;
        self.has_read(network)?;
        self.advanced = true;
        Ok(Derived { connective: Connective::Weak, ..Derived::equal(network.clone(), right) })
    }

    /// What was read on the way has a meaning too: a guard that was decided stands in nothing that comes of it, and what comes
    /// of it is the start of another step. What stands in the network as it begins is needed by whoever speaks of it.
    fn has_read(&mut self, network: &Term) -> Result<(), Reason> {
        let read = std::mem::take(&mut *self.context.read.borrow_mut());
        if read.is_empty() {
            return Ok(());
        }
        let own: BTreeSet<Need> = subterms(network).flat_map(Term::values).flat_map(Value::needs).collect();
        let known = &self.context.assumptions;
        for need in read {
            self.meaning.require(need.clone(), known)?;
            let mut parts = need.apart().into_iter();
            if !parts.all(|part| part.follows_from(&own) || known.grants(&part) == Some(true)) {
                self.reads.insert(need);
            }
        }
        Ok(())
    }

    /// A network is weakly equal to what it draws in this instant, each value under a name of its own, and then the
    /// network with what was drawn.
    pub(super) fn draw(&mut self, network: &Term, names: &[Name]) -> Result<Derived, Reason> {
        let stuck = |stuck: Stuck| Reason::Advance(stuck.0);
        let draws = Draws::of(network, &self.context).map_err(stuck)?;
        let right = draws.made(names, &self.context).map_err(stuck)?;
        self.has_read(network)?;
        self.advanced = true;
        Ok(Derived { connective: Connective::Weak, ..Derived::equal(network.clone(), right) })
    }

    /// From `A(n) = P(n) ; A(n+1)` for every natural n < N: `A(0) = P(0) ; … ; P(N-1) ; A(N)`, by induction on N,
    /// each equation used behind the rounds before it.
    pub(super) fn rounds(
        &mut self,
        lemma: usize,
        variable: &Name,
        round: &Term,
        (index, count): (&Name, &Value),
    ) -> Result<Derived, Reason> {
        let proved = self.proved;
        let (name, theorem) = proved.get(lemma).ok_or(Reason::NotEarlier(lemma))?;
        let statement = theorem.statement();
        self.may_count(variable, index, count, [&statement.left, &statement.right, round])?;
        let own = [
            Condition::Natural(Value::variable(variable)),
            Condition::Compare(Relation::Lss, Value::variable(variable), count.clone()),
        ];
        let here: Vec<Condition> = self.context.hypotheses.iter().cloned().chain(own).collect();
        let inside = Context::new(&self.theory.assumptions, &self.theory.definitions, &here);
        if let Some(missing) = statement.hypotheses.iter().find(|hypothesis| !inside.holds(hypothesis)) {
            return Err(Reason::Condition(Box::new(missing.clone())));
        }
        let at = |term: &Term, value: Value| {
            let map = BTreeMap::from([(variable.clone(), value)]);
            substitute_known(term, &map, &inside.assumptions).map_err(|stuck: Stuck| Reason::Stuck(stuck.0))
        };
        let next = successor(&Value::variable(variable)).ok_or(Reason::TooLarge)?;
        same(&statement.right, &Term::seq([round.clone(), at(&statement.left, next)?]))?;
        let left = at(&statement.left, Value::zero())?;
        let body = at(round, Value::variable(index))?;
        let rounds = Term::new(Node::Power(body, count.clone(), Some(index.clone())));
        let right = Term::seq([rounds, at(&statement.left, count.clone())?]);
        if theorem.advanced {
            self.speaks_of_known([&left, &right])?;
        }
        self.meaning.instance(&theorem.needs, &BTreeMap::new(), &self.context.assumptions)?;
        if theorem.needs.iter().any(|need| need.value().mentions(variable)) {
            return Err(Reason::NotNatural(variable.clone()));
        }
        self.rests_on(name, theorem);
        Ok(Derived { left, connective: statement.connective, right, supposed: BTreeSet::new() })
    }

    /// The number of the round stands for itself alone: nothing else speaks of it or of the index, nothing binds them.
    fn may_count(&self, variable: &Name, index: &Name, count: &Value, terms: [&Term; 3]) -> Result<(), Reason> {
        if !self.context.holds(&Condition::Natural(count.clone())) {
            return Err(Reason::Sort(Box::new(count.clone())));
        }
        let definitions = &self.theory.definitions;
        let spoken_of = |name: &Name| {
            count.mentions(name)
                || self.context.assumptions.variables().contains(name)
                || self.context.hypotheses.iter().any(|other| condition_mentions(other, name))
                || terms
                    .iter()
                    .any(|term| bound_names(term).contains(name) || written(term, definitions).contains(name))
                || definitions.iter().any(|definition| {
                    read_names(&definition.body).contains(name) || bound_names(&definition.body).contains(name)
                })
        };
        if !variable.is_meta() || spoken_of(variable) {
            return Err(Reason::NotNatural(variable.clone()));
        }
        let names: BTreeSet<Name> = terms.iter().flat_map(|term| metavariables(term)).collect();
        let read = terms.iter().any(|term| read_names(term).contains(index));
        if index == variable || read || names.contains(index) || spoken_of(index) {
            return Err(Reason::Name(index.clone()));
        }
        // What is known under hypotheses is known of values that no part binds; the count is one of them.
        let bound: BTreeSet<Name> = terms.iter().flat_map(|term| written(term, definitions)).collect();
        match count.variables().into_iter().find(|name| bound.contains(name)) {
            Some(name) => Err(Reason::Name(name)),
            None => Ok(()),
        }
    }

    pub(super) fn unique_loop(&self, body: &Term, equation: StepId) -> Result<Derived, Reason> {
        if self.earlier(equation)?.connective == Connective::Weak {
            return self.weak_loop(body, equation);
        }
        let derived = self.equation(equation)?;
        no_supposition(derived)?;
        if Facts::of(body, &self.context).instant_stop {
            return Err(Reason::Unguarded(Box::new(body.clone())));
        }
        let round = Term::attempt(Term::seq([body.clone(), derived.left.clone()]));
        same(&derived.right, &round)?;
        Ok(Derived::equal(derived.left.clone(), Term::new(Node::Loop(body.clone()))))
    }

    /// From `X ~~ P ; X`, where P is silent and always stops, after a time d > 0: `X ~~ loop(P)`.
    ///
    /// `loop(P)` is `P ; loop(P)`, as P cannot abort. Relate A with B if for some state Y of P that still runs
    /// `A ~~ Y ; X` and `B ~~ Y ; loop(P)`. All that Y does is let time pass, so a step of A within what is left of Y
    /// leads to such a pair again, a silent one with the same Y, and meanwhile both show what Y shows. A longer time is
    /// cut where Y ends: there `Y ; X` has become a state that X reaches by internal steps, which is weakly P ; X, as P
    /// makes none, and so is A; and B is weakly P ; loop(P). Every such cut takes d, so a time needs finitely many. The
    /// relation is thus a weak bisimulation, in which both sides always run. It need not be one where P takes no time or
    /// communicates: `X ~~ Tau ; X` holds of every X that runs.
    fn weak_loop(&self, body: &Term, equation: StepId) -> Result<Derived, Reason> {
        let derived = self.earlier(equation)?;
        no_supposition(derived)?;
        lasts(body, &self.context)?;
        // Where a round may abort, more is needed.
        if derived.right != Term::seq([body.clone(), derived.left.clone()]) {
            return Err(Reason::Weaker(Connective::Weak, Connective::Equal));
        }
        let forever = Term::new(Node::Loop(body.clone()));
        Ok(Derived { connective: Connective::Weak, ..Derived::equal(derived.left.clone(), forever) })
    }
}

/// How long a part lasts that neither communicates, draws, binds nor aborts, and always stops after a time that is
/// certainly more than 0.
pub(super) fn lasts(body: &Term, context: &Context<'_>) -> Result<Value, Reason> {
    let facts = Facts::of(body, context);
    let more = |time: &&Value| context.assumptions.decide(Relation::Gtr, time, &Value::zero()) == Some(true);
    match facts.duration.as_ref().filter(more) {
        Some(time) if !facts.communicates && !facts.draws && !facts.may_abort && facts.binds.is_empty() => {
            Ok(time.clone())
        }
        _ => Err(Reason::Untimed(Box::new(body.clone()))),
    }
}
