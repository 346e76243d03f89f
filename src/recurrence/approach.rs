//! `x := x + clamp(g - x, -w, w)`: straight to a goal, no faster than w a step. Whatever the numbers are, it arrives
//! after `ceil(distance / w)` steps. So do `max(x - w, g)` from above g and `min(x + w, g)` from below; from the other
//! side these jump there.

use std::collections::BTreeSet;

use super::region::breaks_of;
use super::{Closed, Motion, Piece, Unknown};
use crate::assumption::Assumptions;
use crate::name::Name;
use crate::value::{Relation, Value};

/// The form by two pieces, on the way and at the goal; `None` of any other map.
///
/// # Errors
/// When it is not known on which side of the goal it starts.
pub(super) fn approach(motion: &Motion<'_>) -> Result<Option<Closed>, Unknown> {
    let Motion { map, variable, start, index, known } = *motion;
    let either_way = goal_and_steps(map, variable, known)?;
    let one_way = either_way.is_none();
    let found = match either_way {
        None => one_sided(map, variable, known)?.map(|(goal, step)| (goal, [step.clone(), step])),
        found => found,
    };
    let Some((goal, [upward, downward])) = found else { return Ok(None) };
    let (distance, zero) = (goal.sub(start)?, Value::zero());
    if one_way && known.decide(Relation::Eq, &distance, &zero) == Some(true) {
        let pieces = vec![Piece { from: zero, until: None, form: goal }];
        return Ok(Some(Closed { variable: variable.clone(), pieces, conditions: Vec::new() }));
    }
    let ahead = if known.decide(Relation::Gtr, &distance, &zero) == Some(true) {
        true
    } else if known.decide(Relation::Lss, &distance, &zero) == Some(true) {
        false
    } else {
        // Where it is known not to lie ahead it may still be where it starts.
        let behind = known.decide(Relation::Lte, &distance, &zero) == Some(true);
        return Err(Unknown::undecided(if behind { Relation::Eq } else { Relation::Lss }, start, &goal));
    };
    let step = if ahead { upward } else { downward };
    let up = known.decide(Relation::Gtr, &step, &zero) == Some(true);
    let (steps, on_the_way) = if one_way && up != ahead {
        // From the side to which it does not move it jumps there.
        (Value::one(), start.clone())
    } else {
        let step = if up == ahead { step } else { step.neg()? };
        let steps = known.simplify(&distance.div(&step)?.ceiling()?);
        (steps, start.add(&Value::variable(index).mul(&step)?)?)
    };
    let pieces = vec![
        Piece { from: zero, until: Some(steps.clone()), form: on_the_way },
        Piece { from: steps, until: None, form: goal },
    ];
    Ok(Some(Closed { variable: variable.clone(), pieces, conditions: Vec::new() }))
}

/// The goal of `max(x - w, g)` or `min(x + w, g)` with the step towards it, `-w` or `w`.
fn one_sided(map: &Value, variable: &Name, known: &Assumptions) -> Result<Option<(Value, Value)>, Unknown> {
    let mut breaks = Vec::new();
    if breaks_of(map, variable, known, &mut breaks).is_err() {
        return Ok(None);
    }
    let (zero, place) = (Value::zero(), Value::variable(variable));
    for last in &breaks {
        let goal = known.simplify(&map.with(variable, last)?);
        let step = known.simplify(&goal.sub(last)?);
        let up = known.decide(Relation::Gtr, &step, &zero) == Some(true);
        if !up && known.decide(Relation::Lss, &step, &zero) != Some(true) {
            continue;
        }
        let (far, near) = if up { (Relation::Lss, Relation::Gte) } else { (Relation::Gtr, Relation::Lte) };
        let is = |relation: Relation, wanted: &Value| {
            let mut here = known.without_name(variable);
            here.assume(relation, &place, last);
            here.decide(Relation::Eq, &here.simplify(map), wanted) == Some(true)
        };
        if is(far, &place.add(&step)?) && is(near, &goal) {
            return Ok(Some((goal, step)));
        }
    }
    Ok(None)
}

/// The goal and the longest steps up and down, if the map is this one: it is looked at where it must be affine.
fn goal_and_steps(map: &Value, variable: &Name, known: &Assumptions) -> Result<Option<(Value, [Value; 2])>, Unknown> {
    let mut breaks = Vec::new();
    if breaks_of(map, variable, known, &mut breaks).is_err() {
        return Ok(None);
    }
    let distance = Name::new("[distance]");
    let away = Value::variable(&distance);
    let all: BTreeSet<&Value> = breaks.iter().collect();
    let positive = |value: &Value| known.decide(Relation::Gtr, value, &Value::zero()) == Some(true);
    for low in &all {
        let goal = known.simplify(&map.with(variable, low)?);
        let upward = known.simplify(&goal.sub(low)?);
        if !positive(&upward) {
            continue;
        }
        let place = goal.sub(&away)?;
        let image = map.with(variable, &place)?;
        for high in &all {
            let downward = known.simplify(&high.sub(&goal)?);
            if !positive(&downward) {
                continue;
            }
            let is = |bounds: &[(Relation, &Value)], wanted: &Value| {
                let mut here = known.clone();
                bounds.iter().for_each(|(relation, bound)| here.assume(*relation, &away, bound));
                here.decide(Relation::Eq, &here.simplify(&image), wanted) == Some(true)
            };
            let back = downward.neg()?;
            if is(&[(Relation::Gtr, &upward)], &place.add(&upward)?)
                && is(&[(Relation::Lte, &upward), (Relation::Gte, &back)], &goal)
                && is(&[(Relation::Lss, &back)], &place.sub(&downward)?)
            {
                return Ok(Some((goal, [upward, downward])));
            }
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_arrives_after_the_distance_over_the_step() {
        let [x, n, g, w, p] = ["x", "n", "g", "w", "p"].map(Name::new);
        let [vx, vg, vw, vp] = [&x, &g, &w, &p].map(Value::variable);
        let mut known = Assumptions::default();
        known.assume(Relation::Gtr, &vw, &Value::zero());
        known.assume(Relation::Lss, &vp, &vg);
        let clamped = Value::clamp(&vg.sub(&vx).unwrap(), &vw.neg().unwrap(), &vw).unwrap();
        let map = vx.add(&clamped).unwrap();
        let motion = |map| Motion { map, variable: &x, start: &vp, index: &n, known: &known };
        let found = approach(&motion(&map)).unwrap().expect("this map");
        let steps = vg.sub(&vp).unwrap().div(&vw).unwrap().ceiling().unwrap();
        assert_eq!(found.pieces[1].from, steps);
        assert_eq!(found.pieces[1].form, vg);
        let other = vx.add(&clamped.mul(&Value::fraction(1, 2).unwrap()).unwrap()).unwrap();
        assert_eq!(approach(&motion(&other)), Ok(None));
    }
}
