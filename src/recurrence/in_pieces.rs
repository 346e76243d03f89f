//! Sequences that read one whose form is in pieces: each piece gives them forms, up to where the next one begins.

use super::Unknown;
use super::sequences::{Found, found};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Sequence};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The most pieces that are gone through.
const MOST_PIECES: usize = 16;

/// The forms of the sequences that are left, which are of order 1, where they read the one at this place, whose own form is
/// in these pieces, counted from 0; nothing where they do not.
pub(super) fn in_pieces(
    open: &Recurrence,
    (place, pieces): (usize, &[Piece]),
    rest: &[usize],
    (known, stop): (&Assumptions, &dyn Fn() -> bool),
) -> Result<Option<Found>, Unknown> {
    let sequences: Vec<Sequence> = rest.iter().map(|place| open.sequences[*place].clone()).collect();
    let term = open.term(&open.sequences[place].name, 0);
    // Where pieces end at numbers there are other ways, which find fewer of them; not so where first terms are pieces.
    let symbolic = pieces.iter().filter_map(|piece| piece.until.as_ref()).any(|until| until.as_rational().is_none());
    let alone = |piece: &Piece| piece.until == piece.from.add(&Value::one()).ok();
    let first_terms = pieces.split_last().is_some_and(|(_, early)| !early.is_empty() && early.iter().all(alone));
    if !(symbolic || first_terms) || !sequences.iter().any(|sequence| sequence.next.mentions(&term)) {
        return Ok(None);
    }
    let group = Recurrence { index: open.index.clone(), from: 0, sequences };
    piece_by_piece(&group, (&term, pieces), known, stop).map(Some)
}

fn piece_by_piece(
    group: &Recurrence,
    (term, pieces): (&Name, &[Piece]),
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Found, Unknown> {
    if pieces.len() > MOST_PIECES || group.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        return Err(Unknown::because(format!("the form of {term} is in too many pieces to be put into the others")));
    }
    let index = &group.index;
    let count = Value::variable(index);
    let mut forms: Vec<Vec<Piece>> = vec![Vec::new(); group.sequences.len()];
    let mut conditions = Vec::new();
    let mut now = group.clone();
    for piece in pieces {
        // Within the piece the index counts from 0.
        let later = count.add(&piece.from)?;
        let value = piece.form.with(index, &later)?;
        for (here, sequence) in now.sequences.iter_mut().zip(&group.sequences) {
            let next = sequence.next.with(index, &later)?.with(term, &value);
            here.next = next.map_err(|error| {
                Unknown::because(format!(
                    "where {term} = {value} the equation of {} has no value: {}",
                    here.name, error.0
                ))
            })?;
        }
        let (own, more) = found(&now, known, stop)?;
        conditions.extend(more);
        let since = count.sub(&piece.from)?;
        for ((form, here), all) in own.iter().zip(&mut now.sequences).zip(&mut forms) {
            let length = piece.until.as_ref().map(|until| until.sub(&piece.from)).transpose()?;
            let parts = up_to(form, index, length.as_ref(), known).ok_or_else(|| no_value(&here.name))?;
            if let (Some(length), Some(next)) = (&length, parts.last()) {
                here.start = vec![next.form.with(index, length)?];
            }
            let inside = parts.len() - usize::from(length.is_some());
            for part in &parts[..inside] {
                let until = part.until.as_ref().map(|until| until.add(&piece.from)).transpose()?;
                let (from, form) = (part.from.add(&piece.from)?, part.form.with(index, &since)?);
                match all.last_mut().filter(|before| before.form == form) {
                    Some(before) => before.until = until,
                    None => all.push(Piece { from, until, form }),
                }
            }
        }
    }
    Ok((forms.into_iter().map(Form::Pieces).collect(), conditions))
}

/// The pieces of a form up to a length, and behind them the one that the term at that index is told by; all of them where it
/// has none. `None` where it is not known which these are.
fn up_to(form: &Form, index: &Name, length: Option<&Value>, known: &Assumptions) -> Option<Vec<Piece>> {
    let parts = match form.value(index) {
        Some(form) => vec![Piece { from: Value::zero(), until: None, form }],
        None => form.by_pieces(index, 0)?,
    };
    let Some(length) = length else { return Some(parts) };
    let mut found = Vec::new();
    for part in parts {
        let ends = part.until.as_ref().map(|until| known.decide(Relation::Lss, length, until));
        match ends {
            // It goes on behind the length.
            None | Some(Some(true)) => {
                if known.decide(Relation::Gte, length, &part.from)? {
                    let starts = known.decide(Relation::Gtr, length, &part.from) != Some(false);
                    found.extend(starts.then(|| Piece { until: Some(length.clone()), ..part.clone() }));
                }
                found.push(part);
                return Some(found);
            }
            Some(Some(false)) => found.push(part),
            Some(None) => return None,
        }
    }
    None
}

fn no_value(name: &Name) -> Unknown {
    Unknown::because(format!("what {name} comes to in one piece is no single value with which the next could begin"))
}
