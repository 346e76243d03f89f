//! How a value lies to 0 where this is asked of its parts: what is the greatest of several, or a root, is taken apart.

use crate::exponential_polynomial::ExponentialPolynomial;
use crate::exponential_polynomial::tail::throughout;
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// What a maximum is the greatest of.
pub(super) fn with_zero(atom: &Atom) -> Option<Vec<Value>> {
    let Atom::Maximum(elements) = atom else { return None };
    Some(std::iter::once(Value::zero()).chain(elements.iter().cloned()).collect())
}

/// Whether a value stands in a relation to 0, given what tells of parts of it: what is the greatest of several, or a root, is
/// taken apart.
pub(super) fn stands_to_zero(value: &Value, relation: Relation, leaf: &Leaf<'_>, splits: usize) -> Option<bool> {
    if let Some(told) = leaf(value, relation) {
        return Some(told);
    }
    let splits = splits.checked_sub(1)?;
    let part = Name::new("[part]");
    value.atoms().into_iter().find_map(|atom| {
        let apart = value.with_atom(&atom, &Value::variable(&part)).ok()?;
        let (factor, rest) = apart.linear_in(&part)?;
        let up = leaf(&factor, Relation::Gtr).filter(|up| *up || leaf(&factor, Relation::Lss) == Some(true))?;
        match &atom {
            Atom::Maximum(_) => {
                let parts: Option<Vec<Value>> =
                    with_zero(&atom)?.iter().map(|one| factor.mul(one).and_then(|one| one.add(&rest)).ok()).collect();
                greatest(&parts?, up, relation, leaf, splits)
            }
            Atom::Root(inner) => {
                // factor*sqrt(S) + rest lies to 0 as sqrt(S) to what follows, and turned where the factor is below 0.
                let bound = rest.neg().and_then(|rest| rest.div(&factor)).ok()?;
                let relation = if up { relation } else { relation.mirrored() };
                let squares = inner.sub(&bound.mul(&bound).ok()?).ok()?;
                match (relation, stands_to_zero(&bound, Relation::Gte, leaf, splits)) {
                    (_, Some(true)) => stands_to_zero(&squares, relation, leaf, splits),
                    (Relation::Gtr | Relation::Gte | Relation::Neq, Some(false)) => Some(true),
                    (_, Some(false)) => Some(false),
                    (_, None) => None,
                }
            }
            _ => None,
        }
    })
}

/// What tells whether a value stands in a relation to 0.
pub(super) type Leaf<'a> = dyn Fn(&Value, Relation) -> Option<bool> + 'a;

/// Whether the greatest of these values, or the least, stands in a relation to 0.
fn greatest(parts: &[Value], most: bool, relation: Relation, leaf: &Leaf<'_>, splits: usize) -> Option<bool> {
    let stand = |relation: Relation| parts.iter().map(move |part| stands_to_zero(part, relation, leaf, splits));
    let any = |relation: Relation| stand(relation).any(|told| told == Some(true));
    let all = |relation: Relation| stand(relation).all(|told| told == Some(true));
    // Of the greatest: it is above where one is, and below where all are.
    let (above, below) = if most { (Relation::Gtr, Relation::Lss) } else { (Relation::Lss, Relation::Gtr) };
    let with_equal = |strict: Relation| if strict == Relation::Gtr { Relation::Gte } else { Relation::Lte };
    match relation {
        Relation::Eq | Relation::Neq => {
            let apart = any(above) || all(below);
            let equal = || all(with_equal(below)) && any(with_equal(above));
            if apart { Some(relation == Relation::Neq) } else { equal().then_some(relation == Relation::Eq) }
        }
        _ if relation == above || relation == with_equal(above) => {
            if any(relation) {
                Some(true)
            } else {
                all(relation.negated()).then_some(false)
            }
        }
        _ => {
            if all(relation) {
                Some(true)
            } else {
                any(relation.negated()).then_some(false)
            }
        }
    }
}

/// Whether a sum stands in a relation to 0 at all these indices, or at none of them; nothing where neither is known.
pub(super) fn throughout_or_never(
    sum: &ExponentialPolynomial,
    relation: Relation,
    from: u64,
    until: Option<u64>,
) -> Option<bool> {
    if throughout(sum, relation, from, until) {
        return Some(true);
    }
    throughout(sum, relation.negated(), from, until).then_some(false)
}
