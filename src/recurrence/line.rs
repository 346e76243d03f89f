//! Motion along a straight line: variables that change together, but so that what is left to a fixed point only
//! shrinks. One number, the part of the way that is left, is then a recurrence of its own.

use std::collections::{BTreeMap, BTreeSet};

use super::sequences::Found;
use super::together::closed;
use super::{Closed, Piece, Unknown, solve_all};
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Form, Recurrence, Sequence, settled_by, term};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The bits that the coefficients of a first step that is a number may have, with those under its roots.
const MOST_BITS: u64 = 200;

/// The bits of all coefficients, those in its atoms included.
fn all_bits(value: &Value) -> u64 {
    let inner = value.atoms().into_iter().flat_map(|atom| atom.parts().into_iter().map(all_bits).collect::<Vec<_>>());
    let own = value.polynomials().map_or(0, |(above, below)| {
        above.bits() * above.terms().len() as u64 + below.bits() * below.terms().len() as u64
    });
    inner.fold(own, u64::saturating_add)
}

/// Forms of variables, where they are found.
type Forms = Result<Option<Vec<(Name, Closed)>>, Unknown>;

/// The forms of variables that move straight towards a point; `None` if they do not.
///
/// # Errors
/// When the part that is left has no closed form, or a value is too large.
pub(super) fn along_a_line(
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    index: &Name,
    known: &Assumptions,
) -> Forms {
    Motion { maps, starts, index, known }.along_a_line()
}

/// The forms of sequences that move straight towards a point, to be checked; none if they do not.
///
/// # Errors
/// As [`along_a_line`].
pub(super) fn straight(recurrence: &Recurrence, known: &Assumptions) -> Result<Option<Found>, Unknown> {
    let (mut maps, mut starts) = (BTreeMap::new(), BTreeMap::new());
    let mut names = Vec::new();
    for sequence in &recurrence.sequences {
        let [start] = sequence.start.as_slice() else { return Ok(None) };
        let name = recurrence.term(&sequence.name, 0);
        maps.insert(name.clone(), sequence.next.clone());
        starts.insert(name.clone(), start.clone());
        names.push(name);
    }
    if names.len() < 2 || maps.values().any(|map| map.mentions(&recurrence.index)) {
        return Ok(None);
    }
    if let Some(forms) = standing(&maps, &starts, &names, known) {
        return Ok(Some((forms, Vec::new())));
    }
    let Some(found) = along_a_line(&maps, &starts, &recurrence.index, known)? else { return Ok(None) };
    let conditions = found.first().map(|(_, closed)| closed.conditions.clone()).unwrap_or_default();
    let own = |name: &Name| found.iter().find(|(other, _)| other == name).map(|(_, form)| form.pieces.clone());
    let forms: Option<Vec<Form>> = names.iter().map(|name| Some(Form::Pieces(own(name)?))).collect();
    Ok(forms.map(|forms| (forms, conditions)))
}

/// Constant forms, where the first step leads nowhere.
fn standing(
    maps: &BTreeMap<Name, Value>,
    starts: &BTreeMap<Name, Value>,
    names: &[Name],
    known: &Assumptions,
) -> Option<Vec<Form>> {
    let stays = |name: &Name| {
        // What is divided by may be 0 at the start, and excluded by a condition that fails there for all parameters.
        let zero = Value::zero();
        let holds = |inner: &Value| known.decide(Relation::Gtr, &inner.substitute(starts).ok()?, &zero);
        let map = settled_by(maps.get(name)?, &|_, _| false, &holds).ok()?;
        let (next, start) = (map.substitute(starts).ok()?, starts.get(name)?);
        let stays = known.decide(Relation::Eq, &next, start) == Some(true);
        // In a piece it is asked of an equation what its conditions are at the terms.
        stays.then(|| Form::Pieces(vec![Piece { from: Value::zero(), until: None, form: start.clone() }]))
    };
    names.iter().map(stays).collect()
}

/// Variables that change together.
struct Motion<'a> {
    maps: &'a BTreeMap<Name, Value>,
    starts: &'a BTreeMap<Name, Value>,
    index: &'a Name,
    known: &'a Assumptions,
}

