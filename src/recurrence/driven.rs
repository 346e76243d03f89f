//! Sequences that read others whose forms are in pieces, as what counts how long a robot rests at its goal does: where each
//! of the others has one form, the equations are of the index alone, and what holds there decides their conditions.

use std::collections::{BTreeMap, BTreeSet};

use super::in_pieces::{Stretch, stretch_by_stretch};
use super::sequences::{Found, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Piece, Recurrence, closures};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The forms of a recurrence that begins at 0, those that no others read after those that they read; none where all read
/// all, or the others have no forms in pieces.
pub(super) fn driven(recurrence: &Recurrence, known: &Assumptions, stop: &dyn Fn() -> bool) -> Option<Found> {
    let count = recurrence.sequences.len();
    let closures = closures(count, recurrence.reads());
    let unread = |place: &usize| {
        closures.iter().enumerate().all(|(one, reads)| !reads.contains(place) || closures[*place].contains(&one))
    };
    let (last, first): (BTreeSet<usize>, BTreeSet<usize>) = (0..count).partition(unread);
    if first.is_empty() || last.is_empty() {
        return None;
    }
    let others = recurrence.only(&first);
    let solved = solve_until(others.clone(), known, stop).ok()?;
    let group = recurrence.only(&last);
    let mut read = Vec::new();
    for (name, place, offset) in others.terms() {
        if !group.sequences.iter().any(|sequence| sequence.next.mentions(&name)) {
            continue;
        }
        if offset > 0 {
            return None;
        }
        read.push((name, solved.forms().get(place)?.by_pieces(&recurrence.index, 0)?));
    }
    // What is one form is put in by others.
    if read.iter().all(|(_, pieces)| pieces.len() < 2) {
        return None;
    }
    let (own, more) = stretch_by_stretch(&group, &stretches(&read, known)?, known, stop).ok()?;
    let conditions = solved.conditions().iter().cloned().chain(more).collect();
    let mut forms: BTreeMap<usize, _> = first.into_iter().zip(solved.forms().iter().cloned()).collect();
    forms.extend(last.into_iter().zip(own));
    Some((forms.into_values().collect(), conditions))
}

/// The stretches in which each of these sequences has one form; none where it is not known which of two ends comes first.
fn stretches(read: &[(Name, Vec<Piece>)], known: &Assumptions) -> Option<Vec<Stretch>> {
    let mut starts = vec![Value::zero()];
    for piece in read.iter().flat_map(|(_, pieces)| pieces) {
        let mut place = 0;
        while place < starts.len() {
            if known.decide(Relation::Lte, &piece.from, &starts[place])? {
                break;
            }
            place += 1;
        }
        let there = starts.get(place);
        if there.is_none_or(|start| known.decide(Relation::Eq, &piece.from, start) != Some(true)) {
            starts.insert(place, piece.from.clone());
        }
    }
    let stretch = |(place, from): (usize, &Value)| {
        let holds = |piece: &&Piece| known.decide(Relation::Lte, &piece.from, from) == Some(true);
        let image =
            |(name, pieces): &(Name, Vec<Piece>)| Some((name.clone(), pieces.iter().rev().find(holds)?.form.clone()));
        let images = read.iter().map(image).collect::<Option<_>>()?;
        Some(Stretch { from: from.clone(), until: starts.get(place + 1).cloned(), images, last: false })
    };
    starts.iter().enumerate().map(stretch).collect()
}
