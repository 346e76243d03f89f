//! Equations that go in the direction of a point and have no value at it: `r + min(w, norm(g-r))*unit(g-r)` at g.

use crate::closed_form::Recurrence;
use crate::name::Name;
use crate::value::{Atom, Need, Relation, Value};

/// The same recurrence where the sequences whose equations divide by a distance stay once that is 0, the distance, and these
/// sequences; none where none does, or one divides by something else that has terms.
pub fn at_rest(recurrence: &Recurrence) -> Option<(Recurrence, Value, Vec<Name>)> {
    let terms = recurrence.terms();
    let (mut distance, mut staying): (Option<Value>, Vec<Name>) = (None, Vec::new());
    for sequence in &recurrence.sequences {
        for need in sequence.next.needs() {
            let Need::Nonzero(divisor) = need else { continue };
            if !terms.iter().any(|(name, ..)| divisor.mentions(name)) {
                continue;
            }
            let one = divisor.atoms().into_iter().find(|atom| atom.value().is_ok_and(|value| value == divisor));
            let Some(Atom::Root(square)) = one else { return None };
            square.squares()?;
            if distance.replace(divisor.clone()).is_some_and(|other| other != divisor) {
                return None;
            }
            if !staying.contains(&sequence.name) {
                staying.push(sequence.name.clone());
            }
        }
    }
    let (distance, mut resting) = (distance?, recurrence.clone());
    for sequence in resting.sequences.iter_mut().filter(|sequence| staying.contains(&sequence.name)) {
        let own = Value::variable(&recurrence.term(&sequence.name, 0));
        if sequence.start.len() != 1 {
            return None;
        }
        sequence.next = Value::choose(Relation::Gtr, &distance, &Value::zero(), &sequence.next, &own).ok()?;
    }
    Some((resting, distance, staying))
}
