//! Equations in which a condition of parameters alone chooses how a term depends on those before it,
//! `if k > 0 then x(n)/k else 1`: they are solved where it holds, and where it does not.

use std::collections::BTreeSet;

use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Recurrence};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The equations where the first such condition of which it is not known whether it holds does so, and where it does not;
/// nothing where there is none.
pub(super) fn choices(recurrence: &Recurrence, known: &Assumptions) -> Vec<(Comparison, Recurrence)> {
    let terms: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let parameter = |name: &Name| *name != recurrence.index && !terms.contains(name);
    for atom in conditions(recurrence) {
        let Atom::Positive(inner) = &atom else { continue };
        let open = known.decide(Relation::Gtr, inner, &Value::zero()).is_none();
        if open && known.gives_meaning(inner) && inner.variables().iter().all(parameter) {
            let cases = cases(recurrence, &atom, inner).unwrap_or_default();
            if cases.len() > 1 && depend(&cases, &terms) {
                return cases
                    .into_iter()
                    .filter(|((relation, left, right), _)| known.decide(*relation, left, right) != Some(false))
                    .collect();
            }
        }
    }
    Vec::new()
}

/// The conditions in the equations, at any depth.
fn conditions(recurrence: &Recurrence) -> BTreeSet<Atom> {
    let mut found = BTreeSet::new();
    let mut open: Vec<Value> = recurrence.sequences.iter().map(|sequence| sequence.next.clone()).collect();
    while let Some(value) = open.pop() {
        for atom in value.atoms() {
            open.extend(atom.parts().into_iter().cloned());
            if matches!(atom, Atom::Positive(_)) {
                found.insert(atom);
            }
        }
    }
    found
}

/// The equations in each case of a condition, and of its opposite where that is asked for as well.
fn cases(recurrence: &Recurrence, atom: &Atom, inner: &Value) -> Option<Vec<(Comparison, Recurrence)>> {
    let opposite = Atom::Positive(inner.neg().ok()?);
    let settled = |above: i64, below: i64| {
        let mut settled = recurrence.clone();
        for sequence in &mut settled.sequences {
            let holds = |other: &Atom| match other == atom {
                true => Some(Value::integer(above)),
                false => (*other == opposite).then(|| Value::integer(below)),
            };
            sequence.next = sequence.next.replace(&mut { holds }).ok()?;
        }
        Some(settled)
    };
    let three_ways = conditions(recurrence).contains(&opposite);
    let (above, below, neither) = (settled(1, 0)?, settled(0, 1)?, settled(0, 0)?);
    let cases = match three_ways {
        false => vec![(Relation::Gtr, above), (Relation::Lte, neither)],
        true if above == below => vec![(Relation::Neq, above), (Relation::Eq, neither)],
        true => vec![(Relation::Gtr, above), (Relation::Eq, neither), (Relation::Lss, below)],
    };
    Some(cases.into_iter().map(|(relation, found)| ((relation, inner.clone(), Value::zero()), found)).collect())
}

/// Whether it is more than a summand that differs from case to case.
fn depend(cases: &[(Comparison, Recurrence)], terms: &[Name]) -> bool {
    let differ = |(one, other): (&Recurrence, &Recurrence)| {
        one.sequences.iter().zip(&other.sequences).any(|(one, other)| {
            let difference = one.next.sub(&other.next);
            difference.map_or(true, |difference| terms.iter().any(|name| difference.mentions(name)))
        })
    };
    cases.windows(2).any(|pair| differ((&pair[0].1, &pair[1].1)))
}
