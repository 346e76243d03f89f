//! What is known of sequences without a form: fixed points, how they move, and the first terms.

use crate::closed_form::{Comparison, Recurrence, compared};
use crate::name::Name;
use crate::recurrence::{Behaviour, Stationary, Term, near};
use crate::value::Value;

/// What is known without a form, of the sequences that have none.
pub(super) fn without_form(
    recurrence: &Recurrence,
    behaviour: &Behaviour,
    open: impl Fn(&Name) -> bool,
) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(fixed_points(behaviour));
    lines.extend(behaviour.stationary.as_deref().map(|points| stationary(points, recurrence)));
    lines.extend(behaviour.motion.clone());
    let all = recurrence.sequences.iter().zip(&behaviour.terms);
    for (sequence, terms) in all.filter(|(sequence, _)| open(&sequence.name)) {
        let last = terms.last();
        let terms: Vec<String> = terms.iter().map(Term::text).collect();
        let more = match &behaviour.ended {
            Some((term, why)) => format!("; there is no {term}: {why}"),
            None if behaviour.stopped && last.is_some_and(Term::is_symbolic) => {
                ", …: with its symbols the next term is too long to be of use".to_string()
            }
            None => ", …".to_string(),
        };
        lines.push(format!("{} from {} on: {}{more}", sequence.name, recurrence.from, terms.join(", ")));
    }
    lines
}

/// What is mapped to itself.
fn fixed_points(behaviour: &Behaviour) -> Option<String> {
    let points: Vec<String> = behaviour.fixed_points.iter().map(Value::to_string).collect();
    let others = behaviour.other_fixed_points.as_deref();
    let places: Vec<String> = others.unwrap_or_default().iter().map(near).collect();
    let word = if points.len() + places.len() == 1 { "fixed point" } else { "fixed points" };
    let roots = |word: &str| {
        let which = if places.len() == 1 { "a root" } else { "roots" };
        format!("{word}{}, {which} of higher degree", places.join(" and "))
    };
    Some(match (others, points.is_empty(), places.is_empty()) {
        (Some(_), true, true) => "it has no fixed point".to_string(),
        (Some(_), false, true) => format!("{word} {}", points.join(" and ")),
        (Some(_), true, false) => roots(&format!("{word} ")),
        (Some(_), false, false) => roots(&format!("{word} {}, and ", points.join(" and "))),
        (None, true, _) => return None,
        (None, false, _) => format!("{word} {}, and perhaps others, roots of higher degree", points.join(" and ")),
    })
}

/// The points at which all sequences stay, with what each needs.
fn stationary(points: &[Stationary], recurrence: &Recurrence) -> String {
    let point = |stationary: &Stationary| {
        let values: Vec<String> = stationary.point.iter().map(Value::to_string).collect();
        if let [value] = values.as_slice() { value.clone() } else { format!("({})", values.join(",")) }
    };
    // Those with the same conditions together.
    let mut groups: Vec<(&[Comparison], Vec<String>)> = Vec::new();
    for one in points {
        match groups.iter_mut().find(|(conditions, _)| *conditions == one.conditions.as_slice()) {
            Some((_, points)) => points.push(point(one)),
            None => groups.push((&one.conditions, vec![point(one)])),
        }
    }
    let told: Vec<String> = groups
        .iter()
        .map(|(conditions, points)| {
            let needs: Vec<String> = conditions.iter().map(compared).collect();
            let needs = if needs.is_empty() { String::new() } else { format!(" if {}", needs.join(" and ")) };
            format!("{}{needs}", points.join(" and "))
        })
        .collect();
    let names: Vec<&str> = recurrence.sequences.iter().map(|one| one.name.as_str()).collect();
    let of = if let [_, _, ..] = names.as_slice() { format!("({}) = ", names.join(",")) } else { String::new() };
    match points {
        [] => "it has no fixed point".to_string(),
        [_] => format!("fixed point {of}{}", told.join(", and ")),
        _ => format!("fixed points {of}{}", told.join(", and ")),
    }
}
