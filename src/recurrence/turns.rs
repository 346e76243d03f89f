//! Coefficients that repeat: where an equation depends on `n` modulo M, M steps at once make a recurrence that does not.

use num_integer::Integer;
use num_rational::BigRational;
use num_traits::ToPrimitive;

use super::{Unknown, solve_until};
use crate::assumption::Assumptions;
use crate::closed_form::{Form, Recurrence, Sequence, Solved, in_class};
use crate::exponential_polynomial::ExponentialPolynomial;
use crate::name::Name;
use crate::value::{Atom, Relation, Value, ValueError};

/// The longest cycle.
const MOST_TURNS: i64 = 60;
/// The most turns of a sequence that others read.
const MOST_READ: i64 = 12;

/// After how many steps the equations are the same again; 1 if they always are.
pub(super) fn cycle(recurrence: &Recurrence) -> i64 {
    let index = &recurrence.index;
    let mut cycle = 1;
    let reads_index = |sequence: &&Sequence| sequence.next.mentions(index);
    for sequence in recurrence.sequences.iter().filter(reads_index) {
        for_each_floor(&sequence.next, index, &mut cycle);
        for (name, ..) in &recurrence.terms() {
            if let Some((factor, _)) = sequence.next.linear_in(name)
                && has_sign(&factor, index)
            {
                cycle = cycle.lcm(&2);
            }
        }
        if cycle > MOST_TURNS {
            return 1;
        }
    }
    cycle
}

/// The denominators under the index in integer parts.
fn for_each_floor(value: &Value, index: &Name, cycle: &mut i64) {
    for atom in value.atoms().into_iter().filter(|atom| atom.mentions(index)) {
        match &atom {
            Atom::Floor(inner) => {
                let factor = inner.linear_in(index).and_then(|(factor, _)| factor.as_rational());
                if let Some(denominator) = factor.and_then(|factor| factor.denom().to_i64()) {
                    *cycle = cycle.lcm(&denominator.min(MOST_TURNS + 1));
                }
                for_each_floor(inner, index, cycle);
            }
            Atom::Positive(inner) | Atom::Root(inner) => {
                if by_sign_alone(inner, index) {
                    *cycle = cycle.lcm(&2);
                }
                for_each_floor(inner, index, cycle);
            }
            Atom::Maximum(parts) | Atom::Apply(_, parts) => {
                if parts.iter().all(|part| by_sign_alone(part, index)) {
                    *cycle = cycle.lcm(&2);
                }
                parts.iter().for_each(|part| for_each_floor(part, index, cycle));
            }
            Atom::Power(base, exponent) => [base, exponent].iter().for_each(|part| for_each_floor(part, index, cycle)),
            Atom::Variable(_) => {}
        }
    }
}

/// The term so many places on of forms in turns as one value, for a sequence that reads it: that of each turn where the
/// index leaves its remainder.
pub(super) fn as_one(forms: &[Form], index: &Name, offset: usize) -> Result<Option<Value>, ValueError> {
    let count = i64::try_from(forms.len()).unwrap_or(i64::MAX);
    if count > MOST_READ {
        return Ok(None);
    }
    let offset = Value::rational(BigRational::from_integer(offset.into()));
    let (place, turns) = (Value::variable(index).add(&offset)?, Value::integer(count));
    let remainder = place.sub(&turns.mul(&place.div(&turns)?.floor()?)?)?;
    let mut whole: Option<Value> = None;
    for (turn, form) in (0..count).rev().zip(forms.iter().rev()) {
        let Form::Value(early, value) = form else { return Ok(None) };
        if !early.is_empty() {
            return Ok(None);
        }
        let own = value.with(index, &place.sub(&Value::integer(turn))?.div(&turns)?)?;
        whole = Some(match whole {
            None => own,
            Some(others) => Value::choose(Relation::Eq, &remainder, &Value::integer(turn), &own, &others)?,
        });
    }
    Ok(whole)
}

/// Whether a value depends on the index by `(-1)^n` alone.
fn by_sign_alone(value: &Value, index: &Name) -> bool {
    let sign = |atom: &Atom| matches!(atom, Atom::Power(base, _) if *base == Value::integer(-1));
    has_sign(value, index) && value.atoms().iter().all(|atom| !atom.mentions(index) || sign(atom))
}

fn has_sign(value: &Value, index: &Name) -> bool {
    value.atoms().iter().any(
        |atom| matches!(atom, Atom::Power(base, exponent) if *base == Value::integer(-1) && exponent.mentions(index)),
    )
}