impl Motion<'_> {
    fn along_a_line(&self) -> Forms {
        let Motion { maps, starts, known, .. } = self;
        let mut steps = BTreeMap::new();
        for (name, map) in *maps {
            let Some(start) = starts.get(name) else { return Ok(None) };
            steps.insert(name, known.simplify(&map.substitute(starts)?.sub(start)?));
        }
        // What comes of numbers with roots in roots is longer in each line that begins where the last one ended.
        if steps.values().any(|step| step.variables().is_empty() && all_bits(step) > MOST_BITS) {
            return Ok(None);
        }
        let moves = |step: &Value| known.decide(Relation::Neq, step, &Value::zero()) == Some(true);
        let Some(main) = steps.values().find(|step| moves(step)).cloned() else { return self.towards() };
        match self.along_the_step(&steps, &main) {
            found @ Ok(Some(_)) => found,
            other => match self.towards() {
                found @ Ok(Some(_)) => found,
                _ => other,
            },
        }
    }

    /// The same where the first step leads somewhere: the line through the start that it is on.
    fn along_the_step(&self, steps: &BTreeMap<&Name, Value>, main: &Value) -> Forms {
        let Motion { maps, starts, known, .. } = self;
        let moves = |step: &Value| known.decide(Relation::Neq, step, &Value::zero()) == Some(true);
        let name = Name::new("[way]");
        let way = Value::variable(&name);
        let mut line = BTreeMap::new();
        for (variable, step) in steps {
            let slope = known.simplify(&step.div(main)?);
            line.insert((*variable).clone(), starts[*variable].add(&way.mul(&slope)?)?);
        }
        let Some(centre) = centre(maps, &line)? else { return Ok(None) };
        if !moves(&centre) {
            return Ok(None);
        }
        let mut goals = BTreeMap::new();
        for (variable, place) in &line {
            goals.insert(variable.clone(), known.simplify(&place.with(&name, &centre)?));
        }
        self.straight(&goals)
    }

    /// Where the first step is not known to lead anywhere: the point is where all components of a distance in the maps are
    /// 0, and the start is supposed to lie elsewhere.
    fn towards(&self) -> Forms {
        let own = |value: &Value| value.variables().into_iter().find(|name| self.maps.contains_key(name));
        let mut roots = BTreeSet::new();
        self.maps.values().for_each(|map| collect_roots(map, &mut roots));
        for root in roots {
            let Some(parts) = root.squares() else { continue };
            let vanishes = |part: &Value| {
                let variable = own(part)?;
                let (slope, rest) = part.linear_in(&variable)?;
                let goal = rest.neg().ok()?.div(&slope).ok()?;
                own(&goal).is_none().then_some((variable, goal))
            };
            let Some(goals) = parts.iter().map(vanishes).collect::<Option<BTreeMap<Name, Value>>>() else { continue };
            if goals.len() != self.maps.len() || parts.len() != self.maps.len() {
                continue;
            }
            let distance = root.substitute(self.starts)?.sqrt()?;
            let apart = self.known.decide(Relation::Gtr, &distance, &Value::zero());
            if apart == Some(false) {
                continue;
            }
            if let Some((relation, side)) = self.side(&distance) {
                return Err(Unknown::undecided(relation, &side, &Value::zero()));
            }
            let mut known = self.known.clone();
            known.assume(Relation::Gtr, &distance, &Value::zero());
            let Some(mut found) = (Motion { known: &known, ..*self }).straight(&goals)? else { continue };
            // With symbols it is stated also where it follows: the check of the forms reads it.
            if apart.is_none() || !distance.variables().is_empty() {
                let condition = (Relation::Gtr, distance, Value::zero());
                found.iter_mut().for_each(|(_, closed)| closed.conditions.insert(0, condition.clone()));
            }
            return Ok(Some(found));
        }
        Ok(None)
    }

    /// What a distance is the size of, up to a factor, where it is not known on which side of 0 that lies: on a line of which
    /// all points are multiples of one, `norm((d,d))` is `sqrt(2)*abs(d)`.
    fn side(&self, distance: &Value) -> Option<(Relation, Value)> {
        let decide = |relation, inner: &Value| self.known.decide(relation, inner, &Value::zero());
        distance.atoms().into_iter().find_map(|atom| {
            let Atom::Maximum(parts) = atom else { return None };
            let [inner] = &*parts else { return None };
            let relation = match decide(Relation::Gtr, inner) {
                None => Relation::Gtr,
                Some(false) if decide(Relation::Lss, inner).is_none() => Relation::Lss,
                Some(_) => return None,
            };
            Some((relation, inner.clone()))
        })
    }

    /// The forms of variables that go straight from their starts to these goals: by the part of the way that is left, or
    /// by the distance, where that has roots which the part would have in its equation.
    fn straight(&self, goals: &BTreeMap<Name, Value>) -> Forms {
        let (mut ways, mut square) = (BTreeMap::new(), Value::zero());
        for (variable, goal) in goals {
            let Some(start) = self.starts.get(variable) else { return Ok(None) };
            let way = self.known.simplify(&goal.sub(start)?);
            square = square.add(&way.mul(&way)?)?;
            ways.insert(variable.clone(), way);
        }
        let distance = self.known.simplify(&square.sqrt()?);
        let by_distance = || match self.known.decide(Relation::Gtr, &distance, &Value::zero()) {
            Some(true) => self.measured(goals, &ways, distance.clone()),
            _ => Ok(None),
        };
        let by_parts = || self.measured(goals, &ways, Value::one());
        // A distance with symbols stands in what is asked, and in forms, as it is.
        let (first, second): (&dyn Fn() -> Forms, &dyn Fn() -> Forms) =
            if distance.variables().is_empty() { (&by_parts, &by_distance) } else { (&by_distance, &by_parts) };
        let one = first();
        if let Ok(Some(_)) = one {
            return one;
        }
        let other = second();
        let (of_distance, of_parts) = if distance.variables().is_empty() { (other, one) } else { (one, other) };
        match (of_distance, of_parts) {
            (found @ Ok(Some(_)), _) | (_, found @ Ok(Some(_))) => found,
            (Err(unknown), _) if unknown.open.is_some() => Err(unknown),
            (_, found) => found,
        }
    }

    /// The same, where what is left is measured with this for the whole way.
    fn measured(&self, goals: &BTreeMap<Name, Value>, ways: &BTreeMap<Name, Value>, whole: Value) -> Forms {
        let (name, known) = (Name::new("left"), self.known);
        let part = term(&name, self.index, 0);
        let (mut ways, mut places) = (ways.clone(), BTreeMap::new());
        for (variable, way) in &mut ways {
            *way = known.simplify(&way.div(&whole)?);
            places.insert(variable.clone(), goals[variable].sub(&Value::variable(&part).mul(way)?)?);
        }
        let Some(next) = left_next(self.maps, &places, (goals, &ways), &part, known)? else { return Ok(None) };
        let Some(next) = by_side(&next, &part, known)? else { return Ok(None) };
        let sequences = vec![Sequence { name: name.clone(), start: vec![whole], next }];
        let solved = solve_all(Recurrence { index: self.index.clone(), from: 0, sequences }, known);
        // What is asked of the part that is left is nothing that may be asked of parameters.
        let own = |open: &Comparison| open.1.mentions(&part) || open.2.mentions(&part);
        let solved = solved.map_err(|unknown| Unknown { open: unknown.open.filter(|open| !own(open)), ..unknown })?;
        let left = closed(&solved, &name)?;
        let mut found = Vec::new();
        for variable in self.maps.keys() {
            let image = |piece: &Piece| {
                let form = goals[variable].sub(&piece.form.mul(&ways[variable])?)?;
                Ok::<_, Unknown>(Piece { form, ..piece.clone() })
            };
            let pieces = without_breaks(left.pieces.iter().map(image).collect::<Result<_, _>>()?);
            found.push((variable.clone(), Closed { variable: variable.clone(), pieces, ..left.clone() }));
        }
        Ok(Some(found))
    }
}

