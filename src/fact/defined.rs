//! What defined processes may do, found once for all contexts in which the same would be found: the least fixed point
//! over the definitions, and the names that stand in them.
//!
//! Nothing is given again but what was found of the very same definitions under equal assumptions, and what is found is
//! a function of these alone: an answer does not depend on what is remembered.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::{Context, Facts, NameSet};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::law::Condition;
use crate::name::Name;
use crate::scope::{Spoken, binds_itself, condition_mentions, subterms};
use crate::term::{Node, Term, TermMap};

/// Rounds of the fixed point over recursive definitions; the lattice is far lower than this.
const ROUNDS: usize = 64;

/// Of how many sets of definitions it is remembered what was found of them.
const MOST_SETS: usize = 8;

/// Under how many assumptions it is remembered what the definitions of one set may do.
const MOST_FOUND: usize = 16;

/// For how many sets of calls it is remembered what is bound and read there.
const MOST_CALLED: usize = 2_000;

/// Names that processes bind, and names that they read before they have bound them.
pub(crate) type BoundAndRead = (BTreeSet<Name>, BTreeSet<Name>);

/// What the definitions in force may do.
#[derive(Default)]
pub(crate) struct Defined {
    /// The facts of each: of a call, but for what is put in for the parameters.
    pub(super) facts: BTreeMap<Name, Facts>,
    /// The names in them all.
    pub(crate) names: Rc<Names>,
    /// The names that stand in their bodies, as `advance` has found them.
    bodies: RefCell<TermMap<Rc<Spoken>>>,
    /// What the processes bind and read that are called by these names, and by them: what `advance` has found.
    pub(crate) called: RefCell<BTreeMap<BTreeSet<Name>, Rc<BoundAndRead>>>,
}

/// The names that stand in definitions.
#[derive(Default)]
pub(crate) struct Names {
    /// All parameters.
    parameters: BTreeSet<Name>,
    /// All names that a body writes, binds by an index or replaces.
    pub(crate) bound: BTreeSet<Name>,
    /// All names that a value in a body reads.
    pub(crate) read: BTreeSet<Name>,
    /// Whether some value in a body needs anything to have a meaning.
    pub(crate) partial: bool,
    /// Whether a metavariable stands for a process in some body.
    open: bool,
}

/// Definitions, the names in them, and what they may do under assumptions.
struct Found {
    definitions: Definitions,
    names: Rc<Names>,
    under: Vec<(Assumptions, Rc<Defined>)>,
}

thread_local! {
    static FOUND: RefCell<Vec<Found>> = const { RefCell::new(Vec::new()) };
}

impl Names {
    fn of(definitions: &Definitions) -> Names {
        let mut names = Names::default();
        for definition in definitions.iter() {
            names.parameters.extend(definition.parameters.iter().cloned());
            for part in subterms(&definition.body) {
                names.open |= matches!(part.node(), Node::Meta(..));
                names.bound.extend(binds_itself(part).cloned());
                for value in part.values() {
                    names.read.extend(value.variables());
                    names.partial |= !value.needs().is_empty();
                }
            }
        }
        names
    }

    /// The names of these definitions: looked for once, as long as they are the very same.
    fn known(definitions: &Definitions) -> Rc<Names> {
        FOUND.with_borrow_mut(|found| {
            if let Some(known) = found.iter().find(|found| found.definitions.is(definitions)) {
                return Rc::clone(&known.names);
            }
            let names = Rc::new(Names::of(definitions));
            if found.len() >= MOST_SETS {
                found.remove(0);
            }
            found.push(Found { definitions: definitions.clone(), names: Rc::clone(&names), under: Vec::new() });
            names
        })
    }

