//! What is assumed of parameters: `param t > 0, n : natural`.

use std::collections::BTreeSet;

use super::Environment;
use super::scope::{Lowerer, Metas};
use crate::assumption::Assumptions;
use crate::ast::Parameter;
use crate::diagnostic::{Diagnostic, Span};
use crate::name::Name;
use crate::value::{Atom, Relation, Value, View};

/// More comparisons than this are not assumed: what follows from them is decided anew for every claim.
const MOST_ASSUMPTIONS: usize = 1000;

impl Environment {
    /// Assumes what an item says of parameters, all of it or nothing.
    pub(super) fn assume_all(
        &mut self,
        parameters: &[Parameter],
        interrupted: &dyn Fn() -> bool,
    ) -> Result<(), Vec<Diagnostic>> {
        if parameters.iter().all(|parameter| matches!(parameter, Parameter::Plain(_))) {
            return Ok(());
        }
        let mut lowerer = Lowerer::new(self, Metas::Forbidden);
        let mut facts = Vec::new();
        for parameter in parameters {
            match parameter {
                Parameter::Sorted(name, sort) if sort.name.as_str() == "natural" => {
                    facts.push((Fact::Natural(&name.name), lowerer.errors.len()));
                }
                Parameter::Assumed(relation, left, right) => {
                    let given = self.constant(*relation, left, right).is_some() || self.left_open(*relation, left);
                    if given {
                        continue;
                    }
                    if let Some((one, other)) = lowerer.compared_sides(*relation, left, right) {
                        let fact = Fact::Compared(*relation, one, other, left.span.to(right.span));
                        facts.push((fact, lowerer.errors.len()));
                    }
                }
                _ => {}
            }
        }
        let mut errors = std::mem::take(&mut lowerer.errors);
        let (count, naturals) = (self.assumptions.count(), self.assumptions.naturals().clone());
        let mut room = MOST_ASSUMPTIONS.saturating_sub(count);
        let mut stopped = false;
        for (place, (fact, found)) in facts.into_iter().enumerate() {
            stopped = place > 0 && interrupted();
            if stopped {
                errors.clear();
                break;
            }
            if let Err(error) = self.assumed(fact, &mut room) {
                // What comes after it was not looked at.
                errors.truncate(found);
                errors.push(*error);
                break;
            }
        }
        if errors.is_empty() && !stopped {
            return Ok(());
        }
        if self.assumptions.count() > count || self.assumptions.naturals().len() > naturals.len() {
            self.assumptions = self.assumptions.truncated(count, &naturals);
        }
        Err(errors)
    }

    /// Assumes one thing, where there is room for it; it is assumed also where it contradicts what was assumed before.
    fn assumed(&mut self, fact: Fact<'_>, room: &mut usize) -> Result<(), Box<Diagnostic>> {
        let (relation, one, other, span) = match fact {
            Fact::Natural(name) => {
                self.assumptions.assume_natural(name);
                return Ok(());
            }
            Fact::Compared(relation, one, other, span) => (relation, one, other, span),
        };
        let Some(left) = room.checked_sub(1) else {
            let text = format!("more than {MOST_ASSUMPTIONS} assumptions");
            return Err(Box::new(Diagnostic::error("P0323", text).label(span, "one too many")));
        };
        *room = left;
        let refuted = !leaves_free(&self.assumptions, &one, &other) && {
            let near = related(&self.assumptions, &(&one.variables() | &other.variables()));
            near.decide(relation, &one, &other) == Some(false)
        };
        self.assumptions.assume(relation, &one, &other);
        if refuted {
            let error = Diagnostic::error("P0321", "this contradicts what is assumed already")
                .label(span, "cannot hold as well")
                .note("from a contradiction everything follows, so nothing would be proved");
            return Err(Box::new(error));
        }
        Ok(())
    }
}

/// What a parameter is said to be.
enum Fact<'p> {
    Natural(&'p Name),
    Compared(Relation, Value, Value, Span),
}

/// Whether a comparison holds for some value of a variable of which nothing is assumed, whatever the others are: the
/// difference of its sides is a polynomial that is linear in it.
fn leaves_free(assumptions: &Assumptions, one: &Value, other: &Value) -> bool {
    let Ok(difference) = one.sub(other) else { return false };
    let View::Real(terms, below) = difference.view() else { return false };
    let mut atoms = terms.iter().chain(&below).flat_map(|(_, factors)| factors);
    if below.iter().any(|(_, factors)| !factors.is_empty()) || !atoms.all(|(atom, _)| matches!(atom, Atom::Variable(_)))
    {
        return false;
    }
    let single = |name: &Name| {
        let mut own = terms.iter().filter(|(_, factors)| factors.iter().any(|(atom, _)| atom.mentions(name)));
        let alone = own.next().is_some_and(|(_, factors)| matches!(factors.as_slice(), [(_, 1)]));
        alone && own.next().is_none()
    };
    difference.variables().iter().any(|name| !assumptions.mentions(name) && single(name))
}

/// What is assumed of these variables and of all that are compared with them, directly or by way of others.
fn related(assumptions: &Assumptions, variables: &BTreeSet<Name>) -> Assumptions {
    let facts: Vec<BTreeSet<Name>> = assumptions.iter().map(|(_, value)| value.variables()).collect();
    let mut facts: Vec<&BTreeSet<Name>> = facts.iter().collect();
    let mut near = variables.clone();
    loop {
        let before = facts.len();
        facts.retain(|fact| {
            let apart = fact.is_disjoint(&near);
            if !apart {
                near.extend(fact.iter().cloned());
            }
            apart
        });
        if facts.len() == before {
            return assumptions.within(&near);
        }
    }
}
