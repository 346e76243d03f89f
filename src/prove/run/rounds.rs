//! Rounds of a run: a number that is known one by one, and any number by a lemma about each of them.

use std::collections::BTreeMap;

use super::shape::{alike, between, polynomial, unused};
use super::{Follower, Lost, Stage, items, lost};
use crate::fact::Context;
use crate::law::Condition;
use crate::name::Name;
use crate::proof::{Lemma, Statement, Step, StepId};
use crate::scope::{bound_names, read_names};
use crate::substitution::{Substitution, substitute_values};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// Rounds that are looked at for how values change.
const FITTED: usize = 5;

/// Rounds of which each is as the others: what happens in one, under which name its number stands in it, and how many.
struct Alike<'r> {
    body: &'r Term,
    index: &'r Name,
    variable: Name,
    count: &'r Value,
}

fn put(term: &Term, name: &Name, value: Value) -> Result<Term, Lost> {
    substitute_values(term, &BTreeMap::from([(name.clone(), value)])).map_err(|stuck| Lost(stuck.0))
}

/// A network under the ports that a state hides.
fn under_ports(network: &Term, state: &Term) -> Term {
    match state.node() {
        Node::New(port, inside) => Term::new(Node::New(port.clone(), under_ports(network, inside))),
        _ => network.clone(),
    }
}

