//! Instances of what was proved before: of an earlier step, and of a lemma.

use std::collections::{BTreeMap, BTreeSet};

use super::{Checker, Derived, Reason, Thm, no_supposition, same};
use crate::law::Condition;
use crate::name::Name;
use crate::proof::StepId;
use crate::scope::{bound_names, condition_metavariables, metavariables, read_names, subterms, written};
use crate::substitution::{Stuck, Substitution};
use crate::term::{Node, Term};
use crate::value::{Sort, Value};

/// What was proved of a name was proved of one that is no other: the names that come in stand nowhere in the theorem,
/// and no two metavariables become one.
fn named_apart(sides: [&Term; 2], substitution: &Substitution) -> Result<(), Reason> {
    if substitution.names.is_empty() {
        return Ok(());
    }
    let mut taken: BTreeSet<Name> = sides.into_iter().flat_map(names_of).collect();
    taken.retain(|name| !substitution.names.contains_key(name));
    match substitution.names.values().find(|name| !taken.insert((*name).clone())) {
        Some(name) => Err(Reason::Name(name.clone())),
        None => Ok(()),
    }
}

/// The names that a term reads, writes, binds, or has for ports.
fn names_of(term: &Term) -> BTreeSet<Name> {
    let mut names: BTreeSet<Name> = read_names(term).into_iter().chain(bound_names(term)).collect();
    names.extend(subterms(term).filter_map(|part| match part.node() {
        Node::New(port, _) | Node::In(port, _) | Node::Out(port, _) => Some(port.clone()),
        _ => None,
    }));
    names
}

