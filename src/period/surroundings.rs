//! What a run is made with.

use std::cell::OnceCell;
use std::collections::BTreeSet;

use super::{Failure, Period, analysed};
use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::name::Name;
use crate::scope::{bound_names, read_names};
use crate::term::Term;

/// What a run is made with.
pub(super) struct Surroundings<'a> {
    pub(super) definitions: &'a Definitions,
    pub(super) assumptions: &'a Assumptions,
    pub(super) interrupted: &'a dyn Fn() -> bool,
    /// The names that are free in the definitions, found once for all the parts of a system.
    free: OnceCell<BTreeSet<Name>>,
}

impl<'a> Surroundings<'a> {
    /// These.
    pub(super) fn new(
        definitions: &'a Definitions,
        assumptions: &'a Assumptions,
        interrupted: &'a dyn Fn() -> bool,
    ) -> Surroundings<'a> {
        Surroundings { definitions, assumptions, interrupted, free: OnceCell::new() }
    }

    /// The names that have one value throughout: all that are free in what is given.
    pub(super) fn reserved(&self, components: &[Term]) -> BTreeSet<Name> {
        let free = self.free.get_or_init(|| {
            let free = self.definitions.iter().flat_map(|definition| {
                free_names(&definition.body).filter(|name| !definition.parameters.contains(name))
            });
            free.collect()
        });
        let own = components.iter().flat_map(free_names);
        own.chain(free.iter().cloned()).chain(self.assumptions.variables()).collect()
    }
}

/// The names that have one value throughout a run of these components: parameters.
pub(crate) fn parameters(components: &[Term], definitions: &Definitions, assumptions: &Assumptions) -> BTreeSet<Name> {
    Surroundings::new(definitions, assumptions, &|| false).reserved(components)
}

/// The period of each of several systems of the same processes.
///
/// # Errors
/// The failures of the first that has none.
pub fn analyse_each(
    systems: &[Vec<Term>],
    definitions: &Definitions,
    assumptions: &Assumptions,
    interrupted: &dyn Fn() -> bool,
) -> Result<Vec<Period>, Vec<Failure>> {
    let run = Surroundings::new(definitions, assumptions, interrupted);
    systems.iter().map(|components| analysed(components, &run, true)).collect()
}

/// The names that a process reads and does not bind anywhere.
fn free_names(term: &Term) -> impl Iterator<Item = Name> {
    let read = read_names(term);
    let bound = if read.is_empty() { BTreeSet::new() } else { bound_names(term) };
    read.into_iter().filter(move |name| !bound.contains(name))
}