impl Follower<'_> {
    /// Rounds one by one: `state ~~ P^{i<n} ; next`.
    pub(super) fn counted(
        &mut self,
        body: &Term,
        index: Option<&Name>,
        number: usize,
        state: &Term,
    ) -> Result<(StepId, Term), Lost> {
        let power = |count: usize| Term::new(Node::Power(body.clone(), Value::integer(count as i64), index.cloned()));
        let law = |name: &str, at: usize| {
            let mut with = Substitution::default();
            with.processes.insert(Name::new("?P"), body.clone());
            if let Some(index) = index {
                with.names.insert(Name::new("?i"), index.clone());
            }
            if name.ends_with("step") {
                with.values.insert(Name::new("?n"), Value::integer(at as i64));
            }
            Step::Law(Name::new(name), with)
        };
        let names = if index.is_some() { ("rounds-zero", "rounds-step") } else { ("power-zero", "power-step") };
        // state = Stop ; state = P^0 ; state
        let mut with = Substitution::default();
        with.processes.insert(Name::new("?P"), state.clone());
        let stop = self.script.push(Step::Law(Name::new("seq-stop-left"), with));
        let none = self.script.push(law(names.0, 0));
        let none = self.before(none, state);
        let forward = self.script.chain(vec![none, stop]);
        let mut found = self.script.push(Step::Symmetric(forward));
        let mut state = state.clone();
        for done in 0..number {
            let round = match index {
                Some(index) => {
                    let map = BTreeMap::from([(index.clone(), Value::integer(done as i64))]);
                    substitute_values(body, &map).map_err(|stuck| Lost(stuck.0))?
                }
                None => body.clone(),
            };
            let (step, next) = self.along(&items(&round), state)?;
            let behind = self.behind(&[power(done)], step);
            let one_more = self.script.push(law(names.1, done));
            let back = self.script.push(Step::Symmetric(one_more));
            let back = self.before(back, &next);
            found = self.script.chain(vec![found, behind, back]);
            state = next;
        }
        Ok((found, state))
    }

    /// A number of rounds that is not known: all but the last by a lemma, and the last, after which another thing happens.
    pub(super) fn rounds(
        &mut self,
        body: &Term,
        index: Option<&Name>,
        count: &Value,
        state: &Term,
    ) -> Result<(StepId, Term), Lost> {
        let known = &self.context.assumptions;
        // So few that it is known how many.
        let few = [0, 1, 2]
            .into_iter()
            .find(|few| known.decide(Relation::Eq, count, &Value::integer(*few as i64)) == Some(true));
        if let Some(few) = few {
            let (step, next) = self.counted(body, index, few, state)?;
            let rounds = |count: &Value| {
                let power = Term::new(Node::Power(body.clone(), count.clone(), index.cloned()));
                Term::seq([power, next.clone()])
            };
            let step = self.same(step, &rounds(&Value::integer(few as i64)), &rounds(count))?;
            return Ok((step, next));
        }
        let whole = known.simplify(count);
        let fewer = whole.sub(&Value::one()).map_err(|error| Lost(error.0))?;
        if self.inside || known.is_natural(&fewer) != Some(true) {
            return lost(format!("{count} rounds"));
        }
        let Some(index) = index else { return self.uncounted(body, count, state) };
        let power = |count: &Value| Term::new(Node::Power(body.clone(), count.clone(), Some(index.clone())));
        let (step, state) = self.all_alike(body, index, &fewer, state)?;
        let last = substitute_values(body, &BTreeMap::from([(index.clone(), fewer.clone())]));
        let (last, next) = self.along(&items(&last.map_err(|stuck| Lost(stuck.0))?), state)?;
        let last = self.behind(&[power(&fewer)], last);
        let mut with = Substitution::default();
        with.processes.insert(Name::new("?P"), body.clone());
        with.names.insert(Name::new("?i"), index.clone());
        with.values.insert(Name::new("?n"), fewer);
        let one_more = self.script.push(Step::Law(Name::new("rounds-step"), with));
        let back = self.script.push(Step::Symmetric(one_more));
        let back = self.before(back, &next);
        let step = self.script.chain(vec![step, last, back]);
        let behind = |count: &Value| Term::seq([power(count), next.clone()]);
        let step = self.same(step, &behind(&whole), &behind(count))?;
        Ok((step, next))
    }

    /// Rounds that show nothing of their number, as rounds that have one: the system may be another in each.
    fn uncounted(&mut self, body: &Term, count: &Value, state: &Term) -> Result<(StepId, Term), Lost> {
        let index = self.plain_name(&[body, state], count);
        let (step, next) = self.rounds(body, Some(&index), count, state)?;
        let mut with = Substitution::default();
        with.processes.insert(Name::new("?P"), body.clone());
        with.names.insert(Name::new("?i"), index);
        with.values.insert(Name::new("?n"), count.clone());
        let alike = self.script.push(Step::Law(Name::new("rounds-alike"), with));
        let alike = self.before(alike, &next);
        Ok((self.script.chain(vec![step, alike]), next))
    }

    /// A name for the number of a round that nothing here and no definition mentions.
    fn plain_name(&self, terms: &[&Term], count: &Value) -> Name {
        let mut taken = count.variables();
        taken.extend(self.context.assumptions.variables());
        let bodies = self.theory.definitions.iter().map(|definition| &definition.body);
        for term in terms.iter().copied().chain(bodies) {
            taken.extend(read_names(term).into_iter().chain(bound_names(term)));
        }
        let names = (1..).map(|number| Name::new(&format!("round{number}")));
        std::iter::once(Name::new("i"))
            .chain(names)
            .find(|name| !taken.contains(name))
            .unwrap_or_else(|| Name::new("i"))
    }

    /// Rounds by a lemma about any one of them: `A(n) ~~ P(n) ; A(n+1)`. What changes in the first round by some step is
    /// taken to change so in all; the proof of the lemma tells whether it does.
    fn all_alike(&mut self, body: &Term, index: &Name, count: &Value, state: &Term) -> Result<(StepId, Term), Lost> {
        let variable = unused(&[state, body], count);
        let own = Value::variable(&variable);
        let mut hypotheses = self.context.hypotheses.to_vec();
        // The first of these rounds shows how values change.
        hypotheses.push(Condition::Compare(Relation::Gtr, count.clone(), Value::zero()));
        let first = put(body, index, Value::zero())?;
        let second = self.within(&hypotheses).along(&items(&first), state.clone())?.1;
        let inside = Context::new(&self.theory.assumptions, &self.theory.definitions, &hypotheses);
        let general = between(state, &second, (&own, &inside));
        hypotheses.pop();
        hypotheses.push(Condition::Natural(own.clone()));
        hypotheses.push(Condition::Compare(Relation::Lss, own, count.clone()));
        let rounds = Alike { body, index, variable, count };
        let why = match general.map(|general| self.by_lemma_or_as_found(&rounds, &hypotheses, &general, state)) {
            Some(Ok(done)) => return Ok(done),
            Some(Err(why)) => why,
            None => Lost("the rounds do not change in steps".to_string()),
        };
        if let Some(found) = self.through_first(&rounds, state)
            && let Ok(done) = self.by_lemma(&rounds, &hypotheses, &found, state)
        {
            return Ok(done);
        }
        for found in self.by_stages(&rounds, &hypotheses, state) {
            if let Ok(done) = self.by_lemma_or_as_found(&rounds, &hypotheses, &found, state) {
                return Ok(done);
            }
        }
        Err(why)
    }

    fn by_lemma_or_as_found(
        &mut self,
        rounds: &Alike<'_>,
        hypotheses: &[Condition],
        general: &Term,
        state: &Term,
    ) -> Result<(StepId, Term), Lost> {
        match self.by_lemma(rounds, hypotheses, general, state) {
            Err((why, Some(found))) => self.by_lemma(rounds, hypotheses, &found, state).map_err(|_| why),
            found => found.map_err(|(why, _)| why),
        }
    }

    /// How each of the rounds might begin by the closed forms of the phases that begin as the system is now: with their
    /// first round, or with the one behind it, where the first was told apart.
    fn by_stages(&self, rounds: &Alike<'_>, hypotheses: &[Condition], state: &Term) -> Vec<Term> {
        let own = Value::variable(&rounds.variable);
        let inside = self.within(hypotheses);
        let begins = |first: i64, stage: &Stage| -> Option<Term> {
            let number = own.add(&Value::integer(first)).ok()?;
            let network = put(&stage.network, &stage.number, number).ok()?;
            let general = inside.instant(&under_ports(&network, state)).ok()?.network();
            let start = put(&general, &rounds.variable, Value::zero()).ok()?;
            alike(&start, state, &self.context).then_some(general)
        };
        let mut found: Vec<Term> = Vec::new();
        for (first, stage) in [0, 1].into_iter().flat_map(|first| self.stages.iter().map(move |stage| (first, stage))) {
            found.extend(begins(first, stage).filter(|general| !found.contains(general)));
        }
        found
    }

    /// How each of the rounds might begin if the values that change are polynomials in its number: those through the
    /// first rounds, where there are so many.
    fn through_first(&self, rounds: &Alike<'_>, state: &Term) -> Option<Term> {
        let enough = self.context.assumptions.decide(Relation::Gte, rounds.count, &Value::integer(FITTED as i64));
        if enough != Some(true) {
            return None;
        }
        let mut prover = self.within(self.context.hypotheses);
        let mut states = vec![state.clone()];
        for done in 0..FITTED {
            let round = put(rounds.body, rounds.index, Value::integer(done as i64)).ok()?;
            let next = prover.along(&items(&round), states.last()?.clone()).ok()?.1;
            states.push(next);
        }
        polynomial(&states, &Value::variable(&rounds.variable))
    }

    /// The rounds by a lemma, where this is how each of them begins; if they do not begin so, how they might.
    ///
    /// What is decided in the first round, such as a test that holds, may be open in a round of which only the number is
    /// not known: the system then stands otherwise, as `try(P)` for P.
    fn by_lemma(
        &mut self,
        rounds: &Alike<'_>,
        hypotheses: &[Condition],
        general: &Term,
        state: &Term,
    ) -> Result<(StepId, Term), (Lost, Option<Term>)> {
        let plain = |why: Lost| (why, None);
        let Alike { body, index, variable, count } = rounds;
        let own = Value::variable(variable);
        let number = |value: Result<Value, _>| value.map_err(|error: crate::value::ValueError| plain(Lost(error.0)));
        let round = put(body, index, own.clone()).map_err(plain)?;
        let next = put(general, variable, number(own.add(&Value::one()))?).map_err(plain)?;
        let right = Term::seq([round.clone(), next]);
        let mut prover = self.within(hypotheses);
        let (step, found) = prover.along(&items(&round), general.clone()).map_err(plain)?;
        if let Err(why) = prover.same(step, &Term::seq([round.clone(), found.clone()]), &right) {
            let before = number(own.sub(&Value::one()))?;
            return Err((why, put(&found, variable, before).ok().filter(|found| found != general)));
        }
        let (connective, forgot, steps) = (prover.connective(), prover.forgot, prover.script.steps);
        let start = put(general, variable, Value::zero()).map_err(plain)?;
        let as_it_is = self.begins(state, &start).map_err(plain)?;
        self.forgot |= forgot;
        let statement = Statement { hypotheses: hypotheses.to_vec(), left: general.clone(), connective, right };
        let name = Name::new(&format!("Round{}", self.lemmas.len() + 1));
        self.lemmas.push(Lemma { name, statement, steps });
        let lemma = self.lemmas.len() - 1;
        let (variable, index, count) = (variable.clone(), (*index).clone(), (*count).clone());
        let after = put(general, &variable, count.clone()).map_err(plain)?;
        let step = self.script.push(Step::Rounds { lemma, variable, round, index, count });
        Ok((self.script.chain(as_it_is.into_iter().chain([step]).collect()), after))
    }

    /// A step from how the system is to how the first of the rounds begins, where they are not the same.
    fn begins(&mut self, state: &Term, start: &Term) -> Result<Option<StepId>, Lost> {
        if start == state {
            return Ok(None);
        }
        if alike(start, state, &self.context) {
            return Ok(Some(self.script.push(Step::Arithmetic(state.clone(), start.clone()))));
        }
        let (settled, now) = self.settled(start)?;
        if !alike(&now, state, &self.context) {
            return lost("the rounds do not start as the system is");
        }
        let settled = self.same(settled, &now, state)?;
        Ok(Some(self.script.push(Step::Symmetric(settled))))
    }
}
