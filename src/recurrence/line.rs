//! Motion along a straight line: variables that change together, but so that what is left to a fixed point only
//! shrinks. One number, the part of the way that is left, is then a recurrence of its own.

use std::collections::{BTreeMap, BTreeSet};

use super::together::closed;
use super::{Closed, NoClosedForm, Piece, solve_all};
use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, term};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The forms of variables that move straight towards a point; `None` if they do not.
///
/// # Errors
/// When the part that is left has no closed form, or a value is too large.
pub(super) fn along_a_line(
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    index: &Name,
    known: &Assumptions,
) -> Result<Option<Vec<(Name, Closed)>>, NoClosedForm> {
    let mut steps = BTreeMap::new();
    for (name, map) in maps {
        let Some(start) = starts.get(name) else { return Ok(None) };
        steps.insert(name, known.simplify(&map.substitute(starts)?.sub(start)?));
    }
    let moves = |step: &Value| known.decide(Relation::Neq, step, &Value::zero()) == Some(true);
    let Some(main) = steps.iter().find(|(_, step)| moves(step)).map(|(_, step)| step.clone()) else { return Ok(None) };
    let way = Value::variable(&Name::new("[way]"));
    let mut line = BTreeMap::new();
    for (name, step) in &steps {
        let slope = known.simplify(&step.div(&main)?);
        line.insert((*name).clone(), starts[*name].add(&way.mul(&slope)?)?);
    }
    let Some(centre) = centre(maps, &line)? else { return Ok(None) };
    if !moves(&centre) {
        return Ok(None);
    }
    let name = Name::new("left");
    let part = term(&name, index, 0);
    let (mut goals, mut ways, mut places) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
    for (variable, place) in &line {
        let goal = known.simplify(&place.with(&Name::new("[way]"), &centre)?);
        let whole = known.simplify(&goal.sub(&starts[variable])?);
        places.insert(variable.clone(), goal.sub(&Value::variable(&part).mul(&whole)?)?);
        goals.insert(variable.clone(), goal);
        ways.insert(variable.clone(), whole);
    }
    let Some(next) = left_next(maps, &places, (&goals, &ways), known)? else { return Ok(None) };
    let next = by_side(&next, &part, known)?;
    let sequences = vec![Sequence { name: name.clone(), start: vec![Value::one()], next }];
    let solved = solve_all(Recurrence { index: index.clone(), from: 0, sequences }, known)?;
    let left = closed(&solved, &name)?;
    let mut found = Vec::new();
    for variable in maps.keys() {
        let image = |piece: &Piece| {
            let form = goals[variable].sub(&piece.form.mul(&ways[variable])?)?;
            Ok::<_, NoClosedForm>(Piece { form, ..piece.clone() })
        };
        let pieces = left.pieces.iter().map(image).collect::<Result<_, _>>()?;
        found.push((variable.clone(), Closed { variable: variable.clone(), pieces, ..left.clone() }));
    }
    Ok(Some(found))
}

/// A value by the sign of a variable: a distance, which a direction is divided by, is simple on either side.
fn by_side(value: &Value, variable: &Name, known: &Assumptions) -> Result<Value, NoClosedForm> {
    let (own, zero) = (Value::variable(variable), Value::zero());
    let side = |relation| {
        let mut here = known.clone();
        here.assume(relation, &own, &zero);
        here.simplify(value)
    };
    let (above, below, between) = (side(Relation::Gtr), side(Relation::Lss), value.with(variable, &zero)?);
    let other = Value::choose(Relation::Lss, &own, &zero, &below, &known.simplify(&between))?;
    Ok(Value::choose(Relation::Gtr, &own, &zero, &above, &other)?)
}

/// The part that is left after a step, if all variables agree on it: the map keeps them on the line.
fn left_next(
    maps: &BTreeMap<Name, Value>,
    places: &BTreeMap<Name, Value>,
    (goals, ways): (&BTreeMap<Name, Value>, &BTreeMap<Name, Value>),
    known: &Assumptions,
) -> Result<Option<Value>, NoClosedForm> {
    let moves = |way: &Value| known.decide(Relation::Neq, way, &Value::zero()) == Some(true);
    let Some((variable, way)) = ways.iter().find(|(_, way)| moves(way)) else { return Ok(None) };
    let next = goals[variable].sub(&maps[variable].substitute(places)?)?.div(way)?;
    for (variable, map) in maps {
        let image = map.substitute(places)?;
        let wanted = goals[variable].sub(&next.mul(&ways[variable])?)?;
        if known.decide(Relation::Eq, &image, &wanted) != Some(true) {
            return Ok(None);
        }
    }
    Ok(Some(next))
}

/// Where on the line a distance in the maps vanishes: its square is a square there.
fn centre(maps: &BTreeMap<Name, Value>, line: &BTreeMap<Name, Value>) -> Result<Option<Value>, NoClosedForm> {
    let way = Name::new("[way]");
    let mut roots = BTreeSet::new();
    for map in maps.values() {
        collect_roots(&map.substitute(line)?, &way, &mut roots);
    }
    for root in roots {
        let at = |number: i64| root.with(&way, &Value::integer(number));
        let (ahead, here, behind) = (at(1)?, at(0)?, at(-1)?);
        let half = Value::fraction(1, 2)?;
        let square = ahead.add(&behind)?.mul(&half)?.sub(&here)?;
        let slope = ahead.sub(&behind)?.mul(&half)?;
        if square.is_zero() {
            continue;
        }
        let centre = slope.mul(&half)?.neg()?.div(&square)?;
        let variable = Value::variable(&way).sub(&centre)?;
        if square.mul(&variable)?.mul(&variable)? == root {
            return Ok(Some(centre));
        }
    }
    Ok(None)
}

/// What stands under the roots of a value.
fn collect_roots(value: &Value, name: &Name, found: &mut BTreeSet<Value>) {
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(name)) {
        match &atom {
            Atom::Root(inner) => {
                found.insert(inner.clone());
            }
            Atom::Positive(inner) | Atom::Floor(inner) => collect_roots(inner, name, found),
            Atom::Maximum(parts) | Atom::Apply(_, parts) => {
                parts.iter().for_each(|part| collect_roots(part, name, found));
            }
            Atom::Power(base, exponent) => [base, exponent].iter().for_each(|part| collect_roots(part, name, found)),
            Atom::Variable(_) => {}
        }
    }
}