/// Pieces without those that go on as the one before them.
fn without_breaks(pieces: Vec<Piece>) -> Vec<Piece> {
    let mut joined: Vec<Piece> = Vec::new();
    for piece in pieces {
        match joined.last_mut().filter(|last| last.form == piece.form) {
            Some(last) => last.until = piece.until,
            None => joined.push(piece),
        }
    }
    joined
}

/// A value by the sign of a variable: a distance, which a direction is divided by, is simple on either side. Where the
/// variable is 0 and the value is not defined, nothing is said: 0 stands there. None where it may divide by 0 elsewhere.
fn by_side(value: &Value, variable: &Name, known: &Assumptions) -> Result<Option<Value>, Unknown> {
    let (own, zero) = (Value::variable(variable), Value::zero());
    let side = |relation| {
        let mut here = known.clone();
        here.assume(relation, &own, &zero);
        let simple = here.simplify(value);
        let divisor = simple.denominator().unwrap_or_else(Value::zero);
        (here.decide(Relation::Neq, &divisor, &zero) == Some(true)).then_some(simple)
    };
    let (Some(above), Some(below)) = (side(Relation::Gtr), side(Relation::Lss)) else { return Ok(None) };
    let between = value.with(variable, &zero).map_or(zero.clone(), |between| known.simplify(&between));
    let other = Value::choose(Relation::Lss, &own, &zero, &below, &between)?;
    Ok(Some(Value::choose(Relation::Gtr, &own, &zero, &above, &other)?))
}

