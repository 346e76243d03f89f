//! The known traps: laws that look right and are not, as data in `rules/traps.pars`.

use crate::assumption::Assumptions;
use crate::definition::Definitions;
use crate::fact::Context;
use crate::law::{Law, Laws};
use crate::lower::Environment;
use crate::matching::matches;
use crate::parser::parse;
use crate::proof::hole;
use crate::term::Term;

const TEXT: &str = include_str!("../../rules/traps.pars");

/// All of them; none is in force anywhere.
pub fn traps() -> Laws {
    let mut environment = Environment::new();
    let parsed = parse(TEXT);
    environment.declare(&parsed.items, TEXT);
    environment.laws
}

/// The trap that the law is an instance of, read in either direction.
pub(super) fn known(law: &Law) -> Option<Law> {
    let (assumptions, definitions) = (Assumptions::default(), Definitions::default());
    let context = Context::new(&assumptions, &definitions, &law.conditions);
    let falls = |trap: &Law, left: &Term, right: &Term| {
        [(&trap.left, &trap.right), (&trap.right, &trap.left)].into_iter().any(|(from, to)| {
            matches(trap, from, left, &context).iter().any(|found| {
                found.surrounding == Term::meta(&hole(1))
                    && found.substitution.apply(to, &context).is_ok_and(|image| image == *right)
            })
        })
    };
    traps().iter().find(|trap| falls(trap, &law.left, &law.right)).map(|trap| (**trap).clone())
}
