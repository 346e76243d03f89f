//! Deciding the conditions of laws, from facts about terms and the hypotheses of the claim, and from nothing else.

use std::rc::Rc;

use crate::fact::{Context, Facts, NameSet};
use crate::law::{Condition, Fact};
use crate::name::Name;
use crate::scope::reaches;
use crate::term::{Node, Term};
use crate::value::Relation;

impl Context<'_> {
    /// Decides a condition: true only if it holds of every instance that meets the hypotheses.
    pub fn holds(&self, condition: &Condition) -> bool {
        if self.supposes(condition) {
            return true;
        }
        match condition {
            Condition::Compare(relation, left, right) => self.assumptions.decide(*relation, left, right) == Some(true),
            Condition::Natural(value) => self.assumptions.is_natural(value) == Some(true),
            Condition::Is(fact, term) => self.is(*fact, &Facts::of(term, self)),
            Condition::Lasts(term, time) => match &Facts::of(term, self).duration {
                Some(duration) => self.assumptions.decide(Relation::Eq, duration, time) == Some(true),
                None => false,
            },
            Condition::Complementary(first, second) => self.complementary(first, second),
            Condition::NoPort(term, port) => {
                let no = |process: &Name| Condition::NoPort(Term::meta(process), port.clone());
                self.lacks(&Facts::of(term, self).ports, port, &no)
            }
            Condition::Unread(term, name) => {
                let no = |process: &Name| Condition::Unread(Term::meta(process), name.clone());
                self.lacks(&Facts::of(term, self).reads, name, &no)
            }
            Condition::Apart(first, second) => self.apart(first, second),
            Condition::ShowsOnly(term, shown) => {
                Facts::of(term, self).shows.as_ref().is_some_and(|shows| shows.is_subset(shown))
            }
            Condition::ShowsNone(term, shown) => {
                Facts::of(term, self).shows.as_ref().is_some_and(|shows| shows.is_disjoint(shown))
            }
        }
    }

    /// The facts that hold of each part of a term, as [`Condition::Is`] decides them: the bit `1 << fact` stands for
    /// a fact. The last answer is kept, since one law after the other asks about the same term.
    pub fn facts_of_parts(&self, term: &Term) -> Rc<[u16]> {
        let last = self.last.borrow().as_ref().filter(|(last, _)| last == term).map(|(_, known)| known.clone());
        last.unwrap_or_else(|| {
            let known: Rc<[u16]> = term.children().map(|part| self.facts_held(part)).collect();
            *self.last.borrow_mut() = Some((term.clone(), known.clone()));
            known
        })
    }

    /// The facts that hold of a term, as bits as in [`Context::facts_of_parts`].
    pub fn facts_held(&self, term: &Term) -> u16 {
        if let Some(known) = self.held.borrow().get(term) {
            return *known;
        }
        let facts = Facts::of(term, self);
        let supposed = |fact: Fact| !self.hypotheses.is_empty() && self.supposes(&Condition::Is(fact, term.clone()));
        let held = Fact::ALL.iter().filter(|(fact, _)| self.is(*fact, &facts) || supposed(*fact));
        let held = held.fold(0, |all, (fact, _)| all | 1 << *fact as u16);
        self.held.borrow_mut().insert(term.clone(), held);
        held
    }

    /// Decides a fact from facts.
    pub fn is(&self, fact: Fact, facts: &Facts) -> bool {
        match fact {
            Fact::NeverAborts => !facts.may_abort,
            Fact::NeverStops => !facts.may_stop,
            Fact::Silent => !facts.communicates,
            Fact::DrawsNothing => !facts.draws,
            Fact::BindsNothing => facts.binds.is_empty(),
            Fact::Observer => facts.observer,
            Fact::Guard => facts.guard,
            Fact::NotStopped => !facts.starts_stopped,
            Fact::Running => !facts.starts_stopped && !facts.starts_aborted,
            Fact::Guarded => !facts.instant_stop,
            Fact::Immediate => !facts.starts_running && !facts.starts_aborted,
            Fact::Still => !facts.early,
        }
    }

    fn complementary(&self, first: &Term, second: &Term) -> bool {
        if self.supposes(&Condition::Complementary(second.clone(), first.clone())) {
            return true;
        }
        let (Node::Guard(relation, a, b), Node::Guard(other, c, d)) = (first.node(), second.node()) else {
            return false;
        };
        (relation.negated() == *other && (a, b) == (c, d))
            || (relation.negated().mirrored() == *other && (a, b) == (d, c))
    }

    /// Whether a set surely lacks a name. Two names of which one is a metavariable may turn out the same.
    fn lacks(&self, set: &NameSet, name: &Name, no: &dyn Fn(&Name) -> Condition) -> bool {
        let names = &set.names;
        // Metavariables stand together in the order of names.
        let metas = || names.range(Name::new("?")..).next().is_some_and(Name::is_meta);
        let differ = names.is_empty() || !(name.is_meta() || names.contains(name) || metas());
        differ && set.processes.iter().all(|process| self.supposes(&no(process)))
    }

    fn apart(&self, first: &Term, second: &Term) -> bool {
        let (facts, other) = (Facts::of(first, self), Facts::of(second, self));
        let binds = &facts.binds;
        if binds.is_empty() {
            return true;
        }
        let mut others = other.binds.clone();
        others.extend(&other.reads);
        if others.is_empty() {
            return true;
        }
        let pair = |a: &Name, b: &Name| self.supposes(&Condition::Apart(Term::meta(a), Term::meta(b)));
        binds.names.iter().all(|name| {
            self.lacks(&others, name, &|process| Condition::Unread(Term::meta(process), name.clone()))
                && others.processes.is_empty()
        }) && binds
            .processes
            .iter()
            .all(|process| others.names.is_empty() && others.processes.iter().all(|other| pair(process, other)))
    }
}

/// Whether a call of `name` may be reached having neither waited nor communicated.
pub fn exposes(term: &Term, name: &Name, context: &Context<'_>) -> bool {
    match term.node() {
        Node::Call(called, _) => called == name || reaches(context.definitions, called, name),
        Node::Seq(parts) => {
            for part in parts {
                if exposes(part, name, context) {
                    return true;
                }
                if !Facts::of(part, context).instant_stop {
                    return false;
                }
            }
            false
        }
        Node::Else(first, second) => {
            exposes(first, name, context) || (Facts::of(first, context).instant_abort && exposes(second, name, context))
        }
        _ => term.children().into_iter().any(|part| exposes(part, name, context)),
    }
}
