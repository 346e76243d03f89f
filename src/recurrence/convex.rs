//! When a sum of maxima of lines, as a distance in the greatest or the summed difference of two places is one, gets below a
//! bound, or above it: below it each of its lines is, and above it one of them. The same below a bound of what is quadratic:
//! behind where the last of its parabolas is, if the others are there still.

use super::Reach;
use super::parabola::{before_rounding, coefficients, is_not_behind, past};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Piece};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The most lines.
const MOST_LINES: usize = 16;

/// `slope*n + constant`
struct Line {
    slope: Value,
    constant: Value,
}

/// The first index at which a value of one form for all indices compares with 0, by the parts of its maxima: lines, or parabolas.
pub(super) fn part_by_part(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    convex(pieces, index, relation, known).or_else(|| between(pieces, index, relation, known))
}

/// The same of lines, also of those that end where nothing moves any more, and it is below 0.
fn convex(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let (Piece { from, until, form }, rest) = pieces.split_first()?;
    let at_rest = |piece: &Piece| {
        !piece.form.mentions(index) && known.decide(relation, &piece.form, &Value::zero()) == Some(true)
    };
    if until.is_some() == rest.is_empty() || !rest.iter().all(at_rest) {
        return None;
    }
    if !from.is_zero() || !form.atoms().iter().any(|atom| matches!(atom, Atom::Maximum(_)) && atom.mentions(index)) {
        return None;
    }
    // Below 0 as it is, or its opposite above it.
    let (lines, relation) = match lines(form, index, known) {
        Some(lines) => (lines, relation),
        None => (lines(&form.neg().ok()?, index, known)?, relation.mirrored()),
    };
    match relation {
        Relation::Lss | Relation::Lte => all_below((&lines, until.as_ref()), index, relation, known),
        Relation::Gtr | Relation::Gte if until.is_none() => one_above(&lines, relation, known),
        Relation::Gtr | Relation::Gte => None,
        Relation::Eq | Relation::Neq => None,
    }
}

/// The same of parabolas below 0, or at 0: where one of its parts is there first, under the condition that the others are.
fn between(pieces: &[Piece], index: &Name, relation: Relation, known: &Assumptions) -> Option<Reach> {
    let [Piece { from, until: None, form }] = pieces else { return None };
    let all = |form: &Value, relation: Relation| {
        Some(opened(form, index, known)?.into_iter().map(|part| (relation, part)).collect::<Vec<_>>())
    };
    let parts = match relation {
        Relation::Lss | Relation::Lte => all(form, relation)?,
        Relation::Gtr | Relation::Gte => all(&form.neg().ok()?, relation.mirrored())?,
        Relation::Eq => vec![(Relation::Gte, form.clone()), (Relation::Lte, form.clone())],
        Relation::Neq => return None,
    };
    let zero = Value::zero();
    let at = |part: &Value, place: &Value| Some(known.simplify(&part.with(index, place).ok()?));
    let holds = |(relation, part): &(Relation, Value), place: &Value| known.decide(*relation, &at(part, place)?, &zero);
    if !from.is_zero() || parts.len() < 2 || parts.iter().all(|part| holds(part, from) == Some(true)) {
        return None;
    }
    let mut open = None;
    for (place, (relation, part)) in parts.iter().enumerate() {
        let alone = [Piece { from: from.clone(), until: None, form: part.clone() }];
        match past(&alone, index, *relation, known) {
            Some(Reach::At(first, conditions)) if conditions.is_empty() => {
                let others = parts.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, part)| part);
                let mut conditions: Vec<Comparison> = Vec::new();
                for other in others {
                    match holds(other, &first) {
                        Some(true) => {}
                        Some(false) if goes_on(other, &first, index, known) == Some(true) => {
                            return Some(Reach::Never(format!(
                                "it steps over between {index} = {first} and the one before"
                            )));
                        }
                        Some(false) => return None,
                        None => conditions.push((other.0, at(&other.1, &first)?, zero.clone())),
                    }
                }
                return Some(Reach::At(first, conditions));
            }
            Some(never @ Reach::Never(_)) => return Some(never),
            Some(Reach::Unknown(why)) => open = open.or(Some(Reach::Unknown(why))),
            _ => {}
        }
    }
    open
}

/// Whether what is not below 0 at an index, or not above it, only goes on so behind it.
fn goes_on((relation, part): &(Relation, Value), at: &Value, index: &Name, known: &Assumptions) -> Option<bool> {
    let away = match relation {
        Relation::Lss | Relation::Lte => part.clone(),
        Relation::Gtr | Relation::Gte => part.neg().ok()?,
        Relation::Eq | Relation::Neq => return None,
    };
    let [_, linear, square] = coefficients(&away, index).ok()??;
    let slope = square.mul(at).and_then(|half| half.add(&half)).and_then(|twice| twice.add(&linear)).ok()?;
    let is = |value: &Value| known.decide(Relation::Gte, value, &Value::zero()) == Some(true);
    Some(is(&square) && is(&known.simplify(&slope)))
}

/// The values of which a sum of maxima, each times what is above 0, is the greatest everywhere; itself where there is none in it.
fn opened(form: &Value, index: &Name, known: &Assumptions) -> Option<Vec<Value>> {
    let (mut all, part) = (vec![form.clone()], Name::new("[part]"));
    let bent =
        |value: &Value| value.atoms().into_iter().find(|atom| matches!(atom, Atom::Maximum(_)) && atom.mentions(index));
    while let Some(atom) = all.iter().find_map(bent) {
        let Atom::Maximum(elements) = &atom else { return None };
        let mut opened = Vec::new();
        for value in &all {
            let (factor, rest) = value.with_atom(&atom, &Value::variable(&part)).ok()?.linear_in(&part)?;
            if factor.is_zero() {
                opened.push(rest);
                continue;
            }
            if factor.mentions(index) || known.decide(Relation::Gtr, &factor, &Value::zero()) != Some(true) {
                return None;
            }
            for element in std::iter::once(&Value::zero()).chain(elements.iter()) {
                opened.push(factor.mul(element).and_then(|one| one.add(&rest)).ok()?);
            }
        }
        opened.sort();
        opened.dedup();
        all = opened;
        if all.len() > MOST_LINES {
            return None;
        }
    }
    Some(all)
}