    /// Of these assumptions those that bear on what the definitions may do. Nothing that is said of a parameter: it may
    /// stand for any value, whatever is assumed of a name spelled the same. And nothing that is about other names alone,
    /// be it by way of other facts. Less is known where facts are left out, so nothing is found that does not hold.
    fn bearing(&self, assumptions: &Assumptions) -> Assumptions {
        let about: Vec<BTreeSet<Name>> = assumptions.iter().map(|(_, value)| value.variables()).collect();
        let mut open: Vec<&BTreeSet<Name>> = about.iter().filter(|names| names.is_disjoint(&self.parameters)).collect();
        let mut near: BTreeSet<Name> = self.read.difference(&self.parameters).cloned().collect();
        loop {
            let before = open.len();
            let apart = |names: &&BTreeSet<Name>| names.is_disjoint(&near);
            let (left, joined): (Vec<_>, Vec<_>) = open.into_iter().partition(apart);
            near.extend(joined.into_iter().flatten().cloned());
            open = left;
            if open.len() == before {
                return assumptions.within(&near);
            }
        }
    }
}

impl Defined {
    /// What these definitions may do where this is assumed, and the hypotheses of a claim are among what is.
    pub(super) fn under(assumptions: &Assumptions, definitions: &Definitions, hypotheses: &[Condition]) -> Rc<Defined> {
        if definitions.iter().next().is_none() {
            return Rc::default();
        }
        let names = Names::known(definitions);
        if names.open {
            let mentions = |h: &Condition| names.parameters.iter().any(|name| condition_mentions(h, name));
            let hypotheses = if hypotheses.iter().any(mentions) { &[] } else { hypotheses };
            let plain = assumptions.without(&names.parameters);
            return fixed_point(plain, (definitions, &names), hypotheses);
        }
        // But for comparisons, which are among the assumptions, hypotheses speak of metavariables, and none stands here.
        let bearing = names.bearing(assumptions);
        Defined::remembered(definitions, &bearing).unwrap_or_else(|| {
            let defined = fixed_point(bearing.clone(), (definitions, &names), &[]);
            Defined::remember(definitions, bearing, &defined);
            defined
        })
    }

    fn remembered(definitions: &Definitions, assumptions: &Assumptions) -> Option<Rc<Defined>> {
        FOUND.with_borrow(|found| {
            let known = found.iter().find(|found| found.definitions.is(definitions))?;
            known.under.iter().find(|(other, _)| other == assumptions).map(|(_, defined)| Rc::clone(defined))
        })
    }

    fn remember(definitions: &Definitions, assumptions: Assumptions, defined: &Rc<Defined>) {
        FOUND.with_borrow_mut(|found| {
            if let Some(known) = found.iter_mut().find(|found| found.definitions.is(definitions)) {
                if known.under.len() >= MOST_FOUND {
                    known.under.remove(0);
                }
                known.under.push((assumptions, Rc::clone(defined)));
            }
        });
    }

    /// The names that a process of this name may read before it has bound them.
    pub(crate) fn reads(&self, name: &Name) -> NameSet {
        self.facts.get(name).map_or_else(|| NameSet::of_process(name), |facts| facts.reads.clone())
    }

    /// The names that stand in the body of a definition.
    pub(crate) fn spoken_in(&self, body: &Term) -> Rc<Spoken> {
        Spoken::of(body, &mut self.bodies.borrow_mut())
    }

    /// Keeps what is bound and read where these are called.
    pub(crate) fn remember_called(&self, calls: &BTreeSet<Name>, found: &Rc<BoundAndRead>) {
        let mut called = self.called.borrow_mut();
        if called.len() >= MOST_CALLED {
            called.clear();
        }
        called.insert(calls.clone(), Rc::clone(found));
    }
}

