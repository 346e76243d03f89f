//! Vectors that are to be equal: where one part moves one way only it is equal at one index at most, at which the others are, or
//! none is.

use super::Reach;
use super::exact::{of_difference, read};
use super::reach::Wanted;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece, Solved};
use crate::value::{Relation, Value};

/// The first index at which all parts, of which each is asked, are equal, by one that is a line which rises or falls.
pub(super) fn by_one_part(
    solved: &Solved,
    parts: &[Comparison],
    known: &Assumptions,
    ask: &dyn Fn(Wanted<'_>) -> Reach,
) -> Option<Reach> {
    let (recurrence, zero) = (solved.recurrence(), Value::zero());
    let index = &recurrence.index;
    let line = |(_, left, right): &Comparison| {
        let difference = left.sub(right).ok()?;
        let pieces = of_difference(solved, &difference, &read(recurrence, &difference), known)?;
        let [Piece { until: None, form, .. }] = pieces.as_slice() else { return None };
        let (slope, rest) = form.linear_in(index)?;
        (!slope.mentions(index) && !rest.mentions(index)).then(|| (form.clone(), known.simplify(&slope)))
    };
    let lines = parts.iter().map(line).collect::<Option<Vec<_>>>()?;
    let mut open = None;
    for (place, (part, (_, slope))) in parts.iter().zip(&lines).enumerate() {
        match known.decide(Relation::Neq, slope, &zero) {
            Some(true) => {}
            Some(false) => continue,
            None => {
                open = open.or(Some(Reach::undecided(Relation::Eq, slope, &zero)));
                continue;
            }
        }
        return match ask((part.0, &part.1, &part.2)) {
            Reach::At(at, mut conditions) => {
                for (_, (form, _)) in lines.iter().enumerate().filter(|(other, _)| *other != place) {
                    let there = known.simplify(&form.with(index, &at).ok()?);
                    match known.decide(Relation::Eq, &there, &zero) {
                        Some(true) => {}
                        Some(false) => {
                            let why = format!("one part is equal at {index} = {at} alone, and another is not then");
                            return Some(Reach::Never(why));
                        }
                        None => conditions.push((Relation::Eq, there, zero.clone())),
                    }
                }
                Some(Reach::At(at, conditions))
            }
            Reach::Never(why) => Some(Reach::Never(why)),
            unknown @ Reach::Unknown(_) => Some(unknown),
        };
    }
    open
}
