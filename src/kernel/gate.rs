//! What an instance of a law, and every conclusion, must be to pass.

use std::collections::BTreeSet;

use super::Reason;
use crate::definition::Definitions;
use crate::law::Law;
use crate::name::Name;
use crate::scope::{binds_itself, index_escapes, metavariables, read_names, subterms, written};
use crate::substitution::Substitution;
use crate::term::{Node, Term, TermSet};
use crate::value::{Relation, Sort};

/// What every instance of a law must meet.
pub(super) struct Needs {
    metavariables: BTreeSet<Name>,
    escapes: Vec<(Name, Name)>,
}

impl Needs {
    pub(super) fn of(law: &Law) -> Needs {
        let mut all = metavariables(&law.left);
        all.extend(metavariables(&law.right));
        Needs { metavariables: all, escapes: index_escapes(law) }
    }

    /// Every metavariable of the law has a meaning, of the sort in which it is used, and nothing that is known only
    /// under an index leaves its reach.
    pub(super) fn are_met_by(&self, substitution: &Substitution) -> Result<(), Reason> {
        for meta in &self.metavariables {
            let places = [
                substitution.processes.contains_key(meta),
                substitution.values.contains_key(meta),
                substitution.names.contains_key(meta),
                substitution.sets.contains_key(meta),
            ];
            if places.iter().filter(|place| **place).count() != 1 {
                return Err(Reason::Unbound(meta.clone()));
            }
        }
        for (index, meta) in &self.escapes {
            let Some(index) = substitution.names.get(index) else { continue };
            let process = substitution.processes.get(meta).is_some_and(|term| read_names(term).contains(index));
            let value = substitution.values.get(meta).is_some_and(|value| value.mentions(index));
            if process || value {
                return Err(Reason::Name(index.clone()));
            }
        }
        Ok(())
    }
}

/// A number of rounds is settled before the first: it reads no name that is written anywhere.
pub(super) fn counts_are_settled(term: &Term, definitions: &Definitions) -> Result<(), Reason> {
    let counts = subterms(term).filter_map(|part| match part.node() {
        Node::Power(_, count, _) => Some(count.variables()),
        _ => None,
    });
    let read: BTreeSet<Name> = counts.flatten().collect();
    let all = if read.is_empty() { BTreeSet::new() } else { written(term, definitions) };
    let elsewhere =
        |name: &&Name| definitions.iter().any(|definition| written(&definition.body, definitions).contains(*name));
    match read.iter().find(|name| all.contains(*name) || elsewhere(name)) {
        Some(name) => Err(Reason::Name(name.clone())),
        None => Ok(()),
    }
}

/// Times and comparisons are over reals, draws are from distributions, counts are natural numbers; and no name is bound of
/// which something is assumed: those are `fixed`. `known` holds terms of which this is so, with all their parts; this one
/// is added, and what its counts read to `counts`.
pub(super) fn well_sorted(
    term: &Term,
    fixed: &BTreeSet<Name>,
    known: &mut TermSet,
    counts: &mut BTreeSet<Name>,
) -> Result<(), Reason> {
    let mut open = vec![term.clone()];
    let mut seen = Vec::new();
    while let Some(part) = open.pop() {
        if known.contains(&part) {
            continue;
        }
        operator_is_well_sorted(&part)?;
        if let Some(name) = binds_itself(&part).filter(|name| fixed.contains(*name)) {
            return Err(Reason::Name(name.clone()));
        }
        if let Node::Power(_, count, _) = part.node() {
            counts.extend(count.variables());
        }
        open.extend(part.portions());
        seen.push(part);
    }
    // Only now, when all parts have passed.
    known.extend(seen);
    Ok(())
}

fn operator_is_well_sorted(part: &Term) -> Result<(), Reason> {
    let sort = match part.node() {
        Node::Delay(_) | Node::Power(..) => Sort::Real,
        Node::Guard(relation, ..) if !matches!(relation, Relation::Eq | Relation::Neq) => Sort::Real,
        Node::Ran(value, _) if value.as_variable().is_none() => Sort::Distribution,
        _ => return Ok(()),
    };
    if let Some(value) = part.values().find(|value| value.sort() != sort) {
        return Err(Reason::Sort(Box::new(value.clone())));
    }
    if let Node::Power(_, count, _) = part.node()
        && let Some(number) = count.as_rational()
        && (!number.is_integer() || number < num_rational::BigRational::from_integer(0.into()))
    {
        return Err(Reason::Sort(Box::new(count.clone())));
    }
    Ok(())
}