/// The forms of a recurrence that begins at 0, in so many turns.
pub(super) fn in_turns(
    recurrence: &Recurrence,
    count: i64,
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Form>, Unknown> {
    let one = |turn: i64| -> Result<Vec<Value>, Unknown> {
        let all = recurrence.sequences.iter();
        all.map(|sequence| Ok(in_class(&sequence.next, &recurrence.index, count, turn)?)).collect()
    };
    let turns = (0..count).map(one).collect::<Result<Vec<_>, _>>()?;
    round(recurrence, &turns, known, stop)
}

/// The forms in turns of sequences that go through these equations one after the other, for ever: in each the index counts
/// rounds. The starting values are those of the recurrence.
pub(super) fn round(
    recurrence: &Recurrence,
    turns: &[Vec<Value>],
    known: &Assumptions,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Form>, Unknown> {
    let index = &recurrence.index;
    let variables = recurrence.terms();
    // The terms at each turn, in the terms at the first.
    let mut rows: Vec<Vec<Value>> = vec![variables.iter().map(|(name, ..)| Value::variable(name)).collect()];
    for equations in turns {
        let now = &rows[rows.len() - 1];
        let images = variables.iter().map(|(name, ..)| name.clone()).zip(now.iter().cloned()).collect();
        let mut next = Vec::new();
        for (at, (_, place, offset)) in variables.iter().enumerate() {
            let sequence = &recurrence.sequences[*place];
            next.push(if offset + 1 < sequence.start.len() {
                now[at + 1].clone()
            } else {
                equations[*place].substitute(&images)?
            });
        }
        rows.push(next);
    }
    let names: Vec<Name> = (0..variables.len()).map(|at| Name::new(&format!("[state {at}]"))).collect();
    let renamed = variables
        .iter()
        .map(|(name, ..)| name.clone())
        .zip(names.iter().map(|name| Value::variable(&crate::closed_form::term(name, index, 0))))
        .collect();
    let last = rows.pop().unwrap_or_default();
    let mut sequences = Vec::new();
    for (at, (name, next)) in names.iter().zip(last).enumerate() {
        let (_, place, offset) = &variables[at];
        let start = recurrence.sequences[*place].start[*offset].clone();
        sequences.push(Sequence { name: name.clone(), start: vec![start], next: next.substitute(&renamed)? });
    }
    let rounds = Recurrence { index: index.clone(), from: 0, sequences };
    // What is said of a state is said of the term that it is.
    let told = |Unknown { reason: mut text, .. }: Unknown| {
        for (own, (name, ..)) in names.iter().zip(&variables) {
            text = text.replace(&crate::closed_form::term(own, index, 0).to_string(), name.as_str());
        }
        Unknown::because(text)
    };
    let solved = solve_until(rounds, known, stop).map_err(told)?;
    forms(recurrence, &rows, &solved)
}

/// Each turn's form of each sequence, from those of the first turn.
fn forms(recurrence: &Recurrence, rows: &[Vec<Value>], solved: &Solved) -> Result<Vec<Form>, Unknown> {
    let variables = recurrence.terms();
    let mut early = 0;
    for form in solved.forms() {
        match form {
            Form::Value(first, _) | Form::Sum(first, _) => early = early.max(first.len()),
            _ => return Err(Unknown::because("the steps of one round have no simple closed form")),
        }
    }
    let turns = rows.len();
    let first = recurrence.iterate(early * turns + turns)?;
    let mut all = Vec::new();
    for (place, _) in recurrence.sequences.iter().enumerate() {
        let at = variables.iter().position(|(_, own, offset)| *own == place && *offset == 0);
        let mut forms = Vec::new();
        for (turn, row) in rows.iter().enumerate() {
            let value = at.map(|at| row[at].clone()).unwrap_or_else(Value::zero);
            let early: Vec<Value> = (0..early).map(|round| first[place][round * turns + turn].clone()).collect();
            forms.push(composed(&value, &variables, solved, &recurrence.index, early)?);
        }
        all.push(Form::Turns(forms));
    }
    Ok(all)
}

/// An expression in the terms at the first turn as a form.
fn composed(
    value: &Value,
    variables: &[(Name, usize, usize)],
    solved: &Solved,
    index: &Name,
    early: Vec<Value>,
) -> Result<Form, Unknown> {
    let sums = || -> Option<ExponentialPolynomial> {
        let mut sum = ExponentialPolynomial::zero();
        let mut rest = value.clone();
        for ((name, ..), form) in variables.iter().zip(solved.forms()) {
            if !rest.mentions(name) {
                continue;
            }
            let (factor, constant) = rest.linear_in(name)?;
            let own = match form {
                Form::Sum(_, own) => own.clone(),
                Form::Value(_, own) => ExponentialPolynomial::of(own, index)?,
                _ => return None,
            };
            factor.as_rational()?;
            sum = sum.plus(&own.scale(&factor).ok()?).ok()?;
            rest = constant;
        }
        sum.plus(&ExponentialPolynomial::of(&rest, index)?).ok()
    };
    if let Some(sum) = sums() {
        return Ok(Form::Sum(early, sum));
    }
    let mut images = std::collections::BTreeMap::new();
    for ((name, ..), form) in variables.iter().zip(solved.forms()) {
        let value = match form {
            Form::Value(_, value) => Some(value.clone()),
            Form::Sum(_, sum) => sum.value(index),
            _ => None,
        };
        let value = value.ok_or_else(|| Unknown::because("a sum over roots meets a symbol"))?;
        images.insert(name.clone(), value);
    }
    Ok(Form::Value(early, value.substitute(&images)?))
}

/// A form that is a sum over roots and cannot be written as a value, in turns, if the terms come round soon.
pub(super) fn turning(form: Form, single: &Recurrence) -> Form {
    let is_value = |sum: &ExponentialPolynomial| sum.value(&single.index).is_some();
    match &form {
        Form::Sum(early, sum) if early.is_empty() && !is_value(sum) => in_turn(single).unwrap_or(form),
        _ => form,
    }
}

/// The terms of one round, where the state after it is the first one again.
fn in_turn(single: &Recurrence) -> Option<Form> {
    let [sequence] = single.sequences.as_slice() else { return None };
    if sequence.next.mentions(&single.index) {
        return None;
    }
    let (order, most) = (sequence.start.len(), usize::try_from(MOST_READ).ok()?);
    let terms = single.iterate(order + most).ok()?.pop()?;
    let again = (1..=most).find(|count| terms.get(*count..*count + order) == terms.get(..order))?;
    Some(Form::Turns(terms.into_iter().take(again).map(|term| Form::Value(Vec::new(), term)).collect()))
}
