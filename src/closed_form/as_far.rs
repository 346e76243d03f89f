//! Forms that are known as far as an index. What comes after it is left out by having all terms stay there: up to the
//! index that recurrence has the terms of the other, by induction, and its forms are checked as any others.

use super::{Form, Recurrence, Sequence, Solved, Unchecked};
use crate::assumption::Assumptions;
use crate::value::{Relation, Value};

/// How far the forms of a recurrence are known.
#[derive(Clone, Debug)]
pub struct AsFar {
    /// The last index.
    pub last: Value,
    /// Why no more is known.
    pub reason: String,
    /// The recurrence that goes on after it.
    pub whole: Recurrence,
}

impl Solved {
    /// The forms of a recurrence whose terms depend on those before alone, up to an index and no further: the theorem is
    /// that of the recurrence whose terms stay as they are from there on.
    ///
    /// # Errors
    /// Where the induction fails.
    pub fn as_far_as(
        recurrence: &Recurrence,
        forms: Vec<Form>,
        (last, reason): (Value, String),
        known: &Assumptions,
    ) -> Result<Solved, Unchecked> {
        let index = Value::variable(&recurrence.index);
        let stays = |sequence: &Sequence| {
            let [_] = sequence.start.as_slice() else {
                return Err(Unchecked(format!("{} depends on more than the term before", sequence.name)));
            };
            let here = Value::variable(&recurrence.term(&sequence.name, 0));
            Ok(Sequence {
                next: Value::choose(Relation::Lss, &index, &last, &sequence.next, &here)?,
                ..sequence.clone()
            })
        };
        let sequences = recurrence.sequences.iter().map(stays).collect::<Result<_, _>>()?;
        let own = Recurrence { sequences, ..recurrence.clone() };
        let mut solved = Solved::check(own, forms, Vec::new(), known)?;
        solved.as_far = Some(AsFar { last, reason, whole: recurrence.clone() });
        Ok(solved)
    }

    /// How far the forms are known; none where they are for every index.
    pub fn as_far(&self) -> Option<&AsFar> {
        self.as_far.as_ref()
    }
}
