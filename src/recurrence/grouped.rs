//! Parameters that stand nowhere but in their product, as a speed and the time of a step do: the recurrence is solved with
//! one parameter for the product, and the product is put in.

use crate::assumption::Assumptions;
use crate::closed_form::{Recurrence, Sequence, Solved};
use crate::name::Name;
use crate::value::{Relation, Value};

/// The most parameters of which pairs are tried.
const MOST_PARAMETERS: usize = 6;

/// The forms with a product of two parameters as one, where there are such; `solve` finds the forms of what is left.
pub(super) fn grouped(
    recurrence: &Recurrence,
    known: &Assumptions,
    solve: &dyn Fn(Recurrence, &Assumptions) -> Option<Solved>,
) -> Option<Solved> {
    let terms = recurrence.terms();
    let free = |name: &Name| *name != recurrence.index && terms.iter().all(|(term, ..)| term != name);
    let values = || recurrence.sequences.iter().flat_map(|one| one.start.iter().chain([&one.next]));
    let mut names: Vec<Name> = values().flat_map(Value::variables).filter(free).collect();
    names.sort();
    names.dedup();
    if names.len() > MOST_PARAMETERS {
        return None;
    }
    let pairs = names.iter().enumerate().flat_map(|(place, one)| names[..place].iter().map(move |other| (other, one)));
    pairs.filter_map(|(one, other)| as_one(recurrence, known, one, other)).find_map(|grouped| {
        let solved = solve(grouped.recurrence, &grouped.known)?;
        let found = solved.instance(&grouped.name, &grouped.product, known).ok()?;
        (found.recurrence() == recurrence).then_some(found)
    })
}

/// A recurrence in which one parameter stands for a product.
struct Grouped {
    recurrence: Recurrence,
    known: Assumptions,
    name: Name,
    product: Value,
}

/// The recurrence with `one` for the product of two parameters, if neither of them stands alone.
fn as_one(recurrence: &Recurrence, known: &Assumptions, one: &Name, other: &Name) -> Option<Grouped> {
    let (zero, divisor) = (Value::zero(), Value::variable(other));
    if known.decide(Relation::Neq, &divisor, &zero) != Some(true) {
        return None;
    }
    let name = Name::new(&format!("[{one}*{other}]"));
    let quotient = Value::variable(&name).div(&divisor).ok()?;
    let put = |value: &Value| {
        let put = known.simplify(&value.with(one, &quotient).ok()?);
        (!put.mentions(other)).then_some(put)
    };
    let sequences = recurrence.sequences.iter().map(|sequence| {
        let start = sequence.start.iter().map(put).collect::<Option<Vec<_>>>()?;
        Some(Sequence { name: sequence.name.clone(), start, next: put(&sequence.next)? })
    });
    let sequences = sequences.collect::<Option<Vec<_>>>()?;
    let product = Value::variable(one).mul(&divisor).ok()?;
    let mut own = known.without_name(one).without_name(other);
    for relation in [Relation::Gtr, Relation::Gte, Relation::Lss, Relation::Lte] {
        if known.decide(relation, &product, &zero) == Some(true) {
            own.assume(relation, &Value::variable(&name), &zero);
        }
    }
    // What is known of the product as a whole.
    for (relation, fact) in known.iter().filter(|(_, fact)| fact.mentions(one)) {
        if let Some(fact) = put(&fact) {
            own.assume(relation, &fact, &zero);
        }
    }
    let recurrence = Recurrence { index: recurrence.index.clone(), from: recurrence.from, sequences };
    Some(Grouped { recurrence, known: own, name, product })
}