impl Checker<'_> {
    pub(super) fn instance(&mut self, of: StepId, substitution: &Substitution) -> Result<Derived, Reason> {
        let derived = self.earlier(of)?;
        no_supposition(derived)?;
        // A theorem under hypotheses speaks of their metavariables as they are supposed to be: those stay.
        let kept: BTreeSet<Name> = self.context.hypotheses.iter().flat_map(condition_metavariables).collect();
        self.may_replace(substitution, &kept)?;
        let (known, before) = (&self.context.assumptions, self.meaning.met().clone());
        self.meaning.put_in(substitution, known)?;
        self.meaning.instance(&before, &substitution.read(), known)?;
        let derived = self.earlier(of)?;
        let (left, right) = self.images([&derived.left, &derived.right], substitution)?;
        Ok(Derived { left, connective: derived.connective, right, supposed: BTreeSet::new() })
    }

    /// A lemma speaks of all values that meet its own hypotheses, which must therefore hold of the instance here.
    pub(super) fn lemma(&mut self, of: usize, substitution: &Substitution) -> Result<Derived, Reason> {
        let proved = self.proved;
        let (name, theorem) = proved.get(of).ok_or(Reason::NotEarlier(of))?;
        self.may_replace(substitution, &BTreeSet::new())?;
        let statement = theorem.statement();
        for hypothesis in &statement.hypotheses {
            let instance = substitution.condition(hypothesis, &self.context);
            let instance = instance.map_err(|stuck: Stuck| Reason::Stuck(stuck.0))?;
            if !self.context.holds(&instance) {
                return Err(Reason::Condition(Box::new(instance)));
            }
        }
        let known = &self.context.assumptions;
        self.meaning.put_in(substitution, known)?;
        self.meaning.instance(&theorem.needs, &substitution.read(), known)?;
        if theorem.advanced {
            self.binds_none(substitution, [&statement.left, &statement.right])?;
        }
        let (left, right) = self.images([&statement.left, &statement.right], substitution)?;
        if theorem.advanced {
            self.speaks_of_known([&left, &right])?;
        }
        self.rests_on(name, theorem);
        Ok(Derived { left, connective: statement.connective, right, supposed: BTreeSet::new() })
    }

    /// Two lemmas of the same: one where a comparison of numbers holds, and one where it does not. Of what is compared
    /// something is assumed already, or the claim reads it and nothing binds it, so that it means the same everywhere; and it
    /// has a value wherever the claim has one.
    pub(super) fn cases(&mut self, when: &Condition, of: [usize; 2]) -> Result<Derived, Reason> {
        let Condition::Compare(relation, one, other) = when else {
            return Err(Reason::Condition(Box::new(when.clone())));
        };
        for value in [one, other] {
            if value.sort() != Sort::Real {
                return Err(Reason::Sort(Box::new(value.clone())));
            }
            if let Some(name) = value.variables().into_iter().find(|name| !self.is_of_the_claim(name)) {
                return Err(Reason::Unspoken(name));
            }
            value.needs().into_iter().try_for_each(|need| self.meaning.require(need, &self.context.assumptions))?;
        }
        let mut found: Option<Derived> = None;
        for (lemma, relation) in of.into_iter().zip([*relation, relation.negated()]) {
            let proved = self.proved;
            let (name, theorem) = proved.get(lemma).ok_or(Reason::NotEarlier(lemma))?;
            let statement = theorem.statement();
            let case = Condition::Compare(relation, one.clone(), other.clone());
            let unmet = |hypothesis: &&Condition| **hypothesis != case && !self.context.holds(hypothesis);
            if let Some(hypothesis) = statement.hypotheses.iter().find(unmet) {
                return Err(Reason::Condition(Box::new(hypothesis.clone())));
            }
            self.meaning.instance(&theorem.needs, &BTreeMap::new(), &self.context.assumptions)?;
            if theorem.advanced {
                self.speaks_of_known([&statement.left, &statement.right])?;
            }
            let mut connective = statement.connective;
            if let Some(first) = &found {
                same(&statement.left, &first.left).and_then(|()| same(&statement.right, &first.right))?;
                connective = connective.join(first.connective);
            }
            let (left, right) = (statement.left.clone(), statement.right.clone());
            found = Some(Derived { left, connective, right, supposed: BTreeSet::new() });
            self.rests_on(name, theorem);
        }
        found.ok_or(Reason::Empty)
    }

    /// Whether a name means the same everywhere: something is assumed of it, or it is read by the claim, or by a definition, and
    /// no definition binds it. The lemmas of the cases suppose something of it, so that nothing in them binds it.
    fn is_of_the_claim(&self, name: &Name) -> bool {
        let read = || !name.is_meta() && self.meaning.outside().contains(name);
        self.fixed.contains(name) || read() && !self.context.defined.names.bound.contains(name)
    }

    /// What a theorem rests on, whatever uses it rests on.
    pub(super) fn rests_on(&mut self, name: &Name, theorem: &Thm) {
        self.lemmas.insert(name.clone());
        self.laws.extend(theorem.laws().iter().cloned());
        self.lemmas.extend(theorem.lemmas().iter().cloned());
        self.trusted.extend(theorem.trusted().iter().cloned());
        self.reads.extend(theorem.reads().iter().cloned());
        self.advanced |= theorem.advanced;
    }

    /// What was found by running a network has metavariables only of which this claim supposes something: those keep
    /// their meaning in every instance that is made here.
    pub(super) fn speaks_of_known(&self, sides: [&Term; 2]) -> Result<(), Reason> {
        let supposed: BTreeSet<Name> = self.context.hypotheses.iter().flat_map(condition_metavariables).collect();
        let read = sides.into_iter().flat_map(read_names).find(|name| name.is_meta() && !supposed.contains(name));
        read.map_or(Ok(()), |name| Err(Reason::Unbound(name)))
    }

    /// Where a network was run, a metavariable stood for a value that nothing in the network binds.
    fn binds_none(&self, substitution: &Substitution, sides: [&Term; 2]) -> Result<(), Reason> {
        let definitions = self.theory.definitions.iter().map(|definition| &definition.body);
        let bound: BTreeSet<Name> = sides.into_iter().chain(definitions).flat_map(bound_names).collect();
        let read = substitution.values.values().flat_map(|value| value.variables());
        match read.chain(substitution.names.values().cloned()).find(|name| bound.contains(name)) {
            Some(name) => Err(Reason::Name(name)),
            None => Ok(()),
        }
    }

    /// Metavariables alone are replaced, and not one that a definition mentions: it means the same in every call.
    fn may_replace(&self, substitution: &Substitution, kept: &BTreeSet<Name>) -> Result<(), Reason> {
        let defined: BTreeSet<Name> =
            self.theory.definitions.iter().flat_map(|definition| metavariables(&definition.body)).collect();
        let given = substitution.processes.keys().chain(substitution.values.keys());
        let given = given.chain(substitution.names.keys()).chain(substitution.sets.keys());
        match given.into_iter().find(|name| kept.contains(*name) || defined.contains(*name) || !name.is_meta()) {
            Some(name) => Err(Reason::Name(name.clone())),
            None => Ok(()),
        }
    }

    /// Both sides with the metavariables replaced. An index of rounds keeps its name, and nothing that reads it comes
    /// in: what the theorem says of rounds, it says of values that are the same in all of them.
    fn images(&self, sides: [&Term; 2], substitution: &Substitution) -> Result<(Term, Term), Reason> {
        let mut brought: BTreeSet<Name> = substitution.processes.values().flat_map(read_names).collect();
        brought.extend(substitution.values.values().flat_map(|value| value.variables()));
        brought.extend(substitution.names.values().cloned());
        for part in sides.into_iter().flat_map(subterms) {
            if let Node::Power(_, _, Some(index)) | Node::Replace(_, index, _) = part.node()
                && (brought.contains(index) || substitution.names.contains_key(index))
            {
                return Err(Reason::Name(index.clone()));
            }
        }
        named_apart(sides, substitution)?;
        let stuck = |stuck: Stuck| Reason::Stuck(stuck.0);
        let left = substitution.apply(sides[0], &self.context).map_err(stuck)?;
        let right = substitution.apply(sides[1], &self.context).map_err(stuck)?;
        self.caught_nowhere(substitution, [&left, &right])?;
        Ok((left, right))
    }

    /// What was proved of a value was proved of one that means the same wherever it stands: no part of the instance, and
    /// no process called in it, binds a name that the value reads.
    fn caught_nowhere(&self, substitution: &Substitution, sides: [&Term; 2]) -> Result<(), Reason> {
        let read: BTreeSet<Name> = substitution.values.values().flat_map(Value::variables).collect();
        if read.is_empty() {
            return Ok(());
        }
        let definitions = &self.theory.definitions;
        let bound = sides.into_iter().flat_map(|side| {
            let mut names = written(side, definitions);
            names.extend(bound_names(side));
            names
        });
        bound.into_iter().find(|name| read.contains(name)).map_or(Ok(()), |name| Err(Reason::Name(name)))
    }
}
