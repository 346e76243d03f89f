//! Steps modulo a number, `x(n+1) = mod(k*x(n)+w, m)` with a whole k: without the modulus the terms have a form X(n), and x(n)
//! is X(n) modulo m. So it is of an angle that is kept between two bounds, `mod(x(n)+w-b, m)+b`.

use std::collections::BTreeSet;

use super::sequences::solve_until;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Form, Recurrence, Sequence, term};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// The step `mod(inside, modulus) + shift` of a term: the inside is linear in it.
struct Step {
    inside: Value,
    modulus: Value,
    shift: Value,
}

impl Step {
    /// What stands under the only integer part of the term, times the modulus, is what the integer part is taken from; a
    /// whole number that was taken out of it adds multiples of the modulus, which change nothing.
    fn of(next: &Value, name: &Name) -> Option<Step> {
        let mark = Name::new("[whole part]");
        let mut parts = next.atoms().into_iter().filter(|atom| atom.mentions(name) && matches!(atom, Atom::Floor(_)));
        let (part, None) = (parts.next()?, parts.next()) else { return None };
        let Atom::Floor(inner) = &part else { return None };
        let (factor, rest) = next.with_atom(&part, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
        let modulus = factor.neg().ok()?;
        let inside = inner.mul(&modulus).ok()?;
        let shift = rest.sub(&inside).ok()?;
        let (slope, _) = inside.linear_in(name)?;
        let whole = slope.as_rational().is_some_and(|slope| slope.is_integer());
        (whole && !modulus.mentions(name) && !shift.mentions(name)).then_some(Step { inside, modulus, shift })
    }
}

/// Whether the terms are numbers that come round after a few steps: such ones are told one by one.
fn comes_round_soon(recurrence: &Recurrence) -> bool {
    let plain = recurrence.sequences.iter().all(|sequence| !sequence.next.mentions(&recurrence.index));
    let terms = recurrence.iterate(FEW + 1).unwrap_or_default();
    plain
        && terms.iter().any(|terms| {
            let numbers = terms.iter().all(|term| term.as_rational().is_some());
            numbers && terms.iter().collect::<BTreeSet<_>>().len() < terms.len()
        })
}

/// So few steps are told one by one.
const FEW: usize = 12;

/// The form of a sequence that begins at 0; none where its step is not of this kind or the terms without the modulus have no
/// form.
pub(super) fn modulo(
    recurrence: &Recurrence,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Option<(Form, Vec<Comparison>)> {
    let [sequence] = recurrence.sequences.as_slice() else { return None };
    let ([start], index) = (sequence.start.as_slice(), &recurrence.index) else { return None };
    let name = &recurrence.term(&sequence.name, 0);
    let plain = |step: &Step| !step.modulus.mentions(index) && !step.shift.mentions(index);
    let Step { inside, modulus, shift } = Step::of(&sequence.next, name).filter(plain)?;
    if comes_round_soon(recurrence) {
        return None;
    }
    let whole = Name::new("[without modulus]");
    let before = Value::variable(&term(&whole, index, 0)).add(&shift).ok()?;
    let (next, first) = (inside.with(name, &before).ok()?, start.sub(&shift).ok()?);
    let sequences = vec![Sequence { name: whole, start: vec![first], next }];
    let solved = solve_until(Recurrence { index: index.clone(), from: 0, sequences }, known, stop).ok()?;
    let sum = solved.forms().first()?.value(index)?;
    let turns = sum.div(&modulus).and_then(|turns| turns.floor()).ok()?;
    let form = sum.sub(&modulus.mul(&turns).ok()?).and_then(|rest| rest.add(&shift)).ok()?;
    let at_first = known.simplify(&form.with(index, &Value::zero()).ok()?);
    let early =
        if known.decide(Relation::Eq, &at_first, start) == Some(true) { Vec::new() } else { vec![start.clone()] };
    let mut conditions = solved.conditions().to_vec();
    if known.decide(Relation::Neq, &modulus, &Value::zero()) != Some(true) {
        conditions.push((Relation::Neq, modulus, Value::zero()));
    }
    Some((Form::Value(early, form), conditions))
}
