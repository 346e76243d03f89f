//! What is added under a condition of another sequence, as how often a pump was switched on: where both go by one of two steps, by
//! the same condition, the one is read off the other, `c(n) = c(0)+b*n+(a-b)*(d(n)-d(0)-q*n)/(p-q)`.

use super::Unknown;
use super::exact::of_difference;
use super::sequences::{Found, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Sequence, Solved};
use crate::name::Name;
use crate::value::{Atom, Relation, Value};

/// One of two steps: what is always added, and what is added where the condition holds besides.
struct Steps {
    always: Value,
    besides: Value,
    when: Atom,
}

/// The forms of all sequences, where one of them that no other reads goes by the condition of another one.
pub(super) fn counted(
    recurrence: &Recurrence,
    (known, stop): (&Assumptions, &dyn Fn() -> bool),
    checked: &dyn Fn(Found) -> Result<Solved, Unknown>,
) -> Option<Solved> {
    if recurrence.sequences.len() < 2 || recurrence.sequences.iter().any(|sequence| sequence.start.len() != 1) {
        return None;
    }
    let steps: Vec<Option<Steps>> =
        recurrence.sequences.iter().map(|sequence| steps_of(recurrence, sequence)).collect();
    for (place, own) in steps.iter().enumerate() {
        let name = recurrence.term(&recurrence.sequences[place].name, 0);
        let read = |(other, sequence): (usize, &Sequence)| other != place && sequence.next.mentions(&name);
        let Some(own) = own.as_ref().filter(|_| !recurrence.sequences.iter().enumerate().any(read)) else { continue };
        let same = |other: &Option<Steps>| {
            let other = other.as_ref()?;
            let moves = known.decide(Relation::Neq, &other.besides, &Value::zero()) == Some(true);
            (moves && other.when == own.when).then_some(())
        };
        let found = (0..steps.len()).filter(|other| *other != place).find(|other| same(&steps[*other]).is_some());
        let Some(other) = found else { continue };
        let rest: Vec<usize> = (0..steps.len()).filter(|other| *other != place).collect();
        let sequences = rest.iter().map(|other| recurrence.sequences[*other].clone()).collect();
        let solved = solve_until(Recurrence { sequences, ..recurrence.clone() }, known, stop).ok()?;
        let by = rest.iter().position(|one| *one == other)?;
        let form = read_off(recurrence, &solved, (place, own), (other, by, steps[other].as_ref()?), known)?;
        let mut forms = solved.forms().to_vec();
        forms.insert(place, form);
        if let Ok(solved) = checked((forms, solved.conditions().to_vec())) {
            return Some(solved);
        }
    }
    None
}

fn steps_of(recurrence: &Recurrence, sequence: &Sequence) -> Option<Steps> {
    let terms: Vec<Name> = recurrence.terms().into_iter().map(|(name, ..)| name).collect();
    let own = recurrence.term(&sequence.name, 0);
    let mut conditions = sequence.next.atoms().into_iter().filter(|atom| matches!(atom, Atom::Positive(_)));
    let (when, None) = (conditions.next()?, conditions.next()) else { return None };
    let mark = Name::new("[when]");
    let (besides, rest) = sequence.next.with_atom(&when, &Value::variable(&mark)).ok()?.linear_in(&mark)?;
    let always = rest.sub(&Value::variable(&own)).ok()?;
    let varies = |value: &Value| {
        value.mentions(&recurrence.index) || value.mentions(&mark) || terms.iter().any(|name| value.mentions(name))
    };
    (!varies(&always) && !varies(&besides)).then_some(Steps { always, besides, when })
}

/// The form of a sequence by that of another one, which stands at this place of those that are solved.
fn read_off(
    recurrence: &Recurrence,
    solved: &Solved,
    (place, own): (usize, &Steps),
    (other, by, steps): (usize, usize, &Steps),
    known: &Assumptions,
) -> Option<Form> {
    let index = Value::variable(&recurrence.index);
    let start = |place: usize| recurrence.sequences[place].start.first();
    let name = solved.recurrence().term(&recurrence.sequences[other].name, 0);
    let gone = Value::variable(&name).sub(start(other)?).ok()?.sub(&steps.always.mul(&index).ok()?).ok()?;
    let often = gone.div(&steps.besides).ok()?;
    let added = own.always.mul(&index).ok()?.add(&own.besides.mul(&often).ok()?).ok()?;
    let value = start(place)?.add(&added).ok()?;
    let pieces = of_difference(solved, &value, &[(name, by)], known)?;
    Some(match pieces.as_slice() {
        [only] => Form::Value(Vec::new(), known.simplify(&only.form)),
        _ => Form::Pieces(pieces),
    })
}
