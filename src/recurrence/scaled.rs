//! What grows in proportion to a parameter that is more than 0 compares with 0 as it does where the parameter is 1.

use super::Reach;
use super::exact::{of_difference, read};
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::{Piece, Recurrence, Sequence, Solved};
use crate::name::Name;
use crate::value::{Relation, Sort, Value};

/// The first index at which terms compare as wanted, where it is found for 1 in place of a parameter and is the same for all
/// that are more than 0: both sides, with the forms put in, are so many times what they are there.
pub(super) fn scaled(
    solved: &Solved,
    (relation, left, right): Wanted<'_>,
    known: &Assumptions,
    first: &dyn Fn(Recurrence, Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let recurrence = solved.recurrence();
    let difference = left.sub(right).ok().filter(|difference| difference.sort() == Sort::Real)?;
    let pieces = of_difference(solved, &difference, &read(recurrence, &difference), known)?;
    let names = pieces.iter().flat_map(|piece| piece.form.variables());
    let positive = |name: &Name| known.decide(Relation::Gtr, &Value::variable(name), &Value::zero()) == Some(true);
    // All that is known of it is so of 1 too, so that the forms are right there.
    let may_be_one = |name: &Name| {
        let rest = known.without_name(name);
        let so = |(relation, zero): (Relation, Value)| {
            zero.with(name, &Value::one()).is_ok_and(|zero| rest.decide(relation, &zero, &Value::zero()) == Some(true))
        };
        known.iter().filter(|(_, zero)| zero.mentions(name)).all(so)
    };
    let scale = |name: &Name| {
        *name != recurrence.index
            && positive(name)
            && may_be_one(name)
            && pieces.iter().all(|piece| grows_with(piece, name, known))
    };
    let name = names.collect::<std::collections::BTreeSet<_>>().into_iter().find(scale)?;
    let at_one = |value: &Value| value.with(&name, &Value::one()).ok();
    let sequence = |sequence: &Sequence| {
        let start = sequence.start.iter().map(at_one).collect::<Option<_>>()?;
        Some(Sequence { name: sequence.name.clone(), start, next: at_one(&sequence.next)? })
    };
    let sequences = recurrence.sequences.iter().map(sequence).collect::<Option<_>>()?;
    let there = Recurrence { sequences, ..recurrence.clone() };
    match first(there, (relation, &at_one(left)?, &at_one(right)?)) {
        Reach::Unknown(_) => None,
        Reach::Never(why) => Some(Reach::Never(format!("as where {name} = 1: {why}"))),
        found => Some(found),
    }
}

/// Whether a form is so many times what it is where a parameter is 1, at indices that do not depend on that.
fn grows_with(piece: &Piece, name: &Name, known: &Assumptions) -> bool {
    let apart = || {
        let at_one = piece.form.with(name, &Value::one()).ok()?;
        known.simplify(&piece.form).sub(&known.simplify(&at_one).mul(&Value::variable(name)).ok()?).ok()
    };
    let bounds = [Some(&piece.from), piece.until.as_ref()];
    let free = !bounds.into_iter().flatten().any(|bound| bound.mentions(name));
    free && apart().is_some_and(|apart| apart.is_zero() || known.simplify(&apart).is_zero())
}
