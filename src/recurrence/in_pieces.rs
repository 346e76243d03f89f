//! Sequences that read one whose form is in pieces: each piece gives them forms, up to where the next one begins.

use std::collections::BTreeMap;

use super::Unknown;
use super::sequences::{Found, found, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Piece, Recurrence, Sequence};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

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
    let stretch = |piece: &Piece| Stretch {
        from: piece.from.clone(),
        until: piece.until.clone(),
        images: BTreeMap::from([(term.clone(), piece.form.clone())]),
        last: false,
    };
    let stretches: Vec<Stretch> = pieces.iter().map(stretch).collect();
    stretch_by_stretch(&group, &stretches, known, stop).map(Some)
}

/// Where each of the sequences that are read has one form.
#[derive(Clone)]
pub(super) struct Stretch {
    pub(super) from: Value,
    pub(super) until: Option<Value>,
    /// The forms, of the terms with these names.
    pub(super) images: BTreeMap<Name, Value>,
    /// Whether it is the last index of a stretch, of which the part before tells the terms.
    pub(super) last: bool,
}

impl Stretch {
    /// In two where the last step is another than those before, as that of `min(x+v,10)-x` on the way to 10 is.
    fn apart(&self, group: &Recurrence, known: &Assumptions) -> Result<Vec<Stretch>, Unknown> {
        let whole = || vec![self.clone()];
        let Some(until) = &self.until else { return Ok(whole()) };
        let before = until.sub(&Value::one())?;
        if known.decide(Relation::Gte, &before, &self.from) != Some(true) {
            return Ok(whole());
        }
        let index = &group.index;
        let changes = |stretch: &Stretch| {
            group.sequences.iter().any(|sequence| {
                let turns = |atom: &Atom| matches!(atom, Atom::Maximum(_) | Atom::Positive(_)) && atom.mentions(index);
                stretch.inside(sequence, index, known).is_ok_and(|next| next.atoms().iter().any(turns))
            })
        };
        let early = Stretch { until: Some(before.clone()), ..self.clone() };
        if !changes(self) || changes(&early) {
            return Ok(whole());
        }
        Ok(vec![early, Stretch { from: before, last: true, ..self.clone() }])
    }

    /// The equation of a sequence in it, with the index counted from its beginning, as simple as what holds in it makes it.
    fn inside(&self, sequence: &Sequence, index: &Name, known: &Assumptions) -> Result<Value, Unknown> {
        let later = Value::variable(index).add(&self.from)?;
        let mut images = BTreeMap::from([(index.clone(), later.clone())]);
        for (name, form) in &self.images {
            images.insert(name.clone(), form.with(index, &later)?);
        }
        let next = sequence.next.substitute(&images).map_err(|error| {
            let told: Vec<String> = self.images.iter().map(|(name, form)| format!("{name} = {form}")).collect();
            Unknown::because(format!(
                "where {} the equation of {} has no value: {}",
                told.join(", "),
                sequence.name,
                error.0
            ))
        })?;
        let mut here = known.clone();
        here.assume_natural(index);
        if let Some(until) = &self.until {
            here.assume(Relation::Lss, &Value::variable(index), &until.sub(&self.from)?);
        }
        Ok(here.simplify(&next))
    }
}

/// Forms of sequences of order 1 that read others, stretch by stretch: the term at the end of one begins the next.
pub(super) fn stretch_by_stretch(
    group: &Recurrence,
    stretches: &[Stretch],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Found, Unknown> {
    if stretches.len() > MOST_PIECES || group.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        let names: Vec<&str> = group.sequences.iter().map(|sequence| sequence.name.as_str()).collect();
        return Err(Unknown::because(format!("what {} read is in too many pieces", names.join(", "))));
    }
    let index = &group.index;
    let mut forms: Vec<Vec<Piece>> = vec![Vec::new(); group.sequences.len()];
    let mut conditions = Vec::new();
    let mut now = group.clone();
    let mut all_apart = Vec::new();
    for stretch in stretches {
        all_apart.extend(stretch.apart(group, known)?);
    }
    for stretch in &all_apart {
        for (here, sequence) in now.sequences.iter_mut().zip(&group.sequences) {
            here.next = stretch.inside(sequence, index, known)?;
        }
        let (own, more) = match found(&now, known, stop) {
            Ok(found) => found,
            Err(reason) => {
                let solved = solve_until(now.clone(), known, stop).map_err(|_| reason)?;
                (solved.forms().to_vec(), solved.conditions().to_vec())
            }
        };
        conditions.extend(more);
        let since = Value::variable(index).sub(&stretch.from)?;
        for ((form, here), all) in own.iter().zip(&mut now.sequences).zip(&mut forms) {
            let length = stretch.until.as_ref().map(|until| until.sub(&stretch.from)).transpose()?;
            let parts = up_to(form, index, length.as_ref(), known).ok_or_else(|| no_value(&here.name))?;
            if let (Some(length), Some(next)) = (&length, parts.last()) {
                here.start = vec![next.form.with(index, length)?];
            }
            if stretch.last {
                // The term with which it begins is told by the form before.
                all.last_mut().into_iter().for_each(|before| before.until = stretch.until.clone());
                continue;
            }
            let inside = parts.len() - usize::from(length.is_some());
            for part in &parts[..inside] {
                let until = part.until.as_ref().map(|until| until.add(&stretch.from)).transpose()?;
                let (from, form) = (part.from.add(&stretch.from)?, part.form.with(index, &since)?);
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
