//! Sequences that come round: a recurrence that does not depend on the index repeats as soon as its state does.

use std::collections::BTreeMap;

use crate::closed_form::{Form, Recurrence};
use crate::value::{Atom, Value};

/// The most steps that are made to find a state again.
const MOST_STEPS: usize = 300;
/// The most bits of a number in a state.
const MOST_BITS: u64 = 2_000;

/// The forms of a recurrence that begins at 0, if a state comes again soon: of two values in turn one form with `(-1)^n`
/// comes first, which not every map can be checked with.
pub(super) fn repeating(recurrence: &Recurrence) -> Option<Vec<Vec<Form>>> {
    if recurrence.sequences.iter().any(|sequence| sequence.next.mentions(&recurrence.index)) {
        return None;
    }
    let variables = recurrence.terms();
    let mut state: Vec<Value> = recurrence.sequences.iter().flat_map(|sequence| sequence.start.clone()).collect();
    let mut seen: BTreeMap<Vec<Value>, usize> = BTreeMap::new();
    for step in 0..MOST_STEPS {
        let root = |atom: &Atom| matches!(atom, Atom::Root(inner) if inner.as_rational().is_some());
        let short = |value: &Value| value.bits() < MOST_BITS / 2 && value.atoms().iter().all(root);
        if !state.iter().all(short) {
            return None;
        }
        if let Some(since) = seen.insert(state.clone(), step) {
            return forms(recurrence, since, step - since);
        }
        let images = variables.iter().map(|(name, ..)| name.clone()).zip(state.iter().cloned()).collect();
        let mut next = Vec::new();
        for (place, (_, own, offset)) in variables.iter().enumerate() {
            let sequence = &recurrence.sequences[*own];
            next.push(if offset + 1 < sequence.start.len() {
                state[place + 1].clone()
            } else {
                sequence.next.substitute(&images).ok()?
            });
        }
        state = next;
    }
    None
}

/// The forms of sequences that repeat from an index on, with this period.
fn forms(recurrence: &Recurrence, since: usize, period: usize) -> Option<Vec<Vec<Form>>> {
    let rounds = since.div_ceil(period);
    let terms = recurrence.iterate((rounds + 1) * period).ok()?;
    let variables = recurrence.terms();
    let by_a_term = |below: &Value| variables.iter().any(|(name, ..)| below.mentions(name));
    let divides = recurrence.sequences.iter().any(|one| one.next.denominator().as_ref().is_some_and(by_a_term));
    let form = |terms: &Vec<Value>, alternates: bool| {
        let turn = |turn: usize| {
            let early = (0..rounds).map(|round| terms[round * period + turn].clone()).collect();
            Form::Value(early, terms[rounds * period + turn].clone())
        };
        let turns = || Form::Turns((0..period).map(turn).collect());
        match period {
            1 => turn(0),
            2 if alternates => alternating(&terms[0], &terms[1], recurrence).unwrap_or_else(turns),
            _ => turns(),
        }
    };
    // Where the map divides by the two values, they must be named.
    let alternates = period == 2 && rounds == 0 && !divides;
    let all = |alternates: bool| terms.iter().map(|terms| form(terms, alternates)).collect();
    Some(if alternates { vec![all(true), all(false)] } else { vec![all(false)] })
}

/// `(a + b)/2 + (a - b)/2*(-1)^n`
fn alternating(one: &Value, other: &Value, recurrence: &Recurrence) -> Option<Form> {
    let half = Value::fraction(1, 2).ok()?;
    let sign = Atom::Power(Value::integer(-1), Value::variable(&recurrence.index)).value().ok()?;
    let middle = one.add(other).ok()?.mul(&half).ok()?;
    let swing = one.sub(other).ok()?.mul(&half).ok()?;
    Some(Form::Value(Vec::new(), middle.add(&swing.mul(&sign).ok()?).ok()?))
}