/// The same where all of them are lines.
fn lines(form: &Value, index: &Name, known: &Assumptions) -> Option<Vec<Line>> {
    let line = |value: Value| {
        let (slope, constant) = value.linear_in(index)?;
        let free = !slope.mentions(index) && !constant.mentions(index);
        free.then(|| Line { slope: known.simplify(&slope), constant: known.simplify(&constant) })
    };
    opened(form, index, known)?.into_iter().map(line).collect()
}

/// Whether a line rises, falls or does neither; otherwise what would have to be known.
fn way(line: &Line, known: &Assumptions) -> Result<Relation, Reach> {
    let zero = Value::zero();
    let is = |relation: Relation| known.decide(relation, &line.slope, &zero);
    let told = [Relation::Eq, Relation::Gtr, Relation::Lss].into_iter().find(|relation| is(*relation) == Some(true));
    told.ok_or_else(|| {
        let open = if is(Relation::Gtr).is_none() { Relation::Gtr } else { Relation::Eq };
        Reach::undecided(open, &line.slope, &zero)
    })
}

/// Where all lines are below 0: behind where those that fall are, and before where those that rise are no more. Before an index at
/// which all are, it is to be.
fn all_below(
    (lines, until): (&[Line], Option<&Value>),
    index: &Name,
    relation: Relation,
    known: &Assumptions,
) -> Option<Reach> {
    let counts = relation == Relation::Lte;

    let (zero, mut first, mut ends) = (Value::zero(), vec![Value::zero()], Vec::new());
    for line in lines {
        let crossing = || line.constant.neg()?.div(&line.slope);
        match way(line, known) {
            Err(open) => return Some(open),
            Ok(Relation::Eq) => match known.decide(relation, &line.constant, &zero) {
                Some(true) => {}
                Some(false) => return Some(Reach::Never(format!("{} stays above its bound", line.constant))),
                None => return Some(Reach::undecided(relation, &line.constant, &zero)),
            },
            Ok(Relation::Lss) => {
                let root = known.simplify(&crossing().ok()?);
                let own = known.simplify(&behind(&root, relation)?);
                if until.is_some_and(|until| !is_not_behind((&root, &own), until, counts, known)) {
                    return None;
                }
                first.push(own);
            }
            Ok(_) => {
                let end = known.simplify(&crossing().ok()?);
                // Of what ends before all that counts is whether it is below 0 up to there.
                let exact = until.map(|until| before_rounding(until).unwrap_or_else(|| until.clone()));
                let later = exact.is_some_and(|exact| known.decide(Relation::Gte, &end, &exact) == Some(true));
                if !later {
                    ends.push(end);
                }
            }
        }
    }
    let at = known.simplify(&Value::maximum(&first).ok()?);
    let mut conditions: Vec<Comparison> = Vec::new();
    for end in ends {
        let mut there = known.clone();
        conditions.iter().for_each(|(relation, left, right)| there.assume(*relation, left, right));
        match there.decide(relation, &at, &end) {
            Some(true) => {}
            Some(false) => {
                return Some(Reach::Never(format!("it would be before {index} = {end}, and not before {at}")));
            }
            None => conditions.push((relation, at.clone(), end)),
        }
    }
    Some(Reach::At(at, conditions))
}

/// Where one line is above 0: at the start, or behind where the first of those that rise is.
fn one_above(lines: &[Line], relation: Relation, known: &Assumptions) -> Option<Reach> {
    let zero = Value::zero();
    let at_start = |line: &Line| known.decide(relation, &line.constant, &zero);
    if lines.iter().any(|line| at_start(line) == Some(true)) {
        return Some(Reach::At(zero, Vec::new()));
    }
    // Of the greatest of them, where that is known, the others follow.
    let open: Vec<&Line> = lines.iter().filter(|line| at_start(line).is_none()).collect();
    let over = |one: &Line, other: &Line| known.decide(Relation::Gte, &one.constant, &other.constant) == Some(true);
    let greatest = open.iter().find(|one| open.iter().all(|other| over(one, other)));
    if let Some(open) = greatest.or(open.first()) {
        return Some(Reach::undecided(relation, &open.constant, &zero));
    }
    let mut first: Vec<Value> = Vec::new();
    for line in lines {
        match way(line, known) {
            Err(open) => return Some(open),
            Ok(Relation::Gtr) => {
                let crossing = line.constant.neg().and_then(|rest| rest.div(&line.slope)).ok()?;
                first.push(known.simplify(&behind(&crossing, relation)?).neg().ok()?);
            }
            Ok(_) => {}
        }
    }
    if first.is_empty() {
        return Some(Reach::Never("none of its lines rises".to_string()));
    }
    Some(Reach::At(known.simplify(&Value::maximum(&first).ok()?.neg().ok()?), Vec::new()))
}

/// The first whole number behind a crossing, or at it where that counts.
fn behind(crossing: &Value, relation: Relation) -> Option<Value> {
    match relation {
        Relation::Gte | Relation::Lte => crossing.ceiling().ok(),
        _ => crossing.floor().ok()?.add(&Value::one()).ok(),
    }
}
