//! What a property asks to be shown, with the conditions on what is unknown in it.

use std::collections::BTreeMap;

use crate::assumption::Assumptions;
use crate::name::Name;
use crate::period::Test;
use crate::recurrence::{Closed, Goal, Piece, Reach, first};
use crate::term::{Node, Term};
use crate::value::{Relation, Value};

/// An observer, the values asked for, and the conditions of the property.
pub(super) struct Asking {
    name: Name,
    own: Vec<Value>,
    tests: Vec<Test>,
}

impl Asking {
    pub(super) fn of(term: &Term, tests: &[Test], values: &BTreeMap<Name, Value>) -> Option<Asking> {
        let Node::Observe(name, own) = term.node() else { return None };
        let put = |value: &Value| value.substitute(values).ok();
        let own: Vec<Value> = own.iter().map(put).collect::<Option<_>>()?;
        let tests = tests
            .iter()
            .map(|test| Some(Test { relation: test.relation, left: put(&test.left)?, right: put(&test.right)? }))
            .collect::<Option<_>>()?;
        Some(Asking { name: name.clone(), own, tests })
    }

    /// Whether this may be what is asked for; nothing for values that are not known.
    pub(super) fn may_be(&self, name: &Name, values: Option<&[Value]>) -> bool {
        let Some(values) = values else { return *name == self.name };
        let none = Assumptions::default();
        *name == self.name
            && values.len() == self.own.len()
            && self.own.iter().zip(values).all(|(own, value)| !own.variables().is_empty() || own == value)
            && !self.breaks_a_test(values, &none)
    }

    /// Whether an observer whose values change from round to round may at some time be what is asked for.
    pub(super) fn may_become(&self, name: &Name, values: &[Value], index: Option<&Name>, known: &Assumptions) -> bool {
        if *name != self.name || values.len() != self.own.len() {
            return false;
        }
        let mut known = known.clone();
        if let Some(index) = index {
            known.assume_natural(index);
        }
        let never = |(own, value): (&Value, &Value)| {
            if !own.variables().is_empty() {
                return false;
            }
            let Some(index) = index else { return known.decide(Relation::Neq, value, own) == Some(true) };
            let pieces = vec![Piece { from: Value::zero(), until: None, form: value.clone() }];
            let closed = Closed { variable: name.clone(), pieces, conditions: Vec::new() };
            known.decide(Relation::Neq, value, own) == Some(true)
                || matches!(first(&closed, index, &Goal::Equals(own.clone()), &known), Reach::Never(_))
        };
        !self.own.iter().zip(values).any(never) && !self.breaks_a_test(values, &known)
    }

    /// Whether a condition on unknowns of this observer alone surely does not hold of these values.
    fn breaks_a_test(&self, values: &[Value], known: &Assumptions) -> bool {
        let unknown = |(own, value): (&Value, &Value)| Some((own.as_variable()?.clone(), value.clone()));
        let found: BTreeMap<Name, Value> = self.own.iter().zip(values).filter_map(unknown).collect();
        self.tests.iter().any(|test| {
            let mut names = test.left.variables();
            names.extend(test.right.variables());
            if names.is_empty() || !names.iter().all(|name| found.contains_key(name)) {
                return false;
            }
            let (left, right) = (test.left.substitute(&found), test.right.substitute(&found));
            matches!((left, right), (Ok(left), Ok(right)) if known.decide(test.relation, &left, &right) == Some(false))
        })
    }
}