/// The least facts of which each definition's are those of its body.
fn fixed_point(
    assumptions: Assumptions,
    (definitions, names): (&Definitions, &Rc<Names>),
    hypotheses: &[Condition],
) -> Rc<Defined> {
    let with = |facts| Rc::new(Defined { facts, names: Rc::clone(names), ..Defined::default() });
    let each = |facts: &dyn Fn(&Name) -> Facts| definitions.iter().map(|d| (d.name.clone(), facts(&d.name))).collect();
    let nothing = with(each(&|_| Facts::default()));
    let mut context = Context::of(assumptions, (definitions, nothing), hypotheses);
    for _ in 0..ROUNDS {
        let next = definitions.iter().map(|definition| {
            let mut facts = Facts::clone(&Facts::of(&definition.body, &context));
            if definition.recursive {
                facts = facts.attempt();
                facts.surely_binds.clear();
                facts.duration = None;
            }
            let elsewhere = context.read_in_calls(&definition.body);
            for parameter in definition.parameters.iter().filter(|name| !elsewhere.contains(*name)) {
                facts.reads.names.remove(parameter);
            }
            (definition.name.clone(), facts)
        });
        let next: BTreeMap<Name, Facts> = next.collect();
        if next == context.defined.facts {
            return context.defined;
        }
        context.defined = with(next);
        context.known.borrow_mut().clear();
    }
    with(each(&Facts::anything))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::definition::Definition;
    use crate::law::Fact;
    use crate::value::{Relation, Value};

    fn name(text: &str) -> Name {
        Name::new(text)
    }

    fn variable(text: &str) -> Value {
        Value::variable(&name(text))
    }

    fn defining(body: Term) -> Definitions {
        let mut definitions = Definitions::default();
        definitions.insert(Definition { name: name("T"), parameters: vec![name("u")], body, recursive: false });
        definitions
    }

    fn assumed(facts: &[(&str, Relation, &str)]) -> Assumptions {
        let mut known = Assumptions::default();
        facts.iter().for_each(|(left, relation, right)| known.assume(*relation, &variable(left), &variable(right)));
        known
    }

    fn may_abort(known: &Assumptions, definitions: &Definitions) -> bool {
        let context = Context::new(known, definitions, &[]);
        Facts::of(&Term::new(Node::Call(name("T"), vec![Value::one()])), &context).may_abort
    }

    #[test]
    fn what_was_found_is_not_taken_for_other_assumptions_or_definitions() {
        let guard = |left: &str, right: &str| Term::new(Node::Guard(Relation::Gtr, variable(left), variable(right)));
        let (mut definitions, other) = (defining(guard("k", "l")), defining(guard("l", "k")));
        let more = assumed(&[("k", Relation::Gtr, "l")]);
        let by_another =
            assumed(&[("k", Relation::Gtr, "?r"), ("?r", Relation::Gte, "?s"), ("?s", Relation::Gte, "l")]);
        let less = assumed(&[("k", Relation::Gtr, "?r"), ("?s", Relation::Gte, "l")]);
        for _ in 0..2 {
            assert!(!may_abort(&more, &definitions) && may_abort(&more, &other));
            assert!(!may_abort(&by_another, &definitions), "by way of what no definition speaks of");
            assert!(may_abort(&less, &definitions) && may_abort(&Assumptions::default(), &definitions));
        }
        for bound in 0..2 * MOST_FOUND {
            let more =
                assumed(&[("k", Relation::Gtr, &format!("x{bound}")), (&format!("x{bound}"), Relation::Gtr, "l")]);
            assert!(!may_abort(&more, &definitions));
        }
        let changed = Definition { body: guard("l", "k"), ..definitions.get(&name("T")).unwrap().clone() };
        definitions.insert(changed);
        assert!(may_abort(&more, &definitions), "the definition is another now");
    }

    #[test]
    fn a_parameter_stands_for_any_value() {
        let definitions = defining(Term::new(Node::Guard(Relation::Gtr, variable("u"), variable("k"))));
        let known = assumed(&[("u", Relation::Gtr, "k")]);
        assert!(may_abort(&known, &definitions));
    }

    #[test]
    fn what_is_supposed_of_a_process_counts_in_its_claim_alone() {
        let definitions = defining(Term::meta(&name("?P")));
        let supposed = [Condition::Is(Fact::NeverAborts, Term::meta(&name("?P")))];
        for (hypotheses, aborts) in [(&supposed[..], false), (&[], true), (&supposed[..], false)] {
            let known = Assumptions::default();
            let context = Context::new(&known, &definitions, hypotheses);
            let call = Term::new(Node::Call(name("T"), vec![Value::one()]));
            assert_eq!(Facts::of(&call, &context).may_abort, aborts);
        }
    }
}
