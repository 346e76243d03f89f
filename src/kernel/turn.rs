//! Turns without end from whose start to the next some values move on.

use std::collections::{BTreeMap, BTreeSet};

use super::run::lasts;
use super::{Checker, Derived, Reason, same};
use crate::fact::{Context, Facts};
use crate::law::{Condition, Connective};
use crate::name::Name;
use crate::proof::{Moving, carried_on};
use crate::scope::{bound_names, condition_mentions, condition_parts, metavariables, read_names, subterms, written};
use crate::substitution::{Stuck, substitute_known};
use crate::term::{Node, Term};
use crate::value::{Need, Sort, Value};

impl Checker<'_> {
    /// From `A(x) ~~ P(x) ; A(f(x))` for every x that meets H, where H holds of s, and of f(x) wherever it holds of x:
    /// `A(s) ~~ T(s)`, where `T(x)` is `Set_x<y> ; loop(P(y) ; Set_{f(y)}<y>)`, or `loop(P)` if P does not speak of x.
    ///
    /// By induction every x of the turns meets H. `T(x)` becomes `P(x) ; T(f(x))` at once: `Set` ends as it begins, and
    /// P cannot abort, so the loop goes on. Relate A with B if for some x of the turns and some state Y of `P(x)` that
    /// still runs `A ~~ Y ; A(f(x))` and `B ~~ Y ; T(f(x))`. As in a weak loop this is a weak bisimulation in which both
    /// sides always run: Y does nothing but let time pass, and each turn takes the same time d > 0, so that a time needs
    /// finitely many. Nothing on either side ever stops, so no results are compared. Where the lemma is a refinement, the
    /// left sides may show more on the way, and so may A.
    pub(super) fn turns(&mut self, lemma: usize, turn: &Term, moving: &[Moving]) -> Result<Derived, Reason> {
        let proved = self.proved;
        let (name, theorem) = proved.get(lemma).ok_or(Reason::NotEarlier(lemma))?;
        let statement = theorem.statement();
        self.may_move(turn, moving, [&statement.left, &statement.right])?;
        let here: Vec<Condition> = self.context.hypotheses.iter().chain(&statement.hypotheses).cloned().collect();
        let inside = Context::new(&self.theory.assumptions, &self.theory.definitions, &here);
        let stuck = |stuck: Stuck| Reason::Stuck(stuck.0);
        let map = |of: &dyn Fn(&Moving) -> Value| -> BTreeMap<Name, Value> {
            moving.iter().map(|one| (one.variable.clone(), of(one))).collect()
        };
        let (starts, nexts) = (map(&|one| one.start.clone()), map(&|one| one.next.clone()));
        for hypothesis in &statement.hypotheses {
            let at = |values| at(hypothesis, values).map_err(stuck);
            for (values, context) in [(&starts, &self.context), (&nexts, &inside)] {
                let instance = at(values)?;
                for value in condition_parts(hypothesis).1 {
                    context.assumptions.put_in_powers(value, values).map_err(|error| Reason::Stuck(error.0))?;
                }
                if !context.holds(&instance) {
                    return Err(Reason::Condition(Box::new(instance)));
                }
                // It says something there.
                for need in condition_parts(hypothesis).1.into_iter().flat_map(Value::needs) {
                    granted(&need.substitute(values).map_err(|error| Reason::Stuck(error.0))?, context)?;
                }
            }
        }
        for (value, context) in moving.iter().flat_map(|one| [(&one.start, &self.context), (&one.next, &inside)]) {
            value.needs().iter().try_for_each(|need| granted(need, context))?;
        }
        let moves = |value: &Value| moving.iter().any(|one| value.mentions(&one.variable));
        if moves(&lasts(turn, &inside)?) {
            return Err(Reason::Untimed(Box::new(turn.clone())));
        }
        let onward = substitute_known(&statement.left, &nexts, &inside.assumptions).map_err(stuck)?;
        same(&statement.right, &Term::seq([turn.clone(), onward]))?;
        let left = substitute_known(&statement.left, &starts, &self.context.assumptions).map_err(stuck)?;
        let right = carried_on(turn, moving).map_err(stuck)?;
        if theorem.advanced {
            self.speaks_of_known([&left, &right])?;
        }
        self.meaning.instance(&theorem.needs, &BTreeMap::new(), &self.context.assumptions)?;
        if let Some(need) = theorem.needs.iter().find(|need| moves(need.value())) {
            return Err(Reason::Undefined(Box::new(need.clone())));
        }
        self.rests_on(name, theorem);
        let connective = statement.connective.join(Connective::Weak);
        Ok(Derived { connective, ..Derived::equal(left, right) })
    }

    /// A metavariable of a turn stands for itself alone: nothing else speaks of it, and nothing binds it or what the
    /// values read that are put in for it. The names that carry values on stand nowhere else in what is said.
    fn may_move(&self, turn: &Term, moving: &[Moving], sides: [&Term; 2]) -> Result<(), Reason> {
        let definitions = &self.theory.definitions;
        let mut bound: BTreeSet<Name> = BTreeSet::new();
        for term in [turn, sides[0], sides[1]] {
            bound.extend(bound_names(term).into_iter().chain(written(term, definitions)));
            bound.extend(subterms(term).filter_map(|part| match part.node() {
                Node::Meta(name, _) | Node::New(name, _) | Node::In(name, _) | Node::Out(name, _) => Some(name.clone()),
                _ => None,
            }));
        }
        let mut spoken_of = self.context.assumptions.variables();
        for definition in definitions.iter() {
            bound.extend(bound_names(&definition.body));
            spoken_of.extend(read_names(&definition.body).into_iter().chain(metavariables(&definition.body)));
        }
        let variables: BTreeSet<&Name> = moving.iter().map(|one| &one.variable).collect();
        let mut taken: BTreeSet<Name> = read_names(turn).into_iter().chain(metavariables(turn)).collect();
        let reads = &Facts::of(turn, &self.context).reads;
        if let Some(unknown) = reads.processes.first() {
            return Err(Reason::Unbound(unknown.clone()));
        }
        taken.extend(reads.names.iter().cloned());
        for one in moving {
            taken.extend(one.start.variables().into_iter().chain(one.next.variables()));
        }
        for one in moving {
            let supposed = self.context.hypotheses.iter().any(|other| condition_mentions(other, &one.variable));
            let alone = one.variable.is_meta() && !supposed && !spoken_of.contains(&one.variable);
            if !alone || bound.contains(&one.variable) {
                return Err(Reason::Name(one.variable.clone()));
            }
            if one.start.sort() != Sort::Real || one.next.sort() != Sort::Real {
                return Err(Reason::Sort(Box::new(one.next.clone())));
            }
            let own = |name: &Name| variables.contains(name);
            let read = one.start.variables().into_iter().chain(one.next.variables().into_iter().filter(|n| !own(n)));
            if let Some(name) = read.into_iter().find(|name| bound.contains(name)) {
                return Err(Reason::Name(name));
            }
            if let Some(name) = one.start.variables().into_iter().find(own) {
                return Err(Reason::Name(name));
            }
        }
        // Each once: the metavariables, the names, and the names of images.
        let mut all: BTreeSet<Name> = BTreeSet::new();
        let images = moving.iter().filter(|_| moving.len() > 1).map(Moving::image);
        let names = moving.iter().flat_map(|one| [one.variable.clone(), one.name.clone()]);
        for name in names.chain(images) {
            let plain =
                variables.contains(&name) || !(name.is_meta() || taken.contains(&name) || bound.contains(&name));
            if !plain || spoken_of.contains(&name) || !all.insert(name.clone()) {
                return Err(Reason::Name(name));
            }
        }
        Ok(())
    }
}

fn granted(need: &Need, context: &Context<'_>) -> Result<(), Reason> {
    match context.assumptions.grants(need) {
        Some(true) => Ok(()),
        _ => Err(Reason::Undefined(Box::new(need.clone()))),
    }
}

/// A condition on values with these put in.
fn at(condition: &Condition, values: &BTreeMap<Name, Value>) -> Result<Condition, Stuck> {
    let at = |value: &Value| value.substitute(values).map_err(|error| Stuck(error.0));
    Ok(match condition {
        Condition::Compare(relation, left, right) => Condition::Compare(*relation, at(left)?, at(right)?),
        Condition::Natural(value) => Condition::Natural(at(value)?),
        other if values.keys().any(|name| condition_mentions(other, name)) => {
            return Err(Stuck("a condition that is not on values".to_string()));
        }
        other => other.clone(),
    })
}