/// The part that is left after a step, if all variables agree on it: the map keeps them on the line.
fn left_next(
    maps: &BTreeMap<Name, Value>,
    places: &BTreeMap<Name, Value>,
    (goals, ways): (&BTreeMap<Name, Value>, &BTreeMap<Name, Value>),
    part: &Name,
    known: &Assumptions,
) -> Result<Option<Value>, Unknown> {
    let Some((variable, way)) = ways.iter().find(|(_, way)| !way.is_zero()) else { return Ok(None) };
    let next = known.simplify(&goals[variable].sub(&maps[variable].substitute(places)?)?.div(way)?);
    for (variable, map) in maps {
        let image = map.substitute(places)?;
        let wanted = goals[variable].sub(&next.mul(&ways[variable])?)?;
        if known.decide(Relation::Eq, &image, &wanted) != Some(true) && !same_on_each_side(&image, &wanted, part, known)
        {
            return Ok(None);
        }
    }
    Ok(Some(next))
}

/// Whether two values are equal where a variable is above 0 and where it is below: `x/abs(x)` is `abs(x)/x`.
fn same_on_each_side(one: &Value, other: &Value, variable: &Name, known: &Assumptions) -> bool {
    let own = Value::variable(variable);
    [Relation::Gtr, Relation::Lss].into_iter().all(|side| {
        let mut here = known.clone();
        here.assume(side, &own, &Value::zero());
        here.decide(Relation::Eq, &here.simplify(one), &here.simplify(other)) == Some(true)
    })
}

/// Where on the line a distance in the maps vanishes: its square is a square there.
fn centre(maps: &BTreeMap<Name, Value>, line: &BTreeMap<Name, Value>) -> Result<Option<Value>, Unknown> {
    let way = Name::new("[way]");
    let mut roots = BTreeSet::new();
    maps.values().for_each(|map| collect_roots(map, &mut roots));
    for root in roots {
        let root = root.substitute(line)?;
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
fn collect_roots(value: &Value, found: &mut BTreeSet<Value>) {
    for atom in value.atoms() {
        match &atom {
            Atom::Root(inner) => {
                found.insert(inner.clone());
            }
            Atom::Positive(inner) | Atom::Floor(inner) => collect_roots(inner, found),
            Atom::Maximum(parts) | Atom::Apply(_, parts) => {
                // `abs(x) = 2*max(0,x)-x` is the root of `x^2`.
                if let ([inner], Atom::Maximum(_)) = (&**parts, &atom)
                    && let Ok(square) = inner.mul(inner)
                {
                    found.insert(square);
                }
                parts.iter().for_each(|part| collect_roots(part, found));
            }
            Atom::Power(base, exponent) => [base, exponent].iter().for_each(|part| collect_roots(part, found)),
            Atom::Variable(_) => {}
        }
    }
}
