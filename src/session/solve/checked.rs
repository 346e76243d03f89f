//! How it was checked, apart from the search, that an index is the first, or that there is none.

use super::super::orders::all_there;
use super::Asked;
use crate::assumption::Assumptions;
use crate::closed_form::{Comparison, Earlier, Never, Recurrence, Solved, Unchecked, first, never};
use crate::name::Name;
use crate::recurrence::{Reach, bounds};
use crate::value::{Relation, Value};

/// How it is told that nothing was checked.
const ON_TRUST: &str = "rests on the search alone";

/// How it was checked that no index before the one found is the first, or that there is none.
pub(in crate::session) fn no_earlier(
    found: &Reach,
    (recurrence, solved): (&Recurrence, Option<&Solved>),
    goal: (Relation, &Value, &Value),
    known: &Assumptions,
) -> Option<String> {
    let index = &recurrence.index;
    let (at, conditions) = match found {
        Reach::At(at, conditions) => (at, conditions),
        Reach::Never(_) => {
            let checked = never(recurrence, solved, goal, (known, &[])).or_else(|why| {
                let bounds = bounds(recurrence, known, &|| false);
                if bounds.is_empty() { Err(why) } else { never(recurrence, solved, goal, (known, &bounds)) }
            });
            return Some(never_checked(checked, (index, recurrence.from)));
        }
        Reach::Unknown(_) => return None,
    };
    Some(match first(recurrence, solved, goal, (at, conditions), known) {
        Ok(Earlier::None) => return None,
        Ok(Earlier::OneByOne) => format!("checked term by term: there, and at no earlier {index}"),
        Ok(Earlier::Forms) => format!("checked by the forms: there, and at no earlier {index}"),
        Ok(Earlier::OneWay) => {
            format!(
                "checked by the forms: there, not at the {index} before, and until then the difference moves one way only"
            )
        }
        Err(_) => format!("that there is no earlier {index} {ON_TRUST}"),
    })
}

/// The same of what was asked; where several are to hold together it is enough that one of them does at no earlier index.
pub(in crate::session) fn no_earlier_of(found: &Reach, asked: &Asked<'_>, known: &Assumptions) -> Option<String> {
    let (question, solved) = (asked.question, asked.forms);
    let recurrence = solved.recurrence();
    let told = no_earlier(found, (recurrence, Some(solved)), asked.goal, known);
    let (Reach::At(at, conditions), Some(text)) = (found, &told) else { return told };
    let alone = |(place, (relation, left, right)): (usize, &Comparison)| {
        first(recurrence, Some(solved), (*relation, left, right), (at, conditions), known).is_ok()
            && all_there(question, solved, place, at)
    };
    if text.ends_with(ON_TRUST) && question.together.iter().enumerate().any(alone) {
        return Some(format!("checked by the forms: there, and at no earlier {}", recurrence.index));
    }
    told
}

/// How it was checked that there is no such index.
fn never_checked(checked: Result<Never, Unchecked>, (index, first): (&Name, i64)) -> String {
    let modulo;
    let (from, how) = match checked {
        Ok(Never::Always) => return format!("checked: at no {index}, whatever the terms are"),
        Ok(Never::ComesAgain) => return format!("checked term by term: at no {index} until the terms come again"),
        Ok(Never::Ends) => return "checked term by term: at none of the terms that there are".to_string(),
        Ok(Never::Forms(from)) => (from, "by the forms"),
        Ok(Never::Induction(from, _)) => (from, "by induction from one term to the next"),
        Ok(Never::Modulo(from, modulus)) => {
            modulo = format!("modulo {modulus}");
            (from, modulo.as_str())
        }
        Err(_) => return format!("that there is no such {index} rests on the search alone"),
    };
    if from == first {
        format!("checked {how}: at no {index}")
    } else {
        format!("checked term by term before {index} = {from}, and {how} from there on: at no {index}")
    }
}
